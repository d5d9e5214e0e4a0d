//! The space around the body by a schema: predictions, postures that meet, what is in the way, and ways around it.

use crate::common::{babble, creature, max, own_body, take, truth, two_arms};
use bodyschema::agent::Agent;
use bodyschema::creature::Posture;
use bodyschema::geometry::{Capsule, Frame, Precision, gap};
use bodyschema::kinematics::{InverseKinematics, Place, REACHED};
use bodyschema::learning::{Certainty, Input};
use bodyschema::mujoco::Data;
use bodyschema::peripersonal::{
    CollisionChecker, Doubt, FeltPose, FeltSurface, KEPT, Obstacle, OutOfReach, OwnBody, PostureProgram,
    ReachTarget, Reaching, TablePlane, farthest_postures,
};
use bodyschema::skin::skin_of;
use nalgebra::{Rotation3, Vector3};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// How far this program's kinematics and the engine's may differ, metres.
const ROUNDING: f64 = 1e-9;

fn arms() -> String {
    two_arms(r#"type="capsule" size="0.12 0.2""#, r#"type="capsule" size="0.03 0.2""#)
}

/// Max with the true schema, taken as it is.
fn knowing_max() -> OwnBody {
    let body = max("torso");
    let agent = Agent::of(&body).unwrap();
    let touches = babble(&body, &agent, 300, 1, 2);
    OwnBody::new(&agent, truth(&body), Certainty::Exact, touches.iter().map(|touch| &touch.posture))
}

#[test]
fn postures_found_by_inverse_kinematics_bring_the_receptors_together_within_the_ranges() {
    let body = creature(&arms());
    let (creature, skin, schema) = (&body.creature, skin_of(&body), truth(&body));
    let mut data = Data::new(body.model.clone()).unwrap();
    let mut rng = ChaCha8Rng::seed_from_u64(1);
    let mut met = 0;
    for _ in 0..40 {
        let start = Posture::random(creature, &mut rng);
        for receptors in [[0, 1], [0, 2], [1, 2]] {
            let [first, second] = receptors.map(|r| skin.receptors[r].place(0.0));
            let ends = [first, second.reversed()];
            let reach = InverseKinematics::new(creature, &schema, ends).solve(&start);
            for (dof, angle) in creature.dofs().zip(&reach.posture) {
                assert!((dof.range[0]..=dof.range[1]).contains(angle), "{angle} of {:?}", dof.range);
            }
            take(&body, &mut data, &reach.posture);
            let [a, b] = ends.map(|end| body.limb_frames(&data)[end.limb].point(&end.point));
            let miss = (a - b).norm();
            assert!((miss - reach.miss).abs() < ROUNDING, "{miss} and {}", reach.miss);
            met += usize::from(miss <= REACHED);
        }
    }
    assert!(met >= 20, "only {met} of 120 met");
}

#[test]
fn what_is_held_still_stays_and_directions_are_as_asked() {
    let own = knowing_max();
    let hand = own.creature().limb("left_hand").unwrap();
    let arm = own
        .joints_of(hand, &[own.creature().limb("right_hand").unwrap(), own.creature().limb("head").unwrap()]);
    assert_eq!(arm.len(), 4, "clavicle, shoulder, elbow, wrist");
    let receptor = own.receptors_on(&[hand])[0];
    let start = own.at_ease();
    let place = own.place(receptor);
    let frames = own.frames(&start);
    let point = frames[hand].point(&place.point) + Vector3::new(0.15, 0.0, 0.1);
    let target = Place { limb: 0, point, direction: Vector3::x() };
    let solver = InverseKinematics::new(own.creature(), &own.schema, [place, target])
        .with_direction_lengths([0.05, 0.05])
        .moving(|joint| arm.contains(&joint));
    let reach = solver.solve(&start);
    assert!(reach.reached() && reach.facing > 0.99, "{} {}", reach.miss, reach.facing);
    for (j, joint) in own.creature().joints().iter().enumerate().filter(|(j, _)| !arm.contains(j)) {
        let q = joint.coordinates().start;
        assert_eq!(reach.posture[q..q + joint.dofs.len()], start[q..q + joint.dofs.len()], "{j}");
    }
}

#[test]
fn a_receptor_is_predicted_where_the_engine_has_it() {
    let body = max("torso");
    let agent = Agent::of(&body).unwrap();
    let touches = babble(&body, &agent, 300, 2, 2);
    let own = own_body(&agent, &truth(&body), Input::Receptor, &touches);
    let mut data = Data::new(body.model.clone()).unwrap();
    let mut rng = ChaCha8Rng::seed_from_u64(2);
    let (hand, head) = (own.creature().limb("left_hand").unwrap(), own.creature().limb("head").unwrap());
    for receptor in own.receptors_on(&[hand]) {
        let posture = Posture::random(own.creature(), &mut rng);
        take(&body, &mut data, &posture);
        let frames = body.limb_frames(&data);
        let place = own.place(receptor);
        let seen = |frames: &[Frame]| frames[head].inverse_point(&frames[hand].point(&place.point));
        assert!((seen(&own.frames(&posture)) - seen(&frames)).norm() < ROUNDING);
        let deviation = own
            .covariance(&posture, [hand, head], &place.point)
            .expect("300 touches bound it")
            .trace()
            .sqrt();
        assert!(deviation > 0.0 && deviation < 1e-3, "{deviation}");
    }
    // With five touches nothing is bounded, and he says what he lacks.
    let little = own_body(&agent, &truth(&body), Input::Receptor, &touches[..5]);
    let doubt = little.trusts(&little.at_ease(), [hand, head], &Vector3::zeros()).unwrap_err();
    assert!(matches!(doubt, Doubt::Undetermined(_)), "{doubt:?}");
    assert!(doubt.to_string().contains("not found out"), "{doubt}");
}

#[test]
fn gaps_by_the_schema_are_those_of_the_surfaces() {
    let own = knowing_max();
    let body = max("torso");
    let clearance = CollisionChecker::new(&own);
    let mut data = Data::new(body.declared.clone()).unwrap();
    let mut rng = ChaCha8Rng::seed_from_u64(3);
    let (mut free, mut touching, mut wrong) = (0, 0, 0);
    for _ in 0..300 {
        let posture = Posture::random(own.creature(), &mut rng);
        take(&body, &mut data, &posture);
        let meets = data.contacts().any(|contact| {
            let [a, b] = contact.geoms.map(|geom| body.limb_of_geom(geom).unwrap());
            !own.creature().neighbouring(a, b) && contact.distance < -PASSED
        });
        let gap = clearance.least(&own.frames(&posture), 0.01);
        if gap > 0.0 {
            assert!(!meets, "the engine has limbs in each other at a gap of {gap}");
            free += 1;
        } else if gap < -PASSED {
            // Excluded pairs that never overlapped in what he lived through he takes for ones that feel each other.
            touching += 1;
            wrong += usize::from(!meets);
        }
    }
    assert!(free > 30 && touching > 30, "{free} free, {touching} touching");
    assert!(20 * wrong <= touching, "{wrong} of {touching} do not touch");
}

/// As deep as limbs may have been in each other and still count as feeling each other, metres.
const PASSED: f64 = 2e-3;

#[test]
fn a_way_to_a_place_keeps_clear_and_ends_there() {
    let own = knowing_max();
    let mut clearance = CollisionChecker::new(&own);
    clearance.obstacles.push(Obstacle::Capsule(Capsule::ball(Vector3::new(0.28, 0.3, 0.1), 0.08)));
    let table = TablePlane { up: Vector3::z(), height: -0.05, front: Vector3::x(), edge: 0.2 };
    clearance.obstacles.push(Obstacle::Table(table));
    let hand = own.creature().limb("left_hand").unwrap();
    let others = ["right_hand", "head"].map(|name| own.creature().limb(name).unwrap());
    let reaching = Reaching::new(&own, &clearance, own.joints_of(hand, &others), 1);
    let receptors = own.receptors_on(&[hand]);
    let start = own.at_ease();
    let aim = ReachTarget { point: Vector3::new(0.3, 0.1, 0.2), direction: Vector3::new(1.0, 0.0, 0.0) };
    let reaching = reaching.onto(aim.direction);
    let found = reaching.approach(&start, &receptors, &aim).unwrap();
    let frame = own.frames(&found.touching)[found.place.limb];
    assert!((frame.point(&found.place.point) - aim.point).norm() <= REACHED);
    // No other skin of the hand is there before.
    let ahead = own.skin().surfaces.iter().filter(|surface| surface.limb == hand).map(|surface| {
        let point = frame.point(&surface.support(&frame.rotation.tr_mul(&aim.direction)).unwrap());
        (point - aim.point).dot(&aim.direction)
    });
    let ahead = ahead.fold(f64::NEG_INFINITY, f64::max);
    assert!(ahead <= 2.0 * REACHED, "{ahead} m beyond the place");
    assert_eq!(found.way.0[0], start);
    assert_eq!(found.way.end(), found.straight.0.first().map(|posture| &posture[..]));
    for pair in found.way.0.windows(2) {
        for k in 0..=20 {
            let share = f64::from(k) / 20.0;
            let posture: Vec<f64> = pair[0].iter().zip(&pair[1]).map(|(a, b)| a + share * (b - a)).collect();
            assert!(clearance.free(&own.frames(&posture), 0.0), "something is in the way");
        }
    }
    let far = ReachTarget { point: Vector3::new(1.3, 0.1, 0.2), ..aim };
    match reaching.approach(&start, &receptors, &far) {
        Err(OutOfReach::TooFar(by)) => assert!(by > 0.4 && by < 1.0, "{by}"),
        other => panic!("{other:?}"),
    }
}

/// A forearm is tilted and shifted about what touches it: from the poses in which it begins to feel that, it knows where on
/// the patch it does, for corners, balls and edges; from the first one alone it does not.
#[test]
fn small_motions_tell_where_on_a_patch_something_touches() {
    let own = knowing_max();
    let forearm = own.creature().limb("left_forearm").unwrap();
    let receptor = own.receptors_on(&[forearm])[2];
    let patch = &own.skin().receptors[receptor];
    let surface = &own.skin().surfaces[patch.surface.unwrap()];
    let mut rng = ChaCha8Rng::seed_from_u64(5);
    let (mut errors, mut unsure) = (Vec::new(), Vec::new());
    for trial in 0..24 {
        let mut inside = |half: f64| rng.random_range(-0.8 * half..0.8 * half);
        let flat = patch.position
            + patch.tangent * inside(patch.half_extents[0])
            + patch.bitangent() * inside(patch.half_extents[1]);
        let Some(place) = own.on_surface(receptor, &flat).filter(|place| patch.holds(&place.point)) else {
            continue;
        };
        let n = place.direction;
        let radius = [0.0, 0.02, 0.06][trial % 3];
        let length = [0.0, 0.02][trial / 3 % 2] * n.cross(&Vector3::new(0.3, 0.5, 0.8)).normalize();
        let centre = place.point + n * radius;
        let thing = Capsule { ends: [centre - length, centre + length], radius };
        let mut poses = Vec::new();
        let first = Frame::identity();
        let at_first = FeltSurface::of(&own, receptor, &first, &poses, &mut rng).unwrap();
        let across = at_first.direction.cross(&patch.tangent).normalize();
        for (k, axis) in [across, patch.tangent].into_iter().cycle().take(8).enumerate() {
            let angle = [0.12, 0.12, -0.12, -0.12, 0.0, 0.0, 0.0, 0.0][k];
            let aside = axis * [0.0, 0.0, 0.0, 0.0, 0.005, 0.005, -0.005, -0.005][k];
            let rotation = Rotation3::new(axis * angle).into_inner();
            for step in -50..80 {
                let middle = at_first.point + aside + at_first.direction * (1e-4 * f64::from(step));
                let limb = Frame { rotation, origin: middle - rotation * at_first.point };
                let found = gap(&surface.placed(&limb).unwrap(), &thing, Precision::Exact);
                if found.distance < 0.0 {
                    let felt = patch.holds(&limb.inverse_point(&found.points[0]));
                    poses.extend(felt.then_some(FeltPose { limb, receptor: Some(receptor) }));
                    break;
                }
            }
        }
        let felt = FeltSurface::of(&own, receptor, &first, &poses, &mut rng).unwrap();
        errors.push((felt.point - place.point).norm());
        unsure.push((at_first.point - place.point).norm());
    }
    let median = |errors: &mut Vec<f64>| {
        errors.sort_by(f64::total_cmp);
        errors[errors.len() / 2]
    };
    let (felt_on, once) = (median(&mut errors), median(&mut unsure));
    assert!(felt_on < 2e-3 && once > 1e-2, "{felt_on} m after feeling on, {once} m before");
}

/// An arm of three links in a plane, along x, that turn about y.
const PLANAR: &str = r#"<mujoco model="planar">
  <compiler angle="radian" autolimits="true"/>
  <worldbody><body name="base"><geom type="sphere" size="0.02"/>
    <body name="upper"><joint name="shoulder" axis="0 1 0" range="-2.5 2.5"/>
      <geom type="capsule" fromto="0.05 0 0 0.3 0 0" size="0.01"/>
      <body name="lower" pos="0.3 0 0"><joint name="elbow" axis="0 1 0" range="-2.5 2.5"/>
        <geom type="capsule" fromto="0.05 0 0 0.25 0 0" size="0.01"/>
        <body name="hand" pos="0.25 0 0"><joint name="wrist" axis="0 1 0" range="-2.5 2.5"/>
          <geom type="capsule" fromto="0.05 0 0 0.15 0 0" size="0.01"/>
        </body>
      </body>
    </body>
  </body></worldbody>
</mujoco>"#;

#[test]
fn the_farthest_of_an_arm_in_a_plane_is_where_geometry_has_it() {
    let body = creature(PLANAR);
    let agent = Agent::of(&body).unwrap();
    let own = OwnBody::new(&agent, truth(&body), Certainty::Exact, &[]);
    let place = Place {
        limb: own.creature().limb("hand").unwrap(),
        point: Vector3::new(0.15, 0.0, 0.0),
        direction: Vector3::x(),
    };
    let joints: Vec<usize> = (0..own.creature().joints().len()).collect();
    let height = -0.2;
    let farthest = |clearance: &CollisionChecker, seed: u64| {
        let program = PostureProgram::farthest(&own, clearance, &joints, place, Vector3::x(), 0.002)
            .at_level(Vector3::z(), height)
            .parallel_to(Vector3::x());
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let starts: Vec<Posture> =
            (0..4).map(|_| own.random_posture(&own.at_ease(), &joints, &mut rng)).collect();
        farthest_postures(&own, &program, &joints, &starts, &mut rng)
    };
    let clearance = CollisionChecker::new(&own);
    // Two links stretched out to the height, and the hand level at their end.
    let stretched = 0.15 + f64::sqrt(0.55f64.powi(2) - height * height);
    for seed in 1..=5 {
        let found = farthest(&clearance, seed);
        let best = found.first().expect("there is a farthest one");
        assert!((best.along - stretched).abs() < 1e-3, "{} and {stretched}", best.along);
        let frame = own.frames(&best.posture)[place.limb];
        assert!((frame.point(&place.point).z - height).abs() < KEPT);
        assert!(frame.direction(&Vector3::x()).x > 0.999_999);
    }
    assert_eq!(farthest(&clearance, 1), farthest(&clearance, 1), "the same seed, the same postures");
    // A pole across the way that the stretched arm takes: the elbow goes over it or under it, and gets less far.
    let mut barred = clearance.clone();
    let pole = Vector3::new(0.28, 0.0, -0.11);
    barred.obstacles.push(Obstacle::Capsule(Capsule::ball(pole, 0.02)));
    let found = farthest(&barred, 1);
    let best = found.first().expect("there is a way about the pole");
    assert!(best.along < stretched - 1e-3 && best.along > stretched - 0.2, "{}", best.along);
    assert!(barred.free(&own.frames(&best.posture), 0.0015), "it is in the pole");
}

#[test]
fn the_farthest_postures_of_a_leaning_body_keep_all_that_they_are_to_keep() {
    let own = knowing_max();
    let hand = own.creature().limb("left_hand").unwrap();
    let joints = own.joints_to(hand);
    let (up, front) = (Vector3::z(), Vector3::x());
    // A grip as one is with the hand in front of the trunk, over the table.
    let mut rng = ChaCha8Rng::seed_from_u64(1);
    let flat = own.place(own.receptors_on(&[hand])[0]);
    let held =
        std::iter::repeat_with(|| own.random_posture(&own.at_ease(), &joints, &mut rng)).find(|posture| {
            let point = own.frames(posture)[hand].point(&flat.point);
            (0.08..0.15).contains(&point.z) && point.x > 0.35 && point.y > -0.1
        });
    let frame = own.frames(&held.unwrap())[hand];
    let place = Place { direction: frame.rotation.tr_mul(&up), ..flat };
    let height = frame.point(&flat.point).z;
    let mut clearance = CollisionChecker::new(&own);
    clearance.obstacles.push(Obstacle::Table(TablePlane { up, height: 0.03, front, edge: 0.1 }));
    let program = PostureProgram::farthest(&own, &clearance, &joints, place, front, 0.003)
        .at_level(up, height)
        .parallel_to(up);
    let starts: Vec<Posture> =
        (0..12).map(|_| own.random_posture(&own.at_ease(), &joints, &mut rng)).collect();
    let found = farthest_postures(&own, &program, &joints, &starts, &mut rng);
    assert!(!found.is_empty());
    assert!(found.windows(2).all(|two| two[0].along >= two[1].along), "the farthest first");
    for posed in &found {
        let frames = own.frames(&posed.posture);
        let point = frames[hand].point(&place.point);
        assert!((point.z - height).abs() <= KEPT && (point.x - posed.along).abs() < 1e-9);
        assert!((frames[hand].rotation * place.direction).z > 0.999_99, "it is tilted, or upside down");
        assert!(clearance.moved_by(&own, &joints).free(&frames, 0.0027), "a limb is in something");
        for (dof, angle) in own.creature().dofs().zip(&posed.posture) {
            assert!((dof.range[0]..=dof.range[1]).contains(angle), "{} at {angle}", dof.name);
        }
    }
    // The trunk bends: an arm alone does not get as far.
    let arm = own.joints_of(hand, &[own.creature().limb("right_hand").unwrap()]);
    let length = 0.65;
    assert!(found[0].along > length, "{} with {} joints of {}", found[0].along, joints.len(), arm.len());
}
