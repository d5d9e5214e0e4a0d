//! `bodyschema study merge`: merges shares made by several processes.

use std::path::{Path, PathBuf};

use super::{FILES, save};
use crate::cli::folders::{Force, new_folder};
use crate::cli::{Failure, Outcome};
use crate::named::listed;
use crate::session::{FolderLock, STUDY_FILE};
use crate::study::{Findings, Unready, made_shares};
use crate::view::text::shell_words;

/// Merge the shares of a study.
///
/// The shares were made by separate processes, with `study … --shard 1/16 --out DIR` and so on. The table is byte for byte
/// what a single process would have written. Missing and interrupted shares are listed; only those have to be made again.
/// The command can be repeated at any time and resumes where it was interrupted.
#[derive(clap::Args)]
#[command(after_help = "Examples:
  bodyschema study merge studies/many
  bodyschema study merge studies/many --missing      # shares still to be made, such as 4,7
See docs/many.md for scripts that make all shares with Slurm, GNU parallel or HyperQueue.")]
pub struct MergeArguments {
    /// The folder given to all shares with --out
    folder: PathBuf,
    /// Only print the numbers of missing and interrupted shares, separated by commas
    #[arg(long)]
    missing: bool,
    /// Print one JSON object
    #[arg(long, help_heading = "Output")]
    json: bool,
}

pub fn run(args: &MergeArguments) -> Outcome {
    let folder = &args.folder;
    let found = made_shares(folder)?;
    if args.missing {
        let unready = found.err().unwrap_or_default().shares;
        let numbers: Vec<String> = unready.iter().map(|(share, _)| share.number.to_string()).collect();
        say!("{}", numbers.join(","));
        return Ok(());
    }
    let made = found.map_err(|unready| refusal(folder, &unready))?;
    if folder.join(STUDY_FILE).exists() {
        // One who was killed when all was done left nothing to do but this.
        drop(FolderLock::take(folder)?);
        tell!("{} is complete: nothing left to do", folder.display());
        return Ok(());
    }
    let findings = Findings::of_shares(&made)?;
    let lock = new_folder(folder, Force::default(), "study", &FILES)?;
    save(&findings, &lock, args.json)
}

/// What is to be done before shares can be put together.
fn refusal(folder: &Path, unready: &Unready) -> Failure {
    let all = &unready.shares;
    let what = [("missing", false), ("not finished", true)].into_iter().filter_map(|(how, begun)| {
        let shares = all.iter().filter(|share| share.1 == begun);
        let shares: Vec<String> = shares.map(|(share, _)| share.to_string()).collect();
        (!shares.is_empty()).then(|| format!("{how}: {}", listed(&shares)))
    });
    let what = what.collect::<Vec<_>>().join("; ");
    let first = all.first().map_or(String::new(), |(share, _)| format!(" with --shard {share}"));
    let rest = if all.len() > 1 { ", and so on" } else { "" };
    let like = match shell_words(&unready.command) {
        command if command.is_empty() => String::new(),
        command => format!("; the others were made as in `{command}`"),
    };
    Failure::at(folder, format_args!("some shares are {what}: make them{first}{rest}{like}"))
}
