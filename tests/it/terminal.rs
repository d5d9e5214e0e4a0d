//! What a terminal shows: progress, colours and their absence, and the scripts that complete command lines.

use std::process::{Command, Output, Stdio};

use tempfile::TempDir;

const MODEL: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/mjcf/hexapod/hexapod.xml");

/// Runs a command on a terminal of its own, as `script` of util-linux makes one.
fn on_a_terminal(place: &TempDir, arguments: &str, environment: &[(&str, &str)]) -> String {
    let line = format!("stty cols 100; {} {arguments}", env!("CARGO_BIN_EXE_bodyschema"));
    let mut command = Command::new("script");
    command.args(["-qec", &line, "/dev/null"]).current_dir(place.path());
    command.env("TERM", "xterm").env_remove("NO_COLOR").envs(environment.iter().copied());
    let output = command.stdin(Stdio::null()).output().unwrap();
    assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stdout));
    String::from_utf8_lossy(&output.stdout).into_owned()
}

fn plain(arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_bodyschema")).args(arguments).output().unwrap()
}

/// Whether a text sets a colour or a style, as in `ESC [ 36 m`.
fn coloured(text: &str) -> bool {
    text.split("\u{1b}[")
        .skip(1)
        .any(|rest| rest.trim_start_matches(|c: char| c.is_ascii_digit() || c == ';').starts_with('m'))
}

#[test]
fn progress_has_rate_and_time_left_and_colours_only_where_they_are_wanted() {
    let babble =
        |out: &str| format!("babble {MODEL} --touches 1500 --input contact --learner hersch --out {out}");
    let place = tempfile::tempdir().unwrap();
    let shown = on_a_terminal(&place, &babble("a"), &[]);
    for words in ["babbling", "/1,500 touches", "/s", "left"] {
        assert!(shown.contains(words), "no {words} in {shown}");
    }
    assert!(coloured(&shown));
    let shown = on_a_terminal(&place, &babble("b"), &[("NO_COLOR", "1")]);
    assert!(shown.contains("babbling") && !coloured(&shown), "{shown}");
    let shown = on_a_terminal(&place, &format!("{} --quiet", babble("c")), &[]);
    assert!(!shown.contains("babbling") && !shown.contains('\u{1b}'), "{shown}");
    assert!(shown.contains("session: c"), "{shown}");
}

#[test]
fn help_is_coloured_on_a_terminal_alone_and_not_with_no_color() {
    let place = tempfile::tempdir().unwrap();
    assert!(coloured(&on_a_terminal(&place, "babble --help", &[])));
    assert!(!coloured(&on_a_terminal(&place, "babble --help", &[("NO_COLOR", "1")])));
    assert!(!coloured(&String::from_utf8_lossy(&plain(&["babble", "--help"]).stdout)));
}

#[test]
fn quiet_keeps_messages_back_but_not_errors() {
    let place = tempfile::tempdir().unwrap();
    let skin = |quiet: &[&str]| {
        let new = place.path().join("new.xml");
        let output = plain(&[&["skin", MODEL, "--out", new.to_str().unwrap()], quiet].concat());
        assert_eq!(output.status.code(), Some(0));
        String::from_utf8_lossy(&output.stderr).into_owned()
    };
    assert!(skin(&[]).contains("auras written to"));
    for quiet in ["--quiet", "-q"] {
        assert_eq!(skin(&[quiet]), "");
        let output = plain(&["inspect", "none.xml", quiet]);
        assert!(String::from_utf8_lossy(&output.stderr).contains("none.xml"));
    }
}

#[test]
fn shells_complete_commands_options_and_values() {
    for shell in ["bash", "zsh", "fish", "elvish", "powershell"] {
        let output = plain(&["completions", shell]);
        let script = String::from_utf8_lossy(&output.stdout).into_owned();
        assert_eq!(output.status.code(), Some(0), "{shell}");
        for word in ["babble", "resume", "reach"] {
            assert!(script.contains(word), "no {word} for {shell}");
        }
        assert!(!script.contains("rehearse"), "{shell} completes what is hidden");
    }
    // Bash itself completes with it.
    let complete = |words: &str| {
        let count = words.split(' ').count() - 1;
        let script = format!(
            "source <({} completions bash); COMP_WORDS=({words}); COMP_CWORD={count}; _bodyschema bodyschema \
             \"${{COMP_WORDS[$COMP_CWORD]}}\" \"${{COMP_WORDS[$COMP_CWORD-1]}}\"; echo \"${{COMPREPLY[@]}}\"",
            env!("CARGO_BIN_EXE_bodyschema")
        );
        let output = Command::new("bash").args(["-c", &script]).output().unwrap();
        String::from_utf8_lossy(&output.stdout).trim().to_string()
    };
    assert_eq!(complete("bodyschema bab"), "babble");
    assert_eq!(complete("bodyschema babble --res"), "--resume");
    assert_eq!(complete("bodyschema babble --policy sta"), "stages");
}
