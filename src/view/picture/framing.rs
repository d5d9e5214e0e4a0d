//! A camera that holds all that is to be seen.

use nalgebra::{Isometry3, Point3, Vector3};

use crate::geometry::{Shape, box_about};
use crate::mujoco::{Camera, Data, GeomKind, Model};

/// The part of a picture's width and height that is left free about what it shows.
const MARGIN: f64 = 0.06;
/// What is so many times as long as wide and high lies along.
const LONG: f64 = 2.0;
/// Least distance of a camera, metres: where there is nothing, there is nothing to be filled.
const NEAREST: f64 = 0.05;

/// The direction in which an eye looks.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Direction {
    /// About the world's z from x, radians.
    pub azimuth: f64,
    /// Upwards, radians; below zero it looks down.
    pub elevation: f64,
}

impl Default for Direction {
    /// From ahead, the left and above of what faces along x.
    fn default() -> Direction {
        Direction { azimuth: 205.0_f64.to_radians(), elevation: (-12.0_f64).to_radians() }
    }
}

impl Direction {
    /// The direction from which points are seen that nobody told: the usual one, or more from the side and above where they lie
    /// along x, as a snake does, which from ahead is a ball.
    pub fn suiting(points: &[Point3<f64>]) -> Direction {
        let sides = extent(points);
        if sides.x > LONG * sides.y.max(sides.z) {
            return Direction { azimuth: 245.0_f64.to_radians(), elevation: (-20.0_f64).to_radians() };
        }
        Direction::default()
    }

    /// Ahead, to the right and up, as the eye has them, in the world.
    fn axes(&self) -> [Vector3<f64>; 3] {
        let (sin, cos) = self.azimuth.sin_cos();
        let (rise, level) = self.elevation.sin_cos();
        let ahead = Vector3::new(level * cos, level * sin, rise);
        let right = Vector3::new(sin, -cos, 0.0);
        [ahead, right, right.cross(&ahead)]
    }
}

/// A free camera that looks in a direction and holds some points with little to spare, through a lens of a height, an
/// angle in radians, and a width by height; as far away as it is told, where it is.
pub fn frame(
    points: impl IntoIterator<Item = Point3<f64>>,
    direction: Direction,
    lens: (f64, f64),
    distance: Option<f64>,
) -> Camera {
    let [ahead, right, up] = direction.axes();
    let half = (lens.0 / 2.0).tan() * (1.0 - 2.0 * MARGIN);
    let half = [half * lens.1, half];
    // Of both ways across the picture, how far the eye must be back for the points on either side.
    let mut back = [[f64::NEG_INFINITY; 2]; 2];
    let mut depths = [f64::INFINITY, f64::NEG_INFINITY];
    for point in points {
        let depth = point.coords.dot(&ahead);
        depths = [depths[0].min(depth), depths[1].max(depth)];
        for ((sides, half), across) in back.iter_mut().zip(half).zip([right, up]) {
            let away = point.coords.dot(&across) / half;
            *sides = [sides[0].max(away - depth), sides[1].max(-away - depth)];
        }
    }
    let (mut lookat, mut needed) = (Point3::origin(), 1.0);
    if depths[0].is_finite() {
        let middle = 0.5 * (depths[0] + depths[1]);
        let farthest = back.iter().map(|[a, b]| 0.5 * (a + b)).fold(f64::NEG_INFINITY, f64::max);
        let [x, y] = [0, 1].map(|k| 0.5 * (back[k][0] - back[k][1]) * half[k]);
        lookat = Point3::from(ahead * middle + right * x + up * y);
        needed = (farthest + middle).max(NEAREST);
    }
    let Direction { azimuth, elevation } = direction;
    Camera::Free { lookat, distance: distance.unwrap_or(needed), azimuth, elevation }
}

/// The sides of the box along the world's axes about some points, metres; 0 where there are none.
pub(super) fn extent(points: &[Point3<f64>]) -> Vector3<f64> {
    let corners = box_about(points.iter().map(|point| point.coords));
    corners.map_or(Vector3::zeros(), |[low, high]| high - low)
}

/// Points about all geoms of a model that are `shown` and end somewhere, auras left out, given data with poses computed.
pub fn outline(data: &Data, shown: &dyn Fn(usize) -> bool) -> Vec<Point3<f64>> {
    let model: &Model = data.model();
    let seen = (0..model.ngeom()).filter(|&geom| shown(geom) && !model.is_aura(geom));
    seen.flat_map(|geom| outline_of(model, geom, &data.geom_pose(geom))).collect()
}

/// Points about a geom of a model at `X_WG`; none of one that has no end.
pub fn outline_of(model: &Model, geom: usize, pose: &Isometry3<f64>) -> Vec<Point3<f64>> {
    let info = model.geom(geom);
    match info.kind {
        GeomKind::Mesh => model.mesh_vertices(geom).into_iter().map(|p| pose * Point3::from(p)).collect(),
        kind if Shape::is_of_kind(kind) => {
            // The corners of the box about it.
            let half: [f64; 3] =
                Shape::primitive(kind, info.size).map_or(info.size, |shape| shape.half_bounds().into());
            let side = |corner: usize, k: usize| if corner >> k & 1 == 0 { half[k] } else { -half[k] };
            (0..8).map(|corner| pose * Point3::from([0, 1, 2].map(|k| side(corner, k)))).collect()
        }
        _ => Vec::new(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Where a camera sees a point: across and up, 1 at the edges of the picture.
    fn seen(camera: &Camera, lens: (f64, f64), point: &Point3<f64>) -> [f64; 2] {
        let Camera::Free { lookat, distance, azimuth, elevation } = *camera else { panic!("{camera:?}") };
        let [ahead, right, up] = Direction { azimuth, elevation }.axes();
        let from_eye = point - (lookat - ahead * distance);
        let half = (lens.0 / 2.0).tan();
        let depth = from_eye.dot(&ahead);
        assert!(depth > 0.0);
        [from_eye.dot(&right) / depth / half / lens.1, from_eye.dot(&up) / depth / half]
    }

    #[test]
    fn a_camera_holds_all_points_and_fills_the_picture() {
        let tall = [[0.1, 0.2, 0.0], [0.0, -0.3, 1.8], [0.4, 0.3, 0.9], [-0.2, 0.0, 0.1]];
        let wide = [[0.1, -2.0, 0.0], [0.0, 1.0, 0.1], [3.0, 0.3, 0.2]];
        for points in [&tall[..], &wide[..]] {
            let points: Vec<Point3<f64>> = points.iter().map(|p| Point3::from(*p)).collect();
            for lens in [(0.785, 16.0 / 9.0), (0.5, 0.6)] {
                for (azimuth, elevation) in [(0.0, 0.0), (3.5, -0.2), (1.2, -1.4), (-2.0, 0.7)] {
                    let camera = frame(points.iter().copied(), Direction { azimuth, elevation }, lens, None);
                    let places: Vec<[f64; 2]> = points.iter().map(|p| seen(&camera, lens, p)).collect();
                    let far = places.iter().flatten().fold(0.0, |far: f64, x| far.max(x.abs()));
                    assert!((far - (1.0 - 2.0 * MARGIN)).abs() < 1e-9, "{far}, {camera:?}");
                }
            }
        }
    }

    #[test]
    fn what_lies_along_is_seen_from_the_side() {
        let points = |sides: [f64; 3]| [Point3::origin(), Point3::from(sides)];
        assert_eq!(Direction::suiting(&points([0.5, 0.6, 1.8])), Direction::default());
        assert_eq!(Direction::suiting(&[]), Direction::default());
        assert_ne!(Direction::suiting(&points([2.0, 0.3, 0.2])), Direction::default());
    }

    #[test]
    fn where_there_is_nothing_a_camera_looks_at_the_origin() {
        let camera = frame([], Direction::default(), (0.8, 1.0), None);
        assert!(matches!(camera, Camera::Free { lookat, .. } if lookat == Point3::origin()), "{camera:?}");
    }
}
