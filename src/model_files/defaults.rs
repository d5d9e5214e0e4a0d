//! Default classes: the values of attributes that an element does not give.

use std::collections::BTreeMap;

use super::pose::ORIENTATIONS;
use super::tree::{Element, numbers};

/// The name of the class that all others inherit from.
const MAIN: &str = "main";

/// The default classes of a file: per class and kind of element, its attributes.
#[derive(Clone, Debug, Default)]
pub(super) struct Defaults {
    classes: BTreeMap<String, BTreeMap<String, Element>>,
}

impl Defaults {
    /// Reads all `<default>` sections of a file, in order. The outermost class is the main one, whatever its name.
    ///
    /// # Errors
    /// Where a class has no name or that of another, with the element that should have one.
    pub fn new<'a>(sections: impl Iterator<Item = &'a Element>) -> Result<Defaults, (&'a Element, String)> {
        let mut defaults = Defaults::default();
        defaults.classes.insert(MAIN.into(), BTreeMap::new());
        for (k, section) in sections.enumerate() {
            let name = section.get("class").unwrap_or(MAIN);
            let inherited =
                if k == 0 || name == MAIN { defaults.classes[MAIN].clone() } else { BTreeMap::new() };
            defaults.class(section, name, inherited)?;
            if k == 0 {
                let first = defaults.classes[name].clone();
                defaults.classes.insert(MAIN.into(), first);
            }
        }
        Ok(defaults)
    }

    fn class<'a>(
        &mut self,
        section: &'a Element,
        name: &str,
        inherited: BTreeMap<String, Element>,
    ) -> Result<(), (&'a Element, String)> {
        let mut own = inherited;
        for child in section.children.iter().filter(|e| e.name != "default") {
            let mut merged = child.clone();
            if let Some(before) = own.get(&child.name) {
                inherit(&mut merged, before);
            }
            own.insert(child.name.clone(), merged);
        }
        self.classes.insert(name.to_string(), own.clone());
        for inner in section.all("default") {
            match inner.get("class").unwrap_or_default() {
                "" => return Err((inner, "<default> in another has no class; give it class=\"…\"".into())),
                name if name != MAIN && self.has(name) => {
                    return Err((inner, format!("two classes are called {name}; rename one")));
                }
                name => self.class(inner, name, own.clone())?,
            }
        }
        Ok(())
    }

    /// Whether there is such a class.
    pub fn has(&self, class: &str) -> bool {
        self.classes.contains_key(class)
    }

    /// Writes out what an element has by its own class, or the one that its ancestors gave their children.
    pub fn apply(&self, element: &mut Element, inherited: Option<&str>) {
        let class = element.remove("class");
        let known = [class.as_deref(), inherited].into_iter().flatten().find(|class| self.has(class));
        if let Some(default) = self.classes[known.unwrap_or(MAIN)].get(&element.name) {
            inherit(element, default);
        }
    }
}

/// Gives an element what a default has and it has not. Of a list of numbers that is shorter than its default's, the
/// default has the rest; who gives an orientation undoes that of the default, in whatever way it is given.
fn inherit(element: &mut Element, default: &Element) {
    let turned = ORIENTATIONS.iter().any(|name| element.has(name));
    let placed = element.has("fromto");
    for (name, value) in &default.attributes {
        let pose = ORIENTATIONS.contains(&name.as_str());
        if name == "class" || pose && (turned || placed) || name == "pos" && placed {
            continue;
        }
        match element.get_mut(name) {
            None => {
                element.set(name, value);
            }
            Some(own) => {
                let (given, all) = (numbers(own).len(), value.split_whitespace().collect::<Vec<_>>());
                if given > 0 && given == own.split_whitespace().count() && given < all.len() {
                    *own = format!("{own} {}", all[given..].join(" "));
                }
            }
        }
    }
}
