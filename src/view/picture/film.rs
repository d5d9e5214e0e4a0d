//! A film: frames that ffmpeg puts into a file, or a PNG each.

use std::io::{self, Read, Write};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};

use super::png;
use crate::mujoco::Image;
use crate::record::{PartFile, write_whole};

/// Endings of files that ffmpeg makes films of, and what it calls their forms.
const FILMS: [(&str, &str); 5] =
    [("mp4", "mp4"), ("webm", "webm"), ("mkv", "matroska"), ("mov", "mov"), ("gif", "gif")];

/// The 256 colours of a GIF: those of its first frames, which ffmpeg keeps in memory until it has chosen. Undithered, so that what
/// stands still takes no bytes.
const GIF_COLOURS: &str =
    "split[a][b];[a]trim=end_frame=50,palettegen[p];[b][p]paletteuse=dither=none:diff_mode=rectangle";

/// Why there is no film.
#[derive(Debug, thiserror::Error)]
pub enum FilmError {
    /// There is no ffmpeg.
    #[error(
        "{}: there is no ffmpeg in the PATH to make a film with: install Debian's package ffmpeg, or give \
         --out {} for its frames as pictures",
        path.display(), frames_of(path).display()
    )]
    NoFfmpeg {
        /// The film.
        path: PathBuf,
    },
    /// ffmpeg gave up.
    #[error("{}: ffmpeg fails with \"{message}\": give another ending of the file's name, or --out {} for its frames as \
             pictures", path.display(), frames_of(path).display())]
    Ffmpeg {
        /// The film.
        path: PathBuf,
        /// Its words.
        message: String,
    },
    /// A file could not be written.
    #[error("cannot write {}: {error}: give another file with --out", path.display())]
    Write {
        /// The file.
        path: PathBuf,
        /// Why.
        error: io::Error,
    },
}

/// The frames that a film could be instead.
fn frames_of(film: &Path) -> PathBuf {
    let stem = film.file_stem().unwrap_or_default().to_string_lossy();
    film.with_file_name(format!("{stem}-%04d.png"))
}

/// Whether a file's name is that of a film: one that ffmpeg makes, or of numbered pictures, as in `frame-%04d.png`.
pub fn is_film(path: &Path) -> bool {
    form(path).is_some() || Numbered::new(path).is_some()
}

/// What ffmpeg calls the form that a file's name ends with.
fn form(path: &Path) -> Option<&'static str> {
    let ending = path.extension()?.to_string_lossy().to_lowercase();
    FILMS.iter().find(|(film, _)| *film == ending).map(|(_, form)| *form)
}

/// A name with a place for a number, as ffmpeg has it.
struct Numbered {
    before: String,
    digits: usize,
    after: String,
    folder: PathBuf,
}

impl Numbered {
    fn new(path: &Path) -> Option<Numbered> {
        let name = path.file_name()?.to_str()?;
        let (before, rest) = name.split_once('%')?;
        let (digits, after) = rest.split_once('d')?;
        let digits = if digits.is_empty() { 1 } else { digits.parse().ok().filter(|digits| *digits < 10)? };
        let png = after.to_lowercase().ends_with(".png");
        let (before, after) = (before.to_string(), after.to_string());
        png.then(|| Numbered { before, digits, after, folder: path.with_file_name("") })
    }

    fn path(&self, number: usize) -> PathBuf {
        let Numbered { before, digits, after, folder } = self;
        folder.join(format!("{before}{number:0digits$}{after}"))
    }
}

/// A film that is being made.
pub struct Film {
    path: PathBuf,
    kind: FilmOutput,
    frames: usize,
}

enum FilmOutput {
    Pictures(Numbered),
    /// The program, and the file that it writes; none once that is in its place.
    Ffmpeg {
        child: Child,
        part: Option<PartFile>,
    },
}

impl Drop for FilmOutput {
    fn drop(&mut self) {
        // A film that was not finished is none.
        if let FilmOutput::Ffmpeg { child, part: Some(_) } = self {
            let _ = child.kill();
            let _ = child.wait();
        }
    }
}

impl Film {
    /// Begins a film of pictures of a size, so many a second.
    ///
    /// # Errors
    /// [`FilmError::NoFfmpeg`] where ffmpeg is needed and is not there.
    pub fn begin(path: &Path, size: [usize; 2], frames_per_second: f64) -> Result<Film, FilmError> {
        if let Some(numbered) = Numbered::new(path) {
            return Ok(Film { path: path.to_path_buf(), kind: FilmOutput::Pictures(numbered), frames: 0 });
        }
        let write = |error| FilmError::Write { path: path.to_path_buf(), error };
        let part = PartFile::begin(path).map_err(write)?;
        let mut command = Command::new("ffmpeg");
        command.args(["-loglevel", "error", "-nostdin", "-y", "-f", "rawvideo", "-pixel_format", "rgb24"]);
        command.args(["-video_size", &format!("{}x{}", size[0], size[1])]);
        command.args(["-framerate", &frames_per_second.to_string(), "-i", "-"]);
        if path.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("gif")) {
            command.args(["-filter_complex", GIF_COLOURS]);
        } else {
            // Players want colours at half the size, and so even sides.
            command.args(["-vf", "pad=ceil(iw/2)*2:ceil(ih/2)*2", "-pix_fmt", "yuv420p"]);
        }
        // The part's name does not tell.
        command.args(form(path).map(|form| ["-f", form]).into_iter().flatten());
        command.arg(part.path()).stdin(Stdio::piped()).stdout(Stdio::null()).stderr(Stdio::piped());
        match command.spawn() {
            Ok(child) => {
                let kind = FilmOutput::Ffmpeg { child, part: Some(part) };
                Ok(Film { path: path.to_path_buf(), kind, frames: 0 })
            }
            Err(error) if error.kind() == io::ErrorKind::NotFound => {
                Err(FilmError::NoFfmpeg { path: path.to_path_buf() })
            }
            Err(error) => Err(FilmError::Ffmpeg { path: path.to_path_buf(), message: error.to_string() }),
        }
    }

    /// Adds a frame.
    ///
    /// # Errors
    /// [`FilmError::Ffmpeg`], [`FilmError::Write`].
    pub fn add(&mut self, image: &Image) -> Result<(), FilmError> {
        self.frames += 1;
        match &mut self.kind {
            FilmOutput::Pictures(numbered) => {
                let path = numbered.path(self.frames);
                write_whole(&path, &png(image)).map_err(|error| FilmError::Write { path, error })
            }
            FilmOutput::Ffmpeg { child, .. } => {
                let written = child.stdin.as_mut().map_or(Ok(()), |pipe| pipe.write_all(&image.rgb));
                written.or_else(|_| self.ended())
            }
        }
    }

    /// Ends the film; how many frames it has.
    ///
    /// # Errors
    /// As [`Film::add`].
    pub fn finish(mut self) -> Result<usize, FilmError> {
        self.ended()?;
        Ok(self.frames)
    }

    /// Waits for ffmpeg, and puts its film in its place.
    fn ended(&mut self) -> Result<(), FilmError> {
        let FilmOutput::Ffmpeg { child, part } = &mut self.kind else { return Ok(()) };
        drop(child.stdin.take());
        let mut said = String::new();
        if let Some(mut stderr) = child.stderr.take() {
            let _ = stderr.read_to_string(&mut said);
        }
        let path = self.path.clone();
        let lines: Vec<&str> = said.lines().map(str::trim).filter(|line| !line.is_empty()).collect();
        match child.wait() {
            Ok(status) if status.success() => {
                let put = part.take().map_or(Ok(()), PartFile::put);
                put.map_err(|error| FilmError::Write { path, error })
            }
            Ok(status) if lines.is_empty() => Err(FilmError::Ffmpeg { path, message: status.to_string() }),
            Ok(_) => Err(FilmError::Ffmpeg { path, message: lines.join(", ") }),
            Err(error) => Err(FilmError::Ffmpeg { path, message: error.to_string() }),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn films_are_told_by_their_names() {
        let film = |name: &str| is_film(Path::new(name));
        assert!(film("a.mp4") && film("b/c.WEBM") && film("frame-%04d.png") && film("%d.png"));
        assert!(!film("a.png") && !film("100%.png") && !film("a.jpg") && !film("%0d4.png.txt"));
        let numbered = Numbered::new(Path::new("a/f-%03d.png")).unwrap();
        assert_eq!(numbered.path(7), Path::new("a/f-007.png"));
    }
}
