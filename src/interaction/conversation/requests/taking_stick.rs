//! "Here is a stick: take it with your right hand", "give me back the stick", "how long is the stick?"

use super::super::Conversation;
use super::{Act, Acted, Answer, Intent, RequestKind};
use crate::interaction::conversation::grammar::Request;
use crate::interaction::stick::KnownStick;
use crate::interaction::tasks::tried;

pub(super) const TAKE_STICK: RequestKind = RequestKind::new(
    ["take the stick", "took the stick"],
    Act::Moves(|creature, request, _| creature.take_stick(request)),
)
.told(
    "GRAB|have|get|accept|pick|lift|KEEP ?up STICK ; take|get|catch|keep ?GOOD hold of STICK ; \
         ^ here be STICK ; LIFT|GRAB STICK ?UP ; reach for STICK ; \
         GRAB|have|get|hold|accept|want|take|need STICK ; take|hold .. STICK ; \
         i .. GIVE|hand|hold .. you .. STICK ; GIVE you STICK ; STICK for you ; for you STICK ; \
         STICK & take|hold|GRAB|get ; here STICK ; here ?you ?go STICK ; STICK .. GRAB|take|catch THING ; \
         take my STICK",
)
.needs_body();

pub(super) const GIVE_STICK_BACK: RequestKind = RequestKind::new(
    ["give the stick back", "gave the stick back"],
    Act::Moves(|creature, _, _| creature.give_stick_back()),
)
.denied("stop|STOP =using|=holding STICK ; no more STICK")
.asked("i|we ?have|get .. STICK BACK")
.told(
    "GIVE ?me ?BACK STICK ?BACK ; PUT|take STICK DOWN|away|BACK|SIDEWAYS|off ; \
         PUT DOWN|away|BACK|SIDEWAYS STICK ; DROP|return STICK ; LET STICK go|fall|drop ; \
         LET|leave ?go of|off STICK ; GIVE STICK ; STICK BACK|down|away ; \
         want|like|have|need|get STICK BACK ; get rid of STICK ; leave|lose|DROP|LET|return STICK ; \
         GIVE .. STICK ; STICK & give|return|DROP ; away with STICK ; give me my STICK ; \
         let me have STICK ; no more STICK ; stop =using STICK ; off with STICK ; DROP STICK",
);

pub(super) const STICK_KNOWN: RequestKind = RequestKind::new(
    ["tell what I know of the stick", "told what I know of the stick"],
    Act::Tells(|creature, _| Answer::tells(creature.stick_in_words())),
)
.asked(
    "how ?long|SIZED|FAR be STICK ; what|where|whereabouts be STICK ; \
         do|be you ?still have|hold|know|feel|get STICK ; LENGTH|tip|end|point|SIZE of|OF STICK ; STICK ; \
         be|do .. STICK ; ASKING .. STICK ; ASKING .. hold|have|reach|end|know .. STICK ; TELL .. STICK ; \
         STICK .. LENGTH|end|reach|hold|have ; hold|have STICK ; HAND .. STICK ; STICK in HAND ; \
         how FAR .. STICK ; ASKING HELPING you TELL .. STICK",
);

impl Conversation {
    /// Holds out a hand for a stick, and learns it by touching himself with it; gives it back where he cannot tell where its
    /// tip is.
    fn take_stick(&mut self, request: &Request) -> Acted {
        // The right hand, where none is named.
        let right = (0..2).find(|&hand| self.actor.side(hand) < 0.0).unwrap_or(1);
        let named = self.hand_for(request.hand);
        if let Some(stick) = self.actor.stick() {
            let as_told = named.is_none_or(|hand| hand == stick.hand);
            return Ok(Answer::does(self.stick_in_words(), as_told));
        }
        let hand = named.unwrap_or(right);
        let name = self.hand_name(hand);
        self.let_be();
        self.settle_at_ready();
        // While he does not know how far the stick reaches he keeps it well over a table.
        if self.actor.table.is_none() {
            tried(self.actor.feel_table(hand))?;
        }
        tried(self.actor.hold_out(hand))?;
        if !self.actor.take_stick(hand)? {
            self.settle_at_ready();
            return Ok(Answer::failed(format!("I held out my {name}, and was given no stick")));
        }
        let Some(known) = tried(self.actor.learn_stick())?.flatten() else {
            self.actor.give_stick_back()?;
            self.settle_at_ready();
            return Ok(Answer::failed(
                "I touched myself with the stick and could not tell where its tip is: I gave it back",
            ));
        };
        self.stick_changed();
        Ok(Answer::done(format!(
            "I hold the stick with my {name}, and touched myself {} times with it, {} times with its tip: {}",
            known.touches,
            known.by_tip,
            tip_in_words(&known)
        )))
    }

    /// Gives the stick back, where there is one.
    pub(super) fn give_stick_back(&mut self) -> Acted {
        let Some(hand) = self.actor.stick().map(|stick| stick.hand) else {
            return Ok(Answer::failed("I hold no stick"));
        };
        self.let_be();
        let tip = self.actor.stick_tip();
        let bare = self.actor.hands[hand].tip;
        // What the stick's tip felt was felt by that hand.
        self.things.felt_by_another(|receptor| if Some(receptor) == tip { bare } else { receptor });
        self.actor.give_stick_back()?;
        self.stick_changed();
        Ok(Answer::done("I gave the stick back"))
    }

    /// Goes to where its hands wait with or without a stick, and reaches as far as it does now.
    fn stick_changed(&mut self) {
        self.reachable.take();
        self.ready = self.actor.ready();
        self.settle_at_ready();
    }

    /// What he knows of a stick.
    fn stick_in_words(&self) -> String {
        match self.actor.stick() {
            Some(stick) => {
                let name = self.hand_name(stick.hand);
                let known = stick.known.map_or("I do not know it".to_string(), |known| {
                    let [x, y, z]: [f64; 3] = known.tool.tip.into();
                    format!("{} (at {x:.3},{y:.3},{z:.3} m in that hand's frame)", tip_in_words(&known))
                });
                format!("I hold the stick with my {name}: {known}")
            }
            None => "I hold no stick".into(),
        }
    }

    /// Why something cannot be done with a stick in a hand; none where it can.
    pub(in super::super) fn barred_by_stick(&self, request: &Request) -> Option<String> {
        let stick = self.actor.stick()?;
        let name = self.hand_name(stick.hand);
        let with_both = request.intent == Intent::Lift && request.hand.is_none();
        let feels_about = matches!(request.intent, Intent::Explore | Intent::FeelShape | Intent::FeelOver)
            || (request.intent == Intent::Touch && request.any && self.things.is_empty());
        let by_its_hand =
            matches!(request.intent, Intent::Lift | Intent::PutFar | Intent::BringNear | Intent::PutAside)
                && self.hand_for(request.hand) == Some(stick.hand);
        (with_both || feels_about || by_its_hand)
            .then(|| format!("The stick in my {name} is in the way of that: tell me to give it back first"))
    }
}

/// Where the tip is.
fn tip_in_words(known: &KnownStick) -> String {
    format!(
        "its tip is {:.0} cm from where I hold it, which I know to {:.1} mm",
        100.0 * known.length(),
        0.1 * (1e4 * known.within).ceil()
    )
}
