//! Segments in space.

use nalgebra::Vector3;

/// The closest points of two segments, one on each (Ericson, "Real-Time Collision Detection", section 5.1.9).
pub fn closest_points(a: &[Vector3<f64>; 2], b: &[Vector3<f64>; 2]) -> [Vector3<f64>; 2] {
    const SHORT: f64 = 1e-18;
    let (along_a, along_b, between) = (a[1] - a[0], b[1] - b[0], a[0] - b[0]);
    let (aa, bb) = (along_a.norm_squared(), along_b.norm_squared());
    let (ab, fb) = (along_a.dot(&along_b), along_b.dot(&between));
    let ca = along_a.dot(&between);
    let (s, t) = if aa <= SHORT && bb <= SHORT {
        (0.0, 0.0)
    } else if aa <= SHORT {
        (0.0, (fb / bb).clamp(0.0, 1.0))
    } else if bb <= SHORT {
        ((-ca / aa).clamp(0.0, 1.0), 0.0)
    } else {
        let denominator = aa * bb - ab * ab;
        let s = if denominator > 1e-12 * aa * bb {
            ((ab * fb - ca * bb) / denominator).clamp(0.0, 1.0)
        } else {
            0.0
        };
        let t = (ab * s + fb) / bb;
        if t < 0.0 {
            ((-ca / aa).clamp(0.0, 1.0), 0.0)
        } else if t > 1.0 {
            (((ab - ca) / aa).clamp(0.0, 1.0), 1.0)
        } else {
            (s, t)
        }
    };
    [a[0] + along_a * s, b[0] + along_b * t]
}
