//! What a partner may ask for: the words that mean it, what it needs, and what the creature then does.
//!
//! To add a request, write a file with a [`RequestKind`], and name it in the table below. Its words are patterns
//! ([`grammar`](super::grammar)); an utterance means the request whose pattern takes most of its words, of two the first in the table.

mod exploring;
mod holding;
mod locating;
mod own_body;
mod shape;
mod taking_stick;
mod talking;
mod touching;

use serde::Serialize;

use super::grammar::{Leave, PartName, Request};
use super::mind::Mind;
use super::{Conversation, Reply};
use crate::error::Result;
use crate::interaction::actor::Actor;
use crate::interaction::tasks::Trouble;
use crate::interaction::things::KnownThing;

/// A request that a creature understands.
pub(super) struct RequestKind {
    /// What it is called where it is done or forbidden, and when it is done: `touch it`, `touched it`.
    doing: [&'static str; 2],
    /// The words that mean it: patterns, after how they are said. `told:` or asked to do it, `asked:` for an answer, asked of what
    /// was `past:`, `denied:` something, or `said:` alone, in whatever sentence.
    pub words: &'static str,
    /// Whether it must know its body for it.
    pub needs_body: bool,
    /// Does it, and answers.
    pub act: Act,
}

/// What a request does, by what it can change.
pub(super) enum Act {
    /// It tells, and changes nothing.
    Tells(fn(&Conversation, &Request) -> Answer),
    /// It changes what is kept in mind, and nothing else.
    Minds(fn(&mut Mind, &Actor, &Request) -> Answer),
    /// It moves, for which there has to be leave.
    Moves(fn(&mut Conversation, &Request, &Leave) -> Acted),
    /// It moves, for which there has to be leave, and is about a thing that was felt before.
    Handles(fn(&mut Conversation, &KnownThing, &Request) -> Acted),
}

/// What is said of what was done, or what hindered it.
pub(super) type Acted = Result<Answer, Trouble>;

/// What is said to a request.
pub(super) struct Answer {
    /// What it says.
    pub said: String,
    /// Whether it did what was wanted, where something was.
    pub done: Option<bool>,
    /// Whether it waits for an answer.
    pub asks: bool,
}

impl Answer {
    /// It asks back.
    pub fn asks(said: impl Into<String>) -> Answer {
        Answer { said: said.into(), done: None, asks: true }
    }

    /// It tells something.
    pub fn tells(said: impl Into<String>) -> Answer {
        Answer { said: said.into(), done: None, asks: false }
    }

    /// It did what was wanted, or it was so already.
    pub fn done(said: impl Into<String>) -> Answer {
        Answer::does(said, true)
    }

    /// It could not do it.
    pub fn failed(said: impl Into<String>) -> Answer {
        Answer::does(said, false)
    }

    /// It did what was wanted, or did not.
    pub fn does(said: impl Into<String>, done: bool) -> Answer {
        Answer { said: said.into(), done: Some(done), asks: false }
    }
}

impl From<Reply> for Answer {
    fn from(Reply { said, done, asks, .. }: Reply) -> Answer {
        Answer { said, done, asks }
    }
}

impl RequestKind {
    /// One that is answered at once.
    const fn answer(act: Act, words: &'static str) -> RequestKind {
        RequestKind::new(["do that", "did that"], act, words)
    }

    const fn new(doing: [&'static str; 2], act: Act, words: &'static str) -> RequestKind {
        RequestKind { doing, words, needs_body: false, act }
    }

    /// One for which it must know its body.
    const fn of_body(doing: [&'static str; 2], act: Act, words: &'static str) -> RequestKind {
        RequestKind { doing, words, needs_body: true, act }
    }
}

/// What a request asks for, as it says it, and when it is done.
pub(super) fn doing(intent: Intent, part: Option<&PartName>) -> [String; 2] {
    match (intent.kind(), part) {
        (Some(_), Some(part)) if intent == Intent::TouchOwn => {
            ["touch", "touched"].map(|verb| format!("{verb} my {}", part.text()))
        }
        (kind, _) => kind.map_or(["do that", "did that"], |kind| kind.doing).map(String::from),
    }
}

/// Names the requests, a line each.
macro_rules! requests {
    ($($(#[$about:meta])* $intent:ident => $kind:expr;)+) => {
        /// What a partner may want.
        #[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
        #[serde(rename_all = "snake_case")]
        pub enum Intent {
            $($(#[$about])* $intent,)+
            /// To know what it feels where it is touched, and that it puts a hand there.
            FeelTouch,
            /// None of these.
            #[default]
            Unknown,
        }

        pub(super) const REQUESTS: &[(Intent, RequestKind)] = &[$((Intent::$intent, $kind)),+];
    };
}

requests! {
    /// That something is not done.
    Dont => talking::DONT;
    /// That it does not move.
    KeepStill => talking::KEEP_STILL;
    /// That it leans forward, and tries again what failed.
    LeanForward => own_body::LEAN_FORWARD;
    /// That it is upright again.
    LeanBack => own_body::LEAN_BACK;
    /// That a stick is given back.
    GiveStickBack => taking_stick::GIVE_STICK_BACK;
    /// That a stick is taken.
    TakeStick => taking_stick::TAKE_STICK;
    /// To know what it knows of a stick.
    StickKnown => taking_stick::STICK_KNOWN;
    /// That things are forgotten.
    Forget => talking::FORGET;
    /// To know how many things it found.
    HowMany => exploring::HOW_MANY;
    /// To know whether it reaches a thing, and how.
    NearOrFar => locating::NEAR_OR_FAR;
    /// To know where a part of its body is.
    WhereOwn => locating::WHERE_OWN;
    /// To know how far away a thing is.
    HowFar => locating::HOW_FAR;
    /// That it feels how a thing is shaped.
    FeelShape => shape::FEEL_SHAPE;
    /// To know how big a thing is.
    HowBig => shape::HOW_BIG;
    /// To know what shape a thing has.
    WhatShape => shape::WHAT_SHAPE;
    /// That it feels itself over, to know its body as it is now.
    FeelOver => own_body::FEEL_OVER;
    /// To know where something is felt.
    WhereFelt => locating::WHERE_FELT;
    /// That a part of its own body is touched.
    TouchOwn => own_body::TOUCH_OWN;
    /// That a thing is put to its left or right.
    PutAside => holding::PUT_ASIDE;
    /// That a thing is brought near.
    BringNear => holding::BRING_NEAR;
    /// That a thing is put far away.
    PutFar => holding::PUT_FAR;
    /// That it gets out of the way.
    Avoid => own_body::AVOID;
    /// That what it holds is let go.
    LetGo => holding::LET_GO;
    /// That a thing is picked up.
    Lift => holding::LIFT;
    /// To know what it did.
    Report => talking::REPORT;
    /// To know what it feels.
    WhatFelt => locating::WHAT_FELT;
    /// To know whether something is there.
    Explore => exploring::EXPLORE;
    /// That it goes back to rest.
    Rest => own_body::REST;
    /// That a thing is touched.
    Touch => touching::TOUCH;
    /// To know who it is.
    Who => talking::WHO;
    /// To know what it can do.
    Help => talking::HELP;
    /// That what was done before is done again.
    Repeat => own_body::REPEAT;
    /// That the conversation ends.
    Quit => talking::QUIT;
    /// That it stops.
    Stop => talking::STOP;
    /// No.
    No => talking::NO;
    /// Yes.
    Yes => talking::YES;
    /// Thanks.
    Thanks => talking::THANKS;
    /// A greeting.
    Greet => talking::GREET;
    /// The answer to which of several things.
    Which => talking::WHICH;
}

impl Intent {
    /// What is done for it; nothing for what cannot be asked for.
    pub(super) fn kind(self) -> Option<&'static RequestKind> {
        REQUESTS.iter().find(|(intent, _)| *intent == self).map(|(_, kind)| kind)
    }

    /// Whether it may move for it.
    pub fn moves(self) -> bool {
        self.kind().is_some_and(|kind| matches!(kind.act, Act::Moves(_) | Act::Handles(_)))
    }
}
