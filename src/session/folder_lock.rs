//! One writer a folder: who writes a folder of results holds its lock.

use std::fs::{self, File, OpenOptions, TryLockError};
use std::io::{self, ErrorKind, Write};
use std::os::unix::fs::MetadataExt;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use super::part_file::{MadeFolders, PartFolder};
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
    place: PathBuf,
    /// Where results are written that replace others only when they are complete, and the names of the files that these may have.
    aside: Option<(PartFolder, Vec<String>)>,
    /// Keeps the lock.
    _file: File,
    /// What was made for it goes when it is released, unless something was written there.
    made: MadeFolders,
}

impl FolderLock {
    /// Makes a folder where it is missing and takes it. A folder that was made so and is still empty in the end is removed.
    ///
    /// # Errors
    /// As [`FolderLock::take`], and where the folder cannot be made.
    pub fn make(folder: &Path) -> Result<FolderLock, RecordError> {
        FolderLock::take_made(folder, MadeFolders::make(folder))
    }

    /// Makes a folder and takes it; none where it was there before.
    ///
    /// # Errors
    /// As [`FolderLock::make`].
    pub fn make_new(folder: &Path) -> Result<Option<FolderLock>, RecordError> {
        match MadeFolders::make_new(folder) {
            Err(error) if error.kind() == ErrorKind::AlreadyExists => Ok(None),
            made => FolderLock::take_made(folder, made).map(Some),
        }
    }

    fn take_made(folder: &Path, made: io::Result<MadeFolders>) -> Result<FolderLock, RecordError> {
        let made = made.map_err(RecordError::io(folder, Action::Write))?;
        let mut lock = FolderLock::take(folder)?;
        lock.made = made;
        Ok(lock)
    }

    /// From now on results are written aside: the files with these names that are in the folder stay until
    /// [`FolderLock::finish`] puts the new ones in their stead, all at once.
    ///
    /// # Errors
    /// [`RecordError::Io`] where the folder cannot be written to.
    pub fn replace(&mut self, files: &[&str]) -> Result<(), RecordError> {
        let aside = PartFolder::make(&self.place, "replacement");
        let aside = aside.map_err(RecordError::io(&self.place, Action::Write))?;
        self.aside = Some((aside, files.iter().map(ToString::to_string).collect()));
        Ok(())
    }

    /// Puts results that were written aside in their place; nothing is to be done where there are none.
    ///
    /// # Errors
    /// As [`Generation::commit`](super::Generation::commit).
    pub fn finish(&mut self) -> Result<(), RecordError> {
        let Some((aside, replaced)) = self.aside.take() else { return Ok(()) };
        generation::replace(aside.path(), &self.place, &replaced)
    }

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
        let (place, made) = (folder.to_path_buf(), MadeFolders::default());
        let lock = FolderLock { place, aside: None, _file: file, made };
        generation::complete(folder)?;
        leftovers::sweep(folder);
        Ok(lock)
    }

    /// Where to write.
    pub fn folder(&self) -> &Path {
        self.aside.as_ref().map_or(&self.place, |(aside, _)| aside.path())
    }

    /// The folder that is locked, in which everything is in the end.
    pub fn place(&self) -> &Path {
        &self.place
    }
}

impl Drop for FolderLock {
    fn drop(&mut self) {
        // While it is locked, it is this process' own. Left behind, it does no harm.
        let _ = fs::remove_file(self.place.join(LOCK_FILE));
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
