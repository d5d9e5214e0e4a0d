//! Whether an answer stands, and what is believed with it.

use std::collections::BTreeMap;

use super::{FREEDOM, GrownTouch, Growth, LIMB_FREEDOM, Part};
use crate::learning::annealing::NARROWEST;
use crate::learning::least_squares::LeastSquares;
use crate::learning::online::{Belief, fit_again};
use crate::learning::prediction::GapRow;
use crate::learning::surface_gap::{SHARPEST, SurfaceGap};
use crate::learning::touch_set::TouchProblem;
use crate::learning::{AxisModel, Parameters};
use crate::schema::BodySchema;

/// Touches that others check which a joint needs, …
const CHECKED_OF_JOINT: f64 = 5.0;
/// … and a limb.
const CHECKED_OF_LIMB: f64 = 3.0;
/// The most that a known axis may be off, one standard deviation, radians.
const SURE: f64 = 0.02;
/// The leverage from which on no others check a touch.
const UNCHECKED: f64 = 0.8;
/// The fewest touches that anything is learned from.
const FEWEST: usize = 5;
/// Of so many touches one that was closed may open, and …
const FEW_OPEN: usize = 50;
/// … of so many one in all.
const SOME_OPEN: usize = 8;
/// Touches of one pair of limbs with the same joints moving that a fit uses.
const ALIKE: usize = 40;
/// All that an answer may change.
struct Before {
    resolved: Vec<bool>,
    belief: Option<Belief>,
    base: usize,
}

impl Growth<'_> {
    /// Takes a part's answer in, as far as touches check it; whether anything is left of it.
    pub(super) fn accept(&mut self, part: &Part, schema: &BodySchema) -> bool {
        let before = Before { resolved: self.resolved.clone(), belief: self.belief.clone(), base: self.base };
        let closed = |touch: &GrownTouch| self.is_of(touch, part) && self.closes(&touch.prepared, schema);
        let numbers = 0..self.touches.len();
        let mut new: Vec<usize> =
            numbers.filter(|&i| !self.touches[i].used && closed(&self.touches[i])).collect();
        part.joints.iter().for_each(|&joint| self.resolved[joint] = true);
        let stands = self.settle(part, schema.clone(), &mut new, before.belief.is_none());
        if !stands {
            new.iter().for_each(|&number| self.touches[number].used = false);
            (self.resolved, self.belief, self.base) = (before.resolved, before.belief, before.base);
        }
        self.place();
        stands
    }

    /// Fits all with the `new` touches, and leaves out what they do not bear out until the rest stands.
    fn settle(&mut self, part: &Part, mut schema: BodySchema, new: &mut Vec<usize>, first: bool) -> bool {
        let mut joints = part.joints.clone();
        loop {
            new.iter().for_each(|&number| self.touches[number].used = true);
            if new.len() < FEWEST || !self.fit(&schema) {
                return false;
            }
            let Some(belief) = self.belief.clone() else { return false };
            schema = belief.schema.clone();
            // What does not close is no part of it; what was closed must stay so.
            let open = |&number: &usize| {
                let touch = &self.touches[number];
                touch.used && !self.closes(&touch.prepared, &schema)
            };
            let open: Vec<usize> = (0..self.touches.len()).filter(open).collect();
            let used = self.touches.iter().filter(|touch| touch.used).count();
            let opened = open.iter().filter(|number| !new.contains(number)).count();
            if FEW_OPEN * opened > used || SOME_OPEN * open.len() > used {
                return false;
            }
            self.leave_out(new, |_, number| open.contains(&number));
            let leverages = self.leverages(&belief);
            if self.leave_out(new, |_, number| leverages[number] > UNCHECKED) {
                continue;
            }
            let (of_joints, of_limbs) = self.checked(&leverages);
            let doubt = |joint: usize| (1.0 + self.axis_deviation(joint) / SURE) / (of_joints[joint] + 1e-9);
            let doubtful =
                |joint: &usize| of_joints[*joint] < CHECKED_OF_JOINT || self.axis_deviation(*joint) > SURE;
            let worst =
                joints.iter().copied().filter(doubtful).max_by(|&a, &b| doubt(a).total_cmp(&doubt(b)));
            if let Some(worst) = worst {
                joints.retain(|&joint| joint != worst);
                self.resolved[worst] = false;
                if joints.is_empty() && (first || part.limbs.is_empty()) {
                    return false;
                }
                self.leave_out(new, |touch, _| touch.moving.contains(&worst));
                continue;
            }
            let lonely = |limb: &usize| {
                of_limbs[*limb] < CHECKED_OF_LIMB
                    && new.iter().any(|&number| self.touches[number].limbs.contains(limb))
            };
            let limbs = (0..of_limbs.len()).filter(lonely);
            let Some(limb) = limbs.min_by(|&a, &b| of_limbs[a].total_cmp(&of_limbs[b])) else { return true };
            self.leave_out(new, |touch, _| touch.limbs.contains(&limb));
        }
    }

    /// Leaves out some of the new touches; whether there were any.
    fn leave_out(&mut self, new: &mut Vec<usize>, out: impl Fn(&GrownTouch, usize) -> bool) -> bool {
        let before = new.len();
        new.retain(|&number| {
            let leaves = out(&self.touches[number], number);
            self.touches[number].used &= !leaves;
            !leaves
        });
        new.len() < before
    }

    /// Fits all that is used, from a schema that is nearly right; false where rounding forbids.
    fn fit(&mut self, schema: &BodySchema) -> bool {
        let creature = self.agent.creature();
        let mut counts = BTreeMap::new();
        let few = |touch: &&GrownTouch| {
            let count = counts.entry((touch.limbs, touch.moving.clone())).or_insert(0);
            *count += 1;
            *count <= ALIKE
        };
        let used: Vec<&GrownTouch> = self.touches.iter().filter(|touch| touch.used).filter(few).collect();
        let joints = creature.joints().len();
        let (mut between, mut moving) = (vec![false; joints], vec![false; joints]);
        let mut of_limb = vec![0; creature.limbs().len()];
        for touch in &used {
            touch.chain.iter().for_each(|&joint| between[joint] = true);
            touch.moving.iter().for_each(|&joint| moving[joint] = true);
            touch.limbs.iter().for_each(|&limb| of_limb[limb] += 1);
        }
        let set = self.set(used.into_iter());
        if self.belief.is_none() {
            self.base = (0..of_limb.len()).max_by_key(|&limb| of_limb[limb]).unwrap_or(0);
        }
        let parameters =
            Parameters::of(creature, AxisModel::Unit, |joint| between[joint], |joint, _| moving[joint]);
        let skin = self.agent.skin();
        let (schema, deviation) =
            fit_again(self.agent, &set, &parameters, &self.prior, schema.clone(), NARROWEST);
        let deviation = deviation.max(SHARPEST);
        // A place in a patch is no evidence, nor a touch that stays open, however little it weighs among sharp ones.
        let set = set.filter_touches(|touch| self.closes(touch, &schema));
        let model = SurfaceGap::new(skin, deviation).without_places();
        let evidence = TouchProblem::new(creature, &set, &parameters, model)
            .with_prior(&self.prior)
            .linearize(&schema)
            .hessian;
        let belief = Belief::new(schema, parameters, evidence, deviation);
        let fitted = belief.is_some();
        self.belief = belief.or(self.belief.take());
        fitted
    }

    /// Per touch that is used, the share of its gap that the fit takes up.
    fn leverages(&self, belief: &Belief) -> Vec<f64> {
        let mut row = GapRow::default();
        let leverage = |touch: &GrownTouch| {
            if !touch.used {
                return 0.0;
            }
            row.set(self.agent.skin(), &belief.parameters, &belief.schema, &touch.prepared);
            (row.variance(&belief.covariance) / belief.deviation.powi(2)).min(1.0)
        };
        self.touches.iter().map(leverage).collect()
    }

    /// Per joint and per limb, how many of the touches that tell of it are checked by others.
    fn checked(&self, leverages: &[f64]) -> (Vec<f64>, Vec<f64>) {
        let mut of_joints = vec![0.0; self.resolved.len()];
        let mut of_limbs = vec![0.0; self.placement.len()];
        for (touch, leverage) in self.touches.iter().zip(leverages).filter(|(touch, _)| touch.used) {
            if touch.freedom >= FREEDOM {
                touch.moving.iter().for_each(|&joint| of_joints[joint] += 1.0 - leverage);
            }
            if touch.freedom >= LIMB_FREEDOM {
                touch.limbs.iter().for_each(|&limb| of_limbs[limb] += 1.0 - leverage);
            }
        }
        (of_joints, of_limbs)
    }

    /// The greatest standard deviation of a joint's axes across their directions, radians.
    pub fn axis_deviation(&self, joint: usize) -> f64 {
        let deviation = |dof: usize| match &self.belief {
            Some(belief) => belief.parameters.axes[dof].map_or(f64::INFINITY, |place| {
                let covariance = &belief.covariance;
                covariance[(place, place)].max(covariance[(place + 1, place + 1)]).sqrt()
            }),
            None => f64::INFINITY,
        };
        let elements = self.agent.creature().joints()[joint].elements().filter(|at| !at.is_ball());
        elements.map(|at| deviation(at.axis())).fold(0.0, f64::max)
    }
}
