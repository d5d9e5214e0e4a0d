//! A planar arm of three hinges in front of a ball, and its peripersonal space according to its schema.

use nalgebra::{Matrix3, Vector3};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

use super::*;
use crate::agent::Agent;
use crate::creature::{Creature, Dof, DofKind, Joint, Posture};
use crate::geometry::{Capsule, Frame, Shape};
use crate::kinematics::Place;
use crate::learning::Certainty;
use crate::schema::BodySchema;
use crate::skin::{Receptor, Skin, Surface};

/// How far the tip of the stretched arm is from the shoulder, metres.
const LENGTH: f64 = 0.63;

/// A ball, an upper arm, a forearm and a hand, in a row along x at rest; each joint turns about z.
fn arm() -> OwnBody {
    let hinge = |name: &str, parent: usize| {
        let dof = Dof { name: name.into(), kind: DofKind::Hinge, range: [-2.6, 2.6], follows: None };
        Joint::new(name, parent, vec![dof])
    };
    let joints = vec![hinge("shoulder", 0), hinge("elbow", 1), hinge("wrist", 2)];
    let limbs = ["ball", "upper arm", "forearm", "hand"].map(String::from).to_vec();
    let creature = Creature::new("arm".into(), limbs, joints, Vec::new()).unwrap();
    let mut schema = BodySchema::zero(&creature);
    schema.positions = [0.0, 0.3, 0.25].map(|x| Vector3::new(x, 0.0, 0.0)).to_vec();
    schema.axes = vec![Vector3::z(); 3];
    // A capsule's length is along its z, here along the limb's x.
    let along_x = Matrix3::from_columns(&[Vector3::y(), Vector3::z(), Vector3::x()]);
    let surface = |limb: usize, x: f64, shape: Shape| Surface {
        limb,
        origin: Vector3::new(x, 0.0, 0.0),
        rotation: along_x,
        shape,
        geom: 0,
    };
    let surfaces = vec![
        surface(0, 0.0, Shape::Sphere { radius: 0.12 }),
        surface(1, 0.15, Shape::Capsule { radius: 0.03, half_length: 0.1 }),
        surface(2, 0.12, Shape::Capsule { radius: 0.03, half_length: 0.08 }),
        surface(3, 0.05, Shape::Sphere { radius: 0.03 }),
    ];
    let tip = Receptor {
        id: "tip".into(),
        limb: 3,
        position: Vector3::new(0.08, 0.0, 0.0),
        normal: Vector3::x(),
        tangent: Vector3::y(),
        half_extents: [0.01; 2],
        surface: Some(3),
    };
    let agent = Agent::new(creature, Skin { receptors: vec![tip], surfaces }).unwrap();
    OwnBody::new(&agent, schema, Certainty::Exact, &[])
}

fn posture(angles: [f64; 3]) -> Posture {
    Posture::from(&angles[..])
}

#[test]
fn a_hand_in_another_limb_is_not_free_unless_that_was_harmless() {
    let own = arm();
    let clearance = CollisionChecker::new(&own);
    let at = |angles| own.frames(&posture(angles));
    assert!(clearance.free(&at([0.0; 3]), 0.01));
    // Folded back, the hand is in the ball.
    let folded = at([0.0, 2.6, 1.0]);
    assert!(!clearance.free(&folded, 0.0) && clearance.least(&folded, 0.1) < 0.0);
    // Moving the shoulder alone changes nothing between arm and hand.
    assert!(clearance.moved_by(&own, &[0]).near(&folded, 0.0).iter().all(|near| near.limb == 0));
    // What is as near in a pose that was harmless may be as near again.
    assert!(clearance.eased_at(std::slice::from_ref(&folded), 0.01).free(&folded, 0.01));
}

#[test]
fn a_path_leads_round_what_is_in_the_way() {
    let own = arm();
    let mut clearance = CollisionChecker::new(&own);
    let [from, to] = [[-0.8, 0.0, 0.0], [0.8, 0.0, 0.0]].map(posture);
    let joints = [0, 1, 2];
    let mut rng = ChaCha8Rng::seed_from_u64(1);
    let mut path =
        |clearance: &CollisionChecker| find_path(&own, clearance, [&from, &to], &joints, 0.005, &mut rng);
    assert_eq!(path(&clearance).unwrap().0.len(), 2, "nothing is in the way");
    clearance.obstacles.push(Obstacle::Capsule(Capsule::ball(Vector3::new(0.5, 0.0, 0.0), 0.06)));
    assert!(!straight(&own, &clearance, &from, &to, 0.005));
    let round = path(&clearance).unwrap();
    assert!(round.0.windows(2).all(|two| straight(&own, &clearance, &two[0], &two[1], 0.004)));
    assert_eq!((&round.0[0], round.end().unwrap()), (&from, &to[..]));
}

#[test]
fn the_farthest_is_the_stretched_arm_unless_something_is_asked_of_it() {
    let own = arm();
    let clearance = CollisionChecker::new(&own);
    let tip = own.place(0);
    let joints = [0, 1, 2];
    let program = PostureProgram::farthest(&own, &clearance, &joints, tip, Vector3::y(), 0.005);
    let found = program.solve(&posture([0.3, 0.4, -0.2]));
    assert!(found.kept() && (found.along - LENGTH).abs() < 1e-3, "{found:?}");
    // At a distance to the side, Pythagoras has it.
    let found = program.at_level(Vector3::x(), 0.4).solve(&posture([0.3, 0.4, -0.2]));
    let expected = (LENGTH * LENGTH - 0.16_f64).sqrt();
    assert!(found.kept() && (found.along - expected).abs() < 1e-3, "{found:?}");
}

#[test]
fn a_hand_gets_where_it_is_to_be_and_turned_as_it_is_to_be() {
    let own = arm();
    let target = own.frames(&posture([0.7, -1.1, 0.5]))[3];
    let goal = LimbGoal { limb: 3, place: Frame::identity(), target };
    let found = limb_posture(&own, &[0, 1, 2], &goal, &posture([0.2, -0.5, 0.0]), None, 60);
    assert!(found.miss < 1e-4 && found.turn < 1e-3, "{found:?}");
    // What is held still stays, and the arm comes as near as it can.
    let held = limb_posture(&own, &[1, 2], &goal, &posture([0.2, -0.5, 0.0]), None, 60);
    assert!(held.posture[0] == 0.2 && held.miss > 0.01, "{held:?}");
}

#[test]
fn a_table_is_in_the_way_of_what_reaches_over_its_edge() {
    let table = TablePlane { up: Vector3::z(), height: 0.0, front: Vector3::x(), edge: 0.5 };
    let table = Obstacle::Table(table);
    let gap = |ends: [[f64; 3]; 2]| table.gap(&Capsule { ends: ends.map(Vector3::from), radius: 0.02 });
    assert_eq!(gap([[0.0, 0.0, -1.0], [0.4, 0.0, -0.1]]), f64::INFINITY, "before the edge there is none");
    assert!((gap([[0.6, 0.0, 0.3], [0.8, 0.0, 0.1]]) - 0.08).abs() < 1e-12);
    // Of what slopes down to before the edge the part over the table counts.
    assert!((gap([[0.28, 0.0, -0.1], [0.68, 0.0, 0.1]]) - -0.02).abs() < 1e-12);
}

#[test]
fn every_voxel_of_a_map_has_a_posture_in_it() {
    let own = arm();
    let map = ReachableMap::new(&own, 3, 0, 0.05).unwrap();
    let tip: Place = map.tip;
    let at = |posture: &[f64]| own.frames(posture)[3].point(&tip.point);
    assert!(map.voxels().count() > 300);
    for (cell, level) in map.voxels() {
        let middle = map.lattice().middle(cell);
        let found = map.whereabouts(&middle);
        assert!((at(&found.posture) - middle).amax() <= map.lattice().half() + 1e-5 && found.miss == 0.0);
        assert_eq!((found.level, level), (Level::Near, Level::Near), "nothing leans");
    }
    let reach = map.reach(&Vector3::new(0.3, 0.25, 0.0));
    assert!(reach.miss < 1e-3 && (at(&reach.posture) - Vector3::new(0.3, 0.25, 0.0)).norm() < 1e-3);
    // Beyond the stretched arm it is as far as the point is, less what voxels are thick.
    let far = map.whereabouts(&Vector3::new(1.0, 0.0, 0.0));
    assert!((far.miss - (1.0 - LENGTH)).abs() < 0.05 && at(&far.posture).x > 0.5, "{far:?}");
}
