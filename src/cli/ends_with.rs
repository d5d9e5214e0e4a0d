//! A process that ends when the one does that began it, however that ends: it would go on writing where the next one sweeps.

/// Names, in the environment of a process that another of this program begins, the process that this is.
pub const ENDS_WITH: &str = "BODYSCHEMA_ENDS_WITH";

/// Has the system end this process with the one that the environment names, where there is such a thing.
pub fn heed() {
    let parent = std::env::var(ENDS_WITH).ok().and_then(|text| text.parse::<i32>().ok());
    #[cfg(target_os = "linux")]
    if let Some(parent) = parent {
        use rustix::process::{Signal, getppid, set_parent_process_death_signal};

        let asked = set_parent_process_death_signal(Some(Signal::KILL));
        // It may have ended before.
        if asked.is_ok() && getppid().is_none_or(|now| now.as_raw_nonzero().get() != parent) {
            std::process::exit(1);
        }
    }
    #[cfg(not(target_os = "linux"))]
    let _ = parent;
}
