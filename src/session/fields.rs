//! Fields of JSON that a format does not have: most likely one that it has, with a slip of the pen.

use serde_json::{Map, Value};

use crate::named::did_you_mean;

/// Refuses an object with a field that is none of `known`; `at` stands before its name, with a dot where it is a place.
pub(super) fn check_fields(map: &Map<String, Value>, at: &str, known: &[&str]) -> Result<(), String> {
    let Some(unknown) = map.keys().find(|key| !known.contains(&key.as_str())) else { return Ok(()) };
    let near = did_you_mean(unknown, known.iter().copied());
    let meant = near.map_or(String::new(), |near| format!(" (is {near} meant?)"));
    let fields = known.join(", ");
    Err(format!("{at}{unknown} is unknown{meant}: rename it or leave it out, the fields are {fields}"))
}
