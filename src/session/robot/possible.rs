//! Numbers of a robot that no robot can have, whatever file they are from.

use crate::calibration::robot::{Form, Robot, Unit, Value};
use crate::creature::DofKind;
use crate::plausible::{
    GREATEST_ANGLE, GREATEST_COEFFICIENT, GREATEST_LENGTH, is_angle, is_length, place_fault, pose_fault,
    shape_fault,
};

/// The greatest mass, kilograms: that of the heaviest ships.
const GREATEST_MASS: f64 = 1e9;
/// The greatest acceleration by which masses weigh, m/s².
const GREATEST_GRAVITY: f64 = 1e4;

/// What is wrong with a robot, and the mend.
pub(super) fn fault(robot: &Robot) -> Option<String> {
    let quantities = robot.quantities.iter().filter_map(|quantity| {
        let fault = match (&quantity.nominal, quantity.unit) {
            (Value::Position(place), _) => place_fault(place),
            (Value::Direction(_) | Value::Orientation(_), _) => None,
            (Value::Number(x), Unit::Metre) => beyond(*x, is_length(*x), GREATEST_LENGTH, "metres"),
            (Value::Number(x), Unit::Radian) => beyond(*x, is_angle(*x), GREATEST_ANGLE, "radians"),
            (Value::Number(x), _) => {
                beyond(*x, x.abs() <= GREATEST_COEFFICIENT, GREATEST_COEFFICIENT, "a number")
            }
        };
        fault.map(|fault| format!("{} {fault}", quantity.name))
    });
    let ranges = robot.dofs.iter().filter_map(|dof| {
        let (name, [low, high]) = (&dof.name, dof.range);
        let is_possible = if dof.kind == DofKind::Slide { is_length } else { is_angle };
        (!(low <= high && is_possible(low) && is_possible(high))).then(|| {
            format!("the range of {name} is {low} to {high}: give two numbers in order, radians or metres")
        })
    });
    let surfaces = robot.surfaces.iter().filter_map(|surface| {
        let shape = || match &surface.form {
            Form::Solid(shape) => shape_fault(shape),
            Form::Plane => None,
            Form::Sphere(radius) => {
                let possible = robot.quantities[*radius].nominal.number() > 0.0;
                (!possible).then(|| "has no radius above 0: give metres".into())
            }
        };
        let fault = pose_fault(&surface.pose).or_else(shape)?;
        Some(format!("surface {} {fault}", surface.name))
    });
    let masses = robot.masses.iter().filter_map(|mass| {
        let link = &robot.links[mass.link].name;
        if !(0.0..=GREATEST_MASS).contains(&mass.mass) {
            return Some(format!("the mass of {link} is {}: give kilograms from 0 on", mass.mass));
        }
        place_fault(&mass.centre).map(|fault| format!("the centre of the mass of {link} {fault}"))
    });
    let weight = robot.gravity.norm();
    let gravity = (weight.is_nan() || weight > GREATEST_GRAVITY)
        .then(|| format!("its gravity is {:?}: give m/s², such as 0, 0, -9.81", robot.gravity.as_slice()));
    quantities.chain(ranges).chain(surfaces).chain(masses).chain(gravity).next()
}

fn beyond(x: f64, possible: bool, greatest: f64, unit: &str) -> Option<String> {
    (!possible).then(|| format!("is {x}: give {unit} within {greatest}"))
}
