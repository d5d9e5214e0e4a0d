//! What a study is asked, made ready.

use std::path::{Path, PathBuf};

use serde_json::{Value, json};

use super::{StudyArguments, TOUCHES, bodies};
use crate::babbling;
use crate::calibration::made::Fault;
use crate::cli::Failure;
use crate::cli::open::{embodied, is_there};
use crate::cli::progress::Bars;
use crate::experiment::study::bodies::{self as bodies_study, BodiesOptions, STUDY as BODIES};
use crate::experiment::study::calibration::{self as calibration_study, STUDY as CALIBRATION};
use crate::experiment::study::claims::STUDY as CLAIMS;
use crate::experiment::study::hersch::{STUDY as HERSCH, TOUCHES as HERSCH_TOUCHES};
use crate::experiment::study::trial::{self, Concluded};
use crate::experiment::study::{ReceiveTrial, Subject};
use crate::experiment::{ExperimentError, Observer, Phase};
use crate::mujoco;
use crate::record::{PROGRAM, SCHEMA_FILE, model_hash};

/// A study that is ready to be made.
pub struct AskedStudy<'a> {
    pub args: &'a StudyArguments,
    /// One per trial.
    pub seeds: Vec<u64>,
    of: StudyOf<'a>,
    bars: &'a Bars,
}

/// What is studied.
enum StudyOf<'a> {
    /// A creature, or several.
    Creature(Box<Subject<'a>>),
    /// Bodies that the seeds make.
    Bodies(BodiesOptions),
    /// Robots that the seeds make, in these cases.
    Robots(Vec<Fault>),
}

impl<'a> AskedStudy<'a> {
    pub fn new(args: &'a StudyArguments, bars: &'a Bars) -> Result<AskedStudy<'a>, Failure> {
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
        let rule = args.hersch.options(study)?;
        let seeds = args.seeds()?;
        if study.name == BODIES.name {
            return Ok(AskedStudy { args, seeds, of: StudyOf::Bodies(bodies::options(args)?), bars });
        }
        if args.seconds.is_some() || !args.ways.is_empty() {
            return Err(Failure(format!(
                "study {} is not of generated bodies: leave out --seconds and --way",
                study.name
            )));
        }
        if study.name == CALIBRATION.name {
            bodies::refuse_creature(args)?;
            return Ok(AskedStudy { args, seeds, of: StudyOf::Robots(args.cases.clone()), bars });
        }
        is_there(model, &format!("study {}", study.name))?;
        let most = if study.name == HERSCH.name { HERSCH_TOUCHES } else { TOUCHES };
        let touches = args.touches.unwrap_or(most);
        let selection = args.joints.clone().unwrap_or_default();
        let read = |model: &PathBuf| embodied(args.open.source(model, selection.clone()));
        let mut subject =
            Subject::new(read(model)?, touches, seeds.clone(), babbling::threads(args.jobs), bars)?
                .with_others(others.iter().map(read).collect::<Result<_, Failure>>()?);
        subject.session.clone_from(&args.session);
        subject.hersch = rule;
        subject.policy = args.policy;
        Ok(AskedStudy { args, seeds, of: StudyOf::Creature(Box::new(subject)), bars })
    }

    /// The model, and others where the study is of several.
    fn models(&self) -> (&'a Path, &'a [PathBuf]) {
        // There is one: `new` has seen to it.
        (&self.args.model[0], &self.args.model[1..])
    }

    /// Makes the trials of some seeds, and hands on what each left as soon as it is done.
    pub fn run(&self, seeds: &[u64], receive: &mut ReceiveTrial) -> Result<(), ExperimentError> {
        match &self.of {
            StudyOf::Creature(subject) => self.args.name.trials.run(subject, seeds, receive),
            StudyOf::Bodies(options) => trial::record(seeds, receive, |seed| {
                self.begins(seed, "babbling and learning");
                Ok(bodies_study::trial(seed, options))
            }),
            StudyOf::Robots(cases) => trial::record(seeds, receive, |seed| {
                self.begins(seed, "calibrating");
                Ok(calibration_study::trial(seed, cases))
            }),
        }
    }

    fn begins(&self, seed: u64, doing: &'static str) {
        let trial = self.seeds.iter().position(|other| *other == seed).map_or(0, |k| k + 1);
        self.bars.phase(Phase::Trial { trial, trials: self.seeds.len(), doing });
    }

    /// What trials found that left these texts, and how long they took.
    pub fn conclude(&self, left: &[String]) -> Concluded {
        match &self.of {
            StudyOf::Creature(subject) => self.args.name.trials.conclude(subject, left),
            StudyOf::Bodies(_) => {
                let (trials, seconds) = trial::read(left)?;
                Ok((bodies_study::findings(&trials).into(), seconds))
            }
            StudyOf::Robots(_) => {
                let (trials, seconds) = trial::read(left)?;
                Ok((calibration_study::findings(&trials).into(), seconds))
            }
        }
    }

    /// What is studied and how often, in lines for a person.
    pub fn heading(&self) -> Vec<String> {
        let AskedStudy { args, seeds, of, .. } = self;
        let trials = if args.trials == 1 { "trial" } else { "trials" };
        let named = named_seeds(seeds);
        match of {
            StudyOf::Creature(subject) => {
                let (model, others) = self.models();
                let creature = &subject.body().creature;
                let first = format!(
                    "{}: {} joints, {} degrees of freedom ({}, --joints {})",
                    creature.name(),
                    creature.joints().len(),
                    creature.dof(),
                    model.display(),
                    subject.joints()
                );
                let others = others.iter().map(|other| format!("and {}", other.display()));
                let touches = args.name.touches.then(|| format!(" of {} touches", subject.touches));
                let last = format!("{} {trials}{}, seeds {named}", args.trials, touches.unwrap_or_default());
                std::iter::once(first).chain(others).chain([last]).collect()
            }
            StudyOf::Bodies(options) => {
                let of = format!("of {} touches at random", options.touches);
                vec![format!("{} generated bodies {of}, seeds {named}", args.trials)]
            }
            StudyOf::Robots(_) => vec![format!("{} made robots, seeds {named}", args.trials)],
        }
    }

    /// All that decides what comes out, beside the seeds' shares: two studies that have this in common are one.
    pub fn about(&self) -> Result<Value, Failure> {
        let AskedStudy { args, of, .. } = self;
        let study = args.name;
        let mut about = json!({
            "study": study.name,
            "about": study.about,
            "program": PROGRAM,
            "engine": mujoco::check()?.to_string(),
            "options": { "trials": args.trials, "seed": args.seed },
        });
        let options = match of {
            StudyOf::Bodies(BodiesOptions { touches, seconds, ways }) => {
                json!({ "touches": touches, "seconds": seconds, "ways": ways })
            }
            StudyOf::Robots(cases) => {
                json!({ "cases": cases.iter().map(|case| case.name()).collect::<Vec<_>>() })
            }
            StudyOf::Creature(subject) => {
                let creature = &subject.body().creature;
                about["creature"] = json!(creature.name());
                about["joints"] = json!(creature.joints().len());
                about["dof"] = json!(creature.dof());
                self.options_of(subject)?
            }
        };
        if let (Some(all), Value::Object(options)) = (about["options"].as_object_mut(), options) {
            all.extend(options);
        }
        Ok(about)
    }

    /// The options of a study of creatures.
    fn options_of(&self, subject: &Subject) -> Result<Value, Failure> {
        let args = self.args;
        let (model, others) = self.models();
        let hashes: Result<Vec<String>, _> = others.iter().map(|other| model_hash(other)).collect();
        let schema = args.session.as_ref().map(|session| model_hash(&session.join(SCHEMA_FILE)));
        Ok(json!({
            "model": model,
            "model_hash": model_hash(model)?,
            "other_models": others,
            "other_model_hashes": hashes?,
            "touches": args.name.touches.then_some(subject.touches),
            "joints": subject.joints().to_string(),
            "session": args.session,
            "session_schema_hash": schema.transpose()?,
            "policy": args.policy.map(|policy| policy.to_string()),
        }))
    }
}

/// Seeds that count on from the first, a few one by one.
fn named_seeds(seeds: &[u64]) -> String {
    const MOST: usize = 20;
    match seeds {
        [first, .., last] if seeds.len() > MOST => format!("{first} to {last}"),
        seeds => seeds.iter().map(u64::to_string).collect::<Vec<_>>().join(" "),
    }
}
