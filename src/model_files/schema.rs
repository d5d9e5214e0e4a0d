//! What MJCF the engine knows, as it says itself.

use std::collections::{BTreeMap, BTreeSet};

/// What the engine knows: attributes per element, by the section it is in.
pub(crate) struct Schema {
    attributes: BTreeMap<(String, String), BTreeSet<String>>,
}

impl Schema {
    /// Reads what `mj_printSchema` prints: an element a line, indented by three spaces a level, its attributes from
    /// column 30 on and in further lines.
    pub fn parse(text: &str) -> Schema {
        const COLUMN: usize = 30;
        const INDENT: usize = 3;
        let mut attributes: BTreeMap<(String, String), BTreeSet<String>> = BTreeMap::new();
        let mut path: Vec<String> = Vec::new();
        for line in text.lines() {
            let (head, tail) = line.split_at_checked(COLUMN).unwrap_or((line, ""));
            if let Some(name) = head.split_whitespace().next() {
                let depth = (head.len() - head.trim_start().len()) / INDENT;
                path.truncate(depth);
                path.push(if name == "(world)body" { "body".into() } else { name.to_string() });
            }
            let section = path.get(1).cloned().unwrap_or_default();
            let element = path.last().cloned().unwrap_or_default();
            attributes
                .entry((section, element))
                .or_default()
                .extend(tail.split_whitespace().map(str::to_string));
        }
        Schema { attributes }
    }

    /// Whether an element of a section may have an attribute.
    pub fn knows(&self, section: &str, element: &str, attribute: &str) -> bool {
        let section = if section == "worldbody" { "body" } else { section };
        let known = self.attributes.get(&(section.to_string(), element.to_string()));
        known.is_some_and(|known| known.contains(attribute))
    }
}
