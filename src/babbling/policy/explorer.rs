//! What curious policies share: experience, a working schema, and the choice between aiming by it and
//! revisiting what was touched.

use rand::RngExt;
use rand_chacha::ChaCha8Rng;

use super::experience::Experience;
use super::information::one;
use super::wide::wide_posture;
use super::working_schema::WorkingSchema;
use crate::agent::Agent;
use crate::creature::Posture;
use crate::kinematics::{Chain, InverseKinematics};
use crate::learning::surface_gap::SurfaceGap;
use crate::senses::Touch;

/// The least and the most that an aim goes into the limbs, metres.
const DEPTH: [f64; 2] = [0.01, 0.05];
/// The depth in deviations of the schema.
const DEPTH_DEVIATIONS: f64 = 2.0;
/// Draws of receptors of one pair before it counts as tried in vain.
const DRAWS: usize = 4;
/// Weight of the last motion in the share of motions that touch.
const RECENT: f64 = 0.08;
/// Share of motions that try the worse way of choosing a target, so that it is known.
const TRIAL: f64 = 0.08;
/// Share of aims that start from a random posture of the chain: the more, the more the postures differ.
const AFRESH: f64 = 0.7;
/// The share of a motion after which what touches at its start must have parted, by the schema.
const PARTED: f64 = 0.03;
/// Motions in a row without a new touch after which one goes to a random posture.
const STUCK: u32 = 3;

/// A motion that should bring two receptors together.
#[derive(Clone, Debug)]
pub struct Aim {
    /// The limbs, the lesser first.
    pub limbs: [usize; 2],
    /// The receptors on them.
    pub receptors: [usize; 2],
    /// The target.
    pub posture: Posture,
}

/// How the present motion was chosen.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Choice {
    Random,
    Revisit,
    Aim([usize; 2]),
}

/// A creature that remembers, believes, and aims.
pub struct Explorer<'a> {
    agent: &'a Agent,
    /// What was touched.
    pub experience: Experience<'a>,
    /// What is believed.
    pub working: WorkingSchema<'a>,
    choice: Choice,
    /// The share of motions that touch, when aimed and when revisiting.
    aimed: f64,
    revisiting: f64,
    /// The receptors in contact.
    contact: Option<[usize; 2]>,
    fruitless: u32,
}

impl<'a> Explorer<'a> {
    /// A creature without experience.
    pub fn new(agent: &'a Agent, working: WorkingSchema<'a>) -> Explorer<'a> {
        Explorer {
            agent,
            experience: Experience::new(agent),
            working,
            choice: Choice::Random,
            aimed: 1.0,
            revisiting: 1.0,
            contact: None,
            fruitless: 0,
        }
    }

    /// Whether the next motion should be aimed by the schema. Begins that motion.
    pub fn aims(&mut self, posture: &[f64], rng: &mut ChaCha8Rng) -> bool {
        self.experience.begin(posture);
        if self.working.schema().is_none() || self.fruitless >= STUCK {
            return false;
        }
        let better = self.aimed >= 0.7 * self.revisiting;
        better != (rng.random::<f64>() < TRIAL && !self.working.converged())
    }

    /// A random target.
    pub fn random(&mut self, rng: &mut ChaCha8Rng) -> Posture {
        self.choice = Choice::Random;
        wide_posture(self.agent.creature(), rng)
    }

    /// A target that needs no schema: near a touch that was made, where that brings new ones.
    pub fn revisit(&mut self, rng: &mut ChaCha8Rng) -> Posture {
        if self.fruitless >= STUCK {
            return self.random(rng);
        }
        self.choice = Choice::Revisit;
        self.experience.revisit(rng)
    }

    /// Takes an aim for the present motion.
    pub fn take(&mut self, aim: Aim) -> Posture {
        self.choice = Choice::Aim(aim.limbs);
        aim.posture
    }

    /// Draws an aim at a pair of limbs whose joints need touches; `even` is the exponent of that need: 0
    /// heeds only what can be reached, 1 evens out all joints. None where the schema finds no posture.
    pub fn draw(&mut self, posture: &[f64], even: f64, rng: &mut ChaCha8Rng) -> Option<Aim> {
        let weights: Vec<([usize; 2], f64)> = (self.experience.pairs.iter())
            .map(|(limbs, tally)| {
                (*limbs, tally.success().powi(2) * self.experience.need_between(*limbs).powf(even))
            })
            .collect();
        let mut left = rng.random::<f64>() * weights.iter().map(|(_, weight)| weight).sum::<f64>();
        let drawn = weights.iter().find(|(_, weight)| {
            left -= weight;
            left <= 0.0
        });
        let limbs = drawn.or(weights.last())?.0;
        let depth = (DEPTH_DEVIATIONS * self.working.deviation()).clamp(DEPTH[0], DEPTH[1]);
        for _ in 0..DRAWS {
            let receptors = limbs.map(|limb| self.seldom_touched(limb, rng));
            let start = self.start(posture, limbs, rng);
            let schema = self.working.schema()?;
            // So far inside both limbs that a schema that is wrong by as much still makes contact.
            let ends = receptors.map(|r| self.agent.skin().receptors[r].place(-0.5 * depth));
            let mut solver = InverseKinematics::new(self.agent.creature(), schema, ends);
            let reach = solver.solve(&start);
            if reach.reached() && reach.facing < 0.3 && self.parts(posture, &reach.posture) {
                return Some(Aim { limbs, receptors, posture: reach.posture });
            }
        }
        let tally = self.experience.pairs.get_mut(&limbs)?;
        tally.tries += 0.3;
        None
    }

    /// The posture that a solution starts from.
    fn start(&self, posture: &[f64], limbs: [usize; 2], rng: &mut ChaCha8Rng) -> Posture {
        let random = wide_posture(self.agent.creature(), rng);
        if rng.random::<f64>() >= AFRESH {
            return Posture::between(self.agent.creature(), posture, &random, 0.1);
        }
        // What is not between the limbs stays near where it is, so that it gets less in the way.
        let mut start = Posture::between(self.agent.creature(), posture, &random, 0.3);
        for j in Chain::between(self.agent.creature(), limbs[0], limbs[1]).joints() {
            let at = self.agent.creature().joints()[j].coordinates();
            start[at.clone()].copy_from_slice(&random[at]);
        }
        start
    }

    /// Of a few receptors of a limb the one that was touched least.
    fn seldom_touched(&self, limb: usize, rng: &mut ChaCha8Rng) -> usize {
        let on_limb = &self.experience.receptors[limb];
        let drawn = [(); 3].map(|()| on_limb[rng.random_range(0..on_limb.len())]);
        let least = drawn.into_iter().min_by_key(|&r| self.experience.receptor_touches[r]);
        least.expect("several are drawn")
    }

    /// Whether a motion parts what touches now, by the schema.
    fn parts(&self, posture: &[f64], target: &[f64]) -> bool {
        let (Some(schema), Some(receptors)) = (self.working.schema(), self.contact) else { return true };
        let soon = Posture::between(self.agent.creature(), posture, target, PARTED);
        let gap = |posture: &[f64]| {
            let touch = one(self.agent, receptors, posture);
            SurfaceGap::new(self.agent.skin(), 1.0).gap(&touch.ends, &touch.frames(schema)).distance
        };
        let [now, then] = [posture, &soon].map(gap);
        then > now + 1e-4
    }

    /// Takes in a touch; whether it brought a new schema.
    pub fn touched(&mut self, touch: &Touch) -> bool {
        self.account(Some(touch));
        self.fruitless = 0;
        self.contact = Some(touch.ends.map(|end| end.receptor));
        self.working.touched(touch)
    }

    /// Takes in a motion that brought no new touch; `moved` where it moved at all.
    pub fn missed(&mut self, moved: bool) {
        self.account(None);
        self.fruitless += 1;
        if moved {
            self.contact = None;
            self.experience.freed();
        }
    }

    fn account(&mut self, touch: Option<&Touch>) {
        let met = touch.map(|touch| touch.ends.map(|end| self.agent.skin().receptors[end.receptor].limb));
        let share = match self.choice {
            Choice::Random => None,
            Choice::Revisit => Some(&mut self.revisiting),
            Choice::Aim(limbs) => {
                if let Some(tally) = self.experience.pairs.get_mut(&limbs) {
                    tally.tries += 1.0;
                    tally.hits += f64::from(u8::from(met == Some(limbs)));
                }
                Some(&mut self.aimed)
            }
        };
        if let Some(share) = share {
            *share += RECENT * (f64::from(u8::from(touch.is_some())) - *share);
        }
        self.experience.ended(touch);
    }
}
