//! The log of firing receptors: a firing a line, with nothing of where receptors are.

use std::collections::HashMap;
use std::fs::File;
use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use super::json_lines::read_log;
use super::stamp::Stamp;
use super::{FIRINGS_FILE, files};
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

/// Writes [`FIRINGS_FILE`], a line a firing.
#[derive(Debug)]
pub struct FiringWriter<'a> {
    path: PathBuf,
    file: BufWriter<File>,
    skin: &'a Skin,
}

impl<'a> FiringWriter<'a> {
    /// Begins the log in `folder`, which is made if missing; an older log there is overwritten.
    ///
    /// # Errors
    /// If the folder or the file cannot be made.
    pub fn create(folder: &Path, creature: &str, skin: &'a Skin) -> Result<FiringWriter<'a>, Error> {
        files::make_folder(folder)?;
        let path = folder.join(FIRINGS_FILE);
        let file = File::create(&path).map_err(Error::unwritable(&path))?;
        let mut writer = FiringWriter { path, file: BufWriter::new(file), skin };
        writer.line(&STAMP.on(&FiringHeader { creature: creature.to_string() }))?;
        Ok(writer)
    }

    /// Adds a firing of the skin's.
    ///
    /// # Errors
    /// If writing fails.
    pub fn write(&mut self, firing: &Firing) -> Result<(), Error> {
        let [first, last] = firing.span;
        let receptor = self.skin.receptors[firing.receptor].id.as_str();
        self.line(&FiringLine { receptor, first, last })
    }

    /// Ends the log.
    ///
    /// # Errors
    /// If writing fails.
    pub fn finish(mut self) -> Result<(), Error> {
        self.file.flush().map_err(Error::unwritable(&self.path))
    }

    fn line(&mut self, content: &impl Serialize) -> Result<(), Error> {
        let io = || Error::unwritable(&self.path);
        serde_json::to_writer(&mut self.file, content).map_err(|error| io()(error.into()))?;
        self.file.write_all(b"\n").map_err(io())
    }
}

/// Reads the firings of a creature's skin from the log `path`, in the log's order; the last line may be incomplete, as
/// a killed process leaves it, and is left out then.
///
/// # Errors
/// If the file cannot be read; with the line, if it is no log of
/// firings or one of a newer version, where it belongs to another creature or skin, and for any line that is no firing.
pub fn read_firings(path: &Path, creature: &str, skin: &Skin) -> Result<Vec<Firing>, Error> {
    let receptors: HashMap<&str, usize> =
        skin.receptors.iter().enumerate().map(|(r, receptor)| (receptor.id.as_str(), r)).collect();
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
