//! What a calibration found, for the page to read.

use nalgebra::{Rotation3, Vector3};

use super::results::{REACH, Results, kind};
use crate::calibration::Feature;
use crate::calibration::robot::{RobotDof, Unit, Value};
use crate::cli::output;
use crate::creature::DofKind;
use crate::record::{RobotFile, name_of};
use crate::view::report::calibration::{CalibrationReport, ReportedJoint, ReportedQuantity, ReportedTouch};

/// Pairs of parameters that are known together, at the most.
const MOST_PAIRS: usize = 12;

impl Results<'_> {
    /// All that the page tells.
    pub fn report(&self, file: &RobotFile) -> CalibrationReport {
        let (calibrated, verdict) = self.verdict();
        let mut correlations = self.correlations(0.0);
        correlations.truncate(MOST_PAIRS);
        CalibrationReport {
            robot: self.robot.name.clone(),
            calibrated,
            verdict,
            reach: REACH,
            facts: self.facts(file),
            misses: self.misses(),
            held_out: self.held_out(),
            quantities: self
                .open()
                .filter(|(q, _)| self.is_touched(*q))
                .map(|(q, _)| self.quantity(q))
                .collect(),
            untold: self.untold(),
            correlations,
            touches: self.reported_touches(),
            joints: self.robot.leaders().filter(|dof| dof.kind != DofKind::Ball).map(joint).collect(),
        }
    }

    fn facts(&self, file: &RobotFile) -> Vec<(String, String)> {
        let (robot, noise) = (self.robot, &self.fit.noise);
        let millimetres: Vec<String> =
            noise.groups.iter().map(|metres| output::number(1e3 * metres)).collect();
        let mut facts = vec![
            ("robot", format!("{}, {} degrees of freedom", kind(file.format), robot.dofs.len())),
            ("touches", self.touches.len().to_string()),
            ("unknown numbers", self.estimator.unknowns.len().to_string()),
            ("noise of touch, mm", millimetres.join(", ")),
        ];
        if noise.joint > 0.0 {
            facts.push(("noise of encoders, °", output::number(noise.joint.to_degrees())));
        }
        facts.push(("touches taken to be false", format!("{:.1} %", 100.0 * noise.false_share)));
        facts.into_iter().map(|(name, value)| (name.to_string(), value)).collect()
    }

    fn quantity(&self, q: usize) -> ReportedQuantity {
        let quantity = &self.robot.quantities[q];
        let (factor, unit) = quantity.unit.for_readers();
        let after = &self.fit.values[q];
        ReportedQuantity {
            name: quantity.name.clone(),
            unit,
            before: words(&quantity.nominal, factor),
            after: words(after, factor),
            change: factor * after.distance(&quantity.nominal),
            deviations: self.deviations(q).into_iter().map(|deviation| factor * deviation).collect(),
        }
    }

    fn reported_touches(&self) -> Vec<ReportedTouch> {
        let robot = self.robot;
        let leaders: Vec<usize> = robot
            .leaders()
            .filter(|dof| dof.kind != DofKind::Ball)
            .filter_map(|leader| robot.dof(&leader.name))
            .collect();
        // What follows a joint has its coordinate.
        let moves = |dof: usize, links: [usize; 2]| {
            let coordinate = robot.dofs[dof].coordinate;
            let same = (0..robot.dofs.len()).filter(|other| robot.dofs[*other].coordinate == coordinate);
            same.into_iter().any(|other| robot.is_between(other, links))
        };
        let one = |(touch, ends, seen): &crate::calibration::SeenTouch| {
            let about = &self.touches[*touch];
            let features = [0, 1].map(|side| about.ends[side][ends[side]].feature);
            let links = features.map(|feature| feature.link(robot));
            let read = leaders.iter().enumerate().filter(|(_, dof)| moves(**dof, links));
            let joints = read.map(|(k, dof)| {
                let RobotDof { kind, coordinate, .. } = robot.dofs[*dof];
                (k, factor(kind) * about.posture[coordinate])
            });
            ReportedTouch {
                line: about.line,
                between: features.map(|feature| name_of(robot, &feature)),
                places: features.map(|feature| self.place(&feature)),
                apart: seen.residuals.value.norm(),
                honesty: self.fit.noise.honesty(seen),
                joints: joints.collect(),
            }
        };
        self.fit.seen.iter().map(one).collect()
    }

    /// What a feature is called whenever it touches: a point by its coordinates.
    fn place(&self, feature: &Feature) -> String {
        let name = name_of(self.robot, feature);
        match *feature {
            Feature::Point(link, p) if !self.robot.is_place(link) => {
                let [x, y, z] = [p.x, p.y, p.z].map(|x| format!("{:.1}", 1e3 * x + 0.0).replace('-', "−"));
                format!("{name} {x} {y} {z}")
            }
            _ => name,
        }
    }
}

/// What a reading is multiplied by for a reader.
fn factor(kind: DofKind) -> f64 {
    unit(kind).for_readers().0
}

fn unit(kind: DofKind) -> Unit {
    if kind == DofKind::Slide { Unit::Metre } else { Unit::Radian }
}

fn joint(dof: &RobotDof) -> ReportedJoint {
    ReportedJoint { name: dof.name.clone(), unit: unit(dof.kind).for_readers().1 }
}

/// A value as a person reads it.
pub(super) fn words(value: &Value, factor: f64) -> String {
    let three = |v: Vector3<f64>, decimals: usize| {
        format!("{:.*} {:.*} {:.*}", decimals, v.x, decimals, v.y, decimals, v.z)
    };
    match value {
        Value::Position(at) => three(at * factor, 3),
        Value::Direction(axis) => three(*axis, 4),
        Value::Orientation(rotation) => {
            three(Rotation3::from_matrix_unchecked(*rotation).scaled_axis() * factor, 3)
        }
        Value::Number(number) => format!("{:.4}", number * factor),
    }
}
