//! A session that several processes babble between them, on one machine or many.
//!
//! Bouts are drawn by their numbers, so a share of them can be made anywhere:
//! [`BabblingSession::take_up`](super::BabblingSession::take_up) makes one, in a folder of its own that names the session as any session's folder does. [`BabbledShares`] are all of them, of which
//! [`BabblingSession::put_together`](super::BabblingSession::put_together) makes the log that one process would have written.

mod gather;
mod together;

pub(crate) use gather::{MadeShares, ShareRecord, Unready, made_shares};
pub(crate) use together::BabbledShares;

use std::path::Path;

use crate::error::Error;
use crate::session::{BOUTS_FILE, BoutLine, SESSION_FILE, Session, SessionOptions, read_bouts};
use crate::share::Share;

/// The bouts that are whole in a share's folder: those that the share begins with.
pub(super) fn bouts_of_share(folder: &Path, share: Share) -> Result<Vec<BoutLine>, Error> {
    let bouts = read_bouts(folder)?;
    match bouts.iter().enumerate().find(|(own, bout)| bout.bout != share.piece(*own as u64)) {
        None => Ok(bouts),
        Some((own, _)) => {
            let reason = format!(
                "line {} is not of bout {}: lines were added or lost; remove {} and make the share again",
                own + 1,
                share.piece(own as u64),
                folder.display()
            );
            Err(Error::unfit(&folder.join(BOUTS_FILE), reason))
        }
    }
}

impl ShareRecord for Session {
    const FILE: &'static str = SESSION_FILE;
    const OF: &'static str = "session";

    fn read(folder: &Path) -> Result<Session, Error> {
        Session::read(folder)
    }

    fn share(&self) -> Option<&str> {
        self.options.share.as_deref()
    }

    fn command(&self) -> &[String] {
        &self.command
    }

    fn is_whole(&self, _folder: &Path) -> bool {
        self.effort.is_some()
    }

    fn difference(&self, other: &Session) -> Option<String> {
        let facts = |session: &Session| {
            let SessionOptions { touches, joints, root, motion, learner, input, known, .. } =
                session.options.clone();
            let words = |choice: Option<String>| choice.unwrap_or_else(|| "none".into());
            [
                ("program", session.program.clone()),
                ("MuJoCo", session.engine.clone()),
                ("seed", session.seed.to_string()),
                ("--touches", touches.to_string()),
                ("--joints", joints),
                ("--root", words(root)),
                ("--motion", words(motion)),
                ("--learner", words(learner)),
                ("--input", words(input)),
                ("--known", words(known)),
            ]
        };
        let mut pairs = facts(self).into_iter().zip(facts(other));
        if let Some(((what, one), (_, other))) = pairs.find(|(one, other)| one != other) {
            return Some(format!("one is of {what} {one}, the other of {what} {other}"));
        }
        let same = self.model_hash == other.model_hash && self.agent.creature() == other.agent.creature();
        (!same).then(|| format!("{} is not the same model for both", self.model))
    }
}
