//! What a partner types: lines that can be edited, with those before at the arrow keys, in a terminal; as they come from a
//! pipe.

use std::io::{BufRead, ErrorKind, IsTerminal, StdinLock};

use rustyline::config::{Behavior, Config};
use rustyline::error::ReadlineError;
use rustyline::{DefaultEditor, Editor};

use super::Failure;

/// What stands before what is typed in a terminal.
const PROMPT: &str = "> ";

/// The lines that somebody types, one after the other.
pub enum Typed {
    /// In a terminal.
    Edited(Box<DefaultEditor>),
    /// From a pipe or a file.
    Piped(StdinLock<'static>),
}

impl Typed {
    /// From standard input.
    ///
    /// # Errors
    /// Where a terminal cannot be used.
    pub fn new() -> Result<Typed, Failure> {
        let input = std::io::stdin();
        if !input.is_terminal() {
            return Ok(Typed::Piped(input.lock()));
        }
        // Results may be sent elsewhere: what is typed, and the prompt, stay on the terminal.
        let config = Config::builder().behavior(Behavior::PreferTerm).build();
        let editor = Editor::with_config(config);
        let editor = editor.map_err(|error| Failure(format!("the terminal cannot be used: {error}")))?;
        Ok(Typed::Edited(Box::new(editor)))
    }

    /// Whether it is typed in a terminal.
    pub fn in_terminal(&self) -> bool {
        matches!(self, Typed::Edited(_))
    }

    /// The next line without blanks at its ends; none at the end, or where a terminal is interrupted. What is no UTF-8 is
    /// replaced.
    ///
    /// # Errors
    /// Where standard input cannot be read.
    pub fn line(&mut self) -> Result<Option<String>, Failure> {
        let unreadable =
            |error: &dyn std::fmt::Display| Failure(format!("standard input cannot be read: {error}"));
        match self {
            Typed::Edited(editor) => {
                let prompt = if super::output::quiet() { "" } else { PROMPT };
                let read = loop {
                    match editor.readline(prompt) {
                        // The editor gives such a line up as a whole.
                        Err(ReadlineError::Io(error)) if error.kind() == ErrorKind::InvalidData => {
                            tell!("that line was not valid UTF-8: type it again");
                        }
                        read => break read,
                    }
                };
                match read {
                    Ok(line) => {
                        // What is not kept in the history can still be said.
                        let _ = editor.add_history_entry(line.as_str());
                        Ok(Some(line.trim().to_string()))
                    }
                    Err(ReadlineError::Eof | ReadlineError::Interrupted) => Ok(None),
                    Err(error) => Err(unreadable(&error)),
                }
            }
            Typed::Piped(input) => {
                let mut line = Vec::new();
                let read = input.read_until(b'\n', &mut line).map_err(|error| unreadable(&error))?;
                Ok((read > 0).then(|| String::from_utf8_lossy(&line).trim().to_string()))
            }
        }
    }
}
