//! Reading MJCF files with what they include written out.

use std::collections::HashSet;
use std::path::{Path, PathBuf};

use xmltree::Element;

/// A file that could not be read, and why: the path, and a clause.
pub(crate) type Refused = (PathBuf, String);

/// Reads an MJCF file with its includes written out. As MuJoCo has it, the paths of all includes start from
/// the main file's folder.
pub(crate) fn read(path: &Path) -> Result<Element, Refused> {
    let folder = path.parent().unwrap_or(Path::new(""));
    let mut seen = HashSet::new();
    let mut root = parse(path, &mut seen)?;
    include(&mut root, folder, &mut seen)?;
    Ok(root)
}

fn parse(path: &Path, seen: &mut HashSet<PathBuf>) -> Result<Element, Refused> {
    let refused = |message: String| (path.to_path_buf(), message);
    if !seen.insert(path.to_path_buf()) {
        return Err(refused("it is included twice: MuJoCo allows each file once".into()));
    }
    let bytes = std::fs::read(path)
        .map_err(|error| refused(format!("it cannot be read ({error}): give one that can")))?;
    let malformed =
        |error: xmltree::ParseError| refused(format!("malformed XML ({error}): correct it there"));
    Element::parse(bytes.as_slice()).map_err(malformed)
}

fn include(element: &mut Element, folder: &Path, seen: &mut HashSet<PathBuf>) -> Result<(), Refused> {
    for mut child in std::mem::take(&mut element.children) {
        match child.as_mut_element() {
            Some(inner) if inner.name == "include" => {
                let file = inner.attributes.get("file").cloned().unwrap_or_default();
                let mut included = parse(&folder.join(file), seen)?;
                include(&mut included, folder, seen)?;
                element.children.extend(included.children);
            }
            Some(inner) => {
                include(inner, folder, seen)?;
                element.children.push(child);
            }
            None => element.children.push(child),
        }
    }
    Ok(())
}
