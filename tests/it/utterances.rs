//! What a partner may type, and what it is taken for, a line each, in `utterances/`: the words were found with `first.jsonl`,
//! mended with `more.jsonl`, then with `freer.jsonl` and `registers.jsonl`, in which people speak freely. By `unseen_2.jsonl` and
//! `unseen_3.jsonl`, of other authors who had seen neither the program nor the other lists, nothing has been mended; nor by
//! `unseen_4.jsonl`, of a third author, which nobody has looked at while the grammar was built.

use std::collections::BTreeMap;

use bodyschema::interaction::{End, HandName, Intent, understood};
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
    assert!(right * 1000 >= all * 975, "{right} of {all}");
}

#[test]
fn freer_utterances_are_taken_for_what_they_mean_and_none_moves_that_may_not() {
    let (right, all) = taken(&["tests/it/utterances/freer.jsonl", "tests/it/utterances/registers.jsonl"]);
    assert!(right * 1000 >= all * 968, "{right} of {all}");
}

#[test]
fn unseen_utterances_are_understood_as_often_as_was_measured_and_none_moves_that_may_not() {
    let (right, all) = taken(&["tests/it/utterances/unseen_2.jsonl"]);
    assert!(right * 1000 >= all * 870, "{right} of {all}");
    // By neither list the grammar was mended: they tell how many are understood of what nobody has tried yet.
    let (right, all) = taken(&["tests/it/utterances/unseen_3.jsonl"]);
    assert!(right * 1000 >= all * 920, "{right} of {all}");
    // Of a third author's, whose sentences were not looked at, only how many are understood: 256 of 330 at first, with one that
    // moved him and only asked what a thing is like; fewer still than the 9 in 10 that are wanted.
    let (right, all) = taken(&["tests/it/utterances/unseen_4.jsonl"]);
    assert!(right * 1000 >= all * 855, "{right} of {all}");
}

/// What something is related to, to which side it is to go, or that it is denied in what is asked.
#[derive(Deserialize)]
struct Relation {
    say: String,
    means: Means,
    may_move: bool,
    hand: Option<String>,
    /// What is related, then to what.
    related: Option<Vec<String>>,
    /// To which side, and how far, metres, where that is told.
    aside: Option<String>,
}

/// The first 67 of these were written before anything was mended by them, and 64 taken for what they mean; of the 67 that
/// were written then 62. None that may not moved him but "push it ten feet to the left", which now asks.
#[test]
fn relations_sides_and_what_is_denied_of_facts_are_understood() {
    let text = std::fs::read_to_string(repository("tests/it/utterances/relations.jsonl")).unwrap();
    let (mut wrong, mut moved, mut kept) = (Vec::new(), Vec::new(), 0);
    for line in text.lines() {
        let example: Relation = serde_json::from_str(line).unwrap();
        let understood = understood(&example.say);
        let intent = serde_json::to_value(understood.intent).unwrap();
        let related = understood.related.as_ref().map(|(what, to)| {
            let what = match what {
                End::Thing => "it".to_string(),
                End::Part(part) => part.text(),
            };
            std::iter::once(what).chain(to.iter().map(|part| part.text())).collect::<Vec<_>>()
        });
        let aside = understood.aside.map(|aside| {
            let by = aside.by.map_or(String::new(), |by| format!(" {by}"));
            format!("{}{by}", if aside.left { "left" } else { "right" })
        });
        let hand = match example.hand.as_deref() {
            Some("left") => understood.hand == Some(HandName::Left),
            Some(_) => understood.hand == Some(HandName::Right),
            None => true,
        };
        let to_side = example.aside.is_none() || example.aside == aside;
        if !example.means.has(intent.as_str().unwrap()) || related != example.related || !to_side || !hand {
            wrong.push(format!("{}: {intent} {related:?} {aside:?}", example.say));
        }
        if understood.leave.is_some() && !example.may_move {
            moved.push(example.say.clone());
        }
        kept += usize::from(understood.leave.is_none() && example.may_move);
    }
    assert!(moved.is_empty(), "these may not move: {moved:#?}");
    assert!(wrong.len() <= 1 && kept <= 8, "{kept} ask first: {wrong:#?}");
}

/// What denies, asks, imagines or tells of something that has to do with sides, searching or where things are.
const NOT_TO_BE_DONE: &[&str] = &[
    "I haven't told you to push it to the left",
    "I have not asked you to search for anything you haven't found yet",
    "nobody said you should move it to the right",
    "you haven't been asked to touch it",
    "I did not say push it left",
    "what happens when you push it to the left?",
    "why would you push it to the right?",
    "could it be pushed to the left?",
    "can it move to the left?",
    "might you have pushed it to the left?",
    "is it true that you haven't touched it?",
    "see whether it hasn't moved and don't touch it",
    "see if it has not moved but do not touch it",
    "check that you have not touched it",
    "make sure you have not moved it to the left",
    "make sure you don't push it to the left",
    "tell me if you have not touched it before you touch it",
    "tell me whether there isn't anything, without moving",
    "without moving, tell me whether there isn't anything else",
    "look for anything you haven't found, but not with your hands",
    "don't see whether there's anything you haven't found yet",
    "you shouldn't see whether there is anything",
    "I wonder whether you shouldn't push it to the left",
    "I'm not sure whether you should push it to the left",
    "it's not clear if you haven't found it",
    "do not check whether it hasn't moved",
    "I don't care whether there isn't anything else",
    "if it isn't there, search for it",
    "when it is near, push it to the left",
    "once you have found it push it to the right",
    "before you push it to the left, wait",
    "if only you had not pushed it to the left",
    "push it to the left of the box",
    "push it left of the box",
    "as soon as the bell rings, let go of it",
    "as long as it is quiet push it to the right",
    "in case it comes near, bring it closer",
    "provided that it is light, raise it",
    "on condition that it is light, raise it",
    "the moment it moves, push it to the left",
    "push it to the left only once it is light",
    "were it on the left, you could push it to the right",
    "you can push it to the left, can't you?",
    "you pushed it to the left, didn't you",
    "he pushed it to the left",
    "she wants to move it to the right",
    "people push it to the left",
    "to push it to the left is silly",
    "pushing it to the left is a bad idea",
    "pushing it left would be wrong",
    "not to the left, push it away",
    "push it, but not to the left",
    "push it left, no wait, right",
    "push it left or right",
    "push it neither left nor right",
    "push it to the left if it is light",
    "push it to the left unless it is heavy",
    "push it to the left? no",
    "should I push it to the left?",
    "shall I move it right?",
    "the left one, is it heavy?",
    "it moved to the left",
    "it went to the right",
    "it is to the left of the box",
    "is it the left one or the right one",
    "put the thing that is on the left",
    "never ever slide anything to the right",
    "keep it where it is, don't move it left",
    "leave it there, not further left",
    "stop pushing it to the left",
    "quit moving it left",
    "avoid pushing it right",
    "instead of the left push it nowhere",
    "\"push it to the left\" is what he said",
    "he said \"push it to the left\"",
    "imagine you push it to the left",
    "suppose it's pushed left",
    "let him push it to the left",
    "I will push it to the left",
    "I'll move it to the left myself",
    "we moved it to the left",
    "how about not pushing it to the left",
    "how do you push it to the left?",
    "when did you push it left",
    "how far to the left could you push it",
    "how far left can you move it?",
    "where would it be if you pushed it left?",
    "what if there isn't anything you haven't found yet",
    "I hope you haven't pushed it left",
    "do you know what you have not found yet",
    "did you see whether there isn't anything else?",
    "have you checked whether there's anything you haven't found yet?",
    "aren't you going to push it left?",
    "isn't there any way not to touch it",
    "isn't there something you shouldn't touch?",
    "is there anything you must not touch?",
    "is there something you don't want to touch?",
    "are there things you can't reach?",
    "are there things I should not touch?",
    "find something not to touch",
    "touch nothing you haven't touched yet",
    "touch nothing to the left",
    "move nothing to the left",
    "nothing needs to be moved to the left",
    "don't bother to push it left",
    "no need to push it to the right",
    "there is no reason to push it to the right",
    "I'd rather you didn't push it to the left",
    "I'd hate it if you pushed it to the left",
    "you may not push it to the left",
    "yesterday you pushed it left",
    "tomorrow push it left",
    "not now, but push it to the left later",
];

#[test]
fn what_is_denied_asked_or_imagined_of_sides_and_of_searching_never_moves() {
    for said in NOT_TO_BE_DONE {
        let understood = understood(said);
        assert!(understood.leave.is_none(), "{said}: {understood:?}");
    }
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
fn a_word_that_is_not_known_is_asked_back() {
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
    // A slip as well, with the word that it is nearest to.
    let slip = understood("tuch it");
    assert!(slip.intent == Intent::Touch && slip.leave.is_none(), "{slip:?}");
    assert_eq!(slip.unknown[0].nearest.as_deref(), Some("touch"));
}
