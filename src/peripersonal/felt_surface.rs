//! Where a limb is touched, and by what a surface, from receptors alone: of many places on the patch and many surfaces
//! there those are kept that agree with where the limb was when it began to feel and when it felt nothing.
//!
//! A thing is taken for a capsule about where it was met, of any radius and of no length or [`HALF_LENGTH`]: a corner, an
//! edge, a ball, a rod or, with a great radius, a face. Its surface touches the limb's at the place, so that both have one
//! normal there, which the limb's shape tells.

use std::f64::consts::PI;

use nalgebra::Vector3;
use rand::{Rng, RngExt};

use super::own_body::OwnBody;
use crate::geometry::{Capsule, Frame, Precision, gap};
use crate::kinematics::Place;
use crate::skin::{Skin, Surface};

/// Surfaces that are weighed in the first round …
const FIRST: usize = 5000;
/// … and in each of the others.
const OTHERS: usize = 1200;
/// The standard deviation of a gap that should be none, metres, by round: great ones first, so that no place is lost whose
/// neighbour is right. The last is of the order of a step of a limb that feels.
const DEVIATIONS: [f64; 5] = [2e-3, 1e-3, 5e-4, 2.5e-4, 1.5e-4];
/// By how much a surface is changed from one round to the next, in shares of the patch, of a turn, and of a power of ten of
/// its radius.
const CHANGES: [f64; 5] = [0.0, 0.15, 0.06, 0.025, 0.01];
/// How far beyond a patch's border it may still be that which fires, metres.
const BORDER: f64 = 1e-3;
/// Half the length of an edge or a rod: longer than what small motions bring to touch, metres.
const HALF_LENGTH: f64 = 0.03;
/// The radii that things may have, metres: from that of a corner to that of a face.
const RADII: [f64; 2] = [1e-3, 1.0];
/// Surfaces of the limb no farther than this from the patch may touch the thing, too, metres.
const NEAR: f64 = 0.04;
/// No touch counts for more than this against a surface, squared standard deviations.
const WORST: f64 = 64.0;
/// A touch is explained where the gap is within so many standard deviations, and the border as far.
const EXPLAINED: f64 = 4.0;
/// Fewer touches than this do not tell, for as many things are not known of a surface.
const ENOUGH: usize = 5;
/// Where fewer touches are explained than this share, the thing is none of those that were thought of.
const MOST: f64 = 0.6;
/// How far a limb may be in a thing that it did not come to by itself, metres.
const DEEPEST: f64 = 3e-3;
/// How far a limb may be in a thing when it is felt, metres: a step.
const STEP_IN: f64 = 5e-4;

/// A limb's pose `X_RL` in the root's frame in which it began to feel with a receptor, or felt nothing.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FeltPose {
    /// Where the limb was.
    pub limb: Frame,
    /// What began to feel.
    pub receptor: Option<usize>,
}

/// A surface that touches a limb.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FeltSurface {
    /// Where it touches in the limb's frame, and the limb's outward normal there.
    pub place: Place,
    /// Where that was in the root's frame, metres.
    pub point: Vector3<f64>,
    /// The unit direction into the thing, in the root's frame.
    pub direction: Vector3<f64>,
    /// How surely the point is known: one standard deviation, metres.
    pub deviation: f64,
}

/// One surface that may be there.
#[derive(Clone, Copy, Debug)]
struct Possible {
    /// Where on the patch, in shares of its half sides.
    at: [f64; 2],
    radius: f64,
    half_length: f64,
    /// Where its length leads, about the normal.
    angle: f64,
    /// How far the limb is in it at first, metres.
    depth: f64,
}

impl FeltSurface {
    /// What is felt at a place of a limb that is at `first`, as far as the place is known: not to better than a deviation.
    pub fn at(place: Place, first: &Frame, deviation: f64) -> FeltSurface {
        let (point, direction) = (first.point(&place.point), first.direction(&place.direction));
        FeltSurface { place, point, direction, deviation }
    }

    /// What a receptor feels whose limb is at `first`, by the poses before and after; `None` if the skin's surface is not
    /// known. How surely it is known two draws of surfaces tell.
    pub fn of(
        own: &OwnBody,
        receptor: usize,
        first: &Frame,
        poses: &[FeltPose],
        rng: &mut impl Rng,
    ) -> Option<FeltSurface> {
        let [one, other] = [0; 2].map(|_| FeltSurface::drawn(own, receptor, first, poses, rng));
        let (one, other) = (one?, other?);
        let apart = (one.point - other.point).norm();
        let surest = if one.deviation <= other.deviation { one } else { other };
        Some(FeltSurface { deviation: surest.deviation.max(apart), ..surest })
    }

    fn drawn(
        own: &OwnBody,
        receptor: usize,
        first: &Frame,
        poses: &[FeltPose],
        rng: &mut impl Rng,
    ) -> Option<FeltSurface> {
        let near = surfaces_near(own.skin(), receptor);
        let felt = Felt { skin: own.skin(), receptor, near: &near, first, poses };
        let mut possible: Vec<Possible> = (0..FIRST).map(|_| Possible::drawn(rng)).collect();
        let mut weighed: Vec<(f64, Possible, Place)> = Vec::new();
        // Without touches there is little to tell surfaces apart by.
        let rounds = if poses.iter().any(|pose| pose.receptor.is_some()) { DEVIATIONS.len() } else { 1 };
        for (round, deviation) in DEVIATIONS.into_iter().take(rounds).enumerate() {
            if round > 0 {
                let total: f64 = weighed.iter().map(|(weight, ..)| weight).sum();
                possible.clear();
                // Drawn evenly along the sum of weights: those that weigh much are drawn often.
                let (mut sum, mut next) = (0.0, 0.0);
                for (weight, one, _) in &weighed {
                    sum += weight / total * OTHERS as f64;
                    while next < sum {
                        possible.push(one.changed(CHANGES[round], rng));
                        next += 1.0;
                    }
                }
            }
            let miss = |one: &Possible| {
                let place = one.place(own, receptor)?;
                Some((one.miss(&felt, &place, deviation).0, *one, place))
            };
            weighed = possible.iter().filter_map(miss).collect();
            let least = weighed.iter().map(|(miss, ..)| *miss).fold(f64::INFINITY, f64::min);
            if !least.is_finite() {
                return None;
            }
            weighed.iter_mut().for_each(|(miss, ..)| *miss = (-0.5 * (*miss - least)).exp());
        }
        let best = weighed.iter().max_by(|a, b| a.0.total_cmp(&b.0))?;
        let explained = best.1.miss(&felt, &best.2, DEVIATIONS[DEVIATIONS.len() - 1]).1;
        let touches = poses.iter().filter(|pose| pose.receptor.is_some()).count();
        let total: f64 = weighed.iter().map(|(weight, ..)| weight).sum();
        let point =
            weighed.iter().map(|(weight, _, place)| place.point * *weight).sum::<Vector3<f64>>() / total;
        let spread: f64 = weighed.iter().map(|(w, _, place)| w * (place.point - point).norm_squared()).sum();
        let place = own.on_surface(receptor, &point)?;
        Some(FeltSurface {
            place,
            point: first.point(&place.point),
            direction: first.direction(&place.direction),
            deviation: match touches >= ENOUGH && explained as f64 >= MOST * touches as f64 {
                true => (spread / total).sqrt(),
                false => own.skin().receptors[receptor].covariance(0.0).trace().sqrt(),
            },
        })
    }
}

impl Possible {
    fn drawn(rng: &mut impl Rng) -> Possible {
        let [low, high] = RADII.map(f64::ln);
        Possible {
            at: [rng.random_range(-1.0..1.0), rng.random_range(-1.0..1.0)],
            radius: if rng.random_bool(0.3) { RADII[0] } else { rng.random_range(low..high).exp() },
            half_length: if rng.random_bool(0.5) { 0.0 } else { HALF_LENGTH },
            angle: rng.random_range(0.0..PI),
            depth: rng.random_range(0.0..DEEPEST),
        }
    }

    fn changed(&self, by: f64, rng: &mut impl Rng) -> Possible {
        let mut change = |by: f64| rng.random_range(-by..by);
        let [low, high] = RADII;
        Possible {
            at: self.at.map(|at| (at + change(by)).clamp(-1.0, 1.0)),
            radius: (self.radius * 10f64.powf(change(2.0 * by))).clamp(low, high),
            angle: self.angle + change(PI * by),
            depth: (self.depth + change(DEEPEST * by)).clamp(0.0, DEEPEST),
            ..*self
        }
    }

    /// Where it touches; `None` if the patch reaches beyond the limb there.
    fn place(&self, own: &OwnBody, receptor: usize) -> Option<Place> {
        own.on_surface(receptor, &own.skin().receptors[receptor].patch_point(self.at))
    }

    /// How badly it agrees with what was felt, in squared standard deviations, and how many of the touches it explains.
    fn miss(&self, felt: &Felt, place: &Place, deviation: f64) -> (f64, usize) {
        let Felt { skin, receptor, near, first, poses } = *felt;
        let (point, normal) = (first.point(&place.point), first.direction(&place.direction));
        let across = normal.cross(&first.direction(&skin.receptors[receptor].tangent));
        let Some(across) = across.try_normalize(1e-9) else { return (f64::INFINITY, 0) };
        let along = (across * self.angle.cos() + normal.cross(&across) * self.angle.sin()) * self.half_length;
        let centre = point + normal * (self.radius - self.depth);
        let thing = Capsule { ends: [centre - along, centre + along], radius: self.radius };
        let border = BORDER.max(deviation);
        // The limb is in the thing by no more than a step, nowhere.
        let inside = |limb: &Frame, allowed: f64| {
            let gaps = near.iter().filter_map(|&surface| {
                Some(gap(&skin.surfaces[surface].placed(limb)?, &thing, Precision::Exact).distance)
            });
            (gaps.fold(f64::INFINITY, f64::min) + allowed).min(0.0).powi(2) / deviation.powi(2)
        };
        let mut miss = (outside(skin, receptor, &place.point) / border).powi(2)
            + inside(first, STEP_IN + self.depth).min(WORST);
        let mut explained = 0;
        for pose in poses {
            miss += inside(&pose.limb, STEP_IN).min(WORST);
            let Some(feels) = pose.receptor else { continue };
            let surface = skin.receptors[feels].surface.map(|surface| &skin.surfaces[surface]);
            let Some(surface) = surface.and_then(|surface| surface.placed(&pose.limb)) else { continue };
            let gap = gap(&surface, &thing, Precision::Exact);
            let met = outside(skin, feels, &pose.limb.inverse_point(&gap.points[0]));
            let squares = [gap.distance / deviation, met / border].map(|x| x * x);
            explained += usize::from(squares.iter().all(|square| *square < EXPLAINED * EXPLAINED));
            // What is far off does not weigh more and more: it may have been met by another part of the thing.
            miss += squares.iter().map(|square| square.min(WORST)).sum::<f64>();
        }
        (miss, explained)
    }
}

/// What was felt, and the surfaces of the limb that are near.
#[derive(Clone, Copy)]
struct Felt<'a> {
    skin: &'a Skin,
    receptor: usize,
    near: &'a [usize],
    first: &'a Frame,
    poses: &'a [FeltPose],
}

/// The surfaces of a receptor's limb that are near its patch.
fn surfaces_near(skin: &Skin, receptor: usize) -> Vec<usize> {
    let patch = &skin.receptors[receptor];
    let near = |surface: &Surface| {
        let away = surface.signed_distance(&patch.position).map_or(f64::INFINITY, |(distance, _)| distance);
        surface.limb == patch.limb && away < NEAR
    };
    (0..skin.surfaces.len()).filter(|&surface| near(&skin.surfaces[surface])).collect()
}

/// How far a point of a limb is outside of where a receptor is the one that fires, metres: beyond its border, or nearer to
/// another that has it, too.
fn outside(skin: &Skin, receptor: usize, p_l: &Vector3<f64>) -> f64 {
    let patch = &skin.receptors[receptor];
    let at = patch.patch_coordinates(p_l);
    let beyond = (at.x.abs() - patch.half_extents[0]).max(at.y.abs() - patch.half_extents[1]).max(0.0);
    let others = skin.receptors.iter().enumerate().filter(|(other, found)| {
        *other != receptor && found.limb == patch.limb && found.surface == patch.surface && found.holds(p_l)
    });
    let nearer = others.map(|(_, other)| {
        let between = (other.position - patch.position).norm().max(1e-6);
        ((p_l - patch.position).norm_squared() - (p_l - other.position).norm_squared()) / (2.0 * between)
    });
    nearer.fold(beyond, f64::max)
}
