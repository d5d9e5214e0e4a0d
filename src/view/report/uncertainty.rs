//! How sure the learner is of every joint.

use super::ReportInput;
use super::joint_errors::MOST_JOINTS;
use crate::creature::DofKind;
use crate::schema::SchemaStd;
use crate::view::charts::{Chart, ChartGroup, ChartMark, Ink, Panel, Ruler, Scale};
use crate::view::figure;
use crate::view::text::{bounds, short_number as number};

/// Height of a joint's row, and width of either panel, pixels.
const ROW: f64 = 17.0;
const WIDTH: f64 = 285.0;

/// A deviation: the number of its joint, what it is called, and how much it is; none where nothing determines it.
struct Deviation {
    joint: usize,
    name: String,
    value: Option<f64>,
}

/// The picture; a sentence where the learner cannot tell.
pub(super) fn figure_of(input: &ReportInput) -> String {
    let Some(std) = input.std else {
        return "<p class=\"note\">There is no account of how sure it is: no held-out touches confirm the schema.</p>\n".into();
    };
    let [mut positions, mut axes] = deviations(input, std);
    let count = input.agent.creature().joints().len();
    let shown = least_sure(count, [&positions, &axes]);
    let known = positions.iter().filter(|deviation| deviation.value == Some(0.0)).count();
    for list in [&mut positions, &mut axes] {
        list.retain_mut(|deviation| match shown.binary_search(&deviation.joint) {
            Ok(row) => {
                deviation.joint = row;
                true
            }
            Err(_) => false,
        });
    }
    let joints = input.agent.creature().joints();
    let names: Vec<String> = shown.iter().map(|&joint| joints[joint].name.clone()).collect();
    let panels = vec![
        panel(&positions, "position", "mm", Ink::Blue, names.clone()),
        // The same rows: their names stand before the first panel.
        panel(&axes, "axis", "°", Ink::Green, vec![String::new(); names.len()]),
    ];
    let mut caption =
        "One standard deviation by the learner's own account: of each coordinate of a joint's position, \
         and of each axis across its direction. Crosses stand for what no touch determines."
            .to_string();
    if known > 0 {
        caption.push_str(" What was known exactly in advance is not shown.");
    }
    if shown.len() < count {
        caption.push_str(&format!(" Of {count} joints it shows the {} that are known least.", shown.len()));
    }
    figure("uncertainty", &Chart { says: "Uncertainty of every joint".into(), panels }, &caption)
}

/// The joints that are shown, in their order: all, unless there are too many. What is open is known least of all.
fn least_sure(count: usize, [positions, axes]: [&[Deviation]; 2]) -> Vec<usize> {
    let mut worst = vec![[0.0f64; 2]; count];
    for (k, list) in [positions, axes].into_iter().enumerate() {
        for deviation in list {
            let value = deviation.value.unwrap_or(f64::INFINITY);
            worst[deviation.joint][k] = worst[deviation.joint][k].max(value);
        }
    }
    let mut joints: Vec<usize> = (0..count).collect();
    let unsure = |&joint: &usize| worst[joint];
    joints.sort_by(|a, b| {
        let (a, b) = (unsure(a), unsure(b));
        b[0].total_cmp(&a[0]).then(b[1].total_cmp(&a[1]))
    });
    joints.truncate(MOST_JOINTS);
    joints.sort_unstable();
    joints
}

fn deviations(input: &ReportInput, std: &SchemaStd) -> [Vec<Deviation>; 2] {
    let (mut positions, mut axes) = (Vec::new(), Vec::new());
    for (j, joint) in input.agent.creature().joints().iter().enumerate() {
        let coordinates = std.positions.get(j).into_iter().flatten();
        for (coordinate, value) in ["x", "y", "z"].into_iter().zip(coordinates) {
            let name = format!("{}, {coordinate}", joint.name);
            positions.push(Deviation { joint: j, name, value: value.map(|metres| 1e3 * metres) });
        }
        for (k, dof) in joint.dof_indices().zip(&joint.dofs).filter(|(_, dof)| dof.kind != DofKind::Ball) {
            let value = std.axes.get(k).copied().flatten();
            axes.push(Deviation { joint: j, name: dof.name.clone(), value: value.map(f64::to_degrees) });
        }
    }
    [positions, axes]
}

/// Dots for what is known and crosses for what is open.
fn panel(list: &[Deviation], what: &str, unit: &str, ink: Ink, names: Vec<String>) -> Panel {
    let known = |deviation: &&Deviation| deviation.value.is_some_and(|value| value > 0.0);
    let values = || list.iter().filter(known).filter_map(|deviation| deviation.value);
    let (least, greatest) = bounds(values()).unwrap_or((1e-3, 1e-3));
    let open: Vec<&Deviation> = list.iter().filter(|deviation| deviation.value.is_none()).collect();
    // What is open stands beyond all that is not.
    let beyond = greatest * (greatest / least).powf(0.12).max(2.0);
    let farthest = if open.is_empty() { greatest } else { beyond };
    let dot = |deviation: &Deviation| {
        let value = deviation.value.unwrap_or_default();
        let says = format!("{}: {} {unit}", deviation.name, number(value));
        ChartMark::dot([value, deviation.joint as f64], 3.2, says)
    };
    let cross = |deviation: &&Deviation| ChartMark::Dot {
        at: [beyond, deviation.joint as f64],
        radius: 3.6,
        cross: true,
        says: format!("{}: undetermined", deviation.name),
    };
    let group = |name: String, ink: Ink, marks: Vec<ChartMark>| ChartGroup { name, ink, marks };
    let plot = [WIDTH, ROW * names.len() as f64];
    let mut groups = Vec::new();
    if values().next().is_some() {
        groups.push(group(what.into(), ink, list.iter().filter(known).map(dot).collect()));
    }
    if !open.is_empty() {
        groups.push(group(format!("{what} undetermined"), Ink::Orange, open.iter().map(cross).collect()));
    }
    Panel {
        title: String::new(),
        x: Ruler { title: format!("{what}, {unit}"), scale: Scale::logarithmic([least, farthest]) },
        y: Ruler { title: String::new(), scale: Scale::Names(names) },
        groups,
        plot,
    }
}
