//! How a creature says where things are, what it did, and what went wrong.

use nalgebra::Vector3;
use serde_json::{Value, json};

use super::grammar::Request;
use super::mind::{self, Deed};
use super::requests::{Answer, Intent};
use super::{Conversation, Reply};
use crate::geometry::{ConvexBody, Precision, gap};
use crate::interaction::tasks::Trouble;
use crate::interaction::things::KnownThing;
use crate::named::in_words;

/// Something with a name and what it takes up in the root's frame.
pub(super) struct Placed<'a> {
    pub name: String,
    pub extent: Vec<Box<dyn ConvexBody + 'a>>,
}

impl Conversation {
    pub(super) fn reply(&self, intent: Intent, answer: Answer) -> Reply {
        let Answer { said, done, asks } = answer;
        let said = if said.ends_with(['.', '?', '!']) { said } else { format!("{said}.") };
        let felt = self.things.iter().map(|known| self.known_json(known)).collect();
        Reply { intent, said, done, asks, felt }
    }

    /// What a hand is called.
    pub(super) fn hand_name(&self, hand: usize) -> String {
        in_words(&self.actor.hands[hand].name)
    }

    fn known_json(&self, known: &KnownThing) -> Value {
        let receptor = &self.actor.own.skin().receptors[known.found.receptor];
        json!({
            "thing": known.found.thing,
            "felt_by": self.actor.own.creature().limbs()[receptor.limb],
            "receptor": receptor.id,
            "at": known.at.as_slice(),
            "in_touch": known.in_touch.is_some(),
        })
    }

    /// What went wrong, in words.
    pub(super) fn in_words(&self, trouble: &Trouble) -> String {
        match trouble {
            Trouble::Hit(contacts) => contacts.first().map_or(trouble.to_string(), |contact| {
                format!("I ran into something with my {}", self.limb_in_words(contact.spot.receptor))
            }),
            trouble => trouble.to_string(),
        }
    }

    /// The limb that a receptor is on, as it says it.
    pub(super) fn limb_in_words(&self, receptor: usize) -> String {
        if self.actor.stick_tip() == Some(receptor) {
            return "stick".into();
        }
        let own = &self.actor.own;
        let limb = own.skin().receptors[receptor].limb;
        let aura = own.creature().aura_of(limb).map(|aura| own.creature().aura_limbs()[aura].name.clone());
        in_words(&aura.unwrap_or_else(|| own.creature().limbs()[limb].clone()))
    }

    /// What it says where it does not know its body well enough; none where it does.
    pub(super) fn doubt(&self) -> Option<String> {
        let actor = &self.actor;
        let [a, b] = actor.hands.each_ref().map(|hand| actor.own.place(hand.tip));
        let posture = actor.posture();
        let doubt = actor.own.trusts(&posture, [a.limb, b.limb], &a.point).err()?;
        Some(format!(
            "I do not know my body well enough for this: {doubt}. I should babble and touch myself more first"
        ))
    }

    pub(super) fn question(&self) -> String {
        mind::question(&self.actor, &self.things)
    }

    /// Where a thing is, in words.
    pub(super) fn place(&self, at: &Vector3<f64>) -> String {
        mind::place_in_words(&self.actor, at)
    }

    /// Where a part of its own body is, in words: against the middle of the limb that carries all others.
    pub(super) fn place_of_own(&self, at: &Vector3<f64>) -> String {
        let actor = &self.actor;
        let cm = |metres: f64| format!("{:.0} cm", 100.0 * metres.abs());
        let (front, left, up) = (at.dot(&actor.front), at.dot(&actor.left()), at.dot(&actor.up));
        let root = in_words(&actor.own.creature().limbs()[0]);
        let along =
            if front < 0.0 { format!("{} behind", cm(front)) } else { format!("{} in front of", cm(front)) };
        let side = match left {
            x if x > 0.01 => format!("{} to my left", cm(x)),
            x if x < -0.01 => format!("{} to my right", cm(x)),
            _ => "in the middle".into(),
        };
        let height = if up < 0.0 { format!("{} below it", cm(up)) } else { format!("{} above it", cm(up)) };
        format!("{along} my {root}, {side}, {height}")
    }

    /// How far something is from something else where they are nearest to each other, and which way, in words.
    pub(super) fn relation_in_words(&self, [what, to]: [&Placed<'_>; 2]) -> Option<String> {
        let pair = |a| to.extent.iter().map(move |b| gap(a, &**b, Precision::Exact));
        let pairs = what.extent.iter().flat_map(|a| pair(&**a));
        let nearest = pairs.min_by(|a, b| a.distance.total_cmp(&b.distance))?;
        let way = nearest.points[0] - nearest.points[1];
        let along = |axis: Vector3<f64>, [ahead, behind]: [&str; 2]| {
            let cm = 100.0 * way.dot(&axis);
            let side = if cm > 0.0 { ahead } else { behind };
            (cm.abs() >= 0.5).then(|| format!("{:.0} cm {side} it", cm.abs()))
        };
        let ways = [
            along(self.actor.front, ["in front of", "behind"]),
            along(self.actor.left(), ["to the left of", "to the right of"]),
            along(self.actor.up, ["above", "below"]),
        ];
        let ways: Vec<String> = ways.into_iter().flatten().collect();
        let distance = format!("{:.0} cm", 100.0 * nearest.distance.max(0.0));
        let said = format!("{} is {distance} from {}", what.name, to.name);
        Some(if ways.is_empty() { said } else { format!("{said}: {}", ways.join(", ")) })
    }

    /// Takes down what it did.
    pub(super) fn did(&mut self, request: &Request, reply: &Reply) {
        let Some(done) = reply.done else { return };
        let intent = request.intent;
        let [doing, did] = intent.kind().map_or(["", ""], |kind| kind.doing);
        let it = self.things.it();
        let with = self.hand_touching().map(|hand| self.hand_name(hand));
        let words = match (intent, done) {
            (Intent::TouchOwn, _) => {
                let part = request.part.as_ref().map_or("self".to_string(), |part| part.text());
                if done {
                    format!("touched my {part}")
                } else {
                    format!("tried to touch my {part}, but could not")
                }
            }
            (Intent::Explore, _) => match self.things.iter().find(|known| known.in_touch.is_some()) {
                Some(known) if done => format!("felt about and found something {}", self.place(&known.at)),
                _ => "felt about and found nothing new".to_string(),
            },
            (_, false) => format!("tried to {doing}, but could not"),
            (Intent::Touch, true) => {
                with.map_or(did.to_string(), |hand| format!("touched it with my {hand}"))
            }
            (Intent::PutFar | Intent::BringNear | Intent::PutAside, true) => {
                it.map_or(did.to_string(), |known| format!("{did}: it is {}", self.place(&known.at)))
            }
            _ => did.to_string(),
        };
        let touched = self.things.iter().any(|known| known.in_touch.is_some());
        self.deeds.push(Deed { intent, done, touched, words });
    }
}
