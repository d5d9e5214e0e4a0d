//! A partner's requests in plain words, and what a blindfolded creature says and does (IVA 2009, section 4).
//!
//! To teach it a request, see `requests/`; what words mean is found out in `grammar/`.

pub mod grammar;
mod mind;
mod requests;
mod speaking;

use std::cell::OnceCell;
use std::sync::LazyLock;

use nalgebra::Vector3;
use serde_json::{Value, json};

pub use requests::Intent;

use self::grammar::{BodyNames, HandName, Language, Leave, Request, Understood, UnknownWord, Which};
use self::mind::{Deed, Forbidden, Mind};
use self::requests::{Act, Answer, REQUESTS};
use super::actor::Actor;
use super::tasks::{Grip, Search, tried};
use super::things::{KnownThing, ThingId, Things};
use crate::creature::Posture;
use crate::error::{Error, Result};
use crate::peripersonal::ReachableMap;

/// The voxels of the map that tells what its hands reach, metres.
const VOXEL: f64 = 0.04;

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

/// What it waits to be told.
enum Pending {
    /// Which thing is meant; there is leave for the rest.
    Which(Request, Leave),
    /// Whether it is to do it.
    Whether(Request),
}

/// Where it touches itself.
struct OwnSpot {
    /// The receptor that is touched.
    receptor: usize,
    /// Whether a stick touches it and no hand does.
    by_stick: bool,
}

/// How it holds something.
enum Held {
    /// Between both palms, by friction.
    Palms(Box<Grip>),
    /// By a weld of one hand, where the receptor touches it, raised by so much, metres.
    Stuck { receptor: usize, raised: f64 },
}

/// A creature in conversation.
pub struct Conversation {
    /// Who talks.
    pub actor: Actor,
    language: Language,
    /// What it remembers of things, and which of them is meant.
    pub(in crate::interaction) things: Things,
    /// Its search of the table, as far as it got; none where what stands on it may have changed since.
    search: Option<Search>,
    /// Where it felt things, in the root's frame, metres.
    felt: Vec<Vector3<f64>>,
    deeds: Vec<Deed>,
    forbidden: Vec<Forbidden>,
    pending: Option<Pending>,
    last: Option<Request>,
    ready: Posture,
    /// Where a hand of its own, or a stick in it, touches it.
    spot: Option<OwnSpot>,
    holding: Option<Held>,
    /// Whether it keeps still until it is asked for something.
    still: bool,
    over: bool,
    /// What its hands reach, once it was asked.
    reachable: OnceCell<Option<Vec<ReachableMap>>>,
}

impl Conversation {
    /// A creature that is where its hands wait, or goes there as far as it can; see [`Actor::ready`].
    ///
    /// # Errors
    /// Where the engine fails.
    pub fn new(mut actor: Actor) -> Result<Conversation, Error> {
        let ready = actor.ready();
        if actor.posture().distance(&ready) > 0.0 {
            tried(actor.go(&ready))?;
        }
        actor.wait(0.5)?;
        Ok(Conversation {
            language: language(BodyNames::of(&actor.own)),
            actor,
            things: Things::default(),
            felt: Vec::new(),
            deeds: Vec::new(),
            forbidden: Vec::new(),
            search: None,
            pending: None,
            last: None,
            ready,
            spot: None,
            holding: None,
            still: false,
            over: false,
            reachable: OnceCell::new(),
        })
    }

    /// Whether a partner has ended it.
    pub fn is_over(&self) -> bool {
        self.over
    }

    /// Hears what is said, does what it can if that is wanted, and answers.
    ///
    /// # Errors
    /// Where the engine fails; all else is said in the reply.
    pub fn hear(&mut self, said: &str) -> Result<Reply, Error> {
        let mut understood = self.language.understand(said);
        match self.pending.take() {
            Some(Pending::Whether(request)) => {
                if let Some(leave) = Leave::by_yes(&understood) {
                    self.forbidden.retain(|told| !told.bars_request(&request));
                    return self.moves(&request, leave);
                }
            }
            Some(Pending::Which(request, leave)) => {
                let which = understood.which.and_then(|which| self.which(which));
                let only_which = matches!(understood.intent, Intent::Which | Intent::Unknown | Intent::Yes);
                let answers = only_which || matches!(understood.intent, Intent::Touch | Intent::Lift);
                if let Some(id) = which.filter(|_| answers && !understood.forbids) {
                    self.things.mean(Some(id));
                    return self.moves(&request, leave);
                }
                if only_which && !understood.forbids {
                    let intent = request.intent;
                    self.pending = Some(Pending::Which(request, leave));
                    let said = format!("I did not understand which one. {}", self.question());
                    return Ok(self.reply(intent, Answer::asks(said)));
                }
            }
            None => {}
        }
        let request = understood.request.clone();
        if let Some(id) = request.which.and_then(|which| self.which(which)) {
            self.things.mean(Some(id));
        }
        let leave = understood.leave.take();
        self.act(request, leave, &understood.unknown)
    }

    /// Is touched by its partner where a receptor is: says what it feels, and puts a hand there, unless it was told to
    /// keep still.
    ///
    /// The touch itself is not simulated: the receptor feels it.
    ///
    /// # Errors
    /// Where the engine fails; all else is said in the reply.
    pub fn touched(&mut self, receptor: usize) -> Result<Reply, Error> {
        let id = &self.actor.own.skin().receptors[receptor].id;
        let feels = format!("I feel you touch my {} (receptor {id})", self.limb_in_words(receptor));
        let answer = match self.doubt() {
            _ if self.still => Answer::tells(format!("{feels}, and keep still")),
            Some(doubt) => Answer::failed(format!("{feels}. {doubt}")),
            None => self.puts_hand(receptor, &feels)?,
        };
        let mut reply = self.reply(Intent::FeelTouch, answer);
        self.heed_unexpected(&mut reply);
        Ok(reply)
    }

    /// Puts a hand to where it feels a touch.
    fn puts_hand(&mut self, receptor: usize, feels: &str) -> Result<Answer> {
        self.leave_spot();
        self.let_be();
        let touched = self.actor.touch_own(receptor);
        self.spot = Some(OwnSpot { receptor, by_stick: false });
        Ok(match touched {
            Ok(touch) => {
                let there = match touch.off {
                    off if off < 0.005 => "there".to_string(),
                    off => format!("{:.0} cm from there", (100.0 * off).max(1.0)),
                };
                Answer::done(format!("{feels}, and put my {} {there}", self.hand_name(touch.hand)))
            }
            Err(trouble) => {
                let trouble = self.in_words(&trouble.of_task()?);
                Answer::failed(format!("{feels}, but cannot put a hand there: {trouble}"))
            }
        })
    }

    /// Takes a hand back from where it touches its own skin.
    fn leave_spot(&mut self) {
        if self.spot.take().is_some() {
            // Where it cannot, the next motion says so.
            self.settle_at_ready();
        }
    }

    /// Answers a request, or does what it asks for where there is leave.
    fn act(
        &mut self,
        request: Request,
        leave: Option<Leave>,
        unknown: &[UnknownWord],
    ) -> Result<Reply, Error> {
        let intent = request.intent;
        let Some(kind) = intent.kind() else { return Ok(self.not_understood(unknown)) };
        let answer = match (&kind.act, leave) {
            (Act::Tells(_) | Act::Minds(_), _) if kind.needs_body && self.doubt().is_some() => {
                Answer::failed(self.doubt().unwrap_or_default())
            }
            (Act::Tells(tell), _) => self.relation(&request).unwrap_or_else(|| tell(self, &request)),
            (Act::Minds(mind), _) => mind(&mut self.mind(), &request),
            (Act::Moves(_) | Act::Handles(_), None) => {
                let doing = doing(&request);
                let asks = match unknown {
                    [] => format!("Do you want me to {doing}?"),
                    [word, ..] => format!("{}. Do you want me to {doing}?", word.in_words()),
                };
                self.asks_whether(request, asks)
            }
            (Act::Moves(_) | Act::Handles(_), Some(leave)) => {
                if !self.forbidden.iter().any(|told| told.bars_request(&request)) {
                    return self.moves(&request, leave);
                }
                let doing = doing(&request);
                self.asks_whether(
                    request,
                    format!("You told me not to {doing}: do you want me to do it now?"),
                )
            }
        };
        Ok(self.reply(intent, answer))
    }

    /// Asks whether it is to do something.
    fn asks_whether(&mut self, request: Request, said: String) -> Answer {
        self.pending = Some(Pending::Whether(request));
        Answer::asks(said)
    }

    /// Does what is asked for, for which there is leave.
    fn moves(&mut self, request: &Request, leave: Leave) -> Result<Reply, Error> {
        let intent = request.intent;
        let Some(kind) = intent.kind() else { return Ok(self.not_understood(&[])) };
        let doubt = if kind.needs_body { self.doubt() } else { None };
        if let Some(said) = doubt.or_else(|| self.barred_by_stick(request)) {
            return Ok(self.reply(intent, Answer::failed(said)));
        }
        if !matches!(
            intent,
            Intent::Repeat | Intent::LeanForward | Intent::LeanBack | Intent::Rest | Intent::LetGo
        ) {
            self.last = Some(request.clone());
        }
        // What is near is felt for first; what is felt then is touched.
        let mut feels_first = false;
        if matches!(kind.act, Act::Handles(_)) {
            match self.things.it().map(|known| known.id) {
                None if self.things.is_empty() && intent == Intent::Touch && request.any => {
                    feels_first = true;
                }
                None if self.things.is_empty() => {
                    let said = "I have not felt anything yet: ask me to feel about first";
                    return Ok(self.reply(intent, Answer::failed(said)));
                }
                None => {
                    let said = self.question();
                    self.pending = Some(Pending::Which(request.clone(), leave));
                    return Ok(self.reply(intent, Answer::asks(said)));
                }
                it => self.things.mean(it),
            }
        }
        self.still = false;
        self.leave_spot();
        self.put_by(intent)?;
        let acted = match (&kind.act, self.things.it().cloned()) {
            _ if feels_first => self.explore(self.hand_for(request.hand), false).map(|answer| {
                let done = Some(!self.things.is_empty());
                Answer { done, ..answer }
            }),
            (Act::Moves(act), _) => act(self, request, &leave),
            (Act::Handles(act), Some(thing)) => act(self, &thing, request, &leave),
            _ => return Ok(self.not_understood(&[])),
        };
        let answer = match acted {
            Ok(answer) => answer,
            Err(trouble) => {
                let trouble = self.in_words(&trouble.of_task()?);
                Answer::failed(format!("I cannot {}: {trouble}", doing(request)))
            }
        };
        let mut reply = self.reply(intent, answer);
        self.heed_unexpected(&mut reply);
        for known in self.things.iter().filter(|known| known.in_touch.is_some()) {
            mind::felt_at(&mut self.felt, known.found.point);
        }
        let retried = intent == Intent::LeanForward && (request.again || request.about.is_some());
        if intent != Intent::Repeat && !retried {
            self.did(request, &reply);
        }
        Ok(reply)
    }

    /// Puts down what it holds, unless what it is to do is done with it.
    fn put_by(&mut self, intent: Intent) -> Result<(), Error> {
        use Intent::{BringNear, LeanBack, LeanForward, LetGo, Lift, PutAside, PutFar, Repeat};
        let keeps = match intent {
            Lift | LetGo | Repeat => true,
            // Palms that face each other cannot lean.
            LeanForward | LeanBack => !matches!(self.holding, Some(Held::Palms(_))),
            _ => false,
        };
        if !keeps && let Some(held) = self.holding.take() {
            self.put_down(held)?;
            if !matches!(intent, PutFar | BringNear | PutAside) {
                self.actor.let_go();
            }
        }
        Ok(())
    }

    /// All that may change without moving.
    fn mind(&mut self) -> Mind<'_> {
        Mind {
            actor: &self.actor,
            things: &mut self.things,
            forbidden: &mut self.forbidden,
            felt: &mut self.felt,
            still: &mut self.still,
            over: &mut self.over,
        }
    }

    /// Which thing words mean.
    fn which(&self, which: Which) -> Option<ThingId> {
        mind::find(&self.actor, &self.things, which).map(|known| known.id)
    }

    /// Where a thing was felt.
    fn felt_places(&self, known: &KnownThing) -> Vec<Vector3<f64>> {
        mind::places_of(&self.felt, &known.at)
    }

    /// The hand that touches something now, or did last.
    fn hand_touching(&self) -> Option<usize> {
        let it = self.things.it().or(self.things.iter().next())?;
        let touching = self.things.iter().find_map(|known| known.in_touch);
        self.actor.arm_of(touching.unwrap_or(it.found.receptor))
    }

    /// The hand that words mean.
    fn hand_for(&self, name: Option<HandName>) -> Option<usize> {
        let left = (0..2).find(|&hand| self.actor.side(hand) > 0.0).unwrap_or(0);
        match name? {
            HandName::Left => Some(left),
            HandName::Right => Some(1 - left),
            HandName::Other => self.hand_touching().map(|hand| 1 - hand),
        }
    }

    /// What either hand reaches, and then what the tip of a stick does that is known; none where that cannot be told.
    fn reachable(&self) -> Option<&[ReachableMap]> {
        let made = self.reachable.get_or_init(|| {
            let (own, bare, stick) = (&self.actor.own, self.actor.bare(), self.actor.stick());
            let limbs = self.actor.hands.each_ref().map(|hand| hand.limb);
            let chest = own.carrier_of(&limbs);
            let hands = limbs.map(|limb| ReachableMap::new(bare, limb, chest, VOXEL).ok());
            let with_stick = stick.zip(self.actor.stick_tip()).map(|(stick, tip)| {
                ReachableMap::of_place(own, limbs[stick.hand], own.place(tip), chest, VOXEL).ok()
            });
            hands.into_iter().chain(with_stick).collect()
        });
        made.as_deref()
    }

    /// Lowers what it holds until it stands; what it holds it with, in words, and whether it was felt to stand. Palms let go.
    fn put_down(&mut self, held: Held) -> Result<(String, bool), Error> {
        match held {
            Held::Stuck { receptor, raised } => {
                let lowered = tried(self.actor.lower(receptor, raised))?;
                Ok((self.limb_in_words(receptor), lowered.unwrap_or(false)))
            }
            Held::Palms(mut grip) => {
                let down = tried(self.actor.set_down(&mut grip))?.is_some();
                if let Some(known) = self.things.iter_mut().find(|known| known.found.thing == grip.thing) {
                    let (moved, up) = (grip.middle() - known.at, self.actor.up);
                    known.carried(&(moved - up * moved.dot(&up)));
                }
                self.settle_at_ready();
                Ok(("hands".into(), down))
            }
        }
    }

    /// Both hands to where they wait; whether they got there.
    fn settle_at_ready(&mut self) -> bool {
        let ready = self.ready.clone();
        self.settle(&ready)
    }

    /// Both hands to a posture, past what is met on the way; whether they got there.
    fn settle(&mut self, posture: &[f64]) -> bool {
        self.actor.go_round(posture).is_ok()
    }

    /// Takes the arm that touches something back from it.
    fn let_be(&mut self) {
        let ready = self.ready.clone();
        for known in self.things.iter_mut().filter(|known| known.in_touch.is_some()) {
            known.in_touch = None;
            // Where it cannot, the next motion says so.
            let _ = self.actor.withdraw(&known.found, &ready);
        }
    }
}

/// What words mean, without a creature's own names.
pub fn understood(request: &str) -> Understood {
    static EVERYDAY: LazyLock<Language> = LazyLock::new(|| language(BodyNames::everyday()));
    EVERYDAY.understand(request)
}

fn language(names: BodyNames) -> Language {
    Language::new(REQUESTS.iter().map(|(intent, kind)| (*intent, kind.words)).collect(), names)
}

/// What a request asks for, as it says it.
fn doing(request: &Request) -> String {
    match (&request.part, request.intent) {
        (Some(part), Intent::TouchOwn) => format!("touch my {}", part.text()),
        (_, intent) => intent.kind().map_or("do that", |kind| kind.doing[0]).to_string(),
    }
}
