//! `bodyschema study generate`: bodies that nobody designed, from seeds.

use std::path::PathBuf;

use serde_json::json;

use crate::cli::{Outcome, output};
use crate::study::generated::GeneratedBody;

/// Generate a random body from a seed, as an MJCF file.
///
/// Bodies are chains, snakes, stars, humanoids, walkers, robot arms, hands and random trees, with limbs from 1 cm to 10
/// m, hinges, slides and balls, straight and skewed axes, and shapes of five kinds. Whether they can be learned plays
/// no part in the draw. The same seed gives the same file on every machine. `bodyschema study bodies` learns them.
#[derive(clap::Args)]
#[command(after_help = "Examples:
  bodyschema study generate --seed 7 --out body-7.xml
  bodyschema study generate --seed 1 --count 20 --out bodies")]
pub struct GenerateArguments {
    /// Seed of the body, or of the first of several
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Number of bodies, with consecutive seeds, written to a folder as body-SEED.xml
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=1_000_000), requires = "out")]
    count: Option<u32>,
    /// File to write or, with --count, the folder [default: standard output]
    #[arg(long, short, value_name = "PATH", help_heading = "Output")]
    out: Option<PathBuf>,
    /// Print the bodies' properties as JSON, one object per line
    #[arg(long, requires = "out", help_heading = "Output")]
    json: bool,
}

pub fn run(args: &GenerateArguments) -> Outcome {
    let Some(out) = &args.out else {
        output::line(format_args!("{}", GeneratedBody::new(args.seed).mjcf.trim_end_matches('\n')));
        return Ok(());
    };
    let last = args.seed.checked_add(u64::from(args.count.unwrap_or(1)) - 1);
    let last = last.ok_or("the last body's seed would be too large: give a smaller --seed")?;
    for seed in args.seed..=last {
        let body = GeneratedBody::new(seed);
        let path = args.count.map_or(out.clone(), |_| out.join(format!("{}.xml", body.name())));
        output::file(&path, &body.mjcf)?;
        if args.json {
            output::line(format_args!("{}", json!({ "file": path, "seed": body.seed, "drawn": body.drawn })));
        } else {
            tell!("{}: {}", path.display(), body.drawn.in_words());
        }
    }
    Ok(())
}
