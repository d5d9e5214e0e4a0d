//! Reading several files of a folder, all of one generation.

use std::fs::File;
use std::path::Path;
use std::time::{Duration, Instant};

use super::{FolderLock, RecordError, generation};

/// How long another process may take to put a folder in order.
const PATIENCE: Duration = Duration::from_secs(60);
/// How often it is looked whether it has.
const LOOKED_EVERY: Duration = Duration::from_millis(2);

/// A folder whose files are not replaced while this lives; it may be read by many.
///
/// It is the system's lock on the folder itself, so that nothing is written for it. Where there are no such locks, as over
/// some networks, files can be replaced between the reading of one and the next.
#[derive(Debug)]
pub struct ReadLock {
    _folder: Option<File>,
}

impl ReadLock {
    /// Waits until nobody replaces files of a folder, and has them wait. Where a process was killed while it did, its work
    /// is done first. A folder that is not there is no error: whoever reads a file of it tells that.
    ///
    /// # Errors
    /// [`RecordError::Format`] where a process was killed while it replaced files, and that cannot be made good here.
    pub fn take(folder: &Path) -> Result<ReadLock, RecordError> {
        let began = Instant::now();
        loop {
            let Ok(opened) = File::open(folder) else { return Ok(ReadLock { _folder: None }) };
            let locked = opened.lock_shared().is_ok();
            if !generation::is_pending(folder) {
                return Ok(ReadLock { _folder: locked.then_some(opened) });
            }
            drop(opened);
            match FolderLock::take(folder) {
                // It may be that the one that has it is just putting it in order.
                Err(RecordError::Busy { .. }) if began.elapsed() < PATIENCE => {
                    std::thread::sleep(LOOKED_EVERY);
                }
                Ok(_) => {}
                Err(error) => {
                    let message = format!(
                        "a process was killed while it put new files in their places, and the rest cannot be done ({error}): \
                         give any command on this folder as one who may write to it"
                    );
                    return Err(RecordError::format(folder, None, message));
                }
            }
        }
    }
}
