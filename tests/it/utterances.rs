//! What a partner may type, and what it is taken for, a line each, in `utterances/`: the words were found with `first.jsonl`,
//! mended with `more.jsonl`, then with `freer.jsonl` and `registers.jsonl`, in which people speak freely. `unseen_2.jsonl` was
//! written when all of that was done, and measured once before anything was mended by it. By `unseen_3.jsonl`,
//! of another author who had seen neither the program nor the other lists, nothing has been mended.

use std::collections::BTreeMap;

use bodyschema::interaction::{HandName, understood};
use serde::Deserialize;

use crate::common::repository;

/// An utterance and what it means; one of several classes where it may be taken for either.
#[derive(Deserialize)]
struct Example {
    say: String,
    means: Means,
    hand: Option<String>,
    part: Option<String>,
    may_move: bool,
}

#[derive(Deserialize)]
#[serde(untagged)]
enum Means {
    One(String),
    Either(Vec<String>),
}

impl Means {
    fn has(&self, intent: &str) -> bool {
        match self {
            Means::One(one) => one == intent,
            Means::Either(all) => all.iter().any(|one| one == intent),
        }
    }
}

fn examples(file: &str) -> Vec<Example> {
    let text = std::fs::read_to_string(repository(file)).unwrap();
    text.lines().map(|line| serde_json::from_str(line).unwrap()).collect()
}

/// How many utterances of some files are taken for what they mean, of how many; none may move that may not.
fn taken(files: &[&str]) -> (usize, usize) {
    let (mut right, mut all, mut moved, mut kept) = (0, 0, Vec::new(), 0);
    let mut wrong: BTreeMap<String, Vec<String>> = BTreeMap::new();
    for example in files.iter().flat_map(|file| examples(file)) {
        let understood = understood(&example.say);
        let intent = serde_json::to_value(understood.intent).unwrap();
        let hand = understood.hand.map(|hand| match hand {
            HandName::Left => "left",
            HandName::Right => "right",
            HandName::Other => "other",
        });
        let part = understood.part.as_ref().map(|part| part.text());
        all += 1;
        let means = example.means.has(intent.as_str().unwrap());
        let slots = hand == example.hand.as_deref() && part == example.part;
        right += usize::from(means && slots);
        if understood.leave.is_some() && !example.may_move {
            moved.push(example.say.clone());
        }
        kept += usize::from(understood.leave.is_none() && example.may_move);
        if !(means && slots) || (understood.leave.is_none() && example.may_move) {
            let told = format!(
                "{intent} {:?} {hand:?} {part:?} leave {} {:?}",
                understood.mood,
                understood.leave.is_some(),
                understood.unknown
            );
            wrong
                .entry(
                    (if means && slots {
                        "kept"
                    } else if means {
                        "slots"
                    } else {
                        "intent"
                    })
                    .to_string(),
                )
                .or_default()
                .push(format!("{:60} {told}", example.say));
        }
    }
    for (kind, list) in &wrong {
        eprintln!("{kind}:");
        list.iter().for_each(|line| eprintln!("  {line}"));
    }
    eprintln!("{right} of {all} right; {kept} that may move ask first");
    assert!(moved.is_empty(), "these may not move: {moved:#?}");
    (right, all)
}

#[test]
fn utterances_are_taken_for_what_they_mean_and_none_moves_that_may_not() {
    let (right, all) = taken(&["tests/it/utterances/first.jsonl", "tests/it/utterances/more.jsonl"]);
    assert!(right * 1000 >= all * 994, "{right} of {all}");
}

#[test]
fn freer_utterances_are_taken_for_what_they_mean_and_none_moves_that_may_not() {
    let (right, all) = taken(&["tests/it/utterances/freer.jsonl", "tests/it/utterances/registers.jsonl"]);
    assert!(right * 1000 >= all * 975, "{right} of {all}");
}

#[test]
fn unseen_utterances_are_understood_as_often_as_was_measured_and_none_moves_that_may_not() {
    let (right, all) = taken(&["tests/it/utterances/unseen_2.jsonl"]);
    assert!(right * 1000 >= all * 899, "{right} of {all}");
    // By this list nothing has been mended: it tells how many are understood of what nobody has tried yet.
    let (right, all) = taken(&["tests/it/utterances/unseen_3.jsonl"]);
    assert!(right * 1000 >= all * 940, "{right} of {all}");
}

/// Sentences that tell or ask of doing something, with `{}` where it stands, and ask nobody to do it.
#[derive(Deserialize)]
struct NotAskedFor {
    to_do: Vec<String>,
    done: Vec<String>,
    doing: Vec<String>,
}

#[test]
fn what_is_told_of_asked_or_imagined_never_moves() {
    let text = std::fs::read_to_string(repository("tests/it/utterances/not_asked_for.json")).unwrap();
    let sentences: NotAskedFor = serde_json::from_str(&text).unwrap();
    let deeds = [
        ["touch it", "touched it", "touching it"],
        ["lift it", "lifted it", "lifting it"],
        ["push it away", "pushed it away", "pushing it away"],
        ["put it far away", "put it far away", "putting it far away"],
        ["lean forward", "leaned forward", "leaning forward"],
        ["touch your nose", "touched your nose", "touching your nose"],
        ["bring it near", "brought it near", "bringing it near"],
        ["let go of it", "let go of it", "letting go of it"],
        ["search the table", "searched the table", "searching the table"],
        ["pick it up", "picked it up", "picking it up"],
        ["put it down", "put it down", "putting it down"],
        ["rest", "rested", "resting"],
    ];
    for [to_do, done, doing] in deeds {
        for (sentences, deed) in
            [(&sentences.to_do, to_do), (&sentences.done, done), (&sentences.doing, doing)]
        {
            for sentence in sentences {
                let said = sentence.replace("{}", deed);
                let understood = understood(&said);
                assert!(understood.leave.is_none(), "{said}: {understood:?}");
            }
        }
    }
}

/// Ways to forbid what follows.
const FORBIDDING: [&str; 16] = [
    "don't",
    "dont",
    "Do not",
    "please don't",
    "never",
    "never ever",
    "I don't want you to",
    "I would rather you did not",
    "you must not",
    "you may not",
    "you are not allowed to",
    "make sure that you do not",
    "whatever you do, don't",
    "I told you not to",
    "under no circumstances",
    "could you please not",
];
/// Ways to forbid what is said as a gerund.
const FORBIDDING_DOING: [&str; 8] = [
    "no",
    "stop",
    "refrain from",
    "avoid",
    "please quit",
    "without",
    "I am against you, so no",
    "abstain from",
];

#[test]
fn what_is_forbidden_never_moves() {
    for example in examples("tests/it/utterances/first.jsonl").iter().filter(|example| example.may_move) {
        for forbidding in FORBIDDING {
            for said in [
                format!("{forbidding} {}", example.say),
                format!("{}, no, {forbidding} do that", example.say),
            ] {
                assert!(understood(&said).leave.is_none(), "{said}");
            }
        }
    }
    let doings = [
        "touching it",
        "pushing it away",
        "lifting the box",
        "leaning forward",
        "touching your nose",
        "putting it far away",
    ];
    for doing in doings {
        for forbidding in FORBIDDING_DOING {
            let said = format!("{forbidding} {doing}");
            assert!(understood(&said).leave.is_none(), "{said}");
        }
    }
}

/// Words drawn at random from all that is said in the examples, but those that make a polite request, or ask to search.
fn salads(count: usize, seed: u64) -> Vec<String> {
    use rand::{RngExt, SeedableRng};
    const LEFT_OUT: [&str; 14] = [
        "can",
        "could",
        "will",
        "would",
        "please",
        "pls",
        "there",
        "anything",
        "something",
        "how",
        "if",
        "mind",
        "you're",
        "may",
    ];
    let all = examples("tests/it/utterances/first.jsonl");
    let words: Vec<String> = all
        .iter()
        .flat_map(|example| example.say.split(|c: char| !c.is_alphanumeric() && c != '\''))
        .map(str::to_lowercase)
        .filter(|word| !word.is_empty() && !LEFT_OUT.contains(&word.as_str()))
        .collect();
    let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(seed);
    let salad = |_| {
        let length = rng.random_range(2..8);
        (0..length).map(|_| words[rng.random_range(0..words.len())].clone()).collect::<Vec<_>>().join(" ")
    };
    (0..count).map(salad).collect()
}

#[test]
fn questions_and_what_is_past_never_move_whatever_their_words() {
    for salad in salads(400, 1) {
        for said in [
            format!("{salad}?"),
            format!("why do you {salad}?"),
            format!("did you {salad}"),
            format!("have you already touched {salad}"),
            format!("what did you {salad}?"),
            format!("you touched {salad}"),
            format!("were you going to {salad}"),
        ] {
            let understood = understood(&said);
            assert!(understood.leave.is_none(), "{said}: {understood:?}");
        }
    }
}

#[test]
fn letters_that_are_no_words_never_move() {
    use rand::{RngExt, SeedableRng};
    let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(2);
    for _ in 0..400 {
        let words = rng.random_range(1..5);
        let mut word = || {
            let length = rng.random_range(3..9);
            (0..length).map(|_| char::from(rng.random_range(b'a'..=b'z'))).collect::<String>()
        };
        let said = (0..words).map(|_| word()).collect::<Vec<_>>().join(" ");
        let understood = understood(&said);
        // By chance it may be a word; where it is none, nothing is done.
        assert!(understood.unknown.is_empty() || understood.leave.is_none(), "{said}");
    }
}

#[test]
fn mending_turns_no_english_word_into_another() {
    for said in [
        "couch it",
        "torch it",
        "learn forward",
        "clean forward",
        "bull it closer",
        "gift it",
        "lunch it",
        "fouch it",
    ] {
        let understood = understood(said);
        assert!(understood.leave.is_none(), "{said}: {understood:?}");
    }
    assert!(understood("tuch it").leave.is_some(), "but a slip is mended");
}
