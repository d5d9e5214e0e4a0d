//! Limbs in frames of their own: the equation and its derivatives, learning, files and commands.

use std::fs;
use std::path::Path;
use std::sync::Arc;

use crate::common::program::run;
use crate::common::{babble, creature, max, two_arms};
use bodyschema::agent::Agent;
use bodyschema::creature::{Body, Creature, JointSelection, Posture};
use bodyschema::evaluation::{Evaluation, evaluate, evaluate_learned};
use bodyschema::export::to_mjcf;
use bodyschema::geometry::Frame;
use bodyschema::ground_truth::GroundTruth;
use bodyschema::kinematics::{Chain, ChainSide, SideJacobian, limb_frames};
use bodyschema::learning::{Account, Input, Learned, Learner, LimbFrames, SecondOrder};
use bodyschema::mujoco::{Data, Model};
use bodyschema::schema::{BodySchema, nearest_rotation};
use bodyschema::senses::RecordedTouch;
use bodyschema::session::{read_schema, write_schema};
use bodyschema::skin::{Skin, skin_of};
use nalgebra::{DVector, Matrix3, Rotation3, UnitQuaternion, Vector3};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use serde_json::Value;

/// Rounding in poses of bodies of a metre or two.
const ROUNDING: f64 = 1e-12;
/// Rounding in central differences.
const DERIVATIVE: f64 = 1e-8;
/// Greatest held-out error from exact contact points, millimetres.
const EXACT_MM: f64 = 1e-6;

/// The random stream of a seed that frames are drawn from, apart from those of babbling, initial guesses and disturbances.
const FRAME_STREAM: u64 = u64::MAX - 3;
/// How far an own frame's origin may be from the joint along each axis, metres.
const FARTHEST: f64 = 0.1;

/// Per limb, the pose of its own frame in the frame of its joint.
#[derive(Clone, Debug, PartialEq)]
struct OwnFrames(Vec<Frame>);

impl OwnFrames {
    /// Random frames: any rotation, and a shift of up to 0.1 m along each axis, for every limb, the root among
    /// them.
    fn random(creature: &Creature, seed: u64) -> OwnFrames {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        rng.set_stream(FRAME_STREAM);
        let frame = |_| {
            // Four normal numbers point to a rotation drawn uniformly from all.
            let [w, x, y, z]: [f64; 4] = std::array::from_fn(|_| StandardNormal.sample(&mut rng));
            let turn = UnitQuaternion::from_quaternion(nalgebra::Quaternion::new(w, x, y, z));
            let origin = Vector3::from_fn(|_, _| rng.random_range(-FARTHEST..FARTHEST));
            Frame { rotation: turn.to_rotation_matrix().into_inner(), origin }
        };
        OwnFrames((0..creature.limbs().len()).map(frame).collect())
    }

    /// The skin in these frames.
    fn skin(&self, skin: &Skin) -> Skin {
        let mut skin = skin.clone();
        for receptor in &mut skin.receptors {
            let frame = &self.0[receptor.limb];
            receptor.position = frame.inverse_point(&receptor.position);
            receptor.normal = frame.rotation.tr_mul(&receptor.normal);
            receptor.tangent = frame.rotation.tr_mul(&receptor.tangent);
        }
        for surface in &mut skin.surfaces {
            let frame = &self.0[surface.limb];
            surface.origin = frame.inverse_point(&surface.origin);
            surface.rotation = frame.rotation.tr_mul(&surface.rotation);
        }
        skin
    }

    /// Touches of a skin in these frames.
    fn touches(&self, skin: &Skin, touches: &[RecordedTouch]) -> Vec<RecordedTouch> {
        let mut touches = touches.to_vec();
        for touch in &mut touches {
            let limbs = touch.limbs(skin);
            for (point, limb) in touch.exact_contact_mut().points.iter_mut().zip(limbs) {
                *point = self.0[limb].inverse_point(point);
            }
        }
        touches
    }

    /// A schema with limbs in their joints' frames, of the same body in these frames.
    fn schema(&self, creature: &Creature, schema: &BodySchema) -> BodySchema {
        let mut schema = schema.clone().with_limb_poses();
        for (limb, frame) in self.0.iter().enumerate() {
            schema.reframe(creature, limb, frame);
        }
        schema
    }
}

/// A body told in random frames of its limbs' own.
struct Pupil {
    agent: Agent,
    truth: GroundTruth,
    touches: Vec<RecordedTouch>,
}

fn arms() -> Body {
    creature(&two_arms(r#"type="capsule" size="0.12 0.2""#, r#"type="capsule" size="0.03 0.2""#))
}

impl Pupil {
    fn new(body: &Body, touches: usize, seed: u64) -> Pupil {
        let agent = Agent::of(body).unwrap();
        let own = OwnFrames::random(agent.creature(), seed);
        let truth = GroundTruth::new(body).unwrap();
        Pupil {
            truth: GroundTruth { schema: own.schema(agent.creature(), &truth.schema), ..truth },
            touches: own.touches(agent.skin(), &babble(body, &agent, touches, seed, 2)),
            agent: agent.with_skin(own.skin(agent.skin())).unwrap(),
        }
    }

    fn limbs_of(&self, touch: &RecordedTouch) -> [usize; 2] {
        touch.ends.map(|end| self.agent.skin().receptors[end.receptor].limb)
    }

    fn learn(&self, seed: u64) -> Learned {
        let mut learner = SecondOrder::new(&self.agent, Input::Contact, seed).with_frames(LimbFrames::Limb);
        self.touches.iter().for_each(|touch| learner.touch(&touch.felt(Input::Contact)));
        learner.learn()
    }

    fn evaluate(&self, learned: &Learned) -> Evaluation {
        evaluate_learned(&self.agent, &self.truth, learned)
    }

    /// The limbs of a touch's ends that nothing touched.
    fn untouched(&self) -> Vec<usize> {
        let touched = |limb: &usize| self.touches.iter().any(|touch| self.limbs_of(touch).contains(limb));
        let with_skin = |limb: &usize| self.agent.skin().receptors.iter().any(|r| r.limb == *limb);
        (0..self.agent.creature().limbs().len()).filter(|limb| with_skin(limb) && !touched(limb)).collect()
    }
}

#[test]
fn limbs_in_other_frames_are_the_same_body() {
    let body = max("torso");
    let agent = Agent::of(&body).unwrap();
    let creature = agent.creature();
    let truth = GroundTruth::new(&body).unwrap().schema;
    let own = OwnFrames::random(creature, 3);
    let (schema, own_skin) = (own.schema(creature, &truth), own.skin(agent.skin()));
    let mut rng = ChaCha8Rng::seed_from_u64(1);
    for _ in 0..20 {
        let posture = Posture::random(creature, &mut rng);
        let frames = [limb_frames(creature, &truth, &posture), limb_frames(creature, &schema, &posture)];
        let [before, after] = [(&frames[0], agent.skin()), (&frames[1], &own_skin)].map(|(frames, skin)| {
            let place = |r: usize| {
                let receptor = &skin.receptors[r];
                frames[receptor.limb].point(&receptor.position)
            };
            (1..skin.receptors.len()).map(|r| (place(r) - place(0)).norm()).collect::<Vec<f64>>()
        });
        assert!(before.iter().zip(&after).all(|(a, b)| (a - b).abs() < ROUNDING));
    }
    for receptor in &own_skin.receptors {
        assert!(receptor.normal.dot(&receptor.tangent).abs() < ROUNDING);
    }
}

#[test]
fn the_derivatives_by_a_limbs_pose_agree_with_central_differences() {
    let body = max("torso");
    let creature = &body.creature;
    let truth = GroundTruth::new(&body).unwrap().schema;
    let mut schema = OwnFrames::random(creature, 5).schema(creature, &truth);
    let mut rng = ChaCha8Rng::seed_from_u64(2);
    // Off the rotations, where a solver may begin.
    schema.limb_poses.iter_mut().for_each(|pose| pose.rotation *= rng.random_range(0.5..1.5));
    let posture = Posture::random(creature, &mut rng);
    let limb = creature.limb("left_hand").unwrap();
    let chain = Chain::between(creature, 0, limb);
    let side = ChainSide::new(creature, &chain.sides[1], &posture);
    let p_l = Vector3::new(0.1, -0.2, 0.05);
    let mut jacobian = SideJacobian::default();
    side.point_jacobian(&schema, &p_l, &mut jacobian);
    assert!((jacobian.position - side.frame(&schema).point(&p_l)).norm() < ROUNDING);
    assert_eq!(jacobian.poses.len(), chain.sides[1].len());
    let step = 1e-6;
    for pose in &jacobian.poses {
        let difference = |change: &dyn Fn(&mut Frame, f64)| {
            let [ahead, behind] = [step, -step].map(|step| {
                let mut moved = schema.clone();
                change(&mut moved.limb_poses[pose.joint], step);
                side.frame(&moved).point(&p_l)
            });
            (ahead - behind) / (2.0 * step)
        };
        for k in 0..3 {
            let by_origin = difference(&|frame, step| frame.origin[k] += step);
            assert!((pose.map.column(k) - by_origin).norm() < DERIVATIVE);
            for i in 0..3 {
                let by_rotation = difference(&|frame, step| frame.rotation[(i, k)] += step);
                assert!((pose.map.column(i) * pose.point[k] - by_rotation).norm() < DERIVATIVE);
            }
        }
    }
}

#[test]
fn the_nearest_rotation_is_one_and_undoes_a_stretch() {
    let turn = Rotation3::from_euler_angles(0.4, -1.1, 2.0).into_inner();
    let stretch = Matrix3::from_diagonal(&Vector3::new(1.4, 0.8, 1.1));
    assert!((nearest_rotation(&(turn * stretch)) - turn).norm() < ROUNDING);
    // What points in a plane leave of a rotation is still enough.
    let flat = Matrix3::from_diagonal(&Vector3::new(1.0, 1.0, 0.0));
    assert!((nearest_rotation(&(turn * flat)) - turn).norm() < ROUNDING);
    assert!((nearest_rotation(&-turn).determinant() - 1.0).abs() < ROUNDING);
    assert_eq!(nearest_rotation(&Matrix3::repeat(f64::NAN)), Matrix3::identity());
}

#[test]
fn arms_whose_limbs_have_frames_of_their_own_are_learned_from_contact_points() {
    let pupil = Pupil::new(&arms(), 200, 4);
    let learned = pupil.learn(4);
    assert!(learned.verdict.converged(), "{:?}", learned.verdict);
    assert_eq!((learned.undetermined(), learned.undetermined_limbs()), (vec![], vec![]));
    let found = pupil.evaluate(&learned);
    assert!(found.heldout_mm.max < EXACT_MM, "{:?}", found.heldout_mm);
    assert!(found.axis_deg.max < 1e-6, "{:?}", found.axis_deg);
    // And the measure tells a limb that is turned on its joint.
    let mut turned = learned.schema.clone();
    let joint = pupil.agent.creature().joint_of(pupil.agent.creature().limb("left_fore").unwrap()).unwrap();
    turned.limb_poses[joint].rotation *= Rotation3::from_euler_angles(0.0, 0.0, 0.02).matrix();
    let found = evaluate(&pupil.agent, &pupil.truth, &turned, &[]);
    assert!(found.heldout_mm.max > 1.0, "{:?}", found.heldout_mm);
}

#[test]
fn max_is_learned_with_all_limbs_in_frames_of_their_own_and_untouched_limbs_are_named() {
    let pupil = Pupil::new(&max("torso"), 500, 1);
    let learned = pupil.learn(1);
    assert!(learned.verdict.converged(), "{:?}", learned.verdict);
    assert!(learned.undetermined().is_empty(), "{:?}", learned.undetermined());
    let untouched = pupil.untouched();
    assert!(untouched.iter().all(|limb| learned.undetermined_limbs().contains(limb)));
    assert!(learned.undetermined_limbs().len() < 6, "{:?}", learned.undetermined_limbs());
    let found = pupil.evaluate(&learned);
    assert!(found.determined_mm.max < EXACT_MM, "{:?}", found.determined_mm);
    assert!(found.axis_deg.max < 1e-6 && found.axis_line_mm.max < EXACT_MM, "{found:?}");
    // Untouched limbs have the frames of their joints.
    for &limb in untouched.iter().filter(|&&limb| limb > 0) {
        assert_eq!(learned.schema.limb_poses[limb - 1], Frame::identity());
    }
}

#[test]
fn a_limb_that_two_touches_met_is_named_and_nothing_wrong_is_claimed() {
    let mut pupil = Pupil::new(&arms(), 250, 6);
    let fore = pupil.agent.creature().limb("left_fore").unwrap();
    let mut met = 0;
    let kept: Vec<RecordedTouch> = pupil
        .touches
        .iter()
        .filter(|touch| {
            met += usize::from(pupil.limbs_of(touch).contains(&fore));
            !pupil.limbs_of(touch).contains(&fore) || met <= 2
        })
        .cloned()
        .collect();
    pupil.touches = kept;
    let learned = pupil.learn(6);
    let claimed = |account: &Account| account.limbs().iter().any(|&b| b != fore && account.claims(fore, b));
    assert!(!learned.account.as_ref().is_some_and(claimed), "{:?}", learned.undetermined_limbs());
    if learned.verdict.converged() {
        let found = pupil.evaluate(&learned);
        assert!(found.determined_mm.max < EXACT_MM, "{:?}", found.determined_mm);
    }
}

#[test]
fn the_frames_of_joints_are_found_where_points_are_given_in_them() {
    let body = arms();
    let mut pupil = Pupil::new(&body, 0, 2);
    pupil.agent = Agent::of(&body).unwrap();
    pupil.truth = GroundTruth::new(&body).unwrap();
    pupil.touches = babble(&body, &pupil.agent, 200, 2, 2);
    let learned = pupil.learn(2);
    assert!(learned.verdict.converged(), "{:?}", learned.verdict);
    for (joint, pose) in learned.schema.limb_poses.iter().enumerate() {
        let off = (pose.rotation - Matrix3::identity()).norm() + pose.origin.norm();
        assert!(off < 1e-8, "{}: {pose:?}", pupil.agent.creature().joints()[joint].name);
        let position = pupil.truth.schema.positions[joint];
        assert!((learned.schema.positions[joint] - position).norm() < 1e-8);
    }
}

#[test]
fn choosing_where_a_joint_lies_along_its_hinge_moves_nothing() {
    let body = creature(HINGES);
    let creature = &body.creature;
    let truth = GroundTruth::new(&body).unwrap().schema;
    let schema = OwnFrames::random(creature, 8).schema(creature, &truth);
    let mut settled = schema.clone();
    settled.settle_positions(creature);
    assert_ne!(schema, settled);
    for (joint, pose) in creature.joints().iter().zip(&settled.limb_poses) {
        assert!(pose.origin.dot(&settled.axes[joint.first_dof()]).abs() < ROUNDING);
    }
    let mut rng = ChaCha8Rng::seed_from_u64(3);
    for _ in 0..20 {
        let posture = Posture::random(creature, &mut rng);
        let frames = [&schema, &settled].map(|schema| limb_frames(creature, schema, &posture));
        for (a, b) in frames[0].iter().zip(&frames[1]) {
            assert!((a.rotation - b.rotation).norm() + (a.origin - b.origin).norm() < ROUNDING);
        }
    }
}

#[test]
fn a_schema_with_limbs_poses_survives_its_file_and_a_wrong_file_is_told_from_it() {
    let body = max("torso");
    let creature = &body.creature;
    let truth = GroundTruth::new(&body).unwrap().schema;
    let mut schema = OwnFrames::random(creature, 9).schema(creature, &truth);
    schema.limb_poses[3] = Frame::identity();
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("schema.json");
    write_schema(&path, creature, &schema, None).unwrap();
    let read = read_schema(&path, creature).unwrap();
    assert_eq!((&read.positions, &read.axes), (&schema.positions, &schema.axes));
    for (a, b) in read.limb_poses.iter().zip(&schema.limb_poses) {
        assert!((a.rotation - b.rotation).norm() + (a.origin - b.origin).norm() < ROUNDING);
    }
    assert_eq!(read.limb_poses[3], Frame::identity());
    let text = fs::read_to_string(&path).unwrap();
    let mut json: Value = serde_json::from_str(&text).unwrap();
    assert!(json["joints"][3].get("limb_position").is_none());
    let refused = |change: &dyn Fn(&mut Value)| {
        let mut wrong = json.clone();
        change(&mut wrong["joints"][2]);
        fs::write(&path, wrong.to_string()).unwrap();
        read_schema(&path, creature).unwrap_err().to_string()
    };
    let message = refused(&|joint| joint["limb_quaternion"][0] = 3.into());
    assert!(message.contains("limb_quaternion") && message.contains("divide"), "{message}");
    let message = refused(&|joint| drop(joint.as_object_mut().unwrap().remove("limb_position")));
    assert!(message.contains("both or neither"), "{message}");
    // Without poses nothing of them is in the file.
    write_schema(&path, creature, &truth, None).unwrap();
    json = serde_json::from_str(&fs::read_to_string(&path).unwrap()).unwrap();
    assert!(json["joints"][2].get("limb_quaternion").is_none());
    assert_eq!(read_schema(&path, creature).unwrap(), truth);
}

#[test]
fn mujoco_moves_the_exported_limbs_frames_as_the_schema_does() {
    for body in [max("torso"), creature(HINGES)] {
        let creature = &body.creature;
        let truth = GroundTruth::new(&body).unwrap().schema;
        let own = OwnFrames::random(creature, 11);
        let schema = own.schema(creature, &truth);
        let agent = Agent::new(creature.clone(), own.skin(&skin_of(&body))).unwrap();
        let model = Model::from_xml(&to_mjcf(&agent, &schema)).unwrap();
        let copy = Body::new(Arc::new(model), &JointSelection::All).unwrap();
        let mut data = Data::new(copy.model.clone()).unwrap();
        let mut rng = ChaCha8Rng::seed_from_u64(4);
        let body_of = |limb: usize| copy.limb_of_body.iter().position(|&l| l == Some(limb)).unwrap();
        for _ in 0..20 {
            let posture = Posture::random(creature, &mut rng);
            crate::common::take(&copy, &mut data, &posture);
            let root = data.body_pose(body_of(0));
            for (limb, frame) in limb_frames(creature, &schema, &posture).iter().enumerate() {
                let pose = root.inv_mul(&data.body_pose(body_of(limb)));
                let rotation = pose.rotation.to_rotation_matrix().into_inner();
                let name = &creature.limbs()[limb];
                assert!((pose.translation.vector - frame.origin).norm() < 1e-9, "{name}");
                assert!((rotation - frame.rotation).norm() < 1e-9, "{name}");
            }
        }
    }
}

#[test]
fn relaxed_steps_add_to_the_matrix_and_others_turn_it() {
    use bodyschema::learning::{AxisModel, Parameters};
    let body = creature(HINGES);
    let creature = &body.creature;
    let truth = GroundTruth::new(&body).unwrap().schema;
    let schema = OwnFrames::random(creature, 1).schema(creature, &truth);
    for (axis_model, size) in [(AxisModel::Relaxed, 9), (AxisModel::Unit, 3)] {
        let parameters =
            Parameters::new(creature, axis_model, |_| false).with_limb_poses(|joint| joint == 0, None);
        assert_eq!(parameters.len(), 3 + size);
        let moved = parameters.step(&schema, &DVector::from_element(3 + size, 0.1));
        let (before, after) = (schema.limb_poses[0], moved.limb_poses[0]);
        assert!((after.origin - before.origin - Vector3::repeat(0.1)).norm() < ROUNDING);
        let turn = after.rotation * before.rotation.transpose();
        let orthonormal = (turn * turn.transpose() - Matrix3::identity()).norm() < ROUNDING;
        assert_eq!(orthonormal, axis_model == AxisModel::Unit);
        let held = Parameters::new(creature, axis_model, |_| false).with_limb_poses(|_| true, Some(0));
        assert_eq!(
            held.step(&schema, &DVector::from_element(held.len(), 0.1)).limb_poses[0].rotation,
            before.rotation
        );
    }
}

/// A chain of single hinges and a slide.
const HINGES: &str = r#"<mujoco model="hinges">
  <compiler angle="radian" autolimits="true"/>
  <worldbody>
    <body name="base">
      <geom name="base" type="sphere" size="0.05"/>
      <site name="base_r" type="box" size="0.02 0.02 0.001" pos="0 0 0.05"/>
      <body name="first" pos="0.1 0.2 0.3">
        <joint name="first" axis="1 2 2" range="-1 1"/>
        <geom name="first" type="sphere" size="0.05" pos="0.2 0 0"/>
        <site name="first_r" type="box" size="0.02 0.02 0.001" pos="0.2 0 0.05"/>
        <body name="second" pos="0.3 0 0">
          <joint name="second" axis="0 -0.6 0.8" range="-2 2"/>
          <geom name="second" type="sphere" size="0.05" pos="0 0.2 0"/>
          <site name="second_r" type="box" size="0.02 0.02 0.001" pos="0 0.2 0.05"/>
        </body>
      </body>
    </body>
  </worldbody>
  <sensor><touch site="base_r"/><touch site="first_r"/><touch site="second_r"/></sensor>
</mujoco>"#;

fn json(place: &Path, arguments: &[&str]) -> Value {
    let output = run(place, arguments);
    assert_eq!(output.status.code(), Some(0), "{arguments:?}: {}", String::from_utf8_lossy(&output.stderr));
    serde_json::from_slice(&output.stdout).unwrap()
}

#[test]
fn a_session_is_learned_with_its_limbs_frames_evaluated_and_observed() {
    let place = tempfile::tempdir().unwrap();
    let arms = two_arms(r#"type="capsule" size="0.12 0.2""#, r#"type="capsule" size="0.03 0.2""#);
    fs::write(place.path().join("arms.xml"), arms).unwrap();
    let options = ["--frames", "limb", "--input", "contact", "--json"];
    let babble = ["babble", "arms.xml", "--touches", "200", "--seed", "3", "--out", "s"];
    let found = json(place.path(), &[&babble[..], &options].concat());
    assert_eq!((&found["converged"], &found["frames"]), (&true.into(), &"limb".into()));
    assert_eq!(found["undetermined_limbs"], serde_json::json!([]));
    let again = json(place.path(), &[&["learn", "s"][..], &options].concat());
    assert_eq!(found["heldout_mm"], again["heldout_mm"]);
    let measured = json(place.path(), &["report", "s", "--json"]);
    assert!(measured["heldout_mm"]["max"].as_f64().unwrap() < EXACT_MM, "{measured}");
    let schema = fs::read_to_string(place.path().join("s/schema.json")).unwrap();
    assert!(schema.contains("limb_position") && schema.contains("limb_quaternion"), "{schema}");
    assert_eq!(measured["rank"], measured["parameters"], "{measured}");
    let output = run(place.path(), &["learn", "s", "--known", "s/schema.json"]);
    let message = String::from_utf8(output.stderr).unwrap();
    assert!(output.status.code() == Some(1) && message.contains("--frames joint"), "{message}");
}

#[test]
fn what_cannot_tell_limbs_frames_is_refused() {
    let place = tempfile::tempdir().unwrap();
    let arms = two_arms(r#"type="capsule" size="0.12 0.2""#, r#"type="capsule" size="0.03 0.2""#);
    fs::write(place.path().join("arms.xml"), arms).unwrap();
    let refused = |more: &[&str], word: &str| {
        let output = run(place.path(), &[&["babble", "arms.xml", "--frames", "limb"][..], more].concat());
        let message = String::from_utf8(output.stderr).unwrap();
        assert!(output.status.code() == Some(1) && message.contains(word), "{message}");
    };
    refused(&[], "--input contact");
    refused(&["--input", "contact", "--learner", "hersch"], "--learner lm");
    fs::write(place.path().join("known.json"), r#"{"joints": []}"#).unwrap();
    refused(&["--input", "contact", "--known", "known.json"], "--known");
}

/// A creature as `learn --creature` reads it, and its touches as points in the limbs' frames.
fn recording(pupil: &Pupil) -> [String; 2] {
    let creature = pupil.agent.creature();
    let name = |limb: usize| creature.limbs()[limb].clone();
    let joints = creature.joints().iter().enumerate().map(|(joint, about)| {
        let dofs = about
            .dofs
            .iter()
            .map(|dof| serde_json::json!({"name": dof.name, "kind": "hinge", "range": dof.range}));
        serde_json::json!({"name": about.name, "parent": name(about.parent), "limb": name(joint + 1),
            "dofs": dofs.collect::<Vec<Value>>()})
    });
    let limbs: Vec<String> = (0..creature.limbs().len()).map(name).collect();
    let described =
        serde_json::json!({"name": "arms", "limbs": limbs, "joints": joints.collect::<Vec<Value>>()});
    let mut log = "limb_a,limb_b,ax,ay,az,bx,by,bz".to_string();
    creature.dofs().for_each(|dof| log += &format!(",{}", dof.name));
    for touch in &pupil.touches {
        let [a, b] = pupil.limbs_of(touch);
        log += &format!("\n{},{}", name(a), name(b));
        let points = touch.exact_contact().points.iter().flatten().copied();
        points.chain(touch.posture.iter().copied()).for_each(|x| log += &format!(",{x}"));
    }
    [described.to_string(), log]
}

#[test]
fn points_in_the_limbs_own_frames_are_noticed_and_the_option_for_them_is_named_once() {
    let pupil = Pupil::new(&arms(), 200, 3);
    let place = tempfile::tempdir().unwrap();
    let [creature, log] = recording(&pupil);
    fs::write(place.path().join("arms.json"), creature).unwrap();
    fs::write(place.path().join("log.csv"), log).unwrap();
    let learn = ["learn", "--creature", "arms.json", "--log", "log.csv"];
    let told = |more: &[&str]| {
        let output = run(place.path(), &[&learn[..], more].concat());
        assert_eq!(output.status.code(), Some(0));
        [output.stdout, output.stderr].map(|said| String::from_utf8(said).unwrap())
    };
    let [said, hint] = told(&["--out", "joint"]);
    assert!(said.contains("NOT learned"), "{said}");
    assert_eq!(hint.matches("--frames limb").count(), 1, "{hint}");
    let [said, hint] = told(&["--out", "limb", "--frames", "limb", "--input", "contact"]);
    assert!(!said.contains("NOT learned") && !hint.contains("--frames limb"), "{said}{hint}");
}
