//! A recording as lines of JSON: the fields of a session's log, of which only what is needed must be there.

use std::path::Path;

use nalgebra::Vector3;
use serde::Deserialize;
use serde_json::Value;

use super::posture::unit_quaternions;
use super::raw::{RawEnd, RawTouch};
use crate::creature::{Creature, DofKind, Posture};
use crate::record::RecordError;
use crate::record::error::ContentFault;
use crate::record::error::json_reason;
use crate::record::json_lines::incomplete;
use crate::record::touch_reader::check_header;

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

/// The touches, and the number of a last line that is incomplete. A header is checked where there is one.
pub(super) fn read(
    path: &Path,
    bytes: &[u8],
    creature: &Creature,
) -> Result<(Vec<RawTouch>, Option<usize>), RecordError> {
    let mut touches = Vec::new();
    let mut lines = bytes.split_inclusive(|&byte| byte == b'\n').enumerate().peekable();
    while let Some((number, json)) = lines.next() {
        let line = number + 1;
        if json.trim_ascii().is_empty() {
            continue;
        }
        if touches.is_empty()
            && serde_json::from_slice::<Value>(json).is_ok_and(|v| v.get("format").is_some())
        {
            check_header(path, json, line, creature)?;
            continue;
        }
        let found: JsonTouchLine = match serde_json::from_slice(json) {
            Ok(found) => found,
            Err(error) if lines.peek().is_none() && !touches.is_empty() && incomplete(json, &error) => {
                return Ok((touches, Some(line)));
            }
            Err(error) => {
                let message = format!("it is no touch ({}): mend the line or delete it", json_reason(&error));
                return Err(RecordError::format(path, Some(line), message));
            }
        };
        let touch = touch(found, line, creature);
        touches.push(touch.map_err(|message| RecordError::format(path, Some(line), message))?);
    }
    Ok((touches, None))
}

fn touch(found: JsonTouchLine, line: usize, creature: &Creature) -> Result<RawTouch, ContentFault> {
    let mut posture = posture(&found.posture, creature)?;
    unit_quaternions(creature, &mut posture);
    let end = |k: usize| -> Result<RawEnd, ContentFault> {
        let point = match found.contacts.map(|contacts| contacts[k]) {
            None => None,
            Some([Some(x), Some(y), Some(z)]) => Some(Vector3::new(x, y, z)),
            Some(_) => {
                return Err(format!(
                    "contacts[{k}] is not three finite numbers: give metres in the limb's frame, or leave the touch \
                     out"
                ).into());
            }
        };
        let deviation = found.deviations.and_then(|deviations| deviations[k]);
        if let Some(wrong) = deviation.filter(|deviation| !(deviation.is_finite() && *deviation >= 0.0)) {
            return Err(
                format!("deviations[{k}] is {wrong}: give metres that are not negative, or null").into()
            );
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
fn posture(value: &Value, creature: &Creature) -> Result<Posture, ContentFault> {
    let number = |value: &Value, place: &str| {
        value.as_f64().ok_or_else(|| {
            format!("posture: {place} is {value} and no finite number: give one, or leave the touch out")
        })
    };
    match value {
        Value::Array(values) => {
            let values: Result<Vec<f64>, String> = values
                .iter()
                .enumerate()
                .map(|(i, value)| number(value, &format!("number {}", i + 1)))
                .collect();
            let values = values?;
            if values.len() != creature.coordinates() {
                return Err(format!(
                    "posture has {} numbers but {} has {} coordinates: give one for each, in the creature's order, or \
                     an object of names",
                    values.len(),
                    creature.name(),
                    creature.coordinates()
                ).into());
            }
            Ok(values.into())
        }
        Value::Object(named) => {
            if let Some(unknown) = named.keys().find(|name| !creature.dofs().any(|dof| dof.name == **name)) {
                return Err(format!(
                    "posture: {} has no degree of freedom \"{unknown}\": name those of the creature's file",
                    creature.name()
                )
                .into());
            }
            let mut posture = Vec::new();
            for dof in creature.dofs() {
                let Some(value) = named.get(&dof.name) else {
                    return Err(
                        format!("posture: {} is missing: give it, or leave the touch out", dof.name).into()
                    );
                };
                match (dof.kind, value) {
                    (DofKind::Ball, Value::Array(values)) if values.len() == 4 => {
                        for value in values {
                            posture.push(number(value, &dof.name)?);
                        }
                    }
                    (DofKind::Ball, _) => {
                        return Err(format!(
                            "posture: {} is a ball: give its quaternion [w, x, y, z]",
                            dof.name
                        )
                        .into());
                    }
                    _ => posture.push(number(value, &dof.name)?),
                }
            }
            Ok(posture.into())
        }
        _ => Err("posture is neither a list of numbers nor an object of names: give one of the two".into()),
    }
}
