//! The expanding polytope algorithm: how deep two convex bodies are in each other.
//!
//! A polytope inside the bodies' difference grows about the origin until its nearest face is one of the difference's own
//! (van den Bergen, "Proximity Queries and Penetration Depth Computation on 3D Game Objects", 2001).

use nalgebra::Vector3;

use super::simplex::{Corner, on_triangle, witnesses};
use super::{Gap, Precision};
use crate::deadline::count_work;

/// How exact a depth is where no rounding is in the way, metres.
const EXACT: f64 = 1e-9;
/// … and of what is deep in each other, as a share of the depth: nobody builds on such a depth but to get out of it.
const ROUGH: f64 = 1e-3;
/// What is no deeper than this, metres, is found as exactly as it can be.
const SHALLOW: f64 = 1e-3;
/// Most support points looked for: round shapes need them.
const MOST: usize = 200;
/// How far a corner may be from a plane that it is in, metres.
const ROUNDING: f64 = 1e-13;
/// A corner nearer than this, metres, to the point, line or plane of others says nothing new.
const LOW: f64 = 1e-7;

/// What looking at a face counts as, in work of [`count_work`].
const FACE: usize = 12;

/// A face of a polytope, its corners counterclockwise as seen from outside.
struct Face {
    corners: [usize; 3],
    /// Outward unit normal.
    normal: Vector3<f64>,
    /// How far the face's plane is from the origin along it.
    offset: f64,
}

/// How deep two bodies are in each other whose difference has the origin inside, or nearly on its surface.
pub(super) fn penetration(
    support: &dyn Fn(&Vector3<f64>) -> Corner,
    simplex: &[Corner],
    precision: Precision,
) -> Gap {
    let mut corners = spanning(support, simplex);
    let face = |corners: &[Corner], at: [usize; 3]| {
        let [a, b, c] = at.map(|k| corners[k].difference);
        let normal = (b - a).cross(&(c - a)).try_normalize(f64::MIN_POSITIVE)?;
        Some(Face { corners: at, normal, offset: normal.dot(&a) })
    };
    let mut faces: Vec<Face> = Vec::new();
    if corners.len() == 4 {
        for (at, opposite) in [([0, 1, 2], 3), ([0, 1, 3], 2), ([0, 2, 3], 1), ([1, 2, 3], 0)] {
            let Some(found) = face(&corners, at) else { continue };
            let inward = found.normal.dot(&corners[opposite].difference) > found.offset;
            let turned = [at[0], at[2], at[1]];
            faces.extend(if inward { face(&corners, turned) } else { Some(found) });
        }
    }
    // The best direction so far: no other parts the bodies sooner.
    let mut best: Option<(f64, Vector3<f64>)> = None;
    let by_offset = |a: &&Face, b: &&Face| a.offset.total_cmp(&b.offset);
    for _ in 0..MOST {
        let Some(nearest) = faces.iter().min_by(by_offset) else { break };
        let corner = support(&nearest.normal);
        let depth = nearest.normal.dot(&corner.difference);
        if best.is_none_or(|(least, _)| depth < least) {
            best = Some((depth, nearest.normal));
        }
        let deep = if precision == Precision::ExactWhereShallow { depth - SHALLOW } else { 0.0 };
        if depth - nearest.offset < EXACT.max(ROUGH * deep) {
            break;
        }
        count_work(FACE * faces.len());
        // The faces that see the new corner give way to those between it and their outline.
        let number = corners.len();
        corners.push(corner);
        let mut edges: Vec<[usize; 2]> = Vec::new();
        faces.retain(|face| {
            // A face in whose plane the corner is counts as one that sees it: none of the new ones is a sliver.
            let hidden = face.normal.dot(&corner.difference) < face.offset - ROUNDING;
            if !hidden {
                let [a, b, c] = face.corners;
                for edge in [[a, b], [b, c], [c, a]] {
                    match edges.iter().position(|other| *other == [edge[1], edge[0]]) {
                        Some(twin) => drop(edges.swap_remove(twin)),
                        None => edges.push(edge),
                    }
                }
            }
            hidden
        });
        let (before, added) = (faces.len(), edges.len());
        faces.extend(edges.into_iter().filter_map(|[a, b]| face(&corners, [a, b, number])));
        // A sliver without a normal, or an outline that rounding tore (a body of so many corners has fewer faces, and torn ones
        // would multiply): what is known is as good as rounding allows.
        if faces.len() != before + added || faces.len() > 2 * corners.len() {
            break;
        }
    }
    let least = faces.iter().min_by(by_offset).map_or(0.0, |face| face.offset);
    // Of faces in one plane, the origin is above one.
    let level = faces.iter().filter(|face| face.offset <= least + EXACT).map(|face| {
        let chosen = face.corners.map(|k| corners[k]);
        (on_triangle(&chosen.map(|corner| corner.difference)), chosen)
    });
    let above = level.min_by(|a, b| a.0.point.norm_squared().total_cmp(&b.0.point.norm_squared()));
    let (Some((depth, normal)), Some((foot, chosen))) = (best, above) else {
        // Bodies without a thickness.
        return Gap { distance: 0.0, normal: Vector3::z(), points: corners[0].points };
    };
    // The difference's surface is at `normal * depth`: the first body leaves the second against the normal.
    Gap { distance: -depth, normal: -normal, points: witnesses(&chosen, &foot.weights) }
}

/// Corners that span a tetrahedron, where the bodies have a thickness: those given, and more where they do not.
fn spanning(support: &dyn Fn(&Vector3<f64>) -> Corner, given: &[Corner]) -> Vec<Corner> {
    // How far the last corner is from the point, line or plane of the others: in it, it says nothing.
    let height = |corners: &[Corner]| {
        let at = |k: usize| corners[k].difference - corners[0].difference;
        match corners.len() {
            0 | 1 => f64::INFINITY,
            2 => at(1).norm(),
            3 => at(1).cross(&at(2)).norm() / at(1).norm(),
            _ => at(1).cross(&at(2)).normalize().dot(&at(3)).abs(),
        }
    };
    let mut found: Vec<Corner> = Vec::with_capacity(4);
    let try_corner = |corner: Corner, found: &mut Vec<Corner>| {
        found.push(corner);
        if height(found) < LOW {
            found.pop();
        }
    };
    given.iter().for_each(|corner| try_corner(*corner, &mut found));
    while found.len() < 4 {
        let at = |k: usize| found[k].difference - found[0].difference;
        let directions: Vec<Vector3<f64>> = match found.len() {
            1 => vec![Vector3::x(), Vector3::y(), Vector3::z()],
            2 => {
                let along = at(1).normalize();
                let across = along.cross(&Vector3::ith(along.iamin(), 1.0)).normalize();
                vec![across, along.cross(&across)]
            }
            _ => vec![at(1).cross(&at(2)).normalize()],
        };
        let before = found.len();
        for direction in directions.iter().flat_map(|d| [*d, -d]) {
            if found.len() == before {
                try_corner(support(&direction), &mut found);
            }
        }
        if found.len() == before {
            break;
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use nalgebra::{Rotation3, Vector3};
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    use crate::geometry::{ConvexBody, Frame, PlacedShape, Precision, Shape, gap_from};

    /// Faces in one plane, or all but: rounding tears the outline of what a new corner sees, and a torn polytope would have
    /// ever more faces.
    #[test]
    fn bodies_with_faces_in_one_plane_are_parted_by_what_is_found() {
        let mut rng = ChaCha8Rng::seed_from_u64(1);
        let shapes = [
            Shape::Cylinder { radius: 0.045, half_length: 0.035 },
            Shape::Cylinder { radius: 0.013, half_length: 0.13 },
            Shape::Box { half_extents: [0.09, 0.026, 0.025] },
        ];
        for _ in 0..20_000 {
            let mut any = |values: &[f64]| values[rng.random_range(0..values.len())];
            let (tilt, lift) = (any(&[0.0, 1e-12, 1e-9, 1e-5]), any(&[0.0, 1e-12, 1e-9, 1e-5]));
            let level = any(&[0.0, 0.01, 0.06]) + lift;
            let rotation = Rotation3::from_axis_angle(&Vector3::x_axis(), tilt)
                * Rotation3::from_axis_angle(&Vector3::z_axis(), rng.random_range(0.0..6.3));
            let beside = [0, 1].map(|_| rng.random_range(-0.1..0.1));
            let at =
                Frame { rotation: *rotation.matrix(), origin: Vector3::new(beside[0], beside[1], level) };
            let [first, second] = [at, Frame::identity()].map(|frame| {
                PlacedShape::new(&shapes[rng.random_range(0..3)], frame, Frame::identity()).unwrap()
            });
            let gap = gap_from(&first, &second, Precision::ExactWhereShallow, &Vector3::z());
            // The first leaves the second by as much along the normal.
            let reach = gap.normal.dot(&(second.support(&gap.normal) - first.support(&-gap.normal)));
            assert!((reach + gap.distance).abs() < 1e-7, "{gap:?}, by the normal {reach}");
        }
    }
}
