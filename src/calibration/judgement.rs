//! How a calibration is judged: by touches that it was not fitted to, and by what speaks against it.
//!
//! The noise is estimated from the touches, and what is said of it is held against that. A verdict is a list of [`Objection`]s,
//! and calibrated is what none is raised to.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt;

use nalgebra::Matrix3;
use rand::SeedableRng;
use rand::seq::SliceRandom;
use rand_chacha::ChaCha8Rng;
use serde::Serialize;

use super::causes::{Cause, Explanation, best_explanation, explanations, still_encoders};
use super::estimate::{Estimator, Fit, SeenTouch};
use super::noise::{Noise, Seen, taken_up};
use super::repeats::postures;
use super::robot::{Element, Unit, Value};
use super::touch::{Feature, Touch};

/// The share of touches that an interval should hold, …
const HOLDS: f64 = 0.95;
/// … and the held-out touches that it takes to say so: one in twenty may lie outside.
pub const FEWEST_HELD_OUT: usize = 20;
/// An interval that holds fewer, and by so many deviations, is none.
const HOLDS_AT_LEAST: f64 = 0.85;
/// Deviations of a chance that is none.
const SURE: f64 = 5.0;
/// Equations beyond the unknowns at the least, and at the least as many as unknowns: with fewer, deviations are known to no digit,
/// and what is wrong explains itself.
const FEWEST_SPARE: f64 = 10.0;
/// Rows beyond what fits itself that a number must bear on.
const FEWEST_BEARING: f64 = 3.0;
/// A robot explains its touches if they are apart by less than this share of what touches in others' postures are, …
const EXPLAINED: f64 = 0.25;
/// … what is less than this share may be a small pattern, …
const PATTERN: f64 = 0.05;
/// … of what is more one cause is believed that explains this share of its mean square, …
const WHOLE: f64 = 0.9;
/// … and no more of them are false.
const MOST_FALSE: f64 = 0.4;
/// Noise is contradicted where so many times what is said is left.
const UNDERSTATED: f64 = 1.5;
/// A body that shrinks to less than this explains its touches by being small.
const SHRUNK: f64 = 0.5;
/// Stretches of time of which some are held out.
const STRETCHES: usize = 20;

/// How far apart what touched is put, metres.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Misses {
    /// Root of the mean square.
    pub rms: f64,
    /// The median.
    pub median: f64,
    /// 95 % miss by less.
    pub p95: f64,
    /// The greatest.
    pub max: f64,
}

/// What touches that were not fitted to say.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Judgement {
    /// How many there were.
    pub touches: usize,
    /// At the values from before.
    pub before: Misses,
    /// At the values found.
    pub after: Misses,
    /// The share of them that lies within the interval that is to hold 95 %.
    pub within: f64,
    /// The radius of that interval on average, metres.
    pub interval: f64,
}

impl Misses {
    /// Of touches as they are seen.
    pub fn of(seen: &[SeenTouch]) -> Misses {
        let mut sizes: Vec<f64> = seen.iter().map(|(_, _, seen)| seen.residuals.value.norm()).collect();
        sizes.sort_by(f64::total_cmp);
        let at = |share: f64| quantile(&sizes, share);
        let squares: f64 = sizes.iter().map(|size| size * size).sum();
        Misses {
            rms: (squares / sizes.len().max(1) as f64).sqrt(),
            median: at(0.5),
            p95: at(HOLDS),
            max: sizes.last().copied().unwrap_or(f64::NAN),
        }
    }

    /// The mean over parts that were held out, number by number.
    pub fn mean(judged: &[Judgement], of: impl Fn(&Judgement) -> Misses) -> Misses {
        let all: Vec<Misses> = judged.iter().map(of).collect();
        let mean = |part: fn(&Misses) -> f64| all.iter().map(part).sum::<f64>() / all.len().max(1) as f64;
        Misses {
            rms: mean(|m| m.rms),
            median: mean(|m| m.median),
            p95: mean(|m| m.p95),
            max: mean(|m| m.max),
        }
    }
}

/// How many equations there are for how many unknowns, once touches that are taken for false are left out.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Redundancy {
    rows: f64,
    /// Equations.
    pub equations: f64,
    unknowns: f64,
}

impl Redundancy {
    /// Equations beyond those that it takes; negative where there are too few.
    pub fn spare(&self) -> f64 {
        self.equations - self.unknowns - self.unknowns.max(FEWEST_SPARE)
    }

    /// The rows that it takes, alike to those that there are.
    fn needed(&self) -> f64 {
        let each = (self.equations / self.rows.max(1e-9)).max(1.0);
        ((self.unknowns + self.unknowns.max(FEWEST_SPARE)) / each - 1e-6).ceil()
    }
}

impl Fit {
    /// Equations and unknowns of the touches that are taken to be honest. What is nearly known counts by what the touches add.
    pub fn redundancy(&self) -> Redundancy {
        let mut sum = Redundancy { rows: 0.0, equations: 0.0, unknowns: 0.0 };
        for (_, _, seen) in &self.seen {
            let honesty = self.noise.honesty(seen);
            sum.rows += honesty;
            sum.equations += honesty * seen.residuals.size as f64;
            sum.unknowns += self.leverage(seen);
        }
        sum
    }

    /// How much of a touch's residual what was fitted took up: from 0 to its size.
    fn leverage(&self, seen: &Seen) -> f64 {
        let inverse = self.noise.covariance(seen).try_inverse().unwrap_or_else(Matrix3::zeros);
        (taken_up(&seen.residuals, &self.told.covariance) * inverse).trace() * self.noise.honesty(seen)
    }

    /// The touches that are not taken to be false, as they are seen at what was found.
    pub fn honest(&self) -> Vec<SeenTouch> {
        let honest = |(_, _, seen): &&SeenTouch| self.noise.honesty(seen) > 0.5;
        self.seen.iter().filter(honest).cloned().collect()
    }

    /// Whether nothing speaks against it, as far as is seen without another fit.
    pub(super) fn explains(&self, estimator: &Estimator) -> bool {
        doubts(estimator, self).is_empty()
            && !explanations(estimator, self).iter().any(Explanation::stands_out)
    }
}

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

fn objection(
    question: Question,
    about: Option<String>,
    [found, bound]: [f64; 2],
    sentence: String,
) -> Objection {
    Objection { question, about, found, bound, sentence }
}

/// All that speaks against a fit, and against what was held out; the first is the one to begin with.
pub fn objections(estimator: &Estimator, fit: &Fit, judged: &[Judgement]) -> Vec<Objection> {
    let mut found = doubts(estimator, fit);
    if found.iter().any(|objection| objection.question == Question::Rows) {
        return found;
    }
    found.extend(held_out(judged));
    let mut causes = explanations(estimator, fit);
    if fit.noise.false_share > 0.0 {
        // What is taken for false may have one cause, which is to be fitted: by itself a pattern of false touches is nothing.
        let all_honest = explanations(estimator, &estimator.with_all_honest(fit));
        causes.extend(all_honest.into_iter().filter(|found| found.cause.is_fitted(estimator.robot)));
        causes.sort_by(|a, b| b.evidence.total_cmp(&a.evidence));
    }
    let suspected = causes.iter().any(|cause| cause.stands_out() || matches!(cause.cause, Cause::Dead(_)));
    if !found.is_empty() || suspected {
        let is =
            |questions: &[Question]| found.iter().any(|objection| questions.contains(&objection.question));
        let far_off =
            is(&[Question::Control, Question::Outliers, Question::Signs, Question::Scale, Question::HeldOut]);
        let near = apart_at_random(estimator, fit)
            .is_none_or(|random| Misses::of(&fit.honest()).rms < PATTERN * random.rms);
        let best =
            best_explanation(estimator, fit, &causes, far_off || !near).filter(Explanation::stands_out);
        let still = still_encoders(estimator, fit);
        match best {
            // Far off, anything explains a little: what is the matter explains the most of it.
            Some(best) if best.share > WHOLE || !(far_off || is(&[Question::Prior])) => {
                found.push(pattern(estimator, fit, &best))
            }
            _ if far_off && !still.is_empty() => found.push(unmoved(estimator, fit, &still)),
            _ => {}
        }
    }
    found
}

/// What speaks against a fit by itself.
fn doubts(estimator: &Estimator, fit: &Fit) -> Vec<Objection> {
    let mut found: Vec<Objection> = few_rows(estimator, fit).into_iter().collect();
    let apart = Misses::of(&fit.honest());
    if let Some(random) = apart_at_random(estimator, fit).filter(|random| apart.rms >= EXPLAINED * random.rms)
    {
        let sentence = format!(
            "what touched stays {} mm apart, and {} mm with what was measured exchanged between touches: limbs or columns may be \
             exchanged, units wrong, or what is off is not among what is said to be unknown",
            mm(apart.rms),
            mm(random.rms)
        );
        found.push(objection(Question::Control, None, [apart.rms, random.rms], sentence));
    }
    let share = fit.noise.false_share;
    if share >= MOST_FALSE {
        let sentence = format!("{:.0} % of the touches are not explained", 100.0 * share);
        found.push(objection(Question::Outliers, None, [share, MOST_FALSE], sentence));
    }
    if let Some(starts) = fit.sign_starts.filter(|starts| !starts.agree()) {
        let sentence = format!(
            "of {} starts only one came to these signs of encoders, which may be the wrong ones: make more touches, or say signs \
             that are known (--fix)",
            starts.all
        );
        found.push(objection(Question::Signs, None, [starts.agreeing as f64, starts.all as f64], sentence));
    }
    found.extend(understated(estimator, fit));
    found.extend(contradicted(estimator, fit));
    found.extend(shrunk(estimator, fit));
    found
}

/// The quantity that is farthest from where it was said to be, in units of how far the touches may have moved it.
fn contradicted(estimator: &Estimator, fit: &Fit) -> Option<Objection> {
    let (robot, unknowns) = (estimator.robot, &estimator.unknowns);
    let far = |place: usize| {
        unknowns.pulled(robot, &fit.values, &fit.told.covariance, place).map(|pulled| (place, pulled.sqrt()))
    };
    let worst = (0..unknowns.len()).filter_map(far).max_by(|a, b| a.1.total_cmp(&b.1));
    let (place, off) = worst.filter(|(_, off)| *off > SURE)?;
    let (q, component) = unknowns.parameters[place];
    let name = robot.quantities[q].component_name(component);
    let (factor, unit) = robot.quantities[q].unit.for_readers();
    let said = factor * unknowns.deviation_before(place).unwrap_or(0.0);
    let sentence = format!(
        "the touches contradict the prior of {name} ({} {unit}): they put it {} deviations away; give it a wider prior, or free it",
        number(said),
        number(off)
    );
    Some(objection(Question::Prior, Some(name), [off, SURE], sentence))
}

/// Whether there are too few rows, for all numbers together or for one of them.
fn few_rows(estimator: &Estimator, fit: &Fit) -> Option<Objection> {
    let all = fit.redundancy();
    let rows = estimator.touches().len() as f64;
    let more = "make more touches (`bodyschema plan`), or say less to be unknown";
    if all.spare() < 0.0 {
        // Touches that are taken for false are rows that say nothing.
        let needed = all.needed() + (rows - all.rows).round();
        let sentence = format!(
            "too few rows: {rows}, at least {needed} for {:.0} numbers to be found and tested: {more}",
            all.unknowns
        );
        return Some(objection(Question::Rows, None, [rows, needed], sentence));
    }
    let bearing = |place: &usize| -> (f64, f64) {
        let bears = |seen: &&SeenTouch| {
            seen.2.residuals.slopes.iter().any(|(at, slope)| at == place && slope.norm() > 0.0)
        };
        fit.seen.iter().filter(bears).fold((0.0, 0.0), |(rows, spare), (_, _, seen)| {
            let honesty = fit.noise.honesty(seen);
            (rows + honesty, spare + honesty * seen.residuals.size as f64 - fit.leverage(seen))
        })
    };
    let unknowns = &estimator.unknowns;
    let free = |place: &usize| fit.told.is_told(*place) && unknowns.deviation_before(*place).is_none();
    let worst = (0..unknowns.len()).filter(free).map(|place| (place, bearing(&place)));
    let (place, (rows, spare)) = worst.min_by(|a, b| a.1.1.total_cmp(&b.1.1))?;
    (spare < FEWEST_BEARING).then(|| {
        let (q, component) = unknowns.parameters[place];
        let name = estimator.robot.quantities[q].component_name(component);
        let needed = (rows + FEWEST_BEARING - spare).ceil();
        let sentence =
            format!("too few rows: {rows:.0} bear on {name}, at least {needed} to test it: {more}");
        objection(Question::Rows, Some(name), [rows, needed], sentence)
    })
}

/// Whether more is left than the log says that there is noise.
fn understated(estimator: &Estimator, fit: &Fit) -> Option<Objection> {
    let said = Noise { groups: vec![0.0; fit.noise.groups.len()], ..fit.noise.clone() };
    let (mut squares, mut left, mut equations, mut given, mut spare) = (0.0, 0.0, 0.0, 0.0, 0.0);
    for (touch, ends, seen) in &fit.seen {
        let about = &estimator.touches()[*touch];
        let ends = [0, 1].map(|side| &about.ends[side][ends[side]]);
        let unsaid = ends.iter().any(|end| {
            end.deviation.is_none()
                && matches!(end.feature, Feature::Point(link, _) if !estimator.robot.is_place(link))
        });
        if unsaid || seen.source.given <= 0.0 {
            continue;
        }
        let (honesty, value, size) =
            (fit.noise.honesty(seen), seen.residuals.value, seen.residuals.size as f64);
        let Some(inverse) = said.covariance(seen).try_inverse() else { continue };
        squares += honesty * value.dot(&(inverse * value));
        left += honesty * value.norm_squared();
        given += honesty * size * seen.source.given;
        equations += honesty * size;
        spare += honesty * size - fit.leverage(seen);
    }
    let (rms, said) = ((left / equations).sqrt(), (given / equations).sqrt());
    let beyond = (squares - spare) / (2.0 * spare).sqrt();
    (spare > 1.0 && beyond > SURE && squares > UNDERSTATED.powi(2) * spare).then(|| {
        let sentence = format!(
            "a_std and b_std together state {} mm for each coordinate, and {} mm are left",
            mm(said),
            mm(rms)
        );
        objection(Question::Noise, Some("a_std, b_std".into()), [rms, said], sentence)
    })
}

/// Whether the body became much smaller: touches of a small body are all near each other.
fn shrunk(estimator: &Estimator, fit: &Fit) -> Option<Objection> {
    let robot = estimator.robot;
    // Of what carries a joint: where a place or a mount is has no size.
    let mut carries = vec![false; robot.links.len()];
    for (link, about) in robot.links.iter().enumerate().rev() {
        carries[link] |= about.elements.iter().any(|element| matches!(element, Element::Dof(_)));
        let own = carries[link];
        carries[about.parent] |= own;
    }
    let lengths = |values: &[Value]| -> f64 {
        let of = |element: &Element| match *element {
            Element::Shift(q) if robot.quantities[q].is_open() => values[q].vector().norm_squared(),
            Element::ShiftAlong(_, q) if robot.quantities[q].is_open() => values[q].number().powi(2),
            _ => 0.0,
        };
        let own = robot.links.iter().zip(&carries).filter(|(_, carries)| **carries);
        own.flat_map(|(link, _)| &link.elements).map(of).sum::<f64>().sqrt()
    };
    let (after, before) = (lengths(&fit.values), lengths(&robot.nominal()));
    (after < SHRUNK * before).then(|| {
        let sentence = format!(
            "the lengths that are free shrank to {:.0} % of what they were: a small body is near whatever it touches; fix a length, or \
             say how nearly they are known (--prior)",
            100.0 * after / before
        );
        objection(Question::Scale, None, [after, before], sentence)
    })
}

/// Whether held-out touches are where they are predicted.
fn held_out(judged: &[Judgement]) -> Option<Objection> {
    let count = judged.len().max(1) as f64;
    let touches = judged.iter().map(|judgement| judgement.touches).sum::<usize>() as f64 / count;
    let within = judged.iter().map(|judgement| judgement.within).sum::<f64>() / count;
    let sure = SURE * (HOLDS * (1.0 - HOLDS) / touches.max(1.0)).sqrt();
    (touches > 0.0 && within < HOLDS_AT_LEAST && within < HOLDS - sure).then(|| {
        let sentence = format!(
            "only {:.0} % of the held-out touches are within the interval that should hold 95 %",
            100.0 * within
        );
        objection(Question::HeldOut, None, [within, HOLDS], sentence)
    })
}

/// What explains what is left, as an objection.
fn pattern(estimator: &Estimator, fit: &Fit, best: &Explanation) -> Objection {
    let robot = estimator.robot;
    let left = Misses::of(&fit.honest()).rms;
    let with = left * (1.0 - best.share).max(0.0).sqrt();
    let lower = format!("the contact residual from {} to about {} mm", mm(left), mm(with));
    let dof = |dof: usize| robot.dofs[dof].name.clone();
    let quantity = |q: usize| robot.quantities[q].name.clone();
    let (about, sentence) = match best.cause {
        Cause::Quantity(q) => {
            let name = quantity(q);
            let sentence = format!("freeing {name} reduces {lower} (--free {name})");
            (name, sentence)
        }
        Cause::Reversed(d) => {
            let name = format!("{}.sign", dof(d));
            let sentence =
                format!("the encoder of {} counts the other way: reversing {name} reduces {lower}", dof(d));
            (name, sentence)
        }
        Cause::Dead(d) => {
            let read = still(estimator, fit, d);
            let sentence = format!("the encoder of {} does not follow its joint{read}", dof(d));
            (dof(d), sentence)
        }
        Cause::Curved(d) => {
            let sentence = format!(
                "the contact residual depends on the angle of {}: an encoder that is no straight line reduces {lower}",
                dof(d)
            );
            (dof(d), sentence)
        }
        Cause::Slipped(q, from) => {
            let (name, line) = (quantity(q), estimator.touches()[from].line);
            let sentence = format!(
                "{name} changed in the course of the log: another value from about line {line} on reduces {lower}"
            );
            (name, sentence)
        }
        Cause::Convention => {
            let sentence = format!(
                "the table is of the other Denavit-Hartenberg convention: reading it so reduces {lower} (column convention)"
            );
            ("convention".into(), sentence)
        }
    };
    objection(Question::Pattern, Some(about), [left, with], sentence)
}

/// Encoders that read the same all the time, where what is left has no other explanation.
fn unmoved(estimator: &Estimator, fit: &Fit, still: &[usize]) -> Objection {
    let names: Vec<&str> = still.iter().map(|dof| estimator.robot.dofs[*dof].name.as_str()).collect();
    let names = names.join(", ");
    let left = Misses::of(&fit.honest()).rms;
    let sentence = format!("{names}: the encoder always reads the same, and is dead if the joint moved");
    objection(Question::Pattern, Some(names), [left, left], sentence)
}

/// What an encoder reads, if that is the same all the time.
fn still(estimator: &Estimator, fit: &Fit, dof: usize) -> String {
    let (robot, touches) = (estimator.robot, estimator.touches());
    if !still_encoders(estimator, fit).contains(&dof) {
        return String::new();
    }
    let about = &robot.dofs[dof];
    let unit = about.quantities.map_or(Unit::One, |q| robot.quantities[q.offset].unit);
    let (factor, unit) = unit.for_readers();
    format!(" (it always reads {} {unit})", number(factor * touches[fit.seen[0].0].posture[about.coordinate]))
}

/// Judges a fit by touches that it was not fitted to.
pub fn judge(estimator: &Estimator, fit: &Fit, fresh: &[Touch]) -> Judgement {
    let before = estimator.seen_of(fresh, &estimator.robot.nominal(), &fit.noise);
    let after = estimator.seen_of(fresh, &fit.values, &fit.noise);
    let widths = interval(fit);
    let within =
        after.iter().filter(|(_, _, seen)| spread(fit, seen, seen.residuals.value) <= widths).count();
    let radius = |seen: &Seen| {
        widths * (predicted(fit, seen).trace() - (3 - seen.residuals.size) as f64).max(0.0).sqrt()
    };
    Judgement {
        touches: fresh.len(),
        before: Misses::of(&before),
        after: Misses::of(&after),
        within: within as f64 / after.len().max(1) as f64,
        interval: after.iter().map(|(_, _, seen)| radius(seen)).sum::<f64>() / after.len().max(1) as f64,
    }
}

/// So many predicted deviations hold 95 % of the touches that were fitted to, each with itself left out.
fn interval(fit: &Fit) -> f64 {
    let left_out = |seen: &Seen| {
        // Of a touch left out, the residual is (I − H)⁻¹ r with its own share H in what was fitted.
        let share = taken_up(&seen.residuals, &fit.told.covariance);
        let weight =
            fit.noise.covariance(seen).try_inverse().unwrap_or_else(Matrix3::zeros) * fit.noise.honesty(seen);
        let own = (Matrix3::identity() - share * weight).try_inverse().unwrap_or_else(Matrix3::identity);
        spread(fit, seen, own * seen.residuals.value)
    };
    let mut sizes: Vec<f64> = fit.seen.iter().map(|(_, _, seen)| left_out(seen)).collect();
    sizes.sort_by(f64::total_cmp);
    // Of n touches and a fresh one, each is as likely the greatest.
    let rank = (HOLDS * (sizes.len() + 1) as f64).ceil() as usize;
    sizes.get(rank.saturating_sub(1)).copied().unwrap_or(f64::INFINITY)
}

/// The covariance of a residual that was not fitted to.
fn predicted(fit: &Fit, seen: &Seen) -> Matrix3<f64> {
    fit.noise.covariance(seen) + taken_up(&seen.residuals, &fit.told.covariance)
}

/// A residual in units of what is predicted for it: 1 on average for Gaussian noise.
fn spread(fit: &Fit, seen: &Seen, value: nalgebra::Vector3<f64>) -> f64 {
    let size = seen.residuals.size as f64;
    let whitened = predicted(fit, seen).cholesky().map(|factor| factor.solve(&value).dot(&value));
    whitened.map_or(f64::INFINITY, |squares| (squares / size).sqrt())
}

/// How far apart touches would be with what was measured exchanged between those of the same two links: what a body that explains
/// nothing leaves. Exchanged are postures where points differ; where they are the same in all only joints were measured, and each
/// is exchanged by itself. `None` if no two touches are between the same.
fn apart_at_random(estimator: &Estimator, fit: &Fit) -> Option<Misses> {
    let touches = estimator.touches();
    let mut alike: BTreeMap<[(bool, usize); 2], Vec<usize>> = BTreeMap::new();
    for (i, touch) in touches.iter().enumerate() {
        let key = touch.ends.each_ref().map(|ends| match ends[0].feature {
            Feature::Point(link, _) => (false, link),
            Feature::Surface(surface) => (true, surface),
        });
        alike.entry(key).or_default().push(i);
    }
    let mut exchanged = Vec::new();
    for own in alike.into_values().filter(|own| own.len() > 1) {
        let features = |i: usize| touches[i].ends.each_ref().map(|ends| ends[0].feature);
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
    let seen = estimator.seen_of(&exchanged, &fit.values, &fit.noise);
    (!seen.is_empty()).then(|| Misses::of(&seen))
}

/// Touches that are held out or not together: those of one posture, and of a stretch of time where the log has times. Of each touch
/// which part it is of.
fn parts(touches: &[Touch], count: usize) -> Vec<usize> {
    let postures = postures(touches);
    let Some(times) = touches.iter().map(|touch| touch.time).collect::<Option<Vec<f64>>>() else {
        return postures;
    };
    let mut order: Vec<usize> = (0..touches.len()).collect();
    order.sort_by(|a, b| times[*a].total_cmp(&times[*b]));
    let mut part = vec![0; touches.len()];
    order.iter().enumerate().for_each(|(rank, touch)| part[*touch] = rank * count / touches.len());
    part
}

/// Parts in a random order, and which each touch is of.
fn shuffled(touches: &[Touch], count: usize, seed: u64) -> (Vec<usize>, Vec<usize>) {
    let part = parts(touches, count);
    let mut order: Vec<usize> = part.iter().copied().collect::<BTreeSet<usize>>().into_iter().collect();
    order.shuffle(&mut ChaCha8Rng::seed_from_u64(seed));
    (order, part)
}

/// Touches that are fitted to and those that are held out; no posture is on both sides.
fn divided(touches: &[Touch], held: &[bool]) -> [Vec<Touch>; 2] {
    let postures = postures(touches);
    let fitted: BTreeSet<usize> = (0..touches.len()).filter(|i| !held[*i]).map(|i| postures[i]).collect();
    let of = |out: bool| {
        let own = |i: &usize| held[*i] == out && !(out && fitted.contains(&postures[*i]));
        (0..touches.len()).filter(own).map(|i| touches[i].clone()).collect()
    };
    [of(false), of(true)]
}

/// Divides touches at random into those to fit to and a share that is held out.
pub fn split(touches: &[Touch], held_out: f64, seed: u64) -> [Vec<Touch>; 2] {
    let (order, part) = shuffled(touches, STRETCHES, seed);
    let mut held = vec![false; touches.len()];
    let mut left = (touches.len() as f64 * held_out).round() as usize;
    for next in order {
        let own: Vec<usize> = (0..touches.len()).filter(|i| part[*i] == next).collect();
        if own.len() > left {
            continue;
        }
        left -= own.len();
        own.into_iter().for_each(|i| held[i] = true);
    }
    divided(touches, &held)
}

/// Divides touches at random into so many parts, each of which is held out once: what is fitted to, and what is held out.
pub fn folds(touches: &[Touch], count: usize, seed: u64) -> Vec<[Vec<Touch>; 2]> {
    let count = count.max(1);
    let (order, part) = shuffled(touches, count, seed);
    let rank: BTreeMap<usize, usize> =
        order.into_iter().enumerate().map(|(rank, part)| (part, rank)).collect();
    (0..count)
        .map(|k| divided(touches, &part.iter().map(|part| rank[part] % count == k).collect::<Vec<bool>>()))
        .collect()
}

/// The value below which a share of sorted values lies.
fn quantile(sorted: &[f64], share: f64) -> f64 {
    let at = share * sorted.len().saturating_sub(1) as f64;
    let (low, high) = (at.floor() as usize, at.ceil() as usize);
    match (sorted.get(low), sorted.get(high)) {
        (Some(a), Some(b)) => a + (b - a) * (at - low as f64),
        _ => f64::NAN,
    }
}
