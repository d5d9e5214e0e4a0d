//! "Avoid it", "watch out": it watches what comes near, and gets out of its way.

use super::super::Conversation;
use super::{Act, Intent, Reply, RequestKind};
use crate::interaction::avoiding::Avoiding;
use crate::simulation::EngineError;

/// How long it watches, seconds of its own time, …
const WATCHING: f64 = 5.0;
/// … how far joints have gone where it got out of a way, radians.
const MOVED: f64 = 0.02;

pub(super) const AVOID: RequestKind = RequestKind {
    told: &[
        "avoid|dodge|evade|duck",
        "out of ?the|its|his|my|harm|THING ?be way",
        "get|keep|stay|steer|move|pull|stand ?yourself|BODY clear",
        "move|step|stand|go|lean|shift|jump|get|swerve|come ?yourself|BODY ?out|over aside|sideways",
        "watch|look out",
        "make way|room",
        "keep|stay|get|move|back|pull|step|come|swing ?yourself|BODY away|off ?from ?THING|SOME|what",
        "keep|hold|maintain ?your|some|a ?safe distance",
        "not let THING|SOME hit|touch|reach|bump|get",
        "let nothing|SOME hit|touch",
        "protect|defend|save|guard|shield yourself|BODY",
        "get out ?of ?there|here $",
        "^ move $",
        "^ move|step|jump|get back $",
        "SOME|THING be ?=coming|=approaching|=flying|=heading ?straight|right at|toward|towards|for|your ?you|PART|way",
        "SOME|THING =coming|=approaching",
        "let THING|SOME pass",
        "take cover|evasive",
        "shy|shrink|flinch|draw away|back",
        "incoming",
        "evasive",
        "give THING ?a ?wide room|way|space|berth",
        "on your|guard guard",
        "beware",
        "mind your|the head|BODY",
        "heads up",
    ],
    needs_body: true,
    ..RequestKind::new(
        ["get out of the way", "watched what came near"],
        Act::Moves(|creature, _, _| creature.watch_out()),
    )
};

impl Conversation {
    /// Watches for a while, out of the way of what comes.
    fn watch_out(&mut self) -> Result<Reply, EngineError> {
        // What it touches it cannot keep away from: the arm first.
        let touched = self.things.iter().any(|known| known.in_touch.is_some());
        self.let_be();
        let before = self.actor.posture();
        let mut avoiding = Avoiding::new(&mut self.actor);
        let (mut seconds, mut met) = (0.0, false);
        let step = self.actor.handle.timestep();
        while seconds < WATCHING {
            met |= !avoiding.step(&mut self.actor)?.is_empty();
            seconds += step;
        }
        let moved = self.actor.posture().distance(&before) > MOVED;
        let from = if touched { "I took my arm away from it, and watched" } else { "I watched" };
        let said = match (moved, met) {
            (true, false) => "I got out of the way of what came, and it did not touch me".to_string(),
            (true, true) => "I moved out of the way of what came, but it touched me".to_string(),
            (false, false) => format!("{from} for {WATCHING:.0} seconds: nothing came at me"),
            (false, true) => {
                format!("{from} for {WATCHING:.0} seconds; I feel a touch, but nothing came at me")
            }
        };
        Ok(self.reply(Intent::Avoid, said, Some(!(moved && met)), false))
    }
}
