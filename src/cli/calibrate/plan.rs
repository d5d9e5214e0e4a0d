//! `bodyschema plan`: what to measure next.

use std::path::PathBuf;

use super::UnknownArguments;
use crate::calibration::robot::Robot;
use crate::calibration::{Estimator, EstimatorOptions, Plan, Touch, plan};
use crate::cli::arguments::{count, not_negative};
use crate::cli::open::{ModelArguments, embodied};
use crate::cli::{Outcome, output, progress};
use crate::creature::JointSelection;
use crate::session::simulated::point_touches;
use crate::session::{SessionRequest, calibration_table, name_of, read_robot};
use crate::view::table::Table;

/// Choose the touches that would tell most about what is unknown of a robot.
///
/// From its model, with its shapes and the limits of its joints: it babbles in simulation, and of all touches that it
/// finds those are chosen that together tell most, with what each would tell. The table is a list of postures to
/// drive to, in degrees, with the limbs that meet there.
#[derive(clap::Args)]
#[command(after_help = "Examples:
  bodyschema plan examples/robot/arms.urdf --free '*.offset' --out plan.csv
  bodyschema plan mjcf/bodies/two_arms.xml --free 'left_*.offset' --free 'left_*.gain' --touches 30 --between left_l7,right_l7")]
pub struct PlanArguments {
    /// The model: MJCF or URDF with shapes that may touch
    model: PathBuf,
    /// How many touches to choose
    #[arg(long, value_name = "N", default_value_t = 50, value_parser = count)]
    touches: usize,
    /// How many touches to choose from
    #[arg(long, value_name = "N", default_value_t = 3000, value_parser = count)]
    candidates: usize,
    /// Only touches between these links, with commas between them
    #[arg(long, value_name = "LINKS", value_delimiter = ',')]
    between: Vec<String>,
    #[command(flatten)]
    unknowns: UnknownArguments,
    /// Standard deviation of encoders, degrees
    #[arg(long, value_name = "DEG", default_value_t = 0.1, value_parser = not_negative, help_heading = "Noise")]
    joint_noise: f64,
    /// Standard deviation of where touch is felt, millimetres
    #[arg(long, value_name = "MM", default_value_t = 1.0, value_parser = not_negative, help_heading = "Noise")]
    point_noise: f64,
    /// Babble by another seed
    #[arg(long, default_value_t = 1)]
    seed: u64,
    #[command(flatten)]
    model_arguments: ModelArguments,
    /// The table of touches to make [default: printed]
    #[arg(long, short, value_name = "FILE", help_heading = "Output")]
    out: Option<PathBuf>,
}

pub fn run(args: &PlanArguments) -> Outcome {
    let source = args.model_arguments.source(&args.model, JointSelection::default());
    let embodied = embodied(source)?;
    let limbs = embodied.creature().limbs().to_vec();
    if let Some(name) = args.between.iter().find(|name| !limbs.contains(name)) {
        return Err(
            format!("--between: there is no link \"{name}\": name some of {}", limbs.join(", ")).into()
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
        return Err(
            "no touch was found between these links: name others, or babble more (--candidates)".into()
        );
    }
    spinner.set_message("choosing");
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
    say!("{}: {} of {candidates} touches chosen", robot.name, plan.touches.len());
    let at_random = plan.at_random.map_or("no fewer than all".into(), |count| count.to_string());
    say!(
        "  Touches will then be predicted to {} mm, as by {at_random} at random; no {} of these do better than {} mm.",
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
