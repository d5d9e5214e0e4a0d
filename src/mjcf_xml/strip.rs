//! An MJCF file reduced to what a body schema needs: bodies, joints, geoms, meshes, and the touch sensors.
//!
//! What the engine does not know, because the file was written for a newer one, is left out, and so is all that
//! has nothing to do with where limbs are and what they can touch. What attributes the engine knows, it says itself
//! ([`mujoco::schema`](crate::mujoco::schema)).

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

use xmltree::{Element, XMLNode};

use super::read::{Refused, read};

/// Sections that are kept, or merged where there are several.
const SECTIONS: [&str; 8] =
    ["compiler", "default", "asset", "worldbody", "contact", "equality", "custom", "sensor"];
/// What is kept of each section; a default class keeps what bears on it.
const KEPT: [(&str, &[&str]); 8] = [
    ("compiler", &[]),
    ("default", &["default", "mesh", "joint", "geom", "site"]),
    ("asset", &["mesh"]),
    ("worldbody", &["body", "geom", "site", "frame"]),
    ("body", &["body", "joint", "freejoint", "geom", "site", "frame"]),
    ("contact", &["exclude"]),
    ("equality", &["joint"]),
    ("sensor", &["touch", "jointpos", "ballquat"]),
];
/// Settings of the compiler that speak of what is left out.
const COMPILER_DROPPED: [&str; 6] =
    ["meshdir", "assetdir", "texturedir", "strippath", "inertiafromgeom", "discardvisual"];
/// The shapes of geoms that limbs can have.
const SHAPES: [&str; 7] = ["plane", "sphere", "capsule", "ellipsoid", "cylinder", "box", "mesh"];
/// Least mass and inertia of a body: the shapes that are left may weigh nothing.
const LEAST_MASS: [(&str, &str); 2] = [("boundmass", "0.001"), ("boundinertia", "0.000001")];

/// A stripped model.
pub(crate) struct Stripped {
    /// The model's tree, paths of meshes absolute.
    root: Element,
    /// What was left out, and how often.
    pub left_out: BTreeMap<String, usize>,
}

impl Stripped {
    /// Reads a file and leaves out what is not needed; `schema` is the engine's own.
    pub fn new(path: &Path, schema: &str) -> Result<Stripped, Refused> {
        let schema = Schema::parse(schema);
        let mut source = read(path)?;
        let mut strip = Strip { schema: &schema, left_out: BTreeMap::new() };
        let mut root = Element::new("mujoco");
        if let Some(name) = source.attributes.get("model") {
            root.attributes.insert("model".into(), name.clone());
        }
        let meshes = mesh_folder(&source, path);
        for section in SECTIONS {
            let found = take(&mut source, |e| e.name == section);
            if section == "default" {
                // A file may have several default trees of names of their own, which stay apart.
                for mut tree in found {
                    strip.element(&mut tree, section);
                    root.children.push(XMLNode::Element(tree));
                }
                continue;
            }
            let mut merged = Element::new(section);
            for element in found {
                merged.attributes.extend(element.attributes);
                merged.children.extend(element.children);
            }
            strip.element(&mut merged, section);
            root.children.push(XMLNode::Element(merged));
        }
        for dropped in source.children.iter().filter_map(XMLNode::as_element) {
            *strip.left_out.entry(format!("<{}>", dropped.name)).or_default() += 1;
        }
        let mut left_out = strip.left_out;
        finish(&mut root, &meshes, &mut left_out);
        Ok(Stripped { root, left_out })
    }

    /// Leaves out a mesh and all geoms of it; whether there was such a mesh.
    pub fn drop_mesh(&mut self, name: &str) -> bool {
        let found = remove(&mut self.root, &|e| e.name == "mesh" && mesh_name(e).as_deref() == Some(name));
        if found > 0 {
            let geoms = remove(&mut self.root, &|e| e.name == "geom" && attribute(e, "mesh") == Some(name));
            *self.left_out.entry(format!("mesh {name} with its geoms")).or_default() += geoms.max(1);
        }
        found > 0
    }

    /// The names of its meshes.
    pub fn meshes(&self) -> Vec<String> {
        let assets = self.root.get_child("asset").into_iter().flat_map(|asset| &asset.children);
        assets.filter_map(XMLNode::as_element).filter_map(mesh_name).collect()
    }

    /// Its XML.
    pub fn text(&self) -> Result<String, String> {
        super::write(&self.root)
    }
}

/// The folder of the meshes, and whether files keep but their names.
fn mesh_folder(root: &Element, path: &Path) -> (std::path::PathBuf, bool) {
    let folder = path.parent().unwrap_or(Path::new(""));
    let folder = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
    let folder = folder.canonicalize().unwrap_or_else(|_| folder.to_path_buf());
    let compilers = || root.children.iter().filter_map(XMLNode::as_element).filter(|e| e.name == "compiler");
    let setting = |name: &str| compilers().filter_map(|e| attribute(e, name)).next_back();
    let directory = setting("meshdir").or_else(|| setting("assetdir")).unwrap_or("");
    (folder.join(directory), setting("strippath") == Some("true"))
}

/// What the engine knows: attributes per element, by the section it is in.
struct Schema {
    attributes: BTreeMap<(String, String), BTreeSet<String>>,
}

impl Schema {
    /// Reads what `mj_printSchema` prints: an element a line, indented by three spaces a level, its attributes from
    /// column 30 on and in further lines.
    fn parse(text: &str) -> Schema {
        const COLUMN: usize = 30;
        const INDENT: usize = 3;
        let mut attributes: BTreeMap<(String, String), BTreeSet<String>> = BTreeMap::new();
        let mut path: Vec<String> = Vec::new();
        for line in text.lines() {
            let (head, tail) = line.split_at_checked(COLUMN).unwrap_or((line, ""));
            if let Some(name) = head.split_whitespace().next() {
                let depth = (head.len() - head.trim_start().len()) / INDENT;
                path.truncate(depth);
                path.push(if name == "(world)body" { "body".into() } else { name.to_string() });
            }
            let section = path.get(1).cloned().unwrap_or_default();
            let element = path.last().cloned().unwrap_or_default();
            attributes
                .entry((section, element))
                .or_default()
                .extend(tail.split_whitespace().map(str::to_string));
        }
        Schema { attributes }
    }

    fn knows(&self, section: &str, element: &str, attribute: &str) -> bool {
        let section = if section == "worldbody" { "body" } else { section };
        let element = if element == "worldbody" || element == "frame" { "body" } else { element };
        let known = self.attributes.get(&(section.to_string(), element.to_string()));
        known.is_some_and(|known| known.contains(attribute))
    }
}

struct Strip<'a> {
    schema: &'a Schema,
    left_out: BTreeMap<String, usize>,
}

impl Strip<'_> {
    /// Leaves out what an element holds that is not kept, and attributes that the engine does not know.
    fn element(&mut self, element: &mut Element, section: &str) {
        let name = element.name.clone();
        let looks = |attribute: &str| matches!(attribute, "material" | "user");
        for attribute in element.attributes.keys().cloned().collect::<Vec<_>>() {
            let compiler = name == "compiler" && COMPILER_DROPPED.contains(&attribute.as_str());
            if compiler || looks(&attribute) {
                element.attributes.shift_remove(attribute.as_str());
            } else if !self.schema.knows(section, &name, &attribute) {
                element.attributes.shift_remove(attribute.as_str());
                *self.left_out.entry(format!("{attribute} of <{name}>")).or_default() += 1;
            }
        }
        let inside = if name == "frame" { "body" } else { &name };
        let kept = KEPT.iter().find(|(parent, _)| *parent == inside).map_or(&[][..], |(_, kept)| *kept);
        for child in std::mem::take(&mut element.children) {
            let XMLNode::Element(mut child) = child else { continue };
            // Tuples name limbs and joint sets; their entries are checked at the end.
            let tuple = section == "custom" && matches!(child.name.as_str(), "tuple" | "element");
            if kept.contains(&child.name.as_str()) || tuple {
                self.element(&mut child, section);
                element.children.push(XMLNode::Element(child));
            } else if child.name != "inertial" {
                *self.left_out.entry(format!("<{}>", child.name)).or_default() += 1;
            }
        }
    }
}

/// Settles what refers to what was left out, and what newer engines take for granted.
fn finish(
    root: &mut Element,
    (folder, bare): &(std::path::PathBuf, bool),
    left_out: &mut BTreeMap<String, usize>,
) {
    let compiler = super::section(root, "compiler");
    compiler.attributes.entry("autolimits".into()).or_insert_with(|| "true".into());
    compiler.attributes.insert("inertiafromgeom".into(), "true".into());
    compiler.attributes.insert("balanceinertia".into(), "true".into());
    for (name, value) in LEAST_MASS {
        compiler.attributes.insert(name.into(), value.into());
    }
    each(root, &mut |element| {
        if element.name == "mesh"
            && let Some(file) = element.attributes.get("file").cloned()
        {
            // The name comes from the file where there is none, whatever its folder.
            if let Some(name) = mesh_name(element) {
                element.attributes.insert("name".into(), name);
            }
            let file = Path::new(&file);
            let file = if *bare { file.file_name().map(Path::new).unwrap_or(file) } else { file };
            element.attributes.insert("file".into(), folder.join(file).display().to_string());
        }
    });
    let mut frames = 0;
    unframe(root, &mut frames, left_out);
    let missing = |e: &Element| {
        e.name == "mesh"
            && e.attributes.contains_key("name")
            && !e.attributes.contains_key("vertex")
            && attribute(e, "file").is_none_or(|file| !Path::new(file).is_file())
    };
    let gone = remove(root.get_mut_child("asset").unwrap_or(&mut Element::new("asset")), &missing);
    if gone > 0 {
        left_out.insert("meshes whose files are missing, with their geoms".into(), gone);
    }
    let (mut meshes, mut names) = (BTreeSet::new(), BTreeSet::new());
    collect(root, &mut |e| {
        if e.name == "mesh" {
            meshes.extend(mesh_name(e));
        }
        if let Some(name) = attribute(e, "name") {
            names.insert((kind(&e.name).to_string(), name.to_string()));
        }
    });
    let odd = |e: &Element| {
        e.name == "geom"
            && (attribute(e, "mesh").is_some_and(|mesh| !meshes.contains(mesh))
                || attribute(e, "type").is_some_and(|shape| !SHAPES.contains(&shape)))
    };
    let gone = if let Some(world) = root.get_mut_child("worldbody") { remove(world, &odd) } else { 0 };
    if gone > 0 {
        left_out.insert("geoms of shapes that are not there".into(), gone);
    }
    let has = |kind: &str, e: &Element, name: &str| {
        attribute(e, name).is_none_or(|name| names.contains(&(kind.to_string(), name.to_string())))
    };
    let dangling = |e: &Element| match e.name.as_str() {
        "exclude" => !has("body", e, "body1") || !has("body", e, "body2"),
        "touch" => !has("site", e, "site"),
        "jointpos" | "ballquat" => !has("joint", e, "joint"),
        "element" => !names.contains(&(
            attribute(e, "objtype").unwrap_or("").to_string(),
            attribute(e, "objname").unwrap_or("").to_string(),
        )),
        "joint" => !has("joint", e, "joint1") || !has("joint", e, "joint2"),
        _ => false,
    };
    for section in ["contact", "equality", "custom", "sensor"] {
        if let Some(section) = root.get_mut_child(section) {
            let gone = remove(section, &dangling);
            section.children.retain(|child| {
                child.as_element().is_some_and(|e| e.name != "tuple" || !e.children.is_empty())
            });
            if gone > 0 {
                left_out.insert(format!("entries of <{}> for what is not there", section.name), gone);
            }
        }
    }
}

/// Turns frames into bodies without joints, which move as one with what carries them. The joints of a frame are those
/// of the body about it: they go there, shifted; in a turned frame they are left out. A frame in the world is taken
/// away, with its pose.
fn unframe(element: &mut Element, frames: &mut usize, left_out: &mut BTreeMap<String, usize>) {
    const TURNS: [&str; 5] = ["quat", "axisangle", "xyaxes", "zaxis", "euler"];
    if element.name == "worldbody" {
        // Where a whole body is does not matter to its schema, and only a child of the world may be free.
        while let Some(at) =
            element.children.iter().position(|c| c.as_element().is_some_and(|e| e.name == "frame"))
        {
            let XMLNode::Element(frame) = element.children.remove(at) else { continue };
            let mut inner = frame.children;
            if let Some(class) = frame.attributes.get("childclass") {
                for body in inner.iter_mut().filter_map(XMLNode::as_mut_element).filter(|e| e.name == "body")
                {
                    body.attributes.entry("childclass".into()).or_insert_with(|| class.clone());
                }
            }
            element.children.splice(at..at, inner);
        }
    }
    let mut joints = Vec::new();
    for child in element.children.iter_mut().filter_map(XMLNode::as_mut_element) {
        let frame = child.name == "frame";
        if frame {
            *frames += 1;
            child.name = "body".into();
            child.attributes.entry("name".into()).or_insert_with(|| format!("frame_{frames}"));
        }
        unframe(child, frames, left_out);
        if !frame {
            continue;
        }
        let turned = TURNS.iter().any(|turn| child.attributes.contains_key(*turn));
        for mut joint in take(child, |e| matches!(e.name.as_str(), "joint" | "freejoint")) {
            if turned {
                *left_out.entry("joints in a turned <frame>".into()).or_default() += 1;
                continue;
            }
            if let Some(shift) = attribute(child, "pos") {
                let own = attribute(&joint, "pos").unwrap_or("0 0 0");
                joint.attributes.insert("pos".into(), sum(own, shift));
            }
            joints.push(joint);
        }
    }
    element.children.splice(0..0, joints.into_iter().map(XMLNode::Element));
}

/// Takes some of an element's children out of it.
fn take(element: &mut Element, which: impl Fn(&Element) -> bool) -> Vec<Element> {
    let (taken, kept) = std::mem::take(&mut element.children)
        .into_iter()
        .partition(|child| child.as_element().is_some_and(&which));
    element.children = kept;
    taken
        .into_iter()
        .filter_map(|child| if let XMLNode::Element(e) = child { Some(e) } else { None })
        .collect()
}

/// The sum of two vectors as MJCF writes them.
fn sum(a: &str, b: &str) -> String {
    let numbers =
        |text: &str| text.split_whitespace().map(|x| x.parse().unwrap_or(0.0)).collect::<Vec<f64>>();
    let sums: Vec<f64> = numbers(a).iter().zip(numbers(b)).map(|(a, b)| a + b).collect();
    super::exact(&sums)
}

/// The namespace of an element's name.
fn kind(element: &str) -> &str {
    if element == "freejoint" { "joint" } else { element }
}

/// A mesh's name, or that of its file.
fn mesh_name(mesh: &Element) -> Option<String> {
    let stem = || Path::new(attribute(mesh, "file")?).file_stem()?.to_str().map(str::to_string);
    attribute(mesh, "name").map(str::to_string).or_else(stem)
}

fn attribute<'a>(element: &'a Element, name: &str) -> Option<&'a str> {
    element.attributes.get(name).map(String::as_str)
}

/// Removes elements at any depth; how many went.
fn remove(element: &mut Element, which: &dyn Fn(&Element) -> bool) -> usize {
    let before = element.children.len();
    element.children.retain(|child| !child.as_element().is_some_and(which));
    let gone = before - element.children.len();
    gone + element
        .children
        .iter_mut()
        .filter_map(XMLNode::as_mut_element)
        .map(|child| remove(child, which))
        .sum::<usize>()
}

fn each(element: &mut Element, change: &mut dyn FnMut(&mut Element)) {
    change(element);
    element.children.iter_mut().filter_map(XMLNode::as_mut_element).for_each(|child| each(child, change));
}

fn collect(element: &Element, see: &mut dyn FnMut(&Element)) {
    see(element);
    element.children.iter().filter_map(XMLNode::as_element).for_each(|child| collect(child, see));
}
