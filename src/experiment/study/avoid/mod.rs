//! Whether a creature gets out of the way of what comes near, keeps still what is not in its way, and does meanwhile what it
//! was about, held against what any posture can do.

mod attempt;
mod coming;
mod oracle;

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use serde::{Deserialize, Serialize};
use serde_json::{Value, json};

use self::attempt::{Task, attempt};
use self::coming::{Coming, draw, thing};
use self::oracle::Oracle;
use super::at_table::{Knowledge, KnownBodies, OnStage};
use super::plot::{AxisScale, PlotAxis, PlotSeries, StudyPlot};
use super::subject::{Subject, median, share};
use super::table::row;
use super::{Findings, Study, Trial, Trials};
use crate::creature::Posture;
use crate::experiment::ExperimentError;

/// The study `avoid`.
pub const STUDY: Study = Study {
    name: "avoid",
    about: "whether limbs that something approaches get out of its way, of what any posture avoids",
    touches: true,
    several: false,
    trials: Trials::of::<AvoidTrial<false>>(),
};

/// The study `avoid-busy`.
pub const BUSY: Study = Study {
    name: "avoid-busy",
    about: "the same while a hand stays at a place or follows a circle",
    touches: true,
    several: false,
    trials: Trials::of::<AvoidTrial<true>>(),
};

/// By which schema it acts.
const CONDITIONS: [&str; 2] = ["learned", "true"];
/// A limb that moves less than this keeps still, millimetres.
const STILL: f64 = 10.0;
/// How far limbs are apart at first, metres.
const APART: f64 = 0.015;
/// A hand that is at its task for this share of the time does its task.
const DOES: f64 = 0.95;
/// The circle that a hand follows: its radius, metres, and how long it takes, seconds.
const CIRCLE: [f64; 2] = [0.05, 8.0];
/// Places of a task that are asked after, while the thing is nearer than this to who holds still, metres.
const ASKED: usize = 4;
const NEAR: f64 = 0.1;

row! {
    /// A measurement of the studies `avoid` and `avoid-busy`.
    pub struct AvoidMeasurement {
        seed: u64 = "seed",
        schema: String = "schema",
        limb: String = "aimed at",
        shape: String = "shape",
        posture: String = "posture",
        task: String = "task",
        speed_m_s: f64 = "speed, m/s",
        avoidable: bool = "some posture avoids it",
        avoidable_in_time: bool = "one in time",
        avoidable_twice: bool = "some posture of a second search",
        no_touch: bool = "no touch",
        touched_limb: String = "touched",
        moved_mm: f64 = "others moved, mm",
        moved_but_carried_mm: f64 = "others but carried ones moved, mm",
        self_touch: bool = "an arm touched the body",
        plans: usize = "plans",
        task_possible: bool = "some posture avoids it at the task",
        at_task: f64 = "share of the time at the task",
    }
}

row! {
    /// A row of the summary of the studies `avoid` and `avoid-busy`.
    pub struct AvoidSummary {
        schema: String = "schema",
        limb: String = "aimed at",
        trials: usize = "trials",
        avoidable: usize = "some posture avoids it",
        no_touch: f64 = "of these no touch",
        all_no_touch: f64 = "of all no touch",
        others_still: f64 = "others still",
        moved_mm: f64 = "others moved, mm (median)",
        self_touch: f64 = "an arm touched the body",
        task_possible: usize = "some posture avoids it at the task",
        at_task: f64 = "of these at the task",
        time_at_task: f64 = "share of the time at the task",
    }
}

/// What came of one trial, while the creature has nothing to do or, `BUSY`, a task.
#[derive(Debug, Default, Serialize, Deserialize)]
pub struct AvoidTrial<const BUSY: bool> {
    /// By the learned body and by the true one; none where no way was drawn.
    measurements: Vec<AvoidMeasurement>,
    /// Ways that did not meet the limb that they aimed at first.
    drawn_again: usize,
    /// Postures that were looked at.
    postures: usize,
}

/// What trials share.
pub struct AvoidSetting {
    bodies: KnownBodies,
    /// The aura limbs that are aimed at in turn.
    auras: Vec<usize>,
}

impl<const BUSY: bool> Trial for AvoidTrial<BUSY> {
    type Setting = AvoidSetting;
    type Measurement = AvoidMeasurement;
    type Summary = AvoidSummary;

    fn set_up(subject: &Subject) -> Result<AvoidSetting, ExperimentError> {
        let bodies = KnownBodies::of(subject)?;
        let creature = &subject.body().creature;
        // What nothing moves cannot avoid anything.
        let moves = |aura: &usize| {
            let limbs = &creature.aura_limbs()[*aura].limbs;
            !limbs.contains(&0) && !bodies.truth.own.receptors_on(limbs).is_empty()
        };
        let auras: Vec<usize> = (0..creature.aura_limbs().len()).filter(moves).collect();
        if auras.is_empty() {
            return Err(ExperimentError::unfit(
                subject.model(),
                "no limb of it with receptors moves".to_string(),
            ));
        }
        Ok(AvoidSetting { bodies, auras })
    }

    fn run(
        subject: &Subject,
        setting: &AvoidSetting,
        seed: u64,
    ) -> Result<AvoidTrial<BUSY>, ExperimentError> {
        let AvoidSetting { bodies: KnownBodies { learned, truth }, auras } = setting;
        let creature = &subject.body().creature;
        let number = subject.number(seed);
        let number =
            number.ok_or_else(|| ExperimentError::refused(format!("no trial has the seed {seed}")))?;
        subject.tell(seed, "avoiding");
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let (thing, kind) = thing(&mut rng);
        let mut actor = OnStage::new(subject, truth, vec![thing.clone()], seed)?;
        let raised = rng.random_bool(0.5);
        let beginnings = beginnings(&mut actor, truth, raised, &mut rng);
        let aimed = auras[number % auras.len()];
        let Some((coming, drawn_again)) = draw(&mut actor, &thing, aimed, &beginnings, &mut rng)? else {
            return Ok(AvoidTrial::default());
        };
        let task = BUSY.then(|| Task {
            hand: rng.random_range(0..2),
            radius: if rng.random_bool(0.5) { CIRCLE[0] } else { 0.0 },
            period: CIRCLE[1],
        });
        let oracle =
            Oracle::new(truth, &coming, &actor.stage.root_pose(), actor.hands.each_ref().map(|h| h.limb));
        let avoidable = oracle.search(seed);
        let again = avoidable.any || oracle.search(!seed).any;
        let task_possible = task.is_some_and(|task| possible(&actor, truth, &oracle, &coming, task, seed));
        let mut measurements = Vec::new();
        for (name, known) in CONDITIONS.into_iter().zip([learned, truth]) {
            let outcome = attempt(&mut actor, known, truth, &coming, task)?;
            measurements.push(AvoidMeasurement {
                seed,
                schema: name.into(),
                limb: creature.aura_limbs()[aimed].name.clone(),
                shape: kind.into(),
                posture: if raised { "hands raised" } else { "random arms" }.into(),
                task: task.map_or("none", |task| if task.radius > 0.0 { "circle" } else { "place" }).into(),
                speed_m_s: coming.speed,
                avoidable: avoidable.any,
                avoidable_in_time: avoidable.in_time,
                avoidable_twice: again,
                no_touch: outcome.touched.is_none(),
                touched_limb: outcome
                    .touched
                    .map_or("none".to_string(), |limb| creature.limbs()[limb].clone()),
                moved_mm: 1e3 * outcome.moved[0],
                moved_but_carried_mm: 1e3 * outcome.moved[1],
                self_touch: outcome.itself,
                plans: outcome.plans,
                task_possible,
                at_task: outcome.at_task,
            });
        }
        Ok(AvoidTrial { measurements, drawn_again, postures: avoidable.postures })
    }

    fn findings(subject: &Subject, trials: &[AvoidTrial<BUSY>]) -> Findings<AvoidMeasurement, AvoidSummary> {
        findings(subject, trials)
    }
}

fn findings<const BUSY: bool>(
    subject: &Subject,
    trials: &[AvoidTrial<BUSY>],
) -> Findings<AvoidMeasurement, AvoidSummary> {
    let measurements: Vec<AvoidMeasurement> =
        trials.iter().flat_map(|trial| trial.measurements.clone()).collect();
    let drawn_again: usize = trials.iter().map(|trial| trial.drawn_again).sum();
    let undrawn = trials.iter().filter(|trial| trial.measurements.is_empty()).count();
    let postures: usize = trials.iter().map(|trial| trial.postures).sum();
    let rows = CONDITIONS
        .map(|name| measurements.iter().filter(|row| row.schema == name).collect::<Vec<&AvoidMeasurement>>());
    let mut summary: Vec<AvoidSummary> = Vec::new();
    for (name, rows) in CONDITIONS.into_iter().zip(&rows) {
        summary.push(summarised(name, "all", rows));
        for aura in subject.body().creature.aura_limbs() {
            let of: Vec<&AvoidMeasurement> =
                rows.iter().copied().filter(|row| row.limb == aura.name).collect();
            if !of.is_empty() {
                summary.push(summarised(name, &aura.name, &of));
            }
        }
    }
    let numbers = numbers(&rows, &summary, [drawn_again, undrawn]);
    let real = &rows[1];
    let count = |holds: fn(&AvoidMeasurement) -> bool| real.iter().filter(|row| holds(row)).count();
    let mut notes = vec![
        "Spheres, boxes and capsules of 2 to 5 cm half size come straight from 0.7 to 1 m at 0.1 to 0.5 m/s and go on by \
         0.5 m, whatever they meet. All limbs that joints move are aimed at in turn."
            .to_string(),
        format!(
            "Each would hit the limb that it aims at first if the creature held still; {drawn_again} ways that would not \
             were drawn again, and {undrawn} trials had none."
        ),
        format!(
            "some posture avoids it: found by the truth, keeping clear of all that the thing passes and of the body. {} of \
             {} approaches are so, {} by a posture that can be gone straight to in the time left; a second search as \
             thorough finds {}. {postures} postures were looked at.",
            count(|row| row.avoidable),
            real.len(),
            count(|row| row.avoidable_in_time),
            count(|row| row.avoidable_twice),
        ),
        "others: all limbs but those that the thing would meet, those between them and the root, those that they carry \
         where these are not both arms, and an arm at a task."
            .to_string(),
    ];
    if BUSY {
        notes.push(format!(
            "At the task: the hand's tip is within 2 cm of where it is to be in at least {:.0} % of the time, of the trials \
             in which some posture avoids the thing with the tip there, whenever the thing is near.",
            100.0 * DOES
        ));
    }
    let series = CONDITIONS.into_iter().zip(&rows).enumerate().map(|(k, (name, rows))| PlotSeries {
        name: name.to_string(),
        line: Vec::new(),
        dots: rows.iter().map(|row| (row.moved_mm.max(0.01), k as f64)).collect(),
    });
    let plot = StudyPlot {
        x: PlotAxis {
            title: "how far limbs that were not threatened moved, mm",
            scale: AxisScale::Logarithmic,
        },
        y: PlotAxis { title: "", scale: AxisScale::Names(CONDITIONS.map(String::from).into()) },
        series: series.collect(),
    };
    Findings { summary, notes, plot, numbers, measurements }
}

/// Postures to begin with: hands raised, or arms anywhere where they touch nothing.
fn beginnings(actor: &mut OnStage, truth: &Knowledge, raised: bool, rng: &mut ChaCha8Rng) -> Vec<Posture> {
    let ready = actor.ready();
    if raised {
        return vec![ready];
    }
    let joints = actor.arms();
    let at_ease = [truth.own.frames(&truth.own.at_ease())];
    let clearance = truth.clearance.moved_by(&truth.own, &joints).eased_at(&at_ease, APART);
    (0..2000)
        .map(|_| truth.own.random_posture(&ready, &joints, rng))
        .filter(|posture| clearance.free(&truth.own.frames(posture), APART))
        .take(20)
        .collect()
}

/// Whether some posture avoids the thing at each of a few places that the task has the hand at while the thing is near.
fn possible(
    actor: &OnStage,
    truth: &Knowledge,
    oracle: &Oracle,
    coming: &Coming,
    task: Task,
    seed: u64,
) -> bool {
    let place = task.place(actor, &truth.own);
    let begin = truth.own.frames(&coming.posture)[place.limb].point(&place.point);
    let frames = truth.own.frames(&coming.posture);
    const MOMENTS: usize = 60;
    let near: Vec<usize> =
        (0..=MOMENTS).filter(|&k| oracle.gap(&frames, [k as f64 / MOMENTS as f64; 2], NEAR) < NEAR).collect();
    let (Some(first), Some(last)) = (near.first(), near.last()) else { return true };
    let seconds = (coming.ends[1] - coming.ends[0]).norm() / coming.speed;
    let asked = if task.radius > 0.0 { ASKED } else { 1 };
    (0..asked).all(|k| {
        let share = k as f64 / ASKED.max(2) as f64;
        let moment = (*first as f64 + share * (last - first) as f64) / MOMENTS as f64;
        let [target, _] = task.at(&begin, &actor.up, &actor.front, moment * seconds);
        oracle.keeps_task(place, target, &actor.hands[task.hand].arm, seed)
    })
}

fn summarised(schema: &str, limb: &str, of: &[&AvoidMeasurement]) -> AvoidSummary {
    let rate = |holds: fn(&AvoidMeasurement) -> bool| share(of.iter().map(|row| holds(row)));
    let avoidable: Vec<&&AvoidMeasurement> = of.iter().filter(|row| row.avoidable).collect();
    let possible: Vec<&&AvoidMeasurement> = of.iter().filter(|row| row.task_possible).collect();
    AvoidSummary {
        schema: schema.into(),
        limb: limb.into(),
        trials: of.len(),
        avoidable: avoidable.len(),
        no_touch: share(avoidable.iter().map(|row| row.no_touch)),
        all_no_touch: rate(|row| row.no_touch),
        others_still: rate(|row| row.moved_mm < STILL),
        moved_mm: median(of.iter().map(|row| row.moved_mm)),
        self_touch: rate(|row| row.self_touch),
        task_possible: possible.len(),
        at_task: share(possible.iter().map(|row| row.at_task >= DOES)),
        time_at_task: possible.iter().map(|row| row.at_task).sum::<f64>() / possible.len() as f64,
    }
}

/// What a program asks for by name.
fn numbers(
    rows: &[Vec<&AvoidMeasurement>; 2],
    summary: &[AvoidSummary],
    [drawn_again, undrawn]: [usize; 2],
) -> Vec<(&'static str, Value)> {
    type Holds = fn(&AvoidMeasurement) -> bool;
    let [own, real] = rows;
    let among = |of: &[&AvoidMeasurement], which: Holds| {
        share(of.iter().filter(|row| which(row)).map(|row| row.no_touch))
    };
    let rate = |of: &[&AvoidMeasurement], holds: Holds| share(of.iter().map(|row| holds(row)));
    let by_limb: serde_json::Map<String, Value> = summary
        .iter()
        .filter(|row| row.schema == "learned")
        .map(|row| {
            let numbers = json!({
                "trials": row.trials,
                "avoidable": row.avoidable,
                "no_touch": row.no_touch,
                "others_still": row.others_still,
            });
            (row.limb.clone(), numbers)
        })
        .collect();
    let all = |schema: &str| summary.iter().find(|row| row.schema == schema && row.limb == "all");
    let task = |schema: &str, of: fn(&AvoidSummary) -> f64| json!(all(schema).map(of));
    vec![
        ("avoidable", json!(rate(own, |row| row.avoidable))),
        ("avoidable_in_time", json!(rate(own, |row| row.avoidable_in_time))),
        ("avoidable_by_twice_the_search", json!(rate(own, |row| row.avoidable_twice))),
        ("no_touch_of_avoidable", json!(among(own, |row| row.avoidable))),
        ("no_touch_of_avoidable_in_time", json!(among(own, |row| row.avoidable_in_time))),
        (
            "no_touch_though_no_posture_was_found",
            json!(own.iter().filter(|row| !row.avoidable_twice && row.no_touch).count()),
        ),
        ("no_touch", json!(rate(own, |row| row.no_touch))),
        ("others_still", json!(rate(own, |row| row.moved_mm < STILL))),
        ("others_still_but_carried", json!(rate(own, |row| row.moved_but_carried_mm < STILL))),
        ("self_touch", json!(rate(own, |row| row.self_touch))),
        ("at_task", task("learned", |row| row.at_task)),
        ("time_at_task", task("learned", |row| row.time_at_task)),
        ("true_kinematics_no_touch_of_avoidable", json!(among(real, |row| row.avoidable))),
        ("true_kinematics_no_touch", json!(rate(real, |row| row.no_touch))),
        ("true_kinematics_others_still", json!(rate(real, |row| row.moved_mm < STILL))),
        ("true_kinematics_at_task", task("true", |row| row.at_task)),
        ("by_limb", Value::Object(by_limb)),
        ("drawn_again", json!(drawn_again)),
        ("undrawn", json!(undrawn)),
    ]
}
