//! Shares of any work, whatever is shared: whether they belong together, and which are not made yet.

use std::path::{Path, PathBuf};

use crate::error::Error;
use crate::session::Shares;
use crate::share::Share;

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
            _ if self.share() != asked.share() => "it is not of the share asked for".to_string(),
            Some(difference) => {
                let of = Self::OF;
                format!("it is of another {of} than the one asked for ({difference})")
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
                "it is not of share {share}: move it where it belongs, or make that share again"
            ));
        }
        match made.first() {
            None => unready.command = record.command().to_vec(),
            Some((_, other, first)) => {
                if let Some(difference) = first.difference(&record) {
                    return unfit(format!(
                        "it is not of the {} that {} is of ({difference}): make one of them again",
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
