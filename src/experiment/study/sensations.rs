//! How well the touch sensor tells what is done to the skin.

use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use serde::{Deserialize, Serialize};
use serde_json::{Map, Value, json};

use super::plot::{AxisScale, PlotAxis, PlotSeries, StudyPlot};
use super::subject::Subject;
use super::table::row;
use super::touched_trial::{Doing, TouchedTrial, touch};
use super::{Findings, Study, Trial, Trials};
use crate::experiment::ExperimentError;
use crate::senses::{Sensation, TouchKind};
use crate::simulation::Stage;
use crate::simulation::partner::Stimulation;

/// The study `sensations`.
pub const STUDY: Study = Study {
    name: "sensations",
    about: "how well taps, presses, strokes, rubs, strokes over joints and two touches at once are told; a trial is one each",
    touches: false,
    several: false,
    trials: Trials::of::<SensationsTrial>(),
};

/// How often what is done is drawn again, at the most, where a probe left the skin of itself, or met another.
const DRAWS: u64 = 40;

row! {
    /// A measurement of the study `sensations`.
    pub struct SensationsMeasurement {
        done: String = "done",
        seed: u64 = "seed",
        kind: String = "kind",
        limb: String = "limb",
        last_limb: String = "last limb",
        force_n: f64 = "force, N",
        told: String = "told",
        told_limb: String = "told limb",
        told_last_limb: String = "told last limb",
        peak_force_n: f64 = "felt, N",
        duration_s: f64 = "lasted, s",
        latency_s: f64 = "decided after, s",
        sensations: usize = "sensations",
        redrawn: u64 = "redrawn",
        right: bool = "right",
    }
}

row! {
    /// A row of the summary of the study `sensations`.
    pub struct SensationsSummary {
        done: String = "done",
        touches: usize = "touches",
        tap: usize = "told tap",
        press: usize = "press",
        stroke: usize = "stroke",
        rub: usize = "rub",
        nothing: usize = "nothing",
        kind: f64 = "kind, share",
        limbs: f64 = "limbs, share",
        alone: f64 = "one sensation, share",
        right: f64 = "right, share",
    }
}

/// What one kind of doing came to.
#[derive(Debug, Default, Serialize, Deserialize)]
struct Told {
    /// Per kind told, and nothing.
    kinds: [usize; 5],
    touches: usize,
    trials: usize,
    kind: usize,
    limbs: usize,
    alone: usize,
    right: usize,
    latencies: Vec<f64>,
    redrawn: u64,
    /// Trials in which no draw was what it was to be.
    given_up: usize,
}

/// What came of one trial.
#[derive(Debug, Serialize, Deserialize)]
pub struct SensationsTrial {
    measurements: Vec<SensationsMeasurement>,
    /// For each of [`Doing::ALL`].
    told: Vec<Told>,
}

impl Trial for SensationsTrial {
    type Setting = ();
    type Measurement = SensationsMeasurement;
    type Summary = SensationsSummary;

    fn set_up(_subject: &Subject) -> Result<(), ExperimentError> {
        Ok(())
    }

    fn run(subject: &Subject, (): &(), seed: u64) -> Result<SensationsTrial, ExperimentError> {
        subject.tell(seed, "touching");
        let stage = subject.stage_with(&["probe", "second probe"])?;
        let (mut measurements, mut all_told) = (Vec::new(), Vec::new());
        for (k, doing) in Doing::ALL.into_iter().enumerate() {
            let mut told = Told::default();
            match touched(&stage, doing, seed, k as u64)? {
                Some((done, trial, redrawn)) => {
                    told.redrawn += redrawn;
                    told.take(&stage, doing, seed, (&done, &trial, redrawn), &mut measurements);
                }
                None => {
                    if let Doing::One(kind) = doing {
                        let name = kind.name();
                        return Err(ExperimentError::Refused(format!(
                            "no limb of this creature has room for a {name}"
                        )));
                    }
                    told.given_up += 1;
                }
            }
            all_told.push(told);
        }
        Ok(SensationsTrial { measurements, told: all_told })
    }

    fn findings(
        _subject: &Subject,
        trials: &[SensationsTrial],
    ) -> Findings<SensationsMeasurement, SensationsSummary> {
        let mut told: Vec<Told> = Doing::ALL.iter().map(|_| Told::default()).collect();
        for trial in trials {
            told.iter_mut().zip(&trial.told).for_each(|(all, told)| all.add(told));
        }
        findings(trials.iter().flat_map(|trial| trial.measurements.clone()).collect(), &told)
    }
}

/// Touches by probes that did what they were to do, what they did, and how often it was drawn again; none where no draw
/// was like that. What is done to one limb is never drawn again.
fn touched(
    stage: &Stage,
    doing: Doing,
    seed: u64,
    stream: u64,
) -> Result<Option<(Vec<Stimulation>, TouchedTrial, u64)>, ExperimentError> {
    for redrawn in 0..DRAWS {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        rng.set_stream(stream + Doing::ALL.len() as u64 * redrawn);
        let Some(done) = doing.draw(stage, &mut rng) else { return Ok(None) };
        let found = touch(stage, &done, doing == Doing::Two { one_party: true })?;
        let as_meant = found.truly.iter().zip(&done).all(|(truly, done)| truly.is(done));
        if as_meant || matches!(doing, Doing::One(_)) {
            return Ok(Some((done, found, redrawn)));
        }
    }
    Ok(None)
}

/// Whether a sensation is of what was done, by its kind and by where it began and ended.
fn agrees(done: &Stimulation, felt: &Sensation) -> [bool; 2] {
    let ends = [felt.sides[0].limb, felt.sides[0].last_limb];
    [felt.kind == done.kind, ends == [done.limbs[0], done.limbs[done.limbs.len() - 1]]]
}

impl Told {
    /// Counts what came of it in another trial as well.
    fn add(&mut self, other: &Told) {
        self.kinds.iter_mut().zip(other.kinds).for_each(|(count, more)| *count += more);
        self.touches += other.touches;
        self.trials += other.trials;
        self.kind += other.kind;
        self.limbs += other.limbs;
        self.alone += other.alone;
        self.right += other.right;
        self.latencies.extend(&other.latencies);
        self.redrawn += other.redrawn;
        self.given_up += other.given_up;
    }

    fn take(
        &mut self,
        stage: &Stage,
        doing: Doing,
        seed: u64,
        (done, trial, redrawn): (&[Stimulation], &TouchedTrial, u64),
        measurements: &mut Vec<SensationsMeasurement>,
    ) {
        let name = |limb: usize| stage.agent().creature().limbs()[limb].clone();
        let mut left: Vec<&(Sensation, f64)> = trial.felt.iter().collect();
        let alone = trial.felt.len() == done.len();
        let mut all_right = alone;
        let two = matches!(doing, Doing::Two { .. });
        for (done, truly) in done.iter().zip(&trial.truly) {
            // Of several of its party, the one that is most like it is taken for it, and of these the one that lasted
            // longest.
            let like = |(felt, _): &(Sensation, f64)| {
                let alike = agrees(done, felt).iter().filter(|yes| **yes).count();
                (if two { alike } else { 0 }, felt.ended - felt.began)
            };
            let order = |a: &(usize, f64), b: &(usize, f64)| a.0.cmp(&b.0).then(a.1.total_cmp(&b.1));
            let own = (0..left.len()).filter(|&k| left[k].0.by == truly.party);
            let best = own.max_by(|&a, &b| order(&like(left[a]), &like(left[b])));
            let felt = best.map(|best| left.remove(best));
            let [kind, limbs] = felt.map_or([false; 2], |(felt, _)| agrees(done, felt));
            all_right &= kind && limbs;
            self.touches += 1;
            self.kind += usize::from(kind);
            self.limbs += usize::from(limbs);
            let told = TouchKind::ALL.iter().position(|kind| Some(*kind) == felt.map(|(felt, _)| felt.kind));
            self.kinds[told.unwrap_or(4)] += 1;
            let last = truly.span.map(|span| span[1]);
            let latency = felt.zip(last).map(|((_, decided), last)| decided - last);
            // Which of two of one party a sensation is of is a guess.
            self.latencies.extend(latency.filter(|_| !two));
            let side = felt.map(|(felt, _)| &felt.sides[0]);
            measurements.push(SensationsMeasurement {
                done: doing.name().into(),
                seed,
                kind: done.kind.name().into(),
                limb: name(done.limbs[0]),
                last_limb: name(done.limbs[done.limbs.len() - 1]),
                force_n: done.force,
                told: felt.map_or("nothing", |(felt, _)| felt.kind.name()).into(),
                told_limb: side.map_or("none".into(), |side| name(side.limb)),
                told_last_limb: side.map_or("none".into(), |side| name(side.last_limb)),
                peak_force_n: felt.map_or(f64::NAN, |(felt, _)| felt.peak_force),
                duration_s: felt.map_or(f64::NAN, |(felt, _)| felt.ended - felt.began),
                latency_s: latency.unwrap_or(f64::NAN),
                sensations: trial.felt.len(),
                redrawn,
                right: kind && limbs && alone,
            });
        }
        self.trials += 1;
        self.alone += usize::from(alone);
        self.right += usize::from(all_right);
    }
}

/// What the trials say.
fn findings(
    measurements: Vec<SensationsMeasurement>,
    told: &[Told],
) -> Findings<SensationsMeasurement, SensationsSummary> {
    let share = |count: usize, of: usize| count as f64 / of.max(1) as f64;
    let all = || Doing::ALL.iter().zip(told);
    let done = || all().filter(|(_, told)| told.trials > 0);
    let summary = done().map(|(doing, told)| {
        let [tap, press, stroke, rub, nothing] = told.kinds;
        SensationsSummary {
            done: doing.name().into(),
            touches: told.touches,
            tap,
            press,
            stroke,
            rub,
            nothing,
            kind: share(told.kind, told.touches),
            limbs: share(told.limbs, told.touches),
            alone: share(told.alone, told.trials),
            right: share(told.right, told.trials),
        }
    });
    let summary: Vec<SensationsSummary> = summary.collect();
    let one = || done().filter(|(doing, _)| matches!(doing, Doing::One(_)));
    let of_one = |count: fn(&Told) -> usize| {
        share(one().map(|(_, told)| count(told)).sum(), one().map(|(_, told)| told.touches).sum())
    };
    let slowest = done().flat_map(|(_, told)| &told.latencies).copied().fold(0.0, f64::max);
    let redrawn: u64 = told.iter().map(|told| told.redrawn).sum();
    let mut notes = vec![
        "A row is what was done, a column what the touch sensor said of it; right is a trial of which it told one sensation \
         for each touch, of the right kind, and the limbs where it began and ended."
            .to_string(),
        format!(
            "On one limb right kind {:.3}, right limb {:.3}; all decided at most {:.0} ms after the last contact.",
            of_one(|told| told.kind),
            of_one(|told| told.limbs),
            1e3 * slowest
        ),
        format!("Drawn again, because a probe left the skin on its way or met another: {redrawn} times."),
    ];
    for (doing, told) in all().filter(|(_, told)| told.given_up > 0) {
        notes.push(format!("No room for a {} in {} trials.", doing.name(), told.given_up));
    }
    let names = TouchKind::ALL.iter().map(|kind| kind.name()).chain(["nothing"]);
    let row = |counts: &[usize; 5]| -> Map<String, Value> {
        names.clone().zip(counts).map(|(name, count)| (name.to_string(), json!(count))).collect()
    };
    let table: Map<String, Value> =
        done().map(|(doing, told)| (doing.name().to_string(), row(&told.kinds).into())).collect();
    let right: Map<String, Value> = done()
        .map(|(doing, told)| (doing.name().to_string(), json!(share(told.right, told.trials))))
        .collect();
    let numbers = vec![
        ("accuracy", json!(of_one(|told| told.kind))),
        ("limb_accuracy", json!(of_one(|told| told.limbs))),
        ("right", right.into()),
        ("confusion", table.into()),
        ("redrawn", json!(redrawn)),
        ("latency_s", json!(slowest)),
    ];
    let series = done().enumerate().map(|(k, (doing, told))| PlotSeries {
        name: doing.name().to_string(),
        line: Vec::new(),
        dots: told.latencies.iter().map(|latency| (1e3 * latency, k as f64)).collect(),
    });
    let plot = StudyPlot {
        x: PlotAxis { title: "decided after the last contact, ms", scale: AxisScale::Logarithmic },
        y: PlotAxis {
            title: "",
            scale: AxisScale::Names(done().map(|(doing, _)| doing.name().into()).collect()),
        },
        series: series.collect(),
    };
    Findings { measurements, summary, notes, plot, numbers }
}
