//! Whether a creature gets out of the way of what comes near, and keeps still what is not in its way. Long, as a study is
//! one file: here are the paths that are drawn, the attempts, and what is told of them.

use std::collections::BTreeSet;

use nalgebra::{Isometry3, Point3, Translation3, UnitQuaternion, Vector3};
use rand::seq::IndexedRandom;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use serde_json::{Value, json};

use super::at_table::{HANDS, Knowledge, OnStage, THING};
use super::plot::{AxisScale, PlotAxis, PlotSeries, StudyPlot};
use super::subject::{Subject, median, share};
use super::table::row;
use super::{Findings, Study};
use crate::creature::Posture;
use crate::experiment::ExperimentError;
use crate::geometry::Shape;
use crate::interaction::{Actor, Avoiding};
use crate::senses::{SkinContact, Toucher};
use crate::simulation::{ProbePath, Substance, Thing};

/// The study `avoid`.
pub const STUDY: Study = Study {
    name: "avoid",
    about: "whether a limb that something approaches gets out of its way, and the others keep still",
    touches: true,
    several: false,
    measure: |subject| Ok(measure(subject)?.into()),
};

/// Draws of a way until there is one that threatens one part of the body alone.
const DRAWS: usize = 200;
/// How fast a way is tried, metres a second.
const TRIED: f64 = 2.5;
/// How far things go on beyond where they aim, metres.
const BEYOND: f64 = 0.5;
/// A limb that moves less than this keeps still, metres.
const STILL: f64 = 0.01;
/// How far limbs are apart at first, metres.
const APART: f64 = 0.015;
/// Every how many steps the limbs are measured.
const EVERY: usize = 10;

row! {
    /// A measurement of the study `avoid`.
    pub struct AvoidMeasurement {
        seed: u64 = "seed",
        schema: String = "schema",
        limb: String = "aimed at",
        shape: String = "shape",
        posture: String = "posture",
        speed_m_s: f64 = "speed, m/s",
        no_touch: bool = "no touch",
        touched_limb: String = "touched",
        moved_mm: f64 = "others moved, mm",
        moved_but_carried_mm: f64 = "others but carried ones moved, mm",
        self_touch: bool = "an arm touched the body",
        plans: usize = "plans",
    }
}

row! {
    /// A row of the summary of the study `avoid`.
    pub struct AvoidSummary {
        schema: String = "schema",
        limb: String = "aimed at",
        trials: usize = "trials",
        no_touch: f64 = "no touch",
        others_still: f64 = "others still",
        moved_mm: f64 = "others moved, mm (median)",
        self_touch: f64 = "an arm touched the body",
    }
}

/// A thing and how it comes, which every creature of a trial meets alike.
struct ThreateningPath {
    /// The aura limb that it aims at.
    aimed: usize,
    posture: Posture,
    /// Where it sets out and where it ends, in the world, metres.
    ends: [Vector3<f64>; 2],
    speed: f64,
}

/// What came of it.
struct AvoidanceOutcome {
    aimed: usize,
    touched: Option<usize>,
    /// How far others moved, metres: all, and all but those that the one aimed at carries.
    moved: [f64; 2],
    itself: bool,
    plans: usize,
}

impl ThreateningPath {
    /// Its way from a time on, at a speed of metres a second.
    fn path(&self, time: f64, speed: f64) -> ProbePath {
        let seconds = (self.ends[1] - self.ends[0]).norm() / speed;
        ProbePath(vec![(time, self.ends[0]), (time + seconds, self.ends[1])])
    }
}

/// A random shape of 2 to 5 cm half size.
fn shape(rng: &mut ChaCha8Rng) -> (Shape, &'static str) {
    let mut size = || rng.random_range(0.02..0.05);
    let (a, b, c) = (size(), size(), size());
    match rng.random_range(0..3) {
        0 => (Shape::Sphere { radius: a }, "sphere"),
        1 => (Shape::Box { half_extents: [a, b, c] }, "box"),
        // As long as it is wide at least, 5 cm half at most.
        _ => {
            let radius = 0.5 * a.min(b) + 0.01;
            (Shape::Capsule { radius, half_length: a.max(b) - radius }, "capsule")
        }
    }
}

/// The arm that a limb is on, its clavicle left out; none for the trunk and the head.
fn arm(actor: &Actor, limb: usize) -> Option<usize> {
    actor.hands.iter().position(|hand| actor.own.carried_by(hand.arm[1.min(hand.arm.len() - 1)] + 1)[limb])
}

/// A way that threatens one part of the body alone, and how many draws did not.
fn draw(
    actor: &mut OnStage,
    thing: usize,
    postures: &[Posture],
    rng: &mut ChaCha8Rng,
) -> Result<Option<(ThreateningPath, usize)>, ExperimentError> {
    let creature = actor.own.creature().clone();
    // What nothing moves cannot avoid anything.
    let limbs = |aura: usize| {
        creature.aura_limbs()[aura].limbs.iter().copied().filter(|&limb| limb > 0).collect::<Vec<_>>()
    };
    let auras: Vec<usize> = (0..creature.aura_limbs().len())
        .filter(|&aura| !actor.own.receptors_on(&limbs(aura)).is_empty())
        .collect();
    let Some(&aimed) = auras.choose(rng) else { return Ok(None) };
    let receptors = actor.own.receptors_on(&limbs(aimed));
    for draws in 0..DRAWS {
        let (Some(posture), Some(&receptor)) = (postures.choose(rng), receptors.choose(rng)) else {
            return Ok(None);
        };
        actor.place(posture)?;
        let found = &actor.own.skin().receptors[receptor];
        let [a, b] = [0, 1].map(|k| found.half_extents[k] * rng.random_range(-1.0..1.0));
        let frame = actor.frames()[found.limb];
        let point = frame.point(&(found.position + found.tangent * a + found.bitangent() * b));
        let x_wr = actor.stage.root_pose();
        let (point, normal) = ((x_wr * Point3::from(point)).coords, x_wr * (frame.rotation * found.normal));
        let from = loop {
            let drawn = Vector3::from_fn(|_, _| rng.random_range(-1.0..1.0_f64));
            let drawn = drawn.try_normalize(0.1).filter(|_| drawn.norm() < 1.0);
            if let Some(drawn) = drawn.filter(|drawn| drawn.dot(&normal) > 0.2) {
                break drawn;
            }
        };
        let far = rng.random_range(0.7..1.0);
        let speed = rng.random_range(0.1..0.5);
        let ends = [point + from * far, point - from * BEYOND];
        let coming = ThreateningPath { aimed, posture: posture.clone(), ends, speed };
        if threatens(actor, thing, &coming)? {
            return Ok(Some((coming, draws)));
        }
    }
    Ok(None)
}

/// Whether a thing meets the limb that it aims at first, and then nothing but the same part of the body, where the
/// creature holds still.
fn threatens(actor: &mut OnStage, thing: usize, coming: &ThreateningPath) -> Result<bool, ExperimentError> {
    let began = actor.stage.time();
    let path = coming.path(began, TRIED);
    let end = path.end();
    actor.stage.send_thing(thing, path);
    let aimed = actor.own.creature().aura_limbs()[coming.aimed].limbs.clone();
    let mut hit = false;
    while actor.stage.time() < end {
        let felt = actor.step(&coming.posture)?;
        let met: Vec<usize> = felt
            .iter()
            .filter(|contact| contact.by == Toucher::Thing(thing))
            .map(|contact| actor.own.skin().receptors[contact.spot.receptor].limb)
            .collect();
        if met.is_empty() {
            continue;
        }
        // From outside: it has come some way before.
        let first =
            !hit && (!met.iter().any(|l| aimed.contains(l)) || actor.stage.time() - began < 0.3 / TRIED);
        let part = arm(actor, aimed[aimed.len() - 1]);
        let part = if aimed.iter().all(|&limb| arm(actor, limb) == part) { part } else { None };
        if first || met.iter().any(|&limb| limb == 0 || arm(actor, limb) != part) {
            return Ok(false);
        }
        hit = true;
    }
    Ok(hit)
}

/// The creature with what it knows meets a thing.
fn attempt(
    actor: &mut OnStage,
    known: &Knowledge,
    thing: usize,
    coming: &ThreateningPath,
) -> Result<AvoidanceOutcome, ExperimentError> {
    (actor.own, actor.clearance) = (known.own.clone(), known.clearance.clone());
    let path = coming.path(actor.stage.time(), coming.speed);
    let end = path.end();
    actor.stage.send_thing(thing, path);
    actor.place(&coming.posture)?;
    // What touches already before anything comes is no consequence; the trunk touches itself wherever it bends.
    let own_touches = |actor: &Actor, felt: &[SkinContact]| -> BTreeSet<[usize; 2]> {
        let pair = |contact: &SkinContact| match contact.by {
            Toucher::Own(other) => Some([contact.spot.limb, other.limb])
                .filter(|pair| pair.iter().any(|&limb| arm(actor, limb).is_some())),
            _ => None,
        };
        felt.iter().filter_map(pair).collect()
    };
    let felt = actor.step(&coming.posture)?;
    let touching = own_touches(actor, &felt);
    let mut avoiding = Avoiding::new(actor);
    let creature = actor.own.creature().clone();
    let aimed = &creature.aura_limbs()[coming.aimed].limbs;
    let any = |carries: &dyn Fn(usize) -> Vec<bool>| {
        let mut any = vec![false; creature.limbs().len()];
        for &limb in aimed {
            carries(limb).into_iter().zip(&mut any).for_each(|(by, any)| *any |= by);
        }
        any
    };
    let carried = any(&|limb| actor.own.carried_by(limb));
    let carry = any(&|limb| (0..creature.limbs().len()).map(|l| actor.own.carried_by(l)[limb]).collect());
    // A part that carries the hands is asked to leave them where they are.
    let trunk = actor.hands.iter().all(|hand| carried[hand.limb]);
    let other = |limb: usize| !aimed.contains(&limb) && !carry[limb];
    let skin = |actor: &OnStage| -> Vec<Vector3<f64>> {
        let poses: Vec<Isometry3<f64>> =
            (0..creature.limbs().len()).map(|limb| actor.stage.limb_pose(limb)).collect();
        let receptors = actor.stage.skin().receptors.iter();
        receptors.map(|r| (poses[r.limb] * Point3::from(r.position)).coords).collect()
    };
    let before = skin(actor);
    let mut outcome =
        AvoidanceOutcome { aimed: coming.aimed, touched: None, moved: [0.0; 2], itself: false, plans: 0 };
    let mut steps = 0;
    while actor.stage.time() < end {
        let felt = avoiding.step(actor)?;
        outcome.itself |= own_touches(actor, &felt).iter().any(|pair| !touching.contains(pair));
        if outcome.touched.is_none() {
            let by = felt.iter().find(|contact| contact.by == Toucher::Thing(thing));
            outcome.touched = by.map(|contact| actor.own.skin().receptors[contact.spot.receptor].limb);
        }
        if steps % EVERY == 0 {
            for ((r, now), then) in actor.own.skin().receptors.iter().zip(skin(actor)).zip(&before) {
                let moved = (now - then).norm();
                if other(r.limb) && (trunk || !carried[r.limb]) {
                    outcome.moved[0] = outcome.moved[0].max(moved);
                }
                if other(r.limb) && !carried[r.limb] {
                    outcome.moved[1] = outcome.moved[1].max(moved);
                }
            }
        }
        steps += 1;
    }
    outcome.plans = avoiding.plans;
    Ok(outcome)
}

/// Measures; a trial that does not succeed is a finding.
///
/// # Errors
/// Where something cannot be measured at all.
pub fn measure(subject: &Subject) -> Result<Findings<AvoidMeasurement, AvoidSummary>, ExperimentError> {
    let learned = Knowledge::new(subject.own_body(subject.seeds[0])?);
    let truth = Knowledge::new(learned.own.with_schema(subject.truth().schema.clone()));
    let mut measurements: Vec<AvoidMeasurement> = Vec::new();
    let mut outcomes: [Vec<AvoidanceOutcome>; 2] = Default::default();
    let (mut drawn_again, mut undrawn) = (0, 0);
    for &seed in &subject.seeds {
        subject.tell(seed, "avoiding");
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let (shape, kind) = shape(&mut rng);
        let pose = Isometry3::from_parts(
            Translation3::new(3.0, 0.0, 1.0),
            UnitQuaternion::from_scaled_axis(Vector3::from_fn(|_, _| rng.random_range(-1.5..1.5))),
        );
        let substance = Substance::default();
        let things = vec![Thing { name: THING.into(), shape, pose, fixed: false, substance }];
        let mut actor = OnStage::new(subject, &truth, things, seed)?;
        let thing = actor.the_thing()?;
        let ready = actor.ready();
        let raised = rng.random_bool(0.5);
        let joints: Vec<usize> = actor.hands.iter().flat_map(|hand| hand.arm.clone()).collect();
        let postures: Vec<Posture> = if raised {
            vec![ready]
        } else {
            let at_ease = [truth.own.frames(&truth.own.at_ease())];
            let clearance = truth.clearance.moved_by(&truth.own, &joints).eased_at(&at_ease, APART);
            (0..2000)
                .map(|_| truth.own.random_posture(&ready, &joints, &mut rng))
                .filter(|posture| clearance.free(&truth.own.frames(posture), APART))
                .take(20)
                .collect()
        };
        let Some((coming, draws)) = draw(&mut actor, thing, &postures, &mut rng)? else {
            undrawn += 1;
            continue;
        };
        drawn_again += draws;
        for (k, (name, known)) in [("learned", &learned), ("true", &truth)].into_iter().enumerate() {
            let outcome = attempt(&mut actor, known, thing, &coming)?;
            let limbs = subject.body().creature.limbs();
            measurements.push(AvoidMeasurement {
                seed,
                schema: name.into(),
                limb: subject.body().creature.aura_limbs()[coming.aimed].name.clone(),
                shape: kind.into(),
                posture: if raised { "hands raised" } else { "random arms" }.into(),
                speed_m_s: coming.speed,
                no_touch: outcome.touched.is_none(),
                touched_limb: outcome.touched.map_or("none".to_string(), |limb| limbs[limb].clone()),
                moved_mm: 1e3 * outcome.moved[0],
                moved_but_carried_mm: 1e3 * outcome.moved[1],
                self_touch: outcome.itself,
                plans: outcome.plans,
            });
            outcomes[k].push(outcome);
        }
    }
    let auras = subject.body().creature.aura_limbs();
    let mut summary: Vec<AvoidSummary> = Vec::new();
    let mut by_limb = serde_json::Map::new();
    let untouched = |outcome: &&AvoidanceOutcome| outcome.touched.is_none();
    let still = |outcome: &&AvoidanceOutcome| outcome.moved[0] < STILL;
    for (name, outcomes) in ["learned", "true"].into_iter().zip(&outcomes) {
        let mut row = |limb: &str, of: &[&AvoidanceOutcome]| {
            let rate = |holds: &dyn Fn(&&AvoidanceOutcome) -> bool| share(of.iter().map(holds));
            let (no_touch, others_still) = (rate(&untouched), rate(&still));
            summary.push(AvoidSummary {
                schema: name.into(),
                limb: limb.into(),
                trials: of.len(),
                no_touch,
                others_still,
                moved_mm: 1e3 * median(of.iter().map(|outcome| outcome.moved[0])),
                self_touch: rate(&|outcome| outcome.itself),
            });
            if name == "learned" {
                let numbers = json!({"trials": of.len(), "no_touch": no_touch, "others_still": others_still});
                by_limb.insert(limb.to_string(), numbers);
            }
        };
        row("all", &outcomes.iter().collect::<Vec<_>>());
        for (aura, limb) in auras.iter().enumerate() {
            let of: Vec<&AvoidanceOutcome> =
                outcomes.iter().filter(|outcome| outcome.aimed == aura).collect();
            if !of.is_empty() {
                row(&limb.name, &of);
            }
        }
    }
    let [own, real] = &outcomes;
    let rate = |of: &[AvoidanceOutcome], holds: &dyn Fn(&&AvoidanceOutcome) -> bool| {
        share(of.iter().map(|o| holds(&o)))
    };
    // What carries one hand alone is of an arm.
    let own_body = &learned.own;
    let on_arm = |outcome: &&AvoidanceOutcome| {
        let hands = HANDS.iter().filter_map(|name| own_body.creature().limb(name));
        let limbs = &auras[outcome.aimed].limbs;
        hands.filter(|&hand| limbs.iter().any(|&limb| own_body.carried_by(limb)[hand])).count() == 1
    };
    let arms: Vec<&AvoidanceOutcome> = own.iter().filter(on_arm).collect();
    let numbers: Vec<(&'static str, Value)> = vec![
        ("no_touch", json!(rate(own, &untouched))),
        ("others_still", json!(rate(own, &still))),
        ("others_still_but_carried", json!(rate(own, &|outcome| outcome.moved[1] < STILL))),
        ("arms_no_touch", json!(share(arms.iter().map(untouched)))),
        ("arms_others_still", json!(share(arms.iter().map(still)))),
        ("self_touch", json!(rate(own, &|outcome| outcome.itself))),
        ("true_kinematics_no_touch", json!(rate(real, &untouched))),
        ("true_kinematics_others_still", json!(rate(real, &still))),
        ("by_limb", Value::Object(by_limb)),
        ("drawn_again", json!(drawn_again)),
        ("undrawn", json!(undrawn)),
    ];
    let notes = vec![
        "Spheres, boxes and capsules of 2 to 5 cm half size come straight from 0.7 to 1 m at 0.1 to 0.5 m/s and go on by \
         0.5 m, whatever they meet. The limb that they aim at is drawn at random from those that the joints move."
            .to_string(),
        format!(
            "Each would hit the limb that it aims at first, and then nothing but the same arm, or the trunk and head, if \
             the creature held still; {drawn_again} ways that would not were drawn again, and {undrawn} trials had none."
        ),
        "others: all limbs but the one aimed at, those between it and the pelvis, and, for arms, neck and head, those that \
         it carries. For abdomen and chest the arms and the head, which they carry, count as others."
            .to_string(),
    ];
    let series =
        ["learned", "true"].into_iter().zip(&outcomes).enumerate().map(|(k, (name, outcomes))| PlotSeries {
            name: name.to_string(),
            line: Vec::new(),
            dots: outcomes.iter().map(|outcome| ((1e3 * outcome.moved[0]).max(0.01), k as f64)).collect(),
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
