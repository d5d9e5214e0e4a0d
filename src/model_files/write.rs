//! Writing a tree as XML: an element a line, so that a line shows which element it is.

use super::tree::Element;

/// Elements lie in each other at most so deep in one text: MuJoCo's XML reader takes 100 levels.
const DEEPEST: usize = 80;

/// A text with entities for the marks of XML.
pub(crate) fn escape(text: &str) -> String {
    let marks = [("&", "&amp;"), ("<", "&lt;"), (">", "&gt;"), ("\"", "&quot;"), ("'", "&apos;")];
    marks.iter().fold(text.to_string(), |text, (mark, entity)| text.replace(mark, entity))
}

/// Numbers to the last digit: they read back as the very same.
pub(crate) fn exact<'a>(values: impl IntoIterator<Item = &'a f64>) -> String {
    // Adding zero turns -0 into 0.
    values.into_iter().map(|value| (value + 0.0).to_string()).collect::<Vec<_>>().join(" ")
}

/// The text of a file, indented by two spaces.
pub(crate) fn write(root: &Element) -> String {
    let mut text = String::new();
    element(root, 0, &mut text);
    text
}

fn element(one: &Element, depth: usize, text: &mut String) {
    comments(&one.comments, depth, text);
    let indent = "  ".repeat(depth);
    text.push_str(&format!("{indent}{}", start(one)));
    if one.children.is_empty() && one.last_comments.is_empty() {
        return text.push_str("/>\n");
    }
    text.push_str(">\n");
    one.children.iter().for_each(|child| element(child, depth + 1, text));
    comments(&one.last_comments, depth + 1, text);
    text.push_str(&format!("{indent}</{}>\n", one.name));
}

fn comments(all: &[String], depth: usize, text: &mut String) {
    all.iter().for_each(|words| text.push_str(&format!("{}<!--{words}-->\n", "  ".repeat(depth))));
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
}

impl Texts {
    /// Writes a tree; `name` is that of the first text.
    pub fn new(root: &Element, name: &str) -> Texts {
        let mut texts =
            Texts { texts: vec![(name.to_string(), String::new())], lines: Vec::new(), elements: 0 };
        texts.element(root, 0, 0);
        texts
    }

    /// The number of the element in a line of the first text, counted from 1.
    pub fn element_in_line(&self, line: usize) -> Option<usize> {
        *self.lines.get(line.checked_sub(1)?)?
    }

    fn push(&mut self, text: usize, words: &str, element: Option<usize>) {
        self.texts[text].1.push_str(words);
        if text == 0 {
            self.lines.push(element);
        }
    }

    fn element(&mut self, one: &Element, depth: usize, text: usize) {
        let number = self.elements;
        if depth > DEEPEST {
            let part = self.texts.len();
            let name = format!("part{part}.xml");
            self.push(text, &format!("<include file=\"{name}\"/>\n"), Some(number));
            self.texts.push((name, "<mujocoinclude>\n".into()));
            self.element(one, 1, part);
            self.texts[part].1.push_str("</mujocoinclude>\n");
            return;
        }
        self.elements += 1;
        let tag = start(one);
        if one.children.is_empty() {
            return self.push(text, &format!("{tag}/>\n"), Some(number));
        }
        self.push(text, &format!("{tag}>\n"), Some(number));
        one.children.iter().for_each(|child| self.element(child, depth + 1, text));
        self.push(text, &format!("</{}>\n", one.name), None);
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
