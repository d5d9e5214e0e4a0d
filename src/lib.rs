//! A creature in MuJoCo learns its body schema from nothing but touching itself.
//!
//! The folders read as the data flow:
//!
//! ```text
//! MJCF ─ mujoco ─┬─ creature      what the agent is given: tree, degrees of freedom, ranges, limbs
//!                └─ ground_truth  where joints really are; only the evaluation may see it
//! creature + skin ─ babbling (posture → motion → first contact → senses → touch) ─ touches
//! touches ─ record (the session on disk; or recordings of a real body, with no MJCF at all)
//! touches ─ (senses: disturbances) ─ learning (Hersch's rule; its repair; second order, then online) ─ schema
//! schema + ground_truth ─ evaluation ─ report
//! schema + skin + touch ─ peripersonal (what is where about the body, how to touch it) ─ interaction
//! ```
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
#![deny(unsafe_code)]
#![warn(missing_docs)]

pub mod babbling;
pub mod cli;
pub mod creature;
pub mod evaluation;
pub mod ground_truth;
pub mod interaction;
pub mod kinematics;
pub mod learning;
mod mjcf_xml;
pub mod mujoco;
pub mod peripersonal;
pub mod record;
pub mod schema;
pub mod senses;
pub mod skin;
