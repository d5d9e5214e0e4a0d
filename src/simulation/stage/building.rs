//! Setting up a stage.

use std::path::Path;
use std::sync::Arc;

use nalgebra::Vector3;

use super::StageOptions;
use super::core::StageCore;
use super::stillness::Stillness;
use crate::agent::Agent;
use crate::creature::{Body, JointSelection, Posture};
use crate::error::{Error, Result};
use crate::mujoco::{Data, LONGEST_STEP, Model};
use crate::senses::{ContactReader, SENSES, SensingBody};
use crate::simulation::probe::{self, Probe};
use crate::simulation::{ProbePath, SelfContact, sorted, thing};
use crate::skin::{GrowOptions, grow};

/// Where probes wait, metres along the world's x axis.
const AWAY: f64 = 100.0;

/// Where a probe waits.
pub fn away(probe: usize) -> Vector3<f64> {
    Vector3::new(AWAY + probe as f64, 0.0, 0.0)
}

/// See [`super::Stage::new`].
pub fn build(path: &Path, options: &StageOptions) -> Result<StageCore, Error> {
    let StageOptions { joints, root, things, probes, senses: others } = options;
    // Which of the model's trees is the creature must not depend on what touches it.
    let root = match root {
        None if !probes.is_empty() => root_of(path)?,
        root => root.clone(),
    };
    let added =
        things.iter().flat_map(thing::described).chain(probes.iter().map(|name| probe::described(name)));
    let declared = Arc::new(Model::with_bodies(path, added.collect())?);
    let mut body = Body::rooted(declared.clone(), joints, root.as_deref())?;
    let agent = Agent::new(body.creature.clone(), grow(&body, &GrowOptions::default())?)?;
    let solid = |g: usize| {
        let geom = declared.geom(g);
        body.limb_of_geom(g).is_none() && (geom.contype | geom.conaffinity) != 0
    };
    let touchable: Vec<bool> = (0..declared.ngeom()).map(|g| body.feels(g) || solid(g)).collect();
    let own_geom: Vec<bool> = (0..declared.ngeom()).map(|g| body.limb_of_geom(g).is_some()).collect();
    let (mut own_qpos, mut own_dof) = (vec![false; declared.nq()], vec![false; declared.nv()]);
    for joint in declared.joints().filter(|joint| body.limb_of_body[joint.body].is_some()) {
        own_qpos[joint.qposadr..joint.qposadr + joint.kind.nq()].fill(true);
        own_dof[joint.dofadr..joint.dofadr + joint.kind.nv()].fill(true);
    }
    let mut overlapping = SelfContact::new(&body)?.left_out;
    let step = declared.timestep().min(LONGEST_STEP);
    let mut simulated = declared.simulated(step, &own_dof, true)?;
    // Who says how a thing's friction is wants it borne by that; it makes contacts dearer.
    if things.iter().any(|thing| thing.substance.friction.is_some()) {
        simulated = simulated.without_creep();
    }
    body.model = Arc::new(simulated.touching_with(&touchable)?);
    let reader = ContactReader::new(&body, agent.skin());
    let posture = Posture::start(&body.creature);

    // What is in each other where the creature is in the rest posture is so for good.
    let mut with_self_touch = Data::new(body.model.clone())?;
    let mut qpos = declared.qpos0().to_vec();
    let own = body.qpos(&posture);
    qpos.iter_mut().zip(&own).zip(&own_qpos).filter(|(_, own)| **own).for_each(|((q, own), _)| *q = *own);
    let mut qvel = vec![0.0; declared.nv()];
    let mut waiting = Vec::new();
    for (k, mut probe) in probes.iter().filter_map(|name| Probe::of(&body.model, name)).enumerate() {
        probe.put(&away(k), &mut qpos, &mut qvel);
        probe.path = ProbePath(vec![(0.0, away(k))]);
        waiting.push(probe);
    }
    with_self_touch.set_qpos(&qpos)?;
    with_self_touch.forward()?;
    let at_ease = with_self_touch.contacts().map(|contact| sorted(contact.geoms));
    overlapping.extend(at_ease.filter(|geoms| geoms.iter().any(|&geom| own_geom[geom])));
    // While the creature holds the posture that it came with, contacts of its own are not even looked for.
    let mut data = Data::new(Arc::new(simulated.touching_others(&touchable, &own_geom)?))?;
    data.set_qpos(&qpos)?;
    data.forward()?;
    let own = SensingBody { agent: &agent, body: &body, frames: &body.limb_frames(&data) };
    let senses = SENSES.iter().chain(others).map(|new| new(&own)).collect::<Result<_>>()?;
    let mut core = StageCore {
        body: Arc::new(body),
        agent,
        reader,
        data,
        untouched: simulated,
        touchable,
        with_self_touch: Some(with_self_touch),
        own_qpos,
        own_dof,
        overlapping,
        probes: waiting,
        carried: Vec::new(),
        stillness: Stillness::new(declared.nq()),
        posture,
        time: 0.0,
        senses,
    };
    core.feel_placed()?;
    Ok(core)
}

/// The name of the first body of the creature of a file.
fn root_of(path: &Path) -> Result<Option<String>, Error> {
    let alone = Body::new(Arc::new(Model::read(path)?.0), &JointSelection::All)?;
    Ok(alone.root_name().map(str::to_string))
}
