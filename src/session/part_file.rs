//! A file that is put in its place once it is complete, and folders that are kept once they hold something.

use std::fs::{self, File, OpenOptions, TryLockError};
use std::io::{self, Write};
use std::os::unix::fs::MetadataExt;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

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
