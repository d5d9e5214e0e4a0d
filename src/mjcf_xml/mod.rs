//! Model files as XML: reading them with a place for every element, putting what is newer than the engine in plain
//! terms, and writing elements, sections, and the receptors' look, alike in every file of ours.

mod assets;
mod defaults;
mod expand;
mod hulls;
mod left_out;
mod limits;
mod mesh_corners;
mod mesh_files;
mod pose;
mod reduce;
mod references;
mod schema;
mod source;
mod urdf;
mod urdf_names;
mod urdf_tree;
mod values;
mod write;

pub(crate) use assets::check as check_assets;
pub(crate) use hulls::open_meshes;
pub use left_out::LeftOut;
pub(crate) use limits::{check as check_limits, check_numbers};
pub(crate) use mesh_files::unreadable_mesh;
pub(crate) use pose::{Angles, ORIENTATIONS};
pub(crate) use reduce::Reduced;
pub(crate) use source::{Refused, Source, place};
pub(crate) use urdf::to_mjcf as urdf_to_mjcf;
pub(crate) use urdf_tree::{GREATEST_TURN, UrdfFollowing, UrdfJoint, UrdfKind, UrdfTree, turn_fault};
pub(crate) use values::check as check_values;
pub(crate) use write::{Texts, numbered, write};

use xmltree::{Element, XMLNode};

/// Half the thickness of a receptor's site, metres.
pub(crate) const HALF_THICKNESS: f64 = 0.0008;

/// An element with attributes in the order given.
pub(crate) fn element(name: &str, attributes: &[(&str, String)]) -> Element {
    let mut element = Element::new(name);
    for (key, value) in attributes {
        element.attributes.insert((*key).into(), value.clone());
    }
    element
}

/// A top-level section, made where there is none.
pub(crate) fn section<'a>(root: &'a mut Element, name: &str) -> &'a mut Element {
    if root.get_child(name).is_none() {
        let section = XMLNode::Element(Element::new(name));
        // Classes must be known before they are used.
        let at = if name == "default" { 0 } else { root.children.len() };
        root.children.insert(at, section);
    }
    root.get_mut_child(name).expect("just made")
}

/// Lets a file's meshes and textures be found from anywhere: its folders for them become absolute.
pub(crate) fn anchor_assets(root: &mut Element, path: &std::path::Path) {
    let folder = source::whole_folder_of(path);
    for name in ["meshdir", "texturedir"] {
        let compilers = root.children.iter().filter_map(XMLNode::as_element).filter(|e| e.name == "compiler");
        // A later setting overrides an earlier one.
        let own = compilers.filter_map(|e| attribute(e, name)).next_back().unwrap_or_default();
        let absolute = folder.join(own).display().to_string();
        set_compiler(root, name, &absolute);
    }
}

/// The default class of the receptors' sites.
pub(crate) fn add_receptor_class(root: &mut Element, name: &str) {
    let look = [("type", "box".into()), ("group", "3".into()), ("rgba", "0.2 0.6 0.9 0.5".into())];
    add_class(root, name, element("site", &look));
}

/// A default class of one kind of element.
pub(crate) fn add_class(root: &mut Element, name: &str, of: Element) {
    let mut class = element("default", &[("class", name.into())]);
    class.children.push(XMLNode::Element(of));
    section(root, "default").children.push(XMLNode::Element(class));
}

/// Numbers to the last digit: they read back as the very same.
pub(crate) fn exact<'a>(values: impl IntoIterator<Item = &'a f64>) -> String {
    // Adding zero turns -0 into 0.
    values.into_iter().map(|value| (value + 0.0).to_string()).collect::<Vec<_>>().join(" ")
}

/// What a person calls an element: its tag, and its name where it has one.
pub(crate) fn titled(element: &Element) -> String {
    let name = attribute(element, "name").map(|name| format!(" {name}")).unwrap_or_default();
    format!("<{}>{name}", element.name)
}

/// An attribute of an element.
pub(crate) fn attribute<'a>(element: &'a Element, name: &str) -> Option<&'a str> {
    element.attributes.get(name).map(String::as_str)
}

/// The elements in an element.
fn take_children(element: Element) -> Vec<Element> {
    let elements = element.children.into_iter().filter_map(|child| match child {
        XMLNode::Element(child) => Some(child),
        _ => None,
    });
    elements.collect()
}

/// Visits an element and all in it.
pub(crate) fn each(element: &mut Element, change: &mut dyn FnMut(&mut Element)) {
    change(element);
    element.children.iter_mut().filter_map(XMLNode::as_mut_element).for_each(|child| each(child, change));
}

/// Removes elements at any depth; how many went.
fn remove(element: &mut Element, which: &dyn Fn(&Element) -> bool) -> usize {
    let before = element.children.len();
    element.children.retain(|child| !child.as_element().is_some_and(which));
    let gone = before - element.children.len();
    let inner = element.children.iter_mut().filter_map(XMLNode::as_mut_element);
    gone + inner.map(|child| remove(child, which)).sum::<usize>()
}

/// A setting of the compiler, in place of all that a file says of it.
pub(crate) fn set_compiler(root: &mut Element, name: &str, value: &str) {
    section(root, "compiler");
    let sections = root.children.iter_mut().filter_map(XMLNode::as_mut_element);
    for compiler in sections.filter(|section| section.name == "compiler") {
        compiler.attributes.insert(name.into(), value.into());
    }
}
