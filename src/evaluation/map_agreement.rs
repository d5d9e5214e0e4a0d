//! How far a learned somatotopic map agrees with the one that the geometry gives.

use serde::{Deserialize, Serialize};

use crate::skin::{Skin, SomatotopicMap};

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
    /// Compares maps of one skin: per limb.
    pub fn by_limb(learned: &SomatotopicMap, skin: &Skin, limbs: usize) -> Vec<MapAgreement> {
        let geometric = SomatotopicMap::new(skin);
        let mut found = vec![MapAgreement::default(); limbs];
        let limb = |receptor: usize| skin.receptors[receptor].limb;
        geometric.pairs().for_each(|[a, _]| found[limb(a)].geometric += 1);
        for [a, b] in learned.pairs() {
            found[limb(a)].learned += 1;
            found[limb(a)].shared += usize::from(geometric.adjacent(a, b));
        }
        found
    }

    /// All limbs as one.
    pub fn of_all(limbs: &[MapAgreement]) -> MapAgreement {
        limbs.iter().fold(MapAgreement::default(), |all, limb| MapAgreement {
            learned: all.learned + limb.learned,
            geometric: all.geometric + limb.geometric,
            shared: all.shared + limb.shared,
        })
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
