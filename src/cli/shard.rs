//! `bodyschema babble --shard`: one share of a session, for `bodyschema study merge` to put together with the others.

use std::path::Path;

use serde_json::json;

use super::babbling::{BabbleArguments, Prepared};
use super::progress::Bars;
use super::{Failure, Outcome, output};
use crate::session::{
    BabblingSession, FolderLock, Provenance, ResumedSession, SESSION_FILE, SHARES_FOLDER, Shares,
};
use crate::share::Share;

/// Makes a share in its place below a folder, or what is missing of it.
pub fn run(prepared: &Prepared, args: &BabbleArguments, share: Share, folder: &Path) -> Outcome {
    let lock = take_share(folder, share, SESSION_FILE)?;
    let place = lock.folder();
    let provenance = Provenance { command: output::command_line(), asked: prepared.asked(args) };
    let (embodied, setup) = (&prepared.embodied, &prepared.setup);
    let session = match BabblingSession::take_up(embodied, setup, &lock, provenance)? {
        ResumedSession::Babbled(babbled) => {
            tell!("{} is complete: nothing is left to do", place.display());
            babbled.session
        }
        ResumedSession::Babbling(babbling) => {
            if babbling.made() > 0 {
                tell!("{}: going on after touch {}", place.display(), babbling.made());
            }
            babbling.babble(&Bars::default())?.session
        }
    };
    if let Some(effort) = session.effort.filter(|effort| effort.touches == Some(0)) {
        tell!("nothing was touched in {} motions of this share", effort.of_motions.motions);
    }
    let touches = session.effort.and_then(|effort| effort.touches).unwrap_or_default();
    if args.json {
        return output::json(&json!({
            "share": share.to_string(),
            "touches": touches,
            "motions": session.effort.map(|effort| effort.of_motions.motions),
            "babbling_s": session.effort.map(|effort| effort.babbling_s),
            "folder": place,
        }));
    }
    say!("share {share}: {touches} touches, in {}", place.display());
    say!("next, when all {} shares are made: `bodyschema study merge {}`", share.of(), folder.display());
    Ok(())
}

/// Takes the place of a share below a folder, which is made; `whole` is a file that is in a folder of work that was not
/// cut into shares.
pub fn take_share(folder: &Path, share: Share, whole: &str) -> Result<FolderLock, Failure> {
    if folder.join(whole).exists() && !folder.join(SHARES_FOLDER).exists() {
        return Err(Failure(format!(
            "{} holds work that was not cut into shares ({whole}): give another folder with --out",
            folder.display()
        )));
    }
    let place = Shares::folder(folder, share);
    Ok(FolderLock::make(&place)?)
}
