//! Max and his torso's touches, as both benchmarks need them.

use std::path::Path;
use std::sync::Arc;

use bodyschema::agent::Agent;
use bodyschema::babbling::{Babbler, BabblingOptions, BoutsDone, Made, PolicyName};
use bodyschema::creature::{Body, JointSelection};
use bodyschema::mujoco::Model;
use bodyschema::senses::RecordedTouch;
use bodyschema::simulation::Effort;

/// Max with the joints of his torso (16 joints, 42 degrees of freedom), and the agent in it.
pub fn torso() -> (Body, Agent) {
    moving(&JointSelection::Default)
}

/// Max with all his joints (57 joints, 103 degrees of freedom), and the agent in it.
#[allow(dead_code, reason = "only one of the benchmarks moves them all")]
pub fn all() -> (Body, Agent) {
    moving(&JointSelection::All)
}

fn moving(joints: &JointSelection) -> (Body, Agent) {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("mjcf/max/max.xml");
    let model = Model::from_path(&path).expect("Max loads");
    let body = Body::new(Arc::new(model), joints).expect("Max has joints");
    let agent = Agent::of(&body).expect("his receptors have names");
    (body, agent)
}

/// The first touches of seed 1, made by one thread, and what they cost.
#[allow(dead_code, reason = "not every benchmark needs touches")]
pub fn babble(babbler: &Babbler, touches: usize) -> (Vec<RecordedTouch>, Effort) {
    let mut made = Vec::with_capacity(touches);
    let receive = |news: Made| {
        if let Made::Touch(touch) = news {
            made.push(touch.clone());
        }
        Ok(())
    };
    let options = BabblingOptions { touches, seed: 1, jobs: 1 };
    let babbled = babbler.babble(PolicyName::Random, BoutsDone::default(), &options, receive);
    (made, babbled.expect("Max touches himself").0)
}
