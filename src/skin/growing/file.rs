//! Writing a skin into a model's file.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use std::sync::Arc;

use super::auras::add_auras;
use super::{GrowOptions, Sprout, sprouts};
use crate::creature::{Body, JointSelection, body_name, free_name, joint_name};
use crate::error::Error;
use crate::geometry::{Shape, wxyz};
use crate::model_files::{Element, HALF_THICKNESS, Source, add_receptor_class, element, move_assets, write};
use crate::mujoco::{JointKind, Model, ObjectKind, SensorKind};
use crate::skin::from_model::{skin_of, touch_sites};

/// The default class of the receptors' sites.
const CLASS: &str = "receptor";
/// A receptor's site is at most this share of its smaller half side thick, to be known for a patch.
const THINNESS: f64 = 0.3;
/// What a default for all sites must not have: no class can undo it.
const STICKY: [&str; 5] = ["fromto", "axisangle", "xyaxes", "zaxis", "euler"];

/// A model's file with a skin grown on it.
#[derive(Clone, Debug)]
pub struct Grown {
    root: Element,
    source: PathBuf,
    /// Receptors that grew.
    pub receptors: usize,
    /// Touch sensors that were there.
    pub kept: usize,
    /// Geometries of the aura that were added, one for each aura limb that had none.
    pub auras: usize,
}

/// Reads a model's file and grows a skin on all that can be touched and has no touch sensors.
///
/// Sites with touch sensors are added, a `jointpos` sensor for each hinge and slide without one, a geom without contact and
/// mass for the aura of each aura limb that has none, and names for the creature's bodies and joints that have none. What
/// is there stays.
///
/// # Errors
/// Where the file cannot be read, MuJoCo refuses it or it has no creature, where nothing of it can be touched,
/// or where sites cannot be written into it.
pub fn grow_skin(path: &Path, options: &GrowOptions) -> Result<Grown, Error> {
    grow_skin_rooted(path, None, options)
}

/// The same on the creature that begins at the body called `root`, or has most joints.
///
/// # Errors
/// As [`grow_skin`], and where there is no such body.
pub fn grow_skin_rooted(path: &Path, root: Option<&str>, options: &GrowOptions) -> Result<Grown, Error> {
    let unsuitable = |message: &str| Error::model(message).at(path, None);
    let model = Arc::new(Model::read(path)?.0);
    let body = Body::rooted(model.clone(), &JointSelection::All, root).map_err(Error::of_model(path))?;
    let mut root = Source::read(path)?.root;
    if root.child("compiler").and_then(|e| e.get("coordinate")) == Some("global") {
        return Err(unsuitable("it uses global coordinates: convert it to local ones first"));
    }
    if name_all(&mut root, &body).is_none() {
        // Composites and replicas are not written out in the file; the engine does that.
        let written = Model::written_out(path)?;
        root = Source::of_text(path, &written)?.root;
        name_all(&mut root, &body)
            .ok_or_else(|| unsuitable("its bodies are not spelled out in the file: flatten it first"))?;
    }
    let sprouts = sprouts(&body, &skin_of(&body), options).map_err(Error::of_model(path))?;
    let kept = touch_sites(&model).count();
    if sprouts.is_empty() && kept == 0 {
        let meshes = (0..model.ngeom())
            .any(|g| body.feels(g) && Shape::of_geom(&model, g).is_some_and(|shape| !shape.is_solid()));
        return Err(unsuitable(if meshes {
            "its moving bodies have only flat meshes, on which no skin grows: add capsules or boxes"
        } else {
            "no geom of a moving body can touch anything: add geoms"
        }));
    }
    let auras = add_auras(&mut root, &body, digits(&sprouts))?;
    let sensors = add(&mut root, &body, &sprouts).map_err(|fault| unsuitable(&fault))?;
    if !sensors.is_empty() {
        root.section("sensor").children.extend(sensors);
    }
    // What the engine was given in memory, so that it reads the file at all, stands in the file, too.
    let root = Model::accepted(root, path)?;
    Ok(Grown { root, source: path.to_path_buf(), receptors: sprouts.len(), kept, auras })
}

impl Grown {
    /// The file's text, to be written into `folder`: where that is another than the model's, the folders of
    /// meshes and textures are told anew. Without a folder they stay as they are.
    pub fn text(&self, folder: Option<&Path>) -> String {
        let mut root = self.root.clone();
        let from_file = |part: &Element| part.attributes.iter().any(|(name, _)| name.starts_with("file"));
        let assets = root.all("asset").flat_map(|asset| &asset.children).any(from_file);
        if let Some(way) = folder.filter(|_| assets).and_then(|folder| way(folder, self.source.parent()?)) {
            if root.child("compiler").is_none() {
                root.children.insert(0, Element::new("compiler"));
            }
            move_assets(&mut root, &way);
        }
        write(&root)
    }
}

/// Adds the receptors' sites and returns their sensors, after those of the joints.
fn add(root: &mut Element, body: &Body, sprouts: &[Sprout]) -> Result<Vec<Element>, String> {
    let model = &body.model;
    let mut sensors = Vec::new();
    for (j, joint) in model.joints().enumerate() {
        let measured = model.sensors().any(|sensor| {
            sensor.object == ObjectKind::Joint && sensor.id == Some(j) && sensor.kind == SensorKind::JointPos
        });
        let is_named = joint.name.is_some() || is_own(body, joint.body);
        if is_named && matches!(joint.kind, JointKind::Hinge | JointKind::Slide) && !measured {
            let name = joint_name(model, j);
            let sensor = free_name(model, ObjectKind::Sensor, format!("{name}_pos"));
            sensors.push(element("jointpos", &[("name", sensor), ("joint", name)]));
        }
    }
    if sprouts.is_empty() {
        return Ok(sensors);
    }
    let class = receptor_class(root)?;
    let digits = digits(sprouts);
    let mut sites: BTreeMap<usize, Vec<Element>> = BTreeMap::new();
    for Sprout { id, body, patch, .. } in sprouts {
        sensors.push(element("touch", &[("name", format!("{id}_touch")), ("site", id.clone())]));
        let [half_u, half_v] = patch.half_extents;
        let thickness = HALF_THICKNESS.min(THINNESS * half_u.min(half_v));
        let site = element(
            "site",
            &[
                ("class", class.clone()),
                ("name", id.clone()),
                ("pos", numbers(patch.position.iter(), digits)),
                ("quat", numbers(wxyz(&patch.orientation).iter(), digits)),
                ("size", numbers([half_u, half_v, thickness].iter(), digits)),
            ],
        );
        sites.entry(*body).or_default().push(site);
    }
    let mut number = 0;
    each_body(root, &mut |element| {
        number += 1;
        insert_behind_geoms(element, sites.remove(&number).into_iter().flatten());
    });
    Ok(sensors)
}

/// Puts elements into a body, behind its geoms.
pub(super) fn insert_behind_geoms(body: &mut Element, new: impl Iterator<Item = Element>) {
    let at = body.children.iter().rposition(|child| child.name == "geom").map_or(0, |k| k + 1);
    body.children.splice(at..at, new);
}

/// Makes the class of the receptors' sites, and returns its name.
fn receptor_class(root: &mut Element) -> Result<String, String> {
    for default in root.all("default") {
        // Every class inherits from the outermost.
        if let Some(site) = default.child("site")
            && let Some(sticky) = STICKY.iter().find(|&&name| site.has(name))
        {
            return Err(format!(
                "its default for all sites has {sticky}, which receptors cannot override: move it into a class"
            ));
        }
    }
    let class = free_class(root, CLASS);
    add_receptor_class(root, &class);
    Ok(class)
}

/// A name for a class of defaults that a file has not taken yet.
pub(super) fn free_class(root: &Element, name: &str) -> String {
    let defaults = root.all("default").flat_map(Element::descendants);
    let taken: BTreeSet<&str> = defaults.filter_map(|element| element.get("class")).collect();
    let mut class = name.to_string();
    while taken.contains(class.as_str()) {
        class = format!("grown_{class}");
    }
    class
}

/// Whether a body of the model is the creature's: then it and its joints get names if they have none.
fn is_own(body: &Body, of_model: usize) -> bool {
    of_model != 0 && body.limb_of_body[of_model].is_some()
}

/// Names all of a creature in its file; `None` if the file's bodies or joints are not the model's.
///
/// MuJoCo numbers bodies, and joints within them, in the order of the file.
fn name_all(root: &mut Element, body: &Body) -> Option<()> {
    let model = &body.model;
    let (mut number, mut agree) = (0, true);
    each_body(root, &mut |element| {
        number += 1;
        if number >= model.nbody() {
            return;
        }
        let info = model.body(number);
        let named = element.get("name").filter(|name| !name.is_empty());
        agree &= named == info.name;
        let joint = |child: &&mut Element| child.name == "joint" || child.name == "freejoint";
        let joints: Vec<&mut Element> = element.children.iter_mut().filter(joint).collect();
        agree &= joints.len() == info.joints.len();
        for (element, j) in joints.into_iter().zip(info.joints) {
            let named = element.get("name").filter(|name| !name.is_empty());
            agree &= named == model.joint(j).name;
            if model.joint(j).name.is_none() && is_own(body, number) {
                element.set("name", joint_name(model, j));
            }
        }
        if info.name.is_none() && is_own(body, number) {
            element.set("name", body_name(model, number));
        }
    });
    (agree && number + 1 == model.nbody()).then_some(())
}

/// Visits the bodies of a file in its order.
pub(super) fn each_body(root: &mut Element, visit: &mut impl FnMut(&mut Element)) {
    for child in &mut root.children {
        if child.name == "body" {
            visit(child);
        }
        if matches!(child.name.as_str(), "body" | "worldbody" | "frame") {
            each_body(child, visit);
        }
    }
}

/// The way from one folder to another, as a path; `None` if both are the same.
fn way(from: &Path, to: &Path) -> Option<PathBuf> {
    let whole = |path: &Path| {
        let path = if path.as_os_str().is_empty() { Path::new(".") } else { path };
        path.canonicalize().or_else(|_| std::path::absolute(path)).ok()
    };
    let (from, to) = (whole(from)?, whole(to)?);
    if from == to {
        return None;
    }
    let shared = from.components().zip(to.components()).take_while(|(a, b)| a == b).count();
    let up = from.components().skip(shared).map(|_| Path::new(".."));
    Some(up.chain(to.components().skip(shared).map(|part| Path::new(part.as_os_str()))).collect())
}

/// Digits after the point: a micrometre, or less where receptors are small.
fn digits(sprouts: &[Sprout]) -> usize {
    let sides = sprouts.iter().flat_map(|sprout| sprout.patch.half_extents);
    let least = sides.fold(f64::INFINITY, f64::min);
    if least < 1e-3 { 9 } else { 6 }
}

/// Numbers as MJCF wants them.
pub(super) fn numbers<'a>(values: impl Iterator<Item = &'a f64>, digits: usize) -> String {
    let text = |value: &f64| {
        let text = format!("{value:.digits$}");
        let text = text.trim_end_matches('0').trim_end_matches('.');
        if text == "-0" { "0".to_string() } else { text.to_string() }
    };
    values.map(text).collect::<Vec<_>>().join(" ")
}
