//! Reading a model's file as XML, with what it includes written out and every element knowing its place.

use std::collections::HashSet;
use std::path::{Path, PathBuf};

use quick_xml::Reader;
use quick_xml::events::{BytesStart, Event};
use xmltree::{Element, XMLNode};

use super::attribute;

/// Greatest bytes of an XML file; what is large in a model lies in its meshes.
const GREATEST_FILE: u64 = 256 << 20;
/// How deep elements may lie in each other: what visits a tree goes down by calls.
const GREATEST_DEPTH: usize = 1000;

/// Why a file cannot be read: a clause with its mend, and where it applies.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Refused {
    /// The file.
    pub path: PathBuf,
    /// The line in it, counted from 1; none where it is about the whole file.
    pub line: Option<usize>,
    /// What is wrong, and what to do about it.
    pub message: String,
}

impl Refused {
    /// A refusal of a whole file.
    pub fn file(path: &Path, message: impl Into<String>) -> Refused {
        Refused { path: path.to_path_buf(), line: None, message: message.into() }
    }

    /// A refusal of what an element says; of `path` where the element is of no file.
    pub fn of(element: &Element, path: &Path, message: impl Into<String>) -> Refused {
        let (path, line) = place(element).map_or((path, None), |(path, line)| (path, Some(line)));
        Refused { path: path.to_path_buf(), line, message: message.into() }
    }
}

/// The file and line in which an element stands.
pub(crate) fn place(element: &Element) -> Option<(&Path, usize)> {
    let (line, file) = element.namespace.as_deref()?.split_once(':')?;
    Some((Path::new(file), line.parse().ok()?))
}

/// Marks an element as of a line of a file. Model files have no namespaces: their field holds it, so that it stays with
/// the element in whatever tree it ends up.
fn mark(element: &mut Element, file: &Path, line: usize) {
    element.namespace = Some(format!("{line}:{}", file.display()));
}

/// A model's file as a tree, with what it includes written out.
#[derive(Clone, Debug)]
pub(crate) struct Source {
    /// The file that was named.
    pub path: PathBuf,
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

    /// Refuses what an element of it says.
    pub fn refused(&self, element: &Element, message: impl Into<String>) -> Refused {
        Refused::of(element, &self.path, message)
    }

    fn included(path: &Path, mut root: Element) -> Result<Source, Refused> {
        let main = folder_of(path);
        let mut seen = HashSet::from([path.to_path_buf()]);
        let mut include = Include { main: &main, seen: &mut seen };
        include.within(&mut root, &main, path, 0)?;
        Ok(Source { path: path.to_path_buf(), root })
    }
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
    let refused = |message: String| Refused::file(path, message);
    let about = std::fs::metadata(path).map_err(|error| match error.kind() {
        std::io::ErrorKind::NotFound => {
            refused("there is no such file; give the path of an MJCF or URDF file".into())
        }
        _ => refused(format!("it cannot be read ({error}); give an MJCF or URDF file that can")),
    })?;
    if !about.is_file() {
        return Err(refused("it is no regular file; give the path of an MJCF or URDF file".into()));
    }
    if about.len() > GREATEST_FILE {
        return Err(refused("it is larger than 256 MiB; give the path of an MJCF or URDF file".into()));
    }
    let bytes = std::fs::read(path).map_err(|error| {
        refused(format!("it cannot be read ({error}); give an MJCF or URDF file that can"))
    })?;
    if bytes.starts_with(&[0xff, 0xfe]) || bytes.starts_with(&[0xfe, 0xff]) {
        return Err(refused("it is in UTF-16; save it in UTF-8".into()));
    }
    Ok(String::from_utf8_lossy(&bytes).into_owned())
}

/// The line of a place in a text, counted from 1.
struct Lines<'t> {
    text: &'t [u8],
    at: usize,
    line: usize,
}

impl Lines<'_> {
    /// The line of a place that is not before the last one asked for.
    fn of(&mut self, place: usize) -> usize {
        let place = place.min(self.text.len()).max(self.at);
        self.line += self.text[self.at..place].iter().filter(|&&byte| byte == b'\n').count();
        self.at = place;
        self.line
    }
}

/// What is said of a file without any element, or one that begins with something else.
const NO_XML: &str = "it holds no XML: give the path of an MJCF or URDF file";

/// The one element that a text is, with comments and text in it.
fn parse(path: &Path, text: &str) -> Result<Element, Refused> {
    let text = text.trim_start_matches('\u{feff}');
    let mut lines = Lines { text: text.as_bytes(), at: 0, line: 1 };
    let mut reader = Reader::from_str(text);
    let mut open: Vec<Element> = Vec::new();
    let refused =
        |line: usize, message: String| Refused { path: path.to_path_buf(), line: Some(line), message };
    let malformed =
        |line: usize, what: String| refused(line, format!("malformed XML ({what}); correct it there"));
    if let Some(at) = text.find(|mark: char| mark < ' ' && !mark.is_ascii_whitespace()) {
        let message = "a character there is none of XML; give an MJCF or URDF file, which is text";
        return Err(refused(lines.of(at), message.into()));
    }
    if !text.trim_start().starts_with('<') {
        return Err(Refused::file(path, NO_XML));
    }
    loop {
        let start = usize::try_from(reader.buffer_position()).unwrap_or(usize::MAX);
        let event = reader.read_event().map_err(|error| {
            let place = usize::try_from(reader.error_position()).unwrap_or(usize::MAX);
            malformed(lines.of(place.max(start)), error.to_string())
        })?;
        let closed = match event {
            Event::Start(tag) => {
                let line = lines.of(start);
                if open.len() >= GREATEST_DEPTH {
                    let message = format!(
                        "its elements lie deeper than {GREATEST_DEPTH} in each other; give a chain of fewer bodies"
                    );
                    return Err(refused(line, message));
                }
                open.push(element(&tag, path, line).map_err(|what| malformed(line, what))?);
                continue;
            }
            Event::Empty(tag) => {
                let line = lines.of(start);
                element(&tag, path, line).map_err(|what| malformed(line, what))?
            }
            Event::End(_) => match open.pop() {
                Some(element) => element,
                None => continue,
            },
            Event::Comment(comment) => {
                if let Some(parent) = open.last_mut() {
                    parent.children.push(XMLNode::Comment(String::from_utf8_lossy(&comment).into_owned()));
                }
                continue;
            }
            Event::Text(words) => {
                let words = String::from_utf8_lossy(&words).into_owned();
                if let Some(parent) = open.last_mut().filter(|_| !words.trim().is_empty()) {
                    parent.children.push(XMLNode::Text(words.trim().to_string()));
                }
                continue;
            }
            Event::Eof => break,
            _ => continue,
        };
        match open.last_mut() {
            Some(parent) => parent.children.push(XMLNode::Element(closed)),
            None => match more(&mut reader, text) {
                None => return Ok(closed),
                Some(at) => {
                    let what = format!("there is more after </{}>", closed.name);
                    return Err(malformed(lines.of(at), what));
                }
            },
        }
    }
    match open.last() {
        Some(element) => {
            let line = place(element).map_or(1, |(_, line)| line);
            Err(malformed(line, format!("<{}> is not closed", element.name)))
        }
        None => Err(Refused::file(path, NO_XML)),
    }
}

/// Where a text goes on after its one element with anything but remarks.
fn more(reader: &mut Reader<&[u8]>, text: &str) -> Option<usize> {
    loop {
        let start = usize::try_from(reader.buffer_position()).unwrap_or(usize::MAX);
        match reader.read_event() {
            Ok(Event::Eof) => return None,
            Ok(Event::Comment(_) | Event::PI(_)) => {}
            Ok(Event::Text(words)) if words.trim_ascii().is_empty() => {}
            _ => {
                let rest = text.get(start..).unwrap_or_default();
                return Some(start + rest.len() - rest.trim_start().len());
            }
        }
    }
}

/// An element by its start tag.
fn element(tag: &BytesStart, file: &Path, line: usize) -> Result<Element, String> {
    let mut element = Element::new(&String::from_utf8_lossy(tag.name().as_ref()));
    mark(&mut element, file, line);
    // MuJoCo takes the first of two attributes of one name.
    for attribute in tag.attributes().with_checks(false) {
        let attribute = attribute.map_err(|error| error.to_string())?;
        let name = String::from_utf8_lossy(attribute.key.as_ref()).into_owned();
        let raw = String::from_utf8_lossy(&attribute.value).into_owned();
        // What is no entity is meant as it stands.
        let value = quick_xml::escape::unescape(&raw).map(|value| value.into_owned()).unwrap_or(raw);
        element.attributes.entry(name).or_insert(value);
    }
    Ok(element)
}

/// What is known while includes are written out.
struct Include<'a> {
    main: &'a Path,
    seen: &'a mut HashSet<PathBuf>,
}

impl Include<'_> {
    /// Writes out what an element of the file `path`, in `folder`, includes. Paths are sought from the main file's
    /// folder, as MuJoCo has it, then from the folder of the file that includes.
    fn within(
        &mut self,
        element: &mut Element,
        folder: &Path,
        path: &Path,
        depth: usize,
    ) -> Result<(), Refused> {
        for mut child in std::mem::take(&mut element.children) {
            let Some(inner) = child.as_mut_element() else {
                element.children.push(child);
                continue;
            };
            if inner.name != "include" {
                self.within(inner, folder, path, depth)?;
                element.children.push(child);
                continue;
            }
            let Some(name) = attribute(inner, "file").filter(|name| !name.is_empty()) else {
                return Err(Refused::of(inner, path, "<include> names no file; give it file=\"…\""));
            };
            let file = with_slashes(name);
            let candidates = [self.main.join(&file), folder.join(&file)];
            let Some(found) = candidates.iter().find(|candidate| candidate.is_file()) else {
                let message = format!("it includes {name}, which cannot be found; correct the path there");
                return Err(Refused::of(inner, path, message));
            };
            if !self.seen.insert(found.clone()) {
                let message = format!(
                    "it includes {name} a second time; MuJoCo allows each file once: remove it there"
                );
                return Err(Refused::of(inner, path, message));
            }
            let mut included = parse(found, &text_of(found)?)?;
            if included.name == "robot" {
                let message =
                    format!("it includes {name}, which is URDF; convert it first, or remove it there");
                return Err(Refused::of(inner, path, message));
            }
            if depth >= GREATEST_DEPTH {
                return Err(Refused::file(
                    found,
                    "files include each other without end; remove an <include>",
                ));
            }
            self.within(&mut included, &folder_of(found), found, depth + 1)?;
            element.children.extend(included.children);
        }
        Ok(())
    }
}
