//! `bodyschema babble --resume`: goes on with a session that was interrupted.

use std::path::Path;

use super::babbling::{BabbleArguments, Prepared};
use super::folders::written_session;
use super::{Failure, Outcome, output};
use crate::session::{BabbledSession, BabblingSession, FolderLock, ResumedSession, SESSION_FILE, Session};
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

/// What the session in a folder was asked.
pub fn args_of(session: &Session, folder: &Path) -> Result<BabbleArguments, Failure> {
    let place = folder.join(SESSION_FILE).display().to_string();
    if session.recording.is_some() || session.options.touches == 0 {
        return Err(Failure(format!(
            "{place}: it is not of babbling: give a folder that `bodyschema babble` made"
        )));
    }
    serde_json::from_value(session.options.asked.clone()).map_err(|what| {
        Failure(format!(
            "{place}: its options cannot be used ({what}): it is of another version of bodyschema, or was changed; babble anew"
        ))
    })
}
