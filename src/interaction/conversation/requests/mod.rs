//! What a partner may ask for: the words that mean it, what it needs, and what the creature then does.
//!
//! To add a request, write a file with a [`RequestKind`], and name it in the table below. Its words are patterns
//! ([`grammar`](super::grammar)); an utterance means the request whose pattern takes most of its words, of two the first in the table.

mod answering;
mod avoiding;
mod counting;
mod exploring;
mod feeling_over;
mod feeling_shape;
mod forgetting;
mod helping;
mod keeping_still;
mod leaning;
mod letting_go;
mod lifting;
mod locating;
mod meeting;
mod prohibiting;
mod putting;
mod quitting;
mod repeating;
mod reporting;
mod resting;
mod shape_known;
mod stopping;
mod taking_stick;
mod touching;
mod touching_own;

use serde::Serialize;

use super::grammar::{Leave, Request, Words};
use super::{Conversation, Mind, Reply};
use crate::interaction::tasks::Trouble;
use crate::interaction::things::KnownThing;

/// A request that a creature understands.
pub(super) struct RequestKind {
    /// What it is called in a sentence, and when it is done: `touch it`, `touched it`.
    pub doing: [&'static str; 2],
    /// The words that mean it.
    pub words: Words,
    /// Whether it must know its body for it.
    pub needs_body: bool,
    /// Does it, and answers.
    pub act: Act,
}

/// What a request does, by what it can change.
pub(super) enum Act {
    /// It tells, and changes nothing.
    Tells(fn(&Conversation, &Request) -> Answer),
    /// It changes what is remembered, and nothing else.
    Minds(fn(&mut Mind<'_>, &Request) -> Answer),
    /// It moves, for which there has to be leave.
    Moves(fn(&mut Conversation, &Request, &Leave) -> Acted),
    /// It moves, for which there has to be leave, and is about a thing that was felt before.
    Handles(fn(&mut Conversation, &KnownThing, &Request, &Leave) -> Acted),
}

/// What is said of what was done, or why it could not be.
pub(super) type Acted = Result<Answer, Trouble>;

/// What it says where it no longer feels what it was to hold.
const SLIPPED: &str = "It slipped away: I no longer feel it";

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
    /// One without words, which needs nothing.
    const fn new(doing: [&'static str; 2], act: Act) -> RequestKind {
        RequestKind { doing, words: Words::NONE, needs_body: false, act }
    }

    /// By which it is told or asked to do it.
    const fn told(mut self, patterns: &'static str) -> RequestKind {
        self.words.told = patterns;
        self
    }

    /// By which an answer is asked for.
    const fn asked(mut self, patterns: &'static str) -> RequestKind {
        self.words.asked = patterns;
        self
    }

    /// By which it is asked of what was.
    const fn past(mut self, patterns: &'static str) -> RequestKind {
        self.words.past = patterns;
        self
    }

    /// By which it is meant where something is denied.
    const fn denied(mut self, patterns: &'static str) -> RequestKind {
        self.words.denied = patterns;
        self
    }

    /// By which it is said alone, in whatever sentence.
    const fn said(mut self, patterns: &'static str) -> RequestKind {
        self.words.said = patterns;
        self
    }

    /// It must know its body for it.
    const fn needs_body(mut self) -> RequestKind {
        self.needs_body = true;
        self
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
    Dont => prohibiting::DONT;
    /// That it does not move.
    KeepStill => keeping_still::KEEP_STILL;
    /// That it leans forward, and tries again what failed.
    LeanForward => leaning::LEAN_FORWARD;
    /// That it is upright again.
    LeanBack => leaning::LEAN_BACK;
    /// That a stick is given back.
    GiveStickBack => taking_stick::GIVE_STICK_BACK;
    /// That a stick is taken.
    TakeStick => taking_stick::TAKE_STICK;
    /// To know what it knows of a stick.
    StickKnown => taking_stick::STICK_KNOWN;
    /// That things are forgotten.
    Forget => forgetting::FORGET;
    /// To know how many things it found.
    HowMany => counting::HOW_MANY;
    /// To know whether it reaches a thing, and how.
    NearOrFar => locating::NEAR_OR_FAR;
    /// To know where a part of its body is.
    WhereOwn => locating::WHERE_OWN;
    /// To know how far away a thing is.
    HowFar => locating::HOW_FAR;
    /// That it feels how a thing is shaped.
    FeelShape => feeling_shape::FEEL_SHAPE;
    /// To know how big a thing is.
    HowBig => shape_known::HOW_BIG;
    /// To know what shape a thing has.
    WhatShape => shape_known::WHAT_SHAPE;
    /// That it feels itself over, to know its body as it is now.
    FeelOver => feeling_over::FEEL_OVER;
    /// To know where something is felt.
    WhereFelt => locating::WHERE_FELT;
    /// That a part of its own body is touched.
    TouchOwn => touching_own::TOUCH_OWN;
    /// That a thing is put to its left or right.
    PutAside => putting::PUT_ASIDE;
    /// That a thing is brought near.
    BringNear => putting::BRING_NEAR;
    /// That a thing is put far away.
    PutFar => putting::PUT_FAR;
    /// That it gets out of the way.
    Avoid => avoiding::AVOID;
    /// That what it holds is let go.
    LetGo => letting_go::LET_GO;
    /// That a thing is picked up.
    Lift => lifting::LIFT;
    /// To know what it did.
    Report => reporting::REPORT;
    /// To know what it feels.
    WhatFelt => locating::WHAT_FELT;
    /// To know whether something is there.
    Explore => exploring::EXPLORE;
    /// That it goes back to rest.
    Rest => resting::REST;
    /// That a thing is touched.
    Touch => touching::TOUCH;
    /// To know who it is.
    Who => meeting::WHO;
    /// To know what it can do.
    Help => helping::HELP;
    /// That what was done before is done again.
    Repeat => repeating::REPEAT;
    /// That the conversation ends.
    Quit => quitting::QUIT;
    /// That it stops.
    Stop => stopping::STOP;
    /// No.
    No => answering::NO;
    /// Yes.
    Yes => answering::YES;
    /// Thanks.
    Thanks => meeting::THANKS;
    /// A greeting.
    Greet => meeting::GREET;
    /// The answer to which of several things.
    Which => answering::WHICH;
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
