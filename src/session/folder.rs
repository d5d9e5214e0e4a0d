//! A folder of results: one process writes it at a time, and what is replaced in it is replaced all at once.
//!
//! New files are written into [`PART`], out of sight. One rename makes of that [`WHOLE`]: from then on they are what the
//! folder holds, and all that is left is to move them to their places. A process that ends before the rename leaves the old
//! files. One that ends after it leaves moves, which whoever comes next makes first: a writer by [`FolderLock::take`], a
//! reader by [`ReadLock::take`].

use crate::error::{Error, Kind};
use std::fs::{self, File};
use std::io::{self, ErrorKind, Write};
use std::path::{Path, PathBuf};
use std::thread::sleep;
use std::time::{Duration, Instant};

use super::files::{MadeFolders, PATIENCE, TRIED_EVERY, lock, open_locked, sync_folder};
use super::{SCHEMA_FILE, SPACE_FILE};

/// The file that is locked, in a folder that is being written. It names its writer and is removed with the lock; the one
/// that a killed process leaves is not locked.
const LOCK_FILE: &str = ".writer";
/// Where new files are written.
const PART: &str = ".generation.part";
/// The same once all are written.
const WHOLE: &str = ".generation";
/// Among the new files, the names of the files that are removed when they come, a line each.
const REMOVED: &str = ".removed";
/// How long a new writer is given to write its name into the lock that it took.
const NAMING: Duration = Duration::from_millis(20);
/// How long a lock may be held on: a child that a killed process was just starting holds it until it has begun.
const LETTING_GO: Duration = Duration::from_secs(1);

/// A folder that no other process writes to while this lives.
///
/// The system's lock on the file `.writer` in it is held, so that it ends with the process, however that ends.
#[derive(Debug)]
pub struct FolderLock {
    place: PathBuf,
    part: PathBuf,
    /// The files of before that are removed when the new ones come; `None` if nothing is replaced.
    replaced: Option<Vec<String>>,
    /// Keeps the lock.
    _file: File,
    /// The folders that were made for it are removed if nothing was written there.
    made: MadeFolders,
}

impl FolderLock {
    /// Makes a folder if it is missing, and takes it. If it is still empty in the end it is removed.
    ///
    /// # Errors
    /// As [`FolderLock::take`], and if the folder cannot be made.
    pub fn make(folder: &Path) -> Result<FolderLock, Error> {
        let made = MadeFolders::make(folder).map_err(Error::unwritable(folder))?;
        let mut lock = FolderLock::take(folder)?;
        lock.made = made;
        Ok(lock)
    }

    /// Makes a folder and takes it; `None` if it exists.
    pub(crate) fn make_new(folder: &Path) -> Result<Option<FolderLock>, Error> {
        match MadeFolders::make_new(folder) {
            Err(error) if error.kind() == ErrorKind::AlreadyExists => Ok(None),
            Err(error) => Err(Error::unwritable(folder)(error)),
            Ok(made) => FolderLock::take(folder).map(|mut lock| {
                lock.made = made;
                Some(lock)
            }),
        }
    }

    /// Takes a folder that exists, and puts in order what killed writers left: new files that were all written are moved to
    /// their places, unfinished ones are removed.
    ///
    /// # Errors
    /// If another process has it, or if it cannot be written to.
    pub fn take(folder: &Path) -> Result<FolderLock, Error> {
        let path = folder.join(LOCK_FILE);
        let mut file = open_locked(&path, LETTING_GO).map_err(|error| match error.kind() {
            ErrorKind::WouldBlock => busy(folder, &path),
            _ => Error::unwritable(folder)(error),
        })?;
        // On a full disk the lock holds without a name, too.
        let _ = file.set_len(0).and_then(|()| file.write_all(own_name().as_bytes()));
        let (place, part) = (folder.to_path_buf(), folder.join(PART));
        let lock = FolderLock { place, part, replaced: None, _file: file, made: MadeFolders::default() };
        if folder.join(WHOLE).is_dir() {
            let _alone = wait_for_readers(folder)?;
            put_in_place(folder)?;
        }
        sweep(folder);
        Ok(lock)
    }

    /// From now on all is written apart: the files with these names stay until [`FolderLock::commit`] puts the new ones in
    /// their stead.
    pub(crate) fn replace(&mut self, files: &[&str]) -> Result<(), Error> {
        self.part()?;
        self.replaced = Some(files.iter().map(ToString::to_string).collect());
        Ok(())
    }

    /// Whether the results of before are replaced.
    pub(crate) fn replaces(&self) -> bool {
        self.replaced.is_some()
    }

    /// The folder that is locked, in which everything is in the end.
    pub(crate) fn place(&self) -> &Path {
        &self.place
    }

    /// Where files are written that may be seen before all are complete.
    pub fn folder(&self) -> &Path {
        if self.replaces() { &self.part } else { &self.place }
    }

    /// Where files are written that come together: nothing of them is seen before [`FolderLock::commit`], and nothing is
    /// left of them without it.
    ///
    /// # Errors
    /// If the folder cannot be written to.
    pub fn part(&self) -> Result<&Path, Error> {
        match fs::create_dir(&self.part) {
            Err(error) if error.kind() != ErrorKind::AlreadyExists => {
                Err(Error::unwritable(&self.place)(error))
            }
            _ => Ok(&self.part),
        }
    }

    /// Puts the files that were written apart into the folder: all of them, whatever happens meanwhile. Nothing is done if
    /// there are none.
    ///
    /// # Errors
    /// If a file cannot be stored; the folder is then as it was, or as it will be once the next command
    /// has put it in order; or if the folder is read for too long.
    pub fn commit(&self) -> Result<(), Error> {
        if !self.part.exists() {
            return Ok(());
        }
        let new = names(&self.part)?;
        // The slices of the space were made of the schema that is replaced.
        let of_schema = new.iter().any(|name| name == SCHEMA_FILE).then(|| SPACE_FILE.to_string());
        let old = self.replaced.iter().flatten().cloned().chain(of_schema);
        let removed: String = old.filter(|name| !new.contains(name)).map(|name| name + "\n").collect();
        let list = self.part.join(REMOVED);
        fs::write(&list, removed).map_err(Error::unwritable(&list))?;
        for path in new.iter().map(|name| self.part.join(name)).chain([list]) {
            let stored = File::open(&path).and_then(|file| file.sync_all());
            stored.map_err(Error::unwritable(&path))?;
        }
        sync_folder(&self.part).map_err(Error::unwritable(&self.part))?;
        let _alone = wait_for_readers(&self.place)?;
        let begun = fs::rename(&self.part, self.place.join(WHOLE)).and_then(|()| sync_folder(&self.place));
        begun.map_err(Error::unwritable(&self.place))?;
        put_in_place(&self.place)
    }
}

impl Drop for FolderLock {
    fn drop(&mut self) {
        // While it is locked, all of this is this process' own. Left behind, it does no harm.
        let _ = fs::remove_dir_all(self.place.join(PART));
        let _ = fs::remove_file(self.place.join(LOCK_FILE));
    }
}

/// A folder whose files are not replaced while this lives; it may be read by many.
///
/// It is the system's lock on the folder itself, so that nothing is written for it. Without such locks, as over some
/// networks, files can be replaced between the reading of one and the next.
#[derive(Debug)]
pub struct ReadLock {
    _folder: Option<File>,
}

impl ReadLock {
    /// Waits until nobody replaces files of a folder. If a process was killed while it did, its work is done first. A folder
    /// that does not exist is no error: whoever reads a file of it reports that.
    ///
    /// # Errors
    /// If a process was killed while it replaced files, and that cannot be completed here.
    pub fn take(folder: &Path) -> Result<ReadLock, Error> {
        let began = Instant::now();
        loop {
            let Ok(opened) = File::open(folder) else { return Ok(ReadLock { _folder: None }) };
            let locked = opened.lock_shared().is_ok();
            if !folder.join(WHOLE).is_dir() {
                return Ok(ReadLock { _folder: locked.then_some(opened) });
            }
            drop(opened);
            match FolderLock::take(folder) {
                // The one that has it may be just putting it in order.
                Err(error) if error.is_busy() && began.elapsed() < PATIENCE => sleep(TRIED_EVERY),
                Ok(_) => {}
                Err(error) => {
                    let message = format!(
                        "a process was killed while it moved new files into place, and this cannot be completed \
                         ({error}): run any command on this folder as a user with write permission"
                    );
                    return Err(Error::content(folder, None, message));
                }
            }
        }
    }
}

/// Waits until nobody reads a folder, and keeps readers away while the result lives, as far as there are locks on folders.
fn wait_for_readers(folder: &Path) -> Result<File, Error> {
    let opened = File::open(folder).map_err(Error::unreadable(folder))?;
    lock(&opened, PATIENCE).map_err(|_| {
        let what =
            "a process is still reading it, so nothing in it can be replaced: end that process and try again";
        Error::new(Kind::Busy, what).at(folder, None)
    })?;
    Ok(opened)
}

/// Moves new files to their places once all are written. It may have been begun, and ended, at any step before.
fn put_in_place(folder: &Path) -> Result<(), Error> {
    let whole = folder.join(WHOLE);
    let gone = |path: &Path| match fs::remove_file(path) {
        Err(error) if error.kind() != ErrorKind::NotFound => Err(Error::unwritable(folder)(error)),
        _ => Ok(()),
    };
    let list = whole.join(REMOVED);
    let removed = fs::read_to_string(&list).unwrap_or_default();
    removed.lines().try_for_each(|name| gone(&folder.join(name)))?;
    for name in names(&whole)? {
        let place = folder.join(&name);
        fs::rename(whole.join(name), &place).map_err(Error::unwritable(&place))?;
    }
    sync_folder(folder).map_err(Error::unwritable(folder))?;
    gone(&list)?;
    fs::remove_dir(&whole).map_err(Error::unwritable(folder))
}

/// The names of new files.
fn names(folder: &Path) -> Result<Vec<String>, Error> {
    let entries = fs::read_dir(folder).and_then(Iterator::collect::<io::Result<Vec<_>>>);
    let entries = entries.map_err(Error::unreadable(folder))?;
    let names = entries.iter().map(|entry| entry.file_name().to_string_lossy().into_owned());
    let mut names: Vec<String> = names.filter(|name| name != REMOVED).collect();
    names.sort();
    Ok(names)
}

/// Removes what killed processes left in a folder: an unfinished folder, and parts of files that nobody writes.
fn sweep(folder: &Path) {
    let _ = fs::remove_dir_all(folder.join(PART));
    for entry in fs::read_dir(folder).into_iter().flatten().flatten() {
        let name = entry.file_name().to_string_lossy().into_owned();
        let is_part = name.starts_with('.') && name.ends_with(".part");
        if is_part
            && entry.file_type().is_ok_and(|kind| kind.is_file())
            && File::open(entry.path()).is_ok_and(|file| lock(&file, Duration::ZERO).is_ok())
        {
            let _ = fs::remove_file(entry.path());
        }
    }
}

/// This process, as messages of others name it.
fn own_name() -> String {
    let host = fs::read_to_string("/proc/sys/kernel/hostname").unwrap_or_default();
    let on = if host.trim().is_empty() { String::new() } else { format!(" on {}", host.trim()) };
    let words: Vec<String> = std::env::args_os().skip(1).map(|word| word.to_string_lossy().into()).collect();
    format!("process {}{on} (`{} {}`)", std::process::id(), env!("CARGO_PKG_NAME"), words.join(" "))
}

/// Which process holds a lock, as its file says.
fn busy(folder: &Path, lock: &Path) -> Error {
    sleep(NAMING);
    let name = fs::read_to_string(lock).unwrap_or_default();
    let name: String = name.chars().filter(|letter| !letter.is_control()).collect();
    let holder = if name.is_empty() { "another process".to_string() } else { name };
    let what = format!("{holder} is writing to it: wait until it is done, or give another folder");
    Error::new(Kind::Busy, what).at(folder, None)
}
