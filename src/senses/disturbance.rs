//! What is wrong with an agent's senses: joint angles read inexactly, receptors that are not where the
//! agent believes them, touches felt where there was none.
//!
//! Babbling is exact and so is its log. Disturbances come between the two and the learner: they turn the
//! touches that were made into those that the agent feels, and its skin into the skin that it believes in.

use nalgebra::{UnitQuaternion, Vector3};
use rand::{Rng, RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

use crate::agent::Agent;
use crate::creature::{DofKind, ball};
use crate::geometry::wxyz;
use crate::senses::{FeltPoint, Input, RecordedTouch, Touch, TouchEnd};
use crate::skin::Skin;

/// Random streams of the session's seed, one per disturbance, so that none changes what another draws.
/// Bouts of babbling and initial guesses count from 0 and never get here.
const JOINT_STREAM: u64 = u64::MAX;
const RECEPTOR_STREAM: u64 = u64::MAX - 1;
const FALSE_TOUCH_STREAM: u64 = u64::MAX - 2;
// u64::MAX - 3 makes the gaps of a test, u64::MAX - 4 is the learner's.
const POINT_STREAM: u64 = u64::MAX - 5;

/// How much is wrong with an agent's senses; nothing by default.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Disturbances {
    /// Standard deviation of a joint angle as the agent reads it, radians, anew in every touch. A ball is
    /// turned by a random rotation vector of this deviation per coordinate. Slides are read exactly: a
    /// deviation in radians says nothing about them.
    pub joint_noise: f64,
    /// Standard deviation, per coordinate of the limb's frame, of how far a receptor and the surface under
    /// it are from where the agent believes them, metres. Drawn once: it is the same in every touch.
    pub receptor_noise: f64,
    /// Share of touches of which one end is reported by a receptor that has nothing to do with it, 0 to 1.
    pub false_touches: f64,
    /// Standard deviation of each coordinate of a point of contact, metres, anew at both ends of every touch.
    pub point_noise: f64,
}

/// What an agent with disturbed senses has to learn from.
#[derive(Clone, Debug, PartialEq)]
pub struct DisturbedSenses {
    /// The touches as it feels them, in the order in which they were made.
    pub touches: Vec<Touch>,
    /// The agent that feels them, with the skin that it believes in: the same receptors in the same order,
    /// displaced.
    pub agent: Agent,
}

impl Disturbances {
    /// Whether nothing is disturbed.
    pub fn is_none(&self) -> bool {
        *self == Disturbances::default()
    }

    /// What the agent feels of `touches` through a kind of skin, and believes of its `skin`; the same for the same seed,
    /// and the first touches are felt alike however many come after them.
    pub fn felt(&self, agent: &Agent, touches: &[RecordedTouch], input: Input, seed: u64) -> DisturbedSenses {
        let stream = |number: u64| {
            let mut rng = ChaCha8Rng::seed_from_u64(seed);
            rng.set_stream(number);
            rng
        };
        let (skin, creature) = (agent.skin(), agent.creature());
        let mut touches: Vec<Touch> = touches.iter().map(|touch| touch.felt(input)).collect();
        let mut felt_by = agent.clone();
        if self.false_touches > 0.0 {
            let mut rng = stream(FALSE_TOUCH_STREAM);
            touches.iter_mut().for_each(|touch| self.confuse(skin, touch, &mut rng));
        }
        if self.joint_noise > 0.0 {
            let mut rng = stream(JOINT_STREAM);
            for touch in &mut touches {
                for at in creature.elements().filter(|at| at.kind != DofKind::Slide) {
                    misread(at.of_mut(&mut touch.posture), at.kind, self.joint_noise, &mut rng);
                }
            }
        }
        if self.receptor_noise > 0.0 {
            let mut skin = skin.clone();
            let displacements = self.displace(&mut skin, &mut stream(RECEPTOR_STREAM));
            felt_by = agent.with_skin(skin).expect("displaced receptors are on the limbs that they were on");
            for end in touches.iter_mut().flat_map(|touch| &mut touch.ends) {
                end.point.iter_mut().for_each(|point| point.position += displacements[end.receptor]);
            }
        }
        let points = touches.iter_mut().flat_map(|touch| &mut touch.ends).flat_map(|end| &mut end.point);
        if self.point_noise > 0.0 {
            let mut rng = stream(POINT_STREAM);
            points.for_each(|point| point.position += vector(self.point_noise, &mut rng));
        }
        DisturbedSenses { touches, agent: felt_by }
    }

    /// Displaces every receptor along with a surface of its own, and tells by how much.
    fn displace(&self, skin: &mut Skin, rng: &mut impl Rng) -> Vec<Vector3<f64>> {
        let surfaces = std::mem::take(&mut skin.surfaces);
        let displace = |receptor: &mut crate::skin::Receptor| {
            let displacement = vector(self.receptor_noise, rng);
            receptor.position += displacement;
            receptor.surface = receptor.surface.map(|shared| {
                let mut own = surfaces[shared].clone();
                own.origin += displacement;
                skin.surfaces.push(own);
                skin.surfaces.len() - 1
            });
            displacement
        };
        skin.receptors.iter_mut().map(displace).collect()
    }

    /// With the probability asked for, replaces one end of a touch by a receptor drawn from the whole skin
    /// but the other end's limb. A skin on a single limb has none such, and its touches stay as they are.
    fn confuse(&self, skin: &Skin, touch: &mut Touch, rng: &mut impl Rng) {
        // The draws come first and are always the same number, so that a greater share only adds to the
        // touches that are false with a lesser one.
        let (chance, end, place) =
            (rng.random::<f64>(), usize::from(rng.random::<bool>()), rng.random::<f64>());
        if chance >= self.false_touches {
            return;
        }
        let limb = |end: &TouchEnd| skin.receptors[end.receptor].limb;
        let stays = limb(&touch.ends[1 - end]);
        let elsewhere =
            || (0..skin.receptors.len()).filter(|&receptor| skin.receptors[receptor].limb != stays);
        let number = (place * elsewhere().count() as f64) as usize;
        let Some(receptor) = elsewhere().nth(number) else { return };
        let position = skin.receptors[receptor].position;
        let point = touch.ends[end].point.map(|_| FeltPoint { position, deviation: None });
        touch.ends[end] = TouchEnd { receptor, point };
        if limb(&touch.ends[0]) > limb(&touch.ends[1]) {
            touch.ends.swap(0, 1);
        }
    }
}

/// Adds noise to the coordinates of one degree of freedom, which come first; a ball is turned by a random rotation vector.
pub(super) fn misread(coordinates: &mut [f64], kind: DofKind, deviation: f64, rng: &mut impl Rng) {
    if kind != DofKind::Ball {
        coordinates[0] += normal(deviation, rng);
        return;
    }
    let turned = ball(coordinates) * UnitQuaternion::from_scaled_axis(vector(deviation, rng));
    coordinates[..4].copy_from_slice(&wxyz(&turned));
}

fn normal(deviation: f64, rng: &mut impl Rng) -> f64 {
    let standard: f64 = StandardNormal.sample(rng);
    deviation * standard
}

fn vector(deviation: f64, rng: &mut impl Rng) -> Vector3<f64> {
    Vector3::from_fn(|_, _| normal(deviation, rng))
}
