//! Whether a creature avoids an approaching thing and keeps all other limbs still.

use std::collections::BTreeSet;

use nalgebra::{Isometry3, Point3, Translation3, UnitQuaternion, Vector3};
use rand::RngExt;
use rand::seq::IndexedRandom;
use rand_chacha::ChaCha8Rng;
use serde_json::json;

use super::{Knowledge, OnStage, Row, Scene, THING};
use crate::creature::Posture;
use crate::error::Error;
use crate::geometry::Shape;
use crate::interaction::{Actor, Avoiding};
use crate::senses::{SkinContact, Toucher};
use crate::simulation::{ProbePath, Substance, Thing};

/// Draws of a way until there is one that meets first the limb that it aims at.
const DRAWS: usize = 400;
/// How fast a way is tried, metres a second.
const TRIED: f64 = 2.5;
/// How far things go on beyond where they aim, metres.
const BEYOND: f64 = 0.5;
/// From how far they come at least, metres.
const NEAREST: f64 = 0.7;
/// How far apart limbs are at first, metres.
const APART: f64 = 0.015;
/// A limb that moves less than this keeps still, metres.
const STILL: f64 = 0.01;
/// Every how many steps the limbs are measured.
const EVERY: usize = 10;

/// How a thing comes, which both creatures of a trial meet alike.
struct Coming {
    /// The aura limb that it aims at.
    aimed: usize,
    posture: Posture,
    /// Where it sets out and where it ends, in the world, metres.
    ends: [Vector3<f64>; 2],
    /// Metres a second.
    speed: f64,
    /// The limbs that it would meet.
    met: Vec<usize>,
}

pub(super) fn run(scene: &Scene) -> Result<Vec<Row>, Error> {
    let creature = scene.subject.creature();
    // What nothing moves cannot avoid anything.
    let moves = |aura: &usize| {
        let limbs = &creature.aura_limbs()[*aura].limbs;
        !limbs.contains(&0) && !scene.truth.own.receptors_on(limbs).is_empty()
    };
    let auras: Vec<usize> = (0..creature.aura_limbs().len()).filter(moves).collect();
    if auras.is_empty() {
        return Err(Error::unfit(scene.subject.model(), "no limb of it with receptors moves"));
    }
    let aimed = auras[scene.seed as usize % auras.len()];
    let mut rng = scene.rng(0);
    let thing = thing(&mut rng);
    let mut actor = scene.among(scene.truth, vec![thing])?;
    let postures = beginnings(&mut actor, scene.truth, &mut rng);
    let Some(coming) = draw(&mut actor, aimed, &postures, &mut rng)? else { return Ok(Vec::new()) };
    scene.by_each_schema(|known| {
        let mut row = attempt(&mut actor, known, &coming)?;
        row["limb"] = json!(creature.aura_limbs()[aimed].name);
        Ok(row)
    })
}

/// A thing of a random shape of 2 to 5 cm half size.
fn thing(rng: &mut ChaCha8Rng) -> Thing {
    let [a, b, c] = [0; 3].map(|_| rng.random_range(0.02..0.05));
    let shape = match rng.random_range(0..3) {
        0 => Shape::Sphere { radius: a },
        1 => Shape::Box { half_extents: [a, b, c] },
        // As long as it is wide at least, 5 cm half at most.
        _ => {
            let radius = 0.5 * a.min(b) + 0.01;
            Shape::Capsule { radius, half_length: a.max(b) - radius }
        }
    };
    let turn = UnitQuaternion::from_scaled_axis(Vector3::from_fn(|_, _| rng.random_range(-1.5..1.5)));
    let pose = Isometry3::from_parts(Translation3::new(3.0, 0.0, 1.0), turn);
    Thing { name: THING.into(), shape, pose, fixed: false, substance: Substance::default() }
}

/// Postures to begin with: hands raised, or, as often, arms anywhere where they touch nothing.
fn beginnings(actor: &mut OnStage, truth: &Knowledge, rng: &mut ChaCha8Rng) -> Vec<Posture> {
    let raised = rng.random_bool(0.5);
    let ready = actor.ready();
    if raised {
        return vec![ready];
    }
    let joints = actor.arms();
    let at_rest = [truth.own.frames(&truth.own.at_ease())];
    let clearance = truth.clearance.moved_by(&truth.own, &joints).eased_at(&at_rest, APART);
    (0..2000)
        .map(|_| truth.own.random_posture(&ready, &joints, rng))
        .filter(|posture| clearance.free(&truth.own.frames(posture), APART))
        .take(20)
        .collect()
}

/// A way on which the thing meets a part of the body before any other. `None` if none was drawn.
fn draw(
    actor: &mut OnStage,
    aimed: usize,
    postures: &[Posture],
    rng: &mut ChaCha8Rng,
) -> Result<Option<Coming>, Error> {
    let limbs = actor.own.creature().aura_limbs()[aimed].limbs.clone();
    let receptors = actor.own.receptors_on(&limbs);
    for _ in 0..DRAWS {
        let (Some(posture), Some(&receptor)) = (postures.choose(rng), receptors.choose(rng)) else {
            return Ok(None);
        };
        actor.place(posture)?;
        let patch = &actor.own.skin().receptors[receptor];
        let [a, b] = [0, 1].map(|k| patch.half_extents[k] * rng.random_range(-1.0..1.0));
        let frame = actor.frames()[patch.limb];
        let point = frame.point(&(patch.position + patch.tangent * a + patch.bitangent() * b));
        let x_wr = actor.stage.root_pose();
        let (point, normal) = ((x_wr * Point3::from(point)).coords, x_wr * (frame.rotation * patch.normal));
        // From outside.
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
        let mut coming = Coming { aimed, posture: posture.clone(), ends, speed, met: Vec::new() };
        if meets(actor, &mut coming, &limbs)? {
            return Ok(Some(coming));
        }
    }
    Ok(None)
}

impl Coming {
    /// Its way from a time on, at a speed of metres a second.
    fn path(&self, time: f64, speed: f64) -> ProbePath {
        let seconds = (self.ends[1] - self.ends[0]).norm() / speed;
        ProbePath(vec![(time, self.ends[0]), (time + seconds, self.ends[1])])
    }
}

/// Whether the thing meets first the limbs that it aims at, and from outside, if the creature holds still; and all limbs that it
/// meets then.
fn meets(actor: &mut OnStage, coming: &mut Coming, aimed: &[usize]) -> Result<bool, Error> {
    let thing = actor.the_thing()?;
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
        let at_once = actor.stage.time() - began < 0.3 / TRIED;
        if first && (!news.iter().any(|limb| aimed.contains(limb)) || at_once) {
            return Ok(false);
        }
        coming.met.extend(news);
        coming.met.sort_unstable();
        coming.met.dedup();
    }
    Ok(!coming.met.is_empty())
}

/// The limbs that a thing does not threaten: neither those that it would meet nor those between them and the root, nor, if these
/// are not both arms, those that they carry.
fn others(actor: &Actor, coming: &Coming) -> Vec<bool> {
    let creature = actor.own.creature();
    let aimed = &creature.aura_limbs()[coming.aimed].limbs;
    let mut threatened = vec![false; creature.limbs().len()];
    aimed.iter().chain(&coming.met).for_each(|&limb| threatened[limb] = true);
    let by = |limb: usize| actor.own.carried_by(limb);
    let met: Vec<usize> = (0..threatened.len()).filter(|&limb| threatened[limb]).collect();
    let carried: Vec<bool> =
        (0..threatened.len()).map(|limb| met.iter().any(|&other| by(other)[limb])).collect();
    let carries = |limb: usize| met.iter().any(|&other| by(limb)[other]);
    // A part that carries the hands is asked to leave them where they are.
    let trunk = actor.hands.iter().all(|hand| carried[hand.limb]);
    let is_other = |limb: usize| !threatened[limb] && !carries(limb) && (trunk || !carried[limb]);
    (0..threatened.len()).map(is_other).collect()
}

/// Which arm touches which limb; the trunk touches itself wherever it bends.
fn own_touches(actor: &Actor, felt: &[SkinContact]) -> BTreeSet<[usize; 2]> {
    let on_arm = |limb: usize| {
        // Without its clavicle.
        actor.hands.iter().any(|hand| actor.own.carried_by(hand.arm[1.min(hand.arm.len() - 1)] + 1)[limb])
    };
    let pair = |contact: &SkinContact| match contact.by {
        Toucher::Own(other) => {
            Some([contact.spot.limb, other.limb]).filter(|pair| pair.iter().any(|&limb| on_arm(limb)))
        }
        _ => None,
    };
    felt.iter().filter_map(pair).collect()
}

/// The creature with what it knows meets a thing; what came of it is measured by the truth.
fn attempt(actor: &mut OnStage, known: &Knowledge, coming: &Coming) -> Result<Row, Error> {
    let thing = actor.the_thing()?;
    (actor.own, actor.clearance) = (known.own.clone(), known.clearance.clone());
    let began = actor.stage.time();
    let path = coming.path(began, coming.speed);
    let end = path.end();
    actor.stage.send_thing(thing, path);
    actor.place(&coming.posture)?;
    // What touches already before anything comes is no consequence.
    let felt = actor.step(&coming.posture)?;
    let touching = own_touches(actor, &felt);
    let mut avoiding = Avoiding::new(actor);
    let others = others(actor, coming);
    let skin = |actor: &OnStage| -> Vec<Vector3<f64>> {
        let poses: Vec<Isometry3<f64>> = (0..others.len()).map(|limb| actor.stage.limb_pose(limb)).collect();
        let receptors = actor.stage.skin().receptors.iter();
        receptors.map(|r| (poses[r.limb] * Point3::from(r.position)).coords).collect()
    };
    let before = skin(actor);
    let (mut touched, mut itself, mut moved, mut steps) = (false, false, 0.0f64, 0);
    while actor.stage.time() < end {
        let felt = avoiding.step(actor)?;
        itself |= own_touches(actor, &felt).iter().any(|pair| !touching.contains(pair));
        touched |= felt.iter().any(|contact| contact.by == Toucher::Thing(thing));
        if steps % EVERY == 0 {
            for ((r, now), then) in actor.own.skin().receptors.iter().zip(skin(actor)).zip(&before) {
                if others[r.limb] {
                    moved = moved.max((now - then).norm());
                }
            }
        }
        steps += 1;
    }
    Ok(json!({
        "done": !touched,
        "others_still": moved < STILL,
        "unintended": itself,
        "result": if touched { "touched" } else { "avoided" },
    }))
}
