//! Bouts: made in any order, handed on in theirs; and how far a session of them has come.

use std::collections::BTreeMap;

use super::{BabblingError, MOTION, TOUCHES_PER_BOUT};
use crate::deadline::{Deadline, count_work};
use crate::learning::growth::Growth;
use crate::senses::Touch;
use crate::share::Share;
use crate::simulation::{Effort, EngineResult};

/// How far a session has come: whole bouts that need not be made again to go on from there.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct BoutsDone {
    /// Bouts done.
    pub bouts: u64,
    /// Touches made in them.
    pub touches: usize,
    /// What they cost.
    pub effort: Effort,
}

/// What babbling brings, in the session's order.
#[derive(Clone, Copy, Debug)]
pub enum Made<'a> {
    /// The next touch.
    Touch(&'a Touch),
    /// The end of a bout: how far that is, all touches up to here being handed on, and what the bout cost.
    Bout(BoutsDone, Effort),
    /// What a policy has learned of all touches up to here.
    Grown(&'a Growth),
}

/// A whole bout that was made before, by this process or another.
#[derive(Clone, Debug, PartialEq)]
pub struct RecordedBout {
    /// Its touches.
    pub touches: Vec<Touch>,
    /// What all its motions cost.
    pub effort: Effort,
}

/// The touches and the effort of one bout.
pub(super) struct Bout {
    /// The touches, each with the bout's effort up to it.
    pub touches: Vec<(Touch, Effort)>,
    /// The effort of all its motions.
    pub effort: Effort,
    /// Whether it came to its end; what comes after one that did not would leave a gap.
    pub is_whole: bool,
}

impl Bout {
    /// Whether it is what was recorded of it.
    pub fn is(&self, recorded: &RecordedBout) -> bool {
        self.effort.motions == recorded.effort.motions
            && self.touches.iter().map(|(touch, _)| touch).eq(&recorded.touches)
    }
}

impl From<RecordedBout> for Bout {
    /// The effort up to each touch is not recorded: all touches have that of the bout.
    fn from(recorded: RecordedBout) -> Bout {
        let RecordedBout { touches, effort } = recorded;
        Bout { touches: touches.into_iter().map(|touch| (touch, effort)).collect(), effort, is_whole: true }
    }
}

/// Where a row of bouts ends.
#[derive(Clone, Copy)]
pub(super) enum End {
    /// With a touch, in the middle of a bout where that is its number.
    AtTouch(usize),
    /// With the bout after which there are so many bouts and touches.
    AtBout(BoutsDone),
}

impl End {
    /// Where the share of a session of so many touches ends. It has the bouts that the session would be made of if all
    /// brought as many touches as a bout can; and if they bring fewer, so many more that it makes up for that by itself.
    pub fn of_share(share: Share, wanted: usize) -> End {
        let bouts = share.of_first(wanted.div_ceil(TOUCHES_PER_BOUT) as u64);
        let touches = (bouts as usize).saturating_mul(TOUCHES_PER_BOUT);
        End::AtBout(BoutsDone { bouts, touches, effort: Effort::default() })
    }

    fn is_reached(self, done: &BoutsDone) -> bool {
        match self {
            End::AtTouch(wanted) => done.touches >= wanted,
            End::AtBout(end) => done.bouts >= end.bouts && done.touches >= end.touches,
        }
    }
}

/// Puts the bouts that follow on `done` back into order and hands their touches on, up to where they are to end.
/// Returns how many there are and what they cost up to there, with those before; there may be no touch among them.
pub(super) fn gather<E>(
    bouts: &mut dyn Iterator<Item = (u64, EngineResult<Bout>)>,
    mut done: BoutsDone,
    end: End,
    (fruitless_bouts, deadline): (u64, Deadline),
    receive: &mut impl FnMut(Made) -> Result<(), E>,
) -> Result<BoutsDone, BabblingError<E>> {
    let mut waiting = BTreeMap::new();
    // Threads make bouts in any order: work is counted as if one had been made after the other.
    count_work(MOTION * done.effort.motions as usize);
    'bouts: while !end.is_reached(&done) {
        let next = bouts.next();
        if deadline.has_passed() {
            break;
        }
        let Some((number, bout)) = next else { break };
        waiting.insert(number, bout);
        while let Some(bout) = waiting.remove(&done.bouts) {
            let bout = bout.map_err(BabblingError::Engine)?;
            for (touch, so_far) in &bout.touches {
                receive(Made::Touch(touch)).map_err(BabblingError::Receiver)?;
                done.touches += 1;
                if matches!(end, End::AtTouch(_)) && end.is_reached(&done) {
                    done.effort += *so_far;
                    return Ok(done);
                }
            }
            done.effort += bout.effort;
            count_work(MOTION * bout.effort.motions as usize);
            if !bout.is_whole {
                break 'bouts;
            }
            done.bouts += 1;
            if done.touches == 0 && done.bouts >= fruitless_bouts {
                break 'bouts;
            }
            receive(Made::Bout(done, bout.effort)).map_err(BabblingError::Receiver)?;
            if end.is_reached(&done) || deadline.has_passed() {
                break 'bouts;
            }
        }
    }
    Ok(done)
}
