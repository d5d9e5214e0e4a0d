//! Whether a creature finds all things on a table, and knows how many there are.

use nalgebra::{Point3, Vector3};
use rand::RngExt;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use serde::{Deserialize, Serialize};
use serde_json::json;

use super::at_table::{EDGE, Knowledge, KnownBodies, OnStage, at_table, on_table, shape};
use super::plot::{AxisScale, PlotAxis, PlotSeries, StudyPlot};
use super::subject::{Subject, median, share};
use super::table::row;
use super::{Findings, Study, Trial, Trials};
use crate::experiment::ExperimentError;
use crate::geometry::Shape;
use crate::interaction::Reply;
use crate::peripersonal::ReachTarget;
use crate::simulation::{ProbePath, Stage, Thing};

/// The study `finding`.
pub const STUDY: Study = Study {
    name: "finding",
    about: "whether it finds all things on a table, how many it takes them for, and whether it forgets what is gone",
    touches: true,
    several: false,
    trials: Trials::of::<FindingTrial>(),
};

/// By which schema it acts.
const CONDITIONS: [&str; 2] = ["learned", "true"];
/// Things on a table at most.
const MOST: usize = 5;
/// No two things are nearer to each other than this, metres, nor one to the table's edge than
const APART: f64 = 0.03;
/// this, metres.
const FROM_EDGE: f64 = 0.02;
/// Draws of a place until there is one in true reach.
const DRAWS: usize = 200;
/// Postures that a true reach is looked for from.
const THOROUGH: usize = 10;
/// Steps in which the near side of a thing is looked for, metres.
const SURFACE_STEP: f64 = 1e-3;
/// A thing that is remembered is where one is within this, metres, of its surface.
const THERE: f64 = 0.05;
/// Things that nobody touches move less than this, metres: the engine lets some glide by themselves.
const STANDS: f64 = 1e-3;

row! {
    /// A measurement of the study `finding`.
    pub struct FindingMeasurement {
        seed: u64 = "seed",
        schema: String = "schema",
        things: usize = "things",
        felt: usize = "felt",
        remembered: usize = "remembered",
        phantoms: usize = "phantoms",
        seconds: f64 = "simulated, s",
        moved_mm: f64 = "moved at most, mm",
        later_things: usize = "things later",
        later_remembered: usize = "remembered later",
        later_phantoms: usize = "phantoms later",
        missed: String = "missed, and where, m",
        said: String = "said",
    }
}

row! {
    /// A row of the summary of the study `finding`.
    pub struct FindingSummary {
        schema: String = "schema",
        tables: usize = "tables",
        things: usize = "things",
        found: f64 = "found, share of things",
        count_right: f64 = "count right, share",
        phantoms: usize = "phantoms",
        later_right: f64 = "count right later, share",
        later_phantoms: usize = "phantoms later",
        seconds: f64 = "simulated, s, median",
    }
}

/// A shape of [`shape`], or as often a lower and smaller one: 2 to 6 cm high, 3 to 10 cm wide.
fn any_shape(rng: &mut ChaCha8Rng) -> Shape {
    if rng.random_bool(0.5) {
        return shape(rng);
    }
    let mut size = |low: f64, high: f64| rng.random_range(low..high);
    let (a, b, c) = (size(0.015, 0.05), size(0.015, 0.05), size(0.01, 0.03));
    match rng.random_range(0..3) {
        0 => Shape::Cylinder { radius: a, half_length: c },
        1 => Shape::Sphere { radius: 0.01 + 0.5 * c },
        _ => Shape::Box { half_extents: [a, b, c] },
    }
}

/// The radius of an upright cylinder about a shape, metres.
fn around(shape: &Shape) -> f64 {
    match *shape {
        Shape::Sphere { radius } | Shape::Cylinder { radius, .. } => radius,
        Shape::Capsule { radius, half_length } => radius + half_length,
        _ => shape.half_bounds().xy().norm(),
    }
}

/// Whether some hand can truly touch a thing: from above, or where it is nearest.
fn in_reach(nobody: &mut OnStage, thing: &Thing) -> bool {
    let from = nobody.posture();
    let x_rw = nobody.stage.root_pose().inverse();
    let centre = (x_rw * Point3::from(thing.pose.translation.vector)).coords;
    let top = nobody.table_top().max(centre.z);
    let above = centre + Vector3::z() * (centre.z - top).abs();
    let outward = Vector3::new(centre.x, centre.y, 0.0).normalize();
    // From outside it towards its middle, until its surface: that may be farther in than what is around all of it.
    let inside = |point: &Vector3<f64>| {
        let world = nobody.stage.root_pose() * Point3::from(*point);
        let local = thing.pose.inverse_transform_point(&world).coords;
        thing.shape.signed_distance(&local).is_none_or(|(distance, _)| distance <= 0.0)
    };
    let mut near = centre - outward * around(&thing.shape);
    while !inside(&near) && (near - centre).dot(&outward) < 0.0 {
        near += outward * SURFACE_STEP;
    }
    let aims = [
        ReachTarget { point: above, direction: -Vector3::z() },
        ReachTarget { point: near, direction: outward },
    ];
    (0..2).any(|hand| {
        let hand = nobody.hands[hand].clone();
        aims.iter()
            .any(|aim| nobody.reaching(hand.arm.clone()).can_be_at(&from, &hand.receptors, aim, THOROUGH))
    })
}

/// Random things on a table, all of which a hand can truly touch.
fn draw(nobody: &mut OnStage, rng: &mut ChaCha8Rng) -> Vec<Thing> {
    let count = rng.random_range(1..=MOST);
    let mut things: Vec<Thing> = Vec::new();
    for _ in 0..DRAWS {
        if things.len() == count {
            break;
        }
        let shape = any_shape(rng);
        let radius = around(&shape);
        let (x, y) = (rng.random_range(EDGE..0.8), rng.random_range(-0.8..0.8));
        let heading = rng.random_range(0.0..std::f64::consts::PI);
        let far = |other: &Thing| {
            let at = other.pose.translation.vector;
            (at.x - x).hypot(at.y - y) >= radius + around(&other.shape) + APART
        };
        if x - radius < EDGE + FROM_EDGE || !things.iter().all(far) {
            continue;
        }
        let name = format!("thing {}", things.len());
        let thing = Thing { name, ..on_table(shape, x, y, heading) };
        if in_reach(nobody, &thing) {
            things.push(thing);
        }
    }
    things
}

/// Where a thing is in the world, metres.
fn stage_place(stage: &Stage, thing: &Thing) -> Vector3<f64> {
    stage.thing(&thing.name).map_or_else(Vector3::zeros, |number| stage.thing_pose(number).translation.vector)
}

/// How far a point of the world is from the surface of a thing, metres.
fn away(stage: &Stage, thing: &Thing, point: &Point3<f64>) -> f64 {
    let Some(number) = stage.thing(&thing.name) else { return f64::INFINITY };
    let local = stage.thing_pose(number).inverse_transform_point(point).coords;
    thing.shape.signed_distance(&local).map_or(f64::INFINITY, |(distance, _)| distance)
}

/// The things of a table that something remembered is at, and how many of what is remembered are at none.
fn held_against(stage: &Stage, things: &[Thing], reply: &Reply) -> (usize, usize) {
    let at: Vec<Point3<f64>> = reply
        .felt
        .iter()
        .map(|known| {
            let at = known["at"].as_array().into_iter().flatten().filter_map(|x| x.as_f64());
            stage.root_pose() * Point3::from(Vector3::from_iterator(at.take(3)))
        })
        .collect();
    let is_at = |thing: &Thing, point: &Point3<f64>| away(stage, thing, point) <= THERE;
    let found = things.iter().filter(|thing| at.iter().any(|point| is_at(thing, point))).count();
    let phantoms = at.iter().filter(|point| !things.iter().any(|thing| is_at(thing, point))).count();
    (found, phantoms)
}

/// What came of one trial.
#[derive(Debug, Serialize, Deserialize)]
pub struct FindingTrial {
    measurements: Vec<FindingMeasurement>,
    /// Tables that were drawn on which a thing glides without being touched.
    passed_over: usize,
}

impl Trial for FindingTrial {
    type Setting = KnownBodies;
    type Measurement = FindingMeasurement;
    type Summary = FindingSummary;

    fn set_up(subject: &Subject) -> Result<KnownBodies, ExperimentError> {
        KnownBodies::of(subject)
    }

    fn run(subject: &Subject, bodies: &KnownBodies, seed: u64) -> Result<FindingTrial, ExperimentError> {
        let KnownBodies { learned, truth } = bodies;
        subject.tell(seed, "table");
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let mut nobody = at_table(subject, truth, &[], seed)?;
        let height = nobody.table_top();
        nobody.know_table(height);
        let mut passed_over = 0;
        let things = loop {
            let things = draw(&mut nobody, &mut rng);
            if stand(subject, truth, &things, seed)? {
                break things;
            }
            passed_over += 1;
        };
        let gone = rng.random_range(0..things.len().max(1));
        let mut measurements = Vec::new();
        for (schema, known) in CONDITIONS.into_iter().zip([learned, truth]) {
            let actor = at_table(subject, known, &things, seed)?;
            measurements.push(search(actor, &things, gone, schema, seed)?);
        }
        Ok(FindingTrial { measurements, passed_over })
    }

    fn findings(_subject: &Subject, trials: &[FindingTrial]) -> Findings<FindingMeasurement, FindingSummary> {
        findings(trials)
    }
}

/// Lets a creature count the things on its table, takes one of them away, and lets it count again.
fn search(
    actor: OnStage,
    things: &[Thing],
    gone: usize,
    schema: &str,
    seed: u64,
) -> Result<FindingMeasurement, ExperimentError> {
    let (stage, mut talk) = actor.in_conversation()?;
    let numbers: Vec<usize> = things.iter().filter_map(|thing| stage.thing(&thing.name)).collect();
    let places = || -> Vec<_> { numbers.iter().map(|&n| stage.thing_pose(n).translation.vector).collect() };
    let (before, start) = (places(), stage.time());
    let reply = talk.count(None)?;
    let seconds = stage.time() - start;
    let moved = places().iter().zip(&before).map(|(a, b)| (a - b).norm()).fold(0.0, f64::max);
    let (found, phantoms) = held_against(&stage, things, &reply);
    let lost = things.iter().filter(|thing| held_against(&stage, std::slice::from_ref(thing), &reply).0 == 0);
    let described = lost.map(|thing| {
        let [at, now] = [thing.pose.translation.vector, stage_place(&stage, thing)];
        let [size, moved] = [thing.shape.half_bounds(), now - at];
        format!(
            "half {:.3} {:.3} {:.3} at {:.3} {:.3}, moved {:.3} {:.3} {:.3}",
            size.x, size.y, size.z, at.x, at.y, moved.x, moved.y, moved.z
        )
    });
    let missed = described.collect::<Vec<_>>().join("; ");
    // One is taken away meanwhile.
    let mut left = things.to_vec();
    if let Some(&number) = numbers.get(gone) {
        let (now, here) = (stage.time(), stage.thing_pose(number).translation.vector);
        let up = here + Vector3::z() * 0.8;
        let far = up + Vector3::x() * 3.0;
        stage.send_thing(number, ProbePath(vec![(now, here), (now + 1.0, up), (now + 2.0, far)]));
        left.remove(gone);
        talk.actor.wait(2.5)?;
    }
    let later = talk.count(None)?;
    let (_, later_phantoms) = held_against(&stage, &left, &later);
    Ok(FindingMeasurement {
        seed,
        schema: schema.into(),
        things: things.len(),
        felt: found,
        remembered: reply.felt.len(),
        phantoms,
        seconds,
        moved_mm: 1e3 * moved,
        later_things: left.len(),
        later_remembered: later.felt.len(),
        later_phantoms,
        missed,
        said: reply.said.clone(),
    })
}

fn findings(trials: &[FindingTrial]) -> Findings<FindingMeasurement, FindingSummary> {
    let measurements: Vec<FindingMeasurement> =
        trials.iter().flat_map(|trial| trial.measurements.clone()).collect();
    let passed_over: usize = trials.iter().map(|trial| trial.passed_over).sum();
    let mut summary: Vec<FindingSummary> = Vec::new();
    for schema in CONDITIONS {
        let of: Vec<&FindingMeasurement> = measurements.iter().filter(|m| m.schema == schema).collect();
        let things: usize = of.iter().map(|m| m.things).sum();
        summary.push(FindingSummary {
            schema: schema.into(),
            tables: of.len(),
            things,
            found: of.iter().map(|m| m.felt).sum::<usize>() as f64 / things.max(1) as f64,
            count_right: share(of.iter().map(|m| m.remembered == m.things)),
            phantoms: of.iter().map(|m| m.phantoms).sum(),
            later_right: share(of.iter().map(|m| m.later_remembered == m.later_things)),
            later_phantoms: of.iter().map(|m| m.later_phantoms).sum(),
            seconds: median(of.iter().map(|m| m.seconds)),
        });
    }
    let notes = vec![format!(
        "A thing is found where something is remembered within 5 cm of its surface; a phantom is remembered where there is \
         none. Later: one thing was taken away without a word, and he was asked again. {passed_over} tables were drawn again \
         on which a thing glides without being touched."
    )];
    let numbers = summary
        .iter()
        .zip([
            ["found", "count_right", "later_phantoms"],
            ["true_found", "true_count_right", "true_later_phantoms"],
        ])
        .flat_map(|(row, names)| {
            [json!(row.found), json!(row.count_right), json!(row.later_phantoms)]
                .into_iter()
                .zip(names)
                .map(|(value, name)| (name, value))
                .collect::<Vec<_>>()
        })
        .collect();
    let series = CONDITIONS.into_iter().enumerate().map(|(k, schema)| PlotSeries {
        name: schema.into(),
        line: Vec::new(),
        dots: measurements
            .iter()
            .filter(|m| m.schema == schema)
            .map(|m| (m.things as f64 + 0.1 * k as f64, m.remembered as f64))
            .collect(),
    });
    let counts = || AxisScale::Names((0..=2 * MOST).map(|count| count.to_string()).collect());
    let plot = StudyPlot {
        x: PlotAxis { title: "things on the table", scale: counts() },
        y: PlotAxis { title: "things that he remembers", scale: counts() },
        series: series.collect(),
    };
    Findings { summary, notes, plot, numbers, measurements }
}

/// Whether all things stay where they are put while nobody touches them.
fn stand(subject: &Subject, truth: &Knowledge, things: &[Thing], seed: u64) -> Result<bool, ExperimentError> {
    let mut actor = at_table(subject, truth, things, seed)?;
    let touched = actor.wait(0.5)?;
    let stays = things.iter().all(|thing| {
        actor.stage.thing(&thing.name).is_some_and(|number| {
            let moved = actor.stage.thing_pose(number).translation.vector - thing.pose.translation.vector;
            moved.norm() < STANDS
        })
    });
    Ok(stays && touched.is_empty() && !things.is_empty())
}
