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

/// Asks for a form of a session that needs a feature which this build lacks: it is refused with the mend. Returns the
/// folder, in which the session is `s`.
#[cfg(not(all(feature = "parquet", feature = "rerun")))]
pub fn form_without_its_feature(form: &str, feature: &str) -> tempfile::TempDir {
    let place = tempfile::tempdir().unwrap();
    let hexapod = super::repository("mjcf/hexapod/hexapod.xml");
    let babble =
        ["babble", hexapod.to_str().unwrap(), "--touches", "20", "--learner", "hersch", "--out", "s"];
    succeeds(place.path(), &babble);
    let message = refused(place.path(), 1, &["convert", "s", form]);
    assert!(message.contains(&format!("--features {feature}")), "{message}");
    place
}
