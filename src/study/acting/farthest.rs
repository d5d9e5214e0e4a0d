//! How far away a creature puts a held thing, compared with its reach according to the true body.

use nalgebra::{Isometry3, Translation3, Vector3};
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use serde_json::json;

use super::{OnStage, Row, Scene, TOP, on_table, shape};
use crate::error::Error;
use crate::interaction::Trouble;

/// Draws of a thing until there is one that a hand finds and holds.
const DRAWS: usize = 20;
/// How much effort the creature makes.
const EFFORT: usize = 3;
/// What is farther from where it was to be than this, metres, is not put there …
const OFF: f64 = 0.03;
/// … what is tilted by more, degrees, fell over …
const FELL: f64 = 30.0;
/// … and what is lower than the table by this, metres, fell off it.
const BELOW: f64 = 0.01;

pub(super) fn run(scene: &Scene, lean: bool) -> Result<Vec<Row>, Error> {
    let mut rng = scene.rng(0);
    for _ in 0..DRAWS {
        if let Some((actor, receptor)) = hold(scene, &mut rng)? {
            return Ok(vec![put(scene, actor, receptor, lean)?]);
        }
    }
    Ok(vec![json!({"schema": "learned", "result": "nothing was held"})])
}

/// A creature that has found a random thing and holds it with a receptor of a hand. `None` if it did not come to that.
fn hold(scene: &Scene, rng: &mut ChaCha8Rng) -> Result<Option<(OnStage, usize)>, Error> {
    let (x, y) = (rng.random_range(0.32..0.5), rng.random_range(-0.3..0.3));
    let thing = on_table(shape(rng), x, y, rng.random_range(0.0..std::f64::consts::PI));
    let hand = usize::from(y < 0.0);
    let mut actor = scene.at_table(scene.learned, &[thing])?;
    let thing = actor.the_thing()?;
    if !actor.finds_table() {
        return Ok(None);
    }
    let Some(found) = actor.explore(hand).ok().flatten().filter(|found| found.thing == thing) else {
        return Ok(None);
    };
    let receptor = match actor.hands[hand].receptors.contains(&found.receptor) {
        true => found.receptor,
        false => match actor.touch(&found, hand, false) {
            Ok(touching) if touching.found.thing == thing => touching.found.receptor,
            _ => return Ok(None),
        },
    };
    Ok((actor.arm_of(receptor).is_some() && actor.hold(receptor)).then_some((actor, receptor)))
}

/// Lets a creature put what it holds with a receptor as far away as it can.
fn put(scene: &Scene, mut actor: OnStage, receptor: usize, lean: bool) -> Result<Row, Error> {
    let truth = &scene.truth.own;
    if lean && let Err(Trouble::Engine(error)) = actor.make_way_to_lean(receptor, EFFORT) {
        return Err(error);
    }
    let limb = actor.own.place(receptor).limb;
    let upright = actor.frames()[limb].rotation.tr_mul(&actor.up);
    let height = actor.feels_at(receptor).0.dot(&actor.up);
    let spot = actor.farthest(receptor, height, upright, lean, EFFORT);
    // The same question to the same search by the true body.
    actor.own = truth.clone();
    let by_truth = actor.farthest(receptor, height, upright, lean, EFFORT);
    actor.own = scene.learned.own.clone();
    let (grip, front) = (truth.place(receptor).point, actor.front);
    let forward = |posture: &[f64]| truth.frames(posture)[limb].point(&grip).dot(&front);
    let [reached, possible] =
        [&spot, &by_truth].map(|spot| spot.as_ref().map_or(0.0, |spot| forward(&spot.posture)));
    let mut row = json!({
        "schema": "learned",
        "limb": scene.subject.creature().limbs()[limb],
        "forward_m": reached,
        "of_true_reach": reached / possible.max(reached),
        "done": false,
        "result": "no path found",
    });
    let Some(spot) = spot else { return Ok(row) };
    let thing = actor.the_thing()?;
    let before = actor.stage.thing_pose(thing);
    // Where the thing is to be, rigidly in the hand.
    let in_hand = actor.stage.limb_pose(limb).inv_mul(&before);
    let at_spot = truth.frames(&spot.posture)[limb];
    let in_root = Isometry3::from_parts(Translation3::from(at_spot.origin), at_spot.quaternion());
    let wanted = actor.stage.root_pose() * in_root * in_hand;
    let result = actor.put(receptor, &spot, lean);
    let after = actor.stage.thing_pose(thing);
    let off = (after.translation.vector - wanted.translation.vector).xy().norm();
    // By how much it leans from how it stood, whichever way it is turned about the vertical.
    let was_up = before.rotation.inverse() * Vector3::z();
    let tilt = (after.rotation * was_up).z.clamp(-1.0, 1.0).acos().to_degrees();
    row["error_mm"] = json!(1e3 * off);
    row["result"] = json!(match result {
        Err(Trouble::Engine(error)) => return Err(error),
        Err(trouble) => trouble.to_string(),
        Ok(_) if after.translation.z <= TOP - BELOW => "it fell off the table".into(),
        Ok(_) if tilt > FELL => "it fell over".into(),
        Ok(_) if off > OFF => "it is not at its target".into(),
        Ok(_) => "put".into(),
    });
    row["done"] = json!(row["result"] == "put");
    Ok(row)
}
