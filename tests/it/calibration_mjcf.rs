//! Robots in MJCF: as MuJoCo has them, calibrated, and written back.

use std::fs;
use std::path::Path;
use std::sync::Arc;

use crate::common::calibrating::Place;
use crate::common::{at_random, repository};
use bodyschema::agent::Agent;
use bodyschema::calibration::robot::{Form, Knowledge, Posed, Robot, Value};
use bodyschema::creature::DofKind;
use bodyschema::geometry::Frame;
use bodyschema::mujoco::{Data, Equality, Model, ObjectKind};
use bodyschema::session::simulated::{misread, point_touches};
use bodyschema::session::{calibration_table, read_robot};
use nalgebra::Vector3;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// How far a body may be from where MuJoCo has it, metres and radians.
const ROUNDING: f64 = 1e-12;

/// All that MJCF can say of where bodies are, in degrees.
const ODD: &str = r#"<mujoco model="odd">
  <!-- as its maker has it -->
  <compiler eulerseq="zyx"/>
  <default>
    <joint axis="0 1 0"/>
    <default class="tip"><geom type="sphere" size="0.012"/></default>
    <default class="wrist"><joint ref="20" range="-10 70"/></default>
  </default>
  <worldbody>
    <geom name="plate" type="plane" size="1 1 .1"/>
    <geom name="ball" size=".07" pos="1 0 0"/>
    <body name="base" pos="0 0 .1" euler="10 20 30">
      <geom type="box" size=".1 .1 .1"/>
      <body name="upper"   axisangle="0 1 0 40" pos=".1 0 0.30">
        <joint name="yaw" axis="0 0 2" pos="0 .02 0"/>
        <joint name="pitch" pos=".01 0 -.02" ref="-15" range="-100 50"/>
        <geom type="capsule" fromto="0 0 0 0 0 .2" size=".03"/>
        <body name="fore" xyaxes="0 1 0 -1 0 0" pos="0 0 .2">
          <joint name="rail" type="slide" axis="0.6 0 0.8" ref=".03" range="0 .1"/>
          <geom size=".04"/>
          <body name="hand" zaxis="1 0 1">
            <joint class="wrist" name="wrist"/>
            <geom class="tip" pos="0 0 .05"/>
            <body name="finger" pos="0 .03 .1" quat="0 1 0 0"><joint name="finger"/><geom size=".01"/></body>
            <body name="thumb" pos="0 -.03 .1"><joint name="thumb" ref="5"/><geom name="pad" size=".01"/></body>
          </body>
          <body name="eye" pos="0 .1 0"><joint type="ball" name="eye"/><geom size=".02"/></body>
        </body>
      </body>
    </body>
  </worldbody>
  <equality>
    <joint joint1="thumb" joint2="wrist" polycoef="0.1 -0.5 0 0 0"/>
  </equality>
</mujoco>
"#;

/// A model's file, and in which of its bodies the root of its robot is.
fn robot_of(path: &Path) -> (Robot, Arc<Model>) {
    (read_robot(path).unwrap().robot, Arc::new(Model::from_path(path).unwrap()))
}

/// What encoders read in a random posture, and MuJoCo's `qpos` of it: joints that follow others by the model's equalities.
fn random_posture(robot: &Robot, model: &Model, rng: &mut ChaCha8Rng) -> (Vec<f64>, Vec<f64>) {
    let mut posture = robot.zero_posture();
    for dof in robot.leaders() {
        match dof.kind {
            DofKind::Ball => {
                let q = nalgebra::UnitQuaternion::new(Vector3::from_fn(|_, _| rng.random_range(-1.0..1.0)));
                posture[dof.coordinate..dof.coordinate + 4].copy_from_slice(&[q.w, q.i, q.j, q.k]);
            }
            _ => posture[dof.coordinate] = rng.random_range(-1.5..1.5),
        }
    }
    let mut qpos = model.qpos0().to_vec();
    for dof in robot.leaders() {
        let joint = model.joint(model.id(ObjectKind::Joint, &dof.name).unwrap());
        let count = dof.kind.coordinates();
        qpos[joint.qposadr..joint.qposadr + count]
            .copy_from_slice(&posture[dof.coordinate..dof.coordinate + count]);
    }
    for equality in model.equalities() {
        let Equality::Joint { follower, leader: Some(leader), polynomial } = equality else { continue };
        let [y, x] = [follower, leader].map(|joint| model.joint(joint).qposadr);
        let from = qpos[x] - model.qpos0()[x];
        let powers = polynomial.iter().enumerate().map(|(k, c)| c * from.powi(k as i32));
        qpos[y] = model.qpos0()[y] + powers.sum::<f64>();
    }
    (posture, qpos)
}

/// Every body of a robot at some values is where MuJoCo has it for what the encoders read.
fn assert_as_mujoco_has_it(robot: &Robot, values: &[Value], model: &Arc<Model>, seed: u64) {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let mut data = Data::new(model.clone()).unwrap();
    let mut compared = 0;
    for _ in 0..20 {
        let (posture, qpos) = random_posture(robot, model, &mut rng);
        data.set_qpos(&qpos).unwrap();
        data.kinematics().unwrap();
        let frames = Posed::new(robot, values, &posture).frames();
        let root = model.id(ObjectKind::Body, &robot.links[0].name).unwrap();
        let root = Frame::from(data.body_pose(root));
        for (link, frame) in robot.links.iter().zip(&frames) {
            let Some(body) = model.id(ObjectKind::Body, &link.name) else { continue };
            let theirs = root.inverse() * Frame::from(data.body_pose(body));
            let apart = (theirs.rotation - frame.rotation).norm().max((theirs.origin - frame.origin).norm());
            assert!(apart < ROUNDING, "{} of {}: {apart}", link.name, robot.name);
            compared += 1;
        }
    }
    assert!(compared >= 20 * 5);
}

/// Other values of all that MJCF can say.
fn others(robot: &Robot, rng: &mut ChaCha8Rng) -> Vec<Value> {
    let mut values = robot.nominal();
    let followers: Vec<String> = robot
        .dofs
        .iter()
        .filter(|dof| !robot.leaders().any(|leader| leader.name == dof.name))
        .map(|dof| format!("{}.gain", dof.name))
        .collect();
    for (quantity, value) in robot.quantities.iter().zip(&mut values) {
        let step: Vec<f64> = (0..3).map(|_| rng.random_range(-0.1..0.1)).collect();
        match quantity.name.rsplit('.').next().unwrap() {
            "gain" if !followers.contains(&quantity.name) => {}
            "compliance" => {}
            "radius" => *value = value.stepped(&[0.01 * step[0].abs()]),
            "sign" => *value = Value::Number(if rng.random() { 1.0 } else { -1.0 }),
            _ => *value = value.stepped(&step[..value.size()]),
        }
    }
    values
}

#[test]
fn bodies_are_where_mujoco_has_them() {
    let place = Place::new();
    place.write("odd.xml", ODD);
    let bodies = ["two_arms", "coupled", "arm7_gripper", "humanoid_ball", "starfish"];
    let mut paths: Vec<_> =
        bodies.iter().map(|name| repository(&format!("mjcf/bodies/{name}.xml"))).collect();
    paths.extend([repository("mjcf/max/max.xml"), place.path("odd.xml")]);
    for path in paths {
        let (robot, model) = robot_of(&path);
        assert_as_mujoco_has_it(&robot, &robot.nominal(), &model, 1);
    }
    let (odd, _) = robot_of(&place.path("odd.xml"));
    let dof = |name: &str| &odd.dofs[odd.dof(name).unwrap()];
    assert_eq!(dof("thumb").coordinate, dof("wrist").coordinate);
    assert!(matches!(odd.surfaces[odd.surface("plate").unwrap()].form, Form::Plane));
    assert!(odd.surface("hand").is_some() && odd.surface("pad").is_some());
    assert_eq!(odd.gravity, Vector3::new(0.0, 0.0, -9.81));
    assert!(odd.masses.len() >= 6);
}

#[test]
fn what_did_not_change_is_written_byte_for_byte_and_what_did_is_what_mujoco_has() {
    let place = Place::new();
    let names = ["two_arms.xml", "max.xml", "odd.xml", "coupled.xml"];
    let texts = [
        fs::read_to_string(repository("mjcf/bodies/two_arms.xml")).unwrap(),
        fs::read_to_string(repository("mjcf/max/max.xml")).unwrap(),
        ODD.replace('\n', "\r\n"),
        fs::read_to_string(repository("mjcf/bodies/coupled.xml")).unwrap(),
    ];
    let mut rng = ChaCha8Rng::seed_from_u64(3);
    for (name, text) in names.into_iter().zip(texts) {
        place.write(name, &text);
        let path = place.path(name);
        let mut file = read_robot(&path).unwrap();
        let same = file.with_values(&path, &file.robot.nominal()).unwrap();
        assert!(same.bytes == text.as_bytes() && same.left_out.is_empty(), "{:?}", same.left_out);
        // Mounts that were to be found are bodies then.
        file.robot.set_knowledge("*.mount.*", Knowledge::Free).unwrap();
        let values = others(&file.robot, &mut rng);
        let written = file.with_values(&path, &values).unwrap();
        assert_eq!(written.left_out, Vec::<String>::new());
        let made = place.path("made.xml");
        fs::write(&made, &written.bytes).unwrap();
        let (again, model) = robot_of(&made);
        assert_as_mujoco_has_it(&file.robot, &values, &model, 4);
        assert_as_mujoco_has_it(&again, &again.nominal(), &model, 5);
        let radius = |robot: &Robot, values: &[Value]| -> Vec<f64> {
            let radii = robot.quantities.iter().zip(values).filter(|(q, _)| q.name.ends_with(".radius"));
            radii.map(|(_, value)| value.number()).collect()
        };
        let (found, given) = (radius(&again, &again.nominal()), radius(&file.robot, &values));
        assert!(
            found.iter().zip(&given).all(|(a, b)| (a - b).abs() < ROUNDING) && found.len() == given.len()
        );
    }
    // Lines that say nothing of where bodies are stay.
    let written = fs::read_to_string(place.path("made.xml")).unwrap();
    assert!(written.contains(r#"<position kp="60" />"#));
}

#[test]
fn only_the_numbers_that_changed_are_written() {
    let place = Place::new();
    place.write("odd.xml", ODD);
    let path = place.path("odd.xml");
    let file = read_robot(&path).unwrap();
    let mut values = file.robot.nominal();
    let mut set = |name: &str, value: Value| values[file.robot.quantity(name).unwrap()] = value;
    set("upper.position", Value::Position(Vector3::new(0.1, 0.002, 0.3)));
    set("rail.offset", Value::Number(-0.025));
    set("finger.offset", Value::Number(-0.5f64.to_radians()));
    set("hand.radius", Value::Number(0.0125));
    set("wrist.gain", Value::Number(1.02));
    let written = file.with_values(&path, &values).unwrap();
    let expected = ODD
        .replace(r#"pos=".1 0 0.30""#, r#"pos=".1 0.002 0.30""#)
        .replace(r#"ref=".03""#, r#"ref="0.025""#)
        .replace(r#"<joint name="finger"/>"#, r#"<joint name="finger" ref="0.5"/>"#)
        .replace(r#"class="tip" pos="0 0 .05""#, r#"class="tip" pos="0 0 .05" size="0.0125""#);
    assert_eq!(String::from_utf8(written.bytes).unwrap(), expected);
    assert_eq!(written.left_out.len(), 1);
    assert!(written.left_out[0].starts_with("gain of wrist (1.020000) cannot be expressed in MJCF: "));
}

#[test]
fn several_things_are_added_to_a_body_that_holds_nothing() {
    let place = Place::new();
    place.write(
        "odd.xml",
        ODD.replace("<joint name=\"finger\"/>", "<joint name=\"finger\"/><body name=\"nail\"/>"),
    );
    let path = place.path("odd.xml");
    let mut file = read_robot(&path).unwrap();
    let nail = file.robot.link("nail").unwrap();
    file.robot.add_place("tip", nail, Vector3::z());
    for pattern in ["nail.mount.position", "tip.position"] {
        file.robot.set_knowledge(pattern, Knowledge::Free).unwrap();
    }
    let mut values = file.robot.nominal();
    values[file.robot.quantity("nail.mount.position").unwrap()] = Value::Position(Vector3::x());
    let text = String::from_utf8(file.with_values(&path, &values).unwrap().bytes).unwrap();
    let [mount, tip] = ["<body name=\"nail.mount\" pos=\"1 0 0\"", "<body name=\"tip\" pos=\"0 0 1\""];
    assert!(text.contains(mount) && text.contains(tip) && text.contains("</body>"), "{text}");
    place.write("odd.xml", &text);
    assert!(read_robot(&path).unwrap().robot.link("tip").is_some());
}

#[test]
fn numbers_without_a_place_in_the_file_are_told() {
    let place = Place::new();
    place.write("odd.xml", ODD);
    place.write("scene.xml", r#"<mujoco><include file="odd.xml"/></mujoco>"#);
    place.write(
        "framed.xml",
        ODD.replace("<body name=\"base\"", "<frame pos=\"0 0 .1\"><body name=\"base\"")
            .replace("  </worldbody>", "  </frame></worldbody>"),
    );
    for name in ["scene.xml", "framed.xml"] {
        let path = place.path(name);
        let file = read_robot(&path).unwrap();
        let mut values = file.robot.nominal();
        values[file.robot.quantity("yaw.offset").unwrap()] = Value::Number(0.01);
        let written = file.with_values(&path, &values).unwrap();
        assert_eq!(written.bytes, fs::read(&path).unwrap());
        assert!(written.left_out[0].contains("yaw.offset") && written.left_out.len() == 1, "{written:?}");
    }
    place.write(
        "still.xml",
        "<mujoco><worldbody><body name=\"rock\"><geom size=\".1\"/></body></worldbody></mujoco>",
    );
    place.write("broken.xml", ODD.replace("name=\"hand\"", "name=\"fore\""));
    place.fails(&["still.xml", "touches.csv"], &["still.xml", "no hinge"]);
    place.fails(&["broken.xml", "touches.csv"], &["broken.xml", "fore"]);
}

#[test]
fn an_mjcf_comes_back_with_its_encoders_put_right() {
    let place = Place::new();
    let path = repository("mjcf/bodies/two_arms.xml");
    let text = fs::read_to_string(&path).unwrap();
    place.write("two_arms.xml", &text);
    let robot = read_robot(&path).unwrap().robot;
    let babbled = Agent::from_mjcf(&path).unwrap().babble_as(&at_random(250)).unwrap();
    let embodied = babbled.embodied();
    let mut touches = point_touches(embodied.agent(), &embodied.truth().schema, &robot, babbled.touches());
    assert!(touches.len() > 200);
    let mut truth = robot.nominal();
    for (k, q) in robot.dofs.iter().filter_map(|dof| dof.quantities).enumerate() {
        truth[q.offset] = Value::Number(0.02 * k as f64 - 0.1);
    }
    misread(&robot, &truth, &mut touches);
    let all: Vec<_> = touches.iter().collect();
    place.write("touches.csv", calibration_table(&robot, &all, &[]));
    let arguments = ["two_arms.xml", "touches.csv", "--free", "*.offset"];
    let found = place.json(&[&arguments[..], &["--out", "made"]].concat());
    assert_eq!(found["calibrated"], true);
    let rms = |found: &serde_json::Value, when: &str| found[when]["rms"].as_f64().unwrap();
    assert!(rms(&found, "before") > 1e-2 && rms(&found, "after") < 1e-5, "{found}");
    let written = fs::read_to_string(place.path("made/two_arms.xml")).unwrap();
    for (before, after) in
        text.lines().zip(written.lines()).filter(|(before, _)| !before.contains("<joint name="))
    {
        assert_eq!(before, after);
    }
    place.write("two_arms.xml", &written);
    assert!(rms(&place.json(&arguments), "before") < 1e-5);
}
