//! Where hands can feel about on a table: postures in which skin is low over it, lane by lane from the belly outward.

use std::f64::consts::FRAC_PI_2;

use nalgebra::Vector3;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

use crate::creature::Posture;
use crate::geometry::{Frame, directions};
use crate::interaction::actor::{Actor, Hand};
use crate::kinematics::Place;
use crate::peripersonal::{
    CELL, Cell, CollisionChecker, OwnBody, PosturePath, ReachTarget, Reaching, SearchedMap, SkinPoints,
};

/// How high over the table the lowest skin of a hand that feels about goes, metres: what it touches is no table then, as
/// far as a learned schema errs by few millimetres …
pub const LOW: f64 = 0.006;
/// … and up to which height a place under it has been searched: anything higher would have been touched.
pub const SEARCHED: f64 = 0.016;
/// How thick the layer of skin is that counts as a sole, metres.
const SOLE: f64 = SEARCHED - LOW;
/// How clear of the table and the body postures keep, metres.
pub const CLEAR: f64 = 0.003;
/// How high a hand is lifted from the table to get over things, metres: at most, …
pub const LIFT: f64 = 0.17;
/// … at least, …
const LEAST_LIFT: f64 = 0.06;
/// … and in steps of.
const RISE: f64 = 0.02;
/// How far apart lanes are, and places on a lane, metres.
const LANE: f64 = 0.04;
/// How far beyond the middle a hand feels on the other's side, and on its own, metres.
const ACROSS: [f64; 2] = [-0.16, 0.8];
/// Directions of the hand that are tried for its sole.
const DIRECTIONS: usize = 200;
/// Soles of a hand that are used: the palm, its back, an edge.
const SOLES: usize = 3;
/// How different their directions are, as the greatest cosine.
const DIFFERENT: f64 = 0.5;
/// Random postures that inverse kinematics may begin with …
const DRAWN: usize = 400;
/// … of which as many as this are tried for a place.
const STARTS: usize = 4;
/// How high over the table fingers feel as far away as they get, metres: higher up they get farther.
const RIMS: [f64; 2] = [LOW, 0.035];
/// How far apart places as far away as a hand gets are, metres …
const RIM_SPACING: f64 = 0.04;
/// … in which steps they are found, metres …
const RIM_STEP: f64 = 0.01;
/// … and in how many.
const RIM_STEPS: u32 = 12;
/// Cells under a hand that is flat enough.
const ENOUGH: usize = 42;
/// A place is worth going to for so many cells that were not searched …
const WORTH: usize = 7;
/// … with fingers alone for so many …
const WORTH_NARROW: usize = 4;
/// … and as far away as a hand gets for so many.
const WORTH_FAR: usize = 3;

/// A place where a hand feels the table.
#[derive(Clone, Debug)]
pub struct Stop {
    /// The hand.
    pub hand: usize,
    /// The place of the hand that is lowest.
    pub sole: Place,
    /// Postures straight up from where it is low over the table, until it reaches no farther; the first is the low one.
    pub rising: Vec<Posture>,
    /// Where the sole is when it is low, forward and to the left, metres.
    pub at: [f64; 2],
    /// Up to which height a place under it is searched then, metres.
    pub searches: f64,
    /// For how many cells that were not searched it is worth going there.
    pub worth: usize,
    /// The cells that are searched in the low posture.
    pub cells: Vec<Cell>,
    /// The cells that skin is over then, and how high its lowest is over each, metres.
    pub under: Vec<(Cell, f64)>,
}

impl Stop {
    /// The posture in which it is low over the table.
    pub fn low(&self) -> &Posture {
        &self.rising[0]
    }

    /// Whether it is as far away as the hand gets.
    pub fn is_rim(&self) -> bool {
        self.worth == WORTH_FAR
    }
}

/// Where all hands can feel the table, lane by lane.
#[derive(Clone, Debug)]
pub struct SearchPlan {
    /// The lanes of one hand, nearest first, then those of the other.
    pub lanes: Vec<Vec<Stop>>,
    /// The skin of each hand's arm.
    pub skin: [SkinPoints; 2],
    /// The table with what can be reached of it, of which nothing has been searched.
    pub map: SearchedMap,
}

/// The places of a hand that can be a sole, the one with most skin near its plane first.
fn soles(own: &OwnBody, skin: &SkinPoints, hand: &Hand) -> Vec<Place> {
    let points = skin.of(hand.limb);
    let sole = |direction: Vector3<f64>| {
        let across = direction.cross(&Vector3::ith(direction.iamin(), 1.0)).normalize();
        let along = direction.cross(&across);
        let far = points.iter().map(|point| point.dot(&direction)).fold(f64::NEG_INFINITY, f64::max);
        let near: Vec<_> = points.iter().filter(|point| far - point.dot(&direction) <= SOLE).collect();
        let mut cells: Vec<[i64; 2]> = near
            .iter()
            .map(|point| [point.dot(&across), point.dot(&along)].map(|x| (x / CELL).floor() as i64))
            .collect();
        cells.sort_unstable();
        cells.dedup();
        let middle = near.iter().copied().sum::<Vector3<f64>>() / near.len().max(1) as f64;
        let point = middle + direction * (far - middle.dot(&direction));
        (cells.len(), Place { limb: hand.limb, point, direction })
    };
    let mut found: Vec<_> = directions(DIRECTIONS).map(sole).collect();
    found.sort_by_key(|found| std::cmp::Reverse(found.0));
    let mut soles: Vec<Place> = Vec::new();
    for (_, place) in found {
        if soles.iter().all(|other| other.direction.dot(&place.direction) < DIFFERENT) {
            soles.push(place);
        }
        if soles.len() == SOLES {
            break;
        }
    }
    // Farthest out there is but the tip, however the hand is turned.
    let tip = own.place(hand.tip);
    soles.push(Place { direction: Vector3::zeros(), ..tip });
    soles
}

/// What it takes to look for places of one hand.
struct Places<'a> {
    own: &'a OwnBody,
    clearance: CollisionChecker,
    reaching: Reaching<'a>,
    skin: &'a SkinPoints,
    map: &'a SearchedMap,
    hand: usize,
    up: Vector3<f64>,
    front: Vector3<f64>,
}

impl Places<'_> {
    /// How high the lowest skin of the arm over the table is, metres.
    fn lowest(&self, frames: &[Frame]) -> f64 {
        let over = self.skin.at(frames).map(|point| self.map.plane.coordinates(&point));
        over.filter(|[forward, ..]| *forward > self.map.plane.edge)
            .map(|[.., above]| above)
            .fold(f64::INFINITY, f64::min)
    }

    /// The stop with a sole at a place of the table, so high over it; `None` if there is none that keeps clear.
    fn low(&self, sole: Place, [forward, left]: [f64; 2], height: f64, start: &[f64]) -> Option<Stop> {
        let mut above = height;
        let mut posture = Posture::from(start);
        for _ in 0..3 {
            let point = self.map.plane.point([forward, left, above]);
            let reach = self.reaching.solve(sole, &ReachTarget { point, direction: -self.up }, &posture);
            if !reach.reached() {
                return None;
            }
            posture = reach.posture;
            let lowest = self.lowest(&self.own.frames(&posture));
            if (lowest - height).abs() < 1e-3 {
                break;
            }
            above += height - lowest;
        }
        let frames = self.own.frames(&posture);
        if !self.clearance.free(&frames, CLEAR) {
            return None;
        }
        let mut under: Vec<(Cell, f64)> = self.map.under(self.skin, &frames, LIFT).collect();
        under.sort_unstable_by(|a, b| a.0.cmp(&b.0).then(a.1.total_cmp(&b.1)));
        under.dedup_by_key(|(cell, _)| *cell);
        let searches = height + SOLE;
        let cells = under.iter().filter(|(_, above)| *above <= searches).map(|(cell, _)| *cell).collect();
        let (hand, at, rising) = (self.hand, [forward, left], vec![posture]);
        Some(Stop { hand, sole, rising, cells, under, at, searches, worth: WORTH })
    }

    /// Adds the way up from where a stop is low; whether it goes high enough.
    fn rise(&self, stop: &mut Stop) -> bool {
        stop.rising = self.rising(stop.sole, stop.low());
        RISE * (stop.rising.len() - 1) as f64 >= LEAST_LIFT
    }

    /// Postures straight up from one, as far as it goes; the first is that one.
    fn rising(&self, sole: Place, from: &[f64]) -> Vec<Posture> {
        let frame = self.own.frames(from)[sole.limb];
        let (here, facing) = (frame.point(&sole.point), frame.rotation * sole.direction);
        let above = self.map.plane.coordinates(&here)[2];
        let steps = ((LIFT - above.max(0.0)) / RISE).round() as usize;
        let way = PosturePath::stepwise(from, steps, |k, last| {
            let rise = RISE * k as f64;
            // Where the arm is too short for straight up, it goes back as it goes up.
            [0.0, 0.3, 0.7].into_iter().find_map(|back| {
                let point = here + self.up * rise - self.front * (back * rise);
                let reach = self.reaching.solve(sole, &ReachTarget { point, direction: facing }, last);
                let clear = || self.clearance.free(&self.own.frames(&reach.posture), CLEAR);
                (reach.reached() && clear()).then_some(reach.posture)
            })
        });
        way.0
    }
}

impl Actor {
    /// Where its hands can feel a table that is known, from ready postures on; `None` if none is known.
    pub(super) fn search_plan(&mut self) -> Option<SearchPlan> {
        let plane = self.table_plane()?;
        let mut map = SearchedMap::new(plane);
        let ready = self.ready();
        let skin = [0, 1].map(|hand| {
            let arm = &self.hands[hand].arm;
            SkinPoints::on(&self.own, &self.own.carried_by(arm[arm.len().min(2) - 1] + 1))
        });
        let mut lanes = Vec::new();
        for hand in [1, 0] {
            self.seed = self.seed.wrapping_add(1);
            lanes.extend(self.lanes_of(hand, &skin[hand], &map, &ready));
        }
        for stop in lanes.iter().flatten().filter(|stop| stop.searches < SEARCHED + 1e-6) {
            stop.cells.iter().for_each(|&cell| map.reached[cell] = true);
        }
        Some(SearchPlan { lanes, skin, map })
    }

    /// Stops at some places with the fingers down, which takes little room; what cannot be reached so is left out.
    pub(super) fn narrow_stops(&self, hand: usize, plan: &SearchPlan, at: &[[f64; 2]]) -> Vec<Stop> {
        let Hand { limb, tip, .. } = self.hands[hand];
        let tip = self.own.place(tip);
        let frames = self.own.frames(&self.own.at_ease());
        let from_wrist = frames[tip.limb].point(&tip.point) - frames[limb].origin;
        let Some(direction) = from_wrist.try_normalize(1e-3) else { return Vec::new() };
        let sole = Place { direction: frames[tip.limb].rotation.tr_mul(&direction), ..tip };
        let places = self.places(hand, &plan.skin[hand], &plan.map);
        let stops: Vec<&Stop> = plan.lanes.iter().flatten().filter(|stop| stop.hand == hand).collect();
        let mut narrow: Vec<Stop> = Vec::new();
        for place in at {
            let away = |stop: &Stop| (stop.at[0] - place[0]).hypot(stop.at[1] - place[1]);
            let near = |stops: &mut dyn Iterator<Item = &Stop>| {
                stops.min_by(|a, b| away(a).total_cmp(&away(b))).map(|stop| stop.low().clone())
            };
            let starts = [near(&mut narrow.iter()), near(&mut stops.iter().copied())];
            let stop = starts.into_iter().flatten().find_map(|start| {
                let mut stop = Stop { worth: WORTH_NARROW, ..places.low(sole, *place, LOW, &start)? };
                places.rise(&mut stop).then_some(stop)
            });
            narrow.extend(stop);
        }
        narrow
    }

    /// Straight up from where a hand is, as far as it goes.
    pub(super) fn straight_up(&self, hand: usize, sole: Place, plan: &SearchPlan) -> Vec<Posture> {
        self.places(hand, &plan.skin[hand], &plan.map).rising(sole, &self.posture())
    }

    fn places<'a>(&'a self, hand: usize, skin: &'a SkinPoints, map: &'a SearchedMap) -> Places<'a> {
        let (own, arm) = (&self.own, &self.hands[hand].arm);
        let clearance = self.clearance.moved_by(own, arm);
        let reaching = Reaching::new(own, &self.clearance, arm.clone(), self.seed);
        Places { own, clearance, reaching, skin, map, hand, up: self.up, front: self.front }
    }

    fn lanes_of(&self, hand: usize, skin: &SkinPoints, map: &SearchedMap, ready: &[f64]) -> Vec<Vec<Stop>> {
        let (own, arm) = (&self.own, &self.hands[hand].arm);
        let side = self.side(hand);
        let places = self.places(hand, skin, map);
        let soles = soles(own, skin, &self.hands[hand]);
        let mut rng = ChaCha8Rng::seed_from_u64(self.seed);
        let drawn: Vec<(Vector3<f64>, Posture)> = (0..DRAWN)
            .filter_map(|_| {
                let posture = own.random_posture(ready, arm, &mut rng);
                let frames = own.frames(&posture);
                let at = frames[soles[0].limb].point(&soles[0].point);
                places.clearance.free(&frames, CLEAR).then_some((at, posture))
            })
            .collect();
        let mut lanes: Vec<Vec<Stop>> = Vec::new();
        let (mut before, mut started): (Vec<Option<Posture>>, _) = (Vec::new(), false);
        for lane in 0.. {
            let forward = map.plane.edge + 0.02 + LANE * f64::from(lane);
            let count = ((ACROSS[1] - ACROSS[0]) / LANE) as usize;
            let mut stops: Vec<Option<Stop>> = Vec::with_capacity(count);
            for k in 0..count {
                let place = [forward, side * (ACROSS[0] + LANE * k as f64)];
                let point = map.plane.point([place[0], place[1], LOW]);
                let mut starts: Vec<&Posture> = Vec::new();
                starts.extend(stops.last().into_iter().flatten().map(Stop::low));
                starts.extend(before.get(k).into_iter().flatten());
                let mut near: Vec<_> =
                    drawn.iter().map(|(at, posture)| ((at - point).norm_squared(), posture)).collect();
                near.sort_by(|a, b| a.0.total_cmp(&b.0));
                starts.extend(near.into_iter().take(STARTS).map(|(_, posture)| posture));
                let mut best: Option<Stop> = None;
                for &sole in &soles {
                    for start in &starts {
                        if let Some(mut stop) = places.low(sole, place, LOW, start)
                            && best.as_ref().is_none_or(|best| stop.cells.len() > best.cells.len())
                            && places.rise(&mut stop)
                        {
                            best = Some(stop);
                        }
                        if best.as_ref().is_some_and(|best| best.cells.len() >= ENOUGH) {
                            break;
                        }
                    }
                    if best.is_some() {
                        break;
                    }
                }
                stops.push(best);
            }
            before = stops.iter().map(|stop| stop.as_ref().map(|stop| stop.low().clone())).collect();
            let mut stops: Vec<Stop> = stops.into_iter().flatten().collect();
            // From its own side inwards, and back on the next lane.
            if lane % 2 == 0 {
                stops.reverse();
            }
            if stops.is_empty() && (started || lane > 6) {
                break;
            }
            started |= !stops.is_empty();
            lanes.push(stops);
        }
        for height in RIMS {
            lanes.push(self.rim_of(hand, &places, &lanes, height));
        }
        lanes
    }

    /// How far a hand gets so high over a table, all about it, from where it gets low.
    fn rim_of(&self, hand: usize, places: &Places, lanes: &[Vec<Stop>], height: f64) -> Vec<Stop> {
        let sole = Place { direction: Vector3::zeros(), ..self.own.place(self.hands[hand].tip) };
        let inner: Vec<&Stop> = lanes.iter().flatten().filter(|stop| !stop.is_rim()).collect();
        let Some(nearest) = inner.iter().map(|stop| stop.at[0]).reduce(f64::min) else { return Vec::new() };
        let middle = inner.iter().map(|stop| stop.at[1]).sum::<f64>() / inner.len() as f64;
        let polar = |stop: &Stop| {
            let [x, y] = [stop.at[0] - nearest, stop.at[1] - middle];
            (x.hypot(y), y.atan2(x))
        };
        let farthest = inner.iter().map(|stop| polar(stop).0).fold(RIM_SPACING, f64::max);
        let half = (FRAC_PI_2 * farthest / RIM_SPACING).floor() as i32;
        let mut rim: Vec<Stop> = Vec::new();
        for k in -half..=half {
            let angle = f64::from(k) * RIM_SPACING / farthest;
            let beside = |stop: &&&Stop| {
                let (radius, at) = polar(stop);
                radius * (at - angle).sin().abs() < LANE && (at - angle).cos() > 0.0
            };
            let last = inner.iter().filter(beside).max_by(|a, b| polar(a).0.total_cmp(&polar(b).0));
            let Some(last) = last else { continue };
            let (from, mut found) = (polar(last).0 - LANE, None::<Stop>);
            // From beside the last place first: so that the arm need but turn from the one to the other.
            let beside = rim.last().map(Stop::low);
            for step in 0..=RIM_STEPS {
                let radius = from + RIM_STEP * f64::from(step);
                let place = [nearest + radius * angle.cos(), middle + radius * angle.sin()];
                let starts = match &found {
                    Some(found) => vec![found.low()],
                    None => beside.into_iter().chain([last.low()]).collect(),
                };
                let stop = starts.into_iter().find_map(|start| places.low(sole, place, height, start));
                found = stop.map(|stop| Stop { worth: WORTH_FAR, ..stop }).or(found);
            }
            if let Some(mut stop) = found
                && places.rise(&mut stop)
            {
                rim.push(stop);
            }
        }
        rim
    }
}
