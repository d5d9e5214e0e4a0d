//! What each learner makes of bodies that nobody designed: a benchmark of generated bodies, and the widest test that the
//! learners get.
//!
//! A trial is a seed: the body that it makes, the touches of that body, and what each way to learn comes to with them. A body
//! that fails in some way is a row that says so. No trial depends on another one.

mod trial;

pub use trial::{BodiesOptions, BodyTrial, WAYS, WayTrial, trial};

use serde_json::json;

use super::claims::{DEVIATIONS, NEGLIGIBLE_MM};
use super::plot::{AxisScale, PlotAxis, PlotSeries, StudyPlot};
use super::subject::median;
use super::table::{WallTime, row};
use super::{Findings, Study, Subject, Trial, Trials};
use crate::experiment::ExperimentError;
use crate::experiment::bodies::Family;

/// The study `bodies`.
pub const STUDY: Study = Study {
    name: "bodies",
    about: "what each learner reaches on bodies that are drawn at random, and whether anything is claimed wrongly",
    touches: true,
    several: false,
    trials: Trials::of::<BodyTrial>(),
};

/// A program that asks by a subject has its touches and its seeds: the bodies are those of the seeds.
impl Trial for BodyTrial {
    type Setting = BodiesOptions;
    type Measurement = BodiesMeasurement;
    type Summary = BodiesSummary;

    fn set_up(subject: &Subject) -> Result<BodiesOptions, ExperimentError> {
        Ok(BodiesOptions { touches: subject.touches, ..BodiesOptions::default() })
    }

    fn run(subject: &Subject, options: &BodiesOptions, seed: u64) -> Result<BodyTrial, ExperimentError> {
        subject.tell(seed, "babbling and learning");
        Ok(trial(seed, options))
    }

    fn findings(_: &Subject, trials: &[BodyTrial]) -> Findings<BodiesMeasurement, BodiesSummary> {
        findings(trials)
    }
}

/// Skin that is off by no more than this share of the typical limb's length is right: what acts with it would hardly notice.
const RIGHT: f64 = 0.01;
/// A body is learned by the truth's measure where this share of its held-out points is right.
const WHOLE: f64 = 0.95;

/// How it went, in words.
pub mod outcome {
    /// All is claimed.
    pub const LEARNED: &str = "learned";
    /// Some is claimed, the rest is named.
    pub const EXCEPT: &str = "learned except";
    /// The learner says that it did not learn the body.
    pub const NOT: &str = "not learned";
    /// The learner makes no judgement.
    pub const UNJUDGED: &str = "not judged";
    /// No touch came about.
    pub const UNTOUCHED: &str = "touched nothing";
    /// The program refuses the body.
    pub const REFUSED: &str = "refused";
    /// A panic, which is a defect of the program.
    pub const PANICKED: &str = "panicked";
}

row! {
    /// A measurement of the study `bodies`: one way to learn one body.
    pub struct BodiesMeasurement {
        seed: u64 = "seed",
        family: String = "family",
        limb_m: f64 = "limb, m",
        limbs: usize = "limbs",
        dof: usize = "degrees of freedom",
        hinges: usize = "hinges",
        slides: usize = "slides",
        balls: usize = "balls",
        locked: usize = "as good as locked",
        spins: usize = "along limbs",
        followers: usize = "followers",
        skew: f64 = "skew",
        way: String = "way",
        policy: String = "policy and learner",
        touches: usize = "touches",
        outcome: String = "outcome",
        late: bool = "late",
        joints: usize = "joints",
        joints_named: usize = "joints named",
        heldout_mm: f64 = "held-out, mm",
        worst_heldout_mm: f64 = "worst, mm",
        heldout_percent: f64 = "held-out, % of a limb",
        right: f64 = "right points, share",
        pairs: usize = "pairs of limbs",
        claims: usize = "claims",
        wrong: usize = "wrong",
        worst_mm: f64 = "worst claim, mm",
        worst_deviations: f64 = "its deviations",
        seconds: WallTime = "processor seconds",
        reason: String = "reason",
        command: String = "command",
    }
}

row! {
    /// A row of the summary of the study `bodies`: one way to learn the bodies of one family, or all.
    pub struct BodiesSummary {
        way: String = "way",
        family: String = "family",
        bodies: usize = "bodies",
        untouched: usize = "touched nothing",
        refused: usize = "refused",
        whole: usize = "right",
        right: f64 = "right points",
        learned: usize = "learned",
        learned_except: usize = "except",
        not_learned: usize = "not",
        honest: usize = "not right and said so",
        late: usize = "late",
        claimed: f64 = "pairs claimed",
        claims: usize = "claims",
        wrong: usize = "wrong",
        wrong_bodies: usize = "wrong bodies",
        heldout_percent: f64 = "held-out, % of a limb",
        seconds: WallTime = "processor seconds",
    }
}

/// What the trials show, in whatever order and from however many processes they come.
pub fn findings(trials: &[BodyTrial]) -> Findings<BodiesMeasurement, BodiesSummary> {
    let measurements: Vec<BodiesMeasurement> = trials.iter().flat_map(measurements).collect();
    let mut summary = Vec::new();
    for way in WAYS {
        let of_way: Vec<&BodiesMeasurement> = measurements.iter().filter(|one| one.way == way).collect();
        if of_way.is_empty() {
            continue;
        }
        summary.push(summarize(way, "all", &of_way));
        for family in Family::ALL {
            let of_family: Vec<&BodiesMeasurement> =
                of_way.iter().copied().filter(|one| one.family == family.name()).collect();
            if !of_family.is_empty() {
                summary.push(summarize(way, family.name(), &of_family));
            }
        }
    }
    let wrong = || measurements.iter().filter(|one| one.wrong > 0);
    let mut notes = vec![
        format!(
            "right: bodies of which {:.0} % of all held-out points are off by no more than {:.0} % of the typical limb's length, \
             whatever the learner says; right points: their share over all bodies. learned, except, not: what the learner says; \
             gradient and hersch make no judgement, and claim nothing. not right \
             and said so: nothing of what is wrong is claimed.",
            1e2 * WHOLE,
            1e2 * RIGHT
        ),
        format!(
            "A claim is that skin of two limbs is placed in each other's frames. It is wrong where held-out skin is off by more \
             than {NEGLIGIBLE_MM} mm, on bodies much smaller or larger than a person by more than its share, and {DEVIATIONS} of its own \
             standard deviations."
        ),
        "default: as `bodyschema babble BODY` learns, by stages and growth where that suits the body; the others learn from the \
         same touches at random. late: the work that a way may take with a body was spent before all was done. Medians of held-out errors and seconds."
            .to_string(),
    ];
    notes.extend(wrong().map(|one| {
        let BodiesMeasurement { way, wrong, claims, worst_mm, command, .. } = one;
        format!("{command}   # {way}: {wrong} of {claims} claims wrong, by up to {worst_mm:.3} mm")
    }));
    let panicked = measurements.iter().filter(|one| one.outcome == outcome::PANICKED);
    notes.extend(panicked.map(|one| format!("{}   # {}: panicked: {}", one.command, one.way, one.reason)));
    let dots = |way: &str| {
        let own = measurements.iter().filter(|one| one.way == way);
        own.map(|one| (one.limb_m, one.heldout_percent)).collect()
    };
    let plot = StudyPlot {
        x: PlotAxis { title: "typical length of a limb, m", scale: AxisScale::Logarithmic },
        y: PlotAxis { title: "mean held-out error, % of a limb", scale: AxisScale::Logarithmic },
        series: WAYS
            .map(|way| PlotSeries { name: way.into(), line: Vec::new(), dots: dots(way) })
            .into_iter()
            .collect(),
    };
    let numbers = vec![
        ("bodies", json!(trials.len())),
        ("wrong_claims", json!(measurements.iter().map(|one| one.wrong).sum::<usize>())),
        (
            "wrong_bodies",
            json!(trials.iter().filter(|one| one.ways.iter().any(|way| way.claims[1] > 0)).count()),
        ),
    ];
    Findings { measurements, summary, notes, plot, numbers }
}

/// The rows of a trial.
fn measurements(trial: &BodyTrial) -> impl Iterator<Item = BodiesMeasurement> {
    let BodyTrial { seed, drawn, .. } = trial;
    trial.ways.iter().zip(&trial.seconds).map(move |(way, &seconds)| {
        let [mean, greatest] = way.error_mm.unwrap_or([f64::NAN; 2]);
        BodiesMeasurement {
            seed: *seed,
            family: drawn.family.clone(),
            limb_m: drawn.length,
            limbs: drawn.limbs,
            dof: drawn.dof,
            hinges: drawn.hinges,
            slides: drawn.slides,
            balls: drawn.balls,
            locked: drawn.locked,
            spins: drawn.spins,
            followers: drawn.followers,
            skew: drawn.skew,
            way: way.way.clone(),
            policy: way.policy.clone(),
            touches: way.touches,
            outcome: way.outcome.clone(),
            late: way.late,
            joints: way.joints[0],
            joints_named: way.joints[1],
            heldout_mm: mean,
            worst_heldout_mm: greatest,
            heldout_percent: 0.1 * mean / drawn.length,
            right: way.right,
            pairs: way.pairs,
            claims: way.claims[0],
            wrong: way.claims[1],
            worst_mm: way.worst[0].unwrap_or(f64::NAN),
            worst_deviations: way.worst[1].unwrap_or(f64::NAN),
            seconds: WallTime(seconds),
            reason: way.reason.clone(),
            command: command(*seed, way),
        }
    })
}

/// The command line that makes a session like a row's.
fn command(seed: u64, way: &WayTrial) -> String {
    let babble = match way.policy.split_once(", ") {
        Some(("random", learner)) => {
            format!(" --policy random --learner {learner} --touches {}", way.touches)
        }
        _ => String::new(),
    };
    format!(
        "bodyschema generate --seed {seed} --out body-{seed}.xml && bodyschema babble body-{seed}.xml --seed {seed}{babble}"
    )
}

fn summarize(way: &str, family: &str, rows: &[&BodiesMeasurement]) -> BodiesSummary {
    let count = |holds: &dyn Fn(&BodiesMeasurement) -> bool| rows.iter().filter(|one| holds(one)).count();
    let sum = |value: fn(&BodiesMeasurement) -> usize| rows.iter().map(|one| value(one)).sum::<usize>();
    let was = |outcome: &'static str| count(&|one| one.outcome == outcome);
    let right = rows.iter().map(|one| one.right).sum::<f64>() / rows.len() as f64;
    BodiesSummary {
        way: way.into(),
        family: family.into(),
        bodies: rows.len(),
        untouched: was(outcome::UNTOUCHED),
        refused: was(outcome::REFUSED) + was(outcome::PANICKED),
        whole: count(&|one| one.right >= WHOLE),
        right,
        learned: was(outcome::LEARNED),
        learned_except: was(outcome::EXCEPT),
        not_learned: was(outcome::NOT),
        honest: count(&|one| {
            let said = [outcome::LEARNED, outcome::EXCEPT, outcome::NOT].contains(&one.outcome.as_str());
            said && one.wrong == 0 && one.right < WHOLE
        }),
        late: count(&|one| one.late),
        claimed: sum(|one| one.claims) as f64 / sum(|one| one.pairs) as f64,
        claims: sum(|one| one.claims),
        wrong: sum(|one| one.wrong),
        wrong_bodies: count(&|one| one.wrong > 0),
        heldout_percent: median(rows.iter().map(|one| one.heldout_percent).filter(|error| error.is_finite())),
        seconds: WallTime(median(rows.iter().map(|one| one.seconds.0))),
    }
}
