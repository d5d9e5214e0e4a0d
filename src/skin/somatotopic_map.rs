//! The somatotopic map: which receptors are neighbours on a limb's surface.
//!
//! "The skin receptors are organized in 8-neighborhoods" (IVA 2009, section 2); there the map was made by
//! hand, here the geometry gives it.

use super::{Receptor, Skin};

/// The most neighbours of a receptor.
pub const MOST_NEIGHBOURS: usize = 8;
/// Patches whose rims are no farther apart than this share of their sizes are neighbours.
const REACH: f64 = 1.3;

/// Per receptor, its neighbours on the same limb, nearest first.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SomatotopicMap {
    neighbours: Vec<Vec<usize>>,
}

impl SomatotopicMap {
    /// Works out the map from the receptors' places: neighbours lie on the same limb, face less than a
    /// right angle and a half away from each other, and their patches meet or nearly do. The relation is
    /// mutual.
    pub fn new(skin: &Skin) -> SomatotopicMap {
        let receptors = &skin.receptors;
        let size = |r: &Receptor| r.half_extents[0].hypot(r.half_extents[1]);
        let mut links = Vec::new();
        for (i, a) in receptors.iter().enumerate() {
            for (j, b) in receptors.iter().enumerate().skip(i + 1) {
                let distance = (a.position - b.position).norm();
                let facing = a.normal.dot(&b.normal) > -0.7;
                if a.limb == b.limb && facing && distance <= REACH * (size(a) + size(b)) * 0.75 {
                    links.push((distance, i, j));
                }
            }
        }
        links.sort_by(|a, b| a.0.total_cmp(&b.0).then((a.1, a.2).cmp(&(b.1, b.2))));
        SomatotopicMap::of_links(receptors.len(), links.into_iter().map(|(_, i, j)| [i, j]))
    }

    /// The map of so many receptors that has as many of these links as there is room for, the first ones first: no
    /// receptor has more than [`MOST_NEIGHBOURS`].
    pub fn of_links(receptors: usize, links: impl IntoIterator<Item = [usize; 2]>) -> SomatotopicMap {
        let mut neighbours: Vec<Vec<usize>> = vec![Vec::new(); receptors];
        for [i, j] in links {
            if neighbours[i].len() < MOST_NEIGHBOURS && neighbours[j].len() < MOST_NEIGHBOURS {
                neighbours[i].push(j);
                neighbours[j].push(i);
            }
        }
        SomatotopicMap { neighbours }
    }

    /// Whether two receptors are neighbours, or one.
    pub fn adjacent(&self, a: usize, b: usize) -> bool {
        a == b || self.neighbours(a).contains(&b)
    }

    /// All pairs of neighbours, each once, the earlier receptor first.
    pub fn pairs(&self) -> impl Iterator<Item = [usize; 2]> {
        let later = |(i, of): (usize, &'_ Vec<usize>)| {
            let mut later: Vec<[usize; 2]> = of.iter().filter(|&&j| i < j).map(|&j| [i, j]).collect();
            later.sort_unstable();
            later
        };
        self.neighbours.iter().enumerate().flat_map(later)
    }

    /// The neighbours of a receptor, nearest first.
    pub fn neighbours(&self, receptor: usize) -> &[usize] {
        &self.neighbours[receptor]
    }
}
