//! The skin's surface as a graph of points: how far it is along the skin from one receptor to another.
//!
//! The surfaces that have receptors are sampled evenly, each as finely as its patches need; what lies inside another
//! surface of the limb, or of a limb next to it, is left out. Points near each other are linked, on one surface and from
//! one to another where the two meet: only surfaces of one limb or of limbs that a joint carries from one another, so that
//! fingers that come near each other stay apart. Where a joint leaves a gap, the nearest points bridge it.

mod linking;
mod sampling;
mod ways;

use std::collections::{BTreeSet, HashMap};

use nalgebra::Vector3;

use super::{JoinedLimbs, Skin};
use crate::creature::Creature;
use crate::geometry::Frame;

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

    /// Per pair of receptors whose patches meet, the earlier one first, how far apart their centres are along the skin,
    /// metres.
    pub fn meetings(&self) -> Vec<([usize; 2], f64)> {
        let mut borders: BTreeSet<[usize; 2]> = BTreeSet::new();
        for (i, links) in self.links.iter().enumerate() {
            for &(j, _) in links {
                if let (Some(a), Some(b)) = (self.points[i].receptor, self.points[j as usize].receptor)
                    && a < b
                {
                    borders.insert([a, b]);
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
        let mut found: Vec<([usize; 2], f64)> =
            borders.into_iter().map(|pair| (pair, f64::INFINITY)).collect();
        let mut reached: HashMap<usize, f64> = HashMap::new();
        let mut k = 0;
        while k < found.len() {
            let from = found[k].0[0];
            let until = found[k..].iter().take_while(|(pair, _)| pair[0] == from).count() + k;
            let targets: Vec<usize> = found[k..until].iter().map(|(pair, _)| centre[pair[1]]).collect();
            self.ways(centre[from], &targets, &mut reached);
            for ((_, distance), target) in found[k..until].iter_mut().zip(&targets) {
                *distance = reached.get(target).copied().unwrap_or(f64::INFINITY);
            }
            k = until;
        }
        found
    }
}
