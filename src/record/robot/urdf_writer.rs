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
        let rest = vec![0.0; self.robot.coordinates()];
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
    use crate::calibration::robot::Knowledge;
    use crate::record::robot::urdf::tests::{ARM, about, assert_near, read};

    fn write(text: &str, robot: &Robot, values: &[Value]) -> (String, Vec<String>) {
        let Written { bytes, left_out } =
            write_urdf(Path::new("arm.urdf"), text.as_bytes(), robot, values).unwrap();
        (String::from_utf8(bytes).unwrap(), left_out)
    }

    /// Frames of the links of one robot in another, by name.
    fn assert_same_links(one: (&Robot, &[Value]), other: (&Robot, &[Value]), names: &[&str], seed: u64) {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        for _ in 0..20 {
            let posture: Vec<f64> = (0..one.0.coordinates()).map(|_| rng.random_range(-2.0..2.0)).collect();
            let frames = [one, other].map(|(robot, values)| Posed::new(robot, values, &posture).frames());
            for name in names {
                let link = [one, other].map(|(robot, _)| robot.link(name).unwrap());
                assert_near(&frames[0][link[0]], &frames[1][link[1]], name);
            }
        }
    }

    #[test]
    fn what_did_not_change_is_written_byte_for_byte() {
        for text in [ARM.to_string(), ARM.replace('\n', "\r\n"), format!("\u{feff}{ARM}")] {
            let robot = read(&text).unwrap().0;
            assert_eq!(write(&text, &robot, &robot.nominal()), (text, Vec::new()));
        }
    }

    #[test]
    fn only_the_numbers_that_changed_are_written() {
        let robot = read(ARM).unwrap().0;
        let mut values = robot.nominal();
        values[robot.quantity("shoulder.position").unwrap()] =
            Value::Position(Vector3::new(0.1, 0.002, 0.30));
        values[robot.quantity("base.radius").unwrap()] = Value::Number(0.051);
        values[robot.quantity("elbow.position").unwrap()] = Value::Position(Vector3::new(0.0, 0.001, 0.0));
        let expected = ARM
            .replace("0.1 0 0.30", "0.1 0.002 0.30")
            .replace("'0.05'", "'0.051'")
            .replace(r#""continuous">"#, "\"continuous\">\n    <origin xyz=\"0 0.001 0\"/>");
        assert_eq!(write(ARM, &robot, &values), (expected, Vec::new()));
    }

    #[test]
    fn a_calibrated_robot_reads_back_as_the_same() {
        let mut robot = read(ARM).unwrap().0;
        let names: Vec<String> = robot.links.iter().map(|link| link.name.clone()).collect();
        let hand = robot.link("hand").unwrap();
        robot.add_mount("hand.mount", hand, Frame::identity());
        robot.add_place("tool", hand, Vector3::new(0.0, 0.0, 0.3));
        for quantity in &mut robot.quantities {
            quantity.knowledge = [Knowledge::Near(0.1); 3];
        }
        let mut rng = ChaCha8Rng::seed_from_u64(1);
        for trial in 0..10 {
            let mut values = robot.nominal();
            for (quantity, value) in robot.quantities.iter().zip(&mut values) {
                let step: Vec<f64> = (0..3).map(|_| rng.random_range(-0.1..0.1)).collect();
                let what = quantity.name.rsplit('.').next().unwrap();
                match what {
                    "gain" | "compliance" if quantity.name != "thumb.gain" => {}
                    "radius" => *value = value.stepped(&[0.1 * step[0]]),
                    "sign" => *value = Value::Number(if rng.random() { 1.0 } else { -1.0 }),
                    _ => *value = value.stepped(&step[..value.size()]),
                }
            }
            let (text, left_out) = write(ARM, &robot, &values);
            assert_eq!(left_out, Vec::<String>::new());
            let again = read(&text).unwrap().0;
            let all: Vec<&str> = names.iter().map(String::as_str).chain(["hand.mount", "tool"]).collect();
            assert_same_links((&robot, &values), (&again, &again.nominal()), &all, trial);
            let turned = values[robot.quantity("shoulder.sign").unwrap()].number() < 0.0;
            assert_eq!(again.dofs[0].range, if turned { [-2.0, 1.0] } else { [-1.0, 2.0] });
        }
    }

    #[test]
    fn what_urdf_cannot_say_is_told() {
        let robot = read(ARM).unwrap().0;
        let mut values = robot.nominal();
        values[robot.quantity("elbow.gain").unwrap()] = Value::Number(1.03);
        values[robot.quantity("finger.compliance").unwrap()] = Value::Number(1e-4);
        let (text, left_out) = write(ARM, &robot, &values);
        assert_eq!(text, ARM);
        assert!(left_out[0].starts_with("gain of elbow (1.030000) cannot be said in URDF: "), "{left_out:?}");
        assert!(
            left_out[1].starts_with("compliance of finger (1.000e-4 m/N) cannot be said"),
            "{left_out:?}"
        );
    }

    #[test]
    fn an_upright_pitch_keeps_its_rotation() {
        let mut rng = ChaCha8Rng::seed_from_u64(2);
        let upright = 0.5 * std::f64::consts::PI;
        let rotation = |turns: [f64; 3]| Origin { place: Vector3::zeros(), turns }.rotation();
        for pitch in [upright, upright + 4e-6, 1e-4 - upright, 1.6, 0.3] {
            let near = [rng.random_range(-3.0..3.0), pitch, rng.random_range(-3.0..3.0)];
            for turn in [rotation(near), rotation(near) * about(0, 1e-3).rotation] {
                assert!((rotation(turns(&turn, near)) - turn).norm() < 1e-14, "{near:?}");
            }
            let same = turns(&rotation(near), near);
            assert!(pitch.cos().abs() < 1e-3 || (Vector3::from(same) - Vector3::from(near)).norm() < 1e-13);
        }
    }
}
