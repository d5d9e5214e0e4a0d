//! What a body looks like: what pictures are drawn of. Nothing is learned from it.

use nalgebra::{Isometry3, Vector3};

use super::Body;
use crate::geometry::{ConvexOutline, Frame, Shape};

/// The groups of geoms that MuJoCo's viewers show unless they are asked for others.
const SHOWN_GROUPS: std::ops::RangeInclusive<i32> = 0..=2;
/// What is less opaque than this is not to be seen.
const LEAST_OPACITY: f32 = 0.2;
/// What MuJoCo paints geoms that nobody gave a colour.
const UNPAINTED: [f32; 4] = [0.5, 0.5, 0.5, 1.0];

/// The geoms of a body that MuJoCo's viewers show, as they are in its limbs' frames.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Appearance {
    /// The geoms, in the model's order.
    pub parts: Vec<VisiblePart>,
}

/// A geom that is to be seen.
#[derive(Clone, Debug, PartialEq)]
pub struct VisiblePart {
    /// The limb that it is on.
    pub limb: usize,
    /// `X_LG`, the geom in the limb's frame.
    pub pose: Frame,
    /// Its outline; of a mesh without a hull the convex one about its corners.
    pub outline: ConvexOutline,
    /// Red, green and blue, 0 to 1; none of what nobody painted.
    pub rgb: Option<[f32; 3]>,
}

impl Appearance {
    /// The one of a body.
    pub fn of(body: &Body) -> Appearance {
        let model = &body.model;
        let part = |geom: usize| {
            let (info, rgba) = (model.geom(geom), model.geom_rgba(geom));
            let limb = body.limb_of_geom(geom)?;
            if !SHOWN_GROUPS.contains(&info.group) || rgba[3] < LEAST_OPACITY || model.is_aura(geom) {
                return None;
            }
            let pose = body.pose_in_limb[info.body] * Isometry3::from_parts(info.pos.into(), info.quat);
            let outline = match Shape::of_geom(model, geom)? {
                Shape::Mesh => ConvexOutline::about(model.mesh_vertices(geom))?,
                shape => ConvexOutline::of(shape)?,
            };
            let rgb = (rgba != UNPAINTED).then_some([rgba[0], rgba[1], rgba[2]]);
            Some(VisiblePart { limb, pose: Frame::from(pose), outline, rgb })
        };
        Appearance { parts: (0..model.ngeom()).filter_map(part).collect() }
    }
}

impl VisiblePart {
    /// Its farthest point in a direction of any length, told in the geom's axes; the point in the limb's frame, metres.
    pub fn support(&self, direction: &Vector3<f64>) -> Vector3<f64> {
        self.pose.point(&self.outline.support(direction))
    }
}
