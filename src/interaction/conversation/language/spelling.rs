//! Spelling mistakes: a word that nobody knows is taken for a known one that a slip of the fingers or of the ear makes
//! of it, where there is one such word alone.
//!
//! A word that is known stays as it is, and so does any other common English word: "couch" is not "touch".

use super::lexicon::Lexicon;

/// Common English words that are near to one of the lexicon, in order; from SCOWL's word lists, see its end.
const ENGLISH: &str = include_str!("english.txt");
/// Words shorter than this are not mended …
const SHORTEST: usize = 3;
/// … two slips only in words as long as this.
const LONG: usize = 7;
/// Keys side by side, row by row.
const ROWS: [&str; 3] = ["qwertyuiop", "asdfghjkl", "zxcvbnm"];

/// What a slip costs: the likelier, the less.
const SWAPPED: u32 = 2;
const DOUBLED: u32 = 2;
const MISSING: u32 = 3;
const SOUNDS_ALIKE: u32 = 3;
const NEXT_KEY: u32 = 4;
/// The most that all slips of a word may cost, and how much dearer the next best word has to be.
const MOST: u32 = 6;

/// Whether a word is English that the lexicon does not have.
pub(super) fn is_foreign_english(word: &str) -> bool {
    let mut words = ENGLISH.lines().take_while(|line| !line.is_empty());
    words.any(|line| line == word)
}

/// A word as it was meant; as it is where it is English already, or where no word, or more than one, is likely.
pub(super) fn mended(word: &str, lexicon: &Lexicon) -> String {
    let length = word.chars().count();
    if length < SHORTEST || word.chars().any(|c| !c.is_ascii_lowercase()) || is_foreign_english(word) {
        return word.into();
    }
    let slips = if length >= LONG { 2 } else { 1 };
    let near = |known: &str| known.len() >= SHORTEST && strsim::osa_distance(word, known) <= slips;
    let candidates = lexicon.words().chain(super::words::short_words()).filter(|known| near(known));
    let mut found: Vec<(u32, &str)> =
        candidates.filter_map(|known| Some((cost(word, known, slips)?, known))).collect();
    found.sort_unstable();
    found.dedup();
    match found.as_slice() {
        [(_, best)] => best.to_string(),
        [(least, best), (next, _), ..] if least < next => best.to_string(),
        _ => word.into(),
    }
}

/// What it costs to make what was heard of a word that was meant, in at most so many slips; none where it takes more, or
/// others than people make.
fn cost(heard: &str, meant: &str, slips: usize) -> Option<u32> {
    let [heard, meant]: [Vec<char>; 2] = [heard, meant].map(|word| word.chars().collect());
    cheapest(&heard, &meant, slips, None).filter(|cost| *cost <= MOST)
}

/// `before` is the letter of the meant word before the rest of it.
fn cheapest(heard: &[char], meant: &[char], slips: usize, before: Option<char>) -> Option<u32> {
    if heard == meant {
        return Some(0);
    }
    if let (Some(a), Some(b)) = (heard.first(), meant.first())
        && a == b
    {
        // Of two that are alike one may be missing, or one too many.
        let straight = cheapest(&heard[1..], &meant[1..], slips, Some(*b));
        if straight.is_some() {
            return straight;
        }
    }
    if slips == 0 {
        return None;
    }
    let on = |h: usize, m: usize, cost: u32| {
        let last = m.checked_sub(1).map_or(before, |k| Some(meant[k]));
        Some(cost + cheapest(&heard[h..], &meant[m..], slips - 1, last)?)
    };
    let mut ways = Vec::new();
    if let ([a, b, ..], [c, d, ..]) = (heard, meant)
        && a == d
        && b == c
    {
        // The first letter is seldom wrong.
        ways.push(on(2, 2, SWAPPED + u32::from(before.is_none())));
    }
    if let (Some(a), Some(b), Some(_)) = (heard.first(), meant.first(), before) {
        ways.push(if alike(*a, *b) { on(1, 1, SOUNDS_ALIKE) } else { None });
        ways.push(if beside(*a, *b) { on(1, 1, NEXT_KEY) } else { None });
    }
    if let (Some(a), Some(last)) = (heard.first(), before) {
        let next = meant.first().copied();
        ways.push(if *a == last { on(1, 0, DOUBLED) } else { None });
        let brushed = beside(*a, last) || next.is_some_and(|next| beside(*a, next));
        ways.push(if brushed { on(1, 0, NEXT_KEY) } else { None });
    }
    if let (Some(missed), Some(last)) = (meant.first(), before) {
        ways.push(on(0, 1, if *missed == last { DOUBLED } else { MISSING }));
    }
    ways.into_iter().flatten().min()
}

/// Whether two letters are taken for each other by ear.
fn alike(a: char, b: char) -> bool {
    let vowels = "aeiouy";
    (vowels.contains(a) && vowels.contains(b))
        || ["ck", "sz", "sc", "gj", "fv"].iter().any(|pair| pair.contains(a) && pair.contains(b))
}

/// Whether two letters' keys touch.
fn beside(a: char, b: char) -> bool {
    let at = |c: char| ROWS.iter().enumerate().find_map(|(row, keys)| Some((row, keys.find(c)?)));
    let (Some((row_a, a)), Some((row_b, b))) = (at(a), at(b)) else { return false };
    match row_a.abs_diff(row_b) {
        0 => a.abs_diff(b) == 1,
        1 => {
            // A key of a lower row lies under the one above it and that one's right neighbour.
            let (above, below) = if row_a < row_b { (a, b) } else { (b, a) };
            above == below || above == below + 1
        }
        _ => false,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn slips_are_mended_and_words_are_let_be() {
        let lexicon = Lexicon::new(["nose", "elbow"]);
        for (heard, meant) in [
            ("tuch", "touch"),
            ("toch", "touch"),
            ("tuoch", "touch"),
            ("touchh", "touch"),
            ("psuh", "push"),
            ("serach", "search"),
            ("teh", "the"),
            ("relaese", "release"),
            ("elbwo", "elbow"),
            ("farhtest", "farthest"),
            ("neevr", "never"),
            ("sotp", "stop"),
            // English, or too far off.
            ("couch", "couch"),
            ("torch", "torch"),
            ("learn", "learn"),
            ("clean", "clean"),
            ("hose", "hose"),
            ("france", "france"),
            ("asdf", "asdf"),
            ("qwer", "qwer"),
            ("xyzzy", "xyzzy"),
        ] {
            assert_eq!(mended(heard, &lexicon), meant, "{heard}");
        }
    }
}
