//! Sessions and studies that several processes make between them come to what one process makes, byte for byte.

use std::fs;
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::Duration;

use serde_json::Value;
use tempfile::TempDir;

use crate::common::program::{refused, succeeds};
use crate::common::{repository, two_arms};

/// Files of a session that are the same whoever made them.
const SAME: [&str; 4] = ["touches.jsonl", "schema.json", "learned.xml", "learning.csv"];

/// A folder with a creature whose bouts bring as many touches as they can.
fn place() -> TempDir {
    let place = tempfile::tempdir().unwrap();
    let arms = two_arms(r#"type="capsule" size="0.12 0.2""#, r#"type="capsule" size="0.03 0.2""#);
    fs::write(place.path().join("arms.xml"), arms).unwrap();
    place
}

/// The same with one that rarely touches itself: most of its bouts bring one touch or none.
fn rarely() -> TempDir {
    let arm = |side: &str, y: f64| {
        format!(
            r#"<body name="{side}_upper" pos="0 {y} 0.4"><joint name="{side}_a" axis="1 0.2 0" range="-0.2 0.2"/>
            <joint name="{side}_b" axis="0 1 0.3" range="-0.2 0.2"/><geom type="capsule" fromto="0 0 0 0.3 0 0" size="0.03"/>
            <body name="{side}_fore" pos="0.3 0 0"><joint name="{side}_c" axis="0 0 1" range="-1.2 1.2"/>
            <geom type="capsule" size="0.03 0.2" pos="0.2 0 0" euler="0.3 0.2 0.1"/>
            <site name="{side}_r" type="box" size="0.3 0.3 0.001" pos="0.2 0 0.1"/></body></body>"#
        )
    };
    let model = format!(
        r#"<mujoco model="rare"><compiler angle="radian" autolimits="true"/><worldbody><body name="trunk" pos="0 0 1">
        <geom type="capsule" size="0.05 0.2" pos="0 0 0.1"/><site name="t_r" type="box" size="0.4 0.4 0.001" pos="0 0 0.45"/>
        {}{}</body></worldbody><sensor><touch site="left_r"/><touch site="right_r"/><touch site="t_r"/></sensor></mujoco>"#,
        arm("left", 0.25),
        arm("right", -0.25)
    );
    let place = tempfile::tempdir().unwrap();
    fs::write(place.path().join("arms.xml"), model).unwrap();
    place
}

fn babble<'a>(touches: &'a str, out: &'a str) -> [&'a str; 8] {
    ["babble", "arms.xml", "--touches", touches, "--seed", "3", "--out", out]
}

/// Makes a share.
fn share(place: &Path, touches: &str, share: &str, out: &str) -> String {
    succeeds(place, &[&babble(touches, out)[..], &["--shard", share]].concat())
}

/// The numbers of touches in the bouts of a share.
fn bouts(place: &Path, share: &str) -> Vec<usize> {
    let text = fs::read_to_string(place.join(share).join("bouts.csv")).unwrap();
    text.lines().map(|line| line.split(',').nth(1).unwrap().parse().unwrap()).collect()
}

/// That two sessions came to the same, but for the times that they took and their command lines.
fn same(place: &Path, one: &str, other: &str) {
    for file in SAME {
        let [a, b] = [one, other].map(|session| fs::read(place.join(session).join(file)).unwrap());
        assert!(a == b, "{one} and {other} have another {file}");
    }
    let [a, b] = [one, other].map(|session| {
        let text = fs::read_to_string(place.join(session).join("session.json")).unwrap();
        let mut about: Value = serde_json::from_str(&text).unwrap();
        assert!(about["effort"]["babbling_s"].as_f64().unwrap() > 0.0, "{about}");
        about["effort"]["babbling_s"] = Value::Null;
        about["command"] = Value::Null;
        about
    });
    assert_eq!(a, b);
}

#[test]
fn shares_in_any_order_come_to_the_log_of_one_process() {
    let place = place();
    let place = place.path();
    // No multiple of a bout's touches: the last bout is cut short.
    let touches = "310";
    succeeds(place, &[&babble(touches, "one")[..], &["--policy", "random"]].concat());
    for of in [1, 3, 16] {
        let out = format!("of-{of}");
        for number in (1..=of).rev() {
            share(place, touches, &format!("{number}/{of}"), &out);
        }
        let told = succeeds(place, &["study", "merge", &out]);
        assert!(told.contains("from 310 touches") && told.contains(&format!("session: {out}")), "{told}");
        same(place, "one", &out);
        // Once more nothing is done.
        let log = place.join(&out).join("touches.jsonl");
        let before = fs::metadata(&log).unwrap().modified().unwrap();
        succeeds(place, &["study", "merge", &out]);
        assert_eq!(fs::metadata(&log).unwrap().modified().unwrap(), before);
        assert_eq!(succeeds(place, &["study", "merge", &out, "--missing"]), "\n");
    }
}

#[test]
fn where_touches_are_rare_what_no_share_made_is_babbled_at_the_end() {
    let place = rarely();
    let place = place.path();
    succeeds(place, &[&babble("60", "one")[..], &["--policy", "random"]].concat());
    for number in 1..=3 {
        share(place, "60", &format!("{number}/3"), "three");
    }
    let counts = [1, 2, 3].map(|number| bouts(place, &format!("three/shares/{number}-of-3")));
    assert!(counts.iter().flatten().any(|touches| *touches == 0), "{counts:?}");
    assert!(
        counts.iter().any(|bouts| bouts.len() != counts[0].len()),
        "all shares have as many bouts: {counts:?}"
    );
    succeeds(place, &["study", "merge", "three"]);
    same(place, "one", "three");
}

#[test]
fn missing_and_interrupted_shares_are_named_and_only_they_are_made() {
    let place = place();
    let place = place.path();
    let touches = "3000";
    share(place, touches, "1/3", "out");
    let message = refused(place, 1, &["study", "merge", "out"]);
    assert!(message.contains("missing: 2/3, 3/3") && message.contains("--shard 2/3"), "{message}");
    assert_eq!(succeeds(place, &["study", "merge", "out", "--missing"]), "2,3\n");
    // The second is killed once it has written some.
    let mut killed = Command::new(env!("CARGO_BIN_EXE_bodyschema"));
    killed.args(babble(touches, "out")).args(["--shard", "2/3"]).current_dir(place);
    let mut killed = killed.stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap();
    let log = place.join("out/shares/2-of-3/touches.jsonl");
    while fs::metadata(&log).map_or(0, |about| about.len()) < 50_000 {
        assert!(killed.try_wait().unwrap().is_none(), "it came to its end before it was killed");
        std::thread::sleep(Duration::from_millis(1));
    }
    killed.kill().unwrap();
    killed.wait().unwrap();
    // So does a power failure leave files.
    let bouts = place.join("out/shares/2-of-3/bouts.csv");
    let mut bytes = fs::read(&bouts).unwrap();
    bytes.extend(b"12,2");
    fs::write(&bouts, bytes).unwrap();
    share(place, touches, "3/3", "out");
    let message = refused(place, 1, &["study", "merge", "out"]);
    assert!(message.contains("not finished: 2/3") && !message.contains("missing"), "{message}");
    let first = place.join("out/shares/1-of-3/touches.jsonl");
    let before = fs::metadata(&first).unwrap().modified().unwrap();
    for number in [1, 2] {
        share(place, touches, &format!("{number}/3"), "out");
    }
    assert_eq!(
        fs::metadata(&first).unwrap().modified().unwrap(),
        before,
        "a share that was made is made again"
    );
    succeeds(place, &["study", "merge", "out"]);
    succeeds(place, &[&babble(touches, "one")[..], &["--policy", "random"]].concat());
    same(place, "one", "out");
}

#[test]
fn shares_that_do_not_belong_together_are_refused() {
    let place = place();
    let place = place.path();
    share(place, "100", "1/2", "out");
    // Another seed in the same place, and where another share is.
    let other = ["babble", "arms.xml", "--touches", "100", "--seed", "4", "--out", "out", "--shard"];
    let message = refused(place, 1, &[&other[..], &["1/2"]].concat());
    assert!(message.contains("seed") && message.contains("--out"), "{message}");
    succeeds(place, &[&other[..], &["2/2"]].concat());
    let message = refused(place, 1, &["study", "merge", "out"]);
    let seeds = ["seed is 3 in one, 4 in the other", "seed is 4 in one, 3 in the other"];
    assert!(seeds.iter().any(|words| message.contains(words)), "{message}");
    // What was changed in the last bout, which is made once more.
    fs::remove_dir_all(place.join("out/shares/2-of-2")).unwrap();
    share(place, "100", "2/2", "out");
    let log = place.join("out/shares/2-of-2/touches.jsonl");
    let text = fs::read_to_string(&log).unwrap();
    let last = text.lines().last().unwrap();
    let motion: Value = serde_json::from_str(last).unwrap();
    let motion = motion["motion"].as_u64().unwrap();
    let changed = last.replace(&format!("\"motion\":{motion}"), &format!("\"motion\":{}", motion + 1));
    assert_ne!(changed, last);
    fs::write(&log, text.replace(last, &changed)).unwrap();
    let message = refused(place, 1, &["study", "merge", "out"]);
    assert!(message.contains("bout 3") && message.contains("make that share again"), "{message}");
    // A line that is not there any more.
    fs::write(&log, text.replace(&format!("{last}\n"), "")).unwrap();
    let message = refused(place, 1, &["study", "merge", "out"]);
    assert!(message.contains("2-of-2") && message.contains("lost"), "{message}");
    // What cannot be shared, or is no share.
    for (arguments, words) in [
        (&["--shard", "1/2", "--policy", "stages"][..], "--policy random"),
        (&["--shard", "3/2"], "3/16"),
        (&["--shard", "1/2", "--seconds", "3"], "--seconds"),
    ] {
        let line = [&babble("100", "else")[..], arguments].concat();
        let code = if words.starts_with("--policy") { 1 } else { 2 };
        let message = refused(place, code, &line);
        assert!(message.contains(words), "{message}");
    }
    assert!(!place.join("else").exists());
    let message = refused(place, 1, &["study", "merge", "."]);
    assert!(message.contains("no shares") && message.contains("--shard"), "{message}");
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
    let session =
        ["5", "session", program, "babble", "arms.xml", "--touches", "310", "--seed", "3", "--jobs", "1"];
    let told = script("parallel.sh", place, &session);
    assert!(told.contains("from 310 touches"), "{told}");
    succeeds(place, &[&babble("310", "one")[..], &["--policy", "random"]].concat());
    same(place, "one", "session");
    let jobs = || fs::read_to_string(place.join("session/logs/parallel.tsv")).unwrap().lines().count() - 1;
    assert_eq!(jobs(), 5);
    let log = fs::read_to_string(place.join("session/logs/4.txt")).unwrap();
    assert!(log.contains("share 4/5"), "{log}");
    // One is lost, with all that was made of it.
    fs::remove_dir_all(place.join("session/shares/4-of-5")).unwrap();
    for file in SAME.iter().chain(&["session.json", "learning.json", "report.html"]) {
        fs::remove_file(place.join("session").join(file)).unwrap();
    }
    script("parallel.sh", place, &session);
    assert_eq!(jobs(), 1);
    same(place, "one", "session");
    let table = ["2", "table", program, "study", "learners", "arms.xml", "--trials", "3", "--touches", "12"];
    let told = script("parallel.sh", place, &table);
    assert!(told.contains("3 trials of 12 touches"), "{told}");
}
