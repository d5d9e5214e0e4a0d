//! A rough schema from few touches, good enough to aim by.
//!
//! An agent that chooses its motions needs a schema long before its touches prove one. This learner takes
//! the best explanation it finds, right or not: from what it believed before, from the same with suspect
//! joints drawn anew, and from random initial guesses. It judges itself by what its last schema predicted of the
//! touches since, and once that was right it only keeps fitting it.

use nalgebra::Vector3;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use crate::agent::Agent;
use crate::deadline::{Deadline, in_parallel};
use crate::learning::annealing::{AnnealingLimits, NARROWEST, anneal_to, quantile};
use crate::learning::initial_guess::{random_guess, randomize_joint};
use crate::learning::least_squares::{LeastSquares, Stopping, levenberg_marquardt};
use crate::learning::observation::{Observation, ObservationModel, PointsMeet};
use crate::learning::relaxed_gradient::{MissWeights, descend};
use crate::learning::surface_gap::SurfaceGap;
use crate::learning::touch_set::{LimbTouch, PreparedTouch, TouchProblem, TouchSet};
use crate::learning::{AxisModel, Basis, Learned, Learner, Parameters, Prior, PriorKnowledge, Verdict};
use crate::schema::BodySchema;
use crate::senses::Touch;
use crate::skin::Skin;

/// How far a curved limb is taken to bulge out of a flat patch, metres.
const NORMAL_DEVIATION: f64 = 6e-3;
/// Steps down the relaxed gradient from a random initial guess.
const DESCENT: usize = 40_000;
/// The deviation of the gap down to which axes stay relaxed, metres.
const RELAXED_GAP: f64 = 3e-3;
/// The deviation of the gap at which explanations are compared, metres.
const COMPARED: f64 = 3e-3;
/// Random initial guesses at each learning while the answer is not found, and starts from suspect joints drawn anew.
const GUESSES: usize = 3;
const SUSPECTED: usize = 2;
/// Touches that must be predicted before the answer counts as found …
const PREDICTED: usize = 6;
/// … and the gap that eight tenths of them stay below, metres.
const PREDICTED_GAP: f64 = 2e-3;

/// The learner of rough schemas: receptor input and known surfaces.
pub struct RoughFit {
    agent: Agent,
    prior: Prior,
    rng: ChaCha8Rng,
    touches: Vec<Touch>,
    /// The last schema and the number of touches it is fitted to.
    last: Option<(BodySchema, usize)>,
}

/// How one start begins.
enum RoughStart {
    /// From a schema that is nearly right: unit axes, by the surfaces.
    Continued(BodySchema),
    /// From a schema, axes relaxed, by the receptors' centres first.
    Loosened(BodySchema),
    /// From random axes, down the relaxed gradient first, with touches in an order drawn from a seed.
    Random(BodySchema, u64),
}

impl RoughFit {
    /// A learner whose initial guesses are drawn from `seed`.
    pub fn new(agent: &Agent, seed: u64) -> RoughFit {
        RoughFit {
            agent: agent.clone(),
            prior: PriorKnowledge::nothing(agent).prior,
            rng: ChaCha8Rng::seed_from_u64(seed),
            touches: Vec::new(),
            last: None,
        }
    }

    fn solve(
        &self,
        touches: &TouchSet,
        axis_model: AxisModel,
        model: impl ObservationModel,
        start: BodySchema,
        iterations: usize,
    ) -> BodySchema {
        let parameters = Parameters::new(self.agent.creature(), axis_model, |_| true);
        let mut problem =
            TouchProblem::new(self.agent.creature(), touches, &parameters, model).with_prior(&self.prior);
        let stopping = Stopping { iterations, relative_cost: 1e-3, cost: 0.0, deadline: Deadline::NEVER };
        levenberg_marquardt(&mut problem, start, stopping).state
    }

    /// By the surfaces; relaxed axes are put back on the sphere.
    fn close(&self, touches: &TouchSet, axis_model: AxisModel, start: BodySchema) -> BodySchema {
        let parameters = Parameters::new(self.agent.creature(), axis_model, |_| true);
        let narrowest = if axis_model == AxisModel::Relaxed { RELAXED_GAP } else { NARROWEST };
        let limits = AnnealingLimits { narrowest, ..AnnealingLimits::default() };
        let annealed = anneal_to(limits, &self.agent, touches, &parameters, &self.prior, start);
        let mut schema = annealed.schema;
        schema.normalize_axes(self.agent.creature());
        schema
    }

    /// One start: the misfit of the schema it reaches, and the schema.
    fn start(&self, touches: &TouchSet, initial_guess: RoughStart) -> (f64, BodySchema) {
        let (schema, known) = match initial_guess {
            RoughStart::Continued(schema) => (schema, true),
            RoughStart::Loosened(schema) => (schema, false),
            RoughStart::Random(schema, seed) => {
                let mut rng = ChaCha8Rng::seed_from_u64(seed);
                let parameters = Parameters::new(self.agent.creature(), AxisModel::Relaxed, |_| true);
                let listed: Vec<&PreparedTouch> = touches.touches().collect();
                (descend(&listed, schema, DESCENT, &parameters, MissWeights::Nothing, &mut rng), false)
            }
        };
        let mut schema = schema;
        if !known {
            schema = self.solve(touches, AxisModel::Relaxed, PointsMeet::Anyhow, schema, 60);
            schema.normalize_axes(self.agent.creature());
            schema = self.solve(touches, AxisModel::Unit, PointsMeet::Anyhow, schema, 30);
            schema = self.close(touches, AxisModel::Relaxed, schema);
        }
        schema = self.close(touches, AxisModel::Unit, schema);
        (self.misfit(touches, &schema), schema)
    }

    /// What explanations are compared by: the robust cost of gaps and patches, and the prior's.
    fn misfit(&self, touches: &TouchSet, schema: &BodySchema) -> f64 {
        let parameters = Parameters::new(self.agent.creature(), AxisModel::Unit, |_| true);
        let model = SurfaceGap::new(self.agent.skin(), COMPARED);
        TouchProblem::new(self.agent.creature(), touches, &parameters, model)
            .with_prior(&self.prior)
            .cost(schema)
    }

    /// Per joint, how much the touches with it in their chain miss, metres.
    fn blame(&self, touches: &TouchSet, schema: &BodySchema) -> Vec<f64> {
        let joints = self.agent.creature().joints().len();
        let (mut sum, mut count) = (vec![0.0; joints], vec![1e-9; joints]);
        let model = SurfaceGap::new(self.agent.skin(), 1.0);
        for pair in &touches.pairs {
            for touch in &pair.touches {
                let gap = model.gap(&touch.ends, &touch.frames(schema)).distance.abs();
                // The surfaces tell most; where they all meet the centres tell a little.
                let miss = gap.min(0.05) + 0.1 * touch.miss(schema).norm().min(0.2);
                for joint in pair.chain.joints() {
                    sum[joint] += miss;
                    count[joint] += 1.0;
                }
            }
        }
        sum.iter().zip(&count).map(|(sum, count)| sum / count).collect()
    }

    /// A schema with `many` joints drawn anew by their blame; their positions are kept.
    fn redrawn(&mut self, schema: &BodySchema, blame: &[f64], many: usize) -> BodySchema {
        let mut redrawn = schema.clone();
        for _ in 0..many {
            let mut left = self.rng.random::<f64>() * blame.iter().sum::<f64>();
            let drawn = blame.iter().position(|share| {
                left -= share;
                left <= 0.0
            });
            let joint = drawn.unwrap_or(0);
            randomize_joint(self.agent.creature(), &mut redrawn, joint, &mut self.rng);
            redrawn.positions[joint] = schema.positions[joint];
        }
        redrawn
    }

    /// The gaps, sorted, at which the last schema puts the touches since, metres; none without any.
    fn predicted(&self) -> Option<Vec<f64>> {
        let (schema, fitted) = self.last.as_ref()?;
        let fresh = prepare(&self.agent, &self.touches[*fitted..]);
        let found = crate::learning::annealing::gaps(self.agent.skin(), &fresh, schema);
        (!found.is_empty()).then_some(found)
    }
}

impl Learner for RoughFit {
    fn touch(&mut self, touch: &Touch) {
        self.touches.push(touch.clone());
    }

    fn learn(&mut self) -> Learned {
        let touches = prepare(&self.agent, &self.touches);
        // The only honest measure of a schema is what it predicts.
        let predicted = self.predicted();
        let wide = predicted.as_ref().map_or(f64::INFINITY, |gaps| quantile(gaps, 0.8));
        let found = wide < PREDICTED_GAP && predicted.as_ref().is_some_and(|gaps| gaps.len() >= PREDICTED);
        let mut initial_guesses = Vec::new();
        if let Some((schema, _)) = self.last.clone() {
            initial_guesses.push(RoughStart::Continued(schema.clone()));
            if !found {
                initial_guesses.push(RoughStart::Loosened(schema.clone()));
                let blame = self.blame(&touches, &schema);
                for many in 1..=SUSPECTED {
                    initial_guesses.push(RoughStart::Loosened(self.redrawn(&schema, &blame, many)));
                }
            }
        }
        if !found {
            for _ in 0..GUESSES {
                let initial_guess = random_guess(self.agent.creature(), &mut self.rng);
                initial_guesses.push(RoughStart::Random(initial_guess, self.rng.random()));
            }
        }
        let count = initial_guesses.len();
        let starts = in_parallel(initial_guesses, |initial_guess| self.start(&touches, initial_guess));
        let (_, schema) =
            starts.into_iter().min_by(|a, b| a.0.total_cmp(&b.0)).expect("at least one start is made");
        self.last = Some((schema.clone(), self.touches.len()));
        let why = "a rough schema: it does not predict the touches yet";
        Learned {
            schema,
            basis: Basis::SURFACES,
            verdict: if found { Verdict::Converged } else { Verdict::Failed(why.to_string()) },
            initial_guesses: count,
            fresh_rms: wide / PREDICTED_GAP,
            account: None,
            deviation: predicted.map(|gaps| quantile(&gaps, 0.5)),
            changes: Vec::new(),
        }
    }
}

/// Touches made ready for a solver: receptors' centres with the shape of their patches.
pub fn prepare<'t>(agent: &Agent, touches: impl IntoIterator<Item = &'t Touch>) -> TouchSet {
    let prepared = touches.into_iter().map(|touch| {
        let receptors = touch.ends.map(|end| end.receptor);
        imagined(agent.skin(), receptors, &touch.posture)
    });
    TouchSet::new(agent.creature(), prepared)
}

/// A touch of two receptors in a posture, made or only imagined.
pub fn imagined<'p>(skin: &Skin, receptors: [usize; 2], posture: &'p [f64]) -> LimbTouch<'p> {
    let ends = receptors.map(|receptor| {
        let felt = &skin.receptors[receptor];
        let position: Vector3<f64> = felt.position;
        Observation { receptor, position, covariance: felt.covariance(NORMAL_DEVIATION) }
    });
    LimbTouch { limbs: receptors.map(|receptor| skin.receptors[receptor].limb), posture, ends }
}
