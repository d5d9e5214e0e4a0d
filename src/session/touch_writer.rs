//! Writing the log of touches while they are made.

use std::fs::{File, OpenOptions};
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::time::Duration;

use super::TOUCHES_FILE;
use super::files::{self, lock};
use super::stamp::drop_zeros;
use super::touch_log::{STAMP, TouchHeader, TouchLine, UNITS, check, met};
use crate::agent::Agent;
use crate::error::Error;
use crate::senses::RecordedTouch;

/// Writes [`TOUCHES_FILE`], a line a touch.
///
/// Every touch is handed to the system in one piece as soon as it is written: where the process is
/// killed, at most the last line is incomplete, and [`read_touches`](super::read_touches) leaves that
/// one out, and [`TouchWriter::resume`] goes on in the middle of it. While a writer lives it holds the system's lock on
/// the file, so that no second one writes to it. After an error the writer is of no more use.
#[derive(Debug)]
pub struct TouchWriter<'a> {
    path: PathBuf,
    file: File,
    agent: &'a Agent,
    /// Lines written, the header included.
    lines: usize,
    buffer: Vec<u8>,
    /// What an interrupted writer left.
    left: Vec<u8>,
    /// How much of that has been written once more.
    passed: usize,
    /// Zero bytes that were at its end.
    zeros: usize,
}

/// Opens a log that no other process writes, without touching what is in it.
fn open_alone(path: &Path) -> Result<File, Error> {
    let opened = OpenOptions::new().append(true).create(true).open(path);
    let file = opened.map_err(Error::unwritable(path))?;
    lock(&file, Duration::ZERO).map_err(|_| {
        Error::content(path, None, "another process is writing to it: wait until it is done, or end it")
    })?;
    Ok(file)
}

impl<'a> TouchWriter<'a> {
    /// Begins the log in `folder`, which is made if missing; a log that is there is never overwritten.
    ///
    /// # Errors
    /// If the folder or the file cannot be made; or if there is a log
    /// already, or another process is writing it.
    pub fn create(folder: &Path, agent: &'a Agent) -> Result<TouchWriter<'a>, Error> {
        files::make_folder(folder)?;
        let path = folder.join(TOUCHES_FILE);
        let file = open_alone(&path)?;
        let about = file.metadata().map_err(Error::unwritable(&path))?;
        if about.len() > 0 {
            let message = "a log already exists: give another folder with --out, or move it away";
            return Err(Error::content(&path, None, message));
        }
        TouchWriter::of(path, file, agent, Vec::new(), 0)
    }

    /// Goes on with the log that an interrupted writer left in `folder`, if any. What is there stays: the touches that
    /// are written to it must be the same once more, from the first one on or after [`TouchWriter::skip`], and an
    /// incomplete last line is completed. Only what comes after is added. Zero bytes at its end, which a file system
    /// leaves where the power failed before it had stored what was written, are dropped.
    ///
    /// # Errors
    /// If the log cannot be read and written; or if another process is
    /// writing it, or where it is not of this creature.
    pub fn resume(folder: &Path, agent: &'a Agent) -> Result<TouchWriter<'a>, Error> {
        let path = folder.join(TOUCHES_FILE);
        let file = open_alone(&path)?;
        let mut left = files::read(&path)?;
        let zeros = drop_zeros(&mut left);
        if zeros > 0 {
            let cut = file.set_len(left.len() as u64).and_then(|()| file.sync_all());
            cut.map_err(Error::unwritable(&path))?;
        }
        TouchWriter::of(path, file, agent, left, zeros)
    }

    /// A writer that has written its header, or found it.
    fn of(
        path: PathBuf,
        file: File,
        agent: &'a Agent,
        left: Vec<u8>,
        zeros: usize,
    ) -> Result<TouchWriter<'a>, Error> {
        let mut writer =
            TouchWriter { path, file, agent, lines: 0, buffer: Vec::new(), left, passed: 0, zeros };
        writer.write_line(&STAMP.on(&TouchHeader {
            creature: agent.creature().name().into(),
            coordinates: agent.creature().coordinates(),
            units: UNITS.into(),
        }))?;
        Ok(writer)
    }

    /// How many zero bytes were at the end of the log that is gone on with, and were dropped.
    pub fn zeros(&self) -> usize {
        self.zeros
    }

    /// Passes over touches that an interrupted writer left, at most `touches`, without looking at them; how many whole
    /// ones there were.
    ///
    /// # Errors
    /// If the log cannot be read.
    pub fn skip(&mut self, touches: usize) -> Result<usize, Error> {
        for skipped in 0..touches {
            let line = self.next_left();
            match line.last() {
                Some(b'\n') => (self.passed, self.lines) = (self.passed + line.len(), self.lines + 1),
                Some(_) => {
                    let message = "incomplete line: delete it";
                    return Err(Error::content(&self.path, Some(self.lines + 1), message));
                }
                None => return Ok(skipped),
            }
        }
        Ok(touches)
    }

    /// Adds a touch.
    ///
    /// # Errors
    /// If writing fails, and for a touch that could not be
    /// read again: of another creature or skin, or with numbers that are not finite; and for one that is not
    /// what an interrupted writer left here. Such a touch is not written.
    pub fn write(&mut self, touch: &RecordedTouch) -> Result<(), Error> {
        let refuse = |message| Error::content(&self.path, Some(self.lines + 1), message);
        check(touch, self.agent).map_err(refuse)?;
        let met = met(touch, self.agent).map_err(refuse)?;
        let contact = touch.exact_contact();
        self.write_line(&TouchLine {
            bout: touch.bout,
            motion: touch.motion,
            posture: &touch.posture[..],
            receptors: met.map(|(receptor, _)| receptor.id.as_str()),
            limbs: met.map(|(_, limb)| limb),
            positions: met.map(|(receptor, _)| <[f64; 3]>::from(receptor.position)),
            contacts: contact.points.map(<[f64; 3]>::from),
            deviations: Some(contact.deviations).filter(|deviations| deviations.iter().any(Option::is_some)),
            time: touch.moment.map(|moment| moment.time),
            force: touch.moment.map(|moment| moment.force),
            depth: contact.depth.filter(|_| touch.moment.is_some()),
        })
    }

    /// Ends the log and waits until it is on the disk.
    ///
    /// # Errors
    /// If the system cannot store it, or if an interrupted writer left
    /// more than was written now.
    pub fn finish(self) -> Result<(), Error> {
        if !self.next_left().is_empty() {
            let message = "more touches than the session has: delete this line and all after it";
            return Err(Error::content(&self.path, Some(self.lines + 1), message));
        }
        match self.file.sync_all() {
            // What is no file, such as a pipe, has nothing to wait for.
            Err(error) if error.kind() == io::ErrorKind::InvalidInput => Ok(()),
            result => result.map_err(Error::unwritable(&self.path)),
        }
    }

    /// The next line that an interrupted writer left, which may lack its end; empty if there is none.
    fn next_left(&self) -> &[u8] {
        let left = &self.left[self.passed..];
        left.split_inclusive(|byte| *byte == b'\n').next().unwrap_or_default()
    }

    fn write_line(&mut self, content: &impl serde::Serialize) -> Result<(), Error> {
        self.buffer.clear();
        serde_json::to_writer(&mut self.buffer, content)
            .map_err(|error| Error::unwritable(&self.path)(error.into()))?;
        self.buffer.push(b'\n');
        // A line without its end is the last one, and the beginning of this one.
        let there = self.next_left().len();
        if !self.buffer.starts_with(self.next_left()) {
            return Err(Error::content(
                &self.path,
                Some(self.lines + 1),
                "it differs from what is babbled here: it was edited, or made by another version of bodyschema; \
                 babble again into another folder with --out",
            ));
        }
        self.file.write_all(&self.buffer[there..]).map_err(Error::unwritable(&self.path))?;
        self.passed += there;
        self.lines += 1;
        Ok(())
    }
}
