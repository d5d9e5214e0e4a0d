//! What was once taken in silence, and is refused or told.

use std::fs;
use std::path::Path;

use serde_json::{Value, json};

use super::readers::{Ending, Yard};

/// What makes a bad file of a good one.
type Change<'a> = &'a dyn Fn(&str) -> String;

/// The sentence with which a reader refuses its good file with a change, or what it takes it for.
fn ending(yard: &Yard, name: &str, change: Change) -> Result<String, String> {
    let reader = yard.readers().into_iter().find(|reader| reader.name == name).unwrap();
    let good = String::from_utf8(reader.good.clone()).unwrap();
    let bad = change(&good);
    assert_ne!(good, bad, "{name}: nothing is changed");
    fs::write(&reader.file, bad).unwrap();
    match (reader.read)(&reader.file) {
        Ending::Accepted(value) => Ok(value),
        Ending::Refused(sentence) => Err(sentence),
        _ => panic!("{name} ends in neither"),
    }
}

/// It is refused with a sentence that names the file and has these words.
fn refuses(yard: &Yard, name: &str, change: Change, words: &str) {
    let sentence = match ending(yard, name, change) {
        Err(sentence) => sentence,
        Ok(value) => panic!("{name}, {words}: it is taken: {value:.300}"),
    };
    let file = yard.readers().into_iter().find(|reader| reader.name == name).unwrap().file;
    assert!(sentence.contains(&file.display().to_string()), "{sentence}");
    assert!(sentence.contains(words), "{sentence} lacks {words}");
}

/// JSON with a value in a place.
fn with(pointer: &'static str, value: Value) -> impl Fn(&str) -> String {
    move |good: &str| {
        let mut file: Value = serde_json::from_str(good).unwrap();
        *file.pointer_mut(pointer).unwrap_or_else(|| panic!("no {pointer}")) = value.clone();
        file.to_string()
    }
}

#[test]
fn numbers_of_a_session_that_cannot_be_are_refused() {
    let yard = Yard::new();
    let session = |pointer, value, words: &str| refuses(&yard, "session", &with(pointer, value), words);
    session("/skin/receptors/0/position/0", json!(1e308), "has a coordinate of");
    session("/skin/receptors/0/half_extents/1", json!(-0.01), "half extent of -0.01");
    session("/skin/receptors/0/half_extents/1", json!(1e308), "half extent of");
    session("/skin/receptors/0/normal", json!([0, 0, 2]), "direction of length 2");
    session("/skin/receptors/0/tangent", json!([0, 0, 0]), "direction of length 0");
    session("/skin/surfaces/0/origin/2", json!(-1e308), "has a coordinate of");
    session("/skin/surfaces/0/rotation", json!([1, 0, 0, 0, 1, 0, 0, 0, 2]), "has an invalid rotation");
    session("/skin/surfaces/0/rotation", json!([1, 0, 0, 0, 1, 0, 0, 0, -1]), "has an invalid rotation");
    session(
        "/skin/surfaces/0/shape",
        json!({"capsule": {"radius": -0.1, "half_length": 0.2}}),
        "size -0.1 m",
    );
    session("/skin/surfaces/0/shape", json!({"sphere": {"radius": 1e308}}), "has a shape of size");
    session("/creature/joints/0/dofs/0/range/1", json!(1e308), "the range of left_shoulder_a goes beyond");
    let schema = |pointer, value, words: &str| refuses(&yard, "schema", &with(pointer, value), words);
    schema("/joints/0/position/0", json!(1e308), "joint \"left_shoulder\" has a coordinate of");
    schema("/joints/0/position_std/0", json!(-1.0), "position_std of -1");
    schema("/joints/0/axes/0/axis_std", json!(1e308), "axis_std of");
    let known = |pointer, value, words: &str| refuses(&yard, "known", &with(pointer, value), words);
    known("/joints/0/position/0", json!(1e308), "has a coordinate of");
    known("/joints/0/position_std", json!(1e308), "position_std");
    for (from, to, words) in [
        ("\"mass\": 1.5", "\"mass\": -1.5", "the mass of hand is -1.5"),
        ("\"radius\": 0.05", "\"radius\": -0.05", "radius"),
        ("-9.81", "-1e308", "its gravity"),
        ("\"elbow.offset\": 0.02", "\"elbow.offset\": 1e308", "elbow.offset is"),
    ] {
        refuses(&yard, "robot, JSON", &|good: &str| good.replacen(from, to, 1), words);
    }
    refuses(
        &yard,
        "robot, URDF",
        &|good| good.replacen("0.1 0 0.30", "0.1 0 1e300", 1),
        "is beyond 1000000, the limit",
    );
}

#[test]
fn tables_of_learning_with_anything_wrong_are_refused_by_line() {
    let yard = Yard::new();
    let wrong: [(Change, &str); 6] = [
        (&|good| good.replace(',', ";"), "line 2: "),
        (&|good| good.replace(',', "\t"), "line 2: "),
        (&|good| good.replacen("touches", "touch", 1), "unknown field `touch`"),
        (&|good| format!("{good}inf\n"), "it has 1 cells instead of 9"),
        (&|good| format!("{good}1\n"), "cells instead of"),
        (&|good| good.replacen("converged,", "", 1), "cells instead of"),
    ];
    for (change, words) in wrong {
        refuses(&yard, "learning table", change, words);
    }
}

#[test]
fn unknown_fields_are_named_with_what_was_meant() {
    let yard = Yard::new();
    let slip = |name: &str, from: &'static str, to: &'static str, words: &str| {
        refuses(&yard, name, &move |good: &str| good.replacen(from, to, 1), words);
    };
    slip(
        "known",
        "\"position_std\"",
        "\"positon_std\"",
        "joints[0].positon_std is unknown (is position_std meant?)",
    );
    slip("known", "\"axis_std\"", "\"axis_stdd\"", "(is axis_std meant?)");
    slip("known", "\"creature\"", "\"creatures\"", "creatures is unknown");
    slip("creature", "\"surface\"", "\"surfce\"", "skin.receptors[0].surfce: unknown field `surfce`");
}

#[test]
fn degrees_where_radians_are_meant_are_refused_or_told() {
    let yard = Yard::new();
    let read = |log: &str, range: &str| {
        let folder = yard.path("degrees");
        fs::create_dir_all(&folder).unwrap();
        let creature = format!(
            r#"{{"name": "arm", "limbs": ["base", "arm"], "joints": [{{"name": "lift", "parent": "base", "dofs": [{{"name": "lift", "kind": "hinge", "range": {range}}}]}}]}}"#
        );
        fs::write(folder.join("c.json"), creature).unwrap();
        let rows: String =
            log.split(' ').map(|angle| format!("base,arm,0.1,0.2,0.3,-0.1,0,0.01,{angle}\n")).collect();
        fs::write(folder.join("l.csv"), format!("limb_a,limb_b,ax,ay,az,bx,by,bz,lift\n{rows}")).unwrap();
        read_log(&folder)
    };
    let refused = |log: &str, range: &str, words: &str| {
        let sentence = read(log, range).unwrap_err();
        assert!(sentence.contains("l.csv, line") && sentence.contains(words), "{log}: {sentence}");
    };
    // Degrees in the range as well, in one row of many, and numbers that are no angle at all.
    refused("45 -80 120", "[-170, 170]", "convert them and the range to radians");
    refused("45 -80 120", "[-1.5, 1.5]", "convert them");
    refused("0.1 0.2 57.3 0.4", "[-1.5, 1.5]", "line 4: lift is 57.3, more than a turn beyond its range");
    refused("0.1 0.2 0.3 1e9", "[-1.5, 1.5]", "lift is");
    let told = |log: &str, range: &str, words: &str| {
        let notes = read(log, range).unwrap();
        assert!(notes.iter().any(|note| note.contains(words)), "{log}: {notes:?}");
    };
    told("0.1 -0.2 0.3", "[-170, 170]", "exceeds a full turn");
    // Small degrees.
    told("5 -4 3", "[-1.5, 1.5]", "beyond its range");
    let many = format!("4 {}", ["0.1"; 40].join(" "));
    told(&many, "[-1.5, 1.5]", "lift is 4 on line 2, far beyond its range");
    assert_eq!(read("0.1 -0.2 0.3", "[-1.5, 1.5]").unwrap(), Vec::<String>::new());
    // The same of a robot's log.
    refuses(&yard, "robot's log", &|good| good.replacen(",0.5,", ",1e9,", 1), "out of range");
    refuses(
        &yard,
        "robot's log",
        &|good| good.replacen(",0.5,", ",28.6,", 1),
        "more than a turn beyond its range",
    );
}

fn read_log(folder: &Path) -> Result<Vec<String>, String> {
    let agent = bodyschema::session::read_creature(&folder.join("c.json")).unwrap().agent;
    let read = bodyschema::session::read_recording(&folder.join("l.csv"), &agent);
    read.map(|recording| recording.notes).map_err(|error| error.to_string())
}
