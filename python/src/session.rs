//! Babbling, learning, and sessions on disk.

use std::path::PathBuf;
use std::sync::Arc;

use bodyschema::deadline::worked;
use bodyschema::senses::{ExactContact, RecordedTouch, TouchEnd};
use bodyschema::session::{
    BabbledSession, BabblingSession, FolderLock, LearningOptions, LearningRecord, Observer, Provenance,
    SCHEMA_FILE, SESSION_FILE, Session as SessionFile, SessionOptions, TOUCHES_FILE, TouchWriter,
    learn_session, own_body, read_touches,
};
use bodyschema::{Error as Fault, Input, OwnBody, SessionRequest, Touch};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyTuple};

use crate::arrays::{Table, array, integers, numbers, postures};
use crate::compute::{compute, warn};
use crate::creature::{Creature, coordinates};
use crate::errors::{raised, wrong};
use crate::folder::Folder;
use crate::options::{Learning, positive};
use crate::schema::Schema;

/// A creature's touches: what `babble`, `record` and `open` return.
#[pyclass(frozen, module = "bodyschema")]
pub struct Session {
    babbled: Arc<BabbledSession>,
    folder: Arc<Folder>,
    /// How the session itself would learn, and how much work was done before.
    own: Option<(LearningOptions, u64)>,
    #[pyo3(get)]
    /// Whether babbling was interrupted before its end.
    interrupted: bool,
}

#[pymethods]
impl Session {
    /// The creature's name.
    #[getter]
    fn creature(&self) -> &str {
        self.babbled.session.agent.creature().name()
    }

    /// The seed of all random numbers.
    #[getter]
    fn seed(&self) -> u64 {
        self.babbled.session.seed
    }

    /// The version of MuJoCo that simulated it; empty if it was recorded.
    #[getter]
    fn engine(&self) -> &str {
        &self.babbled.session.engine
    }

    /// The session's folder; `None` if it was not given one.
    #[getter]
    fn folder(&self) -> Option<PathBuf> {
        (!self.folder.is_temporary()).then(|| self.folder.path().to_path_buf())
    }

    /// All N touches as a table of columns: `bout`, `motion`, `receptor_a`, `limb_a`, `receptor_b`, `limb_b`, one column per
    /// coordinate of the posture (radians, metres), and the exact contact in both limbs' frames, `ax` … `bz` (metres), which
    /// learners by receptors are not given. With `motion="dynamic"` also `time` (s), `force` (N) and `depth` (m).
    #[getter]
    fn touches<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let (agent, touches) = (&self.babbled.session.agent, &self.babbled.touches);
        let (limbs, receptors) = (agent.creature().limbs(), &agent.skin().receptors);
        let mut table = Table::new(py)?
            .integers("bout", touches.iter().map(|touch| touch.bout as usize))?
            .integers("motion", touches.iter().map(|touch| touch.motion as usize))?;
        for (k, side) in ["a", "b"].into_iter().enumerate() {
            let receptor = |touch: &RecordedTouch| &receptors[touch.ends[k].receptor];
            table = table
                .words(
                    &format!("receptor_{side}"),
                    touches.iter().map(|touch| Some(receptor(touch).id.clone())),
                )?
                .words(
                    &format!("limb_{side}"),
                    touches.iter().map(|touch| Some(limbs[receptor(touch).limb].clone())),
                )?;
        }
        for (k, name) in coordinates(agent.creature()).iter().enumerate() {
            table = table.numbers(name, touches.iter().map(|touch| touch.posture[k]))?;
        }
        for (k, side) in ["a", "b"].into_iter().enumerate() {
            for (axis, letter) in ["x", "y", "z"].into_iter().enumerate() {
                let contact = touches.iter().map(|touch| touch.exact_contact().points[k][axis]);
                table = table.numbers(&format!("{side}{letter}"), contact)?;
            }
        }
        if touches.iter().any(|touch| touch.moment.is_some()) {
            let of = |number: fn(&RecordedTouch) -> Option<f64>| {
                touches.iter().map(move |touch| number(touch).unwrap_or(f64::NAN))
            };
            table = table
                .numbers("time", of(|touch| touch.moment.map(|moment| moment.time)))?
                .numbers("force", of(|touch| touch.moment.map(|moment| moment.force)))?
                .numbers("depth", of(|touch| touch.exact_contact().depth))?;
        }
        Ok(table.done())
    }

    /// The postures of all touches: (N, D), radians and metres.
    #[getter]
    fn postures<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let touches = &self.babbled.touches;
        let all: Vec<f64> = touches.iter().flat_map(|touch| touch.posture.iter().copied()).collect();
        array(py, &all, &[touches.len(), self.babbled.session.agent.creature().coordinates()])
    }

    /// The two receptors of all touches, by their places in `Creature.receptors`: (N, 2).
    #[getter]
    fn receptors<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let touches = &self.babbled.touches;
        let all = touches.iter().flat_map(|touch| touch.ends.map(|end| end.receptor)).collect();
        integers(py, all, &[touches.len(), 2])
    }

    /// The exact contact of all touches in the frames of the two limbs: (N, 2, 3), metres.
    #[getter]
    fn points<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let touches = &self.babbled.touches;
        let points = touches.iter().flat_map(|touch| touch.exact_contact().points);
        let all: Vec<f64> = points.flat_map(|point| [point.x, point.y, point.z]).collect();
        array(py, &all, &[touches.len(), 2, 3])
    }

    /// Writes the session into a new folder, as the program does: `session.json` and `touches.jsonl`.
    fn save(&self, folder: PathBuf) -> PyResult<()> {
        if folder.join(SESSION_FILE).exists() {
            let sentence = format!("{}: there is a session already: give another folder", folder.display());
            return Err(wrong(sentence));
        }
        std::fs::create_dir_all(&folder)?;
        for file in [SESSION_FILE, TOUCHES_FILE] {
            std::fs::copy(self.folder.path().join(file), folder.join(file))?;
        }
        Ok(())
    }

    /// Draws how often limbs touched one another; needs matplotlib. Returns the axes.
    #[pyo3(signature = (ax = None))]
    fn plot<'py>(slf: &Bound<'py, Self>, ax: Option<Bound<'py, PyAny>>) -> PyResult<Bound<'py, PyAny>> {
        slf.py().import("bodyschema._plot")?.call_method1("touches", (slf, ax))
    }

    fn _repr_html_<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyAny>> {
        slf.py().import("bodyschema._html")?.call_method1("touches", (slf,))
    }

    fn __len__(&self) -> usize {
        self.babbled.touches.len()
    }

    fn __repr__(&self) -> String {
        let end = if self.interrupted { ", interrupted" } else { "" };
        format!("<Session of {}: {} touches, seed {}{end}>", self.creature(), self.__len__(), self.seed())
    }
}

/// A creature explores its body: it moves about and stops where its skin touches its skin. The same seed and the same MuJoCo
/// give the same touches as the program `bodyschema babble`, byte for byte.
///
/// An interruption (Ctrl-C) ends babbling and keeps the touches made so far; a second one abandons it.
///
/// Parameters
/// ----------
/// creature : Creature
/// touches : int, optional
///     Touches to make. By default as many as determine the body, 4000 at the most; at random 1000.
/// seed : int
///     Seed of all random numbers.
/// seconds, work : float, optional
///     End after so many seconds, or after so much work (about what one core does in so many seconds; the same on any
///     computer). By default 50 of work, unless `touches`, `seconds` or physics are asked for.
/// policy : {"stages", "random"}, optional
///     How motions are chosen. By default by stages where these suit.
/// motion : {"kinematic", "dynamic"}
///     How the body is moved: straight through its postures, or by servos in a simulation with gravity.
/// jobs : int, optional
///     Threads; they change nothing but the time.
/// out : path, optional
///     The session's folder, which must not hold one yet. By default a temporary one.
/// learner, input, skin, frames, known, joint_noise_deg, receptor_noise_mm, point_noise_mm, false_touches
///     How to learn from it, as of `learn`: policies that learn mind it.
///
/// Returns
/// -------
/// Session
#[pyfunction]
#[pyo3(signature = (creature, *, touches = None, seed = 1, seconds = None, work = None, policy = None, motion = "kinematic", jobs = None, out = None, **learning))]
#[allow(clippy::too_many_arguments)]
pub fn babble(
    py: Python,
    creature: &Bound<Creature>,
    touches: Option<usize>,
    seed: u64,
    seconds: Option<f64>,
    work: Option<f64>,
    policy: Option<&str>,
    motion: &str,
    jobs: Option<u16>,
    out: Option<PathBuf>,
    learning: Option<&Bound<PyDict>>,
) -> PyResult<Session> {
    let Learning { options: learning, .. } = Learning::read("babble", learning)?;
    if touches == Some(0) || jobs == Some(0) {
        return Err(wrong("touches and jobs: give numbers from 1 on"));
    }
    if seconds.is_some() && work.is_some() {
        return Err(wrong("seconds and work exclude each other: give one of them"));
    }
    let request = SessionRequest {
        touches,
        seconds: positive("seconds", seconds)?,
        work: positive("work", work)?,
        seed,
        jobs,
        policy: policy.map(str::parse).transpose().map_err(raised)?,
        motion: motion.parse().map_err(raised)?,
        learning,
    };
    let folder = Arc::new(Folder::new(out)?);
    let (embodied, place) = (creature.get().embodied.clone(), folder.clone());
    let computed = compute(py, move |watcher| {
        let setup = request.setup(&embodied)?;
        let lock = FolderLock::make(place.path())?;
        let session = BabblingSession::begin(&embodied, &setup, &lock, Provenance::default())?;
        let babbled = session.babble(watcher)?;
        Ok((babbled, setup.learning, worked()))
    })?;
    let interrupted = computed.interrupted;
    let (babbled, learning, worked) = computed.kept(py, "the touches made so far are kept")?;
    Ok(Session { babbled: Arc::new(babbled), folder, own: Some((learning, worked)), interrupted })
}

/// Learns a body schema from touches alone: where the joints are and how they turn. With no options this is what the program
/// does after babbling, to the last bit.
///
/// An interruption (Ctrl-C) ends the search early and returns the best schema so far; a second one abandons it.
///
/// Parameters
/// ----------
/// session : Session
/// touches : int, optional
///     Learn from the first touches only.
/// learner : {"lm", "growth", "hersch"}, optional
///     By default the one that suits the touches.
/// input : {"receptor", "contact"}, optional
///     What a touch reports: the two receptors, or the points of contact.
/// skin : {"surface", "centres"}, optional
///     What the agent knows of its skin: the surfaces under receptors, or their centres alone.
/// frames : {"joint", "limb"}, optional
///     The frames in which points on limbs are given: those of the joints, or the limbs' own.
/// known : path, optional
///     A file of prior knowledge of joints: a schema.json, whole or in part.
/// joint_noise_deg, receptor_noise_mm, point_noise_mm, false_touches : float, optional
///     Disturbances between the exact touches and the learner: standard deviations in degrees and millimetres, and the share
///     of touches with a wrong receptor.
///
/// Returns
/// -------
/// Schema
#[pyfunction]
#[pyo3(signature = (session, *, touches = None, **learning))]
pub fn learn(
    py: Python,
    session: &Bound<Session>,
    touches: Option<usize>,
    learning: Option<&Bound<PyDict>>,
) -> PyResult<Schema> {
    let asked = Learning::read("learn", learning)?;
    let Session { babbled, folder, own, .. } = session.get();
    let options = match own {
        Some((own, worked)) if !asked.is_asked => Ok((own.clone(), Some(*worked))),
        _ => asked.options.for_session(&babbled.session).map(|options| (options, None)),
    };
    let (options, worked_before) = options.map_err(raised)?;
    let folder = if folder.is_temporary() { Arc::new(Folder::new(None)?) } else { folder.clone() };
    let (babbled, place) = (babbled.clone(), folder.clone());
    let source = babbled.clone();
    let computed = compute(py, move |watcher| {
        let _lock = FolderLock::make(place.path())?;
        let deadline = worked_before.map_or(options.deadline, |worked| options.deadline.resumed(worked));
        let options = LearningOptions { deadline, ..options };
        let first =
            touches.filter(|&touches| touches < babbled.touches.len()).map(|touches| BabbledSession {
                session: babbled.session.clone(),
                touches: babbled.touches[..touches].to_vec(),
                grown: None,
            });
        let babbled = first.as_ref().unwrap_or(&babbled);
        let learned = learn_session(place.path(), babbled, &options, None, &[], watcher)?;
        let postures = babbled.touches.iter().map(|touch| &touch.posture);
        Ok((OwnBody::of(&babbled.session.agent, &learned.learned, postures), learned.record))
    })?;
    let (own, record) = computed.kept(py, "the schema is what was known by then")?;
    Ok(Schema::new(own, record, source, folder))
}

/// A session of touches that were recorded elsewhere.
///
/// Parameters
/// ----------
/// creature : Creature
/// postures : array_like, shape (N, D)
///     Radians, metres.
/// receptors : array_like of int, shape (N, 2)
///     The two receptors of each touch, by their places in `Creature.receptors`.
/// points : array_like, shape (N, 2, 3), optional
///     The points of contact in the frames of the two limbs, metres. By default the receptors' centres; with points `learn`
///     uses these.
/// seed : int
///     Seed of the learner's initial guesses.
///
/// Returns
/// -------
/// Session
#[pyfunction]
#[pyo3(name = "record", signature = (creature, postures, receptors, points = None, *, seed = 1))]
pub fn record(
    py: Python,
    creature: &Bound<Creature>,
    #[pyo3(from_py_with = any)] postures: Py<PyAny>,
    #[pyo3(from_py_with = any)] receptors: Py<PyAny>,
    points: Option<Py<PyAny>>,
    seed: u64,
) -> PyResult<Session> {
    let agent = creature.get().embodied.agent();
    let (postures, single) = self::postures(postures.bind(py), "postures", agent.creature())?;
    if single {
        return Err(wrong("postures: give one per touch, (N, D)"));
    }
    let count = postures.len();
    let (places, shape) = numbers(receptors.bind(py), "receptors")?;
    if shape != [count, 2] {
        return Err(wrong(format!(
            "receptors: the shape is {shape:?}: give ({count}, 2), as many as postures"
        )));
    }
    let skin = &agent.skin().receptors;
    if let Some(wrong_place) =
        places.iter().find(|place| place.fract() != 0.0 || !(0.0..skin.len() as f64).contains(*place))
    {
        return Err(wrong(format!(
            "receptors: there is no receptor {wrong_place}: give places from 0 to {}",
            skin.len() - 1
        )));
    }
    let points = points.map(|points| numbers(points.bind(py), "points")).transpose()?;
    if let Some((_, shape)) = points.as_ref().filter(|(_, shape)| *shape != [count, 2, 3]) {
        return Err(wrong(format!("points: the shape is {shape:?}: give ({count}, 2, 3)")));
    }
    let input = if points.is_some() { Input::Contact } else { Input::Receptor };
    let touches: Vec<RecordedTouch> = (0..count)
        .map(|n| {
            // The one on the earlier limb comes first.
            let mut sides = [0, 1].map(|k| (places[2 * n + k] as usize, k));
            sides.sort_by_key(|(receptor, _)| skin[*receptor].limb);
            let at = |(receptor, k): (usize, usize)| match &points {
                Some((points, _)) => nalgebra::Vector3::from_column_slice(&points[6 * n + 3 * k..][..3]),
                None => skin[receptor].position,
            };
            let contact = ExactContact { points: sides.map(at), ..ExactContact::default() };
            let ends = sides.map(|(receptor, _)| TouchEnd::at(receptor));
            let touch =
                Touch { bout: 0, motion: n as u64 + 1, posture: postures[n].clone(), ends, moment: None };
            RecordedTouch::new(touch, contact)
        })
        .collect();
    let session = SessionFile {
        seed,
        options: SessionOptions {
            touches: count,
            joints: creature.get().embodied.source().joints.to_string(),
            input: Some(input.to_string()),
            ..SessionOptions::default()
        },
        agent: agent.clone(),
        ..SessionFile::made_here()
    };
    let folder = Arc::new(Folder::new(None)?);
    let written = || {
        session.write(folder.path()).map_err(|fault| (0, fault))?;
        let mut log = TouchWriter::create(folder.path(), &session.agent).map_err(|fault| (0, fault))?;
        touches.iter().enumerate().try_for_each(|(n, touch)| log.write(touch).map_err(|fault| (n, fault)))?;
        log.finish().map_err(|fault| (count, fault))
    };
    let result: Result<(), (usize, Fault)> = written();
    result.map_err(|(n, fault)| {
        let sentence = fault.to_string();
        let reason = sentence.split_once(": ").map_or(sentence.as_str(), |(_, reason)| reason);
        wrong(format!("touch {n} (from 0): {reason}"))
    })?;
    let learning = LearningOptions { input: Some(input), ..Learning::default().options };
    let own = Some((LearningOptions { deadline: bodyschema::deadline::Deadline::Asked, ..learning }, 0));
    Ok(Session {
        babbled: Arc::new(BabbledSession { session, touches, grown: None }),
        folder,
        own,
        interrupted: false,
    })
}

fn any(given: &Bound<PyAny>) -> PyResult<Py<PyAny>> {
    Ok(given.clone().unbind())
}

/// Opens a session's folder, one of the program's or of `babble(out=…)`.
///
/// Returns
/// -------
/// (Session, Schema or None)
///     The touches, and the schema if one was learned.
#[pyfunction]
pub fn open<'py>(py: Python<'py>, folder: PathBuf) -> PyResult<Bound<'py, PyTuple>> {
    let place = folder.clone();
    let computed = compute(py, move |watcher| {
        let session = SessionFile::read(&place)?;
        let log = read_touches(&place.join(TOUCHES_FILE), &session.agent)?;
        if let Some(line) = log.truncated {
            watcher.note(&format!("{}: the log ends in line {line}, which is left out", place.display()));
        }
        let learned = match place.join(SCHEMA_FILE).exists() {
            true => Some((own_body(&place)?.1, LearningRecord::read(&place, session.agent.creature())?)),
            false => None,
        };
        Ok((BabbledSession { session, touches: log.touches, grown: None }, learned))
    })?;
    let (babbled, learned) = computed.whole()?;
    let (babbled, folder) = (Arc::new(babbled), Arc::new(Folder::new(Some(folder))?));
    let schema = learned.map(|(own, record)| Schema::new(own, record, babbled.clone(), folder.clone()));
    if babbled.session.effort.is_none()
        && babbled.session.recording.is_none()
        && !babbled.session.engine.is_empty()
    {
        warn(py, &format!("{}: babbling was not finished", folder.path().display()))?;
    }
    let session = Session { babbled, folder, own: None, interrupted: false };
    (session, schema).into_pyobject(py)
}
