//! "How many things are there?": tells how many it has felt.

use super::{Act, Answer, RequestKind};

pub(super) const HOW_MANY: RequestKind = RequestKind::new(
    ["count the things", "counted the things"],
    Act::Tells(|creature, _| {
        let places: Vec<String> = creature.things.iter().map(|known| creature.place(&known.at)).collect();
        let said = match places.as_slice() {
            [] => "I have felt no thing so far".to_string(),
            [one] => format!("I have felt one thing: {one}"),
            places => format!("I have felt {} things: {}", places.len(), places.join("; ")),
        };
        Answer::tells(format!("{said}{}", creature.not_searched()))
    }),
)
.asked(
    "how many & !UNIT|cms ; just|only THING or MORE ; number of THING|SOME ; \
         how many THING|SOME & that ; \
         how many THING|SOME|different|of|do|be|have|there|did|now|in|you|other|separate & !UNIT ; \
         COUNT ?up ?ALL ?of THING|SOME|what|them|everything ; COUNT THING|SOME ; \
         number|total|tally of THING|SOME ; what .. number|count|total|tally ; just|only one|THING|SOME ; \
         MORE than one|two|three|THING|SOME ; one|just|only ?THING|SOME or|and MORE|two|several|NUMBER ; \
         be there ?only|just two|three|four|five|several ; how numerous ; how SIZED be number ; \
         give .. count|tally|total|number ; ^ count|tally ; more than one ; be THING just|only SOME|one ; \
         NUMBER or NUMBER|MORE ; SOME|THING or NUMBER|MORE ; keep count|tally ; number|total $ ; \
         how much SOME ; what MORE|else & number ; COUNT what .. FIND|TOUCH|FEEL|PAST ; \
         NUMBER or SOME|THING ; TELL ?me count|number|total ; just the|one one|thing ; \
         more than NUMBER|one|two ; any more than NUMBER ; be THING just THING|one",
)
.past(
    "how many ; number of THING|SOME ; what number ; NUMBER or ; or NUMBER|MORE & THING|SOME ; \
         number|total ; MORE than one|two ; just|only one|THING ; COUNT",
);
