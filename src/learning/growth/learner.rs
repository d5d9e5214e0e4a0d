//! The learner that grows a body part by part from all its touches.

use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

use super::Growth;
use crate::agent::Agent;
use crate::deadline::Deadline;
use crate::learning::initial_guess::random_guess;
use crate::learning::{Basis, Input, Learned, Learner, SecondOrder, Verdict};
use crate::schema::BodySchema;
use crate::senses::Touch;

/// The learner `growth`: receptors on known surfaces.
pub struct Grower<'a> {
    agent: &'a Agent,
    growth: Growth,
    seed: u64,
    touches: Vec<Touch>,
}

impl<'a> Grower<'a> {
    /// A learner whose initial guesses are drawn from `seed`.
    pub fn new(agent: &'a Agent, seed: u64) -> Grower<'a> {
        Grower::from(agent, Growth::new(agent, seed), seed)
    }

    /// A learner that goes on from what was learned of its first touches while they were made.
    pub fn from(agent: &'a Agent, growth: Growth, seed: u64) -> Grower<'a> {
        Grower { agent, growth, seed, touches: Vec::new() }
    }

    /// The last fit, to all touches that what is known should explain, and what they determine.
    ///
    /// What leaves gaps open after it is not told of: a wrong axis of a joint that turns little closes its touches nearly.
    fn conclude(&self, schema: &BodySchema) -> Learned {
        let mut told: Vec<usize> = (0..self.touches.len())
            .filter(|&number| {
                // Those that contradict what is known as well: the account is to hear of them.
                let grown = &self.growth.touches()[number];
                !grown.moving.is_empty() && self.growth.lacks(grown).is_nothing()
            })
            .collect();
        loop {
            let mut last = SecondOrder::new(self.agent, Input::Receptor, self.seed);
            told.iter().for_each(|&number| last.touch(&self.touches[number]));
            let known = vec![true; self.agent.creature().joints().len()];
            let mut learned = last.refine_known(schema, known);
            let deviation = learned.deviation.unwrap_or(0.0);
            if let Some(wrong) = self.growth.most_open(&told, &learned.schema, deviation) {
                told.retain(|&number| !self.growth.touches()[number].tells_of(wrong));
                continue;
            }
            learned.initial_guesses = self.growth.starts();
            learned.verdict =
                learned.account.as_ref().map_or(Verdict::Converged, |account| account.verdict());
            return learned;
        }
    }
}

impl Learner for Grower<'_> {
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
        self.growth.grow_all();
        match self.growth.schema() {
            Some(schema) => self.conclude(schema),
            None => Learned {
                schema: random_guess(
                    self.agent.creature(),
                    &mut ChaCha8Rng::seed_from_u64(self.seed),
                ),
                basis: Basis::SURFACES,
                verdict: Verdict::Failed(
                    match self.growth.starts() {
                        0 => "no part of the body has touches enough that were made while few joints moved, as growth \
                              needs them: babble by stages (--policy stages), or use another learner (--learner lm)"
                            .to_string(),
                        starts => format!(
                            "none of {starts} random initial guesses explains the touches of any part of the body; try \
                             another seed (--seed), or random motions and contact points (--policy random --input contact)"
                        ),
                    },
                ),
                initial_guesses: self.growth.starts(),
                fresh_rms: f64::NAN,
                account: None,
                deviation: None,
                changes: Vec::new(),
            },
        }
    }

    fn schema(&self) -> Option<&BodySchema> {
        self.growth.schema()
    }

    fn way(&self) -> &[(usize, BodySchema)] {
        self.growth.way()
    }
}
