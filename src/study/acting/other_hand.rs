//! Whether a creature touches with one hand a thing that the other arm felt.

use nalgebra::{Isometry3, Point3, Translation3, UnitQuaternion, Vector3};
use rand::RngExt;
use rand::seq::IndexedRandom;
use rand_chacha::ChaCha8Rng;
use serde_json::json;

use super::{OnStage, Row, Scene, THING, on_table, shape};
use crate::creature::Posture;
use crate::error::Error;
use crate::interaction::{FoundThing, Hand, Trouble};
use crate::kinematics::REACHED;
use crate::peripersonal::ReachTarget;
use crate::senses::Toucher;
use crate::simulation::{Substance, Thing};
use crate::skin::Surface;
use crate::study::subject::Knowledge;

/// Draws of a thing until there is one that an arm feels and the other hand could truly reach.
const DRAWS: usize = 60;
/// Postures that a true reach is looked for from.
const THOROUGH: usize = 20;

/// A thing in its place, and the arm that is to feel it: by sweeping, or where the thing is held against it in a posture.
struct PlacedThing {
    thing: Thing,
    arm: usize,
    posture: Option<Posture>,
}

/// A thing that an arm feels, and where on it, in its frame, metres.
struct FeltThing {
    found: FoundThing,
    arm: usize,
    at: Vector3<f64>,
}

pub(super) fn run(scene: &Scene, on_the_table: bool) -> Result<Vec<Row>, Error> {
    let mut rng = scene.rng(u64::from(!on_the_table));
    let mut nobody = on_the_table.then(|| scene.at_table(scene.truth, &[])).transpose()?;
    for _ in 0..DRAWS {
        let put = match &mut nobody {
            Some(nobody) => {
                let (x, y) = (rng.random_range(0.3..0.75), rng.random_range(-0.45..0.45));
                let shape = shape(&mut rng);
                let thing = on_table(shape, x, y, rng.random_range(0.0..std::f64::consts::PI));
                let arm = rng.random_range(0..2);
                both_reach(nobody, &thing).then_some(PlacedThing { thing, arm, posture: None })
            }
            None => {
                let arm = rng.random_range(0..2);
                in_air(scene, arm, &mut rng)?
            }
        };
        let Some(put) = put else { continue };
        // Whether it is felt, and whether the other hand could truly reach it, is asked of the truth.
        let felt = feel(scene, scene.truth, &put)?;
        if felt.is_some_and(|(actor, felt)| reachable(actor, &felt)) {
            return scene.by_each_schema(|known| match feel(scene, known, &put)? {
                Some((actor, felt)) => attempt(actor, &felt),
                None => Ok(json!({"done": false, "first": false, "result": "not felt"})),
            });
        }
    }
    Ok(Vec::new())
}

/// Whether both hands of a creature at the table could be where a thing stands.
fn both_reach(actor: &mut OnStage, thing: &Thing) -> bool {
    let from = actor.posture();
    let point = actor.stage.root_pose().inverse_transform_point(&Point3::from(thing.pose.translation.vector));
    let aim = ReachTarget { point: point.coords, direction: Vector3::zeros() };
    (0..2).all(|hand| {
        let Hand { arm, tip, .. } = actor.hands[hand].clone();
        let place = actor.own.place(tip);
        actor.reaching(arm).solve(place, &aim, &from).miss <= REACHED
    })
}

/// A thing that is held against a random place of an arm in a random posture.
fn in_air(scene: &Scene, hand: usize, rng: &mut ChaCha8Rng) -> Result<Option<PlacedThing>, Error> {
    let own = &scene.truth.own;
    let mut actor = scene.at_table(scene.truth, &[])?;
    let height = actor.table_top();
    actor.know_table(height);
    let from = actor.posture();
    let arm = actor.hands[hand].arm.clone();
    let clearance = actor.clearance.moved_by(own, &arm);
    let posture = (0..200)
        .map(|_| own.random_posture(&from, &arm, rng))
        .find(|posture| clearance.free(&own.frames(posture), 0.01));
    let Some(posture) = posture else { return Ok(None) };
    let limbs = arm.iter().skip(1).flat_map(|joint| own.hand_of(joint + 1)).collect::<Vec<_>>();
    let receptors = own.receptors_on(&limbs);
    let Some(&receptor) = receptors.choose(rng) else { return Ok(None) };
    actor.place(&posture)?;
    // Anywhere on its patch.
    let patch = &own.skin().receptors[receptor];
    let mut along = |half: f64| rng.random_range(-half..half);
    let flat = patch.position
        + patch.tangent * along(patch.half_extents[0])
        + patch.bitangent() * along(patch.half_extents[1]);
    let place = own.on_surface(receptor, &flat).unwrap_or_else(|| own.place(receptor));
    let frame = actor.frames()[place.limb];
    let x_wr = actor.stage.root_pose();
    let point = x_wr * Point3::from(frame.point(&place.point));
    let normal = x_wr * (frame.rotation * place.direction);
    let shape = shape(rng);
    let turn = UnitQuaternion::from_scaled_axis(Vector3::from_fn(|_, _| rng.random_range(-1.5..1.5)));
    let Some(deepest) = shape.support(&turn.inverse_transform_vector(&-normal)) else { return Ok(None) };
    let origin = point.coords - normal * 3e-4 - turn * deepest;
    let pose = Isometry3::from_parts(Translation3::from(origin), turn);
    let thing = Thing { name: THING.into(), shape, pose, fixed: true, substance: Substance::default() };
    Ok(Some(PlacedThing { thing, arm: hand, posture: Some(posture) }))
}

/// Lets the creature feel the thing. `None` if it does not, or feels more than it should.
fn feel(scene: &Scene, known: &Knowledge, put: &PlacedThing) -> Result<Option<(OnStage, FeltThing)>, Error> {
    let mut actor = scene.at_table(known, std::slice::from_ref(&put.thing))?;
    actor.feels_on = true;
    let thing = actor.the_thing()?;
    let touched = actor.wait(0.01)?.iter().any(|contact| contact.by == Toucher::Thing(thing));
    if touched && put.posture.is_none() || !actor.finds_table() {
        return Ok(None);
    }
    let found = match &put.posture {
        Some(posture) => {
            // A partner has put the arm there and holds the thing against it.
            actor.place(posture)?;
            let felt = actor.wait(0.01)?;
            if felt.iter().any(|contact| contact.by != Toucher::Thing(thing)) {
                return Ok(None);
            }
            felt.iter().find_map(|contact| actor.found(contact))
        }
        None => actor.explore(put.arm).ok().flatten(),
    };
    let Some(found) = found.filter(|found| found.thing == thing) else { return Ok(None) };
    if actor.arm_of(found.receptor) != Some(put.arm) {
        return Ok(None);
    }
    let limb = actor.own.skin().receptors[found.receptor].limb;
    let at = actor.stage.touching_at(limb, thing);
    Ok(at.map(|at| (actor, FeltThing { found, arm: put.arm, at })))
}

/// Whether some skin of the other hand can be where the thing was felt with no limb in another or in the table, by the schema of
/// the one who felt it.
fn reachable(mut actor: OnStage, felt: &FeltThing) -> bool {
    let hand = actor.hands[1 - felt.arm].clone();
    let from = actor.ready();
    let aim = ReachTarget { point: felt.found.point, direction: felt.found.direction };
    actor.reaching(hand.arm).can_be_at(&from, &hand.receptors, &aim, THOROUGH)
}

fn attempt(mut actor: OnStage, felt: &FeltThing) -> Result<Row, Error> {
    let hand = 1 - felt.arm;
    let limb = actor.own.skin().receptors[felt.found.receptor].limb;
    let in_world = |actor: &OnStage, p: Vector3<f64>| actor.stage.root_pose() * Point3::from(p);
    let really = actor.stage.thing_pose(felt.found.thing) * Point3::from(felt.at);
    let mut row = json!({
        "limb": actor.own.creature().limbs()[limb],
        "done": false,
        "first": false,
        "felt_mm": 1e3 * (really - in_world(&actor, felt.found.point)).norm(),
    });
    actor.unintended = 0;
    let result = actor.touch(&felt.found, hand, true);
    row["unintended"] = json!(actor.unintended > 0);
    row["result"] = json!(match result {
        Err(Trouble::Engine(error)) => return Err(error),
        Err(trouble) => trouble.to_string(),
        Ok(touching) if touching.found.thing != felt.found.thing => "something else".into(),
        Ok(touching) => {
            row["done"] = json!(true);
            row["first"] = json!(touching.corrections == 0);
            row["felt_on_mm"] = json!(1e3 * (really - in_world(&actor, touching.felt.point)).norm());
            let by = actor.own.skin().receptors[touching.found.receptor].limb;
            let at = actor.stage.touching_at(by, touching.found.thing);
            row["contact_mm"] = json!(at.map(|at| 1e3 * (at - felt.at).norm()));
            // The thing may have been moved a little, and where it was touched with it.
            let place = actor.stage.thing_pose(touching.found.thing) * Point3::from(felt.at);
            let hand = actor.hands[hand].limb;
            let carried = actor.own.carried_by(hand);
            let gap = |surface: &Surface| {
                let pose = actor.stage.limb_pose(surface.limb);
                Some(surface.signed_distance(&pose.inverse_transform_point(&place).coords)?.0.abs())
            };
            let surfaces = actor.stage.skin().surfaces.iter();
            let of_hand = surfaces.filter(|surface| surface.limb == hand || carried[surface.limb]);
            row["error_mm"] = json!(1e3 * of_hand.filter_map(gap).fold(f64::INFINITY, f64::min));
            "touched".into()
        }
    });
    Ok(row)
}
