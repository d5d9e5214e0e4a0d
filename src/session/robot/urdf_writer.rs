//! What calibration found, written into the URDF file that the robot is from.
//!
//! URDF has no words for encoders. An offset goes into the joint's origin, for `X · R(a, q + o) = X · R(a, o) · R(a, q)`; an
//! encoder that counts the other way turns the axis round, and with it the limits. What follows another joint has words:
//! `<mimic multiplier offset>`.

use std::collections::BTreeSet;
use std::path::Path;

use nalgebra::{Matrix3, Rotation3, Unit, Vector3};

use super::urdf::shapes;
use super::writing::{Written, is_to_be_found, unsaid_compliance, unsaid_gain};
use crate::calibration::robot::{Element, Form, Posed, Robot, Value};
use crate::creature::DofKind;
use crate::geometry::Frame;
use crate::model_files::{
    Change, Element as Tag, Origin, Refused, Source, UrdfJoint, UrdfTree, XmlEdits, escape, negative,
    new_element,
};

/// How the format is called in what is left out.
const FORMAT: &str = "URDF";
/// Angles that differ by less are the same but for rounding, radians.
const ROUNDING: f64 = 1e-14;
/// Cosine of a pitch at which roll and yaw turn about the same axis, but for rounding.
const UPRIGHT: f64 = 1e-12;

/// The URDF file `original`, which `robot` was read from, with `values` in the place of the numbers that differ from them, and
/// every other byte as it was. Links that were added to the robot and whose pose was to be found are added to the file.
///
/// `path` is what the file is called in messages.
///
/// # Errors
/// Where `original` is no URDF.
pub fn write_urdf(path: &Path, original: &[u8], robot: &Robot, values: &[Value]) -> Result<Written, Refused> {
    let source = Source::of_bytes(path, original)?;
    let tree = UrdfTree::new(&source)?;
    let mut writer = Writer { robot, values, edits: XmlEdits::new(original), left_out: Vec::new() };
    tree.joints.iter().for_each(|joint| writer.joint(joint));
    tree.links.iter().for_each(|(name, link)| writer.radii(name, link));
    writer.added(&source.root, &tree);
    Ok(Written { bytes: writer.edits.written(), left_out: writer.left_out })
}

struct Writer<'a> {
    robot: &'a Robot,
    values: &'a [Value],
    edits: XmlEdits<'a>,
    left_out: Vec<String>,
}

impl<'a> Writer<'a> {
    fn value(&self, name: &str) -> Option<Value> {
        self.robot.quantity(name).map(|quantity| self.values[quantity])
    }

    /// A joint's origin and axis, and what of its encoder can be said.
    fn joint(&mut self, joint: &UrdfJoint) {
        let UrdfJoint { element: tag, name, .. } = *joint;
        let old = Origin::of(tag);
        let (Some(Value::Position(mut place)), Some(Value::Orientation(mut turn))) =
            (self.value(&format!("{name}.position")), self.value(&format!("{name}.orientation")))
        else {
            return;
        };
        let mut missing = self.degree_of_freedom(joint, &mut place, &mut turn);
        let mut changes = Vec::new();
        if place != old.place {
            changes.push(Change::of("xyz", old.place.as_slice(), place.as_slice()));
        }
        if turn != old.rotation() {
            let change = Change::of("rpy", old.turns, turns(&turn, old.turns));
            changes.push(Change { negligible: ROUNDING, ..change });
        }
        match tag.child("origin") {
            _ if changes.is_empty() => {}
            Some(origin) => self.edits.set(origin, &changes),
            None => missing.insert_str(0, &new_element("origin", &changes)),
        }
        if !missing.is_empty() {
            self.edits.add(tag, &missing, true);
        }
    }

    /// What of a degree of freedom can be said: its offset goes into the pose of its joint, its sign into its axis. An
    /// element for the axis where the file has none.
    fn degree_of_freedom(
        &mut self,
        joint: &UrdfJoint,
        place: &mut Vector3<f64>,
        turn: &mut Matrix3<f64>,
    ) -> String {
        let UrdfJoint { element: tag, name, .. } = *joint;
        let Some(dof) = self.robot.dof(name) else { return String::new() };
        let Some(q) = self.robot.dofs[dof].quantities else { return String::new() };
        let [sign, gain, offset] = [q.sign, q.gain, q.offset].map(|quantity| self.values[quantity].number());
        let mut axis = self.values[q.axis].vector();
        if let Some(mimic) = tag.child("mimic") {
            let [multiplier, shift] = [("multiplier", 1.0), ("offset", 0.0)]
                .map(|(attribute, default)| mimic.number(attribute).unwrap_or(default));
            let leader = mimic.get("joint").unwrap_or_default();
            // The file's numbers go by the joint that it names, which may mimic another in its turn.
            let of_leader = |values: &[Value]| {
                let mimics = self.robot.leaders().all(|other| other.name != leader);
                let q = self.robot.dof(leader).filter(|_| mimics)?;
                let q = self.robot.dofs[q].quantities?;
                Some([values[q.sign].number() * values[q.gain].number(), values[q.offset].number()])
            };
            let [by, at] = of_leader(self.values).unwrap_or([1.0, 0.0]);
            let nominal = self.robot.nominal();
            let same = [q.sign, q.gain, q.offset].iter().all(|q| self.values[*q] == nominal[*q])
                && of_leader(self.values) == of_leader(&nominal);
            if !same && by != 0.0 {
                let new = sign * gain / by;
                self.edits.set(mimic, &[Change::of("multiplier", [multiplier], [new])]);
                self.edits.set(mimic, &[Change::of("offset", [shift], [offset - new * at])]);
            }
        } else {
            match self.robot.dofs[dof].kind {
                _ if offset == 0.0 => {}
                DofKind::Slide => *place += *turn * axis * offset,
                DofKind::Hinge | DofKind::Ball => {
                    *turn *= Rotation3::from_axis_angle(&Unit::new_normalize(axis), offset).matrix();
                }
            }
            if sign < 0.0 {
                axis = -axis;
                self.turn_limits_round(tag);
            }
            self.left_out.extend(unsaid_gain(self.robot, self.values, dof, FORMAT));
        }
        self.left_out.extend(unsaid_compliance(self.robot, self.values, dof, FORMAT));
        let was = joint.axis.normalize();
        if axis == was {
            return String::new();
        }
        let change = Change::of("xyz", was.as_slice(), axis.as_slice());
        match tag.child("axis") {
            // Where the file's axis is not of length 1, none of its numbers stays.
            Some(found) => {
                self.edits.set(found, &[Change { old: joint.axis.as_slice().into(), ..change }]);
                String::new()
            }
            None => new_element("axis", &[change]),
        }
    }

    /// The limits of an axis that points the other way: each is the other's negative.
    fn turn_limits_round(&mut self, joint: &Tag) {
        for (child, lower, upper) in
            [("limit", "lower", "upper"), ("safety_controller", "soft_lower_limit", "soft_upper_limit")]
        {
            let Some(limit) = joint.child(child) else { continue };
            for (name, other) in [(lower, upper), (upper, lower)] {
                let opposite = limit.get(other).map(negative);
                // A limit that is not given is 0.
                if limit.has(name) || opposite.is_some() {
                    self.edits.put(limit, name, name, opposite.as_deref().unwrap_or("0"));
                }
            }
        }
    }

    /// The radii of a link's spheres.
    fn radii(&mut self, link: &str, tag: &Tag) {
        for (name, _, shape) in shapes(link, tag) {
            let surface = self.robot.surface(&name).map(|surface| &self.robot.surfaces[surface].form);
            if let (Some(Form::Sphere(radius)), "sphere") = (surface, shape.name.as_str()) {
                let old = shape.number("radius").unwrap_or_default();
                self.edits.set(shape, &[Change::of("radius", [old], [self.values[*radius].number()])]);
            }
        }
    }

    /// Links that are not of the file, where their pose was to be found.
    fn added(&mut self, root: &Tag, tree: &UrdfTree) {
        let mut there: BTreeSet<&str> = tree.links.iter().map(|(name, _)| *name).collect();
        let rest = self.robot.zero_posture();
        let posed = Posed::new(self.robot, self.values, &rest);
        let mut text = String::new();
        for (index, link) in self.robot.links.iter().enumerate().skip(1) {
            let open = is_to_be_found(self.robot, index);
            let pose = posed.frame(&[index]);
            if there.contains(link.name.as_str()) || !open || pose == Frame::identity() {
                continue;
            }
            let parent = self.robot.links[link.parent].name.as_str();
            if !there.contains(parent)
                || link.elements.iter().any(|element| matches!(element, Element::Dof(_)))
            {
                self.left_out.push(format!(
                    "link {} on {parent} is not of the file and cannot be added to it: add {} there by hand",
                    link.name,
                    if there.contains(parent) { "its joint" } else { parent }
                ));
                continue;
            }
            there.insert(&link.name);
            let zero = [0.0; 3];
            let changes = [
                Change::of("xyz", zero, pose.origin.as_slice()),
                Change::of("rpy", zero, turns(&pose.rotation, zero)),
            ];
            let (name, parent) = (escape(&link.name), escape(parent));
            text += &format!(
                "\n<link name=\"{name}\"/>\n<joint name=\"{name}.joint\" type=\"fixed\">\n  <parent \
                 link=\"{parent}\"/>\n  <child link=\"{name}\"/>{}\n</joint>",
                new_element("origin", &changes).replace('\n', "\n  ")
            );
        }
        if !text.is_empty() {
            self.edits.add(root, &text, false);
        }
    }
}

/// Roll, pitch and yaw of a rotation: of the two ways to write it the one nearer to `near`.
fn turns(rotation: &Matrix3<f64>, near: [f64; 3]) -> [f64; 3] {
    let r = rotation;
    let ways = [1.0, -1.0].map(|side: f64| {
        let yaw = match r.m11.hypot(r.m21) {
            // Roll and yaw turn about one axis: the yaw may stay.
            cosine if cosine < UPRIGHT => near[2],
            _ => (side * r.m21).atan2(side * r.m11),
        };
        // What is left without the yaw: exact even where the yaw is not.
        let (sine, cosine) = yaw.sin_cos();
        let pitch = (-r.m31).atan2(cosine * r.m11 + sine * r.m21);
        let roll = (sine * r.m13 - cosine * r.m23).atan2(cosine * r.m22 - sine * r.m12);
        let found = Vector3::new(roll, pitch, yaw);
        let near = Vector3::from(near);
        found.zip_map(&near, |found, near| {
            found + ((near - found) / std::f64::consts::TAU).round() * std::f64::consts::TAU
        })
    });
    let far = |way: &Vector3<f64>| (way - Vector3::from(near)).norm();
    let [first, second] = ways;
    if far(&second) < far(&first) { second.into() } else { first.into() }
}

#[cfg(test)]
mod tests {
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    use super::*;

    #[test]
    fn an_upright_pitch_keeps_its_rotation() {
        let mut rng = ChaCha8Rng::seed_from_u64(2);
        let upright = 0.5 * std::f64::consts::PI;
        let rotation = |turns: [f64; 3]| Origin { place: Vector3::zeros(), turns }.rotation();
        for pitch in [upright, upright + 4e-6, 1e-4 - upright, 1.6, 0.3] {
            let near = [rng.random_range(-3.0..3.0), pitch, rng.random_range(-3.0..3.0)];
            for turn in [rotation(near), rotation(near) * rotation([1e-3, 0.0, 0.0])] {
                assert!((rotation(turns(&turn, near)) - turn).norm() < 1e-14, "{near:?}");
            }
            let same = turns(&rotation(near), near);
            assert!(pitch.cos().abs() < 1e-3 || (Vector3::from(same) - Vector3::from(near)).norm() < 1e-13);
        }
    }
}
