//! The links of the graph: between points near each other, and over the gaps that joints leave.

use std::collections::HashMap;

use nalgebra::Vector3;

use super::sampling::POINTS_PER_PATCH;
use super::{Sheet, SurfaceGraph, SurfacePoint};
use crate::skin::JoinedLimbs;

/// Points are linked up to this many times their spacing: evenly spread ones leave no holes wider than that.
const REACH: f64 = 2.0;
/// Points whose normals have a product below this face each other through a fold, or are back to back.
const FACING: f64 = -0.5;
/// The widest gap that is bridged, in sides of a patch.
const GAP: f64 = 1.0;

impl SurfaceGraph<'_> {
    /// Links what is near on one sheet, and on sheets that may meet.
    pub(super) fn link(&mut self, joined: &JoinedLimbs) {
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
    pub(super) fn bridge(&mut self, joined: &JoinedLimbs) {
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
