//! How well the touch sensor tells what is done to the skin.

use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use serde_json::{Map, Value, json};

use super::plot::{Axis, Plot, Scale, Series};
use super::subject::Subject;
use super::table::{Cell, Column, Table};
use super::{Findings, Study};
use crate::cli::Failure;
use crate::interaction::Strokes;
use crate::senses::{Kind, Sensation, TouchEvent};

pub const STUDY: Study = Study {
    name: "sensations",
    about: "how well taps, presses, strokes and rubs are told apart; a trial is one of each kind",
    touches: false,
    measure,
};

/// How long after the end of a stimulation a sensation is waited for, seconds.
const PATIENCE: f64 = 0.5;

const MEASUREMENTS: &[Column] = &[
    Column { name: "kind", heading: "done" },
    Column { name: "seed", heading: "seed" },
    Column { name: "limb", heading: "limb" },
    Column { name: "force_n", heading: "force, N" },
    Column { name: "told", heading: "told" },
    Column { name: "told_limb", heading: "told limb" },
    Column { name: "peak_force_n", heading: "felt, N" },
    Column { name: "duration_s", heading: "lasted, s" },
    Column { name: "latency_s", heading: "decided after, s" },
    Column { name: "sensations", heading: "sensations" },
];

const SUMMARY: &[Column] = &[
    Column { name: "done", heading: "done" },
    Column { name: "tap", heading: "told tap" },
    Column { name: "press", heading: "press" },
    Column { name: "stroke", heading: "stroke" },
    Column { name: "rub", heading: "rub" },
    Column { name: "nothing", heading: "nothing" },
    Column { name: "right", heading: "right, share" },
];

fn measure(subject: &Subject) -> Result<Findings, Failure> {
    let mut world = subject.world()?;
    let mut measurements = Table::new(MEASUREMENTS);
    let kinds = Kind::ALL;
    let mut confusion = [[0usize; 5]; 4];
    let (mut right_limb, mut all) = (0usize, 0usize);
    let mut of_kind: [Vec<f64>; 4] = Default::default();
    for &seed in &subject.seeds {
        for (k, &kind) in kinds.iter().enumerate() {
            let mut rng = ChaCha8Rng::seed_from_u64(seed);
            rng.set_stream(k as u64);
            let done = {
                let strokes = Strokes::new(&world);
                strokes.random(kind, world.data.time(), &mut rng)
            };
            let Some(done) = done else {
                return Err(Failure(format!("no limb of this creature has room for a {}", kind.name())));
            };
            let (end, body) = (done.path.end(), world.probe_body(0));
            world.send(0, done.path.clone())?;
            let mut last_contact = world.data.time();
            let mut felt: Vec<(Sensation, f64)> = Vec::new();
            loop {
                let (time, events) = world.step()?;
                if world
                    .data
                    .contacts()
                    .any(|c| c.geoms.iter().any(|&g| world.body.model.geom_body(g) == body))
                {
                    last_contact = time;
                }
                felt.extend(events.into_iter().filter_map(|event| match event {
                    TouchEvent::Sensed { sensation, .. } if sensation.object == Some(body) => {
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
            let limb = |limb: usize| world.body.creature.limbs()[limb].clone();
            measurements.row([
                kind.name().into(),
                seed.into(),
                limb(done.limb).into(),
                done.force.into(),
                told.map_or("nothing", |(s, _)| s.kind.name()).into(),
                limb_told.map_or("none".to_string(), limb).into(),
                told.map_or(Cell::from(f64::NAN), |(s, _)| s.peak_force.into()),
                told.map_or(Cell::from(f64::NAN), |(s, _)| (s.ended - s.began).into()),
                latency.unwrap_or(f64::NAN).into(),
                felt.len().into(),
            ]);
        }
    }
    let mut summary = Table::new(SUMMARY);
    let mut right = 0;
    for (k, kind) in kinds.iter().enumerate() {
        let done: usize = confusion[k].iter().sum();
        right += confusion[k][k];
        let [tap, press, stroke, rub, nothing] = confusion[k].map(Cell::from);
        let share = confusion[k][k] as f64 / done.max(1) as f64;
        summary.row([kind.name().into(), tap, press, stroke, rub, nothing, share.into()]);
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
    let series = kinds.iter().enumerate().map(|(k, kind)| Series {
        name: kind.name().to_string(),
        line: Vec::new(),
        dots: of_kind[k].iter().map(|latency| (1e3 * latency, k as f64)).collect(),
    });
    let plot = Plot {
        x: Axis { title: "decided after the last contact, ms", scale: Scale::Logarithmic },
        y: Axis { title: "", scale: Scale::Names(kinds.iter().map(|kind| kind.name().into()).collect()) },
        series: series.collect(),
    };
    Ok(Findings { measurements, summary, notes, plot, numbers })
}
