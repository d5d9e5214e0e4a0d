//! Ways through postures that keep clear, by the schema: two trees that grow towards each other (RRT-Connect, Kuffner
//! and LaValle 2000), then shortened.

use crate::creature::Posture;
use rand::{Rng, RngExt};

use super::collision::CollisionChecker;
use super::own_body::OwnBody;

/// The farthest that a coordinate goes between two postures that are looked at, radians (or metres times three).
const FINE: f64 = 0.02;
/// The longest branch of a tree, in the same measure.
const BRANCH: f64 = 0.3;
/// Most branches tried.
const MOST: usize = 1500;
/// Shortcuts tried.
const SHORTCUTS: usize = 40;

/// Postures to go through, straight from each to the next; the first is where one is.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PosturePath(pub Vec<Posture>);

impl PosturePath {
    /// A way on from a posture in so many steps, each found by its number and the posture before, the first by 1; it ends
    /// where there is no next one.
    pub fn stepwise(
        from: &[f64],
        steps: usize,
        next: impl Fn(usize, &[f64]) -> Option<Posture>,
    ) -> PosturePath {
        let mut way = vec![Posture::from(from)];
        for k in 1..=steps {
            let Some(posture) = next(k, &way[way.len() - 1]) else { break };
            way.push(posture);
        }
        PosturePath(way)
    }

    /// Its end; none for a way of no posture.
    pub fn end(&self) -> Option<&[f64]> {
        self.0.last().map(|posture| &posture[..])
    }
}

/// How far apart two postures are: the greatest difference of a coordinate.
pub fn distance(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(x, y)| (x - y).abs()).fold(0.0, f64::max)
}

/// Whether all postures straight between two keep clear by `margin`; the first is not looked at.
pub fn straight(own: &OwnBody, clearance: &CollisionChecker, from: &[f64], to: &[f64], margin: f64) -> bool {
    let steps = (distance(from, to) / FINE).ceil().max(1.0) as usize;
    // The far end is the likeliest to be refused, then the middle.
    let free = |k: usize| {
        let posture = Posture::between(own.creature(), from, to, k as f64 / steps as f64);
        clearance.free(&own.frames(&posture), margin)
    };
    free(steps) && (1..steps).all(free)
}

/// A way from one posture to another that moves only `joints` and keeps clear by `margin`; what is nearer at its ends
/// may be as near on the way. `None` if none is found.
pub fn find_path(
    own: &OwnBody,
    clearance: &CollisionChecker,
    [from, to]: [&[f64]; 2],
    joints: &[usize],
    margin: f64,
    rng: &mut impl Rng,
) -> Option<PosturePath> {
    let ends = [from, to].map(|posture| own.frames(posture));
    let clearance = &clearance.moved_by(own, joints).eased_at(&ends, margin);
    if straight(own, clearance, from, to, margin) {
        return Some(PosturePath(vec![Posture::from(from), Posture::from(to)]));
    }
    let mut trees = [vec![(Posture::from(from), 0)], vec![(Posture::from(to), 0)]];
    for tried in 0..MOST {
        let (grown, other) = (tried % 2, 1 - tried % 2);
        let target = own.random_posture(from, joints, rng);
        let Some(branch) = grow(own, clearance, &mut trees[grown], &target, margin) else { continue };
        let goal = trees[grown][branch].0.clone();
        // The other tree goes on towards it as far as it gets.
        let mut met = None;
        while let Some(leaf) = grow(own, clearance, &mut trees[other], &goal, margin) {
            if distance(&trees[other][leaf].0, &goal) < 1e-9 {
                met = Some(leaf);
                break;
            }
        }
        if let Some(leaf) = met {
            let mut halves = [trace(&trees[grown], branch), trace(&trees[other], leaf)];
            if grown == 1 {
                halves.swap(0, 1);
            }
            let [mut way, mut rest] = halves;
            way.reverse();
            way.append(&mut rest);
            shorten(own, clearance, &mut way, margin, rng);
            return Some(PosturePath(way));
        }
    }
    None
}

/// Grows a tree towards a posture by a branch; `None` if the way is barred or it is there already.
fn grow(
    own: &OwnBody,
    clearance: &CollisionChecker,
    tree: &mut Vec<(Posture, usize)>,
    target: &[f64],
    margin: f64,
) -> Option<usize> {
    let nearest = (0..tree.len())
        .min_by(|&i, &j| distance(&tree[i].0, target).total_cmp(&distance(&tree[j].0, target)))?;
    let far = distance(&tree[nearest].0, target);
    if far < 1e-9 {
        return None;
    }
    let reached = Posture::between(own.creature(), &tree[nearest].0, target, (BRANCH / far).min(1.0));
    if !straight(own, clearance, &tree[nearest].0, &reached, margin) {
        return None;
    }
    tree.push((reached, nearest));
    Some(tree.len() - 1)
}

/// From a branch back to the root of its tree.
fn trace(tree: &[(Posture, usize)], mut branch: usize) -> Vec<Posture> {
    let mut way = vec![tree[branch].0.clone()];
    while branch != 0 {
        branch = tree[branch].1;
        way.push(tree[branch].0.clone());
    }
    way
}

fn shorten(
    own: &OwnBody,
    clearance: &CollisionChecker,
    way: &mut Vec<Posture>,
    margin: f64,
    rng: &mut impl Rng,
) {
    way.dedup();
    for _ in 0..SHORTCUTS {
        if way.len() < 3 {
            return;
        }
        let i = rng.random_range(0..way.len() - 2);
        let j = rng.random_range(i + 2..way.len());
        if straight(own, clearance, &way[i], &way[j], margin) {
            way.drain(i + 1..j);
        }
    }
}
