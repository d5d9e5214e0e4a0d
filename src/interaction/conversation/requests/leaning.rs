//! "Lean forward and try again", "lean back".

use super::super::Conversation;
use super::{Act, Intent, Reply, RequestKind};
use crate::interaction::conversation::language::{Leave, Request};
use crate::interaction::tasks::Trouble;
use crate::simulation::EngineError;

pub(super) const LEAN_FORWARD: RequestKind = RequestKind {
    told: &[
        "lean|bend|tilt|bow|stoop|hunch|incline|tip|reach|stretch|move|come|get|push|bring ?PART|yourself ?a ?bit|little|lot|way|from|at ?the ?waist|hips ?far|further|farther|more forward|forwards",
        "lean|bend|tilt|bow|stoop|hunch|incline ?PART|yourself ?a ?bit|little ?further|farther|more over|down|in|into|toward|towards|across|closer|ahead|to|out|at|from",
        "tilt|bend|incline|bow PART",
        "lean|bow|stoop|hunch $",
        "^ ?a ?bit|little|lot ?more|further|even forward|forwards $",
        "move|bring PART|yourself ?closer|nearer to|toward|towards ?the ?THING|table|front",
        "get PART over ?the THING|table",
    ],
    needs_body: true,
    ..RequestKind::new(
        ["lean forward", "leaned forward"],
        Act::Moves(|creature, request, leave| creature.lean(request, leave)),
    )
};

pub(super) const LEAN_BACK: RequestKind = RequestKind {
    told: &[
        "lean|tilt|bend|tip|sit|rock|recline ?PART|yourself|right|well|all ?the ?way back|backward|backwards",
        "move|bring|pull|draw PART|yourself ?right back|backward|backwards|upright",
        "sit|stand|get|straighten|come|rise|raise|go ?yourself|PART|right ?back ?right up|upright|straight|tall|erect|vertical",
        "be|stay ?yourself upright|erect|straight",
        "upright|erect|vertical",
        "^ ?now up straight|tall|again|now $",
        "raise|lift|straighten PART|yourself ?back ?again ?upright|up $",
        "pull PART back|upright|up $",
        "away from the table",
        "^ ?come|go|get back up ?again|now|straight $",
        "lean the other way",
    ],
    needs_body: true,
    ..RequestKind::new(["lean back", "leaned back"], Act::Moves(|creature, _, _| creature.upright()))
};

impl Conversation {
    /// Leans; and where something was asked for before that failed or that goes farther so, does that again.
    fn lean(&mut self, request: &Request, leave: &Leave) -> Result<Reply, EngineError> {
        if request.again {
            return match self.last.clone() {
                Some(last) => {
                    let retried = Request { lean: true, hand: request.hand.or(last.hand), ..last };
                    let reply = self.act(retried, Some(leave.again()), &[])?;
                    Ok(Reply { intent: Intent::LeanForward, ..reply })
                }
                None => {
                    self.fails(Intent::LeanForward, "There is nothing yet that I could try again leaning")
                }
            };
        }
        if let Some(intent) = request.about {
            let leaning = Request { intent, about: None, lean: true, ..request.clone() };
            let reply = self.act(leaning, Some(leave.again()), &[])?;
            return Ok(Reply { intent: Intent::LeanForward, ..reply });
        }
        self.let_be();
        match self.actor.lean_forward() {
            Ok(far) if far > 0.005 => {
                let said = format!("I lean forward: my shoulders came {:.0} cm farther", 100.0 * far);
                self.does(Intent::LeanForward, said)
            }
            Ok(_) => self.does(Intent::LeanForward, "I lean forward already as far as I can"),
            Err(Trouble::Engine(error)) => Err(error),
            Err(Trouble::Reach(_)) => {
                self.fails(Intent::LeanForward, "I cannot lean forward: something would be in the way")
            }
            Err(trouble) => {
                let said = format!("I cannot lean forward: {}", self.in_words(&trouble));
                self.fails(Intent::LeanForward, said)
            }
        }
    }

    fn upright(&mut self) -> Result<Reply, EngineError> {
        let ready = self.ready.clone();
        if !self.actor.leans_from(&ready) {
            return self.does(Intent::LeanBack, "I am upright");
        }
        self.let_be();
        let went = self.settle(&ready);
        let said = if went { "I am upright again" } else { "I cannot get upright: something is in the way" };
        Ok(self.reply(Intent::LeanBack, said.into(), Some(went), false))
    }
}
