//! Whether he notices, while he acts, that a limb of his has grown or become shorter, and learns it anew.

use nalgebra::{Point3, Vector3};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use serde::{Deserialize, Serialize};
use serde_json::json;

use super::at_table::{Knowledge, OnStage, at_table};
use super::plot::{AxisScale, PlotAxis, PlotSeries, StudyPlot};
use super::subject::{Subject, median, share};
use super::table::row;
use super::{Findings, Study, Trial, Trials};
use crate::experiment::ExperimentError;
use crate::interaction::{FeltOver, Trouble};

/// The study `grown`.
pub const STUDY: Study = Study {
    name: "grown",
    about: "whether he notices while he acts that a limb has grown, and learns it anew by feeling himself over",
    touches: true,
    several: false,
    trials: Trials::of::<GrownTrial>(),
};

/// How much a limb grows or becomes shorter, metres; one of so many trials leaves the body as it is.
const GROWTH: [f64; 2] = [0.01, 0.05];
const UNCHANGED: u32 = 4;
/// How often he is asked to touch himself somewhere before he is told to feel himself over.
const ASKED: usize = 6;
/// Postures in which it is measured how far off his hands are.
const POSTURES: usize = 60;

row! {
    /// A measurement of the study `grown`: a limb that grew.
    pub struct GrownMeasurement {
        seed: u64 = "seed",
        limb: String = "limb",
        grown_mm: f64 = "grown by, mm",
        noticed_after: usize = "noticed at the touch",
        found: String = "found",
        touches: usize = "self-touches",
        joints: String = "joints told, mm",
        before_mm: f64 = "hands off before, mm",
        after_mm: f64 = "hands off after, mm",
    }
}

row! {
    /// The summary of the study `grown`.
    pub struct GrownSummary {
        case: String = "case",
        trials: usize = "trials",
        noticed: f64 = "noticed",
        changed: f64 = "found changed",
        same: f64 = "found the same",
        unexplained: f64 = "not explained",
        touches: f64 = "self-touches",
        before_mm: f64 = "hands off before, mm",
        after_mm: f64 = "after, where found changed, mm",
        worst_mm: f64 = "at the most, mm",
    }
}

/// The measurement of one trial.
#[derive(Debug, Serialize, Deserialize)]
pub struct GrownTrial(GrownMeasurement);

impl Trial for GrownTrial {
    type Setting = Knowledge;
    type Measurement = GrownMeasurement;
    type Summary = GrownSummary;

    fn set_up(subject: &Subject) -> Result<Knowledge, ExperimentError> {
        Knowledge::learned(subject)
    }

    fn run(subject: &Subject, learned: &Knowledge, seed: u64) -> Result<GrownTrial, ExperimentError> {
        subject.tell(seed, "growing");
        Ok(GrownTrial(trial(subject, learned, seed)?))
    }

    fn findings(_subject: &Subject, trials: &[GrownTrial]) -> Findings<GrownMeasurement, GrownSummary> {
        findings(trials.iter().map(|trial| trial.0.clone()).collect())
    }
}

fn findings(measurements: Vec<GrownMeasurement>) -> Findings<GrownMeasurement, GrownSummary> {
    let cases = [("grown", true), ("as it was", false)];
    let of_case = |grown: bool| measurements.iter().filter(move |row| (row.grown_mm != 0.0) == grown);
    let summary: Vec<GrownSummary> = cases
        .into_iter()
        .map(|(case, grown)| {
            let found = |what: &str| share(of_case(grown).map(|row| row.found == what));
            let after = || of_case(grown).filter(|row| row.found == CHANGED).map(|row| row.after_mm);
            GrownSummary {
                case: case.into(),
                trials: of_case(grown).count(),
                noticed: share(of_case(grown).map(|row| row.noticed_after > 0)),
                changed: found(CHANGED),
                same: found(SAME),
                unexplained: found(UNEXPLAINED) + found(TOO_FEW),
                touches: median(of_case(grown).map(|row| row.touches as f64)),
                before_mm: median(of_case(grown).map(|row| row.before_mm)),
                after_mm: median(after()),
                worst_mm: after().fold(f64::NAN, f64::max),
            }
        })
        .collect();
    let notes = vec![format!(
        "The joint that moves a limb of an arm is put 1 to 5 cm farther out on the limb that carries it, or as much nearer; one trial in \
             {UNCHANGED} leaves the body as it is. noticed: one of {ASKED} touches of himself that he was asked for was not where he \
             expected it. hands off: of the tips of both hands in the root's frame, the most in {POSTURES} random postures."
    )];
    let numbers = vec![
        ("noticed", json!(summary[0].noticed)),
        ("found_changed", json!(summary[0].changed)),
        ("after_mm", json!(summary[0].after_mm)),
        ("worst_mm", json!(summary[0].worst_mm)),
        ("same_as_it_was", json!(summary[1].same)),
    ];
    let series = [("before", 0), ("after", 1)].map(|(name, at)| PlotSeries {
        name: name.into(),
        line: Vec::new(),
        dots: of_case(true)
            .map(|row| (if at == 0 { row.before_mm } else { row.after_mm }, f64::from(at)))
            .collect(),
    });
    let plot = StudyPlot {
        x: PlotAxis { title: "hands off, mm", scale: AxisScale::Logarithmic },
        y: PlotAxis { title: "", scale: AxisScale::Names(vec!["before".into(), "after".into()]) },
        series: series.into(),
    };
    Findings { measurements, summary, notes, plot, numbers }
}

const CHANGED: &str = "changed";
const SAME: &str = "the same";
const UNEXPLAINED: &str = "unexplained";
const TOO_FEW: &str = "too few touches";

/// A limb grows, he is asked to touch himself here and there, then to feel himself over.
fn trial(subject: &Subject, own: &Knowledge, seed: u64) -> Result<GrownMeasurement, ExperimentError> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let mut actor = at_table(subject, own, &[], seed)?;
    let height = actor.table_top();
    actor.know_table(height);
    let joint = {
        let joints = actor.arms();
        joints[rng.random_range(0..joints.len())]
    };
    let sign = if rng.random_bool(0.5) { 1.0 } else { -1.0 };
    let length = sign * rng.random_range(GROWTH[0]..GROWTH[1]);
    let length = if rng.random_ratio(1, UNCHANGED) { 0.0 } else { length };
    if length != 0.0 {
        actor.stage.grow_limb(joint + 1, length)?;
    }
    let postures: Vec<_> = {
        let joints: Vec<usize> = actor.hands.iter().flat_map(|hand| hand.leaning.clone()).collect();
        let base = actor.own.at_ease();
        (0..POSTURES).map(|_| actor.own.random_posture(&base, &joints, &mut rng)).collect()
    };
    let receptors = actor.own.skin().receptors.len();
    let mut noticed_after = 0;
    for k in 1..=ASKED {
        let ready = actor.ready();
        // Where he cannot, he begins from where he is, or touches nothing.
        if let Err(Trouble::Engine(error)) = actor.go(&ready) {
            return Err(error.into());
        }
        if let Err(Trouble::Engine(error)) = actor.touch_own(rng.random_range(0..receptors)) {
            return Err(error.into());
        }
        if actor.take_unexpected().is_some() {
            noticed_after = k;
            break;
        }
    }
    let before_mm = hands_off(&mut actor, &postures)?;
    let found = match actor.feel_over() {
        Err(Trouble::Engine(error)) => return Err(error.into()),
        found => found,
    };
    let after_mm = hands_off(&mut actor, &postures)?;
    let (found, touches, joints) = match found {
        Ok(FeltOver::Same { touches }) => (SAME, touches, Vec::new()),
        Ok(FeltOver::Changed { touches, joints }) => (CHANGED, touches, joints),
        Ok(FeltOver::Unexplained { touches }) => (UNEXPLAINED, touches, Vec::new()),
        Ok(FeltOver::TooFew { touches }) => (TOO_FEW, touches, Vec::new()),
        Err(_) => ("trouble on the way", 0, Vec::new()),
    };
    let names = actor.own.creature().joints();
    let told: Vec<String> =
        joints.iter().map(|(joint, far)| format!("{} {:.2}", names[*joint].name, 1e3 * far)).collect();
    Ok(GrownMeasurement {
        seed,
        limb: actor.own.creature().limbs()[joint + 1].clone(),
        grown_mm: 1e3 * length,
        noticed_after,
        found: found.into(),
        touches,
        joints: told.join(", "),
        before_mm,
        after_mm,
    })
}

/// How far off he has the tips of his hands at the most in some postures, millimetres.
fn hands_off(actor: &mut OnStage, postures: &[crate::creature::Posture]) -> Result<f64, ExperimentError> {
    let now = actor.posture();
    let mut most: f64 = 0.0;
    for posture in postures {
        actor.stage.place(posture)?;
        let frames = actor.own.frames(posture);
        for hand in &actor.hands {
            let place = actor.own.place(hand.tip);
            let truly = actor.stage.limb_pose(place.limb) * Point3::from(place.point);
            let truly: Vector3<f64> = actor.stage.root_pose().inverse_transform_point(&truly).coords;
            most = most.max((frames[place.limb].point(&place.point) - truly).norm());
        }
    }
    actor.stage.place(&now)?;
    Ok(1e3 * most)
}
