//! Sentences about where things are, what the creature did, and what went wrong.

use nalgebra::Vector3;
use serde_json::json;

use super::grammar::Request;
use super::mind::Deed;
use super::requests::{self, Answer, Intent};
use super::{Conversation, Reply};
use crate::geometry::{ConvexBody, Precision, gap};
use crate::interaction::actor::Actor;
use crate::interaction::tasks::Trouble;
use crate::interaction::things::KnownThing;
use crate::named::in_words;

/// A length as it is told; how far away what touches is, is nothing.
pub(super) fn cm(metres: f64) -> String {
    format!("{:.0} cm", 100.0 * metres.max(0.0))
}

/// Where a point is along an axis, by the words for either way, with what follows them; `None` if it is nearer than `least`.
fn along(metres: f64, least: f64, [ahead, behind]: [&str; 2], of: &str) -> Option<String> {
    let way = if metres < 0.0 { behind } else { ahead };
    (metres.abs() >= least).then(|| format!("{} {way}{of}", cm(metres.abs())))
}

/// Where a point of the root's frame is, in words.
pub(super) fn place_in_words(actor: &Actor, at: &Vector3<f64>) -> String {
    let side = along(at.dot(&actor.left()), 0.05, ["to my left", "to my right"], "");
    let side = side.unwrap_or("straight ahead".into());
    format!("{:.0} cm in front of me, {side}", 100.0 * at.dot(&actor.front))
}

/// Words with a capital letter first.
pub(super) fn sentence(said: &str) -> String {
    let mut letters = said.chars();
    letters.next().map_or(String::new(), |first| first.to_uppercase().chain(letters).collect())
}

/// Something with a name and what it takes up in the root's frame.
pub(super) struct Placed<'a> {
    pub name: String,
    pub extent: Vec<Box<dyn ConvexBody + 'a>>,
}

impl Conversation {
    pub(super) fn reply(&self, intent: Intent, answer: Answer) -> Reply {
        let Answer { said, done, asks } = answer;
        let said = if said.ends_with(['.', '?', '!']) { said } else { format!("{said}.") };
        let felt = |known: &KnownThing| {
            let receptor = &self.actor.own.skin().receptors[known.found.receptor];
            json!({
                "thing": known.found.thing,
                "felt_by": self.actor.own.creature().limbs()[receptor.limb],
                "receptor": receptor.id,
                "at": known.at.as_slice(),
                "in_touch": known.in_touch.is_some(),
            })
        };
        Reply { intent, said, done, asks, felt: self.mind.things.iter().map(felt).collect() }
    }

    /// What a hand is called.
    pub(super) fn hand_name(&self, hand: usize) -> String {
        in_words(&self.actor.hands[hand].name)
    }

    /// What went wrong, in words.
    pub(super) fn in_words(&self, trouble: &Trouble) -> String {
        match trouble {
            Trouble::Hit(contacts) if !contacts.is_empty() => {
                format!("I ran into something with my {}", self.limb_in_words(contacts[0].spot.receptor))
            }
            trouble => trouble.to_string(),
        }
    }

    /// The limb that a receptor is on, as it says it.
    pub(super) fn limb_in_words(&self, receptor: usize) -> String {
        if self.actor.stick_tip() == Some(receptor) {
            return "stick".into();
        }
        let creature = self.actor.own.creature();
        let limb = self.actor.own.skin().receptors[receptor].limb;
        let aura = creature.aura_of(limb).map(|aura| &creature.aura_limbs()[aura].name);
        in_words(aura.unwrap_or(&creature.limbs()[limb]))
    }

    /// What it says where it does not know its body well enough; `None` if it does.
    pub(super) fn doubt(&self) -> Option<String> {
        let actor = &self.actor;
        let [a, b] = actor.hands.each_ref().map(|hand| actor.own.place(hand.tip));
        let doubt = actor.own.trusts(&actor.posture(), [a.limb, b.limb], &a.point).err()?;
        Some(format!("I do not know my body well enough for this: {doubt}. I should babble more first"))
    }

    /// Where a thing is, in words.
    pub(super) fn place(&self, at: &Vector3<f64>) -> String {
        place_in_words(&self.actor, at)
    }

    /// Where a part of its own body is, in words: against the middle of the limb that carries all others.
    pub(super) fn place_of_own(&self, at: &Vector3<f64>) -> String {
        let (actor, root) = (&self.actor, in_words(&self.actor.own.creature().limbs()[0]));
        let ways = [
            along(at.dot(&actor.front), 0.0, ["in front of", "behind"], &format!(" my {root}")),
            along(at.dot(&actor.left()), 0.01, ["to my left", "to my right"], "")
                .or(Some("in the middle".into())),
            along(at.dot(&actor.up), 0.0, ["above", "below"], " it"),
        ];
        ways.map(Option::unwrap_or_default).join(", ")
    }

    /// How far something is from something else where they are nearest to each other, and which way, in words.
    pub(super) fn relation_in_words(&self, [what, to]: [&Placed<'_>; 2]) -> Option<String> {
        let pair = |a| to.extent.iter().map(move |b| gap(a, &**b, Precision::Exact));
        let pairs = what.extent.iter().flat_map(|a| pair(&**a));
        let nearest = pairs.min_by(|a, b| a.distance.total_cmp(&b.distance))?;
        let way = nearest.points[0] - nearest.points[1];
        let ways = [
            (self.actor.front, ["in front of", "behind"]),
            (self.actor.left(), ["to the left of", "to the right of"]),
            (self.actor.up, ["above", "below"]),
        ];
        let ways = ways.map(|(axis, words)| along(way.dot(&axis), 0.005, words, " it"));
        let ways: Vec<String> = ways.into_iter().flatten().collect();
        let said = format!("{} is {} from {}", what.name, cm(nearest.distance), to.name);
        Some(if ways.is_empty() { said } else { format!("{said}: {}", ways.join(", ")) })
    }

    /// Takes down what it did.
    pub(super) fn did(&mut self, request: &Request, reply: &Reply) {
        let Some(done) = reply.done else { return };
        let intent = request.intent;
        let [doing, did] = requests::doing(intent, request.part.as_ref());
        let touching = self.mind.things.iter().find(|known| known.in_touch.is_some());
        let touched = touching.is_some();
        let words = match (intent, done, self.mind.things.it()) {
            (Intent::Explore, ..) => match touching.filter(|_| done) {
                Some(known) => format!("felt around and found something {}", self.place(&known.at)),
                None => "felt around and found nothing new".to_string(),
            },
            (_, false, _) => format!("tried to {doing}, but could not"),
            (Intent::Touch, true, _) => {
                let hand = self.hand_touching().map(|hand| self.hand_name(hand));
                hand.map_or(did, |hand| format!("touched it with my {hand}"))
            }
            (Intent::PutFar | Intent::BringNear | Intent::PutAside, true, Some(known)) => {
                format!("{did}: it is {}", self.place(&known.at))
            }
            _ => did,
        };
        self.mind.deeds.push(Deed { intent, done, touched, words });
    }
}
