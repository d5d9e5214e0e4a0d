//! An utterance's words: small letters, apostrophes resolved, what people run together taken apart.

use super::lexicon::{Form, Lexicon};
use super::noun_phrases::begins_thing;
use super::{idioms, spelling};

/// What ends a clause, or a sentence.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Mark {
    /// A comma, a colon, a semicolon, a dash.
    Pause,
    /// A full stop.
    Stop,
    /// An exclamation mark.
    Cry,
    /// A question mark.
    Question,
}

/// A word of an utterance.
#[derive(Clone, Debug, PartialEq)]
pub struct Word {
    /// As it was mended.
    pub text: String,
    /// Its dictionary form: `touch` of `touched`.
    pub lemma: String,
    /// Which form it is.
    pub(super) form: Form,
    /// Whether the lexicon has it.
    pub known: bool,
    /// What follows it.
    pub(super) mark: Option<Mark>,
}

impl Word {
    /// Whether it is one of some words in their dictionary form.
    pub fn is(&self, lemmas: &[&str]) -> bool {
        lemmas.contains(&self.lemma.as_str())
    }
}

/// What people write together or short, and the words that it stands for.
const SHORT: &[(&str, &str)] = &[
    ("dont", "do not"),
    ("nt", "not"),
    ("dnt", "do not"),
    ("donot", "do not"),
    ("doesnt", "does not"),
    ("didnt", "did not"),
    ("isnt", "is not"),
    ("arent", "are not"),
    ("aint", "is not"),
    ("wasnt", "was not"),
    ("werent", "were not"),
    ("havent", "have not"),
    ("hasnt", "has not"),
    ("hadnt", "had not"),
    ("wont", "will not"),
    ("cant", "can not"),
    ("cannot", "can not"),
    ("couldnt", "could not"),
    ("wouldnt", "would not"),
    ("shouldnt", "should not"),
    ("mustnt", "must not"),
    ("neednt", "need not"),
    ("oughtnt", "ought not"),
    ("shant", "shall not"),
    ("mightnt", "might not"),
    ("whats", "what is"),
    ("hw", "how"),
    ("wat", "what"),
    ("wht", "what"),
    ("plase", "please"),
    ("cn", "can"),
    ("whatre", "what are"),
    ("wheres", "where is"),
    ("hows", "how is"),
    ("whos", "who is"),
    ("thats", "that is"),
    ("theres", "there is"),
    ("lets", "let us"),
    ("im", "i am"),
    ("ive", "i have"),
    ("youre", "you are"),
    ("youve", "you have"),
    ("youll", "you will"),
    ("gonna", "going to"),
    ("wanna", "want to"),
    ("gotta", "have to"),
    ("gimme", "give me"),
    ("lemme", "let me"),
    ("kinda", "kind of"),
    ("whatcha", "what are you"),
    ("dunno", "do not know"),
    ("plz", "please"),
    ("pls", "please"),
    ("pleas", "please"),
    ("u", "you"),
    ("ur", "your"),
    ("ya", "you"),
    ("r", "are"),
    ("thx", "thanks"),
    ("ty", "thanks"),
    ("cya", "bye"),
    ("rn", "now"),
    ("infront", "in front"),
    ("alot", "a lot"),
    ("w", "with"),
    ("touchy", "touch"),
    ("howmany", "how many"),
    ("whereis", "where is"),
    ("pickup", "pick up"),
    ("putdown", "put down"),
    ("letgo", "let go"),
    ("abt", "about"),
    ("tmr", "tomorrow"),
    ("idk", "i do not know"),
    ("sup", "what is up"),
];

/// What an apostrophe and these letters stand for at a word's end.
const ENDINGS: &[(&str, &str)] =
    &[("n't", "not"), ("'re", "are"), ("'ll", "will"), ("'ve", "have"), ("'m", "am"), ("'d", "would")];

/// The words of an utterance, spelling mistakes mended.
pub(super) fn words(heard: &str, lexicon: &Lexicon) -> Vec<Word> {
    let mut words: Vec<Word> = Vec::new();
    for (token, mark) in tokens(heard) {
        words.extend(pieces(&token, lexicon).into_iter().map(|piece| word(piece, lexicon)));
        if let Some(last) = words.last_mut() {
            last.mark = last.mark.max(mark);
        }
    }
    // "Touch touch touch", "no no".
    words.dedup_by(|next, before| {
        let same = next.text == before.text && next.text != "not";
        if same {
            before.mark = before.mark.max(next.mark);
        }
        same
    });
    compared(&mut words, lexicon);
    sticking(&mut words, lexicon);
    plainly(&mut words, lexicon);
    // "don t", as who types in haste has it.
    let mut k = 0;
    while k + 1 < words.len() {
        if words[k].text == "don" && words[k + 1].text == "t" {
            words[k] = word("do".into(), lexicon);
            words[k + 1] = Word { mark: words[k + 1].mark, ..word("not".into(), lexicon) };
        }
        k += 1;
    }
    words
}

/// Idioms are put in plain words.
fn plainly(words: &mut Vec<Word>, lexicon: &Lexicon) {
    loop {
        let texts: Vec<&str> = words.iter().map(|word| word.text.as_str()).collect();
        let marks: Vec<Option<Mark>> = words.iter().map(|word| word.mark).collect();
        let Some((k, count, meant)) = idioms::plain(&texts, &marks) else { return };
        let mark = words[k + count - 1].mark;
        let mut plain: Vec<Word> = meant.split_whitespace().map(|text| word(text.into(), lexicon)).collect();
        match plain.last_mut() {
            Some(last) => last.mark = mark,
            None => {
                if let Some(before) = k.checked_sub(1) {
                    words[before].mark = words[before].mark.max(mark);
                }
            }
        }
        words.splice(k..k + count, plain);
    }
}

/// "More near" is nearer, as who learns the language has it.
fn compared(words: &mut Vec<Word>, lexicon: &Lexicon) {
    const COMPARED: [(&str, &str); 9] = [
        ("near", "nearer"),
        ("close", "closer"),
        ("nearer", "nearer"),
        ("closer", "closer"),
        ("far", "farther"),
        ("farther", "farther"),
        ("further", "further"),
        ("distant", "farther"),
        ("remote", "farther"),
    ];
    let mut k = 0;
    while k + 1 < words.len() {
        let next = COMPARED.iter().find(|(plain, _)| words[k + 1].text == *plain);
        if let Some((_, compared)) = next.filter(|_| words[k].text == "more" && words[k].mark.is_none()) {
            let mark = words[k + 1].mark;
            words[k] = Word { mark, ..word(compared.to_string(), lexicon) };
            words.remove(k + 1);
        }
        k += 1;
    }
}

/// To stick something somewhere is to put it there, where a stick is a thing.
fn sticking(words: &mut [Word], lexicon: &Lexicon) {
    for k in 0..words.len() {
        let before = k.checked_sub(1).filter(|&before| words[before].mark.is_none());
        let thing = before.is_some_and(|before| begins_thing(&words[before]));
        let of_something = words[k].mark.is_none() && words.get(k + 1).is_some_and(begins_thing);
        if words[k].is(&["stick"]) && of_something && !thing {
            let put = match words[k].form {
                Form::Third => "puts",
                Form::Ing => "putting",
                _ => "put",
            };
            words[k] = Word { mark: words[k].mark, ..word(put.into(), lexicon) };
        }
    }
}

/// Whether what somebody said is told of: some of it stands between quotation marks, and some does not.
pub(super) fn quotes(heard: &str) -> bool {
    let marks = ['"', '“', '”', '„', '«', '»'];
    let heard = heard.trim();
    heard.trim_matches(marks).contains(marks) || (heard.starts_with(marks) != heard.ends_with(marks))
}

/// The runs of letters and digits, with the apostrophes within them, and the mark that follows each.
fn tokens(heard: &str) -> Vec<(String, Option<Mark>)> {
    let mut tokens: Vec<(String, Option<Mark>)> = Vec::new();
    let mut within = false;
    for c in heard.chars().flat_map(char::to_lowercase) {
        let apostrophe = matches!(c, '\'' | '’' | '‘' | '`' | '´');
        if c.is_alphanumeric() || (apostrophe && within) {
            if !within {
                tokens.push((String::new(), None));
            }
            if let Some((token, _)) = tokens.last_mut() {
                token.push(if apostrophe { '\'' } else { c });
            }
            within = true;
            continue;
        }
        within = false;
        let mark = match c {
            '?' | '？' => Mark::Question,
            '.' | '\n' => Mark::Stop,
            '!' => Mark::Cry,
            ',' | ';' | ':' | '–' | '—' => Mark::Pause,
            _ => continue,
        };
        if let Some((_, before)) = tokens.last_mut() {
            *before = (*before).max(Some(mark));
        }
    }
    tokens
}

/// What a token stands for, word by word.
fn pieces(token: &str, lexicon: &Lexicon) -> Vec<String> {
    let split = |words: &str| words.split(' ').map(String::from).collect::<Vec<_>>();
    let short = |token: &str| SHORT.iter().find(|(short, _)| *short == token).map(|(_, long)| split(long));
    let bare: String = token.chars().filter(|c| *c != '\'').collect();
    if let Some(long) = short(&bare).filter(|_| !lexicon.has(token)) {
        return long;
    }
    if token.contains('\'') {
        if let Some((stem, long)) =
            ENDINGS.iter().find_map(|(end, long)| Some((token.strip_suffix(end)?, long)))
        {
            return [pieces(stem, lexicon), vec![long.to_string()]].concat();
        }
        if let Some(stem) = token.strip_suffix("'s") {
            // Either "is" or whose it is; the one is no harm where the other is meant.
            return [pieces(stem, lexicon), vec!["is".to_string()]].concat();
        }
    }
    if lexicon.has(&bare) {
        return vec![bare];
    }
    let mended = spelling::mended(&bare, lexicon);
    short(&mended).unwrap_or_else(|| vec![mended])
}

fn word(text: String, lexicon: &Lexicon) -> Word {
    let text = lexicon.meant(&text).to_string();
    let (lemma, form, known) = match lexicon.entry(&text) {
        Some((lemma, form)) => (lemma.to_string(), form, true),
        None => (text.clone(), Form::Other, text.chars().all(|c| c.is_ascii_digit())),
    };
    Word { text, lemma, form, known, mark: None }
}

/// What is written short, as it is written.
pub(super) fn short_words<'a>() -> impl Iterator<Item = &'a str> {
    SHORT.iter().map(|(short, _)| *short).filter(|short| short.len() > 2)
}
