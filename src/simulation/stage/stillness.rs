//! Whether all things lie still: then nothing happens until one of them is touched.

/// Steps over which things are watched: those lie still that are …
const WATCH: usize = 30;
/// … no farther from where they were, metres and shares of a turn.
const STILL: f64 = 3e-4;

/// Watches whether anything but the creature moves.
pub struct Stillness {
    still: bool,
    /// Steps since all was looked at, and the engine's coordinates then.
    watched: usize,
    before: Vec<f64>,
}

impl Stillness {
    /// Everything may move yet; the engine has so many coordinates.
    pub fn new(coordinates: usize) -> Stillness {
        Stillness { still: false, watched: 0, before: vec![f64::INFINITY; coordinates] }
    }

    /// Whether all lies still.
    pub fn is_still(&self) -> bool {
        self.still
    }

    /// Something may move from now on.
    pub fn disturb(&mut self) {
        (self.still, self.watched) = (false, 0);
    }

    /// Takes in the engine's coordinates after a step; `own` tells which of them are the creature's.
    pub fn watch(&mut self, qpos: &[f64], own: &[bool]) {
        self.watched += 1;
        if self.watched < WATCH {
            return;
        }
        let moved = qpos.iter().zip(&self.before).zip(own).filter(|(_, own)| !**own);
        self.still = moved.fold(0.0, |most: f64, ((a, b), _)| most.max((a - b).abs())) < STILL;
        self.watched = 0;
        self.before.copy_from_slice(qpos);
    }
}
