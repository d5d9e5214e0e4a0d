//! A policy of one's own: from where it is, Max sets out half the way to a random posture.
//! `cargo run --release --example own_policy`.

use std::error::Error;

use bodyschema::{Agent, BabblingOptions, Creature, Policy, Posture, Touch};
use rand_chacha::ChaCha8Rng;

/// Goes half the way to random postures.
struct HalfTheWay {
    creature: Creature,
    touched: usize,
}

impl Policy for HalfTheWay {
    fn next_target(&mut self, posture: &[f64], rng: &mut ChaCha8Rng) -> Posture {
        let target = Posture::random(&self.creature, rng);
        Posture::between(&self.creature, posture, &target, 0.5)
    }

    fn touched(&mut self, _: &Touch) {
        self.touched += 1;
    }
}

fn main() -> Result<(), Box<dyn Error>> {
    let max = Agent::from_mjcf("mjcf/max/max.xml")?;
    let mut policy = HalfTheWay { creature: max.creature().clone(), touched: 0 };
    let babbled = max.babble_with(&mut policy, &BabblingOptions { touches: 300, seed: 1, jobs: 1 })?;
    let motions = babbled.touches().last().map_or(0, |touch| touch.motion);
    println!("{} touches in {motions} motions", policy.touched);
    let learned = babbled.learn()?;
    println!("held-out error: {:.3} mm on average", learned.evaluation().heldout_mm.mean);
    Ok(())
}
