//! From a contact of the engine to a contact of the skin: the one place where receptors are told from geometry.

use nalgebra::{Point3, Vector3};

use super::{SkinContact, SkinSpot, Toucher};
use crate::creature::{Body, site_name};
use crate::mujoco::{Contact, Data, ObjectKind, SensorKind};
use crate::skin::Skin;

/// Contacts weaker than this are not felt, newtons.
pub const FAINT: f64 = 1e-3;

/// What a contact is to the agent.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Reading {
    /// Skin met skin: two places, the one on the earlier limb first.
    Touch([SkinSpot; 2]),
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
    /// Per receptor, where its own `touch` sensor is among the numbers of all sensors.
    sensor_of_receptor: Vec<Option<usize>>,
}

impl ContactReader {
    /// A reader for the body and its skin.
    pub fn new(body: &Body, skin: &Skin) -> ContactReader {
        let receptors_on_geom = skin.receptors_by_geom(body.model.ngeom());
        let mut sensor_of_receptor = vec![None; skin.receptors.len()];
        for sensor in body.model.sensors() {
            if let (SensorKind::Touch, ObjectKind::Site, Some(site)) = (sensor.kind, sensor.object, sensor.id)
                && let Some(receptor) = skin.receptor(&site_name(&body.model, site))
            {
                sensor_of_receptor[receptor].get_or_insert(sensor.adr);
            }
        }
        ContactReader { receptors_on_geom, sensor_of_receptor }
    }

    /// Reads one contact of `data`, in whose posture poses are computed.
    pub fn read(&self, body: &Body, skin: &Skin, data: &Data, contact: &Contact) -> Reading {
        let limbs = contact.geoms.map(|geom| body.limb_of_geom(geom));
        let [Some(a), Some(b)] = limbs else { return Reading::Foreign };
        if body.creature.neighbouring(a, b) {
            return Reading::Neighbours;
        }
        match self.spots(body, skin, data, contact) {
            [Some(first), Some(second)] if a <= b => Reading::Touch([first, second]),
            [Some(first), Some(second)] => Reading::Touch([second, first]),
            _ => Reading::Bare,
        }
    }

    /// What the skin feels in the step that `data` has just made: contacts that press, between limbs that are not
    /// neighbours and with everything else.
    pub fn skin_contacts(&self, body: &Body, skin: &Skin, data: &Data) -> Vec<SkinContact> {
        let mut found = Vec::new();
        for (contact, force) in data.pressing().filter(|(_, force)| *force >= FAINT) {
            match self.read(body, skin, data, &contact) {
                Reading::Touch([spot, other]) => {
                    found.push(SkinContact { spot, by: Toucher::Own(other), force });
                }
                Reading::Foreign => {
                    // The side that has skin is the creature's.
                    let spots = self.spots(body, skin, data, &contact).into_iter().zip([1, 0]);
                    found.extend(spots.filter_map(|(spot, other)| {
                        let by = Toucher::Thing(body.model.geom_body(contact.geoms[other]));
                        Some(SkinContact { spot: spot?, by, force })
                    }));
                }
                // Bare on one side of a self-touch: the other side alone cannot tell whom it feels.
                Reading::Bare | Reading::Neighbours => {}
            }
        }
        found
    }

    /// The places on the skin at both ends of a contact of `data`, in the order of its geoms; none where there is no skin.
    pub fn spots(&self, body: &Body, skin: &Skin, data: &Data, contact: &Contact) -> [Option<SkinSpot>; 2] {
        // MuJoCo's normal points from the first geom to the second.
        [(0, contact.normal), (1, -contact.normal)]
            .map(|(k, outward)| self.spot(body, skin, data, contact.geoms[k], &contact.position, &outward))
    }

    /// What the receptor's own `touch` sensor tells of the last step of `data`, newtons.
    pub fn sensor_force(&self, data: &Data, receptor: usize) -> Option<f64> {
        let address = self.sensor_of_receptor[receptor]?;
        data.model().has_sensors_enabled().then(|| data.sensordata()[address])
    }

    /// The nearest receptor on the geom whose patch holds the point.
    fn spot(
        &self,
        body: &Body,
        skin: &Skin,
        data: &Data,
        geom: usize,
        p_w: &Point3<f64>,
        outward_w: &Vector3<f64>,
    ) -> Option<SkinSpot> {
        let mujoco_body = body.model.geom_body(geom);
        let x_wb = data.body_pose(mujoco_body);
        let x_lb = body.pose_in_limb[mujoco_body];
        let point = (x_lb * x_wb.inverse_transform_point(p_w)).coords;
        let outward = x_lb * x_wb.inverse_transform_vector(outward_w);
        let distance = |r: usize| (skin.receptors[r].position - point).norm_squared();
        let feels = |r: &usize| skin.receptors[*r].feels(&point, &outward);
        let receptors = self.receptors_on_geom[geom].iter().copied();
        let receptor = receptors.filter(feels).min_by(|&a, &b| distance(a).total_cmp(&distance(b)))?;
        let limb = skin.receptors[receptor].limb;
        Some(SkinSpot { limb, receptor, point, sensor_force: self.sensor_force(data, receptor) })
    }
}
