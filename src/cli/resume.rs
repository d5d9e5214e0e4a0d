//! `bodyschema babble --resume`: goes on with a session that was interrupted.

use std::path::Path;
use std::time::Duration;

use clap::{Command, FromArgMatches};

use super::arguments::{Arguments, command_line};
use super::babble::{Args, Begun, Plan};
use super::report::REPORT_FILE;
use super::{Failure, Outcome, output};
use crate::babbling::{BoutsDone, PolicyName};
use crate::record::{
    BabblingProgress, SESSION_FILE, Session, SessionOptions, TOUCHES_FILE, TouchWriter, read_touches,
};

/// Does what is missing in a session's folder: touches, learning, the report.
pub fn run(folder: &Path, given: &Args) -> Outcome {
    let session = Session::read(folder)?;
    let args = args_of(&session, folder, given)?;
    let plan = Plan::new(&args)?;
    check_same(&session, &plan, folder)?;
    let (creature, skin) = (&session.creature, &session.skin);
    if session.effort.is_some() {
        let made = read_touches(&folder.join(TOUCHES_FILE), creature, skin)?.touches;
        if made.len() != args.touches {
            return Err(Failure(format!(
                "{}: it has {} touches of {} though babbling was done: lines were added or lost; babble anew with --out",
                folder.join(TOUCHES_FILE).display(),
                made.len(),
                args.touches
            )));
        }
        if !folder.join(REPORT_FILE).exists() {
            tell!("{}: all {} touches are there; learning from them", folder.display(), made.len());
            let live = plan.live(&args, made.len())?;
            return plan.learn(&args, folder, &session, &made, live.as_ref());
        }
        tell!("{} is complete: nothing is left to do", folder.display());
        if args.json {
            return output::json(&serde_json::json!({
                "session": folder,
                "touches": made.len(),
                "complete": true,
            }));
        }
        return Ok(());
    }
    let mut log = TouchWriter::resume(folder, creature, skin)?;
    let done = BabblingProgress::read(folder).filter(|_| args.policy == PolicyName::Random);
    let mut begun = (BoutsDone::default(), Duration::ZERO, Vec::new());
    if let Some(progress) = done
        && let Ok(spent) = Duration::try_from_secs_f64(progress.effort.babbling_s)
    {
        if log.skip(progress.touches)? == progress.touches {
            let mut made = read_touches(&folder.join(TOUCHES_FILE), creature, skin)?.touches;
            made.truncate(progress.touches);
            begun = (progress.done(), spent, made);
        } else {
            // The disk lost some: all are made once more.
            drop(log);
            log = TouchWriter::resume(folder, creature, skin)?;
        }
    }
    let (done, spent, made) = begun;
    tell!("{}: going on after touch {} of {}", folder.display(), made.len(), args.touches);
    plan.babble(&args, folder.to_path_buf(), session.clone(), Begun { log, done, spent, made })
}

/// The options that the session was begun with; those that change nothing in it are taken from the command line.
fn args_of(session: &Session, folder: &Path, given: &Args) -> Result<Args, Failure> {
    let path = folder.join(SESSION_FILE);
    let SessionOptions { touches, policy, arguments, .. } = &session.options;
    if session.recording.is_some() || *touches == 0 || policy.is_none() && arguments.is_empty() {
        let path = path.display();
        return Err(Failure(format!(
            "{path}: it is not of babbling: give a folder that `bodyschema babble` made"
        )));
    }
    let arguments = if arguments.is_empty() { &older(session) } else { arguments };
    let refuse = |what: String| {
        Failure(format!(
            "{}: its options cannot be used ({what}): it is of another version of bodyschema, or was changed; babble anew",
            path.display()
        ))
    };
    let command = <Args as clap::Args>::augment_args(Command::new("babble"));
    let line =
        command_line(&command, arguments).map_err(|option| refuse(format!("there is no --{option}")))?;
    let matches = command.try_get_matches_from(line);
    let mut args = matches.and_then(|matches| Args::from_arg_matches(&matches)).map_err(|error| {
        let text = error.to_string();
        refuse(text.lines().next().unwrap_or_default().trim_start_matches("error: ").to_string())
    })?;
    (args.jobs, args.json, args.live) = (given.jobs, given.json, given.live);
    Ok(args)
}

/// The options of a session that was begun before all were written into it.
fn older(session: &Session) -> Arguments {
    let options = &session.options;
    let some = |name: &str, value: &str| (name.to_string(), vec![value.to_string()]);
    let optional = [
        ("root", &options.root),
        ("input", &options.input),
        ("learner", &options.learner),
        ("known", &options.known),
        ("policy", &options.policy),
        ("motion", &options.motion),
    ];
    let optional = optional.into_iter().filter_map(|(name, value)| Some(some(name, value.as_ref()?)));
    let strip = options.strip.then(|| ("strip".to_string(), Vec::new()));
    [
        some("model", &session.model),
        some("touches", &options.touches.to_string()),
        some("seed", &session.seed.to_string()),
        some("joints", &options.joints),
    ]
    .into_iter()
    .chain(optional)
    .chain(strip)
    .collect()
}

/// Whether the session's creature and engine are still the same, without which touches would be others.
fn check_same(session: &Session, plan: &Plan, folder: &Path) -> Outcome {
    let path = folder.join(SESSION_FILE);
    let version = plan.body.model.version().to_string();
    if session.engine != version {
        return Err(Failure(format!(
            "{}: it was begun with MuJoCo {}, and this is {version}: go on with that one, or babble anew",
            path.display(),
            session.engine
        )));
    }
    if session.model_hash != crate::record::model_hash(Path::new(&session.model))?
        || session.creature != plan.body.creature
        || serde_json::to_value(&session.skin)? != serde_json::to_value(&plan.skin)?
    {
        return Err(Failure(format!(
            "{}: it has changed since the session in {} was begun: put it back as it was, or babble anew",
            session.model,
            folder.display()
        )));
    }
    Ok(())
}
