//! Every command that the README, `docs/` and the help show runs as it is written, once: those of the documents from top
//! to bottom, the examples of a command's help where no document shows them. Of those whose comment says that they take
//! minutes or hours only the usage is checked.

use std::collections::BTreeSet;
use std::fs;
use std::path::Path;

use crate::common::repository;
use crate::common::sessions;
use crate::common::shell::{Line, copy, run};

/// The documents, in the order in which they are read; what one leaves is there for the next.
const DOCUMENTS: [&str; 20] = [
    "README.md",
    "docs/commands.md",
    "docs/looking.md",
    "docs/tutorial.md",
    "docs/robot.md",
    "docs/table.md",
    "docs/creatures.md",
    "docs/recordings.md",
    "docs/learning.md",
    "docs/senses.md",
    "docs/many.md",
    "docs/calibration.md",
    "docs/files.md",
    "docs/library.md",
    "docs/how-it-works.md",
    "docs/hersch.md",
    "docs/results.md",
    "docs/acting.md",
    "docs/bodies.md",
    "docs/performance.md",
];
/// What a reader does once, to install the program and to check it, and what the tests do anyway.
const SETTING_UP: [&str; 5] =
    ["cargo test", "cargo bench", "cargo doc", "cargo install --path .", "cargo run --release --example"];

/// The files that the help takes for granted.
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

/// A fenced block of a document: its language, and its text.
struct Block {
    language: String,
    text: String,
}

fn blocks(document: &str) -> Vec<Block> {
    let mut blocks = Vec::new();
    let mut lines = document.lines();
    while let Some(line) = lines.next() {
        let Some(language) = line.strip_prefix("```") else { continue };
        let text: Vec<&str> = lines.by_ref().take_while(|line| *line != "```").collect();
        blocks.push(Block { language: language.to_string(), text: text.join("\n") + "\n" });
    }
    blocks
}

/// The name that the documents call a file by of which a block shows the content.
fn file_of(block: &Block) -> Option<&'static str> {
    let has = |words: &str| block.text.contains(words);
    match block.language.as_str() {
        "csv" => Some("touches.csv"),
        "json" if has("\"probes\"") => Some("touches.json"),
        "json" if has("\"limbs\": [\"base\"") => Some("robot.json"),
        "json" if has("\"joint\": \"left_elbow\"") => Some("known.json"),
        "xml" => Some("crab.xml"),
        _ => None,
    }
}

/// What a line of a shell has bodyschema do, where it does.
fn command(line: &str) -> Option<Line> {
    let last = line.rsplit(" && ").next().unwrap_or(line);
    let called = last.replacen("cargo run --release -- ", "bodyschema ", 1);
    if SETTING_UP.iter().any(|done| called.starts_with(done)) || called.starts_with('#') {
        return None;
    }
    Some(Line::new(&called))
}

/// The commands that a document shows.
fn shown(blocks: &[Block]) -> impl Iterator<Item = Line> {
    let shell = blocks.iter().filter(|block| block.language == "sh");
    shell.flat_map(|block| block.text.lines().filter_map(command))
}

fn read(document: &str) -> Vec<Block> {
    blocks(&fs::read_to_string(repository(document)).unwrap())
}

/// Commands that ran, and those of which the usage alone was checked.
#[derive(Default)]
struct Count {
    ran: usize,
    checked: usize,
}

impl Count {
    /// Runs a command in a folder, unless it is slow.
    fn run(&mut self, line: &Line, folder: &Path) {
        if line.run(folder) {
            self.ran += 1;
        } else {
            self.checked += 1;
        }
    }
}

#[test]
#[ignore = "needs OpenGL, ffmpeg and MuJoCo's sample models"]
fn every_command_of_the_documents_runs_as_it_is_written() {
    let place = tempfile::tempdir().unwrap();
    copy(sessions::checkout(), place.path());
    let mut met: BTreeSet<String> = sessions::CHECKOUT.map(String::from).into();
    let mut count = Count::default();
    for document in DOCUMENTS {
        let blocks = read(document);
        // A reader may have a file before the command that needs it is shown.
        for block in &blocks {
            if let Some(name) = file_of(block) {
                fs::write(place.path().join(name), &block.text).unwrap();
            }
        }
        for line in shown(&blocks) {
            if met.insert(line.text.clone()) {
                count.run(&line, place.path());
            }
        }
    }
    println!("{} commands ran, of {} the usage was checked", count.ran, count.checked);
    assert!(count.ran >= 25, "{} commands ran", count.ran);
    let known = |path: &Path| DOCUMENTS.iter().any(|document| path == repository(document));
    for entry in fs::read_dir(repository("docs")).unwrap() {
        let path = entry.unwrap().path();
        let text = fs::read_to_string(&path).unwrap_or_default();
        assert!(known(&path) || !text.contains("```sh"), "{} is not among DOCUMENTS", path.display());
    }
}

#[test]
fn what_the_documents_take_for_granted_is_shown_by_them() {
    let shown: BTreeSet<String> = DOCUMENTS
        .iter()
        .flat_map(|document| shown(&read(document)).map(|line| line.text).collect::<Vec<_>>())
        .collect();
    for line in sessions::CHECKOUT {
        assert!(shown.contains(line), "no document shows {line}");
    }
}

/// The commands that the help names.
fn commands() -> Vec<String> {
    let help = run(Path::new("."), "bodyschema --help");
    let (_, list) = help.split_once("Commands:\n").unwrap();
    let names = list.lines().take_while(|line| line.starts_with("  "));
    let names: Vec<String> =
        names.filter_map(|line| line.split_whitespace().next()).map(String::from).collect();
    let of_study = ["study generate", "study gallery", "study merge"].map(String::from);
    names.into_iter().filter(|name| name != "help").chain(of_study).collect()
}

/// The examples in a help.
fn examples(help: &str) -> Vec<Line> {
    let (_, rest) = help.split_once("Examples:\n").unwrap_or_else(|| panic!("no examples in {help}"));
    let lines = rest.lines().take_while(|line| line.starts_with("  "));
    lines.map(|line| Line::new(line.trim())).collect()
}

/// A folder with what the examples take for granted: a checkout, sessions, and the files that the help shows.
fn prepared() -> tempfile::TempDir {
    let place = tempfile::tempdir().unwrap();
    copy(sessions::checkout(), place.path());
    for name in ["creature.xml", "robot.xml"] {
        fs::copy(repository("mjcf/hexapod/hexapod.xml"), place.path().join(name)).unwrap();
    }
    let files = [
        ("known.json", KNOWN),
        ("robot.json", ROBOT),
        ("touches.csv", ROBOT_CSV),
        ("touches.jsonl", ROBOT_LINES),
        ("touches.json", SCRIPT),
    ];
    files.iter().for_each(|(name, text)| fs::write(place.path().join(name), text).unwrap());
    place
}

#[test]
#[ignore = "needs OpenGL, ffmpeg and MuJoCo's sample models"]
fn every_example_of_the_help_runs_as_it_is_written() {
    let documents = DOCUMENTS.iter().flat_map(|document| shown(&read(document)).collect::<Vec<_>>());
    let mut met: BTreeSet<String> = documents.map(|line| line.text).collect();
    let mut count = Count::default();
    let mut elsewhere = 0;
    let commands = commands();
    assert!(commands.len() >= 12, "{commands:?}");
    for command in std::iter::once("").chain(commands.iter().map(String::as_str)) {
        let help = run(Path::new("."), &format!("bodyschema {command} --help"));
        let examples = examples(&help);
        assert!(!examples.is_empty(), "{command} has no example");
        // What one command's examples leave is not there for the next one's.
        let place = prepared();
        if examples.iter().any(|line| line.text.contains("--out sessions/stroked")) {
            // The one that is there was made by a short one of these.
            assert!(examples.iter().all(|line| !line.text.contains("--out sessions/stroked") || line.slow));
        }
        for example in &examples {
            assert!(example.text.contains("bodyschema"), "{command}: {example:?}");
            if met.insert(example.text.clone()) {
                count.run(example, place.path());
            } else {
                elsewhere += 1;
            }
        }
    }
    println!(
        "{} examples ran, of {} the usage was checked, {elsewhere} run elsewhere",
        count.ran, count.checked
    );
    assert!(
        count.ran + elsewhere >= 30 && count.checked <= 20,
        "{} and {elsewhere}, {}",
        count.ran,
        count.checked
    );
}

#[test]
fn links_of_the_documents_lead_somewhere() {
    let documents = fs::read_dir(repository("docs")).unwrap().map(|entry| entry.unwrap().path());
    let top = ["README.md", "CONTRIBUTING.md"].map(repository);
    for path in documents.chain(top).filter(|path| path.extension().is_some_and(|ending| ending == "md")) {
        let text = fs::read_to_string(&path).unwrap();
        for link in text.split("](").skip(1).filter_map(|rest| rest.split(')').next()) {
            if link.starts_with("http") {
                continue;
            }
            let (file, anchor) = link.split_once('#').unwrap_or((link, ""));
            let target = if file.is_empty() { path.clone() } else { path.parent().unwrap().join(file) };
            assert!(target.exists(), "{}: {link} leads nowhere", path.display());
            // The site is of the folder's own pages.
            let leaves = path.starts_with(repository("docs")) && file.starts_with("../");
            assert!(!leaves, "{}: {link} leads out of the site", path.display());
            if !anchor.is_empty() {
                let there = fs::read_to_string(&target).unwrap();
                let headings = there.lines().filter_map(|line| line.strip_prefix('#'));
                let anchors = headings.map(|heading| {
                    let words = heading.trim_start_matches('#').trim().to_lowercase().replace(' ', "-");
                    words.chars().filter(|c| c.is_alphanumeric() || "-_".contains(*c)).collect::<String>()
                });
                assert!(
                    anchors.into_iter().any(|a| a == anchor),
                    "{}: no heading for {link}",
                    path.display()
                );
            }
        }
    }
}

#[test]
fn the_site_has_every_document() {
    let summary = fs::read_to_string(repository("docs/SUMMARY.md")).unwrap();
    for entry in fs::read_dir(repository("docs")).unwrap() {
        let name = entry.unwrap().file_name().into_string().unwrap();
        let is_page = name.ends_with(".md") && name != "SUMMARY.md";
        assert!(!is_page || summary.contains(&format!("]({name})")), "docs/SUMMARY.md leaves out {name}");
    }
}
