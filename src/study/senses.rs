//! How well the touch sensor recognizes stimuli on the skin.

use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use serde_json::json;

use super::{Row, Studied, Study, Trial, columns};
use crate::creature::JointSelection;
use crate::error::{Error, Result};
use crate::senses::{Sensation, TouchEvent, TouchKind, TouchSensor, Toucher};
use crate::simulation::partner::{Stimulation, Strokes};
use crate::simulation::{ProbePath, Stage, StepSenses};
use crate::skin::SomatotopicMap;

pub(super) const STUDY: Study = Study {
    name: "senses",
    about: "recognition of taps, presses, strokes, rubs, strokes across joints and strokes with a damaged map; a trial is one of each",
    of: Studied::Creature,
    touches: None,
    seconds: None,
    cases: || CASES.map(|(name, _)| name.to_string()).into(),
    columns: columns! {
        done: Case, seed, limb, last_limb, force_n, reported, reported_limb, reported_last_limb, tap: Sum,
        press: Sum, stroke: Sum, rub: Sum, nothing: Sum, kind_right: Share, limbs_right: Share,
        alone: Share, right: Share, peak_force_n, duration_s, latency_s: Median Most,
    },
    notes: &[
        "Rows are stimuli; tap, press, stroke, rub and nothing count the touch sensor's reports. right: one \
         sensation of the right kind, from the right limb to the right limb. latency_s: delay between the last \
         contact and the report.",
    ],
    run,
};

/// How long after the end of a stimulation a sensation is waited for, seconds: half of it a probe may be stuck somewhere.
const PATIENCE: f64 = 1.0;
/// What touches.
const PROBE: &str = "probe";

/// The case of a sensor whose map has every other link missing.
const UNLINKED: &str = "stroke, half the map missing";

/// Draws the path of a probe that starts at a time, seconds; `None` if there is no room for it.
type Drawn = fn(&Strokes, f64, &mut ChaCha8Rng) -> Option<Stimulation>;

/// The cases: their names, and the stimulation of each.
const CASES: [(&str, Drawn); 7] = [
    ("tap", |strokes, time, rng| strokes.random(TouchKind::Tap, time, rng)),
    ("press", |strokes, time, rng| strokes.random(TouchKind::Press, time, rng)),
    ("stroke", |strokes, time, rng| strokes.random(TouchKind::Stroke, time, rng)),
    ("rub", |strokes, time, rng| strokes.random(TouchKind::Rub, time, rng)),
    ("stroke across a joint", |strokes, time, rng| strokes.across(1, time, rng)),
    ("stroke across two joints", |strokes, time, rng| strokes.across(2, time, rng)),
    (UNLINKED, |strokes, time, rng| strokes.random(TouchKind::Stroke, time, rng)),
];

fn run(trial: &Trial) -> Result<Vec<Row>, Error> {
    let subject = trial.subject()?;
    let stage = subject.stage(&JointSelection::All, &[PROBE], Vec::new())?;
    let map = stage.sense(|sensor: &mut TouchSensor| sensor.map().clone());
    let mut rows = Vec::new();
    for (stream, (name, draw)) in CASES.into_iter().enumerate().filter(|(_, (name, _))| trial.asks(name)) {
        let mut rng = ChaCha8Rng::seed_from_u64(trial.seed);
        rng.set_stream(stream as u64);
        let followed = match name {
            UNLINKED => SomatotopicMap::of_links(map.receptors(), map.pairs().step_by(2)),
            _ => map.clone(),
        };
        stage.sense(|sensor| *sensor = TouchSensor::new(followed, stage.skin()));
        let mut row = match draw(&Strokes::new(&stage), stage.time(), &mut rng) {
            Some(done) => compared(&stage, &done)?,
            None => json!({"reported": "no room"}),
        };
        row["done"] = json!(name);
        rows.push(row);
    }
    Ok(rows)
}

/// Does something, and compares it with what is felt of it.
fn compared(stage: &Stage, done: &Stimulation) -> Result<Row, Error> {
    let name = |limb: usize| stage.agent().creature().limbs()[limb].clone();
    let felt = feel(stage, done)?;
    let alone = felt.len() == 1;
    // Of several sensations the longest is taken for it.
    let lasted = |felt: &Sensation| felt.ended - felt.began;
    let felt = felt.into_iter().max_by(|a, b| lasted(&a.0).total_cmp(&lasted(&b.0)));
    let felt = felt.as_ref();
    let ends = [done.limbs[0], done.limbs[done.limbs.len() - 1]];
    let side = felt.map(|(felt, _)| &felt.sides[0]);
    let kind = felt.is_some_and(|(felt, _)| felt.kind == done.kind);
    let limbs = side.is_some_and(|side| [side.limb, side.last_limb] == ends);
    let reported = felt.map_or("nothing", |(felt, _)| felt.kind.name());
    let mut row = json!({
        "limb": name(ends[0]),
        "last_limb": name(ends[1]),
        "force_n": done.force,
        "reported": reported,
        "reported_limb": side.map(|side| name(side.limb)),
        "reported_last_limb": side.map(|side| name(side.last_limb)),
        "kind_right": kind,
        "limbs_right": limbs,
        "alone": alone,
        "right": kind && limbs && alone,
        "peak_force_n": felt.map(|(felt, _)| felt.peak_force),
        "duration_s": felt.map(|(felt, _)| lasted(felt)),
        "latency_s": felt.map(|(_, decided)| decided - done.touching[1]),
    });
    let names = TouchKind::ALL.iter().map(|kind| kind.name()).chain(["nothing"]);
    names.for_each(|name| row[name] = json!(name == reported));
    Ok(row)
}

/// Sends a probe and lets the creature feel it; what was felt of it, and when each sensation was decided.
fn feel(stage: &Stage, done: &Stimulation) -> Result<Vec<(Sensation, f64)>> {
    let probe = stage.thing(PROBE).map(Toucher::Thing);
    stage.send_probe(0, done.path.clone())?;
    let end = done.path.end() + PATIENCE;
    let mut felt = Vec::new();
    while stage.time() <= end {
        let StepSenses { time, touches, .. } = stage.step()?;
        felt.extend(touches.into_iter().filter_map(|event| match event {
            TouchEvent::Sensed { sensation, .. } => Some((sensation, time)),
            TouchEvent::Began { .. } => None,
        }));
    }
    felt.retain(|(sensation, _)| Some(sensation.by) == probe);
    stage.send_probe(0, ProbePath::default())?;
    Ok(felt)
}
