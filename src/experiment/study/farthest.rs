//! How far away a creature puts what it holds, against how far it truly could.

use rand::RngExt;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use serde_json::json;

use super::at_table::{Knowledge, OnStage, at_table, on_table, shape};
use super::plot::{AxisScale, PlotAxis, PlotSeries, StudyPlot};
use super::subject::{Subject, median, share};
use super::table::row;
use super::{Findings, Study};
use crate::experiment::ExperimentError;
use crate::interaction::{Actor, Spot, Trouble};

/// The study `farthest`.
pub const STUDY: Study = Study {
    name: "farthest",
    about: "how far away it puts what it holds, of what is truly possible, with and without leaning",
    touches: true,
    several: false,
    measure: |subject| Ok(measure(subject)?.into()),
};

/// Draws of a thing until there is one that a hand finds and holds.
const DRAWS: usize = 20;
/// Random postures that the truth's search begins with beside those of the creature's.
const EFFORT: usize = 9;

row! {
    /// A measurement of the study `farthest`.
    pub struct FarthestMeasurement {
        seed: u64 = "seed",
        leaning: bool = "leaning",
        forward_m: f64 = "reached, m",
        true_maximum_m: f64 = "true maximum, m",
        ratio: f64 = "ratio",
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
        true_maximum_m: f64 = "true maximum, m",
        ratio: f64 = "ratio, median",
        least: f64 = "ratio, least",
    }
}

struct PlacingTrial {
    forward: f64,
    maximum: f64,
    put: bool,
}

/// Measures; a trial that does not succeed is a finding.
///
/// # Errors
/// Where something cannot be measured at all.
pub fn measure(subject: &Subject) -> Result<Findings<FarthestMeasurement, FarthestSummary>, ExperimentError> {
    let learned = Knowledge::new(subject.own_body(subject.seeds[0])?);
    let truth = Knowledge::new(learned.own.with_schema(subject.truth().schema.clone()));
    let mut measurements: Vec<FarthestMeasurement> = Vec::new();
    let mut trials: [Vec<PlacingTrial>; 2] = Default::default();
    for &seed in &subject.seeds {
        subject.tell(seed, "holding");
        for (k, lean) in [false, true].into_iter().enumerate() {
            let mut rng = ChaCha8Rng::seed_from_u64(seed);
            let mut held = None;
            for _ in 0..DRAWS {
                held = hold(subject, &learned, seed, &mut rng)?;
                if held.is_some() {
                    break;
                }
            }
            let Some((mut actor, receptor)) = held else { continue };
            if lean && let Some(hand) = actor.arm_of(receptor) {
                // The other arm makes way as far as it can.
                if let Err(Trouble::Engine(error)) = actor.make_way_to_lean(hand) {
                    return Err(error.into());
                }
            }
            let limb = actor.own.place(receptor).limb;
            let upright = actor.frames()[limb].rotation.tr_mul(&actor.up);
            let height = actor.feels_at(receptor).0.dot(&actor.up);
            let Some(spot) = actor.farthest(receptor, height, upright, lean, 3) else { continue };
            // The same question to the truth, with more starts and what was found for one of them.
            actor.own = truth.own.clone();
            let maximum = actor.farthest(receptor, height, upright, lean, EFFORT);
            let forward = |actor: &Actor, spot: &Spot| {
                let place = actor.own.place(receptor);
                actor.own.frames(&spot.posture)[place.limb].point(&place.point).dot(&actor.front)
            };
            let reached = forward(&actor, &spot);
            let maximum = maximum.map_or(reached, |spot| forward(&actor, &spot).max(reached));
            actor.own = learned.own.clone();
            let thing = actor.the_thing()?;
            let before = actor.stage.thing_pose(thing).translation.vector;
            let result = actor.put(receptor, &spot, lean);
            let after = actor.stage.thing_pose(thing).translation.vector;
            let stands = after.z > super::at_table::TOP - 0.01;
            let put = result.is_ok() && stands;
            let told = match result {
                Ok(()) if stands => "put".to_string(),
                Ok(()) => "it fell".to_string(),
                Err(Trouble::Engine(error)) => return Err(error.into()),
                Err(trouble) => trouble.to_string(),
            };
            measurements.push(FarthestMeasurement {
                seed,
                leaning: lean,
                forward_m: reached,
                true_maximum_m: maximum,
                ratio: reached / maximum,
                moved_m: (after - before).norm(),
                result: told,
            });
            trials[k].push(PlacingTrial { forward: reached, maximum, put });
        }
    }
    let mut summary: Vec<FarthestSummary> = Vec::new();
    let ratios = |trials: &[PlacingTrial]| trials.iter().map(|t| t.forward / t.maximum).collect::<Vec<_>>();
    for (lean, trials) in [false, true].into_iter().zip(&trials) {
        let least = ratios(trials).into_iter().fold(f64::NAN, f64::min);
        summary.push(FarthestSummary {
            leaning: lean,
            trials: trials.len(),
            put: share(trials.iter().map(|t| t.put)),
            forward_m: median(trials.iter().map(|t| t.forward)),
            true_maximum_m: median(trials.iter().map(|t| t.maximum)),
            ratio: median(ratios(trials)),
            least,
        });
    }
    let gain = |of: fn(&PlacingTrial) -> f64| {
        median(trials[0].iter().zip(&trials[1]).map(|(upright, leaning)| of(leaning) - of(upright)))
    };
    let (extends, truly) = (gain(|t| t.forward), gain(|t| t.maximum));
    let all = || trials.iter().flatten();
    let least = ratios(&trials[0]).into_iter().chain(ratios(&trials[1])).fold(f64::NAN, f64::min);
    let notes = vec![
        "Distances are of the skin that holds the thing, forward from the root's origin, at the height where the thing \
         stands; the true maximum is found by the same search with the true kinematics and more starts."
            .to_string(),
        format!("Leaning extends the reach by {extends:.3} m; by the truth it is {truly:.3} m."),
    ];
    let numbers = vec![
        ("ratio_of_true_maximum", json!(median(all().map(|t| t.forward / t.maximum)))),
        ("least_ratio_of_true_maximum", json!(least)),
        ("success", json!(share(all().map(|t| t.put)))),
        ("leaning_extends_m", json!(extends)),
        ("leaning_truly_extends_m", json!(truly)),
    ];
    let series =
        ["upright", "leaning"].into_iter().zip(&trials).enumerate().map(|(k, (name, trials))| PlotSeries {
            name: name.to_string(),
            line: Vec::new(),
            dots: trials.iter().map(|trial| (trial.forward / trial.maximum, k as f64)).collect(),
        });
    let plot = StudyPlot {
        x: PlotAxis { title: "reached, of the true maximum", scale: AxisScale::Logarithmic },
        y: PlotAxis { title: "", scale: AxisScale::Names(vec!["upright".into(), "leaning".into()]) },
        series: series.collect(),
    };
    Ok(Findings { measurements, summary, notes, plot, numbers })
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
