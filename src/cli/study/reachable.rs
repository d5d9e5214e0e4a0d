//! How well a learned body knows where its hands can get to.

use std::collections::BTreeSet;
use std::time::Instant;

use nalgebra::Vector3;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;
use serde_json::json;

use super::super::space::hands;
use super::plot::{Axis, Plot, Scale, Series};
use super::subject::{Subject, median};
use super::table::{Cell, Column, Table};
use super::{Failure, Findings, Study};
use crate::creature::DofKind;
use crate::kinematics::{ChainSide, InverseKinematics, Place, REACHED};
use crate::peripersonal::{Level, OwnBody, ReachableMap};

/// The study `reachable`.
pub const STUDY: Study = Study {
    name: "reachable",
    about: "how well the learned body knows where its hands can get to, and how fast it tells",
    touches: true,
    measure,
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

const MEASUREMENTS: &[Column] = &[
    Column { name: "hand", heading: "hand" },
    Column { name: "seed", heading: "seed" },
    Column { name: "near_l", heading: "near, l" },
    Column { name: "far_l", heading: "far, l" },
    Column { name: "overlap_near", heading: "overlap, near" },
    Column { name: "overlap_all", heading: "overlap, all" },
    Column { name: "strict_near", heading: "with random, near" },
    Column { name: "strict_all", heading: "with random, all" },
    Column { name: "random_found", heading: "random found" },
    Column { name: "beyond_reached", heading: "beyond, yet reached" },
    Column { name: "missed", heading: "missed so" },
    Column { name: "build_s", heading: "build, s" },
    Column { name: "query_us", heading: "query, us" },
    Column { name: "query_p99_us", heading: "99 %, us" },
    Column { name: "ik_us", heading: "reaching, us" },
    Column { name: "ik_reached", heading: "reached" },
    Column { name: "ik_rest_us", heading: "from rest, us" },
    Column { name: "ik_rest_reached", heading: "reached" },
];

/// What one map came to: the columns after hand and seed.
type Measured = [f64; 16];

fn measure(subject: &Subject) -> Result<Findings, Failure> {
    let mut measurements = Table::new(MEASUREMENTS);
    let mut found: Vec<(String, Vec<Measured>)> = Vec::new();
    for &seed in &subject.seeds {
        let own = subject.own_body(seed)?;
        let knowing = own.with_schema(subject.truth.schema.clone());
        let hands = hands(&own, &[])?;
        let chest = own.carrier_of(&hands);
        for hand in hands {
            let name = own.creature.limbs()[hand].clone();
            subject.tell(seed, &format!("the space of {name}"));
            let measured = measure_hand(&own, &knowing, hand, chest, seed)?;
            measurements.row(cells(name.as_str().into(), seed.into(), &measured));
            match found.iter_mut().find(|(other, _)| *other == name) {
                Some((_, trials)) => trials.push(measured),
                None => found.push((name, vec![measured])),
            }
        }
    }
    let mut summary = Table::new(MEASUREMENTS);
    for (name, trials) in &found {
        let medians = std::array::from_fn(|k| median(trials.iter().map(|trial| trial[k])));
        summary.row(cells(name.as_str().into(), trials.len().into(), &medians));
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
    let series = ["near", "all"].iter().enumerate().map(|(level, name)| Series {
        name: (*name).to_string(),
        line: Vec::new(),
        dots: found
            .iter()
            .enumerate()
            .flat_map(|(k, (_, trials))| trials.iter().map(move |t| (1.0 - t[4 + level], k as f64)))
            .collect(),
    });
    let plot = Plot {
        x: Axis { title: "share of the voxels of either that only one has", scale: Scale::Logarithmic },
        y: Axis { title: "", scale: Scale::Names(names) },
        series: series.collect(),
    };
    Ok(Findings { measurements, summary, notes, plot, numbers })
}

/// A row of the table.
fn cells(hand: Cell, seed: Cell, measured: &Measured) -> [Cell; 18] {
    let mut first = [hand, seed].into_iter();
    let mut others = measured.iter().map(|&number| Cell::from(number));
    std::array::from_fn(|_| first.next().or_else(|| others.next()).unwrap_or(Cell::from(f64::NAN)))
}

fn measure_hand(
    own: &OwnBody,
    knowing: &OwnBody,
    hand: usize,
    chest: usize,
    seed: u64,
) -> Result<Measured, Failure> {
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
                    let pose = ChainSide::new(&knowing.creature, &path, &posture).frame(&knowing.schema);
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
    for joint in joints.iter().map(|&joint| &knowing.creature.joints()[joint]) {
        let mut q = joint.first_coordinate();
        for dof in &joint.dofs {
            let [low, high] = dof.range;
            if dof.kind != DofKind::Ball && high > low {
                let share = (posture[q] - low) / (high - low);
                posture[q] = low + (high - low) * (0.5 - 0.5 * (std::f64::consts::PI * share).cos());
            }
            q += dof.kind.coordinates();
        }
    }
    knowing.creature.couple(posture);
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
        let mut solver = InverseKinematics::new(&knowing.creature, &knowing.schema, [tip, target(middle)])
            .with_direction_lengths([0.0, 0.0]);
        reached += usize::from((0..STARTS).any(|_| {
            let found = solver.solve(&knowing.random_posture(&base, &joints, rng));
            let pose = ChainSide::new(&knowing.creature, &joints, &found.posture).frame(&knowing.schema);
            map.lattice().cell(&map.frame.inverse_point(&pose.point(&map.tip.point))) == cell
        }));
    }
    reached as f64 / BEYOND as f64
}
