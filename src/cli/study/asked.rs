//! What a study is asked, made ready.

use std::path::{Path, PathBuf};

use serde_json::{Value, json};

use super::{DEFAULT_MODEL, StudyArguments, TOUCHES};
use crate::babbling;
use crate::cli::Failure;
use crate::cli::open::embodied;
use crate::cli::progress::Bars;
use crate::experiment::study::Subject;
use crate::experiment::study::calibration::STUDY as CALIBRATION;
use crate::experiment::study::claims::STUDY as CLAIMS;
use crate::experiment::study::hersch::{STUDY as HERSCH, TOUCHES as HERSCH_TOUCHES};
use crate::record::{PROGRAM, SCHEMA_FILE, model_hash};

/// A study whose subject is ready.
pub struct AskedStudy<'a> {
    pub args: &'a StudyArguments,
    pub subject: Subject<'a>,
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
        if !model.exists() && model == Path::new(DEFAULT_MODEL) {
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
        if args.policy.is_some() && study.name != CLAIMS.name {
            return Err(Failure(format!("study {} is not of one policy: leave out --policy", study.name)));
        }
        if !args.cases.is_empty() && study.name != CALIBRATION.name {
            return Err(Failure(format!("study {} has no cases: leave out --case", study.name)));
        }
        let rule = args.hersch.options(study)?;
        let most = if study.name == HERSCH.name { HERSCH_TOUCHES } else { TOUCHES };
        let touches = args.touches.unwrap_or(most);
        let selection = args.joints.clone().unwrap_or_default();
        let last = args.seed.checked_add(u64::from(args.trials) - 1);
        let last = last.ok_or("the last trial's seed would be too great: give a smaller --seed")?;
        let seeds: Vec<u64> = (args.seed..=last).collect();
        let read = |model: &PathBuf| embodied(args.open.source(model, selection.clone()));
        let mut subject = Subject::new(read(model)?, touches, seeds, babbling::threads(args.jobs), bars)?
            .with_others(others.iter().map(read).collect::<Result<_, Failure>>()?);
        subject.session.clone_from(&args.session);
        subject.hersch = rule;
        subject.policy = args.policy;
        subject.cases.clone_from(&args.cases);
        Ok(AskedStudy { args, subject })
    }

    /// The model, and others where the study is of several.
    pub fn models(&self) -> (&'a Path, &'a [PathBuf]) {
        // There is one: `new` has seen to it.
        (&self.args.model[0], &self.args.model[1..])
    }

    /// All that decides what comes out, beside the seeds' shares: two studies that have this in common are one.
    pub fn about(&self) -> Result<Value, Failure> {
        let AskedStudy { args, subject } = self;
        let (study, creature) = (args.name, &subject.body().creature);
        let (model, others) = self.models();
        let hashes: Result<Vec<String>, _> = others.iter().map(|other| model_hash(other)).collect();
        let schema = args.session.as_ref().map(|session| model_hash(&session.join(SCHEMA_FILE)));
        Ok(json!({
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
                "other_model_hashes": hashes?,
                "touches": study.touches.then_some(subject.touches),
                "trials": args.trials,
                "seed": args.seed,
                "joints": subject.joints().to_string(),
                "session": args.session,
                "session_schema_hash": schema.transpose()?,
                "policy": args.policy.map(|policy| policy.to_string()),
                "cases": args.cases.iter().map(|case| case.name()).collect::<Vec<_>>(),
            },
        }))
    }
}
