//! What a calibration found: as a person reads it, as JSON, and as files.

use std::path::Path;

use nalgebra::{Rotation3, Vector3};
use serde_json::json;

use crate::calibration::robot::{Quantity, Robot, Value};
use crate::calibration::{Estimator, FEWEST_HELD_OUT, Fit, Judgement, Misses, Objection, SeenTouch, Touch};
use crate::cli::folders::{Force, free_folder};
use crate::cli::{Failure, Outcome, output};
use crate::session::{FolderLock, RobotFile, RobotFormat, json_of};
use crate::view::report::REPORT_FILE;
use crate::view::report::calibration::html;

/// The file that holds all.
const CALIBRATION_FILE: &str = "calibration.json";
/// Tables of quantities, residuals and correlations.
const TABLE_FILES: [&str; 3] = ["quantities.csv", "residuals.csv", "correlations.csv"];
/// Correlations from which on two parameters are told of, and how many at the most.
const CORRELATED: f64 = 0.95;
const MOST_CORRELATIONS: usize = 5;

/// What every calibration is right for.
pub(super) const REACH: &str = "It is right for what was touched: elsewhere offsets from self-touch alone may be worse than the maker's, \
     and priors (--prior) keep them near.";

/// What was found, of whom and by what.
pub(super) struct Results<'a> {
    pub robot: &'a Robot,
    pub touches: &'a [Touch],
    pub estimator: &'a Estimator<'a>,
    pub fit: &'a Fit,
    pub judged: &'a [Judgement],
    pub objections: &'a [Objection],
}

impl Results<'_> {
    /// The touches as they are seen at nominal values.
    pub fn before(&self) -> Vec<SeenTouch> {
        self.estimator.seen(&self.robot.nominal(), &self.fit.noise)
    }

    /// Quantities that were to be found.
    pub fn open(&self) -> impl Iterator<Item = (usize, &Quantity)> {
        self.robot.quantities.iter().enumerate().filter(|(_, quantity)| quantity.is_open())
    }

    /// The standard deviations of a quantity's parameters, infinite where they are not told.
    pub fn deviations(&self, q: usize) -> Vec<f64> {
        let unknowns = &self.estimator.unknowns;
        if self.estimator.open_signs().contains(&q) {
            return vec![if self.fit.untold_signs.contains(&q) { f64::INFINITY } else { 0.0 }];
        }
        let places = (0..self.robot.quantities[q].nominal.size()).filter_map(|part| unknowns.place(q, part));
        places.map(|place| self.fit.told.deviation(place)).collect()
    }

    /// What cannot be told, in sentences.
    pub fn untold(&self) -> Vec<String> {
        let told = self.fit.told.untold(self.robot, &self.estimator.unknowns);
        let (alone, together): (Vec<_>, Vec<_>) =
            told.into_iter().partition(|untold| untold.names.len() == 1);
        let mut sentences: Vec<String> = together.iter().map(ToString::to_string).collect();
        let signs = self.fit.untold_signs.iter().map(|sign| self.robot.quantities[*sign].name.clone());
        let names: Vec<String> = alone.into_iter().flat_map(|untold| untold.names).chain(signs).collect();
        if !names.is_empty() {
            sentences.push(format!(
                "not determined by these touches, and left at the maker's value: {}",
                names.join(", ")
            ));
        }
        sentences
    }

    /// Parameters that are told, by their names and places among the unknowns.
    pub fn told(&self) -> Vec<(String, usize)> {
        let parameters = self.estimator.unknowns.parameters.iter().enumerate();
        parameters
            .filter(|(place, _)| self.fit.told.is_told(*place))
            .map(|(place, (q, part))| (self.robot.quantities[*q].component_name(*part), place))
            .collect()
    }

    /// Pairs of parameters and how much they are known together, the most alike first; those of `least` or more.
    pub fn correlations(&self, least: f64) -> Vec<(String, String, f64)> {
        let told = self.told();
        let mut found = Vec::new();
        for (k, (name, i)) in told.iter().enumerate() {
            for (other, j) in &told[..k] {
                let correlation = self.fit.told.correlation(*i, *j);
                if correlation.abs() >= least {
                    found.push((other.clone(), name.clone(), correlation));
                }
            }
        }
        found.sort_by(|a, b| b.2.abs().total_cmp(&a.2.abs()));
        found
    }

    /// Whether the robot explains its touches, and if not, what speaks against it.
    pub fn verdict(&self) -> (bool, String) {
        let sentences: Vec<String> = self.objections.iter().map(ToString::to_string).collect();
        match sentences.is_empty() {
            true => (true, "calibrated: the touches are explained by what was found".into()),
            false => (false, format!("NOT calibrated: {}", sentences.join("; "))),
        }
    }

    /// How far apart what touched is put, before and after.
    pub fn misses(&self) -> Vec<(String, Misses)> {
        let of_all = [("before", Misses::of(&self.before())), ("after", Misses::of(&self.fit.seen))];
        let mut misses = of_all.map(|(name, misses)| (name.to_string(), misses)).to_vec();
        if self.fit.noise.false_share > 0.0 {
            misses.push(("after, without false ones".into(), Misses::of(&self.fit.honest())));
        }
        if let Some(first) = self.judged.first() {
            let parts =
                if self.judged.len() > 1 { format!("{} × ", self.judged.len()) } else { String::new() };
            let name = |what: &str| format!("{what}, {parts}{} held out", first.touches);
            misses.push((name("before"), mean(self.judged, |judgement| judgement.before)));
            misses.push((name("after"), mean(self.judged, |judgement| judgement.after)));
        }
        misses
    }

    /// How many of the touches that were held out are where the deviations say.
    pub fn held_out(&self) -> Option<String> {
        let count = (!self.judged.is_empty()).then_some(self.judged.len() as f64)?;
        let within = self.judged.iter().map(|judgement| judgement.within).sum::<f64>() / count;
        let interval = self.judged.iter().map(|judgement| judgement.interval).sum::<f64>() / count;
        let rows: usize = self.judged.iter().map(|judgement| judgement.touches).sum();
        if rows < FEWEST_HELD_OUT {
            return Some(format!(
                "too few held-out rows to check an interval that should hold 95 %: {rows}, at least {FEWEST_HELD_OUT}"
            ));
        }
        Some(format!(
            "{:.1} % of what was held out is within the interval that should hold 95 % ({} mm wide on average)",
            100.0 * within,
            output::number(1e3 * interval)
        ))
    }

    /// Prints what a person wants to know.
    pub fn print(&self) {
        let (robot, fit) = (self.robot, self.fit);
        say!(
            "{}: {} touches, {} unknown numbers",
            robot.name,
            self.touches.len(),
            self.estimator.unknowns.len()
        );
        say!("{}", self.verdict().1);
        if self.verdict().0 {
            say!("{REACH}");
        }
        say!("");
        say!("  {:<34}{:>9} {:>9} {:>9} {:>9}", "what touched, apart", "RMS", "median", "95 %", "max");
        let row = |name: &str, misses: &Misses| {
            let numbers =
                [misses.rms, misses.median, misses.p95, misses.max].map(|x| output::number(1e3 * x));
            let [rms, median, p95, max] = numbers;
            say!("  {name:<34}{rms:>9} {median:>9} {p95:>9} {max:>9}  mm");
        };
        for (name, misses) in self.misses() {
            row(&name, &misses);
        }
        if let Some(sentence) = self.held_out() {
            say!("  {sentence}");
        }
        if fit.noise.false_share > 0.0 {
            let share = 100.0 * fit.noise.false_share;
            say!("  {share:.1} % of the touches are taken to be false: residuals.csv (--out) says which");
        }
        say!("");
        say!("  {:<34}{:>30} {:>30}  ± deviation", "quantity", "before", "after");
        let touched: Vec<usize> = self.open().map(|(q, _)| q).filter(|q| self.is_touched(*q)).collect();
        for q in touched {
            let quantity = &robot.quantities[q];
            let (factor, unit) = quantity.unit.for_readers();
            let deviations: Vec<String> = self
                .deviations(q)
                .into_iter()
                .map(
                    |deviation| {
                        if deviation.is_finite() { output::number(factor * deviation) } else { "?".into() }
                    },
                )
                .collect();
            say!(
                "  {:<34}{:>30} {:>30}  {} {unit}",
                quantity.name,
                words(&quantity.nominal, factor),
                words(&fit.values[q], factor),
                deviations.join(" ")
            );
        }
        let untold = self.untold();
        if !untold.is_empty() {
            say!("");
        }
        for sentence in untold {
            say!("  {sentence}");
        }
        for (a, b, correlation) in self.correlations(CORRELATED).into_iter().take(MOST_CORRELATIONS) {
            say!("  {a} and {b} are known together much better than each (correlation {correlation:.3})");
        }
    }

    /// Whether any touch tells of a quantity, alone or with others.
    pub fn is_touched(&self, q: usize) -> bool {
        let unknowns = &self.estimator.unknowns;
        let mut places =
            (0..self.robot.quantities[q].nominal.size()).filter_map(|part| unknowns.place(q, part));
        self.estimator.open_signs().contains(&q)
            || places.any(|place| !self.fit.told.ties.contains(&vec![place]))
    }

    /// All as one JSON object, in metres and radians.
    pub fn as_json(&self) -> serde_json::Value {
        let quantities = self.open().map(|(q, quantity)| {
            json!({
                "name": quantity.name,
                "unit": quantity.unit.name(),
                "before": json_of(&quantity.nominal),
                "after": json_of(&self.fit.values[q]),
                "change": self.fit.values[q].distance(&quantity.nominal),
                "deviation": self.deviations(q),
            })
        });
        let correlations = self.correlations(CORRELATED).into_iter().map(|(a, b, r)| json!([a, b, r]));
        json!({
            "robot": self.robot.name,
            "touches": self.touches.len(),
            "unknowns": self.estimator.unknowns.len(),
            "calibrated": self.verdict().0,
            "verdict": self.verdict().1,
            "objections": self.objections,
            "cost": self.fit.cost,
            "before": Misses::of(&self.before()),
            "after": Misses::of(&self.fit.seen),
            "held_out": self.judged,
            "noise": {
                "points": self.fit.noise.groups,
                "joints": self.fit.noise.joint,
                "false_share": self.fit.noise.false_share,
            },
            "quantities": quantities.collect::<Vec<_>>(),
            "untold": self.untold(),
            "correlations": correlations.collect::<Vec<_>>(),
        })
    }

    /// Writes the robot with its new numbers and the tables into a folder.
    pub fn write(&self, lock: FolderLock, path: &Path, file: &RobotFile, quiet: bool) -> Outcome {
        let name = path.file_name().unwrap_or_default();
        let [quantities, residuals, correlations] = TABLE_FILES;
        let folder = lock.part()?;
        let written = file.with_values(path, &self.fit.values)?;
        output::file(&folder.join(name), &written.bytes)?;
        for sentence in &written.left_out {
            tell!("{}: {sentence}", lock.place().join(name).display());
        }
        output::file(&folder.join(quantities), self.quantities_table())?;
        output::file(&folder.join(residuals), self.residuals_table())?;
        output::file(&folder.join(correlations), self.correlations_table())?;
        output::file(&folder.join(REPORT_FILE), html(&self.report(file)))?;
        let all = serde_json::to_string_pretty(&self.as_json())?;
        output::file(&folder.join(CALIBRATION_FILE), format!("{all}\n"))?;
        lock.commit()?;
        if !quiet {
            let kind = kind(file.format);
            say!("");
            say!(
                "{}: the {kind} with its new numbers, {REPORT_FILE}, quantities.csv, residuals.csv, correlations.csv and \
                 {CALIBRATION_FILE}",
                lock.place().join(name).display()
            );
        }
        Ok(())
    }
}

/// The folder for the results about a robot, whose file gets there as well.
pub(super) fn folder(out: &Path, force: Force, robot: &Path) -> Result<FolderLock, Failure> {
    let [quantities, residuals, correlations] = TABLE_FILES;
    let robot = robot.file_name().unwrap_or_default().to_string_lossy();
    let files = [CALIBRATION_FILE, quantities, residuals, correlations, REPORT_FILE, &robot];
    free_folder(Some(out), force, "calibration", &files, |_| out.to_path_buf())
}

/// What a file is called.
pub(super) fn kind(format: RobotFormat) -> &'static str {
    match format {
        RobotFormat::Urdf => "URDF",
        RobotFormat::Mjcf => "MJCF",
        RobotFormat::Dh => "table",
        RobotFormat::Json => "description",
    }
}

fn mean(judged: &[Judgement], of: impl Fn(&Judgement) -> Misses) -> Misses {
    let count = judged.len().max(1) as f64;
    let sum =
        |part: fn(&Misses) -> f64| judged.iter().map(|judgement| part(&of(judgement))).sum::<f64>() / count;
    Misses { rms: sum(|m| m.rms), median: sum(|m| m.median), p95: sum(|m| m.p95), max: sum(|m| m.max) }
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
