//! Reading a model's file as XML, with what it includes written out and every element knowing its place.

use std::path::{Path, PathBuf};

use super::parse::{first_tag, parse};
use super::tree::Element;

/// Greatest bytes of an XML file; what is large in a model lies in its meshes.
const GREATEST_FILE: u64 = 256 << 20;
/// How many files a model may be made of: what writes out their includes goes down by calls.
const GREATEST_INCLUSION: usize = 1000;

/// Why a file cannot be read: a clause with its mend, and where it applies.
pub(crate) use crate::mujoco::Error as Refused;

impl Refused {
    /// A refusal of a whole file.
    pub(crate) fn file(path: &Path, message: impl Into<String>) -> Refused {
        Refused::Read { path: path.to_path_buf(), line: None, message: message.into() }
    }

    /// A refusal of what an element says; of `path` where the element is of no file.
    pub(crate) fn of(element: &Element, path: &Path, message: impl Into<String>) -> Refused {
        let place = element.place.as_ref();
        let path = place.map_or(path, |place| &place.file).to_path_buf();
        Refused::Read { path, line: place.map(|place| place.line), message: message.into() }
    }
}

/// A model's file as a tree, with what it includes written out.
#[derive(Clone, Debug)]
pub(crate) struct Source {
    /// The file that was named.
    pub path: PathBuf,
    /// This file and those that it includes, in the order in which they are named.
    pub files: Vec<PathBuf>,
    /// The root element.
    pub root: Element,
}

impl Source {
    /// Reads a file and what it includes.
    ///
    /// # Errors
    /// Where a file cannot be read or is malformed.
    pub fn read(path: &Path) -> Result<Source, Refused> {
        Source::included(path, parse(path, &text_of(path)?)?)
    }

    /// Reads a model's text, called `name` in messages; what it includes is sought in the working folder.
    ///
    /// # Errors
    /// As [`Source::read`].
    pub fn of_text(name: &Path, text: &str) -> Result<Source, Refused> {
        Source::included(name, parse(name, text)?)
    }

    /// Reads a file's bytes, called `name` in messages.
    ///
    /// # Errors
    /// As [`Source::read`].
    pub fn of_bytes(name: &Path, bytes: &[u8]) -> Result<Source, Refused> {
        Source::of_text(name, &text_from(bytes))
    }

    /// Whether an element stands in the file itself, and not in one that it includes.
    pub fn is_own(&self, element: &Element) -> bool {
        element.place.as_ref().is_some_and(|place| *place.file == *self.path)
    }

    /// Refuses what an element of it says.
    pub fn refused(&self, element: &Element, message: impl Into<String>) -> Refused {
        Refused::of(element, &self.path, message)
    }

    fn included(path: &Path, mut root: Element) -> Result<Source, Refused> {
        let files = vec![path.to_path_buf()];
        let mut source = Source { path: path.to_path_buf(), files, root: Element::default() };
        source.include(&mut root, path)?;
        Ok(Source { root, ..source })
    }

    /// Writes out what an element of the file `path` includes. Paths are sought from the main file's folder, as MuJoCo has it,
    /// then from the folder of the file that includes.
    fn include(&mut self, element: &mut Element, path: &Path) -> Result<(), Refused> {
        for mut inner in std::mem::take(&mut element.children) {
            if inner.name != "include" {
                self.include(&mut inner, path)?;
                element.children.push(inner);
                continue;
            }
            let refused = |message: String| Err(Refused::of(&inner, path, message));
            let Some(name) = inner.get("file").filter(|name| !name.is_empty()) else {
                return refused("<include> names no file; give it file=\"…\"".into());
            };
            let file = with_slashes(name);
            let candidates = [&self.path, path].map(|from| folder_of(from).join(&file));
            let Some(found) = candidates.into_iter().find(|candidate| candidate.is_file()) else {
                return refused(format!("it includes {name}, which cannot be found; correct the path there"));
            };
            if self.files.contains(&found) {
                return refused(format!(
                    "it includes {name} a second time; MuJoCo allows each file once: remove it there"
                ));
            }
            if self.files.len() >= GREATEST_INCLUSION {
                return refused("it includes more files than can be; remove an <include>".into());
            }
            self.files.push(found.clone());
            let mut included = parse(&found, &text_of(&found)?)?;
            if included.name == "robot" {
                return refused(format!(
                    "it includes {name}, which is URDF; convert it first, or remove it there"
                ));
            }
            self.include(&mut included, &found)?;
            element.children.extend(included.children);
        }
        Ok(())
    }
}

/// The first letter or mark of a file, after what editors put before it.
pub(crate) fn first_letter(bytes: &[u8]) -> Option<u8> {
    let text = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
    text.trim_ascii_start().first().copied()
}

/// Whether the first element of a file has a name.
pub(crate) fn begins_as(bytes: &[u8], name: &str) -> bool {
    first_letter(bytes) == Some(b'<')
        && first_tag(&text_from(bytes), 0).is_some_and(|(tag, _)| tag.name().as_ref() == name.as_bytes())
}

/// A path with the separators of this system, wherever it was written.
pub(super) fn with_slashes(path: &str) -> String {
    path.replace('\\', "/")
}

/// The folder that a file is in; empty for the working folder.
pub(super) fn folder_of(path: &Path) -> PathBuf {
    path.parent().unwrap_or(Path::new("")).to_path_buf()
}

/// The same from the root of the file system on.
pub(super) fn whole_folder_of(path: &Path) -> PathBuf {
    let folder = folder_of(path);
    let folder = if folder.as_os_str().is_empty() { PathBuf::from(".") } else { folder };
    folder.canonicalize().unwrap_or(folder)
}

/// The text of a model file, whatever its encoding.
fn text_of(path: &Path) -> Result<String, Refused> {
    let refused = |message: &str| Err(Refused::file(path, message));
    let read = || -> std::io::Result<_> {
        let about = std::fs::metadata(path)?;
        let readable = about.is_file() && about.len() <= GREATEST_FILE;
        Ok((about, if readable { std::fs::read(path)? } else { Vec::new() }))
    };
    match read() {
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => {
            refused("there is no such file; give the path of an MJCF or URDF file")
        }
        Err(error) => refused(&format!("it cannot be read ({error}); give an MJCF or URDF file that can")),
        Ok((about, _)) if !about.is_file() => {
            refused("it is no regular file; give the path of an MJCF or URDF file")
        }
        Ok((about, _)) if about.len() > GREATEST_FILE => {
            refused("it is larger than 256 MiB; give the path of an MJCF or URDF file")
        }
        Ok((_, bytes)) if bytes.starts_with(&[0xff, 0xfe]) || bytes.starts_with(&[0xfe, 0xff]) => {
            refused("it is in UTF-16; save it in UTF-8")
        }
        Ok((_, bytes)) => Ok(text_from(&bytes)),
    }
}

/// The text of bytes, as long as they are: a mark stands for each that is not of UTF-8.
pub(super) fn text_from(bytes: &[u8]) -> String {
    let mut text = String::with_capacity(bytes.len());
    for part in bytes.utf8_chunks() {
        text.push_str(part.valid());
        text.extend(std::iter::repeat_n('?', part.invalid().len()));
    }
    text
}
