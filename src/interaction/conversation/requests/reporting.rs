//! "What did you do?", "did you touch it?"

use super::super::{Conversation, Request};
use super::{Act, Answer, RequestKind};

/// How many of the last things that it did are told.
const LAST: usize = 4;

pub(super) const REPORT: RequestKind = RequestKind {
    told: &[
        "^ summarise|summarize|recap|recount|sum",
        "^ report",
        "tell|give ?me|us ?a|the ?short|brief story|summary|report|account|recap|rundown",
    ],
    asked: &[
        "summary|report|account|recap|story|rundown|log",
        "what happen|occur",
        "what ?just|has|have happen",
        "summarise|summarize|recap|recount",
        "be you =done|finish|finished|successful",
        "be THING|SOME|that|it all ?done|finished|moved",
        "how do|be THING|that go|went|turn",
        "^ any luck|success|progress|news",
        "success|successful",
        "what you do",
    ],
    past: &[
        "THING|SOME go|work|happen|succeed|move|fall",
        "you",
        "happen|occur",
        "^ ?so|and =did|=has|=had|=was THING|SOME|BODY",
        "success|luck|work",
        "BODY",
        "^ be THING|it",
        "recount|recap|report|summarise|summarize",
    ],
    ..RequestKind::new(["report", "reported"], Act::Tells(|creature, request| creature.report(request)))
};

impl Conversation {
    fn report(&self, request: &Request) -> Answer {
        let Some(about) =
            request.about.filter(|about| !request.open || self.deeds.iter().any(|deed| deed.is(*about)))
        else {
            let from = self.deeds.len().saturating_sub(LAST);
            let told: Vec<String> = self.deeds[from..].iter().map(|deed| deed.words.clone()).collect();
            return Answer::tells(match told.as_slice() {
                [] => "I have not done anything yet".to_string(),
                told => format!("I {}", told.join("; then I ")),
            });
        };
        if request.open {
            let told: Vec<&str> =
                self.deeds.iter().filter(|deed| deed.is(about)).map(|deed| deed.words.as_str()).collect();
            let from = told.len().saturating_sub(LAST);
            return Answer::tells(format!("I {}", told[from..].join("; then I ")));
        }
        let did: Vec<_> = self.deeds.iter().filter(|deed| deed.is(about)).collect();
        let [doing, _] = about.kind().map_or(["do that", "did that"], |kind| kind.doing);
        Answer::tells(match (did.iter().rev().find(|deed| deed.done), did.last()) {
            (Some(deed), _) => format!("Yes: I {}", deed.words),
            (None, Some(deed)) => format!("No: I {}", deed.words),
            (None, None) => format!("No, I did not {doing}"),
        })
    }
}
