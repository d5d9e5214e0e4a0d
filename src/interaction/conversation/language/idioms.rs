//! Turns of speech whose words do not say what they mean: "take it easy", "knock it off".

use super::words::Mark;

/// What is said, from the beginning of a clause where it has a `^`, to its end where it has a `$`, and aloud where it has a
/// `!`; and plain words for it.
const IDIOMS: &[(&str, &str)] = &[
    ("take it easy", "relax"),
    ("take things easy", "relax"),
    ("take a load off", "relax"),
    ("put your feet up", "relax"),
    ("chill out", "relax"),
    ("^ chill", "relax"),
    ("^ at ease", "relax"),
    ("catch your breath", "relax"),
    ("let us call it a day", "goodbye"),
    ("let us call it quits", "goodbye"),
    ("call it a day", "goodbye"),
    ("i meant $", ""),
    ("that was kind of you", "thanks"),
    ("that was very kind of you", "thanks"),
    ("that was nice of you", "thanks"),
    ("call it quits", "goodbye"),
    ("that is it for", "goodbye for"),
    ("that is all for", "goodbye for"),
    ("^ ok bye", "goodbye"),
    ("^ ok goodbye", "goodbye"),
    ("^ hold it !", "stop"),
    ("^ hold on $", "stop"),
    ("^ hold everything", "stop"),
    ("^ hang on", "wait"),
    ("knock it off", "stop"),
    ("cut it out", "stop"),
    ("cut that out", "stop"),
    ("pack it in", "stop"),
    ("leave it at that", "stop"),
    ("give it a rest", "stop"),
    ("call it off", "stop"),
    ("call that off", "stop"),
    ("give up", "stop"),
    ("break off", "stop"),
    ("drop everything", "stop"),
    ("^ drop that $", "let go of it"),
    ("have a break", "rest"),
    ("take a break", "rest"),
    ("take five", "rest"),
    ("a break $", "a rest"),
    ("the coast is clear", "nothing is there"),
    ("steer clear", "keep clear"),
    ("give it a wide berth", "keep clear of it"),
    ("keep an eye out", "watch out"),
    ("look sharp", "watch out"),
    ("do the trick", "work"),
    ("up you get", "stand up"),
    ("up you come", "stand up"),
    ("sit bolt upright", "sit upright"),
    ("in a row", ""),
    ("get your hands on", "grab"),
    ("lay your hands on", "touch"),
    ("get a hold of", "grab"),
    ("take a hold of", "grab"),
    ("get shot of", "put away"),
    ("get rid of", "remove"),
    ("how come", "why"),
    ("come up with", "find"),
    ("i was wondering", "i wonder"),
    ("i was just wondering", "i wonder"),
    ("for once", ""),
    ("in detail", "carefully"),
    ("in depth", "carefully"),
    ("right back $", "back"),
    ("no end", ""),
    ("do not get hit", "dodge it"),
    ("stand easy", "relax"),
    ("end it here", "goodbye"),
    ("end it there", "goodbye"),
    ("your way $", "towards you"),
    ("try not to get hit", "dodge it"),
    ("would you say it is", "is it"),
    ("would you say that it is", "is it"),
    ("do you think it is", "is it"),
    ("do you think that it is", "is it"),
    ("do you reckon it is", "is it"),
    ("until next time", "goodbye"),
    ("pat on the back", "pat of your back"),
    ("give yourself a", "give a"),
    ("go for it", "yes"),
    ("mind out", "watch out"),
    ("avoid being hit", "dodge it"),
    ("avoid getting hit", "dodge it"),
    ("avoid a collision", "dodge it"),
    ("happen to be", "be"),
    ("yourself on the", "your"),
    ("yourself in the", "your"),
    ("arm is reach", "reach"),
    ("arm is length", "arms length"),
    ("would you call", "is"),
    ("over the moon", "happy"),
    ("let us stop here for", "goodbye for"),
    ("stop here for", "goodbye for"),
    ("stop for today", "goodbye"),
    ("stop for now", "goodbye"),
    ("i am leaving", "goodbye"),
    ("i am going now", "goodbye"),
    ("i am off", "goodbye"),
    ("from memory", ""),
    ("put some distance", "put more distance"),
    ("keep me posted", "tell me"),
    ("hey there $", "hello"),
    ("^ hey there", "hello"),
    ("^ hi there", "hello"),
    ("how is it going", "how are you"),
    ("how are things", "how are you"),
];

/// Words beside which a clause may begin or end as well.
const BESIDE: [&str; 6] = ["max", "please", "now", "ok", "and", "so"];

/// The first idiom among words, by the marks behind each: where it begins, of how many words it is, and what it means.
pub(super) fn plain(texts: &[&str], marks: &[Option<Mark>]) -> Option<(usize, usize, &'static str)> {
    let idiom = |k: usize, idiom: &str| {
        let words: Vec<&str> = idiom.split(' ').filter(|word| !["^", "$", "!"].contains(word)).collect();
        let end = k + words.len();
        // A mark within it would part it.
        let there = texts[k..].starts_with(&words) && marks[k..end - 1].iter().all(Option::is_none);
        let begins = || k == 0 || marks[k - 1].is_some() || BESIDE.contains(&texts[k - 1]);
        let ends = || marks[end - 1].is_some() || texts.get(end).is_none_or(|next| BESIDE.contains(next));
        let aloud = || marks[end - 1] == Some(Mark::Cry);
        let fits = there
            && (!idiom.starts_with('^') || begins())
            && (!idiom.ends_with('$') || ends())
            && (!idiom.ends_with('!') || aloud());
        fits.then_some(words.len())
    };
    (0..texts.len()).find_map(|k| IDIOMS.iter().find_map(|(said, meant)| Some((k, idiom(k, said)?, *meant))))
}

/// All words of it.
pub(super) fn words() -> impl Iterator<Item = &'static str> {
    let all = IDIOMS.iter().flat_map(|(idiom, meant)| idiom.split(' ').chain(meant.split(' ')));
    all.filter(|word| !word.is_empty() && word.chars().all(|c| c.is_ascii_lowercase()))
}
