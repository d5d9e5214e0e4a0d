//! The map of neighbours that is learned from strokes: on made-up firings, on physics, and on the command line.

use std::fs;
use std::path::Path;

use crate::common::program::{refused, succeeds};
use crate::common::repository;
use bodyschema::creature::{Creature, Joint};
use bodyschema::evaluation::MapAgreement;
use bodyschema::geometry::Frame;
use bodyschema::senses::{Firing, FiringRecorder, SkinContact, SkinSpot, Toucher, learn_map};
use bodyschema::skin::{Receptor, Skin, SomatotopicMap};
use nalgebra::Vector3;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use serde_json::Value;

/// Receptors along each side of the made-up skin.
const SIDE: usize = 7;

/// A wall of bricks on each of two limbs, square ones: all that touch are about as far apart.
fn bricks() -> Skin {
    let receptor = |limb: usize, row: usize, column: usize| Receptor {
        id: format!("{limb}_{row}_{column}"),
        limb,
        position: Vector3::new(column as f64 + 0.5 + shift(row), row as f64 + 0.5, 0.0),
        normal: Vector3::z(),
        tangent: Vector3::x(),
        half_extents: [0.5; 2],
        surface: None,
    };
    let places = (0..2).flat_map(|limb| (0..SIDE * SIDE).map(move |k| (limb, k / SIDE, k % SIDE)));
    Skin {
        receptors: places.map(|(limb, row, column)| receptor(limb, row, column)).collect(),
        surfaces: vec![],
    }
}

/// How far a row of bricks is shifted.
fn shift(row: usize) -> f64 {
    0.5 * (row % 2) as f64
}

/// Straight strokes over one of the two walls, each somewhere else, in its own direction, and as fast as it likes.
fn strokes(count: usize, seed: u64) -> Vec<Firing> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let mut firings: Vec<Firing> = Vec::new();
    for stroke in 0..count {
        let limb = rng.random_range(0..2);
        let mut at = [0; 2].map(|_| rng.random_range(0.0..SIDE as f64));
        let angle: f64 = rng.random_range(0.0..std::f64::consts::TAU);
        let speed = rng.random_range(2.0..8.0);
        let mut time = 100.0 * stroke as f64;
        let first = firings.len();
        while (0.0..SIDE as f64).contains(&at[1]) {
            let row = at[1] as usize;
            let along = at[0] - shift(row);
            if !(0.0..SIDE as f64).contains(&along) {
                break;
            }
            let receptor = limb * SIDE * SIDE + row * SIDE + along as usize;
            match firings[first..].last_mut() {
                Some(firing) if firing.receptor == receptor => firing.span[1] = time,
                _ => firings.push(Firing { receptor, span: [time; 2] }),
            }
            time += 0.002;
            at = [at[0] + speed * 0.002 * angle.cos(), at[1] + speed * 0.002 * angle.sin()];
        }
    }
    firings
}

/// What the geometry says of the two walls, which lie far apart.
fn geometric(skin: &Skin) -> SomatotopicMap {
    let limbs = ["one", "other"].map(str::to_string).to_vec();
    let creature = Creature::new("walls".into(), limbs, vec![Joint::new("between", 0, vec![])], vec![]);
    let other = Frame { origin: Vector3::new(0.0, 0.0, 50.0), ..Frame::identity() };
    SomatotopicMap::new(&creature.unwrap(), skin, &[Frame::identity(), other])
}

fn limbs(skin: &Skin) -> Vec<usize> {
    skin.receptors.iter().map(|receptor| receptor.limb).collect()
}

#[test]
fn on_bricks_the_learned_neighbours_are_those_of_the_geometry() {
    let skin = bricks();
    let geometric = geometric(&skin);
    assert_eq!(geometric.neighbours(SIDE + 1).len(), 6, "one within has six");
    let learned = learn_map(&limbs(&skin), &strokes(1500, 1));
    let all = MapAgreement::of_all(&learned.map, &geometric);
    assert!(all.recall() >= 0.95 && all.precision() >= 0.95, "{all:?}");
    assert!((1400..=1500).contains(&learned.strokes), "some miss the wall, none is two: {}", learned.strokes);
    for receptor in 0..skin.receptors.len() {
        let neighbours = learned.map.neighbours(receptor);
        assert!(neighbours.len() <= 8 && !neighbours.contains(&receptor));
        assert!(neighbours.iter().all(|&other| learned.map.neighbours(other).contains(&receptor)), "mutual");
    }
}

#[test]
fn the_order_of_the_log_changes_nothing() {
    let skin = bricks();
    let firings = strokes(100, 2);
    let learned = learn_map(&limbs(&skin), &firings);
    let backwards: Vec<Firing> = firings.iter().rev().copied().collect();
    assert_eq!(learned, learn_map(&limbs(&skin), &backwards));
}

#[test]
fn what_never_fired_or_fired_alone_has_no_neighbours() {
    let skin = bricks();
    let alone = [Firing { receptor: 3, span: [0.0, 0.1] }, Firing { receptor: 4, span: [5.0, 5.1] }];
    for firings in [&[][..], &alone, &[Firing { receptor: 1000, span: [0.0, 1.0] }]] {
        let learned = learn_map(&limbs(&skin), firings);
        assert_eq!(learned.map.pairs().count(), 0, "{firings:?}");
        let all = MapAgreement::of_all(&learned.map, &geometric(&skin));
        assert_eq!((all.learned, all.recall()), (0, 0.0));
        assert!(all.precision().is_nan());
    }
}

#[test]
fn a_receptor_fires_on_over_a_bounce_and_anew_after_silence() {
    let spot = SkinSpot { limb: 0, receptor: 7 };
    let contact = [SkinContact { spot, by: Toucher::Thing(1), force: 1.0 }];
    let mut recorder = FiringRecorder::default();
    let mut ended = Vec::new();
    for (time, fires) in [(0.0, true), (0.01, false), (0.02, true), (0.06, false), (0.07, true)] {
        ended.extend(recorder.step(time, if fires { &contact } else { &[] }));
    }
    ended.extend(recorder.rest());
    assert_eq!(ended, [[0.0, 0.02], [0.07, 0.07]].map(|span| Firing { receptor: 7, span }));
}

#[test]
fn a_snake_that_is_stroked_for_a_minute_learns_true_neighbours() {
    let place = tempfile::tempdir().unwrap();
    let snake = repository("mjcf/snake/snake.xml");
    let stroke =
        ["skin", "feel", snake.to_str().unwrap(), "--strokes", "1", "--seed", "3", "--out", "stroked"];
    let told = succeeds(place.path(), &stroke);
    assert!(told.contains("in 1 minutes") && told.contains("stroked"), "{told}");
    for file in ["session.json", "firings.jsonl", "sensations.jsonl"] {
        assert!(place.path().join("stroked").join(file).is_file(), "no {file}");
    }
    let log = fs::read_to_string(place.path().join("stroked/firings.jsonl")).unwrap();
    let fields = ["receptor", "first", "last"];
    for line in log.lines().skip(1) {
        let firing: Value = serde_json::from_str(line).unwrap();
        assert!(firing.as_object().unwrap().keys().all(|key| fields.contains(&key.as_str())), "{line}");
    }
    let arguments = ["skin", "map", "stroked", "--out", "map.json", "--json"];
    let found: Value = serde_json::from_str(&succeeds(place.path(), &arguments)).unwrap();
    let number = |key: &str| found[key].as_f64().unwrap();
    assert!(number("precision") > 0.85 && number("recall") > 0.15, "{found}");
    let of_limbs = |key: &str| -> u64 {
        found["limbs"].as_array().unwrap().iter().map(|limb| limb[key].as_u64().unwrap()).sum()
    };
    for key in ["receptors", "visited"] {
        assert_eq!(found[key], of_limbs(key), "{key}");
    }
    let across = |key: &str| found["across_joints"][key].as_u64().unwrap();
    for key in ["learned", "geometric", "shared"] {
        assert_eq!(found[key], of_limbs(key) + across(key), "{key}");
        assert_eq!(found["within_limbs"][key], of_limbs(key), "{key}");
    }
    assert!(across("shared") > 10, "strokes go over joints: {found}");
    let map: Value =
        serde_json::from_str(&fs::read_to_string(place.path().join("map.json")).unwrap()).unwrap();
    let neighbours = map["neighbours"].as_object().unwrap();
    let links: usize = neighbours.values().map(|of| of.as_array().unwrap().len()).sum();
    assert_eq!(
        (neighbours.len() as u64, links as u64),
        (of_limbs("receptors"), 2 * found["learned"].as_u64().unwrap())
    );
    let table = succeeds(place.path(), &["skin", "map", "stroked"]);
    assert!(table.contains("geometric") && table.contains("agreement"), "{table}");
    let felt = ["skin", "feel", snake.to_str().unwrap(), "--stimulations", "2", "--map", "map.json"];
    assert!(succeeds(place.path(), &felt).contains("\"sensed\""));
    wrong_maps_are_told_in_one_sentence(place.path(), &felt, &map);
    wrong_logs_are_told_in_one_sentence(place.path(), &log);
    assert!(refused(place.path(), 1, &stroke).contains("already contains a session"));
}

/// What is wrong with a map, by a word that the message must have.
fn wrong_maps_are_told_in_one_sentence(place: &Path, feel: &[&str], map: &Value) {
    let text = map.to_string();
    let neighbours = map["neighbours"].as_object().unwrap();
    let (id, of) = neighbours.iter().find(|(_, of)| of.as_array().unwrap().len() > 1).unwrap();
    let other = of[0].as_str().unwrap();
    let with = |list: Value| {
        let mut map = map.clone();
        map["neighbours"][id] = list;
        map.to_string()
    };
    let others: Vec<&str> = of.as_array().unwrap().iter().map(|other| other.as_str().unwrap()).collect();
    let mut fewer = map.clone();
    fewer["neighbours"].as_object_mut().unwrap().remove(id);
    let many: Vec<&str> = neighbours.keys().filter(|key| *key != id).take(9).map(String::as_str).collect();
    let cases = [
        ("{".to_string(), "format"),
        (text.replace("bodyschema map", "bodyschema firings"), "bodyschema firings"),
        (text.replace("\"version\":1", "\"version\":7"), "newer"),
        (text.replace("\"snake\"", "\"worm\""), "worm"),
        (with(Value::from([&others[..], &["third_elbow"]].concat())), "third_elbow"),
        (with(Value::from([&others[..], &[other]].concat())), "twice"),
        (with(Value::from([&others[..], &[id.as_str()]].concat())), "its own"),
        (with(Value::from(others[1..].to_vec())), "the other way round"),
        (with(Value::from(many)), "keep only the nearest"),
        (fewer.to_string(), "an empty list"),
        (with(Value::from(7)), "not a valid map of neighbours"),
    ];
    for (text, word) in cases {
        fs::write(place.join("map.json"), &text).unwrap();
        let message = refused(place, 1, feel);
        assert_eq!(message.trim_end().lines().count(), 1, "{message}");
        assert!(message.contains(word) && message.contains("map.json"), "no \"{word}\" in: {message}");
    }
    fs::remove_file(place.join("map.json")).unwrap();
    assert!(refused(place, 1, feel).contains("map.json"));
}

/// What is wrong with a log, by a word that the message must have.
fn wrong_logs_are_told_in_one_sentence(place: &Path, log: &str) {
    let file = place.join("stroked/firings.jsonl");
    let (header, firings) = log.split_once('\n').unwrap();
    let second = |line: &str| format!("{header}\n{line}\n{firings}");
    let firing: Value = serde_json::from_str(firings.lines().next().unwrap()).unwrap();
    let id = firing["receptor"].as_str().unwrap();
    let cases = [
        (firings.to_string(), "format"),
        (String::new(), "header"),
        (header.replace("firings", "touches"), "format"),
        (header.replace("snake", "worm"), "worm"),
        (second("{\"receptor\": \"third_elbow\", \"first\": 1, \"last\": 2}"), "third_elbow"),
        (second(&format!("{{\"receptor\": \"{id}\", \"first\": 2, \"last\": 1}}")), "order"),
        (
            second(&format!("{{\"receptor\": \"{id}\", \"first\": 1e300, \"last\": 1e301}}")),
            "cannot have fired",
        ),
        (second(&format!("{{\"receptor\": \"{id}\", \"first\": 1}}")), "last"),
        (second("touched"), "correct the line"),
    ];
    for (text, word) in cases {
        fs::write(&file, &text).unwrap();
        let message = refused(place, 1, &["skin", "map", "stroked"]);
        assert_eq!(message.trim_end().lines().count(), 1, "{message}");
        assert!(message.contains(word) && message.contains("firings.jsonl"), "no \"{word}\" in: {message}");
        let line = if text.starts_with(header) { "line 2" } else { "line 1" };
        assert!(message.contains(line), "no {line} in: {message}");
    }
    // What a killed process leaves is read up to there.
    fs::write(&file, &log[..log.len() - 5]).unwrap();
    succeeds(place, &["skin", "map", "stroked"]);
    fs::remove_file(&file).unwrap();
    assert!(refused(place, 1, &["skin", "map", "stroked"]).contains("--strokes"));
    assert!(refused(place, 1, &["skin", "map", "nowhere"]).contains("nowhere"));
}

#[test]
fn strokes_go_with_neither_a_script_nor_nonsense() {
    let place = tempfile::tempdir().unwrap();
    let snake = repository("mjcf/snake/snake.xml");
    let feel = ["skin", "feel", snake.to_str().unwrap()];
    for wrong in [
        &["--strokes", "0"][..],
        &["--strokes", "nan"],
        &["--strokes", "1", "--script", "touches.json"],
        &["--out", "here"],
    ] {
        refused(place.path(), 2, &[&feel[..], wrong].concat());
    }
    assert!(fs::read_dir(place.path()).unwrap().next().is_none(), "wrong usage left a session");
}

#[test]
fn studies_of_the_senses_take_no_touches() {
    let place = tempfile::tempdir().unwrap();
    let max = repository("mjcf/max/max.xml");
    let senses = ["study", "senses", max.to_str().unwrap()];
    let message = refused(place.path(), 1, &[&senses[..], &["--touches", "9"]].concat());
    assert!(message.contains("--touches") && message.contains("--trials"), "{message}");
    assert!(fs::read_dir(place.path()).unwrap().next().is_none(), "wrong usage left a study");
    let told = succeeds(place.path(), &[&senses[..], &["--trials", "1", "--case", "tap"]].concat());
    assert!(told.contains("1 trial, seeds 1") && !told.contains("touches, seeds"), "{told}");
}
