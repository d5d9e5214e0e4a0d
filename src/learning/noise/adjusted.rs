//! Touches in the postures in which they most likely were made, as far as a schema tells.
//!
//! A touch whose joints were read at `q` was made at some `q + e` where its gaps are closed. The likeliest `e` is, by repetition,
//!
//! ```text
//! ê = −σ_q² Sᵀ (σ_q² S Sᵀ + Σ₀)⁻¹ (g(q + ê) − S ê)      S = ∂g/∂q at q + ê
//! ```
//!
//! (Britt and Luecke, "The Estimation of Parameters in Nonlinear, Implicit Models", 1973). What is fitted is `g(q + ê) − S ê`, with
//! its derivatives by parameters at `q + ê`. Derivatives at `q` are off by the same errors as the gaps, and what is fitted with
//! them is off by as much as `σ_q²` makes it, however many touches there are.
//!
//! The same holds of skin under receptors that are not where they were told to be: where it is shifted along itself, the surfaces
//! meet elsewhere, and at another angle. What is linear in the shifts is taken about those that are the likeliest by all touches.

use std::borrow::Cow;

use nalgebra::{DMatrix, DVector, Matrix3, Matrix3xX, Vector3};

use super::estimate::{MixedSystem, Noise};
use super::gap::{Compared, NoisyGap, axes_of_misses, shift_under, widths};
use crate::agent::Agent;
use crate::learning::prediction::GapRow;
use crate::learning::surface_gap::SurfaceGap;
use crate::learning::touch_set::{PreparedTouch, TouchSet};
use crate::learning::{AxisModel, Parameters};
use crate::schema::BodySchema;

/// Repetitions of the likeliest error of a touch's posture, and of where skin is: they are small, and the first leaves their square.
const REPETITIONS: usize = 3;

/// Touches that are adjusted, as the head of this file says.
#[derive(Clone, Debug)]
pub struct Adjusted<'a> {
    /// The touches, in the postures in which they most likely were made.
    pub touches: Cow<'a, TouchSet>,
    /// Per gap, what it has there without being open, metres, and how that varies beyond what is linear in the errors, m²; empty
    /// where all touches are as they were read.
    pub offsets: Vec<[f64; 2]>,
    /// Per receptor, how far the skin under it is most likely from where it was told to be, in its limb's frame, metres; empty
    /// where all is there.
    pub(super) shifts: Vec<Vector3<f64>>,
    /// Per touch, the axes along which its points are compared, and the variance that they were told to have along each, m².
    pub axes: Vec<(Matrix3<f64>, [f64; 3])>,
}

impl<'a> Adjusted<'a> {
    /// Touches as they were read.
    pub fn none(touches: &'a TouchSet) -> Adjusted<'a> {
        Adjusted {
            touches: Cow::Borrowed(touches),
            offsets: Vec::new(),
            shifts: Vec::new(),
            axes: Vec::new(),
        }
    }

    /// Touches by a schema in some noise.
    pub fn of(
        (agent, compared): (&Agent, Compared),
        touches: &'a TouchSet,
        schema: &BodySchema,
        noise: &Noise,
    ) -> Adjusted<'a> {
        let mut adjusted = Adjusted::none(touches);
        if noise.joint > 0.0 {
            adjusted.turn((agent, compared), schema, noise);
        }
        if noise.receptor > 0.0 && compared == Compared::Surfaces {
            let nothing = Parameters::new(agent.creature(), AxisModel::Unit, |_| false);
            for _ in 0..REPETITIONS {
                let gaps = gaps_of((agent, compared), &adjusted, &nothing, schema);
                let system = MixedSystem::new(noise, &gaps, &DMatrix::zeros(0, 0), None);
                let Some(factor) = system.eliminated().and_then(|eliminated| eliminated.factor) else {
                    break;
                };
                adjusted.shifts = system.likeliest_shifts(&gaps, &factor);
            }
        }
        adjusted
    }

    /// Moves the touches to the postures in which they most likely were made.
    fn turn(&mut self, (agent, compared): (&Agent, Compared), schema: &BodySchema, noise: &Noise) {
        let touches = &self.touches;
        let mut moved = touches.clone().into_owned();
        for (pair, width) in moved.pairs.iter_mut().zip(widths(agent, touches)) {
            for touch in &mut pair.touches {
                let comparison = Comparison { agent, compared, schema, noise, width };
                let (error, honest) = comparison.adjust(touch);
                let axes = axes_of_misses(schema, touch);
                self.offsets.extend(comparison.offsets(touch, &axes, &error, honest));
                self.axes.push(axes);
            }
        }
        self.touches = Cow::Owned(moved);
    }
}

/// The gaps of all touches at a schema, pair by pair, with their derivatives by some parameters.
///
/// Joints that are misread move two points apart in some directions more than in others: their gaps are taken along the axes in
/// which these motions are independent of one another.
pub fn gaps_of(
    of: (&Agent, Compared),
    adjusted: &Adjusted,
    parameters: &Parameters,
    schema: &BodySchema,
) -> Vec<NoisyGap> {
    gaps_where_skin_is(of, adjusted, parameters, schema, &adjusted.shifts)
}

/// The same where the skin under receptors is shifted, by what is linear in that less: it is for whoever asks where skin is.
pub(super) fn gaps_where_skin_is(
    (agent, compared): (&Agent, Compared),
    adjusted: &Adjusted,
    parameters: &Parameters,
    schema: &BodySchema,
    shifts: &[Vector3<f64>],
) -> Vec<NoisyGap> {
    let skin = agent.skin();
    let mut row = GapRow::default();
    let mut slopes = Vec::new();
    let mut gaps = Vec::with_capacity(compared.gaps_a_touch() * adjusted.touches.len());
    let mut axes = adjusted.axes.iter();
    for (pair, width) in adjusted.touches.pairs.iter().zip(widths(agent, &adjusted.touches)) {
        for touch in &pair.touches {
            let along = axes.next();
            let mut push = |row: &GapRow, told: f64| {
                row.angle_slopes(schema, touch, &mut slopes);
                let [offset, variance] = adjusted.offsets.get(gaps.len()).copied().unwrap_or_default();
                gaps.push(NoisyGap {
                    gap: row.gap - offset,
                    told: told + variance,
                    entries: row.entries.clone(),
                    slope: slopes.iter().map(|(_, slope)| slope.powi(2)).sum(),
                    receptors: [touch.ends[0].receptor, touch.ends[1].receptor],
                    places: row.points,
                    normals: row.normals,
                    width,
                });
            };
            match compared {
                Compared::Surfaces => {
                    let shifts = touch.ends.each_ref().map(|end| shift_under(shifts, end.receptor));
                    row.set_shifted(skin, parameters, schema, touch, &shifts);
                    row.gap -= (0..2).map(|k| row.normals[k].dot(&shifts[k])).sum::<f64>();
                    push(&row, 0.0);
                }
                Compared::Points => {
                    let (axes, told) = along.copied().unwrap_or_else(|| axes_of_misses(schema, touch));
                    for (axis, told) in axes.column_iter().zip(told) {
                        row.set_miss(parameters, schema, touch, &axis.into_owned());
                        push(&row, told);
                    }
                }
            }
        }
    }
    gaps
}

/// How a touch is compared.
struct Comparison<'a> {
    agent: &'a Agent,
    compared: Compared,
    schema: &'a BodySchema,
    noise: &'a Noise,
    /// How far apart the limbs may be where the touch is false, metres.
    width: f64,
}

/// Where a touch is under a schema.
struct Meeting {
    /// Its gaps, metres.
    gaps: DVector<f64>,
    /// The directions that they are taken along, in the common ancestor's frame.
    along: Matrix3xX<f64>,
    /// The places that meet, each in its limb's frame, metres.
    places: [Vector3<f64>; 2],
}

impl Comparison<'_> {
    /// The gaps of surfaces, or of points along some axes.
    fn meeting(&self, touch: &PreparedTouch, axes: &Matrix3<f64>) -> Meeting {
        let frames = touch.frames(self.schema);
        match self.compared {
            Compared::Surfaces => {
                let found = SurfaceGap::new(self.agent.skin(), 1.0).gap(&touch.ends, &frames);
                let middle = found.middle();
                Meeting {
                    gaps: DVector::from_element(1, found.distance),
                    along: Matrix3xX::from_columns(&[found.normal]),
                    places: [0, 1].map(|k| frames[k].inverse_point(&middle)),
                }
            }
            Compared::Points => {
                let gaps = axes.tr_mul(&touch.miss(self.schema));
                Meeting {
                    gaps: DVector::from_column_slice(gaps.as_slice()),
                    along: Matrix3xX::from_columns(&[axes.column(0), axes.column(1), axes.column(2)]),
                    places: touch.ends.each_ref().map(|end| end.position),
                }
            }
        }
    }

    /// The derivatives of the gaps by what a touch may be turned by, gap by gap, metres a radian.
    fn slopes(&self, touch: &PreparedTouch, at: &Meeting) -> DMatrix<f64> {
        let derivatives = touch.angle_derivatives(self.schema, at.places.each_ref());
        // There may be none: of slides alone nothing is misread.
        let mut slopes = DMatrix::zeros(at.gaps.len(), derivatives.len());
        for (mut column, (_, derivative)) in slopes.column_iter_mut().zip(derivatives) {
            column.copy_from(&at.along.tr_mul(&derivative));
        }
        slopes
    }

    /// A touch with its hinges turned, radians.
    fn turned(touch: &PreparedTouch, by: &DVector<f64>) -> PreparedTouch {
        let mut angles = by.iter().copied();
        let sides = touch.sides.each_ref().map(|side| side.turned(&mut angles));
        PreparedTouch { sides, ends: touch.ends }
    }

    /// Moves a touch to the posture in which it most likely was made: what it is turned by, and the probability that it is honest,
    /// for a false touch stays where it was read.
    fn adjust(&self, touch: &mut PreparedTouch) -> (DVector<f64>, f64) {
        let (read, axes) = (touch.clone(), Matrix3::identity());
        let told = match self.compared {
            Compared::Surfaces => 0.0,
            Compared::Points => touch.ends.iter().map(|end| end.covariance.trace() / 3.0).sum(),
        };
        let own = self.noise.variance_by(0.0, told);
        let (mut error, mut honest) = (DVector::zeros(0), 1.0);
        for _ in 0..REPETITIONS {
            let at = self.meeting(touch, &axes);
            let slopes = self.slopes(touch, &at);
            let open = if error.is_empty() { at.gaps } else { at.gaps - &slopes * &error };
            let rows = open.len();
            let by_angles = &slopes * slopes.transpose() * self.noise.joint.powi(2);
            let covariance = by_angles + DMatrix::identity(rows, rows) * own;
            let variance = covariance.trace() / rows as f64;
            let Some(factor) = covariance.cholesky() else { break };
            let pull = factor.solve(&open);
            // As far off as a single gap would be that is as unlikely.
            let miss = (open.dot(&pull) / rows as f64 * variance).sqrt();
            honest = self.noise.inlier_probability(self.width, miss, variance);
            error = -slopes.tr_mul(&pull) * (honest * self.noise.joint.powi(2));
            *touch = Comparison::turned(&read, &error);
        }
        (error, honest)
    }

    /// What the gaps of a touch that was turned have there without being open, along axes along which they are independent, and how
    /// that varies: see [`Adjusted`].
    fn offsets(
        &self,
        touch: &PreparedTouch,
        (axes, told): &(Matrix3<f64>, [f64; 3]),
        error: &DVector<f64>,
        honest: f64,
    ) -> Vec<[f64; 2]> {
        let at = self.meeting(touch, axes);
        let slopes = self.slopes(touch, &at);
        let linear = &slopes * error;
        let mut offsets: Vec<[f64; 2]> = linear.iter().map(|linear| [*linear, 0.0]).collect();
        // Of second order in the errors that are left, `½ δᵀ ∂²g/∂q² δ`: by differences, over all turns by themselves less what the
        // gaps tell of them.
        let mut add = |direction: DVector<f64>, share: f64| {
            let [up, down] = [self.noise.joint, -self.noise.joint]
                .map(|by| self.meeting(&Comparison::turned(touch, &(&direction * by)), axes).gaps);
            for (k, [mean, variance]) in offsets.iter_mut().enumerate() {
                let difference = up[k] + down[k] - 2.0 * at.gaps[k];
                *mean += 0.5 * share * difference;
                *variance += 0.5 * share * difference.powi(2);
            }
        };
        let count = slopes.ncols();
        for turn in 0..count {
            add(DVector::from_fn(count, |i, _| if i == turn { 1.0 } else { 0.0 }), 1.0);
        }
        for (k, slopes) in slopes.row_iter().enumerate() {
            let squares = slopes.norm_squared();
            if squares > 0.0 {
                let told = if self.compared == Compared::Points { told[k] } else { 0.0 };
                let by_angles = self.noise.joint.powi(2) * squares;
                let share = honest * by_angles / self.noise.variance_by(squares, told);
                add(slopes.transpose() / squares.sqrt(), -share);
            }
        }
        offsets.iter_mut().for_each(|[_, variance]| *variance = variance.max(0.0));
        offsets
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::creature::{Creature, Dof, DofKind, Joint};
    use crate::geometry::Shape;
    use crate::kinematics::{Chain, ChainSide};
    use crate::learning::observation::Observation;
    use crate::learning::touch_set::LimbTouch;
    use crate::skin::{Receptor, Skin, Surface};
    use nalgebra::UnitQuaternion;
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;
    use rand_distr::{Distribution, StandardNormal};

    /// How far joints are misread, radians.
    const MISREAD: f64 = 0.03;

    /// A trunk, an arm on a ball and a hand on a hinge, with a receptor each; the schema, and touches of hand and trunk in
    /// postures that were misread.
    fn misread(count: usize, seed: u64) -> (Agent, BodySchema, TouchSet) {
        let joint = |name: &str, parent, kind, range| {
            Joint::new(name, parent, vec![Dof { name: name.into(), kind, range, follows: None }])
        };
        let joints = vec![
            joint("shoulder", 0, DofKind::Ball, [0.0, 3.0]),
            joint("elbow", 1, DofKind::Hinge, [-2.0, 2.0]),
        ];
        let limbs = ["trunk", "arm", "hand"].map(String::from).to_vec();
        let creature = Creature::new("arm".into(), limbs, joints, Vec::new()).unwrap();
        let mut schema = BodySchema::zero(&creature);
        schema.positions = vec![Vector3::new(0.1, 0.0, 0.2), Vector3::new(0.0, 0.3, 0.0)];
        *schema.axes.last_mut().unwrap() = Vector3::z();
        let receptor = |limb| Receptor {
            id: format!("on {limb}"),
            limb,
            position: Vector3::new(0.0, 0.2, 0.0),
            normal: Vector3::x(),
            tangent: Vector3::y(),
            half_extents: [0.01; 2],
            surface: None,
        };
        let skin = Skin { receptors: vec![receptor(0), receptor(2)], surfaces: Vec::new() };
        let agent = Agent::new(creature, skin).unwrap();
        let creature = agent.creature();
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let chain = Chain::between(creature, 0, 2);
        let mut touches = TouchSet::default();
        for _ in 0..count {
            let mut random = |reach: f64| Vector3::from_fn(|_, _| rng.random_range(-reach..reach));
            let turn = UnitQuaternion::from_scaled_axis(random(1.2));
            // Bent, and far from the elbow: else it moves them to second order alone.
            let (bend, on_hand) = (1.2 + random(0.3).x, Vector3::new(0.0, 0.2, 0.0) + random(0.05));
            let posture = |turn: UnitQuaternion<f64>, bend: f64| [turn.w, turn.i, turn.j, turn.k, bend];
            let side = ChainSide::new(creature, &chain.sides[1], &posture(turn, bend));
            let on_trunk = side.frame(&schema).point(&on_hand);
            let mut normal = || -> f64 {
                MISREAD * <StandardNormal as Distribution<f64>>::sample(&StandardNormal, &mut rng)
            };
            let turned = turn * UnitQuaternion::from_scaled_axis(Vector3::from_fn(|_, _| normal()));
            let read = posture(turned, bend + normal());
            let ends = [(0, on_trunk), (1, on_hand)].map(|(receptor, position)| Observation {
                position,
                covariance: Matrix3::identity() * 5e-9,
                receptor,
            });
            touches.push(creature, LimbTouch { limbs: [0, 2], posture: &read, ends });
        }
        (agent, schema, touches)
    }

    /// By how many deviations touches draw each parameter away from the truth.
    fn pulls(agent: &Agent, schema: &BodySchema, adjusted: &Adjusted, noise: &Noise) -> Vec<f64> {
        let parameters = Parameters::new(agent.creature(), AxisModel::Unit, |_| true);
        let mut sums = vec![[0.0; 2]; parameters.len()];
        for gap in gaps_of((agent, Compared::Points), adjusted, &parameters, schema) {
            for &(place, slope) in &gap.entries {
                sums[place][0] += slope * gap.gap / noise.variance(&gap);
                sums[place][1] += slope * slope / noise.variance(&gap);
            }
        }
        sums.into_iter().filter(|[_, told]| *told > 0.0).map(|[pull, told]| pull / told.sqrt()).collect()
    }

    #[test]
    fn touches_that_are_adjusted_draw_no_parameter_away_from_the_truth() {
        let noise = Noise { joint: MISREAD, ..Noise::of_gaps(1e-6) };
        for seed in 0..4 {
            let (agent, schema, touches) = misread(10_000, seed);
            let worst = |adjusted: &Adjusted| {
                pulls(&agent, &schema, adjusted, &noise)
                    .into_iter()
                    .fold(0.0, |worst: f64, pull| worst.max(pull.abs()))
            };
            let adjusted = Adjusted::of((&agent, Compared::Points), &touches, &schema, &noise);
            assert!(worst(&adjusted) < 4.0, "{}", worst(&adjusted));
            // As they were read they do.
            assert!(worst(&Adjusted::none(&touches)) > 6.0, "{}", worst(&Adjusted::none(&touches)));
        }
    }

    #[test]
    fn a_false_touch_stays_as_it_was_read() {
        let (agent, schema, mut touches) = misread(1, 1);
        touches.pairs[0].touches[0].ends[0].position.x += 0.3;
        let noise = Noise { joint: 1e-3, false_share: 0.1, ..Noise::of_gaps(1e-6) };
        let adjusted = Adjusted::of((&agent, Compared::Points), &touches, &schema, &noise);
        let frames = |touches: &TouchSet| touches.pairs[0].touches[0].frames(&schema)[1];
        let moved = frames(&adjusted.touches).origin - frames(&touches).origin;
        assert!(moved.norm() < 1e-9, "{moved}");
    }

    #[test]
    fn skin_is_found_where_it_is_and_not_where_it_was_told_to_be() {
        const RADIUS: f64 = 0.02;
        let slide =
            |name: &str| Dof { name: name.into(), kind: DofKind::Slide, range: [-1.0, 1.0], follows: None };
        let joint = Joint::new("crane", 0, ["x", "y", "z"].map(slide).to_vec());
        let limbs = ["trunk", "hand"].map(String::from).to_vec();
        let creature = Creature::new("crane".into(), limbs, vec![joint], Vec::new()).unwrap();
        let mut schema = BodySchema::zero(&creature);
        schema.axes = [Vector3::x(), Vector3::y(), Vector3::z()].to_vec();
        let ball = |limb| Surface {
            limb,
            origin: Vector3::zeros(),
            rotation: Matrix3::identity(),
            shape: Shape::Sphere { radius: RADIUS },
            geom: 0,
        };
        let receptor = |limb| Receptor {
            id: format!("on {limb}"),
            limb,
            position: Vector3::x() * RADIUS,
            normal: Vector3::x(),
            tangent: Vector3::y(),
            half_extents: [0.01; 2],
            surface: Some(limb),
        };
        let skin = Skin { receptors: [0, 1].map(receptor).to_vec(), surfaces: [0, 1].map(ball).to_vec() };
        let agent = Agent::new(creature, skin).unwrap();
        // How far from where it was told to be the trunk's ball is, seen from the hand's.
        let displaced = Vector3::new(3e-3, -2e-3, 4e-3);
        let mut rng = ChaCha8Rng::seed_from_u64(1);
        let mut touches = TouchSet::default();
        for _ in 0..20 {
            let away = Vector3::from_fn(|_, _| rng.random_range(-1.0..1.0)).normalize();
            let posture = displaced + away * (2.0 * RADIUS);
            let touch = LimbTouch::of_receptors(agent.skin(), [0, 1], posture.as_slice());
            touches.push(agent.creature(), touch);
        }
        let noise = Noise { receptor: 3e-3, ..Noise::of_gaps(1e-6) };
        let left = |adjusted: &Adjusted, shifts: &[Vector3<f64>]| {
            let nothing = Parameters::new(agent.creature(), AxisModel::Unit, |_| false);
            let gaps = gaps_of((&agent, Compared::Surfaces), adjusted, &nothing, &schema);
            let of = |gap: &NoisyGap| {
                gap.gap + gap.shifts().map(|(k, normal)| normal.dot(&shifts[k])).sum::<f64>()
            };
            gaps.iter().map(|gap| of(gap).abs()).fold(0.0, f64::max)
        };
        let adjusted = Adjusted::of((&agent, Compared::Surfaces), &touches, &schema, &noise);
        let found = adjusted.shifts[0] - adjusted.shifts[1];
        // But for a hundredth, by what is believed of skin before it is felt.
        assert!((found - displaced).norm() < 1e-4, "{found}");
        assert!(left(&adjusted, &adjusted.shifts) < 1e-4);
        // What is linear about where it was told to be leaves more.
        assert!(left(&Adjusted::none(&touches), &adjusted.shifts) > 2e-4);
    }
}
