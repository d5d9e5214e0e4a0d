//! A partner's requests in plain words, and what a blindfolded creature says and does (IVA 2009, section 4).
//!
//! To teach it a request, see `requests/`; what words mean is found out in `grammar/`.

pub mod grammar;
mod mind;
mod requests;
mod speaking;

use std::cell::OnceCell;
use std::sync::LazyLock;

use serde_json::{Value, json};

pub use requests::Intent;

use self::grammar::{BodyNames, HandName, Language, Leave, Request, Understood, UnknownWord};
use self::mind::Mind;
use self::requests::{Act, Acted, Answer, REQUESTS};
use super::actor::Actor;
use super::tasks::{Grip, Search, Trouble, tried};
use crate::creature::Posture;
use crate::error::{Error, Result};
use crate::peripersonal::{ReachableMap, distance};

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
        let Reply { intent, said, done, asks, felt } = self;
        json!({"heard": heard, "intent": intent, "said": said, "done": done, "asks": asks, "felt": felt})
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
    mind: Mind,
    /// Its search of the table, as far as it got; `None` if what stands on it may have changed since.
    search: Option<Search>,
    pending: Option<Pending>,
    last: Option<Request>,
    ready: Posture,
    /// Where a hand of its own, or a stick in it, touches it.
    spot: Option<OwnSpot>,
    holding: Option<Held>,
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
        if distance(&actor.posture(), &ready) > 0.0 {
            tried(actor.go(&ready))?;
        }
        actor.wait(0.5)?;
        Ok(Conversation {
            language: language(BodyNames::of(&actor.own)),
            actor,
            mind: Mind::default(),
            search: None,
            pending: None,
            last: None,
            ready,
            spot: None,
            holding: None,
            reachable: OnceCell::new(),
        })
    }

    /// Whether a partner has ended it.
    pub fn is_over(&self) -> bool {
        self.mind.over
    }

    /// Hears what is said, does what it can if that is wanted, and answers.
    ///
    /// # Errors
    /// Where the engine fails; all else is said in the reply.
    pub fn hear(&mut self, said: &str) -> Result<Reply, Error> {
        let mut understood = self.language.understand(said);
        let which = self.mind.find(&self.actor, understood.which).map(|known| known.id);
        match self.pending.take() {
            Some(Pending::Whether(request)) => {
                if let Some(leave) = Leave::by_yes(&understood) {
                    self.mind.allow(&request);
                    return self.moves(&request, leave);
                }
            }
            Some(Pending::Which(request, leave)) if !understood.forbids => {
                let only_which = matches!(understood.intent, Intent::Which | Intent::Unknown | Intent::Yes);
                let answers = only_which || matches!(understood.intent, Intent::Touch | Intent::Lift);
                if which.is_some() && answers {
                    self.mind.things.mean(which);
                    return self.moves(&request, leave);
                }
                if only_which {
                    let said = format!("I did not understand which one. {}", self.mind.question(&self.actor));
                    let intent = request.intent;
                    self.pending = Some(Pending::Which(request, leave));
                    return Ok(self.reply(intent, Answer::asks(said)));
                }
            }
            _ => {}
        }
        match which {
            Some(_) => self.mind.things.mean(which),
            None => understood.request.which = None,
        }
        let leave = understood.leave.take();
        self.act(understood.request, leave, &understood.unknown)
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
            _ if self.mind.still => Answer::tells(format!("{feels}, and am keeping still")),
            Some(doubt) => Answer::failed(format!("{feels}. {doubt}")),
            None => {
                self.leave_spot();
                self.let_be();
                let touched = self.actor.touch_own(receptor, None);
                self.spot = Some(OwnSpot { receptor, by_stick: false });
                let told = touched.map(|touch| {
                    let hand = self.hand_name(touch.hand);
                    let off = speaking::cm(touch.off.max(0.01));
                    let there = if touch.off < 0.005 { "there" } else { &format!("{off} from there") };
                    Answer::done(format!("{feels}, and put my {hand} {there}"))
                });
                self.answered(told, &format!("{feels}, but cannot put a hand there"))?
            }
        };
        let mut reply = self.reply(Intent::FeelTouch, answer);
        self.heed_unexpected(&mut reply);
        Ok(reply)
    }

    /// Answers a request, or does what it asks for where there is leave.
    fn act(&mut self, request: Request, leave: Option<Leave>, unknown: &[UnknownWord]) -> Result<Reply> {
        let intent = request.intent;
        let Some(kind) = intent.kind() else { return Ok(self.not_understood(unknown)) };
        let doing = || requests::doing(intent, request.part.as_ref())[0].clone();
        let asks = match (&kind.act, leave) {
            (Act::Tells(tell), _) => {
                let doubt = if kind.needs_body { self.doubt() } else { None };
                let answer = match (doubt, self.relation(&request)) {
                    (Some(doubt), _) => Answer::failed(doubt),
                    (None, Some(answer)) => answer,
                    (None, None) => tell(self, &request),
                };
                return Ok(self.reply(intent, answer));
            }
            (Act::Minds(mind), _) => {
                let answer = mind(&mut self.mind, &self.actor, &request);
                return Ok(self.reply(intent, answer));
            }
            (_, Some(leave)) if !self.mind.forbids(&request) => return self.moves(&request, leave),
            (_, Some(_)) => format!("You told me not to {}: do you want me to do it now?", doing()),
            (_, None) => match unknown {
                [] => format!("Do you want me to {}?", doing()),
                [word, ..] => format!("{}. Do you want me to {}?", word.in_words(), doing()),
            },
        };
        self.pending = Some(Pending::Whether(request));
        Ok(self.reply(intent, Answer::asks(asks)))
    }

    /// Does what is asked for, for which there is leave.
    fn moves(&mut self, request: &Request, leave: Leave) -> Result<Reply, Error> {
        use Intent::{LeanBack, LeanForward, LetGo, Repeat, Rest};
        let intent = request.intent;
        let Some(kind) = intent.kind() else { return Ok(self.not_understood(&[])) };
        let doubt = if kind.needs_body { self.doubt() } else { None };
        if let Some(said) = doubt.or_else(|| self.barred_by_stick(request)) {
            return Ok(self.reply(intent, Answer::failed(said)));
        }
        if !matches!(intent, Repeat | LeanForward | LeanBack | Rest | LetGo) {
            self.last = Some(request.clone());
        }
        // What is near is felt for first; what is felt then is touched.
        let handles = matches!(kind.act, Act::Handles(_));
        let feels_first = handles && self.mind.things.is_empty() && intent == Intent::Touch && request.any;
        match self.mind.things.it().map(|known| known.id) {
            None if handles && !feels_first && self.mind.things.is_empty() => {
                let said = "I have not felt anything yet: ask me to feel around first";
                return Ok(self.reply(intent, Answer::failed(said)));
            }
            None if handles && !feels_first => {
                self.pending = Some(Pending::Which(request.clone(), leave));
                return Ok(self.reply(intent, Answer::asks(self.mind.question(&self.actor))));
            }
            it if handles => self.mind.things.mean(it),
            _ => {}
        }
        self.mind.still = false;
        self.leave_spot();
        self.put_by(intent)?;
        let acted = match (&kind.act, self.mind.things.it().cloned()) {
            (Act::Moves(act), _) => act(self, request, &leave),
            (Act::Handles(act), Some(thing)) => act(self, &thing, request),
            (Act::Handles(_), None) => self.explore(self.hand_for(request.hand), false).map(|answer| {
                let done = Some(!self.mind.things.is_empty());
                Answer { done, ..answer }
            }),
            (Act::Tells(_) | Act::Minds(_), _) => return Ok(self.not_understood(&[])),
        };
        let [doing, _] = requests::doing(intent, request.part.as_ref());
        let answer = self.answered(acted, &format!("I cannot {doing}"))?;
        let mut reply = self.reply(intent, answer);
        self.heed_unexpected(&mut reply);
        let retried = intent == LeanForward && (request.again || request.about.is_some());
        if intent != Repeat && !retried {
            self.did(request, &reply);
        }
        Ok(reply)
    }

    /// What it says of something that went wrong; a failure of the engine is passed on.
    fn hindered(&self, what: &str, trouble: Trouble) -> Trouble {
        match trouble {
            Trouble::Engine(_) | Trouble::Told(_) => trouble,
            trouble => Trouble::Told(format!("{what}: {}", self.in_words(&trouble))),
        }
    }

    /// What it says of what it did, or of why that could not be done.
    fn answered(&self, acted: Acted, cannot: &str) -> Result<Answer> {
        acted.or_else(|trouble| Ok(Answer::failed(self.hindered(cannot, trouble).of_task()?.to_string())))
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

    /// The hand that touches something now, or did last.
    fn hand_touching(&self) -> Option<usize> {
        let things = &self.mind.things;
        let it = things.it().or(things.iter().next())?;
        let touching = things.iter().find_map(|known| known.in_touch);
        self.actor.arm_of(touching.unwrap_or(it.found.receptor))
    }

    /// The hand that words mean.
    fn hand_for(&self, name: Option<HandName>) -> Option<usize> {
        let left = self.actor.hand_towards(&self.actor.left());
        match name? {
            HandName::Left => Some(left),
            HandName::Right => Some(1 - left),
            HandName::Other => self.hand_touching().map(|hand| 1 - hand),
        }
    }

    /// What either hand reaches, and then what the tip of a stick does that is known; `None` if that cannot be told.
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
                let mut things = self.mind.things.iter_mut();
                if let Some(known) = things.find(|known| known.found.thing == grip.thing) {
                    let (moved, up) = (grip.middle() - known.at, self.actor.up);
                    known.carried(&(moved - up * moved.dot(&up)));
                }
                self.settle();
                Ok(("hands".into(), down))
            }
        }
    }

    /// Takes both hands to where they wait, past what is met on the way; whether they got there.
    fn settle(&mut self) -> bool {
        let ready = self.ready.clone();
        self.actor.go_round(&ready).is_ok()
    }

    /// Takes a hand back from where it touches its own skin.
    fn leave_spot(&mut self) {
        if self.spot.take().is_some() {
            // Where it cannot, the next motion says so.
            self.settle();
        }
    }

    /// Takes the arm that touches something back from it.
    fn let_be(&mut self) {
        for known in self.mind.things.iter_mut().filter(|known| known.in_touch.is_some()) {
            known.in_touch = None;
            // Where it cannot, the next motion says so.
            let _ = self.actor.withdraw(&known.found, &self.ready);
        }
    }
}

/// What words mean, without a creature's own names.
pub fn understood(request: &str) -> Understood {
    static EVERYDAY: LazyLock<Language> = LazyLock::new(|| language(BodyNames::everyday()));
    EVERYDAY.understand(request)
}

fn language(names: BodyNames) -> Language {
    Language::new(REQUESTS.iter().map(|(intent, kind)| (*intent, kind.words)), names)
}
