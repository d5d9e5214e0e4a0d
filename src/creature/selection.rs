//! What of a model is the creature: its root and the joints it moves.

use serde::{Deserialize, Serialize};

use super::names::body_name;
use super::no_joints;
use crate::error::Error;
use crate::mujoco::{JointKind, Model, ObjectKind};

/// Tuples of a model whose name starts with this list the joints of one named set.
const JOINTS_TUPLE: &str = "joints/";
/// The joint set that is learned unless another is asked for, where the model defines it.
const DEFAULT_JOINTS: &str = "torso";

/// Which joints the creature moves; the others stay where they are at the reference posture.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(from = "String", into = "String")]
pub enum JointSelection {
    /// The model's `joints/torso`, or all where it defines none.
    #[default]
    Default,
    /// All joints.
    All,
    /// The model's tuple `joints/NAME`, or else joints by name, separated by commas.
    Named(String),
}

impl std::str::FromStr for JointSelection {
    type Err = std::convert::Infallible;

    fn from_str(text: &str) -> Result<JointSelection, Self::Err> {
        Ok(text.to_string().into())
    }
}

impl From<String> for JointSelection {
    fn from(text: String) -> JointSelection {
        match text.as_str() {
            "all" => JointSelection::All,
            "default" => JointSelection::Default,
            _ => JointSelection::Named(text),
        }
    }
}

impl From<JointSelection> for String {
    fn from(selection: JointSelection) -> String {
        selection.to_string()
    }
}

impl std::fmt::Display for JointSelection {
    fn fmt(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
        f.write_str(match self {
            JointSelection::Default => "default",
            JointSelection::All => "all",
            JointSelection::Named(name) => name,
        })
    }
}

/// A creature in a file: a tree of bodies that can move.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct CreatureInFile {
    /// The body at which it begins.
    pub root: usize,
    /// That body's name, by which it is chosen.
    pub name: String,
    /// Its joints but for the free one that carries it.
    pub joints: usize,
}

/// The creature with most joints in a model, of two with as many the first.
///
/// # Errors
/// If nothing in it can move.
pub(crate) fn largest(model: &Model) -> Result<CreatureInFile, Error> {
    creatures(model).into_iter().rev().max_by_key(|creature| creature.joints).ok_or_else(no_joints)
}

/// All creatures in a model, in its order. What moves freely as a whole but has no joints is none.
pub fn creatures(model: &Model) -> Vec<CreatureInFile> {
    let mut trees = vec![0; model.nbody()];
    for (i, body) in model.bodies().enumerate().skip(1) {
        trees[i] = if body.parent == 0 { i } else { trees[body.parent] };
    }
    let mut joints = vec![0; model.nbody()];
    for joint in model.joints().filter(|joint| joint.kind != JointKind::Free) {
        joints[trees[joint.body]] += 1;
    }
    let moving = (1..model.nbody()).filter(|&body| joints[body] > 0);
    moving.map(|root| CreatureInFile { root, name: body_name(model, root), joints: joints[root] }).collect()
}

/// The creature's root limb and all that hangs on it.
pub(super) struct Tree {
    /// The MuJoCo body that is the root limb; 0 where the creature is mounted on the world.
    pub root: usize,
    /// Per MuJoCo body, whether it is the creature's; the world never is.
    pub holds: Vec<bool>,
}

impl Tree {
    /// The tree below the body called `root`, or else the one with most joints in the model.
    ///
    /// # Errors
    /// Where there is no such body, or nothing below it can move.
    pub fn new(model: &Model, root: Option<&str>) -> Result<Tree, Error> {
        let top = match root {
            None => largest(model)?.root,
            Some(name) => named(model, name)?,
        };
        let mut holds = vec![false; model.nbody()];
        for (i, body) in model.bodies().enumerate().skip(1) {
            holds[i] = i == top || holds[body.parent];
        }
        // A body hinged to the world is carried by it; one that was asked for by name in mid-tree is a root
        // that stands still.
        let child_of_world = model.body(top).parent == 0;
        let mounted = model.joints().any(|j| j.body == top && j.kind != JointKind::Free);
        Ok(Tree { root: if child_of_world && mounted { 0 } else { top }, holds })
    }
}

/// The body of a name, or of the one that it has here where the file gives it none.
fn named(model: &Model, name: &str) -> Result<usize, Error> {
    let found = model.id(ObjectKind::Body, name).filter(|&body| body != 0);
    let unnamed =
        || (1..model.nbody()).find(|&body| model.body(body).name.is_none() && body_name(model, body) == name);
    found.or_else(unnamed).ok_or_else(|| {
        let roots: Vec<String> =
            creatures(model).into_iter().map(|creature| creature.name).take(12).collect();
        Error::model(format!(
            "the model has no body {name}; its creatures have the roots {}: give one of these",
            roots.join(", ")
        ))
    })
}

/// Per MuJoCo joint, whether the selection names it.
pub(super) fn select(model: &Model, selection: &JointSelection) -> Result<Vec<bool>, Error> {
    let tuples = model.tuples();
    let set = |name: &str| {
        let tuple = tuples
            .iter()
            .find(|t| t.name.and_then(|t| t.strip_prefix(JOINTS_TUPLE)).is_some_and(|set| set == name))?;
        let mut selected = vec![false; model.njnt()];
        for entry in tuple.entries.iter().filter(|entry| entry.object == ObjectKind::Joint) {
            selected[entry.id] = true;
        }
        Some(selected)
    };
    let all = || vec![true; model.njnt()];
    let text = match selection {
        JointSelection::All => return Ok(all()),
        JointSelection::Default => return Ok(set(DEFAULT_JOINTS).unwrap_or_else(all)),
        JointSelection::Named(text) => text,
    };
    let mut selected = vec![false; model.njnt()];
    for name in text.split(',').map(str::trim) {
        if let Some(set) = set(name) {
            selected.iter_mut().zip(set).for_each(|(a, b)| *a |= b);
            continue;
        }
        // A joint's own name, or what several degrees of freedom of one joint are called in common.
        let named =
            |joint: &str| joint == name || joint.strip_prefix(name).is_some_and(|r| r.starts_with('_'));
        let mut found = false;
        for (j, joint) in model.joints().enumerate() {
            if joint.name.is_some_and(named) {
                selected[j] = true;
                found = true;
            }
        }
        if !found {
            let sets = tuples.iter().filter_map(|t| t.name?.strip_prefix(JOINTS_TUPLE));
            let sets: Vec<&str> = sets.chain(["all"]).collect();
            return Err(Error::model(format!(
                "the model has no joint and no joint set named {name}; it has the sets {}",
                sets.join(", ")
            )));
        }
    }
    Ok(selected)
}
