//! MuJoCo behind a safe wall: the only `unsafe` code of the crate.
//!
//! A [`Model`] is read once, never changes and is shared between threads; each thread has its own
//! [`Data`], which holds a posture and what the engine computes from it. Metres, radians, seconds
//! and newtons throughout. MuJoCo writes quaternions as w x y z; they become nalgebra's unit
//! quaternions here and nowhere else, except in the raw `qpos` vector.
//!
//! With the feature `render` pictures are drawn by a `Renderer`, where there is an OpenGL: none is linked.
//!
//! No error of the engine ends the process or writes a log file: see [`Error`].
#![allow(unsafe_code)]
#![deny(unsafe_op_in_unsafe_fn)]

mod compiler;
mod data;
mod element;
mod engine;
mod error;
mod ffi;
mod filter;
mod model;
#[cfg(feature = "render")]
mod opengl;
#[cfg(feature = "render")]
mod renderer;
mod shapes;
mod simulated;
mod vfs;

pub(crate) use compiler::Compiler;
pub use data::{Contact, Data};
pub use element::{
    Equality, Geom, GeomKind, JointKind, ModelBody, ModelJoint, ObjectKind, Sensor, SensorKind, Site, Tuple,
    TupleEntry,
};
pub use engine::{Version, check, compare, schema};
pub use error::{Error, Result};
pub use filter::AURA_GEOM;
pub use model::Model;
#[cfg(feature = "render")]
pub use opengl::OPENGL_VARIABLE;
#[cfg(feature = "render")]
pub use renderer::{Camera, GeomCopy, Image, MOST_MARKS, Mark, PICTURE_SIDES, Renderer, View};
pub use simulated::LONGEST_STEP;
