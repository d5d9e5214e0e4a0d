//! How well the touch sensor tells what is done to the skin.

use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use serde_json::{Map, Value, json};

use super::plot::{AxisScale, PlotAxis, PlotSeries, StudyPlot};
use super::subject::Subject;
use super::table::row;
use super::{Findings, Study};
use crate::experiment::ExperimentError;
use crate::senses::{Party, Sensation, TouchEvent, TouchKind};
use crate::simulation::StepSenses;
use crate::simulation::partner::Strokes;

/// The study `sensations`.
pub const STUDY: Study = Study {
    name: "sensations",
    about: "how well taps, presses, strokes and rubs are told apart; a trial is one of each kind",
    touches: false,
    several: false,
    measure: |subject| Ok(measure(subject)?.into()),
};

/// How long after the end of a stimulation a sensation is waited for, seconds.
const PATIENCE: f64 = 0.5;

row! {
    /// A measurement of the study `sensations`.
    pub struct SensationsMeasurement {
        kind: String = "done",
        seed: u64 = "seed",
        limb: String = "limb",
        force_n: f64 = "force, N",
        told: String = "told",
        told_limb: String = "told limb",
        peak_force_n: f64 = "felt, N",
        duration_s: f64 = "lasted, s",
        latency_s: f64 = "decided after, s",
        sensations: usize = "sensations",
    }
}

row! {
    /// A row of the summary of the study `sensations`.
    pub struct SensationsSummary {
        done: String = "done",
        tap: usize = "told tap",
        press: usize = "press",
        stroke: usize = "stroke",
        rub: usize = "rub",
        nothing: usize = "nothing",
        right: f64 = "right, share",
    }
}

/// Measures; a trial that does not succeed is a finding.
///
/// # Errors
/// Where something cannot be measured at all.
pub fn measure(
    subject: &Subject,
) -> Result<Findings<SensationsMeasurement, SensationsSummary>, ExperimentError> {
    let stage = subject.stage()?;
    let mut measurements: Vec<SensationsMeasurement> = Vec::new();
    let kinds = TouchKind::ALL;
    let mut confusion = [[0usize; 5]; 4];
    let (mut right_limb, mut all) = (0usize, 0usize);
    let mut of_kind: [Vec<f64>; 4] = Default::default();
    for &seed in &subject.seeds {
        for (k, &kind) in kinds.iter().enumerate() {
            let mut rng = ChaCha8Rng::seed_from_u64(seed);
            rng.set_stream(k as u64);
            let done = {
                let strokes = Strokes::new(&stage);
                strokes.random(kind, stage.time(), &mut rng)
            };
            let Some(done) = done else {
                return Err(ExperimentError::Refused(format!(
                    "no limb of this creature has room for a {}",
                    kind.name()
                )));
            };
            let (end, body) = (done.path.end(), stage.probe_thing(0));
            stage.send_probe(0, done.path.clone())?;
            let mut last_contact = stage.time();
            let mut felt: Vec<(Sensation, f64)> = Vec::new();
            loop {
                let StepSenses { time, touches, .. } = stage.step()?;
                if stage.is_touching(body) {
                    last_contact = time;
                }
                felt.extend(touches.into_iter().filter_map(|event| match event {
                    TouchEvent::Sensed { sensation, .. } if sensation.by == Party::Thing(body) => {
                        Some((sensation, time))
                    }
                    _ => None,
                }));
                if time > end + PATIENCE || (time > end && !felt.is_empty() && time > last_contact + PATIENCE)
                {
                    break;
                }
            }
            all += 1;
            // Of several, the one that lasted longest is what the sensor says.
            let longest = |a: &&(Sensation, f64), b: &&(Sensation, f64)| {
                (a.0.ended - a.0.began).total_cmp(&(b.0.ended - b.0.began))
            };
            let told = felt.iter().max_by(longest);
            let row = kinds.iter().position(|other| Some(*other) == told.map(|(s, _)| s.kind)).unwrap_or(4);
            confusion[k][row] += 1;
            let limb_told = told.map(|(sensation, _)| sensation.sides[0].limb);
            right_limb += usize::from(limb_told == Some(done.limb));
            let latency = felt.last().map(|(_, decided)| decided - last_contact);
            of_kind[k].extend(latency);
            let limb = |limb: usize| stage.agent().creature().limbs()[limb].clone();
            measurements.push(SensationsMeasurement {
                kind: kind.name().into(),
                seed,
                limb: limb(done.limb),
                force_n: done.force,
                told: told.map_or("nothing", |(s, _)| s.kind.name()).into(),
                told_limb: limb_told.map_or("none".to_string(), limb),
                peak_force_n: told.map_or(f64::NAN, |(s, _)| s.peak_force),
                duration_s: told.map_or(f64::NAN, |(s, _)| s.ended - s.began),
                latency_s: latency.unwrap_or(f64::NAN),
                sensations: felt.len(),
            });
        }
    }
    let mut summary: Vec<SensationsSummary> = Vec::new();
    let mut right = 0;
    for (k, kind) in kinds.iter().enumerate() {
        let done: usize = confusion[k].iter().sum();
        right += confusion[k][k];
        let [tap, press, stroke, rub, nothing] = confusion[k];
        let share = confusion[k][k] as f64 / done.max(1) as f64;
        summary.push(SensationsSummary {
            done: kind.name().into(),
            tap,
            press,
            stroke,
            rub,
            nothing,
            right: share,
        });
    }
    let slowest = of_kind.iter().flatten().copied().fold(0.0, f64::max);
    let share = |count: usize| count as f64 / all.max(1) as f64;
    let notes = vec![
        "A row is what was done, a column what the touch sensor said of it.".to_string(),
        format!(
            "Right kind {:.3}, right limb {:.3} of {all} stimulations; decided at most {:.0} ms after the last contact.",
            share(right),
            share(right_limb),
            1e3 * slowest
        ),
    ];
    let told = kinds.iter().map(|kind| kind.name()).chain(["nothing"]);
    let row = |counts: &[usize; 5]| -> Map<String, Value> {
        told.clone().zip(counts).map(|(name, count)| (name.to_string(), json!(count))).collect()
    };
    let table: Map<String, Value> =
        kinds.iter().zip(&confusion).map(|(kind, counts)| (kind.name().into(), row(counts).into())).collect();
    let numbers = vec![
        ("accuracy", json!(share(right))),
        ("limb_accuracy", json!(share(right_limb))),
        ("confusion", table.into()),
        ("latency_s", json!(slowest)),
    ];
    let series = kinds.iter().enumerate().map(|(k, kind)| PlotSeries {
        name: kind.name().to_string(),
        line: Vec::new(),
        dots: of_kind[k].iter().map(|latency| (1e3 * latency, k as f64)).collect(),
    });
    let plot = StudyPlot {
        x: PlotAxis { title: "decided after the last contact, ms", scale: AxisScale::Logarithmic },
        y: PlotAxis {
            title: "",
            scale: AxisScale::Names(kinds.iter().map(|kind| kind.name().into()).collect()),
        },
        series: series.collect(),
    };
    Ok(Findings { measurements, summary, notes, plot, numbers })
}
