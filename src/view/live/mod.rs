//! A live view: a page on this machine that shows what happens while it happens.
//!
//! Who works writes down what is newest and goes on; a thread of its own tells the pages, each as often as it can
//! follow. A slow page, or none, or a thousand clients that hold on to a connection, change nothing for who works.
//!
//! ```text
//! babbling, talking ─ LivePage (the newest state) ─ Server (20 times a second) ─ page
//!                       └───────── Asked (what is typed, where the skin is clicked) ┘
//!   within the server: connections (how many, how long) ─ guard (who, and what browsers may do) ─ routes
//! ```

mod babbling;
mod connections;
mod guard;
mod learner;
mod looking;
mod pace;
mod server;
mod table;

pub use babbling::BabblingView;
pub use learner::LiveLearner;
pub use looking::{LookedAt, LookingView};
pub use server::{Asked, LivePage, Reception, Server};
pub use table::TableView;

/// What such a page does beside drawing bodies.
const SCRIPT: &str = include_str!("live.js");
/// Height of the picture, pixels.
const HEIGHT: usize = 560;

/// A page with a title, a sentence below it, and what it shows, which is HTML.
fn page(title: &str, about: &str, content: &str) -> String {
    let content = format!(
        "<header>\n<h1>{}</h1>\n<p>{}</p>\n</header>\n{content}",
        super::text::escape(title),
        super::text::escape(about)
    );
    super::page(&format!("{title}, live"), include_str!("live.css"), &content, SCRIPT)
}
