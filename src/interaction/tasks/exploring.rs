//! Exploring a table blind: a hand is lowered until it feels it, then sweeps over it until something is felt.

use nalgebra::Vector3;

use super::{MARGIN, SWEEPING, Trouble, tried};
use crate::creature::Posture;
use crate::interaction::actor::{Actor, CAREFUL, FoundThing, Hand, TABLE};
use crate::kinematics::REACHED;
use crate::peripersonal::{PosturePath, ReachTarget, Reaching, straight};
use crate::senses::Toucher;

/// How high over the table the tip of a sweeping hand goes, metres: things lower than this are not found.
const SWEEP_HEIGHT: f64 = 0.03;
/// How far apart the lanes of a sweep are, metres.
const LANE: f64 = 0.06;
/// Steps along a lane, metres.
const STRIDE: f64 = 0.02;
/// How far down a hand looks for a table, metres.
const FARTHEST_DOWN: f64 = 1.0;

impl Actor {
    /// Lowers a hand in front of it until it feels something, and takes that for the table.
    ///
    /// # Errors
    /// [`Trouble`]; [`Trouble::Nothing`] where there is no table.
    pub fn feel_table(&mut self, hand: usize) -> Result<f64, Trouble> {
        let (height, _) = self.lower_hand(hand)?;
        self.know_table(height);
        Ok(height)
    }

    /// Lowers both hands, takes the lower of what they feel for the table, and so knows it. What a hand felt well above that
    /// is a thing that stands there.
    ///
    /// # Errors
    /// [`Trouble::Engine`] alone: where neither hand feels anything the table stays unknown.
    pub fn find_table(&mut self) -> Result<Option<FoundThing>, Trouble> {
        let mut felt = Vec::new();
        for hand in 0..self.hands.len() {
            felt.extend(tried(self.lower_hand(hand))?);
        }
        let Some(table) = felt.iter().map(|(height, _)| *height).reduce(f64::min) else { return Ok(None) };
        self.know_table(table);
        Ok(felt.into_iter().find(|(height, _)| height - table > TABLE).and_then(|(_, found)| found))
    }

    /// Lowers a hand until it feels something and takes it back: the height of that, metres, and what it felt.
    fn lower_hand(&mut self, hand: usize) -> Result<(f64, Option<FoundThing>), Trouble> {
        let start = self.posture();
        let way = self.upwards(self.hands[hand].tip, -FARTHEST_DOWN);
        let contacts = self.follow(&PosturePath(way), CAREFUL, |_, _| true)?;
        if contacts.is_empty() {
            return Err(Trouble::Nothing);
        }
        if contacts.iter().any(|contact| matches!(contact.by, Toucher::Own(_))) {
            // Its own leg is no table.
            let _ = self.retreat(&start);
            return Err(Trouble::Nothing);
        }
        let heights = contacts.iter().map(|contact| {
            let place = self.own.place(contact.spot.receptor);
            // The lowest point of the surface that felt it.
            let surface = self.own.skin().receptors[contact.spot.receptor].surface;
            let frame = self.frames()[place.limb];
            let lowest = surface
                .and_then(|s| self.own.skin().surfaces[s].support(&frame.rotation.tr_mul(&-self.up)))
                .unwrap_or(place.point);
            frame.point(&lowest).dot(&self.up)
        });
        let height = heights.fold(f64::INFINITY, f64::min);
        let found = contacts.iter().find_map(|contact| self.found(contact));
        self.retreat(&start)?;
        Ok((height, found))
    }

    /// The lanes of a sweep over the table with a hand: postures, lane by lane, nearest first.
    fn lanes(&mut self, hand: usize) -> Vec<PosturePath> {
        let Some(height) = self.table else { return Vec::new() };
        let Hand { arm, tip, .. } = self.hands[hand].clone();
        let (front, left, up, side) = (self.front, self.left(), self.up, self.side(hand));
        let edge = self.trunk_front(height);
        let place = self.own.place(tip);
        let mut posture = self.ready();
        let mut lanes = Vec::new();
        let own = &self.own;
        let clearance = &self.clearance.moved_by(own, &arm);
        let reaching = Reaching::new(own, clearance, arm, 0);
        for lane in 0..12 {
            let forward = edge + 0.08 + LANE * f64::from(lane);
            // Stretches without a gap, of which the longest is swept.
            let mut stretches: Vec<Vec<Posture>> = vec![Vec::new()];
            for k in 0..44 {
                // From its own side inwards, and back on the next lane.
                let share = if lane % 2 == 0 { 43 - k } else { k };
                let across = side * (-0.2 + STRIDE * f64::from(share));
                let point = front * forward + left * across + up * (height + SWEEP_HEIGHT);
                let reach =
                    reaching.solve(place, &ReachTarget { point, direction: Vector3::zeros() }, &posture);
                let free = reach.miss <= REACHED && clearance.free(&own.frames(&reach.posture), MARGIN);
                let last = stretches.last().and_then(|stretch| stretch.last());
                let near =
                    last.is_none_or(|last| straight(own, clearance, last, &reach.posture, 0.5 * MARGIN));
                if !(free && near) {
                    stretches.push(Vec::new());
                } else if let Some(stretch) = stretches.last_mut() {
                    posture.clone_from(&reach.posture);
                    stretch.push(reach.posture);
                }
            }
            let longest = stretches.into_iter().rev().max_by_key(Vec::len);
            lanes.extend(longest.filter(|stretch| stretch.len() > 3).map(PosturePath));
        }
        lanes
    }

    /// Sweeps the table with a hand until something is felt, by whatever part of the arm, at last on its way back to where
    /// it waits. `None` if all that it reaches is empty. The table must be known.
    ///
    /// # Errors
    /// [`Trouble`].
    pub fn explore(&mut self, hand: usize) -> Result<Option<FoundThing>, Trouble> {
        let lanes = self.lanes(hand);
        let arm = self.hands[hand].arm.clone();
        for lane in lanes {
            let from = self.posture();
            let Some(first) = lane.0.first().cloned() else { continue };
            let Ok(way) = self.find_path([&from, &first], &arm) else { continue };
            for way in [way, lane] {
                let contacts = self.follow(&way, SWEEPING, |actor, contact| !actor.is_table(contact))?;
                if let Some(found) = contacts.iter().find_map(|contact| self.found(contact)) {
                    return Ok(Some(found));
                }
            }
        }
        let ready = self.ready();
        match self.go(&ready) {
            Err(Trouble::Engine(error)) => Err(error.into()),
            Err(Trouble::Hit(contacts)) => Ok(contacts.iter().find_map(|contact| self.found(contact))),
            _ => Ok(None),
        }
    }
}
