//! What to learn next.

use super::{Goal, Stages};

/// Motions with a limb to be placed, with joints to be learned, and how many more for each further joint.
const LIMB_MOTIONS: usize = 12;
const JOINT_MOTIONS: usize = 40;
const FURTHER_MOTIONS: usize = 20;
/// Times that a joint or a limb is tried before it is taken that it cannot be touched.
const MOST_TRIES: f64 = 20.0;
/// What it counts as, where no posture is found that promises anything.
pub(super) const UNPROMISING: f64 = 0.1;
/// Times that all that was learned is looked at once more before babbling ends.
const MOST_LOOKS: usize = 12;
/// What limbs are to be placed to, one standard deviation, metres: a millimetre in 95 % of cases. The gaps of all touches then
/// close as exactly as if it were asked for more.
const PRECISE: f64 = 5e-4;

impl Stages {
    /// Chooses what to learn next: all at once, a limb to place, or a joint with much skin to both sides; what was tried least first.
    pub(super) fn next_goal(&mut self) {
        let creature = self.agent.creature();
        let open: Vec<usize> = (0..self.free.len()).filter(|&joint| !self.growth.resolved()[joint]).collect();
        let tries = |goal: &Goal| self.tries.get(goal).copied().unwrap_or(0.0);
        let touches = self.growth.touches();
        let felt = |limb: usize| touches.iter().any(|touch| touch.told.limbs.contains(&limb));
        let felt: Vec<bool> = (0..creature.limbs().len()).map(felt).collect();
        let vague = |limb: &usize| self.growth.placement(*limb) > PRECISE || !felt[*limb];
        let unplaced: Vec<usize> = self.agent.limbs_with_skin().into_iter().filter(vague).collect();
        self.done = open.iter().all(|&joint| tries(&Goal::Joints(vec![joint])) >= MOST_TRIES)
            && unplaced.iter().all(|&limb| tries(&Goal::Limb(limb)) >= MOST_TRIES);
        if self.done && self.looks < MOST_LOOKS {
            self.looks += 1;
            self.done = self.growth.stands();
        }
        if !self.done && !open.is_empty() && self.learns_at_once() {
            self.tried = None;
            self.begin(Goal::Joints(open), JOINT_MOTIONS);
            return;
        }
        let limb =
            unplaced.iter().copied().min_by(|&a, &b| tries(&Goal::Limb(a)).total_cmp(&tries(&Goal::Limb(b))));
        let worth = |joint: usize| self.lever[joint] / (1.0 + tries(&Goal::Joints(vec![joint]))).powi(3);
        let joint = open.iter().copied().max_by(|&a, &b| worth(a).total_cmp(&worth(b)));
        let limb_first = match (limb, joint) {
            (Some(limb), Some(joint)) => tries(&Goal::Limb(limb)) < tries(&Goal::Joints(vec![joint])),
            (limb, _) => limb.is_some(),
        };
        let (goal, named, patience) = match (limb, joint) {
            (Some(limb), _) if limb_first => (Goal::Limb(limb), Goal::Limb(limb), LIMB_MOTIONS),
            (_, Some(joint)) => {
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
}
