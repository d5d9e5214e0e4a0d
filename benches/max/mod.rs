//! Max and his torso's touches, as both benchmarks need them.

use std::convert::Infallible;
use std::path::Path;
use std::sync::Arc;

use bodyschema::babbling::{Babbler, BabblingOptions, Effort};
use bodyschema::creature::{Body, JointSelection};
use bodyschema::mujoco::Model;
use bodyschema::senses::Touch;
use bodyschema::skin::{Skin, skin_of};

/// Max with the joints of his torso (16 joints, 42 degrees of freedom), and his skin.
pub fn torso() -> (Body, Skin) {
    moving(&JointSelection::Default)
}

/// Max with all his joints (57 joints, 103 degrees of freedom), and his skin.
#[allow(dead_code, reason = "only one of the benchmarks moves them all")]
pub fn all() -> (Body, Skin) {
    moving(&JointSelection::All)
}

fn moving(joints: &JointSelection) -> (Body, Skin) {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("mjcf/max/max.xml");
    let model = Model::from_path(&path).expect("Max loads");
    let body = Body::new(Arc::new(model), joints).expect("Max has joints");
    let skin = skin_of(&body);
    (body, skin)
}

/// The first touches of seed 1, made by one thread, and what they cost.
#[allow(dead_code, reason = "not every benchmark needs touches")]
pub fn babble(babbler: &Babbler, touches: usize) -> (Vec<Touch>, Effort) {
    let mut made = Vec::with_capacity(touches);
    let receive = |touch: &Touch| {
        made.push(touch.clone());
        Ok::<(), Infallible>(())
    };
    let options = BabblingOptions { touches, seed: 1, jobs: 1 };
    let effort = babbler.babble(&options, receive).expect("Max touches himself");
    (made, effort)
}
