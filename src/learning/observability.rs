//! What the touches determine, how well, and what they leave open.
//!
//! The normal equations at the learned schema say it all: their singular values give rank, condition and
//! the indices that the calibration literature reports; their inverse gives the standard deviation of
//! every position and axis; what lies in their null space no touch can feel.
//!
//! Positions and axes have different units. To compare them, positions are counted in units of a
//! characteristic length, so that a singular value tells how much whitened residual a turn of one radian,
//! or a shift of that length, makes.

use nalgebra::{DMatrix, DVector, Matrix3, SymmetricEigen, Vector3};
use serde::Serialize;

use crate::creature::{Creature, DofKind};
use crate::geometry::tangent_basis;
use crate::kinematics::{Chain, ChainSide, SideJacobian, limb_frames};
use crate::learning::{LengthUnit, Parameters};
use crate::schema::{BodySchema, SchemaStd};

/// The length that weighs as much as a radian, in the unit that a body is learned in: about a limb's radius and reach.
pub const CHARACTERISTIC_LENGTH: f64 = 0.1;
/// Singular values below this share of the greatest are zero: rounding in the squared normal equations.
const NULL_SHARE: f64 = 1e-7;
/// How far an undetermined direction of unit length may move what is still called determined, metres and
/// radians: rounding.
pub(super) const UNMOVED: f64 = 1e-6;
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
    /// `L` of the covariance `L Lᵀ`, a column per determined direction (m, 1).
    covariance_factor: DMatrix<f64>,
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
    /// What it was worked out in; all lengths are metres.
    unit: LengthUnit,
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
    /// tells of each joint whether it was known exactly a priori, and is no parameter for that reason. Of bodies that are
    /// learned in a unit of their own, lengths are compared with turns in that.
    pub fn new(
        creature: &Creature,
        parameters: Parameters,
        known: &[bool],
        mut hessian: DMatrix<f64>,
        residuals: usize,
        unit: LengthUnit,
    ) -> Observability {
        let n = parameters.len();
        hessian.fill_upper_triangle_with_lower_triangle();
        let information = hessian.clone();
        let mut scale = DVector::from_element(n, 1.0);
        for offset in parameters.positions.iter().chain(&parameters.limb_origins).flatten() {
            scale.rows_mut(*offset, 3).fill(CHARACTERISTIC_LENGTH * unit.metres());
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
        let (eigenvalues, eigenvectors) = match n {
            0 => (DVector::zeros(0), hessian),
            _ => {
                let eigen = SymmetricEigen::new(hessian);
                (eigen.eigenvalues, eigen.eigenvectors)
            }
        };
        let mut order: Vec<usize> = (0..n).collect();
        order.sort_by(|&a, &b| eigenvalues[b].total_cmp(&eigenvalues[a]));
        let singular_values: Vec<f64> = order.iter().map(|&k| eigenvalues[k].max(0.0).sqrt()).collect();
        let greatest = singular_values.first().copied().unwrap_or(0.0);
        let rank = singular_values.iter().filter(|s| **s > NULL_SHARE * greatest).count();
        let covariance_factor = DMatrix::from_fn(n, rank, |i, k| {
            scale[i] * eigenvectors[(i, order[k])] / eigenvalues[order[k]].sqrt()
        });
        let covariance = &covariance_factor * covariance_factor.transpose();
        let null_space = DMatrix::from_fn(n, n - rank, |i, k| eigenvectors[(i, order[rank + k])]);
        let mut unscaled_null_space = null_space.clone();
        for (mut row, scale) in unscaled_null_space.row_iter_mut().zip(&scale) {
            row *= *scale;
        }
        Observability {
            parameters,
            singular_values,
            rank,
            covariance,
            covariance_factor,
            null_space,
            unscaled_null_space,
            information,
            known: known.to_vec(),
            placed: vec![true; creature.limbs().len()],
            residuals,
            unit,
        }
    }

    /// The same in metres, where it was worked out in another unit: what is determined stays what it was in that.
    pub fn in_metres(mut self, unit: LengthUnit) -> Observability {
        let mut metres = DVector::from_element(self.parameters.len(), 1.0);
        for offset in self.parameters.positions.iter().chain(&self.parameters.limb_origins).flatten() {
            metres.rows_mut(*offset, 3).fill(unit.metres());
        }
        let rows = |matrix: &mut DMatrix<f64>| {
            matrix.row_iter_mut().zip(&metres).for_each(|(mut row, metres)| row *= *metres);
        };
        rows(&mut self.covariance_factor);
        rows(&mut self.unscaled_null_space);
        let n = metres.len();
        for (i, j) in (0..n).flat_map(|i| (0..n).map(move |j| (i, j))) {
            let by = metres[i] * metres[j];
            self.covariance[(i, j)] *= by;
            self.information[(i, j)] /= by;
        }
        Observability { unit, ..self }
    }

    /// The unit of length that it was worked out in.
    pub fn unit(&self) -> LengthUnit {
        self.unit
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

    /// `L` of the covariance `L Lᵀ` of the parameters, a column per determined direction (m, 1).
    pub(super) fn covariance_factor(&self) -> &DMatrix<f64> {
        &self.covariance_factor
    }

    /// The greatest share that some touches, of the information `JᵀWJ` (symmetric), have in what is known of any direction: 1
    /// where nothing else tells of it. It is the greatest eigenvalue of `Lᵀ JᵀWJ L` with the covariance `L Lᵀ` and, which is
    /// less work for few touches, of `Rᵀ L Lᵀ R` with `R Rᵀ = JᵀWJ`.
    pub(super) fn greatest_leverage(&self, information: &DMatrix<f64>) -> f64 {
        let felt: Vec<usize> = (0..information.ncols()).filter(|&k| information[(k, k)] > 0.0).collect();
        if felt.is_empty() {
            return 0.0;
        }
        let told = SymmetricEigen::new(information.select_rows(&felt).select_columns(&felt));
        let least = f64::EPSILON * felt.len() as f64 * told.eigenvalues.max();
        let along: Vec<usize> = (0..felt.len()).filter(|&k| told.eigenvalues[k] > least).collect();
        let mut root = told.eigenvectors.select_columns(&along);
        let lengths = along.iter().map(|&k| told.eigenvalues[k].sqrt());
        lengths.enumerate().for_each(|(column, length)| root.column_mut(column).scale_mut(length));
        let factor = self.covariance_factor.select_rows(&felt).tr_mul(&root);
        SymmetricEigen::new(factor.tr_mul(&factor)).eigenvalues.max()
    }

    /// Directions of unit length in scaled parameters, in the units of the parameters, one a column (m, 1): those known to this
    /// standard deviation or better, radians or characteristic lengths, and all others.
    pub(super) fn directions(&self, deviation: f64) -> [DMatrix<f64>; 2] {
        let well =
            self.singular_values[..self.rank].iter().take_while(|&&value| value * deviation >= 1.0).count();
        let mut determined = self.covariance_factor.clone();
        for (mut column, value) in determined.column_iter_mut().zip(&self.singular_values) {
            column *= *value;
        }
        let badly = determined.columns(well, self.rank - well);
        let open = &self.unscaled_null_space;
        let mut others = DMatrix::zeros(open.nrows(), badly.ncols() + open.ncols());
        others.columns_mut(0, badly.ncols()).copy_from(&badly);
        others.columns_mut(badly.ncols(), open.ncols()).copy_from(open);
        [determined.columns(0, well).into_owned(), others]
    }

    /// The undetermined directions in the units of the parameters, one a column (m, 1).
    pub(super) fn open_directions(&self) -> &DMatrix<f64> {
        &self.unscaled_null_space
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
        let jacobian = miss_jacobian(&self.parameters, creature, schema, &chain, posture, [*p_a, p_b]);
        let product = self.shift_covariance(&jacobian)?;
        let covariance_c = Matrix3::from_fn(|i, j| product[(i, j)]);
        let r_bc = frames[limbs[1]].rotation.tr_mul(&frames[chain.ancestor].rotation);
        Some(r_bc * covariance_c * r_bc.transpose())
    }

    /// The covariance `J Σ Jᵀ` of what the parameters shift, with a row for each length that they do and a column a parameter,
    /// m². None where an undetermined direction shifts any.
    pub fn shift_covariance(&self, jacobian: &DMatrix<f64>) -> Option<DMatrix<f64>> {
        // A chain moves few of the parameters.
        let moved: Vec<usize> = (0..jacobian.ncols()).filter(|&c| jacobian.column(c).amax() > 0.0).collect();
        let jacobian = jacobian.select_columns(&moved);
        // A direction that no touch felt and that moves the point by more than rounding: unbounded.
        if self.null_space.ncols() > 0 {
            let shift = &jacobian * self.unscaled_null_space.select_rows(&moved);
            if shift.amax() > UNMOVED * self.unit.metres() {
                return None;
            }
        }
        let covariance = self.covariance.select_rows(&moved).select_columns(&moved);
        Some(&jacobian * covariance * jacobian.transpose())
    }

    /// Whether nothing is known of a joint: no touch involves it.
    pub(super) fn untouched(&self, joint: usize) -> bool {
        self.parameters.positions[joint].is_none() && !self.known[joint]
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

/// `∂(p_CA − p_CB)` over the parameters, 3×n.
pub(super) fn miss_jacobian(
    parameters: &Parameters,
    creature: &Creature,
    schema: &BodySchema,
    chain: &Chain,
    posture: &[f64],
    points: [Vector3<f64>; 2],
) -> DMatrix<f64> {
    let mut jacobian = DMatrix::zeros(3, parameters.len());
    let mut side = SideJacobian::default();
    for (k, sign) in [(0, 1.0), (1, -1.0)] {
        ChainSide::new(creature, &chain.sides[k], posture).point_jacobian(schema, &points[k], &mut side);
        let basis = |dof: usize| tangent_basis(&schema.axes[dof]);
        for (i, mut row) in jacobian.row_iter_mut().enumerate() {
            parameters.slopes(schema, &side, &Vector3::ith(i, sign), basis, |offset, slopes| {
                slopes.iter().enumerate().for_each(|(k, slope)| row[offset + k] = *slope);
            });
        }
    }
    jacobian
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
