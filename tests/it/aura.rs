//! The aura: geoms of the model that weigh and touch nothing, and alarms.

use std::fs;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use crate::common::{creature, max, repository, truth};
use bodyschema::creature::{Body, JointSelection, Posture};
use bodyschema::geometry::{Frame, Shape};
use bodyschema::kinematics::InverseKinematics;
use bodyschema::mujoco::Model;
use bodyschema::senses::{Aura, Toucher};
use bodyschema::simulation::{AgentHandle, ProbePath, Stage, StageOptions, Substance, Thing};
use bodyschema::skin::{AURA_REACH, GrowOptions, ProximityGeometry, aura_of, grow_skin, skin_of};
use nalgebra::{Isometry3, Point3, Vector3};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// Numbers are written to a micrometre.
const WRITTEN: f64 = 3e-6;

fn from_file(path: &Path) -> Body {
    Body::new(Arc::new(Model::from_path(path).unwrap()), &JointSelection::All).unwrap()
}

fn auras(body: &Body) -> (Vec<ProximityGeometry>, Vec<Frame>) {
    let frames = body.limb_frames(&body.reference_data().unwrap());
    (aura_of(body, &skin_of(body), &frames), frames)
}

#[test]
fn max_has_17_auras_of_his_model_which_hold_his_limbs() {
    let body = max("all");
    let (found, frames) = auras(&body);
    let skin = skin_of(&body);
    let mut names: Vec<&str> = found.iter().map(|geometry| geometry.name.as_str()).collect();
    let mut expected: Vec<&str> = body.creature.aura_limbs().iter().map(|aura| aura.name.as_str()).collect();
    names.sort_unstable();
    expected.sort_unstable();
    assert_eq!((names.len(), names), (17, expected));
    for geometry in &found {
        assert!(geometry.of_model, "{}", geometry.name);
        let reach = geometry.reach(&body.creature, &skin, &frames).unwrap();
        assert!((reach - AURA_REACH).abs() < WRITTEN, "{}: {reach}", geometry.name);
    }
    // With the legs held there are fewer limbs, and as many geometries.
    assert_eq!(auras(&max("torso")).0.len(), 17);
}

#[test]
fn auras_in_a_file_weigh_nothing_and_are_no_surface() {
    let folder = tempfile::tempdir().unwrap();
    let mut models: Vec<PathBuf> = vec![repository("mjcf/max/body.xml")];
    models.extend(
        ["hexapod", "contraption", "octopus"].map(|name| repository(&format!("mjcf/{name}/{name}.xml"))),
    );
    models.extend(fs::read_dir(repository("mjcf/bodies")).unwrap().filter_map(|entry| {
        let path = entry.unwrap().path();
        path.extension().is_some_and(|ending| ending == "xml").then_some(path)
    }));
    assert!(models.len() > 20);
    for path in models {
        let name = path.display();
        let grown = match grow_skin(&path, &GrowOptions::default()) {
            Ok(grown) => grown,
            // Flat meshes alone: no skin grows on them.
            Err(error) if error.to_string().contains("flat meshes") => continue,
            Err(error) => panic!("{error}"),
        };
        let file = folder.path().join("grown.xml");
        fs::write(&file, grown.text(Some(folder.path()))).unwrap();
        let (bare, with) = (from_file(&path), from_file(&file));
        assert!(grown.auras > 0 && with.model.ngeom() == bare.model.ngeom() + grown.auras, "{name}");
        for (a, b) in bare.declared.bodies().zip(with.declared.bodies()) {
            let inert =
                |body: &bodyschema::mujoco::ModelBody| (body.mass, body.ipos, body.iquat, body.inertia);
            assert_eq!(inert(&a), inert(&b), "{name}: {:?}", b.name);
        }
        let shapes = |body: &Body| -> Vec<_> {
            skin_of(body).surfaces.into_iter().map(|surface| (surface.limb, surface.shape)).collect()
        };
        assert_eq!(shapes(&bare), shapes(&with), "{name}");
        // What was grown is there for good: nothing is added to it.
        let again = grow_skin(&file, &GrowOptions::default()).unwrap();
        assert_eq!((again.receptors, again.auras), (0, 0), "{name}");
    }
}

/// A trunk with an arm, of which `filter` says what collides; the arm has an aura.
fn armed(filter: &str, aura: &str) -> Body {
    creature(&format!(
        "<mujoco><worldbody><body name='trunk'><geom size='0.1' {filter}/>\
         <body name='arm' pos='0.2 0 0'><joint axis='0 0 1' range='-60 60'/>\
         <geom type='capsule' fromto='0 0 0 0.3 0 0' size='0.03' {filter}/>{aura}</body></body></worldbody></mujoco>"
    ))
}

#[test]
fn an_aura_is_never_a_surface_even_of_a_body_that_collides_with_nothing() {
    let aura = "<geom name='aura/arm' type='capsule' fromto='0 0 0 0.3 0 0' size='0.2' contype='0' conaffinity='0' mass='0'/>";
    for filter in ["", "contype='0' conaffinity='0'"] {
        let (with, without) = (armed(filter, aura), armed(filter, ""));
        assert_eq!(skin_of(&with), skin_of(&without), "{filter}");
        assert_eq!(skin_of(&with).surfaces.len(), 2);
    }
    // What collides is none, whatever its name.
    let solid = armed("", "<geom name='aura/arm' type='sphere' size='0.2'/>");
    assert_eq!(skin_of(&solid).surfaces.len(), 3);
    assert!(auras(&solid).0.iter().all(|geometry| !geometry.of_model));
}

#[test]
fn an_aura_is_as_large_as_its_author_has_it_and_what_has_none_is_grown() {
    let aura = "<geom name='aura/arm' type='sphere' pos='0.1 0 0' size='0.5' contype='0' conaffinity='0'/>";
    let body = armed("", aura);
    let (found, _) = auras(&body);
    let of = |name: &str| found.iter().find(|geometry| geometry.name == name).unwrap();
    assert_eq!((found.len(), of("trunk").of_model, of("arm").of_model), (2, false, true));
    assert_eq!((of("arm").capsule.radius, of("arm").capsule.ends), (0.5, [Vector3::new(0.1, 0.0, 0.0); 2]));
    assert!((of("trunk").capsule.radius - 0.1 - AURA_REACH).abs() < 1e-9);
}

/// The limbs that contacts are foreseen with.
fn limbs_in_danger(aura: &mut Aura) -> Vec<usize> {
    aura.approaches().filter_map(|approach| Some(approach.contact.as_ref()?.limb)).collect()
}

/// Max with his left hand at a ball that it holds, and with a ball that goes by itself.
fn holding() -> (Stage, AgentHandle, usize) {
    let ball = |name: &str| Thing {
        name: name.into(),
        shape: Shape::Sphere { radius: 0.03 },
        pose: Isometry3::translation(3.0, if name == "ball" { 0.0 } else { 1.0 }, 1.0),
        fixed: false,
        substance: Substance::default(),
    };
    let options = StageOptions {
        joints: "torso".parse().unwrap(),
        things: vec![ball("ball"), ball("other")],
        ..StageOptions::default()
    };
    let stage = Stage::new(&repository("mjcf/max/max.xml"), &options).unwrap();
    let handle = stage.handle();
    let thing = stage.thing("ball").unwrap();
    (stage, handle, thing)
}

#[test]
fn what_a_hand_holds_alarms_neither_it_nor_what_moves_with_it_but_what_it_is_brought_to() {
    let (stage, mut handle, thing) = holding();
    let creature = handle.agent().creature().clone();
    let hand = creature.limb("left_hand").unwrap();
    let receptor = handle.agent().skin().receptors.iter().position(|r| r.limb == hand).unwrap();
    let found = handle.agent().skin().receptors[receptor].clone();
    let at = (stage.limb_pose(hand) * Point3::from(found.place(0.03 - 5e-4).point)).coords;
    let time = stage.time();
    stage.send_thing(thing, ProbePath(vec![(time, at)]));
    let start = handle.posture();
    let felt = handle.step(&start).unwrap();
    assert!(felt.iter().any(|contact| contact.by == Toucher::Thing(thing)));
    assert!(handle.hold(receptor));
    handle.sense(Aura::watch_out);
    // The arm is raised and lowered to all sides.
    let coordinate = |name: &str| creature.dofs().position(|dof| dof.name == name).unwrap();
    let [abduction, flexion, elbow] =
        ["left_shoulder_abduction", "left_shoulder_flexion", "left_elbow_flexion"].map(coordinate);
    let go = |to: &[f64], handle: &mut AgentHandle| {
        let mut threatened = Vec::new();
        let before = handle.posture();
        for k in 1..=300 {
            let posture = Posture::between(&creature, &before, to, f64::from(k) / 300.0);
            handle.step(&posture).unwrap();
            threatened.extend(handle.sense(limbs_in_danger));
        }
        threatened
    };
    let swing = |moves: [(usize, f64); 2], handle: &mut AgentHandle| {
        let mut to = handle.posture();
        moves.into_iter().for_each(|(q, by)| to[q] += by);
        go(&to, handle)
    };
    let mut threatened: Vec<usize> = swing([(abduction, 0.8), (elbow, 0.5)], &mut handle);
    threatened.extend(swing([(abduction, -0.3), (flexion, 0.4)], &mut handle));
    let forearm = creature.limb("left_forearm").unwrap();
    let own = |limb: &usize| [hand, forearm].contains(limb);
    assert!(!threatened.iter().any(own), "{threatened:?}");
    // To the breast.
    let chest = creature.limb("thoracic3").unwrap();
    let breast =
        handle.agent().skin().receptors.iter().find(|r| r.limb == chest && r.normal.x > 0.8).unwrap();
    let places = [found.place(0.06), breast.place(0.0).reversed()];
    let now = handle.posture();
    let schema = truth(&max("torso"));
    let reach = InverseKinematics::new(&creature, &schema, places).at_ease(&now).solve(&now);
    assert!(reach.reached());
    let threatened = go(&reach.posture, &mut handle);
    assert!(threatened.iter().any(|limb| !own(limb)), "{threatened:?}");
    assert!(!threatened.iter().any(own), "{threatened:?}");
}

#[test]
fn which_limb_a_ball_is_going_to_touch_is_foreseen() {
    let options = StageOptions { probes: vec!["probe".into()], ..StageOptions::default() };
    let stage = Stage::new(&repository("mjcf/max/max.xml"), &options).unwrap();
    let mut rng = ChaCha8Rng::seed_from_u64(7);
    let (mut hits, mut foreseen) = (0, 0);
    for _ in 0..20 {
        // Straight to a random place of the skin, from outside and 0.9 m away.
        let receptors = &stage.skin().receptors;
        let receptor = &receptors[rng.random_range(0..receptors.len())];
        let pose = stage.limb_pose(receptor.limb);
        let target = (pose * Point3::from(receptor.position)).coords;
        let from = pose.rotation * receptor.normal;
        let (time, seconds) = (stage.time(), 0.95 / rng.random_range(0.3..0.9));
        let ends = [0.9, -0.05].map(|along: f64| target + from * along);
        stage.send_probe(0, ProbePath(vec![(time, ends[0]), (time + seconds, ends[1])])).unwrap();
        // Nothing was near before.
        stage.sense(Aura::watch_out);
        let mut told: Vec<(f64, Option<usize>)> = Vec::new();
        let mut hit = None;
        while hit.is_none() && stage.time() < time + seconds {
            let step = stage.step().unwrap();
            told.push((step.time, stage.sense(limbs_in_danger).first().copied()));
            hit = step.contacts.first().map(|contact| (step.time, contact.spot.limb));
        }
        stage.send_probe(0, ProbePath::default()).unwrap();
        let Some((when, limb)) = hit else { continue };
        hits += 1;
        // As it was foreseen 0.3 s before.
        let ahead = told.partition_point(|(time, _)| *time <= when - 0.3);
        foreseen += usize::from(ahead > 0 && told[ahead - 1].1 == Some(limb));
    }
    assert!(hits >= 18 && foreseen + 1 >= hits, "{foreseen} of {hits}");
}
