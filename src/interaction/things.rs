//! What a creature remembers of the things that it felt, and which of them is meant.

use nalgebra::Vector3;

use super::actor::FoundThing;
use crate::peripersonal::FeltSize;

/// Two things felt nearer than this to each other are one, metres.
const SAME: f64 = 0.09;
/// How far into a thing the place is that is remembered of it, from where it was felt, metres.
const INTO: f64 = 0.02;
/// Places at which a thing was felt that are nearer than this to each other are one, metres: a small patch of skin.
const ONE_PLACE: f64 = 0.01;

/// Names a thing that it remembers, whatever else is forgotten meanwhile; no other thing is ever named so.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ThingId(usize);

/// What it remembers of a thing.
#[derive(Clone, Debug, PartialEq)]
pub struct KnownThing {
    /// Its name among all that it remembers.
    pub id: ThingId,
    /// How it was felt the last time.
    pub found: FoundThing,
    /// Where it is, in the root's frame, metres.
    pub at: Vector3<f64>,
    /// The receptor that touches it, while one does.
    pub in_touch: Option<usize>,
    /// Where it was touched, in the root's frame, metres.
    pub places: Vec<Vector3<f64>>,
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
    /// It was felt anew, and may still be: the same thing keeps its shape.
    fn felt(&mut self, found: &FoundThing, at: Vector3<f64>, in_touch: Option<usize>) {
        if self.found.thing != found.thing {
            self.shape = None;
            self.places.clear();
        }
        let new = |place: &Vector3<f64>| (found.point - place).norm() > ONE_PLACE;
        if in_touch.is_some() && self.places.iter().all(new) {
            self.places.push(found.point);
        }
        (self.found, self.at, self.in_touch) = (found.clone(), at, in_touch);
    }

    /// It was carried by so much, in the root's frame, metres, and let go.
    pub fn carried(&mut self, by: &Vector3<f64>) {
        self.at += by;
        self.found.point += by;
        self.places.iter_mut().for_each(|place| *place += by);
        self.in_touch = None;
    }
}

/// Where a thing is taken to be by how it was felt, in the root's frame, metres.
fn place_of(found: &FoundThing) -> Vector3<f64> {
    found.point + found.direction * INTO
}

/// The things that it remembers, in the order in which it felt them first.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Things {
    known: Vec<KnownThing>,
    /// Which of them "it" is.
    it: Option<ThingId>,
    /// How many it has ever felt.
    named: usize,
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

    /// The same, to change what is remembered of them.
    pub fn iter_mut(&mut self) -> std::slice::IterMut<'_, KnownThing> {
        self.known.iter_mut()
    }

    /// A thing, unless it has been forgotten.
    pub fn get(&self, id: ThingId) -> Option<&KnownThing> {
        self.known.iter().find(|known| known.id == id)
    }

    /// The same, to change what is remembered of it.
    pub fn get_mut(&mut self, id: ThingId) -> Option<&mut KnownThing> {
        self.known.iter_mut().find(|known| known.id == id)
    }

    /// Remembers what was felt, and whether a receptor still touches it: as one that is known where that is near, as a
    /// new one elsewhere. Which.
    pub fn remember(&mut self, found: &FoundThing, in_touch: Option<usize>) -> ThingId {
        let at = place_of(found);
        match self.known.iter_mut().find(|other| (other.at - at).norm() < SAME) {
            Some(known) => {
                known.felt(found, at, in_touch);
                known.id
            }
            None => self.add(found.clone(), at, in_touch),
        }
    }

    fn add(&mut self, found: FoundThing, at: Vector3<f64>, in_touch: Option<usize>) -> ThingId {
        let id = ThingId(self.named);
        self.named += 1;
        let places = in_touch.iter().map(|_| found.point).collect();
        self.known.push(KnownThing { id, found, at, in_touch, places, shape: None });
        id
    }

    /// Takes over what a search felt: things that are known keep their order, new ones follow; what is known twice is one.
    /// What the search did not feel is forgotten where `gone` says that it would have felt it.
    pub fn take_over(&mut self, felt: &[(FoundThing, Vector3<f64>)], gone: impl Fn(&Vector3<f64>) -> bool) {
        let mut new: Vec<Option<&(FoundThing, Vector3<f64>)>> = felt.iter().map(Some).collect();
        self.known.retain_mut(|known| {
            let away = |(_, at): &(FoundThing, Vector3<f64>)| (at - known.at).norm();
            let nearest = felt.iter().zip(&mut new).min_by(|(a, _), (b, _)| away(a).total_cmp(&away(b)));
            match nearest.filter(|(felt, _)| away(felt) < SAME) {
                Some((_, new)) => new.take().is_some_and(|(found, at)| {
                    known.felt(found, *at, known.in_touch);
                    true
                }),
                None => !gone(&known.at),
            }
        });
        for (found, at) in new.into_iter().flatten() {
            self.add(found.clone(), *at, None);
        }
    }

    /// A thing was felt anew, by a receptor that touches it.
    pub fn felt_again(&mut self, id: ThingId, found: &FoundThing) {
        if let Some(known) = self.get_mut(id) {
            known.felt(found, place_of(found), Some(found.receptor));
        }
    }

    /// No receptor touches any of them.
    pub fn parted(&mut self) {
        self.known.iter_mut().for_each(|known| known.in_touch = None);
    }

    /// What one receptor felt is told of another from now on.
    pub(super) fn felt_by_another(&mut self, other: impl Fn(usize) -> usize) {
        for known in &mut self.known {
            known.found.receptor = other(known.found.receptor);
            known.in_touch = known.in_touch.map(&other);
        }
    }

    /// The thing that "it" is: the one that is meant, or the only one; `None` if there are several and none was named.
    pub fn it(&self) -> Option<&KnownThing> {
        match (self.it.and_then(|it| self.get(it)), self.known.as_slice()) {
            (None, [only]) => Some(only),
            (it, _) => it,
        }
    }

    /// From now on this one is meant; or it is not known which.
    pub fn mean(&mut self, which: Option<ThingId>) {
        self.it = which;
    }

    /// The one for which a value is greatest.
    pub fn most(&self, value: impl Fn(&KnownThing) -> f64) -> Option<&KnownThing> {
        self.known.iter().max_by(|a, b| value(a).total_cmp(&value(b)))
    }

    /// Forgets a thing; "it" is then no longer that one.
    pub fn forget(&mut self, id: ThingId) {
        self.known.retain(|known| known.id != id);
    }

    /// Forgets all things.
    pub fn forget_all(&mut self) {
        self.known.clear();
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
            sharp: false,
        }
    }

    #[test]
    fn what_is_felt_near_a_known_thing_is_that_thing() {
        let mut things = Things::default();
        let first = things.remember(&felt_at(0.4), None);
        assert_eq!(things.it().map(|known| known.id), Some(first), "the only one");
        assert_ne!(things.remember(&felt_at(0.6), Some(3)), first);
        assert_eq!(things.it(), None, "one of two");
        assert_eq!(things.remember(&felt_at(0.43), Some(3)), first);
        assert_eq!(things.len(), 2);
        let known = things.get(first).unwrap();
        assert!((known.at.x - 0.45).abs() < 1e-12 && known.in_touch == Some(3));
    }

    #[test]
    fn it_stays_the_same_thing_when_another_is_forgotten_and_is_none_once_it_is_forgotten_itself() {
        let mut things = Things::default();
        let ids = [0.2, 0.4, 0.6].map(|x| things.remember(&felt_at(x), None));
        things.mean(Some(ids[2]));
        things.forget(ids[0]);
        assert_eq!(things.it().map(|known| known.id), Some(ids[2]));
        things.forget(ids[2]);
        things.felt_again(ids[2], &felt_at(0.6));
        assert_eq!((things.get(ids[2]), things.len()), (None, 1), "and does not come back as another");
        things.remember(&felt_at(0.8), None);
        assert_eq!(things.it(), None);
    }

    #[test]
    fn a_search_keeps_what_it_felt_again_and_forgets_what_is_gone_and_what_was_known_twice() {
        let mut things = Things::default();
        let ids = [0.2, 0.4, 0.6].map(|x| things.remember(&felt_at(x), None));
        things.get_mut(ids[1]).unwrap().at.x = 0.21;
        let felt = [0.2, 0.9].map(|x| (felt_at(x), Vector3::new(x, 0.0, 0.0)));
        things.take_over(&felt, |at| at.x > 0.5);
        let at: Vec<f64> = things.iter().map(|known| known.at.x).collect();
        assert_eq!((at, things.iter().next().unwrap().id), (vec![0.2, 0.9], ids[0]));
    }
}
