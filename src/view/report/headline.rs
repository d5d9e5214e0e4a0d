//! What a report says first: the verdict in its colour, and the one number.

use super::ReportInput;
use crate::view::text::{error_number, escape, touches};
use crate::view::tone::Tone;

/// The verdict and, where it can be told, how far off what was learned is.
pub(super) fn of(input: &ReportInput) -> String {
    let named = input.undetermined.len() + input.undetermined_limbs.len();
    let tone = |converged: bool| format!(" {}", Tone::new(converged, named).class());
    let tone = input.converged.map_or(String::new(), tone);
    let number = number(input).map_or(String::new(), |(number, what)| {
        let time = input.seconds.map_or(String::new(), |seconds| format!(" in {}", time(seconds)));
        format!(
            "<p class=\"headline\"><strong>{} mm</strong> after {}{time}<br/><small>{what}</small></p>\n",
            escape(&error_number(number)),
            touches(input.touches.len()),
        )
    });
    format!("<p class=\"verdict{tone}\">{}</p>\n{number}", escape(&input.verdict))
}

/// How far off skin is in another limb's frame, millimetres, and whose word that is.
fn number(input: &ReportInput) -> Option<(f64, &'static str)> {
    let of = |mm: f64, what| mm.is_finite().then_some((mm, what));
    match (input.evaluation, input.account) {
        (Some(evaluation), Some(_)) if input.converged == Some(true) => of(
            evaluation.determined_mm.mean,
            "mean error of skin whose place in another limb's frame is claimed, against the model",
        ),
        (Some(evaluation), _) => {
            of(evaluation.heldout_mm.mean, "mean error of skin in another limb's frame, against the model")
        }
        _ => None,
    }
}

/// A time as people say it.
fn time(seconds: f64) -> String {
    match seconds {
        short if short < 60.0 => format!("{short:.1} s"),
        long if long < 3600.0 => format!("{:.0} min", long / 60.0),
        long => format!("{:.1} h", long / 3600.0),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_are_told_in_the_unit_that_fits() {
        assert_eq!([4.31, 90.0, 5400.0].map(time), ["4.3 s", "2 min", "1.5 h"]);
    }
}
