//! What commands print: results on standard output, messages on standard error, and nothing that a terminal obeys.

use std::fmt::Display;
use std::io::{ErrorKind, Write};
use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};

use serde_json::Value;

use super::Outcome;
use crate::error::Error;
use crate::session::{MadeFolders, folder_of, write_whole};
use crate::view::table::Table;
/// An error in its unit, as the report has it; a dash where there is none.
pub(crate) use crate::view::text::error_number as number;
use crate::view::tone::Tone;

/// Prints a line to standard output. Where nobody reads on, as in `… | head`, the program ends in silence;
/// where it cannot be written, as on a full disk, with a sentence.
pub fn line(text: std::fmt::Arguments) {
    print(&printable(text));
}

fn print(text: &str) {
    let Err(error) = writeln!(std::io::stdout().lock(), "{text}") else { return };
    if error.kind() == ErrorKind::BrokenPipe {
        std::process::exit(0);
    }
    eprintln!("bodyschema: cannot write to standard output: {error}: redirect it elsewhere");
    std::process::exit(1);
}

/// Prints a verdict, in its colour where standard output is a terminal that wants colours.
pub fn verdict(sentence: &str, tone: Tone) {
    let safe = console::style(printable(sentence)).bold();
    let coloured = match tone {
        Tone::Good => safe.green(),
        Tone::Partly => safe.yellow(),
        Tone::Bad => safe.red(),
    };
    print(&coloured.to_string());
}

/// Prints one JSON object; numbers that do not exist are null.
pub fn json(value: &Value) -> Outcome {
    say!("{}", serde_json::to_string_pretty(value)?);
    Ok(())
}

/// The members of JSON objects in one; what is no object adds nothing.
pub fn joined(objects: impl IntoIterator<Item = Value>) -> Value {
    let members = objects.into_iter().filter_map(|value| match value {
        Value::Object(members) => Some(members),
        _ => None,
    });
    Value::Object(members.flatten().collect())
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
pub fn message(text: std::fmt::Arguments) {
    if !quiet() {
        // A message that nobody can be told is no failure.
        let _ = writeln!(std::io::stderr().lock(), "bodyschema: {}", printable(text));
    }
}

/// A text whose control characters are written out as `\\u001b`, as JSON has them; lines and tabs stay. Names in files could
/// else move the cursor, colour or clear the screen, or turn the direction of writing.
pub fn printable(text: impl Display) -> String {
    let text = text.to_string();
    let mut safe = String::with_capacity(text.len());
    for mark in text.chars() {
        match obeyed(mark) {
            true => safe += &format!("\\u{:04x}", u32::from(mark)),
            false => safe.push(mark),
        }
    }
    safe
}

/// Whether a terminal would do something on a character other than show it.
fn obeyed(mark: char) -> bool {
    let turns = matches!(mark, '\u{200e}' | '\u{200f}' | '\u{202a}'..='\u{202e}' | '\u{2066}'..='\u{2069}');
    turns || mark.is_control() && !matches!(mark, '\n' | '\t')
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn control_characters_are_written_out_and_all_else_stays() {
        let of = |text: &str| printable(text);
        assert_eq!(of("a\u{1b}[31mb\r\u{9b}\u{7f}"), "a\\u001b[31mb\\u000d\\u009b\\u007f");
        assert_eq!(of("left\u{202e}tfel\u{1b}\u{1b}"), "left\\u202etfel\\u001b\\u001b");
        let plain = "left hand: 3 °, ü\n\t– “x”";
        assert_eq!(of(plain), plain);
        let json = serde_json::to_string("a\u{9b}").unwrap();
        assert_eq!(serde_json::from_str::<String>(&of(&json)).unwrap(), "a\u{9b}");
    }
}
