//! How soon a body that changes is known again.

use nalgebra::Vector3;
use serde::{Deserialize, Serialize};

use super::changed_body::{LimbInModel, changed_skin, felt};
use super::plot::{AxisScale, PlotAxis, PlotSeries, StudyPlot};
use super::subject::{Subject, median, share};
use super::table::row;
use super::{Findings, Study, Trial, Trials};
use crate::agent::Agent;
use crate::creature::Body;
use crate::evaluation::{held_out, held_out_points, is_hand};
use crate::experiment::ExperimentError;
use crate::ground_truth::GroundTruth;
use crate::kinematics::Chain;
use crate::learning::{Learner, Online};
use crate::senses::Touch;

/// The study `growth`.
pub const STUDY: Study = Study {
    name: "growth",
    about: "how soon lm knows a limb that has grown, a stick in the hand",
    touches: true,
    several: false,
    trials: Trials::of::<GrowthTrial>(),
};

/// By how much the limb grows, metres.
const GROWTH: f64 = 0.05;
/// The stick's length, metres.
const STICK: f64 = 0.3;
/// Touches of the changed body.
const TOUCHES_AFTER: usize = 300;
/// The error after, in units of the error before, at which the body counts as known again.
const AGAIN: f64 = 2.0;
/// The seed's offset for the touches of the changed body: not those of the body before.
const AFTER_SEED: u64 = 1 << 32;

row! {
    /// A measurement of the study `growth`.
    pub struct GrowthMeasurement {
        change: String = "change",
        limb: String = "limb",
        seed: u64 = "seed",
        touches: usize = "touches",
        touches_of_limb: usize = "touches of the limb",
        error_mm: f64 = "error, mm",
        error_before_mm: f64 = "error before, mm",
    }
}

row! {
    /// A row of the summary of the study `growth`.
    pub struct GrowthSummary {
        change: String = "change",
        error_before_mm: f64 = "error before, mm",
        error_at_change_mm: f64 = "at the change, mm",
        touches_to_notice: f64 = "touches of the limb to notice",
        touches_to_twice: f64 = "to twice the error before",
        known_again: f64 = "known again, share",
        error_after_mm: f64 = "error at the end, mm",
    }
}

/// What changes.
#[derive(Clone, Copy)]
enum StudiedChange {
    Growth,
    Stick,
}

/// The changes, with the names under which they appear.
const CHANGES: [(&str, StudiedChange); 2] =
    [("limb grows by 50 mm", StudiedChange::Growth), ("stick of 300 mm in the hand", StudiedChange::Stick)];

/// One trial of one change.
#[derive(Debug, Serialize, Deserialize)]
struct RelearningCourse {
    change: String,
    limb: String,
    seed: u64,
    /// Touches of the body as it was.
    touches: usize,
    before_mm: f64,
    at_change_mm: f64,
    /// Touches of the changed limb until the change was explained.
    noticed: f64,
    /// Per touch of the changed limb, the error after it.
    errors_mm: Vec<f64>,
}

impl RelearningCourse {
    /// Touches of the limb from which on the error is at most twice the one before.
    fn to_twice(&self) -> f64 {
        let exceeds = |error: &f64| error.is_nan() || *error > AGAIN * self.before_mm;
        match self.errors_mm.iter().rposition(exceeds) {
            None => 0.0,
            Some(last) if last + 1 < self.errors_mm.len() => (last + 2) as f64,
            Some(_) => f64::INFINITY,
        }
    }
}

/// What came of one trial, change by change.
#[derive(Debug, Serialize, Deserialize)]
pub struct GrowthTrial(Vec<RelearningCourse>);

impl RelearningCourse {
    fn measurements(&self) -> impl Iterator<Item = GrowthMeasurement> {
        self.errors_mm.iter().enumerate().map(|(k, &error_mm)| GrowthMeasurement {
            change: self.change.clone(),
            limb: self.limb.clone(),
            seed: self.seed,
            touches: self.touches,
            touches_of_limb: k + 1,
            error_mm,
            error_before_mm: self.before_mm,
        })
    }
}

impl Trial for GrowthTrial {
    type Setting = ();
    type Measurement = GrowthMeasurement;
    type Summary = GrowthSummary;

    fn set_up(_subject: &Subject) -> Result<(), ExperimentError> {
        Ok(())
    }

    fn run(subject: &Subject, (): &(), seed: u64) -> Result<GrowthTrial, ExperimentError> {
        let touches = subject.babble(seed)?;
        let limb = most_touching(subject, &touches)?;
        let courses = CHANGES.into_iter().map(|change| {
            subject.tell(seed, change.0);
            follow(subject, &touches, seed, limb, change)
        });
        Ok(GrowthTrial(courses.collect::<Result<_, _>>()?))
    }

    fn findings(_subject: &Subject, trials: &[GrowthTrial]) -> Findings<GrowthMeasurement, GrowthSummary> {
        findings(trials)
    }
}

fn findings(trials: &[GrowthTrial]) -> Findings<GrowthMeasurement, GrowthSummary> {
    let mut summary: Vec<GrowthSummary> = Vec::new();
    let mut series = Vec::new();
    for (name, _) in CHANGES {
        let of_change = |course: &&RelearningCourse| course.change == name;
        let courses: Vec<&RelearningCourse> =
            trials.iter().filter_map(|trial| trial.0.iter().find(of_change)).collect();
        let median_of =
            |value: fn(&RelearningCourse) -> f64| median(courses.iter().map(|course| value(course)));
        summary.push(GrowthSummary {
            change: name.into(),
            error_before_mm: median_of(|course| course.before_mm),
            error_at_change_mm: median_of(|course| course.at_change_mm),
            touches_to_notice: median_of(|course| course.noticed),
            touches_to_twice: median_of(RelearningCourse::to_twice),
            known_again: share(courses.iter().map(|course| course.to_twice().is_finite())),
            error_after_mm: median_of(|course| course.errors_mm.last().copied().unwrap_or(f64::NAN)),
        });
        let most = courses.iter().map(|course| course.errors_mm.len()).min().unwrap_or(0);
        let at = |k: usize| median(courses.iter().map(|course| course.errors_mm[k]));
        let line = (0..most).map(|k| ((k + 1) as f64, at(k))).collect();
        series.push(PlotSeries { name: name.into(), line, dots: Vec::new() });
    }
    let notes = vec![
        "The hand that touches most (of a creature without hands, the limb) holds the stick, and the limb that \
         carries it grows; touches of the limb have the joint between the two, or the hand, in them."
            .to_string(),
        "The error is the mean held-out error, and for the stick the tip's distance from where it is, in the \
         hand's frame; before the stick is known there is none, and its length counts. A stick has no error \
         before: the body's counts, but no less than 0.1 mm."
            .to_string(),
        "Medians over trials.".to_string(),
    ];
    let plot = StudyPlot {
        x: PlotAxis { title: "touches of the changed limb", scale: AxisScale::Logarithmic },
        y: PlotAxis { title: "error, mm (medians of trials)", scale: AxisScale::Logarithmic },
        series,
    };
    let measurements = trials.iter().flat_map(|trial| &trial.0).flat_map(RelearningCourse::measurements);
    Findings { measurements: measurements.collect(), summary, notes, plot, numbers: Vec::new() }
}

/// The limb with most touches of all that a joint carries; of hands alone, where there are any.
fn most_touching(subject: &Subject, touches: &[Touch]) -> Result<usize, ExperimentError> {
    let mut counts = vec![0; subject.body().creature.limbs().len()];
    for end in touches.iter().flat_map(|touch| &touch.ends) {
        counts[subject.agent().skin().receptors[end.receptor].limb] += 1;
    }
    let creature = &subject.body().creature;
    let hand = |limb: &usize| is_hand(creature, *limb) && counts[*limb] > 0;
    let hands = (1..counts.len()).any(|limb| hand(&limb));
    let carried = (1..counts.len())
        .filter(|limb| !hands || hand(limb))
        .max_by_key(|&limb| (counts[limb], std::cmp::Reverse(limb)));
    carried.ok_or_else(|| ExperimentError::refused("the creature has no limb that could change"))
}

/// Learns the body as it was, changes it and goes on with the same learner.
fn follow(
    subject: &Subject,
    touches: &[Touch],
    seed: u64,
    limb: usize,
    (name, change): (&str, StudiedChange),
) -> Result<RelearningCourse, ExperimentError> {
    let (body, agent) = (subject.body(), subject.agent());
    let (creature, skin) = (agent.creature(), agent.skin());
    let place = LimbInModel { model: subject.model(), joints: subject.joints(), body, limb };
    let hand: Vec<&Vector3<f64>> =
        skin.receptors.iter().filter(|r| r.limb == limb).map(|receptor| &receptor.position).collect();
    let middle: Vector3<f64> = hand.iter().copied().sum::<Vector3<f64>>() / hand.len().max(1) as f64;
    let nearest = |a: &usize, b: &usize| {
        let distance = |r: usize| (skin.receptors[r].position - middle).norm();
        distance(*a).total_cmp(&distance(*b))
    };
    let of_limb = (0..skin.receptors.len()).filter(|&r| skin.receptors[r].limb == limb);
    let grip = of_limb
        .min_by(nearest)
        .ok_or_else(|| ExperimentError::refused("the limb has no skin to hold a stick with"))?;
    // Outwards and a little aslant, as one holds a stick.
    let outwards = middle.try_normalize(1e-6).unwrap_or_else(Vector3::z);
    let aslant = crate::kinematics::tangent_basis(&outwards).column(0).into_owned();
    let base = skin.receptors[grip].position;
    let tip = base + (outwards + 0.4 * aslant).normalize() * STICK;
    let changed: Body = match change {
        StudiedChange::Growth => place.grown(GROWTH)?,
        StudiedChange::Stick => place.with_stick(&base, &tip)?,
    };
    let changed_skin = changed_skin(body, skin, &changed);
    let changed_agent = Agent::new(changed.creature.clone(), changed_skin)?;
    let changed_skin = changed_agent.skin();
    let truth = GroundTruth::new(&changed)?;
    let mut learner = Online::new(agent, seed);
    touches.iter().for_each(|touch| learner.touch(touch));
    let heldout = |schema: &crate::schema::BodySchema, truth: &GroundTruth| {
        let errors = held_out(creature, truth, schema, &held_out_points(agent));
        errors.iter().map(|e| e.millimetres).sum::<f64>() / errors.len().max(1) as f64
    };
    let body_before = heldout(&learner.learn().schema, subject.truth());
    let measure = |learner: &Online| match change {
        StudiedChange::Growth => learner.belief().map_or(f64::NAN, |belief| heldout(&belief.schema, &truth)),
        StudiedChange::Stick => {
            let tool = learner.tools().iter().find(|tool| tool.limb == limb);
            1e3 * tool.map_or(STICK, |tool| (tool.tip - tip).norm())
        }
    };
    let before_mm = match change {
        StudiedChange::Growth => body_before,
        StudiedChange::Stick => body_before.max(0.1),
    };
    let at_change_mm = measure(&learner);
    let mut course = RelearningCourse {
        change: name.into(),
        limb: creature.limbs()[limb].clone(),
        seed,
        touches: touches.len(),
        before_mm,
        at_change_mm,
        noticed: f64::INFINITY,
        errors_mm: Vec::new(),
    };
    for touch in subject.babble_body(&changed, &changed_agent, TOUCHES_AFTER, seed ^ AFTER_SEED)? {
        let Some(touch) = felt(skin, changed_skin, grip, &touch) else { continue };
        let limbs = touch.ends.map(|end| skin.receptors[end.receptor].limb);
        let joint = limb - 1;
        let of_limb = match change {
            StudiedChange::Growth => {
                Chain::between(creature, limbs[0], limbs[1]).joints().any(|j| j == joint)
            }
            StudiedChange::Stick => limbs.contains(&limb),
        };
        let known = learner.changes().len();
        learner.touch(&touch);
        if course.noticed.is_infinite() && learner.changes().len() > known {
            course.noticed = (course.errors_mm.len() + usize::from(of_limb)) as f64;
        }
        if of_limb {
            course.errors_mm.push(measure(&learner));
        }
    }
    Ok(course)
}
