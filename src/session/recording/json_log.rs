//! A recording as JSON, a touch a line or a list of them: the fields of a session's log, of which only what is needed must be there.

use std::borrow::Cow;
use std::path::Path;

use nalgebra::Vector3;
use serde::Deserialize;
use serde_json::Value;
use serde_json::value::RawValue;

use super::posture::unit_quaternions;
use super::raw::{RawEnd, RawLog, RawTouch};
use crate::creature::{Creature, DofKind, Posture};
use crate::session::RecordError;
use crate::session::columns::CellFault;
use crate::session::json_lines::incomplete;
use crate::session::record_error::json_reason;
use crate::session::touch_reader::check_header;

/// A line. JSON has no other way to say "not a finite number" than null.
#[derive(Deserialize)]
#[serde(deny_unknown_fields, expecting = "an object")]
struct JsonTouchLine {
    bout: Option<u64>,
    motion: Option<u64>,
    posture: Value,
    limbs: Option<[String; 2]>,
    receptors: Option<[String; 2]>,
    /// Where the receptors are; the skin tells, too.
    #[serde(rename = "positions")]
    _positions: Option<[[f64; 3]; 2]>,
    contacts: Option<[[Option<f64>; 3]; 2]>,
    deviations: Option<[Option<f64>; 2]>,
}

/// The touches of lines of JSON, or of a list of them. A header is checked where there is one.
pub(super) fn read(path: &Path, bytes: &[u8], creature: &Creature) -> Result<RawLog, RecordError> {
    let bytes = &with_null(bytes);
    let mut log = RawLog::default();
    let list = bytes.trim_ascii_start().starts_with(b"[");
    let mut at = usize::from(list) + bytes.len() - bytes.trim_ascii_start().len();
    let mut line = 1 + newlines(&bytes[..at]);
    let between = |byte: &u8| byte.is_ascii_whitespace() || list && *byte == b',';
    while let Some(blank) = bytes[at..].iter().position(|byte| !between(byte)) {
        line += newlines(&bytes[at..at + blank]);
        at += blank;
        if list && bytes[at] == b']' {
            break;
        }
        let json = value(&bytes[at..]);
        let last = at + json.len() == bytes.len();
        if log.touches.is_empty()
            && serde_json::from_slice::<Value>(json).is_ok_and(|v| v.get("format").is_some())
        {
            check_header(path, json, line, creature)?;
        } else {
            match serde_json::from_slice::<JsonTouchLine>(json) {
                Ok(found) => {
                    log.take(line, touch(found, line, creature)).map_err(|fault| (line, fault.into()))
                }
                Err(error) if last && !log.touches.is_empty() && incomplete(json, &error) => {
                    log.cut = Some(line);
                    Ok(())
                }
                Err(error) => {
                    let line = line + error.line().saturating_sub(1);
                    Err((
                        line,
                        format!("it is no touch ({}): mend the line or delete it", json_reason(&error)),
                    ))
                }
            }
            .map_err(|(line, fault): (usize, String)| RecordError::format(path, Some(line), fault))?;
        }
        line += newlines(json);
        at += json.len();
    }
    Ok(log)
}

fn newlines(bytes: &[u8]) -> usize {
    bytes.iter().filter(|&&byte| byte == b'\n').count()
}

/// The JSON that bytes begin with, however many lines it has, or all of them where they end in it; where it is none, the line.
fn value(bytes: &[u8]) -> &[u8] {
    let mut values = serde_json::Deserializer::from_slice(bytes).into_iter::<&RawValue>();
    match values.next() {
        Some(Ok(raw)) => &bytes[..raw.get().len()],
        Some(Err(error)) if error.is_eof() => bytes,
        _ => bytes.split_inclusive(|&byte| byte == b'\n').next().unwrap_or(bytes),
    }
}

/// The same JSON with null for NaN and Infinity, as Python writes them. They are longer or as long, and lines stay.
fn with_null(bytes: &[u8]) -> Cow<'_, [u8]> {
    const WORDS: [&[u8]; 3] = [b"NaN", b"-Infinity", b"Infinity"];
    if !WORDS.iter().any(|word| bytes.windows(word.len()).any(|window| window == *word)) {
        return Cow::Borrowed(bytes);
    }
    let (mut plain, mut at, mut quoted) = (Vec::with_capacity(bytes.len()), 0, false);
    while let Some(&byte) = bytes.get(at) {
        let word = WORDS.iter().find(|word| !quoted && bytes[at..].starts_with(word));
        let taken = word.map_or(1, |word| word.len()).max(1 + usize::from(quoted && byte == b'\\'));
        quoted ^= byte == b'"';
        plain.extend_from_slice(if word.is_some() {
            b"null"
        } else {
            &bytes[at..bytes.len().min(at + taken)]
        });
        at += taken;
    }
    Cow::Owned(plain)
}

fn touch(found: JsonTouchLine, line: usize, creature: &Creature) -> Result<RawTouch, CellFault> {
    let mut posture = posture(&found.posture, creature)?;
    unit_quaternions(creature, &mut posture);
    let end = |k: usize| -> Result<RawEnd, CellFault> {
        let point = match found.contacts.map(|contacts| contacts[k]) {
            None => None,
            Some([Some(x), Some(y), Some(z)]) => Some(Vector3::new(x, y, z)),
            Some(_) => {
                return Err(CellFault::NotFinite(format!(
                    "contacts[{k}] is not three finite numbers, but null or NaN"
                )));
            }
        };
        let deviation = found.deviations.and_then(|deviations| deviations[k]);
        if let Some(wrong) = deviation.filter(|deviation| !(deviation.is_finite() && *deviation >= 0.0)) {
            let message = format!("deviations[{k}] is {wrong}: give metres that are not negative, or null");
            return Err(CellFault::Wrong(message));
        }
        Ok(RawEnd {
            limb: found.limbs.as_ref().map(|limbs| limbs[k].clone()),
            limb_place: ["limbs[0]", "limbs[1]"][k],
            receptor: found.receptors.as_ref().map(|receptors| receptors[k].clone()),
            receptor_place: ["receptors[0]", "receptors[1]"][k],
            point,
            deviation,
        })
    };
    Ok(RawTouch { line, bout: found.bout, motion: found.motion, ends: [end(0)?, end(1)?], posture })
}

/// A posture as a list in the creature's order, or as an object of names.
fn posture(value: &Value, creature: &Creature) -> Result<Posture, CellFault> {
    let wrong = |message: String| Err(CellFault::Wrong(message));
    let number = |value: &Value, place: &str| match value {
        Value::Null => Err(CellFault::NotFinite(format!("posture: {place} is null or NaN"))),
        value => value.as_f64().ok_or_else(|| {
            let message =
                format!("posture: {place} is {value} and no finite number: give one, or leave the touch out");
            CellFault::Wrong(message)
        }),
    };
    match value {
        Value::Array(values) => {
            let numbers = values.iter().enumerate();
            let values: Vec<f64> = numbers
                .map(|(i, value)| number(value, &format!("number {}", i + 1)))
                .collect::<Result<_, _>>()?;
            if values.len() != creature.coordinates() {
                return wrong(format!(
                    "posture has {} numbers but {} has {} coordinates: give one for each, in the creature's order, or \
                     an object of names",
                    values.len(),
                    creature.name(),
                    creature.coordinates()
                ));
            }
            Ok(values.into())
        }
        Value::Object(named) => {
            if let Some(unknown) = named.keys().find(|name| !creature.dofs().any(|dof| dof.name == **name)) {
                return wrong(format!(
                    "posture: {} has no degree of freedom \"{unknown}\": name those of the creature's file",
                    creature.name()
                ));
            }
            let mut posture = Vec::new();
            for dof in creature.dofs() {
                let Some(value) = named.get(&dof.name) else {
                    return wrong(format!(
                        "posture: {} is missing: give it, or leave the touch out",
                        dof.name
                    ));
                };
                match (dof.kind, value) {
                    (DofKind::Ball, Value::Array(values)) if values.len() == 4 => {
                        for value in values {
                            posture.push(number(value, &dof.name)?);
                        }
                    }
                    (DofKind::Ball, _) => {
                        return wrong(format!(
                            "posture: {} is a ball: give its quaternion [w, x, y, z]",
                            dof.name
                        ));
                    }
                    _ => posture.push(number(value, &dof.name)?),
                }
            }
            Ok(posture.into())
        }
        _ => wrong("posture is neither a list of numbers nor an object of names: give one of the two".into()),
    }
}
