//! Progress on standard error; silent where that is no terminal, and with `--quiet`.
//!
//! Colours are indicatif's, which leaves them out where `NO_COLOR` is set.

use std::fmt::Write;
use std::time::Duration;

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressFinish, ProgressState, ProgressStyle};

use super::message::quiet;

/// How often a bar is drawn anew where nothing happens.
const TICK: Duration = Duration::from_millis(100);

/// Steps a second, as exact as a person reads them.
fn rate(state: &ProgressState, text: &mut dyn Write) {
    let rate = state.per_sec();
    // A rate that cannot be told is none to wait for.
    let _ = if rate < 10.0 { write!(text, "{rate:.1}/s") } else { write!(text, "{rate:.0}/s") };
}

fn bar(total: Option<u64>, template: &str) -> ProgressBar {
    let target = if quiet() { ProgressDrawTarget::hidden() } else { ProgressDrawTarget::stderr() };
    let style =
        ProgressStyle::with_template(template).expect("the templates are right").with_key("rate", rate);
    let bar = ProgressBar::with_draw_target(total, target).with_style(style);
    // A failure's sentence stands on a line of its own.
    let bar = bar.with_finish(ProgressFinish::AndClear);
    if !bar.is_hidden() {
        bar.enable_steady_tick(TICK);
    }
    bar
}

/// A bar that counts, with rate and time left.
pub fn counted(doing: &str, total: u64, what: &str) -> ProgressBar {
    let counts = "{msg} {bar:24.cyan/blue} {human_pos}/{human_len}";
    bar(Some(total), &format!("{counts} {what}  {{rate:.dim}}  {{eta}} left")).with_message(doing.to_string())
}

/// A bar of few long steps, each of which says what it is.
pub fn steps(total: u64) -> ProgressBar {
    bar(Some(total), "{bar:32.cyan/blue} {msg}  {elapsed:.dim}, {eta} left")
}

/// A spinner beside a sentence, for what cannot be counted.
pub fn spinner(message: &str) -> ProgressBar {
    bar(None, "{spinner:.cyan} {msg}  {elapsed:.dim}").with_message(message.to_string())
}
