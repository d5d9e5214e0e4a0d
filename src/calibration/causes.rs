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

use nalgebra::{DMatrix, DVector, Vector3};
use rayon::prelude::*;

use super::estimate::{Estimator, Fit};
use super::noise::{DeadEncoder, Seen, along};
use super::problem::add_to;
use super::robot::{Element, Knowledge, Quantity, Robot, Value};
use super::touch::{Feature, Touch};
use super::unknowns::Unknowns;
use crate::creature::DofKind;
use crate::learning::least_squares::Linearization;

/// Evidence that is believed, as a logarithm: among some hundred causes one in thousands of logs has as much by chance, …
const BELIEVED: f64 = 12.0;
/// … if what is left falls by this share of its mean square: real touches are never all noise.
const WORTHWHILE: f64 = 0.1;
/// Causes of each kind that are fitted for themselves at the most, the likeliest first: where a pattern names them, and where all is
/// far off.
const FITTED: usize = 2;
const FITTED_FROM_AFAR: usize = 5;
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
    /// A quantity that was taken to be known, or nearly so.
    Quantity(usize),
    /// A degree of freedom's encoder counts the other way.
    Reversed(usize),
    /// A degree of freedom's encoder does not follow its joint.
    Dead(usize),
    /// What a degree of freedom's encoder reads is no straight line of the angle.
    Curved(usize),
    /// A quantity changed in the course of the log, at this line.
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

/// Columns of one cause, as places in the normal equations of all.
struct Candidate {
    cause: Cause,
    columns: Vec<usize>,
}

/// The causes of a fit's residuals that a linear look at them finds, the likeliest first.
pub fn explanations(estimator: &Estimator, fit: &Fit) -> Vec<Explanation> {
    let mut open = estimator.robot.clone();
    open.quantities.iter_mut().for_each(|quantity| quantity.knowledge = [Knowledge::Free; 3]);
    let all = Unknowns::of(&open);
    let seen = estimator.seen_by(&open, &all, fit);
    let (extra, count) =
        extra_candidates(estimator, &all, seen.iter().flat_map(|(_, _, seen)| &seen.residuals.slopes));
    let mut total = Linearization::nothing(count);
    let (mut squares, mut equations) = (0.0, 0.0);
    let step = seen.len().div_ceil(TOUCHES).max(1);
    for (touch, _, seen) in seen.iter().step_by(step) {
        let honesty = fit.noise.honesty(seen);
        let Some(inverse) = fit.noise.covariance(seen).try_inverse() else { continue };
        let (weight, value) = (inverse * honesty, seen.residuals.value);
        let slopes = with_extra((estimator, &all), &extra, *touch, seen);
        add_to(&mut total, &slopes, &value, &weight);
        squares += value.dot(&(weight * value));
        equations += honesty * seen.residuals.size as f64;
    }
    total.hessian.fill_upper_triangle_with_lower_triangle();
    let own = &estimator.unknowns;
    // The places of what was fitted; what stayed as it was is as if it had been known.
    let free = |place: &usize| !fit.told.dependent.contains(place) && !fit.told.ties.contains(&vec![*place]);
    let fitted: Vec<usize> = (0..own.len()).filter(free).collect();
    let places: Vec<usize> = fitted
        .iter()
        .filter_map(|place| {
            let (q, component) = own.parameters[*place];
            all.place(q, component)
        })
        .collect();
    let mut information =
        DMatrix::from_fn(places.len(), places.len(), |i, j| total.hessian[(places[i], places[j])]);
    let mut slope = DVector::from_fn(places.len(), |i, _| total.gradient[places[i]]);
    let mut pulled: Vec<(usize, f64)> = Vec::new();
    for (k, place) in fitted.iter().enumerate() {
        let Some(deviation) = own.deviation_before(*place) else { continue };
        let off = own.off(estimator.robot, &fit.values, *place);
        information[(k, k)] += deviation.powi(-2);
        slope[k] += off / deviation.powi(2);
        squares += (off / deviation).powi(2);
        equations += 1.0;
        pulled.extend(
            own.pulled(estimator.robot, &fit.values, &fit.told.covariance, *place)
                .map(|gain| (own.parameters[*place].0, gain)),
        );
    }
    let left = equations - fitted.len() as f64;
    let Some(factor) = information.cholesky() else { return Vec::new() };
    // What the fit would still take off.
    let rest = factor.solve(&slope);
    squares -= slope.dot(&rest);
    let mut found: Vec<Explanation> = Vec::new();
    let mut add = |cause: Cause, gain: f64, columns: usize| {
        let nu = left - columns as f64;
        if columns > 0 && nu > 1.0 {
            let share = (gain / squares).clamp(0.0, 1.0 - 1e-12);
            let evidence = -0.5 * nu * (1.0 - share).ln() - 0.5 * columns as f64 * equations.max(2.0).ln();
            found.push(Explanation { cause, evidence, share });
        }
    };
    for (q, gain) in pulled {
        add(Cause::Quantity(q), gain, 1);
    }
    let known = estimator.robot.quantities.iter().enumerate().map(|(q, quantity)| {
        let of = |component: &usize| own.place(q, *component).is_none();
        let columns = (0..quantity.nominal.size()).filter(of).filter_map(|component| all.place(q, component));
        Candidate { cause: Cause::Quantity(q), columns: columns.collect() }
    });
    for candidate in known.chain(extra) {
        let (gain, columns) = gain_of(&total, (&places, &rest), &factor, &candidate.columns);
        add(candidate.cause, gain, columns);
    }
    found.extend(dead_encoders(estimator, fit, &seen));
    found.sort_by(|a, b| b.evidence.total_cmp(&a.evidence));
    found
}

/// What columns take off the sum of squares, and how many of them say anything of their own.
fn gain_of(
    total: &Linearization,
    (fitted, rest): (&[usize], &DVector<f64>),
    factor: &nalgebra::Cholesky<f64, nalgebra::Dyn>,
    columns: &[usize],
) -> (f64, usize) {
    let across = DMatrix::from_fn(fitted.len(), columns.len(), |i, j| total.hessian[(fitted[i], columns[j])]);
    let solved = factor.solve(&across);
    let mut left =
        DMatrix::from_fn(columns.len(), columns.len(), |i, j| total.hessian[(columns[i], columns[j])]);
    let whole = left.diagonal();
    left -= across.tr_mul(&solved);
    let mut slope = DVector::from_fn(columns.len(), |i, _| total.gradient[columns[i]]);
    slope -= across.tr_mul(rest);
    let (mut gain, mut count) = (0.0, 0);
    for k in 0..columns.len() {
        if left[(k, k)] <= OWN * whole[k] || whole[k] == 0.0 {
            continue;
        }
        gain += slope[k].powi(2) / left[(k, k)];
        count += 1;
        for i in k + 1..columns.len() {
            let by = left[(i, k)] / left[(k, k)];
            slope[i] -= by * slope[k];
            for j in k + 1..columns.len() {
                left[(i, j)] -= by * left[(k, j)];
            }
        }
    }
    (gain, count)
}

/// The columns beside those of the robot's parameters, behind them, and how many there are together: curves of encoders, and what
/// changes in the course of the log of encoders and of what is mounted.
fn extra_candidates<'a>(
    estimator: &Estimator,
    all: &Unknowns,
    slopes: impl Iterator<Item = &'a (usize, Vector3<f64>)>,
) -> (Vec<Candidate>, usize) {
    let robot = estimator.robot;
    let mut candidates = Vec::new();
    let mut next = all.len();
    let mut add = |cause: Cause, columns: usize| {
        candidates.push(Candidate { cause, columns: (next..next + columns).collect() });
        next += columns;
    };
    for (dof, about) in robot.dofs.iter().enumerate() {
        if about.kind == DofKind::Hinge {
            add(Cause::Curved(dof), 2);
        }
    }
    let felt: std::collections::BTreeSet<usize> = slopes.map(|(place, _)| all.parameters[*place].0).collect();
    let offsets = robot.dofs.iter().filter_map(|dof| Some(dof.quantities?.offset));
    let at_rest = robot
        .links
        .iter()
        .filter(|link| !link.elements.iter().any(|element| matches!(element, Element::Dof(_))));
    let mounts = at_rest.flat_map(|link| &link.elements).filter_map(|element| match element {
        Element::Shift(q) | Element::Turn(q) => Some(*q),
        _ => None,
    });
    let lines = estimator.touches().len();
    for q in offsets.chain(mounts).filter(|q| felt.contains(q)) {
        for part in 1..PARTS {
            add(Cause::Slipped(q, part * lines / PARTS), robot.quantities[q].nominal.size());
        }
    }
    (candidates, next)
}

/// The slopes of a touch by all columns.
fn with_extra(
    (estimator, all): (&Estimator, &Unknowns),
    extra: &[Candidate],
    touch: usize,
    seen: &Seen,
) -> Vec<(usize, Vector3<f64>)> {
    let mut slopes = seen.residuals.slopes.clone();
    let posture = &estimator.touches()[touch].posture;
    for Candidate { cause, columns } in extra {
        match *cause {
            Cause::Curved(dof) => {
                let slope = along(seen, dof);
                let (sine, cosine) = posture[estimator.robot.dofs[dof].coordinate].sin_cos();
                if slope != Vector3::zeros() {
                    slopes.extend([(columns[0], slope * sine), (columns[1], slope * cosine)]);
                }
            }
            Cause::Slipped(q, from) if touch >= from => {
                for (component, column) in columns.iter().enumerate() {
                    let of = |(place, _): &&(usize, Vector3<f64>)| Some(*place) == all.place(q, component);
                    slopes
                        .extend(seen.residuals.slopes.iter().filter(of).map(|(_, slope)| (*column, *slope)));
                }
            }
            _ => {}
        }
    }
    slopes
}

/// Encoders along whose joints' motion much more is left than elsewhere, and what a variance of their own would explain.
fn dead_encoders(estimator: &Estimator, fit: &Fit, seen: &[super::SeenTouch]) -> Vec<Explanation> {
    let robot = estimator.robot;
    let equations: f64 = seen.iter().map(|(_, _, seen)| seen.residuals.size as f64).sum();
    let one = |(dof, about): (usize, &super::robot::RobotDof)| {
        about.quantities?;
        let of_touch = |(touch, _, seen): &super::SeenTouch| {
            let slope = along(seen, dof);
            let weighed = fit.noise.covariance(seen).try_inverse()? * slope * fit.noise.honesty(seen);
            let read = estimator.touches()[*touch].posture[about.coordinate];
            (slope != Vector3::zeros())
                .then(|| (weighed.dot(&slope), weighed.dot(&seen.residuals.value).powi(2), read))
        };
        let found: Vec<(f64, f64, f64)> = seen.iter().filter_map(of_touch).collect();
        let (least, most) =
            found.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(least, most), (_, _, read)| {
                (least.min(*read), most.max(*read))
            });
        let beyond: f64 = found.iter().map(|(expected, square, _)| square - expected).sum();
        let deviation = (2.0 * found.iter().map(|(expected, ..)| expected * expected).sum::<f64>()).sqrt();
        let astray = beyond / deviation.max(f64::MIN_POSITIVE);
        let bound = if most - least < STILL { ASTRAY_AND_STILL } else { ASTRAY };
        // As evidence that of a normal deviate; the fit for itself says what it is worth.
        let share = beyond / equations.max(1.0);
        (found.len() > 1 && astray > bound).then_some(Explanation {
            cause: Cause::Dead(dof),
            evidence: 0.5 * astray * astray,
            share,
        })
    };
    robot.dofs.iter().enumerate().filter_map(one).collect()
}

/// Degrees of freedom between what touched whose encoders read the same all the time.
pub fn still_encoders(estimator: &Estimator, fit: &Fit) -> Vec<usize> {
    let robot = estimator.robot;
    let is_still = |dof: &usize| {
        let felt = fit.seen.iter().filter(|(_, _, seen)| along(seen, *dof) != Vector3::zeros());
        let read: Vec<f64> = felt
            .map(|(touch, ..)| estimator.touches()[*touch].posture[robot.dofs[*dof].coordinate])
            .collect();
        read.len() > 1 && read.iter().all(|x| (x - read[0]).abs() < STILL)
    };
    (0..robot.dofs.len()).filter(|dof| robot.dofs[*dof].quantities.is_some()).filter(is_still).collect()
}

/// The explanation that is the likeliest when each is fitted for itself; `afar` where what is left is no small pattern.
pub fn best_explanation(
    estimator: &Estimator,
    fit: &Fit,
    found: &[Explanation],
    afar: bool,
) -> Option<Explanation> {
    let robot = estimator.robot;
    let most = if afar { FITTED_FROM_AFAR } else { FITTED };
    let kinds: [fn(&Cause) -> bool; 4] = [
        |cause| matches!(cause, Cause::Quantity(_)),
        |cause| matches!(cause, Cause::Dead(_)),
        |cause| matches!(cause, Cause::Curved(_)),
        |cause| matches!(cause, Cause::Slipped(..)),
    ];
    let mut chosen: Vec<Explanation> = Vec::new();
    for of_kind in kinds {
        chosen.extend(found.iter().filter(|found| of_kind(&found.cause)).take(most).copied());
    }
    let other = |cause| Explanation { cause, evidence: 0.0, share: 0.0 };
    if afar {
        // An encoder that counts the other way is where its own numbers explain most.
        let of_dof = |found: &Explanation| match found.cause {
            Cause::Quantity(q) | Cause::Slipped(q, _) => robot.dofs.iter().position(|dof| {
                dof.quantities.is_some_and(|own| [own.gain, own.offset, own.compliance].contains(&q))
            }),
            Cause::Curved(dof) | Cause::Dead(dof) => Some(dof),
            Cause::Reversed(_) | Cause::Convention => None,
        };
        let mut turned: Vec<usize> = Vec::new();
        for dof in found.iter().filter_map(of_dof).filter(|dof| robot.dofs[*dof].quantities.is_some()) {
            let known = |own: super::robot::DofQuantities| {
                robot.quantities[own.sign].knowledge[0] == Knowledge::Known
            };
            if robot.dofs[dof].quantities.is_some_and(known) && !turned.contains(&dof) {
                turned.push(dof);
            }
        }
        chosen.extend(turned.into_iter().take(2 * most).map(|dof| other(Cause::Reversed(dof))));
        chosen.push(other(Cause::Convention));
    }
    // Few touches show as well which is the likeliest.
    let step = estimator.touches().len().div_ceil(REFITTED).max(1);
    let touches: Vec<Touch> = estimator.touches().iter().step_by(step).cloned().collect();
    let fewer = Estimator::new(robot, &touches, estimator.options());
    let noise = fewer.noise_at(&fit.values, fit.noise.joint);
    let of_fewer = (step > 1).then(|| fewer.settled(fit.values.clone(), noise, fit.noise.false_share > 0.0));
    let (estimator, fit) = match &of_fewer {
        Some(of_fewer) => (&fewer, of_fewer),
        None => (estimator, fit),
    };
    let still = still_encoders(estimator, fit);
    chosen.retain(|found| !still.iter().any(|dof| found.cause == Cause::Dead(*dof)));
    chosen.extend(still.iter().take(most).map(|dof| other(Cause::Dead(*dof))));
    let equations = fit.redundancy().equations;
    let fitted = chosen.into_par_iter().filter_map(|found| {
        let of_fewer = match found.cause {
            Cause::Slipped(q, from) => Explanation { cause: Cause::Slipped(q, from / step), ..found },
            _ => found,
        };
        let fitted = fitted(estimator, fit, of_fewer)?;
        let counts = matches!(found.cause, Cause::Dead(dof) if fitted.evidence > 0.0 && still.contains(&dof));
        let still = if counts { STILL_COUNTS * equations } else { 0.0 };
        let all = if found.cause.is_fitted(robot) { step as f64 } else { 1.0 };
        Some(Explanation { cause: found.cause, evidence: all * (fitted.evidence + still), ..fitted })
    });
    fitted.collect::<Vec<_>>().into_iter().max_by(|a, b| a.evidence.total_cmp(&b.evidence))
}

/// What a cause explains when it is fitted: itself where it has no fit of its own.
fn fitted(estimator: &Estimator, fit: &Fit, found: Explanation) -> Option<Explanation> {
    let robot = estimator.robot;
    let with_false = fit.noise.false_share > 0.0;
    let again_by = |robot: &Robot, touches: &[Touch], starts: Vec<Vec<Value>>, dead: Option<DeadEncoder>| {
        let estimator = Estimator::new(robot, touches, estimator.options());
        let fits = starts.into_iter().map(|start| {
            let noise = estimator.noise_at(&start, fit.noise.joint);
            estimator.settled(start, super::Noise { dead, ..noise }, with_false)
        });
        fits.min_by(|a, b| a.cost.total_cmp(&b.cost))
    };
    let again = |robot: &Robot, starts, dead| again_by(robot, estimator.touches(), starts, dead);
    let nominal = robot.nominal();
    let (found_fit, columns) = match found.cause {
        Cause::Quantity(q) => {
            let mut open = robot.clone();
            open.quantities[q].knowledge = [Knowledge::Free; 3];
            (again(&open, vec![fit.values.clone(), nominal], None)?, robot.quantities[q].nominal.size())
        }
        Cause::Reversed(dof) => {
            let q = robot.dofs[dof].quantities?;
            let turned = |values: &[Value]| {
                let mut values = values.to_vec();
                values[q.sign] = Value::Number(-values[q.sign].number());
                values[q.offset] = nominal[q.offset];
                values
            };
            let starts = vec![turned(&fit.values), estimator.approach(turned(&nominal)).0];
            (again(robot, starts, None)?, 1)
        }
        Cause::Dead(dof) => {
            let size = if robot.dofs[dof].kind == DofKind::Slide { DEAD_SHIFT } else { DEAD_ANGLE };
            (again(robot, vec![fit.values.clone(), nominal], Some(DeadEncoder { dof, deviation: size }))?, 1)
        }
        Cause::Convention => {
            let other = robot.of_other_convention()?;
            let fit = Estimator::new(&other, estimator.touches(), estimator.options()).fit_from(nominal);
            (fit, 0)
        }
        Cause::Slipped(q, from) => {
            let Some(link) = mount_of(robot, q) else { return Some(found) };
            // A second mount, for what touched from there on.
            let mut slipped = robot.clone();
            let mut values = fit.values.clone();
            let elements = robot.links[link].elements.iter().map(|element| match *element {
                Element::Shift(own) | Element::Turn(own) => {
                    let quantity =
                        Quantity { knowledge: [Knowledge::Free; 3], ..robot.quantities[own].clone() };
                    slipped.quantities.push(quantity);
                    values.push(fit.values[own]);
                    let at = slipped.quantities.len() - 1;
                    if matches!(element, Element::Shift(_)) { Element::Shift(at) } else { Element::Turn(at) }
                }
                other => other,
            });
            let elements = elements.collect();
            let second = slipped.add_link(String::new(), robot.links[link].parent, elements);
            let mut touches = estimator.touches().to_vec();
            for end in touches[from..].iter_mut().flat_map(|touch| &mut touch.ends).flatten() {
                if let Feature::Point(on, point) = end.feature
                    && on == link
                {
                    end.feature = Feature::Point(second, point);
                }
            }
            let columns = values[robot.quantities.len()..].iter().map(Value::size).sum();
            (again_by(&slipped, &touches, vec![values], None)?, columns)
        }
        Cause::Curved(_) => return Some(found),
    };
    let equations: f64 = fit.seen.iter().map(|(_, _, seen)| seen.residuals.size as f64).sum();
    let gain = fit.cost - found_fit.cost;
    let share = 1.0 - (-2.0 * gain / equations.max(1.0)).exp();
    let evidence = gain - 0.5 * columns as f64 * equations.max(2.0).ln();
    Some(Explanation { cause: found.cause, evidence, share })
}
