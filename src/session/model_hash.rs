//! A model's fingerprint: by it a session knows whether its model has changed.

use std::fmt::Write;
use std::path::{Path, PathBuf};

use sha2::{Digest, Sha256};
use xmltree::{Element, XMLNode};

use super::{RecordError, files};

/// The SHA-256 of a model's XML, as `sha256:` and 64 hexadecimal digits.
///
/// It is that of the file's bytes, followed by those of the files that it includes, in the order in
/// which they are named, each followed by its own. So for a model of one file it is what `sha256sum`
/// prints. Meshes and height fields are not part of it.
///
/// # Errors
/// [`RecordError::Io`] where the file or one that it includes cannot be read.
pub fn model_hash(path: &Path) -> Result<String, RecordError> {
    let mut hash = Sha256::new();
    let folder = path.parent().unwrap_or(Path::new(""));
    add(&mut hash, path, folder, &mut vec![path.to_path_buf()])?;
    let mut text = String::from("sha256:");
    for byte in hash.finalize() {
        // Writing to a string cannot fail.
        let _ = write!(text, "{byte:02x}");
    }
    Ok(text)
}

/// Adds a file and what it includes, which MuJoCo seeks in the main file's `folder`.
fn add(hash: &mut Sha256, path: &Path, folder: &Path, seen: &mut Vec<PathBuf>) -> Result<(), RecordError> {
    let bytes = files::read(path)?;
    hash.update(&bytes);
    // Malformed XML is the engine's to complain about.
    let Ok(root) = Element::parse(bytes.as_slice()) else { return Ok(()) };
    let mut includes = Vec::new();
    find_includes(&root, &mut includes);
    for name in includes {
        // Newer engines also look beside the including file.
        let beside = path.with_file_name(&name);
        let main = folder.join(&name);
        let included = if !main.exists() && beside.exists() { beside } else { main };
        if !seen.contains(&included) {
            seen.push(included.clone());
            add(hash, &included, folder, seen)?;
        }
    }
    Ok(())
}

fn find_includes(element: &Element, found: &mut Vec<String>) {
    if element.name == "include" {
        found.extend(element.attributes.get("file").cloned());
    }
    for child in element.children.iter().filter_map(XMLNode::as_element) {
        find_includes(child, found);
    }
}
