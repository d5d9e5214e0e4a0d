//! What words mean: acts, relations and modifiers, a table each, and words that have no meaning of their own here.

use std::cmp::Reverse;
use std::collections::BTreeMap;

use super::words::Word;

/// What is done, and the verbs that say so.
const ACTS: &str = "\
    TOUCH: touch tap poke contact stroke pat prod nudge brush press rub tickle knock meet feel finger pet \
        jab dab graze caress boop rap flick smack fondle nuzzle; \
    TEND: scratch squeeze pinch cover tug pull slap massage cup hug clutch hit approach point wipe thump \
        cradle pound smack caress; \
    REACH: reach stretch extend strain; \
    GRAB: grab clutch grasp seize grip clasp hold catch take grapple snatch nab clench snag cradle receive; \
    LIFT: lift raise hoist heave elevate pick uplift scoop heft pluck; \
    PUT: put place set lay move position stow stick deposit relocate reposition transport carry stand rest \
        pop plonk park install plant perch arrange situate dump transfer; \
    PUSH: push shove slide send nudge shift throw toss thrust scoot propel displace chuck hurl shuffle \
        fling flick bump sling roll steer sweep jog swipe banish shoo boot veer; \
    PULL: bring pull fetch draw drag haul tug retrieve collect recover yank tow reel lug gather rein; \
    DROP: release drop free unhand relinquish unclasp ungrip unclench loosen loose unclamp detach disengage \
        unfasten ungrasp ditch unhold; \
    LEAN: lean bend tilt bow stoop hunch incline tip crouch slant slope hinge pitch; \
    STRAIGHTEN: straighten unbend sit rise uncurl unfold erect unlean unhunch recline; \
    SEARCH: explore search scan scour sweep comb probe survey hunt seek grope fumble rummage scout forage \
        root fish rake trawl patrol browse scope; \
    LOOK: look see; \
    FIND: find locate discover detect encounter spot identify; \
    FEEL: feel sense perceive notice palpate; \
    EXAMINE: examine inspect investigate study trace measure check determine verify test learn recognise \
        recognize figure map outline assess analyse analyze ascertain gauge confirm scrutinise scrutinize \
        handle suss; \
    RUN: run pass glide wander follow trace slide move go stroke guide draw sweep brush walk wave swing; \
    AVOID: avoid dodge evade duck swerve flinch sidestep shun escape elude flee retreat recoil scram; \
    PROTECT: protect defend save guard shield; \
    GO: go come move get step return; \
    RELAX: rest relax unwind chill idle simmer slack; \
    FORGET: forget erase unlearn delete disregard discard purge ignore unremember; \
    CLEAR: clear clean empty wipe reset flush banish dismiss remove strike drop dump purge blank scrub \
        unremember; \
    REPEAT: repeat retry redo rerun replay ditto rinse; \
    TRY: try attempt; \
    DO: do perform make; \
    STOP: stop interrupt halt cease pause abort cancel desist abandon scrap; \
    END: end finish terminate conclude close stop leave quit exit; \
    KEEP: keep stay remain hold stand sit lie wait be; \
    TELL: tell say describe report explain show name state mention list summarise summarize recap recount \
        estimate announce indicate specify recite brief; \
    KNOW: know remember recall wonder guess see think reckon believe; \
    COUNT: count tally; \
    EXPERIENCED: find feel touch discover meet detect notice hold know search explore come; \
    GIVE: give hand pass return; \
    USE: use; \
    LET: let; \
    HAVE: have get; \
    HAPPEN: happen occur; \
    INTRODUCE: introduce present; \
    SPEAK: talk speak chat ask command instruct control operate type; \
    CALIBRATE: calibrate recalibrate relearn; \
    STIR: move budge stir twitch wiggle wriggle fidget shift wobble shake; \
    CARE: want need like love prefer wish expect mind hope enjoy hate dislike mean choose start begin put \
        set help assist work turn lower open ease bump run make become leave log shut switch change play \
        withdraw retract hang lay fall lose sink shrink shy widen increase reduce decrease shorten narrow \
        maximise maximize minimise minimize matter appreciate thank suggest succeed proceed continue add \
        repeat fit weigh seem appear sound resemble suppose imagine pretend assume manage freeze settle \
        welcome understand obey answer agree refuse fail order allow permit watch listen hear wrap roll \
        lean dare attend undo deserve earn call slump slouch fly approach attack travel sway crash hurtle \
        yield stroll resume adopt kick jump clap sing dance forbid object ban miss ask happen greet excuse \
        figure cut act react notice remind grope blow carry hide beat identify update fill nail rock bother \
        dismiss depart power wake fidget cry establish kick nod ease";
/// How things are placed and moved, and of which kind they are.
const RELATIONS: &str = "\
    FARTHER: farther further farthest furthest away miles; \
    FAR: far farther further farthest furthest away distant remote off beyond miles opposite apart yonder \
        outward outwards outlying; \
    NEAR: near nearer nearest close closer closest nearby here adjacent inward inwards; \
    FORWARD: forward forwards ahead forth; \
    UP: up upward upwards; \
    UPRIGHT: upright straight erect tall vertical; \
    DOWN: down downward downwards; \
    BACK: back backward backwards; \
    SIDEWAYS: aside sideways over; \
    AROUND: around about round along over across through everywhere; \
    ON: on onto upon to against at towards toward over across in; \
    OF: of on at from; \
    TABLE: table tabletop desk surface worktop counter; \
    SPACE: space area surroundings environment surface scene place vicinity top region room surrounding \
        workspace tabletop; \
    REACHABLE: reachable touchable accessible graspable unreachable attainable; \
    RANGE: reach range grasp arm length stretch workspace; \
    LENGTH: length extent reach; \
    GAP: distance gap space separation room; \
    EDGE: edge edges corner corners rim sides outside outline contour contours surface geometry curves \
        dimensions extent; \
    FORM: shape shaped form outline contour contours silhouette geometry; \
    KIND: kind sort type manner kinds sorts types; \
    SHAPED: round square flat rectangular spherical cylindrical cubic cubical curved pointed pointy sharp \
        smooth rough hard soft angular oval boxy bumpy elongated hollow conical symmetric symmetrical \
        rounded roundish squarish roundness sphere cylinder cube corner corners edge edges lopsided even \
        spiky; \
    SIZED: big bigger biggest large larger small smaller huge tiny wide wider tall taller long longer thick \
        thicker high higher narrow bulky broad deep thin short little great fat slim massive; \
    SIZE: size sizes dimension dimensions extent extents diameter width breadth volume length height girth \
        measurements radius thickness proportions measurement; \
    UNIT: centimetre centimetres centimeter centimeters cm inch inches metre metres meter meters millimetre \
        millimetres mm foot; \
    WHEREABOUTS: where whereabouts location position place spot coordinates direction bearing site posture \
        pose orientation; \
    CONTACT: contact sensation sensations feeling feelings pressure touch; \
    POSE: position posture pose place stance state spot configuration; \
    START: start starting initial original beginning resting rest home neutral default ready waiting old \
        normal base previous usual idle configuration; \
    MEMORY: memory mind memories head slate history knowledge record list thoughts; \
    COMMANDS: commands command abilities ability skills skill options instructions requests functions \
        features actions tasks tricks sentences questions capabilities talents repertoire words manual menu \
        usage examples example request vocabulary tips tip hint hints guidance advice explanation; \
    TALK: conversation talk session chat dialogue program game meeting call; \
    BEING: creature robot being person machine human man woman computer";
/// How, how often, how much.
const MODIFIERS: &str = "\
    AGAIN: again anew afresh once; \
    MORE: more another further additional extra; \
    ALL: all everything every whole entire; \
    NUMBER: one two three four five several many; \
    STILL: still motionless immobile frozen quiet steady unmoving stationary fixed put; \
    BIT: bit little lot much tad touch; \
    GOOD: good nice great lovely wonderful splendid helpful handy useful super brilliant fantastic \
        marvellous excellent perfect ideal best better wise clever kind sweet cool awesome amazing fun \
        grateful glad happy happier pleased delighted thankful obliged thrilled grand terrific preferable \
        sensible superb neat fine well dandy swell dear angel impressive tremendous stellar star hero \
        legend genius smashing ace fab fabulous magnificent outstanding beautiful gorgeous smart top \
        stunning phenomenal first-rate; \
    BAD: bad wrong terrible awful horrible rude angry upset sad unhappy annoyed shame pity unwise dangerous \
        foolish silly mistake; \
    THANKS: thank thanks grateful ta appreciate appreciated thankful cheers obliged indebted kudos bravo \
        superb thankyou tysm thanx merci gracias congratulations congrats hooray hurrah props; \
    HELLO: hello hi hey hiya howdy greetings welcome yo salutations gday sup ahoy heya hullo hallo wassup \
        evening morning; \
    BYE: cheerio bye goodbye farewell ciao adieu byebye adios laters toodle toodles tata cya seeya; \
    YES: yes yeah yep yup yea aye sure ok okay alright absolutely certainly definitely affirmative agreed \
        correct exactly indeed precisely right true naturally fine righto roger okie okey dokie totally \
        bingo mhm k kk alrighty uhhuh positive; \
    NO: no nope nah negative nay naw uhuh nix; \
    ASKING: what where when why who which how whereabouts whose whom; \
    HELPING: can could will would may might shall should must do be have need ought; \
    HELPED: have do be not never just already first last yet even; \
    LATELY: first last before just so far earlier yet across; \
    PARTING: with by and then please or but using; \
    SUBJECT: i you he she it we they there their this that these those who everybody nobody somebody people";
/// Of what things are called that it felt and cannot see; what these are is told by the very word, not by its lemma.
const NAMES: &str = "\
    NOUN: thing object item stuff obstacle ball box bottle brick block cup mug bowl plate jar book pen pencil \
        spoon fork knife stick rod toy apple orange banana phone pot vase tray lamp tool gadget thingy thingie \
        thingamajig whatsit package parcel carton tube cone dice egg candle camera cube cylinder sphere gizmo \
        doodad contraption article target device widget jug teapot kettle flask tumbler wallet figurine doll \
        torch mouse notebook stapler sponge hammer lemon tomato potato container piece lump chunk thingummy \
        doohickey; \
    PLURAL: things objects items obstacles keys cans bottles boxes blocks cups balls bricks ones; \
    AMBIGUOUS: can one die key glass tin; \
    INDEFINITE: something anything someone somebody anybody anyone; \
    DETERMINER: the this that these those a an some any another every all both each one more other which \
        whichever two three its; \
    DEFINITE: the this that these those both all; \
    VAGUE: a an any some another more; \
    ADJECTIVE: left right near nearer nearest close closer closest far farther farthest further furthest big \
        bigger biggest large larger small smaller little long tall short round square hard soft light heavy \
        first second third last latest other same new old nice whole entire single next remaining opposite \
        front back flat smooth different middle rightmost leftmost latter former hand more; \
    UNPICKING: back front hand middle whole entire same";
/// Words without a meaning of their own here.
const FUNCTION: &str = "because him her himself yesterday after during since unlike underneath among lets centre center \
     everyone six seven eight nine ten least few lots having impossible sorry mr names word question \
     difference separate fast seconds sec slight neighbourhood parts bits respect relation relative \
     reference perspective viewpoint compared measured though although however mine yours ours attention \
     fair unsure exact good-bye via otherwise no-one terms mistaken interest tired seat leftward leftwards \
     rightward rightwards till detail thorough funny left-hand right-hand jiffy today fresh anywhere careful \
     together alert awake barely comfortable familiar harder impression numerous plenty sleep sufficient \
     watchful works aloft horses faces doing happening located sounds sum half beginning case";
/// Irregular forms of verbs; `*` where it is also the base form.
const IRREGULAR: &str = "felt feel,found find,held hold,took take,taken take,caught catch,brought bring,got get,gotten get,\
     went go,gone go,came come,put put*,set set*,let let*,hit hit*,laid lay,stood stand,sat sit,lain lie,\
     kept keep,left leave,lost lose,ran run,threw throw,thrown throw,drew draw,drawn draw,sent send,\
     stuck stick,slid slide,swept sweep,sought seek,bent bend,leant lean,rose rise,risen rise,fell fall,\
     fallen fall,forgot forget,forgotten forget,did do,done do,does do,made make,told tell,said say,\
     shown show,knew know,known know,gave give,given give,met meet,saw see,seen see,was be,were be,been be,\
     am be,is be,are be,has have,had have,thought think,meant mean,spoke speak,spoken speak,began begin,\
     begun begin,chose choose,chosen choose,understood understand,learnt learn,hung hang,froze freeze,\
     frozen freeze,shrank shrink,became become,flew fly,heard hear,read read*,shut shut*,cut cut*,\
     unbent unbend,undid undo,undone undo,lit light,swung swing,sank sink,blew blow,quit quit*,dying die,\
     forbidden forbid,forbade forbid";

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
        for verb in rows(ACTS).flat_map(|(_, verbs)| verbs.split_whitespace()) {
            for (text, form) in inflected(verb) {
                forms.entry(text).or_insert((verb.to_string(), form));
            }
            forms.insert(verb.to_string(), (verb.to_string(), Form::Base));
        }
        for (text, lemma) in IRREGULAR.split(',').filter_map(|pair| pair.split_once(' ')) {
            let (lemma, form) = match lemma.strip_suffix('*') {
                Some(lemma) => (lemma, Form::BaseOrPast),
                None if ["am", "is", "are", "has", "does"].contains(&text) => (lemma, Form::Third),
                None => (lemma, Form::Past),
            };
            forms.insert(text.to_string(), (lemma.to_string(), form));
        }
        let tables = [RELATIONS, MODIFIERS, NAMES]
            .into_iter()
            .flat_map(rows)
            .flat_map(|(_, words)| words.split_whitespace());
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
        let sorted = |word: &str| {
            let mut letters: Vec<char> = word.chars().collect();
            letters.sort_unstable();
            letters
        };
        let slips = match length {
            0..=2 => return None,
            3..=8 => 1,
            _ => 2,
        };
        let near = self.forms.iter().filter_map(|(known, (_, form))| {
            let letters = known.chars().count();
            let swapped = sorted(known) == sorted(typed);
            // What begins otherwise is another word; a short one lacks a letter, or has two swapped.
            let begins = known.chars().next() == typed.chars().next();
            let may_be = letters > 2 && (swapped || begins && letters.max(length) > 3);
            let distance = strsim::osa_distance(typed, known);
            // Of words that are as near one with the same letters, then one that agrees longest, then a verb.
            let like = (1e6 * strsim::jaro_winkler(typed, known)) as u32;
            let key = (distance, !swapped, Reverse(like), Reverse(letters), *form == Form::Other);
            (may_be && distance <= slips + usize::from(swapped)).then_some((key, known.as_str()))
        });
        near.min_by_key(|(key, _)| *key).map(|(_, known)| known)
    }
}

/// The lines of a table: a name, and its words.
fn rows(table: &'static str) -> impl Iterator<Item = (&'static str, &'static str)> {
    table.split(';').filter_map(|row| row.trim().split_once(": "))
}

/// What a word means: the names of the tables' lines that it stands in.
pub(super) fn meanings(lemma: &str, text: &str) -> impl Iterator<Item = &'static str> {
    let has = move |words: &str| words.split_whitespace().any(|word| word == lemma || word == text);
    let tables = [ACTS, RELATIONS, MODIFIERS].into_iter().flat_map(rows).filter(move |(_, words)| has(words));
    let named = rows(NAMES).filter(move |(_, words)| words.split_whitespace().any(|word| word == text));
    tables.chain(named).map(|(name, _)| name)
}

/// The regular forms of a verb.
fn inflected(verb: &str) -> [(String, Form); 3] {
    let ends = |letters: &str, before: usize| {
        verb.chars().rev().nth(before).is_some_and(|letter| letters.contains(letter))
    };
    let vowel = |before: usize| ends("aeiou", before);
    let short = verb.len() <= 4 || ["unclasp", "forget", "begin", "ungrip", "sidestep"].contains(&verb);
    let doubles = short && !vowel(0) && !ends("wxy", 0) && vowel(1) && !vowel(2);
    let stem = match verb.strip_suffix('e') {
        Some(stem) => stem.to_string(),
        None if doubles => format!("{verb}{}", &verb[verb.len() - 1..]),
        None => verb.to_string(),
    };
    let with_i = verb.strip_suffix('y').filter(|_| !vowel(1)).map(|stem| format!("{stem}i"));
    let hisses = ends("sxo", 0) || ends("h", 0) && ends("cs", 1);
    let third = match &with_i {
        Some(with_i) => format!("{with_i}es"),
        None => format!("{verb}{}", if hisses { "es" } else { "s" }),
    };
    let ing = if verb.ends_with("ee") || verb.len() < 3 { verb } else { &stem };
    let past = format!("{}ed", with_i.as_ref().unwrap_or(&stem));
    [(past, Form::Past), (format!("{ing}ing"), Form::Ing), (third, Form::Third)]
}
