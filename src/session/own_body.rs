//! What a session's creature knows of its body.

use std::path::Path;

use crate::creature::Posture;
use crate::error::Error;
use crate::evaluation::is_hand;
use crate::learning::Certainty;
use crate::named::listed;
use crate::peripersonal::OwnBody;
use crate::session::{
    LearningRecord, ReadLock, SCHEMA_FILE, Session, TOUCHES_FILE, read_schema, read_touches,
};

/// A session and what its creature knows of its body after it.
///
/// # Errors
/// If a file of it cannot be read, or nothing was touched or learned in it.
pub fn own_body(folder: &Path) -> Result<(Session, OwnBody), Error> {
    let _reading = ReadLock::take(folder)?;
    let session = Session::read(folder)?;
    let log = read_touches(&folder.join(TOUCHES_FILE), &session.agent)?;
    let own = learned(folder, &session, log.touches.iter().map(|touch| &touch.posture))?;
    if log.touches.is_empty() {
        return Err(Error::no_touch().at(folder, None));
    }
    Ok((session, own))
}

/// What a session's creature has learned of its body, and how sure that is, without what it experienced.
pub(crate) fn learned_body(folder: &Path) -> Result<OwnBody, Error> {
    let _reading = ReadLock::take(folder)?;
    learned(folder, &Session::read(folder)?, [])
}

/// What is known of the body of a session that felt some postures.
fn learned<'a>(
    folder: &Path,
    session: &Session,
    felt: impl IntoIterator<Item = &'a Posture>,
) -> Result<OwnBody, Error> {
    let creature = session.agent.creature();
    let schema = read_schema(&folder.join(SCHEMA_FILE), creature)?;
    let record = LearningRecord::read(folder, creature)?;
    let certainty = record.map_or(Certainty::Unknown, |record| record.certainty());
    Ok(OwnBody::new(&session.agent, schema, certainty, felt))
}

/// The limbs that reach: those that are named, else all with receptors whose names end in hand.
pub(crate) fn hands(own: &OwnBody, names: &[String]) -> Result<Vec<usize>, Error> {
    let (creature, limbs) = (own.creature(), own.creature().limbs());
    let touching: Vec<usize> = (1..limbs.len()).filter(|&limb| own.tip_of(limb).is_some()).collect();
    let choice = || listed(&touching.iter().map(|&limb| limbs[limb].clone()).collect::<Vec<_>>());
    if names.is_empty() {
        let is_named = |limb: &usize| limbs[*limb].ends_with("hand") && is_hand(creature, *limb);
        let hands: Vec<usize> = touching.iter().copied().filter(is_named).collect();
        if hands.is_empty() {
            return Err(Error::usage(format!(
                "{} has no limb with receptors whose name ends in hand: name one with --hand, of {}",
                creature.name(),
                choice()
            )));
        }
        return Ok(hands);
    }
    let named = |name: &String| {
        let limb = creature.limb(name).filter(|limb| touching.contains(limb));
        limb.ok_or_else(|| {
            Error::usage(format!(
                "--hand {name}: there is no such limb with receptors: choose one of {}",
                choice()
            ))
        })
    };
    let mut hands = names.iter().map(named).collect::<Result<Vec<usize>, Error>>()?;
    hands.dedup();
    Ok(hands)
}
