//! Reading pictures that were drawn.

use std::path::Path;

/// A picture: its width and height, and red, green and blue of each pixel, rows from the top.
pub struct Picture {
    pub width: usize,
    pub height: usize,
    pub pixels: Vec<[u8; 3]>,
}

impl Picture {
    /// A PNG.
    pub fn read(path: &Path) -> Picture {
        let file = std::io::BufReader::new(std::fs::File::open(path).unwrap());
        let mut reader = png::Decoder::new(file).read_info().unwrap();
        let mut bytes = vec![0; reader.output_buffer_size().unwrap()];
        let info = reader.next_frame(&mut bytes).unwrap();
        assert_eq!((info.color_type, info.bit_depth), (png::ColorType::Rgb, png::BitDepth::Eight));
        let pixels = bytes.chunks_exact(3).map(|rgb| [rgb[0], rgb[1], rgb[2]]).collect();
        Picture { width: info.width as usize, height: info.height as usize, pixels }
    }

    /// The share of pixels of which something is true.
    pub fn share(&self, is: impl Fn(&[u8; 3]) -> bool) -> f64 {
        self.pixels.iter().filter(|pixel| is(pixel)).count() as f64 / self.pixels.len() as f64
    }

    /// First and last row, and first and last column, of what is not white.
    pub fn bounds(&self) -> [usize; 4] {
        let drawn = self.pixels.iter().enumerate().filter(|(_, pixel)| **pixel != [255; 3]);
        let places: Vec<[usize; 2]> = drawn.map(|(i, _)| [i / self.width, i % self.width]).collect();
        let [rows, columns] = [0, 1].map(|k| places.iter().map(move |place| place[k]));
        [rows.clone().min(), rows.max(), columns.clone().min(), columns.max()].map(|place| place.unwrap())
    }
}
