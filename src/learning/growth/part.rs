//! Parts of a body that can be learned at once: which joints and limbs, and whether there are touches enough.

use std::collections::BTreeMap;

use super::{FREEDOM, Growth, LIMB_FREEDOM};
use crate::creature::DofKind;
use crate::learning::touch_set::PreparedTouch;

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
pub struct GrownTouch {
    /// The limbs, the earlier one first.
    pub limbs: [usize; 2],
    /// The touch, ready for a solver.
    pub prepared: PreparedTouch,
    /// The joints between the limbs.
    pub chain: Vec<usize>,
    /// Those of them that have axes and do not rest.
    pub moving: Vec<usize>,
    /// How many degrees of freedom between the limbs do not rest.
    pub freedom: usize,
    /// Whether what is believed rests on it.
    pub used: bool,
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

/// A set of numbers below some length.
type Bits = Vec<u64>;

/// Joints and limbs as bits, for parts are compared a great many times.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
struct PartBits {
    joints: Bits,
    limbs: Bits,
}

impl PartBits {
    fn of(part: &Part, joints: usize, limbs: usize) -> PartBits {
        let bits = |members: &[usize], length: usize| {
            let mut bits = vec![0u64; length.div_ceil(64)];
            members.iter().for_each(|&member| bits[member / 64] |= 1 << (member % 64));
            bits
        };
        PartBits { joints: bits(&part.joints, joints), limbs: bits(&part.limbs, limbs) }
    }

    fn words(&self) -> impl Iterator<Item = &u64> {
        self.joints.iter().chain(&self.limbs)
    }

    fn holds(&self, other: &PartBits) -> bool {
        self.words().zip(other.words()).all(|(mine, theirs)| theirs & !mine == 0)
    }

    fn with(&self, other: &PartBits) -> PartBits {
        let both = |a: &Bits, b: &Bits| a.iter().zip(b).map(|(a, b)| a | b).collect();
        PartBits { joints: both(&self.joints, &other.joints), limbs: both(&self.limbs, &other.limbs) }
    }

    fn size(&self) -> u32 {
        self.words().map(|word| word.count_ones()).sum()
    }

    fn part(&self) -> Part {
        Part { joints: members(&self.joints).collect(), limbs: members(&self.limbs).collect() }
    }
}

fn members(bits: &Bits) -> impl Iterator<Item = usize> + '_ {
    (0..64 * bits.len()).filter(|member| bits[member / 64] >> (member % 64) & 1 == 1)
}

/// Touches that lack the same.
#[derive(Clone, Copy, Default)]
struct Tally {
    all: usize,
    /// Those with freedom enough to check joints, and limbs.
    of_joints: usize,
    of_limbs: usize,
}

impl Growth<'_> {
    /// The unknowns of joints: a position, and a direction per axis.
    pub fn width(&self, joints: &[usize]) -> usize {
        let axes = |joint: usize| {
            let dofs = &self.agent.creature().joints()[joint].dofs;
            dofs.iter().filter(|dof| dof.kind != DofKind::Ball).count()
        };
        joints.iter().map(|&joint| 3 + 2 * axes(joint)).sum()
    }

    /// The touches that lack something, and nothing but what is in a part.
    pub(super) fn touches_of<'s>(&'s self, part: &'s Part) -> impl Iterator<Item = &'s GrownTouch> + 's {
        self.touches.iter().filter(|touch| self.is_of(touch, part))
    }

    pub(super) fn is_of(&self, touch: &GrownTouch, part: &Part) -> bool {
        let lacks = self.lacks(touch);
        !touch.moving.is_empty() && !lacks.is_nothing() && part.holds(&lacks)
    }

    /// The parts with so many touches per unknown at the least, the most promising first, with their touches.
    pub(super) fn ready(&self, touches_per_unknown: f64) -> Vec<(Part, usize)> {
        let creature = self.agent.creature();
        let (joints, limbs) = (creature.joints().len(), creature.limbs().len());
        let mut groups: BTreeMap<PartBits, Tally> = BTreeMap::new();
        for touch in self.touches.iter().filter(|touch| !touch.used && !touch.moving.is_empty()) {
            let lacks = self.lacks(touch);
            if lacks.is_nothing() {
                continue;
            }
            let tally = groups.entry(PartBits::of(&lacks, joints, limbs)).or_default();
            tally.all += 1;
            tally.of_joints += usize::from(touch.freedom >= FREEDOM);
            tally.of_limbs += usize::from(touch.freedom >= LIMB_FREEDOM);
        }
        let widths: Vec<usize> = (0..joints).map(|joint| self.width(&[joint])).collect();
        let width = |part: &PartBits| -> usize {
            let of_limbs: u32 = part.limbs.iter().map(|word| word.count_ones()).sum();
            members(&part.joints).map(|joint| widths[joint]).sum::<usize>() + 3 * of_limbs as usize
        };
        let count = |part: &PartBits, of: &dyn Fn(&PartBits, &Tally) -> usize| -> usize {
            let within = groups.iter().filter(|(group, _)| part.holds(group));
            within.map(|(group, tally)| of(group, tally)).sum()
        };
        let all = |part: &PartBits| count(part, &|_, tally| tally.all);
        let worth = |part: &PartBits| all(part) as f64 / (width(part) as f64 + 1.0);
        let mut parts: Vec<PartBits> = groups.keys().cloned().collect();
        let mut seeds: Vec<(&PartBits, &Tally)> = groups.iter().collect();
        seeds.sort_by(|a, b| b.1.all.cmp(&a.1.all).then(a.0.cmp(b.0)));
        for (seed, _) in seeds.into_iter().take(SEEDS) {
            let mut part = seed.clone();
            for _ in 0..ADDITIONS {
                let now = worth(&part);
                let wider = groups.keys().map(|group| part.with(group)).filter(|wider| {
                    (1..=ADDED).contains(&(wider.size() - part.size())) && width(wider) <= WIDEST_PART
                });
                let best = wider.map(|wider| (worth(&wider), wider)).max_by(|a, b| a.0.total_cmp(&b.0));
                let Some((_, best)) = best.filter(|(worth, _)| *worth > now) else { break };
                part = best;
                parts.push(part.clone());
            }
        }
        parts.sort_unstable();
        parts.dedup();
        let enough = |part: &PartBits| {
            let has = |bits: &Bits, member: usize| bits[member / 64] >> (member % 64) & 1 == 1;
            let of_joint = |joint: usize| {
                count(part, &|group, tally| if has(&group.joints, joint) { tally.of_joints } else { 0 })
            };
            let of_limb = |limb: usize| {
                count(part, &|group, tally| if has(&group.limbs, limb) { tally.of_limbs } else { 0 })
            };
            members(&part.joints).all(|joint| of_joint(joint) >= widths[joint] + TO_SPARE)
                && members(&part.limbs).all(|limb| of_limb(limb) >= OF_LIMB)
        };
        let mut ready: Vec<(f64, Part, usize)> = Vec::new();
        for part in parts {
            let (touches, unknowns) = (all(&part) as f64, width(&part) as f64);
            if touches >= touches_per_unknown * unknowns + 3.0 && enough(&part) {
                // Those with most touches for their size and, of these, the smallest.
                ready.push((unknowns / touches + 0.01 * unknowns, part.part(), touches as usize));
            }
        }
        ready.sort_by(|a, b| a.0.total_cmp(&b.0));
        ready.into_iter().map(|(_, part, touches)| (part, touches)).collect()
    }
}
