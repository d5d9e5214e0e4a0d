//! Probes: balls like fingertips that springs hold to their paths, and that press on what they meet.

use nalgebra::Vector3;

use super::thing::touching_geom;
use crate::model_files::{Element, element, exact};
use crate::mujoco::Model;

/// The radius of a probe, metres.
pub const PROBE_RADIUS: f64 = 0.008;
/// Its mass, kilogrammes.
const MASS: f64 = 0.05;
/// How stiffly it is held to its path, newtons a metre: as deep as its path goes under the skin, so hard it presses.
pub const STIFFNESS: f64 = 400.0;
/// Damping ratio of that.
const DAMPING_RATIO: f64 = 1.0;
/// How long after the end of its path a probe may still swing, seconds.
const SWINGS: f64 = 0.5;

/// Where something's middle is to be, at which time: seconds and metres in the world's frame, in order of time. In
/// between it goes straight; before and after it stays.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ProbePath(pub Vec<(f64, Vector3<f64>)>);

impl ProbePath {
    /// Where the middle is to be at a time.
    pub fn at(&self, time: f64) -> Option<Vector3<f64>> {
        let next = self.0.partition_point(|(t, _)| *t <= time);
        let before = next.checked_sub(1).map(|k| self.0[k]);
        match (before, self.0.get(next)) {
            (Some((t0, p0)), Some((t1, p1))) => Some(p0 + (p1 - p0) * ((time - t0) / (t1 - t0))),
            (Some((_, p)), None) | (None, Some(&(_, p))) => Some(p),
            (None, None) => None,
        }
    }

    /// When it ends, seconds.
    pub fn end(&self) -> f64 {
        self.0.last().map_or(0.0, |(t, _)| *t)
    }
}

/// A probe in the model: a ball on three slides.
pub(super) struct Probe {
    /// Where its first coordinate is in `qpos`, and its first velocity in `qvel`.
    pub qposadr: usize,
    pub dofadr: usize,
    /// Where it is to be.
    pub path: ProbePath,
}

impl Probe {
    /// The probe called `name` in a model.
    pub fn of(model: &Model, name: &str) -> Option<Probe> {
        let body = (0..model.nbody()).find(|&body| model.body(body).name == Some(name))?;
        let first = model.joints().find(|joint| joint.body == body)?;
        Some(Probe { qposadr: first.qposadr, dofadr: first.dofadr, path: ProbePath::default() })
    }

    /// Whether it is still at rest where its path has ended.
    pub fn rests(&self, time: f64) -> bool {
        time > self.path.end() + SWINGS
    }

    /// Adds the pull towards its path at a time to the forces on all degrees of freedom.
    pub fn pull(&self, time: f64, qpos: &[f64], qvel: &[f64], forces: &mut [f64]) {
        let Some(target) = self.path.at(time) else { return };
        let damping = 2.0 * DAMPING_RATIO * (STIFFNESS * MASS).sqrt();
        for k in 0..3 {
            let miss = target[k] - qpos[self.qposadr + k];
            // The spring leads the way: damping is against the path's own speed.
            let ahead = self.path.at(time + 1e-3).map_or(0.0, |next| (next[k] - target[k]) / 1e-3);
            let slower = ahead - qvel[self.dofadr + k];
            forces[self.dofadr + k] += STIFFNESS * miss + damping * slower;
        }
    }

    /// Where its middle is put, at rest.
    pub fn put(&self, at: &Vector3<f64>, qpos: &mut [f64], qvel: &mut [f64]) {
        qpos[self.qposadr..self.qposadr + 3].copy_from_slice(at.as_slice());
        qvel[self.dofadr..self.dofadr + 3].fill(0.0);
    }
}

/// A probe's body as MJCF: a smooth ball on three slides whose coordinates are its place in the world.
pub(super) fn described(name: &str) -> Element {
    let mut body = element("body", &[("name", name.into()), ("pos", "0 0 0".into())]);
    let inertia = 0.4 * MASS * PROBE_RADIUS * PROBE_RADIUS;
    let inertial = [
        ("pos", "0 0 0".into()),
        ("mass", exact(&[MASS])),
        ("diaginertia", exact(&[inertia, inertia, inertia])),
    ];
    body.children.push(element("inertial", &inertial));
    for (k, axis) in ["1 0 0", "0 1 0", "0 0 1"].into_iter().enumerate() {
        let slide = [("type", "slide".into()), ("pos", "0 0 0".into()), ("axis", axis.into())];
        let mut joint = element("joint", &slide);
        joint.set("name", format!("{name}_{k}"));
        joint.set("limited", "false");
        // Whatever the file has joints be by default.
        ["damping", "stiffness", "armature", "frictionloss"].iter().for_each(|key| joint.set(key, "0"));
        body.children.push(joint);
    }
    let mut geom = touching_geom(name, "3", [0.2, 0.001, 0.0001]);
    geom.set("type", "sphere");
    geom.set("size", exact(&[PROBE_RADIUS]));
    // Where the file has inertia taken from geoms, and where not: the same.
    geom.set("mass", exact(&[MASS]));
    body.children.push(geom);
    body
}
