//! Every command of the README and of `docs/` is run as it is written, from top to bottom, in a copy of the
//! repository's models. Of those whose comment says that they take minutes or hours only the usage is checked.

mod common;

use std::fs;
use std::path::Path;

use common::repository;
use common::shell::{Line, copy_models};

/// The documents, in the order in which they are read; what one leaves is there for the next.
const DOCUMENTS: [&str; 10] = [
    "README.md",
    "docs/tutorial.md",
    "docs/how-it-works.md",
    "docs/learning.md",
    "docs/senses.md",
    "docs/acting.md",
    "docs/creatures.md",
    "docs/recordings.md",
    "docs/performance.md",
    "docs/files.md",
];
/// What a reader does once, to install the program and to check it, and what the tests do anyway.
const SETTING_UP: [&str; 5] =
    ["cargo test", "cargo bench", "cargo doc", "cargo install --path .", "cargo run --release --example"];

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
        "toml" => Some("bodyschema.toml"),
        "json" if has("\"probes\"") => Some("touches.json"),
        "json" if has("\"limbs\": [\"base\"") => Some("robot.json"),
        "json" if has("\"joint\": \"left_elbow\"") => Some("known.json"),
        "xml" => Some("crab.xml"),
        _ => None,
    }
}

/// What a line of a shell has bodyschema do, where it does.
fn command(line: &str) -> Option<String> {
    let last = line.rsplit(" && ").next().unwrap_or(line);
    let called = last.replacen("cargo run --release -- ", "bodyschema ", 1);
    if SETTING_UP.iter().any(|done| called.starts_with(done)) || called.starts_with('#') {
        return None;
    }
    Some(called)
}

fn follow(folder: &Path, document: &str) -> (usize, usize) {
    let text = fs::read_to_string(repository(document)).unwrap();
    let (mut ran, mut slow) = (0, 0);
    let blocks = blocks(&text);
    // A reader may have a file before the command that needs it is shown.
    for block in &blocks {
        if let Some(name) = file_of(block) {
            fs::write(folder.join(name), &block.text).unwrap();
        }
    }
    for block in blocks.iter().filter(|block| block.language == "sh") {
        for line in block.text.lines().filter_map(command) {
            let line = Line::new(&line);
            if line.lacks_something() {
                line.check();
            } else if line.run(folder) {
                ran += 1;
            } else {
                slow += 1;
            }
        }
    }
    (ran, slow)
}

#[test]
fn every_command_of_the_documents_runs_as_it_is_written() {
    let place = tempfile::tempdir().unwrap();
    copy_models(place.path());
    let mut ran = 0;
    for document in DOCUMENTS {
        let (ran_here, slow) = follow(place.path(), document);
        println!("{document}: {ran_here} commands ran, of {slow} slow ones the usage was checked");
        ran += ran_here;
    }
    assert!(ran >= 25, "{ran} commands ran");
    let known = |path: &Path| DOCUMENTS.iter().any(|document| path == repository(document));
    for entry in fs::read_dir(repository("docs")).unwrap() {
        let path = entry.unwrap().path();
        let text = fs::read_to_string(&path).unwrap_or_default();
        assert!(known(&path) || !text.contains("```sh"), "{} is not among DOCUMENTS", path.display());
    }
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
