//! `--config FILE`: options from a TOML file, turned into command-line arguments before these are parsed.
//!
//! A table stands for a command, its keys are that command's long options; keys outside of tables are the options
//! that all commands have. What the command line says itself counts for more.

use std::ffi::{OsStr, OsString};
use std::path::PathBuf;

use clap::error::{ContextKind, ContextValue};
use clap::{Arg, ArgAction, Command};
use toml::Spanned;
use toml::de::{DeTable, DeValue};

use super::Failure;
use crate::given_file;

/// An option in the file: `--name=value` as often as it is given, and where it stands.
struct Entry {
    name: String,
    arguments: Vec<String>,
    line: usize,
}

/// A command line with what a file adds to it.
pub struct CommandLine {
    /// All arguments, the program's own name first.
    pub arguments: Vec<OsString>,
    file: PathBuf,
    added: Vec<Entry>,
}

impl CommandLine {
    /// The command line with the options of the file that its `--config` names, if any.
    ///
    /// # Errors
    /// Where the file cannot be read, is no TOML, or has a key or a value that is no option of the program.
    pub fn new(program: &Command, given: Vec<OsString>) -> Result<CommandLine, Failure> {
        let Some(file) = config_of(&given) else {
            return Ok(CommandLine { arguments: given, file: PathBuf::new(), added: Vec::new() });
        };
        let text = given_file::read_text(&file).map_err(|error| {
            Failure(format!("cannot read {}: {error}: give another --config", file.display()))
        })?;
        let parsed = DeTable::parse(&text).map_err(|error| {
            let line = line_of(&text, error.span().map_or(0, |span| span.start));
            let what = error.message().replace('\n', ", ");
            Failure(format!("{}, line {line}: it is no TOML ({what}): mend the line", file.display()))
        })?;
        let names: Vec<&str> = program.get_subcommands().map(Command::get_name).collect();
        let at = (1..given.len()).find(|&k| given[k].to_str().is_some_and(|word| names.contains(&word)));
        let run = at.and_then(|at| given[at].to_str());
        let mut added = Vec::new();
        for (key, value) in parsed.get_ref() {
            let refuse = |start: usize, what: &str| {
                Failure(format!("{}, line {}: {what}", file.display(), line_of(&text, start)))
            };
            let name = key.get_ref().as_ref();
            let Some(table) = value.get_ref().as_table() else {
                let entry = entry(program, program, key.get_ref(), value, &text);
                added.push(entry.map_err(|(start, what)| refuse(start.unwrap_or(key.span().start), &what))?);
                continue;
            };
            let command = program
                .get_subcommands()
                .find(|command| command.get_name() == name && !command.is_hide_set());
            let command = command.ok_or_else(|| {
                refuse(
                    key.span().start,
                    &format!("there is no command {name}: see `bodyschema --help` for those there are"),
                )
            })?;
            for (key, value) in table {
                let entry = entry(program, command, key.get_ref(), value, &text)
                    .map_err(|(start, what)| refuse(start.unwrap_or(key.span().start), &what))?;
                if run == Some(name) && !beaten(command, &entry.name, &given) {
                    added.push(entry);
                }
            }
        }
        let short = |name: &str| {
            let of = |command: &Command| {
                let mut arguments = command.get_arguments();
                arguments.find(|argument| argument.get_long() == Some(name)).and_then(Arg::get_short)
            };
            of(program).or_else(|| program.find_subcommand(run?).and_then(of))
        };
        added.retain(|entry| !stands(&given, &entry.name, short(&entry.name)));
        let mut arguments = given;
        let words = added.iter().flat_map(|entry| entry.arguments.iter().map(OsString::from));
        let place = at.map_or(arguments.len(), |at| at + 1);
        let words: Vec<OsString> = words.collect();
        arguments.splice(place..place, words);
        Ok(CommandLine { arguments, file, added })
    }

    /// What a parser's error says of the file, if it is about what the file added.
    pub fn blame(&self, error: &clap::Error) -> Option<Failure> {
        let Some(ContextValue::String(argument)) = error.get(ContextKind::InvalidArg) else { return None };
        let name = argument.split(' ').next()?.trim_start_matches("--");
        let entry = self.added.iter().find(|entry| entry.name == name)?;
        let text = error.to_string();
        let what = text.lines().next().unwrap_or_default().trim_start_matches("error: ").to_string();
        Some(Failure(format!("{}, line {}: {what}", self.file.display(), entry.line)))
    }
}

/// The file that a command line names with `--config`.
fn config_of(given: &[OsString]) -> Option<PathBuf> {
    let mut words = given.iter().take_while(|word| *word != "--");
    while let Some(word) = words.next() {
        if word == "--config" {
            return words.next().map(PathBuf::from);
        }
        if let Some(file) = word.to_str().and_then(|word| word.strip_prefix("--config=")) {
            return Some(PathBuf::from(file));
        }
    }
    None
}

/// The line, from 1, of a place in a text.
fn line_of(text: &str, place: usize) -> usize {
    text.bytes().take(place).filter(|byte| *byte == b'\n').count() + 1
}

/// Whether a command line gives an option itself.
fn stands(given: &[OsString], name: &str, short: Option<char>) -> bool {
    let gives = |word: &OsStr| {
        let Some(word) = word.to_str() else { return false };
        let long = word.strip_prefix("--").map(|word| word.split('=').next().unwrap_or_default());
        let brief =
            short.is_some_and(|short| !word.starts_with("--") && word.starts_with(&format!("-{short}")));
        long == Some(name) || brief
    };
    given.iter().take_while(|word| *word != "--").any(|word| gives(word))
}

/// Whether the command line gives the option itself, or one that excludes it, or takes all from a session.
fn beaten(command: &Command, name: &str, given: &[OsString]) -> bool {
    let long = |argument: &&Arg| argument.get_long() == Some(name);
    let Some(argument) = command.get_arguments().find(long) else { return false };
    let groups = command.get_groups().filter(|group| group.get_args().any(|id| id == argument.get_id()));
    let rivals = groups.filter(|group| !(*group).clone().is_multiple()).flat_map(|group| group.get_args());
    let rivals = rivals.filter_map(|id| command.get_arguments().find(|argument| argument.get_id() == id));
    let mut all = rivals.chain(command.get_arg_conflicts_with(argument)).chain([argument]);
    let stands_for =
        |argument: &Arg| argument.get_long().is_some_and(|long| stands(given, long, argument.get_short()));
    all.any(stands_for) || stands(given, "resume", None)
}

/// The option that a key of a command's table stands for; an error has its place, where that is not the key's.
fn entry(
    program: &Command,
    command: &Command,
    key: &str,
    value: &Spanned<DeValue>,
    text: &str,
) -> Result<Entry, (Option<usize>, String)> {
    let option =
        |argument: &&Arg| argument.get_long() == Some(key) && !["config", "help", "version"].contains(&key);
    let top = std::ptr::eq(program, command);
    let who = if top { "bodyschema" } else { command.get_name() };
    let argument = command.get_arguments().find(option).ok_or_else(|| {
        let help = if top { "--help" } else { &format!("{who} --help") };
        let table =
            if top { " for all commands (those of one stand below its name, as in [babble])" } else { "" };
        (None, format!("{who} has no option {key}{table}: see `bodyschema {help}` for those there are"))
    })?;
    let refuse =
        |value: &Spanned<DeValue>, what: &str| Err((Some(value.span().start), format!("{key} {what}")));
    let line = line_of(text, value.span().start);
    let made = |arguments| Ok(Entry { name: key.to_string(), arguments, line });
    let flag = !argument.get_action().takes_values();
    match value.get_ref() {
        DeValue::Boolean(set) if flag => made(if *set { vec![format!("--{key}")] } else { Vec::new() }),
        _ if flag => refuse(value, "is a flag: give true or false"),
        DeValue::Array(values) if matches!(argument.get_action(), ArgAction::Append) => {
            let words = values.iter().map(|value| word(value.get_ref()));
            match words.collect::<Option<Vec<String>>>() {
                Some(words) => made(words.iter().map(|word| format!("--{key}={word}")).collect()),
                None => refuse(value, "is an array of something else: give texts or numbers"),
            }
        }
        DeValue::Array(_) => refuse(value, "is given once only: give a text or a number"),
        single => match word(single) {
            Some(word) => made(vec![format!("--{key}={word}")]),
            None => refuse(value, "takes no such value: give a text or a number"),
        },
    }
}

/// A text or a number as it would stand on the command line.
fn word(value: &DeValue) -> Option<String> {
    match value {
        DeValue::String(text) => Some(text.to_string()),
        DeValue::Integer(number) => {
            let parsed = i128::from_str_radix(number.as_str(), number.radix()).ok()?;
            Some(parsed.to_string())
        }
        DeValue::Float(number) => Some(number.as_str().to_string()),
        _ => None,
    }
}
