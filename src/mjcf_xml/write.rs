//! Writing a tree as XML: an element a line, so that a line says which element it is.

use xmltree::{Element, XMLNode};

use quick_xml::escape::escape;

/// Elements lie in each other at most so deep in one text: MuJoCo's XML reader takes 100 levels.
const DEEPEST: usize = 80;

/// The text of a file, indented by two spaces.
pub(crate) fn write(root: &Element) -> String {
    let mut text = String::new();
    element(root, 0, &mut text);
    text
}

fn element(one: &Element, depth: usize, text: &mut String) {
    start(one, depth, text);
    if one.children.is_empty() {
        text.push_str("/>\n");
        return;
    }
    text.push_str(">\n");
    for child in &one.children {
        match child {
            XMLNode::Element(child) => element(child, depth + 1, text),
            other => node(other, depth + 1, text),
        }
    }
    end(one, depth, text);
}

fn indent(depth: usize, text: &mut String) {
    text.extend(std::iter::repeat_n("  ", depth));
}

/// A start tag without its end.
fn start(element: &Element, depth: usize, text: &mut String) {
    indent(depth, text);
    text.push('<');
    text.push_str(&element.name);
    for (name, value) in &element.attributes {
        text.push_str(&format!(" {name}=\"{}\"", escape(value.as_str()).replace(['\n', '\r', '\t'], " ")));
    }
}

fn end(element: &Element, depth: usize, text: &mut String) {
    indent(depth, text);
    text.push_str(&format!("</{}>\n", element.name));
}

/// What is no element, in lines of its own.
fn node(node: &XMLNode, depth: usize, text: &mut String) {
    let words = match node {
        XMLNode::Comment(words) => format!("<!--{words}-->"),
        XMLNode::Text(words) | XMLNode::CData(words) => escape(words.as_str()).into_owned(),
        XMLNode::Element(_) | XMLNode::ProcessingInstruction(..) => return,
    };
    indent(depth, text);
    text.push_str(&words);
    text.push('\n');
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
        let mut tag = String::new();
        start(one, 0, &mut tag);
        let children: Vec<&Element> = one.children.iter().filter_map(XMLNode::as_element).collect();
        if children.is_empty() {
            return self.push(text, &format!("{tag}/>\n"), Some(number));
        }
        self.push(text, &format!("{tag}>\n"), Some(number));
        children.into_iter().for_each(|child| self.element(child, depth + 1, text));
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
        element.children.iter_mut().filter_map(XMLNode::as_mut_element).find_map(|child| within(child, left))
    }
    within(root, &mut { number })
}
