//! The engine's error messages about a file, rewritten to refer to the user's file.

use super::tree::{Element, Place};
use super::write::{Texts, numbered};
use crate::mujoco::Version;

/// What the engine says of a tree.
#[derive(Clone, Debug)]
pub(super) struct Complaint {
    /// Its words, without where; with the element where it is known.
    pub message: String,
    /// The same without the element.
    pub words: String,
    /// The user's file and the line in it.
    pub place: Option<Place>,
    /// The number of the element in the tree, where it is known.
    pub element: Option<usize>,
}

impl Complaint {
    /// Finds what the engine's words are about in the tree that it was given.
    pub fn new(words: &str, root: &mut Element, texts: &Texts) -> Complaint {
        let words = words.trim_start_matches("XML Error: ").trim_start_matches("Error: ");
        let (line, kept) = cut(words);
        let number = line.and_then(|line| texts.element_in_line(line));
        let element = match number {
            Some(number) => numbered(root, number).map(|element| &*element),
            None => sensor(words, root),
        };
        let message = element.map_or(kept.clone(), |element| format!("{}: {kept}", element.title()));
        let place = element.and_then(|element| element.place.clone());
        Complaint { message, words: kept, place, element: number }
    }
}

/// The sensor that the engine's words are about: of sensors it tells no line, but their number.
fn sensor<'e>(words: &str, root: &'e Element) -> Option<&'e Element> {
    let (_, number) = words.rsplit_once("id = ").filter(|_| words.contains("sensor"))?;
    let elements = |element: &'e Element| element.children.iter();
    elements(root)
        .filter(|section| section.name == "sensor")
        .flat_map(elements)
        .nth(number.trim().parse().ok()?)
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
    // Of a repeated name it tells the place in a list of its own; of a mesh it guesses.
    let end = [", position ", "; perhaps "].into_iter().filter_map(|mark| words.find(mark)).min();
    let words = &words[..end.unwrap_or(words.len())];
    let Some((before, rest)) = words.split_once(" (id = ") else { return words.to_string() };
    let Some((_, after)) = rest.split_once(')') else { return words.to_string() };
    let is_thing = |thing: &str| thing.ends_with('\'') && thing.split_whitespace().count() <= 2;
    let things = [": ", " in "].into_iter().filter_map(|mark| before.rsplit_once(mark));
    let thing = { things }.find(|(_, thing)| after.is_empty() && is_thing(thing));
    thing.map_or_else(|| format!("{before}{after}"), |(before, _)| before.to_string())
}

/// What of the engine's words asks for what; the first that fits counts.
const MENDS: [(&str, &str); 33] = [
    ("Could not allocate memory", "give it fewer bodies, or this process more memory"),
    ("repeated name in", "another has this name: rename one"),
    ("sizes must be positive", "give it a size=\"…\" of numbers above 0"),
    ("size 0 must be positive", "give it a size=\"…\" of numbers above 0"),
    ("axis too small", "give it an axis that is not zero"),
    (
        "free joint can only be used on top level",
        "put its body into the world itself, or take three slides and a ball",
    ),
    ("World body cannot have joints", "put it into a <body>"),
    ("range[0] should be smaller", "give the lower limit first, then a higher one"),
    ("range[0] should be 0", "give the range of a ball as \"0 ANGLE\""),
    ("not have enough data", "give it more numbers"),
    ("too much data", "give it fewer numbers"),
    ("problem reading attribute", "give it numbers, with decimal points and spaces between them"),
    ("single int expected", "give it one whole number"),
    ("invalid keyword", "give it an MJCF keyword"),
    ("required attribute missing", "add it there"),
    ("mass and inertia cannot be negative", "give it a mass above 0"),
    ("inertia or density are negative", "give it numbers of 0 or above"),
    ("plane and hfield only", "give it another shape, or put it into the world"),
    ("must have valid meshid", "name one of the meshes of <asset> with mesh=\"…\""),
    ("both pos and fromto", "remove one of them"),
    ("fromto requires", "give it one of these shapes, or pos instead of fromto"),
    ("invalid condim", "give 1, 3, 4 or 6"),
    ("is not a fixed child of world", "remove mocap=\"true\", or put it into the world without joints"),
    ("more than 6 dofs", "spread its joints over several bodies"),
    ("followed by rotation", "put that rotation into a body of its own, or leave it out"),
    ("unique sub-element", "remove all but one"),
    ("is repeated in equality", "name another joint, or remove it"),
    ("negative cutoff", "give it a cutoff of 0 or above"),
    ("empty name in mesh", "give it a name or a file"),
    ("repeated default class", "rename one"),
    ("empty class name", "give it class=\"…\""),
    ("unknown default c", "define that class or correct the name"),
    ("multiple orientation", "remove all but one"),
];

/// The engine's words with the fix.
pub(super) fn refusal(message: &str, version: Version) -> String {
    if message.is_empty() {
        return "MuJoCo rejects it without a reason: check that it is an MJCF file".into();
    }
    if message.contains("unrecognized") {
        return format!("{message}; MuJoCo {version} does not know it: correct or remove it there");
    }
    let mend = MENDS.iter().find(|(words, _)| message.contains(words));
    format!("{message}; {}", mend.map_or("correct it there", |(_, mend)| mend))
}
