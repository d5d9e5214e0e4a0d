//! XML whose every element and attribute knows the bytes of the file that it stands in.

use std::ops::Range;

use quick_xml::Reader;
use quick_xml::escape::unescape;
use quick_xml::events::{BytesStart, Event};

/// How deep elements may lie in each other: what visits a tree goes down by calls.
const GREATEST_DEPTH: usize = 1000;
/// The mark that some editors put before text in UTF-8.
const BYTE_ORDER_MARK: &[u8] = &[0xef, 0xbb, 0xbf];

/// An attribute of an element.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Attribute {
    /// Its name.
    pub name: String,
    /// Its value, with entities resolved.
    pub value: String,
    /// Where the name is in the file.
    pub name_at: Range<usize>,
    /// Where the value is in the file, without its quotes.
    pub at: Range<usize>,
}

/// An element.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Tag {
    /// What it is called.
    pub name: String,
    /// The line in which it begins, counted from 1.
    pub line: usize,
    /// Its attributes, as they come.
    pub attributes: Vec<Attribute>,
    /// Where its first tag is in the file.
    pub start: Range<usize>,
    /// Where its end tag begins; where it ends if it has none.
    pub end: usize,
    /// The elements in it.
    pub children: Vec<Tag>,
}

impl Tag {
    /// An attribute.
    pub fn attribute(&self, name: &str) -> Option<&Attribute> {
        self.attributes.iter().find(|attribute| attribute.name == name)
    }

    /// An attribute's value.
    pub fn value(&self, name: &str) -> Option<&str> {
        self.attribute(name).map(|attribute| attribute.value.as_str())
    }

    /// Its first child of a name.
    pub fn child(&self, name: &str) -> Option<&Tag> {
        self.children.iter().find(|child| child.name == name)
    }

    /// Its children of a name.
    pub fn children_of(&self, name: &'static str) -> impl Iterator<Item = &Tag> {
        self.children.iter().filter(move |child| child.name == name)
    }

    /// Where its last attribute ends in the file.
    pub fn after_attributes(&self) -> usize {
        // A value has a quote behind it.
        self.attributes.last().map_or(self.after_name(), |last| last.at.end + 1)
    }

    /// Where its own name ends in the file, after which an attribute may be put.
    pub fn after_name(&self) -> usize {
        self.start.start + 1 + self.name.len()
    }
}

/// What is wrong with a file, with its mend, and in which line.
pub(super) type Fault = (usize, String);

/// The line that a byte is in, counted from 1.
pub(super) fn line_of(bytes: &[u8], at: usize) -> usize {
    1 + bytes[..at.min(bytes.len())].iter().filter(|&&byte| byte == b'\n').count()
}

/// Where text begins: after the mark that some editors put before it.
pub(super) fn text_begins(bytes: &[u8]) -> usize {
    if bytes.starts_with(BYTE_ORDER_MARK) { BYTE_ORDER_MARK.len() } else { 0 }
}

/// The one element that a file holds.
///
/// # Errors
/// Where it is no well-formed XML.
pub(super) fn parse(bytes: &[u8]) -> Result<Tag, Fault> {
    let skipped = text_begins(bytes);
    let mut reader = Reader::from_reader(&bytes[skipped..]);
    let mut lines = Lines { bytes, at: 0, line: 1 };
    let mut open: Vec<Tag> = Vec::new();
    let mut root = None;
    let malformed = |line: usize, what: String| (line, format!("malformed XML ({what}): correct it there"));
    let place = |position: u64| skipped + usize::try_from(position).unwrap_or(usize::MAX - skipped);
    loop {
        let start = place(reader.buffer_position());
        let event = reader.read_event().map_err(|error| {
            let at = place(reader.error_position()).max(start);
            malformed(lines.of(at), error.to_string())
        })?;
        let end = place(reader.buffer_position());
        let line = lines.of(start);
        let closed = match event {
            Event::Start(_) if open.len() >= GREATEST_DEPTH => {
                let what = format!("its elements lie deeper than {GREATEST_DEPTH} in each other");
                return Err(malformed(line, what));
            }
            Event::Start(tag) => {
                open.push(element(&tag, start..end, line).map_err(|what| malformed(line, what))?);
                continue;
            }
            Event::Empty(tag) => element(&tag, start..end, line).map_err(|what| malformed(line, what))?,
            Event::End(_) => match open.pop() {
                Some(tag) => Tag { end: start, ..tag },
                None => continue,
            },
            Event::Text(words) if open.is_empty() && !words.trim_ascii().is_empty() => {
                return Err(malformed(line, "there is text outside its element".into()));
            }
            Event::Eof => break,
            _ => continue,
        };
        match open.last_mut() {
            Some(parent) => parent.children.push(closed),
            None if root.is_none() => root = Some(closed),
            None => return Err(malformed(closed.line, format!("<{}> is a second root", closed.name))),
        }
    }
    match (open.last(), root) {
        (Some(tag), _) => Err(malformed(tag.line, format!("<{}> is not closed", tag.name))),
        (None, Some(root)) => Ok(root),
        (None, None) => Err((1, "it holds no XML: give the path of a URDF file".into())),
    }
}

/// An element by its first tag, which is at `at`.
fn element(tag: &BytesStart, at: Range<usize>, line: usize) -> Result<Tag, String> {
    let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
    let inside: &[u8] = tag;
    let mut attributes = Vec::new();
    for attribute in tag.attributes() {
        let attribute = attribute.map_err(|error| error.to_string())?;
        // Name and value are parts of the tag, which begins after its "<".
        let place = |part: &[u8]| {
            let begins = at.start + 1 + (part.as_ptr() as usize - inside.as_ptr() as usize);
            begins..begins + part.len()
        };
        let raw = text(&attribute.value);
        let value = unescape(&raw).map(|value| value.into_owned()).map_err(|error| error.to_string())?;
        let (name_at, at) = (place(attribute.key.as_ref()), place(&attribute.value));
        attributes.push(Attribute { name: text(attribute.key.as_ref()), value, name_at, at });
    }
    Ok(Tag {
        name: text(tag.name().as_ref()),
        line,
        attributes,
        end: at.end,
        start: at,
        children: Vec::new(),
    })
}

/// The lines of places asked for in order.
struct Lines<'b> {
    bytes: &'b [u8],
    at: usize,
    line: usize,
}

impl Lines<'_> {
    fn of(&mut self, place: usize) -> usize {
        let place = place.min(self.bytes.len()).max(self.at);
        self.line += self.bytes[self.at..place].iter().filter(|&&byte| byte == b'\n').count();
        self.at = place;
        self.line
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn attributes_know_their_bytes() {
        let text = "\u{feff}<?xml version=\"1.0\"?>\n<!-- ä --><robot>\n <joint name = 'a&amp;b'\n  x=\"1 2\"/></robot>\n";
        let root = parse(text.as_bytes()).unwrap();
        let joint = &root.children[0];
        assert_eq!((joint.line, joint.value("name")), (3, Some("a&b")));
        let at = |name: &str| &text[joint.attribute(name).unwrap().at.clone()];
        assert_eq!((at("name"), at("x")), ("a&amp;b", "1 2"));
        assert_eq!(&text[joint.start.start..joint.after_name()], "<joint");
        assert_eq!(&text[root.end..], "</robot>\n");
    }

    #[test]
    fn what_is_no_xml_says_where() {
        for (text, line) in
            [("<a>\n<b>\n</a>", 3), ("<a/>\n\n<b/>", 3), ("<a>\n<b x=1/></a>", 2), ("<a>\n <b>", 2)]
        {
            let (found, message) = parse(text.as_bytes()).unwrap_err();
            assert!(found == line && message.contains("malformed XML"), "{text}: {found} {message}");
        }
    }
}
