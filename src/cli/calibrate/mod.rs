//! `bodyschema calibrate`: estimate a robot's calibration parameters from logged contacts.

pub mod plan;

use std::path::{Path, PathBuf};

use super::folders::{Force, new_folder};
use super::open::rehearse;
use super::{Failure, Outcome, output, progress};
use crate::calibration::robot::{Knowledge, Robot};
use crate::calibration::{
    Calibration, Estimator, EstimatorOptions, Fit, Judgement, Touch, add_places, folds, judge, objections,
    put_on_places, split,
};
use crate::given_number::{count, not_negative};
use crate::session::{
    FolderLock, RobotFile, add_fixed_places, is_mjcf, length, read_calibration_log, read_robot, set_prior,
};
use crate::view::report::REPORT_FILE;
use crate::view::report::calibration::{CORRELATED, REACH, as_json, html, tables};

/// The files beside the robot's and the page.
const FILES: [&str; 4] = ["calibration.json", "quantities.csv", "residuals.csv", "correlations.csv"];
/// Correlations that are named at the most.
const MOST_CORRELATIONS: usize = 5;

/// Estimate encoder offsets, joint poses and sensor mounts from logged contacts.
///
/// It starts from the robot's nominal model and a log of contacts. Every quantity has a name, such as elbow.offset,
/// wrist.position or hand.mount.orientation: --free estimates it, --prior estimates it near its given value, --fix keeps it.
#[derive(clap::Args)]
#[command(after_help = format!("Examples:
  bodyschema calibrate examples/robot/arms.urdf examples/robot/touches.csv --free '*.offset'
  bodyschema calibrate examples/robot/arms.urdf examples/robot/touches.csv --prior '*.offset=5deg' --joint-noise auto --folds 5
  bodyschema calibrate examples/robot/arms.urdf examples/robot/touches.csv --free '*.offset' --free 'left_hand.mount.*' --out calibrated\n\n{ROBOT_HELP}"))]
pub struct CalibrateArguments {
    /// The robot: URDF, MJCF, a table of Denavit-Hartenberg parameters (CSV), or a JSON description
    robot: PathBuf,
    /// The log of contacts (CSV)
    log: PathBuf,
    #[command(flatten)]
    unknowns: UnknownArguments,
    #[command(flatten)]
    noise: NoiseArguments,
    #[command(flatten)]
    judging: JudgingArguments,
    /// Folder for the results: the calibrated robot file, a report page, tables of quantities, residuals and
    /// correlations, and everything as JSON
    #[arg(long, short, value_name = "DIR", help_heading = "Output")]
    out: Option<PathBuf>,
    #[command(flatten)]
    force: Force,
    /// Print one JSON object
    #[arg(long, help_heading = "Output")]
    json: bool,
}

/// What robots and logs look like, for the help.
const ROBOT_HELP: &str = r#"Names of quantities; * matches any part of a name:
  JOINT.position  JOINT.axis  JOINT.orientation        pose of a joint (in URDF: on its parent link)
  BODY.position  BODY.orientation                      MJCF: pose of a body in its parent body; the axis is its joint's
  JOINT.a  JOINT.alpha  JOINT.d  JOINT.theta           Denavit-Hartenberg parameters, for a robot given by their table
  JOINT.offset  JOINT.sign  JOINT.gain  JOINT.compliance   encoder and elasticity
  LINK.mount.position  LINK.mount.orientation          pose of the sensor that measures the points on a link
  POINT.position  FRAME.position  SURFACE.radius       tools, receptors, patches, trackers, spheres
  PLACE.position                                       a fixed place in the log, in the root's frame
Columns of a log: limb_a, limb_b (links, points or surfaces), ax, ay, az, bx, by, bz, a_std, b_std, distance, touch (the
same name for unpaired contacts in one posture), place (instead of limb_b: the name of a fixed place, at bx, by, bz in the
root's frame, or free if these are empty), time, and one for each joint. Units are metres and radians unless the column's
name ends in another, such as ax_mm or elbow_deg."#;

/// What is unknown.
#[derive(clap::Args)]
#[command(next_help_heading = "Unknowns")]
struct UnknownArguments {
    /// Quantities to estimate without a prior, by name; * matches any part of a name
    #[arg(long, value_name = "NAME")]
    free: Vec<String>,
    /// Quantities to keep at their given values
    #[arg(long, value_name = "NAME")]
    fix: Vec<String>,
    /// Quantities to estimate near their given values, with this standard deviation
    #[arg(long, value_name = "NAME=DEVIATION")]
    prior: Vec<String>,
    /// Treat recurring points in the log as receptors whose positions are known to this standard deviation
    #[arg(long, value_name = "DEVIATION")]
    places: Option<String>,
}

/// What noise there is.
#[derive(clap::Args)]
#[command(next_help_heading = "Noise")]
struct NoiseArguments {
    /// Standard deviation of the encoders, degrees (millimetres for slides), or auto to estimate it from the touches
    #[arg(long, value_name = "DEG|auto", default_value = "0", value_parser = joint_noise)]
    joint_noise: JointNoise,
    /// Whether touches may be false: no, or maybe to infer it from the data
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
#[command(next_help_heading = "Validation")]
struct JudgingArguments {
    /// Held-out touches for validation: a share of the log, or another log
    #[arg(long, value_name = "SHARE|FILE")]
    held_out: Option<String>,
    /// Repeat the random split this many times, with --held-out SHARE
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = count)]
    splits: usize,
    /// Split the log into this many parts and hold out each in turn
    #[arg(long, value_name = "K", conflicts_with = "held_out", value_parser = clap::value_parser!(u16).range(2..))]
    folds: Option<u16>,
    /// Seed of the random split
    #[arg(long, default_value_t = 1)]
    seed: u64,
}

pub fn run(args: &CalibrateArguments) -> Outcome {
    let (mut file, mut touches) = given(args)?;
    if let Some(deviation) = &args.unknowns.places {
        let deviation = length(deviation).map_err(|fault| format!("--places: {fault}"))?;
        if add_places(&mut file.robot, &mut touches, deviation) == 0 {
            tell!("{}: no point recurs, so --places has no effect", args.log.display());
        }
    }
    let robot = &file.robot;
    let NoiseArguments { joint_noise, false_touches } = args.noise;
    let options = EstimatorOptions { joint_noise, false_touches: false_touches != FalseTouches::No };
    let name = args.robot.file_name().unwrap_or_default().to_string_lossy();
    let files = [&FILES[..], &[REPORT_FILE, &name]].concat();
    let folder = |out| new_folder(out, args.force, "calibration", &files);
    let lock = args.out.as_deref().map(folder).transpose()?;
    let spinner = progress::spinner("calibrating");
    let estimator = Estimator::new(robot, &touches, options);
    if estimator.unknowns.is_empty() && estimator.open_signs().is_empty() {
        return Err("nothing to estimate: give quantities with --free or --prior".into());
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
        print(&found);
    }
    let Some(lock) = lock else { return Ok(()) };
    write(&found, &lock, &args.robot, &file)?;
    if !args.json {
        let ([json, tables @ ..], robot) = (FILES, lock.place().join(&*name));
        let (robot, kind, tables) = (robot.display(), file.format.name(), tables.join(", "));
        say!("\n{robot}: the calibrated {kind}, {REPORT_FILE}, {tables} and {json}");
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
    if let Some(name) = file.unplaced.first() {
        return Err(format!(
            "{place}: joint {name} has no position: give its position and axes, or learn from scratch with \
             `bodyschema learn --creature {place} --log {}`",
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
        if !says_itself && self.free.is_empty() && self.prior.is_empty() {
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

/// Prints what a person wants to know.
fn print(found: &Calibration) {
    let (touches, unknowns) = (found.touches.len(), found.estimator.unknowns.len());
    say!("{}: {touches} touches, {unknowns} parameters to estimate", found.robot.name);
    say!("{}", found.verdict());
    if found.is_calibrated() {
        say!("{REACH}");
    }
    say!("");
    output::table(&tables::misses(found));
    found.held_out().iter().for_each(|sentence| say!("  {sentence}"));
    if found.fit.noise.false_share > 0.0 {
        let share = 100.0 * found.fit.noise.false_share;
        say!("  {share:.1} % of the touches are classified as false; residuals.csv (--out) lists them");
    }
    say!("");
    output::table(&tables::quantities(found));
    found.untold().iter().for_each(|sentence| say!("  {sentence}"));
    for (a, b, correlation) in found.correlations(CORRELATED).into_iter().take(MOST_CORRELATIONS) {
        say!(
            "  {a} and {b} are strongly correlated ({correlation:.3}): their combination is known much better than either"
        );
    }
}

/// Writes the robot with its new numbers, the page and the tables into a folder.
fn write(found: &Calibration, lock: &FolderLock, path: &Path, file: &RobotFile) -> Outcome {
    let (name, folder) = (path.file_name().unwrap_or_default(), lock.part()?);
    let written = file.with_values(path, &found.fit.values)?;
    output::file(&folder.join(name), &written.bytes)?;
    for sentence in &written.left_out {
        tell!("{}: {sentence}", lock.place().join(name).display());
    }
    output::file(&folder.join(REPORT_FILE), html(found, file.format.name()))?;
    let tables = [tables::numbers(found), tables::residuals(found), tables::correlations(found)];
    let tables = tables.iter().map(|table| table.csv());
    let all = format!("{}\n", serde_json::to_string_pretty(&as_json(found))?);
    for (file, content) in FILES.iter().zip(std::iter::once(all).chain(tables)) {
        output::file(&folder.join(file), content)?;
    }
    Ok(lock.commit()?)
}
