//! The engine's words about a file, told of the user's own file.

use std::path::PathBuf;

use xmltree::Element;

use super::engine::Version;
use crate::mjcf_xml::{Files, Texts, attribute, numbered};

/// What the engine says of a tree.
#[derive(Clone, Debug)]
pub(super) struct Complaint {
    /// Its words, without where; with the element where it is known.
    pub message: String,
    /// The user's file and the line in it.
    pub place: Option<(PathBuf, usize)>,
    /// The number of the element in the tree, where it is known.
    pub element: Option<usize>,
}

impl Complaint {
    /// Finds what the engine's words are about in the tree that it was given.
    pub fn new(words: &str, root: &mut Element, texts: &Texts, files: &Files) -> Complaint {
        let words = words.trim_start_matches("XML Error: ").trim_start_matches("Error: ");
        let (line, mut message) = cut(words);
        let number = line.and_then(|line| texts.element_in_line(line));
        let element = number.and_then(|number| numbered(root, number));
        if let Some(element) = &element {
            let name = attribute(element, "name").map(|name| format!(" {name}")).unwrap_or_default();
            message = format!("<{}>{name}: {message}", element.name);
        }
        let place = element.and_then(|element| files.place(element));
        Complaint { message, place: place.map(|(path, line)| (path.to_path_buf(), line)), element: number }
    }
}

/// Takes the engine's account of where out of its words: the line of the text that it was given, and the rest.
fn cut(words: &str) -> (Option<usize>, String) {
    let number = |after: &str| {
        let (_, rest) = words.rsplit_once(after)?;
        let digits: String =
            rest.trim_start_matches([' ', '=']).chars().take_while(char::is_ascii_digit).collect();
        digits.parse::<usize>().ok()
    };
    let line = number(", line").or_else(|| number("line="));
    let end =
        [", Object name =", ", Element '", ", Element name"].iter().filter_map(|mark| words.find(mark)).min();
    let kept = words[..end.unwrap_or(words.len())].trim_start_matches("Schema violation: ");
    (line, unnumbered(kept.trim_end_matches(['.', ',', ' '])))
}

/// Words without the engine's numbers of things, and without the thing itself where they end with it: it is named
/// before them.
fn unnumbered(words: &str) -> String {
    let Some((before, rest)) = words.split_once(" (id = ") else { return words.to_string() };
    let Some((_, after)) = rest.split_once(')') else { return words.to_string() };
    let thing = before.rsplit_once(" in ").filter(|(_, thing)| after.is_empty() && thing.ends_with('\''));
    thing.map_or_else(|| format!("{before}{after}"), |(before, _)| before.to_string())
}

/// What of the engine's words asks for what; the first that fits counts.
const MENDS: [(&str, &str); 14] = [
    ("repeated name", "another has this name: rename one"),
    ("sizes must be positive", "give it a size=\"…\" of numbers above 0"),
    ("size 0 must be positive", "give it a size=\"…\" of numbers above 0"),
    ("axis too small", "give it an axis that is not zero"),
    (
        "free joint can only be used on top level",
        "put its body into the world itself, or take three slides and a ball",
    ),
    ("World body cannot have joints", "put it into a <body>"),
    ("range[0] should be smaller", "give the lower limit first"),
    ("range[0] should be 0", "give the range of a ball as \"0 ANGLE\""),
    ("not have enough data", "give it more numbers"),
    ("too much data", "give it fewer numbers"),
    ("problem reading attribute", "give it numbers"),
    ("invalid keyword", "give it a word that MJCF has"),
    ("required attribute missing", "add it there"),
    ("mass and inertia cannot be negative", "give it a mass above 0"),
];

/// The engine's words with the mend.
pub(super) fn refusal(message: &str, version: Version) -> String {
    if message.is_empty() {
        return "MuJoCo refuses it without a word: check that it is an MJCF file".into();
    }
    if message.contains("unrecognized") {
        return format!("{message}; MuJoCo {version} does not know it: correct or remove it there");
    }
    let mend = MENDS.iter().find(|(words, _)| message.contains(words));
    format!("{message}; {}", mend.map_or("correct it there", |(_, mend)| mend))
}
