//! What to learn next.

use std::collections::BTreeMap;

use super::{Goal, Stages};
use crate::kinematics::Chain;
use crate::learning::growth::{FIRST_TOUCHES, FREEDOM};

/// Sets of joints that are tried before the first is learned, …
const TRIALS: usize = 16;
/// … as many of each of so many sizes, …
const SIZES: usize = 4;
/// … motions with each, …
pub(super) const TRIAL_MOTIONS: usize = 40;
/// … and with all joints, which show what can be touched at all.
const SURVEY_MOTIONS: usize = 150;
/// The least and the most unknowns of the joints of a first set: with fewer wrong answers fit, with more none is found.
const FIRST_UNKNOWNS: [usize; 2] = [24, 110];
/// Motions with a first set before another is tried, in units of those after which it should have been learned.
const FIRST_PATIENCE: f64 = 2.0;
/// Motions with a limb to be placed, with joints to be learned, and how many more for each further joint.
const LIMB_MOTIONS: usize = 12;
const JOINT_MOTIONS: usize = 40;
const FURTHER_MOTIONS: usize = 20;
/// Times that a joint or a limb is tried before it is taken that it cannot be touched.
const MOST_TRIES: f64 = 20.0;
/// What it counts as, where no posture is found that promises anything.
pub(super) const UNPROMISING: f64 = 0.1;
/// What limbs are to be placed to, one standard deviation, metres: a tenth of a millimetre in 95 % of cases.
const PRECISE: f64 = 5e-5;
/// The most unknowns of joints that a touch made by chance has learned at once.
const CHANCE_UNKNOWNS: usize = 35;

impl Stages<'_> {
    /// The sets of joints between two limbs that may be learned first, those that carry most skin for their size first.
    pub(super) fn first_sets(&self) -> Vec<Vec<usize>> {
        let creature = self.agent.creature();
        let skinned = self.agent.limbs_with_skin();
        let mut sets: BTreeMap<Vec<usize>, f64> = BTreeMap::new();
        for (number, &a) in skinned.iter().enumerate() {
            for &b in skinned[number + 1..].iter().filter(|&&b| !creature.neighbouring(a, b)) {
                let mut set: Vec<usize> = Chain::between(creature, a, b).joints().collect();
                set.sort_unstable();
                let unknowns = self.growth.width(&set);
                if (FIRST_UNKNOWNS[0]..=FIRST_UNKNOWNS[1]).contains(&unknowns) {
                    let lever = set.iter().map(|&joint| self.lever[joint]).sum::<f64>();
                    sets.insert(set, lever / (unknowns + 10) as f64);
                }
            }
        }
        let mut sets: Vec<(Vec<usize>, f64)> = sets.into_iter().collect();
        sets.sort_by(|a, b| b.1.total_cmp(&a.1));
        // As many small ones as large ones: only trial tells how many joints it takes to touch.
        let [least, most] = FIRST_UNKNOWNS;
        let size = |set: &[usize]| (self.growth.width(set) - least) * SIZES / (most - least + 1);
        let of_size = |wanted: usize| {
            let sets = sets.iter().filter(move |(set, _)| size(set) == wanted);
            sets.take(TRIALS / SIZES).map(|(set, _)| set.clone())
        };
        (0..SIZES).flat_map(of_size).collect()
    }

    pub(super) fn begin_trial(&mut self, number: usize) {
        self.trial = Some(number);
        let set = self.trials[number].0.clone();
        let all = number + 1 == self.trials.len();
        self.begin(Goal::Joints(set), if all { SURVEY_MOTIONS } else { TRIAL_MOTIONS });
    }

    pub(super) fn end_trial(&mut self, trial: usize) {
        if trial + 1 < self.trials.len() {
            self.begin_trial(trial + 1);
            return;
        }
        // Those first that have their touches soonest; where none touched, all joints at once.
        let mut trials = std::mem::take(&mut self.trials);
        if trials[..trial].iter().any(|(_, touches)| *touches > 0) {
            trials.pop();
            trials.retain(|(_, touches)| *touches > 0);
        }
        trials.sort_by(|a, b| self.first_motions(a).total_cmp(&self.first_motions(b)));
        self.trials = trials;
        self.trial = None;
        self.next_first();
    }

    /// Motions after which a set of joints will have as many touches as a first part needs.
    pub(super) fn first_motions(&self, (set, touches): &(Vec<usize>, usize)) -> f64 {
        FIRST_TOUCHES * (self.growth.width(set) * TRIAL_MOTIONS) as f64 / (*touches).max(1) as f64
    }

    /// Goes on with the next set of joints for the first part, each time with more motions.
    pub(super) fn next_first(&mut self) {
        let number = self.goals % self.trials.len();
        let rounds = 1 + self.goals / self.trials.len();
        let motions = FIRST_PATIENCE * rounds as f64 * self.first_motions(&self.trials[number]);
        let set = self.trials[number].0.clone();
        self.goals += 1;
        self.over = true;
        self.begin(Goal::Joints(set), motions as usize);
    }

    /// Chooses what to learn next: joints that a touch made by chance had, a limb to place, a joint with much skin to both
    /// sides; what was tried least first.
    pub(super) fn next_goal(&mut self) {
        let creature = self.agent.creature();
        let open: Vec<usize> = (0..self.free.len()).filter(|&joint| !self.growth.resolved()[joint]).collect();
        let tries = |goal: &Goal| self.tries.get(goal).copied().unwrap_or(0.0);
        let vague = |limb: &usize| self.growth.placement(*limb) > PRECISE;
        let unplaced: Vec<usize> = self.agent.limbs_with_skin().into_iter().filter(vague).collect();
        self.done = open.iter().all(|&joint| tries(&Goal::Joints(vec![joint])) >= MOST_TRIES)
            && unplaced.iter().all(|&limb| tries(&Goal::Limb(limb)) >= MOST_TRIES);
        self.goals += 1;
        let repeated = (self.goals.is_multiple_of(2)).then(|| self.chance(&tries)).flatten();
        let limb =
            unplaced.iter().copied().min_by(|&a, &b| tries(&Goal::Limb(a)).total_cmp(&tries(&Goal::Limb(b))));
        let worth = |joint: usize| self.lever[joint] / (1.0 + tries(&Goal::Joints(vec![joint]))).powi(3);
        let joint = open.iter().copied().max_by(|&a, &b| worth(a).total_cmp(&worth(b)));
        let limb_first = match (limb, joint) {
            (Some(limb), Some(joint)) => tries(&Goal::Limb(limb)) < tries(&Goal::Joints(vec![joint])),
            (limb, _) => limb.is_some(),
        };
        let (goal, named, patience) = match (repeated, limb, joint) {
            (Some(joints), _, _) => {
                let patience = 30 + 2 * self.growth.width(&joints);
                (Goal::Repeat(joints.clone()), Goal::Repeat(joints), patience)
            }
            (None, Some(limb), _) if limb_first => (Goal::Limb(limb), Goal::Limb(limb), LIMB_MOTIONS),
            (None, _, Some(joint)) => {
                let named = Goal::Joints(vec![joint]);
                // What cannot be touched alone may be together with its neighbours.
                let further = tries(&named).min(3.0) as usize;
                let mut joints = vec![joint];
                let meets = |a: usize, b: usize| creature.joints()[a].parent == b + 1;
                for _ in 0..further {
                    let beside = |other: &usize| {
                        !joints.contains(other)
                            && joints.iter().any(|&j| meets(*other, j) || meets(j, *other))
                    };
                    let Some(next) = open.iter().copied().find(beside) else { break };
                    joints.push(next);
                }
                joints.sort_unstable();
                (Goal::Joints(joints), named, JOINT_MOTIONS + FURTHER_MOTIONS * further)
            }
            _ => return,
        };
        *self.tries.entry(named.clone()).or_insert(0.0) += 1.0;
        self.tried = Some(named);
        self.begin(goal, patience);
    }

    /// The joints to be learned of a touch that was made by chance: few, tried seldom, and with much skin.
    pub(super) fn chance(&self, tries: &impl Fn(&Goal) -> f64) -> Option<Vec<usize>> {
        let mut sets: BTreeMap<Vec<usize>, ()> = BTreeMap::new();
        for touch in self.growth.touches().iter().filter(|touch| touch.freedom >= FREEDOM) {
            let joints = self.growth.lacks(touch).joints;
            if !joints.is_empty() && self.growth.width(&joints) <= CHANCE_UNKNOWNS {
                sets.insert(joints, ());
            }
        }
        let cost = |joints: &Vec<usize>| {
            let tried = tries(&Goal::Repeat(joints.clone()));
            let lever = joints.iter().map(|&joint| self.lever[joint] + 0.02).fold(0.0, f64::max);
            self.growth.width(joints) as f64 * (1.0 + tried) / lever.sqrt()
        };
        sets.into_keys().min_by(|a, b| cost(a).total_cmp(&cost(b)))
    }
}
