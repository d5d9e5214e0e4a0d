//! Which limbs' skins may meet.

use super::Skin;
use crate::creature::Creature;

/// Limbs whose skins may meet: those that a joint connects, or several where what is in between has no receptors.
#[derive(Clone, Debug)]
pub(crate) struct JoinedLimbs {
    joined: Vec<Vec<bool>>,
}

impl JoinedLimbs {
    /// Looks at a creature's tree and at which of its limbs have receptors.
    pub fn new(creature: &Creature, skin: &Skin) -> JoinedLimbs {
        let count = creature.limbs().len();
        let mut has_skin = vec![false; count];
        skin.receptors.iter().for_each(|receptor| has_skin[receptor.limb] = true);
        let carried = |limb: usize| (0..count).filter(move |&other| creature.parent_of(other) == Some(limb));
        let mut joined = vec![vec![false; count]; count];
        for (from, joined) in joined.iter_mut().enumerate() {
            let mut open = vec![from];
            while let Some(limb) = open.pop() {
                if std::mem::replace(&mut joined[limb], true) || (limb != from && has_skin[limb]) {
                    continue;
                }
                open.extend(creature.parent_of(limb).into_iter().chain(carried(limb)));
            }
        }
        JoinedLimbs { joined }
    }

    /// Whether two limbs' skins may meet; those of one limb do.
    pub fn are(&self, a: usize, b: usize) -> bool {
        self.joined[a][b]
    }

    /// The limbs whose skins may meet that of a limb, itself among them.
    pub fn of(&self, limb: usize) -> impl Iterator<Item = usize> {
        (0..self.joined.len()).filter(move |&other| self.joined[limb][other])
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::Vector3;

    use super::*;
    use crate::creature::Joint;
    use crate::skin::Receptor;

    #[test]
    fn skins_may_meet_over_limbs_without_receptors_and_not_over_those_with_some() {
        // A row of five limbs, of which the middle one and its neighbour have no skin.
        let limbs: Vec<String> = (0..5).map(|limb| format!("limb{limb}")).collect();
        let joints = (0..4).map(|parent| Joint::new(format!("joint{parent}"), parent, Vec::new())).collect();
        let creature = Creature::new("row".into(), limbs, joints, Vec::new()).expect("it is a creature");
        let receptor = |limb: usize| Receptor {
            id: format!("r{limb}"),
            limb,
            position: Vector3::zeros(),
            normal: Vector3::z(),
            tangent: Vector3::x(),
            half_extents: [0.01; 2],
            surface: None,
        };
        let skin = Skin { receptors: [0, 1, 4].map(receptor).into(), surfaces: Vec::new() };
        let joined = JoinedLimbs::new(&creature, &skin);
        assert!(joined.are(0, 1) && joined.are(1, 4) && joined.are(4, 1) && joined.are(3, 3));
        assert!(!joined.are(0, 4) && !joined.are(4, 0));
        assert_eq!(joined.of(1).collect::<Vec<_>>(), [0, 1, 2, 3, 4]);
    }
}
