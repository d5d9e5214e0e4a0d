//! The appearance of a body, for pictures only. Nothing is learned from it.

use nalgebra::Vector3;

use super::Body;
use crate::geometry::{ConvexOutline, Frame, Shape};

/// What is less opaque than this is not to be seen.
const LEAST_OPACITY: f32 = 0.2;

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
            let is_clear = rgba.is_some_and(|rgba| rgba[3] < LEAST_OPACITY);
            if !info.is_shown() || is_clear || model.is_aura(geom) {
                return None;
            }
            let pose = body.geom_in_limb(&info);
            let outline = match Shape::of_geom(model, geom)? {
                Shape::Mesh => ConvexOutline::about(&model.mesh_vertices(geom))?,
                shape => ConvexOutline::of(shape)?,
            };
            let rgb = rgba.map(|[red, green, blue, _]| [red, green, blue]);
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
