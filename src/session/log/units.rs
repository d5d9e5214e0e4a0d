//! The units that columns and deviations are given in, in any spelling.

/// What a number measures.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Measure {
    Length,
    Angle,
}

impl Measure {
    /// As a noun, and the units that a column may have.
    pub fn in_words(self) -> (&'static str, &'static str) {
        match self {
            Measure::Length => ("a length", "m, cm or mm"),
            Measure::Angle => ("an angle", "rad or deg"),
        }
    }
}

/// A unit of length or angle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Unit {
    /// What it measures.
    pub measure: Measure,
    /// How many of it make a metre or a radian.
    pub per: f64,
}

/// Degrees in a radian.
const DEGREES: f64 = 180.0 / std::f64::consts::PI;

/// Units by their words in small letters, what they measure, and how many make a metre or a radian.
const UNITS: [(&[&str], Measure, f64); 6] = [
    (&["m", "meter", "meters", "metre", "metres"], Measure::Length, 1.0),
    (&["cm", "centimeter", "centimeters", "centimetre", "centimetres"], Measure::Length, 100.0),
    (&["mm", "millimeter", "millimeters", "millimetre", "millimetres"], Measure::Length, 1000.0),
    (&["rad", "rads", "radian", "radians"], Measure::Angle, 1.0),
    (&["mrad"], Measure::Angle, 1000.0),
    (&["deg", "degs", "degree", "degrees", "°", "º"], Measure::Angle, DEGREES),
];
/// Bytes of a unit at most, with what is around it.
const LONGEST: usize = 40;
/// What may stand between a name and its unit.
const SEPARATORS: [char; 6] = [' ', '_', '-', '.', '/', ','];
/// Brackets that a unit may stand in.
const BRACKETS: [(char, char); 4] = [('[', ']'), ('(', ')'), ('{', '}'), ('<', '>')];

/// The unit of a word, in any spelling.
pub(crate) fn unit(word: &str) -> Option<Unit> {
    let word = word.trim().trim_end_matches('.').to_lowercase();
    let (_, measure, per) = *UNITS.iter().find(|(words, ..)| words.contains(&word.as_str()))?;
    Some(Unit { measure, per })
}

/// A title's name and the unit behind it, as in `elbow_deg`, `elbow [Deg]`, `elbowDeg` or `ax / mm`; of a unit in brackets
/// that is not known the word.
pub(crate) fn name_and_unit(title: &str) -> Option<(&str, Result<Unit, &str>)> {
    // A unit is short, and a title may be a whole file.
    let begin = title.len().saturating_sub(LONGEST);
    title.char_indices().skip(1).filter(|(at, _)| *at >= begin).find_map(|(at, first)| {
        let (name, rest) = title.split_at(at);
        let word = rest.trim_start_matches(SEPARATORS);
        let inside = BRACKETS.iter().find_map(|(open, close)| word.strip_prefix(*open)?.strip_suffix(*close));
        if let Some(inside) = inside {
            return Some((name, unit(inside).ok_or(inside)));
        }
        let humped = first.is_uppercase() && !name.ends_with(char::is_uppercase);
        let apart = word.len() < rest.len() || humped || first == '°';
        let word = word.strip_prefix("in ").unwrap_or(word);
        unit(word).filter(|_| apart).map(|unit| (name, Ok(unit)))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn units_are_read_in_any_spelling() {
        let all = "elbow_deg|elbow [deg]|elbow (deg)|elbow[°]|elbow [Deg]|elbow_DEG|elbow (Degrees)|elbowDeg|elbow°|elbow / deg|\
                   elbow, deg.|elbow-degree|elbow {deg}|elbow in deg|elbow_[deg]|elbow deg";
        for title in all.split('|') {
            let unit = Unit { measure: Measure::Angle, per: DEGREES };
            assert_eq!(name_and_unit(title), Some(("elbow", Ok(unit))), "{title}");
        }
        for (title, per) in
            [("ax_mm", 1000.0), ("ax [MM]", 1000.0), ("ax (Cm)", 100.0), ("axMM", 1000.0), ("ax/metres", 1.0)]
        {
            let unit = Unit { measure: Measure::Length, per };
            assert_eq!(name_and_unit(title), Some(("ax", Ok(unit))), "{title}");
        }
        assert_eq!(name_and_unit("elbow [grad]"), Some(("elbow", Err("grad"))));
        for title in ["elbow", "left_arm", "m", "deg", "ARM", "alarm"] {
            assert_eq!(name_and_unit(title), None, "{title}");
        }
    }
}
