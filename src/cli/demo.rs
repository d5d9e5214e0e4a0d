//! `bodyschema demo`: the program's main job and what it is good for, in one command.

use std::path::Path;

use clap::Parser;

use super::live::show;
use super::open::{MAX, is_there};
use super::{Cli, Outcome};
use crate::session::SESSION_FILE;
use crate::view::report::REPORT_FILE;

/// The session, which the next demonstration finds complete.
const SESSION: &str = "sessions/demo";
/// Max's scene.
const TABLE: &str = "mjcf/max/table.xml";

/// Learn Max's body, open the report, and talk to him at a table in a browser
///
/// Runs `babble`, opens the report that it wrote, and runs `talk --live --open`, printing each command line. The session
/// is kept in sessions/demo and used again the next time. Type or click on the page, or type in the terminal;
/// "goodbye" ends the demonstration. Without a display the addresses of the pages are printed instead.
#[derive(clap::Args)]
#[command(after_help = "Examples:
  bodyschema demo
  echo 'touch your nose' | bodyschema demo")]
pub struct DemoArguments {}

pub fn run(_: &DemoArguments) -> Outcome {
    is_there(Path::new(MAX), "babble")?;
    let session = Path::new(SESSION);
    match session.join(SESSION_FILE).exists() {
        true => command(&["babble", "--resume", SESSION])?,
        false => command(&["babble", MAX, "--out", SESSION])?,
    }
    let report = session.join(REPORT_FILE);
    show(&report.canonicalize().unwrap_or(report).display().to_string());
    command(&["talk", TABLE, SESSION, "--live", "--open"])
}

/// Runs a command of this program, and prints it for who wants to go on alone.
fn command(words: &[&str]) -> Outcome {
    tell!("$ bodyschema {}", words.join(" "));
    Cli::try_parse_from(std::iter::once(&"bodyschema").chain(words))?.command.run()
}
