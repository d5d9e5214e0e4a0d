//! The verdict on a calibration: a list of [`Objection`]s. Calibrated is what none is raised to.
//!
//! The noise is estimated from the touches, and what is said of it is held against that.

use std::collections::BTreeMap;
use std::fmt;

use nalgebra::Vector3;
use serde::Serialize;

use super::causes::{Cause, Explanation, best_explanation, explanations, still_encoders};
use super::estimate::Fit;
use super::held_out::{HOLDS, Judgement, Misses, mean};
use super::noise::{Noise, Seen};
use super::problem::Estimator;
use super::robot::{Element, Robot, Unit, Value};
use super::touch::Feature;

/// An interval that holds a smaller share of touches than this, and by so many deviations, is none.
const HOLDS_AT_LEAST: f64 = 0.85;
/// Deviations of a chance that is none.
const SURE: f64 = 5.0;
/// Equations beyond the unknowns at the least, and at the least as many as unknowns: with fewer, deviations are known to no digit,
/// and what is wrong explains itself.
const FEWEST_SPARE: f64 = 10.0;
/// Equations beyond what fits itself that must bear on a number.
const FEWEST_BEARING: f64 = 3.0;
/// A robot explains its touches if they are apart by less than this share of what touches in others' postures are, …
const EXPLAINED: f64 = 0.25;
/// … what is less than this share is near the noise, …
const NEAR: f64 = 0.05;
/// … and no more of them are false.
const MOST_FALSE: f64 = 0.4;
/// Far off, one cause is believed that explains this share of the mean square of what is left.
const WHOLE: f64 = 0.9;
/// Of fewer starts that agree, nothing confirms that signs are right.
const CONFIRMED: usize = 2;
/// Noise is contradicted where so many times what is said is left.
const UNDERSTATED: f64 = 1.5;
/// A body that shrinks to less than this explains its touches by being small.
const SHRUNK: f64 = 0.5;

/// What speaks against a calibration.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Question {
    /// Whether there are enough rows.
    Rows,
    /// Whether touches in the postures of others are farther apart.
    Control,
    /// Whether the most of the touches are explained.
    Outliers,
    /// Whether the search for signs of encoders agrees with itself.
    Signs,
    /// Whether as much is left as the log says.
    Noise,
    /// Whether what is nearly known is where it is said to be.
    Prior,
    /// Whether the body is as large as it was.
    Scale,
    /// Whether what is left is noise, or goes with something.
    Pattern,
    /// Whether held-out touches are where they are predicted.
    HeldOut,
}

/// An objection to a calibration: the question, what it is about, and its figure.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Objection {
    /// What was asked.
    pub question: Question,
    /// The joint, quantity or column that it is about.
    pub about: Option<String>,
    /// What was found: rows, metres, a share.
    pub found: f64,
    /// What it is held against, in the same unit.
    pub bound: f64,
    /// All of it in words.
    pub sentence: String,
}

impl fmt::Display for Objection {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str(&self.sentence)
    }
}

impl Question {
    /// An objection about something: what was found and what it is held against, and all of it in words.
    fn about(
        self,
        about: impl Into<Option<String>>,
        [found, bound]: [f64; 2],
        sentence: String,
    ) -> Objection {
        Objection { question: self, about: about.into(), found, bound, sentence }
    }
}

/// All that speaks against a fit, and against what was held out.
pub fn objections(estimator: &Estimator, fit: &Fit, judged: &[Judgement]) -> Vec<Objection> {
    use Question::{Control, HeldOut, Prior, Rows, Scale, Signs};
    let mut found = of_fit(estimator, fit);
    let raised = |found: &[Objection], questions: &[Question]| {
        found.iter().any(|objection| questions.contains(&objection.question))
    };
    if raised(&found, &[Rows]) {
        return found;
    }
    found.extend(held_out(judged));
    let far_off = raised(&found, &[Control, Signs, Scale, HeldOut]);
    let near = || left_and_random(estimator, fit).is_none_or(|[left, random]| left < NEAR * random);
    let still = still_encoders(estimator, fit);
    let mut causes = explanations(estimator, fit);
    if fit.noise.false_share > 0.0 {
        // What is taken for false may have one cause, which is to be fitted: by itself a pattern of false touches is nothing.
        let noise = estimator.noise_at(&fit.values, fit.noise.joint);
        let all_inliers = explanations(estimator, &estimator.settled(fit.values.clone(), noise, false));
        causes.extend(all_inliers.into_iter().filter(|found| found.cause.is_fitted(estimator.robot)));
        causes.sort_by(|a, b| b.evidence.total_cmp(&a.evidence));
    }
    let suspected = causes.iter().any(|cause| cause.stands_out() || matches!(cause.cause, Cause::Dead(_)));
    // An encoder that never moves is none of a joint that does, and what is much more than noise says that something does.
    let unmoved = !still.is_empty() && (far_off || !near());
    if found.is_empty() && !suspected && !unmoved {
        return found;
    }
    let best = best_explanation(estimator, fit, &causes, &still);
    match best.filter(Explanation::stands_out) {
        // Far off, anything explains a little: what is the matter explains the most of it.
        Some(best) if best.share > WHOLE || !(far_off || raised(&found, &[Prior])) => {
            found.push(pattern(estimator, fit, &best, &still));
        }
        _ if unmoved => {
            let names: Vec<&str> = still.iter().map(|dof| estimator.robot.dofs[*dof].name.as_str()).collect();
            let (names, left) = (names.join(", "), Misses::of(fit.inliers()).rms);
            let sentence = format!(
                "{names}: the encoder reading never changes; if the joint moved, the encoder is dead"
            );
            found.push(Question::Pattern.about(names, [left, left], sentence));
        }
        _ => {}
    }
    found
}

/// What speaks against a fit by itself; the first question is the one to begin with.
fn of_fit(estimator: &Estimator, fit: &Fit) -> Vec<Objection> {
    let questions = [rows, control, outliers, signs, noise, prior, scale];
    questions.iter().filter_map(|asked| asked(estimator, fit)).collect()
}

/// How many equations there are for how many unknowns, once touches that are taken for false are left out.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Redundancy {
    rows: f64,
    pub(super) equations: f64,
    /// Equations that what was fitted took up.
    unknowns: f64,
}

impl Redundancy {
    /// Equations beyond those that it takes; negative where there are too few.
    pub fn spare(&self) -> f64 {
        self.equations - self.unknowns - self.unknowns.max(FEWEST_SPARE)
    }
}

impl Fit {
    /// Equations and unknowns of the touches that are taken to be honest. What is nearly known counts by what the touches add.
    pub fn redundancy(&self) -> Redundancy {
        self.redundancy_of(&self.seen)
    }

    fn redundancy_of<'a>(&self, seen: impl IntoIterator<Item = &'a Seen>) -> Redundancy {
        let mut sum = Redundancy::default();
        for seen in seen {
            let inlier = self.noise.inlier_probability(seen);
            sum.rows += inlier;
            sum.equations += inlier * seen.size();
            sum.unknowns += (seen.taken_up(&self.told.covariance) * self.noise.weight(seen)).trace();
        }
        sum
    }

    /// The touches that are not taken to be false, as they are seen at what was found.
    pub fn inliers(&self) -> impl Iterator<Item = &Seen> {
        self.seen.iter().filter(|seen| self.noise.inlier_probability(seen) > 0.5)
    }

    /// Whether nothing speaks against it, as far as is seen without another fit.
    pub(super) fn explains(&self, estimator: &Estimator) -> bool {
        of_fit(estimator, self).is_empty()
            && !explanations(estimator, self).iter().any(Explanation::stands_out)
    }
}

/// A number to three digits.
fn number(x: f64) -> String {
    let decimals = (2.0 - x.abs().log10().floor()).clamp(0.0, 3.0);
    match x.abs() {
        0.0 => "0".into(),
        size if size < 1e-2 => format!("{x:.1e}"),
        _ => format!("{x:.0$}", decimals as usize),
    }
}

fn mm(metres: f64) -> String {
    number(1e3 * metres)
}

/// Whether there are enough rows, for all numbers together and for each of them.
fn rows(estimator: &Estimator, fit: &Fit) -> Option<Objection> {
    const MORE: &str = "make more touches (`bodyschema plan`), or estimate fewer quantities";
    let all = fit.redundancy();
    if all.spare() < 0.0 {
        let rows = estimator.touches.len() as f64;
        // Rows alike to those that there are; touches that are taken for false are rows that say nothing.
        let each = (all.equations / all.rows.max(1e-9)).max(1.0);
        let least = (all.unknowns + all.unknowns.max(FEWEST_SPARE)) / each;
        let needed = (least - 1e-6).ceil() + (rows - all.rows).round();
        let sentence = format!(
            "too few rows: {rows}, but at least {needed} are needed to estimate and test {:.0} effective parameters; {MORE}",
            all.unknowns
        );
        return Some(Question::Rows.about(None, [rows, needed], sentence));
    }
    let unknowns = &estimator.unknowns;
    let free = |place: &usize| fit.told.is_told(*place) && unknowns.deviation_before(*place).is_none();
    let bearing = |place: usize| {
        let bears = |(at, slope): &(usize, Vector3<f64>)| *at == place && slope.norm() > 0.0;
        let bearing =
            fit.redundancy_of(fit.seen.iter().filter(|seen| seen.residuals.slopes.iter().any(bears)));
        (place, bearing.rows, bearing.equations - bearing.unknowns)
    };
    let worst = (0..unknowns.len()).filter(free).map(bearing).min_by(|a, b| a.2.total_cmp(&b.2));
    let (place, rows, spare) = worst.filter(|(.., spare)| *spare < FEWEST_BEARING)?;
    let name = unknowns.name(estimator.robot, place);
    let needed = (rows + FEWEST_BEARING - spare).ceil();
    let sentence = format!(
        "too few rows: {rows:.0} depend on {name}, but at least {needed} are needed to test it; {MORE}"
    );
    Some(Question::Rows.about(name, [rows, needed], sentence))
}

/// Whether touches that measured what others did would be much farther apart.
fn control(estimator: &Estimator, fit: &Fit) -> Option<Objection> {
    let [left, random] =
        left_and_random(estimator, fit).filter(|[left, random]| *left >= EXPLAINED * random)?;
    let sentence = format!(
        "the contact residual stays at {} mm, little better than the {} mm with measurements shuffled between \
         touches: limbs or columns may be swapped, units wrong, or the faulty quantity not among those estimated",
        mm(left),
        mm(random)
    );
    Some(Question::Control.about(None, [left, random], sentence))
}

/// Whether most touches are explained.
fn outliers(_: &Estimator, fit: &Fit) -> Option<Objection> {
    let share = fit.noise.false_share;
    let sentence = format!("{:.0} % of the touches are outliers", 100.0 * share);
    (share >= MOST_FALSE).then(|| Question::Outliers.about(None, [share, MOST_FALSE], sentence))
}

/// Whether the signs of encoders that were found are the best, as far as starts tell.
fn signs(_: &Estimator, fit: &Fit) -> Option<Objection> {
    let [agreeing, all] = fit.sign_starts.filter(|[agreeing, _]| *agreeing < CONFIRMED)?;
    let sentence = format!(
        "only one of {all} starts found these encoder signs, so they may be wrong: make more touches, or fix \
         known signs (--fix)"
    );
    Some(Question::Signs.about(None, [agreeing as f64, all as f64], sentence))
}

/// Whether more is left than the log says that there is noise.
fn noise(estimator: &Estimator, fit: &Fit) -> Option<Objection> {
    let stated = Noise { groups: vec![0.0; fit.noise.groups.len()], ..fit.noise.clone() };
    let is_stated = |seen: &&Seen| {
        let ends = estimator.touches[seen.touch].pair(seen.ends);
        seen.given > 0.0
            && ends.iter().all(|end| match end.feature {
                Feature::Point(link, _) => end.deviation.is_some() || estimator.robot.is_place(link),
                Feature::Surface(_) => true,
            })
    };
    let (mut squares, mut left, mut given) = (0.0, 0.0, 0.0);
    for seen in fit.seen.iter().filter(is_stated) {
        let (inlier, value) = (fit.noise.inlier_probability(seen), seen.residuals.value);
        let Some(inverse) = stated.covariance(seen).try_inverse() else { continue };
        squares += inlier * value.dot(&(inverse * value));
        left += inlier * value.norm_squared();
        given += inlier * seen.size() * seen.given;
    }
    let all = fit.redundancy_of(fit.seen.iter().filter(is_stated));
    let [rms, said] = [left, given].map(|sum| (sum / all.equations).sqrt());
    let spare = all.equations - all.unknowns;
    let beyond = (squares - spare) / (2.0 * spare).sqrt();
    (spare > 1.0 && beyond > SURE && squares > UNDERSTATED.powi(2) * spare).then(|| {
        let sentence = format!(
            "a_std and b_std together give {} mm per coordinate, but the residual is {} mm",
            mm(said),
            mm(rms)
        );
        Question::Noise.about("a_std, b_std".to_string(), [rms, said], sentence)
    })
}

/// Whether what is nearly known is where it was said to be, as far as the touches may have moved it.
fn prior(estimator: &Estimator, fit: &Fit) -> Option<Objection> {
    let (robot, unknowns) = (estimator.robot, &estimator.unknowns);
    // How far off it would be without what was said of it, in units of how far touches in agreement with that would move it: what is
    // left of what was said, as a row that is left out.
    let far = |place: usize| {
        let deviation = unknowns.deviation_before(place)?;
        let determined = 1.0 - fit.told.covariance[(place, place)] / deviation.powi(2);
        let off = unknowns.off(robot, &fit.values, place).abs() / deviation;
        Some((place, off / determined.max(1e-9).sqrt()))
    };
    let worst = (0..unknowns.len()).filter_map(far).max_by(|a, b| a.1.total_cmp(&b.1));
    let (place, off) = worst.filter(|(_, off)| *off > SURE)?;
    let name = unknowns.name(robot, place);
    let (factor, unit) = robot.quantities[unknowns.parameters[place].0].unit.for_readers();
    let said = factor * unknowns.deviation_before(place).unwrap_or(0.0);
    let sentence = format!(
        "the touches contradict the prior of {name} ({} {unit}): their estimate is {} standard deviations away; \
         widen the prior, or free it",
        number(said),
        number(off)
    );
    Some(Question::Prior.about(name, [off, SURE], sentence))
}

/// Whether the body became much smaller: touches of a small body are all near each other.
fn scale(estimator: &Estimator, fit: &Fit) -> Option<Objection> {
    let robot = estimator.robot;
    // Of what carries a joint: where a place or a mount is has no size.
    let mut carries = vec![false; robot.links.len()];
    for (link, about) in robot.links.iter().enumerate().rev() {
        carries[link] |= about.elements.iter().any(|element| matches!(element, Element::Dof(_)));
        carries[about.parent] |= carries[link];
    }
    let own = robot.links.iter().zip(&carries).filter(|(_, carries)| **carries);
    let elements: Vec<&Element> = own.flat_map(|(link, _)| &link.elements).collect();
    let length = |values: &[Value]| -> f64 {
        let of = |element: &&Element| match **element {
            Element::Shift(q) if robot.quantities[q].is_open() => values[q].vector().norm_squared(),
            Element::ShiftAlong(_, q) if robot.quantities[q].is_open() => values[q].number().powi(2),
            _ => 0.0,
        };
        elements.iter().map(of).sum::<f64>().sqrt()
    };
    let [after, before] = [length(&fit.values), length(&robot.nominal())];
    (after < SHRUNK * before).then(|| {
        let sentence = format!(
            "the free lengths shrank to {:.0} % of their nominal values, because a smaller body always has \
             smaller residuals; fix a length, or give priors (--prior)",
            100.0 * after / before
        );
        Question::Scale.about(None, [after, before], sentence)
    })
}

/// Whether held-out touches are where they are predicted.
fn held_out(judged: &[Judgement]) -> Option<Objection> {
    let touches = mean(judged.iter().map(|judgement| judgement.touches as f64));
    let within = mean(judged.iter().map(|judgement| judgement.within));
    let sure = SURE * (HOLDS * (1.0 - HOLDS) / touches.max(1.0)).sqrt();
    (touches > 0.0 && within < HOLDS_AT_LEAST && within < HOLDS - sure).then(|| {
        let sentence =
            format!("only {:.0} % of the held-out touches are within the 95 % interval", 100.0 * within);
        Question::HeldOut.about(None, [within, HOLDS], sentence)
    })
}

/// What explains what is left, as an objection.
fn pattern(estimator: &Estimator, fit: &Fit, best: &Explanation, still: &[usize]) -> Objection {
    let robot = estimator.robot;
    let left = Misses::of(fit.inliers()).rms;
    let with = left * (1.0 - best.share).max(0.0).sqrt();
    let lower = format!("the contact residual from {} to about {} mm", mm(left), mm(with));
    let name = best.cause.name(robot);
    let sentence = match best.cause {
        Cause::Quantity(_) => format!("freeing {name} reduces {lower} (--free {name})"),
        Cause::Reversed(d) => {
            let joint = &robot.dofs[d].name;
            format!(
                "the encoder of {joint} counts in the opposite direction: reversing {name} reduces {lower}"
            )
        }
        Cause::Dead(d) => {
            let about = &robot.dofs[d];
            let unit = about.quantities.map_or(Unit::One, |q| robot.quantities[q.offset].unit);
            let (factor, unit) = unit.for_readers();
            let read =
                still.contains(&d).then(|| estimator.touches[fit.seen[0].touch].posture[about.coordinate]);
            let read = read.map(|read| format!(" (it always reads {} {unit})", number(factor * read)));
            format!("the encoder of {name} does not follow its joint{}", read.unwrap_or_default())
        }
        Cause::Curved(_) => format!(
            "the contact residual depends on the angle of {name}: a nonlinear encoder reduces {lower}"
        ),
        Cause::Slipped(_, from) => {
            let line = estimator.touches[from].line;
            format!(
                "{name} changed during the log: a different value from about line {line} on reduces {lower}"
            )
        }
        Cause::Convention => format!(
            "the table uses the other Denavit-Hartenberg convention: reading it that way reduces {lower} (column convention)"
        ),
    };
    Question::Pattern.about(name, [left, with], sentence)
}

/// Contact residuals, and what they would be with measurements exchanged between touches of the same two links:
/// what a body that explains nothing leaves. Exchanged are postures where points differ; where they are the same in all
/// only joints were measured, and each is exchanged by itself. `None` if no two touches are between the same.
fn left_and_random(estimator: &Estimator, fit: &Fit) -> Option<[f64; 2]> {
    let touches = estimator.touches;
    let mut alike: BTreeMap<[(bool, usize); 2], Vec<usize>> = BTreeMap::new();
    for (i, touch) in touches.iter().enumerate() {
        let key = touch.pair([0, 0]).map(|end| match end.feature {
            Feature::Point(link, _) => (false, link),
            Feature::Surface(surface) => (true, surface),
        });
        alike.entry(key).or_default().push(i);
    }
    let mut exchanged = Vec::new();
    for own in alike.into_values().filter(|own| own.len() > 1) {
        let features = |i: usize| touches[i].features([0, 0]);
        let same_points = own.iter().all(|i| features(*i) == features(own[0]));
        for (k, i) in own.iter().enumerate() {
            let mut touch = touches[*i].clone();
            for (d, dof) in estimator.robot.dofs.iter().enumerate() {
                // Of a whole posture from far down the log: neighbours are often alike.
                let share = if same_points { (0.618_034 * (d + 1) as f64).fract() } else { 0.5 };
                let apart = share * (own.len() - 1) as f64;
                let other = own[(k + 1 + apart as usize) % own.len()];
                let coordinates = dof.coordinate..dof.coordinate + dof.kind.coordinates();
                touch.posture[coordinates.clone()].copy_from_slice(&touches[other].posture[coordinates]);
            }
            exchanged.push(touch);
        }
    }
    let random = estimator.of_touches(&exchanged).seen(&fit.values, &fit.noise);
    (!random.is_empty()).then(|| [Misses::of(fit.inliers()).rms, Misses::of(&random).rms])
}

impl Cause {
    /// The joint, quantity or column that it is about.
    fn name(self, robot: &Robot) -> String {
        match self {
            Cause::Quantity(q) | Cause::Slipped(q, _) => robot.quantities[q].name.clone(),
            Cause::Reversed(d) => format!("{}.sign", robot.dofs[d].name),
            Cause::Dead(d) | Cause::Curved(d) => robot.dofs[d].name.clone(),
            Cause::Convention => "convention".into(),
        }
    }
}
