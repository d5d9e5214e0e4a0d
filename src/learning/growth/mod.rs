//! Growing a schema part by part from what is known.
//!
//! Joints that rest in the reference posture turn nothing: the limbs on both sides of them are one, and their
//! positions add up. So touches made while few joints move have few unknowns, and a body is learned as infants free
//! theirs (Bernstein, "The Co-ordination and Regulation of Movements", 1967): a part of few joints first, from random
//! initial guesses; then, touch by touch, the parts next to what is known. Where all moves and there is not too much to be
//! learned, it is learned at once (`at_once`). What is known is never frozen: it enters as
//! a Gaussian with its full covariance ([`Belief`]), of which the initial guesses of what is new are drawn, too.
//!
//! A part is accepted when the surfaces of its touches meet, within the patches that felt them and on their outside;
//! when every touch that it rests on is checked by others (Baarda's reliability, "A Testing Procedure for Use in
//! Geodetic Networks", 1968); and when all that was closed before stays closed. Of touches in which only a few coordinates
//! move, which any smooth curve explains, those count that make a condition of their own (`conditions`).

mod acceptance;
mod at_once;
mod believing;
mod conditions;
mod evidence;
mod learner;
mod part;
mod placement;
mod solving;

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

pub use at_once::Outlook;
pub use learner::Grower;
use nalgebra::DMatrix;
pub use part::{GrownTouch, Part};
pub use placement::rest;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

use self::conditions::Conditions;
use self::solving::PartProblem;
use crate::agent::Agent;
use crate::creature::{Creature, DofKind};
use crate::deadline::Deadline;
use crate::learning::initial_guess::random_guess;
use crate::learning::online::Belief;
use crate::learning::scrutiny::{Scrutiny, ToldTouch};
use crate::learning::touch_set::{LimbTouch, TouchSet};
use crate::learning::{Input, PriorKnowledge};
use crate::schema::BodySchema;
use crate::senses::Touch;

/// Deviation that contact points are given, metres: they are exact, and what is believed before the first touch is to move
/// nothing.
const POINT: f64 = 1e-4;
/// Hinges and slides of a creature that grows at the least: with fewer, touches make fewer conditions than there are unknowns.
const FREEDOM: usize = 4;
/// Starts from random initial guesses with all parts but the first.
const STARTS: usize = 16;
/// Unknowns of a first part from which on fewer starts are made, and more touches needed.
const FIRST_WIDTH: f64 = 45.0;
/// At first little is waited for: a body that touches itself readily is soon learned.
const HASTY: Patience = Patience { touches: 1.4, more: 1.2, starts: 40.0 };
/// … and where that was in vain, for much: wide parts seldom succeed, and narrow ones have wrong answers.
const PATIENT: Patience = Patience { touches: 3.5, more: MORE, starts: 200.0 };
/// Starts with first parts that were made in haste, after which there is no more of it.
const HASTY_STARTS: usize = 120;
/// The least share of all unknowns that a part which is learned in haste has: from a small part of a large body it is far to the
/// others.
const HASTY_SHARE: f64 = 1.0 / 6.0;
/// The fewest unknowns of the joints of a first part: with fewer wrong answers fit.
pub const FEWEST_UNKNOWNS: usize = 24;
/// … and where no touches join others to them.
const NARROWEST_SET: usize = 18;
/// Touches that a part needs, in units of its unknowns.
const TOUCHES: f64 = 1.8;
/// … and in units of all unknowns that its touches tell of.
const TOUCHES_OF_ALL: f64 = 1.2;
/// Touches that a part which was tried in vain needs before it is tried again, in units of those that it had.
const MORE: f64 = 1.5;
/// Touches of one pair of limbs with the same joints moving that tell enough, …
const ALIKE: usize = 25;
/// … and where it is not known where they are: a limb that is felt from few sides takes many to be placed.
const ALIKE_UNPLACED: usize = 100;
/// After so many touches, or this share of all, it is seen what can be learned.
const EVERY: usize = 6;
const EVERY_SHARE: usize = 100;
/// Touches without a first part after which none is looked for but where there are many more: of some bodies all touches that few
/// joints make are alike, or tell nothing.
const MOST_AT_FIRST: usize = 1500;
/// The same of starts from random initial guesses: of 40 first parts that were found none took more than 2,600.
const MOST_STARTS: usize = 4000;
/// Parts that are tried in vain before more touches are made.
const TRIED: usize = 2;
/// … and before it is over where no first part was found so far.
const TRIED_AT_LAST: usize = 8;

/// Schemas on the way that are kept; of more every second one is forgotten.
const MOST_OF_WAY: usize = 12;

/// What is waited for before a first part is learned.
#[derive(Clone, Copy, Debug)]
struct Patience {
    /// Touches that it needs, in units of its joints' unknowns: limbs that rest have theirs, too.
    touches: f64,
    /// Those that it needs where it was tried in vain, in units of those that it had.
    more: f64,
    /// Starts from random initial guesses, of which most are soon given up.
    starts: f64,
}

/// A body's schema as it grows.
#[derive(Clone, Debug)]
pub struct Growth {
    agent: Agent,
    /// Nothing but where the skin is.
    known: PriorKnowledge,
    seed: u64,
    input: Input,
    deadline: Deadline,
    /// Parts solved so far: each has its own random numbers.
    solves: u64,
    starts: usize,
    /// Whether a first part is looked for in haste.
    hurries: bool,
    /// Touches when anything was learned last, and from which on all is tried at once again.
    learned_after: usize,
    next_at_once: usize,
    touches: Vec<GrownTouch>,
    /// The conditions that those make that are between the same limbs with the same joints moving.
    conditions: BTreeMap<([usize; 2], Vec<usize>), Conditions>,
    /// Per joint, how far the skin that it carries may be from it at the most, metres.
    reach: Vec<f64>,
    /// Per joint, whether its axes are known.
    resolved: Vec<bool>,
    /// Per limb, how far off its skin may be in the frame of the base, one standard deviation, metres.
    placement: Vec<f64>,
    /// The limb that others are placed in relation to.
    base: usize,
    belief: Option<Belief>,
    /// What the touches in use tell of the parameters of the belief, without its prior (1/m², 1/m, 1).
    information: DMatrix<f64>,
    /// Touches in use when all were fitted last.
    fitted: usize,
    /// Touches after which it is seen next what can be learned.
    next: usize,
    /// Per part that was tried in vain, its touches then.
    failed: BTreeMap<Part, usize>,
    /// What is believed where nothing is known: random at first, then the best answer so far.
    guess: BodySchema,
    /// What was believed after so many touches, whenever more was known or guessed better.
    way: Vec<(usize, BodySchema)>,
}

impl Growth {
    /// Whether a creature can be grown at all.
    pub fn suits(creature: &Creature) -> bool {
        let hinges_and_slides = creature.dofs().filter(|dof| dof.kind != DofKind::Ball).count();
        hinges_and_slides >= FREEDOM
    }

    /// Nothing known of a body but its skin; initial guesses are drawn from `seed`.
    pub fn new(agent: &Agent, seed: u64) -> Growth {
        let creature = agent.creature();
        let mut reach = vec![0.0_f64; creature.joints().len()];
        for joint in (0..reach.len()).rev() {
            let own = agent.skin().receptors.iter().filter(|receptor| receptor.limb == joint + 1);
            reach[joint] += own.map(|receptor| receptor.position.norm()).fold(0.0, f64::max);
            if let Some(before) = creature.joint_of(creature.joints()[joint].parent) {
                // Children come after their parents: what they carry is known here.
                reach[before] = reach[before].max(reach[joint]);
            }
        }
        Growth {
            agent: agent.clone(),
            reach,
            known: PriorKnowledge::nothing(agent),
            seed,
            input: Input::Receptor,
            deadline: Deadline::Never,
            solves: 0,
            starts: 0,
            hurries: false,
            learned_after: 0,
            next_at_once: 0,
            touches: Vec::new(),
            conditions: BTreeMap::new(),
            resolved: (0..creature.joints().len()).map(|joint| !has_axes(creature, joint)).collect(),
            placement: vec![f64::INFINITY; creature.limbs().len()],
            base: 0,
            belief: None,
            information: DMatrix::zeros(0, 0),
            fitted: 0,
            next: EVERY,
            failed: BTreeMap::new(),
            guess: random_guess(creature, &mut ChaCha8Rng::seed_from_u64(seed)),
            way: Vec::new(),
        }
    }

    /// Takes a touch and, now and then, learns what is likely to be learned from those so far; whether that was anything.
    pub fn touch(&mut self, touch: &Touch) -> bool {
        let creature = self.agent.creature();
        let felt = LimbTouch::of(self.agent.skin(), touch, self.input, |_| POINT.powi(2));
        let (limbs, prepared) = felt.prepare(creature);
        let told = ToldTouch::new(creature, limbs, prepared, &touch.posture);
        let elements = told.moving.iter().flat_map(|&joint| creature.joints()[joint].elements());
        let factors: Vec<Vec<f64>> = elements.map(|at| conditions::factors(at, &touch.posture)).collect();
        let most = conditions::most(factors.iter().map(Vec::len));
        let conditions = self.conditions.entry((limbs, told.moving.clone())).or_default();
        let is_new = conditions.take(&factors);
        let alike = if is_new { conditions.new } else { conditions.touches };
        let unresolved: Vec<usize> =
            told.moving.iter().copied().filter(|&joint| !self.resolved[joint]).collect();
        let least = if limbs.iter().all(|&limb| self.placed(limb)) { ALIKE } else { ALIKE_UNPLACED };
        // Many touches that are alike are one wrong answer's majority; what moves by one coordinate meets in one place.
        let spare = alike > least.max((PATIENT.touches * self.width(&unresolved) as f64) as usize)
            || told.moving.is_empty()
            || !is_new && most <= conditions::OF_ONE_COORDINATE;
        let suffices = most as f64 >= PATIENT.touches * self.width(&told.moving) as f64;
        let told = Arc::new(told);
        self.touches.push(GrownTouch { told, used: false, is_new, suffices, spare, refused: None });
        let due = self.touches.len() >= self.next;
        if due {
            let few = EVERY.max(self.touches.len() / EVERY_SHARE);
            let many = ((MORE - 1.0) * self.touches.len() as f64) as usize;
            self.next = self.touches.len() + if self.gave_up() { many } else { few };
        }
        let before = due.then(|| self.guess.clone());
        let grown = due && self.grow_trying(TRIED);
        if grown {
            self.learned_after = self.touches.len();
        }
        if before.is_some_and(|before| grown || self.guess != before) {
            self.way.push((self.touches.len(), self.believed()));
            if self.way.len() > MOST_OF_WAY {
                self.way = self.way.drain(..).skip(1).step_by(2).collect();
            }
        }
        grown
    }

    /// Learns by what touches report, from the next one on.
    pub fn learn_from(&mut self, input: Input) {
        self.input = input;
    }

    /// Looks for a first part in haste from now on, or does not.
    pub fn hurry(&mut self, hurries: bool) {
        self.hurries = hurries;
    }

    fn patience(&self) -> Patience {
        if self.hurries { HASTY } else { PATIENT }
    }

    /// Whether some of the joints that moved in touches are few enough, and many enough of the body, to be learned in haste; not
    /// where that was in vain often enough.
    pub fn may_hurry(&self) -> bool {
        let least = (HASTY_SHARE * self.width_of_all() as f64).max(FEWEST_UNKNOWNS as f64);
        let narrow = |joints: &&[usize]| (least..=FIRST_WIDTH).contains(&(self.width(joints) as f64));
        self.starts < HASTY_STARTS && self.moved().keys().any(narrow)
    }

    /// The sets of joints that moved in touches that suffice for them, and in how many.
    fn moved(&self) -> BTreeMap<&[usize], usize> {
        let mut moved = BTreeMap::new();
        for touch in self.touches.iter().filter(|touch| touch.suffices) {
            *moved.entry(touch.told.moving.as_slice()).or_default() += 1;
        }
        moved
    }

    fn width_of_all(&self) -> usize {
        self.width(&(0..self.resolved.len()).collect::<Vec<usize>>())
    }

    /// Touches that a first part of some joints needs, whether it or a part of it was tried in vain or not. Wide ones seldom
    /// succeed: narrow ones are given time.
    pub fn first_wanted(&self, joints: &[usize]) -> f64 {
        let patience = self.patience();
        let is_within = |part: &Part| part.joints.iter().all(|joint| joints.contains(joint));
        let before =
            self.failed.iter().filter(|(part, _)| is_within(part)).map(|(_, &touches)| touches).max();
        let unknowns = self.width(joints) as f64;
        let at_first = patience.touches * unknowns * (unknowns / FIRST_WIDTH).max(1.0);
        at_first.max(patience.more * before.unwrap_or(0) as f64)
    }

    /// Touches that suffice for what moved in them in which nothing moved but some joints.
    pub fn touches_within(&self, joints: &[usize]) -> usize {
        within(&self.moved(), joints)
    }

    /// Tries no more parts after a deadline.
    pub fn end_at(&mut self, deadline: Deadline) {
        self.deadline = deadline;
    }

    /// Starts from initial guesses made so far.
    pub fn starts(&self) -> usize {
        self.starts
    }

    /// Whether no first part was found, and none is looked for before there are many more touches.
    pub fn gave_up(&self) -> bool {
        self.belief.is_none() && (self.touches.len() >= MOST_AT_FIRST || self.starts >= MOST_STARTS)
    }

    /// The touches so far.
    pub fn touches(&self) -> &[GrownTouch] {
        &self.touches
    }

    /// The schema as far as it has grown; none before the first part is known.
    pub fn schema(&self) -> Option<&BodySchema> {
        self.belief.as_ref().map(|belief| &belief.schema)
    }

    /// The whole body as it is believed: where nothing is known, as it is guessed.
    pub fn believed(&self) -> BodySchema {
        let mut believed = self.guess.clone();
        if let Some(belief) = &self.belief {
            let (schema, parameters) = (&belief.schema, &belief.parameters);
            let joints = parameters.positions.iter().zip(&schema.positions).zip(&mut believed.positions);
            joints.filter(|((place, _), _)| place.is_some()).for_each(|((_, known), p)| *p = *known);
            let dofs = parameters.axes.iter().zip(&schema.axes).zip(&mut believed.axes);
            dofs.filter(|((place, _), _)| place.is_some()).for_each(|((_, known), axis)| *axis = *known);
        }
        believed
    }

    /// What was believed on the way: after so many touches, when more was known or guessed better than before.
    pub fn way(&self) -> &[(usize, BodySchema)] {
        &self.way
    }

    /// Per joint, whether its axes are known; a joint without any is from the beginning.
    pub fn resolved(&self) -> &[bool] {
        &self.resolved
    }

    /// How many joints that have axes are known, and how many there are.
    pub fn known_joints(&self) -> [usize; 2] {
        let creature = self.agent.creature();
        let with_axes = (0..self.resolved.len()).filter(|&joint| has_axes(creature, joint));
        with_axes.fold([0; 2], |[known, all], joint| [known + usize::from(self.resolved[joint]), all + 1])
    }

    /// How far off a limb's skin may be, one standard deviation, seen from the limb that others are placed in relation to,
    /// metres.
    pub fn placement(&self, limb: usize) -> f64 {
        self.placement[limb]
    }

    /// Whether it is known where a limb is, seen from the limb that others are placed in relation to.
    pub fn placed(&self, limb: usize) -> bool {
        self.placement[limb] < placement::PLACED
    }

    /// What is missing for a touch to tell something of what is known: joints to resolve, limbs to place.
    pub fn lacks(&self, touch: &GrownTouch) -> Part {
        Part {
            joints: touch.told.moving.iter().copied().filter(|&joint| !self.resolved[joint]).collect(),
            limbs: touch.told.limbs.into_iter().filter(|&limb| !self.placed(limb)).collect(),
        }
    }

    /// Whether a touch is redundant: there are enough like it, or it makes no new condition for joints that are not known.
    pub fn is_spare(&self, touch: &GrownTouch) -> bool {
        touch.spare || !touch.is_new && touch.told.moving.iter().any(|&joint| !self.resolved[joint])
    }

    /// Learns all that can be learned from the touches so far, for there will be no more; whether that was anything.
    pub fn grow_all(&mut self) -> bool {
        self.grow_trying(if self.gave_up() { TRIED_AT_LAST } else { usize::MAX })
    }

    fn grow_trying(&mut self, tried: usize) -> bool {
        let mut grown = false;
        if self.belief.is_none() {
            grown = self.grow_first(tried.div_ceil(2)) || self.grow_at_once();
            if !grown {
                return false;
            }
        }
        loop {
            self.take_in();
            let worth = |growth: &Growth, part: &Part, touches: usize| {
                growth.failed.get(&part.key()).is_none_or(|&before| touches as f64 >= MORE * before as f64)
            };
            let ready = self.ready(TOUCHES).into_iter().filter(|(part, touches)| worth(self, part, *touches));
            let ready: Vec<(Part, usize)> = ready.collect();
            let (before, mut vain) = (self.known(), 0);
            let learned = ready.into_iter().any(|(part, touches)| {
                if vain >= tried || self.deadline.has_passed() {
                    return false;
                }
                let told = self.part_problem(&part).filter(|problem| {
                    problem.numbers.len() as f64 >= TOUCHES_OF_ALL * problem.unit.len() as f64
                });
                let Some(problem) = told else { return false };
                // What brings nothing new would be tried for ever.
                let gained = self.learn(&problem, STARTS) && self.known() > before;
                if !gained {
                    self.failed.insert(part.key(), touches);
                    vain += 1;
                }
                gained
            });
            if !learned && !self.grow_at_once() {
                return grown;
            }
            grown = true;
        }
    }

    /// Learns the first part: of all sets of joints that moved in touches enough for their size, the smallest that is solved.
    fn grow_first(&mut self, tried: usize) -> bool {
        let mut candidates: Vec<(Part, usize)> = Vec::new();
        let moved = self.moved();
        for joints in self.first_sets(&moved) {
            let touches = within(&moved, &joints);
            if touches as f64 >= self.first_wanted(&joints) {
                let limbs = (0..self.agent.creature().limbs().len()).collect();
                candidates.push((Part { joints, limbs }, touches));
            }
        }
        // Small ones are found sooner, and cost less in vain.
        candidates.sort_by_key(|(part, _)| self.width(&part.joints));
        candidates.into_iter().take(tried).any(|(part, touches)| {
            let problem = self.part_problem(&part);
            let known =
                problem.is_some_and(|problem| self.learn(&problem, first_starts(&problem, self.patience())));
            if !known {
                self.failed.insert(part.key(), touches);
            }
            known
        })
    }

    /// The sets of joints that moved in touches; those with too few unknowns together with others, those with most touches first.
    fn first_sets(&self, moved: &BTreeMap<&[usize], usize>) -> BTreeSet<Vec<usize>> {
        let fewest = FEWEST_UNKNOWNS.min(self.width_of_all() / 2);
        let widened = |set: &&[usize]| {
            let mut joints: BTreeSet<usize> = set.iter().copied().collect();
            loop {
                let set: Vec<usize> = joints.iter().copied().collect();
                if self.width(&set) >= fewest {
                    return Some(set);
                }
                let shares = |other: &[usize]| other.iter().any(|joint| joints.contains(joint));
                let adds = |other: &[usize]| other.iter().any(|joint| !joints.contains(joint));
                let beside = moved.iter().filter(|(other, _)| shares(other) && adds(other));
                match beside.max_by_key(|(_, touches)| **touches) {
                    Some((next, _)) => joints.extend(*next),
                    // There is nothing to be added.
                    None => return (self.width(&set) >= NARROWEST_SET).then_some(set),
                }
            }
        };
        moved.keys().filter_map(widened).collect()
    }

    /// Solves a part and takes it in where it stands.
    fn learn(&mut self, problem: &PartProblem, starts: usize) -> bool {
        self.solve(problem, starts).is_some_and(|solved| self.is_answer(problem, &solved))
    }

    /// Takes an answer in where it stands.
    fn is_answer(&mut self, problem: &PartProblem, solved: &solving::Solved) -> bool {
        solved.exact > solving::ENOUGH && self.accept(problem, solved)
    }

    fn placed_limbs(&self) -> usize {
        (0..self.placement.len()).filter(|&limb| self.placed(limb)).count()
    }

    /// What is believed, held against touches.
    fn scrutiny(&self) -> Scrutiny<'_> {
        let scrutiny = Scrutiny::new(&self.agent, self.input, &self.known);
        if self.has_false_touches() { scrutiny.with_false_touches() } else { scrutiny }
    }

    fn set<'t>(&self, touches: impl Iterator<Item = &'t GrownTouch>) -> TouchSet {
        self.scrutiny().set(touches.map(|touch| &*touch.told))
    }
}

/// Starts that are made with a first part: wide ones cost more each, and fewer find the answer.
fn first_starts(problem: &PartProblem, patience: Patience) -> usize {
    let share = (FIRST_WIDTH / problem.unit.len() as f64).powi(2).min(1.0);
    (share * patience.starts) as usize
}

/// Touches of sets of joints that moved in which nothing moved but some joints.
fn within(moved: &BTreeMap<&[usize], usize>, joints: &[usize]) -> usize {
    let inside = moved.iter().filter(|(set, _)| set.iter().all(|joint| joints.contains(joint)));
    inside.map(|(_, touches)| touches).sum()
}

/// Whether a joint has axes to be learned: a ball has none.
pub fn has_axes(creature: &Creature, joint: usize) -> bool {
    creature.joints()[joint].dofs.iter().any(|dof| dof.kind != DofKind::Ball)
}
