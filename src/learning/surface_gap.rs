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
use crate::skin::{Shape, Skin, Surface};

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
        let centres = [0, 1].map(|k| frames[k].point(&self.skin.receptors[ends[k].receptor].position));
        let distance = |k: usize, p_c: &Vector3<f64>| {
            let local = frames[k].inverse_point(p_c);
            let receptor = &self.skin.receptors[ends[k].receptor];
            // A surface that is known only by its receptors is flat under each of them.
            let (gap, normal) = surfaces[k]
                .and_then(|surface| surface.signed_distance(&local))
                .unwrap_or_else(|| (receptor.patch_coordinates(&local).z, receptor.normal));
            (gap, frames[k].rotation * normal)
        };
        general(0.5 * (centres[0] + centres[1]), distance)
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

/// Convex surfaces given by their signed distances: the gap is the least sum of the two.
///
/// The projections onto both surfaces are averaged until they meet in opposite normals; the gap is exact
/// to second order in what is left.
fn general(start: Vector3<f64>, distance: impl Fn(usize, &Vector3<f64>) -> (f64, Vector3<f64>)) -> Meeting {
    let mut p = start;
    for _ in 0..40 {
        let (a, b) = (distance(0, &p), distance(1, &p));
        let step = -0.5 * (a.1 * a.0 + b.1 * b.0);
        p += step;
        if step.norm_squared() < 1e-14 {
            break;
        }
    }
    let (a, b) = (distance(0, &p), distance(1, &p));
    // The normals of both surfaces agree where they meet; their mean is better than either.
    let normal = (b.1 - a.1).try_normalize(1e-9).unwrap_or(b.1);
    Meeting { gap: a.0 + b.0, normal, point: p }
}

impl ObservationModel for SurfaceGap<'_> {
    fn whitening(&self, _: &[Observation; 2], _: &[Frame; 2]) -> Matrix3<f64> {
        Matrix3::identity()
    }

    fn residuals(&self, ends: &[Observation; 2], frames: &[Frame; 2], _: &Matrix3<f64>) -> Residuals {
        let meeting = self.meeting(ends, frames);
        let points = [0, 1].map(|k| frames[k].inverse_point(&meeting.point));
        let mut residuals = Residuals::new(points);
        let gap = meeting.gap / self.gap_deviation;
        let weight = 1.0 / (1.0 + (gap / TAIL).powi(2)).sqrt();
        residuals.push(meeting.normal * (weight / self.gap_deviation), gap * weight);
        for (k, offset, deviation, direction) in self.offsets(ends, &points) {
            let value = offset / deviation;
            let weight = 1.0 / (1.0 + (value / TAIL).powi(2)).sqrt();
            // The contact moves over a patch as the other limb moves against it.
            let sign = if k == 0 { -1.0 } else { 1.0 };
            residuals.push(frames[k].rotation * direction * (sign * weight / deviation), value * weight);
        }
        residuals
    }

    fn cost(&self, ends: &[Observation; 2], frames: &[Frame; 2], _: &Matrix3<f64>) -> f64 {
        let meeting = self.meeting(ends, frames);
        let points = [0, 1].map(|k| frames[k].inverse_point(&meeting.point));
        let mut cost = tailed(meeting.gap / self.gap_deviation);
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
/// An M-estimate of scale: the root of `σ² = k Σ w²g² / Σ w²(1 − h)`, with the weights `w` of the gaps `g` at
/// σ and the constant k that makes it agree with a normal distribution. A gap whose share `h` the fit takes
/// up (its leverage) is that much the smaller (Maronna, Martin and Yohai, Robust Statistics, 2006, sections
/// 2.5 and 5.1). Each of `gaps` is a gap in metres and its leverage. `start` must be of the right size.
pub fn gap_scale(gaps: &[(f64, f64)], start: f64) -> f64 {
    let mut deviation = start;
    for _ in 0..SCALE_ITERATIONS {
        let (mut squares, mut count) = (0.0, 0.0);
        for (gap, leverage) in gaps {
            let weight = 1.0 / (1.0 + (gap / (TAIL * deviation)).powi(2));
            squares += (weight * gap).powi(2);
            count += weight * weight * (1.0 - leverage).clamp(0.0, 1.0);
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
