//! What a posture means for other receptors: "given a proprioceptive input, together with input from a certain touch
//! receptor to a corresponding particular posture, the body schema can predict proprioceptive sensor consequences for
//! other touch receptors" (IVA 2009, section 3.1).

use nalgebra::{Matrix3, Vector3};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

use super::collision::CollisionChecker;
use super::own_body::OwnBody;
use crate::creature::Posture;
use crate::kinematics::{Chain, InverseKinematics, Reach};

/// Postures that solutions start from, for each receptor: the present one, then random ones.
const STARTS: usize = 8;

/// Where something is expected, in a limb's frame.
#[derive(Clone, Debug, PartialEq)]
pub struct Predicted {
    /// The point, metres.
    pub point: Vector3<f64>,
    /// The outward normal there.
    pub normal: Vector3<f64>,
    /// Its covariance, m²; none where the touches bound it in no way.
    pub covariance: Option<Matrix3<f64>>,
}

/// A receptor that could meet another, and how.
#[derive(Clone, Debug, PartialEq)]
pub struct PossibleTouch {
    /// The receptor.
    pub receptor: usize,
    /// The posture in which it does, and how well.
    pub reach: Reach,
}

impl OwnBody {
    /// Where a receptor is in the frame of another limb, at a posture.
    pub fn predict(&self, receptor: usize, limb: usize, posture: &[f64]) -> Predicted {
        let place = self.place(receptor);
        let frames = self.frames(posture);
        let relative = frames[limb].inverse() * frames[place.limb];
        Predicted {
            point: relative.point(&place.point),
            normal: relative.rotation * place.direction,
            covariance: self.covariance(posture, [place.limb, limb], &place.point),
        }
    }

    /// The receptors of a limb that could meet a receptor, and the joint angles at which they would, best first: those
    /// whose normals are opposed where the points meet. Joints stay near `posture` where they can; with `clearance`,
    /// postures in which other limbs would be in each other are left out.
    pub fn could_meet(
        &self,
        receptor: usize,
        limb: usize,
        posture: &[f64],
        clearance: Option<&CollisionChecker>,
    ) -> Vec<PossibleTouch> {
        let felt = self.place(receptor);
        let mut meetings: Vec<PossibleTouch> = Vec::new();
        if felt.limb == limb {
            return meetings;
        }
        let mut rng = ChaCha8Rng::seed_from_u64(0);
        let mut starts = vec![Posture::from(posture)];
        let between: Vec<usize> = Chain::between(self.creature(), limb, felt.limb).joints().collect();
        starts.resize_with(STARTS, || self.random_posture(posture, &between, &mut rng));
        let met = [limb, felt.limb];
        for other in self.receptors_on(&[limb]) {
            let ends = [self.place(other), felt];
            let mut solver = InverseKinematics::new(self.creature(), &self.schema, ends).at_ease(posture);
            let found = starts.iter().map(|start| solver.solve(start)).find(|reach| {
                let parted = |clearance: &CollisionChecker| {
                    clearance.free_but(&self.frames(&reach.posture), 0.0, &[met])
                };
                reach.reached() && reach.facing < 0.0 && clearance.is_none_or(parted)
            });
            meetings.extend(found.map(|reach| PossibleTouch { receptor: other, reach }));
        }
        meetings.sort_by(|a, b| a.reach.facing.total_cmp(&b.reach.facing));
        meetings
    }
}
