//! Messages on standard error, which `--quiet` keeps back; errors it does not.

use std::io::Write;
use std::sync::atomic::{AtomicBool, Ordering};

use super::printable::Printable;

/// Whether nothing but errors is told; set once, before any command runs.
static QUIET: AtomicBool = AtomicBool::new(false);

/// Keeps messages and progress back from now on.
pub fn be_quiet() {
    QUIET.store(true, Ordering::Relaxed);
    console::set_colors_enabled(false);
}

/// Whether messages and progress are kept back.
pub fn quiet() -> bool {
    QUIET.load(Ordering::Relaxed)
}

/// Tells a line on standard error unless that is kept back.
pub fn line(text: std::fmt::Arguments) {
    if !quiet() {
        // A message that nobody can be told is no failure.
        let _ = writeln!(std::io::stderr().lock(), "bodyschema: {}", Printable(text));
    }
}
