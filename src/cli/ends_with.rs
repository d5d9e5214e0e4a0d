//! A process that ends when the one does that began it, however that ends: it would go on writing where the next one sweeps.

/// Names, in the environment of a process that another of this program begins, the process that this is.
pub const ENDS_WITH: &str = "BODYSCHEMA_ENDS_WITH";

/// Has the system end this process with the one that the environment names.
#[cfg(target_os = "linux")]
pub fn heed() {
    use nix::sys::prctl::set_pdeathsig;
    use nix::sys::signal::Signal;
    use nix::unistd::getppid;

    let parent = std::env::var(ENDS_WITH).ok().and_then(|text| text.parse::<i32>().ok());
    let Some(parent) = parent else { return };
    let asked = set_pdeathsig(Signal::SIGKILL);
    // It may have ended before.
    if asked.is_ok() && getppid().as_raw() != parent {
        std::process::exit(1);
    }
}

/// Elsewhere there is no such thing.
#[cfg(not(target_os = "linux"))]
pub fn heed() {}
