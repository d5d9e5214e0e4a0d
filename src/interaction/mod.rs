//! The creature acts by what it learned, alone or asked by a partner: all that it has of where it is, is its
//! [`AgentHandle`](crate::simulation::AgentHandle).

mod actor;
mod avoiding;
mod conversation;
mod error;
mod own_spot;
mod tasks;
mod things;

pub use actor::{Actor, CAREFUL, FoundThing, Hand, SWIFT, Stop};
pub use avoiding::{Avoiding, QUICK};
pub use conversation::{Conversation, Intent, Reply, understood};
pub use error::ActorError;
pub use own_spot::OwnTouch;
pub use tasks::{Spot, Touching, Trouble};
pub use things::{KnownThing, Things};
