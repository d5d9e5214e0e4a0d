//! Writing a tree as XML: as a text of its own, an element a line, or into the file that it is from, where every other byte stays
//! as it was.

use std::ops::Range;
use std::path::Path;

use quick_xml::escape::escape;

use super::source::{attributes, first_tag, text_from};
use super::tree::Element;

/// Elements lie in each other at most so deep in one text: MuJoCo's XML reader takes 100 levels.
const DEEPEST: usize = 80;

/// Numbers to the last digit: they read back as the very same.
pub(crate) fn exact<'a>(values: impl IntoIterator<Item = &'a f64>) -> String {
    // Adding zero turns -0 into 0.
    values.into_iter().map(|value| (value + 0.0).to_string()).collect::<Vec<_>>().join(" ")
}

/// The text of a file, indented by two spaces.
pub(crate) fn write(root: &Element) -> String {
    Texts::up_to(usize::MAX, root, "").texts.swap_remove(0).1
}

/// A start tag without its end.
fn start(element: &Element) -> String {
    let attributes = element.attributes.iter();
    let attributes = attributes
        .map(|(name, value)| format!(" {name}=\"{}\"", escape(value).replace(['\n', '\r', '\t'], " ")));
    format!("<{}{}", element.name, attributes.collect::<String>())
}

/// A tree as texts that the engine reads, of which the first includes the others: no text is deeper than its XML
/// reader allows.
pub(crate) struct Texts {
    /// Each text with its name.
    pub texts: Vec<(String, String)>,
    /// Which element, in the order of the tree, starts in each line of the first text.
    lines: Vec<Option<usize>>,
    elements: usize,
    /// How deep elements may lie in each other in one text.
    deepest: usize,
}

impl Texts {
    /// Writes a tree; `name` is that of the first text.
    pub fn new(root: &Element, name: &str) -> Texts {
        Texts::up_to(DEEPEST, root, name)
    }

    fn up_to(deepest: usize, root: &Element, name: &str) -> Texts {
        let texts = vec![(name.to_string(), String::new())];
        let mut texts = Texts { texts, lines: Vec::new(), elements: 0, deepest };
        texts.element(root, 0, 0);
        texts
    }

    /// The number of the element in a line of the first text, counted from 1.
    pub fn element_in_line(&self, line: usize) -> Option<usize> {
        *self.lines.get(line.checked_sub(1)?)?
    }

    /// Writes words in lines of their own into a text.
    fn push(&mut self, [depth, text]: [usize; 2], words: &str, element: Option<usize>) {
        let into = &mut self.texts[text].1;
        (0..depth).for_each(|_| into.push_str("  "));
        into.extend([words, "\n"]);
        if text == 0 {
            self.lines.extend(words.split('\n').map(|_| element));
        }
    }

    fn element(&mut self, one: &Element, depth: usize, text: usize) {
        let (at, number) = ([depth, text], Some(self.elements));
        if depth > self.deepest {
            let part = self.texts.len();
            let name = format!("part{part}.xml");
            self.push(at, &format!("<include file=\"{name}\"/>"), number);
            self.texts.push((name, "<mujocoinclude>\n".into()));
            self.element(one, 1, part);
            return self.push([0, part], "</mujocoinclude>", None);
        }
        self.elements += 1;
        one.comments.iter().for_each(|words| self.push(at, &format!("<!--{words}-->"), None));
        let tag = start(one);
        if one.children.is_empty() && one.last_comments.is_empty() {
            return self.push(at, &format!("{tag}/>"), number);
        }
        self.push(at, &format!("{tag}>"), number);
        one.children.iter().for_each(|child| self.element(child, depth + 1, text));
        let inside = [depth + 1, text];
        one.last_comments.iter().for_each(|words| self.push(inside, &format!("<!--{words}-->"), None));
        self.push(at, &format!("</{}>", one.name), None);
    }
}

/// The element of a number in the order of a tree.
pub(crate) fn numbered(root: &mut Element, number: usize) -> Option<&mut Element> {
    fn within<'a>(element: &'a mut Element, left: &mut usize) -> Option<&'a mut Element> {
        if *left == 0 {
            return Some(element);
        }
        *left -= 1;
        element.children.iter_mut().find_map(|child| within(child, left))
    }
    within(root, &mut { number })
}

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

/// A file's bytes with all that differs in a tree of it: numbers that changed and elements that were added. Every other byte
/// stays as it was. `old` was read from the bytes, and `new` is the same with other names and values of its
/// attributes, with more of them, and with more elements.
pub(crate) fn rewritten(file: &Path, bytes: &[u8], old: &Element, new: &Element) -> Vec<u8> {
    let mut writer = Rewriter { file, bytes, text: text_from(bytes), edits: Edits::default() };
    writer.element(old, new);
    writer.edits.of(bytes)
}

struct Rewriter<'b> {
    file: &'b Path,
    bytes: &'b [u8],
    text: String,
    edits: Edits,
}

impl Rewriter<'_> {
    fn element(&mut self, old: &Element, new: &Element) {
        // What stands in other files stays as it is.
        if let Some(place) = old.place.as_ref().filter(|place| *place.file == *self.file)
            && let Some((tag, ends)) = first_tag(&self.text, place.at)
            && let Ok(attributes) = attributes(&tag)
        {
            let within = |part: Range<usize>| place.at + 1 + part.start..place.at + 1 + part.end;
            let attributes: Vec<[Range<usize>; 2]> =
                attributes.into_iter().map(|own| own.map(within)).collect();
            // A value has a quote behind it.
            let bare = place.at + 1 + tag.name().as_ref().len();
            let behind = attributes.last().map_or(bare, |[_, value]| value.end + 1);
            self.attributes(&attributes, behind, old, new);
            self.children(place.at..ends, place.end, new);
        }
        let kept = new.children.iter().filter(|child| child.place.is_some());
        old.children.iter().zip(kept).for_each(|(old, new)| self.element(old, new));
    }

    /// Changes the attributes of an element: their names, their values, and those behind them that are new.
    fn attributes(&mut self, places: &[[Range<usize>; 2]], behind: usize, old: &Element, new: &Element) {
        let place = |name: &str| places.iter().find(|[own, _]| self.text[own.clone()] == *name).cloned();
        let mut edits = Vec::new();
        for (k, (name, value)) in new.attributes.iter().enumerate() {
            match old.attributes.get(k).and_then(|(before, text)| Some((before, text, place(before)?))) {
                Some((before, text, _)) if before == name && text == value => {}
                Some((before, _, [_, at])) if before == name => edits.extend(self.changed(at, value)),
                Some((.., [own, at])) => edits.extend([(own, name.clone()), (at, escape(value).into())]),
                None => edits.push((behind..behind, format!(" {name}=\"{}\"", escape(value)))),
            }
        }
        edits.into_iter().for_each(|(at, text)| self.edits.replace(at, text));
    }

    /// What of a value changes: numbers that stay keep their text.
    fn changed(&self, at: Range<usize>, value: &str) -> Vec<(Range<usize>, String)> {
        let (old, new) = (words(self.bytes, &at), value.split_ascii_whitespace().collect::<Vec<_>>());
        if old.len() != new.len() {
            // Its blanks are written in some other way.
            return vec![(at, escape(value).into())];
        }
        let number = |word: &str| word.parse::<f64>().ok();
        let same = |(at, new): &(Range<usize>, &str)| {
            let old = &self.text[at.clone()];
            old == *new || number(old).is_some_and(|old| Some(old) == number(new))
        };
        let changed = old.into_iter().zip(new).filter(|word| !same(word));
        changed.map(|(at, new)| (at, escape(new).into())).collect()
    }

    /// Puts the children of an element that are new each into lines of their own: before those that are there, or behind.
    fn children(&mut self, tag: Range<usize>, end: usize, new: &Element) {
        let own = indentation(self.bytes, tag.start);
        let places = new.children.iter().map(|child| child.place.as_ref());
        let there = places.clone().flatten().find(|place| *place.file == *self.file);
        let indent = there.map_or(format!("{own}  "), |place| indentation(self.bytes, place.at));
        let first = places.clone().position(|place| place.is_some()).unwrap_or(new.children.len());
        let [before, behind] = [&new.children[..first], &new.children[first..]].map(|children| {
            let new = children.iter().filter(|child| child.place.is_none());
            new.map(|child| format!("\n{}", write(child).trim_end()).replace('\n', &indent))
                .collect::<String>()
        });
        match self.text[tag.end..end].rfind("</") {
            // After the last line that is not blank.
            Some(close) => {
                let last = self.bytes[..tag.end + close].trim_ascii_end().len();
                let added = [(tag.end, before), (last, behind)];
                added.into_iter().for_each(|(at, text)| self.edits.insert(at, text));
            }
            None if before.is_empty() => {}
            None => {
                let text = format!(">{before}{own}</{}>", new.name);
                self.edits.replace(tag.end - "/>".len()..tag.end, text);
            }
        }
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
        let mut root = source.root.clone();
        let joint = &mut root.children[0];
        joint.attributes[0].0 = "id".into();
        [("x", "1 3"), ("y", "4"), ("id", "c")].iter().for_each(|(name, value)| joint.set(name, *value));
        joint.children.push(Element::new("axis"));
        root.children.push(Element::new("link"));
        let expected = text
            .replace("1  2\"/>", "1  3\" y=\"4\">\n    <axis/>\n  </joint>\n  <link/>")
            .replace("name = 'a&amp;b'", "id = 'c'");
        let written = rewritten(Path::new("a.urdf"), &bytes, &source.root, &root);
        assert_eq!(String::from_utf8_lossy(&written[..expected.len()]), expected);
    }
}
