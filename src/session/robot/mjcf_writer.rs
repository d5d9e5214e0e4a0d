//! What calibration found, written into the MJCF file that the robot is from.
//!
//! An encoder's offset is the joint's `ref` with the other sign: for a `qpos` that it reads MuJoCo turns the joint by
//! `qpos − ref`. An encoder that counts the other way turns the axis round, and with it the limits and `ref`. What follows
//! another joint has words: `polycoef` of its equality.

use std::path::Path;

use nalgebra::{Rotation3, UnitQuaternion};

use super::mjcf::{read_mjcf, surface_name};
use super::writing::{Written, is_to_be_found, unsaid_compliance, unsaid_gain};
use crate::calibration::robot::{Element, Form, Posed, Robot, Value};
use crate::creature::DofKind;
use crate::error::Error;
use crate::geometry::Frame;
use crate::model_files::{
    Angles, Change, Element as Tag, ORIENTATIONS, Source, XmlEdits, escape, exact, negative, new_element,
};

/// How the format is called in what is left out.
const FORMAT: &str = "MJCF";
/// A pose that a file says is the one that MuJoCo compiled if it is no farther from it, metres and radians.
const ROUNDING: f64 = 1e-9;
/// Elements in a body that make others, or put them elsewhere.
const MAKERS: [&str; 5] = ["frame", "replicate", "composite", "flexcomp", "attach"];

/// The MJCF file `original`, which `robot` was read from, with `values` in the place of the numbers that differ from them, and
/// every other byte as it was. Links that were added to the robot and whose pose was to be found become bodies of the file.
///
/// `path` is where the file is.
///
/// # Errors
/// Where it is no MJCF any more.
pub fn write_mjcf(path: &Path, original: &[u8], robot: &Robot, values: &[Value]) -> Result<Written, Error> {
    let source = Source::of_bytes(path, original)?;
    let mut writer = Writer {
        // What the file says, without what was added since.
        file: &read_mjcf(path)?.0,
        robot,
        values,
        angles: Angles::of(&source.root),
        edits: XmlEdits::new(original),
        left_out: Vec::new(),
        unsaid: Vec::new(),
    };
    let bodies = Bodies::of(&source, writer.file);
    writer.bodies(&bodies);
    writer.equalities(&source);
    writer.added(&bodies);
    for dof in 0..writer.file.dofs.len() {
        if !writer.follows(dof) {
            writer.left_out.extend(unsaid_gain(robot, values, dof, FORMAT));
        }
        writer.left_out.extend(unsaid_compliance(robot, values, dof, FORMAT));
    }
    if !writer.unsaid.is_empty() {
        let names = writer.unsaid.join(", ");
        writer.left_out.push(format!(
            "the new numbers of {names} have no place of their own in this file, for they come from an included file, a \
             <frame> or what makes bodies: put them there by hand, from quantities.csv"
        ));
    }
    Ok(Written { bytes: writer.edits.written(), left_out: writer.left_out })
}

/// The bodies of a file that stand in it as they are, each with its link, and their joints with their degrees of freedom.
struct Bodies<'a> {
    links: Vec<(usize, &'a Tag)>,
    joints: Vec<(usize, &'a Tag)>,
}

impl<'a> Bodies<'a> {
    fn of(source: &'a Source, file: &Robot) -> Bodies<'a> {
        let mut bodies = Bodies { links: Vec::new(), joints: Vec::new() };
        let mut count = Count { file, bodies: 1, joints: 0, known: true };
        for world in source.root.all("worldbody") {
            bodies.links.extend(file.link("world").map(|link| (link, world)));
            count.inside(world, &mut bodies);
        }
        bodies.links.retain(|(_, tag)| source.is_own(tag));
        bodies.joints.retain(|(_, tag)| source.is_own(tag));
        bodies
    }
}

/// Bodies and joints counted as MuJoCo does, for those without names.
struct Count<'r> {
    file: &'r Robot,
    bodies: usize,
    joints: usize,
    /// Whether nothing so far made others.
    known: bool,
}

impl Count<'_> {
    fn inside<'a>(&mut self, parent: &'a Tag, bodies: &mut Bodies<'a>) {
        for child in &parent.children {
            if MAKERS.contains(&child.name.as_str()) {
                self.known = false;
            }
            if child.name != "body" {
                continue;
            }
            let name = self.name(child, "body", self.bodies);
            self.bodies += 1;
            bodies.links.extend(name.and_then(|name| self.file.link(&name)).map(|link| (link, child)));
            for joint in
                child.children.iter().filter(|tag| ["joint", "freejoint"].contains(&tag.name.as_str()))
            {
                let name = self.name(joint, "joint", self.joints);
                self.joints += 1;
                bodies.joints.extend(name.and_then(|name| self.file.dof(&name)).map(|dof| (dof, joint)));
            }
            self.inside(child, bodies);
        }
    }

    fn name(&self, tag: &Tag, kind: &str, number: usize) -> Option<String> {
        let own = tag.get("name").map(str::to_string);
        own.or_else(|| self.known.then(|| format!("{kind}{number}")))
    }
}

struct Writer<'a> {
    file: &'a Robot,
    robot: &'a Robot,
    values: &'a [Value],
    angles: Angles,
    edits: XmlEdits<'a>,
    left_out: Vec<String>,
    /// Quantities that the file has no place for.
    unsaid: Vec<String>,
}

impl Writer<'_> {
    fn changed(&self, quantity: usize) -> bool {
        self.values[quantity] != self.file.quantities[quantity].nominal
    }

    fn number(&self, quantity: usize) -> f64 {
        self.values[quantity].number()
    }

    /// Quantities of the file's own bodies, joints and geoms.
    fn bodies(&mut self, bodies: &Bodies) {
        let mut said = vec![false; self.file.quantities.len()];
        for (link, tag) in &bodies.links {
            if *link == 0 {
                // Where the root is does not matter.
                self.radii(*link, tag, &mut said);
            }
            if !self.stands_so(*link, tag) {
                continue;
            }
            let elements = &self.file.links[*link].elements;
            for element in elements {
                match *element {
                    Element::Shift(q) => {
                        said[q] = true;
                        self.position(tag, q);
                    }
                    Element::Turn(q) => {
                        said[q] = true;
                        self.orientation(tag, q);
                    }
                    Element::Dof(dof) => {
                        if let Some((_, joint)) = bodies.joints.iter().find(|(own, _)| *own == dof) {
                            let q = self.file.dofs[dof].quantities;
                            let said_here = q.into_iter().flat_map(|q| [q.axis, q.sign, q.offset]);
                            said_here.for_each(|quantity| said[quantity] = true);
                            self.joint(joint, dof);
                        }
                    }
                    _ => {}
                }
            }
            self.radii(*link, tag, &mut said);
        }
        let ways = self.file.dofs.iter().filter_map(|dof| dof.quantities);
        ways.for_each(|q| [q.gain, q.compliance].into_iter().for_each(|quantity| said[quantity] = true));
        let unsaid = (0..said.len()).filter(|q| !said[*q] && self.changed(*q));
        self.unsaid = unsaid.map(|q| self.file.quantities[q].name.clone()).collect();
    }

    /// Whether a body's pose is what its element says: it is not where something else puts it.
    fn stands_so(&self, link: usize, tag: &Tag) -> bool {
        let said = Frame::from(self.angles.pose(tag));
        let nominal = self.file.nominal();
        match self.file.links[link].elements.as_slice() {
            [Element::Shift(shift), Element::Turn(turn), ..] => {
                let turned = nominal[*turn].distance(&Value::Orientation(said.rotation));
                (nominal[*shift].vector() - said.origin).norm() < ROUNDING && turned < ROUNDING
            }
            _ => false,
        }
    }

    fn position(&mut self, tag: &Tag, q: usize) {
        if self.changed(q) {
            let (old, new) = (self.file.quantities[q].nominal.vector(), self.values[q].vector());
            self.edits.set(tag, &[Change::of("pos", old.as_slice(), new.as_slice())]);
        }
    }

    fn orientation(&mut self, tag: &Tag, q: usize) {
        let (true, Value::Orientation(turn)) = (self.changed(q), self.values[q]) else { return };
        let own = tag.attributes.iter().map(|(name, _)| name.as_str());
        let own = { own }.find(|name| ORIENTATIONS.contains(name)).unwrap_or("quat");
        self.edits.put(tag, own, "quat", &quaternion(&turn).numbers());
    }

    /// A joint's axis and where its coordinate begins.
    fn joint(&mut self, tag: &Tag, dof: usize) {
        let Some(q) = self.file.dofs[dof].quantities else { return };
        let nominal = |quantity: usize| self.file.quantities[quantity].nominal;
        let (old, mut axis) = (nominal(q.axis).vector(), self.values[q.axis].vector());
        if !self.follows(dof) {
            if self.number(q.sign) < 0.0 {
                axis = -axis;
                self.turn_limits_round(tag, dof, nominal(q.offset).number() == 0.0);
            }
            let (before, reference) = (-nominal(q.offset).number(), -self.beginning(dof));
            if reference != before {
                let written = |x: f64| match self.file.dofs[dof].kind {
                    DofKind::Hinge => self.angles.written(x),
                    DofKind::Slide | DofKind::Ball => x,
                };
                let change = Change::of("ref", [written(before)], [written(reference)]);
                self.edits.set(tag, &[change]);
            }
        }
        if axis != old {
            // Where the file's axis is not of length 1, none of its numbers stays.
            let given = if tag.has("axis") { tag.numbers("axis") } else { old.as_slice().to_vec() };
            self.edits.set(tag, &[Change::of("axis", given, axis.as_slice())]);
        }
    }

    /// Where a joint that follows none is by its own axis when its encoder reads zero: minus its `ref`.
    fn beginning(&self, dof: usize) -> f64 {
        self.file.dofs[dof].quantities.map_or(0.0, |q| self.number(q.sign) * self.number(q.offset))
    }

    /// Whether a degree of freedom has the coordinate of another.
    fn follows(&self, dof: usize) -> bool {
        let name = &self.file.dofs[dof].name;
        !self.file.leaders().any(|leader| leader.name == *name)
    }

    /// The limits of an axis that points the other way: each is the other's negative. Without any they are even about `ref`.
    fn turn_limits_round(&mut self, tag: &Tag, dof: usize, begins_at_zero: bool) {
        let range = self.file.dofs[dof].range;
        let text =
            match tag.get("range").map(|own| own.split_ascii_whitespace().collect::<Vec<_>>()).as_deref() {
                Some([low, high]) => format!("{} {}", negative(high), negative(low)),
                // Those of a default class.
                None if begins_at_zero && range[0] + range[1] != 0.0 => {
                    let hinge = self.file.dofs[dof].kind == DofKind::Hinge;
                    let [low, high] = range.map(|x| if hinge { self.angles.written(x) } else { x });
                    exact(&[-high, -low])
                }
                _ => return,
            };
        self.edits.put(tag, "range", "range", &text);
    }

    /// The radii of a body's spheres.
    fn radii(&mut self, link: usize, tag: &Tag, said: &mut [bool]) {
        let geoms: Vec<&Tag> = tag.all("geom").collect();
        for (k, geom) in geoms.iter().enumerate() {
            let name = match geom.get("name") {
                Some(name) => name.to_string(),
                None => surface_name(&self.file.links[link].name, k, geoms.len()),
            };
            let surface = self.file.surface(&name).map(|surface| &self.file.surfaces[surface]);
            let Some((on, Form::Sphere(q))) = surface.map(|surface| (surface.link, &surface.form)) else {
                continue;
            };
            let old = geom.numbers("size");
            let radius = self.file.quantities[*q].nominal.number();
            // Geoms without names may be counted otherwise where something makes others.
            if on != link || old.first().is_some_and(|old| (old - radius).abs() > ROUNDING) {
                continue;
            }
            said[*q] = true;
            if self.changed(*q) {
                let mut new = old.clone();
                new.truncate(3);
                new.splice(..new.len().min(1), [self.number(*q)]);
                self.edits.set(geom, &[Change::of("size", old, new)]);
            }
        }
    }

    /// How joints follow others.
    fn equalities(&mut self, source: &Source) {
        let nominal = self.file.nominal();
        let entries: Vec<&Tag> = source
            .root
            .all("equality")
            .flat_map(|tag| tag.all("joint"))
            .filter(|tag| source.is_own(tag))
            .collect();
        let followers: Vec<usize> = (0..self.file.dofs.len()).filter(|dof| self.follows(*dof)).collect();
        for dof in followers {
            let name = &self.file.dofs[dof].name;
            let entry = entries.iter().find(|entry| entry.get("joint1") == Some(name));
            let leader = entry.and_then(|entry| entry.get("joint2")).and_then(|name| self.file.dof(name));
            let (Some(entry), Some(leader)) = (entry, leader) else {
                if self.line(dof, self.values) != self.line(dof, &nominal) {
                    self.unsaid.push(format!("{name}.gain, {name}.offset"));
                }
                continue;
            };
            let coefficients = |values: &[Value]| {
                let ([slope, constant], [by, from]) = (self.line(dof, values), self.line(leader, values));
                [constant - slope / by * from, slope / by]
            };
            let (old, new) = (coefficients(&nominal), coefficients(self.values));
            if old != new {
                let given = if entry.has("polycoef") { entry.numbers("polycoef") } else { vec![0.0, 1.0] };
                let new = new.into_iter().chain(given.iter().copied().skip(2)).collect::<Vec<_>>();
                self.edits.set(entry, &[Change::of("polycoef", given, new)]);
            }
        }
    }

    /// How far a joint is from its reference by what is read: the slope and the constant of a straight line.
    fn line(&self, dof: usize, values: &[Value]) -> [f64; 2] {
        let Some(q) = self.file.dofs[dof].quantities else { return [1.0, 0.0] };
        let [sign, gain, offset] = [q.sign, q.gain, q.offset].map(|quantity| values[quantity].number());
        if self.follows(dof) { [sign * gain, offset] } else { [1.0, sign * offset] }
    }

    /// Links that are not of the file, where their pose was to be found: bodies in those that they are on.
    fn added(&mut self, bodies: &Bodies) {
        let rest = self.robot.zero_posture();
        let posed = Posed::new(self.robot, self.values, &rest);
        let count = self.file.links.len();
        for (index, link) in self.robot.links.iter().enumerate().skip(count) {
            if !is_to_be_found(self.robot, index) {
                continue;
            }
            let mut path = vec![index];
            let mut on = link.parent;
            while on >= count {
                path.insert(0, on);
                on = self.robot.links[on].parent;
            }
            let pose = posed.frame(&path);
            if pose == Frame::identity() {
                continue;
            }
            let Some((_, tag)) = bodies.links.iter().find(|(link, _)| *link == on) else {
                self.unsaid.push(link.name.clone());
                continue;
            };
            let name = format!("body name=\"{}\"", escape(&link.name));
            let zero = [0.0; 3];
            let place = Change::of("pos", zero, pose.origin.as_slice());
            let body = new_element(&name, &[place, quaternion(&pose.rotation)]);
            self.edits.add(tag, &body, false);
        }
    }
}

/// A rotation as a quaternion w x y z.
fn quaternion(turn: &nalgebra::Matrix3<f64>) -> Change {
    let turn = UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(*turn));
    Change::of("quat", [], [turn.w, turn.i, turn.j, turn.k])
}
