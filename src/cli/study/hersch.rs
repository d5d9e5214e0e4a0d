//! The options that only the study `hersch` has.

use crate::cli::Failure;
use crate::experiment::study::Study;
use crate::experiment::study::hersch::{HerschOptions, STUDY};
use crate::learning::STEP;

/// How the study `hersch` applies the rule.
#[derive(clap::Args)]
#[command(next_help_heading = "Of the study hersch")]
pub struct HerschArguments {
    /// Passes over the touches [default: 20]
    #[arg(long, value_parser = clap::value_parser!(u16).range(1..))]
    passes: Option<u16>,
    /// The small positive scalar ε of the paper's equations [default: 0.05]
    #[arg(long, value_name = "EPSILON", value_parser = step)]
    step: Option<f64>,
    /// Learning ends at the first touch that misses by no more, as in the paper's algorithm, millimetres [default: 0]
    #[arg(long, value_name = "MM", value_parser = miss)]
    stop: Option<f64>,
    /// Has rows, too, in which every touch is used in one direction alone
    #[arg(long)]
    single: bool,
}

impl HerschArguments {
    /// The options; refused where the study is another one.
    pub fn options(&self, study: &Study) -> Result<HerschOptions, Failure> {
        let HerschArguments { passes, step, stop, single } = *self;
        let given = passes.is_some() || step.is_some() || stop.is_some() || single;
        if given && study.name != STUDY.name {
            return Err(Failure(format!(
                "study {} does not apply Hersch's rule by itself: leave out --passes, --step, --stop and --single, or \
                 ask for study hersch",
                study.name
            )));
        }
        let by_default = HerschOptions::default();
        Ok(HerschOptions {
            passes: passes.map_or(by_default.passes, usize::from),
            step: step.unwrap_or(STEP),
            stop_mm: stop.unwrap_or(by_default.stop_mm),
            single,
        })
    }
}

fn step(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(step) if step.is_finite() && step > 0.0 => Ok(step),
        _ => Err("give a number above 0".into()),
    }
}

fn miss(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(miss) if miss.is_finite() && miss >= 0.0 => Ok(miss),
        _ => Err("give a number of 0 or above".into()),
    }
}
