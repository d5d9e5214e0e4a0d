//! "Here is a stick: take it with your right hand", "give me back the stick", "how long is the stick?"

use super::super::Conversation;
use super::super::speaking::cm;
use super::{Act, Acted, Answer, Intent, RequestKind};
use crate::interaction::conversation::grammar::{Leave, Request};
use crate::interaction::stick::KnownStick;
use crate::interaction::tasks::tried;

pub(super) const TAKE_STICK: RequestKind = RequestKind::of_body(
    ["take the stick", "took the stick"],
    Act::Moves(Conversation::take_stick),
    "told: GRAB|have|get|accept|pick|lift|KEEP ?up STICK; reach for STICK; i .. GIVE|hand|hold .. you .. STICK; \
     GIVE you STICK; STICK for you; for you STICK; STICK & GRAB|get; here ?you ?go STICK",
);

pub(super) const GIVE_STICK_BACK: RequestKind = RequestKind::new(
    ["give the stick back", "gave the stick back"],
    Act::Moves(|creature, _, _| creature.give_stick_back()),
    "told: GIVE ?me ?BACK STICK ?BACK; PUT|take STICK DOWN|away|BACK|SIDEWAYS|off; PUT DOWN|away|BACK|SIDEWAYS \
     STICK; LET|leave ?go of|off STICK; STICK BACK|down|away; get rid of STICK; leave|lose|DROP|LET|return STICK; \
     STICK & give|return|DROP; away with STICK; let me have STICK; off with STICK; asked: i|we ?have|get .. STICK \
     BACK; denied: STOP =using|=holding STICK",
);

pub(super) const STICK_KNOWN: RequestKind =
    RequestKind::answer(Act::Tells(|creature, _| Answer::tells(creature.stick_in_words())), "asked: STICK");

impl Conversation {
    /// Holds out a hand for a stick, and learns it by touching himself with it; gives it back where he cannot tell where its
    /// tip is.
    fn take_stick(&mut self, request: &Request, _: &Leave) -> Acted {
        let named = self.hand_for(request.hand);
        if let Some(stick) = self.actor.stick() {
            let as_told = named.is_none_or(|hand| hand == stick.hand);
            return Ok(Answer::does(self.stick_in_words(), as_told));
        }
        // The right hand, where none is named.
        let hand = named.unwrap_or(self.actor.hand_towards(&-self.actor.left()));
        let name = self.hand_name(hand);
        self.let_be();
        self.settle();
        // While he does not know how far the stick reaches he keeps it well over a table.
        if self.actor.table.is_none() {
            tried(self.actor.feel_table(hand))?;
        }
        tried(self.actor.hold_out(hand))?;
        if !self.actor.take_stick(hand)? {
            self.settle();
            return Ok(Answer::failed(format!("I held out my {name}, but was not given a stick")));
        }
        let Some(known) = tried(self.actor.learn_stick())?.flatten() else {
            self.actor.give_stick_back()?;
            self.settle();
            return Ok(Answer::failed(
                "I touched my body with the stick but could not tell where its tip is, so I gave it back",
            ));
        };
        self.stick_changed();
        Ok(Answer::done(format!(
            "I am holding the stick with my {name}, and touched my body with it {} times, {} of them with its tip: {}",
            known.touches,
            known.by_tip,
            tip_in_words(&known)
        )))
    }

    /// Gives the stick back, where there is one.
    pub(super) fn give_stick_back(&mut self) -> Acted {
        let Some(hand) = self.actor.stick().map(|stick| stick.hand) else {
            return Ok(Answer::failed("I am not holding a stick"));
        };
        self.let_be();
        let (tip, bare) = (self.actor.stick_tip(), self.actor.hands[hand].tip);
        // What the stick's tip felt was felt by that hand.
        self.mind.things.felt_by_another(|receptor| if Some(receptor) == tip { bare } else { receptor });
        self.actor.give_stick_back()?;
        self.stick_changed();
        Ok(Answer::done("I gave the stick back"))
    }

    /// Goes to where its hands wait with or without a stick, and reaches as far as it does now.
    fn stick_changed(&mut self) {
        self.reachable.take();
        self.ready = self.actor.ready();
        self.settle();
    }

    /// What he knows of a stick.
    fn stick_in_words(&self) -> String {
        let Some(stick) = self.actor.stick() else { return "I am not holding a stick".into() };
        let known = stick.known.map_or("I do not know it".to_string(), |known| {
            let [x, y, z]: [f64; 3] = known.tool.tip.into();
            format!("{} (at {x:.3},{y:.3},{z:.3} m in that hand's frame)", tip_in_words(&known))
        });
        format!("I hold the stick with my {}: {known}", self.hand_name(stick.hand))
    }

    /// Why something cannot be done with a stick in a hand; `None` if it can.
    pub(in super::super) fn barred_by_stick(&self, request: &Request) -> Option<String> {
        use Intent::{BringNear, Explore, FeelOver, FeelShape, Lift, PutAside, PutFar, Touch};
        let stick = self.actor.stick()?;
        let barred = match request.intent {
            Explore | FeelShape | FeelOver => true,
            Touch => request.any && self.mind.things.is_empty(),
            Lift if request.hand.is_none() => true,
            Lift | PutFar | BringNear | PutAside => self.hand_for(request.hand) == Some(stick.hand),
            _ => false,
        };
        let name = self.hand_name(stick.hand);
        barred.then(|| format!("The stick in my {name} is in the way: tell me to give it back first"))
    }
}

/// Where the tip is.
fn tip_in_words(known: &KnownStick) -> String {
    let within = 0.1 * (1e4 * known.within).ceil();
    format!("its tip is {} from where I hold it, known to {within:.1} mm", cm(known.length()))
}
