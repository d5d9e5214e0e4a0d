//! Poses of one frame in another.

use std::ops::Mul;

use nalgebra::{Isometry3, Matrix3, Matrix3x2, Rotation3, UnitQuaternion, Vector3};
use serde::{Deserialize, Serialize};

/// A pose `X_AB`: where frame B is in frame A.
///
/// The rotation is a plain matrix, not an orthonormal type: with relaxed axes it need not be one.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Frame {
    /// Rotation `R_AB`.
    pub rotation: Matrix3<f64>,
    /// Origin `p_AB_A` in metres.
    pub origin: Vector3<f64>,
}

impl Frame {
    /// The pose of a frame in itself.
    #[inline]
    pub fn identity() -> Frame {
        Frame { rotation: Matrix3::identity(), origin: Vector3::zeros() }
    }

    /// `p_A = X_AB p_B`.
    #[inline]
    pub fn point(&self, p_b: &Vector3<f64>) -> Vector3<f64> {
        self.direction(p_b) + self.origin
    }

    /// A direction of B in A.
    #[inline]
    pub fn direction(&self, v_b: &Vector3<f64>) -> Vector3<f64> {
        let (r, v) = (&self.rotation, v_b);
        // Written out: this is the innermost loop of babbling, of learning and of every map.
        Vector3::new(
            r.m11 * v.x + r.m12 * v.y + r.m13 * v.z,
            r.m21 * v.x + r.m22 * v.y + r.m23 * v.z,
            r.m31 * v.x + r.m32 * v.y + r.m33 * v.z,
        )
    }

    /// `p_B = X_AB⁻¹ p_A`, for an orthonormal rotation.
    #[inline]
    pub fn inverse_point(&self, p_a: &Vector3<f64>) -> Vector3<f64> {
        self.rotation.tr_mul(&(p_a - self.origin))
    }

    /// The rotation as a unit quaternion, for an orthonormal rotation.
    pub fn quaternion(&self) -> UnitQuaternion<f64> {
        UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(self.rotation))
    }

    /// The same as MuJoCo writes it: w x y z.
    pub fn wxyz(&self) -> [f64; 4] {
        wxyz(&self.quaternion())
    }

    /// `X_BA`, for an orthonormal rotation.
    #[inline]
    pub fn inverse(&self) -> Frame {
        Frame { rotation: self.rotation.transpose(), origin: -self.rotation.tr_mul(&self.origin) }
    }
}

impl Default for Frame {
    fn default() -> Frame {
        Frame::identity()
    }
}

impl From<Isometry3<f64>> for Frame {
    fn from(pose: Isometry3<f64>) -> Frame {
        Frame { rotation: pose.rotation.to_rotation_matrix().into_inner(), origin: pose.translation.vector }
    }
}

/// A rotation matrix that is none for rounding becomes a rotation.
impl From<Frame> for Isometry3<f64> {
    fn from(frame: Frame) -> Isometry3<f64> {
        Isometry3::from_parts(frame.origin.into(), frame.quaternion())
    }
}

/// `X_AC = X_AB X_BC`.
impl Mul for Frame {
    type Output = Frame;

    #[inline]
    fn mul(self, inner: Frame) -> Frame {
        Frame { rotation: product(&self.rotation, &inner.rotation), origin: self.point(&inner.origin) }
    }
}

/// A rotation's quaternion as MuJoCo, and postures, have it: w x y z.
pub(crate) fn wxyz(rotation: &UnitQuaternion<f64>) -> [f64; 4] {
    [rotation.w, rotation.i, rotation.j, rotation.k]
}

/// The rotation that brings the z axis onto a direction by the shortest way, as MuJoCo has it.
pub(crate) fn z_onto(direction: &Vector3<f64>) -> UnitQuaternion<f64> {
    let opposite = || UnitQuaternion::from_axis_angle(&Vector3::x_axis(), std::f64::consts::PI);
    UnitQuaternion::rotation_between(&Vector3::z(), direction).unwrap_or_else(opposite)
}

/// The product of two rotations, written out for the same reason.
#[inline]
pub(crate) fn product(a: &Matrix3<f64>, b: &Matrix3<f64>) -> Matrix3<f64> {
    Matrix3::new(
        a.m11 * b.m11 + a.m12 * b.m21 + a.m13 * b.m31,
        a.m11 * b.m12 + a.m12 * b.m22 + a.m13 * b.m32,
        a.m11 * b.m13 + a.m12 * b.m23 + a.m13 * b.m33,
        a.m21 * b.m11 + a.m22 * b.m21 + a.m23 * b.m31,
        a.m21 * b.m12 + a.m22 * b.m22 + a.m23 * b.m32,
        a.m21 * b.m13 + a.m22 * b.m23 + a.m23 * b.m33,
        a.m31 * b.m11 + a.m32 * b.m21 + a.m33 * b.m31,
        a.m31 * b.m12 + a.m32 * b.m22 + a.m33 * b.m32,
        a.m31 * b.m13 + a.m32 * b.m23 + a.m33 * b.m33,
    )
}

/// An orthonormal basis (3×2) of the plane perpendicular to `axis`: the two directions in which a unit
/// axis can turn.
#[inline]
pub fn tangent_basis(axis: &Vector3<f64>) -> Matrix3x2<f64> {
    let smallest = axis.iamin();
    let mut other = Vector3::zeros();
    other[smallest] = 1.0;
    let first = axis.cross(&other).normalize();
    let second = axis.cross(&first).normalize();
    Matrix3x2::from_columns(&[first, second])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_tangent_basis_is_orthonormal_and_perpendicular() {
        let axis = Vector3::new(0.36, -0.48, 0.8);
        let basis = tangent_basis(&axis);
        assert!((basis.transpose() * basis - nalgebra::Matrix2::identity()).norm() < 1e-14);
        assert!((basis.transpose() * axis).norm() < 1e-14);
    }
}
