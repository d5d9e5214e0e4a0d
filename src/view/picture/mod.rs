//! Pictures and films of bodies: what MuJoCo's renderer is to draw, from where, and into which file.
//!
//! A [`Shot`] is what one picture shows, a [`Storyboard`] a sequence of them, and [`frame`] finds a camera that holds it all.
//! [`png()`] and [`Film`] make files of it.

mod figure;
mod film;
mod framing;
mod storyboard;

use crate::error::Result;
use crate::mujoco::{Camera, GeomCopy, Image, Mark, Renderer, View};

pub use film::{Film, is_film, png};
pub use framing::{Direction, frame, outline, outline_of};
pub use storyboard::{SessionDrawing, Storyboard};

/// A body that another is drawn over.
const SHADE: [f32; 4] = [0.45, 0.5, 0.55, 0.16];
/// How strongly lit marks shine through what hides them.
const THROUGH: f32 = 0.55;

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

/// Draws a shot. Geoms that are `shaded` are drawn as a mere shade.
///
/// # Errors
/// As [`Renderer::render`].
pub fn draw(
    renderer: &mut Renderer,
    shot: &Shot,
    camera: Camera,
    shaded: &dyn Fn(usize) -> bool,
) -> Result<Image> {
    let repaint = |geom: usize| shaded(geom).then_some(SHADE);
    let view = View {
        camera,
        marks: &shot.lit,
        marks_alone: false,
        repaint: &repaint,
        copies: &shot.copies,
        caption: &shot.caption,
    };
    let mut image = renderer.render(&shot.qpos, &view)?;
    if shot.lit.is_empty() {
        return Ok(image);
    }
    let lit = renderer.render(&shot.qpos, &View { marks_alone: true, copies: &[], caption: "", ..view })?;
    for (pixel, lit) in image.rgb.chunks_exact_mut(3).zip(lit.rgb.chunks_exact(3)) {
        // What is lit has no blue, and all else is white.
        let share = THROUGH * (1.0 - f32::from(lit[2]) / 255.0);
        for (seen, lit) in pixel.iter_mut().zip(lit) {
            *seen = (f32::from(*seen) * (1.0 - share) + f32::from(*lit) * share).round() as u8;
        }
    }
    Ok(image)
}
