//! The way of a touch over the skin: the receptors that fired one after the other.

use nalgebra::Vector3;

use super::firing::{Firing, SILENCE};
use super::mapped_skin::MappedSkin;
use super::{LimbSensation, SensationSide};

/// What fires together for less than this is no stay, seconds: a touch cuts a corner, or begins to press.
const PASSING: f64 = 0.02;
/// How far a touch may go on that leaves a receptor, metres: over a hole between patches, …
const HOLE: f64 = 0.02;
/// … or straight ahead where the map has no neighbour.
const BARE: f64 = 0.05;
/// How long it is waited for there at the most, seconds.
pub(super) const LONGEST: f64 = 0.2;

/// One side of what is being followed.
#[derive(Clone, Debug, Default)]
pub(super) struct Trail {
    /// In the order in which they began.
    firings: Vec<Firing>,
}

/// What fired together for a while.
#[derive(Clone, Debug)]
struct Stay {
    /// In their order.
    receptors: Vec<usize>,
    /// The one that began last.
    newest: usize,
    span: [f64; 2],
}

impl Stay {
    fn lasted(&self) -> f64 {
        self.span[1] - self.span[0]
    }
}

/// Stays of the same receptors one after the other as one.
fn merged(stays: impl Iterator<Item = Stay>) -> Vec<Stay> {
    let mut merged: Vec<Stay> = Vec::new();
    for stay in stays {
        match merged.last_mut() {
            Some(last) if last.receptors == stay.receptors => last.span[1] = stay.span[1],
            _ => merged.push(stay),
        }
    }
    merged
}

/// The receptors that it came to, one after the other.
fn places(stays: &[Stay]) -> Vec<usize> {
    let mut places: Vec<usize> = stays.iter().map(|stay| stay.newest).collect();
    places.dedup();
    places
}

impl Trail {
    /// Takes in the receptors that fire in a step.
    pub fn add(&mut self, time: f64, receptors: impl Iterator<Item = usize>) {
        for receptor in receptors {
            let mut firings = self.firings.iter_mut().rev();
            match firings.find(|firing| firing.receptor == receptor) {
                Some(firing) if time - firing.span[1] <= SILENCE => firing.span[1] = time,
                _ => self.firings.push(Firing { receptor, span: [time; 2] }),
            }
        }
    }

    /// Which receptors fired together, one stay after the other.
    fn stays(&self) -> Vec<Stay> {
        let mut times: Vec<f64> = self.firings.iter().flat_map(|firing| firing.span).collect();
        times.sort_by(f64::total_cmp);
        times.dedup();
        let fire = |span: [f64; 2]| {
            let fires = |firing: &&Firing| firing.span[0] <= span[0] && span[1] <= firing.span[1];
            let mut receptors: Vec<usize> =
                self.firings.iter().filter(fires).map(|firing| firing.receptor).collect();
            let newest = receptors.last().copied()?;
            receptors.sort_unstable();
            Some(Stay { receptors, newest, span })
        };
        let all: Vec<Stay> = times.windows(2).filter_map(|pair| fire([pair[0], pair[1]])).collect();
        let all = merged(all.into_iter());
        let longest = all.iter().map(Stay::lasted).fold(0.0, f64::max);
        merged(all.into_iter().filter(|stay| stay.lasted() >= PASSING.min(longest)))
    }

    /// Whether it went along the skin, and whether it came back to where it had been.
    pub fn moves(&self) -> (bool, bool) {
        let stays = self.stays();
        let back = |row: &&[Stay]| row[0].receptors == row[2].receptors;
        // A straight way may lead over a patch that lies within another, once.
        let within =
            |row: &[Stay]| row[0].receptors.iter().all(|receptor| row[1].receptors.contains(receptor));
        let (over, turns): (Vec<_>, Vec<_>) = stays.windows(3).filter(back).partition(|row| within(row));
        (stays.len() > 1, !turns.is_empty() || over.len() > 1)
    }

    /// How long nothing must touch beyond the release before it has ended, seconds: until it would have got over a hole as
    /// fast as it went. What has not moved is not waited for.
    pub fn patience(&self, skin: &MappedSkin) -> f64 {
        let stays = self.stays();
        let (Some(first), Some(last)) = (stays.first(), stays.last()) else { return 0.0 };
        let places = places(&stays);
        let way: f64 = places.windows(2).map(|pair| skin.way(pair[0], pair[1])).sum();
        let wait = match places[..] {
            [.., from, to] if skin.leads_off(from, to) => BARE,
            [_, _, ..] => HOLE,
            _ => return 0.0,
        };
        (wait * (last.span[1] - first.span[0]) / way).min(LONGEST)
    }

    /// What it was, all in all.
    pub fn side(&self, skin: &MappedSkin, duration: f64) -> SensationSide {
        let stays = self.stays();
        let mut limbs: Vec<(LimbSensation, usize)> = Vec::new();
        let (mut path, mut before) = (0.0, None);
        // Of what lasted a single step there is no stay.
        let alone = self.firings[..1].iter().map(|firing| (firing.receptor, firing.span));
        let places =
            stays.iter().map(|stay| (stay.newest, stay.span)).chain(alone.filter(|_| stays.is_empty()));
        for (receptor, span) in places {
            let (limb, centre) = (skin.limb(receptor), skin.centre(receptor));
            let way = before.map_or(0.0, |before| skin.way(before, receptor));
            let stays_on = before.is_some_and(|before| skin.limb(before) == limb);
            (path, before) = (path + way, Some(receptor));
            match limbs.iter_mut().find(|(part, _)| part.limb == limb) {
                Some((part, first)) => {
                    (part.end, part.span[1]) = (centre, span[1]);
                    part.direction = (centre - skin.centre(*first)).try_normalize(1e-9).unwrap_or_default();
                    part.path += if stays_on { way } else { 0.0 };
                }
                None => {
                    let (path, direction) = (0.0, Vector3::zeros());
                    let part = LimbSensation { limb, point: centre, end: centre, span, path, direction };
                    limbs.push((part, receptor));
                }
            }
        }
        let mut receptors: Vec<(usize, [f64; 2])> = Vec::new();
        for firing in &self.firings {
            match receptors.iter_mut().find(|(receptor, _)| *receptor == firing.receptor) {
                Some((_, span)) => span[1] = firing.span[1],
                None => receptors.push((firing.receptor, firing.span)),
            }
        }
        let limbs: Vec<LimbSensation> = limbs.into_iter().map(|(part, _)| part).collect();
        SensationSide {
            limb: limbs[0].limb,
            last_limb: before.map_or(limbs[0].limb, |last| skin.limb(last)),
            receptors,
            path,
            speed: if duration > 0.0 { path / duration } else { 0.0 },
            limbs,
        }
    }
}
