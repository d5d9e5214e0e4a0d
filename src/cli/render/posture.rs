//! A posture from the command line or a file.

use std::collections::BTreeMap;
use std::path::Path;

use serde::Deserialize;

use super::super::Failure;
use crate::creature::{Creature, Dof, DofKind, Posture};
use crate::given_file;

/// How far a coordinate may be beyond its range, radians or metres: degrees are rounded.
const PLAY: f64 = 1e-6;

/// What a file gives for one degree of freedom.
#[derive(Deserialize)]
#[serde(untagged)]
enum Coordinates {
    One(f64),
    Quaternion([f64; 4]),
}

/// A posture as text has it: `NAME=DEG,…`, or the path of a JSON file.
///
/// # Errors
/// A sentence that names the place and the mend, for a name that is not there and a number beyond its range.
pub fn read(text: &str, creature: &Creature) -> Result<Posture, Failure> {
    if text.contains('=') { from_words(text, creature) } else { from_file(Path::new(text), creature) }
}

fn from_words(text: &str, creature: &Creature) -> Result<Posture, Failure> {
    let mut posture = Posture::start(creature);
    for word in text.split(',').map(str::trim).filter(|word| !word.is_empty()) {
        let refuse = |message: String| Failure(format!("--posture {word}: {message}"));
        let number = |number: &str| number.trim().parse::<f64>().ok().filter(|number| number.is_finite());
        let (name, number) = word
            .split_once('=')
            .and_then(|(name, value)| Some((name.trim(), number(value)?)))
            .ok_or_else(|| refuse("give a name, = and a number, as in left_elbow_flexion=90".into()))?;
        let (place, dof) = find(name, creature).map_err(refuse)?;
        let refuse = |message: String| Failure(format!("--posture {word}: {message}"));
        if dof.kind == DofKind::Ball {
            return Err(refuse(format!("{name} is a ball: give its quaternion w x y z in a JSON file")));
        }
        posture[place] = Unit::of(dof).coordinate(number);
        check(dof, &posture[place..]).map_err(refuse)?;
    }
    creature.couple(&mut posture);
    Ok(posture)
}

fn from_file(path: &Path, creature: &Creature) -> Result<Posture, Failure> {
    let place = path.display();
    let text = given_file::read_text(path).map_err(|error| {
        Failure(format!("{place}: {error}: give NAME=DEGREES,… or a JSON file with --posture"))
    })?;
    let entries: BTreeMap<String, Coordinates> = serde_json::from_str(&text).map_err(|error| {
        Failure(format!(
            "{place}: {error}: give an object of names with radians or metres, as in {{\"elbow\": 0.5}}"
        ))
    })?;
    let mut posture = Posture::start(creature);
    for (name, coordinates) in &entries {
        let refuse = |message: String| Failure(format!("{place}, {name}: {message}"));
        let (at, dof) = find(name, creature).map_err(refuse)?;
        match (coordinates, dof.kind) {
            (Coordinates::Quaternion(q), DofKind::Ball) => {
                let length = q.iter().map(|x| x * x).sum::<f64>().sqrt();
                if (length - 1.0).abs() > 1e-3 {
                    return Err(Failure(format!(
                        "{place}, {name}: the quaternion's length is {length:.3}: make it 1"
                    )));
                }
                posture[at..at + 4].copy_from_slice(&q.map(|x| x / length));
            }
            (Coordinates::One(x), DofKind::Hinge | DofKind::Slide) => posture[at] = *x,
            (_, DofKind::Ball) => {
                return Err(Failure(format!(
                    "{place}, {name}: it is a ball: give a quaternion [w, x, y, z]"
                )));
            }
            _ => return Err(Failure(format!("{place}, {name}: it is no ball: give one number"))),
        }
        check(dof, &posture[at..]).map_err(|message| Failure(format!("{place}, {name}: {message}")))?;
    }
    creature.couple(&mut posture);
    Ok(posture)
}

/// A degree of freedom that moves by itself, and the place of its first coordinate.
fn find<'a>(name: &str, creature: &'a Creature) -> Result<(usize, &'a Dof), String> {
    let Some(found) = creature.elements().find(|element| element.name == name) else {
        // Of many names those are worth telling that have a word of it.
        let words: Vec<&str> = name.split(['_', ' ', '-', '.']).filter(|word| word.len() > 2).collect();
        let shared = |dof: &&Dof| words.iter().filter(|word| dof.name.contains(**word)).count();
        let most = creature.dofs().map(|dof| shared(&dof)).max().unwrap_or(0);
        let alike = creature.dofs().filter(|dof| shared(dof) == most).map(|dof| dof.name.clone());
        let names = crate::experiment::words::listed(&alike.collect::<Vec<_>>());
        return Err(format!("{} has no degree of freedom named {name}; it has {names}", creature.name()));
    };
    let dof = found.dof();
    if let Some(coupling) = dof.follows {
        let leader = creature.dofs().nth(coupling.leader).map_or("", |dof| &dof.name);
        return Err(format!("{name} follows {leader}: set that one"));
    }
    Ok((found.coordinate(), dof))
}

/// Whether the coordinates of a degree of freedom are within its range.
fn check(dof: &Dof, coordinates: &[f64]) -> Result<(), String> {
    let [low, high] = dof.range;
    let unit = Unit::of(dof);
    let x = match dof.kind {
        DofKind::Ball => 2.0 * coordinates[0].abs().min(1.0).acos(),
        _ => coordinates[0],
    };
    if (low - PLAY..=high + PLAY).contains(&x) {
        return Ok(());
    }
    let told = [x, low, high].map(|x| unit.told(x));
    Err(format!("{} is beyond its range of {} to {}: give a number within", told[0], told[1], told[2]))
}

/// What a person writes coordinates in.
struct Unit {
    name: &'static str,
    per_unit: f64,
}

impl Unit {
    fn of(dof: &Dof) -> Unit {
        match dof.kind {
            DofKind::Slide => Unit { name: " mm", per_unit: 1e3 },
            DofKind::Hinge | DofKind::Ball => Unit { name: "°", per_unit: 1f64.to_degrees() },
        }
    }

    /// Radians or metres.
    fn coordinate(&self, number: f64) -> f64 {
        number / self.per_unit
    }

    fn told(&self, x: f64) -> String {
        let rounded = (x * self.per_unit * 100.0).round() / 100.0;
        format!("{rounded}{}", self.name)
    }
}
