//! Bodies that change between two sessions: a limb that has grown, a stick in a hand.
//!
//! Both are made in the MJCF, so that the engine and the babbling know them and the agent does not.

use std::path::Path;
use std::sync::Arc;

use nalgebra::Vector3;

use crate::creature::{Body, JointSelection};
use crate::experiment::ExperimentError;
use crate::model_files::{Element, Source, element, exact, write};
use crate::mujoco::Model;
use crate::senses::{Touch, TouchEnd};
use crate::skin::{Receptor, Skin, skin_of};

/// A stick's radius, metres.
const STICK_RADIUS: f64 = 0.008;
/// What the stick's sites are called.
const STICK: &str = "study_stick";
/// Half the size of a site that feels all that touches its side of the stick, metres.
const ALL: f64 = 2.0;

/// A limb's body with a name in the MJCF.
pub struct LimbInModel<'a> {
    /// The model's file.
    pub model: &'a Path,
    /// The joints that move.
    pub joints: &'a JointSelection,
    /// The body as it was.
    pub body: &'a Body,
    /// The limb.
    pub limb: usize,
}

impl LimbInModel<'_> {
    /// The name of the limb's body.
    pub fn name(&self) -> Result<&str, ExperimentError> {
        let name = self.limb.checked_sub(1).and_then(|joint| {
            let segment = &self.body.segments[joint];
            self.body.model.body(segment.body).name
        });
        name.ok_or_else(|| {
            let limb = &self.body.creature.limbs()[self.limb];
            ExperimentError::Refused(format!(
                "{}: the body of the limb {limb} has no name: name it, so that it can be changed",
                self.model.display()
            ))
        })
    }

    /// The body with the limb's joint further out by `length`, metres, on the limb that carries it.
    pub fn grown(&self, length: f64) -> Result<Body, ExperimentError> {
        self.changed(|element| {
            let position = numbers(element, "pos");
            let direction = position.try_normalize(1e-6).unwrap_or_else(Vector3::z);
            let grown = position + direction * length;
            element.set("pos", exact(grown.as_slice()));
        })
    }

    /// The body with a stick fixed to the limb, from `grip` to `tip` in the limb's frame, metres.
    pub fn with_stick(&self, grip: &Vector3<f64>, tip: &Vector3<f64>) -> Result<Body, ExperimentError> {
        let joint =
            self.limb.checked_sub(1).ok_or_else(|| ExperimentError::refused("the trunk holds no stick"))?;
        let x_lb = &self.body.pose_in_limb[self.body.segments[joint].body];
        let [grip, tip] = [grip, tip].map(|p| x_lb.inverse_transform_point(&(*p).into()).coords);
        let from_to = format!("{} {}", exact(grip.as_slice()), exact(tip.as_slice()));
        let geom = element(
            "geom",
            &[
                ("name", STICK.into()),
                ("type", "capsule".into()),
                ("fromto", from_to),
                ("size", exact(&[STICK_RADIUS])),
                ("mass", "0.01".into()),
            ],
        );
        let body = self.changed(move |body| {
            // A site per side, each of which feels what comes from there.
            let along = (tip - grip).normalize();
            let across = crate::kinematics::tangent_basis(&along);
            let middle = 0.5 * (grip + tip);
            let sides = [across.column(0).into(), across.column(1).into()];
            let sides = sides.iter().flat_map(|side: &Vector3<f64>| [*side, -side]);
            for (k, side) in sides.chain([along]).enumerate() {
                let at = if k < 4 { middle } else { tip };
                let size = exact(&[ALL]);
                let position = exact((at + side * STICK_RADIUS * 1.01).as_slice());
                let site = [("name", format!("{STICK}{k}")), ("pos", position), ("size", size)];
                body.children.insert(0, element("site", &site));
            }
            body.children.insert(0, geom.clone());
        })?;
        Ok(body)
    }

    /// The body after a change of its limb's element.
    fn changed(&self, mut change: impl FnMut(&mut Element)) -> Result<Body, ExperimentError> {
        let name = self.name()?;
        let fail = |why: String| ExperimentError::Refused(format!("{}: {why}", self.model.display()));
        let mut root = Source::read(self.model).map_err(crate::mujoco::Error::from)?.root;
        let found = find(root.section("worldbody"), name);
        let found = found.ok_or_else(|| {
            fail(format!(
                "the body {name} is not written out in it: write out its <replicate> to study growth"
            ))
        })?;
        change(found);
        add_sensors(&mut root);
        let model = Model::from_xml(&write(&root))?;
        Body::new(Arc::new(model), self.joints).map_err(|error| fail(error.to_string()))
    }
}

/// Touch sensors for the stick's sites, where there are any.
fn add_sensors(root: &mut Element) {
    let mut text = 0;
    let world = root.child("worldbody");
    while world.is_some_and(|world| has_site(world, &format!("{STICK}{text}"))) {
        text += 1;
    }
    let sensors = root.section("sensor");
    for k in 0..text {
        let site = format!("{STICK}{k}");
        sensors.children.push(element("touch", &[("site", site)]));
    }
}

fn has_site(parent: &Element, name: &str) -> bool {
    parent
        .children
        .iter()
        .any(|child| (child.name == "site" && child.get("name") == Some(name)) || has_site(child, name))
}

fn find<'a>(parent: &'a mut Element, name: &str) -> Option<&'a mut Element> {
    for child in parent.children.iter_mut() {
        if child.name == "body" && child.get("name") == Some(name) {
            return Some(child);
        }
        if let Some(found) = find(child, name) {
            return Some(found);
        }
    }
    None
}

fn numbers(element: &Element, key: &str) -> Vector3<f64> {
    let text = element.get(key).unwrap_or_default();
    let mut values = text.split_whitespace().filter_map(|word| word.parse().ok());
    Vector3::from_fn(|_, _| values.next().unwrap_or(0.0))
}

/// The skin of a changed body: its model's and, where that of the body as it was had grown in memory, the same
/// receptors on the same surfaces.
pub fn changed_skin(body: &Body, known: &Skin, changed: &Body) -> Skin {
    let mut skin = skin_of(changed);
    if skin_of(body).receptors.is_empty() {
        let is_own = |&s: &usize| changed.model.geom(skin.surfaces[s].geom).name != Some(STICK);
        let own: Vec<usize> = (0..skin.surfaces.len()).filter(is_own).collect();
        skin.receptors.extend(known.receptors.iter().map(|receptor| Receptor {
            surface: receptor.surface.and_then(|s| own.get(s).copied()),
            ..receptor.clone()
        }));
    }
    skin
}

/// A touch of the changed body as the agent feels it with the skin that it knows: what touches the stick is
/// felt at the receptor that holds it.
pub fn felt(known: &Skin, changed: &Skin, grip: usize, touch: &Touch) -> Option<Touch> {
    let mut touch = touch.clone();
    for end in &mut touch.ends {
        let id = &changed.receptors[end.receptor].id;
        let receptor = if id.starts_with(STICK) { grip } else { known.receptor(id)? };
        *end = TouchEnd { receptor, contact: end.contact, deviation: end.deviation };
    }
    Some(touch)
}
