//! What a motion will touch first, as far as a schema tells.

use std::collections::BTreeSet;

use nalgebra::Vector3;

use crate::agent::Agent;
use crate::creature::{DofKind, Posture};
use crate::geometry::{Ball, Frame, Precision, gap};
use crate::kinematics::{limb_frames, limb_frames_into};
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

    /// Limbs that count and are in each other in a posture that the body was in: they do not feel each other.
    pub fn passing(
        &self,
        schema: &BodySchema,
        posture: &[f64],
        counts: impl Fn(usize) -> bool,
    ) -> Vec<[usize; 2]> {
        let frames = limb_frames(self.agent.creature(), schema, posture);
        let centres = self.centres(&frames);
        let limbs = self.solid_limbs(counts);
        let pairs = limbs.iter().enumerate().flat_map(|(n, &a)| limbs[n + 1..].iter().map(move |&b| [a, b]));
        let in_each_other = |pair: &[usize; 2]| {
            !self.passing.contains(pair) && self.gap(&frames, &centres, *pair, -PASSING) < -PASSING
        };
        pairs.filter(in_each_other).collect()
    }

    /// Takes it that pairs of limbs pass through each other.
    pub fn pass(&mut self, pairs: Vec<[usize; 2]>) {
        self.passing.extend(pairs);
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
        let limbs = self.solid_limbs(counts);
        let sweep = Sweep::new(self, schema, [from, to]);
        let mut frames = limb_frames(creature, schema, from);
        let centres = self.centres(&frames);
        let (mut pairs, mut touching) = (Vec::new(), Vec::new());
        for (number, &a) in limbs.iter().enumerate() {
            for &b in &limbs[number + 1..] {
                let passing = creature.neighbouring(a, b) || self.passing.contains(&[a, b]);
                // Limbs with the same joint that moves before them do not move to each other.
                if sweep.carried_by[a] == sweep.carried_by[b] || passing {
                    continue;
                }
                match self.gap(&frames, &centres, [a, b], TOUCHING) {
                    // What is deep in each other at the beginning does not feel each other.
                    gap if gap < -TOUCHING => {}
                    gap if gap < TOUCHING => touching.push(([a, b], gap)),
                    gap => {
                        let closes = sweep.of([a, b]);
                        // What cannot meet on this way need not be looked at.
                        if gap <= closes {
                            pairs.push(Nearing { pair: [a, b], closes, apart_until: gap / closes });
                        }
                    }
                }
            }
        }
        let posture = Posture::between(creature, from, to, FIRST_LOOK);
        limb_frames_into(creature, schema, &posture, &mut frames);
        let centres = self.centres(&frames);
        let goes_on = |&(pair, before): &([usize; 2], f64)| {
            self.gap(&frames, &centres, pair, TOUCHING) < before - DEEPER
        };
        if touching.iter().any(goes_on) {
            return Foreseen::Stuck;
        }
        for look in 1..=LOOKS {
            let share = look as f64 / LOOKS as f64;
            if pairs.iter().all(|nearing| nearing.apart_until > share) {
                continue;
            }
            let posture = Posture::between(creature, from, to, share);
            limb_frames_into(creature, schema, &posture, &mut frames);
            let centres = self.centres(&frames);
            for nearing in pairs.iter_mut().filter(|nearing| nearing.apart_until <= share) {
                let gap = self.gap(&frames, &centres, nearing.pair, 0.0);
                if gap <= 0.0 {
                    return Foreseen::Meeting(nearing.pair);
                }
                nearing.apart_until = share + gap / nearing.closes;
            }
        }
        Foreseen::Nothing
    }

    /// Limbs that count and have a solid surface.
    fn solid_limbs(&self, counts: impl Fn(usize) -> bool) -> Vec<usize> {
        (0..self.balls.len()).filter(|&limb| self.balls[limb].is_some() && counts(limb)).collect()
    }

    /// Per limb, the centre of the ball about it.
    fn centres(&self, frames: &[Frame]) -> Vec<Vector3<f64>> {
        let centre = |(ball, frame): (&Option<Ball>, &Frame)| {
            ball.as_ref().map_or(frame.origin, |ball| frame.point(&ball.centre))
        };
        self.balls.iter().zip(frames).map(centre).collect()
    }

    /// The gap of two limbs where it is below a limit, metres; no less than that elsewhere.
    fn gap(&self, frames: &[Frame], centres: &[Vector3<f64>], [a, b]: [usize; 2], below: f64) -> f64 {
        let (Some(p), Some(q)) = (&self.balls[a], &self.balls[b]) else { return f64::INFINITY };
        let apart = p.gap_at(&centres[a], q, &centres[b]);
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

/// Two limbs that may meet on a way.
struct Nearing {
    pair: [usize; 2],
    /// How much of their gap the whole way closes at the most, metres.
    closes: f64,
    /// The share of the way before which they are apart.
    apart_until: f64,
}

/// How far a motion carries limbs at the most.
struct Sweep {
    /// Per limb, the joint before which nothing moves it, counted from 1; none, 0, on what rests.
    carried_by: Vec<usize>,
    /// Per joint, counted from 1, the one before it that moves.
    carried_before: Vec<usize>,
    /// Per joint, counted from 1, how far it turns, radians, and slides, metres.
    turns: Vec<f64>,
    slides: Vec<f64>,
    /// Per limb, how far its joint is from the root at the most, before it slides and after; and how far from its joint its
    /// surface is, metres.
    joint_depth: Vec<f64>,
    depth: Vec<f64>,
    reach: Vec<f64>,
}

impl Sweep {
    fn new(foresight: &Foresight, schema: &BodySchema, [from, to]: [&[f64]; 2]) -> Sweep {
        let creature = foresight.agent.creature();
        let limbs = creature.limbs().len();
        let reach = |ball: &Option<Ball>| ball.as_ref().map_or(0.0, |ball| ball.centre.norm() + ball.radius);
        let mut sweep = Sweep {
            carried_by: vec![0; limbs],
            carried_before: vec![0; limbs],
            turns: vec![0.0; limbs],
            slides: vec![0.0; limbs],
            joint_depth: vec![0.0; limbs],
            depth: vec![0.0; limbs],
            reach: foresight.balls.iter().map(reach).collect(),
        };
        for (number, joint) in creature.joints().iter().enumerate() {
            let limb = number + 1;
            let moves = joint.elements().any(|at| at.of(from) != at.of(to));
            sweep.carried_before[limb] = sweep.carried_by[joint.parent];
            sweep.carried_by[limb] = if moves { limb } else { sweep.carried_before[limb] };
            sweep.joint_depth[limb] = sweep.depth[joint.parent] + schema.positions[number].norm();
            sweep.depth[limb] = sweep.joint_depth[limb];
            for at in joint.elements() {
                let (a, b) = (at.of(from), at.of(to));
                let most = a.iter().zip(b).map(|(a, b)| (b - a).abs()).fold(0.0, f64::max);
                match at.dof().kind {
                    DofKind::Slide => {
                        sweep.slides[limb] += most;
                        sweep.depth[limb] += a[0].abs().max(b[0].abs());
                    }
                    DofKind::Hinge => sweep.turns[limb] += most,
                    DofKind::Ball if a != b => sweep.turns[limb] += std::f64::consts::PI,
                    DofKind::Ball => {}
                }
            }
        }
        sweep
    }

    /// How much of the gap of two limbs a motion closes at the most, metres.
    fn of(&self, [a, b]: [usize; 2]) -> f64 {
        let at = |limb: usize, joint: usize| {
            let far = self.depth[limb] - self.joint_depth[joint] + self.reach[limb];
            self.turns[joint] * far + self.slides[joint]
        };
        let (mut x, mut y) = (self.carried_by[a], self.carried_by[b]);
        let mut most = 0.0;
        // A limb comes after its parent, so the later one is not before the other.
        while x != y {
            if x > y {
                most += at(a, x);
                x = self.carried_before[x];
            } else {
                most += at(b, y);
                y = self.carried_before[y];
            }
        }
        most
    }
}
