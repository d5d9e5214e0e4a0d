//! `bodyschema skin`: grow receptors on a model, touch them, and learn which are neighbours.

mod feel;
mod map;

use std::path::{Path, PathBuf};

use super::open::{ModelArguments, rehearse};
use super::{Outcome, output, progress};
use crate::given_number::positive;
use crate::skin::{GrowOptions, PatchSize, grow_skin_rooted};

/// Grow a skin of touch receptors on a model.
///
/// Every touchable surface without touch sensors is tiled with flat receptors, written into a copy of the model as
/// sites with touch sensors; hinges and slides get joint sensors, and unnamed bodies and joints get names. A tuple
/// `limb/NAME` in the model names the bodies of a limb, and the `prm` of each body there is the area of its receptors
/// in cm². If neither the model nor an option gives the size of receptors, about 250 cover the creature, whatever its size.
#[derive(clap::Args)]
#[command(
    args_conflicts_with_subcommands = true,
    subcommand_negates_reqs = true,
    after_help = "Examples:
  bodyschema skin mjcf/max/body.xml --out max_with_skin.xml
  bodyschema skin mjcf/hexapod/hexapod.xml --receptors 400 --denser left_front_tibia=3 --out hexapod_with_skin.xml
  bodyschema skin robot.xml --spacing 0.02 --out robot_with_skin.xml
  bodyschema skin feel mjcf/max/max.xml                      # what it feels when it is touched"
)]
pub struct SkinArguments {
    #[command(subcommand)]
    command: Option<SkinCommand>,
    /// The MJCF or URDF file of a creature
    #[arg(required = true)]
    model: Option<PathBuf>,
    #[command(flatten)]
    open: ModelArguments,
    /// File for the model with its skin [default: standard output]
    #[arg(long, short, value_name = "FILE", help_heading = "Output")]
    out: Option<PathBuf>,
    /// Number of receptors; surfaces that need more to be covered get more
    #[arg(long, value_name = "N", group = "size", value_parser = clap::value_parser!(u32).range(1..=20_000))]
    receptors: Option<u32>,
    /// Side of a receptor, metres; overrides the model
    #[arg(long, value_name = "M", group = "size", value_parser = positive)]
    spacing: Option<f64>,
    /// Relative receptor density of a limb, by its tuple's or body's name; repeatable
    #[arg(long, value_name = "LIMB=FACTOR", value_parser = denser)]
    denser: Vec<(String, f64)>,
}

#[derive(clap::Subcommand)]
enum SkinCommand {
    Feel(feel::FeelArguments),
    Map(map::MapArguments),
}

fn denser(text: &str) -> Result<(String, f64), String> {
    let (limb, factor) = text.rsplit_once('=').ok_or("give LIMB=FACTOR, as in left_hand=4")?;
    Ok((limb.to_string(), positive(factor)?))
}

pub fn run(args: &SkinArguments) -> Outcome {
    match (&args.command, &args.model) {
        (Some(SkinCommand::Feel(args)), _) => feel::run(args),
        (Some(SkinCommand::Map(args)), _) => map::run(args),
        (None, Some(model)) => grow(args, model),
        (None, None) => Ok(()),
    }
}

/// Grows a skin on a model.
fn grow(args: &SkinArguments, model: &Path) -> Outcome {
    let size = match (args.receptors, args.spacing) {
        (Some(count), _) => PatchSize::Count(count as usize),
        (None, Some(side)) => PatchSize::Spacing(side),
        (None, None) => PatchSize::OfCreature,
    };
    let options = GrowOptions { size, denser: args.denser.clone() };
    rehearse(model)?;
    let spinner = progress::spinner("growing a skin");
    let grown = grow_skin_rooted(model, args.open.root.as_deref(), &options)?;
    spinner.finish_and_clear();
    match &args.out {
        None => output::line(format_args!("{}", grown.text(None).trim_end_matches('\n'))),
        Some(path) => {
            output::file(path, grown.text(path.parent()))?;
            let kept = match grown.kept {
                0 => String::new(),
                kept => format!(", {kept} touch sensors kept"),
            };
            let (receptors, auras) = (grown.receptors, grown.auras);
            tell!("{receptors} receptors and {auras} auras written to {}{kept}", path.display());
        }
    }
    Ok(())
}
