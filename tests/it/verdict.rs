//! One verdict everywhere: what terminal, JSON and page say of a session never contradicts itself.

use std::fs;
use std::path::Path;

use crate::common::program::succeeds;
use crate::common::{repository, two_arms};
use serde_json::Value;

/// Sessions of every kind: learned, partly, not, not judged, in noise, from centres and points, of several creatures.
const SESSIONS: [(&str, &str); 12] = [
    ("arms.xml", "--input contact --touches 200"),
    ("arms.xml", "--policy random --touches 300 --skin centres"),
    ("arms.xml", "--policy random --touches 300 --receptor-noise 3"),
    ("arms.xml", "--policy random --touches 300 --joint-noise 0.5"),
    ("arms.xml", "--touches 12 --policy random"),
    ("arms.xml", "--touches 100 --learner hersch"),
    ("arms.xml", "--touches 200 --input contact --frames limb --seed 3"),
    ("mjcf/hexapod/hexapod.xml", "--input contact --policy random --touches 120"),
    ("mjcf/hexapod/hexapod.xml", "--policy random --touches 60"),
    ("mjcf/contraption/contraption.xml", "--input contact --policy random --touches 300"),
    ("mjcf/fourarms/fourarms.xml", "--touches 120 --learner hersch"),
    ("mjcf/octopus/octopus.xml", "--input contact --policy random --touches 250"),
];

fn json(place: &Path, arguments: &[&str]) -> Value {
    serde_json::from_str(&succeeds(place, arguments)).unwrap()
}

/// The text between two words of a page or of what a terminal shows.
fn between<'t>(text: &'t str, from: &str, to: &str) -> Option<&'t str> {
    Some(text.split_once(from)?.1.split_once(to)?.0)
}

/// Names in a row, as terminals show them.
fn listed(names: &Value) -> String {
    let names: Vec<&str> = names.as_array().unwrap().iter().map(|name| name.as_str().unwrap()).collect();
    match names.len() {
        0 => "none".into(),
        n if n <= 8 => names.join(", "),
        n => format!("{} and {} more", names[..8].join(", "), n - 8),
    }
}

fn escaped(text: &str) -> String {
    text.replace('&', "&amp;")
        .replace('<', "&lt;")
        .replace('>', "&gt;")
        .replace('"', "&quot;")
        .replace('\'', "&#39;")
}

/// Whether a page shows a number of millimetres, to the digits that it shows.
fn shows(shown: &str, millimetres: f64) -> bool {
    match shown.strip_prefix("&lt; ") {
        Some(least) => millimetres < least.parse().unwrap(),
        None => (shown.parse::<f64>().unwrap() - millimetres).abs() <= 0.01 * millimetres + 5.1e-4,
    }
}

/// Whether two measures are equal but for what writing a turn down rounds, in mm and degrees.
fn same(a: &Value, b: &Value) -> bool {
    match (a, b) {
        (Value::Object(a), Value::Object(b)) => a.iter().all(|(key, value)| same(value, &b[key])),
        (Value::Number(a), Value::Number(b)) => (a.as_f64().unwrap() - b.as_f64().unwrap()).abs() < 1e-9,
        _ => a == b,
    }
}

fn one_verdict(place: &Path, number: usize) -> Value {
    let (model, options) = SESSIONS[number];
    let session = format!("s{number}");
    let model = if model.contains('/') { repository(model).display().to_string() } else { model.to_string() };
    let mut babble = vec!["babble", &model, "--json", "--out", &session];
    babble.extend(options.split(' '));
    let babbled = json(place, &babble);
    let what = format!("{model} {options}");
    let reported = json(place, &["report", &session, "--json"]);
    let in_all = [
        "converged",
        "reason",
        "verdict",
        "located_limbs",
        "limbs_with_skin",
        "undetermined",
        "undetermined_limbs",
        "touches",
    ];
    for key in in_all {
        assert!(babbled.get(key).is_some(), "{what}: no {key}");
        assert_eq!(babbled[key], reported[key], "{what}: {key} of report");
    }
    for key in ["heldout_mm", "determined_mm", "hand_mm", "axis_deg", "axis_line_mm", "bound_mm"] {
        assert!(same(&babbled[key], &reported[key]), "{what}: {key}: {} and {}", babbled[key], reported[key]);
    }
    let converged = babbled["converged"].as_bool().unwrap();
    let verdict = babbled["verdict"].as_str().unwrap();
    let joints = if converged {
        listed(&babbled["undetermined"])
    } else {
        "all (no held-out touches confirm the schema)".into()
    };
    let page = fs::read_to_string(place.join(&session).join("report.html")).unwrap();
    let shown = succeeds(place, &["report", &session]);
    assert!(shown.contains(verdict), "{what}: {shown}");
    assert_eq!(between(&shown, "undetermined joints: ", "\n").unwrap(), joints, "{what}");
    assert!(page.contains(&escaped(verdict)), "{what}: the page");

    // The number on the page is that of JSON: of located limbs where there are any, else of all.
    let shown = between(&page, "<strong>", " mm</strong>").unwrap();
    let of = if converged { "determined_mm" } else { "heldout_mm" };
    assert!(shows(shown, babbled[of]["mean"].as_f64().unwrap()), "{what}: {shown}, {}", babbled[of]);
    let limbs = reported["limbs"].as_array().unwrap();
    if !converged {
        // Nothing is bounded near a schema that may be wrong.
        assert_eq!(
            babbled["undetermined"].as_array().unwrap().len(),
            babbled["joints"].as_u64().unwrap() as usize,
            "{what}"
        );
        assert!(babbled["determined_mm"]["mean"].is_null() && babbled["bound_mm"].is_null(), "{what}");
        assert!(limbs.iter().all(|limb| limb.get("worst_mm").is_none()), "{what}");
        assert!(!page.contains("class=\"limbs\"") && !page.contains("No joint is undetermined"), "{what}");
        assert!(
            !fs::read_to_string(place.join(&session).join("schema.json")).unwrap().contains("_std"),
            "{what}"
        );
        return babbled;
    }
    let located = limbs.iter().filter(|limb| limb["open"].is_null()).count();
    assert_eq!(babbled["located_limbs"], located, "{what}");
    assert!(page.contains(&format!(">{located} of {} limbs located<", limbs.len())), "{what}");
    for limb in limbs {
        let never = limb["open"] == "never touched";
        assert_eq!(never, limb["touches"] == 0 && !limb["open"].is_null(), "{what}: {limb}");
        assert!(limb["supporting_touches"].as_u64() <= limb["touches"].as_u64(), "{what}: {limb}");
    }
    // Bounds of exact touches say what they assume, and nothing is drawn as the least error that there could be.
    let at_floor = &babbled["bound_mm"]["at_floor"];
    assert_eq!(at_floor.as_bool().unwrap(), reported["bounds_note"].is_string(), "{what}");
    let record = fs::read_to_string(place.join(&session).join("learning.json")).unwrap();
    if at_floor.as_bool().unwrap() {
        assert!(!record.contains("bound_rms_mm") && !page.contains("Cramér-Rao bound"), "{what}");
    }
    babbled
}

#[test]
fn terminal_json_and_page_never_contradict_one_another() {
    let place = tempfile::tempdir().unwrap();
    let arms = two_arms(r#"type="capsule" size="0.12 0.2""#, r#"type="capsule" size="0.03 0.2""#);
    fs::write(place.path().join("arms.xml"), arms).unwrap();
    let place = place.path();
    let halves = [0, 1].map(|half| (half..SESSIONS.len()).step_by(2));
    let said: Vec<Value> = std::thread::scope(|scope| {
        let of = |half: std::iter::StepBy<std::ops::Range<usize>>| {
            scope.spawn(move || half.map(|number| one_verdict(place, number)).collect::<Vec<_>>())
        };
        halves.map(of).into_iter().flat_map(|half| half.join().unwrap()).collect()
    });
    // All kinds of verdicts are among them.
    for begin in ["Learned: ", "Partly learned: ", "NOT learned: ", "Not judged: "] {
        let is = |said: &&Value| said["verdict"].as_str().unwrap().starts_with(begin);
        assert!(
            said.iter().any(|said| is(&said)),
            "{begin} {:?}",
            said.iter().map(|s| &s["verdict"]).collect::<Vec<_>>()
        );
    }
}
