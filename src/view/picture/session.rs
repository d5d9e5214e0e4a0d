//! What a session gives to see: a posture, a touch, one touch after the other, or how the body was learned.

use nalgebra::{Isometry3, Matrix3, Point3, Translation3};

use super::Shot;
use super::framing::{extent, outline};
use crate::agent::Agent;
use crate::creature::{Body, Posture};
use crate::error::Result;
use crate::geometry::Frame;
use crate::kinematics::limb_frames;
use crate::mujoco::{GeomCopy, GeomKind, Mark};
use crate::named::{in_words, plural};
use crate::schema::BodySchema;
use crate::senses::RecordedTouch;
use crate::session::Checkpoint;
use crate::view::text::error_number;

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
/// The colours of the two receptors, of the point where they touch, and of the glow about it: without any blue.
const FIRING: [f32; 4] = [1.0, 0.45, 0.0, 1.0];
const POINT: [f32; 4] = [0.95, 0.0, 0.0, 1.0];
const GLOW: [f32; 4] = [1.0, 0.25, 0.0, 0.3];
/// The longest motion of a film that nobody sees, by the size of the body, about a quarter of a pixel; and the same, radians.
const UNSEEN: f64 = 3e-4;
/// Radii of the point and of its glow, and how thick a receptor is, by the size of the body.
const POINT_RADIUS: f64 = 0.012;
const GLOW_RADIUS: f64 = 0.03;
const THICKNESS: f64 = 0.003;

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
        let size = extent(&outline(&at_rest, &|geom| body.limb_of_geom(geom).is_some())).max().max(1e-3);
        let root = body.limb_pose(&at_rest, 0).unwrap_or_default();
        Ok(SessionDrawing { agent, body, schema, size, root, frames_per_second })
    }

    /// The body in a posture.
    pub fn posture(&self, posture: &[f64]) -> Shot {
        let qpos = self.body.qpos(posture);
        let copies = self.schema.as_ref().map_or(Vec::new(), |schema| self.learned(schema, posture));
        Shot { qpos, copies, ..Shot::default() }
    }

    /// The body as it touches itself; the touch has a number.
    ///
    /// # Errors
    /// If the engine fails.
    pub fn touch(&self, number: usize, touch: &RecordedTouch) -> Result<Shot> {
        let shot = self.posture(&touch.posture);
        let limbs = touch.limbs(self.agent.skin());
        let [a, b] = limbs.map(|limb| in_words(&self.agent.creature().limbs()[limb]));
        Ok(Shot { lit: self.lit(touch, &shot.qpos)?, caption: format!("touch {number}: {a}, {b}"), ..shot })
    }

    /// From touch to touch, the first of which has a number.
    ///
    /// # Errors
    /// If the engine fails.
    pub fn touches(&self, first: usize, touches: &[RecordedTouch]) -> Result<Vec<Shot>> {
        let creature = self.agent.creature();
        let mut shots = Vec::new();
        let mut from = Posture::start(creature);
        for (number, touch) in (first..).zip(touches) {
            let between = |share| self.posture(&Posture::between(creature, &from, &touch.posture, share));
            shots.extend(self.shares(MOTION).map(between));
            shots.extend(std::iter::repeat_n(self.touch(number, touch)?, self.frames(PAUSE)));
            from.clone_from(&touch.posture);
        }
        Ok(shots)
    }

    /// From checkpoint to checkpoint of learning, the body in the rest posture.
    pub fn learning(&self, checkpoints: &[Checkpoint]) -> Vec<Shot> {
        let [Some(first), Some(last)] = [checkpoints.first(), checkpoints.last()] else { return Vec::new() };
        let posture = Posture::start(self.agent.creature());
        let body = |at: &Checkpoint| self.learned(&at.schema, &posture);
        let true_body = self.posture(&posture);
        let shot = |copies, at: &Checkpoint| Shot { copies, caption: caption(at), ..true_body.clone() };
        let still = |at, seconds| std::iter::repeat_n(shot(body(at), at), self.frames(seconds));
        let mut shots: Vec<Shot> = still(first, GUESS).collect();
        for pair in checkpoints.windows(2) {
            let (from, to) = (body(&pair[0]), body(&pair[1]));
            let moves = from.iter().zip(&to).any(|(from, to)| self.is_seen(&from.pose, &to.pose));
            let at = |share| if moves { between(&from, &to, share) } else { from.clone() };
            shots.extend(self.shares(STEP).map(|share| shot(at(share), &pair[0])));
        }
        shots.extend(still(last, END));
        shots
    }

    /// Whether anybody sees in a film that a geom moves from one pose to another.
    fn is_seen(&self, from: &Isometry3<f64>, to: &Isometry3<f64>) -> bool {
        let moved = (from.translation.vector - to.translation.vector).norm();
        moved > UNSEEN * self.size || from.rotation.angle_to(&to.rotation) > UNSEEN
    }

    /// The number of pictures of some seconds, at least one.
    fn frames(&self, seconds: f64) -> usize {
        ((seconds * self.frames_per_second).round() as usize).max(1)
    }

    /// The shares of a motion of some seconds at its pictures, from 0 to 1 with a gentle beginning and end.
    fn shares(&self, seconds: f64) -> impl Iterator<Item = f64> + use<> {
        let count = self.frames(seconds);
        (0..count).map(move |k| k as f64 / count as f64).map(|x| x * x * (3.0 - 2.0 * x))
    }

    /// The geoms of the body placed by a schema in a posture.
    fn learned(&self, schema: &BodySchema, posture: &[f64]) -> Vec<GeomCopy> {
        let model = &self.body.model;
        let frames = limb_frames(&self.body.creature, schema, posture);
        let place = |geom: usize| {
            let limb = Isometry3::from(frames[self.body.limb_of_geom(geom)?]);
            let on_limb = self.body.geom_in_limb(&model.geom(geom));
            Some(GeomCopy { geom, pose: self.root * limb * on_limb })
        };
        (0..model.ngeom()).filter(|&geom| !model.is_aura(geom)).filter_map(place).collect()
    }

    /// The receptors of a touch, and the point between them.
    fn lit(&self, touch: &RecordedTouch, qpos: &[f64]) -> Result<Vec<Mark>> {
        let mut data = self.body.reference_data()?;
        data.set_qpos(qpos)?;
        data.kinematics()?;
        let receptors = touch.ends.map(|end| &self.agent.skin().receptors[end.receptor]);
        let limbs = receptors.map(|r| self.body.limb_pose(&data, r.limb).unwrap_or_default());
        let patch = |end: usize| {
            let receptor = receptors[end];
            let axes = Matrix3::from_columns(&[receptor.tangent, receptor.bitangent(), receptor.normal]);
            let [a, b] = receptor.half_extents;
            let pose = limbs[end] * Isometry3::from(Frame { rotation: axes, origin: receptor.position });
            let size = [a, b, THICKNESS * self.size];
            Mark { kind: GeomKind::Box, size, pose, rgba: FIRING, emission: 1.0 }
        };
        let [a, b] = [0, 1].map(|end| limbs[end] * Point3::from(touch.exact_contact().points[end]));
        let point = nalgebra::center(&a, &b);
        let sphere =
            |radius: f64, colour| Mark { emission: 1.0, ..Mark::sphere(&point, radius * self.size, colour) };
        Ok(vec![patch(0), patch(1), sphere(POINT_RADIUS, POINT), sphere(GLOW_RADIUS, GLOW)])
    }
}

/// Geoms moved from some poses towards others, at 0 to 1 of the path.
fn between(from: &[GeomCopy], to: &[GeomCopy], share: f64) -> Vec<GeomCopy> {
    let moved = |(from, to): (&GeomCopy, &GeomCopy)| {
        let nearer = if share < 0.5 { from } else { to };
        let rotation = from.pose.rotation.try_slerp(&to.pose.rotation, share, 1e-9);
        let translation = from.pose.translation.vector.lerp(&to.pose.translation.vector, share);
        let rotation = rotation.unwrap_or(nearer.pose.rotation);
        GeomCopy { geom: from.geom, pose: Isometry3::from_parts(Translation3::from(translation), rotation) }
    };
    from.iter().zip(to).map(moved).collect()
}

/// The touches of a checkpoint, and its error if known.
fn caption(at: &Checkpoint) -> String {
    let touches = match at.touches {
        0 => "a random initial guess".to_string(),
        count => plural(count, "touch"),
    };
    touches + &at.error_rms.map_or(String::new(), |error| format!("   {} mm", error_number(error)))
}
