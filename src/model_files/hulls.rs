//! A model in which geoms of meshes collide, so that the engine makes the meshes' convex hulls.

use std::collections::BTreeSet;

use super::tree::Element;

/// Lets the geoms of some meshes collide, whatever else their filters say; how many there are.
pub(crate) fn open_meshes(root: &mut Element, meshes: &BTreeSet<String>) -> usize {
    let sections = root.children.iter_mut();
    sections.filter(|section| section.name == "worldbody").map(|world| open(world, meshes)).sum()
}

/// Opens the geoms below an element that are of these meshes, or may be by their class; how many.
fn open(element: &mut Element, meshes: &BTreeSet<String>) -> usize {
    let mut opened = 0;
    for child in element.children.iter_mut() {
        opened += open(child, meshes);
        let of = |name: &str| child.get(name);
        let may_be_of_class = || of("type").is_none_or(|kind| kind == "mesh");
        if child.name == "geom" && of("mesh").map_or_else(may_be_of_class, |mesh| meshes.contains(mesh)) {
            child.set("contype", "1");
            opened += 1;
        }
    }
    opened
}
