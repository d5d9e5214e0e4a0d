//! `bodyschema study`: one measurement repeated over several seeds.
//!
//! To add a study, write a file beside this one with a `pub const STUDY: Study`, and name it in [`STUDIES`].
//! Its `measure` takes a [`Subject`], which babbles, learns and evaluates for it, and gives [`Findings`]: all
//! measurements as one tidy table, a summary of them, and what to plot. Options, printing, JSON and the
//! files are the same for all studies and are done here.

mod approach;
mod at_table;
mod avoid;
mod changed_body;
mod coverage;
mod disturbances;
mod farthest;
mod frames;
mod growth;
mod learners;
mod map;
mod other_hand;
mod plot;
mod policies;
mod reachable;
mod self_touch;
mod sensations;
mod subject;
mod table;
mod turned;

use std::path::{Path, PathBuf};
use std::time::Instant;

use serde_json::{Value, json};

use super::touches::{threads, touch_count};
use super::{Failure, Outcome, output};
use crate::creature::JointSelection;
use crate::record::{PROGRAM, model_hash};
use plot::Plot;
use subject::Subject;
use table::Table;

/// The studies, in the order in which they are named to the user.
const STUDIES: [&Study; 15] = [
    &learners::STUDY,
    &policies::STUDY,
    &coverage::STUDY,
    &disturbances::STUDY,
    &growth::STUDY,
    &turned::STUDY,
    &frames::STUDY,
    &sensations::STUDY,
    &approach::STUDY,
    &self_touch::STUDY,
    &map::STUDY,
    &other_hand::STUDY,
    &farthest::STUDY,
    &avoid::STUDY,
    &reachable::STUDY,
];

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

/// A question that is answered by measuring over several seeds.
pub struct Study {
    /// The name on the command line.
    pub name: &'static str,
    /// The question in a line.
    pub about: &'static str,
    /// Whether it learns from babbled touches, so many a trial.
    pub touches: bool,
    /// Measures. A trial that does not succeed is a finding; only what cannot be measured fails.
    pub measure: fn(&Subject) -> Result<Findings, Failure>,
}

/// What a study found.
pub struct Findings {
    /// All measurements, a row each: one kind of thing per column, so that it can be plotted as it is.
    pub measurements: Table,
    /// A row per condition over all trials: the table that a person reads.
    pub summary: Table,
    /// How to read the summary, in sentences.
    pub notes: Vec<String>,
    /// The plot.
    pub plot: Plot,
    /// What a program asks for by name, beside the summary.
    pub numbers: Vec<(&'static str, Value)>,
}

/// Repeat a measurement over several seeds: a table, its data and a plot.
///
/// Trial by trial the creature babbles with a seed of its own, learns under every condition of the study from
/// the same touches, and is measured against the model. Everything goes into a folder: study.json with all
/// options, seeds and numbers, study.csv with a row per measurement, study.svg.
#[derive(clap::Args)]
#[command(after_help = studies_help())]
pub struct Args {
    /// The study, by its name below
    #[arg(value_parser = study)]
    name: &'static Study,
    /// The MJCF file of a creature with touch sensors
    #[arg(default_value = DEFAULT_MODEL)]
    model: PathBuf,
    /// Trials, each with touches and onsets of its own
    #[arg(long, default_value_t = 3, value_parser = clap::value_parser!(u16).range(1..=1000))]
    trials: u16,
    /// Seed of the first trial; the next ones count on from it
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Touches of a trial, of studies that babble them [default: 1000]
    #[arg(long, value_parser = touch_count)]
    touches: Option<usize>,
    /// The joints that move: a set that the model names (torso), all, or names separated by commas
    /// [default: torso where the model names it, else all]
    #[arg(long)]
    joints: Option<JointSelection>,
    /// The session whose schema a study of action uses [default: it babbles and learns one, by the first seed]
    #[arg(long, value_name = "SESSION")]
    schema: Option<PathBuf>,
    /// Threads that babble; they change nothing but the time [default: one per core]
    #[arg(long, value_parser = clap::value_parser!(u16).range(1..=1024))]
    jobs: Option<u16>,
    /// The study's folder [default: studies/NAME, or the first free of studies/NAME-2, -3, …]
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Print one JSON object
    #[arg(long)]
    json: bool,
}

fn study(name: &str) -> Result<&'static Study, String> {
    STUDIES.into_iter().find(|study| study.name == name).ok_or_else(|| {
        let names: Vec<&str> = STUDIES.iter().map(|study| study.name).collect();
        format!("there is no such study: choose one of {}", names.join(", "))
    })
}

fn studies_help() -> String {
    let studies: Vec<String> =
        STUDIES.iter().map(|study| format!("  {:<14}{}", study.name, study.about)).collect();
    format!(
        "Studies:\n{}\n\nExamples:\n  bodyschema study learners --trials 5                                # takes minutes\n  \
         bodyschema study disturbances creature.xml --touches 500 --seed 7 --json  # takes minutes",
        studies.join("\n")
    )
}

pub fn run(args: &Args) -> Outcome {
    let study = args.name;
    if !args.model.exists() && args.model == Path::new(DEFAULT_MODEL) {
        return Err(Failure(format!(
            "{DEFAULT_MODEL}: there is no such file here: name a model, as in `bodyschema study {} MODEL`, or go \
             to the folder that holds mjcf",
            study.name
        )));
    }
    if args.touches.is_some() && !study.touches {
        return Err(Failure(format!(
            "study {} does not learn from babbled touches: leave out --touches, its trials are counted by --trials",
            study.name
        )));
    }
    let touches = args.touches.unwrap_or(TOUCHES);
    let selection = args.joints.clone().unwrap_or_default();
    let last = args.seed.checked_add(u64::from(args.trials) - 1);
    let last = last.ok_or("the last trial's seed would be too great: give a smaller --seed")?;
    let seeds: Vec<u64> = (args.seed..=last).collect();
    let mut subject = Subject::new(&args.model, &selection, touches, seeds, threads(args.jobs))?;
    subject.schema.clone_from(&args.schema);
    let folder = study_folder(args.out.as_deref(), study.name)?;
    let began = Instant::now();
    let findings = (study.measure)(&subject)?;
    let seconds = began.elapsed().as_secs_f64();
    subject.done();
    let creature = &subject.body.creature;
    let mut result = json!({
        "study": study.name,
        "about": study.about,
        "program": PROGRAM,
        "engine": subject.body.model.version().to_string(),
        "creature": creature.name(),
        "joints": creature.joints().len(),
        "dof": creature.dof(),
        "options": {
            "model": args.model,
            "model_hash": model_hash(&args.model)?,
            "touches": study.touches.then_some(touches),
            "trials": args.trials,
            "seed": args.seed,
            "joints": selection.to_string(),
            "schema": args.schema,
        },
        "seeds": subject.seeds,
        "seconds": seconds,
        "summary": findings.summary.to_json(),
        "notes": findings.notes,
        "rows": findings.measurements.to_json(),
        "folder": folder,
    });
    findings.numbers.iter().for_each(|(name, number)| result[*name] = number.clone());
    save(&folder, study, &result, &findings)?;
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
        args.model.display()
    );
    let trials = if args.trials == 1 { "trial" } else { "trials" };
    let of = if study.touches { format!(" of {touches} touches") } else { String::new() };
    say!("{} {trials}{of}, seeds {}\n", args.trials, seeds.join(" "));
    findings.summary.print();
    say!("");
    findings.notes.iter().for_each(|note| say!("{note}"));
    say!("\n{seconds:.0} s; {TABLE_FILE}, {PLOT_FILE} and {STUDY_FILE} are in {}", folder.display());
    Ok(())
}

fn save(folder: &Path, study: &Study, result: &Value, findings: &Findings) -> Outcome {
    output::file(&folder.join(STUDY_FILE), &format!("{}\n", serde_json::to_string_pretty(result)?))?;
    output::file(&folder.join(TABLE_FILE), &findings.measurements.to_csv())?;
    let title = format!("{}: {}", study.name, study.about);
    let svg = findings.plot.svg(&title).map_err(|error| {
        Failure(format!("{}: it cannot be drawn: {error}", folder.join(PLOT_FILE).display()))
    })?;
    output::file(&folder.join(PLOT_FILE), &svg)
}

/// The folder to write to: never one that holds a study already.
fn study_folder(out: Option<&Path>, name: &str) -> Result<PathBuf, Failure> {
    let folder = match out {
        Some(folder) if folder.join(STUDY_FILE).exists() => {
            return Err(Failure(format!(
                "{} holds a study already: give another folder with --out, or remove it",
                folder.display()
            )));
        }
        Some(folder) => folder.to_path_buf(),
        None => {
            let numbered = |k: u32| match k {
                1 => Path::new("studies").join(name),
                _ => Path::new("studies").join(format!("{name}-{k}")),
            };
            (1..).map(numbered).find(|folder| !folder.exists()).expect("some number is free")
        }
    };
    output::make_folder(&folder)?;
    Ok(folder)
}
