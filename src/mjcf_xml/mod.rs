//! MJCF as XML: reading files, reducing them, and writing elements, sections, and the receptors' look, alike in
//! every file of ours.

mod hulls;
mod read;
mod strip;

pub(crate) use hulls::with_colliding;
pub(crate) use read::read;
pub(crate) use strip::Stripped;

use xmltree::{Element, EmitterConfig, XMLNode};

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
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty());
    let folder = folder.unwrap_or(std::path::Path::new("."));
    let folder = folder.canonicalize().unwrap_or_else(|_| folder.to_path_buf());
    let compiler = section(root, "compiler");
    let common = compiler.attributes.get("assetdir").cloned().unwrap_or_default();
    for name in ["meshdir", "texturedir"] {
        let own = compiler.attributes.get(name).unwrap_or(&common);
        let absolute = folder.join(own).display().to_string();
        compiler.attributes.insert(name.into(), absolute);
    }
}

/// The default class of the receptors' sites.
pub(crate) fn add_receptor_class(root: &mut Element, name: &str) {
    let mut class = element("default", &[("class", name.into())]);
    let look = [("type", "box".into()), ("group", "3".into()), ("rgba", "0.2 0.6 0.9 0.5".into())];
    class.children.push(XMLNode::Element(element("site", &look)));
    section(root, "default").children.push(XMLNode::Element(class));
}

/// Numbers to the last digit: they read back as the very same.
pub(crate) fn exact<'a>(values: impl IntoIterator<Item = &'a f64>) -> String {
    // Adding zero turns -0 into 0.
    values.into_iter().map(|value| (value + 0.0).to_string()).collect::<Vec<_>>().join(" ")
}

/// The text of a file, indented by two spaces.
pub(crate) fn write(root: &Element) -> Result<String, String> {
    let config = EmitterConfig::new()
        .perform_indent(true)
        .indent_string("  ")
        .write_document_declaration(false)
        .pad_self_closing(false);
    let mut bytes = Vec::new();
    root.write_with_config(&mut bytes, config).map_err(|e| e.to_string())?;
    bytes.push(b'\n');
    String::from_utf8(bytes).map_err(|e| e.to_string())
}
