//! A session's creature in its model.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use super::embodied::ModelSource;
use super::observer::Observer;
use crate::creature::{Body, Creature, JointSelection};
use crate::error::Error;
use crate::session::{Session, SessionOptions, model_hash};

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
            "it has not the limbs and degrees of freedom of the recording: name a model that has, or leave out \
             --model",
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
            "it is not the model that was babbled on, or it has changed since: name the right one with --model",
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
