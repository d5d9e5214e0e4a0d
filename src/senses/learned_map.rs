//! The somatotopic map from experience: receptors that fire one after the other under strokes are neighbours.
//!
//! What is known is which limb each receptor is on and when it fired; places, sizes and speeds are not. A stroke is
//! what fires without a pause, over joints, too. Strokes differ in how fast they are, so each is given a pace, under
//! which a receptor takes the same time in all of them: then times between receptors are as good as distances along
//! the skin. The nearest are linked, at most eight to each, as the geometry would: near is measured by how far apart
//! receptors of the same limbs are that fired one right after the other, for a hand's are smaller than a back's.

use std::collections::BTreeMap;

use super::Firing;
use crate::skin::SomatotopicMap;

/// How long all must be silent before a stroke has ended, seconds.
const PAUSE: f64 = 0.06;
/// Firings that are shorter say nothing about a stroke's pace, seconds: the probe cut a corner.
const PASSING: f64 = 0.01;
/// Rounds in which paces and widths are made to agree.
const ROUNDS: usize = 30;
/// How many receptors of their limb's mean width a receptor, or a stroke, is taken to have been before it was.
const PRIOR: f64 = 2.0;
/// How many receptors later in a stroke one is still related to.
const WITHIN: usize = 6;
/// Of the distances of two receptors in several strokes, this share is shorter than the one that counts: ways may be
/// round about, and none is shorter than the straight one.
const SHARE: f64 = 0.35;
/// Receptors are linked up to this many times their limbs' mean distance between those that fired in succession. On squares
/// these are 0.8 sides apart by the measure here and diagonal ones 1.26: it reaches nearly that far, as the geometry does.
const REACH: f64 = 1.45;
/// Pairs on a limb that fired in succession from which on they tell its unit: a finger's bone has one, of front and back.
const FEW: f64 = 4.0;
/// So much nearer, in the same unit, two receptors are taken to be when one has fired right after the other.
const SUCCESSION: f64 = 0.6;

/// A map that was learned, and from how much.
#[derive(Clone, Debug, PartialEq)]
pub struct LearnedMap {
    /// The neighbours.
    pub map: SomatotopicMap,
    /// Per receptor, how often it fired.
    pub firings: Vec<usize>,
    /// Strokes.
    pub strokes: usize,
}

/// A stroke: firings in the order of their middles.
struct Stroke {
    firings: Vec<Firing>,
    /// Width of skin that it passes in a second, in a unit of all.
    pace: f64,
}

/// Learns the map of receptors, each on its limb, from firings in any order. Firings of receptors that there are not
/// are left out.
pub fn learn_map(limbs: &[usize], firings: &[Firing]) -> LearnedMap {
    let firings = firings.iter().copied().filter(|firing| firing.receptor < limbs.len());
    let firings: Vec<Firing> = firings.collect();
    let mut fired = vec![0; limbs.len()];
    firings.iter().for_each(|firing| fired[firing.receptor] += 1);
    let mut strokes = strokes_of(firings);
    agree(&mut strokes, limbs);
    let mut links = links_of(&strokes, limbs);
    links.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    let map = SomatotopicMap::of_links(limbs.len(), links.into_iter().map(|(_, pair)| pair));
    LearnedMap { map, firings: fired, strokes: strokes.len() }
}

/// Parts the firings where all is silent.
fn strokes_of(mut firings: Vec<Firing>) -> Vec<Stroke> {
    firings.sort_by(|a, b| a.span[0].total_cmp(&b.span[0]).then(a.receptor.cmp(&b.receptor)));
    let mut strokes: Vec<Stroke> = Vec::new();
    let mut last = f64::NEG_INFINITY;
    for firing in firings {
        match strokes.last_mut() {
            Some(stroke) if firing.span[0] - last <= PAUSE => stroke.firings.push(firing),
            _ => strokes.push(Stroke { firings: vec![firing], pace: 1.0 }),
        }
        last = last.max(firing.span[1]);
    }
    for stroke in &mut strokes {
        stroke.firings.sort_by(|a, b| middle(a).total_cmp(&middle(b)).then(a.receptor.cmp(&b.receptor)));
    }
    strokes
}

fn middle(firing: &Firing) -> f64 {
    0.5 * (firing.span[0] + firing.span[1])
}

fn lasted(firing: &Firing) -> f64 {
    firing.span[1] - firing.span[0]
}

impl Stroke {
    /// Firings that were begun and ended by the stroke's way, not by its own beginning and end.
    fn crossings(&self) -> impl Iterator<Item = &Firing> {
        let inner = self.firings.get(1..self.firings.len().saturating_sub(1)).unwrap_or_default();
        inner.iter().filter(|firing| lasted(firing) > PASSING)
    }
}

/// Sums of values and how many they are, by a key and of all.
#[derive(Default)]
struct Means {
    by_key: BTreeMap<usize, [f64; 2]>,
    all: [f64; 2],
}

impl Means {
    fn add(&mut self, key: usize, value: f64) {
        for [sum, count] in [self.by_key.entry(key).or_default(), &mut self.all] {
            (*sum, *count) = (*sum + value, *count + 1.0);
        }
    }

    fn sum_and_count(&self, key: usize) -> [f64; 2] {
        self.by_key.get(&key).copied().unwrap_or_default()
    }

    /// The mean for a key; that of all where it has none.
    fn of(&self, key: usize) -> f64 {
        let [sum, count] = self.by_key.get(&key).unwrap_or(&self.all);
        sum / count
    }
}

/// Gives strokes their paces: a receptor is as wide in every stroke.
fn agree(strokes: &mut [Stroke], limbs: &[usize]) {
    for _ in 0..ROUNDS {
        let (mut of_receptors, mut of_limbs) = (Means::default(), Means::default());
        for stroke in strokes.iter() {
            for firing in stroke.crossings() {
                let width = stroke.pace * lasted(firing);
                of_receptors.add(firing.receptor, width);
                of_limbs.add(limbs[firing.receptor], width);
            }
        }
        if of_limbs.all[1] == 0.0 {
            return;
        }
        let usual_width = |receptor: usize| of_limbs.of(limbs[receptor]);
        let width = |receptor: usize| {
            let [sum, count] = of_receptors.sum_and_count(receptor);
            (sum + PRIOR * usual_width(receptor)) / (count + PRIOR)
        };
        let mut paces: Vec<f64> = strokes.iter().map(|stroke| stroke.pace).collect();
        paces.sort_by(f64::total_cmp);
        let usual = paces[paces.len() / 2];
        for stroke in strokes.iter_mut() {
            let seconds: f64 = stroke.crossings().map(lasted).sum();
            let passed: f64 = stroke.crossings().map(|firing| width(firing.receptor)).sum();
            let count = stroke.firings.len() as f64;
            let mean = stroke.firings.iter().map(|firing| usual_width(firing.receptor)).sum::<f64>() / count;
            stroke.pace = (passed + PRIOR * mean) / (seconds + PRIOR * mean / usual);
        }
        // Only ratios can be told.
        let logs: f64 = strokes.iter().map(|stroke| stroke.pace.ln()).sum();
        let unit = (logs / strokes.len() as f64).exp();
        strokes.iter_mut().for_each(|stroke| stroke.pace /= unit);
    }
}

/// What strokes tell of two receptors.
#[derive(Default)]
struct Pair {
    /// Distances, each with how much of both receptors the stroke passed, up to 1.
    distances: Vec<(f64, f64)>,
    /// Whether one fired right after the other.
    succession: bool,
}

impl Pair {
    /// The distance below which [`SHARE`] of the distances are.
    fn distance(&mut self) -> f64 {
        self.distances.sort_by(|a, b| a.0.total_cmp(&b.0));
        let all: f64 = self.distances.iter().map(|(_, weight)| weight).sum();
        let mut below = 0.0;
        let found = self.distances.iter().find(|(_, weight)| {
            below += weight;
            below >= SHARE * all
        });
        found.map_or(f64::INFINITY, |(distance, _)| *distance)
    }
}

/// Receptors near enough to be neighbours, and how far apart, in their limbs' own unit.
fn links_of(strokes: &[Stroke], limbs: &[usize]) -> Vec<(f64, [usize; 2])> {
    let mut widths = Means::default();
    for stroke in strokes {
        stroke.firings.iter().for_each(|firing| widths.add(firing.receptor, stroke.pace * lasted(firing)));
    }
    let mut pairs: BTreeMap<[usize; 2], Pair> = BTreeMap::new();
    for stroke in strokes {
        let passed = |firing: &Firing| {
            let usual = widths.of(firing.receptor);
            if usual > 0.0 { (stroke.pace * lasted(firing) / usual).min(1.0) } else { 1.0 }
        };
        for (k, from) in stroke.firings.iter().enumerate() {
            let mut seen = vec![from.receptor];
            for (steps, to) in stroke.firings[k + 1..].iter().take(WITHIN).enumerate() {
                // Back where it was: all that follows was nearer then.
                if to.receptor == from.receptor {
                    break;
                }
                if seen.contains(&to.receptor) {
                    continue;
                }
                seen.push(to.receptor);
                let pair = pairs
                    .entry([from.receptor.min(to.receptor), from.receptor.max(to.receptor)])
                    .or_default();
                pair.succession |= steps == 0;
                pair.distances.push((stroke.pace * (middle(to) - middle(from)), passed(from) * passed(to)));
            }
        }
    }
    let told: Vec<([usize; 2], f64, bool)> =
        pairs.into_iter().map(|(at, mut pair)| (at, pair.distance(), pair.succession)).collect();
    // Those of one limb tell its unit; where it has none, all that lead onto it.
    let (mut within, mut onto) = (Means::default(), Means::default());
    for ([a, b], distance, _) in told.iter().filter(|(.., succession)| *succession) {
        let [a, b] = [limbs[*a], limbs[*b]];
        [a, b].into_iter().for_each(|limb| onto.add(limb, *distance));
        if a == b {
            within.add(a, *distance);
        }
    }
    let unit = |limb: usize| {
        let told = if within.sum_and_count(limb)[1] >= FEW { &within } else { &onto };
        told.of(limb)
    };
    let far = |[a, b]: [usize; 2], distance: f64, succession: bool| {
        let unit = 0.5 * (unit(limbs[a]) + unit(limbs[b]));
        distance / unit - if succession { SUCCESSION } else { 0.0 }
    };
    let links = told.into_iter().map(|(at, distance, succession)| (far(at, distance, succession), at));
    links.filter(|(far, _)| *far <= REACH).collect()
}
