//! What is told in words that no request lists: by what kind of doing its verb names, to what, and which way.

use super::patterns::has;
use super::slots::{Piece, Sense};
use crate::interaction::conversation::requests::Intent;

/// Verbs of touching …
const TOUCHING: &str = "touch|tap|poke|contact|pat|stroke|prod|rub|brush|press|scratch|tickle|reach|feel|hit|meet|squeeze|pinch|massage|knock|approach|slap|nudge";
/// … of taking a thing or a hand somewhere …
pub(super) const MOVING: &str = "put|push|move|place|set|shove|slide|send|carry|take|shift|get|bring|transport|position|keep|stow|lay|drag|pop|roll|nudge|displace|pull|fetch|haul|draw|tug|guide|direct|steer|leave|rest|stretch|extend|deposit|scoot|pass|have|want|make|hold|go|come|roll|reposition|relocate";
const PUSHING: &str = "push|shove|send|banish|remove|displace|clear|dispose";
const PULLING: &str = "pull|bring|fetch|drag|haul|draw|tug|retrieve";
const LIFTING: &str = "lift|raise|pick|grab|grasp|hoist|seize|clasp|scoop|heave|elevate|catch|grip|hold";
const RELEASING: &str = "release|drop|loosen|free|unhand|relinquish|lower|unclench|unload";
const SEARCHING: &str = "search|look|seek|explore|scan|grope|hunt|scout|rummage|sweep|probe|fumble|survey|scour|comb|find|discover|detect|locate|spot|identify";
const SHAPING: &str = "trace|outline|follow|measure|palpate|examine|inspect|explore|investigate|study|feel|probe|map|scan|check";
const LEANING: &str = "lean|bend|bow|stoop|tilt|hunch|incline";
const AVOIDING: &str = "avoid|dodge|evade|duck|escape|swerve|flinch|retreat";
const RESTING: &str = "relax|rest|unwind";
const STANDING: &str = "straighten|unbend|recline";

/// Which way.
const FAR: &str = "far|farther|further|farthest|furthest|away|off|distant|distance|beyond|forth|end|miles";
const NEAR: &str = "near|nearer|nearest|close|closer|closest|here|in|toward|towards|lap|inward|inwards";
const UP: &str = "up|air|high|higher|upward|upwards|aloft|off";
const DOWN: &str = "down|back|loose|go";
const BACK: &str = "back|backward|backwards|upright|up|straight|erect";
const FORWARD: &str =
    "forward|forwards|over|in|toward|towards|closer|down|more|further|farther|ahead|out|front";
const ON: &str = "on|onto|to|against|upon|at|over|with|in|by|towards|toward";

/// Which way a thing is to be pushed, where that is told: not all that is pushed is to go far away.
pub(super) fn way(pieces: &[&Piece]) -> Option<Intent> {
    let first = pieces.iter().position(|piece| piece.sense == Sense::Word && piece.word.form.is_base())?;
    let said = &pieces[first..];
    let pushes = has(&said[..1], "push|move|shove|slide|nudge|shift|scoot");
    if !pushes || !said.iter().any(|piece| piece.sense == Sense::Thing) {
        return None;
    }
    let goes = |way: &str| has(said, &format!("THING .. {way}"));
    match () {
        () if has(said, "SIDE") => None,
        () if goes("nearer|closer|inward|inwards") || goes("toward|towards|to you|me|us|yourself|PART") => {
            Some(Intent::BringNear)
        }
        () if goes("far|away|out|farther|further|off") => None,
        () if goes("up|upward|upwards $") || goes("up|upward|upwards by|high") => Some(Intent::Lift),
        () if goes("down|downward|downwards $") || goes("down|downward|downwards by") => Some(Intent::LetGo),
        () => None,
    }
}

/// What pieces tell to do; nothing where the first verb among them is none of these.
pub(super) fn told(pieces: &[&Piece]) -> Option<Intent> {
    let first = pieces.iter().position(|piece| piece.sense == Sense::Word && piece.word.form.is_base())?;
    // What stands before it is but how or with what.
    if pieces[..first]
        .iter()
        .any(|piece| piece.sense == Sense::Some || (piece.sense == Sense::Word && !piece.word.known))
    {
        return None;
    }
    let said = &pieces[first..];
    let does = |verbs: &str| has(&said[..1], verbs);
    let way = |words: &str| said[1..].iter().any(|piece| piece.sense == Sense::Word && has(&[*piece], words));
    let thing = pieces.iter().any(|piece| piece.sense == Sense::Thing);
    let some = pieces.iter().any(|piece| piece.sense == Sense::Some);
    let hand = pieces.iter().any(|piece| matches!(piece.sense, Sense::Hand(_)));
    let part = pieces.iter().any(|piece| matches!(piece.sense, Sense::Part(_)));
    let end = has(said, "at|to|on the ?far ?other|opposite|very|far back|end|rear|edge|side");
    let hands = pieces.iter().filter(|piece| piece.is_body()).count() > 1;
    let to_part = has(said, &format!("{ON} ?the ?side|top|middle ?of BODY"));
    let table =
        pieces.iter().any(|piece| piece.word.is(&["table", "tabletop", "desk", "surface", "area", "space"]));
    let alone = said.len() == 1;
    Some(match () {
        () if does(TOUCHING) && (part || hands) && !thing => Intent::TouchOwn,
        () if does(MOVING) && hand && part && to_part => Intent::TouchOwn,
        () if (does(MOVING) || does(TOUCHING)) && thing && (end || way(FAR) && !way(NEAR)) => Intent::PutFar,
        () if does(MOVING) && hand && has(said, &format!("HAND .. {ON} THING")) => Intent::Touch,
        () if does(MOVING) && thing && way(NEAR) => Intent::BringNear,
        () if does(LIFTING) && thing => Intent::Lift,
        () if does(MOVING) && thing && way(UP) => Intent::Lift,
        () if does(RELEASING) && (thing || hand || alone) => Intent::LetGo,
        () if does(MOVING) && thing && way(DOWN) => Intent::LetGo,
        () if does(PUSHING) && thing => Intent::PutFar,
        () if does(PULLING) && thing => Intent::BringNear,
        () if does(SEARCHING) && (some || table || alone) => Intent::Explore,
        () if does(SHAPING) && thing => Intent::FeelShape,
        () if does(TOUCHING) && thing => Intent::Touch,
        () if does(LEANING) && way(BACK) => Intent::LeanBack,
        () if does(LEANING) && (way(FORWARD) || alone) => Intent::LeanForward,
        () if does(STANDING) => Intent::LeanBack,
        () if does(AVOIDING) && (thing || some || alone) => Intent::Avoid,
        () if does(RESTING) && !thing => Intent::Rest,
        () => return None,
    })
}
