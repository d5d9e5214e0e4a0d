//! A robot of a creature and what its maker says of its joints.

use nalgebra::Vector3;

use super::{Element, Robot, Unit, Value};
use crate::creature::Creature;
use crate::geometry::Frame;

/// Where a joint is by its maker's account.
#[derive(Clone, Debug, PartialEq)]
pub struct NominalJoint {
    /// `l_P`, in the parent limb's frame, metres.
    pub position: Vector3<f64>,
    /// `a_P` of every degree of freedom, unit vectors in the parent limb's frame; anything for a ball.
    pub axes: Vec<Vector3<f64>>,
}

impl Robot {
    /// A robot with a creature's limbs and joints at their nominal places, one for each joint. A limb's frame has the joint that
    /// carries it for its origin and, with all joints at zero, its parent's orientation; its points are on a mount of its own.
    pub fn of_creature(creature: &Creature, nominal: &[NominalJoint]) -> Robot {
        let limbs = creature.limbs();
        let mut robot = Robot::new(creature.name(), limbs[0].clone());
        for ((joint, at), limb) in creature.joints().iter().zip(nominal).zip(&limbs[1..]) {
            let shift = robot.add_quantity(
                format!("{}.position", joint.name),
                Unit::Metre,
                Value::Position(at.position),
            );
            let mut elements = vec![Element::Shift(shift)];
            for (dof, axis) in joint.dofs.iter().zip(&at.axes) {
                elements.push(Element::Dof(robot.add_dof(&dof.name, dof.kind, dof.range, *axis)));
            }
            robot.add_link(limb.clone(), joint.parent, elements);
        }
        robot.mount_all();
        robot
    }

    /// Gives every link so far a mount at rest, called after it, that its points are on; none where it has one, or is one.
    pub fn mount_all(&mut self) {
        for link in 0..self.links.len() {
            let name = mount_name(&self.links[link].name);
            if self.link(&name).is_none() && !self.links[link].name.ends_with(MOUNT) {
                self.add_mount(&name, link, Frame::identity());
            }
        }
    }

    /// The link that a log's points on a link of this name are on: the link's mount, or a place itself.
    pub fn points_of(&self, name: &str) -> Option<usize> {
        self.link(&mount_name(name)).or_else(|| self.link(name))
    }
}

/// How the names of mounts end.
const MOUNT: &str = ".mount";

/// What the mount of a link is called.
fn mount_name(link: &str) -> String {
    format!("{link}{MOUNT}")
}
