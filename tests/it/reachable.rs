//! The space that a hand can get to: the map against postures drawn at random, its levels, its queries, and the command.

use std::fs;

use crate::common::program::run;
use crate::common::{creature, max, truth, two_arms};
use bodyschema::agent::Agent;
use bodyschema::creature::{Body, Posture};
use bodyschema::kinematics::REACHED;
use bodyschema::kinematics::Workspace;
use bodyschema::learning::Certainty;
use bodyschema::peripersonal::{Level, OwnBody, Reach, ReachableMap};
use nalgebra::Vector3;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use serde_json::Value;

/// How far this chain's kinematics and those of the whole body may differ, metres.
const ROUNDING: f64 = 1e-12;
/// The same for postures as a map keeps them.
const KEPT: f64 = 1e-6;

/// A creature that knows its body.
fn knowing(body: &Body) -> OwnBody {
    OwnBody::new(&Agent::of(body).unwrap(), truth(body), Certainty::Exact, &[])
}

fn arms() -> Body {
    creature(&two_arms(r#"type="capsule" size="0.12 0.2""#, r#"type="capsule" size="0.03 0.2""#))
}

/// Slides, a ball and a joint that follows another, on the way to one limb.
const MIXED: &str = r#"<mujoco model="mixed">
  <compiler angle="radian" autolimits="true"/>
  <worldbody>
    <body name="base">
      <geom type="sphere" size="0.05"/>
      <body name="sled" pos="0.1 0.05 0" euler="0.2 0.1 0">
        <joint name="slide" type="slide" axis="0 1 0.2" range="-0.1 0.2"/>
        <geom type="sphere" size="0.03"/>
        <body name="shoulder" pos="0 0 0.1">
          <joint name="ball" type="ball" range="0 1.2"/>
          <geom type="capsule" fromto="0 0 0 0.2 0 0" size="0.02"/>
          <body name="fore" pos="0.2 0 0" euler="0 0.3 0.1">
            <joint name="elbow" axis="0 0 1" range="-0.5 1.5"/>
            <geom type="capsule" fromto="0 0 0 0.2 0 0" size="0.02"/>
            <body name="hand" pos="0.2 0 0">
              <joint name="wrist" axis="0 1 0" range="-0.5 1.5"/>
              <geom type="capsule" fromto="0 0 0 0.1 0 0" size="0.02"/>
              <site name="tip" type="box" size="0.01 0.01 0.001" pos="0.1 0 0.02"/>
            </body>
          </body>
        </body>
      </body>
    </body>
  </worldbody>
  <equality><joint joint1="wrist" joint2="elbow" polycoef="0 0.8 0 0 0"/></equality>
  <sensor><touch site="tip"/></sensor>
</mujoco>"#;

/// Max's left hand, or his right one, and the chest.
fn max_map(hand: &str, voxel: f64) -> (OwnBody, ReachableMap) {
    let own = knowing(&max("torso"));
    let hands = ["left_hand", "right_hand"].map(|name| own.creature().limb(name).unwrap());
    let chest = own.carrier_of(&hands);
    let map = ReachableMap::new(&own, own.creature().limb(hand).unwrap(), chest, voxel).unwrap();
    (own, map)
}

/// How well two maps of the same voxels agree, of what is near and of all that is reached: the share of the voxels of either
/// that both have.
fn overlap(one: &ReachableMap, other: &ReachableMap) -> [f64; 2] {
    let share = |reached: fn(Level) -> bool| {
        let of = |map: &ReachableMap| map.voxels().filter(|(_, level)| reached(*level)).count();
        let ours = one.voxels().filter(|(_, level)| reached(*level));
        let both = ours.filter(|(cell, _)| reached(other.level_of(*cell))).count();
        both as f64 / (of(one) + of(other) - both) as f64
    };
    [share(|level| level == Level::Near), share(|level| level != Level::OutOfReach)]
}

/// Where the tip of a map's hand is, in the map's frame.
fn tip(own: &OwnBody, map: &ReachableMap, posture: &[f64]) -> Vector3<f64> {
    map.frame.inverse_point(&own.frames(posture)[map.hand].point(&map.tip.point))
}

#[test]
fn a_folded_chain_puts_the_tip_where_the_whole_body_has_it() {
    let mut rng = ChaCha8Rng::seed_from_u64(1);
    for (body, limb) in [(arms(), "left_fore"), (max("torso"), "right_hand"), (creature(MIXED), "hand")] {
        let own = knowing(&body);
        let limb = own.creature().limb(limb).unwrap();
        let place = own.tip_of(limb).unwrap();
        let frame = own.frames(&own.at_ease())[1];
        let joints = own.joints_to(limb);
        // All joints, and all but the first: what follows one that is held is held as well.
        for first in [0, 1] {
            let base = Posture::random(own.creature(), &mut rng);
            let chain = own.chain_to(&place, &frame, &base, |joint| joint >= joints[first]);
            let mut workspace = Workspace::default();
            for _ in 0..50 {
                let mut posture = base.clone();
                let drawn = chain.of_posture(&Posture::random(own.creature(), &mut rng));
                chain.put_into(drawn.clone(), &mut posture);
                let expected = frame.inverse_point(&own.frames(&posture)[limb].point(&place.point));
                let found = chain.point(&drawn, &mut workspace);
                assert!((found - expected).norm() < ROUNDING, "{found} {expected}");
                // And it gets back there from another posture.
                let mut coordinates = chain.of_posture(&base);
                if chain.seek(&mut coordinates, &found, 1e-3, 100, &mut workspace) == 0.0 {
                    chain.put_into(coordinates, &mut posture);
                    own.creature().couple(&mut posture);
                    let arrived = frame.inverse_point(&own.frames(&posture)[limb].point(&place.point));
                    assert!((arrived - found).amax() <= 1e-3 + ROUNDING);
                }
            }
        }
    }
}

#[test]
fn random_postures_are_on_the_map_and_every_voxel_has_a_posture_in_it() {
    for (body, limb, voxel) in
        [(arms(), "left_fore", 0.04), (max("torso"), "left_hand", 0.06), (creature(MIXED), "hand", 0.02)]
    {
        let own = knowing(&body);
        let limb = own.creature().limb(limb).unwrap();
        let map = ReachableMap::new(&own, limb, own.carrier_of(&[limb]), voxel).unwrap();
        let mut rng = ChaCha8Rng::seed_from_u64(2);
        let (drawn, mut missed) = (20_000, 0);
        for _ in 0..drawn {
            let point = tip(&own, &map, &Posture::random(own.creature(), &mut rng));
            missed += usize::from(map.level(&point) == Level::OutOfReach);
        }
        assert!(1000 * missed <= drawn, "{missed} of {drawn} are missing");
        let trunk = own.joints_to(map.chest);
        let at_ease = own.at_ease();
        for (cell, level) in map.voxels().step_by(7) {
            let middle = map.lattice().middle(cell);
            let posture = map.whereabouts(&middle).posture;
            assert!((tip(&own, &map, &posture) - middle).amax() <= map.lattice().half() + KEPT);
            for dof in own.creature().elements() {
                let q = dof.coordinate();
                let within = dof.range[0] - KEPT..=dof.range[1] + KEPT;
                assert!(
                    dof.kind.coordinates() > 1 || within.contains(&posture[q]),
                    "{} {}",
                    dof.name,
                    posture[q]
                );
            }
            for joint in trunk.iter().map(|&joint| &own.creature().joints()[joint]) {
                let q = joint.coordinates().start;
                assert!(level == Level::Far || posture[q] == at_ease[q], "{} leans", joint.name);
            }
        }
    }
}

#[test]
fn levels_distances_and_postures_agree() {
    let (own, map) = max_map("left_hand", 0.06);
    let [near, far] = map.volumes();
    assert!(near > 0.5 && far > 0.5, "{near} m³ near, {far} m³ far");
    assert_eq!(own.creature().limbs()[map.chest], "thoracic3");
    let ahead = Vector3::new(0.4, 0.1, 0.0);
    let found = map.whereabouts(&ahead);
    assert_eq!((found.level, found.miss), (Level::Near, 0.0));
    let reach = map.reach(&ahead);
    assert!(
        reach.miss <= REACHED && (tip(&own, &map, &reach.posture) - ahead).norm() <= REACHED,
        "{reach:?}"
    );
    // Straight on all that is left to reach comes to an end, and then it gets ever farther.
    let mut levels = Vec::new();
    for step in 0..40 {
        let point = Vector3::new(0.051 * f64::from(step), 0.1, 0.0);
        let Reach { level, miss: beyond, .. } = map.whereabouts(&point);
        assert_eq!(level == Level::OutOfReach, beyond > 0.0, "{level:?} by {beyond}");
        // No voxel is nearer than the nearest.
        let nearest =
            map.voxels().map(|(cell, _)| map.lattice().distance(cell, &point)).fold(f64::INFINITY, f64::min);
        assert!((beyond - nearest).abs() < ROUNDING, "{beyond} {nearest}");
        levels.push(level);
    }
    levels.dedup();
    assert_eq!(levels.last(), Some(&Level::OutOfReach));
    assert!(levels.contains(&Level::Far), "{levels:?}");
    // What touches the skin is at no distance from it.
    let hand = own.creature().limb("right_hand").unwrap();
    let (frames, place) = (own.frames(&own.at_ease()), own.tip_of(hand).unwrap());
    let distances = own.distances(&frames, &frames[hand].point(&place.point));
    assert!(distances[hand].unwrap().abs() < 1e-9);
    assert!(distances.iter().enumerate().all(|(limb, d)| limb == hand || d.is_none_or(|d| d > -1e-3)));
}

#[test]
fn a_point_is_sought_as_exactly_on_a_coarse_map_as_on_a_fine_one() {
    let (own, coarse) = max_map("left_hand", 0.12);
    let (_, fine) = max_map("left_hand", 0.04);
    let mut rng = ChaCha8Rng::seed_from_u64(5);
    let at_ease = own.at_ease();
    let mut counts = [0; 3];
    for _ in 0..300 {
        let point = Vector3::from_fn(|_, _| rng.random_range(-1.3..1.3));
        let found = coarse.reach(&point);
        counts[usize::from(found.level.number())] += 1;
        let miss = (tip(&own, &coarse, &found.posture) - point).norm();
        assert!((miss - found.miss).abs() < KEPT, "{miss} {}", found.miss);
        // No posture is off by more than the fine map says, and none that reaches leans without need.
        assert_eq!(found.level == Level::OutOfReach, found.miss > 2e-4, "{found:?}");
        let border = fine.lattice().voxel;
        let deeply = |level: Level| {
            let steps = [-border, 0.0, border];
            let around = steps.iter().flat_map(|x| steps.iter().map(move |y| (*x, *y)));
            { around }
                .all(|(x, y)| steps.iter().all(|z| fine.level(&(point + Vector3::new(x, y, *z))) == level))
        };
        for level in [Level::Near, Level::Far, Level::OutOfReach].into_iter().filter(|level| deeply(*level)) {
            assert_eq!(found.level, level, "{point}");
        }
        if found.level == Level::Near {
            for joint in own.joints_to(fine.chest) {
                let coordinates = own.creature().joints()[joint].coordinates();
                assert_eq!(found.posture[coordinates.clone()], at_ease[coordinates]);
            }
        }
    }
    assert!(counts.iter().all(|count| *count > 20), "{counts:?}");
}

#[test]
fn the_map_is_the_same_for_any_number_of_threads_and_nearly_the_same_for_nearly_the_same_body() {
    let own = knowing(&max("torso"));
    let hand = own.creature().limb("left_hand").unwrap();
    let chest = own.carrier_of(&[hand]);
    let build = |own: &OwnBody, threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| ReachableMap::new(own, hand, chest, 0.08).unwrap())
    };
    let maps = [1, 3].map(|threads| build(&own, threads));
    let all = maps.each_ref().map(|map| map.voxels().collect::<Vec<_>>());
    assert_eq!(all[0], all[1]);
    for (cell, _) in all[0].iter().step_by(11) {
        let middle = maps[0].lattice().middle(*cell);
        assert_eq!(maps[0].whereabouts(&middle), maps[1].whereabouts(&middle));
    }
    let mut learned = own.schema.clone();
    learned.positions.iter_mut().for_each(|position| position.x += 1e-5);
    let [near, reached] = overlap(&build(&own.with_schema(learned), 2), &maps[0]);
    assert!(near > 0.97 && reached > 0.97, "{near} {reached}");
}

#[test]
fn what_cannot_be_mapped_is_told() {
    let own = knowing(&arms());
    let upper = own.creature().limb("left_upper").unwrap();
    let found = ReachableMap::new(&own, upper, 0, 0.02).unwrap_err();
    assert!(found.is_usage() && found.to_string().starts_with("left_upper has no receptors"), "{found}");
    let fore = own.creature().limb("left_fore").unwrap();
    for voxel in [0.0, -1.0, f64::NAN, f64::INFINITY, 1e-9] {
        let found = ReachableMap::new(&own, fore, 0, voxel).unwrap_err();
        assert!(found.is_usage() && found.to_string().starts_with("voxels of"), "{voxel}: {found}");
    }
    // Voxels larger than the body are no mistake.
    assert_eq!(ReachableMap::new(&own, fore, 0, 50.0).unwrap().voxels().count(), 1);
}

#[test]
fn the_command_tells_the_space_and_writes_its_files() {
    let place = tempfile::tempdir().unwrap();
    let body = two_arms(r#"type="capsule" size="0.12 0.2""#, r#"type="capsule" size="0.03 0.2""#);
    fs::write(place.path().join("arms.xml"), body.replace("_fore", "_hand")).unwrap();
    let babbled = run(place.path(), &["babble", "arms.xml", "--touches", "100", "--out", "arms"]);
    assert!(babbled.status.success(), "{}", String::from_utf8_lossy(&babbled.stderr));
    let asked = ["reach", "arms", "--voxel", "0.05", "--vtk", "reach.vtk"];
    let output = run(place.path(), &[&asked[..], &["--at", "-0.2,0.3,0.4", "--json"]].concat());
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let found: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(found["chest"], "trunk");
    assert_eq!(found["hands"].as_array().unwrap().len(), 2);
    assert!(found["hands"][0]["near_l"].as_f64().unwrap() > 0.0);
    assert_eq!(found["at"]["hands"][0]["posture"].as_object().unwrap().len(), 8);
    assert!(found["at"]["limbs"].as_array().unwrap().iter().any(|limb| limb["limb"] == "trunk"));
    let vtk = fs::read(place.path().join("reach.vtk")).unwrap();
    let head = String::from_utf8_lossy(&vtk[..400]).to_string();
    let dimensions = head.lines().find_map(|line| line.strip_prefix("DIMENSIONS ")).unwrap();
    let count: usize = dimensions.split(' ').map(|number| number.parse::<usize>().unwrap()).product();
    assert!(head.contains(&format!("POINT_DATA {count}\nSCALARS left_hand unsigned_char 1")), "{head}");
    assert!(vtk.len() > 2 * count && vtk.len() < 2 * count + 500);
    assert!(run(place.path(), &["report", "arms"]).status.success());
    let page = fs::read_to_string(place.path().join("arms/report.html")).unwrap();
    let slices = page.split_once("id=\"reachable\"").unwrap().1.split_once("</svg>").unwrap().0;
    assert!(slices.contains("from above") && !slices.contains("NaN"));
    // A point by itself takes no map, and changes nothing.
    let kept = fs::read(place.path().join("arms/space.json")).unwrap();
    let output = run(place.path(), &["reach", "arms", "--at", "-0.2,0.3,0.4"]);
    let said = String::from_utf8(output.stdout).unwrap();
    assert!(said.contains("left_hand: ") && !said.contains("voxels") && !said.contains("guess"), "{said}");
    assert_eq!(fs::read(place.path().join("arms/space.json")).unwrap(), kept);
    // What is learned of nothing is a guess, and said to be one.
    let output = run(place.path(), &["learn", "arms", "--learner", "hersch", "--out", "guessed"]);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    for asked in [vec!["reach", "guessed", "--voxel", "0.1"], vec!["reach", "guessed", "--at", "0.1,0.2,0.3"]]
    {
        let said = String::from_utf8(run(place.path(), &asked).stdout).unwrap();
        assert!(said.contains("left_hand: its workspace is a guess, because it is not located"), "{said}");
    }
    assert!(run(place.path(), &["report", "guessed"]).status.success());
    let page = fs::read_to_string(place.path().join("guessed/report.html")).unwrap();
    assert!(page.contains("its workspace is a guess"));
    for (arguments, code, says) in [
        (vec!["reach", "arms", "--hand", "foot"], 1, "no such limb"),
        (vec!["reach", "arms", "--voxel", "0"], 1, "are impossible"),
        (vec!["reach", "arms", "--at", "1,2"], 2, "three numbers"),
        (vec!["reach", "nowhere"], 1, "nowhere"),
        (vec!["reach", "arms", "--voxel", "0.1", "--vtk", "no/such/reach.vtk"], 1, "cannot write"),
    ] {
        let output = run(place.path(), &arguments);
        let message = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(code), "{arguments:?}: {message}");
        assert!(message.contains(says) && !message.contains("panicked"), "{arguments:?}: {message}");
    }
}
