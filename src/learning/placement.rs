//! How far off the skin of every limb may be in every other limb's frame.
//!
//! A change of a schema's parameters moves each limb rigidly: to first order by a twist, which moves the point at `x`
//! by `v + ω × x`, all in the root limb's frame. What moves limb `a` against limb `b` is the sum of the twists of the
//! joints between them and of no others. So of each two limbs a matrix of six rows tells, whatever their points: the
//! joints' twists times a factor of the parameters' covariance.

use nalgebra::{DMatrix, Matrix3, Matrix6, SMatrix, Vector3};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

use super::observability::{Observability, UNMOVED};
use crate::agent::Agent;
use crate::creature::{Creature, Posture};
use crate::geometry::{Frame, tangent_basis};
use crate::kinematics::{DofTransform, Twist, carry_through, joint_transforms, skew};
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
    // Variances along the worst direction, m².
    let mut worst = DMatrix::zeros(limbs.len(), limbs.len());
    let mut rng = ChaCha8Rng::seed_from_u64(SEED);
    for _ in 0..POSTURES {
        let posture = Posture::random(creature, &mut rng);
        let twists = LimbTwists::new(creature, schema, found, &posture);
        let placed: Vec<Vec<Vector3<f64>>> = limbs
            .iter()
            .zip(&points)
            .map(|(&limb, points)| points.iter().map(|p| twists.frames[limb].point(p)).collect())
            .collect();
        let mut relative = RelativeTwists::new(&twists);
        for (i, &a) in limbs.iter().enumerate() {
            relative.set(creature, &twists, a);
            for (j, &b) in limbs.iter().enumerate().skip(i + 1) {
                let both = placed[i].iter().chain(&placed[j]);
                worst[(i, j)] = match found.placed()[a] && found.placed()[b] {
                    true => relative.worst_variance(&twists, b, both, worst[(i, j)]),
                    false => f64::INFINITY,
                };
            }
        }
    }
    worst.fill_lower_triangle_with_upper_triangle();
    worst.map(|variance: f64| Z95 * variance.sqrt())
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

/// What every joint's parameters do to the limbs beyond it, at one posture.
struct LimbTwists {
    /// `X_RL` of every limb.
    frames: Vec<Frame>,
    /// Per joint six rows (v, ω) over the determined directions, each of one standard deviation, then the
    /// undetermined ones; none where no touch involves the joint.
    of_joints: Vec<Option<Vec<f64>>>,
    /// Determined and undetermined directions.
    counts: [usize; 2],
}

impl LimbTwists {
    fn new(creature: &Creature, schema: &BodySchema, found: &Observability, posture: &[f64]) -> LimbTwists {
        let counts = [found.covariance_factor().ncols(), found.open_directions().ncols()];
        let width = counts[0] + counts[1];
        let mut frames = vec![Frame::identity()];
        let mut of_joints = Vec::with_capacity(creature.joints().len());
        for (j, joint) in creature.joints().iter().enumerate() {
            let mut frame = frames[joint.parent];
            let mut rows = vec![0.0; 6 * width];
            // A parameter's twist, times what each direction does to the parameter.
            let mut add = |parameter: usize, twist: Twist| {
                let determined = found.covariance_factor().row(parameter);
                let open = found.open_directions().row(parameter);
                for (row, along) in twist.linear.iter().chain(&twist.angular).enumerate() {
                    if *along != 0.0 {
                        let steps = determined.iter().chain(open.iter());
                        let sums = rows[row * width..(row + 1) * width].iter_mut();
                        sums.zip(steps).for_each(|(sum, step)| *sum += along * step);
                    }
                }
            };
            if let Some(offset) = found.parameters.positions[j] {
                (0..3).for_each(|i| add(offset + i, Twist::shifting(frame.rotation.column(i).into())));
            }
            carry_through(
                schema,
                j,
                joint_transforms(joint, posture),
                &mut frame,
                |dof, transform, before| {
                    let Some(offset) = found.parameters.axes[dof] else { return };
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
                if let Some(offset) = found.parameters.limb_origins[j] {
                    (0..3).for_each(|i| add(offset + i, Twist::shifting(rotation.column(i).into())));
                }
                if let Some(offset) = found.parameters.limb_rotations[j] {
                    (0..3).for_each(|i| {
                        add(offset + i, Twist::turning(rotation.column(i).into(), &frame.origin))
                    });
                }
            }
            frames.push(frame);
            of_joints.push((!found.untouched(j)).then_some(rows));
        }
        LimbTwists { frames, of_joints, counts }
    }
}

/// What moves one limb against each other one: the twists between them.
struct RelativeTwists {
    /// Per limb six rows.
    rows: Vec<Vec<f64>>,
    /// Per limb whether all joints between are known at all.
    known: Vec<bool>,
    /// Whether a limb is set.
    reached: Vec<bool>,
}

impl RelativeTwists {
    fn new(twists: &LimbTwists) -> RelativeTwists {
        let limbs = twists.frames.len();
        RelativeTwists {
            rows: vec![Vec::new(); limbs],
            known: vec![false; limbs],
            reached: vec![false; limbs],
        }
    }

    /// Against limb `a`.
    fn set(&mut self, creature: &Creature, twists: &LimbTwists, a: usize) {
        let width = twists.counts[0] + twists.counts[1];
        self.reached.fill(false);
        self.rows[a] = vec![0.0; 6 * width];
        (self.known[a], self.reached[a]) = (true, true);
        // Up to the root, then to whatever hangs on what is reached.
        let mut below = a;
        while let Some(joint) = creature.joint_of(below) {
            let parent = creature.joints()[joint].parent;
            self.pass(twists, joint, [below, parent], 1.0);
            below = parent;
        }
        for (joint, parent) in creature.joints().iter().map(|joint| joint.parent).enumerate() {
            if !self.reached[joint + 1] {
                self.pass(twists, joint, [parent, joint + 1], -1.0);
            }
        }
    }

    /// From one limb to its neighbour across a joint.
    fn pass(&mut self, twists: &LimbTwists, joint: usize, [from, to]: [usize; 2], sign: f64) {
        let mut rows = std::mem::take(&mut self.rows[to]);
        rows.clear();
        let twist = twists.of_joints[joint].as_ref();
        if let Some(twist) = twist {
            rows.extend(self.rows[from].iter().zip(twist).map(|(sum, step)| sum + sign * step));
        }
        self.known[to] = self.known[from] && twist.is_some();
        self.rows[to] = rows;
        self.reached[to] = true;
    }

    /// The greatest variance of any of some points (in the root's frame), as points of either limb, against the
    /// other; at least `least`, m².
    fn worst_variance<'p>(
        &self,
        twists: &LimbTwists,
        limb: usize,
        points: impl Iterator<Item = &'p Vector3<f64>>,
        least: f64,
    ) -> f64 {
        let [determined, open] = twists.counts;
        let width = determined + open;
        if !self.known[limb] || least.is_infinite() {
            return f64::INFINITY;
        }
        let all = &self.rows[limb];
        let rows: Vec<&[f64]> = (0..6).map(|row| &all[row * width..(row + 1) * width]).collect();
        let mut covariance = Matrix6::zeros();
        for i in 0..6 {
            for j in 0..=i {
                let sum = dot(&rows[i][..determined], &rows[j][..determined]);
                covariance[(i, j)] = sum;
                covariance[(j, i)] = sum;
            }
        }
        let mut worst = least;
        for x in points {
            let moves = |k: usize| {
                let part = |from: usize| Vector3::new(rows[from][k], rows[from + 1][k], rows[from + 2][k]);
                (part(0) + part(3).cross(x)).norm() > UNMOVED
            };
            if (determined..width).any(moves) {
                return f64::INFINITY;
            }
            let mut map = SMatrix::<f64, 3, 6>::zeros();
            map.fixed_view_mut::<3, 3>(0, 0).fill_with_identity();
            map.fixed_view_mut::<3, 3>(0, 3).copy_from(&-skew(x));
            let variance: Matrix3<f64> = map * covariance * map.transpose();
            // No eigenvalue is greater than the trace.
            if variance.trace() > worst {
                worst = worst.max(variance.symmetric_eigenvalues().max());
            }
        }
        worst
    }
}

/// The product of two rows: four sums at once, which the processor adds side by side.
fn dot(a: &[f64], b: &[f64]) -> f64 {
    let mut sums = [0.0; 4];
    let (fours_a, fours_b) = (a.chunks_exact(4), b.chunks_exact(4));
    let rest: f64 = fours_a.remainder().iter().zip(fours_b.remainder()).map(|(x, y)| x * y).sum();
    for (x, y) in fours_a.zip(fours_b) {
        (0..4).for_each(|k| sums[k] += x[k] * y[k]);
    }
    sums.iter().sum::<f64>() + rest
}
