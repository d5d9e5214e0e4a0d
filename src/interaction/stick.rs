//! A stick in a hand: what the hand feels through it, and what is known about it.
//!
//! The hand that holds a stick feels it pressed against something, at the receptor that holds it; where it touches is not
//! told. Skin of his own that the stick touches feels a thing in the same moment. From such touches of himself he learns
//! where the tip is (`tasks/wielding.rs`), and from then on the stick is a part of him: the tip is the last receptor of
//! his body, and what is felt through the stick is felt there.

use nalgebra::Vector3;

use crate::error::Result;
use crate::geometry::Ball;
use crate::interaction::actor::{Actor, Hand};
use crate::interaction::tasks::Trouble;
use crate::learning::Tool;
use crate::learning::touch_set::PreparedTouch;
use crate::peripersonal::{CollisionChecker, OwnBody};
use crate::senses::{SkinContact, SkinSpot, Toucher};

/// A stick that is held.
pub struct HeldStick {
    /// The hand, an index into [`Actor::hands`].
    pub hand: usize,
    /// The receptor that holds it.
    pub receptor: usize,
    /// The number that other skin feels it as.
    pub(super) thing: usize,
    /// What is known of it; none before that has been learned.
    pub known: Option<KnownStick>,
    /// The body without it, and its surfaces.
    pub(super) bare: Box<(OwnBody, CollisionChecker)>,
    /// How he touched himself with it.
    pub(super) touches: Vec<PreparedTouch>,
}

/// What was learned of a stick.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct KnownStick {
    /// Where its tip is in the hand's frame, where its axis leaves the hand, and its radius, metres.
    pub tool: Tool,
    /// How far off the tip may be, at 95 %, metres.
    pub within: f64,
    /// The touches of his own skin that this is known from …
    pub touches: usize,
    /// … and those of them that were the tip's.
    pub by_tip: usize,
}

impl HeldStick {
    /// Whether a contact is of the hand that holds it, and of what the stick presses on.
    fn presses(&self, contact: &SkinContact) -> bool {
        matches!(contact.by, Toucher::Through(_)) && contact.spot.receptor == self.receptor
    }

    /// Whether a contact is of other skin, which the stick touches.
    fn touches(&self, contact: &SkinContact) -> bool {
        contact.by == Toucher::Thing(self.thing)
    }
}

impl KnownStick {
    /// How far the tip is from where the stick leaves the hand, its round end included, metres.
    pub fn length(&self) -> f64 {
        (self.tool.tip - self.tool.grip).norm() + self.tool.radius
    }
}

impl Actor {
    /// The stick that is held.
    pub fn stick(&self) -> Option<&HeldStick> {
        self.stick.as_ref()
    }

    /// The receptor at the tip of a stick that is held and known.
    pub fn stick_tip(&self) -> Option<usize> {
        self.stick.as_ref()?.known.map(|_| self.own.skin().receptors.len() - 1)
    }

    /// The body without a stick that it holds.
    pub fn bare(&self) -> &OwnBody {
        self.stick.as_ref().map_or(&self.own, |stick| &stick.bare.0)
    }

    /// How far a point of the root's frame is from a stick that is held and known, metres.
    pub fn from_stick(&self, point: &Vector3<f64>) -> Option<f64> {
        let tool = self.stick.as_ref()?.known?.tool;
        let stick = tool.capsule().placed(&self.frames()[tool.limb]);
        Some(stick.distance_to(&Ball { centre: *point, radius: 0.0 }))
    }

    /// Holds out a hand for a stick, at the receptor in the middle of its skin; whether one was put there.
    ///
    /// # Errors
    /// Where the engine fails.
    pub fn take_stick(&mut self, hand: usize) -> Result<bool> {
        if self.stick.is_some() {
            return Ok(false);
        }
        let receptor = self.grip_of(hand);
        let thing = self.handle.take_stick(receptor)?;
        thing.into_iter().for_each(|thing| self.was_given_stick(hand, receptor, thing));
        Ok(thing.is_some())
    }

    /// The receptor of a hand that would hold a stick: that nearest to the middle of the hand's own skin.
    pub fn grip_of(&self, hand: usize) -> usize {
        let Hand { limb, tip, .. } = self.hands[hand];
        let receptors = self.own.receptors_on(&[limb]);
        let at = |receptor: usize| self.own.skin().receptors[receptor].position;
        let middle = receptors.iter().map(|&r| at(r)).sum::<Vector3<f64>>() / receptors.len() as f64;
        let away = |receptor: usize| (at(receptor) - middle).norm();
        receptors.into_iter().min_by(|&a, &b| away(a).total_cmp(&away(b))).unwrap_or(tip)
    }

    /// Has been given a stick by a partner, who put it to a receptor of a hand; other skin feels it as that number.
    pub fn was_given_stick(&mut self, hand: usize, receptor: usize, thing: usize) {
        let bare = Box::new((self.own.clone(), self.clearance.clone()));
        self.stick = Some(HeldStick { hand, receptor, thing, known: None, bare, touches: Vec::new() });
    }

    /// Takes a stick that is held for known: its tip is a part of the body from now on.
    pub fn know_stick(&mut self, known: KnownStick) {
        let Some(stick) = self.stick.as_mut() else { return };
        let (own, clearance) = stick.bare.as_ref();
        let Some(holding) = own.holding(&known.tool) else { return };
        let holds = clearance.holding(own, &known.tool);
        let before = std::mem::replace(&mut self.clearance, holds);
        self.clearance.obstacles = before.obstacles;
        self.own = holding;
        stick.known = Some(known);
    }

    /// Gives the stick back; the body is as it was without.
    ///
    /// # Errors
    /// Where the engine fails.
    pub fn give_stick_back(&mut self) -> Result<()> {
        self.handle.give_stick_back()?;
        if let Some(stick) = self.stick.take() {
            let (own, clearance) = *stick.bare;
            let with_it = std::mem::replace(&mut self.clearance, clearance);
            self.clearance.obstacles = with_it.obstacles;
            self.own = own;
        }
        Ok(())
    }

    /// What is felt, as who holds a stick understands it: what presses on the stick touches its tip, and where his own skin
    /// feels the stick in that moment, he touches himself. Before the tip is known it is felt as it is.
    pub(super) fn understood(&self, felt: Vec<SkinContact>) -> Vec<SkinContact> {
        let (Some(stick), Some(receptor)) = (&self.stick, self.stick_tip()) else { return felt };
        let tip = SkinSpot { limb: self.own.skin().receptors[receptor].limb, receptor };
        let own = felt.iter().any(|contact| stick.touches(contact));
        let understood = felt.into_iter().filter_map(|contact| match contact.by {
            Toucher::Thing(_) if stick.touches(&contact) => {
                Some(SkinContact { by: Toucher::Own(tip), ..contact })
            }
            // Felt on both sides: told above.
            Toucher::Through(_) if stick.presses(&contact) && own => None,
            Toucher::Through(thing) if stick.presses(&contact) => {
                Some(SkinContact { spot: tip, by: Toucher::Thing(thing), ..contact })
            }
            _ => Some(contact),
        });
        understood.collect()
    }

    /// Whether a contact is one of the stick that he holds.
    pub(super) fn is_of_stick(&self, contact: &SkinContact) -> bool {
        self.stick.as_ref().is_some_and(|stick| stick.touches(contact) || stick.presses(contact))
    }

    /// The receptor of his own that a stick which is not known yet touches, and nothing else: where the hand and other skin
    /// feel it in the same moment.
    pub(super) fn touches_by_stick(&self, felt: &[SkinContact]) -> Option<usize> {
        let stick = self.stick.as_ref()?;
        let pressed = felt.iter().any(|contact| stick.presses(contact));
        let mut touched = felt.iter().filter(|contact| stick.touches(contact));
        let (only, None) = (touched.next()?, touched.next()) else { return None };
        pressed.then_some(only.spot.receptor)
    }

    /// Touches something with the tip of the stick in place of the hand that holds it, which `touch` is given.
    ///
    /// # Errors
    /// [`Trouble`]; [`Trouble::Nothing`] if no stick is known.
    pub fn with_stick<T>(
        &mut self,
        touch: impl FnOnce(&mut Actor, usize) -> Result<T, Trouble>,
    ) -> Result<T, Trouble> {
        let held = self.stick_tip().zip(self.stick.as_ref().map(|stick| stick.hand));
        let (tip, hand) = held.ok_or(Trouble::Nothing)?;
        let with_tip = Hand { receptors: vec![tip], tip, ..self.hands[hand].clone() };
        let without = std::mem::replace(&mut self.hands[hand], with_tip);
        let touched = touch(self, hand);
        self.hands[hand] = without;
        touched
    }
}
