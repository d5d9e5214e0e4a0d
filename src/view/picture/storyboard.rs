//! What a session gives to see: a touch, the touches one after the other, or how the body was learned.

use nalgebra::{Isometry3, Point3};

use super::{Shot, between, extent, learned_body, lit_touch, outline};
use crate::agent::Agent;
use crate::creature::{Body, Posture};
use crate::mujoco::{self, GeomCopy, Mark};
use crate::named::in_words;
use crate::record::Checkpoint;
use crate::schema::BodySchema;
use crate::senses::Touch;
use crate::view::text::{self, error_number};

/// Seconds from one touch to the next, and for which a touch is looked at.
const MOTION: f64 = 0.9;
const PAUSE: f64 = 0.6;
/// The part of a motion in which the places of a touch light up, and the last ones go out.
const LIGHTING: f64 = 0.2;
/// Seconds for which the initial guess is looked at and the end, …
const GUESS: f64 = 1.0;
const END: f64 = 1.5;
/// … and from one checkpoint to the next: as long where little moves, and by so much longer where as much as the body
/// is large.
const STEP: f64 = 0.2;
const LONGER: f64 = 3.0;
/// Errors below this are all alike, millimetres.
const TINY: f64 = 1e-4;

/// What is drawn, picture by picture.
#[derive(Clone, Debug, PartialEq)]
pub struct Storyboard {
    /// One or more, in their order.
    pub shots: Vec<Shot>,
    /// Indices of shots that the camera is to hold all of.
    pub held: Vec<usize>,
    /// Whether the true body is but a shade that another is drawn over.
    pub shaded: bool,
}

impl Storyboard {
    /// A single picture.
    pub fn still(shot: Shot, shaded: bool) -> Storyboard {
        Storyboard { shots: vec![shot], held: vec![0], shaded }
    }
}

/// A session's body, and what is known of it for drawing.
pub struct SessionDrawing<'a> {
    agent: &'a Agent,
    body: &'a Body,
    schema: Option<BodySchema>,
    /// Greatest extent of the body, metres.
    size: f64,
    frames_per_second: f64,
}

impl<'a> SessionDrawing<'a> {
    /// A drawing of an agent's body, with the learned one over it where that is to be seen.
    ///
    /// # Errors
    /// Where the engine fails.
    pub fn new(
        agent: &'a Agent,
        body: &'a Body,
        schema: Option<BodySchema>,
        frames_per_second: f64,
    ) -> mujoco::Result<SessionDrawing<'a>> {
        let at_ease = body.reference_data()?;
        let size = extent(&outline(&at_ease, &|geom| body.limb_of_geom(geom).is_some())).max(1e-3);
        Ok(SessionDrawing { agent, body, schema, size, frames_per_second })
    }

    /// The body in a posture, and where its root limb is.
    fn qpos(&self, posture: &[f64]) -> Vec<f64> {
        let mut qpos = vec![0.0; self.body.model.nq()];
        self.body.write_qpos(posture, &mut qpos);
        qpos
    }

    /// The learned body in a posture, where it is to be seen.
    fn learned(&self, posture: &[f64]) -> mujoco::Result<Vec<GeomCopy>> {
        let Some(schema) = &self.schema else { return Ok(Vec::new()) };
        Ok(learned_body(self.body, schema, posture, &self.root()?))
    }

    /// The limbs that a touch is of, in words.
    fn limbs(&self, touch: &Touch) -> String {
        let receptors = touch.ends.map(|end| &self.agent.skin().receptors[end.receptor]);
        let [a, b] = receptors.map(|receptor| in_words(&self.agent.creature().limbs()[receptor.limb]));
        format!("{a}, {b}")
    }

    /// `X_WR`, which no posture moves.
    fn root(&self) -> mujoco::Result<Isometry3<f64>> {
        Ok(self.body.limb_pose(&self.body.reference_data()?, 0).unwrap_or_default())
    }

    /// The places of a touch, lit, when the body is in some posture.
    fn lit(&self, touch: &Touch, strength: f64, posture: &[f64]) -> mujoco::Result<Vec<Mark>> {
        let mut data = self.body.reference_data()?;
        data.set_qpos(&self.qpos(posture))?;
        data.kinematics()?;
        let receptor = |end: usize| {
            let receptor = &self.agent.skin().receptors[touch.ends[end].receptor];
            (receptor, self.body.limb_pose(&data, receptor.limb).unwrap_or_default())
        };
        let receptors = [receptor(0), receptor(1)];
        // Unless the body is on its way the two points are one.
        let [a, b] = [0, 1].map(|end| receptors[end].1 * Point3::from(touch.ends[end].contact));
        Ok(lit_touch(receptors, &nalgebra::center(&a, &b), strength, self.size))
    }

    fn shot(&self, posture: &[f64], lit: &[(&Touch, f64)]) -> mujoco::Result<Shot> {
        let mut marks = Vec::new();
        for (touch, strength) in lit.iter().filter(|(_, strength)| *strength > 0.0) {
            marks.extend(self.lit(touch, *strength, posture)?);
        }
        let copies = self.learned(posture)?;
        Ok(Shot { qpos: self.qpos(posture), lit: marks, copies, ..Shot::default() })
    }

    /// One picture of the body in a posture, with the places of a touch of a number lit.
    ///
    /// # Errors
    /// Where the engine fails.
    pub fn still(&self, posture: &[f64], touch: Option<(usize, &Touch)>) -> mujoco::Result<Storyboard> {
        let lit: Vec<(&Touch, f64)> = touch.into_iter().map(|(_, touch)| (touch, 1.0)).collect();
        let caption = touch.map(|(number, touch)| format!("touch {number}: {}", self.limbs(touch)));
        let shot = Shot { caption: caption.unwrap_or_default(), ..self.shot(posture, &lit)? };
        Ok(Storyboard::still(shot, self.schema.is_some()))
    }

    /// So many pictures as a time takes, one at least.
    fn frames(&self, seconds: f64) -> usize {
        ((seconds * self.frames_per_second).round() as usize).max(1)
    }

    /// From touch to touch, the first of which has a number.
    ///
    /// # Errors
    /// Where the engine fails.
    pub fn touches(&self, first: usize, touches: &[Touch]) -> mujoco::Result<Storyboard> {
        let (mut shots, mut held) = (Vec::new(), Vec::new());
        let mut from = Posture::start(self.agent.creature());
        let mut before: Option<&Touch> = None;
        for (number, touch) in (first..).zip(touches) {
            let count = self.frames(MOTION);
            let caption = format!("touch {number}: {}", self.limbs(touch));
            for k in 0..count {
                let time = k as f64 / count as f64;
                let posture = self.on_the_way(&from, &touch.posture, eased(time));
                let going = (1.0 - time / LIGHTING).max(0.0);
                let coming = ((time - 1.0 + LIGHTING) / LIGHTING).max(0.0);
                let mut lit = vec![(touch, coming)];
                lit.extend(before.map(|touch| (touch, going)));
                // Every sixth will do to know how much room the motion takes.
                if k % 6 == 0 {
                    held.push(shots.len());
                }
                let caption = if coming > 0.0 { caption.clone() } else { String::new() };
                shots.push(Shot { caption, ..self.shot(&posture, &lit)? });
            }
            let touched = Shot { caption, ..self.shot(&touch.posture, &[(touch, 1.0)])? };
            held.push(shots.len());
            shots.extend(std::iter::repeat_n(touched, self.frames(PAUSE)));
            from.clone_from(&touch.posture);
            before = Some(touch);
        }
        Ok(Storyboard { shots, held, shaded: self.schema.is_some() })
    }

    /// A posture on the way from one to another, at 0 to 1 of it.
    fn on_the_way(&self, from: &[f64], to: &[f64], share: f64) -> Posture {
        Posture::between(self.agent.creature(), from, to, share)
    }

    /// From checkpoint to checkpoint of learning, the body at ease.
    ///
    /// # Errors
    /// Where the engine fails.
    ///
    /// # Panics
    /// Where there is no checkpoint.
    pub fn learning(&self, checkpoints: &[Checkpoint]) -> mujoco::Result<Storyboard> {
        let (posture, root) = (Posture::start(self.agent.creature()), self.root()?);
        let qpos = self.qpos(&posture);
        let figures: Vec<Vec<GeomCopy>> = checkpoints
            .iter()
            .map(|checkpoint| learned_body(self.body, &checkpoint.schema, &posture, &root))
            .collect();
        let shot = |copies: Vec<GeomCopy>, caption: String| Shot {
            qpos: qpos.clone(),
            copies,
            caption,
            ..Shot::default()
        };
        let last = checkpoints.len() - 1;
        let (mut shots, mut held) = (Vec::new(), Vec::new());
        let stay = |shots: &mut Vec<Shot>, held: &mut Vec<usize>, number: usize, count: usize| {
            held.push(shots.len());
            let still = shot(figures[number].clone(), caption([&checkpoints[number]; 2], 0.0));
            shots.extend(std::iter::repeat_n(still, count));
        };
        stay(&mut shots, &mut held, 0, self.frames(GUESS));
        for (number, pair) in figures.windows(2).enumerate() {
            let way = |(from, to): (&GeomCopy, &GeomCopy)| {
                (from.pose.translation.vector - to.pose.translation.vector).norm() / self.size
            };
            let moved = pair[0].iter().zip(&pair[1]).map(way).fold(0.0, f64::max).min(1.0);
            let count = self.frames(STEP + LONGER * moved.sqrt());
            let ends = [&checkpoints[number], &checkpoints[number + 1]];
            for k in 0..count {
                let share = eased(k as f64 / count as f64);
                shots.push(shot(between(&pair[0], &pair[1], share), caption(ends, share)));
            }
            stay(&mut shots, &mut held, number + 1, 1);
        }
        stay(&mut shots, &mut held, last, self.frames(END));
        Ok(Storyboard { shots, held, shaded: true })
    }
}

/// How much was touched on the way between two checkpoints, at 0 to 1 of it, and how far off the body is there.
fn caption([from, to]: [&Checkpoint; 2], share: f64) -> String {
    let touches = from.touches as f64 + share * (to.touches as f64 - from.touches as f64);
    let touches = match touches.round() as usize {
        0 => "a random initial guess".to_string(),
        count => text::touches(count),
    };
    // Errors fall by orders of magnitude.
    let error = from.error_rms.zip(to.error_rms).map(|(from, to)| {
        let [from, to] = [from, to].map(|error| error.max(TINY));
        format!("   {} mm", error_number(from.powf(1.0 - share) * to.powf(share)))
    });
    touches + &error.unwrap_or_default()
}

/// From 0 to 1 with a gentle beginning and end.
fn eased(x: f64) -> f64 {
    x * x * (3.0 - 2.0 * x)
}
