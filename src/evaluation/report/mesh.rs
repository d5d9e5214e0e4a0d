//! Surfaces of the skin as triangles, for a picture.

use nalgebra::Vector3;

use crate::skin::{Receptor, Shape, Skin};

/// Angles of latitude at which a round shape is cut, radians. The equator is cut on both sides: a capsule is
/// straight between the two.
const LATITUDES: [f64; 4] = [-0.75, -0.0, 0.0, 0.75];
/// Corners of each cut.
const AROUND: usize = 10;
/// How high above the skin a receptor is drawn, metres: it would be half in it otherwise.
const LIFT: f64 = 0.0015;
/// How much of a receptor is drawn along each side: neighbours would run into each other otherwise.
const DRAWN: f64 = 0.86;

/// Triangles on limbs.
#[derive(Clone, Debug, Default)]
pub(crate) struct Mesh {
    /// Per corner its limb and `p_L`, its place in that limb's frame, metres.
    pub corners: Vec<(usize, Vector3<f64>)>,
    /// Three corners each.
    pub triangles: Vec<[usize; 3]>,
}

impl Mesh {
    /// The surfaces of a skin.
    pub fn of_surfaces(skin: &Skin) -> Mesh {
        let mut mesh = Mesh::default();
        for surface in &skin.surfaces {
            let (directions, triangles) = match surface.shape {
                Shape::Box { .. } => cube(),
                _ => globe(),
            };
            // The farthest points in all directions are a convex shape's surface.
            let support = |direction: &Vector3<f64>| surface.shape.support(direction);
            let Some(points) = directions.iter().map(support).collect::<Option<Vec<_>>>() else { continue };
            let to_limb = |p: Vector3<f64>| (surface.limb, surface.rotation * p + surface.origin);
            mesh.push(points.into_iter().map(to_limb), &triangles);
        }
        mesh
    }

    /// The patches of receptors, four corners each.
    pub fn of_receptors(receptors: &[Receptor]) -> Mesh {
        let mut mesh = Mesh::default();
        for receptor in receptors {
            let [u, v] = receptor.half_extents.map(|half| DRAWN * half);
            let middle = receptor.position + receptor.normal * LIFT;
            let corner = |a: f64, b: f64| {
                (receptor.limb, middle + receptor.tangent * (a * u) + receptor.bitangent() * (b * v))
            };
            let corners = [corner(-1.0, -1.0), corner(1.0, -1.0), corner(1.0, 1.0), corner(-1.0, 1.0)];
            mesh.push(corners, &[[0, 1, 2], [0, 2, 3]]);
        }
        mesh
    }

    fn push(&mut self, corners: impl IntoIterator<Item = (usize, Vector3<f64>)>, triangles: &[[usize; 3]]) {
        let first = self.corners.len();
        self.corners.extend(corners);
        self.triangles.extend(triangles.iter().map(|triangle| triangle.map(|corner| first + corner)));
    }
}

/// Directions to the corners of a cube, and its faces.
fn cube() -> (Vec<Vector3<f64>>, Vec<[usize; 3]>) {
    let sign = |corner: usize, k: usize| if corner >> k & 1 == 0 { -1.0 } else { 1.0 };
    let corners = (0..8).map(|corner| Vector3::from_fn(|k, _| sign(corner, k))).collect();
    let faces = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    (corners, faces.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect())
}

/// Directions to the corners of a globe, from the south pole upwards, and its faces.
fn globe() -> (Vec<Vector3<f64>>, Vec<[usize; 3]>) {
    let mut corners = vec![-Vector3::z()];
    for latitude in LATITUDES {
        for k in 0..AROUND {
            let longitude = std::f64::consts::TAU * k as f64 / AROUND as f64;
            let (across, up) = (latitude.cos(), latitude.sin());
            corners.push(Vector3::new(across * longitude.cos(), across * longitude.sin(), up));
        }
    }
    corners.push(Vector3::z());
    let north = corners.len() - 1;
    let at = |ring: usize, k: usize| 1 + ring * AROUND + k % AROUND;
    let mut triangles = Vec::new();
    for k in 0..AROUND {
        triangles.push([0, at(0, k + 1), at(0, k)]);
        for ring in 1..LATITUDES.len() {
            let [a, b, c, d] = [at(ring - 1, k), at(ring - 1, k + 1), at(ring, k + 1), at(ring, k)];
            triangles.extend([[a, b, c], [a, c, d]]);
        }
        triangles.push([at(LATITUDES.len() - 1, k), at(LATITUDES.len() - 1, k + 1), north]);
    }
    (corners, triangles)
}

#[cfg(test)]
mod tests {
    use nalgebra::Matrix3;

    use super::*;
    use crate::skin::Surface;

    /// The volume that triangles close, positive where they go round counterclockwise as seen from outside.
    fn volume(mesh: &Mesh) -> f64 {
        let corner = |k: usize| mesh.corners[k].1;
        mesh.triangles.iter().map(|&[a, b, c]| corner(a).cross(&corner(b)).dot(&corner(c)) / 6.0).sum()
    }

    #[test]
    fn shapes_become_closed_meshes_of_nearly_their_volume() {
        use std::f64::consts::PI;
        let shapes = [
            (Shape::Sphere { radius: 0.2 }, 4.0 / 3.0 * PI * 0.008),
            (Shape::Capsule { radius: 0.1, half_length: 0.3 }, PI * 0.01 * (0.6 + 0.4 / 3.0)),
            (Shape::Cylinder { radius: 0.1, half_length: 0.3 }, PI * 0.01 * 0.6),
            (Shape::Ellipsoid { semi_axes: [0.3, 0.2, 0.1] }, 4.0 / 3.0 * PI * 0.006),
            (Shape::Box { half_extents: [0.1, 0.2, 0.3] }, 0.048),
        ];
        for (shape, exact) in shapes {
            let surface = Surface {
                limb: 0,
                origin: Vector3::new(0.1, 0.2, 0.3),
                rotation: Matrix3::identity(),
                shape: shape.clone(),
                geom: 0,
            };
            let mesh = Mesh::of_surfaces(&Skin { receptors: Vec::new(), surfaces: vec![surface] });
            let share = volume(&mesh) / exact;
            assert!((0.7..1.0 + 1e-9).contains(&share), "{shape:?}: {share}");
        }
    }
}
