//! Quantities by name: what a person says is known of them.

use strsim::levenshtein;

use super::{Knowledge, Robot};

/// A sentence about a name that says nothing.
pub type NamingFault = String;

impl Robot {
    /// Says what is known of every quantity, or parameter of one, whose name a pattern matches: `elbow.offset`, `*.axis`,
    /// `left_*.position.x`. A deviation is in the quantity's own unit.
    ///
    /// # Errors
    /// Where nothing is called so, with the names that come nearest.
    pub fn set_knowledge(&mut self, pattern: &str, knowledge: Knowledge) -> Result<(), NamingFault> {
        let mut found = false;
        for quantity in &mut self.quantities {
            let size = quantity.nominal.size();
            if matches(pattern, &quantity.name) {
                quantity.knowledge[..size].fill(knowledge);
                found = true;
                continue;
            }
            let direction = quantity.components() == ["u", "v"];
            for component in 0..size {
                if matches(pattern, &quantity.component_name(component)) {
                    if direction {
                        return Err(format!(
                            "{} is one direction: say {pattern} without its last part",
                            quantity.name
                        ));
                    }
                    quantity.knowledge[component] = knowledge;
                    found = true;
                }
            }
        }
        if found { Ok(()) } else { Err(self.unknown_name(pattern)) }
    }

    fn unknown_name(&self, pattern: &str) -> NamingFault {
        let mut names: Vec<&str> = self.quantities.iter().map(|quantity| quantity.name.as_str()).collect();
        names.sort_by_key(|name| levenshtein(pattern, name));
        let near = names[..names.len().min(4)].join(", ");
        format!(
            "nothing of {} is called \"{pattern}\": name one of {near} … (* stands for any part of a name)",
            self.name
        )
    }
}

/// Whether a name is of a pattern in which `*` stands for any letters.
fn matches(pattern: &str, name: &str) -> bool {
    let Some((first, rest)) = pattern.split_once('*') else { return pattern == name };
    let Some(mut left) = name.strip_prefix(first) else { return false };
    let mut parts: Vec<&str> = rest.split('*').collect();
    let last = parts.pop().unwrap_or_default();
    for part in parts {
        match left.find(part) {
            Some(at) => left = &left[at + part.len()..],
            None => return false,
        }
    }
    left.ends_with(last)
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
