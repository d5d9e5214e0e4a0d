//! "Feel its shape": it touches a thing all about with the fingertips of both hands. "How big is it?", "what shape is it?": from
//! what that told; before that from where it was felt, which is little.

use super::super::Conversation;
use super::super::speaking::cm;
use super::{Act, Acted, Answer, RequestKind};
use crate::interaction::conversation::grammar::Request;
use crate::interaction::tasks::Trouble;
use crate::interaction::things::{KnownShape, KnownThing};
use crate::peripersonal::FeltLength;

/// Touches of a thing whose shape is to be felt.
const TOUCHES: usize = 15;
/// Touches at the least that tell a shape.
const FEW: usize = 4;
/// Gaps that one body leaves where skin touched it, root mean square, up to which touches are of one thing that stayed, metres.
const FITS: f64 = 0.003;
/// A length whose deviation is above this is known roughly only, metres.
const ROUGHLY: f64 = 0.005;

pub(super) const FEEL_SHAPE: RequestKind = RequestKind::of_body(
    ["feel its shape", "felt its shape"],
    Act::Handles(Conversation::feel_shape),
    "told: FEEL|EXAMINE|SEARCH|FIND|TOUCH|get|make|take|work .. FORM|EDGE|SIZE; FEEL|FIND|EXAMINE|see ?out what \
     THING|SOME be|look; FEEL|FIND|EXAMINE|work|see|SEARCH .. how SIZED|SHAPED; RUN ?with ?your HAND|PART ?ALL \
     ?way AROUND THING|the|its|EDGE; EXAMINE|SEARCH|palpate THING; FEEL ?ALL ?way AROUND THING; FEEL|TOUCH THING \
     ALL|AROUND|up|from|closely; FEEL|FIND|EXAMINE ?out whether|if|what ?THING ?be|is SHAPED|like|box; \
     get|have|take|give ?THING a|the ?GOOD ?proper FEEL ?for|of|over; GO|RUN ?ALL AROUND ?ALL ?its EDGE|THING; \
     get|come to KNOW|EXAMINE THING|FORM; wrap|put|close HAND AROUND THING; FIND|work|figure|make out what \
     KIND|FORM; FEEL THING; give THING .. FEEL; FEEL what KIND; FIND out what THING; EXAMINE|SEARCH|FEEL|TOUCH|RUN \
     .. ALL|each ?face|side|part|bit|face|sides OF THING; TOUCH THING in|at|from|on .. \
     places|sides|points|spots|times & MORE|NUMBER|ALL|different",
);

pub(super) const HOW_BIG: RequestKind = RequestKind::answer(
    Act::Tells(|creature, _| creature.felt_in_words("how big it is")),
    "asked: how SIZED .. THING; as SIZED as; SIZE; be|do THING|SOME ?seem|feel|look|appear ?that|ALL|BIT SIZED; \
     bigger|smaller|larger|taller|wider|longer|higher ?or|than; fit in|into|inside|between ?one|your HAND|BODY; \
     THING ?be SIZED; small|big|large enough",
);

pub(super) const WHAT_SHAPE: RequestKind = RequestKind::answer(
    Act::Tells(|creature, _| creature.felt_in_words("its shape")),
    "told: TELL ?me ?about its|the FORM; asked: HELPING THING be SOME; FORM; be|do THING|SOME|they \
     ?seem|feel|look|have|got|get ?any|MORE|like|ALL|to ?be ?be ?like SHAPED; be|do THING|SOME ?seem|feel|look \
     ?MORE ?like|to ?be SOME; describe THING|SOME|its; what ?KIND ?of ?SOME|THING HELPING THING|SOME \
     ?look|feel|seem|be ?like|resemble; what .. THING look|feel ?like; what KIND of THING|SOME ?be|have|do; SHAPED \
     or|and|nor SHAPED; any SHAPED|EDGE ON; THING have SHAPED|EDGE; SOME or SOME; have THING ?get|any \
     SHAPED|EDGE|a; what THING|that be; what ?HELPING you TELL|KNOW ?me about|of THING|its; THING be .. SHAPED; \
     description; how do THING FEEL|look|seem; what you think THING be",
);

impl Conversation {
    fn feel_shape(&mut self, thing: &KnownThing, request: &Request) -> Acted {
        let touched_now = |creature: &Conversation| {
            let known = creature.mind.things.get(thing.id)?;
            let touches = known.in_touch.is_some() && creature.actor.posture() == known.found.posture;
            touches.then(|| known.found.clone())
        };
        let found = match touched_now(self) {
            Some(found) => found,
            None => {
                let answer = self.touch(thing, self.hand_for(request.hand), request.lean)?;
                touched_now(self).ok_or(Trouble::Told(answer.said))?
            }
        };
        self.mind.things.parted();
        let felt = self.actor.feel_shape(&found, TOUCHES);
        let went = felt.as_ref().is_ok_and(|felt| self.actor.go_about(&felt.shape, &self.ready).is_ok());
        if !went {
            self.settle();
        }
        let felt = felt?;
        if felt.touches < FEW {
            return Ok(Answer::failed("I could touch it only in a few places, so I do not know its shape"));
        }
        if felt.shape.unexplained > FITS {
            return Ok(Answer::failed(
                "What I felt is inconsistent: it may have moved, so I do not know its shape",
            ));
        }
        let (front, left, up) = (self.actor.front, self.actor.left(), self.actor.up);
        let sides = [
            (-front, "in front"),
            (front, "behind"),
            (left, "on the left"),
            (-left, "on the right"),
            (up, "on top"),
        ];
        let unfelt = sides.into_iter().filter(|(side, _)| !felt.shape.is_felt_along(side));
        let unfelt = unfelt.map(|(_, words)| words).collect();
        let shape = KnownShape { size: felt.shape.size(&up), touches: felt.touches, unfelt };
        if let Some(known) = self.mind.things.get_mut(thing.id) {
            known.shape = Some(shape);
        }
        Ok(Answer { done: Some(true), ..self.felt_in_words("its shape") })
    }

    /// What it may say of the size or the shape of the thing of which they talk.
    fn felt_in_words(&self, what: &str) -> Answer {
        Answer::tells(match self.mind.things.it() {
            None if self.mind.things.is_empty() => "I have not felt anything yet".into(),
            None => self.mind.question(&self.actor),
            Some(KnownThing { shape: Some(shape), .. }) => said_of(shape),
            Some(known) => {
                let places = &known.places;
                let apart = places.iter().flat_map(|a| places.iter().map(move |b| (a - b).norm()));
                match places.len() {
                    0 | 1 => format!(
                        "I have felt it in only one place, so I do not know {what}: ask me to feel its shape"
                    ),
                    n => format!(
                        "I have felt it in {n} places, at most {} apart: it is at least that wide, and I know no \
                         more of {what}",
                        cm(apart.fold(0.0, f64::max))
                    ),
                }
            }
        })
    }
}

/// What it may say of a shape that it has felt: how large it is, and where it could not feel it. What kind of thing that is
/// touches do not tell for certain.
fn said_of(shape: &KnownShape) -> String {
    let told = |felt: &FeltLength| {
        format!("{} {}", if felt.deviation > ROUGHLY { "roughly" } else { "about" }, cm(felt.length))
    };
    let [height, length, breadth] = [&shape.size.height, &shape.size.length, &shape.size.breadth].map(told);
    let mut said = format!(
        "I have touched it {} times: it is {height} high, {length} long and {breadth} wide; I am not sure what \
         kind of thing it is",
        shape.touches,
    );
    if !shape.unfelt.is_empty() {
        said += &format!(". I could not feel it well {}", shape.unfelt.join(", nor "));
    }
    said
}
