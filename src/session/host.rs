//! The computer that a session was made on.

use std::fmt;

use serde::{Deserialize, Serialize};

/// A computer, as far as times depend on it.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(expecting = "an object")]
pub struct Host {
    /// The processor's name; its architecture where it tells no name.
    pub cpu: String,
    /// Threads that run at the same time.
    pub cores: usize,
    /// The operating system.
    pub os: String,
}

impl Host {
    /// This computer.
    pub fn here() -> Host {
        let value = |file: &str, key: &str| {
            let text = std::fs::read_to_string(file).ok()?;
            let line = text.lines().find(|line| line.starts_with(key))?;
            let (_, value) = line.split_once([':', '='])?;
            Some(value.trim().trim_matches('"').to_string()).filter(|value| !value.is_empty())
        };
        let (arch, os) = (std::env::consts::ARCH, std::env::consts::OS);
        Host {
            cpu: value("/proc/cpuinfo", "model name").unwrap_or_else(|| arch.to_string()),
            cores: std::thread::available_parallelism().map_or(1, usize::from),
            os: value("/etc/os-release", "PRETTY_NAME")
                .map_or_else(|| os.to_string(), |name| format!("{name} ({os} {arch})")),
        }
    }
}

impl fmt::Display for Host {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let plural = if self.cores == 1 { "" } else { "s" };
        write!(f, "{} core{plural} of {}, {}", self.cores, self.cpu, self.os)
    }
}
