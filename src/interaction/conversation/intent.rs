//! What a partner may want, told from its words.

use serde::Serialize;

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
