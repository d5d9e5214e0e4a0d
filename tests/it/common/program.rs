//! Running the program in a folder, as a user would.

use std::path::Path;
use std::process::{Command, Output};

/// What a command line prints, and how it ends.
pub fn run(place: &Path, arguments: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_bodyschema"));
    command.args(arguments).current_dir(place).env("RUST_BACKTRACE", "0").output().unwrap()
}

/// What a command that succeeds prints on standard output.
pub fn succeeds(place: &Path, arguments: &[&str]) -> String {
    let output = run(place, arguments);
    assert_eq!(output.status.code(), Some(0), "{arguments:?}: {}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout).unwrap()
}

/// What a command says that fails with an exit code; it prints nothing else, and does not panic.
pub fn refused(place: &Path, code: i32, arguments: &[&str]) -> String {
    let output = run(place, arguments);
    let message = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(code), "{arguments:?}: {message}");
    assert!(output.stdout.is_empty() && !message.contains("panicked"), "{arguments:?}: {message}");
    message
}
