//! Growing up: few joints move at first, and more as they are known.
//!
//! All joints rest but a few. Which few is found by trial: sets of joints between two limbs, those first that carry
//! much skin to both sides, and of these the set that touches most. Once it is known (see
//! [`Growth`](crate::learning::growth)), what is known moves, and one joint more, or two or three; or only what is
//! known, towards a limb that is not placed yet. Where the schema tells how, motions are aimed; where it does not,
//! what was touched once is touched again, a little differently.

use std::collections::BTreeMap;

use rand::RngExt;
use rand_chacha::ChaCha8Rng;

use super::Policy;
use super::foresight::{Foreseen, Foresight};
use crate::agent::Agent;
use crate::creature::Posture;
use crate::kinematics::{Chain, InverseKinematics};
use crate::learning::growth::{FIRST_TOUCHES, FREEDOM, GrownTouch, Growth, LIMB_FREEDOM, rest};
use crate::senses::Touch;
use crate::simulation::Ending;

/// Sets of joints that are tried before the first is learned, …
const TRIALS: usize = 16;
/// … as many of each of so many sizes, …
const SIZES: usize = 4;
/// … motions with each, …
const TRIAL_MOTIONS: usize = 40;
/// … and with all joints, which show what can be touched at all.
const SURVEY_MOTIONS: usize = 150;
/// The least and the most unknowns of the joints of a first set: with fewer wrong answers fit, with more none is found.
const FIRST_UNKNOWNS: [usize; 2] = [24, 110];
/// Motions with a first set before another is tried, in units of those after which it should have been learned.
const FIRST_PATIENCE: f64 = 2.0;
/// Share of motions that go anywhere.
const ANYWHERE: f64 = 0.15;
/// Share of the others that repeat a touch though they could be aimed.
const REPEATED: f64 = 0.3;
/// How far a repeated touch scatters, in shares of the ranges; how much farther it goes than the touch was, radians
/// or metres, in shares of the way that led there.
const SCATTER: f64 = 0.15;
const FARTHER: f64 = 0.5;
const FARTHEST: f64 = 0.3;
/// Draws of two receptors to aim at.
const AIMS: usize = 8;
/// Goals that are considered before a motion goes anywhere because none of them promises anything.
const GOALS: usize = 3;
/// How deep an aim goes into both limbs, metres, and how far from it a posture may stay.
const DEPTH: f64 = 0.01;
const NEAR: f64 = 0.01;
/// A limb that is placed to this, one standard deviation, metres, is where the schema has it.
const WELL_PLACED: f64 = 5e-4;
/// Motions in a row without a touch that tells anything, after which a body caught in itself starts over.
const CAUGHT: usize = 12;
/// Motions with a limb to be placed, with joints to be learned, and how many more for each further joint.
const LIMB_MOTIONS: usize = 12;
const JOINT_MOTIONS: usize = 40;
const FURTHER_MOTIONS: usize = 20;
/// Times that a joint or a limb is tried before it is taken that it cannot be touched.
const MOST_TRIES: f64 = 20.0;
/// What it counts as, where no posture is found that promises anything.
const UNPROMISING: f64 = 0.1;
/// What limbs are to be placed to, one standard deviation, metres: a tenth of a millimetre in 95 % of cases.
const PRECISE: f64 = 5e-5;
/// The most unknowns of joints that a touch made by chance has learned at once.
const CHANCE_UNKNOWNS: usize = 35;

/// The policy `stages`.
pub struct Stages<'a> {
    agent: &'a Agent,
    growth: Growth,
    foresight: Foresight<'a>,
    /// Per joint, the share of the skin on the side of it where there is less.
    lever: Vec<f64>,
    /// Sets of joints for the first part, and the touches that each brought in its trial.
    trials: Vec<(Vec<usize>, usize)>,
    /// The set that is tried; none any more once one was chosen.
    trial: Option<usize>,
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
    /// Whether something was learned from the last touch.
    grown: bool,
    goals: usize,
    tried: Option<Goal>,
    tries: BTreeMap<Goal, f64>,
    /// Per touch, its posture and where the motion to it began.
    remembered: Vec<[Posture; 2]>,
    start: Posture,
    /// Motions in a row that told nothing.
    caught: usize,
    over: bool,
    done: bool,
}

/// What motions are made for.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Goal {
    /// That joints are learned.
    Joints(Vec<usize>),
    /// The same, by repeating touches that were made by chance.
    Repeat(Vec<usize>),
    /// That a limb is placed.
    Limb(usize),
}

impl<'a> Stages<'a> {
    /// The policy of a body of which nothing is known; what it learns on the way begins with `seed`.
    pub fn new(agent: &'a Agent, seed: u64) -> Stages<'a> {
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
        let growth = Growth::new(agent, seed);
        let mut stages = Stages {
            agent,
            foresight: Foresight::new(agent),
            lever: beyond.iter().map(|beyond: &f64| beyond.min(all - beyond) / all).collect(),
            trials: Vec::new(),
            trial: Some(0),
            aim: Goal::Joints(Vec::new()),
            wanted: vec![false; creature.limbs().len()],
            repeatable: BTreeMap::new(),
            free: vec![false; joints],
            motions: 0,
            patience: TRIAL_MOTIONS,
            grown: false,
            goals: 0,
            tried: None,
            tries: BTreeMap::new(),
            remembered: Vec::new(),
            start: Posture::default(),
            caught: 0,
            over: false,
            done: growth.resolved().iter().all(|&resolved| resolved),
            growth,
        };
        stages.trials = stages.first_sets().into_iter().map(|set| (set, 0)).collect();
        stages.trials.push(((0..joints).collect(), 0));
        stages.begin_trial(0);
        stages
    }

    /// The sets of joints between two limbs that may be learned first, those that carry most skin for their size first.
    fn first_sets(&self) -> Vec<Vec<usize>> {
        let creature = self.agent.creature();
        let skinned = self.agent.limbs_with_skin();
        let mut sets: BTreeMap<Vec<usize>, f64> = BTreeMap::new();
        for (number, &a) in skinned.iter().enumerate() {
            for &b in skinned[number + 1..].iter().filter(|&&b| !creature.neighbouring(a, b)) {
                let mut set: Vec<usize> = Chain::between(creature, a, b).joints().collect();
                set.sort_unstable();
                let unknowns = self.growth.width(&set);
                if (FIRST_UNKNOWNS[0]..=FIRST_UNKNOWNS[1]).contains(&unknowns) {
                    let lever = set.iter().map(|&joint| self.lever[joint]).sum::<f64>();
                    sets.insert(set, lever / (unknowns + 10) as f64);
                }
            }
        }
        let mut sets: Vec<(Vec<usize>, f64)> = sets.into_iter().collect();
        sets.sort_by(|a, b| b.1.total_cmp(&a.1));
        // As many small ones as large ones: only trial tells how many joints it takes to touch.
        let [least, most] = FIRST_UNKNOWNS;
        let size = |set: &[usize]| (self.growth.width(set) - least) * SIZES / (most - least + 1);
        let of_size = |wanted: usize| {
            let sets = sets.iter().filter(move |(set, _)| size(set) == wanted);
            sets.take(TRIALS / SIZES).map(|(set, _)| set.clone())
        };
        (0..SIZES).flat_map(of_size).collect()
    }

    fn begin_trial(&mut self, number: usize) {
        self.trial = Some(number);
        let set = self.trials[number].0.clone();
        let all = number + 1 == self.trials.len();
        self.begin(Goal::Joints(set), if all { SURVEY_MOTIONS } else { TRIAL_MOTIONS });
    }

    fn begin(&mut self, goal: Goal, patience: usize) {
        self.free = self.growth.resolved().to_vec();
        if self.growth.schema().is_none() {
            self.free.fill(false);
        }
        if let Goal::Joints(joints) | Goal::Repeat(joints) = &goal {
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
            Goal::Joints(joints) | Goal::Repeat(joints) => joints,
            Goal::Limb(_) => &[],
        }
    }

    /// Remembers a touch by its pair of limbs, where it serves the goal to touch that again.
    fn remember(&mut self, number: usize) {
        let touch = &self.growth.touches()[number];
        if self.is_repeatable(touch) {
            self.repeatable.entry(touch.limbs).or_default().push(number);
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

    /// Learns which limbs pass through each other from a posture that was reached.
    fn live_through(&mut self, posture: &[f64]) {
        let Some(schema) = self.growth.schema() else { return };
        // Limbs on joints that are not known yet are not where the schema has them.
        let unknown = |limb: usize| self.wanted[limb] && !self.joints().is_empty();
        let counts = |limb: usize| !unknown(limb) && self.growth.placement(limb) < WELL_PLACED;
        let passing = self.foresight.passing(schema, posture, counts);
        self.foresight.pass(passing);
    }

    /// Takes stock after a motion.
    fn take_stock(&mut self) {
        if let Some(trial) = self.trial.filter(|_| self.growth.schema().is_none()) {
            if self.motions >= self.patience {
                self.end_trial(trial);
            }
            return;
        }
        if std::mem::take(&mut self.grown) {
            self.trial = None;
            self.next_goal();
            return;
        }
        if self.motions >= self.patience {
            match self.growth.schema() {
                Some(_) => self.next_goal(),
                None => self.next_first(),
            }
        }
    }

    fn end_trial(&mut self, trial: usize) {
        if trial + 1 < self.trials.len() {
            self.begin_trial(trial + 1);
            return;
        }
        // Those first that have their touches soonest; where none touched, all joints at once.
        let mut trials = std::mem::take(&mut self.trials);
        if trials[..trial].iter().any(|(_, touches)| *touches > 0) {
            trials.pop();
            trials.retain(|(_, touches)| *touches > 0);
        }
        trials.sort_by(|a, b| self.first_motions(a).total_cmp(&self.first_motions(b)));
        self.trials = trials;
        self.trial = None;
        self.next_first();
    }

    /// Motions after which a set of joints will have as many touches as a first part needs.
    fn first_motions(&self, (set, touches): &(Vec<usize>, usize)) -> f64 {
        FIRST_TOUCHES * (self.growth.width(set) * TRIAL_MOTIONS) as f64 / (*touches).max(1) as f64
    }

    /// Goes on with the next set of joints for the first part, each time with more motions.
    fn next_first(&mut self) {
        let number = self.goals % self.trials.len();
        let rounds = 1 + self.goals / self.trials.len();
        let motions = FIRST_PATIENCE * rounds as f64 * self.first_motions(&self.trials[number]);
        let set = self.trials[number].0.clone();
        self.goals += 1;
        self.over = true;
        self.begin(Goal::Joints(set), motions as usize);
    }

    /// Chooses what to learn next: joints that a touch made by chance had, a limb to place, a joint with much skin to both
    /// sides; what was tried least first.
    fn next_goal(&mut self) {
        let creature = self.agent.creature();
        let open: Vec<usize> = (0..self.free.len()).filter(|&joint| !self.growth.resolved()[joint]).collect();
        let tries = |goal: &Goal| self.tries.get(goal).copied().unwrap_or(0.0);
        let vague = |limb: &usize| self.growth.placement(*limb) > PRECISE;
        let unplaced: Vec<usize> = self.agent.limbs_with_skin().into_iter().filter(vague).collect();
        self.done = open.iter().all(|&joint| tries(&Goal::Joints(vec![joint])) >= MOST_TRIES)
            && unplaced.iter().all(|&limb| tries(&Goal::Limb(limb)) >= MOST_TRIES);
        self.goals += 1;
        let repeated = (self.goals.is_multiple_of(2)).then(|| self.chance(&tries)).flatten();
        let limb =
            unplaced.iter().copied().min_by(|&a, &b| tries(&Goal::Limb(a)).total_cmp(&tries(&Goal::Limb(b))));
        let worth = |joint: usize| self.lever[joint] / (1.0 + tries(&Goal::Joints(vec![joint]))).powi(3);
        let joint = open.iter().copied().max_by(|&a, &b| worth(a).total_cmp(&worth(b)));
        let limb_first = match (limb, joint) {
            (Some(limb), Some(joint)) => tries(&Goal::Limb(limb)) < tries(&Goal::Joints(vec![joint])),
            (limb, _) => limb.is_some(),
        };
        let (goal, named, patience) = match (repeated, limb, joint) {
            (Some(joints), _, _) => {
                let patience = 30 + 2 * self.growth.width(&joints);
                (Goal::Repeat(joints.clone()), Goal::Repeat(joints), patience)
            }
            (None, Some(limb), _) if limb_first => (Goal::Limb(limb), Goal::Limb(limb), LIMB_MOTIONS),
            (None, _, Some(joint)) => {
                let named = Goal::Joints(vec![joint]);
                // What cannot be touched alone may be together with its neighbours.
                let further = tries(&named).min(3.0) as usize;
                let mut joints = vec![joint];
                let meets = |a: usize, b: usize| creature.joints()[a].parent == b + 1;
                for _ in 0..further {
                    let beside = |other: &usize| {
                        !joints.contains(other)
                            && joints.iter().any(|&j| meets(*other, j) || meets(j, *other))
                    };
                    let Some(next) = open.iter().copied().find(beside) else { break };
                    joints.push(next);
                }
                joints.sort_unstable();
                (Goal::Joints(joints), named, JOINT_MOTIONS + FURTHER_MOTIONS * further)
            }
            _ => return,
        };
        *self.tries.entry(named.clone()).or_insert(0.0) += 1.0;
        self.tried = Some(named);
        self.begin(goal, patience);
    }

    /// The joints to be learned of a touch that was made by chance: few, tried seldom, and with much skin.
    fn chance(&self, tries: &impl Fn(&Goal) -> f64) -> Option<Vec<usize>> {
        let mut sets: BTreeMap<Vec<usize>, ()> = BTreeMap::new();
        for touch in self.growth.touches().iter().filter(|touch| touch.freedom >= FREEDOM) {
            let joints = self.growth.lacks(touch).joints;
            if !joints.is_empty() && self.growth.width(&joints) <= CHANCE_UNKNOWNS {
                sets.insert(joints, ());
            }
        }
        let cost = |joints: &Vec<usize>| {
            let tried = tries(&Goal::Repeat(joints.clone()));
            let lever = joints.iter().map(|&joint| self.lever[joint] + 0.02).fold(0.0, f64::max);
            self.growth.width(joints) as f64 * (1.0 + tried) / lever.sqrt()
        };
        sets.into_keys().min_by(|a, b| cost(a).total_cmp(&cost(b)))
    }

    /// A random posture in which only what is free moves.
    fn anywhere(&self, rng: &mut ChaCha8Rng) -> Posture {
        let creature = self.agent.creature();
        let mut posture = Posture::random(creature, rng);
        self.rest_others(&mut posture);
        posture
    }

    /// The present posture, but what is not free at rest.
    fn here(&self) -> Posture {
        let mut posture = self.start.clone();
        self.rest_others(&mut posture);
        posture
    }

    fn rest_others(&self, posture: &mut Posture) {
        let creature = self.agent.creature();
        let held = (0..self.free.len()).filter(|&joint| !self.free[joint]);
        held.for_each(|joint| rest(creature, joint, posture));
        creature.couple(posture);
    }

    /// Whether the schema foresees that the way to a posture brings a limb that the goal wants to another one or, where it
    /// is not known where such limbs are, at least that nothing else gets in the way.
    fn promises(&self, target: &Posture, sure: bool) -> bool {
        let Some(schema) = self.growth.schema() else { return true };
        let creature = self.agent.creature();
        // Joints that are not known yet: at rest it is known best where their limbs are.
        let [from, to] = [&self.start, target].map(|posture| {
            let mut posture = posture.clone();
            let unknown = (0..self.free.len()).filter(|&joint| !self.growth.resolved()[joint]);
            unknown.for_each(|joint| rest(creature, joint, &mut posture));
            posture
        });
        match self.foresight.foresee(schema, [&from, &to], |limb| self.growth.placed(limb)) {
            Foreseen::Meeting([a, b]) => self.wanted[a] != self.wanted[b],
            Foreseen::Nothing => !sure,
            Foreseen::Stuck => false,
        }
    }

    /// Whether it serves the goal to touch again what a touch was of.
    fn is_repeatable(&self, touch: &GrownTouch) -> bool {
        let least = if self.joints().is_empty() { LIMB_FREEDOM } else { FREEDOM };
        let [a, b] = touch.limbs.map(|limb| self.wanted[limb]);
        let told = match self.aim {
            Goal::Repeat(_) => touch.moving.iter().any(|joint| self.joints().contains(joint)),
            _ => a != b,
        };
        touch.freedom >= least && told && touch.moving.iter().all(|&joint| self.free[joint])
    }

    /// A posture near one in which something was touched that the goal wants.
    fn again(&self, rng: &mut ChaCha8Rng) -> Option<Posture> {
        let creature = self.agent.creature();
        // Each pair of limbs as likely as any other, however often it was touched.
        let pair = rng.random_range(0..self.repeatable.len().max(1));
        let known = self.repeatable.values().nth(pair)?;
        let number = known[rng.random_range(0..known.len())];
        let [touched, from] = &self.remembered[number];
        let mut target = self.here();
        let between = self.growth.touches()[number].chain.iter().filter(|&&joint| self.free[joint]);
        let between: Vec<_> = between
            .flat_map(|&joint| creature.joints()[joint].elements().map(move |at| (joint, at)))
            .collect();
        let few = SCATTER / (between.len() as f64).sqrt();
        for (joint, at) in between {
            // Of a joint that hardly moves its touches tell hardly anything.
            let scatter = if self.joints().contains(&joint) { SCATTER } else { few };
            if at.is_ball() {
                at.of_mut(&mut target).copy_from_slice(at.of(touched));
                continue;
            }
            let (q, [low, high]) = (at.coordinate(), at.range);
            let further = FARTHER * (touched[q] - from[q]).clamp(-FARTHEST, FARTHEST);
            let scatter = scatter * (high - low) * (2.0 * rng.random::<f64>() - 1.0);
            target[q] = (touched[q] + further + scatter).clamp(low, high);
        }
        creature.couple(&mut target);
        Some(target)
    }

    /// A posture that brings a limb that the goal wants to another one, by the schema; what is not known stays where chance
    /// puts it.
    fn aimed(&self, sure: bool, rng: &mut ChaCha8Rng) -> Option<Posture> {
        let (creature, skin) = (self.agent.creature(), self.agent.skin());
        let schema = self.growth.schema()?;
        let on = |fits: &dyn Fn(usize) -> bool| -> Vec<usize> {
            (0..skin.receptors.len()).filter(|&receptor| fits(skin.receptors[receptor].limb)).collect()
        };
        let wanted = on(&|limb| self.wanted[limb] && (!sure || self.growth.placed(limb)));
        let others = on(&|limb| !self.wanted[limb] && self.growth.placed(limb));
        if wanted.is_empty() || others.is_empty() {
            return None;
        }
        let receptors = [&wanted, &others].map(|list| &skin.receptors[list[rng.random_range(0..list.len())]]);
        let [a, b] = receptors.map(|receptor| receptor.limb);
        if creature.neighbouring(a, b) {
            return None;
        }
        let ends = receptors.map(|receptor| receptor.place(-DEPTH));
        // What is not between the two stays where it is: the less moves, the less gets in the way.
        let (mut start, random) = (self.here(), self.anywhere(rng));
        for at in
            Chain::between(creature, a, b).joints().flat_map(|joint| creature.joints()[joint].elements())
        {
            at.of_mut(&mut start).copy_from_slice(at.of(&random));
        }
        creature.couple(&mut start);
        let known = |joint: usize| self.free[joint] && !self.joints().contains(&joint);
        let mut solver = InverseKinematics::new(creature, schema, ends).moving(known);
        let reach = solver.solve(&start);
        (reach.miss < NEAR).then_some(reach.posture)
    }
}

impl Policy for Stages<'_> {
    fn next_target(&mut self, posture: &[f64], rng: &mut ChaCha8Rng) -> Posture {
        self.motions += 1;
        self.start = posture.into();
        if self.growth.schema().is_none() || rng.random::<f64>() < ANYWHERE {
            return self.anywhere(rng);
        }
        for _ in 0..GOALS {
            let receptors = &self.agent.skin().receptors;
            let sure = receptors.iter().any(|r| self.wanted[r.limb] && self.growth.placed(r.limb));
            let repeats = !sure || matches!(self.aim, Goal::Repeat(_)) || rng.random::<f64>() < REPEATED;
            for _ in 0..AIMS {
                let again = if repeats { self.again(rng) } else { None };
                let Some(target) = again.or_else(|| self.aimed(sure, rng)) else { continue };
                if self.promises(&target, sure) {
                    return target;
                }
            }
            // Where nothing is promised from here, it may be another time.
            if let Some(tries) = self.tried.as_ref().and_then(|goal| self.tries.get_mut(goal)) {
                *tries += UNPROMISING - 1.0;
            }
            self.next_goal();
        }
        self.anywhere(rng)
    }

    fn touched(&mut self, touch: &Touch) {
        self.grown = self.growth.touch(touch);
        self.remembered.push([touch.posture.clone(), self.start.clone()]);
        self.remember(self.remembered.len() - 1);
        if let Some(felt) = self.growth.touches().last() {
            let tells = felt.moving.iter().all(|&joint| self.free[joint]);
            self.caught = if tells { 0 } else { self.caught + 1 };
            if let Some(trial) = self.trial.filter(|_| tells && felt.freedom >= FREEDOM) {
                self.trials[trial].1 += 1;
            }
        }
        self.take_stock();
    }

    fn missed(&mut self, ending: &Ending, posture: &[f64]) {
        if *ending == Ending::Free {
            self.live_through(posture);
        }
        self.caught = if *ending == Ending::Free { 0 } else { self.caught + 1 };
        self.take_stock();
    }

    fn starts_over(&mut self) -> bool {
        let over = self.over || self.caught >= CAUGHT;
        if over {
            (self.over, self.caught) = (false, 0);
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
