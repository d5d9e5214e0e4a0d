//! A model's file reduced to what a body schema needs: bodies, joints, geoms, meshes, inertias, and the sensors of
//! touch and joints.
//!
//! What the engine does not know, because the file was written for a newer one, is put in plain terms or left out, and
//! so is all that has nothing to do with where limbs are and what they can touch. What attributes the engine knows, it
//! says itself ([`mujoco::schema`](crate::mujoco::schema)).

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

use super::expand::{Expanded, REFERENCES};
use super::meshes::{fault, is_of_others, mesh_name, take_corners};
use super::references::{Name, names, stands};
use super::source::{LeftOut, Refused, Source};
use super::tree::{Element, element, is_of};
use crate::named::did_you_mean;

/// Settings of the compiler that every file in plain terms has alike, or that speak of what is left out.
const SETTLED: &str = "meshdir assetdir texturedir strippath angle eulerseq autolimits";
/// What of the physics is kept.
const PHYSICS: &str = "timestep gravity wind density viscosity";
/// The sections that are put in plain terms, or of which something is kept.
const READ: &str = "compiler option default asset worldbody contact equality custom sensor";
/// What is of the world and what is in it.
const OF_BODIES: &str = "body geom site joint freejoint inertial frame replicate attach composite";
/// The section that may hold parts of bodies.
const BODILY: &str = "deformable";
/// Attributes of newer engines that change nothing of where limbs are and what they can touch.
const NEWER: &str = "actuatorfrclimited actuatorfrcrange actuatorgravcomp adhesion align castshadow content_type delay fuse gravcomp \
                     group inertia interp interval material maxhullvert nsample params simple sleep smoothnormal springyield \
                     surfacevel user";
/// The shapes of geoms that limbs can have.
const SHAPES: &str = "plane sphere capsule ellipsoid cylinder box mesh";

/// A model in plain terms.
pub(crate) struct Reduced {
    /// Its tree.
    pub root: Element,
    /// What was left out of it.
    pub left_out: LeftOut,
}

impl Reduced {
    /// Reduces a file; `schema` is the engine's own.
    ///
    /// # Errors
    /// Where the file refers to another that cannot be read, or comes to more than can be.
    pub fn new(source: &Source, schema: &str) -> Result<Reduced, Refused> {
        let schema = Schema::parse(schema);
        let mut left_out = LeftOut::default();
        let sections = || source.root.children.iter();
        for section in sections().filter(|section| !is_of(READ, &section.name)) {
            let what = format!("<{}>", section.name);
            if is_of(OF_BODIES, &section.name) {
                let message = format!("{} is outside <worldbody>; move it there", section.title());
                return Err(source.refused(section, message));
            }
            if is_of(BODILY, &section.name) { left_out.lose(what, 1) } else { left_out.spare(what) }
        }
        for asset in sections().filter(|e| e.name == "asset").flat_map(|e| &e.children) {
            if !matches!(asset.name.as_str(), "mesh" | "model") {
                left_out.spare(format!("<{}>", asset.name));
            }
        }
        for default in sections().filter(|e| e.name == "default") {
            lose_unknown_defaults(default, &mut left_out);
        }
        let expanded = Expanded::new(source, &mut left_out, 0)?;
        let mut compiler = element("compiler", &[("angle", "radian".into()), ("autolimits", "true".into())]);
        let mut option = Element::new("option");
        for section in sections() {
            // What is wrong in one is looked for in its line.
            match section.name.as_str() {
                "compiler" => compiler.place.clone_from(&section.place),
                "option" => option.place.clone_from(&section.place),
                _ => {}
            }
            for (name, value) in &section.attributes {
                if section.name == "compiler" && !is_of(SETTLED, name) {
                    compiler.set(name, value);
                } else if section.name == "option" && is_of(PHYSICS, name) {
                    option.set(name, value);
                }
            }
        }
        let mut root = Element::new("mujoco");
        if let Some(name) = source.root.get("model") {
            root.set("model", name);
        }
        let mut sections = vec![
            compiler,
            option,
            Element::holding("asset", expanded.meshes),
            Element::holding("worldbody", expanded.world),
        ];
        for (name, _) in REFERENCES {
            let entries = expanded.references.iter().filter(|(section, _)| *section == name);
            sections.push(Element::holding(name, entries.map(|(_, entry)| entry.clone()).collect()));
        }
        for section in &mut sections {
            let name = section.name.clone();
            known(section, &name, &schema, &mut left_out);
        }
        root.children = sections;
        Ok(Reduced::plain(root, left_out))
    }

    /// A model that is in plain terms already.
    pub fn plain(root: Element, left_out: LeftOut) -> Reduced {
        let mut reduced = Reduced { root, left_out };
        reduced.settle();
        reduced
    }

    /// Leaves out what refers to what is not there.
    fn settle(&mut self) {
        let Reduced { root, left_out } = self;
        let mut faulty: BTreeMap<String, String> = BTreeMap::new();
        root.each(&mut |e| {
            let of_others = e.get("file").is_some_and(|file| is_of_others(Path::new(file)));
            if e.name == "mesh" && (of_others || fault(e).is_some()) && !take_corners(e) {
                let fault = fault(e).unwrap_or_else(|| "it cannot be read".into());
                faulty.insert(mesh_name(e).unwrap_or_default(), fault);
            }
        });
        root.remove_all(&|e| e.name == "mesh" && mesh_name(e).is_some_and(|name| faulty.contains_key(&name)));
        for (mesh, fault) in &faulty {
            let gone = root.remove_all(&|e| e.name == "geom" && e.get("mesh") == Some(mesh));
            left_out.lose(format!("geom of the mesh {mesh}: {fault}"), gone);
        }
        let meshes: BTreeSet<String> =
            root.descendants().filter(|e| e.name == "mesh").filter_map(mesh_name).collect();
        let gone = root
            .remove_all(&|e| e.name == "geom" && e.get("mesh").is_some_and(|mesh| !meshes.contains(mesh)));
        left_out.lose("geom with a missing mesh", gone);
        let shapes = root.descendants().filter(|e| e.name == "geom").filter_map(|e| e.get("type"));
        let others: BTreeSet<String> =
            shapes.filter(|shape| !is_of(SHAPES, shape)).map(str::to_string).collect();
        for shape in others {
            let gone = root.remove_all(&|e| e.name == "geom" && e.get("type") == Some(&shape));
            // Height fields are ground, and not of a body.
            if shape == "hfield" {
                left_out.spare("<geom> of a height field");
            } else {
                left_out.lose(format!("geom of the shape {shape}"), gone);
            }
        }
        let mut there: BTreeSet<Name> = BTreeSet::new();
        if let Some(world) = root.child("worldbody") {
            names(world, &mut there);
        }
        for (section, _) in REFERENCES {
            if let Some(section) = root.children.iter_mut().find(|own| own.name == section) {
                let gone = section.remove_all(&|e| !stands(e, &there));
                section.children.retain(|child| child.name != "tuple" || !child.children.is_empty());
                let what = format!("entry of <{}> for a missing element", section.name);
                (0..gone).for_each(|_| left_out.spare(&what));
            }
        }
    }

    /// Has the engine make the hull of a mesh whose faces it refuses; whether there was such a mesh.
    pub fn take_hull(&mut self, name: &str) -> bool {
        let mut found = false;
        self.root.each(&mut |e| {
            if e.name == "mesh" && mesh_name(e).as_deref() == Some(name) && take_corners(e) {
                found = true;
            }
        });
        if found {
            self.left_out.spare("faces of a mesh (its hull is used)");
        }
        found
    }

    /// Leaves out a mesh that the engine refuses, and all geoms of it; whether there was such a mesh.
    /// `reason` is what the engine says of it.
    pub fn drop_mesh(&mut self, name: &str, reason: &str) -> bool {
        let found = self.root.remove_all(&|e| e.name == "mesh" && mesh_name(e).as_deref() == Some(name));
        if found > 0 {
            let geoms = self.root.remove_all(&|e| e.name == "geom" && e.get("mesh") == Some(name));
            self.left_out
                .lose(format!("geom of the mesh {name}, which this MuJoCo rejects: {reason}"), geoms);
        }
        found > 0
    }

    /// The names of its meshes.
    pub fn meshes(&self) -> Vec<String> {
        self.root.all("asset").flat_map(|asset| &asset.children).filter_map(mesh_name).collect()
    }
}

/// Reports what default classes say of elements that are most likely misspelt.
fn lose_unknown_defaults(class: &Element, left_out: &mut LeftOut) {
    const OF_BODIES: [&str; 4] = ["mesh", "joint", "geom", "site"];
    for child in &class.children {
        match child.name.as_str() {
            "default" => lose_unknown_defaults(child, left_out),
            name if OF_BODIES.contains(&name) || did_you_mean(name, OF_BODIES).is_none() => {}
            name => left_out.lose(format!("<{name}> in <default>"), 1),
        }
    }
}

/// Leaves out attributes that the engine does not know, all over a section.
fn known(one: &mut Element, section: &str, schema: &Schema, left_out: &mut LeftOut) {
    let name = one.name.clone();
    one.attributes.retain(|(attribute, _)| {
        let kept = attribute != "user" && schema.knows(section, &name, attribute);
        let of_body = section == "worldbody" && !is_of(NEWER, attribute);
        match attribute.as_str() {
            "user" => {}
            _ if kept => {}
            _ if of_body => left_out.lose(format!("{attribute} of <{name}>, which MuJoCo does not know"), 1),
            _ => left_out.spare(format!("{attribute} of <{name}>")),
        }
        kept
    });
    one.children.iter_mut().for_each(|child| known(child, section, schema, left_out));
}

/// What the engine knows: attributes per element, by the section it is in.
pub(crate) struct Schema {
    attributes: BTreeMap<(String, String), BTreeSet<String>>,
}

impl Schema {
    /// Reads what `mj_printSchema` prints: an element a line, indented by three spaces a level, its attributes from
    /// column 30 on and in further lines.
    pub fn parse(text: &str) -> Schema {
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

    /// Whether an element of a section may have an attribute.
    pub fn knows(&self, section: &str, element: &str, attribute: &str) -> bool {
        let section = if section == "worldbody" { "body" } else { section };
        let known = self.attributes.get(&(section.to_string(), element.to_string()));
        known.is_some_and(|known| known.contains(attribute))
    }
}
