//! "What did you do?", "did you touch it?"

use super::super::Conversation;
use super::{Act, Answer, Intent, RequestKind};
use crate::interaction::conversation::language::Request;
use crate::interaction::conversation::mind::Deed;

/// How many of the last things that it did are told.
const LAST: usize = 4;

pub(super) const REPORT: RequestKind = RequestKind {
    told: &[
        "^ summarise|summarize|recap|recount|sum",
        "^ report",
        "tell|give ?me|us ?a|the ?short|brief story|summary|report|account|recap|rundown",
    ],
    asked: &[
        "what happen|occur",
        "what ?just|has|have happen",
        "summarise|summarize|recap|recount",
        "be you =done|finish|finished|successful",
        "be THING|SOME|that|it all ?done|finished|moved",
        "how do|be THING|that go|went|turn",
        "^ any luck|success|progress|news",
        "success|successful",
        "what you do",
        "what be the result|outcome|upshot",
        "what =went|=goes wrong|well|right|amiss",
    ],
    past: &[
        "what ?be the result|outcome|upshot",
        "THING|SOME go|work|happen|succeed|move|fall|fail",
        "you",
        "happen|occur",
        "^ ?so|and =did|=has|=had|=was THING|SOME|BODY",
        "success|luck|work",
        "BODY",
    ],
    ..RequestKind::new(["report", "reported"], Act::Tells(|creature, request| creature.report(request)))
};

impl Conversation {
    fn report(&self, request: &Request) -> Answer {
        // "What did you touch?" is about its own body as well.
        let asked = |deed: &&Deed| match request.about {
            Some(Intent::Touch) if request.open => deed.is(Intent::Touch) || deed.is(Intent::TouchOwn),
            Some(about) => deed.is(about),
            None => true,
        };
        let deeds: Vec<&Deed> = self.deeds.iter().filter(asked).collect();
        if request.open || request.about.is_none() {
            let told: Vec<&str> =
                deeds[deeds.len().saturating_sub(LAST)..].iter().map(|deed| deed.words.as_str()).collect();
            return Answer::tells(match told.as_slice() {
                [] if self.deeds.is_empty() => "I have not done anything yet".to_string(),
                [] => "I have done nothing of that kind".to_string(),
                told => format!("I {}", told.join("; then I ")),
            });
        }
        let doing = request.about.and_then(Intent::kind).map_or("do that", |kind| kind.doing[0]);
        Answer::tells(match (deeds.iter().rev().find(|deed| deed.done), deeds.last()) {
            (Some(deed), _) => format!("Yes: I {}", deed.words),
            (None, Some(deed)) => format!("No: I {}", deed.words),
            (None, None) => format!("No, I did not {doing}"),
        })
    }
}
