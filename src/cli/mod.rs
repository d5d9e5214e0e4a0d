//! The command line: one file per command.
//!
//! Results go to standard output, progress and messages to standard error. Exit codes: 0 done, 1 failed,
//! 2 wrong usage.

/// Prints a line to standard output; see [`output::line`].
macro_rules! say {
    ($($text:tt)*) => { $crate::cli::output::line(format_args!($($text)*)) };
}

/// Prints a message to standard error; see [`output::message`].
macro_rules! tell {
    ($($text:tt)*) => { $crate::cli::output::message(format_args!($($text)*)) };
}

mod babble;
mod calibrate;
mod completions;
mod demo;
mod export;
mod folders;
mod inspect;
mod learn;
mod learned;
mod live;
mod open;
mod output;
mod progress;
mod reach;
mod render;
mod report;
mod skin;
mod study;
mod talk;
mod threads;
mod typed;
mod view;

use std::fmt::Display;
use std::path::Path;
use std::process::ExitCode;

use clap::error::{ContextKind, ErrorKind};
use clap::{CommandFactory, FromArgMatches, Parser, Subcommand};

use crate::session::is_model;

/// The error of a command: one sentence with the file, the position and the fix.
#[derive(Debug)]
pub struct Failure(String);

impl Failure {
    /// An error about a file or folder.
    fn at(path: &Path, sentence: impl Display) -> Failure {
        Failure(format!("{}: {sentence}", path.display()))
    }
}

impl<E: Display> From<E> for Failure {
    fn from(error: E) -> Failure {
        Failure(error.to_string())
    }
}

type Outcome = Result<(), Failure>;

#[derive(Parser)]
#[command(
    name = "bodyschema",
    version,
    about = "A creature in MuJoCo learns where its joints are from self-touch alone",
    after_help = "Examples:
  bodyschema demo                                            # Max learns his body; then talk to him
  bodyschema babble mjcf/max/max.xml                         # babble, learn, and measure
  bodyschema inspect mjcf/max/max.xml                        # what the agent is given
  bodyschema skin creature.xml --out with_skin.xml           # grow a skin on another creature
  bodyschema learn sessions/max-1 --learner hersch           # learn again from a session's touches
  bodyschema learn --creature robot.json --log touches.csv   # learn from a recording of a real body
  bodyschema calibrate examples/robot/arms.urdf examples/robot/touches.csv --out calibrated
  bodyschema render sessions/max-1 --touch 3 --out touch.png # a picture of a touch
  bodyschema reach sessions/max-1                            # the workspace of its hands
  bodyschema export sessions/max-1 --out max.urdf            # the learned body for other programs
  bodyschema study learners --trials 5                       # compare learners; takes minutes"
)]
struct Cli {
    #[command(subcommand)]
    command: Command,
    /// Print errors only, no progress or other messages
    #[arg(short, long, global = true)]
    quiet: bool,
}

/// The commands, each with its documentation, its arguments and the function that runs it.
macro_rules! commands {
    ($($(#[$about:meta])* $name:ident($arguments:ty) => $run:path,)*) => {
        #[derive(Subcommand)]
        enum Command {
            $($(#[$about])* $name($arguments),)*
        }

        impl Command {
            fn run(&self) -> Outcome {
                match self {
                    $(Command::$name(arguments) => $run(arguments),)*
                }
            }
        }
    };
}

commands! {
    Demo(demo::DemoArguments) => demo::run,
    Babble(babble::BabbleArguments) => babble::run,
    Learn(learn::LearnArguments) => learn::run,
    Calibrate(calibrate::CalibrateArguments) => calibrate::run,
    Plan(calibrate::plan::PlanArguments) => calibrate::plan::run,
    Report(report::ReportArguments) => report::run,
    View(view::ViewArguments) => view::run,
    Render(render::RenderArguments) => render::run,
    Reach(reach::ReachArguments) => reach::run,
    Export(export::ExportArguments) => export::run,
    Inspect(inspect::InspectArguments) => inspect::run,
    Skin(skin::SkinArguments) => skin::run,
    Talk(talk::TalkArguments) => talk::run,
    Study(study::StudyArguments) => study::run,
    #[command(hide = true)]
    Completions(completions::CompletionsArguments) => completions::run,
    #[command(hide = true)]
    Rehearse(open::RehearseArgs) => open::run,
}

/// Checks the usage of a command line that begins with the program's name, without running it.
///
/// # Errors
/// The usage error as printed for a person; a request for help is one too.
pub fn check_usage<S: Into<std::ffi::OsString> + Clone>(
    line: impl IntoIterator<Item = S>,
) -> Result<(), String> {
    Cli::try_parse_from(line).map(drop).map_err(|error| error.to_string())
}

/// Commands of the previous version, and those that replace them.
const RENAMED: [(&str, &str); 8] = [
    ("evaluate", "report"),
    ("observe", "report"),
    ("space", "reach"),
    ("feel", "skin feel"),
    ("map", "skin map"),
    ("generate", "study generate"),
    ("gallery", "study gallery"),
    ("merge", "study merge"),
];

/// Options allowed with `babble --resume`, and itself.
const BESIDE_RESUME: [&str; 6] = ["resume", "jobs", "json", "live", "open", "quiet"];

/// The program. `babble --resume` takes all other options from the session.
fn program() -> clap::Command {
    Cli::command().mut_subcommand("babble", |babble| {
        let ids = babble.get_arguments().map(|argument| argument.get_id().clone());
        let others: Vec<_> = ids.filter(|id| !BESIDE_RESUME.contains(&id.as_str())).collect();
        babble.mut_arg("resume", |resume| resume.conflicts_with_all(others))
    })
}

/// Runs the program with the process' arguments.
pub fn run() -> ExitCode {
    match carry_out() {
        Ok(()) => ExitCode::SUCCESS,
        Err(Failure(sentence)) => {
            let sentence = crate::error::shortened(sentence);
            eprintln!("bodyschema: {}", output::printable(sentence));
            ExitCode::FAILURE
        }
    }
}

/// The command line. `learn MODEL` is `babble MODEL`: a model has no touches yet.
fn words() -> Vec<std::ffi::OsString> {
    let mut words: Vec<_> = std::env::args_os().collect();
    let is_model = |word: &std::ffi::OsString| is_model(Path::new(word));
    if words.get(1).is_some_and(|command| command == "learn") && words.get(2).is_some_and(is_model) {
        words[1] = "babble".into();
    }
    words
}

fn carry_out() -> Outcome {
    let mut program = program();
    let matches = program.try_get_matches_from_mut(words()).unwrap_or_else(|error| {
        let word = error.get(ContextKind::InvalidSubcommand).map(ToString::to_string);
        match RENAMED.iter().find(|(old, _)| word.as_deref() == Some(old)) {
            Some((old, new)) => {
                let sentence =
                    format!("`bodyschema {old}` is now `bodyschema {new}`; see `bodyschema {new} --help`");
                program.error(ErrorKind::InvalidSubcommand, sentence).exit()
            }
            None => error.exit(),
        }
    });
    let cli = Cli::from_arg_matches(&matches).unwrap_or_else(|error| error.exit());
    if cli.quiet {
        output::be_quiet();
    }
    threads::make();
    cli.command.run()
}
