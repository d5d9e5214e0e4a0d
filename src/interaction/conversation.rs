//! A partner's requests in plain words, and what a blindfolded creature says and does (IVA 2009, section 4).
//!
//! To teach it a request, add an [`Intent`], the words that mean it in [`understood`], and what it does in
//! [`Conversation::hear`].

use nalgebra::Vector3;
use serde::Serialize;
use serde_json::{Value, json};

use super::actor::{Actor, FoundThing};
use super::tasks::Trouble;
use crate::creature::Posture;
use crate::geometry::Capsule;
use crate::peripersonal::{Obstacle, OutOfReach};
use crate::simulation::EngineError;

/// Two things felt nearer than this to each other are one, metres.
const SAME: f64 = 0.09;
/// How far over the table's near edge something is that is brought near, metres.
const NEAR: f64 = 0.14;

/// What a partner may want.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Intent {
    /// To know whether something is there.
    Explore,
    /// That a thing is touched.
    Touch,
    /// That a thing is put far away.
    PutFar,
    /// That a thing is brought near.
    BringNear,
    /// That what failed, or was done before, is done again with the trunk leaning.
    LeanAndRetry,
    /// To know how far away a thing is.
    HowFar,
    /// To know where something is felt.
    WhereFelt,
    /// That it goes back to rest.
    Rest,
    /// To know what it feels where it is touched, and that it puts a hand there.
    FeelTouch,
    /// To know what it can do.
    Help,
    /// None of these.
    Unknown,
}

/// What it answers.
#[derive(Clone, Debug, PartialEq)]
pub struct Reply {
    /// What it took the request for.
    pub intent: Intent,
    /// What it says.
    pub said: String,
    /// Whether it did what was wanted, where something was.
    pub done: Option<bool>,
    /// Whether it waits for an answer.
    pub asks: bool,
    /// What it feels or knows of things: by whom felt, where.
    pub felt: Vec<Value>,
}

impl Reply {
    /// The reply as an object: `heard`, `intent`, `said`, `done`, `asks`, `felt`.
    pub fn to_json(&self, heard: &str) -> Value {
        json!({
            "heard": heard,
            "intent": self.intent,
            "said": self.said,
            "done": self.done,
            "asks": self.asks,
            "felt": self.felt,
        })
    }
}

/// What it remembers of a thing.
#[derive(Clone, Debug)]
struct KnownThing {
    found: FoundThing,
    /// Where it is, in the root's frame, metres.
    at: Vector3<f64>,
    /// The receptor of a hand that touches it, while one does.
    in_touch: Option<usize>,
}

/// A request that it waits to know more of, or may do again.
#[derive(Clone, Copy, Debug)]
struct Request {
    intent: Intent,
    hand: Option<usize>,
    lean: bool,
}

/// A creature in conversation.
pub struct Conversation {
    /// Who talks.
    pub actor: Actor,
    things: Vec<KnownThing>,
    /// Which thing "it" is.
    it: Option<usize>,
    pending: Option<Request>,
    last: Option<Request>,
    ready: Posture,
    /// Whether a hand is where it was touched.
    at_spot: bool,
}

/// What it can do, as it says it.
const ABILITIES: &str = "I can feel about for things (\"is there something in front of you?\"), touch what I felt with \
either hand, tell where I feel it and how far it is, put it as far away as possible, bring it near, lean forward and try \
again, and go back to rest";

/// What words mean.
pub fn understood(request: &str) -> Intent {
    let text = request.to_lowercase();
    let words: Vec<&str> =
        text.split(|c: char| !c.is_alphanumeric()).filter(|word| !word.is_empty()).collect();
    let any = |list: &[&str]| list.iter().any(|word| words.contains(word));
    match () {
        () if any(&["lean", "leaning"]) => Intent::LeanAndRetry,
        () if text.contains("how far")
            || text.contains("how near")
            || text.contains("how close")
            || any(&["distance"]) =>
        {
            Intent::HowFar
        }
        () if any(&["where"]) && any(&["feel", "felt", "touch", "is", "touched"]) => Intent::WhereFelt,
        () if any(&["put", "push", "place", "move", "set"])
            && any(&["far", "away", "farther", "farthest"]) =>
        {
            Intent::PutFar
        }
        () if any(&["bring", "pull", "fetch"])
            || (any(&["put", "move", "place"]) && any(&["near", "nearer", "closer", "close", "back"])) =>
        {
            Intent::BringNear
        }
        () if any(&["rest", "stop", "relax"]) || text.contains("let go") => Intent::Rest,
        () if any(&["help", "can"]) && any(&["help", "do"]) => Intent::Help,
        () if any(&[
            "something",
            "anything",
            "explore",
            "search",
            "find",
            "look",
            "feel",
            "around",
            "there",
        ]) && !any(&["touch", "reach"]) =>
        {
            Intent::Explore
        }
        () if any(&["touch", "reach", "tap", "point"]) => Intent::Touch,
        () => Intent::Unknown,
    }
}

impl Conversation {
    /// A creature that is where its hands wait, or goes there as far as it can; see [`Actor::ready`].
    ///
    /// # Errors
    /// Where the engine fails.
    pub fn new(mut actor: Actor) -> Result<Conversation, EngineError> {
        let ready = actor.ready();
        if actor.posture().distance(&ready) > 0.0
            && let Err(Trouble::Engine(error)) = actor.go(&ready)
        {
            return Err(error);
        }
        actor.wait(0.5)?;
        Ok(Conversation {
            actor,
            things: Vec::new(),
            it: None,
            pending: None,
            last: None,
            ready,
            at_spot: false,
        })
    }

    /// Hears a request, does what it can, and answers.
    ///
    /// # Errors
    /// Where the engine fails; all else is said in the reply.
    pub fn hear(&mut self, request: &str) -> Result<Reply, EngineError> {
        self.leave_spot();
        let mut intent = understood(request);
        let text = request.to_lowercase();
        // An answer to its own question.
        if let Some(asked) = self.pending.take() {
            if let Some(which) = self.which(&text)
                && matches!(intent, Intent::Unknown | Intent::Touch | Intent::Explore)
            {
                self.it = Some(which);
                return self.act(asked);
            }
            if intent == Intent::Unknown {
                self.pending = Some(asked);
                return Ok(self.reply(
                    asked.intent,
                    format!("I did not understand which one. {}", self.question()),
                    None,
                    true,
                ));
            }
        }
        let mut lean = false;
        let mut hand = self.hand_named(&text);
        if intent == Intent::LeanAndRetry {
            lean = true;
            match self.last {
                Some(last) => {
                    intent = last.intent;
                    hand = hand.or(last.hand);
                }
                None => {
                    return Ok(self.reply(
                        intent,
                        "There is nothing yet that I could try again leaning".into(),
                        Some(false),
                        false,
                    ));
                }
            }
        }
        if let Some(which) = self.which(&text)
            && self.things.len() > 1
        {
            self.it = Some(which);
        }
        self.act(Request { intent, hand, lean })
    }

    /// Is touched by its partner where a receptor is: says what it feels, and puts a hand there.
    ///
    /// The touch itself is not simulated: the receptor feels it.
    ///
    /// # Errors
    /// Where the engine fails; all else is said in the reply.
    pub fn touched(&mut self, receptor: usize) -> Result<Reply, EngineError> {
        let id = &self.actor.own.skin().receptors[receptor].id;
        let feels = format!("I feel you touch my {} (receptor {id})", self.limb_in_words(receptor));
        if let Some(doubt) = self.doubt() {
            return Ok(self.reply(Intent::FeelTouch, format!("{feels}. {doubt}"), Some(false), false));
        }
        self.leave_spot();
        self.let_be();
        let (said, done) = match self.actor.touch_own(receptor) {
            Ok(touch) => {
                self.at_spot = true;
                let name = self.actor.hands[touch.hand].name.replace('_', " ");
                let there = match touch.off {
                    off if off < 0.005 => "there".to_string(),
                    off => format!("{:.0} cm from there", (100.0 * off).max(1.0)),
                };
                (format!("{feels}, and put my {name} {there}"), true)
            }
            Err(Trouble::Engine(error)) => return Err(error),
            Err(trouble) => {
                self.at_spot = true;
                (format!("{feels}, but cannot put a hand there: {}", self.in_words(&trouble)), false)
            }
        };
        Ok(self.reply(Intent::FeelTouch, said, Some(done), false))
    }

    /// Takes a hand back from where it was touched.
    fn leave_spot(&mut self) {
        if std::mem::take(&mut self.at_spot) {
            let ready = self.ready.clone();
            // Where it cannot, the next motion says so.
            self.settle(&ready);
        }
    }

    fn act(&mut self, request: Request) -> Result<Reply, EngineError> {
        let Request { intent, hand, lean } = request;
        let needs_body =
            matches!(intent, Intent::Explore | Intent::Touch | Intent::PutFar | Intent::BringNear);
        if needs_body && let Some(doubt) = self.doubt() {
            return Ok(self.reply(intent, doubt, Some(false), false));
        }
        if matches!(intent, Intent::Touch | Intent::PutFar | Intent::BringNear) {
            self.last = Some(request);
            match self.it {
                None if self.things.is_empty() => {
                    let said = "I have not felt anything yet: ask me to feel about first".to_string();
                    return Ok(self.reply(intent, said, Some(false), false));
                }
                None if self.things.len() > 1 => {
                    self.pending = Some(request);
                    return Ok(self.reply(intent, self.question(), None, true));
                }
                None => self.it = Some(0),
                Some(_) => {}
            }
        }
        match intent {
            Intent::Explore => self.explore(hand),
            Intent::Touch => self.touch(hand, lean),
            Intent::PutFar => self.put(true, hand, lean),
            Intent::BringNear => self.put(false, hand, lean),
            Intent::HowFar => Ok(self.how_far()),
            Intent::WhereFelt => Ok(self.where_felt()),
            Intent::Rest => {
                self.actor.let_go();
                let ready = self.ready.clone();
                let went = self.settle(&ready);
                Ok(self.reply(
                    intent,
                    if went {
                        "I am at rest again"
                    } else {
                        "I cannot get back to rest: something is in the way"
                    }
                    .into(),
                    Some(went),
                    false,
                ))
            }
            Intent::Help => Ok(self.reply(intent, format!("{ABILITIES}."), None, false)),
            Intent::LeanAndRetry | Intent::FeelTouch | Intent::Unknown => Ok(self.reply(
                Intent::Unknown,
                format!("I did not understand that. {ABILITIES}."),
                None,
                false,
            )),
        }
    }

    fn reply(&self, intent: Intent, said: String, done: Option<bool>, asks: bool) -> Reply {
        let said = if said.ends_with(['.', '?']) { said } else { format!("{said}.") };
        let felt = self.things.iter().map(|known| self.known_json(known)).collect();
        Reply { intent, said, done, asks, felt }
    }

    fn known_json(&self, known: &KnownThing) -> Value {
        let receptor = &self.actor.own.skin().receptors[known.found.receptor];
        json!({
            "thing": known.found.thing,
            "felt_by": self.actor.own.creature().limbs()[receptor.limb],
            "receptor": receptor.id,
            "at": known.at.as_slice(),
            "in_touch": known.in_touch.is_some(),
        })
    }

    /// What went wrong, in words.
    fn in_words(&self, trouble: &Trouble) -> String {
        match trouble {
            Trouble::Hit(contacts) if !contacts.is_empty() => {
                format!("I ran into something with my {}", self.limb_in_words(contacts[0].spot.receptor))
            }
            trouble => trouble.to_string(),
        }
    }

    /// What it says where it does not know its body well enough; none where it does.
    fn doubt(&self) -> Option<String> {
        let actor = &self.actor;
        let [a, b] = actor.hands.each_ref().map(|hand| actor.own.place(hand.tip));
        let posture = actor.posture();
        let doubt = actor.own.trusts(&posture, [a.limb, b.limb], &a.point).err()?;
        Some(format!(
            "I do not know my body well enough for this: {doubt}. I should babble and touch myself more first"
        ))
    }

    fn hand_named(&self, text: &str) -> Option<usize> {
        // "The left one" is a thing, "your left hand" is not.
        let named = |side: &str| {
            ["hand", "arm", "foot", "claw", "side"]
                .iter()
                .any(|limb| text.contains(&format!("{side} {limb}")))
        };
        if text.contains("other hand") || text.contains("other arm") {
            let it = self.it.or((!self.things.is_empty()).then_some(0))?;
            return self.actor.arm_of(self.things[it].found.receptor).map(|hand| 1 - hand);
        }
        let left = (0..2).find(|&hand| self.actor.side(hand) > 0.0).unwrap_or(0);
        match (named("left"), named("right")) {
            (true, false) => Some(left),
            (false, true) => Some(1 - left),
            _ => None,
        }
    }

    /// Which of the things words tell apart.
    fn which(&self, text: &str) -> Option<usize> {
        let words: Vec<&str> = text.split(|c: char| !c.is_alphanumeric()).collect();
        let has = |word: &str| words.contains(&word);
        let left = self.actor.left();
        let front = self.actor.front;
        let most = |value: &dyn Fn(&KnownThing) -> f64| {
            (0..self.things.len()).max_by(|&i, &j| value(&self.things[i]).total_cmp(&value(&self.things[j])))
        };
        let by_hand = text.contains("hand") || text.contains("arm");
        match () {
            () if has("first") => (!self.things.is_empty()).then_some(0),
            () if has("second") || has("last") || has("latter") => self.things.len().checked_sub(1),
            () if has("left") && !by_hand => most(&|known| known.at.dot(&left)),
            () if has("right") && !by_hand => most(&|known| -known.at.dot(&left)),
            () if has("nearest") || has("nearer") => most(&|known| -known.at.dot(&front)),
            () if has("farthest") || has("farther") => most(&|known| known.at.dot(&front)),
            () => None,
        }
    }

    fn question(&self) -> String {
        let places: Vec<String> =
            self.things.iter().map(|known| format!("the one {}", self.place(&known.at))).collect();
        format!("I felt {} things: which one do you mean, {}?", places.len(), places.join(" or "))
    }

    /// Where a point is, in words.
    fn place(&self, at: &Vector3<f64>) -> String {
        let left = at.dot(&self.actor.left());
        let side = match left {
            x if x > 0.05 => format!("{:.0} cm to my left", 100.0 * x),
            x if x < -0.05 => format!("{:.0} cm to my right", -100.0 * x),
            _ => "straight ahead".into(),
        };
        format!("{:.0} cm in front of me, {side}", 100.0 * at.dot(&self.actor.front))
    }

    fn remember(&mut self, found: &FoundThing, in_touch: Option<usize>) -> usize {
        let at = found.point + found.direction * 0.02;
        let known = KnownThing { found: found.clone(), at, in_touch };
        let same = |other: &KnownThing| (other.at - known.at).norm() < SAME;
        match self.things.iter().position(same) {
            Some(i) => {
                self.things[i] = known;
                i
            }
            None => {
                self.things.push(known);
                self.things.len() - 1
            }
        }
    }

    /// Both hands to a posture; whether they got there.
    fn settle(&mut self, posture: &[f64]) -> bool {
        for _ in 0..3 {
            match self.actor.go(posture) {
                Ok(()) => return true,
                Err(Trouble::Hit(_)) => {}
                Err(_) => return false,
            }
        }
        false
    }

    /// Takes the arm that touches something back from it.
    fn let_be(&mut self) {
        let ready = self.ready.clone();
        for i in 0..self.things.len() {
            if self.things[i].in_touch.take().is_some() {
                let found = self.things[i].found.clone();
                // Where it cannot, the next motion says so.
                let _ = self.actor.withdraw(&found, &ready);
            }
        }
    }

    fn explore(&mut self, hand: Option<usize>) -> Result<Reply, EngineError> {
        self.let_be();
        if self.actor.table.is_none() {
            let heights: Vec<f64> = (0..2).filter_map(|hand| self.actor.feel_table(hand).ok()).collect();
            let Some(height) = heights.into_iter().reduce(f64::min) else {
                let said = "I lowered my hands and felt no table in front of me".to_string();
                return Ok(self.reply(Intent::Explore, said, Some(false), false));
            };
            self.actor.know_table(height);
        }
        // What is known already is kept clear of.
        let table = self.actor.clearance.obstacles.clone();
        for known in &self.things {
            self.actor.clearance.obstacles.push(Obstacle::Capsule(Capsule::ball(known.at, 0.07)));
        }
        let first = hand.unwrap_or(1);
        let mut found = None;
        for hand in [first, 1 - first].into_iter().take(if hand.is_some() { 1 } else { 2 }) {
            match self.actor.explore(hand) {
                Ok(Some(thing)) => {
                    found = Some(thing);
                    break;
                }
                Ok(None) | Err(Trouble::Hit(_) | Trouble::Nothing | Trouble::Reach(_)) => {
                    let ready = self.ready.clone();
                    self.settle(&ready);
                }
                Err(Trouble::Engine(error)) => return Err(error),
            }
        }
        self.actor.clearance.obstacles = table;
        let Some(found) = found else {
            let said = match self.things.len() {
                0 => "I felt about on the table as far as I reach and found nothing",
                _ => "I felt about and found nothing else",
            };
            return Ok(self.reply(Intent::Explore, said.into(), Some(true), false));
        };
        let before = self.things.len();
        let i = self.remember(&found, Some(found.receptor));
        self.it = (self.things.len() == 1).then_some(i);
        let limb = self.limb_in_words(found.receptor);
        let something = if self.things.len() > before && before > 0 { "something else" } else { "something" };
        let said = format!("Yes, I feel {something} with my {limb}, {}", self.place(&self.things[i].at));
        Ok(self.reply(Intent::Explore, said, Some(true), false))
    }

    fn limb_in_words(&self, receptor: usize) -> String {
        let own = &self.actor.own;
        let limb = own.skin().receptors[receptor].limb;
        let aura = own.creature().aura_of(limb).map(|aura| own.creature().aura_limbs()[aura].name.clone());
        aura.unwrap_or_else(|| own.creature().limbs()[limb].clone()).replace('_', " ")
    }

    fn touch(&mut self, hand: Option<usize>, lean: bool) -> Result<Reply, EngineError> {
        let i = self.it.expect("it is known which");
        let found = self.things[i].found.clone();
        let touching = self.things[i].in_touch.and_then(|receptor| self.actor.arm_of(receptor));
        let hand = hand.or_else(|| touching.map(|hand| 1 - hand)).unwrap_or(0);
        if touching == Some(hand)
            && self.things[i].in_touch.is_some_and(|r| self.actor.hands[hand].receptors.contains(&r))
        {
            let said = format!("My {} touches it already", self.actor.hands[hand].name.replace('_', " "));
            return Ok(self.reply(Intent::Touch, said, Some(true), false));
        }
        // Other things' arms first; the one that touches this goes back by itself.
        for k in (0..self.things.len()).filter(|&k| k != i) {
            self.things[k].in_touch = None;
        }
        if touching.is_none() {
            let ready = self.ready.clone();
            self.settle(&ready);
        }
        self.things[i].in_touch = None;
        let result = match touching {
            Some(_) => self.actor.touch(&found, hand, lean, 1),
            None => self.actor.touch_again(&found, hand, lean, 1),
        };
        let name = self.actor.hands[hand].name.replace('_', " ");
        match result {
            Ok(touching) => {
                self.things[i].found = touching.found.clone();
                self.things[i].at = touching.found.point + touching.found.direction * 0.02;
                self.things[i].in_touch = Some(touching.found.receptor);
                let said = match touching.corrections {
                    0 => format!("I touch it with my {name}"),
                    _ => format!("I had to feel about for it, and now touch it with my {name}"),
                };
                Ok(self.reply(Intent::Touch, said, Some(true), false))
            }
            Err(Trouble::Engine(error)) => Err(error),
            Err(trouble) => {
                let hint = match &trouble {
                    Trouble::Reach(OutOfReach::TooFar(_)) if !lean => "; I could lean forward and try again",
                    _ => "",
                };
                let said = format!("I cannot touch it with my {name}: {}{hint}", self.in_words(&trouble));
                Ok(self.reply(Intent::Touch, said, Some(false), false))
            }
        }
    }

    fn put(&mut self, far: bool, hand: Option<usize>, lean: bool) -> Result<Reply, EngineError> {
        let intent = if far { Intent::PutFar } else { Intent::BringNear };
        let i = self.it.expect("it is known which");
        let by_hand = |receptor: &usize| {
            let by = self.actor.arm_of(*receptor);
            by.is_some_and(|by| {
                self.actor.hands[by].receptors.contains(receptor) && hand.is_none_or(|hand| hand == by)
            })
        };
        if self.things[i].in_touch.filter(by_hand).is_none() {
            // Only what a hand touches can be held.
            let own_side = usize::from(self.actor.side(0) * self.things[i].at.dot(&self.actor.left()) < 0.0);
            let touched = self.touch(Some(hand.unwrap_or(own_side)), lean)?;
            if touched.done != Some(true) {
                return Ok(Reply { intent, ..touched });
            }
        }
        let receptor = self.things[i].in_touch.expect("a hand touches it");
        if !self.actor.hold(receptor) {
            self.things[i].in_touch = None;
            return Ok(self.reply(intent, "It slipped away: I no longer feel it".into(), Some(false), false));
        }
        let actor = &mut self.actor;
        if far && lean {
            // Where the other arm cannot make way, what is left is found all the same.
            if let Some(Err(Trouble::Engine(error))) =
                actor.arm_of(receptor).map(|hand| actor.make_way_to_lean(hand))
            {
                return Err(error);
            }
        }
        let limb = actor.own.place(receptor).limb;
        let (point, _) = actor.feels_at(receptor);
        let upright = actor.frames()[limb].rotation.tr_mul(&actor.up);
        let height = point.dot(&actor.up);
        let spot = match far {
            true => actor.farthest(receptor, height, upright, lean, 2),
            false => {
                let edge = actor.trunk_front(actor.table.unwrap_or(height));
                actor.spot_at(receptor, edge + NEAR, 0.15, height, upright)
            }
        };
        let Some(spot) = spot else {
            actor.let_go();
            return Ok(self.reply(intent, "I find no place for it that I reach".into(), Some(false), false));
        };
        let moved = spot.point - point;
        match self.actor.put(receptor, &spot, lean) {
            Ok(()) => {
                let known = &mut self.things[i];
                known.at += moved;
                known.found.point += moved;
                known.in_touch = None;
                let at = known.at;
                let ready = self.ready.clone();
                let back = self.settle(&ready);
                let how = if lean { "I leaned forward and put it" } else { "I put it" };
                let far = if far { " as far away as I could" } else { " near me" };
                let rest = if back { "" } else { "; my hand is still there" };
                let said = format!("{how}{far}: it is {} now{rest}", self.place(&at));
                Ok(self.reply(intent, said, Some(true), false))
            }
            Err(Trouble::Engine(error)) => Err(error),
            Err(trouble) => {
                self.actor.let_go();
                let said = format!("I held it, but did not get it there: {}", self.in_words(&trouble));
                Ok(self.reply(intent, said, Some(false), false))
            }
        }
    }

    fn how_far(&self) -> Reply {
        let it = self.it.or((self.things.len() == 1).then_some(0));
        let Some(known) = it.map(|i| &self.things[i]) else {
            let said =
                if self.things.is_empty() { "I have not felt anything yet".into() } else { self.question() };
            return self.reply(Intent::HowFar, said, None, false);
        };
        let distances = self.actor.distances(&known.at);
        let nearest = distances.iter().min_by(|a, b| a.1.total_cmp(&b.1));
        let hands = self.actor.hands.each_ref().map(|hand| {
            let distance =
                distances.iter().find(|(limb, _)| *limb == hand.limb).map_or(f64::NAN, |(_, d)| *d);
            format!("{:.0} cm from my {}", 100.0 * distance.max(0.0), hand.name.replace('_', " "))
        });
        let near = nearest.map_or(String::new(), |(limb, distance)| {
            let limb = self.actor.own.creature().limbs()[*limb].replace('_', " ");
            format!("; the nearest to it is my {limb}, {:.0} cm away", 100.0 * distance.max(0.0))
        });
        let said = format!("It is {}: {} and {}{near}", self.place(&known.at), hands[0], hands[1]);
        self.reply(Intent::HowFar, said, None, false)
    }

    fn where_felt(&self) -> Reply {
        let touching =
            self.things.iter().filter_map(|known| known.in_touch.map(|receptor| (known, receptor)));
        let told: Vec<String> = touching
            .map(|(known, receptor)| {
                let id = &self.actor.own.skin().receptors[receptor].id;
                format!(
                    "I feel it with my {} (receptor {id}), {}",
                    self.limb_in_words(receptor),
                    self.place(&known.at)
                )
            })
            .collect();
        let said = match (told.is_empty(), self.it.or(self.things.len().checked_sub(1))) {
            (false, _) => told.join("; "),
            (true, Some(i)) => {
                let known = &self.things[i];
                format!(
                    "I do not feel it now; I felt it with my {}, and it is {}",
                    self.limb_in_words(known.found.receptor),
                    self.place(&known.at)
                )
            }
            (true, None) => "I do not feel anything".into(),
        };
        self.reply(Intent::WhereFelt, said, None, false)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn requests_are_taken_for_what_they_mean() {
        for (request, intent) in [
            ("Is there something in front of you?", Intent::Explore),
            ("is there anything else?", Intent::Explore),
            ("touch it with your left hand", Intent::Touch),
            ("How far is it?", Intent::HowFar),
            ("put it as far away as possible", Intent::PutFar),
            ("bring it near", Intent::BringNear),
            ("put it back closer", Intent::BringNear),
            ("lean forward and try again", Intent::LeanAndRetry),
            ("Where do you feel this?", Intent::WhereFelt),
            ("what can you do?", Intent::Help),
            ("sing a song", Intent::Unknown),
            ("", Intent::Unknown),
        ] {
            assert_eq!(understood(request), intent, "{request}");
        }
    }
}
