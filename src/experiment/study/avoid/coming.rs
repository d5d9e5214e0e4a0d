//! What comes: a thing on a straight way that a creature that holds still would be hit by.

use nalgebra::{Isometry3, Point3, Translation3, UnitQuaternion, Vector3};
use rand::RngExt;
use rand::seq::IndexedRandom;
use rand_chacha::ChaCha8Rng;

use super::super::at_table::{OnStage, THING};
use crate::creature::Posture;
use crate::experiment::ExperimentError;
use crate::geometry::Shape;
use crate::senses::Toucher;
use crate::simulation::{ProbePath, Substance, Thing};

/// Draws of a way until there is one that meets the limb that it aims at first.
const DRAWS: usize = 400;
/// How fast a way is tried, metres a second.
const TRIED: f64 = 2.5;
/// How far things go on beyond where they aim, metres.
pub(super) const BEYOND: f64 = 0.5;
/// From how far they come at least, metres.
const NEAREST: f64 = 0.7;

/// A thing and how it comes, which every creature of a trial meets alike.
pub(super) struct Coming {
    /// The aura limb that it aims at.
    pub aimed: usize,
    pub posture: Posture,
    pub shape: Shape,
    /// How it is turned in the world.
    pub turn: UnitQuaternion<f64>,
    /// Where it sets out and where it ends, in the world, metres.
    pub ends: [Vector3<f64>; 2],
    /// Metres a second.
    pub speed: f64,
    /// The limbs that it would meet.
    pub met: Vec<usize>,
}

impl Coming {
    /// Its way from a time on, at a speed of metres a second.
    pub fn path(&self, time: f64, speed: f64) -> ProbePath {
        let seconds = (self.ends[1] - self.ends[0]).norm() / speed;
        ProbePath(vec![(time, self.ends[0]), (time + seconds, self.ends[1])])
    }
}

/// A thing of a random shape of 2 to 5 cm half size, and what kind that is.
pub(super) fn thing(rng: &mut ChaCha8Rng) -> (Thing, &'static str) {
    let mut size = || rng.random_range(0.02..0.05);
    let (a, b, c) = (size(), size(), size());
    let (shape, kind) = match rng.random_range(0..3) {
        0 => (Shape::Sphere { radius: a }, "sphere"),
        1 => (Shape::Box { half_extents: [a, b, c] }, "box"),
        // As long as it is wide at least, 5 cm half at most.
        _ => {
            let radius = 0.5 * a.min(b) + 0.01;
            (Shape::Capsule { radius, half_length: a.max(b) - radius }, "capsule")
        }
    };
    let turn = UnitQuaternion::from_scaled_axis(Vector3::from_fn(|_, _| rng.random_range(-1.5..1.5)));
    let pose = Isometry3::from_parts(Translation3::new(3.0, 0.0, 1.0), turn);
    (Thing { name: THING.into(), shape, pose, fixed: false, substance: Substance::default() }, kind)
}

/// A way on which a thing meets a part of the body before any other, and how many draws did not.
pub(super) fn draw(
    actor: &mut OnStage,
    thing: &Thing,
    aimed: usize,
    postures: &[Posture],
    rng: &mut ChaCha8Rng,
) -> Result<Option<(Coming, usize)>, ExperimentError> {
    let number = actor.the_thing()?;
    let limbs = actor.own.creature().aura_limbs()[aimed].limbs.clone();
    let receptors = actor.own.receptors_on(&limbs);
    for draws in 0..DRAWS {
        let (Some(posture), Some(&receptor)) = (postures.choose(rng), receptors.choose(rng)) else {
            return Ok(None);
        };
        actor.place(posture)?;
        let found = &actor.own.skin().receptors[receptor];
        let [a, b] = [0, 1].map(|k| found.half_extents[k] * rng.random_range(-1.0..1.0));
        let frame = actor.frames()[found.limb];
        let point = frame.point(&(found.position + found.tangent * a + found.bitangent() * b));
        let x_wr = actor.stage.root_pose();
        let (point, normal) = ((x_wr * Point3::from(point)).coords, x_wr * (frame.rotation * found.normal));
        let from = loop {
            let drawn = Vector3::from_fn(|_, _| rng.random_range(-1.0..1.0_f64));
            let drawn = drawn.try_normalize(0.1).filter(|_| drawn.norm() < 1.0);
            if let Some(drawn) = drawn.filter(|drawn| drawn.dot(&normal) > 0.2) {
                break drawn;
            }
        };
        let far = rng.random_range(NEAREST..1.0);
        let speed = rng.random_range(0.1..0.5);
        let ends = [point + from * far, point - from * BEYOND];
        let turn = actor.stage.thing_pose(number).rotation;
        let shape = thing.shape.clone();
        let mut coming =
            Coming { aimed, posture: posture.clone(), shape, turn, ends, speed, met: Vec::new() };
        if meets(actor, number, &mut coming, &limbs)? {
            return Ok(Some((coming, draws)));
        }
    }
    Ok(None)
}

/// Whether a thing meets the limbs that it aims at first, and from outside, where the creature holds still; and all limbs
/// that it meets then.
fn meets(
    actor: &mut OnStage,
    thing: usize,
    coming: &mut Coming,
    aimed: &[usize],
) -> Result<bool, ExperimentError> {
    let began = actor.stage.time();
    let path = coming.path(began, TRIED);
    let end = path.end();
    actor.stage.send_thing(thing, path);
    while actor.stage.time() < end {
        let felt = actor.step(&coming.posture)?;
        let things = felt.iter().filter(|contact| contact.by == Toucher::Thing(thing));
        let limbs = things.map(|contact| actor.own.skin().receptors[contact.spot.receptor].limb);
        let news: Vec<usize> = limbs.filter(|limb| !coming.met.contains(limb)).collect();
        let first = coming.met.is_empty() && !news.is_empty();
        // What is met at the very beginning is met by a thing that was put into it.
        if first
            && (!news.iter().any(|limb| aimed.contains(limb)) || actor.stage.time() - began < 0.3 / TRIED)
        {
            return Ok(false);
        }
        coming.met.extend(news);
        coming.met.sort_unstable();
        coming.met.dedup();
    }
    Ok(!coming.met.is_empty())
}
