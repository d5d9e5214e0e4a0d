//! What a schema expects a touch to be before it is learned from.
//!
//! At the posture of a touch the schema puts the two surfaces a gap apart, which should be zero. How far
//! from zero it may be follows from how sure the schema is: with the gap's derivative `j` over the
//! parameters and their covariance `Σ`, its variance is `σ² + j Σ jᵀ`.

use nalgebra::{DMatrix, Vector3};

use crate::agent::Agent;
use crate::geometry::{Frame, tangent_basis};
use crate::kinematics::SideJacobian;
use crate::learning::least_squares::LeastSquares;
use crate::learning::surface_gap::SurfaceGap;
use crate::learning::touch_set::{PreparedTouch, TouchProblem, TouchSet};
use crate::learning::{Parameters, Prior};
use crate::schema::BodySchema;
use crate::skin::Skin;

/// The gap of one touch and its derivative.
#[derive(Clone, Debug, Default)]
pub struct GapRow {
    /// The gap at the schema, metres; negative where the limbs overlap.
    pub gap: f64,
    /// Its derivative as pairs of a parameter's place and the derivative by it, each place once.
    pub entries: Vec<(usize, f64)>,
    /// Per end, where the surfaces are closest, in the limb's frame, metres.
    pub points: [Vector3<f64>; 2],
    /// Per end, the gap's derivative by a shift of that end's surface, in the limb's frame.
    pub normals: [Vector3<f64>; 2],
    sides: [SideJacobian; 2],
}

impl GapRow {
    /// Sets the row to a touch at a schema. Buffers are used again.
    pub fn set(&mut self, skin: &Skin, parameters: &Parameters, schema: &BodySchema, touch: &PreparedTouch) {
        self.set_shifted(skin, parameters, schema, touch, &[Vector3::zeros(); 2]);
    }

    /// The same where the skin of either end is shifted on its limb, in the limb's frame, metres.
    pub fn set_shifted(
        &mut self,
        skin: &Skin,
        parameters: &Parameters,
        schema: &BodySchema,
        touch: &PreparedTouch,
        shifts: &[Vector3<f64>; 2],
    ) {
        let frames = touch.frames(schema);
        let shifted = [0, 1].map(|k| Frame { origin: frames[k].point(&shifts[k]), ..frames[k] });
        let found = SurfaceGap::new(skin, 1.0).gap(&touch.ends, &shifted);
        self.gap = found.distance;
        self.points = [0, 1].map(|k| frames[k].inverse_point(&found.middle()));
        self.normals =
            [0, 1].map(|k| frames[k].rotation.tr_mul(&found.normal) * if k == 0 { 1.0 } else { -1.0 });
        self.fill(parameters, schema, touch, &found.normal);
    }

    /// The gap's derivative by every hinge's angle at the schema that the row was set to, metres a radian, with its degree of
    /// freedom; into `slopes`.
    pub fn angle_slopes(&self, schema: &BodySchema, touch: &PreparedTouch, slopes: &mut Vec<(usize, f64)>) {
        let along = touch.sides[0].frame(schema).rotation * self.normals[0];
        let derivatives = touch.angle_derivatives(schema, self.points.each_ref());
        slopes.clear();
        slopes.extend(derivatives.iter().map(|(dof, derivative)| (*dof, along.dot(derivative))));
    }

    /// Sets the row to how far apart a schema leaves the two places of a touch along a unit vector of the common frame.
    pub fn set_miss(
        &mut self,
        parameters: &Parameters,
        schema: &BodySchema,
        touch: &PreparedTouch,
        along: &Vector3<f64>,
    ) {
        let frames = touch.frames(schema);
        self.gap = along.dot(&touch.miss(schema));
        self.points = [0, 1].map(|k| touch.ends[k].position);
        self.normals = [0, 1].map(|k| frames[k].rotation.tr_mul(along) * if k == 0 { 1.0 } else { -1.0 });
        self.fill(parameters, schema, touch, along);
    }

    /// The derivative of how far apart the two points are along a unit vector of the common frame.
    fn fill(
        &mut self,
        parameters: &Parameters,
        schema: &BodySchema,
        touch: &PreparedTouch,
        along: &Vector3<f64>,
    ) {
        self.entries.clear();
        for (k, sign) in [(0, 1.0), (1, -1.0)] {
            let side = &mut self.sides[k];
            touch.sides[k].point_jacobian(schema, &self.points[k], side);
            let entries = &mut self.entries;
            let push = |offset: usize, slopes: &[f64]| {
                entries.extend(slopes.iter().enumerate().map(|(i, slope)| (offset + i, *slope)));
            };
            let basis = |dof: usize| tangent_basis(&schema.axes[dof]);
            parameters.slopes(schema, side, &(along * sign), basis, push);
        }
    }

    /// `j Σ jᵀ` for a covariance of all parameters, m².
    pub fn variance(&self, covariance: &DMatrix<f64>) -> f64 {
        row_variance(&self.entries, covariance)
    }
}

/// `j Σ jᵀ` of a derivative j, given as pairs of a parameter's place and the derivative by it.
pub fn row_variance(row: &[(usize, f64)], covariance: &DMatrix<f64>) -> f64 {
    let product = |column: usize| -> f64 {
        let column = covariance.column(column);
        row.iter().map(|&(place, slope)| slope * column[place]).sum()
    };
    row.iter().map(|&(column, slope)| slope * product(column)).sum()
}

/// Adds `w jᵀj` of such a derivative to information, both triangles.
pub fn add_row(information: &mut DMatrix<f64>, row: &[(usize, f64)], weight: f64) {
    for &(column, slope) in row {
        let scaled = weight * slope;
        row.iter().for_each(|&(place, other)| information[(place, column)] += scaled * other);
    }
}

/// The covariance of all parameters that touches of a gap deviation (metres) and a prior leave at a
/// schema; none where rounding makes it unusable.
pub fn covariance(
    agent: &Agent,
    touches: &TouchSet,
    parameters: &Parameters,
    prior: &Prior,
    schema: &BodySchema,
    deviation: f64,
) -> Option<DMatrix<f64>> {
    let model = SurfaceGap::new(agent.skin(), deviation);
    let mut problem = TouchProblem::new(agent.creature(), touches, parameters, model).with_prior(prior);
    information_inverse(problem.linearize(schema).hessian, parameters)
}

/// The covariance that normal equations (lower triangle) leave of parameters; none where rounding makes it
/// unusable.
pub fn information_inverse(mut information: DMatrix<f64>, parameters: &Parameters) -> Option<DMatrix<f64>> {
    doubt_axes(&mut information, parameters, 0);
    invert(information)
}

/// Adds to information, in which the parameters begin at a place, that no axis is less certain than a radian.
pub fn doubt_axes(information: &mut DMatrix<f64>, parameters: &Parameters, first: usize) {
    for place in parameters.axes.iter().flatten().map(|offset| first + offset) {
        (0..2).for_each(|i| information[(place + i, place + i)] += 1.0);
    }
}

/// The inverse of a positive definite matrix given by its lower triangle, scaled to a unit diagonal on the
/// way: metres and radians make it look worse than it is.
pub fn invert(mut information: DMatrix<f64>) -> Option<DMatrix<f64>> {
    let n = information.nrows();
    let scale: Vec<f64> = (0..n).map(|i| 1.0 / information[(i, i)].max(f64::MIN_POSITIVE).sqrt()).collect();
    for j in 0..n {
        for i in j..n {
            information[(i, j)] *= scale[i] * scale[j];
        }
    }
    let mut inverse = information.cholesky()?.inverse();
    for j in 0..n {
        for i in 0..n {
            inverse[(i, j)] *= scale[i] * scale[j];
        }
    }
    inverse.iter().all(|x| x.is_finite()).then_some(inverse)
}
