//! The tables of the page.

use super::ReportInput;
use crate::creature::{Creature, DofKind};
use crate::evaluation::{AxisErrors, CramerRaoBound, Evaluation, Summary, axis_errors, touches_across};
use crate::learning::{Account, LimbLine};
use crate::senses::limb_pairs;
use crate::view::table::Table;
use crate::view::text::{error_number, escape, plural, short_number};

/// The numbers of the session, counted and told.
pub(super) fn facts(input: &ReportInput) -> String {
    let creature = input.agent.creature();
    let pairs = limb_pairs(input.agent.skin(), input.touches);
    let joints = plural(creature.joints().len(), "joint");
    let counted = [
        ("Body", format!("{joints} with {} degrees of freedom", creature.dof())),
        ("Skin", plural(input.agent.skin().receptors.len(), "receptor")),
        ("Touches", format!("{} of {}", input.touches.len(), plural(pairs.len(), "pair of limbs"))),
    ];
    let counted = counted.map(|(name, value)| (name.to_string(), value));
    let seed = [("Seed".to_string(), input.seed.to_string())];
    let commands = |(name, command): &(String, String)| {
        format!("<p>{} <code>{}</code></p>\n", escape(name), escape(command))
    };
    let rows = definitions(counted.iter().chain(&input.facts).chain(&seed));
    let commands: String = input.commands.iter().map(commands).collect();
    commands + &rows
}

/// An error as HTML has it.
fn number(value: f64) -> String {
    escape(&error_number(value))
}

/// A list of names and values.
pub(super) fn definitions<'a>(facts: impl IntoIterator<Item = &'a (String, String)>) -> String {
    let row = |(name, value): &(String, String)| {
        format!("<div><dt>{}</dt><dd>{}</dd></div>\n", escape(name), escape(value))
    };
    let rows: String = facts.into_iter().map(row).collect();
    format!("<dl>\n{rows}</dl>\n")
}

/// A table of summaries, each with its unit.
pub fn summaries<'a>(rows: impl IntoIterator<Item = (&'a str, &'a str, Summary)>) -> Table {
    let row = |(name, unit, summary): (&str, &str, Summary)| {
        let [mean, median, p95, max] =
            [summary.mean, summary.median, summary.p95, summary.max].map(error_number);
        [name.to_string(), unit.to_string(), mean, median, p95, max]
    };
    Table::new(["error", "unit", "mean", "median", "95 %", "max"], rows.into_iter().map(row))
}

/// The errors against the truth, each with its unit.
pub fn error_rows(evaluation: &Evaluation) -> Vec<(&'static str, &'static str, Summary)> {
    let rows = [
        ("skin in another limb's frame", "mm", Some(evaluation.heldout_mm)),
        ("the same, of located limbs", "mm", Some(evaluation.determined_mm)),
        ("the same, with a hand as one of the two", "mm", evaluation.hand_mm),
        ("angle between axes", "°", Some(evaluation.axis_deg)),
        ("distance between axis lines", "mm", Some(evaluation.axis_line_mm)),
    ];
    rows.into_iter().filter_map(|(name, unit, summary)| Some((name, unit, summary?))).collect()
}

/// The error measures.
pub(super) fn errors(input: &ReportInput) -> String {
    let Some(evaluation) = input.evaluation else {
        return "<p>The truth is not known, so no error could be measured.</p>\n".into();
    };
    let bound = evaluation.bound_mm.as_ref().map_or(String::new(), bound);
    format!(
        "{}<p class=\"note\">The skin is compared at random postures that were not babbled. 95 % of the values are no \
         greater than the column says.</p>\n{bound}",
        summaries(error_rows(evaluation)).html("errors")
    )
}

/// The error beside the least that there could be.
fn bound(bound: &CramerRaoBound) -> String {
    if bound.at_floor {
        return format!(
            "<p class=\"bound\">Of located limbs the error is {} mm as a root mean square: the touches are explained to \
             the numerical floor.</p>\n",
            number(bound.error_rms)
        );
    }
    format!(
        "<p class=\"bound\">Of located limbs the error is {} mm as a root mean square: {} times the Cramér-Rao bound of \
         {} mm, the least that any unbiased learner could leave on average over many sessions like this one, if their \
         noise is what the learner estimates. A single session may lie below it.</p>\n",
        number(bound.error_rms),
        short_number(bound.ratio),
        number(bound.bound_rms)
    )
}

/// A sentence that names what the touches leave open.
pub(super) fn undetermined(input: &ReportInput) -> String {
    if input.converged == Some(false) {
        return "<p>All joints: no held-out touches confirm the schema, and what touches determine at a wrong schema bounds nothing.</p>\n".into();
    }
    let limbs: Vec<String> = input.undetermined_limbs.iter().map(|limb| escape(limb)).collect();
    let limbs = match limbs.as_slice() {
        [] => String::new(),
        limbs => {
            format!("<p>{} could not be located: {}.</p>\n", plural(limbs.len(), "limb"), limbs.join(", "))
        }
    };
    let directions: String =
        input.open_directions.iter().map(|words| format!("<li>{}</li>\n", escape(words))).collect();
    let all_located = input.undetermined.is_empty() && input.undetermined_limbs.is_empty();
    let directions = match directions.as_str() {
        "" => String::new(),
        items if all_located => format!(
            "<p>Unobservable, but they move no located skin relative to other located skin:</p>\n<ul>\n{items}</ul>\n"
        ),
        items => format!("<p>Unobservable directions:</p>\n<ul>\n{items}</ul>\n"),
    };
    format!("{}{limbs}{directions}", undetermined_joints(input))
}

fn undetermined_joints(input: &ReportInput) -> String {
    let joints = input.agent.creature().joints();
    let names: Vec<String> =
        input.undetermined.iter().filter_map(|&j| joints.get(j)).map(|j| escape(&j.name)).collect();
    if names.is_empty() {
        return "<p>No joint is undetermined.</p>\n".into();
    }
    format!(
        "<p>The touches do not determine {} of {}: {}. Where these are is a guess.</p>\n",
        names.len(),
        plural(joints.len(), "joint"),
        names.join(", ")
    )
}

/// How far off the skin of limbs may be, the limb that is known worst first, millimetres.
pub fn limb_table(account: &Account, creature: &Creature) -> Table {
    let row = |line: LimbLine| {
        let [best, worst] = line.bounds.map(|metres| error_number(1e3 * metres));
        let (limb, why) = (creature.limbs()[line.limb].clone(), line.why.unwrap_or_default());
        [limb, line.touches.to_string(), line.supporting.to_string(), best, worst, why]
    };
    let titles = ["Limb", "touches", "supporting", "best, mm", "worst, mm", "why it is not located"];
    Table::new(titles, account.limb_lines(creature).into_iter().map(row))
}

/// The same on the page; a sentence without an account.
pub(super) fn limbs(input: &ReportInput) -> String {
    let Some(account) = input.account else {
        return "<p class=\"note\">No bounds are given: no held-out touches confirm the schema.</p>\n".into();
    };
    let note = input.bounds_note.map_or(String::new(), |note| format!(" {note}"));
    format!(
        "{}<p class=\"note\">How far off any skin of a limb may be at 95 %, in the frames of the other limbs that are \
         located relative to one another: in that where it is known best, and in that where it is known worst. A dash \
         stands for no bound.{note}</p>\n",
        limb_table(account, input.agent.creature()).html("limbs")
    )
}

/// The table of joints.
pub(super) fn joints(input: &ReportInput) -> String {
    let creature = input.agent.creature();
    let [involved, _] = touches_across(input.agent, input.touches);
    let errors = input.truth.map(|truth| axis_errors(creature, truth, input.schema, input.undetermined, &[]));
    let mut groups = String::new();
    for (j, joint) in creature.joints().iter().enumerate() {
        let determined = !input.undetermined.contains(&j);
        let lines = joint.dofs.len().max(1);
        let cell =
            |class: &str, content: &str| format!("<td rowspan=\"{lines}\" class=\"{class}\">{content}</td>");
        let position: String =
            input.schema.positions[j].iter().map(|x| cell("number", &coordinate(1e3 * x, 1))).collect();
        let position_std = input.std.map_or(String::new(), |std| {
            let millimetres = std.positions[j].map(|m| number(1e3 * m.unwrap_or(f64::NAN)));
            millimetres.iter().map(|std| cell("number", std)).collect()
        });
        let mut row = format!(
            "<th rowspan=\"{lines}\" scope=\"rowgroup\">{}</th>{}{}{}{position}{position_std}",
            escape(&joint.name),
            cell("", &escape(&creature.limbs()[joint.parent])),
            cell("number", &involved[j].to_string()),
            cell(if determined { "" } else { "open" }, if determined { "yes" } else { "no" }),
        );
        groups.push_str("<tbody>\n");
        for (dof, k) in joint.dofs.iter().zip(joint.dof_indices()) {
            let axis: String = match dof.kind {
                DofKind::Ball => "<td colspan=\"3\" class=\"ball\">turns freely</td>".into(),
                _ => input.schema.axes[k]
                    .iter()
                    .map(|x| format!("<td class=\"number\">{}</td>", coordinate(*x, 3)))
                    .collect(),
            };
            let short = dof.name.strip_prefix(&format!("{}_", joint.name)).unwrap_or(&dof.name);
            let name = if lines == 1 { String::new() } else { escape(short) };
            let axis_std = input.std.map_or(String::new(), |std| {
                let degrees = std.axes[k].map_or(f64::NAN, f64::to_degrees);
                format!("<td class=\"number\">{}</td>", number(degrees))
            });
            let error = errors.as_ref().map_or(String::new(), |errors| error_cells(errors, k));
            groups.push_str(&format!("<tr>{row}<td>{name}</td>{axis}{axis_std}{error}</tr>\n"));
            row.clear();
        }
        groups.push_str("</tbody>\n");
    }
    let columns = if errors.is_some() {
        "<th class=\"number\">off by, °</th><th class=\"number\">off by, mm</th>"
    } else {
        ""
    };
    let (position_std, axis_std, std_note) = match input.std {
        Some(_) => (
            "<th colspan=\"3\" class=\"number\">± x y z, mm</th>",
            "<th class=\"number\">±, °</th>",
            " ± is one standard deviation by the learner's own account, of an axis that of each coordinate \
             across it; a dash stands where nothing determines it.",
        ),
        None => ("", "", ""),
    };
    format!(
        "<div class=\"wide\" tabindex=\"0\"><table class=\"joints\">\n<thead><tr><th>Joint</th><th>On limb</th><th class=\"number\">Touches</th>\
         <th>Determined</th><th colspan=\"3\" class=\"number\">Position x y z, mm</th>{position_std}<th>DOF</th>\
         <th colspan=\"3\" class=\"number\">Axis x y z</th>{axis_std}{columns}</tr></thead>\n{groups}</table></div>\n\
         <p class=\"note\">Positions and axes are in the frame of the limb that the joint is on. Touches are \
         those between limbs with the joint on the way from one to the other. A position may slide along \
         its axis unfelt: what counts is how far the axis turns off (°) and passes by (mm).{std_note}</p>\n"
    )
}

/// The errors of one axis; dashes where it has none that mean anything.
fn error_cells(errors: &[AxisErrors], dof: usize) -> String {
    let found = errors.iter().find(|error| error.dof == dof);
    let values = [found.map(|e| e.degrees), found.and_then(|e| e.line_millimetres)];
    values.map(|value| format!("<td class=\"number\">{}</td>", number(value.unwrap_or(f64::NAN)))).concat()
}

/// A coordinate with a true minus sign, and no sign before zero.
fn coordinate(value: f64, digits: usize) -> String {
    let text = format!("{value:.digits$}");
    match text.strip_prefix('-') {
        Some(zero) if zero.chars().all(|c| c == '0' || c == '.') => zero.to_string(),
        Some(positive) => format!("−{positive}"),
        None => text,
    }
}
