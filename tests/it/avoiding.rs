//! Getting out of the way of what comes near, by the schema and the aura.

use crate::common::{babble, max, repository, truth};
use bodyschema::agent::Agent;
use bodyschema::creature::{JointSelection, Posture};
use bodyschema::geometry::Shape;
use bodyschema::interaction::{Actor, Avoiding};
use bodyschema::learning::Certainty;
use bodyschema::peripersonal::OwnBody;
use bodyschema::senses::Toucher;
use bodyschema::simulation::{ProbePath, Stage, StageOptions, Substance, Thing};
use nalgebra::{Isometry3, Point3, Vector3};

const RADIUS: f64 = 0.03;

/// Max with a ball far away, its hands raised.
fn beside_a_ball() -> (Stage, Actor, usize) {
    let body = max("torso");
    let agent = Agent::of(&body).unwrap();
    let touches = babble(&body, &agent, 300, 1, 2);
    let own = OwnBody::new(&agent, truth(&body), Certainty::Exact, &touches);
    let ball = Thing {
        name: "ball".into(),
        shape: Shape::Sphere { radius: RADIUS },
        pose: Isometry3::translation(3.0, 0.0, 1.0),
        fixed: false,
        substance: Substance::default(),
    };
    let joints: JointSelection = "torso".parse().unwrap();
    let options = StageOptions { joints, things: vec![ball], ..StageOptions::default() };
    let stage = Stage::new(&repository("mjcf/max/max.xml"), &options).unwrap();
    let mut actor = Actor::new(own, stage.handle(), ["left_hand", "right_hand"], 1).unwrap();
    let thing = stage.thing("ball").unwrap();
    stage.place(&actor.ready()).unwrap();
    (stage, actor, thing)
}

/// The ball comes from the front and goes on, past the tip of the left hand by `aside` to the left, metres; the largest
/// change of a coordinate, coordinate by coordinate, and whether the ball was felt.
fn comes(stage: &Stage, actor: &mut Actor, thing: usize, aside: f64, avoids: bool) -> (Vec<f64>, bool) {
    let ready = actor.ready();
    let tip = actor.hands[0].tip;
    stage.place(&ready).unwrap();
    actor.was_placed();
    let (point, _) = actor.feels_at(tip);
    let x_wr = stage.root_pose();
    let at = |ahead: f64| (x_wr * Point3::from(point + Vector3::new(ahead, aside, 0.0))).coords;
    let time = stage.time();
    let path = ProbePath(vec![(time, at(0.8)), (time + 1.0 / 0.4, at(-0.1))]);
    let end = path.end();
    stage.send_thing(thing, path);
    actor.step(&ready).unwrap();
    let mut avoiding = Avoiding::new(actor);
    let (mut moved, mut touched) = (vec![0.0_f64; ready.len()], false);
    while stage.time() < end {
        let felt = if avoids { avoiding.step(actor) } else { actor.step(&ready) }.unwrap();
        touched |= felt.iter().any(|contact| contact.by == Toucher::Thing(thing));
        for (most, (now, before)) in moved.iter_mut().zip(actor.posture().iter().zip(&ready)) {
            *most = most.max((now - before).abs());
        }
    }
    (moved, touched)
}

#[test]
fn a_hand_gets_out_of_the_way_and_all_else_keeps_still() {
    let (stage, mut actor, thing) = beside_a_ball();
    let (_, touched) = comes(&stage, &mut actor, thing, 0.0, false);
    assert!(touched, "whoever holds still is touched");
    let (moved, touched) = comes(&stage, &mut actor, thing, 0.0, true);
    assert!(!touched);
    let arm: Vec<usize> = actor.hands[0]
        .arm
        .iter()
        .map(|&joint| &actor.own.creature().joints()[joint])
        .flat_map(|joint| joint.coordinates())
        .collect();
    for (q, moved) in moved.iter().enumerate() {
        assert!(arm.contains(&q) || *moved == 0.0, "coordinate {q} moved by {moved}");
    }
    assert!(moved.iter().any(|moved| *moved > 0.05));
}

#[test]
fn what_passes_moves_nothing() {
    let (stage, mut actor, thing) = beside_a_ball();
    let (moved, touched) = comes(&stage, &mut actor, thing, 0.3, true);
    assert!(!touched);
    assert!(moved.iter().all(|moved| *moved == 0.0), "{moved:?}");
}

#[test]
fn the_aura_tells_where_the_nearest_point_of_a_thing_is() {
    let (stage, mut actor, thing) = beside_a_ball();
    let at_ease = Posture::start(actor.own.creature());
    stage.place(&at_ease).unwrap();
    stage.grow_aura();
    let hand = actor.hands[1].limb;
    let middle =
        stage.root_pose() * Point3::from(actor.frames()[hand].origin) + Vector3::new(0.2, -0.1, -0.05);
    let time = stage.time();
    stage.send_thing(thing, ProbePath(vec![(time, middle.coords)]));
    actor.step(&at_ease).unwrap();
    let approach = &stage.approaches()[0];
    assert_eq!(approach.object, thing);
    let frame = stage.limb_pose(approach.limb);
    let nearest = frame * Point3::from(approach.point + approach.toward * approach.distance);
    let off = (nearest - stage.thing_pose(thing).translation.vector).coords.norm() - RADIUS;
    assert!(off.abs() < 1e-4, "{off}");
    assert!((approach.toward.norm() - 1.0).abs() < 1e-9);
}
