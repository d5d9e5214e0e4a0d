//! Which patches meet on the skin, and how far apart their centres are along it.
//!
//! The surfaces that have receptors are sampled evenly, each as finely as its patches need; what lies inside another surface of
//! the limb, or of a limb next to it, is left out. Points near each other are linked, on one surface and from one to another
//! where the two meet: only surfaces of one limb or of limbs that a joint carries from one another, so that fingers that come
//! near each other stay apart. Where a joint leaves a gap, the nearest points bridge it. Each point belongs to a receptor:
//! linked points of two receptors are the border of their patches.

use std::collections::{BTreeMap, HashMap};

use nalgebra::Vector3;

use super::{JoinedLimbs, Receptor, Skin};
use crate::creature::Creature;
use crate::geometry::Frame;

/// Points of a surface for each patch on it.
const POINTS_PER_PATCH: f64 = 40.0;
/// Points at most on one surface, whatever share of it has skin.
const MOST_POINTS: f64 = 20_000.0;
/// A point so deep in another surface is buried, in spacings.
const BURIED: f64 = 0.05;
/// Points are linked up to this many times their spacing: evenly spread ones leave no holes wider than that.
const REACH: f64 = 2.0;
/// Points whose normals have a product below this face each other through a fold, or are back to back.
const FACING: f64 = -0.5;
/// The widest gap that is bridged, in sides of a patch.
const GAP: f64 = 1.0;

/// A point of the skin, in the frame that limbs are placed in.
struct SurfacePoint {
    sheet: usize,
    at: Vector3<f64>,
    normal: Vector3<f64>,
    /// The receptor whose patch holds it, or is nearest along the limb's skin.
    receptor: usize,
}

/// One sampled surface, or the patches of a limb that lie on none.
struct Sheet {
    limb: usize,
    /// Typical distance between its points, metres.
    spacing: f64,
}

/// How far apart two points are, metres, and which they are.
type Near = (f64, [usize; 2]);

/// The points of one posture.
struct SurfaceGraph<'a> {
    skin: &'a Skin,
    frames: &'a [Frame],
    joined: JoinedLimbs,
    points: Vec<SurfacePoint>,
    sheets: Vec<Sheet>,
    /// Per pair of receptors whose patches meet, the earlier one first, the way between their centres, metres.
    meetings: BTreeMap<[usize; 2], f64>,
    /// Per point, one that it hangs together with; itself for the first of a part.
    parts: Vec<usize>,
}

/// Per pair of receptors whose patches meet where the limbs are at these frames, the earlier one first, how far apart their
/// centres are along the skin, metres.
pub(super) fn meetings(creature: &Creature, skin: &Skin, frames: &[Frame]) -> BTreeMap<[usize; 2], f64> {
    let joined = JoinedLimbs::new(creature, skin);
    let (points, sheets, meetings, parts) = (Vec::new(), Vec::new(), BTreeMap::new(), Vec::new());
    let mut graph = SurfaceGraph { skin, frames, joined, points, sheets, meetings, parts };
    graph.sample();
    graph.parts = (0..graph.points.len()).collect();
    let gaps = graph.link_near();
    graph.bridge(gaps);
    graph.meetings
}

impl SurfaceGraph<'_> {
    fn sample(&mut self) {
        let skin = self.skin;
        let mut on_surface: Vec<Vec<usize>> = vec![Vec::new(); skin.surfaces.len()];
        let mut flat: BTreeMap<usize, Vec<usize>> = BTreeMap::new();
        for (r, receptor) in skin.receptors.iter().enumerate() {
            match receptor.surface.filter(|&s| skin.surfaces[s].shape.is_solid()) {
                Some(surface) => on_surface[surface].push(r),
                None => flat.entry(receptor.limb).or_default().push(r),
            }
        }
        for (s, receptors) in on_surface.iter().enumerate().filter(|(_, on)| !on.is_empty()) {
            let surface = &skin.surfaces[s];
            let share = median_area(skin, receptors) / POINTS_PER_PATCH;
            let share = share.max(surface.shape.area() / MOST_POINTS);
            let samples = surface.shape.samples(share).into_iter();
            let samples = samples.map(|(p, n)| (surface.pose().point(&p), surface.rotation * n));
            self.add_sheet(surface.limb, receptors, samples.collect(), share.sqrt(), Some(s));
        }
        for (limb, receptors) in flat {
            let spacing = (median_area(skin, &receptors) / POINTS_PER_PATCH).sqrt();
            let samples = receptors.iter().flat_map(|&r| patch_points(&skin.receptors[r], spacing)).collect();
            self.add_sheet(limb, &receptors, samples, spacing, None);
        }
    }

    /// Adds points of a surface, given in its limb's frame: the centres of its receptors, for a receptor is somewhere even
    /// where all of it is covered, and samples that are not buried.
    fn add_sheet(
        &mut self,
        limb: usize,
        receptors: &[usize],
        samples: Vec<(Vector3<f64>, Vector3<f64>)>,
        spacing: f64,
        surface: Option<usize>,
    ) {
        let (skin, frame, sheet) = (self.skin, self.frames[limb], self.sheets.len());
        let others = skin.surfaces.iter().enumerate();
        let over: Vec<_> = others
            .filter(|(s, other)| Some(*s) != surface && self.joined.are(limb, other.limb))
            .map(|(_, other)| (other, self.frames[other.limb]))
            .collect();
        let is_buried = |at: &Vector3<f64>| {
            over.iter().any(|(other, frame)| other.holds(&frame.inverse_point(at), BURIED * spacing))
        };
        let on_limb: Vec<usize> = skin.receptors_on(limb).collect();
        let nearest = |from: &[usize], p: &Vector3<f64>, n: &Vector3<f64>, feels: bool| {
            let fits = |r: &&Receptor| if feels { r.feels(p, n) } else { r.normal.dot(n) >= FACING };
            let receptors = from.iter().filter(|&&r| fits(&&skin.receptors[r]));
            let way = |&&r: &&usize| arc(&[skin.receptors[r].position, *p], &[skin.receptors[r].normal, *n]);
            receptors.min_by(|a, b| way(a).total_cmp(&way(b))).copied()
        };
        let mut add = |p: &Vector3<f64>, n: &Vector3<f64>, receptor: usize| {
            self.points.push(SurfacePoint {
                sheet,
                at: frame.point(p),
                normal: frame.rotation * n,
                receptor,
            });
        };
        receptors.iter().for_each(|&r| add(&skin.receptors[r].position, &skin.receptors[r].normal, r));
        for (p, n) in samples.iter().filter(|(p, _)| !is_buried(&frame.point(p))) {
            let owner = nearest(receptors, p, n, true).or_else(|| nearest(&on_limb, p, n, false));
            owner.into_iter().for_each(|receptor| add(p, n, receptor));
        }
        self.sheets.push(Sheet { limb, spacing });
    }

    /// Links points that are near each other, and gathers those that a gap may be bridged by, per pair of sheets.
    fn link_near(&mut self) -> BTreeMap<[usize; 2], Vec<Near>> {
        let far = self.sheets.iter().map(|sheet| sheet.spacing).fold(0.0, f64::max);
        let far = (far * REACH.max(GAP * POINTS_PER_PATCH.sqrt())).max(1e-9);
        let mut gaps: BTreeMap<[usize; 2], Vec<Near>> = BTreeMap::new();
        let mut cells: HashMap<Vector3<i64>, Vec<usize>> = HashMap::new();
        for j in 0..self.points.len() {
            let here = (self.points[j].at / far).map(|x| x.floor() as i64);
            let around = (0..27).map(|k| here + Vector3::new(k % 3 - 1, k / 3 % 3 - 1, k / 9 - 1));
            for &i in around.filter_map(|cell| cells.get(&cell)).flatten() {
                let (p, q) = (&self.points[i], &self.points[j]);
                let sheets = [p.sheet.min(q.sheet), p.sheet.max(q.sheet)];
                let [one, other] = sheets.map(|sheet| &self.sheets[sheet]);
                let spacing = 0.5 * (one.spacing + other.spacing);
                let distance = (p.at - q.at).norm();
                let most = spacing * if p.sheet == q.sheet { REACH } else { GAP * POINTS_PER_PATCH.sqrt() };
                if distance > most
                    || p.normal.dot(&q.normal) < FACING
                    || !self.joined.are(one.limb, other.limb)
                {
                    continue;
                }
                if p.sheet != q.sheet {
                    gaps.entry(sheets).or_default().push((distance, [i, j]));
                }
                if distance <= REACH * spacing {
                    self.link([i, j]);
                }
            }
            cells.entry(here).or_default().push(j);
        }
        gaps
    }

    /// Links two points: their parts are one, and the patches that they lie on meet.
    fn link(&mut self, points: [usize; 2]) {
        let [a, b] = points.map(|point| self.part(point));
        self.parts[a.max(b)] = a.min(b);
        let [p, q] = points.map(|point| &self.points[point]);
        if p.receptor == q.receptor {
            return;
        }
        let from_centre = |point: &SurfacePoint| {
            let (frame, receptor) =
                (&self.frames[self.sheets[point.sheet].limb], &self.skin.receptors[point.receptor]);
            arc(
                &[frame.point(&receptor.position), point.at],
                &[frame.rotation * receptor.normal, point.normal],
            )
        };
        let way = from_centre(p) + arc(&[p.at, q.at], &[p.normal, q.normal]) + from_centre(q);
        let pair = [p.receptor.min(q.receptor), p.receptor.max(q.receptor)];
        let shortest = self.meetings.entry(pair).or_insert(way);
        *shortest = shortest.min(way);
    }

    /// The first point of the part that a point hangs together with.
    fn part(&mut self, mut point: usize) -> usize {
        while self.parts[point] != point {
            self.parts[point] = self.parts[self.parts[point]];
            point = self.parts[point];
        }
        point
    }

    /// Links parts of the skin that do not meet though a joint, or a limb, has them side by side: over their narrowest gap.
    fn bridge(&mut self, gaps: BTreeMap<[usize; 2], Vec<Near>>) {
        let narrowest =
            |near: &[Near]| near.iter().map(|(distance, _)| *distance).fold(f64::INFINITY, f64::min);
        let mut gaps: Vec<_> =
            gaps.into_iter().map(|(sheets, near)| (narrowest(&near), sheets, near)).collect();
        gaps.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        for (gap, [a, b], near) in gaps {
            let within = gap + 0.5 * (self.sheets[a].spacing + self.sheets[b].spacing);
            let over: Vec<_> = near.into_iter().filter(|(distance, _)| *distance <= within).collect();
            if over.iter().any(|&(_, [i, j])| self.part(i) != self.part(j)) {
                over.iter().for_each(|(_, points)| self.link(*points));
            }
        }
    }
}

/// The length of the way between two points of the skin with normals: on a rounded surface the arc, not the chord.
pub(crate) fn arc([p, q]: &[Vector3<f64>; 2], [n, m]: &[Vector3<f64>; 2]) -> f64 {
    let half = 0.5 * n.dot(m).clamp(-1.0, 1.0).acos();
    (p - q).norm() * if half > 1e-3 { half / half.sin() } else { 1.0 }
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
        (receptor.patch_point([share(k % across, across), share(k / across, along)]), receptor.normal)
    };
    (0..across * along).map(point).collect()
}
