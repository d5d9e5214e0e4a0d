//! The farthest that a place of the body gets: a [`PostureProgram`] begun from many postures, and anew from near the best.
//!
//! A trunk and an arm make many postures that nothing near betters. What a single start leads to may be a fifth short of
//! the farthest, but small changes of a good one lead to better ones (basin hopping, Wales and Doye 1997).

use rand::{Rng, RngExt};

use super::own_body::OwnBody;
use super::path::distance;
use super::posture_program::{PosedPlace, PostureProgram};
use crate::creature::Posture;

/// Steps of a first look from a start.
const FIRST_LOOK: usize = 25;
/// Rounds in which the best are begun from anew, …
const ROUNDS: usize = 3;
/// … so many of them, …
const BEST: usize = 3;
/// … from where their joints are these shares of the way to a random posture.
const CHANGES: [f64; 4] = [0.05, 0.12, 0.25, 0.4];
/// Postures that are told at most, …
const TOLD: usize = 8;
/// … which differ by this much, in radians.
const DIFFERENT: f64 = 0.1;

/// The postures in which a place is farthest, as a program has it, the farthest first; joints that do not move are as in
/// all `starts`. What is drawn is drawn by `rng`.
pub fn farthest_postures(
    own: &OwnBody,
    program: &PostureProgram,
    joints: &[usize],
    starts: &[Posture],
    rng: &mut impl Rng,
) -> Vec<PosedPlace> {
    let mut found: Vec<PosedPlace> =
        starts.iter().map(|start| program.solve_within(start, FIRST_LOOK)).collect();
    for _ in 0..ROUNDS {
        sort(&mut found, BEST);
        let mut hops = Vec::new();
        for best in &found {
            for share in CHANGES {
                // Some joints go far, others hardly.
                let other = own.random_posture(&best.posture, joints, rng);
                let mut start = best.posture.clone();
                for (at, other) in start.iter_mut().zip(other.iter()) {
                    let far: f64 = rng.random_range(0.0..2.0);
                    *at += far.min(1.0) * share * (other - *at);
                }
                own.creature().couple(&mut start);
                hops.push(program.solve_within(&start, FIRST_LOOK));
            }
        }
        found.append(&mut hops);
    }
    sort(&mut found, TOLD);
    let mut last: Vec<PosedPlace> = found.iter().map(|best| program.solve(&best.posture)).collect();
    last.retain(PosedPlace::kept);
    sort(&mut last, TOLD);
    last
}

/// Keeps the best that differ, those that keep everything before those that do not.
fn sort(found: &mut Vec<PosedPlace>, most: usize) {
    found.sort_by(|a, b| b.kept().cmp(&a.kept()).then(b.along.total_cmp(&a.along)));
    let mut kept: Vec<PosedPlace> = Vec::new();
    for posed in found.drain(..) {
        let differs = |other: &PosedPlace| distance(&other.posture, &posed.posture) > DIFFERENT;
        if kept.len() < most && kept.iter().all(differs) {
            kept.push(posed);
        }
    }
    *found = kept;
}
