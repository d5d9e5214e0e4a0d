//! Opening the files that somebody gives: regular ones, and pipes that somebody writes to. What would keep a process waiting
//! for ever, or never come to an end, is told of instead.

use std::fs::{File, OpenOptions};
use std::io::{self, IsTerminal, Read};
use std::os::unix::fs::{FileTypeExt, OpenOptionsExt};
use std::path::Path;
use std::thread::sleep;
use std::time::{Duration, Instant};

/// How long a pipe may have nobody who writes to it before it is given up.
const PATIENCE: Duration = Duration::from_secs(3);
/// How often it is looked whether something has come through a pipe.
const LOOKED_EVERY: Duration = Duration::from_millis(1);
/// Bytes that are taken from a pipe at once.
const PIECE: usize = 1 << 16;

/// All bytes of a file, or of a pipe up to its writer's end, such as `/dev/stdin`.
///
/// # Errors
/// What the system says; where it is a folder or a device; where nobody writes to a pipe.
pub(crate) fn read(path: &Path) -> io::Result<Vec<u8>> {
    let mut file = OpenOptions::new().read(true).custom_flags(libc::O_NONBLOCK).open(path)?;
    let kind = file.metadata()?.file_type();
    if kind.is_fifo() || kind.is_char_device() && file.is_terminal() {
        return read_pipe(file);
    }
    let mut bytes = Vec::new();
    regular(&file)?;
    file.read_to_end(&mut bytes)?;
    Ok(bytes)
}

/// The text of a file or a pipe.
///
/// # Errors
/// As [`read`], and where it is not in UTF-8.
pub(crate) fn read_text(path: &Path) -> io::Result<String> {
    String::from_utf8(read(path)?).map_err(|_| io::Error::other("it is no text in UTF-8"))
}

/// Opens a regular file for reading.
///
/// # Errors
/// What the system says, and where it is anything else.
pub(crate) fn open(path: &Path) -> io::Result<File> {
    let file = OpenOptions::new().read(true).custom_flags(libc::O_NONBLOCK).open(path)?;
    regular(&file)?;
    Ok(file)
}

fn regular(file: &File) -> io::Result<()> {
    let kind = file.metadata()?.file_type();
    if kind.is_file() {
        return Ok(());
    }
    if kind.is_dir() {
        return Err(io::ErrorKind::IsADirectory.into());
    }
    Err(io::Error::other(if kind.is_fifo() {
        "it is a pipe, where a file is needed that can be read again"
    } else {
        "it is a device and no regular file"
    }))
}

/// What comes through a pipe that is opened without waiting.
fn read_pipe(mut pipe: File) -> io::Result<Vec<u8>> {
    // A terminal has nobody else who might come.
    let mut written = pipe.is_terminal();
    let began = Instant::now();
    let (mut bytes, mut piece) = (Vec::new(), vec![0; PIECE]);
    loop {
        match pipe.read(&mut piece) {
            Ok(0) if !written && began.elapsed() < PATIENCE => sleep(LOOKED_EVERY),
            Ok(0) if !written => {
                return Err(io::Error::other(format!(
                    "it is a pipe, and nobody has written to it for {} s",
                    PATIENCE.as_secs()
                )));
            }
            Ok(0) => return Ok(bytes),
            Ok(count) => {
                written = true;
                bytes.extend_from_slice(&piece[..count]);
            }
            // Somebody has it open and has not written yet.
            Err(error) if error.kind() == io::ErrorKind::WouldBlock => {
                written = true;
                sleep(LOOKED_EVERY);
            }
            Err(error) if error.kind() == io::ErrorKind::Interrupted => {}
            Err(error) => return Err(error),
        }
    }
}

#[cfg(test)]
mod tests {
    use std::process::Command;

    use super::*;

    #[test]
    fn a_pipe_is_read_where_somebody_writes_to_it_and_told_of_where_nobody_does() {
        let folder = tempfile::tempdir().unwrap();
        let pipe = folder.path().join("pipe");
        assert!(Command::new("mkfifo").arg(&pipe).status().unwrap().success());
        let long = vec![b'x'; 3 * PIECE];
        let (to, whole) = (pipe.clone(), long.clone());
        let writer = std::thread::spawn(move || {
            sleep(Duration::from_millis(100));
            std::fs::write(to, whole).unwrap();
        });
        assert_eq!(read(&pipe).unwrap(), long);
        writer.join().unwrap();
        let began = Instant::now();
        assert!(read(&pipe).unwrap_err().to_string().contains("nobody has written"));
        assert!(began.elapsed() < 2 * PATIENCE);
        assert!(open(&pipe).unwrap_err().to_string().contains("it is a pipe"));
    }

    #[test]
    fn folders_and_devices_are_no_files() {
        for read in
            [|path: &str| read(Path::new(path)).map(drop), |path: &str| open(Path::new(path)).map(drop)]
        {
            assert_eq!(read("/").unwrap_err().kind(), io::ErrorKind::IsADirectory);
            assert!(read("/dev/zero").unwrap_err().to_string().contains("device"));
        }
    }
}
