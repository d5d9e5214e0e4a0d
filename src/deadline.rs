//! A moment after which nothing more is begun.

use std::time::{Duration, Instant};

use nix::time::{ClockId, clock_gettime};

/// A moment after which nothing more is begun; by default there is none. What is under way then is brought to its end, so
/// that everything that was begun can be trusted.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Deadline(Option<Moment>);

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Moment {
    /// On the clock.
    Clock(Instant),
    /// When this process has computed for so long, on all its threads together.
    Computed(Duration),
}

impl Deadline {
    /// No such moment.
    pub const NEVER: Deadline = Deadline(None);

    /// The moment after a time from `began` on; none where that is farther off than time can be told.
    pub fn after(began: Instant, time: Duration) -> Deadline {
        Deadline(began.checked_add(time).map(Moment::Clock))
    }

    /// The moment when this process will have [`computed`] for so long: other work on the computer does not bring it nearer.
    pub fn when_computed(time: Duration) -> Deadline {
        Deadline(Some(Moment::Computed(time)))
    }

    /// The time until then; none where there is no such moment.
    pub fn left(&self) -> Option<Duration> {
        self.0.map(|moment| match moment {
            Moment::Clock(moment) => moment.saturating_duration_since(Instant::now()),
            Moment::Computed(time) => time.saturating_sub(computed()),
        })
    }

    /// Whether the moment has come.
    pub fn has_passed(&self) -> bool {
        self.left().is_some_and(|left| left.is_zero())
    }
}

/// For how long this process has computed, on all its threads together.
pub fn computed() -> Duration {
    // Every system has this clock.
    clock_gettime(ClockId::CLOCK_PROCESS_CPUTIME_ID).map(Duration::from).unwrap_or_default()
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
        assert!(!Deadline::NEVER.has_passed());
        assert_eq!(
            [Deadline::NEVER, Deadline::after(began, Duration::ZERO)].map(|d| d.left()),
            [None, Some(Duration::ZERO)]
        );
    }

    #[test]
    fn a_process_that_rests_computes_nothing() {
        let deadline = Deadline::when_computed(computed() + Duration::from_millis(200));
        // Other tests compute in this process meanwhile.
        assert!(!Deadline::when_computed(computed() + Duration::from_secs(3600)).has_passed());
        let mut sum = 0u64;
        while !deadline.has_passed() {
            sum = std::hint::black_box(sum.wrapping_mul(3).wrapping_add(1));
        }
        assert_eq!(deadline.left(), Some(Duration::ZERO));
    }
}
