//! Who learns while babbling goes on, so that there is something to see; what the session learns, it learns after.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

use super::babbling::BabblingView;
use crate::agent::Agent;
use crate::kinematics::limb_frames;
use crate::learning::initial_guess::random_guess;
use crate::learning::{Hersch, Input, Learner};
use crate::schema::BodySchema;
use crate::senses::Touch;

/// How often it looks for touches.
const EVERY: Duration = Duration::from_millis(50);
/// For each second of learning it rests so many: it must not take time from babbling.
const REST: u32 = 50;

/// A thread that learns by Hersch's rule from as many of the touches as it gets to.
pub struct LiveLearner {
    done: Arc<AtomicBool>,
    thread: Option<JoinHandle<()>>,
}

impl LiveLearner {
    /// Begins to learn from the touches that a view is told of.
    ///
    /// # Errors
    /// Where the system refuses a thread.
    pub fn new(view: Arc<BabblingView>, agent: &Agent, seed: u64) -> std::io::Result<LiveLearner> {
        let done = Arc::new(AtomicBool::new(false));
        let ended = done.clone();
        let agent = agent.clone();
        let work = move || {
            let initial_guess = random_guess(agent.creature(), &mut ChaCha8Rng::seed_from_u64(seed));
            let mut learner = Hersch::new(&agent, Input::Receptor, initial_guess);
            let mut touches = 0;
            while !ended.load(Ordering::Relaxed) {
                let began = Instant::now();
                let fresh = view.take_fresh();
                if let Some(first) = fresh.first() {
                    let missed = miss(&agent, &learner.learn().schema, first);
                    fresh.iter().for_each(|touch| learner.touch(touch));
                    touches += fresh.len();
                    view.learned(touches, None, Some(&learner.learn().schema), Some(missed));
                }
                std::thread::sleep(EVERY.max(REST * began.elapsed()));
            }
        };
        let thread = std::thread::Builder::new().name("live learner".into()).spawn(work)?;
        Ok(LiveLearner { done, thread: Some(thread) })
    }
}

/// How far apart a schema puts the two receptors of a touch, metres.
pub(super) fn miss(agent: &Agent, schema: &BodySchema, touch: &Touch) -> f64 {
    let frames = limb_frames(agent.creature(), schema, &touch.posture);
    let [a, b] = touch.ends.map(|end| {
        let receptor = &agent.skin().receptors[end.receptor];
        frames[receptor.limb].point(&receptor.position)
    });
    (a - b).norm()
}

impl Drop for LiveLearner {
    fn drop(&mut self) {
        self.done.store(true, Ordering::Relaxed);
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
    }
}
