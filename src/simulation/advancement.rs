//! How far a motion can go before anything can touch.
//!
//! Between two postures every coordinate changes at a constant rate, so the speed and the acceleration
//! of each point of a limb against another limb are bounded by the joints between them. With the gap of
//! two geoms and those bounds a motion jumps ahead to where they may meet at the earliest (conservative
//! advancement), and needs no small steps. Geoms are bounded by capsules; for spheres and capsules the
//! bound is exact and so is the gap. Other convex shapes are asked for a plane that parts them once their
//! capsules tell no more.

use std::collections::BTreeSet;
use std::sync::Arc;

use nalgebra::Vector3;

use super::broad_phase::near_pairs;
use super::relative_motion::{PairMotion, outlasts, until_zero};
use super::straight_motion::StraightMotion;
use super::touchable::{ClusterPair, Encounter, LimbCluster, TouchablePairs};
use crate::creature::Body;
use crate::error::Result;
use crate::geometry::{Ball, Capsule, Gap, PlacedShape, Precision, gap_from, separation};
use crate::ground_truth::GroundTruth;
use crate::kinematics::LimbMotion;

/// How far a creature's motions can go, by the gaps between its geoms along them.
#[derive(Clone, Debug)]
pub(super) struct ConservativeAdvancement {
    /// The same for all motions of a body.
    pub(super) touchable: Arc<TouchablePairs>,
    pub(super) motion: StraightMotion,
    limbs: Vec<LimbMotion>,
    /// Per bound, its capsule in the root's frame, where its cluster is placed.
    world: Vec<Capsule>,
    placed: Vec<bool>,
    /// Per bound, the ball about it, in the same places.
    balls: Vec<MovingBall>,
    /// Per cluster, its ball in the root's frame.
    cluster_balls: Vec<Ball>,
    /// Per joint, how fast it turns and shifts in the present motion.
    joint_speeds: Vec<(f64, f64)>,
    /// The pairs that can meet before the end of the window, in order; all others are free until then.
    near: Vec<u32>,
    /// Up to when they are known.
    window_end: f64,
    /// How long a window is in the present motion, and what each cluster can move by against the root in one, metres: where
    /// there are too many pairs to look at all.
    window: f64,
    growth: Vec<f64>,
    /// How each pair moves, and until when it is free.
    pairs: Vec<MovingPair>,
    free_until: Vec<f64>,
    /// Per pair of geoms, the plane that parted them when they were last looked at, where they are no capsules. Those of a pair
    /// of limbs follow one another.
    planes: Vec<PartingPlane>,
    /// Motions begun.
    motions: u64,
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
/// The least advance of a motion's parameter, so that no approach without contact stalls it.
const LEAST_ADVANCE: f64 = 1e-6;
/// Of so many pairs all are looked at from the beginning of a motion on.
const FEW_PAIRS: usize = 8192;
/// How far clusters move in a window on average, as a share of their radius.
const WINDOW: f64 = 1.0;
/// The shortest window, as a part of the motion.
const LEAST_WINDOW: f64 = 1e-3;
/// After every so many steps it grows by as much again: limbs may slide along each other for a whole motion.
const CREEPING: usize = 1000;

impl ConservativeAdvancement {
    /// The motions of a body whose geoms can touch: those that the engine would let collide, on limbs that are not
    /// neighbours, but for the pairs `left_out`, the lesser index first.
    ///
    /// # Errors
    /// Where the engine fails.
    pub fn new(body: &Body, left_out: &BTreeSet<[usize; 2]>) -> Result<ConservativeAdvancement> {
        let schema = GroundTruth::new(body)?.schema;
        let touchable = Arc::new(TouchablePairs::new(body, &schema, left_out));
        let count = touchable.pairs.len();
        Ok(ConservativeAdvancement {
            motion: StraightMotion::new(body.creature.clone(), schema),
            limbs: Vec::with_capacity(body.creature.limbs().len()),
            world: touchable.bounds.iter().map(|bound| bound.capsule).collect(),
            balls: touchable.bounds.iter().map(|bound| MovingBall::about(&bound.capsule)).collect(),
            placed: vec![false; touchable.clusters.len()],
            cluster_balls: touchable.clusters.iter().map(|cluster| cluster.ball).collect(),
            joint_speeds: Vec::new(),
            near: if count > FEW_PAIRS { Vec::new() } else { (0..count as u32).collect() },
            window_end: 0.0,
            window: 0.0,
            growth: Vec::new(),
            pairs: vec![MovingPair::default(); count],
            free_until: vec![0.0; count],
            planes: vec![PartingPlane::default(); touchable.geoms.len()],
            motions: 0,
            start_contact: None,
            checks: 0,
            steps: 0,
            touchable,
        })
    }

    /// Sets out from `start` to `target`, in contact at the start where `contact` says so.
    pub fn begin(&mut self, start: &[f64], target: &[f64], contact: Option<Encounter>) {
        self.motion.begin(start, target);
        self.steps = 0;
        self.joint_speeds = self.motion.joint_speeds();
        self.motions += 1;
        self.start_contact = contact;
        if self.touchable.pairs.len() <= FEW_PAIRS {
            self.window_end = f64::INFINITY;
            (0..self.touchable.pairs.len()).for_each(|k| self.prepare(k));
            return;
        }
        self.near.clear();
        self.window_end = 0.0;
        let speeds = &self.joint_speeds;
        self.growth.clear();
        self.growth.extend(self.touchable.clusters.iter().map(|cluster| {
            let levers = cluster.levers.iter();
            levers.map(|lever| speeds[lever.joint].0 * lever.reach + speeds[lever.joint].1).sum::<f64>()
        }));
        // In a window the clusters move by about as much as they are large.
        let size: f64 = self.cluster_balls.iter().map(|ball| ball.radius).sum();
        let speed: f64 = self.growth.iter().sum();
        self.window = (WINDOW * size / speed).max(LEAST_WINDOW);
        self.growth.iter_mut().for_each(|growth| *growth *= self.window);
    }

    /// Bounds of how a pair moves in the present motion, and that nothing is known yet of when it meets.
    fn prepare(&mut self, k: usize) {
        let (mut speed, mut acceleration) = (0.0, 0.0);
        for side in 0..2 {
            // A point turned by joints i before j is accelerated by at most 2 ω_i ω_j r_j.
            let mut inner = 0.0;
            for lever in self.touchable.levers(&self.touchable.pairs[k], side) {
                let (turn, shift) = self.joint_speeds[lever.joint];
                let own = turn * lever.reach + shift;
                speed += own;
                acceleration += turn * turn * lever.reach + 2.0 * (inner * own + turn * shift);
                inner += turn;
            }
        }
        let limiting = self.pairs[k].limiting;
        self.pairs[k] = MovingPair { motion: self.motions, speed, acceleration, limiting };
        self.free_until[k] = if speed > 0.0 { 0.0 } else { f64::INFINITY };
    }

    /// Begins a window at `t`, where the limbs are placed: finds the pairs that can meet before its end.
    fn begin_window(&mut self, t: f64) {
        self.window_end = t + self.window;
        let mut near = std::mem::take(&mut self.near);
        near.clear();
        let touchable = &self.touchable;
        near_pairs(&self.cluster_balls, &self.growth, FAR, |clusters| {
            near.extend(touchable.pair_of(clusters).map(|k| k as u32));
        });
        near.sort_unstable();
        for &k in &near {
            if self.pairs[k as usize].motion != self.motions {
                self.prepare(k as usize);
            }
        }
        self.near = near;
    }

    /// The first encounter of the motion after `from`, as the fraction of the way at which it is about to
    /// happen; none when the target is reached freely.
    pub fn next(&mut self, from: f64) -> Option<(f64, Encounter)> {
        let mut t = from;
        loop {
            self.steps += 1;
            let least_advance = self.least_advance();
            t = t.max(self.least_free_until().min(self.window_end));
            if t >= 1.0 {
                return None;
            }
            self.place_limbs(t);
            if t >= self.window_end {
                self.begin_window(t);
            }
            // Pairs that come up soon after are looked at now: the limbs are placed already.
            let soon = t + SOON;
            let mut met: Option<Encounter> = None;
            for n in 0..self.near.len() {
                let k = self.near[n] as usize;
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

    /// Until when all pairs that are near are free.
    fn least_free_until(&self) -> f64 {
        if self.near.len() == self.free_until.len() {
            return least(&self.free_until);
        }
        self.near.iter().map(|&k| self.free_until[k as usize]).fold(f64::INFINITY, f64::min)
    }

    /// How far a motion advances at the least, whatever comes near: a share of its way.
    pub fn least_advance(&self) -> f64 {
        LEAST_ADVANCE * (1 + self.steps / CREEPING) as f64
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
        self.pairs[encounter.pair].speed
    }

    /// How far a motion may advance from `t` until a point in both bounds of an encounter has moved by
    /// `length` metres between the limbs, at the most.
    pub fn advance_by(&mut self, encounter: &Encounter, t: f64, length: f64) -> f64 {
        self.place_limbs(t);
        let pair = self.touchable.pairs[encounter.pair];
        // Any such point is in the lesser of the two.
        let bound = |side: usize| &self.touchable.bounds[encounter.bounds[side] as usize];
        let side = usize::from(bound(0).reach > bound(1).reach);
        let Capsule { ends, radius } = bound(side).capsule;
        let limbs = pair.limbs();
        let turning = (self.limbs[limbs[0]].twist.angular - self.limbs[limbs[1]].twist.angular).norm();
        let motion = self.pair_motion(&pair);
        let fastest = ends
            .map(|end| self.limbs[limbs[side]].frame.point(&end))
            .map(|p| motion.relative_velocity(&[p, p]).norm())
            .into_iter()
            .fold(0.0, f64::max)
            + turning * radius;
        // Way in a time: fastest h + ½ acceleration h².
        let acceleration = self.pairs[encounter.pair].acceleration;
        let slow = 2.0 * length / (fastest + (fastest * fastest + 2.0 * acceleration * length).sqrt());
        slow.max(length / self.pairs[encounter.pair].speed)
    }

    /// The gap of an encounter's geoms at `t`, and its rate of change, metres and metres per unit: of capsules, or of other
    /// convex shapes; `None` if nothing is known of a shape.
    pub fn gap(&mut self, encounter: &Encounter, t: f64) -> Option<(f64, f64)> {
        self.place_limbs(t);
        let pair = self.touchable.pairs[encounter.pair];
        pair.clusters().into_iter().for_each(|cluster| self.place_cluster(cluster));
        let about = self.bounds_gap(encounter.bounds);
        let Gap { distance, normal, points } = match encounter.exact {
            true => about,
            false => {
                let [first, second] = self.solids(&pair, encounter.bounds)?;
                gap_from(&first, &second, Precision::Exact, &about.normal)
            }
        };
        let velocity = self.pair_motion(&pair).relative_velocity(&points);
        Some((distance, normal.dot(&velocity)))
    }

    /// How far the motion may advance from where the limbs are placed before limb pair `k` can touch, and
    /// which geoms limit it; infinity where it cannot within the `rest`.
    fn look(&mut self, k: usize, rest: f64) -> (f64, Option<Encounter>) {
        self.checks += 1;
        let pair = self.touchable.pairs[k];
        let balls = pair.clusters().map(|cluster| &self.cluster_balls[cluster]);
        let middles = balls.map(|ball| ball.centre);
        let between = middles[0] - middles[1];
        let distance = between.norm();
        let apart = distance - balls[0].radius - balls[1].radius;
        if apart > FAR {
            let plain = apart / self.pairs[k].speed;
            if plain >= rest {
                return (f64::INFINITY, None);
            }
            let opening = between.dot(&self.pair_motion(&pair).relative_velocity(&middles)) / distance;
            return (plain.max(until_zero(apart, opening, self.pairs[k].acceleration)), None);
        }
        pair.clusters().into_iter().for_each(|cluster| self.place_cluster(cluster));
        let found = self.look_at_geoms(k, rest);
        let has_parted =
            |contact: &Encounter| contact.pair == k && self.bounds_gap(contact.bounds).distance > PARTED;
        if self.start_contact.as_ref().is_some_and(has_parted) {
            self.start_contact = None;
        }
        found
    }

    /// [`look`](Self::look) at the geoms of limb pair `k`.
    fn look_at_geoms(&mut self, k: usize, rest: f64) -> (f64, Option<Encounter>) {
        let pair = self.touchable.pairs[k];
        let acceleration = self.pairs[k].acceleration;
        let motion = self.pair_motion(&pair);
        let spins = motion.sides.map(|side| side.angular.norm());
        // What limited the last look most likely limits this one: all that comes later need not be known exactly.
        let last = self.pairs[k].limiting as usize;
        let mut planes = std::mem::take(&mut self.planes);
        let plane = |number: usize| pair.geoms().start + number;
        let geoms = &self.touchable.geoms[pair.geoms()];
        let about = self.bounds_gap(geoms[last]);
        let by_last = self.advance_of(k, &motion, geoms[last], &about, &mut planes[plane(last)], rest);
        let mut heeded = by_last.min(rest);
        let mut least = rest;
        let mut limiting = None;
        for (number, &bounds) in geoms.iter().enumerate() {
            let advance = if number == last {
                by_last
            } else {
                let passing = self.passing(&motion, &spins, bounds, acceleration, heeded);
                let Some((velocity, turning)) = passing else { continue };
                let gap = self.bounds_gap(bounds);
                let opening = gap.normal.dot(&velocity) - turning;
                if gap.distance > MET && outlasts(gap.distance, opening, acceleration, heeded) {
                    continue;
                }
                self.advance_of(k, &motion, bounds, &gap, &mut planes[plane(number)], heeded)
            };
            if advance < least {
                (least, limiting) = (advance, Some(number));
                heeded = heeded.min(least);
            }
        }
        let encounter = limiting.map(|number| self.touchable.encounter_of(k, geoms[number]));
        self.planes = planes;
        let Some(number) = limiting else { return (f64::INFINITY, None) };
        self.pairs[k].limiting = number as u32;
        (least, encounter)
    }

    /// How far the motion may advance before two geoms of limb pair `k` can meet, given the gap of those about them and the
    /// plane between them; where it is `heeded` or more, anything from there on.
    fn advance_of(
        &self,
        k: usize,
        motion: &PairMotion,
        bounds: [u32; 2],
        gap: &Gap,
        plane: &mut PartingPlane,
        heeded: f64,
    ) -> f64 {
        let capsules = bounds.map(|bound| &self.world[bound as usize]);
        let kept_apart =
            || motion.keeps_capsules_apart(capsules, &gap.normal, self.pairs[k].acceleration, heeded);
        let exact = bounds.iter().all(|&bound| self.touchable.bounds[bound as usize].exact);
        if gap.distance > MET {
            let by_capsules = (gap.distance / self.pairs[k].speed).max(kept_apart());
            if exact || by_capsules >= heeded {
                return by_capsules;
            }
            return self.advance_of_solids(k, motion, bounds, gap, plane, heeded).max(by_capsules);
        }
        if !exact {
            return self.advance_of_solids(k, motion, bounds, gap, plane, heeded);
        }
        // What touches at the start is already felt, until it has parted.
        let parting = self.start_contact.is_some_and(|contact| contact.pair == k && contact.bounds == bounds);
        // What slides along does not part, however long the way: the same as at the start of a motion.
        let opening = gap.normal.dot(&motion.relative_velocity(&gap.points));
        if parting && opening > SLIDING * self.pairs[k].speed {
            return (PARTING_STEP / self.pairs[k].speed).max(kept_apart());
        }
        0.0
    }

    /// The same of two geoms that are no capsules: 0 where they nearly meet, or where their capsules tell as much.
    fn advance_of_solids(
        &self,
        k: usize,
        motion: &PairMotion,
        bounds: [u32; 2],
        about: &Gap,
        plane: &mut PartingPlane,
        heeded: f64,
    ) -> f64 {
        if about.distance > FAR {
            return 0.0;
        }
        let pair = self.touchable.pairs[k];
        let Some([first, second]) = self.solids(&pair, bounds) else { return 0.0 };
        let kept_apart = |normal: &Vector3<f64>| {
            motion.keeps_bodies_apart([&first, &second], normal, self.pairs[k].acceleration, heeded)
        };
        let orientation = &self.limbs[pair.limbs()[1]].frame.rotation;
        let mut guess = about.normal;
        // The plane that parted them before most likely still does. One of another motion must not count, for bouts are
        // made in any order.
        if plane.motion == self.motions {
            guess = orientation * plane.normal;
            let kept = kept_apart(&guess);
            if kept >= heeded {
                return kept;
            }
        }
        let (distance, normal) = separation(&first, &second, &guess, heeded * self.pairs[k].speed);
        *plane = PartingPlane { normal: orientation.tr_mul(&normal), motion: self.motions };
        if distance <= NEARLY_MET {
            return 0.0;
        }
        kept_apart(&normal).max(distance / self.pairs[k].speed)
    }

    /// The shapes of two geoms of a limb pair where the limbs are; `None` if nothing is known of one.
    fn solids(&self, pair: &ClusterPair, bounds: [u32; 2]) -> Option<[PlacedShape<'_>; 2]> {
        let solid = |side: usize| {
            let solid = self.touchable.bounds[bounds[side] as usize].solid.as_ref()?;
            solid.placed(&self.limbs[pair.limbs()[side]].frame)
        };
        Some([solid(0)?, solid(1)?])
    }

    /// How two geoms' capsules pass each other on limbs that turn at `spins`, by the balls about them: the velocity of the first
    /// one's middle against the second's, and what turning adds at the most to that of any point of one segment against any of
    /// the other. `None` if they are kept apart for longer than a time, whichever their closest points are.
    #[inline]
    fn passing(
        &self,
        motion: &PairMotion,
        spins: &[f64; 2],
        bounds: [u32; 2],
        acceleration: f64,
        time: f64,
    ) -> Option<(Vector3<f64>, f64)> {
        let [first, second] = bounds.map(|bound| &self.balls[bound as usize]);
        let between = first.centre - second.centre;
        let distance = between.norm();
        let gap = distance - first.radius - second.radius;
        let velocity = first.velocity - second.velocity - motion.ancestor_omega.cross(&between);
        let turning = spins[0] * first.half_length + spins[1] * second.half_length;
        // The closest points of the segments are within `reach` of where they would be if both were the middles, so the normal
        // leads along `between` but for an offset of up to that. All is multiplied by its length, which is the one at which the
        // opening is least.
        let reach = first.half_length + second.half_length;
        let closing = reach * velocity.norm() - between.dot(&velocity);
        let length = if closing > 0.0 { distance - reach } else { distance + reach };
        let opening = -closing - turning * length;
        let outlasts = gap > MET && outlasts(gap * length, opening, acceleration * length, time);
        (!outlasts).then_some((velocity, turning))
    }

    /// How the two limbs of a pair move against their common ancestor.
    fn pair_motion(&self, pair: &ClusterPair) -> PairMotion {
        PairMotion::new(pair.limbs().map(|limb| &self.limbs[limb]), &self.limbs[pair.ancestor as usize])
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
            let velocity = limb.twist.at(&centre);
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

/// How a pair of clusters moves.
#[derive(Clone, Copy, Debug, Default)]
struct MovingPair {
    /// The number of the motion in which it does.
    motion: u64,
    /// The greatest relative speed and acceleration, metres per unit and its square.
    speed: f64,
    acceleration: f64,
    /// Which of its geom pairs limited the motion when it was last looked at: most likely it still does.
    limiting: u32,
}

/// A plane that parted two geoms.
#[derive(Clone, Copy, Debug, Default)]
struct PartingPlane {
    /// Its unit normal in the second limb's frame, from the second geom to the first.
    normal: Vector3<f64>,
    /// The number of the motion that it was found in; 0 where there is none yet.
    motion: u64,
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
