//! Units in JSON and tables: a number is in SI, or its name ends in its unit, or that of the group that it is in; and one
//! object has one unit for one measure.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::Path;

use crate::common::program::succeeds;
use crate::common::{repository, sessions, two_arms};
use serde_json::Value;

/// What names end in that are not of the SI, by what they measure.
const SUFFIXES: [(&str, &str); 9] = [
    ("_mm", "length"),
    ("_deg", "angle"),
    ("_l", "volume"),
    ("_percent", "share"),
    // Of the SI, and named all the same.
    ("_m", "length"),
    ("_s", "time"),
    ("_n", "force"),
    ("_kg", "mass"),
    ("_m_s", "speed"),
];
/// What a number of a group may be called that is in the group's unit …
const STATISTICS: [&str; 8] = ["mean", "median", "p95", "max", "rms", "bound_rms", "error_rms", "ratio"];
/// … and what it may be called that has none.
const OF_GROUPS: [&str; 2] = ["points", "ratio"];
/// Numbers in SI, by what they measure.
#[rustfmt::skip]
const SI: [(&str, &[&str]); 6] = [
    ("length", &[
        "position", "position_std", "positions", "contacts", "half_extents", "origin", "radius", "half_length", "ends", "reach",
        "distances", "distance", "point", "point_deviation", "touch_deviation", "voxel", "first", "at", "outlines", "beyond", "miss",
        "extents", "near_extents", "tip", "length", "interval", "path", "end", "meeting", "depth", "before", "after", "noise.points",
    ]),
    ("angle", &["axis_std", "rotation_std", "noise.joints"]),
    ("time", &["time", "time_to_contact", "began", "duration", "last", "seconds"]),
    ("force", &["force", "mean_force", "peak_force"]),
    ("speed", &["speed"]),
    ("posture", &["posture", "range"]),
];
/// Counts, seeds, indices, shares, directions and what else has no unit.
#[rustfmt::skip]
const NO_UNIT: [&str; 83] = [
    "touches", "seed", "seeds", "joints", "version", "dof", "motions", "motion", "bout", "limb", "limbs", "initial_guesses", "cores", "trials",
    "tangent", "normal", "direction", "rotation", "axis", "axes", "surface", "receptors", "parent", "shared", "learned", "geometric",
    "located_limbs", "limbs_with_skin", "limb_pairs", "false_touches", "false_share", "bare", "neighbours", "neighbours_mean", "again",
    "engine_checks", "converged", "within", "visited", "unknowns", "torso_joints", "torso_dof", "step", "passes", "residuals",
    "receptors_grown", "receptors_by_limb", "recall", "precision", "agreement", "points", "number", "made", "links_across_limbs",
    "information", "geom_pairs_left_out", "fresh_rms", "cost", "coordinates", "constraints_not_heeded", "aura_limbs",
    "supporting_touches", "strokes", "spins", "slides", "hinges", "balls", "welded", "locked", "followers", "skew", "singular_values",
    "minimum_singular_value", "rank", "parameters", "noise_amplification", "noise", "line", "inverse_condition", "d_optimality",
    "condition", "honest", "firings",
];

/// The numbers of a value by the names over them, the nearest first; of lists and of names that are data the list's own.
fn numbers(value: &Value, names: &mut Vec<String>, found: &mut BTreeSet<Vec<String>>) {
    match value {
        Value::Number(_) => drop(found.insert(names.iter().rev().cloned().collect())),
        Value::Array(items) => items.iter().for_each(|item| numbers(item, names, found)),
        // Each with its own unit beside it.
        Value::Object(fields) if fields.contains_key("unit") => {}
        Value::Object(fields) => {
            let named = ["posture", "receptors_by_limb"].contains(&names.last().map_or("", String::as_str));
            for (name, field) in fields {
                if !named {
                    names.push(name.clone());
                }
                numbers(field, names, found);
                if !named {
                    names.pop();
                }
            }
        }
        _ => {}
    }
}

/// What a number measures and in which unit; none where it has no unit, an error where nobody can know it.
fn unit(names: &[String]) -> Result<Option<(&'static str, &'static str)>, ()> {
    let name = names[0].as_str();
    let suffix = |name: &str| {
        let longest = SUFFIXES.iter().filter(|(suffix, _)| name.ends_with(suffix));
        let (suffix, measure) = longest.max_by_key(|(suffix, _)| suffix.len())?;
        Some((*measure, if ["_m", "_s", "_n", "_kg", "_m_s"].contains(suffix) { "SI" } else { *suffix }))
    };
    if let Some(found) = suffix(name) {
        return Ok(Some(found));
    }
    let si = |name: &str| {
        let (measure, _) = SI.iter().find(|(_, all)| all.contains(&name))?;
        Some((*measure, "SI"))
    };
    let in_group = names.get(1).map(|group| format!("{group}.{name}"));
    if let Some(found) = in_group.and_then(|name| si(&name)).or_else(|| si(name)) {
        return Ok(Some(found));
    }
    let of_group = names.get(1).and_then(|group| suffix(group).or_else(|| si(group)));
    if let Some(found) = of_group.filter(|_| STATISTICS.contains(&name) || OF_GROUPS.contains(&name)) {
        return Ok(Some(found).filter(|_| !OF_GROUPS.contains(&name)));
    }
    if NO_UNIT.contains(&name) { Ok(None) } else { Err(()) }
}

/// Holds a file's or an output's names against the rule; says what breaks it.
fn faults(of: &str, values: &[Value]) -> Vec<String> {
    let mut found = BTreeSet::new();
    values.iter().for_each(|value| numbers(value, &mut Vec::new(), &mut found));
    let mut faults = Vec::new();
    let mut units: BTreeMap<(&[String], &str), BTreeMap<&str, String>> = BTreeMap::new();
    for names in found.iter().filter(|names| !names.is_empty()) {
        let path = names.iter().rev().cloned().collect::<Vec<_>>().join(".");
        match unit(names) {
            Err(()) => faults.push(format!("{of}: nobody can know the unit of {path}")),
            Ok(Some((measure, unit))) => {
                units.entry((&names[1..], measure)).or_default().entry(unit).or_insert(path);
            }
            Ok(None) => {}
        }
    }
    let mixed = units.iter().filter(|(_, units)| units.len() > 1);
    faults
        .extend(mixed.map(|((_, measure), units)| format!("{of}: {measure} is in several units: {units:?}")));
    faults
}

/// A table as one object of a number per column that has any.
fn table(text: &str) -> Value {
    let mut lines = text.lines().map(|line| line.split(',').collect::<Vec<_>>());
    let head = lines.next().unwrap();
    let rows: Vec<Vec<&str>> = lines.collect();
    // A column of units says what those beside it are in.
    if head.contains(&"unit") {
        return Value::Null;
    }
    let number = |k: usize| rows.iter().find_map(|row| row.get(k)?.parse::<f64>().ok());
    let columns = head.iter().enumerate().filter_map(|(k, name)| Some((name.to_string(), number(k)?.into())));
    Value::Object(columns.collect())
}

fn lines(text: &str) -> Vec<Value> {
    text.lines().map(|line| serde_json::from_str(line).unwrap()).collect()
}

#[test]
fn every_number_is_in_si_or_named_with_its_unit() {
    let place = tempfile::tempdir().unwrap();
    let at = |name: &str| place.path().join(name);
    let read = |name: &str| fs::read_to_string(at(name)).unwrap();
    let shapes = ("type=\"sphere\" size=\"0.2\"", "type=\"capsule\" size=\"0.05 0.15\"");
    fs::write(at("arms.xml"), two_arms(shapes.0, shapes.1)).unwrap();
    let robot = repository("examples/robot");
    let (urdf, log) = (robot.join("arms.urdf"), robot.join("touches.csv"));
    let (urdf, log) = (urdf.to_str().unwrap(), log.to_str().unwrap());
    let max = sessions::max().join("max");
    let max = max.to_str().unwrap();
    let scene = repository("mjcf/max/table.xml");
    let mut all: Vec<String> = Vec::new();
    for arguments in [
        &["babble", "arms.xml", "--touches", "200", "--joint-noise", "0.1", "--out", "s", "--json"][..],
        &[
            "babble",
            "arms.xml",
            "--touches",
            "20",
            "--motion",
            "dynamic",
            "--learner",
            "hersch",
            "--out",
            "d",
            "--json",
        ],
        &["learn", "s", "--learner", "lm", "--out", "t", "--json"],
        &["learn", max, "--learner", "hersch", "--out", "m", "--json"],
        &["report", "s", "--json"],
        &["inspect", "arms.xml", "--json"],
        &["inspect", scene.to_str().unwrap(), "--json"],
        &["study", "generate", "--out", "g.xml", "--json"],
        &["calibrate", urdf, log, "--free", "*.offset", "--held-out", "0.3", "--out", "c", "--json"],
        &["study", "hersch", "arms.xml", "--trials", "1", "--touches", "60", "--out", "y", "--json"],
        &["study", "learners", "arms.xml", "--trials", "1", "--touches", "60", "--out", "z", "--json"],
    ] {
        let output: Value = serde_json::from_str(&succeeds(place.path(), arguments)).unwrap();
        all.extend(faults(&arguments[..2].join(" "), &[output]));
    }
    crate::common::shell::copy(Path::new(max), &at("w"));
    let reach = succeeds(place.path(), &["reach", "w", "--voxel", "0.1", "--at", "0.3,0,0.1", "--json"]);
    all.extend(faults("reach", &[serde_json::from_str(&reach).unwrap()]));
    let feel = succeeds(place.path(), &["skin", "feel", "arms.xml", "--stimulations", "4"]);
    all.extend(faults("feel", &lines(&feel)));
    succeeds(place.path(), &["skin", "feel", "arms.xml", "--strokes", "0.05", "--out", "f"]);
    let map = succeeds(place.path(), &["skin", "map", "f", "--out", "map.json", "--json"]);
    all.extend(faults("map", &[serde_json::from_str(&map).unwrap()]));
    for file in ["s/session.json", "d/session.json", "f/session.json", "s/schema.json"] {
        all.extend(faults(file, &[serde_json::from_str(&read(file)).unwrap()]));
    }
    for file in [
        "s/learning.json",
        "w/learning.json",
        "w/space.json",
        "c/calibration.json",
        "y/study.json",
        "map.json",
    ] {
        all.extend(faults(file, &[serde_json::from_str(&read(file)).unwrap()]));
    }
    for file in ["s/touches.jsonl", "d/touches.jsonl", "f/firings.jsonl", "f/sensations.jsonl"] {
        all.extend(faults(file, &lines(&read(file))));
    }
    for file in ["s/learning.csv", "w/learning.csv", "c/residuals.csv", "y/study.csv", "z/study.csv"] {
        all.extend(faults(file, &[table(&read(file))]));
    }
    assert!(all.is_empty(), "{}", all.join("\n"));
}

#[test]
fn the_rule_is_broken_by_two_units_and_by_none() {
    let found = |text: &str| faults("it", &[serde_json::from_str(text).unwrap()]).len();
    assert_eq!(found(r#"{"heldout_mm": {"mean": 1.5, "ratio": 2}, "axis_deg": 3, "learning_s": 2}"#), 0);
    assert_eq!(found(r#"{"error_mm": 1.5, "distance": 0.1}"#), 1);
    assert_eq!(found(r#"{"litres": 1.5}"#), 1);
    assert_eq!(found(r#"{"quantities": [{"unit": "rad", "after": 1.5}]}"#), 0);
}
