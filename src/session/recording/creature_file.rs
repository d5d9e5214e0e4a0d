//! A creature by hand: the JSON that says which limbs a body has, which joints carry them, and how each moves.

use std::collections::BTreeSet;
use std::f64::consts::PI;
use std::path::Path;

use serde::de::DeserializeOwned;
use serde_json::{Value, json};

use crate::agent::Agent;
use crate::creature::Creature;
use crate::error::{Error, json_reason};
use crate::session::files;
use crate::skin::Skin;

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

/// The creature and skin of a file. A session's file has indices where a person writes names, and leaves nothing out: names
/// become indices here, and ranges that are left out are filled in.
fn parse(mut file: Value) -> Result<CreatureFile, String> {
    let seed = file.get("seed").and_then(Value::as_u64);
    let take = |file: &mut Value, field: &str| file.as_object_mut().and_then(|file| file.remove(field));
    let skin = take(&mut file, "skin").filter(|skin| !skin.is_null());
    let (creature, names) = match take(&mut file, "creature") {
        Some(creature) => named_creature(creature, "creature.")?,
        None => named_creature(file, "")?,
    };
    let mut skin = skin.unwrap_or(json!({ "receptors": [] }));
    for list in ["receptors", "surfaces"] {
        names.resolve_limbs(&mut skin, list, "limb", "skin.")?;
    }
    let agent = Agent::new(creature, typed::<Skin>(skin, "skin.")?).map_err(|error| error.to_string())?;
    Ok(CreatureFile { agent, seed })
}

/// The creature of a description that is nothing else.
pub(in crate::session) fn creature_of(description: Value) -> Result<Creature, String> {
    named_creature(description, "").map(|(creature, _)| creature)
}

/// The creature of a description, and its names; `at` is before all places in messages.
fn named_creature(mut description: Value, at: &str) -> Result<(Creature, Names), String> {
    let mut names = Names::of(&description)?;
    names.resolve_creature(&mut description, at)?;
    let creature = typed(description, at)?;
    match &names.endless {
        Some(slide) => Err(format!("{slide} is a slide without a range: give its limits in metres")),
        None => Ok((creature, names)),
    }
}

/// A value as a type, an error with the place.
pub(in crate::session) fn typed<T: DeserializeOwned>(value: Value, at: &str) -> Result<T, String> {
    serde_path_to_error::deserialize(value).map_err(|error| {
        let path = error.path().to_string();
        let place = format!("{at}{}", if path == "." { "" } else { &path });
        let place = Some(place.trim_end_matches('.')).filter(|place| !place.is_empty());
        let place = place.map_or(String::new(), |place| format!("{place}: "));
        let mend = "correct it according to the documentation of the creature file";
        format!("{place}{}: {mend}", json_reason(error.inner()))
    })
}

/// What is in a field that holds a list; nothing if it holds none, which the type of the whole complains of.
pub(in crate::session) fn list<'v>(value: &'v mut Value, field: &str) -> impl Iterator<Item = &'v mut Value> {
    value.get_mut(field).and_then(Value::as_array_mut).into_iter().flatten()
}

/// The names of a file's limbs and degrees of freedom; `None` if it has no list of them.
struct Names {
    limbs: Option<Vec<String>>,
    dofs: Option<Vec<String>>,
    /// The place of a slide without a range, which is told once all else is right: the range may only be misspelt.
    endless: Option<String>,
}

impl Names {
    /// The names in a description of a creature, where none occurs twice and every joint moves: so it always is in a creature
    /// from a simulator.
    fn of(creature: &Value) -> Result<Names, String> {
        let text = |value: &Value| value.as_str().map(str::to_string);
        let limbs = creature["limbs"].as_array().map(|limbs| limbs.iter().filter_map(text).collect());
        let joints = creature["joints"].as_array();
        let dofs = joints.map(|joints| {
            let dofs = joints.iter().filter_map(|joint| joint["dofs"].as_array()).flatten();
            dofs.filter_map(|dof| text(&dof["name"])).collect()
        });
        for (names, what) in [(&limbs, "limbs"), (&dofs, "degrees of freedom")] {
            let mut seen = BTreeSet::new();
            let names: &[String] = names.as_deref().unwrap_or_default();
            if let Some(twice) = names.iter().find(|name| !seen.insert(*name)) {
                return Err(format!("two {what} are called \"{twice}\": give each its own name"));
            }
        }
        let fixed = |joint: &&Value| joint["dofs"].as_array().is_some_and(Vec::is_empty);
        match joints {
            Some(joints) if joints.is_empty() => Err("it has no joint: give at least one".into()),
            Some(joints) if joints.iter().any(|joint| fixed(&joint)) => {
                let name = joints.iter().find(fixed).map_or(&Value::Null, |joint| &joint["name"]);
                Err(format!(
                    "joint {name} has no degrees of freedom: a rigid part belongs to its parent limb; leave it out"
                ))
            }
            _ => Ok(Names { limbs, dofs, endless: None }),
        }
    }

    /// Puts the index of a limb in place of its name.
    fn resolve_limb(&self, limb: &mut Value, place: &str) -> Result<(), String> {
        let missing = |name: &str| format!("limbs contains no \"{name}\": add it, or give another name");
        resolve(limb, self.limbs.as_deref(), place, missing)
    }

    /// The same in a field of every object of a list.
    fn resolve_limbs(&self, of: &mut Value, name: &str, field: &str, at: &str) -> Result<(), String> {
        let objects = list(of, name).enumerate();
        let mut fields = objects.filter_map(|(i, object)| Some((i, object.get_mut(field)?)));
        fields.try_for_each(|(i, limb)| self.resolve_limb(limb, &format!("{at}{name}[{i}].{field}")))
    }

    /// Puts indices in place of all names in a description of a creature, and fills in the ranges that are left out.
    fn resolve_creature(&mut self, creature: &mut Value, at: &str) -> Result<(), String> {
        self.resolve_limbs(creature, "joints", "parent", at)?;
        self.resolve_limbs(creature, "joints", "limb", at)?;
        for (j, joint) in list(creature, "joints").enumerate() {
            let carried = joint.as_object_mut().and_then(|joint| joint.remove("limb"));
            let other = carried.is_some_and(|limb| !limb.is_null() && limb != json!(j + 1));
            if other && self.limbs.is_some() {
                let name =
                    self.limbs.as_ref().and_then(|limbs| limbs.get(j + 1)).map_or("none", String::as_str);
                return Err(format!(
                    "{at}joints[{j}].limb differs from limb {} of the list, \"{name}\": put joints and limbs in \
                     the same order",
                    j + 1
                ));
            }
            for (d, dof) in list(joint, "dofs").enumerate() {
                self.complete_dof(dof, &format!("{at}joints[{j}].dofs[{d}]"))?;
            }
        }
        for (i, aura) in list(creature, "aura_limbs").enumerate() {
            for (k, limb) in list(aura, "limbs").enumerate() {
                self.resolve_limb(limb, &format!("{at}aura_limbs[{i}].limbs[{k}]"))?;
            }
        }
        Ok(())
    }

    /// Puts an index in place of the name of what a degree of freedom follows, and fills in its range.
    fn complete_dof(&mut self, dof: &mut Value, place: &str) -> Result<(), String> {
        if dof.get("range").is_none_or(Value::is_null) {
            match dof["kind"].as_str() {
                Some("hinge") => dof["range"] = json!([-PI, PI]),
                Some("ball") => dof["range"] = json!([0.0, PI]),
                Some("slide") => {
                    dof["range"] = json!([0.0, 0.0]);
                    self.endless.get_or_insert(place.to_string());
                }
                // Another kind, or none, is no kind of the type's.
                _ => {}
            }
        }
        let missing = |name: &str| format!("no degree of freedom \"{name}\": give one of joints[].dofs[]");
        match dof.get_mut("follows").and_then(|follows| follows.get_mut("leader")) {
            Some(leader) => {
                resolve(leader, self.dofs.as_deref(), &format!("{place}.follows.leader"), missing)
            }
            None => Ok(()),
        }
    }
}

/// Puts the index among `all` in place of a name.
fn resolve(
    name: &mut Value,
    all: Option<&[String]>,
    place: &str,
    missing: impl Fn(&str) -> String,
) -> Result<(), String> {
    let Value::String(text) = &name else { return Ok(()) };
    let index = all.map_or(Some(0), |all| all.iter().position(|other| other == text));
    *name = json!(index.ok_or_else(|| format!("{place}: {}", missing(text)))?);
    Ok(())
}
