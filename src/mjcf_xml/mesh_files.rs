//! Where the meshes of a model are.

use std::path::{Path, PathBuf};

use xmltree::{Element, XMLNode};

use super::attribute;
use super::mesh_corners::corners;
use super::source::{Refused, Source, whole_folder_of, with_slashes};

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

/// The kind of a file by its name, in small letters.
pub(super) fn kind(file: &Path) -> String {
    file.extension().and_then(|kind| kind.to_str()).unwrap_or_default().to_ascii_lowercase()
}

/// Gives a mesh the corners of its file in the place of the file, or takes its faces from it, so that the engine makes its
/// hull; whether there was anything to be changed.
pub(super) fn take_corners(mesh: &mut Element) -> bool {
    if let Some(corners) = attribute(mesh, "file").and_then(|file| corners(Path::new(file))) {
        let corners: Vec<String> = corners.as_flattened().iter().map(f32::to_string).collect();
        mesh.attributes.shift_remove("file");
        mesh.attributes.insert("vertex".into(), corners.join(" "));
        return true;
    }
    mesh.attributes.contains_key("vertex") && mesh.attributes.shift_remove("face").is_some()
}

/// A refusal of a model by the first of its meshes whose file cannot be read, where there is one.
pub(crate) fn unreadable_mesh(path: &Path) -> Option<Refused> {
    let source = Source::read(path).ok()?;
    let folder = MeshFolder::of(&source);
    let root = if source.root.name == "robot" {
        super::urdf_to_mjcf(&source).ok()?.root
    } else {
        source.root.clone()
    };
    let assets = root.children.iter().filter_map(XMLNode::as_element).filter(|e| e.name == "asset");
    let meshes =
        assets.flat_map(|e| &e.children).filter_map(XMLNode::as_element).filter(|e| e.name == "mesh");
    { meshes }.find_map(|mesh| {
        let mut settled = mesh.clone();
        folder.settle(&mut settled);
        let file = PathBuf::from(attribute(&settled, "file")?);
        let sound = kind(&file) == "msh" || corners(&file).is_some();
        (file.is_file() && !sound).then(|| {
            let message = format!(
                "the mesh {} cannot be read as STL or OBJ; correct the file or the path there",
                file.display()
            );
            source.refused(mesh, message)
        })
    })
}

/// Why the engine cannot read a mesh, as far as that can be told from outside.
pub(super) fn fault(mesh: &Element) -> Option<&'static str> {
    if attribute(mesh, "vertex").is_some() {
        return None;
    }
    let Some(file) = attribute(mesh, "file").map(Path::new) else {
        return Some("has neither file nor vertices, or is made by the engine it was written for");
    };
    let kind = kind(file);
    if !file.is_file() {
        Some("has no file")
    } else if !KINDS.contains(&kind.as_str()) {
        Some("is in a file that is not STL, OBJ, PLY or MSH")
    } else {
        None
    }
}
