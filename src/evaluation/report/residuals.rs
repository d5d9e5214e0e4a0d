//! How far apart the learned schema puts what touched.

use plotly::common::Marker;
use plotly::{Histogram, Trace};

use super::ReportInput;
use super::picture::{BLUE, axis, figure, layout, significant, thinned};
use super::text::degrees_and_millimetres as number;
use crate::evaluation::Summary;
use crate::kinematics::limb_frames;
use crate::learning::surface_gap::SurfaceGap;
use crate::learning::{Input, Learner, SecondOrder};
use crate::skin::Shape;

/// Most touches that are counted one by one.
const MOST: usize = 20_000;
/// Residuals this many times beyond the bulk are counted, not drawn: they would squeeze all others into one bar.
const FAR: f64 = 6.0;

/// What is left of every touch under the learned schema.
pub(super) struct Residuals {
    /// Per touch, the two limbs and how far apart the schema puts what touched, millimetres.
    pub values: Vec<([usize; 2], f64)>,
    /// Whether these are gaps between surfaces, negative where the two overlap; else distances of points.
    pub gaps: bool,
}

impl Residuals {
    /// Those of receptors on known surfaces as gaps, all others as distances between the points of contact.
    pub fn new(input: &ReportInput) -> Residuals {
        let (creature, skin) = (input.creature, input.skin);
        let surface = |surface: usize| skin.surfaces.get(surface).is_some_and(|s| s.shape != Shape::Mesh);
        let known = skin.receptors.iter().all(|receptor| receptor.surface.is_some_and(surface));
        let gaps = input.input == Input::Receptor && known;
        if gaps {
            let mut prepared = SecondOrder::new(creature, skin, Input::Receptor, 0);
            input.touches.iter().for_each(|touch| prepared.touch(touch));
            let model = SurfaceGap::new(skin, 1.0);
            let values = prepared.prepared().map(|(limbs, touch)| {
                (limbs, 1e3 * model.meeting(&touch.ends, &touch.frames(input.schema)).gap)
            });
            return Residuals { values: values.collect(), gaps };
        }
        let values = input.touches.iter().map(|touch| {
            let frames = limb_frames(creature, input.schema, &touch.posture);
            let limbs = touch.ends.map(|end| skin.receptors[end.receptor].limb);
            let [a, b] = [0, 1].map(|k| frames[limbs[k]].point(&touch.ends[k].contact));
            (limbs, 1e3 * (a - b).norm())
        });
        Residuals { values: values.collect(), gaps }
    }
}

/// The picture; a sentence where there was no touch.
pub(super) fn figure_of(residuals: &Residuals) -> String {
    let all: Vec<f64> = residuals.values.iter().map(|(_, value)| *value).filter(|v| v.is_finite()).collect();
    if all.is_empty() {
        return "<p class=\"note\">There is no touch to look at.</p>\n".into();
    }
    let sizes = Summary::of(all.iter().map(|value| value.abs()));
    // Micrometres where millimetres would have many zeros.
    let (scale, unit) = if sizes.p95 < 0.05 { (1e3, "µm") } else { (1.0, "mm") };
    let limit = FAR * sizes.p95;
    let count = all.len();
    let drawn: Vec<f64> = all.into_iter().filter(|value| value.abs() <= limit).collect();
    let beyond = count - drawn.len();
    let drawn: Vec<f64> =
        thinned(drawn, MOST).into_iter().map(|value| significant(scale * value, 4)).collect();
    let what = if residuals.gaps {
        format!("gap between the two surfaces, {unit}")
    } else {
        format!("distance between the two points, {unit}")
    };
    let bars: Box<dyn Trace> = Histogram::new(drawn).n_bins_x(60).marker(Marker::new().color(BLUE));
    let layout = layout().x_axis(axis(&what)).y_axis(axis("touches")).bar_gap(0.05).show_legend(false);
    let mut caption = format!(
        "Every touch under the learned schema; {} {unit} on the median, {} {unit} at 95 %, {} {unit} at most.",
        number(scale * sizes.median),
        number(scale * sizes.p95),
        number(scale * sizes.max)
    );
    if residuals.gaps {
        caption.push_str(" Below zero the two overlap.");
    }
    if beyond > 0 {
        caption.push_str(&format!(" {beyond} of {count} are farther out than is drawn."));
    }
    figure("residuals", "Residuals of the touches", 330, vec![bars], layout, &caption)
}
