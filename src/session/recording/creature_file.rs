//! A creature by hand: the JSON that says which limbs a body has, which joints carry them, and how each moves.

use std::collections::BTreeSet;
use std::f64::consts::PI;
use std::path::Path;

use serde_json::{Map, Value, json};

use crate::agent::Agent;
use crate::creature::Creature;
use crate::session::fields::check_fields;
use crate::session::record_error::ContentFault;
use crate::session::{RecordError, files};
use crate::skin::Skin;

/// The fields of a receptor of the skin.
const OF_RECEPTOR: [&str; 7] = ["id", "limb", "position", "normal", "tangent", "half_extents", "surface"];
/// The fields of what a degree of freedom follows.
const OF_COUPLING: [&str; 2] = ["leader", "polynomial"];
/// The fields of a surface of the skin.
const OF_SURFACE: [&str; 4] = ["limb", "origin", "rotation", "shape"];

/// A creature's file, read.
#[derive(Clone, Debug, PartialEq)]
pub struct CreatureFile {
    /// The creature and its skin, which is empty where the file has none.
    pub agent: Agent,
    /// The seed of the session, where the file is a whole `session.json`.
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
/// | `dofs[].follows` | optional, where it does not move by itself: `leader`, the degree of freedom that it follows, by name or index over all (from 0), and `polynomial`, five coefficients of degree 0 to 4 that give its coordinate from that one's |
/// | `aura_limbs` | optional: named parts of the body, `{"name", "limbs": […]}`, for reports |
///
/// `skin` is as in a `session.json`, limbs by name or index: `receptors` with `id`, `limb`, `position` (centre in
/// the limb's frame, metres), `normal` and `tangent` (unit vectors), `half_extents` (metres along the tangent and
/// along normal × tangent) and `surface` (an index into `surfaces`, or null); `surfaces` with `limb`, `origin` (in
/// the limb's frame, metres), `rotation` (its columns are the shape's axes) and `shape`, as
/// [`Shape`](crate::geometry::Shape) says.
///
/// # Errors
/// [`RecordError::Io`] where the file cannot be read; [`RecordError::Format`], with the field, where it is no
/// such file.
pub fn read_creature(path: &Path) -> Result<CreatureFile, RecordError> {
    let bytes = files::read(path)?;
    let text = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(&bytes);
    let value: Value = serde_json::from_slice(text)
        .map_err(|error| RecordError::json(path, "description of a creature", &error))?;
    parse(value).map_err(|message| RecordError::format(path, None, message))
}

fn parse(value: Value) -> Result<CreatureFile, ContentFault> {
    let Value::Object(mut file) = value else {
        return Err("it is no JSON object: give one with name, limbs and joints, or a session.json".into());
    };
    let seed = file.get("seed").and_then(Value::as_u64);
    let (mut creature, skin, at) = match file.remove("creature") {
        Some(creature @ Value::Object(_)) => (creature, file.remove("skin"), "creature."),
        Some(_) => {
            return Err("its creature is no object: give one with name, limbs and joints".into());
        }
        None => {
            let skin = file.remove("skin");
            (Value::Object(file), skin, "")
        }
    };
    let limbs = prepare_creature(&mut creature, at)?;
    let creature: Creature = typed(creature, at)?;
    check_creature(&creature)?;
    let skin = match skin {
        None | Some(Value::Null) => Skin::default(),
        Some(mut skin) => {
            prepare_skin(&mut skin, &limbs)?;
            typed(skin, "skin.")?
        }
    };
    let agent = Agent::new(creature, skin).map_err(|error| error.to_string())?;
    Ok(CreatureFile { agent, seed })
}

/// A value as a type, an error with the place.
fn typed<T: serde::de::DeserializeOwned>(value: Value, at: &str) -> Result<T, ContentFault> {
    serde_path_to_error::deserialize(value).map_err(|error| {
        let path = error.path().to_string();
        let place = if path == "." { at.trim_end_matches('.').to_string() } else { format!("{at}{path}") };
        let mend = "mend it as the documentation of the creature's file says";
        let inner = error.inner();
        if place.is_empty() {
            format!("{inner}: {mend}").into()
        } else {
            format!("{place}: {inner}: {mend}").into()
        }
    })
}

/// Fills in what may be left out, and turns limbs' names into indices; the limbs' names.
fn prepare_creature(creature: &mut Value, at: &str) -> Result<Vec<String>, ContentFault> {
    let creature = object(creature, at.trim_end_matches('.'))?;
    check_fields(creature, at, &["name", "limbs", "joints", "aura_limbs"])?;
    creature.entry("aura_limbs").or_insert(json!([]));
    let limbs: Vec<String> = creature
        .get("limbs")
        .and_then(|limbs| serde_json::from_value(limbs.clone()).ok())
        .ok_or_else(|| format!("{at}limbs is not a list of names: give the limbs' names, the root first"))?;
    let dofs = dof_names(creature);
    for (j, joint) in list(creature, "joints", at)?.iter_mut().enumerate() {
        let place = format!("{at}joints[{j}]");
        let joint = object(joint, &place)?;
        check_fields(joint, &format!("{place}."), &["name", "parent", "limb", "dofs"])?;
        limb_index(joint, "parent", &place, &limbs)?;
        if joint.contains_key("limb") {
            limb_index(joint, "limb", &place, &limbs)?;
            let carried = joint.remove("limb").and_then(|limb| limb.as_u64());
            if carried != Some(j as u64 + 1) {
                let name = limbs.get(j + 1).map_or("none", String::as_str);
                return Err(format!(
                    "{place}.limb is another than limb {} of the list, \"{name}\": put joints and limbs in one order",
                    j + 1
                ).into());
            }
        }
        for (d, dof) in list(joint, "dofs", &format!("{place}."))?.iter_mut().enumerate() {
            let place = format!("{place}.dofs[{d}]");
            let dof = object(dof, &place)?;
            check_fields(dof, &format!("{place}."), &["name", "kind", "range", "follows"])?;
            if let Some(follows) = dof.get_mut("follows").filter(|follows| !follows.is_null()) {
                let place = format!("{place}.follows");
                let follows = object(follows, &place)?;
                check_fields(follows, &format!("{place}."), &OF_COUPLING)?;
                if let Some(leader @ Value::String(_)) = follows.get_mut("leader") {
                    let Some(index) = dofs.iter().position(|name| leader == name) else {
                        return Err(format!(
                            "{place}.leader: there is no degree of freedom {leader}: name one of joints[].dofs[]"
                        )
                        .into());
                    };
                    *leader = json!(index);
                }
            }
            let range = match dof.get("kind").and_then(Value::as_str) {
                Some("hinge") => json!([-PI, PI]),
                Some("ball") => json!([0.0, PI]),
                Some("slide") if dof.get("range").is_none_or(Value::is_null) => {
                    return Err(
                        format!("{place} is a slide and has no range: give its ends in metres").into()
                    );
                }
                _ => Value::Null,
            };
            if dof.get("range").is_none_or(Value::is_null) {
                dof.insert("range".into(), range);
            }
        }
    }
    for (i, aura) in list(creature, "aura_limbs", at)?.iter_mut().enumerate() {
        let place = format!("{at}aura_limbs[{i}]");
        let aura = object(aura, &place)?;
        for (k, limb) in list(aura, "limbs", &format!("{place}."))?.iter_mut().enumerate() {
            name_to_index(limb, &format!("{place}.limbs[{k}]"), &limbs)?;
        }
    }
    Ok(limbs)
}

/// The names of all degrees of freedom, as far as they have names.
fn dof_names(creature: &Map<String, Value>) -> Vec<Value> {
    let list = |value: Option<&Value>| value.and_then(Value::as_array).cloned().unwrap_or_default();
    let joints = list(creature.get("joints"));
    let dofs = joints.iter().flat_map(|joint| list(joint.get("dofs")));
    dofs.map(|dof| dof.get("name").cloned().unwrap_or_default()).collect()
}

fn prepare_skin(skin: &mut Value, limbs: &[String]) -> Result<(), ContentFault> {
    let skin = object(skin, "skin")?;
    check_fields(skin, "skin.", &["receptors", "surfaces"])?;
    skin.entry("surfaces").or_insert(json!([]));
    let parts = [("receptors", OF_RECEPTOR.as_slice()), ("surfaces", &OF_SURFACE)];
    for (part, fields) in parts {
        for (i, entry) in list(skin, part, "skin.")?.iter_mut().enumerate() {
            let place = format!("skin.{part}[{i}]");
            let entry = object(entry, &place)?;
            check_fields(entry, &format!("{place}."), fields)?;
            limb_index(entry, "limb", &place, limbs)?;
        }
    }
    Ok(())
}

/// What a creature from a simulator has by itself: names that tell things apart, and joints that move.
fn check_creature(creature: &Creature) -> Result<(), ContentFault> {
    let mut seen = BTreeSet::new();
    if let Some(twice) = creature.limbs().iter().find(|name| !seen.insert(name.as_str())) {
        return Err(format!("two limbs are called \"{twice}\": give each a name of its own").into());
    }
    let mut seen = BTreeSet::new();
    if let Some(twice) = creature.dofs().find(|dof| !seen.insert(dof.name.as_str())) {
        return Err(format!(
            "two degrees of freedom are called \"{}\": give each a name of its own",
            twice.name
        )
        .into());
    }
    if let Some(fixed) = creature.joints().iter().find(|joint| joint.dofs.is_empty()) {
        return Err(format!(
            "joint \"{}\" has no degrees of freedom: what does not move is a part of its parent limb, leave it out",
            fixed.name
        ).into());
    }
    if creature.joints().is_empty() {
        return Err("it has no joint: give at least one".into());
    }
    Ok(())
}

fn object<'a>(value: &'a mut Value, place: &str) -> Result<&'a mut Map<String, Value>, ContentFault> {
    let place = if place.is_empty() { "it" } else { place };
    value.as_object_mut().ok_or_else(|| format!("{place} is no object: give one").into())
}

fn list<'a>(
    map: &'a mut Map<String, Value>,
    field: &str,
    at: &str,
) -> Result<&'a mut Vec<Value>, ContentFault> {
    map.get_mut(field)
        .and_then(Value::as_array_mut)
        .ok_or_else(|| format!("{at}{field} is missing or no list: give one").into())
}

fn limb_index(
    map: &mut Map<String, Value>,
    field: &str,
    place: &str,
    limbs: &[String],
) -> Result<(), ContentFault> {
    let limb = map.get_mut(field).ok_or_else(|| format!("{place} has no {field}: name a limb"))?;
    name_to_index(limb, &format!("{place}.{field}"), limbs)
}

fn name_to_index(limb: &mut Value, place: &str, limbs: &[String]) -> Result<(), ContentFault> {
    if let Value::String(name) = limb {
        let Some(index) = limbs.iter().position(|other| other == name) else {
            return Err(
                format!("{place}: there is no limb \"{name}\" in limbs: add it, or name another").into()
            );
        };
        *limb = json!(index);
    }
    Ok(())
}
