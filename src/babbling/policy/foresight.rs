//! Predicting from a schema what a motion will touch first.

use std::collections::BTreeSet;

use crate::agent::Agent;
use crate::creature::Posture;
use crate::kinematics::limb_frames;
use crate::peripersonal::LimbPieces;
use crate::schema::BodySchema;

/// Postures on the way that are looked at: a finger is thinner than an arm's way from one to the next, but what is
/// overlooked now and then costs a motion, and no more.
const LOOKS: usize = 24;
/// The share of the way after which it is seen whether limbs that touch part.
const FIRST_LOOK: f64 = 0.01;
/// Limbs that are no farther from each other touch, metres; and how much deeper they are where they do not part.
const TOUCHING: f64 = 5e-4;
const DEEPER: f64 = 1e-6;

/// Limbs that were deeper in each other do not feel each other, metres: what is believed of where they are is never as
/// far off.
const PASSING: f64 = 2e-3;

/// What a motion leads to.
#[derive(Clone, Debug, PartialEq)]
pub enum Foreseen {
    /// These limbs meet first, about in this posture.
    Meeting([usize; 2], Posture),
    /// Nothing meets.
    Nothing,
    /// Limbs that touch at the beginning would go into each other.
    Stuck,
}

/// Foresees what a straight motion touches first.
pub struct Foresight {
    agent: Agent,
    pieces: LimbPieces,
    /// Pairs of limbs that were in each other and did not feel it.
    passing: BTreeSet<[usize; 2]>,
}

impl Foresight {
    /// Of an agent's own surfaces.
    pub fn new(agent: &Agent) -> Foresight {
        Foresight { agent: agent.clone(), pieces: LimbPieces::new(agent), passing: BTreeSet::new() }
    }

    /// Takes in a posture that the body was in: limbs that count and are in each other there do not feel each other.
    pub fn pass(&mut self, schema: &BodySchema, posture: &[f64], counts: impl Fn(usize) -> bool) {
        let frames = limb_frames(self.agent.creature(), schema, posture);
        let mut passing = self.pairs(counts);
        passing.retain(|&pair| self.pieces.gap(&frames, pair, -PASSING) < -PASSING);
        self.passing.extend(passing);
    }

    /// What the straight way from one posture to another leads to. Limbs that do not count are overlooked, as are pairs
    /// that touch at the beginning and part.
    pub fn foresee(
        &self,
        schema: &BodySchema,
        [from, to]: [&[f64]; 2],
        counts: impl Fn(usize) -> bool,
    ) -> Foreseen {
        let creature = self.agent.creature();
        // Per limb, the last joint before it that moves, counted from 1; 0 on what rests. Limbs with the same one do not move to
        // each other.
        let mut carried_by = vec![0; creature.limbs().len()];
        for (number, joint) in creature.joints().iter().enumerate() {
            let moves = joint.elements().any(|at| at.of(from) != at.of(to));
            carried_by[number + 1] = if moves { number + 1 } else { carried_by[joint.parent] };
        }
        let frames = limb_frames(creature, schema, from);
        let moving = self.pairs(counts).into_iter().filter(|&[a, b]| carried_by[a] != carried_by[b]);
        let gaps = moving.map(|pair| (pair, self.pieces.gap(&frames, pair, TOUCHING)));
        // What is deep in each other at the beginning does not feel each other.
        let (apart, touching): (Vec<_>, Vec<_>) =
            gaps.filter(|(_, gap)| *gap >= -TOUCHING).partition(|(_, gap)| *gap >= TOUCHING);
        let after = |share: f64| Posture::between(creature, from, to, share);
        let frames = limb_frames(creature, schema, &after(FIRST_LOOK));
        if touching.iter().any(|&(pair, before)| self.pieces.gap(&frames, pair, TOUCHING) < before - DEEPER) {
            return Foreseen::Stuck;
        }
        for look in 1..=LOOKS {
            let posture = after(look as f64 / LOOKS as f64);
            let frames = limb_frames(creature, schema, &posture);
            if let Some((pair, _)) =
                apart.iter().find(|(pair, _)| self.pieces.gap(&frames, *pair, 0.0) <= 0.0)
            {
                return Foreseen::Meeting(*pair, posture);
            }
        }
        Foreseen::Nothing
    }

    /// The pairs of limbs that count, have solid surfaces, and may feel each other.
    fn pairs(&self, counts: impl Fn(usize) -> bool) -> Vec<[usize; 2]> {
        let limbs: Vec<usize> = (0..self.agent.creature().limbs().len())
            .filter(|&limb| self.pieces.has(limb) && counts(limb))
            .collect();
        let all = limbs.iter().enumerate().flat_map(|(n, &a)| limbs[n + 1..].iter().map(move |&b| [a, b]));
        let feels = |&[a, b]: &[usize; 2]| !self.agent.creature().neighbouring(a, b);
        all.filter(feels).filter(|pair| !self.passing.contains(pair)).collect()
    }
}
