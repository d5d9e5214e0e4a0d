//! "What did you do?", "did you touch it?"

use super::super::Conversation;
use super::{Act, Answer, Intent, RequestKind};
use crate::interaction::conversation::grammar::Request;
use crate::interaction::conversation::mind::Deed;

/// How many of the last things that it did are told.
const LAST: usize = 4;

pub(super) const REPORT: RequestKind =
    RequestKind::new(["report", "reported"], Act::Tells(|creature, request| creature.report(request)))
        .told(
            "^ summarise|summarize|recap|recount|sum ; ^ report ; \
         TELL|give ?me|us ?short|brief story|summary|report|account|recap|rundown ; \
         update|brief|debrief me ; fill me in ; the result|outcome|upshot|summary|story",
        )
        .asked(
            "what HAPPEN ; if|whether THING|that|you =worked|work|PAST|have|did ; what you =did|=have|PAST ; \
         TELL .. whether|if you =have|=did ; how many times ; what =went ; what ?have HAPPEN ; \
         TELL|say what HAPPEN ; how do|be THING|that go|went|turn ; success|successful ; \
         what be result|outcome|upshot ; what =went|=goes wrong|well|right ; \
         be you|THING|ALL =done|=finished|finish|successful|through ; any luck|success|progress|news ; \
         summary|report|recap|recount ; status|progress ; TELL .. you =did|=done|=did|PAST ; \
         what be|have you|HAND =doing|=done ; ^ ?ALL =done|=finished $ ; \
         any luck|joy|success|progress|news|result ; how would THING go ; =going|=happening on ; \
         the result|outcome|upshot",
        )
        .past(
            "you ; what be that $ ; what|how|where =went|go ; how many time|times & you ; \
         what be the result|outcome|upshot ; you|BODY|HAND|THING|SOME PAST ; \
         what ?be result|outcome|upshot ; THING|SOME GO|work|HAPPEN|succeed|fall|fail ; HAPPEN ; \
         ^ ?so|and =did|=has|=had|=was|=have THING|SOME|BODY|you ; success|luck|work|successful ; BODY ; \
         which HAND ; what|which ?THING .. you ; THING =moved|=put|=done ; anything ; how THING|that go ; \
         be THING PAST ; ^ HELPING|be you|THING|SOME ; how .. THING .. turn|go|went|work ; \
         be there ?any problem|trouble|difficulty ; how .. that ; problem|trouble ; everything GO|work ; \
         what come|came of|out ; your|the last|latest|previous ANY ; how many .. =need|need ; \
         what have =been",
        );

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
