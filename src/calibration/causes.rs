//! What else a fit's residuals would be explained by: quantities that were taken to be known, encoders that do not follow their
//! joints, mounts that slipped.
//!
//! With the whitened residuals `y` at a fit and the columns `A` of what was fitted, columns `B` of another cause take
//!
//! ```text
//! sᵀ G⁻¹ s,   s = Bᵀy,   G = BᵀB − BᵀA (AᵀA)⁻¹ AᵀB
//! ```
//!
//! off `yᵀy` (Rao's score test). In units of log-likelihood that is `ν/2 ln(yᵀy / (yᵀy − sᵀG⁻¹s))` for `ν` equations beyond the
//! unknowns, whatever the noise is; from it the half of `ln N` is taken for each column (Schwarz, "Estimating the dimension of a
//! model", 1978). What stands out is fitted for itself.

use std::collections::{BTreeSet, HashMap};
use std::mem::discriminant;

use nalgebra::Vector3;
use rayon::prelude::*;

use super::estimate::Fit;
use super::noise::{Noise, Seen};
use super::problem::{Estimator, add_to};
use super::robot::{DofQuantities, Element, Knowledge, Quantity, Robot, Value};
use super::told::Told;
use super::touch::{Feature, Touch};
use crate::creature::DofKind;
use crate::learning::least_squares::Linearization;

/// Evidence that is believed, as a logarithm: among some hundred causes one in thousands of logs has as much by chance, …
const BELIEVED: f64 = 12.0;
/// … if what is left falls by this share of its mean square: real touches are never all noise.
const WORTHWHILE: f64 = 0.1;
/// Causes of each kind that are fitted for themselves at the most, the likeliest first.
const FITTED: usize = 5;
/// An encoder may not follow its joint if what is left along its motion is so many deviations more than elsewhere; …
const ASTRAY: f64 = 5.0;
/// … fewer where it reads the same all the time, to this angle or length.
const ASTRAY_AND_STILL: f64 = 2.0;
const STILL: f64 = 1e-3;
/// What it counts for each equation that an encoder reads the same all the time: far off, a motion along a joint is no straight line,
/// and what it explains is little of what it is.
const STILL_COUNTS: f64 = 0.5;
/// How far an encoder that does not follow its joint is off, radians and metres: about half of what joints move by.
const DEAD_ANGLE: f64 = 0.5;
const DEAD_SHIFT: f64 = 0.1;
/// Touches that are looked at, and that causes are fitted to, at the most.
const TOUCHES: usize = 1000;
const REFITTED: usize = 200;
/// Parts of a log at whose ends a mount or an encoder may have slipped.
const PARTS: usize = 4;
/// The least share of its information that a column must have of its own, beside what was fitted.
const OWN: f64 = 1e-6;

/// What may be wrong with a robot or its log beside what was said to be unknown.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Cause {
    /// A quantity that was taken to be known.
    Quantity(usize),
    /// A degree of freedom's encoder counts the other way.
    Reversed(usize),
    /// A degree of freedom's encoder does not follow its joint.
    Dead(usize),
    /// What a degree of freedom's encoder reads is no straight line of the angle.
    Curved(usize),
    /// A quantity changed in the course of the log, at this touch.
    Slipped(usize, usize),
    /// A table of Denavit and Hartenberg's numbers is of the other convention.
    Convention,
}

impl Cause {
    /// Whether it is fitted for itself: of others only the linear look is known.
    pub fn is_fitted(self, robot: &Robot) -> bool {
        match self {
            Cause::Curved(_) => false,
            Cause::Slipped(q, _) => mount_of(robot, q).is_some(),
            _ => true,
        }
    }

    /// The degree of freedom whose encoder it is of.
    fn dof(self, robot: &Robot) -> Option<usize> {
        match self {
            Cause::Quantity(q) | Cause::Slipped(q, _) => {
                let own =
                    |(_, own): &(usize, DofQuantities)| [own.gain, own.offset, own.compliance].contains(&q);
                robot.encoders().find(own).map(|(dof, _)| dof)
            }
            Cause::Curved(dof) | Cause::Dead(dof) | Cause::Reversed(dof) => Some(dof),
            Cause::Convention => None,
        }
    }
}

/// The link that a quantity of a mount places.
fn mount_of(robot: &Robot, quantity: usize) -> Option<usize> {
    let places =
        |element: &Element| matches!(*element, Element::Shift(q) | Element::Turn(q) if q == quantity);
    robot.links.iter().position(|link| link.elements.iter().any(places))
}

/// A cause, and what it explains.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Explanation {
    /// The cause.
    pub cause: Cause,
    /// How much likelier the touches are with it, as a logarithm, less the price of its numbers.
    pub evidence: f64,
    /// By which share the mean square of what is left falls.
    pub share: f64,
}

impl Explanation {
    /// Whether it is to be believed.
    pub fn stands_out(&self) -> bool {
        self.evidence > BELIEVED && self.share > WORTHWHILE
    }
}

/// The causes of a fit's residuals that a linear look at them finds, the likeliest first.
pub fn explanations(estimator: &Estimator, fit: &Fit) -> Vec<Explanation> {
    let (robot, own) = (estimator.robot, &estimator.unknowns);
    let mut open = robot.clone();
    open.quantities.iter_mut().for_each(|quantity| quantity.knowledge = [Knowledge::Free; 3]);
    let of_all = estimator.of_robot(&open);
    let seen = of_all.seen(&fit.values, &fit.noise);
    let all = &of_all.unknowns;
    let extra = extra_columns(&of_all, &seen);
    let mut total = Linearization::nothing(all.len() + extra.len());
    let (mut squares, mut equations) = (0.0, 0.0);
    for seen in seen.iter().step_by(seen.len().div_ceil(TOUCHES).max(1)) {
        let (weight, value) = (fit.noise.weight(seen), seen.residuals.value);
        let mut slopes = seen.residuals.slopes.clone();
        let posture = &estimator.touches[seen.touch].posture;
        for (k, column) in extra.iter().enumerate() {
            let factor = column.factor(robot, seen.touch, posture);
            let of = seen.residuals.slopes.iter().filter(|(at, _)| *at == column.of && factor != 0.0);
            slopes.extend(of.map(|(_, slope)| (all.len() + k, slope * factor)));
        }
        add_to(&mut total, &slopes, &value, &weight);
        squares += value.dot(&(weight * value));
        equations += fit.noise.inlier_probability(seen) * seen.size();
    }
    total.hessian.fill_upper_triangle_with_lower_triangle();
    // What stayed as it was is as if it had been known.
    let free = |place: &usize| !fit.told.dependent.contains(place) && !fit.told.ties.contains(&vec![*place]);
    let mut fitted = Vec::new();
    for place in (0..own.len()).filter(free) {
        let (q, component) = own.parameters[place];
        let Some(at) = all.place(q, component) else { continue };
        fitted.push(at);
        // What was said of it is a row.
        if let Some(deviation) = own.deviation_before(place) {
            let off = own.off(robot, &fit.values, place);
            total.hessian[(at, at)] += deviation.powi(-2);
            total.gradient[at] += off / deviation.powi(2);
            squares += (off / deviation).powi(2);
            equations += 1.0;
        }
    }
    let selected =
        |rows: &[usize], columns: &[usize]| total.hessian.select_rows(rows).select_columns(columns);
    let Some(factor) = selected(&fitted, &fitted).cholesky() else { return Vec::new() };
    let slope = total.gradient.select_rows(&fitted);
    // What the fit would still take off.
    let rest = factor.solve(&slope);
    squares -= slope.dot(&rest);
    // What columns take off the sum of squares, and how many of them say anything of their own.
    let gain = |columns: &[usize]| {
        let across = selected(&fitted, columns);
        let left = selected(columns, columns) - across.tr_mul(&factor.solve(&across));
        let own = |k: &usize| left[(*k, *k)] > OWN * total.hessian[(columns[*k], columns[*k])];
        let own: Vec<usize> = (0..columns.len()).filter(own).collect();
        let told = Told::above(&left.select_rows(&own).select_columns(&own), OWN);
        let slope = total.gradient.select_rows(columns) - across.tr_mul(&rest);
        let slope = slope.select_rows(&own);
        (slope.dot(&(&told.covariance * &slope)), own.len() - told.dependent.len())
    };
    let known = (0..robot.quantities.len()).map(|q| {
        let of = |component: &usize| own.place(q, *component).is_none();
        (Cause::Quantity(q), (0..3).filter(of).filter_map(|component| all.place(q, component)).collect())
    });
    let further = extra.chunk_by(|a, b| a.cause == b.cause).scan(all.len(), |next, columns| {
        *next += columns.len();
        Some((columns[0].cause, (*next - columns.len()..*next).collect()))
    });
    let looked = known.chain(further).filter_map(|(cause, columns): (Cause, Vec<usize>)| {
        let (gain, columns) = gain(&columns);
        let share = (gain / squares).clamp(0.0, 1.0 - 1e-12);
        let spare = equations - (fitted.len() + columns) as f64;
        let evidence = -0.5 * spare * (1.0 - share).ln() - 0.5 * columns as f64 * equations.max(2.0).ln();
        (columns > 0 && spare > 1.0).then_some(Explanation { cause, evidence, share })
    });
    let mut found: Vec<Explanation> = looked.chain(dead_encoders(estimator, fit, &seen)).collect();
    found.sort_by(|a, b| b.evidence.total_cmp(&a.evidence));
    found
}

/// A column beside those of the robot's parameters: that of one of them, by a factor that differs from touch to touch.
struct Column {
    cause: Cause,
    /// The place of the parameter.
    of: usize,
    /// Which of its cause's columns.
    part: usize,
}

impl Column {
    fn factor(&self, robot: &Robot, touch: usize, posture: &[f64]) -> f64 {
        match self.cause {
            Cause::Curved(dof) => {
                let (sine, cosine) = posture[robot.dofs[dof].coordinate].sin_cos();
                [sine, cosine][self.part]
            }
            Cause::Slipped(_, from) if touch < from => 0.0,
            _ => 1.0,
        }
    }
}

/// Curves of encoders, and what changes in the course of the log of encoders and of what is mounted.
fn extra_columns(of_all: &Estimator, seen: &[Seen]) -> Vec<Column> {
    let (robot, all, lines) = (of_all.robot, &of_all.unknowns, of_all.touches.len());
    let mut columns = Vec::new();
    for (dof, q) in robot.encoders().filter(|(dof, _)| robot.dofs[*dof].kind == DofKind::Hinge) {
        let of = all.places(q.offset).next().unwrap_or_default();
        columns.extend([0, 1].map(|part| Column { cause: Cause::Curved(dof), of, part }));
    }
    let slopes = seen.iter().flat_map(|seen| &seen.residuals.slopes);
    let felt: BTreeSet<usize> = slopes.map(|(place, _)| all.parameters[*place].0).collect();
    let offsets = robot.encoders().map(|(_, q)| q.offset);
    let moves = |element: &Element| matches!(element, Element::Dof(_));
    let at_rest = robot.links.iter().filter(|link| !link.elements.iter().any(moves));
    let mounts = at_rest.flat_map(|link| &link.elements).filter_map(|element| match element {
        Element::Shift(q) | Element::Turn(q) => Some(*q),
        _ => None,
    });
    for q in offsets.chain(mounts).filter(|q| felt.contains(q)) {
        for from in (1..PARTS).map(|part| part * lines / PARTS) {
            let of = all.places(q).enumerate();
            columns.extend(of.map(|(part, of)| Column { cause: Cause::Slipped(q, from), of, part }));
        }
    }
    columns
}

/// Encoders along whose joints' motion much more is left than elsewhere, and what a variance of their own would explain.
fn dead_encoders(estimator: &Estimator, fit: &Fit, seen: &[Seen]) -> Vec<Explanation> {
    let equations: f64 = seen.iter().map(Seen::size).sum();
    let still = still_encoders(estimator, fit);
    let one = |(dof, _)| {
        let of_touch = |seen: &Seen| {
            let slope = seen.along(dof);
            let weighed = fit.noise.weight(seen) * slope;
            (slope != Vector3::zeros())
                .then(|| (weighed.dot(&slope), weighed.dot(&seen.residuals.value).powi(2)))
        };
        let found: Vec<(f64, f64)> = seen.iter().filter_map(of_touch).collect();
        let beyond: f64 = found.iter().map(|(expected, square)| square - expected).sum();
        let deviation = (2.0 * found.iter().map(|(expected, _)| expected * expected).sum::<f64>()).sqrt();
        let astray = beyond / deviation.max(f64::MIN_POSITIVE);
        let bound = if still.contains(&dof) { ASTRAY_AND_STILL } else { ASTRAY };
        // As evidence that of a normal deviate; the fit for itself says what it is worth.
        let (evidence, share) = (0.5 * astray * astray, beyond / equations.max(1.0));
        (found.len() > 1 && astray > bound).then_some(Explanation {
            cause: Cause::Dead(dof),
            evidence,
            share,
        })
    };
    estimator.robot.encoders().filter_map(one).collect()
}

/// Degrees of freedom between what touched whose encoders read the same all the time.
pub fn still_encoders(estimator: &Estimator, fit: &Fit) -> Vec<usize> {
    let robot = estimator.robot;
    let is_still = |dof: &usize| {
        let felt = fit.seen.iter().filter(|seen| seen.along(*dof) != Vector3::zeros());
        let read: Vec<f64> =
            felt.map(|seen| estimator.touches[seen.touch].posture[robot.dofs[*dof].coordinate]).collect();
        read.len() > 1 && read.iter().all(|x| (x - read[0]).abs() < STILL)
    };
    robot.encoders().map(|(dof, _)| dof).filter(is_still).collect()
}

/// The explanation that is the likeliest when each is fitted for itself; encoders that are still, those that may count the other way
/// and the other convention are tried whatever a linear look says.
pub fn best_explanation(
    estimator: &Estimator,
    fit: &Fit,
    found: &[Explanation],
    still: &[usize],
) -> Option<Explanation> {
    let robot = estimator.robot;
    let is_still = |cause: Cause| matches!(cause, Cause::Dead(dof) if still.contains(&dof));
    let mut of_kind = HashMap::new();
    let mut chosen: Vec<Explanation> = found.to_vec();
    chosen.retain(|found| {
        let count = of_kind.entry(discriminant(&found.cause)).or_insert(0);
        *count += 1;
        *count <= FITTED && !is_still(found.cause)
    });
    // An encoder that counts the other way is where its own numbers explain most.
    let mut turned: Vec<usize> = Vec::new();
    for dof in found.iter().filter_map(|found| found.cause.dof(robot)) {
        let known = |own: DofQuantities| !robot.quantities[own.sign].is_open();
        if robot.dofs[dof].quantities.is_some_and(known) && !turned.contains(&dof) {
            turned.push(dof);
        }
    }
    let dead = still.iter().take(FITTED).map(|dof| Cause::Dead(*dof));
    let turned = turned.into_iter().take(2 * FITTED).map(Cause::Reversed);
    let unseen = dead.chain(turned).chain([Cause::Convention]);
    chosen.extend(unseen.map(|cause| Explanation { cause, evidence: 0.0, share: 0.0 }));
    // Few touches show as well which is the likeliest.
    let step = estimator.touches.len().div_ceil(REFITTED).max(1);
    let touches: Vec<Touch> = estimator.touches.iter().step_by(step).cloned().collect();
    let fewer = Estimator::new(robot, &touches, estimator.options);
    let of_fewer = (step > 1).then(|| {
        let noise = fewer.noise_at(&fit.values, fit.noise.joint);
        fewer.settled(fit.values.clone(), noise, fit.noise.false_share > 0.0)
    });
    let fit = of_fewer.as_ref().unwrap_or(fit);
    let equations: f64 = fit.seen.iter().map(Seen::size).sum();
    let all_of_them = fit.redundancy().equations;
    let fitted = chosen.into_par_iter().map(|found| {
        let Some((cost, columns)) = fitted(&fewer, fit, found.cause, step) else { return found };
        let gain = fit.cost - cost;
        let share = 1.0 - (-2.0 * gain / equations.max(1.0)).exp();
        let mut evidence = gain - 0.5 * columns as f64 * equations.max(2.0).ln();
        if is_still(found.cause) && evidence > 0.0 {
            evidence += STILL_COUNTS * all_of_them;
        }
        Explanation { evidence: step as f64 * evidence, share, ..found }
    });
    fitted.collect::<Vec<_>>().into_iter().max_by(|a, b| a.evidence.total_cmp(&b.evidence))
}

/// What a fit with a cause costs, and how many numbers it has more; of every how manieth touch the estimator's are. `None` of what is not
/// fitted for itself.
fn fitted(estimator: &Estimator, fit: &Fit, cause: Cause, step: usize) -> Option<(f64, usize)> {
    let mut robot = estimator.robot.clone();
    let mut touches = estimator.touches.to_vec();
    let nominal = robot.nominal();
    let mut starts = vec![fit.values.clone(), nominal.clone()];
    let mut dead = None;
    let columns = match cause {
        Cause::Quantity(q) => {
            robot.quantities[q].knowledge = [Knowledge::Free; 3];
            nominal[q].size()
        }
        Cause::Reversed(dof) => {
            let q = robot.dofs[dof].quantities?;
            for values in &mut starts {
                values[q.sign] = Value::Number(-values[q.sign].number());
                values[q.offset] = nominal[q.offset];
            }
            let afar = starts.pop()?;
            starts.push(estimator.approach(afar).0);
            1
        }
        Cause::Dead(dof) => {
            let deviation = if robot.dofs[dof].kind == DofKind::Slide { DEAD_SHIFT } else { DEAD_ANGLE };
            dead = Some((dof, deviation));
            1
        }
        Cause::Convention => {
            robot = robot.of_other_convention()?;
            starts[0] = Estimator::new(&robot, &touches, estimator.options).approach(nominal).0;
            0
        }
        Cause::Slipped(q, from) => {
            let link = mount_of(&robot, q)?;
            // A second mount, for what touched from there on.
            let mut values = fit.values.clone();
            let mut elements = robot.links[link].elements.clone();
            for element in &mut elements {
                if let Element::Shift(own) | Element::Turn(own) = element {
                    let free = Quantity { knowledge: [Knowledge::Free; 3], ..robot.quantities[*own].clone() };
                    robot.quantities.push(free);
                    values.push(fit.values[*own]);
                    *own = values.len() - 1;
                }
            }
            let second = robot.add_link(String::new(), robot.links[link].parent, elements);
            for end in touches[from / step..].iter_mut().flat_map(|touch| &mut touch.ends).flatten() {
                match &mut end.feature {
                    Feature::Point(on, _) if *on == link => *on = second,
                    _ => {}
                }
            }
            let columns = values[nominal.len()..].iter().map(Value::size).sum();
            starts = vec![values];
            columns
        }
        Cause::Curved(_) => return None,
    };
    let estimator = Estimator::new(&robot, &touches, estimator.options);
    let costs = starts.into_iter().map(|start| {
        let noise = Noise { dead, ..estimator.noise_at(&start, fit.noise.joint) };
        estimator.settled(start, noise, fit.noise.false_share > 0.0).cost
    });
    Some((costs.min_by(f64::total_cmp)?, columns))
}
