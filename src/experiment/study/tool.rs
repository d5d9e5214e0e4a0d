//! Whether a stick in the hand becomes a part of the body: its tip learned by touching himself with it, then things touched
//! with it that the bare hand does not reach.

use nalgebra::{Isometry3, Point3, Translation3, UnitQuaternion, Vector3};
use rand::RngExt;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use serde::{Deserialize, Serialize};
use serde_json::json;

use super::at_table::{HANDS, Knowledge, KnownBodies, OnStage, THING, at_table};
use super::plot::{AxisScale, PlotAxis, PlotSeries, StudyPlot};
use super::subject::{Subject, median, share};
use super::table::row;
use super::{Findings, Study, Trial, Trials};
use crate::creature::Posture;
use crate::experiment::ExperimentError;
use crate::geometry::Shape;
use crate::interaction::{FoundThing, KnownStick, Trouble};
use crate::kinematics::Place;
use crate::learning::Tool;
use crate::peripersonal::ReachTarget;
use crate::simulation::{ProbePath, Substance, Thing};

/// The study `tool`.
pub const STUDY: Study = Study {
    name: "tool",
    about: "a stick in the hand: whether its tip is learned by touching himself, and things are touched with it",
    touches: true,
    several: false,
    trials: Trials::of::<ToolTrial>(),
};

/// The name of the stick.
const STICK: &str = "stick";
/// How long sticks are, metres, and how thick.
const LENGTHS: [f64; 2] = [0.2, 0.5];
const RADII: [f64; 2] = [0.006, 0.01];
/// How far from where the hand points a stick leads: the tangent of the angle, at the most.
const ASLANT: f64 = 0.6;
/// How far a stick's end is from the middle of the receptor that holds it, metres, at the most along each axis.
const OFF: f64 = 0.008;
/// Ways that are tried of putting a stick into the hand.
const WAYS: usize = 30;
/// Things that are touched in a trial, small balls that a partner holds in the air …
const TARGETS: usize = 5;
const BALL: f64 = 0.025;
/// … and draws of each.
const DRAWS: usize = 3000;
/// How far beyond the bare hand's reach they are at the least, metres.
const BEYOND: f64 = 0.03;
/// Where the ball is while it is not touched, metres in the world.
const AWAY: Vector3<f64> = Vector3::new(-2.0, 0.0, 3.0);
/// How far over the table the stick is to be when it touches, metres.
const OVER: f64 = 0.05;
/// By which schema and which tip he acts.
const CONDITIONS: [&str; 2] = ["learned", "true"];

row! {
    /// A measurement of the study `tool`: a thing that was to be touched with the stick.
    pub struct ToolMeasurement {
        seed: u64 = "seed",
        hand: String = "hand",
        length_mm: f64 = "stick, mm",
        schema: String = "schema",
        known: bool = "tip known",
        learned_from: usize = "self-touches",
        tip_error_mm: f64 = "tip off, mm",
        within_mm: f64 = "known to, mm",
        beyond_mm: f64 = "beyond the hand, mm",
        first: bool = "at the first go",
        touched: bool = "touched",
        error_mm: f64 = "off by, mm",
        unintended: usize = "unintended",
        result: String = "result",
    }
}

row! {
    /// A row of the summary of the study `tool`.
    pub struct ToolSummary {
        schema: String = "schema",
        sticks: usize = "sticks",
        known: f64 = "tip known",
        learned_from: f64 = "from self-touches",
        tip_error_mm: f64 = "tip off, mm",
        worst_tip_mm: f64 = "at the most, mm",
        within_mm: f64 = "known to, mm",
        as_said: f64 = "as he says",
        things: usize = "things",
        first: f64 = "at the first go",
        touched: f64 = "with one correction",
        error_mm: f64 = "off by, mm",
        worst_error_mm: f64 = "95 %, mm",
        unintended: f64 = "unintended, share",
    }
}

/// A stick and how it is held.
struct HeldInTruth {
    hand: usize,
    receptor: usize,
    shape: [f64; 2],
    direction: Vector3<f64>,
    tool: Tool,
    /// The posture in which it is put into the hand.
    posture: Posture,
}

/// What he takes a stick's tip for in one condition.
#[derive(Debug, Serialize, Deserialize)]
struct KnownTip {
    /// Whether he takes himself to know it.
    known: bool,
    /// From so many touches of himself.
    touches: usize,
    /// How far off it is, metres; NaN where he does not know it.
    off: f64,
    /// How far off it may be by what he says, metres; NaN where he does not know it.
    within: f64,
}

/// What came of one trial.
#[derive(Debug, Default, Serialize, Deserialize)]
pub struct ToolTrial {
    measurements: Vec<ToolMeasurement>,
    /// For each condition; none where no stick was drawn.
    sticks: Vec<KnownTip>,
}

impl Trial for ToolTrial {
    type Setting = KnownBodies;
    type Measurement = ToolMeasurement;
    type Summary = ToolSummary;

    fn set_up(subject: &Subject) -> Result<KnownBodies, ExperimentError> {
        KnownBodies::of(subject)
    }

    fn run(subject: &Subject, bodies: &KnownBodies, seed: u64) -> Result<ToolTrial, ExperimentError> {
        let KnownBodies { learned, truth } = bodies;
        subject.tell(seed, "learning the stick");
        let mut trial = ToolTrial::default();
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let Some(held) = draw_stick(subject, truth, seed, &mut rng)? else { return Ok(trial) };
        let targets = targets(subject, truth, &held, seed, &mut rng)?;
        for (name, own) in CONDITIONS.into_iter().zip([learned, truth]) {
            let mut actor = with_stick(subject, own, &held, seed)?;
            let known = match name {
                "learned" => match actor.learn_stick() {
                    Ok(known) => known,
                    Err(Trouble::Engine(error)) => return Err(error.into()),
                    Err(_) => None,
                },
                _ => {
                    let by_truth = KnownStick { tool: held.tool, within: 0.0, touches: 0, by_tip: 0 };
                    actor.know_stick(by_truth);
                    Some(by_truth)
                }
            };
            let tip = KnownTip {
                known: known.is_some(),
                touches: known.map_or(0, |known| known.touches),
                off: known.map_or(f64::NAN, |known| (known.tool.tip - held.tool.tip).norm()),
                within: known.map_or(f64::NAN, |known| known.within),
            };
            for target in &targets {
                subject.tell(seed, name);
                let mut row = ToolMeasurement {
                    seed,
                    hand: HANDS[held.hand].into(),
                    length_mm: 1e3 * (held.tool.tip - held.tool.grip).norm(),
                    schema: name.into(),
                    known: tip.known,
                    learned_from: tip.touches,
                    tip_error_mm: 1e3 * tip.off,
                    within_mm: 1e3 * tip.within,
                    beyond_mm: 1e3 * target.beyond,
                    first: false,
                    touched: false,
                    error_mm: f64::NAN,
                    unintended: 0,
                    result: "tip not known".into(),
                };
                if tip.known {
                    touch(&mut actor, &held, target, &mut row)?;
                }
                trial.measurements.push(row);
            }
            trial.sticks.push(tip);
        }
        Ok(trial)
    }

    fn findings(_subject: &Subject, trials: &[ToolTrial]) -> Findings<ToolMeasurement, ToolSummary> {
        findings(trials)
    }
}

fn findings(trials: &[ToolTrial]) -> Findings<ToolMeasurement, ToolSummary> {
    let measurements: Vec<ToolMeasurement> =
        trials.iter().flat_map(|trial| trial.measurements.clone()).collect();
    let mut summary: Vec<ToolSummary> = Vec::new();
    for (k, name) in CONDITIONS.into_iter().enumerate() {
        let sticks = || trials.iter().filter_map(|trial| trial.sticks.get(k));
        let rows: Vec<&ToolMeasurement> = measurements.iter().filter(|row| row.schema == name).collect();
        let errors = || rows.iter().filter(|row| row.touched).map(|row| row.error_mm);
        let mut sorted: Vec<f64> = errors().collect();
        sorted.sort_by(f64::total_cmp);
        let known = || sticks().filter(|stick| stick.known);
        let tips = || known().map(|stick| 1e3 * stick.off);
        summary.push(ToolSummary {
            schema: name.into(),
            sticks: sticks().count(),
            known: share(sticks().map(|stick| stick.known)),
            learned_from: median(known().map(|stick| stick.touches as f64)),
            tip_error_mm: median(tips()),
            worst_tip_mm: tips().fold(f64::NAN, f64::max),
            within_mm: median(known().map(|stick| 1e3 * stick.within)),
            as_said: share(known().map(|stick| stick.off <= stick.within)),
            things: rows.len(),
            first: share(rows.iter().map(|row| row.first)),
            touched: share(rows.iter().map(|row| row.touched)),
            error_mm: median(errors()),
            worst_error_mm: crate::learning::annealing::quantile(&sorted, 0.95),
            unintended: share(rows.iter().map(|row| row.unintended > 0)),
        });
    }
    let notes = vec![
        "tip off: the centre of the learned stick's round end from the true one, in the hand's frame; medians over sticks \
         whose tip he takes himself to know. known to: how far off he says it may be, at 95 %; as he says: the share of \
         sticks of which that holds. things: balls of 25 mm radius, held in the air 3 cm or more beyond what any skin \
         of the bare hand reaches with the arm alone, where the true stick reaches; he is told where. off by: from the place \
         that he was to touch to the stick's true tip when it touches."
            .to_string(),
    ];
    let numbers = vec![
        ("known", json!(summary[0].known)),
        ("tip_error_mm", json!(summary[0].tip_error_mm)),
        ("worst_tip_mm", json!(summary[0].worst_tip_mm)),
        ("as_said", json!(summary[0].as_said)),
        ("success_first", json!(summary[0].first)),
        ("success", json!(summary[0].touched)),
        ("error_mm", json!(summary[0].error_mm)),
        ("unintended", json!(summary[0].unintended)),
        ("true_kinematics_success_first", json!(summary[1].first)),
        ("true_kinematics_success", json!(summary[1].touched)),
    ];
    let series = CONDITIONS.iter().enumerate().map(|(k, name)| {
        let rows = measurements.iter().filter(|row| row.schema == *name && row.touched);
        let dots = rows.map(|row| (row.error_mm, k as f64)).collect();
        PlotSeries { name: (*name).to_string(), line: Vec::new(), dots }
    });
    let plot = StudyPlot {
        x: PlotAxis {
            title: "from where he was to touch to the tip when it touches, mm",
            scale: AxisScale::Logarithmic,
        },
        y: PlotAxis {
            title: "",
            scale: AxisScale::Names(CONDITIONS.iter().map(|name| (*name).into()).collect()),
        },
        series: series.collect(),
    };
    Findings { summary, notes, plot, numbers, measurements }
}

/// A stick of some radius and half length, beside him, and a ball that is far away.
fn things([radius, half_length]: [f64; 2]) -> [Thing; 2] {
    let put = |name: &str, shape: Shape, at: Vector3<f64>| Thing {
        name: name.into(),
        shape,
        pose: Isometry3::from_parts(Translation3::from(at), UnitQuaternion::identity()),
        fixed: false,
        substance: Substance::default(),
    };
    [
        put(STICK, Shape::Capsule { radius, half_length }, Vector3::new(-1.0, 0.0, 1.0)),
        put(THING, Shape::Sphere { radius: BALL }, AWAY),
    ]
}

/// He stands at a table that he has felt, as yet without the stick.
fn at_table_with(
    subject: &Subject,
    own: &Knowledge,
    shape: [f64; 2],
    seed: u64,
) -> Result<OnStage, ExperimentError> {
    let mut actor = at_table(subject, own, &things(shape), seed)?;
    let thing = actor.the_thing()?;
    actor.stage.send_thing(thing, ProbePath(vec![(0.0, AWAY)]));
    let height = actor.table_top();
    actor.know_table(height);
    Ok(actor)
}

/// A stick of random size, held in a random hand and direction in which it meets nothing.
fn draw_stick(
    subject: &Subject,
    truth: &Knowledge,
    seed: u64,
    rng: &mut ChaCha8Rng,
) -> Result<Option<HeldInTruth>, ExperimentError> {
    let hand = rng.random_range(0..2);
    let length = rng.random_range(LENGTHS[0]..LENGTHS[1]);
    let shape = [rng.random_range(RADII[0]..RADII[1]), 0.5 * length];
    let mut actor = at_table_with(subject, truth, shape, seed)?;
    if let Err(Trouble::Engine(error)) = actor.hold_out(hand) {
        return Err(error.into());
    }
    let (receptor, posture) = (actor.grip_of(hand), actor.posture());
    let middle = truth.own.skin().receptors[receptor].position;
    let grip = middle + Vector3::from_fn(|_, _| rng.random_range(-OFF..OFF));
    let pointing = grip.try_normalize(1e-6).unwrap_or_else(Vector3::x);
    let across = crate::kinematics::tangent_basis(&pointing);
    for _ in 0..WAYS {
        let turn = rng.random_range(0.0..std::f64::consts::TAU);
        let aside = across.column(0) * turn.cos() + across.column(1) * turn.sin();
        let direction = (pointing + aside * rng.random_range(0.0..ASLANT)).normalize();
        let tip = grip + direction * length;
        let tool = Tool { limb: actor.hands[hand].limb, grip, tip, radius: shape[0] };
        let held = HeldInTruth { hand, receptor, shape, direction, tool, posture: posture.clone() };
        if give(&actor, &held)? {
            return Ok(Some(held));
        }
    }
    Ok(None)
}

fn give(actor: &OnStage, held: &HeldInTruth) -> Result<bool, ExperimentError> {
    let stick = actor.stage.thing(STICK);
    let stick = stick.ok_or_else(|| ExperimentError::refused("the stick is not on the stage"))?;
    Ok(actor.stage.give_stick(stick, held.receptor, &held.tool.grip, &held.direction)?)
}

/// He stands at the table with the stick in his hand, of which he knows nothing yet.
fn with_stick(
    subject: &Subject,
    own: &Knowledge,
    held: &HeldInTruth,
    seed: u64,
) -> Result<OnStage, ExperimentError> {
    let mut actor = at_table_with(subject, own, held.shape, seed)?;
    actor.place(&held.posture)?;
    if !give(&actor, held)? {
        return Err(ExperimentError::refused("there is no room for the stick"));
    }
    let stick = actor.stage.thing(STICK).unwrap_or_default();
    actor.was_given_stick(held.hand, held.receptor, stick);
    Ok(actor)
}

/// A place to be touched with the stick.
struct StickTarget {
    aim: ReachTarget,
    /// How far it is beyond what the bare hand reaches, metres.
    beyond: f64,
}

/// Places that the true stick reaches in some posture with nothing in anything else, and the true hand does not.
fn targets(
    subject: &Subject,
    truth: &Knowledge,
    held: &HeldInTruth,
    seed: u64,
    rng: &mut ChaCha8Rng,
) -> Result<Vec<StickTarget>, ExperimentError> {
    let mut actor = with_stick(subject, truth, held, seed)?;
    let bare = actor.hands[held.hand].receptors.clone();
    actor.know_stick(KnownStick { tool: held.tool, within: 0.0, touches: 0, by_tip: 0 });
    let arm = actor.hands[held.hand].arm.clone();
    let ready = actor.ready();
    let clearance = actor.clearance.moved_by(&actor.own, &arm);
    let height = actor.table_top() + OVER;
    let mut found = Vec::new();
    for _ in 0..DRAWS {
        if found.len() == TARGETS {
            break;
        }
        let posture = actor.own.random_posture(&ready, &arm, rng);
        let frames = actor.own.frames(&posture);
        let frame = &frames[held.tool.limb];
        let (tip, direction) = (frame.point(&held.tool.tip), frame.direction(&held.direction));
        let point = tip + direction * held.tool.radius;
        let before_him = point.dot(&actor.front) > 0.1 && point.dot(&actor.up) > height;
        if !before_him || !clearance.free(&frames, 0.01) {
            continue;
        }
        let aim = ReachTarget { point, direction };
        let beyond = beyond_hand(&mut actor, &bare, &arm, &aim, &ready);
        if beyond >= BEYOND {
            found.push(StickTarget { aim, beyond });
        }
    }
    Ok(found)
}

/// How near the bare hand comes to a place at the most, by the arm alone, metres.
fn beyond_hand(
    actor: &mut OnStage,
    receptors: &[usize],
    arm: &[usize],
    aim: &ReachTarget,
    ready: &[f64],
) -> f64 {
    let places: Vec<Place> = receptors.iter().map(|&receptor| actor.own.place(receptor)).collect();
    let anyhow = ReachTarget { direction: Vector3::zeros(), ..*aim };
    let reaching = actor.reaching(arm.to_vec());
    let miss =
        |place: Place| reaching.solve(Place { direction: Vector3::zeros(), ..place }, &anyhow, ready).miss;
    places.into_iter().map(miss).fold(f64::INFINITY, f64::min)
}

/// Lets him touch the ball that is held at a place, with the stick, and measures.
fn touch(
    actor: &mut OnStage,
    held: &HeldInTruth,
    target: &StickTarget,
    row: &mut ToolMeasurement,
) -> Result<(), ExperimentError> {
    let ready: Posture = actor.ready();
    // Where he cannot, he begins from where he is.
    if let Err(Trouble::Engine(error)) = actor.go(&ready) {
        return Err(error.into());
    }
    let thing = actor.the_thing()?;
    let ReachTarget { point, direction } = target.aim;
    let x_wr = actor.stage.root_pose();
    let middle = (x_wr * Point3::from(point + direction * BALL)).coords;
    let now = actor.stage.time();
    actor.stage.send_thing(thing, ProbePath(vec![(now, middle)]));
    let receptor = actor.hands[held.hand].tip;
    let found = FoundThing { receptor, thing, posture: actor.posture(), point, direction };
    actor.unintended = 0;
    let result = actor.touch_with_stick(&found, false, 1);
    row.unintended = actor.unintended;
    row.result = match result {
        Ok(touching) if touching.found.thing == thing => {
            row.touched = true;
            row.first = touching.corrections == 0;
            let tip = actor.stage.limb_pose(held.tool.limb) * Point3::from(held.tool.tip);
            let aim = x_wr * Point3::from(point);
            row.error_mm = 1e3 * ((aim - tip).norm() - held.tool.radius).abs();
            "touched".into()
        }
        Ok(_) => "something else".into(),
        Err(Trouble::Engine(error)) => return Err(error.into()),
        Err(trouble) => trouble.to_string(),
    };
    let now = actor.stage.time();
    actor.stage.send_thing(thing, ProbePath(vec![(now, AWAY)]));
    Ok(())
}
