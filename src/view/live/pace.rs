//! How fast what is watched goes: as its page asks for, as long as it does.

use std::sync::{Condvar, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

/// How long a pace holds that no page asks for any more: whoever shuts a page that was paused ends nothing by it.
const HELD: Duration = Duration::from_secs(3);

/// A pace that others may set while somebody keeps it.
#[derive(Debug, Default)]
pub(super) struct Pace {
    asked: Mutex<Option<AskedPace>>,
    news: Condvar,
}

#[derive(Clone, Copy, Debug)]
struct AskedPace {
    /// Touches a second; 0 while it is to rest.
    touches_a_second: f64,
    at: Instant,
}

impl AskedPace {
    /// How long a step is to wait that was begun some time ago; none where it may go on.
    fn left(&self, since: Duration) -> Option<Duration> {
        let held = HELD.checked_sub(self.at.elapsed()).filter(|held| !held.is_zero())?;
        // Whoever rests waits as long as anybody wants that.
        let each = Duration::try_from_secs_f64(self.touches_a_second.recip()).unwrap_or(Duration::MAX);
        each.checked_sub(since).filter(|left| !left.is_zero()).map(|left| left.min(held))
    }
}

impl Pace {
    fn asked(&self) -> MutexGuard<'_, Option<AskedPace>> {
        self.asked.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Asks for so many touches a second, 0 to rest; none for as many as there can be.
    pub fn ask(&self, touches_a_second: Option<f64>) {
        *self.asked() =
            touches_a_second.map(|touches_a_second| AskedPace { touches_a_second, at: Instant::now() });
        self.news.notify_all();
    }

    /// Waits after a touch until the next one is due.
    pub fn keep(&self) {
        let began = Instant::now();
        let mut asked = self.asked();
        while let Some(left) = asked.and_then(|asked| asked.left(began.elapsed())) {
            asked = match self.news.wait_timeout(asked, left) {
                Ok((asked, _)) => asked,
                Err(poisoned) => poisoned.into_inner().0,
            };
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_pace_is_kept_until_another_is_asked_for_or_nobody_asks() {
        let pace = Pace::default();
        let took = |pace: &Pace| {
            let began = Instant::now();
            pace.keep();
            began.elapsed()
        };
        assert!(took(&pace) < Duration::from_secs(1));
        pace.ask(Some(20.0));
        assert!(took(&pace) >= Duration::from_millis(50));
        pace.ask(Some(0.0));
        let rested = std::thread::scope(|scope| {
            let resting = scope.spawn(|| took(&pace));
            std::thread::sleep(Duration::from_millis(200));
            pace.ask(None);
            resting.join().unwrap()
        });
        assert!((Duration::from_millis(150)..HELD).contains(&rested), "{rested:?}");
        // Who asks once and no more is not waited for.
        pace.ask(Some(0.0));
        assert!(took(&pace) < 2 * HELD);
    }
}
