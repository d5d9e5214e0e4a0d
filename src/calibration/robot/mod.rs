//! A robot as it is calibrated: links in a tree, and named quantities that say where each is on its parent.
//!
//! The pose of a link on its parent is a product of [`Element`]s from the parent's side on. Whatever may be unknown is a
//! [`Quantity`]: joints' positions and axes, Denavit and Hartenberg's lengths and twists, what an encoder reads
//! (`q_true = sign · gain · q + offset + compliance · torque`), radii of spheres. A skin that is mounted nobody knows how,
//! a tool's point and a receptor are links of their own, carried by elements that nothing moves.

mod naming;
mod pose;
mod quantity;

use nalgebra::Vector3;

pub use pose::{Mover, Posed};
pub use quantity::{Knowledge, Quantity, Unit, Value};

use crate::creature::DofKind;
use crate::geometry::{Frame, Shape};

/// One factor of a link's pose on its parent.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Element {
    /// What never changes.
    Fixed(Frame),
    /// A shift by a position.
    Shift(usize),
    /// A turn by an orientation.
    Turn(usize),
    /// A shift along a coordinate axis (0 is x) by a number, metres.
    ShiftAlong(usize, usize),
    /// A turn about a coordinate axis by a number, radians.
    TurnAbout(usize, usize),
    /// What a degree of freedom does.
    Dof(usize),
}

/// A link: a rigid part, or a place on one.
#[derive(Clone, Debug, PartialEq)]
pub struct Link {
    /// Its name.
    pub name: String,
    /// The link that it is on, an index; the root's own.
    pub parent: usize,
    /// `X_PL`, from the parent's side on; none for the root.
    pub elements: Vec<Element>,
}

/// A degree of freedom, and what its encoder reads.
#[derive(Clone, Debug, PartialEq)]
pub struct RobotDof {
    /// What a log calls it.
    pub name: String,
    /// Hinge, slide or ball.
    pub kind: DofKind,
    /// Least and greatest coordinate, radians or metres.
    pub range: [f64; 2],
    /// Where its coordinates begin in a posture.
    pub coordinate: usize,
    /// The quantities of its axis and of its encoder; a ball has none.
    pub quantities: Option<DofQuantities>,
}

/// Indices of the quantities of a hinge or slide.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct DofQuantities {
    /// The axis, in the frame in which it turns.
    pub axis: usize,
    /// Which way the encoder counts: 1 or −1.
    pub sign: usize,
    /// Turns for each turn that is read.
    pub gain: usize,
    /// Where it is when the encoder reads zero.
    pub offset: usize,
    /// How far it gives way to a torque, radians a newton metre.
    pub compliance: usize,
}

/// A surface that may touch: a shape on a link, or a plane.
#[derive(Clone, Debug, PartialEq)]
pub struct RobotSurface {
    /// Its name.
    pub name: String,
    /// The link that it is on.
    pub link: usize,
    /// Its pose on the link.
    pub pose: Frame,
    /// What it is.
    pub form: Form,
}

/// What a surface is.
#[derive(Clone, Debug, PartialEq)]
pub enum Form {
    /// A sphere whose radius is a quantity.
    Sphere(usize),
    /// The half of space below its own x and y axes.
    Plane,
    /// Any other shape.
    Solid(Shape),
}

/// A mass on a link, which weighs on the joints below it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LinkMass {
    /// The link.
    pub link: usize,
    /// Kilograms.
    pub mass: f64,
    /// Its centre in the link's frame, metres.
    pub centre: Vector3<f64>,
}

/// A robot as it is calibrated.
#[derive(Clone, Debug, PartialEq)]
pub struct Robot {
    /// Its name.
    pub name: String,
    /// Its links, the root first and every one after the one that it is on.
    pub links: Vec<Link>,
    /// Its degrees of freedom, in the order of a posture's coordinates.
    pub dofs: Vec<RobotDof>,
    /// All that may be unknown of it.
    pub quantities: Vec<Quantity>,
    /// Its surfaces.
    pub surfaces: Vec<RobotSurface>,
    /// What its links weigh.
    pub masses: Vec<LinkMass>,
    /// The acceleration by which masses weigh, in the root's frame, m/s².
    pub gravity: Vector3<f64>,
}

/// How the names of mounts end.
pub const MOUNT: &str = ".mount";

/// The acceleration of free fall where the root stands upright.
pub const GRAVITY: [f64; 3] = [0.0, 0.0, -9.81];

impl Robot {
    /// A robot of a root alone.
    pub fn new(name: impl Into<String>, root: impl Into<String>) -> Robot {
        Robot {
            name: name.into(),
            links: vec![Link { name: root.into(), parent: 0, elements: Vec::new() }],
            dofs: Vec::new(),
            quantities: Vec::new(),
            surfaces: Vec::new(),
            masses: Vec::new(),
            gravity: Vector3::from(GRAVITY),
        }
    }

    /// Adds a quantity of which everything is known; its index.
    pub fn add_quantity(&mut self, name: impl Into<String>, unit: Unit, nominal: Value) -> usize {
        self.quantities.push(Quantity { name: name.into(), unit, nominal, knowledge: [Knowledge::Known; 3] });
        self.quantities.len() - 1
    }

    /// Adds a hinge or slide with an axis and an encoder; its index. The quantities are called after the degree of freedom.
    pub fn add_dof(&mut self, name: &str, kind: DofKind, range: [f64; 2], axis: Vector3<f64>) -> usize {
        let coordinate = self.coordinates();
        let (turning, compliance) = match kind {
            DofKind::Slide => (Unit::Metre, Unit::One),
            DofKind::Hinge | DofKind::Ball => (Unit::Radian, Unit::Compliance),
        };
        let mut add = |what: &str, unit, value| self.add_quantity(format!("{name}.{what}"), unit, value);
        let quantities = (kind != DofKind::Ball).then(|| DofQuantities {
            axis: add("axis", Unit::Radian, Value::Direction(axis)),
            sign: add("sign", Unit::One, Value::Number(1.0)),
            gain: add("gain", Unit::One, Value::Number(1.0)),
            offset: add("offset", turning, Value::Number(0.0)),
            compliance: add("compliance", compliance, Value::Number(0.0)),
        });
        self.dofs.push(RobotDof { name: name.into(), kind, range, coordinate, quantities });
        self.dofs.len() - 1
    }

    /// Adds a link on another; its index.
    pub fn add_link(&mut self, name: impl Into<String>, parent: usize, elements: Vec<Element>) -> usize {
        self.links.push(Link { name: name.into(), parent, elements });
        self.links.len() - 1
    }

    /// Adds a link at rest on another, with a position and an orientation of its own, both of which may be unknown: the mount
    /// of a skin, a tool, a tracker.
    pub fn add_mount(&mut self, name: &str, parent: usize, pose: Frame) -> usize {
        let elements = self.add_pose(name, pose).to_vec();
        self.add_link(name, parent, elements)
    }

    /// Adds the position and the orientation of something, which may be unknown, as elements of a link.
    pub fn add_pose(&mut self, name: &str, pose: Frame) -> [Element; 2] {
        let (shift, turn) = (Value::Position(pose.origin), Value::Orientation(pose.rotation));
        let shift = self.add_quantity(format!("{name}.position"), Unit::Metre, shift);
        let turn = self.add_quantity(format!("{name}.orientation"), Unit::Radian, turn);
        [Element::Shift(shift), Element::Turn(turn)]
    }

    /// Gives every link so far a mount at rest, called after it, that its points are on; none where it has one, or is one.
    pub fn mount_all(&mut self) {
        for link in 0..self.links.len() {
            let name = format!("{}{MOUNT}", self.links[link].name);
            if self.link(&name).is_none() && !self.links[link].name.ends_with(MOUNT) {
                self.add_mount(&name, link, Frame::identity());
            }
        }
    }

    /// The link that a log's points on a link of this name are on: the link's mount, or a place itself.
    pub fn points_of(&self, name: &str) -> Option<usize> {
        self.link(&format!("{name}{MOUNT}")).or_else(|| self.link(name))
    }

    /// Adds a place on a link whose position may be unknown: a tool's point, a receptor.
    pub fn add_place(&mut self, name: &str, parent: usize, at: Vector3<f64>) -> usize {
        let shift = self.add_quantity(format!("{name}.position"), Unit::Metre, Value::Position(at));
        self.add_link(name, parent, vec![Element::Shift(shift)])
    }

    /// Adds a sphere about a link's origin, whose radius may be unknown; its index among the surfaces.
    pub fn add_sphere(&mut self, name: &str, link: usize, pose: Frame, radius: f64) -> usize {
        let radius = self.add_quantity(format!("{name}.radius"), Unit::Metre, Value::Number(radius));
        self.add_surface(name, link, pose, Form::Sphere(radius))
    }

    /// Adds a surface; its index.
    pub fn add_surface(&mut self, name: &str, link: usize, pose: Frame, form: Form) -> usize {
        self.surfaces.push(RobotSurface { name: name.into(), link, pose, form });
        self.surfaces.len() - 1
    }

    /// The link of a name.
    pub fn link(&self, name: &str) -> Option<usize> {
        self.links.iter().position(|link| link.name == name)
    }

    /// The surface of a name.
    pub fn surface(&self, name: &str) -> Option<usize> {
        self.surfaces.iter().position(|surface| surface.name == name)
    }

    /// The quantity of a name.
    pub fn quantity(&self, name: &str) -> Option<usize> {
        self.quantities.iter().position(|quantity| quantity.name == name)
    }

    /// The degree of freedom of a name.
    pub fn dof(&self, name: &str) -> Option<usize> {
        self.dofs.iter().position(|dof| dof.name == name)
    }

    /// How many coordinates a posture has.
    pub fn coordinates(&self) -> usize {
        self.dofs.iter().map(|dof| dof.coordinate + dof.kind.coordinates()).max().unwrap_or(0)
    }

    /// Hinges and slides, and the quantities of each.
    pub fn encoders(&self) -> impl Iterator<Item = (usize, DofQuantities)> {
        self.dofs.iter().enumerate().filter_map(|(dof, about)| Some((dof, about.quantities?)))
    }

    /// Degrees of freedom that have coordinates of their own: what mimics another has that one's.
    pub fn leaders(&self) -> impl Iterator<Item = &RobotDof> {
        (0..self.dofs.len()).filter(|dof| self.leads(*dof)).map(|dof| &self.dofs[dof])
    }

    /// Whether a degree of freedom has a coordinate of its own.
    pub fn leads(&self, dof: usize) -> bool {
        self.dofs[..dof].iter().all(|other| other.coordinate != self.dofs[dof].coordinate)
    }

    /// Whether a degree of freedom moves one of two links and not the other.
    pub fn is_between(&self, dof: usize, links: [usize; 2]) -> bool {
        let moves = |mut link: usize| {
            loop {
                let own = self.links.get(link)?;
                if own.elements.contains(&Element::Dof(dof)) {
                    return Some(true);
                }
                if own.parent == link {
                    return Some(false);
                }
                link = own.parent;
            }
        };
        moves(links[0]) != moves(links[1])
    }

    /// Whether a link is a place: a point that needs no coordinates.
    pub fn is_place(&self, link: usize) -> bool {
        matches!(self.links[link].elements.as_slice(), [Element::Shift(_)])
    }

    /// The posture in which all encoders read zero.
    pub fn zero_posture(&self) -> Vec<f64> {
        let mut posture = vec![0.0; self.coordinates()];
        for dof in self.dofs.iter().filter(|dof| dof.kind == DofKind::Ball) {
            posture[dof.coordinate] = 1.0;
        }
        posture
    }

    /// The robot of the same table of Denavit and Hartenberg's numbers by the other convention: θ and d after a and α, or before.
    /// `None` if it is of no such table.
    pub fn of_other_convention(&self) -> Option<Robot> {
        let mut other = self.clone();
        let of_table = |link: &&mut Link| {
            link.elements.len() == 5 && link.elements.iter().any(|e| matches!(e, Element::ShiftAlong(0, _)))
        };
        let mut found = false;
        for link in other.links.iter_mut().filter(of_table) {
            // What is along and about one axis goes in any order.
            let modified = matches!(link.elements[0], Element::TurnAbout(0, _));
            link.elements.rotate_left(if modified { 3 } else { 2 });
            found = true;
        }
        found.then_some(other)
    }

    /// All quantities at their nominal values.
    pub fn nominal(&self) -> Vec<Value> {
        self.quantities.iter().map(|quantity| quantity.nominal).collect()
    }
}
