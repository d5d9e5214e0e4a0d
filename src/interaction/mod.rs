//! The creature among other things: probes that touch it and what it feels of them; scenes in which it acts by what it
//! learned, alone or asked by a partner.

mod actor;
mod avoiding;
mod caress;
mod conversation;
mod event;
mod own_spot;
mod scene;
mod script;
mod stimulation;
mod tasks;
mod world;

pub use actor::{Actor, CAREFUL, Found, Hand, SWIFT, Stop};
pub use avoiding::{Avoiding, QUICK};
pub use caress::stroke_for;
pub use conversation::{Conversation, Intent, Reply, understood};
pub use event::{aura_event_json, event_json};
pub use own_spot::OwnTouch;
pub use scene::{Feeling, Scene, Thing, Touched, Watcher};
pub use script::Script;
pub use stimulation::{Stimulation, Strokes};
pub use tasks::{Spot, Touching, Trouble};
pub use world::{PROBE_RADIUS, ProbePath, World, WorldError};
