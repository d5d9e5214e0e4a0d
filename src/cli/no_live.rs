//! `--live` where the program was built without it: it says so.

use std::convert::Infallible;
use std::path::Path;

use super::{Failure, Outcome};
use crate::experiment::{Embodied, LearnedSession, Observer, SessionSetup};
use crate::interaction::Conversation;
use crate::simulation::Stage;

const MISSING: &str = "this bodyschema was built without the live page: leave out --live, or install it with `cargo install \
                       --path . --features live`";

/// Where a page is served: nowhere.
pub type Place = Infallible;

/// Whether a page is asked for.
#[derive(clap::Args, Clone, Debug, Default)]
pub struct LiveOptions {
    /// Serve a page to watch it live in a browser: this program was built without it
    #[arg(long, value_name = "ADDRESS", num_args = 0..=1, default_missing_value = "", help_heading = "Output")]
    live: Option<String>,
    /// Open that page in a browser
    #[arg(long, requires = "live", help_heading = "Output")]
    open: bool,
}

impl LiveOptions {
    /// Where a page is to be served: refused where one is asked for.
    pub fn place(&self) -> Result<Option<Place>, Failure> {
        if self.live.is_some() { Err(MISSING.into()) } else { Ok(None) }
    }

    pub fn is_asked(&self) -> bool {
        self.live.is_some()
    }
}

/// A page that is served: there is none.
pub struct Live(Infallible);

impl Live {
    /// Nobody can ask for it.
    pub fn new(never: Place, _: &Embodied, _: &SessionSetup, _: usize) -> Result<Live, Failure> {
        match never {}
    }

    pub fn done(&self, _: &Path, _: &LearnedSession) {
        match self.0 {}
    }

    pub fn rest(&self) {
        match self.0 {}
    }
}

impl Observer for Live {}

/// Nobody can ask for it.
pub fn talk(_: Conversation, _: &Stage, never: Place, _: &str, _: bool) -> Outcome {
    match never {}
}
