//! What the studies of action share: a table, random things on it, and a creature that stands at it.

use std::ops::{Deref, DerefMut};

use nalgebra::{Isometry3, Translation3, UnitQuaternion, Vector3};
use rand::RngExt;
use rand_chacha::ChaCha8Rng;

use super::subject::Subject;
use crate::experiment::ExperimentError;
use crate::geometry::{Capsule, Frame, Shape};
use crate::interaction::{Actor, Conversation};
use crate::mujoco;
use crate::peripersonal::{CollisionChecker, OwnBody};
use crate::simulation::{Stage, StageOptions, Substance, Thing};

/// The height of the table's top in the world, metres.
pub const TOP: f64 = 0.98;
/// Where its near edge is along x, metres.
pub const EDGE: f64 = 0.22;
/// Its depth and width, metres.
const SIZE: [f64; 2] = [1.1, 2.0];
/// The name of the thing of a trial.
pub const THING: &str = "thing";
/// The hands that act.
pub const HANDS: [&str; 2] = ["left_hand", "right_hand"];

/// The table.
pub fn table() -> Thing {
    let half = [0.5 * SIZE[0], 0.5 * SIZE[1], 0.02];
    let middle = Translation3::new(EDGE + half[0], 0.0, TOP - half[2]);
    Thing {
        name: "table".into(),
        shape: Shape::Box { half_extents: half },
        pose: Isometry3::from_parts(middle, UnitQuaternion::identity()),
        fixed: true,
        substance: Substance::default(),
    }
}

/// A random shape that a hand can feel: 5 to 13 cm high, 4 to 12 cm wide.
pub fn shape(rng: &mut ChaCha8Rng) -> Shape {
    let mut size = |low: f64, high: f64| rng.random_range(low..high);
    let (a, b, c) = (size(0.02, 0.06), size(0.02, 0.06), size(0.025, 0.065));
    match rng.random_range(0..4) {
        0 => Shape::Sphere { radius: c },
        1 => Shape::Cylinder { radius: a, half_length: c },
        2 => Shape::Capsule { radius: 0.02 + 0.2 * a, half_length: 0.02 + 0.5 * b },
        _ => Shape::Box { half_extents: [a, b, c] },
    }
}

/// How far the middle of a shape that stands, or a capsule that lies, is above what it stands on, and how it is turned.
pub fn standing(shape: &Shape, heading: f64) -> (f64, UnitQuaternion<f64>) {
    let turn = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), heading);
    match shape.as_capsule(&Frame::identity()) {
        Some(Capsule { ends, radius }) if ends[0] != ends[1] => {
            (radius, turn * UnitQuaternion::from_axis_angle(&Vector3::y_axis(), 0.5 * std::f64::consts::PI))
        }
        _ => (shape.half_bounds().z, turn),
    }
}

/// A thing that stands on the table.
pub fn on_table(shape: Shape, x: f64, y: f64, heading: f64) -> Thing {
    let (height, turn) = standing(&shape, heading);
    let pose = Isometry3::from_parts(Translation3::new(x, y, TOP + height), turn);
    Thing { name: THING.into(), shape, pose, fixed: false, substance: Substance::default() }
}

/// What a creature knows, and its surfaces.
pub struct Knowledge {
    /// What it knows of its body.
    pub own: OwnBody,
    /// Its surfaces with nothing about them.
    pub clearance: CollisionChecker,
}

impl Knowledge {
    /// Works the surfaces out.
    pub fn new(own: OwnBody) -> Knowledge {
        Knowledge { clearance: CollisionChecker::new(&own), own }
    }

    /// What a subject knows by its session, or after babbling by the first of all seeds.
    ///
    /// # Errors
    /// Where it has no seeds, or its session cannot be used.
    pub fn learned(subject: &Subject) -> Result<Knowledge, ExperimentError> {
        let first = subject.seeds.first();
        let first = first.ok_or_else(|| ExperimentError::refused("a study needs a seed at least"))?;
        Ok(Knowledge::new(subject.own_body(*first)?))
    }
}

/// What all trials share of those who act by what they have learned, and beside it by the truth.
pub struct KnownBodies {
    /// By what was learned.
    pub learned: Knowledge,
    /// By the true kinematics.
    pub truth: Knowledge,
}

impl KnownBodies {
    /// Those of a subject.
    ///
    /// # Errors
    /// As of [`Knowledge::learned`].
    pub fn of(subject: &Subject) -> Result<KnownBodies, ExperimentError> {
        let learned = Knowledge::learned(subject)?;
        let truth = Knowledge::new(learned.own.with_schema(subject.truth().schema.clone()));
        Ok(KnownBodies { learned, truth })
    }
}

/// A creature that acts, and the stage that it is on for those who put it there and measure.
pub struct OnStage {
    /// Where things really are.
    pub stage: Stage,
    actor: Actor,
}

impl OnStage {
    /// A creature with what it knows among some things.
    pub fn new(
        subject: &Subject,
        known: &Knowledge,
        things: Vec<Thing>,
        seed: u64,
    ) -> Result<OnStage, ExperimentError> {
        let unfit = |clause: String| ExperimentError::unfit(subject.model(), clause);
        let root = subject.body().root_name().map(str::to_string);
        let options =
            StageOptions { joints: subject.joints().clone(), root, things, ..StageOptions::default() };
        let stage = Stage::new(subject.model(), &options).map_err(|error| unfit(error.to_string()))?;
        let (own, clearance) = (known.own.clone(), known.clearance.clone());
        let actor = Actor::with_clearance(own, clearance, stage.handle(), HANDS, seed);
        Ok(OnStage { actor: actor.map_err(|error| unfit(error.to_string()))?, stage })
    }

    /// The stage, and the creature as one that talks.
    pub fn in_conversation(self) -> Result<(Stage, Conversation), ExperimentError> {
        Ok((self.stage, Conversation::new(self.actor)?))
    }

    /// Puts the creature into a posture at once.
    pub fn place(&mut self, posture: &[f64]) -> mujoco::Result<()> {
        self.actor.was_placed();
        self.stage.place(posture)
    }

    /// The height of the table's top in the root's frame, metres.
    pub fn table_top(&self) -> f64 {
        TOP - self.stage.root_pose().translation.z
    }

    /// The number of the thing of the trial.
    pub fn the_thing(&self) -> Result<usize, ExperimentError> {
        self.stage.thing(THING).ok_or_else(|| ExperimentError::refused("the thing is not on the stage"))
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

/// A creature that stands at the table among things, its hands raised.
pub fn at_table(
    subject: &Subject,
    known: &Knowledge,
    things: &[Thing],
    seed: u64,
) -> Result<OnStage, ExperimentError> {
    let things: Vec<Thing> = std::iter::once(table()).chain(things.iter().cloned()).collect();
    let mut actor = OnStage::new(subject, known, things, seed)?;
    let ready = actor.ready();
    actor.place(&ready)?;
    Ok(actor)
}
