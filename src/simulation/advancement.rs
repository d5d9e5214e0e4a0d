//! How far a motion can go before anything can touch.
//!
//! Between two postures every coordinate changes at a constant rate, so the speed and the acceleration
//! of each point of a limb against another limb are bounded by the joints between them. With the gap of
//! two geoms and those bounds a motion jumps ahead to where they may meet at the earliest (conservative
//! advancement), and needs no small steps. Geoms are bounded by capsules; for spheres and capsules the
//! bound is exact and so is the gap.

use std::collections::BTreeSet;

use nalgebra::Vector3;

use super::straight_motion::StraightMotion;
use super::touchable::{ClusterPair, Encounter, LimbCluster, TouchablePairs};
use crate::creature::{Body, Posture};
use crate::geometry::{Ball, Capsule, Gap, Precision, gap_from};
use crate::ground_truth::GroundTruth;
use crate::kinematics::LimbMotion;
use crate::mujoco;

/// How far a creature's motions can go, by the gaps between its geoms along them.
#[derive(Clone, Debug)]
pub struct ConservativeAdvancement {
    touchable: TouchablePairs,
    motion: StraightMotion,
    limbs: Vec<LimbMotion>,
    /// Per bound, its capsule in the root's frame, where its cluster is placed.
    world: Vec<Capsule>,
    placed: Vec<bool>,
    /// Per bound, the ball about it, in the same places.
    balls: Vec<MovingBall>,
    /// Per cluster, its ball in the root's frame.
    cluster_balls: Vec<Ball>,
    /// Per pair: greatest relative speed, greatest relative acceleration, and until when it is free.
    speed: Vec<f64>,
    acceleration: Vec<f64>,
    free_until: Vec<f64>,
    /// Per pair, which of its geom pairs limited the motion when it was last looked at: most likely it still does.
    limiting: Vec<usize>,
    /// What the motion starts in contact with, until it has parted.
    start_contact: Option<Encounter>,
    /// Limb pairs looked at, for the statistics.
    pub checks: u64,
    /// Steps of the present motion.
    steps: usize,
}

/// Below this gap two geoms count as met, metres.
const MET: f64 = 4e-7;
/// The same for shapes of which only the engine can tell that they touch, metres: more than its own error.
const NEARLY_MET: f64 = 4e-6;
/// Beyond this gap two geoms that touched at the start of a motion have parted, metres.
const PARTED: f64 = 1e-4;
/// Limbs that open by no more than this share of the way of the fastest point slide along each other.
pub(super) const SLIDING: f64 = 1e-3;
/// Way of the fastest point between looks at what is still parting, metres.
const PARTING_STEP: f64 = 5e-7;
/// Limbs farther apart than this are not looked at geom by geom, metres.
const FAR: f64 = 0.03;
/// Pairs that come up within this part of the motion are looked at together: placing the limbs costs
/// more than a look.
const SOON: f64 = 0.06;
/// More than what rounding does to a gap, metres.
const ROUNDING: f64 = 1e-9;
/// The least advance of a motion's parameter, so that no approach without contact stalls it.
const LEAST_ADVANCE: f64 = 1e-6;
/// After every so many steps it grows by as much again: limbs may slide along each other for a whole motion.
const CREEPING: usize = 1000;

impl ConservativeAdvancement {
    /// The motions of a body whose geoms can touch: those that the engine would let collide, on limbs that are not
    /// neighbours, but for the pairs `left_out`, the lesser index first.
    ///
    /// # Errors
    /// Where the engine fails.
    pub fn new(body: &Body, left_out: &BTreeSet<[usize; 2]>) -> mujoco::Result<ConservativeAdvancement> {
        let schema = GroundTruth::new(body)?.schema;
        let touchable = TouchablePairs::new(body, &schema, left_out);
        let count = touchable.pairs.len();
        Ok(ConservativeAdvancement {
            motion: StraightMotion::new(body.creature.clone(), schema),
            limbs: Vec::with_capacity(body.creature.limbs().len()),
            world: touchable.bounds.iter().map(|bound| bound.capsule).collect(),
            balls: touchable.bounds.iter().map(|bound| MovingBall::about(&bound.capsule)).collect(),
            placed: vec![false; touchable.clusters.len()],
            cluster_balls: touchable.clusters.iter().map(|cluster| cluster.ball).collect(),
            speed: vec![0.0; count],
            acceleration: vec![0.0; count],
            free_until: vec![0.0; count],
            limiting: vec![0; count],
            start_contact: None,
            checks: 0,
            steps: 0,
            touchable,
        })
    }

    /// Whether any two geoms can touch at all.
    pub fn is_empty(&self) -> bool {
        self.touchable.pairs.is_empty()
    }

    /// Sets out from `start` to `target`, in contact at the start where `contact` says so.
    pub fn begin(&mut self, start: &[f64], target: &[f64], contact: Option<Encounter>) {
        self.motion.begin(start, target);
        self.steps = 0;
        let speeds = self.motion.joint_speeds();
        for (k, pair) in self.touchable.pairs.iter().enumerate() {
            let (mut speed, mut acceleration) = (0.0, 0.0);
            for side in &pair.levers {
                // A point turned by joints i before j is accelerated by at most 2 ω_i ω_j r_j.
                let mut inner = 0.0;
                for lever in side {
                    let (turn, shift) = speeds[lever.joint];
                    let own = turn * lever.reach + shift;
                    speed += own;
                    acceleration += turn * turn * lever.reach + 2.0 * (inner * own + turn * shift);
                    inner += turn;
                }
            }
            self.speed[k] = speed;
            self.acceleration[k] = acceleration;
            self.free_until[k] = if speed > 0.0 { 0.0 } else { f64::INFINITY };
        }
        self.start_contact = contact;
    }

    /// The first encounter of the motion after `from`, as the fraction of the way at which it is about to
    /// happen; none when the target is reached freely.
    pub fn next(&mut self, from: f64) -> Option<(f64, Encounter)> {
        let mut t = from;
        loop {
            self.steps += 1;
            let least_advance = self.least_advance();
            t = t.max(least(&self.free_until));
            if t >= 1.0 {
                return None;
            }
            self.place_limbs(t);
            // Pairs that come up soon after are looked at now: the limbs are placed already.
            let soon = t + SOON;
            let mut met: Option<Encounter> = None;
            for k in 0..self.touchable.pairs.len() {
                if self.free_until[k] > soon {
                    continue;
                }
                let (advance, encounter) = self.look(k, 1.0 - t);
                if let Some(encounter) = encounter.filter(|_| advance <= 0.0) {
                    met = Some(encounter);
                }
                let parting = encounter.is_some() && encounter == self.start_contact && advance > 0.0;
                let advance = if parting { advance } else { advance.max(least_advance) };
                self.free_until[k] = self.free_until[k].max(t + advance);
            }
            if let Some(encounter) = met {
                return Some((t, encounter));
            }
        }
    }

    /// How far a motion advances at the least, whatever comes near: a share of its way.
    pub fn least_advance(&self) -> f64 {
        LEAST_ADVANCE * (1 + self.steps / CREEPING) as f64
    }

    /// The encounter of two geoms, in either order; none where they cannot touch, or are joined.
    pub fn encounter(&self, geoms: [usize; 2]) -> Option<Encounter> {
        self.touchable.encounter(geoms)
    }

    /// Whether the encounter is what touched at the start and has not parted since.
    pub fn parting(&self, encounter: &Encounter) -> bool {
        self.start_contact == Some(*encounter)
    }

    /// Lets a pair pass until `t`: the engine found it free so far.
    pub fn pass(&mut self, encounter: &Encounter, t: f64) {
        self.free_until[encounter.pair] = t;
    }

    /// The greatest speed of the encounter's pair, metres per unit of the motion.
    pub fn speed(&self, encounter: &Encounter) -> f64 {
        self.speed[encounter.pair]
    }

    /// How far a motion may advance from `t` until a point in both bounds of an encounter has moved by
    /// `length` metres between the limbs, at the most.
    pub fn advance_by(&mut self, encounter: &Encounter, t: f64, length: f64) -> f64 {
        self.place_limbs(t);
        let pair = &self.touchable.pairs[encounter.pair];
        // Any such point is in the lesser of the two.
        let bound = |side: usize| &self.touchable.bounds[encounter.bounds[side] as usize];
        let side = if bound(0).reach <= bound(1).reach { 0 } else { 1 };
        let Capsule { ends, radius } = bound(side).capsule;
        let turning = (self.limbs[pair.limbs[0]].omega - self.limbs[pair.limbs[1]].omega).norm();
        let motion = self.pair_motion(pair);
        let fastest = ends
            .map(|end| self.limbs[pair.limbs[side]].frame.point(&end))
            .map(|p| motion.relative_velocity(&[p, p]).norm())
            .into_iter()
            .fold(0.0, f64::max)
            + turning * radius;
        // Way in a time: fastest h + ½ acceleration h².
        let acceleration = self.acceleration[encounter.pair];
        let slow = 2.0 * length / (fastest + (fastest * fastest + 2.0 * acceleration * length).sqrt());
        slow.max(length / self.speed[encounter.pair])
    }

    /// The gap of an encounter's geoms at `t`, and its rate of change, metres and metres per unit.
    pub fn gap(&mut self, encounter: &Encounter, t: f64) -> (f64, f64) {
        self.place_limbs(t);
        let clusters = self.touchable.pairs[encounter.pair].clusters;
        clusters.into_iter().for_each(|cluster| self.place_cluster(cluster));
        let pair = &self.touchable.pairs[encounter.pair];
        let Gap { distance, normal, points } = self.bounds_gap(encounter.bounds);
        let velocity = self.pair_motion(pair).relative_velocity(&points);
        (distance, normal.dot(&velocity))
    }

    /// The posture at `t`.
    pub fn posture(&self, t: f64) -> Posture {
        self.motion.posture(t)
    }

    /// How far the motion may advance from where the limbs are placed before limb pair `k` can touch, and
    /// which geoms limit it; infinity where it cannot within the `rest`.
    fn look(&mut self, k: usize, rest: f64) -> (f64, Option<Encounter>) {
        self.checks += 1;
        let pair = &self.touchable.pairs[k];
        let balls = pair.clusters.map(|cluster| &self.cluster_balls[cluster]);
        let middles = balls.map(|ball| ball.centre);
        let between = middles[0] - middles[1];
        let distance = between.norm();
        let apart = distance - balls[0].radius - balls[1].radius;
        if apart > FAR {
            let plain = apart / self.speed[k];
            if plain >= rest {
                return (f64::INFINITY, None);
            }
            let opening = between.dot(&self.pair_motion(pair).relative_velocity(&middles)) / distance;
            return (plain.max(until_zero(apart, opening, self.acceleration[k])), None);
        }
        pair.clusters.into_iter().for_each(|cluster| self.place_cluster(cluster));
        match self.start_contact {
            Some(contact) if contact.pair == k => self.look_at_contact(&contact),
            _ => self.look_at_geoms(k, rest),
        }
    }

    /// [`look`](Self::look) at the geoms of limb pair `k`.
    fn look_at_geoms(&mut self, k: usize, rest: f64) -> (f64, Option<Encounter>) {
        let pair = &self.touchable.pairs[k];
        let acceleration = self.acceleration[k];
        let motion = self.pair_motion(pair);
        let spins = motion.sides.map(|side| side.omega.norm());
        // What limited the last look most likely limits this one: all that comes later need not be known exactly.
        let last = self.limiting[k];
        let by_last = self.advance_of(k, &motion, pair.geoms[last], &self.bounds_gap(pair.geoms[last]), rest);
        let mut heeded = by_last.min(rest);
        let mut least = rest;
        let mut limiting = None;
        for (number, &bounds) in pair.geoms.iter().enumerate() {
            let advance = if number == last {
                by_last
            } else {
                let passing = self.passing(&motion, &spins, bounds);
                if passing.outlasts(acceleration, heeded) {
                    continue;
                }
                let gap = self.bounds_gap(bounds);
                let opening = gap.normal.dot(&passing.velocity) - passing.turning;
                if gap.distance > MET && outlasts(gap.distance, opening, acceleration, heeded) {
                    continue;
                }
                self.advance_of(k, &motion, bounds, &gap, heeded)
            };
            if advance < least {
                (least, limiting) = (advance, Some(number));
                heeded = heeded.min(least);
            }
        }
        let Some(number) = limiting else { return (f64::INFINITY, None) };
        self.limiting[k] = number;
        (least, Some(self.touchable.encounter_of(k, pair.geoms[number])))
    }

    /// [`look`](Self::look) at the geoms of the limb pair that the motion starts in contact with, whether these have
    /// parted or not.
    fn look_at_contact(&mut self, contact: &Encounter) -> (f64, Option<Encounter>) {
        let k = contact.pair;
        let pair = &self.touchable.pairs[k];
        let motion = self.pair_motion(pair);
        let mut least = f64::INFINITY;
        let mut limiting = None;
        let mut parted = false;
        for &bounds in &pair.geoms {
            // Even at full speed it comes later than what is known already?
            let beyond = least * self.speed[k];
            if self.apart(bounds) > beyond {
                continue;
            }
            let gap = self.bounds_gap(bounds);
            if gap.distance > beyond {
                continue;
            }
            parted |= contact.exact && contact.bounds == bounds && gap.distance > PARTED;
            let advance = self.advance_of(k, &motion, bounds, &gap, least);
            if advance < least {
                (least, limiting) = (advance, Some(bounds));
            }
        }
        if parted {
            self.start_contact = None;
        }
        (least, limiting.map(|bounds| self.touchable.encounter_of(k, bounds)))
    }

    /// How far the motion may advance before two geoms of limb pair `k` can meet, given the gap of those about them; where
    /// it is `heeded` or more, anything from there on.
    fn advance_of(&self, k: usize, motion: &PairMotion, bounds: [u32; 2], gap: &Gap, heeded: f64) -> f64 {
        let kept_apart = || self.kept_apart(k, motion, bounds, &gap.normal, heeded);
        let exact = bounds.iter().all(|&bound| self.touchable.bounds[bound as usize].exact);
        if gap.distance > MET {
            let by_capsules = (gap.distance / self.speed[k]).max(kept_apart());
            if exact || by_capsules >= heeded {
                return by_capsules;
            }
            return self.advance_of_solids(k, motion, bounds, gap).max(by_capsules);
        }
        if !exact {
            return self.advance_of_solids(k, motion, bounds, gap);
        }
        // What touches at the start is already felt, until it has parted.
        let parting = self.start_contact.is_some_and(|contact| contact.pair == k && contact.bounds == bounds);
        // What slides along does not part, however long the way: the same as at the start of a motion.
        let opening = gap.normal.dot(&motion.relative_velocity(&gap.points));
        if parting && opening > SLIDING * self.speed[k] {
            return (PARTING_STEP / self.speed[k]).max(kept_apart());
        }
        0.0
    }

    /// How far the motion may advance before two geoms can meet that are no capsules, given the gap of those about them:
    /// 0 where they nearly do, or where their capsules tell as much.
    fn advance_of_solids(&self, k: usize, motion: &PairMotion, bounds: [u32; 2], about: &Gap) -> f64 {
        if about.distance > FAR {
            return 0.0;
        }
        let limbs = self.touchable.pairs[k].limbs;
        let solid = |side: usize| {
            let solid = self.touchable.bounds[bounds[side] as usize].solid.as_ref()?;
            solid.placed(&self.limbs[limbs[side]].frame)
        };
        let [Some(first), Some(second)] = [solid(0), solid(1)] else { return 0.0 };
        let Gap { distance, normal, .. } = gap_from(&first, &second, Precision::LowerBound, &about.normal);
        if distance <= NEARLY_MET {
            return 0.0;
        }
        // Every point of a shape is in its capsule, where velocities along the normal are greatest at an end but for
        // what the turning adds within the radius.
        let closing: f64 = [(0, -1.0), (1, 1.0)]
            .map(|(side, sign)| {
                let Twist { omega, .. } = motion.sides[side];
                let Capsule { ends, radius } = &self.world[bounds[side] as usize];
                let rates = ends.map(|end| sign * normal.dot(&motion.sides[side].velocity_at(&end)));
                rates[0].max(rates[1]) + omega.cross(&normal).norm() * radius
            })
            .iter()
            .sum();
        until_zero(distance, -closing, self.acceleration[k]).max(distance / self.speed[k])
    }

    /// How long a plane between two geoms' capsules keeps them apart, given its normal from the second to the first, to
    /// second order in the motion; where it is `heeded` or more, anything from there on.
    fn kept_apart(
        &self,
        k: usize,
        motion: &PairMotion,
        bounds: [u32; 2],
        n: &Vector3<f64>,
        heeded: f64,
    ) -> f64 {
        let mut height = [[0.0; 2]; 2];
        let mut rate = [[0.0; 2]; 2];
        for side in 0..2 {
            let sign = if side == 0 { 1.0 } else { -1.0 };
            let Capsule { ends, radius } = &self.world[bounds[side] as usize];
            for (end, p) in ends.iter().enumerate() {
                height[side][end] = sign * n.dot(p) - radius;
                rate[side][end] = sign * n.dot(&motion.sides[side].velocity_at(p));
            }
        }
        let acceleration = self.acceleration[k];
        let mut least = f64::INFINITY;
        for first in 0..2 {
            for second in 0..2 {
                let gap = (height[0][first] + height[1][second]).max(0.0);
                let opening = rate[0][first] + rate[1][second];
                let known = least.min(heeded);
                // A multiplication tells what is later than what is known, without a root.
                if !outlasts(gap, opening, acceleration, known) {
                    least = least.min(until_zero(gap, opening, acceleration));
                }
            }
        }
        least
    }

    /// How the balls about two geoms' capsules pass each other, on limbs that turn at `spins`.
    #[inline]
    fn passing(&self, motion: &PairMotion, spins: &[f64; 2], bounds: [u32; 2]) -> Passing {
        let [first, second] = bounds.map(|bound| &self.balls[bound as usize]);
        let between = first.centre - second.centre;
        let distance = between.norm();
        Passing {
            between,
            distance,
            gap: distance - first.radius - second.radius,
            reach: first.half_length + second.half_length,
            velocity: first.velocity - second.velocity - motion.ancestor_omega.cross(&between),
            turning: spins[0] * first.half_length + spins[1] * second.half_length,
        }
    }

    /// How the two limbs of a pair move against their common ancestor.
    fn pair_motion(&self, pair: &ClusterPair) -> PairMotion {
        let ancestor = &self.limbs[pair.ancestor];
        let against = |limb: &LimbMotion| Twist {
            omega: limb.omega - ancestor.omega,
            velocity: limb.velocity - ancestor.velocity,
        };
        let sides = pair.limbs.map(|limb| against(&self.limbs[limb]));
        PairMotion { sides, ancestor_omega: ancestor.omega }
    }

    /// A lower bound of two geoms' gap, from the balls about them.
    fn apart(&self, bounds: [u32; 2]) -> f64 {
        let [first, second] = bounds.map(|bound| &self.balls[bound as usize]);
        (first.centre - second.centre).norm() - first.radius - second.radius
    }

    /// The gap of the capsules about two geoms, at the points of their segments.
    fn bounds_gap(&self, bounds: [u32; 2]) -> Gap {
        let [first, second] = bounds.map(|bound| &self.world[bound as usize]);
        first.gap_at_segments(second)
    }

    /// Carries a cluster's capsules into the root's frame, once per posture.
    fn place_cluster(&mut self, cluster: usize) {
        if std::mem::replace(&mut self.placed[cluster], true) {
            return;
        }
        let LimbCluster { limb, members, .. } = &self.touchable.clusters[cluster];
        let limb = &self.limbs[*limb];
        for &bound in members {
            let bound = bound as usize;
            let capsule = self.touchable.bounds[bound].capsule.placed(&limb.frame);
            let centre = 0.5 * (capsule.ends[0] + capsule.ends[1]);
            let velocity = limb.velocity + limb.omega.cross(&centre);
            self.world[bound] = capsule;
            self.balls[bound] = MovingBall { centre, velocity, ..self.balls[bound] };
        }
    }

    /// Poses and velocities of all limbs at `t`, in the root's frame.
    fn place_limbs(&mut self, t: f64) {
        self.motion.place_limbs(t, &mut self.limbs);
        self.placed.fill(false);
        for (ball, cluster) in self.cluster_balls.iter_mut().zip(&self.touchable.clusters) {
            ball.centre = self.limbs[cluster.limb].frame.point(&cluster.ball.centre);
        }
    }
}

/// The ball about a capsule.
#[derive(Clone, Copy, Debug)]
struct MovingBall {
    centre: Vector3<f64>,
    /// Velocity of the limb's point at the centre in the root's frame.
    velocity: Vector3<f64>,
    radius: f64,
    /// Half the length of the capsule's segment.
    half_length: f64,
}

impl MovingBall {
    fn about(capsule: &Capsule) -> MovingBall {
        let Ball { centre, radius } = capsule.bounding_ball();
        MovingBall { centre, velocity: Vector3::zeros(), radius, half_length: radius - capsule.radius }
    }
}

/// How the balls about two geoms' capsules pass each other.
#[derive(Clone, Copy, Debug)]
struct Passing {
    /// From the second's middle to the first's.
    between: Vector3<f64>,
    distance: f64,
    /// Of the balls.
    gap: f64,
    /// The closest points of the capsules' segments are within this of where they would be if both were the middles.
    reach: f64,
    /// Of the first's middle against the second's.
    velocity: Vector3<f64>,
    /// What turning adds, at the most, to the velocity of any point of one segment against any of the other.
    turning: f64,
}

impl Passing {
    /// Whether the capsules are kept apart for longer than a time, whichever their closest points are.
    #[inline]
    fn outlasts(&self, acceleration: f64, time: f64) -> bool {
        // The normal leads along `between` but for an offset of up to `reach`. All is multiplied by its length, which is
        // the one at which the opening is least.
        let closing = self.reach * self.velocity.norm() - self.between.dot(&self.velocity);
        let length = if closing > 0.0 { self.distance - self.reach } else { self.distance + self.reach };
        let opening = -closing - self.turning * length;
        self.gap > MET && outlasts(self.gap * length, opening, acceleration * length, time)
    }
}

/// How a limb moves against another that rests, as [`LimbMotion`] has it.
#[derive(Clone, Copy, Debug)]
struct Twist {
    omega: Vector3<f64>,
    velocity: Vector3<f64>,
}

impl Twist {
    /// Velocity of the limb's point that is at `p`.
    #[inline]
    fn velocity_at(&self, p: &Vector3<f64>) -> Vector3<f64> {
        self.velocity + self.omega.cross(p)
    }
}

/// How the two limbs of a pair move against their common ancestor.
#[derive(Clone, Copy, Debug)]
struct PairMotion {
    sides: [Twist; 2],
    /// The ancestor's own angular velocity.
    ancestor_omega: Vector3<f64>,
}

impl PairMotion {
    /// Velocity of a point of the first limb against one of the second.
    #[inline]
    fn relative_velocity(&self, points: &[Vector3<f64>; 2]) -> Vector3<f64> {
        self.sides[0].velocity_at(&points[0]) - self.sides[1].velocity_at(&points[1])
    }
}

/// Whether `gap + opening h − ½ acceleration h²`, which is not below zero at first, stays above it for longer than `time`.
fn outlasts(gap: f64, opening: f64, acceleration: f64, time: f64) -> bool {
    gap + (opening - 0.5 * acceleration * time) * time > ROUNDING
}

/// The least of some numbers; infinity of none.
fn least(numbers: &[f64]) -> f64 {
    let lesser = |a: f64, b: f64| if b < a { b } else { a };
    // Several at a time: no comparison waits for the one before it.
    let mut least = [f64::INFINITY; 8];
    let chunks = numbers.chunks_exact(least.len());
    let rest = chunks.remainder();
    for chunk in chunks {
        for (least, &number) in least.iter_mut().zip(chunk) {
            *least = lesser(*least, number);
        }
    }
    least.iter().chain(rest).copied().fold(f64::INFINITY, lesser)
}

/// The time for which `gap + opening h − ½ acceleration h²` stays above zero.
fn until_zero(gap: f64, opening: f64, acceleration: f64) -> f64 {
    let root = (opening * opening + 2.0 * acceleration * gap).sqrt();
    if opening < 0.0 {
        2.0 * gap / (root - opening)
    } else if acceleration > 0.0 {
        (opening + root) / acceleration
    } else {
        f64::INFINITY
    }
}
