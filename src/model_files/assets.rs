//! The files of meshes, height fields and textures that a model names: the engine opens them itself, and would wait for ever
//! for what comes through a pipe.

use super::source::{Refused, Source, whole_folder_of, with_slashes};

/// Attributes by which the engine opens files.
const FILES: [&str; 7] = ["file", "fileright", "fileleft", "fileup", "filedown", "filefront", "fileback"];
/// The compiler's settings for their folders.
const FOLDERS: [&str; 3] = ["meshdir", "texturedir", "assetdir"];

/// Checks that no file that a model names is a pipe or a device.
///
/// # Errors
/// Where one is.
pub(super) fn check(source: &Source) -> Result<(), Refused> {
    let folder = whole_folder_of(&source.path);
    let compilers = source.root.all("compiler");
    let own = compilers.flat_map(|compiler| FOLDERS.iter().filter_map(|name| compiler.get(name)));
    let folders: Vec<_> = own.chain([""]).map(|own| folder.join(with_slashes(own))).collect();
    let endless = |name: &str| {
        folders.iter().any(|folder| {
            let about = std::fs::metadata(folder.join(with_slashes(name)));
            about.is_ok_and(|about| !about.is_file() && !about.is_dir())
        })
    };
    for element in source.root.descendants() {
        let mut named = FILES.iter().filter_map(|name| element.get(name));
        if let Some(name) = named.find(|name| !name.is_empty() && endless(name)) {
            let message = format!(
                "{} is in {name}, which is a pipe or a device; give it a regular file",
                element.title()
            );
            return Err(source.refused(element, message));
        }
    }
    Ok(())
}
