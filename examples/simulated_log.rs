//! A log as a robot with encoders that are off would make it, to try a calibration before anything is measured:
//! `cargo run --release --example simulated_log examples/robot/arms.urdf examples/robot/touches.csv`.

use std::error::Error;
use std::fs;
use std::path::PathBuf;

use bodyschema::{
    Agent, Estimator, EstimatorOptions, Knowledge, RobotTouch, SessionRequest, Value, add_joint_noise,
    add_point_noise, calibration_table, misread, plan, point_touches, read_robot,
};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// Touches that are found in simulation, and those that are made.
const FOUND: usize = 3000;
const MADE: usize = 120;
/// Encoders are off by so many degrees at the most, and noisy; so is the skin, metres.
const OFF: f64 = 5.0;
const JOINT_NOISE: f64 = 0.05;
const POINT_NOISE: f64 = 0.5e-3;

fn main() -> Result<(), Box<dyn Error>> {
    let mut paths = std::env::args().skip(1).map(PathBuf::from);
    let (Some(model), Some(log)) = (paths.next(), paths.next()) else {
        return Err("give a URDF file and the log to write".into());
    };
    let robot = read_robot(&model)?.robot;
    let babbled = Agent::from_mjcf(&model)?.babble_as(&SessionRequest::at_random(FOUND, 1))?;
    let embodied = babbled.embodied();
    let schema = &embodied.truth().schema;
    let found = point_touches(embodied.agent(), schema, &robot, babbled.touches());

    // Those that tell most of what encoders read.
    let mut unknown = robot.clone();
    unknown.set_knowledge("*.offset", Knowledge::Free)?;
    let estimator = Estimator::new(&unknown, &found, EstimatorOptions::default());
    let noise = estimator.noise(POINT_NOISE, JOINT_NOISE.to_radians());
    let chosen = plan(&estimator, &unknown.nominal(), &noise, MADE);
    let mut touches: Vec<RobotTouch> =
        chosen.touches.iter().map(|planned| found[planned.candidate].clone()).collect();

    let mut rng = ChaCha8Rng::seed_from_u64(1);
    let mut truth = robot.nominal();
    for dof in &robot.dofs {
        if let Some(quantities) = dof.quantities {
            let off: f64 = rng.random_range(-OFF..OFF);
            truth[quantities.offset] = Value::Number(off.to_radians());
            println!("{}: {off:.2}°", robot.quantities[quantities.offset].name);
        }
    }
    misread(&robot, &truth, &mut touches);
    add_joint_noise(&robot, &mut touches, JOINT_NOISE.to_radians(), &mut rng);
    add_point_noise(&mut touches, POINT_NOISE, &mut rng);
    let all: Vec<_> = touches.iter().collect();
    Ok(fs::write(log, calibration_table(&robot, &all, &[]))?)
}
