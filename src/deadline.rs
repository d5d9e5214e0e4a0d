//! A moment after which nothing more is begun.

use std::time::{Duration, Instant};

/// A moment after which nothing more is begun; by default there is none. What is under way then is brought to its end, so
/// that everything that was begun can be trusted.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Deadline(Option<Instant>);

impl Deadline {
    /// No such moment.
    pub const NEVER: Deadline = Deadline(None);

    /// The moment after a time from `began` on; none where that is farther off than time can be told.
    pub fn after(began: Instant, time: Duration) -> Deadline {
        Deadline(began.checked_add(time))
    }

    /// The time until then; none where there is no such moment.
    pub fn left(&self) -> Option<Duration> {
        self.0.map(|moment| moment.saturating_duration_since(Instant::now()))
    }

    /// Whether the moment has come.
    pub fn has_passed(&self) -> bool {
        self.0.is_some_and(|moment| Instant::now() >= moment)
    }
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
}
