//! Whether a robot whose numbers are off is put right by touching itself: encoders, joints, and logs as they come.

use std::collections::BTreeSet;
use std::time::Instant;

use nalgebra::{Rotation3, Vector3};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use serde::{Deserialize, Serialize};

use super::plot::{AxisScale, PlotAxis, PlotSeries, StudyPlot};
use super::subject::{Subject, median, share};
use super::table::{WallTime, row};
use super::{Findings, Study, Trial, Trials};
use crate::calibration::robot::{Element, Knowledge, Link, Posed, Quantity, Robot, Unit, Value};
use crate::calibration::simulated::{
    add_joint_noise, add_point_noise, double, falsify, misread, normal, point_touches, robot_of,
    surface_touches,
};
use crate::calibration::{End, Estimator, EstimatorOptions, JointNoise, Touch, plan};
use crate::experiment::ExperimentError;
use crate::named::named;

/// The study `calibration`.
pub const STUDY: Study = Study {
    name: "calibration",
    about: "whether a robot whose encoders or joints are off is put right by self-touch, from logs clean and not",
    touches: true,
    several: false,
    trials: Trials::of::<CalibrationTrial>(),
};

/// The greatest offset, degrees, and how far gains are from 1.
const OFFSET: f64 = 10.0;
const GAIN: f64 = 0.05;
/// How far off mounts are: deviations, metres and radians.
const MOUNT_POSITION: f64 = 5e-3;
const MOUNT_ANGLE: f64 = 0.05;
/// Noise of encoders, degrees, and of points, metres, in the conditions that have some.
const JOINT_NOISE: f64 = 0.1;
const POINT_NOISE: f64 = 1e-3;
/// Share of false touches in the condition that has some.
const FALSE: f64 = 0.2;
/// How far surfaces that touch are apart by a robot whose joints are off, metres: the worst of them.
const OFF: f64 = 17.7e-3;
/// Deviations of how joints are off, before they are scaled to that: metres and radians.
const POSITIONS: f64 = 5e-3;
const AXES: f64 = 0.05;
/// What counts as right without noise: degrees, and of gains a ratio.
const RIGHT_OFFSET: f64 = 1e-3;
const RIGHT_GAIN: f64 = 1e-5;
/// Touches that are made at random, and those that are chosen of all, to compare them.
const RANDOM: usize = 300;
const PLANNED: usize = 50;
/// Noise of points where there is none, for a plan, metres.
const EXACT: f64 = 1e-5;
/// Every so many touches one is held out.
const HELD_OUT: usize = 4;

/// What is off, and how the log is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CalibrationCase {
    /// Encoders, in exact touches.
    Encoders,
    /// Encoders, that are noisy, too.
    NoisyEncoders,
    /// Encoders, in touches of noisy points.
    NoisyPoints,
    /// The same with false touches among them.
    FalseTouches,
    /// The same with two contacts in each posture, of which nobody knows who met whom.
    Unpaired,
    /// Both.
    FalseAndUnpaired,
    /// Encoders, and where the skins of fingertips are: what nothing tells apart is to be named.
    Mounts,
    /// Joints, by surfaces that touch.
    Joints,
    /// The same with noisy encoders.
    NoisyJoints,
    /// Noisy encoders, by touches at random.
    Random,
    /// The same by fewer that were planned.
    Planned,
}

named!(CalibrationCase, "case", {
    Encoders => "encoders",
    NoisyEncoders => "noisy-encoders",
    NoisyPoints => "noisy-points",
    FalseTouches => "false-touches",
    Unpaired => "unpaired",
    FalseAndUnpaired => "false-and-unpaired",
    Mounts => "mounts",
    Joints => "joints",
    NoisyJoints => "noisy-joints",
    Random => "random",
    Planned => "planned",
});

impl CalibrationCase {
    fn is_of_joints(self) -> bool {
        matches!(self, CalibrationCase::Joints | CalibrationCase::NoisyJoints)
    }

    fn joint_noise(self) -> f64 {
        match self {
            CalibrationCase::NoisyEncoders
            | CalibrationCase::NoisyJoints
            | CalibrationCase::Random
            | CalibrationCase::Planned => JOINT_NOISE.to_radians(),
            _ => 0.0,
        }
    }

    fn point_noise(self) -> f64 {
        match self {
            CalibrationCase::NoisyPoints
            | CalibrationCase::FalseTouches
            | CalibrationCase::Unpaired
            | CalibrationCase::FalseAndUnpaired => POINT_NOISE,
            _ => 0.0,
        }
    }
}

row! {
    /// A measurement of the study `calibration`.
    pub struct CalibrationMeasurement {
        case: String = "case",
        seed: u64 = "seed",
        touches: usize = "touches",
        before_mm: f64 = "before, worst, mm",
        after_mm: f64 = "after, RMS, mm",
        worst_mm: f64 = "after, worst, mm",
        wrong_signs: usize = "wrong signs",
        offset_deg: f64 = "worst offset, °",
        offset_rms_deg: f64 = "offset, RMS, °",
        gain: f64 = "worst gain",
        ratio: f64 = "error / bound",
        right: bool = "right",
        seconds: WallTime = "seconds",
        untold: String = "not told",
    }
}

row! {
    /// A row of the summary of the study `calibration`.
    pub struct CalibrationSummary {
        case: String = "case",
        trials: usize = "trials",
        right: f64 = "right, share",
        before_mm: f64 = "before, worst, mm",
        after_mm: f64 = "after, RMS, mm",
        worst_mm: f64 = "after, worst, mm",
        offset_deg: f64 = "worst offset, °",
        offset_rms_deg: f64 = "offset, RMS, °",
        gain: f64 = "worst gain",
        ratio: f64 = "error / bound",
        seconds: WallTime = "seconds",
    }
}

/// The cases of a subject: all where none is named.
fn cases<'a>(subject: &'a Subject) -> &'a [CalibrationCase] {
    if subject.cases.is_empty() { CalibrationCase::ALL } else { &subject.cases }
}

/// The measurements of one trial, case by case.
#[derive(Debug, Serialize, Deserialize)]
pub struct CalibrationTrial(Vec<CalibrationMeasurement>);

impl Trial for CalibrationTrial {
    type Setting = ();
    type Measurement = CalibrationMeasurement;
    type Summary = CalibrationSummary;

    fn set_up(_subject: &Subject) -> Result<(), ExperimentError> {
        Ok(())
    }

    fn run(subject: &Subject, (): &(), seed: u64) -> Result<CalibrationTrial, ExperimentError> {
        let babbled = subject.babble(seed)?;
        let measured = cases(subject).iter().map(|&case| {
            subject.tell(seed, case.name());
            let mut robot = robot_of(subject.agent(), &subject.truth().schema);
            let touches = if case.is_of_joints() {
                let touches = surface_touches(subject.agent(), &mut robot, &babbled);
                let tips = tips(&robot);
                let is_of_tips =
                    |touch: &Touch| touch.ends.iter().all(|ends| is_tip(&tips, &robot, &ends[0]));
                touches.into_iter().filter(is_of_tips).collect()
            } else {
                point_touches(subject.agent(), &subject.truth().schema, &robot, &babbled)
            };
            calibrated(case, robot, touches, seed)
        });
        Ok(CalibrationTrial(measured.collect()))
    }

    fn findings(
        subject: &Subject,
        trials: &[CalibrationTrial],
    ) -> Findings<CalibrationMeasurement, CalibrationSummary> {
        findings(cases(subject), trials.iter().flat_map(|trial| trial.0.clone()).collect())
    }
}

fn findings(
    cases: &[CalibrationCase],
    measurements: Vec<CalibrationMeasurement>,
) -> Findings<CalibrationMeasurement, CalibrationSummary> {
    let summarized = |&case: &CalibrationCase| {
        let of = || measurements.iter().filter(|found| found.case == case.name());
        let each = |value: fn(&CalibrationMeasurement) -> f64| of().map(value).collect::<Vec<f64>>();
        let worst = |value: fn(&CalibrationMeasurement) -> f64| each(value).into_iter().fold(0.0, f64::max);
        let rms = |values: Vec<f64>| {
            (values.iter().map(|x| x * x).sum::<f64>() / values.len().max(1) as f64).sqrt()
        };
        CalibrationSummary {
            case: case.name().into(),
            trials: of().count(),
            right: share(of().map(|found| found.right)),
            before_mm: median(each(|found| found.before_mm)),
            after_mm: rms(each(|found| found.after_mm)),
            worst_mm: worst(|found| found.worst_mm),
            offset_deg: worst(|found| found.offset_deg),
            offset_rms_deg: rms(each(|found| found.offset_rms_deg)),
            gain: worst(|found| found.gain),
            ratio: rms(each(|found| found.ratio)),
            seconds: WallTime(median(each(|found| found.seconds.0))),
        }
    };
    let summary = cases.iter().map(summarized).collect();
    let notes = vec![format!(
        "Encoders are off by up to {OFFSET}°, gains by up to {GAIN}, signs are drawn; joints are off so that what touches is \
         up to {} mm apart. Apart are exact touches that were not fitted to. Without noise, right is to {RIGHT_OFFSET}° and \
         {RIGHT_GAIN} in all that is not named as not told; with noise, within five deviations. Error / bound is the root \
         mean square of encoders' errors in units of their deviations.",
        1e3 * OFF
    )];
    let dots = |(k, case): (usize, &CalibrationCase)| PlotSeries {
        name: case.name().into(),
        line: Vec::new(),
        dots: measurements
            .iter()
            .filter(|found| found.case == case.name())
            .map(|found| (found.after_mm.max(1e-9), k as f64))
            .collect(),
    };
    let plot = StudyPlot {
        x: PlotAxis { title: "what touches, apart after calibration, mm", scale: AxisScale::Logarithmic },
        series: cases.iter().enumerate().map(dots).collect(),
        y: PlotAxis {
            title: "",
            scale: AxisScale::Names(cases.iter().map(|case| case.name().into()).collect()),
        },
    };
    Findings { summary, notes, plot, numbers: Vec::new(), measurements }
}

/// Limbs that carry no other and are carried themselves: fingertips.
fn tips(robot: &Robot) -> Vec<usize> {
    let moves = |link: &Link| link.elements.iter().any(|element| matches!(element, Element::Dof(_)));
    let carries = |limb: usize| robot.links.iter().any(|link| link.parent == limb && moves(link));
    (0..robot.links.len()).filter(|limb| moves(&robot.links[*limb]) && !carries(*limb)).collect()
}

/// Whether an end is of a fingertip.
fn is_tip(tips: &[usize], robot: &Robot, end: &End) -> bool {
    tips.contains(&robot.links[end.feature.link(robot)].parent)
}

/// The quantities of the mount that a limb's points are on.
fn mount_of(robot: &Robot, limb: usize) -> Vec<usize> {
    let mount = robot.points_of(&robot.links[limb].name).map(|mount| robot.links[mount].elements.iter());
    let quantity = |element: &Element| match *element {
        Element::Shift(quantity) | Element::Turn(quantity) => Some(quantity),
        _ => None,
    };
    mount.into_iter().flatten().filter_map(quantity).collect()
}

/// What touches cannot tell apart where the fingertips' mounts are unknown: of each, the encoder that turns it last and the mount.
fn ties_of_mounts(robot: &Robot) -> Vec<BTreeSet<String>> {
    let of_tip = |tip: usize| {
        let last = robot.links[tip].elements.iter().rev().find_map(|element| match element {
            Element::Dof(dof) => robot.dofs[*dof].quantities.map(|q| q.offset),
            _ => None,
        });
        let tied = last.into_iter().chain(mount_of(robot, tip));
        tied.map(|quantity| robot.quantities[quantity].name.clone()).collect()
    };
    tips(robot).into_iter().map(of_tip).collect()
}

/// Says what is unknown; the truth, about which the robot's nominal values are off.
fn disturbed(case: CalibrationCase, robot: &mut Robot, exact: &[Touch], seed: u64) -> Vec<Value> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let mut truth = robot.nominal();
    let open = |robot: &mut Robot, what: &str, knowledge| {
        let called = format!(".{what}");
        for quantity in robot.quantities.iter_mut().filter(|quantity| quantity.name.ends_with(&called)) {
            // Mounts have positions, too, and are as they are.
            if !quantity.name.contains(".mount.") {
                quantity.knowledge = [knowledge; 3];
            }
        }
    };
    if !case.is_of_joints() {
        for q in robot.dofs.iter().filter_map(|dof| dof.quantities) {
            let mut even = |size: f64| rng.random_range(-size..=size);
            truth[q.offset] = Value::Number(even(OFFSET.to_radians()));
            truth[q.gain] = Value::Number(1.0 + even(GAIN));
            truth[q.sign] = Value::Number(even(1.0).signum());
        }
        for what in ["offset", "gain", "sign"] {
            open(robot, what, Knowledge::Free);
        }
        if case == CalibrationCase::Mounts {
            for quantity in tips(robot).into_iter().flat_map(|tip| mount_of(robot, tip)).collect::<Vec<_>>() {
                let quantity = &mut robot.quantities[quantity];
                let step: [f64; 3] = std::array::from_fn(|_| normal(&mut rng));
                let size = if quantity.unit == Unit::Metre { MOUNT_POSITION } else { MOUNT_ANGLE };
                quantity.nominal = quantity.nominal.stepped(&step.map(|x| size * x));
                quantity.knowledge = [Knowledge::Free; 3];
            }
        }
        return truth;
    }
    open(robot, "position", Knowledge::Near(POSITIONS));
    open(robot, "axis", Knowledge::Near(AXES));
    let nominal_at = |size: f64| -> Vec<Value> {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let off = |(quantity, true_value): (&Quantity, &Value)| {
            let step = Vector3::from_fn(|_, _| size * normal(&mut rng));
            match true_value {
                _ if !quantity.is_open() => *true_value,
                Value::Position(at) => Value::Position(at + step * POSITIONS),
                Value::Direction(axis) => Value::Direction(Rotation3::new(step * AXES) * axis),
                other => *other,
            }
        };
        robot.quantities.iter().zip(&truth).map(off).collect()
    };
    // The size at which what touched is as far apart as it shall be: halving, for it grows with the size.
    let (mut low, mut high) = (0.0, 4.0);
    for _ in 0..30 {
        let middle = 0.5 * (low + high);
        let worst = sizes(robot, &nominal_at(middle), exact).into_iter().fold(0.0, f64::max);
        if worst < OFF { low = middle } else { high = middle }
    }
    let nominal = nominal_at(low);
    for (quantity, value) in robot.quantities.iter_mut().zip(nominal) {
        quantity.nominal = value;
    }
    truth
}

/// Those of some touches that a plan chooses, with all encoders taken to be right.
fn planned(robot: &Robot, touches: &[Touch]) -> Vec<Touch> {
    let estimator = Estimator::new(robot, touches, EstimatorOptions::default());
    let noise = estimator.noise(EXACT, JOINT_NOISE.to_radians());
    let plan = plan(&estimator, &robot.nominal(), &noise, PLANNED);
    plan.touches.iter().map(|planned| touches[planned.candidate].clone()).collect()
}

/// How far apart what touched is by some values, metres.
fn sizes(robot: &Robot, values: &[Value], touches: &[Touch]) -> Vec<f64> {
    let size = |touch: &Touch| {
        let posed = Posed::new(robot, values, &touch.posture);
        posed.miss([&touch.ends[0][0].feature, &touch.ends[1][0].feature], touch.distance).1.norm()
    };
    touches.iter().map(size).collect()
}

fn calibrated(
    case: CalibrationCase,
    mut robot: Robot,
    mut exact: Vec<Touch>,
    seed: u64,
) -> CalibrationMeasurement {
    let truth = disturbed(case, &mut robot, &exact, seed);
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let (mut fitted, mut fresh) = (Vec::new(), Vec::new());
    for (i, touch) in exact.drain(..).enumerate() {
        if i % HELD_OUT == 0 { fresh.push(touch) } else { fitted.push(touch) }
    }
    if matches!(case, CalibrationCase::Unpaired | CalibrationCase::FalseAndUnpaired) {
        // The nominal encoders read right: postures are still as they are.
        double(&robot, &robot.nominal(), &mut fitted, &mut rng);
    }
    if case == CalibrationCase::Random {
        fitted.truncate(RANDOM);
    }
    if case == CalibrationCase::Planned {
        fitted = planned(&robot, &fitted);
    }
    for touches in [&mut fitted, &mut fresh] {
        misread(&robot, &truth, touches);
    }
    add_joint_noise(&robot, &mut fitted, case.joint_noise(), &mut rng);
    add_point_noise(&mut fitted, case.point_noise(), &mut rng);
    if matches!(case, CalibrationCase::FalseTouches | CalibrationCase::FalseAndUnpaired) {
        falsify(&mut fitted, FALSE, &mut rng);
    }
    let joint_noise = if case.joint_noise() > 0.0 { JointNoise::Estimated } else { JointNoise::None };
    let options = EstimatorOptions { joint_noise, ..EstimatorOptions::default() };
    let started = Instant::now();
    let estimator = Estimator::new(&robot, &fitted, options);
    let fit = estimator.fit();
    let seconds = WallTime(started.elapsed().as_secs_f64());
    let told =
        |quantity: usize| estimator.unknowns.place(quantity, 0).filter(|place| fit.told.is_told(*place));
    let error = |quantity: usize| (fit.values[quantity].number() - truth[quantity].number()).abs();
    let (mut wrong_signs, mut offset, mut gain) = (0, 0.0f64, 0.0f64);
    let (mut squares, mut offsets) = (Vec::new(), Vec::new());
    for q in robot.dofs.iter().filter_map(|dof| dof.quantities) {
        wrong_signs += usize::from(!fit.untold_signs.contains(&q.sign) && error(q.sign) > 0.0);
        offsets.extend(told(q.offset).map(|_| error(q.offset)));
        for (quantity, worst) in [(q.offset, &mut offset), (q.gain, &mut gain)] {
            if let Some(place) = told(quantity) {
                *worst = worst.max(error(quantity));
                squares.push((error(quantity) / fit.told.deviation(place)).powi(2));
            }
        }
    }
    let after = sizes(&robot, &fit.values, &fresh);
    let most = |sizes: &[f64]| sizes.iter().fold(0.0f64, |most, size| most.max(*size));
    let noisy = case.joint_noise() > 0.0 || case.point_noise() > 0.0;
    let offset_deg = offset.to_degrees();
    let right = match (case.is_of_joints(), noisy) {
        (true, _) => most(&after) < if noisy { 1e-3 } else { 5e-5 },
        (false, false) => offset_deg < RIGHT_OFFSET && gain < RIGHT_GAIN,
        (false, true) => squares.iter().all(|square| *square < 25.0),
    };
    let untold = fit.told.untold(&robot, &estimator.unknowns);
    let ties: Vec<BTreeSet<String>> =
        untold.iter().map(|untold| untold.names.iter().cloned().collect()).collect();
    // A part of a mount that does not change with the last encoder need not be named.
    let is_named = case != CalibrationCase::Mounts
        || ties_of_mounts(&robot).iter().all(|tie| {
            let of_it: Vec<usize> = (0..ties.len()).filter(|k| !ties[*k].is_disjoint(tie)).collect();
            matches!(of_it.as_slice(), [k] if ties[*k].is_subset(tie) && untold[*k].ways == 1)
        });
    CalibrationMeasurement {
        case: case.name().into(),
        seed,
        touches: fitted.len(),
        before_mm: 1e3 * most(&sizes(&robot, &robot.nominal(), &fresh)),
        after_mm: 1e3 * (after.iter().map(|x| x * x).sum::<f64>() / after.len().max(1) as f64).sqrt(),
        worst_mm: 1e3 * most(&after),
        wrong_signs,
        offset_deg,
        offset_rms_deg: (offsets.iter().map(|x: &f64| x * x).sum::<f64>() / offsets.len().max(1) as f64)
            .sqrt()
            .to_degrees(),
        gain,
        ratio: (squares.iter().sum::<f64>() / squares.len().max(1) as f64).sqrt(),
        right: right && is_named && wrong_signs == 0,
        seconds,
        untold: untold.iter().map(ToString::to_string).collect::<Vec<_>>().join("; "),
    }
}
