//! The skin's surface as a graph of points: how far it is along the skin from one receptor to another.
//!
//! The surfaces that have receptors are sampled evenly, each as finely as its patches need; what lies inside another
//! surface of the limb, or of a limb next to it, is left out. Points near each other are linked, on one surface and from
//! one to another where the two meet: only surfaces of one limb or of limbs that a joint carries from one another, so that
//! fingers that come near each other stay apart. Where a joint leaves a gap, the nearest points bridge it.

mod linking;
mod sampling;
mod ways;

use std::collections::{BTreeMap, HashMap};

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

    /// Per pair of receptors whose patches meet, the earlier one first, how far apart they are and where they meet.
    pub fn meetings(&self) -> Vec<([usize; 2], Meeting)> {
        let mut borders: BTreeMap<[usize; 2], Meeting> = Default::default();
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
}
