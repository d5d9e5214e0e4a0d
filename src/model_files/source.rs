//! Reading a model's file as XML, with what it includes written out and every element knowing its place.

use std::collections::BTreeMap;
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use quick_xml::Reader;
use quick_xml::escape::unescape;
use quick_xml::events::{BytesStart, Event};

use super::tree::{Element, Place};

/// Greatest bytes of an XML file; what is large in a model lies in its meshes.
const GREATEST_FILE: u64 = 256 << 20;
/// How many files a model may be made of: what writes out their includes goes down by calls.
const GREATEST_INCLUSION: usize = 1000;

/// Why a file cannot be read: a clause with its fix, and where it applies.
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
                return refused("it includes too many files; remove an <include>".into());
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
            refused("no such file; give the path of an MJCF or URDF file")
        }
        Err(error) => refused(&format!("it cannot be read ({error}); give a readable MJCF or URDF file")),
        Ok((about, _)) if !about.is_file() => {
            refused("it is not a regular file; give the path of an MJCF or URDF file")
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

/// How deep elements may lie in each other: what visits a tree goes down by calls.
const GREATEST_DEPTH: usize = 1000;
/// What a file without any element is refused with, or one that begins with something else.
const NO_XML: &str = "it contains no XML: give the path of an MJCF or URDF file";
/// The mark that some editors put before text, and blanks as long.
const BYTE_ORDER_MARK: (&str, &str) = ("\u{feff}", "   ");

/// The one element that a text is.
///
/// # Errors
/// Where it is malformed.
pub(super) fn parse(path: &Path, text: &str) -> Result<Element, Refused> {
    let refused = |at: usize, message: String| Refused::Read {
        path: path.to_path_buf(),
        line: Some(1 + newlines(&text[..at])),
        message,
    };
    let malformed = |at: usize, what: &str| refused(at, format!("malformed XML ({what}); correct it there"));
    let is_control = |mark: char| mark < ' ' && !mark.is_ascii_whitespace();
    if let Some(at) = text.find(is_control) {
        let message =
            "it contains a character that XML does not allow; give an MJCF or URDF file, which is text";
        return Err(refused(at, message.into()));
    }
    let text = &text.replacen(BYTE_ORDER_MARK.0, BYTE_ORDER_MARK.1, 1);
    if !text.trim_start().starts_with('<') {
        return Err(Refused::file(path, NO_XML));
    }
    let (file, mut reader) = (Arc::from(path), reader(text));
    let (mut lines, mut counted) = (1, 0);
    let (mut root, mut open, mut comments): (Option<Element>, Vec<Element>, _) = (None, vec![], vec![]);
    loop {
        let begin = reader.buffer_position() as usize;
        let event = reader.read_event();
        let event = event.map_err(|fault| malformed(reader.error_position() as usize, &fault.to_string()))?;
        let end = reader.buffer_position() as usize;
        if let Some(root) = root.as_ref().filter(|_| !matches!(event, Event::Comment(_) | Event::PI(_)))
            && let Some(more) = text[begin..end].find(|mark: char| !mark.is_whitespace())
        {
            return Err(malformed(begin + more, &format!("content after </{}>", root.name)));
        }
        let closes = matches!(event, Event::Empty(_) | Event::End(_));
        match event {
            Event::Start(tag) | Event::Empty(tag) => {
                (lines, counted) = (lines + newlines(&text[counted..begin]), begin);
                let mut element = Element::new(&String::from_utf8_lossy(tag.name().as_ref()));
                element.comments = std::mem::take(&mut comments);
                element.place = Some(Place { file: Arc::clone(&file), line: lines, at: begin, end });
                for at in attributes(&tag).map_err(|fault| malformed(begin, &fault))? {
                    let [name, value] = at.map(|at| &text[begin + 1..end][at]);
                    if !element.has(name) {
                        // What is no entity is meant as it stands.
                        let plain = unescape(value).ok().filter(|plain| !plain.contains(is_control));
                        element.set(name, plain.unwrap_or(value.into()));
                    }
                }
                let names = element.attributes.iter().map(|(name, _)| name).chain([&element.name]);
                if let Some(odd) = { names }.find(|name| !is_name(name)) {
                    return Err(malformed(begin, &format!("{odd:?} is not a name")));
                }
                open.push(element);
            }
            Event::Comment(_) => comments.push(text[begin + "<!--".len()..end - "-->".len()].to_string()),
            Event::Eof => break,
            _ => {}
        }
        if open.len() > GREATEST_DEPTH {
            let message = format!(
                "its elements are nested more than {GREATEST_DEPTH} deep; give a chain of fewer bodies"
            );
            return Err(refused(begin, message));
        }
        if let Some(mut element) = open.pop_if(|_| closes) {
            element.last_comments = std::mem::take(&mut comments);
            element.place.iter_mut().for_each(|place| place.end = end);
            match open.last_mut() {
                Some(parent) => parent.children.push(element),
                None => root = Some(element),
            }
        }
    }
    if let Some((unclosed, place)) = open.last().and_then(|open| Some((open, open.place.as_ref()?))) {
        return Err(malformed(place.at, &format!("<{}> is not closed", unclosed.name)));
    }
    let mut root = root.ok_or_else(|| Refused::file(path, NO_XML))?;
    root.comments.extend(comments);
    Ok(root)
}

/// Whether an element or an attribute can be called so.
fn is_name(name: &str) -> bool {
    name.starts_with(|first: char| first.is_alphabetic() || "_:".contains(first))
        && !name.contains(|mark: char| "<&'\"/;".contains(mark))
}

fn newlines(text: &str) -> usize {
    text.bytes().filter(|byte| *byte == b'\n').count()
}

/// A reader that takes as text what begins as an entity and is none.
fn reader(text: &str) -> Reader<&[u8]> {
    let mut reader = Reader::from_str(text);
    reader.config_mut().allow_dangling_amp = true;
    reader
}

/// The first tag of a text that begins at a byte; where it ends.
pub(super) fn first_tag(text: &str, at: usize) -> Option<(BytesStart<'_>, usize)> {
    let mut reader = reader(text.get(at..)?);
    loop {
        match reader.read_event() {
            Ok(Event::Start(tag) | Event::Empty(tag)) => {
                return Some((tag, at + reader.buffer_position() as usize));
            }
            Ok(Event::Eof) | Err(_) => return None,
            Ok(_) => {}
        }
    }
}

/// Where in a tag, from behind its bracket on, each attribute's name and its value without quotes are.
pub(super) fn attributes(tag: &BytesStart) -> Result<Vec<[Range<usize>; 2]>, String> {
    let at = |part: &[u8]| {
        let from = part.as_ptr() as usize - tag.as_ptr() as usize;
        from..from + part.len()
    };
    let mut all = tag.attributes();
    let places = all.with_checks(false).map(|own| own.map(|own| [at(own.key.as_ref()), at(&own.value)]));
    places.collect::<Result<_, _>>().map_err(|fault| fault.to_string())
}

/// What was left out of a model's file, each with its number.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct LeftOut {
    /// Parts of the body that could not be read.
    pub lost: BTreeMap<String, usize>,
    /// What has nothing to do with where limbs are and what they touch.
    pub unneeded: BTreeMap<String, usize>,
    /// Entries of `<equality>` that couple joints or close the tree, and are not heeded.
    pub unheeded: usize,
    /// What was read otherwise than it stands there, or looks odd, a sentence each.
    pub notes: Vec<String>,
}

impl LeftOut {
    /// Whether nothing was.
    pub fn is_empty(&self) -> bool {
        self.lost.is_empty() && self.unneeded.is_empty()
    }

    pub(crate) fn lose(&mut self, what: impl Into<String>, count: usize) {
        if count > 0 {
            *self.lost.entry(what.into()).or_default() += count;
        }
    }

    pub(crate) fn spare(&mut self, what: impl Into<String>) {
        *self.unneeded.entry(what.into()).or_default() += 1;
    }

    /// What was left out, for a sentence: what is lost of the body by name, all else as a number of kinds; `None` if
    /// nothing was.
    pub fn in_words(&self) -> Option<String> {
        const SHOWN: usize = 4;
        let kinds = |count: usize, of: &str| match count {
            0 => None,
            1 => Some(format!("1 kind of {of}")),
            count => Some(format!("{count} kinds of {of}")),
        };
        let lost = self.lost.iter().take(SHOWN).map(|(what, count)| counted(what, *count));
        let more = kinds(self.lost.len().saturating_sub(SHOWN), "other part of the body");
        let unneeded = kinds(self.unneeded.len(), "part that a body schema does not need");
        let all: Vec<String> = lost.chain(more).chain(unneeded).collect();
        (!all.is_empty()).then(|| all.join(", "))
    }
}

/// A thing with its number.
fn counted(what: &str, count: usize) -> String {
    if count == 1 { what.to_string() } else { format!("{what} ({count} times)") }
}
