//! Things that are put on a stage.

use nalgebra::Isometry3;

use crate::geometry::Shape;
use crate::mjcf_xml::{element, exact};

/// A thing of one shape that is put on a stage.
#[derive(Clone, Debug, PartialEq)]
pub struct Thing {
    /// Its name, which no other body of the stage has.
    pub name: String,
    /// Its shape; a hull's vertices are about its origin.
    pub shape: Shape,
    /// `X_WT`: where it is at first, in the world.
    pub pose: Isometry3<f64>,
    /// Whether it stays there whatever touches it.
    pub fixed: bool,
}

/// The body of a thing as MJCF, after the mesh that it is made of where it is one.
pub(super) fn described(thing: &Thing) -> Vec<xmltree::Element> {
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
    let mut elements = Vec::new();
    let made = match (&thing.shape, thing.shape.mjcf()) {
        (Shape::Hull(hull), _) => {
            let corners: Vec<f64> =
                hull.vertices().iter().flat_map(|corner| [corner.x, corner.y, corner.z]).collect();
            elements.push(element("mesh", &[("name", thing.name.clone()), ("vertex", exact(&corners))]));
            [("type", "mesh".into()), ("mesh", thing.name.clone())]
        }
        (_, Some((kind, size))) => [("type", kind.into()), ("size", exact(&size))],
        // A thing of which no shape is known stands in as a small ball.
        (_, None) => [("type", "sphere".into()), ("size", "0.01".into())],
    };
    let rest = [
        ("name", thing.name.clone()),
        ("density", "300".into()),
        ("contype", "1".into()),
        ("conaffinity", "1".into()),
        ("condim", "4".into()),
        ("friction", "0.8 0.01 0.001".into()),
    ];
    let geom: Vec<(&str, String)> = made.into_iter().chain(rest).collect();
    body.children.push(xmltree::XMLNode::Element(element("geom", &geom)));
    elements.push(body);
    elements
}
