//! "Hello", "who are you?", "thank you".

use super::{Act, Answer, RequestKind};

pub(super) const GREET: RequestKind = RequestKind::new(
    ["", ""],
    Act::Tells(|_, _| Answer::tells("Hello. I cannot see you, but I hear you: what shall I do?")),
)
.asked(
    "how be THING|life|everything|things|you|ALL ?going ; how do you do ; \
         you|are|be ?you ok|okay|alright|well $ ; what be UP $ ; ^ be you there|=awake|wake $ ; \
         ^ you =awake $ ; ^ YES max ; what be new",
)
.said(
    "GOOD to MEET|meet|see you ; i be back ; how have you be ; ^ HELLO ; \
         ^ GOOD|good morning|afternoon|evening|day ; how be|do you ?doing|feeling|today|going|do ; \
         ^ morning|evening|afternoon ; long time no see ; ^ HELLO there|BEING ; good to be back ; \
         make your acquaintance",
);

pub(super) const THANKS: RequestKind =
    RequestKind::new(["", ""], Act::Tells(|_, _| Answer::tells("You are welcome")))
        .past(
            "THANKS ; not thank you ; you =have =been ?GOOD help|GOOD ; you =did GOOD ; \
         ^ that be ?so GOOD ?of ?you ; i like how|what|that ; you nail THING ; well =played",
        )
        .said(
            "THANKS ?you|THING|many|much ?for|very|ALL|so ?THING|your ?help|much ; you be =doing well|GOOD ; \
         owe you ; impressed ; not thank you ; THANKS ; well|nicely =done|do ; ^ GOOD BEING|boy|one ; \
         ^ GOOD ?one $ ; GOOD of you ; GOOD job|work|effort ; how kind ; THING be ?so ?very GOOD ; \
         you be GOOD ; you be a|the GOOD ; ^ nice|good|lovely|great one ; way to go ; \
         i be ?so|very|really GOOD|THANKS|grateful ; very|so GOOD ; ^ what a GOOD ; \
         ^ GOOD job|work|stuff|BEING|going|one ; ^ GOOD $ ; you nail THING ; you rock ; well play|=played ; \
         i like how|what|that ; THING will do nicely",
        );

pub(super) const WHO: RequestKind = RequestKind::new(
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
    .told(
    "INTRODUCE yourself ; TELL|give ?me|us ?your who|name|yourself $ ; \
         TELL ?me ?SOME|MORE ?BIT about yourself ; identify yourself",
)
    .asked(
    "who HELPING|be you ; who you be ; who i be ?=talking|=speaking ; your name ; \
         who|what ?you|exactly be you ; who|whom do|be|have i|we have|the|TELL|=talking|=speaking|SPEAK ; \
         which|what KIND|BEING ?of ?BEING|THING|SOME be|are you ; your purpose|function|job|name ; \
         ^ ?and you be $ ; what be your name ; you have name ; what be you $ ; \
         be you ?called|named BEING|real|alive|virtual|SOME|max ; you be max ; INTRODUCE yourself ; \
         how be you =called ; call|named|name you ; you be BEING|right|real ; \
         who be =speaking|=talking|there|this ; people call you ; TELL .. who you be ; \
         what you be|call|called ; about yourself ; what HELPING|be i call you ; be this|that BEING ; \
         you be who ; who go|be there|this ; which|what BEING be this|THING|you ; what be this program ; \
         identify|introduce yourself ; state ?your name",
);
