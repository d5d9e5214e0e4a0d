//! Bouts: made in any order, delivered in sequence; and the progress of a session of them.

use std::collections::BTreeMap;

use super::MOTION;
use crate::deadline::{Deadline, count_work};
use crate::error::Result;
use crate::learning::growth::Growth;
use crate::senses::RecordedTouch;
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
    /// The end of a bout: how far that is, all touches up to here being handed on.
    Bout(BoutsDone),
    /// What a policy has learned of all touches up to here.
    Grown(&'a Growth),
}

/// The touches and the effort of one bout.
#[derive(Clone, Debug)]
pub(super) struct Bout {
    /// Its touches.
    pub(super) touches: Vec<RecordedTouch>,
    /// The effort up to each of them.
    pub(super) so_far: Vec<Effort>,
    /// The effort of all its motions.
    pub(super) effort: Effort,
    /// Whether it came to its end; what comes after one that did not would leave a gap.
    pub(super) is_whole: bool,
}

/// Puts the bouts that follow on `done` back into order and hands their touches on, until there are so many.
/// Returns how many there are and what they cost up to there, with those before; there may be no touch among them.
pub(super) fn gather(
    bouts: &mut dyn Iterator<Item = (u64, Result<Bout>)>,
    mut done: BoutsDone,
    wanted: usize,
    (fruitless_bouts, deadline): (u64, Deadline),
    receive: &mut dyn FnMut(Made) -> Result<()>,
) -> Result<BoutsDone> {
    let mut waiting = BTreeMap::new();
    // Threads make bouts in any order: work is counted as if one had been made after the other.
    count_work(MOTION * done.effort.motions as usize);
    'bouts: while done.touches < wanted {
        let Some((number, bout)) = bouts.next().filter(|_| !deadline.has_passed()) else { break };
        waiting.insert(number, bout);
        while let Some(bout) = waiting.remove(&done.bouts) {
            let bout = bout?;
            for (k, touch) in bout.touches.iter().enumerate() {
                receive(Made::Touch(touch))?;
                done.touches += 1;
                if done.touches >= wanted {
                    done.effort += bout.so_far[k];
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
            receive(Made::Bout(done))?;
            if deadline.has_passed() {
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
    fn gathered(order: &[(u64, u64)], wanted: usize) -> (Vec<u64>, BoutsDone) {
        let mut bouts = order.iter().map(|&(number, touches)| (number, Ok(bout(number, touches))));
        let mut received = Vec::new();
        let receive = &mut |made: Made| {
            if let Made::Touch(touch) = made {
                received.push(touch.bout);
            }
            Ok(())
        };
        let done = gather(&mut bouts, BoutsDone::default(), wanted, (3, Deadline::Never), receive);
        (received, done.expect("no bout fails"))
    }

    #[test]
    fn bouts_made_in_any_order_are_handed_on_in_theirs_up_to_the_last_touch_wanted() {
        for order in [[(0, 2), (1, 3), (2, 2)], [(2, 2), (0, 2), (1, 3)]] {
            let (received, done) = gathered(&order, 4);
            assert_eq!(received, [0, 0, 1, 1]);
            // The first bout took 5 motions; the second touch of the next one came with its fourth.
            assert_eq!((done.bouts, done.touches, done.effort.motions), (1, 4, 9));
        }
    }

    #[test]
    fn nothing_is_handed_on_after_a_gap_and_fruitless_bouts_end_it() {
        assert_eq!(gathered(&[(0, 1), (2, 5)], 10).0, [0]);
        let (received, done) = gathered(&[(0, 0), (1, 0), (2, 0), (3, 1)], 1);
        assert_eq!((received.len(), done.bouts), (0, 3));
    }
}
