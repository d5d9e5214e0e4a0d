//! A picture as a PNG.

use crate::mujoco::Image;

/// The bytes of a PNG of eight bits a colour.
pub fn png(image: &Image) -> Vec<u8> {
    let mut bytes = Vec::new();
    // Sides are within the renderer's bounds, and memory takes all that is written.
    let mut encoder = png::Encoder::new(&mut bytes, image.width as u32, image.height as u32);
    encoder.set_color(png::ColorType::Rgb);
    encoder.set_depth(png::BitDepth::Eight);
    let mut writer = encoder.write_header().expect("the header of a picture with sides");
    writer.write_image_data(&image.rgb).expect("three bytes a pixel");
    writer.finish().expect("memory takes all that is written");
    bytes
}
