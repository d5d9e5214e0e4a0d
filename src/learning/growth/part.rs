//! Parts of a body that can be learned at once: which joints and limbs, and whether there are touches enough.

use std::collections::BTreeMap;
use std::sync::Arc;

use super::Growth;
use crate::creature::DofKind;
use crate::learning::scrutiny::ToldTouch;

/// Touches of a joint, beyond its unknowns, that a part with it needs.
const TO_SPARE: usize = 6;
/// Touches of a limb that a part with it needs.
const OF_LIMB: usize = 6;
/// The most unknowns of a part: a random initial guess of more seldom finds the answer.
const WIDEST_PART: usize = 60;
/// Groups of touches from which parts are put together, those with most touches first, …
const SEEDS: usize = 24;
/// … how often each is added to …
const ADDITIONS: usize = 6;
/// … and how many joints and limbs at a time.
const ADDED: u32 = 2;

/// A touch, and what it takes to learn from it.
#[derive(Clone, Debug)]
pub struct GrownTouch {
    /// The touch, and what it tells of.
    pub told: Arc<ToldTouch>,
    /// Whether what is believed rests on it.
    pub used: bool,
    /// Whether it makes a condition that those before it of the same limbs and moving joints did not make.
    pub(super) is_new: bool,
    /// Whether touches like it can make as many conditions as it takes to learn the joints that moved where nothing is known.
    pub suffices: bool,
    /// Whether nothing is learned from it: there were enough like it already, or nothing moved between its limbs, or a single
    /// coordinate did and made no new condition.
    pub(super) spare: bool,
    /// How much was known when it was found not to agree with what is believed.
    pub(super) refused: Option<usize>,
}

/// Joints to resolve and limbs to place.
#[derive(Clone, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub struct Part {
    /// The joints.
    pub joints: Vec<usize>,
    /// The limbs.
    pub limbs: Vec<usize>,
}

impl Part {
    /// Whether there is nothing in it.
    pub fn is_nothing(&self) -> bool {
        self.joints.is_empty() && self.limbs.is_empty()
    }

    /// What tells one part from another: its joints or, without any, its limbs.
    pub(super) fn key(&self) -> Part {
        let limbs = if self.joints.is_empty() { self.limbs.clone() } else { Vec::new() };
        Part { joints: self.joints.clone(), limbs }
    }

    /// Whether all of another part is in this one.
    pub(super) fn holds(&self, other: &Part) -> bool {
        other.joints.iter().all(|joint| self.joints.contains(joint))
            && other.limbs.iter().all(|limb| self.limbs.contains(limb))
    }
}

/// Joints and, after them, limbs as bits, for parts are compared a great many times.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
struct PartBits(Vec<u64>);

impl PartBits {
    fn of(part: &Part, joints: usize, limbs: usize) -> PartBits {
        let mut bits = vec![0u64; (joints + limbs).div_ceil(64)];
        let members = part.joints.iter().copied().chain(part.limbs.iter().map(|limb| joints + limb));
        members.for_each(|member| bits[member / 64] |= 1 << (member % 64));
        PartBits(bits)
    }

    fn holds(&self, other: &PartBits) -> bool {
        self.0.iter().zip(&other.0).all(|(mine, theirs)| theirs & !mine == 0)
    }

    fn has(&self, member: usize) -> bool {
        self.0[member / 64] >> (member % 64) & 1 == 1
    }

    fn with(&self, other: &PartBits) -> PartBits {
        PartBits(self.0.iter().zip(&other.0).map(|(a, b)| a | b).collect())
    }

    fn shares(&self, other: &PartBits) -> bool {
        self.0.iter().zip(&other.0).any(|(a, b)| a & b != 0)
    }

    /// How many members another has that it has not.
    fn lacks_of(&self, other: &PartBits) -> u32 {
        self.0.iter().zip(&other.0).map(|(mine, theirs)| (theirs & !mine).count_ones()).sum()
    }

    fn members(&self) -> impl Iterator<Item = usize> + '_ {
        let words = self.0.iter().enumerate().filter(|(_, word)| **word != 0);
        words.flat_map(|(at, word)| {
            (0..64).filter(move |bit| word >> bit & 1 == 1).map(move |bit| 64 * at + bit)
        })
    }

    fn part(&self, joints: usize) -> Part {
        let (of_joints, limbs) = self.members().partition::<Vec<usize>, _>(|&member| member < joints);
        Part { joints: of_joints, limbs: limbs.into_iter().map(|member| member - joints).collect() }
    }
}

impl Growth {
    /// The unknowns of joints: a position, and a direction per axis.
    pub fn width(&self, joints: &[usize]) -> usize {
        let axes = |joint: usize| {
            let dofs = &self.agent.creature().joints()[joint].dofs;
            dofs.iter().filter(|dof| dof.kind != DofKind::Ball).count()
        };
        joints.iter().map(|&joint| 3 + 2 * axes(joint)).sum()
    }

    /// Whether a touch lacks something, and nothing but what is in a part.
    pub(super) fn is_of(&self, touch: &GrownTouch, part: &Part) -> bool {
        let lacks = self.lacks(touch);
        !self.is_spare(touch) && !lacks.is_nothing() && part.holds(&lacks)
    }

    /// All joints and limbs that touches lack.
    pub(super) fn all_lacking(&self) -> Part {
        let creature = self.agent.creature();
        let (joints, limbs) = (creature.joints().len(), creature.limbs().len());
        let touches = self.touches.iter().filter(|touch| !self.is_spare(touch));
        let lacking = touches.map(|touch| PartBits::of(&self.lacks(touch), joints, limbs));
        lacking.reduce(|all, other| all.with(&other)).map_or_else(Part::default, |all| all.part(joints))
    }

    /// The parts with so many touches per unknown at the least, the most promising first, with their touches.
    pub(super) fn ready(&self, touches_per_unknown: f64) -> Vec<(Part, usize)> {
        let creature = self.agent.creature();
        let (joints, limbs) = (creature.joints().len(), creature.limbs().len());
        // How many touches lack the same.
        let mut groups: BTreeMap<PartBits, usize> = BTreeMap::new();
        for touch in self.touches.iter().filter(|touch| !touch.used && !self.is_spare(touch)) {
            let lacks = self.lacks(touch);
            if !lacks.is_nothing() {
                *groups.entry(PartBits::of(&lacks, joints, limbs)).or_default() += 1;
            }
        }
        let groups: Vec<(PartBits, usize)> = groups.into_iter().collect();
        let widths: Vec<usize> =
            (0..joints).map(|joint| self.width(&[joint])).chain((0..limbs).map(|_| 3)).collect();
        let width = |part: &PartBits| -> usize { part.members().map(|member| widths[member]).sum() };
        let all = |part: &PartBits| -> usize {
            groups.iter().map(|(group, touches)| if part.holds(group) { *touches } else { 0 }).sum()
        };
        let worth = |part: &PartBits| all(part) as f64 / (width(part) as f64 + 1.0);
        let mut parts: Vec<PartBits> = groups.iter().map(|(group, _)| group.clone()).collect();
        let mut seeds: Vec<&(PartBits, usize)> = groups.iter().collect();
        seeds.sort_by(|a, b| b.1.cmp(&a.1).then(a.0.cmp(&b.0)));
        for (seed, _) in seeds.into_iter().take(SEEDS) {
            let mut part = seed.clone();
            for _ in 0..ADDITIONS {
                let now = worth(&part);
                // What shares nothing with it is a part of its own.
                let near = groups
                    .iter()
                    .filter(|(group, _)| part.shares(group) && (1..=ADDED).contains(&part.lacks_of(group)));
                let wider =
                    near.map(|(group, _)| part.with(group)).filter(|wider| width(wider) <= WIDEST_PART);
                let best = wider.map(|wider| (worth(&wider), wider)).max_by(|a, b| a.0.total_cmp(&b.0));
                let Some((_, best)) = best.filter(|(worth, _)| *worth > now) else { break };
                part = best;
                parts.push(part.clone());
            }
        }
        parts.sort_unstable();
        parts.dedup();
        let mut ready: Vec<(f64, Part, usize)> = Vec::new();
        for part in parts {
            let (touches, unknowns) = (all(&part) as f64, width(&part) as f64);
            if touches < touches_per_unknown * unknowns + 3.0 {
                continue;
            }
            let enough = part.members().all(|member| {
                let tell = groups.iter().filter(|(group, _)| part.holds(group) && group.has(member));
                let wanted = if member < joints { widths[member] + TO_SPARE } else { OF_LIMB };
                tell.map(|(_, touches)| touches).sum::<usize>() >= wanted
            });
            if enough {
                // Those with most touches for their size and, of these, the smallest.
                ready.push((unknowns / touches + 0.01 * unknowns, part.part(joints), touches as usize));
            }
        }
        ready.sort_by(|a, b| a.0.total_cmp(&b.0));
        ready.into_iter().map(|(_, part, touches)| (part, touches)).collect()
    }
}
