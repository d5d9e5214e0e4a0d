//! Growing up: few joints are learned at first, and more as they are known.
//!
//! All joints move at random at first. Where that touches soon, and there is not too much to be learned, all go on moving, to where
//! the touch that is foreseen tells most ([`motions`]). Else some that touched each other most are learned; where that is in vain, all
//! rest but a few, and which few is found by trial ([`trials`]). Once they are known (see
//! [`Growth`](crate::learning::growth)), what is known moves, and one joint more, or two or three; or only what is
//! known, towards a limb that is not placed yet ([`goals`]). Where the schema tells how, motions are aimed; where it does
//! not, what was touched once is touched again, a little differently; and only ways are gone on which, as the schema
//! foresees, the wanted limb is the first to meet another ([`motions`]).

mod goals;
mod motions;
mod trials;

use std::collections::BTreeMap;

use rand::RngExt;
use rand_chacha::ChaCha8Rng;

use self::goals::UNPROMISING;
use self::trials::{FirstSet, TRIAL_MOTIONS};
use super::foresight::Foresight;
use super::{Policy, PolicyStart};
use crate::agent::Agent;
use crate::creature::Posture;
use crate::learning::LengthUnit;
use crate::learning::growth::{Growth, Outlook};
use crate::senses::Touch;
use crate::simulation::Ending;

/// Share of motions for the first part that repeat a touch, where touches are rare: others tell more.
const REPEATED_AT_FIRST: f64 = 0.5;
/// Share of motions that go anywhere.
const ANYWHERE: f64 = 0.15;
/// Share of the others that repeat a touch though they could be aimed.
const REPEATED: f64 = 0.3;
/// … and where it is not known well enough where to aim.
const REPEATED_UNSURE: f64 = 0.7;
/// Share of motions for a limb, where all that is not known is learned at once, that go where the touch tells most.
const EXPLORED: f64 = 0.5;
/// Draws of two receptors to aim at.
const AIMS: usize = 8;
/// The share of the way back that is gone to part limbs in touch.
const RETREAT: f64 = 0.5;
/// Goals that are considered before a motion goes anywhere because none of them promises anything.
const GOALS: usize = 3;
/// Motions in a row without any touch after which it is given up to find a first part of the body with few joints moving.
const MOST_IN_VAIN: usize = 15_000;
/// Touches at random with all joints, which are made where no first part was found, …
const AT_RANDOM: usize = 2500;
/// … and after how many of them the body starts over, lest all are of the limbs that it got caught in.
const AT_A_TIME: usize = 25;
/// Motions in a row without a touch that tells anything, after which a body caught in itself starts over.
const CAUGHT: usize = 12;

/// The policy `stages`.
pub struct Stages {
    /// The agent, in the unit of length that its body is learned in: how many metres that is.
    agent: Agent,
    metres: f64,
    growth: Growth,
    foresight: Foresight,
    /// Per joint, the share of the skin on the side of it where there is less.
    lever: Vec<f64>,
    /// Sets of joints for the first part; the present one; and whether it is still to be seen which is best.
    trials: Vec<FirstSet>,
    trial: usize,
    is_choosing: bool,
    /// Whether it touches soon where all joints move.
    all_move: bool,
    aim: Goal,
    /// Per limb, whether a touch of it with one that is not tells what the goal asks.
    wanted: Vec<bool>,
    /// Per pair of limbs, the touches that it serves the goal to repeat.
    repeatable: BTreeMap<[usize; 2], Vec<usize>>,
    /// Per joint, whether it moves.
    free: Vec<bool>,
    /// Motions for the present goal, and the most.
    motions: usize,
    patience: usize,
    /// What is believed of the whole body after the last touch, where it was asked for.
    outlook: Option<Outlook>,
    /// Whether something was learned from the last touch.
    grown: bool,
    /// Times that all that was learned was looked at once more.
    looks: usize,
    tried: Option<Goal>,
    tries: BTreeMap<Goal, f64>,
    /// Per touch, its posture and where the motion to it began.
    remembered: Vec<[Posture; 2]>,
    start: Posture,
    /// Where the body starts, and joints rest; none before it moves.
    home: Option<Posture>,
    /// What was met last and has not parted since.
    met: Option<Met>,
    /// Motions in a row that told nothing, and that ended in no touch.
    caught: usize,
    untouched: usize,
    /// Touches at random with all joints; `None` if the body grows.
    at_random: Option<usize>,
    over: bool,
    done: bool,
}

/// What a motion ended at.
struct Met {
    /// Whether it is bare geometry.
    bare: bool,
    /// Where the motion came from.
    back: Posture,
    /// Whether a motion since then did not part it.
    held: bool,
}

/// What motions are made for.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Goal {
    /// That joints are learned.
    Joints(Vec<usize>),
    /// That a limb is placed.
    Limb(usize),
}

impl Stages {
    /// The policy of a body of which nothing is known.
    pub fn new(agent: &Agent, start: PolicyStart) -> Stages {
        let unit = LengthUnit::of(agent);
        let agent = &unit.agent(agent);
        let creature = agent.creature();
        let joints = creature.joints().len();
        let mut beyond = vec![0.0; joints];
        for receptor in &agent.skin().receptors {
            let mut limb = receptor.limb;
            while let Some(joint) = creature.joint_of(limb) {
                beyond[joint] += 1.0;
                limb = creature.joints()[joint].parent;
            }
        }
        let all = agent.skin().receptors.len().max(1) as f64;
        let mut growth = Growth::new(agent, start.seed);
        growth.learn_from(start.input);
        growth.end_at(start.deadline);
        growth.hurry(true);
        let mut stages = Stages {
            agent: agent.clone(),
            metres: unit.metres(),
            foresight: Foresight::new(agent),
            lever: beyond.iter().map(|beyond: &f64| beyond.min(all - beyond) / all).collect(),
            trials: vec![FirstSet::of((0..joints).collect())],
            trial: 0,
            is_choosing: true,
            all_move: false,
            aim: Goal::Joints(Vec::new()),
            wanted: vec![false; creature.limbs().len()],
            repeatable: BTreeMap::new(),
            free: vec![false; joints],
            motions: 0,
            patience: TRIAL_MOTIONS,
            outlook: None,
            grown: false,
            looks: 0,
            tried: None,
            tries: BTreeMap::new(),
            remembered: Vec::new(),
            start: Posture::default(),
            home: None,
            met: None,
            caught: 0,
            untouched: 0,
            at_random: None,
            over: false,
            done: growth.resolved().iter().all(|&resolved| resolved),
            growth,
        };
        stages.move_set(0, TRIAL_MOTIONS);
        stages
    }

    fn begin(&mut self, goal: Goal, patience: usize) {
        self.free = self.growth.resolved().to_vec();
        if self.growth.schema().is_none() {
            self.free.fill(false);
        }
        if let Goal::Joints(joints) = &goal {
            joints.iter().for_each(|&joint| self.free[joint] = true);
        }
        self.aim = goal;
        self.wanted = self.limbs_wanted();
        self.repeatable.clear();
        (0..self.growth.touches().len()).for_each(|number| self.remember(number));
        (self.motions, self.patience) = (0, patience);
    }

    /// The joints that the present goal is to learn.
    fn joints(&self) -> &[usize] {
        match &self.aim {
            Goal::Joints(joints) => joints,
            Goal::Limb(_) => &[],
        }
    }

    /// Per limb, whether it is moved by the joints to be learned, or is the one to be placed.
    fn limbs_wanted(&self) -> Vec<bool> {
        let creature = self.agent.creature();
        let mut wanted = vec![false; creature.limbs().len()];
        match self.aim {
            Goal::Limb(limb) => wanted[limb] = true,
            _ => creature.joints().iter().enumerate().for_each(|(joint, at)| {
                wanted[joint + 1] = wanted[at.parent] || self.joints().contains(&joint);
            }),
        }
        wanted
    }

    /// Some of the way back from what was met or, where that did not part it, anywhere.
    fn retreat(&self, met: &Met, rng: &mut ChaCha8Rng) -> Posture {
        match met.held {
            true => self.anywhere(rng),
            false => Posture::between(self.agent.creature(), &self.start, &met.back, RETREAT),
        }
    }

    /// Takes stock after a motion.
    fn take_stock(&mut self) {
        let grown = std::mem::take(&mut self.grown);
        match self.growth.schema() {
            None if self.at_random.is_some_and(|touches| touches >= AT_RANDOM) => self.done = true,
            None if self.at_random.is_some() => {}
            None if self.growth.gave_up() || self.untouched >= MOST_IN_VAIN => {
                self.at_random = Some(0);
                self.free.fill(true);
                self.over = true;
            }
            None => self.try_on(),
            Some(_) if grown || self.motions >= self.patience => self.next_goal(),
            Some(_) => {}
        }
    }

    /// The posture to move towards from `self.start`.
    fn choose_target(&mut self, rng: &mut ChaCha8Rng) -> Posture {
        let first = self.growth.schema().is_none();
        if self.at_random.is_some() && first {
            return self.anywhere(rng);
        }
        let for_joints = matches!(self.aim, Goal::Joints(_));
        if self.learns_at_once() && (for_joints || rng.random::<f64>() < EXPLORED) {
            return self.most_telling(rng);
        }
        if first && self.touches_seldom() && rng.random::<f64>() < REPEATED_AT_FIRST {
            return self.again(rng).unwrap_or_else(|| self.anywhere(rng));
        }
        if first || rng.random::<f64>() < ANYWHERE {
            return self.anywhere(rng);
        }
        if let Some(met) = self.met.as_ref().filter(|met| met.bare) {
            return self.retreat(met, rng);
        }
        for _ in 0..GOALS {
            let receptors = &self.agent.skin().receptors;
            let sure = receptors.iter().any(|r| self.wanted[r.limb] && self.growth.placed(r.limb));
            let often = if sure { REPEATED } else { REPEATED_UNSURE };
            let repeats = rng.random::<f64>() < often;
            for _ in 0..AIMS {
                let again = if repeats { self.again(rng) } else { None };
                let Some(target) = again.or_else(|| self.aimed(sure, rng)) else { continue };
                if self.promises(&target, sure) {
                    return target;
                }
            }
            // What is in touch with what is held back by it: first away from there.
            if let Some(met) = &self.met {
                return self.retreat(met, rng);
            }
            // Where nothing is promised from here, it may be another time.
            if let Some(tries) = self.tried.as_ref().and_then(|goal| self.tries.get_mut(goal)) {
                *tries += UNPROMISING - 1.0;
            }
            self.next_goal();
        }
        self.anywhere(rng)
    }

    /// A posture in metres, in the unit of length that the body is learned in.
    fn in_unit(&self, posture: &[f64]) -> Posture {
        Posture::from(posture).scaled(self.agent.creature(), 1.0 / self.metres)
    }
}

impl Policy for Stages {
    fn next_target(&mut self, posture: &[f64], rng: &mut ChaCha8Rng) -> Posture {
        self.motions += 1;
        self.start = self.in_unit(posture);
        self.home.get_or_insert_with(|| self.start.clone());
        self.choose_target(rng).scaled(self.agent.creature(), self.metres)
    }

    fn touched(&mut self, touch: &Touch) {
        let touch = &touch.scaled(self.agent.creature(), 1.0 / self.metres);
        self.grown = self.growth.touch(touch);
        self.outlook = None;
        self.remembered.push([touch.posture.clone(), self.start.clone()]);
        let number = self.remembered.len() - 1;
        self.remember(number);
        self.met = Some(Met { bare: false, back: self.start.clone(), held: false });
        if let Some(felt) = self.growth.touches().last() {
            let first = self.growth.schema().is_none();
            let tells = !self.growth.is_spare(felt)
                && felt.told.moving.iter().all(|&joint| self.free[joint])
                && (!first || felt.suffices);
            self.caught = if tells { 0 } else { self.caught + 1 };
            self.untouched = 0;
            match &mut self.at_random {
                Some(touches) => {
                    *touches += 1;
                    self.over |= touches.is_multiple_of(AT_A_TIME);
                }
                None if tells && first => self.count_trial(),
                None => {}
            }
        }
        self.take_stock();
    }

    fn missed(&mut self, ending: &Ending, posture: &[f64]) {
        self.untouched += 1;
        match ending {
            Ending::Free => {
                self.live_through(&self.in_unit(posture));
                self.met = None;
            }
            Ending::Bare => self.met = Some(Met { bare: true, back: self.start.clone(), held: false }),
            Ending::Again | Ending::Touch(_) => self.met.iter_mut().for_each(|met| met.held = true),
        }
        self.caught = if *ending == Ending::Free { 0 } else { self.caught + 1 };
        self.take_stock();
    }

    fn starts_over(&mut self) -> bool {
        let over = self.over || self.caught >= CAUGHT;
        if over {
            (self.over, self.caught, self.met) = (false, 0, None);
        }
        over
    }

    fn is_done(&self) -> bool {
        self.done
    }

    fn grown(&self) -> Option<&Growth> {
        Some(&self.growth)
    }
}
