//! Where the hands can get to: slices of the reachable map.

use super::ReportInput;
use crate::view::figure;
use crate::view::space::chart;
use crate::view::text::{escape, short_number as number};

/// The picture; a sentence that says how to get one where there is no map yet.
pub(super) fn figure_of(input: &ReportInput) -> String {
    let Some(space) = input.space.filter(|space| !space.slices.is_empty()) else {
        return "<p class=\"note\">There is no map yet: <code>bodyschema reach SESSION</code> works it out and \
                <code>bodyschema report SESSION</code> shows it here.</p>\n"
            .into();
    };
    let litres = space.hands.iter().zip(&space.litres).map(|(hand, [near, far])| {
        format!("{}: {} litres near, {} litres far", escape(hand), number(*near), number(*far))
    });
    let caption = format!(
        "Where {} can get to by the learned schema, in the frame of {}: near by the arm alone, far by leaning{}. \
         Lines are limbs at ease. {}.{}",
        escape(&space.hands.join(" and ")),
        escape(&space.chest),
        if space.hands.len() > 1 { ", for one of them or for more" } else { "" },
        litres.collect::<Vec<_>>().join("; "),
        space.doubts.iter().map(|doubt| format!(" <b>{}.</b>", escape(doubt))).collect::<String>()
    );
    figure("reachable", &chart(space, "Slices of the reachable map"), &caption)
}
