//! What a skin of receptors really says: the two limbs' surfaces touch, within the two patches.
//!
//! A receptor reports no point. But the agent knows the surface under each patch, in the limb's own frame,
//! and where two limbs touch the gap between their surfaces is zero: one equation as sharp as the contact
//! itself. Where on the patches it happened is known only to lie inside them: four weak equations, the
//! contact's offset from each patch's centre along its sides, with the deviation of a uniform
//! distribution.

use nalgebra::{Matrix3, Vector3};

use crate::kinematics::Frame;
use crate::learning::observation::{Observation, ObservationModel, Residuals};
use crate::skin::{Shape, Skin, Surface, closest};

/// Residuals beyond this many deviations count ever less (Cauchy weights).
pub const TAIL: f64 = 3.0;
/// Mean of the weights, `E[1 / (1 + z²/TAIL²)]`, over a standard normal `z`. Weighted normal equations hold
/// this share of the information `JᵀJ/σ²` that there is in normal noise. For the contact's place in a patch,
/// uniform and not normal, the mean is `√3 arctan(1/√3) = 0.907`: as good as the same.
pub const MEAN_WEIGHT: f64 = 0.913771;
/// `E[w²] / E[w²z²]` over a standard normal `z`, with the weights `w` above: what makes a weighted variance
/// agree with the deviation of normal noise.
const VARIANCE_FACTOR: f64 = 1.363449;

/// Deviation of the contact's place in a patch, in units of a uniform distribution's, where the last word is
/// spoken. A patch is touched again and again on the same side: its places are biased, and a bias does not
/// average out as the model has it. On Max, at gaps of 1 mm, places at their full weight hold 3 % of the
/// information, add 16 % to the error, and leave the intervals too short.
pub const BIASED_PLACES: f64 = 3.0;
/// Most steps to the fixed point of a scale.
const SCALE_ITERATIONS: usize = 100;

/// The gap of the two surfaces, and the contact inside both patches.
#[derive(Clone, Copy, Debug)]
pub struct SurfaceGap<'a> {
    /// The skin.
    pub skin: &'a Skin,
    /// Standard deviation of the gap, metres.
    pub gap_deviation: f64,
    /// Standard deviation of the contact's place in a patch, in units of a uniform distribution's.
    pub patch_deviation: f64,
}

/// Where two surfaces come closest.
#[derive(Clone, Copy, Debug)]
pub struct Meeting {
    /// Distance between the surfaces, negative where they overlap, metres.
    pub gap: f64,
    /// Unit normal from the second surface to the first, in the ancestor's frame.
    pub normal: Vector3<f64>,
    /// The middle between the closest points, in the ancestor's frame, metres.
    pub point: Vector3<f64>,
}

impl<'a> SurfaceGap<'a> {
    /// The model with a deviation of the gap, metres, and uniform places in the patches.
    pub fn new(skin: &'a Skin, gap_deviation: f64) -> SurfaceGap<'a> {
        SurfaceGap { skin, gap_deviation, patch_deviation: 1.0 }
    }

    /// The same with places in the patches that count less; see [`BIASED_PLACES`].
    pub fn with_biased_places(self) -> SurfaceGap<'a> {
        SurfaceGap { patch_deviation: BIASED_PLACES, ..self }
    }

    /// Where the surfaces under two receptors come closest, given their limbs' frames `X_CA`, `X_CB`.
    pub fn meeting(&self, ends: &[Observation; 2], frames: &[Frame; 2]) -> Meeting {
        let surfaces =
            [0, 1].map(|k| self.skin.receptors[ends[k].receptor].surface.map(|s| &self.skin.surfaces[s]));
        if let [Some(a), Some(b)] = surfaces
            && let (Some(first), Some(second)) = (segment(a, &frames[0]), segment(b, &frames[1]))
        {
            return swept_segments(&first, &second);
        }
        let receptors = [0, 1].map(|k| &self.skin.receptors[ends[k].receptor]);
        let distance = |k: usize, p_c: &Vector3<f64>| {
            let local = frames[k].inverse_point(p_c);
            // A surface that is known only by its receptors is flat under each of them.
            let (gap, normal) = surfaces[k]
                .and_then(|surface| surface.signed_distance(&local))
                .unwrap_or_else(|| (receptors[k].patch_coordinates(&local).z, receptors[k].normal));
            (gap, frames[k].rotation * normal)
        };
        // A sphere or capsule against anything else: its axis' nearest point is all there is to find.
        for k in [0, 1] {
            if let Some(swept) = surfaces[k].and_then(|surface| segment(surface, &frames[k])) {
                return swept_segment(&swept, |p_c| distance(1 - k, p_c)).seen_from(k);
            }
        }
        let centres = [0, 1].map(|k| frames[k].point(&receptors[k].position));
        let normals = [0, 1].map(|k| frames[k].rotation * receptors[k].normal);
        let support = |k: usize, d: &Vector3<f64>| {
            Some(frames[k].point(&surfaces[k]?.support(&frames[k].rotation.tr_mul(d))?))
        };
        match [0, 1].map(|k| support(k, &normals[k]).is_some()) {
            [true, true] => {
                let solid = |k: usize, d: &Vector3<f64>| support(k, d).expect("it has a farthest point");
                let found = closest([&|d| solid(0, d), &|d| solid(1, d)], &normals[1]);
                let point = 0.5 * (found.points[0] + found.points[1]);
                Meeting { gap: found.distance, normal: found.normal, point }
            }
            // Two flat patches say little more than that their centres are near.
            [false, false] => {
                let normal = (normals[1] - normals[0]).try_normalize(1e-9).unwrap_or(normals[1]);
                let gap = normal.dot(&(centres[0] - centres[1]));
                Meeting { gap, normal, point: 0.5 * (centres[0] + centres[1]) }
            }
            [first, _] => {
                // The solid's lowest point over the flat patch.
                let k = usize::from(!first);
                let normal = normals[1 - k];
                let lowest = support(k, &-normal).expect("it has a farthest point");
                let gap = distance(1 - k, &lowest).0;
                Meeting { gap, normal, point: lowest - normal * (0.5 * gap) }.seen_from(k)
            }
        }
    }
}

impl Meeting {
    /// A meeting whose normal leads to the `k`-th of two surfaces, with one that leads to the first.
    fn seen_from(self, k: usize) -> Meeting {
        Meeting { normal: if k == 0 { self.normal } else { -self.normal }, ..self }
    }
}

/// A sphere or capsule as a segment and a radius, in the ancestor's frame.
struct Swept {
    ends: [Vector3<f64>; 2],
    radius: f64,
}

fn segment(surface: &Surface, frame: &Frame) -> Option<Swept> {
    let (radius, half_length) = match surface.shape {
        Shape::Sphere { radius } => (radius, 0.0),
        Shape::Capsule { radius, half_length } => (radius, half_length),
        _ => return None,
    };
    let along: Vector3<f64> = surface.rotation.column(2) * half_length;
    let ends = [surface.origin - along, surface.origin + along].map(|end| frame.point(&end));
    Some(Swept { ends, radius })
}

fn swept_segments(a: &Swept, b: &Swept) -> Meeting {
    let [p, q] = crate::kinematics::closest_points(&a.ends, &b.ends);
    let between = p - q;
    let distance = between.norm();
    let normal = if distance > 1e-12 { between / distance } else { Vector3::z() };
    let point = 0.5 * (p - normal * a.radius + q + normal * b.radius);
    Meeting { gap: distance - a.radius - b.radius, normal, point }
}

/// A swept segment against a convex surface given by its signed distance: along the segment the distance is
/// convex, and its least is the gap. The normal is outward of the surface.
fn swept_segment(a: &Swept, distance: impl Fn(&Vector3<f64>) -> (f64, Vector3<f64>)) -> Meeting {
    let along = a.ends[1] - a.ends[0];
    let at = |t: f64| {
        let p = a.ends[0] + along * t;
        let (distance, normal) = distance(&p);
        (p, distance, normal, normal.dot(&along))
    };
    let (first, second) = (at(0.0), at(1.0));
    let found = if first.3 >= 0.0 {
        first
    } else if second.3 <= 0.0 {
        second
    } else {
        // The root of the slope, by regula falsi with the Illinois rule: it cannot leave its bracket.
        let (mut low, mut high) = ((0.0, first.3), (1.0, second.3));
        let mut found = first;
        let mut kept = 0;
        for _ in 0..60 {
            let t = (low.0 * high.1 - high.0 * low.1) / (high.1 - low.1);
            found = at(t);
            if found.3.abs() * (high.0 - low.0) < 1e-13 {
                break;
            }
            if found.3 < 0.0 {
                low = (t, found.3);
                high.1 *= if kept < 0 { 0.5 } else { 1.0 };
                kept = -1;
            } else {
                high = (t, found.3);
                low.1 *= if kept > 0 { 0.5 } else { 1.0 };
                kept = 1;
            }
        }
        found
    };
    let (p, distance, normal, _) = found;
    Meeting { gap: distance - a.radius, normal, point: p - normal * (0.5 * (distance + a.radius)) }
}

impl ObservationModel for SurfaceGap<'_> {
    fn whitening(&self, _: &[Observation; 2], _: &[Frame; 2]) -> Matrix3<f64> {
        Matrix3::identity()
    }

    fn residuals(&self, ends: &[Observation; 2], frames: &[Frame; 2], whitening: &Matrix3<f64>) -> Residuals {
        let meeting = self.meeting(ends, frames);
        let points = [0, 1].map(|k| frames[k].inverse_point(&meeting.point));
        let mut residuals = Residuals::new(points);
        // One over how much wider than another's the touch's gap may be.
        let gap_deviation = self.gap_deviation / whitening[(0, 0)];
        let gap = meeting.gap / gap_deviation;
        let weight = 1.0 / (1.0 + (gap / TAIL).powi(2)).sqrt();
        residuals.push(meeting.normal * (weight / gap_deviation), gap * weight);
        for (k, offset, deviation, direction) in self.offsets(ends, &points) {
            let value = offset / deviation;
            let weight = 1.0 / (1.0 + (value / TAIL).powi(2)).sqrt();
            // The contact moves over a patch as the other limb moves against it.
            let sign = if k == 0 { -1.0 } else { 1.0 };
            residuals.push(frames[k].rotation * direction * (sign * weight / deviation), value * weight);
        }
        residuals
    }

    fn cost(&self, ends: &[Observation; 2], frames: &[Frame; 2], whitening: &Matrix3<f64>) -> f64 {
        let meeting = self.meeting(ends, frames);
        let points = [0, 1].map(|k| frames[k].inverse_point(&meeting.point));
        let mut cost = tailed(meeting.gap / self.gap_deviation * whitening[(0, 0)]);
        for (_, offset, deviation, _) in self.offsets(ends, &points) {
            cost += tailed(offset / deviation);
        }
        cost
    }
}

impl SurfaceGap<'_> {
    /// Per side of each patch: the end, the contact's offset and its deviation in metres, the direction in
    /// the limb's frame.
    fn offsets(
        &self,
        ends: &[Observation; 2],
        points: &[Vector3<f64>; 2],
    ) -> [(usize, f64, f64, Vector3<f64>); 4] {
        let side = |k: usize, second: bool| {
            let receptor = &self.skin.receptors[ends[k].receptor];
            let direction = if second { receptor.bitangent() } else { receptor.tangent };
            let half = receptor.half_extents[usize::from(second)];
            let offset = (points[k] - receptor.position).dot(&direction);
            (k, offset, self.patch_deviation * half / 3f64.sqrt(), direction)
        };
        [side(0, false), side(0, true), side(1, false), side(1, true)]
    }
}

/// Standard deviation of normal gaps, some of them wild, that parameters were fitted to, metres.
///
/// An M-estimate of scale: the root of `σ² = k Σ w²r² (1 − h) / Σ w²(1 − h)` over the standardized gaps
/// `r = g / √(1 − h)`, with their weights `w` at σ and the constant k that makes it agree with a normal
/// distribution. A gap `g` whose share `h` the fit takes up (its leverage) is that much the smaller, and tells
/// that much less (Maronna, Martin and Yohai, Robust Statistics, 2006, sections 2.5 and 5.1). Each of `gaps`
/// is a gap in metres and its leverage. `start` must be of the right size.
pub fn gap_scale(gaps: &[(f64, f64)], start: f64) -> f64 {
    let mut deviation = start;
    for _ in 0..SCALE_ITERATIONS {
        let (mut squares, mut count) = (0.0, 0.0);
        for (gap, leverage) in gaps {
            let left = (1.0 - leverage).clamp(1e-9, 1.0);
            let weight = 1.0 / (1.0 + gap * gap / (left * (TAIL * deviation).powi(2)));
            squares += (weight * gap).powi(2);
            count += weight * weight * left;
        }
        let next = (VARIANCE_FACTOR * squares / count).sqrt();
        if !(next.is_finite() && next > 0.0) {
            return deviation;
        }
        let settled = (next / deviation - 1.0).abs() < 1e-6;
        deviation = next;
        if settled {
            break;
        }
    }
    deviation
}

/// Cauchy's cost, quadratic near zero.
fn tailed(residual: f64) -> f64 {
    0.5 * TAIL * TAIL * (residual / TAIL).powi(2).ln_1p()
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;
    use rand_distr::{Distribution, StandardNormal};

    fn normal(rng: &mut ChaCha8Rng) -> f64 {
        StandardNormal.sample(rng)
    }

    #[test]
    fn the_scale_is_that_of_normal_gaps_whatever_their_leverage_and_a_tenth_of_wild_ones() {
        let mut rng = ChaCha8Rng::seed_from_u64(1);
        let leverages: Vec<f64> = (0..20_000).map(|_| rng.random_range(0.0..0.5)).collect();
        let mut gaps: Vec<(f64, f64)> =
            leverages.into_iter().map(|h| (1e-4 * normal(&mut rng) * (1.0 - h).sqrt(), h)).collect();
        let scale = gap_scale(&gaps, 2e-4);
        assert!((scale / 1e-4 - 1.0).abs() < 0.02, "{scale}");
        for gap in gaps.iter_mut().step_by(10) {
            gap.0 = 0.05;
        }
        let scale = gap_scale(&gaps, 2e-4);
        assert!((scale / 1e-4 - 1.0).abs() < 0.02, "{scale} with false touches");
        assert_eq!(gap_scale(&[], 1e-6), 1e-6);
        assert_eq!(gap_scale(&[(0.0, 0.0)], 1e-6), 1e-6);
    }

    #[test]
    fn the_gap_over_a_convex_surface_is_that_of_the_balls_that_they_are() {
        let mut rng = ChaCha8Rng::seed_from_u64(2);
        for gap in [-1e-3, -1e-4, 0.0, 1e-6, 1e-4, 1e-3, 0.01] {
            let direction = Vector3::from_fn(|_, _| normal(&mut rng)).normalize();
            let middle = direction * (0.08 + gap);
            let shape = Shape::Ellipsoid { semi_axes: [0.05; 3] };
            let swept = Swept { ends: [middle; 2], radius: 0.03 };
            let found = swept_segment(&swept, |p| shape.signed_distance(p).unwrap());
            assert!((found.gap - gap).abs() < 1e-8, "{} in place of {gap}", found.gap);
            assert!((found.normal - direction).norm() < 1e-9);
        }
    }

    #[test]
    fn a_capsule_over_an_ellipsoid_is_as_near_as_its_nearest_point() {
        let mut rng = ChaCha8Rng::seed_from_u64(3);
        let shape = Shape::Ellipsoid { semi_axes: [0.2, 0.03, 0.05] };
        for _ in 0..50 {
            let ends = [0, 1].map(|_| Vector3::from_fn(|_, _| 0.3 * normal(&mut rng)));
            let swept = Swept { ends, radius: 0.02 };
            let found = swept_segment(&swept, |p| shape.signed_distance(p).unwrap());
            let along = |k: usize| ends[0] + (ends[1] - ends[0]) * (k as f64 / 1000.0);
            let sampled = (0..=1000).map(|k| shape.signed_distance(&along(k)).unwrap().0 - 0.02);
            let least = sampled.fold(f64::INFINITY, f64::min);
            assert!(found.gap <= least + 1e-9 && found.gap > least - 1e-3, "{} and {least}", found.gap);
        }
    }
}
