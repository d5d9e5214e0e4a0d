//! What a calibration found, as tables: comma-separated values.

use std::fmt::Write;

use nalgebra::{Rotation3, Vector3};

use super::results::Results;
use crate::calibration::robot::Value;
use crate::session::{joint_cells, joint_titles, name_of};

impl Results<'_> {
    /// What was found, a line for each number.
    pub fn quantities_table(&self) -> String {
        let mut table = String::from("quantity,unit,before,after,change,deviation\n");
        for (q, quantity) in self.open() {
            let (before, after) = (numbers(&quantity.nominal), numbers(&self.fit.values[q]));
            let deviations = self.deviations(q);
            let parts = ["x", "y", "z"];
            for (k, (before, after)) in before.iter().zip(&after).enumerate() {
                let name = if before_is_one(&quantity.nominal) {
                    quantity.name.clone()
                } else {
                    format!("{}.{}", quantity.name, parts[k])
                };
                // Of a direction there is one for each way it turns aside.
                let deviation =
                    deviations.get(k).or(deviations.last()).filter(|deviation| deviation.is_finite());
                let deviation = deviation.map_or(String::new(), ToString::to_string);
                let _ = writeln!(
                    table,
                    "{name},{},{before},{after},{},{deviation}",
                    quantity.unit.name(),
                    after - before
                );
            }
        }
        table
    }

    /// What is left of each touch, and what was read there.
    pub fn residuals_table(&self) -> String {
        let mut table =
            format!("line,a,b,before_mm,after_mm,honest,{}\n", joint_titles(self.robot).join(","));
        let before = self.before();
        let name = |touch: usize, side: usize, end: usize| {
            name_of(self.robot, &self.touches[touch].ends[side][end].feature)
        };
        for ((touch, ends, seen), (_, _, was)) in self.fit.seen.iter().zip(&before) {
            let size = |value: &Vector3<f64>| 1e3 * value.norm();
            let _ = writeln!(
                table,
                "{},{},{},{},{},{:.3},{}",
                self.touches[*touch].line,
                name(*touch, 0, ends[0]),
                name(*touch, 1, ends[1]),
                size(&was.residuals.value),
                size(&seen.residuals.value),
                self.fit.noise.honesty(seen),
                joint_cells(self.robot, &self.touches[*touch].posture).join(",")
            );
        }
        table
    }

    /// How much the parameters that are told are known together, all with all.
    pub fn correlations_table(&self) -> String {
        let told = self.told();
        let names: Vec<&str> = told.iter().map(|(name, _)| name.as_str()).collect();
        let mut table = format!("parameter,{}\n", names.join(","));
        for (name, i) in &told {
            let cells = told.iter().map(|(_, j)| format!("{:.6}", self.fit.told.correlation(*i, *j)));
            let _ = writeln!(table, "{name},{}", cells.collect::<Vec<_>>().join(","));
        }
        table
    }
}

fn before_is_one(value: &Value) -> bool {
    matches!(value, Value::Number(_))
}

fn numbers(value: &Value) -> Vec<f64> {
    match value {
        Value::Position(v) | Value::Direction(v) => v.iter().copied().collect(),
        Value::Orientation(r) => Rotation3::from_matrix_unchecked(*r).scaled_axis().iter().copied().collect(),
        Value::Number(x) => vec![*x],
    }
}
