//! A script of what is done to the creature: probes and the ways they take.

use std::path::Path;

use nalgebra::Vector3;
use serde::Deserialize;

use super::world::{PROBE_RADIUS, ProbePath, World};

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

/// What is done to the creature.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Script {
    probes: Vec<ScriptedProbe>,
}

impl Script {
    /// Reads a script.
    ///
    /// # Errors
    /// A sentence that names the file, the place and the mend.
    pub fn read(path: &Path) -> Result<Script, String> {
        let at = path.display();
        let text =
            std::fs::read_to_string(path).map_err(|error| format!("{at}: it cannot be read ({error})"))?;
        let script: Script =
            serde_json::from_str(&text).map_err(|error| format!("{at}: {error}: correct it there"))?;
        for (k, probe) in script.probes.iter().enumerate() {
            let name = &probe.name;
            if name.is_empty() || script.probes[..k].iter().any(|other| other.name == *name) {
                return Err(format!(
                    "{at}: two probes are called \"{name}\", or one has no name: give each its own"
                ));
            }
            if probe.path.is_empty() {
                return Err(format!("{at}: the probe \"{name}\" has no path: give it one waypoint at least"));
            }
            for (j, waypoint) in probe.path.iter().enumerate() {
                let place = format!("{at}: waypoint {} of \"{name}\"", j + 1);
                if waypoint.at.is_some() == waypoint.receptor.is_some() {
                    return Err(format!("{place} needs either \"at\" or \"receptor\": give one of them"));
                }
                let numbers = waypoint.at.iter().flatten().chain([&waypoint.time, &waypoint.height]);
                if waypoint.time < 0.0 || numbers.clone().any(|x| !x.is_finite() || x.abs() > 1e4) {
                    return Err(format!(
                        "{place} has a number that cannot be: give times from 0 on, and metres"
                    ));
                }
                if j > 0 && waypoint.time <= probe.path[j - 1].time {
                    return Err(format!(
                        "{place} is not later than the one before it: put them in order of time"
                    ));
                }
            }
        }
        Ok(script)
    }

    /// The names of its probes.
    pub fn probes(&self) -> Vec<String> {
        self.probes.iter().map(|probe| probe.name.clone()).collect()
    }

    /// The ways of its probes about a creature, in the order of [`Script::probes`].
    ///
    /// # Errors
    /// A clause that names a receptor that the creature has not.
    pub fn paths(&self, world: &World) -> Result<Vec<ProbePath>, String> {
        let place = |probe: &ScriptedProbe, waypoint: &Waypoint| match (&waypoint.at, &waypoint.receptor) {
            (Some(at), _) => Ok::<_, String>(Vector3::from(*at)),
            (None, Some(id)) => {
                let found = world.skin.receptor(id).map(|receptor| &world.skin.receptors[receptor]);
                let receptor = found.ok_or_else(|| {
                    format!(
                        "\"{}\" goes to the receptor \"{id}\", which {} has not",
                        probe.name,
                        world.body.creature.name()
                    )
                })?;
                let pose = world.body.limb_pose(&world.data, receptor.limb).unwrap_or_default();
                let above = receptor.position + receptor.normal * (waypoint.height + PROBE_RADIUS);
                Ok((pose * nalgebra::Point3::from(above)).coords)
            }
            (None, None) => unreachable!("a script is checked when it is read"),
        };
        let path = |probe: &ScriptedProbe| {
            let way = probe.path.iter().map(|waypoint| Ok((waypoint.time, place(probe, waypoint)?)));
            way.collect::<Result<Vec<_>, String>>().map(ProbePath)
        };
        self.probes.iter().map(path).collect()
    }
}
