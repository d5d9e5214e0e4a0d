//! `lm`: Levenberg-Marquardt from any initial guess.

use super::{LearnerGivens, LearnerKind, LearnerUses, doubling};
use crate::agent::Agent;
use crate::learning::growth::{Grower, Growth};
use crate::learning::{Input, Learner, Online, PriorKnowledge, SecondOrder, SkinKnowledge};

/// Most touches whose contact points are learned from in an instant.
const MOST_INSTANT: usize = 4000;

/// Levenberg-Marquardt from random initial guesses; from receptors with their surfaces, touch by touch.
#[derive(Clone, Copy, Debug)]
pub struct LevenbergMarquardt;

impl LearnerKind for LevenbergMarquardt {
    fn name(&self) -> &'static str {
        "lm"
    }

    fn about(&self) -> &'static str {
        "Levenberg-Marquardt from any initial guess"
    }

    fn uses(&self) -> LearnerUses {
        LearnerUses { surfaces: true, known_joints: true, limb_frames: true, surfaces_alone: false }
    }

    fn learner(&self, agent: &Agent, given: &LearnerGivens, seed: u64) -> Box<dyn Learner> {
        let known = PriorKnowledge::nothing(agent).with(&given.known);
        if self.predicts(given) {
            let mut learner = Online::new(agent, seed).with_known(known);
            // False touches in many pairs of limbs leave few pairs without: these are found one after the other.
            if Growth::suits(agent.creature()) {
                let agent = agent.clone();
                let grow = move |touches: &[_], deadline| Grower::grow(&agent, touches, deadline, seed);
                learner = learner.with_search(Box::new(grow));
            }
            return Box::new(learner);
        }
        let learner = SecondOrder::new(agent, given.input, seed);
        Box::new(learner.with_frames(given.frames).with_skin(given.skin).with_known(known))
    }

    fn predicts(&self, given: &LearnerGivens) -> bool {
        (given.input, given.skin) == (Input::Receptor, SkinKnowledge::Surface)
    }

    fn checkpoints(&self, given: &LearnerGivens, touches: usize) -> Vec<usize> {
        if self.predicts(given) {
            // Roughly evenly spaced where touches are counted in powers of ten.
            let round = [50, 70, 100, 150, 200, 300, 500, 700];
            let round = (0..).flat_map(|k| round.map(|n| n * 10usize.pow(k)));
            return round.take_while(|&n| n < touches).collect();
        }
        match given.input {
            Input::Contact if touches <= MOST_INSTANT => doubling(125, touches),
            _ => Vec::new(),
        }
    }
}
