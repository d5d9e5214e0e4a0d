//! How far off the skin of every limb may be in every other limb's frame.
//!
//! A change of a schema's parameters moves each limb rigidly: to first order by a twist, which moves the point at `x`
//! by `v + ω × x`, all in the root limb's frame. What moves limb `a` against limb `b` is the difference of their twists, in
//! which those of the joints that carry both cancel. So a matrix of six rows a limb describes all of its points: its twists by
//! the columns of a factor of the parameters' covariance.

use nalgebra::{DMatrix, Matrix3, Vector3, Vector6};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

use super::observability::{Observability, UNMOVED};
use crate::agent::Agent;
use crate::creature::{Creature, Posture};
use crate::geometry::{Frame, tangent_basis};
use crate::kinematics::{Chain, DofTransform, Twist, carry_through, joint_transforms, skew};
use crate::learning::Parameters;
use crate::schema::BodySchema;
use crate::skin::Skin;

/// Standard deviations within which 95 % of a normal distribution lies.
pub const Z95: f64 = 1.959964;
/// Receptors that stand for all skin of a limb: no four in one plane are needed to see any turn of it.
const POINTS: usize = 4;
/// Random postures in which limbs are looked at. Twice as many find hardly more: a limb that one posture places badly,
/// most do.
const POSTURES: usize = 4;
/// The seed of these postures.
const SEED: u64 = 0;

/// How far off any skin of a limb may be in another limb's frame, metres: 95 % of the distance along the direction
/// that is known worst, the greatest of both ways. A row and a column per limb of `limbs`; infinite where an
/// undetermined direction moves it, where a joint between was never touched, or a limb is not placed at all.
pub(super) fn distances(
    agent: &Agent,
    schema: &BodySchema,
    found: &Observability,
    limbs: &[usize],
) -> DMatrix<f64> {
    let creature = agent.creature();
    let points: Vec<Vec<Vector3<f64>>> =
        limbs.iter().map(|&limb| far_apart(agent.skin(), limb, POINTS)).collect();
    let (factor, open) = (found.covariance_factor(), found.open_directions());
    let determined = factor.ncols();
    let steps = DMatrix::from_fn(determined + open.ncols(), factor.nrows(), |k, parameter| {
        if k < determined { factor[(parameter, k)] } else { open[(parameter, k - determined)] }
    });
    let is_known = |a: usize, b: usize| {
        let placed = found.placed()[a] && found.placed()[b];
        placed && !Chain::between(creature, a, b).joints().any(|joint| found.untouched(joint))
    };
    // Variances along the worst direction, m².
    let mut worst = DMatrix::zeros(limbs.len(), limbs.len());
    let mut rng = ChaCha8Rng::seed_from_u64(SEED);
    for _ in 0..POSTURES {
        let posture = Posture::random(creature, &mut rng);
        let twists = LimbTwists::new(creature, schema, &found.parameters, &steps, &posture);
        let of_limb = |(&limb, points): (&usize, &Vec<Vector3<f64>>)| -> Vec<Vector3<f64>> {
            points.iter().map(|point| twists.frames[limb].point(point)).collect()
        };
        let placed: Vec<Vec<Vector3<f64>>> = limbs.iter().zip(&points).map(of_limb).collect();
        for (i, &a) in limbs.iter().enumerate() {
            for (j, &b) in limbs.iter().enumerate().skip(i + 1) {
                let at_least: &mut f64 = &mut worst[(i, j)];
                if !is_known(a, b) {
                    *at_least = f64::INFINITY;
                }
                if at_least.is_finite() {
                    let both = placed[i].iter().chain(&placed[j]);
                    *at_least = worst_variance(&twists.between(a, b), determined, both, *at_least);
                }
            }
        }
    }
    worst.fill_lower_triangle_with_upper_triangle();
    worst.map(|variance: f64| Z95 * variance.sqrt())
}

/// The greatest variance of any of some points (in the root's frame), at least `least`, m²: by the twists of its limb, first one of
/// one standard deviation for each `determined` direction, then those of undetermined ones.
fn worst_variance<'p>(
    twists: &DMatrix<f64>,
    determined: usize,
    points: impl Iterator<Item = &'p Vector3<f64>>,
    least: f64,
) -> f64 {
    let open = twists.columns(determined, twists.ncols() - determined).into_owned();
    let twists = twists.columns(0, determined);
    let covariance = twists * twists.transpose();
    let mut worst = least;
    for x in points {
        if shifts(&open, x).column_iter().any(|shift| shift.norm() > UNMOVED) {
            return f64::INFINITY;
        }
        // Once by its columns, once by its rows.
        let half = shifts(&covariance, x);
        let variance: Matrix3<f64> = shifts(&half.transpose(), x).fixed_view::<3, 3>(0, 0).into_owned();
        // No eigenvalue is greater than the trace.
        if variance.trace() > worst {
            worst = worst.max(variance.symmetric_eigenvalues().max());
        }
    }
    worst
}

/// How twists, one a column, shift a point at `x`: three rows.
pub(super) fn shifts(twists: &DMatrix<f64>, x: &Vector3<f64>) -> DMatrix<f64> {
    let mut shifts = twists.rows(0, 3).into_owned();
    shifts -= skew(x) * twists.rows(3, 3);
    shifts
}

/// Up to `most` receptors of a limb that are far from one another, metres in the limb's frame.
pub(super) fn far_apart(skin: &Skin, limb: usize, most: usize) -> Vec<Vector3<f64>> {
    let all: Vec<Vector3<f64>> =
        skin.receptors.iter().filter(|receptor| receptor.limb == limb).map(|r| r.position).collect();
    let mut chosen: Vec<Vector3<f64>> = all.first().copied().into_iter().collect();
    while chosen.len() < most.min(all.len()) {
        let nearest = |p: &Vector3<f64>| chosen.iter().map(|q| (p - q).norm()).fold(f64::INFINITY, f64::min);
        let farthest = all.iter().max_by(|a, b| nearest(a).total_cmp(&nearest(b)));
        chosen.extend(farthest.copied());
    }
    chosen
}

/// What steps of a schema's parameters do to every limb, at one posture.
pub(super) struct LimbTwists {
    /// `X_RL` of every limb.
    pub frames: Vec<Frame>,
    /// Per limb its twist (v, ω) by every step, one a column.
    twists: Vec<DMatrix<f64>>,
}

impl LimbTwists {
    /// By steps of `parameters`, a column for each of these.
    pub fn new(
        creature: &Creature,
        schema: &BodySchema,
        parameters: &Parameters,
        steps: &DMatrix<f64>,
        posture: &[f64],
    ) -> LimbTwists {
        let mut frames = vec![Frame::identity()];
        let mut twists = vec![DMatrix::zeros(6, steps.nrows())];
        for (j, joint) in creature.joints().iter().enumerate() {
            let mut frame = frames[joint.parent];
            let mut twist: DMatrix<f64> = twists[joint.parent].clone();
            let mut add = |parameter: usize, own: Twist| {
                let own = Vector6::from_iterator(own.linear.iter().chain(&own.angular).copied());
                twist.ger(1.0, &own, &steps.column(parameter), 1.0);
            };
            if let Some(offset) = parameters.positions[j] {
                (0..3).for_each(|i| add(offset + i, Twist::shifting(frame.rotation.column(i).into())));
            }
            carry_through(
                schema,
                j,
                joint_transforms(joint, posture),
                &mut frame,
                |dof, transform, before| {
                    let Some(offset) = parameters.axes[dof] else { return };
                    let axis = &schema.axes[dof];
                    for (i, across) in tangent_basis(axis).column_iter().enumerate() {
                        let across: Vector3<f64> = across.into();
                        match transform {
                            // dR Rᵀ of R(a, θ) where a moves across its direction.
                            DofTransform::Hinge { sine, versine } => {
                                let omega =
                                    before.direction(&(across * *sine + axis.cross(&across) * *versine));
                                add(offset + i, Twist::turning(omega, &before.origin));
                            }
                            DofTransform::Slide { distance } => {
                                add(offset + i, Twist::shifting(before.direction(&across) * *distance));
                            }
                            DofTransform::Ball { .. } => {}
                        }
                    }
                },
            );
            if let Some(pose) = schema.limb_poses.get(j) {
                // The joint's side of the limb's pose.
                let rotation = frame.rotation * pose.rotation.transpose();
                let column = |i: usize| -> Vector3<f64> { rotation.column(i).into() };
                if let Some(offset) = parameters.limb_origins[j] {
                    (0..3).for_each(|i| add(offset + i, Twist::shifting(column(i))));
                }
                if let Some(offset) = parameters.limb_rotations[j] {
                    (0..3).for_each(|i| add(offset + i, Twist::turning(column(i), &frame.origin)));
                }
            }
            frames.push(frame);
            twists.push(twist);
        }
        LimbTwists { frames, twists }
    }

    /// The twists of one limb against another.
    pub fn between(&self, a: usize, b: usize) -> DMatrix<f64> {
        &self.twists[a] - &self.twists[b]
    }
}
