//! The skin: receptors on the limbs, and which of them are neighbours.

mod aura;
mod from_model;
mod growing;
mod joined_limbs;
mod somatotopic_map;
mod surface;
mod surface_graph;

use std::collections::{BTreeMap, HashMap};

use nalgebra::{Matrix3, Vector3};
use serde::{Deserialize, Serialize};

use crate::kinematics::Place;

pub use aura::{AURA_REACH, ProximityGeometry, aura_of, grow_aura};
pub use from_model::skin_of;
pub(crate) use from_model::{surface_of_body, surface_of_geom};
pub(crate) use growing::grow_counted;
pub use growing::{GrowOptions, Grown, PatchSize, grow, grow_skin, grow_skin_rooted};
pub(crate) use joined_limbs::JoinedLimbs;
pub use somatotopic_map::{MOST_NEIGHBOURS, SomatotopicMap};
pub use surface::Surface;
pub(crate) use surface_graph::arc;

/// Half the thickness of a patch, metres.
const HALF_THICK: f64 = 8e-4;

/// One touch receptor: a flat quadrangle on a limb's surface.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, expecting = "an object")]
pub struct Receptor {
    /// Its id, the name of its site in the model.
    pub id: String,
    /// The limb it is attached to.
    pub limb: usize,
    /// `p_LR`: its centre in the limb's frame, metres.
    pub position: Vector3<f64>,
    /// `n_L`: its outward unit normal, expressed in the limb's frame.
    pub normal: Vector3<f64>,
    /// The unit direction of its first side, perpendicular to the normal, in the limb's frame.
    pub tangent: Vector3<f64>,
    /// Half extents along the tangent and along normal × tangent, metres.
    pub half_extents: [f64; 2],
    /// The surface it lies on, an index into [`Skin::surfaces`]; none when the model does not tell.
    // In a file it is there as a null at least: what is misspelt would be none in silence.
    #[serde(deserialize_with = "Option::deserialize")]
    pub surface: Option<usize>,
}

impl Receptor {
    /// The direction of its second side: normal × tangent.
    #[inline]
    pub fn bitangent(&self) -> Vector3<f64> {
        self.normal.cross(&self.tangent)
    }

    /// Its centre, so far above the skin, and its outward normal: metres, below 0 for a place inside the limb.
    pub fn place(&self, height: f64) -> Place {
        Place { limb: self.limb, point: self.position + self.normal * height, direction: self.normal }
    }

    /// A point of the flat patch in shares of its half sides, along the tangent and across it, in the limb's frame, metres.
    pub fn patch_point(&self, [along, across]: [f64; 2]) -> Vector3<f64> {
        self.position
            + self.tangent * (along * self.half_extents[0])
            + self.bitangent() * (across * self.half_extents[1])
    }

    /// A point of its limb in the patch's own coordinates: along both sides and the normal, metres.
    #[inline]
    pub fn patch_coordinates(&self, p_l: &Vector3<f64>) -> Vector3<f64> {
        let offset = p_l - self.position;
        Vector3::new(offset.dot(&self.tangent), offset.dot(&self.bitangent()), offset.dot(&self.normal))
    }

    /// Whether the point, projected onto the patch along its normal, lies inside.
    pub fn holds(&self, p_l: &Vector3<f64>) -> bool {
        let at = self.patch_coordinates(p_l);
        at.x.abs() <= self.half_extents[0] && at.y.abs() <= self.half_extents[1]
    }

    /// Whether it feels a point of its limb's surface whose outward normal is given.
    pub fn feels(&self, p_l: &Vector3<f64>, outward: &Vector3<f64>) -> bool {
        self.holds(p_l) && self.normal.dot(outward) > 0.0
    }

    /// Whether its `touch` sensor reads what presses at a point of its limb with an outward normal: by MuJoCo's rule, if the
    /// line from there along the normal leads through the patch.
    pub(crate) fn reads(&self, p_l: &Vector3<f64>, outward: &Vector3<f64>) -> bool {
        let (below, along) = (-self.patch_coordinates(p_l).z, self.normal.dot(outward));
        along > 0.0 && below > -HALF_THICK && self.holds(&(p_l + outward * (below / along)))
    }

    /// Where on the limb a contact that this receptor reports may be: the covariance of a uniform
    /// distribution over the patch (h²/3 along each side) and `normal_deviation` along the normal, m².
    pub fn covariance(&self, normal_deviation: f64) -> Matrix3<f64> {
        let along = |direction: Vector3<f64>, variance: f64| direction * direction.transpose() * variance;
        along(self.tangent, self.half_extents[0].powi(2) / 3.0)
            + along(self.bitangent(), self.half_extents[1].powi(2) / 3.0)
            + along(self.normal, normal_deviation.powi(2))
    }
}

/// How far some points extend: from the one that is farthest from the first to the one that is farthest from that, which is
/// half of the greatest distance between two at the least.
fn extent(points: &[Vector3<f64>]) -> f64 {
    let farthest_of = |from: &Vector3<f64>| {
        let far = points.iter().max_by(|a, b| (*a - from).norm().total_cmp(&(*b - from).norm()));
        far.copied().unwrap_or(*from)
    };
    points.first().map_or(0.0, |first| {
        let end = farthest_of(first);
        (farthest_of(&end) - end).norm()
    })
}

/// All receptors of a creature and the surfaces they lie on.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, expecting = "an object")]
pub struct Skin {
    /// The receptors, in the order of the model's sites.
    pub receptors: Vec<Receptor>,
    /// The surfaces of the limbs.
    #[serde(default)]
    pub surfaces: Vec<Surface>,
}

impl Skin {
    /// The same skin with all lengths so many times as long.
    pub(crate) fn scaled(&self, by: f64) -> Skin {
        let receptors = self.receptors.iter().map(|receptor| Receptor {
            position: by * receptor.position,
            half_extents: receptor.half_extents.map(|half| by * half),
            ..receptor.clone()
        });
        let surfaces = self.surfaces.iter().map(|surface| Surface {
            limb: surface.limb,
            origin: by * surface.origin,
            rotation: surface.rotation,
            shape: surface.shape.scaled(by),
            geom: surface.geom,
        });
        Skin { receptors: receptors.collect(), surfaces: surfaces.collect() }
    }

    /// The receptors' indices by their ids.
    pub(crate) fn numbers(&self) -> HashMap<&str, usize> {
        self.receptors.iter().enumerate().map(|(r, receptor)| (receptor.id.as_str(), r)).collect()
    }

    /// The receptors on a limb.
    pub fn receptors_on(&self, limb: usize) -> impl Iterator<Item = usize> + Clone {
        (0..self.receptors.len()).filter(move |&receptor| self.receptors[receptor].limb == limb)
    }

    /// How far the receptors of the longest limb extend, metres; 0 where no limb has two.
    pub(crate) fn longest_limb(&self) -> f64 {
        let mut of_limbs: BTreeMap<usize, Vec<Vector3<f64>>> = BTreeMap::new();
        for receptor in &self.receptors {
            of_limbs.entry(receptor.limb).or_default().push(receptor.position);
        }
        of_limbs.values().map(|points| extent(points)).fold(0.0, f64::max)
    }

    /// Whether the surfaces under some receptors are known and curved wherever something touches them.
    pub(crate) fn all_round(&self, mut receptors: impl Iterator<Item = usize>) -> bool {
        let surface = |receptor: usize| self.receptors[receptor].surface;
        receptors.all(|receptor| surface(receptor).is_some_and(|surface| self.surfaces[surface].is_round()))
    }

    /// Whether a receptor lies on a geom of the model.
    pub(crate) fn is_on(&self, receptor: usize, geom: usize) -> bool {
        self.receptors[receptor].surface.is_some_and(|surface| self.surfaces[surface].geom == geom)
    }

    /// The index of a receptor by id.
    pub fn receptor(&self, id: &str) -> Option<usize> {
        self.receptors.iter().position(|receptor| receptor.id == id)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_receptor_feels_its_own_patch_from_outside_alone() {
        let receptor = Receptor {
            id: "back".into(),
            limb: 0,
            position: Vector3::new(0.0, 0.0, 0.1),
            normal: Vector3::z(),
            tangent: Vector3::y(),
            half_extents: [0.02, 0.01],
            surface: None,
        };
        // The tangent leads along y: there it is twice as wide.
        let [inside, beside] = [Vector3::new(0.009, 0.019, 0.1), Vector3::new(0.019, 0.009, 0.1)];
        assert!(receptor.feels(&inside, &Vector3::z()) && !receptor.feels(&inside, &-Vector3::z()));
        assert!(!receptor.feels(&beside, &Vector3::z()));
        let covariance = receptor.covariance(0.003);
        let expected = Vector3::new(0.01f64.powi(2) / 3.0, 0.02f64.powi(2) / 3.0, 0.003f64.powi(2));
        assert!((covariance - Matrix3::from_diagonal(&expected)).norm() < 1e-12);
    }
}
