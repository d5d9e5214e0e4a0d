//! Growing up: few joints at first, and more as they are known.

use std::path::Path;
use std::process::Command;

use serde_json::Value;

use crate::common::program::{refused, succeeds};
use crate::common::{repository, two_arms};

/// Work that ends a session of two arms before they are known.
const WORK: &str = "0.1";

/// A folder's `arms.xml`, with a grown skin.
fn arms(place: &Path) {
    let trunk = r#"type="capsule" size="0.12 0.2""#;
    let body = two_arms(trunk, r#"type="capsule" size="0.03 0.2""#);
    let bare: Vec<&str> =
        body.lines().filter(|line| !line.contains("<site") && !line.contains("<sensor")).collect();
    std::fs::write(place.join("arms.xml"), bare.join("\n")).unwrap();
}

fn json(place: &Path, arguments: &[&str]) -> Value {
    serde_json::from_str(&succeeds(place, arguments)).unwrap()
}

/// Stages are for what growth can learn from; where they end is theirs, and what stands by default is kept.
#[test]
fn a_body_grows_by_default_where_nothing_stands_against_it() {
    let place = tempfile::tempdir().unwrap();
    arms(place.path());
    let chosen = |more: &[&str]| {
        let out = more.join("_").replace("--", "") + "_";
        let options = [&["babble", "arms.xml", "--out", &out, "--json"][..], more].concat();
        let found = json(place.path(), &options);
        let session = std::fs::read_to_string(place.path().join(&out).join("session.json")).unwrap();
        let session: Value = serde_json::from_str(&session).unwrap();
        let kept = &session["options"]["asked"];
        assert_eq!((&kept["policy"], &kept["learner"]), (&found["policy"], &found["learner"]), "{kept}");
        let name = |key: &str| found[key].as_str().unwrap().to_string();
        (name("policy"), name("learner"), found["touches"].as_u64().unwrap())
    };
    let (policy, learner, touches) = chosen(&[]);
    assert_eq!((&*policy, &*learner), ("stages", "growth"));
    assert!(touches < 1000, "{touches}");
    assert_eq!(chosen(&["--learner", "growth", "--seed", "2"]).0, "stages");
    let (policy, learner, _) = chosen(&["--input", "contact"]);
    assert_eq!((&*policy, &*learner), ("stages", "growth"));
    for other in [
        &["--learner", "lm"][..],
        &["--skin", "centres", "--touches", "60"],
        &["--joint-noise", "0.1", "--touches", "60"],
    ] {
        let (policy, learner, touches) = chosen(other);
        assert_eq!((&*policy, &*learner), ("random", "lm"), "{other:?}");
        assert!(touches == if other.contains(&"--touches") { 60 } else { 1000 }, "{touches}");
    }
    assert_eq!(chosen(&["--policy", "random", "--input", "contact", "--touches", "60"]).1, "lm");
}

/// What a work budget ends ends at the same place on a busy computer and by any number of threads, and that is said.
#[test]
fn a_session_that_work_ended_is_the_same_under_any_load() {
    let place = tempfile::tempdir().unwrap();
    arms(place.path());
    let busy = std::sync::atomic::AtomicBool::new(true);
    let found = std::thread::scope(|scope| {
        let learned = |threads: &str| {
            let out = format!("by{threads}");
            let mut command = Command::new(env!("CARGO_BIN_EXE_bodyschema"));
            command.args(["babble", "arms.xml", "--work", WORK, "--out", &out, "--json"]);
            let output =
                command.current_dir(place.path()).env("RAYON_NUM_THREADS", threads).output().unwrap();
            let found: Value = serde_json::from_slice(&output.stdout).unwrap();
            assert_eq!(found["ended_by"]["babbling"], "work", "{found}");
            assert!(String::from_utf8_lossy(&output.stderr).contains("--work"), "{output:?}");
            let read = |name: &str| std::fs::read(place.path().join(&out).join(name)).unwrap();
            assert!(String::from_utf8(read("report.html")).unwrap().contains("work budget"), "{out}");
            ["schema.json", "touches.jsonl"].map(read)
        };
        let quiet = learned("3");
        for _ in 0..2 {
            scope.spawn(|| {
                while busy.load(std::sync::atomic::Ordering::Relaxed) {
                    std::hint::spin_loop();
                }
            });
        }
        let loaded = learned("1");
        busy.store(false, std::sync::atomic::Ordering::Relaxed);
        [quiet, loaded]
    });
    assert!(found[0] == found[1], "what was learned depends on what else the computer does");
}

/// Noise that the model itself gives its joint sensors is noise as any.
#[test]
fn a_body_whose_own_sensors_are_noisy_is_not_learned_as_if_they_were_exact() {
    let place = tempfile::tempdir().unwrap();
    arms(place.path());
    if !bodyschema::mujoco::schema().unwrap().contains("sensornoise") {
        return;
    }
    let exact = std::fs::read_to_string(place.path().join("arms.xml")).unwrap();
    let sensor = r#"<sensor><jointpos joint="left_elbow_a" noise="0.01"/></sensor>"#;
    let noisy = exact.replace("</mujoco>", &format!("{sensor}</mujoco>"));
    let enabled = noisy.replace("<worldbody>", r#"<option><flag sensornoise="enable"/></option><worldbody>"#);
    for (name, text, policy) in [("idle", noisy, "stages"), ("noisy", enabled, "random")] {
        let file = format!("{name}.xml");
        std::fs::write(place.path().join(&file), text).unwrap();
        let found = json(place.path(), &["babble", &file, "--touches", "60", "--out", name, "--json"]);
        assert_eq!(found["policy"], policy, "{name}");
        assert_eq!(found["learner"], if policy == "stages" { "growth" } else { "lm" }, "{name}");
    }
}

/// In a plane no gap feels to first order what is across it; how round limbs are tells it all the same, but not how a body turns
/// about a line that all of its limbs lie along.
#[test]
fn what_moves_in_a_plane_is_placed_across_it_where_its_limbs_are_round() {
    let place = tempfile::tempdir().unwrap();
    let learned = |body: &str, seed: &str| {
        let model = repository(&format!("mjcf/bodies/{body}.xml"));
        let (model, out) = (model.to_str().unwrap(), format!("{body}-{seed}"));
        json(place.path(), &["babble", model, "--touches", "600", "--seed", seed, "--out", &out, "--json"])
    };
    // Of some touches nothing across the plane is known (seed 2, and two of twelve others).
    let hoppers = ["1", "2", "3", "4"].map(|seed| learned("hopper", seed));
    let known: Vec<&Value> = hoppers.iter().filter(|hopper| hopper["converged"] == true).collect();
    assert!(known.len() >= 3, "{hoppers:?}");
    for hopper in known {
        assert!(hopper["determined_mm"]["max"].as_f64().unwrap() < 0.5, "{hopper}");
        // Where nothing touches the pelvis it may slide along its axes.
        let named = hopper["undetermined_limbs"].as_array().unwrap();
        assert!(named.iter().all(|limb| limb == "pelvis"), "{hopper}");
    }
    let swimmer = learned("swimmer", "2");
    assert_eq!(swimmer["converged"], false, "{swimmer}");
}

/// A fit closes some touches of a joint whatever is wrong with it. That others stay open is to be heard of.
#[test]
fn a_joint_whose_touches_stay_open_is_not_told_of() {
    let place = tempfile::tempdir().unwrap();
    arms(place.path());
    let whole = json(place.path(), &["babble", "arms.xml", "--out", "arms", "--json"]);
    assert_eq!(whole["undetermined"], serde_json::json!([]));
    // Of every third touch the angle of an elbow is another one than it was.
    let log = place.path().join("arms/touches.jsonl");
    let text = std::fs::read_to_string(&log).unwrap();
    let falsified = text.lines().enumerate().map(|(number, line)| {
        let mut touch: Value = serde_json::from_str(line).unwrap();
        if number % 3 == 0 && touch["posture"][2].as_f64().is_some_and(|angle| angle != 0.0) {
            touch["posture"][2] = (0.1 - touch["posture"][2].as_f64().unwrap()).into();
        }
        touch.to_string() + "\n"
    });
    std::fs::write(&log, falsified.collect::<String>()).unwrap();
    let found = json(place.path(), &["learn", "arms", "--json"]);
    assert_eq!(found["learner"], "growth");
    if found["converged"] == true {
        let worst = found["determined_mm"]["max"].as_f64().unwrap_or(0.0);
        assert!(worst < 0.1, "{worst} mm of what is claimed");
        assert!(!found["undetermined"].as_array().unwrap().is_empty(), "{found}");
    }
}

/// The palm of this hand turns in no touch: nothing is known of its axis, and the session is kept all the same.
#[test]
fn a_joint_that_turns_in_no_touch_is_kept_with_an_axis_and_named() {
    let place = tempfile::tempdir().unwrap();
    succeeds(place.path(), &["study", "generate", "--seed", "51512", "--out", "hand.xml"]);
    let found = json(place.path(), &["babble", "hand.xml", "--seed", "51512", "--out", "hand", "--json"]);
    let undetermined = found["undetermined"].as_array().unwrap();
    assert!(undetermined.iter().any(|joint| joint == "palm"), "{undetermined:?}");
    let schema = std::fs::read_to_string(place.path().join("hand/schema.json")).unwrap();
    assert!(schema.contains("palm"));
}

/// It knows its body by the surfaces under its receptors.
#[test]
fn growth_refuses_what_it_cannot_learn_from() {
    let place = tempfile::tempdir().unwrap();
    let arms = two_arms(r#"type="capsule" size="0.12 0.2""#, r#"type="capsule" size="0.03 0.2""#);
    std::fs::write(place.path().join("arms.xml"), arms).unwrap();
    let arguments = ["babble", "arms.xml", "--learner", "growth", "--skin", "centres", "--quiet"];
    let message = refused(place.path(), 1, &arguments);
    assert!(message.contains("leave out --skin") && message.contains("--learner lm"), "{message}");
}

/// Joints that hardly open gaps close them slowly: fits of this body's are to be brought to their end.
#[test]
fn joints_that_touches_hardly_feel_are_learned_as_well() {
    let place = tempfile::tempdir().unwrap();
    let seed = "110012";
    succeeds(place.path(), &["study", "generate", "--seed", seed, "--out", "body.xml"]);
    let motions = ["babble", "body.xml", "--policy", "random", "--touches", "1000", "--seed", seed];
    let found = json(place.path(), &[&motions[..], &["--learner", "growth", "--json"]].concat());
    assert_eq!(found["undetermined"], serde_json::json!([]), "{}", found["verdict"]);
    let worst = found["determined_mm"]["max"].as_f64().unwrap();
    assert!(worst < 0.1, "{worst} mm of what is claimed");
}

mod slow {
    use serde_json::Value;

    use crate::common::program::succeeds;

    /// Its 15 joints are learned from a few touches each; it ends before it has made all that it might.
    #[test]
    #[ignore = "slow: 10 s"]
    fn a_body_grows_from_its_trunk_and_claims_nothing_wrong() {
        let model = concat!(env!("CARGO_MANIFEST_DIR"), "/mjcf/fourarms/fourarms.xml");
        let place = tempfile::tempdir().unwrap();
        for seed in ["21", "22"] {
            let arguments =
                ["babble", model, "--policy", "stages", "--learner", "growth", "--touches", "1500"];
            let more = ["--seed", seed, "--out", seed, "--json"];
            let found: Value =
                serde_json::from_str(&succeeds(place.path(), &[&arguments[..], &more].concat())).unwrap();
            assert_eq!(found["converged"], true);
            assert!(found["undetermined"].as_array().unwrap().len() <= 3, "{}", found["undetermined"]);
            let worst = found["determined_mm"]["max"].as_f64().unwrap();
            assert!(worst < 0.1, "{worst} mm of what is claimed");
            // A session that ended early is whole, and what was learned on the way is what its log tells.
            let schema = || std::fs::read(place.path().join(seed).join("schema.json")).unwrap();
            let on_the_way = schema();
            succeeds(place.path(), &["babble", "--resume", seed]);
            assert!(schema() == on_the_way, "learned again from the log, the schema is another");
        }
    }
}
