//! Babbling: random postures, motions that stop at touch, and the touches they bring.
//!
//! Work goes in bouts. Each starts from the same posture with its own random stream, so that a session's
//! touches depend on its seed alone, not on how many threads share the bouts.

mod bouts;
pub mod policy;

use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::mpsc;

use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

pub use bouts::{BoutsDone, Made};
pub use policy::{Policy, PolicyName};

use crate::babbling::bouts::{Bout, gather};
use crate::babbling::policy::{PolicyStart, Random};
use crate::deadline::{Deadline, count_work};
use crate::error::{Error, Kind, Result};
use crate::learning::growth::Growth;
use crate::senses::Input;
use crate::simulation::{Effort, Ending, Mover, Movers};

/// Touches after which a bout ends.
const TOUCHES_PER_BOUT: usize = 25;
/// Motions after which a bout ends.
const MOTIONS_PER_BOUT: u64 = 1000;
/// Bouts without a single touch after which babbling is given up …
const FRUITLESS_BOUTS: u64 = 20;
/// … and with physics, where a motion takes a thousand times as long.
const FRUITLESS_DYNAMIC_BOUTS: u64 = 1;
/// What a motion counts as, in work of [`count_work`].
const MOTION: usize = 400_000;
/// Marks the random streams of a seed that noise of the senses is drawn from.
const NOISE_STREAMS: u64 = 1 << 62;

/// The threads asked for, or one per core.
pub fn threads(jobs: Option<u16>) -> usize {
    jobs.map_or_else(|| std::thread::available_parallelism().map_or(1, usize::from), usize::from)
}

/// What to babble.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BabblingOptions {
    /// Touches wanted.
    pub touches: usize,
    /// Seed of all random streams.
    pub seed: u64,
    /// Threads.
    pub jobs: usize,
}

/// An agent that babbles.
pub struct Babbler<'a> {
    movers: Movers<'a>,
    /// Bouts without a single touch after which babbling is given up.
    fruitless_bouts: u64,
    deadline: Deadline,
    input: Input,
}

impl<'a> Babbler<'a> {
    /// An agent that babbles by these movers of its body.
    pub fn new(movers: Movers<'a>) -> Babbler<'a> {
        let fruitless_bouts = if movers.is_dynamic() { FRUITLESS_DYNAMIC_BOUTS } else { FRUITLESS_BOUTS };
        Babbler { movers, fruitless_bouts, deadline: Deadline::Never, input: Input::Receptor }
    }

    /// The same that begins no motion after a deadline: its touches are the first ones of those that it would have made.
    pub fn until(self, deadline: Deadline) -> Babbler<'a> {
        Babbler { deadline, ..self }
    }

    /// The same whose policies learn on the way from what touches report.
    pub fn learning_from(self, input: Input) -> Babbler<'a> {
        Babbler { input, ..self }
    }

    /// What moves its body.
    pub fn movers(&self) -> &Movers<'a> {
        &self.movers
    }

    /// Babbles by a policy of the creature's own until `options.touches` touches are made, handing on each as soon as all before
    /// it are: at random in bouts on all threads, which go on from those in `from`, or one motion after the other from the
    /// beginning on, as [`Babbler::babble_with`]. The touches are those of a session that was never interrupted, from number
    /// `from.touches` on; returns what all cost, and what a policy learned that learns all that can be.
    ///
    /// # Errors
    /// If the engine or `receive` fails, or nothing is touched; touches handed on before stay handed on.
    pub fn babble(
        &self,
        policy: PolicyName,
        from: BoutsDone,
        options: &BabblingOptions,
        mut receive: impl FnMut(Made) -> Result<()>,
    ) -> Result<(Effort, Option<Growth>)> {
        if policy == PolicyName::Random {
            let done = self.make_bouts(from, options, &mut receive)?;
            return Ok((ended(options, done.touches, done.effort)?, None));
        }
        let start = PolicyStart { seed: options.seed, input: self.input, deadline: self.deadline };
        let mut policy = policy.policy(self.movers.agent(), start);
        let effort = self.babble_with(policy.as_mut(), options, receive)?;
        Ok((effort, policy.grown().cloned()))
    }

    /// Makes bouts on all threads, those after `from`, and hands them on in their order.
    fn make_bouts(
        &self,
        from: BoutsDone,
        options: &BabblingOptions,
        receive: &mut dyn FnMut(Made) -> Result<()>,
    ) -> Result<BoutsDone> {
        let (next_bout, done) = (AtomicU64::new(from.bouts), AtomicBool::new(false));
        let jobs = options.jobs.max(1);
        // A bounded channel keeps the threads from running far ahead of the receiver.
        let (sender, receiver) = mpsc::sync_channel::<(u64, Result<Bout>)>(2 * jobs);
        std::thread::scope(|scope| {
            for _ in 0..jobs {
                let sender = sender.clone();
                let (next_bout, done) = (&next_bout, &done);
                scope.spawn(move || {
                    let mut mover = None;
                    while !done.load(Ordering::Relaxed) && !self.deadline.has_passed() {
                        let bout = next_bout.fetch_add(1, Ordering::Relaxed);
                        let made = self.bout(&mut mover, options.seed, bout);
                        if sender.send((bout, made)).is_err() {
                            break;
                        }
                    }
                });
            }
            drop(sender);
            let until = (self.fruitless_bouts, self.deadline);
            let result = gather(&mut receiver.iter(), from, options.touches, until, receive);
            done.store(true, Ordering::Relaxed);
            // Unblocks threads that wait to send.
            drop(receiver);
            result
        })
    }

    /// One bout, the same whichever thread makes it, and when; by a mover that is there already, or made for it.
    fn bout<'m>(&'m self, mover: &mut Option<Mover<'m>>, seed: u64, bout: u64) -> Result<Bout> {
        let mover = match mover {
            Some(mover) => mover,
            None => mover.insert(self.movers.mover()?),
        };
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        rng.set_stream(bout);
        mover.reset()?;
        mover.draw_noise_from(noise_of(seed, bout));
        let mut policy = Random::new(self.movers.agent().creature());
        let (mut touches, mut so_far) = (Vec::new(), Vec::new());
        let is_whole = |made: usize, motions| made >= TOUCHES_PER_BOUT || motions >= MOTIONS_PER_BOUT;
        while !is_whole(touches.len(), mover.effort().motions) && !self.deadline.has_passed() {
            let target = policy.next_target(&mover.felt_posture()?, &mut rng);
            if let Ending::Touch(met) = mover.advance(&target)? {
                touches.push(mover.touch(bout, met)?);
                so_far.push(mover.effort());
            }
        }
        let effort = mover.effort();
        Ok(Bout { is_whole: is_whole(touches.len(), effort.motions), touches, so_far, effort })
    }

    /// Babbles by a policy, one motion after the other from where the last one stopped, or from the start after a
    /// thousand without a touch, until `options.touches` touches are made; all belong to bout 0. It works on one thread, whatever
    /// `options.jobs`, for each motion depends on all before it. `receive` is also given what the policy has learned after
    /// each touch, if it learns all that can be. Returns what it cost.
    ///
    /// # Errors
    /// If the engine or `receive` fails, or nothing is touched; touches handed on before stay handed on.
    pub fn babble_with(
        &self,
        policy: &mut dyn Policy,
        options: &BabblingOptions,
        mut receive: impl FnMut(Made) -> Result<()>,
    ) -> Result<Effort> {
        let mut rng = ChaCha8Rng::seed_from_u64(options.seed);
        let mut mover = self.movers.mover()?;
        mover.draw_noise_from(noise_of(options.seed, 0));
        // What was done before the body was last put back to where it starts, and up to now.
        let (mut before, mut effort) = (Effort::default(), Effort::default());
        let (mut received, mut in_vain) = (0, 0);
        while received < options.touches && !policy.is_done() && !self.deadline.has_passed() {
            // A body may have got caught in itself, where all ways out begin with the contact that it is in.
            let caught = in_vain > 0 && in_vain % MOTIONS_PER_BOUT == 0;
            if policy.starts_over() || caught {
                before = effort;
                mover.reset()?;
            }
            let target = policy.next_target(&mover.felt_posture()?, &mut rng);
            let ending = mover.advance(&target)?;
            count_work(MOTION);
            effort = before;
            effort += mover.effort();
            if let Ending::Touch(met) = ending {
                let mut touch = mover.touch(0, met)?;
                touch.motion = effort.motions;
                policy.touched(&touch.felt(self.input));
                receive(Made::Touch(&touch))?;
                if let Some(growth) = policy.grown() {
                    receive(Made::Grown(growth))?;
                }
                (received, in_vain) = (received + 1, 0);
            } else {
                policy.missed(&ending, &mover.felt_posture()?);
                in_vain += 1;
                if in_vain >= self.fruitless_bouts * MOTIONS_PER_BOUT {
                    break;
                }
            }
        }
        ended(options, received, effort)
    }
}

/// What so many touches cost; fails if some were wanted and there is none.
fn ended(options: &BabblingOptions, touches: usize, effort: Effort) -> Result<Effort> {
    if touches > 0 || options.touches == 0 {
        return Ok(effort);
    }
    let Effort { motions, bare, .. } = effort;
    Err(Error::new(
        Kind::NoContact,
        format!(
            "no touch in {motions} motions ({bare} met bare geometry): move more joints (--joints all), give \
             joints wider ranges or make limbs thicker, or grow more skin"
        ),
    ))
}

/// The random stream that the noise of the senses is drawn from in a bout: none that targets are drawn from.
fn noise_of(seed: u64, bout: u64) -> ChaCha8Rng {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    rng.set_stream(NOISE_STREAMS | bout);
    rng
}
