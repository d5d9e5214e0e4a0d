//! Max: his joints, limbs and skin are what they were planned to be, and the generator makes them anew.

use std::collections::BTreeSet;

use crate::common::{max, repository, take};
use bodyschema::agent::Agent;
use bodyschema::babbling::{Babbler, BabblingOptions, BoutsDone, PolicyName};
use bodyschema::creature::DofKind;
use bodyschema::mujoco::{Data, JointKind, Model, ObjectKind, SensorKind};
use bodyschema::simulation::{MotionName, Movers};
use bodyschema::skin::{GrowOptions, Receptor, grow_skin, skin_of};

/// How far a receptor's centre may be from its surface: the digits that the file keeps, metres.
const ON_SURFACE: f64 = 1e-6;
/// Least cosine between a receptor's normal and its surface's.
const OUTWARD: f64 = 1.0 - 1e-6;
/// Agreement of unit vectors.
const UNIT: f64 = 1e-9;
/// Least share of stops of babbling at which skin met skin.
const TOUCH_SHARE: f64 = 0.95;

/// The 17 limbs that have an aura.
const AURA_LIMBS: [&str; 17] = [
    "pelvis",
    "abdomen",
    "chest",
    "neck",
    "head",
    "left_upper_arm",
    "left_forearm",
    "left_hand",
    "left_thigh",
    "left_shank",
    "left_foot",
    "right_upper_arm",
    "right_forearm",
    "right_hand",
    "right_thigh",
    "right_shank",
    "right_foot",
];

/// The receptors of one aura limb.
fn of_aura<'a>(agent: &'a Agent, name: &str) -> Vec<&'a Receptor> {
    let aura = agent.creature().aura_limbs().iter().find(|aura| aura.name == name).unwrap();
    agent.skin().receptors.iter().filter(|receptor| aura.limbs.contains(&receptor.limb)).collect()
}

/// The mean area of patches, m².
fn mean_area(receptors: &[&Receptor]) -> f64 {
    let area = |r: &&Receptor| 4.0 * r.half_extents[0] * r.half_extents[1];
    receptors.iter().map(area).sum::<f64>() / receptors.len() as f64
}

#[test]
fn max_has_57_joints_with_103_degrees_of_freedom_and_17_aura_limbs() {
    let creature = max("all").creature;
    assert_eq!((creature.joints().len(), creature.dof()), (57, 103));
    assert_eq!(creature.coordinates(), 103);
    assert!(creature.dofs().all(|dof| dof.kind == DofKind::Hinge && dof.range[0] < dof.range[1]));
    let found: BTreeSet<&str> = creature.aura_limbs().iter().map(|aura| aura.name.as_str()).collect();
    assert_eq!(found, BTreeSet::from(AURA_LIMBS));
    let names: BTreeSet<&String> = creature.limbs().iter().collect();
    assert_eq!(names.len(), creature.limbs().len(), "two limbs share a name");
}

#[test]
fn the_torso_has_16_joints_with_42_degrees_of_freedom_and_is_what_moves_by_default() {
    let torso = max("torso").creature;
    assert_eq!((torso.joints().len(), torso.dof()), (16, 42));
    assert_eq!(max("default").creature, torso);
    let auras: BTreeSet<&str> = torso.aura_limbs().iter().map(|aura| aura.name.as_str()).collect();
    assert!(auras.contains("left_hand") && auras.contains("right_hand"), "{auras:?}");
}

#[test]
fn every_degree_of_freedom_is_sensed_and_every_receptor_has_a_touch_sensor() {
    let body = max("all");
    let model = &body.model;
    let sensed = |kind: SensorKind, object: ObjectKind| -> Vec<usize> {
        let sensors = model.sensors().filter(|sensor| sensor.kind == kind && sensor.object == object);
        let mut ids: Vec<usize> = sensors.filter_map(|sensor| sensor.id).collect();
        ids.sort_unstable();
        ids
    };
    let joints = model.joints().enumerate();
    let moving: Vec<usize> = joints.filter(|(_, j)| j.kind != JointKind::Free).map(|(i, _)| i).collect();
    assert_eq!(sensed(SensorKind::JointPos, ObjectKind::Joint), moving);
    let skin = skin_of(&body);
    let mut sites: Vec<usize> =
        skin.receptors.iter().map(|r| model.id(ObjectKind::Site, &r.id).unwrap()).collect();
    sites.sort_unstable();
    assert_eq!(sensed(SensorKind::Touch, ObjectKind::Site), sites);
}

#[test]
fn the_skin_is_densest_on_hands_and_denser_on_arms_than_on_the_trunk() {
    let body = max("all");
    let agent = Agent::of(&body).unwrap();
    assert!(agent.skin().receptors.len() > 200, "{}", agent.skin().receptors.len());
    let trunk: Vec<&Receptor> =
        ["pelvis", "abdomen", "chest"].iter().flat_map(|name| of_aura(&agent, name)).collect();
    for side in ["left", "right"] {
        let hand = of_aura(&agent, &format!("{side}_hand"));
        assert!(hand.len() > 30, "{side}: {}", hand.len());
        for part in ["upper_arm", "forearm"] {
            let arm = of_aura(&agent, &format!("{side}_{part}"));
            let areas = [mean_area(&hand), mean_area(&arm), mean_area(&trunk)];
            assert!(areas.is_sorted(), "{side} {part}: {areas:?}");
        }
    }
    for name in AURA_LIMBS {
        assert!(!of_aura(&agent, name).is_empty(), "{name} is numb");
    }
}

#[test]
fn the_neutral_posture_is_free_of_contacts() {
    for joints in ["all", "torso"] {
        let body = max(joints);
        let mut data = Data::new(body.declared.clone()).unwrap();
        take(&body, &mut data, &body.creature.reference_posture());
        let touching: Vec<_> =
            data.contacts().map(|c| c.geoms.map(|g| body.model.geom(g).name.map(str::to_string))).collect();
        assert!(touching.is_empty(), "{touching:?}");
    }
}

#[test]
fn growing_a_skin_on_the_bare_body_gives_the_checked_in_file_byte_for_byte() {
    let grown = grow_skin(&repository("mjcf/max/body.xml"), &GrowOptions::default()).unwrap().text(None);
    let checked_in = std::fs::read_to_string(repository("mjcf/max/max.xml")).unwrap();
    let line = grown.lines().zip(checked_in.lines()).position(|(a, b)| a != b);
    assert!(
        grown == checked_in,
        "they differ from line {:?}: run `bodyschema skin mjcf/max/body.xml --out mjcf/max/max.xml`",
        line.map(|line| line + 1)
    );
}

#[test]
fn a_body_with_skin_stays_as_it_is() {
    let grown = grow_skin(&repository("mjcf/max/max.xml"), &GrowOptions::default()).unwrap();
    assert_eq!((grown.receptors, grown.kept), (0, skin_of(&max("all")).receptors.len()));
    let checked_in = std::fs::read_to_string(repository("mjcf/max/max.xml")).unwrap();
    assert!(grown.text(None) == checked_in);
}

#[test]
fn the_scene_loads_without_warnings_and_holds_the_same_max() {
    let scene = Model::from_path(repository("mjcf/max/scene.xml")).unwrap();
    let alone = max("all").model;
    assert_eq!(scene.warning(), None);
    assert_eq!(alone.warning(), None);
    assert_eq!((scene.nq(), scene.nsite(), scene.nsensor()), (alone.nq(), alone.nsite(), alone.nsensor()));
    assert_eq!(scene.ngeom(), alone.ngeom() + 1, "the floor is all that it adds");
}

#[test]
fn every_receptor_lies_on_its_surface_and_faces_outward() {
    for joints in ["all", "torso"] {
        let skin = skin_of(&max(joints));
        let mut ids = BTreeSet::new();
        for receptor in &skin.receptors {
            let id = &receptor.id;
            assert!(ids.insert(id), "{id} occurs twice");
            let surface = &skin.surfaces[receptor.surface.unwrap_or_else(|| panic!("{id} has no surface"))];
            assert_eq!(surface.limb, receptor.limb, "{id}");
            let (distance, outward) = surface.signed_distance(&receptor.position).unwrap();
            assert!(distance.abs() < ON_SURFACE, "{id}: {distance} m off its surface");
            assert!(outward.dot(&receptor.normal) > OUTWARD, "{id}: {}", outward.dot(&receptor.normal));
            assert!((receptor.normal.norm() - 1.0).abs() < UNIT, "{id}");
            assert!((receptor.tangent.norm() - 1.0).abs() < UNIT, "{id}");
            assert!(receptor.normal.dot(&receptor.tangent).abs() < UNIT, "{id}");
            assert!(receptor.half_extents.iter().all(|&half| half > 0.0 && half < 0.2), "{id}");
            assert!(receptor.holds(&receptor.position), "{id} does not hold its own centre");
        }
    }
}

#[test]
fn at_nearly_every_stop_of_babbling_skin_meets_skin() {
    for joints in ["torso", "all"] {
        let body = max(joints);
        let agent = Agent::of(&body).unwrap();
        let babbler = Babbler::new(Movers::new(&body, &agent, MotionName::Kinematic).unwrap());
        let options = BabblingOptions { touches: 500, seed: 5, jobs: 2 };
        let from = BoutsDone::default();
        let (effort, _) = babbler.babble(PolicyName::Random, from, &options, |_| Ok(())).unwrap();
        let share = options.touches as f64 / (options.touches as f64 + effort.bare as f64);
        assert!(share >= TOUCH_SHARE, "{joints}: {share}");
    }
}
