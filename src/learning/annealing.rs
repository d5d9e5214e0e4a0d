//! From the receptors' centres to the surfaces: annealing the deviation of the gap.
//!
//! The gap's equation is sharp, hence blind from afar: at a schema that is wrong by centimetres the nearest
//! points of two limbs are not those that touched. So its deviation starts at what the gaps are now, and
//! falls with them; every step is accepted on the robust cost. It stops falling at the noise that the gaps
//! themselves show, so that noisy joints or false touches do not turn the fit into a vote of a few.

use crate::agent::Agent;
use crate::creature::Creature;
use crate::deadline::Deadline;
use crate::learning::Parameters;
use crate::learning::least_squares::{FIRST_DAMPING, Stopping, damped_from};
use crate::learning::observation::PointsMeet;
use crate::learning::prior::Prior;
use crate::learning::surface_gap::SurfaceGap;
use crate::learning::touch_set::{TouchProblem, TouchSet};
use crate::schema::BodySchema;
use crate::skin::Skin;

/// The widest deviation, metres: a few centimetres is what receptor centres leave.
pub const WIDEST: f64 = 0.02;
/// The narrowest deviation, metres: how deep limbs press into each other where a motion stops.
pub const NARROWEST: f64 = 1e-6;
/// Standard deviation of a normal distribution whose absolute values have the median 1.
pub const NORMAL_MEDIAN: f64 = 1.4826;
/// The share of gaps that the deviation covers while it falls: it waits for stragglers, not for false touches.
const WIDE: f64 = 0.95;
/// Eight tenths of a normal distribution's absolute values are below this many deviations.
const NORMAL_P80: f64 = 1.2816;
/// How much the deviation falls from step to step at the least.
const COOLING: f64 = 0.7;
/// Steps in a row that do not close the gaps further, after which what is left is noise.
const VAIN: usize = 5;
/// Linearizations at each deviation.
const ITERATIONS: usize = 3;
/// Linearizations at the last deviation.
const LAST_ITERATIONS: usize = 30;

/// Without noise the gaps of a right answer close four times as far with every step once the deviation is below this, metres; …
const NEARLY_CLOSED: f64 = 3e-4;
/// … of what leaves gaps of this share of the deviation then, nothing will come.
const SLOWLY: f64 = 0.5;

/// Fits to points with relaxed axes, and half as many on the sphere; …
pub const POINT_FITS: usize = 10;
/// … steps of each, …
const POINT_STEPS: usize = 6;
/// … and how wide it is, in units of what half of all touches leave apart, and in deviations at the least.
const WIDTH: f64 = 2.0;
const LEAST_WIDTH: f64 = 3.0;
/// … which end where one brings half of them no nearer than this, in units of how near the one before did.
const NO_NEARER: f64 = 0.99;
/// Half of all touches leave receptors fewer deviations apart where an answer is near: right ones of a whole body 1.5 at the most,
/// most wrong ones 2.2 and more.
pub const HOPELESS: f64 = 2.0;

/// How wide annealing begins, and when it ends.
#[derive(Clone, Copy, Debug)]
pub struct AnnealingLimits {
    /// The greatest deviation of the gap, metres: narrow ones find answers among false touches, wide ones from farther away.
    pub widest: f64,
    /// The least deviation of the gap, metres.
    pub narrowest: f64,
    /// The moment at which it ends wherever it is.
    pub deadline: Deadline,
    /// Whether touches have no noise: then what closes slowly is given up.
    pub exact: bool,
}

impl Default for AnnealingLimits {
    fn default() -> AnnealingLimits {
        AnnealingLimits { widest: WIDEST, narrowest: NARROWEST, deadline: Deadline::Never, exact: false }
    }
}

/// What annealing came to.
#[derive(Clone, Debug)]
pub struct Annealed {
    /// The schema.
    pub schema: BodySchema,
    /// The deviation of the gap at the end, metres: the noise of the touches, or [`NARROWEST`].
    pub gap_deviation: f64,
    /// Eight tenths of the gaps are smaller, metres.
    pub p80_gap: f64,
}

/// The absolute gaps of all touches under a schema, sorted, metres.
pub fn gaps(skin: &Skin, touches: &TouchSet, schema: &BodySchema) -> Vec<f64> {
    sorted(touches.touches().map(|touch| touch.gap(skin, schema).distance.abs()))
}

/// Numbers in rising order.
pub fn sorted(values: impl IntoIterator<Item = f64>) -> Vec<f64> {
    let mut values: Vec<f64> = values.into_iter().collect();
    values.sort_by(f64::total_cmp);
    values
}

/// Standard deviation of sorted absolute gaps, by half of them or by eight tenths, whichever is greater:
/// noise of the joints weighs more on touches far from them, and half of the touches may hardly show it.
pub fn typical_gap(sorted: &[f64]) -> f64 {
    (NORMAL_MEDIAN * quantile(sorted, 0.5)).max(quantile(sorted, 0.8) / NORMAL_P80)
}

/// How many times as wide gaps would be, by their standard deviation, if a fit of parameters to them took up none of them.
pub fn shrinkage(gaps: usize, parameters: &Parameters) -> f64 {
    let spare = (gaps as f64 - 0.7 * parameters.len() as f64).max(1.0);
    (gaps as f64 / spare).sqrt()
}

/// The value below which a share of sorted values lies; 0 where there is none.
pub fn quantile(sorted: &[f64], share: f64) -> f64 {
    if sorted.is_empty() {
        return 0.0;
    }
    sorted[((sorted.len() - 1) as f64 * share).round() as usize]
}

/// How many deviations the points that touched stay apart in half of all touches.
pub fn usual_miss(touches: &TouchSet, schema: &BodySchema) -> f64 {
    quantile(&sorted(touches.squared_misfits(PointsMeet::Anyhow, schema).map(f64::sqrt)), 0.5)
}

/// Fits `parameters` to receptors' centres, or contact points, from any schema, so many times until a deadline. What is farther
/// apart than most counts little, for it may be a false touch: at first nothing is near, and all count.
pub fn meet(
    creature: &Creature,
    touches: &TouchSet,
    parameters: &Parameters,
    prior: &Prior,
    start: BodySchema,
    (fits, deadline): (usize, Deadline),
) -> BodySchema {
    let stopping = Stopping { iterations: POINT_STEPS, relative_cost: 1e-4, cost: 0.0, deadline };
    let touches = touches.with_held(creature, parameters, &start);
    let mut schema = start;
    let mut before = f64::INFINITY;
    for _ in 0..fits {
        let miss = usual_miss(&touches, &schema);
        if miss > NO_NEARER * before {
            break;
        }
        before = miss;
        let width = LEAST_WIDTH.max(WIDTH * miss);
        let model = PointsMeet::Mostly(width);
        let problem = TouchProblem::new(creature, &touches, parameters, model).with_prior(prior);
        schema = problem.fit(schema, stopping);
    }
    schema
}

/// Fits `parameters` to the surfaces of `touches` from a schema that is right to centimetres.
pub fn anneal(
    limits: AnnealingLimits,
    agent: &Agent,
    touches: &TouchSet,
    parameters: &Parameters,
    prior: &Prior,
    start: BodySchema,
) -> Annealed {
    let AnnealingLimits { widest, narrowest, deadline, exact } = limits;
    let skin = agent.skin();
    let touches = &touches.with_held(agent.creature(), parameters, &start);
    let mut damping = FIRST_DAMPING;
    let mut fit = |schema: BodySchema, deviation: f64, stopping: Stopping| {
        // Far off, and in noise, short steps keep to the nearest answer.
        if !exact || deviation >= NEARLY_CLOSED {
            damping = FIRST_DAMPING;
        }
        let model = SurfaceGap::new(skin, deviation);
        let mut problem = TouchProblem::new(agent.creature(), touches, parameters, model).with_prior(prior);
        damped_from(&mut damping, &mut problem, schema, stopping).state
    };
    let scatter = NORMAL_MEDIAN * shrinkage(touches.len(), parameters);
    let measure = |schema: &BodySchema| {
        let found = gaps(skin, touches, schema);
        (scatter * quantile(&found, 0.5), quantile(&found, WIDE))
    };
    let annealed = |schema: BodySchema, gap_deviation: f64| {
        let p80_gap = quantile(&gaps(skin, touches, &schema), 0.8);
        Annealed { schema, gap_deviation, p80_gap }
    };
    let (mut noise, mut wide) = measure(&start);
    let (mut least, mut best) = (noise, start.clone());
    let mut schema = start;
    let mut deviation = (2.0 * wide).clamp(narrowest, widest);
    let mut vain = 0;
    loop {
        schema = fit(
            schema,
            deviation,
            Stopping { iterations: ITERATIONS, relative_cost: 1e-2, cost: 0.0, deadline },
        );
        (noise, wide) = measure(&schema);
        if noise < 0.9 * least {
            vain = 0;
        } else {
            vain += 1;
        }
        if noise < least {
            (least, best) = (noise, schema.clone());
        }
        if exact && deviation < NEARLY_CLOSED && noise > SLOWLY * deviation {
            return annealed(best, least);
        }
        // Narrower than the noise the fit becomes a vote of a few; a little way into it shows that it is noise.
        if deviation <= narrowest || vain >= VAIN || deadline.has_passed() {
            break;
        }
        deviation = (1.5 * wide).min(COOLING * deviation).max(0.25 * deviation).max(narrowest);
    }
    let mut deviation = least.clamp(narrowest, widest);
    let last = Stopping { iterations: LAST_ITERATIONS, relative_cost: 1e-6, cost: 0.0, deadline };
    schema = fit(best, deviation, last);
    let (again, _) = measure(&schema);
    if again.max(narrowest) > 1.2 * deviation {
        deviation = again.clamp(narrowest, widest);
        schema = fit(schema, deviation, last);
    }
    annealed(schema, deviation)
}
