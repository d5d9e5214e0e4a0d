//! The tables of the page.

use super::ReportInput;
use crate::creature::{Creature, DofKind};
use crate::evaluation::{CramerRaoBound, Evaluation, Summary, axis_errors, touch_misses, touches_across};
use crate::learning::{Account, LimbLine};
use crate::named::plural;
use crate::senses::limb_pairs;
use crate::view::table::Table;
use crate::view::text::{error_number, escape, shell_words};

/// The commands of the session, its numbers, and how it came about and was learned from.
pub(super) fn facts(input: &ReportInput) -> String {
    let ReportInput { session, record, .. } = input;
    let (agent, effort) = (&session.agent, session.effort.as_ref());
    let again = Some(&record.command).filter(|command| **command != session.command);
    let commands = [("Made by", Some(&session.command)), ("Learned by", again)];
    let kept = commands.iter().filter_map(|(what, command)| Some((what, (*command)?)));
    let commands: String = kept
        .filter(|(_, command)| !command.is_empty())
        .map(|(what, command)| format!("<p>{what} <code>{}</code></p>\n", escape(&shell_words(command))))
        .collect();
    let (joints, dof) = (plural(agent.creature().joints().len(), "joint"), agent.creature().dof());
    let pairs = plural(limb_pairs(agent.skin(), input.touches).len(), "pair of limbs");
    let host = record.host.as_ref().or(session.host.as_ref());
    let recording = session.recording.as_ref();
    let simulated = recording.is_none();
    let facts = [
        ("Body", Some(format!("{joints} with {dof} degrees of freedom"))),
        ("Skin", Some(plural(agent.skin().receptors.len(), "receptor"))),
        ("Touches", Some(format!("{} of {pairs}", input.touches.len()))),
        ("program", Some(session.program.clone())),
        ("creature", recording.map(|recording| recording.creature.clone())),
        ("log", recording.map(|recording| recording.log.clone())),
        ("model", simulated.then(|| session.model.clone())),
        ("engine", simulated.then(|| format!("MuJoCo {}", session.engine))),
        ("processor", host.map(|host| host.cpu.clone())),
        ("cores", host.map(|host| host.cores.to_string())),
        ("operating system", host.map(|host| host.os.clone())),
        ("motions", effort.map(|effort| effort.of_motions.motions.to_string())),
        ("babbling", effort.map(|effort| format!("{:.2} s", effort.babbling_s))),
        ("babbling ended", effort.and_then(|effort| Some(effort.ended_by?.to_string()))),
        ("simulated", effort.and_then(|effort| Some(format!("{:.0} s", effort.simulated_s()?)))),
    ];
    let facts = facts.into_iter().filter_map(|(name, value)| Some((name.to_string(), value?)));
    let seed = ("Seed".to_string(), input.seed().to_string());
    commands + &definitions(facts.chain(record.facts.iter().cloned()).chain([seed]))
}

/// A list of names and values.
pub(super) fn definitions(facts: impl IntoIterator<Item = (String, String)>) -> String {
    let row = |(name, value): (String, String)| {
        format!("<div><dt>{}</dt><dd>{}</dd></div>\n", escape(&name), escape(&value))
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
        ("surface position in another limb's frame", "mm", Some(evaluation.heldout_mm)),
        (
            "the same, located limbs only",
            "mm",
            Some(evaluation.determined_mm).filter(|all| all.mean.is_finite()),
        ),
        ("the same, pairs with a hand", "mm", evaluation.hand_mm),
        ("angle between axes", "°", Some(evaluation.axis_deg)),
        ("distance between axis lines", "mm", Some(evaluation.axis_line_mm)),
    ];
    rows.into_iter().filter_map(|(name, unit, summary)| Some((name, unit, summary?))).collect()
}

/// The error measures, where the truth is known, and the contact residual.
pub(super) fn errors(input: &ReportInput) -> String {
    let residual = touch_misses(&input.session.agent, input.schema, input.touches);
    let residual = ("contact residual of all touches", "mm", residual);
    let rows = input.evaluation.map_or(Vec::new(), error_rows);
    let table = summaries(rows.into_iter().chain([residual])).html("errors");
    let Some(evaluation) = input.evaluation else {
        return format!(
            "{table}<p class=\"note\">The true body is not known, so no other errors could be measured.</p>\n"
        );
    };
    let bound = evaluation.bound_mm.as_ref();
    let bound = bound.map_or(String::new(), |bound| format!(" The {}.", bound_in_words(bound)));
    format!(
        "{table}<p class=\"note\">Surface positions are compared at random postures that were not babbled. 95 % of the \
         errors are at most the value in the 95 % column.{}</p>\n",
        escape(&bound)
    )
}

/// The error beside its bound, both as root mean squares, in words.
pub fn bound_in_words(bound: &CramerRaoBound) -> String {
    let beside = match bound.at_floor {
        true => "the touches fit to numerical precision".to_string(),
        false => format!(
            "{:.2} times the Cramér-Rao bound of {} mm, which applies to the average over sessions",
            bound.ratio,
            error_number(bound.bound_rms)
        ),
    };
    format!("RMS of the located limbs: {} mm; {beside}", error_number(bound.error_rms))
}

/// What the touches leave open, in sentences.
pub(super) fn undetermined(input: &ReportInput) -> String {
    if input.converged() == Some(false) {
        return "<p>All joints: no held-out touches confirm the schema, so no bounds can be given.</p>\n"
            .into();
    }
    let listed = |names: &[String]| escape(&names.join(", "));
    let joints = input.session.agent.creature().joints();
    let open = &input.record.undetermined;
    let mut html = match open.len() {
        0 => "<p>No joint is undetermined.</p>\n".to_string(),
        count => format!(
            "<p>The touches do not determine {count} of {}: {}. Their positions are guesses.</p>\n",
            plural(joints.len(), "joint"),
            listed(open)
        ),
    };
    let limbs = &input.record.undetermined_limbs;
    if !limbs.is_empty() {
        let count = plural(limbs.len(), "limb");
        html += &format!("<p>{count} could not be located: {}.</p>\n", listed(limbs));
    }
    if !input.record.open_directions.is_empty() {
        let items: String = input
            .record
            .open_directions
            .iter()
            .map(|words| format!("<li>{}</li>\n", escape(words)))
            .collect();
        let all_located = open.is_empty() && limbs.is_empty();
        let title = match all_located {
            true => {
                "Unobservable, but without effect on the positions of located limbs relative to each other:"
            }
            false => "Unobservable directions:",
        };
        html += &format!("<p>{title}</p>\n<ul>\n{items}</ul>\n");
    }
    html
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
    let Some(account) = input.record.reliable_account() else {
        return "<p class=\"note\">No bounds: no held-out touches confirm the schema.</p>\n".into();
    };
    let note = input.record.floor_note().map_or(String::new(), |note| format!(" {note}"));
    format!(
        "{}<p class=\"note\">95 % bounds on the surface error of each limb, in the frames of the other limbs \
         located relative to it: the best and the worst of these frames. A dash means no bound.{note}</p>\n",
        limb_table(account, input.session.agent.creature()).html("limbs")
    )
}

/// The table of joints: a row per degree of freedom, the first of which has the numbers of the joint.
pub(super) fn joints(input: &ReportInput) -> String {
    let creature = input.session.agent.creature();
    let undetermined = input.undetermined();
    let [involved, _] = touches_across(&input.session.agent, input.touches);
    let errors = input.truth.map(|truth| axis_errors(creature, truth, input.schema, &undetermined, &[]));
    let mut rows = Vec::new();
    for (j, joint) in creature.joints().iter().enumerate() {
        let determined = if undetermined.contains(&j) { "no" } else { "yes" };
        let limb = creature.limbs()[joint.parent].clone();
        let position = input.schema.positions[j].iter().map(|x| coordinate(1e3 * x, 1));
        let std = input.std.map(|std| std.positions[j].map(|m| error_number(1e3 * m.unwrap_or(f64::NAN))));
        let mut of_joint = vec![joint.name.clone(), limb, involved[j].to_string(), determined.to_string()];
        of_joint.extend(position.chain(std.into_iter().flatten()));
        for (dof, k) in joint.dofs.iter().zip(joint.dof_indices()) {
            let short = dof.name.strip_prefix(&format!("{}_", joint.name)).unwrap_or(&dof.name);
            let is_ball = dof.kind == DofKind::Ball;
            let name = match joint.dofs.len() {
                _ if is_ball => "unlimited",
                1 => "",
                _ => short,
            };
            let axis = input.schema.axes[k].iter();
            let axis = axis.map(|x| if is_ball { String::new() } else { coordinate(*x, 3) });
            let std = input.std.map(|std| std.axes[k].map_or(f64::NAN, f64::to_degrees));
            let off = errors.as_ref().map(|errors| {
                // Dashes where there is none that means anything.
                let found = errors.iter().find(|error| error.dof == k);
                [found.map(|e| e.degrees), found.and_then(|e| e.line_millimetres)]
            });
            let off = off.into_iter().flatten().map(|error| error.unwrap_or(f64::NAN));
            let numbers = std.into_iter().chain(off).map(error_number);
            let of_dof = std::iter::once(name.to_string()).chain(axis).chain(numbers);
            rows.push(of_joint.iter().cloned().chain(of_dof).collect::<Vec<_>>());
            of_joint[1..].fill(String::new());
        }
    }
    let titles = [
        (true, &["Joint", "Parent limb", "Touches", "Determined", "x, mm", "y, mm", "z, mm"][..]),
        (input.std.is_some(), &["± x, mm", "± y, mm", "± z, mm"]),
        (true, &["DOF", "axis x", "axis y", "axis z"]),
        (input.std.is_some(), &["±, °"]),
        (errors.is_some(), &["error, °", "error, mm"]),
    ];
    let titles = titles.iter().filter(|(there, _)| *there).flat_map(|(_, titles)| titles.iter().copied());
    let std_note = input.std.map_or("", |_| {
        " ± is one standard deviation as estimated by the learner; for an axis, that of each coordinate \
         perpendicular to it. A dash means undetermined."
    });
    format!(
        "{}<p class=\"note\">Positions and axes are in the parent limb's frame. Touches counts those between \
         limbs with the joint on the path between them. A position along the axis is unobservable, so errors are \
         the angle between the true and the learned axis (°) and the distance between their lines \
         (mm).{std_note}</p>\n",
        Table::new(titles, rows).html("joints")
    )
}

/// A coordinate to some digits, with no sign before zero.
fn coordinate(value: f64, digits: i32) -> String {
    let scale = 10f64.powi(digits);
    format!("{:.*}", digits as usize, (value * scale).round() / scale + 0.0)
}
