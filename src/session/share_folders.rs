//! Shares on disk: each in a folder of its own, so that several processes, on one machine or many, write beside each other.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

use crate::error::Error;
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
            let message = "there are no shares in it: make them with `bodyschema babble … --shard 1/3 --out DIR`, or \
                           with `bodyschema study`, and give that DIR";
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
            return Err(Error::content(&place, None, "there is no share in it: make one with --shard"));
        };
        if let Some(other) = counts.find(|other| *other != of) {
            let message = format!("there are shares of {of} and of {other}: remove those of one kind");
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
