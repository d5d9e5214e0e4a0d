//! How large things are in a picture: a bar of a round length.

use crate::mujoco::{Camera, Image};

/// The bar is no longer than this share of the picture's width.
const LONGEST: f64 = 0.2;
/// Its colour, how thick it is, and how far from the picture's right edge it ends, pixels.
const INK: u8 = 70;
const THICK: usize = 3;
const MARGIN: usize = 8;

/// A bar as it is drawn in pictures of one camera.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct ScaleBar {
    /// How long it is, in words.
    pub says: String,
    /// The same in pixels.
    pixels: usize,
}

impl ScaleBar {
    /// The bar at the distance of the point that a free camera looks at, through a lens (a height, an angle in radians, and
    /// a width by height) into a picture of so many rows; none for other cameras.
    pub fn new(camera: Camera, lens: (f64, f64), height: usize) -> Option<ScaleBar> {
        let Camera::Free { distance, .. } = camera else { return None };
        let pixels_a_metre = height as f64 / (2.0 * distance * (lens.0 / 2.0).tan());
        let longest = LONGEST * lens.1 * height as f64 / pixels_a_metre;
        if !(longest > 0.0 && longest.is_finite()) {
            return None;
        }
        let decade = 10f64.powf(longest.log10().floor());
        let metres = [5.0, 2.0, 1.0].map(|round| round * decade).into_iter().find(|&m| m <= longest)?;
        let says = match metres {
            m if m >= 0.9995 => format!("{m:.0} m"),
            m if m >= 0.0095 => format!("{:.0} cm", 1e2 * m),
            m if m >= 0.00095 => format!("{:.0} mm", 1e3 * m),
            m => format!("{m:.0e} m"),
        };
        Some(ScaleBar { says, pixels: (metres * pixels_a_metre).round() as usize })
    }

    /// Draws it into a picture, so many pixels below its upper edge.
    pub fn draw(&self, image: &mut Image, below: usize) {
        let Some(right) = image.width.checked_sub(MARGIN) else { return };
        let Some(left) = right.checked_sub(self.pixels) else { return };
        let mut ink = |x: usize, y: usize| {
            let at = 3 * (y * image.width + x);
            image.rgb[at..at + 3].fill(INK);
        };
        // A line with an end that stands up on either side.
        for y in 0..3 * THICK {
            let row = below + y;
            if row >= image.height {
                return;
            }
            let ends = (left..left + THICK).chain(right - THICK..right);
            if y >= 2 * THICK {
                (left..right).for_each(|x| ink(x, row))
            } else {
                ends.for_each(|x| ink(x, row))
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::Point3;

    use super::*;

    #[test]
    fn a_bar_is_as_long_as_it_says() {
        let from =
            |distance: f64| Camera::Free { lookat: Point3::origin(), distance, azimuth: 0.0, elevation: 0.0 };
        // Ninety degrees at one metre are two metres high.
        let lens = (std::f64::consts::FRAC_PI_2, 1.5);
        for (distance, says, metres) in
            [(1.0, "50 cm", 0.5), (0.02, "1 cm", 0.01), (7.0, "2 m", 2.0), (0.001, "5e-4 m", 5e-4)]
        {
            let bar = ScaleBar::new(from(distance), lens, 1000).unwrap();
            assert_eq!((bar.says.as_str(), bar.pixels), (says, (metres * 500.0 / distance).round() as usize));
        }
        assert_eq!(ScaleBar::new(Camera::Fixed(0), lens, 1000), None);
    }

    #[test]
    fn a_bar_is_drawn_within_its_picture_or_not_at_all() {
        let bar = ScaleBar { says: String::new(), pixels: 20 };
        for (width, height, below, drawn) in
            [(40, 40, 10, 20 * 3 + 2 * 3 * 6), (25, 40, 10, 0), (40, 4, 10, 0)]
        {
            let mut image = Image { width, height, rgb: vec![255; 3 * width * height] };
            bar.draw(&mut image, below);
            let dark = image.rgb.chunks_exact(3).filter(|pixel| pixel[0] == INK).count();
            assert_eq!(dark, drawn, "{width} x {height}");
        }
    }
}
