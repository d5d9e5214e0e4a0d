//! The somatotopic map: which receptors are neighbours along the skin, on Max and on other creatures.

use std::collections::BTreeSet;
use std::fs;
use std::sync::Arc;

use crate::common::{max, repository};
use bodyschema::creature::{Body, JointSelection};
use bodyschema::mujoco::Model;
use bodyschema::skin::{GrowOptions, MOST_NEIGHBOURS, Skin, SomatotopicMap, grow, skin_of};

/// Neighbours of a receptor of Max on average, at the least.
const MEAN_NEIGHBOURS: f64 = 6.0;

/// Mean number of neighbours, the receptors without any, and the share of receptors that have one on another limb.
fn counted(map: &SomatotopicMap, skin: &Skin) -> (f64, Vec<String>, f64) {
    let count = skin.receptors.len();
    let limb = |r: usize| skin.receptors[r].limb;
    let links: usize = (0..count).map(|r| map.neighbours(r).len()).sum();
    let alone = (0..count).filter(|&r| map.neighbours(r).is_empty());
    let alone = alone.map(|r| skin.receptors[r].id.clone()).collect();
    let across = (0..count).filter(|&r| map.neighbours(r).iter().any(|&n| limb(n) != limb(r))).count();
    (links as f64 / count as f64, alone, across as f64 / count as f64)
}

/// The pairs of limbs that are linked, by name, the lesser first.
fn linked_limbs(map: &SomatotopicMap, body: &Body, skin: &Skin) -> BTreeSet<[String; 2]> {
    let limbs = |pair: [usize; 2]| {
        let mut names = pair.map(|r| body.creature.limbs()[skin.receptors[r].limb].clone());
        names.sort();
        names
    };
    map.pairs().map(limbs).filter(|[a, b]| a != b).collect()
}

#[test]
fn the_map_is_mutual_and_no_receptor_of_max_is_without_neighbours() {
    for joints in ["all", "torso"] {
        let body = max(joints);
        let skin = skin_of(&body);
        let map = SomatotopicMap::at_ease(&body, &skin).unwrap();
        for (r, receptor) in skin.receptors.iter().enumerate() {
            let neighbours = map.neighbours(r);
            let distinct: BTreeSet<usize> = neighbours.iter().copied().collect();
            assert_eq!(distinct.len(), neighbours.len(), "{}", receptor.id);
            assert!(neighbours.len() <= MOST_NEIGHBOURS, "{}", receptor.id);
            assert!(neighbours.iter().all(|&n| n != r && map.neighbours(n).contains(&r)), "{}", receptor.id);
        }
        let (mean, alone, across) = counted(&map, &skin);
        assert!(mean >= MEAN_NEIGHBOURS && alone.is_empty(), "{joints}: {mean} on average, alone: {alone:?}");
        assert!(across > 0.2, "{joints}: only {across} of the receptors have one on another limb");
    }
}

#[test]
fn neighbours_go_across_joints_and_never_through_air_or_limbs() {
    let body = max("all");
    let skin = skin_of(&body);
    let map = SomatotopicMap::at_ease(&body, &skin).unwrap();
    let linked = linked_limbs(&map, &body, &skin);
    for side in ["left", "right"] {
        for pair in [["upper_arm", "forearm"], ["forearm", "hand"], ["thigh", "shank"], ["shank", "foot"]] {
            let mut names = pair.map(|limb| format!("{side}_{limb}"));
            names.sort();
            assert!(linked.contains(&names), "{names:?} are not linked");
        }
    }
    // Only what a joint carries meets what carries it, over limbs without skin where there are any.
    let has_skin = |limb: usize| skin.receptors.iter().any(|receptor| receptor.limb == limb);
    let carrier = |limb: usize| {
        let above = |&limb: &usize| body.creature.parent_of(limb);
        std::iter::successors(above(&limb), above).find(|&limb| has_skin(limb))
    };
    for [a, b] in map.pairs() {
        let [one, other] = [a, b].map(|r| &skin.receptors[r]);
        let joined = one.limb == other.limb
            || carrier(one.limb) == Some(other.limb)
            || carrier(other.limb) == Some(one.limb);
        assert!(joined, "{} and {} are of limbs that no joint connects", one.id, other.id);
    }
    // A link goes round a limb, not through it: back to back are only the patches that meet along a rim, and those are no
    // wider than half of what they lie on.
    let mut round_rims = 0;
    for [a, b] in map.pairs() {
        let [one, other] = [a, b].map(|r| &skin.receptors[r]);
        if one.limb == other.limb && one.normal.dot(&other.normal) < -0.7 {
            let thick = (one.position - other.position).dot(&one.normal).abs();
            let long = one.half_extents.iter().chain(&other.half_extents).copied().fold(0.0, f64::max);
            assert!(thick < 2.0 * long, "{} and {} are back to back, {thick} m apart", one.id, other.id);
            round_rims += 1;
        }
    }
    assert!(round_rims > 0, "the halves of a finger meet along its rim");
    for limb in ["pelvis", "thoracic1"] {
        let on = |r: usize| body.creature.limbs()[skin.receptors[r].limb] == limb;
        let opposite = |pair: &[usize; 2]| {
            let [one, other] = pair.map(|r| &skin.receptors[r]);
            pair.iter().all(|&r| on(r)) && one.normal.dot(&other.normal) < -0.8
        };
        assert_eq!(map.pairs().filter(opposite).count(), 0, "front and back of the {limb}");
    }
}

#[test]
fn what_touches_nothing_is_no_part_of_the_skin() {
    let text = fs::read_to_string(repository("mjcf/max/max.xml")).unwrap();
    let lines = text.lines().filter(|line| !line.contains("<geom class=\"aura\""));
    let bare = lines.collect::<Vec<_>>().join("\n");
    assert!(bare.len() < text.len(), "Max's model has auras");
    let place = tempfile::tempdir().unwrap();
    let path = place.path().join("max.xml");
    fs::write(&path, bare).unwrap();
    let [with, without] = [repository("mjcf/max/max.xml"), path].map(|path| {
        let body = Body::new(Arc::new(Model::from_path(&path).unwrap()), &JointSelection::All).unwrap();
        let skin = skin_of(&body);
        let map = SomatotopicMap::at_ease(&body, &skin).unwrap();
        (skin.surfaces.len(), map)
    });
    assert_eq!(with.0, without.0, "an aura is taken for a surface of a limb");
    assert!(with.1 == without.1, "auras change which receptors are neighbours, or where limbs meet");
}

#[test]
fn other_creatures_have_one_skin_too() {
    for (name, most_alone) in [("hexapod", 0), ("snake", 0), ("octopus", 0), ("bodies/ant", 0)] {
        let file = name.rsplit('/').next().unwrap();
        let folder = name.strip_suffix(&format!("/{file}")).unwrap_or(name);
        let path = repository(&format!("mjcf/{folder}/{file}.xml"));
        let body = Body::new(Arc::new(Model::from_path(&path).unwrap()), &JointSelection::All).unwrap();
        let skin = grow(&body, &GrowOptions::default()).unwrap();
        let map = SomatotopicMap::at_ease(&body, &skin).unwrap();
        let (mean, alone, across) = counted(&map, &skin);
        assert!(
            mean > 5.5 && alone.len() <= most_alone && across > 0.2,
            "{name}: {mean}, {alone:?}, {across}"
        );
        // Over joints, all that has skin hangs together.
        let mut reached = BTreeSet::from([0]);
        let mut open = vec![0];
        while let Some(r) = open.pop() {
            open.extend(map.neighbours(r).iter().copied().filter(|&n| reached.insert(n)));
        }
        assert_eq!(reached.len(), skin.receptors.len(), "{name} is in parts");
    }
}
