//! `--config FILE`: options from a file, which the command line beats, and what is wrong with one.

use std::fs;
use std::process::{Command, Output};

use crate::common::two_arms;
use serde_json::Value;
use tempfile::TempDir;

fn place() -> TempDir {
    let place = tempfile::tempdir().unwrap();
    let arms = two_arms(r#"type="capsule" size="0.12 0.2""#, r#"type="capsule" size="0.03 0.2""#);
    fs::write(place.path().join("arms.xml"), arms).unwrap();
    place
}

fn run(place: &TempDir, config: &str, arguments: &[&str]) -> Output {
    fs::write(place.path().join("c.toml"), config).unwrap();
    let mut command = Command::new(env!("CARGO_BIN_EXE_bodyschema"));
    command.args(arguments).args(["--config", "c.toml"]).current_dir(place.path()).output().unwrap()
}

/// The JSON object that a command prints with a configuration.
fn json(place: &TempDir, config: &str, arguments: &[&str]) -> Value {
    let output = run(place, config, arguments);
    let message = String::from_utf8_lossy(&output.stderr);
    serde_json::from_slice(&output.stdout).unwrap_or_else(|error| panic!("{error}: {message}"))
}

const BABBLE: &str = r#"quiet = true  # of all commands

[babble]
touches = 40
seed = 7
learner = "hersch"
joint-noise = 0.25
json = true

[skin]
denser = ["left_hand=2", "right_hand=3"]
"#;

#[test]
fn options_come_from_the_file_and_are_kept_in_the_session() {
    let place = place();
    let told = json(&place, BABBLE, &["babble", "arms.xml", "--out", "s"]);
    assert_eq!(
        (&told["touches"], &told["seed"], &told["learner"]),
        (&40.into(), &7.into(), &"hersch".into())
    );
    assert_eq!(told["disturbances"]["joint_noise_deg"], 0.25);
    let session: Value =
        serde_json::from_str(&fs::read_to_string(place.path().join("s/session.json")).unwrap()).unwrap();
    let kept = &session["options"]["arguments"];
    for (name, value) in [("touches", "40"), ("seed", "7"), ("learner", "hersch"), ("joint-noise", "0.25")] {
        assert_eq!(kept[name], serde_json::json!([value]), "{kept}");
    }
    // A default that nobody named, and the model; but not what says nothing of what the session is.
    assert_eq!(
        (&kept["skin"], &kept["model"]),
        (&serde_json::json!(["surface"]), &serde_json::json!(["arms.xml"]))
    );
    assert!(
        kept.get("json").is_none() && kept.get("config").is_none() && kept.get("out").is_none(),
        "{kept}"
    );
}

#[test]
fn the_command_line_beats_the_file() {
    let place = place();
    for seed in [&["--seed", "9"][..], &["--seed=9"]] {
        let told = json(&place, BABBLE, &[&["babble", "arms.xml", "--touches", "30"], seed].concat());
        assert_eq!((&told["touches"], &told["seed"]), (&30.into(), &9.into()));
    }
    // An option that excludes one of the file.
    let config = "[skin]\nreceptors = 50\nout = \"new.xml\"\n";
    let output = run(&place, config, &["skin", "arms.xml", "--spacing", "0.1", "-o", "other.xml"]);
    assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
    assert!(place.path().join("other.xml").exists() && !place.path().join("new.xml").exists());
    // Global options may stand before the command.
    let mut command = Command::new(env!("CARGO_BIN_EXE_bodyschema"));
    let line = ["--config=c.toml", "skin", "arms.xml"];
    let output = command.args(line).current_dir(place.path()).output().unwrap();
    assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
    assert!(place.path().join("new.xml").exists());
}

#[test]
fn what_is_wrong_is_named_with_file_line_and_mend() {
    let place = place();
    for (config, line, words) in [
        ("[babble]\ntuches = 5\n", 2, "babble has no option tuches: see `bodyschema babble --help`"),
        ("[learn]\n\nspeed = 5\n", 3, "learn has no option speed"),
        ("touches = 5\n", 1, "as in [babble]"),
        ("[dance]\nseed = 1\n", 1, "there is no command dance"),
        ("[babble]\ntouches = true\n", 2, "touches takes no such value: give a text or a number"),
        ("[babble]\njson = 1\n", 2, "json is a flag: give true or false"),
        ("[babble]\ntouches = [1, 2]\n", 2, "touches is given once only"),
        ("[skin]\ndenser = [[1]]\n", 2, "denser is an array of something else"),
        ("[babble]\nseed = 3\ntouches = 0\n", 3, "at least 1"),
        ("[babble]\nlearner = \"magic\"\n", 2, "magic"),
        ("[babble]\ntouches = 5 6\n", 2, "it is no TOML"),
        ("[babble]\nconfig = \"c.toml\"\n", 2, "babble has no option config"),
        ("[rehearse]\nmodel = true\n", 1, "there is no command rehearse"),
    ] {
        let output = run(&place, config, &["babble", "arms.xml"]);
        let message = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(1), "{config}: {message}");
        assert_eq!(message.trim_end().lines().count(), 1, "{message}");
        assert!(message.starts_with(&format!("bodyschema: c.toml, line {line}: ")), "{config}: {message}");
        assert!(message.contains(words), "{config}: {message}");
    }
    assert!(!place.path().join("sessions").exists());
    let mut command = Command::new(env!("CARGO_BIN_EXE_bodyschema"));
    let output = command.args(["inspect", "arms.xml", "--config", "none.toml"]).output().unwrap();
    let message = String::from_utf8_lossy(&output.stderr);
    assert!(message.contains("cannot read none.toml"), "{message}");
}
