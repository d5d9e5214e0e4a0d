//! A session's creature: in its model, which is known again by its content, and what it knows of its body.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use sha2::{Digest, Sha256};

use super::embodied::ModelSource;
use super::files;
use super::observer::Observer;
use crate::creature::{Body, Creature, JointSelection, Posture};
use crate::error::Error;
use crate::evaluation::is_hand;
use crate::model_files::Source;
use crate::named::listed;
use crate::peripersonal::OwnBody;
use crate::session::{
    LearningRecord, ReadLock, SCHEMA_FILE, Session, SessionOptions, TOUCHES_FILE, read_schema, read_touches,
};

/// A session's creature in its model, or in another that is named; with its textures where they are wanted.
pub(crate) fn session_body(
    session: &Session,
    model: Option<&Path>,
    textures: bool,
    observer: &dyn Observer,
) -> Result<Body, Error> {
    let path = model.map_or_else(|| PathBuf::from(&session.model), Path::to_path_buf);
    if session.recording.is_some() {
        // Which joints of a model a recording has is not known by the name of a set.
        let source = ModelSource { textures, ..ModelSource::new(&path) };
        let model = Arc::new(source.read(observer)?);
        for selection in [JointSelection::Default, JointSelection::All] {
            let body = source.clone().with_joints(selection).body_in(model.clone())?;
            if same_tree(&body.creature, session.agent.creature()) {
                return Ok(body);
            }
        }
        return Err(Error::unfit(
            &path,
            "its limbs and degrees of freedom differ from the recording's: give another model, or leave out --model",
        ));
    }
    let SessionOptions { root, joints, .. } = &session.options;
    let joints = joints.parse::<JointSelection>().unwrap_or_default();
    let source = ModelSource { model: path, joints, root: root.clone(), textures };
    let body = source.body(observer)?;
    // Who names another file vouches for it, as far as it can be told.
    let other_file = model.is_none() && model_hash(&source.model)? != session.model_hash;
    if other_file || body.creature != *session.agent.creature() {
        return Err(Error::unfit(
            &source.model,
            "it is not the model of the session, or has changed since: give the right one with --model",
        ));
    }
    Ok(body)
}

/// Whether two creatures have the same limbs, joints and kinds of degrees of freedom.
pub(crate) fn same_tree(a: &Creature, b: &Creature) -> bool {
    let joints = |creature: &Creature| {
        let parents: Vec<usize> = creature.joints().iter().map(|joint| joint.parent).collect();
        let dofs: Vec<_> = creature.dofs().map(|dof| (dof.name.clone(), dof.kind)).collect();
        (creature.limbs().to_vec(), parents, dofs)
    };
    joints(a) == joints(b)
}

/// The SHA-256 of a model's XML, as `sha256:` and 64 hexadecimal digits.
///
/// It is that of the file's bytes, followed by those of the files that it includes, in the order in
/// which they are named, each followed by its own. So for a model of one file it is what `sha256sum`
/// prints. Meshes and height fields are not part of it.
///
/// # Errors
/// If the file or one that it includes cannot be read, or is malformed.
pub fn model_hash(path: &Path) -> Result<String, Error> {
    let mut hash = Sha256::new();
    let bytes = files::read(path)?;
    hash.update(&bytes);
    for included in &Source::of_bytes(path, &bytes)?.files[1..] {
        hash.update(files::read(included)?);
    }
    let digits = hash.finalize().iter().map(|byte| format!("{byte:02x}")).collect::<String>();
    Ok(format!("sha256:{digits}"))
}

/// A session and what its creature knows of its body after it.
///
/// # Errors
/// If a file of it cannot be read, or nothing was touched or learned in it.
pub fn own_body(folder: &Path) -> Result<(Session, OwnBody), Error> {
    let _reading = ReadLock::take(folder)?;
    let session = Session::read(folder)?;
    let log = read_touches(&folder.join(TOUCHES_FILE), &session.agent)?;
    let own = learned(folder, &session, log.touches.iter().map(|touch| &touch.posture))?;
    if log.touches.is_empty() {
        return Err(Error::no_touch().at(folder, None));
    }
    Ok((session, own))
}

/// What a session's creature has learned of its body, and how sure that is, without what it experienced.
pub(crate) fn learned_body(folder: &Path) -> Result<OwnBody, Error> {
    let _reading = ReadLock::take(folder)?;
    learned(folder, &Session::read(folder)?, [])
}

/// What is known of the body of a session that felt some postures.
fn learned<'a>(
    folder: &Path,
    session: &Session,
    felt: impl IntoIterator<Item = &'a Posture>,
) -> Result<OwnBody, Error> {
    let creature = session.agent.creature();
    let schema = read_schema(&folder.join(SCHEMA_FILE), creature)?;
    let certainty = LearningRecord::read(folder, creature)?.certainty();
    Ok(OwnBody::new(&session.agent, schema, certainty, felt))
}

/// The limbs that reach: those that are named, else all with receptors whose names end in hand.
pub(crate) fn hands(own: &OwnBody, names: &[String]) -> Result<Vec<usize>, Error> {
    let (creature, limbs) = (own.creature(), own.creature().limbs());
    let touching: Vec<usize> = (1..limbs.len()).filter(|&limb| own.tip_of(limb).is_some()).collect();
    let choice = || listed(&touching.iter().map(|&limb| limbs[limb].clone()).collect::<Vec<_>>());
    if names.is_empty() {
        let is_named = |limb: &usize| limbs[*limb].ends_with("hand") && is_hand(creature, *limb);
        let hands: Vec<usize> = touching.iter().copied().filter(is_named).collect();
        if hands.is_empty() {
            return Err(Error::usage(format!(
                "no limb of {} with receptors has a name that ends in hand: choose one with --hand, of {}",
                creature.name(),
                choice()
            )));
        }
        return Ok(hands);
    }
    let named = |name: &String| {
        let limb = creature.limb(name).filter(|limb| touching.contains(limb));
        limb.ok_or_else(|| {
            Error::usage(format!("--hand {name}: no such limb with receptors: choose one of {}", choice()))
        })
    };
    let mut hands = names.iter().map(named).collect::<Result<Vec<usize>, Error>>()?;
    hands.dedup();
    Ok(hands)
}
