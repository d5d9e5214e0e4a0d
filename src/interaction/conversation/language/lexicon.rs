//! The words that are known: verbs with their forms, other words as they are, and what a creature's parts are called.

use std::collections::BTreeMap;

use super::synonyms::{ALIKE, SYNONYMS};
use super::words::Word;

/// A verb's form.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Form {
    /// `touch`.
    Base,
    /// `touches`.
    Third,
    /// `touched`; also the participle.
    Past,
    /// `touching`.
    Ing,
    /// `put`, `put`: the base and the past are one.
    BaseOrPast,
    /// No verb.
    Other,
}

impl Form {
    /// Whether it can begin a command.
    pub fn is_base(self) -> bool {
        matches!(self, Form::Base | Form::BaseOrPast)
    }
}

/// Verbs that bend as a rule.
const REGULAR: &str = "watch touch reach tap poke contact stroke pat explore search look scan seek locate identify discover \
    probe grope sweep check examine inspect investigate sense push shove slide move place pull drag fetch draw lift \
    raise pick grasp grab hoist carry release drop lower avoid dodge evade duck escape lean bend tilt bow stoop \
    straighten rest relax return stop halt pause cease wait stay remain freeze report happen forget erase clear \
    repeat retry try help ask answer listen talk want need like wish love hope thank greet quit end finish exit \
    stretch extend point use press handle measure trace outline follow approach near count name call describe explain \
    remind guess compare estimate show refrain desist abstain prevent prohibit forbid ban allow permit \
    work act start continue turn rotate shift displace transport deposit position retrieve clasp grip \
    seize bump collide notice detect manage succeed fail attempt finish complete learn remember mind \
    believe wonder care play retreat advance back walk nudge prod brush scratch rub finger \
    recline slouch hunch crouch hover wiggle wave loosen open close squeeze confirm verify ensure \
    concern interest bother matter dare risk hesitate delay hurry rush step jump guide direct steer \
    retract remove clean pass toss fling chuck stow park ditch dispose undo reset resume restart proceed \
    enclose surround palpate tickle pinch calm settle hunt scout rummage survey scour comb fumble haul tug scoop heave \
    elevate relinquish unhand unclench banish scoot reposition deliver swerve flinch shrink massage tuck pop kick roll \
    whack knock study recognise recognize assist introduce summarise summarize recap chill unwind incline unbend \
    suggest propose recommend advise urge invite require encourage promise agree prefer appreciate enjoy please suit \
    trouble bother beg persuade order command request instruct deserve dislike hate loathe mind pretend imagine suppose \
    abort cancel change clutch collect conclude decrease defend delete determine dismiss discard disregard \
    encounter enlarge erect establish exchange fidget figure glide hug ignore increase maximise maximize minimise minimize obey \
    perceive perform purge reduce relocate resemble scrub snatch shorten slap slip stumble swap switch swipe terminate tidy \
    unclasp uncover ungrip unlearn unload wander widen wipe fancy yield budge stir twitch wriggle shield protect guard";
/// Verbs that do not: base, past, participle.
const IRREGULAR: &[[&str; 3]] = &[
    ["be", "was", "been"],
    ["do", "did", "done"],
    ["have", "had", "had"],
    ["go", "went", "gone"],
    ["come", "came", "come"],
    ["get", "got", "gotten"],
    ["put", "put", "put"],
    ["set", "set", "set"],
    ["let", "let", "let"],
    ["hit", "hit", "hit"],
    ["hurt", "hurt", "hurt"],
    ["find", "found", "found"],
    ["feel", "felt", "felt"],
    ["bring", "brought", "brought"],
    ["take", "took", "taken"],
    ["give", "gave", "given"],
    ["hold", "held", "held"],
    ["keep", "kept", "kept"],
    ["leave", "left", "left"],
    ["stand", "stood", "stood"],
    ["sit", "sat", "sat"],
    ["lay", "laid", "laid"],
    ["lie", "lay", "lain"],
    ["make", "made", "made"],
    ["say", "said", "said"],
    ["tell", "told", "told"],
    ["know", "knew", "known"],
    ["think", "thought", "thought"],
    ["see", "saw", "seen"],
    ["meet", "met", "met"],
    ["begin", "began", "begun"],
    ["shake", "shook", "shaken"],
    ["withdraw", "withdrew", "withdrawn"],
    ["throw", "threw", "thrown"],
    ["send", "sent", "sent"],
    ["catch", "caught", "caught"],
    ["run", "ran", "run"],
    ["swing", "swung", "swung"],
    ["understand", "understood", "understood"],
    ["mean", "meant", "meant"],
    ["choose", "chose", "chosen"],
    ["beware", "bewared", "bewared"],
    ["shut", "shut", "shut"],
    ["cut", "cut", "cut"],
    ["quit", "quit", "quit"],
    ["freeze", "froze", "frozen"],
    ["forget", "forgot", "forgotten"],
    ["forbid", "forbade", "forbidden"],
    ["draw", "drew", "drawn"],
    ["bend", "bent", "bent"],
    ["stick", "stuck", "stuck"],
    ["lose", "lost", "lost"],
    ["speak", "spoke", "spoken"],
    ["hear", "heard", "heard"],
    ["sink", "sank", "sunk"],
    ["rise", "rose", "risen"],
    ["steer", "steered", "steered"],
];
/// Verbs of one stressed syllable whose last letter doubles.
const DOUBLING: &[&str] = &[
    "put", "set", "let", "hit", "get", "sit", "tap", "pat", "grab", "stop", "drop", "forget", "begin",
    "prod", "scan", "quit", "shut", "cut", "run", "hug", "forbid", "ban", "grip", "bar", "rub", "nod",
    "step", "permit", "tug", "jab", "dab", "nab", "snag", "lug", "ram", "hug", "shun", "pet", "pop", "recap",
    "beg", "prefer", "stir", "slap", "slip", "swap", "ungrip", "scrub", "hug",
];
/// Words that bend not, or whose forms are words of their own.
const OTHERS: &str = "whatever whoever whichever i me my mine myself you your yours yourself he him his she her it its itself we us our they them their \
    this that these those there here one ones another other others both each every all any some none no not nothing \
    something anything everything nobody somebody anybody someone anyone thing things object objects item items stuff \
    obstacle obstacles \
    the a an and or but so then than if when while until unless before after because as though although whether once \
    to of in on at by for from with without within into onto upon off over under above below beneath behind beside \
    besides near nearby against between beyond through around about along across toward towards up down out away \
    back forward forwards backward backwards ahead front rear sideways apart together aside inward outward \
    left right upper middle hind top bottom side sides edge end tip point \
    what where which who whom whose why how \
    can could will would shall should may might must ought \
    please kindly maybe perhaps possibly possible just only even still again anew more less most least much many \
    few several enough too very quite rather pretty really actually now later soon immediately instantly today \
    tonight already yet ever never always sometimes often first second third last next finally \
    twice thrice times time moment minute second seconds bit little lot way ways place position spot \
    gently softly carefully slowly quickly fast slow gentle careful lightly light firmly briefly directly straight \
    upright normally quietly calmly steadily straightaway properly exactly nicely neatly \
    hello hi hey hiya howdy greetings good morning afternoon evening night day welcome yo \
    bye goodbye farewell cheers thanks ta grateful appreciated appreciate ok okay alright fine great nice well sure \
    yes yeah yep yup aye nope nah correct wrong true false exactly indeed course absolutely certainly definitely \
    never mind sorry excuse pardon max robot buddy friend mate sir dear pal dude man \
    far farther farthest further furthest near nearer nearest close closer closest distant distance distances away \
    remote reachable reach range accessible touchable within beyond arms length centimetres centimeters metres \
    meters meter metre cm mm inches inch feet steps \
    big bigger biggest large larger largest small smaller smallest size sizes wide width tall taller height high \
    higher highest low lower lowest long longer longest short shorter shortest thick thin deep heavy dimensions \
    dimension extent extents diameter breadth depth volume huge tiny \
    shape shapes form round square flat rectangular spherical cylindrical cubic curved pointed sharp edgy smooth \
    rough hard soft angular outline contour contours surface corners corner edges sphere cube cylinder \
    ball box can bottle brick block cup mug glass bowl plate jar tin book pen pencil spoon fork knife stick rod toy \
    apple orange banana phone key keys can cans bottles boxes blocks cups pot vase tray lamp tool \
    gadget thingy thingie thingamajig whatsit doodah package parcel carton tube cone die dice egg candle camera watch \
    table tabletop desk surface board ground floor \
    hand hands arm arms fingers finger fingertip fingertips thumb palm palms fist limb limbs body skin self own \
    contact feeling sensation sensations number name home original initial resting starting start neutral \
    base default posture pose break ease loose tight alone be allowed able supposed going \
    glad happy new old same opposite different else instead anymore longer ago lately recently \
    earlier previously until case vicinity presence present alive busy ready done finished \
    everything memory memories list whereabouts location locations direction directions \
    abilities ability skills skill options option commands command capable instructions manual usage examples example \
    zero one two three four five six seven eight nine ten oh ah um uh er hmm wow lol haha per \
    whole entire single couple pair total altogether motionless immobile upwards downwards halfway completely \
    fully entirely simply gladly anyway anyways mistake accident careful attention luck chance idea question favour \
    favor business problem kind order turn job work motion movement movements \
    somewhere anywhere elsewhere everywhere nowhere someplace \
    fair roughly approximately precise precisely currently presently meanwhile anymore such \
    contactless possession comfortable comfortably safe safely \
    maximum max minimum utmost extreme incoming \
    two-handed handed upward upwards downward downwards leftward leftwards rightward rightwards curious detail details air path boy mug people person corner lap";

/// What is known of words.
pub struct Lexicon {
    entries: BTreeMap<String, (String, Form)>,
    /// What words are taken for.
    synonyms: BTreeMap<String, String>,
}

impl Lexicon {
    /// The words of all requests, and others that a creature's parts have.
    pub fn new<'a>(others: impl IntoIterator<Item = &'a str>) -> Lexicon {
        let mut lexicon = Lexicon { entries: BTreeMap::new(), synonyms: BTreeMap::new() };
        for verb in REGULAR.split_whitespace() {
            let irregular = IRREGULAR.iter().any(|[base, ..]| *base == verb);
            if !irregular {
                lexicon.verb([verb, &past(verb), &past(verb)]);
            }
        }
        IRREGULAR.iter().for_each(|forms| lexicon.verb(*forms));
        for (word, lemma, form) in [
            ("is", "be", Form::Third),
            ("are", "be", Form::Third),
            ("am", "be", Form::Third),
            ("were", "be", Form::Past),
            ("does", "do", Form::Third),
            ("has", "have", Form::Third),
        ] {
            lexicon.entries.insert(word.into(), (lemma.into(), form));
        }
        for word in OTHERS.split_whitespace().chain(others) {
            lexicon.entries.entry(word.into()).or_insert_with(|| (word.into(), Form::Other));
        }
        // What is more often no verb.
        for word in ["left", "back", "near", "like", "name", "right", "thought", "pleased"] {
            lexicon.entries.insert(word.into(), (word.into(), Form::Other));
        }
        // "Let us", as most write it.
        lexicon.entries.remove("lets");
        lexicon.learn_synonyms();
        lexicon
    }

    fn learn_synonyms(&mut self) {
        for (meant, words) in SYNONYMS {
            let Some([base, was, done]) = forms(meant) else { continue };
            for word in words.split_whitespace() {
                let [said, said_was, said_done] =
                    forms(word).unwrap_or([word.into(), past(word), past(word)]);
                for (said, meant) in [
                    (third(&said), third(&base)),
                    (ing(&said), ing(&base)),
                    (said_was, was.clone()),
                    (said_done, done.clone()),
                    (said, base.clone()),
                ] {
                    self.synonyms.insert(said, meant);
                }
            }
        }
        for (meant, words) in ALIKE {
            for word in words.split_whitespace() {
                self.synonyms.insert(word.into(), meant.to_string());
            }
        }
    }

    /// What a word is taken for: itself, or one that means the same here.
    pub(super) fn meant<'a>(&'a self, word: &'a str) -> &'a str {
        self.synonyms.get(word).map_or(word, String::as_str)
    }

    fn verb(&mut self, [base, past, participle]: [&str; 3]) {
        let form = if base == past { Form::BaseOrPast } else { Form::Base };
        let mut add = |text: String, form: Form| {
            self.entries.entry(text).or_insert_with(|| (base.to_string(), form));
        };
        add(base.to_string(), form);
        add(third(base), Form::Third);
        add(ing(base), Form::Ing);
        add(past.to_string(), Form::Past);
        add(participle.to_string(), Form::Past);
    }

    /// A word that is known.
    pub(super) fn word(&self, text: &str) -> Word {
        let (lemma, form) = self.entry(text).unwrap_or((text, Form::Other));
        Word { text: text.into(), lemma: lemma.into(), form, known: true, mark: None }
    }

    /// A verb as it is told: `touch` of `touched`.
    pub(super) fn told(&self, word: &Word) -> Word {
        if word.text == "left" {
            return Word { mark: word.mark, ..self.word("leave") };
        }
        let form = self.entry(&word.lemma).map_or(Form::Base, |(_, form)| form);
        let form = if form.is_base() { form } else { Form::Base };
        Word { text: word.lemma.clone(), form, ..word.clone() }
    }

    /// Whether a word is known as it is written.
    pub fn has(&self, word: &str) -> bool {
        self.entries.contains_key(word) || self.synonyms.contains_key(word)
    }

    /// A word's dictionary form, and which form it is.
    pub(super) fn entry(&self, word: &str) -> Option<(&str, Form)> {
        self.entries.get(word).map(|(lemma, form)| (lemma.as_str(), *form))
    }

    /// All words, those apart that are but taken for others.
    pub(super) fn words(&self) -> impl Iterator<Item = &str> {
        self.entries.keys().map(String::as_str)
    }
}

fn ends_in_consonant_and_y(verb: &str) -> bool {
    let mut letters = verb.chars().rev();
    letters.next() == Some('y') && letters.next().is_some_and(|c| !"aeiou".contains(c))
}

/// A verb without its silent e, or with its last letter doubled, where an ending makes it so.
fn stem(verb: &str) -> String {
    let doubled = DOUBLING.contains(&verb).then(|| verb.chars().last()).flatten();
    match (verb.strip_suffix('e'), doubled) {
        (Some(stem), _) if !verb.ends_with("ee") && verb != "be" => stem.to_string(),
        (_, Some(last)) => format!("{verb}{last}"),
        _ => verb.to_string(),
    }
}

/// A verb's base, past and participle; none where it is not known.
fn forms(verb: &str) -> Option<[String; 3]> {
    let irregular = IRREGULAR.iter().find(|[base, ..]| *base == verb);
    let regular = REGULAR.split_whitespace().any(|known| known == verb);
    irregular
        .map(|forms| forms.map(String::from))
        .or_else(|| regular.then(|| [verb.into(), past(verb), past(verb)]))
}

fn past(verb: &str) -> String {
    match ends_in_consonant_and_y(verb) {
        true => format!("{}ied", &verb[..verb.len() - 1]),
        false => format!("{}ed", stem(verb)),
    }
}

fn ing(verb: &str) -> String {
    if verb == "lie" { "lying".into() } else { format!("{}ing", stem(verb)) }
}

fn third(verb: &str) -> String {
    let hisses = ["s", "x", "z", "ch", "sh", "o"].iter().any(|end| verb.ends_with(end));
    match (ends_in_consonant_and_y(verb), hisses) {
        (true, _) => format!("{}ies", &verb[..verb.len() - 1]),
        (_, true) => format!("{verb}es"),
        _ => format!("{verb}s"),
    }
}
