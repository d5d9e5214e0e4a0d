//! A calibration as a report page: estimated quantities, their uncertainty, and the residuals.

mod charts;
pub(crate) mod tables;

use serde_json::{Value, json};

use super::tables::definitions;
use crate::calibration::robot::Quantity;
use crate::calibration::{Calibration, Misses};
use crate::session::json_of;
use crate::view::page;
use crate::view::table::Table;
use crate::view::text::{error_number, escape};

/// What every calibration is right for.
pub const REACH: &str = "Valid for the contacts in this log: elsewhere, offsets from self-touch alone can be worse than the nominal ones. Priors (--prior) keep them close.";

/// Correlations from which on two parameters are named.
pub(crate) const CORRELATED: f64 = 0.95;

/// A section of the page: its title, and what makes its content.
type Section = (&'static str, fn(&Calibration) -> String);

/// The sections of the page, below what was done.
const SECTIONS: &[Section] = &[
    ("Contact residuals", misses),
    ("Estimated quantities", quantities),
    ("Confounded and unobservable quantities", untold),
    ("Residuals by pair of links", charts::by_pair),
    ("Correlations", correlations),
];

/// The whole page; `kind` is what the robot's file is.
pub fn html(found: &Calibration, kind: &str) -> String {
    let sections = SECTIONS.iter().map(|(title, content)| (*title, content(found)));
    let sections = super::in_sections([("Settings", facts(found, kind))].into_iter().chain(sections));
    let content = format!(
        "<header>\n<h1>{}</h1>\n<p>A robot calibrated from logged contacts</p>\n</header>\n\
         <p class=\"verdict{}\">{}</p>\n<p class=\"note\">{REACH}</p>\n{sections}",
        escape(&found.robot.name),
        if found.is_calibrated() { "" } else { " open" },
        escape(&found.verdict()),
    );
    page(&format!("{}: calibration from logged contacts", found.robot.name), "", &content, "")
}

/// All as one JSON object, in metres and radians.
pub fn as_json(found: &Calibration) -> Value {
    let (fit, noise) = (found.fit, &found.fit.noise);
    let quantity = |(q, quantity): (usize, &Quantity)| {
        json!({
            "name": quantity.name,
            "unit": quantity.unit.name(),
            "before": json_of(&quantity.nominal),
            "after": json_of(&fit.values[q]),
            "change": fit.values[q].distance(&quantity.nominal),
            "deviation": found.deviations(q),
        })
    };
    json!({
        "robot": found.robot.name,
        "touches": found.touches.len(),
        "unknowns": found.estimator.unknowns.len(),
        "calibrated": found.is_calibrated(),
        "verdict": found.verdict(),
        "objections": found.objections,
        "cost": fit.cost,
        "before": Misses::of(&found.before()),
        "after": Misses::of(&fit.seen),
        "held_out": found.judged,
        "noise": { "points": noise.groups, "joints": noise.joint, "false_share": noise.false_share },
        "quantities": found.open().map(quantity).collect::<Vec<_>>(),
        "untold": found.untold(),
        "correlations": found.correlations(CORRELATED),
    })
}

fn facts(found: &Calibration, kind: &str) -> String {
    let noise = &found.fit.noise;
    let millimetres: Vec<String> = noise.groups.iter().map(|metres| error_number(1e3 * metres)).collect();
    let mut facts = vec![
        ("robot", format!("{kind}, {} degrees of freedom", found.robot.dofs.len())),
        ("touches", found.touches.len().to_string()),
        ("estimated parameters", found.estimator.unknowns.len().to_string()),
        ("contact noise, mm", millimetres.join(", ")),
        ("touches classified as false", format!("{:.1} %", 100.0 * noise.false_share)),
    ];
    if noise.joint > 0.0 {
        facts.push(("encoder noise, °", error_number(noise.joint.to_degrees())));
    }
    definitions(facts.into_iter().map(|(name, value)| (name.to_string(), value)))
}

fn misses(found: &Calibration) -> String {
    let held_out = match found.held_out() {
        Some(sentence) => format!(
            "<p>{}</p>\n<p class=\"note\">Held-out touches were not used in the fit; their residuals show what to \
             expect for new touches. 95 % of the residuals are at most the value in the 95 % column.</p>\n",
            escape(&sentence)
        ),
        None => "<p class=\"note\">95 % of the residuals are at most the value in the 95 % column. To see what to expect for new touches, hold some out: <code>--held-out 0.3 --splits 10</code>.</p>\n"
            .into(),
    };
    tables::misses(found).html("errors") + &held_out
}

fn quantities(found: &Calibration) -> String {
    let note = "<p class=\"note\">± is one standard deviation; a dash marks values that these touches do not determine. Positions are x y z, axes unit vectors, orientations rotation vectors.</p>\n";
    tables::quantities(found).html("errors") + note
}

fn untold(found: &Calibration) -> String {
    let item = |sentence: &String| format!("<li>{}</li>\n", escape(sentence));
    match found.untold().as_slice() {
        [] => "<p>The touches determine every estimated quantity.</p>\n".into(),
        sentences => format!("<ul>\n{}</ul>\n", sentences.iter().map(item).collect::<String>()),
    }
}

/// The parameters that are known together best.
fn correlations(found: &Calibration) -> String {
    const MOST: usize = 12;
    let all = found.correlations(0.0).into_iter().take(MOST);
    let rows = all.map(|(one, other, correlation)| [one, other, format!("{correlation:.3}")]);
    let table = Table::new(["One", "Other", "Correlation"], rows);
    if table.is_empty() {
        return "<p>Fewer than two quantities were estimated.</p>\n".into();
    }
    let note = "<p class=\"note\">The most strongly correlated pairs. Near 1 or −1, the touches determine little more than the difference or the sum of the two; other postures would separate them. <code>correlations.csv</code> lists all pairs.</p>\n";
    table.html("errors") + note
}
