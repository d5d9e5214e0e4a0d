//! How far a motion can go before anything can touch.
//!
//! Between two postures every coordinate changes at a constant rate, so the speed and the acceleration
//! of each point of a limb against another limb are bounded by the joints between them. With the gap of
//! two geoms and those bounds a motion jumps ahead to where they may meet at the earliest (conservative
//! advancement), and needs no small steps. Geoms are bounded by capsules; for spheres and capsules the
//! bound is exact and so is the gap.

use std::collections::{BTreeMap, BTreeSet};

use nalgebra::{Isometry3, Matrix3, Vector3};

use crate::creature::{Body, Creature, DofKind, Joint};
use crate::kinematics::{Chain, closest_points, rotation};
use crate::mujoco::{self, Geom, GeomKind};
use crate::schema::BodySchema;
use crate::skin::{Surface, separation, surface_of_geom};

/// A capsule about a geom: all points within a radius of a segment.
#[derive(Clone, Debug)]
struct Bound {
    geom: usize,
    /// The segment's ends in the limb's frame, metres.
    ends: [Vector3<f64>; 2],
    radius: f64,
    /// Radius of the ball about the whole capsule, metres.
    reach: f64,
    exact: bool,
    /// The geom itself; none where nothing is known of its shape.
    solid: Option<Surface>,
}

/// One joint on one side of a pair, as seen from the limb at the end of that side.
#[derive(Clone, Copy, Debug)]
struct Lever {
    joint: usize,
    /// The farthest that any point of the limb's geoms can be from the joint, metres.
    reach: f64,
}

/// Geoms of one limb that lie together, and a ball about them.
#[derive(Clone, Debug)]
struct Cluster {
    limb: usize,
    members: Vec<u32>,
    /// The ball's middle in the limb's frame and its radius, metres.
    middle: Vector3<f64>,
    radius: f64,
}

/// Two clusters that can touch.
#[derive(Clone, Debug)]
struct ClusterPair {
    clusters: [usize; 2],
    limbs: [usize; 2],
    ancestor: usize,
    /// Per side, the joints from the ancestor outwards.
    levers: [Vec<Lever>; 2],
    /// The geom pairs, as indices into `bounds`.
    geoms: Vec<[u32; 2]>,
}

/// Two geoms that are about to meet.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Encounter {
    /// The geoms.
    pub geoms: [usize; 2],
    /// Whether their gap is exact, or only a lower bound.
    pub exact: bool,
    pair: usize,
    bounds: [u32; 2],
}

/// A limb's pose and motion in the root's frame.
#[derive(Clone, Copy, Debug)]
struct LimbState {
    rotation: Matrix3<f64>,
    origin: Vector3<f64>,
    /// Angular velocity per unit of the motion.
    omega: Vector3<f64>,
    /// Velocity of the point of the limb that is at the root frame's origin.
    velocity: Vector3<f64>,
}

impl LimbState {
    const ROOT: LimbState = LimbState {
        rotation: Matrix3::new(1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0),
        origin: Vector3::new(0.0, 0.0, 0.0),
        omega: Vector3::new(0.0, 0.0, 0.0),
        velocity: Vector3::new(0.0, 0.0, 0.0),
    };

    fn point(&self, p_l: &Vector3<f64>) -> Vector3<f64> {
        self.rotation * p_l + self.origin
    }
}

/// How one degree of freedom moves from start to target.
#[derive(Clone, Copy, Debug)]
enum Course {
    Hinge { start: f64, rate: f64 },
    Slide { start: f64, rate: f64 },
    Ball { start: Matrix3<f64>, axis: Vector3<f64>, rate: f64 },
}

/// The gaps between a creature's geoms along motions.
#[derive(Clone, Debug)]
pub struct Clearance {
    creature: Creature,
    schema: BodySchema,
    bounds: Vec<Bound>,
    pairs: Vec<ClusterPair>,
    clusters: Vec<Cluster>,
    /// Per pair of geoms that can touch, the lesser index first, their encounter.
    encounters: BTreeMap<[usize; 2], Encounter>,
    /// How strongly neighbouring degrees of freedom of one joint turn about the same axis: per degree of
    /// freedom, |a_k · a_(k+1)|.
    alike: Vec<f64>,
    // The current motion.
    courses: Vec<Course>,
    states: Vec<LimbState>,
    /// Per bound, its segment's ends in the root's frame, where its cluster is placed.
    world: Vec<[Vector3<f64>; 2]>,
    placed: Vec<bool>,
    /// Per cluster, its ball's middle in the root's frame.
    middles: Vec<Vector3<f64>>,
    /// Per pair: greatest relative speed, greatest relative acceleration, and until when it is free.
    speed: Vec<f64>,
    acceleration: Vec<f64>,
    free_until: Vec<f64>,
    /// What the motion starts in contact with, until it has parted.
    start_contact: Option<Encounter>,
    /// Limb pairs looked at, for the statistics.
    pub checks: u64,
}

/// Below this gap two geoms count as met, metres.
const MET: f64 = 4e-7;
/// The same for shapes of which only the engine can tell that they touch, metres: more than its own error.
const NEARLY_MET: f64 = 4e-6;
/// Beyond this gap two geoms that touched at the start of a motion have parted, metres.
const PARTED: f64 = 1e-4;
/// Way of the fastest point between looks at what is still parting, metres.
const PARTING_STEP: f64 = 5e-7;
/// Limbs farther apart than this are not looked at geom by geom, metres.
const FAR: f64 = 0.03;
/// A limb's geoms are split into clusters of at most about this radius, metres.
const LARGEST_CLUSTER: f64 = 0.18;
/// Pairs that come up within this part of the motion are looked at together: placing the limbs costs
/// more than a look.
const SOON: f64 = 0.06;
/// The least advance of a motion's parameter, so that no approach without contact stalls it.
const LEAST_ADVANCE: f64 = 1e-6;

impl Clearance {
    /// The clearance of a body between the geoms that can touch: those that the engine would let collide,
    /// on limbs that are not neighbours, but for the pairs `left_out`, the lesser index first.
    ///
    /// # Errors
    /// Where the engine fails.
    pub fn new(body: &Body, left_out: &BTreeSet<[usize; 2]>) -> mujoco::Result<Clearance> {
        let creature = body.creature.clone();
        let schema = body.kinematics()?;
        let mut by_limb: Vec<Vec<u32>> = vec![Vec::new(); creature.limbs().len()];
        let mut bounds = Vec::new();
        for (g, geom) in body.model.geoms().enumerate() {
            let Some(limb) = body.limb_of_geom(g) else { continue };
            let Some(bound) = bound(body, g, &geom) else { continue };
            by_limb[limb].push(bounds.len() as u32);
            bounds.push(bound);
        }
        let clusters: Vec<Cluster> = by_limb
            .into_iter()
            .enumerate()
            .flat_map(|(limb, members)| clusters(limb, members, &bounds))
            .collect();
        let slide_reach: Vec<f64> = creature
            .joints()
            .iter()
            .map(|joint| {
                let slides = joint.dofs.iter().filter(|dof| dof.kind == DofKind::Slide);
                slides.map(|dof| dof.range[0].abs().max(dof.range[1].abs())).sum()
            })
            .collect();
        let mut pairs = Vec::new();
        for (i, first) in clusters.iter().enumerate() {
            for (j, second) in clusters.iter().enumerate().skip(i + 1) {
                if creature.neighbouring(first.limb, second.limb) {
                    continue;
                }
                let collide = |pair: &[u32; 2]| {
                    let [g, h] = pair.map(|k| bounds[k as usize].geom);
                    body.model.collides(g, h) && !left_out.contains(&[g.min(h), g.max(h)])
                };
                let all = first.members.iter().flat_map(|&g| second.members.iter().map(move |&h| [g, h]));
                let geoms: Vec<[u32; 2]> = all.filter(collide).collect();
                if geoms.is_empty() {
                    continue;
                }
                let chain = Chain::between(&creature, first.limb, second.limb);
                let levers = [(0, first), (1, second)]
                    .map(|(side, cluster)| levers(&schema, &slide_reach, &chain.sides[side], cluster));
                pairs.push(ClusterPair {
                    clusters: [i, j],
                    limbs: [first.limb, second.limb],
                    ancestor: chain.ancestor,
                    levers,
                    geoms,
                });
            }
        }
        let mut encounters = BTreeMap::new();
        for (pair, touching) in pairs.iter().enumerate() {
            for &ends in &touching.geoms {
                let met = encounter(&bounds, pair, ends);
                let [a, b] = met.geoms;
                encounters.insert([a.min(b), a.max(b)], met);
            }
        }
        let mut alike = vec![1.0; creature.dof_elements()];
        for joint in creature.joints() {
            for k in joint.dof_indices().skip(1) {
                let both = [k - 1, k].map(|k| creature.dofs().nth(k).map(|dof| dof.kind));
                if both == [Some(DofKind::Hinge); 2] {
                    alike[k - 1] = schema.axes[k - 1].dot(&schema.axes[k]).abs();
                }
            }
        }
        let (count, bound_count, cluster_count) = (pairs.len(), bounds.len(), clusters.len());
        let states = vec![LimbState::ROOT; creature.limbs().len()];
        Ok(Clearance {
            creature,
            schema,
            bounds,
            pairs,
            clusters,
            encounters,
            alike,
            world: vec![[Vector3::zeros(); 2]; bound_count],
            placed: vec![false; cluster_count],
            middles: vec![Vector3::zeros(); cluster_count],
            courses: Vec::new(),
            states,
            speed: vec![0.0; count],
            acceleration: vec![0.0; count],
            free_until: vec![0.0; count],
            start_contact: None,
            checks: 0,
        })
    }

    /// Whether any two geoms can touch at all.
    pub fn is_empty(&self) -> bool {
        self.pairs.is_empty()
    }

    /// Sets out from `start` to `target`, in contact at the start where `contact` says so.
    pub fn begin(&mut self, start: &[f64], target: &[f64], contact: Option<Encounter>) {
        self.courses.clear();
        let mut q = 0;
        for dof in self.creature.dofs() {
            self.courses.push(match dof.kind {
                DofKind::Hinge => Course::Hinge { start: start[q], rate: target[q] - start[q] },
                DofKind::Slide => Course::Slide { start: start[q], rate: target[q] - start[q] },
                DofKind::Ball => {
                    let (from, to) =
                        (crate::kinematics::ball(&start[q..]), crate::kinematics::ball(&target[q..]));
                    let (axis, rate) = (to * from.inverse())
                        .axis_angle()
                        .map_or((Vector3::x(), 0.0), |(axis, angle)| (axis.into_inner(), angle));
                    Course::Ball { start: from.to_rotation_matrix().into_inner(), axis, rate }
                }
            });
            q += dof.kind.coordinates();
        }
        let rates: Vec<(f64, f64)> = self.creature.joints().iter().map(|joint| self.rates(joint)).collect();
        for (k, pair) in self.pairs.iter().enumerate() {
            let (mut speed, mut acceleration) = (0.0, 0.0);
            for side in &pair.levers {
                // A point turned by joints i before j is accelerated by at most 2 ω_i ω_j r_j.
                let mut inner = 0.0;
                for lever in side {
                    let (turn, shift) = rates[lever.joint];
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

    /// How fast a joint turns (radians) and shifts (metres per unit) at the most.
    fn rates(&self, joint: &Joint) -> (f64, f64) {
        let (mut squared, mut shift) = (0.0, 0.0);
        let turning = |k: usize| match self.courses[k] {
            Course::Hinge { rate, .. } | Course::Ball { rate, .. } => rate.abs(),
            Course::Slide { .. } => 0.0,
        };
        for k in joint.dof_indices() {
            squared += turning(k) * turning(k);
            for later in k + 1..joint.dof_indices().end {
                // Consecutive axes keep their angle; others may come to lie along each other.
                let alike = if later == k + 1 { self.alike[k] } else { 1.0 };
                squared += 2.0 * alike * turning(k) * turning(later);
            }
            if let Course::Slide { rate, .. } = self.courses[k] {
                shift += rate.abs();
            }
        }
        (squared.sqrt(), shift)
    }

    /// The first encounter of the motion after `from`, as the fraction of the way at which it is about to
    /// happen; none when the target is reached freely.
    pub fn next(&mut self, from: f64) -> Option<(f64, Encounter)> {
        let mut t = from;
        loop {
            let earliest = self.free_until.iter().copied().fold(f64::INFINITY, f64::min);
            t = t.max(earliest);
            if t >= 1.0 {
                return None;
            }
            self.place_limbs(t);
            // Pairs that come up soon after are looked at now: the limbs are placed already.
            let soon = t + SOON;
            let mut met: Option<Encounter> = None;
            for k in 0..self.pairs.len() {
                if self.free_until[k] > soon {
                    continue;
                }
                let (advance, encounter) = self.look(k, 1.0 - t);
                if let Some(encounter) = encounter.filter(|_| advance <= 0.0) {
                    met = Some(encounter);
                }
                let parting = encounter.is_some() && encounter == self.start_contact && advance > 0.0;
                let advance = if parting { advance } else { advance.max(LEAST_ADVANCE) };
                self.free_until[k] = self.free_until[k].max(t + advance);
            }
            if let Some(encounter) = met {
                return Some((t, encounter));
            }
        }
    }

    /// The encounter of two geoms, in either order; none where they cannot touch, or are joined.
    pub fn encounter(&self, [a, b]: [usize; 2]) -> Option<Encounter> {
        self.encounters.get(&[a.min(b), a.max(b)]).copied()
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
        let pair = &self.pairs[encounter.pair];
        // Any such point is in the lesser of the two.
        let reach = |side: usize| self.bounds[encounter.bounds[side] as usize].reach;
        let side = if reach(0) <= reach(1) { 0 } else { 1 };
        let bound = &self.bounds[encounter.bounds[side] as usize];
        let turning = (self.states[pair.limbs[0]].omega - self.states[pair.limbs[1]].omega).norm();
        let fastest = bound
            .ends
            .map(|end| self.states[pair.limbs[side]].point(&end))
            .map(|p| self.relative_velocity(pair, &[p, p]).norm())
            .into_iter()
            .fold(0.0, f64::max)
            + turning * bound.radius;
        // Way in a time: fastest h + ½ acceleration h².
        let acceleration = self.acceleration[encounter.pair];
        let slow = 2.0 * length / (fastest + (fastest * fastest + 2.0 * acceleration * length).sqrt());
        slow.max(length / self.speed[encounter.pair])
    }

    /// The gap of an encounter's geoms at `t`, and its rate of change, metres and metres per unit.
    pub fn gap(&mut self, encounter: &Encounter, t: f64) -> (f64, f64) {
        self.place_limbs(t);
        let clusters = self.pairs[encounter.pair].clusters;
        clusters.into_iter().for_each(|cluster| self.place_cluster(cluster));
        let pair = &self.pairs[encounter.pair];
        let closest = self.closest(encounter.bounds);
        let velocity = self.relative_velocity(pair, &closest.points);
        (closest.gap, closest.normal.dot(&velocity))
    }

    /// The posture at `t`.
    pub fn posture(&self, t: f64) -> Vec<f64> {
        let mut posture = Vec::with_capacity(self.creature.coordinates());
        for course in &self.courses {
            match course {
                Course::Hinge { start, rate } | Course::Slide { start, rate } => {
                    posture.push(start + t * rate);
                }
                Course::Ball { start, axis, rate } => {
                    let turned = ball_at(start, axis, *rate, t);
                    let rotation = nalgebra::Rotation3::from_matrix_unchecked(turned);
                    let q = nalgebra::UnitQuaternion::from_rotation_matrix(&rotation);
                    posture.extend([q.w, q.i, q.j, q.k]);
                }
            }
        }
        posture
    }

    /// How far the motion may advance from where the limbs are placed before limb pair `k` can touch, and
    /// which geoms limit it.
    fn look(&mut self, k: usize, rest: f64) -> (f64, Option<Encounter>) {
        self.checks += 1;
        let clusters = self.pairs[k].clusters;
        let middles = clusters.map(|c| self.middles[c]);
        let [first, second] = clusters.map(|c| self.clusters[c].radius);
        let between = middles[0] - middles[1];
        let distance = between.norm();
        let apart = distance - first - second;
        if apart > FAR {
            let pair = &self.pairs[k];
            let plain = apart / self.speed[k];
            if plain >= rest {
                return (plain, None);
            }
            let opening = between.dot(&self.relative_velocity(pair, &middles)) / distance;
            return (plain.max(until_zero(apart, opening, self.acceleration[k])), None);
        }
        clusters.into_iter().for_each(|cluster| self.place_cluster(cluster));
        let pair = &self.pairs[k];
        let mut least = f64::INFINITY;
        let mut limiting = None;
        let mut parted = false;
        for &bounds in &pair.geoms {
            // Even at full speed it comes later than what is known already?
            let beyond = least * self.speed[k];
            if self.apart(bounds) > beyond {
                continue;
            }
            let closest = self.closest(bounds);
            if closest.gap > beyond {
                continue;
            }
            let encounter = encounter(&self.bounds, k, bounds);
            if !encounter.exact {
                let advance = self.advance_of_solids(pair, bounds, &closest, k);
                if advance < least {
                    least = advance;
                    limiting = Some(encounter);
                }
                continue;
            }
            // What touches at the start is already felt, until it has parted.
            let parting = self.parting(&encounter);
            parted |= parting && closest.gap > PARTED;
            let advance = if closest.gap > MET {
                (closest.gap / self.speed[k]).max(self.kept_apart(pair, &closest, k))
            } else if parting && closest.normal.dot(&self.relative_velocity(pair, &closest.points)) > 0.0 {
                (PARTING_STEP / self.speed[k]).max(self.kept_apart(pair, &closest, k))
            } else {
                0.0
            };
            if advance < least {
                least = advance;
                limiting = Some(encounter);
            }
        }
        if parted {
            self.start_contact = None;
        }
        (least, limiting)
    }

    /// How far the motion may advance before two geoms can meet that are no capsules: 0 where they nearly do.
    fn advance_of_solids(&self, pair: &ClusterPair, bounds: [u32; 2], closest: &Closest, k: usize) -> f64 {
        let by_capsules = if closest.gap > MET {
            (closest.gap / self.speed[k]).max(self.kept_apart(pair, closest, k))
        } else {
            0.0
        };
        if closest.gap > FAR {
            return by_capsules;
        }
        let solids = bounds.map(|bound| self.bounds[bound as usize].solid.as_ref());
        let [Some(first), Some(second)] = solids else { return by_capsules };
        let states = pair.limbs.map(|limb| &self.states[limb]);
        let support = |direction: &Vector3<f64>| {
            let at = |solid: &Surface, state: &LimbState, d: Vector3<f64>| {
                state.point(&solid.support(&state.rotation.tr_mul(&d)).unwrap_or_default())
            };
            at(first, states[0], *direction) - at(second, states[1], -direction)
        };
        let (gap, normal) = separation(support, &closest.normal);
        if gap <= NEARLY_MET {
            return by_capsules;
        }
        // Every point of a shape is in its capsule, where velocities along the normal are greatest at an end but for
        // what the turning adds within the radius.
        let closing: f64 = [(0, -1.0), (1, 1.0)]
            .map(|(side, sign)| {
                let limb = states[side];
                let turning = limb.omega - self.states[pair.ancestor].omega;
                let rates = closest.ends[side].map(|end| sign * normal.dot(&self.velocity(pair, side, &end)));
                rates[0].max(rates[1]) + turning.cross(&normal).norm() * closest.radii[side]
            })
            .iter()
            .sum();
        let by_solids = until_zero(gap, -closing, self.acceleration[k]).max(gap / self.speed[k]);
        by_solids.max(by_capsules)
    }

    /// How long the plane between two geoms keeps them apart, to second order in the motion.
    fn kept_apart(&self, pair: &ClusterPair, closest: &Closest, k: usize) -> f64 {
        let n = closest.normal;
        let mut least = f64::INFINITY;
        let mut height = [[0.0; 2]; 2];
        let mut rate = [[0.0; 2]; 2];
        for side in 0..2 {
            let sign = if side == 0 { 1.0 } else { -1.0 };
            for end in 0..2 {
                let p = closest.ends[side][end];
                height[side][end] = sign * n.dot(&p) - closest.radii[side];
                let velocity = self.velocity(pair, side, &p);
                rate[side][end] = sign * n.dot(&velocity);
            }
        }
        for first in 0..2 {
            for second in 0..2 {
                let gap = (height[0][first] + height[1][second]).max(0.0);
                let opening = rate[0][first] + rate[1][second];
                least = least.min(until_zero(gap, opening, self.acceleration[k]));
            }
        }
        least
    }

    /// Velocity of a point of one side's limb against the common ancestor.
    fn velocity(&self, pair: &ClusterPair, side: usize, p: &Vector3<f64>) -> Vector3<f64> {
        let limb = &self.states[pair.limbs[side]];
        let ancestor = &self.states[pair.ancestor];
        limb.velocity - ancestor.velocity + (limb.omega - ancestor.omega).cross(p)
    }

    fn relative_velocity(&self, pair: &ClusterPair, points: &[Vector3<f64>; 2]) -> Vector3<f64> {
        self.velocity(pair, 0, &points[0]) - self.velocity(pair, 1, &points[1])
    }

    /// A lower bound of two geoms' gap, from the balls about them.
    fn apart(&self, bounds: [u32; 2]) -> f64 {
        let [a, b] = bounds.map(|i| i as usize);
        let doubled = self.world[a][0] + self.world[a][1] - self.world[b][0] - self.world[b][1];
        0.5 * doubled.norm() - self.bounds[a].reach - self.bounds[b].reach
    }

    fn closest(&self, bounds: [u32; 2]) -> Closest {
        let at = |side: usize| {
            let bound = bounds[side] as usize;
            (self.world[bound], self.bounds[bound].radius)
        };
        let ((a, radius_a), (b, radius_b)) = (at(0), at(1));
        let points = closest_points(&a, &b);
        let between = points[0] - points[1];
        let distance = between.norm();
        let normal = if distance > 1e-12 { between / distance } else { Vector3::z() };
        Closest {
            gap: distance - radius_a - radius_b,
            normal,
            points,
            ends: [a, b],
            radii: [radius_a, radius_b],
        }
    }

    /// Carries a cluster's segments into the root's frame, once per posture.
    fn place_cluster(&mut self, cluster: usize) {
        if std::mem::replace(&mut self.placed[cluster], true) {
            return;
        }
        let Cluster { limb, members, .. } = &self.clusters[cluster];
        let state = &self.states[*limb];
        for &bound in members {
            self.world[bound as usize] = self.bounds[bound as usize].ends.map(|end| state.point(&end));
        }
    }

    /// Poses and velocities of all limbs at `t`, in the root's frame.
    fn place_limbs(&mut self, t: f64) {
        for (j, joint) in self.creature.joints().iter().enumerate() {
            let parent = self.states[joint.parent];
            let mut state = parent;
            state.origin += parent.rotation * self.schema.positions[j];
            for k in joint.dof_indices() {
                let axis = &self.schema.axes[k];
                match &self.courses[k] {
                    Course::Hinge { start, rate } => {
                        let (sine, cosine) = (start + t * rate).sin_cos();
                        let omega = state.rotation * (axis * *rate);
                        state.omega += omega;
                        state.velocity -= omega.cross(&state.origin);
                        state.rotation *= rotation(axis, sine, 1.0 - cosine);
                    }
                    Course::Slide { start, rate } => {
                        let direction = state.rotation * axis;
                        state.origin += direction * (start + t * rate);
                        state.velocity += direction * *rate;
                    }
                    Course::Ball { start, axis, rate } => {
                        let omega = state.rotation * (axis * *rate);
                        state.omega += omega;
                        state.velocity -= omega.cross(&state.origin);
                        state.rotation *= ball_at(start, axis, *rate, t);
                    }
                }
            }
            self.states[j + 1] = state;
        }
        self.placed.fill(false);
        for (middle, cluster) in self.middles.iter_mut().zip(&self.clusters) {
            *middle = self.states[cluster.limb].point(&cluster.middle);
        }
    }
}

/// The encounter of two bounds of a pair.
fn encounter(bounds: &[Bound], pair: usize, ends: [u32; 2]) -> Encounter {
    let exact = ends.iter().all(|&i| bounds[i as usize].exact);
    let geoms = ends.map(|i| bounds[i as usize].geom);
    Encounter { geoms, exact, pair, bounds: ends }
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

/// Splits a limb's geoms until each cluster's ball is small, so that balls tell limbs apart.
fn clusters(limb: usize, members: Vec<u32>, bounds: &[Bound]) -> Vec<Cluster> {
    if members.is_empty() {
        return Vec::new();
    }
    let ends = || members.iter().flat_map(|&b| bounds[b as usize].ends);
    let low = ends().reduce(|a, b| a.inf(&b)).expect("a cluster has members");
    let high = ends().reduce(|a, b| a.sup(&b)).expect("a cluster has members");
    let middle = 0.5 * (low + high);
    let reach = |b: &u32| {
        let bound = &bounds[*b as usize];
        bound.ends.iter().map(|end| (end - middle).norm()).fold(0.0, f64::max) + bound.radius
    };
    let radius = members.iter().map(reach).fold(0.0, f64::max);
    if radius > LARGEST_CLUSTER && members.len() > 1 {
        let axis = (high - low).imax();
        let centre = |b: &u32| bounds[*b as usize].ends.iter().map(|end| end[axis]).sum::<f64>();
        let mut sorted = members.clone();
        sorted.sort_by(|a, b| centre(a).total_cmp(&centre(b)));
        let rest = sorted.split_off(sorted.len() / 2);
        let mut split = clusters(limb, sorted, bounds);
        split.extend(clusters(limb, rest, bounds));
        return split;
    }
    vec![Cluster { limb, members, middle, radius }]
}

struct Closest {
    gap: f64,
    /// From the second segment to the first.
    normal: Vector3<f64>,
    points: [Vector3<f64>; 2],
    ends: [[Vector3<f64>; 2]; 2],
    radii: [f64; 2],
}

fn ball_at(start: &Matrix3<f64>, axis: &Vector3<f64>, rate: f64, t: f64) -> Matrix3<f64> {
    let (sine, cosine) = (t * rate).sin_cos();
    rotation(axis, sine, 1.0 - cosine) * start
}

/// Per joint of one side, ancestor first, how far the limb's geoms can be from it.
fn levers(schema: &BodySchema, slide_reach: &[f64], joints: &[usize], cluster: &Cluster) -> Vec<Lever> {
    let mut reach = cluster.middle.norm() + cluster.radius;
    let mut levers: Vec<Lever> = Vec::new();
    for &joint in joints.iter().rev() {
        reach += slide_reach[joint];
        levers.push(Lever { joint, reach });
        reach += schema.positions[joint].norm();
    }
    levers.reverse();
    levers
}

/// The capsule about a geom, in the frame of its limb; none for what has no bounds.
fn bound(body: &Body, g: usize, geom: &Geom) -> Option<Bound> {
    let [x, y, z] = geom.size;
    let along = |axis: usize, half: f64| {
        let mut end = Vector3::zeros();
        end[axis] = half;
        [end, -end]
    };
    // A box about the origin, as a capsule along its longest side.
    let boxed = |half: Vector3<f64>| {
        let axis = half.imax();
        let others = Vector3::from_fn(|k, _| if k == axis { 0.0 } else { half[k] });
        (along(axis, half[axis]), others.norm())
    };
    let (ends, radius) = match geom.kind {
        GeomKind::Sphere => (along(2, 0.0), x),
        GeomKind::Capsule | GeomKind::Cylinder => (along(2, y), x),
        GeomKind::Box => boxed(Vector3::new(x, y, z)),
        GeomKind::Ellipsoid => {
            let half = Vector3::new(x, y, z);
            let axis = half.imax();
            let radius = (0..3).filter(|&k| k != axis).map(|k| half[k]).fold(0.0, f64::max);
            (along(axis, half[axis] - radius), radius)
        }
        GeomKind::Mesh => {
            let vertices = body.model.mesh_vertices(g);
            boxed(vertices.iter().fold(Vector3::zeros(), |half, v| half.sup(&v.abs())))
        }
        _ => return None,
    };
    let pose = body.pose_in_limb[geom.body] * Isometry3::from_parts(geom.pos.into(), geom.quat);
    let place = |end: Vector3<f64>| (pose * nalgebra::Point3::from(end)).coords;
    let exact = matches!(geom.kind, GeomKind::Sphere | GeomKind::Capsule);
    let reach = radius + 0.5 * (ends[1] - ends[0]).norm();
    let solid = surface_of_geom(body, g).filter(|surface| surface.support(&Vector3::x()).is_some());
    Some(Bound { geom: g, ends: ends.map(place), radius, reach, exact, solid })
}
