//! Bouts: made in any order, delivered in sequence; and the progress of a session of them.

use std::collections::BTreeMap;

use super::{MOTION, TOUCHES_PER_BOUT};
use crate::deadline::{Deadline, count_work};
use crate::error::{Error, Result};
use crate::learning::growth::Growth;
use crate::senses::RecordedTouch;
use crate::share::Share;
use crate::simulation::Effort;

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
    Touch(&'a RecordedTouch),
    /// The end of a bout: how far that is, all touches up to here being handed on, and what the bout cost.
    Bout(BoutsDone, Effort),
    /// What a policy has learned of all touches up to here.
    Grown(&'a Growth),
}

/// The touches and the effort of one bout.
#[derive(Clone, Debug)]
pub struct Bout {
    /// Its touches.
    pub touches: Vec<RecordedTouch>,
    /// The effort up to each of them, which is not recorded.
    pub(super) so_far: Vec<Effort>,
    /// The effort of all its motions.
    pub effort: Effort,
    /// Whether it came to its end; what comes after one that did not would leave a gap.
    pub(super) is_whole: bool,
}

impl Bout {
    /// A whole one that was made before, by this process or another.
    pub fn recorded(touches: Vec<RecordedTouch>, effort: Effort) -> Bout {
        Bout { touches, so_far: Vec::new(), effort, is_whole: true }
    }

    /// The same, if it is what was recorded of it.
    pub(super) fn checked(self, number: u64, recorded: Option<Bout>) -> Result<Bout> {
        let same = |other: Bout| self.effort.motions == other.effort.motions && self.touches == other.touches;
        match recorded.is_none_or(same) {
            true => Ok(self),
            false => Err(Error::model(format!(
                "bout {number} of a share differs from what is babbled here: it was edited, or made by another \
                 version of bodyschema or on a machine with different floating-point results; make that share \
                 again here"
            ))),
        }
    }
}

/// Where a row of bouts ends: with so many bouts and touches.
#[derive(Clone, Copy)]
pub(super) struct End {
    bouts: u64,
    touches: usize,
    /// Whether it ends with the last of these touches, even in the middle of a bout.
    in_bout: bool,
}

impl End {
    /// With a touch of a number.
    pub fn at_touch(touches: usize) -> End {
        End { bouts: 0, touches, in_bout: true }
    }

    /// Where the share of a session of so many touches ends. It has the bouts that the session would be made of if all
    /// brought as many touches as a bout can; and if they bring fewer, so many more that it makes up for that by itself.
    pub fn of_share(share: Share, wanted: usize) -> End {
        let bouts = share.of_first(wanted.div_ceil(TOUCHES_PER_BOUT) as u64);
        End { bouts, touches: (bouts as usize).saturating_mul(TOUCHES_PER_BOUT), in_bout: false }
    }

    fn is_reached(self, done: &BoutsDone) -> bool {
        done.bouts >= self.bouts && done.touches >= self.touches
    }
}

/// Puts the bouts that follow on `done` back into order and hands their touches on, up to where they are to end.
/// Returns how many there are and what they cost up to there, with those before; there may be no touch among them.
pub(super) fn gather(
    bouts: &mut dyn Iterator<Item = (u64, Result<Bout>)>,
    mut done: BoutsDone,
    end: End,
    (fruitless_bouts, deadline): (u64, Deadline),
    receive: &mut dyn FnMut(Made) -> Result<()>,
) -> Result<BoutsDone> {
    let mut waiting = BTreeMap::new();
    // Threads make bouts in any order: work is counted as if one had been made after the other.
    count_work(MOTION * done.effort.motions as usize);
    'bouts: while !end.is_reached(&done) {
        let Some((number, bout)) = bouts.next().filter(|_| !deadline.has_passed()) else { break };
        waiting.insert(number, bout);
        while let Some(bout) = waiting.remove(&done.bouts) {
            let bout = bout?;
            for (k, touch) in bout.touches.iter().enumerate() {
                receive(Made::Touch(touch))?;
                done.touches += 1;
                if end.in_bout && end.is_reached(&done) {
                    done.effort += bout.so_far.get(k).copied().unwrap_or(bout.effort);
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
            receive(Made::Bout(done, bout.effort))?;
            if end.is_reached(&done) || deadline.has_passed() {
                break 'bouts;
            }
        }
    }
    Ok(done)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::creature::Posture;
    use crate::senses::{Touch, TouchEnd};

    fn touch(bout: u64, motion: u64) -> RecordedTouch {
        let ends = [TouchEnd::at(0), TouchEnd::at(1)];
        let touch = Touch { bout, motion, posture: Posture::default(), ends, moment: None };
        RecordedTouch::new(touch, Default::default())
    }

    fn effort(motions: u64) -> Effort {
        Effort { motions, ..Effort::default() }
    }

    /// A whole bout of so many touches, two motions each, and one motion more.
    fn bout(number: u64, touches: u64) -> Bout {
        let so_far = (1..=touches).map(|k| effort(2 * k)).collect();
        let made = (1..=touches).map(|k| touch(number, 2 * k)).collect();
        Bout { touches: made, so_far, effort: effort(2 * touches + 1), is_whole: true }
    }

    /// The bouts of the touches handed on, and the result, of bouts that become ready in this order.
    fn gathered(order: &[(u64, u64)], end: End) -> (Vec<u64>, BoutsDone) {
        let mut bouts = order.iter().map(|&(number, touches)| (number, Ok(bout(number, touches))));
        let mut received = Vec::new();
        let receive = &mut |made: Made| {
            if let Made::Touch(touch) = made {
                received.push(touch.bout);
            }
            Ok(())
        };
        let done = gather(&mut bouts, BoutsDone::default(), end, (3, Deadline::Never), receive);
        (received, done.expect("no bout fails"))
    }

    #[test]
    fn bouts_made_in_any_order_are_handed_on_in_theirs_up_to_the_last_touch_wanted() {
        for order in [[(0, 2), (1, 3), (2, 2)], [(2, 2), (0, 2), (1, 3)]] {
            let (received, done) = gathered(&order, End::at_touch(4));
            assert_eq!(received, [0, 0, 1, 1]);
            // The first bout took 5 motions; the second touch of the next one came with its fourth.
            assert_eq!((done.bouts, done.touches, done.effort.motions), (1, 4, 9));
        }
    }

    #[test]
    fn nothing_is_handed_on_after_a_gap_and_fruitless_bouts_end_it() {
        assert_eq!(gathered(&[(0, 1), (2, 5)], End::at_touch(10)).0, [0]);
        let (received, done) = gathered(&[(0, 0), (1, 0), (2, 0), (3, 1)], End::at_touch(1));
        assert_eq!((received.len(), done.bouts), (0, 3));
    }

    #[test]
    fn shares_of_full_bouts_add_up_to_the_session() {
        for wanted in [1, 25, 26, 990] {
            let ends = Share::all(7).map(|share| End::of_share(share, wanted).bouts);
            assert_eq!(ends.sum::<u64>(), wanted.div_ceil(TOUCHES_PER_BOUT) as u64);
        }
    }
}
