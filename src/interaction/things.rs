//! What a creature remembers of the things that it felt, and which of them is meant.

use std::ops::{Index, IndexMut};

use nalgebra::Vector3;

use super::actor::FoundThing;
use crate::peripersonal::FeltSize;

/// Two things felt nearer than this to each other are one, metres.
const SAME: f64 = 0.09;
/// How far into a thing the place is that is remembered of it, from where it was felt, metres.
const INTO: f64 = 0.02;

/// What it remembers of a thing.
#[derive(Clone, Debug, PartialEq)]
pub struct KnownThing {
    /// How it was felt the last time.
    pub found: FoundThing,
    /// Where it is, in the root's frame, metres.
    pub at: Vector3<f64>,
    /// The receptor that touches it, while one does.
    pub in_touch: Option<usize>,
    /// What was felt of its shape, where that was asked for.
    pub shape: Option<KnownShape>,
}

/// What it remembers of a thing's shape.
#[derive(Clone, Debug, PartialEq)]
pub struct KnownShape {
    /// How large it is.
    pub size: FeltSize,
    /// Touches that this is known from.
    pub touches: usize,
    /// The sides of it, in words, of which touches told little.
    pub unfelt: Vec<&'static str>,
}

impl KnownThing {
    /// A thing that was felt, and may still be.
    fn felt(found: &FoundThing, in_touch: Option<usize>) -> KnownThing {
        KnownThing { found: found.clone(), at: found.point + found.direction * INTO, in_touch, shape: None }
    }

    /// It was carried by so much, in the root's frame, metres, and let go.
    pub fn carried(&mut self, by: &Vector3<f64>) {
        self.at += by;
        self.found.point += by;
        self.in_touch = None;
    }
}

/// The things that it remembers, in the order in which it felt them first.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Things {
    known: Vec<KnownThing>,
    /// Which of them "it" is.
    it: Option<usize>,
}

impl Things {
    /// How many there are.
    pub fn len(&self) -> usize {
        self.known.len()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.known.is_empty()
    }

    /// All of them.
    pub fn iter(&self) -> std::slice::Iter<'_, KnownThing> {
        self.known.iter()
    }

    /// Remembers what was felt, and whether a receptor still touches it: as one that is known where that is near, as a
    /// new one elsewhere. Which.
    pub fn remember(&mut self, found: &FoundThing, in_touch: Option<usize>) -> usize {
        let felt = KnownThing::felt(found, in_touch);
        match self.known.iter().position(|other| (other.at - felt.at).norm() < SAME) {
            Some(i) => {
                self.replace(i, felt);
                i
            }
            None => {
                self.known.push(felt);
                self.known.len() - 1
            }
        }
    }

    /// Takes over what a search felt: things that are known keep their order, new ones follow; what is known twice is one.
    /// What the search did not feel is forgotten where `gone` says that it would have felt it.
    pub fn take_over(&mut self, felt: &[(FoundThing, Vector3<f64>)], gone: impl Fn(&Vector3<f64>) -> bool) {
        let mut taken = vec![false; felt.len()];
        let mut which = 0;
        while which < self.known.len() {
            let at = self.known[which].at;
            let away = |k: &usize| (felt[*k].1 - at).norm();
            let nearest = (0..felt.len()).min_by(|a, b| away(a).total_cmp(&away(b)));
            match nearest.filter(|k| away(k) < SAME) {
                Some(k) if !taken[k] => {
                    taken[k] = true;
                    let in_touch = self.known[which].in_touch;
                    let (found, at) = felt[k].clone();
                    self.replace(which, KnownThing { found, at, in_touch, shape: None });
                    which += 1;
                }
                None if !gone(&at) => which += 1,
                _ => self.forget(which),
            }
        }
        for ((found, at), _) in felt.iter().zip(&taken).filter(|(_, taken)| !**taken) {
            self.known.push(KnownThing { found: found.clone(), at: *at, in_touch: None, shape: None });
        }
    }

    /// A thing was felt anew, by a receptor that touches it.
    pub fn felt_again(&mut self, which: usize, found: &FoundThing) {
        self.replace(which, KnownThing::felt(found, Some(found.receptor)));
    }

    /// What was felt now counts for more, but the same thing has the same shape.
    fn replace(&mut self, which: usize, felt: KnownThing) {
        let known = &mut self.known[which];
        let shape = known.shape.take().filter(|_| known.found.thing == felt.found.thing);
        *known = KnownThing { shape, ..felt };
    }

    /// What one receptor felt is told of another from now on.
    pub(super) fn felt_by_another(&mut self, other: impl Fn(usize) -> usize) {
        for known in &mut self.known {
            known.found.receptor = other(known.found.receptor);
            known.in_touch = known.in_touch.map(&other);
        }
    }

    /// Which thing "it" is, where one is meant; not where there are several and none was named.
    pub fn it(&self) -> Option<usize> {
        self.it
    }

    /// From now on this one is meant; or it is not known which.
    pub fn mean(&mut self, which: Option<usize>) {
        self.it = which;
    }

    /// The one for which a value is greatest.
    pub fn most(&self, value: impl Fn(&KnownThing) -> f64) -> Option<usize> {
        (0..self.known.len()).max_by(|&i, &j| value(&self.known[i]).total_cmp(&value(&self.known[j])))
    }

    /// Forgets a thing; "it" is then no longer that one.
    pub fn forget(&mut self, which: usize) {
        if which < self.known.len() {
            self.known.remove(which);
            self.it = match self.it {
                Some(it) if it == which => None,
                Some(it) if it > which => Some(it - 1),
                it => it,
            };
        }
    }

    /// Forgets all things.
    pub fn forget_all(&mut self) {
        *self = Things::default();
    }
}

impl Index<usize> for Things {
    type Output = KnownThing;

    fn index(&self, which: usize) -> &KnownThing {
        &self.known[which]
    }
}

impl IndexMut<usize> for Things {
    fn index_mut(&mut self, which: usize) -> &mut KnownThing {
        &mut self.known[which]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::creature::Posture;

    fn felt_at(x: f64) -> FoundThing {
        let posture = Posture::from(&[0.0][..]);
        FoundThing {
            receptor: 3,
            thing: 1,
            posture,
            point: Vector3::new(x, 0.0, 0.0),
            direction: Vector3::x(),
        }
    }

    #[test]
    fn what_is_felt_near_a_known_thing_is_that_thing() {
        let mut things = Things::default();
        assert_eq!(things.remember(&felt_at(0.4), None), 0);
        assert_eq!(things.remember(&felt_at(0.6), Some(3)), 1);
        assert_eq!(things.remember(&felt_at(0.43), Some(3)), 0);
        assert_eq!(things.len(), 2);
        assert!((things[0].at.x - 0.45).abs() < 1e-12 && things[0].in_touch == Some(3));
    }

    #[test]
    fn it_stays_the_same_thing_when_another_is_forgotten() {
        let mut things = Things::default();
        for x in [0.2, 0.4, 0.6] {
            things.remember(&felt_at(x), None);
        }
        things.mean(Some(2));
        things.forget(0);
        assert_eq!(things.it(), Some(1));
        things.forget(1);
        assert_eq!((things.it(), things.len()), (None, 1));
    }
}
