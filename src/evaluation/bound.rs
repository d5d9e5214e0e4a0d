//! Bounds of the error of a schema: the Cramér-Rao bound beside the error, at the end and during learning, and an estimate of the
//! error without the ground truth.

use serde::{Deserialize, Serialize};

use super::{HeldOutPoint, Summary, held_out, held_out_points};
use crate::agent::Agent;
use crate::creature::Creature;
use crate::ground_truth::GroundTruth;
use crate::learning::annealing::gaps;
use crate::learning::observability::Observability;
use crate::learning::touch_set::TouchSet;
use crate::learning::{Account, Input, Learned, Learner, SecondOrder};
use crate::schema::BodySchema;
use crate::senses::Touch;

/// The least share of the points that a bound must be over to be one of them all.
const MOST_OF_THEM: f64 = 0.95;

/// Every how many touches one is held out.
const HELD_OUT: usize = 5;

/// The held-out error beside the least that any unbiased learner could have made of the same touches.
///
/// The Cramér-Rao bound of a placed point's covariance is `J I⁻¹ Jᵀ`, with the Fisher information `I` of
/// the touches in the noise that the model assumes and the point's derivative `J` by the parameters (Kay,
/// Fundamentals of Statistical Signal Processing: Estimation Theory, 1993, section 3.8). Its trace bounds
/// the mean *square* of the error: the two are compared as root mean squares, never with the mean error.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct CramerRaoBound {
    /// Root of the mean over the points of the bound of the squared error, millimetres.
    pub bound_rms: f64,
    /// Root mean square of the errors at the same points, millimetres.
    pub error_rms: f64,
    /// The second over the first.
    pub ratio: f64,
    /// Points that both are taken over: those of limbs that are claimed to be placed against one another.
    pub points: usize,
    /// Whether the touches fit to numerical precision: they show no more noise than the least that the learner assumes,
    /// the bound is one of that, and the error may be less.
    #[serde(default)]
    pub at_floor: bool,
}

impl CramerRaoBound {
    /// Puts errors beside their bounds: `errors` are those at `points`, of which those count whose limbs the account
    /// claims. `None` if it claims none.
    pub fn new(
        creature: &Creature,
        schema: &BodySchema,
        account: &Account,
        observability: &Observability,
        points: &[HeldOutPoint],
        errors: &[f64],
    ) -> Option<CramerRaoBound> {
        let (claimed, deviations) = claimed_deviations(creature, schema, account, observability, points);
        let errors: Vec<f64> = claimed.iter().map(|&point| errors[point]).collect();
        let (bound_rms, error_rms) = (rms(&deviations)?, rms(&errors)?);
        Some(CramerRaoBound {
            bound_rms,
            error_rms,
            ratio: error_rms / bound_rms,
            points: errors.len(),
            at_floor: account.witnesses.at_floor,
        })
    }
}

/// The indices of the points whose limbs an account claims to locate relative to each other, and the standard deviation of each
/// point, millimetres. Points without a finite one, in an unobservable direction, are left out.
fn claimed_deviations(
    creature: &Creature,
    schema: &BodySchema,
    account: &Account,
    observability: &Observability,
    points: &[HeldOutPoint],
) -> (Vec<usize>, Vec<f64>) {
    let claimed =
        points.iter().enumerate().filter(|(_, point)| account.claims(point.limbs[0], point.limbs[1]));
    let deviation = |HeldOutPoint { posture, limbs, p_a }: &HeldOutPoint| {
        1e3 * observability.point_deviation(creature, schema, posture, *limbs, p_a)
    };
    let deviations = claimed.map(|(index, point)| (index, deviation(point)));
    deviations.filter(|(_, deviation)| deviation.is_finite()).unzip()
}

/// The root mean square of some numbers; `None` if there is none.
fn rms(values: &[f64]) -> Option<f64> {
    let squares: f64 = values.iter().map(|value| value * value).sum();
    (!values.is_empty()).then(|| (squares / values.len() as f64).sqrt())
}

/// Measures schemas at the same points: those that the touches determine in the end.
#[derive(Debug)]
pub struct Progress<'a> {
    agent: &'a Agent,
    truth: &'a GroundTruth,
    learned: &'a Learned,
    points: Vec<HeldOutPoint>,
}

impl<'a> Progress<'a> {
    /// For schemas during learning.
    pub fn new(agent: &'a Agent, truth: &'a GroundTruth, learned: &'a Learned) -> Progress<'a> {
        let determined = |point: &HeldOutPoint| {
            let [a, b] = point.limbs;
            learned.reliable_account().is_some_and(|account| account.claims(a, b))
        };
        let mut points = held_out_points(agent);
        // Where nothing is determined, or the learner cannot tell, all count.
        if points.iter().any(determined) {
            points.retain(determined);
        }
        Progress { agent, truth, learned, points }
    }

    /// Root mean square of a schema's held-out errors, millimetres; `None` if there is no point.
    pub fn error_rms(&self, schema: &BodySchema) -> Option<f64> {
        rms(&held_out(self.agent.creature(), self.truth, schema, &self.points))
    }

    /// The Cramér-Rao bound of the same from touches that determine so much, millimetres; `None` if they leave some of it open.
    pub fn bound_rms(&self, observability: &Observability) -> Option<f64> {
        let (creature, schema) = (self.agent.creature(), &self.learned.schema);
        let account = self.learned.account.as_ref()?;
        let (_, deviations) = claimed_deviations(creature, schema, account, observability, &self.points);
        let most = deviations.len() as f64 >= MOST_OF_THEM * self.points.len() as f64;
        rms(&deviations).filter(|rms| most && rms.is_finite())
    }
}

/// A schema's own account of how good it is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OwnAccount {
    /// Root mean square of how far off skin of one limb is expected in another's frame, millimetres, over limbs
    /// that are claimed to be placed against one another, at the postures of the held-out error. It is the least that noise of
    /// the size that the touches show leaves; what the learner does not know of, such as joints that are not rigid,
    /// is not in it. `None` if nothing is determined.
    pub expected_mm: Option<f64>,
    /// Every fifth touch under a schema fitted anew to the others: how far apart it puts the two points or, of receptors, the
    /// two surfaces, millimetres; of limbs that are claimed, or of all where none is. `None` if too few touches are left.
    pub fresh_mm: Option<Summary>,
}

impl OwnAccount {
    /// The account of what the learner `lm` came to; `None` if it can give none, as where nothing explains the touches.
    pub fn new(agent: &Agent, touches: &[Touch], learned: &Learned) -> Option<OwnAccount> {
        let (creature, input) = (agent.creature(), learned.basis.input);
        let account = learned.account.as_ref()?;
        let expected_mm = learned.reliable_account().and_then(|account| {
            let (schema, observability) = (&learned.schema, &account.observability);
            rms(&claimed_deviations(creature, schema, account, observability, &held_out_points(agent)).1)
        });

        // A body that places no skin may explain touches all the same, as far as one arm at one place tells.
        let all = learned.reliable_account().is_none_or(|account| !account.claims_any());
        let known = (0..creature.joints().len())
            .map(|joint| all || !account.undetermined().contains(&joint))
            .collect();
        let mut fitted = SecondOrder::new(agent, input, 0);
        let mut fresh = SecondOrder::new(agent, input, 0);
        for (i, touch) in touches.iter().enumerate() {
            let held_out = i % HELD_OUT == HELD_OUT - 1;
            if held_out { &mut fresh } else { &mut fitted }.touch(touch);
        }
        let schema = fitted.refine_known(&learned.schema, known).schema;
        let mut set = TouchSet::default();
        for (limbs, touch) in fresh.prepared().filter(|([a, b], _)| all || account.claims(*a, *b)) {
            set.push_prepared(creature, limbs, touch);
        }
        let misses = match input {
            Input::Receptor => gaps(agent.skin(), &set, &schema),
            Input::Contact => {
                let touches = set.touches();
                touches.map(|touch| touch.miss(&schema).norm()).collect()
            }
        };
        let fresh_mm = (!misses.is_empty()).then(|| Summary::of(misses.iter().map(|miss| 1e3 * miss)));
        Some(OwnAccount { expected_mm, fresh_mm })
    }
}
