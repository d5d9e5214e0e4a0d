//! Contacts: where two geoms touch in the current posture.

use nalgebra::{Point3, Vector3};

use super::ffi;

/// A place where two geoms touch or nearly do.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Contact {
    /// The two geoms; the engine puts the one with the lower shape type first.
    pub geoms: [usize; 2],
    /// Midpoint between the two surfaces, in the world frame, in metres.
    pub position: Point3<f64>,
    /// Unit normal from the first geom to the second, in the world frame.
    pub normal: Vector3<f64>,
    /// Distance between the surfaces, in metres; negative where they overlap.
    pub distance: f64,
}

/// The contacts of a posture, in the engine's order.
#[derive(Clone)]
pub struct Contacts<'d>(pub(super) std::slice::Iter<'d, ffi::mjContact>);

impl Iterator for Contacts<'_> {
    type Item = Contact;

    fn next(&mut self) -> Option<Contact> {
        // Contacts of a deformable body carry a geom of -1: they are none of a geom pair.
        self.0.by_ref().find(|raw| raw.geom1 >= 0 && raw.geom2 >= 0).map(|raw| Contact {
            geoms: [raw.geom1 as usize, raw.geom2 as usize],
            position: Point3::new(raw.pos[0], raw.pos[1], raw.pos[2]),
            normal: Vector3::new(raw.frame[0], raw.frame[1], raw.frame[2]),
            distance: raw.dist,
        })
    }
}
