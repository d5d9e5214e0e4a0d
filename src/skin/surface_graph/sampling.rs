//! The points of the graph: surfaces sampled evenly, without what is buried.

use nalgebra::Vector3;

use super::{Sheet, SurfaceGraph, SurfacePoint};
use crate::skin::{JoinedLimbs, Receptor, Skin};

/// Points of a surface for each patch on it.
pub(super) const POINTS_PER_PATCH: f64 = 40.0;
/// Points at most on one surface, whatever share of it has skin.
const MOST_POINTS: f64 = 20_000.0;
/// A point so deep in another surface is buried, in spacings.
const BURIED: f64 = 0.05;

impl SurfaceGraph<'_> {
    /// Fills in the sheets. The first points are the receptors' centres.
    pub(super) fn sample(&mut self, joined: &JoinedLimbs) {
        let skin = self.skin;
        let mut on_surface: Vec<Vec<usize>> = vec![Vec::new(); skin.surfaces.len()];
        let mut flat: Vec<Vec<usize>> = Vec::new();
        for (r, receptor) in skin.receptors.iter().enumerate() {
            match receptor.surface.filter(|&s| skin.surfaces[s].shape.is_solid()) {
                Some(surface) => on_surface[surface].push(r),
                None => match flat.iter_mut().find(|of| skin.receptors[of[0]].limb == receptor.limb) {
                    Some(of) => of.push(r),
                    None => flat.push(vec![r]),
                },
            }
        }
        for (s, receptors) in on_surface.iter().enumerate().filter(|(_, on)| !on.is_empty()) {
            let surface = &skin.surfaces[s];
            let spacing = median_area(skin, receptors) / POINTS_PER_PATCH;
            let spacing = spacing.max(surface.shape.area() / MOST_POINTS);
            let samples = surface.shape.samples(spacing).into_iter();
            let samples = samples.map(|(p, n)| (surface.pose().point(&p), surface.rotation * n));
            self.add_sheet(surface.limb, receptors, samples.collect(), spacing.sqrt(), Some(s), joined);
        }
        for receptors in flat {
            let spacing = (median_area(skin, &receptors) / POINTS_PER_PATCH).sqrt();
            let samples = receptors.iter().flat_map(|&r| patch_points(&skin.receptors[r], spacing)).collect();
            self.add_sheet(skin.receptors[receptors[0]].limb, &receptors, samples, spacing, None, joined);
        }
    }

    /// Adds points of a surface, given in its limb's frame, those that are not buried.
    fn add_sheet(
        &mut self,
        limb: usize,
        receptors: &[usize],
        samples: Vec<(Vector3<f64>, Vector3<f64>)>,
        spacing: f64,
        surface: Option<usize>,
        joined: &JoinedLimbs,
    ) {
        let (skin, frame) = (self.skin, self.frames[limb]);
        let others = skin.surfaces.iter().enumerate();
        let over: Vec<_> = others
            .filter(|(s, other)| Some(*s) != surface && joined.are(limb, other.limb))
            .map(|(_, other)| (other, self.frames[other.limb], other.shape.bounding_radius()))
            .collect();
        let first = self.points.len();
        let centre = |&r: &usize| {
            let receptor = &skin.receptors[r];
            (receptor.position, receptor.normal, Some(r))
        };
        let sampled = samples.into_iter().map(|(p, n)| {
            let near = |r: &usize| (skin.receptors[*r].position - p).norm_squared();
            let feels = receptors.iter().copied().filter(|&r| skin.receptors[r].feels(&p, &n));
            (p, n, feels.min_by(|a, b| near(a).total_cmp(&near(b))))
        });
        let (far, centres) = (f64::INFINITY, receptors.len());
        let (mut low, mut high) = (Vector3::repeat(far), Vector3::repeat(-far));
        for (k, (p, n, receptor)) in receptors.iter().map(centre).chain(sampled).enumerate() {
            let at = frame.point(&p);
            let buried = over.iter().any(|(other, frame, radius)| {
                let p_o = frame.inverse_point(&at);
                (p_o - other.origin).norm() < *radius && other.holds(&p_o, BURIED * spacing)
            });
            // A receptor is somewhere, even where all of it is covered.
            if k < centres || !buried {
                low = low.inf(&at);
                high = high.sup(&at);
                self.points.push(SurfacePoint { limb, at, normal: frame.rotation * n, receptor });
            }
        }
        let points = first..self.points.len();
        self.sheets.push(Sheet { limb, points, spacing, low, high });
    }
}

/// The median of the areas of patches, m².
fn median_area(skin: &Skin, receptors: &[usize]) -> f64 {
    let area = |&r: &usize| 4.0 * skin.receptors[r].half_extents.iter().product::<f64>();
    let mut areas: Vec<f64> = receptors.iter().map(area).collect();
    areas.sort_by(f64::total_cmp);
    areas[areas.len() / 2]
}

/// Points over a flat patch and its normal there, about so far apart, in the limb's frame.
fn patch_points(receptor: &Receptor, spacing: f64) -> Vec<(Vector3<f64>, Vector3<f64>)> {
    let [across, along] = receptor.half_extents.map(|half| ((2.0 * half / spacing).round() as usize).max(1));
    let share = |k: usize, of: usize| (2 * k + 1) as f64 / of as f64 - 1.0;
    let point = |k: usize| {
        let [u, v] = [share(k % across, across), share(k / across, along)];
        let p = receptor.position
            + receptor.tangent * (u * receptor.half_extents[0])
            + receptor.bitangent() * (v * receptor.half_extents[1]);
        (p, receptor.normal)
    };
    (0..across * along).map(point).collect()
}
