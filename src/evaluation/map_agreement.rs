//! How far a learned somatotopic map agrees with the one that the geometry gives.

use serde::{Deserialize, Serialize};

use crate::skin::SomatotopicMap;

/// Pairs of neighbours in both maps.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct MapAgreement {
    /// Pairs that were learned.
    pub learned: usize,
    /// Pairs that the geometry has.
    pub geometric: usize,
    /// Pairs in both.
    pub shared: usize,
}

impl MapAgreement {
    /// Compares maps of one skin: all pairs.
    pub fn of_all(learned: &SomatotopicMap, geometric: &SomatotopicMap) -> MapAgreement {
        MapAgreement::of_pairs(learned, geometric, |_| true)
    }

    /// Compares maps of one skin: the pairs of receptors that count.
    pub fn of_pairs(
        learned: &SomatotopicMap,
        geometric: &SomatotopicMap,
        counts: impl Fn([usize; 2]) -> bool,
    ) -> MapAgreement {
        let geometric_pairs = geometric.pairs().filter(|pair| counts(*pair)).count();
        let mut found = MapAgreement { geometric: geometric_pairs, ..MapAgreement::default() };
        for [a, b] in learned.pairs().filter(|pair| counts(*pair)) {
            found.learned += 1;
            found.shared += usize::from(geometric.adjacent(a, b));
        }
        found
    }

    /// The share of the geometry's pairs that were learned; NaN where it has none.
    pub fn recall(&self) -> f64 {
        self.shared as f64 / self.geometric as f64
    }

    /// The share of the learned pairs that the geometry has; NaN where none was learned.
    pub fn precision(&self) -> f64 {
        self.shared as f64 / self.learned as f64
    }

    /// Recall and precision in one, their harmonic mean: the shared pairs among the mean number of both maps; NaN where
    /// both are empty.
    pub fn agreement(&self) -> f64 {
        2.0 * self.shared as f64 / (self.learned + self.geometric) as f64
    }
}
