//! Getting out of the way of what comes near, by the schema and the aura.

mod common;

use bodyschema::babbling::start_posture;
use bodyschema::creature::JointSelection;
use bodyschema::interaction::{Actor, Avoiding, ProbePath, Scene, Thing, Touched};
use bodyschema::learning::Input;
use bodyschema::peripersonal::OwnBody;
use bodyschema::senses::Aura;
use bodyschema::skin::{Shape, skin_of};
use common::{babble, max, repository, truth};
use nalgebra::{Isometry3, Point3, Vector3};

const RADIUS: f64 = 0.03;

/// Max with a ball far away, its hands raised.
fn beside_a_ball() -> (Actor, usize) {
    let body = max("torso");
    let skin = skin_of(&body);
    let touches = babble(&body, &skin, 300, 1, 2);
    let own = OwnBody::new(&body.creature, &skin, truth(&body), &touches, Input::Receptor)
        .with_schema(truth(&body));
    let ball = Thing {
        name: "ball".into(),
        shape: Shape::Sphere { radius: RADIUS },
        pose: Isometry3::translation(3.0, 0.0, 1.0),
        fixed: false,
    };
    let selection: JointSelection = "torso".parse().unwrap();
    let scene = Scene::new(&repository("mjcf/max/max.xml"), &selection, None, &[ball]).unwrap();
    let mut actor = Actor::new(own, scene, ["left_hand", "right_hand"], 1).unwrap();
    let thing = actor.scene.thing("ball").unwrap();
    let ready = actor.ready();
    actor.place(&ready).unwrap();
    (actor, thing)
}

/// The ball comes from the front and goes on, past the tip of the left hand by `aside` to the left, metres; the largest
/// change of a coordinate, coordinate by coordinate, and whether the ball was felt.
fn comes(actor: &mut Actor, thing: usize, aside: f64, avoids: bool) -> (Vec<f64>, bool) {
    let ready = actor.ready();
    let tip = actor.hands[0].tip;
    actor.place(&ready).unwrap();
    let (point, _) = actor.feels_at(tip);
    let x_wr = actor.scene.root_pose();
    let at = |ahead: f64| (x_wr * Point3::from(point + Vector3::new(ahead, aside, 0.0))).coords;
    let time = actor.scene.time();
    let path = ProbePath(vec![(time, at(0.8)), (time + 1.0 / 0.4, at(-0.1))]);
    let end = path.end();
    actor.scene.send(thing, path);
    actor.scene.step(&ready).unwrap();
    let mut avoiding = Avoiding::new(actor).unwrap();
    let (mut moved, mut touched) = (vec![0.0_f64; ready.len()], false);
    while actor.scene.time() < end {
        let felt = if avoids { avoiding.step(actor) } else { actor.scene.step(&ready) }.unwrap();
        touched |= felt.iter().any(|feeling| feeling.what == Touched::Thing(thing));
        for (most, (now, before)) in moved.iter_mut().zip(actor.posture().iter().zip(&ready)) {
            *most = most.max((now - before).abs());
        }
    }
    (moved, touched)
}

#[test]
fn a_hand_gets_out_of_the_way_and_all_else_keeps_still() {
    let (mut actor, thing) = beside_a_ball();
    let (_, touched) = comes(&mut actor, thing, 0.0, false);
    assert!(touched, "whoever holds still is touched");
    let (moved, touched) = comes(&mut actor, thing, 0.0, true);
    assert!(!touched);
    let arm: Vec<usize> = actor.hands[0]
        .arm
        .iter()
        .map(|&joint| &actor.own.creature.joints()[joint])
        .flat_map(|joint| joint.first_coordinate()..joint.first_coordinate() + joint.dofs.len())
        .collect();
    for (q, moved) in moved.iter().enumerate() {
        assert!(arm.contains(&q) || *moved == 0.0, "coordinate {q} moved by {moved}");
    }
    assert!(moved.iter().any(|moved| *moved > 0.05));
}

#[test]
fn what_passes_moves_nothing() {
    let (mut actor, thing) = beside_a_ball();
    let (moved, touched) = comes(&mut actor, thing, 0.3, true);
    assert!(!touched);
    assert!(moved.iter().all(|moved| *moved == 0.0), "{moved:?}");
}

#[test]
fn the_aura_tells_where_the_nearest_point_of_a_thing_is() {
    let (mut actor, thing) = beside_a_ball();
    let at_ease = start_posture(&actor.own.creature);
    actor.place(&at_ease).unwrap();
    let mut aura = Aura::new(&actor.scene.body, &actor.scene.skin, &actor.scene.data);
    let hand = actor.hands[1].limb;
    let middle =
        actor.scene.root_pose() * Point3::from(actor.frames()[hand].origin) + Vector3::new(0.2, -0.1, -0.05);
    let time = actor.scene.time();
    actor.scene.send(thing, ProbePath(vec![(time, middle.coords)]));
    actor.scene.step(&at_ease).unwrap();
    let scene = &actor.scene;
    aura.step(scene.time(), &scene.body, &scene.skin, &scene.data);
    let approach = aura.approaches().next().unwrap();
    assert_eq!(approach.object, thing);
    let frame = scene.body.limb_pose(&scene.data, approach.limb).unwrap();
    let nearest = frame * Point3::from(approach.point + approach.toward * approach.distance);
    let off = (nearest - scene.thing_pose(thing).translation.vector).coords.norm() - RADIUS;
    assert!(off.abs() < 1e-4, "{off}");
    assert!((approach.toward.norm() - 1.0).abs() < 1e-9);
}
