//! A file that comes to its place when it is whole.

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

fn folder_of(path: &Path) -> &Path {
    path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."))
}
