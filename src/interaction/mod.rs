//! The creature acts by what it learned, alone or asked by a partner: all that it has of where it is, is its
//! [`AgentHandle`](crate::simulation::AgentHandle).

mod actor;
mod avoiding;
mod body_part;
mod conversation;
mod leaning;
mod own_spot;
mod stick;
mod tasks;
mod things;

pub use actor::{Actor, CAREFUL, FoundThing, Hand, SWIFT};
pub use avoiding::{Avoiding, PlaceGoal, QUICK};
pub use body_part::BodyPart;
pub use conversation::grammar::{
    Aside, End, HandName, Language, Mood, PartName, Request, Understood, UnknownWord, Which,
};
pub use conversation::{Conversation, Intent, Reply, understood};
pub use own_spot::OwnTouch;
pub use stick::{HeldStick, KnownStick};
pub use tasks::{
    BodyFound, Feeling, FeltOver, Grip, PalmPlan, Search, SearchPlan, ShapeFeeling, Spot, Touching, Trouble,
};
pub use things::{KnownThing, ThingId, Things};
