//! How much wider the gap of one touch may be than that of another.
//!
//! A joint that reports its angle wrongly moves all beyond it: the error of a gap grows with how far the contact
//! is from the joints between the two limbs. With the gap's derivative `∂g/∂q` by the angles, and angles that
//! are all read equally well, its variance is
//!
//! ```text
//! σ² = σ₀² + σ_q² |∂g/∂q|²
//! ```
//!
//! The share of the two is what makes the gaps most likely; where none is likelier than a single σ₀, nothing is
//! weighed.

use nalgebra::Vector3;

use crate::learning::annealing::{NORMAL_MEDIAN, quantile};
use crate::learning::surface_gap::{SurfaceGap, gap_scale};
use crate::learning::touch_set::TouchSet;
use crate::schema::BodySchema;
use crate::skin::Skin;

/// Shares of the variance of a middling touch that may be the joints'.
const SHARES: [f64; 7] = [0.0, 0.25, 0.5, 0.75, 0.9, 0.97, 1.0];
/// What a share has to gain in likelihood (natural logarithm) over none.
const GAIN: f64 = 3.0;

/// Per touch, in the order of the set, the deviation of its gap in units of a middling touch's; none where all
/// are alike.
pub fn scales(skin: &Skin, touches: &TouchSet, schema: &BodySchema) -> Option<Vec<f64>> {
    let model = SurfaceGap::new(skin, 1.0);
    let mut derivatives: Vec<(usize, Vector3<f64>)> = Vec::new();
    let (mut gaps, mut slopes) = (Vec::new(), Vec::new());
    for touch in touches.touches() {
        let frames = touch.frames(schema);
        let found = model.gap(&touch.ends, &frames);
        let mut squares = 0.0;
        for (side, frame) in touch.sides.iter().zip(&frames) {
            derivatives.clear();
            side.angle_derivatives(schema, &frame.inverse_point(&found.middle()), &mut derivatives);
            squares += derivatives.iter().map(|(_, d)| found.normal.dot(d).powi(2)).sum::<f64>();
        }
        gaps.push(found.distance);
        slopes.push(squares);
    }
    let mut sorted = slopes.clone();
    sorted.sort_by(f64::total_cmp);
    let middle = quantile(&sorted, 0.5);
    if middle.is_nan() || middle <= 0.0 {
        return None;
    }
    let of_share = |share: f64| -> Vec<f64> {
        // Even a touch that no angle moves is not exact.
        slopes.iter().map(|slope| (1.0 - share + share * slope / middle).max(1e-3).sqrt()).collect()
    };
    let unlikelihood = |scales: &[f64]| -> f64 {
        let scaled: Vec<(f64, f64)> =
            gaps.iter().zip(scales).map(|(gap, scale)| (gap / scale, 0.0)).collect();
        let mut sizes: Vec<f64> = scaled.iter().map(|(gap, _)| gap.abs()).collect();
        sizes.sort_by(f64::total_cmp);
        let deviation = gap_scale(&scaled, NORMAL_MEDIAN * quantile(&sizes, 0.5));
        scales.len() as f64 * deviation.ln() + scales.iter().map(|scale| scale.ln()).sum::<f64>()
    };
    let plain = unlikelihood(&of_share(0.0));
    let candidates = SHARES[1..].iter().map(|&share| {
        let scales = of_share(share);
        (unlikelihood(&scales), scales)
    });
    let best = candidates.min_by(|a, b| a.0.total_cmp(&b.0))?;
    (best.0 < plain - GAIN).then_some(best.1)
}
