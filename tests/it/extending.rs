//! What `docs/house.md` promises: another one of each kind is a file, and its name in one table. A copy of the crate is given
//! one of each, and compiled.

use std::fs;
use std::os::unix::fs::symlink;
use std::path::Path;
use std::process::Command;

use crate::common::repository;
use crate::common::shell::copy;

/// Something that is added: its folder, its file's name and content, and its line in the table of a file of the folder.
struct Addition {
    folder: &'static str,
    module: &'static str,
    content: &'static str,
    /// The file that holds the table, and the line before that of the addition.
    table: (&'static str, &'static str),
    line: &'static str,
}

const ADDITIONS: [Addition; 7] = [
    Addition {
        folder: "senses",
        module: "steps",
        content: r#"//! Counts the steps of the simulation.

use super::sense::{Sense, SensedStep};
use crate::error::Result;

/// How many steps there were.
#[derive(Default)]
pub struct Steps(pub usize);

impl Sense for Steps {
    fn step(&mut self, _: &SensedStep) -> Result<()> {
        self.0 += 1;
        Ok(())
    }
}
"#,
        table: ("sense.rs", "pub const SENSES: &[NewSense] = &["),
        line: "    |_| Ok(Box::new(super::steps::Steps::default())),",
    },
    Addition {
        folder: "babbling/policy",
        module: "still",
        content: r#"//! Never moves.

use rand_chacha::ChaCha8Rng;

use super::Policy;
use crate::creature::Posture;
use crate::senses::Touch;

pub(super) struct Still;

impl Policy for Still {
    fn next_target(&mut self, posture: &[f64], _: &mut ChaCha8Rng) -> Posture {
        Posture::from(posture.to_vec())
    }

    fn touched(&mut self, _: &Touch) {}
}
"#,
        table: ("mod.rs", "policies! {"),
        line: "    /// None.\n    Still, \"still\" => |_, _| Box::new(still::Still);",
    },
    Addition {
        folder: "learning/learners",
        module: "again",
        content: r#"//! Another way to Hersch's rule repaired.

use super::{LearnerGivens, LearnerKind, HerschsRule};
use crate::agent::Agent;
use crate::learning::Learner;

pub(super) struct Again;

impl LearnerKind for Again {
    fn name(&self) -> &'static str {
        "again"
    }

    fn about(&self) -> &'static str {
        "the repaired rule once more"
    }

    fn learner(&self, agent: &Agent, given: &LearnerGivens, seed: u64) -> Box<dyn Learner> {
        HerschsRule.learner(agent, given, seed + 1)
    }
}
"#,
        table: ("mod.rs", "pub const LEARNERS: &[&dyn LearnerKind] = &["),
        line: "    &again::Again,",
    },
    Addition {
        folder: "interaction/conversation/requests",
        module: "shrugging",
        content: r#"//! "Whatever."

use super::{Act, Answer, RequestKind};

pub(super) const SHRUG: RequestKind =
    RequestKind::new(["shrug", "shrugged"], Act::Tells(|_, _| Answer::tells("Well")), "told: ^ whatever $");
"#,
        table: ("mod.rs", "requests! {"),
        line: "    /// Nothing.\n    Shrug => shrugging::SHRUG;",
    },
    Addition {
        folder: "study",
        module: "limbs",
        content: r#"//! How many limbs generated bodies have.

use serde_json::json;

use super::{Row, Studied, Study, Trial, columns};

pub(super) const STUDY: Study = Study {
    name: "limbs",
    about: "how many limbs there are",
    of: Studied::Generated,
    touches: None,
    seconds: None,
    cases: || vec!["all".into()],
    columns: columns! { case: Case, limbs: Median },
    notes: &[],
    run: |trial: &Trial| Ok(vec![Row::from(json!({"case": trial.cases[0], "limbs": trial.seed}))]),
};
"#,
        table: ("mod.rs", "pub const STUDIES: &[&Study] = &["),
        line: "    &limbs::STUDY,",
    },
    Addition {
        folder: "view/report",
        module: "greeting",
        content: r#"//! A friendly word.

use super::ReportInput;

pub(super) fn words(_: &ReportInput) -> String {
    "<p>Hello</p>".into()
}
"#,
        table: ("mod.rs", "const SECTIONS: &[Section] = &["),
        line: "    (\"Hello\", greeting::words),",
    },
    Addition {
        folder: "export",
        module: "names",
        content: r#"//! The limbs by name.

use std::path::Path;

use super::ExportedFile;
use crate::agent::Agent;
use crate::schema::BodySchema;

pub(super) fn files(agent: &Agent, _: &BodySchema, path: &Path) -> Vec<ExportedFile> {
    vec![(path.to_path_buf(), agent.creature().limbs().join("\n").into_bytes())]
}
"#,
        table: ("mod.rs", "pub const FORMATS: &[ExportFormat] = &["),
        line: "    ExportFormat { ending: \"txt\", about: \"names\", files: names::files },",
    },
];

/// Puts words after the line that begins the only place of its kind in a file.
fn put_after(path: &Path, line: &str, words: &str) {
    let text = fs::read_to_string(path).unwrap();
    assert_eq!(text.matches(line).count(), 1, "{}: {line}", path.display());
    fs::write(path, text.replacen(line, &format!("{line}\n{words}"), 1)).unwrap();
}

#[test]
#[ignore = "slow: compiles the crate once more"]
fn another_one_of_each_kind_is_a_file_and_its_name_in_one_table() {
    let place = tempfile::tempdir().unwrap();
    for entry in fs::read_dir(repository("")).unwrap().map(Result::unwrap) {
        let name = entry.file_name();
        let (from, to) = (entry.path(), place.path().join(&name));
        match name.to_str().unwrap() {
            "src" => copy(&from, &to),
            "target" => {}
            name if name.starts_with('.') => {}
            _ => symlink(from, to).unwrap(),
        }
    }
    for Addition { folder, module, content, table: (table, begins), line } in ADDITIONS {
        let folder = place.path().join("src").join(folder);
        fs::write(folder.join(format!("{module}.rs")), content).unwrap();
        // Before the first module, wherever that is.
        let modules = folder.join("mod.rs");
        let text = fs::read_to_string(&modules).unwrap();
        let first = text.lines().find(|line| line.starts_with("mod ")).unwrap();
        put_after(&modules, first, &format!("pub mod {module};"));
        put_after(&folder.join(table), begins, line);
    }
    let compiled = Command::new(env!("CARGO"))
        .args(["check", "--lib", "--quiet", "--locked", "--offline"])
        .current_dir(place.path())
        .env("CARGO_TARGET_DIR", repository("target"))
        .output()
        .unwrap();
    assert!(compiled.status.success(), "{}", String::from_utf8_lossy(&compiled.stderr));
}
