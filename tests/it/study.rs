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
    assert_eq!(learners, ["hersch", "gradient", "lm --skin centres", "lm"]);
    let rows = found["rows"].as_array().unwrap();
    assert_eq!(rows.len(), 8, "four learners in two trials, each after all touches");
    assert!(rows.iter().all(|row| row["heldout_mm"].is_number() && row["touches"] == 60));
    let folder = place.path().join("studies/learners");
    let saved = fs::read_to_string(folder.join("study.json")).unwrap();
    assert_eq!(serde_json::from_str::<Value>(&saved).unwrap(), found);
    let csv = fs::read_to_string(folder.join("study.csv")).unwrap();
    assert_eq!(csv.lines().count(), 9, "{csv}");
    assert!(csv.starts_with("learner,seed,touches,heldout_mm,"), "{csv}");
    let svg = fs::read_to_string(folder.join("study.svg")).unwrap();
    assert!(svg.starts_with("<svg") && svg.contains("gradient"), "{svg}");
}

/// Holds what two trials left together against what each of them left alone: the same, to the byte.
fn is_the_same_alone(study: &str, touches: &str) {
    let place = pincer();
    let table = |out: &str, seed: &str, trials: &str, jobs: &str| {
        let arguments = ["study", study, "pincer.xml", "--touches", touches, "--out", out, "--seed", seed];
        succeeds(place.path(), &[&arguments[..], &["--trials", trials, "--jobs", jobs]].concat());
        fs::read_to_string(place.path().join(out).join("study.csv")).unwrap()
    };
    let [one, other] = [table("one", "4", "1", "1"), table("other", "5", "1", "2")];
    let (names, rows) = other.split_once('\n').unwrap();
    assert!(!rows.is_empty(), "{study}: {other}");
    assert_eq!(table("both", "4", "2", "1"), one + rows, "{study}");
    // How long something took is no other's.
    let timed = ["seconds", "babbling_s", "learning_s"];
    assert!(!names.split(',').any(|name| timed.contains(&name)), "{study}: {names}");
}

#[test]
fn a_trial_is_the_same_whatever_was_tried_before() {
    for (study, touches) in [("policies", "30"), ("hersch", "20")] {
        is_the_same_alone(study, touches);
    }
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
}

#[test]
fn a_study_of_disturbances_compares_all_with_none() {
    let place = pincer();
    let arguments = ["study", "disturbances", "pincer.xml", "--trials", "1", "--touches", "40", "--json"];
    let found = json(place.path(), &[&arguments[..], &["--out", "here"]].concat());
    let summary = found["summary"].as_array().unwrap();
    assert_eq!((&summary[0]["disturbances"], &summary[0]["factor"]), (&"none".into(), &1.0.into()));
    assert_eq!(summary.len(), 11);
    let together = summary[10]["disturbances"].as_str().unwrap();
    assert_eq!(together, "joint noise 0.1°, receptor noise 1 mm, false touches 5 %");
    assert!(place.path().join("here/study.svg").is_file());
}

#[test]
fn a_study_of_policies_relates_all_to_random() {
    let place = place();
    let arguments = ["study", "policies", "arms.xml", "--trials", "1", "--touches", "40", "--json"];
    let found = json(place.path(), &[&arguments[..], &["--out", "here"]].concat());
    let summary = found["summary"].as_array().unwrap();
    let policies: Vec<&str> = summary.iter().map(|row| row["policy"].as_str().unwrap()).collect();
    assert_eq!(policies, ["random", "stages"]);
    let rows = found["rows"].as_array().unwrap();
    assert_eq!(rows.len(), 2, "forty touches are learned from once");
    assert!(rows.iter().all(|row| row["motions"].as_u64() >= Some(40)));
    assert!(place.path().join("here/study.svg").is_file());
}

#[test]
fn a_study_of_herschs_rule_compares_what_it_is_told() {
    let place = pincer();
    let arguments = [
        "study",
        "hersch",
        "pincer.xml",
        "--trials",
        "2",
        "--seed",
        "2",
        "--touches",
        "60",
        "--passes",
        "3",
        "--json",
    ];
    let found =
        json(place.path(), &[&arguments[..], &["--single", "--step", "0.1", "--out", "here"]].concat());
    let summary = found["summary"].as_array().unwrap();
    assert_eq!(summary.len(), 4 * 6 * 2, "four kinds of telling, six initial guesses, two uses");
    assert_eq!(found["rule"], serde_json::json!({"passes": 3, "step": 0.1, "stop_mm": 0.0, "single": true}));
    let rows = found["rows"].as_array().unwrap();
    assert_eq!(rows.len(), 2 * summary.len());
    assert!(rows.iter().all(|row| row["heldout_mm"].is_number() && row["touches"] == 60));
    let of = |guess: &str| -> Vec<&Value> {
        let first = |row: &&Value| row["told"] == "touch, exact points" && row["used"] == "both ways";
        rows.iter().filter(|row| row["initial_guess"] == guess).filter(first).collect()
    };
    for (near, far) in of("30°").into_iter().zip(of("90°")) {
        assert!(near["before_mm"].as_f64() < far["before_mm"].as_f64(), "{near} {far}");
        assert!(near["heldout_mm"].as_f64() < near["before_mm"].as_f64(), "{near}");
    }
    let again = json(place.path(), &[&arguments[..], &["--single", "--step", "0.1", "--jobs", "1"]].concat());
    assert_eq!(again["rows"], found["rows"]);
    let ended = json(place.path(), &[&arguments[..], &["--stop", "100000"]].concat());
    assert_eq!(ended["summary"].as_array().unwrap().len(), 4 * 6);
    for (row, whole) in ended["rows"].as_array().unwrap().iter().zip(rows.iter().step_by(2)) {
        // Its first touch ends it, so it is hardly anywhere else than where it began.
        assert_eq!(row["before_mm"], whole["before_mm"]);
        let [left, began] = ["heldout_mm", "before_mm"].map(|column| row[column].as_f64().unwrap());
        assert!((left - began).abs() < 0.2 * began, "{row}");
    }
    assert!(fs::read_to_string(place.path().join("here/study.svg")).unwrap().contains("vision"));
}

#[test]
fn wrong_usage_of_a_study_is_told_in_a_sentence() {
    let place = place();
    for wrong in [["--passes", "3"], ["--step", "0.1"], ["--stop", "1"], ["--single", "--json"]] {
        let message = refused(place.path(), 1, &[&["study", "learners", "arms.xml"][..], &wrong].concat());
        assert!(message.contains("--passes") && message.contains("hersch"), "{message}");
    }
    for wrong in [["--passes", "0"], ["--step", "0"], ["--step", "nan"], ["--stop=-1", "--json"]] {
        refused(place.path(), 2, &[&["study", "hersch", "arms.xml"][..], &wrong].concat());
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

#[test]
fn what_touches_itself_is_never_taken_for_what_is_touched() {
    let place = tempfile::tempdir().unwrap();
    let max = crate::common::repository("mjcf/max/max.xml");
    let arguments = ["study", "self-touch", max.to_str().unwrap(), "--trials", "9", "--seed", "9", "--json"];
    let found = json(place.path(), &arguments);
    assert_eq!((&found["trials"], &found["named_wrongly"]), (&9.into(), &0.into()));
    let done: usize =
        found["summary"].as_array().unwrap().iter().map(|row| row["trials"].as_u64().unwrap() as usize).sum();
    assert_eq!(done, 9);
    for (done, told) in [("self", "other"), ("other", "self")] {
        assert_eq!(found["confusion"][done][told], 0, "{}", found["confusion"]);
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

    #[test]
    #[ignore = "slow: Max grows and holds things"]
    fn a_body_that_grows_and_one_that_holds_a_stick_are_known_again() {
        let place = tempfile::tempdir().unwrap();
        let max = crate::common::repository("mjcf/max/max.xml");
        let model = max.to_str().unwrap();
        let arguments =
            ["study", "growth", model, "--trials", "1", "--seed", "9", "--touches", "600", "--json"];
        let found = json(place.path(), &arguments);
        for row in found["summary"].as_array().unwrap() {
            assert_eq!(row["known_again"], 1.0, "{row}");
            assert!(row["touches_to_twice"].as_f64().unwrap() <= 60.0, "{row}");
            assert!(row["error_at_change_mm"].as_f64().unwrap() > 1.0, "{row}");
        }
    }
}

#[test]
fn claims_are_held_against_the_truth_over_creatures_inputs_counts_and_noises() {
    let place = place();
    fs::copy(pincer().path().join("pincer.xml"), place.path().join("pincer.xml")).unwrap();
    let arguments =
        ["study", "claims", "arms.xml", "pincer.xml", "--trials", "1", "--seed", "1001", "--json"];
    let found = json(place.path(), &arguments);
    let rows = found["rows"].as_array().unwrap();
    // Two inputs, each with four counts of touches without noise and five noises, and four ends of growing by stages.
    assert_eq!(rows.len(), 2 * (2 * (4 + 5) + 4));
    assert_eq!(found["sessions"], rows.len());
    let all = found["summary"].as_array().unwrap().last().unwrap();
    assert_eq!((&all["creature"], &all["sessions"]), (&"all".into(), &rows.len().into()));
    assert!(all["claims"].as_u64().unwrap() > 0, "{all}");
    let told = |row: &&Value| row["verdict"] == "not learned";
    assert!(rows.iter().filter(told).all(|row| row["claims"] == 0 && row["reason"] != ""), "{rows:?}");
    assert_eq!(found["wrong_claims"], 0, "{:?}", found["notes"]);
    assert_eq!(all["false_changes"], 0);
    refused(place.path(), 1, &["study", "policies", "arms.xml", "pincer.xml"]);
}
