//! Fits in noise of starts that are judged next, and the last fit: of the one that was accepted, to all touches.

use super::judging::shown_deviation;
use super::{MOST_NOISE, SecondOrder};
use crate::deadline::Deadline;
use crate::geometry::Frame;
use crate::learning::annealing::{AnnealingLimits, NARROWEST, anneal, gaps, typical_gap};
use crate::learning::growing::{Evidence, Start};
use crate::learning::least_squares::{Stopping, levenberg_marquardt};
use crate::learning::noise::{Noise, NoisyProblem};
use crate::learning::observation::PointsMeet;
use crate::learning::surface_gap::{CERTAIN_NOISE, SurfaceGap};
use crate::learning::touch_set::{TouchProblem, TouchSet};
use crate::learning::twins::without_twins;
use crate::learning::{Account, LimbFrames, Parameters, Prior};
use crate::schema::BodySchema;
use crate::senses::Input;
use crate::skin::Skin;

/// Fits in which the touches are weighed by their noise, the first with none weighed.
const WEIGHINGS: i32 = 3;
/// Gaps count as no sharper at first than the skin under receptors is known, and then by this in each fit.
const SHARPER: f64 = 0.1;
/// Fits to exact touches, each as sharp as the gaps that the one before left; and no sharper than rounding, metres.
const SHARPENINGS: usize = 3;
const ROUNDING: f64 = 1e-11;
/// The last fit: so many linearizations, each with so much progress at the least.
const LAST: Stopping = Stopping { iterations: 30, relative_cost: 1e-9, cost: 0.0, deadline: Deadline::Never };

impl SecondOrder {
    /// Fits all known joints to all touches: the schema, what it rests on, and the deviation of a touch.
    pub(super) fn polish(&self, start: &Start) -> (BodySchema, Account, f64) {
        let all = self.prepare(self.touches.iter());
        let used = all.filter(|pair| start.covers(pair));
        let parameters = self.parameters(&start.known, &start.placed);
        let mut schema = self.with_frozen(&start.schema);
        let told = match self.evidence() {
            Evidence::Surfaces(skin) => {
                let limits = AnnealingLimits::default();
                let annealed = anneal(limits, &self.agent, &used, &parameters, &self.known.prior, schema);
                schema = annealed.schema;
                if annealed.gap_deviation <= CERTAIN_NOISE {
                    let deviation = self.gap_deviation(skin, &used, &parameters, &schema);
                    let model = SurfaceGap::new(skin, deviation).with_biased_places();
                    let problem = TouchProblem::new(self.agent.creature(), &used, &parameters, model)
                        .with_prior(&self.known.prior);
                    schema = problem.fit(schema, LAST);
                    schema = self.sharpened(skin, &used, &parameters, schema);
                } else {
                    schema = self.fit_in_noise(&used, &parameters, schema, true);
                }
                used
            }
            _ => {
                let stopping = Stopping { iterations: 60, ..LAST };
                let problem =
                    TouchProblem::new(self.agent.creature(), &used, &parameters, PointsMeet::Shaped)
                        .with_prior(self.prior());
                schema = problem.fit(schema, stopping);
                if self.shows_noise(&used, &parameters, &schema) {
                    schema = self.fit_in_noise(&used, &parameters, schema, true);
                }
                schema = self.settled(schema, &start.placed);
                match self.frames {
                    LimbFrames::Joint if self.input == Input::Contact => {
                        without_twins(self.agent.creature(), &used, &schema, &self.known.frozen)
                    }
                    _ => used,
                }
            }
        };
        let (account, deviation) = self.account_of(&told, &schema);
        (schema, account, deviation)
    }

    /// A schema in which every limb that is not placed has the frame of its joint, and every joint its position
    /// where its own motion cannot feel it.
    fn settled(&self, mut schema: BodySchema, placed: &[bool]) -> BodySchema {
        for joint in 0..schema.limb_poses.len() {
            if !placed[joint + 1] {
                let pose = schema.limb_poses[joint].inverse();
                schema.reframe(self.agent.creature(), joint + 1, &pose);
                // Free of the last digit.
                schema.limb_poses[joint] = Frame::identity();
            }
        }
        schema.settle_positions(self.agent.creature());
        schema
    }

    /// What is believed beside touches: points that are felt need no guess from where the skin is.
    fn prior(&self) -> &Prior {
        match self.input {
            Input::Receptor => &self.known.prior,
            Input::Contact => &self.known.given,
        }
    }

    /// Fits touches weighed by the noise that they show; that of `receptors` is told from others where it is asked for.
    fn fit_in_noise(
        &self,
        used: &TouchSet,
        parameters: &Parameters,
        mut schema: BodySchema,
        receptors: bool,
    ) -> BodySchema {
        let mut noise: Option<Noise> = None;
        for weighing in 0..WEIGHINGS {
            let (found, adjusted) = self.noise(used, parameters, &schema, noise, receptors);
            // Where skin may be anywhere, sharp gaps leave the schema hardly any way to go.
            let narrowest = found.receptor * SHARPER.powi(weighing);
            let blunt = Noise { contact: found.contact.max(narrowest), ..found };
            let mut problem = NoisyProblem::new(self.compared(), &adjusted, parameters, self.prior(), blunt);
            let start = problem.start(schema);
            schema = levenberg_marquardt(&mut problem, start, LAST).state.schema;
            noise = Some(found);
        }
        schema
    }

    /// Fits what a start knows to touches of surfaces, weighed by the noise that they show, for an answer is judged by the best
    /// that it can be; where they show none, or more than is believed, it is left.
    pub(super) fn fit_start_in_noise(&self, touches: &TouchSet, start: &mut Start) {
        let Evidence::Surfaces(skin) = self.evidence() else { return };
        let used = touches.filter(|pair| start.covers(pair));
        if used.is_empty() {
            return;
        }
        let parameters = self.parameters(&start.known, &start.placed);
        let deviation = shown_deviation(skin, &used, &parameters, &start.schema);
        if (CERTAIN_NOISE..MOST_NOISE).contains(&deviation) {
            // To tell what receptors do from noise of single touches is dear, and not needed to judge by.
            start.schema = self.fit_in_noise(&used, &parameters, start.schema.clone(), false);
        }
    }

    /// Whether points are farther apart than they were taken to be, as far as parameters do not take that up: that much is noise.
    pub(super) fn shows_noise(&self, used: &TouchSet, parameters: &Parameters, schema: &BodySchema) -> bool {
        let misfit: f64 = used.squared_misfits(PointsMeet::Shaped, schema).sum();
        let spare = 3.0 * used.len() as f64 - parameters.len() as f64;
        self.input == Input::Contact && self.frames == LimbFrames::Joint && misfit > spare.max(1.0)
    }

    /// The fit to touches that show no noise, as far as they go: where surfaces are round and bodies move in a plane, gaps hardly
    /// feel what is across it.
    fn sharpened(
        &self,
        skin: &Skin,
        touches: &TouchSet,
        parameters: &Parameters,
        mut schema: BodySchema,
    ) -> BodySchema {
        // What is well known is at its place in a step or two, what is not in many, and each closes gaps fourfold.
        let stopping = Stopping { relative_cost: 1e-2, ..LAST };
        let mut left = typical_gap(&gaps(skin, touches, &schema));
        for _ in 0..SHARPENINGS {
            if left >= NARROWEST || left <= ROUNDING {
                break;
            }
            // A place in a patch says nothing that gaps so narrow do not.
            let model = SurfaceGap::new(skin, left).without_places();
            let problem = TouchProblem::new(self.agent.creature(), touches, parameters, model)
                .with_prior(&self.known.prior);
            let sharper = problem.fit(schema.clone(), stopping);
            let now = typical_gap(&gaps(skin, touches, &sharper));
            if now >= left {
                break;
            }
            (schema, left) = (sharper, now);
        }
        schema
    }

    /// A schema with the frozen joints exactly as they are known: starts scale every axis to unit length, which
    /// may change its last digit.
    pub(super) fn with_frozen(&self, schema: &BodySchema) -> BodySchema {
        let mut schema = schema.clone();
        for (j, joint) in
            self.agent.creature().joints().iter().enumerate().filter(|(j, _)| self.known.frozen[*j])
        {
            schema.positions[j] = self.known.prior.mean.positions[j];
            for k in joint.dof_indices() {
                schema.axes[k] = self.known.prior.mean.axes[k];
            }
        }
        schema
    }
}
