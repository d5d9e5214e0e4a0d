//! What a session gives to see: a touch, the touches one after the other, or how the body was learned.

use std::path::Path;
use std::sync::Arc;

use nalgebra::{Isometry3, Point3};

use super::super::Failure;
use super::super::learned::warn_truncated;
use super::super::open::{ModelArguments, session_body};
use super::{Plan, RenderArguments, RenderSubject, posture};
use crate::agent::Agent;
use crate::creature::{Body, JointSelection, Posture};
use crate::experiment::{ModelSource, same_tree};
use crate::export::to_mjcf;
use crate::mujoco::{Mark, Model};
use crate::record::{LearningRecord, SCHEMA_FILE, Session, TOUCHES_FILE, read_schema, read_touches};
use crate::schema::BodySchema;
use crate::senses::Touch;
use crate::view::picture::{Shot, between, extent, learned_body, lit_touch, outline};

/// Touches of a film that says nothing of them.
const TOUCHES: [usize; 2] = [1, 8];
/// Seconds from one touch to the next, and for which a touch is looked at.
const MOTION: f64 = 0.9;
const PAUSE: f64 = 0.6;
/// The part of a motion in which the places of a touch light up, and the last ones go out.
const LIGHTING: f64 = 0.2;
/// Seconds for which the onset is looked at and the end, …
const ONSET: f64 = 1.0;
const END: f64 = 1.5;
/// … and from one checkpoint to the next: as long where little moves, and by so much longer where as much as the body
/// is large.
const STEP: f64 = 0.2;
const LONGER: f64 = 3.0;

/// A range of touches from the command line.
pub fn touch_range(text: &str) -> Result<[usize; 2], String> {
    let ends = text.split_once("..").and_then(|(from, to)| Some([from.parse().ok()?, to.parse().ok()?]));
    ends.filter(|[from, to]| 1 <= *from && from <= to).ok_or_else(|| "give two numbers, as in 1..8".into())
}

/// A session, and what is known of it for drawing.
struct SessionDrawing<'a> {
    args: &'a RenderArguments,
    agent: &'a Agent,
    body: Body,
    /// The learned body, where it is to be seen.
    schema: Option<BodySchema>,
    /// Greatest extent of the body, metres.
    size: f64,
}

/// What is drawn of a session.
pub fn plan(args: &RenderArguments, film: bool) -> Result<(RenderSubject, Plan), Failure> {
    let session = Session::read(&args.what)?;
    let ModelArguments { strip, root } = &args.options;
    for (given, option) in [(*strip, "--strip"), (root.is_some(), "--root")] {
        if given {
            return Err(Failure(format!(
                "{}: a session knows how its model is read: leave out {option}",
                args.what.display()
            )));
        }
    }
    let agent = &session.agent;
    let creature = agent.creature();
    let read_schema = || read_schema(&args.what.join(SCHEMA_FILE), creature);
    let body = if session.model.is_empty() && args.model.is_none() {
        // A recording has no true body: the learned one is all there is to see.
        learned(&session, &read_schema()?, &args.what)?
    } else {
        session_body(&session, args.model.as_deref())?
    };
    let schema = if args.schema { Some(read_schema()?) } else { None };
    let at_ease = body.reference_data()?;
    let size = extent(&outline(&at_ease, &|geom| body.limb_of_geom(geom).is_some())).max(1e-3);
    let drawn = SessionDrawing { args, agent, body, schema, size };
    let plan = match (film, args.learning) {
        (true, true) => drawn.learning()?,
        (true, false) => drawn.touches(&touches(args, &session)?)?,
        (false, _) => drawn.still(&session)?,
    };
    let (place, model) = (args.what.display().to_string(), drawn.body.declared.clone());
    Ok((RenderSubject { place, model, body: Some(drawn.body), alone: true }, plan))
}

/// The body of a session without a model, as it was learned.
fn learned(session: &Session, schema: &BodySchema, folder: &Path) -> Result<Body, Failure> {
    let model = Arc::new(Model::from_xml(&to_mjcf(&session.agent, schema))?);
    let body = ModelSource::new(folder).with_joints(JointSelection::All).body_in(model)?;
    if same_tree(&body.creature, session.agent.creature()) {
        return Ok(body);
    }
    Err(Failure(format!(
        "{}: its learned body cannot be drawn by itself: name the creature's model with --model",
        folder.display()
    )))
}

fn touches(args: &RenderArguments, session: &Session) -> Result<Vec<Touch>, Failure> {
    let log = read_touches(&args.what.join(TOUCHES_FILE), &session.agent)?;
    warn_truncated(&log, &args.what);
    Ok(log.touches)
}

impl SessionDrawing<'_> {
    /// The body in a posture, and where its root limb is.
    fn qpos(&self, posture: &[f64]) -> Vec<f64> {
        let mut qpos = vec![0.0; self.body.model.nq()];
        self.body.write_qpos(posture, &mut qpos);
        qpos
    }

    /// The learned body in a posture, where it is to be seen.
    fn learned(&self, posture: &[f64]) -> Result<Vec<Mark>, Failure> {
        let Some(schema) = &self.schema else { return Ok(Vec::new()) };
        let root = self.root()?;
        Ok(learned_body(self.agent, schema, posture, &root, self.size))
    }

    /// `X_WR`, which no posture moves.
    fn root(&self) -> Result<Isometry3<f64>, Failure> {
        Ok(self.body.limb_pose(&self.body.reference_data()?, 0).unwrap_or_default())
    }

    /// The places of a touch, lit, when the body is in some posture.
    fn lit(&self, touch: &Touch, strength: f64, posture: &[f64]) -> Result<Vec<Mark>, Failure> {
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

    fn shot(&self, posture: &[f64], lit: &[(&Touch, f64)]) -> Result<Shot, Failure> {
        let mut marks = Vec::new();
        for (touch, strength) in lit.iter().filter(|(_, strength)| *strength > 0.0) {
            marks.extend(self.lit(touch, *strength, posture)?);
        }
        Ok(Shot { qpos: self.qpos(posture), marks: self.learned(posture)?, lit: marks })
    }

    fn still(&self, session: &Session) -> Result<Plan, Failure> {
        let shot = match (self.args.touch, &self.args.posture) {
            (Some(number), _) => {
                let touches = touches(self.args, session)?;
                let touch = number.checked_sub(1).and_then(|index| touches.get(index));
                let touch = touch.ok_or_else(|| self.no_touch(number, touches.len()))?;
                self.shot(&touch.posture, &[(touch, 1.0)])?
            }
            (None, Some(text)) => self.shot(&posture::read(text, self.agent.creature())?, &[])?,
            (None, None) => self.shot(&Posture::start(self.agent.creature()), &[])?,
        };
        Ok(Plan::still(shot, self.schema.is_some()))
    }

    fn no_touch(&self, number: usize, count: usize) -> Failure {
        let log = self.args.what.join(TOUCHES_FILE);
        let mend =
            if count == 0 { "babble some first".into() } else { format!("give one from 1 to {count}") };
        Failure(format!("{}: there is no touch {number} in it: {mend}", log.display()))
    }

    /// So many pictures as a time takes, one at least.
    fn frames(&self, seconds: f64) -> usize {
        ((seconds * self.args.frames_per_second).round() as usize).max(1)
    }

    /// From touch to touch.
    fn touches(&self, touches: &[Touch]) -> Result<Plan, Failure> {
        let [first, last] = self.args.touches.unwrap_or([TOUCHES[0], TOUCHES[1].min(touches.len().max(1))]);
        let chosen = touches.get(first - 1..last).ok_or_else(|| self.no_touch(last, touches.len()))?;
        let (mut shots, mut held) = (Vec::new(), Vec::new());
        let mut from = Posture::start(self.agent.creature());
        let mut before: Option<&Touch> = None;
        for touch in chosen {
            let count = self.frames(MOTION);
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
                shots.push(self.shot(&posture, &lit)?);
            }
            let touched = self.shot(&touch.posture, &[(touch, 1.0)])?;
            held.push(shots.len());
            shots.extend(std::iter::repeat_n(touched, self.frames(PAUSE)));
            from.clone_from(&touch.posture);
            before = Some(touch);
        }
        Ok(Plan { shots, held, shaded: self.schema.is_some() })
    }

    /// A posture on the way from one to another, at 0 to 1 of it.
    fn on_the_way(&self, from: &[f64], to: &[f64], share: f64) -> Posture {
        Posture::between(self.agent.creature(), from, to, share)
    }

    /// From checkpoint to checkpoint, the body at ease.
    fn learning(&self) -> Result<Plan, Failure> {
        let folder = &self.args.what;
        let record = LearningRecord::read(folder, self.agent.creature())?;
        let checkpoints =
            record.map(|record| record.checkpoints).filter(|all| all.len() > 1).ok_or_else(|| {
                Failure(format!(
                    "{}: it has no checkpoints of learning: learn from it again with `bodyschema learn {0}`",
                    folder.display()
                ))
            })?;
        let (posture, root) = (Posture::start(self.agent.creature()), self.root()?);
        let qpos = self.qpos(&posture);
        let figures: Vec<Vec<Mark>> = checkpoints
            .iter()
            .map(|at| learned_body(self.agent, &at.schema, &posture, &root, self.size))
            .collect();
        let (mut shots, mut held) = (Vec::new(), Vec::new());
        let mut stay = |shots: &mut Vec<Shot>, marks: &Vec<Mark>, count: usize| {
            held.push(shots.len());
            shots.extend(std::iter::repeat_n(
                Shot { qpos: qpos.clone(), marks: marks.clone(), lit: Vec::new() },
                count,
            ));
        };
        stay(&mut shots, &figures[0], self.frames(ONSET));
        for pair in figures.windows(2) {
            let way = |(from, to): (&Mark, &Mark)| {
                (from.pose.translation.vector - to.pose.translation.vector).norm() / self.size
            };
            let moved = pair[0].iter().zip(&pair[1]).map(way).fold(0.0, f64::max).min(1.0);
            let count = self.frames(STEP + LONGER * moved.sqrt());
            for k in 0..count {
                let share = eased(k as f64 / count as f64);
                shots.push(Shot {
                    qpos: qpos.clone(),
                    marks: between(&pair[0], &pair[1], share),
                    lit: Vec::new(),
                });
            }
            stay(&mut shots, &pair[1], 1);
        }
        stay(&mut shots, &figures[figures.len() - 1], self.frames(END));
        Ok(Plan { shots, held, shaded: true })
    }
}

/// From 0 to 1 with a gentle beginning and end.
fn eased(x: f64) -> f64 {
    x * x * (3.0 - 2.0 * x)
}
