//! What was touched, how often, and where to find it again without any schema.
//!
//! Whether two limbs touch depends on the joints between them alone. So a touch is found again by giving
//! these joints the angles that they had, and a little more of the motion that led there; all other joints
//! may do what they like, and bring new touches on the way.

use std::collections::BTreeMap;

use nalgebra::Vector3;
use rand::RngExt;
use rand_chacha::ChaCha8Rng;

use super::wide::wide_posture;
use crate::agent::Agent;
use crate::creature::turn_ball;
use crate::creature::{DofKind, Posture};
use crate::kinematics::Chain;
use crate::senses::Touch;

/// How far beyond a touch its revisit aims, in the coordinate that moves most: radians or metres.
const BEYOND: f64 = 0.15;
/// The scatter of revisits in shares of the ranges: at first, least, most.
const SCATTER: [f64; 3] = [0.12, 0.02, 0.4];
/// The share of touching motions that the scatter is steered to: a motion that touches widens it by the
/// smaller step, one that does not narrows it by the larger.
const WIDER: f64 = 1.05;
const NARROWER: f64 = 0.85;

/// Revisits that are weighed up before each motion.
const CANDIDATES: usize = 8;
/// Weight of a revisit that presses on where it touches already.
const PRESSING: f64 = 0.05;

/// How often a pair of limbs touched, and how often that was tried.
#[derive(Clone, Copy, Debug, Default)]
pub struct PairTally {
    /// Touches, wanted or not.
    pub touches: f64,
    /// Motions and plans that aimed at the pair.
    pub tries: f64,
    /// Those that met it.
    pub hits: f64,
}

impl PairTally {
    /// The share of tries that will meet the pair, as far as is known; 1 before the first.
    pub fn success(&self) -> f64 {
        (self.hits + 1.0) / (self.tries + 1.0)
    }
}

/// A touch that can be found again.
struct Remembered {
    /// The joints between the limbs.
    joints: Vec<usize>,
    /// The posture a little beyond the touch.
    beyond: Posture,
    /// The direction of the motion that led there, per coordinate.
    approach: Vec<f64>,
}

/// All that was touched.
pub struct Experience<'a> {
    agent: &'a Agent,
    /// Per pair of limbs that both have skin and do not carry one another, the lesser first.
    pub pairs: BTreeMap<[usize; 2], PairTally>,
    /// Per joint, the touches with it between the limbs.
    pub joint_touches: Vec<f64>,
    /// Per receptor, its touches.
    pub receptor_touches: Vec<u32>,
    /// Per limb, its receptors.
    pub receptors: Vec<Vec<usize>>,
    remembered: Vec<Remembered>,
    scatter: f64,
    /// Where the present motion began, and which touch it revisits.
    start: Posture,
    revisited: Option<usize>,
    /// Whether it stands where it last touched.
    in_contact: bool,
}

impl<'a> Experience<'a> {
    /// No experience yet.
    pub fn new(agent: &'a Agent) -> Experience<'a> {
        let creature = agent.creature();
        let mut receptors = vec![Vec::new(); creature.limbs().len()];
        for (r, receptor) in agent.skin().receptors.iter().enumerate() {
            receptors[receptor.limb].push(r);
        }
        let mut pairs = BTreeMap::new();
        for a in 0..receptors.len() {
            for b in a + 1..receptors.len() {
                let skinned = !receptors[a].is_empty() && !receptors[b].is_empty();
                if skinned && !creature.neighbouring(a, b) {
                    pairs.insert([a, b], PairTally::default());
                }
            }
        }
        Experience {
            agent,
            pairs,
            joint_touches: vec![0.0; creature.joints().len()],
            receptor_touches: vec![0; agent.skin().receptors.len()],
            receptors,
            remembered: Vec::new(),
            scatter: SCATTER[0],
            start: Posture::default(),
            revisited: None,
            in_contact: false,
        }
    }

    /// Says that a motion begins in `posture`.
    pub fn begin(&mut self, posture: &[f64]) {
        self.start = posture.into();
        self.revisited = None;
    }

    /// A target that finds a remembered touch again, roughly; a random posture while there is none.
    /// Call [`Experience::begin`] before.
    pub fn revisit(&mut self, rng: &mut ChaCha8Rng) -> Posture {
        if self.remembered.is_empty() {
            return wide_posture(self.agent.creature(), rng);
        }
        let mut best: Option<(f64, usize, Posture)> = None;
        for _ in 0..CANDIDATES {
            let (index, target) = self.draw(rng);
            let parting = self.parting(&target);
            let value =
                self.need(&self.remembered[index].joints) * if parting > 0.0 { 1.0 } else { PRESSING };
            if best.as_ref().is_none_or(|(most, ..)| value > *most) {
                best = Some((value, index, target));
            }
        }
        let (_, index, target) = best.expect("several are drawn");
        self.revisited = Some(index);
        target
    }

    /// How seldom a chain's joints were between limbs that touched: the mean over its degrees of freedom of
    /// each joint's own degrees of freedom to its touches. It needs no schema, and evens out what the
    /// joints get; where it is even, a right schema is found from the fewest touches.
    pub fn need(&self, joints: &[usize]) -> f64 {
        let dofs = |j: usize| self.agent.creature().joints()[j].dofs.len() as f64;
        let all = joints.iter().map(|&j| dofs(j)).sum::<f64>();
        joints.iter().map(|&j| dofs(j) * dofs(j) / (self.joint_touches[j] + 1.0)).sum::<f64>() / all.max(1.0)
    }

    /// The same of the chain between two limbs.
    pub fn need_between(&self, limbs: [usize; 2]) -> f64 {
        let joints: Vec<usize> = Chain::between(self.agent.creature(), limbs[0], limbs[1]).joints().collect();
        self.need(&joints)
    }

    /// How much a motion to `target` undoes the motion that led to the present touch; 1 in free space.
    pub fn parting(&self, target: &[f64]) -> f64 {
        let Some(last) = self.remembered.last().filter(|_| self.in_contact) else { return 1.0 };
        let coordinates = self.coordinates_of(&last.joints);
        coordinates.map(|q| -(target[q] - self.start[q]) * last.approach[q]).sum()
    }

    fn draw(&self, rng: &mut ChaCha8Rng) -> (usize, Posture) {
        let index = rng.random_range(0..self.remembered.len());
        let touch = &self.remembered[index];
        let mut target = wide_posture(self.agent.creature(), rng);
        for &j in &touch.joints {
            let joint = &self.agent.creature().joints()[j];
            for at in joint.elements() {
                let ([low, high], q) = (at.range, at.coordinate());
                match at.kind {
                    DofKind::Ball => {
                        at.of_mut(&mut target).copy_from_slice(at.of(&touch.beyond));
                        let scatter = self.scatter * high.min(1.0);
                        let turn = Vector3::from_fn(|_, _| rng.random_range(-scatter..=scatter));
                        turn_ball(at.of_mut(&mut target), &turn, high);
                    }
                    DofKind::Hinge | DofKind::Slide => {
                        let scatter = self.scatter * (high - low);
                        target[q] = (touch.beyond[q] + rng.random_range(-scatter..=scatter)).clamp(low, high);
                    }
                }
            }
        }
        (index, target)
    }

    /// Takes in how the motion begun last ended: at a touch, or at none in `posture`.
    pub fn ended(&mut self, touch: Option<&Touch>) {
        if self.revisited.is_some() {
            let factor = if touch.is_some() { WIDER } else { NARROWER };
            self.scatter = (self.scatter * factor).clamp(SCATTER[1], SCATTER[2]);
        }
        let Some(touch) = touch else { return };
        self.in_contact = true;
        let limbs = touch.ends.map(|end| self.agent.skin().receptors[end.receptor].limb);
        for end in &touch.ends {
            self.receptor_touches[end.receptor] += 1;
        }
        if let Some(tally) = self.pairs.get_mut(&limbs) {
            tally.touches += 1.0;
        }
        let joints: Vec<usize> = Chain::between(self.agent.creature(), limbs[0], limbs[1]).joints().collect();
        joints.iter().for_each(|&j| self.joint_touches[j] += 1.0);
        let mut approach = vec![0.0; touch.posture.len()];
        let mut longest = 1e-9f64;
        for q in self.coordinates_of(&joints) {
            let before = self.start.get(q).copied().unwrap_or(touch.posture[q]);
            approach[q] = touch.posture[q] - before;
            longest = longest.max(approach[q].abs());
        }
        let mut beyond = touch.posture.clone();
        for &j in &joints {
            let joint = &self.agent.creature().joints()[j];
            for at in joint.elements().filter(|at| !at.is_ball()) {
                let q = at.coordinate();
                let further = beyond[q] + approach[q] * (BEYOND / longest);
                beyond[q] = further.clamp(at.range[0], at.range[1]);
            }
        }
        self.remembered.push(Remembered { joints, beyond, approach });
    }

    /// Says that the motion ended in free space.
    pub fn freed(&mut self) {
        self.in_contact = false;
    }

    /// The tally of a pair of limbs, the lesser first.
    pub fn tally(&self, limbs: [usize; 2]) -> PairTally {
        self.pairs.get(&limbs).copied().unwrap_or_default()
    }

    fn coordinates_of<'s>(&'s self, joints: &'s [usize]) -> impl Iterator<Item = usize> + 's {
        joints.iter().flat_map(|&joint| self.agent.creature().joints()[joint].coordinates())
    }
}
