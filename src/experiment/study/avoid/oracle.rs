//! Whether any posture gets out of the way of a thing, by the truth: a search that knows the thing's shape and course and the
//! true kinematics, and tries many thousands of postures.

use nalgebra::{Isometry3, Vector3};
use rand::seq::IndexedRandom;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::super::at_table::Knowledge;
use super::coming::Coming;
use crate::creature::Posture;
use crate::geometry::{Capsule, Frame, PlacedShape, SweptShape};
use crate::interaction::QUICK;
use crate::kinematics::{Facing, InverseKinematics, Place};
use crate::peripersonal::{CollisionChecker, distance};

/// A posture that keeps this far from all that the thing passes avoids it, metres.
const CLEAR: f64 = 1e-3;
/// Random postures of a search, within radii of how many radians, …
const DRAWS: usize = 10_000;
const RADII: [f64; 5] = [0.15, 0.3, 0.6, 1.2, 3.2];
/// … and the best of them that are bettered by changes of a few joints, so many each.
const BEST: usize = 16;
const BETTERED: usize = 500;
const TOGETHER: usize = 4;
/// The same for postures that keep a hand at its task.
const TASK_DRAWS: usize = 1_500;
/// How near a limb a thing is when it is noticed, metres: as far as an aura reaches at least.
const NOTICED: f64 = 0.35;
/// Most clear postures whose ways are looked at.
const WAYS: usize = 400;
/// Time between two moments of a way that are looked at, seconds.
const FINE: f64 = 0.02;
/// How near its place a hand at its task is, metres.
pub(super) const AT_TASK: f64 = 0.02;

/// What a search found.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Avoidable {
    /// Some posture keeps clear of all that the thing passes, and of the body.
    pub any: bool,
    /// Some such posture can be gone straight to in the time left from when the thing is within an aura.
    pub in_time: bool,
    /// Postures looked at.
    pub postures: usize,
}

/// Who knows all about a trial.
pub(super) struct Oracle<'a> {
    known: &'a Knowledge,
    coming: &'a Coming,
    /// The thing where it sets out, in the root's frame, and where it goes from there.
    first: Frame,
    way: Vector3<f64>,
    clearance: CollisionChecker,
    /// The joints of each arm with the trunk's, the trunk's alone, and all.
    groups: Vec<Vec<usize>>,
    /// The share of its way that the thing has gone when it is noticed.
    noticed: f64,
}

impl<'a> Oracle<'a> {
    /// Knows a trial on a stage whose root is at `X_WR`; `hands` are the limbs that act.
    pub fn new(
        known: &'a Knowledge,
        coming: &'a Coming,
        x_wr: &Isometry3<f64>,
        hands: [usize; 2],
    ) -> Oracle<'a> {
        let own = &known.own;
        let x_rw = x_wr.inverse();
        let pose = x_rw * Isometry3::from_parts(coming.ends[0].into(), coming.turn);
        let way = x_rw * (coming.ends[1] - coming.ends[0]);
        let clearance = known.clearance.eased_at(&[own.frames(&coming.posture)], 0.0);
        let mut groups = vec![(0..own.creature().joints().len()).collect::<Vec<_>>()];
        groups.extend(hands.map(|hand| own.joints_to(hand)));
        groups.extend([0, 1].map(|k| own.joints_of(hands[k], &[hands[1 - k]])));
        let trunk = groups[0]
            .iter()
            .copied()
            .filter(|joint| !groups[3].contains(joint) && !groups[4].contains(joint));
        let trunk: Vec<usize> = trunk.collect();
        groups.push(trunk);
        groups.retain(|group| !group.is_empty());
        let first = Frame::from(pose);
        let mut oracle = Oracle { known, coming, first, way, clearance, groups, noticed: 0.0 };
        oracle.noticed = oracle.first_within(NOTICED);
        oracle
    }

    /// How far the body is from all that the thing passes between two shares of its way, up to `below`, metres.
    pub fn gap(&self, frames: &[Frame], [from, until]: [f64; 2], below: f64) -> f64 {
        let origin = self.first.origin + self.way * from;
        let Some(shape) =
            PlacedShape::new(&self.coming.shape, Frame { origin, ..self.first }, Frame::identity())
        else {
            return below;
        };
        let way = self.way * (until - from);
        let about = Capsule { ends: [origin, origin + way], radius: self.coming.shape.bounding_radius() };
        let swept = SweptShape { shape, way };
        (0..frames.len())
            .fold(below, |least, limb| least.min(self.clearance.to_body(frames, limb, &swept, &about, least)))
    }

    /// How far a posture keeps from all of the thing's way; none where limbs are in each other.
    fn rate(&self, posture: &[f64], enough: f64) -> Option<f64> {
        let frames = self.known.own.frames(posture);
        let gap = self.gap(&frames, [0.0, 1.0], 0.1);
        (gap > enough && self.clearance.free(&frames, 0.0)).then_some(gap)
    }

    /// The share of its way that the thing has gone when it is first as near as `near` to the creature that holds still.
    pub fn first_within(&self, near: f64) -> f64 {
        let frames = self.known.own.frames(&self.coming.posture);
        let far = self.way.norm();
        let mut share = 0.0;
        // Nothing can come nearer faster than it goes.
        while share < 1.0 {
            let gap = self.gap(&frames, [share, share], 2.0);
            if gap <= near + 1e-3 {
                break;
            }
            share += (gap - near) / far;
        }
        share.min(1.0)
    }

    /// Whether a posture can be gone straight to, joints turning at [`QUICK`], before the thing is there.
    fn in_time(&self, posture: &[f64]) -> bool {
        let own = &self.known.own;
        let from = &self.coming.posture;
        let seconds = distance(from, posture) / QUICK;
        let steps = (seconds / FINE).ceil().max(1.0) as usize;
        let per_second = self.coming.speed / self.way.norm();
        (1..=steps).all(|k| {
            let share = k as f64 / steps as f64;
            let frames = own.frames(&Posture::between(own.creature(), from, posture, share));
            let [before, after] = [-1.0, 0.0]
                .map(|off| (self.noticed + (k as f64 + off) / steps as f64 * seconds * per_second).min(1.0));
            self.gap(&frames, [before, after], CLEAR) >= CLEAR && self.clearance.free(&frames, 0.0)
        })
    }

    /// Looks for a posture that avoids the thing.
    pub fn search(&self, seed: u64) -> Avoidable {
        let own = &self.known.own;
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let mut found = Avoidable::default();
        // What nothing moves cannot get out of the way.
        if self.gap(&[Frame::identity()], [0.0, 1.0], CLEAR) < CLEAR {
            return found;
        }
        let mut ways = 0;
        let mut takes = |found: &mut Avoidable, posture: &[f64], gap: f64| {
            if gap > CLEAR {
                found.any = true;
                if ways < WAYS {
                    ways += 1;
                    found.in_time |= self.in_time(posture);
                }
            }
            found.in_time
        };
        let mut rated: Vec<(f64, usize, Posture)> = Vec::new();
        for k in 0..DRAWS {
            let (group, radius) = (k % self.groups.len(), RADII[k / self.groups.len() % RADII.len()]);
            let posture = own.posture_near(&self.coming.posture, &self.groups[group], radius, &mut rng);
            found.postures += 1;
            let worst = rated.get(BEST).map_or(f64::NEG_INFINITY, |worst| worst.0);
            if let Some(gap) = self.rate(&posture, worst) {
                if takes(&mut found, &posture, gap) {
                    return found;
                }
                rated.push((gap, group, posture));
                rated.sort_by(|a, b| b.0.total_cmp(&a.0));
                rated.truncate(BEST + 1);
            }
        }
        for (mut gap, group, mut posture) in rated.into_iter().take(BEST) {
            for k in 0..BETTERED {
                let trial = self.changed(&posture, &self.groups[group], k, &mut rng);
                found.postures += 1;
                if let Some(better) = self.rate(&trial, gap) {
                    (gap, posture) = (better, trial);
                    if takes(&mut found, &posture, gap) {
                        return found;
                    }
                }
            }
        }
        found
    }

    /// A posture that differs in a few joints, the less the later.
    fn changed(&self, posture: &[f64], joints: &[usize], k: usize, rng: &mut ChaCha8Rng) -> Posture {
        let count = rng.random_range(1..=TOGETHER);
        let some: Vec<usize> = (0..count).filter_map(|_| joints.choose(rng).copied()).collect();
        self.known.own.posture_near(posture, &some, 0.5 * 0.99_f64.powi(k as i32), rng)
    }

    /// Whether some posture avoids the thing while a place of the body is where its task has it.
    pub fn keeps_task(&self, place: Place, target: Vector3<f64>, joints: &[usize], seed: u64) -> bool {
        let own = &self.known.own;
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let place = Place { direction: Vector3::zeros(), ..place };
        let ends = [place, Place { limb: 0, point: target, direction: Vector3::zeros() }];
        let mut solver = InverseKinematics::new(own.creature(), &own.schema, ends)
            .with_facing(Facing::Parallel)
            .moving(|joint| joints.contains(&joint));
        let mut rate = |posture: Posture, enough: f64| {
            let reach = solver.solve(&posture);
            (reach.miss < AT_TASK)
                .then(|| Some((self.rate(&reach.posture, enough)?, reach.posture)))
                .flatten()
        };
        let mut rated: Vec<(f64, Posture)> = Vec::new();
        for k in 0..TASK_DRAWS {
            let (group, radius) = (k % self.groups.len(), RADII[k / self.groups.len() % RADII.len()]);
            let drawn = own.posture_near(&self.coming.posture, &self.groups[group], radius, &mut rng);
            if let Some(found) = rate(drawn, f64::NEG_INFINITY) {
                if found.0 > CLEAR {
                    return true;
                }
                rated.push(found);
            }
        }
        rated.sort_by(|a, b| b.0.total_cmp(&a.0));
        rated.into_iter().take(BEST / 2).any(|(mut gap, mut posture)| {
            (0..BETTERED / 3).any(|k| {
                let trial = self.changed(&posture, &self.groups[0], k, &mut rng);
                if let Some(better) = rate(trial, gap) {
                    (gap, posture) = better;
                }
                gap > CLEAR
            })
        })
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;
    use std::sync::Arc;

    use nalgebra::UnitQuaternion;

    use super::*;
    use crate::agent::Agent;
    use crate::creature::{Body, JointSelection};
    use crate::geometry::Shape;
    use crate::ground_truth::GroundTruth;
    use crate::learning::Certainty;
    use crate::mujoco::Model;
    use crate::peripersonal::OwnBody;

    #[test]
    fn a_head_gets_out_of_the_way_of_a_ball_but_not_of_a_wall_and_a_pelvis_of_nothing() {
        let model = Model::from_path(Path::new(env!("CARGO_MANIFEST_DIR")).join("mjcf/max/max.xml")).unwrap();
        let body = Body::new(Arc::new(model), &JointSelection::Default).unwrap();
        let agent = Agent::of(&body).unwrap();
        let schema = GroundTruth::new(&body).unwrap().schema;
        let known = Knowledge::new(OwnBody::new(&agent, schema, Certainty::Exact, &[]));
        let own = &known.own;
        let hands = ["left_hand", "right_hand"].map(|name| own.creature().limb(name).unwrap());
        let posture = own.at_ease();
        let head = own.frames(&posture)[own.limbs_called("head").unwrap()[0]].origin;
        let search = |through: Vector3<f64>, radius: f64, speed: f64| {
            let ends = [1.0, -0.5].map(|ahead| through + Vector3::x() * ahead);
            let shape = Shape::Sphere { radius };
            let turn = UnitQuaternion::identity();
            let coming =
                Coming { aimed: 0, posture: posture.clone(), shape, turn, ends, speed, met: Vec::new() };
            Oracle::new(&known, &coming, &Isometry3::identity(), hands).search(1)
        };
        let found = search(head, 0.03, 0.3);
        assert!(found.any && found.in_time);
        let found = search(head, 0.03, 300.0);
        assert!(found.any && !found.in_time, "nobody is that quick");
        // One that misses the pelvis, and takes in all above.
        let found = search(head, 0.42, 0.3);
        assert!(!found.any && found.postures > DRAWS, "{found:?}");
        assert!(!search(Vector3::zeros(), 0.03, 0.3).any);
    }
}
