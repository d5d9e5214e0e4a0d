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
    of: Studied::Touched,
    touches: None,
    seconds: None,
    cases: || Doing::ALL.map(|doing| doing.name().to_string()).into(),
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

/// What is done in a trial.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Doing {
    /// One touch of a kind, on one limb.
    One(TouchKind),
    /// A stroke over so many joints.
    Across(usize),
    /// A stroke on one limb that is followed by a map with every other link missing.
    Unlinked,
}

impl Doing {
    const ALL: [Doing; 7] = [
        Doing::One(TouchKind::Tap),
        Doing::One(TouchKind::Press),
        Doing::One(TouchKind::Stroke),
        Doing::One(TouchKind::Rub),
        Doing::Across(1),
        Doing::Across(2),
        Doing::Unlinked,
    ];

    fn name(self) -> &'static str {
        match self {
            Doing::One(kind) => kind.name(),
            Doing::Across(1) => "stroke across a joint",
            Doing::Across(_) => "stroke across two joints",
            Doing::Unlinked => "stroke, half the map missing",
        }
    }

    /// What a probe does, setting out now. `None` if there is no room for it.
    fn draw(self, stage: &Stage, rng: &mut ChaCha8Rng) -> Option<Stimulation> {
        let (strokes, time) = (Strokes::new(stage), stage.time());
        match self {
            Doing::One(kind) => strokes.random(kind, time, rng),
            Doing::Across(joints) => strokes.across(joints, time, rng),
            Doing::Unlinked => strokes.random(TouchKind::Stroke, time, rng),
        }
    }
}

fn run(trial: &Trial) -> Result<Vec<Row>, Error> {
    let subject = trial.subject()?;
    let stage = subject.stage(&JointSelection::All, &[PROBE], Vec::new())?;
    let map = stage.sense(|sensor: &mut TouchSensor| sensor.map().clone());
    let mut rows = Vec::new();
    for (stream, doing) in Doing::ALL.into_iter().enumerate().filter(|(_, doing)| trial.asks(doing.name())) {
        let mut rng = ChaCha8Rng::seed_from_u64(trial.seed);
        rng.set_stream(stream as u64);
        let followed = match doing {
            Doing::Unlinked => SomatotopicMap::of_links(map.receptors(), map.pairs().step_by(2)),
            _ => map.clone(),
        };
        stage.sense(|sensor| *sensor = TouchSensor::new(followed, stage.skin()));
        let mut row = match doing.draw(&stage, &mut rng) {
            Some(done) => compared(&stage, &done)?,
            None => json!({"reported": "no room"}),
        };
        row["done"] = json!(doing.name());
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
