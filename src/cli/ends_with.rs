//! A process that ends when the one does that began it, however that ends: it would go on writing where the next one sweeps.

/// Names, in the environment of a process that another of this program begins, the process that this is.
pub const ENDS_WITH: &str = "BODYSCHEMA_ENDS_WITH";

/// Has the system end this process with the one that the environment names.
#[cfg(target_os = "linux")]
pub fn heed() {
    use rustix::process::{Signal, getppid, set_parent_process_death_signal};

    let parent = std::env::var(ENDS_WITH).ok().and_then(|text| text.parse::<i32>().ok());
    let Some(parent) = parent else { return };
    let asked = set_parent_process_death_signal(Some(Signal::KILL));
    // It may have ended before.
    if asked.is_ok() && getppid().is_none_or(|now| now.as_raw_nonzero().get() != parent) {
        std::process::exit(1);
    }
}

/// Elsewhere there is no such thing.
#[cfg(not(target_os = "linux"))]
pub fn heed() {}
