//! The somatotopic map: which receptors are neighbours along the skin.
//!
//! "The skin receptors are organized in 8-neighborhoods" (IVA 2009, section 2); there the map was made by
//! hand, here the geometry gives it, or [experience](crate::senses::learn_map). The skin is one: neighbours may be on two
//! limbs that a joint connects.

use std::collections::BTreeMap;

use nalgebra::Vector3;

use super::Skin;
use super::surface_graph::{Crossing, Meeting, SurfaceGraph};
use crate::creature::{Body, Creature};
use crate::error::Result;
use crate::geometry::Frame;

/// The most neighbours of a receptor.
pub const MOST_NEIGHBOURS: usize = 8;
/// Places that are kept of where two patches on two limbs meet: on a border as long as a patch they are nearer to each
/// other than a fingertip is wide.
const CROSSINGS: usize = 40;

/// Per receptor, its neighbours along the skin, nearest first.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SomatotopicMap {
    neighbours: Vec<Vec<usize>>,
    /// Per pair of limbs, the earlier first, where their skins meet. None for what was learned without places.
    crossings: BTreeMap<[usize; 2], Vec<Crossing>>,
}

impl SomatotopicMap {
    /// Works out the map from the receptors' places, where the limbs are at these frames (`X_CL` for any frame C, a
    /// frame per limb) in each of some postures. Neighbours are receptors whose patches meet on the skin in any of the
    /// postures, on one limb or across a joint, at most [`MOST_NEIGHBOURS`], nearest along the skin first. The relation is
    /// mutual.
    ///
    /// # Panics
    /// Where a posture has not a frame per limb.
    pub fn new(creature: &Creature, skin: &Skin, postures: &[Vec<Frame>]) -> SomatotopicMap {
        let mut met: BTreeMap<[usize; 2], Meeting> = BTreeMap::new();
        for frames in postures {
            assert_eq!(frames.len(), creature.limbs().len(), "a posture has a frame per limb");
            for (pair, meeting) in SurfaceGraph::new(creature, skin, frames).meetings() {
                let known = met.entry(pair).or_insert(Meeting { distance: f64::INFINITY, crossings: vec![] });
                known.distance = known.distance.min(meeting.distance);
                known.crossings.extend(meeting.crossings);
            }
        }
        let mut links: Vec<(f64, [usize; 2])> = met.iter().map(|(pair, met)| (met.distance, *pair)).collect();
        links.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        let mut map = SomatotopicMap::of_links(skin.receptors.len(), links.into_iter().map(|(_, pair)| pair));
        for ([a, b], meeting) in met {
            let every = meeting.crossings.len().div_ceil(CROSSINGS).max(1);
            let crossings = meeting.crossings.into_iter().step_by(every);
            let limbs = [a, b].map(|r| skin.receptors[r].limb);
            if limbs[0] != limbs[1] {
                let limbs = [limbs[0].min(limbs[1]), limbs[0].max(limbs[1])];
                map.crossings.entry(limbs).or_default().extend(crossings);
            }
        }
        map
    }

    /// The map of a creature's skin as it is in its model's reference posture.
    ///
    /// # Errors
    /// Where the engine fails.
    pub fn at_ease(body: &Body, skin: &Skin) -> Result<SomatotopicMap> {
        let frames = body.limb_frames(&body.reference_data()?);
        Ok(SomatotopicMap::new(&body.creature, skin, &[frames]))
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
        SomatotopicMap { neighbours, crossings: BTreeMap::new() }
    }

    /// The map in which each receptor has these neighbours, nearest first; who has a neighbour is one of its own.
    pub(crate) fn of_lists(neighbours: Vec<Vec<usize>>) -> SomatotopicMap {
        SomatotopicMap { neighbours, crossings: BTreeMap::new() }
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

    /// About how long the way along the skin is between points of two limbs, each in its limb's frame, by where the
    /// limbs' skins meet and thus in any posture; metres. None where that is not known.
    pub fn way_across(&self, from: (usize, Vector3<f64>), to: (usize, Vector3<f64>)) -> Option<f64> {
        let [from, to] = if from.0 < to.0 { [from, to] } else { [to, from] };
        let crossings = self.crossings.get(&[from.0, to.0])?;
        let way = |[here, there]: &Crossing| (here - from.1).norm() + (there - to.1).norm();
        crossings.iter().map(way).min_by(f64::total_cmp)
    }

    /// Where the skins of two limbs meet: the limbs, the earlier first, and the same point in the frame of either, metres.
    pub(crate) fn borders(&self) -> impl Iterator<Item = ([usize; 2], [Vector3<f64>; 2])> {
        self.crossings.iter().flat_map(|(limbs, crossings)| crossings.iter().map(|at| (*limbs, *at)))
    }

    /// How far a point of a limb, in the limb's frame, is from where the skin of another limb begins, metres. None where
    /// that is not known.
    pub fn way_to_border(&self, limb: usize, point: &Vector3<f64>) -> Option<f64> {
        let borders = self.crossings.iter().filter_map(|(limbs, crossings)| {
            let side = limbs.iter().position(|on| *on == limb)?;
            Some(crossings.iter().map(move |crossing| (crossing[side] - point).norm()))
        });
        borders.flatten().min_by(f64::total_cmp)
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

    #[test]
    fn the_way_to_another_limb_leads_over_the_nearest_place_where_their_skins_meet() {
        let x = |x: f64| Vector3::new(x, 0.0, 0.0);
        let crossings = BTreeMap::from([([2, 5], vec![[x(0.1), x(-0.1)], [x(0.3), x(0.3)]])]);
        let map = SomatotopicMap { neighbours: Vec::new(), crossings };
        let [from, to] = [(2, x(0.12)), (5, x(-0.15))];
        for way in [map.way_across(from, to), map.way_across(to, from)] {
            assert!((way.expect("it is known") - 0.07).abs() < 1e-12);
        }
        assert!((map.way_to_border(5, &x(0.25)).expect("it is known") - 0.05).abs() < 1e-12);
        assert_eq!((map.way_across(from, (6, x(0.0))), map.way_to_border(6, &x(0.0))), (None, None));
    }
}
