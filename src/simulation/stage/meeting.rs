//! Which geoms of a stage act on each other.

use std::collections::BTreeSet;

use super::carrying::Carried;
use crate::creature::Body;

/// Two geoms, the one with the lesser number first.
pub fn sorted([a, b]: [usize; 2]) -> [usize; 2] {
    [a.min(b), a.max(b)]
}

/// Whether two geoms act on each other: not where they always overlap, nor a limb and one that carries it, nor what is
/// held and the limbs about it.
pub fn meets(
    body: &Body,
    overlapping: &BTreeSet<[usize; 2]>,
    carried: &[Carried],
    geoms: [usize; 2],
) -> bool {
    if overlapping.contains(&sorted(geoms)) {
        return false;
    }
    match geoms.map(|geom| body.limb_of_geom(geom)) {
        [Some(a), Some(b)] => !body.creature.neighbouring(a, b),
        [Some(limb), None] | [None, Some(limb)] => {
            let bodies = geoms.map(|geom| body.model.geom_body(geom));
            let holds = |carried: &Carried| {
                let near = |grip: &super::carrying::Grip| body.creature.neighbouring(grip.limb, limb);
                bodies.contains(&carried.body) && carried.grip().is_some_and(near)
            };
            !carried.iter().any(holds)
        }
        [None, None] => true,
    }
}
