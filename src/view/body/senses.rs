//! What of a body's senses is drawn over it: the aura about its limbs, and which receptors are neighbours.

use serde_json::{Value, json};

use super::{on_limb, point, whole};
use crate::agent::Agent;
use crate::kinematics::limb_frames;
use crate::schema::BodySchema;
use crate::skin::{ProximityGeometry, SomatotopicMap, grow_aura};

/// What the auras and the map are called where they are switched on; both are hidden at first.
pub(in crate::view) const AURAS: &str = "auras";
pub(in crate::view) const MAP: &str = "neighbouring receptors";

/// The auras that a schema gives, but about limbs beyond joints that are not determined, the `open` ones: per aura its limb, both
/// ends of its segment in that limb's frame, and its radius.
pub(super) fn auras(agent: &Agent, schema: &BodySchema, open: &[usize], poses: &str) -> Value {
    let creature = agent.creature();
    let mut unknown = vec![false; creature.limbs().len()];
    for (j, joint) in creature.joints().iter().enumerate() {
        unknown[j + 1] = unknown[joint.parent] || open.contains(&j);
    }
    let frames = limb_frames(creature, schema, &creature.reference_posture());
    let capsule = |aura: ProximityGeometry| {
        let limbs = &creature.aura_limbs()[aura.aura_limb].limbs;
        let [a, b] = aura.capsule.ends.map(|end| point(&end));
        let numbers = [&[aura.limb as i64][..], &a, &b, &[whole(aura.capsule.radius)]].concat();
        limbs.iter().all(|&limb| !unknown[limb]).then_some(numbers)
    };
    let capsules: Vec<_> =
        grow_aura(creature, agent.skin(), &frames).into_iter().filter_map(capsule).collect();
    json!({ "name": AURAS, "poses": poses, "capsules": capsules })
}

/// The somatotopic map of an agent's skin on limbs placed by a schema: per receptor its limb and its middle in that limb's frame,
/// and pairs of receptors.
pub(super) fn map(agent: &Agent, schema: &BodySchema, poses: &str) -> Value {
    let (creature, skin) = (agent.creature(), agent.skin());
    let frames = limb_frames(creature, schema, &creature.reference_posture());
    let links: Vec<_> = SomatotopicMap::new(creature, skin, &frames).pairs().collect();
    let points = skin.receptors.iter().map(|receptor| on_limb(receptor.limb, &receptor.position));
    json!({ "name": MAP, "poses": poses, "points": points.collect::<Vec<_>>(), "links": links })
}
