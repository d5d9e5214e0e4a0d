//! Second answers of joints that hardly move.
//!
//! What touches tell of an axis `a` that limbs turn about by small angles, or slide along, is linear in it: `g = g₀ + c·a`. Where
//! all `c` lie nearly in a plane, as of a limb that is felt along its side, `|a| = 1` alone tells how the axis lies across that
//! plane, and it has two solutions: the axis and its mirror image `a − 2 (a·d) d`, where `d` is the plane's normal. Each looks
//! as sure as the other to a covariance. So do both ways in which a round limb may turn about itself: gaps tell nothing of that,
//! and the patches that felt what touched tell all.

use nalgebra::{Matrix3, SymmetricEigen, Vector3};

use super::open::FEWEST_FELT;
use super::{CLOSED, Doubt, Member, SHARP, Scrutiny, ToldTouch};
use crate::creature::DofKind;
use crate::learning::annealing::{NARROWEST, quantile, sorted};
use crate::learning::least_squares::Stopping;
use crate::learning::open_gaps::FELT;
use crate::learning::prediction::GapRow;
use crate::learning::surface_gap::SurfaceGap;
use crate::learning::touch_set::TouchProblem;
use crate::learning::{AxisModel, Parameters};
use crate::schema::BodySchema;

/// Hinges whose range is narrower than this hardly turn, radians.
const NARROW: f64 = 0.2;
/// An image that is no farther from the axis, 1, is the same.
const SAME_AXIS: f64 = 5e-3;
/// Most touches that an image is fitted to.
const MOST: usize = 200;
/// Steps of that, at either width of the gap.
const STEPS: usize = 40;
/// An answer that leaves gaps so many times as wide is a worse one, …
const WORSE: f64 = 5.0;
/// … if they are wider than what motions leave that stop at touch, metres.
const STOPPED: f64 = 3e-9;
/// In noise an answer is worse that is less likely by so much, twice the logarithm.
const UNLIKELY: f64 = 9.0;

/// How well a schema explains touches.
struct Misses {
    /// Touches that it leaves open.
    open: usize,
    /// How wide 9 in 10 gaps are at the most, metres.
    width: f64,
    /// The mean square of the gaps that are closed, m².
    square: f64,
    count: usize,
}

impl Scrutiny<'_> {
    /// The first of the joints that hardly move, of which touches tell, whose axes have a mirror image that explains these
    /// as well or better than a schema that was fitted to them; `deviation` is that of a gap, metres.
    pub(super) fn image(&self, told: &[&ToldTouch], schema: &BodySchema, deviation: f64) -> Option<Doubt> {
        let creature = self.agent.creature();
        if self.by_points() {
            return None;
        }
        let mut open = (0..creature.joints().len()).filter(|&joint| !self.known.frozen[joint]);
        open.find_map(|joint| {
            let touches = told.iter().copied();
            let touches: Vec<&ToldTouch> = touches.filter(|touch| touch.moving.contains(&joint)).collect();
            let step = touches.len().div_ceil(MOST).max(1);
            let touches: Vec<&ToldTouch> = touches.into_iter().step_by(step).collect();
            if touches.is_empty() { None } else { self.image_of(joint, &touches, schema, deviation) }
        })
    }

    fn image_of(
        &self,
        joint: usize,
        touches: &[&ToldTouch],
        schema: &BodySchema,
        deviation: f64,
    ) -> Option<Doubt> {
        let creature = self.agent.creature();
        let now = self.misses(touches, schema);
        for at in creature.joints()[joint].elements().filter(|at| !at.is_ball()) {
            let axis = at.axis();
            let is_narrow = at.kind == DofKind::Slide || at.range[1] - at.range[0] < NARROW;
            let mut normals = Vec::new();
            if is_narrow {
                normals.extend(self.normals(axis, touches, schema));
            } else if self.is_unfelt(axis, touches, schema) {
                normals.push(schema.axes[axis]);
            }
            for normal in normals {
                let own = &schema.axes[axis];
                let image = own - normal * (2.0 * own.dot(&normal));
                if (image - own).norm() < SAME_AXIS {
                    continue;
                }
                let mut other = schema.clone();
                other.axes[axis] = image;
                let other = self.fitted_alone(joint, touches, other, deviation);
                if (other.axes[axis] - own).norm() < SAME_AXIS || self.is_unlikely(joint, &other, schema) {
                    continue;
                }
                let then = self.misses(touches, &other);
                if now.is_worse_than(&then, deviation) {
                    return Some(Doubt::Better(joint, other));
                }
                if !then.is_worse_than(&now, deviation) {
                    return Some(Doubt::Of(Member::Joint(joint)));
                }
            }
        }
        None
    }

    /// Whether what was known of a joint before the first touch speaks for one schema and against another.
    fn is_unlikely(&self, joint: usize, schema: &BodySchema, than: &BodySchema) -> bool {
        let parameters = Parameters::new(self.agent.creature(), AxisModel::Unit, |other| other == joint);
        let cost = |schema: &BodySchema| self.known.given.cost(&parameters, schema);
        cost(schema) > cost(than) + UNLIKELY
    }

    /// Whether hardly any of some touches would part, or press, as a hinge turned.
    fn is_unfelt(&self, dof: usize, touches: &[&ToldTouch], schema: &BodySchema) -> bool {
        let feels = |touch: &&&ToldTouch| {
            let mut slopes = touch.prepared.gap_slopes(self.agent.skin(), schema);
            slopes.any(|(other, slope)| other == dof && slope.abs() > FELT)
        };
        touches.iter().filter(feels).count() < FEWEST_FELT
    }

    /// The directions of which touches tell least of an axis, the least first; the last is the one of which they tell most.
    fn normals(&self, axis: usize, touches: &[&ToldTouch], schema: &BodySchema) -> [Vector3<f64>; 2] {
        let free = Parameters::of(self.agent.creature(), AxisModel::Relaxed, |_| false, |_, dof| dof == axis);
        let mut row = GapRow::default();
        let mut told = Matrix3::zeros();
        for touch in touches {
            row.set(self.agent.skin(), &free, schema, &touch.prepared);
            let slope = Vector3::from_iterator(row.entries.iter().map(|(_, slope)| *slope));
            told += slope * slope.transpose();
        }
        let found = SymmetricEigen::new(told);
        let mut order = [0, 1, 2];
        order.sort_by(|&a, &b| found.eigenvalues[a].total_cmp(&found.eigenvalues[b]));
        [order[0], order[1]].map(|k| found.eigenvectors.column(k).into_owned())
    }

    /// A schema in which a joint alone is fitted to touches.
    fn fitted_alone(
        &self,
        joint: usize,
        touches: &[&ToldTouch],
        mut schema: BodySchema,
        deviation: f64,
    ) -> BodySchema {
        let creature = self.agent.creature();
        let parameters = Parameters::new(creature, AxisModel::Unit, |other| other == joint);
        let set = self.set(touches.iter().copied());
        let found = sorted(touches.iter().map(|touch| self.miss(touch, &schema)));
        let widest = quantile(&found, 0.9).max(deviation);
        let narrowest = if deviation > NARROWEST { deviation } else { SHARP };
        for width in [widest, (widest * narrowest).sqrt(), narrowest] {
            let model = SurfaceGap::new(self.agent.skin(), width).without_places();
            let problem = TouchProblem::new(creature, &set, &parameters, model).with_prior(&self.known.prior);
            let stopping = Stopping { iterations: STEPS, relative_cost: 1e-6, ..Stopping::default() };
            schema = problem.fit(schema, stopping);
        }
        schema
    }

    fn misses(&self, touches: &[&ToldTouch], schema: &BodySchema) -> Misses {
        let gaps = sorted(touches.iter().map(|touch| self.felt_gap(CLOSED, touch, schema)));
        let closed: Vec<f64> = gaps.iter().copied().filter(|gap| gap.is_finite()).collect();
        Misses {
            open: gaps.iter().filter(|gap| **gap >= CLOSED).count(),
            width: quantile(&gaps, 0.9),
            square: closed.iter().map(|gap| gap * gap).sum::<f64>() / closed.len().max(1) as f64,
            count: gaps.len(),
        }
    }
}

impl Misses {
    /// Whether another answer explains the same touches better than by chance.
    fn is_worse_than(&self, other: &Misses, deviation: f64) -> bool {
        if deviation > NARROWEST {
            let less_likely = self.count as f64 * (self.square - other.square) / deviation.powi(2);
            return less_likely > UNLIKELY;
        }
        match self.open.cmp(&other.open) {
            std::cmp::Ordering::Greater => other.width < WORSE * self.width.max(STOPPED),
            std::cmp::Ordering::Less => false,
            std::cmp::Ordering::Equal => self.width > STOPPED.max(WORSE * other.width),
        }
    }
}
