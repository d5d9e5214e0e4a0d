//! Whether a creature finds with one hand what the other arm felt.

use nalgebra::{Isometry3, Point3, Translation3, UnitQuaternion, Vector3};
use rand::RngExt;
use rand::SeedableRng;
use rand::seq::IndexedRandom;
use rand_chacha::ChaCha8Rng;
use serde::{Deserialize, Serialize};
use serde_json::json;

use super::at_table::{HANDS, Knowledge, KnownBodies, OnStage, THING, at_table, on_table, shape};
use super::plot::{AxisScale, PlotAxis, PlotSeries, StudyPlot};
use super::subject::{Subject, median, share};
use super::table::row;
use super::{Findings, Study, Trial, Trials};
use crate::creature::Posture;
use crate::experiment::ExperimentError;
use crate::interaction::{FoundThing, Hand, Trouble};
use crate::kinematics::REACHED;
use crate::peripersonal::ReachTarget;
use crate::senses::Toucher;
use crate::simulation::{Substance, Thing};
use crate::skin::Surface;

/// The study `other-hand`.
pub const STUDY: Study = Study {
    name: "other-hand",
    about: "whether one hand finds what the other arm felt, on a table and in the air; a trial is one of either",
    touches: true,
    several: false,
    trials: Trials::of::<OtherHandTrial>(),
};

/// Draws of a thing until there is one that a hand feels and the other could truly reach.
const DRAWS: usize = 60;

/// By which schema it acts, and whether it feels points or only receptors.
const CONDITIONS: [(&str, bool); 3] = [("learned", false), ("true", false), ("learned, feels points", true)];

row! {
    /// A measurement of the study `other-hand`.
    pub struct OtherHandMeasurement {
        seed: u64 = "seed",
        place: String = "place",
        schema: String = "schema",
        felt_by: String = "felt by",
        hand: String = "hand",
        first: bool = "at the first go",
        touched: bool = "touched",
        error_mm: f64 = "error, mm",
        contact_mm: f64 = "contacts apart, mm",
        felt_mm: f64 = "felt, mm",
        felt_on_mm: f64 = "felt on, mm",
        unintended: usize = "unintended",
        result: String = "result",
    }
}

row! {
    /// A row of the summary of the study `other-hand`.
    pub struct OtherHandSummary {
        schema: String = "schema",
        trials: usize = "trials",
        first: f64 = "at the first go",
        touched: f64 = "with one correction",
        error_mm: f64 = "error, mm",
        contact_mm: f64 = "contacts apart, mm",
        felt_mm: f64 = "felt, mm",
        felt_on_mm: f64 = "felt on, mm",
        unintended: f64 = "unintended, share",
    }
}

/// What came of one attempt.
struct TouchAttempt {
    first: bool,
    touched: bool,
    /// From where the thing was touched by the arm to the nearest skin of the hand when it touches, metres.
    error: f64,
    /// From where the arm touched the thing to where the hand does, on the thing, metres.
    contact: f64,
    /// From where the arm took itself to be touched to where it was, metres.
    felt: f64,
    /// The same after it has felt on.
    felt_on: f64,
    unintended: usize,
    result: String,
}

/// What is felt, and by what.
pub(super) struct FeltThing {
    pub found: FoundThing,
    pub hand: usize,
    limb: usize,
    /// Where on the thing, in its frame, metres.
    at: Vector3<f64>,
}

/// What came of one trial.
#[derive(Debug, Serialize, Deserialize)]
pub struct OtherHandTrial {
    measurements: Vec<OtherHandMeasurement>,
    /// Things that were drawn and that the other hand could truly not have reached.
    passed_over: usize,
}

impl Trial for OtherHandTrial {
    type Setting = KnownBodies;
    type Measurement = OtherHandMeasurement;
    type Summary = OtherHandSummary;

    fn set_up(subject: &Subject) -> Result<KnownBodies, ExperimentError> {
        KnownBodies::of(subject)
    }

    fn run(subject: &Subject, bodies: &KnownBodies, seed: u64) -> Result<OtherHandTrial, ExperimentError> {
        let KnownBodies { learned, truth } = bodies;
        let mut measurements = Vec::new();
        let mut passed_over = 0;
        for (stream, place) in ["table", "air"].into_iter().enumerate() {
            subject.tell(seed, place);
            let mut rng = ChaCha8Rng::seed_from_u64(seed);
            rng.set_stream(stream as u64);
            let mut drawn = None;
            for _ in 0..DRAWS {
                let thing = match place {
                    "table" => Some(random_on_table(&mut rng)),
                    _ => None,
                };
                let hand = rng.random_range(0..2);
                let put = match thing {
                    Some(thing) if !both_reach(subject, truth, &thing)? => None,
                    Some(thing) => Some(PlacedThing { thing, hand, arm: None }),
                    None => in_air(subject, truth, hand, &mut rng)?,
                };
                let Some(put) = put else { continue };
                // Whether it is felt, and whether the other hand could truly reach it, is asked of the truth.
                let Some((actor, felt)) = feel(subject, truth, &put, seed, false)? else { continue };
                if reachable(actor, &felt) {
                    drawn = Some(put);
                    break;
                }
                passed_over += 1;
            }
            let Some(put) = drawn else { continue };
            for (name, fine) in CONDITIONS {
                let own = if name.starts_with("true") { truth } else { learned };
                let (limb, attempt) = match feel(subject, own, &put, seed, fine)? {
                    Some((actor, felt)) => {
                        let limb = own.own.creature().limbs()[felt.limb].clone();
                        (limb, attempt(actor, &felt)?)
                    }
                    None => (
                        "nothing".to_string(),
                        TouchAttempt {
                            first: false,
                            touched: false,
                            error: f64::NAN,
                            contact: f64::NAN,
                            felt: f64::NAN,
                            felt_on: f64::NAN,
                            unintended: 0,
                            result: "not felt".into(),
                        },
                    ),
                };
                measurements.push(OtherHandMeasurement {
                    seed,
                    place: place.into(),
                    schema: name.into(),
                    felt_by: limb,
                    hand: HANDS[1 - put.hand].into(),
                    first: attempt.first,
                    touched: attempt.touched,
                    error_mm: 1e3 * attempt.error,
                    contact_mm: 1e3 * attempt.contact,
                    felt_mm: 1e3 * attempt.felt,
                    felt_on_mm: 1e3 * attempt.felt_on,
                    unintended: attempt.unintended,
                    result: attempt.result,
                });
            }
        }
        Ok(OtherHandTrial { measurements, passed_over })
    }

    fn findings(
        _subject: &Subject,
        trials: &[OtherHandTrial],
    ) -> Findings<OtherHandMeasurement, OtherHandSummary> {
        findings(trials)
    }
}

fn findings(trials: &[OtherHandTrial]) -> Findings<OtherHandMeasurement, OtherHandSummary> {
    type Row = OtherHandMeasurement;
    let measurements: Vec<Row> = trials.iter().flat_map(|trial| trial.measurements.clone()).collect();
    let passed_over: usize = trials.iter().map(|trial| trial.passed_over).sum();
    let rows = CONDITIONS
        .map(|(name, _)| measurements.iter().filter(|row| row.schema == name).collect::<Vec<&Row>>());
    let rate = |rows: &[&Row], of: fn(&Row) -> bool| share(rows.iter().map(|row| of(row)));
    let error = |rows: &[&Row], of: fn(&Row) -> f64| {
        median(rows.iter().filter(|row| row.touched).map(|row| of(row)).filter(|x| x.is_finite()))
    };
    let mut summary: Vec<OtherHandSummary> = Vec::new();
    for ((name, _), rows) in CONDITIONS.into_iter().zip(&rows) {
        summary.push(OtherHandSummary {
            schema: name.into(),
            trials: rows.len(),
            first: rate(rows, |row| row.first),
            touched: rate(rows, |row| row.touched),
            error_mm: error(rows, |row| row.error_mm),
            contact_mm: error(rows, |row| row.contact_mm),
            felt_mm: error(rows, |row| row.felt_mm),
            felt_on_mm: error(rows, |row| row.felt_on_mm),
            unintended: rate(rows, |row| row.unintended > 0),
        });
    }
    let [own, real, fine] = &rows;
    let ratio = rate(own, |row| row.touched) / rate(real, |row| row.touched);
    let notes = vec![
        "error: from where the arm touched the thing to the nearest skin of the hand when it touches; contacts apart: to \
         where the hand touches, on the thing, which may be another side of it; felt: from where the arm, whose receptors \
         have an extent, took itself to be touched to where it was; felt on: the same after small motions of it. Medians over what was touched."
            .to_string(),
        format!("Successes with the learned schema over those with the true one: {ratio:.3}. {passed_over} things were drawn that the other hand could truly not have reached."),
    ];
    let numbers = vec![
        ("success_first", json!(rate(own, |row| row.first))),
        ("success", json!(rate(own, |row| row.touched))),
        ("error_mm", json!(error(own, |row| row.error_mm))),
        ("contact_mm", json!(error(own, |row| row.contact_mm))),
        ("felt_mm", json!(error(own, |row| row.felt_mm))),
        ("fine_error_mm", json!(error(fine, |row| row.error_mm))),
        ("fine_success_first", json!(rate(fine, |row| row.first))),
        ("fine_success", json!(rate(fine, |row| row.touched))),
        ("true_kinematics_success", json!(rate(real, |row| row.touched))),
        ("success_ratio", json!(ratio)),
        ("unintended", json!(rate(own, |row| row.unintended > 0))),
    ];
    let series = CONDITIONS.iter().zip(&rows).enumerate().map(|(k, ((name, _), rows))| PlotSeries {
        name: name.to_string(),
        line: Vec::new(),
        dots: rows.iter().map(|row| (row.error_mm, k as f64)).collect(),
    });
    let plot = StudyPlot {
        x: PlotAxis {
            title: "from where it was felt to where it was touched, mm",
            scale: AxisScale::Logarithmic,
        },
        y: PlotAxis {
            title: "",
            scale: AxisScale::Names(CONDITIONS.iter().map(|(name, _)| (*name).into()).collect()),
        },
        series: series.collect(),
    };
    Findings { summary, notes, plot, numbers, measurements }
}

/// A thing in its place, and the hand that is to feel it: by sweeping, or where it is put against an arm in a posture.
pub(super) struct PlacedThing {
    pub thing: Thing,
    pub hand: usize,
    pub arm: Option<Posture>,
}

fn random_on_table(rng: &mut ChaCha8Rng) -> Thing {
    let (x, y) = (rng.random_range(0.3..0.75), rng.random_range(-0.45..0.45));
    on_table(shape(rng), x, y, rng.random_range(0.0..std::f64::consts::PI))
}

/// Whether both hands could truly be where a thing stands.
pub(super) fn both_reach(
    subject: &Subject,
    truth: &Knowledge,
    thing: &Thing,
) -> Result<bool, ExperimentError> {
    let mut actor = at_table(subject, truth, &[], 0)?;
    let from = actor.posture();
    let point = actor.stage.root_pose().inverse_transform_point(&Point3::from(thing.pose.translation.vector));
    let aim = ReachTarget { point: point.coords, direction: Vector3::zeros() };
    Ok((0..2).all(|hand| {
        let Hand { arm, tip, .. } = actor.hands[hand].clone();
        actor.reaching(arm).solve(truth.own.place(tip), &aim, &from).miss <= REACHED
    }))
}

/// A thing that is held against a random receptor of an arm in a random posture.
fn in_air(
    subject: &Subject,
    truth: &Knowledge,
    hand: usize,
    rng: &mut ChaCha8Rng,
) -> Result<Option<PlacedThing>, ExperimentError> {
    let mut actor = at_table(subject, truth, &[], 0)?;
    let height = actor.table_top();
    actor.know_table(height);
    let from = actor.posture();
    let arm = actor.hands[hand].arm.clone();
    let clearance = actor.clearance.moved_by(&truth.own, &arm);
    let posture = (0..200)
        .map(|_| truth.own.random_posture(&from, &arm, rng))
        .find(|posture| clearance.free(&truth.own.frames(posture), 0.01));
    let Some(posture) = posture else { return Ok(None) };
    let limbs = arm.iter().skip(1).flat_map(|joint| truth.own.hand_of(joint + 1)).collect::<Vec<_>>();
    let receptors = truth.own.receptors_on(&limbs);
    let Some(&receptor) = receptors.choose(rng) else { return Ok(None) };
    actor.place(&posture)?;
    // Anywhere on its patch.
    let found = &truth.own.skin().receptors[receptor];
    let mut along = |half: f64| rng.random_range(-half..half);
    let flat = found.position
        + found.tangent * along(found.half_extents[0])
        + found.bitangent() * along(found.half_extents[1]);
    let place = truth.own.on_surface(receptor, &flat).unwrap_or_else(|| truth.own.place(receptor));
    let frame = actor.frames()[place.limb];
    let (point, normal) = (frame.point(&place.point), frame.rotation * place.direction);
    let x_wr = actor.stage.root_pose();
    let (point, normal) = (x_wr * Point3::from(point), x_wr * normal);
    let shape = shape(rng);
    let turn = UnitQuaternion::from_scaled_axis(Vector3::from_fn(|_, _| rng.random_range(-1.5..1.5)));
    let Some(deepest) = shape.support(&turn.inverse_transform_vector(&-normal)) else { return Ok(None) };
    let origin = point.coords - normal * 3e-4 - turn * deepest;
    let pose = Isometry3::from_parts(Translation3::from(origin), turn);
    let thing = Thing { name: THING.into(), shape, pose, fixed: true, substance: Substance::default() };
    Ok(Some(PlacedThing { thing, hand, arm: Some(posture) }))
}

/// Lets the creature feel the thing; none where it does not, or feels more than it should.
pub(super) fn feel(
    subject: &Subject,
    own: &Knowledge,
    put: &PlacedThing,
    seed: u64,
    fine: bool,
) -> Result<Option<(OnStage, FeltThing)>, ExperimentError> {
    let mut actor = at_table(subject, own, std::slice::from_ref(&put.thing), seed)?;
    actor.fine_touch = fine;
    actor.feels_on = true;
    let thing = actor.the_thing()?;
    if actor.wait(0.01)?.iter().any(|contact| contact.by == Toucher::Thing(thing)) && put.arm.is_none() {
        return Ok(None);
    }
    let Ok(height) = actor.feel_table(0).and_then(|a| Ok(a.min(actor.feel_table(1)?))) else {
        return Ok(None);
    };
    actor.know_table(height);
    let found = match &put.arm {
        Some(posture) => {
            // A partner has put the arm there and holds the thing against it.
            actor.place(posture)?;
            let felt = actor.wait(0.01)?;
            if felt.iter().any(|contact| contact.by != Toucher::Thing(thing)) {
                return Ok(None);
            }
            felt.iter().find_map(|contact| actor.found(contact))
        }
        None => actor.explore(put.hand).ok().flatten(),
    };
    let Some(found) = found.filter(|found| found.thing == thing) else { return Ok(None) };
    let limb = actor.own.skin().receptors[found.receptor].limb;
    if actor.arm_of(found.receptor) != Some(put.hand) {
        return Ok(None);
    }
    let Some(at) = actor.stage.touching_at(limb, thing) else { return Ok(None) };
    let felt = FeltThing { found, hand: put.hand, limb, at };
    Ok(Some((actor, felt)))
}

/// Postures that a true reach is looked for from.
const THOROUGH: usize = 20;

/// Whether some skin of the other hand can be where the thing was felt with no limb in another or in the table, by the
/// schema of the one who felt it.
fn reachable(mut actor: OnStage, felt: &FeltThing) -> bool {
    let hand = actor.hands[1 - felt.hand].clone();
    let from = actor.ready();
    let aim = ReachTarget { point: felt.found.point, direction: felt.found.direction };
    actor.reaching(hand.arm).can_be_at(&from, &hand.receptors, &aim, THOROUGH)
}

fn attempt(mut actor: OnStage, felt: &FeltThing) -> Result<TouchAttempt, ExperimentError> {
    let hand = 1 - felt.hand;
    // Both in the world: by the engine, and by the creature.
    let really = actor.stage.thing_pose(felt.found.thing) * Point3::from(felt.at);
    let believed = actor.stage.root_pose() * Point3::from(felt.found.point);
    actor.unintended = 0;
    let result = actor.touch(&felt.found, hand, true, 1);
    let mut attempt = TouchAttempt {
        first: false,
        touched: false,
        error: f64::NAN,
        contact: f64::NAN,
        felt: (really - believed).norm(),
        felt_on: f64::NAN,
        unintended: actor.unintended,
        result: String::new(),
    };
    match result {
        Ok(touching) if touching.found.thing == felt.found.thing => {
            let by = actor.own.skin().receptors[touching.found.receptor].limb;
            attempt.touched = true;
            let felt_on = actor.stage.root_pose() * Point3::from(touching.felt.found.point);
            attempt.felt_on = (really - felt_on).norm();
            attempt.first = touching.corrections == 0;
            if let Some(at) = actor.stage.touching_at(by, touching.found.thing) {
                attempt.contact = (at - felt.at).norm();
            }
            // The thing may have been moved a little: where it was touched went with it.
            let place = actor.stage.thing_pose(touching.found.thing) * Point3::from(felt.at);
            let surfaces = actor.stage.skin().surfaces.iter().filter(|surface| {
                actor.hands[hand].limb == surface.limb
                    || actor.own.carried_by(actor.hands[hand].limb)[surface.limb]
            });
            let gap = |surface: &Surface| {
                let pose = actor.stage.limb_pose(surface.limb);
                Some(surface.signed_distance(&pose.inverse_transform_point(&place).coords)?.0.abs())
            };
            let nearest = surfaces.filter_map(gap).fold(f64::INFINITY, f64::min);
            if nearest.is_finite() {
                attempt.error = nearest;
            }
            attempt.result = "touched".into();
        }
        Ok(_) => attempt.result = "something else".into(),
        Err(Trouble::Engine(error)) => return Err(error.into()),
        Err(trouble) => attempt.result = trouble.to_string(),
    }
    Ok(attempt)
}
