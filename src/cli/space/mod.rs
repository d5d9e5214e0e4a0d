//! `bodyschema space`: where a creature's hands can get to, by the schema of a session.

mod picture;
mod slices;
mod vtk;

use std::path::{Path, PathBuf};
use std::time::Instant;

use nalgebra::Vector3;
use serde_json::{Value, json};

use super::{Failure, Outcome, output, progress};
use crate::evaluation::is_hand;
use crate::learning::Input;
use crate::peripersonal::{Level, OwnBody, ReachableMap};
use crate::record::{SCHEMA_FILE, Session, read_schema};

/// Tell where a creature's hands can get to, by the schema of a session.
///
/// A map of voxels in the frame of the chest at ease: near is what the tip of a hand reaches by the arm alone, far what
/// it reaches when the trunk leans. Joints' ranges alone count; whether limbs are in each other's way is not regarded.
/// Three slices of it are kept in the session, for `bodyschema report`.
#[derive(clap::Args)]
#[command(after_help = "Examples:
  bodyschema space sessions/max-1
  bodyschema space sessions/max-1 --picture space.svg --vtk space.vtk
  bodyschema space sessions/max-1 --hand left_hand --at 0.3,0.2,0.1 --json")]
pub struct Args {
    /// The session's folder
    session: PathBuf,
    /// A limb that reaches; may be given several times [default: the limbs whose names end in hand]
    #[arg(long, value_name = "LIMB")]
    hand: Vec<String>,
    /// The side of a voxel, metres
    #[arg(long, value_name = "METRES", default_value_t = 0.02)]
    voxel: f64,
    /// Write the maps to a file that ParaView opens
    #[arg(long, value_name = "FILE")]
    vtk: Option<PathBuf>,
    /// Write a picture of three slices
    #[arg(long, value_name = "FILE.svg")]
    picture: Option<PathBuf>,
    /// A point in the chest's frame, metres: tell how far away it is, and a posture that reaches for it
    #[arg(long, value_name = "X,Y,Z", value_parser = point, allow_hyphen_values = true)]
    at: Option<Vector3<f64>>,
    /// Print one JSON object
    #[arg(long)]
    json: bool,
}

fn point(text: &str) -> Result<Vector3<f64>, String> {
    let numbers: Result<Vec<f64>, _> = text.split(',').map(|number| number.trim().parse::<f64>()).collect();
    match numbers.as_deref() {
        Ok(&[x, y, z]) if [x, y, z].iter().all(|number| number.is_finite()) => Ok(Vector3::new(x, y, z)),
        _ => Err("a point is three numbers of metres with commas between, as in 0.3,0.2,0.1".to_string()),
    }
}

/// What a session's creature knows of its body.
fn own_body(folder: &Path) -> Result<OwnBody, Failure> {
    let session = Session::read(folder)?;
    let schema = read_schema(&folder.join(SCHEMA_FILE), &session.creature)?;
    Ok(OwnBody::new(&session.creature, &session.skin, schema, &[], Input::Receptor))
}

/// The limbs that reach: those that are named, else all with receptors whose names end in hand.
pub(super) fn hands(own: &OwnBody, names: &[String]) -> Result<Vec<usize>, Failure> {
    let limbs = own.creature.limbs();
    let touching: Vec<String> =
        (1..limbs.len()).filter(|&limb| own.tip_of(limb).is_some()).map(|limb| limbs[limb].clone()).collect();
    let named = |name: &String| {
        let limb = own.creature.limb(name).filter(|limb| touching.contains(&limbs[*limb]));
        let choice = output::names(&touching);
        limb.ok_or_else(|| {
            Failure(format!("--hand {name}: there is no such limb with receptors: choose one of {choice}"))
        })
    };
    if !names.is_empty() {
        let mut hands = names.iter().map(named).collect::<Result<Vec<usize>, Failure>>()?;
        hands.dedup();
        return Ok(hands);
    }
    let hands: Vec<usize> = (1..limbs.len())
        .filter(|&limb| limbs[limb].ends_with("hand") && is_hand(&own.creature, limb))
        .collect();
    let hands: Vec<usize> = hands.into_iter().filter(|&limb| touching.contains(&limbs[limb])).collect();
    if hands.is_empty() {
        return Err(Failure(format!(
            "{} has no limb with receptors whose name ends in hand: name one with --hand, of {}",
            own.creature.name(),
            output::names(&touching)
        )));
    }
    Ok(hands)
}

/// What is near and what is far, litres: for any of several maps, and for each of them.
fn litres(maps: &[ReachableMap]) -> [[f64; 2]; 2] {
    let lattice = vtk::about(maps);
    let mut counts = [[0.0; 2]; 2];
    for cell in (0..lattice.len()).map(|index| lattice.cell_at(index)) {
        let levels = || maps.iter().map(|map| map.level_of(cell));
        let nearest = levels().max_by_key(|level| level.number());
        let farthest = levels().min_by_key(|level| level.number());
        for (level, counts) in [nearest, farthest].into_iter().zip(&mut counts) {
            match level {
                Some(Level::Near) => counts[0] += 1.0,
                Some(Level::Far) => counts[1] += 1.0,
                _ => {}
            }
        }
    }
    counts.map(|counts| counts.map(|count| 1e3 * count * lattice.voxel.powi(3)))
}

/// Least and greatest coordinate along each axis of what is reached, metres.
fn extents(map: &ReachableMap, near: bool) -> [[f64; 2]; 3] {
    let mut extents = [[f64::INFINITY, f64::NEG_INFINITY]; 3];
    for (cell, _) in map.voxels().filter(|(_, level)| !near || *level == Level::Near) {
        let (middle, half) = (map.lattice().middle(cell), map.lattice().half());
        for k in 0..3 {
            let [low, high] = &mut extents[k];
            (*low, *high) = (low.min(middle[k] - half), high.max(middle[k] + half));
        }
    }
    extents
}

pub fn run(args: &Args) -> Outcome {
    let own = own_body(&args.session)?;
    let hands = hands(&own, &args.hand)?;
    let chest = own.carrier_of(&hands);
    let began = Instant::now();
    let mut maps = Vec::with_capacity(hands.len());
    let bar = progress::steps(hands.len() as u64);
    for &hand in &hands {
        bar.set_message(format!("where the {} gets to", own.creature.limbs()[hand].replace('_', " ")));
        maps.push(
            ReachableMap::new(&own, hand, chest, args.voxel)
                .map_err(|error| Failure(format!("{}: {error}", args.session.display())))?,
        );
        bar.inc(1);
    }
    bar.finish_and_clear();
    let seconds = began.elapsed().as_secs_f64();
    slices::record(&own, &maps).write(&args.session)?;
    if let Some(path) = &args.vtk {
        vtk::write(path, &own, &maps)?;
    }
    if let Some(path) = &args.picture {
        let svg = picture::svg(&own, &maps)
            .map_err(|error| Failure(format!("{}: it cannot be drawn: {error}", path.display())))?;
        output::file(path, &svg)?;
    }
    let limbs = own.creature.limbs();
    let answers: Vec<Answer> =
        args.at.iter().flat_map(|at| maps.iter().map(|map| Answer::new(&own, map, at))).collect();
    if args.json {
        let told = maps.iter().map(|map| {
            let [near, far] = map.volumes().map(|volume| 1e3 * volume);
            json!({
                "hand": limbs[map.hand],
                "tip": map.tip.point.as_slice(),
                "near_l": near,
                "far_l": far,
                "near_extents": extents(map, true),
                "extents": extents(map, false),
            })
        });
        let [either, both] = litres(&maps);
        return output::json(&json!({
            "session": args.session,
            "chest": limbs[chest],
            "voxel": args.voxel,
            "hands": told.collect::<Vec<_>>(),
            "either": {"near_l": either[0], "far_l": either[1]},
            "both": {"near_l": both[0], "far_l": both[1]},
            "seconds": seconds,
            "at": args.at.map(|at| json!({
                "point": at.as_slice(),
                "hands": answers.iter().map(|answer| answer.json(&own)).collect::<Vec<_>>(),
                "limbs": distances(&own, &maps[0], &at).into_iter().map(|(limb, metres)| json!({"limb": limb, "distance": metres})).collect::<Vec<_>>(),
            })),
        }));
    }
    say!(
        "{}: voxels of {} m in the frame of {}, worked out in {seconds:.2} s",
        args.session.display(),
        args.voxel,
        limbs[chest]
    );
    say!("  {:<24}{:>12}{:>12}   x, m             y, m             z, m", "", "near, l", "far, l");
    for map in &maps {
        let [near, far] = map.volumes().map(|volume| 1e3 * volume);
        let extents = extents(map, false).map(|[low, high]| format!("{low:>6.2} to {high:<5.2}")).join("  ");
        say!("  {:<24}{near:>12.1}{far:>12.1}  {extents}", limbs[map.hand]);
    }
    if maps.len() > 1 {
        for (name, [near, far]) in ["any of them", "each of them"].into_iter().zip(litres(&maps)) {
            say!("  {name:<24}{near:>12.1}{far:>12.1}");
        }
    }
    if let Some(at) = &args.at {
        say!("");
        answers.iter().for_each(|answer| answer.print(&own));
        say!("  from the limbs at ease:");
        for (limb, metres) in distances(&own, &maps[0], at) {
            say!("    {limb:<24}{metres:>8.3} m");
        }
    }
    Ok(())
}

/// How far a point in the map's frame is from every limb that has a surface, with the body at ease, nearest first.
fn distances(own: &OwnBody, map: &ReachableMap, at: &Vector3<f64>) -> Vec<(String, f64)> {
    let distances = own.distances(&own.frames(&own.at_ease()), &map.frame.point(at));
    let named = own.creature.limbs().iter().zip(distances);
    let mut known: Vec<(String, f64)> =
        named.filter_map(|(limb, distance)| Some((limb.clone(), distance?))).collect();
    known.sort_by(|a, b| a.1.total_cmp(&b.1));
    known
}

/// What a map tells of a point.
struct Answer {
    hand: usize,
    level: Level,
    beyond: f64,
    posture: Vec<f64>,
    miss: f64,
}

impl Answer {
    fn new(own: &OwnBody, map: &ReachableMap, at: &Vector3<f64>) -> Answer {
        let (mut posture, miss) = map.reach(at);
        own.creature.couple(&mut posture);
        Answer { hand: map.hand, level: map.level(at), beyond: map.beyond(at), posture, miss }
    }

    fn json(&self, own: &OwnBody) -> Value {
        let names = own
            .creature
            .dofs_in_posture()
            .map(|(q, dof)| (dof.name.clone(), json!(self.posture[q..q + dof.kind.coordinates()])));
        json!({
            "hand": own.creature.limbs()[self.hand],
            "level": self.level.name(),
            "beyond": self.beyond,
            "miss": self.miss,
            "posture": names.collect::<serde_json::Map<_, _>>(),
        })
    }

    fn print(&self, own: &OwnBody) {
        let hand = &own.creature.limbs()[self.hand];
        match self.level {
            Level::OutOfReach => say!("  {hand}: out of reach by {:.3} m", self.beyond),
            level => say!("  {hand}: {}, reached to {:.1} mm", level.name(), 1e3 * self.miss),
        }
    }
}
