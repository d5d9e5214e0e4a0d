//! Command lines that documents show, and running them as a reader would.

use std::fs;
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::Instant;

use super::repository;
use super::served::Served;

/// What a line says of itself where it takes too long for a test: then only its usage is checked.
const SLOW: [&str; 2] = ["takes minutes", "takes hours"];

/// A line of a shell, as it is written, and whether it says that it is slow.
#[derive(Clone, Debug)]
pub struct Line {
    /// The line without its comment.
    pub text: String,
    /// Whether its comment says so.
    pub slow: bool,
}

impl Line {
    /// A line with its comment.
    pub fn new(line: &str) -> Line {
        let (text, comment) = line.split_once(" #").unwrap_or((line, ""));
        Line { text: text.trim().to_string(), slow: SLOW.iter().any(|slow| comment.contains(slow)) }
    }

    /// Checks the usage of what the line has bodyschema do, without doing it.
    pub fn check(&self) {
        let line = self.text.rsplit('|').next().unwrap_or_default();
        let line = line.split('>').next().unwrap_or_default();
        let words: Vec<&str> = line.split_whitespace().map(|word| word.trim_matches('\'')).collect();
        if words.first() != Some(&"bodyschema") {
            assert!(!self.slow, "{self:?}: nothing of it could be checked");
            return;
        }
        if let Err(error) = bodyschema::cli::check_usage(words) {
            panic!("{self:?}: {error}");
        }
    }

    /// Runs the line in a folder, or only checks its usage where it is slow; whether it ran.
    pub fn run(&self, folder: &Path) -> bool {
        self.check();
        if !self.slow {
            let begun = Instant::now();
            if self.text.starts_with("bodyschema view")
                || self.text == "bodyschema demo"
                || self.text.starts_with("bodyschema talk") && self.text.ends_with("--live")
            {
                // It serves until it is ended.
                let served = Served::started(shell(folder, &format!("exec {}", self.text)));
                let page = served.answer("GET", "/", "host: HERE\r\n", "");
                assert!(page.starts_with("HTTP/1.1 200"), "{self:?}: {page}");
            } else {
                run(folder, &self.text);
            }
            println!("{:.1} s: {}", begun.elapsed().as_secs_f64(), self.text);
        }
        !self.slow
    }
}

/// A shell that runs a line in a folder, with bodyschema in its path, where nobody types.
fn shell(folder: &Path, line: &str) -> Command {
    let program = Path::new(env!("CARGO_BIN_EXE_bodyschema"));
    let path = format!("{}:{}", program.parent().unwrap().display(), std::env::var("PATH").unwrap());
    let mut shell = Command::new("bash");
    shell.args(["-o", "pipefail", "-c", line]).current_dir(folder).env("PATH", path).stdin(Stdio::null());
    // What is installed for a user goes into the folder, too.
    shell.env("HOME", folder);
    // Nobody sits before a browser.
    for display in ["DISPLAY", "WAYLAND_DISPLAY", "BROWSER"] {
        shell.env_remove(display);
    }
    shell
}

/// Runs a line in a shell in a folder, with bodyschema in its path; it must succeed.
pub fn run(folder: &Path, line: &str) -> String {
    let output = shell(folder, line).output().unwrap();
    let [out, message] =
        [&output.stdout, &output.stderr].map(|bytes| String::from_utf8_lossy(bytes).into_owned());
    assert!(output.status.success(), "{line}: {message}{out}");
    out
}

/// Copies the repository's models and its robot into a folder, as a checkout has them.
pub fn copy_models(folder: &Path) {
    copy(&repository("mjcf"), &folder.join("mjcf"));
    copy(&repository("examples/robot"), &folder.join("examples/robot"));
}

/// Copies a folder with all that is in it.
pub fn copy(from: &Path, to: &Path) {
    fs::create_dir_all(to).unwrap();
    for entry in fs::read_dir(from).unwrap() {
        let entry = entry.unwrap();
        let to = to.join(entry.file_name());
        if entry.file_type().unwrap().is_dir() {
            copy(&entry.path(), &to);
        } else {
            fs::copy(entry.path(), to).unwrap();
        }
    }
}
