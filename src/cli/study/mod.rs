//! `bodyschema study`: one measurement repeated over several seeds.

mod gallery;
mod generate;
mod merge;

use std::fs;
use std::path::{Path, PathBuf};

use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};
use serde_json::json;

use super::folders::{Force, first_free, new_folder};
use super::open::{MAX, ModelArguments, embodied, is_there};
use super::{Failure, Outcome, output, progress};
use crate::creature::JointSelection;
use crate::error::Error;
use crate::named::plural;
use crate::session::{FolderLock, SHARES_FOLDER, STUDY_FILE};
use crate::study::{
    Findings, STUDIES, Share, Studied, Study, StudyOptions, StudyRun, StudyShare, share_folder,
};
use crate::view::table::Table;

/// The measurements, in the study's folder.
const TABLE_FILE: &str = "study.csv";
/// All that a study leaves in its folder.
const FILES: [&str; 2] = [STUDY_FILE, TABLE_FILE];
/// Where trials are until all are made, in the study's folder.
const TRIALS_FOLDER: &str = ".trials";

/// Repeat a measurement over several seeds and write a table, its data and a summary.
///
/// Each trial has its own seed and compares every case of the study with the model. Trials run on all cores. The
/// results go into a folder: study.json with all options, seeds and numbers, study.csv with one row per measurement.
/// The same command resumes an interrupted study.
#[derive(clap::Args)]
#[command(
    args_conflicts_with_subcommands = true,
    subcommand_negates_reqs = true,
    after_help = "Examples:
  bodyschema study learners --trials 5                                # takes minutes
  bodyschema study disturbances creature.xml --touches 500 --seed 7 --json  # takes minutes
  bodyschema study bodies --trials 20 --seed 20001                    # takes minutes
  bodyschema study learners --trials 1000 --shard 3/16 --out studies/many    # takes hours"
)]
pub struct StudyArguments {
    #[command(subcommand)]
    command: Option<StudyCommand>,
    #[command(flatten)]
    study: RunArguments,
}

#[derive(clap::Subcommand)]
enum StudyCommand {
    Generate(generate::GenerateArguments),
    Gallery(gallery::GalleryArguments),
    Merge(merge::MergeArguments),
}

#[derive(clap::Args)]
struct RunArguments {
    /// The study
    #[arg(value_parser = study(), required = true)]
    name: Option<&'static Study>,
    /// The MJCF or URDF file of a creature
    #[arg(default_value = MAX)]
    model: PathBuf,
    #[command(flatten)]
    open: ModelArguments,
    #[command(flatten)]
    options: StudyOptions,
    /// The joints that move: a joint set named in the model (torso), all, or names separated by commas [default: torso
    /// if the model names it, else all]
    #[arg(long)]
    joints: Option<JointSelection>,
    /// Number of threads; affects only the running time [default: one per core]
    #[arg(long, value_parser = clap::value_parser!(u16).range(1..=1024))]
    jobs: Option<u16>,
    /// The study's folder [default: studies/NAME, or the first free of studies/NAME-2, -3, …]
    #[arg(long, short, value_name = "DIR", help_heading = "Output")]
    out: Option<PathBuf>,
    #[command(flatten)]
    force: Force,
    /// Make only this share of the trials, such as 3/16. Other processes, on this machine or others, make the rest, and
    /// `bodyschema study merge DIR` merges all shares into what a single process would have written. The same command
    /// resumes an interrupted share
    #[arg(long, value_name = "SHARE", requires = "out", conflicts_with = "force", help_heading = "Output")]
    shard: Option<Share>,
    /// Print one JSON object
    #[arg(long, help_heading = "Output")]
    json: bool,
}

/// A study by its name, which shells complete.
fn study() -> impl TypedValueParser<Value = &'static Study> {
    let choices = STUDIES.iter().map(|study| PossibleValue::new(study.name).help(study.about));
    PossibleValuesParser::new(choices).try_map(|name| Study::of_name(&name).ok_or("unknown study"))
}

pub fn run(args: &StudyArguments) -> Outcome {
    match (&args.command, args.study.name) {
        (Some(StudyCommand::Generate(args)), _) => generate::run(args),
        (Some(StudyCommand::Gallery(args)), _) => gallery::run(args),
        (Some(StudyCommand::Merge(args)), _) => merge::run(args),
        (None, Some(study)) => match args.study.jobs.map(usize::from) {
            None => args.study.run(study),
            Some(jobs) => {
                rayon::ThreadPoolBuilder::new().num_threads(jobs).build()?.install(|| args.study.run(study))
            }
        },
        (None, None) => Err("give a study; `bodyschema study --help` lists them".into()),
    }
}

impl RunArguments {
    fn run(&self, study: &'static Study) -> Outcome {
        let run = self.prepared(study)?;
        let number = self.shard.unwrap_or(Share::WHOLE);
        let (command, asked) = (output::command_line(), run.asked().clone());
        let share = StudyShare { share: number.to_string(), command, asked };
        if let (Some(_), Some(folder)) = (self.shard, &self.out) {
            return self.make_share(&run, &share, number, folder);
        }
        let lock = self.folder(&share)?;
        let trials = lock.place().join(TRIALS_FOLDER);
        make(&run, &share, &trials)?;
        save(&Findings::of_shares(&[(trials.clone(), share)])?, &lock, self.json)?;
        Ok(fs::remove_dir_all(&trials).map_err(Error::unwritable(&trials))?)
    }

    /// The study made ready.
    fn prepared(&self, study: &'static Study) -> Result<StudyRun, Failure> {
        let creature = if study.of == Studied::Generated {
            let given = [
                (self.model != Path::new(MAX), "the model"),
                (self.joints.is_some(), "--joints"),
                (self.open.root.is_some(), "--root"),
            ];
            if let Some((_, what)) = given.into_iter().find(|(given, _)| *given) {
                let name = study.name;
                return Err(Failure(format!(
                    "study {name} generates its subjects from seeds: leave out {what}"
                )));
            }
            None
        } else {
            is_there(&self.model, &format!("study {}", study.name))?;
            Some(embodied(self.open.source(&self.model, self.joints.clone().unwrap_or_default()))?)
        };
        Ok(StudyRun::new(study, self.options.clone(), creature)?)
    }

    /// The folder of a study that is made whole: the one named, else the first that is free, or holds the beginning of this
    /// very study.
    fn folder(&self, share: &StudyShare) -> Result<FolderLock, Failure> {
        let numbered = |k: u32| match k {
            1 => Path::new("studies").join(&share.asked.study),
            _ => Path::new("studies").join(format!("{}-{k}", share.asked.study)),
        };
        let is_begun = |folder: &PathBuf| {
            let begun = StudyShare::read(&folder.join(TRIALS_FOLDER));
            !folder.join(STUDY_FILE).exists() && begun.is_ok_and(|begun| begun.asked == share.asked)
        };
        let begun = || (1..).map(numbered).take_while(|folder| folder.exists()).find(is_begun);
        let lock = match self.out.clone().or_else(begun) {
            Some(out) => new_folder(&out, self.force, "study", &FILES)?,
            None => first_free(numbered, &FILES)?,
        };
        let trials = lock.place().join(TRIALS_FOLDER);
        if StudyShare::is_in(&trials) && !is_begun(&lock.place().to_path_buf()) && self.force.force {
            fs::remove_dir_all(&trials).map_err(Error::unwritable(&trials))?;
        }
        Ok(lock)
    }

    /// Makes the trials of a share that are missing.
    fn make_share(&self, run: &StudyRun, made: &StudyShare, share: Share, folder: &Path) -> Outcome {
        if folder.join(STUDY_FILE).exists() && !folder.join(SHARES_FOLDER).exists() {
            let what = format_args!("contains unsharded work ({STUDY_FILE}): give another folder with --out");
            return Err(Failure(format!("{} {what}", folder.display())));
        }
        let lock = FolderLock::make(&share_folder(folder, share))?;
        let place = lock.folder();
        make(run, made, place)?;
        let count = made.seeds().len();
        if self.json {
            return output::json(&json!({"share": share.to_string(), "trials": count, "folder": place}));
        }
        say!("share {share}: {}, in {}", plural(count, "trial"), place.display());
        say!("once all {} shares are made: `bodyschema study merge {}`", share.of, folder.display());
        Ok(())
    }
}

/// Makes the trials of a share that are missing in its folder.
fn make(run: &StudyRun, share: &StudyShare, folder: &Path) -> Outcome {
    let (all, missing) = (share.seeds().len(), share.missing(folder).len());
    if missing == 0 {
        tell!("{} is complete: nothing left to do", folder.display());
    } else if missing < all {
        tell!("{}: {} of {all} trials are present; resuming", folder.display(), all - missing);
    }
    let bar = progress::steps(all as u64);
    bar.set_position((all - missing) as u64);
    bar.set_message(format!("trials of {}", run.asked().study));
    share.make(run, folder, || bar.inc(1))?;
    bar.finish_and_clear();
    Ok(())
}

/// Writes findings into a folder, all at once, and prints them.
fn save(findings: &Findings, lock: &FolderLock, as_json: bool) -> Outcome {
    let place = lock.place().to_path_buf();
    let result = findings.to_json(&place);
    let folder = lock.part()?;
    output::file(&folder.join(STUDY_FILE), format!("{}\n", serde_json::to_string_pretty(&result)?))?;
    output::file(&folder.join(TABLE_FILE), Table::exact_of_study(&findings.table()).csv())?;
    lock.commit()?;
    if as_json {
        return output::json(&result);
    }
    findings.heading().iter().for_each(|line| say!("{line}"));
    say!("");
    output::table(&Table::of_study(&findings.summary()));
    say!("");
    findings.notes().iter().for_each(|line| say!("{line}"));
    say!("{TABLE_FILE} and {STUDY_FILE} were written to {}", place.display());
    Ok(())
}
