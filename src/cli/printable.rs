//! What a terminal shows and does not obey.

use std::fmt::{self, Display, Write};

/// A text whose control characters are written out as `\\u001b`, as JSON has them; lines and tabs stay. Names in files could
/// else move the cursor, colour or clear the screen, or turn the direction of writing.
pub struct Printable<'a>(pub fmt::Arguments<'a>);

impl Display for Printable<'_> {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        Escaping(formatter).write_fmt(self.0)
    }
}

struct Escaping<'a, 'b>(&'a mut fmt::Formatter<'b>);

impl Write for Escaping<'_, '_> {
    fn write_str(&mut self, text: &str) -> fmt::Result {
        for part in text.split_inclusive(obeyed) {
            let mark = part.chars().next_back().filter(|mark| obeyed(*mark));
            self.0.write_str(&part[..part.len() - mark.map_or(0, char::len_utf8)])?;
            if let Some(mark) = mark {
                write!(self.0, "\\u{:04x}", u32::from(mark))?;
            }
        }
        Ok(())
    }
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
        let of = |text: &str| Printable(format_args!("{text}")).to_string();
        assert_eq!(of("a\u{1b}[31mb\r\u{9b}\u{7f}"), "a\\u001b[31mb\\u000d\\u009b\\u007f");
        assert_eq!(of("left\u{202e}tfel\u{1b}\u{1b}"), "left\\u202etfel\\u001b\\u001b");
        let plain = "left hand: 3 °, ü\n\t– “x”";
        assert_eq!(of(plain), plain);
        let json = serde_json::to_string("a\u{9b}").unwrap();
        assert_eq!(serde_json::from_str::<String>(&of(&json)).unwrap(), "a\u{9b}");
    }
}
