//! Who learns while babbling goes on, so that there is something to see; what the session learns, it learns after.

use std::sync::{Arc, Mutex, PoisonError};
use std::thread::available_parallelism;
use std::time::{Duration, Instant};

use rayon::ThreadPoolBuilder;

use super::babbling::BabblingView;
use crate::agent::Agent;
use crate::deadline::Deadline;
use crate::experiment::LearningOptions;
use crate::kinematics::limb_frames;
use crate::learning::{Learner, Verdict};
use crate::schema::BodySchema;
use crate::senses::Touch;

/// How often it looks for touches.
const EVERY: Duration = Duration::from_millis(50);
/// How long it tries initial guesses.
const TRIES: Duration = Duration::from_millis(500);
/// For each second of learning it rests so many: it must not take time from babbling, not even where the other core is half of the
/// same one; and much more so where there is one alone.
const REST: u32 = 10;
const REST_ALONE: u32 = 50;

/// A thread that learns as the session will, from as many of the touches as it gets to.
pub struct LiveLearner {
    /// Whether what it finds is wanted no more. Held while the view is told.
    done: Arc<Mutex<bool>>,
}

impl LiveLearner {
    /// Begins to learn from the touches that a view is told of.
    ///
    /// # Errors
    /// Where the system refuses a thread.
    pub fn new(
        view: Arc<BabblingView>,
        agent: &Agent,
        options: &LearningOptions,
        seed: u64,
    ) -> std::io::Result<LiveLearner> {
        let done = Arc::new(Mutex::new(false));
        let (ended, agent, options) = (done.clone(), agent.clone(), options.clone());
        let work = move || {
            let disturbances = options.disturbances.disturbances();
            let mut learner = options.learner(&disturbances.felt(&agent, &[], seed).agent, seed);
            let rest =
                if available_parallelism().is_ok_and(|cores| cores.get() > 1) { REST } else { REST_ALONE };
            let mut schema: Option<BodySchema> = None;
            let mut touches = 0;
            loop {
                let began = Instant::now();
                let fresh = view.take_fresh();
                let missed = schema.as_ref().zip(fresh.first());
                let missed = missed.map(|(schema, first)| miss(&agent, schema, first));
                let felt = disturbances.felt(&agent, &fresh, seed.wrapping_add(touches as u64)).touches;
                if !felt.is_empty() {
                    felt.iter().for_each(|touch| learner.touch(touch));
                    touches += felt.len();
                    schema = believed(learner.as_mut(), schema.take());
                }
                {
                    let ended = ended.lock().unwrap_or_else(PoisonError::into_inner);
                    if *ended {
                        return;
                    }
                    if !felt.is_empty() {
                        view.learned(touches, None, schema.as_ref(), missed);
                    }
                }
                std::thread::sleep(EVERY.max(rest * began.elapsed()));
            }
        };
        // With threads of its own: those of the session are at work, or wait for it.
        let pool = ThreadPoolBuilder::new().num_threads(1).build().map_err(std::io::Error::other)?;
        std::thread::Builder::new().name("live learner".into()).spawn(move || pool.install(work))?;
        Ok(LiveLearner { done })
    }
}

/// What a learner believes now, or what was believed before where it comes to nothing.
fn believed(learner: &mut dyn Learner, before: Option<BodySchema>) -> Option<BodySchema> {
    if let Some(schema) = learner.schema() {
        return Some(schema.clone());
    }
    learner.end_at(Deadline::after(Instant::now(), TRIES));
    let learned = learner.learn();
    match (learned.verdict, before) {
        (Verdict::Failed(_), Some(before)) => Some(before),
        _ => Some(learned.schema),
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
        // What it is at may take a while: nobody waits for that.
        *self.done.lock().unwrap_or_else(PoisonError::into_inner) = true;
    }
}
