//! A point after which nothing more is begun: so much work, or a moment on the clock.
//!
//! Work is counted where it is done, by the solvers and the motions, thread by thread: what a computation comes to must depend
//! neither on what else the computer does nor on how many threads share it. So whatever runs beside something else
//! ([`side_by_side`]) is counted apart, from what had been done when all of it was begun.

use std::cell::Cell;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use rayon::prelude::*;
use serde::{Deserialize, Serialize};

/// Work that one core does in a second: multiplications and additions of a solver, and as many as take as long as whatever else
/// is counted. Measured while Max's 57 joints are searched for.
const A_SECOND: f64 = 4e9;

/// A point after which nothing more is begun; by default there is none. What is under way then is brought to its end, so
/// that everything that was begun can be trusted.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Deadline {
    /// No such moment.
    #[default]
    Never,
    /// On the clock.
    Clock(Instant),
    /// When so much work is done.
    Worked(u64),
    /// When [`end_all`] asks for it, as it may for the two before.
    Asked,
}

/// What was limited where more was to be done.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Limit {
    /// Work, as much on any computer.
    Work,
    /// Time on the clock.
    Seconds,
    /// An interruption.
    Interrupt,
}

impl std::fmt::Display for Limit {
    fn fmt(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
        f.write_str(match self {
            Limit::Work => "when its work budget was spent, before it was complete (--work, --touches)",
            Limit::Seconds => "when its time was up, before it was complete (--seconds, --touches)",
            Limit::Interrupt => "when it was interrupted, before it was complete",
        })
    }
}

/// What was done on a thread.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Tally {
    /// Work, in multiplications and additions.
    pub work: u64,
    /// Whether a deadline had passed where there was more to be begun.
    pub ended: bool,
}

/// Whether all deadlines of this process have come.
static ENDING: AtomicBool = AtomicBool::new(false);

thread_local! {
    static TALLY: Cell<Tally> = const { Cell::new(Tally { work: 0, ended: false }) };
}

impl Tally {
    /// The work, in seconds that it takes one core.
    pub fn seconds(&self) -> f64 {
        self.work as f64 / A_SECOND
    }
}

impl Deadline {
    /// The moment after a time from `began` on; `None` if that is farther off than time can be told.
    pub fn after(began: Instant, time: Duration) -> Deadline {
        began.checked_add(time).map_or(Deadline::Never, Deadline::Clock)
    }

    /// When this thread, and those that work for it, have done as much more as a core does in so many seconds: as much on a busy
    /// computer as on an idle one.
    pub fn after_work_of(seconds: f64) -> Deadline {
        Deadline::Worked(worked().saturating_add((seconds * A_SECOND) as u64))
    }

    /// The same where work was put aside when `then` had been [`worked`], and goes on here: what was done since does not
    /// count.
    pub fn resumed(self, then: u64) -> Deadline {
        match self {
            Deadline::Worked(work) => Deadline::Worked(work.saturating_sub(then).saturating_add(worked())),
            _ => self,
        }
    }

    /// The time until then; `None` if the clock does not tell.
    pub fn left(&self) -> Option<Duration> {
        match self {
            Deadline::Clock(moment) => Some(moment.saturating_duration_since(Instant::now())),
            Deadline::Worked(_) | Deadline::Asked | Deadline::Never => None,
        }
    }

    /// What it limits.
    pub fn limit(&self) -> Limit {
        match self {
            _ if ENDING.load(Ordering::Relaxed) => Limit::Interrupt,
            Deadline::Clock(_) => Limit::Seconds,
            _ => Limit::Work,
        }
    }

    /// Whether it has come, asked by who would begin something else.
    pub fn has_passed(&self) -> bool {
        let ended = match self {
            Deadline::Never => false,
            _ if ENDING.load(Ordering::Relaxed) => true,
            Deadline::Clock(moment) => *moment <= Instant::now(),
            Deadline::Worked(work) => *work <= worked(),
            Deadline::Asked => false,
        };
        count(Tally { work: 0, ended });
        ended
    }
}

/// Has all deadlines of this process come, or not any more: whatever is under way ends with what is known by then.
pub fn end_all(end: bool) {
    ENDING.store(end, Ordering::Relaxed);
}

/// Counts work that was done, in multiplications and additions.
pub fn count_work(work: usize) {
    count(Tally { work: work as u64, ended: false });
}

/// Counts what was done apart.
pub fn count(done: Tally) {
    let before = TALLY.get();
    TALLY.set(Tally { work: before.work.saturating_add(done.work), ended: before.ended | done.ended });
}

/// What something comes to, and what was done for it: none of it is counted yet.
pub fn apart<T>(run: impl FnOnce() -> T) -> (T, Tally) {
    apart_from(TALLY.get().work, run)
}

/// The same where so much was done before.
fn apart_from<T>(work: u64, run: impl FnOnce() -> T) -> (T, Tally) {
    let before = TALLY.replace(Tally { work, ended: false });
    let found = run();
    let after = TALLY.replace(before);
    (found, Tally { work: after.work.saturating_sub(work), ended: after.ended })
}

/// How much was done on this thread.
pub fn worked() -> u64 {
    TALLY.get().work
}

/// What something comes to for each of several, on all threads, as if `work` had been done before each, and what was done for it:
/// none of it is counted yet.
pub fn side_by_side<I: Send, T: Send>(
    work: u64,
    items: Vec<I>,
    run: impl Fn(I) -> T + Sync,
) -> Vec<(T, Tally)> {
    items.into_par_iter().map(|item| apart_from(work, || run(item))).collect()
}

/// What something comes to for each of several, on all threads, all of it counted.
pub fn in_parallel<I: Send, T: Send>(items: Vec<I>, run: impl Fn(I) -> T + Sync) -> Vec<T> {
    let made = side_by_side(worked(), items, run).into_iter();
    made.map(|(found, done)| (found, count(done)).0).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_deadline_passes_once_its_time_is_over_and_none_never_does() {
        let began = Instant::now();
        assert!(Deadline::after(began, Duration::ZERO).has_passed());
        assert!(!Deadline::after(began, Duration::from_secs(3600)).has_passed());
        assert!(!Deadline::after(began, Duration::MAX).has_passed());
        assert!(!Deadline::Never.has_passed());
        assert_eq!(
            [Deadline::Never, Deadline::after(began, Duration::ZERO)].map(|d| d.left()),
            [None, Some(Duration::ZERO)]
        );
    }

    #[test]
    fn work_brings_a_deadline_nearer_whatever_else_is_done_meanwhile() {
        let deadline = Deadline::after_work_of(1e-6);
        let half = || count_work(A_SECOND as usize / 2_000_000);
        half();
        // Other tests work in this process meanwhile.
        std::thread::spawn(move || (0..100).for_each(|_| half())).join().expect("it only counts");
        assert!(!deadline.has_passed());
        half();
        assert!(deadline.has_passed());
    }

    #[test]
    fn what_runs_side_by_side_is_told_of_the_same_work_however_many_threads_there_are() {
        let found = [1, 3].map(|threads| {
            let pool =
                rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads are to be had");
            pool.install(|| {
                let deadline = Deadline::after_work_of(1e-6);
                let unit = A_SECOND as usize / 10_000_000;
                // Each counts on until it is over; those inside it belong to it.
                let ended = in_parallel((0..8).collect(), |number: usize| {
                    in_parallel(vec![number, 1], |units| count_work(units * unit));
                    (0..).take_while(|_| !(count_work(unit), deadline.has_passed()).1).count()
                });
                (ended, apart(|| deadline.has_passed()))
            })
        });
        assert_eq!(found[0], found[1]);
        assert_eq!(found[0].0, [8, 7, 6, 5, 4, 3, 2, 1]);
        assert_eq!(found[0].1, (true, Tally { work: 0, ended: true }));
    }
}
