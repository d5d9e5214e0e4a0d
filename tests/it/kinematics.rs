//! Kinematics: the schema's forward model against MuJoCo's own poses, its Jacobians against central
//! differences, and chains against the tree.

use crate::common::{creature, max, take, truth};
use bodyschema::creature::{Body, Creature, DofKind, JointSelection, Posture, turn_ball};
use bodyschema::geometry::Frame;
use bodyschema::kinematics::{Chain, ChainSide, Feature, Freedoms, RelativePoses, SideJacobian, limb_frames};
use bodyschema::mujoco::{Data, JointKind, ObjectKind};
use bodyschema::schema::BodySchema;
use bodyschema::skin::skin_of;
use nalgebra::{Isometry3, Matrix3, Vector3};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// Agreement of positions with MuJoCo's, metres (the issue's figure).
const POSITION: f64 = 1e-10;
/// Agreement of rotation matrices with MuJoCo's, per entry.
const ROTATION: f64 = 1e-10;
/// Step of central differences, metres and axis lengths.
const STEP: f64 = 1e-6;
/// Agreement of derivatives with central differences: of order STEP² and rounding / STEP.
const DERIVATIVE: f64 = 1e-8;
/// Agreement of two ways to compute the same.
const ROUNDING: f64 = 1e-12;
/// Random postures per creature.
const POSTURES: usize = 20;

/// A free body: slides, a ball, joints in series on one body, turned bodies, references off zero.
const FREE: &str = r#"<mujoco model="free">
  <compiler angle="degree" eulerseq="zyx" autolimits="true"/>
  <worldbody>
    <geom type="plane" size="3 3 0.1"/>
    <body name="trunk" pos="1 -2 3" quat="0.7 0.1 -0.5 0.3">
      <freejoint/>
      <geom type="box" size="0.1 0.2 0.3"/>
      <body name="series" pos="0.2 0.1 0.3" euler="40 -25 70">
        <joint name="first" axis="1 0.5 0" pos="0.05 0 0.02" range="-100 80" ref="20"/>
        <joint name="second" axis="0 1 0.3" pos="-0.04 0.03 0" range="-60 60"/>
        <joint name="third" axis="0.2 0.1 1" pos="-0.04 0.03 0" range="-60 90" ref="-15"/>
        <geom type="capsule" fromto="0 0 0 0.3 0.1 0" size="0.03"/>
        <body name="cart" pos="0.3 0.1 0" quat="0.5 0.5 -0.5 0.5">
          <joint name="rail" type="slide" axis="1 1 0.2" range="-0.2 0.3" ref="0.05"/>
          <joint name="mast" axis="0 0.3 1" pos="0.02 0.01 0.03" range="-170 170"/>
          <joint name="boom" type="slide" axis="0 0 1" range="-0.1 0.1"/>
          <geom type="sphere" size="0.05"/>
          <body name="held" pos="0 0 0.2" euler="10 20 30">
            <geom type="sphere" size="0.02"/>
            <body name="tip" pos="0.1 0.2 0" quat="0.8 0.1 0.4 -0.2">
              <joint name="tip" axis="0.6 0 0.8" range="30 120"/>
              <geom type="ellipsoid" size="0.02 0.03 0.04"/>
            </body>
          </body>
        </body>
      </body>
      <body name="unlimited" pos="-0.2 0 0">
        <joint name="wheel" axis="0 1 0"/>
        <joint name="piston" type="slide" axis="0 1 0"/>
        <geom type="sphere" size="0.05"/>
      </body>
    </body>
    <body name="stone" pos="5 0 0"><joint type="slide" axis="0 0 1"/><geom type="sphere" size="0.1"/></body>
  </worldbody>
</mujoco>"#;

/// Ball joints: on a straight body, on turned bodies, in series with hinges, with limits and without.
const BALLS: &str = r#"<mujoco model="balls">
  <compiler angle="radian" autolimits="true"/>
  <worldbody>
    <body name="trunk" pos="0 0 1" quat="0.6 0 0.8 0">
      <geom type="sphere" size="0.1"/>
      <body name="straight" pos="0.1 0 0">
        <joint name="straight" type="ball" pos="0.01 0.02 0.03" range="0 1.5"/>
        <geom type="capsule" fromto="0 0 0 0.2 0 0" size="0.02"/>
        <body name="turned" pos="0.2 0 0" quat="0.5 -0.5 0.5 0.5">
          <joint name="turned" type="ball"/>
          <geom type="capsule" fromto="0 0 0 0.2 0 0" size="0.02"/>
          <body name="series" pos="0.2 0 0" quat="0.9 0.1 0.2 -0.3">
            <joint name="hinge" axis="1 0 0.4" range="-1 2"/>
            <joint name="ball" type="ball" range="0 2.5"/>
            <joint name="slide" type="slide" axis="0 1 0" range="-0.1 0.1"/>
            <geom type="sphere" size="0.05"/>
          </body>
        </body>
      </body>
    </body>
  </worldbody>
</mujoco>"#;

/// An arm on the world, with joints in series on its first body.
const MOUNTED: &str = r#"<mujoco model="mounted">
  <compiler angle="radian" autolimits="true"/>
  <worldbody>
    <geom type="plane" size="3 3 0.1"/>
    <body name="column" pos="0.3 0.2 0.1" quat="0.3 0.1 0.9 -0.2">
      <joint name="swivel" axis="0 0 1" range="-3 3" ref="0.4"/>
      <joint name="lift" type="slide" axis="0 0 1" range="0 0.5" ref="0.1"/>
      <joint name="nod" axis="0 1 0" pos="0 0 0.1" range="-1 1"/>
      <geom type="cylinder" size="0.05 0.1"/>
      <body name="fore" pos="0 0 0.4" quat="0.7 0 0.7 0">
        <joint name="elbow" axis="1 1 1" range="-2 0.5"/>
        <geom type="capsule" fromto="0 0 0 0.3 0 0" size="0.03"/>
      </body>
    </body>
  </worldbody>
</mujoco>"#;

/// A creature in several files: an include, classes of defaults, degrees in an order of their own, mirrored axes,
/// several limbs on one joint's body, a joint that follows another.
fn in_several_files() -> Body {
    let folder = tempfile::tempdir().unwrap();
    let main = r#"<mujoco model="parts">
  <compiler angle="degree" eulerseq="XYZ" autolimits="true"/>
  <default>
    <default class="skewed"><joint axis="1 2 -0.5" pos="0.01 0 0.02" range="-70 100"/><geom size="0.02 0.05"/>
      <default class="mirrored"><joint axis="-1 2 -0.5" pos="-0.01 0 0.02"/></default>
    </default>
  </default>
  <worldbody><body name="trunk" euler="20 30 40" childclass="skewed"><geom type="box" size=".1 .1 .1"/>
    <include file="limbs.xml"/>
  </body></worldbody>
  <equality><joint joint1="right_toe" joint2="left_toe" polycoef="0.1 -0.5 0 0 0"/></equality>
</mujoco>"#;
    let limbs = r#"<mujocoinclude>
  <body name="left" pos="0 .2 0" euler="10 -50 35"><joint name="left"/><geom type="capsule"/>
    <body name="left_toe" pos=".1 0 0"><joint name="left_toe" range="-40 20"/><geom type="sphere"/></body>
    <body name="left_heel" pos="-.1 0 0" euler="0 0 90"><joint name="left_heel" type="ball" range="0 50"/><geom type="sphere"/></body>
    <body name="left_shell" pos="0 0 .1" euler="0 45 0"><geom type="box" size=".02 .02 .02"/>
      <body name="left_hair" pos="0 0 .1"><joint name="left_hair" type="slide" range="-.1 .2"/><geom type="sphere"/></body>
    </body>
  </body>
  <body name="right" pos="0 -.2 0" euler="-10 -50 -35" childclass="mirrored"><joint name="right"/><geom type="capsule"/>
    <body name="right_toe" pos=".1 0 0"><joint name="right_toe"/><geom type="sphere"/></body>
  </body>
</mujocoinclude>"#;
    std::fs::write(folder.path().join("limbs.xml"), limbs).unwrap();
    let path = folder.path().join("main.xml");
    std::fs::write(&path, main).unwrap();
    let model = bodyschema::mujoco::Model::from_path(path).unwrap();
    Body::new(model.into(), &JointSelection::All).unwrap()
}

/// Every creature of these tests, by name.
fn creatures() -> Vec<(&'static str, Body)> {
    vec![
        ("in several files", in_several_files()),
        ("a part of the free body", {
            let model = bodyschema::mujoco::Model::from_xml(FREE).unwrap();
            Body::rooted(model.into(), &JointSelection::All, Some("cart")).unwrap()
        }),
        ("Max", max("all")),
        ("Max's torso", max("torso")),
        ("free", creature(FREE)),
        ("balls", creature(BALLS)),
        ("mounted", creature(MOUNTED)),
        ("one joint of the free body held", {
            let model = bodyschema::mujoco::Model::from_xml(FREE).unwrap();
            Body::new(model.into(), &"first,third,rail,tip,wheel".parse().unwrap()).unwrap()
        }),
    ]
}

/// A frame's distance from a pose: metres, and the largest difference of matrix entries.
fn apart(found: &Frame, expected: &Isometry3<f64>) -> (f64, f64) {
    let rotation = expected.rotation.to_rotation_matrix().into_inner();
    ((found.origin - expected.translation.vector).norm(), (found.rotation - rotation).amax())
}

fn compose(a: &Frame, b: &Isometry3<f64>) -> Frame {
    let rotation: Matrix3<f64> = b.rotation.to_rotation_matrix().into_inner();
    Frame { rotation: a.rotation * rotation, origin: a.point(&b.translation.vector) }
}

#[test]
fn forward_kinematics_agree_with_mujoco_for_every_limb_of_every_creature() {
    for (name, body) in creatures() {
        let schema = truth(&body);
        let mut data = Data::new(body.model.clone()).unwrap();
        let mut rng = ChaCha8Rng::seed_from_u64(7);
        for _ in 0..POSTURES {
            let posture = Posture::random(&body.creature, &mut rng);
            take(&body, &mut data, &posture);
            let frames = limb_frames(&body.creature, &schema, &posture);
            let root = data.body_pose(body.root);
            let mut seen = vec![false; frames.len()];
            for (b, limb) in body.limb_of_body.iter().enumerate() {
                let Some(limb) = *limb else { continue };
                seen[limb] = true;
                let found = compose(&frames[limb], &body.pose_in_limb[b]);
                let (metres, turn) = apart(&found, &root.inv_mul(&data.body_pose(b)));
                let at = format!("{name}, body {:?}: {metres} m, {turn}", body.model.body(b).name);
                assert!(metres < POSITION && turn < ROTATION, "{at}");
                let limb_pose = root.inv_mul(&body.limb_pose(&data, limb).unwrap());
                let (metres, turn) = apart(&frames[limb], &limb_pose);
                assert!(metres < POSITION && turn < ROTATION, "{name}, limb {limb}: {metres} m, {turn}");
            }
            // Limbs between two joints of one body bear no body: their origin is the joint's anchor.
            for (k, segment) in body.segments.iter().enumerate().filter(|(k, _)| !seen[k + 1]) {
                assert!(!segment.last, "{name}: limb {} bears no body", k + 1);
                let mut joints = segment.joints.iter();
                if segment.joints.iter().any(|&j| body.model.joint(j).kind == JointKind::Slide) {
                    continue; // MuJoCo's anchor shifts with the slides before it; later limbs check these.
                }
                let anchor = root.inverse_transform_point(&data.joint_anchor(*joints.next().unwrap()));
                assert!((frames[k + 1].origin - anchor.coords).norm() < POSITION, "{name}, limb {}", k + 1);
            }
        }
    }
}

#[test]
fn receptors_of_max_are_where_mujoco_has_their_sites() {
    for joints in ["all", "torso"] {
        let body = max(joints);
        let (schema, skin) = (truth(&body), skin_of(&body));
        let mut data = Data::new(body.model.clone()).unwrap();
        let mut rng = ChaCha8Rng::seed_from_u64(8);
        for _ in 0..POSTURES {
            let posture = Posture::random(&body.creature, &mut rng);
            take(&body, &mut data, &posture);
            let frames = limb_frames(&body.creature, &schema, &posture);
            let root = data.body_pose(body.root);
            for receptor in &skin.receptors {
                let site = body.model.id(ObjectKind::Site, &receptor.id).unwrap();
                let expected = root.inverse_transform_point(&data.site_pose(site).translation.vector.into());
                let found = frames[receptor.limb].point(&receptor.position);
                assert!((found - expected.coords).norm() < POSITION, "{}", receptor.id);
            }
        }
    }
}

#[test]
fn the_reference_posture_puts_no_joint_out_of_line() {
    for (name, body) in creatures() {
        let frames = limb_frames(&body.creature, &truth(&body), &body.creature.reference_posture());
        for frame in frames {
            assert!((frame.rotation - Matrix3::identity()).amax() < ROUNDING, "{name}");
        }
    }
}

/// Central differences of `f` by the three coordinates of the vector that `at` picks from a schema.
fn differences(
    schema: &BodySchema,
    at: impl Fn(&mut BodySchema) -> &mut Vector3<f64>,
    f: impl Fn(&BodySchema) -> Vector3<f64>,
) -> Matrix3<f64> {
    let mut columns = Matrix3::zeros();
    for k in 0..3 {
        let moved = |step: f64| {
            let mut schema = schema.clone();
            at(&mut schema)[k] += step;
            f(&schema)
        };
        columns.set_column(k, &((moved(STEP) - moved(-STEP)) / (2.0 * STEP)));
    }
    columns
}

#[test]
fn point_jacobians_agree_with_central_differences_on_the_sphere_and_off_it() {
    let mut kinds = Vec::new();
    for (name, body) in creatures() {
        let body_creature = &body.creature;
        let mut rng = ChaCha8Rng::seed_from_u64(9);
        for scaled in [false, true] {
            let mut schema = truth(&body);
            if scaled {
                schema.axes.iter_mut().for_each(|axis| *axis *= rng.random_range(0.4..1.8));
            }
            let posture = Posture::random(body_creature, &mut rng);
            for limb in 1..body_creature.limbs().len() {
                let chain = Chain::between(body_creature, 0, limb);
                let side = ChainSide::new(body_creature, &chain.sides[1], &posture);
                let p_l = Vector3::from_fn(|_, _| rng.random_range(-0.3..0.3));
                let land = |schema: &BodySchema| side.frame(schema).point(&p_l);
                let mut jacobian = SideJacobian::default();
                side.point_jacobian(&schema, &p_l, &mut jacobian);
                assert!((jacobian.position - land(&schema)).norm() < ROUNDING, "{name}");
                assert!((jacobian.frame.rotation - side.frame(&schema).rotation).amax() < ROUNDING, "{name}");
                let joints: Vec<usize> = jacobian.joints.iter().map(|(joint, _)| *joint).collect();
                assert_eq!(joints, chain.sides[1], "{name}");
                for (joint, derivative) in &jacobian.joints {
                    let expected = differences(&schema, |s| &mut s.positions[*joint], land);
                    assert!((derivative - expected).amax() < DERIVATIVE, "{name}, position {joint}");
                }
                let dofs: Vec<usize> = jacobian.dofs.iter().map(|(dof, _)| *dof).collect();
                let of_chain = chain.sides[1].iter().flat_map(|&j| body_creature.joints()[j].dof_indices());
                assert_eq!(dofs, of_chain.collect::<Vec<_>>(), "{name}");
                for (dof, derivative) in &jacobian.dofs {
                    let kind = body_creature.dofs().nth(*dof).unwrap().kind;
                    kinds.push(kind);
                    let expected = differences(&schema, |s| &mut s.axes[*dof], land);
                    let off = (derivative - expected).amax();
                    assert!(off < DERIVATIVE, "{name}, axis {dof} ({kind:?}): {off}");
                }
            }
        }
    }
    for kind in [DofKind::Hinge, DofKind::Slide, DofKind::Ball] {
        assert!(kinds.contains(&kind), "no {kind:?} was checked");
    }
}

#[test]
fn freedoms_move_points_and_directions_as_central_differences_do() {
    let mut compared = 0;
    for (name, body) in creatures() {
        let (creature, schema) = (&body.creature, truth(&body));
        let mut rng = ChaCha8Rng::seed_from_u64(11);
        let joints: Vec<usize> = (0..creature.joints().len()).collect();
        let freedoms = Freedoms::new(creature, &schema, &joints);
        // Half way to the middle, no coordinate is at the end of its range.
        let middle = Posture::start(creature);
        let posture = Posture::between(creature, &Posture::random(creature, &mut rng), &middle, 0.5);
        let count = freedoms.count();
        for limb in 1..creature.limbs().len() {
            let p_l = Vector3::from_fn(|_, _| rng.random_range(-0.3..0.3));
            let along = Vector3::from_fn(|_, _| rng.random_range(-1.0..1.0));
            // Where the point and the direction are along `along`, and how fast that grows.
            let at = |posture: &[f64]| {
                let now = freedoms.at(posture);
                let (point, direction) = (now.frames[limb].point(&p_l), now.frames[limb].direction(&p_l));
                let mut rates = [vec![0.0; count], vec![0.0; count]];
                now.add_rates(limb, Feature::Point(point), &along, &mut rates[0]);
                now.add_rates(limb, Feature::Direction(direction), &along, &mut rates[1]);
                ([point.dot(&along), direction.dot(&along)], rates)
            };
            let (_, rates) = at(&posture);
            for k in 0..count {
                let mut step = vec![0.0; count];
                step[k] = STEP;
                let more = at(&freedoms.changed(&posture, &step));
                step[k] = -STEP;
                let less = at(&freedoms.changed(&posture, &step));
                for ((more, less), rates) in more.0.iter().zip(less.0).zip(&rates) {
                    let rate = (more - less) / (2.0 * STEP);
                    assert!((rate - rates[k]).abs() < DERIVATIVE, "{name}, limb {limb}, {k}");
                    compared += 1;
                }
            }
        }
    }
    assert!(compared > 1000, "{compared}");
}

#[test]
fn joints_that_are_held_are_multiplied_out_and_change_nothing_of_the_others() {
    for (name, body) in creatures() {
        let mut rng = ChaCha8Rng::seed_from_u64(12);
        let schema = truth(&body);
        let joints = body.creature.joints().len();
        // All others change: what is held may not be asked of the schema again.
        let mut moved = schema.clone();
        let is_held: Vec<bool> = (0..joints).map(|_| rng.random_bool(0.6)).collect();
        for joint in (0..joints).filter(|&joint| is_held[joint]) {
            moved.positions[joint] *= 2.0;
            body.creature.joints()[joint].dof_indices().for_each(|dof| moved.axes[dof] *= -1.0);
        }
        let posture = Posture::random(&body.creature, &mut rng);
        for limb in 1..body.creature.limbs().len() {
            let chain = Chain::between(&body.creature, 0, limb);
            let side = ChainSide::new(&body.creature, &chain.sides[1], &posture);
            // Held one after the other, as by learners of parts of parts.
            let held = side.with_held(&schema, |joint| is_held[joint] && joint % 2 == 0);
            let held = held.with_held(&schema, |joint| is_held[joint]);
            let p_l = Vector3::from_fn(|_, _| rng.random_range(-0.3..0.3));
            let (mut all, mut rest) = (SideJacobian::default(), SideJacobian::default());
            side.point_jacobian(&schema, &p_l, &mut all);
            held.point_jacobian(&moved, &p_l, &mut rest);
            assert!((all.position - rest.position).norm() < ROUNDING, "{name}");
            assert!((held.frame(&moved).origin - all.frame.origin).norm() < ROUNDING, "{name}");
            all.joints.retain(|(joint, _)| !is_held[*joint]);
            let of_free = |dof: usize| {
                all.joints.iter().any(|(j, _)| body.creature.joints()[*j].dof_indices().contains(&dof))
            };
            let dofs = all.dofs.iter().filter(|(dof, _)| of_free(*dof));
            assert_eq!(rest.joints.len(), all.joints.len(), "{name}");
            for ((i, a), (j, b)) in all.joints.iter().chain(dofs).zip(rest.joints.iter().chain(&rest.dofs)) {
                assert!(i == j && (a - b).amax() < ROUNDING, "{name}, {i} and {j}");
            }
        }
    }
}

#[test]
fn jacobian_buffers_can_be_used_again_for_another_chain() {
    let body = creature(FREE);
    let schema = truth(&body);
    let posture = Posture::random(&body.creature, &mut ChaCha8Rng::seed_from_u64(3));
    let side = |limb| {
        let chain = Chain::between(&body.creature, 0, limb);
        ChainSide::new(&body.creature, &chain.sides[1], &posture)
    };
    let p_l = Vector3::new(0.1, 0.2, 0.3);
    let mut used = SideJacobian::default();
    side(body.creature.limbs().len() - 1).point_jacobian(&schema, &p_l, &mut used);
    side(1).point_jacobian(&schema, &p_l, &mut used);
    let mut fresh = SideJacobian::default();
    side(1).point_jacobian(&schema, &p_l, &mut fresh);
    assert_eq!((used.joints, used.dofs, used.position), (fresh.joints, fresh.dofs, fresh.position));
}

/// A limb and all that carry it, outermost first.
fn ancestors(creature: &Creature, limb: usize) -> Vec<usize> {
    std::iter::successors(Some(limb), |&limb| creature.parent_of(limb)).collect()
}

#[test]
fn a_chain_meets_at_the_nearest_common_ancestor_and_reads_the_same_both_ways() {
    for (name, body) in creatures() {
        let creature = &body.creature;
        for a in 0..creature.limbs().len() {
            for b in 0..creature.limbs().len() {
                let chain = Chain::between(creature, a, b);
                let (of_a, of_b) = (ancestors(creature, a), ancestors(creature, b));
                let nearest = of_a.iter().find(|limb| of_b.contains(limb)).unwrap();
                assert_eq!(chain.ancestor, *nearest, "{name}: {a} to {b}");
                for (side, end, path) in [(0, a, &of_a), (1, b, &of_b)] {
                    let mut limb = chain.ancestor;
                    for &joint in &chain.sides[side] {
                        assert_eq!(creature.joints()[joint].parent, limb, "{name}: {a} to {b}");
                        limb = joint + 1;
                        assert!(path.contains(&limb), "{name}: {a} to {b}");
                    }
                    assert_eq!(limb, end, "{name}: {a} to {b}");
                }
                let back = Chain::between(creature, b, a);
                assert_eq!(back.ancestor, chain.ancestor);
                assert_eq!([&back.sides[1], &back.sides[0]], [&chain.sides[0], &chain.sides[1]]);
                assert_eq!(chain.joints().count(), chain.sides[0].len() + chain.sides[1].len());
                assert_eq!(a == b, chain.joints().count() == 0);
            }
        }
    }
}

#[test]
fn the_two_sides_of_a_chain_put_a_point_where_the_limb_frames_put_it() {
    for (name, body) in creatures() {
        let schema = truth(&body);
        let mut rng = ChaCha8Rng::seed_from_u64(10);
        let limbs = body.creature.limbs().len();
        let posture = Posture::random(&body.creature, &mut rng);
        let frames = limb_frames(&body.creature, &schema, &posture);
        for _ in 0..200 {
            let ends = [rng.random_range(0..limbs), rng.random_range(0..limbs)];
            let chain = Chain::between(&body.creature, ends[0], ends[1]);
            let p_l = Vector3::from_fn(|_, _| rng.random_range(-0.3..0.3));
            for (side, end) in chain.sides.iter().zip(ends) {
                let x_cl = ChainSide::new(&body.creature, side, &posture).frame(&schema);
                let by_root = frames[chain.ancestor].inverse_point(&frames[end].point(&p_l));
                assert!((x_cl.point(&p_l) - by_root).norm() < ROUNDING, "{name}: {ends:?}");
            }
        }
    }
}

#[test]
fn a_pose_undone_gives_the_point_back() {
    let body = max("all");
    let mut rng = ChaCha8Rng::seed_from_u64(11);
    let posture = Posture::random(&body.creature, &mut rng);
    for frame in limb_frames(&body.creature, &truth(&body), &posture) {
        let p = Vector3::from_fn(|_, _| rng.random_range(-1.0..1.0));
        assert!((frame.inverse_point(&frame.point(&p)) - p).norm() < ROUNDING);
    }
}

#[test]
fn a_limbs_pose_in_another_and_its_jacobian_agree_with_frames_and_central_differences() {
    for (name, body) in creatures() {
        let (creature, schema) = (&body.creature, &truth(&body));
        let mut rng = ChaCha8Rng::seed_from_u64(11);
        let limbs = creature.limbs().len();
        for _ in 0..POSTURES {
            let posture = Posture::random(creature, &mut rng);
            let [of, wrt] = [rng.random_range(0..limbs), rng.random_range(0..limbs)];
            let relative = RelativePoses::new(creature, schema, &[0, of], wrt);
            let mut posed = relative.room();
            let mut pose_at = |posture: &[f64]| {
                relative.put(posture, &mut posed);
                relative.pose(1, &posed)
            };
            let (mut here, mut jacobian) = (relative.room(), vec![0.0; 6 * creature.dof()]);
            relative.put(&posture, &mut here);
            relative.jacobian(1, &here, &mut jacobian);
            let frames = limb_frames(creature, schema, &posture);
            let (pose, expected) = (pose_at(&posture), frames[wrt].inverse() * frames[of]);
            assert!((pose.origin - expected.origin).norm() < ROUNDING, "{name}");
            assert!((pose.rotation - expected.rotation).norm() < ROUNDING, "{name}");
            let mut column = 0;
            for element in creature.elements() {
                for k in 0..element.kind.dof() {
                    let [after, before] = [STEP, -STEP].map(|step| {
                        let mut moved = posture.clone();
                        let q = element.of_mut(&mut moved);
                        match element.kind {
                            DofKind::Ball => turn_ball(q, &(Vector3::ith(k, step)), f64::INFINITY),
                            _ => q[0] += step,
                        }
                        pose_at(&moved)
                    });
                    let velocity = (after.origin - before.origin) / (2.0 * STEP);
                    let turning =
                        (after.rotation - before.rotation) / (2.0 * STEP) * pose.rotation.transpose();
                    let omega = Vector3::new(turning.m32, turning.m13, turning.m21);
                    for row in 0..3 {
                        let [linear, angular] =
                            [row, 3 + row].map(|row| jacobian[row * creature.dof() + column]);
                        let off = (linear - velocity[row]).abs().max((angular - omega[row]).abs());
                        assert!(off < DERIVATIVE, "{name}, {}: {off}", element.name);
                    }
                    column += 1;
                }
            }
        }
    }
}
