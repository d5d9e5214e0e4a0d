//! Max touches himself 500 times and says where his left elbow is: `cargo run --release --example learn_max`.

use std::error::Error;

use bodyschema::Agent;

fn main() -> Result<(), Box<dyn Error>> {
    let max = Agent::from_mjcf("mjcf/max/max.xml")?.babble(500)?.learn()?;

    let learned = max.learned();
    println!("converged: {}", learned.verdict.converged());
    let creature = max.embodied().creature();
    let elbow = creature.joints().iter().position(|joint| joint.name == "left_elbow");
    let elbow = elbow.ok_or("Max has an elbow")?;
    println!("left elbow, in the upper arm's frame: {:.4?} m", learned.schema.positions[elbow].as_slice());

    // Only here does the truth come in.
    println!("held-out error: {:.3} mm on average", max.evaluation().heldout_mm.mean);
    Ok(())
}
