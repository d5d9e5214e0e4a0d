//! A folder of results: a named one, or a temporary one that is removed when its last user goes.

use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU32, Ordering};

use pyo3::prelude::*;

static COUNT: AtomicU32 = AtomicU32::new(0);

/// A folder, which is removed in the end if it is a temporary one of this process.
pub struct Folder {
    path: PathBuf,
    /// The process that made it, if it is temporary.
    temporary: Option<u32>,
}

impl Folder {
    /// The one that is named, else a new one.
    pub fn new(named: Option<PathBuf>) -> PyResult<Folder> {
        if let Some(path) = named {
            return Ok(Folder { path, temporary: None });
        }
        let process = std::process::id();
        loop {
            let number = COUNT.fetch_add(1, Ordering::Relaxed);
            let path = std::env::temp_dir().join(format!("bodyschema-python-{process}-{number}"));
            match std::fs::create_dir(&path) {
                Err(error) if error.kind() == std::io::ErrorKind::AlreadyExists => {}
                made => return Ok(made.map(|()| Folder { path, temporary: Some(process) })?),
            }
        }
    }

    pub fn path(&self) -> &Path {
        &self.path
    }

    pub fn is_temporary(&self) -> bool {
        self.temporary.is_some()
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        // What a process has from the one that it was forked from is not its own.
        if self.temporary == Some(std::process::id()) {
            let _ = std::fs::remove_dir_all(&self.path);
        }
    }
}
