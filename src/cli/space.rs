//! `bodyschema space`: where a creature's hands can get to, by the schema of a session.

use std::path::PathBuf;
use std::time::Instant;

use nalgebra::Vector3;
use serde_json::{Value, json};

use super::folders::written_session;
use super::{Failure, Outcome, output, progress};
use crate::creature::Posture;
use crate::experiment::{hands, learned_body};
use crate::kinematics::Place;
use crate::peripersonal::{Level, OwnBody, ReachableMap};
use crate::view::space::{slices, vtk};

/// Tell where a creature's hands can get to, by the schema of a session.
///
/// A map of voxels in the frame of the chest at ease: near is what the tip of a hand reaches by the arm alone, far what
/// it reaches when the trunk leans. Joints' ranges alone count; whether limbs are in each other's way is not regarded.
/// Three slices of it are kept in the session, for `bodyschema report`. With a stick there is one more map, of its tip.
#[derive(clap::Args)]
#[command(after_help = "Examples:
  bodyschema space sessions/max-1
  bodyschema space sessions/max-1 --voxel 0.04 --picture space.svg --vtk space.vtk
  bodyschema space sessions/max-1 --voxel 0.04 --hand left_hand --at 0.3,0.2,0.1 --json
  bodyschema space sessions/max-1 --voxel 0.04 --stick right_hand=0.06,0.03,-0.31 --picture space.svg")]
pub struct SpaceArguments {
    /// The session's folder
    session: PathBuf,
    /// A limb that reaches; may be given several times [default: the limbs whose names end in hand]
    #[arg(long, value_name = "LIMB")]
    hand: Vec<String>,
    /// The side of a voxel, metres
    #[arg(long, value_name = "METRES", default_value_t = 0.02)]
    voxel: f64,
    /// A stick that a hand holds: where its tip is in the frame of that limb, metres, as `talk` tells it
    #[arg(long, value_name = "LIMB=X,Y,Z", value_parser = stick)]
    stick: Option<Stick>,
    /// Write the maps to a file that ParaView opens
    #[arg(long, value_name = "FILE", help_heading = "Output")]
    vtk: Option<PathBuf>,
    /// Write a picture of three slices
    #[arg(long, value_name = "FILE.svg", help_heading = "Output")]
    picture: Option<PathBuf>,
    /// A point in the chest's frame, metres: tell how far away it is, and a posture that reaches for it
    #[arg(long, value_name = "X,Y,Z", value_parser = point, allow_hyphen_values = true)]
    at: Option<Vector3<f64>>,
    /// Print one JSON object
    #[arg(long, help_heading = "Output")]
    json: bool,
}

fn point(text: &str) -> Result<Vector3<f64>, String> {
    let numbers: Result<Vec<f64>, _> = text.split(',').map(|number| number.trim().parse::<f64>()).collect();
    match numbers.as_deref() {
        Ok(&[x, y, z]) if [x, y, z].iter().all(|number| number.is_finite()) => Ok(Vector3::new(x, y, z)),
        _ => Err("a point is three numbers of metres with commas between, as in 0.3,0.2,0.1".to_string()),
    }
}

/// A stick in a hand.
#[derive(Clone)]
struct Stick {
    hand: String,
    /// Its tip in the hand's frame, metres.
    tip: Vector3<f64>,
}

fn stick(text: &str) -> Result<Stick, String> {
    let (hand, tip) = text
        .split_once('=')
        .ok_or("a stick is a limb and where its tip is, as in right_hand=0.06,0.03,-0.31")?;
    Ok(Stick { hand: hand.trim().to_string(), tip: point(tip)? })
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

pub fn run(args: &SpaceArguments) -> Outcome {
    let _lock = written_session(&args.session)?;
    let own = learned_body(&args.session)?;
    let hands = hands(&own, &args.hand)?;
    let chest = own.carrier_of(&hands);
    let began = Instant::now();
    let mut maps = Vec::with_capacity(hands.len());
    let held = args.stick.as_ref().map(|stick| held(&own, &hands, stick)).transpose()?;
    let bar = progress::steps((hands.len() + usize::from(held.is_some())) as u64);
    let unmappable = |error| Failure(format!("{}: {error}", args.session.display()));
    for &hand in &hands {
        bar.set_message(format!("where the {} gets to", own.creature().limbs()[hand].replace('_', " ")));
        maps.push(ReachableMap::new(&own, hand, chest, args.voxel).map_err(unmappable)?);
        bar.inc(1);
    }
    if let Some(tip) = held {
        bar.set_message("where the stick gets to");
        let map = ReachableMap::of_place(&own, tip.limb, tip, chest, args.voxel);
        maps.push(map.map_err(unmappable)?);
        bar.inc(1);
    }
    bar.finish_and_clear();
    let seconds = began.elapsed().as_secs_f64();
    let record = slices::record(&own, &maps);
    record.write(&args.session)?;
    if let Some(path) = &args.vtk {
        vtk::write(path, &own, &maps).map_err(|error| {
            Failure(format!("cannot write {}: {error}: give another file with --vtk", path.display()))
        })?;
    }
    if let Some(path) = &args.picture {
        let says = format!(
            "{}: where {} can get to, in the frame of {}",
            own.creature().name(),
            record.hands.join(" and "),
            record.chest
        );
        output::file(path, &slices::chart(&record, &says).alone())?;
    }
    let limbs = own.creature().limbs();
    let answers: Vec<Answer> =
        args.at.iter().flat_map(|at| maps.iter().map(|map| Answer::new(&own, map, at))).collect();
    if args.json {
        let told = maps.iter().map(|map| {
            let [near, far] = map.volumes().map(|volume| 1e3 * volume);
            json!({
                "hand": map.name(&own),
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
        say!("  {:<24}{near:>12.1}{far:>12.1}  {extents}", map.name(&own));
    }
    if maps.len() > 1 {
        for (name, [near, far]) in ["any of them", "each of them"].into_iter().zip(litres(&maps)) {
            say!("  {name:<24}{near:>12.1}{far:>12.1}");
        }
    }
    if let Some(at) = &args.at {
        say!("");
        answers.iter().for_each(Answer::print);
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
    let named = own.creature().limbs().iter().zip(distances);
    let mut known: Vec<(String, f64)> =
        named.filter_map(|(limb, distance)| Some((limb.clone(), distance?))).collect();
    known.sort_by(|a, b| a.1.total_cmp(&b.1));
    known
}

/// The tip of a stick that one of some hands holds, as a place of that hand.
fn held(own: &OwnBody, hands: &[usize], stick: &Stick) -> Result<Place, Failure> {
    let limb = own.creature().limb(&stick.hand).filter(|limb| hands.contains(limb));
    let limb = limb.ok_or_else(|| {
        let known: Vec<&str> = hands.iter().map(|&hand| own.creature().limbs()[hand].as_str()).collect();
        Failure(format!(
            "--stick {}: no map is made of that limb: give one of {}, or name it with --hand as well",
            stick.hand,
            known.join(", ")
        ))
    })?;
    let direction = stick.tip.try_normalize(1e-6).unwrap_or_else(Vector3::x);
    Ok(Place { limb, point: stick.tip, direction })
}

/// What a map tells of a point.
struct Answer {
    hand: String,
    level: Level,
    beyond: f64,
    posture: Posture,
    miss: f64,
}

impl Answer {
    fn new(own: &OwnBody, map: &ReachableMap, at: &Vector3<f64>) -> Answer {
        let (mut posture, miss) = map.reach(at);
        own.creature().couple(&mut posture);
        Answer { hand: map.name(own), level: map.level(at), beyond: map.beyond(at), posture, miss }
    }

    fn json(&self, own: &OwnBody) -> Value {
        let names = own.creature().elements().map(|at| (at.name.clone(), json!(at.of(&self.posture))));
        json!({
            "hand": self.hand,
            "level": self.level.name(),
            "beyond": self.beyond,
            "miss": self.miss,
            "posture": names.collect::<serde_json::Map<_, _>>(),
        })
    }

    fn print(&self) {
        let hand = &self.hand;
        match self.level {
            Level::OutOfReach => say!("  {hand}: out of reach by {:.3} m", self.beyond),
            level => say!("  {hand}: {}, reached to {:.1} mm", level.name(), 1e3 * self.miss),
        }
    }
}
