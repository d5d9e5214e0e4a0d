//! A creature in its model, with its skin: it can babble. The creature of a session in its model, which is known again by its
//! content, and what it knows of its body.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use sha2::{Digest, Sha256};

use super::{
    LearningRecord, Observer, ReadLock, SCHEMA_FILE, Session, SessionOptions, TOUCHES_FILE, files,
    read_schema, read_touches,
};
use crate::agent::Agent;
use crate::babbling::{Babbler, BabblingOptions, BoutsDone, Made, PolicyName};
use crate::creature::{Body, Creature, CreatureInFile, JointSelection, Posture, creatures};
use crate::error::{Error, Result};
use crate::evaluation::is_hand;
use crate::ground_truth::GroundTruth;
use crate::learning::growth::Growth;
use crate::model_files::Source;
use crate::mujoco::Model;
use crate::named::listed;
use crate::peripersonal::OwnBody;
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

/// A session's creature in its model, or in another that is named; with its textures where they are wanted.
pub(crate) fn session_body(
    session: &Session,
    model: Option<&Path>,
    textures: bool,
    observer: &dyn Observer,
) -> Result<Body, Error> {
    let path = model.map_or_else(|| PathBuf::from(&session.model), Path::to_path_buf);
    if session.recording.is_some() {
        // Which joints of a model a recording has is not known by the name of a set.
        let source = ModelSource { textures, ..ModelSource::new(&path) };
        let model = Arc::new(source.read(observer)?);
        for selection in [JointSelection::Default, JointSelection::All] {
            let body = source.clone().with_joints(selection).body_in(model.clone())?;
            if same_tree(&body.creature, session.agent.creature()) {
                return Ok(body);
            }
        }
        return Err(Error::unfit(
            &path,
            "its limbs and degrees of freedom differ from the recording's: give another model, or leave out --model",
        ));
    }
    let SessionOptions { root, joints, .. } = &session.options;
    let joints = joints.parse::<JointSelection>().unwrap_or_default();
    let source = ModelSource { model: path, joints, root: root.clone(), textures };
    let body = source.body(observer)?;
    // Who names another file vouches for it, as far as it can be told.
    let other_file = model.is_none() && model_hash(&source.model)? != session.model_hash;
    if other_file || body.creature != *session.agent.creature() {
        return Err(Error::unfit(
            &source.model,
            "it is not the model of the session, or has changed since: give the right one with --model",
        ));
    }
    Ok(body)
}

/// Whether two creatures have the same limbs, joints and kinds of degrees of freedom.
pub(crate) fn same_tree(a: &Creature, b: &Creature) -> bool {
    let joints = |creature: &Creature| {
        let parents: Vec<usize> = creature.joints().iter().map(|joint| joint.parent).collect();
        let dofs: Vec<_> = creature.dofs().map(|dof| (dof.name.clone(), dof.kind)).collect();
        (creature.limbs().to_vec(), parents, dofs)
    };
    joints(a) == joints(b)
}

/// The SHA-256 of a model's XML, as `sha256:` and 64 hexadecimal digits.
///
/// It is that of the file's bytes, followed by those of the files that it includes, in the order in
/// which they are named, each followed by its own. So for a model of one file it is what `sha256sum`
/// prints. Meshes and height fields are not part of it.
///
/// # Errors
/// If the file or one that it includes cannot be read, or is malformed.
pub fn model_hash(path: &Path) -> Result<String, Error> {
    let mut hash = Sha256::new();
    let bytes = files::read(path)?;
    hash.update(&bytes);
    for included in &Source::of_bytes(path, &bytes)?.files[1..] {
        hash.update(files::read(included)?);
    }
    let digits = hash.finalize().iter().map(|byte| format!("{byte:02x}")).collect::<String>();
    Ok(format!("sha256:{digits}"))
}

/// A session and what its creature knows of its body after it.
///
/// # Errors
/// If a file of it cannot be read, or nothing was touched or learned in it.
pub fn own_body(folder: &Path) -> Result<(Session, OwnBody), Error> {
    let _reading = ReadLock::take(folder)?;
    let session = Session::read(folder)?;
    let log = read_touches(&folder.join(TOUCHES_FILE), &session.agent)?;
    let own = learned(folder, &session, log.touches.iter().map(|touch| &touch.posture))?;
    if log.touches.is_empty() {
        return Err(Error::no_touch().at(folder, None));
    }
    Ok((session, own))
}

/// What a session's creature has learned of its body, and how sure that is, without what it experienced.
pub(crate) fn learned_body(folder: &Path) -> Result<OwnBody, Error> {
    let _reading = ReadLock::take(folder)?;
    learned(folder, &Session::read(folder)?, [])
}

/// What is known of the body of a session that felt some postures.
fn learned<'a>(
    folder: &Path,
    session: &Session,
    felt: impl IntoIterator<Item = &'a Posture>,
) -> Result<OwnBody, Error> {
    let creature = session.agent.creature();
    let schema = read_schema(&folder.join(SCHEMA_FILE), creature)?;
    let certainty = LearningRecord::read(folder, creature)?.certainty();
    Ok(OwnBody::new(&session.agent, schema, certainty, felt))
}

/// The limbs that reach: those that are named, else all with receptors whose names end in hand.
pub(crate) fn hands(own: &OwnBody, names: &[String]) -> Result<Vec<usize>, Error> {
    let (creature, limbs) = (own.creature(), own.creature().limbs());
    let touching: Vec<usize> = (1..limbs.len()).filter(|&limb| own.tip_of(limb).is_some()).collect();
    let choice = || listed(&touching.iter().map(|&limb| limbs[limb].clone()).collect::<Vec<_>>());
    if names.is_empty() {
        let is_named = |limb: &usize| limbs[*limb].ends_with("hand") && is_hand(creature, *limb);
        let hands: Vec<usize> = touching.iter().copied().filter(is_named).collect();
        if hands.is_empty() {
            return Err(Error::usage(format!(
                "no limb of {} with receptors has a name that ends in hand: choose one with --hand, of {}",
                creature.name(),
                choice()
            )));
        }
        return Ok(hands);
    }
    let named = |name: &String| {
        let limb = creature.limb(name).filter(|limb| touching.contains(limb));
        limb.ok_or_else(|| {
            Error::usage(format!("--hand {name}: no such limb with receptors: choose one of {}", choice()))
        })
    };
    let mut hands = names.iter().map(named).collect::<Result<Vec<usize>, Error>>()?;
    hands.dedup();
    Ok(hands)
}
