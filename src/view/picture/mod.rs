//! Pictures and films of bodies: what MuJoCo's renderer is to draw, from where, and into which file.
//!
//! A [`Shot`] is what one picture shows, a [`Drawing`] a sequence of them of one model, with a camera that holds it all. [`png()`]
//! and [`Film`] make files of it.

mod film;
mod framing;
mod session;

use std::sync::Arc;

use nalgebra::Point3;

use crate::creature::Body;
use crate::error::Result;
use crate::mujoco::{Camera, Data, GeomCopy, Image, Mark, Model, Renderer, View};

pub use film::{Film, is_film, png};
pub use framing::Direction;
use framing::{frame, outline, outline_of};
pub use session::SessionDrawing;

/// A body that another is drawn over.
const SHADE: [f32; 4] = [0.45, 0.5, 0.55, 0.16];
/// How strongly lit marks shine through what hides them.
const THROUGH: f32 = 0.55;
/// Every so-many-th frame is enough to determine how much room a motion takes.
const HELD_EVERY: usize = 3;

/// What one picture shows.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Shot {
    /// The model's coordinates: `nq` numbers, radians and metres, quaternions w x y z.
    pub qpos: Vec<f64>,
    /// Marks that shine through whatever hides them: none of them has any blue.
    pub lit: Vec<Mark>,
    /// Geoms drawn a second time, as they look.
    pub copies: Vec<GeomCopy>,
    /// What is written below, in ASCII.
    pub caption: String,
}

/// What is drawn: a model, picture by picture.
pub struct Drawing {
    /// The model.
    pub model: Arc<Model>,
    /// The creature in it, where there is one.
    pub body: Option<Body>,
    /// Whether only the creature is to fill the picture, and not all that is about it.
    pub alone: bool,
    /// One or more, in their order.
    pub shots: Vec<Shot>,
    /// Whether the true body is but a shade that another is drawn over.
    pub shaded: bool,
}

impl Drawing {
    /// Whether a geom is the creature's.
    fn is_own(&self, geom: usize) -> bool {
        self.body.as_ref().is_some_and(|body| body.limb_of_geom(geom).is_some())
    }

    /// A camera that holds all that is shown, from a direction, or the usual one for it; as far away as it is told, where it is.
    ///
    /// # Errors
    /// If the engine fails.
    pub fn camera(
        &self,
        renderer: &Renderer,
        direction: Option<Direction>,
        distance: Option<f64>,
    ) -> Result<Camera> {
        let shown = |geom: usize| renderer.shows(geom) && (!self.alone || self.is_own(geom));
        let mut points: Vec<Point3<f64>> = Vec::new();
        let mut data = Data::new(self.model.clone())?;
        for shot in self.shots.iter().step_by(HELD_EVERY).chain(self.shots.last()) {
            data.set_qpos(&shot.qpos)?;
            data.kinematics()?;
            points.extend(outline(&data, &shown));
            let copies = shot.copies.iter().filter(|copy| shown(copy.geom));
            points.extend(copies.flat_map(|copy| outline_of(&self.model, copy.geom, &copy.pose)));
        }
        let direction = direction.unwrap_or_else(|| Direction::suiting(&points));
        Ok(frame(points, direction, renderer.lens(), distance))
    }

    /// Draws a shot.
    ///
    /// # Errors
    /// As [`Renderer::render`].
    pub fn draw(&self, renderer: &mut Renderer, shot: &Shot, camera: Camera) -> Result<Image> {
        let repaint = |geom: usize| (self.shaded && self.is_own(geom)).then_some(SHADE);
        let (marks, copies, caption) = (&shot.lit[..], &shot.copies[..], shot.caption.as_str());
        let view = View { camera, marks, marks_alone: false, repaint: &repaint, copies, caption };
        let mut image = renderer.render(&shot.qpos, &view)?;
        if shot.lit.is_empty() {
            return Ok(image);
        }
        let view = View { marks_alone: true, copies: &[], caption: "", ..view };
        let lit = renderer.render(&shot.qpos, &view)?;
        for (pixel, lit) in image.rgb.chunks_exact_mut(3).zip(lit.rgb.chunks_exact(3)) {
            // What is lit has no blue, and all else is white.
            let share = THROUGH * (1.0 - f32::from(lit[2]) / 255.0);
            for (seen, lit) in pixel.iter_mut().zip(lit) {
                *seen = (f32::from(*seen) * (1.0 - share) + f32::from(*lit) * share).round() as u8;
            }
        }
        Ok(image)
    }
}
