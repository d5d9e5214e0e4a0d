//! The somatotopic map: which receptors are neighbours along the skin.
//!
//! "The skin receptors are organized in 8-neighborhoods" (IVA 2009, section 2); there the map was made by
//! hand, here the geometry gives it, or [experience](crate::senses::learn_map). The skin is one: neighbours may be on two
//! limbs that a joint connects.

use super::Skin;
use super::surface_graph::meetings;
use crate::creature::{Body, Creature};
use crate::error::Result;
use crate::geometry::Frame;

/// The most neighbours of a receptor.
pub const MOST_NEIGHBOURS: usize = 8;

/// Per receptor, its neighbours along the skin, nearest first.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SomatotopicMap {
    neighbours: Vec<Vec<usize>>,
}

impl SomatotopicMap {
    /// Works out the map from the receptors' positions, where the limbs are at these frames (`X_CL` for any frame C, a frame
    /// per limb). Neighbours are receptors whose patches meet on the skin there, on one limb or across a joint, at most
    /// [`MOST_NEIGHBOURS`], nearest along the skin first. The relation is mutual.
    ///
    /// # Panics
    /// Where there is not a frame per limb.
    pub fn new(creature: &Creature, skin: &Skin, frames: &[Frame]) -> SomatotopicMap {
        assert_eq!(frames.len(), creature.limbs().len(), "there is a frame per limb");
        let mut met: Vec<([usize; 2], f64)> = meetings(creature, skin, frames).into_iter().collect();
        met.sort_by(|a, b| a.1.total_cmp(&b.1).then(a.0.cmp(&b.0)));
        SomatotopicMap::of_links(skin.receptors.len(), met.into_iter().map(|(pair, _)| pair))
    }

    /// The map of a creature's skin as it is in its model's reference posture.
    ///
    /// # Errors
    /// Where the engine fails.
    pub fn at_ease(body: &Body, skin: &Skin) -> Result<SomatotopicMap> {
        let frames = body.limb_frames(&body.reference_data()?);
        Ok(SomatotopicMap::new(&body.creature, skin, &frames))
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

    /// The map in which each receptor has these neighbours, nearest first; who has a neighbour is one of its own.
    pub(crate) fn of_lists(neighbours: Vec<Vec<usize>>) -> SomatotopicMap {
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

    /// How many receptors it has.
    pub fn receptors(&self) -> usize {
        self.neighbours.len()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_receptor_has_its_first_links_and_being_neighbours_is_mutual() {
        let star = (1..=MOST_NEIGHBOURS + 2).map(|other| [0, other]);
        let map = SomatotopicMap::of_links(MOST_NEIGHBOURS + 3, star);
        assert_eq!(map.neighbours(0), (1..=MOST_NEIGHBOURS).collect::<Vec<_>>());
        assert!(map.adjacent(3, 0) && map.adjacent(0, 3) && map.adjacent(3, 3));
        assert!(!map.adjacent(0, MOST_NEIGHBOURS + 1) && !map.adjacent(1, 2));
        assert_eq!(map.pairs().count(), MOST_NEIGHBOURS);
    }
}
