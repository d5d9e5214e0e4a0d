//! A session that several processes babble between them, on one machine or many.
//!
//! Bouts are drawn by their numbers, so a share of them can be made anywhere: [`BabblingShare`] makes one, in a folder of
//! its own that names the session as any session's folder does. [`BabbledShares`] are all of them, of which
//! [`BabblingSession::put_together`](super::BabblingSession::put_together) makes the log that one process would have written.

mod gather;
mod making;
mod together;

pub use gather::Unready;
pub(crate) use gather::{ShareRecord, made_shares};
pub use making::BabblingShare;
pub use together::BabbledShares;

use std::path::Path;

use crate::error::Error;
use crate::session::{SESSION_FILE, Session};

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
        let one = self;
        let of = |what: &str, one: &str, other: &str| {
            (one != other).then(|| format!("one is of {what} {one}, the other of {what} {other}"))
        };
        let (a, b) = (&one.options, &other.options);
        let words = |choice: &Option<String>| choice.clone().unwrap_or_else(|| "none".into());
        of("program", &one.program, &other.program)
            .or_else(|| of("MuJoCo", &one.engine, &other.engine))
            .or_else(|| of("seed", &one.seed.to_string(), &other.seed.to_string()))
            .or_else(|| of("--touches", &a.touches.to_string(), &b.touches.to_string()))
            .or_else(|| of("--joints", &a.joints, &b.joints))
            .or_else(|| of("--root", &words(&a.root), &words(&b.root)))
            .or_else(|| of("--motion", &words(&a.motion), &words(&b.motion)))
            .or_else(|| of("--learner", &words(&a.learner), &words(&b.learner)))
            .or_else(|| of("--input", &words(&a.input), &words(&b.input)))
            .or_else(|| of("--known", &words(&a.known), &words(&b.known)))
            .or_else(|| {
                let same =
                    one.model_hash == other.model_hash && one.agent.creature() == other.agent.creature();
                (!same).then(|| format!("{} is not the same model for both", one.model))
            })
    }
}
