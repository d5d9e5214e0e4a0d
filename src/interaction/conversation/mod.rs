//! A partner's requests in plain words, and what a blindfolded creature says and does (IVA 2009, section 4).
//!
//! To teach it a request, see `requests/`.

mod requests;

use nalgebra::Vector3;
use serde_json::{Value, json};

pub use requests::{Intent, understood};

use super::actor::Actor;
use super::tasks::Trouble;
use super::things::{KnownThing, Things};
use crate::creature::Posture;
use crate::simulation::EngineError;

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
    /// What it remembers of things, and which of them is meant.
    things: Things,
    pending: Option<Request>,
    last: Option<Request>,
    ready: Posture,
    /// Whether a hand is where it was touched.
    at_spot: bool,
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
            things: Things::default(),
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
        let intent = understood(request);
        let text = request.to_lowercase();
        // An answer to its own question.
        if let Some(asked) = self.pending.take() {
            if let Some(which) = self.which(&text)
                && matches!(intent, Intent::Unknown | Intent::Touch | Intent::Explore)
            {
                self.things.mean(Some(which));
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
        let hand = self.hand_named(&text);
        if let Some(which) = self.which(&text)
            && self.things.len() > 1
        {
            self.things.mean(Some(which));
        }
        self.act(Request { intent, hand, lean: false })
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
        let intent = request.intent;
        let Some(kind) = intent.kind() else { return Ok(self.not_understood()) };
        if kind.needs_body
            && let Some(doubt) = self.doubt()
        {
            return Ok(self.reply(intent, doubt, Some(false), false));
        }
        if kind.needs_thing {
            self.last = Some(request);
            match self.things.it() {
                None if self.things.is_empty() => {
                    let said = "I have not felt anything yet: ask me to feel about first".to_string();
                    return Ok(self.reply(intent, said, Some(false), false));
                }
                None if self.things.len() > 1 => {
                    self.pending = Some(request);
                    return Ok(self.reply(intent, self.question(), None, true));
                }
                None => self.things.mean(Some(0)),
                Some(_) => {}
            }
        }
        (kind.act)(self, request)
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

    /// The limb that a receptor is on, as it says it.
    fn limb_in_words(&self, receptor: usize) -> String {
        let own = &self.actor.own;
        let limb = own.skin().receptors[receptor].limb;
        let aura = own.creature().aura_of(limb).map(|aura| own.creature().aura_limbs()[aura].name.clone());
        aura.unwrap_or_else(|| own.creature().limbs()[limb].clone()).replace('_', " ")
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
            let it = self.things.it().or((!self.things.is_empty()).then_some(0))?;
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
        let most = |value: &dyn Fn(&KnownThing) -> f64| self.things.most(value);
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
}
