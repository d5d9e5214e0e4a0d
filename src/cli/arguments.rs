//! The options in effect, as a session keeps them, and back again.

use std::collections::BTreeMap;

use clap::parser::ValueSource;
use clap::{Arg, ArgMatches, Args, Command};

/// Options by their long names, each with its values; a flag that is set has none.
pub type Arguments = BTreeMap<String, Vec<String>>;

/// What tells nothing of what a session is: where it goes, what is printed, and how fast it is made.
const NOT_KEPT: [&str; 11] =
    ["help", "version", "quiet", "json", "out", "force", "jobs", "resume", "live", "open", "shard"];

fn name(argument: &Arg) -> &str {
    argument.get_long().unwrap_or(argument.get_id().as_str())
}

/// All options of a command that are in effect: given or by default.
pub fn effective(command: &Command, matches: &ArgMatches) -> Arguments {
    let kept = command.get_arguments().filter(|argument| !NOT_KEPT.contains(&name(argument)));
    let values = |argument: &Arg| {
        let id = argument.get_id().as_str();
        if !argument.get_action().takes_values() {
            return matches.get_flag(id).then(Vec::new);
        }
        let values = matches.get_raw(id)?.map(|value| value.to_string_lossy().into_owned());
        Some(values.collect())
    };
    kept.filter_map(|argument| Some((name(argument).to_string(), values(argument)?))).collect()
}

/// The options of a command that were given, and do not only stand by default.
pub fn given<'a>(command: &'a Command, matches: &ArgMatches) -> Vec<&'a Arg> {
    let source = |argument: &&Arg| matches.value_source(argument.get_id().as_str());
    command.get_arguments().filter(|argument| source(argument) == Some(ValueSource::CommandLine)).collect()
}

/// The command line that puts options into effect, from the program's name on; none where the command lacks one,
/// which is named.
pub fn command_line(command: &Command, arguments: &Arguments) -> Result<Vec<String>, String> {
    let mut line = vec![command.get_name().to_string()];
    for (option, values) in arguments {
        let found = command.get_arguments().find(|argument| name(argument) == option);
        match found.ok_or_else(|| option.clone())?.get_long() {
            // In the order in which the command has them, below.
            None => {}
            Some(long) if values.is_empty() => line.push(format!("--{long}")),
            Some(long) => line.extend(values.iter().map(|value| format!("--{long}={value}"))),
        }
    }
    line.push("--".to_string());
    line.extend(
        command.get_positionals().filter_map(|positional| arguments.get(name(positional))).flatten().cloned(),
    );
    Ok(line)
}

/// Options in effect as a command's arguments again; says why where this version of the command does not take them.
pub fn taken_up<A: Args>(name: &'static str, arguments: &Arguments) -> Result<A, String> {
    let command = A::augment_args(Command::new(name));
    let line = command_line(&command, arguments).map_err(|option| format!("there is no --{option}"))?;
    let matches = command.try_get_matches_from(line);
    matches.and_then(|matches| A::from_arg_matches(&matches)).map_err(|error| {
        let text = error.to_string();
        text.lines().next().unwrap_or_default().trim_start_matches("error: ").to_string()
    })
}

/// A number of touches from the command line.
pub fn touch_count(text: &str) -> Result<usize, String> {
    match text.parse::<usize>() {
        Ok(0) => Err("there is nothing to learn from 0 touches: give at least 1".into()),
        Ok(n) if n <= 100_000_000 => Ok(n),
        _ => Err("give a whole number from 1 to 100000000".into()),
    }
}

/// A number above 0 from the command line.
pub fn positive(text: &str) -> Result<f64, String> {
    let number: f64 = text.parse().map_err(|_| "give a number".to_string())?;
    if number > 0.0 && number.is_finite() { Ok(number) } else { Err("give a number above 0".into()) }
}
