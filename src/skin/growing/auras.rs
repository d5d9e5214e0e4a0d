//! Writing the aura's geometries into a model's file: geoms that touch nothing, weigh nothing and are hidden.

use std::collections::{BTreeMap, BTreeSet};

use super::file::{each_body, free_class, insert_behind_geoms, numbers};
use crate::creature::Body;
use crate::error::Result;
use crate::geometry::Frame;
use crate::model_files::{Element, add_class, element, set_compiler};
use crate::mujoco::{AURA_GEOM, ObjectKind};
use crate::skin::aura::{aura_of, on_body};
use crate::skin::skin_of;

/// The default class of the aura's geoms.
const CLASS: &str = "aura";
/// Their visibility group: the last of MuJoCo's, which viewers hide until asked.
const GROUP: i32 = 5;
/// A capsule shorter than this is a ball, metres: the engine refuses one without a direction.
const SHORTEST: f64 = 1e-5;

/// Adds a geom for each aura limb of the creature that has none; how many there are now to be added.
pub(super) fn add_auras(root: &mut Element, body: &Body, digits: usize) -> Result<usize> {
    let data = body.reference_data()?;
    let frames: Vec<Frame> = body.reference_frames(&data).into_iter().map(Frame::from).collect();
    let all = aura_of(body, &skin_of(body), &frames);
    let mut geoms: BTreeMap<usize, Vec<Element>> = BTreeMap::new();
    let mut names = BTreeSet::new();
    let class = free_class(root, CLASS);
    for geometry in all.iter().filter(|geometry| !geometry.of_model) {
        let Some((bearer, capsule)) = on_body(body, geometry) else { continue };
        let mut name = format!("{AURA_GEOM}{}", geometry.name);
        while body.model.id(ObjectKind::Geom, &name).is_some() || !names.insert(name.clone()) {
            name.push('_');
        }
        let mut attributes = vec![("class", class.clone()), ("name", name)];
        let [a, b] = capsule.ends;
        if (b - a).norm() > SHORTEST {
            attributes.push(("fromto", numbers(a.iter().chain(&b), digits)));
        } else {
            attributes.push(("type", "sphere".into()));
            attributes.push(("pos", numbers((0.5 * (a + b)).iter(), digits)));
        }
        attributes.push(("size", numbers([capsule.radius].iter(), digits)));
        geoms.entry(bearer).or_default().push(element("geom", &attributes));
    }
    if names.is_empty() {
        return Ok(0);
    }
    let look = [
        ("type", "capsule".to_string()),
        ("contype", "0".into()),
        ("conaffinity", "0".into()),
        ("mass", "0".into()),
        ("group", GROUP.to_string()),
        ("rgba", "0.35 0.65 0.95 0.1".into()),
    ];
    add_class(root, &class, element("geom", &look));
    leave_out_of_inertia(root, body);
    let mut number = 0;
    each_body(root, &mut |element| {
        number += 1;
        insert_behind_geoms(element, geoms.remove(&number).into_iter().flatten());
    });
    Ok(names.len())
}

/// Has the engine leave the aura's group out where it works out a body's inertia. It weighs nothing anyway, but the
/// engine takes the inertia of a body of one geom as it is and adds up that of several, which rounds.
fn leave_out_of_inertia(root: &mut Element, body: &Body) {
    const RANGE: &str = "inertiagrouprange";
    let model = &body.declared;
    if (0..model.ngeom()).any(|geom| model.geom(geom).group >= GROUP && !model.is_aura(geom)) {
        return;
    }
    let told = root.setting("compiler", RANGE).unwrap_or("0 5");
    let range: Vec<i32> = told.split_whitespace().filter_map(|number| number.parse().ok()).collect();
    if let [least, most] = range[..]
        && most >= GROUP
    {
        set_compiler(root, RANGE, &format!("{least} {}", GROUP - 1));
    }
}
