//! Making one share of a session.

use std::path::{Path, PathBuf};
use std::time::Instant;

use super::ShareRecord;
use crate::babbling::{BoutsDone, Made};
use crate::error::Error;
use crate::session::babbling::{check_same, new_session};
use crate::session::{
    BOUTS_FILE, BabblingEffort, BoutLine, BoutLog, Embodied, FolderLock, Observer, Phase, Provenance,
    SESSION_FILE, Session, SessionSetup, TouchWriter, read_bouts,
};
use crate::share::Share;

/// A share of a session, with bouts still to make.
pub struct BabblingShare<'a> {
    embodied: &'a Embodied,
    setup: &'a SessionSetup,
    share: Share,
    folder: PathBuf,
    session: Session,
    /// The log, ready for the touch after those of `bouts`.
    log: TouchWriter<'a>,
    /// The bouts that need not be made again.
    bouts: Vec<BoutLine>,
}

impl<'a> BabblingShare<'a> {
    /// Begins a share in a folder, which is its writer's alone, or goes on with what is there of it; none where all of it
    /// is.
    ///
    /// # Errors
    /// Where a file cannot be read or written, or there is something else in the folder.
    pub fn take_up(
        embodied: &'a Embodied,
        setup: &'a SessionSetup,
        share: Share,
        lock: &FolderLock,
        provenance: Provenance,
    ) -> Result<Option<BabblingShare<'a>>, Error> {
        let folder = lock.folder().to_path_buf();
        let mut session = new_session(embodied, setup, provenance)?;
        session.options.share = Some(share.to_string());
        let (log, bouts) = if folder.join(SESSION_FILE).exists() {
            let there = Session::read(&folder)?;
            there.check(&folder, &session)?;
            check_same(&there, embodied, &folder)?;
            if there.effort.is_some() {
                return Ok(None);
            }
            take_up_logs(embodied, share, &folder)?
        } else {
            session.write(&folder)?;
            // A process that was killed before it had written that had no touches yet.
            (TouchWriter::resume(&folder, embodied.agent())?, Vec::new())
        };
        Ok(Some(BabblingShare { embodied, setup, share, folder, session, log, bouts }))
    }

    /// How many touches are there already.
    pub fn made(&self) -> usize {
        self.bouts.iter().map(|bout| bout.touches).sum()
    }

    /// Babbles what is missing, and writes every touch as soon as it is made. Returns the share's session; it counts as
    /// made, though it has no touch, where so many bouts bring none that one process would give up.
    ///
    /// # Errors
    /// Where the engine fails or a file cannot be written; a share that was interrupted so can be taken up.
    pub fn babble(self, observer: &dyn Observer) -> Result<Session, Error> {
        let made = self.made();
        let BabblingShare { embodied, setup, share, folder, mut session, mut log, bouts } = self;
        let babbler = embodied.babbler(setup.motion)?;
        observer.phase(Phase::Babbling {
            made,
            touches: setup.babbling.touches.div_ceil(share.of() as usize).max(made),
            grows: false,
            deadline: setup.deadline,
        });
        let mut from = BoutsDone { bouts: bouts.len() as u64, touches: made, ..BoutsDone::default() };
        bouts.iter().for_each(|bout| from.effort += bout.effort);
        let mut bout_log = BoutLog::go_on(&folder, &bouts)?;
        let (began, mut touches, mut own) = (Instant::now(), 0, from.bouts);
        let done = babbler.babble_share(share, from, &setup.babbling, |news| {
            match news {
                Made::Touch(touch) => {
                    log.write(touch)?;
                    observer.touched(touch);
                    touches += 1;
                }
                Made::Bout(_, effort) => {
                    bout_log.write(&BoutLine { bout: share.piece(own), touches, effort })?;
                    (own, touches) = (own + 1, 0);
                }
                Made::Grown(_) => {}
            }
            Ok::<(), Error>(())
        });
        let done = done.map_err(Error::of_model(embodied.model()))?;
        observer.phase(Phase::Done);
        log.finish()?;
        bout_log.finish()?;
        // What a process that was killed before had needed is not known any more.
        session.effort = Some(BabblingEffort {
            of_motions: done.effort,
            touches: Some(done.touches),
            ended_by: None,
            babbling_s: began.elapsed().as_secs_f64(),
        });
        session.write(&folder)?;
        Ok(session)
    }
}

/// The logs of a share that was interrupted, and the bouts that are whole in both.
fn take_up_logs<'a>(
    embodied: &'a Embodied,
    share: Share,
    folder: &Path,
) -> Result<(TouchWriter<'a>, Vec<BoutLine>), Error> {
    let agent = embodied.agent();
    let bouts = read_bouts(folder)?;
    check_bouts(folder, share, &bouts)?;
    let touches = bouts.iter().map(|bout| bout.touches).sum();
    let mut log = TouchWriter::resume(folder, agent)?;
    if log.skip(touches)? == touches {
        return Ok((log, bouts));
    }
    // The disk lost some: all are made once more.
    drop(log);
    Ok((TouchWriter::resume(folder, agent)?, Vec::new()))
}

/// Whether bouts are those that a share begins with.
pub(super) fn check_bouts(folder: &Path, share: Share, bouts: &[BoutLine]) -> Result<(), Error> {
    match bouts.iter().enumerate().find(|(own, bout)| bout.bout != share.piece(*own as u64)) {
        None => Ok(()),
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
