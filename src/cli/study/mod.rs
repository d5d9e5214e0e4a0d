//! `bodyschema study`: one measurement repeated over several seeds.

mod bodies;
mod hersch;

use std::path::{Path, PathBuf};
use std::time::Instant;

use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};
use serde_json::{Value, json};

use super::arguments::{positive, touch_count};
use super::folders::free_folder;
use super::open::{ModelArguments, embodied};
use super::progress::Bars;
use super::{Failure, Outcome, output};
use crate::babbling::{self, PolicyName};
use crate::creature::JointSelection;
use crate::experiment::study::bodies::{STUDY as BODIES, WAYS};
use crate::experiment::study::calibration::{CalibrationCase, STUDY as CALIBRATION};
use crate::experiment::study::claims::{POLICIES as CLAIMS_POLICIES, STUDY as CLAIMS};
use crate::experiment::study::hersch::{STUDY as HERSCH, TOUCHES as HERSCH_TOUCHES};
use crate::experiment::study::{FoundTables, STUDIES, Study, Subject};
use crate::experiment::{Observer, Phase};
use crate::record::{Generation, PROGRAM, model_hash};
use crate::view::study_chart;

/// The model that is studied where none is named.
const DEFAULT_MODEL: &str = "mjcf/max/max.xml";
/// Touches of a trial where none are asked for.
const TOUCHES: usize = 1000;
/// What was asked and what came out, in the study's folder.
const STUDY_FILE: &str = "study.json";
/// The measurements, in the study's folder.
const TABLE_FILE: &str = "study.csv";
/// The plot, in the study's folder.
const PLOT_FILE: &str = "study.svg";

/// Repeat a measurement over several seeds: a table, its data and a plot.
///
/// Trial by trial the creature babbles with a seed of its own, learns under every condition of the study from
/// the same touches, and is measured against the model. Everything goes into a folder: study.json with all
/// options, seeds and numbers, study.csv with a row per measurement, study.svg.
#[derive(clap::Args)]
#[command(after_help = "Examples:
  bodyschema study learners --trials 5                                # takes minutes
  bodyschema study disturbances creature.xml --touches 500 --seed 7 --json  # takes minutes
  bodyschema study bodies --trials 20 --seed 20001                    # takes minutes")]
pub struct StudyArguments {
    /// The study
    #[arg(value_parser = study())]
    name: &'static Study,
    /// The MJCF or URDF file of a creature; several of studies that are of several
    #[arg(default_value = DEFAULT_MODEL)]
    model: Vec<PathBuf>,
    #[command(flatten)]
    open: ModelArguments,
    /// Trials, each with touches and initial guesses of its own
    #[arg(long, default_value_t = 3, value_parser = clap::value_parser!(u16).range(1..=1000))]
    trials: u16,
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
    cases: Vec<CalibrationCase>,
    /// Seconds that a way to learn may compute with a body, its touches included [default: 50]
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
fn case() -> impl TypedValueParser<Value = CalibrationCase> {
    let names = CalibrationCase::ALL.iter().map(|case| case.name());
    PossibleValuesParser::new(names).try_map(|name| name.parse::<CalibrationCase>())
}

/// A way to learn of the study `bodies`.
fn way() -> impl TypedValueParser<Value = &'static str> {
    PossibleValuesParser::new(WAYS)
        .try_map(|name| WAYS.into_iter().find(|way| *way == name).ok_or("there is no such way"))
}

pub fn run(args: &StudyArguments) -> Outcome {
    let study = args.name;
    let [model, others @ ..] = args.model.as_slice() else {
        return Err("no model is named: name the file of a creature".into());
    };
    if !others.is_empty() && !study.several {
        return Err(Failure(format!("study {} is of one creature: name one model", study.name)));
    }
    if args.touches.is_some() && !study.touches {
        return Err(Failure(format!(
            "study {} does not learn from babbled touches: leave out --touches, its trials are counted by --trials",
            study.name
        )));
    }
    if args.policy.is_some() && study.name != CLAIMS.name {
        return Err(Failure(format!("study {} is not of one policy: leave out --policy", study.name)));
    }
    if !args.cases.is_empty() && study.name != CALIBRATION.name {
        return Err(Failure(format!("study {} has no cases: leave out --case", study.name)));
    }
    if args.seconds.is_some() && study.name != BODIES.name {
        return Err(Failure(format!(
            "study {} takes the time that it needs: leave out --seconds",
            study.name
        )));
    }
    let rule = args.hersch.options(study)?;
    let last = args.seed.checked_add(u64::from(args.trials) - 1);
    let last = last.ok_or("the last trial's seed would be too great: give a smaller --seed")?;
    let seeds: Vec<u64> = (args.seed..=last).collect();
    if study.name == BODIES.name {
        return bodies::run(args, &seeds);
    }
    if !model.exists() && model == Path::new(DEFAULT_MODEL) {
        return Err(Failure(format!(
            "{DEFAULT_MODEL}: there is no such file here: name a model, as in `bodyschema study {} MODEL`, or go \
             to the folder that holds mjcf",
            study.name
        )));
    }
    let touches = args.touches.unwrap_or(if study.name == HERSCH.name { HERSCH_TOUCHES } else { TOUCHES });
    let selection = args.joints.clone().unwrap_or_default();
    let bars = Bars::default();
    let read = |model: &PathBuf| embodied(args.open.source(model, selection.clone()));
    let mut subject = Subject::new(read(model)?, touches, seeds, babbling::threads(args.jobs), &bars)?
        .with_others(others.iter().map(read).collect::<Result<_, Failure>>()?);
    subject.session.clone_from(&args.session);
    subject.hersch = rule;
    subject.policy = args.policy;
    subject.cases.clone_from(&args.cases);
    let numbered = |k: u32| match k {
        1 => Path::new("studies").join(study.name),
        _ => Path::new("studies").join(format!("{}-{k}", study.name)),
    };
    let lock = free_folder(args.out.as_deref(), "study", &[STUDY_FILE], numbered)?;
    let folder = lock.folder();
    let began = Instant::now();
    let findings = (study.measure)(&subject)?;
    let seconds = began.elapsed().as_secs_f64();
    bars.phase(Phase::Done);
    let creature = &subject.body().creature;
    let mut result = json!({
        "study": study.name,
        "about": study.about,
        "program": PROGRAM,
        "engine": subject.body().model.version().to_string(),
        "creature": creature.name(),
        "joints": creature.joints().len(),
        "dof": creature.dof(),
        "options": {
            "model": model,
            "model_hash": model_hash(model)?,
            "other_models": others,
            "touches": study.touches.then_some(touches),
            "trials": args.trials,
            "seed": args.seed,
            "joints": selection.to_string(),
            "session": args.session,
            "policy": args.policy.map(|policy| policy.to_string()),
            "cases": args.cases.iter().map(|case| case.name()).collect::<Vec<_>>(),
        },
        "seeds": subject.seeds,
        "seconds": seconds,
        "summary": findings.summary.to_json(),
        "notes": findings.notes,
        "rows": findings.measurements.to_json(),
        "folder": folder,
    });
    findings.numbers.iter().for_each(|(name, number)| result[*name] = number.clone());
    let generation = Generation::begin(&lock)?;
    save(generation.folder(), study, &result, &findings)?;
    generation.commit()?;
    if args.json {
        return output::json(&result);
    }
    let seeds: Vec<String> = subject.seeds.iter().map(u64::to_string).collect();
    say!("study {}: {}", study.name, study.about);
    say!(
        "{}: {} joints, {} degrees of freedom ({}, --joints {selection})",
        creature.name(),
        creature.joints().len(),
        creature.dof(),
        model.display()
    );
    others.iter().for_each(|other| say!("and {}", other.display()));
    let trials = if args.trials == 1 { "trial" } else { "trials" };
    let of = if study.touches { format!(" of {touches} touches") } else { String::new() };
    say!("{} {trials}{of}, seeds {}\n", args.trials, seeds.join(" "));
    told(&findings, folder, seconds);
    Ok(())
}

/// Prints what was found, and where it is.
fn told(findings: &FoundTables, folder: &Path, seconds: f64) {
    findings.summary.lines().iter().for_each(|line| say!("{line}"));
    say!("");
    findings.notes.iter().for_each(|note| say!("{note}"));
    say!("\n{seconds:.0} s; {TABLE_FILE}, {PLOT_FILE} and {STUDY_FILE} are in {}", folder.display());
}

fn save(folder: &Path, study: &Study, result: &Value, findings: &FoundTables) -> Outcome {
    output::file(&folder.join(STUDY_FILE), &format!("{}\n", serde_json::to_string_pretty(result)?))?;
    output::file(&folder.join(TABLE_FILE), &findings.measurements.to_csv()?)?;
    let title = format!("{}: {}", study.name, study.about);
    output::file(&folder.join(PLOT_FILE), &study_chart(&findings.plot, &title).alone())
}
