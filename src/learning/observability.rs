//! What the touches determine, how well, and what they leave open.
//!
//! The normal equations at the learned schema say it all: their singular values give rank, condition and
//! the indices that the calibration literature reports; their inverse gives the standard deviation of
//! every position and axis; what lies in their null space no touch can feel.
//!
//! Positions and axes have different units. To compare them, positions are counted in units of a
//! characteristic length, so that a singular value tells how much whitened residual a turn of one radian,
//! or a shift of that length, makes.
//!
//! Long: its parts are taken apart together with those of the other learners, when learning goes in stages.

use nalgebra::{DMatrix, DVector, Matrix3, SymmetricEigen, Vector3};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use serde::Serialize;

use crate::agent::Agent;
use crate::creature::{Creature, DofKind, Posture};
use crate::kinematics::{Chain, ChainSide, SideJacobian, limb_frames, skew, tangent_basis};
use crate::learning::Parameters;
use crate::schema::{BodySchema, SchemaStd};
use crate::skin::Skin;

/// The length that weighs as much as a radian, metres: about a limb's radius and reach.
pub const CHARACTERISTIC_LENGTH: f64 = 0.1;
/// Singular values below this share of the greatest are zero: rounding in the squared normal equations.
const NULL_SHARE: f64 = 1e-7;
/// A joint is determined when skin beyond it can be placed to this, metres.
pub const DETERMINED: f64 = 1e-3;
/// How far an undetermined direction of unit length may move what is still called determined, metres and
/// radians: rounding.
const UNMOVED: f64 = 1e-6;
/// The part of a direction of unit length outside the null space that is rounding.
const FELT: f64 = 1e-5;
/// Least share of a null direction that is worth naming.
const NAMED_SHARE: f64 = 0.15;

/// The observability of a schema from a set of touches.
#[derive(Clone, Debug)]
pub struct Observability {
    /// The parameters that the touches involve.
    pub parameters: Parameters,
    /// Singular values of the whitened Jacobian, greatest first, per radian or characteristic length.
    pub singular_values: Vec<f64>,
    /// How many of them are not zero.
    pub rank: usize,
    /// Covariance of the determined part of the parameters (m², m, 1); undetermined directions are left
    /// out, see `null_space`.
    pub covariance: DMatrix<f64>,
    /// Orthonormal undetermined directions, one a column, in scaled parameters.
    pub null_space: DMatrix<f64>,
    unscaled_null_space: DMatrix<f64>,
    /// The information `JᵀWJ` over the parameters, from which all of this follows.
    information: DMatrix<f64>,
    /// Per joint, whether it was known exactly before the first touch and is no parameter.
    known: Vec<bool>,
    /// Per limb, whether it is known at all where points in its frame are on it.
    placed: Vec<bool>,
    residuals: usize,
}

/// The indices that the calibration literature reports.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Indices {
    /// D-optimality `(σ_1 … σ_n)^(1/n) / √m` (Borm and Menq 1991).
    pub d_optimality: f64,
    /// Inverse condition number `σ_n / σ_1` (Driels and Pathre 1990).
    pub inverse_condition: f64,
    /// Least singular value `σ_n` (Nahvi et al. 1994).
    pub minimum_singular_value: f64,
    /// Noise amplification `σ_n² / σ_1` (Nahvi and Hollerbach 1996).
    pub noise_amplification: f64,
}

impl Observability {
    /// From the information `JᵀWJ` (lower triangle) over `parameters` and the number of residuals. `known`
    /// tells of each joint whether it was known exactly a priori, and is no parameter for that reason.
    pub fn new(
        creature: &Creature,
        parameters: Parameters,
        known: &[bool],
        mut hessian: DMatrix<f64>,
        residuals: usize,
    ) -> Observability {
        let n = parameters.len();
        hessian.fill_upper_triangle_with_lower_triangle();
        let information = hessian.clone();
        let mut scale = DVector::from_element(n, 1.0);
        for offset in parameters.positions.iter().chain(&parameters.limb_origins).flatten() {
            scale.rows_mut(*offset, 3).fill(CHARACTERISTIC_LENGTH);
        }
        for (dof, offset) in creature.dofs().zip(&parameters.axes) {
            if let Some(offset) = offset.filter(|_| dof.kind == DofKind::Slide) {
                // A slide's axis turns distances, which are small where angles are not.
                scale.rows_mut(offset, 2).fill(1.0);
            }
        }
        for j in 0..n {
            for i in 0..n {
                hessian[(i, j)] *= scale[i] * scale[j];
            }
        }
        if n == 0 {
            return Observability {
                parameters,
                singular_values: Vec::new(),
                rank: 0,
                covariance: DMatrix::zeros(0, 0),
                null_space: DMatrix::zeros(0, 0),
                unscaled_null_space: DMatrix::zeros(0, 0),
                information,
                known: known.to_vec(),
                placed: vec![true; creature.limbs().len()],
                residuals,
            };
        }
        let eigen = SymmetricEigen::new(hessian);
        let mut order: Vec<usize> = (0..n).collect();
        order.sort_by(|&a, &b| eigen.eigenvalues[b].total_cmp(&eigen.eigenvalues[a]));
        let singular_values: Vec<f64> = order.iter().map(|&k| eigen.eigenvalues[k].max(0.0).sqrt()).collect();
        let greatest = singular_values.first().copied().unwrap_or(0.0);
        let rank = singular_values.iter().filter(|s| **s > NULL_SHARE * greatest).count();
        let mut covariance = DMatrix::zeros(n, n);
        for &k in &order[..rank] {
            let direction = eigen.eigenvectors.column(k).component_mul(&scale);
            covariance.ger(1.0 / eigen.eigenvalues[k], &direction, &direction, 1.0);
        }
        let null_space = DMatrix::from_fn(n, n - rank, |i, k| eigen.eigenvectors[(i, order[rank + k])]);
        let mut unscaled_null_space = null_space.clone();
        for (mut row, scale) in unscaled_null_space.row_iter_mut().zip(&scale) {
            row *= *scale;
        }
        Observability {
            parameters,
            singular_values,
            rank,
            covariance,
            null_space,
            unscaled_null_space,
            information,
            known: known.to_vec(),
            placed: vec![true; creature.limbs().len()],
            residuals,
        }
    }

    /// The information `JᵀWJ` over the parameters; [`Observability::new`] makes all of this of it again.
    pub fn information(&self) -> &DMatrix<f64> {
        &self.information
    }

    /// The number of residuals that the information is of.
    pub fn residuals(&self) -> usize {
        self.residuals
    }

    /// Per joint, whether it was known exactly before the first touch and is no parameter.
    pub fn known(&self) -> &[bool] {
        &self.known
    }

    /// Per limb, whether it is known at all where points in its frame are on it.
    pub fn placed(&self) -> &[bool] {
        &self.placed
    }

    /// Sets of each limb whether it is known at all where points in its frame are on it; all are by default.
    pub fn with_placed(mut self, placed: Vec<bool>) -> Observability {
        self.placed = placed;
        self
    }

    /// Greatest over least singular value; infinite where something is undetermined.
    pub fn condition(&self) -> f64 {
        let greatest = self.singular_values.first().copied().unwrap_or(0.0);
        if self.rank < self.singular_values.len() {
            return f64::INFINITY;
        }
        greatest / self.singular_values.last().copied().unwrap_or(0.0)
    }

    /// The calibration literature's indices, over the determined directions.
    pub fn indices(&self) -> Indices {
        let values = &self.singular_values[..self.rank];
        let (greatest, least) =
            (values.first().copied().unwrap_or(0.0), values.last().copied().unwrap_or(0.0));
        let logarithms: f64 = values.iter().map(|s| s.ln()).sum();
        Indices {
            d_optimality: (logarithms / self.rank.max(1) as f64).exp()
                / (self.residuals.max(1) as f64).sqrt(),
            inverse_condition: least / greatest,
            minimum_singular_value: least,
            noise_amplification: least * least / greatest,
        }
    }

    /// Standard deviation of a joint's position, metres: the root of the covariance's trace; none where the
    /// touches do not involve it.
    pub fn position_deviation(&self, joint: usize) -> Option<f64> {
        let offset = self.parameters.positions[joint]?;
        let block = self.covariance.view((offset, offset), (3, 3));
        Some(block.trace().max(0.0).sqrt())
    }

    /// Standard deviation of an axis' direction, radians.
    pub fn axis_deviation(&self, dof: usize) -> Option<f64> {
        let offset = self.parameters.axes[dof]?;
        let block = self.covariance.view((offset, offset), (2, 2));
        Some(block.trace().max(0.0).sqrt())
    }

    /// Standard deviation of each coordinate of a joint's position `l_P`, metres. None for a coordinate that
    /// the touches leave open, all three of a joint that they do not involve.
    pub fn position_std(&self, joint: usize) -> [Option<f64>; 3] {
        let Some(offset) = self.parameters.positions[joint] else {
            return [self.known[joint].then_some(0.0); 3];
        };
        [0, 1, 2].map(|i| self.parameter_std(offset + i))
    }

    /// Standard deviation of each of the two coordinates of an axis across its direction, radians: the root
    /// of their mean variance. None where the touches leave its direction open, and for a ball.
    pub fn axis_std(&self, creature: &Creature, dof: usize) -> Option<f64> {
        let known = |joint: usize| self.known[joint] && creature.joints()[joint].dof_indices().contains(&dof);
        if (0..self.known.len()).any(known) {
            return Some(0.0);
        }
        let offset = self.parameters.axes[dof]?;
        let [first, second] = [self.parameter_std(offset)?, self.parameter_std(offset + 1)?];
        Some((0.5 * (first * first + second * second)).sqrt())
    }

    /// The standard deviations of all positions and axes.
    pub fn schema_std(&self, creature: &Creature) -> SchemaStd {
        SchemaStd {
            positions: (0..creature.joints().len()).map(|joint| self.position_std(joint)).collect(),
            axes: (0..creature.dof_elements()).map(|dof| self.axis_std(creature, dof)).collect(),
        }
    }

    /// Standard deviation of one parameter; none where an undetermined direction moves it.
    pub fn parameter_std(&self, index: usize) -> Option<f64> {
        let open = self.unscaled_null_space.row(index).iter().any(|shift| shift.abs() > UNMOVED);
        (!open).then(|| self.covariance[(index, index)].max(0.0).sqrt())
    }

    /// The standard deviation with which the schema puts a point `p_a` of limb `a` into the frame of limb
    /// `b`, metres: the root of the trace of `J Σ Jᵀ`. Infinite where an undetermined direction moves it or
    /// a joint between was never touched.
    pub fn point_deviation(
        &self,
        creature: &Creature,
        schema: &BodySchema,
        posture: &[f64],
        limbs: [usize; 2],
        p_a: &Vector3<f64>,
    ) -> f64 {
        let covariance = self.point_covariance(creature, schema, posture, limbs, p_a);
        covariance.map_or(f64::INFINITY, |covariance| covariance.trace().max(0.0).sqrt())
    }

    /// The covariance `J Σ Jᵀ` with which the schema puts a point `p_a` of limb `a` into the frame of limb
    /// `b`, in that frame, m². None where an undetermined direction moves it or a joint between was never
    /// touched.
    pub fn point_covariance(
        &self,
        creature: &Creature,
        schema: &BodySchema,
        posture: &[f64],
        limbs: [usize; 2],
        p_a: &Vector3<f64>,
    ) -> Option<Matrix3<f64>> {
        let chain = Chain::between(creature, limbs[0], limbs[1]);
        if chain.joints().any(|joint| self.untouched(joint)) || limbs.iter().any(|&limb| !self.placed[limb]) {
            return None;
        }
        let frames = limb_frames(creature, schema, posture);
        let p_b = frames[limbs[1]].inverse_point(&frames[limbs[0]].point(p_a));
        let jacobian = self.miss_jacobian(creature, schema, &chain, posture, [*p_a, p_b]);
        // A chain moves few of the parameters.
        let moved: Vec<usize> = (0..jacobian.ncols()).filter(|&c| jacobian.column(c).amax() > 0.0).collect();
        let jacobian = jacobian.select_columns(&moved);
        // A direction that no touch felt and that moves the point by more than rounding: unbounded.
        if self.null_space.ncols() > 0 {
            let shift = &jacobian * self.unscaled_null_space.select_rows(&moved);
            if shift.amax() > UNMOVED {
                return None;
            }
        }
        let covariance = self.covariance.select_rows(&moved).select_columns(&moved);
        let product = &jacobian * covariance * jacobian.transpose();
        let covariance_c = Matrix3::from_fn(|i, j| product[(i, j)]);
        let r_bc = frames[limbs[1]].rotation.tr_mul(&frames[chain.ancestor].rotation);
        Some(r_bc * covariance_c * r_bc.transpose())
    }

    /// The joints that the touches leave undetermined: those through which no skin point of any limb can be
    /// put into another limb's frame to [`DETERMINED`]. Postures are drawn at random.
    pub fn undetermined_joints(&self, agent: &Agent, schema: &BodySchema) -> Vec<usize> {
        self.joints_not_placed_to(DETERMINED, agent, schema)
    }

    /// The same for another standard deviation than [`DETERMINED`], metres.
    pub fn joints_not_placed_to(&self, sharpness: f64, agent: &Agent, schema: &BodySchema) -> Vec<usize> {
        let creature = agent.creature();
        let mut rng = ChaCha8Rng::seed_from_u64(0);
        let mut best = vec![f64::INFINITY; creature.joints().len()];
        let on_limb = |limb: usize| agent.skin().receptors.iter().find(|receptor| receptor.limb == limb);
        let limbs: Vec<usize> = (0..creature.limbs().len()).filter(|&l| on_limb(l).is_some()).collect();
        // Every pair of limbs once; of very many, enough that each joint is met often.
        let pairs = limbs.iter().flat_map(|&a| limbs.iter().map(move |&b| [a, b])).filter(|[a, b]| a < b);
        let pairs: Vec<[usize; 2]> = pairs.collect();
        let every = (pairs.len() / 600).max(1);
        for [a, b] in pairs.into_iter().step_by(every) {
            let Some(receptor) = on_limb(a) else { continue };
            let posture = Posture::random(creature, &mut rng);
            let deviation = self.point_deviation(creature, schema, &posture, [a, b], &receptor.position);
            for joint in Chain::between(creature, a, b).joints() {
                best[joint] = best[joint].min(deviation);
            }
        }
        (0..best.len()).filter(|&joint| best[joint] > sharpness && !self.known[joint]).collect()
    }

    /// The limbs with skin whose own frames the touches do not tell: those of which no three receptors far
    /// apart can all be put into another limb's frame to [`DETERMINED`]. None where no limb's pose is learned.
    /// Postures are drawn at random.
    pub fn undetermined_limbs(&self, agent: &Agent, schema: &BodySchema) -> Vec<usize> {
        if schema.limb_poses.is_empty() {
            return Vec::new();
        }
        let creature = agent.creature();
        let mut rng = ChaCha8Rng::seed_from_u64(0);
        let far_apart: Vec<Vec<Vector3<f64>>> =
            (0..creature.limbs().len()).map(|limb| three_far_apart(agent.skin(), limb)).collect();
        let with_skin: Vec<usize> =
            (0..far_apart.len()).filter(|&limb| !far_apart[limb].is_empty()).collect();
        let told = |limb: usize, rng: &mut ChaCha8Rng| {
            with_skin.iter().filter(|&&other| other != limb).any(|&other| {
                let posture = Posture::random(creature, rng);
                far_apart[limb].iter().all(|point| {
                    let limbs = [limb, other];
                    self.point_deviation(creature, schema, &posture, limbs, point) <= DETERMINED
                })
            })
        };
        with_skin.iter().copied().filter(|&limb| !told(limb, &mut rng)).collect()
    }

    /// Whether nothing is known of a joint: no touch involves it.
    fn untouched(&self, joint: usize) -> bool {
        self.parameters.positions[joint].is_none() && !self.known[joint]
    }

    /// `∂(p_CA − p_CB)` over the parameters, 3×n.
    fn miss_jacobian(
        &self,
        creature: &Creature,
        schema: &BodySchema,
        chain: &Chain,
        posture: &[f64],
        points: [Vector3<f64>; 2],
    ) -> DMatrix<f64> {
        let mut jacobian = DMatrix::zeros(3, self.parameters.len());
        let mut side = SideJacobian::default();
        for (k, sign) in [(0, 1.0), (1, -1.0)] {
            ChainSide::new(creature, &chain.sides[k], posture).point_jacobian(schema, &points[k], &mut side);
            for (joint, map) in &side.joints {
                if let Some(offset) = self.parameters.positions[*joint] {
                    let mut block = jacobian.fixed_view_mut::<3, 3>(0, offset);
                    block += map * sign;
                }
            }
            for (dof, derivative) in &side.dofs {
                if let Some(offset) = self.parameters.axes[*dof] {
                    let mut block = jacobian.fixed_view_mut::<3, 2>(0, offset);
                    block += derivative * tangent_basis(&schema.axes[*dof]) * sign;
                }
            }
            for pose in &side.poses {
                if let Some(offset) = self.parameters.limb_origins[pose.joint] {
                    let mut block = jacobian.fixed_view_mut::<3, 3>(0, offset);
                    block += pose.map * sign;
                }
                if let Some(offset) = self.parameters.limb_rotations[pose.joint] {
                    // ω × Q p.
                    let turned = schema.limb_poses[pose.joint].rotation * pose.point;
                    let mut block = jacobian.fixed_view_mut::<3, 3>(0, offset);
                    block += pose.map * skew(&turned) * -sign;
                }
            }
        }
        jacobian
    }

    /// Every undetermined direction, in words.
    ///
    /// First those that bodies often have: a joint that slides along its own axis while the joints on the limb
    /// it carries slide back. What is left of the null space is turned so that few joints carry each direction
    /// (varimax-like, by pivoting), and named by the joints that move and how.
    pub fn undetermined(&self, creature: &Creature, schema: &BodySchema) -> Vec<String> {
        let mut words = Vec::new();
        for (j, joint) in creature.joints().iter().enumerate() {
            if self.untouched(j) {
                words.push(format!("{}: never exercised, no touch involves it or too few do", joint.name));
            }
        }
        let slides = self.slides(creature, schema);
        let rest = sparse_basis(&without(&self.null_space, &slides));
        for direction in slides.into_iter().chain(rest) {
            let sentence = self.describe(creature, schema, &direction);
            // Two directions of one axis read alike: once is enough.
            if !words.contains(&sentence) {
                words.push(sentence);
            }
        }
        words
    }

    /// The undetermined directions, of unit length, in which a joint's position slides along an axis of its
    /// own and the positions of the joints beyond it back.
    fn slides(&self, creature: &Creature, schema: &BodySchema) -> Vec<DVector<f64>> {
        let mut slides = Vec::new();
        for (j, joint) in creature.joints().iter().enumerate() {
            let Some(offset) = self.parameters.positions[j] else { continue };
            for (k, _) in joint.dof_indices().zip(&joint.dofs).filter(|(_, dof)| dof.kind == DofKind::Hinge) {
                let mut slide = DVector::zeros(self.parameters.len());
                slide.fixed_rows_mut::<3>(offset).copy_from(&schema.axes[k]);
                for (next, other) in creature.joints().iter().enumerate() {
                    if let Some(offset) = self.parameters.positions[next].filter(|_| other.parent == j + 1) {
                        slide.fixed_rows_mut::<3>(offset).copy_from(&-schema.axes[k]);
                    }
                }
                slide.normalize_mut();
                let felt = &slide - &self.null_space * self.null_space.tr_mul(&slide);
                if felt.norm() < FELT {
                    slides.push(slide);
                }
            }
        }
        slides
    }

    fn describe(&self, creature: &Creature, schema: &BodySchema, direction: &DVector<f64>) -> String {
        let mut moved = Vec::new();
        for (j, joint) in creature.joints().iter().enumerate() {
            if let Some(offset) = self.parameters.positions[j] {
                let shift: Vector3<f64> = direction.fixed_rows::<3>(offset).into();
                if shift.norm() > NAMED_SHARE {
                    let along = shift.normalize();
                    let own = joint.dof_indices().find(|&k| schema.axes[k].dot(&along).abs() > 0.99);
                    moved.push(match own {
                        Some(k) => {
                            let dof = &joint.dofs[k - joint.first_dof()].name;
                            format!("{} may slide along the axis of {dof}", joint.name)
                        }
                        None => format!(
                            "{} may shift along ({:.2}, {:.2}, {:.2})",
                            joint.name, along.x, along.y, along.z
                        ),
                    });
                }
            }
            for (k, dof) in joint.dof_indices().zip(&joint.dofs) {
                if let Some(offset) = self.parameters.axes[k]
                    && direction.rows(offset, 2).norm() > NAMED_SHARE
                {
                    moved.push(format!("the axis of {} may turn", dof.name));
                }
            }
        }
        match moved.len() {
            0 => "a direction spread over many joints".to_string(),
            1 => moved.remove(0),
            _ => format!("together: {}", moved.join("; ")),
        }
    }
}

/// An orthonormal basis of what is in an orthonormal `space` and perpendicular to the `directions` in it.
fn without(space: &DMatrix<f64>, directions: &[DVector<f64>]) -> DMatrix<f64> {
    if directions.is_empty() || space.ncols() == 0 {
        return space.clone();
    }
    // In coordinates of the space.
    let inside = space.tr_mul(&DMatrix::from_columns(directions));
    let eigen = SymmetricEigen::new(&inside * inside.transpose());
    let greatest = eigen.eigenvalues.amax();
    let left: Vec<usize> =
        (0..space.ncols()).filter(|&k| eigen.eigenvalues[k] < NULL_SHARE * greatest).collect();
    space * eigen.eigenvectors.select_columns(&left)
}

/// A basis of the same space whose directions have few large entries: reduced to echelon form by the
/// largest pivots, then scaled to unit length.
fn sparse_basis(space: &DMatrix<f64>) -> Vec<DVector<f64>> {
    let mut rows = space.transpose();
    let (count, n) = rows.shape();
    for step in 0..count {
        let mut pivot = (step, 0, 0.0);
        for i in step..count {
            for j in 0..n {
                if rows[(i, j)].abs() > pivot.2 {
                    pivot = (i, j, rows[(i, j)].abs());
                }
            }
        }
        if pivot.2 == 0.0 {
            break;
        }
        rows.swap_rows(step, pivot.0);
        let lead = rows[(step, pivot.1)];
        for other in (0..count).filter(|&other| other != step) {
            let factor = rows[(other, pivot.1)] / lead;
            for j in 0..n {
                rows[(other, j)] -= factor * rows[(step, j)];
            }
        }
    }
    rows.row_iter().map(|row| row.transpose().normalize()).collect()
}

/// Up to three receptors of a limb that are far from one another, metres in the limb's frame.
fn three_far_apart(skin: &Skin, limb: usize) -> Vec<Vector3<f64>> {
    let all: Vec<Vector3<f64>> =
        skin.receptors.iter().filter(|receptor| receptor.limb == limb).map(|r| r.position).collect();
    let mut chosen: Vec<Vector3<f64>> = all.first().copied().into_iter().collect();
    while chosen.len() < 3.min(all.len()) {
        let nearest = |p: &Vector3<f64>| chosen.iter().map(|q| (p - q).norm()).fold(f64::INFINITY, f64::min);
        let farthest = all.iter().max_by(|a, b| nearest(a).total_cmp(&nearest(b)));
        chosen.extend(farthest.copied());
    }
    chosen
}
