//! Running the trials of a study and summarizing them.

use std::path::{Path, PathBuf};
use std::time::Instant;

use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use serde_json::{Value, json};
use sha2::{Digest, Sha256};

use super::{Row, Studied, Study, Subject, Table};
use crate::deadline::apart;
use crate::error::Error;
use crate::mujoco;
use crate::named::plural;
use crate::session::{Embodied, PROGRAM, SCHEMA_FILE, files, model_hash};

/// Trials of a study at most.
pub const MOST_TRIALS: u64 = 1_000_000;
/// Touches from which a creature that acts learns its body if no session is named and no number is asked for.
const LEARNED_FROM: usize = 1000;

/// What a study can be asked for.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "cli", derive(clap::Args))]
pub struct StudyOptions {
    /// Number of trials, each with its own touches and initial guesses
    #[cfg_attr(feature = "cli", arg(long, default_value_t = 3, value_parser = clap::value_parser!(u64).range(1..=MOST_TRIALS)))]
    pub trials: u64,
    /// Seed of the first trial; the others follow consecutively
    #[cfg_attr(feature = "cli", arg(long, default_value_t = 1))]
    pub seed: u64,
    /// Only this case: its name, or a part of several names; repeatable
    #[cfg_attr(feature = "cli", arg(long = "case", visible_alias = "way", value_name = "CASE"))]
    pub cases: Vec<String>,
    /// Touches per trial, for studies that babble; for acting, those that the body is learned from [default: 1000;
    /// 20000 for hersch]
    #[cfg_attr(feature = "cli", arg(long, value_parser = clap::builder::RangedU64ValueParser::<usize>::new().range(1..)))]
    pub touches: Option<usize>,
    /// For the study bodies: work per case, touches included, in units of about one second on one core [default: 50]
    #[cfg_attr(feature = "cli", arg(long))]
    pub seconds: Option<f64>,
    /// For the study acting: the session with the learned body [default: babble and learn with the first seed]
    #[cfg_attr(feature = "cli", arg(long, value_name = "SESSION"))]
    pub session: Option<PathBuf>,
}

/// All that decides what comes out of a study: two processes that were asked the same come to the same.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Asked {
    /// The study's name.
    pub study: String,
    /// This program and its version.
    pub program: String,
    /// The engine's version.
    pub engine: String,
    /// The options in effect, with the full names of all cases.
    pub options: StudyOptions,
    /// Who is studied, unless the seeds make it.
    pub creature: Option<AskedCreature>,
}

/// A creature that is studied.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct AskedCreature {
    name: String,
    joints: usize,
    dof: usize,
    model: PathBuf,
    model_hash: String,
    /// Which of its joints move, as on the command line.
    moving: String,
    root: Option<String>,
    /// The schema of the session in which it has learned its body.
    schema_hash: Option<String>,
}

/// A study that is ready to be made.
pub struct StudyRun {
    study: &'static Study,
    asked: Asked,
    subject: Option<Subject>,
}

/// A trial: a seed, and what is asked of it.
pub struct Trial<'a> {
    /// The seed of all its random numbers.
    pub seed: u64,
    /// The names of its cases.
    pub cases: &'a [String],
    /// Touches, if the study babbles.
    pub touches: usize,
    /// Work of a case, in seconds of one core, if it is limited.
    pub seconds: f64,
    subject: Option<&'a Subject>,
}

/// What a trial leaves.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(super) struct TrialRecord {
    /// How long it took, seconds.
    pub seconds: f64,
    pub rows: Vec<Row>,
}

/// What all trials come to.
pub struct Findings {
    study: &'static Study,
    asked: Asked,
    seconds: f64,
    rows: Vec<Row>,
}

impl Trial<'_> {
    /// Who is studied.
    ///
    /// # Errors
    /// If the seeds make it.
    pub fn subject(&self) -> Result<&Subject, Error> {
        self.subject.ok_or_else(|| Error::usage("this study takes no creature"))
    }

    /// Whether a case is asked for.
    pub fn asks(&self, case: &str) -> bool {
        self.cases.iter().any(|asked| asked == case)
    }
}

impl Asked {
    /// The seeds of its trials.
    pub fn seeds(&self) -> std::ops::Range<u64> {
        self.options.seed..self.options.seed.saturating_add(self.options.trials)
    }

    fn study(&self) -> Result<&'static Study, Error> {
        Study::of_name(&self.study).ok_or_else(|| {
            Error::usage(format!(
                "this version has no study {}: finish it with the version that began it",
                self.study
            ))
        })
    }

    /// Who is studied and how often, in lines.
    fn heading(&self) -> Vec<String> {
        const MOST: u64 = 20;
        let StudyOptions { trials, touches, session, .. } = &self.options;
        let seeds = self.seeds();
        let seeds = match *trials {
            few if few <= MOST => seeds.map(|seed| seed.to_string()).collect::<Vec<_>>().join(" "),
            _ => format!("{} to {}", seeds.start, seeds.end - 1),
        };
        let touches = touches.map(|touches| format!(" of {touches} touches")).unwrap_or_default();
        let creature = self.creature.as_ref().map(|creature| {
            let AskedCreature { name, joints, dof, model, moving, .. } = creature;
            let learned = session.as_ref().map(|session| format!(", as learned in {}", session.display()));
            format!(
                "{name}: {joints} joints, {dof} degrees of freedom ({}, --joints {moving}){}",
                model.display(),
                learned.unwrap_or_default()
            )
        });
        creature
            .into_iter()
            .chain([format!("{}{touches}, seeds {seeds}", plural(*trials as usize, "trial"))])
            .collect()
    }
}

impl StudyRun {
    /// Makes a study ready: of a creature, unless the seeds make who is studied.
    ///
    /// # Errors
    /// If an option is not for this study or a case is none of its own; if the creature cannot babble, or has not learned its
    /// body.
    pub fn new(
        study: &'static Study,
        options: StudyOptions,
        creature: Option<Embodied>,
    ) -> Result<StudyRun, Error> {
        let acts = study.of == Studied::Acting;
        let babbles = study.touches.is_some() || acts && options.session.is_none();
        let unused = [
            ("--touches (use --trials)", options.touches.is_some() && !babbles),
            ("--seconds", options.seconds.is_some() && study.seconds.is_none()),
            ("--session", options.session.is_some() && !acts),
        ];
        if let Some((option, _)) = unused.into_iter().find(|(_, unused)| *unused) {
            let why = format!("study {} does not use {option}: leave it out", study.name);
            return Err(Error::usage(why));
        }
        if options.seconds.is_some_and(|seconds| seconds.is_nan() || seconds <= 0.0) {
            return Err(Error::usage("--seconds: give a number above 0"));
        }
        if options.seed.checked_add(options.trials).is_none() {
            return Err(Error::usage("the last trial's seed would be too large: give a smaller --seed"));
        }
        let learned_from = (acts && options.session.is_none()).then_some(LEARNED_FROM);
        let options = StudyOptions {
            cases: chosen(study, &options.cases)?,
            touches: options.touches.or(study.touches).or(learned_from),
            seconds: options.seconds.or(study.seconds),
            ..options
        };
        let asked_creature =
            creature.as_ref().map(|creature| asked_creature(creature, &options)).transpose()?;
        let mut subject = creature.map(Subject::new).transpose()?;
        if acts {
            let (session, touches) = (options.session.as_deref(), options.touches.unwrap_or_default());
            let learned = |subject: Subject| subject.with_learned_body(session, touches, options.seed);
            subject = subject.map(learned).transpose()?;
        }
        let asked = Asked {
            study: study.name.into(),
            program: PROGRAM.into(),
            engine: mujoco::check()?.to_string(),
            options,
            creature: asked_creature,
        };
        Ok(StudyRun { study, asked, subject })
    }

    /// What it was asked.
    pub fn asked(&self) -> &Asked {
        &self.asked
    }

    /// Makes the trial of a seed.
    pub(super) fn trial(&self, seed: u64) -> Result<TrialRecord, Error> {
        let StudyOptions { cases, touches, seconds, .. } = &self.asked.options;
        let trial = Trial {
            seed,
            cases,
            touches: touches.unwrap_or_default(),
            seconds: seconds.unwrap_or(f64::INFINITY),
            subject: self.subject.as_ref(),
        };
        let began = Instant::now();
        // Each counts its own work, though a thread may begin another one while it waits.
        let mut rows = apart(|| (self.study.run)(&trial)).0?;
        rows.iter_mut().for_each(|row| row["seed"] = json!(seed));
        Ok(TrialRecord { seconds: began.elapsed().as_secs_f64(), rows })
    }

    /// Makes the trials of the seeds that `begins` says yes to, which is asked before each; on all threads and in memory.
    ///
    /// # Errors
    /// If something cannot be measured at all.
    pub fn findings(&self, begins: impl Fn(u64) -> bool + Sync) -> Result<Findings, Error> {
        let seeds = self.asked.seeds().into_par_iter().filter(|seed| begins(*seed));
        let trials = seeds.map(|seed| self.trial(seed));
        Findings::of(self.asked.clone(), trials.collect::<Result<Vec<_>, _>>()?)
    }
}

impl Findings {
    /// What trials come to, in the order of their seeds.
    pub(super) fn of(asked: Asked, trials: Vec<TrialRecord>) -> Result<Findings, Error> {
        let study = asked.study()?;
        let seconds = trials.iter().map(|trial| trial.seconds).sum();
        Ok(Findings {
            study,
            asked,
            seconds,
            rows: trials.into_iter().flat_map(|trial| trial.rows).collect(),
        })
    }

    /// All measurements.
    pub fn table(&self) -> Table {
        Table::of(self.study.columns, &self.rows)
    }

    /// A row per case.
    pub fn summary(&self) -> Table {
        Table::summary(self.study.columns, &self.rows)
    }

    /// All of it, and the folder that it goes to, as JSON.
    pub fn to_json(&self, folder: &Path) -> Value {
        let mut all = json!(self.asked);
        all["about"] = json!(self.study.about);
        all["seeds"] = json!(self.asked.seeds().collect::<Vec<u64>>());
        all["seconds"] = json!(self.seconds);
        all["summary"] = self.summary().to_json();
        all["notes"] = json!(self.study.notes);
        all["rows"] = self.table().to_json();
        all["folder"] = json!(folder);
        all
    }

    /// The question, who was studied and how often, in lines.
    pub fn heading(&self) -> Vec<String> {
        let question = format!("study {}: {}", self.study.name, self.study.about);
        std::iter::once(question).chain(self.asked.heading()).collect()
    }

    /// How to read the summary, in lines.
    pub fn notes(&self) -> Vec<String> {
        let medians = "Medians over the trials, unless a column is a count or a share.";
        let notes = self.study.notes.iter().chain([&medians]).map(ToString::to_string);
        notes.chain([format!("\n{:.0} s of trials", self.seconds)]).collect()
    }
}

/// The cases of a study that are meant: those of these names, or whose names hold these words; all if none is named.
fn chosen(study: &Study, named: &[String]) -> Result<Vec<String>, Error> {
    let all = (study.cases)();
    let means = |word: &String, case: &String| {
        if all.contains(word) { case == word } else { case.contains(word.as_str()) }
    };
    if let Some(word) = named.iter().find(|word| !all.iter().any(|case| means(word, case))) {
        let choices = all.join("; ");
        return Err(Error::usage(format!("study {} has no case {word}: choose from {choices}", study.name)));
    }
    let is_meant = |case: &&String| named.is_empty() || named.iter().any(|word| means(word, case));
    Ok(all.iter().filter(is_meant).cloned().collect())
}

/// The SHA-256 of a file.
fn hash(file: &Path) -> Result<String, Error> {
    Ok(Sha256::digest(files::read(file)?).iter().map(|byte| format!("{byte:02x}")).collect())
}

fn asked_creature(embodied: &Embodied, options: &StudyOptions) -> Result<AskedCreature, Error> {
    let (creature, source) = (embodied.creature(), embodied.source());
    let schema = options.session.as_ref().map(|session| hash(&session.join(SCHEMA_FILE)));
    Ok(AskedCreature {
        name: creature.name().into(),
        joints: creature.joints().len(),
        dof: creature.dof(),
        model: source.model.clone(),
        model_hash: model_hash(&source.model)?,
        moving: source.joints.to_string(),
        root: source.root.clone(),
        schema_hash: schema.transpose()?,
    })
}
