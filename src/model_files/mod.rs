//! Model files as XML: reading them with a place for every element, putting what is newer than the engine in plain
//! terms, and writing elements, sections, and the receptors' look, alike in every file of ours.

use std::path::Path;

mod checks;
mod collada;
mod defaults;
mod expand;
mod hulls;
mod loading;
mod meshes;
mod pose;
mod reduce;
mod references;
mod refusal;
mod source;
mod tree;
mod urdf;
mod urdf_tree;
mod write;

pub(crate) use checks::check as check_source;
pub(crate) use meshes::unreadable_mesh;
pub(crate) use pose::{Angles, ORIENTATIONS};
pub use source::LeftOut;
pub(crate) use source::{Refused, Source, begins_as, first_letter};
pub(crate) use tree::{Element, element};
pub(crate) use urdf_tree::{Following, GREATEST_TURN, Origin, UrdfJoint, UrdfKind, UrdfTree};
pub(crate) use write::{Edits, exact, rewritten, write};

/// Half the thickness of a receptor's site, metres.
pub(crate) const HALF_THICKNESS: f64 = 0.0008;

/// The default class of the receptors' sites.
pub(crate) fn add_receptor_class(root: &mut Element, name: &str) {
    let look = [("type", "box".into()), ("group", "3".into()), ("rgba", "0.2 0.6 0.9 0.5".into())];
    add_class(root, name, element("site", &look));
}

/// A default class of one kind of element.
pub(crate) fn add_class(root: &mut Element, name: &str, of: Element) {
    let class = Element { children: vec![of], ..element("default", &[("class", name.into())]) };
    root.section("default").children.push(class);
}

/// A setting of the compiler, in place of all that a file says of it.
pub(crate) fn set_compiler(root: &mut Element, name: &str, value: &str) {
    root.section("compiler");
    let sections = root.children.iter_mut().filter(|section| section.name == "compiler");
    sections.for_each(|compiler| compiler.set(name, value));
}

/// Sets the folders of meshes and textures, so that they are found from elsewhere by a path to the folder that they were sought
/// from.
pub(crate) fn move_assets(root: &mut Element, path: &Path) {
    for folder in ["meshdir", "texturedir"] {
        let own = root.setting("compiler", folder).unwrap_or_default();
        let moved = path.join(own).display().to_string();
        set_compiler(root, folder, &moved);
    }
}
