//! The tree of a model's file: elements that know their file, line and byte, and can be changed.

use std::path::Path;
use std::sync::Arc;

use nalgebra::Vector3;

/// Where an element stands.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Place {
    /// The file.
    pub file: Arc<Path>,
    /// The line in it, counted from 1.
    pub line: usize,
    /// The byte at which the element begins.
    pub at: usize,
    /// The byte behind it.
    pub end: usize,
}

/// An element.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Element {
    /// Its tag.
    pub name: String,
    /// Names and values in the order in which they stand.
    pub attributes: Vec<(String, String)>,
    /// The elements in it.
    pub children: Vec<Element>,
    /// The comments before it.
    pub comments: Vec<String>,
    /// The comments after its last child.
    pub last_comments: Vec<String>,
    /// Where it stands, if it is from a file.
    pub place: Option<Place>,
}

/// An element with attributes in the order given.
pub(crate) fn element(name: &str, attributes: &[(&str, String)]) -> Element {
    let mut element = Element::new(name);
    attributes.iter().for_each(|(name, value)| element.set(name, value));
    element
}

impl Element {
    pub fn new(name: &str) -> Element {
        Element { name: name.into(), ..Element::default() }
    }

    /// An element of children alone.
    pub fn holding(name: &str, children: Vec<Element>) -> Element {
        Element { children, ..Element::new(name) }
    }

    /// The same, at the place of another.
    pub fn placed_as(self, other: &Element) -> Element {
        Element { place: other.place.clone(), ..self }
    }

    /// An attribute's value.
    pub fn get(&self, name: &str) -> Option<&str> {
        self.attributes.iter().find(|(own, _)| own == name).map(|(_, value)| value.as_str())
    }

    /// An attribute's value, to be changed.
    pub fn get_mut(&mut self, name: &str) -> Option<&mut String> {
        self.attributes.iter_mut().find(|(own, _)| own == name).map(|(_, value)| value)
    }

    pub fn has(&self, name: &str) -> bool {
        self.get(name).is_some()
    }

    /// Gives an attribute a value, where it stands or behind all others.
    pub fn set(&mut self, name: &str, value: impl Into<String>) {
        match self.get_mut(name) {
            Some(own) => *own = value.into(),
            None => self.attributes.push((name.into(), value.into())),
        }
    }

    /// Takes an attribute away; its value.
    pub fn remove(&mut self, name: &str) -> Option<String> {
        let at = self.attributes.iter().position(|(own, _)| own == name)?;
        Some(self.attributes.remove(at).1)
    }

    /// The numbers of an attribute; what is none ends them.
    pub fn numbers(&self, name: &str) -> Vec<f64> {
        self.get(name).map(numbers).unwrap_or_default()
    }

    /// The first number of an attribute.
    pub fn number(&self, name: &str) -> Option<f64> {
        self.numbers(name).first().copied()
    }

    /// An attribute of three numbers.
    pub fn vector(&self, name: &str) -> Option<Vector3<f64>> {
        let numbers = self.numbers(name);
        (numbers.len() == 3).then(|| Vector3::from_column_slice(&numbers))
    }

    /// The first child of a name.
    pub fn child(&self, name: &str) -> Option<&Element> {
        self.children.iter().find(|child| child.name == name)
    }

    /// The children of a name.
    pub fn all<'e>(&'e self, name: &'e str) -> impl DoubleEndedIterator<Item = &'e Element> + Clone {
        self.children.iter().filter(move |child| child.name == name)
    }

    /// Their last value of an attribute, which overrides those before it: how a file's settings are read.
    pub fn setting<'e>(&'e self, section: &'e str, name: &str) -> Option<&'e str> {
        self.all(section).filter_map(|child| child.get(name)).next_back()
    }

    /// A child that there is to be one of; it is made where there is none.
    pub fn section(&mut self, name: &str) -> &mut Element {
        let found = self.children.iter().position(|child| child.name == name);
        let at = found.unwrap_or_else(|| {
            // Classes must be known before they are used.
            let at = if name == "default" { 0 } else { self.children.len() };
            self.children.insert(at, Element::new(name));
            at
        });
        &mut self.children[at]
    }

    /// The element in it that stands at a place.
    pub fn at(&mut self, place: &Place) -> Option<&mut Element> {
        if self.place.as_ref() == Some(place) {
            return Some(self);
        }
        self.children.iter_mut().find_map(|child| child.at(place))
    }

    /// Visits it and all in it.
    pub fn each(&mut self, change: &mut dyn FnMut(&mut Element)) {
        change(self);
        self.children.iter_mut().for_each(|child| child.each(change));
    }

    /// It and all in it, in the order of the file.
    pub fn descendants(&self) -> impl Iterator<Item = &Element> {
        let mut due = vec![self];
        std::iter::from_fn(move || {
            let next = due.pop()?;
            due.extend(next.children.iter().rev());
            Some(next)
        })
    }

    /// Removes elements at any depth; how many went.
    pub fn remove_all(&mut self, which: &dyn Fn(&Element) -> bool) -> usize {
        let before = self.children.len();
        self.children.retain(|child| !which(child));
        let gone = before - self.children.len();
        gone + self.children.iter_mut().map(|child| child.remove_all(which)).sum::<usize>()
    }

    /// What a person calls it: its tag, and its name where it has one.
    pub fn title(&self) -> String {
        let name = self.get("name").map(|name| format!(" {name}")).unwrap_or_default();
        format!("<{}>{name}", self.name)
    }
}

/// The numbers in a text; what is none ends them.
pub(super) fn numbers(text: &str) -> Vec<f64> {
    text.split_whitespace().map_while(|number| number.parse().ok()).collect()
}

/// Whether a word is one of those in a text.
pub(super) fn is_of(words: &str, word: &str) -> bool {
    words.split(' ').any(|other| other == word)
}
