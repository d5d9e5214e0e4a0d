//! Shapes in space: poses, convex shapes, and how far apart two of them are.
//!
//! A [`Shape`] is matched here and nowhere else: whoever has one asks its methods. [`gap()`] is the one answer to how
//! far apart two placed bodies are; [`Ball`] and [`Capsule`] bound what is too far away to be asked about.

mod capsule;
mod contact_region;
mod epa;
mod farthest;
mod formats;
mod frame;
mod gap;
mod gjk;
mod hull;
mod outline;
mod samples;
mod shape;
mod simplex;

pub use capsule::{Ball, Capsule, Cluster, box_about, closest_points, clusters};
pub use contact_region::ContactRegion;
pub use formats::UrdfGeometry;
pub use frame::{Frame, tangent_basis};
pub(crate) use frame::{product, wxyz, z_onto};
pub use gap::{ConvexBody, Gap, PlacedShape, gap, gap_from, separation};
pub(crate) use gap::{distance_by_support, gap_by_support};
pub use gjk::Precision;
pub use hull::Hull;
pub use outline::ConvexOutline;
pub use samples::{SurfaceSample, directions, random_direction};
pub use shape::Shape;
