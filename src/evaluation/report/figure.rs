//! The learned body as stick figures in the reference posture.

use nalgebra::Vector3;

use super::ReportInput;
use super::text::escape;
use crate::creature::Creature;
use crate::kinematics::limb_frames;
use crate::schema::BodySchema;
use crate::skin::Skin;

/// The greatest width and height of a drawing, and the rim about it, pixels.
const WIDTH: f64 = 470.0;
const HEIGHT: f64 = 600.0;
const RIM: f64 = 14.0;
/// Room for the scale below a drawing, pixels.
const FOOT: f64 = 26.0;

/// A way to look at the body: the axes that point right and up.
struct View {
    right: usize,
    up: usize,
    title: &'static str,
}

const VIEWS: [View; 3] = [
    View { right: 1, up: 2, title: "along −x (y to the right, z up)" },
    View { right: 0, up: 2, title: "along +y (x to the right, z up)" },
    View { right: 0, up: 1, title: "along −z (x to the right, y up)" },
];

/// One schema laid out in the root limb's frame.
struct Skeleton {
    /// Pairs of points to join by a line.
    lines: Vec<[Vector3<f64>; 2]>,
    joints: Vec<Vector3<f64>>,
    receptors: Vec<Vector3<f64>>,
}

impl Skeleton {
    fn new(creature: &Creature, skin: &Skin, schema: &BodySchema) -> Skeleton {
        let frames = limb_frames(creature, schema, &creature.reference_posture());
        // Where each limb begins: at its joint, wherever its own frame is.
        let placed = creature.joints().iter().zip(&schema.positions);
        let begins: Vec<Vector3<f64>> = std::iter::once(frames[0].origin)
            .chain(placed.map(|(joint, position)| frames[joint.parent].point(position)))
            .collect();
        let mut lines: Vec<[Vector3<f64>; 2]> = creature
            .joints()
            .iter()
            .zip(&begins[1..])
            .map(|(joint, end)| [begins[joint.parent], *end])
            .collect();
        // A limb that carries no other reaches to the middle of its skin.
        for (limb, frame) in frames.iter().enumerate() {
            let carries = creature.joints().iter().any(|joint| joint.parent == limb);
            let own = skin.receptors.iter().filter(|r| r.limb == limb).map(|r| r.position);
            if let Some(middle) = Some(own.collect::<Vec<_>>()).filter(|own| !carries && !own.is_empty()) {
                let middle = middle.iter().sum::<Vector3<f64>>() / middle.len() as f64;
                lines.push([begins[limb], frame.point(&middle)]);
            }
        }
        let place = |r: &crate::skin::Receptor| frames[r.limb].point(&r.position);
        Skeleton {
            lines,
            joints: begins[1..].to_vec(),
            receptors: skin.receptors.iter().map(place).collect(),
        }
    }

    fn points(&self) -> impl Iterator<Item = &Vector3<f64>> {
        self.lines.iter().flatten().chain(&self.receptors)
    }
}

/// The two views in which the body is largest, at one scale.
pub(super) fn figures(input: &ReportInput) -> String {
    let learned = Skeleton::new(input.creature, input.skin, input.schema);
    let truth = input.truth.map(|truth| Skeleton::new(input.creature, input.skin, truth));
    let mut low = Vector3::repeat(f64::INFINITY);
    let mut high = -low;
    for point in learned.points().chain(truth.iter().flat_map(Skeleton::points)) {
        (low, high) = (low.inf(point), high.sup(point));
    }
    let extent = high - low;
    if !extent.iter().all(|side| side.is_finite()) || extent.max() <= 0.0 {
        return "<p class=\"note\">There is nothing to draw.</p>\n".into();
    }
    let mut views: Vec<&View> = VIEWS.iter().collect();
    views.sort_by(|a, b| {
        let area = |view: &View| extent[view.right] * extent[view.up];
        area(b).total_cmp(&area(a))
    });
    views.truncate(2);
    let fits = |view: &&View| (WIDTH / extent[view.right]).min(HEIGHT / extent[view.up]);
    let scale = views.iter().map(fits).fold(f64::INFINITY, f64::min);
    let bar = round_length(extent.max() / 8.0);
    let drawings: String = views
        .iter()
        .map(|view| {
            let flat = Projection { view, low, high, scale, bar: &bar };
            flat.draw(&learned, truth.as_ref(), input)
        })
        .collect();
    let grey = if truth.is_some() { ", in grey the true ones" } else { "" };
    format!(
        "<div class=\"views\">\n{drawings}</div>\n<p class=\"note\">The reference posture, in the frame of \
         the root limb: in blue the learned joints and limbs{grey}; small dots are receptors, open circles \
         joints that the touches do not determine.</p>\n"
    )
}

/// From metres in the root's frame to pixels of one drawing.
struct Projection<'a> {
    view: &'a View,
    low: Vector3<f64>,
    high: Vector3<f64>,
    scale: f64,
    /// Length of the scale, metres, and what it is called.
    bar: &'a (f64, String),
}

impl Projection<'_> {
    fn flat(&self, p: &Vector3<f64>) -> (f64, f64) {
        let View { right, up, .. } = *self.view;
        (RIM + self.scale * (p[right] - self.low[right]), RIM + self.scale * (self.high[up] - p[up]))
    }

    fn draw(&self, learned: &Skeleton, truth: Option<&Skeleton>, input: &ReportInput) -> String {
        let View { right, up, title } = *self.view;
        let extent = (self.high - self.low) * self.scale;
        let (width, height) = ((extent[right] + 2.0 * RIM).max(150.0), extent[up] + 2.0 * RIM + FOOT);
        let mut drawing = String::new();
        self.dots(&mut drawing, "receptors", &learned.receptors, 1.2);
        self.lines(&mut drawing, "learned", &learned.lines);
        // Fingers crowd a figure with many joints.
        let radius = if learned.joints.len() > 30 { 2.4 } else { 3.4 };
        for (j, point) in learned.joints.iter().enumerate() {
            let (x, y) = self.flat(point);
            let class = if input.undetermined.contains(&j) { "guess" } else { "joint" };
            let name = escape(&input.creature.joints()[j].name);
            drawing.push_str(&format!(
                "<circle class=\"{class}\" cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"{radius}\"><title>{name}</title>\
                 </circle>\n"
            ));
        }
        if let Some(truth) = truth {
            self.lines(&mut drawing, "true", &truth.lines);
            self.dots(&mut drawing, "true", &truth.joints, 1.4);
        }
        let (length, label) = self.bar;
        let (bar, foot) = (length * self.scale, height - 8.0);
        format!(
            "<figure>\n<svg viewBox=\"0 0 {width:.0} {height:.0}\" width=\"{width:.0}\" \
             height=\"{height:.0}\" role=\"img\" aria-label=\"The learned body seen {title}\">\n{drawing}\
             <path class=\"scale\" d=\"M{RIM} {:.1}v4h{bar:.1}v-4\"/>\n\
             <text x=\"{:.1}\" y=\"{foot:.1}\">{label}</text>\n</svg>\n\
             <figcaption>Seen {title}</figcaption>\n</figure>\n",
            foot - 6.0,
            RIM + bar + 6.0,
        )
    }

    fn lines(&self, drawing: &mut String, class: &str, lines: &[[Vector3<f64>; 2]]) {
        drawing.push_str(&format!("<path class=\"{class}\" d=\""));
        for line in lines {
            let [(x1, y1), (x2, y2)] = [self.flat(&line[0]), self.flat(&line[1])];
            drawing.push_str(&format!("M{x1:.1} {y1:.1}L{x2:.1} {y2:.1}"));
        }
        drawing.push_str("\"/>\n");
    }

    fn dots(&self, drawing: &mut String, class: &str, points: &[Vector3<f64>], radius: f64) {
        drawing.push_str(&format!("<g class=\"{class}\">"));
        for point in points {
            let (x, y) = self.flat(point);
            drawing.push_str(&format!("<circle cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"{radius}\"/>"));
        }
        drawing.push_str("</g>\n");
    }
}

/// The greatest of 1, 2, 5 times a power of ten that is no longer than `most` metres, and its name.
fn round_length(most: f64) -> (f64, String) {
    let power = 10f64.powf(most.log10().floor());
    let length = [5.0, 2.0, 1.0].map(|k| k * power).into_iter().find(|l| *l <= most).unwrap_or(power);
    let label = match length {
        metres if metres > 0.999 => format!("{metres:.0} m"),
        metres if metres > 0.00999 => format!("{:.0} cm", 1e2 * metres),
        metres => format!("{} mm", (1e6 * metres).round() / 1e3),
    };
    (length, label)
}
