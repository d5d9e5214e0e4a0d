//! "How many things are there?": tells how many it has felt.

use super::{Act, Answer, RequestKind};

pub(super) const HOW_MANY: RequestKind = RequestKind {
    asked: &[
        "how many THING|SOME|different|of|do|be|have|there|did|now|in|you|other|things|separate",
        "how many $",
        "how much SOME",
        "count|tally ?up ?all ?of THING|SOME|what|them|everything",
        "count|number|tally of THING|SOME",
        "^ ?just|only|but one ?SOME|THING or",
        "^ count ?them ?all ?up $",
        "more than one|two|three|THING|SOME",
        "just|only one",
        "be THING ?just|only one|THING|SOME ?SOME|THING or two|three|more|several|many",
        "be there two|three|four|five|several|only|just",
        "^ what|give .. count|tally|total|number",
        "how large|big be the number",
        "keep count",
        "total number",
        "one or two|more|several",
        "how numerous",
    ],
    past: &[
        "one|two|three|four or",
        "how many",
        "more than one|two",
        "just|only one",
        "just|only one",
        "count|tally",
    ],
    ..RequestKind::new(
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
};
