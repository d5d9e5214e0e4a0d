//! What words mean: acts, relations and modifiers, a table each, and words that have no meaning of their own here.

use std::cmp::Reverse;
use std::collections::BTreeMap;

use super::words::Word;

/// What is done, and the verbs that say so.
const ACTS: &[(&str, &str)] = &[
    (
        "TOUCH",
        "touch tap poke contact stroke pat prod nudge brush press rub tickle knock meet feel finger pet jab dab graze caress boop rap flick smack fondle nuzzle",
    ),
    (
        "TEND",
        "scratch squeeze pinch cover tug pull slap massage cup hug clutch hit approach point wipe thump cradle pound smack caress",
    ),
    ("REACH", "reach stretch extend strain"),
    (
        "GRAB",
        "grab clutch grasp seize grip clasp hold catch take grapple snatch nab clench snag cradle receive",
    ),
    ("LIFT", "lift raise hoist heave elevate pick uplift scoop heft pluck"),
    (
        "PUT",
        "put place set lay move position stow stick deposit relocate reposition transport carry stand rest pop plonk park install plant perch arrange situate dump transfer",
    ),
    (
        "PUSH",
        "push shove slide send nudge shift throw toss thrust scoot propel displace chuck hurl shuffle fling flick bump sling roll steer sweep jog swipe banish shoo boot veer",
    ),
    ("PULL", "bring pull fetch draw drag haul tug retrieve collect recover yank tow reel lug gather rein"),
    (
        "DROP",
        "release drop free unhand relinquish unclasp ungrip unclench loosen loose unclamp detach disengage unfasten ungrasp ditch unhold",
    ),
    ("LEAN", "lean bend tilt bow stoop hunch incline tip crouch slant slope hinge pitch"),
    ("STRAIGHTEN", "straighten unbend sit rise uncurl unfold erect unlean unhunch recline"),
    (
        "SEARCH",
        "explore search scan scour sweep comb probe survey hunt seek grope fumble rummage scout forage root fish rake trawl patrol browse scope",
    ),
    ("LOOK", "look see"),
    ("FIND", "find locate discover detect encounter spot identify"),
    ("FEEL", "feel sense perceive notice palpate"),
    (
        "EXAMINE",
        "examine inspect investigate study trace measure check determine verify test learn recognise recognize figure map outline assess analyse analyze ascertain gauge confirm scrutinise scrutinize handle suss",
    ),
    (
        "RUN",
        "run pass glide wander follow trace slide move go stroke guide draw sweep brush walk wave swing ",
    ),
    ("AVOID", "avoid dodge evade duck swerve flinch sidestep shun escape elude flee retreat recoil scram"),
    ("PROTECT", "protect defend save guard shield"),
    ("GO", "go come move get step return"),
    ("RELAX", "rest relax unwind chill idle simmer slack"),
    ("FORGET", "forget erase unlearn delete disregard discard purge ignore unremember"),
    (
        "CLEAR",
        "clear clean empty wipe reset flush banish dismiss remove strike drop dump purge blank scrub unremember",
    ),
    ("REPEAT", "repeat retry redo rerun replay ditto rinse"),
    ("TRY", "try attempt"),
    ("DO", "do perform make"),
    ("STOP", "stop interrupt halt cease pause abort cancel desist abandon scrap"),
    ("END", "end finish terminate conclude close stop leave quit exit"),
    ("KEEP", "keep stay remain hold stand sit lie wait be"),
    (
        "TELL",
        "tell say describe report explain show name state mention list summarise summarize recap recount estimate announce indicate specify recite brief",
    ),
    ("KNOW", "know remember recall wonder guess see think reckon believe"),
    ("COUNT", "count tally"),
    ("GIVE", "give hand pass return"),
    ("USE", "use"),
    ("LET", "let"),
    ("HAVE", "have get"),
    ("HAPPEN", "happen occur"),
    ("INTRODUCE", "introduce present"),
    ("SPEAK", "talk speak chat ask command instruct control operate type"),
    ("CALIBRATE", "calibrate recalibrate relearn"),
    ("STIR", "move budge stir twitch wiggle wriggle fidget shift wobble shake"),
    (
        "CARE",
        "want need like love prefer wish expect mind hope enjoy hate dislike mean choose start begin put set \
        help assist work turn lower open ease bump run make become leave log shut switch change play withdraw retract hang \
        lay fall lose sink shrink shy widen increase reduce decrease shorten narrow maximise maximize minimise minimize \
        matter appreciate thank suggest succeed proceed continue add repeat fit weigh seem appear sound resemble suppose imagine \
        pretend assume manage freeze settle welcome understand obey answer agree refuse fail order allow permit watch listen hear \
        wrap roll lean dare attend undo deserve earn call slump slouch fly approach attack travel sway crash hurtle yield stroll \
        resume adopt kick jump clap sing dance forbid object ban miss ask happen greet excuse figure cut act react notice remind grope blow carry hide beat identify update fill nail rock bother dismiss depart power wake fidget cry establish kick nod ease",
    ),
];
/// How things are placed and moved, and of which kind they are.
const RELATIONS: &[(&str, &str)] = &[
    ("FARTHER", "farther further farthest furthest away miles"),
    (
        "FAR",
        "far farther further farthest furthest away distant remote off beyond miles opposite apart yonder outward outwards outlying",
    ),
    ("NEAR", "near nearer nearest close closer closest nearby here adjacent inward inwards"),
    ("FORWARD", "forward forwards ahead forth"),
    ("UP", "up upward upwards"),
    ("UPRIGHT", "upright straight erect tall vertical"),
    ("DOWN", "down downward downwards"),
    ("BACK", "back backward backwards"),
    ("SIDEWAYS", "aside sideways over"),
    ("AROUND", "around about round along over across through everywhere"),
    ("ON", "on onto upon to against at towards toward over across in"),
    ("OF", "of on at from"),
    ("TABLE", "table tabletop desk surface worktop counter"),
    (
        "SPACE",
        "space area surroundings environment surface scene place vicinity top region room surrounding workspace tabletop",
    ),
    ("REACHABLE", "reachable touchable accessible graspable unreachable attainable "),
    ("RANGE", "reach range grasp arm length stretch workspace"),
    ("LENGTH", "length extent reach"),
    ("GAP", "distance gap space separation room"),
    (
        "EDGE",
        "edge edges corner corners rim sides outside outline contour contours surface geometry curves dimensions extent",
    ),
    ("FORM", "shape shaped form outline contour contours silhouette geometry"),
    ("KIND", "kind sort type manner kinds sorts types"),
    (
        "SHAPED",
        "round square flat rectangular spherical cylindrical cubic cubical curved pointed pointy sharp smooth rough hard soft \
        angular oval boxy bumpy elongated hollow conical symmetric symmetrical rounded roundish squarish roundness sphere cylinder cube \
        corner corners edge edges lopsided even spiky",
    ),
    (
        "SIZED",
        "big bigger biggest large larger small smaller huge tiny wide wider tall taller long longer thick thicker high higher narrow \
        bulky broad deep thin short little great fat slim massive",
    ),
    (
        "SIZE",
        "size sizes dimension dimensions extent extents diameter width breadth volume length height girth measurements radius \
        thickness proportions measurement",
    ),
    (
        "UNIT",
        "centimetre centimetres centimeter centimeters cm inch inches metre metres meter meters millimetre millimetres mm foot",
    ),
    (
        "WHEREABOUTS",
        "where whereabouts location position place spot coordinates direction bearing site posture pose orientation",
    ),
    ("CONTACT", "contact sensation sensations feeling feelings pressure touch"),
    ("POSE", "position posture pose place stance state spot configuration"),
    (
        "START",
        "start starting initial original beginning resting rest home neutral default ready waiting old normal base previous usual idle configuration",
    ),
    ("MEMORY", "memory mind memories head slate history knowledge record list thoughts"),
    (
        "COMMANDS",
        "commands command abilities ability skills skill options instructions requests functions features actions tasks tricks \
        sentences questions capabilities talents repertoire words manual menu usage examples example request vocabulary tips tip hint hints guidance advice explanation",
    ),
    ("TALK", "conversation talk session chat dialogue program game meeting call"),
    ("BEING", "creature robot being person machine human man woman computer"),
];
/// How, how often, how much.
const MODIFIERS: &[(&str, &str)] = &[
    ("AGAIN", "again anew afresh once"),
    ("MORE", "more another further additional extra"),
    ("ALL", "all everything every whole entire"),
    ("NUMBER", "one two three four five several many"),
    ("STILL", "still motionless immobile frozen quiet steady unmoving stationary fixed put"),
    ("BIT", "bit little lot much tad touch"),
    (
        "GOOD",
        "good nice great lovely wonderful splendid helpful handy useful super brilliant fantastic marvellous excellent perfect ideal \
        best better wise clever kind sweet cool awesome amazing fun grateful glad happy happier pleased delighted thankful obliged thrilled \
        grand terrific preferable sensible superb neat fine well dandy swell dear angel impressive tremendous stellar star hero legend genius smashing ace fab fabulous magnificent outstanding beautiful gorgeous smart top stunning phenomenal first-rate",
    ),
    (
        "BAD",
        "bad wrong terrible awful horrible rude angry upset sad unhappy annoyed shame pity unwise dangerous foolish silly mistake",
    ),
    (
        "THANKS",
        "thank thanks grateful ta appreciate appreciated thankful cheers obliged indebted kudos bravo superb thankyou tysm thanx merci gracias congratulations congrats hooray hurrah props",
    ),
    (
        "HELLO",
        "hello hi hey hiya howdy greetings welcome yo salutations gday sup ahoy heya hullo hallo wassup evening morning",
    ),
    ("BYE", "cheerio bye goodbye farewell ciao adieu byebye adios laters toodle toodles tata cya seeya"),
    (
        "YES",
        "yes yeah yep yup yea aye sure ok okay alright absolutely certainly definitely affirmative agreed correct exactly indeed \
        precisely right true naturally fine righto roger okie okey dokie totally bingo mhm k kk alrighty uhhuh positive",
    ),
    ("NO", "no nope nah negative nay naw uhuh nix"),
    ("ASKING", "what where when why who which how whereabouts whose whom"),
    ("HELPING", "can could will would may might shall should must do be have need ought"),
    (
        "SUBJECT",
        "i you he she it we they there their this that these those who everybody nobody somebody people",
    ),
];
/// Words without a meaning of their own here.
const FUNCTION: &str = "a an the of to in on at by for with from into and or but not never nor neither if unless whether because so as \
    than then that this these those it its he she him her his they them their we us our i me my you your yourself himself please \
    very really quite rather too just only even also still yet already ever soon later today tomorrow yesterday now time times moment \
    any some every each both all none nothing nobody no other another same such own else instead without before after until while during \
    since like unlike about above below under beneath underneath behind beside between among up down out off over there here away \
    what who whom whose which why how when where would will can could may might must shall should ought let lets once twice first \
    second third last next left right middle centre center front hand side half end top bottom way thing things stuff something \
    anything everything someone anyone somebody anybody everyone max robot mate buddy partner friend one two three four five six seven \
    eight nine ten number enough more most less least much many few little lot lots bit maybe perhaps possibly probably kindly gently \
    carefully slowly quickly softly lightly firmly straight well ok okay oh um uh er hmm ah hey good day night morning evening afternoon \
    again back ahead forward be am is are was were been being do does did done doing have has had having got gotten going gone \
    able possible impossible sure certain safe easy hard ready willing free chance favour favor sorry mr name names \
    life idea job turn task mission goal aim word words question answer problem trouble bother difference success luck result outcome \
    upshot progress news summary story account rundown brief short long able capable allowed supposed dead statue rock stone muscle step \
    inch movement movements motion motions trunk waist posture air mid light quick full maximum maximal separate different total \
    numerous real alive virtual called named nice boy break breather ease lap asap fast while minute second seconds sec wee tiny slight \
    scratch slate fresh purpose function body skin receptor receptors finger hand grip fist fingers grasp hold neighbourhood parts part \
    bit bits small respect relation relative reference perspective viewpoint compared measured seen though although however both by \
    mine yours ours attention careful hurry fair lost confused stuck horses ground wait help harm guard room berth distance cover \
    evasive incoming opposite table stick rod unsure exact exactly precisely roughly approximately actually certainly definitely simply \
    slightly immediately directly completely absolutely perfectly entirely thoroughly closely further farther proper tight firm total \
    encore shot crack whirl bash stab go kindness solid good-bye via using onto upon toward towards within inside outside against \
    nose everywhere anywhere somewhere nowhere otherwise rid under no-one terms course means true false incorrect mistaken stop \
    curious interested interest unsure business tired seat leftward leftwards rightward rightwards empty bare goes belongs lad till detail thorough path funny appreciated heavy sense physical left-hand right-hand sec jiffy whole self";
/// Irregular forms of verbs; `*` where it is also the base form.
const IRREGULAR: &str = "felt feel,found find,held hold,took take,taken take,caught catch,brought bring,got get,gotten get,went go,gone go,\
    came come,put put*,set set*,let let*,hit hit*,laid lay,stood stand,sat sit,lain lie,kept keep,left leave,lost lose,\
    ran run,threw throw,thrown throw,drew draw,drawn draw,sent send,stuck stick,slid slide,swept sweep,sought seek,bent bend,leant lean,\
    rose rise,risen rise,fell fall,fallen fall,forgot forget,forgotten forget,did do,done do,does do,made make,told tell,said say,shown show,\
    knew know,known know,gave give,given give,met meet,saw see,seen see,was be,were be,been be,am be,is be,are be,has have,had have,\
    thought think,meant mean,spoke speak,spoken speak,began begin,begun begin,chose choose,chosen choose,understood understand,\
    learnt learn,hung hang,froze freeze,frozen freeze,shrank shrink,became become,flew fly,heard hear,read read*,shut shut*,cut cut*,\
    unbent unbend,undid undo,undone undo,lit light,swung swing,sank sink,blew blow,quit quit*,dying die,forbidden forbid,forbade forbid";

/// Which form of a verb a word is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Form {
    /// As it is told: `touch`.
    Base,
    /// As it is told, or of what was: `put`.
    BaseOrPast,
    /// `touched`.
    Past,
    /// `touching`.
    Ing,
    /// `touches`.
    Third,
    /// No verb.
    Other,
}

impl Form {
    /// Whether it may be told so.
    pub fn is_base(self) -> bool {
        matches!(self, Form::Base | Form::BaseOrPast)
    }
}

/// All words that are known.
pub(super) struct Lexicon {
    /// Of a word its lemma and form.
    forms: BTreeMap<String, (String, Form)>,
}

impl Lexicon {
    /// The tables' words, and some more that are no verbs.
    pub fn new(more: impl Iterator<Item = String>) -> Lexicon {
        let mut forms: BTreeMap<String, (String, Form)> = BTreeMap::new();
        for verb in ACTS.iter().flat_map(|(_, verbs)| verbs.split_whitespace()) {
            for (text, form) in inflected(verb) {
                forms.entry(text).or_insert((verb.to_string(), form));
            }
            forms.insert(verb.to_string(), (verb.to_string(), Form::Base));
        }
        for pair in IRREGULAR.split(',') {
            let Some((text, lemma)) = pair.trim().split_once(' ') else { continue };
            let (lemma, form) = match lemma.strip_suffix('*') {
                Some(lemma) => (lemma, Form::BaseOrPast),
                None if "am is are has does".split(' ').any(|third| third == text) => (lemma, Form::Third),
                None => (lemma, Form::Past),
            };
            forms.insert(text.to_string(), (lemma.to_string(), form));
        }
        let tables = RELATIONS.iter().chain(MODIFIERS).flat_map(|(_, words)| words.split_whitespace());
        for word in tables.chain(FUNCTION.split_whitespace()).map(String::from).chain(more) {
            forms.entry(word.clone()).or_insert((word, Form::Other));
        }
        Lexicon { forms }
    }

    /// A word, or the nearest that is known.
    pub fn word(&self, typed: &str) -> Word {
        let number = typed.chars().all(|c| c.is_ascii_digit() || c == '.');
        let known = self.forms.contains_key(typed) || number;
        let near = if known { None } else { self.nearest(typed) };
        let text = near.unwrap_or(typed);
        let (lemma, form) = self.forms.get(text).cloned().unwrap_or((text.to_string(), Form::Other));
        Word { text: text.into(), lemma, form, unknown: (!known).then(|| typed.to_string()), mark: None }
    }

    /// The known word that is nearest to one that is not, where it can be a slip of the pen.
    pub fn nearest(&self, typed: &str) -> Option<&str> {
        let length = typed.chars().count();
        let slips = match length {
            0..=2 => return None,
            3..=8 => 1,
            _ => 2,
        };
        let near = self.forms.iter().filter_map(|(known, (_, form))| {
            let letters = known.chars().count();
            if letters <= 2 || letters.abs_diff(length) > slips {
                return None;
            }
            let (same, slip) = (same_letters(typed, known), fingers_slip(typed, known));
            let begins = known.chars().next() == typed.chars().next();
            // A short word lacks a letter; what begins otherwise is another word, but for slips that are plain.
            let may_be = begins && (length > 3 || letters > 3) || length > 3 && slip || same;
            let distance = strsim::osa_distance(typed, known);
            if !may_be || distance > slips + usize::from(same) {
                return None;
            }
            // Of words that are as near a plain slip, then a letter that was left out, then a verb: what is done matters most.
            let plain = slip || letters > length;
            Some(((distance, !same, !plain, Reverse(known.len()), *form == Form::Other), known.as_str()))
        });
        near.min_by_key(|(key, _)| *key).map(|(_, known)| known)
    }
}

/// Whether two words have the same letters.
fn same_letters(a: &str, b: &str) -> bool {
    let [a, b] = [a, b].map(|word| {
        let mut letters: Vec<char> = word.chars().collect();
        letters.sort_unstable();
        letters
    });
    a == b
}

/// The keys of a keyboard.
const KEYS: [&str; 3] = ["qwertyuiop", "asdfghjkl", "zxcvbnm"];

/// Whether fingers slip to what was typed from what was meant: to a key beside one, or on one twice.
fn fingers_slip(typed: &str, meant: &str) -> bool {
    // In half keys: a lower row is shifted half a key to the right.
    let key = |letter: char| {
        let at = |(row, keys): (usize, &&str)| Some((row, 2 * keys.find(letter)? + row));
        KEYS.iter().enumerate().find_map(at)
    };
    let beside = |a: char, b: char| {
        let keys = key(a).zip(key(b));
        keys.is_some_and(|((row, x), (other, y))| row.abs_diff(other) <= 1 && x.abs_diff(y) <= 2)
    };
    let mut others = typed.chars().zip(meant.chars()).filter(|(a, b)| a != b);
    let twice = || {
        let letters: Vec<char> = typed.chars().collect();
        let once = |k: usize| letters[..k].iter().chain(&letters[k + 1..]).collect::<String>();
        (1..letters.len()).any(|k| letters[k] == letters[k - 1] && once(k) == meant)
    };
    let mut one = || others.next().is_some_and(|(a, b)| beside(a, b)) && others.next().is_none();
    if typed.len() == meant.len() { one() } else { twice() }
}

/// What a word means: the names of the tables' lines that it stands in.
pub(super) fn meanings(lemma: &str, text: &str) -> impl Iterator<Item = &'static str> {
    let tables = ACTS.iter().chain(RELATIONS).chain(MODIFIERS);
    let has = move |words: &str| words.split_whitespace().any(|word| word == lemma || word == text);
    tables.filter(move |(_, words)| has(words)).map(|(name, _)| *name)
}

/// The regular forms of a verb.
fn inflected(verb: &str) -> Vec<(String, Form)> {
    let mut letters = verb.chars().rev();
    let (last, second, third) = (letters.next(), letters.next(), letters.next());
    let vowel = |letter: Option<char>| letter.is_some_and(|letter| "aeiou".contains(letter));
    let short =
        verb.len() <= 4 || ["unclasp", "forget", "begin", "ungrip", "sidestep", "commit"].contains(&verb);
    let doubles =
        short && !vowel(last) && !matches!(last, Some('w' | 'x' | 'y')) && vowel(second) && !vowel(third);
    let (stem, ed) = match last {
        Some('e') => (verb.trim_end_matches('e').to_string(), "ed"),
        Some('y') if !vowel(second) => (verb.to_string(), "ied"),
        _ if doubles => (format!("{verb}{}", last.unwrap_or_default()), "ed"),
        _ => (verb.to_string(), "ed"),
    };
    let past = if ed == "ied" { format!("{}ied", &verb[..verb.len() - 1]) } else { format!("{stem}{ed}") };
    let third_person = match last {
        Some('y') if !vowel(second) => format!("{}ies", &verb[..verb.len() - 1]),
        Some('s' | 'x' | 'o') => format!("{verb}es"),
        Some('h') if matches!(second, Some('c' | 's')) => format!("{verb}es"),
        _ => format!("{verb}s"),
    };
    let ing =
        if verb.ends_with("ee") || verb.len() < 3 { format!("{verb}ing") } else { format!("{stem}ing") };
    vec![(past, Form::Past), (ing, Form::Ing), (third_person, Form::Third)]
}
