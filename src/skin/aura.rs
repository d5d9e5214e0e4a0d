//! The geometries of the aura: one about each aura limb, in the reach of which something is near.
//!
//! "Around every geometry representing a limb of Max's body, 17 proximity geometries were added forming a 'proximity
//! aura'" (IVA 2009, section 2). Here a limb's geometry is a capsule about its surfaces, grown by how far it reaches. A
//! model may have them itself, as geoms without contact: a capsule or a ball `aura/NAME` on a body of the aura limb
//! `NAME`. What it has none of is grown.

use nalgebra::{Point3, Vector3};

use super::{Skin, Surface};
use crate::creature::{AuraLimb, Body, Creature};
use crate::geometry::{Ball, Capsule, Frame, Shape};
use crate::mujoco::AURA_GEOM;

/// How far an aura reaches beyond its limb, metres: an object of 1 m/s is noticed a third of a second before.
pub const AURA_REACH: f64 = 0.35;

/// The proximity geometry of one aura limb: a capsule in the frame of one of its limbs.
#[derive(Clone, Debug, PartialEq)]
pub struct ProximityGeometry {
    /// What it is called: the aura limb that it is about. Limbs that are one with joints held may have several.
    pub name: String,
    /// The aura limb, an index into the creature's.
    pub aura_limb: usize,
    /// The limb that carries it.
    pub limb: usize,
    /// The capsule in that limb's frame, its reach beyond the limb included.
    pub capsule: Capsule,
    /// Whether the model has it; it is grown otherwise.
    pub of_model: bool,
}

impl ProximityGeometry {
    /// Whether a ball, in the frame of [`ProximityGeometry::limb`], is partly inside.
    pub fn holds(&self, ball: &Ball) -> bool {
        self.capsule.distance_to(ball) < 0.0
    }

    /// How far it reaches beyond the surfaces of its aura limb at the least, metres, where limbs are at `X_CL`, below 0
    /// where it does not hold them; `None` if the aura limb has no surface.
    pub fn reach(&self, creature: &Creature, skin: &Skin, frames: &[Frame]) -> Option<f64> {
        let limbs = &creature.aura_limbs()[self.aura_limb].limbs;
        Some(self.capsule.radius - girth(limbs, skin, frames, self.limb, &self.capsule)?)
    }
}

/// The proximity geometries of a creature in its model: those that the model has, and a grown one for each aura limb with a
/// surface that it has none of. Limb frames `X_WL` are those of the reference posture.
pub fn aura_of(body: &Body, skin: &Skin, frames: &[Frame]) -> Vec<ProximityGeometry> {
    let mut found = own_aura_geometries(body);
    let grown = grow_aura(&body.creature, skin, frames);
    let lacks = |one: &ProximityGeometry| !found.iter().any(|own| own.aura_limb == one.aura_limb);
    let missing: Vec<ProximityGeometry> = grown.into_iter().filter(lacks).collect();
    found.extend(missing);
    found.sort_by_key(|geometry| geometry.aura_limb);
    found
}

/// The proximity geometries that the model has, in its order: capsules and balls on the creature's bodies.
fn own_aura_geometries(body: &Body) -> Vec<ProximityGeometry> {
    let model = &body.model;
    let geometry = |geom: usize| {
        let info = model.geom(geom);
        let limb = body.limb_of_geom(geom)?;
        let frame = Frame::from(body.geom_in_limb(&info));
        Some(ProximityGeometry {
            name: info.name?.strip_prefix(AURA_GEOM)?.to_string(),
            aura_limb: body.creature.aura_of(limb)?,
            limb,
            capsule: Shape::of_geom(model, geom)?.as_capsule(&frame)?,
            of_model: true,
        })
    };
    (0..model.ngeom()).filter(|&geom| model.is_aura(geom)).filter_map(geometry).collect()
}

/// Makes the proximity geometries of a creature, one for each aura limb that has a surface: about it, on its first limb,
/// where limbs are at `X_CL` in the reference posture.
pub fn grow_aura(creature: &Creature, skin: &Skin, frames: &[Frame]) -> Vec<ProximityGeometry> {
    let geometry = |(aura_limb, aura): (usize, &AuraLimb)| {
        let limb = *aura.limbs.first()?;
        let about = Capsule::about_points(&outline(&aura.limbs, skin, frames, limb))?;
        let radius = girth(&aura.limbs, skin, frames, limb, &about)? + AURA_REACH;
        let capsule = Capsule { radius, ..about };
        Some(ProximityGeometry { name: aura.name.clone(), aura_limb, limb, capsule, of_model: false })
    };
    creature.aura_limbs().iter().enumerate().filter_map(geometry).collect()
}

/// Points of the surfaces of some limbs that are farthest in some directions, in the frame of `limb`.
fn outline(limbs: &[usize], skin: &Skin, frames: &[Frame], limb: usize) -> Vec<Vector3<f64>> {
    let directions = directions();
    let of_surface = |surface: &Surface| -> Vec<Vector3<f64>> {
        let farthest = directions.iter().filter_map(|direction| surface.support(direction));
        farthest.map(|p| frames[limb].inverse_point(&frames[surface.limb].point(&p))).collect()
    };
    let surfaces = skin.surfaces.iter().filter(|surface| limbs.contains(&surface.limb));
    surfaces.flat_map(of_surface).collect()
}

/// The radius of a capsule with the segment of `about`, in the frame of `limb`, that just holds the surfaces of some limbs;
/// `None` if there are none. Capsules and balls are measured as they are, others by points of their outline.
fn girth(limbs: &[usize], skin: &Skin, frames: &[Frame], limb: usize, about: &Capsule) -> Option<f64> {
    let to_limb = frames[limb].inverse();
    let of_ball = |centre: Vector3<f64>, radius: f64| {
        about.distance_to(&Ball { centre, radius: 0.0 }) + about.radius + radius
    };
    let of_surface = |surface: &Surface| {
        let there = to_limb * frames[surface.limb];
        match surface.as_capsule() {
            Some(capsule) => {
                let [a, b] = capsule.placed(&there).ends;
                Some(of_ball(a, capsule.radius).max(of_ball(b, capsule.radius)))
            }
            None => {
                let points = directions().into_iter().filter_map(|direction| surface.support(&direction));
                points.map(|point| of_ball(there.point(&point), 0.0)).reduce(f64::max)
            }
        }
    };
    let surfaces = skin.surfaces.iter().filter(|surface| limbs.contains(&surface.limb));
    surfaces.filter_map(of_surface).reduce(f64::max)
}

/// Directions all round, alike on all sides and along no axis, which shapes have their own along: there two points would be
/// as far, of which one is told.
fn directions() -> Vec<Vector3<f64>> {
    const ORDERS: [[f64; 3]; 6] = [
        [3.0, 2.0, 1.0],
        [3.0, 1.0, 2.0],
        [2.0, 3.0, 1.0],
        [2.0, 1.0, 3.0],
        [1.0, 3.0, 2.0],
        [1.0, 2.0, 3.0],
    ];
    let sign = |octant: usize, k: usize| if octant >> k & 1 == 0 { 1.0 } else { -1.0 };
    let of_octant = |octant: usize| ORDERS.map(|order| Vector3::from_fn(|k, _| sign(octant, k) * order[k]));
    (0..8).flat_map(of_octant).collect()
}

/// A body of the model that bears a proximity geometry, and the capsule in that body's frame.
pub(super) fn on_body(body: &Body, geometry: &ProximityGeometry) -> Option<(usize, Capsule)> {
    let bearer = body.limb_of_body.iter().position(|limb| *limb == Some(geometry.limb))?;
    let to_body = body.pose_in_limb[bearer].inverse();
    let ends = geometry.capsule.ends.map(|end| (to_body * Point3::from(end)).coords);
    Some((bearer, Capsule { ends, ..geometry.capsule }))
}
