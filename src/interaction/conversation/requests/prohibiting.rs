//! "Don't touch it": does nothing, and remembers.

use super::{Act, Answer, Intent, RequestKind};

pub(super) const DONT: RequestKind = RequestKind::new(
    ["", ""],
    Act::Minds(|mind, request| {
        let Some(intent) = request.about else {
            return Answer::done("All right, I do not do that");
        };
        let doing = intent.kind().map_or("do that", |kind| kind.doing[0]);
        let doing = match (&request.part, intent) {
            (Some(part), Intent::TouchOwn) => format!("touch my {}", part.text()),
            _ => doing.to_string(),
        };
        mind.forbid(intent, request.part.clone());
        Answer::done(format!("All right, I will not {doing}"))
    }),
);
