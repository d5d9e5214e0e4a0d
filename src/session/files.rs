//! Reading and writing files: each is put in its place once it is complete, JSON is such that people can read it, and folders are
//! kept once they hold something.

use std::fs::{self, File, OpenOptions, TryLockError};
use std::io::{self, Write};
use std::os::unix::fs::MetadataExt;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use serde::Serialize;

use crate::error::Error;
use crate::given_file;

/// How long another process may write the same file, or read a folder in which files are to be replaced.
pub(super) const PATIENCE: Duration = Duration::from_secs(60);
/// How often a lock is tried.
pub(super) const TRIED_EVERY: Duration = Duration::from_millis(2);

/// A new file beside the place that it is to have, so that no reader sees half of it. It is locked while it is written; one
/// that a killed process left is written anew by the next. What is not put in its place is removed.
#[derive(Debug)]
pub(crate) struct PartFile {
    place: PathBuf,
    part: PathBuf,
    file: File,
    /// Whether another process may have the name of the part by now.
    is_put: bool,
}

impl PartFile {
    /// Begins the file of a place.
    pub fn begin(place: &Path) -> io::Result<PartFile> {
        let name = place.file_name().ok_or(io::ErrorKind::InvalidFilename)?.to_string_lossy();
        let part = place.with_file_name(format!(".{name}.part"));
        let file = open_locked(&part, PATIENCE)?;
        file.set_len(0)?;
        Ok(PartFile { place: place.to_path_buf(), part, file, is_put: false })
    }

    /// Where it is to be written.
    pub fn path(&self) -> &Path {
        &self.part
    }

    /// Puts it in its place, once it is on the disk.
    pub fn put(mut self) -> io::Result<()> {
        self.file.sync_all()?;
        fs::rename(&self.part, &self.place)?;
        self.is_put = true;
        sync_folder(folder_of(&self.place))
    }
}

impl Drop for PartFile {
    fn drop(&mut self) {
        if !self.is_put {
            let _ = fs::remove_file(&self.part);
        }
    }
}

/// Writes a new file beside `path` and puts it in its place, so that no reader sees half of it.
pub(crate) fn write_whole(path: &Path, bytes: &[u8]) -> io::Result<()> {
    // What is not a file, such as a pipe, is never replaced.
    if fs::metadata(path).is_ok_and(|about| !about.is_file() && !about.is_dir()) {
        return fs::write(path, bytes);
    }
    let mut part = PartFile::begin(path)?;
    part.file.write_all(bytes)?;
    part.put()
}

/// Opens a file, which is made if missing, and locks it; [`io::ErrorKind::WouldBlock`] if another process has it for so
/// long. It is the file at its place, and not one that another process has just removed or renamed.
pub(super) fn open_locked(path: &Path, patience: Duration) -> io::Result<File> {
    loop {
        let file = OpenOptions::new().read(true).write(true).create(true).truncate(false).open(path)?;
        lock(&file, patience)?;
        let id = |about: fs::Metadata| (about.dev(), about.ino());
        let own = file.metadata().map(id)?;
        if fs::metadata(path).is_ok_and(|there| id(there) == own) {
            return Ok(file);
        }
    }
}

/// Locks an open file or folder; [`io::ErrorKind::WouldBlock`] if another process has it for so long. Where there are no locks,
/// nobody else can be kept away.
pub(super) fn lock(file: &File, patience: Duration) -> io::Result<()> {
    let began = Instant::now();
    loop {
        match file.try_lock() {
            Ok(()) | Err(TryLockError::Error(_)) => return Ok(()),
            Err(TryLockError::WouldBlock) if began.elapsed() < patience => std::thread::sleep(TRIED_EVERY),
            Err(TryLockError::WouldBlock) => return Err(io::ErrorKind::WouldBlock.into()),
        }
    }
}

/// The folders that were made for results. Those that are still empty in the end are removed: a command that fails leaves none.
#[derive(Debug, Default)]
pub(crate) struct MadeFolders(Vec<PathBuf>);

impl MadeFolders {
    /// Makes a folder and those above it, if they are missing.
    pub fn make(folder: &Path) -> io::Result<MadeFolders> {
        let missing = folder.ancestors().take_while(|above| !above.as_os_str().is_empty() && !above.exists());
        let made = MadeFolders(missing.map(Path::to_path_buf).collect());
        fs::create_dir_all(folder)?;
        Ok(made)
    }

    /// Makes a folder that does not exist, and those above it.
    pub fn make_new(folder: &Path) -> io::Result<MadeFolders> {
        let mut made = MadeFolders::make(folder_of(folder))?;
        fs::create_dir(folder)?;
        made.0.insert(0, folder.to_path_buf());
        Ok(made)
    }
}

impl Drop for MadeFolders {
    fn drop(&mut self) {
        // From within: the system removes none that holds anything.
        self.0.iter().for_each(|folder| drop(fs::remove_dir(folder)));
    }
}

pub(crate) fn folder_of(path: &Path) -> &Path {
    path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."))
}

/// Waits until the names in a folder are on the disk.
pub(super) fn sync_folder(folder: &Path) -> io::Result<()> {
    match File::open(folder)?.sync_all() {
        // Some file systems keep names without being asked, and refuse to be.
        Err(error) if matches!(error.kind(), io::ErrorKind::InvalidInput | io::ErrorKind::Unsupported) => {
            Ok(())
        }
        result => result,
    }
}

/// The bytes of a file, or what comes through a pipe.
pub(crate) fn read(path: &Path) -> Result<Vec<u8>, Error> {
    given_file::read(path).map_err(Error::unreadable(path))
}

/// Writes a file of results, whole or not at all. The folders above it are made, and go again where it cannot be written.
pub(crate) fn write(path: &Path, content: impl AsRef<[u8]>) -> Result<(), Error> {
    let folder = folder_of(path);
    let _made = MadeFolders::make(folder).map_err(Error::unwritable(folder))?;
    write_whole(path, content.as_ref()).map_err(Error::unwritable(path))
}

/// Writes a value as JSON that people can read, as [`write`] does.
pub(crate) fn write_json(path: &Path, value: &impl Serialize) -> Result<(), Error> {
    let json = serde_json::to_string_pretty(value).map_err(|error| Error::unwritable(path)(error.into()))?;
    write(path, on_lines(&json) + "\n")
}

/// JSON of one field a line, with every array of plain values on one line.
fn on_lines(pretty: &str) -> String {
    let mut json = String::with_capacity(pretty.len());
    // Where the innermost array begins, as long as it has plain values alone.
    let (mut array, mut quoted, mut escaped) = (None, false, false);
    for letter in pretty.chars() {
        match letter {
            '[' if !quoted => array = Some(json.len()),
            '{' | '}' if !quoted => array = None,
            ']' if !quoted => {
                if let Some(begin) = array.take() {
                    // No text has a line's end in it.
                    let values: String = json[begin..].split('\n').map(str::trim_start).collect();
                    json.truncate(begin);
                    json += &values;
                }
            }
            '"' if !escaped => quoted = !quoted,
            _ => {}
        }
        escaped = letter == '\\' && !escaped;
        json.push(letter);
    }
    json
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn arrays_of_plain_values_are_on_one_line() {
        let value =
            serde_json::json!({"a [\"]\\": [[1.0, -0.5], ["x\n  y", null]], "b": [], "c": [{"d": [true]}]});
        let json = on_lines(&serde_json::to_string_pretty(&value).unwrap());
        let lines = [
            "{",
            r#"  "a [\"]\\": ["#,
            "    [1.0,-0.5],",
            r#"    ["x\n  y",null]"#,
            "  ],",
            r#"  "b": [],"#,
            r#"  "c": ["#,
            "    {",
            r#"      "d": [true]"#,
            "    }",
            "  ]",
            "}",
        ];
        assert_eq!(json.lines().collect::<Vec<_>>(), lines);
    }
}
