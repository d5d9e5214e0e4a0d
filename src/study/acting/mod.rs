//! How well a creature acts by the body that it has learned, beside the same by its true body.

mod avoid;
mod farthest;
mod find;
mod other_hand;

use std::ops::{Deref, DerefMut};

use nalgebra::{Isometry3, Translation3, UnitQuaternion, Vector3};
use rand::RngExt;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use serde_json::json;

use super::subject::Knowledge;
use super::{Row, Studied, Study, Subject, Trial, columns};
use crate::error::{Error, Result};
use crate::geometry::{Capsule, Frame, Shape};
use crate::interaction::Actor;
use crate::simulation::{Stage, Substance, Thing};

pub(super) const STUDY: Study = Study {
    name: "acting",
    about: "success of actions with the learned body, compared with the true body",
    of: Studied::Acting,
    touches: None,
    seconds: None,
    cases: || TASKS.map(|(name, _)| name.to_string()).into(),
    columns: columns! {
        task: Case, schema: Case, seed, limb, done: Share, first: Share, error_mm: Median Most,
        felt_mm: Median, felt_on_mm: Median, contact_mm: Median, forward_m: Median,
        of_true_reach: Median Least, things: Sum, found: Sum, phantoms: Sum, done_later: Share,
        others_still: Share, unintended: Share, simulated_s: Median, result,
    },
    notes: &[
        "other hand: one arm finds a thing on a table, or a thing is held against it in the air. done: the other hand touches it; first: on the first attempt; error_mm: distance from the arm's contact to the nearest skin of the hand; felt_mm: from \
         where the arm, whose receptors have an extent, located the touch to where it was; felt_on_mm: the same after feeling \
         on; contact_mm: between both contacts, on the thing; unintended: anything else was met.",
        "farthest: it puts what it holds as far away as it can, upright or leaning. done: the thing stands within \
         3 cm of the planned position; forward_m: distance reached by the grip; of_true_reach: the same as a \
         share of what the search reaches with the true body.",
        "find: it counts 1 to 5 things on a table. done: the count is right; found: things remembered within 5 cm \
         of their surface; phantoms: things remembered elsewhere; done_later: the count is right after a thing \
         was removed.",
        "avoid: a thing approaches on a collision course. done: no touch; others_still: limbs that are not \
         threatened move by less than 10 mm; unintended: an arm touched the body.",
    ],
    run,
};

/// A task: what a scene makes of it, in rows without what is common to all.
type Task = fn(&Scene) -> Result<Vec<Row>, Error>;

/// The tasks; a line here is all that another one needs beside its file.
const TASKS: [(&str, Task); 6] = [
    ("other hand, table", |scene| other_hand::run(scene, true)),
    ("other hand, air", |scene| other_hand::run(scene, false)),
    ("farthest, upright", |scene| farthest::run(scene, false)),
    ("farthest, leaning", |scene| farthest::run(scene, true)),
    ("find", find::run),
    ("avoid", avoid::run),
];

/// The height of the table's top in the world, metres.
const TOP: f64 = 0.98;
/// Where its near edge is along x, metres.
const EDGE: f64 = 0.22;
/// Its depth and width, metres.
const SIZE: [f64; 2] = [1.1, 2.0];
/// The name of the thing of a trial.
const THING: &str = "thing";
/// The hands that act.
const HANDS: [&str; 2] = ["left_hand", "right_hand"];

fn run(trial: &Trial) -> Result<Vec<Row>, Error> {
    let subject = trial.subject()?;
    let [learned, truth] = subject.known()?;
    let scene = Scene { subject, learned, truth, seed: trial.seed };
    let mut all = Vec::new();
    for (name, task) in TASKS.into_iter().filter(|(name, _)| trial.asks(name)) {
        for mut row in task(&scene)? {
            row["task"] = json!(name);
            all.push(row);
        }
    }
    Ok(all)
}

/// What a task has to do with: a creature by what it has learned, and by the truth.
struct Scene<'a> {
    subject: &'a Subject,
    learned: &'a Knowledge,
    truth: &'a Knowledge,
    seed: u64,
}

impl Scene<'_> {
    /// A row of an attempt by each of both schemas.
    fn by_each_schema(
        &self,
        mut attempt: impl FnMut(&Knowledge) -> Result<Row, Error>,
    ) -> Result<Vec<Row>, Error> {
        let row = |(name, known)| {
            let mut row = attempt(known)?;
            row["schema"] = json!(name);
            Ok(row)
        };
        [("learned", self.learned), ("true", self.truth)].into_iter().map(row).collect()
    }

    /// The random numbers of the trial.
    fn rng(&self, stream: u64) -> ChaCha8Rng {
        let mut rng = ChaCha8Rng::seed_from_u64(self.seed);
        rng.set_stream(stream);
        rng
    }

    /// A creature with what it knows among some things.
    fn among(&self, known: &Knowledge, things: Vec<Thing>) -> Result<OnStage, Error> {
        let stage = self.subject.stage(&self.subject.source().joints, &[], things)?;
        let (own, clearance) = (known.own.clone(), known.clearance.clone());
        let actor = Actor::with_clearance(own, clearance, stage.handle(), HANDS, self.seed);
        let actor = actor.map_err(|error| Error::unfit(self.subject.model(), error.to_string()))?;
        Ok(OnStage { stage, actor })
    }

    /// A creature that stands at the table among things, its hands raised.
    fn at_table(&self, known: &Knowledge, things: &[Thing]) -> Result<OnStage, Error> {
        let half = [0.5 * SIZE[0], 0.5 * SIZE[1], 0.02];
        let middle = Translation3::new(EDGE + half[0], 0.0, TOP - half[2]);
        let table = Thing {
            name: "table".into(),
            shape: Shape::Box { half_extents: half },
            pose: Isometry3::from_parts(middle, UnitQuaternion::identity()),
            fixed: true,
            substance: Substance::default(),
        };
        let mut actor = self.among(known, std::iter::once(table).chain(things.iter().cloned()).collect())?;
        let ready = actor.ready();
        actor.place(&ready)?;
        Ok(actor)
    }
}

/// A creature that acts, and the stage that it is on for those who put it there and measure.
struct OnStage {
    /// Where things really are.
    stage: Stage,
    actor: Actor,
}

impl OnStage {
    /// Puts the creature into a posture at once.
    fn place(&mut self, posture: &[f64]) -> Result<()> {
        self.actor.was_placed();
        self.stage.place(posture)
    }

    /// Has it feel with both hands how high the table is, and know it from then on; whether it does.
    fn finds_table(&mut self) -> bool {
        let height = self.feel_table(0).and_then(|a| Ok(a.min(self.feel_table(1)?)));
        height.map(|height| self.know_table(height)).is_ok()
    }

    /// The height of the table's top in the root's frame, metres.
    fn table_top(&self) -> f64 {
        TOP - self.stage.root_pose().translation.z
    }

    /// The number of the thing of the trial.
    fn the_thing(&self) -> Result<usize, Error> {
        self.stage.thing(THING).ok_or_else(|| Error::usage("the thing is not on the stage"))
    }
}

impl Deref for OnStage {
    type Target = Actor;

    fn deref(&self) -> &Actor {
        &self.actor
    }
}

impl DerefMut for OnStage {
    fn deref_mut(&mut self) -> &mut Actor {
        &mut self.actor
    }
}

/// A random shape that a hand can feel: 5 to 13 cm high, 4 to 12 cm wide.
fn shape(rng: &mut ChaCha8Rng) -> Shape {
    let mut size = |low: f64, high: f64| rng.random_range(low..high);
    let (a, b, c) = (size(0.02, 0.06), size(0.02, 0.06), size(0.025, 0.065));
    match rng.random_range(0..4) {
        0 => Shape::Sphere { radius: c },
        1 => Shape::Cylinder { radius: a, half_length: c },
        2 => Shape::Capsule { radius: 0.02 + 0.2 * a, half_length: 0.02 + 0.5 * b },
        _ => Shape::Box { half_extents: [a, b, c] },
    }
}

/// A thing that stands on the table, or a capsule that lies there.
fn on_table(shape: Shape, x: f64, y: f64, heading: f64) -> Thing {
    let upright = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), heading);
    let (height, turn) = match shape.as_capsule(&Frame::identity()) {
        Some(Capsule { ends, radius }) if ends[0] != ends[1] => {
            let lying = UnitQuaternion::from_axis_angle(&Vector3::y_axis(), 0.5 * std::f64::consts::PI);
            (radius, upright * lying)
        }
        _ => (shape.half_bounds().z, upright),
    };
    let pose = Isometry3::from_parts(Translation3::new(x, y, TOP + height), turn);
    Thing { name: THING.into(), shape, pose, fixed: false, substance: Substance::default() }
}
