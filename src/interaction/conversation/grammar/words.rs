//! An utterance's words: lower case, short forms resolved, each with its lemma and form.

use super::lexicon::{Form, Lexicon};

/// What ends a clause, or a sentence.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Mark {
    /// A comma, a colon, a semicolon, a dash.
    Pause,
    /// A full stop or an exclamation mark.
    Stop,
    /// A question mark.
    Question,
}

/// A word of an utterance.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Word {
    /// As it is spelled, or the nearest known word.
    pub text: String,
    /// Its dictionary form: `touch` of `touched`.
    pub lemma: String,
    /// Which form it is.
    pub form: Form,
    /// What was typed, if that is not a known word.
    pub unknown: Option<String>,
    /// What follows it.
    pub mark: Option<Mark>,
}

impl Word {
    /// Whether its lemma is one of some words, parted by blanks.
    pub fn is(&self, lemmas: &str) -> bool {
        lemmas.split_whitespace().any(|lemma| lemma == self.lemma || lemma == self.text)
    }
}

/// Short forms, and the words that they stand for.
const SHORT: &str = "cannot: can not, cant: can not, wont: will not, aint: is not, shant: shall not, nt: not, \
    musnt: must not, dnt: do not, dnot: do not, donot: do not, lets: let us, im: i am, ive: i have, \
    gonna: going to, wanna: want to, gotta: have to, gday: good day, uhhuh: yes, lil: little, \
    infront: in front, howmany: how many, gimme: give me, lemme: let me, kinda: kind of, \
    dunno: do not know, whatcha: what are you, cmon: come on, plz: please, pls: please, u: you, ya: you, \
    ur: your, r: are, n: and, thx: thanks, ty: thanks, cya: bye, abt: about, hw: how, wat: what, \
    tht: that, cn: can, yer: your, em: them, nd: and, wd: would";
/// Helping words with "not" written on: "dont" is "do not".
const DENIABLE: &str = "do does did is are was were have has had could would should must need ought might";
/// Words that "is" is written on without an apostrophe: "whats".
const WITH_IS: &str = "what where how who that there here when";
/// What is written on after an apostrophe.
const ENDINGS: [(&str, &str); 6] =
    [("n't", "not"), ("'re", "are"), ("'ve", "have"), ("'ll", "will"), ("'d", "would"), ("'m", "am")];
/// What "'s" after is "is", and not somebody's.
const BEFORE_IS: &str =
    "it that this there here what where how who when he she thing one everything something anything";

/// The words of what was heard.
pub(super) fn words(heard: &str, lexicon: &Lexicon) -> Vec<Word> {
    let heard = heard.to_lowercase().replace(['’', '`', '‘'], "'").replace(" - ", ", ").replace('—', ", ");
    let mut words: Vec<Word> = Vec::new();
    for token in heard.split_whitespace() {
        let core = token.trim_start_matches(|c: char| !c.is_alphanumeric());
        let end = core.trim_end_matches(|c: char| !c.is_alphanumeric());
        let mark = mark_of(if core.is_empty() { token } else { &core[end.len()..] });
        for part in end.split(|c: char| !c.is_alphanumeric() && c != '\'').filter(|part| !part.is_empty()) {
            let inside = part.as_ptr() as usize - end.as_ptr() as usize + part.len();
            for text in resolved(part) {
                words.extend(text.split_whitespace().map(|text| lexicon.word(text)));
            }
            // "Stop,please": a mark inside of what has no blanks.
            if let Some(last) = words.last_mut() {
                last.mark = mark_of(end[inside..].split(char::is_alphanumeric).next().unwrap_or(""));
            }
        }
        if let Some(last) = words.last_mut() {
            last.mark = last.mark.max(mark);
        }
    }
    words
}

/// Whether something is quoted: what others say asks for nothing.
pub(super) fn quotes(heard: &str) -> bool {
    let quotes = |word: &str| word.starts_with('\'') && word.len() > 1;
    heard.contains(['"', '“', '”']) || heard.split_whitespace().any(quotes)
}

fn mark_of(end: &str) -> Option<Mark> {
    match end {
        end if end.contains('?') => Some(Mark::Question),
        end if end.contains(['.', '!', '…']) => Some(Mark::Stop),
        end if end.contains([',', ':', ';', '(', ')', '–']) => Some(Mark::Pause),
        _ => None,
    }
}

/// What a word stands for, short forms written out.
fn resolved(word: &str) -> Vec<String> {
    let listed = |list: &str, word: &str| list.split(' ').any(|other| other == word);
    let bare = word.replace('\'', "");
    let mut short = SHORT.split(", ").filter_map(|pair| pair.split_once(": "));
    if let Some((_, long)) = short.find(|(short, _)| *short == bare) {
        return vec![long.to_string()];
    }
    if let Some(helping) = bare.strip_suffix("nt").filter(|helping| listed(DENIABLE, helping)) {
        return vec![helping.to_string(), "not".into()];
    }
    if let Some(asking) = bare.strip_suffix('s').filter(|asking| listed(WITH_IS, asking)) {
        return vec![asking.to_string(), "is".into()];
    }
    for (ending, long) in ENDINGS {
        if let Some(word) = word.strip_suffix(ending).filter(|word| !word.is_empty()) {
            return vec![word.to_string(), long.to_string()];
        }
    }
    match word.strip_suffix("'s") {
        Some(word) if listed(BEFORE_IS, word) => vec![word.to_string(), "is".into()],
        Some(word) => vec![word.to_string()],
        None => vec![bare],
    }
}
