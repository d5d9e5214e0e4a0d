//! The learner that grows a body part by part from all its touches.

use std::borrow::Cow;

use super::Growth;
use crate::agent::Agent;
use crate::deadline::Deadline;
use crate::learning::scrutiny::{Member, ToldTouch};
use crate::learning::{Input, Learned, Learner, Online, SecondOrder};
use crate::schema::BodySchema;
use crate::senses::Touch;

/// Times that what was learned and does not stand is looked for anew.
const SECOND_LOOKS: usize = 3;

/// The learner `growth`: from receptors on known surfaces, or from contact points where touches report such.
pub struct Grower {
    agent: Agent,
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
        Grower { agent: agent.clone(), growth, seed, touches: Vec::new() }
    }

    /// The same with what touches report.
    pub fn with_input(mut self, input: Input) -> Grower {
        self.growth.learn_from(input);
        self
    }

    /// Whether no more is to be had from the touches: points may tell of joints that surfaces tell nothing of.
    fn suffices(&self, grown: &Learned) -> bool {
        !self.growth.by_points() || grown.undetermined().is_empty()
    }

    /// Where no part is found that places anything, all joints at once.
    fn learn_at_once(&self) -> Learned {
        let mut learner: Box<dyn Learner> = match self.growth.input {
            Input::Receptor => Box::new(Online::new(&self.agent, self.seed)),
            Input::Contact => Box::new(SecondOrder::new(&self.agent, self.growth.input, self.seed)),
        };
        learner.end_at(self.growth.deadline);
        self.touches.iter().for_each(|touch| learner.touch(touch));
        let learned = learner.learn();
        // A body that is told to have changed while it babbled did not: nothing was known of it.
        Learned { changes: Vec::new(), ..learned }
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
                let told = lacks.joints.is_empty() && (lacks.limbs.is_empty() || self.growth.by_points());
                told && !grown.told.moving.is_empty()
            })
            .collect();
        let fit = |schema: &BodySchema, told: &[usize]| {
            let mut last = SecondOrder::new(&self.agent, self.growth.input, self.seed);
            told.iter().for_each(|&number| last.touch(&self.touches[number]));
            last.refine(schema)
        };
        let touches: Vec<&ToldTouch> = self.growth.touches().iter().map(|touch| &*touch.told).collect();
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
            Some(grown) => grown.or_better(self.learn_at_once()),
            None => {
                let at_once = self.learn_at_once();
                Learned { initial_guesses: self.growth.starts() + at_once.initial_guesses, ..at_once }
            }
        }
    }

    fn schema(&self) -> Option<Cow<'_, BodySchema>> {
        self.growth.schema().map(Cow::Borrowed)
    }

    fn way(&self) -> Vec<(usize, BodySchema)> {
        self.growth.way().to_vec()
    }
}
