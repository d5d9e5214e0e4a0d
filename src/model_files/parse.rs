//! XML as MuJoCo and editors take it, read by a parser that is stricter: what it would refuse is written over beforehand, byte
//! for byte, so that every place stays what it is in the file.

use std::ops::Range;
use std::path::Path;
use std::sync::Arc;

use roxmltree::{Document, Error, Node};

use super::source::Refused;
use super::tree::{Element, Place};

/// How deep elements may lie in each other: what visits a tree goes down by calls.
const GREATEST_DEPTH: usize = 1000;
/// What a file without any element is refused with, or one that begins with something else.
const NO_XML: &str = "it holds no XML: give the path of an MJCF or URDF file";
/// The mark that some editors put before text.
const BYTE_ORDER_MARK: char = '\u{feff}';

/// The one element that a text is.
///
/// # Errors
/// Where it is malformed.
pub(super) fn parse(path: &Path, text: &str) -> Result<Element, Refused> {
    let lines = Lines::new(text);
    let refused =
        |line: usize, message: String| Refused { path: path.to_path_buf(), line: Some(line), message };
    let malformed =
        |line: usize, what: &str| refused(line, format!("malformed XML ({what}); correct it there"));
    if let Some(at) = text.find(|mark: char| mark < ' ' && !mark.is_ascii_whitespace()) {
        let message = "a character there is none of XML; give an MJCF or URDF file, which is text";
        return Err(refused(lines.of(at), message.into()));
    }
    if !text.trim_start_matches(BYTE_ORDER_MARK).trim_start().starts_with('<') {
        return Err(Refused::file(path, NO_XML));
    }
    let Tolerant { text: tolerant, root, unclosed, too_deep } = Tolerant::new(text);
    if let Some(at) = too_deep {
        let message = format!(
            "its elements lie deeper than {GREATEST_DEPTH} in each other; give a chain of fewer bodies"
        );
        return Err(refused(lines.of(at), message));
    }
    let name = |at: Option<usize>| name_at(text, at.unwrap_or_default());
    let document = Document::parse(&tolerant).map_err(|error| {
        let line = error.pos().row as usize;
        match error {
            Error::NoRootNode => Refused::file(path, NO_XML),
            Error::UnclosedRootNode => {
                let line = lines.of(unclosed.unwrap_or_default());
                malformed(line, &format!("<{}> is not closed", name(unclosed)))
            }
            Error::UnknownToken(_) => malformed(line, &format!("there is more after </{}>", name(root))),
            _ => malformed(line, &error.to_string()),
        }
    })?;
    let reader = Reader { text, tolerant: &tolerant, lines: &lines, file: Arc::from(path) };
    let before = document.root().children().filter(Node::is_comment);
    Ok(reader.element(document.root_element(), before.map(|comment| reader.words(comment)).collect()))
}

/// An element's tag, with its prefix.
pub(super) fn name_at(text: &str, at: usize) -> &str {
    let name = &text[at + 1..];
    &name[..name.find(|mark: char| mark.is_whitespace() || "/>".contains(mark)).unwrap_or(name.len())]
}

/// Makes elements of a parser's nodes.
struct Reader<'a> {
    text: &'a str,
    tolerant: &'a str,
    lines: &'a Lines,
    file: Arc<Path>,
}

impl Reader<'_> {
    fn words(&self, comment: Node) -> String {
        let Range { start, end } = comment.range();
        self.text[start + "<!--".len()..end - "-->".len()].to_string()
    }

    fn element(&self, node: Node, comments: Vec<String>) -> Element {
        let at = node.range().start;
        let place = Place { file: self.file.clone(), line: self.lines.of(at), at };
        let mut element = Element { comments, place: Some(place), ..Element::new(name_at(self.text, at)) };
        for attribute in node.attributes() {
            let (name, raw) = (&self.text[attribute.range_qname()], &self.text[attribute.range_value()]);
            // What is no entity is meant as it stands.
            let told = raw == &self.tolerant[attribute.range_value()];
            // MuJoCo takes the first of two attributes of one name.
            if !element.has(name) {
                element.set(name, if told { attribute.value() } else { raw });
            }
        }
        let mut comments = Vec::new();
        for child in node.children() {
            if child.is_comment() {
                comments.push(self.words(child));
            } else if child.is_element() {
                element.children.push(self.element(child, std::mem::take(&mut comments)));
            }
        }
        element.last_comments = comments;
        element
    }
}

/// The lines of a text.
struct Lines(Vec<usize>);

impl Lines {
    fn new(text: &str) -> Lines {
        Lines(text.bytes().enumerate().filter(|(_, byte)| *byte == b'\n').map(|(at, _)| at).collect())
    }

    /// The line of a byte, counted from 1.
    fn of(&self, at: usize) -> usize {
        1 + self.0.partition_point(|end| *end < at)
    }
}

/// A text in which what the parser would refuse is written over.
pub(super) struct Tolerant {
    /// The text, as long as it was.
    pub text: String,
    /// Where its first element begins.
    pub root: Option<usize>,
    /// Where the innermost element begins that is not closed.
    unclosed: Option<usize>,
    /// Where an element begins that is too deep.
    too_deep: Option<usize>,
}

impl Tolerant {
    /// Writes over hyphens in comments, declarations, prefixes of names, attributes that repeat another, and marks in values
    /// that are no entities.
    pub fn new(text: &str) -> Tolerant {
        let mut bytes = text.as_bytes().to_vec();
        let (mut at, mut open) = (0, Vec::new());
        let (mut root, mut too_deep) = (None, None);
        if text.starts_with(BYTE_ORDER_MARK) {
            blank(&mut bytes[..BYTE_ORDER_MARK.len_utf8()]);
        }
        while let Some(begin) = text[at..].find('<').map(|next| at + next) {
            let rest = &text[begin..];
            let up_to = |mark: &str| rest.find(mark).map_or(text.len(), |end| begin + end + mark.len());
            if rest.starts_with("<!--") {
                at = up_to("-->");
                let inside = begin + 4..at.saturating_sub(3).max(begin + 4);
                bytes[inside].iter_mut().filter(|byte| **byte == b'-').for_each(|byte| *byte = b'_');
            } else if rest.starts_with("<![CDATA[") {
                at = up_to("]]>");
            } else if rest.starts_with("<?") {
                at = up_to("?>");
                blank(&mut bytes[begin..at]);
            } else if rest.starts_with("<!") {
                let inner = rest.find('[').filter(|inner| *inner < rest.find('>').unwrap_or(0));
                at = up_to(if inner.is_some() { "]>" } else { ">" });
                blank(&mut bytes[begin..at]);
            } else {
                at = tag(text, begin, &mut bytes);
                root = root.or(Some(begin));
                if rest.starts_with("</") {
                    open.pop();
                } else if !text[..at].ends_with("/>") {
                    open.push(begin);
                    too_deep = too_deep.or((open.len() > GREATEST_DEPTH).then_some(begin));
                }
            }
        }
        let text = String::from_utf8(bytes).unwrap_or_else(|_| text.into());
        Tolerant { text, root, unclosed: open.pop(), too_deep }
    }
}

fn blank(bytes: &mut [u8]) {
    bytes.iter_mut().filter(|byte| **byte != b'\n').for_each(|byte| *byte = b' ');
}

/// Writes over what is in a tag; where it ends.
fn tag(text: &str, begin: usize, bytes: &mut [u8]) -> usize {
    let mut quote = None;
    let mut names: Vec<&str> = Vec::new();
    let mut name_from = None;
    for (i, byte) in text.bytes().enumerate().skip(begin + 1) {
        match (quote, byte) {
            (Some(mark), _) if mark == byte => quote = None,
            (Some(_), b'<') => bytes[i] = b'_',
            (Some(_), b'&') if !is_entity(&text[i..]) => bytes[i] = b'_',
            (Some(_), _) => {}
            (None, b'"' | b'\'') => quote = Some(byte),
            (None, b'>') => return i + 1,
            (None, b':') => bytes[i] = b'_',
            (None, b'=') => {
                let from = name_from.take().unwrap_or(i);
                let name = text[from..i].trim_end();
                if names.contains(&name) {
                    bytes[from] = b'_';
                }
                names.push(name);
            }
            (None, _) if byte.is_ascii_whitespace() => {}
            (None, _) => {
                let begins =
                    text.as_bytes()[i - 1].is_ascii_whitespace() || b"\"'".contains(&text.as_bytes()[i - 1]);
                if begins {
                    name_from = Some(i);
                }
            }
        }
    }
    text.len()
}

/// Whether a text begins with an entity that XML has.
fn is_entity(text: &str) -> bool {
    let Some((name, _)) = text[1..].split_once(';') else { return false };
    let code = name.strip_prefix('#').map(|code| match code.strip_prefix('x') {
        Some(digits) => u32::from_str_radix(digits, 16),
        None => code.parse(),
    });
    match code {
        Some(code) => code.is_ok_and(|code| char::from_u32(code).is_some_and(|mark| mark >= ' ')),
        None => ["amp", "lt", "gt", "quot", "apos"].contains(&name),
    }
}
