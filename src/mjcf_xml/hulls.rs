//! A model's text in which geoms of meshes collide, so that the engine makes the meshes' convex hulls.

use std::collections::BTreeSet;
use std::path::Path;

use xmltree::{Element, XMLNode};

use super::{anchor_assets, read, write};

/// The text of a model in which the geoms of some meshes collide, whatever else their filters say: that in the file at
/// `path`, or `text` where it is given. None where there is no such geom, or no such file.
pub(crate) fn with_colliding(path: &Path, text: Option<&str>, meshes: &BTreeSet<String>) -> Option<String> {
    let mut root = match text {
        Some(text) => Element::parse(text.as_bytes()).ok()?,
        None => {
            let mut root = read(path).ok()?;
            anchor_assets(&mut root, path);
            root
        }
    };
    let worlds = root.children.iter_mut().filter_map(XMLNode::as_mut_element);
    let opened: usize =
        worlds.filter(|section| section.name == "worldbody").map(|world| open(world, meshes)).sum();
    if opened == 0 {
        return None;
    }
    write(&root).ok()
}

/// Opens the geoms below an element that are of these meshes, or may be by their class; how many.
fn open(element: &mut Element, meshes: &BTreeSet<String>) -> usize {
    let mut opened = 0;
    for child in element.children.iter_mut().filter_map(XMLNode::as_mut_element) {
        opened += open(child, meshes);
        let of = |name: &str| child.attributes.get(name).map(String::as_str);
        let may_be_of_class = || of("type").is_none_or(|kind| kind == "mesh");
        if child.name == "geom" && of("mesh").map_or_else(may_be_of_class, |mesh| meshes.contains(mesh)) {
            child.attributes.insert("contype".into(), "1".into());
            opened += 1;
        }
    }
    opened
}
