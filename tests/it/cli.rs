//! The command line as a user meets it: what it prints and where, its exit codes, and one clear sentence
//! for everything that can be wrong.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};
use std::time::Duration;

use crate::common::{repository, two_arms};
use serde_json::Value;
use tempfile::TempDir;

/// What `babble` and `learn` say at least (the issue's list).
const LEARNING_KEYS: [&str; 15] = [
    "touches",
    "motions",
    "limb_pairs",
    "babbling_s",
    "learning_s",
    "learner",
    "input",
    "converged",
    "initial_guesses",
    "heldout_mm",
    "hand_mm",
    "axis_deg",
    "undetermined",
    "session",
    "dof",
];
/// What `inspect` says at least.
const INSPECT_KEYS: [&str; 8] =
    ["joints", "dof", "torso_joints", "torso_dof", "limbs", "receptors", "receptors_by_limb", "aura_limbs"];

/// A folder of its own with a small creature in it, in which commands run.
struct Place(TempDir);

impl Place {
    fn new() -> Place {
        let place = Place(tempfile::tempdir().unwrap());
        place.write("arms.xml", &arms());
        place
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    fn write(&self, name: &str, text: &str) {
        fs::write(self.path(name), text).unwrap();
    }

    fn command(&self, arguments: &[&str]) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_bodyschema"));
        command.args(arguments).current_dir(self.0.path()).env("RUST_BACKTRACE", "0");
        command
    }

    fn run(&self, arguments: &[&str]) -> Output {
        self.command(arguments).output().unwrap()
    }

    /// Runs what must fail with exit code 1 and one sentence, which it returns.
    fn fails(&self, arguments: &[&str]) -> String {
        let output = self.run(arguments);
        let message = text(&output.stderr);
        assert_eq!(output.status.code(), Some(1), "{arguments:?}: {message}");
        assert!(output.stdout.is_empty(), "{arguments:?} prints {}", text(&output.stdout));
        // A skin that grew is told of before anything can go wrong.
        let message: String = message.lines().filter(|line| !line.ends_with("in memory")).collect();
        assert!(message.starts_with("bodyschema: "), "{arguments:?}: {message}");
        assert_eq!(message.matches("bodyschema: ").count(), 1, "{arguments:?}: {message}");
        assert!(!message.contains("panicked"), "{arguments:?}: {message}");
        message
    }

    /// Runs what must be refused as wrong usage, exit code 2.
    fn misused(&self, arguments: &[&str]) -> String {
        let output = self.run(arguments);
        let message = text(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{arguments:?}: {message}");
        assert!(output.stdout.is_empty(), "{arguments:?} prints {}", text(&output.stdout));
        assert!(message.starts_with("error: ") && !message.contains("panicked"), "{arguments:?}: {message}");
        message
    }

    /// Runs what must succeed; standard output and standard error.
    fn succeeds(&self, arguments: &[&str]) -> (String, String) {
        let output = self.run(arguments);
        let (out, message) = (text(&output.stdout), text(&output.stderr));
        assert_eq!(output.status.code(), Some(0), "{arguments:?}: {message}");
        assert!(!message.contains("panicked"), "{arguments:?}: {message}");
        (out, message)
    }

    /// The one JSON object of a command.
    fn json(&self, arguments: &[&str]) -> Value {
        let (out, _) = self.succeeds(arguments);
        let value: Value = serde_json::from_str(&out).unwrap_or_else(|error| panic!("{error}: {out}"));
        assert!(value.is_object(), "{out}");
        value
    }

    /// A session of the small creature in the folder `name`.
    fn session(&self, name: &str, touches: &str) {
        self.succeeds(&["babble", "arms.xml", "--touches", touches, "--learner", "hersch", "--out", name]);
    }
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

fn arms() -> String {
    two_arms(r#"type="capsule" size="0.12 0.2""#, r#"type="capsule" size="0.03 0.2""#)
}

fn has(message: &str, words: &[&str]) {
    for word in words {
        assert!(message.contains(word), "no \"{word}\" in: {message}");
    }
}

fn has_keys(object: &Value, keys: &[&str]) {
    for key in keys {
        assert!(object.get(key).is_some(), "no \"{key}\" in: {object}");
    }
}

/// All that can be wrong with a model's file, with words that the message must hold.
fn wrong_models() -> Vec<(&'static str, Option<String>, Vec<&'static str>)> {
    let no_touch = r#"<mujoco><compiler angle="radian" autolimits="true"/><worldbody><body name="a">
        <geom type="capsule" size="0.02 0.05"/>
        <body name="b" pos="0 0 1"><joint name="j" axis="1 0 0" range="-0.1 0.1"/>
          <geom type="capsule" size="0.02 0.05"/><site name="r" size="0.02"/>
          <body name="c" pos="0 0 1"><joint name="k" axis="0 1 0" range="-0.1 0.1"/>
            <geom type="capsule" size="0.02 0.05"/><site name="s" size="0.02"/></body></body></body></worldbody>
        <sensor><touch site="r"/><touch site="s"/></sensor></mujoco>"#;
    vec![
        ("missing.xml", None, vec!["no such file"]),
        ("broken.xml", Some("<mujoco>\n<worldbody>\n<body>\n</worldbody></mujoco>".into()), vec!["line"]),
        ("empty.xml", Some(String::new()), vec!["no XML"]),
        ("text.xml", Some("this is no XML".into()), vec![]),
        ("other.xml", Some("<svg/>".into()), vec![]),
        (
            "unknown.xml",
            Some("<mujoco><worldbody>\n<geom sise='1'/>\n</worldbody></mujoco>".into()),
            vec!["sise", "line 2"],
        ),
        (
            "stiff.xml",
            Some("<mujoco><worldbody><body><geom size='1'/></body></worldbody></mujoco>".into()),
            vec!["joint"],
        ),
        (
            "stone.xml",
            Some("<mujoco><worldbody><body><freejoint/><geom size='1'/></body></worldbody></mujoco>".into()),
            vec!["joint"],
        ),
        ("untouchable.xml", Some(no_touch.into()), vec!["no touch in", "motions"]),
        (
            "apart.xml",
            Some(
                "<mujoco><worldbody><body><geom size='1'/><site name='s'/><body pos='3 0 0'><joint name='only'/>\
                 <geom size='1'/></body></body></worldbody><sensor><touch site='s'/></sensor></mujoco>"
                    .into(),
            ),
            vec!["no two of its limbs", "only"],
        ),
        ("deep.xml", Some("<body>".repeat(2000)), vec!["more than 1000 deep", "line 1"]),
        ("hostile.xml", Some(arms().replacen("0.12 0.2", "1e30 0.2", 1)), vec!["line 5", "1e30"]),
    ]
}

#[test]
fn a_wrong_model_gets_one_sentence_that_names_the_file() {
    let place = Place::new();
    for (name, content, words) in wrong_models() {
        content.iter().for_each(|text| place.write(name, text));
        let message = place.fails(&["babble", name, "--touches", "20", "--out", "session"]);
        has(&message, &[name]);
        has(&message, &words);
        assert!(!place.path("session/touches.jsonl").exists() || name == "untouchable.xml", "{name}");
        assert!(
            fs::read_dir(place.0.path())
                .unwrap()
                .all(|e| { !e.unwrap().file_name().to_string_lossy().to_lowercase().ends_with(".txt") })
        );
        if place.path("session").exists() {
            fs::remove_dir_all(place.path("session")).unwrap();
        }
    }
    place.fails(&["babble", ".", "--touches", "20"]);
}

#[test]
fn commands_that_read_a_model_refuse_a_wrong_one_alike() {
    let place = Place::new();
    for (name, content, words) in wrong_models().into_iter().take(8) {
        content.iter().for_each(|text| place.write(name, text));
        for command in ["inspect", "skin"] {
            let message = place.fails(&[command, name]);
            has(&message, &[name]);
            if command == "inspect" {
                has(&message, &words);
            }
        }
    }
}

#[test]
fn wrong_usage_is_exit_code_2() {
    let place = Place::new();
    let message = place.misused(&["babble", "arms.xml", "--touches", "0"]);
    has(&message, &["--touches", "at least 1"]);
    for wrong in [
        &["babble", "arms.xml", "--frobnicate"][..],
        &["babble", "arms.xml", "--touches", "-1"],
        &["babble", "arms.xml", "--touches", "1e3"],
        &["babble", "arms.xml", "--touches", "99999999999999999999999"],
        &["babble", "arms.xml", "--seed", "-1"],
        &["babble", "arms.xml", "--jobs", "0"],
        &["babble", "arms.xml", "--jobs", "100000"],
        &["babble", "arms.xml", "--learner", "magic"],
        &["babble", "arms.xml", "--input", "telepathy"],
        &["learn"],
        &["learn", "session", "--touches", "0"],
        &["skin", "arms.xml", "--spacing", "0"],
        &["skin", "arms.xml", "--spacing", "nan"],
        &["skin", "arms.xml", "--spacing", "inf"],
        &["dance"],
    ] {
        place.misused(wrong);
    }
    assert!(!place.path("sessions").exists(), "wrong usage left a session");
}

#[test]
fn joints_that_do_not_exist_are_named_with_what_there_is() {
    let place = Place::new();
    let message = place.fails(&["babble", "arms.xml", "--joints", "left_elbow,antenna", "--touches", "5"]);
    has(&message, &["arms.xml", "antenna", "all"]);
    let max = repository("mjcf/max/max.xml");
    let message = place.fails(&["babble", max.to_str().unwrap(), "--joints", "wings", "--touches", "5"]);
    has(&message, &["max.xml", "wings", "torso"]);
    place.fails(&["babble", "arms.xml", "--joints", "", "--touches", "5"]);
}

#[test]
fn an_output_folder_that_cannot_be_made_is_named() {
    let place = Place::new();
    place.write("file", "in the way");
    for out in ["file", "file/session", "file/a/b"] {
        let message = place.fails(&["babble", "arms.xml", "--touches", "5", "--out", out]);
        has(&message, &["file", "--out"]);
    }
    assert_eq!(fs::read_to_string(place.path("file")).unwrap(), "in the way");
    fs::create_dir_all(place.path("blocked/touches.jsonl")).unwrap();
    let message = place.fails(&["babble", "arms.xml", "--touches", "5", "--out", "blocked"]);
    has(&message, &["touches.jsonl"]);
}

#[test]
fn a_session_that_exists_is_never_overwritten() {
    let place = Place::new();
    place.session("taken", "20");
    let before = fs::read(place.path("taken/touches.jsonl")).unwrap();
    let message = place.fails(&["babble", "arms.xml", "--touches", "5", "--out", "taken"]);
    has(&message, &["taken", "already", "--out", "--force"]);
    assert_eq!(fs::read(place.path("taken/touches.jsonl")).unwrap(), before);
    for number in 1..=2 {
        let hersch = ["babble", "arms.xml", "--touches", "5", "--learner", "hersch", "--json"];
        let session = place.json(&hersch)["session"].as_str().unwrap().to_string();
        assert!(session.ends_with(&format!("-{number}")), "{session}");
    }
}

#[test]
fn babble_prints_one_json_object_with_all_that_the_issue_asks_for() {
    let place = Place::new();
    let found = place.json(&[
        "babble",
        "arms.xml",
        "--touches",
        "120",
        "--policy",
        "random",
        "--input",
        "contact",
        "--json",
    ]);
    has_keys(&found, &LEARNING_KEYS);
    assert_eq!((&found["touches"], &found["input"]), (&Value::from(120), &Value::from("contact")));
    assert_eq!(found["converged"], Value::Bool(true), "{found}");
    has_keys(&found["heldout_mm"], &["mean", "median", "p95", "max"]);
    has_keys(&found["axis_deg"], &["median", "max"]);
    assert!(found["heldout_mm"]["mean"].as_f64().unwrap() < 0.1, "{found}");
    assert!(found["motions"].as_u64().unwrap() >= 120);
    let folder = place.path(found["session"].as_str().unwrap());
    for file in ["session.json", "touches.jsonl", "schema.json", "learning.csv", "learned.xml"] {
        assert!(folder.join(file).is_file(), "{file}");
    }
    let log = fs::read_to_string(folder.join("touches.jsonl")).unwrap();
    assert_eq!(log.lines().count(), 121);
}

#[test]
fn learn_prints_one_json_object_and_uses_the_first_touches_asked_for() {
    let place = Place::new();
    place.session("session", "150");
    let found = place.json(&["learn", "session", "--json", "--input", "contact"]);
    has_keys(&found, &LEARNING_KEYS);
    assert_eq!(found["touches"], 150);
    let found = place.json(&["learn", "session", "--touches", "40", "--learner", "hersch", "--json"]);
    assert_eq!((&found["touches"], &found["learner"]), (&Value::from(40), &Value::from("hersch")));
    let found = place.json(&["learn", "session", "--touches", "99999", "--learner", "hersch", "--json"]);
    assert_eq!(found["touches"], 150);
    let found = place.json(&["report", "session", "--json"]);
    has_keys(&found, &["heldout_mm", "axis_deg", "touch_mm"]);
}

#[test]
fn inspect_prints_one_json_object_and_knows_max() {
    let place = Place::new();
    let max = repository("mjcf/max/max.xml");
    let found = place.json(&["inspect", max.to_str().unwrap(), "--json"]);
    has_keys(&found, &INSPECT_KEYS);
    let numbers = ["joints", "dof", "torso_joints", "torso_dof", "aura_limbs"].map(|key| &found[key]);
    assert_eq!(numbers.map(|n| n.as_u64().unwrap()), [57, 103, 16, 42, 17]);
    let by_limb = found["receptors_by_limb"].as_object().unwrap();
    let sum: u64 = by_limb.values().map(|n| n.as_u64().unwrap()).sum();
    assert_eq!(sum, found["receptors"].as_u64().unwrap());
    assert!(by_limb["left_hand"].as_u64().unwrap() > 30);
    let (text, _) = place.succeeds(&["inspect", max.to_str().unwrap()]);
    has(&text, &["57 joints", "103 degrees of freedom", "left_hand", "neighbours on average", "cross limbs"]);
    // His auras, and the neighbours of every receptor, which are mutual.
    let auras = found["auras"].as_array().unwrap();
    assert_eq!(auras.len(), 17);
    for aura in auras {
        assert_eq!(aura["of_model"], true, "{aura}");
        assert!((aura["reach"].as_f64().unwrap() - 0.35).abs() < 1e-4, "{aura}");
    }
    let neighbours = found["neighbours"].as_object().unwrap();
    assert_eq!(neighbours.len() as u64, found["receptors"].as_u64().unwrap());
    let links: usize = neighbours.values().map(|of| of.as_array().unwrap().len()).sum();
    let mean = found["neighbours_mean"].as_f64().unwrap();
    assert!((mean - links as f64 / neighbours.len() as f64).abs() < 1e-9 && mean > 3.0, "{mean}");
    for (id, of) in neighbours {
        for other in of.as_array().unwrap() {
            assert!(
                neighbours[other.as_str().unwrap()].as_array().unwrap().contains(&id.as_str().into()),
                "{id}"
            );
        }
    }
    let alone = neighbours.values().filter(|of| of.as_array().unwrap().is_empty()).count();
    assert_eq!(found["neighbours_none"].as_array().unwrap().len(), alone);
}

#[test]
fn the_results_for_people_go_to_standard_output_and_hold_no_control_characters() {
    let place = Place::new();
    let arguments = ["babble", "arms.xml", "--touches", "60", "--learner", "hersch", "--out", "s"];
    let (out, message) = place.succeeds(&arguments);
    has(&out, &["60 touches", "session: s"]);
    assert!(!out.contains('\u{1b}') && !message.contains('\u{1b}'), "{out}{message}");
    let (out, _) = place.succeeds(&["report", "s"]);
    has(&out, &["mean", "median"]);
}

#[test]
fn the_same_seed_gives_the_same_log_byte_for_byte_with_one_job_and_with_four() {
    let place = Place::new();
    let max = repository("mjcf/max/max.xml");
    for (model, touches) in [("arms.xml", "300"), (max.to_str().unwrap(), "60")] {
        let log = |name: &str, jobs: &str, seed: &str| {
            let learner = ["--learner", "hersch", "--out", name, "--jobs", jobs, "--seed", seed];
            place.succeeds(&[&["babble", model, "--touches", touches], &learner[..]].concat());
            let log = fs::read(place.path(name).join("touches.jsonl")).unwrap();
            fs::remove_dir_all(place.path(name)).unwrap();
            log
        };
        let one = log("one", "1", "7");
        assert!(one == log("four", "4", "7"), "{model}");
        assert!(one == log("many", "64", "7"), "{model}");
        assert!(one != log("other", "1", "8"), "{model}");
    }
}

#[test]
fn the_log_alone_is_enough_to_learn_when_the_model_is_gone() {
    let place = Place::new();
    place.session("session", "120");
    fs::remove_file(place.path("arms.xml")).unwrap();
    let output = place.run(&["learn", "session", "--input", "contact", "--json"]);
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    let found: Value = serde_json::from_slice(&output.stdout).unwrap();
    has_keys(&found, &LEARNING_KEYS);
    assert_eq!(found["converged"], Value::Bool(true));
    assert_eq!(found["heldout_mm"], Value::Null, "there is nothing to measure against");
    has(&text(&output.stderr), &["not measured", "arms.xml"]);
    place.succeeds(&["learn", "session", "--learner", "hersch"]);
    has(&place.succeeds(&["report", "session"]).1, &["not measured", "arms.xml"]);
    has(&place.fails(&["learn", "session", "--model", "gone.xml"]), &["gone.xml"]);
    place.write("moved.xml", &arms());
    let found = place.json(&["learn", "session", "--model", "moved.xml", "--learner", "hersch", "--json"]);
    assert!(found["heldout_mm"]["mean"].is_number());
}

#[test]
fn a_model_that_changed_since_is_not_measured_against() {
    let place = Place::new();
    place.session("session", "60");
    place.write("arms.xml", &arms().replace("range=\"-2.4 2.4\"", "range=\"-2.3 2.4\""));
    has(&place.succeeds(&["report", "session"]).1, &["not measured", "arms.xml", "--model"]);
    // Only where the joints are has changed: nothing that the agent is given.
    place.write("arms.xml", &arms().replace("pos=\"0.3 0 0\"", "pos=\"0.31 0 0\""));
    has(&place.succeeds(&["report", "session"]).1, &["not measured", "arms.xml", "--model"]);
    place.write("arms.xml", &arms());
    has(&place.succeeds(&["report", "session"]).0, &["angle between axes"]);
}

#[test]
fn a_truncated_log_loses_the_last_touch_alone() {
    let place = Place::new();
    place.session("session", "50");
    let log = place.path("session/touches.jsonl");
    let whole = fs::read(&log).unwrap();
    fs::write(&log, &whole[..whole.len() - 40]).unwrap();
    let output = place.run(&["learn", "session", "--learner", "hersch", "--json"]);
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    assert_eq!(serde_json::from_slice::<Value>(&output.stdout).unwrap()["touches"], 49);
    has(&text(&output.stderr), &["line 51", "ignored"]);
    has(&place.succeeds(&["report", "session"]).0, &["angle between axes"]);
}

#[test]
fn a_log_with_anything_wrong_in_it_is_refused_with_its_line() {
    let place = Place::new();
    place.session("session", "20");
    let log = place.path("session/touches.jsonl");
    let whole = fs::read_to_string(&log).unwrap();
    let lines: Vec<&str> = whole.lines().collect();
    let with = |line: usize, new: &str| {
        let mut lines = lines.clone();
        lines[line - 1] = new;
        lines.join("\n") + "\n"
    };
    let first_number = |new: &str| {
        let line = lines[4];
        let start = line.find("\"posture\":[").unwrap() + "\"posture\":[".len();
        let end = start + line[start..].find(',').unwrap();
        format!("{}{new}{}", &line[..start], &line[end..])
    };
    let nonsense = [
        (with(7, "nonsense"), "line 7"),
        (with(7, ""), "line 7"),
        (with(7, "{}"), "line 7"),
        (with(5, &first_number("NaN")), "line 5"),
        (with(5, &first_number("null")), "line 5"),
        (with(5, &first_number("1e999")), "line 5"),
        (with(5, &first_number("\"x\"")), "line 5"),
        (with(1, "{\"format\":\"bodyschema touches\",\"version\":99}"), "newer"),
        (with(1, "{\"format\":\"shopping list\",\"version\":1}"), "shopping list"),
        (with(1, "time,posture"), "line 1"),
        (with(1, &lines[0].replace("two arms", "octopus")), "octopus"),
        (String::new(), "header"),
        ("\u{0}\u{1}\u{2}".repeat(100), "line 1"),
    ];
    for (content, word) in nonsense {
        fs::write(&log, &content).unwrap();
        for command in ["learn", "report"] {
            has(&place.fails(&[command, "session"]), &["touches.jsonl", word]);
        }
    }
}

#[test]
fn postures_beyond_all_ranges_in_a_log_do_not_crash_a_learner() {
    let place = Place::new();
    place.session("session", "60");
    let log = place.path("session/touches.jsonl");
    let whole = fs::read_to_string(&log).unwrap();
    for huge in ["1e300", "-1e18", "1e-320"] {
        let mut lines: Vec<String> = whole.lines().map(str::to_string).collect();
        for line in lines.iter_mut().skip(1) {
            let start = line.find("\"posture\":[").unwrap() + "\"posture\":[".len();
            let end = start + line[start..].find(',').unwrap();
            line.replace_range(start..end, huge);
        }
        fs::write(&log, lines.join("\n") + "\n").unwrap();
        for learner in ["lm", "hersch"] {
            let output = place.run(&["learn", "session", "--learner", learner]);
            let message = text(&output.stderr);
            assert!(matches!(output.status.code(), Some(0 | 1)), "{huge}, {learner}: {message}");
            assert!(!message.contains("panicked"), "{huge}, {learner}: {message}");
        }
    }
}

#[test]
fn a_foreign_or_empty_session_is_refused_by_name() {
    let place = Place::new();
    place.session("session", "20");
    has(&place.fails(&["learn", "nowhere"]), &["nowhere"]);
    has(&place.fails(&["report", "nowhere"]), &["nowhere"]);
    fs::create_dir(place.path("empty")).unwrap();
    has(&place.fails(&["learn", "empty"]), &["empty: it is not a session folder", "babble"]);
    has(&place.fails(&["babble", "session"]), &["it is a session folder, not a model", "arms.xml"]);
    has(&place.fails(&["babble"]), &["mjcf/max/max.xml", "give a model"]);

    // Another creature's log in this session's folder.
    let max = repository("mjcf/max/max.xml");
    let arguments =
        ["babble", max.to_str().unwrap(), "--touches", "3", "--learner", "hersch", "--out", "max"];
    place.succeeds(&arguments);
    fs::copy(place.path("max/touches.jsonl"), place.path("session/touches.jsonl")).unwrap();
    has(&place.fails(&["learn", "session"]), &["touches.jsonl", "max", "two arms"]);

    // A session that was stopped before its first touch.
    let header = fs::read_to_string(place.path("max/touches.jsonl")).unwrap();
    place.write("max/touches.jsonl", &(header.lines().next().unwrap().to_string() + "\n"));
    has(&place.fails(&["learn", "max"]), &["no touch", "babble"]);

    fs::remove_file(place.path("max/touches.jsonl")).unwrap();
    has(&place.fails(&["learn", "max"]), &["touches.jsonl"]);
    for nonsense in ["", "{}", "[]", "null", "{\"format\":\"bodyschema session\",\"version\":1}", "\u{0}"] {
        place.write("max/session.json", nonsense);
        has(&place.fails(&["learn", "max"]), &["session.json"]);
    }
}

#[test]
fn motions_with_physics_are_told_from_those_without() {
    let place = Place::new();
    let run = |motion: &str, out: &str| {
        let arguments = ["babble", "arms.xml", "--touches", "5", "--motion", motion, "--out", out, "--json"];
        let told: serde_json::Value =
            serde_json::from_slice(&place.run(&[&arguments[..], &["--learner", "hersch"]].concat()).stdout)
                .unwrap();
        assert_eq!(told["motion"], motion);
        let read = |file: &str| fs::read_to_string(place.path(&format!("{out}/{file}"))).unwrap();
        (told, read("session.json").contains("dynamic"), read("touches.jsonl").matches("\"force\":").count())
    };
    let (told, named, forces) = run("dynamic", "dynamic");
    assert!(
        told["depth_mm"]["median"].as_f64().unwrap() < 0.1 && told["simulated_s"].as_f64().unwrap() > 0.0
    );
    assert!(named && forces == 5);
    let (told, named, forces) = run("kinematic", "kinematic");
    assert!(told["depth_mm"].is_null() && told["simulated_s"].is_null() && !named && forces == 0);
}

#[test]
fn reporting_a_session_without_a_schema_says_so() {
    let place = Place::new();
    place.session("session", "20");
    fs::remove_file(place.path("session/schema.json")).unwrap();
    has(&place.fails(&["report", "session"]), &["session: ", "babble --resume session", "learn session"]);
    place.write("session/schema.json", "{\"format\":\"bodyschema schema\",\"version\":1}");
    has(&place.fails(&["report", "session"]), &["schema.json"]);
}

#[test]
fn babbling_that_is_killed_half_way_leaves_a_session_to_learn_from() {
    let place = Place::new();
    // At random, for what is learned in stages is soon learned to the end.
    let arguments = "babble arms.xml --policy random --touches 2000000 --jobs 1 --out session".split(' ');
    let arguments: Vec<&str> = arguments.collect();
    let mut child = place.command(&arguments).stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap();
    let log = place.path("session/touches.jsonl");
    for _ in 0..200 {
        std::thread::sleep(Duration::from_millis(20));
        if fs::metadata(&log).is_ok_and(|about| about.len() > 50_000) {
            break;
        }
    }
    child.kill().unwrap();
    child.wait().unwrap();
    let written = fs::read(&log).unwrap();
    let complete = written.iter().filter(|&&byte| byte == b'\n').count() - 1;
    assert!(complete > 0, "killed too early");
    let output = place.run(&["learn", "session", "--learner", "hersch", "--json"]);
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    let found: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(found["touches"], complete);
    assert_eq!(found["motions"], Value::Null, "what it cost was never written");
}

/// The examples in a help text: lines that begin with the program's name, without their remarks.
fn examples(help: &str) -> Vec<Vec<String>> {
    let lines = help.lines().map(str::trim).filter_map(|line| line.strip_prefix("bodyschema "));
    let command = |line: &str| line.split(" #").next().unwrap_or(line).to_string();
    lines.map(|line| command(line).split_whitespace().map(str::to_string).collect()).collect()
}

#[test]
fn every_example_of_the_help_parses() {
    let place = Place::new();
    let (main, _) = place.succeeds(&["--help"]);
    let mut all = examples(&main);
    assert!(all.len() >= 5, "{main}");
    for command in ["babble", "learn", "report", "inspect", "skin"] {
        has(&main, &[command]);
        let (help, _) = place.succeeds(&[command, "--help"]);
        let found = examples(&help);
        let own = found.iter().filter(|example| example[0] == command).count();
        assert!(own >= 1, "{command} shows no example of itself");
        all.extend(found);
    }
    for example in all {
        let mut arguments: Vec<&str> = example.iter().map(String::as_str).collect();
        arguments.push("--help");
        place.succeeds(&arguments);
        // `--help` forgives what is missing; without it only the files may be.
        let output = place.run(&arguments[..arguments.len() - 1]);
        assert_eq!(output.status.code(), Some(1), "{example:?}: {}", text(&output.stderr));
        has(&text(&output.stderr), &["bodyschema: "]);
    }
}

#[test]
fn versions_are_told() {
    let (out, _) = Place::new().succeeds(&["--version"]);
    has(&out, &["bodyschema", env!("CARGO_PKG_VERSION")]);
}

#[test]
fn a_closed_pipe_is_no_panic() {
    let place = Place::new();
    let max = repository("mjcf/max/max.xml");
    for arguments in [&["inspect", max.to_str().unwrap()][..], &["skin", "bare.xml"]] {
        place.write("bare.xml", &(arms().split("<sensor>").next().unwrap().to_string() + "</mujoco>"));
        let mut child =
            place.command(arguments).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
        drop(child.stdout.take());
        let output = child.wait_with_output().unwrap();
        assert!(!text(&output.stderr).contains("panicked"), "{arguments:?}: {}", text(&output.stderr));
    }
}

#[test]
fn a_grown_skin_makes_a_bare_creature_learn() {
    let place = Place::new();
    let bare = arms().split("<sensor>").next().unwrap().to_string() + "</mujoco>";
    let without_sites: String = bare.lines().filter(|line| !line.contains("<site")).collect();
    place.write("bare.xml", &without_sites);
    place.succeeds(&["skin", "bare.xml", "--out", "grown.xml"]);
    let (to_stdout, _) = place.succeeds(&["skin", "bare.xml"]);
    assert_eq!(to_stdout, fs::read_to_string(place.path("grown.xml")).unwrap());
    let found = place.json(&["babble", "grown.xml", "--touches", "300", "--json"]);
    assert_eq!(found["converged"], Value::Bool(true), "{found}");
    place.write("file", "");
    has(&place.fails(&["skin", "bare.xml", "--out", "file/grown.xml"]), &["grown.xml", "--out"]);
    // With its skin it stays as it is; without, the same skin grows in memory, and that is said.
    let (again, _) = place.succeeds(&["skin", "grown.xml"]);
    assert_eq!(again, to_stdout);
    let (printed, message) = place.succeeds(&["babble", "bare.xml", "--touches", "300", "--json"]);
    has(&message, &["bare.xml", "no touch sensors", "receptors", "in memory"]);
    let in_memory: Value = serde_json::from_str(&printed).unwrap();
    assert_eq!(in_memory["converged"], Value::Bool(true), "{in_memory}");
    let receptors = |session: &Value| {
        let session = session["session"].as_str().unwrap();
        let text = fs::read_to_string(place.path(session).join("session.json")).unwrap();
        let session: Value = serde_json::from_str(&text).unwrap();
        let receptors = session["skin"]["receptors"].as_array().unwrap().clone();
        receptors.iter().map(|receptor| receptor["id"].clone()).collect::<Vec<_>>()
    };
    assert_eq!(receptors(&in_memory), receptors(&found));
}

#[test]
fn creatures_nobody_thought_of_end_in_a_result_or_a_sentence() {
    let place = Place::new();
    let limb = r#"<geom type="capsule" fromto="0 0 0 0.3 0 0" size="0.03"/>"#;
    let chain = |joint: &str, bodies: usize| {
        let one = |k: usize| {
            format!("<body pos='{} 0 0'>{joint}{limb}<site size='0.3'/>", if k > 0 { 0.3 } else { 0.0 })
        };
        (0..bodies).map(one).collect::<String>() + &"</body>".repeat(bodies)
    };
    let model = |body: &str, rest: &str| {
        format!(
            "<mujoco><compiler angle='radian' autolimits='true'/>{rest}<worldbody><body name='t'>{limb}{body}</body></worldbody></mujoco>"
        )
    };
    let mesh = "<asset><mesh name='m' vertex='0 0 0 0.3 0 0 0 0.1 0 0 0 0.1'/></asset>";
    for (name, xml) in [
        ("nameless balls", model(&chain("<joint type='ball'/>", 3), "")),
        ("nameless hinges", model(&chain("<joint axis='0 0 1'/>", 3), "")),
        ("huge ranges", model(&chain("<joint axis='0 1 0' range='-1e5 1e5'/>", 3), "")),
        ("huge slides", model(&chain("<joint type='slide' axis='0 1 0' range='-1e5 1e5'/>", 3), "")),
        ("zero size", model("<body><joint/><geom size='0'/></body>", "")),
        ("zero range", model(&chain("<joint range='0 0'/>", 2), "")),
        ("a plane on a limb", model("<body><joint/><geom type='plane' size='1 1 1'/></body>", "")),
        ("a mesh", model("<body><joint name='j'/><geom type='mesh' mesh='m'/></body>", mesh)),
        ("one limb", model(&chain("<joint axis='0 0 1'/>", 1), "")),
    ] {
        // Named, and with all sites sensed, what can be babbled is.
        let mut count = 0;
        let parts = xml.split("<site ").map(|part| {
            count += 1;
            if count == 1 { part.to_string() } else { format!("<site name='s{count}' {part}") }
        });
        let sensed: String = parts.collect();
        let sensors: String = (2..=count).map(|k| format!("<touch site='s{k}'/>")).collect();
        let sensed = sensed.replace("</mujoco>", &format!("<sensor>{sensors}</sensor></mujoco>"));
        for (file, text) in [("plain.xml", &xml), ("sensed.xml", &sensed)] {
            place.write(file, text);
            for arguments in [
                &["inspect", file][..],
                &["skin", file],
                &["babble", file, "--touches", "1", "--out", "odd", "--jobs", "2"],
            ] {
                let output = place.run(arguments);
                let message = self::text(&output.stderr);
                // A skin that grew is told of before anything can go wrong.
                let failure = message.lines().filter(|line| !line.ends_with("in memory"));
                let message = failure.collect::<Vec<_>>().join("\n");
                assert!(matches!(output.status.code(), Some(0 | 1)), "{name}, {arguments:?}: {message}");
                assert!(!message.contains("panicked"), "{name}, {arguments:?}: {message}");
                let failed = output.status.code() == Some(1);
                assert!(
                    !failed || message.trim_end().lines().count() == 1,
                    "{name}, {arguments:?}: {message}"
                );
            }
            let _ = fs::remove_dir_all(place.path("odd"));
        }
    }
}

#[test]
fn a_session_of_a_creature_with_an_odd_name_stays_in_its_folder() {
    let place = Place::new();
    place.write("odd.xml", &arms().replace("model=\"two arms\"", "model=\"../../../evil/name\""));
    let found = place.json(&["babble", "odd.xml", "--touches", "5", "--learner", "hersch", "--json"]);
    let session = Path::new(found["session"].as_str().unwrap());
    assert_eq!(session.parent(), Some(Path::new("sessions")));
    assert!(place.path("sessions").join(session.file_name().unwrap()).is_dir());
}

#[test]
fn old_names_of_commands_are_answered_with_the_new_ones() {
    let place = Place::new();
    for (old, new) in [("evaluate", "report"), ("observe", "report"), ("space", "reach"), ("map", "skin map")]
    {
        let output = place.run(&[old, "session"]);
        assert_eq!(output.status.code(), Some(2));
        has(&text(&output.stderr), &[&format!("`bodyschema {old}` is now `bodyschema {new}`")]);
    }
}
