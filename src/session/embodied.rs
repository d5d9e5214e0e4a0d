//! A creature in its model, with its skin: it can babble.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use super::observer::Observer;
use crate::agent::Agent;
use crate::babbling::{Babbler, BabblingOptions, BoutsDone, Made, PolicyName};
use crate::creature::{Body, Creature, CreatureInFile, JointSelection, creatures};
use crate::error::{Error, Result};
use crate::ground_truth::GroundTruth;
use crate::learning::growth::Growth;
use crate::mujoco::Model;
use crate::named::listed;
use crate::senses::RecordedTouch;
use crate::simulation::{MotionName, Movers};
use crate::skin::{GrowOptions, Skin, grow_counted};

/// A model's file, and what of it is the creature.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ModelSource {
    /// The MJCF or URDF file.
    pub model: PathBuf,
    /// The joints that move.
    pub joints: JointSelection,
    /// The body at which the creature begins; the first of the tree with most joints where it is left out.
    pub root: Option<String>,
    /// Whether the model is read with its textures, for pictures.
    pub textures: bool,
}

/// A creature in its model, with its skin and the truth that it is measured against.
pub struct Embodied {
    source: ModelSource,
    body: Body,
    agent: Agent,
    truth: GroundTruth,
}

impl ModelSource {
    /// A model's file, of which the joints move that are learned by default.
    pub fn new(model: impl Into<PathBuf>) -> ModelSource {
        ModelSource { model: model.into(), ..ModelSource::default() }
    }

    /// The same with other joints that move.
    pub fn with_joints(self, joints: JointSelection) -> ModelSource {
        ModelSource { joints, ..self }
    }

    /// Reads the model; the observer is told what is left out of it.
    pub(crate) fn read(&self, observer: &dyn Observer) -> Result<Model, Error> {
        let read = if self.textures { Model::read_with_textures } else { Model::read };
        let (model, left_out) = read(&self.model)?;
        if let Some(words) = left_out.in_words() {
            observer.note(&format!(
                "{} was read without {words}: `bodyschema inspect` lists all",
                self.model.display()
            ));
        }
        for note in &left_out.notes {
            observer.note(&format!("{}: {note}", self.model.display()));
        }
        Ok(model)
    }

    /// The creature in a model that was read.
    pub(crate) fn body_in(&self, model: Arc<Model>) -> Result<Body, Error> {
        Body::rooted(model, &self.joints, self.root.as_deref()).map_err(Error::of_model(&self.model))
    }

    /// That other creatures are in the file, and how to choose one; `None` if there are no others, or one was chosen.
    fn others(&self, body: &Body) -> Option<String> {
        let creatures = creatures(&body.declared);
        let told = |creature: &CreatureInFile| format!("{} ({} joints)", creature.name, creature.joints);
        let (own, others): (Vec<_>, Vec<_>) =
            creatures.iter().partition(|creature| body.limb_of_body[creature.root].is_some());
        let chosen = own.first().filter(|_| self.root.is_none() && !others.is_empty())?;
        let others: Vec<String> = others.into_iter().map(told).collect();
        Some(format!(
            "{} contains several creatures; this is {}. --root selects another of {}",
            self.model.display(),
            told(chosen),
            listed(&others)
        ))
    }

    /// Reads the model and the creature in it.
    pub(crate) fn body(&self, observer: &dyn Observer) -> Result<Body, Error> {
        self.body_in(Arc::new(self.read(observer)?))
    }
}

impl Embodied {
    /// Reads a model, its creature and its skin. Where the model has no touch sensors a skin is grown in memory, of which
    /// the observer is told.
    ///
    /// # Errors
    /// Where the file is not one that the engine takes, there is no creature in it that can learn, or no skin can be
    /// grown on it.
    pub fn open(source: ModelSource, observer: &dyn Observer) -> Result<Embodied, Error> {
        let model = Arc::new(source.read(observer)?);
        Embodied::of_model(source, model, observer)
    }

    /// The same of a model that was read, or never was in a file: that of its source names it in errors alone.
    ///
    /// # Errors
    /// See [`Embodied::open`].
    pub fn of_model(
        source: ModelSource,
        model: Arc<Model>,
        observer: &dyn Observer,
    ) -> Result<Embodied, Error> {
        let body = source.body_in(model)?;
        if let Some(sentence) = source.others(&body) {
            observer.note(&sentence);
        }
        let (skin, _) = skin_for(&source.model, &body, observer)?;
        let agent = Agent::new(body.creature.clone(), skin);
        let agent = agent.map_err(|error| Error::unfit(&source.model, error.to_string()))?;
        let truth = GroundTruth::new(&body)?;
        Ok(Embodied { source, body, agent, truth })
    }

    /// Where it came from.
    pub fn source(&self) -> &ModelSource {
        &self.source
    }

    /// The model's file.
    pub fn model(&self) -> &Path {
        &self.source.model
    }

    /// The creature in its model.
    pub fn body(&self) -> &Body {
        &self.body
    }

    /// What the agent is given of its body.
    pub fn creature(&self) -> &Creature {
        &self.body.creature
    }

    /// What the agent is given about itself: its creature and skin.
    pub fn agent(&self) -> &Agent {
        &self.agent
    }

    /// Where its joints really are; for measures alone.
    pub fn truth(&self) -> &GroundTruth {
        &self.truth
    }

    /// Makes it ready to babble.
    ///
    /// # Errors
    /// Where it has no skin, or no two of its limbs can meet.
    pub fn babbler(&self, motion: MotionName) -> Result<Babbler<'_>, Error> {
        let movers = Movers::new(&self.body, &self.agent, motion);
        movers.map(Babbler::new).map_err(Error::of_model(self.model()))
    }

    /// All touches that a babbler of this creature makes by a policy, and what a policy that learns all that can be has
    /// learned along the way.
    pub(crate) fn touches(
        &self,
        babbler: &Babbler,
        policy: PolicyName,
        options: &BabblingOptions,
    ) -> Result<(Vec<RecordedTouch>, Option<Growth>)> {
        let mut touches = Vec::new();
        let made = babbler.babble(policy, BoutsDone::default(), options, kept(&mut touches));
        let (_, grown) = made.map_err(Error::of_model(self.model()))?;
        Ok((touches, grown))
    }
}

/// Keeps the touches of all that is made.
pub(super) fn kept(touches: &mut Vec<RecordedTouch>) -> impl FnMut(Made) -> Result<()> {
    |made| {
        if let Made::Touch(touch) = made {
            touches.push(touch.clone());
        }
        Ok(())
    }
}

/// The skin of a creature: the receptors in its model, and where these are too few or none, more that are grown in memory,
/// of which the observer is told; and how many are the model's own, which come first.
pub(crate) fn skin_for(model: &Path, body: &Body, observer: &dyn Observer) -> Result<(Skin, usize), Error> {
    let (skin, own) = grow_counted(body, &GrowOptions::default()).map_err(Error::of_model(model))?;
    let grown = skin.receptors.len() - own;
    let model = model.display();
    match (own, grown) {
        (_, 0) => {}
        (0, grown) => observer
            .note(&format!("{model} has no touch sensors; {grown} receptors were grown on it in memory")),
        (own, grown) => observer.note(&format!(
            "the {own} touch sensors of {model} do not cover its skin; {grown} receptors were grown on the rest in memory"
        )),
    }
    Ok((skin, own))
}
