//! Studies and disturbances as a user meets them: what they print, what they save, and what they refuse.

use std::fs;
use std::path::Path;

use crate::common::program::{refused, succeeds};
use crate::common::two_arms;
use serde_json::Value;
use tempfile::TempDir;

/// A folder with a small creature in it, in which commands run.
fn place() -> TempDir {
    let place = tempfile::tempdir().unwrap();
    let arms = two_arms(r#"type="capsule" size="0.12 0.2""#, r#"type="capsule" size="0.03 0.2""#);
    fs::write(place.path().join("arms.xml"), arms).unwrap();
    place
}

/// A folder with an upper arm on a trunk and a forearm on it, of which the kinematics is soon learned.
fn pincer() -> TempDir {
    let limb = |name: &str, within: &str| {
        format!(
            r#"{within}<geom type="capsule" fromto="0 0 0 0.3 0 0" size="0.03"/>
            <site name="{name}_r" type="box" size="0.4 0.4 0.4"/>"#
        )
    };
    let [shoulder, elbow] = [
        r#"<joint name="turn" axis="0 0 1" range="-3 3"/><joint name="tilt" axis="0.3 1 0" range="-2.6 2.6"/>"#,
        r#"<joint name="bend" axis="0 0 1" range="-3 3"/>"#,
    ];
    let pincer = format!(
        r#"<mujoco model="pincer"><compiler angle="radian" autolimits="true"/><worldbody><body name="trunk">{}
        <body name="upper" pos="0.3 0 0">{}<body name="fore" pos="0.3 0 0">{}</body></body></body></worldbody>
        <sensor><touch site="trunk_r"/><touch site="upper_r"/><touch site="fore_r"/></sensor></mujoco>"#,
        limb("trunk", ""),
        limb("upper", shoulder),
        limb("fore", elbow)
    );
    let place = tempfile::tempdir().unwrap();
    fs::write(place.path().join("pincer.xml"), pincer).unwrap();
    place
}

fn json(place: &Path, arguments: &[&str]) -> Value {
    let text = succeeds(place, arguments);
    serde_json::from_str(&text).unwrap_or_else(|error| panic!("{error}: {text}"))
}

#[test]
fn a_study_prints_one_json_object_with_its_seeds_and_saves_its_files() {
    let place = place();
    let arguments =
        ["study", "learners", "arms.xml", "--trials", "2", "--seed", "5", "--touches", "60", "--json"];
    let found = json(place.path(), &arguments);
    assert_eq!(found["seeds"], serde_json::json!([5, 6]));
    assert_eq!((&found["options"]["touches"], &found["options"]["trials"]), (&60.into(), &2.into()));
    let summary = found["summary"].as_array().unwrap();
    let learners: Vec<&str> = summary.iter().map(|row| row["learner"].as_str().unwrap()).collect();
    assert_eq!(learners, ["hersch", "lm --skin centres", "lm"]);
    assert!(summary.iter().all(|row| row["trials"] == 2 && row["heldout_mm"].is_number()), "{summary:?}");
    let rows = found["rows"].as_array().unwrap();
    assert_eq!(rows.len(), 6, "three learners in two trials, each after all touches");
    assert!(rows.iter().all(|row| row["heldout_mm"].is_number() && row["touches"] == 60));
    let folder = place.path().join("studies/learners");
    let saved = fs::read_to_string(folder.join("study.json")).unwrap();
    assert_eq!(serde_json::from_str::<Value>(&saved).unwrap(), found);
    let csv = fs::read_to_string(folder.join("study.csv")).unwrap();
    assert_eq!(csv.lines().count(), 7, "{csv}");
    assert!(csv.starts_with("learner,touches,seed,heldout_mm,"), "{csv}");
    assert_eq!(fs::read_dir(&folder).unwrap().count(), 2, "trials are left beside what they came to");
}

/// Holds what two trials left together against what each of them left alone, on other numbers of threads: the same, to the byte.
fn is_the_same_alone(study: &str, touches: &str) {
    let place = pincer();
    let table = |out: &str, seed: &str, trials: &str, jobs: &str| {
        let arguments = ["study", study, "pincer.xml", "--touches", touches, "--out", out, "--seed", seed];
        succeeds(place.path(), &[&arguments[..], &["--trials", trials, "--jobs", jobs]].concat());
        fs::read_to_string(place.path().join(out).join("study.csv")).unwrap()
    };
    let [one, other] = [table("one", "4", "1", "1"), table("other", "5", "1", "2")];
    let (_, rows) = other.split_once('\n').unwrap();
    assert!(!rows.is_empty(), "{study}: {other}");
    assert_eq!(table("both", "4", "2", "2"), one + rows, "{study}");
}

#[test]
fn a_trial_is_the_same_whatever_was_tried_before() {
    is_the_same_alone("hersch", "20");
}

#[test]
fn a_study_never_overwrites_another() {
    let place = place();
    let arguments = ["study", "learners", "arms.xml", "--trials", "1", "--touches", "12"];
    for folder in ["studies/learners", "studies/learners-2"] {
        let text = succeeds(place.path(), &arguments);
        assert!(text.contains("seeds 1") && text.contains("12 touches") && text.contains(folder), "{text}");
        assert!(place.path().join(folder).join("study.csv").is_file());
    }
    let out = [&arguments[..], &["--out", "studies/learners"]].concat();
    let message = refused(place.path(), 1, &out);
    assert!(message.contains("already") && message.contains("--out"), "{message}");
    let forced = [&out[..], &["--force", "--seed", "9", "--json"]].concat();
    assert_eq!(json(place.path(), &forced)["seeds"], serde_json::json!([9]));
}

#[test]
fn a_study_that_was_interrupted_goes_on_with_the_trials_that_are_missing() {
    let place = place();
    let arguments = ["study", "learners", "arms.xml", "--trials", "3", "--touches", "12", "--shard", "1/1"];
    succeeds(place.path(), &[&arguments[..], &["--out", "share"]].concat());
    // As a process leaves it that was killed before its last trial.
    let [begun, share] = ["studies/learners", "share/shares/1-of-1"].map(|folder| place.path().join(folder));
    fs::create_dir_all(&begun).unwrap();
    fs::rename(share, begun.join(".trials")).unwrap();
    fs::remove_file(begun.join(".trials/trials/2.json")).unwrap();
    let kept = fs::metadata(begun.join(".trials/trials/1.json")).unwrap().modified().unwrap();
    let other = [&arguments[..6], &["13"]].concat();
    let told = succeeds(place.path(), &other);
    assert!(
        told.contains("studies/learners-2"),
        "what is begun in the first folder is another study: {told}"
    );
    assert_eq!(fs::metadata(begun.join(".trials/trials/1.json")).unwrap().modified().unwrap(), kept);
    let message = refused(place.path(), 1, &[&other[..], &["--out", "studies/learners"]].concat());
    assert!(message.contains("touches is 12 in one, 13 in the other"), "{message}");
    let told = succeeds(place.path(), &arguments[..7]);
    assert!(told.trim_end().ends_with("were written to studies/learners"), "{told}");
    assert!(begun.join("study.csv").is_file() && !begun.join(".trials").exists());
}

#[test]
fn a_study_of_disturbances_compares_all_with_none() {
    let place = pincer();
    let arguments = ["study", "disturbances", "pincer.xml", "--trials", "1", "--touches", "40", "--json"];
    let found = json(place.path(), &[&arguments[..], &["--out", "here"]].concat());
    let summary = found["summary"].as_array().unwrap();
    assert_eq!((&summary[0]["disturbances"], summary.len()), (&"none".into(), 11));
    let together = summary[10]["disturbances"].as_str().unwrap();
    assert_eq!(together, "joint noise 0.1°, receptor noise 1 mm, false touches 5 %");
}

#[test]
fn a_study_of_herschs_rule_compares_what_it_is_given() {
    let place = pincer();
    let arguments =
        ["study", "hersch", "pincer.xml", "--trials", "2", "--seed", "2", "--touches", "60", "--json"];
    let found = json(place.path(), &arguments);
    let summary = found["summary"].as_array().unwrap();
    assert_eq!(summary.len(), 4 * 6 + 4 * 6, "four inputs, six initial guesses; four variants of the rule");
    let rows = found["rows"].as_array().unwrap();
    assert_eq!(rows.len(), 2 * summary.len());
    assert!(rows.iter().all(|row| row["heldout_mm"].is_number() && row["touches"] == 60));
    let of = |rule: &str, guess: &str| -> Vec<&Value> {
        let exact = |row: &&Value| row["given"] == "touch, exact points" && row["rule"] == rule;
        rows.iter().filter(|row| row["initial_guess"] == guess).filter(exact).collect()
    };
    // Where joints are far off in a guess is chance, how far their axes are is not.
    let before = |guess: &str| {
        of("20 passes", guess).iter().map(|row| row["before_mm"].as_f64().unwrap()).sum::<f64>()
    };
    assert!(before("30°") < before("90°"));
    for (near, far) in of("20 passes", "30°").into_iter().zip(of("20 passes", "90°")) {
        assert!(near["heldout_mm"].as_f64() < near["before_mm"].as_f64(), "{near}");
        assert!(near["heldout_mm"].as_f64() < far["heldout_mm"].as_f64(), "{near} {far}");
    }
    for (whole, once) in of("20 passes", "30°").into_iter().zip(of("1 pass", "30°")) {
        assert!(whole["heldout_mm"].as_f64() < once["heldout_mm"].as_f64(), "{whole} {once}");
    }
    // Some of its cases alone.
    let some =
        [&arguments[..], &["--case", "one way", "--case", "vision, any limbs / random / 20 passes"]].concat();
    let some = json(place.path(), &some);
    let alone = some["rows"].as_array().unwrap();
    assert_eq!(alone.len(), 2 * (6 + 1));
    assert!(alone.iter().all(|row| rows.contains(row)), "cases change each other");
}

#[test]
fn acting_by_what_was_learned_is_held_against_acting_by_the_truth() {
    let place = tempfile::tempdir().unwrap();
    let max = crate::common::repository("mjcf/max/max.xml");
    let session = crate::common::sessions::max().join("max");
    let arguments = ["study", "acting", max.to_str().unwrap(), "--session", session.to_str().unwrap()];
    let cases = ["--case", "avoid", "--trials", "2", "--seed", "4", "--json"];
    let found = json(place.path(), &[&arguments[..], &cases].concat());
    let rows = found["rows"].as_array().unwrap();
    assert_eq!(rows.len(), 4, "two creatures in each of two trials");
    for (row, schema) in rows.iter().zip(["learned", "true"].into_iter().cycle()) {
        assert_eq!((&row["task"], &row["schema"]), (&"avoid".into(), &schema.into()), "{row}");
        assert_eq!(row["done"].as_bool(), Some(row["result"] == "avoided"), "{row}");
        assert!(row["others_still"].is_boolean() && row["unintended"].is_boolean(), "{row}");
    }
    let message = refused(place.path(), 1, &[&arguments[..], &["--joints", "all"]].concat());
    assert!(message.contains("other joints"), "{message}");
}

#[test]
fn the_verdict_on_made_robots_is_right() {
    let place = tempfile::tempdir().unwrap();
    let cases = ["--case", "plate/none", "--case", "plate/sign", "--json"];
    let found =
        json(place.path(), &[&["study", "calibration", "--trials", "1", "--seed", "3"][..], &cases].concat());
    let summary = found["summary"].as_array().unwrap();
    let of = |case: &str| summary.iter().find(|row| row["case"] == case).unwrap();
    assert_eq!((&of("none")["calibrated"], &of("sign")["calibrated"]), (&1.into(), &0.into()));
    assert_eq!(
        (&of("all")["falsely_calibrated"], &of("all")["falsely_not_calibrated"]),
        (&0.into(), &0.into())
    );
}

#[test]
fn wrong_usage_of_a_study_is_told_in_a_sentence() {
    let place = place();
    for (study, wrong, word) in [
        ("learners", ["--seconds", "3"], "--seconds"),
        ("learners", ["--session", "s"], "--session"),
        ("learners", ["--case", "aristotle"], "hersch"),
        ("bodies", ["--joints", "all"], "--joints"),
    ] {
        let model = if study == "bodies" { &[][..] } else { &["arms.xml"] };
        let message = refused(place.path(), 1, &[&["study", study][..], model, &wrong].concat());
        assert!(message.contains(word) && message.contains(study), "{message}");
    }
    let message = refused(place.path(), 2, &["study", "astrology", "arms.xml"]);
    for word in ["astrology", "learners", "disturbances"] {
        assert!(message.contains(word), "no \"{word}\" in: {message}");
    }
    let message = refused(place.path(), 1, &["study", "learners"]);
    assert!(message.contains("mjcf/max/max.xml") && message.contains("MODEL"), "{message}");
    refused(place.path(), 1, &["study", "learners", "missing.xml"]);
    refused(place.path(), 2, &["study", "learners", "arms.xml", "--trials", "0"]);
    refused(
        place.path(),
        1,
        &["study", "learners", "arms.xml", "--trials", "2", "--seed", "18446744073709551615"],
    );
    assert!(!place.path().join("studies").exists(), "wrong usage left a study");
    for (old, new) in [("merge", "study merge"), ("generate", "study generate"), ("gallery", "study gallery")]
    {
        let message = refused(place.path(), 2, &[old, "arms.xml"]);
        assert!(message.contains(&format!("bodyschema {new}")), "{message}");
    }
}

#[test]
fn learning_from_disturbed_touches_says_what_that_cost_and_leaves_the_log_exact() {
    let place = pincer();
    let exact = ["babble", "pincer.xml", "--touches", "80", "--input", "contact", "--json"];
    let noise = ["--joint-noise", "0.2", "--receptor-noise", "1", "--false-touches", "0.02"];
    let undisturbed = json(place.path(), &[&exact[..], &["--out", "exact"]].concat());
    assert!(undisturbed["undisturbed_heldout_mm"].is_null());
    assert_eq!(undisturbed["disturbances"]["joint_noise_deg"], 0.0);
    let disturbed = json(place.path(), &[&exact[..], &noise, &["--out", "disturbed"]].concat());
    assert_eq!(disturbed["disturbances"]["receptor_noise_mm"], 1.0);
    assert_eq!(disturbed["undisturbed_heldout_mm"], undisturbed["heldout_mm"]);
    let mean = |found: &Value| found["heldout_mm"]["mean"].as_f64().unwrap();
    assert!(mean(&disturbed) > 100.0 * mean(&undisturbed), "{disturbed}");
    let log = |folder: &str| fs::read(place.path().join(folder).join("touches.jsonl")).unwrap();
    assert!(log("exact") == log("disturbed"));
    let text = succeeds(place.path(), &["learn", "exact", "--learner", "hersch", "--joint-noise", "1"]);
    assert!(text.contains("without the disturbances: ") && text.contains("joint noise 1°"), "{text}");
    for wrong in [["--joint-noise", "nan"], ["--receptor-noise=-1", "--json"], ["--false-touches", "1"]] {
        refused(place.path(), 2, &[&["learn", "exact"][..], &wrong].concat());
    }
}

mod slow {
    use super::*;

    #[test]
    #[ignore = "slow: learners begin again and again"]
    fn a_trial_of_learners_and_of_disturbances_is_the_same_whatever_was_tried_before() {
        is_the_same_alone("learners", "24");
        is_the_same_alone("disturbances", "100");
    }
}

mod large {
    use super::*;

    #[test]
    #[ignore = "large: all tasks of acting"]
    fn max_does_every_task_by_what_he_has_learned() {
        let place = tempfile::tempdir().unwrap();
        let max = crate::common::repository("mjcf/max/max.xml");
        let session = crate::common::sessions::max().join("max");
        let arguments = ["study", "acting", max.to_str().unwrap(), "--session", session.to_str().unwrap()];
        let found =
            json(place.path(), &[&arguments[..], &["--trials", "2", "--seed", "9101", "--json"]].concat());
        let summary = found["summary"].as_array().unwrap();
        let tasks: Vec<&str> = summary.iter().map(|row| row["task"].as_str().unwrap()).collect();
        for task in [
            "other hand, table",
            "other hand, air",
            "farthest, upright",
            "farthest, leaning",
            "find",
            "avoid",
        ] {
            assert!(tasks.contains(&task), "{task} of {tasks:?}");
        }
        for row in summary.iter().filter(|row| row["schema"] == "learned") {
            assert!(row["done"].as_f64() >= Some(0.5), "{row}");
        }
    }
}
