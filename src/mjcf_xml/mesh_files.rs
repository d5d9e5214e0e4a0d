//! Where the meshes of a model are.

use std::path::{Path, PathBuf};

use xmltree::{Element, XMLNode};

use super::attribute;
use super::source::{Source, whole_folder_of, with_slashes};

/// The kinds of files that the engine reads meshes from.
const KINDS: [&str; 3] = ["stl", "obj", "msh"];

/// The folder of a model's meshes, and whether files keep but their names.
pub(super) struct MeshFolder {
    folder: PathBuf,
    bare: bool,
}

impl MeshFolder {
    /// By the settings of a model's compiler.
    pub fn of(source: &Source) -> MeshFolder {
        let compilers =
            || source.root.children.iter().filter_map(XMLNode::as_element).filter(|e| e.name == "compiler");
        let setting = |name: &str| compilers().filter_map(|e| attribute(e, name)).next_back();
        let folder = whole_folder_of(&source.path);
        let own = setting("meshdir").or_else(|| setting("assetdir")).unwrap_or("");
        MeshFolder { folder: folder.join(own), bare: setting("strippath") == Some("true") }
    }

    /// Gives a mesh the whole path of its file, and a name: that of the file where it has none of its own.
    pub fn settle(&self, mesh: &mut Element) {
        if let Some(name) = mesh_name(mesh) {
            mesh.attributes.insert("name".into(), name);
        }
        if let Some(file) = mesh.attributes.get_mut("file") {
            let path = with_slashes(file);
            let path = Path::new(&path);
            let path = if self.bare { path.file_name().map(Path::new).unwrap_or(path) } else { path };
            *file = self.folder.join(path).display().to_string();
        }
    }
}

/// A mesh's name, or that of its file.
pub(super) fn mesh_name(mesh: &Element) -> Option<String> {
    let stem = || Path::new(attribute(mesh, "file")?).file_stem()?.to_str().map(str::to_string);
    attribute(mesh, "name").map(str::to_string).or_else(stem)
}

/// Why the engine cannot read a mesh, as far as that can be told from outside.
pub(super) fn fault(mesh: &Element) -> Option<&'static str> {
    if attribute(mesh, "vertex").is_some() {
        return None;
    }
    let Some(file) = attribute(mesh, "file").map(Path::new) else {
        return Some("is made by the engine it was written for");
    };
    let kind = file.extension().and_then(|kind| kind.to_str()).unwrap_or_default().to_ascii_lowercase();
    if !file.is_file() {
        Some("has no file")
    } else if !KINDS.contains(&kind.as_str()) {
        Some("is in a file that is not STL, OBJ or MSH")
    } else {
        None
    }
}
