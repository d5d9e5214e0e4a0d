//! Touching oneself so exactly that a learner can go by it: once swiftly, then again, slowly.

use super::Trouble;
use crate::creature::Posture;
use crate::interaction::actor::{Actor, SWIFT};
use crate::peripersonal::PosturePath;
use crate::senses::SkinContact;

/// How many steps back he goes from a touch to come again, and how fast the tips of the hands then go, metres a second: in
/// the end a hundredth of a millimetre a step.
const AGAIN: [(usize, f64); 2] = [(12, 0.05), (6, 0.005)];
/// How many steps of the way back he then leaves it by, so that what touched is clear.
const LEAVING: usize = 60;

impl Actor {
    /// Goes straight to a posture until contacts tell something; what they tell after he has come once more, slowly, and more
    /// slowly, and the posture then. It counts only where he was clear of it before he came again: no contact that `touches`
    /// says is one of it. He goes back from whatever he met.
    ///
    /// # Errors
    /// Where the engine fails.
    pub(super) fn touch_exactly<T>(
        &mut self,
        target: &Posture,
        touches: impl Fn(&Actor, &SkinContact) -> bool,
        told: impl Fn(&Actor, &[SkinContact]) -> Option<T>,
    ) -> Result<Option<(T, Posture)>, Trouble> {
        let mut since = self.steps;
        let way = PosturePath(vec![target.clone()]);
        let contacts = self.follow(&way, SWIFT, |_, _| true)?;
        if contacts.is_empty() {
            return Ok(None);
        }
        let leaving = self.lately(since).take(LEAVING).cloned().collect();
        let mut touch = told(self, &contacts);
        for (steps, speed) in AGAIN {
            if touch.is_none() {
                break;
            }
            let met = self.posture();
            let back: Vec<Posture> = self.lately(since).take(steps).cloned().collect();
            let Some(before) = back.last() else { break };
            self.follow(&PosturePath(vec![before.clone()]), SWIFT, |_, _| false)?;
            // What is still in what it met would be felt on coming again long after it touched.
            if self.wait(0.0)?.iter().any(|contact| touches(self, contact)) {
                touch = None;
                break;
            }
            since = self.steps;
            let contacts = self.follow(&PosturePath(vec![met]), speed, |_, _| true)?;
            touch = told(self, &contacts);
        }
        let posture = self.posture();
        self.follow(&PosturePath(leaving), SWIFT, |_, _| false)?;
        Ok(touch.map(|touch| (touch, posture)))
    }
}
