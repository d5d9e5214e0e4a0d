#![doc = include_str!("../docs/library.md")]
#![deny(unsafe_code)]
#![warn(missing_docs)]
// What the program alone uses.
#![cfg_attr(not(feature = "cli"), allow(dead_code, unused_imports))]

// The library: at most 130 names beside those of estimation (`learning`, `calibration`), counted by `tests/it/library.rs`.
// Each is used in a documentation test or an example. To add a name, name it here and use it there.

// From a model to a learned body.
pub use agent::Agent;
pub use babbling::PolicyName;
pub use creature::JointSelection;
pub use error::{Error, Result};
pub use session::{Babbled, Embodied, LearnedBody, LearningOptions, ModelSource, SessionRequest};
pub use simulation::MotionName;

// What a creature is, and what it learned.
pub use creature::{Creature, Dof, DofKind, Joint, Posture};
pub use geometry::{Frame, Shape};
pub use kinematics::limb_frames;
pub use learning::{
    Account, BodyChange, Certainty, Hersch, Input, Learned, Learner, LimbFrames, Online, SecondOrder,
    SkinKnowledge, Verdict, initial_guess::random_guess, learners::LEARNERS,
};
pub use schema::BodySchema;

// Skin and senses.
pub use senses::{
    NewSense, RecordedTouch, SENSES, Sensation, Sense, SensedStep, SensingBody, SkinContact, Touch,
    TouchEvent, TouchKind, Toucher,
};
pub use skin::{GrowOptions, Grown, PatchSize, Receptor, Skin, SomatotopicMap, Surface, grow_skin};

// Babbling by a policy of one's own.
pub use babbling::{BabblingOptions, Policy};

// Measuring against the truth, which no learner sees.
pub use creature::Body;
pub use evaluation::{Evaluation, Summary, evaluate, evaluate_learned};
pub use ground_truth::GroundTruth;
pub use mujoco::Model;

// Sessions on disk, and recordings of a real body.
pub use session::{
    BabbledSession, BabblingSession, DisturbanceLevels, FolderLock, LearnedSession, LearningRecord, Observer,
    Phase, Provenance, Session, SessionSetup, learn_session, own_body, read_schema, read_touches,
};

// Acting by what was learned.
pub use interaction::{
    Actor, Avoiding, Conversation, FoundThing, Hand, Intent, PlaceGoal, Reply, Touching, Trouble,
};
pub use kinematics::Place;
pub use peripersonal::{
    CollisionChecker, Level, LimbGoal, LimbPosture, Obstacle, OutOfReach, OwnBody, PosturePath, Reach,
    ReachPlan, ReachTarget, ReachableMap, Reaching, TablePlane, find_path, limb_posture,
};
pub use simulation::{AgentHandle, ProbePath, Stage, StageOptions, StepSenses, Substance, Thing};

// The learned body in the formats of others.
pub use export::{to_mjcf, to_urdf};

// Calibrating a robot by its logged self-contacts.
pub use calibration::robot::{Knowledge, Quantity, Robot, Value};
pub use calibration::{
    Estimator, EstimatorOptions, Fit, Judgement, Objection, Plan, Touch as RobotTouch, folds, judge,
    objections, plan,
};
pub use session::simulated::{add_joint_noise, add_point_noise, misread, point_touches};
pub use session::{CalibrationLog, RobotFile, calibration_table, read_calibration_log, read_robot};

// The modules, used by our program, tests and benchmarks; no promise is made about them.
#[doc(hidden)]
pub mod agent;
#[doc(hidden)]
pub mod babbling;
#[doc(hidden)]
pub mod calibration;
#[doc(hidden)]
#[cfg(feature = "cli")]
pub mod cli;
#[doc(hidden)]
pub mod creature;
#[doc(hidden)]
pub mod deadline;
mod error;
#[doc(hidden)]
pub mod evaluation;
#[doc(hidden)]
pub mod export;
#[doc(hidden)]
pub mod geometry;
mod given_file;
mod given_number;
#[doc(hidden)]
pub mod ground_truth;
#[doc(hidden)]
pub mod interaction;
#[doc(hidden)]
pub mod kinematics;
#[doc(hidden)]
pub mod learning;
#[doc(hidden)]
pub mod model_files;
#[doc(hidden)]
pub mod mujoco;
mod named;
#[doc(hidden)]
pub mod peripersonal;
mod plausible;
#[doc(hidden)]
pub mod schema;
#[doc(hidden)]
pub mod senses;
#[doc(hidden)]
pub mod session;
#[doc(hidden)]
pub mod simulation;
#[doc(hidden)]
pub mod skin;
#[doc(hidden)]
pub mod study;
#[doc(hidden)]
#[cfg(feature = "report")]
pub mod view;
