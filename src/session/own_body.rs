//! What a session's creature knows of its body.

use std::path::Path;

use super::words::listed;
use crate::error::Error;
use crate::evaluation::is_hand;
use crate::learning::Certainty;
use crate::peripersonal::OwnBody;
use crate::session::{
    LearningRecord, ReadLock, SCHEMA_FILE, Session, TOUCHES_FILE, read_schema, read_touches,
};

/// A session and what its creature knows of its body after it.
///
/// # Errors
/// Where a file of it cannot be read, or nothing was touched or learned in it.
pub fn own_body(folder: &Path) -> Result<(Session, OwnBody), Error> {
    let _reading = ReadLock::take(folder)?;
    let session = Session::read(folder)?;
    let agent = &session.agent;
    let creature = agent.creature();
    let log = read_touches(&folder.join(TOUCHES_FILE), agent)?;
    let schema = read_schema(&folder.join(SCHEMA_FILE), creature)?;
    if log.touches.is_empty() {
        return Err(Error::no_touch().at(folder, None));
    }
    let record = LearningRecord::read(folder, creature)?;
    let certainty = record.map_or(Certainty::Unknown, |record| record.certainty());
    let own = OwnBody::new(agent, schema, certainty, log.touches.iter().map(|touch| &touch.posture));
    Ok((session, own))
}

/// What a session's creature has learned of its body, and how sure that is, without what it experienced.
///
/// # Errors
/// Where a file of it cannot be read.
pub fn learned_body(folder: &Path) -> Result<OwnBody, Error> {
    let _reading = ReadLock::take(folder)?;
    let session = Session::read(folder)?;
    let creature = session.agent.creature();
    let schema = read_schema(&folder.join(SCHEMA_FILE), creature)?;
    let record = LearningRecord::read(folder, creature)?;
    let certainty = record.map_or(Certainty::Unknown, |record| record.certainty());
    Ok(OwnBody::new(&session.agent, schema, certainty, &[]))
}

/// The limbs that reach: those that are named, else all with receptors whose names end in hand.
///
/// # Errors
/// Where a name is of no such limb, or there is none.
pub fn hands(own: &OwnBody, names: &[String]) -> Result<Vec<usize>, Error> {
    let limbs = own.creature().limbs();
    let touching: Vec<String> =
        (1..limbs.len()).filter(|&limb| own.tip_of(limb).is_some()).map(|limb| limbs[limb].clone()).collect();
    let named = |name: &String| {
        let limb = own.creature().limb(name).filter(|limb| touching.contains(&limbs[*limb]));
        let choice = listed(&touching);
        limb.ok_or_else(|| {
            Error::usage(format!(
                "--hand {name}: there is no such limb with receptors: choose one of {choice}"
            ))
        })
    };
    if !names.is_empty() {
        let mut hands = names.iter().map(named).collect::<Result<Vec<usize>, Error>>()?;
        hands.dedup();
        return Ok(hands);
    }
    let hands: Vec<usize> = (1..limbs.len())
        .filter(|&limb| limbs[limb].ends_with("hand") && is_hand(own.creature(), limb))
        .collect();
    let hands: Vec<usize> = hands.into_iter().filter(|&limb| touching.contains(&limbs[limb])).collect();
    if hands.is_empty() {
        return Err(Error::usage(format!(
            "{} has no limb with receptors whose name ends in hand: name one with --hand, of {}",
            own.creature().name(),
            listed(&touching)
        )));
    }
    Ok(hands)
}
