//! Which joints are learned first: those that touch soon while all move or, where that is in vain, sets of joints between two
//! limbs, which are tried for how soon they touch.

use std::collections::BTreeMap;

use super::{Goal, Stages};
use crate::kinematics::Chain;
use crate::learning::growth::{FEWEST_UNKNOWNS, Growth};

/// Touches at random with all joints before it is seen whether these will tell of a first part: they tell of the next parts, too.
pub(super) const SURVEY_TOUCHES: usize = 40;
/// Sets of joints that are tried, …
const SETS: usize = 16;
/// … as many of each of so many sizes.
const SIZES: usize = 4;
/// The fewest and the most unknowns of the joints of a set: of more no answer is found.
const UNKNOWNS: [usize; 2] = [FEWEST_UNKNOWNS, 110];
/// Touches after which a trial ends, and the most motions.
const TRIAL_TOUCHES: usize = 12;
pub(super) const TRIAL_MOTIONS: usize = 60;
/// So many more unknowns make a set twice as hard to learn: a random initial guess of many seldom finds their answer.
const HARDER: f64 = 15.0;
/// Touches are rare of which there are not more than one in so many motions.
const RARE: usize = 6;
/// Motions with a set before it is seen whether another has become more promising, in units of those after which it should
/// be learned.
const PATIENCE: f64 = 1.2;

/// A set of joints that may be learned first.
#[derive(Default)]
pub(super) struct FirstSet {
    joints: Vec<usize>,
    /// The touches that told something while they moved, and the motions.
    touches: usize,
    motions: usize,
}

impl FirstSet {
    pub(super) fn of(joints: Vec<usize>) -> FirstSet {
        FirstSet { joints, ..FirstSet::default() }
    }

    /// Motions that are missing until it should be learned.
    fn missing(&self, growth: &Growth) -> f64 {
        let touches = growth.first_wanted(&self.joints) - growth.touches_within(&self.joints) as f64;
        touches.max(1.0) * (self.motions + 1) as f64 / (self.touches as f64 + 0.5)
    }
}

impl Stages {
    /// The sets of joints between two limbs that may be learned first, those that carry most skin for their size.
    fn first_sets(&self) -> Vec<Vec<usize>> {
        let creature = self.agent.creature();
        let skinned = self.agent.limbs_with_skin();
        let mut sets: BTreeMap<Vec<usize>, f64> = BTreeMap::new();
        for (number, &a) in skinned.iter().enumerate() {
            for &b in skinned[number + 1..].iter().filter(|&&b| !creature.neighbouring(a, b)) {
                let mut set: Vec<usize> = Chain::between(creature, a, b).joints().collect();
                set.sort_unstable();
                let unknowns = self.growth.width(&set);
                if (UNKNOWNS[0]..=UNKNOWNS[1]).contains(&unknowns) {
                    let lever = set.iter().map(|&joint| self.lever[joint]).sum::<f64>();
                    sets.insert(set, lever / (unknowns + 10) as f64);
                }
            }
        }
        let mut sets: Vec<(Vec<usize>, f64)> = sets.into_iter().collect();
        sets.sort_by(|a, b| b.1.total_cmp(&a.1));
        // As many small ones as large ones: only trial tells how many joints it takes to touch.
        let [least, most] = UNKNOWNS;
        let size = |set: &[usize]| (self.growth.width(set) - least) * SIZES / (most - least + 1);
        let of_size = |wanted: usize| {
            let sets = sets.iter().filter(move |(set, _)| size(set) == wanted);
            sets.take(SETS / SIZES).map(|(set, _)| set.clone())
        };
        (0..SIZES).flat_map(of_size).collect()
    }

    /// Whether all that is not known moves, and is learned at once: not where that seldom touches.
    pub(super) fn learns_at_once(&self) -> bool {
        self.all_move && self.growth.learns_at_once()
    }

    /// Begins with the first set; all joints, which were tried already, are the last.
    fn begin_trials(&mut self) {
        self.growth.hurry(false);
        self.trials[0].motions += self.motions;
        let sets = self.first_sets().into_iter().map(FirstSet::of);
        self.trials.splice(..0, sets);
        self.move_set(0, TRIAL_MOTIONS);
    }

    pub(super) fn move_set(&mut self, number: usize, motions: usize) {
        self.trial = number;
        self.begin(Goal::Joints(self.trials[number].joints.clone()), motions);
    }

    /// Whether few motions with the set that is tried end in a touch that tells anything.
    pub(super) fn touches_seldom(&self) -> bool {
        let tried = &self.trials[self.trial];
        RARE * (tried.touches + 1) <= tried.motions + self.motions
    }

    /// A touch of the set that is tried.
    pub(super) fn count_trial(&mut self) {
        self.trials[self.trial].touches += 1;
    }

    /// Goes on with the trials, or with the set that needs least to be learned.
    pub(super) fn try_on(&mut self) {
        if self.trials.len() == 1 {
            let motions = RARE * SURVEY_TOUCHES;
            let touches_soon = self.growth.touches().len() >= SURVEY_TOUCHES;
            self.all_move |= touches_soon && self.motions <= motions;
            let waits = self.learns_at_once() || self.growth.may_hurry();
            if (touches_soon || self.motions >= motions) && !waits {
                self.begin_trials();
            }
            return;
        }
        let enough = self.trials[self.trial].touches >= TRIAL_TOUCHES;
        if self.motions < self.patience && !(self.is_choosing && enough) {
            return;
        }
        self.trials[self.trial].motions += self.motions;
        if self.is_choosing && self.trial + 2 < self.trials.len() {
            self.move_set(self.trial + 1, TRIAL_MOTIONS);
            return;
        }
        self.is_choosing = false;
        let missing = |number: usize| self.trials[number].missing(&self.growth);
        let hardness = |number: usize| self.growth.width(&self.trials[number].joints) as f64 / HARDER;
        let cost = |number: &usize| missing(*number) * 2f64.powf(hardness(*number));
        let best = (0..self.trials.len()).min_by(|a, b| cost(a).total_cmp(&cost(b))).unwrap_or(0);
        self.over = best != self.trial;
        let motions = (PATIENCE * missing(best)) as usize;
        self.move_set(best, motions.max(TRIAL_MOTIONS));
    }
}
