//! What an imagined touch would tell of the schema.
//!
//! A touch says that the gap of two surfaces is zero. With j its derivative by all parameters and Σ their
//! covariance given the touches so far, the touch brings ½ log(1 + jᵀ Σ j / σ²) nats (Lindley 1956).

use nalgebra::{DMatrix, DVector, Vector3};

use crate::creature::Creature;
use crate::kinematics::{SideJacobian, tangent_basis};
use crate::learning::least_squares::LeastSquares;
use crate::learning::rough::prepare;
use crate::learning::surface_gap::{Meeting, SurfaceGap};
use crate::learning::touch_set::{PairTouches, TouchProblem};
use crate::learning::{AxisModel, Parameters};
use crate::schema::BodySchema;
use crate::senses::{Touch, TouchEnd};
use crate::skin::Skin;

/// What is believed of a position before any touch: standard deviation, metres.
const POSITION_DEVIATION: f64 = 0.1;
/// What is believed of an axis before any touch: standard deviation in each direction, radians.
const AXIS_DEVIATION: f64 = 1.0;

/// The covariance of all positions and axes given the touches so far.
pub struct Information {
    parameters: Parameters,
    covariance: DMatrix<f64>,
    deviation: f64,
}

impl Information {
    /// Before any touch.
    pub fn new(creature: &Creature) -> Information {
        let parameters = Parameters::new(creature, AxisModel::Unit, |_| true);
        let n = parameters.len();
        let mut prior = DVector::from_element(n, AXIS_DEVIATION * AXIS_DEVIATION);
        for offset in parameters.positions.iter().flatten() {
            prior.rows_mut(*offset, 3).fill(POSITION_DEVIATION * POSITION_DEVIATION);
        }
        Information { parameters, covariance: DMatrix::from_diagonal(&prior), deviation: POSITION_DEVIATION }
    }

    /// Works it out anew at a schema, with a standard deviation of the gap in metres.
    pub fn rebuild(
        &mut self,
        creature: &Creature,
        skin: &Skin,
        schema: &BodySchema,
        touches: &[Touch],
        deviation: f64,
    ) {
        let set = prepare(creature, skin, |limb| limb, touches);
        let mut problem =
            TouchProblem::new(creature, &set, &self.parameters, SurfaceGap::new(skin, deviation));
        let mut information = problem.linearize(schema).hessian;
        information.fill_upper_triangle_with_lower_triangle();
        let prior = Information::new(creature).covariance;
        for k in 0..information.nrows() {
            information[(k, k)] += 1.0 / prior[(k, k)];
        }
        self.deviation = deviation;
        self.covariance = match information.cholesky() {
            Some(factor) => factor.inverse(),
            None => prior,
        };
    }

    /// The derivative of the gap between two receptors' surfaces in a posture, by all parameters.
    pub fn row(
        &self,
        creature: &Creature,
        skin: &Skin,
        schema: &BodySchema,
        receptors: [usize; 2],
        posture: &[f64],
    ) -> DVector<f64> {
        let (pair, meeting) = meeting(creature, skin, schema, receptors, posture);
        let touch = &pair.touches[0];
        let frames = touch.frames(schema);
        let mut row = DVector::zeros(self.parameters.len());
        let mut side = SideJacobian::default();
        for (k, sign) in [(0, 1.0), (1, -1.0)] {
            let point = frames[k].inverse_point(&meeting.point);
            touch.sides[k].point_jacobian(schema, &point, &mut side);
            let direction = meeting.normal * sign;
            for (joint, map) in &side.joints {
                if let Some(offset) = self.parameters.positions[*joint] {
                    let mut block = row.fixed_rows_mut::<3>(offset);
                    block += map.tr_mul(&direction);
                }
            }
            for (dof, derivative) in &side.dofs {
                if let Some(offset) = self.parameters.axes[*dof] {
                    let free = derivative.tr_mul(&direction);
                    let mut block = row.fixed_rows_mut::<2>(offset);
                    block += tangent_basis(&schema.axes[*dof]).tr_mul(&free);
                }
            }
        }
        row
    }

    /// Twice the nats that a touch with this row would bring.
    pub fn gain(&self, row: &DVector<f64>) -> f64 {
        (1.0 + (&self.covariance * row).dot(row) / self.deviation.powi(2)).ln()
    }

    /// Takes in a touch with this row.
    pub fn update(&mut self, row: &DVector<f64>) {
        let moved = &self.covariance * row;
        let variance = self.deviation.powi(2) + moved.dot(row);
        self.covariance.ger(-1.0 / variance, &moved, &moved, 1.0);
    }
}

/// Where the surfaces under two receptors come closest in a posture, by the schema, and the chain of them;
/// the lesser limb's receptor must come first.
pub fn meeting(
    creature: &Creature,
    skin: &Skin,
    schema: &BodySchema,
    receptors: [usize; 2],
    posture: &[f64],
) -> (PairTouches, Meeting) {
    let ends = receptors.map(|receptor| TouchEnd { receptor, contact: Vector3::zeros() });
    let touch = Touch { bout: 0, motion: 0, posture: posture.to_vec(), ends };
    let set = prepare(creature, skin, |limb| limb, [&touch]);
    let pair = set.pairs.into_iter().next().expect("one touch makes one pair");
    let frames = pair.touches[0].frames(schema);
    let meeting = SurfaceGap::new(skin, 1.0).meeting(&pair.touches[0].ends, &frames);
    (pair, meeting)
}
