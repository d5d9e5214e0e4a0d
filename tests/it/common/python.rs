//! Python for tests, with the packages that `.ci/run` puts into `target/python`.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use super::repository;

/// The folder of the packages.
pub fn packages() -> PathBuf {
    repository("target/python")
}

/// Runs a program in a folder; it must succeed. What it printed.
pub fn run(folder: &Path, program: &str) -> String {
    fs::write(folder.join("shown.py"), program).unwrap();
    let mut python = Command::new("python3");
    let output = python.arg("shown.py").current_dir(folder).env("PYTHONPATH", packages()).output().unwrap();
    let [out, message] =
        [&output.stdout, &output.stderr].map(|bytes| String::from_utf8_lossy(bytes).into_owned());
    assert!(
        output.status.success(),
        "python3 with what is in target/python, where .ci/run installs it: {message}"
    );
    out
}
