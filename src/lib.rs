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
//! model + posture + marks ─ picture (a still or a film, by MuJoCo's renderer)
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
//! # From touches to acting
//! Babble, learn, evaluate, act: Max touches himself, and then knows a posture that brings his hand to a point.
//!
//! ```
//! use std::{convert::Infallible, path::Path, sync::Arc};
//!
//! use bodyschema::babbling::{Babbler, BabblingOptions};
//! use bodyschema::creature::{Body, JointSelection};
//! use bodyschema::evaluation::evaluate;
//! use bodyschema::ground_truth::GroundTruth;
//! use bodyschema::learning::{Input, Learner, SecondOrder};
//! use bodyschema::mujoco::Model;
//! use bodyschema::peripersonal::{OwnBody, ReachableMap};
//! use bodyschema::skin::skin_of;
//!
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! let model = Model::from_path(Path::new("mjcf/max/max.xml"))?;
//! let body = Body::new(Arc::new(model), &JointSelection::Default)?;
//! let skin = skin_of(&body);
//!
//! // Babble: the same seed gives the same touches.
//! let mut touches = Vec::new();
//! let options = BabblingOptions { touches: 400, seed: 1, jobs: 2 };
//! Babbler::new::<Infallible>(&body, &skin)?.babble(&options, |touch| {
//!     touches.push(touch.clone());
//!     Ok::<(), Infallible>(())
//! })?;
//!
//! // Learn, here from the points of contact.
//! let mut learner = SecondOrder::new(&body.creature, &skin, Input::Contact, 1);
//! touches.iter().for_each(|touch| learner.touch(touch));
//! let learned = learner.learn();
//! assert!(learned.verdict.converged());
//!
//! // Evaluate: only here does the truth come in.
//! let truth = GroundTruth::new(&body)?;
//! let evaluation = evaluate(&body.creature, &skin, &truth, &learned.schema, &learned.undetermined);
//! assert!(evaluation.heldout_mm.mean < 1e-6);
//!
//! // Act: where the left hand gets to, in the chest's frame, and how it gets there.
//! let own = OwnBody::new(&body.creature, &skin, learned.schema, &touches, Input::Contact);
//! let hand = body.creature.limb("left_hand").ok_or("Max has a left hand")?;
//! let map = ReachableMap::new(&own, hand, own.carrier_of(&[hand]), 0.08).map_err(|error| error.to_string())?;
//! let (posture, miss) = map.reach(&[0.3, 0.2, 0.1].into());
//! assert!(miss < 1e-3 && posture.len() == body.creature.coordinates());
//! # Ok(())
//! # }
//! ```
//!
//! The same from the command line: [`cli`]; sessions on disk: [`record`].
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
mod live;
mod mjcf_xml;
pub mod mujoco;
pub mod peripersonal;
pub mod picture;
pub mod record;
pub mod schema;
pub mod senses;
pub mod skin;
