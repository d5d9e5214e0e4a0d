//! What moves in a live view: meshes on parts whose poses the page is told anew.
//!
//! The report's pictures in three dimensions are too slow to move in a browser without a graphics card: `body.js` draws these,
//! pixel by pixel.

use nalgebra::{Isometry3, Matrix3, Vector3};
use serde_json::{Value, json};

use crate::evaluation::report::mesh::Mesh;
use crate::evaluation::report::picture;
use crate::evaluation::report::text::escape;
use crate::kinematics::Frame;

/// Numbers are told to so many parts of a metre.
const EXACT: f64 = 1e4;

/// One mesh of the picture.
pub struct Moving<'a> {
    /// What it is called.
    pub name: &'a str,
    /// Which poses move it, by the name that the page is told them under.
    pub poses: &'static str,
    /// Its corners on the parts, and its triangles.
    pub mesh: &'a Mesh,
    /// Its colour; none where each four corners are a receptor, which lights up.
    pub colour: Option<&'static str>,
}

impl Moving<'_> {
    fn described(&self) -> Value {
        let Mesh { corners, triangles } = self.mesh;
        let corners: Vec<Value> =
            corners.iter().map(|(part, p)| json!([part, rounded(p.x), rounded(p.y), rounded(p.z)])).collect();
        json!({
            "name": self.name,
            "poses": self.poses,
            "colour": self.colour,
            "corners": corners,
            "triangles": self.colour.map(|_| triangles),
        })
    }
}

/// The picture as HTML: meshes in a room between two corners, metres.
pub fn figure(
    says: &str,
    height: usize,
    meshes: &[Moving],
    room: [Vector3<f64>; 2],
    caption: &str,
) -> String {
    let described: Vec<Value> = meshes.iter().map(Moving::described).collect();
    let room = room.map(|corner| corner.as_slice().to_vec());
    let described = picture::harmless(&json!({ "meshes": described, "room": room }).to_string());
    format!(
        "<figure>\n<canvas id=\"body\" role=\"img\" aria-label=\"{}\" style=\"height:{height}px\"></canvas>\n\
         <script type=\"application/json\" id=\"moving\">{described}</script>\n\
         <figcaption>{caption}</figcaption>\n</figure>\n",
        escape(says)
    )
}

/// Poses as the page takes them: of each part its rotation, row by row, and its origin.
pub fn poses<'a>(frames: impl IntoIterator<Item = &'a Frame>) -> Value {
    let of = |frame: &Frame| -> Vec<f64> {
        frame.rotation.transpose().iter().chain(frame.origin.iter()).map(|x| rounded(*x)).collect()
    };
    frames.into_iter().map(of).collect::<Vec<_>>().into()
}

/// A pose as a frame.
pub fn frame(pose: &Isometry3<f64>) -> Frame {
    let rotation: Matrix3<f64> = *pose.rotation.to_rotation_matrix().matrix();
    Frame { rotation, origin: pose.translation.vector }
}

fn rounded(x: f64) -> f64 {
    (x * EXACT).round() / EXACT
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn poses_are_told_row_by_row() {
        let turn = nalgebra::UnitQuaternion::from_axis_angle(&Vector3::z_axis(), std::f64::consts::FRAC_PI_2);
        let told = poses(&[frame(&Isometry3::from_parts(Vector3::new(1.0, 2.0, 3.0).into(), turn))]);
        assert_eq!(told, json!([[0.0, -1.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 1.0, 2.0, 3.0]]));
    }
}
