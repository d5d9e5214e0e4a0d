//! The aura: geoms of the model that weigh and touch nothing, the one that is acted on by the schema, and alarms.

use std::fs;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use crate::common::{babble, creature, max, own_body, repository, truth};
use bodyschema::agent::Agent;
use bodyschema::creature::{Body, JointSelection, Posture};
use bodyschema::geometry::{Ball, Frame, Shape};
use bodyschema::kinematics::InverseKinematics;
use bodyschema::learning::{Certainty, Input};
use bodyschema::mujoco::Model;
use bodyschema::peripersonal::{Doubt, OwnAura, OwnBody};
use bodyschema::senses::Toucher;
use bodyschema::simulation::{AgentHandle, ProbePath, Stage, StageOptions, Substance, Thing};
use bodyschema::skin::{AURA_REACH, GrowOptions, ProximityGeometry, aura_of, grow_skin, skin_of};
use nalgebra::{Isometry3, Point3, Vector3};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// Numbers are written to a micrometre.
const WRITTEN: f64 = 3e-6;
/// The aura of a learned schema is where that of the true body is to this, metres.
const LEARNED: f64 = 1e-3;

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

/// Some balls about a limb of a body in a posture, in the root's frame.
fn about_limbs(own: &OwnBody, posture: &[f64], rng: &mut ChaCha8Rng) -> Vec<Ball> {
    let frames = own.frames(posture);
    let receptors = &own.skin().receptors;
    let ball = |_| {
        let receptor = &receptors[rng.random_range(0..receptors.len())];
        let place = receptor.place(rng.random_range(0.01..0.3));
        Ball { centre: frames[receptor.limb].point(&place.point), radius: rng.random_range(0.0..0.05) }
    };
    (0..20).map(ball).collect()
}

/// The largest difference of how near balls are by two accounts of one body, metres; limbs of the nearest agree.
fn differ(own: &OwnBody, other: &OwnBody, seed: u64) -> f64 {
    let auras = [own, other].map(OwnAura::new);
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let mut most = 0.0_f64;
    for _ in 0..20 {
        let posture = Posture::random(own.creature(), &mut rng);
        for ball in about_limbs(other, &posture, &mut rng) {
            let [mine, its] =
                [(own, &auras[0]), (other, &auras[1])].map(|(body, aura)| aura.near(body, &posture, &ball));
            for near in &its {
                let same = mine.iter().find(|mine| mine.aura_limb == near.aura_limb);
                let off = |same: &bodyschema::peripersonal::NearLimb| {
                    (same.distance - near.distance).abs().max((same.depth - near.depth).abs())
                };
                // What is hardly inside one may be hardly outside the other.
                most = most.max(same.map_or(near.depth, off));
            }
        }
    }
    most
}

#[test]
fn the_aura_that_is_acted_on_is_where_the_schema_has_it() {
    let path = repository("mjcf/max/max.xml");
    let learned = Agent::from_mjcf(&path).unwrap().babble(400).unwrap().learn().unwrap();
    let own = learned.own_body();
    let body = max("torso");
    let true_body = own.with_schema(truth(&body));
    let off = differ(&own, &true_body, 1);
    assert!(off < LEARNED, "{off}");
    assert!(OwnAura::new(&own).unknown.is_empty());
    // A schema that has an elbow 8 cm farther down has the aura of the forearm and the hand there, too.
    let mut wrong = truth(&body);
    let elbow = own.creature().joints().iter().position(|joint| joint.name == "left_elbow").unwrap();
    wrong.positions[elbow] += Vector3::new(0.0, 0.0, -0.08);
    let wrong = own.with_schema(wrong);
    let off = differ(&wrong, &true_body, 1);
    assert!((0.05..0.081).contains(&off), "{off}");
    let posture = own.at_ease();
    let hand = own.creature().limb("left_hand").unwrap();
    let place = own.place(own.receptors_on(&[hand])[0]);
    let at = |own: &OwnBody| Ball { centre: own.frames(&posture)[hand].point(&place.point), radius: 0.0 };
    let nearest = |own: &OwnBody, ball| OwnAura::new(own).near(own, &posture, &ball)[0];
    let found = nearest(&wrong, at(&wrong));
    assert!(found.limb == hand && found.distance.abs() < 1e-6, "{found:?}");
    assert!(nearest(&wrong, at(&true_body)).distance > 0.01);
}

#[test]
fn limbs_whose_place_is_not_known_are_named_and_have_no_aura() {
    let body = max("torso");
    let agent = Agent::of(&body).unwrap();
    let schema = truth(&body);
    let hand = body.creature.limb("left_hand").unwrap();
    // Touches of all limbs but the left hand say nothing of the wrist.
    let touches: Vec<_> = babble(&body, &agent, 600, 3, 2)
        .into_iter()
        .filter(|touch| touch.ends.iter().all(|end| agent.skin().receptors[end.receptor].limb != hand))
        .collect();
    let own = own_body(&agent, &schema, Input::Receptor, &touches);
    let aura = OwnAura::new(&own);
    let named: Vec<usize> = aura.unknown.iter().map(|(limb, _)| *limb).collect();
    assert!(named.contains(&hand), "{named:?}");
    assert!(aura.unknown.iter().all(|(_, doubt)| !matches!(doubt, Doubt::Unknown)), "{:?}", aura.unknown);
    assert!(!named.contains(&body.creature.limb("head").unwrap()), "{:?}", aura.unknown);
    let posture = own.at_ease();
    let place = own.place(own.receptors_on(&[hand])[0]);
    let ball = Ball { centre: own.frames(&posture)[hand].point(&place.point), radius: 0.01 };
    assert!(aura.near(&own, &posture, &ball).iter().all(|near| near.limb != hand));
    // Where nothing bears out what it takes itself to be, only the root is where it is.
    let nobody = OwnAura::new(&OwnBody::new(&agent, schema, Certainty::Unknown, &touches));
    assert!(nobody.geometries.iter().all(|geometry| geometry.limb == 0));
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
    handle.watch_out();
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
            threatened
                .extend(handle.approaches().into_iter().filter_map(|approach| Some(approach.contact?.limb)));
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
    let places = [found.place(0.06), breast.place(0.0)];
    let now = handle.posture();
    let schema = truth(&max("torso"));
    let reach = InverseKinematics::new(&creature, &schema, places).at_ease(&now).solve(&now);
    assert!(reach.reached());
    let threatened = go(&reach.posture, &mut handle);
    assert!(threatened.iter().any(|limb| !own(limb)), "{threatened:?}");
    assert!(!threatened.iter().any(own), "{threatened:?}");
}
