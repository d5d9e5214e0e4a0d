//! Plausible ranges of a body's numbers: larger ones in a file are a typo or in another unit.

use nalgebra::{Matrix3, Vector3};

use crate::geometry::{Frame, Shape};

/// The greatest length, coordinate or deviation of a position, metres: no body is ten kilometres long.
pub(crate) const GREATEST_LENGTH: f64 = 1e4;
/// The greatest coordinate, distance or deviation of a body that was learned, metres: of one that was not, it may be said to be
/// anywhere.
pub(crate) const GREATEST_LEARNED: f64 = 1e15;
/// The greatest angle of a joint, radians: some sixteen hundred turns.
pub(crate) const GREATEST_ANGLE: f64 = 1e4;
/// The greatest coefficient of a joint that follows another: what a metre or radian of that one does to it.
pub(crate) const GREATEST_COEFFICIENT: f64 = 1e6;
/// How far the length of a direction may be from 1, and directions at right angles from these: they may have been written with
/// a few digits.
pub(crate) const UNIT: f64 = 1e-4;

/// Whether a number can be a coordinate, metres.
pub(crate) fn is_length(x: f64) -> bool {
    x.abs() <= GREATEST_LENGTH
}

/// Whether a number can be a joint's angle, radians.
pub(crate) fn is_angle(x: f64) -> bool {
    x.abs() <= GREATEST_ANGLE
}

/// Least and greatest coordinate between limits, of which those beyond all that can be, or infinite, are none: where only one
/// is, the range is `span` to either side of its middle. `None` if neither is a limit.
pub(crate) fn bounded([least, greatest]: [f64; 2], span: f64) -> Option<[f64; 2]> {
    match [least, greatest].map(is_angle) {
        [true, true] => Some([least, greatest]),
        [true, false] => Some([least, least + 2.0 * span]),
        [false, true] => Some([greatest - 2.0 * span, greatest]),
        [false, false] => None,
    }
}

/// Whether a number can be a deviation of a length, or of an angle: infinite where nothing is known.
pub(crate) fn is_deviation(x: f64) -> bool {
    x == f64::INFINITY || (0.0..=GREATEST_LENGTH).contains(&x)
}

/// What is wrong with a place, and the fix.
pub(crate) fn place_fault(place: &Vector3<f64>) -> Option<String> {
    let wrong = place.iter().find(|x| !is_length(**x))?;
    Some(format!(
        "has a coordinate of {wrong} m: give metres, at most {GREATEST_LENGTH} from its frame's origin"
    ))
}

/// What is wrong with a direction, and the fix.
pub(crate) fn direction_fault(direction: &Vector3<f64>) -> Option<String> {
    let length = direction.norm();
    let unit = (length - 1.0).abs() <= UNIT;
    (!unit)
        .then(|| format!("has a direction of length {length}: divide it by its length, and keep five digits"))
}

/// What is wrong with a rotation, and the fix.
pub(crate) fn rotation_fault(rotation: &Matrix3<f64>) -> Option<String> {
    let off = (rotation.tr_mul(rotation) - Matrix3::identity()).amax();
    let turns = off <= UNIT && rotation.determinant() > 0.0;
    (!turns).then(|| {
        "has an invalid rotation: give three orthonormal, right-handed columns, to five digits".into()
    })
}

/// What is wrong with a pose, and the fix.
pub(crate) fn pose_fault(pose: &Frame) -> Option<String> {
    place_fault(&pose.origin).or_else(|| rotation_fault(&pose.rotation))
}

/// What is wrong with a shape's size, and the fix.
pub(crate) fn shape_fault(shape: &Shape) -> Option<String> {
    let sizes = match shape {
        Shape::Sphere { radius } => vec![*radius],
        // The segment of a capsule may be a point.
        Shape::Capsule { radius, half_length: 0.0 } => vec![*radius],
        Shape::Capsule { radius, half_length } => vec![*radius, *half_length],
        Shape::Cylinder { radius, half_length } => vec![*radius, *half_length],
        Shape::Ellipsoid { semi_axes: sizes } | Shape::Box { half_extents: sizes } => sizes.to_vec(),
        Shape::Hull(_) => shape.half_bounds().iter().copied().collect(),
        Shape::Mesh => Vec::new(),
    };
    let wrong = sizes.into_iter().find(|size| !(*size > 0.0 && *size <= GREATEST_LENGTH))?;
    Some(format!("has a shape of size {wrong} m: give metres above 0, at most {GREATEST_LENGTH}"))
}

/// What is wrong with a patch's half extents, and the fix.
pub(crate) fn extent_fault(half_extents: &[f64; 2]) -> Option<String> {
    let wrong = half_extents.iter().find(|half| !(0.0..=GREATEST_LENGTH).contains(*half))?;
    Some(format!("has a half extent of {wrong} m: give metres from 0 to {GREATEST_LENGTH}"))
}
