//! Where Hersch's rule gets to, by what it starts from and by what it is told.
//!
//! Hersch et al. (2008) tell the rule where a hand is seen, and the paper tells it of touches instead. So the same rule,
//! from the same initial guesses (the paper's onsets) at the same postures, is given receptors' centres (the paper's input), the exact points of
//! contact, and exact points of limbs in each other's frames: of the limbs that touch, and of any.

use nalgebra::{Unit, UnitQuaternion, Vector3};
use rand::{Rng, RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use serde_json::json;

use super::plot::{AxisScale, PlotAxis, PlotSeries, StudyPlot};
use super::subject::{Subject, median};
use super::table::row;
use super::{Findings, Study, Trial, Trials};
use crate::agent::Agent;
use crate::creature::DofKind;
use crate::evaluation::{evaluate, evaluate_learned};
use crate::experiment::ExperimentError;
use crate::ground_truth::GroundTruth;
use crate::kinematics::{limb_frames, tangent_basis};
use crate::learning::initial_guess::random_guess;
use crate::learning::{Hersch, Input, Learner, STEP};
use crate::schema::BodySchema;
use crate::senses::Touch;

/// The study `hersch`.
pub const STUDY: Study = Study {
    several: false,
    name: "hersch",
    about: "where Hersch's rule gets to, by touch and by vision, from near the truth and from far",
    touches: true,
    trials: Trials::of::<HerschTrial>(),
};

/// Touches of a trial where none are asked for. The rule is slow: after as many, once each, it has found no body from
/// any initial guess, and after 20 passes from those within 45° and mostly from 60°. A trial takes half a minute.
pub const TOUCHES: usize = 20_000;
/// Passes over the touches where none are asked for.
const PASSES: usize = 20;
/// Mean held-out errors that the summary counts trials below, millimetres. By exact points of contact the rule mostly ends
/// below the first one where it finds the body; receptors' centres miss by more than that, but not by the second.
const LEVELS_MM: [f64; 2] = [20.0, 50.0];
/// How far the initial guesses' axes are turned from the true ones, degrees.
const TURNS_DEG: [f64; 5] = [30.0, 45.0, 60.0, 75.0, 90.0];
/// The seed's stream for what is seen; initial guesses are drawn from stream 0, as the learner `hersch` draws its own.
const VISION_STREAM: u64 = 2;
/// How far a plot's dots of one kind stand beside those of the next, of the distance between two initial guesses.
const BESIDE: f64 = 0.12;

/// How the rule is applied.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct HerschOptions {
    /// Passes over the touches.
    pub passes: usize,
    /// The small positive scalar ε of equations 1 and 2.
    pub step: f64,
    /// The miss of a touch at which learning ends, millimetres.
    pub stop_mm: f64,
    /// Whether there are rows, too, in which a touch is used in one direction alone.
    pub single: bool,
}

impl Default for HerschOptions {
    fn default() -> HerschOptions {
        HerschOptions { passes: PASSES, step: STEP, stop_mm: 0.0, single: false }
    }
}

row! {
    /// A measurement of the study `hersch`.
    pub struct HerschMeasurement {
        told: String = "told",
        initial_guess: String = "initial guess",
        used: String = "used",
        seed: u64 = "seed",
        touches: usize = "touches",
        before_mm: f64 = "before, mm",
        heldout_mm: f64 = "held-out, mm",
        axis_deg: f64 = "axes, °",
    }
}

row! {
    /// A row of the summary of the study `hersch`.
    pub struct HerschSummary {
        told: String = "told",
        initial_guess: String = "initial guess",
        used: String = "used",
        below_20_mm: usize = "to 20 mm",
        below_50_mm: usize = "to 50 mm",
        trials: usize = "of",
        before_mm: f64 = "before, mm",
        heldout_mm: f64 = "held-out, mm",
        heldout_least_mm: f64 = "least, mm",
        heldout_most_mm: f64 = "most, mm",
        axis_deg: f64 = "axes, °",
    }
}

/// What the rule is told of a posture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Told {
    /// The centres of the two receptors that touch.
    Centres,
    /// The point of contact in the frames of both limbs.
    Contacts,
    /// A point of one limb in its own frame and in that of another, these two being the limbs that touch.
    VisionOfTouching,
    /// The same of any two limbs.
    VisionOfAny,
}

/// What the rule starts from.
#[derive(Clone, Copy, Debug, PartialEq)]
enum InitialGuess {
    /// Every true axis turned by so many degrees about a random direction across it; positions small and random.
    Turned(f64),
    /// Axes and positions random: the paper's.
    Random,
}

/// One combination of what is compared.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Condition {
    told: Told,
    guess: InitialGuess,
    double_use: bool,
}

/// A point of one limb as another has it, at a posture.
struct Sighting<'a> {
    posture: &'a [f64],
    limbs: [usize; 2],
    points: [Vector3<f64>; 2],
}

/// What all conditions of a trial share.
struct SharedInput<'a> {
    agent: &'a Agent,
    truth: &'a GroundTruth,
    options: &'a HerschOptions,
    touches: &'a [Touch],
    sightings: [(Told, Vec<Sighting<'a>>); 2],
    seed: u64,
}

impl Told {
    const ALL: [Told; 4] = [Told::Centres, Told::Contacts, Told::VisionOfTouching, Told::VisionOfAny];

    fn name(self) -> &'static str {
        match self {
            Told::Centres => "touch, receptor centres",
            Told::Contacts => "touch, exact points",
            Told::VisionOfTouching => "vision, limbs that touch",
            Told::VisionOfAny => "vision, any limbs",
        }
    }
}

impl InitialGuess {
    fn all() -> impl Iterator<Item = InitialGuess> {
        TURNS_DEG.into_iter().map(InitialGuess::Turned).chain([InitialGuess::Random])
    }

    fn name(self) -> String {
        match self {
            InitialGuess::Turned(degrees) => format!("{degrees}°"),
            InitialGuess::Random => "random".into(),
        }
    }

    /// The schema of a trial. All of one trial have the same positions and turn the axes the same ways.
    fn schema(self, agent: &Agent, truth: &GroundTruth, seed: u64) -> BodySchema {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let mut schema = random_guess(agent.creature(), &mut rng);
        let InitialGuess::Turned(degrees) = self else { return schema };
        for element in agent.creature().elements().filter(|element| element.kind != DofKind::Ball) {
            let axis = &truth.schema.axes[element.axis()];
            let turn =
                UnitQuaternion::from_axis_angle(&direction_across(axis, &mut rng), degrees.to_radians());
            schema.axes[element.axis()] = turn * axis;
        }
        schema
    }
}

impl Condition {
    fn all(options: &HerschOptions) -> Vec<Condition> {
        let uses = if options.single { &[true, false][..] } else { &[true] };
        let mut all = Vec::new();
        for told in Told::ALL {
            for guess in InitialGuess::all() {
                all.extend(uses.iter().map(|&double_use| Condition { told, guess, double_use }));
            }
        }
        all
    }

    fn used(self) -> &'static str {
        if self.double_use { "both ways" } else { "one way" }
    }
}

impl SharedInput<'_> {
    /// What the rule comes to under one condition.
    fn measured(&self, condition: &Condition) -> HerschMeasurement {
        let SharedInput { agent, truth, options, touches, seed, .. } = *self;
        let Condition { told, guess, double_use } = *condition;
        let initial_guess = guess.schema(agent, truth, seed);
        let before_mm = evaluate(agent, truth, &initial_guess, &[]).heldout_mm.mean;
        let input = if told == Told::Contacts { Input::Contact } else { Input::Receptor };
        let mut rule = Hersch::new(agent, input, initial_guess)
            .with_step(options.step)
            .with_passes(options.passes)
            .with_double_use(double_use)
            .with_tolerance(1e-3 * options.stop_mm);
        match self.sightings.iter().find(|(kind, _)| *kind == told) {
            None => touches.iter().for_each(|touch| rule.touch(touch)),
            Some((_, seen)) => {
                seen.iter().for_each(|one| rule.observe_points(one.posture, one.limbs, one.points));
            }
        }
        let evaluation = evaluate_learned(agent, truth, &rule.learn());
        HerschMeasurement {
            told: told.name().into(),
            initial_guess: guess.name(),
            used: condition.used().into(),
            seed,
            touches: touches.len(),
            before_mm,
            heldout_mm: evaluation.heldout_mm.mean,
            axis_deg: evaluation.axis_deg.median,
        }
    }
}

/// At each touch's posture, the centre of a random receptor of one limb in its own frame and in that of another.
fn sightings<'a>(
    told: Told,
    agent: &Agent,
    truth: &GroundTruth,
    touches: &'a [Touch],
    seed: u64,
) -> Vec<Sighting<'a>> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    rng.set_stream(VISION_STREAM);
    let receptors = &agent.skin().receptors;
    let mut on_limb = vec![Vec::new(); agent.creature().limbs().len()];
    receptors.iter().for_each(|receptor| on_limb[receptor.limb].push(receptor.position));
    // Two at the least, where there are touches.
    let limbs: Vec<usize> = (0..on_limb.len()).filter(|&limb| !on_limb[limb].is_empty()).collect();
    let seen = |touch: &'a Touch| {
        let of = match told {
            Told::VisionOfAny => &limbs[..],
            _ => &touch.ends.map(|end| receptors[end.receptor].limb),
        };
        let from = rng.random_range(0..of.len());
        let to = (from + rng.random_range(1..of.len())) % of.len();
        let (a, b) = (of[from], of[to]);
        let p_a = on_limb[a][rng.random_range(0..on_limb[a].len())];
        let frames = limb_frames(agent.creature(), &truth.schema, &touch.posture);
        let p_b = frames[b].inverse_point(&frames[a].point(&p_a));
        Sighting { posture: &touch.posture, limbs: [a, b], points: [p_a, p_b] }
    };
    touches.iter().map(seen).collect()
}

/// The measurements of one trial, condition by condition.
#[derive(Debug, Serialize, Deserialize)]
pub struct HerschTrial(Vec<HerschMeasurement>);

impl Trial for HerschTrial {
    type Setting = ();
    type Measurement = HerschMeasurement;
    type Summary = HerschSummary;

    fn set_up(_subject: &Subject) -> Result<(), ExperimentError> {
        Ok(())
    }

    fn run(subject: &Subject, (): &(), seed: u64) -> Result<HerschTrial, ExperimentError> {
        let touches = subject.babble(seed)?;
        let (agent, truth, options) = (subject.agent(), subject.truth(), &subject.hersch);
        let sightings = [Told::VisionOfTouching, Told::VisionOfAny]
            .map(|told| (told, sightings(told, agent, truth, &touches, seed)));
        let shared = SharedInput { agent, truth, options, touches: &touches, sightings, seed };
        subject.tell(seed, "learning");
        let conditions = Condition::all(options);
        Ok(HerschTrial(conditions.par_iter().map(|condition| shared.measured(condition)).collect()))
    }

    fn findings(subject: &Subject, trials: &[HerschTrial]) -> Findings<HerschMeasurement, HerschSummary> {
        findings(&subject.hersch, trials)
    }
}

fn findings(options: &HerschOptions, trials: &[HerschTrial]) -> Findings<HerschMeasurement, HerschSummary> {
    let conditions = Condition::all(options);
    let of = |k: usize| trials.iter().filter_map(move |trial| trial.0.get(k));
    let below = |k: usize, level: f64| of(k).filter(|one| one.heldout_mm <= level).count();
    let summary = conditions.iter().enumerate().map(|(k, condition)| HerschSummary {
        told: condition.told.name().into(),
        initial_guess: condition.guess.name(),
        used: condition.used().into(),
        below_20_mm: below(k, LEVELS_MM[0]),
        below_50_mm: below(k, LEVELS_MM[1]),
        trials: trials.len(),
        before_mm: median(of(k).map(|one| one.before_mm)),
        heldout_mm: median(of(k).map(|one| one.heldout_mm)),
        heldout_least_mm: of(k).map(|one| one.heldout_mm).fold(f64::INFINITY, f64::min),
        heldout_most_mm: of(k).map(|one| one.heldout_mm).fold(0.0, f64::max),
        axis_deg: median(of(k).map(|one| one.axis_deg)),
    });
    let summary: Vec<HerschSummary> = summary.collect();
    let series = Told::ALL.into_iter().enumerate().map(|(place, told)| {
        let mut series = PlotSeries { name: told.name().into(), line: Vec::new(), dots: Vec::new() };
        let shown = |condition: &Condition| condition.told == told && condition.double_use;
        let shown = (0..conditions.len()).filter(|&k| shown(&conditions[k]));
        for (column, k) in shown.enumerate() {
            let x = column as f64 + BESIDE * (place as f64 - 1.5);
            series.dots.extend(of(k).map(|one| (x, one.heldout_mm)));
            // A random one is no angle, so no line leads to it.
            if conditions[k].guess != InitialGuess::Random {
                series.line.push((x, summary[k].heldout_mm));
            }
        }
        series
    });
    let plot = StudyPlot {
        x: PlotAxis {
            title: "how far an initial guess's axes are from the true ones",
            scale: AxisScale::Names(InitialGuess::all().map(InitialGuess::name).collect()),
        },
        y: PlotAxis {
            title: "mean held-out error, mm (dots: trials, lines: medians)",
            scale: AxisScale::Logarithmic,
        },
        series: series.collect(),
    };
    let notes = vec![
        format!(
            "Errors are mean held-out errors after {} passes with ε = {}, medians over trials beside the least and the \
             most, and how many trials end at {} and at {} mm or less. Axes: the median angle between learned and true \
             ones.",
            options.passes, options.step, LEVELS_MM[0], LEVELS_MM[1]
        ),
        "Initial guesses have small random positions; their axes are the true ones turned by an angle about random directions \
         across them, or random."
            .to_string(),
        "Vision: at the postures of the touches, a random receptor of one limb as another limb has it, exactly, though \
         nothing touches it: of the two limbs that touch, or of any two."
            .to_string(),
    ];
    let numbers = vec![("rule", json!(options))];
    let measurements = trials.iter().flat_map(|trial| trial.0.clone()).collect();
    Findings { measurements, summary, notes, plot, numbers }
}

/// A direction drawn uniformly from those across an axis.
fn direction_across(axis: &Vector3<f64>, rng: &mut impl Rng) -> Unit<Vector3<f64>> {
    let across = tangent_basis(axis);
    let direction = std::f64::consts::TAU * rng.random::<f64>();
    Unit::new_normalize(across.column(0) * direction.cos() + across.column(1) * direction.sin())
}
