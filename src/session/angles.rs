//! Angles of a log that look like degrees where radians are meant, or like none of their joint.

use std::f64::consts::TAU;

/// An angle so far beyond its joint's range, radians, is worth a note each …
const FAR: f64 = 1.0;
/// … and one beyond it by a whole turn is refused: it would be another angle with the turn taken off.
const TURN: f64 = TAU;
/// How many rows are named in a note.
const NAMED: usize = 3;

/// What a log tells of one hinge.
pub(crate) struct HingeAngles<'a> {
    /// Its name.
    pub name: &'a str,
    /// Least and greatest angle, radians.
    pub range: [f64; 2],
    /// Line and angle of every touch that tells one, radians.
    pub angles: Vec<(usize, f64)>,
}

impl HingeAngles<'_> {
    /// How far an angle is beyond the range, radians.
    fn beyond(&self, angle: f64) -> f64 {
        (self.range[0] - angle).max(angle - self.range[1]).max(0.0)
    }

    /// The first angle that is beyond a full turn, with its line, where most are that are not zero: zero is zero in any unit.
    /// A range that allows for them is likely to be in degrees itself.
    pub fn degrees(&self) -> Option<(usize, f64)> {
        let turned = || self.angles.iter().filter(|(_, angle)| *angle != 0.0);
        let mut beyond = turned().filter(|(_, angle)| angle.abs() > TAU);
        let example = *beyond.next()?;
        (2 * (1 + beyond.count()) > turned().count()).then_some(example)
    }

    /// The first angle that its joint cannot have, with its line and a sentence.
    pub fn impossible(&self) -> Option<(usize, String)> {
        let (line, angle) = *self.angles.iter().find(|(_, angle)| self.beyond(*angle) > TURN)?;
        let [low, high] = self.range;
        let sentence = format!(
            "{} is {angle}, more than a turn beyond its range of {low:.3} to {high:.3} radians: convert degrees to radians, take \
             whole turns off, mend the range, or leave the touch out",
            self.name
        );
        Some((line, sentence))
    }

    /// Angles that are far beyond the range, as a sentence.
    pub fn note(&self) -> Option<String> {
        let far: Vec<_> = self.angles.iter().filter(|(_, angle)| self.beyond(*angle) > FAR).collect();
        let lines: Vec<String> =
            far.iter().take(NAMED).map(|(line, angle)| format!("{angle} on line {line}")).collect();
        let more = if far.len() > NAMED { format!(" and {} more", far.len() - NAMED) } else { String::new() };
        let [low, high] = self.range;
        (!far.is_empty()).then(|| {
            format!(
                "{} is {}{more}, far beyond its range of {low:.3} to {high:.3} radians: mend them, or the range",
                self.name,
                lines.join(", ")
            )
        })
    }
}

/// Ranges beyond a full turn, as a sentence.
pub(crate) fn wide_ranges<'a>(hinges: impl Iterator<Item = (&'a str, [f64; 2])>) -> Option<String> {
    let wide: Vec<_> =
        { hinges }.filter(|(_, range)| range.iter().any(|end| end.abs() > TAU + 0.01)).collect();
    let (name, [low, high]) = *wide.first()?;
    let others =
        if wide.len() > 1 { format!(" and those of {} more", wide.len() - 1) } else { String::new() };
    Some(format!(
        "the range of {name}, {low} to {high}{others}, goes beyond a full turn of 6.283 radians: if it is in degrees, convert \
         it, and all angles with it"
    ))
}
