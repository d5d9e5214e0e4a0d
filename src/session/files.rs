//! Reading and writing the files of a session; JSON that people can read.

use std::fs::{self, File};
use std::path::Path;

use serde::Serialize;

use super::part_file::{folder_of, write_whole};
use crate::error::Error;
use crate::given_file;

/// Makes a folder and those above it where they are missing.
pub(super) fn make_folder(folder: &Path) -> Result<(), Error> {
    fs::create_dir_all(folder).map_err(Error::unwritable(folder))
}

/// The bytes of a file, or what comes through a pipe.
pub(crate) fn read(path: &Path) -> Result<Vec<u8>, Error> {
    given_file::read(path).map_err(Error::unreadable(path))
}

/// Opens a regular file for reading.
pub(super) fn open(path: &Path) -> Result<File, Error> {
    given_file::open(path).map_err(Error::unreadable(path))
}

/// Writes a value as JSON that people can read, whole or not at all; its folder is made if missing.
pub(super) fn write_json(path: &Path, value: &impl Serialize) -> Result<(), Error> {
    let json = serde_json::to_string_pretty(value).map_err(|error| Error::unwritable(path)(error.into()))?;
    make_folder(folder_of(path))?;
    write_whole(path, (on_lines(&json) + "\n").as_bytes()).map_err(Error::unwritable(path))
}

/// JSON of one field a line, with every array of plain values on one line.
fn on_lines(pretty: &str) -> String {
    let mut json = String::with_capacity(pretty.len());
    // Where the innermost array begins, as long as it has plain values alone.
    let (mut array, mut quoted, mut escaped) = (None, false, false);
    for letter in pretty.chars() {
        match letter {
            '[' if !quoted => array = Some(json.len()),
            '{' | '}' if !quoted => array = None,
            ']' if !quoted => {
                if let Some(begin) = array.take() {
                    // No text has a line's end in it.
                    let values: String = json[begin..].split('\n').map(str::trim_start).collect();
                    json.truncate(begin);
                    json += &values;
                }
            }
            '"' if !escaped => quoted = !quoted,
            _ => {}
        }
        escaped = letter == '\\' && !escaped;
        json.push(letter);
    }
    json
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn arrays_of_plain_values_are_on_one_line() {
        let value =
            serde_json::json!({"a [\"]\\": [[1.0, -0.5], ["x\n  y", null]], "b": [], "c": [{"d": [true]}]});
        let json = on_lines(&serde_json::to_string_pretty(&value).unwrap());
        let lines = [
            "{",
            r#"  "a [\"]\\": ["#,
            "    [1.0,-0.5],",
            r#"    ["x\n  y",null]"#,
            "  ],",
            r#"  "b": [],"#,
            r#"  "c": ["#,
            "    {",
            r#"      "d": [true]"#,
            "    }",
            "  ]",
            "}",
        ];
        assert_eq!(json.lines().collect::<Vec<_>>(), lines);
    }
}
