//! What a calibration found, for the page to read.

use super::results::{REACH, Results, kind, words};
use crate::calibration::SeenTouch;
use crate::cli::output;
use crate::session::{RobotFile, name_of};
use crate::view::report::calibration::{CalibrationReport, ReportedQuantity, ReportedTouch};

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
        let one = |(touch, ends, seen): &SeenTouch| {
            let about = &self.touches[*touch];
            let name = |side: usize| name_of(self.robot, &about.ends[side][ends[side]].feature);
            ReportedTouch {
                line: about.line,
                between: [name(0), name(1)],
                apart: seen.residuals.value.norm(),
                honesty: self.fit.noise.honesty(seen),
            }
        };
        self.fit.seen.iter().map(one).collect()
    }
}
