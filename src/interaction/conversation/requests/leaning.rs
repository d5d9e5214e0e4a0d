//! "Lean forward and try again."

use super::super::Request;
use super::{RequestKind, Utterance};

pub(super) const LEAN_AND_RETRY: RequestKind = RequestKind {
    means: |utterance: &Utterance| utterance.any(&["lean", "leaning"]),
    needs_body: false,
    needs_thing: false,
    act: |creature, request| match creature.last {
        Some(last) => {
            creature.act(Request { intent: last.intent, hand: request.hand.or(last.hand), lean: true })
        }
        None => {
            let said = "There is nothing yet that I could try again leaning".into();
            Ok(creature.reply(request.intent, said, Some(false), false))
        }
    },
};
