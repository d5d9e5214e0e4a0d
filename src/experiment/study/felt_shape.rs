//! How well the shape of a thing is known after some touches of the fingertips.

use nalgebra::{Isometry3, Point3, Rotation3, Translation3, UnitQuaternion, Vector3};
use rand::RngExt;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use serde::{Deserialize, Serialize};
use serde_json::json;

use super::at_table::{Knowledge, KnownBodies, THING, TOP, at_table};
use super::plot::{AxisScale, PlotAxis, PlotSeries, StudyPlot};
use super::subject::{Subject, median, share};
use super::table::row;
use super::{Findings, Study, Trial, Trials};
use crate::experiment::ExperimentError;
use crate::geometry::{Hull, Shape};
use crate::interaction::Trouble;
use crate::peripersonal::ShapeEstimate;
use crate::simulation::{Substance, Thing};

/// The study `shape`.
pub const STUDY: Study = Study {
    name: "shape",
    about: "how well the shape of a thing on the table is known after 15 touches; a trial is a thing",
    touches: true,
    several: false,
    trials: Trials::of::<ShapeTrial>(),
};

/// Touches of a thing.
const TOUCHES: usize = 15;
/// Draws of a thing until there is one that a hand finds.
const DRAWS: usize = 20;
/// Points by which volumes are compared.
const POINTS: usize = 20_000;
/// Corners of a hull.
const CORNERS: usize = 24;
/// The share of the union that is to be common.
const GOOD: f64 = 0.85;
/// By which schema it acts.
const CONDITIONS: [&str; 2] = ["learned", "true"];

row! {
    /// A measurement of the study `shape`.
    pub struct ShapeMeasurement {
        seed: u64 = "seed",
        schema: String = "schema",
        kind: String = "shape",
        widest_m: f64 = "widest, m",
        touches: usize = "touches",
        contacts: usize = "contacts",
        barred: usize = "sides barred",
        overlap: f64 = "intersection over union",
        moved_mm: f64 = "moved, mm",
        result: String = "result",
    }
}

row! {
    /// A row of the summary of the study `shape`.
    pub struct ShapeSummary {
        schema: String = "schema",
        trials: usize = "trials",
        touches: f64 = "touches, median",
        contacts: f64 = "contacts, median",
        overlap: f64 = "intersection over union, median",
        least: f64 = "least",
        good: f64 = "at least 0.85, share",
    }
}

/// The measurements of one trial, for those conditions in which the thing was found.
#[derive(Debug, Serialize, Deserialize)]
pub struct ShapeTrial(Vec<ShapeMeasurement>);

impl Trial for ShapeTrial {
    type Setting = KnownBodies;
    type Measurement = ShapeMeasurement;
    type Summary = ShapeSummary;

    fn set_up(subject: &Subject) -> Result<KnownBodies, ExperimentError> {
        KnownBodies::of(subject)
    }

    fn run(subject: &Subject, bodies: &KnownBodies, seed: u64) -> Result<ShapeTrial, ExperimentError> {
        subject.tell(seed, "thing");
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        for _ in 0..DRAWS {
            let thing = random_thing(&mut rng);
            let mut rows = Vec::new();
            for (name, known) in CONDITIONS.into_iter().zip([&bodies.learned, &bodies.truth]) {
                rows.extend(attempt(subject, known, &thing, seed, name)?);
            }
            // Drawn again where it is not found at all by whoever knows the truth.
            if rows.iter().any(|row| row.schema == "true") {
                return Ok(ShapeTrial(rows));
            }
        }
        Ok(ShapeTrial(Vec::new()))
    }

    fn findings(_subject: &Subject, trials: &[ShapeTrial]) -> Findings<ShapeMeasurement, ShapeSummary> {
        findings(trials.iter().flat_map(|trial| trial.0.clone()).collect())
    }
}

fn findings(measurements: Vec<ShapeMeasurement>) -> Findings<ShapeMeasurement, ShapeSummary> {
    let mut summary = Vec::new();
    let of = |name: &str| measurements.iter().filter(|row| row.schema == name).collect::<Vec<_>>();
    for name in CONDITIONS {
        let rows = of(name);
        summary.push(ShapeSummary {
            schema: name.into(),
            trials: rows.len(),
            touches: median(rows.iter().map(|row| row.touches as f64)),
            contacts: median(rows.iter().map(|row| row.contacts as f64)),
            overlap: median(rows.iter().map(|row| row.overlap)),
            least: rows.iter().map(|row| row.overlap).fold(f64::NAN, f64::min),
            good: share(rows.iter().map(|row| row.overlap >= GOOD)),
        });
    }
    let own = of("learned");
    let notes = vec![
        "Intersection over union of the volumes of the thing and of what it is taken for. Boxes and cylinders stand by \
         themselves; capsules, ellipsoids and hulls are fixed to the table."
            .to_string(),
    ];
    let numbers = vec![
        ("overlap", json!(median(own.iter().map(|row| row.overlap)))),
        ("least_overlap", json!(own.iter().map(|row| row.overlap).fold(f64::NAN, f64::min))),
        ("good", json!(share(own.iter().map(|row| row.overlap >= GOOD)))),
    ];
    let series = CONDITIONS.iter().enumerate().map(|(k, name)| PlotSeries {
        name: (*name).to_string(),
        line: Vec::new(),
        dots: of(name).iter().map(|row| (row.overlap, k as f64)).collect(),
    });
    let plot = StudyPlot {
        x: PlotAxis { title: "intersection over union", scale: AxisScale::Logarithmic },
        y: PlotAxis {
            title: "",
            scale: AxisScale::Names(CONDITIONS.iter().map(|name| (*name).into()).collect()),
        },
        series: series.collect(),
    };
    Findings { summary, notes, plot, numbers, measurements }
}

/// One thing, felt by one body; none where no hand finds it.
fn attempt(
    subject: &Subject,
    known: &Knowledge,
    thing: &Thing,
    seed: u64,
    schema: &str,
) -> Result<Option<ShapeMeasurement>, ExperimentError> {
    let mut actor = at_table(subject, known, std::slice::from_ref(thing), seed)?;
    let Ok(height) = actor.feel_table(0).and_then(|a| Ok(a.min(actor.feel_table(1)?))) else {
        return Ok(None);
    };
    actor.know_table(height);
    let first = usize::from(thing.pose.translation.y < 0.0);
    let number = actor.the_thing()?;
    let Some(found) = [first, 1 - first].into_iter().find_map(|hand| actor.explore(hand).ok().flatten())
    else {
        return Ok(None);
    };
    let felt = actor.feel_shape(&found, TOUCHES);
    let pose = actor.stage.thing_pose(number);
    let moved_mm = 1e3 * (pose.translation.vector - thing.pose.translation.vector).norm();
    let half = thing.shape.half_bounds();
    let row = |touches, contacts, barred, overlap, result: String| ShapeMeasurement {
        seed,
        schema: schema.into(),
        kind: kind(&thing.shape).into(),
        widest_m: 2.0 * half.amax(),
        touches,
        contacts,
        barred,
        overlap,
        moved_mm,
        result,
    };
    Ok(Some(match felt {
        Ok(felt) => {
            let root = actor.stage.root_pose();
            let overlap = overlap(&felt.shape, &thing.shape, &(root.inverse() * pose), seed);
            row(felt.touches, felt.contacts, felt.barred, overlap, "felt".into())
        }
        Err(Trouble::Engine(error)) => return Err(error.into()),
        Err(trouble) => row(0, 0, 0, 0.0, trouble.to_string()),
    }))
}

fn kind(shape: &Shape) -> &'static str {
    match shape {
        Shape::Box { .. } => "box",
        Shape::Cylinder { .. } => "cylinder",
        Shape::Capsule { .. } => "capsule",
        Shape::Ellipsoid { .. } => "ellipsoid",
        _ => "hull",
    }
}

/// The intersection over the union of what a thing is taken for, in the root's frame, and of what it is, at `X_RT`.
fn overlap(taken: &ShapeEstimate, shape: &Shape, pose: &Isometry3<f64>, seed: u64) -> f64 {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let corners = taken.corners();
    let radius = shape.bounding_radius();
    let (mut low, mut high) =
        (pose.translation.vector.add_scalar(-radius), pose.translation.vector.add_scalar(radius));
    for corner in &corners {
        (low, high) = (low.inf(corner), high.sup(corner));
    }
    let (mut both, mut any) = (0, 0);
    for _ in 0..POINTS {
        let p = Vector3::from_fn(|k, _| rng.random_range(low[k]..high[k]));
        let truly = shape.holds(&pose.inverse_transform_point(&Point3::from(p)).coords, 0.0);
        let supposed = taken.holds(&p);
        both += usize::from(truly && supposed);
        any += usize::from(truly || supposed);
    }
    both as f64 / any.max(1) as f64
}

/// A thing of 3 to 15 cm that stands or lies on the table.
fn random_thing(rng: &mut ChaCha8Rng) -> Thing {
    let mut between = |low: f64, high: f64| rng.random_range(low..high);
    let half = Vector3::new(between(0.015, 0.055), between(0.015, 0.055), between(0.02, 0.075));
    let yaw = Rotation3::from_axis_angle(&Vector3::z_axis(), between(0.0, std::f64::consts::PI));
    let lying = yaw * Rotation3::from_axis_angle(&Vector3::y_axis(), std::f64::consts::FRAC_PI_2);
    let (x, y) = (between(0.36, 0.52), between(-0.22, 0.22));
    let kind = between(0.0, 5.0) as usize;
    let (shape, turn) = match kind {
        0 => (Shape::Box { half_extents: half.into() }, yaw),
        1 => (Shape::Cylinder { radius: half.x, half_length: half.z }, yaw),
        2 => (Shape::Capsule { radius: half.x.min(0.035), half_length: half.y }, lying),
        3 => (Shape::Ellipsoid { semi_axes: half.into() }, yaw),
        _ => (random_hull(half, &mut between), yaw),
    };
    let turn = UnitQuaternion::from_rotation_matrix(&turn);
    let down = turn.inverse_transform_vector(&-Vector3::z());
    let low = shape.support(&down).map_or(half.z, |point| point.dot(&down));
    let pose = Isometry3::from_parts(Translation3::new(x, y, TOP + low), turn);
    Thing { name: THING.into(), fixed: kind > 1, shape, pose, substance: Substance::default() }
}

/// The hull of points on a rounded body between an ellipsoid and a box, wider at one end: a bottle's, a fruit's.
fn random_hull(half: Vector3<f64>, between: &mut impl FnMut(f64, f64) -> f64) -> Shape {
    let (exponent, widening) = (between(2.0, 6.0), between(-0.4, 0.4));
    let points: Vec<Vector3<f64>> = (0..CORNERS)
        .map(|_| {
            let v = Vector3::from_fn(|_, _| between(-1.0, 1.0));
            let norm: f64 = v.iter().map(|x: &f64| x.abs().powf(exponent)).sum::<f64>().powf(1.0 / exponent);
            let v = v / norm.max(1e-6);
            let wide = 1.0 + widening * v.z;
            Vector3::new(v.x * half.x * wide, v.y * half.y * wide, v.z * half.z)
        })
        .collect();
    let middle = points.iter().sum::<Vector3<f64>>() / points.len() as f64;
    let points: Vec<Vector3<f64>> = points.into_iter().map(|point| point - middle).collect();
    hull_of(points).map_or(Shape::Ellipsoid { semi_axes: half.into() }, Shape::Hull)
}

/// The convex hull of few points: all planes through three of them that have the others on one side.
fn hull_of(points: Vec<Vector3<f64>>) -> Option<Hull> {
    let mut faces = Vec::new();
    for i in 0..points.len() {
        for j in i + 1..points.len() {
            for k in j + 1..points.len() {
                let normal = (points[j] - points[i]).cross(&(points[k] - points[i]));
                let sides = points.iter().map(|p| normal.dot(&(p - points[i])));
                let ends = sides.fold([0.0_f64; 2], |[low, high], side| [low.min(side), high.max(side)]);
                if ends[0] > -1e-12 || ends[1] < 1e-12 {
                    faces.push([i, j, k]);
                }
            }
        }
    }
    // Only corners of the hull: a point inside belongs to no face.
    let mut corners: Vec<usize> = faces.iter().flatten().copied().collect();
    corners.sort_unstable();
    corners.dedup();
    let faces = faces.into_iter().map(|face| face.map(|v| corners.binary_search(&v).unwrap_or(0))).collect();
    Hull::new(corners.into_iter().map(|v| points[v]).collect(), faces)
}
