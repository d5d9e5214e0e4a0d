//! Rotation about an axis, and how it changes with the axis.

use nalgebra::{Matrix3, Vector3};

/// The cross-product matrix `[v]×`, with `[v]× w = v × w`.
#[inline]
pub fn skew(v: &Vector3<f64>) -> Matrix3<f64> {
    Matrix3::new(0.0, -v.z, v.y, v.z, 0.0, -v.x, -v.y, v.x, 0.0)
}

/// Rodrigues' rotation `R(a, θ) = I + sin θ [a]× + (1 − cos θ) [a]×²`.
///
/// `sine` is sin θ and `versine` is 1 − cos θ. For a unit axis this is the rotation by θ. For any other
/// length it is the polynomial continuation on which the second-order learner relaxes the unit-axis
/// constraint: linear and quadratic in `a`, hence without the local minima that the sphere makes.
#[inline]
pub fn rotation(axis: &Vector3<f64>, sine: f64, versine: f64) -> Matrix3<f64> {
    // [a]×² = a aᵀ − |a|² I, written out: this is the innermost loop of every learner.
    let (x, y, z) = (axis.x, axis.y, axis.z);
    let (xx, yy, zz) = (x * x, y * y, z * z);
    let (xy, xz, yz) = (versine * x * y, versine * x * z, versine * y * z);
    let (sx, sy, sz) = (sine * x, sine * y, sine * z);
    Matrix3::new(
        1.0 - versine * (yy + zz),
        xy - sz,
        xz + sy,
        xy + sz,
        1.0 - versine * (xx + zz),
        yz - sx,
        xz - sy,
        yz + sx,
        1.0 - versine * (xx + yy),
    )
}

/// `∂(R(a, θ) v)/∂a`, 3×3, with `R` as in [`rotation`] and `a` free in R³.
///
/// From `R v = v + sin θ a×v + (1 − cos θ) a×(a×v)` follows
/// `−sin θ [v]× + (1 − cos θ) ((a·v) I + a vᵀ − 2 v aᵀ)`.
#[inline]
pub fn axis_derivative(axis: &Vector3<f64>, sine: f64, versine: f64, v: &Vector3<f64>) -> Matrix3<f64> {
    let mut derivative = skew(v) * -sine;
    derivative += (axis * v.transpose() - v * axis.transpose() * 2.0) * versine;
    let diagonal = versine * axis.dot(v);
    for i in 0..3 {
        derivative[(i, i)] += diagonal;
    }
    derivative
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::{Rotation3, Unit};

    const AXIS: Vector3<f64> = Vector3::new(0.36, -0.48, 0.8);

    #[test]
    fn a_unit_axis_gives_the_rotation() {
        for angle in [-3.0, -0.4, 0.0, 1.2, 3.1f64] {
            let expected = Rotation3::from_axis_angle(&Unit::new_normalize(AXIS), angle);
            let found = rotation(&AXIS, angle.sin(), 1.0 - angle.cos());
            assert!((found - expected.matrix()).norm() < 1e-14);
        }
    }

    #[test]
    fn the_derivative_agrees_with_central_differences_off_the_sphere() {
        let (sine, versine) = (0.8f64.sin(), 1.0 - 0.8f64.cos());
        let (axis, v) = (AXIS * 1.7, Vector3::new(0.2, -0.5, 0.9));
        let analytic = axis_derivative(&axis, sine, versine, &v);
        let step = 1e-6;
        for k in 0..3 {
            let mut offset = Vector3::zeros();
            offset[k] = step;
            let difference = (rotation(&(axis + offset), sine, versine) * v
                - rotation(&(axis - offset), sine, versine) * v)
                / (2.0 * step);
            assert!((analytic.column(k) - difference).norm() < 1e-9);
        }
    }
}
