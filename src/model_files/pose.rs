//! Poses as MJCF writes them: in degrees or radians, by quaternions, axes, or angles in some order.

use nalgebra::{Isometry3, Matrix3, Quaternion, Rotation3, Translation3, UnitQuaternion, Vector3};

use super::tree::{Element, numbers};
use super::write::exact;
use crate::geometry::z_onto;

/// The ways to give an orientation.
pub(crate) const ORIENTATIONS: [&str; 5] = ["quat", "axisangle", "xyaxes", "zaxis", "euler"];

/// How a file gives its angles.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Angles {
    /// Whether angles are in degrees.
    degrees: bool,
    /// The axes of Euler angles in turn; capital letters stand still, small ones turn along.
    sequence: Vec<u8>,
}

impl Angles {
    /// By the settings `angle` and `eulerseq` of a compiler.
    pub fn new(angle: Option<&str>, sequence: Option<&str>) -> Angles {
        let sequence = sequence.filter(|sequence| sequence.len() == 3).unwrap_or("xyz");
        Angles { degrees: angle != Some("radian"), sequence: sequence.as_bytes().to_vec() }
    }

    /// By what a model's file says, with what it includes written out.
    pub fn of(root: &Element) -> Angles {
        Angles::new(root.setting("compiler", "angle"), root.setting("compiler", "eulerseq"))
    }

    /// An angle as written in radians.
    pub fn radians(&self, angle: f64) -> f64 {
        if self.degrees { angle.to_radians() } else { angle }
    }

    /// Radians as the file writes them.
    pub fn written(&self, radians: f64) -> f64 {
        if self.degrees { radians.to_degrees() } else { radians }
    }

    fn euler(&self, angles: [f64; 3]) -> UnitQuaternion<f64> {
        let turns = self.sequence.iter().zip(angles);
        turns.fold(UnitQuaternion::identity(), |before, (axis, angle)| {
            let unit = Vector3::ith_axis(usize::from(axis.to_ascii_lowercase().saturating_sub(b'x').min(2)));
            let turn = UnitQuaternion::from_axis_angle(&unit, self.radians(angle));
            if axis.is_ascii_lowercase() { before * turn } else { turn * before }
        })
    }

    /// The orientation that an element gives, if it gives one.
    pub fn orientation(&self, element: &Element) -> Option<UnitQuaternion<f64>> {
        let given = |name| Some((name, numbers(element.get(name)?))).filter(|(_, given)| !given.is_empty());
        let (name, given) = ORIENTATIONS.into_iter().find_map(given)?;
        match (name, given.as_slice()) {
            ("quat", [w, x, y, z]) => UnitQuaternion::try_new(Quaternion::new(*w, *x, *y, *z), 0.0),
            ("axisangle", [x, y, z, angle]) => {
                let axis = Vector3::new(*x, *y, *z).try_normalize(0.0)?;
                Some(UnitQuaternion::from_scaled_axis(axis * self.radians(*angle)))
            }
            ("xyaxes", [a, b, c, d, e, f]) => {
                let x = Vector3::new(*a, *b, *c).try_normalize(0.0)?;
                let y = Vector3::new(*d, *e, *f);
                let y = (y - x * x.dot(&y)).try_normalize(0.0)?;
                let matrix = Matrix3::from_columns(&[x, y, x.cross(&y)]);
                Some(UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(matrix)))
            }
            ("zaxis", [x, y, z]) => Some(z_onto(&Vector3::new(*x, *y, *z).try_normalize(0.0)?)),
            ("euler", [x, y, z]) => Some(self.euler([*x, *y, *z])),
            _ => None,
        }
    }

    /// The pose that an element gives; what it does not give is zero.
    pub fn pose(&self, element: &Element) -> Isometry3<f64> {
        let position = element.vector("pos").unwrap_or_default();
        let orientation = self.orientation(element).unwrap_or_default();
        Isometry3::from_parts(Translation3::from(position), orientation)
    }
}

/// Writes a pose into an element, in place of the one it has; zero is left out.
pub(super) fn set_pose(element: &mut Element, pose: &Isometry3<f64>) {
    for name in ORIENTATIONS.into_iter().chain(["pos"]) {
        element.remove(name);
    }
    if pose.translation.vector != Vector3::zeros() {
        element.set("pos", exact(pose.translation.vector.iter()));
    }
    let turn = &pose.rotation;
    if turn.imag() != Vector3::zeros() {
        element.set("quat", exact(&[turn.w, turn.i, turn.j, turn.k]));
    }
}
