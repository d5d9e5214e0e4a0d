//! A file that comes to its place when it is whole, a folder that never does, and folders that are kept once they hold something.

use std::fs::{self, File};
use std::io;
use std::path::{Path, PathBuf};

use super::files::sync_folder;
use super::leftovers::{part_name, sweep_parts};

/// A new file beside the place that it is to have, so that no reader sees a part of it. What is not put in its place is
/// removed.
#[derive(Debug)]
pub(crate) struct PartFile {
    place: PathBuf,
    part: PathBuf,
}

impl PartFile {
    /// Begins the file of a place, and removes what killed processes left of such ones.
    ///
    /// # Errors
    /// Where the place has no name.
    pub fn begin(place: &Path) -> io::Result<PartFile> {
        let name = place.file_name().ok_or(io::ErrorKind::InvalidFilename)?.to_string_lossy();
        sweep_parts(folder_of(place), |of| of == name);
        Ok(PartFile { place: place.to_path_buf(), part: place.with_file_name(part_name(&name)) })
    }

    /// Where it is to be written.
    pub fn path(&self) -> &Path {
        &self.part
    }

    /// Puts it in its place, once it is on the disk.
    ///
    /// # Errors
    /// Where the system refuses.
    pub fn put(self) -> io::Result<()> {
        File::open(&self.part)?.sync_all()?;
        fs::rename(&self.part, &self.place)?;
        sync_folder(folder_of(&self.place))
    }
}

impl Drop for PartFile {
    fn drop(&mut self) {
        // One that was put in its place is not here any more.
        let _ = fs::remove_file(&self.part);
    }
}

/// A new folder in another one, out of sight, for what is needed for a while. It is removed in the end, by the next who takes
/// the lock of that other one where this process is killed before.
#[derive(Debug)]
pub(crate) struct PartFolder(PathBuf);

impl PartFolder {
    /// Makes one of a name in `folder`, of which the lock is held.
    ///
    /// # Errors
    /// Where the system refuses.
    pub fn make(folder: &Path, name: &str) -> io::Result<PartFolder> {
        let part = PartFolder(folder.join(part_name(name)));
        let _ = fs::remove_dir_all(&part.0);
        fs::create_dir(&part.0)?;
        Ok(part)
    }

    /// Where it is.
    pub fn path(&self) -> &Path {
        &self.0
    }
}

impl Drop for PartFolder {
    fn drop(&mut self) {
        let _ = fs::remove_dir_all(&self.0);
    }
}

/// The folders that were made for results. Those that are still empty in the end are removed: a command that fails leaves none.
#[derive(Debug, Default)]
pub(crate) struct MadeFolders(Vec<PathBuf>);

impl MadeFolders {
    /// Makes a folder and those above it, where they are missing.
    ///
    /// # Errors
    /// Where the system refuses.
    pub fn make(folder: &Path) -> io::Result<MadeFolders> {
        let missing = folder.ancestors().take_while(|above| !above.as_os_str().is_empty() && !above.exists());
        let made = MadeFolders(missing.map(Path::to_path_buf).collect());
        fs::create_dir_all(folder)?;
        Ok(made)
    }

    /// Makes a folder that is not there yet, and those above it.
    ///
    /// # Errors
    /// [`io::ErrorKind::AlreadyExists`] where it is there, and where the system refuses.
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
