//! How soon a body that changes is known again.

use nalgebra::Vector3;

use super::changed_body::{Place, changed_skin, felt};
use super::plot::{Axis, Plot, Scale, Series};
use super::subject::{Subject, median, share};
use super::table::{Column, Table};
use super::{Failure, Findings, Study};
use crate::creature::Body;
use crate::evaluation::{held_out, held_out_points, is_hand};
use crate::ground_truth::GroundTruth;
use crate::kinematics::Chain;
use crate::learning::{Learner, Online};
use crate::senses::Touch;

/// The study `growth`.
pub const STUDY: Study = Study {
    name: "growth",
    about: "how soon lm knows a limb that has grown, a stick in the hand",
    touches: true,
    measure,
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

const MEASUREMENTS: &[Column] = &[
    Column { name: "change", heading: "change" },
    Column { name: "limb", heading: "limb" },
    Column { name: "seed", heading: "seed" },
    Column { name: "touches", heading: "touches" },
    Column { name: "touches_of_limb", heading: "touches of the limb" },
    Column { name: "error_mm", heading: "error, mm" },
    Column { name: "error_before_mm", heading: "error before, mm" },
];

const SUMMARY: &[Column] = &[
    Column { name: "change", heading: "change" },
    Column { name: "error_before_mm", heading: "error before, mm" },
    Column { name: "error_at_change_mm", heading: "at the change, mm" },
    Column { name: "touches_to_notice", heading: "touches of the limb to notice" },
    Column { name: "touches_to_twice", heading: "to twice the error before" },
    Column { name: "known_again", heading: "known again, share" },
    Column { name: "error_after_mm", heading: "error at the end, mm" },
];

/// What changes.
#[derive(Clone, Copy)]
enum Change {
    Growth,
    Stick,
}

/// One trial of one change.
struct Course {
    before_mm: f64,
    at_change_mm: f64,
    /// Touches of the changed limb until the change was explained.
    noticed: f64,
    /// Per touch of the changed limb, the error after it.
    errors_mm: Vec<f64>,
}

impl Course {
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

fn measure(subject: &Subject) -> Result<Findings, Failure> {
    let changes = [("limb grows by 50 mm", Change::Growth), ("stick of 300 mm in the hand", Change::Stick)];
    let mut measurements = Table::new(MEASUREMENTS);
    let mut courses: [Vec<Course>; 2] = [Vec::new(), Vec::new()];
    for &seed in &subject.seeds {
        let touches = subject.babble(seed)?;
        let limb = most_touching(subject, &touches)?;
        for ((name, change), courses) in changes.iter().zip(&mut courses) {
            subject.tell(seed, name);
            let course = follow(subject, &touches, seed, limb, *change)?;
            for (k, error) in course.errors_mm.iter().enumerate() {
                measurements.row([
                    (*name).into(),
                    subject.body.creature.limbs()[limb].clone().into(),
                    seed.into(),
                    touches.len().into(),
                    (k + 1).into(),
                    (*error).into(),
                    course.before_mm.into(),
                ]);
            }
            courses.push(course);
        }
    }
    let mut summary = Table::new(SUMMARY);
    let mut series = Vec::new();
    for ((name, _), courses) in changes.iter().zip(&courses) {
        let median_of = |value: fn(&Course) -> f64| median(courses.iter().map(value));
        summary.row([
            (*name).into(),
            median_of(|course| course.before_mm).into(),
            median_of(|course| course.at_change_mm).into(),
            median_of(|course| course.noticed).into(),
            median_of(Course::to_twice).into(),
            share(courses.iter().map(|course| course.to_twice().is_finite())).into(),
            median_of(|course| course.errors_mm.last().copied().unwrap_or(f64::NAN)).into(),
        ]);
        let most = courses.iter().map(|course| course.errors_mm.len()).min().unwrap_or(0);
        let at = |k: usize| median(courses.iter().map(|course| course.errors_mm[k]));
        let line = (0..most).map(|k| ((k + 1) as f64, at(k))).collect();
        series.push(Series { name: (*name).to_string(), line, dots: Vec::new() });
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
    let plot = Plot {
        x: Axis { title: "touches of the changed limb", scale: Scale::Logarithmic },
        y: Axis { title: "error, mm (medians of trials)", scale: Scale::Logarithmic },
        series,
    };
    Ok(Findings { measurements, summary, notes, plot, numbers: Vec::new() })
}

/// The limb with most touches of all that a joint carries; of hands alone, where there are any.
fn most_touching(subject: &Subject, touches: &[Touch]) -> Result<usize, Failure> {
    let mut counts = vec![0; subject.body.creature.limbs().len()];
    for end in touches.iter().flat_map(|touch| &touch.ends) {
        counts[subject.skin.receptors[end.receptor].limb] += 1;
    }
    let creature = &subject.body.creature;
    let hand = |limb: &usize| is_hand(creature, *limb) && counts[*limb] > 0;
    let hands = (1..counts.len()).any(|limb| hand(&limb));
    let carried = (1..counts.len())
        .filter(|limb| !hands || hand(limb))
        .max_by_key(|&limb| (counts[limb], std::cmp::Reverse(limb)));
    carried.ok_or_else(|| Failure("the creature has no limb that could change".into()))
}

/// Learns the body as it was, changes it and goes on with the same learner.
fn follow(
    subject: &Subject,
    touches: &[Touch],
    seed: u64,
    limb: usize,
    change: Change,
) -> Result<Course, Failure> {
    let (body, skin) = (&subject.body, &subject.skin);
    let creature = &body.creature;
    let place = Place { model: subject.model(), joints: subject.joints(), body, limb };
    let hand: Vec<&Vector3<f64>> =
        skin.receptors.iter().filter(|r| r.limb == limb).map(|receptor| &receptor.position).collect();
    let middle: Vector3<f64> = hand.iter().copied().sum::<Vector3<f64>>() / hand.len().max(1) as f64;
    let nearest = |a: &usize, b: &usize| {
        let distance = |r: usize| (skin.receptors[r].position - middle).norm();
        distance(*a).total_cmp(&distance(*b))
    };
    let of_limb = (0..skin.receptors.len()).filter(|&r| skin.receptors[r].limb == limb);
    let grip = of_limb.min_by(nearest).ok_or("the limb has no skin to hold a stick with")?;
    // Outwards and a little aslant, as one holds a stick.
    let outwards = middle.try_normalize(1e-6).unwrap_or_else(Vector3::z);
    let aslant = crate::kinematics::tangent_basis(&outwards).column(0).into_owned();
    let base = skin.receptors[grip].position;
    let tip = base + (outwards + 0.4 * aslant).normalize() * STICK;
    let changed: Body = match change {
        Change::Growth => place.grown(GROWTH)?,
        Change::Stick => place.with_stick(&base, &tip)?,
    };
    let changed_skin = changed_skin(body, skin, &changed);
    let truth = GroundTruth::new(&changed)?;
    let mut learner = Online::new(creature, skin, seed);
    touches.iter().for_each(|touch| learner.touch(touch));
    let heldout = |schema: &crate::schema::BodySchema, truth: &GroundTruth| {
        let errors = held_out(creature, truth, schema, &held_out_points(creature, skin));
        errors.iter().map(|e| e.millimetres).sum::<f64>() / errors.len().max(1) as f64
    };
    let body_before = heldout(&learner.learn().schema, &subject.truth);
    let measure = |learner: &Online| match change {
        Change::Growth => learner.belief().map_or(f64::NAN, |belief| heldout(&belief.schema, &truth)),
        Change::Stick => {
            let tool = learner.tools().iter().find(|tool| tool.limb == limb);
            1e3 * tool.map_or(STICK, |tool| (tool.tip - tip).norm())
        }
    };
    let before_mm = match change {
        Change::Growth => body_before,
        Change::Stick => body_before.max(0.1),
    };
    let at_change_mm = measure(&learner);
    let mut course = Course { before_mm, at_change_mm, noticed: f64::INFINITY, errors_mm: Vec::new() };
    for touch in subject.babble_body(&changed, &changed_skin, TOUCHES_AFTER, seed ^ AFTER_SEED)? {
        let Some(touch) = felt(skin, &changed_skin, grip, &touch) else { continue };
        let limbs = touch.ends.map(|end| skin.receptors[end.receptor].limb);
        let joint = limb - 1;
        let of_limb = match change {
            Change::Growth => Chain::between(creature, limbs[0], limbs[1]).joints().any(|j| j == joint),
            Change::Stick => limbs.contains(&limb),
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
