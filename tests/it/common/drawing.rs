//! Whether pictures can be drawn here, and reading them.

use std::path::Path;
use std::process::{Command, Stdio};

use bodyschema::mujoco::{Model, Renderer};

/// The variable that forbids to skip what needs OpenGL or ffmpeg.
const REQUIRED: &str = "BODYSCHEMA_GL_TESTS";

fn there(what: &str, lacks: Option<String>) -> bool {
    let Some(lacks) = lacks else { return true };
    let required = std::env::var(REQUIRED).is_ok_and(|value| value == "required");
    assert!(!required, "{what}: {lacks}, or unset {REQUIRED}");
    eprintln!("skipped: {what}: {lacks}");
    false
}

/// Whether there is an OpenGL to draw with; it says so where there is none, and fails where one is required.
pub fn opengl() -> bool {
    let model = Model::from_xml("<mujoco/>").unwrap();
    there("OpenGL", Renderer::new(&model, 16, 16).err().map(|error| error.to_string()))
}

/// The same of ffmpeg.
pub fn ffmpeg() -> bool {
    let run = Command::new("ffmpeg").arg("-version").stdout(Stdio::null()).stderr(Stdio::null()).status();
    there("ffmpeg", run.err().map(|error| format!("{error}: install Debian's package ffmpeg")))
}

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
