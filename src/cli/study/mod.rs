//! `bodyschema study`: one measurement repeated over several seeds.

mod asked;
mod bodies;
mod conclusion;
mod hersch;
pub mod shares;

use std::path::{Path, PathBuf};

use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};

use super::arguments::{Arguments, positive, touch_count};
use super::folders::{Force, free_folder};
use super::open::{MAX, ModelArguments};
use super::progress::Bars;
use super::{Failure, Outcome};
use crate::babbling::PolicyName;
use crate::calibration::made::Fault;
use crate::creature::JointSelection;
use crate::experiment::study::bodies::WAYS;
use crate::experiment::study::claims::POLICIES as CLAIMS_POLICIES;
use crate::experiment::study::{STUDIES, Study};
use crate::experiment::{Observer, Phase};
use crate::share::Share;

use asked::AskedStudy;

/// Touches of a trial where none are asked for.
const TOUCHES: usize = 1000;

/// Repeat a measurement over several seeds: a table, its data and a plot.
///
/// Trial by trial the creature babbles with a seed of its own, learns under every condition of the study from
/// the same touches, and is measured against the model. Everything goes into a folder: study.json with all
/// options, seeds and numbers, study.csv with a row per measurement, study.svg.
#[derive(clap::Args)]
#[command(after_help = "Examples:
  bodyschema study learners --trials 5                                # takes minutes
  bodyschema study disturbances creature.xml --touches 500 --seed 7 --json  # takes minutes
  bodyschema study bodies --trials 20 --seed 20001                    # takes minutes
  bodyschema study learners --trials 1000 --shard 3/16 --out studies/many    # takes hours")]
pub struct StudyArguments {
    /// The study
    #[arg(value_parser = study())]
    name: &'static Study,
    /// The MJCF or URDF file of a creature; several of studies that are of several
    #[arg(default_value = MAX)]
    model: Vec<PathBuf>,
    #[command(flatten)]
    open: ModelArguments,
    /// Trials, each with touches and initial guesses of its own
    #[arg(long, default_value_t = 3, value_parser = clap::value_parser!(u32).range(1..=1_000_000))]
    trials: u32,
    /// Seed of the first trial; the next ones count on from it
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Touches of a trial, of studies that babble them [default: 1000; of hersch 20000]
    #[arg(long, value_parser = touch_count)]
    touches: Option<usize>,
    /// The joints that move: a set that the model names (torso), all, or names separated by commas
    /// [default: torso where the model names it, else all]
    #[arg(long)]
    joints: Option<JointSelection>,
    /// The session whose schema a study of action uses [default: it babbles and learns one, by the first seed]
    #[arg(long, value_name = "SESSION")]
    session: Option<PathBuf>,
    /// Threads that babble; they change nothing but the time [default: one per core]
    #[arg(long, value_parser = clap::value_parser!(u16).range(1..=1024))]
    jobs: Option<u16>,
    /// The study's folder [default: studies/NAME, or the first free of studies/NAME-2, -3, …]
    #[arg(long, short, value_name = "DIR", help_heading = "Output")]
    out: Option<PathBuf>,
    #[command(flatten)]
    force: Force,
    /// Make only this share of the trials, as in 3/16: other processes, here or elsewhere, make the others, and `bodyschema
    /// merge DIR` makes of all what one process would have made. The same command goes on with a share that was interrupted
    #[arg(long, value_name = "SHARE", requires = "out", conflicts_with = "force", help_heading = "Output")]
    shard: Option<Share>,
    /// Print one JSON object
    #[arg(long, help_heading = "Output")]
    json: bool,
    /// Only sessions that this policy babbled: random or stages
    #[arg(long, value_name = "POLICY", value_parser = policy, help_heading = "Of the study claims")]
    policy: Option<PolicyName>,
    /// Only these of its cases, separated by commas
    #[arg(
        long = "case",
        value_name = "CASES",
        value_delimiter = ',',
        value_parser = case(),
        help_heading = "Of the study calibration"
    )]
    cases: Vec<Fault>,
    /// Work that a way to learn may take with a body, its touches included: about what one core does in so many seconds
    /// [default: 50]
    #[arg(long, value_parser = positive, help_heading = "Of the study bodies")]
    seconds: Option<f64>,
    /// Only these of its ways to learn, separated by commas
    #[arg(
        long = "way",
        value_name = "WAYS",
        value_delimiter = ',',
        value_parser = way(),
        help_heading = "Of the study bodies"
    )]
    ways: Vec<&'static str>,
    #[command(flatten)]
    hersch: hersch::HerschArguments,
}

impl StudyArguments {
    /// The seeds of the trials, one after the other.
    fn seeds(&self) -> Result<Vec<u64>, Failure> {
        let last = self.seed.checked_add(u64::from(self.trials) - 1);
        let last = last.ok_or("the last trial's seed would be too great: give a smaller --seed")?;
        Ok((self.seed..=last).collect())
    }
}

/// A study by its name, which shells complete.
fn study() -> impl TypedValueParser<Value = &'static Study> {
    let choices = STUDIES.iter().map(|study| PossibleValue::new(study.name).help(study.about));
    PossibleValuesParser::new(choices).try_map(|name| {
        STUDIES.iter().copied().find(|study| study.name == name).ok_or("there is no such study")
    })
}

/// A policy that the study `claims` knows.
fn policy(name: &str) -> Result<PolicyName, String> {
    let found = CLAIMS_POLICIES.into_iter().find(|policy| policy.to_string() == name);
    found.ok_or_else(|| "give one of random and stages".to_string())
}

/// A case of the study `calibration`.
fn case() -> impl TypedValueParser<Value = Fault> {
    let names = Fault::ALL.iter().map(|case| case.name());
    PossibleValuesParser::new(names).try_map(|name| name.parse::<Fault>())
}

/// A way to learn of the study `bodies`.
fn way() -> impl TypedValueParser<Value = &'static str> {
    PossibleValuesParser::new(WAYS)
        .try_map(|name| WAYS.into_iter().find(|way| *way == name).ok_or("there is no such way"))
}

pub fn run(args: &StudyArguments, given: Arguments) -> Outcome {
    let bars = Bars::default();
    let asked = AskedStudy::new(args, &bars)?;
    if let (Some(share), Some(folder)) = (args.shard, &args.out) {
        return shares::make(&asked, share, folder, given, &bars);
    }
    let study = args.name;
    let numbered = |k: u32| match k {
        1 => Path::new("studies").join(study.name),
        _ => Path::new("studies").join(format!("{}-{k}", study.name)),
    };
    let lock = free_folder(args.out.as_deref(), args.force, "study", &conclusion::FILES, numbered)?;
    let mut left = Vec::new();
    asked.run(&asked.seeds, &mut |_, trial| {
        left.push(trial);
        Ok(())
    })?;
    bars.phase(Phase::Done);
    let (findings, seconds) = asked.conclude(&left)?;
    conclusion::save_and_print(&asked, &lock, &findings, seconds)
}
