//! Max touches himself 500 times and says where his left elbow is: `cargo run --release --example learn_max`.

use std::convert::Infallible;
use std::error::Error;
use std::path::Path;
use std::sync::Arc;

use bodyschema::babbling::{Babbler, BabblingOptions};
use bodyschema::creature::{Body, JointSelection};
use bodyschema::evaluation::evaluate;
use bodyschema::ground_truth::GroundTruth;
use bodyschema::learning::{Learner, Online};
use bodyschema::mujoco::Model;
use bodyschema::skin::skin_of;

fn main() -> Result<(), Box<dyn Error>> {
    let model = Model::from_path(Path::new("mjcf/max/max.xml"))?;
    let body = Body::new(Arc::new(model), &JointSelection::Default)?;
    let skin = skin_of(&body);

    // Babble: every touch goes to the learner.
    let mut learner = Online::new(&body.creature, &skin, 1);
    let options = BabblingOptions { touches: 500, seed: 1, jobs: 2 };
    let babbler = Babbler::new::<Infallible>(&body, &skin)?;
    babbler.babble(&options, |touch| {
        learner.touch(touch);
        Ok::<(), Infallible>(())
    })?;

    let learned = learner.learn();
    println!("converged: {}", learned.verdict.converged());
    let elbow = body.creature.joints().iter().position(|joint| joint.name == "left_elbow");
    let elbow = elbow.ok_or("Max has an elbow")?;
    println!("left elbow, in the upper arm's frame: {:.4?} m", learned.schema.positions[elbow].as_slice());

    // Only here does the truth come in.
    let truth = GroundTruth::new(&body)?;
    let evaluation = evaluate(&body.creature, &skin, &truth, &learned.schema, &learned.undetermined);
    println!("held-out error: {:.3} mm on the mean", evaluation.heldout_mm.mean);
    Ok(())
}
