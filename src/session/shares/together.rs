//! All shares of a session.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::time::Duration;

use super::making::check_bouts;
use super::{Unready, made_shares};
use crate::agent::Agent;
use crate::babbling::RecordedBout;
use crate::error::Error;
use crate::session::{Session, Shares, TOUCHES_FILE, read_bouts, read_touches};
use crate::share::Share;

/// Shares that are all made, of one session.
pub struct BabbledShares {
    of: u64,
    /// The session, as its first share has it.
    session: Session,
    /// Where each share is.
    folders: BTreeMap<Share, PathBuf>,
    /// The time that all of them took.
    spent: Duration,
}

impl BabbledShares {
    /// The shares in a folder, if all are made; else which are not.
    ///
    /// # Errors
    /// Where a file cannot be read, or the shares are not all of one session.
    pub fn find(shares: &Shares) -> Result<Result<BabbledShares, Unready>, Error> {
        let made = match made_shares::<Session>(shares)? {
            Ok(made) => made,
            Err(unready) => return Ok(Err(unready)),
        };
        let effort = made.iter().filter_map(|(_, _, session)| session.effort);
        let spent = effort.map(|effort| Duration::try_from_secs_f64(effort.babbling_s).unwrap_or_default());
        let spent = spent.fold(Duration::ZERO, Duration::saturating_add);
        let folders = made.iter().map(|(share, folder, _)| (*share, folder.clone())).collect();
        // Without a share there is nothing to find.
        let session = made.into_iter().next().map(|(_, _, session)| session);
        Ok(session
            .map(|session| BabbledShares { of: shares.of(), session, folders, spent })
            .ok_or_else(Unready::default))
    }

    /// The session that they are of, as one of them has it.
    pub fn session(&self) -> &Session {
        &self.session
    }

    /// The time that all of them took to babble.
    pub fn spent(&self) -> Duration {
        self.spent
    }

    /// Reads all that was made; what it gives hands out each bout once, by its number.
    ///
    /// # Errors
    /// Where a log cannot be read or is not what its share's other files say.
    pub(in crate::session) fn bouts(
        &self,
        agent: &Agent,
    ) -> Result<impl FnMut(u64) -> Option<RecordedBout> + use<>, Error> {
        let of = self.of;
        let mut made: BTreeMap<Share, Vec<Option<RecordedBout>>> = BTreeMap::new();
        for (share, folder) in &self.folders {
            made.insert(*share, read_share(folder, *share, agent)?);
        }
        Ok(move |bout| {
            let (share, own) = Share::having(bout, of);
            made.get_mut(&share)?.get_mut(own as usize)?.take()
        })
    }
}

/// The bouts of one share.
fn read_share(folder: &Path, share: Share, agent: &Agent) -> Result<Vec<Option<RecordedBout>>, Error> {
    let bouts = read_bouts(folder)?;
    check_bouts(folder, share, &bouts)?;
    let path = folder.join(TOUCHES_FILE);
    let mut touches = read_touches(&path, agent)?.touches.into_iter().peekable();
    let recorded = bouts.iter().map(|line| {
        let of_bout =
            std::iter::from_fn(|| touches.next_if(|touch| touch.bout == line.bout)).collect::<Vec<_>>();
        (of_bout.len() == line.touches)
            .then(|| Some(RecordedBout { touches: of_bout, effort: line.effort }))
            .ok_or(line.bout)
    });
    let recorded: Result<Vec<_>, u64> = recorded.collect();
    let lost = match recorded {
        Ok(recorded) if touches.peek().is_none() => return Ok(recorded),
        Ok(_) => "after the last bout".to_string(),
        Err(bout) => format!("in bout {bout}"),
    };
    let reason = format!(
        "lines were added or lost {lost}, for its bouts have other touches: remove {} and make share {share} again",
        folder.display()
    );
    Err(Error::unfit(&path, reason))
}
