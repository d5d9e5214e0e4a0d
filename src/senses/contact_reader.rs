//! From a contact of the engine to a touch of the skin.

use nalgebra::{Point3, Vector3};

use super::TouchEnd;
use crate::creature::Body;
use crate::mujoco::{Contact, Data};
use crate::skin::Skin;

/// What a contact is to the agent.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Reading {
    /// Skin met skin: two receptors, the one on the earlier limb first.
    Touch([TouchEnd; 2]),
    /// At least one side has no receptor there.
    Bare,
    /// The two limbs carry one another, or are one.
    Neighbours,
    /// At least one side is not the creature's own body.
    Foreign,
}

/// Reads contacts by the skin of one body.
#[derive(Clone, Debug)]
pub struct ContactReader {
    /// Per geom, the receptors that lie on it.
    receptors_on_geom: Vec<Vec<usize>>,
}

impl ContactReader {
    /// A reader for the body and its skin.
    pub fn new(body: &Body, skin: &Skin) -> ContactReader {
        let mut receptors_on_geom = vec![Vec::new(); body.model.ngeom()];
        for (r, receptor) in skin.receptors.iter().enumerate() {
            if let Some(surface) = receptor.surface {
                receptors_on_geom[skin.surfaces[surface].geom].push(r);
            }
        }
        ContactReader { receptors_on_geom }
    }

    /// Whether any receptor lies on the geom.
    pub fn has_skin(&self, geom: usize) -> bool {
        !self.receptors_on_geom[geom].is_empty()
    }

    /// Reads one contact of `data`, in whose posture poses are computed.
    pub fn read(&self, body: &Body, skin: &Skin, data: &Data, contact: &Contact) -> Reading {
        let limbs = contact.geoms.map(|geom| body.limb_of_geom(geom));
        let [Some(a), Some(b)] = limbs else { return Reading::Foreign };
        if body.creature.neighbouring(a, b) {
            return Reading::Neighbours;
        }
        match self.ends(body, skin, data, contact) {
            [Some(first), Some(second)] if a <= b => Reading::Touch([first, second]),
            [Some(first), Some(second)] => Reading::Touch([second, first]),
            _ => Reading::Bare,
        }
    }

    /// The receptors at both ends of a contact of `data`, in the order of its geoms; none where there is no skin.
    pub fn ends(&self, body: &Body, skin: &Skin, data: &Data, contact: &Contact) -> [Option<TouchEnd>; 2] {
        // MuJoCo's normal points from the first geom to the second.
        [(0, contact.normal), (1, -contact.normal)]
            .map(|(k, outward)| self.end(body, skin, data, contact.geoms[k], &contact.position, &outward))
    }

    /// The nearest receptor on the geom whose patch holds the point.
    fn end(
        &self,
        body: &Body,
        skin: &Skin,
        data: &Data,
        geom: usize,
        p_w: &Point3<f64>,
        outward_w: &Vector3<f64>,
    ) -> Option<TouchEnd> {
        let mujoco_body = body.model.geom_body(geom);
        let x_wb = data.body_pose(mujoco_body);
        let x_lb = body.pose_in_limb[mujoco_body];
        let contact = (x_lb * x_wb.inverse_transform_point(p_w)).coords;
        let outward = x_lb * x_wb.inverse_transform_vector(outward_w);
        let distance = |r: usize| (skin.receptors[r].position - contact).norm_squared();
        let holds = |r: &usize| {
            let receptor = &skin.receptors[*r];
            receptor.holds(&contact) && receptor.normal.dot(&outward) > 0.0
        };
        let receptors = self.receptors_on_geom[geom].iter().copied();
        let receptor = receptors.filter(holds).min_by(|&a, &b| distance(a).total_cmp(&distance(b)))?;
        Some(TouchEnd { receptor, contact, deviation: None })
    }
}
