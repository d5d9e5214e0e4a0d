//! What learning came to and how it got there: the verdict, the schema as it stood at checkpoints, and a table with a row for each.

use std::io;
use std::path::Path;

use serde::de::Error as _;
use serde::{Deserialize, Deserializer, Serialize, Serializer};

use super::account::{AccountEntry, RecordedAccount};
use super::schema::{JointEntry, joint_entries, schema_of_joints};
use super::stamp::Stamp;
use super::{Host, LEARNED_RECORD_FILE, LEARNING_FILE, files};
use crate::creature::Creature;
use crate::error::Error;
use crate::evaluation::CramerRaoBound;
use crate::learning::{Account, Certainty};
use crate::named::plural;
use crate::schema::BodySchema;

const STAMP: Stamp = Stamp { format: "bodyschema learning", version: 1 };

/// The name of a fact that reports a change of the body.
pub(super) const CHANGE: &str = "change";
/// Touches of a log at the most.
const MOST_TOUCHES: usize = 100_000_000;
/// Numbers in the table at the most; learning gives none that are farther off.
const GREATEST: f64 = 1e15;

/// What learning from a session's touches came to.
///
/// In the file, the format's name and version come before these fields.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct LearningRecord {
    /// The program and its version: [`PROGRAM`](super::PROGRAM).
    pub program: String,
    /// The command line that it was learned by, word by word.
    pub command: Vec<String>,
    /// The computer it was learned on.
    pub host: Option<Host>,
    /// The seed of the initial guesses.
    pub seed: u64,
    /// How many of the session's touches it was learned from.
    pub touches: usize,
    /// How it was learned and what is worth telling of it: name and value, in the order to be told.
    pub facts: Vec<(String, String)>,
    /// Time that learning took, seconds; none in records from before it was kept.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub seconds: Option<f64>,
    /// Whether the schema predicts held-out touches.
    pub converged: bool,
    /// The verdict in a sentence.
    pub verdict: String,
    /// Why it did not converge; `None` if it did, and in records from before this was kept.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub reason: Option<String>,
    /// The joints that the touches do not determine, by name.
    pub undetermined: Vec<String>,
    /// The limbs that are not placed though no joint between them and limbs that are is undetermined, by name.
    pub undetermined_limbs: Vec<String>,
    /// Every direction in which the schema could change without any touch feeling it, in words.
    pub open_directions: Vec<String>,
    /// The held-out error beside its bound; `None` if either is not known.
    #[serde(rename = "bound_mm", alias = "bound", default, skip_serializing_if = "Option::is_none")]
    pub bound: Option<CramerRaoBound>,
    /// How sure the schema is; none in records from before it was kept.
    #[serde(skip)]
    pub account: Option<RecordedAccount>,
    /// The schema during learning, from the initial guess on, as far as there was one.
    #[serde(skip)]
    pub checkpoints: Vec<Checkpoint>,
}

/// A schema during learning.
#[derive(Clone, Debug, PartialEq)]
pub struct Checkpoint {
    /// After so many touches; 0 is the initial guess, what was believed before the first.
    pub touches: usize,
    /// What was believed.
    pub schema: BodySchema,
    /// Its held-out error over what the touches determine in the end, a root mean square, millimetres; `None` if
    /// the truth was not known.
    pub error_rms: Option<f64>,
    /// The Cramér-Rao bound of the same from so many touches, millimetres; `None` if it was not known.
    pub bound_rms: Option<f64>,
}

/// A checkpoint as it is written.
#[derive(Serialize, Deserialize)]
struct CheckpointEntry {
    touches: usize,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    error_rms_mm: Option<f64>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    bound_rms_mm: Option<f64>,
    joints: Vec<JointEntry>,
}

/// The record as it is written, with what has names of the creature's.
#[derive(Serialize, Deserialize)]
struct LearningFile {
    #[serde(flatten)]
    record: LearningRecord,
    creature: String,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    account: Option<AccountEntry>,
    checkpoints: Vec<CheckpointEntry>,
}

impl LearningRecord {
    /// The account that may be relied on; `None` if learning did not converge, and in records from before this was
    /// kept: what touches determine at a wrong schema bounds nothing.
    pub fn reliable_account(&self) -> Option<&Account> {
        self.account.as_ref().filter(|_| self.converged)?.account.as_ref()
    }

    /// How sure the schema is: unknown without a reliable account.
    pub fn certainty(&self) -> Certainty {
        let account = self.reliable_account().cloned();
        account.map_or(Certainty::Unknown, |account| Certainty::Estimated(Box::new(account)))
    }

    /// How many limbs are located relative to one another, and how many have skin; `None` if the learner gives no account.
    pub fn located(&self) -> Option<[usize; 2]> {
        let account = self.account.as_ref()?.account.as_ref()?;
        let located = self.reliable_account().map_or(0, |account| account.located().len());
        Some([located, account.limbs().len()])
    }

    /// What the bounds of exact touches assume, in a sentence; `None` if touches show noise, or nothing is bounded.
    pub fn floor_note(&self) -> Option<&'static str> {
        self.reliable_account().filter(|account| account.witnesses.at_floor).map(|_| {
            "The touches show no noise. The bounds assume the learner's minimum noise; actual errors may be far smaller."
        })
    }

    /// How the body changed as the learner understood it, in sentences.
    pub fn changes(&self) -> impl Iterator<Item = &String> {
        self.facts.iter().filter(|(name, _)| name == CHANGE).map(|(_, value)| value)
    }

    /// How many directions no touch feels, and what that means for what is located.
    pub fn directions_in_words(&self) -> String {
        let directions = plural(self.open_directions.len(), "direction");
        match self.undetermined.is_empty() && self.undetermined_limbs.is_empty() {
            true => {
                format!(
                    "{directions} of joints, without effect on the positions of located limbs relative to each other"
                )
            }
            false => format!("{directions} of joints and limbs"),
        }
    }

    /// What is known, as every command's JSON has it.
    pub fn knowledge_json(&self) -> serde_json::Value {
        let [located, limbs] = self.located().map_or([None; 2], |counts| counts.map(Some));
        serde_json::json!({
            "converged": self.converged,
            "reason": self.reason,
            "verdict": self.verdict,
            "located_limbs": located,
            "limbs_with_skin": limbs,
            "undetermined": self.undetermined,
            "undetermined_limbs": self.undetermined_limbs,
        })
    }

    /// That of a schema without a record: nothing is known.
    fn unknown(creature: &Creature) -> LearningRecord {
        LearningRecord {
            touches: usize::MAX,
            verdict: "The session does not record whether learning converged; run `bodyschema learn` again."
                .into(),
            undetermined: creature.joints().iter().map(|joint| joint.name.clone()).collect(),
            ..LearningRecord::default()
        }
    }

    /// Writes [`LEARNED_RECORD_FILE`] into `folder`, which is made if missing; whole or not at all.
    ///
    /// # Errors
    /// If the folder or the file cannot be written.
    pub fn write(&self, folder: &Path, creature: &Creature) -> Result<(), Error> {
        let entry = |checkpoint: &Checkpoint| CheckpointEntry {
            touches: checkpoint.touches,
            error_rms_mm: checkpoint.error_rms.filter(|error| error.is_finite()),
            bound_rms_mm: checkpoint.bound_rms.filter(|bound| bound.is_finite()),
            joints: joint_entries(creature, &checkpoint.schema, None),
        };
        let finite = |bound: &CramerRaoBound| numbers(bound).iter().all(|x| x.is_finite());
        let content = LearningFile {
            record: LearningRecord { bound: self.bound.filter(finite), ..self.clone() },
            creature: creature.name().to_string(),
            account: self.account.as_ref().map(|account| AccountEntry::new(account, creature)),
            checkpoints: self.checkpoints.iter().map(entry).collect(),
        };
        STAMP.write(&folder.join(LEARNED_RECORD_FILE), &content)
    }

    /// Reads [`LEARNED_RECORD_FILE`] of `folder`. Without such a file, as beside a schema that was put there, nothing is known,
    /// not even the program.
    ///
    /// # Errors
    /// If it cannot be read, or if it is no such record, one of a
    /// newer version, or of another creature.
    pub fn read(folder: &Path, creature: &Creature) -> Result<LearningRecord, Error> {
        let path = folder.join(LEARNED_RECORD_FILE);
        if !path.exists() {
            return Ok(LearningRecord::unknown(creature));
        }
        let content: LearningFile = STAMP.read(&path, "record of learning")?;
        let refuse = |message: String| Error::content(&path, None, message);
        if content.creature != creature.name() {
            return Err(refuse(format!(
                "it is of \"{}\", not of \"{}\": learn again with `bodyschema learn`",
                content.creature,
                creature.name()
            )));
        }
        let mut record = content.record;
        let anew = "learn again with `bodyschema learn`";
        let of_creature = |name: &&String| {
            creature.limb(name).is_some() || creature.joints().iter().any(|joint| joint.name == **name)
        };
        let named = record.undetermined.iter().chain(&record.undetermined_limbs);
        if let Some(other) = { named }.find(|name| !of_creature(name)) {
            return Err(refuse(format!("it names \"{other}\", which the creature does not have: {anew}")));
        }
        let on_the_way =
            content.checkpoints.iter().flat_map(|entry| [entry.error_rms_mm, entry.bound_rms_mm]);
        let all = record.bound.iter().flat_map(numbers).chain(on_the_way.flatten()).chain(record.seconds);
        if let Some(wrong) = { all }.find(|x| !(*x >= 0.0 && x.is_finite())) {
            let message = format!("it has an impossible error, bound or time of {wrong}: {anew}");
            return Err(refuse(message));
        }
        let account = content.account.map(|entry| entry.account(creature)).transpose();
        record.account = account.map_err(&refuse)?;
        for (i, entry) in content.checkpoints.iter().enumerate() {
            let schema = schema_of_joints(&entry.joints, creature)
                .map_err(|message| refuse(format!("its checkpoint {}: {message}", i + 1)))?;
            record.checkpoints.push(Checkpoint {
                touches: entry.touches,
                schema,
                error_rms: entry.error_rms_mm,
                bound_rms: entry.bound_rms_mm,
            });
        }
        Ok(record)
    }
}

/// The numbers of a bound.
fn numbers(bound: &CramerRaoBound) -> [f64; 3] {
    [bound.bound_rms, bound.error_rms, bound.ratio]
}

/// A row of [`LEARNING_FILE`]; what is not known has an empty cell.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LearningRow {
    /// The touches that were learned from.
    pub touches: usize,
    /// How far apart the schema before put the surfaces that met in the last of them, millimetres, …
    #[serde(default, serialize_with = "written", deserialize_with = "gap")]
    pub predicted_gap_mm: Option<f64>,
    /// … and the standard deviation that the learner expected of that.
    #[serde(default, serialize_with = "written", deserialize_with = "measure")]
    pub predicted_deviation_mm: Option<f64>,
    /// 1 if the schema predicts held-out touches, else 0.
    #[serde(default)]
    pub converged: Option<u8>,
    /// The residual of held-out touches, a root mean square in the learner's own unit.
    #[serde(default, serialize_with = "written", deserialize_with = "measure")]
    pub fresh_rms: Option<f64>,
    /// The mean surface error between all pairs of limbs, millimetres.
    #[serde(default, serialize_with = "written", deserialize_with = "measure")]
    pub heldout_mean_mm: Option<f64>,
    /// 95 % of these errors are less.
    #[serde(default, serialize_with = "written", deserialize_with = "measure")]
    pub heldout_p95_mm: Option<f64>,
    /// The mean surface error between a hand and other limbs, millimetres.
    #[serde(default, serialize_with = "written", deserialize_with = "measure")]
    pub hand_mean_mm: Option<f64>,
    /// The median angle between learned and true axes, degrees.
    #[serde(default, serialize_with = "written", deserialize_with = "measure")]
    pub axis_median_deg: Option<f64>,
}

/// Writes [`LEARNING_FILE`] into a session's folder, which is made if missing: comma-separated values after a line of column
/// names. A number that no measure can have leaves its cell empty.
///
/// # Errors
/// If the folder or the file cannot be written.
pub fn write_learning_table(folder: &Path, rows: &[LearningRow]) -> Result<(), Error> {
    let path = folder.join(LEARNING_FILE);
    let mut writer = csv::Writer::from_writer(Vec::new());
    for row in rows {
        writer.serialize(row).map_err(io::Error::other).map_err(Error::unwritable(&path))?;
    }
    let table = writer.into_inner().map_err(|error| Error::unwritable(&path)(error.into_error()))?;
    files::write(&path, table)
}

/// A number that no measure can have leaves its cell empty.
fn written<S: Serializer>(number: &Option<f64>, serializer: S) -> Result<S::Ok, S::Error> {
    number.filter(|x| x.abs() <= GREATEST).serialize(serializer)
}

/// A gap, which is negative where surfaces overlap.
fn gap<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Option<f64>, D::Error> {
    within(-GREATEST, deserializer)
}

/// Any other measure.
fn measure<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Option<f64>, D::Error> {
    within(0.0, deserializer)
}

fn within<'de, D: Deserializer<'de>>(least: f64, deserializer: D) -> Result<Option<f64>, D::Error> {
    let number = Option::<f64>::deserialize(deserializer)?;
    match number.filter(|x| !(least..=GREATEST).contains(x)) {
        None => Ok(number),
        Some(wrong) => Err(D::Error::custom(format!("{wrong} is not a possible value"))),
    }
}

/// Reads [`LEARNING_FILE`] of a session's folder; nothing if there is no such file.
///
/// # Errors
/// If it cannot be read, or, with the line, if it is no such table.
pub fn read_learning_table(folder: &Path) -> Result<Vec<LearningRow>, Error> {
    let path = folder.join(LEARNING_FILE);
    if !path.exists() {
        return Ok(Vec::new());
    }
    let bytes = files::read(&path)?;
    let refuse = |line: usize, what: String| {
        let mend = "learn again with `bodyschema learn`, which rewrites the table";
        Error::content(&path, Some(line), format!("{what}: {mend}"))
    };
    let mut rows: Vec<LearningRow> = Vec::new();
    for (k, row) in csv::Reader::from_reader(&bytes[..]).deserialize().enumerate() {
        let row: LearningRow = row.map_err(|error: csv::Error| {
            let fault = match error.kind() {
                csv::ErrorKind::UnequalLengths { expected_len, len, .. } => {
                    format!("it has {len} cells instead of {expected_len}")
                }
                _ => format!("not a row of learning ({error})"),
            };
            refuse(k + 2, fault)
        })?;
        let before = rows.last().map_or(0, |last| last.touches);
        if !(before..=MOST_TOUCHES).contains(&row.touches) {
            return Err(refuse(k + 2, format!("it is of {} touches, after {before}", row.touches)));
        }
        rows.push(row);
    }
    Ok(rows)
}
