//! What happens on the table: a can is found wherever it stands, things go where they are wanted, and what is said of where
//! something is relative to a part of the body is so.

use std::sync::LazyLock;

use bodyschema::geometry::{Capsule, ConvexBody, Precision, gap};
use bodyschema::interaction::{Actor, Conversation, Intent, Reply};
use bodyschema::peripersonal::OwnBody;
use bodyschema::simulation::{ProbePath, Stage, StageOptions, Thing};
use nalgebra::{Isometry3, Point3, Vector3};

use crate::common::repository;
use crate::conversation::say;
use crate::interaction::{at_table, learned_max};
use bodyschema::geometry::Shape;

/// The height of the table's top in the world, metres.
const TOP: f64 = 0.98;
/// The radius and half the height of a can, metres.
const CAN: [f64; 2] = [0.033, 0.055];

/// What Max has learned by his first 400 touches.
fn learned() -> OwnBody {
    static LEARNED: LazyLock<OwnBody> = LazyLock::new(|| learned_max(400));
    LEARNED.clone()
}

fn thing(name: &str, shape: Shape, at: [f64; 3], fixed: bool) -> Thing {
    let pose = Isometry3::translation(at[0], at[1], at[2]);
    Thing { name: name.into(), shape, pose, fixed, substance: Default::default() }
}

/// Max at a table on which nothing is but a can.
fn with_a_can(x: f64, y: f64, seed: u64) -> (Stage, Conversation) {
    let table = Shape::Box { half_extents: [0.55, 1.0, 0.02] };
    let can = Shape::Cylinder { radius: CAN[0], half_length: CAN[1] };
    let things = vec![
        thing("table", table, [0.77, 0.0, TOP - 0.02], true),
        thing("can", can, [x, y, TOP + CAN[1]], false),
    ];
    let options = StageOptions { things, ..StageOptions::default() };
    let stage = Stage::new(&repository("mjcf/max/max.xml"), &options).unwrap();
    let mut actor = Actor::new(learned(), stage.handle(), ["left_hand", "right_hand"], seed).unwrap();
    stage.place(&actor.ready()).unwrap();
    (stage, Conversation::new(actor).unwrap())
}

fn place(stage: &Stage, name: &str) -> Vector3<f64> {
    stage.thing_pose(stage.thing(name).unwrap()).translation.vector
}

/// Where things are that a reply remembers, in the world, metres.
fn remembered(stage: &Stage, reply: &Reply) -> Vec<Vector3<f64>> {
    let place = |known: &serde_json::Value| {
        let at = known["at"].as_array().unwrap().iter().map(|x| x.as_f64().unwrap());
        (stage.root_pose() * Point3::from(Vector3::from_iterator(at))).coords
    };
    reply.felt.iter().map(place).collect()
}

/// Whether he finds a can, and still has it on the table in the end: what was wrong, else.
fn finds(x: f64, y: f64, seed: u64) -> Result<(), String> {
    let (stage, mut talk) = with_a_can(x, y, seed);
    let reply = talk.hear("is there something in front of you?").unwrap();
    let can = place(&stage, "can");
    let off = |at: &Vector3<f64>| (at - can).xy().norm();
    let found = remembered(&stage, &reply).iter().any(|at| off(at) < CAN[0] + 0.05);
    let told = format!("{x:.2} {y:.2}: can at {can:.3?}, table {:?}: {}", talk.actor.table, reply.said);
    eprintln!("{told}");
    (found && can.z > TOP && reply.done == Some(true)).then_some(()).ok_or(told)
}

#[test]
fn a_can_is_found_near_the_edge_and_beside_the_middle() {
    for (x, y) in [(0.27, 0.3), (0.45, -0.15)] {
        finds(x, y, 1).unwrap();
    }
}

#[test]
fn what_is_no_longer_there_is_said_to_be_gone_whatever_is_asked_for() {
    let (stage, mut talk) = with_a_can(0.45, -0.15, 1);
    for request in [
        "put it as far away as possible",
        "pick it up with your right hand",
        "feel its shape",
        "push it left",
    ] {
        let reply = say(&mut talk, "is there something in front of you?");
        assert_eq!(reply.felt.len(), 1, "{}", reply.said);
        // It is taken away while his hands wait elsewhere.
        say(&mut talk, "rest");
        let (can, now, here) = (stage.thing("can").unwrap(), stage.time(), place(&stage, "can"));
        let (up, away) = (here + Vector3::z() * 0.8, here + Vector3::new(3.0, 0.0, 0.8));
        stage.send_thing(can, ProbePath(vec![(now, here), (now + 1.0, up), (now + 2.0, away)]));
        talk.actor.wait(2.5).unwrap();
        let reply = say(&mut talk, request);
        assert!(reply.done == Some(false) && reply.felt.is_empty(), "{request}: {}", reply.said);
        let reply = say(&mut talk, request);
        assert!(reply.said.contains("not felt anything yet"), "{request}: {}", reply.said);
        // And comes back.
        let now = stage.time();
        stage.send_thing(can, ProbePath(vec![(now, away), (now + 1.0, up), (now + 2.0, here)]));
        talk.actor.wait(2.5).unwrap();
    }
}

#[test]
fn it_is_pushed_to_the_side_that_is_told() {
    let (stage, mut talk) = with_a_can(0.45, -0.05, 1);
    say(&mut talk, "is there something in front of you?");
    for (request, way) in [
        ("push it 10 cm to the left", 0.1),
        ("nudge it to the right by 8 cm", -0.08),
        ("don't push it left", 0.0),
    ] {
        let before = place(&stage, "can");
        let reply = say(&mut talk, request);
        let moved = place(&stage, "can") - before;
        assert!((moved.y - way).abs() < 0.015 && moved.x.abs() < 0.02, "{request}: {moved} {}", reply.said);
        assert!(place(&stage, "can").z > TOP);
    }
}

/// Numbers of centimetres in what was said.
fn centimetres(said: &str) -> Vec<f64> {
    let words: Vec<&str> = said.split(' ').collect();
    words.windows(2).filter(|pair| pair[1] == "cm").map(|pair| pair[0].parse().unwrap()).collect()
}

/// Parts as they are asked for, whose name says where they truly are: a joint of the model, or a limb.
const JOINTS: [&str; 6] =
    ["left_elbow", "right_elbow", "left_shoulder", "right_shoulder", "left_wrist", "right_wrist"];
const LIMBS: [&str; 7] =
    ["left_hand", "right_hand", "left_forearm", "right_upper_arm", "head", "chest", "abdomen"];
/// Others, which are where some receptor truly is.
const PLACES: [&str; 20] = [
    "nose",
    "chin",
    "forehead",
    "mouth",
    "left ear",
    "right ear",
    "right cheek",
    "belly",
    "back",
    "throat",
    "left palm",
    "right palm",
    "left fingertip",
    "right fingertip",
    "left hip",
    "left knee",
    "right knee",
    "left shoulder blade",
    "left thumb",
    "top of your head",
];

/// What a part truly takes up in the world, by its name.
fn truly<'a>(stage: &'a Stage, part: &str) -> Vec<Box<dyn ConvexBody + 'a>> {
    let frames = stage.limb_frames();
    let creature = stage.agent().creature();
    if let Some(joint) = creature.joints().iter().position(|joint| joint.name == part) {
        // A limb's frame has its origin at the joint that carries it.
        return vec![Box::new(Capsule::ball(frames[joint + 1].origin, 0.0))];
    }
    let called = |limb: usize| creature.aura_of(limb).is_some_and(|k| creature.aura_limbs()[k].name == part);
    let surfaces = stage.skin().surfaces.iter().filter(|surface| called(surface.limb));
    let placed = surfaces.filter_map(|surface| surface.placed(&frames[surface.limb]));
    placed.map(|placed| Box::new(placed) as Box<dyn ConvexBody>).collect()
}

/// How far apart two places truly are, and the way from the second to the first, metres.
fn apart(a: &[Box<dyn ConvexBody + '_>], b: &[Box<dyn ConvexBody + '_>]) -> (f64, Vector3<f64>) {
    let gaps = a.iter().flat_map(|a| b.iter().map(move |b| gap(&**a, &**b, Precision::Exact)));
    let nearest = gaps.min_by(|a, b| a.distance.total_cmp(&b.distance)).unwrap();
    (nearest.distance.max(0.0), nearest.points[0] - nearest.points[1])
}

/// Holds what is said of one place relative to another against where they are; `x_wr` turns ways into the root's frame.
fn holds(stage: &Stage, said: &str, (distance, way): (f64, Vector3<f64>)) -> Result<(), String> {
    let told = centimetres(said);
    let way = stage.root_pose().rotation.inverse() * way;
    let ways =
        [("in front of", way.x), ("behind", -way.x), ("to the left of", way.y), ("to the right of", -way.y)];
    let ways = ways.into_iter().chain([("above", way.z), ("below", -way.z)]);
    let mut wrong = Vec::new();
    if !told.first().is_some_and(|told| (told - 100.0 * distance).abs() < 1.0) {
        wrong.push(format!("{distance:.3} m apart"));
    }
    for (words, along) in ways {
        let part = said.split(',').find(|part| part.contains(&format!("cm {words} it")));
        let told = part.and_then(|part| centimetres(part).last().copied()).unwrap_or(0.0);
        if (told - 100.0 * along.max(0.0)).abs() >= 1.0 {
            wrong.push(format!("{words}: {along:.3} m"));
        }
    }
    if wrong.is_empty() { Ok(()) } else { Err(format!("{said}: {}", wrong.join(", "))) }
}

#[test]
fn where_something_is_relative_to_any_part_is_told_as_it_is() {
    let (stage, mut talk) = at_table(learned());
    let reply = say(&mut talk, "is there something in front of you?");
    let mut wrong = Vec::new();
    let thing = remembered(&stage, &reply)[0];
    let it = || -> Vec<Box<dyn ConvexBody>> { vec![Box::new(Capsule::ball(thing, 0.0))] };
    for part in JOINTS.iter().chain(&LIMBS) {
        for request in [
            format!("how far is it from your {}?", part.replace('_', " ")),
            format!("where is it relative to your {}?", part.replace('_', " ")),
        ] {
            let said = talk.hear(&request).unwrap().said;
            wrong.extend(holds(&stage, &said, apart(&it(), &truly(&stage, part))).err());
        }
        for other in JOINTS.iter().chain(&LIMBS).filter(|other| *other != part) {
            let request = format!(
                "where is your {} relative to your {}?",
                part.replace('_', " "),
                other.replace('_', " ")
            );
            let said = talk.hear(&request).unwrap().said;
            wrong.extend(holds(&stage, &said, apart(&truly(&stage, part), &truly(&stage, other))).err());
        }
    }
    // Where a place is he says of the middle of his root; what he says of it relative to others fits that.
    let receptors: Vec<Vector3<f64>> = stage
        .skin()
        .receptors
        .iter()
        .map(|receptor| stage.limb_frames()[receptor.limb].point(&receptor.position))
        .collect();
    for part in PLACES {
        let said = talk.hear(&format!("how far is it from your {part}?")).unwrap().said;
        let told = centimetres(&said);
        let Some(&told) = told.first() else {
            wrong.push(said);
            continue;
        };
        let near = receptors.iter().map(|at| (100.0 * (at - thing).norm() - told).abs());
        if near.fold(f64::INFINITY, f64::min) >= 1.0 && !said.contains("hand") {
            wrong.push(said);
        }
    }
    assert!(wrong.is_empty(), "{} wrong:\n{}", wrong.len(), wrong.join("\n"));
}

/// By `cargo test --release --test it table::large -- --ignored --nocapture`.
mod large {
    use super::*;
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    #[test]
    #[ignore = "large: a can at 40 places"]
    fn a_can_at_forty_places() {
        let mut places = vec![];
        // The strip before the belly, and beside the middle.
        places.extend([-0.4, -0.3, -0.2, -0.1, 0.0, 0.1, 0.2, 0.3, 0.4].map(|y| (0.27, y)));
        for x in [0.35, 0.45, 0.55] {
            places.extend([-0.35, -0.25, -0.15, 0.0, 0.15, 0.25, 0.35].map(|y| (x, y)));
        }
        // And anywhere else that a hand surely gets to.
        let mut rng = ChaCha8Rng::seed_from_u64(9101);
        while places.len() < 40 {
            let (x, y) = (rng.random_range(0.27..0.65), rng.random_range(-0.45..0.45));
            places.extend((f64::hypot(x, y) < 0.68).then_some((x, y)));
        }
        let missed: Vec<String> =
            places.iter().enumerate().filter_map(|(k, &(x, y))| finds(x, y, 100 + k as u64).err()).collect();
        assert!(missed.is_empty(), "{} of {} missed:\n{}", missed.len(), places.len(), missed.join("\n"));
    }

    #[test]
    #[ignore = "large: 60 conversations"]
    fn sixty_conversations_of_put_it_far_and_bring_it_near() {
        let (mut against, mut done, mut asked) = (Vec::new(), 0, 0);
        for seed in 7001..7061 {
            let stage = Stage::new(&repository("mjcf/max/table.xml"), &StageOptions::default()).unwrap();
            let mut actor = Actor::new(learned(), stage.handle(), ["left_hand", "right_hand"], seed).unwrap();
            stage.place(&actor.ready()).unwrap();
            let mut talk = Conversation::new(actor).unwrap();
            say(&mut talk, "is there something in front of you?");
            let requests = ["put it as far away as possible", "bring it near"];
            for request in requests.into_iter().cycle().take(4).chain([
                "again",
                "don't put it far away",
                "how far is it?",
            ]) {
                let before = positions(&stage);
                let (time, reply) = (stage.time(), say(&mut talk, request));
                let after = positions(&stage);
                asked += usize::from(reply.done.is_some());
                done += usize::from(reply.done == Some(true));
                let moved = before
                    .iter()
                    .zip(&after)
                    .map(|(a, b)| b - a)
                    .max_by(|a, b| a.norm().total_cmp(&b.norm()));
                let moved = moved.unwrap();
                // What is put somewhere stands on the table.
                let falls = before.iter().zip(&after).any(|(a, b)| a.z > TOP && b.z < TOP);
                let wrong = match (reply.intent, reply.done) {
                    (Intent::PutFar, Some(true)) => moved.x < -0.03 || falls,
                    (Intent::BringNear, Some(true)) => moved.x > 0.03 || falls,
                    (Intent::Dont | Intent::HowFar, _) => stage.time() > time,
                    _ => false,
                };
                if wrong {
                    against.push(format!("seed {seed}: {request}: {moved:.3?} {}", reply.said));
                }
            }
        }
        eprintln!("{done} of {asked} done");
        assert!(against.is_empty(), "{} against what was asked for:\n{}", against.len(), against.join("\n"));
    }

    fn positions(stage: &Stage) -> Vec<Vector3<f64>> {
        ["box", "can", "brick", "bottle"].map(|name| place(stage, name)).to_vec()
    }
}
