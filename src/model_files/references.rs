//! What names parts of the body: excludes, couplings, sensors, tuples. They follow the names when bodies are repeated or
//! taken from another file.

use std::collections::BTreeSet;

use super::tree::Element;

/// What kind of thing has a name, and the name.
pub(super) type Name = (&'static str, String);

/// The kind of thing that an element of the tree is; joints of all kinds share their names.
pub(super) fn kind(element: &str) -> Option<&'static str> {
    match element {
        "body" => Some("body"),
        "joint" | "freejoint" => Some("joint"),
        "geom" => Some("geom"),
        "site" => Some("site"),
        _ => None,
    }
}

/// The names in a tree.
pub(super) fn names(element: &Element, into: &mut BTreeSet<Name>) {
    let named = |e: &Element| Some((kind(&e.name)?, e.get("name")?.to_string()));
    into.extend(element.descendants().filter_map(named));
}

/// Renames all in a tree that has a name.
pub(super) fn rename(element: &mut Element, change: &dyn Fn(&str) -> String) {
    if kind(&element.name).is_some()
        && let Some(name) = element.get_mut("name")
    {
        *name = change(name);
    }
    element.children.iter_mut().for_each(|child| rename(child, change));
}

/// The attributes by which an element names things, with their kinds.
fn slots(element: &Element) -> &'static [(&'static str, &'static str)] {
    match element.name.as_str() {
        "exclude" => &[("body1", "body"), ("body2", "body")],
        "connect" | "weld" => &[("body1", "body"), ("body2", "body"), ("site1", "site"), ("site2", "site")],
        "joint" => &[("joint1", "joint"), ("joint2", "joint")],
        "touch" => &[("site", "site")],
        "jointpos" | "ballquat" => &[("joint", "joint")],
        "element" => match element.get("objtype") {
            Some("body" | "xbody") => &[("objname", "body")],
            Some("joint") => &[("objname", "joint")],
            Some("geom") => &[("objname", "geom")],
            Some("site") => &[("objname", "site")],
            _ => &[],
        },
        _ => &[],
    }
}

/// What an element of a section names.
pub(super) fn named(element: &Element) -> Vec<Name> {
    let slots = slots(element).iter();
    slots.filter_map(|(slot, kind)| Some((*kind, element.get(slot)?.to_string()))).collect()
}

/// Whether all is there that an element of a section names.
pub(super) fn stands(element: &Element, names: &BTreeSet<Name>) -> bool {
    let told = slots(element).first().map(|(slot, _)| element.get(slot).is_some());
    named(element).iter().all(|name| names.contains(name) || name == &("body", "world".to_string()))
        && told.unwrap_or(element.name != "element")
}

/// The same element with what it names and its own name changed.
fn renamed(element: &Element, names: &BTreeSet<Name>, change: &dyn Fn(&str) -> String) -> Element {
    let mut copy = element.clone();
    for (slot, kind) in slots(element) {
        if let Some(name) = copy.get_mut(slot)
            && names.contains(&(*kind, name.clone()))
        {
            *name = change(name);
        }
    }
    if let Some(name) = copy.get_mut("name") {
        *name = change(name);
    }
    copy
}

/// An element of a section, once for each way in which the things in `names` are renamed; once as it is where it names
/// none of them. A tuple stays one, and its entries are repeated.
pub(super) fn repeated(
    element: &Element,
    names: &BTreeSet<Name>,
    changes: &[&dyn Fn(&str) -> String],
) -> Vec<Element> {
    if element.name == "tuple" {
        let mut tuple = element.clone();
        let entries = std::mem::take(&mut tuple.children);
        let entries = entries.iter();
        tuple.children = entries.flat_map(|entry| repeated(entry, names, changes)).collect();
        return vec![tuple];
    }
    if named(element).iter().any(|name| names.contains(name)) {
        changes.iter().map(|change| renamed(element, names, change)).collect()
    } else {
        vec![element.clone()]
    }
}
