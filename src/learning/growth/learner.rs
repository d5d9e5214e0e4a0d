//! The learner that grows a body part by part from all its touches.

use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

use super::Growth;
use crate::agent::Agent;
use crate::deadline::Deadline;
use crate::learning::initial_guess::random_guess;
use crate::learning::scrutiny::{Member, ToldTouch, moves};
use crate::learning::{AxisModel, Input, Learned, Learner, Online, Parameters, SecondOrder, Verdict};
use crate::schema::BodySchema;
use crate::senses::Touch;

/// Times that a body is learned at once: an answer that explains touches and places nothing is no answer.
const ATTEMPTS: u64 = 5;
/// Times that what was learned and does not stand is looked for anew.
const SECOND_LOOKS: usize = 3;
/// Touches in which all joints move, from which a body is learned at once, at the least.
const FEWEST_AT_LARGE: usize = 100;

/// The learner `growth`: from receptors on known surfaces, or from contact points where touches report such.
pub struct Grower {
    agent: Agent,
    input: Input,
    growth: Growth,
    seed: u64,
    touches: Vec<Touch>,
}

impl Grower {
    /// A learner whose initial guesses are drawn from `seed`.
    pub fn new(agent: &Agent, seed: u64) -> Grower {
        Grower::from(agent, Growth::new(agent, seed), seed)
    }

    /// A learner that goes on from what was learned of its first touches while they were made.
    pub fn from(agent: &Agent, growth: Growth, seed: u64) -> Grower {
        Grower { agent: agent.clone(), input: Input::Receptor, growth, seed, touches: Vec::new() }
    }

    /// The same with what touches report.
    pub fn with_input(self, input: Input) -> Grower {
        let mut grower = Grower { input, ..self };
        grower.growth.learn_from(input);
        grower
    }

    /// Whether no more is to be had from the touches: points may tell of joints that surfaces tell nothing of.
    fn suffices(&self, grown: &Learned) -> bool {
        self.input == Input::Receptor || grown.undetermined().is_empty()
    }

    /// Where no part is found that places anything, all joints at once: from the touches in which all of them move, if there
    /// are such.
    fn learn_at_once(&self) -> Learned {
        let creature = self.agent.creature();
        let joints = self.growth.known_joints()[1];
        let at_large = |touch: &&Touch| {
            let moving = (0..creature.joints().len()).filter(|&joint| moves(creature, joint, &touch.posture));
            moving.count() >= joints
        };
        let mut touches: Vec<&Touch> = self.touches.iter().filter(at_large).collect();
        if touches.len() < FEWEST_AT_LARGE {
            touches = self.touches.iter().collect();
        }
        // One equation a touch, of points three.
        let equations = touches.len() * if self.input == Input::Contact { 3 } else { 1 };
        let unknowns = Parameters::new(creature, AxisModel::Unit, |_| true).len();
        let enough = touches.len() >= FEWEST_AT_LARGE && equations >= unknowns;
        if enough && !self.growth.deadline.has_passed() {
            let mut found = self.learn_whole(&touches, self.seed);
            for attempt in 1..ATTEMPTS {
                if found.verdict.converged() || self.growth.deadline.has_passed() {
                    break;
                }
                let other = self.learn_whole(&touches, self.seed.wrapping_add(attempt << 32));
                let initial_guesses = found.initial_guesses + other.initial_guesses;
                if other.verdict.converged() {
                    found = other;
                }
                found.initial_guesses = initial_guesses;
            }
            found.initial_guesses += self.growth.starts();
            return found;
        }
        let mut rng = ChaCha8Rng::seed_from_u64(self.seed);
        let reason = match self.growth.starts() {
            0 => "no part of the body has touches enough that were made while few joints moved, as growth needs them: make more \
                  touches (--touches), by stages (--policy stages), or use another learner (--learner lm)"
                .to_string(),
            starts => format!(
                "none of {starts} random initial guesses explains the touches of any part of the body; try another seed \
                 (--seed), or random motions and contact points (--policy random --input contact)"
            ),
        };
        let basis = SecondOrder::new(&self.agent, self.input, self.seed).basis();
        let schema = random_guess(creature, &mut rng);
        Learned::unaccounted(schema, basis, Verdict::Failed(reason), self.growth.starts())
    }

    /// Learns at once, from random initial guesses of a seed.
    fn learn_whole(&self, touches: &[&Touch], seed: u64) -> Learned {
        let mut learner: Box<dyn Learner> = match self.input {
            Input::Receptor => Box::new(Online::new(&self.agent, seed)),
            Input::Contact => Box::new(SecondOrder::new(&self.agent, self.input, seed)),
        };
        learner.end_at(self.growth.deadline);
        touches.iter().for_each(|touch| learner.touch(touch));
        let mut learned = learner.learn();
        // A body that is told to have changed while it babbled did not: nothing was known of it.
        learned.changes.clear();
        learned
    }

    /// The last fit, to all touches that what is known should explain, and what they determine.
    ///
    /// What leaves gaps open after it is not located: a wrong axis of a joint that turns little closes its touches nearly. Returned
    /// with it are the joints and limbs that do not stand.
    fn conclude(&self, schema: &BodySchema) -> (Learned, Vec<Member>) {
        let told: Vec<usize> = (0..self.touches.len())
            .filter(|&number| {
                // Those that contradict what is known as well: the account is to hear of them.
                let grown = &self.growth.touches()[number];
                let lacks = self.growth.lacks(grown);
                // Points place limbs that surfaces do not.
                let told =
                    lacks.joints.is_empty() && (lacks.limbs.is_empty() || self.input == Input::Contact);
                told && !grown.told.moving.is_empty()
            })
            .collect();
        let fit = |schema: &BodySchema, told: &[usize]| {
            let mut last = SecondOrder::new(&self.agent, self.input, self.seed);
            told.iter().for_each(|&number| last.touch(&self.touches[number]));
            last.refine(schema)
        };
        let touches: Vec<&ToldTouch> = self.growth.touches().iter().map(|touch| &touch.told).collect();
        let learned = fit(schema, &told);
        let (learned, fallen) = self.growth.scrutiny().standing(&touches, told, learned, fit);
        (Learned { initial_guesses: self.growth.starts(), ..learned }, fallen)
    }

    /// What grows of some touches before a deadline, as far as it stands; `None` if no part is found.
    pub fn grow(agent: &Agent, touches: &[Touch], deadline: Deadline, seed: u64) -> Option<Learned> {
        let mut grower = Grower::new(agent, seed);
        grower.end_at(deadline);
        touches.iter().for_each(|touch| grower.touch(touch));
        grower.grown()
    }

    fn grown(&mut self) -> Option<Learned> {
        self.growth.grow_all();
        self.concluded()
    }

    /// What has grown, as far as it stands. What does not stand was learned from its first touches alone: it is looked for anew,
    /// from all of them.
    fn concluded(&mut self) -> Option<Learned> {
        let (mut best, mut fallen) = self.conclude(self.growth.schema()?);
        for _ in 0..SECOND_LOOKS {
            if fallen.is_empty() || self.growth.deadline.has_passed() {
                break;
            }
            self.growth.take_back_all(&fallen);
            self.growth.grow_all();
            let Some(schema) = self.growth.schema() else { break };
            let (next, still) = self.conclude(schema);
            fallen = still;
            if next.open_members() < best.open_members() {
                best = next;
            }
        }
        Some(best)
    }
}

impl Learner for Grower {
    fn end_at(&mut self, deadline: Deadline) {
        self.growth.end_at(deadline);
    }

    fn touch(&mut self, touch: &Touch) {
        self.touches.push(touch.clone());
        if self.touches.len() > self.growth.touches().len() {
            self.growth.touch(touch);
        }
    }

    fn learn(&mut self) -> Learned {
        match self.grown() {
            Some(grown) if grown.verdict.converged() && self.suffices(&grown) => grown,
            grown => {
                let at_once = self.learn_at_once();
                let better = |grown: &Learned| grown.open_joints() <= at_once.open_joints();
                grown.filter(better).unwrap_or(at_once)
            }
        }
    }

    fn schema(&self) -> Option<&BodySchema> {
        self.growth.schema()
    }

    fn way(&self) -> &[(usize, BodySchema)] {
        self.growth.way()
    }
}
