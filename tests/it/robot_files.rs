//! Robots' files as people have them, read, and written back with other numbers: URDF and tables of Denavit and Hartenberg's
//! numbers. MJCF is compared with MuJoCo itself.

use std::f64::consts::PI;

use bodyschema::calibration::robot::{Knowledge, Posed, Robot, Value};
use bodyschema::geometry::Frame;
use bodyschema::session::{RobotFile, read_robot};
use nalgebra::{Matrix3, Rotation3, Vector3};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use crate::common::calibrating::Place;

/// How far links may be apart, metres and radians.
const ROUNDING: f64 = 1e-12;

/// An arm as its maker has it.
const ARM: &str = r#"<?xml version="1.0"?>
<!-- An arm, as its maker has it. -->
<robot name="arm">
  <link name="base"><collision><geometry><sphere   radius='0.05'/></geometry></collision></link>
  <link name="upper">
    <inertial><origin xyz="0 0 0.1"/><mass value="1.5"/></inertial>
    <collision><geometry><mesh filename="x.stl"/></geometry></collision>
    <collision><origin xyz="0 0 0.1" rpy="0 0 0.5"/><geometry><cylinder radius="0.03" length="0.2"/></geometry></collision>
    <collision><geometry><sphere radius="0.04"/></geometry></collision>
  </link>
  <joint name="shoulder" type="revolute">
    <!-- odd, but so it is -->
    <origin rpy="1.55 -0.3 3.12"   xyz="0.1 0 0.30"/>
    <parent link="base"/><child link="upper"/>
    <axis xyz="0 0 2"/><limit lower="-1.0" upper="2" effort="5"/>
  </joint>
  <link name="fore"/>
  <joint name="elbow" type="continuous">
    <parent link="upper"/> <child link="fore"/>
  </joint>
  <joint type="fixed" name="wrist"><origin xyz="0 0.2 0"/><parent link="fore"/><child link="hand"/></joint>
  <link name="hand"/>
  <joint name="finger" type="prismatic">
    <parent link="hand"/><child link="tip"/> <origin xyz="0 0 0.1" rpy="0 1.5707963267948966 0"/>
    <axis xyz="0.6 0 0.8"/> <limit lower="0" upper="0.04" effort="1" velocity="1"/>
  </joint>
  <joint name="thumb" type="prismatic">
    <parent link="hand"/><child link="other_tip"/>
    <axis xyz="0 -1 0"/> <mimic joint="finger" multiplier="-0.5"/>
  </joint>
  <link name="tip"/><link name="other_tip"/>
</robot>
"#;

/// A hand in millimetres, by the standard convention.
const CSV: &str = "# A hand, with millimetres.\r
joint, a_mm ,d,alpha [deg],theta_deg,kind,parent,min_deg,max_deg,max_mm\r
j1,0,0.30,90, 0,,,-170,170,\r
j2,\"250.5\",0,0,-90.0,hinge,,,,\r
slide,10,0.1,-90,5,slide,j2,,,300\r
flange,0,0.05,0,45,fixed,j1,,,\r
";
/// An arm by Craig's.
const CRAIG: &str = "joint,link,kind,a_mm,d,alpha,theta,beta,max,convention,parent,\"comment\"
j1,,,0,0.30,pi/2,,,,modified,,\"odd, but so it is\"
j2,fore,,250.5,0,-0.1,0.20,,,,,
slide,,prismatic,10,0.1,1,,0.05,0.3,,fore,
old,,,10,0.1,1,,0.1,,standard,base,
";

/// Reads a text as a robot's file.
fn file(text: &str) -> Result<RobotFile, String> {
    let place = Place::new();
    place.write("robot", text);
    read_robot(&place.path("robot"))
        .map_err(|error| error.to_string().replace(&place.path("robot").display().to_string(), "robot"))
}

fn robot(text: &str) -> Robot {
    file(text).unwrap().robot
}

/// The file with other values, and what it has no place for.
fn written(file: &RobotFile, values: &[Value]) -> (String, Vec<String>) {
    let written = file.with_values("robot".as_ref(), values).unwrap();
    (String::from_utf8(written.bytes).unwrap(), written.left_out)
}

/// The nominal values, but for these.
fn with(robot: &Robot, others: &[(&str, Value)]) -> Vec<Value> {
    let mut values = robot.nominal();
    for (name, value) in others {
        values[robot.quantity(name).unwrap_or_else(|| panic!("{name} is there"))] = *value;
    }
    values
}

fn turn(axis: usize, angle: f64) -> Frame {
    Frame { rotation: Rotation3::new(Vector3::ith(axis, angle)).into_inner(), origin: Vector3::zeros() }
}

fn shift(axis: usize, by: f64) -> Frame {
    at(Vector3::ith(axis, by))
}

fn at(origin: Vector3<f64>) -> Frame {
    Frame { rotation: Matrix3::identity(), origin }
}

/// Links of a robot are where they should be.
fn assert_at(robot: &Robot, posture: &[f64], expected: &[(&str, Frame)]) {
    let nominal = robot.nominal();
    let frames = Posed::new(robot, &nominal, &posture[..robot.coordinates()]).frames();
    for (name, frame) in expected {
        let found = &frames[robot.link(name).unwrap()];
        let apart = (found.rotation - frame.rotation).norm().max((found.origin - frame.origin).norm());
        assert!(apart < ROUNDING, "{name}: {apart}");
    }
}

/// All links of one robot at some values are where another's of the same name are at its own.
fn assert_same_links(robot: &Robot, values: &[Value], again: &Robot, seed: u64) {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    for _ in 0..20 {
        let posture: Vec<f64> = (0..robot.coordinates()).map(|_| rng.random_range(-2.0..2.0)).collect();
        let frames = Posed::new(robot, values, &posture).frames();
        let named = robot.links.iter().map(|link| link.name.as_str()).zip(frames);
        assert_at(again, &posture, &named.filter(|(name, _)| again.link(name).is_some()).collect::<Vec<_>>());
    }
}

#[test]
fn what_did_not_change_is_written_byte_for_byte() {
    let windows = ARM.replace('\n', "\r\n");
    for text in
        [ARM, &windows, &format!("\u{feff}{ARM}"), CSV, &format!("\u{feff}{CSV}"), CSV.trim_end(), CRAIG]
    {
        let file = file(text).unwrap();
        assert_eq!(written(&file, &file.robot.nominal()), (text.to_string(), Vec::new()));
    }
}

#[test]
fn links_are_where_urdf_has_them() {
    let RobotFile { robot, notes, .. } = file(ARM).unwrap();
    assert_eq!(robot.coordinates(), 3);
    let names: Vec<&str> = robot.dofs.iter().map(|dof| dof.name.as_str()).collect();
    assert_eq!(names, ["shoulder", "elbow", "finger", "thumb"]);
    assert_eq!((robot.dofs[0].range, robot.dofs[1].range), ([-1.0, 2.0], [-PI, PI]));
    let surfaces: Vec<&str> = robot.surfaces.iter().map(|surface| surface.name.as_str()).collect();
    assert_eq!(surfaces, ["base", "upper.1", "upper.2"]);
    assert!(robot.quantity("upper.2.radius").is_some());
    assert_eq!((robot.masses.len(), robot.masses[0].centre), (1, Vector3::new(0.0, 0.0, 0.1)));
    assert_eq!(notes.len(), 1, "{notes:?}");
    let [q, e, f] = [0.4, -1.1, 0.02];
    let upper = at(Vector3::new(0.1, 0.0, 0.3)) * turn(2, 3.12) * turn(1, -0.3) * turn(0, 1.55) * turn(2, q);
    let hand = upper * turn(0, e) * shift(1, 0.2);
    let tip = hand * shift(2, 0.1) * turn(1, 0.5 * PI) * at(Vector3::new(0.6 * f, 0.0, 0.8 * f));
    let expected = [("upper", upper), ("hand", hand), ("tip", tip), ("other_tip", hand * shift(1, 0.5 * f))];
    assert_at(&robot, &[q, e, f], &expected);
}

#[test]
fn links_are_where_the_conventions_have_them() {
    let standard = |theta: f64, d, a, alpha| turn(2, theta) * shift(2, d) * shift(0, a) * turn(0, alpha);
    let modified = |theta: f64, d, a, alpha| turn(0, alpha) * shift(0, a) * turn(2, theta) * shift(2, d);
    let degree = PI / 180.0;
    let [p, q, s, o] = [0.3, -0.7, 0.05, 1.1];
    let first = standard(p, 0.3, 0.0, 90.0 * degree);
    let second = first * standard(q - 90.0 * degree, 0.0, 0.2505, 0.0);
    let csv = [
        ("j1_link", first),
        ("j2_link", second),
        ("slide_link", second * standard(5.0 * degree, 0.1 + s, 0.01, -90.0 * degree)),
        ("flange_link", first * standard(45.0 * degree, 0.05, 0.0, 0.0)),
    ];
    let first = modified(p, 0.3, 0.0, 90.0 * degree);
    let second = first * modified(q + 0.2, 0.0, 0.2505, -0.1);
    let craig = [
        ("j1_link", first),
        ("fore", second),
        ("slide_link", second * turn(0, 1.0) * shift(0, 0.01) * turn(1, 0.05) * shift(2, 0.1 + s)),
        ("old_link", standard(o, 0.1, 0.01, 1.0) * turn(1, 0.1)),
    ];
    for (text, expected) in [(CSV, csv), (CRAIG, craig)] {
        let robot = robot(text);
        assert_at(&robot, &[p, q, s, o], &expected);
        assert!((robot.dofs[2].range[1] - 0.3).abs() < 1e-15);
        assert!(robot.quantity("j1.offset").is_none() && robot.quantity("slide.theta").is_some());
        assert_eq!(robot.quantity("j2.theta"), robot.dofs[1].quantities.map(|q| q.offset));
    }
    assert!((robot(CSV).dofs[0].range[1] - 170.0 * degree).abs() < 1e-15);
}

#[test]
fn only_the_numbers_that_changed_are_written() {
    let changes = [
        ("shoulder.position", Value::Position(Vector3::new(0.1, 0.002, 0.30))),
        ("base.radius", Value::Number(0.051)),
        ("elbow.position", Value::Position(Vector3::new(0.0, 0.001, 0.0))),
    ];
    let arm = file(ARM).unwrap();
    let expected = ARM
        .replace("0.1 0 0.30", "0.1 0.002 0.30")
        .replace("'0.05'", "'0.051'")
        .replace(r#""continuous">"#, "\"continuous\">\n    <origin xyz=\"0 0.001 0\"/>");
    assert_eq!(written(&arm, &with(&arm.robot, &changes)), (expected, Vec::new()));
    let table = file(CSV).unwrap();
    let changed = |name, value| written(&table, &with(&table.robot, &[(name, Value::Number(value))])).0;
    assert_eq!(changed("j2.a", 0.25075), CSV.replace("\"250.5\"", "\"250.75\""));
    let text = changed("j2.beta", 0.5);
    let lines: Vec<&str> = text.lines().collect();
    assert!(lines[1].ends_with("max_mm,beta") && lines[2].ends_with("170,,0") && lines[3].ends_with(",0.5"));
}

#[test]
fn a_calibrated_robot_reads_back_as_the_same() {
    let mut arm = file(ARM).unwrap();
    let hand = arm.robot.link("hand").unwrap();
    arm.robot.add_place("tool", hand, Vector3::new(0.0, 0.0, 0.3));
    arm.robot.set_knowledge("*", Knowledge::Near(0.1)).unwrap();
    let mut rng = ChaCha8Rng::seed_from_u64(1);
    for trial in 0..10 {
        let mut values = arm.robot.nominal();
        for (quantity, value) in arm.robot.quantities.iter().zip(&mut values) {
            let step: Vec<f64> = (0..3).map(|_| rng.random_range(-0.1..0.1)).collect();
            match quantity.name.rsplit('.').next().unwrap() {
                "gain" | "compliance" if quantity.name != "thumb.gain" => {}
                "radius" => *value = value.stepped(&[0.1 * step[0]]),
                "sign" => *value = Value::Number(if rng.random() { 1.0 } else { -1.0 }),
                _ => *value = value.stepped(&step[..value.size()]),
            }
        }
        let (text, left_out) = written(&arm, &values);
        assert_eq!(left_out, Vec::<String>::new());
        let again = robot(&text);
        assert!(again.link("tool").is_some() && again.link("hand.mount").is_some());
        assert_same_links(&arm.robot, &values, &again, trial);
        let turned = values[arm.robot.quantity("shoulder.sign").unwrap()].number() < 0.0;
        assert_eq!(again.dofs[0].range, if turned { [-2.0, 1.0] } else { [-1.0, 2.0] });
    }
    for text in [CSV, CRAIG] {
        let table = file(text).unwrap();
        let mut values = table.robot.nominal();
        for (quantity, value) in table.robot.quantities.iter().zip(&mut values) {
            if [".theta", ".d", ".a", ".alpha", ".beta"].iter().any(|end| quantity.name.ends_with(end)) {
                *value = value.stepped(&[rng.random_range(-0.1..0.1)]);
            }
        }
        let (text, left_out) = written(&table, &values);
        assert_eq!(left_out, Vec::<String>::new());
        assert_same_links(&table.robot, &values, &robot(&text), 3);
    }
}

#[test]
fn what_a_format_has_no_place_for_is_reported() {
    let assert_left_out = |file: &RobotFile, text: &str, others: &[(&str, Value)], begin: &[&str]| {
        let (same, left_out) = written(file, &with(&file.robot, others));
        assert_eq!(same, text);
        let all = left_out.iter().zip(begin).all(|(sentence, begin)| sentence.starts_with(begin));
        assert!(all && left_out.len() == begin.len(), "{left_out:?}");
    };
    let changes = [("elbow.gain", Value::Number(1.03)), ("finger.compliance", Value::Number(1e-4))];
    let begin = [
        "gain of elbow (1.030000) cannot be expressed in URDF: ",
        "compliance of finger (1.000e-4 m/N) cannot be expressed",
    ];
    assert_left_out(&file(ARM).unwrap(), ARM, &changes, &begin);
    let mut table = file(CSV).unwrap();
    table.robot.add_mount("tip", 1, Frame::identity());
    let changes = [
        ("j1.sign", Value::Number(-1.0)),
        ("j1.gain", Value::Number(1.01)),
        ("slide.compliance", Value::Number(1e-3)),
        ("j2.axis", Value::Direction(Vector3::new(0.0, 0.1, 1.0).normalize())),
        ("tip.position", Value::Position(Vector3::x())),
    ];
    let begin = ["sign of j1", "gain of j1", "axis of j2", "compliance of slide", "link tip on j1_link"];
    assert_left_out(&table, CSV, &changes, &begin);
}

#[test]
fn angles_are_read_as_books_print_them() {
    let read = |angle: &str| {
        file(&format!("joint,a,d,alpha\nj1,0,0,{angle}\n"))
            .map(|file| file.robot.nominal()[file.robot.quantity("j1.alpha").unwrap()].number())
    };
    for (text, expected) in [
        ("pi/2", PI / 2.0),
        ("-pi", -PI),
        ("2*pi/3", 2.0 * PI / 3.0),
        ("π", PI),
        ("−π/2", -PI / 2.0),
        ("+0.5 * np.pi", 0.5 * PI),
        ("-(math.pi / 4)", -PI / 4.0),
        ("3π/4", 0.75 * PI),
        ("-90°", -PI / 2.0),
        ("45 deg", PI / 4.0),
    ] {
        assert!((read(text).unwrap() - expected).abs() < 1e-15, "{text}");
    }
    for text in ["pie", "pi/", "*pi", "pi//2", "q1", "", "theta+pi", "1/2/x", "pi/0"] {
        assert!(read(text).unwrap_err().contains("not a finite number"), "{text}");
    }
}

#[test]
fn mistakes_in_urdf_get_a_sentence() {
    let altered = |from: &str, to: &str| {
        assert!(ARM.contains(from), "{from}");
        file(&ARM.replacen(from, to, 1)).unwrap_err()
    };
    let cases = [
        (altered("<link name=\"hand\"/>", "<xacro:hand/>"), "line 22: <xacro:hand> is Xacro, not URDF; "),
        (
            altered("0 0.2 0", "0 ${length} 0"),
            "line 21: \"${length}\" in xyz of <origin> is not a number; expand it",
        ),
        (altered("0 0.2 0", "0 0.2"), "line 21: xyz of <origin> has 2 numbers; give it 3"),
        (
            altered("0 0.2 0", "0,0.2,0"),
            "line 21: \"0,0.2,0\" in xyz of <origin> is not a number; use decimal points",
        ),
        (
            altered("rpy=\"1.55", "rpy=\"90"),
            "line 13: rpy=\"90 -0.3 3.12\" of joint shoulder is more than a turn: ",
        ),
        (altered("\"continuous\"", "\"hinge\""), "joint elbow has type \"hinge\"; "),
        (altered("\"continuous\"", "\"floating\""), "joint elbow is floating, which has no encoder; "),
        (
            altered("parent link=\"hand\"", "parent link=\"palm\""),
            "joint finger names the link palm, which does not exist",
        ),
        (altered("parent link=\"base\"", "parent link=\"hand\""), "link upper is its own parent; "),
        (altered("joint=\"finger\"", "joint=\"thumb\""), "joint thumb mimics itself"),
        (altered("name=\"elbow\"", "name=\"wrist\""), "line 21: two joints are called wrist; "),
        (altered("0.6 0 0.8", "0 0 0"), "the axis of joint finger has no direction"),
        (altered("'0.05'", "'0'"), "line 4: <sphere> of link base needs radius=\"…\" above 0; "),
    ];
    for (message, expected) in cases {
        assert!(message.contains(expected) && message.contains([':', ';']), "{message} != {expected}");
    }
}

#[test]
fn mistakes_in_tables_get_a_sentence() {
    let altered = |from: &str, to: &str| {
        let text = if CSV.contains(from) { CSV } else { CRAIG };
        assert!(text.contains(from), "{from}");
        file(&text.replacen(from, to, 1)).unwrap_err()
    };
    let cases = [
        (altered("alpha [deg]", "comment"), "robot, line 2: column alpha is missing: "),
        (
            altered("alpha [deg]", "alpha"),
            "robot, line 3: alpha of joint j1 is 90 radians: call it alpha_deg",
        ),
        (altered("a_mm", "a"), "robot, line 4: a of joint j2 is 250.5 metres: call it a_mm"),
        (altered("min_deg", "min"), "robot, line 3: min of joint j1 is -170 radians: call it min_deg"),
        (altered("slide,10", "slide,q2"), "line 5: a of joint slide is \"q2\", not a finite number: "),
        (altered("5,slide", "5,screw"), "line 5: joint slide has kind \"screw\": give hinge, slide or fixed"),
        (
            altered("slide,j2", "slide,j9"),
            "line 5: the parent of joint slide, j9, is neither a joint nor a link of an earlier row: ",
        ),
        (
            altered("slide,j2,,,300", "slide,j2,,90,"),
            "max of joint slide, which shifts, has the wrong unit: ",
        ),
        (altered(",,,,\r\nslide", ",,\r\nslide"), "line 4: it has 8 cells instead of 10: "),
        (altered("fixed,j1", "fixed,base,,,\r\nj1,0,0,0,0,,"), "two joints are called j1: rename one"),
        (file("joint;a;d").unwrap_err(), "line 1: its columns are not separated by commas: "),
        (file("joint,a,d,alpha\n").unwrap_err(), "line 1: it has no joints: "),
        (altered("modified", "paul"), "line 2: unknown convention \"paul\": give standard or modified"),
        (altered("0.05,0.3,", "0.05,-9,"), "the range of joint slide is empty"),
        (altered("theta_deg", "theta_mm"), "column \"theta_mm\": theta is an angle: give it in rad or deg"),
        (altered("d,alpha [deg]", "d [inch],alpha [deg]"), "unknown unit inch: "),
        (altered("\"comment\"", "weight"), "column \"weight\" is none of joint, parent, "),
    ];
    for (message, expected) in cases {
        assert!(message.contains(expected), "{message} != {expected}");
    }
}
