//! A trial of the study `sensations`: what probes do to a creature, what the engine says that they did, and what the touch
//! sensor makes of it.

use std::collections::BTreeSet;

use rand::RngExt;
use rand_chacha::ChaCha8Rng;

use crate::mujoco;
use crate::senses::{FAINT, Party, Sensation, SkinContact, TouchEvent, TouchKind, TouchSensor, Toucher};
use crate::simulation::partner::{Stimulation, Strokes};
use crate::simulation::{PROBE_RADIUS, Stage, StepSenses};
use crate::skin::SomatotopicMap;

/// How long after the end of a stimulation a sensation is waited for, seconds.
const PATIENCE: f64 = 0.5;
/// How long after the end a probe that is stuck somewhere may touch on, seconds.
const STUCK: f64 = 2.0;
/// A probe that touches nothing for longer than this in between has left the skin, seconds: it is no stroke then.
const LEFT: f64 = 0.02;
/// How far apart the middles of two probes are at the least, metres: so far are those of two fingers side by side with a
/// little between them.
const APART: f64 = 3.0 * PROBE_RADIUS;
/// How far apart the beginnings of two touches are at the most where they are to be near each other, metres.
const NEAR: f64 = 0.08;
/// Steps in which two paths are compared, seconds.
const LOOK: f64 = 0.005;
/// Pairs of touches that are tried.
const PAIRS: usize = 200;

/// What is done in a trial.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Doing {
    /// One touch of a kind, on one limb.
    One(TouchKind),
    /// A stroke over so many joints.
    Across(usize),
    /// Two touches at once: by one party or by two.
    Two {
        /// Whether both are felt as the same party's.
        one_party: bool,
    },
}

impl Doing {
    /// All that is measured.
    pub const ALL: [Doing; 8] = [
        Doing::One(TouchKind::Tap),
        Doing::One(TouchKind::Press),
        Doing::One(TouchKind::Stroke),
        Doing::One(TouchKind::Rub),
        Doing::Across(1),
        Doing::Across(2),
        Doing::Two { one_party: false },
        Doing::Two { one_party: true },
    ];

    /// Its name.
    pub fn name(self) -> &'static str {
        match self {
            Doing::One(kind) => kind.name(),
            Doing::Across(1) => "stroke over a joint",
            Doing::Across(_) => "stroke over two joints",
            Doing::Two { one_party: false } => "two at once, two parties",
            Doing::Two { one_party: true } => "two at once, one party",
        }
    }

    /// What probes do, setting out now; none where there is no room for it.
    pub fn draw(self, stage: &Stage, rng: &mut ChaCha8Rng) -> Option<Vec<Stimulation>> {
        let (strokes, time) = (Strokes::new(stage), stage.time());
        match self {
            Doing::One(kind) => Some(vec![strokes.random(kind, time, rng)?]),
            Doing::Across(joints) => Some(vec![strokes.across(joints, time, rng)?]),
            Doing::Two { .. } => (0..PAIRS).find_map(|_| two(stage, &strokes, rng)),
        }
    }
}

/// Two touches at once, of any kinds, anywhere or, every other time, near each other on one limb.
fn two(stage: &Stage, strokes: &Strokes, rng: &mut ChaCha8Rng) -> Option<Vec<Stimulation>> {
    let kind = |rng: &mut ChaCha8Rng| TouchKind::ALL[rng.random_range(0..TouchKind::ALL.len())];
    let kinds = [kind(rng), kind(rng)];
    let first = strokes.random(kinds[0], stage.time(), rng)?;
    let lasts = first.touching[1] - first.touching[0];
    let time = stage.time() + rng.random_range(0.0..0.8) * lasts;
    let second = if rng.random_bool(0.5) {
        let receptors = &stage.skin().receptors;
        let begins = first.begins;
        let frame = &stage.limb_frames()[first.limbs[0]];
        let near: Vec<usize> = (0..receptors.len())
            .filter(|&r| receptors[r].limb == first.limbs[0])
            .filter(|&r| (frame.point(&receptors[r].position) - begins).norm() <= NEAR)
            .collect();
        strokes.at(
            kinds[1],
            near[rng.random_range(0..near.len().max(1)).min(near.len().checked_sub(1)?)],
            time,
            rng,
        )?
    } else {
        strokes.random(kinds[1], time, rng)?
    };
    let until = first.path.end().max(second.path.end());
    let steps = ((until - stage.time()) / LOOK) as usize;
    let apart = (0..=steps).all(|k| {
        let at = [&first, &second].map(|done| done.path.at(stage.time() + k as f64 * LOOK));
        at[0].zip(at[1]).is_none_or(|(a, b)| (a - b).norm() >= APART)
    });
    apart.then(|| vec![first, second])
}

/// What the engine says that a probe did.
#[derive(Clone, Debug)]
pub struct TrueTouch {
    /// The party that it is felt as.
    pub party: Party,
    /// The limbs that it touched in its first step, and in its last one.
    pub ends: [BTreeSet<usize>; 2],
    /// All limbs that it touched.
    pub limbs: BTreeSet<usize>,
    /// When it touched first and last, seconds; none where it never did.
    pub span: Option<[f64; 2]>,
    /// How long it touched nothing in between at the most, seconds.
    pub pause: f64,
    /// Whether it touched another probe.
    pub met: bool,
}

impl TrueTouch {
    fn of(party: Party) -> TrueTouch {
        let (ends, limbs) = Default::default();
        TrueTouch { party, ends, limbs, span: None, pause: 0.0, met: false }
    }

    fn take(&mut self, stage: &Stage, body: usize, time: f64) {
        let data = stage.data();
        let on = |geom: usize| stage.body().limb_of_geom(geom);
        let mut limbs = BTreeSet::new();
        for (contact, _) in data.pressing().filter(|(_, force)| *force >= FAINT) {
            let bodies = contact.geoms.map(|geom| stage.body().model.geom_body(geom));
            if let Some(k) = bodies.iter().position(|b| *b == body) {
                match on(contact.geoms[1 - k]) {
                    Some(limb) => _ = limbs.insert(limb),
                    None => self.met = true,
                }
            }
        }
        if limbs.is_empty() {
            return;
        }
        match &mut self.span {
            Some(span) => {
                self.pause = self.pause.max(time - span[1]);
                span[1] = time;
            }
            None => {
                self.span = Some([time; 2]);
                self.ends[0] = limbs.clone();
            }
        }
        self.limbs.extend(&limbs);
        self.ends[1] = limbs;
    }

    /// Whether the probe did what it was to do: it stayed on the skin from the first limb to the last one, and met nothing
    /// else.
    pub fn is(&self, done: &Stimulation) -> bool {
        let (first, last) = (done.limbs[0], done.limbs[done.limbs.len() - 1]);
        let on_the_row = done.limbs.iter().all(|limb| self.limbs.contains(limb));
        !self.met
            && self.pause <= LEFT
            && on_the_row
            && self.ends[0].contains(&first)
            && self.ends[1].contains(&last)
            && (done.limbs.len() == 1 || self.ends[0].is_disjoint(&self.ends[1]))
    }
}

/// What a trial came to.
pub struct TouchedTrial {
    /// Per probe, what it truly did.
    pub truly: Vec<TrueTouch>,
    /// What was felt of all probes, and when each was decided.
    pub felt: Vec<(Sensation, f64)>,
}

/// Sends probes and lets the creature feel them; where they are of one party, it cannot tell them apart by that.
///
/// # Errors
/// Where the engine fails.
pub fn touch(stage: &Stage, done: &[Stimulation], one_party: bool) -> mujoco::Result<TouchedTrial> {
    let bodies: Vec<usize> = (0..done.len()).map(|probe| stage.probe_thing(probe)).collect();
    for (probe, done) in done.iter().enumerate() {
        stage.send_probe(probe, done.path.clone())?;
    }
    let end = done.iter().map(|done| done.path.end()).fold(0.0, f64::max);
    let mut own_sensor = match one_party {
        true => Some(TouchSensor::new(SomatotopicMap::at_ease(stage.body(), stage.skin())?, stage.skin())),
        false => None,
    };
    let felt_as = |body: &usize| Party::Thing(if one_party { bodies[0] } else { *body });
    let truly = bodies.iter().map(|body| TrueTouch::of(felt_as(body)));
    let mut trial = TouchedTrial { truly: truly.collect(), felt: Vec::new() };
    let mut quiet_since = stage.time();
    loop {
        let StepSenses { time, contacts, touches, .. } = stage.step()?;
        for (truly, body) in trial.truly.iter_mut().zip(&bodies) {
            truly.take(stage, *body, time);
            if truly.span.is_some_and(|span| span[1] == time) {
                quiet_since = time;
            }
        }
        let touches = match &mut own_sensor {
            Some(sensor) => sensor.follow(time, &of_one_party(&contacts, &bodies)),
            None => touches,
        };
        trial.felt.extend(touches.into_iter().filter_map(|event| match event {
            TouchEvent::Sensed { sensation, .. }
                if bodies.iter().any(|b| sensation.by == Party::Thing(*b)) =>
            {
                Some((sensation, time))
            }
            _ => None,
        }));
        if time > end.max(quiet_since.min(end + STUCK)) + PATIENCE {
            break;
        }
    }
    for probe in 0..done.len() {
        stage.withdraw_probe(probe)?;
    }
    Ok(trial)
}

/// The contacts as if all probes were one.
fn of_one_party(contacts: &[SkinContact], bodies: &[usize]) -> Vec<SkinContact> {
    let told = |contact: &SkinContact| match contact.by {
        Toucher::Thing(body) if bodies.contains(&body) => {
            SkinContact { by: Toucher::Thing(bodies[0]), ..contact.clone() }
        }
        _ => contact.clone(),
    };
    contacts.iter().map(told).collect()
}
