//! Random stimulations of the skin: taps, presses, strokes and rubs by a probe.

use std::f64::consts::TAU;

use nalgebra::Vector3;
use rand::RngExt;
use rand::seq::IndexedRandom;
use rand_chacha::ChaCha8Rng;

use crate::geometry::Frame;
use crate::senses::TouchKind;
use crate::simulation::{PROBE_RADIUS, ProbePath, STIFFNESS, Stage};
use crate::skin::Skin;

/// From how far above the skin a probe comes, metres.
const ABOVE: f64 = 0.04;
/// How far a probe keeps from all other limbs, metres.
const CLEAR: f64 = 0.004;
/// Steps in which a way over the skin is laid, metres.
pub(super) const STEP: f64 = 0.002;
/// Places tried for one stimulation.
pub(super) const TRIES: usize = 2000;

/// A stimulation that is done to the creature.
#[derive(Clone, Debug, PartialEq)]
pub struct Stimulation {
    /// What kind it is.
    pub kind: TouchKind,
    /// The limb.
    pub limb: usize,
    /// The force that the probe is pressed with, newtons.
    pub force: f64,
    /// The way of its middle, from when it sets out.
    pub path: ProbePath,
}

/// The skin of a creature in its posture, as ways over it need it.
pub struct Strokes<'a> {
    pub(super) skin: &'a Skin,
    /// Per limb, `X_WL`.
    pub(super) frames: Vec<Frame>,
}

/// A point above the skin at a probe's radius, and the outward normal.
pub(super) type SkinPoint = (Vector3<f64>, Vector3<f64>);

impl<'a> Strokes<'a> {
    /// Looks at the creature where the stage's last step left it.
    pub fn new(stage: &'a Stage) -> Strokes<'a> {
        Strokes { skin: stage.skin(), frames: stage.limb_frames() }
    }

    /// A random stimulation of a kind, setting out at `time`: limbs are drawn alike, then a place of their skin, a
    /// direction, a speed, a force. None where no limb has room for it.
    pub fn random(&self, kind: TouchKind, time: f64, rng: &mut ChaCha8Rng) -> Option<Stimulation> {
        let skin = self.skin;
        let mut limbs: Vec<usize> = skin.receptors.iter().map(|receptor| receptor.limb).collect();
        limbs.sort_unstable();
        limbs.dedup();
        (0..TRIES).find_map(|_| {
            let limb = *limbs.choose(rng)?;
            let on_limb: Vec<usize> =
                (0..skin.receptors.len()).filter(|&r| skin.receptors[r].limb == limb).collect();
            let receptor = *on_limb.choose(rng)?;
            self.at(kind, receptor, time, rng)
        })
    }

    /// A random stimulation of a kind that begins on a receptor; none where there is no room.
    pub fn at(
        &self,
        kind: TouchKind,
        receptor: usize,
        time: f64,
        rng: &mut ChaCha8Rng,
    ) -> Option<Stimulation> {
        let receptor = &self.skin.receptors[receptor];
        let limb = receptor.limb;
        let length = match kind {
            TouchKind::Tap | TouchKind::Press => 0.0,
            TouchKind::Stroke => rng.random_range(0.03..0.15),
            TouchKind::Rub => rng.random_range(0.02..0.06),
        };
        let place = |half: f64, rng: &mut ChaCha8Rng| 0.7 * half * rng.random_range(-1.0..1.0);
        let p_l = receptor.position
            + receptor.tangent * place(receptor.half_extents[0], rng)
            + receptor.bitangent() * place(receptor.half_extents[1], rng);
        let angle = rng.random_range(0.0..TAU);
        let along = receptor.tangent * angle.cos() + receptor.bitangent() * angle.sin();
        let way = self.way(limb, &p_l, &along, length)?;
        let force = match kind {
            TouchKind::Tap => rng.random_range(0.5..4.0),
            TouchKind::Press => rng.random_range(0.5..8.0),
            TouchKind::Stroke => rng.random_range(0.3..3.0),
            TouchKind::Rub => rng.random_range(0.4..4.0),
        };
        let depth = force / STIFFNESS;
        let passes = match kind {
            TouchKind::Tap | TouchKind::Press => 0,
            TouchKind::Stroke => 1,
            TouchKind::Rub => rng.random_range(3..7),
        };
        let end = if passes % 2 == 1 { way[way.len() - 1] } else { way[0] };
        let at = |(p, n): &SkinPoint, height: f64| p + n * height;
        let mut path = vec![(time, at(&way[0], ABOVE))];
        let mut now = time + 0.25;
        path.push((now, at(&way[0], 0.005)));
        let mut go = |seconds: f64, p: Vector3<f64>, path: &mut Vec<(f64, Vector3<f64>)>| {
            now += seconds;
            path.push((now, p));
        };
        match kind {
            TouchKind::Tap => {
                go(rng.random_range(0.02..0.05), at(&way[0], -depth), &mut path);
                go(rng.random_range(0.0..0.06), at(&way[0], -depth), &mut path);
                go(0.04, at(&way[0], 0.01), &mut path);
            }
            TouchKind::Press => {
                go(0.05, at(&way[0], -depth), &mut path);
                go(rng.random_range(0.4..2.0), at(&way[0], -depth), &mut path);
                go(0.05, at(&way[0], 0.01), &mut path);
            }
            TouchKind::Stroke | TouchKind::Rub => {
                let speed = rng.random_range(0.05..0.4);
                go(0.03, at(&way[0], -depth), &mut path);
                for pass in 0..passes {
                    let spots: Vec<&SkinPoint> =
                        if pass % 2 == 0 { way.iter().collect() } else { way.iter().rev().collect() };
                    for pair in spots.windows(2) {
                        let seconds = (pair[1].0 - pair[0].0).norm() / speed;
                        go(seconds, at(pair[1], -depth), &mut path);
                    }
                }
                go(0.03, at(&end, 0.01), &mut path);
            }
        }
        go(0.2, at(&end, ABOVE), &mut path);
        Some(Stimulation { kind, limb, force, path: ProbePath(path) })
    }

    /// A step on over a limb's skin; none over an edge or into a fold, where the way would jump.
    pub(super) fn next(
        &self,
        limb: usize,
        (p, normal): &SkinPoint,
        along: &Vector3<f64>,
    ) -> Option<SkinPoint> {
        let next = self.onto(limb, &(p - normal * PROBE_RADIUS + along * STEP))?;
        ((next.0 - p).norm() <= 5.0 * STEP && next.1.dot(normal) >= 0.7).then_some(next)
    }

    /// A way over a limb's skin of a length, metres, from a point near it in a direction, both in the limb's frame; in
    /// the world's frame. None where it leaves the limb or comes near another.
    fn way(
        &self,
        limb: usize,
        p_l: &Vector3<f64>,
        along_l: &Vector3<f64>,
        length: f64,
    ) -> Option<Vec<SkinPoint>> {
        let frame = &self.frames[limb];
        let mut p = self.onto(limb, &frame.point(p_l))?;
        let mut along = frame.rotation * along_l;
        let mut way = vec![p];
        let steps = (length / STEP).ceil() as usize;
        for _ in 0..steps {
            along = (along - p.1 * along.dot(&p.1)).try_normalize(1e-6)?;
            p = self.next(limb, &p, &along)?;
            way.push(p);
        }
        let free = way.iter().all(|spot| self.is_free(limb, spot, ABOVE, CLEAR));
        free.then_some(way)
    }

    /// The distance of a point in the world to a limb's surface, and the outward normal.
    fn distance(&self, limb: usize, p: &Vector3<f64>) -> Option<(f64, Vector3<f64>)> {
        let frame = &self.frames[limb];
        let p_l = frame.inverse_point(p);
        let surfaces = self.skin.surfaces.iter().filter(|surface| surface.limb == limb);
        let found = surfaces.filter_map(|surface| surface.signed_distance(&p_l));
        let (distance, normal) = found.min_by(|a, b| a.0.total_cmp(&b.0))?;
        Some((distance, frame.rotation * normal))
    }

    /// Where a probe that touches the limb nearest to a point has its middle, and the normal there; none where the
    /// limb is covered by another, or has no receptor.
    pub(super) fn onto(&self, limb: usize, p: &Vector3<f64>) -> Option<SkinPoint> {
        let mut p = *p;
        let mut normal = Vector3::zeros();
        for _ in 0..20 {
            let (distance, outward) = self.distance(limb, &p)?;
            normal = outward;
            p -= outward * (distance - PROBE_RADIUS);
        }
        let (distance, _) = self.distance(limb, &p)?;
        ((distance - PROBE_RADIUS).abs() < 1e-5).then_some((p, normal))
    }

    /// Whether a probe gets to a spot from so far above it, metres, farther than a distance from any other limb.
    pub(super) fn is_free(&self, limb: usize, (p, normal): &SkinPoint, above: f64, clear: f64) -> bool {
        let mut heights = [0.0, 0.25, 0.5, 0.75, 1.0].into_iter().map(|share| share * above);
        heights.all(|height| self.has_room(limb, &(p + normal * height), clear))
    }

    /// Whether a probe there is farther than a distance from any other limb, metres.
    pub(super) fn has_room(&self, limb: usize, p: &Vector3<f64>, clear: f64) -> bool {
        (0..self.frames.len())
            .filter(|&other| other != limb)
            .all(|other| self.distance(other, p).is_none_or(|(distance, _)| distance > PROBE_RADIUS + clear))
    }
}
