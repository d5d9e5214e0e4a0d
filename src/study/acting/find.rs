//! Whether a creature finds all things on a table, and knows how many there are.

use nalgebra::{Point3, Vector3};
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use serde_json::json;

use super::{EDGE, OnStage, Row, Scene, on_table, shape};
use crate::error::Error;
use crate::geometry::Shape;
use crate::interaction::{Conversation, Reply};
use crate::peripersonal::ReachTarget;
use crate::simulation::{ProbePath, Stage, Thing};

/// Things on a table at most.
const MOST: usize = 5;
/// No two things are nearer to each other than this, metres, nor one to the table's edge than …
const APART: f64 = 0.03;
/// … this, metres.
const FROM_EDGE: f64 = 0.02;
/// Draws of a place until there is one in true reach.
const DRAWS: usize = 200;
/// Postures that a true reach is looked for from.
const THOROUGH: usize = 10;
/// Steps in which the near side of a thing is looked for, metres.
const SURFACE_STEP: f64 = 1e-3;
/// A thing that is remembered is where one is within this, metres, of its surface.
const THERE: f64 = 0.05;
/// Things that nobody touches move less than this, metres: the engine lets some glide.
const STANDS: f64 = 1e-3;

pub(super) fn run(scene: &Scene) -> Result<Vec<Row>, Error> {
    let mut rng = scene.rng(0);
    let mut nobody = scene.at_table(scene.truth, &[])?;
    let height = nobody.table_top();
    nobody.know_table(height);
    let things = loop {
        let things = draw(&mut nobody, &mut rng);
        if stand(scene, &things)? {
            break things;
        }
    };
    let gone = rng.random_range(0..things.len());
    scene.by_each_schema(|known| search(scene.at_table(known, &things)?, &things, gone))
}

/// Lets a creature count the things on its table, takes one of them away, and lets it count again.
fn search(OnStage { stage, actor }: OnStage, things: &[Thing], gone: usize) -> Result<Row, Error> {
    let mut talk = Conversation::new(actor)?;
    let start = stage.time();
    let reply = talk.count(None)?;
    let seconds = stage.time() - start;
    let (found, phantoms) = compared(&stage, things, &reply);
    // One is taken away meanwhile.
    let mut left = things.to_vec();
    if let Some(number) = stage.thing(&left.remove(gone).name) {
        let (now, here) = (stage.time(), stage.thing_pose(number).translation.vector);
        let up = here + Vector3::z() * 0.8;
        let far = up + Vector3::x() * 3.0;
        stage.send_thing(number, ProbePath(vec![(now, here), (now + 1.0, up), (now + 2.0, far)]));
        talk.actor.wait(2.5)?;
    }
    let later = talk.count(None)?;
    let (_, later_phantoms) = compared(&stage, &left, &later);
    Ok(json!({
        "things": things.len(),
        "found": found,
        "phantoms": phantoms + later_phantoms,
        "done": reply.felt.len() == things.len(),
        "done_later": later.felt.len() == left.len(),
        "simulated_s": seconds,
        "result": reply.said,
    }))
}

/// The things of a table at which something is remembered, and how much of what is remembered is at none.
fn compared(stage: &Stage, things: &[Thing], reply: &Reply) -> (usize, usize) {
    let remembered = reply.felt.iter().map(|known| {
        let at = known["at"].as_array().into_iter().flatten().filter_map(|x| x.as_f64());
        stage.root_pose() * Point3::from(Vector3::from_iterator(at.take(3)))
    });
    let remembered: Vec<Point3<f64>> = remembered.collect();
    let is_at = |thing: &Thing, point: &Point3<f64>| {
        stage.thing(&thing.name).is_some_and(|number| {
            let local = stage.thing_pose(number).inverse_transform_point(point).coords;
            thing.shape.signed_distance(&local).is_some_and(|(distance, _)| distance <= THERE)
        })
    };
    let found = things.iter().filter(|thing| remembered.iter().any(|point| is_at(thing, point))).count();
    let phantoms = remembered.iter().filter(|point| !things.iter().any(|thing| is_at(thing, point))).count();
    (found, phantoms)
}

/// Random things on a table, all of which a hand can truly touch.
fn draw(nobody: &mut OnStage, rng: &mut ChaCha8Rng) -> Vec<Thing> {
    let count = rng.random_range(1..=MOST);
    let mut things: Vec<Thing> = Vec::new();
    for _ in 0..DRAWS {
        if things.len() == count {
            break;
        }
        let shape = any_shape(rng);
        let radius = around(&shape);
        let (x, y) = (rng.random_range(EDGE..0.8), rng.random_range(-0.8..0.8));
        let heading = rng.random_range(0.0..std::f64::consts::PI);
        let far = |other: &Thing| {
            let at = other.pose.translation.vector;
            (at.x - x).hypot(at.y - y) >= radius + around(&other.shape) + APART
        };
        if x - radius < EDGE + FROM_EDGE || !things.iter().all(far) {
            continue;
        }
        let name = format!("thing {}", things.len());
        let thing = Thing { name, ..on_table(shape, x, y, heading) };
        if in_reach(nobody, &thing) {
            things.push(thing);
        }
    }
    things
}

/// A shape that a hand can feel, or as often a lower and smaller one: 2 to 6 cm high, 3 to 10 cm wide.
fn any_shape(rng: &mut ChaCha8Rng) -> Shape {
    if rng.random_bool(0.5) {
        return shape(rng);
    }
    let mut size = |low: f64, high: f64| rng.random_range(low..high);
    let (a, b, c) = (size(0.015, 0.05), size(0.015, 0.05), size(0.01, 0.03));
    match rng.random_range(0..3) {
        0 => Shape::Cylinder { radius: a, half_length: c },
        1 => Shape::Sphere { radius: 0.01 + 0.5 * c },
        _ => Shape::Box { half_extents: [a, b, c] },
    }
}

/// The radius of an upright cylinder about a shape, metres.
fn around(shape: &Shape) -> f64 {
    match *shape {
        Shape::Sphere { radius } | Shape::Cylinder { radius, .. } => radius,
        Shape::Capsule { radius, half_length } => radius + half_length,
        _ => shape.half_bounds().xy().norm(),
    }
}

/// Whether some hand can truly touch a thing: from above, or where it is nearest.
fn in_reach(nobody: &mut OnStage, thing: &Thing) -> bool {
    let from = nobody.posture();
    let x_wr = nobody.stage.root_pose();
    let centre = x_wr.inverse_transform_point(&Point3::from(thing.pose.translation.vector)).coords;
    let top = nobody.table_top().max(centre.z);
    let above = centre + Vector3::z() * (centre.z - top).abs();
    let outward = Vector3::new(centre.x, centre.y, 0.0).normalize();
    // From outside it towards its middle, until its surface: that may be farther in than what is around all of it.
    let inside = |point: &Vector3<f64>| {
        let local = thing.pose.inverse_transform_point(&(x_wr * Point3::from(*point))).coords;
        thing.shape.signed_distance(&local).is_none_or(|(distance, _)| distance <= 0.0)
    };
    let mut near = centre - outward * around(&thing.shape);
    while !inside(&near) && (near - centre).dot(&outward) < 0.0 {
        near += outward * SURFACE_STEP;
    }
    let aims = [
        ReachTarget { point: above, direction: -Vector3::z() },
        ReachTarget { point: near, direction: outward },
    ];
    (0..2).any(|hand| {
        let hand = nobody.hands[hand].clone();
        aims.iter()
            .any(|aim| nobody.reaching(hand.arm.clone()).can_be_at(&from, &hand.receptors, aim, THOROUGH))
    })
}

/// Whether there are things, and all stay where they are put while nobody touches them.
fn stand(scene: &Scene, things: &[Thing]) -> Result<bool, Error> {
    let mut actor = scene.at_table(scene.truth, things)?;
    let touched = actor.wait(0.5)?;
    let stays = |thing: &Thing| {
        let pose = |number| actor.stage.thing_pose(number).translation.vector;
        let moved = |number| (pose(number) - thing.pose.translation.vector).norm();
        actor.stage.thing(&thing.name).is_some_and(|number| moved(number) < STANDS)
    };
    Ok(!things.is_empty() && touched.is_empty() && things.iter().all(stays))
}
