//! Contacts on the skin in one step, and their positions.

/// A place on the skin that something touches, as exactly as the skin feels it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SkinSpot {
    /// The limb.
    pub limb: usize,
    /// The receptor that fires.
    pub receptor: usize,
}

/// What touches the skin.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Toucher {
    /// The creature itself, with another place of its skin.
    Own(SkinSpot),
    /// A thing, told from others by a number.
    Thing(usize),
    /// A thing that the one held there meets.
    Through(usize),
}

impl Toucher {
    /// The number of the thing; `None` if the creature touches itself.
    pub fn thing(&self) -> Option<usize> {
        match *self {
            Toucher::Own(_) => None,
            Toucher::Thing(thing) | Toucher::Through(thing) => Some(thing),
        }
    }

    /// Whether it is the same party as another, wherever on the skin: the creature itself, or one thing in one way.
    pub fn is_party_of(&self, other: &Toucher) -> bool {
        self == other || self.own().and(other.own()).is_some()
    }

    /// The place of the creature's skin that touches, where it touches itself.
    pub fn own(&self) -> Option<SkinSpot> {
        match *self {
            Toucher::Own(spot) => Some(spot),
            Toucher::Thing(_) | Toucher::Through(_) => None,
        }
    }
}

/// A contact with the skin in one step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SkinContact {
    /// The place on the skin; the one on the earlier limb of a self-touch.
    pub spot: SkinSpot,
    /// What touches it.
    pub by: Toucher,
    /// What the receptor's own `touch` sensor reads, newtons: all that presses on it. If no sensor reads the contact, its
    /// normal force.
    pub force: f64,
}

impl SkinContact {
    /// Its places on the skin: one, or the two of a self-touch.
    pub fn spots(&self) -> impl Iterator<Item = SkinSpot> {
        std::iter::once(self.spot).chain(self.by.own())
    }

    /// Whether the same party touches the same limb as in another, and with the same of its own in a self-touch.
    pub fn has_parties_of(&self, other: &SkinContact) -> bool {
        self.by.is_party_of(&other.by)
            && self.spots().map(|spot| spot.limb).eq(other.spots().map(|spot| spot.limb))
    }

    /// Contacts of one party as one: that which presses most, of several the first, with the sum of their forces.
    pub(super) fn fused(contacts: &[SkinContact]) -> SkinContact {
        let force = contacts.iter().map(|contact| contact.force).sum();
        let strongest = contacts.iter().copied().reduce(|a, b| if b.force > a.force { b } else { a });
        SkinContact { force, ..strongest.expect("there is a contact") }
    }

    /// The same from the other side of a self-touch; any other as it is.
    pub fn turned(&self) -> SkinContact {
        match self.by {
            Toucher::Own(own) => SkinContact { spot: own, by: Toucher::Own(self.spot), force: self.force },
            Toucher::Thing(_) | Toucher::Through(_) => *self,
        }
    }

    /// The contact as each of its places feels it: a self-touch is felt twice.
    pub fn felt(&self) -> impl Iterator<Item = (SkinSpot, Toucher)> {
        let back = self.by.own().map(|other| (other, Toucher::Own(self.spot)));
        std::iter::once((self.spot, self.by)).chain(back)
    }
}
