//! Sessions that are interrupted and gone on with: their touches are those of one that never was.

use std::fs::{self, File, OpenOptions};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output, Stdio};
use std::time::{Duration, Instant};

use crate::common::two_arms;
use serde_json::Value;
use tempfile::TempDir;

/// How long a killed session may take to come to the place where it is killed.
const PATIENCE: Duration = Duration::from_secs(120);
/// Files that learning leaves, the same each time.
const LEARNED: [&str; 3] = ["schema.json", "learned.xml", "learning.csv"];

/// A folder with a small creature, in which sessions are begun, killed and gone on with.
struct Place(TempDir);

impl Place {
    fn new() -> Place {
        let place = Place(tempfile::tempdir().unwrap());
        let arms = two_arms(r#"type="capsule" size="0.12 0.2""#, r#"type="capsule" size="0.03 0.2""#);
        fs::write(place.path("arms.xml"), arms).unwrap();
        place
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    fn command(&self, arguments: &[&str]) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_bodyschema"));
        command.args(arguments).current_dir(self.0.path());
        command
    }

    fn run(&self, arguments: &[&str]) -> Output {
        self.command(arguments).output().unwrap()
    }

    fn succeeds(&self, arguments: &[&str]) -> String {
        let output = self.run(arguments);
        let message = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(0), "{arguments:?}: {message}");
        message
    }

    fn fails(&self, arguments: &[&str]) -> String {
        let output = self.run(&[arguments, &["--quiet"]].concat());
        let message = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(1), "{arguments:?}: {message}");
        assert_eq!(message.trim_end().lines().count(), 1, "{message}");
        message
    }

    /// Begins a session and kills it as soon as `now` holds of its folder; whether that was before its end.
    fn killed(&self, arguments: &[&str], folder: &str, now: impl Fn(&Path) -> bool) -> bool {
        let mut command = self.command(&["babble", "arms.xml", "--out", folder]);
        command.args(arguments).stdout(Stdio::null()).stderr(Stdio::null());
        let mut child: Child = command.spawn().unwrap();
        let (began, folder) = (Instant::now(), self.path(folder));
        while !now(&folder) && child.try_wait().unwrap().is_none() {
            assert!(began.elapsed() < PATIENCE, "{} never came so far", folder.display());
            std::thread::sleep(Duration::from_micros(200));
        }
        // On Unix this is SIGKILL, which nothing can catch.
        let _ = child.kill();
        child.wait().unwrap().code().is_none()
    }

    fn log(&self, session: &str) -> Vec<u8> {
        fs::read(self.path(session).join("touches.jsonl")).unwrap()
    }

    /// What a session says of itself, but for the time that babbling took, and the command, which names the folder.
    fn about(&self, session: &str) -> Value {
        let text = fs::read_to_string(self.path(session).join("session.json")).unwrap();
        let mut about: Value = serde_json::from_str(&text).unwrap();
        assert!(about["effort"]["babbling_s"].as_f64().unwrap() > 0.0, "{about}");
        about["effort"]["babbling_s"] = Value::Null;
        assert_eq!(about["command"][1], "babble");
        about["command"] = Value::Null;
        about
    }

    /// That two sessions came to the same.
    fn same(&self, one: &str, other: &str) {
        assert!(self.log(one) == self.log(other), "{one} and {other} have other touches");
        assert_eq!(self.about(one), self.about(other));
        for file in LEARNED {
            let [a, b] = [one, other].map(|session| fs::read(self.path(session).join(file)).unwrap());
            assert!(a == b, "{one} and {other} have another {file}");
        }
        assert!(!self.path(other).join("babbling.json").exists());
    }
}

fn lines(folder: &Path) -> usize {
    fs::read(folder.join("touches.jsonl")).map_or(0, |log| log.iter().filter(|byte| **byte == b'\n').count())
}

#[test]
fn a_session_killed_at_any_moment_is_gone_on_with_to_the_same() {
    let place = Place::new();
    let options = ["--touches", "3000", "--learner", "hersch", "--seed", "3", "--false-touches", "0.05"];
    place.succeeds(&[&["babble", "arms.xml", "--out", "whole"], &options[..]].concat());
    type Moment = (&'static str, fn(&Path) -> bool);
    let moments: [Moment; 6] = [
        ("begun", |folder| folder.join("session.json").exists()),
        ("log", |folder| folder.join("touches.jsonl").exists()),
        ("first", |folder| lines(folder) >= 2),
        ("middle", |folder| lines(folder) >= 1500),
        ("kept", |folder| folder.join("babbling.json").exists()),
        ("learning", |folder| folder.join(".generation.part/learning.csv").exists()),
    ];
    for (name, moment) in moments {
        let killed = place.killed(&options, name, moment);
        // A machine that is fast enough may be done before anything is kept.
        assert!(killed || name == "kept", "{name} came to its end before it was killed");
        let message = place.succeeds(&["babble", "--resume", name, "--jobs", "2"]);
        assert!(message.contains(name), "{message}");
        place.same("whole", name);
        assert!(place.path(name).join("report.html").exists());
    }
}

#[test]
fn a_session_killed_again_and_again_comes_to_its_end() {
    let place = Place::new();
    let options = ["--touches", "2000", "--learner", "hersch"];
    place.succeeds(&[&["babble", "arms.xml", "--out", "whole"], &options[..]].concat());
    place.killed(&options, "often", |folder| lines(folder) >= 10);
    for more in [300, 700, 1500] {
        let mut child =
            place.command(&["babble", "--resume", "often"]).stderr(Stdio::null()).spawn().unwrap();
        while lines(&place.path("often")) < more && child.try_wait().unwrap().is_none() {
            std::thread::sleep(Duration::from_micros(200));
        }
        let _ = child.kill();
        child.wait().unwrap();
    }
    place.succeeds(&["babble", "--resume", "often"]);
    place.same("whole", "often");
}

/// Puts a copy of a whole session back to where babbling had written `bytes` of the log.
fn cut(place: &Place, whole: &str, cut: &str, bytes: usize) {
    fs::create_dir_all(place.path(cut)).unwrap();
    let mut about: Value =
        serde_json::from_slice(&fs::read(place.path(whole).join("session.json")).unwrap()).unwrap();
    about["effort"] = Value::Null;
    fs::write(place.path(cut).join("session.json"), about.to_string()).unwrap();
    fs::write(place.path(cut).join("touches.jsonl"), &place.log(whole)[..bytes]).unwrap();
}

#[test]
fn every_policy_and_motion_goes_on_in_the_middle_of_a_line() {
    let place = Place::new();
    for (name, touches, options) in [
        ("random", "60", &["--policy", "random"][..]),
        ("stages", "30", &["--policy", "stages"]),
        ("dynamic", "8", &["--motion", "dynamic"]),
    ] {
        let begin = ["babble", "arms.xml", "--touches", touches, "--learner", "hersch", "--out", name];
        place.succeeds(&[&begin[..], options].concat());
        let log = place.log(name);
        let header = log.iter().position(|byte| *byte == b'\n').unwrap() + 1;
        let last = log[..log.len() - 1].iter().rposition(|byte| *byte == b'\n').unwrap() + 1;
        let every = [header + 7, log.len() / 2, log.len() - 1, 0, 1, header - 1, header, last, log.len()];
        // The others take their time.
        let cuts = if name == "random" { &every[..] } else { &every[1..2] };
        for &bytes in cuts {
            let part = format!("{name}-{bytes}");
            cut(&place, name, &part, bytes);
            place.succeeds(&["babble", "--resume", &part]);
            place.same(name, &part);
        }
    }
}

#[test]
fn a_session_that_lost_touches_which_it_had_counted_makes_them_again() {
    let place = Place::new();
    let begin = ["babble", "arms.xml", "--touches", "200", "--learner", "hersch", "--out", "whole"];
    place.succeeds(&begin);
    for touches in [50, 175] {
        let part = format!("part-{touches}");
        let bytes =
            place.log("whole").split_inclusive(|byte| *byte == b'\n').take(101).map(<[u8]>::len).sum();
        cut(&place, "whole", &part, bytes);
        let effort = r#"{"motions": 1, "engine_checks": 1, "bare": 0, "neighbours": 0, "again": 0, "babbling_s": 1.0}"#;
        let kept = format!(
            r#"{{"format": "bodyschema babbling", "version": 1, "bouts": {}, "touches": {touches}, "effort": {effort}}}"#,
            touches / 25
        );
        fs::write(place.path(&part).join("babbling.json"), kept).unwrap();
        let message = place.succeeds(&["babble", "--resume", &part]);
        // 100 touches are there: 50 are gone on after, 175 cannot be.
        let after = if touches == 50 { "after touch 50 of 200" } else { "after touch 0 of 200" };
        assert!(message.contains(after), "{message}");
        assert!(place.log("whole") == place.log(&part));
        let same_effort = place.about("whole")["effort"] == place.about(&part)["effort"];
        assert_eq!(same_effort, touches != 50, "the effort that was kept is what is gone on from");
    }
    let broken = "broken";
    cut(&place, "whole", broken, place.log("whole").len() / 2);
    fs::write(place.path(broken).join("babbling.json"), "{\"format\": \"bodyschema ba").unwrap();
    place.succeeds(&["babble", "--resume", broken]);
    place.same("whole", broken);
}

#[test]
fn a_log_that_ends_in_zeros_after_a_power_failure_is_gone_on_with_from_its_good_lines() {
    let place = Place::new();
    let begin = ["babble", "arms.xml", "--touches", "80", "--learner", "hersch", "--out", "whole"];
    place.succeeds(&begin);
    let log = place.log("whole");
    for (name, bytes, zeros) in [("middle", log.len() / 2, 5000), ("none", 0, 100)] {
        cut(&place, "whole", name, bytes);
        let mut part = place.log(name);
        part.resize(bytes + zeros, 0);
        fs::write(place.path(name).join("touches.jsonl"), &part).unwrap();
        let message = place.succeeds(&["babble", "--resume", name]);
        assert!(message.contains(&format!("{zeros} zero bytes")), "{message}");
        place.same("whole", name);
    }
}

#[test]
fn a_session_that_is_complete_is_left_as_it_is_and_what_is_missing_is_made() {
    let place = Place::new();
    place.succeeds(&["babble", "arms.xml", "--touches", "80", "--learner", "hersch", "--out", "s"]);
    let before = fs::metadata(place.path("s/schema.json")).unwrap().modified().unwrap();
    let message = place.succeeds(&["babble", "--resume", "s"]);
    assert!(message.contains("s is complete"), "{message}");
    assert_eq!(before, fs::metadata(place.path("s/schema.json")).unwrap().modified().unwrap());
    let output = place.run(&["babble", "--resume", "s", "--json"]);
    let told: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!((&told["complete"], &told["touches"]), (&Value::Bool(true), &Value::from(80)));
    let schema = fs::read(place.path("s/schema.json")).unwrap();
    for file in ["report.html", "schema.json"] {
        fs::remove_file(place.path("s").join(file)).unwrap();
    }
    let message = place.succeeds(&["babble", "--resume", "s"]);
    assert!(message.contains("all 80 touches are present"), "{message}");
    assert!(place.path("s/report.html").exists());
    assert!(schema == fs::read(place.path("s/schema.json")).unwrap());
}

#[test]
fn what_cannot_be_gone_on_with_is_told_in_a_sentence_and_nothing_is_lost() {
    let place = Place::new();
    place.succeeds(&["babble", "arms.xml", "--touches", "80", "--learner", "hersch", "--out", "whole"]);
    let half = place.log("whole").len() / 2;

    assert!(place.fails(&["babble", "--resume", "nowhere"]).contains("nowhere: no such folder"));

    // Another touch than the one that is babbled, and more than were asked for.
    cut(&place, "whole", "changed", half);
    let log = String::from_utf8(place.log("changed")).unwrap().replacen("\"motion\":", "\"motion\":9", 1);
    fs::write(place.path("changed/touches.jsonl"), &log).unwrap();
    let message = place.fails(&["babble", "--resume", "changed"]);
    assert!(message.contains("changed/touches.jsonl, line 2:") && message.contains("--out"), "{message}");
    assert_eq!(place.log("changed"), log.as_bytes());

    cut(&place, "whole", "long", place.log("whole").len());
    let mut log = place.log("long");
    log.extend_from_slice(b"{\"more\": 1}\n");
    fs::write(place.path("long/touches.jsonl"), &log).unwrap();
    let message = place.fails(&["babble", "--resume", "long"]);
    assert!(message.contains("line 82") && message.contains("delete"), "{message}");
    assert_eq!(place.log("long"), log);

    // One of a version that wrote its options otherwise.
    cut(&place, "whole", "old", half);
    let path = place.path("old/session.json");
    let mut about: Value = serde_json::from_slice(&fs::read(&path).unwrap()).unwrap();
    assert!(about["options"].as_object_mut().unwrap().remove("asked").is_some());
    fs::write(&path, about.to_string()).unwrap();
    let message = place.fails(&["babble", "--resume", "old"]);
    assert!(
        message.contains("it was written by another version") && message.contains("babble again"),
        "{message}"
    );

    // One that is still at work.
    cut(&place, "whole", "busy", half);
    let held: File = OpenOptions::new().append(true).open(place.path("busy/touches.jsonl")).unwrap();
    held.lock().unwrap();
    let message = place.fails(&["babble", "--resume", "busy"]);
    assert!(message.contains("another process is writing to it"), "{message}");
    drop(held);
    place.succeeds(&["babble", "--resume", "busy"]);

    // A model that has changed.
    cut(&place, "whole", "half", half);
    let arms = fs::read_to_string(place.path("arms.xml")).unwrap();
    fs::write(place.path("arms.xml"), arms.replace("-2.4 2.4", "-2.3 2.4")).unwrap();
    let message = place.fails(&["babble", "--resume", "half"]);
    assert!(message.contains("arms.xml: it has changed"), "{message}");
    assert_eq!(place.log("half"), place.log("whole")[..half]);
}

#[test]
fn options_beside_resume_are_wrong_usage() {
    let place = Place::new();
    for option in [
        &["--touches", "5"][..],
        &["--out", "other"],
        &["arms.xml"],
        &["--joint-noise", "1"],
        &["--root", "big"],
    ] {
        let output = place.run(&[&["babble", "--resume", "s"], option].concat());
        let message = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(2), "{option:?}: {message}");
        assert!(message.contains("cannot be used with") && message.contains("--resume"), "{message}");
    }
}
