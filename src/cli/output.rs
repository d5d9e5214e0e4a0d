//! What commands print.

use std::io::{ErrorKind, Write};
use std::path::Path;

use serde_json::Value;

use super::Outcome;
use super::printable::Printable;
use crate::error::Error;
use crate::session::{MadeFolders, folder_of, write_whole};
use crate::view::table::Table;
/// An error in its unit, as the report has it; a dash where there is none.
pub(crate) use crate::view::text::error_number as number;
use crate::view::tone::Tone;

/// Prints a line to standard output. Where nobody reads on, as in `… | head`, the program ends in silence;
/// where it cannot be written, as on a full disk, with a sentence.
pub fn line(text: std::fmt::Arguments) {
    print(format_args!("{}", Printable(text)));
}

fn print(text: std::fmt::Arguments) {
    let Err(error) = writeln!(std::io::stdout().lock(), "{text}") else { return };
    if error.kind() == ErrorKind::BrokenPipe {
        std::process::exit(0);
    }
    eprintln!("bodyschema: cannot write to standard output: {error}: send it elsewhere");
    std::process::exit(1);
}

/// Prints a verdict, in its colour where standard output is a terminal that wants colours.
pub fn verdict(sentence: &str, tone: Tone) {
    let safe = console::style(Printable(format_args!("{sentence}")).to_string()).bold();
    let coloured = match tone {
        Tone::Good => safe.green(),
        Tone::Partly => safe.yellow(),
        Tone::Bad => safe.red(),
    };
    print(format_args!("{coloured}"));
}

/// Prints one JSON object; numbers that do not exist are null.
pub fn json(value: &Value) -> Outcome {
    say!("{}", serde_json::to_string_pretty(value)?);
    Ok(())
}

/// The members of two JSON objects in one.
pub fn joined(mut object: Value, with: Value) -> Value {
    if let (Some(object), Value::Object(with)) = (object.as_object_mut(), with) {
        object.extend(with);
    }
    object
}

/// The command line that this program was called with, word by word, the program by its name alone.
pub fn command_line() -> Vec<String> {
    let words = std::env::args_os().skip(1).map(|word| word.to_string_lossy().into_owned());
    std::iter::once(env!("CARGO_PKG_NAME").to_string()).chain(words).collect()
}

/// Writes a file of results, whole or not at all. The folders above it are made, and go again where it cannot be written.
pub fn file(path: &Path, content: impl AsRef<[u8]>) -> Outcome {
    let written = MadeFolders::make(folder_of(path)).and_then(|_made| write_whole(path, content.as_ref()));
    Ok(written.map_err(Error::unwritable(path))?)
}

/// Prints a table.
pub fn table(table: &Table) {
    table.lines().for_each(|line| say!("{line}"));
}
