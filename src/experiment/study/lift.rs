//! Lifting random things between both palms, blind: held by friction alone.

use rand::RngExt;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use serde::{Deserialize, Serialize};
use serde_json::json;

use super::at_table::{KnownBodies, OnStage, TOP};
use super::liftable::{KINDS, random};
use super::other_hand::{PlacedThing, both_reach, feel};
use super::plot::{AxisScale, PlotAxis, PlotSeries, StudyPlot};
use super::subject::{Subject, median, share};
use super::table::row;
use super::{Findings, Study, Trial, Trials};
use crate::experiment::ExperimentError;
use crate::interaction::{FoundThing, LiftTrouble, Trouble};

/// The study `lift`.
pub const STUDY: Study = Study {
    name: "lift",
    about: "lifting between both palms, by friction, what one arm has felt on a table",
    touches: true,
    several: false,
    trials: Trials::of::<LiftTrial>(),
};

/// Draws of a thing until there is one that an arm feels and both hands reach.
const DRAWS: usize = 60;
/// How high a thing must have risen, metres, …
const RISEN: f64 = 0.08;
/// … and for how long it is held there, seconds.
const HOLDING: f64 = 2.0;
/// How often he may begin again.
const CORRECTIONS: usize = 4;
/// How far from where it stood a thing may be set down, metres.
const SET_DOWN: f64 = 0.05;
/// What he knows of his body.
const CONDITIONS: [&str; 2] = ["learned", "true"];

row! {
    /// A measurement of the study `lift`.
    pub struct LiftMeasurement {
        seed: u64 = "seed",
        schema: String = "schema",
        shape: String = "shape",
        mass_kg: f64 = "mass, kg",
        friction: f64 = "friction",
        x_m: f64 = "x, m",
        y_m: f64 = "y, m",
        first: bool = "at the first go",
        lifted: bool = "lifted",
        claimed: bool = "says so",
        rise_mm: f64 = "risen, mm",
        set_down: bool = "set down",
        moved_mm: f64 = "set down apart, mm",
        unintended: usize = "unintended",
        result: String = "result",
    }
}

row! {
    /// A row of the summary of the study `lift`.
    pub struct LiftSummary {
        schema: String = "schema",
        trials: usize = "trials",
        first: f64 = "at the first go",
        lifted: f64 = "with four corrections",
        set_down: f64 = "of these set down",
        moved_mm: f64 = "apart, mm",
        wrong: f64 = "said wrongly",
        unintended: f64 = "unintended, share",
    }
}

/// What came of one trial.
#[derive(Default)]
struct LiftAttempt {
    first: bool,
    lifted: bool,
    /// Whether he says that he has lifted it.
    claimed: bool,
    /// How far it rose, metres.
    rise: f64,
    set_down: bool,
    /// From where it stood to where it was set down, metres.
    moved: f64,
    unintended: usize,
    result: String,
}

/// The measurements of one trial, one for each condition; none where no thing was drawn that can be lifted.
#[derive(Debug, Serialize, Deserialize)]
pub struct LiftTrial(Vec<LiftMeasurement>);

impl Trial for LiftTrial {
    type Setting = KnownBodies;
    type Measurement = LiftMeasurement;
    type Summary = LiftSummary;

    fn set_up(subject: &Subject) -> Result<KnownBodies, ExperimentError> {
        KnownBodies::of(subject)
    }

    fn run(subject: &Subject, bodies: &KnownBodies, seed: u64) -> Result<LiftTrial, ExperimentError> {
        let KnownBodies { learned, truth } = bodies;
        let kind = KINDS[(seed % KINDS.len() as u64) as usize];
        subject.tell(seed, kind);
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let mut drawn = None;
        for _ in 0..DRAWS {
            let put = PlacedThing { thing: random(kind, &mut rng), hand: rng.random_range(0..2), arm: None };
            // Whether both hands could truly be there, and whether it is felt, is asked of the truth.
            if both_reach(subject, truth, &put.thing)? && feel(subject, truth, &put, seed, false)?.is_some() {
                drawn = Some(put);
                break;
            }
        }
        let Some(put) = drawn else { return Ok(LiftTrial(Vec::new())) };
        let mut measurements = Vec::new();
        for (name, own) in CONDITIONS.into_iter().zip([learned, truth]) {
            let attempt = match feel(subject, own, &put, seed, false)? {
                Some((actor, felt)) => attempt(actor, &felt.found)?,
                None => LiftAttempt { result: "not felt".into(), ..LiftAttempt::default() },
            };
            let at = put.thing.pose.translation.vector;
            measurements.push(LiftMeasurement {
                seed,
                schema: name.into(),
                shape: kind.into(),
                mass_kg: put.thing.substance.mass.unwrap_or(f64::NAN),
                friction: put.thing.substance.friction.unwrap_or(f64::NAN),
                x_m: at.x,
                y_m: at.y,
                first: attempt.first,
                lifted: attempt.lifted,
                claimed: attempt.claimed,
                rise_mm: 1e3 * attempt.rise,
                set_down: attempt.set_down,
                moved_mm: 1e3 * attempt.moved,
                unintended: attempt.unintended,
                result: attempt.result,
            });
        }
        Ok(LiftTrial(measurements))
    }

    fn findings(_subject: &Subject, trials: &[LiftTrial]) -> Findings<LiftMeasurement, LiftSummary> {
        findings(trials.iter().flat_map(|trial| trial.0.clone()).collect())
    }
}

fn findings(measurements: Vec<LiftMeasurement>) -> Findings<LiftMeasurement, LiftSummary> {
    type Row = LiftMeasurement;
    let rows =
        CONDITIONS.map(|name| measurements.iter().filter(|row| row.schema == name).collect::<Vec<&Row>>());
    let rate = |rows: &[&Row], of: fn(&Row) -> bool| share(rows.iter().map(|row| of(row)));
    let set_down = |rows: &[&Row]| share(rows.iter().filter(|row| row.lifted).map(|row| row.set_down));
    let summary = CONDITIONS.into_iter().zip(&rows).map(|(name, rows)| LiftSummary {
        schema: name.into(),
        trials: rows.len(),
        first: rate(rows, |row| row.first),
        lifted: rate(rows, |row| row.lifted),
        set_down: set_down(rows),
        moved_mm: median(rows.iter().filter(|row| row.set_down).map(|row| row.moved_mm)),
        wrong: rate(rows, |row| row.claimed != row.lifted),
        unintended: rate(rows, |row| row.unintended > 0),
    });
    let summary = summary.collect();
    let [own, real] = &rows;
    let notes = vec![
        "lifted: its middle is at least 8 cm higher than it stood after it has been held for two seconds, and nothing but \
         hands touches it; set down: it comes to rest on the table within 5 cm of where it stood; said wrongly: he says \
         that he lifted it where he did not, or that he did not where he did."
            .to_string(),
    ];
    let numbers = vec![
        ("success_first", json!(rate(own, |row| row.first))),
        ("success", json!(rate(own, |row| row.lifted))),
        ("set_down", json!(set_down(own))),
        ("said_wrongly", json!(rate(own, |row| row.claimed != row.lifted))),
        ("true_kinematics_success_first", json!(rate(real, |row| row.first))),
        ("true_kinematics_success", json!(rate(real, |row| row.lifted))),
        ("unintended", json!(rate(own, |row| row.unintended > 0))),
    ];
    let series = CONDITIONS.iter().zip(&rows).enumerate().map(|(k, (name, rows))| PlotSeries {
        name: name.to_string(),
        line: Vec::new(),
        dots: rows.iter().map(|row| (row.rise_mm.max(1.0), k as f64)).collect(),
    });
    let plot = StudyPlot {
        x: PlotAxis { title: "risen, mm", scale: AxisScale::Logarithmic },
        y: PlotAxis {
            title: "",
            scale: AxisScale::Names(CONDITIONS.iter().map(|name| (*name).into()).collect()),
        },
        series: series.collect(),
    };
    Findings { summary, notes, plot, numbers, measurements }
}

/// Lets him lift what he has felt, hold it, and set it down.
fn attempt(mut actor: OnStage, found: &FoundThing) -> Result<LiftAttempt, ExperimentError> {
    let thing = found.thing;
    let before = actor.stage.thing_pose(thing).translation.vector;
    actor.unintended = 0;
    let mut attempt = LiftAttempt::default();
    let held = actor.lift(found, CORRECTIONS).and_then(|mut grip| {
        actor.hold_up(&mut grip, HOLDING)?;
        Ok(grip)
    });
    let rise = actor.stage.thing_pose(thing).translation.vector.z - before.z;
    attempt.rise = rise;
    attempt.result = match held {
        Ok(mut grip) => {
            attempt.claimed = true;
            attempt.lifted = rise >= RISEN && only_hands(&actor, thing);
            attempt.first = attempt.lifted && grip.corrections == 0;
            match actor.set_down(&mut grip) {
                Err(LiftTrouble::Other(Trouble::Engine(error))) => return Err(error.into()),
                Err(trouble) => trouble.to_string(),
                Ok(()) => "lifted".to_string(),
            }
        }
        Err(LiftTrouble::Other(Trouble::Engine(error))) => return Err(error.into()),
        Err(trouble) => trouble.to_string(),
    };
    attempt.unintended = actor.unintended;
    if attempt.lifted {
        actor.wait(0.5)?;
        let after = actor.stage.thing_pose(thing).translation.vector;
        attempt.moved = (after - before).xy().norm();
        attempt.set_down = attempt.moved <= SET_DOWN && after.z > TOP;
    }
    Ok(attempt)
}

/// Whether nothing but hands touches a thing, and hands do.
fn only_hands(actor: &OnStage, thing: usize) -> bool {
    let body = actor.stage.body();
    let hands: Vec<bool> = {
        let [one, other] = actor.hands.each_ref().map(|hand| actor.own.carried_by(hand.limb));
        one.into_iter().zip(other).map(|(a, b)| a || b).collect()
    };
    let mut touched = false;
    let data = actor.stage.data();
    for (contact, _) in data.pressing() {
        let bodies = contact.geoms.map(|geom| body.model.geom_body(geom));
        let Some(k) = bodies.iter().position(|body| *body == thing) else { continue };
        if !body.limb_of_geom(contact.geoms[1 - k]).is_some_and(|limb| hands[limb]) {
            return false;
        }
        touched = true;
    }
    touched
}
