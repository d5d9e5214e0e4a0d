//! Whether an answer stands.

use std::collections::BTreeMap;

use nalgebra::{DMatrix, DVector};

use super::evidence::Equation;
use super::solving::{PartProblem, Solved};
use super::{GrownTouch, Growth};
use crate::creature::DofKind;
use crate::learning::Parameters;
use crate::learning::prediction::{add_row, information_inverse, row_variance};
use crate::learning::scrutiny::{CLOSED, Member};

/// Touches that others check which a joint needs, or a limb: a wrong answer closes none of them but by chance.
const CHECKED: f64 = 3.0;
/// The most that the skin on a known joint may be off by its axes where the joint turns as far as it can, one standard deviation,
/// metres; but as much as this an axis may be off wherever its skin is, and never more than that where it turns by a radian, radians.
const SURE: f64 = 5e-3;
const SURE_AXIS: f64 = 0.02;
const UNSURE_AXIS: f64 = 0.2;
/// Of what a touch misses by, a fit to it leaves open the share that its leverage lacks to 1. Wrong answers miss by a millimetre:
/// where no more than this share is left, the gap counts as closed all the same, and no other touches check this one.
const CHECKED_SHARE: f64 = CLOSED / 1e-3;
/// What swings less counts as if it swung so far, radians.
const LEAST_SWING: f64 = 1e-6;
/// The fewest touches that anything is learned from.
const FEWEST: usize = 5;

impl Growth {
    /// Takes a part's answer in, as far as touches check it; whether anything is left of it.
    pub(super) fn accept(&mut self, problem: &PartProblem, solved: &Solved) -> bool {
        let given_up = |touch: &GrownTouch| solved.given_up.iter().any(|&member| touch.told.tells_of(member));
        let stands = |&number: &usize| {
            let touch = &self.touches[number];
            !given_up(touch) && self.closes(touch, &solved.schema)
        };
        let new: Vec<usize> = problem.numbers.iter().copied().filter(stands).collect();
        let Some((joints, new)) = self.checked_part(problem, solved, new) else { return false };
        // What speaks against an answer was perhaps not looked at to the end.
        if self.deadline.has_passed() {
            return false;
        }
        let mut grown = self.clone();
        joints.iter().for_each(|&joint| grown.resolved[joint] = true);
        // An answer that opens as much as it closes is none.
        let stands = grown.believe(solved.schema.clone(), &new) && grown.used().count() > self.used().count();
        if stands {
            grown.place();
            *self = grown;
        }
        stands
    }

    /// What of a part's joints and closed touches is left without what others do not check.
    fn checked_part(
        &self,
        problem: &PartProblem,
        solved: &Solved,
        mut new: Vec<usize>,
    ) -> Option<(Vec<usize>, Vec<usize>)> {
        let (part, schema) = (problem.part, &solved.schema);
        let mut joints = part.joints.clone();
        joints.retain(|&joint| !solved.given_up.contains(&Member::Joint(joint)));
        let is_nothing =
            |joints: &[usize]| joints.is_empty() && (self.belief.is_none() || part.limbs.is_empty());
        let mut rows: BTreeMap<usize, Vec<Equation>> = BTreeMap::new();
        for &number in &new {
            rows.insert(number, self.equations(&self.touches[number], &problem.unit, schema));
        }
        let believed = problem.information(schema);
        loop {
            if new.len() < FEWEST || is_nothing(&joints) {
                return None;
            }
            let mut information = believed.clone();
            let told = new.iter().flat_map(|number| &rows[number]);
            told.for_each(|row| add_row(&mut information, &row.entries, self.weight()));
            let covariance = information_inverse(information, &problem.unit)?;
            let of_row = |row: &Equation| (row_variance(&row.entries, &covariance) * self.weight()).min(1.0);
            let leverage = |number: usize| rows[&number].iter().map(of_row).fold(0.0, f64::max);
            let leverages: Vec<(usize, f64)> = new.iter().map(|&number| (number, leverage(number))).collect();
            let checked_ones = leverages.iter().filter(|(_, leverage)| 1.0 - leverage > CHECKED_SHARE);
            new = checked_ones.map(|(number, _)| *number).collect();
            if new.len() < leverages.len() {
                continue;
            }
            let checked = |of: &dyn Fn(&GrownTouch) -> bool| -> f64 {
                let told = || leverages.iter().filter(|(number, _)| of(&self.touches[*number]));
                let least: f64 = told().map(|(_, leverage)| 1.0 - leverage).sum();
                if least >= CHECKED {
                    return least;
                }
                let of_it: Vec<&Equation> = told().flat_map(|(number, _)| &rows[number]).collect();
                checks(&of_it, &covariance, self.weight()) as f64
            };
            let of_joint = |joint: usize| checked(&|touch| touch.told.moving.contains(&joint));
            let deviation = |joint: usize| self.axis_deviation_in(joint, &problem.unit, &covariance);
            let sure = |joint: usize| {
                let swing = self.swing(joint);
                (SURE / self.reach[joint] / swing).clamp(SURE_AXIS, UNSURE_AXIS / swing)
            };
            let doubt = |joint: usize| (1.0 + deviation(joint) / sure(joint)) / (of_joint(joint) + 1e-9);
            let doubtful = |joint: &usize| of_joint(*joint) < CHECKED || deviation(*joint) > sure(*joint);
            let worst =
                joints.iter().copied().filter(doubtful).max_by(|&a, &b| doubt(a).total_cmp(&doubt(b)));
            if let Some(worst) = worst {
                joints.retain(|&joint| joint != worst);
                new.retain(|&number| !self.touches[number].told.moving.contains(&worst));
                continue;
            }
            let of_limb = |limb: usize| checked(&|touch| touch.told.limbs.contains(&limb));
            let lonely = |limb: &usize| {
                of_limb(*limb) < CHECKED
                    && new.iter().any(|&number| self.touches[number].told.limbs.contains(limb))
            };
            let limbs = part.limbs.iter().copied().filter(lonely);
            let Some(limb) = limbs.min_by(|&a, &b| of_limb(a).total_cmp(&of_limb(b))) else {
                return Some((joints, new));
            };
            new.retain(|&number| !self.touches[number].told.limbs.contains(&limb));
        }
    }

    /// How far a joint turns from where it rests at the most, radians, as far as it matters: what hardly swings displaces little,
    /// however wrong its axis is.
    fn swing(&self, joint: usize) -> f64 {
        let elements =
            self.agent.creature().joints()[joint].elements().filter(|at| at.kind == DofKind::Hinge);
        let most = elements.map(|at| at.range[0].abs().max(at.range[1].abs())).reduce(f64::max);
        most.unwrap_or(1.0).clamp(LEAST_SWING, 1.0)
    }

    /// The greatest standard deviation of a joint's axes across their directions, radians.
    fn axis_deviation_in(&self, joint: usize, parameters: &Parameters, covariance: &DMatrix<f64>) -> f64 {
        let deviation = |dof: usize| {
            parameters.axes[dof].map_or(f64::INFINITY, |place| {
                covariance[(place, place)].max(covariance[(place + 1, place + 1)]).sqrt()
            })
        };
        let elements = self.agent.creature().joints()[joint].elements().filter(|at| !at.is_ball());
        elements.map(|at| deviation(at.axis())).fold(0.0, f64::max)
    }
}

/// How many equations among some are checked by the others, or by each other: as many as are left once those are taken away that
/// it takes to tell what nothing else tells. These are the directions in which a fit to them leaves nothing open of what they miss by.
fn checks(rows: &[&Equation], covariance: &DMatrix<f64>, weight: f64) -> usize {
    let moved = |row: &&Equation| {
        let mut moved = DVector::zeros(covariance.nrows());
        row.entries.iter().for_each(|&(place, slope)| moved.axpy(slope, &covariance.column(place), 1.0));
        moved
    };
    if rows.is_empty() {
        return 0;
    }
    let moved: Vec<DVector<f64>> = rows.iter().map(moved).collect();
    let left = DMatrix::from_fn(rows.len(), rows.len(), |i, j| {
        let taken_up: f64 = rows[i].entries.iter().map(|&(place, slope)| slope * moved[j][place]).sum();
        f64::from(u8::from(i == j)) - weight * taken_up
    });
    left.symmetric_eigenvalues().iter().filter(|share| **share > CHECKED_SHARE).count()
}
