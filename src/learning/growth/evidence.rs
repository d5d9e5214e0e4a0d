//! What a touch says of a schema: that two surfaces meet or, of contact points, that two points are one.

use nalgebra::{DMatrix, Vector3};

use super::{GrownTouch, Growth};
use crate::learning::annealing::{AnnealingLimits, NARROWEST, anneal};
use crate::learning::least_squares::{LeastSquares, Stopping, levenberg_marquardt};
use crate::learning::observation::PointsMeet;
use crate::learning::online::fit_again;
use crate::learning::prediction::{GapRow, add_row};
use crate::learning::scrutiny::CLOSED;
use crate::learning::surface_gap::{SHARPEST, SurfaceGap};
use crate::learning::touch_set::{TouchProblem, TouchSet};
use crate::learning::{Parameters, Prior};
use crate::schema::BodySchema;
use crate::senses::Input;

/// Steps of a fit to points that is to be exact.
const POINT_STEPS: usize = 60;

/// One equation of a touch: what is to be nothing, metres, and its derivative as pairs of a parameter's place and the
/// derivative by it.
pub(super) struct Equation {
    pub gap: f64,
    pub entries: Vec<(usize, f64)>,
}

impl Growth {
    pub(super) fn by_points(&self) -> bool {
        self.input == Input::Contact
    }

    /// How far apart a schema leaves what touched, metres.
    pub(super) fn miss(&self, touch: &GrownTouch, schema: &BodySchema) -> f64 {
        self.scrutiny().miss(&touch.told, schema)
    }

    /// Whether a schema has what touched meet, of surfaces within the patches that felt it.
    pub(super) fn closes(&self, touch: &GrownTouch, schema: &BodySchema) -> bool {
        self.scrutiny().felt_gap(CLOSED, &touch.told, schema) < CLOSED
    }

    /// The equations of a touch at a schema: one of surfaces, three of points.
    pub(super) fn equations(
        &self,
        touch: &GrownTouch,
        parameters: &Parameters,
        schema: &BodySchema,
    ) -> Vec<Equation> {
        let mut row = GapRow::default();
        if !self.by_points() {
            row.set(self.agent.skin(), parameters, schema, &touch.told.prepared);
            return vec![Equation { gap: row.gap, entries: row.entries }];
        }
        let along = (0..3).map(|axis| Vector3::ith(axis, 1.0));
        let equation = |along: Vector3<f64>| {
            row.set_miss(parameters, schema, &touch.told.prepared, &along);
            Equation { gap: row.gap, entries: row.entries.clone() }
        };
        along.map(equation).collect()
    }

    /// The answer that is nearest to a schema; surfaces are closed from deviations no wider than `widest` to none narrower than
    /// `narrowest`, metres.
    pub(super) fn closest(
        &self,
        [widest, narrowest]: [f64; 2],
        touches: &TouchSet,
        parameters: &Parameters,
        prior: &Prior,
        schema: BodySchema,
    ) -> BodySchema {
        if !self.by_points() {
            let limits = AnnealingLimits { widest, narrowest, deadline: self.deadline, exact: true };
            return anneal(limits, &self.agent, touches, parameters, prior, schema).schema;
        }
        let stopping =
            Stopping { iterations: POINT_STEPS, relative_cost: 1e-6, cost: 0.0, deadline: self.deadline };
        let mut problem = TouchProblem::new(self.agent.creature(), touches, parameters, PointsMeet::Anyhow)
            .with_prior(prior);
        levenberg_marquardt(&mut problem, schema, stopping).state
    }

    /// Fits parameters to touches from a schema that is nearly right: the schema, and the deviation of what is left of the
    /// gaps, metres.
    pub(super) fn fitted_to(
        &self,
        touches: &TouchSet,
        parameters: &Parameters,
        schema: BodySchema,
    ) -> (BodySchema, f64) {
        if !self.by_points() {
            return fit_again(&self.agent, touches, parameters, &self.known.prior, schema, NARROWEST);
        }
        let stopping = Stopping { iterations: POINT_STEPS, relative_cost: 1e-6, ..Stopping::default() };
        let mut problem = TouchProblem::new(self.agent.creature(), touches, parameters, PointsMeet::Anyhow)
            .with_prior(&self.known.prior);
        // Points have no noise where bodies grow.
        (levenberg_marquardt(&mut problem, schema, stopping).state, 0.0)
    }

    /// What the touches in use tell of parameters at a schema, for a deviation of the gap, metres.
    pub(super) fn information_at(
        &self,
        parameters: &Parameters,
        schema: &BodySchema,
        deviation: f64,
    ) -> DMatrix<f64> {
        if self.by_points() {
            let mut information = DMatrix::zeros(parameters.len(), parameters.len());
            for touch in self.touches.iter().filter(|touch| touch.used) {
                let equations = self.equations(touch, parameters, schema);
                equations.iter().for_each(|row| add_row(&mut information, &row.entries, deviation.powi(-2)));
            }
            return information;
        }
        // A place in a patch is no evidence.
        let model = SurfaceGap::new(self.agent.skin(), deviation.max(SHARPEST)).without_places();
        let set = self.set(self.touches.iter().filter(|touch| touch.used));
        let creature = self.agent.creature();
        let mut information = TouchProblem::new(creature, &set, parameters, model).linearize(schema).hessian;
        information.fill_upper_triangle_with_lower_triangle();
        information
    }
}
