//! `bodyschema babble --resume`: goes on with a session that was interrupted.

use std::path::Path;

use super::arguments::{Arguments, taken_up};
use super::babbling::{BabbleArguments, Prepared};
use super::folders::written_session;
use super::{Failure, Outcome, output};
use crate::experiment::{BabbledSession, BabblingSession, ResumedSession};
use crate::record::{FolderLock, SESSION_FILE, Session, SessionOptions};
use crate::view::report::REPORT_FILE;

/// Does what is missing in a session's folder: touches, learning, the report.
pub fn run(folder: &Path, given: &BabbleArguments) -> Outcome {
    let lock = written_session(folder)?;
    let session = Session::read(folder)?;
    let mut args = args_of(&session, folder)?;
    (args.jobs, args.json, args.live) = (given.jobs, given.json, given.live.clone());
    let prepared = Prepared::new(&args)?;
    let place = folder.display();
    match BabblingSession::resume(&prepared.embodied, &prepared.setup, &lock, session)? {
        ResumedSession::Babbling(session) => {
            if session.zeros() > 0 {
                tell!(
                    "{place}: its log ended in {} zero bytes, as a power failure leaves them: they are dropped",
                    session.zeros()
                );
            }
            tell!("{place}: going on after touch {} of {}", session.made(), prepared.setup.babbling.touches);
            prepared.babble(&args, lock, *session)
        }
        ResumedSession::Babbled(babbled) => finish(&prepared, &args, lock, &babbled),
    }
}

/// Learns from touches that are all there, where that was not done yet.
pub fn finish(
    prepared: &Prepared,
    args: &BabbleArguments,
    lock: FolderLock,
    babbled: &BabbledSession,
) -> Outcome {
    let (folder, touches) = (lock.folder(), babbled.touches.len());
    let place = folder.display();
    if !folder.join(REPORT_FILE).exists() {
        tell!("{place}: all {touches} touches are there; learning from them");
        return prepared.learn(args, lock, babbled);
    }
    tell!("{place} is complete: nothing is left to do");
    if args.json {
        output::json(&serde_json::json!({"session": folder, "touches": touches, "complete": true}))?;
    }
    Ok(())
}

/// The options that the session in a folder was begun with.
pub fn args_of(session: &Session, folder: &Path) -> Result<BabbleArguments, Failure> {
    let path = folder.join(SESSION_FILE);
    let SessionOptions { touches, policy, arguments, .. } = &session.options;
    if session.recording.is_some() || *touches == 0 || policy.is_none() && arguments.is_empty() {
        let path = path.display();
        return Err(Failure(format!(
            "{path}: it is not of babbling: give a folder that `bodyschema babble` made"
        )));
    }
    let mut arguments = if arguments.is_empty() { older(session) } else { arguments.clone() };
    // Files are reduced by themselves where they have to be; there was an option for it once.
    arguments.remove("strip");
    taken_up("babble", &arguments).map_err(|what| {
        Failure(format!(
            "{}: its options cannot be used ({what}): it is of another version of bodyschema, or was changed; babble anew",
            path.display()
        ))
    })
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
    [
        some("model", &session.model),
        some("touches", &options.touches.to_string()),
        some("seed", &session.seed.to_string()),
        some("joints", &options.joints),
    ]
    .into_iter()
    .chain(optional)
    .collect()
}
