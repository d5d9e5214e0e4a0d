//! The state of a table search: what has been searched, what was felt, and where to go next.

use std::collections::{BTreeMap, BTreeSet};

use nalgebra::Vector3;

use super::plan::{SEARCHED, SearchPlan, Stop};
use crate::interaction::actor::FoundThing;
use crate::peripersonal::{CELL, SearchedMap};

/// A lane is left to the next one where it alone would search fewer cells than this.
const LANE_WORTH: usize = 30;
/// What is nearer than this to where something was felt is taken for that thing, metres.
const AT: f64 = 0.02;
/// Fewer cells side by side than this hide nothing that is to be told of: a square of 4 cm.
const UNSEARCHED: usize = 16;
/// Touches farther apart than this do not tell that there is nothing to be felt between them, metres.
const ACROSS: f64 = 0.045;
/// Touches farther apart than this are not taken for those of one thing by themselves, metres: what is larger is touched at
/// places that are nearer.
const TOGETHER: f64 = 0.07;
/// By so much skin passed lower than both touches where it parts them, metres.
const LOWER: f64 = 0.015;
/// So much of the way between two touches may be empty, metres: a touch is known to a centimetre or two.
const EMPTY: f64 = 0.012;
/// And so much at either end is not looked at, metres.
const END: f64 = 0.012;
/// By so much skin must pass lower than a thing was felt to be where it is no more, metres …
const BENEATH: f64 = 0.004;
/// … in as many as this of nine cells.
const GONE: usize = 7;
/// Where a thing is no more what is as near as this is searched again, metres …
const NEAR: f64 = 0.2;
/// … so often in a search.
const UPSETS: usize = 6;
/// How often it is made sure of each thing in the end, where a hand comes down beside it.
const SURE: u8 = 3;
/// How far apart places for fingers are, in cells.
const NARROW: usize = 2;
/// A place is tried so often.
const TRIES: u8 = 2;

/// Something felt in a search.
#[derive(Clone, Debug)]
pub struct Feeling {
    /// What was felt.
    pub found: FoundThing,
    /// Where, forward, to the left and above the table, metres.
    pub at: [f64; 3],
    /// Where the thing must be, if it is still there, in the same directions.
    pub(super) within: [f64; 3],
    /// Whether skin has since been where that was.
    pub gone: bool,
}

impl Feeling {
    /// How far it is from another over the table, metres.
    fn away(&self, other: &Feeling) -> f64 {
        (self.at[0] - other.at[0]).hypot(self.at[1] - other.at[1])
    }

    /// Whether no skin has passed between two touches lower than both: where it has there is no thing that reaches from one to
    /// the other.
    fn hangs_together_with(&self, other: &Feeling, map: &SearchedMap) -> bool {
        let [p, q] = [self, other].map(|felt| [felt.at[0], felt.at[1]]);
        let lower = self.at[2].min(other.at[2]) - LOWER;
        map.longest_empty(p, q, END, lower.max(SEARCHED)) < EMPTY.max(CELL)
    }
}

/// A thing as it was felt in a search.
#[derive(Clone, Debug)]
pub struct FeltThing {
    /// Its touches, as indices into [`Search::felt`].
    pub touches: Vec<usize>,
    /// The middle of them in the root's frame, metres.
    pub at: Vector3<f64>,
}

/// A search of a table, as far as it got.
pub struct Search {
    pub(super) plan: SearchPlan,
    /// What has been searched.
    pub map: SearchedMap,
    /// All that was felt.
    pub felt: Vec<Feeling>,
    /// Where it goes next: a lane and a stop of it.
    next: [usize; 2],
    /// Per lane and stop, how often it was tried.
    pub(super) tried: Vec<Vec<u8>>,
    /// Where the hand is, and whether it is low there.
    pub(super) at: Option<([usize; 2], bool)>,
    /// Whether all lanes are done, and what they left is being searched.
    again: bool,
    /// Whether places for fingers alone have been added.
    pub(super) narrowed: bool,
    /// Per cell how high what was felt there is, metres, and whether the cell is taken up by a thing.
    tops: Vec<f64>,
    taken: Vec<bool>,
    /// How often what was known turned out to be gone.
    upsets: usize,
    /// What was felt before it began to make sure of all things, and how often it has tried to, by a thing's first touch.
    sure: Option<(usize, BTreeMap<usize, u8>)>,
    /// Whether there is nothing left to search.
    pub done: bool,
    /// The hand that alone is to search; `None` if both do.
    pub only: Option<usize>,
}

impl Search {
    /// A search of which nothing has been done.
    pub fn new(plan: SearchPlan) -> Search {
        let tried = plan.lanes.iter().map(|lane| vec![0; lane.len()]).collect();
        let map = plan.map.clone();
        let cells = map.cells();
        Search {
            narrowed: false,
            tops: vec![f64::NEG_INFINITY; cells],
            taken: vec![false; cells],
            upsets: 0,
            sure: None,
            plan,
            map,
            felt: Vec::new(),
            next: [0, 0],
            tried,
            at: None,
            again: false,
            done: false,
            only: None,
        }
    }

    pub(super) fn stop(&self, [lane, k]: [usize; 2]) -> &Stop {
        &self.plan.lanes[lane][k]
    }

    /// The things that were felt, in the order in which they were felt first: touches that belong together by where they are and
    /// by the free space between them.
    pub fn things(&self) -> Vec<FeltThing> {
        let felt = &self.felt;
        let mut group: Vec<usize> = (0..felt.len()).collect();
        let are_one = |a: &Feeling, b: &Feeling| a.away(b) <= TOGETHER && a.hangs_together_with(b, &self.map);
        for i in 0..felt.len() {
            for j in 0..i {
                if group[i] != group[j] && !felt[i].gone && !felt[j].gone && are_one(&felt[i], &felt[j]) {
                    let (old, new) = (group[i].max(group[j]), group[i].min(group[j]));
                    group.iter_mut().filter(|g| **g == old).for_each(|g| *g = new);
                }
            }
        }
        let firsts = (0..felt.len()).filter(|&i| group[i] == i && !felt[i].gone);
        let thing = |first: usize| {
            let touches: Vec<usize> = (first..felt.len()).filter(|&i| group[i] == first).collect();
            let points = touches.iter().map(|&i| felt[i].found.point);
            let (low, high) = points
                .fold((felt[first].found.point, felt[first].found.point), |(low, high), point| {
                    (low.inf(&point), high.sup(&point))
                });
            FeltThing { touches, at: 0.5 * (low + high) }
        };
        firsts.map(thing).collect()
    }

    /// Whether a thing at a point of the root's frame would have been felt: whether skin has been low over that place.
    pub fn would_have_felt(&self, point: &Vector3<f64>) -> bool {
        let [forward, left, _] = self.map.plane.coordinates(point);
        self.map.cell(forward, left).is_some_and(|cell| self.map.passed[cell] <= SEARCHED)
    }

    /// The middles of the places that it could reach and could not search, forward and to the left, metres, and how many
    /// cells each is; not what is at the things that it felt.
    pub fn unsearched(&self) -> Vec<([f64; 2], usize)> {
        let mut open: BTreeSet<usize> = self.map.reachable().filter(|&cell| self.is_open(cell)).collect();
        let mut places = Vec::new();
        while let Some(first) = open.pop_first() {
            let (mut front, mut place) = (vec![first], Vec::new());
            while let Some(cell) = front.pop() {
                place.push(self.map.middle(cell));
                let beside: Vec<usize> = self.map.beside(cell).filter(|cell| open.contains(cell)).collect();
                beside.iter().for_each(|cell| {
                    open.remove(cell);
                });
                front.extend(beside);
            }
            if place.len() >= UNSEARCHED {
                let middle = [0, 1].map(|i| place.iter().map(|at| at[i]).sum::<f64>() / place.len() as f64);
                places.push((middle, place.len()));
            }
        }
        places
    }

    /// How many cells a place would search that have not been, and that are not at what was felt; `None` if the hand would
    /// come down on that.
    fn gain(&self, stop: &Stop) -> usize {
        if stop.under.iter().any(|&(cell, above)| self.tops[cell] > above + BENEATH) {
            return 0;
        }
        let open = |cell: &&usize| self.map.passed[**cell] > stop.searches && !self.taken[**cell];
        stop.cells.iter().filter(open).count()
    }

    /// Whether a cell is still to be searched.
    fn is_open(&self, cell: usize) -> bool {
        self.map.passed[cell] > SEARCHED && !self.taken[cell]
    }

    /// Takes in where things are known to be now.
    pub(super) fn know_cells(&mut self) {
        self.tops.fill(f64::NEG_INFINITY);
        self.taken.fill(false);
        let live: Vec<&Feeling> = self.felt.iter().filter(|felt| !felt.gone).collect();
        let mut take = |[x, y]: [f64; 2]| {
            let side = (AT / CELL) as i32;
            for (i, j) in (-side..=side).flat_map(|i| (-side..=side).map(move |j| (i, j))) {
                let [dx, dy] = [i, j].map(|k| CELL * f64::from(k));
                if dx.hypot(dy) <= AT
                    && let Some(cell) = self.map.cell(x + dx, y + dy)
                {
                    self.taken[cell] = true;
                }
            }
        };
        for (i, a) in live.iter().enumerate() {
            for cell in self.map.about([a.within[0], a.within[1]]) {
                self.tops[cell] = self.tops[cell].max(a.within[2]);
            }
            let place = |felt: &Feeling| [felt.at[0], felt.at[1]];
            take(place(a));
            for b in &live[..i] {
                let [p, q] = [place(a), place(b)];
                let length = a.away(b);
                if length <= ACROSS && a.hangs_together_with(b, &self.map) {
                    let steps = (length / CELL).ceil() as usize;
                    (1..steps)
                        .for_each(|k| take([0, 1].map(|x| p[x] + (q[x] - p[x]) * k as f64 / steps as f64)));
                }
            }
        }
    }

    /// Whether skin that has passed cells at some heights has been where a thing must be that was felt.
    fn is_gone(&self, felt: &Feeling, above: impl Fn(usize) -> f64) -> bool {
        let [forward, left, height] = felt.within;
        self.map.about([forward, left]).filter(|&cell| above(cell) <= height - BENEATH).count() >= GONE
    }

    /// What the last motion has passed is no longer there; where all of a thing is gone, it may be near there.
    pub(super) fn take_in_what_is_gone(&mut self) {
        let gone: Vec<usize> = (0..self.felt.len())
            .filter(|&i| !self.felt[i].gone && self.is_gone(&self.felt[i], |cell| self.map.lately[cell]))
            .collect();
        if gone.is_empty() {
            return;
        }
        let things = self.things();
        gone.iter().for_each(|&i| self.felt[i].gone = true);
        for thing in things {
            if thing.touches.iter().all(|&i| self.felt[i].gone) && self.upsets < UPSETS {
                self.upsets += 1;
                let [forward, left, _] = self.map.plane.coordinates(&thing.at);
                self.map.forget_about([forward, left], NEAR);
                for (lane, tried) in self.plan.lanes.iter().zip(&mut self.tried) {
                    for (stop, tried) in lane.iter().zip(tried) {
                        if (stop.at[0] - forward).hypot(stop.at[1] - left) < NEAR {
                            *tried = 0;
                        }
                    }
                }
            }
        }
        self.know_cells();
    }

    /// Where it goes to make sure of a thing that was not felt again in the end: where the hand must come down on it.
    fn next_to_make_sure_of(&mut self) -> Option<[usize; 2]> {
        let (before, tried) = self.sure.get_or_insert_with(|| (self.felt.len(), BTreeMap::new()));
        let before = *before;
        let tried = tried.clone();
        for thing in self.things() {
            let first = thing.touches[0];
            let times = tried.get(&first).copied().unwrap_or(0);
            if thing.touches.iter().any(|&i| i >= before) || times >= SURE {
                continue;
            }
            if let Some((_, tried)) = &mut self.sure {
                tried.insert(first, times + 1);
            }
            let met = |stop: &Stop| {
                let above = |cell: usize| {
                    let at = stop.under.binary_search_by_key(&cell, |(cell, _)| *cell);
                    at.map_or(f64::INFINITY, |k| stop.under[k].1)
                };
                thing.touches.iter().filter(|&&i| self.is_gone(&self.felt[i], above)).count()
            };
            if let Some((_, at)) =
                self.allowed().map(|at| (met(self.stop(at)), at)).filter(|(met, _)| *met > 0).max()
            {
                return Some(at);
            }
        }
        None
    }

    /// All stops of the hands that are to search.
    fn allowed(&self) -> impl Iterator<Item = [usize; 2]> {
        let lanes = self.plan.lanes.iter().enumerate();
        let all = lanes.flat_map(|(lane, stops)| (0..stops.len()).map(move |k| [lane, k]));
        all.filter(|&at| self.only.is_none_or(|hand| hand == self.stop(at).hand))
    }

    /// Whether a lane would search what the next two would not as well.
    fn lane_is_worth(&self, lane: usize) -> bool {
        let here = &self.plan.lanes[lane];
        let Some(hand) = here.first().map(|stop| stop.hand) else { return false };
        if here[0].is_rim() {
            return true;
        }
        let next = self.plan.lanes.iter().skip(lane + 1).take(2);
        let others: BTreeSet<usize> = next
            .flatten()
            .filter(|stop| stop.hand == hand)
            .flat_map(|stop| stop.cells.iter().copied())
            .collect();
        let mut alone: Vec<usize> = here
            .iter()
            .flat_map(|stop| stop.cells.iter().copied())
            .filter(|cell| !others.contains(cell) && self.is_open(*cell))
            .collect();
        alone.sort_unstable();
        alone.dedup();
        alone.len() >= LANE_WORTH
    }

    /// The place to go to next; `None` if all is searched that can be.
    pub(super) fn following(&mut self) -> Option<[usize; 2]> {
        while !self.again {
            let [lane, k] = self.next;
            if lane == self.plan.lanes.len() {
                self.again = true;
                break;
            }
            let hand = self.plan.lanes[lane].first().map(|stop| stop.hand);
            let searches = self.only.is_none() || self.only == hand;
            if k == self.plan.lanes[lane].len() || !searches || (k == 0 && !self.lane_is_worth(lane)) {
                self.next = [lane + 1, 0];
                continue;
            }
            self.next = [lane, k + 1];
            if self.is_worth([lane, k]) {
                return Some([lane, k]);
            }
        }
        // What the lanes left: where most is to be searched first, with the hand that is there already.
        let hand = self.at.map(|(at, _)| self.stop(at).hand);
        let order = |at: &[usize; 2]| {
            let stop = self.stop(*at);
            (Some(stop.hand) == hand, self.gain(stop))
        };
        let best = self
            .allowed()
            .filter(|&at| self.tried[at[0]][at[1]] < TRIES && self.is_worth(at))
            .max_by_key(order);
        if best.is_some() || !self.narrowed {
            return best;
        }
        let best = self.next_to_make_sure_of();
        self.done = best.is_none();
        best
    }

    /// Whether a place would search enough to go there.
    fn is_worth(&self, at: [usize; 2]) -> bool {
        self.gain(self.stop(at)) >= self.stop(at).worth
    }

    /// Cells to which fingers alone may get.
    pub(super) fn narrow_places(&self) -> Vec<[f64; 2]> {
        let every = |cell: &usize| {
            let [x, y] = self.map.middle(*cell).map(|x| (x / CELL).floor() as i64);
            x.rem_euclid(NARROW as i64) == 0 && y.rem_euclid(NARROW as i64) == 0
        };
        let open = self.map.reachable().filter(|&cell| self.is_open(cell));
        open.filter(every).map(|cell| self.map.middle(cell)).collect()
    }
}
