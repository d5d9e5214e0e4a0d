//! Where limbs are, and how surely.

use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

use super::{Growth, has_axes};
use crate::creature::{Creature, Posture};
use crate::kinematics::{Chain, limb_frames};
use crate::learning::observability::miss_jacobian;
use crate::skin::Receptor;

/// A limb whose skin may be off by less, one standard deviation, is placed, metres: near enough for its touches to
/// find the right minimum.
pub(super) const PLACED: f64 = 5e-3;
/// Postures in which placement is looked at.
const POSTURES: usize = 2;
/// Seed of these postures.
const POSTURE_SEED: u64 = 3;

impl Growth {
    /// Works out how far off the skin of each limb may be in the frame of the base: the most of three receptors, joints
    /// that are not known at rest.
    pub(super) fn place(&mut self) {
        let creature = self.agent.creature();
        let Some(belief) = &self.belief else {
            self.placement.fill(f64::INFINITY);
            return;
        };
        let mut rng = ChaCha8Rng::seed_from_u64(POSTURE_SEED);
        let postures: Vec<Posture> = (0..POSTURES)
            .map(|_| {
                let mut posture = Posture::random(creature, &mut rng);
                let unknown = |joint: &usize| !self.resolved[*joint];
                (0..self.resolved.len())
                    .filter(unknown)
                    .for_each(|joint| rest(creature, joint, &mut posture));
                posture
            })
            .collect();
        let frames: Vec<_> =
            postures.iter().map(|posture| limb_frames(creature, &belief.schema, posture)).collect();
        let deviation = |limb: usize, receptor: &Receptor, at: usize| {
            let chain = Chain::between(creature, limb, self.base);
            let p_b = frames[at][self.base].inverse_point(&frames[at][limb].point(&receptor.position));
            let points = [receptor.position, p_b];
            let jacobian =
                miss_jacobian(&belief.parameters, creature, &belief.schema, &chain, &postures[at], points);
            // A chain moves few of the parameters.
            let moved: Vec<usize> =
                (0..jacobian.ncols()).filter(|&column| jacobian.column(column).amax() > 0.0).collect();
            let jacobian = jacobian.select_columns(&moved);
            let covariance = belief.covariance.select_rows(&moved).select_columns(&moved);
            (&jacobian * covariance * jacobian.transpose()).trace().max(0.0).sqrt()
        };
        let placement = (0..creature.limbs().len()).map(|limb| {
            let on_limb: Vec<&Receptor> =
                self.agent.skin().receptors.iter().filter(|receptor| receptor.limb == limb).collect();
            let chain = Chain::between(creature, limb, self.base);
            let unknown = |joint: usize| belief.parameters.positions[joint].is_none();
            if on_limb.is_empty() || chain.joints().any(unknown) {
                return f64::INFINITY;
            }
            if limb == self.base {
                return 0.0;
            }
            let three = [0, on_limb.len() / 2, on_limb.len() - 1];
            let each = three.iter().flat_map(|&i| (0..POSTURES).map(move |at| (i, at)));
            each.map(|(i, at)| deviation(limb, on_limb[i], at)).fold(0.0, f64::max)
        });
        self.placement = placement.collect();
    }
}

/// Puts a joint at rest, as near to zero as its range has it; a ball, which has no axes, stays as it is.
pub fn rest(creature: &Creature, joint: usize, posture: &mut [f64]) {
    if has_axes(creature, joint) {
        for at in creature.joints()[joint].elements().filter(|at| !at.is_ball()) {
            posture[at.coordinate()] = 0f64.clamp(at.range[0], at.range[1]);
        }
    }
}
