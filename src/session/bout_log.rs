//! The log of bouts of a session's share, with the cost of each.

use std::fs::{File, OpenOptions};
use std::io::{self, Write};
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use super::{BOUTS_FILE, files, write_whole};
use crate::error::Error;
use crate::share::Share;
use crate::simulation::Effort;

/// A line of [`BOUTS_FILE`].
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct BoutLine {
    /// The bout's number in its session, from 0 on.
    pub bout: u64,
    /// Touches made in it.
    pub touches: usize,
    /// What its motions cost; how often gaps were looked at is not kept.
    pub effort: Effort,
}

/// Writes [`BOUTS_FILE`], a line a bout, each in one piece once all touches of the bout are in their log.
#[derive(Debug)]
pub struct BoutLog {
    path: PathBuf,
    file: File,
}

impl BoutLog {
    /// Begins the log in `folder`, or goes on with the first `bouts` lines of what is there.
    ///
    /// # Errors
    /// If it cannot be written.
    pub fn go_on(folder: &Path, bouts: &[BoutLine]) -> Result<BoutLog, Error> {
        let path = folder.join(BOUTS_FILE);
        let io = || Error::unwritable(&path);
        let mut text = Vec::new();
        bouts.iter().try_for_each(|bout| write(&mut text, bout)).map_err(io())?;
        write_whole(&path, &text).map_err(io())?;
        let file = OpenOptions::new().append(true).open(&path).map_err(io())?;
        Ok(BoutLog { path, file })
    }

    /// Adds a bout.
    ///
    /// # Errors
    /// If it cannot be written.
    pub fn write(&mut self, bout: &BoutLine) -> Result<(), Error> {
        let mut line = Vec::new();
        let written = write(&mut line, bout).and_then(|()| self.file.write_all(&line));
        written.map_err(Error::unwritable(&self.path))
    }

    /// Ends the log and waits until it is on the disk.
    ///
    /// # Errors
    /// If the system cannot store it.
    pub fn finish(self) -> Result<(), Error> {
        self.file.sync_all().map_err(Error::unwritable(&self.path))
    }
}

fn write(to: &mut Vec<u8>, bout: &BoutLine) -> io::Result<()> {
    let mut writer = csv::WriterBuilder::new().has_headers(false).from_writer(to);
    writer.serialize(bout).map_err(io::Error::other)?;
    writer.flush()
}

/// Reads the whole bouts of a share in its `folder`, with which the share begins; none if there is no [`BOUTS_FILE`]. What
/// follows on the last whole line, as a killed process or a power failure leaves it, is left out.
///
/// # Errors
/// If it cannot be read, or if a line is not that of the share's next bout.
pub fn read_bouts(folder: &Path, share: Share) -> Result<Vec<BoutLine>, Error> {
    let path = folder.join(BOUTS_FILE);
    let bytes = match files::read(&path) {
        Err(error) if error.system() == Some(io::ErrorKind::NotFound) => return Ok(Vec::new()),
        read => read?,
    };
    let whole = bytes.iter().rposition(|byte| *byte == b'\n').map_or(0, |last| last + 1);
    let mut reader = csv::ReaderBuilder::new().has_headers(false).from_reader(&bytes[..whole]);
    let bout = |(k, bout): (usize, csv::Result<BoutLine>)| {
        let wanted = share.piece(k as u64);
        let fault = match bout {
            Ok(bout) if bout.bout == wanted => return Ok(bout),
            Ok(other) => format!("it is of bout {}, not {wanted}", other.bout),
            Err(error) => format!("not a bout ({error})"),
        };
        let mend = format!("lines were added or lost; remove {} and make the share again", folder.display());
        Err(Error::content(&path, Some(k + 1), format!("{fault}: {mend}")))
    };
    reader.deserialize().enumerate().map(bout).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bouts_are_gone_on_with_after_the_last_whole_line() {
        let place = tempfile::tempdir().unwrap();
        let effort = Effort { motions: 9, bare: 2, simulated_s: 0.1 + 0.2, ..Effort::default() };
        let bouts = [0, 3, 6].map(|bout| BoutLine { bout, touches: 25, effort });
        let share = Share::new(1, 3).unwrap();
        let read_bouts = |folder: &Path| read_bouts(folder, share);
        assert_eq!(read_bouts(place.path()).unwrap(), []);
        let mut log = BoutLog::go_on(place.path(), &bouts[..1]).unwrap();
        log.write(&bouts[1]).unwrap();
        log.finish().unwrap();
        let path = place.path().join(BOUTS_FILE);
        let mut bytes = std::fs::read(&path).unwrap();
        bytes.extend(b"6,25,9,0,2,0,0,0.30");
        std::fs::write(&path, &bytes).unwrap();
        let read = read_bouts(place.path()).unwrap();
        assert_eq!(read, bouts[..2]);
        BoutLog::go_on(place.path(), &read).unwrap().write(&bouts[2]).unwrap();
        assert_eq!(read_bouts(place.path()).unwrap(), bouts);
        for (lines, line) in [("0,25,9\n", "line 1"), ("0,1,9,0,2,0,0,0.0\n0,1,9,0,2,0,0,0.0\n", "line 2")] {
            std::fs::write(&path, lines).unwrap();
            let message = read_bouts(place.path()).unwrap_err().to_string();
            assert!(message.contains(line) && message.contains("make the share again"), "{message}");
        }
    }
}
