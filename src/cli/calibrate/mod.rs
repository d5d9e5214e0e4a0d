//! `bodyschema calibrate`: put a robot's numbers right by its own touches.

pub mod plan;
mod results;

use std::path::{Path, PathBuf};

use super::arguments::{count, not_negative};
use super::folders::Force;
use super::open::rehearse;
use super::{Failure, Outcome, output, progress};
use crate::calibration::robot::{Knowledge, Robot};
use crate::calibration::{
    Calibration, Estimator, EstimatorOptions, Fit, Judgement, Touch, add_places, folds, judge, objections,
    put_on_places, split,
};
use crate::session::{
    RobotFile, add_fixed_places, apply_known, is_mjcf, length, read_calibration_log, read_known, read_robot,
    set_prior,
};
use crate::view::report::calibration::as_json;

/// Put a robot's numbers right by its own touches.
///
/// From what its maker says of it and a log of touches. Whatever may be wrong has a name, such as elbow.offset,
/// wrist.position or skin.orientation: what is free is found, what is nearly known is found near where it is said to be.
#[derive(clap::Args)]
#[command(after_help = format!("Examples:
  bodyschema calibrate examples/robot/arms.urdf examples/robot/touches.csv --free '*.offset'
  bodyschema calibrate examples/robot/arms.urdf examples/robot/touches.csv --prior '*.offset=5deg' --joint-noise auto --folds 5
  bodyschema calibrate examples/robot/arms.urdf examples/robot/touches.csv --free '*.offset' --free 'left_hand.mount.*' --out calibrated\n\n{ROBOT_HELP}"))]
pub struct CalibrateArguments {
    /// The robot: URDF, MJCF, a table of Denavit and Hartenberg's numbers (CSV), or a description in JSON
    robot: PathBuf,
    /// The log of touches: comma-separated values
    log: PathBuf,
    #[command(flatten)]
    unknowns: UnknownArguments,
    #[command(flatten)]
    noise: NoiseArguments,
    #[command(flatten)]
    judging: JudgingArguments,
    /// The folder for results: the robot with its new numbers, a page to read, tables of quantities, residuals and correlations,
    /// and all as JSON
    #[arg(long, short, value_name = "DIR", help_heading = "Output")]
    out: Option<PathBuf>,
    #[command(flatten)]
    force: Force,
    /// Print one JSON object
    #[arg(long, help_heading = "Output")]
    json: bool,
}

/// What robots and logs look like, for the help.
const ROBOT_HELP: &str = r#"What may be unknown, by name; * stands for any part of one:
  JOINT.position  JOINT.axis  JOINT.orientation        where a joint is and how it turns (of URDF: on its parent link)
  BODY.position  BODY.orientation                      of MJCF: where a body is in its parent body; the axis is its joint's
  JOINT.a  JOINT.alpha  JOINT.d  JOINT.theta           the same of a table of Denavit and Hartenberg's numbers
  JOINT.offset  JOINT.sign  JOINT.gain  JOINT.compliance   what its encoder reads, and how far it gives way to a torque
  LINK.mount.position  LINK.mount.orientation          where the skin is whose points are on a link
  POINT.position  FRAME.position  SURFACE.radius       tools, receptors, patches, trackers, spheres
  PLACE.position                                       where a fixed place of the log is, in the root's frame
Columns of a log: limb_a, limb_b (links, points or surfaces), ax, ay, az, bx, by, bz, a_std, b_std, distance, touch (one
name for contacts in one posture that nobody paired), place (in place of limb_b: a fixed place by its name, at bx, by, bz in
the root's frame, or free where these are empty), time, and one for each joint. Metres and radians, or a unit behind the
name, as in ax_mm and elbow_deg."#;

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
    /// Points of the log that recur are receptors, each known to this deviation
    #[arg(long, value_name = "DEVIATION")]
    places: Option<String>,
    /// What is known of joints, as for learn: positions and axes with their deviations
    #[arg(long, value_name = "FILE")]
    known: Option<PathBuf>,
}

/// What noise there is.
#[derive(clap::Args)]
#[command(next_help_heading = "Noise")]
struct NoiseArguments {
    /// Standard deviation of encoders, degrees (millimetres of slides), or auto: as much as the touches show
    #[arg(long, value_name = "DEG|auto", default_value = "0", value_parser = joint_noise)]
    joint_noise: JointNoise,
    /// Whether touches may be false: no, or maybe if the touches show it
    #[arg(long, value_enum, default_value_t)]
    false_touches: FalseTouches,
}

/// The deviation of encoders, radians; `None` if the touches are to show it.
type JointNoise = std::option::Option<f64>;

fn joint_noise(text: &str) -> Result<JointNoise, String> {
    if text == "auto" {
        return Ok(None);
    }
    not_negative(text).map(|degrees| Some(degrees.to_radians())).map_err(|_| "give degrees, or auto".into())
}

#[derive(clap::ValueEnum, Clone, Copy, Default, PartialEq)]
enum FalseTouches {
    No,
    #[default]
    Maybe,
}

/// How it is judged.
#[derive(clap::Args)]
#[command(next_help_heading = "Judging")]
struct JudgingArguments {
    /// Touches that are not fitted to and by which the rest is judged: a share of the log, or another log
    #[arg(long, value_name = "SHARE|FILE")]
    held_out: Option<String>,
    /// Divide the log anew so many times, with --held-out SHARE
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = count)]
    splits: usize,
    /// Divide the log into so many parts and hold out each in turn
    #[arg(long, value_name = "K", conflicts_with = "held_out", value_parser = clap::value_parser!(u16).range(2..))]
    folds: Option<u16>,
    /// Divide the log by another seed
    #[arg(long, default_value_t = 1)]
    seed: u64,
}

pub fn run(args: &CalibrateArguments) -> Outcome {
    let (mut file, mut touches) = given(args)?;
    if let Some(deviation) = &args.unknowns.places {
        let deviation = length(deviation).map_err(|fault| format!("--places: {fault}"))?;
        if add_places(&mut file.robot, &mut touches, deviation) == 0 {
            tell!("{}: no point recurs: --places says nothing.", args.log.display());
        }
    }
    let robot = &file.robot;
    let NoiseArguments { joint_noise, false_touches } = args.noise;
    let options = EstimatorOptions { joint_noise, false_touches: false_touches != FalseTouches::No };
    let lock = args.out.as_deref().map(|out| results::folder(out, args.force, &args.robot)).transpose()?;
    let spinner = progress::spinner("calibrating");
    let estimator = Estimator::new(robot, &touches, options);
    if estimator.unknowns.is_empty() && estimator.open_signs().is_empty() {
        return Err("nothing is unknown: say what is by --free or --prior".into());
    }
    let fit = estimator.fit();
    let judged = args.judging.judged(robot, &touches, options, (&estimator, &fit))?;
    let objections = objections(&estimator, &fit, &judged);
    spinner.finish_and_clear();
    let (touches, judged, objections) = (&touches, &judged, &objections);
    let found = Calibration { robot, touches, estimator: &estimator, fit: &fit, judged, objections };
    if args.json {
        output::json(&as_json(&found))?;
    } else {
        results::print(&found);
    }
    let Some(lock) = lock else { return Ok(()) };
    results::write(&found, &lock, &args.robot, &file)?;
    if !args.json {
        say!("\n{}", results::contents(&lock, &args.robot, &file));
    }
    Ok(())
}

/// The robot with what is known of it, and the touches.
fn given(args: &CalibrateArguments) -> Result<(RobotFile, Vec<Touch>), Failure> {
    if is_mjcf(&args.robot) {
        rehearse(&args.robot)?;
    }
    let mut file = read_robot(&args.robot)?;
    let place = args.robot.display().to_string();
    for note in &file.notes {
        tell!("{place}: {note}");
    }
    let mut unplaced = std::mem::take(&mut file.unplaced);
    if let Some(known) = &args.unknowns.known {
        let creature = file.creature.as_ref().ok_or_else(|| {
            format!("{place} is no description in JSON: say what is known by --prior in place of --known")
        })?;
        let joints = read_known(known, creature)?;
        apply_known(&mut file.robot, creature, &joints);
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
    add_fixed_places(&args.log, &mut file.robot)?;
    args.unknowns.apply(&mut file.robot, file.says_what_is_open)?;
    let log = read_calibration_log(&args.log, &file.robot)?;
    for note in &log.notes {
        tell!("{}: {note}", args.log.display());
    }
    Ok((file, log.touches))
}

impl UnknownArguments {
    /// Says what is unknown of a robot: encoders' offsets, where nothing is said here nor by its file.
    fn apply(&self, robot: &mut Robot, says_itself: bool) -> Outcome {
        if !says_itself && self.free.is_empty() && self.prior.is_empty() && self.known.is_none() {
            let offsets: Vec<_> = robot.dofs.iter().filter_map(|dof| Some(dof.quantities?.offset)).collect();
            offsets.iter().for_each(|&offset| robot.quantities[offset].knowledge[0] = Knowledge::Free);
            tell!("No --free or --prior given: estimating all encoder offsets.");
        }
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
        Ok(())
    }
}

impl JudgingArguments {
    /// What touches that are held out say, part by part.
    fn judged(
        &self,
        robot: &Robot,
        touches: &[Touch],
        options: EstimatorOptions,
        (estimator, fit): (&Estimator, &Fit),
    ) -> Result<Vec<Judgement>, Failure> {
        let one = |[fitted, fresh]: [Vec<Touch>; 2]| {
            let estimator = Estimator::new(robot, &fitted, options);
            judge(&estimator, &estimator.fit(), &fresh)
        };
        if let Some(count) = self.folds {
            let count = usize::from(count).min(touches.len());
            return Ok(folds(touches, count, self.seed).into_iter().map(one).collect());
        }
        let Some(held_out) = &self.held_out else { return Ok(Vec::new()) };
        let Ok(share) = held_out.parse::<f64>() else {
            let mut fresh = read_calibration_log(Path::new(held_out), robot)?;
            put_on_places(robot, &mut fresh.touches);
            return Ok(vec![judge(estimator, fit, &fresh.touches)]);
        };
        if !(share > 0.0 && share < 1.0) {
            return Err(format!(
                "--held-out {held_out}: give a share between 0 and 1, such as 0.3, or a log"
            )
            .into());
        }
        Ok((0..self.splits as u64).map(|k| one(split(touches, share, self.seed + k))).collect())
    }
}
