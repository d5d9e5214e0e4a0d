//! A stick that a partner puts into a hand: its tip is learned by touching himself with it, and is then a part of him.

use crate::common::{babble, max, repository, truth};
use crate::conversation::say;
use crate::interaction::learned_max;
use bodyschema::agent::Agent;
use bodyschema::geometry::Shape;
use bodyschema::interaction::{Actor, Conversation, Intent, understood};
use bodyschema::learning::{Certainty, Input, Learner, SecondOrder};
use bodyschema::peripersonal::{OwnBody, STICK_TIP};
use bodyschema::senses::Toucher;
use bodyschema::simulation::{Stage, StageOptions, Thing};
use nalgebra::{Isometry3, Point3, Vector3};

/// Half of the stick's length in the scene, without its round ends, metres.
const HALF: f64 = 0.25;

fn beside_a_stick(own: OwnBody) -> (Stage, Conversation) {
    let scene = repository("mjcf/max/table_stick.xml");
    let stage = Stage::new(&scene, &StageOptions::default()).unwrap();
    let mut actor = Actor::new(own, stage.handle(), ["left_hand", "right_hand"], 1).unwrap();
    stage.place(&actor.ready()).unwrap();
    (stage, Conversation::new(actor).unwrap())
}

/// Where the tip of the stick truly is, in the hand's frame: the end that is farther from the hand.
fn true_tip(stage: &Stage, hand: usize) -> Vector3<f64> {
    let stick = stage.thing("stick").unwrap();
    let x_hs = stage.limb_pose(hand).inverse() * stage.thing_pose(stick);
    let ends = [HALF, -HALF].map(|z| (x_hs * Point3::new(0.0, 0.0, z)).coords);
    let [a, b] = ends;
    if a.norm() > b.norm() { a } else { b }
}

#[test]
fn a_stick_that_he_is_given_extends_his_reach() {
    let (stage, mut talk) = beside_a_stick(learned_max(400));
    let stick = stage.thing("stick").unwrap();
    let lies = stage.thing_pose(stick).translation.vector;
    for request in ["is there something in front of you?", "lean forward and put it as far away as possible"]
    {
        let reply = say(&mut talk, request);
        assert_eq!(reply.done, Some(true), "{}", reply.said);
    }
    let thing = talk.hear("how many things are there?").unwrap().felt[0]["thing"].as_u64().unwrap() as usize;
    say(&mut talk, "lean back");
    // It is too far for either hand, and he says so by the map of what he reaches, too.
    for hand in ["left", "right"] {
        let reply = say(&mut talk, &format!("touch it with your {hand} hand"));
        assert_eq!(reply.done, Some(false), "{}", reply.said);
    }
    let reply = say(&mut talk, "is it near or far?");
    assert!(reply.said.contains("only if I lean forward"), "{}", reply.said);
    assert_eq!(say(&mut talk, "touch it with the stick").done, Some(false), "he has none yet");
    assert_eq!(say(&mut talk, "don't take the stick").intent, Intent::Dont);
    assert!(talk.actor.stick().is_none());
    say(&mut talk, "do you hold a stick?");
    assert!(talk.actor.stick().is_none(), "a question is answered");

    let reply = say(&mut talk, "take the stick with your right hand");
    let reply = if reply.asks { say(&mut talk, "yes") } else { reply };
    assert_eq!((reply.intent, reply.done), (Intent::TakeStick, Some(true)), "{}", reply.said);
    let held = talk.actor.stick().unwrap();
    let (hand, known) = (talk.actor.hands[held.hand].limb, held.known.unwrap());
    assert_eq!(talk.actor.hands[held.hand].name, "right_hand");
    let off = (known.tool.tip - true_tip(&stage, hand)).norm();
    assert!(off < 1e-3, "the tip is {} mm off", 1e3 * off);
    assert!(off < 1.5 * known.within, "{} mm off, known to {} mm", 1e3 * off, 1e3 * known.within);

    assert!(say(&mut talk, "what are you holding?").said.contains("I hold the stick with my right hand"));
    let reply = say(&mut talk, "take the stick with your left hand");
    assert_eq!(reply.done, Some(false), "he holds it with the right one: {}", reply.said);
    // The stick that he holds is near, and does not come at him.
    let reply = say(&mut talk, "watch out");
    assert!(reply.done == Some(true) && reply.said.contains("nothing came at me"), "{}", reply.said);
    for request in ["feel its shape", "lift it", "lift it with your right hand", "search the table"] {
        let reply = say(&mut talk, request);
        assert!(reply.said.contains("in the way"), "{request}: {}", reply.said);
        assert_eq!(reply.done, Some(false), "{request}");
    }
    let reply = say(&mut talk, "is it near or far?");
    assert!(reply.said.contains("the stick reaches it without leaning"), "{}", reply.said);
    let reply = say(&mut talk, "touch it");
    assert_eq!((reply.intent, reply.done), (Intent::Touch, Some(true)), "{}", reply.said);
    assert!(reply.said.contains("with the stick"), "{}", reply.said);
    let met = stage.data().contacts().any(|contact| {
        let bodies = contact.geoms.map(|geom| stage.body().model.geom_body(geom));
        bodies.contains(&stick) && bodies.contains(&thing) && contact.distance <= 0.0
    });
    assert!(met, "the stick touches the {}", stage.thing_name(thing));
    let reply = say(&mut talk, "how far is it?");
    let told = |of: &str| -> f64 {
        let before = reply.said.split(of).next().unwrap();
        before.split_whitespace().last().unwrap().parse().unwrap()
    };
    let (from_hand, told_of_stick) =
        (told(" cm from my right hand"), reply.said.split("the stick in my hand is ").nth(1));
    let from_stick: f64 = told_of_stick.unwrap().split(' ').next().unwrap().parse().unwrap();
    // Of the thing's middle.
    assert!(from_hand > 20.0 && from_stick < 5.0, "{}", reply.said);
    let reply = say(&mut talk, "let go");
    assert!(talk.actor.stick().is_some() && reply.said.contains("but the stick"), "{}", reply.said);
    let reply = say(&mut talk, "touch your nose with the stick");
    assert_eq!((reply.intent, reply.done), (Intent::TouchOwn, Some(true)), "{}", reply.said);
    let reply = say(&mut talk, "what do you feel?");
    assert!(reply.said.starts_with("I feel the stick on my "), "{}", reply.said);

    let reply = say(&mut talk, "give me back the stick");
    assert_eq!((reply.intent, reply.done), (Intent::GiveStickBack, Some(true)), "{}", reply.said);
    assert!((stage.thing_pose(stick).translation.vector - lies).norm() < 0.02, "where it was");
    assert_eq!(talk.actor.own.skin().receptor(STICK_TIP), None, "the stick is no part of him any more");
    assert_eq!(say(&mut talk, "touch it with the stick").done, Some(false));
}

#[test]
fn a_stick_that_he_cannot_make_out_he_does_not_use() {
    // He is sure of a body that is not his: his elbows are 3 cm from where he believes.
    let body = max("torso");
    let agent = Agent::of(&body).unwrap();
    let mut schema = truth(&body);
    for (k, joint) in agent.creature().joints().iter().enumerate() {
        if joint.name.contains("elbow") {
            schema.positions[k] *= 1.1;
        }
    }
    let (stage, mut talk) = beside_a_stick(learned_max(400).with_schema(schema));
    let reply = say(&mut talk, "here is a stick, take it");
    assert_eq!((reply.intent, reply.done), (Intent::TakeStick, Some(false)), "{}", reply.said);
    assert!(reply.said.contains("could not tell where its tip is"), "{}", reply.said);
    assert!(talk.actor.stick().is_none());
    let stick = stage.thing("stick").unwrap();
    assert!(stage.thing_pose(stick).translation.vector.y < -1.0, "he gave it back");
}

#[test]
fn what_is_slender_and_moves_freely_is_a_stick_and_nothing_else_is() {
    let (stage, talk) = beside_a_stick(learned_max(400));
    let grip = talk.actor.grip_of(1);
    let (at, up) = (Vector3::new(0.0, 0.0, -0.05), Vector3::z());
    for (name, is_stick) in [("box", false), ("bottle", false), ("table", false), ("stick", true)] {
        let thing = stage.thing(name).unwrap();
        let given = [up, -up, Vector3::x(), -Vector3::x(), Vector3::y(), -Vector3::y()]
            .iter()
            .any(|direction| stage.give_stick(thing, grip, &at, direction).unwrap());
        assert_eq!(given, is_stick, "{name}");
    }
}

#[test]
fn what_is_said_of_a_stick_is_about_a_stick() {
    for (request, intent, moves) in [
        ("take the stick with your right hand", Intent::TakeStick, true),
        ("here is a stick, take it", Intent::TakeStick, true),
        ("please pick up the stick", Intent::TakeStick, true),
        ("can you hold this stick?", Intent::TakeStick, true),
        ("give me back the stick", Intent::GiveStickBack, true),
        ("let go of the stick", Intent::GiveStickBack, true),
        ("put the stick down", Intent::GiveStickBack, true),
        ("touch the box with the stick", Intent::Touch, true),
        ("use the stick to touch it", Intent::Touch, true),
        ("touch your chin with the stick", Intent::TouchOwn, true),
        ("stick it at the very back of the table", Intent::PutFar, true),
        ("how long is the stick?", Intent::StickKnown, false),
        ("do you have the stick?", Intent::StickKnown, false),
        ("don't take the stick", Intent::Dont, false),
        ("don't touch it with the stick", Intent::Dont, false),
        ("did you take the stick?", Intent::Report, false),
    ] {
        let heard = understood(request);
        assert_eq!((heard.intent, heard.leave.is_some()), (intent, moves), "{request}");
        assert_eq!(
            heard.stick,
            request.contains("with the stick") || request.contains("use the"),
            "{request}"
        );
    }
}

#[test]
fn what_a_held_stick_meets_is_felt_at_once_from_below_as_from_above() {
    const RADIUS: f64 = 0.008;
    let scene = repository("mjcf/max/table_stick.xml");
    let own = learned_max(400);
    let held_among = |things: Vec<Thing>| {
        let stage = Stage::new(&scene, &StageOptions { things, ..StageOptions::default() }).unwrap();
        let mut actor = Actor::new(own.clone(), stage.handle(), ["left_hand", "right_hand"], 1).unwrap();
        stage.place(&actor.ready()).unwrap();
        let (grip, limb) = (actor.grip_of(1), actor.hands[1].limb);
        let end = own.skin().receptors[grip].position;
        let x_wl = stage.limb_pose(limb);
        let mut level = x_wl * end;
        level.z = 0.0;
        let level = x_wl.rotation.inverse() * level;
        let stick = stage.thing("stick").unwrap();
        assert!(stage.give_stick(stick, grip, &end, &level).unwrap());
        (stage, actor, stick)
    };
    let tip_after = |stage: &Stage, posture: &[f64], stick: usize| {
        stage.handle().step(posture).unwrap();
        stage.thing_pose(stick) * Point3::new(0.0, 0.0, HALF)
    };
    // How an arm's joints raise the tip.
    let (stage, mut actor, stick) = held_among(Vec::new());
    let ready = actor.ready().to_vec();
    let tip = tip_after(&stage, &ready, stick);
    let turned = |joint: usize, angle: f64| {
        let mut posture = ready.clone();
        posture[joint] += angle;
        posture
    };
    let raising = |joint: usize| (tip_after(&stage, &turned(joint, 1e-3), stick) - tip).z / 1e-3;
    let rates = actor.hands[1].arm.iter().map(|&joint| (joint, raising(joint)));
    let (joint, rate) = rates.max_by(|a, b| a.1.abs().total_cmp(&b.1.abs())).unwrap();
    for side in [1.0, -1.0] {
        let half_extents = [0.02, 0.02, 0.01];
        let roof = Thing {
            name: "roof".into(),
            shape: Shape::Box { half_extents },
            pose: Isometry3::translation(tip.x, tip.y, tip.z + side * (RADIUS + 1e-3 + half_extents[2])),
            fixed: true,
            substance: Default::default(),
        };
        let (stage, _, stick) = held_among(vec![roof]);
        let roof = stage.thing("roof").unwrap();
        let depth = (0..1000).find_map(|k| {
            let felt = stage.handle().step(&turned(joint, side * 5e-6 * f64::from(k) / rate)).unwrap();
            let met = felt.iter().any(|contact| contact.by == Toucher::Through(roof));
            let between = |contact: &bodyschema::mujoco::Contact| {
                let bodies = contact.geoms.map(|geom| stage.body().model.geom_body(geom));
                bodies.contains(&stick) && bodies.contains(&roof)
            };
            let data = stage.data();
            met.then(|| data.contacts().filter(between).map(|met| -met.distance).fold(0.0, f64::max))
        });
        let depth = depth.expect("it is felt");
        assert!(depth < 1e-4, "felt {} mm deep on side {side}", 1e3 * depth);
    }
}

/// By `cargo test large:: -- --ignored`.
mod large {
    use super::*;

    #[test]
    #[ignore = "large: a stick is made out twice"]
    fn how_well_he_knows_a_stick_counts_how_well_he_knows_his_body() {
        let body = max("torso");
        let agent = Agent::of(&body).unwrap();
        let schema = truth(&body);
        let touches = babble(&body, &agent, 300, 1, 2);
        let mut learner = SecondOrder::new(&agent, Input::Contact, 0);
        touches.iter().for_each(|touch| learner.touch(&touch.felt(Input::Contact)));
        // The same body and the same motions: joints and axes known exactly, and to so many metres and radians each.
        let within = [0.0_f64, 5e-5].map(|deviation| {
            let (mut account, _) = learner.account(&schema);
            let covariance = &mut account.observability.covariance;
            covariance.fill(0.0);
            covariance.fill_diagonal(deviation.powi(2));
            let certainty = Certainty::Estimated(Box::new(account));
            let (_, mut talk) = beside_a_stick(OwnBody::new(
                &agent,
                schema.clone(),
                certainty,
                touches.iter().map(|touch| &touch.posture),
            ));
            say(&mut talk, "take the stick with your right hand");
            talk.actor.stick().unwrap().known.unwrap().within
        });
        // Some ten joints between the hand and what is touched, each tenths of a metre away.
        assert!(within[1] > 1.5 * within[0] && within[1] < 2e-3, "{within:?}");
    }
}
