//! XML as MuJoCo and editors take it: any hyphens in comments, any prefixes, the first of two attributes of one name, and marks
//! that are no entities as they stand.

use std::ops::Range;
use std::path::Path;
use std::sync::Arc;

use quick_xml::Reader;
use quick_xml::escape::unescape;
use quick_xml::events::{BytesStart, Event};

use super::tree::{Element, Place};
use crate::mujoco::Error as Refused;

/// How deep elements may lie in each other: what visits a tree goes down by calls.
const GREATEST_DEPTH: usize = 1000;
/// What a file without any element is refused with, or one that begins with something else.
const NO_XML: &str = "it holds no XML: give the path of an MJCF or URDF file";
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
        let message = "a character there is none of XML; give an MJCF or URDF file, which is text";
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
            return Err(malformed(begin + more, &format!("there is more after </{}>", root.name)));
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
                    return Err(malformed(begin, &format!("{odd:?} is no name")));
                }
                open.push(element);
            }
            Event::Comment(_) => comments.push(text[begin + "<!--".len()..end - "-->".len()].to_string()),
            Event::Eof => break,
            _ => {}
        }
        if open.len() > GREATEST_DEPTH {
            let message = format!(
                "its elements lie deeper than {GREATEST_DEPTH} in each other; give a chain of fewer bodies"
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
