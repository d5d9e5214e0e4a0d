//! What a report says first: the verdict in its colour, and the one number.

use super::ReportInput;
use crate::named::plural;
use crate::view::text::{error_number, escape};
use crate::view::tone::Tone;

/// The verdict; how much of the body is located, and, where the truth is known, how far off that is.
pub(super) fn of(input: &ReportInput) -> String {
    let tone = input.converged().map_or(String::new(), |_| format!(" {}", Tone::of(input.record).name()));
    let verdict = escape(&input.record.verdict);
    let Some(evaluation) = input.evaluation else {
        return format!("<p class=\"verdict{tone}\">{verdict}</p>\n");
    };
    let (error, located, of) = match input.record.reliable_account() {
        Some(account) => {
            let (located, all) = (account.located().len(), account.limbs().len());
            (evaluation.determined_mm.mean, format!("{located} of {all} limbs located<br/>"), "located limbs")
        }
        None => (evaluation.heldout_mm.mean, String::new(), "all limbs"),
    };
    if !error.is_finite() {
        return format!("<p class=\"verdict{tone}\">{verdict}</p>\n");
    }
    let babbling = input.session.effort.map_or(0.0, |effort| effort.babbling_s);
    let time =
        input.record.seconds.map_or(String::new(), |learning| format!(" in {}", time(babbling + learning)));
    format!(
        "<p class=\"verdict{tone}\">{verdict}</p>\n<p class=\"headline\">{located}<strong>{} mm</strong> after {}{time}<br/>\
         <small>mean surface error of {of} relative to one another, compared with the true model</small></p>\n",
        escape(&error_number(error)),
        plural(input.touches.len(), "touch"),
    )
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
