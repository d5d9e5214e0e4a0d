//! Pictures and films of bodies: what MuJoCo's renderer is to draw, from where, and into which file.
//!
//! A [`Shot`] is what one picture shows, and [`frame`] finds a camera that holds it all. [`learned_body`] and [`lit_touch`]
//! make marks of what is no part of a model. [`png()`] and [`Film`] are what files hold.

mod figure;
mod film;
mod framing;
mod layers;
mod scale;
mod still;
mod storyboard;

use crate::mujoco::{self, Camera, GeomCopy, Image, Mark, Renderer, View};

pub use figure::{between, learned_body, lit_touch, skin};
pub use film::{Film, FilmError, is_film};
pub use framing::{Direction, corners_of, extent, frame, outline, outline_of};
pub use layers::{auras, map};
use scale::ScaleBar;
pub use still::png;
pub use storyboard::{SessionDrawing, Storyboard};

/// A body that another is drawn over.
const SHADE: [f32; 4] = [0.45, 0.5, 0.55, 0.16];
/// How strongly what is lit shines through what hides it.
const THROUGH: f32 = 0.55;

/// What one picture shows.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Shot {
    /// The model's coordinates: `nq` numbers, radians and metres, quaternions w x y z.
    pub qpos: Vec<f64>,
    /// What is drawn besides.
    pub marks: Vec<Mark>,
    /// What is drawn besides and shines through whatever is before it: marks without any blue.
    pub lit: Vec<Mark>,
    /// Geoms that are drawn a second time, as they look.
    pub copies: Vec<GeomCopy>,
    /// What is written below, in ASCII.
    pub caption: String,
    /// Whether a bar tells how large things are, where the camera is free.
    pub scaled: bool,
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
    let marks = [&shot.marks[..], &shot.lit].concat();
    let bar = ScaleBar::new(camera, renderer.lens(), renderer.height()).filter(|_| shot.scaled);
    let view = View {
        camera,
        marks: &marks,
        marks_alone: false,
        repaint: &repaint,
        copies: &shot.copies,
        caption: &shot.caption,
        scale: bar.as_ref().map_or("", |bar| &bar.says),
    };
    let mut image = renderer.render(&shot.qpos, &view)?;
    if let Some(bar) = &bar {
        bar.draw(&mut image, renderer.label_height());
    }
    if shot.lit.is_empty() {
        return Ok(image);
    }
    let lit = renderer.render(
        &shot.qpos,
        &View { marks: &shot.lit, marks_alone: true, copies: &[], caption: "", scale: "", ..view },
    )?;
    for (pixel, lit) in image.rgb.chunks_exact_mut(3).zip(lit.rgb.chunks_exact(3)) {
        // What is lit has no blue, and all else is white.
        let share = THROUGH * (1.0 - f32::from(lit[2]) / 255.0);
        for (seen, lit) in pixel.iter_mut().zip(lit) {
            *seen = (f32::from(*seen) * (1.0 - share) + f32::from(*lit) * share).round() as u8;
        }
    }
    Ok(image)
}
