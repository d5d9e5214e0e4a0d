//! `bodyschema convert`: a session for programs that read tables, or that show what happened over time.

use std::path::{Path, PathBuf};

use super::folders::written_session;
use super::learned::warn_truncated;
use super::{Outcome, progress};
use crate::record::{ReadLock, Session, TOUCHES_FILE, read_touches};
use crate::senses::Touch;

/// Write a session for other programs: its touches as a table, or bodies, touches and errors over time.
///
/// A Parquet file has a row per touch and a column per number, names beside them: for long sessions, which it stores in
/// a fraction of the space, and of which data frames read single columns. A Rerun file has the true body and the learned
/// one in the posture of every touch, the two receptors and the place, and the errors of learning.csv.
#[derive(clap::Args)]
#[command(
    group = clap::ArgGroup::new("form").required(true).args(["parquet", "rrd"]),
    after_help = "Examples:
  bodyschema convert sessions/max-1 --parquet
  bodyschema convert sessions/max-1 --parquet --out touches.parquet
  bodyschema convert sessions/max-1 --rrd
  bodyschema convert sessions/max-1 --rrd --model mjcf/max/max.xml --out max.rrd"
)]
pub struct ConvertArguments {
    /// The session's folder
    session: PathBuf,
    /// Parquet, which pandas, Polars, DuckDB and Arrow read
    #[arg(long)]
    parquet: bool,
    /// Rerun, for its viewer
    #[arg(long)]
    rrd: bool,
    /// The model with the true body, where it is not at the path in the session
    #[arg(long, conflicts_with = "parquet")]
    model: Option<PathBuf>,
    /// The file to write [default: touches.parquet or session.rrd in the session's folder]
    #[arg(long, short, value_name = "FILE", help_heading = "Output")]
    out: Option<PathBuf>,
}

pub fn run(args: &ConvertArguments) -> Outcome {
    // What goes beside the session's own files is made of them as they are.
    let _lock = args.out.is_none().then(|| written_session(&args.session)).transpose()?;
    let _reading = ReadLock::take(&args.session)?;
    let session = Session::read(&args.session)?;
    let log = read_touches(&args.session.join(TOUCHES_FILE), &session.agent)?;
    warn_truncated(&log, &args.session);
    let name = if args.rrd { "session.rrd" } else { "touches.parquet" };
    let path = args.out.clone().unwrap_or_else(|| args.session.join(name));
    let spinner = progress::spinner("writing");
    if args.rrd {
        write_rrd(args, &path, &session, &log.touches)?;
    } else {
        write_parquet(&path, &session, &log.touches)?;
    }
    spinner.finish_and_clear();
    say!("{}: {} touches", path.display(), log.touches.len());
    Ok(())
}

#[cfg(feature = "parquet")]
fn write_parquet(path: &Path, session: &Session, touches: &[Touch]) -> Outcome {
    Ok(crate::record::write_parquet(path, &session.agent, touches)?)
}

#[cfg(not(feature = "parquet"))]
fn write_parquet(path: &Path, _: &Session, _: &[Touch]) -> Outcome {
    Err(super::Failure(format!(
        "{}: this bodyschema was built without Parquet: install it with `cargo install --path . --features parquet`",
        path.display()
    )))
}

#[cfg(feature = "rerun")]
fn write_rrd(args: &ConvertArguments, path: &Path, session: &Session, touches: &[Touch]) -> Outcome {
    use super::Failure;
    use crate::record::{Checkpoint, LearningRecord, SCHEMA_FILE, read_learning_table, read_schema};
    use crate::view::{RerunInput, write_rrd};

    let (folder, creature) = (&args.session, session.agent.creature());
    let truth = super::open::known_truth(session, args.model.as_deref())?;
    let record = LearningRecord::read(folder, creature)?;
    let mut checkpoints = record.map_or(Vec::new(), |record| record.checkpoints);
    // Sessions from before there were checkpoints have what was learned in the end.
    if checkpoints.is_empty() && folder.join(SCHEMA_FILE).exists() {
        let schema = read_schema(&folder.join(SCHEMA_FILE), creature)?;
        checkpoints.push(Checkpoint { touches: touches.len(), schema, error_rms: None, bound_rms: None });
    }
    if truth.is_none() && checkpoints.is_empty() {
        return Err(Failure(format!(
            "{}: there is neither a true body nor a learned one to show: learn with `bodyschema learn`, or name the \
             creature's model with --model",
            folder.display()
        )));
    }
    let table = read_learning_table(folder)?;
    let input = RerunInput {
        agent: &session.agent,
        truth: truth.as_ref().map(|truth| &truth.schema),
        touches,
        checkpoints: &checkpoints,
        table: &table,
    };
    write_rrd(path, &input).map_err(|error| {
        Failure(format!("cannot write {}: {error}: give another file with --out", path.display()))
    })
}

#[cfg(not(feature = "rerun"))]
fn write_rrd(_: &ConvertArguments, path: &Path, _: &Session, _: &[Touch]) -> Outcome {
    Err(super::Failure(format!(
        "{}: this bodyschema was built without Rerun: install it with `cargo install --path . --features rerun`",
        path.display()
    )))
}
