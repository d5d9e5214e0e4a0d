//! The tables of the page.

use super::CalibrationReport;
use crate::view::text::{escape, short_number as number};

/// A cell of numbers, with true minus signs.
fn cell(text: &str) -> String {
    format!("<td class=\"number\">{}</td>", escape(&text.replace('-', "−")))
}

/// How far apart what touched is put, before and after.
pub(super) fn misses(report: &CalibrationReport) -> String {
    let row = |(name, misses): &(String, crate::calibration::Misses)| {
        let cells =
            [misses.rms, misses.median, misses.p95, misses.max].map(|metres| cell(&number(1e3 * metres)));
        format!("<tr><th scope=\"row\">{}</th>{}</tr>\n", escape(name), cells.concat())
    };
    let rows: String = report.misses.iter().map(row).collect();
    let fresh = match &report.held_out {
        Some(sentence) => format!(
            "<p>{}</p>\n<p class=\"note\">What was held out was not fitted to: it tells how far apart fresh touches will be \
             put. 95 % are no farther apart than the column says.</p>\n",
            escape(sentence)
        ),
        None => "<p class=\"note\">95 % are no farther apart than the column says. How far apart fresh touches will be put \
                 is told by some that are not fitted to: <code>--held-out 0.3 --splits 10</code>.</p>\n"
            .into(),
    };
    format!(
        "<div class=\"wide\" tabindex=\"0\"><table class=\"errors\">\n<thead><tr><th>Millimetres</th><th class=\"number\">RMS</th>\
         <th class=\"number\">Median</th><th class=\"number\">95 %</th><th class=\"number\">Greatest</th></tr></thead>\n\
         <tbody>\n{rows}</tbody>\n</table></div>\n{fresh}"
    )
}

/// What was found, quantity by quantity.
pub(super) fn quantities(report: &CalibrationReport) -> String {
    let row = |quantity: &super::ReportedQuantity| {
        let untold = quantity.deviations.iter().any(|deviation| !deviation.is_finite());
        let deviations: Vec<String> = quantity.deviations.iter().map(|x| number(*x)).collect();
        format!(
            "<tr><th scope=\"row\"{}>{}</th>{}{}{}{}<td>{}</td></tr>\n",
            if untold { " class=\"open\"" } else { "" },
            escape(&quantity.name),
            cell(&quantity.before),
            cell(&quantity.after),
            cell(&number(quantity.change)),
            cell(&deviations.join(" ")),
            escape(quantity.unit)
        )
    };
    let rows: String = report.quantities.iter().map(row).collect();
    format!(
        "<div class=\"wide\" tabindex=\"0\"><table class=\"errors\">\n<thead><tr><th>Quantity</th><th class=\"number\">Before</th>\
         <th class=\"number\">After</th><th class=\"number\">Change</th><th class=\"number\">± deviation</th><th>Unit</th></tr>\
         </thead>\n<tbody>\n{rows}</tbody>\n</table></div>\n<p class=\"note\">± is one standard deviation of each number; a \
         dash stands, and the name in colour, where these touches do not tell it. Positions are x y z, axes unit vectors, \
         orientations rotation vectors.</p>\n"
    )
}

/// What cannot be told apart.
pub(super) fn untold(report: &CalibrationReport) -> String {
    if report.untold.is_empty() {
        return "<p>The touches tell all that was to be found.</p>\n".into();
    }
    let items: String =
        report.untold.iter().map(|sentence| format!("<li>{}</li>\n", escape(sentence))).collect();
    format!("<ul>\n{items}</ul>\n")
}

/// The parameters that are known together best.
pub(super) fn correlations(report: &CalibrationReport) -> String {
    if report.correlations.is_empty() {
        return "<p>There are no two numbers to be known together.</p>\n".into();
    }
    let row = |(a, b, correlation): &(String, String, f64)| {
        let correlation = format!("{correlation:.3}");
        format!("<tr><th scope=\"row\">{}</th><td>{}</td>{}</tr>\n", escape(a), escape(b), cell(&correlation))
    };
    let rows: String = report.correlations.iter().map(row).collect();
    format!(
        "<div class=\"wide\" tabindex=\"0\"><table class=\"errors\">\n<thead><tr><th>One</th><th>Other</th><th class=\"number\">Correlation</th>\
         </tr></thead>\n<tbody>\n{rows}</tbody>\n</table></div>\n<p class=\"note\">The pairs that are most alike: near 1 or −1 the \
         touches tell little but the sum of the two, or the difference; other postures would tell each. \
         <code>correlations.csv</code> has all pairs.</p>\n"
    )
}
