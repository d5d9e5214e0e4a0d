//! What a motion will touch first, as far as a schema tells.

use crate::agent::Agent;
use crate::creature::Posture;
use crate::geometry::{Ball, Frame, Precision, gap};
use crate::kinematics::{limb_frames, limb_frames_into};
use crate::schema::BodySchema;

/// Postures on the way that are looked at: a finger is thinner than an arm's way from one to the next, but what is
/// overlooked now and then costs a motion, and no more.
const LOOKS: usize = 24;

/// Foresees what a straight motion touches first.
pub struct Foresight<'a> {
    agent: &'a Agent,
    /// Per limb, its solid surfaces, and a ball about them.
    surfaces: Vec<Vec<usize>>,
    balls: Vec<Option<Ball>>,
}

impl<'a> Foresight<'a> {
    /// Of an agent's own surfaces.
    pub fn new(agent: &'a Agent) -> Foresight<'a> {
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
        Foresight { agent, surfaces, balls }
    }

    /// The two limbs that are the first to meet on the straight way from one posture to another; none where none do.
    /// Limbs that do not count are overlooked, and pairs that meet at the beginning.
    pub fn first_meeting(
        &self,
        schema: &BodySchema,
        [from, to]: [&[f64]; 2],
        counts: impl Fn(usize) -> bool,
    ) -> Option<[usize; 2]> {
        let creature = self.agent.creature();
        // Limbs with the same joint that moves before them do not move to each other.
        let mut carried_by = vec![0; creature.limbs().len()];
        for (number, joint) in creature.joints().iter().enumerate() {
            let moves = joint.elements().any(|at| at.of(from) != at.of(to));
            carried_by[number + 1] = if moves { number + 1 } else { carried_by[joint.parent] };
        }
        let limbs: Vec<usize> =
            (0..carried_by.len()).filter(|&limb| self.balls[limb].is_some() && counts(limb)).collect();
        let mut frames = limb_frames(creature, schema, from);
        let mut pairs = Vec::new();
        for (number, &a) in limbs.iter().enumerate() {
            for &b in &limbs[number + 1..] {
                let apart = carried_by[a] != carried_by[b] && !creature.neighbouring(a, b);
                if apart && !self.meet(&frames, [a, b]) {
                    pairs.push([a, b]);
                }
            }
        }
        (1..=LOOKS).find_map(|look| {
            let posture = Posture::between(creature, from, to, look as f64 / LOOKS as f64);
            limb_frames_into(creature, schema, &posture, &mut frames);
            pairs.iter().copied().find(|&pair| self.meet(&frames, pair))
        })
    }

    fn meet(&self, frames: &[Frame], [a, b]: [usize; 2]) -> bool {
        let (Some(p), Some(q)) = (&self.balls[a], &self.balls[b]) else { return false };
        if p.gap_at(&frames[a].point(&p.centre), q, &frames[b].point(&q.centre)) > 0.0 {
            return false;
        }
        let of = |limb: usize| {
            self.surfaces[limb].iter().filter_map(move |&number| {
                let surface = &self.agent.skin().surfaces[number];
                let ball = Ball {
                    centre: frames[limb].point(&surface.origin),
                    radius: surface.shape.bounding_radius(),
                };
                Some((ball, surface.placed(&frames[limb])?))
            })
        };
        of(a).any(|(ball, first)| {
            of(b).any(|(other, second)| {
                ball.gap_at(&ball.centre, &other, &other.centre) <= 0.0
                    && gap(&first, &second, Precision::LowerBound).distance <= 0.0
            })
        })
    }
}
