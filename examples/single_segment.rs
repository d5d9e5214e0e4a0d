//! Figure 4 of the paper: one segment that turns about one joint. Where the joint is (`l`) and its axis (`a`) are learned
//! online, from points that are known in the frames of both sides and the angle at which they were:
//! `cargo run --release --example single_segment`.

use std::error::Error;
use std::sync::Arc;

use bodyschema::{
    Agent, Body, GroundTruth, Hersch, Input, JointSelection, Learner, Model, limb_frames, random_guess,
};
use nalgebra::Vector3;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// s1 with its origin at A, and s2 with the end effector C.
const ARM: &str = r#"<mujoco model="single segment">
  <compiler angle="radian" autolimits="true"/>
  <worldbody>
    <body name="s1">
      <geom type="capsule" fromto="0 0 0 0.2 0 0" size="0.02"/>
      <site name="A" type="box" size="0.01 0.01 0.001" pos="0 0 0.02"/>
      <body name="s2" pos="0.25 0.05 0">
        <joint name="joint" axis="0.2 0.3 1" range="-2 2"/>
        <geom type="capsule" fromto="0.03 0 0 0.3 0 0" size="0.02"/>
        <site name="C" type="box" size="0.01 0.01 0.001" pos="0.3 0 0.02"/>
      </body>
    </body>
  </worldbody>
  <sensor><touch site="A"/><touch site="C"/></sensor>
</mujoco>"#;
/// How far from the joint points are, metres.
const FAR: f64 = 0.5;
const EXAMPLES: u32 = 1 << 11;

fn main() -> Result<(), Box<dyn Error>> {
    let body = Body::new(Arc::new(Model::from_xml(ARM)?), &JointSelection::All)?;
    let (agent, truth) = (Agent::of(&body)?, GroundTruth::new(&body)?.schema);
    let (s1, s2) = (0, 1);
    let mut rng = ChaCha8Rng::seed_from_u64(1);
    let mut learner = Hersch::new(&agent, Input::Contact, random_guess(agent.creature(), &mut rng));
    println!("examples   joint off, mm   axis off, °   v' off, mm");
    for example in 0..=EXAMPLES {
        let angle = [rng.random_range(-2.0..2.0)];
        // v in the frame of s2, and v' in that of s1.
        let v = Vector3::from_fn(|_, _| rng.random_range(-FAR..FAR));
        let transformed = limb_frames(agent.creature(), &truth, &angle)[s2].point(&v);
        if example.is_power_of_two() {
            let learned = learner.learn().schema;
            let (l, a) = (learned.positions[0] - truth.positions[0], learned.axes[0].angle(&truth.axes[0]));
            let miss = limb_frames(agent.creature(), &learned, &angle)[s2].point(&v) - transformed;
            let (off, axis) = (1e3 * l.norm(), a.to_degrees());
            println!("{example:>8}   {off:>13.3}   {axis:>11.4}   {:>10.3}", 1e3 * miss.norm());
        }
        learner.observe_points(&angle, [s2, s1], [v, transformed]);
    }
    Ok(())
}
