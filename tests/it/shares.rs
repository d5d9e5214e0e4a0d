//! Studies that several processes make between them come to what one process makes, byte for byte.

use std::fs;
use std::path::Path;
use std::process::Command;

use serde_json::Value;
use tempfile::TempDir;

use crate::common::program::{refused, succeeds};
use crate::common::{repository, two_arms};

/// A folder with a creature whose bouts bring as many touches as they can.
fn place() -> TempDir {
    let place = tempfile::tempdir().unwrap();
    let arms = two_arms(r#"type="capsule" size="0.12 0.2""#, r#"type="capsule" size="0.03 0.2""#);
    fs::write(place.path().join("arms.xml"), arms).unwrap();
    place
}

/// A study of two learners' courses on a small creature, with a share or none.
fn study<'a>(name: &'a str, more: &[&'a str]) -> Vec<&'a str> {
    let study = ["study", name, "arms.xml", "--trials", "5", "--seed", "7", "--touches", "12", "--out"];
    [&study[..], more].concat()
}

/// What a study's file says, but for how long it took, and where it is.
fn found(place: &Path, folder: &str) -> Value {
    let text = fs::read_to_string(place.join(folder).join("study.json")).unwrap();
    let mut found: Value = serde_json::from_str(&text).unwrap();
    assert!(found["seconds"].as_f64().unwrap() > 0.0);
    found["seconds"] = Value::Null;
    found["folder"] = Value::Null;
    found
}

#[test]
fn trials_of_a_study_are_shared_and_come_to_the_tables_of_one_process() {
    let place = place();
    let place = place.path();
    succeeds(place, &study("learners", &["one"]));
    for (of, out) in [(1, "of-1"), (3, "of-3"), (16, "of-16")] {
        for number in (1..=of).rev() {
            let share = format!("{number}/{of}");
            let told = succeeds(place, &study("learners", &[out, "--shard", &share]));
            assert!(told.contains(&format!("share {share}")) && told.contains("merge"), "{told}");
        }
        let told = succeeds(place, &["study", "merge", out]);
        assert!(told.contains("5 trials of 12 touches, seeds 7 8 9 10 11"), "{told}");
        let table = |folder: &str| fs::read(place.join(folder).join("study.csv")).unwrap();
        assert!(table("one") == table(out), "{out} has another table");
        assert_eq!(found(place, "one"), found(place, out));
    }
}

#[test]
fn trials_that_are_missing_are_named_by_their_shares_and_only_they_are_made() {
    let place = place();
    let place = place.path();
    succeeds(place, &study("learners", &["out", "--shard", "2/2"]));
    let message = refused(place, 1, &["study", "merge", "out"]);
    assert!(message.contains("missing: 1/2") && message.contains("--shard 1/2"), "{message}");
    succeeds(place, &study("learners", &["out", "--shard", "1/2"]));
    // A trial that was not done when its process was killed.
    let trials = place.join("out/shares/1-of-2/trials");
    fs::remove_file(trials.join("9.json")).unwrap();
    assert_eq!(succeeds(place, &["study", "merge", "out", "--missing"]), "1\n");
    let made = fs::metadata(trials.join("7.json")).unwrap().modified().unwrap();
    succeeds(place, &study("learners", &["out", "--shard", "1/2"]));
    assert_eq!(fs::metadata(trials.join("7.json")).unwrap().modified().unwrap(), made);
    // One that is none is named.
    let trial = fs::read_to_string(trials.join("11.json")).unwrap();
    fs::write(trials.join("11.json"), &trial[..trial.len() / 2]).unwrap();
    let message = refused(place, 1, &["study", "merge", "out"]);
    assert!(message.contains("11.json") && message.contains("remove it"), "{message}");
    fs::write(trials.join("11.json"), trial).unwrap();
    // Another study is not mixed with it.
    let other =
        ["study", "learners", "arms.xml", "--trials", "5", "--seed", "8", "--touches", "12", "--out", "out"];
    let message = refused(place, 1, &[&other[..], &["--shard", "1/2"]].concat());
    assert!(message.contains("seed is 7") && message.contains("--out"), "{message}");
    let message = refused(place, 2, &study("learners", &["else", "--shard", "3/2"]));
    assert!(message.contains("3/16") && !place.join("else").exists(), "{message}");
    let message = refused(place, 1, &["study", "merge", "."]);
    assert!(message.contains("no shares") && message.contains("--shard"), "{message}");
    succeeds(place, &["study", "merge", "out"]);
    succeeds(place, &study("learners", &["one"]));
    assert_eq!(found(place, "one"), found(place, "out"));
}

/// Runs a script of examples/many.
fn script(name: &str, place: &Path, arguments: &[&str]) -> String {
    let mut script = Command::new(repository("examples/many").join(name));
    let output = script.args(arguments).current_dir(place).output().unwrap();
    let told = String::from_utf8_lossy(&output.stdout).into_owned();
    assert_eq!(output.status.code(), Some(0), "{told}{}", String::from_utf8_lossy(&output.stderr));
    told
}

#[test]
#[ignore = "needs GNU parallel"]
fn gnu_parallel_makes_all_shares_and_only_those_that_are_missing() {
    let place = place();
    let place = place.path();
    let program = env!("CARGO_BIN_EXE_bodyschema");
    let table = [
        "3",
        "table",
        program,
        "study",
        "learners",
        "arms.xml",
        "--trials",
        "5",
        "--seed",
        "7",
        "--touches",
        "12",
        "--jobs",
        "1",
    ];
    let told = script("parallel.sh", place, &table);
    assert!(told.contains("5 trials of 12 touches"), "{told}");
    succeeds(place, &study("learners", &["one"]));
    assert_eq!(found(place, "one"), found(place, "table"));
    let jobs = || fs::read_to_string(place.join("table/logs/parallel.tsv")).unwrap().lines().count() - 1;
    assert_eq!(jobs(), 3);
    let log = fs::read_to_string(place.join("table/logs/2.txt")).unwrap();
    assert!(log.contains("share 2/3"), "{log}");
    // One is lost, with all that was made of it.
    fs::remove_dir_all(place.join("table/shares/2-of-3")).unwrap();
    ["study.json", "study.csv"]
        .iter()
        .for_each(|file| fs::remove_file(place.join("table").join(file)).unwrap());
    script("parallel.sh", place, &table);
    assert_eq!(jobs(), 1);
    assert_eq!(found(place, "one"), found(place, "table"));
}
