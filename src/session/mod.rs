//! A session: a creature babbles and learns, an observer looks on, and all of it goes into a folder.
//!
//! A session is a folder of files that other programs can read: [`SESSION_FILE`] says how it came
//! about, [`TOUCHES_FILE`] holds a touch a line, [`SCHEMA_FILE`] the learned body by name, and
//! [`LEARNING_FILE`] how learning went. Metres and radians throughout; names, not indices, between
//! files. Numbers are written in the shortest form that reads back to the same bits.

mod account;
mod babbling;
mod embodied;
pub(crate) mod files;
mod folder;
mod in_memory;
mod learned_session;
mod learning_options;
mod learning_record;
mod log;
mod mistaken;
mod observer;
mod recording;
mod request;
mod robot;
mod schema;
mod session_body;
mod session_file;
mod space;
mod stamp;
mod strokes;
mod touch_log;

pub use account::RecordedAccount;
pub use babbling::{BabbledSession, BabblingSession, Provenance};
pub(crate) use embodied::skin_for;
pub use embodied::{Embodied, ModelSource};
pub(crate) use files::{MadeFolders, PartFile, folder_of, write_whole};
pub use folder::{FolderLock, ReadLock};
pub use in_memory::{Babbled, LearnedBody};
pub use learned_session::{LearnedSession, learn_session};
pub use learning_options::{DisturbanceLevels, LearningOptions};
pub use learning_record::{
    Checkpoint, LearningRecord, LearningRow, read_learning_table, write_learning_table,
};
pub(crate) use log::wide_ranges;
pub(crate) use mistaken::{for_model as mistaken_for_model, is_model};
pub use observer::{LearningStep, Observer, Phase};
pub use recording::{CreatureFile, Recording, read_creature, read_recording};
pub(crate) use request::{BABBLING_SHARE, LEARNING_SHARE};
pub use request::{SessionRequest, SessionSetup};
pub use robot::simulated;
pub use robot::{
    CalibrationLog, RobotFile, RobotFormat, Written, add_fixed_places, calibration_table, is_mjcf,
    read_calibration_log, read_robot,
};
pub(crate) use robot::{joint_cells, joint_titles, json_of, length, name_of, set_prior};
pub use schema::{read_known, read_schema, read_schema_with_std, write_schema};
pub(crate) use session_body::{hands, learned_body, same_tree, session_body};
pub use session_body::{model_hash, own_body};
pub use session_file::{BabblingEffort, BabblingProgress, Host, RecordingFiles, Session, SessionOptions};
pub use space::{SpaceRecord, SpaceSlice};
pub use strokes::{StrokedSession, read_firings, read_map, record_strokes, write_firings, write_map};
pub use touch_log::{TouchLog, TouchWriter, read_touches};

/// How a session came about, in a session's folder.
pub const SESSION_FILE: &str = "session.json";
/// The log of touches, in a session's folder.
pub const TOUCHES_FILE: &str = "touches.jsonl";
/// How far babbling has come, in a session's folder while it babbles.
pub const PROGRESS_FILE: &str = "babbling.json";
/// What a study was asked and what came out, in its folder.
pub const STUDY_FILE: &str = "study.json";
/// Where the shares of a study are that several processes make, in its folder.
pub(crate) const SHARES_FOLDER: &str = "shares";
/// What a share of a study was asked for, in the share's folder.
pub const STUDY_SHARE_FILE: &str = "study-share.json";
/// The log of firing receptors, in the folder of a session of strokes.
pub const FIRINGS_FILE: &str = "firings.jsonl";
/// What the touch sensor made of them, in the same folder: a sensation a line.
pub const SENSATIONS_FILE: &str = "sensations.jsonl";
/// The learned body schema, in a session's folder.
pub const SCHEMA_FILE: &str = "schema.json";
/// The learned body as a model, in a session's folder.
pub const LEARNED_FILE: &str = "learned.xml";
/// The table of checkpoints of learning, in a session's folder.
pub const LEARNING_FILE: &str = "learning.csv";
/// What learning came to and how it got there, in a session's folder.
pub const LEARNED_RECORD_FILE: &str = "learning.json";
/// Slices of where the hands can get to, in a session's folder.
pub const SPACE_FILE: &str = "space.json";

/// This program and its version, as a session names what made it.
pub const PROGRAM: &str = concat!(env!("CARGO_PKG_NAME"), " ", env!("CARGO_PKG_VERSION"));

/// How far the length of an axis or a quaternion may be from 1 in a file.
const UNIT_LENGTH: f64 = 1e-6;
