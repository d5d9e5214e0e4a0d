//! Where results go: what is there is replaced by `--force` alone and all at once, and a command that fails leaves nothing.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use crate::common::program::{refused, succeeds};
use crate::common::{repository, two_arms};
use bodyschema::session::FolderLock;
use tempfile::TempDir;

const BABBLE: [&str; 6] = ["babble", "arms.xml", "--learner", "hersch", "--policy", "random"];

/// A folder with a small creature and a session of it in `s`, beside a note of somebody.
fn place() -> TempDir {
    let place = tempfile::tempdir().unwrap();
    fs::write(
        place.path().join("arms.xml"),
        two_arms("type=\"sphere\" size=\"0.2\"", "type=\"capsule\" size=\"0.05 0.15\""),
    )
    .unwrap();
    succeeds(place.path(), &[&BABBLE[..], &["--touches", "20", "--out", "s"]].concat());
    fs::write(place.path().join("s/note.txt"), "mine").unwrap();
    place
}

/// The files of a folder with what they hold, folders with nothing.
fn files(folder: &Path) -> BTreeMap<String, Vec<u8>> {
    let entries = fs::read_dir(folder).unwrap().flatten();
    entries
        .map(|entry| (entry.file_name().to_string_lossy().into(), fs::read(entry.path()).unwrap_or_default()))
        .collect()
}

#[test]
fn results_are_replaced_by_force_alone_and_not_before_the_new_ones_are_complete() {
    let place = place();
    let folder = place.path().join("s");
    // Made of the schema, by another command.
    fs::write(folder.join("space.json"), "{}").unwrap();
    let before = files(&folder);
    let again = [&BABBLE[..], &["--seed", "2", "--touches", "30", "--out", "s"]].concat();
    assert!(refused(place.path(), 1, &again).contains("--force"));
    let learn = ["learn", "s", "--learner", "hersch", "--out", "s"];
    assert!(refused(place.path(), 1, &learn).contains("--force"));
    // One that fails, …
    refused(place.path(), 1, &["babble", "nobody.xml", "--out", "s", "--force"]);
    assert_eq!(files(&folder), before);
    // … and one that is killed while it writes.
    let endless = [&BABBLE[..], &["--touches", "10000000", "--out", "s", "--force"]].concat();
    let mut program = Command::new(env!("CARGO_BIN_EXE_bodyschema"))
        .args(&endless)
        .current_dir(place.path())
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn()
        .unwrap();
    let began = Instant::now();
    let written = || {
        let hidden = fs::read_dir(&folder).unwrap().flatten().find(|entry| entry.path().is_dir());
        hidden.is_some_and(|aside| {
            fs::metadata(aside.path().join("touches.jsonl")).is_ok_and(|log| log.len() > 1000)
        })
    };
    while !written() {
        assert!(began.elapsed() < Duration::from_secs(60), "nothing is written");
        std::thread::sleep(Duration::from_millis(5));
    }
    program.kill().unwrap();
    program.wait().unwrap();
    let mut killed = files(&folder);
    killed.retain(|name, _| !name.starts_with('.'));
    assert_eq!(killed, before);

    let said = succeeds(place.path(), &[&again[..], &["--force"]].concat());
    assert!(said.contains("session: s\n"), "{said}");
    let now = files(&folder);
    let names = |files: &BTreeMap<String, Vec<u8>>| files.keys().cloned().collect::<Vec<_>>();
    let expected: Vec<String> = names(&before).into_iter().filter(|name| name != "space.json").collect();
    assert_eq!(
        names(&now),
        expected,
        "what was made of the old schema goes, notes stay, nothing hidden is left"
    );
    assert_eq!(now["note.txt"], b"mine");
    assert_ne!(now["touches.jsonl"], before["touches.jsonl"]);
    // It is the session that it would have been elsewhere.
    succeeds(place.path(), &[&BABBLE[..], &["--seed", "2", "--touches", "30", "--out", "t"]].concat());
    assert_eq!(now["touches.jsonl"], fs::read(place.path().join("t/touches.jsonl")).unwrap());
    // And it is learned from in its own place.
    succeeds(place.path(), &[&learn[..], &["--force"]].concat());
    assert_eq!(names(&files(&folder)), expected);
    assert!(refused(place.path(), 2, &["babble", "arms.xml", "--force"]).contains("--out"));
    assert!(refused(place.path(), 2, &["babble", "--resume", "s", "--force"]).contains("--force"));
}

#[test]
fn a_model_is_learned_by_babbling() {
    let place = place();
    let babble = [&BABBLE[1..], &["--touches", "20", "--out", "t"]].concat();
    succeeds(place.path(), &[&["learn"], &babble[..]].concat());
    let log = |session: &str| fs::read(place.path().join(session).join("touches.jsonl")).unwrap();
    assert!(log("s") == log("t"));
}

/// Whoever is killed between any two moves, what is there then or after the next command is all new.
#[test]
fn a_replacement_is_whole_wherever_its_writer_was_killed() {
    let new = ["a.json", "b.csv", "schema.json"];
    for moved in 0..=new.len() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        for name in ["a.json", "b.csv", "schema.json", "old.json", "note.txt"] {
            fs::write(at(name), "old").unwrap();
        }
        fs::create_dir(at(".generation")).unwrap();
        fs::write(at(".generation/.removed"), "old.json\n").unwrap();
        for (k, name) in new.iter().enumerate() {
            let place = if k < moved { at(name) } else { at(".generation").join(name) };
            fs::write(place, "new").unwrap();
        }
        drop(FolderLock::take(folder.path()).unwrap());
        let found = files(folder.path());
        let names: Vec<&str> = found.keys().map(String::as_str).collect();
        assert_eq!(names, ["a.json", "b.csv", "note.txt", "schema.json"], "after {moved} moves");
        assert!(new.iter().all(|name| found[*name] == b"new"), "after {moved} moves");
        assert_eq!(found["note.txt"], b"old");
    }
}

#[test]
fn other_results_are_replaced_by_force_too() {
    let place = place();
    let at = |name: &str| place.path().join(name);
    let robot = repository("examples/robot");
    let (urdf, log) = (robot.join("arms.urdf"), robot.join("touches.csv"));
    let calibrate =
        ["calibrate", urdf.to_str().unwrap(), log.to_str().unwrap(), "--free", "*.offset", "--out"];
    let calibrate = |out: &'static str| [&calibrate[..], &[out]].concat();
    succeeds(place.path(), &calibrate("made"));
    // Somebody's own robot, of the name that the result would have, and a page of another command.
    fs::create_dir(at("own")).unwrap();
    fs::write(at("own/arms.urdf"), "mine").unwrap();
    for out in ["made", "own", "s"] {
        let before = files(&at(out));
        assert!(refused(place.path(), 1, &calibrate(out)).contains("--force"), "{out}");
        assert_eq!(files(&at(out)), before, "{out}");
    }
    let before = files(&at("made"));
    fs::write(at("made/residuals.csv"), "old").unwrap();
    succeeds(place.path(), &[&calibrate("made")[..], &["--force"]].concat());
    assert_eq!(files(&at("made")), before);

    let feel = ["skin", "feel", "arms.xml", "--strokes", "0.02", "--out", "s"];
    assert!(refused(place.path(), 1, &feel).contains("--force"));
    succeeds(place.path(), &[&feel[..], &["--force"]].concat());
    let names: Vec<String> = files(&at("s")).into_keys().collect();
    assert_eq!(names, ["firings.jsonl", "note.txt", "sensations.jsonl", "session.json"]);

    fs::create_dir(at("gallery")).unwrap();
    fs::write(at("gallery/gallery.md"), "hours of work").unwrap();
    assert!(refused(place.path(), 1, &["study", "gallery", "arms.xml"]).contains("--force"));
    fs::create_dir_all(at("odd/schema.json")).unwrap();
    let odd = refused(place.path(), 1, &[&BABBLE[..], &["--out", "odd", "--force"]].concat());
    assert!(odd.contains("odd/schema.json: not a file"), "{odd}");
}

#[test]
fn a_command_that_fails_leaves_no_folder() {
    let place = place();
    fs::create_dir(place.path().join("empty")).unwrap();
    for file in ["session.json", "touches.jsonl"] {
        let text = fs::read_to_string(place.path().join("s").join(file)).unwrap();
        // A session without a touch.
        let text =
            if file == "touches.jsonl" { text.lines().next().unwrap().to_string() + "\n" } else { text };
        fs::write(place.path().join("empty").join(file), text).unwrap();
    }
    // Too long for a file system, so that the folder can be made and the file cannot.
    let long = format!("new/deep/{}.xml", "x".repeat(300));
    let long_urdf = long.replace(".xml", ".urdf");
    fs::create_dir(place.path().join("x.urdf")).unwrap();
    fs::write(
        place.path().join("stiff.xml"),
        "<mujoco><worldbody><body><joint name=\"j\"/><geom size=\"0.1\"/></body></worldbody></mujoco>",
    )
    .unwrap();
    let robot = repository("examples/robot");
    let (urdf, log) = (robot.join("arms.urdf"), robot.join("touches.csv"));
    let (urdf, log) = (urdf.to_str().unwrap(), log.to_str().unwrap());
    let before = files(place.path());
    let inside = files(&place.path().join("s"));
    for arguments in [
        &["export", "s", "--out", &long][..],
        &["export", "s", "--out", &long_urdf],
        &["export", "s", "--out", "x.urdf"],
        &["export", "s", "--out", "x.jpg"],
        &["export", "s", "--urdf"],
        &["skin", "arms.xml", "--out", &long],
        &["study", "generate", "--out", &long],
        &["learn", "empty", "--out", "new/deep"],
        &["learn", "empty", "--out", "s", "--force"],
        &["learn", "--creature", "empty/session.json", "--log", "empty/touches.jsonl", "--out", "new/deep"],
        &["calibrate", urdf, log, "--fix", "*", "--free", "nobody.offset", "--out", "new/deep"],
        &["calibrate", urdf, log, "--free", "*.offset", "--fix", "*", "--out", "new/deep"],
        &["babble", "stiff.xml", "--policy", "random", "--out", "new/deep"],
        &["babble", "stiff.xml"],
    ] {
        refused(place.path(), 1, arguments);
        assert_eq!(files(place.path()), before, "{arguments:?}");
        assert_eq!(files(&place.path().join("s")), inside, "{arguments:?}");
    }
}
