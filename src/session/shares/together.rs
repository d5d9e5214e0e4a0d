//! All shares of a session.

use std::collections::BTreeMap;
use std::path::Path;
use std::time::Duration;

use super::{MadeShares, Unready, bouts_of_share, made_shares};
use crate::agent::Agent;
use crate::babbling::Bout;
use crate::error::Error;
use crate::session::{Session, Shares, TOUCHES_FILE, read_touches};
use crate::share::Share;

/// Shares that are all made, of one session.
pub(crate) struct BabbledShares(MadeShares<Session>);

impl BabbledShares {
    /// The shares in a folder, if all are made; else which are not.
    pub(crate) fn find(shares: &Shares) -> Result<Result<BabbledShares, Unready>, Error> {
        Ok(made_shares(shares)?.map(BabbledShares))
    }

    /// The session that they are of, as the first share has it.
    pub(crate) fn session(&self) -> &Session {
        &self.0[0].2
    }

    /// The time that all of them took to babble.
    pub(crate) fn spent(&self) -> Duration {
        let effort = self.0.iter().filter_map(|(_, _, session)| session.effort);
        let spent = effort.map(|effort| Duration::try_from_secs_f64(effort.babbling_s).unwrap_or_default());
        spent.fold(Duration::ZERO, Duration::saturating_add)
    }

    /// Reads all that was made; what it gives hands out each bout once, by its number.
    pub(in crate::session) fn bouts(
        &self,
        agent: &Agent,
    ) -> Result<impl FnMut(u64) -> Option<Bout> + use<>, Error> {
        let mut made = BTreeMap::new();
        for (share, folder, _) in &self.0 {
            made.extend(read_share(folder, *share, agent)?);
        }
        Ok(move |bout| made.remove(&bout))
    }
}

/// The bouts of one share, by their numbers.
fn read_share(folder: &Path, share: Share, agent: &Agent) -> Result<BTreeMap<u64, Bout>, Error> {
    let bouts = bouts_of_share(folder, share)?;
    let path = folder.join(TOUCHES_FILE);
    let mut touches = read_touches(&path, agent)?.touches.into_iter().peekable();
    let lost = |lost: String| {
        let reason = format!(
            "lines were added or lost {lost}, for its bouts have other touches: remove {} and make share {share} again",
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
