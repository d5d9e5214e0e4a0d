//! `bodyschema convert`: a session's touches for programs that read tables.

use std::path::{Path, PathBuf};

use super::learn_options::warn_truncated;
use super::{Outcome, progress};
use crate::record::{Session, TOUCHES_FILE, read_touches};

/// Write a session's touches as a table for other programs.
///
/// A Parquet file has a row per touch and a column per number, names beside them: for long sessions, which it stores in
/// a fraction of the space, and of which data frames read single columns.
#[derive(clap::Args)]
#[command(after_help = "Examples:
  bodyschema convert sessions/max-1 --parquet
  bodyschema convert sessions/max-1 --parquet --out touches.parquet")]
pub struct Args {
    /// The session's folder
    session: PathBuf,
    /// Parquet, which pandas, Polars, DuckDB and Arrow read
    #[arg(long, required = true)]
    parquet: bool,
    /// The file to write [default: touches.parquet in the session's folder]
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,
}

pub fn run(args: &Args) -> Outcome {
    let session = Session::read(&args.session)?;
    let log = read_touches(&args.session.join(TOUCHES_FILE), &session.creature, &session.skin)?;
    warn_truncated(&log, &args.session);
    let path = args.out.clone().unwrap_or_else(|| args.session.join("touches.parquet"));
    let spinner = progress::spinner("writing");
    write(&path, &session, &log.touches)?;
    spinner.finish_and_clear();
    say!("{}: {} touches", path.display(), log.touches.len());
    Ok(())
}

#[cfg(feature = "parquet")]
fn write(path: &Path, session: &Session, touches: &[crate::senses::Touch]) -> Outcome {
    Ok(crate::record::write_parquet(path, &session.creature, &session.skin, touches)?)
}

#[cfg(not(feature = "parquet"))]
fn write(path: &Path, _: &Session, _: &[crate::senses::Touch]) -> Outcome {
    Err(super::Failure(format!(
        "{}: this bodyschema was built without Parquet: install it with `cargo install --path . --features parquet`",
        path.display()
    )))
}
