//! Opening the files that somebody gives. Devices other than terminals are refused.

use std::fs::{self, File};
use std::io::{self, IsTerminal, Read};
use std::os::unix::fs::FileTypeExt;
use std::path::Path;

/// All bytes of a file, or of a pipe up to its writer's end, such as `/dev/stdin`.
///
/// # Errors
/// What the system says, and if it is a device.
pub(crate) fn read(path: &Path) -> io::Result<Vec<u8>> {
    let mut file = File::open(path)?;
    let kind = file.metadata()?.file_type();
    if kind.is_block_device() || kind.is_char_device() && !file.is_terminal() {
        return Err(io::Error::other("it is a device, not a regular file"));
    }
    let mut bytes = Vec::new();
    file.read_to_end(&mut bytes)?;
    Ok(bytes)
}

/// The text of a file or a pipe.
///
/// # Errors
/// As [`read`], and if it is not in UTF-8.
pub(crate) fn read_text(path: &Path) -> io::Result<String> {
    String::from_utf8(read(path)?).map_err(|_| io::Error::other("it is not UTF-8 text"))
}

/// Opens a regular file for reading.
///
/// # Errors
/// What the system says, and if it is anything else.
pub(crate) fn open(path: &Path) -> io::Result<File> {
    let about = fs::metadata(path)?;
    match about.is_file() {
        true => File::open(path),
        false if about.is_dir() => Err(io::ErrorKind::IsADirectory.into()),
        false => Err(io::Error::other("it is not a regular file, which is needed to read it again")),
    }
}
