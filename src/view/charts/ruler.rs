//! An axis: what it counts, and where it is labelled.

use std::ops::Range;

use plotters::coord::ranged1d::{DefaultFormatting, KeyPointHint, Ranged};

use super::width_of;
use crate::view::text::{bounds, plain, tick_label, ticks};

/// Values below this are drawn as this on a logarithmic axis: rounding, not learning.
const LEAST: f64 = 1e-12;

/// How an axis counts.
#[derive(Clone, Debug, PartialEq)]
pub enum Scale {
    /// Evenly, from one value to another, whichever is greater.
    Linear(f64, f64),
    /// By powers of ten, between two values.
    Logarithmic(f64, f64),
    /// Names, each at its number counted from 0.
    Names(Vec<String>),
}

/// An axis.
#[derive(Clone, Debug)]
pub struct Ruler {
    /// What it shows, with its unit; empty for nothing.
    pub title: String,
    /// How it counts.
    pub scale: Scale,
}

impl Scale {
    /// A logarithmic scale that holds all of `values` that are finite, with room at both ends, and about a decade at
    /// least.
    pub fn logarithmic(values: impl IntoIterator<Item = f64>) -> Scale {
        let values = values.into_iter().filter(|value| value.is_finite()).map(|value| value.max(LEAST));
        // Without values there is still an axis to draw.
        let (least, greatest) = bounds(values).unwrap_or((1.0, 10.0));
        let decades = (greatest / least).log10();
        let room = (0.05 * decades).max(0.4 * (1.0 - decades)).max(0.04);
        Scale::Logarithmic(least * 10f64.powf(-room), greatest * 10f64.powf(room))
    }

    /// A linear scale from a value to the greatest of `values` that are finite, with some room.
    pub fn linear(from: f64, values: impl IntoIterator<Item = f64>) -> Scale {
        let greatest = values.into_iter().filter(|value| value.is_finite()).fold(from, f64::max);
        let span = if greatest > from { greatest - from } else { 1.0 };
        Scale::Linear(from, from + 1.04 * span)
    }

    /// Where a value lies on the even coordinate of its axis, before it is turned round.
    fn even(&self, value: f64) -> f64 {
        match self {
            Scale::Logarithmic(..) => value.max(LEAST).log10(),
            Scale::Linear(..) | Scale::Names(_) => value,
        }
    }
}

impl Ruler {
    /// An axis to the right, which may count from right to left.
    pub(super) fn right(&self) -> Even {
        Even::new(self, matches!(self.scale, Scale::Linear(from, to) if from > to))
    }

    /// An axis upwards; names stand from the top down.
    pub(super) fn up(&self) -> Even {
        Even::new(self, matches!(self.scale, Scale::Names(_)))
    }

    pub(super) fn label(&self, value: f64) -> String {
        match &self.scale {
            Scale::Linear(..) => plain(value),
            Scale::Logarithmic(..) => tick_label(value),
            Scale::Names(names) => names.get(value.round() as usize).cloned().unwrap_or_default(),
        }
    }

    /// The width of its widest label, pixels.
    pub(super) fn widest(&self) -> f64 {
        self.ticks().into_iter().map(|tick| width_of(&self.label(tick))).fold(0.0, f64::max)
    }

    fn ticks(&self) -> Vec<f64> {
        match &self.scale {
            Scale::Linear(from, to) => even_ticks(from.min(*to), from.max(*to)),
            Scale::Logarithmic(least, greatest) => ticks(&(*least..*greatest)),
            Scale::Names(names) => (0..names.len()).map(|k| k as f64).collect(),
        }
    }
}

/// Some six ticks at round numbers.
fn even_ticks(low: f64, high: f64) -> Vec<f64> {
    let wanted = (high - low) / 6.0;
    let decade = 10f64.powf(wanted.log10().floor());
    let step =
        [1.0, 2.0, 5.0, 10.0].map(|m| m * decade).into_iter().find(|step| *step >= wanted).unwrap_or(decade);
    let [first, last] = [(low / step - 1e-9).ceil(), (high / step + 1e-9).floor()];
    if !(last - first).is_finite() {
        return Vec::new();
    }
    (first as i64..=last as i64).map(|k| k as f64 * step).collect()
}

/// The coordinate along an axis as plotters wants it: evenly from one end to the other.
#[derive(Clone)]
pub(super) struct Even {
    scale: Scale,
    turned: bool,
    range: Range<f64>,
    ticks: Vec<f64>,
}

impl Even {
    fn new(ruler: &Ruler, turned: bool) -> Even {
        let scale = ruler.scale.clone();
        let (from, to) = match &scale {
            Scale::Linear(from, to) => (from.min(*to), from.max(*to)),
            Scale::Logarithmic(least, greatest) => (least.log10(), greatest.log10()),
            Scale::Names(names) => (-0.5, names.len() as f64 - 0.5),
        };
        let range = if turned { -to..-from } else { from..to };
        let mut even = Even { scale, turned, range, ticks: Vec::new() };
        even.ticks = ruler.ticks().into_iter().map(|tick| even.coordinate(tick)).collect();
        even
    }

    /// The coordinate of a value.
    pub fn coordinate(&self, value: f64) -> f64 {
        let even = self.scale.even(value);
        if self.turned { -even } else { even }
    }

    /// The value at a coordinate.
    pub fn value(&self, coordinate: f64) -> f64 {
        let even = if self.turned { -coordinate } else { coordinate };
        if matches!(self.scale, Scale::Logarithmic(..)) { 10f64.powf(even) } else { even }
    }
}

impl Ranged for Even {
    type FormatOption = DefaultFormatting;
    type ValueType = f64;

    fn map(&self, value: &f64, (first, last): (i32, i32)) -> i32 {
        let share = (value - self.range.start) / (self.range.end - self.range.start);
        first + (share * f64::from(last - first)).round() as i32
    }

    fn key_points<Hint: KeyPointHint>(&self, _: Hint) -> Vec<f64> {
        self.ticks.clone()
    }

    fn range(&self) -> Range<f64> {
        self.range.clone()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn labels(ruler: &Ruler, even: &Even) -> Vec<String> {
        even.ticks.iter().map(|tick| ruler.label(even.value(*tick))).collect()
    }

    #[test]
    fn linear_axes_are_labelled_at_round_numbers() {
        let ruler = Ruler { title: String::new(), scale: Scale::Linear(0.0, 1040.0) };
        assert_eq!(labels(&ruler, &ruler.right()), ["0", "200", "400", "600", "800", "1000"]);
        let turned = Ruler { title: String::new(), scale: Scale::Linear(0.6, -0.6) };
        let even = turned.right();
        assert_eq!(labels(&turned, &even), ["−0.6", "−0.4", "−0.2", "0", "0.2", "0.4", "0.6"]);
        let place = |value: f64| even.map(&even.coordinate(value), (0, 100));
        assert!(place(0.6) < place(-0.6));
    }
}
