//! `bodyschema skin`: grow receptors on a model.

use std::path::PathBuf;

use super::{Outcome, output};
use crate::skin::{GrowOptions, grow_skin};

/// Grow a skin of touch receptors on a model.
///
/// Every exposed surface is tiled with flat receptors, written into a copy of the model as sites with touch
/// sensors; hinges and slides get joint sensors. A tuple `limb/NAME` in the model names the bodies of a
/// limb, and the `prm` of each body there is the area of its receptors in cm².
#[derive(clap::Args)]
#[command(after_help = "Examples:
  bodyschema skin mjcf/max/body.xml --output mjcf/max/max.xml
  bodyschema skin spider.xml --area 4 --output spider_with_skin.xml")]
pub struct Args {
    /// The MJCF file of a creature without touch sensors
    model: PathBuf,
    /// Where to write the model with its skin; standard output if left out
    #[arg(short, long)]
    output: Option<PathBuf>,
    /// Area of a receptor in cm² where the model does not say
    #[arg(long, value_name = "CM2", default_value_t = 60.0, value_parser = area)]
    area: f64,
}

fn area(text: &str) -> Result<f64, String> {
    let area: f64 = text.parse().map_err(|_| "give a number of cm²".to_string())?;
    if (0.01..=1e4).contains(&area) { Ok(area) } else { Err("give an area from 0.01 to 10000 cm²".into()) }
}

pub fn run(args: &Args) -> Outcome {
    let grown = grow_skin(&args.model, &GrowOptions { area: args.area * 1e-4 })?;
    match &args.output {
        None => output::line(format_args!("{}", grown.trim_end_matches('\n'))),
        Some(path) => {
            std::fs::write(path, &grown).map_err(|error| {
                format!("cannot write {}: {error}: give another --output", path.display())
            })?;
            let receptors = grown.matches("class=\"receptor\" name=").count();
            eprintln!("{receptors} receptors written to {}", path.display());
        }
    }
    Ok(())
}
