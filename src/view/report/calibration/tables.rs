//! The tables of a calibration, for its page, for a terminal, and as files.

use crate::calibration::Calibration;
use crate::calibration::robot::Value;
use crate::session::{joint_cells, joint_titles, name_of};
use crate::view::table::{NONE, Table};
use crate::view::text::error_number;

/// Contact residuals, before and after, millimetres.
pub fn misses(found: &Calibration) -> Table {
    let row = |(name, misses): (String, crate::calibration::Misses)| {
        let numbers = [misses.rms, misses.median, misses.p95, misses.max];
        std::iter::once(name).chain(numbers.map(|metres| error_number(1e3 * metres)))
    };
    Table::new(["Contact residual, mm", "RMS", "Median", "95 %", "Max"], found.misses().into_iter().map(row))
}

/// Estimated quantities, quantity by quantity, in units for readers.
pub fn quantities(found: &Calibration) -> Table {
    let row = |q: usize| {
        let (quantity, after) = (&found.robot.quantities[q], &found.fit.values[q]);
        let (factor, unit) = quantity.unit.for_readers();
        let deviation = |x: f64| if x.is_finite() { error_number(factor * x) } else { NONE.into() };
        let deviations: Vec<String> = found.deviations(q).into_iter().map(deviation).collect();
        let change = error_number(factor * after.distance(&quantity.nominal));
        let [before, after] = [&quantity.nominal, after].map(|value| words(value, factor));
        [quantity.name.clone(), before, after, change, deviations.join(" "), unit.into()]
    };
    let touched = found.open().map(|(q, _)| q).filter(|q| found.is_touched(*q));
    Table::new(["Quantity", "Before", "After", "Change", "± deviation", "Unit"], touched.map(row))
}

/// A value as a person reads it.
fn words(value: &Value, factor: f64) -> String {
    let (digits, factor) = match value {
        Value::Position(_) | Value::Orientation(_) => (3, factor),
        Value::Direction(_) => (4, 1.0),
        Value::Number(_) => (4, factor),
    };
    let words = value.numbers().into_iter().map(|number| format!("{:.*}", digits, number * factor));
    words.collect::<Vec<_>>().join(" ")
}

/// Estimated quantities, a row for each number, in metres and radians.
pub fn numbers(found: &Calibration) -> Table {
    let rows = found.open().flat_map(|(q, quantity)| {
        let (before, after) = (quantity.nominal.numbers(), found.fit.values[q].numbers());
        let deviations = found.deviations(q);
        (0..before.len()).map(move |k| {
            // Of a direction there is one for each way it turns aside.
            let deviation = deviations.get(k).or(deviations.last()).filter(|deviation| deviation.is_finite());
            let part = if before.len() == 1 { "" } else { [".x", ".y", ".z"][k] };
            let [name, unit] = [format!("{}{part}", quantity.name), quantity.unit.name().into()];
            let [before, after, change] = [before[k], after[k], after[k] - before[k]].map(|x| x.to_string());
            [name, unit, before, after, change, deviation.map_or(String::new(), ToString::to_string)]
        })
    });
    Table::new(["quantity", "unit", "before", "after", "change", "deviation"], rows)
}

/// What is left of each touch, and what was read there.
pub fn residuals(found: &Calibration) -> Table {
    let titles = ["line", "a", "b", "before_mm", "after_mm", "honest"].map(String::from);
    let rows = found.fit.seen.iter().zip(found.before()).map(|(seen, was)| {
        let touch = &found.touches[seen.touch];
        let [a, b] = touch.features(seen.ends).map(|feature| name_of(found.robot, feature));
        let [before, after] = [&was, seen].map(|seen| (1e3 * seen.apart()).to_string());
        let honest = format!("{:.3}", found.fit.noise.inlier_probability(seen));
        let own = [touch.line.to_string(), a, b, before, after, honest];
        own.into_iter().chain(joint_cells(found.robot, &touch.posture))
    });
    Table::new(titles.into_iter().chain(joint_titles(found.robot)), rows)
}

/// The correlations of the parameters that are determined, all with all.
pub fn correlations(found: &Calibration) -> Table {
    let told = found.told();
    let rows = told.iter().map(|(name, i)| {
        let cells = told.iter().map(|(_, j)| format!("{:.6}", found.fit.told.correlation(*i, *j)));
        std::iter::once(name.clone()).chain(cells)
    });
    Table::new(std::iter::once("parameter").chain(told.iter().map(|(name, _)| name.as_str())), rows)
}
