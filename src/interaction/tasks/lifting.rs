//! Lifting a thing between both palms, blind: it is held by friction alone, as hard as the palms squeeze it.
//!
//! The palms come down on either side of where the thing was felt, close until each feels it, and shift along it until it
//! lies about their middles. They squeeze until both feel force enough: what stands askew turns until a side lies against a
//! palm, as between the jaws of a gripper (Goldberg 1993). Then they rise, and go on to press where the force falls off.
//! That it slips is felt: a palm feels nothing any more, or feels it lower and lower.

use nalgebra::Vector3;

use super::two_palms::{PalmPlan, RISE};
use super::{BACK, Trouble};
use crate::creature::Posture;
use crate::interaction::actor::{Actor, CAREFUL, FoundThing};
use crate::senses::{SkinContact, Toucher};

/// How far behind the place where it was felt the middle of a thing is taken to be, metres: half of a small one.
const BEHIND: f64 = 0.04;
/// How high a thing is lifted, metres.
pub const LIFT: f64 = 0.11;
/// The least that counts as lifted, metres.
const HIGH_ENOUGH: f64 = 0.09;
/// How fast, metres a second.
const LIFTING: f64 = 0.1;
/// Steps in which palms go where they expect something, metres, …
const STEP: f64 = 1e-3;
/// … and in which they squeeze, metres, …
const SQUEEZE: f64 = 1e-4;
/// … one in so many seconds.
const SQUEEZE_TIME: f64 = 4e-3;
/// At which share of the height at which a thing was felt it is gripped: about its middle, since what hangs by the fingertips
/// below its middle turns over.
const GRIPPED_AT: f64 = 0.6;
/// How high over the table fingertips grip when the palms are down, metres, …
const FINGERTIP: f64 = 0.015;
/// … how much higher it is worth to grip, since what is round may roll off meanwhile, …
const LEAST_HIGHER: f64 = 0.03;
/// … and how much higher they grip at most; …
const HIGHEST_GRIP: f64 = 0.06;
/// … so far open meanwhile, metres, that nothing is rubbed and nothing gets away.
const EASED: f64 = 0.008;
/// The force that each palm is to feel at first, newtons: more than twice what friction of 0.5 needs to bear a kilogram.
const FORCE: f64 = 25.0;
/// By how much harder it squeezes what slipped.
const HARDER: f64 = 3.0;
/// Of the force wanted: below this share a palm presses on, …
const SLACK: f64 = 0.9;
/// … so far in each step where it feels none, metres, and less the more it feels: what tapers is followed, …
const HOLD: f64 = 6e-4;
/// … above this one it eases.
const TIGHT: f64 = 4.0;
/// Palms that are no farther apart than this have nothing between them, metres.
const NOTHING_BETWEEN: f64 = 0.025;
/// What is felt no farther than this from where the fingertips press is about the middle of the palms, metres.
const CENTRED: f64 = 0.012;
/// How far ahead a thing is looked for that is not between the palms, one after the other, metres: twice as far as it may
/// be thick, and a little less each time than the palms are long.
const AHEAD: [f64; 6] = [0.0, 0.04, -0.04, 0.08, -0.08, 0.12];
/// How often the palms shift along a thing.
const SHIFTS: usize = 3;
/// How far palms open to shift, metres.
const SHIFT_OPEN: f64 = 0.03;
/// How far aside palms go where one came down on the thing, metres, …
const ASIDE: f64 = 0.03;
/// … and how often.
const DESCENTS: usize = 4;
/// How long a palm feels nothing until the thing has slipped, seconds.
const LOST: f64 = 0.05;
/// How high it is when it is felt where on the palms it hangs, metres.
const OFF_TABLE: f64 = 0.015;
/// How much lower than then a thing is felt that has slipped, metres.
const SLIPPED: f64 = 0.04;
/// Squeezes after which a force is taken to be there to stay.
const FIRM: usize = 6;
/// What a hand beside a thing feels no higher than this over the table is the table, metres.
const LOW: f64 = 0.03;
/// How far palms open to let go, metres, …
const LET_GO: f64 = 0.05;
/// … and slowly so far.
const SETTLING: f64 = 0.005;

/// A thing between both palms.
#[derive(Clone, Debug)]
pub struct Grip {
    /// How the palms face each other.
    pub plan: PalmPlan,
    /// What is held.
    pub thing: usize,
    /// How far each palm is from the middle of the plan, metres.
    pub apart: [f64; 2],
    /// How far it is raised, metres.
    pub rise: f64,
    /// How far the palms are raised where they grip it on the table, metres.
    pub gripped: f64,
    /// The force that each palm is to feel, newtons.
    pub force: f64,
    /// The highest at which anything of it was felt, metres over the table.
    tallest: f64,
    /// Where between the palms it was last felt, in the root's frame.
    last_felt: Option<Vector3<f64>>,
    /// How high on the palms it was felt when it came off the table, metres.
    felt_at: Option<f64>,
}

/// What both palms feel of a thing while they move.
#[derive(Clone, Debug, Default)]
struct PalmFeeling {
    /// Mean normal force on each, newtons.
    force: [f64; 2],
    /// Whether each felt it at the last.
    touches: [bool; 2],
    /// Where each felt it on the palm: towards the fingertips and up, metres.
    place: [Option<[f64; 2]>; 2],
    /// Whether anything else was felt than the thing by hands, and the table.
    hit: Vec<SkinContact>,
}

impl PalmFeeling {
    /// The mean over both palms of where they felt it, along one way.
    fn mean_place(&self, way: usize) -> Option<f64> {
        let felt: Vec<f64> = self.place.iter().flatten().map(|place| place[way]).collect();
        (!felt.is_empty()).then(|| felt.iter().sum::<f64>() / felt.len() as f64)
    }
}

impl Actor {
    /// Takes a thing that was felt between both palms, and lifts it. What felt it goes back first. Where that does not come
    /// off it is taken again, otherwise and harder, up to `corrections` times.
    ///
    /// # Errors
    /// [`Trouble`].
    pub fn lift(&mut self, found: &FoundThing, corrections: usize) -> Result<Grip, Trouble> {
        let ready = self.ready();
        match self.withdraw(found, &ready) {
            Err(Trouble::Hit(contacts)) => self.back_off(&contacts, BACK)?,
            Err(Trouble::Reach(_)) => {}
            went => went?,
        }
        let level = (found.direction - self.up * found.direction.dot(&self.up)).try_normalize(0.3);
        let mut middle = found.point + level.unwrap_or(self.front) * BEHIND;
        let mut tallest = self.over_table(&found.point).ok_or(Trouble::Nothing)?;
        let (mut tried, mut force) = (Vec::new(), FORCE);
        for correction in 0..=corrections {
            let planned = self.plan_palms(&middle, &tried);
            let (plan, yaw) = planned.or_else(|_| self.plan_palms(&middle, &[]))?;
            tried.push(yaw);
            let mut grip = Grip {
                apart: plan.openings,
                rise: RISE,
                gripped: 0.0,
                tallest,
                thing: found.thing,
                last_felt: None,
                felt_at: None,
                force,
                plan,
            };
            match self.raise_palms_over(&grip.plan) {
                // Another way, with the palms otherwise.
                Err(Trouble::Hit(contacts)) if correction < corrections => {
                    self.back_off(&contacts, BACK)?;
                    continue;
                }
                went => went?,
            }
            let lifted = self.take(&mut grip).and_then(|()| {
                let raised = grip.gripped + LIFT;
                self.carry(&mut grip, raised)
            });
            let trouble = match lifted {
                Ok(()) => return Ok(grip),
                Err(trouble) => trouble.of_task()?,
            };
            // From where it was felt last; what slipped is near there.
            middle = grip.last_felt.unwrap_or(middle);
            tallest = grip.tallest;
            self.give_up(&mut grip)?;
            if correction == corrections {
                return Err(trouble);
            }
            if matches!(trouble, Trouble::Slipped) {
                force *= HARDER;
            }
        }
        Err(Trouble::Slipped)
    }

    /// Holds what is between the palms up for some time.
    ///
    /// # Errors
    /// [`Trouble::Slipped`] where it is felt to slip.
    pub fn hold_up(&mut self, grip: &mut Grip, seconds: f64) -> Result<(), Trouble> {
        let (mut lost, step) = (0.0, STEP / LIFTING);
        for _ in 0..(seconds / step).ceil() as usize {
            self.bear(grip, grip.rise, step, &mut lost)?;
        }
        Ok(())
    }

    /// Sets what is between the palms down where it was, and lets go of it.
    ///
    /// # Errors
    /// [`Trouble::Slipped`] where it fell on the way.
    pub fn set_down(&mut self, grip: &mut Grip) -> Result<(), Trouble> {
        let down = self.carry(grip, grip.gripped);
        self.open(grip)?;
        self.palms_up(grip)?;
        down
    }

    /// Comes down on both sides of a thing, feels along them, closes about the middle, and squeezes.
    fn take(&mut self, grip: &mut Grip) -> Result<(), Trouble> {
        self.come_down(grip)?;
        self.find_middle(grip)?;
        self.grip_high(grip)?;
        self.squeeze(grip)
    }

    /// Takes the palms from where they are down to about the middle of what is tall.
    fn grip_high(&mut self, grip: &mut Grip) -> Result<(), Trouble> {
        let high = (GRIPPED_AT * grip.tallest - FINGERTIP).clamp(0.0, HIGHEST_GRIP);
        if high < LEAST_HIGHER {
            return Ok(());
        }
        self.take_palms(grip, grip.apart.map(|apart| apart + EASED), grip.rise, CAREFUL)?;
        self.take_palms(grip, grip.apart, high, CAREFUL)?;
        grip.gripped = grip.rise;
        self.close(grip)?;
        Ok(())
    }

    /// Feels the sides of a thing from end to end with the fingertips, and closes the palms about the middle of them.
    fn find_middle(&mut self, grip: &mut Grip) -> Result<(), Trouble> {
        let wide = grip.apart;
        // First where anything is felt, and with the fingertips.
        let mut felt = None;
        let mut now = 0.0;
        for ahead in AHEAD {
            if !self.go_along(grip, ahead - now, wide)? {
                continue;
            }
            now = ahead;
            felt = self.feel_sides(grip, wide)?;
            if felt.is_some() {
                break;
            }
        }
        let mut place = felt.ok_or(Trouble::Nothing)?;
        // Then so that it is about their middles.
        for _ in 0..SHIFTS {
            if place.abs() <= CENTRED {
                break;
            }
            let apart = grip.apart.map(|apart| apart + SHIFT_OPEN);
            if !self.go_along(grip, place, apart)? {
                break;
            }
            match self.feel_sides(grip, wide)? {
                Some(now) => place = now,
                None => return Err(Trouble::Nothing),
            }
        }
        if grip.width() > NOTHING_BETWEEN && place.abs() > CENTRED {
            self.close(grip)?;
        }
        Ok(())
    }

    /// Closes the palms, and tells how far towards the fingertips they feel the thing, metres; `None` if there is nothing
    /// between them, which leaves them apart.
    fn feel_sides(&mut self, grip: &mut Grip, apart: [f64; 2]) -> Result<Option<f64>, Trouble> {
        match self.close(grip) {
            Err(Trouble::Nothing | Trouble::NoSides) => {
                self.take_palms(grip, apart, grip.rise, CAREFUL)?;
                Ok(None)
            }
            felt => {
                let place = felt?;
                grip.last_felt = Some(grip.middle() + grip.plan.forward * place);
                Ok(Some(place))
            }
        }
    }

    /// Opens the palms, and shifts them towards where the fingers point; whether the arms get there. Where they do not, they
    /// are where they were.
    fn go_along(&mut self, grip: &mut Grip, far: f64, apart: [f64; 2]) -> Result<bool, Trouble> {
        self.take_palms(grip, apart, grip.rise, CAREFUL)?;
        let begun = grip.plan.middle;
        match self.shift(grip, grip.plan.forward * far) {
            Err(Trouble::NoSides) => {
                let back = begun - grip.plan.middle;
                self.shift(grip, back)?;
                Ok(false)
            }
            shifted => shifted.map(|()| true),
        }
    }

    /// Takes the palms to so far from the middle each, and to a height, in steps, as far as the arms go.
    fn take_palms(&mut self, grip: &mut Grip, apart: [f64; 2], rise: f64, speed: f64) -> Result<(), Trouble> {
        let (begun, low) = (grip.apart, grip.rise);
        let far = (0..2).map(|k| (apart[k] - begun[k]).abs()).fold((rise - low).abs(), f64::max);
        let steps = (far / STEP).ceil();
        for k in 1..=steps as usize {
            let share = k as f64 / steps;
            let apart = [0, 1].map(|hand| begun[hand] + share * (apart[hand] - begun[hand]));
            match self.move_palms(grip, apart, low + share * (rise - low), STEP / speed, [false; 2]) {
                Err(Trouble::NoSides) => break,
                moved => moved?,
            };
        }
        Ok(())
    }

    /// Lowers the palms until they are down, without meeting anything; where one comes down on the thing, both go aside.
    fn come_down(&mut self, grip: &mut Grip) -> Result<(), Trouble> {
        let mut met = [false; 2];
        for _ in 0..DESCENTS {
            let mut feeling = PalmFeeling::default();
            while grip.rise > 0.0 {
                let rise = (grip.rise - STEP).max(0.0);
                feeling = self.move_palms(grip, grip.apart, rise, STEP / CAREFUL, [true; 2])?;
                if feeling.touches != [false; 2] || !feeling.hit.is_empty() {
                    break;
                }
            }
            if grip.rise <= 0.0 && feeling.touches == [false; 2] {
                return Ok(());
            }
            self.unintended += 1;
            if !feeling.hit.is_empty() {
                return Err(Trouble::Hit(feeling.hit));
            }
            for (met, touches) in met.iter_mut().zip(feeling.touches) {
                *met |= touches;
            }
            self.palms_up(grip)?;
            if met == [true; 2] {
                return Err(Trouble::TooWide);
            }
            let aside = grip.plan.outward[usize::from(met[1])] * ASIDE;
            self.shift(grip, aside)?;
        }
        Err(Trouble::TooWide)
    }

    /// Closes the palms until both feel the thing: how far towards the fingertips they do, metres.
    fn close(&mut self, grip: &mut Grip) -> Result<f64, Trouble> {
        let mut felt = PalmFeeling::default();
        while felt.touches != [true; 2] {
            if grip.width() < NOTHING_BETWEEN {
                return Err(Trouble::Nothing);
            }
            let apart = [0, 1].map(|k| grip.apart[k] - if felt.touches[k] { 0.0 } else { STEP });
            let until = felt.touches.map(|touches| !touches);
            let feeling = self.move_palms(grip, apart, grip.rise, STEP / CAREFUL, until)?;
            for k in 0..2 {
                felt.touches[k] |= feeling.touches[k];
                felt.place[k] = feeling.place[k].or(felt.place[k]);
            }
            // Where the hands meet each other there is nothing between them.
            if feeling.hit.iter().any(|contact| matches!(contact.by, Toucher::Own(_))) {
                return Err(Trouble::Nothing);
            }
            if !feeling.hit.is_empty() {
                self.unintended += 1;
                return Err(Trouble::Hit(feeling.hit));
            }
        }
        Ok(felt.mean_place(0).unwrap_or(0.0))
    }

    /// Opens the palms so far each that they let go: slowly at first, so that what stands askew settles.
    fn open(&mut self, grip: &mut Grip) -> Result<(), Trouble> {
        let opened = grip.apart.map(|apart| apart + LET_GO);
        self.take_palms(grip, grip.apart.map(|apart| apart + SETTLING), grip.rise, 0.2 * CAREFUL)?;
        self.take_palms(grip, opened, grip.rise, CAREFUL)
    }

    /// Moves both palms, and the middle between them, along the table. Where the arms do not get there, they stay where they
    /// got to.
    fn shift(&mut self, grip: &mut Grip, by: Vector3<f64>) -> Result<(), Trouble> {
        let steps = (by.norm() / STEP).ceil().max(1.0);
        for _ in 0..steps as usize {
            let before = grip.plan.middle;
            grip.plan.middle += by / steps;
            let moved = self.move_palms(grip, grip.apart, grip.rise, STEP / CAREFUL, [false; 2]);
            if let Err(trouble) = moved {
                grip.plan.middle = before;
                return Err(trouble);
            }
        }
        Ok(())
    }

    /// Squeezes until both palms feel the force wanted.
    fn squeeze(&mut self, grip: &mut Grip) -> Result<(), Trouble> {
        let mut firm = 0;
        let mut feeling = PalmFeeling::default();
        while firm < FIRM {
            if grip.width() < NOTHING_BETWEEN {
                return Err(Trouble::Nothing);
            }
            let presses = |k: usize| if feeling.force[k] < grip.force { SQUEEZE } else { 0.0 };
            let apart = [0, 1].map(|k| grip.apart[k] - presses(k));
            feeling = self.move_palms(grip, apart, grip.rise, SQUEEZE_TIME, [false; 2])?;
            firm = if feeling.force.iter().all(|force| *force >= grip.force) { firm + 1 } else { 0 };
        }
        Ok(())
    }

    /// Raises or lowers what is between the palms to a height over where it stood, metres.
    fn carry(&mut self, grip: &mut Grip, to: f64) -> Result<(), Trouble> {
        let mut lost = 0.0;
        while grip.rise != to {
            let rise = if to > grip.rise { (grip.rise + STEP).min(to) } else { (grip.rise - STEP).max(to) };
            match self.bear(grip, rise, STEP / LIFTING, &mut lost) {
                // As high as the arms go.
                Err(Trouble::NoSides) if to > rise && rise > grip.gripped + HIGH_ENOUGH => break,
                borne => borne?,
            }
        }
        Ok(())
    }

    /// Goes on for a moment with a thing between the palms, and presses as it is felt; `lost` is for how long a palm has felt
    /// nothing.
    fn bear(&mut self, grip: &mut Grip, rise: f64, seconds: f64, lost: &mut f64) -> Result<(), Trouble> {
        let feeling = self.move_palms(grip, grip.apart, rise, seconds, [false; 2])?;
        for k in 0..2 {
            let share = feeling.force[k] / grip.force;
            if share < SLACK {
                grip.apart[k] -= HOLD * (1.0 - share);
            } else if share > TIGHT {
                grip.apart[k] += 0.5 * SQUEEZE;
            }
        }
        *lost = if feeling.touches == [true; 2] { 0.0 } else { *lost + seconds };
        if grip.felt_at.is_none() && rise >= grip.gripped + OFF_TABLE && feeling.touches == [true; 2] {
            grip.felt_at = feeling.mean_place(1);
        }
        let sunk = grip.felt_at.zip(feeling.mean_place(1)).map_or(0.0, |(before, now)| before - now);
        if *lost > LOST || sunk > SLIPPED || grip.width() < NOTHING_BETWEEN {
            return Err(Trouble::Slipped);
        }
        Ok(())
    }

    /// Lowers the hands, lets go, and raises them again.
    fn give_up(&mut self, grip: &mut Grip) -> Result<(), Trouble> {
        self.take_palms(grip, grip.apart, grip.gripped.min(grip.rise), LIFTING)?;
        self.open(grip)?;
        self.palms_up(grip)
    }

    /// Raises the palms to where they came down from.
    fn palms_up(&mut self, grip: &mut Grip) -> Result<(), Trouble> {
        self.take_palms(grip, grip.apart, RISE.max(grip.rise), CAREFUL)
    }

    /// Takes the palms straight to a distance from the middle and a height; `until` tells which of them are to stop all where
    /// they feel the thing. The grip is then where they got to.
    fn move_palms(
        &mut self,
        grip: &mut Grip,
        apart: [f64; 2],
        rise: f64,
        seconds: f64,
        until: [bool; 2],
    ) -> Result<PalmFeeling, Trouble> {
        let start = self.posture();
        let target = self.palms_at(&grip.plan, apart, rise, &start).ok_or(Trouble::NoSides)?;
        let steps = (seconds / self.handle.timestep()).round().max(1.0) as usize;
        let mut feeling = PalmFeeling::default();
        let mut gone = 0;
        for k in 1..=steps {
            gone = k;
            let posture = Posture::between(self.own.creature(), &start, &target, k as f64 / steps as f64);
            let felt = self.step(&posture)?;
            feeling.touches = [false; 2];
            let mut places = [(0.0, [0.0; 2]); 2];
            for contact in felt {
                let receptor = contact.spot.receptor;
                let hand = self.hands.iter().position(|hand| hand.receptors.contains(&receptor));
                match (contact.by, hand) {
                    (Toucher::Thing(thing), Some(hand)) if thing == grip.thing => {
                        feeling.touches[hand] = true;
                        feeling.force[hand] += contact.force;
                        if let Some(height) = self.over_table(&self.feels_at(receptor).0) {
                            grip.tallest = grip.tallest.max(height);
                        }
                        if k == steps || until[hand] {
                            let [along, up] = grip.plan.place_of(&self.own, hand, receptor);
                            let (weight, sum) = &mut places[hand];
                            *weight += contact.force;
                            sum[0] += contact.force * along;
                            sum[1] += contact.force * up;
                        }
                    }
                    (Toucher::Thing(thing), _) if thing != grip.thing && self.is_low(&contact) => {}
                    _ => feeling.hit.push(contact),
                }
            }
            for (place, (weight, sum)) in feeling.place.iter_mut().zip(places) {
                if weight > 0.0 {
                    *place = Some(sum.map(|sum| sum / weight));
                }
            }
            if (0..2).any(|hand| until[hand] && feeling.touches[hand]) {
                break;
            }
        }
        let share = gone as f64 / steps as f64;
        for (k, wanted) in apart.into_iter().enumerate() {
            grip.apart[k] += share * (wanted - grip.apart[k]);
            feeling.force[k] /= gone as f64;
        }
        grip.rise = if gone == steps { rise } else { grip.rise + share * (rise - grip.rise) };
        Ok(feeling)
    }

    /// Whether something is felt so low that it is the table that a hand goes along.
    fn is_low(&self, contact: &SkinContact) -> bool {
        self.over_table(&self.feels_at(contact.spot.receptor).0).is_some_and(|height| height < LOW)
    }

    /// How high a point of the root's frame is over the table, metres; `None` if no table is known.
    pub(super) fn over_table(&self, point: &Vector3<f64>) -> Option<f64> {
        self.table.map(|table| point.dot(&self.up) - table)
    }
}

impl Grip {
    /// How far the palms are apart, metres.
    fn width(&self) -> f64 {
        self.apart[0] + self.apart[1]
    }

    /// Between the palms as they are, at the height of the table, in the root's frame.
    pub fn middle(&self) -> Vector3<f64> {
        let [one, other] = self.plan.outward;
        self.plan.middle + 0.5 * (one * self.apart[0] + other * self.apart[1])
    }
}
