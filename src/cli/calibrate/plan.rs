//! `bodyschema plan`: selects the most informative touches.

use std::path::PathBuf;

use super::UnknownArguments;
use crate::calibration::robot::Robot;
use crate::calibration::{Estimator, EstimatorOptions, Plan, Touch, plan};
use crate::cli::open::{ModelArguments, embodied};
use crate::cli::{Outcome, output, progress};
use crate::creature::JointSelection;
use crate::given_number::{count, not_negative};
use crate::session::simulated::point_touches;
use crate::session::{SessionRequest, calibration_table, name_of, read_robot};
use crate::view::table::Table;

/// Select the most informative touches for a calibration.
///
/// The robot's model, with its shapes and joint limits, babbles in simulation. From the touches found, the set that
/// together determines the unknowns best is selected. The table lists the postures to drive to, in degrees, the limbs
/// that touch there, and the gain in precision from each.
#[derive(clap::Args)]
#[command(after_help = "Examples:
  bodyschema plan examples/robot/arms.urdf --free '*.offset' --out plan.csv
  bodyschema plan mjcf/bodies/two_arms.xml --free 'left_*.offset' --free 'left_*.gain' --touches 30 --between left_l7,right_l7")]
pub struct PlanArguments {
    /// The model: MJCF or URDF with collision shapes
    model: PathBuf,
    /// Number of touches to select
    #[arg(long, value_name = "N", default_value_t = 50, value_parser = count)]
    touches: usize,
    /// Number of candidate touches
    #[arg(long, value_name = "N", default_value_t = 3000, value_parser = count)]
    candidates: usize,
    /// Only touches between these links, separated by commas
    #[arg(long, value_name = "LINKS", value_delimiter = ',')]
    between: Vec<String>,
    #[command(flatten)]
    unknowns: UnknownArguments,
    /// Standard deviation of the encoders, degrees
    #[arg(long, value_name = "DEG", default_value_t = 0.1, value_parser = not_negative, help_heading = "Noise")]
    joint_noise: f64,
    /// Standard deviation of contact points, millimetres
    #[arg(long, value_name = "MM", default_value_t = 1.0, value_parser = not_negative, help_heading = "Noise")]
    point_noise: f64,
    /// Seed for babbling
    #[arg(long, default_value_t = 1)]
    seed: u64,
    #[command(flatten)]
    model_arguments: ModelArguments,
    /// File for the table of touches [default: standard output]
    #[arg(long, short, value_name = "FILE", help_heading = "Output")]
    out: Option<PathBuf>,
}

pub fn run(args: &PlanArguments) -> Outcome {
    let source = args.model_arguments.source(&args.model, JointSelection::default());
    let embodied = embodied(source)?;
    let limbs = embodied.creature().limbs().to_vec();
    if let Some(name) = args.between.iter().find(|name| !limbs.contains(name)) {
        return Err(
            format!("--between: there is no link \"{name}\"; choose from {}", limbs.join(", ")).into()
        );
    }
    let spinner = progress::spinner("babbling");
    let babbled = embodied.babble_as(&SessionRequest::at_random(args.candidates, args.seed))?;
    let (agent, truth) = (babbled.embodied().agent(), &babbled.embodied().truth().schema);
    // The file's own frames and names, by which its touches are logged and calibrated.
    let mut robot = read_robot(&args.model)?.robot;
    args.unknowns.apply(&mut robot, false)?;
    let touches: Vec<Touch> = point_touches(agent, truth, &robot, babbled.touches())
        .into_iter()
        .filter(|touch| {
            args.between.is_empty()
                || (0..2).all(|side| args.between.contains(&name_of(&robot, &touch.ends[side][0].feature)))
        })
        .collect();
    if touches.is_empty() {
        return Err("no touch found between these links: choose others, or babble more (--candidates)".into());
    }
    spinner.set_message("selecting");
    let estimator = Estimator::new(&robot, &touches, EstimatorOptions::default());
    let noise = estimator.noise(1e-3 * args.point_noise.max(1e-3), args.joint_noise.to_radians());
    let chosen = plan(&estimator, &robot.nominal(), &noise, args.touches);
    spinner.finish_and_clear();
    let table = table(&robot, &touches, &estimator, &chosen);
    match &args.out {
        None => say!("{}", table.trim_end()),
        Some(path) => {
            output::file(path, table)?;
            report(&robot, &estimator, &chosen, touches.len());
            say!("{}: {} touches to make", path.display(), chosen.touches.len());
        }
    }
    Ok(())
}

/// The touches in the order in which they are to be made, as a log has them.
fn table(robot: &Robot, touches: &[Touch], estimator: &Estimator, plan: &Plan) -> String {
    let chosen: Vec<&Touch> = plan.touches.iter().map(|planned| &touches[planned.candidate]).collect();
    let gains = plan.touches.iter().map(|planned| format!("{:.4}", 1e3 * planned.gain)).collect();
    let tells = plan.touches.iter().map(|planned| estimator.unknowns.name(robot, planned.tells.0));
    let times = plan.touches.iter().map(|planned| format!("{:.2}", planned.tells.1)).collect();
    calibration_table(robot, &chosen, &[("gain_mm", gains), ("tells", tells.collect()), ("times", times)])
}

/// What would be known after all of them.
fn report(robot: &Robot, estimator: &Estimator, plan: &Plan, candidates: usize) {
    say!("{}: {} of {candidates} touches selected", robot.name, plan.touches.len());
    let at_random = plan.at_random.map_or("all".into(), |count| count.to_string());
    say!(
        "  Expected prediction error {} mm, equivalent to {at_random} random touches (lower bound for any {} of \
         these: {} mm).",
        output::number(1e3 * plan.predicted),
        plan.touches.len(),
        output::number(1e3 * plan.floor)
    );
    let rows = estimator.unknowns.parameters.iter().enumerate().map(|(place, (q, part))| {
        let (factor, unit) = robot.quantities[*q].unit.for_readers();
        let deviation = plan.covariance[(place, place)].max(0.0).sqrt();
        [robot.quantities[*q].component_name(*part), output::number(factor * deviation), unit.into()]
    });
    output::table(&Table::new(["quantity", "± deviation", "unit"], rows));
}
