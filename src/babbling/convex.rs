//! How far apart two convex shapes are, at the least.

use nalgebra::{Matrix3, Vector3};

use crate::skin::Surface;

/// Most projections from one shape to the other and back.
const PROJECTIONS: usize = 12;
/// A bound this near the distance found is good enough.
const GOOD: f64 = 0.8;

/// A convex shape at a place: its surface on a limb, and the limb's rotation and origin.
pub struct Placed<'a> {
    /// The shape on its limb.
    pub surface: &'a Surface,
    /// The limb's rotation.
    pub rotation: &'a Matrix3<f64>,
    /// The limb's origin.
    pub origin: &'a Vector3<f64>,
}

impl Placed<'_> {
    /// The nearest point of the shape; the point itself where it lies inside.
    fn nearest(&self, p: &Vector3<f64>) -> Option<Vector3<f64>> {
        let p_l = self.rotation.tr_mul(&(p - self.origin));
        let (distance, normal) = self.surface.signed_distance(&p_l)?;
        Some(if distance > 0.0 { p - self.rotation * normal * distance } else { *p })
    }

    /// How far the shape reaches in a direction of length 1.
    fn reach(&self, direction: &Vector3<f64>) -> Option<f64> {
        let in_limb = self.rotation.tr_mul(direction);
        let in_shape = self.surface.rotation.tr_mul(&in_limb);
        let own = self.surface.shape.support(&in_shape)?;
        Some(own + in_limb.dot(&self.surface.origin) + direction.dot(self.origin))
    }
}

/// A lower bound of the distance between two shapes, metres, good to a fifth where a few projections find
/// it: a plane between them proves it. None where none is found, as when they overlap.
pub fn apart(a: &Placed, b: &Placed, start: Vector3<f64>) -> Option<f64> {
    let mut on_b = start;
    let mut best: Option<f64> = None;
    for _ in 0..PROJECTIONS {
        let on_a = a.nearest(&on_b)?;
        on_b = b.nearest(&on_a)?;
        let between = on_a - on_b;
        let distance = between.norm();
        let normal = between.try_normalize(1e-9)?;
        let proven = -a.reach(&-normal)? - b.reach(&normal)?;
        if proven > best.unwrap_or(0.0) {
            best = Some(proven);
        }
        if best.is_some_and(|best| best >= GOOD * distance) {
            break;
        }
    }
    best
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::skin::Shape;

    #[test]
    fn a_proven_distance_is_close_to_the_distance_and_never_above_it() {
        let shapes = [
            Shape::Sphere { radius: 0.1 },
            Shape::Capsule { radius: 0.05, half_length: 0.2 },
            Shape::Cylinder { radius: 0.1, half_length: 0.05 },
            Shape::Box { half_extents: [0.1, 0.05, 0.2] },
            Shape::Ellipsoid { semi_axes: [0.05, 0.1, 0.2] },
        ];
        let turn = |k: usize| *nalgebra::Rotation3::from_euler_angles(k as f64, 0.7 * k as f64, 0.3).matrix();
        let (still, nowhere) = (Matrix3::identity(), Vector3::zeros());
        let mut good = 0;
        let mut all = 0;
        for (i, first) in shapes.iter().enumerate() {
            for (j, second) in shapes.iter().enumerate() {
                let at = Vector3::new(0.3, 0.2, 0.25 + 0.02 * j as f64);
                let surface = |shape: &Shape, origin, k| Surface {
                    limb: 0,
                    origin,
                    rotation: turn(k),
                    shape: shape.clone(),
                    geom: 0,
                };
                let (a, b) = (surface(first, nowhere, i), surface(second, at, j + 3));
                let placed = [&a, &b].map(|surface| Placed { surface, rotation: &still, origin: &nowhere });
                let proven = apart(&placed[0], &placed[1], at).expect("they are apart");
                // Many projections end at the nearest points.
                let (mut p, mut q) = (nowhere, at);
                for _ in 0..5000 {
                    p = placed[0].nearest(&q).unwrap();
                    q = placed[1].nearest(&p).unwrap();
                }
                let distance = (p - q).norm();
                assert!(proven <= distance + 1e-9, "{first:?}, {second:?}: {proven} of {distance}");
                good += usize::from(proven > 0.7 * distance);
                all += 1;
                let same = Placed { surface: &b, rotation: &still, origin: &nowhere };
                assert_eq!(apart(&placed[1], &same, at), None, "a shape overlaps itself");
            }
        }
        assert!(good * 10 >= all * 9, "{good} of {all} bounds are good");
    }
}
