//! The log of firing receptors: a firing a line, with nothing of where receptors are.

use std::collections::HashMap;
use std::path::Path;

use serde::{Deserialize, Serialize};

use super::json_lines::read_log;
use super::stamp::Stamp;
use super::{FIRINGS_FILE, write_whole};
use crate::error::Error;
use crate::senses::Firing;
use crate::skin::Skin;

const STAMP: Stamp = Stamp { format: "bodyschema firings", version: 1 };

/// What the header says beside its stamp.
#[derive(Serialize, Deserialize)]
#[serde(expecting = "an object")]
struct FiringHeader {
    /// The creature's name.
    creature: String,
}

/// A firing as a line has it; times are seconds.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields, expecting = "an object")]
struct FiringLine<Id> {
    receptor: Id,
    first: f64,
    last: f64,
}

/// Writes the firings of a creature's skin to [`FIRINGS_FILE`] in `folder`, a line a firing; an older log there is replaced.
///
/// # Errors
/// If the file cannot be written.
pub fn write_firings(folder: &Path, creature: &str, skin: &Skin, firings: &[Firing]) -> Result<(), Error> {
    let path = folder.join(FIRINGS_FILE);
    let mut lines = serde_json::to_string(&STAMP.on(&FiringHeader { creature: creature.to_string() }))
        .map_err(|error| Error::unwritable(&path)(error.into()))?;
    for Firing { receptor, span: [first, last] } in firings {
        let line = FiringLine { receptor: &skin.receptors[*receptor].id, first: *first, last: *last };
        let line = serde_json::to_string(&line).map_err(|error| Error::unwritable(&path)(error.into()))?;
        lines = lines + "\n" + &line;
    }
    write_whole(&path, (lines + "\n").as_bytes()).map_err(Error::unwritable(&path))
}

/// Reads the firings of a creature's skin from the log `path`, in the log's order; the last line may be incomplete, as
/// a killed process leaves it, and is left out then.
///
/// # Errors
/// If the file cannot be read; with the line, if it is no log of
/// firings or one of a newer version, where it belongs to another creature or skin, and for any line that is no firing.
pub fn read_firings(path: &Path, creature: &str, skin: &Skin) -> Result<Vec<Firing>, Error> {
    let receptors = skin.numbers();
    let check = |header: FiringHeader| match header.creature {
        found if found == creature => Ok(()),
        found => {
            Err(format!("its firings are of \"{found}\", not of \"{creature}\": give the log of one session"))
        }
    };
    let mut firings = Vec::new();
    read_log(path, (STAMP, "firing"), check, |found| {
        firings.push(firing(&found, &receptors)?);
        Ok(())
    })?;
    Ok(firings)
}

fn firing(line: &FiringLine<String>, receptors: &HashMap<&str, usize>) -> Result<Firing, String> {
    let id = &line.receptor;
    let &receptor = receptors.get(id.as_str()).ok_or_else(|| {
        format!("the skin has no receptor \"{id}\": mend the line, or give the session it was recorded in")
    })?;
    let span = [line.first, line.last];
    if span.iter().any(|time| !time.is_finite() || time.abs() > 1e9) || span[0] > span[1] {
        return Err(format!(
            "receptor \"{id}\" cannot have fired from {} to {} s: give times in their order, or delete the line",
            span[0], span[1]
        ));
    }
    Ok(Firing { receptor, span })
}
