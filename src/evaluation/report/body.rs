//! The learned body over the true one, to be turned with the mouse, from the onset to the end.

use nalgebra::Vector3;
use plotly::common::{
    Anchor, ColorBar, ColorScale, ColorScaleElement, Font, HoverInfo, Line, Marker, Mode, Pad, Title,
};
use plotly::layout::update_menu::{Button, ButtonMethod, UpdateMenu, UpdateMenuDirection, UpdateMenuType};
use plotly::layout::{
    AspectMode, Axis, Camera, DragMode3D, LayoutScene, Margin, Slider, SliderCurrentValue, SliderMethod,
    SliderStep,
};
use plotly::mesh3d::Lighting;
use plotly::{Mesh3D, Scatter3D, Trace};
use serde_json::json;

use super::ReportInput;
use super::mesh::Mesh;
use super::picture::{GREY, ORANGE, figure_over, layout};
use super::still::{Over, Piece, still};
use super::text::{escape, plural};
use crate::creature::Creature;
use crate::kinematics::{Frame, limb_frames};
use crate::record::Checkpoint;
use crate::schema::BodySchema;
use crate::skin::Skin;

/// Most corners of all checkpoints together: each takes some twenty bytes of the page.
const MOST_CORNERS: usize = 90_000;
/// Places are told to this, metres.
const EXACT: f64 = 1e-4;
/// The colours of limbs and of joints.
const LIMB: &str = "#b9c7d3";
const JOINT: &str = "#1f6fb2";
/// Letters of buttons, to be read on both of the grounds that plotly.js gives them.
const BUTTON: &str = "#6f8496";
/// Receptors from never touched to touched most often.
const TOUCHED: [(f64, &str); 5] =
    [(0.0, "#93a1ad"), (0.25, "#f6d573"), (0.55, "#f28e3c"), (0.8, "#d7301f"), (1.0, "#7f0018")];
/// How opaque limbs and receptors are where joints are to be seen inside them.
const SEE_THROUGH: [f64; 2] = [0.2, 0.45];
/// How much nearer than it is a receptor counts in the still, metres: the surface below is cut more coarsely.
const LIFT: f64 = 0.05;

/// Where the body is looked at from, with x ahead, y to the left and z up, and how many of its greatest extents
/// away.
const VIEW: [f64; 3] = [0.8, 0.5, 0.18];
const DISTANCE: f64 = 1.4;

/// Coordinates of points, one list per axis.
type Coordinates = [Vec<Option<f64>>; 3];

fn coordinates(points: impl IntoIterator<Item = Option<Vector3<f64>>>) -> Coordinates {
    let mut lists = Coordinates::default();
    for point in points {
        for (k, list) in lists.iter_mut().enumerate() {
            list.push(point.map(|p| (p[k] / EXACT).round() * EXACT).map(|x| (x * 1e4).round() / 1e4));
        }
    }
    lists
}

/// One schema laid out in the root limb's frame, at ease.
struct Pose {
    frames: Vec<Frame>,
    /// Where each limb begins: at its joint, wherever its own frame is.
    begins: Vec<Vector3<f64>>,
}

impl Pose {
    fn new(creature: &Creature, schema: &BodySchema) -> Pose {
        let frames = limb_frames(creature, schema, &creature.reference_posture());
        let placed = creature.joints().iter().zip(&schema.positions);
        let begins = std::iter::once(frames[0].origin)
            .chain(placed.map(|(joint, position)| frames[joint.parent].point(position)))
            .collect();
        Pose { frames, begins }
    }

    fn mesh(&self, mesh: &Mesh) -> Coordinates {
        coordinates(mesh.corners.iter().map(|(limb, p_l)| Some(self.frames[*limb].point(p_l))))
    }

    fn points(&self, mesh: &Mesh) -> Vec<Vector3<f64>> {
        mesh.corners.iter().map(|(limb, p_l)| self.frames[*limb].point(p_l)).collect()
    }

    fn joints(&self) -> Coordinates {
        coordinates(self.begins[1..].iter().map(|p| Some(*p)))
    }

    /// A line from joint to joint, and to the middle of the skin of limbs that carry no other.
    fn bones(&self, creature: &Creature, skin: &Skin) -> Coordinates {
        let lines = self.lines(creature, skin);
        coordinates(lines.into_iter().flat_map(|[from, to]| [Some(from), Some(to), None]))
    }

    /// The ends of each bone.
    fn lines(&self, creature: &Creature, skin: &Skin) -> Vec<[Vector3<f64>; 2]> {
        let mut lines = Vec::new();
        for (joint, end) in creature.joints().iter().zip(&self.begins[1..]) {
            lines.push([self.begins[joint.parent], *end]);
        }
        for (limb, frame) in self.frames.iter().enumerate() {
            let carries = creature.joints().iter().any(|joint| joint.parent == limb);
            let own: Vec<_> = skin.receptors.iter().filter(|r| r.limb == limb).map(|r| r.position).collect();
            if !carries && !own.is_empty() {
                let middle = own.iter().sum::<Vector3<f64>>() / own.len() as f64;
                lines.push([self.begins[limb], frame.point(&middle)]);
            }
        }
        lines
    }
}

/// What is drawn of the learned body, in the order of its traces.
struct Drawn {
    limbs: Mesh,
    receptors: Mesh,
}

impl Drawn {
    fn lists(&self, input: &ReportInput, schema: &BodySchema) -> [Coordinates; 4] {
        let pose = Pose::new(input.creature, schema);
        [
            pose.mesh(&self.limbs),
            pose.mesh(&self.receptors),
            pose.bones(input.creature, input.skin),
            pose.joints(),
        ]
    }
}

/// The picture; a sentence where there is nothing to draw.
pub(super) fn body(input: &ReportInput) -> String {
    let drawn =
        Drawn { limbs: Mesh::of_surfaces(input.skin), receptors: Mesh::of_receptors(&input.skin.receptors) };
    let last = drawn.lists(input, input.schema);
    let steps = steps(input, &drawn, &last);
    let truth = input.truth.map(|truth| {
        let pose = Pose::new(input.creature, truth);
        let bare = drawn.limbs.corners.is_empty();
        let bones = if bare { pose.bones(input.creature, input.skin) } else { Coordinates::default() };
        [pose.mesh(&drawn.limbs), bones, pose.joints()]
    });
    let shown = steps.iter().flat_map(|(_, lists)| lists).chain(truth.iter().flatten());
    let Some(scene) = scene(shown) else {
        return "<p class=\"note\">There is nothing to draw.</p>\n".into();
    };
    let mut traces = learned(input, &drawn, last);
    traces.extend(truth.map(|lists| true_body(input, &drawn, lists)).into_iter().flatten());
    let mut layout = layout().scene(scene).margin(Margin::new().left(0).right(0).top(8).bottom(20));
    if !drawn.limbs.corners.is_empty() {
        layout = layout.update_menus(vec![buttons()]);
    }
    if steps.len() > 1 {
        layout = layout.sliders(vec![slider(&steps)]);
    }
    let over = if input.truth.is_some() { " over the true one, grey" } else { "" };
    let caption = format!(
        "The learned body{over}, at ease. Turn it with the mouse, zoom with the wheel, click a name to hide it. \
         Patches are receptors, coloured by how often they were touched; orange joints are those that the touches \
         do not determine.{}",
        if steps.len() > 1 {
            " The slider goes from a random onset to what was learned in the end."
        } else {
            ""
        }
    );
    let says = format!("The learned body{over} in three dimensions");
    figure_over("body", &says, 660, traces, layout, &caption, &still_of(input, &drawn))
}

/// What is to be seen of the learned body before it can be turned.
fn still_of(input: &ReportInput, drawn: &Drawn) -> String {
    let pose = Pose::new(input.creature, input.schema);
    let places = pose.points(&drawn.limbs);
    let limbs = drawn.limbs.triangles.iter().map(|triangle| Piece {
        corners: triangle.map(|corner| places[corner]).to_vec(),
        colour: red_green_blue(LIMB),
        lift: 0.0,
    });
    let counts = counts(input);
    let most = (counts.iter().copied().max().unwrap_or(0).max(1) as f64).ln_1p();
    let places = pose.points(&drawn.receptors);
    let receptors = places.chunks(4).zip(&counts).map(|(corners, count)| Piece {
        corners: corners.to_vec(),
        colour: between(&TOUCHED, (*count as f64).ln_1p() / most),
        lift: LIFT,
    });
    let pieces: Vec<Piece> = limbs.chain(receptors).collect();
    let joints = pose.begins[1..].iter().enumerate();
    let over = Over {
        lines: pose.lines(input.creature, input.skin),
        line_colour: JOINT,
        points: joints.map(|(joint, place)| (*place, colour_of(input, joint))).collect(),
    };
    still(&pieces, &over, &Vector3::from(VIEW))
}

/// Orange where the touches do not determine a joint.
fn colour_of(input: &ReportInput, joint: usize) -> &'static str {
    if input.undetermined.contains(&joint) { ORANGE } else { JOINT }
}

/// A colour written as #rrggbb.
fn red_green_blue(colour: &str) -> [f64; 3] {
    [1, 3, 5].map(|at| u8::from_str_radix(&colour[at..at + 2], 16).map_or(0.0, f64::from))
}

/// The colour at `share` of a scale.
fn between(scale: &[(f64, &str)], share: f64) -> [f64; 3] {
    let above = scale.iter().position(|(at, _)| share <= *at).unwrap_or(scale.len() - 1).max(1);
    let ((low, from), (high, to)) = (scale[above - 1], scale[above]);
    let part = ((share - low) / (high - low)).clamp(0.0, 1.0);
    let (from, to) = (red_green_blue(from), red_green_blue(to));
    [0, 1, 2].map(|k| from[k] + part * (to[k] - from[k]))
}

/// The checkpoints that there is room for, the first and the last at any rate: what each is called and the lists
/// of its traces.
fn steps(input: &ReportInput, drawn: &Drawn, last: &[Coordinates; 4]) -> Vec<(String, [Coordinates; 4])> {
    let corners: usize = last.iter().map(|lists| lists[0].len()).sum::<usize>().max(1);
    let room = (MOST_CORNERS / corners).max(2);
    let touches = input.touches.len();
    let before: Vec<&Checkpoint> =
        input.checkpoints.iter().filter(|checkpoint| checkpoint.touches < touches).collect();
    let every = before.len().div_ceil(room - 1).max(1);
    let name = |touches: usize| if touches == 0 { "onset".to_string() } else { touches.to_string() };
    let earlier = before.iter().step_by(every);
    let mut steps: Vec<(String, [Coordinates; 4])> = earlier
        .map(|checkpoint| (name(checkpoint.touches), drawn.lists(input, &checkpoint.schema)))
        .collect();
    steps.push((touches.to_string(), last.clone()));
    steps
}

fn slider(steps: &[(String, [Coordinates; 4])]) -> Slider {
    let step = |(name, lists): &(String, [Coordinates; 4])| {
        let axis = |k: usize| lists.iter().map(|list| json!(list[k])).collect::<Vec<_>>();
        let args = json!([{ "x": axis(0), "y": axis(1), "z": axis(2) }, [0, 1, 2, 3]]);
        SliderStep::new().label(name).method(SliderMethod::Restyle).args(args)
    };
    Slider::new()
        .active(steps.len() as i32 - 1)
        .current_value(SliderCurrentValue::new().prefix("touches: "))
        .length(0.84)
        .x(0.06)
        .y(0.0)
        .pad(Pad::new(10, 40, 0))
        .steps(steps.iter().map(step).collect())
}

/// Buttons that make the skin opaque, or joints visible in it.
fn buttons() -> UpdateMenu {
    let button = |name: &str, opacities: [f64; 2]| {
        let args = json!([{ "opacity": opacities }, [0, 1]]);
        Button::new().label(name).method(ButtonMethod::Restyle).args(args)
    };
    UpdateMenu::new()
        .ty(UpdateMenuType::Buttons)
        .direction(UpdateMenuDirection::Down)
        .buttons(vec![button("see through", SEE_THROUGH), button("skin", [1.0; 2])])
        .active(0)
        .font(Font::new().color(BUTTON))
        .x(0.0)
        .x_anchor(Anchor::Left)
        .y(1.0)
        .y_anchor(Anchor::Top)
}

/// How often each receptor was touched.
fn counts(input: &ReportInput) -> Vec<usize> {
    let mut counts = vec![0; input.skin.receptors.len()];
    input.touches.iter().flat_map(|touch| touch.ends).for_each(|end| counts[end.receptor] += 1);
    counts
}

fn triangles(mesh: &Mesh) -> [Option<Vec<usize>>; 3] {
    [0, 1, 2].map(|k| Some(mesh.triangles.iter().map(|triangle| triangle[k]).collect()))
}

/// Light that comes from everywhere, so that no side of a body is in the dark.
fn light() -> Lighting {
    Lighting::new().ambient(0.85).diffuse(0.35).specular(0.03).roughness(0.9).fresnel(0.05)
}

fn learned(input: &ReportInput, drawn: &Drawn, lists: [Coordinates; 4]) -> Vec<Box<dyn Trace>> {
    let [limbs, patches, bones, joints] = lists;
    let counts = counts(input);
    let most = counts.iter().copied().max().unwrap_or(0);
    let shade = |count: usize| (count as f64).ln_1p();
    let ticks: Vec<usize> =
        [0, 1, 3, 10, 30, 100, 300, 1000, 3000, 10_000].into_iter().filter(|n| *n <= most).collect();
    let [x, y, z] = limbs;
    let [i, j, k] = triangles(&drawn.limbs);
    let limbs = Mesh3D::new(x, y, z, i, j, k)
        .name("limbs")
        .color(LIMB)
        .opacity(SEE_THROUGH[0])
        .lighting(light())
        .hover_info(HoverInfo::Skip)
        .show_legend(true);
    let [x, y, z] = patches;
    let [i, j, k] = triangles(&drawn.receptors);
    let named = input.skin.receptors.iter().zip(&counts).flat_map(|(receptor, count)| {
        let text = format!("{}: touched {}", escape(&receptor.id), times(*count));
        std::iter::repeat_n(text, 4)
    });
    let patches = Mesh3D::new(x, y, z, i, j, k)
        .name("receptors")
        .intensity(counts.iter().flat_map(|count| [shade(*count); 4]).collect())
        .c_min(0.0)
        .c_max(shade(most.max(1)))
        .color_scale(ColorScale::Vector(
            TOUCHED.iter().map(|(at, colour)| ColorScaleElement(*at, colour.to_string())).collect(),
        ))
        .opacity(SEE_THROUGH[1])
        .show_scale(true)
        .color_bar(
            ColorBar::new()
                .title(Title::with_text("touches of<br>a receptor"))
                .thickness(14)
                .x(0.98)
                .tick_vals(ticks.iter().map(|n| shade(*n)).collect())
                .tick_text(ticks.iter().map(usize::to_string).collect::<Vec<_>>()),
        )
        .lighting(light())
        .flat_shading(true)
        .hover_text_array(named.collect::<Vec<_>>())
        .hover_info(HoverInfo::Text)
        .show_legend(true);
    let [x, y, z] = bones;
    let bones = Scatter3D::new(x, y, z)
        .name("bones")
        .mode(Mode::Lines)
        .line(Line::new().color(JOINT).width(7.0))
        .hover_info(HoverInfo::Skip);
    let [x, y, z] = joints;
    let colour = |joint: usize| colour_of(input, joint);
    let names = input.creature.joints().iter().map(|joint| escape(&joint.name));
    let joints = Scatter3D::new(x, y, z)
        .name("joints")
        .mode(Mode::Markers)
        .marker(
            Marker::new()
                .size(7)
                .line(Line::new().color("#ffffff").width(1.5))
                .color_array((0..input.creature.joints().len()).map(colour).collect::<Vec<_>>()),
        )
        .hover_text_array(names.collect::<Vec<_>>())
        .hover_info(HoverInfo::Text);
    vec![limbs, patches, bones, joints]
}

/// The true body: as a shade where it has a skin, and its joints.
fn true_body(input: &ReportInput, drawn: &Drawn, lists: [Coordinates; 3]) -> Vec<Box<dyn Trace>> {
    let [skin, bones, joints] = lists;
    let [x, y, z] = skin;
    let [i, j, k] = triangles(&drawn.limbs);
    let skin = Mesh3D::new(x, y, z, i, j, k)
        .name("true body")
        .legend_group("true")
        .color(GREY)
        .opacity(0.07)
        .lighting(light())
        .hover_info(HoverInfo::Skip)
        .show_legend(true);
    let [x, y, z] = bones;
    let bones = Scatter3D::new(x, y, z)
        .legend_group("true")
        .show_legend(false)
        .mode(Mode::Lines)
        .line(Line::new().color(GREY).width(3.0))
        .hover_info(HoverInfo::Skip);
    let [x, y, z] = joints;
    let names = input.creature.joints().iter().map(|joint| format!("{} in truth", escape(&joint.name)));
    let joints = Scatter3D::new(x, y, z)
        .name("true joints")
        .mode(Mode::Markers)
        .marker(Marker::new().size(3).color(GREY))
        .hover_text_array(names.collect::<Vec<_>>())
        .hover_info(HoverInfo::Text);
    vec![skin, bones, joints]
}

/// A scene that holds all that is shown, at one scale in all directions; none where there is nothing.
fn scene<'a>(shown: impl Iterator<Item = &'a Coordinates>) -> Option<LayoutScene> {
    let mut bounds = [(f64::INFINITY, f64::NEG_INFINITY); 3];
    for lists in shown {
        for (list, (low, high)) in lists.iter().zip(&mut bounds) {
            for x in list.iter().flatten().filter(|x| x.is_finite()) {
                (*low, *high) = (low.min(*x), high.max(*x));
            }
        }
    }
    let extent = bounds.iter().map(|(low, high)| high - low).fold(0.0, f64::max);
    if !bounds.iter().all(|(low, high)| low <= high) || extent <= 0.0 {
        return None;
    }
    let axis = |(low, high): (f64, f64)| {
        // A flat body still has a place on every axis.
        let room = 0.02 * extent;
        Axis::new().visible(false).show_spikes(false).range(vec![low - room, high + room])
    };
    let sides = bounds.map(|(low, high)| high - low + 0.04 * extent);
    // The scene's unit is the geometric mean of its sides.
    let unit = sides.iter().product::<f64>().cbrt();
    let eye = Vector3::from(VIEW).normalize() * (DISTANCE * extent / unit);
    let [x, y, z] = bounds.map(axis);
    Some(
        LayoutScene::new()
            .x_axis(x)
            .y_axis(y)
            .z_axis(z)
            .aspect_mode(AspectMode::Data)
            .drag_mode(DragMode3D::Orbit)
            .camera(Camera::new().eye((eye.x, eye.y, eye.z).into())),
    )
}

fn times(count: usize) -> String {
    match count {
        0 => "never".into(),
        1 => "once".into(),
        n => plural(n, "time"),
    }
}
