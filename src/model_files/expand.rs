//! A model's tree in plain terms that every MuJoCo knows: default classes written out, poses as positions and
//! quaternions, angles in radians, and the bodies of frames, replicas and attached models where they belong.

use std::collections::{BTreeMap, BTreeSet};
use std::path::PathBuf;

use nalgebra::{Isometry3, Vector3};

use super::checks;
use super::defaults::Defaults;
use super::meshes::{MeshFolder, mesh_name};
use super::pose::{Angles, ORIENTATIONS, set_pose};
use super::references::{Name, names, rename, repeated, stands};
use super::source::{LeftOut, Refused, Source, folder_of, with_slashes};
use super::tree::{Element, numbers};
use super::write::exact;

/// Elements that a file may come to with all its replicas.
const GREATEST_TREE: usize = 200_000;
/// How deep models may be attached to each other.
const GREATEST_NESTING: usize = 16;
/// What in a body has nothing to do with where limbs are and what they touch.
const UNNEEDED: [&str; 3] = ["camera", "light", "plugin"];
/// What a frame says besides its pose.
const FRAME: [&str; 2] = ["name", "childclass"];
/// What a replicate says besides how each replica is turned.
const REPLICATE: [&str; 4] = ["count", "offset", "sep", "childclass"];

/// A model in plain terms.
pub(super) struct Expanded {
    /// What the world holds.
    pub world: Vec<Element>,
    /// Its meshes, their files with their whole paths.
    pub meshes: Vec<Element>,
    /// What names parts of it, each with the section it is in.
    pub references: Vec<(&'static str, Element)>,
}

/// Sections whose entries name parts of the body, and the entries that are kept.
pub(super) const REFERENCES: [(&str, &[&str]); 4] = [
    ("contact", &["exclude"]),
    ("equality", &["joint", "connect", "weld"]),
    ("custom", &["tuple"]),
    ("sensor", &["touch", "jointpos", "ballquat"]),
];

impl Expanded {
    /// Writes out a model's tree; `nesting` counts the models that it is attached to.
    ///
    /// # Errors
    /// Where it refers to a model that cannot be read, or comes to more than can be.
    pub fn new(source: &Source, left_out: &mut LeftOut, nesting: usize) -> Result<Expanded, Refused> {
        let sections = |name: &'static str| source.root.all(name);
        let defaults = Defaults::new(sections("default"))
            .map_err(|(element, message)| source.refused(element, message))?;
        let assets = || sections("asset").flat_map(|e| &e.children);
        let colours = assets().filter(|e| e.name == "material").filter_map(|material| {
            let mut material = material.clone();
            defaults.apply(&mut material, None);
            Some((material.get("name")?.to_string(), material.get("rgba")?.to_string()))
        });
        let folder = MeshFolder::of(source);
        let meshes = assets().filter(|e| e.name == "mesh").map(|mesh| {
            let mut mesh = mesh.clone();
            defaults.apply(&mut mesh, None);
            folder.settle(&mut mesh);
            mesh
        });
        let mut references = Vec::new();
        for (section, kept) in REFERENCES {
            for entry in sections(section).flat_map(|e| &e.children) {
                if kept.contains(&entry.name.as_str()) {
                    references.push((section, entry.clone()));
                } else if section == "equality" {
                    left_out.unheeded += 1;
                } else {
                    left_out.spare(format!("<{}> in <{section}>", entry.name));
                }
            }
        }
        let mut expansion = Expansion {
            source,
            angles: Angles::of(&source.root),
            autolimits: source.root.setting("compiler", "autolimits") != Some("false"),
            colours: colours.collect(),
            models: assets().filter(|e| e.name == "model").map(|e| (model_name(source, e), e)).collect(),
            made: Expanded { world: Vec::new(), meshes: meshes.collect(), references },
            defaults,
            left_out,
            elements: 0,
            nesting,
        };
        for section in sections("worldbody") {
            let world = expansion.children(section, section.get("childclass"))?;
            expansion.made.world.extend(world);
        }
        Ok(expansion.made)
    }
}

/// The file of a model that can be attached.
fn model_file(source: &Source, model: &Element) -> Option<PathBuf> {
    Some(folder_of(&source.path).join(with_slashes(model.get("file")?)))
}

/// The name of a model that can be attached: its own, or what its file calls it.
fn model_name(source: &Source, model: &Element) -> String {
    let told = model.get("name").map(str::to_string);
    let own = || {
        let file = model_file(source, model)?;
        let read = Source::read(&file).ok()?;
        read.root.get("model").map(str::to_string)
    };
    told.or_else(own).unwrap_or_default()
}

struct Expansion<'a> {
    source: &'a Source,
    angles: Angles,
    autolimits: bool,
    defaults: Defaults,
    /// The colour of each material.
    colours: BTreeMap<String, String>,
    /// The models that can be attached, by name.
    models: BTreeMap<String, &'a Element>,
    made: Expanded,
    left_out: &'a mut LeftOut,
    elements: usize,
    nesting: usize,
}

impl Expansion<'_> {
    /// What an element of the tree holds, in plain terms; `class` is the one that its ancestors gave their children.
    fn children(&mut self, parent: &Element, class: Option<&str>) -> Result<Vec<Element>, Refused> {
        let mut plain = Vec::new();
        for child in &parent.children {
            match child.name.as_str() {
                "body" => plain.push(self.body(child, class)?),
                "geom" | "site" | "joint" | "freejoint" | "inertial" => plain.push(self.part(child, class)?),
                "frame" => {
                    let pose = self.angles.pose(child);
                    self.lose_unknown(child, &FRAME);
                    let class = self.class(child, "childclass")?.or(class);
                    let mut inner = self.children(child, class)?;
                    inner.iter_mut().for_each(|element| put(element, &pose));
                    plain.extend(inner);
                }
                "replicate" => {
                    self.lose_unknown(child, &REPLICATE);
                    let inner = self.children(child, self.class(child, "childclass")?.or(class))?;
                    plain.extend(self.replicate(child, &inner)?);
                }
                "attach" => plain.extend(self.attach(child)?),
                name if UNNEEDED.contains(&name) => self.left_out.spare(format!("<{name}>")),
                name => self.left_out.lose(format!("<{name}>"), 1),
            }
        }
        self.elements += plain.len();
        self.bounded(parent, self.elements)?;
        Ok(plain)
    }

    /// Tells what an element has besides these attributes and a pose.
    fn lose_unknown(&mut self, element: &Element, known: &[&str]) {
        for (name, _) in &element.attributes {
            let posed = name == "pos" || ORIENTATIONS.contains(&name.as_str());
            if !posed && !known.contains(&name.as_str()) {
                self.left_out.lose(format!("{name} of <{}>, which MuJoCo does not know", element.name), 1);
            }
        }
    }

    /// Refuses a tree of too many elements.
    fn bounded(&self, at: &Element, elements: usize) -> Result<(), Refused> {
        if elements <= GREATEST_TREE {
            return Ok(());
        }
        let message = format!(
            "with all replicas it has more than {GREATEST_TREE} elements; give <replicate> a smaller count"
        );
        Err(self.source.refused(at, message))
    }

    fn body(&mut self, body: &Element, class: Option<&str>) -> Result<Element, Refused> {
        let mut plain = Element { children: Vec::new(), ..body.clone() };
        plain.remove("childclass");
        set_pose(&mut plain, &self.angles.pose(body));
        let children = self.children(body, self.class(body, "childclass")?.or(class))?;
        plain.children = children;
        Ok(plain)
    }

    /// The class that an element names.
    fn class<'e>(&self, element: &'e Element, attribute: &str) -> Result<Option<&'e str>, Refused> {
        match element.get(attribute) {
            Some(class) if !class.is_empty() && !self.defaults.has(class) => {
                let message = format!(
                    "{attribute}=\"{class}\" of {} names no <default>; define that class or correct the name",
                    element.title()
                );
                Err(self.source.refused(element, message))
            }
            class => Ok(class.filter(|class| !class.is_empty())),
        }
    }

    /// A geom, site or joint, or the inertia of a body, with all that its class says.
    fn part(&mut self, part: &Element, class: Option<&str>) -> Result<Element, Refused> {
        self.class(part, "class")?;
        let mut plain = Element { children: Vec::new(), ..part.clone() };
        // Newer engines take an empty attribute for none.
        plain.attributes.retain(|(_, value)| !value.trim().is_empty());
        self.defaults.apply(&mut plain, class);
        if plain.name == "site" && plain.get("type") == Some("mesh") {
            // A site of a mesh is somewhere, too.
            plain.remove("type");
            plain.remove("mesh");
        }
        match plain.name.as_str() {
            "joint" => self.joint(&mut plain),
            "freejoint" => {}
            "inertial" => {
                let pose = self.angles.pose(&plain);
                set_pose(&mut plain, &pose);
                // Newer engines take the body's origin where none is given.
                plain.set("pos", exact(pose.translation.vector.iter()));
            }
            _ => {
                let material = plain.remove("material");
                if let Some(colour) = material.and_then(|material| self.colours.get(&material))
                    && !plain.has("rgba")
                {
                    plain.set("rgba", colour);
                }
                if plain.get("fromto").is_none() {
                    let pose = self.angles.pose(&plain);
                    set_pose(&mut plain, &pose);
                }
            }
        }
        Ok(plain)
    }

    /// Writes out a joint's angles in radians, and whether it has limits.
    fn joint(&self, joint: &mut Element) {
        let kind = joint.get("type").unwrap_or("hinge").to_string();
        let angular = |name: &str| match name {
            "range" => matches!(kind.as_str(), "hinge" | "ball"),
            _ => kind == "hinge",
        };
        for name in ["range", "ref", "springref"] {
            if let Some(value) = joint.get_mut(name).filter(|_| angular(name)) {
                let radians: Vec<f64> = numbers(value).into_iter().map(|x| self.angles.radians(x)).collect();
                *value = exact(&radians);
            }
        }
        let range = joint.numbers("range");
        let limited = match joint.get("limited") {
            Some(told @ ("true" | "false")) => told == "true",
            _ => self.autolimits && range.iter().any(|&end| end != 0.0),
        };
        joint.set("limited", limited.to_string());
    }

    /// Repeats elements, each time moved on by the same way from where they were, their names with the replica's number.
    fn replicate(&mut self, replicate: &Element, inner: &[Element]) -> Result<Vec<Element>, Refused> {
        let refused = |message: String| self.source.refused(replicate, message);
        let count = replicate.get("count");
        let count = count.ok_or_else(|| refused("<replicate> has no count; give it count=\"…\"".into()))?;
        let count = count.trim().parse::<usize>().map_err(|_| {
            refused(format!("count=\"{count}\" of <replicate> is not a whole number, 0 or above; give one"))
        })?;
        self.bounded(replicate, self.elements.saturating_add(count.saturating_mul(inner.len())))?;
        let offset = replicate.vector("offset").unwrap_or_default();
        let turn = self.angles.orientation(replicate).unwrap_or_default();
        let step = Isometry3::from_parts(offset.into(), turn);
        let separator = replicate.get("sep").unwrap_or_default();
        let digits = count.saturating_sub(1).to_string().len();
        let suffixed = |k: usize| move |name: &str| format!("{name}{separator}{k:0digits$}");
        let mut replicated: BTreeSet<Name> = BTreeSet::new();
        inner.iter().for_each(|element| names(element, &mut replicated));
        let changes: Vec<_> = (0..count).map(suffixed).collect();
        let changes: Vec<&dyn Fn(&str) -> String> = changes.iter().map(|change| change as _).collect();
        for (section, entry) in std::mem::take(&mut self.made.references) {
            let entries = repeated(&entry, &replicated, &changes);
            self.made.references.extend(entries.into_iter().map(|entry| (section, entry)));
        }
        let (mut pose, mut plain) = (Isometry3::identity(), Vec::new());
        for change in changes {
            for element in inner {
                let mut copy = element.clone();
                rename(&mut copy, change);
                put(&mut copy, &pose);
                plain.push(copy);
            }
            pose *= step;
        }
        self.elements += plain.len();
        Ok(plain)
    }

    /// The body of another model, or all of its world, every name with a prefix.
    fn attach(&mut self, attach: &Element) -> Result<Vec<Element>, Refused> {
        let refused = |message: String| self.source.refused(attach, message);
        let name = attach.get("model").filter(|name| !name.is_empty());
        let name = name.ok_or_else(|| refused("<attach> names no model; give it model=\"…\"".into()))?;
        let file = self.models.get(name).and_then(|model| model_file(self.source, model)).ok_or_else(|| {
            refused(format!(
                "<attach> names the model {name}, which no <asset> has; give one with <model name=\"{name}\" \
                 file=\"…\"/>"
            ))
        })?;
        if attach.has("frame") {
            return Err(refused(
                "<attach> names a frame, which is not supported; name the body in it".into(),
            ));
        }
        if !file.is_file() {
            let model = self.models[name];
            let message = format!(
                "model {name} is in {}, which cannot be found; correct the path there",
                file.display()
            );
            return Err(self.source.refused(model, message));
        }
        if self.nesting >= GREATEST_NESTING {
            return Err(refused("models attach each other endlessly; remove this <attach>".into()));
        }
        let attached = Source::read(&file)?;
        if attached.root.name != "mujoco" {
            let message =
                format!("model {name} is in {}, which is not MJCF; convert it first", file.display());
            return Err(self.source.refused(self.models[name], message));
        }
        checks::check(&attached)?;
        let Expanded { mut world, meshes, references } =
            Expanded::new(&attached, self.left_out, self.nesting + 1)?;
        if let Some(body) = attach.get("body") {
            let found = world.iter().flat_map(Element::descendants);
            let found = found.filter(|e| e.name == "body").find(|e| e.get("name") == Some(body)).cloned();
            world = vec![found.ok_or_else(|| {
                refused(format!(
                    "<attach> names the body {body}, which {} does not have; name one of its bodies",
                    file.display()
                ))
            })?];
        }
        let prefix = attach.get("prefix").unwrap_or_default();
        let prefixed = |name: &str| format!("{prefix}{name}");
        let mut taken: BTreeSet<Name> = BTreeSet::new();
        world.iter().for_each(|element| names(element, &mut taken));
        for (section, entry) in references.iter().filter(|(_, entry)| whole(entry, &taken)) {
            self.made
                .references
                .extend(repeated(entry, &taken, &[&prefixed]).into_iter().map(|e| (*section, e)));
        }
        for mut mesh in meshes {
            let name = prefixed(&mesh_name(&mesh).unwrap_or_default());
            mesh.set("name", name.clone());
            // A model may be attached several times.
            if self.made.meshes.iter().all(|other| other.get("name") != Some(&name)) {
                self.made.meshes.push(mesh);
            }
        }
        for element in &mut world {
            rename(element, &prefixed);
            element.each(&mut |element| {
                if let Some(mesh) = element.get_mut("mesh") {
                    *mesh = prefixed(mesh);
                }
            });
        }
        self.elements += world.len();
        Ok(world)
    }
}

/// Whether all that an entry of a section names is there.
fn whole(entry: &Element, names: &BTreeSet<Name>) -> bool {
    stands(entry, names) && entry.children.iter().all(|e| stands(e, names))
}

/// Moves an element of a frame to where it is in what holds the frame.
fn put(element: &mut Element, pose: &Isometry3<f64>) {
    if *pose == Isometry3::identity() {
        return;
    }
    match element.name.as_str() {
        "freejoint" => {}
        "joint" => {
            let kind = element.get("type").unwrap_or("hinge");
            if kind == "free" {
                return;
            }
            if kind != "ball" {
                let axis = element.vector("axis").unwrap_or(Vector3::z());
                let axis = pose.rotation * axis;
                element.set("axis", exact(axis.iter()));
            }
            let anchor = pose * nalgebra::Point3::from(element.vector("pos").unwrap_or_default());
            element.set("pos", exact(anchor.coords.iter()));
        }
        _ => match element.numbers("fromto").as_slice() {
            [a, b, c, d, e, f] => {
                let ends = [Vector3::new(*a, *b, *c), Vector3::new(*d, *e, *f)];
                let ends = ends.map(|end| pose * nalgebra::Point3::from(end));
                let ends = exact(ends.iter().flat_map(|end| end.coords.iter()));
                element.set("fromto", ends);
            }
            _ => {
                // Poses are in plain terms by now: a position and a quaternion.
                let own = Angles::new(None, None).pose(element);
                set_pose(element, &(pose * own));
            }
        },
    }
}
