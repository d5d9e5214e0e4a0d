//! Things that are put on a stage.

use nalgebra::Isometry3;

use crate::geometry::{Shape, wxyz};
use crate::model_files::{Element, element, exact};

/// Density of what a thing is made of where its mass is not said, kilograms a cubic metre: light wood.
const DENSITY: f64 = 300.0;
/// Coefficient of friction of a thing where it is not said.
const FRICTION: f64 = 0.8;
/// A contact resists turning about its normal as by friction over a metre's so-manieth part, a soft patch's radius, and
/// rolling a tenth of that.
const TURNING: f64 = 80.0;
const ROLLING: f64 = 800.0;

/// A thing of one shape that is put on a stage.
#[derive(Clone, Debug, PartialEq)]
pub struct Thing {
    /// Its name, which no other body of the stage has.
    pub name: String,
    /// Its shape; a hull's vertices are about its origin, and a mesh without a hull stands in as a small ball.
    pub shape: Shape,
    /// `X_WT`: where it is at first, in the world.
    pub pose: Isometry3<f64>,
    /// Whether it stays there whatever touches it.
    pub fixed: bool,
    /// What it is made of.
    pub substance: Substance,
}

/// What a thing is made of, as far as it matters to who lifts it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Substance {
    /// Its mass, kilograms; none for that of light wood of its shape.
    pub mass: Option<f64>,
    /// The coefficient of friction of it with everything; none for 0.8, or more with what is rougher.
    pub friction: Option<f64>,
}

/// A geom that touches all that can be touched, in contacts of so many dimensions.
pub(super) fn touching_geom(name: &str, dimensions: &str, friction: [f64; 3]) -> Element {
    let touching = [("contype", "1".into()), ("conaffinity", "1".into()), ("condim", dimensions.into())];
    let mut geom = element("geom", &touching);
    geom.set("name", name);
    geom.set("friction", exact(&friction));
    geom
}

/// The body of a thing as MJCF, and the mesh that it is made of where it is one.
pub(super) fn described(thing: &Thing) -> Vec<Element> {
    let translation = thing.pose.translation.vector;
    let pose = [
        ("name", thing.name.clone()),
        ("pos", exact(translation.as_slice())),
        ("quat", exact(&wxyz(&thing.pose.rotation))),
    ];
    let mut body = element("body", &pose);
    if !thing.fixed {
        body.children.push(element("freejoint", &[]));
    }
    let Substance { mass, friction } = thing.substance;
    let coefficient = friction.unwrap_or(FRICTION);
    // What is round would never come to rest again once it was touched. The engine heeds that only in contacts of six dimensions.
    let round = matches!(thing.shape, Shape::Sphere { .. } | Shape::Capsule { .. } | Shape::Cylinder { .. });
    let rolls = round && friction.is_none();
    let friction_of = [coefficient, coefficient / TURNING, coefficient / ROLLING];
    let mut geom = touching_geom(&thing.name, if rolls { "6" } else { "4" }, friction_of);
    let mut set = |key: &str, value: String| geom.set(key, value);
    match mass {
        Some(mass) => set("mass", exact(&[mass])),
        None => set("density", exact(&[DENSITY])),
    };
    if friction.is_some() {
        // Of two geoms that touch, the engine takes the greater friction unless one goes first.
        set("priority", "1".into());
    }
    let mut described = Vec::new();
    match (thing.shape.hull(), thing.shape.mjcf().filter(|(_, size)| !size.is_empty())) {
        (Some(hull), _) => {
            let corners = hull.vertices().iter().flat_map(|corner| corner.iter());
            let mesh = [("name", thing.name.clone()), ("vertex", exact(corners))];
            described.push(element("mesh", &mesh));
            set("type", "mesh".into());
            set("mesh", thing.name.clone());
        }
        (None, primitive) => {
            let (kind, size) = primitive.unwrap_or(("sphere", vec![0.01]));
            set("type", kind.into());
            set("size", exact(&size));
        }
    }
    body.children.push(geom);
    described.push(body);
    described
}
