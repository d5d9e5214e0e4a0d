//! Writing a tree as XML: an element a line, so that a line shows which element it is.

pub(crate) use quick_xml::escape::escape;

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
