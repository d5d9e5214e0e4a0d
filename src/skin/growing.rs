//! Growing a skin on any creature.
//!
//! The exposed surface of every geom is sampled evenly; Lloyd's iteration gathers the samples into cells
//! of about the wanted area; each cell becomes a receptor, a flat quadrangle that touches the surface at
//! the cell's middle and is just large enough to cover the cell. So the receptors tile all that can be
//! touched, whatever the shape. They are written into the model's file as sites with touch sensors, and
//! every hinge and slide gets its `jointpos` sensor.
//!
//! How fine the skin is, the model says itself: a tuple `limb/NAME` names the bodies of a limb, and the
//! `prm` of each is the area of a receptor there in cm². Where it says nothing, the default holds.

use std::collections::{BTreeMap, HashSet};
use std::path::{Path, PathBuf};
use std::sync::Arc;

use nalgebra::{Matrix3, Rotation3, UnitQuaternion, Vector3};
use xmltree::{Element, XMLNode};

use super::from_model::shape;
use super::{Shape, Surface};
use crate::mjcf_xml::{HALF_THICKNESS, add_receptor_class, element, section, write};
use crate::mujoco::{self, Data, GeomKind, JointKind, Model, ObjectKind};

/// Samples per receptor of the surface.
const SAMPLES_PER_RECEPTOR: f64 = 150.0;
/// A point this deep inside another geom is not exposed, metres.
const BURIED: f64 = 5e-4;
/// Cells whose normals average to less than this face all ways and are split.
const ONE_SIDED: f64 = 0.35;
/// Exposed surface below this share of a receptor's area is left bare.
const REMNANT: f64 = 0.02;

/// What a skin is to be like.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GrowOptions {
    /// Area of a receptor where the model does not say, m².
    pub area: f64,
}

impl Default for GrowOptions {
    fn default() -> GrowOptions {
        GrowOptions { area: 0.006 }
    }
}

/// Why no skin could be grown.
#[derive(Debug, thiserror::Error)]
pub enum GrowError {
    /// The engine refused the model.
    #[error(transparent)]
    Engine(#[from] mujoco::Error),
    /// A file could not be read or written.
    #[error("{path}: {source}")]
    File {
        /// The file.
        path: PathBuf,
        /// What the system says.
        source: std::io::Error,
    },
    /// The file is not XML.
    #[error("{path}: {message}")]
    Xml {
        /// The file.
        path: PathBuf,
        /// What is wrong with it.
        message: String,
    },
    /// A body or joint cannot be found again in the file.
    #[error("{path}: {message}")]
    Unsuitable {
        /// The file.
        path: PathBuf,
        /// What is wrong, and the mend.
        message: String,
    },
}

/// A receptor about to be written: in its body's frame.
struct Patch {
    body: usize,
    position: Vector3<f64>,
    orientation: UnitQuaternion<f64>,
    half_extents: [f64; 2],
}

/// Reads a model's file and returns it with a skin grown on every geom that can touch.
///
/// # Errors
/// Where the file cannot be read or MuJoCo refuses it, where it has a skin already, or where a body that
/// needs receptors has no name.
pub fn grow_skin(path: &Path, options: &GrowOptions) -> Result<String, GrowError> {
    let model = Arc::new(Model::from_path(path)?);
    let unsuitable = |message: String| GrowError::Unsuitable { path: path.to_path_buf(), message };
    if model.sensors().any(|sensor| sensor.kind == mujoco::SensorKind::Touch) {
        return Err(unsuitable("it has touch sensors already: give the model without its skin".into()));
    }
    let mut root = read(path, &mut HashSet::new())?;
    if attribute(&root, "compiler", "coordinate") == Some("global") {
        return Err(unsuitable("it uses global coordinates: convert it to local ones first".into()));
    }
    let patches = patches(&model, options)?;
    if patches.is_empty() {
        let meshes = model.geoms().any(|geom| geom.kind == GeomKind::Mesh && in_creature(&model, geom.body));
        return Err(unsuitable(if meshes {
            "its moving bodies have meshes alone, on which no skin grows: give them capsules or boxes too"
                .into()
        } else {
            "no geom of a moving body can touch anything: give it geoms".into()
        }));
    }
    let names = limb_names(&model);
    let mut count: BTreeMap<String, usize> = BTreeMap::new();
    let mut sites: BTreeMap<String, Vec<Element>> = BTreeMap::new();
    let mut sensors = Vec::new();
    for (j, joint) in model.joints().enumerate() {
        let measured = model.sensors().any(|sensor| {
            sensor.object == ObjectKind::Joint
                && sensor.id == Some(j)
                && sensor.kind == mujoco::SensorKind::JointPos
        });
        if matches!(joint.kind, JointKind::Hinge | JointKind::Slide) && !measured {
            let name = joint
                .name
                .ok_or_else(|| unsuitable(format!("joint {j} has no name: give it one, for its sensor")))?;
            sensors.push(element("jointpos", &[("name", format!("{name}_pos")), ("joint", name.into())]));
        }
    }
    for patch in &patches {
        let body = model.body(patch.body).name.ok_or_else(|| {
            unsuitable(format!("body {} has no name: give it one, for its receptors", patch.body))
        })?;
        let limb = names.get(&patch.body).cloned().unwrap_or_else(|| body.to_string());
        let number = count.entry(limb.clone()).or_insert(0);
        *number += 1;
        let id = format!("{limb}_{number:02}");
        sensors.push(element("touch", &[("name", format!("{id}_touch")), ("site", id.clone())]));
        let q = patch.orientation.quaternion();
        let [half_u, half_v] = patch.half_extents;
        let site = element(
            "site",
            &[
                ("class", "receptor".into()),
                ("name", id),
                ("pos", numbers(patch.position.iter())),
                ("quat", numbers([q.w, q.i, q.j, q.k].iter())),
                ("size", numbers([half_u, half_v, HALF_THICKNESS].iter())),
            ],
        );
        sites.entry(body.to_string()).or_default().push(site);
    }
    insert_sites(&mut root, &mut sites);
    if let Some(body) = sites.keys().next() {
        return Err(unsuitable(format!("body {body} is not written out in the file: flatten it first")));
    }
    add_receptor_class(&mut root);
    let section = section(&mut root, "sensor");
    section.children.extend(sensors.into_iter().map(XMLNode::Element));
    write(&root).map_err(|message| GrowError::Xml { path: path.to_path_buf(), message })
}

/// All receptors, body by body in the model's order.
fn patches(model: &Arc<Model>, options: &GrowOptions) -> Result<Vec<Patch>, GrowError> {
    let mut data = Data::new(model.clone())?;
    data.kinematics()?;
    let areas = receptor_areas(model);
    let touching = |g: usize| {
        let geom = model.geom(g);
        (geom.contype != 0 || geom.conaffinity != 0) && in_creature(model, geom.body)
    };
    // Every geom in the world's frame, to see what is buried where.
    let placed = |g: usize| {
        let pose = data.geom_pose(g);
        let rotation = pose.rotation.to_rotation_matrix().into_inner();
        let shape = shape(&model.geom(g)).filter(|_| touching(g))?;
        Some(Surface { limb: 0, origin: pose.translation.vector, rotation, shape, geom: g })
    };
    let placed: Vec<Option<Surface>> = (0..model.ngeom()).map(placed).collect();
    let mut patches = Vec::new();
    for (body, info) in model.bodies().enumerate() {
        let area = areas.get(&body).copied().unwrap_or(options.area);
        for g in info.geoms {
            let Some(surface) = &placed[g] else { continue };
            let spacing = area / SAMPLES_PER_RECEPTOR;
            let mut samples = samples(&surface.shape, spacing);
            let share = surface.shape.area() / samples.len().max(1) as f64;
            for (point, normal) in &mut samples {
                *point = surface.rotation * *point + surface.origin;
                *normal = surface.rotation * *normal;
            }
            samples.retain(|(point, _)| {
                let mut others = placed.iter().enumerate().filter(|(other, _)| *other != g);
                !others.any(|(_, other)| {
                    other.as_ref().and_then(|s| s.signed_distance(point)).is_some_and(|d| d.0 < -BURIED)
                })
            });
            if (samples.len() as f64) * share < REMNANT * area {
                continue;
            }
            let pose = data.body_pose(body);
            let long_axis: Vector3<f64> = surface.rotation.column(2).into();
            for mut patch in cells(&samples, share, area, &long_axis) {
                patch.body = body;
                patch.position = pose.inverse_transform_point(&patch.position.into()).coords;
                patch.orientation = pose.rotation.inverse() * patch.orientation;
                patches.push(patch);
            }
        }
    }
    Ok(patches)
}

/// Whether a body is part of a tree with joints, and not the world or furniture.
fn in_creature(model: &Model, body: usize) -> bool {
    let mut root = body;
    while root != 0 && model.body(root).parent != 0 {
        root = model.body(root).parent;
    }
    root != 0
        && model.joints().any(|joint| {
            let mut at = joint.body;
            while model.body(at).parent != 0 {
                at = model.body(at).parent;
            }
            at == root && joint.kind != JointKind::Free
        })
}

/// Per body, the receptor area that the model's limb tuples ask for, m².
fn receptor_areas(model: &Model) -> BTreeMap<usize, f64> {
    let tuples = model.tuples();
    let limbs = tuples.iter().filter(|tuple| tuple.name.is_some_and(|n| n.starts_with("limb/")));
    let entries = limbs.flat_map(|tuple| &tuple.entries);
    entries
        .filter(|entry| entry.object == ObjectKind::Body && entry.prm > 0.0)
        .map(|entry| (entry.id, entry.prm * 1e-4))
        .collect()
}

/// Per body, the name of the limb it is part of.
fn limb_names(model: &Model) -> BTreeMap<usize, String> {
    let mut names = BTreeMap::new();
    for tuple in model.tuples() {
        let Some(name) = tuple.name.and_then(|name| name.strip_prefix("limb/")) else { continue };
        for entry in tuple.entries.iter().filter(|entry| entry.object == ObjectKind::Body) {
            names.entry(entry.id).or_insert_with(|| name.to_string());
        }
    }
    names
}

/// Points and outward normals spread evenly over a shape, one per `spacing` m², in the shape's axes.
fn samples(shape: &Shape, spacing: f64) -> Vec<(Vector3<f64>, Vector3<f64>)> {
    // A box about the shape is sampled evenly and its points drawn to the surface along the shape's
    // own normals; where that crowds them, thinning evens them out.
    let golden = std::f64::consts::PI * (3.0 - 5f64.sqrt());
    let count = ((shape.area() / spacing).ceil() as usize).max(24);
    let sphere = |k: usize, n: usize| {
        let z = 1.0 - (2 * k + 1) as f64 / n as f64;
        let ring = (1.0 - z * z).sqrt();
        let angle = golden * k as f64;
        Vector3::new(ring * angle.cos(), ring * angle.sin(), z)
    };
    match *shape {
        Shape::Sphere { radius } => {
            (0..count).map(|k| (sphere(k, count) * radius, sphere(k, count))).collect()
        }
        Shape::Capsule { radius, half_length } => {
            // Archimedes: a sphere's area is spread evenly along z, and so is a cylinder's.
            let height = 2.0 * (radius + half_length);
            let point = |k: usize| {
                let z = height * ((k as f64 + 0.5) / count as f64 - 0.5);
                let core = z.clamp(-half_length, half_length);
                let up = (z - core) / radius;
                let ring = (1.0 - up * up).max(0.0).sqrt();
                let angle = golden * k as f64;
                let normal = Vector3::new(ring * angle.cos(), ring * angle.sin(), up);
                (normal * radius + Vector3::z() * core, normal)
            };
            (0..count).map(point).collect()
        }
        Shape::Mesh => Vec::new(),
        _ => {
            let bounds = shape.half_bounds();
            let dense = 12 * count;
            let far = 3.0 * bounds.norm();
            let mut kept: Vec<(Vector3<f64>, Vector3<f64>)> = Vec::new();
            let apart = 0.7 * (shape.area() / count as f64).sqrt();
            for k in 0..dense {
                // Rays from outside towards the middle, spread as on an ellipsoid of the same bounds.
                let direction = sphere(k, dense).component_mul(&bounds).normalize();
                let mut along = far;
                for _ in 0..200 {
                    let distance = shape.signed_distance(&(direction * along)).map_or(0.0, |d| d.0);
                    along -= distance;
                    if distance.abs() < 1e-12 {
                        break;
                    }
                }
                let point = direction * along;
                let Some((_, normal)) = shape.signed_distance(&(point * (1.0 + 1e-9))) else { continue };
                if kept.iter().all(|(other, _)| (other - point).norm() >= apart) {
                    kept.push((point, normal));
                }
            }
            kept
        }
    }
}

/// Gathers samples into cells of about `area` and makes each a patch (its body left open).
fn cells(
    samples: &[(Vector3<f64>, Vector3<f64>)],
    share: f64,
    area: f64,
    long_axis: &Vector3<f64>,
) -> Vec<Patch> {
    let mean: Vector3<f64> = samples.iter().map(|s| s.1).sum::<Vector3<f64>>() / samples.len() as f64;
    let least = if mean.norm() < ONE_SIDED { 2 } else { 1 };
    let count = ((samples.len() as f64 * share / area).round() as usize).max(least).min(samples.len());
    // Farthest-point start: deterministic and spread out.
    let mut centres = vec![farthest(samples, |p| -(p.dot(long_axis)))];
    while centres.len() < count {
        let nearest = |p: &Vector3<f64>| {
            let distances = centres.iter().map(|&c: &usize| (samples[c].0 - p).norm());
            distances.fold(f64::INFINITY, f64::min)
        };
        let next = farthest(samples, nearest);
        centres.push(next);
    }
    let mut owner = vec![0; samples.len()];
    for _ in 0..30 {
        for (sample, owner) in samples.iter().zip(&mut owner) {
            // Normals count as well, so that no cell folds around an edge that another could cover.
            let cost = |c: usize| {
                let (point, normal) = samples[c];
                (point - sample.0).norm_squared() + area * (1.0 - normal.dot(&sample.1))
            };
            *owner = (0..centres.len())
                .min_by(|&a, &b| cost(centres[a]).total_cmp(&cost(centres[b])))
                .expect("there is a centre");
        }
        let mut moved = false;
        for (cell, centre) in centres.iter_mut().enumerate() {
            let members = || samples.iter().zip(&owner).enumerate().filter(|(_, (_, o))| **o == cell);
            let number = members().count().max(1) as f64;
            let middle: Vector3<f64> = members().map(|(_, (s, _))| s.0).sum::<Vector3<f64>>() / number;
            let facing: Vector3<f64> = members().map(|(_, (s, _))| s.1).sum::<Vector3<f64>>() / number;
            let cost =
                |k: usize| (samples[k].0 - middle).norm_squared() + area * (1.0 - samples[k].1.dot(&facing));
            let best = members().map(|(k, _)| k).min_by(|&a, &b| cost(a).total_cmp(&cost(b)));
            if let Some(best) = best.filter(|best| best != centre) {
                *centre = best;
                moved = true;
            }
        }
        if !moved {
            break;
        }
    }
    let rim = 0.5 * share.sqrt();
    let patch = |(cell, &centre): (usize, &usize)| {
        let (position, normal) = samples[centre];
        let along = long_axis - normal * normal.dot(long_axis);
        let tangent = along
            .try_normalize(1e-3)
            .unwrap_or_else(|| crate::kinematics::tangent_basis(&normal).column(0).into());
        let bitangent = normal.cross(&tangent);
        let extent = |direction: &Vector3<f64>| {
            let members = samples.iter().zip(&owner).filter(|(_, o)| **o == cell);
            members.map(|(s, _)| (s.0 - position).dot(direction).abs()).fold(0.0, f64::max) + rim
        };
        let axes = Matrix3::from_columns(&[tangent, bitangent, normal]);
        Patch {
            body: 0,
            position,
            orientation: UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(axes)),
            half_extents: [extent(&tangent), extent(&bitangent)],
        }
    };
    centres.iter().enumerate().map(patch).collect()
}

/// The sample with the greatest value; the first of equals.
fn farthest(samples: &[(Vector3<f64>, Vector3<f64>)], value: impl Fn(&Vector3<f64>) -> f64) -> usize {
    let mut best = (0, f64::NEG_INFINITY);
    for (k, (point, _)) in samples.iter().enumerate() {
        let found = value(point);
        if found > best.1 + 1e-12 {
            best = (k, found);
        }
    }
    best.0
}

/// Reads an MJCF file with its includes written out.
fn read(path: &Path, seen: &mut HashSet<PathBuf>) -> Result<Element, GrowError> {
    let file_error = |source| GrowError::File { path: path.to_path_buf(), source };
    let xml_error = |message: String| GrowError::Xml { path: path.to_path_buf(), message };
    if !seen.insert(path.to_path_buf()) {
        return Err(xml_error("it includes itself: MuJoCo allows each file once".into()));
    }
    let text = std::fs::read_to_string(path).map_err(file_error)?;
    let mut root = Element::parse(text.as_bytes()).map_err(|e| xml_error(e.to_string()))?;
    include(&mut root, path.parent().unwrap_or(Path::new("")), seen)?;
    Ok(root)
}

fn include(element: &mut Element, folder: &Path, seen: &mut HashSet<PathBuf>) -> Result<(), GrowError> {
    for mut child in std::mem::take(&mut element.children) {
        match child.as_mut_element() {
            Some(inner) if inner.name == "include" => {
                let file = inner.attributes.get("file").cloned().unwrap_or_default();
                element.children.extend(read(&folder.join(file), seen)?.children);
            }
            Some(inner) => {
                include(inner, folder, seen)?;
                element.children.push(child);
            }
            None => element.children.push(child),
        }
    }
    Ok(())
}

/// Puts the sites behind the geoms of their bodies; what is placed leaves `sites`.
fn insert_sites(element: &mut Element, sites: &mut BTreeMap<String, Vec<Element>>) {
    if element.name == "body" {
        let new = element.attributes.get("name").and_then(|name| sites.remove(name.as_str()));
        let at = element
            .children
            .iter()
            .rposition(|child| child.as_element().is_some_and(|e| e.name == "geom"))
            .map_or(0, |k| k + 1);
        let new = new.into_iter().flatten().map(XMLNode::Element);
        element.children.splice(at..at, new);
    }
    for child in element.children.iter_mut().filter_map(XMLNode::as_mut_element) {
        insert_sites(child, sites);
    }
}

fn attribute<'a>(root: &'a Element, child: &str, name: &str) -> Option<&'a str> {
    root.get_child(child)?.attributes.get(name).map(String::as_str)
}

/// Numbers as MJCF wants them, to a hundredth of a millimetre or less.
fn numbers<'a>(values: impl Iterator<Item = &'a f64>) -> String {
    let text = |value: &f64| {
        let text = format!("{value:.6}");
        let text = text.trim_end_matches('0').trim_end_matches('.');
        if text == "-0" { "0".to_string() } else { text.to_string() }
    };
    values.map(text).collect::<Vec<_>>().join(" ")
}
