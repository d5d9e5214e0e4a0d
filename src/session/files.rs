//! Reading and writing the files of a session; JSON that people can read.

use std::fs::{self, File};
use std::io::{self, Write};
use std::path::Path;

use serde::Serialize;
use serde_json::ser::Formatter;

use super::part_file::write_whole;
use crate::error::Error;
use crate::given_file;

/// Makes a folder and those above it where they are missing.
pub(super) fn make_folder(folder: &Path) -> Result<(), Error> {
    fs::create_dir_all(folder).map_err(Error::unwritable(folder))
}

/// The bytes of a file, or what comes through a pipe.
pub(crate) fn read(path: &Path) -> Result<Vec<u8>, Error> {
    given_file::read(path).map_err(Error::unreadable(path))
}

/// Opens a regular file for reading.
pub(super) fn open(path: &Path) -> Result<File, Error> {
    given_file::open(path).map_err(Error::unreadable(path))
}

/// Writes a value as JSON that people can read, whole or not at all.
pub(super) fn write_json(path: &Path, value: &impl Serialize) -> Result<(), Error> {
    let mut json = Vec::new();
    let mut serializer = serde_json::Serializer::with_formatter(&mut json, Layout::default());
    value.serialize(&mut serializer).map_err(|error| Error::unwritable(path)(io::Error::other(error)))?;
    json.push(b'\n');
    write_whole(path, &json).map_err(Error::unwritable(path))
}

/// JSON of one field a line, with every array of plain values on one line.
#[derive(Default)]
struct Layout {
    depth: usize,
    /// Per open container, whether what it holds stands on lines of its own.
    broken: Vec<bool>,
    /// Whether a value of an array is due, which breaks the line if it is a container.
    due: bool,
}

impl Layout {
    fn break_line<W: ?Sized + Write>(&self, writer: &mut W) -> io::Result<()> {
        writer.write_all(b"\n")?;
        (0..self.depth).try_for_each(|_| writer.write_all(b"  "))
    }

    fn open<W: ?Sized + Write>(&mut self, writer: &mut W, mark: &[u8]) -> io::Result<()> {
        if std::mem::take(&mut self.due) {
            if let Some(broken) = self.broken.last_mut() {
                *broken = true;
            }
            self.break_line(writer)?;
        }
        self.depth += 1;
        self.broken.push(false);
        writer.write_all(mark)
    }

    fn close<W: ?Sized + Write>(&mut self, writer: &mut W, mark: &[u8]) -> io::Result<()> {
        self.due = false;
        self.depth -= 1;
        if self.broken.pop() == Some(true) {
            self.break_line(writer)?;
        }
        writer.write_all(mark)
    }
}

impl Formatter for Layout {
    fn begin_array<W: ?Sized + Write>(&mut self, writer: &mut W) -> io::Result<()> {
        self.open(writer, b"[")
    }

    fn end_array<W: ?Sized + Write>(&mut self, writer: &mut W) -> io::Result<()> {
        self.close(writer, b"]")
    }

    fn begin_array_value<W: ?Sized + Write>(&mut self, writer: &mut W, first: bool) -> io::Result<()> {
        self.due = true;
        if first { Ok(()) } else { writer.write_all(b",") }
    }

    fn end_array_value<W: ?Sized + Write>(&mut self, _: &mut W) -> io::Result<()> {
        self.due = false;
        Ok(())
    }

    fn begin_object<W: ?Sized + Write>(&mut self, writer: &mut W) -> io::Result<()> {
        self.open(writer, b"{")
    }

    fn end_object<W: ?Sized + Write>(&mut self, writer: &mut W) -> io::Result<()> {
        self.close(writer, b"}")
    }

    fn begin_object_key<W: ?Sized + Write>(&mut self, writer: &mut W, first: bool) -> io::Result<()> {
        if let Some(broken) = self.broken.last_mut() {
            *broken = true;
        }
        if !first {
            writer.write_all(b",")?;
        }
        self.break_line(writer)
    }

    fn begin_object_value<W: ?Sized + Write>(&mut self, writer: &mut W) -> io::Result<()> {
        writer.write_all(b": ")
    }
}
