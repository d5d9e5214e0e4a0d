//! Progress on standard error; silent where that is no terminal.

use std::time::Duration;

use indicatif::{ProgressBar, ProgressStyle};

/// A bar that counts touches.
pub fn touches(total: usize) -> ProgressBar {
    let style = ProgressStyle::with_template("babbling {bar:32} {pos}/{len} touches  {per_sec}  {eta} left")
        .expect("the template is right");
    ProgressBar::new(total as u64).with_style(style)
}

/// A spinner beside a sentence.
pub fn spinner(message: &str) -> ProgressBar {
    let spinner = ProgressBar::new_spinner().with_message(message.to_string());
    spinner.enable_steady_tick(Duration::from_millis(100));
    spinner
}
