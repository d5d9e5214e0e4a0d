//! One writer a folder: who writes a folder of results holds its lock.

use std::fs::{self, File, OpenOptions, TryLockError};
use std::io::Write;
use std::os::unix::fs::MetadataExt;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use super::{Action, RecordError, generation, leftovers};

/// The file that is locked, in a folder that is being written. It names its writer, and goes with it; what a killed one
/// leaves is no lock, as the system lets go of that.
pub const LOCK_FILE: &str = ".writer";
/// How long a new writer is given to write its name into the lock that it took, before that is read.
const NAMING: Duration = Duration::from_millis(20);
/// How long a lock may be held on: a child that a killed process was just starting holds it until it has begun.
const LETTING_GO: Duration = Duration::from_secs(1);

/// A folder that no other process writes to while this lives.
///
/// The system's lock on [`LOCK_FILE`] is held, so that it ends with the process, however that ends.
#[derive(Debug)]
pub struct FolderLock {
    folder: PathBuf,
    /// Keeps the lock.
    _file: File,
}

impl FolderLock {
    /// Takes a folder that is there. What writers that were killed left in it is put in order: a
    /// [`Generation`](super::Generation) that was whole is put in its place, parts of files and of generations are removed.
    ///
    /// # Errors
    /// [`RecordError::Busy`] where another process has it, [`RecordError::Io`] where it cannot be written to.
    pub fn take(folder: &Path) -> Result<FolderLock, RecordError> {
        let path = folder.join(LOCK_FILE);
        let io = || RecordError::io(folder, Action::Write);
        let began = Instant::now();
        let file = loop {
            let opened = OpenOptions::new().read(true).write(true).create(true).truncate(false).open(&path);
            let mut file = opened.map_err(io())?;
            match file.try_lock() {
                Err(TryLockError::WouldBlock) if began.elapsed() < LETTING_GO => {
                    std::thread::sleep(NAMING);
                    continue;
                }
                Err(TryLockError::WouldBlock) => return Err(busy(folder, &path)),
                // Where there are no locks, nobody else can be kept away.
                Ok(()) | Err(TryLockError::Error(_)) => {}
            }
            // Its writer may have ended, and taken it along, before it was locked here.
            let same = |there: fs::Metadata, here: fs::Metadata| {
                (there.dev(), there.ino()) == (here.dev(), here.ino())
            };
            if !fs::metadata(&path).is_ok_and(|there| file.metadata().is_ok_and(|here| same(there, here))) {
                continue;
            }
            // On a full disk the lock holds without a name as well.
            let _ = file.set_len(0).and_then(|()| file.write_all(own_name().as_bytes()));
            break file;
        };
        let lock = FolderLock { folder: folder.to_path_buf(), _file: file };
        generation::complete(folder)?;
        leftovers::sweep(folder);
        Ok(lock)
    }

    /// The folder.
    pub fn folder(&self) -> &Path {
        &self.folder
    }
}

impl Drop for FolderLock {
    fn drop(&mut self) {
        // While it is locked, it is this process' own. Left behind, it does no harm.
        let _ = fs::remove_file(self.folder.join(LOCK_FILE));
    }
}

/// What this process is called by others.
fn own_name() -> String {
    let host = fs::read_to_string("/proc/sys/kernel/hostname").unwrap_or_default();
    let on = Some(host.trim()).filter(|host| !host.is_empty()).map(|host| format!(" on {host}"));
    let words: Vec<String> = std::env::args_os().skip(1).map(|word| word.to_string_lossy().into()).collect();
    format!(
        "process {}{} (`{} {}`)",
        std::process::id(),
        on.unwrap_or_default(),
        env!("CARGO_PKG_NAME"),
        words.join(" ")
    )
}

/// Who holds a lock, as it says.
fn busy(folder: &Path, lock: &Path) -> RecordError {
    std::thread::sleep(NAMING);
    let name: String = fs::read_to_string(lock).unwrap_or_default();
    let name: String = name.chars().filter(|letter| !letter.is_control()).collect();
    let holder = if name.is_empty() { "another process".to_string() } else { name };
    RecordError::Busy { folder: folder.to_path_buf(), holder }
}
