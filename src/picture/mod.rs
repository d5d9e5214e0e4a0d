//! Pictures and films of bodies: what MuJoCo's renderer is to draw, from where, and into which file.
//!
//! A [`Shot`] is what one picture shows; [`frame`] finds a camera that holds it all; [`learned_body`] and [`touching_places`] are marks of what is
//! no part of a model, as a learned body and the places of a touch; [`png`] and [`Film`] are what files hold.

mod figure;
mod film;
mod framing;
mod still;

use crate::mujoco::{self, Camera, Image, Mark, Renderer, View};

pub use figure::{between, learned_body, touching_places};
pub use film::{Film, FilmError, is_film};
pub use framing::{Direction, corners_of, extent, frame, outline};
pub use still::png;

/// What is behind a body in models without a sky.
const BACKGROUND: [f32; 3] = [0.93, 0.94, 0.95];
/// A body that another is drawn over.
const SHADE: [f32; 4] = [0.45, 0.5, 0.55, 0.16];

/// What one picture shows.
#[derive(Clone, Debug, PartialEq)]
pub struct Shot {
    /// The model's coordinates: `nq` numbers, radians and metres, quaternions w x y z.
    pub qpos: Vec<f64>,
    /// What is drawn besides.
    pub marks: Vec<Mark>,
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
) -> mujoco::Result<Image> {
    let repaint = |geom: usize| shaded(geom).then_some(SHADE);
    let view = View { camera, marks: &shot.marks, background: BACKGROUND, repaint: &repaint };
    renderer.render(&shot.qpos, &view)
}
