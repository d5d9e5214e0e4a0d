//! `bodyschema calibrate`: put a robot's numbers right by its own touches.

use std::path::{Path, PathBuf};

use serde_json::json;

use super::{Failure, Outcome, output, progress};
use crate::calibration::robot::{Knowledge, Robot};
use crate::calibration::{
    Estimator, EstimatorOptions, FalseTouches, Fit, JointNoise, Judgement, Misses, Touch, judge, split,
};
use crate::record::{apply_known, read_calibration_log, read_known, read_robot, set_prior};

/// Put a robot's numbers right by its own touches.
///
/// From what its maker says of it and a log of touches. Whatever may be wrong has a name, such as elbow.offset,
/// wrist.position or skin.orientation: what is free is found, what is nearly known is found near where it is said to be.
#[derive(clap::Args)]
#[command(after_help = "Examples:
  bodyschema calibrate robot.json touches.csv --free '*.offset'
  bodyschema calibrate robot.json touches.csv --free 'torso.mount.*' --free 'hand.mount.*' --held-out 0.3
  bodyschema calibrate robot.json touches.csv --prior '*.position=5mm' --prior '*.axis=1deg'
  bodyschema calibrate robot.json touches.csv --known near.json --held-out fresh.csv --json")]
pub struct CalibrateArguments {
    /// The robot: a description in JSON with its maker's numbers
    robot: PathBuf,
    /// The log of touches: comma-separated values
    log: PathBuf,
    #[command(flatten)]
    unknowns: UnknownArguments,
    #[command(flatten)]
    noise: NoiseArguments,
    #[command(flatten)]
    judging: JudgingArguments,
    /// Print one JSON object
    #[arg(long, help_heading = "Output")]
    json: bool,
}

/// What is unknown.
#[derive(clap::Args)]
#[command(next_help_heading = "What is unknown")]
struct UnknownArguments {
    /// Quantities of which nothing is known, by name; * stands for any part of one
    #[arg(long, value_name = "NAME")]
    free: Vec<String>,
    /// Quantities that are as they are given
    #[arg(long, value_name = "NAME")]
    fix: Vec<String>,
    /// Quantities that are nearly as they are given, to a standard deviation
    #[arg(long, value_name = "NAME=DEVIATION")]
    prior: Vec<String>,
    /// What is known of joints, as for learn: positions and axes with their deviations
    #[arg(long, value_name = "FILE")]
    known: Option<PathBuf>,
}

/// What noise there is.
#[derive(clap::Args)]
#[command(next_help_heading = "Noise")]
struct NoiseArguments {
    /// Standard deviation of encoders, degrees (millimetres of slides), or auto: as much as the touches show
    #[arg(long, value_name = "DEG|auto", default_value = "0")]
    joint_noise: String,
    /// Whether touches may be false: no, or maybe if the touches show it
    #[arg(long, value_name = "no|maybe", default_value = "maybe", value_parser = ["no", "maybe"])]
    false_touches: String,
}

/// How it is judged.
#[derive(clap::Args)]
#[command(next_help_heading = "Judging")]
struct JudgingArguments {
    /// Touches that are not fitted to and by which the rest is judged: a share of the log, or another log
    #[arg(long, value_name = "SHARE|FILE")]
    held_out: Option<String>,
    /// Divide the log anew so many times, with --held-out SHARE
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u64).range(1..))]
    splits: u64,
    /// Divide the log by another seed
    #[arg(long, default_value_t = 1)]
    seed: u64,
}

pub fn run(args: &CalibrateArguments) -> Outcome {
    let (robot, touches) = given(args)?;
    let options = args.noise.options()?;
    let spinner = progress::spinner("calibrating");
    let judged = args.judging.judged(&robot, touches.as_slice(), options)?;
    let estimator = Estimator::new(&robot, &touches, options);
    let fit = estimator.fit();
    spinner.finish_and_clear();
    if args.json {
        return output::json(&as_json(&robot, &touches, &estimator, &fit, &judged));
    }
    print(&robot, &touches, &estimator, &fit, &judged);
    Ok(())
}

/// The robot with what is known of it, and the touches.
fn given(args: &CalibrateArguments) -> Result<(Robot, Vec<Touch>), Failure> {
    let file = read_robot(&args.robot)?;
    let mut robot = file.robot;
    let place = args.robot.display().to_string();
    let mut unplaced = file.unplaced;
    if let Some(known) = &args.unknowns.known {
        let creature = file.creature.as_ref().ok_or_else(|| {
            format!("{place} is no description in JSON: say what is known by --prior in place of --known")
        })?;
        let joints = read_known(known, creature)?;
        apply_known(&mut robot, creature, &joints);
        unplaced.retain(|name| {
            !joints
                .iter()
                .any(|joint| creature.joints()[joint.joint].name == *name && joint.position.is_some())
        });
    }
    if let Some(name) = unplaced.first() {
        return Err(format!(
            "{place}: nothing is said of where joint {name} is: give its position and axes, or --known, or learn from \
             nothing with `bodyschema learn --creature {place} --log {}`",
            args.log.display()
        )
        .into());
    }
    let says = args.unknowns.apply(&mut robot)?;
    if !says && !file.says_what_is_open && args.unknowns.known.is_none() {
        robot.set_knowledge("*.offset", Knowledge::Free)?;
        tell!(
            "Nothing is said to be unknown: encoders' offsets are taken to be; say what is by --free and --prior."
        );
    }
    let log = read_calibration_log(&args.log, &robot)?;
    for note in &log.notes {
        tell!("{}: {note}", args.log.display());
    }
    Ok((robot, log.touches))
}

impl UnknownArguments {
    /// Says what is unknown of a robot; whether anything is said.
    fn apply(&self, robot: &mut Robot) -> Result<bool, Failure> {
        for pattern in &self.free {
            robot.set_knowledge(pattern, Knowledge::Free).map_err(|fault| format!("--free: {fault}"))?;
        }
        for prior in &self.prior {
            let (pattern, deviation) = prior.split_once('=').ok_or_else(|| {
                format!("--prior {prior}: give a name and a deviation, such as {prior}=5mm")
            })?;
            set_prior(robot, pattern, deviation).map_err(|fault| format!("--prior: {fault}"))?;
        }
        for pattern in &self.fix {
            robot.set_knowledge(pattern, Knowledge::Known).map_err(|fault| format!("--fix: {fault}"))?;
        }
        Ok(!self.free.is_empty() || !self.prior.is_empty())
    }
}

impl NoiseArguments {
    fn options(&self) -> Result<EstimatorOptions, Failure> {
        let joint_noise = match self.joint_noise.as_str() {
            "auto" => JointNoise::Estimated,
            text => match text.parse::<f64>() {
                Ok(0.0) => JointNoise::None,
                Ok(degrees) if degrees.is_finite() && degrees > 0.0 => {
                    JointNoise::Given(degrees.to_radians())
                }
                _ => return Err(format!("--joint-noise {text}: give degrees, or auto").into()),
            },
        };
        let false_touches = if self.false_touches == "no" { FalseTouches::None } else { FalseTouches::Maybe };
        Ok(EstimatorOptions { joint_noise, false_touches })
    }
}

impl JudgingArguments {
    /// What touches that are held out say, split by split.
    fn judged(
        &self,
        robot: &Robot,
        touches: &[Touch],
        options: EstimatorOptions,
    ) -> Result<Vec<Judgement>, Failure> {
        let Some(held_out) = &self.held_out else { return Ok(Vec::new()) };
        let one = |fitted: &[Touch], fresh: &[Touch]| {
            let estimator = Estimator::new(robot, fitted, options);
            judge(&estimator, &estimator.fit(), fresh)
        };
        let Ok(share) = held_out.parse::<f64>() else {
            let fresh = read_calibration_log(Path::new(held_out), robot)?;
            return Ok(vec![one(touches, &fresh.touches)]);
        };
        if !(share > 0.0 && share < 1.0) {
            return Err(format!(
                "--held-out {held_out}: give a share between 0 and 1, such as 0.3, or a log"
            )
            .into());
        }
        let of_split = |k: u64| {
            let [fitted, fresh] = split(touches, share, self.seed + k);
            one(&fitted, &fresh)
        };
        Ok((0..self.splits).map(of_split).collect())
    }
}

fn print(robot: &Robot, touches: &[Touch], estimator: &Estimator, fit: &Fit, judged: &[Judgement]) {
    say!("{}: {} touches, {} unknown numbers", robot.name, touches.len(), estimator.unknowns.len());
    say!("  {:<34}{:>9} {:>9} {:>9} {:>9}", "what touched, apart", "RMS", "median", "95 %", "max");
    let row = |name: &str, misses: &Misses| {
        let [rms, median, p95, max] =
            [misses.rms, misses.median, misses.p95, misses.max].map(|x| output::number(1e3 * x));
        say!("  {name:<34}{rms:>9} {median:>9} {p95:>9} {max:>9}  mm");
    };
    row("before", &Misses::of(&estimator.seen(&robot.nominal(), &fit.noise)));
    row("after", &Misses::of(&fit.seen));
    if !judged.is_empty() {
        let name = |what: &str| format!("{what}, {} held out", judged[0].touches);
        row(&name("before"), &mean(judged, |judgement| judgement.before));
        row(&name("after"), &mean(judged, |judgement| judgement.after));
        let within = judged.iter().map(|judgement| judgement.within).sum::<f64>() / judged.len() as f64;
        let interval = judged.iter().map(|judgement| judgement.interval).sum::<f64>() / judged.len() as f64;
        say!(
            "  {:.1} % of what was held out is within the interval that should hold 95 % ({:.1} mm on average)",
            100.0 * within,
            1e3 * interval
        );
    }
    say!("");
    say!("  {:<34}{:>24} {:>24} {:>12}", "quantity", "before", "after", "deviation");
    for (q, quantity) in robot.quantities.iter().enumerate().filter(|(_, quantity)| quantity.is_open()) {
        let (factor, unit) = quantity.unit.for_readers();
        let deviations: Vec<String> = (0..quantity.nominal.size())
            .filter_map(|component| estimator.unknowns.place(q, component))
            .map(|place| match fit.told.deviation(place) {
                deviation if deviation.is_finite() => output::number(factor * deviation),
                _ => "?".into(),
            })
            .collect();
        say!(
            "  {:<34}{:>24} {:>24} {:>12} {unit}",
            quantity.name,
            words(&quantity.nominal, factor),
            words(&fit.values[q], factor),
            deviations.join(" ")
        );
    }
    for untold in fit.told.untold(robot, &estimator.unknowns) {
        say!("  {untold}");
    }
}

fn mean(judged: &[Judgement], of: impl Fn(&Judgement) -> Misses) -> Misses {
    let count = judged.len().max(1) as f64;
    let sum =
        |part: fn(&Misses) -> f64| judged.iter().map(|judgement| part(&of(judgement))).sum::<f64>() / count;
    Misses { rms: sum(|m| m.rms), median: sum(|m| m.median), p95: sum(|m| m.p95), max: sum(|m| m.max) }
}

/// A value as a person reads it.
fn words(value: &crate::calibration::robot::Value, factor: f64) -> String {
    use crate::calibration::robot::Value;
    let three = |v: nalgebra::Vector3<f64>, decimals: usize| {
        format!("{:.*} {:.*} {:.*}", decimals, v.x, decimals, v.y, decimals, v.z)
    };
    match value {
        Value::Position(at) => three(at * factor, 3),
        Value::Direction(axis) => three(*axis, 4),
        Value::Orientation(rotation) => {
            three(nalgebra::Rotation3::from_matrix_unchecked(*rotation).scaled_axis() * factor, 3)
        }
        Value::Number(number) => format!("{:.4}", number * factor),
    }
}

fn as_json(
    robot: &Robot,
    touches: &[Touch],
    estimator: &Estimator,
    fit: &Fit,
    judged: &[Judgement],
) -> serde_json::Value {
    use crate::calibration::robot::Value;
    let numbers = |value: &Value| match value {
        Value::Position(v) | Value::Direction(v) => v.iter().copied().collect::<Vec<f64>>(),
        Value::Orientation(r) => {
            nalgebra::Rotation3::from_matrix_unchecked(*r).scaled_axis().iter().copied().collect()
        }
        Value::Number(x) => vec![*x],
    };
    let open = robot.quantities.iter().enumerate().filter(|(_, quantity)| quantity.is_open());
    let quantities = open.map(|(q, quantity)| {
        let deviations =
            (0..quantity.nominal.size()).filter_map(|component| estimator.unknowns.place(q, component));
        json!({
            "name": quantity.name,
            "unit": quantity.unit.name(),
            "before": numbers(&quantity.nominal),
            "after": numbers(&fit.values[q]),
            "deviation": deviations.map(|place| fit.told.deviation(place)).collect::<Vec<f64>>(),
        })
    });
    json!({
        "robot": robot.name,
        "touches": touches.len(),
        "unknowns": estimator.unknowns.len(),
        "cost": fit.cost,
        "before": Misses::of(&estimator.seen(&robot.nominal(), &fit.noise)),
        "after": Misses::of(&fit.seen),
        "held_out": judged,
        "noise": {"points": fit.noise.groups, "joints": fit.noise.joint, "false_share": fit.noise.false_share},
        "quantities": quantities.collect::<Vec<_>>(),
        "untold": fit.told.untold(robot, &estimator.unknowns).iter().map(ToString::to_string).collect::<Vec<_>>(),
    })
}
