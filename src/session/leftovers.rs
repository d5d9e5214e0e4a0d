//! What killed processes leave in a folder: files and folders that never came to be.

use std::fs;
use std::path::Path;

use super::generation::{EARLIER_PART, PART};

/// Where the system shows its processes.
const PROCESSES: &str = "/proc";

/// The name of the file or folder that becomes `name` once it is whole, which this process writes.
pub(super) fn part_name(name: &str) -> String {
    format!(".{name}.{}.part", std::process::id())
}

/// Removes what processes that are no more left in a folder. Only for who has the folder's lock.
pub(super) fn sweep(folder: &Path) {
    for part in [PART, EARLIER_PART] {
        let _ = fs::remove_dir_all(folder.join(part));
    }
    sweep_parts(folder, |_| true);
}

/// Removes the parts of files and folders that processes which are no more left in a folder, of those of some names. Where the
/// system does not show its processes, nobody knows which are no more.
pub(super) fn sweep_parts(folder: &Path, of: impl Fn(&str) -> bool) {
    if !Path::new(PROCESSES).join("self").exists() {
        return;
    }
    for entry in fs::read_dir(folder).into_iter().flatten().flatten() {
        let file = entry.file_name();
        let Some((name, process)) = file.to_str().and_then(written_by) else { continue };
        if of(name) && !Path::new(PROCESSES).join(process.to_string()).exists() {
            let left = entry.path();
            let _ = if left.is_dir() { fs::remove_dir_all(left) } else { fs::remove_file(left) };
        }
    }
}

/// The name of the file that a part was to become, and the process that wrote it.
fn written_by(part: &str) -> Option<(&str, u32)> {
    let (name, process) = part.strip_prefix('.')?.strip_suffix(".part")?.rsplit_once('.')?;
    Some((name, process.parse().ok()?))
}
