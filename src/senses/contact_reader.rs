//! From a contact of the engine to receptors: the one place where receptors are told from geometry.
//!
//! Where limbs press, the receptors' own `touch` sensors tell which of those at a contact fire, and how hard. Babbling stops
//! before anything presses, and at the edge of a flat patch on a round limb no sensor reads what presses: there the nearest
//! one fires whose patch holds the point.

use nalgebra::Vector3;

use super::{Met, SkinContact, SkinSpot, Toucher};
use crate::creature::{Body, site_name};
use crate::mujoco::{Contact, Data, ObjectKind, SensorKind};
use crate::skin::Skin;

/// Contacts weaker than this are not felt, newtons.
pub const FAINT: f64 = 1e-3;

/// What a contact is to the agent.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Reading {
    /// Skin met skin.
    Touch(Met),
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
    /// Per limb, its receptors.
    receptors_on_limb: Vec<Vec<usize>>,
    /// Per receptor, where its own `touch` sensor is among the numbers of all sensors.
    sensor_of_receptor: Vec<Option<usize>>,
}

impl ContactReader {
    /// A reader for the body and its skin.
    pub fn new(body: &Body, skin: &Skin) -> ContactReader {
        let mut sensor_of_receptor = vec![None; skin.receptors.len()];
        for sensor in body.model.sensors() {
            if let (SensorKind::Touch, ObjectKind::Site, Some(site)) = (sensor.kind, sensor.object, sensor.id)
                && let Some(receptor) = skin.receptor(&site_name(&body.model, site))
            {
                sensor_of_receptor[receptor].get_or_insert(sensor.adr);
            }
        }
        let mut receptors_on_limb = vec![Vec::new(); body.creature.limbs().len()];
        skin.receptors.iter().enumerate().for_each(|(r, of)| receptors_on_limb[of.limb].push(r));
        ContactReader { receptors_on_limb, sensor_of_receptor }
    }

    /// Reads one contact of `data`, in whose posture poses are computed, by where it is.
    pub fn read(&self, body: &Body, skin: &Skin, data: &Data, contact: &Contact) -> Reading {
        let limbs = contact.geoms.map(|geom| body.limb_of_geom(geom));
        let [Some(a), Some(b)] = limbs else { return Reading::Foreign };
        if body.creature.neighbouring(a, b) {
            return Reading::Neighbours;
        }
        let place = |side: usize| {
            let side = Side::new(body, data, contact, side)?;
            let receptor = self.nearest(skin, &side)?;
            Some((receptor, side.point))
        };
        match [place(0), place(1)] {
            [Some(first), Some(second)] if a <= b => Reading::Touch(Met::at([first, second])),
            [Some(first), Some(second)] => Reading::Touch(Met::at([second, first])),
            _ => Reading::Bare,
        }
    }

    /// What the skin feels in the step that `data` has just made: receptors that fire where something presses, between
    /// limbs that are not neighbours and with everything else. A receptor feels each party once.
    pub fn skin_contacts(&self, body: &Body, skin: &Skin, data: &Data) -> Vec<SkinContact> {
        let mut found: Vec<SkinContact> = Vec::new();
        let spot = |receptor: usize| SkinSpot { limb: skin.receptors[receptor].limb, receptor };
        for (contact, force) in data.pressing().filter(|(_, force)| *force >= FAINT) {
            let limbs = contact.geoms.map(|geom| body.limb_of_geom(geom));
            if let [Some(a), Some(b)] = limbs
                && body.creature.neighbouring(a, b)
            {
                continue;
            }
            let sides = [0, 1].map(|side| match Side::new(body, data, &contact, side) {
                Some(side) => self.fired(skin, data, &side),
                None => Vec::new(),
            });
            let mut feel = |receptor: usize, by: Toucher, reading: Option<f64>| {
                let same = |other: &&mut SkinContact| other.spot.receptor == receptor && other.by == by;
                match (found.iter_mut().find(same), reading) {
                    (Some(other), None) => other.force += force,
                    (Some(_), Some(_)) => {}
                    (None, _) => {
                        found.push(SkinContact { spot: spot(receptor), by, force: reading.unwrap_or(force) })
                    }
                }
            };
            if limbs.iter().all(Option::is_some) {
                // Bare on one side of a self-touch: the other side alone cannot tell whom it feels.
                let earlier = usize::from(limbs[0] > limbs[1]);
                for &(receptor, reading) in &sides[earlier] {
                    for &(other, _) in &sides[1 - earlier] {
                        feel(receptor, Toucher::Own(spot(other)), reading);
                    }
                }
            } else {
                // The side that has skin is the creature's.
                for (side, receptors) in sides.iter().enumerate() {
                    let by = Toucher::Thing(body.model.geom_body(contact.geoms[1 - side]));
                    receptors.iter().for_each(|&(receptor, reading)| feel(receptor, by, reading));
                }
            }
        }
        found
    }

    /// The receptors at one side of a contact that presses which fire, each with what its sensor reads, newtons; if no sensor
    /// reads it, the nearest. Those on the touched surface come first: a patch may lie over another surface of its limb.
    fn fired(&self, skin: &Skin, data: &Data, side: &Side) -> Vec<(usize, Option<f64>)> {
        let reads = |r: &&usize| skin.receptors[**r].reads(&side.point, &side.outward);
        let reading = |&r: &usize| Some((r, Some(self.sensor_reading(data, r).filter(|f| *f >= FAINT)?)));
        let mut fired: Vec<(usize, Option<f64>)> =
            self.receptors_on_limb[side.limb].iter().filter(reads).filter_map(reading).collect();
        fired.sort_by_key(|(receptor, _)| !skin.is_on(*receptor, side.geom));
        if fired.is_empty() {
            fired.extend(self.nearest(skin, side).map(|receptor| (receptor, None)));
        }
        fired
    }

    /// What the receptor's own `touch` sensor reads after the last step of `data`, newtons.
    fn sensor_reading(&self, data: &Data, receptor: usize) -> Option<f64> {
        let address = self.sensor_of_receptor[receptor]?;
        data.model().has_sensors_enabled().then(|| data.sensordata()[address])
    }

    /// The nearest receptor on the touched geom whose patch holds the point.
    fn nearest(&self, skin: &Skin, side: &Side) -> Option<usize> {
        let distance = |r: usize| (skin.receptors[r].position - side.point).norm_squared();
        let feels =
            |r: &usize| skin.is_on(*r, side.geom) && skin.receptors[*r].feels(&side.point, &side.outward);
        let receptors = self.receptors_on_limb[side.limb].iter().copied().filter(feels);
        receptors.min_by(|&a, &b| distance(a).total_cmp(&distance(b)))
    }
}

/// One side of a contact with a limb.
struct Side {
    geom: usize,
    limb: usize,
    /// The point in the limb's frame, metres.
    point: Vector3<f64>,
    /// The outward normal there, in the limb's frame.
    outward: Vector3<f64>,
}

impl Side {
    /// The first or second side of a contact; none of what is no limb's.
    fn new(body: &Body, data: &Data, contact: &Contact, side: usize) -> Option<Side> {
        let geom = contact.geoms[side];
        let limb = body.limb_of_geom(geom)?;
        let mujoco_body = body.model.geom_body(geom);
        let (x_wb, x_lb) = (data.body_pose(mujoco_body), body.pose_in_limb[mujoco_body]);
        // MuJoCo's normal points from the first geom to the second.
        let outward = if side == 0 { contact.normal } else { -contact.normal };
        let point = (x_lb * x_wb.inverse_transform_point(&contact.position)).coords;
        Some(Side { geom, limb, point, outward: x_lb * x_wb.inverse_transform_vector(&outward) })
    }
}
