//! An axis: its quantity, scale and labels.

use super::{ChartGroup, ChartMark, width_of};
use crate::view::text::{plain, tick_label, ticks};

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

impl Scale {
    /// A logarithmic scale that holds all finite `values`, with room at both ends, and about a decade at least.
    pub fn logarithmic(values: impl IntoIterator<Item = f64>) -> Scale {
        let finite = values.into_iter().filter(|value| value.is_finite()).map(|value| value.max(LEAST));
        let bounds = finite.fold(None, |bounds, value: f64| {
            let (least, greatest): (f64, f64) = bounds.unwrap_or((value, value));
            Some((value.min(least), value.max(greatest)))
        });
        // Without values there is still an axis to draw.
        let (least, greatest) = bounds.unwrap_or((1.0, 10.0));
        let decades = (greatest / least).log10();
        let room = (0.05 * decades).max(0.4 * (1.0 - decades)).max(0.04);
        Scale::Logarithmic(least * 10f64.powf(-room), greatest * 10f64.powf(room))
    }

    /// The same for all that groups draw along an axis, 0 to the right and 1 upwards.
    pub fn logarithmic_of(groups: &[ChartGroup], axis: usize) -> Scale {
        let marks = groups.iter().flat_map(|group| &group.marks);
        Scale::logarithmic(marks.flat_map(ChartMark::points).map(|point| point[axis]))
    }

    /// A linear scale from a value to the greatest of the finite `values`, with some room.
    pub fn linear(from: f64, values: impl IntoIterator<Item = f64>) -> Scale {
        let greatest = values.into_iter().filter(|value| value.is_finite()).fold(from, f64::max);
        let span = if greatest > from { greatest - from } else { 1.0 };
        Scale::Linear(from, from + 1.04 * span)
    }

    /// Whether it counts names.
    pub(super) fn is_named(&self) -> bool {
        matches!(self, Scale::Names(_))
    }

    /// Where a value is along the axis: 0 at its beginning, 1 at its end.
    pub(super) fn share(&self, value: f64) -> f64 {
        match self {
            Scale::Linear(from, to) => (value - from) / (to - from),
            Scale::Logarithmic(least, greatest) => {
                (value.max(LEAST) / least).log10() / (greatest / least).log10()
            }
            Scale::Names(names) => (value + 0.5) / names.len().max(1) as f64,
        }
    }

    pub(super) fn label(&self, value: f64) -> String {
        match self {
            Scale::Linear(..) => plain(value),
            Scale::Logarithmic(..) => tick_label(value),
            Scale::Names(names) => names.get(value.round() as usize).cloned().unwrap_or_default(),
        }
    }

    /// The width of its widest label, pixels.
    pub(super) fn widest(&self) -> f64 {
        self.ticks().into_iter().map(|tick| width_of(&self.label(tick))).fold(0.0, f64::max)
    }

    pub(super) fn ticks(&self) -> Vec<f64> {
        match self {
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn linear_axes_are_labelled_at_round_numbers_and_may_count_from_right_to_left() {
        let labels = |scale: &Scale| scale.ticks().iter().map(|tick| scale.label(*tick)).collect::<Vec<_>>();
        let upwards = Scale::Linear(0.0, 1040.0);
        assert_eq!(labels(&upwards), ["0", "200", "400", "600", "800", "1000"]);
        let turned = Scale::Linear(0.6, -0.6);
        assert_eq!(labels(&turned), ["−0.6", "−0.4", "−0.2", "0", "0.2", "0.4", "0.6"]);
        assert!(turned.share(0.6) < turned.share(-0.6));
    }
}
