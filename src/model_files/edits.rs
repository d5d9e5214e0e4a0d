//! A file with other numbers in their places: every other byte stays as it was.

use std::collections::BTreeMap;
use std::ops::Range;

use roxmltree::{Document, Node};

use super::parse::{Tolerant, name_at};
use super::source::text_from;
use super::tree::Element;

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
    fn is_none(&self) -> bool {
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

/// The bytes of an element.
struct Spot {
    name: String,
    /// Each attribute's name, and where its name and its value without quotes are.
    attributes: Vec<(String, Range<usize>, Range<usize>)>,
    /// Where its start tag ends.
    start_ends: usize,
    /// Where its first child begins.
    first_child: Option<usize>,
    /// Where its end tag begins; `None` if its start tag closes it.
    end_begins: Option<usize>,
}

impl Spot {
    /// Where its last attribute ends.
    fn after_attributes(&self, begins: usize) -> usize {
        // A value has a quote behind it.
        self.attributes.last().map_or(begins + 1 + self.name.len(), |(_, _, value)| value.end + 1)
    }
}

/// Changes of an XML file, told by its elements.
pub(crate) struct XmlEdits<'b> {
    bytes: &'b [u8],
    /// By the byte at which each element begins.
    spots: BTreeMap<usize, Spot>,
    edits: Edits,
}

impl<'b> XmlEdits<'b> {
    /// Of a file that was read; of one that is no XML nothing can be changed.
    pub fn new(bytes: &'b [u8]) -> XmlEdits<'b> {
        let text = text_from(bytes);
        let tolerant = Tolerant::new(&text).text;
        let mut spots = BTreeMap::new();
        if let Ok(document) = Document::parse(&tolerant) {
            for node in document.root_element().descendants().filter(Node::is_element) {
                spots.insert(node.range().start, spot(node, &text));
            }
        }
        XmlEdits { bytes, spots, edits: Edits::default() }
    }

    fn at(&self, element: &Element) -> Option<(usize, &Spot)> {
        let at = element.place.as_ref()?.at;
        Some((at, self.spots.get(&at)?))
    }

    /// Changes the numbers of an element's attributes; those that stay keep their text.
    pub fn set(&mut self, element: &Element, changes: &[Change]) {
        for change in changes.iter().filter(|change| !change.is_none()) {
            let Some((begins, spot)) = self.at(element) else { continue };
            let Some((_, _, value)) = spot.attributes.iter().find(|(name, ..)| name == change.attribute)
            else {
                let at = spot.after_attributes(begins);
                self.edits.insert(at, change.text());
                continue;
            };
            let words = words(self.bytes, value);
            if words.len() != change.new.len() {
                // Its blanks are written in some other way.
                let at = value.clone();
                self.edits.replace(at, change.numbers());
                continue;
            }
            for (i, at) in words.into_iter().enumerate().filter(|(i, _)| !change.keeps(*i)) {
                self.edits.replace(at, super::exact(&[change.new[i]]));
            }
        }
    }

    /// Gives an attribute, or one in the place of another, a text.
    pub fn put(&mut self, element: &Element, old: &str, new: &str, text: &str) {
        let Some((begins, spot)) = self.at(element) else { return };
        match spot.attributes.iter().find(|(name, ..)| name == old) {
            Some((_, name, value)) => {
                let (name, value) = (name.clone(), value.clone());
                if new != old {
                    self.edits.replace(name, new);
                }
                self.edits.replace(value, text);
            }
            None => {
                let at = spot.after_attributes(begins);
                self.edits.insert(at, format!(" {new}=\"{text}\""));
            }
        }
    }

    /// Puts elements into another, each in a line as its children are: before them all, or behind.
    pub fn add(&mut self, element: &Element, elements: &str, before: bool) {
        let Some((begins, spot)) = self.at(element) else { return };
        let indent = match spot.first_child {
            Some(child) => indentation(self.bytes, child),
            None => indentation(self.bytes, begins) + "  ",
        };
        let elements = elements.replace('\n', &indent);
        match spot.end_begins {
            // After the last line that is not blank.
            Some(end) if !before => {
                let at = self.bytes[..end].trim_ascii_end().len();
                self.edits.insert(at, elements);
            }
            Some(_) => {
                let at = spot.start_ends;
                self.edits.insert(at, elements);
            }
            None => {
                let end = format!(">{elements}{}</{}>", indentation(self.bytes, begins), spot.name);
                let at = spot.start_ends;
                self.edits.replace(at - "/>".len()..at, end);
            }
        }
    }

    /// The file with all changes.
    pub fn written(self) -> Vec<u8> {
        self.edits.of(self.bytes)
    }
}

fn spot(node: Node, text: &str) -> Spot {
    let Range { start, end } = node.range();
    let name = name_at(text, start).to_string();
    let attributes: Vec<_> = node
        .attributes()
        .map(|own| (text[own.range_qname()].to_string(), own.range_qname(), own.range_value()))
        .collect();
    let mut spot = Spot { name, attributes, start_ends: end, first_child: None, end_begins: None };
    let rest = spot.after_attributes(start);
    spot.start_ends = text[rest..end].find('>').map_or(end, |at| rest + at + 1);
    spot.first_child = node.children().find(Node::is_element).map(|child| child.range().start);
    spot.end_begins = text[spot.start_ends..end].rfind("</").map(|at| spot.start_ends + at);
    spot
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
    use std::path::Path;

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
        let mut edits = XmlEdits::new(&bytes);
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
