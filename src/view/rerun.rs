//! A session as a recording for Rerun's viewer: the bodies, the touches and the errors, over time.

use std::io;
use std::path::Path;

use nalgebra::Vector3;
use re_chunk::{Chunk, ChunkId, EntityPath, RowId, TimePoint};
use re_log_encoding::Encoder;
use re_log_types::{
    EntityPathPart, LogMsg, SetStoreInfo, StoreId, StoreInfo, StoreKind, StoreSource, TimeCell,
};
use re_types::AsComponents;
use re_types::archetypes::{
    Arrows3D, LineStrips3D, Points3D, Scalars, SeriesLines, Transform3D, ViewCoordinates,
};
use re_types::components::{Color, LineStrip3D, Radius};
use re_types::datatypes::Quaternion;
use sha2::{Digest, Sha256};

use super::body::Pose;
use crate::agent::Agent;
use crate::creature::Posture;
use crate::record::{Checkpoint, LearningRows, PROGRAM, write_whole};
use crate::schema::BodySchema;
use crate::senses::Touch;

/// Most touches of which the bodies are shown: of Max each takes some three kilobytes.
const MOST_SHOWN: usize = 10_000;
/// Rows that a viewer loads at a time.
const ROWS: usize = 1024;
/// How long the arrow of an axis is, by the greatest extent of the skeleton.
const AXIS: f64 = 0.06;
/// Radii of points and of lines, of which a viewer makes the same on the screen however near they are.
const POINT: f32 = 2.0;
const JOINT: f32 = 4.0;
const PLACE: f32 = 6.0;
const LINE: f32 = 1.5;
/// Colours, red, green and blue: of the true body, of the learned one and its axes, …
const TRUE: [u8; 3] = [147, 161, 173];
const LEARNED: [u8; 3] = [242, 142, 60];
const AXES: [u8; 3] = [31, 111, 178];
/// … of the two receptors that touch, and of the place where they do.
const RECEPTORS: [[u8; 3]; 2] = [[246, 213, 115], [120, 190, 90]];
const TOUCHED: [u8; 3] = [215, 48, 31];

/// What is shown of a session.
#[derive(Clone, Copy, Debug)]
pub struct RerunInput<'a> {
    /// What the agent was given.
    pub agent: &'a Agent,
    /// The true body, where that is known; must fit the creature.
    pub truth: Option<&'a BodySchema>,
    /// The touches, in their order.
    pub touches: &'a [Touch],
    /// The schema on the way, by the number of touches; every schema must fit the creature.
    pub checkpoints: &'a [Checkpoint],
    /// The table of learning: its errors.
    pub table: &'a LearningRows,
}

/// Writes a recording for Rerun's viewer (`.rrd`), whole or not at all. The same input gives the same bytes.
///
/// All is in the root limb's frame, metres. On the timeline `touch` 0 is the initial guess, the body at zero, and k the k-th
/// touch in its posture; where all touches have times there is a timeline `time` as well, the bouts one after the
/// other, each until its last touch.
///
/// - `true/skeleton`, lines from joint to joint, and `true/skin/LIMB`, its receptors in the limb's frame with the
///   limb's pose: where the true body is known.
/// - `learned/skeleton`, lines, `learned/joints`, points, and `learned/axes`, an arrow per hinge and slide from its
///   joint: by the last checkpoint until then.
/// - `touch/receptors`, the centres of the two, labelled by their ids, and `touch/place`, between the two points of
///   contact: on the true body, or where that is not known on the learned one.
/// - `error/COLUMN`, a number per row of `learning.csv` that has one, millimetres or degrees by the column's name;
///   `learning/COLUMN` of columns without a unit. `error/error_rms_mm` and `error/bound_rms_mm` are of checkpoints.
///
/// Of more than 10,000 touches every second, third, … is shown, and every one that has a checkpoint.
///
/// # Errors
/// Where the file cannot be written.
pub fn write_rrd(path: &Path, input: &RerunInput) -> io::Result<()> {
    let chunks = RrdChunks::of(input).map_err(io::Error::other)?;
    // Viewers take recordings of one name for parts of one: this one's is that of its content.
    let unnamed = encode(&chunks, "").map_err(io::Error::other)?;
    let name: String = Sha256::digest(&unnamed)[..16].iter().map(|byte| format!("{byte:02x}")).collect();
    write_whole(path, &encode(&chunks, &name).map_err(io::Error::other)?)
}

type Failed = Box<dyn std::error::Error + Send + Sync>;

fn encode(chunks: &[Chunk], name: &str) -> Result<Vec<u8>, Failed> {
    let store = StoreId::new(StoreKind::Recording, env!("CARGO_PKG_NAME"), name);
    let info = StoreInfo::new(store.clone(), StoreSource::Other(PROGRAM.to_string()));
    let mut encoder = Encoder::local()?;
    encoder.append(&LogMsg::SetStoreInfo(SetStoreInfo { row_id: RowId::ZERO.as_tuid(), info }))?;
    for chunk in chunks {
        encoder.append(&LogMsg::ArrowMsg(store.clone(), chunk.to_arrow_msg()?))?;
    }
    encoder.finish()?;
    Ok(encoder.into_inner()?)
}

/// A recording in the making.
#[derive(Default)]
struct RrdChunks {
    chunks: Vec<Chunk>,
    /// Numbers given away: every row and every chunk has its own.
    ids: u128,
}

impl RrdChunks {
    fn of(input: &RerunInput) -> Result<Vec<Chunk>, Failed> {
        let mut recording = RrdChunks::default();
        recording.constant(&[], &ViewCoordinates::RIGHT_HAND_Z_UP())?;
        let moments = Moments::new(input);
        if let Some(truth) = input.truth {
            recording.true_body(input, truth, &moments)?;
        }
        recording.learned_body(input, &moments)?;
        recording.touches(input, &moments)?;
        recording.errors(input, &moments)?;
        Ok(recording.chunks)
    }

    fn id(&mut self) -> u128 {
        self.ids += 1;
        self.ids
    }

    /// What is the same at all times.
    fn constant(&mut self, entity: &[&str], what: &dyn AsComponents) -> Result<(), Failed> {
        let (chunk, row) = (ChunkId::from_u128(self.id()), RowId::from_u128(self.id()));
        let builder = Chunk::builder_with_id(chunk, path(entity));
        self.chunks.push(builder.with_archetype(row, TimePoint::default(), what).build()?);
        Ok(())
    }

    /// What is another at every time.
    fn changing<T: AsComponents>(
        &mut self,
        entity: &[&str],
        rows: impl IntoIterator<Item = (TimePoint, T)>,
    ) -> Result<(), Failed> {
        let mut rows = rows.into_iter().peekable();
        while rows.peek().is_some() {
            let mut builder = Chunk::builder_with_id(ChunkId::from_u128(self.id()), path(entity));
            for (time, what) in rows.by_ref().take(ROWS) {
                builder = builder.with_archetype(RowId::from_u128(self.id()), time, &what);
            }
            self.chunks.push(builder.build()?);
        }
        Ok(())
    }

    fn true_body(&mut self, input: &RerunInput, truth: &BodySchema, moments: &Moments) -> Result<(), Failed> {
        let RerunInput { agent, .. } = *input;
        let (creature, skin) = (agent.creature(), agent.skin());
        let poses: Vec<(TimePoint, Pose)> = moments
            .shown
            .iter()
            .map(|shown| (moments.at(shown.touch), Pose::new(creature, truth, &shown.posture)))
            .collect();
        let skeleton = ["true", "skeleton"];
        self.constant(&skeleton, &line(TRUE))?;
        self.changing(&skeleton, poses.iter().map(|(time, pose)| (time.clone(), bones(pose, agent))))?;
        for (limb, name) in creature.limbs().iter().enumerate() {
            let own: Vec<_> = skin.receptors.iter().filter(|receptor| receptor.limb == limb).collect();
            if own.is_empty() {
                continue;
            }
            let entity = ["true", "skin", name.as_str()];
            let places = own.iter().map(|receptor| single(&receptor.position));
            self.constant(
                &entity,
                &Points3D::new(places).with_colors([colour(TRUE)]).with_radii([radius(POINT)]),
            )?;
            self.changing(
                &entity,
                poses.iter().map(|(time, pose)| (time.clone(), pose_of(&pose.frames[limb]))),
            )?;
        }
        Ok(())
    }

    fn learned_body(&mut self, input: &RerunInput, moments: &Moments) -> Result<(), Failed> {
        let RerunInput { agent, .. } = *input;
        let creature = agent.creature();
        let poses: Vec<(TimePoint, &Shown, &BodySchema, Pose)> = moments
            .shown
            .iter()
            .filter_map(|shown| {
                let schema = believed(input, shown.touch)?;
                Some((moments.at(shown.touch), shown, schema, Pose::new(creature, schema, &shown.posture)))
            })
            .collect();
        let Some((.., last)) = poses.last() else { return Ok(()) };
        let length = AXIS * extent(&last.begins);
        let [skeleton, joints, axes] = ["skeleton", "joints", "axes"].map(|part| ["learned", part]);
        self.constant(&skeleton, &line(LEARNED))?;
        self.changing(&skeleton, poses.iter().map(|(time, _, _, pose)| (time.clone(), bones(pose, agent))))?;
        self.constant(&joints, &point(JOINT).with_colors([colour(LEARNED)]))?;
        let begins = |pose: &Pose| Points3D::new(pose.begins[1..].iter().map(single));
        self.changing(&joints, poses.iter().map(|(time, _, _, pose)| (time.clone(), begins(pose))))?;
        let arrow = Arrows3D::update_fields().with_colors([colour(AXES)]).with_radii([radius(LINE)]);
        self.constant(&axes, &arrow)?;
        let arrows = poses.iter().map(|(time, shown, schema, pose)| {
            let found = pose.axes(creature, schema, &shown.posture);
            let vectors = found.iter().map(|[_, axis]| single(&(axis * length)));
            let origins = found.iter().map(|[origin, _]| single(origin));
            (time.clone(), Arrows3D::from_vectors(vectors).with_origins(origins))
        });
        self.changing(&axes, arrows)
    }

    fn touches(&mut self, input: &RerunInput, moments: &Moments) -> Result<(), Failed> {
        let RerunInput { agent, touches, .. } = *input;
        let (creature, skin) = (agent.creature(), agent.skin());
        let found: Vec<(TimePoint, &Touch, Pose)> = moments
            .shown
            .iter()
            .filter_map(|shown| {
                let touch = &touches[shown.touch.checked_sub(1)?];
                let schema = input.truth.or_else(|| believed(input, shown.touch))?;
                Some((moments.at(shown.touch), touch, Pose::new(creature, schema, &touch.posture)))
            })
            .collect();
        let [receptors, place] = ["receptors", "place"].map(|part| ["touch", part]);
        self.constant(&receptors, &point(PLACE).with_colors(RECEPTORS.map(colour)))?;
        let pair = |touch: &Touch, pose: &Pose| {
            let two = touch.ends.map(|end| &skin.receptors[end.receptor]);
            let places = two.map(|receptor| single(&pose.frames[receptor.limb].point(&receptor.position)));
            Points3D::new(places).with_labels(two.map(|receptor| receptor.id.as_str()))
        };
        self.changing(&receptors, found.iter().map(|(time, touch, pose)| (time.clone(), pair(touch, pose))))?;
        self.constant(&place, &point(PLACE).with_colors([colour(TOUCHED)]))?;
        let between = |touch: &Touch, pose: &Pose| {
            let [a, b] =
                touch.ends.map(|end| pose.frames[skin.receptors[end.receptor].limb].point(&end.contact));
            Points3D::new([single(&((a + b) / 2.0))])
        };
        self.changing(&place, found.iter().map(|(time, touch, pose)| (time.clone(), between(touch, pose))))
    }

    fn errors(&mut self, input: &RerunInput, moments: &Moments) -> Result<(), Failed> {
        let LearningRows { columns, rows } = input.table;
        let Some(touches) = columns.iter().position(|name| name == "touches") else { return Ok(()) };
        for (column, name) in columns.iter().enumerate().filter(|(column, _)| *column != touches) {
            let number = |row: &Vec<Option<f64>>| {
                let value = row[column].filter(|value| value.is_finite())?;
                Some((moments.at(row[touches]? as usize), Scalars::new([value])))
            };
            let error = name.ends_with("_mm") || name.ends_with("_deg");
            self.numbers(&[if error { "error" } else { "learning" }, name], rows.iter().filter_map(number))?;
        }
        let mut of_checkpoints = |name: &str, value: fn(&Checkpoint) -> Option<f64>| {
            let number = |at: &Checkpoint| {
                let value = value(at).filter(|value| value.is_finite())?;
                Some((moments.at(at.touches), Scalars::new([value])))
            };
            self.numbers(&["error", name], input.checkpoints.iter().filter_map(number))
        };
        of_checkpoints("error_rms_mm", |at| at.error_rms)?;
        of_checkpoints("bound_rms_mm", |at| at.bound_rms)
    }

    /// A curve by the name of the last part of its entity, unless it is empty.
    fn numbers(
        &mut self,
        entity: &[&str],
        rows: impl Iterator<Item = (TimePoint, Scalars)>,
    ) -> Result<(), Failed> {
        let mut rows = rows.peekable();
        if rows.peek().is_some() {
            self.constant(entity, &SeriesLines::new().with_names(entity.last().copied()))?;
            self.changing(entity, rows)?;
        }
        Ok(())
    }
}

/// A touch of which the bodies are shown; 0 is the initial guess.
struct Shown {
    touch: usize,
    posture: Posture,
}

/// What is shown when.
struct Moments {
    shown: Vec<Shown>,
    /// Seconds from the first bout's beginning, of the initial guess and of every touch; empty where a touch lacks it.
    seconds: Vec<f64>,
}

impl Moments {
    fn new(input: &RerunInput) -> Moments {
        let touches = input.touches;
        let step = touches.len().div_ceil(MOST_SHOWN).max(1);
        let checkpoint = |touch: &usize| input.checkpoints.iter().any(|at| at.touches == *touch);
        let shown = (0..=touches.len()).filter(|touch| touch % step == 0 || checkpoint(touch));
        let posture = |touch: usize| match touch.checked_sub(1) {
            Some(index) => touches[index].posture.clone(),
            None => input.agent.creature().reference_posture(),
        };
        let shown = shown.map(|touch| Shown { touch, posture: posture(touch) }).collect();
        Moments { shown, seconds: seconds(touches).unwrap_or_default() }
    }

    /// When a touch was, counted from 1.
    fn at(&self, touch: usize) -> TimePoint {
        let number = i64::try_from(touch).unwrap_or(i64::MAX);
        let time = TimePoint::default().with_index("touch", TimeCell::from_sequence(number));
        match self.seconds.get(touch) {
            Some(seconds) => {
                time.with_index("time", TimeCell::from_duration_nanos((seconds * 1e9).round() as i64))
            }
            None => time,
        }
    }
}

/// What was believed after a touch; before the first checkpoint nothing is known.
fn believed<'a>(input: &RerunInput<'a>, touch: usize) -> Option<&'a BodySchema> {
    let until = input.checkpoints.iter().filter(|at| at.touches <= touch);
    until.max_by_key(|at| at.touches).map(|at| &at.schema)
}

/// The times of the initial guess and of the touches, the bouts one after the other, seconds.
fn seconds(touches: &[Touch]) -> Option<Vec<f64>> {
    let (mut before, mut bout, mut last) = (0.0, touches.first()?.bout, 0.0);
    let mut found = vec![0.0];
    for touch in touches {
        if touch.bout != bout {
            (before, bout) = (last, touch.bout);
        }
        last = before + touch.moment?.time;
        found.push(last);
    }
    Some(found)
}

fn path(entity: &[&str]) -> EntityPath {
    EntityPath::new(entity.iter().map(|part| EntityPathPart::new(*part)).collect())
}

/// A viewer's numbers are of single precision.
fn single(v: &Vector3<f64>) -> [f32; 3] {
    [v.x as f32, v.y as f32, v.z as f32]
}

fn colour([red, green, blue]: [u8; 3]) -> Color {
    Color::from_rgb(red, green, blue)
}

fn radius(points: f32) -> Radius {
    Radius::new_ui_points(points)
}

fn point(size: f32) -> Points3D {
    Points3D::update_fields().with_radii([radius(size)])
}

fn line(rgb: [u8; 3]) -> LineStrips3D {
    LineStrips3D::update_fields().with_colors([colour(rgb)]).with_radii([radius(LINE)])
}

fn bones(pose: &Pose, agent: &Agent) -> LineStrips3D {
    let lines = pose.bones(agent);
    LineStrips3D::new(lines.iter().map(|ends| LineStrip3D::from_iter(ends.iter().map(single))))
}

fn pose_of(frame: &crate::geometry::Frame) -> Transform3D {
    let turned = frame.quaternion();
    let [x, y, z, w] = [turned.i, turned.j, turned.k, turned.w].map(|part| part as f32);
    Transform3D::from_translation_rotation(single(&frame.origin), Quaternion::from_xyzw([x, y, z, w]))
}

/// Greatest extent of points along an axis.
fn extent(points: &[Vector3<f64>]) -> f64 {
    let least = points.iter().fold(Vector3::repeat(f64::INFINITY), |a, b| a.inf(b));
    let most = points.iter().fold(Vector3::repeat(f64::NEG_INFINITY), |a, b| a.sup(b));
    (most - least).max()
}
