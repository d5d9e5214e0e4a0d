//! A creature in MuJoCo learns its body schema from nothing but touching itself.
//!
//! The folders read as the data flow:
//!
//! ```text
//! MJCF ─ mujoco ─┬─ creature, skin ─ agent   what the agent is given: tree, degrees of freedom, ranges, limbs, receptors
//!                └─ ground_truth             where joints really are; only the evaluation may see it
//! agent ─ simulation (motions until touch; a stage with things, probes and a handle) ─ senses ─ babbling ─ touches
//! touches ─ session (its folder on disk; or recordings of a real body, with no MJCF at all)
//! touches ─ learning (Hersch's rule; its repair; second order, then online) ─ schema, and how sure it is
//! schema + ground_truth ─ evaluation
//! schema + skin + touch ─ peripersonal (what is where about the body, how to touch it) ─ interaction
//! all of it ─ session (with an observer) ─ study (cases measured over seeds) ─ cli
//! session, schema ─ export (MJCF, URDF), view (report, live page, charts; pictures and films by MuJoCo's renderer)
//! ```
//!
//! All stand on [`geometry`] (shapes and their gaps) and [`kinematics`] (where a schema has the limbs in a posture).
//!
//! # Notation
//! Frames are `W` world, `L` a limb (origin at the joint that carries it; in the reference posture, parallel
//! to its parent), `P` its parent limb, `C` the common ancestor of two limbs, `R` a receptor. `X_AB` is the
//! pose of B in A, so `p_A = X_AB p_B`; `p_LR` is a receptor's position in its limb's frame, `n_L` a unit
//! normal expressed in L; `l_P` and `a_P` are a joint's position and axis in its parent limb's frame. Limbs may
//! have frames of their own in place of these, each at a fixed pose `(Q, c)` on its joint:
//! `p_P = l_P + R(a, θ) (Q p_L + c)`.
//!
//! Metres, radians, seconds and newtons everywhere; millimetres and degrees only in what a person reads.
//! MuJoCo's quaternions are w x y z, nalgebra's x y z w: they are converted at the boundary only.
//!
//! # From touches to acting
//! Babble, learn, evaluate, act: Max touches himself, and then knows a posture that brings his hand to a point.
//!
//! ```
//! use bodyschema::agent::Agent;
//! use bodyschema::peripersonal::ReachableMap;
//!
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! // The same touches each time, and from them alone where the joints are and how they turn.
//! let max = Agent::from_mjcf("mjcf/max/max.xml")?.babble(400)?.learn()?;
//! assert!(max.learned().verdict.converged());
//!
//! // Only here does the truth come in: where skin lands in another limb's frame, off by less than a tenth of a
//! // millimetre.
//! assert!(max.evaluation().determined_mm.mean < 0.1);
//!
//! // Act: where the left hand gets to, in the chest's frame, and how it gets there.
//! let own = max.own_body();
//! let hand = own.creature().limb("left_hand").ok_or("Max has a left hand")?;
//! let map = ReachableMap::new(&own, hand, own.carrier_of(&[hand]), 0.08)?;
//! let reach = map.reach(&[0.3, 0.2, 0.1].into());
//! assert!(reach.miss < 1e-3 && reach.posture.len() == own.creature().coordinates());
//! # Ok(())
//! # }
//! ```
//!
//! With an observer, and on disk: [`session`]; over many seeds: [`study`].
#![deny(unsafe_code)]
#![warn(missing_docs)]

pub mod agent;
pub mod babbling;
pub mod calibration;
#[cfg(feature = "cli")]
pub mod cli;
pub mod creature;
pub mod deadline;
mod error;
pub mod evaluation;
pub mod export;
pub mod geometry;
mod given_file;
pub mod ground_truth;
pub mod interaction;
pub mod kinematics;
pub mod learning;
pub mod model_files;
pub mod mujoco;
pub mod named;
pub mod peripersonal;
mod plausible;
pub mod schema;
pub mod senses;
pub mod session;
pub mod share;
pub mod simulation;
pub mod skin;
pub mod study;
#[cfg(any(feature = "render", feature = "report"))]
pub mod view;

pub use error::Error;
