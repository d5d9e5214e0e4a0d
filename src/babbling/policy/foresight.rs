//! What a motion will touch first, as far as a schema tells.

use std::collections::BTreeSet;

use crate::agent::Agent;
use crate::creature::Posture;
use crate::geometry::{Ball, Frame, Precision, gap};
use crate::kinematics::limb_frames;
use crate::schema::BodySchema;

/// Postures on the way that are looked at: a finger is thinner than an arm's way from one to the next, but what is
/// overlooked now and then costs a motion, and no more.
const LOOKS: usize = 24;
/// The share of the way after which it is seen whether limbs that touch part.
pub(super) const FIRST_LOOK: f64 = 0.01;
/// Limbs that are no farther from each other touch, metres; and how much deeper they are where they do not part.
const TOUCHING: f64 = 5e-4;
const DEEPER: f64 = 1e-6;

/// Limbs that were deeper in each other do not feel each other, metres: what is believed of where they are is never as
/// far off.
const PASSING: f64 = 2e-3;

/// What a motion leads to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Foreseen {
    /// These limbs meet first.
    Meeting([usize; 2]),
    /// Nothing meets.
    Nothing,
    /// Limbs that touch at the beginning would go into each other.
    Stuck,
}

/// Foresees what a straight motion touches first.
pub struct Foresight {
    agent: Agent,
    /// Per limb, its solid surfaces, and a ball about them.
    surfaces: Vec<Vec<usize>>,
    balls: Vec<Option<Ball>>,
    /// Pairs of limbs that were in each other and did not feel it.
    passing: BTreeSet<[usize; 2]>,
}

impl Foresight {
    /// Of an agent's own surfaces.
    pub fn new(agent: &Agent) -> Foresight {
        let mut surfaces = vec![Vec::new(); agent.creature().limbs().len()];
        let solid = agent.skin().surfaces.iter().enumerate().filter(|(_, surface)| surface.shape.is_solid());
        solid.for_each(|(number, surface)| surfaces[surface.limb].push(number));
        let about = |numbers: &Vec<usize>| {
            let surfaces = numbers.iter().map(|&number| &agent.skin().surfaces[number]);
            let balls = surfaces
                .map(|s| Ball { centre: s.origin, radius: s.shape.bounding_radius() })
                .collect::<Vec<_>>();
            Ball::about(&balls)
        };
        let balls = surfaces.iter().map(about).collect();
        Foresight { agent: agent.clone(), surfaces, balls, passing: BTreeSet::new() }
    }

    /// Takes in a posture that the body was in: limbs that count and are in each other there do not feel each other.
    pub fn pass(&mut self, schema: &BodySchema, posture: &[f64], counts: impl Fn(usize) -> bool) {
        let frames = limb_frames(self.agent.creature(), schema, posture);
        let mut passing = self.pairs(counts);
        passing.retain(|&pair| self.gap(&frames, pair, -PASSING) < -PASSING);
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
        let gaps = moving.map(|pair| (pair, self.gap(&frames, pair, TOUCHING)));
        // What is deep in each other at the beginning does not feel each other.
        let (apart, touching): (Vec<_>, Vec<_>) =
            gaps.filter(|(_, gap)| *gap >= -TOUCHING).partition(|(_, gap)| *gap >= TOUCHING);
        let after = |share: f64| limb_frames(creature, schema, &Posture::between(creature, from, to, share));
        let frames = after(FIRST_LOOK);
        if touching.iter().any(|&(pair, before)| self.gap(&frames, pair, TOUCHING) < before - DEEPER) {
            return Foreseen::Stuck;
        }
        for look in 1..=LOOKS {
            let frames = after(look as f64 / LOOKS as f64);
            if let Some((pair, _)) = apart.iter().find(|(pair, _)| self.gap(&frames, *pair, 0.0) <= 0.0) {
                return Foreseen::Meeting(*pair);
            }
        }
        Foreseen::Nothing
    }

    /// The pairs of limbs that count, have solid surfaces, and may feel each other.
    fn pairs(&self, counts: impl Fn(usize) -> bool) -> Vec<[usize; 2]> {
        let limbs: Vec<usize> =
            (0..self.balls.len()).filter(|&limb| self.balls[limb].is_some() && counts(limb)).collect();
        let all = limbs.iter().enumerate().flat_map(|(n, &a)| limbs[n + 1..].iter().map(move |&b| [a, b]));
        let feels = |&[a, b]: &[usize; 2]| !self.agent.creature().neighbouring(a, b);
        all.filter(feels).filter(|pair| !self.passing.contains(pair)).collect()
    }

    /// The gap of two limbs where it is below a limit, metres; no less than that elsewhere.
    fn gap(&self, frames: &[Frame], [a, b]: [usize; 2], below: f64) -> f64 {
        let (Some(p), Some(q)) = (&self.balls[a], &self.balls[b]) else { return f64::INFINITY };
        let apart = p.gap_at(&frames[a].point(&p.centre), q, &frames[b].point(&q.centre));
        if apart > below {
            return apart;
        }
        let of = |limb: usize| {
            self.surfaces[limb].iter().filter_map(move |&number| {
                let surface = &self.agent.skin().surfaces[number];
                let centre = frames[limb].point(&surface.origin);
                let ball = Ball { centre, radius: surface.shape.bounding_radius() };
                Some((ball, surface.placed(&frames[limb])?))
            })
        };
        let pieces = of(a).flat_map(|first| of(b).map(move |second| (first, second)));
        let gaps = pieces.map(|((ball, first), (other, second))| {
            match ball.gap_at(&ball.centre, &other, &other.centre) {
                apart if apart > below => apart,
                _ => gap(&first, &second, Precision::Exact).distance,
            }
        });
        gaps.fold(f64::INFINITY, f64::min)
    }
}
