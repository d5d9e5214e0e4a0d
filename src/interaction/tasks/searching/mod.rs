//! Searching a table: hands feel about low over it, lane by lane from the belly outward, lift over what they meet and come
//! down behind it, until all that they reach has been felt.

mod clusters;
mod plan;

use nalgebra::Vector3;

use crate::creature::Posture;
use crate::interaction::actor::{Actor, CAREFUL, FoundThing, SWIFT, Stop as Ended};
use crate::peripersonal::{PosturePath, SearchedMap, TablePlane, straight};
use crate::simulation::EngineResult;
pub use clusters::FeltThing;
pub use plan::SearchPlan;
use plan::{CLEAR, SEARCHED, Stop};

/// How fast the tips of the hands go low over the table and down to it, metres a second.
const FEELING: f64 = 3.0 * CAREFUL;
/// How far skin draws back from what it met, metres.
const DRAWN_BACK: f64 = 0.02;
/// The way of a sweep between neighbouring places is no longer than this, metres.
const SWEEP: f64 = 0.09;
/// A place is worth going to for so many cells that were not searched.
const WORTH: usize = 7;
/// A lane is left to the next one where it alone would search fewer cells than this.
const LANE_WORTH: usize = 30;
/// What is nearer than this to where something was felt is taken for that thing, metres.
const AT: f64 = 0.02;
/// Fewer cells side by side than this hide nothing that is to be told of: a square of 4 cm.
const UNSEARCHED: usize = 16;
/// Where hands can feel a table is worked out anew where it is higher or lower by more than this, metres.
const SAME_HEIGHT: f64 = 5e-4;
/// A place is tried so often.
const TRIES: u8 = 2;
/// Every so many steps of a motion what it passed is taken down: a millimetre or two of way.
const NOTED: usize = 6;

/// Something felt in a search.
#[derive(Clone, Debug)]
pub struct Feeling {
    /// What was felt.
    pub found: FoundThing,
    /// Where, forward, to the left and above the table, metres.
    pub at: [f64; 3],
}

/// A search of a table, as far as it got.
pub struct Search {
    plan: SearchPlan,
    /// What has been searched.
    pub map: SearchedMap,
    /// All that was felt.
    pub felt: Vec<Feeling>,
    /// Where it goes next: a lane and a stop of it.
    next: [usize; 2],
    /// Per lane and stop, how often it was tried.
    tried: Vec<Vec<u8>>,
    /// Where the hand is, and whether it is low there.
    at: Option<([usize; 2], bool)>,
    /// Whether all lanes are done, and what they left is being searched.
    again: bool,
    /// Whether there is nothing left to search.
    pub done: bool,
    /// The hand that alone is to search; none where both do.
    pub only: Option<usize>,
}

impl Search {
    /// A search of which nothing has been done.
    pub fn new(plan: SearchPlan) -> Search {
        let tried = plan.lanes.iter().map(|lane| vec![0; lane.len()]).collect();
        let map = plan.map.clone();
        Search {
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

    /// The plan.
    pub fn plan(&self) -> &SearchPlan {
        &self.plan
    }

    fn stop(&self, [lane, k]: [usize; 2]) -> &Stop {
        &self.plan.lanes[lane][k]
    }

    /// The things that were felt, in the order in which they were felt first.
    pub fn things(&self) -> Vec<FeltThing> {
        clusters::things(&self.map, &self.felt)
    }

    /// Whether a thing at a point of the root's frame would have been felt: whether skin has been low over that place.
    pub fn would_have_felt(&self, point: &Vector3<f64>) -> bool {
        let [forward, left, _] = self.map.plane.coordinates(point);
        self.map.cell(forward, left).is_some_and(|cell| self.map.passed(cell) <= SEARCHED)
    }

    /// The middles of the places that it could reach and could not search, forward and to the left, metres, and how many
    /// cells each is; not what is at the things that it felt.
    pub fn unsearched(&self) -> Vec<([f64; 2], usize)> {
        let mut open: std::collections::BTreeSet<usize> =
            self.map.reachable().filter(|&cell| self.is_open(cell)).collect();
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

    /// How many cells a place would search that have not been, and that are not at what was felt.
    fn gain(&self, stop: &Stop) -> usize {
        stop.cells.iter().filter(|&&cell| self.is_open(cell)).count()
    }

    /// Whether a cell is still to be searched.
    fn is_open(&self, cell: usize) -> bool {
        let [x, y] = self.map.middle(cell);
        let felt = |felt: &Feeling| (felt.at[0] - x).hypot(felt.at[1] - y) < AT;
        self.map.passed(cell) > SEARCHED && !self.felt.iter().any(felt)
    }

    /// Whether a lane would search what the next two would not as well.
    fn lane_is_worth(&self, lane: usize) -> bool {
        let here = &self.plan.lanes[lane];
        let Some(hand) = here.first().map(|stop| stop.hand) else { return false };
        let next = self.plan.lanes.iter().skip(lane + 1).take(2);
        let others: std::collections::BTreeSet<usize> = next
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

    /// The place to go to next; none where all is searched that can be.
    fn following(&mut self) -> Option<[usize; 2]> {
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
            if self.gain(self.stop([lane, k])) >= WORTH {
                return Some([lane, k]);
            }
        }
        // What the lanes left: where most is to be searched first, with the hand that is there already.
        let hand = self.at.map(|(at, _)| self.stop(at).hand);
        let all = (0..self.plan.lanes.len())
            .flat_map(|lane| (0..self.plan.lanes[lane].len()).map(move |k| [lane, k]));
        let worth = |at: &[usize; 2]| {
            let stop = self.stop(*at);
            (Some(stop.hand) == hand, self.gain(stop))
        };
        let best = all
            .filter(|&at| self.only.is_none_or(|hand| hand == self.stop(at).hand))
            .filter(|&[lane, k]| self.tried[lane][k] < TRIES && self.gain(self.stop([lane, k])) >= WORTH)
            .max_by_key(worth);
        self.done = best.is_none();
        best
    }
}

impl Actor {
    /// The table as far as it is known.
    pub fn table_plane(&self) -> Option<TablePlane> {
        let height = self.table?;
        Some(TablePlane { up: self.up, front: self.front, height, edge: self.trunk_front(height) })
    }

    /// A search of the table; none where it is not known.
    pub fn begin_search(&mut self) -> Option<Search> {
        let plane = self.table_plane()?;
        let fits = |plan: &&SearchPlan| {
            let known = plan.map.plane;
            (known.height - plane.height).abs() < SAME_HEIGHT && known.edge == plane.edge
        };
        if self.reach.as_ref().filter(fits).is_none() {
            self.reach = Some(self.search_plan()?);
        }
        self.reach.clone().map(Search::new)
    }

    /// Touches anew what was felt in a search, from where the hand has drawn back to: what is felt then; none where it is gone.
    ///
    /// # Errors
    /// Where the engine fails.
    pub fn touch_anew(&mut self, felt: &Feeling) -> EngineResult<Option<FoundThing>> {
        match self.follow(&PosturePath(vec![felt.found.posture.clone()]), CAREFUL, |_, _| true)? {
            Ended::Felt(contacts) => Ok(contacts.iter().find_map(|contact| self.found(contact))),
            Ended::Arrived => Ok(None),
        }
    }

    /// Goes on with a search until something is felt; none where all was searched.
    ///
    /// # Errors
    /// Where the engine fails.
    pub fn search_on(&mut self, search: &mut Search) -> EngineResult<Option<Feeling>> {
        while let Some(to) = search.following() {
            let from = search.at.filter(|&(_, low)| low).map(|(at, _)| at);
            let felt = match from {
                Some(from) if self.sweeps(search, from, to) => {
                    let low = search.stop(to).low.clone();
                    self.feel_along(search, &PosturePath(vec![low]), FEELING)?
                }
                _ => self.come_down_at(search, to)?,
            };
            let [lane, k] = to;
            search.tried[lane][k] += 1;
            search.at = Some((to, felt.is_none()));
            if let Some(felt) = felt {
                search.felt.push(felt.clone());
                return Ok(Some(felt));
            }
        }
        Ok(None)
    }

    /// Whether the next place is low beside the present one.
    fn sweeps(&self, search: &Search, from: [usize; 2], to: [usize; 2]) -> bool {
        let [a, b] = [from, to].map(|at| search.stop(at));
        let near = (a.at[0] - b.at[0]).hypot(a.at[1] - b.at[1]) <= SWEEP;
        let clearance = self.clearance.moved_by(&self.own, &self.hands[b.hand].arm);
        a.hand == b.hand && near && straight(&self.own, &clearance, &self.posture(), &b.low, CLEAR - 1e-3)
    }

    /// Goes along a way, takes down what it passes, and draws back at once from what it feels.
    fn feel_along(
        &mut self,
        search: &mut Search,
        way: &PosturePath,
        speed: f64,
    ) -> EngineResult<Option<Feeling>> {
        let since = self.steps();
        let ended = self.follow(way, speed, |_, _| true)?;
        let passed: Vec<Posture> = self.lately(since).step_by(NOTED).cloned().collect();
        for posture in &passed {
            let frames = self.own.frames(posture);
            for skin in &search.plan.skin {
                search.map.pass(skin, &frames);
            }
        }
        let Ended::Felt(contacts) = ended else { return Ok(None) };
        let found = contacts.iter().find_map(|contact| self.found(contact));
        let back = contacts[0].spot.receptor;
        if let Some(way) = self.back_by(back, DRAWN_BACK) {
            self.follow(&way, SWIFT, |_, _| false)?;
        }
        Ok(found.map(|found| Feeling { at: search.map.plane.coordinates(&found.point), found }))
    }

    /// Lifts the hand, takes it over a place, and lets it down there.
    fn come_down_at(&mut self, search: &mut Search, to: [usize; 2]) -> EngineResult<Option<Feeling>> {
        let stop = search.stop(to).clone();
        let other = search.at.map(|(at, _)| search.stop(at).clone()).filter(|at| at.hand != stop.hand);
        if let Some(at) = search.at.map(|(at, _)| search.stop(at).clone()) {
            let up = self.straight_up(at.hand, at.sole, &search.plan);
            let felt = self.feel_along(search, &PosturePath(up), SWIFT)?;
            if felt.is_some() {
                return Ok(felt);
            }
        }
        if let Some(other) = other {
            let ready = self.ready();
            let arm = self.hands[other.hand].arm.clone();
            let from = self.posture();
            if let Ok(way) = self.find_path([&from, &ready], &arm) {
                let felt = self.feel_along(search, &way, SWIFT)?;
                if felt.is_some() {
                    return Ok(felt);
                }
            }
        }
        let from = self.posture();
        let high = stop.rising.last().expect("the low posture").clone();
        let arm = self.hands[stop.hand].arm.clone();
        let Ok(way) = self.find_path([&from, &high], &arm) else { return Ok(None) };
        let felt = self.feel_along(search, &way, SWIFT)?;
        if felt.is_some() {
            return Ok(felt);
        }
        let down: Vec<Posture> = stop.rising.iter().rev().cloned().collect();
        self.feel_along(search, &PosturePath(down), FEELING)
    }
}
