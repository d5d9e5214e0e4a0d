//! What stands at a path that was given for a session's folder or for a model, and is none: in words, with the command that is
//! meant.

use crate::error::{Error, Kind};
use std::fs;
use std::path::Path;

use super::{SESSION_FILE, SHARES_FOLDER, STUDY_FILE, Session};

/// How models' files end.
const MODELS: [&str; 3] = ["xml", "mjcf", "urdf"];

/// Whether a path is called as a model's file.
pub(crate) fn is_model(path: &Path) -> bool {
    path.extension().is_some_and(|end| MODELS.iter().any(|model| end.eq_ignore_ascii_case(model)))
}

/// Why a path is no session's folder, and the fix.
pub(super) fn for_session(path: &Path) -> String {
    let place = path.display();
    let Ok(about) = fs::metadata(path) else {
        let near = path.parent().and_then(first_session);
        let near = near.map_or(String::new(), |near| format!(", such as {near}"));
        return format!("no such folder: give one written by `bodyschema babble MODEL`{near}");
    };
    if about.is_file() {
        let of_session = path.parent().filter(|folder| folder.join(SESSION_FILE).exists());
        return match of_session {
            Some(folder) => format!("it is a file of a session: give its folder, {}", folder.display()),
            None if is_model(path) => {
                format!(
                    "it is a model, not a session folder: `bodyschema babble {place}` makes a session from it"
                )
            }
            None => "it is a file, not a session folder: give a folder written by `bodyschema babble MODEL`"
                .into(),
        };
    }
    if path.join(STUDY_FILE).exists() {
        return "it is a study folder, not a session: its results are in study.json".into();
    }
    if path.join(SHARES_FOLDER).exists() {
        return format!(
            "it contains unmerged shares of a study: merge them with `bodyschema study merge {place}`"
        );
    }
    match first_session(path) {
        Some(session) => format!("it contains sessions but is not one: give one of them, such as {session}"),
        None => "it is not a session folder: give one written by `bodyschema babble MODEL`".into(),
    }
}

/// Why a folder is no model, and the fix; none of what may be one.
pub(crate) fn for_model(path: &Path) -> Option<String> {
    if !path.is_dir() {
        return None;
    }
    let model = Session::read(path).ok().map(|session| session.model).filter(|model| !model.is_empty());
    let what = match (model, first_session(path)) {
        (Some(model), _) => format!("it is a session folder, not a model: its model is {model}"),
        (None, Some(session)) => {
            format!("it is a folder of sessions, such as {session}, not a model: give an MJCF or URDF file")
        }
        (None, None) => "it is a folder, not a model: give an MJCF or URDF file".into(),
    };
    Some(format!("{}: {what}", path.display()))
}

/// Why a session has no schema, and the fix.
pub(super) fn for_schema(folder: &Path) -> Error {
    let place = folder.display();
    let sentence = format!(
        "the session has touches, but nothing has been learned from them: `bodyschema babble --resume {place}` \
         resumes an interrupted session, `bodyschema learn {place}` learns from the touches so far"
    );
    Error::new(Kind::NotLearned, sentence).at(folder, None)
}

/// The first session in a folder, by name.
fn first_session(folder: &Path) -> Option<String> {
    let folder = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
    let entries = fs::read_dir(folder).ok()?.flatten();
    let sessions = entries.map(|entry| entry.path()).filter(|path| path.join(SESSION_FILE).exists());
    sessions.min().map(|session| session.display().to_string())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_no_session_is_told_with_what_is_meant() {
        let place = tempfile::tempdir().unwrap();
        let path = |name: &str| place.path().join(name);
        fs::create_dir_all(path("sessions/max-1")).unwrap();
        fs::create_dir_all(path("shared/shares")).unwrap();
        fs::create_dir_all(path("study")).unwrap();
        for (file, text) in [
            ("sessions/max-1/session.json", "{}"),
            ("study/study.json", "{}"),
            ("max.XML", ""),
            ("log.csv", ""),
        ] {
            fs::write(path(file), text).unwrap();
        }
        for (given, told) in [
            ("max.XML", "babble"),
            ("log.csv", "it is a file"),
            ("sessions", "such as"),
            ("sessions/max-2", "max-1"),
            ("sessions/max-1/session.json", "give its folder"),
            ("shared", "merge"),
            ("study", "a study folder"),
            (".", "not a session folder"),
        ] {
            let sentence = for_session(&path(given));
            assert!(sentence.contains(told), "{given}: {sentence}");
        }
    }
}
