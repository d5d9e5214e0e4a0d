//! Whether a creature tells its own touch from another's.

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use serde::{Deserialize, Serialize};
use serde_json::json;

use super::plot::{AxisScale, PlotAxis, PlotSeries, StudyPlot};
use super::subject::{Subject, share};
use super::table::row;
use super::{Findings, Study, Trial, Trials};
use crate::creature::Posture;
use crate::experiment::ExperimentError;
use crate::learning::surface_gap::SurfaceGap;
use crate::learning::touch_set::{LimbTouch, TouchSet};
use crate::senses::{Party, Touch, TouchEvent, TouchKind};
use crate::simulation::partner::Strokes;
use crate::simulation::{Stage, StepSenses};

/// The study `self-touch`.
pub const STUDY: Study = Study {
    name: "self-touch",
    about: "whether self-touch and being touched are ever confused; a trial is one contact",
    touches: false,
    several: false,
    trials: Trials::of::<SelfTouchTrial>(),
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
}

/// What came of one trial.
#[derive(Debug, Serialize, Deserialize)]
pub struct SelfTouchTrial {
    measurement: SelfTouchMeasurement,
    /// Whether one was told of that was not there.
    named_wrongly: bool,
}

impl Trial for SelfTouchTrial {
    type Setting = ();
    type Measurement = SelfTouchMeasurement;
    type Summary = SelfTouchSummary;

    fn set_up(_subject: &Subject) -> Result<(), ExperimentError> {
        Ok(())
    }

    fn run(subject: &Subject, (): &(), seed: u64) -> Result<SelfTouchTrial, ExperimentError> {
        subject.tell(seed, "touching");
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let done = TouchScenario::ALL[rng.random_range(0..TouchScenario::ALL.len())];
        let reference = qpos(subject, &subject.body().creature.reference_posture());
        let touches = match done.parties()[0] {
            true => subject.babble_body(subject.body(), subject.agent(), 1, seed)?,
            false => Vec::new(),
        };
        let posture = match touches.first() {
            Some(touch) => qpos(subject, &pressed(subject, touch)),
            None => reference.clone(),
        };
        let told = touched(&subject.stage()?, done, &posture, &reference, &mut rng)?;
        let there = done.parties();
        let named_wrongly = [0, 1].iter().any(|&party| told.named[party] && !there[party]);
        let measurement = SelfTouchMeasurement {
            done: done.name().into(),
            seed,
            self_events: told.sensed[0],
            other_events: told.sensed[1],
            peak_force_n: told.peak_force,
            right: told.sensed.map(|count| count > 0) == there && !named_wrongly,
        };
        Ok(SelfTouchTrial { measurement, named_wrongly })
    }

    fn findings(
        _subject: &Subject,
        trials: &[SelfTouchTrial],
    ) -> Findings<SelfTouchMeasurement, SelfTouchSummary> {
        findings(trials)
    }
}

impl SelfTouchMeasurement {
    /// Whether a sensation told of self-touch, and whether one of another's.
    fn sensed(&self) -> [bool; 2] {
        [self.self_events > 0, self.other_events > 0]
    }
}

fn findings(trials: &[SelfTouchTrial]) -> Findings<SelfTouchMeasurement, SelfTouchSummary> {
    let rows = || trials.iter().map(|trial| &trial.measurement);
    let of = |done: TouchScenario| rows().filter(move |row| row.done == done.name());
    let right = rows().filter(|row| row.right).count();
    let named_wrongly = trials.iter().filter(|trial| trial.named_wrongly).count();
    let mut missed = 0;
    // By what was done and what was told of it: itself, another, nothing.
    let mut confusion = [[0usize; 3]; 2];
    let mut summary: Vec<SelfTouchSummary> = Vec::new();
    for done in TouchScenario::ALL {
        let there = done.parties();
        for sensed in of(done).map(SelfTouchMeasurement::sensed) {
            for party in [0, 1].into_iter().filter(|&party| there[party]) {
                missed += usize::from(!sensed[party]);
                let other = 1 - party;
                let as_what = match sensed {
                    _ if sensed[party] => party,
                    _ if sensed[other] && !there[other] => other,
                    _ => 2,
                };
                confusion[party][as_what] += 1;
            }
        }
        let told = |sensed: [bool; 2]| of(done).filter(|row| row.sensed() == sensed).count();
        summary.push(SelfTouchSummary {
            done: done.name().into(),
            trials: of(done).count(),
            told_self: told([true, false]),
            told_other: told([false, true]),
            told_both: told([true, true]),
            nothing: told([false, false]),
            right: share(of(done).map(|row| row.right)),
        });
    }
    let all = trials.len();
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
    let series = TouchScenario::ALL.into_iter().enumerate().map(|(k, done)| PlotSeries {
        name: done.name().to_string(),
        line: Vec::new(),
        dots: of(done).map(|row| row.peak_force_n).filter(|&f| f > 0.0).map(|f| (f, k as f64)).collect(),
    });
    let names = TouchScenario::ALL.iter().map(|done| done.name().into()).collect();
    let plot = StudyPlot {
        x: PlotAxis { title: "greatest force felt, N", scale: AxisScale::Logarithmic },
        y: PlotAxis { title: "", scale: AxisScale::Names(names) },
        series: series.collect(),
    };
    let measurements = rows().cloned().collect();
    Findings { measurements, summary, notes, plot, numbers }
}

/// Does what a trial is, in a posture, and goes back to the reference posture; what was told.
fn touched(
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
        let touch = LimbTouch::of_receptors(subject.agent().skin(), receptors, posture);
        let set = TouchSet::new(&subject.body().creature, [touch]);
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
