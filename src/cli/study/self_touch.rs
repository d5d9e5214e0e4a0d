//! Whether a creature tells its own touch from another's.

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use serde_json::json;

use super::plot::{Axis, Plot, Scale, Series};
use super::subject::Subject;
use super::table::{Cell, Column, Table};
use super::{Findings, Study};
use crate::cli::Failure;
use crate::interaction::{Strokes, World};
use crate::learning::rough::imagined;
use crate::learning::surface_gap::SurfaceGap;
use crate::learning::touch_set::TouchSet;
use crate::senses::{Kind, Touch, TouchEvent};

pub const STUDY: Study = Study {
    name: "self-touch",
    about: "whether self-touch and being touched are ever confused; a trial is one contact",
    touches: false,
    measure,
};

/// How deep limbs that touch are pressed into each other, metres: a babbled touch only just meets.
const PRESSED: f64 = 1e-3;
/// Step of a coordinate over which the gap's gradient is taken, radians or metres.
const NUDGE: f64 = 1e-5;
/// How long a self-touch is held, seconds.
const HELD: f64 = 0.15;
/// How long the creature is watched afterwards, seconds: long enough for every sensation to end.
const AFTER: f64 = 0.1;

const MEASUREMENTS: &[Column] = &[
    Column { name: "done", heading: "done" },
    Column { name: "seed", heading: "seed" },
    Column { name: "self_events", heading: "self-touches told" },
    Column { name: "other_events", heading: "others told" },
    Column { name: "peak_force_n", heading: "felt, N" },
    Column { name: "right", heading: "right" },
];

const SUMMARY: &[Column] = &[
    Column { name: "done", heading: "done" },
    Column { name: "trials", heading: "trials" },
    Column { name: "told_self", heading: "self told" },
    Column { name: "told_other", heading: "other told" },
    Column { name: "told_both", heading: "both told" },
    Column { name: "nothing", heading: "nothing" },
    Column { name: "right", heading: "right, share" },
];

/// What a trial is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Done {
    /// The creature touches itself.
    Itself,
    /// A probe taps it.
    Other,
    /// A probe taps it while it touches itself.
    Both,
}

impl Done {
    const ALL: [Done; 3] = [Done::Itself, Done::Other, Done::Both];

    fn name(self) -> &'static str {
        match self {
            Done::Itself => "self",
            Done::Other => "other",
            Done::Both => "both",
        }
    }

    /// Whether the creature touches itself, and whether a probe does.
    fn parties(self) -> [bool; 2] {
        [self != Done::Other, self != Done::Itself]
    }
}

/// What was told in a trial: by self-touch and by another's, how many sensations, and whether any beginning or
/// sensation told of that party.
#[derive(Default)]
struct Told {
    sensed: [usize; 2],
    named: [bool; 2],
    peak_force: f64,
}

impl Told {
    fn take(&mut self, event: &TouchEvent) {
        let party = |object: Option<usize>| usize::from(object.is_some());
        match event {
            TouchEvent::Began { contact, .. } => self.named[party(contact.object)] = true,
            TouchEvent::Sensed { sensation, .. } => {
                self.named[party(sensation.object)] = true;
                self.sensed[party(sensation.object)] += 1;
                self.peak_force = self.peak_force.max(sensation.peak_force);
            }
        }
    }

    fn sensed(&self) -> [bool; 2] {
        self.sensed.map(|count| count > 0)
    }
}

fn measure(subject: &Subject) -> Result<Findings, Failure> {
    let mut world = subject.world()?;
    let reference = qpos(subject, &subject.body.creature.reference_posture());
    let trials: Vec<(u64, ChaCha8Rng, Done)> = subject
        .seeds
        .iter()
        .map(|&seed| {
            let mut rng = ChaCha8Rng::seed_from_u64(seed);
            let done = Done::ALL[rng.random_range(0..Done::ALL.len())];
            (seed, rng, done)
        })
        .collect();
    let needed = trials.iter().filter(|(_, _, done)| done.parties()[0]).count();
    // One babbling for all trials: a touch each, and no more than that.
    let touches = match needed {
        0 => Vec::new(),
        _ => subject.babble_body(&subject.body, &subject.skin, needed, subject.seeds[0])?,
    };
    let mut touches = touches.iter();
    let mut measurements = Table::new(MEASUREMENTS);
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
        let told = trial(&mut world, done, &posture, &reference, &mut rng)?;
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
        let k = Done::ALL.iter().position(|&other| other == done).expect("all are listed");
        right_of[k] += usize::from(is_right);
        let column = match sensed {
            [true, false] => 0,
            [false, true] => 1,
            [true, true] => 2,
            [false, false] => 3,
        };
        counts[k][column] += 1;
        forces[k].push(told.peak_force);
        measurements.row([
            done.name().into(),
            seed.into(),
            told.sensed[0].into(),
            told.sensed[1].into(),
            told.peak_force.into(),
            is_right.into(),
        ]);
    }
    let mut summary = Table::new(SUMMARY);
    for (k, done) in Done::ALL.iter().enumerate() {
        let all: usize = counts[k].iter().sum();
        let [itself, other, both, nothing] = counts[k].map(Cell::from);
        let share = right_of[k] as f64 / all as f64;
        summary.row([done.name().into(), all.into(), itself, other, both, nothing, share.into()]);
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
    let series = Done::ALL.iter().enumerate().map(|(k, done)| Series {
        name: done.name().to_string(),
        line: Vec::new(),
        dots: forces[k].iter().filter(|&&force| force > 0.0).map(|&force| (force, k as f64)).collect(),
    });
    let names = Done::ALL.iter().map(|done| done.name().into()).collect();
    let plot = Plot {
        x: Axis { title: "greatest force felt, N", scale: Scale::Logarithmic },
        y: Axis { title: "", scale: Scale::Names(names) },
        series: series.collect(),
    };
    Ok(Findings { measurements, summary, notes, plot, numbers })
}

/// Does what a trial is, in a posture, and goes back to the reference posture; what was told.
fn trial(
    world: &mut World,
    done: Done,
    posture: &[f64],
    reference: &[f64],
    rng: &mut ChaCha8Rng,
) -> Result<Told, Failure> {
    let mut told = Told::default();
    world.hold_qpos(posture)?;
    // The way of a probe is laid over the skin where a step has put it.
    let (began, events) = world.step()?;
    events.iter().for_each(|event| told.take(event));
    let mut end = began + HELD;
    if done != Done::Itself {
        let tap = Strokes::new(world).random(Kind::Tap, world.data.time(), rng);
        let tap = tap.ok_or("no limb of this creature has room for a tap")?;
        end = tap.path.end();
        world.send(0, tap.path)?;
    }
    watch(world, end, &mut told)?;
    // The creature moves now, and must not run into the probe.
    let now = world.data.time();
    world.withdraw(0)?;
    world.hold_qpos(reference)?;
    watch(world, now + AFTER, &mut told)?;
    Ok(told)
}

/// Simulates to a time, seconds.
fn watch(world: &mut World, end: f64, told: &mut Told) -> Result<(), Failure> {
    loop {
        let (time, events) = world.step()?;
        events.iter().for_each(|event| told.take(event));
        if time > end {
            return Ok(());
        }
    }
}

/// The engine's coordinates of a posture of the studied joints.
fn qpos(subject: &Subject, posture: &[f64]) -> Vec<f64> {
    let mut qpos = vec![0.0; subject.body.model.nq()];
    subject.body.write_qpos(posture, &mut qpos);
    qpos
}

/// A touch's posture moved the shortest way to where the two limbs press on each other.
fn pressed(subject: &Subject, touch: &Touch) -> Vec<f64> {
    let receptors = touch.ends.map(|end| end.receptor);
    let gap = |posture: &[f64]| {
        let set = TouchSet::new(&subject.body.creature, [imagined(&subject.skin, receptors, posture)]);
        let touch = set.touches().next().expect("it is a set of one");
        SurfaceGap::new(&subject.skin, 1.0).meeting(&touch.ends, &touch.frames(&subject.truth.schema)).gap
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
