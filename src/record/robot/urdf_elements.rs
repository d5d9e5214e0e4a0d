//! What single elements of URDF say: origins, axes, shapes, numbers.

use nalgebra::{Matrix3, Rotation3, Vector3};

use super::tags::{Fault, Tag};

/// Greatest angle that is taken for radians: a turn, and what rounding puts on top of it.
pub(super) const GREATEST_ANGLE: f64 = std::f64::consts::TAU + 0.01;

/// Where something is in the frame of its link or its parent.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Origin {
    /// Metres.
    pub place: Vector3<f64>,
    /// Roll, pitch and yaw, radians: turns about axes that stand still, one after the other.
    pub turns: [f64; 3],
}

impl Origin {
    /// The `<origin>` in an element, which is called `of` in messages; zero where there is none.
    pub fn of(tag: &Tag, of: &str) -> Result<Origin, Fault> {
        let Some(origin) = tag.child("origin") else {
            return Ok(Origin { place: Vector3::zeros(), turns: [0.0; 3] });
        };
        let place = vector(origin, "xyz", of)?.unwrap_or_default();
        let turns = vector(origin, "rpy", of)?.unwrap_or_default();
        if turns.amax() > GREATEST_ANGLE {
            let message = format!(
                "rpy=\"{}\" of {of} is more than a turn: give radians, not degrees",
                origin.value("rpy").unwrap_or_default()
            );
            return Err((origin.line, message));
        }
        Ok(Origin { place, turns: turns.into() })
    }
}

/// The rotation by roll, pitch and yaw.
pub(super) fn rotation([roll, pitch, yaw]: [f64; 3]) -> Matrix3<f64> {
    Rotation3::from_euler_angles(roll, pitch, yaw).into_inner()
}

/// The unit axis of a joint, in the joint's frame; x where it has none.
pub(super) fn axis_of(tag: &Tag, name: &str) -> Result<Vector3<f64>, Fault> {
    let Some(axis) = tag.child("axis") else { return Ok(Vector3::x()) };
    let direction = vector(axis, "xyz", &format!("joint {name}"))?.unwrap_or(Vector3::x());
    direction.try_normalize(f64::EPSILON).ok_or_else(|| {
        let message = format!("the axis of joint {name} has no direction: give it one in <axis xyz=\"…\"/>");
        (axis.line, message)
    })
}

/// The multiplier and the offset of a `<mimic>`, and the joint that it names.
pub(super) fn follows<'a>(mimic: &'a Tag, joint: &str) -> Result<([f64; 2], &'a str), Fault> {
    let of = format!("joint {joint}");
    let Some(leader) = mimic.value("joint").filter(|leader| !leader.is_empty()) else {
        let message = format!("<mimic> of joint {joint} names no joint: give it joint=\"…\"");
        return Err((mimic.line, message));
    };
    let multiplier = number(mimic, "multiplier", &of)?.unwrap_or(1.0);
    Ok(([multiplier, number(mimic, "offset", &of)?.unwrap_or(0.0)], leader))
}

/// The shapes of a link's collision geometry that are no meshes: a surface's name, the `<collision>` and the shape.
pub(super) fn shapes<'a>(link: &str, tag: &'a Tag) -> Vec<(String, &'a Tag, &'a Tag)> {
    let known = |name: &str| ["sphere", "cylinder", "capsule", "box"].contains(&name);
    let shape =
        |collision: &'a Tag| collision.child("geometry")?.children.iter().find(|shape| known(&shape.name));
    let found: Vec<(&Tag, &Tag)> = tag
        .children
        .iter()
        .filter(|child| child.name == "collision")
        .filter_map(|collision| Some((collision, shape(collision)?)))
        .collect();
    let alone = found.len() == 1;
    let called = |i: usize| if alone { link.to_string() } else { format!("{link}.{}", i + 1) };
    found.into_iter().enumerate().map(|(i, (collision, shape))| (called(i), collision, shape)).collect()
}

/// The name of a link or joint.
pub(super) fn name_of(tag: &Tag) -> Result<&str, Fault> {
    tag.value("name")
        .filter(|name| !name.trim().is_empty())
        .ok_or_else(|| (tag.line, format!("<{}> has no name: give it name=\"…\"", tag.name)))
}

/// The numbers of an attribute of a part of `of`, separated by spaces.
fn numbers(tag: &Tag, name: &str, of: &str) -> Result<Option<Vec<f64>>, Fault> {
    let Some(text) = tag.value(name) else { return Ok(None) };
    let refused = |what: &str| Err((tag.line, format!("{name}=\"{text}\" in <{}> of {of} {what}", tag.name)));
    if text.contains("${") {
        return refused("is of Xacro, not URDF: write it out with `xacro FILE > robot.urdf`");
    }
    let read: Result<Vec<f64>, _> = text.split_ascii_whitespace().map(str::parse).collect();
    match read {
        Ok(numbers) if numbers.iter().all(|number| number.is_finite()) => Ok(Some(numbers)),
        _ => refused("is not made of finite numbers: give numbers, separated by spaces"),
    }
}

/// A vector in an attribute.
pub(super) fn vector(tag: &Tag, name: &str, of: &str) -> Result<Option<Vector3<f64>>, Fault> {
    match numbers(tag, name, of)?.as_deref() {
        None => Ok(None),
        Some([x, y, z]) => Ok(Some(Vector3::new(*x, *y, *z))),
        Some(other) => Err((
            tag.line,
            format!("{name} in <{}> of {of} has {} numbers: give three", tag.name, other.len()),
        )),
    }
}

/// A number in an attribute.
pub(super) fn number(tag: &Tag, name: &str, of: &str) -> Result<Option<f64>, Fault> {
    match numbers(tag, name, of)?.as_deref() {
        None => Ok(None),
        Some([number]) => Ok(Some(*number)),
        Some(other) => {
            Err((tag.line, format!("{name} in <{}> of {of} has {} numbers: give one", tag.name, other.len())))
        }
    }
}
