//! How well the aura predicts what is going to touch, and where.

use std::f64::consts::TAU;

use nalgebra::Vector3;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use serde::{Deserialize, Serialize};
use serde_json::json;

use super::plot::{AxisScale, PlotAxis, PlotSeries, StudyPlot};
use super::subject::Subject;
use super::table::row;
use super::{Findings, Study, Trial, Trials};
use crate::experiment::ExperimentError;
use crate::senses::{Approach, AuraEvent, TouchEvent};
use crate::simulation::{PROBE_RADIUS, ProbePath, Stage, StepSenses};

/// The study `approach`.
pub const STUDY: Study = Study {
    name: "approach",
    about: "how well the aura predicts which limb is hit, and where; a trial is an approach, a pass, a retreat and a touch that \
            lasts",
    touches: false,
    several: false,
    trials: Trials::of::<ApproachTrial>(),
};

/// How long before a contact it is to be predicted, seconds.
const AHEAD: f64 = 0.3;
/// How long an object must have been seen, seconds.
const SEEN: f64 = 0.05;
/// How far from the skin objects set out, metres.
const FAR: f64 = 0.9;

row! {
    /// A measurement of the study `approach`.
    pub struct ApproachMeasurement {
        way: String = "way",
        seed: u64 = "seed",
        speed_m_s: f64 = "speed, m/s",
        hit_limb: String = "hit",
        hit_receptor: String = "receptor",
        predicted_limb: String = "predicted 0.3 s ahead",
        limb_right: bool = "limb right",
        receptor_named: bool = "receptor named",
        alarms: usize = "alarms",
        first_alarm_s: f64 = "first alarm, s ahead",
    }
}

row! {
    /// A row of the summary of the study `approach`.
    pub struct ApproachSummary {
        way: String = "way",
        trials: usize = "trials",
        hits: usize = "hit",
        limb_accuracy: f64 = "limb right 0.3 s ahead",
        receptor_accuracy: f64 = "receptor among five",
        false_alarms: usize = "alarmed, not hit",
    }
}

/// The ways that an object takes; one that touches already when it is first looked at presses, then goes along the skin.
const WAYS: [&str; 4] = ["approach", "pass", "retreat", "touching"];
/// How deep what touches already presses into the skin, metres, how long it stays before it goes on, and how long after
/// that it is watched, seconds.
const PRESSED: [f64; 2] = [5e-4, 3e-3];
const STAYS: f64 = 0.5;
const GOES_ON: f64 = 0.7;
/// The fastest that it goes along the skin, metres a second.
const ALONG_SKIN: f64 = 0.1;

fn direction(rng: &mut ChaCha8Rng) -> Vector3<f64> {
    let (z, angle) = (rng.random_range(-1.0..1.0_f64), rng.random_range(0.0..TAU));
    let ring = (1.0 - z * z).sqrt();
    Vector3::new(ring * angle.cos(), ring * angle.sin(), z)
}

/// A way past or to a random place of the skin, as fast as drawn, bent by a random acceleration.
fn way(stage: &Stage, name: &str, time: f64, rng: &mut ChaCha8Rng) -> (ProbePath, f64) {
    let skin = stage.skin();
    let receptor = &skin.receptors[rng.random_range(0..skin.receptors.len())];
    let pose = stage.limb_pose(receptor.limb);
    let target = (pose * nalgebra::Point3::from(receptor.position)).coords;
    let normal = pose.rotation * receptor.normal;
    // From outside: what comes from within a body is no approach.
    let from = loop {
        let drawn = direction(rng);
        if drawn.dot(&normal) > 0.2 {
            break drawn;
        }
    };
    let speed = rng.random_range(0.2..1.0);
    let bend = from.cross(&direction(rng)) * rng.random_range(0.0..1.0);
    let (reach, aside) = match name {
        "approach" => (FAR + 0.05, Vector3::zeros()),
        "pass" => (2.0 * FAR, from.cross(&direction(rng)).normalize() * rng.random_range(0.05..0.3)),
        _ => (FAR, Vector3::zeros()),
    };
    let seconds = reach / speed;
    // When it is at its target, straight ahead of where it set out but for the bend.
    let arrival = if name == "retreat" { 0.0 } else { FAR / speed };
    let at = |t: f64| {
        let bent = bend * (0.5 * (t - arrival).powi(2));
        match name {
            "retreat" => target + normal * (PROBE_RADIUS + 0.03) + from * (speed * t) + bend * (0.5 * t * t),
            _ => target + aside + from * (FAR - speed * t) + bent,
        }
    };
    let count = (seconds / 0.004).ceil() as usize;
    let points = (0..=count).map(|k| k as f64 * seconds / count as f64).map(|t| (time + t, at(t)));
    (ProbePath(points.collect()), speed)
}

/// A way that begins on a random place of the skin, stays there, and then goes straight on along the skin or away from it.
fn touching_way(stage: &Stage, time: f64, rng: &mut ChaCha8Rng) -> ProbePath {
    let skin = stage.skin();
    let receptor = &skin.receptors[rng.random_range(0..skin.receptors.len())];
    let pose = stage.limb_pose(receptor.limb);
    let [depth, speed] = [rng.random_range(PRESSED[0]..PRESSED[1]), rng.random_range(0.0..ALONG_SKIN)];
    let start = pose * nalgebra::Point3::from(receptor.place(PROBE_RADIUS - depth).point);
    let drawn = direction(rng);
    let normal = pose.rotation * receptor.normal;
    // Never farther into it.
    let along = drawn - normal * drawn.dot(&normal).min(0.0);
    let end = start.coords + along * (speed * GOES_ON);
    ProbePath(vec![(time, start.coords), (time + STAYS, start.coords), (time + STAYS + GOES_ON, end)])
}

/// What came of a touch that lasts.
struct LastingTouch {
    /// Whether it touched at all.
    touched: bool,
    /// Alarms in all, …
    alarms: usize,
    /// … those for a limb that was touched then, …
    for_touched: usize,
    /// … and those for another that it would have met later and did not.
    for_missed: usize,
}

/// Watches what touches already, along its way.
fn lasting_touch(stage: &Stage, path: ProbePath) -> Result<LastingTouch, ExperimentError> {
    let end = path.end();
    stage.send_probe(0, path)?;
    stage.grow_aura();
    let mut found = LastingTouch { touched: false, alarms: 0, for_touched: 0, for_missed: 0 };
    let mut announced: Vec<usize> = Vec::new();
    while stage.time() < end {
        let StepSenses { time, contacts, near, .. } = stage.step()?;
        let touched: Vec<usize> = contacts.iter().map(|contact| contact.spot.limb).collect();
        found.touched |= !touched.is_empty();
        announced.retain(|limb| !touched.contains(limb));
        for event in &near {
            let AuraEvent::Alarm(Approach { contact: Some(contact), .. }) = event else { continue };
            found.alarms += 1;
            found.for_touched += usize::from(touched.contains(&contact.limb));
            // What would be met after the end of the way is not known to be wrong.
            if !touched.contains(&contact.limb) && time + contact.seconds < end {
                announced.push(contact.limb);
            }
        }
    }
    found.for_missed = announced.len();
    Ok(found)
}

/// What came of one trial.
#[derive(Debug, Default, Serialize, Deserialize)]
pub struct ApproachTrial {
    measurements: Vec<ApproachMeasurement>,
    /// For each of [`WAYS`].
    counts: [WayCounts; WAYS.len()],
    /// Of alarms before contacts, how long before, for each of [`WAYS`], seconds.
    leads: [Vec<f64>; WAYS.len()],
    /// Alarms for a limb that was touched then.
    touched_alarms: usize,
}

/// How often what came of one way.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize)]
struct WayCounts {
    trials: usize,
    hits: usize,
    limbs_right: usize,
    receptors_named: usize,
    /// Alarms without a hit.
    false_alarms: usize,
}

impl WayCounts {
    fn add(&mut self, other: &WayCounts) {
        self.trials += other.trials;
        self.hits += other.hits;
        self.limbs_right += other.limbs_right;
        self.receptors_named += other.receptors_named;
        self.false_alarms += other.false_alarms;
    }
}

impl Trial for ApproachTrial {
    type Setting = ();
    type Measurement = ApproachMeasurement;
    type Summary = ApproachSummary;

    fn set_up(_subject: &Subject) -> Result<(), ExperimentError> {
        Ok(())
    }

    fn run(subject: &Subject, (): &(), seed: u64) -> Result<ApproachTrial, ExperimentError> {
        let stage = subject.stage()?;
        let mut trial = ApproachTrial::default();
        for (k, name) in WAYS.iter().enumerate() {
            let mut rng = ChaCha8Rng::seed_from_u64(seed);
            rng.set_stream(k as u64);
            match *name {
                "touching" => trial.touch(&stage, k, seed, &mut rng)?,
                _ => trial.approach(&stage, k, seed, &mut rng)?,
            }
        }
        Ok(trial)
    }

    fn findings(
        _subject: &Subject,
        trials: &[ApproachTrial],
    ) -> Findings<ApproachMeasurement, ApproachSummary> {
        let mut all = ApproachTrial::default();
        for trial in trials {
            all.measurements.extend(trial.measurements.iter().cloned());
            all.counts.iter_mut().zip(&trial.counts).for_each(|(counts, more)| counts.add(more));
            all.leads.iter_mut().zip(&trial.leads).for_each(|(leads, more)| leads.extend(more));
            all.touched_alarms += trial.touched_alarms;
        }
        findings(all)
    }
}

impl ApproachTrial {
    /// Lets a probe touch that stays.
    fn touch(
        &mut self,
        stage: &Stage,
        way: usize,
        seed: u64,
        rng: &mut ChaCha8Rng,
    ) -> Result<(), ExperimentError> {
        let found = lasting_touch(stage, touching_way(stage, stage.time(), rng))?;
        self.counts[way].trials += usize::from(found.touched);
        self.counts[way].false_alarms += found.for_missed;
        self.touched_alarms += found.for_touched;
        self.measurements.push(ApproachMeasurement {
            way: WAYS[way].into(),
            seed,
            speed_m_s: 0.0,
            hit_limb: "none".into(),
            hit_receptor: "none".into(),
            predicted_limb: "none".into(),
            limb_right: false,
            receptor_named: false,
            alarms: found.alarms,
            first_alarm_s: f64::NAN,
        });
        Ok(())
    }

    /// Lets a probe go one of the other ways.
    fn approach(
        &mut self,
        stage: &Stage,
        drawn: usize,
        seed: u64,
        rng: &mut ChaCha8Rng,
    ) -> Result<(), ExperimentError> {
        let (path, speed) = way(stage, WAYS[drawn], stage.time(), rng);
        let end = path.end();
        stage.send_probe(0, path)?;
        let mut told: Vec<(f64, Option<Approach>)> = Vec::new();
        // Nothing was near before.
        stage.grow_aura();
        let mut alarms: Vec<f64> = Vec::new();
        let mut hit = None;
        while hit.is_none() && stage.time() < end {
            let StepSenses { time, touches, near, .. } = stage.step()?;
            let alarmed = near.iter().any(|event| matches!(event, AuraEvent::Alarm(_)));
            alarms.extend(alarmed.then_some(time));
            told.push((time, stage.approaches().into_iter().next()));
            // What touched last may still be felt to leave.
            hit = touches.iter().find_map(|event| match event {
                TouchEvent::Began { contact, .. } => Some((time, contact.spot)),
                TouchEvent::Sensed { .. } => None,
            });
        }
        // What moves away from one limb may come to another: then it is no retreat but a pass. What met a limb
        // before anybody could predict it tells nothing.
        let distances: Vec<f64> =
            told.iter().filter_map(|(_, approach)| Some(approach.as_ref()?.distance)).collect();
        let comes_near = distances.windows(2).any(|pair| pair[1] < pair[0] - 1e-4);
        let k = if WAYS[drawn] == "retreat" && (hit.is_some() || comes_near) { 1 } else { drawn };
        let begun = told.first().map_or(0.0, |(time, _)| *time);
        if hit.is_some_and(|(time, _)| time - AHEAD < begun + SEEN) {
            return Ok(());
        }
        let before = hit.map(|(time, _)| time - AHEAD);
        let predicted = before.and_then(|before| {
            let at = told.partition_point(|(time, _)| *time <= before);
            told[..at].last()?.1.clone()?.contact
        });
        let limb_right = hit
            .is_some_and(|(_, spot)| predicted.as_ref().is_some_and(|predicted| predicted.limb == spot.limb));
        let named = hit.is_some_and(|(_, spot)| {
            predicted.as_ref().is_some_and(|predicted| predicted.receptors.contains(&spot.receptor))
        });
        let lead = hit.and_then(|(time, _)| Some(time - alarms.first()?));
        self.leads[k].extend(lead);
        self.counts[k].add(&WayCounts {
            trials: 1,
            hits: usize::from(hit.is_some()),
            limbs_right: usize::from(limb_right),
            receptors_named: usize::from(named),
            false_alarms: usize::from(hit.is_none() && !alarms.is_empty()),
        });
        let limbs = stage.agent().creature().limbs();
        self.measurements.push(ApproachMeasurement {
            way: WAYS[k].into(),
            seed,
            speed_m_s: speed,
            hit_limb: hit.map_or("none".to_string(), |(_, spot)| limbs[spot.limb].clone()),
            hit_receptor: hit
                .map_or("none".to_string(), |(_, p)| stage.skin().receptors[p.receptor].id.clone()),
            predicted_limb: predicted.map_or("none".to_string(), |predicted| limbs[predicted.limb].clone()),
            limb_right,
            receptor_named: named,
            alarms: alarms.len(),
            first_alarm_s: lead.unwrap_or(f64::NAN),
        });
        Ok(())
    }
}

/// What trials say that are put together.
fn findings(all: ApproachTrial) -> Findings<ApproachMeasurement, ApproachSummary> {
    let ApproachTrial { measurements, counts, leads, touched_alarms } = all;
    let share = |part: usize, of: usize| part as f64 / of as f64;
    let summary = WAYS.iter().zip(&counts).map(|(name, count)| ApproachSummary {
        way: (*name).into(),
        trials: count.trials,
        hits: count.hits,
        limb_accuracy: share(count.limbs_right, count.hits),
        receptor_accuracy: share(count.receptors_named, count.hits),
        false_alarms: count.false_alarms,
    });
    let mut sum = WayCounts::default();
    counts.iter().for_each(|count| sum.add(count));
    let numbers = vec![
        ("accuracy", json!(share(sum.limbs_right, sum.hits))),
        ("receptor_accuracy", json!(share(sum.receptors_named, sum.hits))),
        ("receding_alarms", json!(counts[2].false_alarms)),
        ("touched_alarms", json!(touched_alarms)),
        ("hits", json!(sum.hits)),
    ];
    let notes = vec![
        "Balls of 16 mm on bent ways of 0.2 to 1 m/s: to a random place of the skin, past one by 5 to 30 cm, and away \
         from 3 cm above one."
            .to_string(),
        "Hits are predicted from what the aura said 0.3 s before the first contact.".to_string(),
        format!(
            "What touches already presses for 0.5 s and goes along the skin at up to 10 cm/s: {touched_alarms} alarms for a \
             limb that it touched then."
        ),
    ];
    let series = WAYS.iter().zip(&leads).enumerate().map(|(k, (name, leads))| PlotSeries {
        name: (*name).to_string(),
        line: Vec::new(),
        dots: leads.iter().map(|lead| (*lead, k as f64)).collect(),
    });
    let plot = StudyPlot {
        x: PlotAxis { title: "first alarm, s before the contact", scale: AxisScale::Logarithmic },
        y: PlotAxis { title: "", scale: AxisScale::Names(WAYS.iter().map(|name| (*name).into()).collect()) },
        series: series.collect(),
    };
    Findings { measurements, summary: summary.collect(), notes, plot, numbers }
}
