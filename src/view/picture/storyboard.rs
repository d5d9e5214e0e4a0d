//! What a session gives to see: a touch, one touch after the other, or how the body was learned.

use nalgebra::{Isometry3, Point3};

use super::Shot;
use super::figure::{between, learned_body, lit_touch};
use super::framing::{extent, outline};
use crate::agent::Agent;
use crate::creature::{Body, Posture};
use crate::error::Result;
use crate::mujoco::{GeomCopy, Mark};
use crate::named::in_words;
use crate::schema::BodySchema;
use crate::senses::RecordedTouch;
use crate::session::Checkpoint;
use crate::view::text::{self, error_number};

/// Seconds from one touch to the next.
const MOTION: f64 = 0.9;
/// Seconds for which a touch is shown.
const PAUSE: f64 = 0.6;
/// Seconds for which the initial guess is shown.
const GUESS: f64 = 1.0;
/// Seconds from one checkpoint to the next.
const STEP: f64 = 0.6;
/// Seconds for which the end is shown.
const END: f64 = 1.5;
/// Every so-many-th frame is enough to determine how much room a motion takes.
const HELD_EVERY: usize = 3;

/// What is drawn, picture by picture.
#[derive(Clone, Debug, PartialEq)]
pub struct Storyboard {
    /// One or more, in their order.
    pub shots: Vec<Shot>,
    /// Whether the true body is but a shade that another is drawn over.
    pub shaded: bool,
}

impl Storyboard {
    /// The shots that the camera is to hold all of.
    pub fn held(&self) -> impl Iterator<Item = &Shot> {
        self.shots.iter().step_by(HELD_EVERY).chain(self.shots.last())
    }
}

/// A session's body, and what drawing needs of it.
pub struct SessionDrawing<'a> {
    agent: &'a Agent,
    body: &'a Body,
    schema: Option<BodySchema>,
    /// Greatest extent of the body, metres.
    size: f64,
    /// `X_WR`, which no posture moves.
    root: Isometry3<f64>,
    frames_per_second: f64,
}

impl<'a> SessionDrawing<'a> {
    /// A drawing of an agent's body, with the learned one over it if there is a schema.
    ///
    /// # Errors
    /// If the engine fails.
    pub fn new(
        agent: &'a Agent,
        body: &'a Body,
        schema: Option<BodySchema>,
        frames_per_second: f64,
    ) -> Result<SessionDrawing<'a>> {
        let at_rest = body.reference_data()?;
        let size = extent(&outline(&at_rest, &|geom| body.limb_of_geom(geom).is_some())).max(1e-3);
        let root = body.limb_pose(&at_rest, 0).unwrap_or_default();
        Ok(SessionDrawing { agent, body, schema, size, root, frames_per_second })
    }

    fn qpos(&self, posture: &[f64]) -> Vec<f64> {
        let mut qpos = vec![0.0; self.body.model.nq()];
        self.body.write_qpos(posture, &mut qpos);
        qpos
    }

    /// The limbs of a touch, in words.
    fn limbs(&self, touch: &RecordedTouch) -> String {
        let limbs = touch.limbs(self.agent.skin());
        let [a, b] = limbs.map(|limb| in_words(&self.agent.creature().limbs()[limb]));
        format!("{a}, {b}")
    }

    /// The receptors of a touch, lit.
    fn lit(&self, touch: &RecordedTouch) -> Result<Vec<Mark>> {
        let mut data = self.body.reference_data()?;
        data.set_qpos(&self.qpos(&touch.posture))?;
        data.kinematics()?;
        let receptors = touch.ends.map(|end| {
            let receptor = &self.agent.skin().receptors[end.receptor];
            (receptor, self.body.limb_pose(&data, receptor.limb).unwrap_or_default())
        });
        let [a, b] = [0, 1].map(|end| receptors[end].1 * Point3::from(touch.exact_contact().points[end]));
        Ok(lit_touch(receptors, &nalgebra::center(&a, &b), self.size))
    }

    /// The body in a posture.
    fn shot(&self, posture: &[f64]) -> Shot {
        let learned = |schema| learned_body(self.body, schema, posture, &self.root);
        let copies = self.schema.as_ref().map_or(Vec::new(), learned);
        Shot { qpos: self.qpos(posture), copies, ..Shot::default() }
    }

    /// The body as it touches itself; the touch has a number.
    fn touched(&self, number: usize, touch: &RecordedTouch) -> Result<Shot> {
        let caption = format!("touch {number}: {}", self.limbs(touch));
        Ok(Shot { lit: self.lit(touch)?, caption, ..self.shot(&touch.posture) })
    }

    /// A single picture or a film of some shots.
    fn board(&self, shots: Vec<Shot>) -> Storyboard {
        Storyboard { shots, shaded: self.schema.is_some() }
    }

    /// One picture of the body in a posture.
    pub fn posture(&self, posture: &[f64]) -> Storyboard {
        self.board(vec![self.shot(posture)])
    }

    /// One picture of a touch of a number.
    ///
    /// # Errors
    /// If the engine fails.
    pub fn touch(&self, number: usize, touch: &RecordedTouch) -> Result<Storyboard> {
        Ok(self.board(vec![self.touched(number, touch)?]))
    }

    /// The number of pictures of some seconds, at least one.
    fn frames(&self, seconds: f64) -> usize {
        ((seconds * self.frames_per_second).round() as usize).max(1)
    }

    /// From touch to touch, the first of which has a number.
    ///
    /// # Errors
    /// If the engine fails.
    pub fn touches(&self, first: usize, touches: &[RecordedTouch]) -> Result<Storyboard> {
        let creature = self.agent.creature();
        let mut shots = Vec::new();
        let mut from = Posture::start(creature);
        for (number, touch) in (first..).zip(touches) {
            let count = self.frames(MOTION);
            shots.extend((0..count).map(|k| {
                let share = eased(k as f64 / count as f64);
                self.shot(&Posture::between(creature, &from, &touch.posture, share))
            }));
            shots.extend(std::iter::repeat_n(self.touched(number, touch)?, self.frames(PAUSE)));
            from.clone_from(&touch.posture);
        }
        Ok(self.board(shots))
    }

    /// From checkpoint to checkpoint of learning, the body in the rest posture.
    pub fn learning(&self, checkpoints: &[Checkpoint]) -> Storyboard {
        let posture = Posture::start(self.agent.creature());
        let qpos = self.qpos(&posture);
        let body =
            |checkpoint: &Checkpoint| learned_body(self.body, &checkpoint.schema, &posture, &self.root);
        let shot = |copies: Vec<GeomCopy>, at: &Checkpoint| Shot {
            qpos: qpos.clone(),
            copies,
            caption: caption(at),
            ..Shot::default()
        };
        let still = |at: &Checkpoint, seconds: f64| {
            std::iter::repeat_n(shot(body(at), at), self.frames(seconds)).collect::<Vec<_>>()
        };
        let mut shots = checkpoints.first().map_or(Vec::new(), |first| still(first, GUESS));
        for pair in checkpoints.windows(2) {
            let (from, to) = (body(&pair[0]), body(&pair[1]));
            let count = self.frames(STEP);
            let moving = (0..count).map(|k| eased(k as f64 / count as f64));
            shots.extend(moving.map(|share| shot(between(&from, &to, share), &pair[0])));
        }
        shots.extend(checkpoints.last().map_or(Vec::new(), |last| still(last, END)));
        Storyboard { shots, shaded: true }
    }
}

/// The touches of a checkpoint, and its error if known.
fn caption(at: &Checkpoint) -> String {
    let touches = match at.touches {
        0 => "a random initial guess".to_string(),
        count => text::touches(count),
    };
    touches + &at.error_rms.map_or(String::new(), |error| format!("   {} mm", error_number(error)))
}

/// From 0 to 1 with a gentle beginning and end.
fn eased(x: f64) -> f64 {
    x * x * (3.0 - 2.0 * x)
}
