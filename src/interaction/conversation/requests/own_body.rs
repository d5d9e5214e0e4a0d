//! What is about its own body: "touch your nose", "has your body changed?", "watch out", "lean forward and try again", "lean back",
//! "rest", "again".

use super::super::speaking::cm;
use super::super::{Conversation, OwnSpot, Pending};
use super::{Act, Acted, Answer, Intent, Reply, RequestKind};
use crate::interaction::avoiding::Avoiding;
use crate::interaction::body_part;
use crate::interaction::conversation::grammar::{Leave, Request};
use crate::interaction::tasks::{BodyFound, FeltOver, Trouble, tried};
use crate::named::in_words;
use crate::peripersonal::distance;

/// Places of a part that are tried, the one that it is first.
const TRIES: usize = 6;
/// Skin this near to a part is that part, metres: a patch's width.
const NEAR: f64 = 0.01;
/// How long it watches, seconds of its own time, …
const WATCHING: f64 = 5.0;
/// … how far joints have gone where it got out of a way, radians.
const MOVED: f64 = 0.02;

pub(super) const TOUCH_OWN: RequestKind = RequestKind::of_body(
    ["touch myself there", "touched myself"],
    Act::Moves(Conversation::touch_part),
    "told: TOUCH|TEND|FEEL BODY; PUT|get|keep|have|press|point|raise|lift|REACH|hold|LET|take|PULL|PUSH|guide ?one \
     HAND|finger|hand|palm ?UP|down|over|back|rest|go|out|TOUCH ?straight ON|OF|around|touch|by|behind|near \
     ?contact|top|touch ?with|of BODY; get|have|lay|keep|GRAB hold of BODY; ^ PART with|by ?your HAND $; HAND \
     ?should|must|be|GO ?be|go ON BODY; BODY .. HAND ON THING|PART; PART .. TOUCH|TEND|GRAB|REACH|FEEL|PUT|give \
     THING|PART; with|by HAND .. BODY; REACH ?UP|DOWN|out|BACK|behind|AROUND ?for|and|ON ?TOUCH|TEND ?behind BODY; \
     give BODY ?GOOD ?BIT TOUCH|TEND; GRAB ON BODY; PUT|PULL|get BODY .. ON|near BODY; ^ PART $; RUN|wipe ?your \
     HAND|finger .. PART; TOUCH|TEND|GRAB|cup .. PART",
);

pub(super) const FEEL_OVER: RequestKind = RequestKind::new(
    ["explore my body", "explored my body"],
    Act::Moves(|creature, _, _| creature.feel_over()),
    "told: FEEL|TOUCH ?your ?whole|entire yourself|body ?ALL ?AGAIN|AROUND; FEEL|TOUCH yourself|BODY \
     ALL|anew|AROUND; FEEL|TOUCH ALL over ?your yourself|body|BODY; CALIBRATE; FIND|work out ?how|what|whether \
     ?your body; EXAMINE|FIND|see .. whether|if|how .. body|limbs|BODY .. changed|=changed|=same|as|still; \
     body|limbs .. changed; EXAMINE|FEEL|pat|SEARCH|KNOW .. body|yourself|limbs & !stick; give yourself|body .. \
     once|check|feel|exam|examination; update|refresh .. body|yourself; GO|RUN ?HAND over|along ?your \
     yourself|body|limbs; FEEL|TOUCH ALL ?over ?of yourself|body; self check|test|exam|calibration|CALIBRATE; \
     EXAMINE ?your PART; ^ body SEARCH|EXAMINE; do .. body EXAMINE; asked: be ?your body ?still \
     same|changed|different|=changed; past: have BODY|your ?body changed|=changed",
);

pub(super) const AVOID: RequestKind = RequestKind::of_body(
    ["get out of the way", "watched what came near"],
    Act::Moves(|creature, _, _| creature.watch_out()),
    "said: THING|SOME ?be =coming|=approaching|=flying|=moving; told: AVOID; out of ?its|his|my|harm|THING way; \
     GO|keep|stay|steer|PULL|hold|stand ?yourself|BODY ?well clear; GO|jump|stand|shift ?yourself|BODY ?out|over \
     aside|SIDEWAYS; watch|look|mind out; make way|room; GO|keep|stay|back|jump|PULL ?yourself|BODY|PART \
     ?BACK|well FAR ?from ?THING|SOME|what & !HAND; KEEP|maintain ?your|some ?safe distance; PROTECT \
     yourself|BODY; get out ?of there|here $; ^ move $; ^ GO|jump BACK $; let THING|SOME pass; incoming; beware; \
     move so .. miss|past; get|be missed; GO|keep|stay ?yourself ?well ?right out|clear of; THING|SOME \
     =comes|=approaches|=flies; GO|stay|keep ?yourself out of ?its range|reach|way|path; ^ danger; denied: \
     not|nothing|never LET THING|SOME ?at|ever TOUCH|reach|bump|get|TEND|catch; not get|be \
     hit|=touched|=struck|caught|bumped & !THING; not to get|be hit|=touched & !THING; GO .. THING|SOME HELPING \
     not hit|TOUCH|get|reach|catch; nothing|nobody TOUCH|hit|reach|get you|PART|BODY; avoid|dodge ?=being|=getting \
     =hit|hit|it|THING",
);

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
    fn touch_part(&mut self, request: &Request, _: &Leave) -> Acted {
        let Some(part) = &request.part else {
            return Ok(Answer::asks("Which part of me do you mean?"));
        };
        let found = body_part::find(&self.actor, part, self.hand_touching());
        let found = found.map_err(Trouble::Told)?;
        let by = self.hand_for(request.hand);
        if request.stick && self.actor.stick_tip().is_none() {
            return Ok(Answer::failed("I am not holding a stick"));
        }
        self.let_be();
        let mut trouble = None;
        for part in &found {
            // As the arms are, and then with the arm that it is on held out to the other.
            for held_out in [false, true] {
                if held_out && !tried(self.actor.present(part.receptors[0]))?.unwrap_or(false) {
                    break;
                }
                for &receptor in part.receptors.iter().take(TRIES) {
                    let touched = match request.stick {
                        true => self.actor.with_stick(|actor, hand| actor.touch_own(receptor, Some(hand))),
                        false => self.actor.touch_own(receptor, by),
                    };
                    let this = match touched {
                        Err(this) => this.of_task()?,
                        Ok(touch) => {
                            self.spot = Some(OwnSpot { receptor, by_stick: request.stick });
                            let name = match request.stick {
                                true => "stick".to_string(),
                                false => self.hand_name(touch.hand),
                            };
                            let off = part.off(&self.actor, touch.felt);
                            let (what, far) = if off < NEAR {
                                ("", String::new())
                            } else {
                                ("myself ", cm(off) + " from ")
                            };
                            return Ok(Answer::done(format!(
                                "I touch {what}{far}my {} with my {name}",
                                part.name
                            )));
                        }
                    };
                    let met = matches!(this, Trouble::Hit(_) | Trouble::Nothing);
                    trouble.get_or_insert((part.name.clone(), this));
                    if met {
                        self.settle();
                    }
                }
            }
        }
        self.settle();
        match trouble {
            Some((name, trouble)) => Err(self.hindered(&format!("I cannot touch my {name}"), trouble)),
            None => Ok(Answer::failed(format!("I have no skin to touch at my {}", part.text()))),
        }
    }

    /// Feels itself over, and tells what has changed.
    fn feel_over(&mut self) -> Acted {
        self.let_be();
        self.settle();
        let found = self.actor.feel_over();
        let FeltOver { touches, body } =
            found.map_err(|trouble| self.hindered("I could not explore my whole body", trouble))?;
        // What he touched himself with was meant.
        self.actor.take_unexpected();
        if matches!(body, BodyFound::Changed(_)) {
            self.mind.things.forget_all();
            self.search = None;
            self.reachable.take();
            self.ready = self.actor.ready();
        }
        self.settle();
        Ok(match body {
            BodyFound::Same => Answer::done(format!("{touches} self-touches: my body is as I know it")),
            BodyFound::Changed(joints) => {
                let names = self.actor.own.creature().joints();
                let told = joints.iter().map(|(joint, distance)| {
                    let name = in_words(&names[*joint].name);
                    format!("my {name} is {:.1} cm from where I thought", 100.0 * distance)
                });
                let told = told.collect::<Vec<_>>().join("; ");
                Answer::done(format!(
                    "{touches} self-touches show that my body has changed: {told}. From now on I use what I \
                     learned, and have to feel again where the table and its things are"
                ))
            }
            BodyFound::Unexplained => Answer::failed(format!(
                "{touches} self-touches show that my body is not as I know it, but not how it has changed. I will \
                 not act until I know it again"
            )),
            BodyFound::Undecided if touches == 0 => Answer::failed(
                "I do not know how accurate my body schema is, so I cannot tell whether my body has changed: I \
                 should babble again",
            ),
            BodyFound::Undecided => Answer::failed(format!(
                "{touches} self-touches are too few to tell whether my body has changed"
            )),
        })
    }

    /// Says that it touched itself where it did not expect it, and asks whether to feel itself over, where that happened.
    pub(in super::super) fn heed_unexpected(&mut self, reply: &mut Reply) {
        let Some((receptors, off)) = self.actor.take_unexpected() else { return };
        if reply.asks || self.pending.is_some() {
            return;
        }
        let [a, b] = receptors.map(|receptor| self.limb_in_words(receptor));
        let how = if off > 0.0 { "apart" } else { "inside each other" };
        reply.said += &format!(
            " My {a} and my {b} touched, although I expected them {} {how}: my body may have changed. Shall I \
             explore my body?",
            cm(off.abs().max(0.01))
        );
        reply.asks = true;
        self.pending = Some(Pending::Whether(Request { intent: Intent::FeelOver, ..Request::default() }));
    }

    /// Watches for a while, out of the way of what comes.
    fn watch_out(&mut self) -> Acted {
        // What it touches it cannot keep away from: the arm first.
        let touched = self.mind.things.iter().any(|known| known.in_touch.is_some());
        self.let_be();
        let before = self.actor.posture();
        let mut avoiding = Avoiding::new(&mut self.actor);
        let (mut seconds, mut met) = (0.0, false);
        let step = self.actor.handle.timestep();
        while seconds < WATCHING {
            met |= !avoiding.step(&mut self.actor)?.is_empty();
            seconds += step;
        }
        let moved = distance(&self.actor.posture(), &before) > MOVED;
        let from = if touched { "I took my arm away from it, and watched" } else { "I watched" };
        let said = match (moved, met) {
            (true, false) => "I got out of the way, and it did not touch me".to_string(),
            (true, true) => "I moved out of the way, but it touched me".to_string(),
            (false, _) => {
                let felt = if met { "; I feel a touch, but" } else { ":" };
                format!("{from} for {WATCHING:.0} seconds{felt} nothing came at me")
            }
        };
        Ok(Answer::does(said, !(moved && met)))
    }

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
