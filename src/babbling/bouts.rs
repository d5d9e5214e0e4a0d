//! Bouts: made in any order, handed on in theirs; and how far a session of them has come.

use std::collections::BTreeMap;
use std::sync::mpsc;

use super::BabblingError;
use crate::learning::growth::Growth;
use crate::senses::Touch;
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
    /// The end of a bout: all touches up to here are handed on.
    Bout(BoutsDone),
    /// What a policy has learned of all touches up to here.
    Grown(&'a Growth),
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

/// Puts the bouts that follow on `done` back into order and hands their touches on, until so many are there in all.
/// Returns how many there are and what they cost up to the last of them, with those before; there may be none.
pub(super) fn gather<E>(
    bouts: &mpsc::Receiver<(u64, EngineResult<Bout>)>,
    mut done: BoutsDone,
    wanted: usize,
    fruitless_bouts: u64,
    receive: &mut impl FnMut(Made) -> Result<(), E>,
) -> Result<BoutsDone, BabblingError<E>> {
    let mut waiting = BTreeMap::new();
    'bouts: while done.touches < wanted {
        let Ok((number, bout)) = bouts.recv() else { break };
        waiting.insert(number, bout);
        while let Some(bout) = waiting.remove(&done.bouts) {
            let bout = bout.map_err(BabblingError::Engine)?;
            for (touch, so_far) in &bout.touches {
                receive(Made::Touch(touch)).map_err(BabblingError::Receiver)?;
                done.touches += 1;
                if done.touches == wanted {
                    done.effort += *so_far;
                    return Ok(done);
                }
            }
            done.effort += bout.effort;
            if !bout.is_whole {
                break 'bouts;
            }
            done.bouts += 1;
            if done.touches == 0 && done.bouts >= fruitless_bouts {
                break 'bouts;
            }
            receive(Made::Bout(done)).map_err(BabblingError::Receiver)?;
        }
    }
    Ok(done)
}
