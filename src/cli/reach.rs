//! `bodyschema reach`: the reachable workspace of each hand, from a session's schema.

use std::path::PathBuf;
use std::time::Instant;

use nalgebra::Vector3;
use serde_json::{Map, Value, json};

use super::folders::written_session;
use super::{Failure, Outcome, output, progress};
use crate::export::reachable_vtk;
use crate::named::in_words;
use crate::peripersonal::{COARSE, FINE, Level, OwnBody, ReachableMap, voxel_side};
use crate::session::{SpaceRecord, hands, learned_body, write_whole};
use crate::view::table::Table;

/// Compute the reachable workspace of each hand from a session's schema.
///
/// The map consists of voxels in the frame of the chest in the rest posture: near is what the tip of a hand reaches
/// with the arm alone, far what it reaches when the trunk leans. Only joint ranges are considered, not collisions
/// between limbs. Three slices are stored in the session for `bodyschema report`. The map of a hand that is not located
/// is a guess, and reported as such.
#[derive(clap::Args)]
#[command(after_help = "Examples:
  bodyschema reach sessions/max-1
  bodyschema reach sessions/max-1 --voxel 0.04 --vtk reach.vtk
  bodyschema reach sessions/max-1 --at 0.3,0.2,0.1
  bodyschema reach sessions/max-1 --hand left_hand --at 0.3,0.2,0.1 --json")]
pub struct ReachArguments {
    /// The session's folder
    session: PathBuf,
    /// The limb that reaches; repeatable [default: the limbs whose names end in hand]
    #[arg(long, value_name = "LIMB")]
    hand: Vec<String>,
    /// Side of a voxel, metres [default: about 1/50 of the longest reach, 2 cm for Max]
    #[arg(long, value_name = "METRES")]
    voxel: Option<f64>,
    /// Write the maps to a VTK file, for ParaView
    #[arg(long, value_name = "FILE", help_heading = "Output")]
    vtk: Option<PathBuf>,
    /// A point in the chest's frame, metres: print its distance and a posture that reaches for it. Without --voxel and
    /// --vtk no map is stored
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
        _ => {
            Err("give a point as three numbers in metres, separated by commas, such as 0.3,0.2,0.1"
                .to_string())
        }
    }
}

pub fn run(args: &ReachArguments) -> Outcome {
    let _lock = written_session(&args.session)?;
    let own = learned_body(&args.session)?;
    let limbs = own.creature().limbs();
    let hands = hands(&own, &args.hand)?;
    let chest = own.carrier_of(&hands);
    let tips: Vec<_> = hands.iter().filter_map(|&hand| own.tip_of(hand)).collect();
    let at_alone = args.at.is_some() && args.voxel.is_none() && args.vtk.is_none();
    let longest = tips.iter().map(|tip| own.length_of(tip)).fold(0.0, f64::max);
    let voxel = args.voxel.unwrap_or_else(|| voxel_side(longest, if at_alone { COARSE } else { FINE }));
    let began = Instant::now();
    let bar = progress::steps(tips.len() as u64);
    let mut maps = Vec::with_capacity(tips.len());
    for tip in tips {
        bar.set_message(format!("workspace of the {}", in_words(&limbs[tip.limb])));
        let map = ReachableMap::of_place(&own, tip.limb, tip, chest, voxel);
        maps.push(map.map_err(|error| Failure::at(&args.session, error))?);
        bar.inc(1);
    }
    bar.finish_and_clear();
    let seconds = began.elapsed().as_secs_f64();
    let doubt = |&hand: &usize| {
        let why = own.unplaced(hand)?;
        Some(format!("{}: its workspace is a guess, because it is not located ({why})", limbs[hand]))
    };
    let doubts: Vec<String> = hands.iter().filter_map(doubt).collect();
    let at = args.at.map(|at| answer(&own, &maps, &at));
    let mut found = json!({
        "session": args.session,
        "chest": limbs[chest],
        "doubts": doubts,
        "seconds": seconds,
        "at": at,
    });
    if !at_alone {
        write(args, &own, &maps, doubts.clone())?;
        // Volumes of voxels as coarse as an answer for a point needs would mislead.
        (found["voxel"], found["hands"]) =
            (json!(voxel), maps.iter().map(|map| volumes(&own, map)).collect());
    }
    if args.json {
        return output::json(&found);
    }
    let (session, chest) = (args.session.display(), &limbs[chest]);
    if at_alone {
        say!("{session}: in the frame of {chest}");
    } else {
        say!("{session}: voxels of {voxel} m in the frame of {chest}, computed in {seconds:.2} s");
        let columns = [("hand", "hand"), ("near, l", "near_l"), ("far, l", "far_l")];
        output::table(&Table::of_json(&found["hands"], &columns));
    }
    doubts.iter().for_each(|doubt| say!("  {doubt}"));
    let Some(at) = at else { return Ok(()) };
    for hand in at["hands"].as_array().into_iter().flatten() {
        let [beyond, miss] =
            ["beyond", "miss"].map(|field| output::number(1e3 * hand[field].as_f64().unwrap_or(f64::NAN)));
        match (hand["hand"].as_str().unwrap_or_default(), hand["level"].as_str().unwrap_or_default()) {
            (name, _) if hand["beyond"] != 0.0 => say!("  {name}: out of reach by {beyond} mm"),
            (name, level) => say!("  {name}: {level}, reached within {miss} mm"),
        }
    }
    let columns = [("distance from the limbs in the rest posture", "limb"), ("m", "distance")];
    output::table(&Table::of_json(&at["limbs"], &columns));
    Ok(())
}

/// Stores the slices in the session, and writes the file that is asked for.
fn write(args: &ReachArguments, own: &OwnBody, maps: &[ReachableMap], doubts: Vec<String>) -> Outcome {
    SpaceRecord::of(own, maps, doubts).write(&args.session)?;
    let Some(path) = &args.vtk else { return Ok(()) };
    write_whole(path, &reachable_vtk(own, maps)).map_err(|error| {
        Failure(format!("cannot write {}: {error}: give another file with --vtk", path.display()))
    })
}

/// How much a hand reaches, litres.
fn volumes(own: &OwnBody, map: &ReachableMap) -> Value {
    let [near, far] = map.volumes().map(|volume| 1e3 * volume);
    json!({ "hand": map.name(own), "tip": map.tip.point.as_slice(), "near_l": near, "far_l": far })
}

/// How far a point in the maps' frame is from every hand and from every limb that has a surface, with the body in the rest posture,
/// nearest first; metres.
fn answer(own: &OwnBody, maps: &[ReachableMap], at: &Vector3<f64>) -> Value {
    let creature = own.creature();
    let hand = |map: &ReachableMap| {
        let mut reach = map.reach(at);
        creature.couple(&mut reach.posture);
        let posture = creature.elements().map(|at| (at.name.clone(), json!(at.of(&reach.posture))));
        json!({
            "hand": map.name(own),
            "level": reach.level.name(),
            "beyond": if reach.level == Level::OutOfReach { reach.miss } else { 0.0 },
            "miss": reach.miss,
            "posture": posture.collect::<Map<_, _>>(),
        })
    };
    let distances = maps.first().map(|map| own.distances(&own.frames(&own.at_ease()), &map.frame.point(at)));
    let named = creature.limbs().iter().zip(distances.into_iter().flatten());
    let mut known: Vec<(&String, f64)> =
        named.filter_map(|(limb, distance)| Some((limb, distance?))).collect();
    known.sort_by(|a, b| a.1.total_cmp(&b.1));
    let limb = |(limb, metres): &(&String, f64)| json!({ "limb": limb, "distance": metres });
    json!({
        "point": at.as_slice(),
        "hands": maps.iter().map(hand).collect::<Vec<_>>(),
        "limbs": known.iter().map(limb).collect::<Vec<_>>(),
    })
}
