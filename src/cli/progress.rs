//! Progress on standard error; silent where that is no terminal, and with `--quiet`.
//!
//! Colours are indicatif's, which leaves them out where `NO_COLOR` is set.

use std::cell::RefCell;
use std::fmt::Write;
use std::time::Duration;

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressFinish, ProgressState, ProgressStyle};

use super::output::quiet;
use crate::deadline::Deadline;
use crate::learning::growth::Growth;
use crate::senses::RecordedTouch;
use crate::session::{LearningStep, Observer, Phase};

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

/// Touches as they come, where nobody knows how many it takes or how many there will be: no time left is told, but the most.
fn until(deadline: Deadline, touches: u64) -> ProgressBar {
    let most =
        deadline.left().map_or(String::new(), |left| format!(" of {:.0}s at most", left.as_secs_f64()));
    let template = "{spinner:.cyan} {msg}, {human_pos} touches  {rate:.dim}  {elapsed:.dim}";
    bar(Some(touches), &format!("{template}{most}")).with_message("babbling")
}

/// A bar of few long steps, each of which says what it is.
pub fn steps(total: u64) -> ProgressBar {
    bar(Some(total), "{bar:32.cyan/blue} {msg}  {elapsed:.dim}, {eta} left")
}

/// A spinner beside a sentence, for what cannot be counted.
pub fn spinner(message: &str) -> ProgressBar {
    bar(None, "{spinner:.cyan} {msg}  {elapsed:.dim}").with_message(message.to_string())
}

/// Messages, and a bar for every phase of an experiment.
#[derive(Default)]
pub struct Bars {
    bar: RefCell<Option<ProgressBar>>,
}

impl Bars {
    fn advance(&self) {
        if let Some(bar) = &*self.bar.borrow() {
            bar.inc(1);
        }
    }
}

impl Observer for Bars {
    fn note(&self, sentence: &str) {
        tell!("{sentence}");
    }

    fn phase(&self, phase: Phase) {
        let mut bar = self.bar.borrow_mut();
        if let (Phase::LearningUndisturbed, Some(bar)) = (phase, &*bar) {
            bar.set_message("learning without the disturbances, for comparison");
            return;
        }
        bar.iter().for_each(ProgressBar::finish_and_clear);
        *bar = match phase {
            Phase::Babbling { made, touches, grows, deadline } => {
                let bar = match grows || deadline.left().is_some() {
                    true => until(deadline, touches as u64),
                    false => counted("babbling", touches as u64, "touches"),
                };
                bar.set_position(made as u64);
                Some(bar)
            }
            Phase::Learning { touches, each: true } => Some(counted("learning", touches as u64, "touches")),
            Phase::Learning { touches, each: false } => {
                Some(spinner(&format!("learning from {touches} touches")))
            }
            Phase::LearningUndisturbed | Phase::Done => None,
        };
    }

    fn touched(&self, _: &RecordedTouch) {
        self.advance();
    }

    fn grew(&self, growth: &Growth) {
        if let Some(bar) = &*self.bar.borrow() {
            let [known, all] = growth.known_joints();
            bar.set_message(format!("babbling, {known} of {all} joints known"));
        }
    }

    fn learned(&self, _: &LearningStep) {
        self.advance();
    }
}
