//! A script of stimuli: probes and their paths.

use std::path::Path;

use nalgebra::Vector3;
use serde::Deserialize;

use crate::error::Error;
use crate::given_file;
use crate::simulation::{PROBE_RADIUS, ProbePath, Stage};

/// Where a probe's tip or middle is to be at a time.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Waypoint {
    /// Seconds from the beginning.
    time: f64,
    /// The probe's middle in the world's frame, metres; or …
    at: Option<[f64; 3]>,
    /// … a receptor, by its id, with the probe's surface …
    receptor: Option<String>,
    /// … so far above it, metres: below 0 the probe presses, with 400 N for each metre.
    #[serde(default)]
    height: f64,
}

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct ScriptedProbe {
    name: String,
    path: Vec<Waypoint>,
}

/// The script of touches (JSON).
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Script {
    probes: Vec<ScriptedProbe>,
}

impl Script {
    /// Reads a script.
    ///
    /// # Errors
    /// If it cannot be read, or is no script.
    pub fn read(path: &Path) -> Result<Script, Error> {
        let unreadable = |sentence: String| Error::content(path, None, sentence);
        let text = given_file::read_text(path)
            .map_err(|error| unreadable(format!("it cannot be read ({error})")))?;
        let script: Script =
            serde_json::from_str(&text).map_err(|error| unreadable(format!("{error}: correct it there")))?;
        match script.fault() {
            Some(fault) => Err(unreadable(fault)),
            None => Ok(script),
        }
    }

    /// What cannot be done of it.
    fn fault(&self) -> Option<String> {
        if self.probes.is_empty() {
            return Some("it has no probes: give at least one".into());
        }
        for (k, ScriptedProbe { name, path }) in self.probes.iter().enumerate() {
            if name.is_empty() || self.probes[..k].iter().any(|other| other.name == *name) {
                return Some(format!(
                    "two probes are called \"{name}\", or one has no name: give each its own"
                ));
            }
            if path.is_empty() {
                return Some(format!("the probe \"{name}\" has no path: give at least one waypoint"));
            }
            for (j, waypoint) in path.iter().enumerate() {
                let numbers = waypoint.at.iter().flatten().chain([&waypoint.time, &waypoint.height]);
                let fault = if waypoint.at.is_some() == waypoint.receptor.is_some() {
                    "needs either \"at\" or \"receptor\": give one of them"
                } else if waypoint.time < 0.0 || { numbers }.any(|x| !x.is_finite() || x.abs() > 1e4) {
                    "has an impossible number: give times from 0, and metres"
                } else if j > 0 && waypoint.time <= path[j - 1].time {
                    "is not later than the one before it: order them by time"
                } else {
                    continue;
                };
                return Some(format!("waypoint {} of \"{name}\" {fault}", j + 1));
            }
        }
        None
    }

    /// The names of its probes.
    pub fn probes(&self) -> Vec<String> {
        self.probes.iter().map(|probe| probe.name.clone()).collect()
    }

    /// The ways of its probes about a creature, in the order of [`Script::probes`].
    ///
    /// # Errors
    /// If it names a receptor that the creature does not have.
    pub fn paths(&self, stage: &Stage) -> Result<Vec<ProbePath>, Error> {
        let place = |probe: &ScriptedProbe, waypoint: &Waypoint| match (&waypoint.at, &waypoint.receptor) {
            (Some(at), _) => Ok::<_, Error>(Vector3::from(*at)),
            (None, Some(id)) => {
                let found = stage.skin().receptor(id).map(|receptor| &stage.skin().receptors[receptor]);
                let receptor = found.ok_or_else(|| {
                    let (probe, creature) = (&probe.name, stage.agent().creature().name());
                    Error::usage(format!(
                        "\"{probe}\" goes to receptor \"{id}\", which {creature} does not have"
                    ))
                })?;
                let pose = stage.limb_pose(receptor.limb);
                let above = receptor.position + receptor.normal * (waypoint.height + PROBE_RADIUS);
                Ok((pose * nalgebra::Point3::from(above)).coords)
            }
            (None, None) => unreachable!("a script is checked when it is read"),
        };
        let path = |probe: &ScriptedProbe| {
            let way = probe.path.iter().map(|waypoint| Ok((waypoint.time, place(probe, waypoint)?)));
            way.collect::<Result<Vec<_>, Error>>().map(ProbePath)
        };
        self.probes.iter().map(path).collect()
    }
}
