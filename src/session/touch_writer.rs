//! Writing the log of touches while they are made.

use std::fs::{self, File, OpenOptions, TryLockError};
use std::io::{self, BufRead, BufReader, Read, Seek, SeekFrom, Write};
use std::os::unix::fs::FileTypeExt;
use std::path::{Path, PathBuf};

use super::touch_line::{STAMP, TouchHeader, TouchLine, UNITS, check, limb_name};
use super::{Action, RecordError, TOUCHES_FILE, files};
use crate::agent::Agent;
use crate::senses::Touch;

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
    /// What an interrupted writer left, from the next line on; none where the next line is to be written.
    left: Option<BufReader<File>>,
    /// Zero bytes that were at its end.
    zeros: u64,
}

/// How much of a log is looked at in one piece, bytes.
const PIECE: u64 = 1 << 16;

/// Opens a log that no other process writes, without touching what is in it.
fn open_alone(path: &Path) -> Result<File, RecordError> {
    // A pipe would keep it waiting.
    if fs::metadata(path).is_ok_and(|about| about.file_type().is_fifo()) {
        let message = "it is a pipe, and a log is a file: remove it, or give another folder with --out";
        return Err(RecordError::format(path, None, message));
    }
    let opened = OpenOptions::new().append(true).create(true).open(path);
    let file = opened.map_err(RecordError::io(path, Action::Write))?;
    match file.try_lock() {
        Err(TryLockError::WouldBlock) => {
            let message = "another process is writing it: wait for its end, or end it";
            Err(RecordError::format(path, None, message))
        }
        // Where there are no locks, nobody else can be kept away.
        Ok(()) | Err(TryLockError::Error(_)) => Ok(file),
    }
}

/// How many zero bytes a file ends with; it is left at its beginning.
fn zeros_at_end(file: &mut File) -> io::Result<u64> {
    let length = if file.metadata()?.is_file() { file.metadata()?.len() } else { 0 };
    let (mut end, mut piece) = (length, Vec::new());
    while end > 0 {
        let begin = end.saturating_sub(PIECE);
        piece.resize((end - begin) as usize, 0);
        file.seek(SeekFrom::Start(begin))?;
        file.read_exact(&mut piece)?;
        if let Some(last) = piece.iter().rposition(|byte| *byte != 0) {
            end = begin + last as u64 + 1;
            break;
        }
        end = begin;
    }
    file.rewind()?;
    Ok(length - end)
}

impl<'a> TouchWriter<'a> {
    /// Begins the log in `folder`, which is made if missing; a log that is there is never overwritten.
    ///
    /// # Errors
    /// [`RecordError::Io`] where the folder or the file cannot be made. [`RecordError::Format`] where there is a log
    /// already, or another process is writing it.
    pub fn create(folder: &Path, agent: &'a Agent) -> Result<TouchWriter<'a>, RecordError> {
        files::make_folder(folder)?;
        let path = folder.join(TOUCHES_FILE);
        let file = open_alone(&path)?;
        let about = file.metadata().map_err(RecordError::io(&path, Action::Write))?;
        if about.len() > 0 {
            let message = "there is a log already: give another folder with --out, or move it away";
            return Err(RecordError::format(&path, None, message));
        }
        let mut writer =
            TouchWriter { path, file, agent, lines: 0, buffer: Vec::new(), left: None, zeros: 0 };
        writer.write_header()?;
        Ok(writer)
    }

    /// Goes on with the log that an interrupted writer left in `folder`, if any. What is there stays: the touches that
    /// are written to it must be the same once more, from the first one on or after [`TouchWriter::skip`], and an
    /// incomplete last line is completed. Only what comes after is added. Zero bytes at its end, which a file system
    /// leaves where the power failed before it had stored what was written, are dropped.
    ///
    /// # Errors
    /// [`RecordError::Io`] where the log cannot be read and written. [`RecordError::Format`] where another process is
    /// writing it, or where it is not of this creature.
    pub fn resume(folder: &Path, agent: &'a Agent) -> Result<TouchWriter<'a>, RecordError> {
        let path = folder.join(TOUCHES_FILE);
        let file = open_alone(&path)?;
        let mut left = files::open(&path)?;
        let zeros = zeros_at_end(&mut left).map_err(RecordError::io(&path, Action::Read))?;
        if zeros > 0 {
            let length = file.metadata().map(|about| about.len() - zeros);
            let cut = length.and_then(|length| file.set_len(length)).and_then(|()| file.sync_all());
            cut.map_err(RecordError::io(&path, Action::Write))?;
        }
        let left = Some(BufReader::new(left));
        let mut writer = TouchWriter { path, file, agent, lines: 0, buffer: Vec::new(), left, zeros };
        writer.write_header()?;
        Ok(writer)
    }

    /// How many zero bytes were at the end of the log that is gone on with, and were dropped.
    pub fn zeros(&self) -> u64 {
        self.zeros
    }

    /// Passes over touches that an interrupted writer left, at most `touches`, without looking at them; how many whole
    /// ones there were.
    ///
    /// # Errors
    /// [`RecordError::Io`] where the log cannot be read.
    pub fn skip(&mut self, touches: usize) -> Result<usize, RecordError> {
        for skipped in 0..touches {
            match self.next_left()? {
                Some(line) if line.ends_with(b"\n") => self.lines += 1,
                Some(_) => {
                    let message = "it is no whole line: delete it";
                    return Err(RecordError::format(&self.path, Some(self.lines + 1), message));
                }
                None => return Ok(skipped),
            }
        }
        Ok(touches)
    }

    /// Adds a touch.
    ///
    /// # Errors
    /// [`RecordError::Io`] where writing fails, [`RecordError::Format`] for a touch that could not be
    /// read again: of another creature or skin, or with numbers that are not finite; and for one that is not
    /// what an interrupted writer left here. Such a touch is not written.
    pub fn write(&mut self, touch: &Touch) -> Result<(), RecordError> {
        let refuse = |message| RecordError::format(&self.path, Some(self.lines + 1), message);
        check(touch, self.agent).map_err(refuse)?;
        let limb = |k: usize| limb_name(self.agent, touch.ends[k].receptor).map_err(refuse);
        let limbs = [limb(0)?, limb(1)?];
        let receptors = touch.ends.map(|end| &self.agent.skin().receptors[end.receptor]);
        self.write_line(&TouchLine {
            bout: touch.bout,
            motion: touch.motion,
            posture: &touch.posture[..],
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
    /// [`RecordError::Io`] where the system cannot store it, [`RecordError::Format`] where an interrupted writer left
    /// more than was written now.
    pub fn finish(mut self) -> Result<(), RecordError> {
        if self.next_left()?.is_some() {
            let message =
                "there are more touches than the session is of: delete this line and those after it";
            return Err(RecordError::format(&self.path, Some(self.lines + 1), message));
        }
        match self.file.sync_all() {
            // What is no file, such as a pipe, has nothing to wait for.
            Err(error) if error.kind() == io::ErrorKind::InvalidInput => Ok(()),
            result => result.map_err(RecordError::io(&self.path, Action::Write)),
        }
    }

    fn write_header(&mut self) -> Result<(), RecordError> {
        self.write_line(&STAMP.on(&TouchHeader {
            creature: self.agent.creature().name().into(),
            coordinates: self.agent.creature().coordinates(),
            units: UNITS.into(),
        }))
    }

    /// The next line that an interrupted writer left.
    fn next_left(&mut self) -> Result<Option<Vec<u8>>, RecordError> {
        let Some(left) = &mut self.left else { return Ok(None) };
        let mut line = Vec::new();
        left.read_until(b'\n', &mut line).map_err(RecordError::io(&self.path, Action::Read))?;
        if line.is_empty() {
            self.left = None;
            return Ok(None);
        }
        Ok(Some(line))
    }

    fn write_line(&mut self, content: &impl serde::Serialize) -> Result<(), RecordError> {
        self.buffer.clear();
        serde_json::to_writer(&mut self.buffer, content)
            .map_err(|error| RecordError::io(&self.path, Action::Write)(error.into()))?;
        self.buffer.push(b'\n');
        // A line without its end is the last one, and the beginning of this one.
        let there = self.next_left()?.unwrap_or_default();
        if !there.ends_with(b"\n") {
            self.left = None;
        }
        if !self.buffer.starts_with(&there) {
            return Err(RecordError::format(
                &self.path,
                Some(self.lines + 1),
                "it is not what is babbled here: it was changed, or made by another version of bodyschema; \
                 babble anew into another folder with --out",
            ));
        }
        self.file
            .write_all(&self.buffer[there.len()..])
            .map_err(RecordError::io(&self.path, Action::Write))?;
        self.lines += 1;
        Ok(())
    }
}
