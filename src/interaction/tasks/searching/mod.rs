//! Searching a table: hands feel about low over it, lane by lane from the belly outward, lift over what they meet and come
//! down behind it, until all that they reach has been felt.

mod plan;
mod search;

use super::SWEEPING;
use crate::creature::Posture;
use crate::error::Result;
use crate::geometry::Capsule;
use crate::interaction::actor::{Actor, CAREFUL, FoundThing, SWIFT};
use crate::peripersonal::{Obstacle, OutOfReach, PosturePath, TablePlane, straight};
use plan::CLEAR;
pub use plan::SearchPlan;
pub use search::{Feeling, Search};

/// How fast they go above things, metres a second.
const ABOVE: f64 = 3.0 * CAREFUL;
/// How far skin draws back from what it met, metres.
const DRAWN_BACK: f64 = 0.02;
/// The way of a sweep between neighbouring places is no longer than this, metres.
const SWEEP: f64 = 0.09;
/// A thing goes on at least so far from where it was felt, metres.
const INTO: f64 = 0.012;
/// On its way above things a hand keeps clear of a ball of this radius where each was felt, metres.
const ABOUT: f64 = 0.03;
/// Where hands can feel a table is worked out anew where it is higher or lower by more than this, metres.
const SAME_HEIGHT: f64 = 5e-4;
/// Every so many steps of a motion what it passed is taken down: a millimetre or two of way.
const NOTED: usize = 6;

impl Actor {
    /// The table as far as it is known.
    pub fn table_plane(&self) -> Option<TablePlane> {
        let height = self.table?;
        Some(TablePlane { up: self.up, front: self.front, height, edge: self.trunk_front(height) })
    }

    /// A search of the table; `None` if it is not known.
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

    /// Touches anew what was felt in a search, from where the hand has drawn back to: what is felt then; `None` if it is gone.
    ///
    /// # Errors
    /// Where the engine fails.
    pub fn touch_anew(&mut self, found: &FoundThing) -> Result<Option<FoundThing>> {
        let contacts = self.follow(&PosturePath(vec![found.posture.clone()]), CAREFUL, |_, _| true)?;
        Ok(contacts.iter().find_map(|contact| self.found(contact)))
    }

    /// Goes on with a search until something is felt; `None` if all was searched.
    ///
    /// # Errors
    /// Where the engine fails.
    pub fn search_on(&mut self, search: &mut Search) -> Result<Option<Feeling>> {
        loop {
            let Some(to) = search.following() else {
                if search.done {
                    return Ok(None);
                }
                self.add_narrow_stops(search);
                continue;
            };
            let from = search.at.filter(|&(_, low)| low).map(|(at, _)| at);
            let felt = match from {
                Some(from) if self.sweeps(search, from, to) => {
                    let low = search.stop(to).low().clone();
                    self.feel_along(search, &PosturePath(vec![low]), SWEEPING)?
                }
                _ => self.come_down_at(search, to)?,
            };
            let [lane, k] = to;
            search.tried[lane][k] += 1;
            search.at = Some((to, felt.is_none()));
            if let Some(felt) = felt {
                search.felt.push(felt.clone());
                search.know_cells();
                return Ok(Some(felt));
            }
        }
    }

    /// Adds places for fingers where the palms cannot get.
    fn add_narrow_stops(&mut self, search: &mut Search) {
        search.narrowed = true;
        let places = search.narrow_places();
        for hand in 0..2 {
            let stops = self.narrow_stops(hand, &search.plan, &places);
            search.tried.push(vec![0; stops.len()]);
            search.plan.lanes.push(stops);
        }
    }

    /// Whether the next place is low beside the present one.
    fn sweeps(&self, search: &Search, from: [usize; 2], to: [usize; 2]) -> bool {
        let [a, b] = [from, to].map(|at| search.stop(at));
        let near = (a.at[0] - b.at[0]).hypot(a.at[1] - b.at[1]) <= SWEEP;
        let clearance = self.clearance.moved_by(&self.own, &self.hands[b.hand].arm);
        a.hand == b.hand && near && straight(&self.own, &clearance, &self.posture(), b.low(), CLEAR - 1e-3)
    }

    /// Goes along a way, takes down what it passes, and draws back at once from what it feels.
    fn feel_along(&mut self, search: &mut Search, way: &PosturePath, speed: f64) -> Result<Option<Feeling>> {
        let since = self.steps;
        let contacts = self.follow(way, speed, |_, _| true)?;
        search.map.lately.fill(f64::INFINITY);
        let passed: Vec<Posture> = self.lately(since).step_by(NOTED).cloned().collect();
        for posture in &passed {
            let frames = self.own.frames(posture);
            for skin in &search.plan.skin {
                search.map.pass(skin, &frames);
            }
        }
        search.take_in_what_is_gone();
        let found = contacts.iter().find_map(|contact| self.found(contact));
        self.back_off(&contacts, DRAWN_BACK)?;
        let plane = search.map.plane;
        Ok(found.map(|found| Feeling {
            at: plane.coordinates(&found.point),
            within: plane.coordinates(&(found.point + found.direction * INTO)),
            gone: false,
            found,
        }))
    }

    /// A way that keeps clear of what was felt, or, where there is none, of the body and the table alone.
    fn way_above(
        &mut self,
        search: &Search,
        ends: [&[f64]; 2],
        arm: &[usize],
    ) -> Result<PosturePath, OutOfReach> {
        let live = search.felt.iter().filter(|felt| !felt.gone);
        let balls = live.map(|felt| search.map.plane.point(felt.within)).map(|at| Capsule::ball(at, ABOUT));
        let way = self.with_obstacles(balls.map(Obstacle::Capsule), |actor| actor.find_path(ends, arm));
        way.or_else(|_| self.find_path(ends, arm))
    }

    /// Lifts the hand, takes it over a place, and lets it down there.
    fn come_down_at(&mut self, search: &mut Search, to: [usize; 2]) -> Result<Option<Feeling>> {
        let stop = search.stop(to).clone();
        let other = search.at.map(|(at, _)| search.stop(at).clone()).filter(|at| at.hand != stop.hand);
        if let Some(at) = search.at.map(|(at, _)| search.stop(at).clone()) {
            let up = self.straight_up(at.hand, at.sole, &search.plan);
            if let Some(felt) = self.feel_along(search, &PosturePath(up), SWIFT)? {
                return Ok(Some(felt));
            }
        }
        if let Some(other) = other {
            let (from, ready) = (self.posture(), self.ready());
            let arm = self.hands[other.hand].arm.clone();
            if let Ok(way) = self.way_above(search, [&from, &ready], &arm)
                && let Some(felt) = self.feel_along(search, &way, ABOVE)?
            {
                return Ok(Some(felt));
            }
        }
        let from = self.posture();
        let high = stop.rising.last().unwrap_or(stop.low()).clone();
        let arm = self.hands[stop.hand].arm.clone();
        let Ok(way) = self.way_above(search, [&from, &high], &arm) else { return Ok(None) };
        if let Some(felt) = self.feel_along(search, &way, ABOVE)? {
            return Ok(Some(felt));
        }
        let down: Vec<Posture> = stop.rising.iter().rev().cloned().collect();
        self.feel_along(search, &PosturePath(down), SWEEPING)
    }
}
