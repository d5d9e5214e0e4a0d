//! Things that are put on a stage.

use nalgebra::Isometry3;

use crate::geometry::Shape;
use crate::mjcf_xml::{element, exact};

/// A thing of one shape that is put on a stage.
#[derive(Clone, Debug, PartialEq)]
pub struct Thing {
    /// Its name, which no other body of the stage has.
    pub name: String,
    /// Its shape; no mesh.
    pub shape: Shape,
    /// `X_WT`: where it is at first, in the world.
    pub pose: Isometry3<f64>,
    /// Whether it stays there whatever touches it.
    pub fixed: bool,
}

/// The body of a thing as MJCF.
pub(super) fn described(thing: &Thing) -> xmltree::Element {
    let translation = thing.pose.translation.vector;
    let turn = thing.pose.rotation.quaternion();
    let pose = [
        ("name", thing.name.clone()),
        ("pos", exact(translation.as_slice())),
        ("quat", exact(&[turn.w, turn.i, turn.j, turn.k])),
    ];
    let mut body = element("body", &pose);
    if !thing.fixed {
        body.children.push(xmltree::XMLNode::Element(element("freejoint", &[])));
    }
    // A thing without a primitive shape stands in as a small ball.
    let primitive = thing.shape.mjcf().filter(|(_, size)| !size.is_empty());
    let (kind, size) = primitive.unwrap_or(("sphere", vec![0.01]));
    let geom = [
        ("name", thing.name.clone()),
        ("type", kind.into()),
        ("size", exact(&size)),
        ("density", "300".into()),
        ("contype", "1".into()),
        ("conaffinity", "1".into()),
        ("condim", "4".into()),
        ("friction", "0.8 0.01 0.001".into()),
    ];
    body.children.push(xmltree::XMLNode::Element(element("geom", &geom)));
    body
}
