//! Getting out of the way of what comes near, by the schema and the aura.

use crate::common::{babble, max, repository, truth};
use bodyschema::agent::Agent;
use bodyschema::creature::{JointSelection, Posture};
use bodyschema::geometry::Shape;
use bodyschema::interaction::{Actor, Avoiding, PlaceGoal};
use bodyschema::learning::Certainty;
use bodyschema::peripersonal::{Barrier, OwnBody, PlaceVelocity, VelocityProgram};
use bodyschema::senses::{Aura, Toucher};
use bodyschema::simulation::{ProbePath, Stage, StageOptions, Substance, Thing};
use nalgebra::{Isometry3, Point3, Vector3};

const RADIUS: f64 = 0.03;

/// Max with a ball far away, its hands raised.
fn beside_a_ball() -> (Stage, Actor, usize) {
    let body = max("torso");
    let agent = Agent::of(&body).unwrap();
    let touches = babble(&body, &agent, 300, 1, 2);
    let own =
        OwnBody::new(&agent, truth(&body), Certainty::Exact, touches.iter().map(|touch| &touch.posture));
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
    stage.sense(Aura::watch_out);
    let hand = actor.hands[1].limb;
    let middle =
        stage.root_pose() * Point3::from(actor.frames()[hand].origin) + Vector3::new(0.2, -0.1, -0.05);
    let time = stage.time();
    stage.send_thing(thing, ProbePath(vec![(time, middle.coords)]));
    actor.step(&at_ease).unwrap();
    let approach = &stage.sense(|aura: &mut Aura| aura.approaches().next().cloned()).unwrap();
    assert_eq!(approach.object, thing);
    let frame = stage.limb_pose(approach.limb);
    let nearest = frame * Point3::from(approach.point + approach.toward * approach.distance);
    let off = (nearest - stage.thing_pose(thing).translation.vector).coords.norm() - RADIUS;
    assert!(off.abs() < 1e-4, "{off}");
    assert!((approach.toward.norm() - 1.0).abs() < 1e-9);
}

#[test]
fn a_hand_stays_at_its_place_while_the_head_gets_out_of_the_way() {
    let (stage, mut actor, thing) = beside_a_ball();
    let ready = actor.ready();
    let receptors = actor.own.receptors_on(&[actor.own.creature().limb("head").unwrap()]);
    let ahead = |&receptor: &usize| actor.feels_at(receptor).1.x;
    let face = receptors.into_iter().max_by(|a, b| ahead(a).total_cmp(&ahead(b))).unwrap();
    let place = actor.own.place(actor.hands[0].tip);
    let mut comes_at_the_face = |avoids: bool| {
        stage.place(&ready).unwrap();
        actor.was_placed();
        let (point, _) = actor.feels_at(face);
        let x_wr = stage.root_pose();
        let at = |off: f64| (x_wr * Point3::from(point + Vector3::new(off, 0.3 * off, 0.0))).coords;
        let path = ProbePath(vec![(stage.time(), at(0.8)), (stage.time() + 3.0, at(-0.4))]);
        let end = path.end();
        stage.send_thing(thing, path);
        actor.step(&ready).unwrap();
        let tip = |actor: &Actor| actor.frames()[place.limb].point(&place.point);
        let begin = tip(&actor);
        let mut avoiding = Avoiding::new(&mut actor);
        avoiding.goal = Some(PlaceGoal { place, point: begin, velocity: Vector3::zeros() });
        let (mut touched, mut off) = (false, 0.0_f64);
        while stage.time() < end {
            let felt = if avoids { avoiding.step(&mut actor) } else { actor.step(&ready) }.unwrap();
            touched |= felt.iter().any(|contact| contact.by == Toucher::Thing(thing));
            off = off.max((tip(&actor) - begin).norm());
        }
        let moved = actor.posture().iter().zip(&ready).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        (touched, off, moved)
    };
    assert!(comes_at_the_face(false).0, "whoever holds still is touched");
    let (touched, off, moved) = comes_at_the_face(true);
    assert!(!touched);
    assert!(off < 0.02, "{off}");
    assert!(moved > 0.05, "{moved}");
}

#[test]
fn joint_velocities_keep_barriers_and_ranges_and_say_what_they_give_up() {
    let (_stage, actor, _) = beside_a_ball();
    let own = &actor.own;
    let posture = actor.posture();
    let frames = own.frames(&posture);
    let hand = actor.hands[0].limb;
    let point = frames[hand].origin;
    let joints: Vec<usize> = (0..own.creature().joints().len()).collect();
    const FASTEST: f64 = 3.0;
    const SECONDS: f64 = 1e-4;
    // Where a point of the hand goes, by the difference of two postures.
    let goes = |barriers: &[Barrier]| {
        let mut program = VelocityProgram::new(own, &posture, &frames, &joints, FASTEST, SECONDS);
        let velocity = Vector3::new(0.3, -0.1, 0.2);
        program.want(&PlaceVelocity { limb: hand, point, velocity, weight: 100.0 });
        barriers.iter().for_each(|barrier| program.keep(barrier));
        let found = program.solve().unwrap();
        let after = &found.posture;
        let far = after.iter().zip(&posture).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        assert!(far <= FASTEST * SECONDS + 1e-12, "{far}");
        assert!(own.creature().elements().filter(|at| !at.is_ball()).all(|at| {
            let [low, high] = at.range;
            (low..=high).contains(&after[at.coordinate()])
        }));
        let moved = own.frames(after)[hand].point(&frames[hand].inverse_point(&point)) - point;
        (moved / SECONDS, found.given_up)
    };
    let (free, given_up) = goes(&[]);
    assert!((free - Vector3::new(0.3, -0.1, 0.2)).norm() < 0.02 && given_up == 0.0, "{free}");
    let barrier = |normal: Vector3<f64>, rate: f64, yields: bool| Barrier {
        limb: hand,
        other: None,
        points: [point; 2],
        normal,
        rate,
        yields,
    };
    let wall = [barrier(-Vector3::x(), -0.05, false), barrier(Vector3::y(), 0.0, false)];
    let (walled, given_up) = goes(&wall);
    assert!((walled - Vector3::new(0.05, 0.0, 0.2)).norm() < 0.02, "{walled}");
    assert!(walled.x < 0.0505 && walled.y > -5e-4 && given_up < 1e-4, "{walled} {given_up}");
    // Two that ask for opposite ways cannot both be kept; one that does not yield is.
    let torn = [barrier(-Vector3::x(), -0.05, false), barrier(Vector3::x(), 1.0, true)];
    let (torn, given_up) = goes(&torn);
    assert!(torn.x < 0.0505 && torn.x > 0.04, "{torn}");
    assert!((given_up - 0.95).abs() < 0.01, "{given_up}");
}
