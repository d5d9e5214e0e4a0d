//! Which limbs of a body can touch each other.
//!
//! A model's own filters are no guide: many switch self-contact off for speed, and in many the shapes of limbs
//! that are near each other in the tree overlap by construction. So contact types and affinities do not count
//! at all, an `<exclude>` counts where its limbs have others to touch, and random postures tell what overlaps
//! for good.

use std::collections::{BTreeMap, BTreeSet};

use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use serde::Serialize;

use super::sorted;
use crate::creature::{Body, Posture};
use crate::error::Result;
use crate::kinematics::Chain;
use crate::mujoco::Data;

/// Random postures that are looked at, always the same ones.
const POSTURES: usize = 200;
/// Geoms that overlap in this share of all postures always do.
const ALWAYS: f64 = 0.9;
/// Where some geoms of two limbs always overlap, so do, as good as always, those that overlap this often.
const OFTEN: f64 = 0.15;
/// A reference posture in which geoms overlap that do so in fewer postures than this is a tangle.
const SELDOM: f64 = 0.5;

/// Shares of the way to the ends of their ranges that joints are moved by where a body is tangled at rest.
const SHARES: [f64; 4] = [0.1, 0.25, 0.5, 1.0];

/// What is between two limbs.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Relation {
    /// They can touch.
    Touch,
    /// One carries the other: their contacts are those of the joint.
    Neighbours,
    /// Their geoms that could meet overlap by construction.
    Overlap,
    /// All their geoms that could meet are excluded by the model.
    Excluded,
}

/// Two limbs with surface, and whether they can touch.
#[derive(Clone, Debug, PartialEq)]
pub struct LimbPair {
    /// The limbs, the earlier first.
    pub limbs: [usize; 2],
    /// Whether they can touch.
    pub relation: Relation,
    /// Whether they can although the model's own filters let none of their geoms collide.
    pub switched_on: bool,
    /// Pairs of their geoms that are left out because they overlap by construction.
    pub left_out: usize,
    /// The share of random postures in which other geoms of theirs overlap.
    pub meeting: f64,
}

/// The limb pairs of a body, and the posture from which they can be told apart.
#[derive(Clone, Debug, PartialEq)]
pub struct SelfContact {
    /// All pairs of limbs with surface.
    pub pairs: Vec<LimbPair>,
    /// Pairs of geoms of different limbs that are never to be felt, the lesser index first.
    pub left_out: BTreeSet<[usize; 2]>,
    /// A posture in which nothing else overlaps: the reference posture, or as near to it as ranges allow, unless
    /// the body is tangled there.
    pub start: Posture,
}

impl SelfContact {
    /// Looks at a body in random postures.
    ///
    /// # Errors
    /// Where the engine fails.
    pub fn new(body: &Body) -> Result<SelfContact> {
        let mut data = Data::new(body.model.clone())?;
        let mut rng = ChaCha8Rng::seed_from_u64(0);
        let mut postures = vec![Posture::start(&body.creature)];
        postures.extend((0..POSTURES).map(|_| Posture::random(&body.creature, &mut rng)));
        let seen: Vec<BTreeSet<[usize; 2]>> =
            postures.iter().map(|posture| overlapping(body, &mut data, posture)).collect::<Result<_, _>>()?;
        let mut counts: BTreeMap<[usize; 2], usize> = BTreeMap::new();
        seen[1..].iter().flatten().for_each(|&pair| *counts.entry(pair).or_default() += 1);
        let share = |pair: &[usize; 2]| counts.get(pair).map_or(0.0, |&n| n as f64 / POSTURES as f64);

        let excluded = excluded(body);
        let limbs = |&[a, b]: &[usize; 2]| limb_pair(body, a, b);
        let always: BTreeSet<[usize; 2]> =
            counts.keys().filter(|pair| share(pair) >= ALWAYS).copied().collect();
        let tangled = |posture: &BTreeSet<[usize; 2]>, below: f64| {
            posture.iter().filter(|pair| share(pair) < below && !excluded.contains(*pair)).count()
        };
        let untangled = untangled(body, &mut data, (&postures[0], &seen[0]), |seen| tangled(seen, SELDOM))?;
        let (start, met_at_start) = untangled.unwrap_or_else(|| {
            let chosen = (0..seen.len()).min_by_key(|&k| tangled(&seen[k], ALWAYS)).unwrap_or(0);
            (postures.swap_remove(chosen), seen[chosen].clone())
        });
        let mut left_out: BTreeSet<[usize; 2]> = always.union(&met_at_start).copied().collect();
        let joined: BTreeSet<[usize; 2]> = left_out.iter().map(limbs).collect();
        left_out.extend(
            counts.keys().filter(|pair| share(pair) >= OFTEN && joined.contains(&limbs(pair))).copied(),
        );

        let mut pairs: BTreeMap<[usize; 2], LimbPair> = BTreeMap::new();
        for pair in geom_pairs(body) {
            let found = pairs.entry(limbs(&pair)).or_insert_with_key(|&[a, b]| {
                let neighbours = body.creature.neighbouring(a, b);
                let relation = if neighbours { Relation::Neighbours } else { Relation::Excluded };
                LimbPair { limbs: [a, b], relation, switched_on: true, left_out: 0, meeting: 0.0 }
            });
            found.switched_on &= !body.declared.collides(pair[0], pair[1]);
            let relation = if left_out.contains(&pair) {
                found.left_out += 1;
                Relation::Overlap
            } else if !excluded.contains(&pair) && body.model.collides(pair[0], pair[1]) {
                Relation::Touch
            } else {
                continue;
            };
            if !matches!(found.relation, Relation::Neighbours | Relation::Touch) {
                found.relation = relation;
            }
        }
        left_out.extend(&excluded);
        let mut meeting: BTreeMap<[usize; 2], usize> = BTreeMap::new();
        for posture in &seen[1..] {
            let met: BTreeSet<[usize; 2]> = posture.difference(&left_out).map(limbs).collect();
            met.into_iter().for_each(|pair| *meeting.entry(pair).or_default() += 1);
        }
        let pairs = pairs.into_values().map(|pair| LimbPair {
            switched_on: pair.switched_on && pair.relation == Relation::Touch,
            meeting: meeting.get(&pair.limbs).map_or(0.0, |&n| n as f64 / POSTURES as f64),
            ..pair
        });
        Ok(SelfContact { pairs: pairs.collect(), left_out, start })
    }

    /// The number of limb pairs in a relation.
    pub fn count(&self, relation: Relation) -> usize {
        self.pairs.iter().filter(|pair| pair.relation == relation).count()
    }
}

/// A posture near a tangled one, given with what overlaps there, in which nothing is tangled; and what overlaps in that: joint by joint the turn or shift that
/// leaves least. Few joints away from the reference posture leave most of a body's joints at rest.
fn untangled(
    body: &Body,
    data: &mut Data,
    (from, overlaps): (&Posture, &BTreeSet<[usize; 2]>),
    tangled: impl Fn(&BTreeSet<[usize; 2]>) -> usize,
) -> Result<Option<(Posture, BTreeSet<[usize; 2]>)>> {
    let creature = &body.creature;
    let (mut best, mut seen) = (from.clone(), overlaps.clone());
    while tangled(&seen) > 0 {
        let between: BTreeSet<usize> = seen
            .iter()
            .flat_map(|&[a, b]| {
                let [a, b] = limb_pair(body, a, b);
                Chain::between(creature, a, b).joints().collect::<Vec<usize>>()
            })
            .collect();
        let mut least = tangled(&seen);
        let mut found: Option<(Posture, BTreeSet<[usize; 2]>)> = None;
        for share in SHARES {
            for joint in between.iter().map(|&joint| &creature.joints()[joint]) {
                for at in joint.elements().filter(|at| !at.is_ball()) {
                    for end in at.range {
                        let mut posture = best.clone();
                        let now = posture[at.coordinate()];
                        posture[at.coordinate()] = now + share * (end - now);
                        creature.couple(&mut posture);
                        let left = overlapping(body, data, &posture)?;
                        let tangles = tangled(&left);
                        if tangles < least {
                            least = tangles;
                            found = Some((posture, left));
                        }
                    }
                }
            }
        }
        let Some(less) = found else { return Ok(None) };
        (best, seen) = less;
    }
    Ok(Some((best, seen)))
}

/// The limbs of two geoms that are felt, the earlier first.
fn limb_pair(body: &Body, a: usize, b: usize) -> [usize; 2] {
    sorted([a, b].map(|g| body.limb_of_geom(g).unwrap_or(0)))
}

/// The pairs of geoms, the lesser index first, whose bodies the model excludes, but for limbs that could then touch
/// nothing at all.
fn excluded(body: &Body) -> BTreeSet<[usize; 2]> {
    let named: BTreeSet<[usize; 2]> = body.declared.excludes().map(sorted).collect();
    if named.is_empty() {
        return BTreeSet::new();
    }
    let is_named = |a: usize, b: usize| named.contains(&sorted([a, b].map(|g| body.model.geom_body(g))));
    let mut touching = BTreeSet::new();
    let mut pairs = BTreeSet::new();
    for [a, b] in geom_pairs(body) {
        let [first, second] = limb_pair(body, a, b);
        if is_named(a, b) {
            pairs.insert([a, b]);
        } else if !body.creature.neighbouring(first, second) {
            touching.extend([first, second]);
        }
    }
    pairs.retain(|&[a, b]| limb_pair(body, a, b).iter().all(|limb| touching.contains(limb)));
    pairs
}

/// All pairs of geoms that are felt, on different limbs, the lesser index first.
fn geom_pairs(body: &Body) -> impl Iterator<Item = [usize; 2]> {
    let geoms: Vec<usize> = (0..body.model.ngeom()).filter(|&g| body.feels(g)).collect();
    let all = (0..geoms.len()).flat_map(move |k| {
        let first = geoms[k];
        geoms[k + 1..].iter().map(move |&second| [first, second]).collect::<Vec<_>>()
    });
    all.filter(|&[a, b]| body.limb_of_geom(a) != body.limb_of_geom(b))
}

/// The pairs of geoms of different limbs that overlap in a posture by the engine, the lesser index first; neighbours are left
/// out.
fn overlapping(body: &Body, data: &mut Data, posture: &[f64]) -> Result<BTreeSet<[usize; 2]>> {
    body.put(posture, data)?;
    data.collision()?;
    let pairs = data.contacts().map(|contact| sorted(contact.geoms));
    let apart = |&[a, b]: &[usize; 2]| {
        let [first, second] = limb_pair(body, a, b);
        !body.creature.neighbouring(first, second)
    };
    Ok(pairs.filter(apart).collect())
}
