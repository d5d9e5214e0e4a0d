//! Prior knowledge: read from a file, kept exactly or as nearly as it is known.

use std::path::Path;
use std::process::Command;

use crate::common::{babble, creature, max, two_arms};
use bodyschema::agent::Agent;
use bodyschema::creature::Creature;
use bodyschema::ground_truth::GroundTruth;
use bodyschema::learning::{Input, KnownJoint, Learner, PriorKnowledge, SecondOrder, Verdict};
use bodyschema::schema::SchemaStd;
use bodyschema::session::{read_known, read_schema, write_schema};
use nalgebra::Vector3;
use serde_json::{Value, json};

fn arms() -> bodyschema::creature::Body {
    creature(&two_arms(r#"type="capsule" size="0.12 0.2""#, r#"type="capsule" size="0.03 0.2""#))
}

/// What a file with this content is read as.
fn read(creature: &Creature, content: &str) -> Result<Vec<KnownJoint>, String> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("known.json");
    std::fs::write(&path, content).unwrap();
    read_known(&path, creature).map_err(|error| {
        let sentence = error.to_string();
        assert!(sentence.starts_with(&path.display().to_string()), "{sentence}");
        assert_eq!(sentence.lines().count(), 1, "{sentence}");
        sentence
    })
}

/// A whole joint of the two arms, as a user gives it.
fn shoulder() -> Value {
    json!({
        "joint": "left_shoulder", "position": [0.1, 0.2, 0.3],
        "axes": [{ "dof": "left_shoulder_a", "axis": [1, 0, 0] }, { "axis": [0, 0.6, 0.8] }],
    })
}

#[test]
fn joints_are_known_exactly_or_nearly_as_the_file_says() {
    let body = arms();
    let known = |entry: Value| read(&body.creature, &json!({ "joints": [entry] }).to_string()).unwrap();
    let (position, axes) = (Vector3::new(0.1, 0.2, 0.3), [Vector3::x(), Vector3::new(0.0, 0.6, 0.8)]);
    let exact = &known(shoulder())[0];
    assert_eq!((exact.joint, exact.exact), (0, true));
    assert_eq!(exact.position.unwrap()[0], position);
    assert_eq!(
        exact.axes.iter().map(|(k, axis, _)| (*k, *axis)).collect::<Vec<_>>(),
        [(0, axes[0]), (1, axes[1])]
    );
    // With deviations, of one number or three; null is not known at all.
    let mut near = shoulder();
    near["position_std"] = json!([0.001, 0.002, null]);
    near["axes"][0]["axis_std"] = json!(0.1);
    near["axes"][1]["axis_std"] = Value::Null;
    let found = &known(near.clone())[0];
    assert!(!found.exact);
    assert_eq!(found.position.unwrap()[1], Vector3::new(0.001, 0.002, f64::INFINITY));
    assert_eq!(found.axes, [(0, axes[0], 0.1)]);
    near["position_std"] = json!(0.01);
    near.as_object_mut().unwrap().remove("axes");
    assert_eq!(known(near)[0].position.unwrap()[1], Vector3::repeat(0.01));
    assert_eq!(read(&body.creature, r#"{"joints": []}"#).unwrap(), []);
}

#[test]
fn a_wrong_file_is_told_in_a_sentence_that_names_the_place_and_the_mend() {
    let body = arms();
    let refuse = |content: String| read(&body.creature, &content).unwrap_err();
    let entry = |change: &dyn Fn(&mut Value)| {
        let mut entry = shoulder();
        change(&mut entry);
        refuse(json!({ "joints": [entry] }).to_string())
    };
    let cases: [(String, &[&str]); 17] = [
        (refuse("{".into()), &["line 1", "ends in the middle"]),
        (refuse(r#"{"joints": 3}"#.into()), &["line 1", "object of known joints"]),
        (refuse(r#"{"format": "bodyschema touches", "joints": []}"#.into()), &["bodyschema schema"]),
        (refuse(r#"{"format": "bodyschema schema", "version": 9, "joints": []}"#.into()), &["newer version"]),
        (refuse(r#"{"creature": "max", "joints": []}"#.into()), &["\"max\"", "\"two arms\""]),
        (refuse(json!({ "joints": [shoulder(), shoulder()] }).to_string()), &["left_shoulder", "twice"]),
        (entry(&|e| e["joint"] = json!("knee")), &["\"knee\"", "joint 1", "inspect"]),
        (entry(&|e| e["parent"] = json!("left_upper")), &["left_upper", "trunk"]),
        (entry(&|e| e["position"] = json!([1, 2])), &["line 1"]),
        (entry(&|e| e["axes"] = json!([{ "axis": [1, 0, 0] }])), &["1 axes instead of 2"]),
        (entry(&|e| e["axes"][0]["dof"] = json!("elbow")), &["\"elbow\"", "left_shoulder_a"]),
        (entry(&|e| e["axes"][0]["axis"] = json!([0, 3, 4])), &["length 5", "[0, 0.6, 0.8]"]),
        (entry(&|e| e["axes"][0]["axis"] = json!([0, 0, 0])), &["length zero"]),
        (entry(&|e| e["position_std"] = json!(-0.1)), &["position_std of -0.1", "impossible"]),
        (entry(&|e| e["axes"][1]["axis_std"] = json!(-1)), &["axis_std of -1", "left_shoulder_b"]),
        (entry(&|e| e["position_std"] = json!(0.01)), &["uncertain", "above zero"]),
        (
            entry(&|e| {
                e.as_object_mut().unwrap().remove("axes");
            }),
            &["no axes", "deviations"],
        ),
    ];
    for (sentence, words) in cases {
        for word in words {
            assert!(sentence.contains(word), "no {word:?} in: {sentence}");
        }
    }
    let missing = read_known(Path::new("nowhere.json"), &body.creature).unwrap_err().to_string();
    assert!(missing.contains("nowhere.json") && missing.contains("that exists"), "{missing}");
}

#[test]
fn a_schema_file_keeps_its_deviations_and_is_a_file_of_known_joints() {
    let body = arms();
    let schema = GroundTruth::new(&body).unwrap().schema;
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("schema.json");
    let joints = schema.positions.len();
    let mut std = SchemaStd {
        positions: vec![[Some(1e-3), Some(2e-3), None]; joints],
        axes: vec![Some(0.01); schema.axes.len()],
    };
    std.axes[3] = None;
    write_schema(&path, &body.creature, &schema, Some(&std)).unwrap();
    assert_eq!(read_schema(&path, &body.creature).unwrap(), schema);
    let text: Value = serde_json::from_slice(&std::fs::read(&path).unwrap()).unwrap();
    assert_eq!(text["joints"][0]["position_std"], json!([0.001, 0.002, null]));
    assert_eq!(text["joints"][1]["axes"][0]["axis_std"], json!(0.01));
    assert!(text["joints"][1]["axes"][1]["axis_std"].is_null());
    let known = read_known(&path, &body.creature).unwrap();
    assert_eq!(known.len(), joints);
    assert!(known.iter().all(|known| !known.exact));
    assert_eq!((known[0].axes.len(), known[1].axes.len()), (2, 1));
    // Without deviations, as older versions wrote it: all of it exact.
    write_schema(&path, &body.creature, &schema, None).unwrap();
    assert!(read_known(&path, &body.creature).unwrap().iter().all(|known| known.exact));
    std.axes.pop();
    write_schema(&path, &body.creature, &schema, Some(&std)).unwrap_err();
}

#[test]
fn what_is_known_exactly_stays_and_helps_where_touches_are_too_few() {
    let body = max("torso");
    let (agent, truth) = (Agent::of(&body).unwrap(), GroundTruth::new(&body).unwrap());
    let touches = babble(&body, &agent, 150, 1, 2);
    let schema = &truth.schema;
    let exact = |joint: usize| KnownJoint {
        joint,
        exact: true,
        position: Some([schema.positions[joint], Vector3::zeros()]),
        axes: body.creature.joints()[joint].dof_indices().map(|k| (k, schema.axes[k], 0.0)).collect(),
    };
    let joints = body.creature.joints().len();
    for every in [1, 2] {
        let given: Vec<KnownJoint> = (0..joints).step_by(every).map(exact).collect();
        for input in [Input::Contact, Input::Receptor] {
            let known = PriorKnowledge::nothing(&agent).with(&given);
            let mut learner = SecondOrder::new(&agent, input, 1).with_known(known);
            touches.iter().for_each(|touch| learner.touch(&touch.felt(input)));
            let learned = learner.learn();
            assert_eq!(learned.verdict, Verdict::Converged, "every {every}, {input:?}");
            let std = learned.schema_std(&body.creature).unwrap();
            for known in &given {
                assert_eq!(learned.schema.positions[known.joint], schema.positions[known.joint]);
                assert_eq!(std.positions[known.joint], [Some(0.0); 3]);
                for (k, axis, _) in &known.axes {
                    assert_eq!((learned.schema.axes[*k], std.axes[*k]), (*axis, Some(0.0)));
                }
            }
            let off = |joint: usize| (learned.schema.positions[joint] - schema.positions[joint]).norm();
            assert!((0..joints).all(|joint| off(joint) < 1e-3), "every {every}, {input:?}");
        }
    }
}

#[test]
fn what_is_known_nearly_counts_as_much_as_its_deviation_says() {
    let body = arms();
    let agent = Agent::of(&body).unwrap();
    let schema = GroundTruth::new(&body).unwrap().schema;
    let touches = babble(&body, &agent, 40, 1, 2);
    let near = KnownJoint {
        joint: 0,
        exact: false,
        position: Some([schema.positions[0], Vector3::new(1e-4, 1e-4, f64::INFINITY)]),
        axes: vec![(0, schema.axes[0], 2e-3)],
    };
    let observe = |known: PriorKnowledge| {
        let mut learner = SecondOrder::new(&agent, Input::Contact, 1).with_known(known);
        touches.iter().for_each(|touch| learner.touch(&touch.felt(Input::Contact)));
        learner.observe(&schema).0
    };
    let nothing = PriorKnowledge::nothing(&agent);
    assert!(!nothing.is_given());
    let (without, with) = (observe(nothing.clone()), observe(nothing.with(&[near])));
    // Independent information adds up: a deviation falls below both.
    let [x, _, z] = with.position_std(0).map(Option::unwrap);
    let before = without.position_std(0).map(Option::unwrap);
    assert!(x < before[0].min(1e-4) && z <= before[2], "{x} {z} from {before:?}");
    assert!(with.axis_std(&body.creature, 0).unwrap() < 2e-3);
}

/// Runs the program in a folder; its exit code, standard output and standard error.
fn run(place: &Path, arguments: &[&str]) -> (Option<i32>, String, String) {
    let mut command = Command::new(env!("CARGO_BIN_EXE_bodyschema"));
    let output = command.args(arguments).current_dir(place).env("RUST_BACKTRACE", "0").output().unwrap();
    let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
    (output.status.code(), text(&output.stdout), text(&output.stderr))
}

#[test]
fn the_example_of_the_help_is_a_file_of_known_joints_of_max() {
    let (code, help, _) = run(Path::new("."), &["learn", "--help"]);
    assert_eq!(code, Some(0));
    let example = &help[help.find("{\"joints\"").expect("an example")..];
    let example = &example[..example.find("\n  ]}").unwrap() + "\n  ]}".len()];
    let known = read(&max("torso").creature, example).unwrap();
    assert_eq!(known.iter().map(|known| known.exact).collect::<Vec<_>>(), [true, false]);
}

#[test]
fn the_program_keeps_to_what_is_known_and_says_so() {
    let place = tempfile::tempdir().unwrap();
    let write = |name: &str, text: &str| std::fs::write(place.path().join(name), text).unwrap();
    write("arms.xml", &two_arms(r#"type="capsule" size="0.12 0.2""#, r#"type="capsule" size="0.03 0.2""#));
    write("wrong.json", r#"{"joints": [{"joint": "knee"}]}"#);
    let babble = ["babble", "arms.xml", "--touches", "60", "--input", "contact", "--out", "s", "--json"];
    let (code, _, message) = run(place.path(), &[&babble[..], &["--known", "wrong.json"]].concat());
    assert_eq!(code, Some(1), "{message}");
    assert!(message.contains("wrong.json") && message.contains("knee"), "{message}");
    assert!(!place.path().join("s").exists(), "a wrong file left a session");
    let schema = GroundTruth::new(&arms()).unwrap().schema;
    write_schema(&place.path().join("all.json"), &arms().creature, &schema, None).unwrap();
    let mut some: Value =
        serde_json::from_slice(&std::fs::read(place.path().join("all.json")).unwrap()).unwrap();
    some["joints"].as_array_mut().unwrap().truncate(1);
    write("some.json", &some.to_string());
    let (code, output, message) = run(place.path(), &[&babble[..], &["--known", "some.json"]].concat());
    assert_eq!(code, Some(0), "{message}");
    let found: Value = serde_json::from_str(&output).unwrap();
    let name = &some["joints"][0]["joint"];
    assert_eq!(found["known"], json!({ "file": "some.json", "joints": [{ "joint": name, "exact": true }] }));
    assert!(found["bound_mm"]["bound_rms"].as_f64().unwrap() > 0.0, "{output}");
    let file = |name: &str| -> Value {
        serde_json::from_slice(&std::fs::read(place.path().join("s").join(name)).unwrap()).unwrap()
    };
    let learned = &file("schema.json")["joints"][0];
    assert_eq!(learned["position"], some["joints"][0]["position"]);
    assert_eq!(learned["position_std"], json!([0.0, 0.0, 0.0]));
    assert_eq!(file("session.json")["options"]["known"], "some.json");
    let report = std::fs::read_to_string(place.path().join("s/report.html")).unwrap();
    assert!(
        report.contains("the touches fit to numerical precision") && report.contains("± x, mm"),
        "the report does not say how sure"
    );
    // All that is known and nothing to learn is no failure; a learner that cannot use it refuses.
    let (code, output, message) = run(place.path(), &["learn", "s", "--known", "all.json", "--json"]);
    assert_eq!(code, Some(0), "{message}");
    assert_eq!(serde_json::from_str::<Value>(&output).unwrap()["undetermined"], json!([]), "{output}");
    let hersch = ["learn", "s", "--known", "all.json", "--learner", "hersch"];
    let (code, _, message) = run(place.path(), &hersch);
    assert!(code == Some(1) && message.contains("--learner lm"), "{message}");
}
