//! What moves in a live view: meshes on parts whose poses the page is told anew.

use nalgebra::{Isometry3, Matrix3, Vector3};
use plotly::common::{ColorScale, ColorScaleElement, HoverInfo};
use plotly::layout::{AspectMode, Axis, Camera, DragMode3D, LayoutScene, Margin};
use plotly::mesh3d::Lighting;
use plotly::{Mesh3D, Trace};
use serde_json::{Value, json};

use crate::evaluation::report::mesh::Mesh;
use crate::evaluation::report::picture;
use crate::kinematics::Frame;

/// Receptors from untouched to touched just now.
const GLOW: [(f64, &str); 4] = [(0.0, "#93a1ad"), (0.35, "#f6d573"), (0.7, "#f28e3c"), (1.0, "#d7301f")];
/// Numbers are told to this many digits after the point: a tenth of a millimetre.
const DIGITS: f64 = 1e4;
/// Where it is looked at from, with x ahead, y to the left and z up.
const VIEW: [f64; 3] = [1.25, 0.55, 0.45];

/// One mesh of the picture.
pub struct Moving<'a> {
    /// What it is called.
    pub name: String,
    /// Which poses move it, by the name that the page is told them under.
    pub poses: &'static str,
    /// Its corners on the parts, and its triangles.
    pub mesh: &'a Mesh,
    /// Whether each four corners are a receptor, which lights up.
    pub receptors: bool,
    /// Its colour.
    pub colour: &'static str,
    /// How opaque it is.
    pub opacity: f64,
}

impl Moving<'_> {
    fn trace(&self, at: &[Frame]) -> Box<dyn Trace> {
        let places: Vec<Vector3<f64>> =
            self.mesh.corners.iter().map(|(part, p)| at.get(*part).map_or(*p, |frame| frame.point(p))).collect();
        let axis = |k: usize| places.iter().map(|p| rounded(p[k])).collect::<Vec<f64>>();
        let corner = |k: usize| Some(self.mesh.triangles.iter().map(|t| t[k]).collect());
        let trace = Mesh3D::new(axis(0), axis(1), axis(2), corner(0), corner(1), corner(2))
            .name(&self.name)
            .opacity(self.opacity)
            .lighting(Lighting::new().ambient(0.8).diffuse(0.4).specular(0.03).roughness(0.9).fresnel(0.05))
            .hover_info(HoverInfo::None)
            .show_scale(false)
            .show_legend(true);
        if !self.receptors {
            return trace.color(self.colour);
        }
        let scale = GLOW.iter().map(|(at, colour)| ColorScaleElement(*at, colour.to_string())).collect();
        trace
            .flat_shading(true)
            .intensity(vec![0.0; places.len()])
            .c_min(0.0)
            .c_max(1.0)
            .color_scale(ColorScale::Vector(scale))
    }

    fn described(&self) -> Value {
        let corners: Vec<Value> = self
            .mesh
            .corners
            .iter()
            .map(|(part, p)| json!([part, rounded(p.x), rounded(p.y), rounded(p.z)]))
            .collect();
        json!({ "poses": self.poses, "receptors": self.receptors, "corners": corners })
    }
}

/// The picture as HTML: meshes, each with the poses of its parts at first, in a room between two corners, metres.
pub fn figure(
    says: &str,
    height: usize,
    meshes: &[(Moving, &[Frame])],
    room: [Vector3<f64>; 2],
    caption: &str,
) -> String {
    let traces = meshes.iter().map(|(moving, at)| moving.trace(at)).collect();
    let axis = |k: usize| Axis::new().visible(false).show_spikes(false).range(vec![room[0][k], room[1][k]]);
    let scene = LayoutScene::new()
        .x_axis(axis(0))
        .y_axis(axis(1))
        .z_axis(axis(2))
        .aspect_mode(AspectMode::Data)
        .drag_mode(DragMode3D::Orbit)
        .camera(Camera::new().eye((VIEW[0], VIEW[1], VIEW[2]).into()));
    let layout = picture::layout().scene(scene).margin(Margin::new().left(0).right(0).top(8).bottom(4));
    let described: Vec<Value> = meshes.iter().map(|(moving, _)| moving.described()).collect();
    let described = picture::harmless(&json!(described).to_string());
    format!(
        "{}<script type=\"application/json\" id=\"moving\">{described}</script>\n",
        picture::figure("body", says, height, traces, layout, caption)
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
    (x * DIGITS).round() / DIGITS
}
