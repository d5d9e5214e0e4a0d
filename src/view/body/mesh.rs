//! The triangles of a body: of the surfaces of its limbs, of its receptors, of the things about it.

use std::collections::BTreeMap;

use nalgebra::Vector3;

use crate::creature::{Appearance, VisiblePart};
use crate::skin::{Receptor, Skin, Surface};

/// A round shape. The equator is cut on both sides: a capsule is straight between the two.
const GLOBE: Topology = Topology::Globe(&[-1.05, -0.5, -0.0, 0.0, 0.5, 1.05], 14);
/// The outline of a mesh, whose corners are anywhere.
const OUTLINE: Topology =
    Topology::Globe(&[-1.3, -1.0, -0.7, -0.42, -0.18, 0.0, 0.18, 0.42, 0.7, 1.0, 1.3], 24);
/// One of very many round shapes, each of which is a few pixels wide.
const BEAD: Topology = Topology::Globe(&[-0.0, 0.0], 8);
/// Bodies of more surfaces than this are drawn by those.
const MANY_SURFACES: usize = 300;
/// Receptors of more than these are drawn flat.
const MANY_RECEPTORS: usize = 3000;
/// How high above the skin a receptor is drawn, metres: it would be half in it otherwise.
const LIFT: f64 = 0.0025;
/// How much of a receptor is drawn along each side: neighbours would run into each other otherwise.
const DRAWN: f64 = 0.86;
/// Corners along each side of a receptor, and of one of very many.
const ALONG: usize = 5;
const FEW_ALONG: usize = 2;

/// How the corners of a piece are joined by triangles.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Topology {
    /// A round shape, whose neighbouring triangles share their light: the angles of latitude at which it is cut, radians, and the
    /// corners of each cut.
    Globe(&'static [f64], usize),
    /// Six flat sides.
    Cuboid,
    /// A patch of skin, seen from its front alone, with so many corners along each side.
    Patch(usize),
}

impl Topology {
    /// Directions to the corners of a convex piece, and triangles of three corners each, counterclockwise as seen from outside.
    fn shape(self) -> (Vec<Vector3<f64>>, Vec<[usize; 3]>) {
        match self {
            Topology::Globe(latitudes, around) => globe(latitudes, around),
            Topology::Cuboid => cuboid(),
            Topology::Patch(along) => (Vec::new(), patch(along)),
        }
    }

    /// The triangles alone.
    pub fn triangles(self) -> Vec<[usize; 3]> {
        self.shape().1
    }
}

/// A piece of a body that moves as one: of a limb, the surface of a geom or a receptor.
#[derive(Clone, Debug)]
pub struct Piece {
    /// The limb it is on.
    pub limb: usize,
    /// How its corners are joined.
    pub topology: Topology,
    /// `p_L` of every corner, metres.
    pub corners: Vec<Vector3<f64>>,
}

/// The triangles of a body on its limbs, in whatever posture these are.
pub type BodyMesh = Vec<Piece>;

/// The surfaces of a skin.
pub fn mesh_of_surfaces(skin: &Skin) -> BodyMesh {
    let round = if skin.surfaces.len() > MANY_SURFACES { BEAD } else { GLOBE };
    let piece = |surface: &Surface| {
        let topology = if surface.shape.is_box() { Topology::Cuboid } else { round };
        convex_piece(surface.limb, topology, |direction| {
            Some(surface.rotation * surface.shape.support(direction)? + surface.origin)
        })
    };
    skin.surfaces.iter().filter_map(piece).collect()
}

/// What is to be seen of a body, a piece each.
pub fn mesh_of_appearance(appearance: &Appearance) -> BodyMesh {
    let many = appearance.parts.len() > MANY_SURFACES;
    let piece = |part: &VisiblePart| {
        let topology = match &part.outline {
            outline if outline.is_box() => Topology::Cuboid,
            _ if many => BEAD,
            outline if outline.is_shape() => GLOBE,
            _ => OUTLINE,
        };
        convex_piece(part.limb, topology, |direction| Some(part.support(direction)))
    };
    appearance.parts.iter().filter_map(piece).collect()
}

/// The patches of receptors, a piece each. What is flat for the sense of touch is drawn as it lies on the limb.
pub fn mesh_of_receptors(skin: &Skin) -> BodyMesh {
    let mut surfaces: BTreeMap<usize, Vec<&Surface>> = BTreeMap::new();
    skin.surfaces.iter().for_each(|surface| surfaces.entry(surface.limb).or_default().push(surface));
    let along = if skin.receptors.len() > MANY_RECEPTORS { FEW_ALONG } else { ALONG };
    let piece = |receptor: &Receptor| {
        let [u, v] = receptor.half_extents.map(|half| DRAWN * half);
        let surfaces = surfaces.get(&receptor.limb).map_or(&[][..], Vec::as_slice);
        let at = |k: usize| 2.0 * k as f64 / (along - 1) as f64 - 1.0;
        let corner = |k: usize| {
            let (a, b) = (at(k % along), at(k / along));
            let flat = receptor.position + receptor.tangent * (a * u) + receptor.bitangent() * (b * v);
            on_the_limb(flat, &receptor.normal, surfaces)
        };
        let corners = (0..along * along).map(corner).collect();
        Piece { limb: receptor.limb, topology: Topology::Patch(along), corners }
    };
    skin.receptors.iter().map(piece).collect()
}

/// A convex piece, by its farthest point in each direction; `None` of a mesh without a hull.
fn convex_piece(
    limb: usize,
    topology: Topology,
    farthest: impl Fn(&Vector3<f64>) -> Option<Vector3<f64>>,
) -> Option<Piece> {
    // The farthest points in all directions are a convex shape's surface.
    let corners = topology.shape().0.iter().map(farthest).collect::<Option<Vec<_>>>()?;
    Some(Piece { limb, topology, corners })
}

/// A point of a receptor, just above the surface of its limb; above the receptor itself where no surface is known.
fn on_the_limb(flat: Vector3<f64>, normal: &Vector3<f64>, surfaces: &[&Surface]) -> Vector3<f64> {
    let nearest = surfaces
        .iter()
        .filter_map(|surface| surface.signed_distance(&flat))
        .filter(|(distance, _)| distance.is_finite())
        .min_by(|a, b| a.0.total_cmp(&b.0));
    match nearest {
        Some((distance, out)) => flat + out * (LIFT - distance),
        None => flat + normal * LIFT,
    }
}

/// The faces of a patch, whose corners are told row by row, so many in each.
fn patch(along: usize) -> Vec<[usize; 3]> {
    let cells = (0..along - 1).flat_map(|v| (0..along - 1).map(move |u| u + along * v));
    cells.flat_map(|a| [[a, a + 1, a + along + 1], [a, a + along + 1, a + along]]).collect()
}

/// Directions to the corners of a cuboid, and its faces.
fn cuboid() -> (Vec<Vector3<f64>>, Vec<[usize; 3]>) {
    let sign = |corner: usize, k: usize| if corner >> k & 1 == 0 { -1.0 } else { 1.0 };
    let corners = (0..8).map(|corner| Vector3::from_fn(|k, _| sign(corner, k))).collect();
    let faces = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    (corners, faces.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect())
}

/// Directions to the corners of a globe, from the south pole upwards, and its faces.
fn globe(latitudes: &[f64], around: usize) -> (Vec<Vector3<f64>>, Vec<[usize; 3]>) {
    let mut corners = vec![-Vector3::z()];
    for &latitude in latitudes {
        for k in 0..around {
            let longitude = std::f64::consts::TAU * k as f64 / around as f64;
            let (across, up) = (latitude.cos(), latitude.sin());
            corners.push(Vector3::new(across * longitude.cos(), across * longitude.sin(), up));
        }
    }
    corners.push(Vector3::z());
    let north = corners.len() - 1;
    let at = |ring: usize, k: usize| 1 + ring * around + k % around;
    let mut triangles = Vec::new();
    for k in 0..around {
        triangles.push([0, at(0, k + 1), at(0, k)]);
        for ring in 1..latitudes.len() {
            let [a, b, c, d] = [at(ring - 1, k), at(ring - 1, k + 1), at(ring, k + 1), at(ring, k)];
            triangles.extend([[a, b, c], [a, c, d]]);
        }
        triangles.push([at(latitudes.len() - 1, k), at(latitudes.len() - 1, k + 1), north]);
    }
    (corners, triangles)
}

#[cfg(test)]
mod tests {
    use nalgebra::Matrix3;

    use super::*;
    use crate::geometry::Shape;

    /// The volume that triangles close, positive where they go round counterclockwise as seen from outside.
    fn volume(mesh: &[Piece]) -> f64 {
        let of = |piece: &Piece| -> f64 {
            let corner = |k: usize| piece.corners[k];
            let triangles = piece.topology.triangles();
            triangles.iter().map(|&[a, b, c]| corner(a).cross(&corner(b)).dot(&corner(c)) / 6.0).sum()
        };
        mesh.iter().map(of).sum()
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
            let many = vec![surface.clone(); MANY_SURFACES + 1];
            let mesh = mesh_of_surfaces(&Skin { receptors: Vec::new(), surfaces: vec![surface] });
            let share = volume(&mesh) / exact;
            assert!((0.85..1.0 + 1e-9).contains(&share), "{shape:?}: {share}");
            // Each of very many is drawn by fewer corners, and closed, too.
            let coarse = mesh_of_surfaces(&Skin { receptors: Vec::new(), surfaces: many });
            let share = volume(&coarse) / exact / coarse.len() as f64;
            assert!((0.4..1.0 + 1e-9).contains(&share), "{shape:?}: {share}");
            assert!(coarse[0].corners.len() <= 18);
        }
    }
}
