//! A live view: a page on this machine that follows a running command.
//!
//! A page records its newest state and goes on; a thread of the server sends it to browsers, each as often as it can
//! follow. A slow browser, or none, or a thousand clients that hold on to a connection, change nothing for the work.
//!
//! ```text
//! babbling, looking, table ─ LivePage (the newest state) ─ Server (20 times a second) ─ browser
//!                               └──────── Asked (what is typed, where the skin is clicked) ┘
//!   within the server: connections (how many, how long) ─ guard (who, and what browsers may do) ─ routes
//! ```

mod babbling;
mod connections;
mod guard;
mod looking;
mod server;
mod table;

use std::sync::{Mutex, MutexGuard, PoisonError};

use nalgebra::Vector3;

pub use babbling::BabblingView;
pub use looking::{LookedAt, LookingView};
pub use server::{Asked, LivePage, Reception, Server};
pub use table::TableView;

use super::body::Pose;
use crate::agent::Agent;
use crate::schema::BodySchema;

/// What such a page does besides drawing bodies.
const SCRIPT: &str = include_str!("live.js");
/// Height of the picture, pixels.
const HEIGHT: usize = 560;
/// Half the side of the box to be seen, as a share of the body's extent: outstretched arms may leave it.
const ROOM: f64 = 0.86;

/// What a mutex guards, even if a thread panicked while it held it.
fn locked<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

/// A page with a title, a sentence below it, and its content, which is HTML.
fn page(title: &str, about: &str, content: &str) -> String {
    let content = format!(
        "<header>\n<h1>{}</h1>\n<p>{}</p>\n</header>\n{content}",
        super::text::escape(title),
        super::text::escape(about)
    );
    super::page(&format!("{title}, live"), include_str!("live.css"), &content, SCRIPT)
}

/// The greatest distance of any receptor or joint of a body in the rest posture from its root, metres.
fn extent(agent: &Agent, schema: &BodySchema) -> f64 {
    let pose = Pose::at_rest(agent.creature(), schema);
    let receptors = agent.skin().receptors.iter();
    let places = receptors.map(|receptor| pose.frames[receptor.limb].point(&receptor.position).norm());
    places.chain(pose.begins.iter().map(|begin| begin.norm())).fold(0.1, f64::max)
}

/// The box to be seen of a body of some extent, and of another one so far beside it along y, metres.
fn room(extent: f64, aside: f64) -> [Vector3<f64>; 2] {
    let r = ROOM * extent;
    [Vector3::repeat(-r), Vector3::new(r, aside + r, r)]
}
