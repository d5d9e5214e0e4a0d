//! A live view: a page on this machine that shows what happens while it happens.
//!
//! Who works writes down what is newest and goes on; a thread of its own tells the pages, each as often as it can
//! follow. A slow page, or none, changes nothing for who works.
//!
//! ```text
//! babbling, talking ─ View (the newest state) ─ Server (20 times a second) ─ page
//!                       └───────── Asked (what is typed, where the skin is clicked) ┘
//! ```

mod babbling;
mod figure;
mod learner;
mod page;
mod server;
mod table;

pub use babbling::BabblingView;
pub use learner::LiveLearner;
pub use server::{Asked, Server, View};
pub use table::TableView;
