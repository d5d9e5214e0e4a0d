//! The shape of a thing from where one's own skin touched it and where it touched nothing.
//!
//! A touch tells that the surface of a limb, whose shape and place are known, meets the thing: their gap is 0. Where limbs
//! went without a touch there is nothing: gaps are not below 0. Of a family of convex bodies ([`family`]) the one is found
//! that explains both best (Levenberg-Marquardt from several initial guesses, with a prior of what things are like); what
//! the family does not explain bends its support function by as little as explains it ([`bending`]).
//!
//! All is told in the root's frame `R`, metres.

mod bending;
mod family;

use nalgebra::{DMatrix, DVector, Rotation3, Vector2, Vector3};

use self::bending::BentBody;
use self::family::{NUMBERS, Numbers, RoundedFrustum};
use crate::geometry::{
    Capsule, ConvexBody, Frame, Gap, Precision, gap, gap_by_support, separation, tangent_basis,
};
use crate::learning::least_squares::{LeastSquares, Linearization, Stopping, levenberg_marquardt};
use crate::skin::Surface;

/// How exactly a gap is known where a motion stopped at a touch, metres: a step of the motion.
const TOUCHED: f64 = 5e-4;
/// How exactly it is known how high a thing stands, metres.
const STANDS: f64 = 1e-3;
/// What things are like before anything is felt of one: half axes and half height, metres, and the deviations of their
/// logarithms; …
const USUAL_SIZE: (f64, f64) = (0.035, 0.7);
/// … of the radius of rounding, …
const USUAL_ROUNDING: (f64, f64) = (0.008, 1.0);
/// … of the logarithm of the widening, of how far the top is aside in shares of the usual size, …
const USUAL_WIDENING: f64 = 0.15;
const USUAL_ASIDE: f64 = 0.15;
/// … of tilting, radians, where it stands, and of where the middle is, metres, about where it is first taken to be.
const USUAL_TILT: f64 = 0.15;
const USUAL_AWAY: f64 = 0.08;
/// Of squareness, on the logistic scale: from ellipses (−3) to rectangles (3).
const USUAL_SQUARENESS: f64 = 3.0;
/// Linearizations of a fit.
const ITERATIONS: usize = 30;
/// Exactness of gaps in the order in which it is asked for, metres: rough ones let the fit go far.
const ANNEALED: [f64; 4] = [0.01, 0.003, 0.001, TOUCHED];
/// How many of these are rough: after them it is told whether the family explains what was felt at all.
const ROUGH: usize = 2;
/// The root mean square of gaps where skin touched up to which it does, metres: what has corners leaves several millimetres.
const EXPLAINED: f64 = 1.5e-3;
/// Initial guesses that are gone on with.
const REFINED: usize = 3;
/// It is begun anew from all initial guesses when there are so many times as many touches as when that was done last.
const ANEW: f64 = 1.5;
/// How far a capsule's segment is from a body at the least for its gap to be told by the segment, metres.
const CORE_CLEAR: f64 = 1e-5;
/// Level directions among which a thing's breadth is looked for.
const HEADINGS: usize = 36;
/// What is left of the deviation of before where touches tell how far a thing reaches: with normals within half a radian.
const FELT: f64 = 0.8;
/// Small steps by which extents are differentiated.
const SMALL: f64 = 1e-6;

/// A surface of a limb where it was.
#[derive(Clone, Debug)]
pub struct PlacedSkin {
    surface: Surface,
    limb: Frame,
}

impl PlacedSkin {
    /// A surface of a limb whose frame was at `X_RL`; `None` if nothing is known of the surface's shape.
    pub fn new(surface: &Surface, limb: &Frame) -> Option<PlacedSkin> {
        surface.shape.is_solid().then(|| PlacedSkin { surface: surface.clone(), limb: *limb })
    }

    /// The gap from a body to it, the normal from the body to the skin. Of a capsule whose segment is clear of the body it is
    /// the segment's less the radius.
    fn gap_to(&self, body: &dyn ConvexBody, precision: Precision) -> Gap {
        let placed = self.surface.placed(&self.limb).expect("only solid surfaces are placed");
        if let Some(Capsule { ends, radius }) = placed.as_capsule() {
            let found = gap_by_support(&Capsule { ends, radius: 0.0 }, body, Precision::Exact);
            if found.distance > CORE_CLEAR {
                let points = [found.points[0] - found.normal * radius, found.points[1]];
                return Gap { distance: found.distance - radius, points, ..found };
            }
        }
        gap(&placed, body, precision)
    }

    /// The gap where it is below 0, `None` if it is not.
    fn overlap_with(&self, body: &dyn ConvexBody) -> Option<Gap> {
        let placed = self.surface.placed(&self.limb).expect("only solid surfaces are placed");
        let guess = (placed.centre() - body.centre()).try_normalize(1e-9).unwrap_or_else(Vector3::x);
        if separation(&placed, body, &guess, 0.0).0 > 0.0 {
            return None;
        }
        Some(self.gap_to(body, Precision::ExactWhereShallow)).filter(|gap| gap.distance < 0.0)
    }

    fn middle(&self) -> Vector3<f64> {
        self.limb.point(&self.surface.origin)
    }

    fn bound(&self) -> f64 {
        self.surface.shape.bounding_radius()
    }
}

/// What was felt of a thing, and what was not.
#[derive(Clone, Debug)]
pub struct FeltShape {
    touching: Vec<PlacedSkin>,
    clear: Vec<PlacedSkin>,
    /// Where its middle is taken to be before it is known better.
    about: Vector3<f64>,
    up: Vector3<f64>,
    /// The height that it stands on, along `up`; `None` if it does not.
    stands: Option<f64>,
    /// The numbers of the last estimate, with what they were like before.
    last: Option<(Numbers, Numbers)>,
    /// Touches when it was begun anew last.
    begun: usize,
}

/// A length, and how surely it is known.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FeltLength {
    /// Metres.
    pub length: f64,
    /// One standard deviation, metres.
    pub deviation: f64,
}

/// How large a thing is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FeltSize {
    /// Along `up`; from what it stands on, where it stands.
    pub height: FeltLength,
    /// Across its breadth, level.
    pub length: FeltLength,
    /// The least of its level widths.
    pub breadth: FeltLength,
}

/// What is known of a thing's shape: a convex body.
#[derive(Clone, Debug)]
pub struct ShapeEstimate {
    body: BentBody,
    /// The plane that it stands on: the direction to it, and how far it is from the origin.
    stands: Option<(Vector3<f64>, f64)>,
    /// Root mean square of the gaps where skin touched, metres.
    pub unexplained: f64,
}

impl FeltShape {
    /// Nothing yet but roughly where; `stands` is the height that it stands on along `up`, where it does.
    pub fn new(about: Vector3<f64>, up: Vector3<f64>, stands: Option<f64>) -> FeltShape {
        FeltShape { touching: Vec::new(), clear: Vec::new(), about, up, stands, last: None, begun: 0 }
    }

    /// A surface touches it here.
    pub fn touches(&mut self, skin: PlacedSkin) {
        self.touching.push(skin);
    }

    /// A surface was here and touched nothing.
    pub fn is_clear_of(&mut self, skin: PlacedSkin) {
        self.clear.push(skin);
    }

    /// The body that explains best what was felt; none before there is a touch. It goes on from the last estimate where that
    /// explains what has been felt since.
    pub fn estimate(&mut self) -> Option<ShapeEstimate> {
        if self.touching.is_empty() {
            return None;
        }
        let count = self.touching.len();
        let mut fits: Vec<Fitted> = Vec::new();
        fits.extend(self.last.map(|(last, start)| self.fit(last, start, &ANNEALED[ROUGH - 1..ROUGH])));
        let explained = fits.first().is_some_and(|fit| self.is_explained_by(fit));
        if fits.is_empty() || (!explained && count as f64 >= ANEW * self.begun as f64) {
            fits.extend(self.starts().into_iter().map(|start| self.fit(start, start, &ANNEALED[..ROUGH])));
            self.begun = count;
        }
        fits.sort_by(|a, b| a.cost.total_cmp(&b.cost));
        fits.truncate(REFINED);
        if fits.iter().any(|fit| self.is_explained_by(fit)) {
            fits = fits.iter().map(|fit| self.fit(fit.numbers, fit.start, &ANNEALED[ROUGH..])).collect();
        }
        let Fitted { numbers, start, .. } = fits.into_iter().min_by(|a, b| a.cost.total_cmp(&b.cost))?;
        self.last = Some((numbers, start));
        let family = RoundedFrustum::of(&numbers);
        let half = |k: usize| numbers[6 + k].exp() + numbers[14 + k].exp();
        let size = (half(0) * half(1) * half(2)).cbrt();
        let stands = self.stands.map(|height| (-self.up, -height));
        let body = BentBody::new(&family, size).bent(self, stands, TOUCHED);
        let unexplained = self.misfit(&body);
        Some(ShapeEstimate { body, stands, unexplained })
    }

    /// The gaps between a body and the skin that touched, and those below 0 of skin that touched nothing.
    fn gaps(&self, body: &dyn ConvexBody) -> Vec<Gap> {
        let touching = self.touching.iter().map(|skin| skin.gap_to(body, Precision::ExactWhereShallow));
        // Most are parted from it by a plane across the way between the middles.
        let parted = |skin: &&PlacedSkin| {
            let way = (skin.middle() - body.centre()).try_normalize(1e-6);
            way.is_some_and(|way| way.dot(&skin.middle()) - skin.bound() > body.support(&way).dot(&way))
        };
        let near = self.clear.iter().filter(|skin| !parted(skin));
        touching.chain(near.filter_map(|skin| skin.overlap_with(body))).collect()
    }

    /// The least cost from a guess, where `start` is what the numbers are like before.
    fn fit(&self, guess: Numbers, start: Numbers, exactness: &[f64]) -> Fitted {
        let stopping = Stopping { iterations: ITERATIONS, relative_cost: 1e-3, ..Stopping::default() };
        let (mut cost, mut numbers) = (f64::INFINITY, guess);
        for &touched in exactness {
            let solution = levenberg_marquardt(&mut Fit { felt: self, start, touched }, numbers, stopping);
            (cost, numbers) = (solution.cost, solution.state);
        }
        Fitted { cost, numbers, start }
    }

    /// The root mean square of the gaps between a body and the skin that touched, metres.
    fn misfit(&self, body: &dyn ConvexBody) -> f64 {
        let gaps = self.touching.iter().map(|skin| skin.gap_to(body, Precision::ExactWhereShallow).distance);
        (gaps.map(|gap| gap * gap).sum::<f64>() / self.touching.len() as f64).sqrt()
    }

    /// Whether the family explains what was felt, by a fit.
    fn is_explained_by(&self, fit: &Fitted) -> bool {
        self.misfit(&RoundedFrustum::of(&fit.numbers)) < EXPLAINED
    }

    /// Initial guesses: turned, and more or less round.
    fn starts(&self) -> Vec<Numbers> {
        let to_up = Rotation3::rotation_between(&Vector3::z(), &self.up)
            .unwrap_or_else(|| Rotation3::from_axis_angle(&Vector3::x_axis(), std::f64::consts::PI));
        let points: Vec<Vector3<f64>> = self.touching.iter().map(PlacedSkin::middle).collect();
        let mean = points.iter().sum::<Vector3<f64>>() / points.len() as f64;
        let mut middle = if points.len() > 3 { mean } else { self.about };
        let mut half = USUAL_SIZE.0;
        if let Some(height) = self.stands {
            let top = points.iter().map(|p| p.dot(&self.up)).fold(f64::NEG_INFINITY, f64::max);
            half = (0.5 * (top - height)).clamp(0.015, 0.15);
            middle += self.up * (height + half - middle.dot(&self.up));
        }
        let mut starts = Vec::new();
        for (yaw, square) in [(0.0, 2.0), (0.4, 2.0), (0.8, 2.0), (1.2, 2.0), (0.0, -3.0), (0.8, -3.0)] {
            let turn = to_up * Rotation3::from_axis_angle(&Vector3::z_axis(), yaw);
            let vector = turn.scaled_axis();
            let mut n = Numbers::zeros();
            n.fixed_rows_mut::<3>(0).copy_from(&middle);
            n.fixed_rows_mut::<3>(3).copy_from(&vector);
            n[6] = USUAL_SIZE.0.ln();
            n[7] = USUAL_SIZE.0.ln();
            n[8] = half.ln();
            n[13] = -square;
            n.fixed_rows_mut::<3>(14).fill(USUAL_ROUNDING.0.ln());
            starts.push(n);
        }
        // As round as can be: a ball, and capsules that lie.
        for (yaw, long) in [(0.0, 0.005), (0.0, 0.04), (0.8, 0.04), (1.6, 0.04), (2.4, 0.04)] {
            let mut n = starts[0];
            let turn = to_up * Rotation3::from_axis_angle(&Vector3::z_axis(), yaw);
            n.fixed_rows_mut::<3>(3).copy_from(&turn.scaled_axis());
            (n[6], n[7], n[8], n[13]) = (f64::ln(long), f64::ln(0.005), f64::ln(0.005), 3.0);
            n.fixed_rows_mut::<3>(14).fill(half.ln());
            starts.push(n);
        }
        starts
    }
}

impl ShapeEstimate {
    /// Whether a point is inside.
    pub fn holds(&self, point: &Vector3<f64>) -> bool {
        self.stands.is_none_or(|(down, far)| down.dot(point) <= far)
            && self.body.signed_distance(point).0 <= 0.0
    }

    /// How far it extends along a unit direction, from the root's origin, metres.
    pub fn extent(&self, direction: &Vector3<f64>) -> f64 {
        self.body.support(direction).dot(direction)
    }

    /// One standard deviation of that, metres: large where nothing was felt.
    pub fn doubt(&self, direction: &Vector3<f64>) -> f64 {
        self.body.deviation(direction)
    }

    /// The point of it that is farthest in a direction.
    pub fn farthest(&self, direction: &Vector3<f64>) -> Vector3<f64> {
        self.body.support(direction)
    }

    /// Points whose convex hull it is.
    pub fn corners(&self) -> Vec<Vector3<f64>> {
        self.body.corners().to_vec()
    }

    /// Its middle.
    pub fn middle(&self) -> Vector3<f64> {
        self.body.centre()
    }

    /// How wide it is along a unit direction, metres.
    pub fn width(&self, direction: &Vector3<f64>) -> f64 {
        self.extent(direction) + self.extent(&-direction)
    }

    /// How large it is; `up` is a unit direction in the root's frame.
    pub fn size(&self, up: &Vector3<f64>) -> FeltSize {
        let level = tangent_basis(up);
        let heading = |k: usize| {
            let (sin, cos) = (std::f64::consts::PI * k as f64 / HEADINGS as f64).sin_cos();
            level * Vector2::new(cos, sin)
        };
        let narrower = |a: &Vector3<f64>, b: &Vector3<f64>| self.width(a).total_cmp(&self.width(b));
        let narrow = (0..HEADINGS).map(heading).min_by(narrower).expect("there are headings");
        let level = |direction: &Vector3<f64>| FeltLength {
            length: self.width(direction),
            deviation: self.doubt(direction).hypot(self.doubt(&-direction)),
        };
        let height = match &self.stands {
            Some((_, far)) => FeltLength { length: self.extent(up) + far, deviation: self.doubt(up) },
            None => level(up),
        };
        FeltSize { height, length: level(&up.cross(&narrow)), breadth: level(&narrow) }
    }

    /// Whether touches tell how far it reaches along a unit direction, or only what things are usually like.
    pub fn is_felt_along(&self, direction: &Vector3<f64>) -> bool {
        self.doubt(direction) < FELT * self.body.before()
    }
}

/// A body of the family that was fitted.
#[derive(Clone, Copy)]
struct Fitted {
    cost: f64,
    numbers: Numbers,
    /// What the numbers were taken to be before.
    start: Numbers,
}

/// The fit of the family to what was felt.
struct Fit<'a> {
    felt: &'a FeltShape,
    /// What the numbers are taken to be before.
    start: Numbers,
    /// How exactly gaps are taken to be known, metres.
    touched: f64,
}

impl Fit<'_> {
    /// Residuals over their deviations, and per residual the direction in which the body's extent tells of it and what a
    /// metre of extent does to it.
    fn residuals(&self, n: &Numbers) -> Vec<(f64, Vector3<f64>, f64)> {
        let body = RoundedFrustum::of(n);
        let gaps = self.felt.gaps(&body).into_iter();
        let mut found: Vec<_> =
            gaps.map(|gap| (gap.distance / self.touched, gap.normal, -1.0 / self.touched)).collect();
        if let Some(height) = self.felt.stands {
            let (down, stands) = (-self.felt.up, STANDS.max(self.touched));
            found.push(((-body.extent(&down) - height) / stands, down, -1.0 / stands));
        }
        found
    }

    /// What the numbers are like before, each with its deviation.
    fn prior(&self) -> [(f64, f64); NUMBERS] {
        let mut prior = [(0.0, 1.0); NUMBERS];
        for k in 0..3 {
            prior[k] = (self.start[k], USUAL_AWAY);
            prior[3 + k] = (self.start[3 + k], if self.felt.stands.is_some() { USUAL_TILT } else { 1.0 });
            prior[6 + k] = (self.start[6 + k], USUAL_SIZE.1);
        }
        prior[9] = (0.0, USUAL_WIDENING);
        prior[10] = (0.0, USUAL_WIDENING);
        prior[11] = (0.0, USUAL_ASIDE * USUAL_SIZE.0);
        prior[12] = (0.0, USUAL_ASIDE * USUAL_SIZE.0);
        prior[13] = (self.start[13], USUAL_SQUARENESS);
        for (k, prior) in prior.iter_mut().enumerate().skip(14) {
            *prior = (self.start[k], USUAL_ROUNDING.1);
        }
        prior
    }
}

impl LeastSquares for Fit<'_> {
    type State = Numbers;

    fn linearize(&mut self, n: &Numbers) -> Linearization {
        let mut model = Linearization::nothing(NUMBERS);
        let body = RoundedFrustum::of(n);
        let stepped: Vec<RoundedFrustum> = (0..NUMBERS)
            .map(|k| {
                let mut m = *n;
                m[k] += SMALL;
                RoundedFrustum::of(&m)
            })
            .collect();
        let mut hessian = DMatrix::zeros(NUMBERS, NUMBERS);
        let mut gradient = DVector::zeros(NUMBERS);
        for (residual, normal, by) in self.residuals(n) {
            let extent = body.extent(&normal);
            let row = DVector::from_iterator(
                NUMBERS,
                stepped.iter().map(|stepped| by * (stepped.extent(&normal) - extent) / SMALL),
            );
            hessian += &row * row.transpose();
            gradient += &row * residual;
            model.cost += 0.5 * residual * residual;
        }
        for (k, (mean, deviation)) in self.prior().into_iter().enumerate() {
            let residual = (n[k] - mean) / deviation;
            hessian[(k, k)] += 1.0 / (deviation * deviation);
            gradient[k] += residual / deviation;
            model.cost += 0.5 * residual * residual;
        }
        model.scale = hessian.diagonal();
        model.hessian = hessian;
        model.gradient = gradient;
        model
    }

    fn cost(&self, n: &Numbers) -> f64 {
        let told: f64 = self.residuals(n).iter().map(|(residual, ..)| residual * residual).sum();
        let prior = self.prior().into_iter().enumerate();
        let before: f64 = prior.map(|(k, (mean, deviation))| ((n[k] - mean) / deviation).powi(2)).sum();
        0.5 * (told + before)
    }

    fn step(&self, n: &Numbers, step: &DVector<f64>) -> Numbers {
        let mut next = n + Numbers::from_iterator(step.iter().copied());
        // Logarithms and squareness stay where numbers stay finite.
        for k in [6, 7, 8, 14, 15, 16] {
            next[k] = next[k].clamp((1e-4_f64).ln(), (0.5_f64).ln());
        }
        for k in [9, 10] {
            next[k] = next[k].clamp(-1.5, 1.5);
        }
        next[13] = next[13].clamp(-8.0, 6.0);
        next
    }
}
