//! `bodyschema reach`: where a creature's hands can get to, by the schema of a session.

use std::path::PathBuf;
use std::time::Instant;

use nalgebra::Vector3;
use serde_json::{Value, json};

use super::folders::written_session;
use super::{Failure, Outcome, output, progress};
use crate::named::in_words;
use crate::peripersonal::{Level, OwnBody, Reach, ReachableMap};
use crate::session::{hands, learned_body};
use crate::view::space::{slices, vtk};
use crate::view::text::error_number;

/// Tell where a creature's hands can get to, by the schema of a session.
///
/// A map of voxels in the frame of the chest at ease: near is what the tip of a hand reaches by the arm alone, far what
/// it reaches when the trunk leans. Joints' ranges alone count; whether limbs are in each other's way is not regarded.
/// Three slices of it are kept in the session, for `bodyschema report`.
/// Where a hand is not placed by what was touched, that is told: its map is a guess then.
#[derive(clap::Args)]
#[command(after_help = "Examples:
  bodyschema reach sessions/max-1
  bodyschema reach sessions/max-1 --voxel 0.04 --picture reach.svg --vtk reach.vtk
  bodyschema reach sessions/max-1 --at 0.3,0.2,0.1
  bodyschema reach sessions/max-1 --hand left_hand --at 0.3,0.2,0.1 --json")]
pub struct ReachArguments {
    /// The session's folder
    session: PathBuf,
    /// A limb that reaches; may be given several times [default: the limbs whose names end in hand]
    #[arg(long, value_name = "LIMB")]
    hand: Vec<String>,
    /// The side of a voxel, metres [default: about a 50th of the longest reach, 2 cm for Max]
    #[arg(long, value_name = "METRES")]
    voxel: Option<f64>,
    /// Write the maps to a file that ParaView opens
    #[arg(long, value_name = "FILE", help_heading = "Output")]
    vtk: Option<PathBuf>,
    /// Write a picture of three slices
    #[arg(long, value_name = "FILE.svg", help_heading = "Output")]
    picture: Option<PathBuf>,
    /// A point in the chest's frame, metres: tell how far away it is, and a posture that reaches for it. Alone it is answered
    /// without the map
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

/// Voxels in the longest reach where the map is asked for, and where it only helps to answer for a point.
const FINE: f64 = 50.0;
const COARSE: f64 = 12.0;

/// A side of voxels that are about so many in a length, metres: 1, 2 or 5 of some decimal place.
fn side_of(length: f64, many: f64) -> f64 {
    let side = (length / many).max(1e-4);
    let decade = 10f64.powf(side.log10().floor());
    [5.0, 2.0, 1.0].into_iter().find(|&round| round * decade <= side).unwrap_or(1.0) * decade
}

pub fn run(args: &ReachArguments) -> Outcome {
    let _lock = written_session(&args.session)?;
    let own = learned_body(&args.session)?;
    let hands = hands(&own, &args.hand)?;
    let chest = own.carrier_of(&hands);
    let tips: Vec<_> = hands.iter().filter_map(|&hand| own.tip_of(hand)).collect();
    let at_alone = args.at.is_some() && args.voxel.is_none() && args.vtk.is_none() && args.picture.is_none();
    let longest = tips.iter().map(|tip| own.length_of(tip)).fold(0.0, f64::max);
    let voxel = args.voxel.unwrap_or_else(|| side_of(longest, if at_alone { COARSE } else { FINE }));
    let began = Instant::now();
    let bar = progress::steps(tips.len() as u64);
    let mut maps = Vec::with_capacity(tips.len());
    for tip in tips {
        let limb = tip.limb;
        bar.set_message(format!("where the {} gets to", in_words(&own.creature().limbs()[limb])));
        let map = ReachableMap::of_place(&own, limb, tip, chest, voxel);
        maps.push(map.map_err(|error| Failure(format!("{}: {error}", args.session.display())))?);
        bar.inc(1);
    }
    bar.finish_and_clear();
    let space = Space { own, hands, chest, maps, voxel, seconds: began.elapsed().as_secs_f64() };
    if !at_alone {
        space.write(args)?;
    }
    let answers: Vec<Answer> =
        args.at.iter().flat_map(|at| space.maps.iter().map(|map| Answer::new(&space.own, map, at))).collect();
    if args.json {
        return space.print_json(args, at_alone, &answers);
    }
    if at_alone {
        let chest = &space.own.creature().limbs()[chest];
        say!("{}: in the frame of {chest}", args.session.display());
    } else {
        space.print(args);
    }
    for doubt in space.doubts() {
        say!("  {doubt}");
    }
    if let Some(at) = &args.at {
        if !at_alone {
            say!("");
        }
        answers.iter().for_each(Answer::print);
        say!("  from the limbs at ease:");
        for (limb, metres) in distances(&space.own, &space.maps[0], at) {
            say!("    {limb:<24}{metres:>8.3} m");
        }
    }
    Ok(())
}

/// What was worked out.
struct Space {
    own: OwnBody,
    hands: Vec<usize>,
    chest: usize,
    maps: Vec<ReachableMap>,
    /// Metres.
    voxel: f64,
    seconds: f64,
}

impl Space {
    /// What of it is no knowledge, in sentences.
    fn doubts(&self) -> Vec<String> {
        let doubt = |&hand: &usize| {
            let (limbs, why) = (self.own.creature().limbs(), self.own.unplaced(hand)?);
            Some(format!("{}: where it gets to is a guess, for it is not placed ({why})", limbs[hand]))
        };
        self.hands.iter().filter_map(doubt).collect()
    }

    /// Keeps the slices in the session, and writes the files that are asked for.
    fn write(&self, args: &ReachArguments) -> Outcome {
        let record = slices::record(&self.own, &self.maps, self.doubts());
        record.write(&args.session)?;
        if let Some(path) = &args.vtk {
            vtk::write(path, &self.own, &self.maps).map_err(|error| {
                Failure(format!("cannot write {}: {error}: give another file with --vtk", path.display()))
            })?;
        }
        if let Some(path) = &args.picture {
            let says = format!(
                "{}: where {} can get to, in the frame of {}",
                self.own.creature().name(),
                record.hands.join(" and "),
                record.chest
            );
            output::file(path, slices::chart(&record, &says).alone())?;
        }
        Ok(())
    }

    fn print_json(&self, args: &ReachArguments, at_alone: bool, answers: &[Answer]) -> Outcome {
        let (own, limbs) = (&self.own, self.own.creature().limbs());
        let told = self.maps.iter().map(|map| {
            let [near, far] = map.volumes().map(|volume| 1e3 * volume);
            json!({
                "hand": map.name(own),
                "tip": map.tip.point.as_slice(),
                "near_l": near,
                "far_l": far,
            })
        });
        let at = args.at.map(|at| {
            let limbs = distances(own, &self.maps[0], &at);
            let limbs = limbs.into_iter().map(|(limb, metres)| json!({"limb": limb, "distance": metres}));
            json!({
                "point": at.as_slice(),
                "hands": answers.iter().map(|answer| answer.json(own)).collect::<Vec<_>>(),
                "limbs": limbs.collect::<Vec<_>>(),
            })
        });
        let mut all = json!({
            "session": args.session,
            "chest": limbs[self.chest],
            "doubts": self.doubts(),
            "seconds": self.seconds,
            "at": at,
        });
        // Volumes of voxels as coarse as an answer for a point needs would mislead.
        if !at_alone {
            (all["voxel"], all["hands"]) = (json!(self.voxel), told.collect());
        }
        output::json(&all)
    }

    fn print(&self, args: &ReachArguments) {
        say!(
            "{}: voxels of {} m in the frame of {}, worked out in {:.2} s",
            args.session.display(),
            self.voxel,
            self.own.creature().limbs()[self.chest],
            self.seconds
        );
        say!("  {:<24}{:>12}{:>12}", "", "near, l", "far, l");
        for map in &self.maps {
            let [near, far] = map.volumes().map(|volume| 1e3 * volume);
            say!("  {:<24}{near:>12.1}{far:>12.1}", map.name(&self.own));
        }
    }
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

/// What a hand can do about a point.
struct Answer {
    hand: String,
    reach: Reach,
    /// How far out of reach it is, metres; 0 where it is not.
    beyond: f64,
}

impl Answer {
    fn new(own: &OwnBody, map: &ReachableMap, at: &Vector3<f64>) -> Answer {
        let mut reach = map.reach(at);
        own.creature().couple(&mut reach.posture);
        let beyond = if reach.level == Level::OutOfReach { reach.miss } else { 0.0 };
        Answer { hand: map.name(own), reach, beyond }
    }

    fn json(&self, own: &OwnBody) -> Value {
        let posture = &self.reach.posture;
        let names = own.creature().elements().map(|at| (at.name.clone(), json!(at.of(posture))));
        json!({
            "hand": self.hand,
            "level": self.reach.level.name(),
            "beyond": self.beyond,
            "miss": self.reach.miss,
            "posture": names.collect::<serde_json::Map<_, _>>(),
        })
    }

    fn print(&self) {
        let hand = &self.hand;
        match self.reach.level {
            Level::OutOfReach => say!("  {hand}: out of reach by {} mm", error_number(1e3 * self.beyond)),
            level => {
                say!("  {hand}: {}, reached to {} mm", level.name(), error_number(1e3 * self.reach.miss))
            }
        }
    }
}
