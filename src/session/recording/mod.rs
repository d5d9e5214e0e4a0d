//! Self-touch recordings of a body that no simulator knows: a creature by hand, a log of touches from anywhere.
//!
//! A creature comes from a JSON file ([`read_creature`]), the log from a [table](super::table) ([`read_recording`]). What a touch
//! needs is where the joints were, which two limbs met, and either the point of contact in both limbs' frames or the receptors
//! that felt it. Limbs without a skin get [bare receptors](bare_receptors), so that such a recording is a session as any other.

mod creature_file;
mod posture;

use std::path::Path;

use csv::StringRecord;
use nalgebra::Vector3;

pub use creature_file::{CreatureFile, read_creature};
pub(super) use creature_file::{creature_of, list, typed};

use super::table::{CellFault, LIMBS, Measure, POINTS, RECEPTORS, Table, read_table};
use super::touch_columns::{TouchColumns, coordinate_columns, left_out_in_words};
use super::touch_line::check;
use super::words::listed;
use crate::agent::Agent;
use crate::calibration::{SAME_POINT, SAME_POSTURE, drop_alike};
use crate::creature::{Creature, Dof, Posture};
use crate::error::Error;
use crate::named::did_you_mean;
use crate::senses::{ExactContact, Input, RecordedTouch, Touch, TouchEnd};
use crate::skin::{Receptor, Skin};

/// Bare receptors of a limb at the most.
const BARE_RECEPTORS: usize = 12;

/// A log of touches, and the skin that they are on.
#[derive(Clone, Debug, PartialEq)]
pub struct Recording {
    /// The agent that was given, with bare receptors if limbs were touched that have none.
    pub agent: Agent,
    /// The touches in the log's order.
    pub touches: Vec<RecordedTouch>,
    /// What the touches report: points if every touch has them and one lacks receptors, else receptors.
    pub input: Input,
    /// What looks odd, in sentences: nothing that stands in the way.
    pub notes: Vec<String>,
}

/// One end of a touch as the log has it.
struct RawEnd {
    /// The name of the limb.
    limb: Option<String>,
    /// The id of the receptor.
    receptor: Option<String>,
    /// The point of contact in the limb's frame, metres.
    point: Option<Vector3<f64>>,
    /// Standard deviation of each of its coordinates, metres.
    deviation: Option<f64>,
}

impl RawEnd {
    /// The receptor, an index into the skin; `None` if the skin does not have it.
    fn receptor(&self, skin: &Skin) -> Option<usize> {
        self.receptor.as_ref().and_then(|id| skin.receptor(id))
    }
}

/// A touch before it is known whether creature and skin have what it names; its posture in the creature's order.
struct RawTouch {
    line: usize,
    bout: Option<u64>,
    motion: Option<u64>,
    posture: Posture,
    ends: [RawEnd; 2],
}

/// Reads a recording's touches from `path`: JSON or a table of comma-separated values, packed by gzip or not.
///
/// # Errors
/// If the file cannot be read, or, with line and column, for what is
/// no touch of the creature; for a log without touches; and for one whose angles look like degrees.
pub fn read_recording(path: &Path, agent: &Agent) -> Result<Recording, Error> {
    let creature = agent.creature();
    let columns_of_dof = |dof: &Dof| coordinate_columns(&dof.name, dof.kind);
    let coordinates: Vec<_> = creature.dofs().flat_map(columns_of_dof).collect();
    let names: Vec<String> = coordinates.iter().map(|(name, _)| name.clone()).collect();
    let mut table = read_table(path, &names, Some(creature))?;
    let (mut touches, mut left_out) = (Vec::with_capacity(table.rows.len()), Vec::new());
    let mut columns = None;
    if !table.rows.is_empty() || !table.columns.is_empty() {
        let found = columns_of(&mut table, &coordinates);
        columns = Some(found.map_err(|fault| Error::content(path, Some(table.line), fault))?);
    }
    for ((line, row), columns) in table.rows.iter().zip(columns.iter().cycle()) {
        match raw_touch(&table, columns, *line, row, creature) {
            Ok(touch) => touches.push(touch),
            Err(CellFault::NotFinite(fault)) => left_out.push((*line, fault)),
            Err(CellFault::Wrong(fault)) => return Err(Error::content(path, Some(*line), fault)),
        }
    }
    let left_out = left_out_in_words(&left_out, table.rows.len());
    if touches.is_empty() {
        let why = left_out.map_or(String::new(), |note| format!(" ({note})"));
        let message = format!("it holds no touch{why}: give one with a touch a line");
        return Err(Error::content(path, None, message));
    }
    let odd = posture::check(path, creature, &touches)?;
    let mut notes: Vec<String> = table.notes().chain(left_out).chain(odd).collect();
    notes.extend(columns.and_then(|columns| columns.note()));
    let mut recording = resolve(path, agent, &touches)?;
    let rows = recording.touches.len();
    let repeats = drop_repeats(&mut recording.touches);
    notes.extend((repeats > 0).then(|| {
        format!("{repeats} of {rows} rows repeat another in the same posture: each touch counts once")
    }));
    Ok(Recording { notes, ..recording })
}

/// The columns of a table, which has all that a touch needs.
fn columns_of(table: &mut Table, coordinates: &[(String, Option<Measure>)]) -> Result<TouchColumns, String> {
    let columns = TouchColumns::new(table, coordinates, &[])?;
    if let Some(missing) = columns.posture.iter().position(Option::is_none) {
        let name = &coordinates[missing].0;
        let meant = columns.spare.iter().find(|other| did_you_mean(other.name(), [name.as_str()]).is_some());
        let meant =
            meant.map_or(String::new(), |other| format!(", or is {} meant? Then rename it", other.title));
        return Err(format!("there is no column {name}: add this degree of freedom{meant}"));
    }
    for side in [0, 1] {
        let (limb, receptor, [x, y, z]) = (LIMBS[side], RECEPTORS[side], POINTS[side]);
        let has = |name: &str| columns.place(name).is_some();
        if !(has(receptor) || has(limb) && has(x)) {
            let missing = if has(limb) { x } else { limb };
            return Err(format!(
                "there is no column {missing}: give {limb} with {x}, {y}, {z}, or {receptor}"
            ));
        }
    }
    Ok(columns)
}

/// The touch of a row.
fn raw_touch(
    table: &Table,
    columns: &TouchColumns,
    line: usize,
    row: &StringRecord,
    creature: &Creature,
) -> Result<RawTouch, CellFault> {
    let number = |at: &usize| table.number(row, *at, "radians, or metres of a slide");
    let mut posture = columns.posture.iter().flatten().map(number).collect::<Result<Vec<f64>, _>>()?;
    posture::unit_quaternions(creature, &mut posture);
    let end = |side: usize| -> Result<RawEnd, CellFault> {
        Ok(RawEnd {
            limb: columns.text(row, LIMBS[side]).map(str::to_string),
            receptor: columns.text(row, RECEPTORS[side]).map(str::to_string),
            point: columns.point(table, row, side)?,
            deviation: columns.deviation(table, row, side)?,
        })
    };
    Ok(RawTouch {
        line,
        bout: columns.count(table, row, "bout")?,
        motion: columns.count(table, row, "motion")?,
        ends: [end(0)?, end(1)?],
        posture: posture.into(),
    })
}

/// Leaves of touches that repeat one another the first; how many went.
fn drop_repeats(touches: &mut Vec<RecordedTouch>) -> usize {
    drop_alike(touches, |touch| {
        let posture = touch.posture.iter().map(|x| x / SAME_POSTURE);
        let points = touch.exact_contact().points.iter().flatten().map(|x| x / SAME_POINT);
        ((touch.bout, touch.ends.map(|end| end.receptor)), posture.chain(points).collect())
    })
}

/// Gives every touch its limbs and receptors.
fn resolve(path: &Path, agent: &Agent, raw: &[RawTouch]) -> Result<Recording, Error> {
    let limbs = agent.creature().limbs();
    let refuse = |touch: &RawTouch, fault: String| Error::content(path, Some(touch.line), fault);
    let of_touch = |touch: &RawTouch| -> Result<[usize; 2], String> {
        Ok([limb_of(agent, touch, 0)?, limb_of(agent, touch, 1)?])
    };
    let met = raw.iter().map(|touch| of_touch(touch).map_err(|fault| refuse(touch, fault)));
    let met: Vec<[usize; 2]> = met.collect::<Result<_, _>>()?;
    let mut points = vec![Vec::new(); limbs.len()];
    for (end, &limb) in raw.iter().flat_map(|touch| &touch.ends).zip(met.iter().flatten()) {
        if end.receptor(agent.skin()).is_none() {
            points[limb].extend(end.point);
        }
    }
    let mut skin = agent.skin().clone();
    let given = skin.receptors.len();
    for (limb, points) in points.iter().enumerate() {
        if !skin.receptors.iter().any(|receptor| receptor.limb == limb) {
            skin.receptors.extend(bare_receptors(&limbs[limb], limb, points));
        }
    }
    let agent = agent.with_skin(skin).map_err(|error| Error::content(path, None, error.to_string()))?;
    let skin = agent.skin();
    let named = |end: &RawEnd| end.receptor(skin).filter(|&receptor| receptor < given);
    let ends = || raw.iter().flat_map(|touch| &touch.ends);
    let all_receptors = ends().all(|end| named(end).is_some());
    let mut touches = Vec::with_capacity(raw.len());
    for (number, (found, limbs)) in raw.iter().zip(&met).enumerate() {
        // The end on the earlier limb comes first.
        let order = if limbs[0] > limbs[1] { [1, 0] } else { [0, 1] };
        let receptors = order.map(|k| {
            let end = &found.ends[k];
            let receptor = named(end).or_else(|| nearest(skin, limbs[k], &end.point?));
            receptor.expect("an end has a receptor or a point")
        });
        let touch = Touch {
            bout: found.bout.unwrap_or(0),
            motion: found.motion.unwrap_or(number as u64 + 1),
            posture: found.posture.clone(),
            ends: receptors.map(TouchEnd::at),
            moment: None,
        };
        let point = |k: usize| found.ends[order[k]].point.unwrap_or(skin.receptors[receptors[k]].position);
        let deviations = order.map(|k| found.ends[k].deviation);
        let contact = ExactContact { points: [point(0), point(1)], deviations, depth: None };
        let touch = RecordedTouch::new(touch, contact);
        check(&touch, &agent).map_err(|fault| refuse(found, fault))?;
        touches.push(touch);
    }
    if let Some(without) = raw.iter().find(|touch| touch.ends.iter().any(|end| end.point.is_none()))
        && !all_receptors
    {
        let message = "this touch has only receptors and others have only points: give points in every touch, or \
                       receptors in every touch";
        return Err(refuse(without, message.into()));
    }
    let input = if all_receptors { Input::Receptor } else { Input::Contact };
    Ok(Recording { agent, touches, input, notes: Vec::new() })
}

/// The limb of one end of a touch: where its receptor is, or the one that is named.
fn limb_of(agent: &Agent, touch: &RawTouch, k: usize) -> Result<usize, String> {
    let (creature, skin) = (agent.creature(), agent.skin());
    let end = &touch.ends[k];
    let side = ["a", "b"][k];
    let unknown = |name: &String| {
        format!(
            "column {}: {} has no limb \"{name}\": name one of {}",
            LIMBS[k],
            creature.name(),
            listed(creature.limbs())
        )
    };
    let limb = |name: &String| creature.limb(name).ok_or_else(|| unknown(name));
    let named = end.limb.as_ref().map(limb).transpose()?;
    let felt = end.receptor(skin).map(|receptor| skin.receptors[receptor].limb);
    match (felt, named, &end.receptor) {
        (Some(felt), Some(named), Some(id)) if felt != named => Err(format!(
            "column {}: receptor \"{id}\" is on limb {}, not on {}: mend one of the two",
            LIMBS[k],
            creature.limbs()[felt],
            creature.limbs()[named]
        )),
        (Some(limb), ..) => Ok(limb),
        (None, _, Some(id)) if end.point.is_none() || named.is_none() => {
            let mend = if skin.receptors.is_empty() {
                "give the creature's file a skin, or give limbs and points in place of receptors"
            } else {
                "give the skin that the touches were recorded with"
            };
            Err(format!("column {}: the skin has no receptor \"{id}\": {mend}", RECEPTORS[k]))
        }
        (None, Some(_), _) if end.point.is_none() => Err(format!(
            "end {side} has a limb but no point on it: give the point of contact in the limb's frame, or a receptor"
        )),
        (None, Some(limb), _) => Ok(limb),
        (None, None, _) => Err(format!("end {side} has no limb: name the limb, or a receptor of the skin")),
    }
}

/// The receptor of a limb whose centre is nearest to a point.
fn nearest(skin: &Skin, limb: usize, point: &Vector3<f64>) -> Option<usize> {
    let distance = |receptor: usize| (skin.receptors[receptor].position - point).norm_squared();
    let on_limb = (0..skin.receptors.len()).filter(|&receptor| skin.receptors[receptor].limb == limb);
    on_limb.min_by(|&a, &b| distance(a).total_cmp(&distance(b)))
}

/// Receptors of a limb that has no skin: without extent or surface, at points where it was touched, each as far
/// from those before as there is one.
fn bare_receptors(name: &str, limb: usize, points: &[Vector3<f64>]) -> Vec<Receptor> {
    let mut centres: Vec<Vector3<f64>> = Vec::new();
    let mut distances = vec![f64::INFINITY; points.len()];
    while centres.len() < BARE_RECEPTORS {
        let farthest = (0..points.len()).max_by(|&a, &b| distances[a].total_cmp(&distances[b]));
        let Some(farthest) = farthest.filter(|&i| distances[i] > 0.0) else { break };
        centres.push(points[farthest]);
        for (distance, point) in distances.iter_mut().zip(points) {
            *distance = distance.min((point - points[farthest]).norm());
        }
    }
    let receptor = |(i, position)| Receptor {
        id: format!("{name}/{}", i + 1),
        limb,
        position,
        normal: Vector3::z(),
        tangent: Vector3::x(),
        half_extents: [0.0; 2],
        surface: None,
    };
    centres.into_iter().enumerate().map(receptor).collect()
}
