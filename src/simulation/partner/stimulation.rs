//! Random stimulations of the skin: taps, presses, strokes and rubs by a probe, and strokes that go over joints, from one limb
//! to the next.

use std::f64::consts::TAU;

use nalgebra::Vector3;
use rand::RngExt;
use rand::seq::IndexedRandom;
use rand_chacha::ChaCha8Rng;

use crate::geometry::Frame;
use crate::senses::TouchKind;
use crate::simulation::{PROBE_RADIUS, ProbePath, STIFFNESS, Stage};
use crate::skin::{JoinedLimbs, Skin};

/// From how far above the skin a probe comes, metres.
const ABOVE: f64 = 0.04;
/// How far a probe keeps from all other limbs, metres.
const CLEAR: f64 = 0.004;
/// Steps in which a way over the skin is laid, metres.
pub(super) const STEP: f64 = 0.002;
/// Rounds in which a probe's place on the skin is found: in a crease it comes to rest between two sides.
const SETTLES: usize = 60;
/// Speeds over the skin, metres a second.
const SPEED: [f64; 2] = [0.05, 0.4];
/// How long a probe takes to come down to the skin, and to rise from it, seconds.
const COMES: f64 = 0.25;
const LEAVES: f64 = 0.2;
/// Steps of a way in which the same receptors fire at its beginning, and at its end, at the least: on one patch nothing moves,
/// as far as a skin feels, and by less a probe cuts a corner.
const FELT: usize = 7;
/// Steps of a way in one of which a receptor fires at the least: over wider bare skin what touches could as well have been
/// lifted.
const UNFELT: usize = 5;
/// Places tried for one stimulation.
pub(super) const TRIES: usize = 2000;

/// Normals of two steps of a way on one limb have a cosine of this at the least: beyond is an edge or a fold.
const STRAIGHT_ON: f64 = 0.7;
/// The same where a way goes over a joint, in whose crease the limbs meet at an angle.
const OVER_A_JOINT: f64 = 0.4;
/// Steps over which the direction that a probe is pressed in is evened out where it goes over a crease.
const EVENED_OUT: usize = 3;

/// How long a way over joints is on the first limb and on the last one at the least, metres: it begins on the one, and ends on the
/// other.
const ON_EITHER: f64 = 0.015;
/// The farthest that it goes, metres, and from end to end in a straight line.
const FARTHEST: f64 = 0.5;
/// Ways that are tried.
const WAYS: usize = 500;

/// A stimulation that is done to the creature.
#[derive(Clone, Debug, PartialEq)]
pub struct Stimulation {
    /// What kind it is.
    pub kind: TouchKind,
    /// The limbs, from the one where it begins to the one where it ends.
    pub limbs: Vec<usize>,
    /// The force that the probe is pressed with, newtons.
    pub force: f64,
    /// The way of its middle, from when it sets out.
    pub path: ProbePath,
    /// When it comes down to the skin, and when it leaves it, seconds.
    pub touching: [f64; 2],
}

/// The skin of a creature in its posture, as ways over it need it.
pub struct Strokes<'a> {
    pub(super) skin: &'a Skin,
    /// Per limb, `X_WL`.
    pub(super) frames: Vec<Frame>,
    /// Which limbs follow each other.
    limbs: JoinedLimbs,
}

/// A place of a probe on the skin.
#[derive(Clone, Copy, Debug)]
pub(super) struct SkinPoint {
    /// The limb that it is on.
    pub limb: usize,
    /// The probe's middle, at its radius above the skin.
    pub middle: Vector3<f64>,
    /// The outward normal.
    pub normal: Vector3<f64>,
}

impl SkinPoint {
    /// The unit direction along the skin that comes nearest to a direction. `None` if that leads straight away from it.
    pub fn along(&self, direction: &Vector3<f64>) -> Option<Vector3<f64>> {
        (direction - self.normal * direction.dot(&self.normal)).try_normalize(1e-6)
    }

    /// The middle of a probe so far above the skin there, metres.
    pub fn at(&self, height: f64) -> Vector3<f64> {
        self.middle + self.normal * height
    }
}

impl<'a> Strokes<'a> {
    /// Looks at the creature where the stage's last step left it.
    pub fn new(stage: &'a Stage) -> Strokes<'a> {
        let limbs = JoinedLimbs::new(stage.agent().creature(), stage.skin());
        Strokes { skin: stage.skin(), frames: stage.limb_frames(), limbs }
    }

    /// The limbs that a way may go on to from a limb, itself first.
    pub(super) fn joined(&self, limb: usize) -> Vec<usize> {
        std::iter::once(limb).chain(self.limbs.of(limb).filter(|&other| other != limb)).collect()
    }

    /// A receptor of a limb, drawn at random.
    fn receptor_on(&self, limb: usize, rng: &mut ChaCha8Rng) -> Option<usize> {
        self.skin.receptors_on(limb).collect::<Vec<_>>().choose(rng).copied()
    }

    /// A random point of a receptor's patch, or of the inner share of it, in the limb's frame.
    pub(super) fn place_on(&self, receptor: usize, share: f64, rng: &mut ChaCha8Rng) -> Vector3<f64> {
        let receptor = &self.skin.receptors[receptor];
        let [a, b] = receptor.half_extents.map(|half| share * half * rng.random_range(-1.0..1.0));
        receptor.position + receptor.tangent * a + receptor.bitangent() * b
    }

    /// A random stimulation of a kind, setting out at `time`, that begins on one receptor and where it moves ends on another:
    /// limbs are drawn alike, then a place of their skin, a direction, a speed, a force. `None` if no limb has room for it.
    pub fn random(&self, kind: TouchKind, time: f64, rng: &mut ChaCha8Rng) -> Option<Stimulation> {
        let mut limbs: Vec<usize> = self.skin.receptors.iter().map(|receptor| receptor.limb).collect();
        limbs.sort_unstable();
        limbs.dedup();
        (0..TRIES).find_map(|_| {
            let limb = *limbs.choose(rng)?;
            let receptor = self.receptor_on(limb, rng)?;
            let length = match kind {
                TouchKind::Tap | TouchKind::Press => 0.0,
                TouchKind::Stroke => rng.random_range(0.03..0.15),
                TouchKind::Rub => rng.random_range(0.02..0.06),
            };
            let p_l = self.place_on(receptor, 0.7, rng);
            let angle = rng.random_range(0.0..TAU);
            let receptor = &self.skin.receptors[receptor];
            let along = receptor.tangent * angle.cos() + receptor.bitangent() * angle.sin();
            let way = self.way(limb, &p_l, &along, length)?;
            (length == 0.0 || self.is_felt(&way)).then(|| laid(kind, &way, time, rng))
        })
    }

    /// A random stroke over so many joints, setting out at `time`: a row of limbs that follow each other is drawn, then a place
    /// on its first and one on its last limb; the way goes towards the latter over the skin. `None` if no row has room for it.
    pub fn across(&self, joints: usize, time: f64, rng: &mut ChaCha8Rng) -> Option<Stimulation> {
        let rows = self.rows(joints + 1);
        (0..WAYS).find_map(|_| {
            let row = rows.choose(rng)?;
            let [from, to] = [row[0], row[joints]].map(|limb| {
                let receptor = self.receptor_on(limb, rng)?;
                Some(self.frames[limb].point(&self.place_on(receptor, 1.0, rng)))
            });
            let way = self.towards(row, &from?, &to?)?;
            Some(laid(TouchKind::Stroke, &way, time, rng))
        })
    }

    /// All rows of so many limbs with skin, each joined to the next.
    fn rows(&self, length: usize) -> Vec<Vec<usize>> {
        let has_skin = |limb: &usize| self.skin.receptors_on(*limb).next().is_some();
        let mut rows: Vec<Vec<usize>> =
            (0..self.frames.len()).filter(has_skin).map(|limb| vec![limb]).collect();
        for _ in 1..length {
            let longer = |row: &Vec<usize>| {
                let next = self.joined(row[row.len() - 1]).into_iter().filter(has_skin);
                let next: Vec<usize> = next.filter(|limb| !row.contains(limb)).collect();
                next.into_iter().map(|limb| [&row[..], &[limb]].concat()).collect::<Vec<_>>()
            };
            rows = rows.iter().flat_map(longer).collect();
        }
        rows
    }

    /// A way over the skin of a row of limbs from a place on the first one towards a place on the last one, straight
    /// ahead as far as the skin has it. `None` if it does not get there, or comes near another limb.
    fn towards(&self, row: &[usize], from: &Vector3<f64>, to: &Vector3<f64>) -> Option<Vec<SkinPoint>> {
        let last = row[row.len() - 1];
        let [start, end] = [self.onto(row, from)?, self.onto(row, to)?];
        if start.limb != row[0] || end.limb != last || (end.middle - start.middle).norm() > FARTHEST {
            return None;
        }
        let mut way = vec![start];
        while (end.middle - way[way.len() - 1].middle).norm() > 1.5 * STEP {
            let spot = way[way.len() - 1];
            way.push(self.next(row, &spot, &spot.along(&(end.middle - spot.middle))?)?);
            if way.len() as f64 * STEP > FARTHEST {
                return None;
            }
        }
        let mut limbs: Vec<usize> = way.iter().map(|spot| spot.limb).collect();
        limbs.dedup();
        let long_enough = [row[0], last]
            .iter()
            .all(|&limb| way.iter().filter(|spot| spot.limb == limb).count() as f64 * STEP >= ON_EITHER);
        let ends_are_free = || [0, way.len() - 1].iter().all(|&k| self.is_free(&[way[k].limb], &way[k..=k]));
        (limbs == row && long_enough && ends_are_free() && self.is_free(row, &way) && self.is_felt(&way))
            .then_some(way)
    }

    /// Whether a skin can feel that a way moves: other receptors fire at its end than at its beginning, and there is
    /// nowhere for long none that does.
    pub(super) fn is_felt(&self, way: &[SkinPoint]) -> bool {
        let felt: Vec<Vec<usize>> = way.iter().map(|spot| self.receptors_at(spot)).collect();
        let lasts = |part: &[Vec<usize>]| !part[0].is_empty() && part.iter().all(|found| *found == part[0]);
        let ends = felt.first_chunk::<FELT>().zip(felt.last_chunk::<FELT>());
        ends.is_some_and(|(first, last)| lasts(first) && lasts(last) && first[0] != last[0])
            && felt.windows(UNFELT).all(|part| part.iter().any(|found| !found.is_empty()))
    }

    /// The receptors whose `touch` sensors read what presses at a spot.
    fn receptors_at(&self, spot: &SkinPoint) -> Vec<usize> {
        let frame = &self.frames[spot.limb];
        let p_l = frame.inverse_point(&(spot.middle - spot.normal * PROBE_RADIUS));
        let outward = frame.rotation.tr_mul(&spot.normal);
        self.skin.receptors_on(spot.limb).filter(|&r| self.skin.receptors[r].reads(&p_l, &outward)).collect()
    }

    /// A step on over the skin of some limbs; none over an edge or into a fold, where the way would jump.
    pub(super) fn next(&self, on: &[usize], from: &SkinPoint, along: &Vector3<f64>) -> Option<SkinPoint> {
        let next = self.onto(on, &(from.middle - from.normal * PROBE_RADIUS + along * STEP))?;
        let straight = if on.len() > 1 { OVER_A_JOINT } else { STRAIGHT_ON };
        let goes_on =
            (next.middle - from.middle).norm() <= 5.0 * STEP && next.normal.dot(&from.normal) >= straight;
        goes_on.then_some(next)
    }

    /// A way over a limb's skin of a length, metres, from a point near it in a direction, both in the limb's frame; in
    /// the world's frame. `None` if it leaves the limb or comes near another.
    fn way(
        &self,
        limb: usize,
        p_l: &Vector3<f64>,
        along_l: &Vector3<f64>,
        length: f64,
    ) -> Option<Vec<SkinPoint>> {
        let frame = &self.frames[limb];
        let mut spot = self.onto(&[limb], &frame.point(p_l))?;
        let mut along = frame.rotation * along_l;
        let mut way = vec![spot];
        let steps = (length / STEP).ceil() as usize;
        for _ in 0..steps {
            along = spot.along(&along)?;
            spot = self.next(&[limb], &spot, &along)?;
            way.push(spot);
        }
        self.is_free(&[limb], &way).then_some(way)
    }

    /// The distance of a point in the world to the nearest surface of some limbs, the outward normal, and the limb.
    fn distance(&self, on: &[usize], p: &Vector3<f64>) -> Option<(f64, Vector3<f64>, usize)> {
        let surfaces = self.skin.surfaces.iter().filter(|surface| on.contains(&surface.limb));
        let found = surfaces.filter_map(|surface| {
            let frame = &self.frames[surface.limb];
            let (distance, normal) = surface.signed_distance(&frame.inverse_point(p))?;
            Some((distance, frame.rotation * normal, surface.limb))
        });
        found.min_by(|a, b| a.0.total_cmp(&b.0))
    }

    /// Where a probe that touches the nearest of some limbs at a point has its middle; `None` if that is covered by
    /// another, or has no surface.
    pub(super) fn onto(&self, on: &[usize], p: &Vector3<f64>) -> Option<SkinPoint> {
        let mut middle = *p;
        for _ in 0..SETTLES {
            let (distance, normal, limb) = self.distance(on, &middle)?;
            if (distance - PROBE_RADIUS).abs() < 1e-6 {
                return Some(SkinPoint { limb, middle, normal });
            }
            middle -= normal * (distance - PROBE_RADIUS);
        }
        None
    }

    /// Whether a probe gets to every spot of a way over some limbs, clear of all others.
    pub(super) fn is_free(&self, on: &[usize], way: &[SkinPoint]) -> bool {
        way.iter().all(|spot| self.can_come(on, spot, ABOVE, CLEAR))
    }

    /// Whether a probe gets to a spot from so far above it, metres, farther than a distance from limbs that it is not on.
    pub(super) fn can_come(&self, on: &[usize], spot: &SkinPoint, above: f64, clear: f64) -> bool {
        let mut heights = [0.0, 0.25, 0.5, 0.75, 1.0].into_iter().map(|share| share * above);
        heights.all(|height| self.has_room(on, &spot.at(height), clear))
    }

    /// Whether a probe there is farther than a distance from any limb that it is not on, metres.
    pub(super) fn has_room(&self, on: &[usize], p: &Vector3<f64>, clear: f64) -> bool {
        let others = self.skin.surfaces.iter().filter(|surface| !on.contains(&surface.limb));
        others
            .filter_map(|surface| surface.signed_distance(&self.frames[surface.limb].inverse_point(p)))
            .all(|(distance, _)| distance > PROBE_RADIUS + clear)
    }
}

/// What a probe does on a way: comes down to its beginning, touches as the kind has it, with a random force, speed and
/// duration, and leaves.
pub(super) fn laid(kind: TouchKind, way: &[SkinPoint], time: f64, rng: &mut ChaCha8Rng) -> Stimulation {
    let (forces, passes) = match kind {
        TouchKind::Tap => (0.5..4.0, 0..1),
        TouchKind::Press => (0.5..8.0, 0..1),
        TouchKind::Stroke => (0.3..3.0, 1..2),
        TouchKind::Rub => (0.4..4.0, 3..7),
    };
    let force = rng.random_range(forces);
    let depth = force / STIFFNESS;
    let passes = if passes.len() > 1 { rng.random_range(passes) } else { passes.start };
    let (start, end) = (way[0], if passes % 2 == 1 { way[way.len() - 1] } else { way[0] });
    let mut path = vec![(time, start.at(ABOVE)), (time + COMES, start.at(0.005))];
    let mut go = |seconds: f64, p: Vector3<f64>| {
        let now = path[path.len() - 1].0;
        path.push((now + seconds, p));
        now + seconds
    };
    let leaves = match kind {
        TouchKind::Tap => {
            go(rng.random_range(0.02..0.05), start.at(-depth));
            go(rng.random_range(0.0..0.06), start.at(-depth));
            go(0.04, start.at(0.01))
        }
        TouchKind::Press => {
            go(0.05, start.at(-depth));
            go(rng.random_range(0.4..2.0), start.at(-depth));
            go(0.05, start.at(0.01))
        }
        TouchKind::Stroke | TouchKind::Rub => {
            let speed = rng.random_range(SPEED[0]..SPEED[1]);
            let mut pressed = evened_out(way);
            go(0.03, pressed[0].at(-depth));
            for _ in 0..passes {
                for pair in pressed.windows(2) {
                    go((pair[1].middle - pair[0].middle).norm() / speed, pair[1].at(-depth));
                }
                pressed.reverse();
            }
            go(0.03, end.at(0.01))
        }
    };
    go(LEAVES, end.at(ABOVE));
    let mut limbs: Vec<usize> = way.iter().map(|spot| spot.limb).collect();
    limbs.dedup();
    Stimulation { kind, limbs, force, path: ProbePath(path), touching: [time + COMES, leaves] }
}

/// The same way with the normals of a crease evened out over a few steps, in which a probe rolls from one side of it to
/// the other.
pub(super) fn evened_out(way: &[SkinPoint]) -> Vec<SkinPoint> {
    let evened = |(k, spot): (usize, &SkinPoint)| {
        let around = &way[k.saturating_sub(EVENED_OUT)..(k + EVENED_OUT + 1).min(way.len())];
        let sum: Vector3<f64> = around.iter().map(|spot| spot.normal).sum();
        SkinPoint { normal: sum.try_normalize(1e-6).unwrap_or(spot.normal), ..*spot }
    };
    way.iter().enumerate().map(evened).collect()
}
