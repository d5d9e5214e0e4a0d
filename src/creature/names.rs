//! Names of bodies, joints and sites, made where a model has none.

use crate::mujoco::{Model, ObjectKind};

/// A body's name, or one made from its number that no other has.
pub(crate) fn body_name(model: &Model, body: usize) -> String {
    let made = || free_name(model, ObjectKind::Body, format!("body{body}"));
    model.body(body).name.map_or_else(made, str::to_string)
}

/// A joint's name, or one made from its number that no other has.
pub(crate) fn joint_name(model: &Model, joint: usize) -> String {
    let made = || free_name(model, ObjectKind::Joint, format!("joint{joint}"));
    model.joint(joint).name.map_or_else(made, str::to_string)
}

/// A site's name, or one made from its number that no other has, as receptors are called.
pub(crate) fn site_name(model: &Model, site: usize) -> String {
    let made = || free_name(model, ObjectKind::Site, format!("site{site}"));
    model.site(site).name.map_or_else(made, str::to_string)
}

/// A name with underscores behind it where one of a kind has it in the model.
pub(crate) fn free_name(model: &Model, kind: ObjectKind, mut name: String) -> String {
    while model.id(kind, &name).is_some() {
        name.push('_');
    }
    name
}
