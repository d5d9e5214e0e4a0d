//! Whether a creature tells its own touch from another's.

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use serde_json::json;

use super::plot::{AxisScale, PlotAxis, PlotSeries, StudyPlot};
use super::subject::Subject;
use super::table::row;
use super::{Findings, Study};
use crate::creature::Posture;
use crate::experiment::ExperimentError;
use crate::learning::rough::imagined;
use crate::learning::surface_gap::SurfaceGap;
use crate::learning::touch_set::TouchSet;
use crate::senses::{Party, Touch, TouchEvent, TouchKind};
use crate::simulation::partner::Strokes;
use crate::simulation::{Stage, StepSenses};

/// The study `self-touch`.
pub const STUDY: Study = Study {
    name: "self-touch",
    about: "whether self-touch and being touched are ever confused; a trial is one contact",
    touches: false,
    several: false,
    measure: |subject| Ok(measure(subject)?.into()),
};

/// How deep limbs that touch are pressed into each other, metres: a babbled touch only just meets.
const PRESSED: f64 = 1e-3;
/// Step of a coordinate over which the gap's gradient is taken, radians or metres.
const NUDGE: f64 = 1e-5;
/// How long a self-touch is held, seconds.
const HELD: f64 = 0.15;
/// How long the creature is watched afterwards, seconds: long enough for every sensation to end.
const AFTER: f64 = 0.1;

row! {
    /// A measurement of the study `self-touch`.
    pub struct SelfTouchMeasurement {
        done: String = "done",
        seed: u64 = "seed",
        self_events: usize = "self-touches told",
        other_events: usize = "others told",
        peak_force_n: f64 = "felt, N",
        right: bool = "right",
    }
}

row! {
    /// A row of the summary of the study `self-touch`.
    pub struct SelfTouchSummary {
        done: String = "done",
        trials: usize = "trials",
        told_self: usize = "self told",
        told_other: usize = "other told",
        told_both: usize = "both told",
        nothing: usize = "nothing",
        right: f64 = "right, share",
    }
}

/// What a trial is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum TouchScenario {
    /// The creature touches itself.
    Itself,
    /// A probe taps it.
    Other,
    /// A probe taps it while it touches itself.
    Both,
}

impl TouchScenario {
    const ALL: [TouchScenario; 3] = [TouchScenario::Itself, TouchScenario::Other, TouchScenario::Both];

    fn name(self) -> &'static str {
        match self {
            TouchScenario::Itself => "self",
            TouchScenario::Other => "other",
            TouchScenario::Both => "both",
        }
    }

    /// Whether the creature touches itself, and whether a probe does.
    fn parties(self) -> [bool; 2] {
        [self != TouchScenario::Other, self != TouchScenario::Itself]
    }
}

/// What was told in a trial: by self-touch and by another's, how many sensations, and whether any beginning or
/// sensation told of that party.
#[derive(Default)]
struct ToldTouches {
    sensed: [usize; 2],
    named: [bool; 2],
    peak_force: f64,
}

impl ToldTouches {
    fn take(&mut self, event: &TouchEvent) {
        let party = |by: Party| usize::from(by != Party::Own);
        match event {
            TouchEvent::Began { contact, .. } => self.named[party(contact.by.party())] = true,
            TouchEvent::Sensed { sensation, .. } => {
                self.named[party(sensation.by)] = true;
                self.sensed[party(sensation.by)] += 1;
                self.peak_force = self.peak_force.max(sensation.peak_force);
            }
        }
    }

    fn sensed(&self) -> [bool; 2] {
        self.sensed.map(|count| count > 0)
    }
}

/// Measures; a trial that does not succeed is a finding.
///
/// # Errors
/// Where something cannot be measured at all.
pub fn measure(
    subject: &Subject,
) -> Result<Findings<SelfTouchMeasurement, SelfTouchSummary>, ExperimentError> {
    let stage = subject.stage()?;
    let reference = qpos(subject, &subject.body().creature.reference_posture());
    let trials: Vec<(u64, ChaCha8Rng, TouchScenario)> = subject
        .seeds
        .iter()
        .map(|&seed| {
            let mut rng = ChaCha8Rng::seed_from_u64(seed);
            let done = TouchScenario::ALL[rng.random_range(0..TouchScenario::ALL.len())];
            (seed, rng, done)
        })
        .collect();
    let needed = trials.iter().filter(|(_, _, done)| done.parties()[0]).count();
    // One babbling for all trials: a touch each, and no more than that.
    let touches = match needed {
        0 => Vec::new(),
        _ => subject.babble_body(subject.body(), subject.agent(), needed, subject.seeds[0])?,
    };
    let mut touches = touches.iter();
    let mut measurements: Vec<SelfTouchMeasurement> = Vec::new();
    let mut counts = [[0usize; 4]; 3];
    let (mut right, mut right_of, mut named_wrongly, mut missed) = (0usize, [0usize; 3], 0usize, 0usize);
    // By what was done and what was told of it: itself, another, nothing.
    let mut confusion = [[0usize; 3]; 2];
    let mut forces: [Vec<f64>; 3] = Default::default();
    for (seed, mut rng, done) in trials {
        subject.tell(seed, "touching");
        let touch = if done.parties()[0] { touches.next() } else { None };
        let posture = match touch {
            Some(touch) => qpos(subject, &pressed(subject, touch)),
            None => reference.clone(),
        };
        let told = trial(&stage, done, &posture, &reference, &mut rng)?;
        let (there, sensed) = (done.parties(), told.sensed());
        let wrongly = [0, 1].iter().any(|&party| told.named[party] && !there[party]);
        named_wrongly += usize::from(wrongly);
        missed += [0, 1].iter().filter(|&&party| there[party] && !sensed[party]).count();
        for party in [0, 1].into_iter().filter(|&party| there[party]) {
            let other = 1 - party;
            let as_what = match sensed {
                _ if sensed[party] => party,
                _ if sensed[other] && !there[other] => other,
                _ => 2,
            };
            confusion[party][as_what] += 1;
        }
        let is_right = sensed == there && !wrongly;
        right += usize::from(is_right);
        let k = TouchScenario::ALL.iter().position(|&other| other == done).expect("all are listed");
        right_of[k] += usize::from(is_right);
        let column = match sensed {
            [true, false] => 0,
            [false, true] => 1,
            [true, true] => 2,
            [false, false] => 3,
        };
        counts[k][column] += 1;
        forces[k].push(told.peak_force);
        measurements.push(SelfTouchMeasurement {
            done: done.name().into(),
            seed,
            self_events: told.sensed[0],
            other_events: told.sensed[1],
            peak_force_n: told.peak_force,
            right: is_right,
        });
    }
    let mut summary: Vec<SelfTouchSummary> = Vec::new();
    for (k, done) in TouchScenario::ALL.iter().enumerate() {
        let all: usize = counts[k].iter().sum();
        let [itself, other, both, nothing] = counts[k];
        let share = right_of[k] as f64 / all as f64;
        summary.push(SelfTouchSummary {
            done: done.name().into(),
            trials: all,
            told_self: itself,
            told_other: other,
            told_both: both,
            nothing,
            right: share,
        });
    }
    let all = subject.seeds.len();
    let notes = vec![
        "A row is what was done, a column what the touch sensor told of.".to_string(),
        format!(
            "{right} of {all} trials right; in {named_wrongly} one was told of that was not there; {missed} contacts \
             were missed."
        ),
    ];
    let row = |counts: [usize; 3]| json!({"self": counts[0], "other": counts[1], "nothing": counts[2]});
    let numbers = vec![
        ("accuracy", json!(right as f64 / all.max(1) as f64)),
        ("confusion", json!({"self": row(confusion[0]), "other": row(confusion[1])})),
        ("named_wrongly", json!(named_wrongly)),
        ("missed", json!(missed)),
        ("trials", json!(all)),
    ];
    let series = TouchScenario::ALL.iter().enumerate().map(|(k, done)| PlotSeries {
        name: done.name().to_string(),
        line: Vec::new(),
        dots: forces[k].iter().filter(|&&force| force > 0.0).map(|&force| (force, k as f64)).collect(),
    });
    let names = TouchScenario::ALL.iter().map(|done| done.name().into()).collect();
    let plot = StudyPlot {
        x: PlotAxis { title: "greatest force felt, N", scale: AxisScale::Logarithmic },
        y: PlotAxis { title: "", scale: AxisScale::Names(names) },
        series: series.collect(),
    };
    Ok(Findings { measurements, summary, notes, plot, numbers })
}

/// Does what a trial is, in a posture, and goes back to the reference posture; what was told.
fn trial(
    stage: &Stage,
    done: TouchScenario,
    posture: &[f64],
    reference: &[f64],
    rng: &mut ChaCha8Rng,
) -> Result<ToldTouches, ExperimentError> {
    let mut told = ToldTouches::default();
    stage.place(&stage.posture_of(posture))?;
    // The way of a probe is laid over the skin where a step has put it.
    let StepSenses { time: began, touches, .. } = stage.step()?;
    touches.iter().for_each(|event| told.take(event));
    let mut end = began + HELD;
    if done != TouchScenario::Itself {
        let tap = Strokes::new(stage).random(TouchKind::Tap, stage.time(), rng);
        let tap =
            tap.ok_or_else(|| ExperimentError::refused("no limb of this creature has room for a tap"))?;
        end = tap.path.end();
        stage.send_probe(0, tap.path)?;
    }
    watch(stage, end, &mut told)?;
    // The creature moves now, and must not run into the probe.
    let now = stage.time();
    stage.withdraw_probe(0)?;
    stage.place(&stage.posture_of(reference))?;
    watch(stage, now + AFTER, &mut told)?;
    Ok(told)
}

/// Simulates to a time, seconds.
fn watch(stage: &Stage, end: f64, told: &mut ToldTouches) -> Result<(), ExperimentError> {
    loop {
        let StepSenses { time, touches, .. } = stage.step()?;
        touches.iter().for_each(|event| told.take(event));
        if time > end {
            return Ok(());
        }
    }
}

/// The engine's coordinates of a posture of the studied joints.
fn qpos(subject: &Subject, posture: &[f64]) -> Vec<f64> {
    let mut qpos = vec![0.0; subject.body().model.nq()];
    subject.body().write_qpos(posture, &mut qpos);
    qpos
}

/// A touch's posture moved the shortest way to where the two limbs press on each other.
fn pressed(subject: &Subject, touch: &Touch) -> Posture {
    let receptors = touch.ends.map(|end| end.receptor);
    let gap = |posture: &[f64]| {
        let set =
            TouchSet::new(&subject.body().creature, [imagined(subject.agent().skin(), receptors, posture)]);
        let touch = set.touches().next().expect("it is a set of one");
        SurfaceGap::new(subject.agent().skin(), 1.0)
            .gap(&touch.ends, &touch.frames(&subject.truth().schema))
            .distance
    };
    let mut posture = touch.posture.clone();
    let slope = |k: usize| {
        let nudged = |by: f64| {
            let mut nudged = posture.clone();
            nudged[k] += by;
            gap(&nudged)
        };
        (nudged(NUDGE) - nudged(-NUDGE)) / (2.0 * NUDGE)
    };
    let gradient: Vec<f64> = (0..posture.len()).map(slope).collect();
    let steepness: f64 = gradient.iter().map(|slope| slope * slope).sum();
    if steepness > 0.0 {
        posture.iter_mut().zip(&gradient).for_each(|(x, slope)| *x -= PRESSED * slope / steepness);
    }
    posture
}
