//! "Hello", "who are you?", "thank you".

use super::{Act, Answer, RequestKind};

pub(super) const GREET: RequestKind = RequestKind {
    asked: &[
        "how be THING|life|everything|things going",
        "how be THING|life $",
        "you|are|be ?you ok|okay|alright|well $",
    ],
    said: &[
        "^ hello|hi|hey|hiya|howdy|greetings|welcome|yo|salutations",
        "^ good morning|afternoon|evening|day",
        "^ ?it ?be nice|pleased|good|lovely|glad|great|pleasure|delighted to|meeting|seeing ?meet|see|you",
        "how be|do you ?doing|feeling|today|going|do|$",
        "^ morning|evening|afternoon",
        "how have you be",
        "long time no see",
    ],
    ..RequestKind::new(
        ["", ""],
        Act::Tells(|_, _| Answer::tells("Hello. I cannot see you, but I hear you: what shall I do?")),
    )
};

pub(super) const THANKS: RequestKind = RequestKind {
    said: &[
        "thank|thanks|grateful|ta|appreciate|appreciated|thankful|cheers|obliged|indebted|kudos|bravo",
        "^ well|nicely do|done",
        "^ good|clever|nice boy|man|robot|one",
        "kind|good|nice|sweet of you",
        "you have be|being ?a|of ?great|big|real help|helpful|useful",
        "good|great|nice|excellent|perfect|brilliant|wonderful|fantastic|awesome|lovely job|work",
        "^ good|great|nice|excellent|perfect|brilliant|wonderful|fantastic|awesome|lovely ?one $",
        "very|so|most|how kind",
        "that|THING be ?very|really|so ?a good|great|nice|perfect|kind|helpful|excellent|lovely|well|brilliant|help",
        "you be ?very|so|a|really|most kind|helpful|great|good|best",
    ],
    ..RequestKind::new(["", ""], Act::Tells(|_, _| Answer::tells("You are welcome")))
};

pub(super) const WHO: RequestKind = RequestKind {
    told: &[
        "introduce|present yourself",
        "say|tell|give ?me|us ?your who|name|yourself $",
        "tell me ?SOME|more|a ?bit|little about yourself",
    ],
    asked: &[
        "who might|may|would you be",
        "who ?exactly you be",
        "who be you",
        "who|whom do i|we have the",
        "which|what creature|robot|being|person be you",
        "your purpose|function|job",
        "^ ?and you be $",
        "what ?kind|sort|type ?of =being",
        "^ who be =speaking|=talking|there",
        "your name",
        "have ?you a name",
        "what be you ?exactly|call|name|then|anyway $",
        "be you ?really ?a|an|the|called|named human|robot|real|person|machine|alive|virtual|computer|man|max|creature",
        "what|which kind|sort|type of THING|creature|robot|being|person|machine be|are|do you",
        "who|whom do|am|have|be i|we ?have talk|talking|speak|speaking|deal|dealing",
        "introduce yourself",
        "how be you called",
        "call|named you",
    ],
    ..RequestKind::new(
        ["tell who I am", "told who I am"],
        Act::Tells(|creature, _| {
            let name = creature.actor.own.creature().name();
            let mut capital = name.chars();
            let name =
                capital.next().map_or(String::new(), |first| first.to_uppercase().chain(capital).collect());
            Answer::tells(format!(
                "I am {name}. I am blindfolded: I know my body from touching myself, and what is about me from what I feel"
            ))
        }),
    )
};
