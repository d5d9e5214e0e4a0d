//! What calibration found, written into the MJCF or URDF file that the robot is from.
//!
//! MJCF has a word for an encoder's offset: the joint's `ref` with the other sign, for MuJoCo turns the joint by `qpos − ref`.
//! URDF has none: there it goes into the joint's origin, for `X · R(a, q + o) = X · R(a, o) · R(a, q)`. An encoder that counts
//! the other way turns the axis round, and with it the limits. What follows another joint has words in both: `polycoef` of an
//! equality, `<mimic multiplier offset>`.

use std::path::Path;

use nalgebra::{Matrix3, Rotation3, Unit, Vector3};

use super::urdf::shapes;
use super::{Written, surface_name, unsaid_of_encoder};
use crate::calibration::robot::{Element, Form, Posed, Robot, RobotDof, Value};
use crate::creature::DofKind;
use crate::geometry::Frame;
use crate::model_files::{
    Angles, Element as Tag, ORIENTATIONS, Origin, Refused, Source, UrdfTree, element, exact, rewritten,
};

/// A pose or a size that a file says is the one that was read if it is no farther from it, metres and radians.
const ROUNDING: f64 = 1e-9;
/// Roll, pitch and yaw that differ by less are the same but for rounding, radians.
const TURN_ROUNDING: f64 = 1e-14;
/// Cosine of a pitch at which roll and yaw turn about the same axis, but for rounding.
const UPRIGHT: f64 = 1e-12;
/// Elements in a body of MJCF that make others, or put them elsewhere.
const MAKERS: [&str; 5] = ["frame", "replicate", "composite", "flexcomp", "attach"];

/// The file `original`, which `robot` was read from, with `values` in the place of the numbers that differ from them, and every
/// other byte as it was. `own` is how many links and quantities the robot has from the file: links that were added since, and
/// whose pose was to be found, are added to the file.
///
/// `path` is what the file is called in messages.
///
/// # Errors
/// Where `original` is neither MJCF nor URDF.
pub fn write_xml(
    path: &Path,
    original: &[u8],
    robot: &Robot,
    own: [usize; 2],
    values: &[Value],
) -> Result<Written, Refused> {
    let source = Source::of_bytes(path, original)?;
    let is_urdf = source.root.name == "robot";
    let places = if is_urdf { places_of_urdf(&source, robot)? } else { places_of_mjcf(&source, robot) };
    let mut writer = Writer {
        source: &source,
        robot,
        nominal: robot.nominal(),
        values,
        angles: (!is_urdf).then(|| Angles::of(&source.root)),
        root: source.root.clone(),
        said: vec![false; own[1]],
    };
    places.iter().for_each(|place| writer.place(place));
    let mut unsaid = writer.followers(&places);
    // What has no place in either format is told apart.
    let encoders = robot.dofs.iter().filter_map(|dof| dof.quantities);
    encoders.for_each(|q| [q.gain, q.compliance].into_iter().for_each(|q| writer.said[q] = true));
    let others = (0..own[1]).filter(|q| !writer.said[*q] && writer.nominal[*q] != values[*q]);
    unsaid.extend(others.map(|q| robot.quantities[q].name.clone()));
    unsaid.extend(writer.added(&places, own[0]));
    let format = if is_urdf { "URDF" } else { "MJCF" };
    let mut left_out: Vec<String> =
        (0..robot.dofs.len()).flat_map(|dof| unsaid_of_encoder(robot, values, dof, format)).collect();
    if !unsaid.is_empty() {
        left_out.push(format!(
            "the new values of {} cannot be written into this file, because they come from an included file, a \
             <frame> or generated bodies: enter them there by hand, from quantities.csv",
            unsaid.join(", ")
        ));
    }
    Ok(Written { bytes: rewritten(path, original, &source.root, &writer.root), left_out })
}

/// Where a file says what there is of a link.
struct Place<'a> {
    link: usize,
    /// The link or body itself, with its geometry.
    tag: &'a Tag,
    /// What says its pose: a joint of URDF, a body of MJCF.
    posed: Option<&'a Tag>,
    /// The degrees of freedom that move it, and their joints.
    joints: Vec<(usize, &'a Tag)>,
}

fn places_of_urdf<'a>(source: &'a Source, robot: &Robot) -> Result<Vec<Place<'a>>, Refused> {
    let tree = UrdfTree::new(source)?;
    let place = |(name, tag): &(&'a str, &'a Tag)| {
        let joint = tree.joints.iter().find(|joint| joint.child == *name);
        let moved = joint.and_then(|joint| Some((robot.dof(joint.name)?, joint.element)));
        let posed = joint.map(|joint| joint.element);
        Some(Place { link: robot.link(name)?, tag, posed, joints: moved.into_iter().collect() })
    };
    Ok(tree.links.iter().filter_map(place).collect())
}

/// The bodies that stand in the file itself as they are. Those without names are called by number, as MuJoCo counts them, where
/// nothing makes others.
fn places_of_mjcf<'a>(source: &'a Source, robot: &Robot) -> Vec<Place<'a>> {
    fn inside<'a>(parent: &'a Tag, bodies: &mut Vec<&'a Tag>) {
        for body in parent.all("body") {
            bodies.push(body);
            inside(body, bodies);
        }
    }
    let counted = source.root.descendants().all(|tag| !MAKERS.contains(&tag.name.as_str()));
    let name = |tag: &Tag, kind: &str, number: usize| {
        let own = tag.get("name").map(str::to_string);
        own.or_else(|| counted.then(|| format!("{kind}{number}")))
    };
    let mut bodies = Vec::new();
    source.root.all("worldbody").for_each(|world| inside(world, &mut bodies));
    let worlds = source.root.all("worldbody").filter_map(|tag| Some((robot.link("world")?, tag)));
    let place = |(link, tag)| Place { link, tag, posed: None, joints: Vec::new() };
    let mut places: Vec<Place> = worlds.map(place).collect();
    let mut number = 0;
    for (k, body) in bodies.into_iter().enumerate() {
        let mut joints = Vec::new();
        for joint in body.children.iter().filter(|tag| matches!(tag.name.as_str(), "joint" | "freejoint")) {
            let dof = name(joint, "joint", number).and_then(|name| robot.dof(&name));
            joints.extend(dof.filter(|_| source.is_own(joint)).map(|dof| (dof, joint)));
            number += 1;
        }
        let link = name(body, "body", k + 1).and_then(|name| robot.link(&name));
        places.extend(link.map(|link| Place { link, tag: body, posed: Some(body), joints }));
    }
    places.retain(|place| source.is_own(place.tag));
    places
}

struct Writer<'a> {
    source: &'a Source,
    robot: &'a Robot,
    /// The file's own values.
    nominal: Vec<Value>,
    values: &'a [Value],
    /// How MJCF gives its angles; none of URDF.
    angles: Option<Angles>,
    /// The file's tree with the new numbers.
    root: Tag,
    /// Per quantity of the file's own whether it was found there.
    said: Vec<bool>,
}

impl Writer<'_> {
    fn number(&self, quantity: usize) -> f64 {
        self.values[quantity].number()
    }

    /// The quantities of a link, of the joints that move it, and of its geometry.
    fn place(&mut self, place: &Place) {
        let elements = self.robot.links[place.link].elements.as_slice();
        let (Some(tag), [Element::Shift(shift), Element::Turn(turn), ..]) = (place.posed, elements) else {
            return self.radii(place);
        };
        let frame = |values: &[Value]| match values[*turn] {
            Value::Orientation(rotation) => Frame { rotation, origin: values[*shift].vector() },
            _ => Frame::identity(),
        };
        let (old, mut new) = (frame(&self.nominal), frame(self.values));
        if let Some(angles) = &self.angles {
            let said = Frame::from(angles.pose(tag));
            let turned = Value::Orientation(old.rotation).distance(&Value::Orientation(said.rotation));
            // It is elsewhere where something else puts it.
            if (old.origin - said.origin).norm() > ROUNDING || turned > ROUNDING {
                return;
            }
        }
        [shift, turn].into_iter().for_each(|q| self.said[*q] = true);
        for (dof, joint) in place.joints.iter().filter(|(dof, _)| elements.contains(&Element::Dof(*dof))) {
            self.joint(joint, *dof, &mut new);
        }
        self.pose(tag, &old, &new);
        self.radii(place);
    }

    /// An element, to be changed.
    fn edited(&mut self, tag: &Tag) -> &mut Tag {
        let place = tag.place.as_ref().expect("it is of a file");
        self.root.at(place).expect("it is of this tree")
    }

    /// Writes a pose.
    fn pose(&mut self, tag: &Tag, old: &Frame, new: &Frame) {
        let (moved, turned) = (new.origin != old.origin, new.rotation != old.rotation);
        if !moved && !turned {
            return;
        }
        let is_urdf = self.angles.is_none();
        let edited = self.edited(tag);
        if is_urdf {
            let said = Origin::of(tag);
            let mut to = if turned { turns(&new.rotation, said.turns) } else { said.turns };
            for (to, said) in to.iter_mut().zip(said.turns) {
                if (*to - said).abs() <= TURN_ROUNDING {
                    *to = said;
                }
            }
            let origin = first_child(edited, "origin");
            for (name, changed, numbers) in
                [("xyz", moved, new.origin.as_slice()), ("rpy", to != said.turns, &to)]
            {
                if changed {
                    origin.set(name, exact(numbers));
                }
            }
            return;
        }
        if moved {
            edited.set("pos", exact(&new.origin));
        }
        if turned {
            for (own, _) in edited.attributes.iter_mut().filter(|(own, _)| ORIENTATIONS.contains(&&**own)) {
                *own = "quat".into();
            }
            edited.set("quat", exact(&new.wxyz()));
        }
    }

    /// A joint's axis, and where its coordinate begins, which in URDF moves its pose.
    fn joint(&mut self, tag: &Tag, dof: usize, pose: &mut Frame) {
        let about = &self.robot.dofs[dof];
        let Some(q) = about.quantities else { return };
        [q.axis, q.sign, q.offset].into_iter().for_each(|q| self.said[q] = true);
        let (was, mut axis) = (self.nominal[q.axis].vector(), self.values[q.axis].vector());
        if self.robot.leads(dof) {
            let [sign, offset] = [q.sign, q.offset].map(|q| self.number(q));
            match (&self.angles, about.kind) {
                (Some(angles), kind) => {
                    let written = |x: f64| if kind == DofKind::Hinge { angles.written(x) } else { x };
                    let [before, now] = [self.nominal[q.offset].number(), sign * offset].map(|x| written(-x));
                    if before != now {
                        self.edited(tag).set("ref", exact(&[now]));
                    }
                }
                (None, _) if offset == 0.0 => {}
                (None, DofKind::Slide) => pose.origin += pose.rotation * axis * offset,
                (None, DofKind::Hinge | DofKind::Ball) => {
                    pose.rotation *= Rotation3::from_axis_angle(&Unit::new_normalize(axis), offset).matrix();
                }
            }
            if sign < 0.0 {
                axis = -axis;
                self.turn_limits_round(tag, dof);
            }
        }
        if axis != was {
            let is_urdf = self.angles.is_none();
            let joint = self.edited(tag);
            match is_urdf {
                true => first_child(joint, "axis").set("xyz", exact(&axis)),
                false => joint.set("axis", exact(&axis)),
            }
        }
    }

    /// The limits of an axis that points the other way: each is the other's negative. Without any they are even about `ref`.
    fn turn_limits_round(&mut self, joint: &Tag, dof: usize) {
        let RobotDof { range, kind, quantities, .. } = &self.robot.dofs[dof];
        let Some(angles) = &self.angles else {
            for (child, lower, upper) in
                [("limit", "lower", "upper"), ("safety_controller", "soft_lower_limit", "soft_upper_limit")]
            {
                let Some(limit) = joint.child(child) else { continue };
                // A limit that is not given is 0.
                for (name, other) in [(lower, upper), (upper, lower)] {
                    if limit.has(name) || limit.has(other) {
                        let opposite = -limit.number(other).unwrap_or_default();
                        self.edited(limit).set(name, exact(&[opposite]));
                    }
                }
            }
            return;
        };
        let at_zero = quantities.is_some_and(|q| self.nominal[q.offset].number() == 0.0);
        let written = |x: f64| if *kind == DofKind::Hinge { angles.written(x) } else { x };
        let limits = match joint.numbers("range").as_slice() {
            [low, high] => [-high, -low],
            // Those of a default class.
            _ if at_zero && range[0] + range[1] != 0.0 => [range[1], range[0]].map(|limit| written(-limit)),
            _ => return,
        };
        self.edited(joint).set("range", exact(&limits));
    }

    /// The radii of a link's spheres.
    fn radii(&mut self, place: &Place) {
        let link = &self.robot.links[place.link].name;
        let geoms: Vec<&Tag> = place.tag.all("geom").collect();
        let named = |(k, geom): (usize, &&'_ Tag)| {
            geom.get("name").map_or_else(|| surface_name(link, k, geoms.len()), str::to_string)
        };
        let spheres: Vec<(String, &Tag, &'static str)> = match self.angles {
            Some(_) => geoms.iter().enumerate().map(|(k, geom)| (named((k, geom)), *geom, "size")).collect(),
            None => {
                shapes(link, place.tag).into_iter().map(|(name, _, shape)| (name, shape, "radius")).collect()
            }
        };
        for (name, tag, attribute) in spheres {
            let surface = self.robot.surface(&name).map(|surface| &self.robot.surfaces[surface]);
            let Some(&Form::Sphere(q)) = surface.filter(|own| own.link == place.link).map(|own| &own.form)
            else {
                continue;
            };
            let old = tag.numbers(attribute);
            // Geoms without names may be counted otherwise where something makes others.
            let other = old.first().is_some_and(|old| (old - self.nominal[q].number()).abs() > ROUNDING);
            if other || !self.source.is_own(tag) {
                continue;
            }
            self.said[q] = true;
            if self.values[q] != self.nominal[q] {
                let new = exact([&self.number(q)].into_iter().chain(old.iter().take(3).skip(1)));
                self.edited(tag).set(attribute, new);
            }
        }
    }

    /// How joints follow others; the quantities of those of which the file itself does not say it.
    fn followers(&mut self, places: &[Place]) -> Vec<String> {
        let mut unsaid = Vec::new();
        let robot = self.robot;
        for (dof, about) in robot.dofs.iter().enumerate().filter(|(dof, _)| !robot.leads(*dof)) {
            let name = &about.name;
            let joint = places.iter().flat_map(|place| &place.joints).find(|(own, _)| *own == dof);
            let equalities = self.source.root.all("equality").flat_map(|tag| tag.all("joint"));
            let entry = match self.angles {
                Some(_) => equalities
                    .filter(|tag| self.source.is_own(tag))
                    .find(|tag| tag.get("joint1") == Some(name)),
                None => joint.and_then(|(_, joint)| joint.child("mimic")),
            };
            let leader =
                entry.and_then(|tag| tag.get(if self.angles.is_some() { "joint2" } else { "joint" }));
            let leader = leader.and_then(|leader| self.robot.dof(leader));
            // By the coordinate of the joint that the file names, which may follow another in its turn.
            let line = |values: &[Value]| {
                let ([slope, constant], [by, from]) =
                    (self.line(dof, values), leader.map_or([1.0, 0.0], |leader| self.line(leader, values)));
                [constant - slope / by * from, slope / by]
            };
            let (old, new) = (line(&self.nominal), line(self.values));
            match entry {
                _ if old == new || !new[1].is_finite() => {}
                None => unsaid.push(format!("{name}.gain, {name}.offset")),
                Some(entry) if self.angles.is_some() => {
                    let rest = entry.numbers("polycoef");
                    let new = exact(new.iter().chain(rest.iter().skip(2)));
                    self.edited(entry).set("polycoef", new);
                }
                Some(entry) => {
                    for (name, default, new) in [("multiplier", 1.0, new[1]), ("offset", 0.0, new[0])] {
                        if entry.number(name).unwrap_or(default) != new {
                            self.edited(entry).set(name, exact(&[new]));
                        }
                    }
                }
            }
        }
        unsaid
    }

    /// How far a joint is from where its file's words put it by what is read: the slope and the constant of a straight line.
    fn line(&self, dof: usize, values: &[Value]) -> [f64; 2] {
        let Some(q) = self.robot.dofs[dof].quantities else { return [1.0, 0.0] };
        let [sign, gain, offset] = [q.sign, q.gain, q.offset].map(|quantity| values[quantity].number());
        match self.robot.leads(dof) {
            // In URDF the offset is in the joint's pose.
            true => [1.0, if self.angles.is_some() { sign * offset } else { 0.0 }],
            false => [sign * gain, offset],
        }
    }

    /// Adds links that are not of the file, where their pose was to be found; those that it has no place for.
    fn added(&mut self, places: &[Place], count: usize) -> Vec<String> {
        let rest = self.robot.zero_posture();
        let posed = Posed::new(self.robot, self.values, &rest);
        let mut unsaid = Vec::new();
        for (index, link) in self.robot.links.iter().enumerate().skip(count) {
            let mut path = vec![index];
            let mut on = link.parent;
            while on >= count {
                path.insert(0, on);
                on = self.robot.links[on].parent;
            }
            let pose = posed.frame(&path);
            if pose == Frame::identity() || !is_to_be_found(self.robot, index) {
                continue;
            }
            let Some(place) = places.iter().find(|place| place.link == on) else {
                unsaid.push(link.name.clone());
                continue;
            };
            let name = ("name", link.name.clone());
            if self.angles.is_some() {
                let pose = [("pos", exact(&pose.origin)), ("quat", exact(&pose.wxyz()))];
                let body = element("body", &[[name].as_slice(), &pose].concat());
                self.edited(place.tag).children.push(body);
                continue;
            }
            let turns = exact(&turns(&pose.rotation, [0.0; 3]));
            let joint = [("name", format!("{}.joint", link.name)), ("type", "fixed".into())];
            let parts = vec![
                element("parent", &[("link", self.robot.links[on].name.clone())]),
                element("child", &[("link", link.name.clone())]),
                element("origin", &[("xyz", exact(&pose.origin)), ("rpy", turns)]),
            ];
            let joint = Tag { children: parts, ..element("joint", &joint) };
            self.root.children.extend([element("link", &[name]), joint]);
        }
        unsaid
    }
}

/// The child of a name, which becomes the first where there is none.
fn first_child<'t>(tag: &'t mut Tag, name: &str) -> &'t mut Tag {
    let found = tag.children.iter().position(|child| child.name == name);
    if found.is_none() {
        tag.children.insert(0, Tag::new(name));
    }
    &mut tag.children[found.unwrap_or(0)]
}

/// Whether a link's pose at rest was to be found.
fn is_to_be_found(robot: &Robot, link: usize) -> bool {
    robot.links[link].elements.iter().any(|element| match element {
        Element::Shift(q) | Element::Turn(q) | Element::ShiftAlong(_, q) | Element::TurnAbout(_, q) => {
            robot.quantities[*q].is_open()
        }
        Element::Fixed(_) | Element::Dof(_) => false,
    })
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
