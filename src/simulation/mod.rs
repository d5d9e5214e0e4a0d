//! A creature on MuJoCo's physics: it moves until it touches something, alone or among things, and feels what touches it.
//!
//! On a [`Stage`] are things and probes, and all senses run. Who looks on, puts things and measures has the stage itself;
//! the creature has an [`AgentHandle`], which moves, feels, holds and lets go, and nothing else. Motions that stop at the
//! first touch of the creature with itself are [`Movers`]'. The physics is stepped in one place, `step.rs`.

mod advancement;
mod agent_handle;
mod broad_phase;
mod dynamic;
mod event;
mod kinematic;
mod motion;
pub mod partner;
mod probe;
mod relative_motion;
mod self_contact;
mod stage;
mod step;
mod straight_motion;
mod thing;
mod touchable;

pub use agent_handle::AgentHandle;
pub use dynamic::{Servo, ServoPath};
pub use event::{aura_event_json, event_json};
pub use kinematic::DEEPEST;
pub use motion::{Effort, Ending, MotionName, Mover, Movers};
pub use probe::{PROBE_RADIUS, ProbePath, STIFFNESS};
pub use self_contact::{LimbPair, Relation, SelfContact};
pub use stage::{Stage, StageOptions, StepSenses, Watcher};
pub use step::step;
pub use thing::{Substance, Thing};

/// Two numbers, of geoms or limbs, the lesser one first.
fn sorted([a, b]: [usize; 2]) -> [usize; 2] {
    [a.min(b), a.max(b)]
}
