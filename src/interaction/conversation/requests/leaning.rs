//! "Lean forward and try again", "lean back".

use super::super::Conversation;
use super::{Act, Acted, Answer, RequestKind};
use crate::interaction::conversation::grammar::{Leave, Request};
use crate::interaction::tasks::Trouble;

pub(super) const LEAN_FORWARD: RequestKind = RequestKind::new(
    ["lean forward", "leaned forward"],
    Act::Moves(|creature, request, leave| creature.lean(request, leave)),
)
.told(
    "yourself|you ?BIT MORE FORWARD ; \
         LEAN ?your ?PART|yourself|HAND|over|body ?BIT ?way|at|from ?waist|hips ?far ?MORE FORWARD ; \
         AGAIN & LEAN FORWARD ; TRY|REPEAT & LEAN FORWARD ; \
         LEAN ?your ?PART|yourself|body ?BIT ?FAR ?MORE \
         over|down|in|into|ON|out|across|closer|ahead|at|MORE|further ; ^ LEAN $ ; ^ LEAN ?BIT ?MORE ; \
         ^ ?BIT ?MORE|FAR FORWARD $ ; \
         come|get|move|bring|push|REACH ?yourself|PART|FAR ?BIT ?MORE FORWARD & !THING|SOME ; \
         LEAN BIT|now|PART & !BACK|UPRIGHT ; come|get|go closer|nearer to|over TABLE & !THING ; \
         move|bring|get BODY|yourself NEAR|over ON|the TABLE ; \
         get|move|bring ?your yourself|PART|body ?BIT ?FAR FORWARD|over|further ; LEAN PART ; a|the lean ; \
         have|take a lean|bow ; bow $ ; LEAN to ; LEAN so ; lean as ; LEAN with ; \
         PUT|shift|move|bring|PUSH|GO|tip .. weight|BODY|chest|torso|trunk|shoulders ?BIT ?MORE FORWARD ; \
         GO FORWARD & !THING|ahead ; LEAN ; lower PART ON|over ; stretch FORWARD ; MORE FORWARD ; \
         len FORWARD ; PULL|PUSH yourself FORWARD ; GO NEAR ?to ?TABLE with PART ; \
         PART ?down ON|to|over TABLE ; FORWARD with you|PART",
)
.needs_body();

pub(super) const LEAN_BACK: RequestKind = RequestKind::new(
    ["lean back", "leaned back"],
    Act::Moves(|creature, _, _| creature.upright()),
)
.said("^ BACK ?BIT $")
.told(
    "LEAN ?PART|yourself|THING ?BIT BACK ; LEAN ?BIT away|off ; LEAN ?right BACK ; LEAN .. other way ; \
         up you get ; STRAIGHTEN up|yourself|BODY|out|BACK|UPRIGHT ; ^ STRAIGHTEN $ ; ^ unbend ; \
         STRAIGHTEN ?BACK up ; UPRIGHT ; \
         sit|stand|get|come|go|lift|raise|straighten ?yourself|PART BACK ?UP ; \
         sit|stand ?BACK UP|BACK|properly ; raise|lift|straighten yourself|BODY & !HAND ; \
         stop|undo =leaning|lean ; back up|upright|straight ; \
         get|come|be|keep|hold ?yourself|BODY UPRIGHT ; un bend ; \
         take|get|pull|move|bring your|yourself|PART BACK & !HAND|THING ; UP straight ; no LEAN ; \
         UPRIGHT ?again|BACK ; GO ?BACK UPRIGHT ; up ?BACK UPRIGHT ; STRAIGHTEN your ; \
         PULL|raise|lift|bring|get yourself|BODY UPRIGHT|UP|BACK & !HAND ; \
         GO|come|get|be|BACK ?BACK ?to|into|at|in ?sitting UPRIGHT|vertical ?POSE ; \
         sit ?up|BACK ?UP UPRIGHT ; LEAN right|MORE|all BACK ; come|get|BACK ?BACK UP ; \
         undo|end ?your lean ; STRAIGHTEN ; bring|move|PULL PART BACK UP ; vertical ; \
         away from TABLE & LEAN ; no MORE =leaning|=bending ; ^ PART BACK $ ; ^ PART UP $ ; \
         ^ ease|rock|recline ?BACK $ ; sit|stand|get UPRIGHT ; undo .. lean|LEAN ; GO|PULL BACK from TABLE",
)
.denied(
    "STOP|quit|cease =leaning|=bending ; not|stop slouch|slump|=slouching ; not slouch & STRAIGHTEN ; \
         not LEAN any|longer|anymore ; no =slouching|=stooping",
)
.needs_body();

impl Conversation {
    /// Leans; and if something was asked for before that failed or that goes farther so, does that again.
    fn lean(&mut self, request: &Request, leave: &Leave) -> Acted {
        let retried = match (request.again, request.about, self.last.clone()) {
            (true, _, None) => {
                return Ok(Answer::failed("There is nothing yet that I could try again leaning"));
            }
            (true, _, Some(last)) => Some(Request { lean: true, hand: request.hand.or(last.hand), ..last }),
            (false, Some(intent), _) => Some(Request { intent, about: None, lean: true, ..request.clone() }),
            (false, None, _) => None,
        };
        if let Some(retried) = retried {
            return Ok(self.act(retried, Some(leave.again()), &[])?.into());
        }
        self.let_be();
        match self.actor.lean_forward() {
            Ok(far) if far > 0.005 => {
                Ok(Answer::done(format!("I lean forward: my shoulders came {:.0} cm farther", 100.0 * far)))
            }
            Ok(_) => Ok(Answer::done("I lean forward already as far as I can")),
            Err(Trouble::Reach(_)) => {
                Ok(Answer::failed("I cannot lean forward: something would be in the way"))
            }
            Err(trouble) => Err(trouble),
        }
    }

    fn upright(&mut self) -> Acted {
        let ready = self.ready.clone();
        if !self.actor.leans_from(&ready) {
            return Ok(Answer::done("I am upright"));
        }
        self.let_be();
        Ok(match self.settle(&ready) {
            true => Answer::done("I am upright again"),
            false => Answer::failed("I cannot get upright: something is in the way"),
        })
    }
}
