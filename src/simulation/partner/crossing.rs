//! Strokes that go over joints, from one limb to the next.

use nalgebra::Vector3;
use rand::seq::IndexedRandom;
use rand_chacha::ChaCha8Rng;

use super::stimulation::{STEP, SkinPoint, Stimulation, Strokes, laid};
use crate::senses::TouchKind;

/// How long the way is on the first limb and on the last one at the least, metres: it begins on the one, and ends on the
/// other.
const ON_EITHER: f64 = 0.015;
/// The farthest that a way goes, metres, and from end to end in a straight line.
const FARTHEST: f64 = 0.5;
/// Ways that are tried.
const WAYS: usize = 500;

impl Strokes<'_> {
    /// A random stroke over so many joints, setting out at `time`: a row of limbs that follow each other is drawn, then a
    /// place on its first and one on its last limb; the way goes towards the latter over the skin. None where no row has
    /// room for it.
    pub fn across(&self, joints: usize, time: f64, rng: &mut ChaCha8Rng) -> Option<Stimulation> {
        let rows = self.rows(joints + 1);
        (0..WAYS).find_map(|_| {
            let row = rows.choose(rng)?;
            let [from, to] = [row[0], row[joints]].map(|limb| {
                let receptor = *self.receptors_on(limb).choose(rng)?;
                Some(self.frames[limb].point(&self.place_on(receptor, 1.0, rng)))
            });
            let way = self.towards(row, &from?, &to?)?;
            Some(laid(TouchKind::Stroke, &way, time, rng))
        })
    }

    /// All rows of so many limbs with skin, each joined to the next.
    fn rows(&self, length: usize) -> Vec<Vec<usize>> {
        let has_skin = |limb: &usize| !self.receptors_on(*limb).is_empty();
        let mut rows: Vec<Vec<usize>> =
            (0..self.frames.len()).filter(has_skin).map(|limb| vec![limb]).collect();
        for _ in 1..length {
            let longer = |row: &Vec<usize>| {
                let next = self.joined(row[row.len() - 1]).into_iter().filter(has_skin);
                let next: Vec<usize> = next.filter(|limb| !row.contains(limb)).collect();
                next.into_iter().map(|limb| [&row[..], &[limb]].concat()).collect::<Vec<_>>()
            };
            rows = rows.iter().flat_map(longer).collect();
        }
        rows
    }

    /// A way over the skin of a row of limbs from a place on the first one towards a place on the last one, straight
    /// ahead as far as the skin has it. None where it does not get there, or comes near another limb.
    fn towards(&self, row: &[usize], from: &Vector3<f64>, to: &Vector3<f64>) -> Option<Vec<SkinPoint>> {
        let last = row[row.len() - 1];
        let [start, end] = [self.onto(row, from)?, self.onto(row, to)?];
        if start.limb != row[0] || end.limb != last || (end.middle - start.middle).norm() > FARTHEST {
            return None;
        }
        let mut way = vec![start];
        while (end.middle - way[way.len() - 1].middle).norm() > 1.5 * STEP {
            let spot = way[way.len() - 1];
            way.push(self.next(row, &spot, &spot.along(&(end.middle - spot.middle))?)?);
            if way.len() as f64 * STEP > FARTHEST {
                return None;
            }
        }
        let mut limbs: Vec<usize> = way.iter().map(|spot| spot.limb).collect();
        limbs.dedup();
        let long_enough = [row[0], last]
            .iter()
            .all(|&limb| way.iter().filter(|spot| spot.limb == limb).count() as f64 * STEP >= ON_EITHER);
        let ends_are_free = || [0, way.len() - 1].iter().all(|&k| self.is_free(&[way[k].limb], &way[k..=k]));
        (limbs == row && long_enough && ends_are_free() && self.is_free(row, &way) && self.is_felt(&way))
            .then_some(way)
    }
}
