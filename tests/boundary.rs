//! Who may know what, read off the sources: the agent's modules never name the truth, learning never
//! names the model, and `unsafe` stays behind the wall of `src/mujoco`.

mod common;

use std::path::{Path, PathBuf};

use common::repository;

/// Modules of the agent: none of them may name the truth.
const AGENT: [&str; 6] = ["learning", "schema", "babbling", "senses", "peripersonal", "interaction"];
/// What the truth is called.
const TRUTH: [&str; 2] = ["ground_truth", "GroundTruth"];
/// What would let the truth in by way of the model or the measures: for learning, the schema and its use.
const MODEL: [&str; 4] = ["mujoco", "Body", "evaluation", "Model"];

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
fn no_module_of_the_agent_names_the_truth() {
    for name in AGENT {
        assert!(!module(name).is_empty(), "module {name} has gone: amend this test");
    }
    for file in AGENT.iter().flat_map(|name| module(name)) {
        let found = names(&file, &TRUTH);
        assert!(found.is_empty(), "{} names {found:?}", file.display());
    }
}

#[test]
fn learning_the_schema_and_its_use_name_neither_the_model_nor_the_measures() {
    for file in ["learning", "schema", "peripersonal"].iter().flat_map(|name| module(name)) {
        let found = names(&file, &MODEL);
        assert!(found.is_empty(), "{} names {found:?}", file.display());
    }
}

#[test]
fn the_map_is_learned_without_knowing_where_receptors_are() {
    let file = repository("src/senses/learned_map.rs");
    let places = ["Skin", "Receptor", "Body", "Model", "mujoco", "nalgebra", "position", "normal", "point"];
    assert!(!names(&file, &["Firing"]).is_empty(), "the learner of the map has gone: amend this test");
    let found = names(&file, &places);
    assert!(found.is_empty(), "{} names {found:?}", file.display());
}

/// Where things and limbs really are in a scene: for those who measure, not for the one who acts.
const REALLY: [&str; 8] = [
    "thing_pose",
    "root_pose",
    "touching_at",
    "limb_pose",
    "limb_frames",
    "body_pose",
    "geom_pose",
    "GroundTruth",
];

#[test]
fn who_acts_in_a_scene_does_not_look_where_things_really_are() {
    for name in ["actor", "avoiding", "conversation", "tasks"] {
        let files = module(&format!("interaction/{name}"));
        assert!(!files.is_empty(), "interaction/{name} has gone: amend this test");
        for file in files {
            let found = names(&file, &REALLY);
            assert!(found.is_empty(), "{} names {found:?}", file.display());
        }
    }
}

#[test]
fn policies_name_neither_the_model_nor_the_measures() {
    let files = rust_files(&repository("src/babbling/policy"));
    assert!(!files.is_empty(), "the policies have gone: amend this test");
    for file in files {
        let found = names(&file, &MODEL);
        assert!(found.is_empty(), "{} names {found:?}", file.display());
    }
}

#[test]
fn the_truth_is_named_by_the_evaluation_and_the_command_line_alone() {
    let allowed = ["lib.rs", "ground_truth.rs", "evaluation", "cli"];
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
