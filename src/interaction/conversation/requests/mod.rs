//! What a partner may ask for: the words that mean it, and what the creature then does.
//!
//! To add a request, write a file with a [`RequestKind`], and name it in the table below.

mod exploring;
mod leaning;
mod putting;
mod resting;
mod telling;
mod touching;

use serde::Serialize;

use super::{Conversation, Reply, Request};
use crate::simulation::EngineError;

/// A request that a creature understands.
pub(super) struct RequestKind {
    /// Whether words mean it.
    pub means: fn(&Utterance) -> bool,
    /// Whether it must know its body for it.
    pub needs_body: bool,
    /// Whether it is about a thing that was felt before.
    pub needs_thing: bool,
    /// Does it, and answers.
    pub act: fn(&mut Conversation, Request) -> Result<Reply, EngineError>,
}

/// What was said.
pub(super) struct Utterance {
    /// In small letters.
    pub text: String,
    words: Vec<String>,
}

impl Utterance {
    fn new(request: &str) -> Utterance {
        let text = request.to_lowercase();
        let words = text.split(|c: char| !c.is_alphanumeric()).filter(|word| !word.is_empty());
        Utterance { words: words.map(String::from).collect(), text }
    }

    /// Whether one of these words is among it.
    fn any(&self, list: &[&str]) -> bool {
        self.words.iter().any(|word| list.contains(&word.as_str()))
    }
}

/// Names the requests, a line each. Words are taken for the first that they mean.
macro_rules! requests {
    ($($(#[$about:meta])* $intent:ident => $kind:expr;)+) => {
        /// What a partner may want.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
        #[serde(rename_all = "snake_case")]
        pub enum Intent {
            $($(#[$about])* $intent,)+
            /// To know what it feels where it is touched, and that it puts a hand there.
            FeelTouch,
            /// None of these.
            Unknown,
        }

        const REQUESTS: &[(Intent, RequestKind)] = &[$((Intent::$intent, $kind)),+];
    };
}

requests! {
    /// That what failed, or was done before, is done again with the trunk leaning.
    LeanAndRetry => leaning::LEAN_AND_RETRY;
    /// To know how far away a thing is.
    HowFar => telling::HOW_FAR;
    /// To know where something is felt.
    WhereFelt => telling::WHERE_FELT;
    /// That a thing is put far away.
    PutFar => putting::PUT_FAR;
    /// That a thing is brought near.
    BringNear => putting::BRING_NEAR;
    /// That it goes back to rest.
    Rest => resting::REST;
    /// To know what it can do.
    Help => telling::HELP;
    /// To know whether something is there.
    Explore => exploring::EXPLORE;
    /// That a thing is touched.
    Touch => touching::TOUCH;
}

impl Intent {
    /// What is done for it; nothing for what cannot be asked for.
    pub(super) fn kind(self) -> Option<&'static RequestKind> {
        REQUESTS.iter().find(|(intent, _)| *intent == self).map(|(_, kind)| kind)
    }
}

/// What words mean.
pub fn understood(request: &str) -> Intent {
    let utterance = Utterance::new(request);
    REQUESTS.iter().find(|(_, kind)| (kind.means)(&utterance)).map_or(Intent::Unknown, |(intent, _)| *intent)
}

impl Conversation {
    /// What it says where it did not understand.
    pub(super) fn not_understood(&self) -> Reply {
        let said = format!("I did not understand that. {}.", telling::ABILITIES);
        self.reply(Intent::Unknown, said, None, false)
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
