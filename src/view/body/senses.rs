//! What of a body's senses is drawn over it: the aura about its limbs, and which receptors are neighbours.

use serde::Serialize;

use super::whole;
use crate::agent::Agent;
use crate::kinematics::limb_frames;
use crate::schema::BodySchema;
use crate::skin::{ProximityGeometry, Receptor, SomatotopicMap, grow_aura};

/// What the auras and the map are called where they are switched on; both are hidden at first.
pub(in crate::view) const AURAS: &str = "auras";
pub(in crate::view) const MAP: &str = "neighbouring receptors";

/// Capsules about limbs that all else is seen through.
#[derive(Clone, Debug, Serialize)]
pub(in crate::view) struct AuraOverlay {
    name: &'static str,
    poses: &'static str,
    /// Per aura its limb, both ends of its segment in that limb's frame, and its radius.
    capsules: Vec<[i64; 8]>,
}

impl AuraOverlay {
    /// Those that a schema gives, but about limbs beyond joints that are not determined, the `open` ones.
    pub fn by_schema(agent: &Agent, schema: &BodySchema, open: &[usize], poses: &'static str) -> AuraOverlay {
        let creature = agent.creature();
        let mut unknown = vec![false; creature.limbs().len()];
        for (j, joint) in creature.joints().iter().enumerate() {
            unknown[j + 1] = unknown[joint.parent] || open.contains(&j);
        }
        let frames = limb_frames(creature, schema, &creature.reference_posture());
        let capsule = |aura: ProximityGeometry| {
            let limbs = &creature.aura_limbs()[aura.aura_limb].limbs;
            let [a, b] = aura.capsule.ends.map(|end| [end.x, end.y, end.z].map(whole));
            let radius = whole(aura.capsule.radius);
            let told = [aura.limb as i64, a[0], a[1], a[2], b[0], b[1], b[2], radius];
            limbs.iter().all(|&limb| !unknown[limb]).then_some(told)
        };
        let capsules = grow_aura(creature, agent.skin(), &frames).into_iter().filter_map(capsule).collect();
        AuraOverlay { name: AURAS, poses, capsules }
    }
}

/// Lines between receptors that are neighbours.
#[derive(Clone, Debug, Serialize)]
pub(in crate::view) struct MapOverlay {
    name: &'static str,
    poses: &'static str,
    /// Per receptor its limb and its middle in that limb's frame.
    points: Vec<[i64; 4]>,
    /// Pairs of receptors.
    links: Vec<[usize; 2]>,
}

impl MapOverlay {
    /// The somatotopic map of an agent's skin on limbs placed by a schema.
    pub fn by_schema(agent: &Agent, schema: &BodySchema, poses: &'static str) -> MapOverlay {
        let (creature, skin) = (agent.creature(), agent.skin());
        let frames = limb_frames(creature, schema, &creature.reference_posture());
        let map = SomatotopicMap::new(creature, skin, &frames);
        let point = |receptor: &Receptor| {
            let [x, y, z] = [receptor.position.x, receptor.position.y, receptor.position.z].map(whole);
            [receptor.limb as i64, x, y, z]
        };
        let points = skin.receptors.iter().map(point).collect();
        MapOverlay { name: MAP, poses, points, links: map.pairs().collect() }
    }
}
