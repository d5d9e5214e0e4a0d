//! Writing the log of touches while they are made.

use std::fs::File;
use std::io::Write;
use std::path::{Path, PathBuf};

use super::touch_line::{Header, Line, STAMP, UNITS, check, limb_name};
use super::{Action, RecordError, TOUCHES_FILE, files};
use crate::creature::Creature;
use crate::senses::Touch;
use crate::skin::Skin;

/// Writes [`TOUCHES_FILE`], a line a touch.
///
/// Every touch is handed to the system in one piece as soon as it is written: where the process is
/// killed, at most the last line is incomplete, and [`read_touches`](super::read_touches) leaves that
/// one out. After a [`RecordError::Io`] the writer is of no more use.
#[derive(Debug)]
pub struct TouchWriter<'a> {
    path: PathBuf,
    file: File,
    creature: &'a Creature,
    skin: &'a Skin,
    /// Lines written, the header included.
    lines: usize,
    buffer: Vec<u8>,
}

impl<'a> TouchWriter<'a> {
    /// Begins the log in `folder`, which is made if missing; an older log there is overwritten.
    ///
    /// # Errors
    /// [`RecordError::Io`] where the folder or the file cannot be made.
    pub fn create(
        folder: &Path,
        creature: &'a Creature,
        skin: &'a Skin,
    ) -> Result<TouchWriter<'a>, RecordError> {
        files::make_folder(folder)?;
        let path = folder.join(TOUCHES_FILE);
        let file = File::create(&path).map_err(RecordError::io(&path, Action::Write))?;
        let mut writer = TouchWriter { path, file, creature, skin, lines: 0, buffer: Vec::new() };
        let header = Header {
            creature: creature.name().into(),
            coordinates: creature.coordinates(),
            units: UNITS.into(),
        };
        writer.write_line(&STAMP.on(&header))?;
        Ok(writer)
    }

    /// Adds a touch.
    ///
    /// # Errors
    /// [`RecordError::Io`] where writing fails, [`RecordError::Format`] for a touch that could not be
    /// read again: of another creature or skin, or with numbers that are not finite. Such a touch is
    /// not written.
    pub fn write(&mut self, touch: &Touch) -> Result<(), RecordError> {
        let refuse = |message| RecordError::format(&self.path, Some(self.lines + 1), message);
        check(touch, self.creature, self.skin).map_err(refuse)?;
        let limb = |k: usize| limb_name(self.creature, self.skin, touch.ends[k].receptor).map_err(refuse);
        let limbs = [limb(0)?, limb(1)?];
        let receptors = touch.ends.map(|end| &self.skin.receptors[end.receptor]);
        self.write_line(&Line {
            bout: touch.bout,
            motion: touch.motion,
            posture: touch.posture.as_slice(),
            receptors: receptors.map(|receptor| receptor.id.as_str()),
            limbs,
            positions: receptors.map(|receptor| <[f64; 3]>::from(receptor.position)),
            contacts: touch.ends.map(|end| <[f64; 3]>::from(end.contact)),
            deviations: Some(touch.ends.map(|end| end.deviation))
                .filter(|deviations| deviations.iter().any(Option::is_some)),
            time: touch.moment.map(|moment| moment.time),
            force: touch.moment.map(|moment| moment.force),
            depth: touch.moment.map(|moment| moment.depth),
        })
    }

    /// Ends the log and waits until it is on the disk.
    ///
    /// # Errors
    /// [`RecordError::Io`] where the system cannot store it.
    pub fn finish(self) -> Result<(), RecordError> {
        match self.file.sync_all() {
            // What is no file, such as a pipe, has nothing to wait for.
            Err(error) if error.kind() == std::io::ErrorKind::InvalidInput => Ok(()),
            result => result.map_err(RecordError::io(&self.path, Action::Write)),
        }
    }

    fn write_line(&mut self, content: &impl serde::Serialize) -> Result<(), RecordError> {
        self.buffer.clear();
        serde_json::to_writer(&mut self.buffer, content)
            .map_err(|error| RecordError::io(&self.path, Action::Write)(error.into()))?;
        self.buffer.push(b'\n');
        self.file.write_all(&self.buffer).map_err(RecordError::io(&self.path, Action::Write))?;
        self.lines += 1;
        Ok(())
    }
}
