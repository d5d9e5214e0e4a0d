//! Leaning the trunk forward, and back upright.

use super::actor::Actor;
use super::tasks::Trouble;
use crate::creature::Posture;
use crate::geometry::Frame;
use crate::peripersonal::OutOfReach;

/// Shares of the farthest that it leans, the first that keeps clear.
const SHARES: [f64; 6] = [1.0, 0.85, 0.7, 0.5, 0.35, 0.2];
/// How clear of everything it stays, metres, …
const CLEAR: f64 = 0.01;
/// … and postures of the arms that are drawn for it.
const DRAWN: usize = 60;

/// The least gain for which a joint of the trunk is bent, metres.
const GAIN: f64 = 1e-3;

impl Actor {
    /// The joints of the trunk that carry both hands.
    pub(super) fn trunk(&self) -> Vec<usize> {
        let [a, b] = &self.hands;
        a.leaning.iter().copied().filter(|joint| b.leaning.contains(joint)).collect()
    }

    /// How far forward the shoulders are on average, in the root's frame, metres.
    fn shoulders_forward(&self, frames: &[Frame]) -> f64 {
        let of = |hand: usize| frames[self.hands[hand].arm[0] + 1].origin.dot(&self.front);
        0.5 * (of(0) + of(1))
    }

    /// A posture with the trunk bent joint by joint from the hips, each to the end of its range where a distance is greatest,
    /// metres. A joint that gains nothing stays.
    pub(super) fn bent(&self, from: &[f64], distance: impl Fn(&[Frame]) -> f64) -> Posture {
        let mut bent = Posture::from(from);
        for joint in self.trunk() {
            let joint = &self.own.creature().joints()[joint];
            for at in joint.elements().filter(|at| !at.is_ball() && at.follows.is_none()) {
                let q = at.coordinate();
                let far = |value: f64| {
                    let mut posture = bent.clone();
                    posture[q] = value;
                    distance(&self.own.frames(&posture))
                };
                let [low, high] = at.range.map(far);
                if low.max(high) > far(bent[q]) + GAIN {
                    bent[q] = at.range[usize::from(high > low)];
                }
            }
        }
        self.own.creature().couple(&mut bent);
        bent
    }

    /// Leans forward as far as it keeps clear of itself and of what it knows; by how far its shoulders came forward, metres.
    ///
    /// # Errors
    /// [`Trouble`] where it cannot, or meets something.
    pub(super) fn lean_forward(&mut self) -> Result<f64, Trouble> {
        let from = self.posture();
        let bent = self.bent(&from, |frames| self.shoulders_forward(frames));
        let before = self.shoulders_forward(&self.frames());
        let Some(leaning) = self.leaning_towards(&from, &bent) else { return Err(OutOfReach::Barred.into()) };
        self.go(&leaning)?;
        Ok(self.shoulders_forward(&self.frames()) - before)
    }

    /// A posture with the trunk as far on the way to a bent one as there are postures of the arms that keep clear: as they
    /// are, at ease, or drawn.
    fn leaning_towards(&mut self, from: &[f64], bent: &[f64]) -> Option<Posture> {
        let mut rng = self.new_rng();
        let arms = self.arms();
        let ease = self.own.at_ease();
        let creature = self.own.creature();
        for share in SHARES {
            let trunk = Posture::between(creature, from, bent, share);
            let with_ease = Posture::with_joints(creature, &trunk, arms.iter().copied(), &ease);
            let drawn = (0..DRAWN).map(|_| self.own.random_posture(&trunk, &arms, &mut rng));
            let mut all = [trunk.clone(), with_ease].into_iter().chain(drawn);
            if let Some(found) = all.find(|posture| self.clearance.free(&self.own.frames(posture), CLEAR)) {
                return Some(found);
            }
        }
        None
    }

    /// Whether the trunk is not as it is in a posture.
    pub(super) fn leans_from(&self, upright: &[f64]) -> bool {
        let now = self.posture();
        let off = |joint: usize| {
            self.own.creature().joints()[joint].coordinates().any(|q| (now[q] - upright[q]).abs() > 1e-3)
        };
        self.trunk().into_iter().any(off)
    }
}
