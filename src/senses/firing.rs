//! Receptor firings with their times: touches without the receptors' positions.

use super::SkinContact;

/// How long a receptor must be silent before it has ceased to fire, seconds: a probe that bounces comes back sooner.
const SILENCE: f64 = 0.03;

/// A receptor that fired without a pause.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Firing {
    /// The receptor.
    pub receptor: usize,
    /// When it fired first and last, seconds.
    pub span: [f64; 2],
}

/// Adds the receptors that fire in a step at `time`, seconds, later than the last one: a receptor fires on or anew.
pub(super) fn fire(firings: &mut Vec<Firing>, time: f64, receptors: impl Iterator<Item = usize>) {
    for receptor in receptors {
        match firings.iter_mut().rev().find(|firing| firing.receptor == receptor) {
            Some(firing) if time - firing.span[1] <= SILENCE => firing.span[1] = time,
            _ => firings.push(Firing { receptor, span: [time; 2] }),
        }
    }
}

/// Follows which receptors fire.
#[derive(Clone, Debug, Default)]
pub struct FiringRecorder {
    firing: Vec<Firing>,
}

impl FiringRecorder {
    /// Takes in the contacts of one step at `time`, seconds, later than the last one: what has ceased to fire.
    pub fn step(&mut self, time: f64, contacts: &[SkinContact]) -> Vec<Firing> {
        let ceased = self.firing.extract_if(.., |firing| time - firing.span[1] > SILENCE).collect();
        fire(&mut self.firing, time, contacts.iter().flat_map(SkinContact::spots).map(|spot| spot.receptor));
        ceased
    }

    /// What still fires, where nothing comes after it.
    pub fn rest(self) -> Vec<Firing> {
        self.firing
    }
}
