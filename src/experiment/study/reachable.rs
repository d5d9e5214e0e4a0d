//! How well a learned body knows where its hands can get to.

use std::collections::BTreeSet;
use std::time::Instant;

use nalgebra::Vector3;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use serde_json::json;

use super::plot::{AxisScale, PlotAxis, PlotSeries, StudyPlot};
use super::subject::{Subject, median};
use super::table::{WallTime, row};
use super::{Findings, Study, Trial, Trials};
use crate::experiment::ExperimentError;
use crate::experiment::hands;
use crate::kinematics::{ChainSide, InverseKinematics, Place, REACHED};
use crate::peripersonal::{Level, OwnBody, ReachableMap};

/// The study `reachable`.
pub const STUDY: Study = Study {
    name: "reachable",
    about: "how well the learned body knows where its hands can get to, and how fast it tells",
    touches: true,
    several: false,
    trials: Trials::of::<ReachableTrial>(),
};

/// The side of a voxel, metres.
const VOXEL: f64 = 0.02;
/// Random postures of the true body, of the arm alone and as many with the trunk; drawn so many at a time.
const POSTURES: u64 = 1_000_000;
const DRAWN: u64 = 10_000;
/// Points that are asked for.
const QUERIES: usize = 20_000;
/// Points that are reached for.
const REACHES: usize = 2_000;
/// Voxels just beyond the map that are sought by another solver, each from so many random postures.
const BEYOND: usize = 400;
const STARTS: usize = 8;

row! {
    /// A measurement of the study `reachable`.
    pub struct ReachableMeasurement {
        hand: String = "hand",
        seed: u64 = "seed",
        near_l: f64 = "near, l",
        far_l: f64 = "far, l",
        overlap_near: f64 = "overlap, near",
        overlap_all: f64 = "overlap, all",
        strict_near: f64 = "with random, near",
        strict_all: f64 = "with random, all",
        random_found: f64 = "random found",
        beyond_reached: f64 = "beyond, yet reached",
        missed: f64 = "missed so",
        build_s: WallTime = "build, s",
        query_us: WallTime = "query, us",
        query_p99_us: WallTime = "99 %, us",
        ik_us: WallTime = "reaching, us",
        ik_reached: f64 = "reached",
        ik_rest_us: WallTime = "from rest, us",
        ik_rest_reached: f64 = "reached",
    }
}

/// What one map came to: the columns after hand and seed.
type Measured = [f64; 16];

/// The measurements of one trial, hand by hand.
#[derive(Debug, Serialize, Deserialize)]
pub struct ReachableTrial(Vec<ReachableMeasurement>);

impl Trial for ReachableTrial {
    type Setting = ();
    type Measurement = ReachableMeasurement;
    type Summary = ReachableMeasurement;

    fn set_up(_subject: &Subject) -> Result<(), ExperimentError> {
        Ok(())
    }

    fn run(subject: &Subject, (): &(), seed: u64) -> Result<ReachableTrial, ExperimentError> {
        let own = subject.own_body(seed)?;
        let knowing = own.with_schema(subject.truth().schema.clone());
        let hands = hands(&own, &[])?;
        let chest = own.carrier_of(&hands);
        let mut measurements = Vec::new();
        for hand in hands {
            let name = own.creature().limbs()[hand].clone();
            subject.tell(seed, &format!("the space of {name}"));
            measurements.push(row_of(&name, seed, &measure_hand(&own, &knowing, hand, chest, seed)?));
        }
        Ok(ReachableTrial(measurements))
    }

    fn findings(
        _subject: &Subject,
        trials: &[ReachableTrial],
    ) -> Findings<ReachableMeasurement, ReachableMeasurement> {
        findings(trials)
    }
}

fn findings(trials: &[ReachableTrial]) -> Findings<ReachableMeasurement, ReachableMeasurement> {
    let mut found: Vec<(String, Vec<Measured>)> = Vec::new();
    for row in trials.iter().flat_map(|trial| &trial.0) {
        match found.iter_mut().find(|(name, _)| *name == row.hand) {
            Some((_, trials)) => trials.push(measured_of(row)),
            None => found.push((row.hand.clone(), vec![measured_of(row)])),
        }
    }
    let mut summary: Vec<ReachableMeasurement> = Vec::new();
    for (name, trials) in &found {
        let medians = std::array::from_fn(|k| median(trials.iter().map(|trial| trial[k])));
        summary.push(row_of(name, trials.len() as u64, &medians));
    }
    let all = || found.iter().flat_map(|(_, trials)| trials);
    let least = |columns: &[usize]| {
        all().flat_map(|trial| columns.iter().map(|&k| trial[k])).fold(f64::INFINITY, f64::min)
    };
    let most = |k: usize| all().map(|trial| trial[k]).fold(0.0, f64::max);
    let middle = |k: usize| median(all().map(|trial| trial[k]));
    // What another solver still gets into is missing on both maps.
    let strict = all().map(|trial| trial[4].min(trial[5]) * (1.0 - trial[8])).fold(f64::INFINITY, f64::min);
    let numbers = vec![
        ("overlap", json!(strict)),
        ("overlap_with_random", json!(least(&[4, 5]))),
        ("overlap_same_builder", json!(least(&[2, 3]))),
        ("random_found", json!(least(&[6]))),
        ("missed", json!(most(8))),
        ("build_s", json!(most(9))),
        (
            "build_all_hands_s",
            json!(found.iter().map(|(_, t)| median(t.iter().map(|trial| trial[9]))).sum::<f64>()),
        ),
        ("query_us", json!(middle(10))),
        ("query_p99_us", json!(most(11))),
        ("ik_us", json!(middle(12))),
        ("ik_reached", json!(least(&[13]))),
        ("ik_rest_us", json!(middle(14))),
        ("ik_rest_reached", json!(least(&[15]))),
    ];
    let notes = vec![
        format!(
            "Voxels of {VOXEL} m. Overlap: intersection over union with the map of the true body; with random: with that \
             map and all voxels of {} true random postures, half of them without leaning. Medians over trials, in the \
             column seed their number.",
            2 * POSTURES
        ),
        format!(
            "Beyond, yet reached: the share of {BEYOND} voxels next to the map that general inverse kinematics on the \
             true body gets into from any of {STARTS} random postures; missed so: the share of all voxels that these \
             are. The number `overlap` in the file is the lesser overlap with random, less what is missed."
        ),
        "A query: how far away a random point in and about the map is, by how much it is out of reach, and a posture \
         near it. Reaching: a posture with the tip at a random point of the map, from the one that the map keeps."
            .to_string(),
    ];
    let names: Vec<String> = found.iter().map(|(name, _)| name.clone()).collect();
    let series = ["near", "all"].iter().enumerate().map(|(level, name)| PlotSeries {
        name: (*name).to_string(),
        line: Vec::new(),
        dots: found
            .iter()
            .enumerate()
            .flat_map(|(k, (_, trials))| trials.iter().map(move |t| (1.0 - t[4 + level], k as f64)))
            .collect(),
    });
    let plot = StudyPlot {
        x: PlotAxis {
            title: "share of the voxels of either that only one has",
            scale: AxisScale::Logarithmic,
        },
        y: PlotAxis { title: "", scale: AxisScale::Names(names) },
        series: series.collect(),
    };
    let measurements = trials.iter().flat_map(|trial| trial.0.clone()).collect();
    Findings { measurements, summary, notes, plot, numbers }
}

/// The columns after hand and seed of a row.
fn measured_of(row: &ReachableMeasurement) -> Measured {
    [
        row.near_l,
        row.far_l,
        row.overlap_near,
        row.overlap_all,
        row.strict_near,
        row.strict_all,
        row.random_found,
        row.beyond_reached,
        row.missed,
        row.build_s.0,
        row.query_us.0,
        row.query_p99_us.0,
        row.ik_us.0,
        row.ik_reached,
        row.ik_rest_us.0,
        row.ik_rest_reached,
    ]
}

/// A row of the table.
fn row_of(hand: &str, seed: u64, measured: &Measured) -> ReachableMeasurement {
    let [near_l, far_l, overlap_near, overlap_all, strict_near, strict_all, random_found, beyond_reached, ..] =
        *measured;
    let [.., missed, build_s, query_us, query_p99_us, ik_us, ik_reached, ik_rest_us, ik_rest_reached] =
        *measured;
    ReachableMeasurement {
        hand: hand.to_string(),
        seed,
        near_l,
        far_l,
        overlap_near,
        overlap_all,
        strict_near,
        strict_all,
        random_found,
        beyond_reached,
        missed,
        build_s: WallTime(build_s),
        query_us: WallTime(query_us),
        query_p99_us: WallTime(query_p99_us),
        ik_us: WallTime(ik_us),
        ik_reached,
        ik_rest_us: WallTime(ik_rest_us),
        ik_rest_reached,
    }
}

fn measure_hand(
    own: &OwnBody,
    knowing: &OwnBody,
    hand: usize,
    chest: usize,
    seed: u64,
) -> Result<Measured, ExperimentError> {
    let began = Instant::now();
    let map = ReachableMap::new(own, hand, chest, VOXEL)?;
    let build = began.elapsed().as_secs_f64();
    let true_map = ReachableMap::new(knowing, hand, chest, VOXEL)?;
    let [overlap_near, overlap_all] = map.overlap(&true_map);
    let trunk = knowing.joints_to(chest);
    let every = knowing.joints_to(hand);
    let arm: Vec<usize> = every.iter().copied().filter(|joint| !trunk.contains(joint)).collect();
    let near = random_voxels(knowing, &true_map, &arm, seed, 0);
    let mut all = random_voxels(knowing, &true_map, &every, seed, POSTURES);
    all.extend(&near);
    let held = all.iter().filter(|&&cell| map.level_of(cell) != Level::OutOfReach).count()
        + near.iter().filter(|&&cell| map.level_of(cell) == Level::Near).count();
    let [near_l, far_l] = map.volumes().map(|volume| 1e3 * volume);
    let strict_near = with_voxels(&map, &true_map, &near, |level| level == Level::Near);
    let strict_all = with_voxels(&map, &true_map, &all, |level| level != Level::OutOfReach);
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let mut queries = query_times(&map, &mut rng);
    queries.sort_by(f64::total_cmp);
    let beyond = beyond_reached(knowing, &map, &mut rng);
    let missed = map.just_beyond().len() as f64 * beyond;
    let missed = missed / (map.voxels().count() as f64 + missed);
    let at_ease = own.at_ease();
    let cells: Vec<[i32; 3]> = map.voxels().map(|(cell, _)| cell).collect();
    let (mut warm, mut cold, mut reached) = (Vec::new(), Vec::new(), [0.0; 2]);
    for _ in 0..REACHES {
        let cell = cells[rng.random_range(0..cells.len())];
        let half = map.lattice().half();
        let point = map.lattice().middle(cell) + Vector3::from_fn(|_, _| rng.random_range(-half..half));
        for (k, times) in [&mut warm, &mut cold].into_iter().enumerate() {
            let began = Instant::now();
            let (_, miss) = if k == 0 { map.reach(&point) } else { map.reach_from(&point, &at_ease) };
            times.push(1e6 * began.elapsed().as_secs_f64());
            reached[k] += f64::from(u8::from(miss <= REACHED)) / REACHES as f64;
        }
    }
    Ok([
        near_l,
        far_l,
        overlap_near,
        overlap_all,
        strict_near,
        strict_all,
        held as f64 / (all.len() + near.len()) as f64,
        beyond,
        missed,
        build,
        median(queries.iter().copied()),
        queries[queries.len() * 99 / 100],
        median(warm),
        reached[0],
        median(cold),
        reached[1],
    ])
}

/// The voxels in which random true postures have the tip, by forward kinematics alone; half of them favour the ends of
/// the ranges.
fn random_voxels(
    knowing: &OwnBody,
    map: &ReachableMap,
    joints: &[usize],
    seed: u64,
    stream: u64,
) -> BTreeSet<[i32; 3]> {
    let base = knowing.at_ease();
    let path = knowing.joints_to(map.hand);
    let draws: Vec<Vec<[i32; 3]>> = (0..POSTURES / DRAWN)
        .into_par_iter()
        .map(|draw| {
            let mut rng = ChaCha8Rng::seed_from_u64(seed);
            rng.set_stream(stream + draw + 1);
            let mut cells: Vec<[i32; 3]> = (0..DRAWN)
                .map(|k| {
                    let mut posture = knowing.random_posture(&base, joints, &mut rng);
                    if k % 2 == 1 {
                        widen(knowing, joints, &mut posture);
                    }
                    let pose = ChainSide::new(knowing.creature(), &path, &posture).frame(&knowing.schema);
                    map.lattice().cell(&map.frame.inverse_point(&pose.point(&map.tip.point)))
                })
                .collect();
            cells.sort_unstable();
            cells.dedup();
            cells
        })
        .collect();
    draws.into_iter().flatten().collect()
}

/// Moves the coordinates of some joints towards the ends of their ranges.
fn widen(knowing: &OwnBody, joints: &[usize], posture: &mut [f64]) {
    for joint in joints.iter().map(|&joint| &knowing.creature().joints()[joint]) {
        for at in joint.elements().filter(|at| !at.is_ball()) {
            let ([low, high], q) = (at.range, at.coordinate());
            if high > low {
                let share = (posture[q] - low) / (high - low);
                posture[q] = low + (high - low) * (0.5 - 0.5 * (std::f64::consts::PI * share).cos());
            }
        }
    }
    knowing.creature().couple(posture);
}

/// Intersection over union of the map with the true map and more voxels that are truly reached.
fn with_voxels(
    map: &ReachableMap,
    true_map: &ReachableMap,
    more: &BTreeSet<[i32; 3]>,
    counts: fn(Level) -> bool,
) -> f64 {
    let voxels = |map: &ReachableMap| -> Vec<[i32; 3]> {
        map.voxels().filter(|(_, level)| counts(*level)).map(|(cell, _)| cell).collect()
    };
    let mut truth = voxels(true_map);
    truth.extend(more.iter().filter(|&&cell| !counts(true_map.level_of(cell))));
    let both = truth.iter().filter(|&&cell| counts(map.level_of(cell))).count();
    both as f64 / (truth.len() + voxels(map).len() - both) as f64
}

/// How long single queries take, microseconds.
fn query_times(map: &ReachableMap, rng: &mut ChaCha8Rng) -> Vec<f64> {
    let lattice = map.lattice();
    let (low, counts) =
        (lattice.middle(lattice.first), Vector3::from(lattice.counts.map(|count| count as f64)));
    (0..QUERIES)
        .map(|_| {
            let share = Vector3::from_fn(|_, _| rng.random_range(-0.1..1.1));
            let point = low + counts.component_mul(&share) * lattice.voxel;
            let began = Instant::now();
            let answer = map.whereabouts(&point);
            let seconds = began.elapsed().as_secs_f64();
            std::hint::black_box(answer);
            1e6 * seconds
        })
        .collect()
}

/// The share of voxels next to the map that another solver gets into, on the true body.
fn beyond_reached(knowing: &OwnBody, map: &ReachableMap, rng: &mut ChaCha8Rng) -> f64 {
    let beyond = map.just_beyond();
    if beyond.is_empty() {
        return 0.0;
    }
    let base = knowing.at_ease();
    let joints = knowing.joints_to(map.hand);
    let mut reached = 0usize;
    for _ in 0..BEYOND {
        let cell = beyond[rng.random_range(0..beyond.len())];
        let target = |point: Vector3<f64>| Place { limb: 0, point, direction: Vector3::zeros() };
        let tip = Place { direction: Vector3::zeros(), ..map.tip };
        let middle = map.frame.point(&map.lattice().middle(cell));
        let mut solver = InverseKinematics::new(knowing.creature(), &knowing.schema, [tip, target(middle)])
            .with_direction_lengths([0.0, 0.0]);
        reached += usize::from((0..STARTS).any(|_| {
            let found = solver.solve(&knowing.random_posture(&base, &joints, rng));
            let pose = ChainSide::new(knowing.creature(), &joints, &found.posture).frame(&knowing.schema);
            map.lattice().cell(&map.frame.inverse_point(&pose.point(&map.tip.point))) == cell
        }));
    }
    reached as f64 / BEYOND as f64
}
