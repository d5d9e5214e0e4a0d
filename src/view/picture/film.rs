//! Files of pictures: a PNG, and a film that ffmpeg makes of frames, or a PNG a frame.

use std::io::{self, Read, Write};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};

use crate::error::Error;
use crate::mujoco::Image;
use crate::session::{PartFile, files};

/// Endings of film files, and ffmpeg's names of their formats.
const FORMATS: [(&str, &str); 5] =
    [("mp4", "mp4"), ("webm", "webm"), ("mkv", "matroska"), ("mov", "mov"), ("gif", "gif")];

/// The 256 colours of a GIF: those of its first frames, which ffmpeg keeps in memory until it has chosen. Undithered, so that
/// still parts take no bytes.
const GIF_COLOURS: &str =
    "split[a][b];[a]trim=end_frame=50,palettegen[p];[b][p]paletteuse=dither=none:diff_mode=rectangle";

/// An error of ffmpeg: frames as pictures can do without it.
fn ffmpeg(path: &Path, what: &str, fix: &str) -> Error {
    let stem = path.file_stem().unwrap_or_default().to_string_lossy();
    let frames = path.with_file_name(format!("{stem}-%04d.png"));
    let frames = frames.display();
    Error::unfit(path, format!("{what}: {fix}, or give --out {frames} for its frames as pictures"))
}

fn failed(path: &Path, message: &str) -> Error {
    let what = format!("ffmpeg failed with \"{message}\"");
    ffmpeg(path, &what, "give another file extension")
}

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

/// Whether a file's name is that of a film: one that ffmpeg makes, or of numbered pictures, as in `frame-%04d.png`.
pub fn is_film(path: &Path) -> bool {
    format_of(path).is_some() || numbered(path, 1).is_some()
}

/// ffmpeg's name of the format that a file's name ends with.
fn format_of(path: &Path) -> Option<&'static str> {
    let ending = path.extension()?.to_string_lossy().to_lowercase();
    FORMATS.iter().find(|(film, _)| *film == ending).map(|(_, format)| *format)
}

/// The path of a picture of a number, of a name with a place for it, as ffmpeg has it; `None` of any other name.
fn numbered(path: &Path, number: usize) -> Option<PathBuf> {
    let (before, rest) = path.file_name()?.to_str()?.split_once('%')?;
    let (digits, after) = rest.split_once('d')?;
    let digits = if digits.is_empty() { 1 } else { digits.parse().ok().filter(|digits| *digits < 10)? };
    let is_png = after.to_lowercase().ends_with(".png");
    is_png.then(|| path.with_file_name(format!("{before}{number:0digits$}{after}")))
}

/// A film that is being made.
pub struct Film {
    path: PathBuf,
    frames: usize,
    /// ffmpeg and the file that it writes; `None` of numbered pictures, and once the file is in its place.
    ffmpeg: Option<(Child, PartFile)>,
}

impl Drop for Film {
    fn drop(&mut self) {
        // A film that was not finished is none.
        if let Some((child, _)) = &mut self.ffmpeg {
            let _ = child.kill();
            let _ = child.wait();
        }
    }
}

impl Film {
    /// Begins a film of pictures of a size, so many a second.
    ///
    /// # Errors
    /// If ffmpeg is needed and cannot be run, or the file cannot be written.
    pub fn begin(path: &Path, size: [usize; 2], frames_per_second: f64) -> Result<Film, Error> {
        let mut film = Film { path: path.to_path_buf(), frames: 0, ffmpeg: None };
        let Some(format) = format_of(path) else { return Ok(film) };
        let part = PartFile::begin(path).map_err(Error::unwritable(path))?;
        let mut command = Command::new("ffmpeg");
        command.args(["-loglevel", "error", "-nostdin", "-y", "-f", "rawvideo", "-pixel_format", "rgb24"]);
        command.args(["-video_size", &format!("{}x{}", size[0], size[1])]);
        command.args(["-framerate", &frames_per_second.to_string(), "-i", "-"]);
        if format == "gif" {
            command.args(["-filter_complex", GIF_COLOURS]);
        } else {
            // Players want colours at half the size, and so even sides.
            command.args(["-vf", "pad=ceil(iw/2)*2:ceil(ih/2)*2", "-pix_fmt", "yuv420p"]);
        }
        // The part's own name does not say which.
        command.args(["-f", format]).arg(part.path());
        let child = command.stdin(Stdio::piped()).stdout(Stdio::null()).stderr(Stdio::piped()).spawn();
        let child = child.map_err(|error| match error.kind() {
            io::ErrorKind::NotFound => {
                let what = "films need ffmpeg, which is not in the PATH";
                ffmpeg(path, what, "install Debian's package ffmpeg")
            }
            _ => failed(path, &error.to_string()),
        })?;
        film.ffmpeg = Some((child, part));
        Ok(film)
    }

    /// Adds a frame.
    ///
    /// # Errors
    /// If ffmpeg fails, or a picture cannot be written.
    pub fn add(&mut self, image: &Image) -> Result<(), Error> {
        self.frames += 1;
        if let Some((child, _)) = &mut self.ffmpeg {
            let written = child.stdin.as_mut().map_or(Ok(()), |pipe| pipe.write_all(&image.rgb));
            return written.or_else(|_| self.end());
        }
        let path = numbered(&self.path, self.frames).unwrap_or_else(|| self.path.clone());
        files::write(&path, png(image))
    }

    /// Ends the film; how many frames it has.
    ///
    /// # Errors
    /// As [`Film::add`].
    pub fn finish(mut self) -> Result<usize, Error> {
        self.end()?;
        Ok(self.frames)
    }

    /// Waits for ffmpeg, and puts its film in its place.
    fn end(&mut self) -> Result<(), Error> {
        let Some((mut child, part)) = self.ffmpeg.take() else { return Ok(()) };
        drop(child.stdin.take());
        let mut said = String::new();
        if let Some(mut stderr) = child.stderr.take() {
            let _ = stderr.read_to_string(&mut said);
        }
        let status = child.wait().map_err(|error| failed(&self.path, &error.to_string()))?;
        if status.success() {
            return part.put().map_err(Error::unwritable(&self.path));
        }
        let lines: Vec<&str> = said.lines().map(str::trim).filter(|line| !line.is_empty()).collect();
        let message = if lines.is_empty() { status.to_string() } else { lines.join(", ") };
        Err(failed(&self.path, &message))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn films_are_recognized_by_their_names() {
        let film = |name: &str| is_film(Path::new(name));
        assert!(film("a.mp4") && film("b/c.WEBM") && film("frame-%04d.png") && film("%d.png"));
        assert!(!film("a.png") && !film("100%.png") && !film("a.jpg") && !film("%0d4.png.txt"));
        assert_eq!(numbered(Path::new("a/f-%03d.png"), 7).unwrap(), Path::new("a/f-007.png"));
    }
}
