//! Who may know what, as far as types cannot say it: the agent's modules import neither the truth nor what would let it
//! in, and `unsafe` stays behind the wall of `src/mujoco`.

use std::path::{Path, PathBuf};

use crate::common::repository;

/// Modules of the agent: they get an `Agent` and a handle of the simulation. What those offer is in their types; that
/// nothing else is reached for is said here.
const AGENT: [&str; 5] = ["learning", "schema", "babbling", "peripersonal", "interaction"];
/// What would let the truth in: by its name, by way of the model, of the exact contact beside a touch, of the side of the
/// simulation that looks on, or of the measures.
const NOT_THE_AGENTS: [&str; 13] = [
    "ExactContact",
    "exact_contact",
    "exact_contact_mut",
    "ground_truth",
    "GroundTruth",
    "mujoco",
    "Body",
    "Model",
    "Data",
    "Stage",
    "evaluation",
    "session",
    "study",
];
/// What the truth is called.
const TRUTH: [&str; 2] = ["ground_truth", "GroundTruth"];

/// The identifiers of Rust source text: comments, strings and characters are left out.
fn identifiers(source: &str) -> Vec<String> {
    let chars: Vec<char> = source.chars().collect();
    let at = |i: usize| chars.get(i).copied().unwrap_or('\0');
    let (mut found, mut i) = (Vec::new(), 0);
    while i < chars.len() {
        let c = chars[i];
        if c == '/' && at(i + 1) == '/' {
            while i < chars.len() && chars[i] != '\n' {
                i += 1;
            }
        } else if c == '/' && at(i + 1) == '*' {
            let mut depth = 0;
            loop {
                match (at(i), at(i + 1)) {
                    ('/', '*') => (depth, i) = (depth + 1, i + 2),
                    ('*', '/') => (depth, i) = (depth - 1, i + 2),
                    _ => i += 1,
                }
                if depth == 0 || i >= chars.len() {
                    break;
                }
            }
        } else if c == '"' {
            i += 1;
            while i < chars.len() && chars[i] != '"' {
                i += if chars[i] == '\\' { 2 } else { 1 };
            }
            i += 1;
        } else if c == '\'' && at(i + 1) == '\\' {
            i += 3;
            while i < chars.len() && chars[i] != '\'' {
                i += 1;
            }
            i += 1;
        } else if c == '\'' && at(i + 2) == '\'' {
            i += 3;
        } else if c == '_' || c.is_alphabetic() {
            let start = i;
            while at(i) == '_' || at(i).is_alphanumeric() {
                i += 1;
            }
            let word: String = chars[start..i].iter().collect();
            let hashes = chars[i..].iter().take_while(|&&c| c == '#').count();
            if matches!(word.as_str(), "r" | "br" | "cr") && at(i + hashes) == '"' {
                // A raw string, up to its quote and as many hashes.
                let end: String = std::iter::once('"').chain(std::iter::repeat_n('#', hashes)).collect();
                let rest: String = chars[i + hashes + 1..].iter().collect();
                let length = rest.find(&end).map_or(rest.len(), |bytes| bytes + end.len());
                i += hashes + 1 + rest[..length].chars().count();
            } else {
                found.push(word);
            }
        } else {
            i += 1;
        }
    }
    found
}

/// All Rust files below a folder, or none where it does not exist.
fn rust_files(folder: &Path) -> Vec<PathBuf> {
    let mut files = Vec::new();
    for entry in std::fs::read_dir(folder).into_iter().flatten() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            files.extend(rust_files(&path));
        } else if path.extension().is_some_and(|extension| extension == "rs") {
            files.push(path);
        }
    }
    files.sort();
    files
}

/// The files of a module, whether a folder or a file.
fn module(name: &str) -> Vec<PathBuf> {
    let mut files = rust_files(&repository("src").join(name));
    files.extend(Some(repository("src").join(format!("{name}.rs"))).filter(|file| file.is_file()));
    files
}

fn names(file: &Path, words: &[&str]) -> Vec<String> {
    let found = identifiers(&std::fs::read_to_string(file).unwrap());
    found.into_iter().filter(|word| words.contains(&word.as_str())).collect()
}

#[test]
fn the_reader_of_sources_sees_code_and_nothing_else() {
    let source = r####"
        use crate::{creature::Body, kinematics}; // ground_truth
        /* GroundTruth /* nested GroundTruth */ still GroundTruth */
        /// [`crate::ground_truth`]
        let text = "ground_truth \" GroundTruth"; let raw = r#"GroundTruth " here"#;
        let (c, d, e) = ('"', '\'', '\u{41}'); fn f<'unsafe_lifetime>() {} let after = unsafe { x };
    "####;
    let found = identifiers(source);
    assert!(!found.iter().any(|word| TRUTH.contains(&word.as_str())), "{found:?}");
    for word in ["Body", "kinematics", "after", "unsafe", "unsafe_lifetime"] {
        assert!(found.iter().any(|other| other == word), "{word} of {found:?}");
    }
}

#[test]
fn no_module_of_the_agent_reaches_for_more_than_it_is_given() {
    for name in AGENT {
        let files = module(name);
        assert!(!files.is_empty(), "module {name} has gone: amend this test");
        for file in files {
            let found = names(&file, &NOT_THE_AGENTS);
            assert!(found.is_empty(), "{} names {found:?}", file.display());
        }
    }
}

#[test]
fn a_touch_has_receptors_and_nothing_of_the_engines_contact() {
    let file = repository("src/senses/touch.rs");
    assert!(!names(&file, &["Touch"]).is_empty(), "the touch has gone: amend this test");
    let found = names(&file, &["contact", "depth", "distance", "ExactContact", "SkinSpot", "mujoco"]);
    assert!(found.is_empty(), "{} names {found:?}", file.display());
    // Babbling hands records on; none of the others gets one.
    for name in AGENT.into_iter().filter(|name| *name != "babbling") {
        for file in module(name) {
            assert!(names(&file, &["RecordedTouch"]).is_empty(), "{} gets records", file.display());
        }
    }
}

#[test]
fn where_joints_are_is_read_from_the_model_in_one_place() {
    let source = repository("src");
    let readers: Vec<PathBuf> = rust_files(&source)
        .into_iter()
        .filter(|file| !file.starts_with(source.join("mujoco")) && !names(file, &["joint_axis"]).is_empty())
        .collect();
    assert_eq!(readers, [source.join("ground_truth.rs")]);
}

#[test]
fn the_map_is_learned_without_knowing_where_receptors_are() {
    let file = repository("src/senses/learned_map.rs");
    let places = ["Skin", "Receptor", "Body", "Model", "mujoco", "nalgebra", "position", "normal", "point"];
    assert!(!names(&file, &["Firing"]).is_empty(), "the learner of the map has gone: amend this test");
    let found = names(&file, &places);
    assert!(found.is_empty(), "{} names {found:?}", file.display());
}

#[test]
fn the_truth_is_named_by_those_who_simulate_and_measure_alone() {
    let allowed =
        ["lib.rs", "ground_truth.rs", "simulation", "evaluation", "session", "study", "view", "cli"];
    let source = repository("src");
    for file in rust_files(&source) {
        let first = file.strip_prefix(&source).unwrap().components().next().unwrap();
        let first = first.as_os_str().to_str().unwrap().to_string();
        let found = names(&file, &TRUTH);
        assert!(found.is_empty() || allowed.contains(&first.as_str()), "{} names {found:?}", file.display());
    }
}

#[test]
fn unsafe_code_is_in_the_mujoco_layer_alone() {
    let (source, wall) = (repository("src"), repository("src/mujoco"));
    let files = rust_files(&source);
    assert!(files.iter().any(|file| file.starts_with(&wall)));
    for file in files.iter().filter(|file| !file.starts_with(&wall)) {
        let found = names(file, &["unsafe"]);
        assert!(found.is_empty(), "{} has unsafe code", file.display());
        // Nor may anyone but the crate's root, which denies it, speak of allowing it.
        let speaks = !names(file, &["unsafe_code"]).is_empty();
        assert!(!speaks || *file == source.join("lib.rs"), "{}", file.display());
    }
    let root = std::fs::read_to_string(source.join("lib.rs")).unwrap();
    assert!(root.contains("#![deny(unsafe_code)]"));
}
