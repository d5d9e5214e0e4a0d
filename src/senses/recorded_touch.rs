//! A touch as it is recorded: with the exact contact, which the agent does not feel.

use std::ops::{Deref, DerefMut};

use nalgebra::Vector3;

use super::{FeltPoint, Input, Touch};

/// Where and how deep two surfaces met exactly: what the engine computes or a recording measured. Evaluation, tests and
/// files have it; the agent's folders never name it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ExactContact {
    /// The point of contact in the frame of each end's limb, metres.
    pub points: [Vector3<f64>; 2],
    /// Standard deviation of each coordinate of these points, metres, where a recording gives it.
    pub deviations: [Option<f64>; 2],
    /// How deep the surfaces were in each other, metres. `None` if no forces were at work.
    pub depth: Option<f64>,
}

/// Skin that met skin: two receptors, and the exact contact, which only a record of the touch takes in.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Met {
    /// The receptors, the one on the earlier limb first.
    pub receptors: [usize; 2],
    /// The exact contact.
    pub exact_contact: ExactContact,
}

impl Met {
    /// Receptors that met, each at a point of its limb, without forces.
    pub(super) fn at(places: [(usize, Vector3<f64>); 2]) -> Met {
        let points = places.map(|(_, point)| point);
        let exact_contact = ExactContact { points, ..ExactContact::default() };
        Met { receptors: places.map(|(receptor, _)| receptor), exact_contact }
    }
}

/// A touch of the receptors alone, beside the exact contact that it was.
#[derive(Clone, Debug, PartialEq)]
pub struct RecordedTouch {
    touch: Touch,
    contact: ExactContact,
}

impl RecordedTouch {
    /// A touch and its contact.
    pub fn new(touch: Touch, contact: ExactContact) -> RecordedTouch {
        RecordedTouch { touch, contact }
    }

    /// The touch as an agent feels it through a kind of skin.
    pub fn felt(&self, input: Input) -> Touch {
        let mut touch = self.touch.clone();
        if input == Input::Contact {
            for (k, end) in touch.ends.iter_mut().enumerate() {
                let (position, deviation) = (self.contact.points[k], self.contact.deviations[k]);
                end.point = Some(FeltPoint { position, deviation });
            }
        }
        touch
    }

    /// The exact contact.
    pub fn exact_contact(&self) -> &ExactContact {
        &self.contact
    }

    /// The exact contact, to be changed.
    pub fn exact_contact_mut(&mut self) -> &mut ExactContact {
        &mut self.contact
    }
}

impl Deref for RecordedTouch {
    type Target = Touch;

    fn deref(&self) -> &Touch {
        &self.touch
    }
}

impl DerefMut for RecordedTouch {
    fn deref_mut(&mut self) -> &mut Touch {
        &mut self.touch
    }
}
