//! "What can you do?", and what it says where it did not understand.

use super::super::Conversation;
use super::super::grammar::UnknownWord;
use super::{Act, Answer, Intent, Reply, RequestKind};

/// What it can do, as it says it.
const ABILITIES: &str = "I can feel about for things (\"is there something in front of you?\"), touch what I felt with either \
hand, feel its shape, pick it up, put it as far away as possible, bring it near, let go; take a \
stick and touch with it; touch my own body (\"touch your nose\"); \
tell where a thing or a part of me is, how far, how many, how big, and whether I reach it; lean forward and back; get out of the \
way of what comes; tell what I did; forget, do it again, rest, keep still. \"Quit\" ends our talk";

pub(super) const HELP: RequestKind = RequestKind::new(
    ["help", "helped"],
    Act::Tells(|_, _| Answer::tells(ABILITIES)),
)
.told(
    "show me what you can|do ; ^ usage|manual|instructions|commands|options|menu $ ; assist|help me $ ; \
         give|show ?me|us .. COMMANDS ; list COMMANDS ; guide|instruct|help|assist|teach me ; \
         give ?me a|some|any COMMANDS ; walk me through ; what you have got|get",
)
.asked(
    "what ?all you can|could|may do ; how this|THING|that work ; what to SPEAK|TELL|do ; \
         what ?else|ALL|things|KIND|sort ?of ?SOME|THING HELPING you|i|we \
         do|TELL|SPEAK|understand|make|perform|offer|KNOW|try|want|request|DO ; \
         what ?KIND|THING|SOME ?of ?THING|SOME HELPING i|we|you ; what be you able|capable|good|for ; \
         what|which|list|TELL|your|all|give|any ?ALL|of ?THING|your|ALL|be ?your COMMANDS ; \
         help ?me|us ?out $ ; how HELPING|do i|we SPEAK|USE|TELL|get|make|work|GIVE ; your COMMANDS ; \
         what HELPING i|we SPEAK|TELL|do|try|want ; what be possible ; \
         what be my|the options|choices|possibilities ; what HELPING be =done|=asked|=said|done|asked ; \
         be there ?any COMMANDS|help ; TELL ?me what you HELPING|KNOW|do|understand ; \
         what you HELPING|understand|KNOW $ ; how .. ?to USE you ; what KIND|sort .. requests|COMMANDS ; \
         what i HELPING|do ; how HELPING i ; be there SOME ?that you HELPING ; \
         how do one|somebody|people SPEAK|USE ; THING|SOME ?that you HELPING do ; \
         how do you work|function ; any COMMANDS ; what next|now|else $ ; \
         show me what you ?have ?got|can|know ; ^ COMMANDS",
)
.said(
    "^ help ; ^ i =need|=want .. help|assistance ; ^ i could|can ?use ?some help ; \
         ^ how do|does THING|it work ; ^ i be stuck|lost|confused ; what should i ; ^ what next|now $ ; \
         ^ guide|instruct|assist me ; ^ COMMANDS ?please $ ; ^ sos",
);

impl Conversation {
    /// What it says where it did not understand: why, and three examples that fit what it knows by now.
    pub(in super::super) fn not_understood(&self, unknown: &[UnknownWord]) -> Reply {
        let examples =
            match (self.things.is_empty(), self.things.iter().any(|known| known.in_touch.is_some())) {
                (true, _) => ["is there something in front of you?", "touch your nose", "what can you do?"],
                (false, false) => {
                    ["touch it with your left hand", "is it near or far?", "is there anything else?"]
                }
                (false, true) => [
                    "where do you feel this?",
                    "touch it with your other hand",
                    "put it as far away as possible",
                ],
            };
        let told = match unknown {
            [] => "I did not understand that".to_string(),
            [word, ..] => word.in_words(),
        };
        let said = format!(
            "{told}. I understand, for example: \"{}\", \"{}\", \"{}\"",
            examples[0], examples[1], examples[2]
        );
        self.reply(Intent::Unknown, Answer::tells(said))
    }
}
