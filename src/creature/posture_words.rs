//! Postures in words, as people give them: degrees of freedom by their names, in degrees and millimetres.

use super::{Creature, DofKind, Posture};
use crate::named::listed;

/// How far a coordinate may be beyond its range, radians or metres: degrees are rounded.
const PLAY: f64 = 1e-6;

impl Posture {
    /// The posture at the start but for what words such as `left_elbow_flexion=90,neck=0.7:0.7:0:0` say: degrees, millimetres, and of
    /// a ball its quaternion w x y z.
    ///
    /// # Errors
    /// The word that cannot be followed, and why.
    pub fn from_words(creature: &Creature, words: &str) -> Result<Posture, String> {
        let mut posture = Posture::start(creature);
        for word in words.split(',').map(str::trim).filter(|word| !word.is_empty()) {
            set(word, creature, &mut posture).map_err(|message| format!("{word}: {message}"))?;
        }
        creature.couple(&mut posture);
        Ok(posture)
    }
}

/// Sets one degree of freedom by a word such as left_elbow_flexion=90.
fn set(word: &str, creature: &Creature, posture: &mut Posture) -> Result<(), String> {
    let numbers = |text: &str| -> Option<Vec<f64>> {
        let numbers =
            text.split(':').map(|number| number.trim().parse::<f64>().ok().filter(|x| x.is_finite()));
        numbers.collect()
    };
    let (name, numbers) = word
        .split_once('=')
        .and_then(|(name, value)| Some((name.trim(), numbers(value)?)))
        .ok_or("give a name, = and a number, as in left_elbow_flexion=90")?;
    let element = creature.elements().find(|element| element.name == name).ok_or_else(|| {
        // Of many names, those that share a word are the useful ones.
        let words: Vec<&str> = name.split(['_', ' ', '-', '.']).filter(|word| word.len() > 2).collect();
        let shared = |name: &str| words.iter().filter(|word| name.contains(**word)).count();
        let most = creature.dofs().map(|dof| shared(&dof.name)).max().unwrap_or(0);
        let alike = creature.dofs().map(|dof| dof.name.clone()).filter(|name| shared(name) == most);
        let names = listed(&alike.collect::<Vec<_>>());
        format!("{} has no degree of freedom {name}; it has {names}", creature.name())
    })?;
    if let Some(coupling) = element.follows {
        let leader = creature.dofs().nth(coupling.leader).map_or("", |dof| &dof.name);
        return Err(format!("{name} follows {leader}: set {leader}"));
    }
    let (unit, per_unit) = match element.kind {
        DofKind::Slide => (" mm", 1e3),
        DofKind::Hinge | DofKind::Ball => ("°", 1f64.to_degrees()),
    };
    let coordinate = match (element.kind, numbers.as_slice()) {
        (DofKind::Ball, &[w, x, y, z]) => {
            let length = [w, x, y, z].iter().map(|x| x * x).sum::<f64>().sqrt();
            if (length - 1.0).abs() > 0.02 {
                return Err(format!("the quaternion's length is {length:.3}: make it 1"));
            }
            let quaternion = [w, x, y, z].map(|x| x / length);
            element.of_mut(posture).copy_from_slice(&quaternion);
            2.0 * quaternion[0].abs().min(1.0).acos()
        }
        (DofKind::Hinge | DofKind::Slide, &[number]) => {
            posture[element.coordinate()] = number / per_unit;
            number / per_unit
        }
        (DofKind::Ball, _) => return Err(format!("{name} is a ball: give its quaternion as w:x:y:z")),
        _ => return Err(format!("{name} is not a ball: give one number")),
    };
    let [low, high] = element.range;
    if (low - PLAY..=high + PLAY).contains(&coordinate) {
        return Ok(());
    }
    let [x, low, high] =
        [coordinate, low, high].map(|x| format!("{}{unit}", (x * per_unit * 100.0).round() / 100.0));
    Err(format!("{x} is outside its range of {low} to {high}: give a number within"))
}
