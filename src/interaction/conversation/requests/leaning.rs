//! "Lean forward and try again."

use super::super::Request;
use super::{Heard, RequestKind};

pub(super) const LEAN_AND_RETRY: RequestKind = RequestKind {
    means: |heard: &Heard| heard.any(&["lean", "leaning"]),
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
