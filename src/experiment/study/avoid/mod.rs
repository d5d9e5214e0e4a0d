//! Whether a creature gets out of the way of what comes near, keeps still what is not in its way, and does meanwhile what it
//! was about, held against what any posture can do.

mod attempt;
mod coming;
mod oracle;

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use serde_json::{Value, json};

use self::attempt::{Outcome, Task, attempt};
use self::coming::{Coming, draw, thing};
use self::oracle::{Avoidable, Oracle};
use super::at_table::{Knowledge, OnStage};
use super::plot::{AxisScale, PlotAxis, PlotSeries, StudyPlot};
use super::subject::{Subject, median, share};
use super::table::row;
use super::{Findings, Study};
use crate::creature::Posture;
use crate::experiment::ExperimentError;

/// The study `avoid`.
pub const STUDY: Study = Study {
    name: "avoid",
    about: "whether limbs that something approaches get out of its way, of what any posture avoids",
    touches: true,
    several: false,
    measure: |subject| Ok(measure(subject, false)?.into()),
};

/// The study `avoid-busy`.
pub const BUSY: Study = Study {
    name: "avoid-busy",
    about: "the same while a hand stays at a place or follows a circle",
    touches: true,
    several: false,
    measure: |subject| Ok(measure(subject, true)?.into()),
};

/// A limb that moves less than this keeps still, metres.
const STILL: f64 = 0.01;
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

/// A trial of one creature.
struct Trial {
    aimed: usize,
    avoidable: Avoidable,
    /// What a second search found where the first found none.
    again: bool,
    task_possible: bool,
    outcome: Outcome,
}

impl Trial {
    fn untouched(&self) -> bool {
        self.outcome.touched.is_none()
    }
}

/// Measures; a trial that does not succeed is a finding.
///
/// # Errors
/// Where something cannot be measured at all.
pub fn measure(
    subject: &Subject,
    busy: bool,
) -> Result<Findings<AvoidMeasurement, AvoidSummary>, ExperimentError> {
    let learned = Knowledge::new(subject.own_body(subject.seeds[0])?);
    let truth = Knowledge::new(learned.own.with_schema(subject.truth().schema.clone()));
    let creature = &subject.body().creature;
    // What nothing moves cannot avoid anything.
    let moves = |aura: &usize| {
        let limbs = &creature.aura_limbs()[*aura].limbs;
        !limbs.contains(&0) && !truth.own.receptors_on(limbs).is_empty()
    };
    let auras: Vec<usize> = (0..creature.aura_limbs().len()).filter(moves).collect();
    if auras.is_empty() {
        return Err(ExperimentError::unfit(
            subject.model(),
            "no limb of it with receptors moves".to_string(),
        ));
    }
    let mut measurements: Vec<AvoidMeasurement> = Vec::new();
    let mut trials: [Vec<Trial>; 2] = Default::default();
    let (mut drawn_again, mut undrawn, mut postures) = (0, 0, 0);
    for (number, &seed) in subject.seeds.iter().enumerate() {
        subject.tell(seed, "avoiding");
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let (thing, kind) = thing(&mut rng);
        let mut actor = OnStage::new(subject, &truth, vec![thing.clone()], seed)?;
        let raised = rng.random_bool(0.5);
        let beginnings = beginnings(&mut actor, &truth, raised, &mut rng);
        let aimed = auras[number % auras.len()];
        let Some((coming, draws)) = draw(&mut actor, &thing, aimed, &beginnings, &mut rng)? else {
            undrawn += 1;
            continue;
        };
        drawn_again += draws;
        let task = busy.then(|| Task {
            hand: rng.random_range(0..2),
            radius: if rng.random_bool(0.5) { CIRCLE[0] } else { 0.0 },
            period: CIRCLE[1],
        });
        let oracle =
            Oracle::new(&truth, &coming, &actor.stage.root_pose(), actor.hands.each_ref().map(|h| h.limb));
        let avoidable = oracle.search(seed);
        postures += avoidable.postures;
        let again = avoidable.any || oracle.search(!seed).any;
        let task_possible = task.is_some_and(|task| possible(&actor, &truth, &oracle, &coming, task, seed));
        for (k, (name, known)) in [("learned", &learned), ("true", &truth)].into_iter().enumerate() {
            let outcome = attempt(&mut actor, known, &truth, &coming, task)?;
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
            trials[k].push(Trial { aimed, avoidable, again, task_possible, outcome });
        }
    }
    let mut summary: Vec<AvoidSummary> = Vec::new();
    for (name, trials) in ["learned", "true"].into_iter().zip(&trials) {
        summary.push(summarised(name, "all", &trials.iter().collect::<Vec<_>>()));
        for &aura in &auras {
            let of: Vec<&Trial> = trials.iter().filter(|trial| trial.aimed == aura).collect();
            if !of.is_empty() {
                summary.push(summarised(name, &creature.aura_limbs()[aura].name, &of));
            }
        }
    }
    let numbers = numbers(&trials, &summary, [drawn_again, undrawn]);
    let count = |holds: &dyn Fn(&Trial) -> bool| trials[1].iter().filter(|trial| holds(trial)).count();
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
            count(&|trial| trial.avoidable.any),
            trials[1].len(),
            count(&|trial| trial.avoidable.in_time),
            count(&|trial| trial.again),
        ),
        "others: all limbs but those that the thing would meet, those between them and the root, those that they carry \
         where these are not both arms, and an arm at a task."
            .to_string(),
    ];
    if busy {
        notes.push(format!(
            "At the task: the hand's tip is within 2 cm of where it is to be in at least {:.0} % of the time, of the trials \
             in which some posture avoids the thing with the tip there, whenever the thing is near.",
            100.0 * DOES
        ));
    }
    let series =
        ["learned", "true"].into_iter().zip(&trials).enumerate().map(|(k, (name, trials))| PlotSeries {
            name: name.to_string(),
            line: Vec::new(),
            dots: trials.iter().map(|trial| ((1e3 * trial.outcome.moved[0]).max(0.01), k as f64)).collect(),
        });
    let plot = StudyPlot {
        x: PlotAxis {
            title: "how far limbs that were not threatened moved, mm",
            scale: AxisScale::Logarithmic,
        },
        y: PlotAxis { title: "", scale: AxisScale::Names(vec!["learned".into(), "true".into()]) },
        series: series.collect(),
    };
    Ok(Findings { measurements, summary, notes, plot, numbers })
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

fn summarised(schema: &str, limb: &str, of: &[&Trial]) -> AvoidSummary {
    let rate = |holds: &dyn Fn(&Trial) -> bool| share(of.iter().map(|trial| holds(trial)));
    let avoidable: Vec<&&Trial> = of.iter().filter(|trial| trial.avoidable.any).collect();
    let possible: Vec<&&Trial> = of.iter().filter(|trial| trial.task_possible).collect();
    AvoidSummary {
        schema: schema.into(),
        limb: limb.into(),
        trials: of.len(),
        avoidable: avoidable.len(),
        no_touch: share(avoidable.iter().map(|trial| trial.untouched())),
        all_no_touch: rate(&Trial::untouched),
        others_still: rate(&|trial| trial.outcome.moved[0] < STILL),
        moved_mm: 1e3 * median(of.iter().map(|trial| trial.outcome.moved[0])),
        self_touch: rate(&|trial| trial.outcome.itself),
        task_possible: possible.len(),
        at_task: share(possible.iter().map(|trial| trial.outcome.at_task >= DOES)),
        time_at_task: possible.iter().map(|trial| trial.outcome.at_task).sum::<f64>() / possible.len() as f64,
    }
}

/// What a program asks for by name.
fn numbers(
    trials: &[Vec<Trial>; 2],
    summary: &[AvoidSummary],
    [drawn_again, undrawn]: [usize; 2],
) -> Vec<(&'static str, Value)> {
    let [own, real] = trials;
    let among = |of: &[Trial], which: &dyn Fn(&Trial) -> bool| {
        share(of.iter().filter(|trial| which(trial)).map(Trial::untouched))
    };
    let rate = |of: &[Trial], holds: &dyn Fn(&Trial) -> bool| share(of.iter().map(holds));
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
        ("avoidable", json!(rate(own, &|trial| trial.avoidable.any))),
        ("avoidable_in_time", json!(rate(own, &|trial| trial.avoidable.in_time))),
        ("avoidable_by_twice_the_search", json!(rate(own, &|trial| trial.again))),
        ("no_touch_of_avoidable", json!(among(own, &|trial| trial.avoidable.any))),
        ("no_touch_of_avoidable_in_time", json!(among(own, &|trial| trial.avoidable.in_time))),
        (
            "no_touch_though_no_posture_was_found",
            json!(own.iter().filter(|trial| !trial.again && trial.untouched()).count()),
        ),
        ("no_touch", json!(rate(own, &Trial::untouched))),
        ("others_still", json!(rate(own, &|trial| trial.outcome.moved[0] < STILL))),
        ("others_still_but_carried", json!(rate(own, &|trial| trial.outcome.moved[1] < STILL))),
        ("self_touch", json!(rate(own, &|trial| trial.outcome.itself))),
        ("at_task", task("learned", |row| row.at_task)),
        ("time_at_task", task("learned", |row| row.time_at_task)),
        ("true_kinematics_no_touch_of_avoidable", json!(among(real, &|trial| trial.avoidable.any))),
        ("true_kinematics_no_touch", json!(rate(real, &Trial::untouched))),
        ("true_kinematics_others_still", json!(rate(real, &|trial| trial.outcome.moved[0] < STILL))),
        ("true_kinematics_at_task", task("true", |row| row.at_task)),
        ("by_limb", Value::Object(by_limb)),
        ("drawn_again", json!(drawn_again)),
        ("undrawn", json!(undrawn)),
    ]
}
