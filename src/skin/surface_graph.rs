//! The skin's surface as a graph of points: how far it is along the skin from one receptor to another.
//!
//! The surfaces that have receptors are sampled evenly, each as finely as its patches need; what lies inside another
//! surface of the limb, or of a limb next to it, is left out. Points near each other are linked, on one surface and from
//! one to another where the two meet: only surfaces of one limb or of limbs that a joint carries from one another, so that
//! fingers that come near each other stay apart. Where a joint leaves a gap, the nearest points bridge it.

use std::cmp::Reverse;
use std::collections::{BinaryHeap, HashMap};

use nalgebra::Vector3;

use super::{JoinedLimbs, Receptor, Skin};
use crate::creature::Creature;
use crate::geometry::Frame;

/// Points of a surface for each patch on it.
const POINTS_PER_PATCH: f64 = 40.0;
/// Points at most on one surface, whatever share of it has skin.
const MOST_POINTS: f64 = 20_000.0;
/// Points are linked up to this many times their spacing: evenly spread ones leave no holes wider than that.
const REACH: f64 = 2.0;
/// Points whose normals have a product below this face each other through a fold, or are back to back.
const FACING: f64 = -0.5;
/// A point so deep in another surface is buried, in spacings.
const BURIED: f64 = 0.05;
/// The widest gap that is bridged, in sides of a patch.
const GAP: f64 = 1.0;

/// A point of the skin.
struct SurfacePoint {
    limb: usize,
    /// In the common frame, metres.
    at: Vector3<f64>,
    normal: Vector3<f64>,
    /// The receptor whose patch holds it, or is nearest along the limb's skin.
    receptor: Option<usize>,
}

/// Points of one surface, one after the other in the graph.
struct Sheet {
    limb: usize,
    points: std::ops::Range<usize>,
    /// Typical distance between its points, metres.
    spacing: f64,
    low: Vector3<f64>,
    high: Vector3<f64>,
}

impl Sheet {
    fn is_near(&self, p: &Vector3<f64>, within: f64) -> bool {
        (0..3).all(|k| p[k] >= self.low[k] - within && p[k] <= self.high[k] + within)
    }
}

/// Where two patches meet, if they do, and how far apart their centres are.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Meeting {
    /// Length of the shortest way along the skin between the centres, metres.
    pub distance: f64,
    /// Where the skins of two limbs meet, if they are on two.
    pub crossings: Vec<Crossing>,
}

/// A place where the skin goes from one limb on to another: the same point in both limbs' frames, the earlier limb's
/// first, metres.
pub(super) type Crossing = [Vector3<f64>; 2];

/// The graph of one posture.
pub(super) struct SurfaceGraph<'a> {
    skin: &'a Skin,
    frames: &'a [Frame],
    points: Vec<SurfacePoint>,
    sheets: Vec<Sheet>,
    links: Vec<Vec<(u32, f64)>>,
}

impl<'a> SurfaceGraph<'a> {
    /// The graph where the limbs are at these frames.
    pub fn new(creature: &Creature, skin: &'a Skin, frames: &'a [Frame]) -> SurfaceGraph<'a> {
        let mut graph =
            SurfaceGraph { skin, frames, points: Vec::new(), sheets: Vec::new(), links: Vec::new() };
        let joined = JoinedLimbs::new(creature, skin);
        graph.sample(&joined);
        graph.links = vec![Vec::new(); graph.points.len()];
        graph.link(&joined);
        graph.bridge(&joined);
        graph.give_to_receptors();
        graph
    }

    /// Fills in the sheets. The first points are the receptors' centres.
    fn sample(&mut self, joined: &JoinedLimbs) {
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

    /// Links what is near on one sheet, and on sheets that may meet.
    fn link(&mut self, joined: &JoinedLimbs) {
        for a in 0..self.sheets.len() {
            let cells = Cells::new(&self.points, &self.sheets[a]);
            for b in a..self.sheets.len() {
                if !joined.are(self.sheets[a].limb, self.sheets[b].limb) {
                    continue;
                }
                let reach = 0.5 * REACH * (self.sheets[a].spacing + self.sheets[b].spacing);
                for j in self.sheets[b].points.clone() {
                    if !self.sheets[a].is_near(&self.points[j].at, reach) {
                        continue;
                    }
                    for i in cells.within(&self.points, &self.points[j].at, reach) {
                        if a != b || i < j {
                            self.join(i, j);
                        }
                    }
                }
            }
        }
    }

    /// Links two points unless their normals say that air or a limb is between them.
    fn join(&mut self, i: usize, j: usize) {
        let (from, to) = (&self.points[i], &self.points[j]);
        let cosine = from.normal.dot(&to.normal);
        if cosine < FACING {
            return;
        }
        // On a rounded surface the way is the arc, not the chord.
        let half = 0.5 * cosine.clamp(-1.0, 1.0).acos();
        let arc = if half > 1e-3 { half / half.sin() } else { 1.0 };
        let length = (from.at - to.at).norm() * arc;
        self.links[i].push((j as u32, length));
        self.links[j].push((i as u32, length));
    }

    /// Links parts of the skin that do not meet though a joint, or a limb, has them side by side: over their
    /// narrowest gap.
    fn bridge(&mut self, joined: &JoinedLimbs) {
        let mut parts = Parts::new(&self.links);
        let mut gaps: Vec<(f64, usize, usize)> = Vec::new();
        for a in 0..self.sheets.len() {
            for b in a + 1..self.sheets.len() {
                let [one, other] = [a, b].map(|sheet| &self.sheets[sheet]);
                let apart = |parts: &mut Parts| {
                    let of = parts.of(one.points.start);
                    one.points.clone().chain(other.points.clone()).any(|point| parts.of(point) != of)
                };
                if !joined.are(one.limb, other.limb) || !apart(&mut parts) {
                    continue;
                }
                let most = GAP * 0.5 * (one.spacing + other.spacing) * POINTS_PER_PATCH.sqrt();
                gaps.extend(self.narrowest(a, b, most).map(|gap| (gap, a, b)));
            }
        }
        gaps.sort_by(|x, y| x.0.total_cmp(&y.0).then((x.1, x.2).cmp(&(y.1, y.2))));
        for (gap, a, b) in gaps {
            let within = gap + 0.5 * (self.sheets[a].spacing + self.sheets[b].spacing);
            let over = self.pairs(a, b, within);
            if over.iter().any(|&(i, j)| parts.of(i) != parts.of(j)) {
                for (i, j) in over {
                    self.join(i, j);
                    parts.unite(i, j);
                }
            }
        }
    }

    /// Pairs of points of two sheets that face alike and are no farther apart.
    fn pairs(&self, a: usize, b: usize, within: f64) -> Vec<(usize, usize)> {
        let [one, other] = [a, b].map(|sheet| &self.sheets[sheet]);
        let near = |i: &usize| other.is_near(&self.points[*i].at, within);
        let mine: Vec<usize> = one.points.clone().filter(near).collect();
        let near = |j: &usize| one.is_near(&self.points[*j].at, within);
        let theirs: Vec<usize> = other.points.clone().filter(near).collect();
        let mut pairs = Vec::new();
        for &i in &mine {
            for &j in &theirs {
                let (p, q) = (&self.points[i], &self.points[j]);
                if (p.at - q.at).norm() <= within && p.normal.dot(&q.normal) >= FACING {
                    pairs.push((i, j));
                }
            }
        }
        pairs
    }

    /// How far apart two sheets are at the least, if no more than that.
    fn narrowest(&self, a: usize, b: usize, most: f64) -> Option<f64> {
        let gap = |&(i, j): &(usize, usize)| (self.points[i].at - self.points[j].at).norm();
        self.pairs(a, b, most).iter().map(gap).min_by(f64::total_cmp)
    }

    /// Gives points that no patch holds to the receptor that is nearest along their limb's skin.
    fn give_to_receptors(&mut self) {
        let mut queue = BinaryHeap::new();
        let mut reached = vec![f64::INFINITY; self.points.len()];
        for (i, point) in self.points.iter().enumerate().filter(|(_, point)| point.receptor.is_some()) {
            reached[i] = 0.0;
            queue.push(Reverse((Length(0.0), i, point.receptor)));
        }
        while let Some(Reverse((Length(length), i, receptor))) = queue.pop() {
            if length > reached[i] {
                continue;
            }
            self.points[i].receptor = receptor;
            for &(j, way) in &self.links[i] {
                let j = j as usize;
                if self.points[j].limb == self.points[i].limb && length + way < reached[j] {
                    reached[j] = length + way;
                    queue.push(Reverse((Length(length + way), j, receptor)));
                }
            }
        }
    }

    /// Per pair of receptors whose patches meet, the earlier one first, how far apart they are and where they meet.
    pub fn meetings(&self) -> Vec<([usize; 2], Meeting)> {
        let mut borders: std::collections::BTreeMap<[usize; 2], Meeting> = Default::default();
        for (i, links) in self.links.iter().enumerate() {
            for &(j, _) in links {
                let (from, to) = (&self.points[i], &self.points[j as usize]);
                let (Some(a), Some(b)) = (from.receptor, to.receptor) else { continue };
                if a < b {
                    let meeting = borders.entry([a, b]).or_default();
                    if from.limb != to.limb {
                        let middle = 0.5 * (from.at + to.at);
                        let limbs = [from.limb.min(to.limb), from.limb.max(to.limb)];
                        meeting.crossings.push(limbs.map(|limb| self.frames[limb].inverse_point(&middle)));
                    }
                }
            }
        }
        let mut centre = vec![usize::MAX; self.skin.receptors.len()];
        for (i, point) in self.points.iter().enumerate().rev() {
            if let Some(receptor) = point.receptor {
                let here = self.frames[point.limb].point(&self.skin.receptors[receptor].position);
                if (point.at - here).norm() < 1e-12 {
                    centre[receptor] = i;
                }
            }
        }
        let mut found: Vec<([usize; 2], Meeting)> = borders.into_iter().collect();
        let mut reached: HashMap<usize, f64> = HashMap::new();
        let mut k = 0;
        while k < found.len() {
            let from = found[k].0[0];
            let until = found[k..].iter().take_while(|(pair, _)| pair[0] == from).count() + k;
            let targets: Vec<usize> = found[k..until].iter().map(|(pair, _)| centre[pair[1]]).collect();
            self.ways(centre[from], &targets, &mut reached);
            for ((_, meeting), target) in found[k..until].iter_mut().zip(&targets) {
                meeting.distance = reached.get(target).copied().unwrap_or(f64::INFINITY);
            }
            k = until;
        }
        found
    }

    /// The lengths of the shortest ways from a point, until all targets are reached (Dijkstra).
    fn ways(&self, from: usize, targets: &[usize], reached: &mut HashMap<usize, f64>) {
        reached.clear();
        let mut left = targets.to_vec();
        let mut queue = BinaryHeap::from([Reverse((Length(0.0), from))]);
        reached.insert(from, 0.0);
        while let Some(Reverse((Length(length), i))) = queue.pop() {
            if length > reached[&i] {
                continue;
            }
            left.retain(|target| *target != i);
            if left.is_empty() {
                break;
            }
            for &(j, way) in &self.links[i] {
                let (j, length) = (j as usize, length + way);
                if reached.get(&j).is_none_or(|before| length < *before) {
                    reached.insert(j, length);
                    queue.push(Reverse((Length(length), j)));
                }
            }
        }
    }
}

/// Points by place, to find what is near.
struct Cells {
    side: f64,
    of: HashMap<[i64; 3], Vec<usize>>,
}

impl Cells {
    fn new(points: &[SurfacePoint], sheet: &Sheet) -> Cells {
        let side = REACH * sheet.spacing;
        let mut of: HashMap<[i64; 3], Vec<usize>> = HashMap::new();
        for i in sheet.points.clone() {
            of.entry(cell(&points[i].at, side)).or_default().push(i);
        }
        Cells { side, of }
    }

    fn within(&self, points: &[SurfacePoint], p: &Vector3<f64>, reach: f64) -> Vec<usize> {
        let [low, high] = [-reach, reach].map(|offset| cell(&p.add_scalar(offset), self.side));
        let mut found = Vec::new();
        for x in low[0]..=high[0] {
            for y in low[1]..=high[1] {
                for z in low[2]..=high[2] {
                    let here = self.of.get(&[x, y, z]).into_iter().flatten();
                    found.extend(here.copied().filter(|&i| (points[i].at - p).norm() <= reach));
                }
            }
        }
        found
    }
}

fn cell(p: &Vector3<f64>, side: f64) -> [i64; 3] {
    (p / side).map(|x| x.floor() as i64).into()
}

/// Which points hang together.
struct Parts(Vec<usize>);

impl Parts {
    fn new(links: &[Vec<(u32, f64)>]) -> Parts {
        let mut parts = Parts((0..links.len()).collect());
        for (i, links) in links.iter().enumerate() {
            links.iter().for_each(|&(j, _)| parts.unite(i, j as usize));
        }
        parts
    }

    fn of(&mut self, mut i: usize) -> usize {
        while self.0[i] != i {
            self.0[i] = self.0[self.0[i]];
            i = self.0[i];
        }
        i
    }

    fn unite(&mut self, i: usize, j: usize) {
        let (i, j) = (self.of(i), self.of(j));
        self.0[i.max(j)] = i.min(j);
    }
}

/// A length in an order.
#[derive(Clone, Copy, PartialEq)]
struct Length(f64);

impl Eq for Length {}

impl Ord for Length {
    fn cmp(&self, other: &Length) -> std::cmp::Ordering {
        self.0.total_cmp(&other.0)
    }
}

impl PartialOrd for Length {
    fn partial_cmp(&self, other: &Length) -> Option<std::cmp::Ordering> {
        Some(self.cmp(other))
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
