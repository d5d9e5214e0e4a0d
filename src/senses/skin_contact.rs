//! What touches the skin in one step, and where.

use nalgebra::Vector3;

/// A place on the skin that something touches.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SkinSpot {
    /// The limb.
    pub limb: usize,
    /// The receptor that holds the point.
    pub receptor: usize,
    /// The point in the limb's frame, metres.
    pub point: Vector3<f64>,
    /// What the receptor's own `touch` sensor tells, newtons: all that presses on it in this step, by MuJoCo's own rule
    /// of what presses on a site. None where the receptor has no such sensor, or no forces were computed.
    pub sensor_force: Option<f64>,
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

/// Who touches: what touches the skin, wherever it is touched.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Party {
    /// The creature itself.
    Own,
    /// A thing, told from others by a number.
    Thing(usize),
    /// A thing that a held one meets.
    Through(usize),
}

impl Party {
    /// The number of the thing; none where the creature touches itself.
    pub fn thing(self) -> Option<usize> {
        match self {
            Party::Own => None,
            Party::Thing(thing) | Party::Through(thing) => Some(thing),
        }
    }
}

impl Toucher {
    /// Who it is.
    pub fn party(&self) -> Party {
        match *self {
            Toucher::Own(_) => Party::Own,
            Toucher::Thing(thing) => Party::Thing(thing),
            Toucher::Through(thing) => Party::Through(thing),
        }
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
#[derive(Clone, Debug, PartialEq)]
pub struct SkinContact {
    /// The place on the skin; the one on the earlier limb of a self-touch.
    pub spot: SkinSpot,
    /// What touches it.
    pub by: Toucher,
    /// Normal force, newtons.
    pub force: f64,
}

impl SkinContact {
    /// Its places on the skin: one, or the two of a self-touch.
    pub fn spots(&self) -> impl Iterator<Item = SkinSpot> {
        std::iter::once(self.spot).chain(self.by.own())
    }

    /// Who touches which limb, and with which of its own in a self-touch.
    pub fn parties(&self) -> (usize, Party, Option<usize>) {
        (self.spot.limb, self.by.party(), self.by.own().map(|spot| spot.limb))
    }

    /// The contact as each of its places feels it: a self-touch is felt twice.
    pub fn felt(&self) -> impl Iterator<Item = (SkinSpot, Toucher)> {
        let back = self.by.own().map(|other| (other, Toucher::Own(self.spot)));
        std::iter::once((self.spot, self.by)).chain(back)
    }
}
