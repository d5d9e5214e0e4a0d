//! Postures as other programs write them: quaternions of few digits, and angles that look like degrees.

use std::collections::BTreeMap;
use std::path::Path;

use super::RawTouch;
use crate::creature::{Creature, DofElement, DofKind};
use crate::error::Error;
use crate::session::UNIT_LENGTH;
use crate::session::angles::{HingeAngles, wide_ranges};

/// How far from 1 the length of a quaternion may be that was written with few digits; it is then scaled.
const ROUNDED: f64 = 0.01;
/// Points farther from their limb's origin than this, metres, on the median look like millimetres; a single one so many times
/// as far as the median is worth a note …
const FAR: f64 = 10.0;
/// … and a limb that is shorter than this, metres, is taken to be as long.
const LEAST: f64 = 0.05;
/// Share of a degree of freedom's coordinates beyond its range that is worth a note …
const BEYOND_SHARE: f64 = 0.05;
/// … where they are beyond it by more than this, radians and metres.
const BEYOND: f64 = 0.02;

/// Scales quaternions that were rounded when they were written; those that fit to the last digits stay.
pub(super) fn unit_quaternions(creature: &Creature, posture: &mut [f64]) {
    for ball in of_kind(creature, DofKind::Ball) {
        let coordinates = ball.of_mut(posture);
        let length = coordinates.iter().map(|x| x * x).sum::<f64>().sqrt();
        let off = (length - 1.0).abs();
        if off > UNIT_LENGTH && off < ROUNDED {
            coordinates.iter_mut().for_each(|x| *x /= length);
        }
    }
}

/// Every degree of freedom of a kind.
fn of_kind(creature: &Creature, kind: DofKind) -> impl Iterator<Item = DofElement<'_>> {
    creature.elements().filter(move |element| element.kind == kind)
}

/// Refuses angles that most of them are beyond a full turn, and single ones that their joint cannot have; what else looks odd,
/// in sentences: coordinates beyond their ranges, points far from their limbs.
pub(super) fn check(path: &Path, creature: &Creature, touches: &[RawTouch]) -> Result<Vec<String>, Error> {
    let values = |at: usize| touches.iter().map(move |touch| (touch.line, touch.posture[at]));
    let hinges: Vec<HingeAngles> = of_kind(creature, DofKind::Hinge)
        .map(|hinge| {
            let dof = hinge.dof();
            HingeAngles { name: &dof.name, range: dof.range, angles: values(hinge.coordinate()).collect() }
        })
        .collect();
    if let Some((hinge, (line, angle))) = hinges.iter().find_map(|hinge| Some((hinge, hinge.degrees()?))) {
        let message = format!(
            "{} is {angle}, and most angles are beyond a full turn of 6.283 radians: they look like degrees, convert \
             them to radians, and the range as well, or take whole turns off",
            hinge.name
        );
        return Err(Error::content(path, Some(line), message));
    }
    if let Some((line, message)) = hinges.iter().find_map(HingeAngles::impossible) {
        return Err(Error::content(path, Some(line), message));
    }
    let ranges = hinges.iter().map(|hinge| (hinge.name, hinge.range));
    let mut notes: Vec<String> = wide_ranges(ranges).into_iter().collect();
    let angles = hinges.iter().map(Some).chain(std::iter::repeat(None));
    let dofs = of_kind(creature, DofKind::Hinge).chain(of_kind(creature, DofKind::Slide));
    for (at, angles) in dofs.zip(angles) {
        let [low, high] = at.range;
        let values = || values(at.coordinate()).map(|(_, x)| x);
        let beyond = values().filter(|x| *x < low - BEYOND || *x > high + BEYOND).count();
        if beyond as f64 > BEYOND_SHARE * touches.len() as f64 {
            let [least, most] =
                [values().fold(f64::INFINITY, f64::min), values().fold(-f64::INFINITY, f64::max)];
            notes.push(format!(
                "{} goes from {least:.3} to {most:.3}, beyond its range of {low:.3} to {high:.3}, in {beyond} of {} \
                 touches: mend the range in the creature's file, or the angles' sign or zero",
                at.name,
                touches.len()
            ));
        } else {
            notes.extend(angles.and_then(HingeAngles::note));
        }
    }
    notes.extend(far_points(touches));
    Ok(notes)
}

/// The first point that is far from its limb for a point of it, and points that are all far, as sentences.
fn far_points(touches: &[RawTouch]) -> impl Iterator<Item = String> {
    let (mut of_limbs, mut all) = (BTreeMap::<&str, Vec<(usize, f64)>>::new(), Vec::new());
    for (touch, end) in touches.iter().flat_map(|touch| touch.ends.iter().map(move |end| (touch, end))) {
        let Some(distance) = end.point.map(|point| point.norm()) else { continue };
        all.push(distance);
        if let Some(limb) = &end.limb {
            of_limbs.entry(limb).or_default().push((touch.line, distance));
        }
    }
    let one = of_limbs.into_iter().find_map(|(limb, points)| {
        let usual = median(points.iter().map(|(_, distance)| *distance).collect())?.max(LEAST);
        let (line, far) = points.into_iter().find(|(_, distance)| *distance > FAR * usual)?;
        Some(format!(
            "on line {line} the point on {limb} is {far:.3} m from its origin, and half of its points are within {usual:.3} m: \
             mend it, or leave the touch out"
        ))
    });
    let millimetres = median(all).filter(|median| *median > FAR).map(|median| {
        format!(
            "half of the points are more than {median:.0} m from their limb's origin: if they are in millimetres, \
             convert them to metres"
        )
    });
    one.into_iter().chain(millimetres)
}

/// The middle one of some numbers.
fn median(mut numbers: Vec<f64>) -> Option<f64> {
    numbers.sort_by(f64::total_cmp);
    numbers.get(numbers.len() / 2).copied()
}
