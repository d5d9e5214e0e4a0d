//! What a calibration found: as a person reads it, as JSON, and as files.

use std::fmt::Write;
use std::path::Path;

use nalgebra::{Rotation3, Vector3};
use serde_json::json;

use crate::calibration::robot::{Quantity, Robot, Value};
use crate::calibration::{Estimator, Fit, Judgement, Misses, SeenTouch, Touch, apart_at_random};
use crate::cli::{Failure, Outcome, folders, output};
use crate::record::{RobotFile, RobotFormat, json_of, name_of};

/// The file that holds all.
const CALIBRATION_FILE: &str = "calibration.json";
/// Correlations from which on two parameters are told of, and how many at the most.
const CORRELATED: f64 = 0.95;
const MOST_CORRELATIONS: usize = 5;

/// A robot explains its touches if they are apart by less than this share of what touches mixed at random are.
const EXPLAINED: f64 = 0.5;
/// … and no more of them are false.
const MOST_FALSE: f64 = 0.4;

/// What was found, of whom and by what.
pub(super) struct Results<'a> {
    pub robot: &'a Robot,
    pub touches: &'a [Touch],
    pub estimator: &'a Estimator<'a>,
    pub fit: &'a Fit,
    pub judged: &'a [Judgement],
    pub untold_signs: Vec<usize>,
}

impl Results<'_> {
    /// The touches as they are seen at nominal values.
    fn before(&self) -> Vec<SeenTouch> {
        self.estimator.seen(&self.robot.nominal(), &self.fit.noise)
    }

    /// Quantities that were to be found.
    fn open(&self) -> impl Iterator<Item = (usize, &Quantity)> {
        self.robot.quantities.iter().enumerate().filter(|(_, quantity)| quantity.is_open())
    }

    /// The standard deviations of a quantity's parameters, infinite where they are not told.
    fn deviations(&self, q: usize) -> Vec<f64> {
        let unknowns = &self.estimator.unknowns;
        if self.estimator.open_signs().contains(&q) {
            return vec![if self.untold_signs.contains(&q) { f64::INFINITY } else { 0.0 }];
        }
        let places = (0..self.robot.quantities[q].nominal.size()).filter_map(|part| unknowns.place(q, part));
        places.map(|place| self.fit.told.deviation(place)).collect()
    }

    /// What cannot be told, in sentences.
    fn untold(&self) -> Vec<String> {
        let told = self.fit.told.untold(self.robot, &self.estimator.unknowns);
        let (alone, together): (Vec<_>, Vec<_>) =
            told.into_iter().partition(|untold| untold.names.len() == 1);
        let mut sentences: Vec<String> = together.iter().map(ToString::to_string).collect();
        let signs = self.untold_signs.iter().map(|sign| self.robot.quantities[*sign].name.clone());
        let names: Vec<String> = alone.into_iter().flat_map(|untold| untold.names).chain(signs).collect();
        if !names.is_empty() {
            sentences.push(format!("not told by these touches at all: {}", names.join(", ")));
        }
        sentences
    }

    /// Pairs of parameters that are known together much better than each, the most alike first.
    fn correlations(&self) -> Vec<(String, String, f64)> {
        let unknowns = &self.estimator.unknowns;
        let name = |place: usize| {
            let (q, part) = unknowns.parameters[place];
            self.robot.quantities[q].component_name(part)
        };
        let told: Vec<usize> = (0..unknowns.len()).filter(|place| self.fit.told.is_told(*place)).collect();
        let mut found = Vec::new();
        for (k, i) in told.iter().enumerate() {
            for j in &told[..k] {
                let correlation = self.fit.told.correlation(*i, *j);
                if correlation.abs() >= CORRELATED {
                    found.push((name(*j), name(*i), correlation));
                }
            }
        }
        found.sort_by(|a, b| b.2.abs().total_cmp(&a.2.abs()));
        found
    }

    /// Whether the robot explains its touches, and if not, what may be the reason.
    fn verdict(&self) -> (bool, String) {
        let honest: Vec<SeenTouch> =
            self.fit.seen.iter().filter(|(_, _, seen)| self.fit.noise.honesty(seen) > 0.5).cloned().collect();
        let apart = Misses::of(&honest);
        let false_share = self.fit.noise.false_share;
        let equations: usize = self.fit.seen.iter().map(|(_, _, seen)| seen.residuals.size).sum();
        let unknowns = self.estimator.unknowns.len() - self.fit.told.ties.len();
        let mm = |metres: f64| output::number(1e3 * metres);
        let mend = "limbs or columns may be exchanged, units wrong, or what is off is not among what is said to be unknown";
        // Touches that are taken to be false are not what is explained.
        if let Some(random) = apart_at_random(self.estimator, self.fit)
            && apart.rms >= EXPLAINED * random.rms
        {
            let (apart, random) = (mm(apart.rms), mm(random.rms));
            return (
                false,
                format!(
                    "NOT calibrated: what touched stays {apart} mm apart, and {random} mm with touches mixed at random: \
                     {mend}"
                ),
            );
        }
        if false_share >= MOST_FALSE {
            let share = 100.0 * false_share;
            return (false, format!("NOT calibrated: {share:.0} % of the touches are not explained: {mend}"));
        }
        if equations <= unknowns {
            let reason = format!(
                "NOT calibrated: {equations} equations of {} touches for {unknowns} unknown numbers explain themselves: make \
                 more touches (`bodyschema plan`), or say less to be unknown",
                self.touches.len()
            );
            return (false, reason);
        }
        (true, "calibrated: the touches are explained by what was found".into())
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
        say!("");
        say!("  {:<34}{:>9} {:>9} {:>9} {:>9}", "what touched, apart", "RMS", "median", "95 %", "max");
        let row = |name: &str, misses: &Misses| {
            let numbers =
                [misses.rms, misses.median, misses.p95, misses.max].map(|x| output::number(1e3 * x));
            let [rms, median, p95, max] = numbers;
            say!("  {name:<34}{rms:>9} {median:>9} {p95:>9} {max:>9}  mm");
        };
        row("before", &Misses::of(&self.before()));
        row("after", &Misses::of(&fit.seen));
        if let Some(first) = self.judged.first() {
            let parts =
                if self.judged.len() > 1 { format!("{} × ", self.judged.len()) } else { String::new() };
            let name = |what: &str| format!("{what}, {parts}{} held out", first.touches);
            row(&name("before"), &mean(self.judged, |judgement| judgement.before));
            row(&name("after"), &mean(self.judged, |judgement| judgement.after));
            let count = self.judged.len() as f64;
            let within = self.judged.iter().map(|judgement| judgement.within).sum::<f64>() / count;
            let interval = self.judged.iter().map(|judgement| judgement.interval).sum::<f64>() / count;
            say!(
                "  {:.1} % of what was held out is within the interval that should hold 95 % ({} mm wide on average)",
                100.0 * within,
                output::number(1e3 * interval)
            );
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
        for (a, b, correlation) in self.correlations().into_iter().take(MOST_CORRELATIONS) {
            say!("  {a} and {b} are known together much better than each (correlation {correlation:.3})");
        }
    }

    /// Whether any touch tells of a quantity, alone or with others.
    fn is_touched(&self, q: usize) -> bool {
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
        let correlations = self.correlations().into_iter().map(|(a, b, r)| json!([a, b, r]));
        json!({
            "robot": self.robot.name,
            "touches": self.touches.len(),
            "unknowns": self.estimator.unknowns.len(),
            "calibrated": self.verdict().0,
            "verdict": self.verdict().1,
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
    pub fn write(&self, folder: &Path, path: &Path, file: &RobotFile, quiet: bool) -> Outcome {
        let folder =
            folders::free_folder(Some(folder), "calibration", CALIBRATION_FILE, |_| folder.to_path_buf())?;
        let name = path.file_name().unwrap_or_default();
        let written = file.with_values(path, &self.fit.values)?;
        put(&folder.join(name), &written.bytes)?;
        for sentence in &written.left_out {
            tell!("{}: {sentence}", folder.join(name).display());
        }
        output::file(&folder.join("quantities.csv"), &self.quantities_table())?;
        output::file(&folder.join("residuals.csv"), &self.residuals_table())?;
        let all = serde_json::to_string_pretty(&self.as_json())?;
        output::file(&folder.join(CALIBRATION_FILE), &format!("{all}\n"))?;
        if !quiet {
            let kind = match file.format {
                RobotFormat::Urdf => "URDF",
                RobotFormat::Mjcf => "MJCF",
                RobotFormat::Dh => "table",
                RobotFormat::Json => "description",
            };
            say!("");
            say!(
                "{}: the {kind} with its new numbers, quantities.csv, residuals.csv and {CALIBRATION_FILE}",
                folder.join(name).display()
            );
        }
        Ok(())
    }

    fn quantities_table(&self) -> String {
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

    fn residuals_table(&self) -> String {
        let mut table = String::from("line,a,b,before_mm,after_mm,honest\n");
        let before = self.before();
        let name = |touch: usize, side: usize, end: usize| {
            name_of(self.robot, &self.touches[touch].ends[side][end].feature)
        };
        for ((touch, ends, seen), (_, _, was)) in self.fit.seen.iter().zip(&before) {
            let size = |value: &Vector3<f64>| 1e3 * value.norm();
            let _ = writeln!(
                table,
                "{},{},{},{},{},{:.3}",
                self.touches[*touch].line,
                name(*touch, 0, ends[0]),
                name(*touch, 1, ends[1]),
                size(&was.residuals.value),
                size(&seen.residuals.value),
                self.fit.noise.honesty(seen)
            );
        }
        table
    }
}

/// Writes bytes whole or not at all.
fn put(path: &Path, bytes: &[u8]) -> Outcome {
    crate::record::write_whole(path, bytes).map_err(|error| {
        Failure(format!("cannot write {}: {error}: give another folder with --out", path.display()))
    })
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

fn mean(judged: &[Judgement], of: impl Fn(&Judgement) -> Misses) -> Misses {
    let count = judged.len().max(1) as f64;
    let sum =
        |part: fn(&Misses) -> f64| judged.iter().map(|judgement| part(&of(judgement))).sum::<f64>() / count;
    Misses { rms: sum(|m| m.rms), median: sum(|m| m.median), p95: sum(|m| m.p95), max: sum(|m| m.max) }
}

/// A value as a person reads it.
fn words(value: &Value, factor: f64) -> String {
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
