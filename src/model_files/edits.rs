//! A file with other numbers in their places: every other byte stays as it was.

use std::ops::Range;
use std::path::Path;

use super::parse::{attributes, first_tag};
use super::source::text_from;
use super::tree::{Element, Place};

/// Changes of a file's bytes.
#[derive(Clone, Debug, Default)]
pub(crate) struct Edits(Vec<(Range<usize>, String)>);

impl Edits {
    /// Puts a text in the place of another.
    pub fn replace(&mut self, at: Range<usize>, text: impl Into<String>) {
        self.0.push((at, text.into()));
    }

    /// Puts a text before a byte, after what was put there before it.
    pub fn insert(&mut self, at: usize, text: impl Into<String>) {
        self.replace(at..at, text);
    }

    /// The file with all changes, which must not overlap.
    pub fn of(mut self, bytes: &[u8]) -> Vec<u8> {
        self.0.sort_by_key(|(at, _)| at.start);
        let mut written = Vec::with_capacity(bytes.len());
        let mut done = 0;
        for (at, text) in self.0 {
            written.extend_from_slice(&bytes[done..at.start]);
            written.extend_from_slice(text.as_bytes());
            done = at.end;
        }
        written.extend_from_slice(&bytes[done..]);
        written
    }
}

/// Numbers of an attribute as they were and as they are to be.
pub(crate) struct Change {
    pub attribute: &'static str,
    pub old: Vec<f64>,
    pub new: Vec<f64>,
    /// What counts as no difference.
    pub negligible: f64,
}

impl Change {
    /// A change of which any difference counts.
    pub fn of(attribute: &'static str, old: impl Into<Vec<f64>>, new: impl Into<Vec<f64>>) -> Change {
        Change { attribute, old: old.into(), new: new.into(), negligible: 0.0 }
    }

    /// Whether nothing changes.
    pub fn is_none(&self) -> bool {
        self.old.len() == self.new.len() && (0..self.new.len()).all(|i| self.keeps(i))
    }

    fn keeps(&self, i: usize) -> bool {
        self.old.get(i).is_some_and(|old| (self.new[i] - old).abs() <= self.negligible)
    }

    /// The new numbers.
    pub fn numbers(&self) -> String {
        super::exact(&self.new)
    }

    /// The attribute with its new numbers.
    fn text(&self) -> String {
        format!(" {}=\"{}\"", self.attribute, self.numbers())
    }
}

/// An element of its own line with the new numbers of attributes.
pub(crate) fn new_element(name: &str, changes: &[Change]) -> String {
    format!("\n<{name}{}/>", changes.iter().map(Change::text).collect::<String>())
}

/// The start tag of an element in a file.
struct Tag {
    /// Where it begins and ends.
    at: Range<usize>,
    /// Where the name and the value without quotes of each attribute are.
    attributes: Vec<[Range<usize>; 2]>,
    /// Where its last attribute ends.
    after_attributes: usize,
    /// Where the end tag begins; `None` if the start tag closes the element.
    end_begins: Option<usize>,
}

/// Changes of an XML file, told by its elements.
pub(crate) struct XmlEdits<'b> {
    file: &'b Path,
    bytes: &'b [u8],
    text: String,
    edits: Edits,
}

impl<'b> XmlEdits<'b> {
    /// Of a file that was read; elements of others stay as they are.
    pub fn new(file: &'b Path, bytes: &'b [u8]) -> XmlEdits<'b> {
        XmlEdits { file, bytes, text: text_from(bytes), edits: Edits::default() }
    }

    /// Where an element is; `None` if it is not of this file.
    fn place<'e>(&self, element: &'e Element) -> Option<&'e Place> {
        element.place.as_ref().filter(|place| *place.file == *self.file)
    }

    /// The start tag of an element; `None` if it is not of this file.
    fn tag(&self, element: &Element) -> Option<Tag> {
        let &Place { at, end, .. } = self.place(element)?;
        let (tag, start_ends) = first_tag(&self.text, at)?;
        let within = |part: Range<usize>| at + 1 + part.start..at + 1 + part.end;
        let attributes: Vec<_> = attributes(&tag).ok()?.into_iter().map(|own| own.map(within)).collect();
        Some(Tag {
            at: at..start_ends,
            // A value has a quote behind it.
            after_attributes: attributes
                .last()
                .map_or(at + 1 + tag.name().as_ref().len(), |[_, value]| value.end + 1),
            attributes,
            end_begins: self.text[start_ends..end].rfind("</").map(|inside| start_ends + inside),
        })
    }

    /// Where the name and the value of an attribute are.
    fn attribute(&self, tag: &Tag, name: &str) -> Option<[Range<usize>; 2]> {
        tag.attributes.iter().find(|[own, _]| self.text[own.clone()] == *name).cloned()
    }

    /// Changes the numbers of an element's attributes; those that stay keep their text.
    pub fn set(&mut self, element: &Element, changes: &[Change]) {
        let Some(tag) = self.tag(element) else { return };
        for change in changes.iter().filter(|change| !change.is_none()) {
            let Some([_, value]) = self.attribute(&tag, change.attribute) else {
                self.edits.insert(tag.after_attributes, change.text());
                continue;
            };
            let words = words(self.bytes, &value);
            if words.len() != change.new.len() {
                // Its blanks are written in some other way.
                self.edits.replace(value, change.numbers());
                continue;
            }
            for (i, at) in words.into_iter().enumerate().filter(|(i, _)| !change.keeps(*i)) {
                self.edits.replace(at, super::exact(&[change.new[i]]));
            }
        }
    }

    /// Gives an attribute, or one in the place of another, a text.
    pub fn put(&mut self, element: &Element, old: &str, new: &str, text: &str) {
        let Some(tag) = self.tag(element) else { return };
        match self.attribute(&tag, old) {
            Some([name, value]) => {
                self.edits.replace(name, new);
                self.edits.replace(value, text);
            }
            None => self.edits.insert(tag.after_attributes, format!(" {new}=\"{text}\"")),
        }
    }

    /// Puts elements into another, each in a line as its children are: before them all, or behind.
    pub fn add(&mut self, element: &Element, elements: &str, before: bool) {
        let Some(tag) = self.tag(element) else { return };
        let own = indentation(self.bytes, tag.at.start);
        let first = element.children.iter().find_map(|child| self.place(child));
        let indent = first.map_or(format!("{own}  "), |child| indentation(self.bytes, child.at));
        let elements = elements.replace('\n', &indent);
        match tag.end_begins {
            // After the last line that is not blank.
            Some(end) if !before => self.edits.insert(self.bytes[..end].trim_ascii_end().len(), elements),
            Some(_) => self.edits.insert(tag.at.end, elements),
            None => {
                let end = format!(">{elements}{own}</{}>", element.name);
                self.edits.replace(tag.at.end - "/>".len()..tag.at.end, end);
            }
        }
    }

    /// The file with all changes.
    pub fn written(self) -> Vec<u8> {
        self.edits.of(self.bytes)
    }
}

/// Where the words of a stretch of a file are.
fn words(bytes: &[u8], at: &Range<usize>) -> Vec<Range<usize>> {
    let mut from = at.start;
    let mut words = Vec::new();
    for word in bytes[at.clone()].split(u8::is_ascii_whitespace) {
        words.extend((!word.is_empty()).then_some(from..from + word.len()));
        from += word.len() + 1;
    }
    words
}

/// The negative of a number as it is written.
pub(crate) fn negative(text: &str) -> String {
    let text = text.trim();
    match (text.strip_prefix('-'), text.parse::<f64>()) {
        (Some(positive), _) => positive.to_string(),
        (None, Ok(0.0)) => text.to_string(),
        _ => format!("-{}", text.trim_start_matches('+')),
    }
}

/// The line break and the blanks before a place; a line break alone where something else stands there.
fn indentation(bytes: &[u8], at: usize) -> String {
    let before = &bytes[..at];
    let line = before.iter().rposition(|&byte| byte == b'\n').map_or(0, |end| end + 1);
    let blanks = &before[line..];
    let lines = if before[..line].ends_with(b"\r\n") { "\r\n" } else { "\n" };
    match std::str::from_utf8(blanks) {
        Ok(blanks) if line > 0 && blanks.trim().is_empty() => format!("{lines}{blanks}"),
        _ => lines.to_string(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model_files::Source;

    #[test]
    fn edits_leave_the_rest_alone() {
        let mut edits = Edits::default();
        edits.replace(8..9, "6");
        edits.insert(2, "b");
        edits.insert(2, "c");
        edits.replace(3..4, "");
        assert_eq!(edits.of(b"a x2 y z5"), b"a bcx y z6".to_vec());
    }

    #[test]
    fn elements_are_changed_in_their_places() {
        let text = "\u{feff}<?xml version=\"1.0\"?>\n<!-- ä -- --><robot>\n  <joint name = 'a&amp;b'\n  x=\"1  2\"/>\n</robot>\n";
        let bytes = [text.as_bytes(), b"<!-- \xe4 -->"].concat();
        let source = Source::of_text(Path::new("a.urdf"), &text_from(&bytes)).unwrap();
        let joint = source.root.child("joint").unwrap();
        assert_eq!((joint.place.as_ref().unwrap().line, joint.get("name")), (3, Some("a&b")));
        let mut edits = XmlEdits::new(Path::new("a.urdf"), &bytes);
        edits.set(joint, &[Change::of("x", [1.0, 2.0], [1.0, 3.0]), Change::of("y", [0.0], [4.0])]);
        edits.put(joint, "name", "id", "c");
        edits.add(&source.root, "\n<link/>", false);
        edits.add(joint, "\n<axis/>", true);
        let expected = text
            .replace("1  2\"/>", "1  3\" y=\"4\">\n    <axis/>\n  </joint>\n  <link/>")
            .replace("name = 'a&amp;b'", "id = 'c'");
        assert_eq!(String::from_utf8_lossy(&edits.written()[..expected.len()]), expected);
    }
}
