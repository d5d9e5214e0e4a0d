//! "What can you do?", and what it says where it did not understand.

use super::super::Conversation;
use super::{Act, Answer, Intent, Reply, RequestKind};

/// What it can do, as it says it.
const ABILITIES: &str = "I can feel about for things (\"is there something in front of you?\"), touch what I felt with either \
hand, feel its shape, pick it up, put it as far away as possible, bring it near, let go; take a \
stick and touch with it; touch my own body (\"touch your nose\"); \
tell where a thing or a part of me is, how far, how many, how big, and whether I reach it; lean forward and back; get out of the \
way of what comes; tell what I did; forget, do it again, rest, keep still. \"Quit\" ends our talk";

pub(super) const HELP: RequestKind = RequestKind {
    told: &[
        "show me what you can|do",
        "^ usage|manual|instructions|commands|options $",
        "assist|help me $",
        "^ menu $",
        "give|show ?me|us .. example|examples",
    ],
    asked: &[
        "what ?else|all|exactly|things|sort|kind ?of ?SOME|THING can|could|may you|i do|ask|say|tell|understand|make|perform|type|offer|know|have",
        "what be you able|capable|good|for",
        "what|which|list ?all|of ?THING|the|your|all ?SOME commands|command|abilities|ability|skills|options|instructions|requests|functions|features|actions|tasks|tricks|sentences|questions|capabilities|words",
        "what|which ?sort|kind|sorts|kinds|type ?of ?SOME|THING|things|stuff i|one|we can|could|may|might ask|say|tell|request|type|want|try",
        "help ?me|us ?out $",
        "how can|do|should|may|must|shall i|we ask|use|command|instruct|talk|speak|control|make|tell|get|work|operate|give",
        "your abilities|skills|commands|capabilities|options|instructions|talents|functions|features|repertoire",
        "what should|shall|must|might|can i|we ask|say|do|tell|type|request|try|want",
        "what be possible",
        "what|which ?sort|kind ?of THING|SOME can|may|could i|we ask|say|tell|request|give",
        "what be my|the options|choices|possibilities",
        "what can|may be done|asked|said",
        "what|which kind|sort|sorts|kinds|type|types of requests|commands|tasks|requests|SOME can|could|do you|i",
        "do you need|have ?any|a instructions|manual",
        "be there ?a|any manual|instructions|help",
        "tell me what you can|know|do|understand",
        "what you can|understand|know $",
        "what ?sort|kind|type|sorts|kinds ?of ?THING|SOME do you understand|know|obey|follow",
        "how .. ?to use you",
        "what can|could you help ?me ?with",
    ],
    said: &[
        "^ help",
        "^ i need|want .. help|assistance",
        "^ i could|can use ?some help",
        "^ how do|does this|THING|it work",
        "^ i be stuck|lost|confused",
        "^ i do not know what|how to",
    ],
    ..RequestKind::new(["help", "helped"], Act::Tells(|_, _| Answer::tells(ABILITIES)))
};

impl Conversation {
    /// What it says where it did not understand: why, and three examples that fit what it knows by now.
    pub(in super::super) fn not_understood(&self, unknown: &[String]) -> Reply {
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
            [word] => format!("I do not know the word \"{word}\""),
            [first, .., last] => format!("I do not know words like \"{first}\" and \"{last}\""),
        };
        let said = format!(
            "{told}. I understand, for example: \"{}\", \"{}\", \"{}\"",
            examples[0], examples[1], examples[2]
        );
        self.reply(Intent::Unknown, format!("{said}."), None, false)
    }
}
