//! "Lean forward and try again", "lean back", "rest", "again".

use super::super::Conversation;
use super::{Act, Acted, Answer, RequestKind};
use crate::interaction::conversation::grammar::{Leave, Request};
use crate::interaction::conversation::speaking::cm;
use crate::interaction::tasks::Trouble;

pub(super) const LEAN_FORWARD: RequestKind = RequestKind::of_body(
    ["lean forward", "leaned forward"],
    Act::Moves(Conversation::lean),
    "told: LEAN ?your ?PART|yourself|HAND|over|body ?BIT ?way|at|from ?waist|hips ?far ?MORE FORWARD; AGAIN & LEAN \
     FORWARD; ^ ?BIT ?MORE|FAR FORWARD $; come|get|move|bring|push|REACH ?yourself|PART|FAR ?BIT ?MORE FORWARD & \
     !THING|SOME; come|get|go closer|nearer to|over TABLE & !THING; move|bring|get BODY|yourself NEAR|over ON|the \
     TABLE; PUT|bring|PUSH|GO|tip .. weight|BODY|chest|torso|trunk|shoulders ?BIT ?MORE FORWARD; LEAN; MORE \
     FORWARD; PULL|PUSH yourself FORWARD",
);

pub(super) const LEAN_BACK: RequestKind = RequestKind::of_body(
    ["lean back", "leaned back"],
    Act::Moves(|creature, _, _| match creature.actor.leans_from(&creature.ready) {
        true => creature.back("upright again", "upright"),
        false => Ok(Answer::done("I am upright")),
    }),
    "said: ^ BACK ?BIT $; told: LEAN ?PART|yourself|THING ?BIT BACK; LEAN .. other way; up you get; STRAIGHTEN \
     up|yourself|BODY|out|BACK|UPRIGHT; sit|stand|get|come|go|lift|raise|straighten ?yourself|PART BACK ?UP; \
     sit|stand ?BACK UP|BACK|properly; raise|lift|straighten yourself|BODY & !HAND; un bend; UP straight; no LEAN; \
     UPRIGHT ?again|BACK; PULL|raise|lift|get yourself|BODY UPRIGHT|UP|BACK & !HAND; GO|be|BACK ?BACK \
     ?to|into|at|in ?sitting UPRIGHT ?POSE; LEAN right|MORE|all BACK; come|get|BACK ?BACK UP; STRAIGHTEN; away \
     from TABLE & LEAN; sit|stand|get UPRIGHT; undo .. LEAN; denied: STOP|quit =leaning|=bending; not LEAN \
     any|longer|anymore",
);

pub(super) const REST: RequestKind = RequestKind::new(
    ["go back to rest", "went back to rest"],
    Act::Moves(|creature, _, _| {
        creature.actor.let_go();
        creature.back("at rest again", "back to rest")
    }),
    "told: ^ assume|adopt|resume|take|take .. START ?old POSE; have|take|get ?yourself|your ?GOOD|BIT|short \
     ?earned|deserved rest|break|breather; at ease; GO|sit ?BACK home; lower|relax|withdraw|retract|hang|rest|DROP \
     BODY; PUT|lower|take|LET|PULL|DROP HAND ?BACK DOWN|BACK|rest|hang|fall|away|in|at|by|home|drop; HAND \
     ?sink|fall|drop|GO DOWN|BACK $; HAND ?BACK ?DOWN to|at|by|in ?your side|sides|lap|START; settle down|BACK; \
     reset yourself|your|BODY; BACK|GO|PUT .. where|how ?you|THING|they ?PAST \
     start|begin|=was|=were|came|=started|=began|PAST; RELAX; a|short|good|BIT rest|break|breather; take THING \
     easy; ^ return $; GO limp|slack; GO BACK to|START; stand down|easy|easily; hang loose; GO|fold \
     BACK|to|in|into ?to|in|into ?your START ?POSE; START ?POSE ?please $; BACK ?to|at|in ?your START ?POSE; \
     take|get|PULL|remove HAND off|from TABLE; ^ reset $",
);

pub(super) const REPEAT: RequestKind = RequestKind::new(
    ["do it again", "did it again"],
    Act::Moves(|creature, request, leave| match creature.last.clone() {
        Some(last) => creature.again(last, request, leave),
        None => Ok(Answer::failed("I have not done anything yet that I could do again")),
    }),
    "told: ^ ?and ?try AGAIN; ^ ?and AGAIN but; ^ encore; once|one|twice|another ?last MORE ?again|time; \
     DO|TRY|have ?THING|so|that|SOME ?same ?thing ?ALL|over ?yet ?once ?over AGAIN|over; have|take|give ?THING \
     ?another ?second|third|MORE TRY|shot|crack|stab|bash|whirl|GO; go AGAIN|over; DO THING ?one|once MORE|again; \
     DO ?that same ?again|thing; same again|thing|procedure; go|start|TRY over again; keep =trying|going; \
     second|third time; AGAIN $ & !HELLO; MORE time; perform|play|show|see ?THING|that AGAIN; go through THING \
     AGAIN; REPEAT; another|one ?MORE go|try|attempt; another|one ?MORE round|turn; ^ take two",
);

impl Conversation {
    /// Does something again that it was asked for, with the hand that is named now.
    fn again(&mut self, last: Request, request: &Request, leave: &Leave) -> Acted {
        let again = Request { hand: request.hand.or(last.hand), lean: request.lean || last.lean, ..last };
        Ok(self.act(again, Some(leave.again()), &[])?.into())
    }

    /// Goes back to where its hands wait.
    fn back(&mut self, done: &str, place: &str) -> Acted {
        self.let_be();
        Ok(match self.settle() {
            true => Answer::done(format!("I am {done}")),
            false => Answer::failed(format!("I cannot get {place}: something is in the way")),
        })
    }

    /// Leans; and if something was asked for before that failed or that goes farther so, does that again.
    fn lean(&mut self, request: &Request, leave: &Leave) -> Acted {
        let leaning = Request { lean: true, ..request.clone() };
        match (request.again, request.about, self.last.clone()) {
            (true, _, Some(last)) => return self.again(last, &leaning, leave),
            (true, _, None) => {
                return Ok(Answer::failed("There is nothing yet to try again while leaning"));
            }
            (false, Some(intent), _) => {
                return self.again(Request { intent, about: None, ..leaning }, request, leave);
            }
            (false, None, _) => {}
        }
        self.let_be();
        match self.actor.lean_forward() {
            Ok(far) if far > 0.005 => {
                Ok(Answer::done(format!("I am leaning forward: my shoulders moved {} farther", cm(far))))
            }
            Ok(_) => Ok(Answer::done("I am already leaning forward as far as I can")),
            Err(Trouble::Reach(_)) => {
                Ok(Answer::failed("I cannot lean forward: something would be in the way"))
            }
            Err(trouble) => Err(trouble),
        }
    }
}
