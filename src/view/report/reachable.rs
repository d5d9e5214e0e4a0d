//! The reachable workspace: slices of the map.

use super::ReportInput;
use crate::view::figure;
use crate::view::space::chart;
use crate::view::text::{escape, short_number as number};

/// The picture; a sentence that says how to get one where there is no map yet.
pub(super) fn figure_of(input: &ReportInput) -> String {
    let Some(space) = input.space.filter(|space| !space.slices.is_empty()) else {
        return "<p class=\"note\">No map yet: <code>bodyschema reach SESSION</code> computes it, then <code>bodyschema report SESSION</code> shows it here.</p>\n"
            .into();
    };
    let litres = space.hands.iter().zip(&space.litres).map(|(hand, [near, far])| {
        format!("{}: {} litres near, {} litres far", escape(hand), number(*near), number(*far))
    });
    let caption = format!(
        "Workspace of {} according to the learned schema, in the frame of {}: near with the arm alone, far when \
         leaning{}. Lines are limbs in the rest posture. {}.{}",
        escape(&space.hands.join(" and ")),
        escape(&space.chest),
        if space.hands.len() > 1 { ", for one hand or several" } else { "" },
        litres.collect::<Vec<_>>().join("; "),
        space.doubts.iter().map(|doubt| format!(" <b>{}.</b>", escape(doubt))).collect::<String>()
    );
    figure("reachable", &chart(space, "Slices of the reachable map"), &caption)
}
