//! Limits of the system, and files that are none: pipes, devices, models that take too long.

use std::fs;
use std::path::Path;
use std::process::{Command, Output};
use std::time::{Duration, Instant};

use tempfile::TempDir;

use crate::common::program::{refused, run};
use crate::common::{repository, two_arms};

/// How long a refusal may take at the most: a pipe is given three seconds.
const SOON: Duration = Duration::from_secs(15);

fn place() -> TempDir {
    let place = tempfile::tempdir().unwrap();
    let arms = two_arms(r#"type="capsule" size="0.12 0.2""#, r#"type="capsule" size="0.03 0.2""#);
    fs::write(place.path().join("arms.xml"), arms).unwrap();
    place
}

/// What a line of a shell does in a place; `$B` is the program.
fn shell(place: &Path, line: &str) -> Output {
    let mut command = Command::new("bash");
    command.args(["-c", line]).current_dir(place).env("B", env!("CARGO_BIN_EXE_bodyschema"));
    command.output().unwrap()
}

#[test]
fn hard_limits_are_taken_as_they_are_and_threads_are_bounded() {
    let place = place();
    for line in [
        "ulimit -v 4000000; $B inspect arms.xml",
        "ulimit -t 15; $B inspect arms.xml",
        "RAYON_NUM_THREADS=100000 $B babble arms.xml --touches 30 --learner hersch --out a",
        "ulimit -v 1500000; RAYON_NUM_THREADS=100000 $B babble arms.xml --touches 30 --learner hersch --jobs 2 --out b",
    ] {
        let output = shell(place.path(), line);
        assert!(output.status.success(), "{line}: {}", String::from_utf8_lossy(&output.stderr));
    }
}

#[test]
fn a_pipe_is_read_and_a_device_is_refused() {
    let place = place();
    let path = place.path();
    let babble = shell(path, "$B babble arms.xml --touches 30 --learner hersch --out s && mkfifo pipe");
    assert!(babble.status.success(), "{}", String::from_utf8_lossy(&babble.stderr));
    for (line, words) in [
        ("inspect pipe", "not a regular file"),
        ("learn --creature s/session.json --log /dev/zero --out c", "device"),
    ] {
        let began = Instant::now();
        let message = refused(path, 1, &line.split(' ').collect::<Vec<_>>());
        assert!(message.contains(words) && began.elapsed() < SOON, "{line}: {message}");
    }
    for line in [
        "cat s/touches.jsonl | $B learn --creature s/session.json --log /dev/stdin --learner hersch --out d",
        "$B learn --creature <(cat s/session.json) --log <(cat s/touches.jsonl) --learner hersch --out e",
    ] {
        let output = shell(path, line);
        assert!(output.status.success(), "{line}: {}", String::from_utf8_lossy(&output.stderr));
    }
}

#[test]
fn models_that_take_too_long_are_refused_at_once() {
    let place = place();
    let path = place.path();
    let model = |name: &str, text: &str| fs::write(path.join(name), text).unwrap();
    let hexapod = fs::read_to_string(repository("mjcf/hexapod/hexapod.xml")).unwrap();
    let with = |section: &str| hexapod.replacen("<worldbody>", &format!("{section}<worldbody>"), 1);
    model("step.xml", &with("<option timestep=\"1e-300\"/>"));
    model("rounds.xml", &with("<option iterations=\"2000000000\"/>"));
    model("pipe.xml", &with("<asset><mesh name=\"m\" file=\"pipe.stl\"/></asset>"));
    assert!(Command::new("mkfifo").arg(path.join("pipe.stl")).status().unwrap().success());
    let body = "<body><joint/><geom size=\".1\"/></body>";
    model("many.xml", &format!("<mujoco><worldbody>{}</worldbody></mujoco>", body.repeat(100_000)));
    model("nan.xml", &hexapod.replacen("<geom ", "<geom mass=\"nan\" ", 1));
    for (file, words) in [
        ("step.xml", "timestep=\"1e-300\""),
        ("rounds.xml", "iterations=\"2000000000\""),
        ("pipe.xml", "which is a pipe"),
        ("many.xml", "100000 elements <body>"),
        ("nan.xml", "\"nan\" in mass"),
    ] {
        let began = Instant::now();
        let message = refused(path, 1, &["inspect", file]);
        assert!(message.contains(words) && message.contains(file), "{file}: {message}");
        assert!(began.elapsed() < SOON, "{file}: {:?}", began.elapsed());
    }
}

/// A chain is written for MuJoCo in pieces, as its reader takes a hundred levels.
#[test]
fn a_chain_deeper_than_the_engines_reader_is_read() {
    let place = place();
    let link = |k: usize| {
        format!(
            "<body name=\"b{k}\" pos=\"0 0 .1\"><joint name=\"j{k}\" axis=\"1 0 0\"/><geom size=\".02\"/>"
        )
    };
    let chain: String = (0..150).map(link).collect();
    let text = format!("<mujoco><worldbody>{chain}{}</worldbody></mujoco>", "</body>".repeat(150));
    fs::write(place.path().join("chain.xml"), text).unwrap();
    let output = run(place.path(), &["inspect", "chain.xml"]);
    assert!(String::from_utf8_lossy(&output.stdout).contains("150 joints"));
}

#[test]
fn control_characters_in_names_are_shown_and_not_obeyed() {
    let place = place();
    let creature = r#"{"name": "a\u001b[2Jb", "limbs": ["x", "y"], "joints": [{"name": "j\u009b", "parent": "x", "dofs": [{"name": "d\u0007", "kind": "hinge"}]}]}"#;
    fs::write(place.path().join("c.json"), creature).unwrap();
    fs::write(place.path().join("l.csv"), "limb_a,limb_b,ax,ay,az,bx,by,bz\nx,y,0,0,0,0,0,0\n").unwrap();
    let message = refused(place.path(), 1, &["learn", "--creature", "c.json", "--log", "l.csv"]);
    assert!(message.contains("d\\u0007") && !message.trim_end().contains(char::is_control), "{message:?}");
    let odd = "none\u{1b}[31m.xml";
    let message = refused(place.path(), 1, &["inspect", odd]);
    assert!(message.contains("none\\u001b[31m.xml"), "{message:?}");
}
