//! Where a robot's links are in a posture, and how they move with what may be unknown.

use nalgebra::{Matrix3, Vector3};

use super::{DofQuantities, Element, Robot, Value};
use crate::creature::{DofKind, ball};
use crate::geometry::{Frame, tangent_basis};
use crate::kinematics::{Twist, rotation, ways_apart};

/// Rounds in which gravity's torques and the joints that give way to them settle.
const SAGGING_ROUNDS: usize = 4;

/// What moves a link.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Mover {
    /// A degree of freedom as it is.
    Dof(usize),
    /// A parameter of a quantity: which, and which of its parameters.
    Parameter(usize, usize),
}

/// A robot at values of its quantities, in a posture as its encoders read it.
pub struct Posed<'a> {
    /// The robot.
    pub robot: &'a Robot,
    /// The values of its quantities.
    pub values: &'a [Value],
    posture: &'a [f64],
    /// Gravity's torque on each degree of freedom, newton metres or newtons; empty where nothing gives way.
    torques: Vec<f64>,
}

impl<'a> Posed<'a> {
    /// `posture` holds the encoders' readings: radians, metres of slides, a ball's unit quaternion w x y z.
    pub fn new(robot: &'a Robot, values: &'a [Value], posture: &'a [f64]) -> Posed<'a> {
        let mut posed = Posed { robot, values, posture, torques: Vec::new() };
        let gives_way = |(_, own): (usize, DofQuantities)| {
            values[own.compliance].number() != 0.0 || robot.quantities[own.compliance].is_open()
        };
        if robot.encoders().any(gives_way) {
            posed.torques = vec![0.0; robot.dofs.len()];
            for _ in 0..SAGGING_ROUNDS {
                posed.torques = posed.gravity_torques();
            }
        }
        posed
    }

    /// A hinge's angle or a slide's distance as it is: what its encoder reads put right.
    pub fn actual(&self, dof: usize) -> f64 {
        let read = self.posture[self.robot.dofs[dof].coordinate];
        let Some(q) = self.robot.dofs[dof].quantities else { return read };
        let number = |quantity: usize| self.values[quantity].number();
        let torque = self.torques.get(dof).copied().unwrap_or(0.0);
        number(q.sign) * number(q.gain) * read + number(q.offset) + number(q.compliance) * torque
    }

    /// Gravity's torque on every degree of freedom, as the joints are with the torques so far.
    fn gravity_torques(&self) -> Vec<f64> {
        let robot = self.robot;
        let mut torques = vec![0.0; robot.dofs.len()];
        for mass in &robot.masses {
            let [_, path] = self.paths([0, mass.link]);
            let mut twists = Vec::new();
            let frame = self.walk(&path, |mover, twist| twists.push((mover, twist)));
            let centre = frame.point(&mass.centre);
            for (mover, twist) in twists {
                if let Mover::Dof(dof) = mover {
                    torques[dof] += mass.mass * robot.gravity.dot(&twist.at(&centre));
                }
            }
        }
        torques
    }

    /// The paths to two links from the last link that is on both ways.
    pub fn paths(&self, links: [usize; 2]) -> [Vec<usize>; 2] {
        ways_apart(|link| self.robot.links[link].parent, links).1
    }

    /// `X_CL` at the end of a path, C where it begins.
    pub fn frame(&self, path: &[usize]) -> Frame {
        self.walk(path, |_, _| {})
    }

    /// `X_RL` of every link in the root's frame.
    pub fn frames(&self) -> Vec<Frame> {
        let mut frames: Vec<Frame> = vec![Frame::identity()];
        for (link, about) in self.robot.links.iter().enumerate().skip(1) {
            frames.push(frames[about.parent] * self.frame(&[link]));
        }
        frames
    }

    /// The same as [`Posed::frame`], with the twist in C by which the end moves with each degree of freedom as it is, and with each
    /// parameter of quantities on the way.
    pub fn walk(&self, path: &[usize], mut on: impl FnMut(Mover, Twist)) -> Frame {
        let mut frame = Frame::identity();
        for element in path.iter().flat_map(|link| &self.robot.links[*link].elements) {
            self.pass(element, &mut frame, &mut on);
        }
        frame
    }

    fn pass(&self, element: &Element, frame: &mut Frame, on: &mut impl FnMut(Mover, Twist)) {
        let mut on_parameter = |quantity, component, twist| on(Mover::Parameter(quantity, component), twist);
        let column = |frame: &Frame, i: usize| -> Vector3<f64> { frame.rotation.column(i).into() };
        match *element {
            Element::Fixed(pose) => *frame = *frame * pose,
            Element::Shift(quantity) => {
                for i in 0..3 {
                    on_parameter(quantity, i, Twist::shifting(column(frame, i)));
                }
                frame.origin = frame.point(&self.values[quantity].vector());
            }
            Element::Turn(quantity) => {
                for i in 0..3 {
                    on_parameter(quantity, i, Twist::turning(column(frame, i), &frame.origin));
                }
                if let Value::Orientation(turn) = &self.values[quantity] {
                    frame.rotation *= turn;
                }
            }
            Element::ShiftAlong(axis, quantity) => {
                on_parameter(quantity, 0, Twist::shifting(column(frame, axis)));
                frame.origin += column(frame, axis) * self.values[quantity].number();
            }
            Element::TurnAbout(axis, quantity) => {
                on_parameter(quantity, 0, Twist::turning(column(frame, axis), &frame.origin));
                let angle = self.values[quantity].number();
                frame.rotation *= turn(&Vector3::ith(axis, 1.0), angle);
            }
            Element::Dof(dof) => self.pass_dof(dof, frame, on),
        }
    }

    fn pass_dof(&self, dof: usize, frame: &mut Frame, on: &mut impl FnMut(Mover, Twist)) {
        let about = &self.robot.dofs[dof];
        let Some(q) = about.quantities else {
            let coordinates = &self.posture[about.coordinate..about.coordinate + 4];
            frame.rotation *= ball(coordinates).to_rotation_matrix().into_inner();
            return;
        };
        let axis = self.values[q.axis].vector();
        let basis = tangent_basis(&axis);
        let amount = self.actual(dof);
        let read = self.posture[about.coordinate];
        let number = |quantity: usize| self.values[quantity].number();
        let before = *frame;
        let mut on_parameter = |quantity, component, twist| on(Mover::Parameter(quantity, component), twist);
        let moved = match about.kind {
            DofKind::Slide => {
                frame.origin += before.direction(&axis) * amount;
                for i in 0..2 {
                    let aside = before.direction(&basis.column(i).into()) * amount;
                    on_parameter(q.axis, i, Twist::shifting(aside));
                }
                Twist::shifting(before.direction(&axis))
            }
            DofKind::Hinge | DofKind::Ball => {
                frame.rotation *= turn(&axis, amount);
                for i in 0..2 {
                    // An axis that turns by ω takes its hinge along: E R E⁻¹ moves as ω before it, less ω behind it.
                    let omega: Vector3<f64> = axis.cross(&basis.column(i).into_owned());
                    let angular = before.direction(&omega) - frame.direction(&omega);
                    on_parameter(q.axis, i, Twist::turning(angular, &before.origin));
                }
                Twist::turning(before.direction(&axis), &before.origin)
            }
        };
        on_parameter(q.offset, 0, moved);
        on_parameter(q.gain, 0, moved.scaled(number(q.sign) * read));
        let torque = self.torques.get(dof).copied().unwrap_or(0.0);
        on_parameter(q.compliance, 0, moved.scaled(torque));
        on(Mover::Dof(dof), moved);
    }
}

/// The rotation about a unit axis by an angle, radians.
fn turn(axis: &Vector3<f64>, angle: f64) -> Matrix3<f64> {
    let (sine, cosine) = angle.sin_cos();
    rotation(axis, sine, 1.0 - cosine)
}
