//! All files of a result at once: a folder holds the old ones or the new ones, never some of both.
//!
//! The new files are written into [`PART`], out of sight. One rename makes of that [`WHOLE`]: from then on the new files
//! are what the folder holds, and what is left is to move them to their places. A process that ends before the rename leaves
//! the old files, and one that ends after it leaves moves to do, which whoever comes next does first: a writer by
//! [`FolderLock::take`], a reader by [`ReadLock::take`](super::ReadLock::take).

use std::fs::{self, File, TryLockError};
use std::io;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use super::{Action, FolderLock, RecordError, SCHEMA_FILE, SPACE_FILE, files};

/// Where a generation is written, in its folder.
pub(super) const PART: &str = ".generation.part";
/// A whole one, whose files are being moved to their places.
pub(super) const WHOLE: &str = ".generation";
/// Where files of before are copied to, until they are all there.
pub(super) const EARLIER_PART: &str = ".earlier.part";
/// In a generation that replaces all results of a folder, the names of the files that go when it comes, a line each.
const REMOVED: &str = ".removed";
/// Files that were made of a schema, and go with it.
const MADE_OF_SCHEMA: [&str; 1] = [SPACE_FILE];
/// How long files are not moved for the sake of those who read them; reading takes seconds.
const MOST_READING: Duration = Duration::from_secs(60);
/// How often it is looked whether they still do.
const LOOKED_EVERY: Duration = Duration::from_millis(2);

/// Files that come into a folder together or not at all.
#[derive(Debug)]
pub struct Generation<'a> {
    lock: &'a FolderLock,
    part: PathBuf,
}

impl<'a> Generation<'a> {
    /// Begins one: nothing of it can be seen in the folder before [`Generation::commit`], and nothing is left of one that
    /// is dropped before.
    ///
    /// # Errors
    /// [`RecordError::Io`] where the folder cannot be written to.
    pub fn begin(lock: &'a FolderLock) -> Result<Generation<'a>, RecordError> {
        let part = lock.folder().join(PART);
        let _ = fs::remove_dir_all(&part);
        fs::create_dir(&part).map_err(RecordError::io(lock.folder(), Action::Write))?;
        Ok(Generation { lock, part })
    }

    /// Where its files are to be written, each under its own name.
    pub fn folder(&self) -> &Path {
        &self.part
    }

    /// Where they will be after [`Generation::commit`].
    pub fn place(&self) -> &Path {
        self.lock.folder()
    }

    /// Copies what the generation is to replace into the first free of earlier-1, -2, … in the folder; none where there is
    /// nothing.
    ///
    /// # Errors
    /// [`RecordError::Io`] where a file cannot be copied.
    pub fn keep_earlier(&self) -> Result<Option<PathBuf>, RecordError> {
        let place = self.place();
        let names = self.names()?;
        let named = names.iter().map(PathBuf::as_path).chain(MADE_OF_SCHEMA.map(Path::new));
        let there: Vec<&Path> = named.filter(|name| place.join(name).is_file()).collect();
        if there.is_empty() {
            return Ok(None);
        }
        let part = place.join(EARLIER_PART);
        let _ = fs::remove_dir_all(&part);
        fs::create_dir(&part).map_err(RecordError::io(place, Action::Write))?;
        for name in there {
            let copy = part.join(name);
            let copied =
                fs::copy(place.join(name), &copy).and_then(|_| File::open(&copy)).and_then(|f| f.sync_all());
            copied.map_err(RecordError::io(&copy, Action::Write))?;
        }
        let earlier = (1..)
            .map(|k: u32| place.join(format!("earlier-{k}")))
            .find(|earlier| fs::symlink_metadata(earlier).is_err())
            .expect("some number is free");
        fs::rename(&part, &earlier).map_err(RecordError::io(&earlier, Action::Write))?;
        Ok(Some(earlier))
    }

    /// Puts its files into the folder: all of them, whatever happens meanwhile.
    ///
    /// # Errors
    /// [`RecordError::Io`] where a file cannot be stored; the folder is then as it was, or as it will be once the next
    /// command has put it in order.
    pub fn commit(self) -> Result<(), RecordError> {
        commit(&self.part, self.place())
    }

    /// The names of its files.
    fn names(&self) -> Result<Vec<PathBuf>, RecordError> {
        names(&self.part)
    }
}

impl Drop for Generation<'_> {
    fn drop(&mut self) {
        // One that is committed is not there any more; what is left is swept by the next writer.
        let _ = fs::remove_dir_all(&self.part);
    }
}

/// Puts the files of a folder within `place` there in the stead of some that are named, which go.
pub(super) fn replace(part: &Path, place: &Path, replaced: &[String]) -> Result<(), RecordError> {
    let removed = replaced.iter().filter(|name| !part.join(name).exists());
    let removed: String = removed.map(|name| format!("{name}\n")).collect();
    let list = part.join(REMOVED);
    fs::write(&list, removed).map_err(RecordError::io(&list, Action::Write))?;
    commit(part, place)
}

/// Puts the files of a folder within `place` there, all at once.
fn commit(part: &Path, place: &Path) -> Result<(), RecordError> {
    for name in all_names(part)? {
        let path = part.join(name);
        File::open(&path).and_then(|file| file.sync_all()).map_err(RecordError::io(&path, Action::Write))?;
    }
    files::sync_folder(part).map_err(RecordError::io(part, Action::Write))?;
    let _alone = Unread::wait(place)?;
    fs::rename(part, place.join(WHOLE)).map_err(RecordError::io(place, Action::Write))?;
    files::sync_folder(place).map_err(RecordError::io(place, Action::Write))?;
    put_in_place(place)
}

/// Whether files of a generation are still to be moved to their places.
pub(super) fn is_pending(folder: &Path) -> bool {
    folder.join(WHOLE).is_dir()
}

/// Does what a process that was killed left to do. Only for who has the folder's lock.
pub(super) fn complete(folder: &Path) -> Result<(), RecordError> {
    if !is_pending(folder) {
        return Ok(());
    }
    let _alone = Unread::wait(folder)?;
    put_in_place(folder)
}

/// Moves the files of a whole generation to their places. It may have been begun, and ended, at any step before.
fn put_in_place(folder: &Path) -> Result<(), RecordError> {
    let whole = folder.join(WHOLE);
    let io = || RecordError::io(folder, Action::Write);
    let names = names(&whole)?;
    let gone = |path: &Path| match fs::remove_file(path) {
        Err(error) if error.kind() != io::ErrorKind::NotFound => Err(io()(error)),
        _ => Ok(()),
    };
    let list = whole.join(REMOVED);
    let removed = fs::read_to_string(&list).unwrap_or_default();
    removed.lines().try_for_each(|name| gone(&folder.join(name)))?;
    // The schema is moved last: as long as it is there, so may be what was made of the one before.
    if names.iter().any(|name| name == Path::new(SCHEMA_FILE)) {
        let mut made = MADE_OF_SCHEMA.iter().filter(|made| !whole.join(made).exists());
        made.try_for_each(|made| gone(&folder.join(made)))?;
    }
    let (schema, others): (Vec<_>, Vec<_>) =
        names.iter().partition(|name| name.as_path() == Path::new(SCHEMA_FILE));
    for name in others.into_iter().chain(schema) {
        let place = folder.join(name);
        fs::rename(whole.join(name), &place).map_err(RecordError::io(&place, Action::Write))?;
    }
    files::sync_folder(folder).map_err(io())?;
    gone(&list)?;
    fs::remove_dir(&whole).map_err(io())
}

/// The names of the files that a generation puts in a folder.
fn names(part: &Path) -> Result<Vec<PathBuf>, RecordError> {
    let mut names = all_names(part)?;
    names.retain(|name| name != Path::new(REMOVED));
    Ok(names)
}

/// The names of the files in a folder.
fn all_names(folder: &Path) -> Result<Vec<PathBuf>, RecordError> {
    let io = || RecordError::io(folder, Action::Read);
    let entries = fs::read_dir(folder).map_err(io())?;
    let names = entries.map(|entry| entry.map(|entry| PathBuf::from(entry.file_name())));
    let mut names = names.collect::<io::Result<Vec<PathBuf>>>().map_err(io())?;
    names.sort();
    Ok(names)
}

/// A folder that nobody reads while this lives, as far as there are locks on folders.
struct Unread {
    _folder: Option<File>,
}

impl Unread {
    fn wait(folder: &Path) -> Result<Unread, RecordError> {
        let opened = File::open(folder).map_err(RecordError::io(folder, Action::Read))?;
        let began = Instant::now();
        loop {
            match opened.try_lock() {
                Ok(()) => return Ok(Unread { _folder: Some(opened) }),
                Err(TryLockError::Error(_)) => return Ok(Unread { _folder: None }),
                Err(TryLockError::WouldBlock) if began.elapsed() < MOST_READING => {
                    std::thread::sleep(LOOKED_EVERY);
                }
                Err(TryLockError::WouldBlock) => {
                    let holder = "a process that does not come to its end".to_string();
                    return Err(RecordError::Read { folder: folder.to_path_buf(), holder });
                }
            }
        }
    }
}
