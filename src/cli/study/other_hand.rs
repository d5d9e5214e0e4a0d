//! Whether a creature finds with one hand what the other arm felt.

use nalgebra::{Isometry3, Point3, Translation3, UnitQuaternion, Vector3};
use rand::RngExt;
use rand::SeedableRng;
use rand::seq::IndexedRandom;
use rand_chacha::ChaCha8Rng;
use serde_json::json;

use super::at_table::{HANDS, Knowledge, THING, at_table, on_table, shape};
use super::plot::{Axis, Plot, Scale, Series};
use super::subject::{Subject, median, share};
use super::table::{Cell, Column, Table};
use super::{Findings, Study};
use crate::cli::Failure;
use crate::interaction::{Actor, Found, Hand, Thing, Touched, Trouble};
use crate::kinematics::REACHED;
use crate::peripersonal::Aim;
use crate::skin::Surface;

pub const STUDY: Study = Study {
    name: "other-hand",
    about: "whether one hand finds what the other arm felt, on a table and in the air; a trial is one of either",
    touches: true,
    measure,
};

/// Draws of a thing until there is one that a hand feels and the other could truly reach.
const DRAWS: usize = 60;

/// By which schema it acts, and whether it feels points or only receptors.
const CONDITIONS: [(&str, bool); 3] = [("learned", false), ("true", false), ("learned, feels points", true)];

const MEASUREMENTS: &[Column] = &[
    Column { name: "seed", heading: "seed" },
    Column { name: "place", heading: "place" },
    Column { name: "schema", heading: "schema" },
    Column { name: "felt_by", heading: "felt by" },
    Column { name: "hand", heading: "hand" },
    Column { name: "first", heading: "at the first go" },
    Column { name: "touched", heading: "touched" },
    Column { name: "error_mm", heading: "error, mm" },
    Column { name: "contact_mm", heading: "contacts apart, mm" },
    Column { name: "felt_mm", heading: "felt, mm" },
    Column { name: "unintended", heading: "unintended" },
    Column { name: "result", heading: "result" },
];

const SUMMARY: &[Column] = &[
    Column { name: "schema", heading: "schema" },
    Column { name: "trials", heading: "trials" },
    Column { name: "first", heading: "at the first go" },
    Column { name: "touched", heading: "with one correction" },
    Column { name: "error_mm", heading: "error, mm" },
    Column { name: "contact_mm", heading: "contacts apart, mm" },
    Column { name: "felt_mm", heading: "felt, mm" },
    Column { name: "unintended", heading: "unintended, share" },
];

/// What came of one attempt.
struct Attempt {
    first: bool,
    touched: bool,
    /// From where the thing was touched by the arm to the nearest skin of the hand when it touches, metres.
    error: f64,
    /// From where the arm touched the thing to where the hand does, on the thing, metres.
    contact: f64,
    /// From where the arm took itself to be touched to where it was, metres.
    felt: f64,
    unintended: usize,
    result: String,
}

/// What is felt, and by what.
struct Felt {
    found: Found,
    hand: usize,
    limb: usize,
    /// Where on the thing, in its frame, metres.
    at: Vector3<f64>,
}

fn measure(subject: &Subject) -> Result<Findings, Failure> {
    let learned = Knowledge::new(subject.own_body(subject.seeds[0])?);
    let truth = Knowledge::new(learned.own.with_schema(subject.truth.schema.clone()));
    let mut measurements = Table::new(MEASUREMENTS);
    let mut attempts: [Vec<Attempt>; 3] = Default::default();
    let mut passed_over = 0;
    for &seed in &subject.seeds {
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
                    Some(thing) if !both_reach(subject, &truth, &thing)? => None,
                    Some(thing) => Some(Put { thing, hand, arm: None }),
                    None => in_air(subject, &truth, hand, &mut rng)?,
                };
                let Some(put) = put else { continue };
                // Whether it is felt, and whether the other hand could truly reach it, is asked of the truth.
                let Some((actor, felt)) = feel(subject, &truth, &put, seed, false)? else { continue };
                if reachable(actor, &felt) {
                    drawn = Some(put);
                    break;
                }
                passed_over += 1;
            }
            let Some(put) = drawn else { continue };
            for (k, (name, fine)) in CONDITIONS.into_iter().enumerate() {
                let own = if name.starts_with("true") { &truth } else { &learned };
                let (limb, attempt) = match feel(subject, own, &put, seed, fine)? {
                    Some((actor, felt)) => {
                        let limb = own.own.creature.limbs()[felt.limb].clone();
                        (limb, attempt(actor, &felt)?)
                    }
                    None => (
                        "nothing".to_string(),
                        Attempt {
                            first: false,
                            touched: false,
                            error: f64::NAN,
                            contact: f64::NAN,
                            felt: f64::NAN,
                            unintended: 0,
                            result: "not felt".into(),
                        },
                    ),
                };
                measurements.row([
                    seed.into(),
                    place.into(),
                    name.into(),
                    limb.into(),
                    HANDS[1 - put.hand].into(),
                    attempt.first.into(),
                    attempt.touched.into(),
                    (1e3 * attempt.error).into(),
                    (1e3 * attempt.contact).into(),
                    (1e3 * attempt.felt).into(),
                    attempt.unintended.into(),
                    attempt.result.clone().into(),
                ]);
                attempts[k].push(attempt);
            }
        }
    }
    let mut summary = Table::new(SUMMARY);
    let rate = |attempts: &[Attempt], of: fn(&Attempt) -> bool| share(attempts.iter().map(of));
    let error = |attempts: &[Attempt], of: fn(&Attempt) -> f64| {
        1e3 * median(attempts.iter().filter(|a| a.touched).map(of).filter(|x| x.is_finite()))
    };
    for ((name, _), attempts) in CONDITIONS.into_iter().zip(&attempts) {
        summary.row([
            name.into(),
            attempts.len().into(),
            rate(attempts, |a| a.first).into(),
            rate(attempts, |a| a.touched).into(),
            error(attempts, |a| a.error).into(),
            error(attempts, |a| a.contact).into(),
            error(attempts, |a| a.felt).into(),
            Cell::from(rate(attempts, |a| a.unintended > 0)),
        ]);
    }
    let [own, real, fine] = &attempts;
    let ratio = rate(own, |a| a.touched) / rate(real, |a| a.touched);
    let notes = vec![
        "error: from where the arm touched the thing to the nearest skin of the hand when it touches; contacts apart: to \
         where the hand touches, on the thing, which may be another side of it; felt: from where the arm, whose receptors \
         have an extent, took itself to be touched to where it was. Medians over what was touched."
            .to_string(),
        format!("Successes with the learned schema over those with the true one: {ratio:.3}. {passed_over} things were drawn that the other hand could truly not have reached."),
    ];
    let numbers = vec![
        ("success_first", json!(rate(own, |a| a.first))),
        ("success", json!(rate(own, |a| a.touched))),
        ("error_mm", json!(error(own, |a| a.error))),
        ("contact_mm", json!(error(own, |a| a.contact))),
        ("felt_mm", json!(error(own, |a| a.felt))),
        ("fine_error_mm", json!(error(fine, |a| a.error))),
        ("fine_success_first", json!(rate(fine, |a| a.first))),
        ("fine_success", json!(rate(fine, |a| a.touched))),
        ("true_kinematics_success", json!(rate(real, |a| a.touched))),
        ("success_ratio", json!(ratio)),
        ("unintended", json!(rate(own, |a| a.unintended > 0))),
    ];
    let series = CONDITIONS.iter().zip(&attempts).enumerate().map(|(k, ((name, _), attempts))| Series {
        name: name.to_string(),
        line: Vec::new(),
        dots: attempts.iter().map(|attempt| (1e3 * attempt.error, k as f64)).collect(),
    });
    let plot = Plot {
        x: Axis { title: "from where it was felt to where it was touched, mm", scale: Scale::Logarithmic },
        y: Axis {
            title: "",
            scale: Scale::Names(CONDITIONS.iter().map(|(name, _)| (*name).into()).collect()),
        },
        series: series.collect(),
    };
    Ok(Findings { measurements, summary, notes, plot, numbers })
}

/// A thing in its place, and the hand that is to feel it: by sweeping, or where it is put against an arm in a posture.
struct Put {
    thing: Thing,
    hand: usize,
    arm: Option<Vec<f64>>,
}

fn random_on_table(rng: &mut ChaCha8Rng) -> Thing {
    let (x, y) = (rng.random_range(0.3..0.75), rng.random_range(-0.45..0.45));
    on_table(shape(rng), x, y, rng.random_range(0.0..std::f64::consts::PI))
}

/// Whether both hands could truly be where a thing stands.
fn both_reach(subject: &Subject, truth: &Knowledge, thing: &Thing) -> Result<bool, Failure> {
    let mut actor = at_table(subject, truth, &[], 0)?;
    let from = actor.posture();
    let point = actor.scene.root_pose().inverse_transform_point(&Point3::from(thing.pose.translation.vector));
    let aim = Aim { point: point.coords, direction: Vector3::zeros() };
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
) -> Result<Option<Put>, Failure> {
    let mut actor = at_table(subject, truth, &[], 0)?;
    actor.know_table(super::at_table::TOP - actor.scene.root_pose().translation.z);
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
    let found = &truth.own.skin.receptors[receptor];
    let mut along = |half: f64| rng.random_range(-half..half);
    let flat = found.position
        + found.tangent * along(found.half_extents[0])
        + found.bitangent() * along(found.half_extents[1]);
    let place = truth.own.on_surface(receptor, &flat).unwrap_or_else(|| truth.own.place(receptor));
    let frame = actor.frames()[place.limb];
    let (point, normal) = (frame.point(&place.point), frame.rotation * place.direction);
    let x_wr = actor.scene.root_pose();
    let (point, normal) = (x_wr * Point3::from(point), x_wr * normal);
    let shape = shape(rng);
    let turn = UnitQuaternion::from_scaled_axis(Vector3::from_fn(|_, _| rng.random_range(-1.5..1.5)));
    let Some(deepest) = shape.support(&turn.inverse_transform_vector(&-normal)) else { return Ok(None) };
    let origin = point.coords - normal * 3e-4 - turn * deepest;
    let pose = Isometry3::from_parts(Translation3::from(origin), turn);
    let thing = Thing { name: THING.into(), shape, pose, fixed: true };
    Ok(Some(Put { thing, hand, arm: Some(posture) }))
}

/// Lets the creature feel the thing; none where it does not, or feels more than it should.
fn feel(
    subject: &Subject,
    own: &Knowledge,
    put: &Put,
    seed: u64,
    fine: bool,
) -> Result<Option<(Actor, Felt)>, Failure> {
    let mut actor = at_table(subject, own, std::slice::from_ref(&put.thing), seed)?;
    actor.fine_touch = fine;
    let thing = actor.scene.thing(THING).ok_or("the thing is not in the scene")?;
    if actor.wait(0.01)?.iter().any(|feeling| feeling.what == Touched::Thing(thing)) && put.arm.is_none() {
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
            if felt.iter().any(|feeling| feeling.what != Touched::Thing(thing)) {
                return Ok(None);
            }
            felt.iter().find_map(|feeling| actor.found(feeling))
        }
        None => actor.explore(put.hand).ok().flatten(),
    };
    let Some(found) = found.filter(|found| found.thing == thing) else { return Ok(None) };
    let limb = actor.own.skin.receptors[found.receptor].limb;
    if actor.arm_of(found.receptor) != Some(put.hand) {
        return Ok(None);
    }
    let Some(at) = actor.scene.touching_at(limb, thing) else { return Ok(None) };
    let felt = Felt { found, hand: put.hand, limb, at };
    Ok(Some((actor, felt)))
}

/// Postures that a true reach is looked for from.
const THOROUGH: usize = 20;

/// Whether some skin of the other hand can be where the thing was felt with no limb in another or in the table, by the
/// schema of the one who felt it.
fn reachable(mut actor: Actor, felt: &Felt) -> bool {
    let hand = actor.hands[1 - felt.hand].clone();
    let from = actor.ready();
    let aim = Aim { point: felt.found.point, direction: felt.found.direction };
    actor.reaching(hand.arm).can_be_at(&from, &hand.receptors, &aim, THOROUGH)
}

fn attempt(mut actor: Actor, felt: &Felt) -> Result<Attempt, Failure> {
    let hand = 1 - felt.hand;
    // Both in the world: by the engine, and by the creature.
    let really = actor.scene.thing_pose(felt.found.thing) * Point3::from(felt.at);
    let believed = actor.scene.root_pose() * Point3::from(felt.found.point);
    actor.unintended = 0;
    let result = actor.touch(&felt.found, hand, true, 1);
    let mut attempt = Attempt {
        first: false,
        touched: false,
        error: f64::NAN,
        contact: f64::NAN,
        felt: (really - believed).norm(),
        unintended: actor.unintended,
        result: String::new(),
    };
    match result {
        Ok(touching) if touching.found.thing == felt.found.thing => {
            let by = actor.own.skin.receptors[touching.found.receptor].limb;
            attempt.touched = true;
            attempt.first = touching.corrections == 0;
            if let Some(at) = actor.scene.touching_at(by, touching.found.thing) {
                attempt.contact = (at - felt.at).norm();
            }
            // The thing may have been moved a little: where it was touched went with it.
            let place = actor.scene.thing_pose(touching.found.thing) * Point3::from(felt.at);
            let surfaces = actor.scene.skin.surfaces.iter().filter(|surface| {
                actor.hands[hand].limb == surface.limb
                    || actor.own.carried_by(actor.hands[hand].limb)[surface.limb]
            });
            let gap = |surface: &Surface| {
                let pose = actor.scene.body.limb_pose(&actor.scene.data, surface.limb)?;
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
