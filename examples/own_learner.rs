//! A learner of one's own, which keeps but a few touches of each pair of receptors, beside the one that keeps all:
//! `cargo run --release --example own_learner`.

use std::collections::HashMap;
use std::error::Error;

use bodyschema::{Agent, Input, Learned, Learner, SecondOrder, Touch};

/// Most touches that are kept of each pair of receptors.
const KEPT: usize = 1;

/// Learns from few touches of each pair of receptors.
struct Thrifty {
    learner: SecondOrder,
    kept: HashMap<[usize; 2], usize>,
}

impl Thrifty {
    fn new(agent: &Agent) -> Thrifty {
        Thrifty { learner: SecondOrder::new(agent, Input::Contact, 1), kept: HashMap::new() }
    }
}

impl Learner for Thrifty {
    fn touch(&mut self, touch: &Touch) {
        let kept = self.kept.entry(touch.ends.map(|end| end.receptor)).or_default();
        *kept += 1;
        if *kept <= KEPT {
            self.learner.touch(touch);
        }
    }

    fn learn(&mut self) -> Learned {
        self.learner.learn()
    }
}

fn main() -> Result<(), Box<dyn Error>> {
    let babbled = Agent::from_mjcf("mjcf/max/max.xml")?.babble(500)?;
    let (thrifty, errors) = babbled.learn_with(Input::Contact, Thrifty::new)?;
    println!("thrifty: converged {}, {:.1e} mm", thrifty.verdict.converged(), errors.determined_mm.mean);
    let (all, errors) =
        babbled.learn_with(Input::Contact, |agent| SecondOrder::new(agent, Input::Contact, 1))?;
    println!("all: converged {}, {:.1e} mm", all.verdict.converged(), errors.determined_mm.mean);
    Ok(())
}
