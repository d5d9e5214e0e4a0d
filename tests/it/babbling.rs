//! Babbling: the same touches for the same seed, every touch confirmed by the engine, and no contact
//! jumped over on the way.

use std::sync::Arc;

use crate::common::{babble, creature, is_newer_engine, max, repository, take, two_arms};
use crate::scale;
use bodyschema::agent::Agent;
use bodyschema::babbling::Babbler;
use bodyschema::creature::{Body, DofKind, JointSelection, Posture};
use bodyschema::mujoco::{Contact, Data, Model};
use bodyschema::senses::RecordedTouch;
use bodyschema::session::TouchWriter;
use bodyschema::simulation::{DEEPEST, Ending, MotionName, Movers, SelfContact};
use bodyschema::skin::{GrowOptions, Skin, grow};
use nalgebra::{Point3, Quaternion, UnitQuaternion};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

#[path = "../../benches/meshes/mod.rs"]
mod meshes;

/// How far a coordinate may be out of its range, by rounding.
const RANGE: f64 = 1e-9;
/// How far apart in the world the two ends of a touch may be, metres.
const SAME_PLACE: f64 = 2e-6;
/// How deep limbs may be in each other on the way to a stop, metres: the engine's own error is part of it.
const JUMPED: f64 = 5e-6;
/// Motions after which a body begins anew where it starts, lest it stays where it got caught.
const MOTIONS_PER_BOUT: usize = 50;
/// Parts of the rest of a motion, of which one micrometre is one or the other.
const ONWARD: [f64; 5] = [1e-6, 3e-6, 1e-5, 3e-5, 1e-4];
/// Steps in which a path is looked at again.
const STEPS: usize = 1000;

const CAPSULE: &str = r#"type="capsule" size="0.03 0.2""#;
const TRUNK: &str = r#"type="capsule" size="0.12 0.2""#;

/// Two chains of ball joints and slides on a free trunk, all of capsules and spheres.
const BALLS: &str = r#"<mujoco model="balls">
  <compiler angle="radian" autolimits="true"/>
  <worldbody>
    <body name="trunk" pos="0 0 1" quat="0.6 0 0.8 0">
      <freejoint/>
      <geom type="sphere" size="0.15"/>
      <site name="t" type="sphere" size="0.2"/>
      <body name="left" pos="0 0.2 0" quat="0.5 -0.5 0.5 0.5">
        <joint name="left" type="ball" range="0 2.6"/>
        <geom type="capsule" fromto="0 0 0 0.2 0 0" size="0.02"/>
        <body name="left_hand" pos="0.2 0 0" quat="0.9 0.1 0.2 -0.3">
          <joint name="left_out" type="slide" axis="1 0 0" range="0 0.1"/>
          <joint name="left_hand" type="ball"/>
          <geom type="capsule" fromto="0 0 0 0.15 0 0" size="0.03"/>
          <site name="l" type="sphere" size="0.3"/>
        </body>
      </body>
      <body name="right" pos="0 -0.2 0">
        <joint name="right" type="ball" range="0 1.2"/>
        <geom type="capsule" fromto="0 0 0 0.2 0 0" size="0.02"/>
        <body name="right_hand" pos="0.2 0 0">
          <joint name="right_hand" axis="0 0.3 1" range="-2.5 2.5"/>
          <geom type="capsule" fromto="0 0 0 0.2 0 0" size="0.03"/>
          <site name="r" type="sphere" size="0.3"/>
        </body>
      </body>
    </body>
  </worldbody>
  <sensor><touch site="t"/><touch site="l"/><touch site="r"/></sensor>
</mujoco>"#;

fn arms(trunk: &str, shape: &str) -> Body {
    creature(&two_arms(trunk, shape))
}

/// Creatures of spheres and capsules alone.
fn exact() -> Vec<(&'static str, Body)> {
    vec![("capsules", arms(TRUNK, CAPSULE)), ("balls", creature(BALLS)), ("Max's torso", max("torso"))]
}

/// Creatures with shapes that are no capsules.
fn other_shapes() -> Vec<(&'static str, Body)> {
    vec![
        ("sheets", arms(r#"type="box" size="0.12 0.0001 0.3""#, r#"type="box" size="0.2 0.03 0.0001""#)),
        ("boxes", arms(r#"type="box" size="0.12 0.1 0.3""#, r#"type="box" size="0.2 0.03 0.04""#)),
        (
            "ellipsoids",
            arms(r#"type="ellipsoid" size="0.12 0.1 0.3""#, r#"type="ellipsoid" size="0.2 0.03 0.04""#),
        ),
        ("cylinders", arms(r#"type="cylinder" size="0.12 0.3""#, r#"type="cylinder" size="0.04 0.15""#)),
    ]
}

/// What the engine says about the contacts of a body, as far as babbling heeds them.
struct Judge<'b> {
    body: &'b Body,
    data: Data,
    /// Geom pairs that overlap at the start: joined by construction.
    joined: Vec<[usize; 2]>,
}

impl<'b> Judge<'b> {
    /// Of a body whose surface may be open to itself by its file or not.
    fn of_surface(body: &'b Body) -> Judge<'b> {
        let data = Data::new(body.model.clone()).unwrap();
        let joined = SelfContact::new(body).unwrap().left_out.into_iter().collect();
        Judge { body, data, joined }
    }

    /// Of a body as its file has it: excludes are no contacts.
    fn new(body: &'b Body) -> Judge<'b> {
        let mut data = Data::new(body.declared.clone()).unwrap();
        take(body, &mut data, &Posture::start(&body.creature));
        let joined = data.contacts().map(|contact| contact.geoms).collect();
        Judge { body, data, joined }
    }

    /// Contacts between limbs that are not neighbours, with the limbs.
    fn contacts(&mut self, posture: &[f64]) -> Vec<([usize; 2], Contact)> {
        take(self.body, &mut self.data, posture);
        let limbs = |c: &Contact| {
            let [a, b] = c.geoms.map(|geom| self.body.limb_of_geom(geom));
            Some([a?, b?])
        };
        let apart = |(limbs, contact): &([usize; 2], Contact)| {
            let [a, b] = contact.geoms;
            !self.body.creature.neighbouring(limbs[0], limbs[1])
                && !self.joined.contains(&[a, b])
                && !self.joined.contains(&[b, a])
        };
        self.data.contacts().filter_map(|c| Some((limbs(&c)?, c))).filter(apart).collect()
    }

    /// How deep the deepest pair is.
    fn deepest(&mut self, posture: &[f64]) -> (f64, [usize; 2]) {
        let contacts = self.contacts(posture);
        let depths = contacts.iter().map(|(limbs, contact)| (-contact.distance, *limbs));
        depths.fold((f64::NEG_INFINITY, [0, 0]), |a, b| if b.0 > a.0 { b } else { a })
    }
}

/// The posture a fraction of the way from one to another, by the conventions of a motion.
fn between(body: &Body, from: &[f64], to: &[f64], t: f64) -> Vec<f64> {
    let mut posture = Vec::new();
    for dof in body.creature.dofs() {
        let q = posture.len();
        if dof.kind == DofKind::Ball {
            let turn = |p: &[f64]| {
                UnitQuaternion::from_quaternion(Quaternion::new(p[q], p[q + 1], p[q + 2], p[q + 3]))
            };
            let (a, b) = (turn(from), turn(to));
            let way = (b * a.inverse()).scaled_axis();
            let at = UnitQuaternion::from_scaled_axis(way * t) * a;
            posture.extend([at.w, at.i, at.j, at.k]);
        } else {
            posture.push(from[q] + t * (to[q] - from[q]));
        }
    }
    posture
}

fn assert_within_ranges(name: &str, body: &Body, posture: &[f64]) {
    assert_eq!(posture.len(), body.creature.coordinates());
    let mut q = 0;
    for dof in body.creature.dofs() {
        let [low, high] = dof.range;
        if dof.kind == DofKind::Ball {
            let turn = Quaternion::new(posture[q], posture[q + 1], posture[q + 2], posture[q + 3]);
            assert!((turn.norm() - 1.0).abs() < RANGE, "{name}, {}: {turn}", dof.name);
            let angle = UnitQuaternion::from_quaternion(turn).angle();
            assert!(angle <= high + RANGE, "{name}, {}: {angle} of {high} rad", dof.name);
        } else {
            let at = posture[q];
            assert!(at >= low - RANGE && at <= high + RANGE, "{name}, {}: {at} of {low}..{high}", dof.name);
        }
        q += dof.kind.coordinates();
    }
}

/// Checks every touch of a creature against the engine: where it finds shapes step by step it may find the contact only a little
/// `onward` of the touch's posture, in one of the postures given for each touch.
fn assert_confirmed(
    name: &str,
    body: &Body,
    skin: &Skin,
    touches: &[RecordedTouch],
    onward: &[Vec<Vec<f64>>],
) {
    let mut judge = Judge::new(body);
    for (i, touch) in touches.iter().enumerate() {
        let at = format!("{name}, touch {i}");
        assert_within_ranges(&at, body, &touch.posture);
        let receptors = touch.ends.map(|end| &skin.receptors[end.receptor]);
        let limbs = receptors.map(|receptor| receptor.limb);
        assert!(limbs[0] < limbs[1], "{at}: {limbs:?}");
        assert!(!body.creature.neighbouring(limbs[0], limbs[1]), "{at}: {limbs:?}");
        let mut confirmed = false;
        for (found, contact) in judge.contacts(&touch.posture) {
            let depth = -contact.distance;
            // Newer engines find contacts of round shapes step by step, and the same one not quite as deep each time.
            let deepest = if is_newer_engine() { 5.0 * DEEPEST } else { DEEPEST };
            assert!(depth <= deepest, "{at}: limbs {found:?} are {depth} m deep, the touch is of {limbs:?}");
            let same = found == limbs || found == [limbs[1], limbs[0]];
            confirmed |= same && depth >= 0.0;
        }
        for posture in onward.get(i).into_iter().flatten() {
            let found = judge.contacts(posture);
            confirmed |= found.iter().any(|(found, _)| *found == limbs || *found == [limbs[1], limbs[0]]);
        }
        assert!(confirmed, "{at}: the engine finds no contact of {limbs:?}");
        take(body, &mut judge.data, &touch.posture);
        let in_world = [0, 1].map(|k| {
            let (point, receptor) = (touch.exact_contact().points[k], receptors[k]);
            assert!(receptor.holds(&point), "{at}: {} does not hold the point", receptor.id);
            body.limb_pose(&judge.data, limbs[k]).unwrap() * Point3::from(point)
        });
        let apart = (in_world[0] - in_world[1]).norm();
        assert!(apart < SAME_PLACE, "{at}: the ends are {apart} m apart");
    }
}

#[test]
fn every_touch_is_confirmed_by_the_engine_and_nothing_else_is_deeper() {
    for (name, body) in exact().into_iter().chain([("Max", max("all"))]) {
        let agent = Agent::of(&body).unwrap();
        let touches = babble(&body, &agent, 300, 3, 2);
        assert_eq!(touches.len(), 300, "{name}");
        assert_confirmed(name, &body, agent.skin(), &touches, &[]);
    }
}

#[test]
fn touches_of_other_shapes_are_confirmed_alike() {
    for (name, body) in other_shapes() {
        let agent = Agent::of(&body).unwrap();
        let babbler = Babbler::new(Movers::new(&body, &agent, MotionName::Kinematic).unwrap());
        let mut mover = babbler.movers().mover().unwrap();
        let mut rng = ChaCha8Rng::seed_from_u64(3);
        let (mut touches, mut onward) = (Vec::new(), Vec::new());
        // A whole bout would take long where motions feel their way in steps.
        for motion in 0..300 {
            let target = Posture::random(&body.creature, &mut rng);
            if let Ending::Touch(met) = mover.advance(&target).unwrap() {
                let stop = mover.posture().to_vec();
                onward.push(ONWARD.map(|t| between(&body, &stop, &target, t)).to_vec());
                let mut touch = mover.touch(0, met).unwrap();
                (touch.motion, touch.posture) = (motion, stop.into());
                touches.push(touch);
            }
        }
        assert!(touches.len() > 3, "{name}: {} touches prove nothing", touches.len());
        assert_confirmed(name, &body, agent.skin(), &touches, &onward);
    }
}

#[test]
fn the_same_seed_gives_the_same_touches_with_any_number_of_threads() {
    let boxes = other_shapes().into_iter().find(|(name, _)| *name == "boxes");
    for (name, body) in [("Max's torso", max("torso")), ("balls", creature(BALLS))].into_iter().chain(boxes) {
        let agent = Agent::of(&body).unwrap();
        let log = |jobs: usize| {
            let touches = babble(&body, &agent, 130, 11, jobs);
            let folder = tempfile::tempdir().unwrap();
            let mut writer = TouchWriter::create(folder.path(), &agent).unwrap();
            touches.iter().for_each(|touch| writer.write(touch).unwrap());
            writer.finish().unwrap();
            (touches, std::fs::read(folder.path().join("touches.jsonl")).unwrap())
        };
        let one = log(1);
        for jobs in [3, 64] {
            assert!(log(jobs) == one, "{name}: {jobs} threads give other touches than one");
        }
    }
}

#[test]
fn fewer_touches_are_the_first_of_more() {
    let body = max("torso");
    let agent = Agent::of(&body).unwrap();
    let many = babble(&body, &agent, 120, 2, 2);
    for few in [1, 24, 25, 26, 99] {
        assert!(babble(&body, &agent, few, 2, 3) == many[..few], "{few}");
    }
}

#[test]
fn different_seeds_give_different_touches() {
    let body = max("torso");
    let agent = Agent::of(&body).unwrap();
    let touches = [1, 2, 3].map(|seed| babble(&body, &agent, 20, seed, 1));
    for [a, b] in [[0, 1], [0, 2], [1, 2]] {
        assert!(touches[a].iter().zip(&touches[b]).all(|(x, y)| x.posture != y.posture));
    }
}

#[test]
fn two_touches_of_one_pair_in_a_row_are_parted_by_free_space() {
    const LOOKS: usize = 400;
    for (name, body) in exact() {
        let agent = Agent::of(&body).unwrap();
        let touches = babble(&body, &agent, 500, 4, 2);
        let mut judge = Judge::new(&body);
        let mut looked = 0;
        for pair in touches.windows(2) {
            let [before, after] = pair else { unreachable!() };
            let limbs = [before, after].map(|t| t.ends.map(|end| agent.skin().receptors[end.receptor].limb));
            let in_a_row = before.bout == after.bout && before.motion + 1 == after.motion;
            if !in_a_row || limbs[0] != limbs[1] {
                continue;
            }
            looked += 1;
            let parted = (1..LOOKS).any(|k| {
                let t = k as f64 / LOOKS as f64;
                let contacts = judge.contacts(&between(&body, &before.posture, &after.posture, t));
                !contacts.iter().any(|(found, _)| *found == limbs[0] || *found == [limbs[0][1], limbs[0][0]])
            });
            let moved = before.posture.iter().zip(&after.posture).map(|(a, b)| (a - b).abs());
            let moved = moved.fold(0.0, f64::max);
            assert!(parted, "{name}: bout {}, motion {}: moved by {moved}", after.bout, after.motion);
        }
        assert!(looked > 0, "{name}: no two touches of one pair in a row to look at");
    }
}

/// Makes motions, at least so many, and looks at their paths again in small steps, start to stop.
///
/// It goes on until one motion stopped and one was free: others prove nothing.
fn assert_nothing_jumped(name: &str, mut judge: Judge, motions: usize, steps: usize) {
    let body = judge.body;
    let agent = Agent::new(body.creature.clone(), grow(body, &GrowOptions::default()).unwrap()).unwrap();
    let babbler = Babbler::new(Movers::new(body, &agent, MotionName::Kinematic).unwrap());
    let mut mover = babbler.movers().mover().unwrap();
    let mut rng = ChaCha8Rng::seed_from_u64(17);
    let (mut stops, mut free) = (0, 0);
    for motion in 0..10 * motions {
        if motion >= motions && stops > 0 && free > 0 {
            break;
        }
        if motion % MOTIONS_PER_BOUT == 0 {
            mover.reset().unwrap();
        }
        let start = mover.posture().to_vec();
        let target = Posture::random(&body.creature, &mut rng);
        match mover.advance(&target).unwrap() {
            Ending::Again => {
                assert_eq!(mover.posture(), start, "{name}: a motion that never began moved");
                continue;
            }
            Ending::Free => free += 1,
            Ending::Touch(_) | Ending::Bare => stops += 1,
        }
        let stop = mover.posture().to_vec();
        for k in 0..=steps {
            let t = k as f64 / steps as f64;
            let (depth, limbs) = judge.deepest(&between(body, &start, &stop, t));
            let names = limbs.map(|limb| &body.creature.limbs()[limb]);
            assert!(depth <= JUMPED, "{name}, motion {motion} at {t}: {names:?} are {depth} m deep");
        }
    }
    assert!(stops > 0 && free > 0, "{name}: {stops} stops and {free} free motions prove nothing");
}

#[test]
fn no_contact_of_spheres_and_capsules_is_jumped_over() {
    for (name, body) in exact() {
        assert_nothing_jumped(name, Judge::new(&body), 100, STEPS);
    }
}

#[test]
fn no_contact_of_other_shapes_is_jumped_over() {
    for (name, body) in other_shapes() {
        assert_nothing_jumped(name, Judge::new(&body), 200, STEPS);
    }
}

/// More pairs of limbs than are looked at from the beginning of a motion on.
#[test]
fn no_contact_of_very_many_limbs_is_jumped_over() {
    for (name, chain, range) in [("star", 1, "-.8 .8"), ("arms", 8, "-.6 .6")] {
        let body = creature(&scale::body(160, chain).replace("-1.5 1.5", range));
        assert_nothing_jumped(name, Judge::new(&body), 40, STEPS);
    }
}

mod large {
    use super::*;

    /// The creatures of `mjcf/`, bodies of meshes and of thin sheets, in steps of a tenth of a millimetre or so.
    #[test]
    #[ignore = "large: minutes"]
    fn no_contact_of_any_body_is_jumped_over() {
        const FINE: usize = 8 * STEPS;
        for name in ["hexapod", "octopus", "snake", "fourarms", "sauropod", "contraption"] {
            let model = Model::from_path(repository(&format!("mjcf/{name}/{name}.xml"))).unwrap();
            let body = Body::new(Arc::new(model), &JointSelection::All).unwrap();
            assert_nothing_jumped(name, Judge::of_surface(&body), 40, FINE);
        }
        for (name, xml) in meshes::bodies() {
            assert_nothing_jumped(&name, Judge::of_surface(&creature(&xml)), 40, FINE);
        }
        for (name, body) in other_shapes() {
            assert_nothing_jumped(name, Judge::of_surface(&body), 60, FINE);
        }
    }
}
