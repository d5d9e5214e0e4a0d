//! Quantities by name: what a person says is known of them.

use strsim::levenshtein;

use super::{Knowledge, Robot, Value};

impl Robot {
    /// Says what is known of every quantity, or parameter of one, whose name a pattern matches: `elbow.offset`, `*.axis`,
    /// `left_*.position.x`. A deviation is in the quantity's own unit.
    ///
    /// # Errors
    /// Where nothing is called so, with the names that come nearest.
    pub fn set_knowledge(&mut self, pattern: &str, knowledge: Knowledge) -> Result<(), String> {
        let mut found = false;
        for quantity in &mut self.quantities {
            let whole = matches(pattern, &quantity.name);
            for component in 0..quantity.nominal.size() {
                if !whole && !matches(pattern, &quantity.component_name(component)) {
                    continue;
                }
                if !whole && matches!(quantity.nominal, Value::Direction(_)) {
                    let name = &quantity.name;
                    return Err(format!(
                        "{name} is a single direction: give {pattern} without its last part"
                    ));
                }
                quantity.knowledge[component] = knowledge;
                found = true;
            }
        }
        if found { Ok(()) } else { Err(self.unknown_name(pattern)) }
    }

    fn unknown_name(&self, pattern: &str) -> String {
        let mut names: Vec<&str> = self.quantities.iter().map(|quantity| quantity.name.as_str()).collect();
        names.sort_by_key(|name| levenshtein(pattern, name));
        let near = names[..names.len().min(4)].join(", ");
        format!(
            "{} has nothing called \"{pattern}\": choose from {near} … (* matches any part of a name)",
            self.name
        )
    }
}

/// Whether a name is of a pattern in which `*` stands for any letters.
fn matches(pattern: &str, name: &str) -> bool {
    let Some((first, rest)) = pattern.split_once('*') else { return pattern == name };
    let Some(left) = name.strip_prefix(first) else { return false };
    left.char_indices().map(|(at, _)| at).chain([left.len()]).any(|at| matches(rest, &left[at..]))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn patterns_match_whole_names() {
        assert!(matches("*.offset", "elbow.offset") && matches("left_*.position", "left_hand.position"));
        assert!(matches("*", "anything") && matches("a*b*c", "aXbYc") && !matches("a*b*c", "aXcYb"));
        assert!(!matches("*.offset", "elbow.offsets") && !matches("elbow", "elbow.axis"));
    }
}
