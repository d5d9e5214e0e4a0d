//! How far away a creature puts what it holds, against how far it truly could.

use nalgebra::{Isometry3, Translation3, Vector3};
use rand::RngExt;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use serde::{Deserialize, Serialize};
use serde_json::json;

use super::at_table::{Knowledge, KnownBodies, OnStage, TOP, at_table, on_table, shape};
use super::exhaustive_reach::GripProblem;
use super::plot::{AxisScale, PlotAxis, PlotSeries, StudyPlot};
use super::subject::{Subject, median, share};
use super::table::row;
use super::{Findings, Study, Trial, Trials};
use crate::experiment::ExperimentError;
use crate::interaction::Trouble;
use crate::kinematics::Place;
use crate::simulation::Stage;

/// The study `farthest`.
pub const STUDY: Study = Study {
    name: "farthest",
    about: "how far away it puts what it holds, of what is truly possible, with and without leaning",
    touches: true,
    several: false,
    trials: Trials::of::<FarthestTrial>(),
};

/// Draws of a thing until there is one that a hand finds and holds.
const DRAWS: usize = 20;
/// How much effort the creature makes.
const EFFORT: usize = 3;
/// Runs of the exhaustive search, upright and leaning.
const RUNS: [usize; 2] = [2, 6];
/// A reach of at least this share of the maximum counts as the farthest.
const FARTHEST: f64 = 0.97;
/// What is farther from where it was to be than this, metres, is not put there …
const OFF: f64 = 0.03;
/// … and what is tilted by more, degrees, fell over.
const FELL: f64 = 30.0;
/// What is lower than the table by this, metres, fell off it.
const BELOW: f64 = 0.01;

row! {
    /// A measurement of the study `farthest`.
    pub struct FarthestMeasurement {
        seed: u64 = "seed",
        leaning: bool = "leaning",
        forward_m: f64 = "reached, m",
        true_schema_forward_m: f64 = "reached by the true schema, m",
        true_maximum_m: f64 = "true maximum, m",
        searched_m: f64 = "maximum by the search, m",
        half_search_m: f64 = "maximum by half the search, m",
        bound_m: f64 = "no farther than, m",
        ratio: f64 = "ratio",
        put: bool = "put",
        off_mm: f64 = "off, mm",
        tilt_deg: f64 = "tilt, °",
        moved_m: f64 = "moved, m",
        result: String = "result",
    }
}

row! {
    /// A row of the summary of the study `farthest`.
    pub struct FarthestSummary {
        leaning: bool = "leaning",
        trials: usize = "trials",
        put: f64 = "put, share",
        forward_m: f64 = "reached, m",
        true_schema_forward_m: f64 = "by the true schema, m",
        true_maximum_m: f64 = "true maximum, m",
        bound_m: f64 = "no farther than, m",
        ratio: f64 = "ratio, median",
        least: f64 = "ratio, least",
        farthest: f64 = "at least 97 %, share",
        off_mm: f64 = "off, mm",
        tilt_deg: f64 = "tilt, °",
    }
}

/// What came of one trial.
#[derive(Debug, Default, Serialize, Deserialize)]
pub struct FarthestTrial {
    /// Upright and leaning, where a thing was held.
    measurements: Vec<FarthestMeasurement>,
    /// Postures that the exhaustive search looked at.
    looked_at: usize,
    /// How often no thing was held.
    not_held: usize,
}

impl Trial for FarthestTrial {
    type Setting = KnownBodies;
    type Measurement = FarthestMeasurement;
    type Summary = FarthestSummary;

    fn set_up(subject: &Subject) -> Result<KnownBodies, ExperimentError> {
        KnownBodies::of(subject)
    }

    fn run(subject: &Subject, bodies: &KnownBodies, seed: u64) -> Result<FarthestTrial, ExperimentError> {
        subject.tell(seed, "holding");
        let mut trial = FarthestTrial::default();
        for lean in [false, true] {
            let mut rng = ChaCha8Rng::seed_from_u64(seed);
            let mut held = None;
            for _ in 0..DRAWS {
                held = hold(subject, &bodies.learned, seed, &mut rng)?;
                if held.is_some() {
                    break;
                }
            }
            let Some((actor, receptor)) = held else {
                trial.not_held += 1;
                continue;
            };
            let Some(hand) = actor.arm_of(receptor) else { continue };
            let (row, looked_at) = place(bodies, actor, [hand, receptor], lean, seed, &mut rng)?;
            trial.looked_at += looked_at;
            trial.measurements.push(row);
        }
        Ok(trial)
    }

    fn findings(
        _subject: &Subject,
        trials: &[FarthestTrial],
    ) -> Findings<FarthestMeasurement, FarthestSummary> {
        findings(trials)
    }
}

/// Lets a creature put what it holds with a receptor of a hand as far away as it can; how far that is, and how many
/// postures were looked at to say how far it truly could have been.
fn place(
    bodies: &KnownBodies,
    mut actor: OnStage,
    [hand, receptor]: [usize; 2],
    lean: bool,
    seed: u64,
    rng: &mut ChaCha8Rng,
) -> Result<(FarthestMeasurement, usize), ExperimentError> {
    let KnownBodies { learned, truth } = bodies;
    if lean && let Err(Trouble::Engine(error)) = actor.make_way_to_lean(receptor, EFFORT) {
        return Err(error.into());
    }
    let limb = actor.own.place(receptor).limb;
    let upright = actor.frames()[limb].rotation.tr_mul(&actor.up);
    let height = actor.feels_at(receptor).0.dot(&actor.up);
    let spot = actor.farthest(receptor, height, upright, lean, EFFORT);
    // The same question to the same search with the true kinematics, …
    actor.own = truth.own.clone();
    let by_truth = actor.farthest(receptor, height, upright, lean, EFFORT);
    // … and to another one that takes its time, as if the arm that is idle were out of the way.
    let place = Place { direction: upright, ..truth.own.place(receptor) };
    let (up, front) = (actor.up, actor.front);
    let joints = actor.hands[hand].joints(lean).to_vec();
    let idle = truth.own.moved_by(&actor.hands[1 - hand].arm);
    let clearance = actor.clearance.moved_by(&truth.own, &joints).without(&idle);
    let from = actor.posture();
    let problem = GripProblem { own: &truth.own, clearance, joints: &joints, place, up, front, height, from };
    let maximum = problem.search(RUNS[usize::from(lean)], rng);
    let bound = problem.upper_bound().unwrap_or(f64::NAN);
    actor.own = learned.own.clone();
    let forward = |posture: &[f64]| truth.own.frames(posture)[limb].point(&place.point).dot(&front);
    // Without a spot nothing is reached.
    let reached = spot.as_ref().map_or(0.0, |spot| forward(&spot.posture));
    let by_truth = by_truth.map_or(0.0, |spot| forward(&spot.posture));
    // What any of them found can be.
    let best = [reached, by_truth].into_iter().fold(maximum.forward, f64::max);
    let thing = actor.the_thing()?;
    let before = actor.stage.thing_pose(thing);
    let (mut told, mut off, mut tilt, mut put) = ("there is no way".to_string(), f64::NAN, 0.0, false);
    if let Some(spot) = &spot {
        // Where the thing is to be, rigidly in the hand.
        let grip = actor.stage.limb_pose(limb).inv_mul(&before);
        let at_spot = truth.own.frames(&spot.posture)[limb];
        let in_root = Isometry3::from_parts(Translation3::from(at_spot.origin), at_spot.quaternion());
        let wanted = actor.stage.root_pose() * in_root * grip;
        let result = actor.put(receptor, spot, lean);
        let after = actor.stage.thing_pose(thing);
        off = (after.translation.vector - wanted.translation.vector).xy().norm();
        tilt = tilted(&before, &after);
        let stands = stands(&actor.stage, thing);
        put = result.is_ok() && stands && off <= OFF && tilt <= FELL;
        told = match result {
            Err(Trouble::Engine(error)) => return Err(error.into()),
            Err(trouble) => trouble.to_string(),
            Ok(_) if put => "put".into(),
            Ok(_) if !stands => "it fell off the table".into(),
            Ok(_) if tilt > FELL => "it fell over".into(),
            Ok(_) => "it is not where it was to be".into(),
        };
    }
    let moved = actor.stage.thing_pose(thing).translation.vector - before.translation.vector;
    let row = FarthestMeasurement {
        seed,
        leaning: lean,
        forward_m: reached,
        true_schema_forward_m: by_truth,
        true_maximum_m: best,
        searched_m: maximum.forward,
        half_search_m: maximum.half,
        bound_m: bound,
        ratio: reached / best,
        put,
        off_mm: 1e3 * off,
        tilt_deg: tilt,
        moved_m: moved.norm(),
        result: told,
    };
    Ok((row, maximum.looked_at))
}

fn findings(trials: &[FarthestTrial]) -> Findings<FarthestMeasurement, FarthestSummary> {
    let measurements: Vec<FarthestMeasurement> =
        trials.iter().flat_map(|trial| trial.measurements.clone()).collect();
    let looked_at: usize = trials.iter().map(|trial| trial.looked_at).sum();
    let not_held: usize = trials.iter().map(|trial| trial.not_held).sum();
    let of = |lean: bool| measurements.iter().filter(move |row| row.leaning == lean);
    let summary = [false, true].map(|lean| FarthestSummary {
        leaning: lean,
        trials: of(lean).count(),
        put: share(of(lean).map(|row| row.put)),
        forward_m: median(of(lean).map(|row| row.forward_m)),
        true_schema_forward_m: median(of(lean).map(|row| row.true_schema_forward_m)),
        true_maximum_m: median(of(lean).map(|row| row.true_maximum_m)),
        bound_m: median(of(lean).map(|row| row.bound_m)),
        ratio: median(of(lean).map(|row| row.ratio)),
        least: of(lean).map(|row| row.ratio).fold(f64::NAN, f64::min),
        farthest: share(of(lean).map(|row| row.ratio >= FARTHEST)),
        off_mm: median(of(lean).map(|row| row.off_mm)),
        tilt_deg: median(of(lean).map(|row| row.tilt_deg)),
    });
    // What leaning adds, trial by trial, by the creature and by the truth.
    let gains: Vec<[f64; 2]> = of(true)
        .filter_map(|leaning| {
            let upright = of(false).find(|upright| upright.seed == leaning.seed)?;
            let truly = leaning.true_maximum_m - upright.true_maximum_m;
            Some([leaning.forward_m - upright.forward_m, truly])
        })
        .collect();
    let (extends, truly) = (median(gains.iter().map(|g| g[0])), median(gains.iter().map(|g| g[1])));
    let short = |gain: &[f64; 2]| (gain[1] - gain[0]).abs();
    let within = share(gains.iter().map(|gain| short(gain) <= 0.01));
    let all = || measurements.iter();
    let grown: Vec<f64> = all().map(|row| 1e3 * (row.searched_m - row.half_search_m)).collect();
    let most = |grown: &[f64]| grown.iter().fold(0.0f64, |most, grown| most.max(*grown));
    let most_grown = most(&grown);
    let missed: Vec<f64> = all().map(|row| 1e3 * (row.true_maximum_m - row.searched_m)).collect();
    let bounded = median(all().map(|row| row.true_maximum_m / row.bound_m));
    let notes = vec![
        "Distances are of the skin that holds the thing, by the true kinematics, forward from the root's origin, at the \
         height where the thing stands. The true maximum is found by another search with the true kinematics, as if the \
         idle arm were out of the way; what is put stands within 3 cm of where the hand was to leave it."
            .to_string(),
        format!(
            "That search looked at {:.0} postures a trial; its second half raised the maximum by {:.1} mm in the median and \
             {most_grown:.1} at most; the creature's own was farther in {:.0} % of the trials, by {:.1} mm at most, and then \
             counts. It is {:.1} % of what no posture exceeds, where limbs may be in each other and in the table (median).",
            looked_at as f64 / all().count().max(1) as f64,
            median(grown.iter().copied()),
            1e2 * share(missed.iter().map(|missed| *missed > 0.1)),
            most(&missed),
            1e2 * bounded,
        ),
        format!(
            "Leaning extends the reach by {extends:.3} m; by the truth it is {truly:.3} m; within 1 cm in {:.0} % of the \
             trials, {:.1} mm at the median and {:.1} at the worst. Things that could not be held at first: {not_held}.",
            1e2 * within,
            1e3 * median(gains.iter().map(short)),
            1e3 * gains.iter().map(short).fold(0.0, f64::max),
        ),
    ];
    let least = all().map(|row| row.ratio).fold(f64::NAN, f64::min);
    let numbers = vec![
        ("ratio_of_true_maximum", json!(median(all().map(|row| row.ratio)))),
        ("least_ratio_of_true_maximum", json!(least)),
        ("success", json!(share(all().map(|row| row.put)))),
        ("leaning_extends_m", json!(extends)),
        ("leaning_truly_extends_m", json!(truly)),
        ("leaning_within_a_centimetre", json!(within)),
        ("maximum_raised_by_second_half_mm", json!(most_grown)),
        ("maximum_missed_by_search_mm", json!(most(&missed))),
        ("maximum_of_upper_bound", json!(bounded)),
    ];
    let series = [("upright", false), ("leaning", true)].map(|(name, lean)| PlotSeries {
        name: name.to_string(),
        line: Vec::new(),
        dots: of(lean).map(|row| (row.ratio, f64::from(u8::from(lean)))).collect(),
    });
    let plot = StudyPlot {
        x: PlotAxis { title: "reached, of the true maximum", scale: AxisScale::Logarithmic },
        y: PlotAxis { title: "", scale: AxisScale::Names(vec!["upright".into(), "leaning".into()]) },
        series: series.into(),
    };
    Findings { summary: summary.into(), notes, plot, numbers, measurements }
}

/// By how much a thing leans from how it stood, whichever way it is turned about the vertical, degrees.
fn tilted(before: &Isometry3<f64>, after: &Isometry3<f64>) -> f64 {
    let upright = before.rotation.inverse() * Vector3::z();
    (after.rotation * upright).z.clamp(-1.0, 1.0).acos().to_degrees()
}

/// Whether a thing is on the table, not below it.
fn stands(stage: &Stage, thing: usize) -> bool {
    stage.thing_pose(thing).translation.z > TOP - BELOW
}

/// A creature that has found a random thing and holds it with a receptor of a hand; none where it did not come to that.
fn hold(
    subject: &Subject,
    known: &Knowledge,
    seed: u64,
    rng: &mut ChaCha8Rng,
) -> Result<Option<(OnStage, usize)>, ExperimentError> {
    let (x, y) = (rng.random_range(0.32..0.5), rng.random_range(-0.3..0.3));
    let thing = on_table(shape(rng), x, y, rng.random_range(0.0..std::f64::consts::PI));
    let hand = usize::from(y < 0.0);
    let mut actor = at_table(subject, known, &[thing], seed)?;
    let thing = actor.the_thing()?;
    let Ok(height) = actor.feel_table(0).and_then(|a| Ok(a.min(actor.feel_table(1)?))) else {
        return Ok(None);
    };
    actor.know_table(height);
    let Some(found) = actor.explore(hand).ok().flatten().filter(|found| found.thing == thing) else {
        return Ok(None);
    };
    let receptor = match actor.hands[hand].receptors.contains(&found.receptor) {
        true => found.receptor,
        false => match actor.touch(&found, hand, false, 1) {
            Ok(touching) if touching.found.thing == thing => touching.found.receptor,
            _ => return Ok(None),
        },
    };
    Ok(actor.hold(receptor).then_some((actor, receptor)))
}
