//! Every example in every command's help is run as it is written. Of those whose comment says that they take
//! minutes only the usage is checked.

mod common;

use std::fs;
use std::path::Path;

use common::shell::{Line, copy, copy_models, run};

const KNOWN: &str = r#"{"joints": [
  {"joint": "left_elbow", "position": [0.024, 0.089, -0.28],
   "axes": [{"dof": "left_elbow_flexion", "axis": [-0.239924, -0.9466999, -0.2149319]},
            {"dof": "left_elbow_pronation", "axis": [0.2399183, 0.2399183, -0.9406798]}]},
  {"joint": "right_wrist", "position": [0.06, -0.06, -0.235], "position_std": 0.005}
]}"#;
const ROBOT: &str = r#"{"name": "arm", "limbs": ["base", "forearm"], "joints": [{"name": "elbow", "parent": "base",
  "dofs": [{"name": "elbow_pitch", "kind": "hinge", "range": [-1.5, 1.5]}]}]}"#;
const ROBOT_CSV: &str = "limb_a,limb_b,ax,ay,az,bx,by,bz,elbow_pitch\n\
                         base,forearm,0.08,0.01,0.02,0.21,0.00,0.01,0.75\n\
                         base,forearm,0.05,0.02,0.02,0.19,0.01,0.00,1.10\n";
const ROBOT_LINES: &str = r#"{"posture": {"elbow_pitch": 0.75}, "limbs": ["base", "forearm"], "contacts": [[0.08, 0.01, 0.02], [0.21, 0.0, 0.01]]}
"#;
const SCRIPT: &str = r#"{"probes": [{"name": "finger", "path": [
  {"time": 0.0, "receptor": "left_forearm_05", "height": 0.03},
  {"time": 0.3, "receptor": "left_forearm_05", "height": -0.005},
  {"time": 0.4, "receptor": "left_forearm_05", "height": 0.03}]}]}"#;

/// The commands that the help names.
fn commands(folder: &Path) -> Vec<String> {
    let help = run(folder, "bodyschema --help");
    let (_, list) = help.split_once("Commands:\n").unwrap();
    let names = list.lines().take_while(|line| line.starts_with("  "));
    let names: Vec<String> =
        names.filter_map(|line| line.split_whitespace().next()).map(String::from).collect();
    names.into_iter().filter(|name| name != "help").collect()
}

/// The examples in a help.
fn examples(help: &str) -> Vec<Line> {
    let (_, rest) = help.split_once("Examples:\n").unwrap_or_else(|| panic!("no examples in {help}"));
    let lines = rest.lines().take_while(|line| line.starts_with("  "));
    lines.map(|line| Line::new(line.trim())).collect()
}

/// What the examples take for granted: a checkout, sessions, and the files that the help shows.
fn prepare(folder: &Path) {
    copy_models(folder);
    fs::copy(folder.join("mjcf/hexapod/hexapod.xml"), folder.join("creature.xml")).unwrap();
    fs::copy(folder.join("mjcf/hexapod/hexapod.xml"), folder.join("robot.xml")).unwrap();
    let files = [
        ("known.json", KNOWN),
        ("robot.json", ROBOT),
        ("touches.csv", ROBOT_CSV),
        ("touches.jsonl", ROBOT_LINES),
        ("touches.json", SCRIPT),
    ];
    files.iter().for_each(|(name, text)| fs::write(folder.join(name), text).unwrap());
    run(folder, "bodyschema babble mjcf/max/max.xml --out sessions/max-1");
    run(folder, "bodyschema feel mjcf/max/max.xml --strokes 0.5 --out sessions/stroked");
}

#[test]
fn every_example_of_the_help_runs_as_it_is_written() {
    let prepared = tempfile::tempdir().unwrap();
    prepare(prepared.path());
    let (mut ran, mut slow) = (0, 0);
    let commands = commands(prepared.path());
    assert!(commands.len() >= 14, "{commands:?}");
    for command in std::iter::once("").chain(commands.iter().map(String::as_str)) {
        let help = run(prepared.path(), &format!("bodyschema {command} --help"));
        let examples = examples(&help);
        assert!(!examples.is_empty(), "{command} has no example");
        // What one command's examples leave is not there for the next one's.
        let place = tempfile::tempdir().unwrap();
        copy(prepared.path(), place.path());
        if examples.iter().any(|line| line.text.contains("--out sessions/stroked")) {
            // The one that is there was made by a short one of these.
            assert!(examples.iter().all(|line| !line.text.contains("--out sessions/stroked") || line.slow));
        }
        for example in &examples {
            assert!(example.text.contains("bodyschema"), "{command}: {example:?}");
            if example.lacks_something() {
                example.check();
            } else if example.run(place.path()) {
                ran += 1;
            } else {
                slow += 1;
            }
        }
    }
    println!("{ran} examples ran, of {slow} slow ones the usage was checked");
    assert!(ran >= 30 && slow <= 9, "{ran} ran, {slow} are slow");
}

#[test]
fn the_configuration_in_the_help_is_one() {
    let place = tempfile::tempdir().unwrap();
    copy_models(place.path());
    let help = run(place.path(), "bodyschema --help");
    let (_, config) = help.split_once("A file for --config:\n").unwrap();
    fs::write(place.path().join("c.toml"), config).unwrap();
    let told = run(
        place.path(),
        "bodyschema babble mjcf/hexapod/hexapod.xml --learner hersch --json --config c.toml",
    );
    let told: serde_json::Value = serde_json::from_str(&told).unwrap();
    assert_eq!((&told["touches"], &told["disturbances"]["joint_noise_deg"]), (&2000.into(), &0.1.into()));
}
