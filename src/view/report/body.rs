//! The learned body over the true one, to be turned with the mouse, from the initial guess to the end.

use std::fmt::Write;

use serde_json::Value;

use super::ReportInput;
use crate::named::plural;
use crate::session::Checkpoint;
use crate::view::body::{AURAS, BodyScene, MAP, Pose, certainty, step};

/// Most steps of the slider, …
const MOST_STEPS: usize = 80;
/// … most limbs of all of them: each takes some hundred bytes of the page …
const MOST_LIMBS_OF_STEPS: usize = 6000;
/// … and fewest steps: how it began, how it went on, what came of it.
const FEWEST_STEPS: usize = 3;
/// Most receptors that are drawn: of more, those that were touched most.
const MOST_RECEPTORS: usize = 6000;
/// Height of the picture, pixels.
const HEIGHT: usize = 640;
/// The picture's width by the body's, and the least and most of it by its height.
const ROOM_ABOUT: f64 = 1.5;
const NARROWEST: f64 = 0.7;
const WIDEST: f64 = 1.15;

/// The picture; a sentence where there is nothing to draw.
pub(super) fn figure_of(input: &ReportInput, above: &str) -> String {
    let (agent, creature) = (&input.session.agent, input.session.agent.creature());
    let appearance = input.truth.map(|truth| &truth.appearance);
    let undetermined = input.undetermined();
    let mut scene = BodyScene::of_body(agent, input.schema, &undetermined, appearance, "learned");
    let account = input.record.reliable_account();
    scene.add_kinematics(creature, input.schema, |limb| certainty(creature, account, limb));
    let counts = counts(input);
    let drawn = most_touched(&counts);
    let left_out = counts.len() - drawn.len();
    let most = counts.iter().copied().max().unwrap_or(0);
    let shade = |count: usize| (count as f64).ln_1p() / (most.max(1) as f64).ln_1p();
    let receptors = &agent.skin().receptors;
    let label = |&receptor: &usize| {
        format!("{}: touched {}", receptors[receptor].id, plural(counts[receptor], "time"))
    };
    let labels = drawn.iter().map(label).collect();
    scene.only_receptors(&drawn, labels, drawn.iter().map(|&receptor| shade(counts[receptor])).collect());
    scene.poses = vec![("learned", Pose::at_rest(creature, input.schema))];
    scene.add_joints(agent, &undetermined);
    if let Some(truth) = input.truth {
        scene.poses.push(("true", Pose::at_rest(creature, &truth.schema)));
        scene.add_truth(agent);
    }
    let all = scene.meshes.iter().flat_map(|mesh| scene.poses.iter().map(move |(_, pose)| (mesh, pose)));
    let Some(room) = BodyScene::room_of(all) else {
        return format!("{above}<p class=\"note\">Nothing to draw.</p>\n");
    };
    let bare = scene.meshes[0].is_empty();
    scene.hidden = if bare { vec![AURAS, MAP] } else { vec!["receptors", AURAS, MAP] };
    if bare {
        // Receptors alone have neither limbs to be seen nor auras about them.
        scene.layers.retain(|layer| layer.mesh != 0);
        scene.auras.clear();
    }
    scene.steps = steps(input);
    scene.room = room;
    let sides = room[1] - room[0];
    let aspect = (ROOM_ABOUT * sides.x.max(sides.y) / sides.z).clamp(NARROWEST, WIDEST);
    scene.beside = Some((above.into(), aspect));
    let over = if input.truth.is_some() { " over the true one (grey)" } else { "" };
    let notes = [
        (!bare, " Receptors, if switched on, are coloured by their number of touches.".to_string()),
        (left_out > 0, format!(" The {left_out} least touched receptors are not drawn.")),
        (scene.steps.len() > 1, " While learning plays, the millimetres are the RMS surface error of the limbs that are located in the end.".to_string()),
    ];
    let notes: String = notes.into_iter().filter_map(|(there, note)| there.then_some(note)).collect();
    let caption = format!(
        "The learned body{over}. Drag a limb to pull it, or the background to rotate; click a limb to pick it out in the charts and \
         tables, which light it up here in turn. Keys: arrows rotate, + and − zoom (as Ctrl and the wheel), N and P choose a limb, \
         Shift and arrows pull it, Esc goes back. Orange joints are not determined.{notes}"
    );
    scene.figure(
        &format!("The learned body{over} in three dimensions"),
        HEIGHT,
        &legend(most, &shade),
        &caption,
    )
}

/// How receptors are coloured by their touches.
fn legend(most: usize, shade: &dyn Fn(usize) -> f64) -> String {
    let mut legend = "<div class=\"scale\">touches of a receptor<i></i><div>".to_string();
    let mut last = f64::NEG_INFINITY;
    for count in [0, 1, 3, 10, 30, 100, 300, 1000, 3000, 10_000, 100_000] {
        // A label takes about a seventh of the scale.
        if count <= most && shade(count) - last > 0.14 {
            last = shade(count);
            // Writing to a string cannot fail.
            let _ = write!(legend, "<span style=\"left:{:.0}%\">{count}</span>", 100.0 * last);
        }
    }
    legend + "</div></div>\n"
}

/// The checkpoints that there is room for, the first and the last at any rate.
fn steps(input: &ReportInput) -> Vec<Value> {
    let (creature, touches) = (input.session.agent.creature(), input.touches.len());
    let before: Vec<&Checkpoint> =
        input.record.checkpoints.iter().filter(|at| at.touches < touches).collect();
    let most = (MOST_LIMBS_OF_STEPS / creature.limbs().len().max(1)).clamp(FEWEST_STEPS, MOST_STEPS);
    let every = before.len().div_ceil(most - 1).max(1);
    let earlier = before.iter().step_by(every).map(|at| {
        let name = if at.touches == 0 { "initial guess".to_string() } else { at.touches.to_string() };
        step(&name, at.touches, at.error_rms, &Pose::at_rest(creature, &at.schema))
    });
    let off = input.record.checkpoints.iter().rfind(|at| at.touches == touches).and_then(|at| at.error_rms);
    let last = step(&touches.to_string(), touches, off, &Pose::at_rest(creature, input.schema));
    earlier.chain([last]).collect()
}

/// The receptors that are drawn, in their order: all, unless there are too many.
fn most_touched(counts: &[usize]) -> Vec<usize> {
    let mut receptors: Vec<usize> = (0..counts.len()).collect();
    receptors.sort_by_key(|&receptor| std::cmp::Reverse(counts[receptor]));
    receptors.truncate(MOST_RECEPTORS);
    receptors.sort_unstable();
    receptors
}

/// How often each receptor was touched.
fn counts(input: &ReportInput) -> Vec<usize> {
    let mut counts = vec![0; input.session.agent.skin().receptors.len()];
    input.touches.iter().flat_map(|touch| touch.ends).for_each(|end| counts[end.receptor] += 1);
    counts
}
