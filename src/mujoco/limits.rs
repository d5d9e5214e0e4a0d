//! Checks on foreign model files before the engine sees them.
//!
//! Of 5,000 mutated files MuJoCo 2.2.2 crashed on some sizes and never returned from others. This
//! reads the XML's attributes, and those of included files, and refuses numbers of that order. It is
//! no parser: whatever is malformed is left for the engine, which says so itself.

use std::collections::HashSet;
use std::path::{Path, PathBuf};

use super::error::{Error, Result};

/// Greatest length, coordinate or scale accepted, in metres: a thousand kilometres.
const GREATEST_LENGTH: f64 = 1e6;

/// Greatest bytes of an XML file; what is large in a model lies in its meshes.
const GREATEST_FILE: u64 = 256 << 20;

/// Attributes that hold lengths, coordinates or scales, in any element.
const LENGTHS: [&str; 21] = [
    "size",
    "pos",
    "fromto",
    "scale",
    "refpos",
    "vertex",
    "spacing",
    "margin",
    "gap",
    "axis",
    "quat",
    "euler",
    "axisangle",
    "xyaxes",
    "zaxis",
    "center",
    "offset",
    "xyz",
    "rpy",
    "radius",
    "length",
];

/// Attributes that hold a count of things the engine makes, with the greatest count accepted; an
/// element of `*` stands for any.
const COUNTS: [(&str, &str, f64); 19] = [
    ("texture", "width", 16384.0),
    ("texture", "height", 16384.0),
    ("texture", "gridsize", 4096.0),
    ("hfield", "nrow", 8192.0),
    ("hfield", "ncol", 8192.0),
    ("composite", "count", 10_000.0),
    ("flexcomp", "count", 10_000.0),
    ("replicate", "count", 10_000.0),
    ("size", "njmax", 100_000.0),
    ("size", "nconmax", 100_000.0),
    ("size", "nstack", 1e8),
    ("size", "nuserdata", 1e6),
    ("size", "nkey", 1e6),
    ("*", "nuser", 1e6),
    ("quality", "shadowsize", 65536.0),
    ("quality", "offsamples", 1024.0),
    ("global", "offwidth", 65536.0),
    ("global", "offheight", 65536.0),
    ("mesh", "maxhullvert", 1e6),
];

/// Checks the model file at `path` and the files that it includes.
///
/// # Errors
/// [`Error::Read`] where the file cannot be read, [`Error::Unsuitable`] for a number out of bounds.
pub(super) fn check_file(path: &Path) -> Result<()> {
    let folder = path.parent().unwrap_or(Path::new("")).to_path_buf();
    let text = read(path)?;
    scan(path, &text, &folder, &mut HashSet::from([path.to_path_buf()]))
}

/// Checks a model's text, called `name` in messages, and the files that it includes.
///
/// # Errors
/// As [`check_file`].
pub(super) fn check_text(name: &Path, text: &str) -> Result<()> {
    scan(name, text, Path::new(""), &mut HashSet::new())
}

/// The text of a model file, whatever its encoding.
fn read(path: &Path) -> Result<String> {
    let refused = |message: String| Error::Read { path: path.to_path_buf(), message };
    let about = std::fs::metadata(path).map_err(|error| match error.kind() {
        std::io::ErrorKind::NotFound => {
            refused("there is no such file; give the path of an MJCF file".into())
        }
        _ => refused(format!("it cannot be read ({error}); give an MJCF file that can")),
    })?;
    if !about.is_file() {
        return Err(refused("it is no regular file; give the path of an MJCF file".into()));
    }
    if about.len() > GREATEST_FILE {
        return Err(refused("it is larger than 256 MiB; give the path of an MJCF file".into()));
    }
    let bytes = std::fs::read(path)
        .map_err(|error| refused(format!("it cannot be read ({error}); give an MJCF file that can")))?;
    Ok(String::from_utf8_lossy(&bytes).into_owned())
}

/// Checks one text, then what it includes; includes are relative to the main file's `folder`.
fn scan(path: &Path, text: &str, folder: &Path, seen: &mut HashSet<PathBuf>) -> Result<()> {
    for tag in Tags::new(text) {
        for (attribute, value) in tag.attributes() {
            let greatest = greatest(tag.name, attribute);
            let unsuitable =
                |message: String| Error::Unsuitable { path: path.to_path_buf(), line: tag.line, message };
            if let Some(greatest) = greatest {
                if let Some(number) = excess(value, greatest) {
                    return Err(unsuitable(format!(
                        "{attribute}=\"{number}\" of <{}> is beyond {greatest}, the greatest that MuJoCo \
                         takes safely; give a smaller number",
                        tag.name
                    )));
                }
            } else if tag.name == "include" && attribute == "file" {
                let included = folder.join(value);
                // An include that cannot be read is the engine's to complain about.
                if seen.insert(included.clone())
                    && let Ok(text) = read(&included)
                {
                    scan(&included, &text, folder, seen)?;
                }
            }
        }
    }
    Ok(())
}

/// The greatest number that an attribute may hold, if it is one of those that matter.
fn greatest(element: &str, attribute: &str) -> Option<f64> {
    let count = COUNTS.iter().find(|(tag, name, _)| {
        (*tag == element || *tag == "*") && (*name == attribute || counts_users(name, attribute))
    });
    match count {
        Some(&(_, _, greatest)) => Some(greatest),
        None => LENGTHS.contains(&attribute).then_some(GREATEST_LENGTH),
    }
}

/// Whether `attribute` is one of `nuser_body`, `nuser_geom`, …
fn counts_users(name: &str, attribute: &str) -> bool {
    name == "nuser" && attribute.starts_with("nuser_")
}

/// The first token of `value` that is a number beyond `greatest`, or that hides one in an entity.
fn excess(value: &str, greatest: f64) -> Option<&str> {
    value.split_ascii_whitespace().find(|token| {
        let beyond = |number: f64| number.is_nan() || number.abs() > greatest;
        token.contains('&') || number(token).is_some_and(beyond)
    })
}

/// The number that `token` begins with, as C reads it.
fn number(token: &str) -> Option<f64> {
    let ends = token.char_indices().map(|(at, mark)| at + mark.len_utf8());
    ends.rev().take(64).find_map(|end| token[..end].parse().ok())
}

/// A start tag.
struct Tag<'t> {
    name: &'t str,
    line: usize,
    rest: &'t str,
}

impl<'t> Tag<'t> {
    /// The attributes with their values as written.
    fn attributes(&self) -> impl Iterator<Item = (&'t str, &'t str)> + use<'t> {
        let mut rest = self.rest;
        std::iter::from_fn(move || {
            let (name, after) = rest.split_once('=')?;
            let quoted = after.trim_start();
            let quote = quoted.chars().next().filter(|mark| matches!(mark, '"' | '\''))?;
            let (value, after) = quoted[1..].split_once(quote)?;
            rest = after;
            Some((name.trim(), value))
        })
    }
}

/// The start tags of an XML text, comments left out.
struct Tags<'t> {
    rest: &'t str,
    line: usize,
}

impl<'t> Tags<'t> {
    fn new(text: &'t str) -> Self {
        Self { rest: text, line: 1 }
    }

    /// Moves on by `bytes`, counting lines.
    fn skip(&mut self, bytes: usize) {
        let (passed, rest) = self.rest.split_at(bytes);
        self.line += passed.bytes().filter(|&byte| byte == b'\n').count();
        self.rest = rest;
    }
}

impl<'t> Iterator for Tags<'t> {
    type Item = Tag<'t>;

    fn next(&mut self) -> Option<Tag<'t>> {
        loop {
            self.skip(self.rest.find('<')?);
            let closing = [("<!--", "-->"), ("<![CDATA[", "]]>"), ("<?", "?>")];
            if let Some((open, close)) = closing.iter().find(|(open, _)| self.rest.starts_with(open)) {
                let end = self.rest[open.len()..].find(close)?;
                self.skip(open.len() + end + close.len());
                continue;
            }
            let line = self.line;
            let body = &self.rest[1..];
            let end = tag_end(body)?;
            self.skip(1 + end);
            let tag = &body[..end];
            let name_end = tag.find(|c: char| c.is_whitespace() || c == '/').unwrap_or(tag.len());
            if name_end > 0 {
                return Some(Tag { name: &tag[..name_end], line, rest: &tag[name_end..] });
            }
        }
    }
}

/// Where a tag ends: the first `>` outside quotes.
fn tag_end(body: &str) -> Option<usize> {
    let mut quote = None;
    for (at, byte) in body.bytes().enumerate() {
        match (quote, byte) {
            (None, b'>') => return Some(at),
            (None, b'"' | b'\'') => quote = Some(byte),
            (Some(mark), _) if mark == byte => quote = None,
            _ => {}
        }
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;

    fn refusal(xml: &str) -> Option<String> {
        check_text(Path::new("hostile.xml"), xml).err().map(|error| error.to_string())
    }

    #[test]
    fn ordinary_models_pass() {
        let xml = "<mujoco><!-- size=\"1e30\" --><asset><texture width='512' height=\"512\"/></asset>\n\
                   <worldbody><geom size=\"1 2 3\" pos='-5 0 1e3' name=\"a>b\"/></worldbody></mujoco>";
        assert_eq!(refusal(xml), None);
    }

    #[test]
    fn hostile_numbers_are_named_with_their_line() {
        let text = refusal("<mujoco>\n<texture width=\"999999999\"/></mujoco>").unwrap();
        assert!(text.contains("hostile.xml, line 2") && text.contains("width"), "{text}");
        for value in ["1e30", "-1e30", "nan", "inf", "0 1e30", "1e30m", "&#49;e30"] {
            let text = refusal(&format!("<geom size='{value}'/>")).unwrap();
            assert!(text.contains("size"), "{text}");
        }
        assert!(refusal("<geom fromto = '0 0 0 0 0 1e30'/>").is_some());
        assert!(refusal("<size nuser_body='999999999'/>").is_some());
    }

    #[test]
    fn malformed_text_is_left_to_the_engine() {
        for xml in ["", "<", "<mujoco", "<!-- ", "<a b=\"", "<a b", "<>", "< >", "<a é='", "</", "<a =''>"] {
            assert_eq!(refusal(xml), None, "{xml}");
        }
    }
}
