//! Putting a hand to a spot of one's own skin.

use super::actor::Actor;
use super::tasks::Trouble;
use crate::peripersonal::{OutOfReach, ReachTarget};
use crate::senses::SkinContact;

/// How far before the shoulder of the other arm a spot of an arm is brought to be touched, metres, …
const PRESENTED: f64 = 0.3;
/// … and what it is worth in metres that it faces that hand.
const FACING: f64 = 0.15;

/// A spot that was touched with a hand.
#[derive(Clone, Debug, PartialEq)]
pub struct OwnTouch {
    /// The hand, an index into [`Actor::hands`].
    pub hand: usize,
    /// The receptor that feels it.
    pub felt: usize,
    /// How far that one's centre is from the spot that was meant, metres.
    pub off: f64,
}

impl Actor {
    /// Puts a hand to a receptor, the one that is named or either: never the hand of the arm that it is on; where both can, the
    /// one on its side.
    ///
    /// # Errors
    /// [`Trouble`] of the last hand that was tried; [`OutOfReach::Barred`] where it is the hand of the same arm.
    pub fn touch_own(&mut self, receptor: usize, by: Option<usize>) -> Result<OwnTouch, Trouble> {
        let (point, normal) = self.feels_at(receptor);
        let limb = self.own.skin().receptors[receptor].limb;
        let own_side = self.hand_towards(&point);
        let hands = match self.arm_of(receptor) {
            Some(arm) => vec![1 - arm],
            None => vec![own_side, 1 - own_side],
        };
        let mut trouble = Trouble::Reach(OutOfReach::Barred);
        for hand in hands.into_iter().filter(|hand| by.is_none_or(|by| by == *hand)) {
            let aim = ReachTarget { point, direction: -normal };
            let (arm, receptors) = (self.hands[hand].arm.clone(), self.hands[hand].receptors.clone());
            let from = self.posture();
            let plan = match self.reaching(arm).meeting(limb).approach(&from, &receptors, &aim) {
                Ok(plan) => plan,
                Err(reason) => {
                    trouble = reason.into();
                    continue;
                }
            };
            let contacts = self.approach(&plan)?;
            trouble = match self.met(&contacts, hand, receptor) {
                Some(touch) => return Ok(touch),
                None if contacts.is_empty() => Trouble::Nothing,
                None => Trouble::Hit(contacts),
            };
        }
        Err(trouble)
    }

    /// Brings a receptor of an arm to where the other hand reaches it: before that hand's shoulder, facing it. Whether there
    /// was such a posture.
    ///
    /// # Errors
    /// [`Trouble`] on the way.
    pub(super) fn present(&mut self, receptor: usize) -> Result<bool, Trouble> {
        let Some(arm) = self.arm_of(receptor) else { return Ok(false) };
        let joints = self.hands[arm].arm.clone();
        let place = self.own.place(receptor);
        let shoulder = self.frames()[self.hands[1 - arm].arm[0] + 1].origin;
        let wanted = shoulder + self.front * PRESENTED;
        let facing = (self.front + self.left() * self.side(1 - arm)).normalize();
        let best = self.best_drawn(&joints, |_, frames| {
            let frame = &frames[place.limb];
            let (point, normal) = (frame.point(&place.point), frame.rotation * place.direction);
            FACING * normal.dot(&facing) - (point - wanted).norm()
        });
        let Some(posture) = best else { return Ok(false) };
        self.go(&posture)?;
        Ok(true)
    }

    /// What of a hand's touches of one's own skin is nearest to a spot on the same limb.
    fn met(&self, contacts: &[SkinContact], hand: usize, receptor: usize) -> Option<OwnTouch> {
        let skin = &self.own.skin().receptors;
        let spot = &skin[receptor];
        let touches = contacts.iter().flat_map(SkinContact::felt).filter_map(|(by, toucher)| {
            let felt = toucher.own()?;
            let meant = self.hands[hand].receptors.contains(&by.receptor) && felt.limb == spot.limb;
            let off = (skin[felt.receptor].position - spot.position).norm();
            meant.then_some(OwnTouch { hand, felt: felt.receptor, off })
        });
        touches.min_by(|a, b| a.off.total_cmp(&b.off))
    }
}
