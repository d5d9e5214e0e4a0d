//! `bodyschema babble`: the main job.

use super::babbling::{BabbleArguments, Prepared};
use super::folders::session_folder;
use super::{Outcome, output};
use crate::session::{BabblingSession, Provenance};

pub fn run(args: &BabbleArguments) -> Outcome {
    if let Some(folder) = &args.resume {
        return super::resume::run(folder, args);
    }
    let prepared = Prepared::new(args)?;
    if let (Some(share), Some(folder)) = (args.shard, &args.out) {
        return super::shard::run(&prepared, args, share, folder);
    }
    let lock = session_folder(args.out.as_deref(), prepared.embodied.creature().name(), args.force)?;
    let provenance = Provenance { command: output::command_line(), asked: prepared.asked(args) };
    let session = BabblingSession::begin(&prepared.embodied, &prepared.setup, &lock, provenance)?;
    prepared.babble(args, lock, session)
}
