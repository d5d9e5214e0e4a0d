//! The bytes of a log that somebody gives, whatever it is packed and encoded in.

use std::io::{ErrorKind, Read};
use std::path::Path;

use flate2::read::MultiGzDecoder;

use super::json_lines::drop_zeros;
use super::{RecordError, files};

/// How a file begins that gzip packed.
const PACKED: [u8; 2] = [0x1f, 0x8b];
/// Greatest bytes of a log that is unpacked: a few of a packed one may stand for very many.
const GREATEST_LOG: u64 = 4 << 30;
/// The mark that some programs put before text in UTF-8.
const MARK: [u8; 3] = [0xef, 0xbb, 0xbf];

/// Reads a log as text in UTF-8, unpacked and without a mark before it; and what is worth a note.
///
/// # Errors
/// [`RecordError::Io`] where it cannot be read, [`RecordError::Format`] where it cannot be unpacked.
pub(crate) fn read_log(path: &Path) -> Result<(Vec<u8>, Vec<String>), RecordError> {
    let mut bytes = files::read(path)?;
    let mut notes = Vec::new();
    if bytes.starts_with(&PACKED) {
        let mut plain = Vec::new();
        let refused = |what: String| Err(RecordError::format(path, None, format!("{what}: unpack it first")));
        match MultiGzDecoder::new(&bytes[..]).take(GREATEST_LOG + 1).read_to_end(&mut plain) {
            Ok(_) if plain.len() as u64 > GREATEST_LOG => {
                return refused("unpacked it is larger than 4 GiB".into());
            }
            Ok(_) => {}
            // As it is while it is being written.
            Err(error) if error.kind() == ErrorKind::UnexpectedEof && !plain.is_empty() => {
                notes.push(
                    "it was packed by gzip and ends in the middle: what can be unpacked is used".into(),
                );
            }
            Err(error) => return refused(format!("it is packed by gzip and cannot be read ({error})")),
        }
        bytes = plain;
    }
    let zeros = drop_zeros(&mut bytes);
    if let Some(text) = utf_16(&bytes) {
        bytes = text.into_bytes();
    } else if zeros > 0 {
        notes.push(format!(
            "it ends in {zeros} zero bytes, as a power failure leaves them: they are left out"
        ));
    }
    if bytes.starts_with(&MARK) {
        bytes.drain(..MARK.len());
    }
    Ok((bytes, notes))
}

/// The text of bytes in UTF-16, as spreadsheets write it.
fn utf_16(bytes: &[u8]) -> Option<String> {
    let of: fn([u8; 2]) -> u16 = match bytes {
        [0xff, 0xfe, ..] => u16::from_le_bytes,
        [0xfe, 0xff, ..] => u16::from_be_bytes,
        _ => return None,
    };
    // The last character's zero byte may be gone.
    let pair = |pair: &[u8]| of([pair[0], pair.get(1).copied().unwrap_or_default()]);
    let units: Vec<u16> = bytes[2..].chunks(2).map(pair).collect();
    Some(String::from_utf16_lossy(&units))
}

/// That the last line of a log is left out, as a sentence.
pub(crate) fn cut_in_words(line: usize) -> String {
    format!("it ends in the middle of line {line}: that touch is left out, all before it are used")
}
