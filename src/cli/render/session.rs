//! What a session gives to see: a touch, the touches one after the other, or how the body was learned.

use std::path::Path;
use std::sync::Arc;

use super::super::Failure;
use super::super::learned::read_log;
use super::super::open::session_body;
use super::{RenderArguments, posture};
use crate::creature::{Body, Creature, JointSelection};
use crate::export::to_mjcf;
use crate::mujoco::Model;
use crate::schema::BodySchema;
use crate::session::{
    Checkpoint, LearningRecord, ModelSource, ReadLock, SCHEMA_FILE, Session, TOUCHES_FILE, read_schema,
    same_tree,
};
use crate::view::picture::{Drawing, SessionDrawing};

/// Touches of a film that says nothing of them.
const TOUCHES: [usize; 2] = [1, 8];

/// A range of touches from the command line.
pub fn touch_range(text: &str) -> Result<[usize; 2], String> {
    let ends = text.split_once("..").and_then(|(from, to)| Some([from.parse().ok()?, to.parse().ok()?]));
    ends.filter(|[from, to]| 1 <= *from && from <= to).ok_or_else(|| "give two numbers, as in 1..8".into())
}

/// What is drawn of a session.
pub fn drawing(args: &RenderArguments, film: bool) -> Result<Drawing, Failure> {
    let _reading = ReadLock::take(&args.what)?;
    let session = Session::read(&args.what)?;
    if args.options.root.is_some() {
        return Err(Failure::at(&args.what, "a session already determines the creature: leave out --root"));
    }
    let (agent, creature) = (&session.agent, session.agent.creature());
    let read_schema = || read_schema(&args.what.join(SCHEMA_FILE), creature);
    let body = if session.model.is_empty() && args.model.is_none() {
        // A recording has no true body: the learned one is all there is to see.
        if agent.skin().surfaces.is_empty() {
            return Err(Failure::at(
                &args.what,
                "the shapes of its limbs are unknown: give a model with --model, or surfaces in the creature's skin",
            ));
        }
        learned(&session, &read_schema()?, &args.what)?
    } else {
        session_body(&session, args.model.as_deref(), true)?
    };
    let schema = if args.schema { Some(read_schema()?) } else { None };
    let drawn = SessionDrawing::new(agent, &body, schema, args.frames_per_second)?;
    let shots = match (film, args.learning, args.touch) {
        (true, true, _) => drawn.learning(&checkpoints(args, creature)?),
        (true, false, _) => {
            let touches = read_log(&args.what, agent)?;
            let [first, last] = args.touches.unwrap_or([TOUCHES[0], TOUCHES[1].min(touches.len().max(1))]);
            let chosen = touches.get(first - 1..last).ok_or_else(|| no_touch(args, last, touches.len()))?;
            drawn.touches(first, chosen)?
        }
        (false, _, Some(number)) => {
            let touches = read_log(&args.what, agent)?;
            let touch = number.checked_sub(1).and_then(|index| touches.get(index));
            vec![drawn.touch(number, touch.ok_or_else(|| no_touch(args, number, touches.len()))?)?]
        }
        (false, _, None) => vec![drawn.posture(&posture(args.posture.as_deref(), creature)?)],
    };
    let shaded = args.schema || film && args.learning;
    Ok(Drawing { model: body.declared.clone(), body: Some(body), alone: true, shots, shaded })
}

fn no_touch(args: &RenderArguments, number: usize, count: usize) -> Failure {
    let fix = if count == 0 { "babble first".into() } else { format!("give one from 1 to {count}") };
    Failure::at(&args.what.join(TOUCHES_FILE), format_args!("it has no touch {number}: {fix}"))
}

/// What learning went through.
fn checkpoints(args: &RenderArguments, creature: &Creature) -> Result<Vec<Checkpoint>, Failure> {
    let record = LearningRecord::read(&args.what, creature)?;
    Some(record.checkpoints).filter(|all| all.len() > 1).ok_or_else(|| {
        let again = format!("learn again with `bodyschema learn {}`", args.what.display());
        Failure::at(&args.what, format_args!("it has no checkpoints of learning: {again}"))
    })
}

/// The body of a session without a model, as it was learned.
fn learned(session: &Session, schema: &BodySchema, folder: &Path) -> Result<Body, Failure> {
    let model = Arc::new(Model::from_xml(&to_mjcf(&session.agent, schema))?);
    let body = ModelSource::new(folder).with_joints(JointSelection::All).body_in(model)?;
    if same_tree(&body.creature, session.agent.creature()) {
        return Ok(body);
    }
    Err(Failure::at(
        folder,
        "its learned body cannot be drawn without a model: give the creature's with --model",
    ))
}
