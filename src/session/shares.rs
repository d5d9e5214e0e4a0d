//! Work that several processes make between them, on one machine or many: each share is in a folder of its own.
//!
//! Bouts are drawn by their numbers, so a share of them can be made anywhere:
//! [`BabblingSession::take_up`](super::BabblingSession::take_up) makes one, in a folder that names the session as any session's folder does.
//! Of all of them [`BabblingSession::put_together`](super::BabblingSession::put_together) makes the log that one process would
//! have written.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::time::Duration;

use serde_json::{Value, json};

use crate::agent::Agent;
use crate::babbling::Bout;
use crate::error::Error;
use crate::session::{SESSION_FILE, Session, SessionOptions, TOUCHES_FILE, read_bouts, read_touches};
use crate::share::Share;

/// Where the shares of a folder's work are.
pub(crate) const SHARES_FOLDER: &str = "shares";

/// The shares of a folder's work that were begun.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Shares {
    of: u64,
    begun: BTreeMap<Share, PathBuf>,
}

impl Shares {
    /// The folder of a share: `shares/03-of-16`.
    pub(crate) fn folder(of: &Path, share: Share) -> PathBuf {
        let width = share.of().to_string().len();
        of.join(SHARES_FOLDER).join(format!("{:0width$}-of-{}", share.number(), share.of()))
    }

    /// Looks for the shares in a folder.
    pub(crate) fn find(folder: &Path) -> Result<Shares, Error> {
        let place = folder.join(SHARES_FOLDER);
        if !place.is_dir() {
            let message = "it contains no shares: make them with `bodyschema babble … --shard 1/3 --out DIR`, or with `bodyschema study`, and give that DIR";
            return Err(Error::content(folder, None, message));
        }
        let io = || Error::unreadable(&place);
        let mut begun = BTreeMap::new();
        for entry in fs::read_dir(&place).map_err(io())? {
            let path = entry.map_err(io())?.path();
            let share = path.file_name().and_then(|name| name.to_str()).and_then(named);
            begun.extend(
                share.filter(|share| Shares::folder(folder, *share) == path).map(|share| (share, path)),
            );
        }
        let mut counts = begun.keys().map(|share| share.of());
        let Some(of) = counts.next() else {
            return Err(Error::content(&place, None, "it contains no share: make one with --shard"));
        };
        if let Some(other) = counts.find(|other| *other != of) {
            let message = format!("it contains shares of {of} and of {other}: remove one kind");
            return Err(Error::content(&place, None, message));
        }
        Ok(Shares { of, begun })
    }

    /// Those that were begun, and where they are.
    pub(crate) fn begun(&self) -> impl Iterator<Item = (Share, &Path)> {
        self.begun.iter().map(|(share, path)| (*share, path.as_path()))
    }

    /// Those that were not.
    pub(crate) fn missing(&self) -> Vec<Share> {
        Share::all(self.of).filter(|share| !self.begun.contains_key(share)).collect()
    }
}

/// The share that a folder is named after.
fn named(name: &str) -> Option<Share> {
    let (number, of) = name.split_once("-of-")?;
    Share::new(number.parse().ok()?, of.parse().ok()?)
}

/// What the folder of a share records about it.
pub trait ShareRecord: Sized {
    /// The file that it is in.
    const FILE: &'static str;
    /// What is shared.
    const OF: &'static str;

    /// Reads it from the folder of a share.
    fn read(folder: &Path) -> Result<Self, Error>;
    /// The name of the share, as in `3/16`; `None` if it is no share.
    fn share(&self) -> Option<&str>;
    /// How it was asked for, word by word.
    fn command(&self) -> &[String];
    /// Whether all of the share is made in its folder.
    fn is_whole(&self, folder: &Path) -> bool;
    /// What differs from another share's record, in words, though both are to be of the same work; `None` if nothing does.
    fn difference(&self, other: &Self) -> Option<String>;

    /// Whether a folder holds one.
    fn is_in(folder: &Path) -> bool {
        folder.join(Self::FILE).exists()
    }

    /// Whether this record of a folder is that of what is asked for.
    fn check(&self, folder: &Path, asked: &Self) -> Result<(), Error> {
        let why = match self.difference(asked) {
            _ if self.share() != asked.share() => "it belongs to another share".to_string(),
            Some(difference) => {
                let of = Self::OF;
                format!("it belongs to another {of} ({difference})")
            }
            None => return Ok(()),
        };
        let why = format!("{why}: give another folder with --out");
        Err(Error::unfit(&folder.join(Self::FILE), why))
    }
}

/// Shares that have to be made before all can be put together.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(crate) struct Unready {
    /// Those that were not begun, or of which nothing is left.
    pub missing: Vec<Share>,
    /// Those that were interrupted, or are being made.
    pub unfinished: Vec<Share>,
    /// How one that was begun was asked for, word by word; empty if that was not kept.
    pub command: Vec<String>,
}

impl Unready {
    /// All of them, in their order.
    pub(crate) fn all(&self) -> Vec<Share> {
        let mut all: Vec<Share> = self.missing.iter().chain(&self.unfinished).copied().collect();
        all.sort_unstable();
        all
    }
}

/// The shares of some work, at least one, each with its folder and record.
pub type MadeShares<R> = Vec<(Share, PathBuf, R)>;

/// All shares of some work with their records and folders, if all are made; else which are not.
pub(crate) fn made_shares<R: ShareRecord>(shares: &Shares) -> Result<Result<MadeShares<R>, Unready>, Error> {
    let mut unready = Unready { missing: shares.missing(), ..Unready::default() };
    let mut made: MadeShares<R> = Vec::new();
    for (share, folder) in shares.begun() {
        // One that was killed at once has none yet.
        if !R::is_in(folder) {
            unready.missing.push(share);
            continue;
        }
        let record = R::read(folder)?;
        let unfit = |why: String| Err(Error::unfit(&folder.join(R::FILE), why));
        if record.share() != Some(share.to_string().as_str()) {
            return unfit(format!(
                "it does not belong to share {share}: move it where it belongs, or make that share again"
            ));
        }
        match made.first() {
            None => unready.command = record.command().to_vec(),
            Some((_, other, first)) => {
                if let Some(difference) = first.difference(&record) {
                    return unfit(format!(
                        "it belongs to another {} than {} ({difference}): make one of them again",
                        R::OF,
                        other.display()
                    ));
                }
            }
        }
        if !record.is_whole(folder) {
            unready.unfinished.push(share);
        }
        made.push((share, folder.to_path_buf(), record));
    }
    Ok(if unready.all().is_empty() { Ok(made) } else { Err(unready) })
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
        // Where the files are may differ from machine to machine, and the command with it.
        let facts = |session: &Session| {
            let options = SessionOptions { share: None, asked: Value::Null, ..session.options.clone() };
            json!({"program": session.program, "MuJoCo": session.engine, "seed": session.seed, "options": options})
        };
        let same = self.model_hash == other.model_hash && self.agent.creature() == other.agent.creature();
        difference(&facts(self), &facts(other))
            .or_else(|| (!same).then(|| format!("{} is a different model", self.model)))
    }
}

/// The first that differs of what two JSON objects say, in words; `None` if nothing does.
pub(crate) fn difference(one: &Value, other: &Value) -> Option<String> {
    one.as_object()?.iter().find_map(|(name, value)| match &other[name] {
        same if same == value => None,
        inner if value.is_object() && inner.is_object() => difference(value, inner),
        another => Some(format!("{name} is {value} in one, {another} in the other")),
    })
}

/// The time that all shares of a session took to babble.
pub(super) fn time_spent(shares: &MadeShares<Session>) -> Duration {
    let effort = shares.iter().filter_map(|(_, _, session)| session.effort);
    let spent = effort.map(|effort| Duration::try_from_secs_f64(effort.babbling_s).unwrap_or_default());
    spent.fold(Duration::ZERO, Duration::saturating_add)
}

/// Reads all that was made of a session by shares; what it gives hands out each bout once, by its number.
pub(super) fn bouts_of(
    shares: &MadeShares<Session>,
    agent: &Agent,
) -> Result<impl FnMut(u64) -> Option<Bout> + use<>, Error> {
    let mut made = BTreeMap::new();
    for (share, folder, _) in shares {
        made.extend(read_share(folder, *share, agent)?);
    }
    Ok(move |bout| made.remove(&bout))
}

/// The bouts of one share, by their numbers.
fn read_share(folder: &Path, share: Share, agent: &Agent) -> Result<BTreeMap<u64, Bout>, Error> {
    let bouts = read_bouts(folder, share)?;
    let path = folder.join(TOUCHES_FILE);
    let mut touches = read_touches(&path, agent)?.touches.into_iter().peekable();
    let lost = |lost: String| {
        let reason = format!(
            "lines were added or lost {lost}: its bouts have different touches; remove {} and make share {share} \
             again",
            folder.display()
        );
        Error::unfit(&path, reason)
    };
    let mut recorded = BTreeMap::new();
    for line in bouts {
        let of_bout: Vec<_> =
            std::iter::from_fn(|| touches.next_if(|touch| touch.bout == line.bout)).collect();
        if of_bout.len() != line.touches {
            return Err(lost(format!("in bout {}", line.bout)));
        }
        recorded.insert(line.bout, Bout::recorded(of_bout, line.effort));
    }
    match touches.peek() {
        Some(_) => Err(lost("after the last bout".to_string())),
        None => Ok(recorded),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shares_are_found_where_they_are_made() {
        let place = tempfile::tempdir().unwrap();
        let refused = |place: &Path| Shares::find(place).unwrap_err().to_string();
        assert!(refused(place.path()).contains("--shard"));
        for number in [3, 16, 1] {
            fs::create_dir_all(Shares::folder(place.path(), Share::new(number, 16).unwrap())).unwrap();
        }
        fs::create_dir(place.path().join("shares/notes")).unwrap();
        let shares = Shares::find(place.path()).unwrap();
        let begun: Vec<String> = shares.begun().map(|(share, _)| share.to_string()).collect();
        assert_eq!((shares.of, shares.missing().len()), (16, 13));
        assert_eq!(begun, ["1/16", "3/16", "16/16"]);
        assert!(place.path().join("shares/03-of-16").is_dir());
        fs::create_dir(place.path().join("shares/1-of-2")).unwrap();
        assert!(refused(place.path()).contains("of 2 and of 16"));
    }
}
