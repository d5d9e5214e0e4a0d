//! A creature by hand: the JSON that says which limbs a body has, which joints carry them, and how each moves.

use std::collections::BTreeSet;
use std::f64::consts::PI;
use std::path::Path;

use nalgebra::{Matrix3, Vector3};
use serde::Deserialize;
use serde::de::DeserializeOwned;
use serde_json::Value;

use crate::agent::Agent;
use crate::creature::{AuraLimb, Coupling, Creature, Dof, DofKind, Joint};
use crate::error::Error;
use crate::geometry::Shape;
use crate::session::files;
use crate::skin::{Receptor, Skin, Surface};

/// A creature's file, read.
#[derive(Clone, Debug, PartialEq)]
pub struct CreatureFile {
    /// The creature and its skin, which is empty if the file has none.
    pub agent: Agent,
    /// The seed of the session, if the file is a whole `session.json`.
    pub seed: Option<u64>,
}

/// Reads a creature from the JSON file `path`.
///
/// The file is the `creature` of a `session.json`, or an object with it and optionally a `skin` beside it, such
/// as a whole `session.json`:
///
/// | field | is |
/// |---|---|
/// | `name` | the creature's name |
/// | `limbs` | the limbs' names, the root first, every limb after the one that carries it |
/// | `joints` | one joint per limb but the root, in the limbs' order: joint i (from 0) carries limb i + 1 |
/// | `joints[].name` | the joint's name |
/// | `joints[].parent` | the limb it is mounted on, by name or index (from 0) |
/// | `joints[].limb` | optional: the limb it carries, by name or index; checked |
/// | `joints[].dofs` | its degrees of freedom from the parent's side, all about or along axes through one point |
/// | `dofs[].name` | the name by which a log gives its coordinate |
/// | `dofs[].kind` | `hinge` (radians), `slide` (metres) or `ball` (a unit quaternion w, x, y, z) |
/// | `dofs[].range` | least and greatest coordinate, radians or metres; of a ball 0 and the largest angle. A slide needs it, others default to \[−π, π\] and \[0, π\] |
/// | `dofs[].follows` | optional, if it follows another: `leader`, the degree of freedom that it follows, by name or index over all (from 0), and `polynomial`, five coefficients of degree 0 to 4 that give its coordinate from that one's |
/// | `aura_limbs` | optional: named parts of the body, `{"name", "limbs": […]}`, for reports |
///
/// `skin` is as in a `session.json`, limbs by name or index: `receptors` with `id`, `limb`, `position` (centre in
/// the limb's frame, metres), `normal` and `tangent` (unit vectors), `half_extents` (metres along the tangent and
/// along normal × tangent) and `surface` (an index into `surfaces`, or null); `surfaces` with `limb`, `origin` (in
/// the limb's frame, metres), `rotation` (its columns are the shape's axes) and `shape`, as
/// [`Shape`](crate::geometry::Shape) says.
///
/// # Errors
/// If the file cannot be read, or, with the field, if it is no
/// such file.
pub fn read_creature(path: &Path) -> Result<CreatureFile, Error> {
    let bytes = files::read(path)?;
    let text = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(&bytes);
    let value: Value = serde_json::from_slice(text)
        .map_err(|error| Error::json(path, "description of a creature", &error))?;
    parse(value).map_err(|message| Error::content(path, None, message))
}

/// One of a list, by its name or its index (from 0).
#[derive(Deserialize)]
#[serde(untagged, expecting = "a name or an index")]
enum NameOrIndex {
    Name(String),
    Index(usize),
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields, expecting = "an object")]
struct CreatureEntry {
    name: String,
    limbs: Vec<String>,
    joints: Vec<JointEntry>,
    #[serde(default)]
    aura_limbs: Vec<AuraEntry>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields, expecting = "an object")]
struct JointEntry {
    name: String,
    parent: NameOrIndex,
    limb: Option<NameOrIndex>,
    dofs: Vec<DofEntry>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields, expecting = "an object")]
struct DofEntry {
    name: String,
    kind: DofKind,
    range: Option<[f64; 2]>,
    follows: Option<CouplingEntry>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields, expecting = "an object")]
struct CouplingEntry {
    leader: NameOrIndex,
    polynomial: [f64; 5],
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields, expecting = "an object")]
struct AuraEntry {
    name: String,
    limbs: Vec<NameOrIndex>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields, expecting = "an object")]
struct SkinEntry {
    receptors: Vec<ReceptorEntry>,
    #[serde(default)]
    surfaces: Vec<SurfaceEntry>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields, expecting = "an object")]
struct ReceptorEntry {
    id: String,
    limb: NameOrIndex,
    position: Vector3<f64>,
    normal: Vector3<f64>,
    tangent: Vector3<f64>,
    half_extents: [f64; 2],
    // There as a null at least: what is misspelt would be none in silence.
    #[serde(deserialize_with = "Option::deserialize")]
    surface: Option<usize>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields, expecting = "an object")]
struct SurfaceEntry {
    limb: NameOrIndex,
    origin: Vector3<f64>,
    rotation: Matrix3<f64>,
    shape: Shape,
}

fn parse(mut file: Value) -> Result<CreatureFile, String> {
    let seed = file.get("seed").and_then(Value::as_u64);
    let skin = file.as_object_mut().and_then(|file| file.remove("skin"));
    let (creature, at) = match file.as_object_mut().and_then(|file| file.remove("creature")) {
        Some(creature) => (creature, "creature."),
        None => (file, ""),
    };
    let creature = typed::<CreatureEntry>(creature, at)?.creature(at)?;
    let skin = match skin.filter(|skin| !skin.is_null()) {
        None => Skin::default(),
        Some(skin) => typed::<SkinEntry>(skin, "skin.")?.skin(creature.limbs())?,
    };
    let agent = Agent::new(creature, skin).map_err(|error| error.to_string())?;
    Ok(CreatureFile { agent, seed })
}

/// A value as a type, an error with the place.
fn typed<T: DeserializeOwned>(value: Value, at: &str) -> Result<T, String> {
    serde_path_to_error::deserialize(value).map_err(|error| {
        let path = error.path().to_string();
        let place = format!("{at}{}", if path == "." { "" } else { &path });
        let place = Some(place.trim_end_matches('.')).filter(|place| !place.is_empty());
        let place = place.map_or(String::new(), |place| format!("{place}: "));
        let mend = "mend it as the documentation of the creature's file says";
        format!("{place}{}: {mend}", error.inner())
    })
}

impl NameOrIndex {
    /// Its index among limbs.
    fn among(&self, limbs: &[String], place: &str) -> Result<usize, String> {
        match self {
            NameOrIndex::Index(index) => Ok(*index),
            NameOrIndex::Name(name) => limbs.iter().position(|other| other == name).ok_or_else(|| {
                format!("{place}: there is no limb \"{name}\" in limbs: add it, or name another")
            }),
        }
    }
}

impl CreatureEntry {
    fn creature(self, at: &str) -> Result<Creature, String> {
        let CreatureEntry { name, limbs, joints, aura_limbs } = self;
        let dofs: Vec<String> =
            joints.iter().flat_map(|joint| &joint.dofs).map(|dof| dof.name.clone()).collect();
        check_names(&limbs, &dofs, &joints)?;
        let mut made = Vec::with_capacity(joints.len());
        for (j, joint) in joints.into_iter().enumerate() {
            let place = format!("{at}joints[{j}]");
            let parent = joint.parent.among(&limbs, &format!("{place}.parent"))?;
            let carried = joint.limb.map(|limb| limb.among(&limbs, &format!("{place}.limb"))).transpose()?;
            if carried.is_some_and(|carried| carried != j + 1) {
                let name = limbs.get(j + 1).map_or("none", String::as_str);
                return Err(format!(
                    "{place}.limb is another than limb {} of the list, \"{name}\": put joints and limbs in one order",
                    j + 1
                ));
            }
            let own = joint.dofs.into_iter().enumerate();
            let own = own.map(|(d, dof)| dof.dof(&dofs, &format!("{place}.dofs[{d}]")));
            made.push(Joint::new(joint.name, parent, own.collect::<Result<_, _>>()?));
        }
        let aura = |(i, aura): (usize, AuraEntry)| -> Result<AuraLimb, String> {
            let of = aura.limbs.iter().enumerate();
            let of = of.map(|(k, limb)| limb.among(&limbs, &format!("{at}aura_limbs[{i}].limbs[{k}]")));
            Ok(AuraLimb { name: aura.name, limbs: of.collect::<Result<_, _>>()? })
        };
        let auras = aura_limbs.into_iter().enumerate().map(aura).collect::<Result<_, _>>()?;
        Creature::new(name, limbs, made, auras).map_err(|error| error.to_string())
    }
}

impl DofEntry {
    /// The degree of freedom; `dofs` are the names of all.
    fn dof(self, dofs: &[String], place: &str) -> Result<Dof, String> {
        let range = match (self.range, self.kind) {
            (Some(range), _) => range,
            (None, DofKind::Hinge) => [-PI, PI],
            (None, DofKind::Ball) => [0.0, PI],
            (None, DofKind::Slide) => {
                return Err(format!("{place} is a slide and has no range: give its ends in metres"));
            }
        };
        let follows = self.follows.map(|CouplingEntry { leader, polynomial }| {
            let leader = match leader {
                NameOrIndex::Index(leader) => leader,
                NameOrIndex::Name(name) => {
                    dofs.iter().position(|other| *other == name).ok_or_else(|| {
                        format!(
                            "{place}.follows.leader: there is no degree of freedom \"{name}\": name one of joints[].dofs[]"
                        )
                    })?
                }
            };
            Ok::<Coupling, String>(Coupling { leader, polynomial })
        });
        Ok(Dof { name: self.name, kind: self.kind, range, follows: follows.transpose()? })
    }
}

impl SkinEntry {
    fn skin(self, limbs: &[String]) -> Result<Skin, String> {
        let receptor = |(i, entry): (usize, ReceptorEntry)| -> Result<Receptor, String> {
            let limb = entry.limb.among(limbs, &format!("skin.receptors[{i}].limb"))?;
            let ReceptorEntry { id, position, normal, tangent, half_extents, surface, .. } = entry;
            Ok(Receptor { id, limb, position, normal, tangent, half_extents, surface })
        };
        let surface = |(i, entry): (usize, SurfaceEntry)| -> Result<Surface, String> {
            let limb = entry.limb.among(limbs, &format!("skin.surfaces[{i}].limb"))?;
            let SurfaceEntry { origin, rotation, shape, .. } = entry;
            Ok(Surface { limb, origin, rotation, shape, geom: 0 })
        };
        Ok(Skin {
            receptors: self.receptors.into_iter().enumerate().map(receptor).collect::<Result<_, _>>()?,
            surfaces: self.surfaces.into_iter().enumerate().map(surface).collect::<Result<_, _>>()?,
        })
    }
}

/// Refuses what a creature from a simulator never has: names that occur twice, and joints that do not move.
fn check_names(limbs: &[String], dofs: &[String], joints: &[JointEntry]) -> Result<(), String> {
    for (names, what) in [(limbs, "limbs"), (dofs, "degrees of freedom")] {
        let mut seen = BTreeSet::new();
        if let Some(twice) = names.iter().find(|name| !seen.insert(*name)) {
            return Err(format!("two {what} are called \"{twice}\": give each a name of its own"));
        }
    }
    match joints.iter().find(|joint| joint.dofs.is_empty()) {
        Some(fixed) => Err(format!(
            "joint \"{}\" has no degrees of freedom: what does not move is a part of its parent limb, leave it out",
            fixed.name
        )),
        None if joints.is_empty() => Err("it has no joint: give at least one".into()),
        None => Ok(()),
    }
}
