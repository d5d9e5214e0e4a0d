//! The learned body as a model: read back by MuJoCo it is the schema that was written.

use std::path::Path;
use std::sync::Arc;

use bodyschema::agent::Agent;
use bodyschema::creature::{Body, Creature, Dof, DofKind, Joint, JointSelection, Posture};
use bodyschema::export::{ExportFormat, to_mjcf};
use bodyschema::geometry::Shape;
use bodyschema::ground_truth::GroundTruth;
use bodyschema::kinematics::limb_frames;
use bodyschema::learning::initial_guess::random_guess;
use bodyschema::mujoco::{Data, Model};
use bodyschema::schema::BodySchema;
use bodyschema::skin::{Skin, skin_of};
use nalgebra::Vector3;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

/// Agreement of lengths (metres), directions and rotations after a round trip through MJCF.
const ROUND_TRIP: f64 = 1e-9;

/// A slide and a ball, joints in series on one body, a bare limb, and a geom of each shape.
const MIXED: &str = r#"<mujoco model="mixed &amp; &quot;odd&quot;">
  <compiler angle="radian"/>
  <worldbody>
    <body name="trunk" pos="1 2 3" quat="0.9 0.1 -0.3 0.2">
      <freejoint/>
      <geom type="box" size="0.1 0.2 0.3" quat="0.7 0.1 0.2 0.3"/>
      <site name="t" type="box" size="0.02 0.03 0.001" pos="0.1 0 0" quat="0.7 0 0.7 0"/>
      <body name="piston" pos="0.2 0 0.4" quat="0.8 0.2 0.1 0">
        <joint name="push" type="slide" axis="0.3 0 1" limited="true" range="-0.1 0.2"/>
        <joint name="swing" axis="1 1 0" pos="0.01 0.02 0" limited="true" range="-1 1" ref="0.25"/>
        <joint name="twist" axis="0 0 1" pos="0.05 0 0.01"/>
        <geom type="cylinder" size="0.05 0.1" pos="0 0 0.3"/>
        <site name="p" type="sphere" size="0.02" pos="0.06 0 0.3"/>
        <body name="bare" pos="0 0 0.3">
          <joint name="lean" axis="0 1 0" limited="true" range="-0.5 0.7"/>
          <inertial pos="0 0 0" mass="0.1" diaginertia="0.001 0.001 0.001"/>
          <body name="bowl" pos="0.1 0 0.1">
            <joint name="roll" type="ball" limited="true" range="0 1.2"/>
            <geom type="ellipsoid" size="0.05 0.06 0.07" quat="0.5 0.5 0.1 0.2"/>
            <site name="b" type="box" size="0.01 0.01 0.002" pos="0.05 0.01 0"/>
          </body>
          <body name="loose" pos="-0.1 0 0.2">
            <joint name="spin" type="ball"/>
            <joint name="slip" type="slide" axis="0 1 0"/>
            <geom type="capsule" size="0.02 0.1" pos="0 0 0.1"/>
            <geom type="sphere" size="0.03" pos="0 0 0.25"/>
            <site name="l" type="box" size="0.002 0.003 0.0001" pos="0.02 0 0.1" quat="0.7 0 0.7 0"/>
          </body>
        </body>
      </body>
    </body>
  </worldbody>
  <sensor>
    <touch site="t"/> <touch site="p"/> <touch site="b"/> <touch site="l"/>
  </sensor>
</mujoco>"#;

fn body(model: Model, selection: &JointSelection) -> Body {
    Body::new(Arc::new(model), selection).unwrap()
}

fn max(selection: &JointSelection) -> Body {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/mjcf/max/max.xml");
    body(Model::from_path(path).unwrap(), selection)
}

fn read_back(xml: &str) -> Body {
    body(Model::from_xml(xml).unwrap_or_else(|e| panic!("{e}\n{xml}")), &JointSelection::All)
}

/// Exports a body's true schema, reads it back, and holds all that the agent knows against each other.
fn round_trip(original: &Body) -> Body {
    let (agent, truth) = (Agent::of(original).unwrap(), GroundTruth::new(original).unwrap().schema);
    let copy = read_back(&to_mjcf(&agent, &truth));
    same_creature(&original.creature, &copy.creature);
    same_schema(&truth, &GroundTruth::new(&copy).unwrap().schema);
    same_receptors(agent.skin(), &skin_of(&copy));
    same_motion(&copy, &truth);
    copy
}

fn same_creature(a: &Creature, b: &Creature) {
    assert_eq!(a.name(), b.name());
    assert_eq!(a.limbs(), b.limbs());
    assert_eq!(a.aura_limbs(), b.aura_limbs());
    assert_eq!(a.joints().len(), b.joints().len());
    for (x, y) in a.dofs().zip(b.dofs()) {
        assert_eq!((&x.name, x.kind, x.range), (&y.name, y.kind, y.range));
    }
}

fn same_schema(a: &BodySchema, b: &BodySchema) {
    assert_eq!((a.positions.len(), a.axes.len()), (b.positions.len(), b.axes.len()));
    for (x, y) in a.positions.iter().chain(&a.axes).zip(b.positions.iter().chain(&b.axes)) {
        assert!((x - y).norm() < ROUND_TRIP, "{x} became {y}");
    }
}

fn same_receptors(a: &Skin, b: &Skin) {
    assert_eq!(a.receptors.len(), b.receptors.len());
    for x in &a.receptors {
        let y = &b.receptors[b.receptor(&x.id).unwrap_or_else(|| panic!("{} is lost", x.id))];
        assert_eq!((x.limb, x.half_extents), (y.limb, y.half_extents));
        for (x, y) in [(x.position, y.position), (x.normal, y.normal), (x.tangent, y.tangent)] {
            assert!((x - y).norm() < ROUND_TRIP, "{x} became {y}");
        }
    }
}

/// MuJoCo moves the exported limbs as the schema does.
fn same_motion(copy: &Body, schema: &BodySchema) {
    let mut rng = ChaCha8Rng::seed_from_u64(7);
    let mut data = Data::new(copy.model.clone()).unwrap();
    for _ in 0..50 {
        let posture = Posture::random(&copy.creature, &mut rng);
        copy.put(&posture, &mut data).unwrap();
        let root = data.body_pose(copy.root);
        for (limb, frame) in limb_frames(&copy.creature, schema, &posture).iter().enumerate() {
            let pose = root.inv_mul(&copy.limb_pose(&data, limb).unwrap());
            let rotation = pose.rotation.to_rotation_matrix().into_inner();
            let name = &copy.creature.limbs()[limb];
            assert!((pose.translation.vector - frame.origin).norm() < ROUND_TRIP, "{name}");
            assert!((rotation - frame.rotation).norm() < ROUND_TRIP, "{name}");
        }
    }
}

#[test]
fn max_survives_the_round_trip() {
    for selection in [JointSelection::All, JointSelection::Default] {
        round_trip(&max(&selection));
    }
}

#[test]
fn every_kind_of_joint_and_shape_survives_the_round_trip() {
    let original = body(Model::from_xml(MIXED).unwrap(), &JointSelection::All);
    assert_eq!(original.creature.joints().len(), 5, "two joints in series and three more");
    let copy = round_trip(&original);
    let shapes = |skin: Skin| skin.surfaces.into_iter().map(|s| (s.limb, s.shape)).collect::<Vec<_>>();
    assert_eq!(shapes(skin_of(&original)), shapes(skin_of(&copy)));
    for (a, b) in skin_of(&original).surfaces.iter().zip(&skin_of(&copy).surfaces) {
        assert!((a.origin - b.origin).norm() < ROUND_TRIP);
        assert!((a.rotation - b.rotation).norm() < ROUND_TRIP);
    }
}

/// A schema need not be true: MuJoCo puts every limb where it says, with slides and balls, too.
#[test]
fn limbs_are_where_the_schema_says_however_wrong_it_is() {
    let mixed = body(Model::from_xml(MIXED).unwrap(), &JointSelection::All);
    for (original, seed) in [(max(&JointSelection::Default), 1), (max(&JointSelection::All), 2), (mixed, 3)] {
        let learned = random_guess(&original.creature, &mut ChaCha8Rng::seed_from_u64(seed));
        let copy = read_back(&to_mjcf(&Agent::of(&original).unwrap(), &learned));
        same_schema(&learned, &GroundTruth::new(&copy).unwrap().schema);
        same_motion(&copy, &learned);
    }
}

#[test]
fn exporting_again_adds_and_loses_nothing() {
    let original = body(Model::from_xml(MIXED).unwrap(), &JointSelection::All);
    let first = round_trip(&original);
    let export = |body: &Body| to_mjcf(&Agent::of(body).unwrap(), &GroundTruth::new(body).unwrap().schema);
    let second = read_back(&export(&first));
    same_schema(&GroundTruth::new(&first).unwrap().schema, &GroundTruth::new(&second).unwrap().schema);
    assert_eq!(export(&first).lines().count(), export(&second).lines().count());
}

#[test]
fn a_mesh_becomes_a_tile_below_each_of_its_receptors() {
    let original = body(Model::from_xml(MIXED).unwrap(), &JointSelection::All);
    let mut skin = skin_of(&original);
    let trunk = skin.surfaces.iter().position(|surface| surface.limb == 0).unwrap();
    skin.surfaces[trunk].shape = Shape::Mesh;
    let agent = Agent::new(original.creature.clone(), skin).unwrap();
    let skin = agent.skin();
    let truth = GroundTruth::new(&original).unwrap().schema;
    let copy = read_back(&to_mjcf(&agent, &truth));
    let found = skin_of(&copy);
    same_receptors(skin, &found);
    let receptor = &skin.receptors[skin.receptor("t").unwrap()];
    let tile = found.surfaces.iter().find(|surface| surface.limb == 0).unwrap();
    let (distance, normal) = tile.signed_distance(&(receptor.position + receptor.normal * 0.01)).unwrap();
    assert!((distance - 0.01).abs() < ROUND_TRIP && (normal - receptor.normal).norm() < ROUND_TRIP);
}

/// A creature hinged to the world has the world for its root, a name that no body may bear.
#[test]
fn a_mounted_creature_gets_a_root_of_its_own() {
    let xml = r#"<mujoco>
      <compiler angle="radian"/>
      <worldbody>
        <body name="arm" pos="0 0 1">
          <joint name="shoulder" axis="0 1 0" limited="true" range="-1 2"/>
          <geom type="capsule" size="0.05 0.1"/>
        </body>
      </worldbody>
    </mujoco>"#;
    let original = body(Model::from_xml(xml).unwrap(), &JointSelection::All);
    let truth = GroundTruth::new(&original).unwrap().schema;
    let copy = read_back(&to_mjcf(&Agent::of(&original).unwrap(), &truth));
    assert_eq!(copy.creature.limbs(), ["root", "arm"]);
    same_schema(&truth, &GroundTruth::new(&copy).unwrap().schema);
    same_motion(&copy, &truth);
}

/// In the reference posture neighbouring limbs overlap; without the excludes they would collide.
#[test]
fn neighbouring_limbs_do_not_collide() {
    let original = max(&JointSelection::All);
    let xml = to_mjcf(&Agent::of(&original).unwrap(), &GroundTruth::new(&original).unwrap().schema);
    let colliding = |xml: &str| {
        let copy = read_back(xml);
        // With the file's own filters.
        let mut data = Data::new(copy.declared.clone()).unwrap();
        data.kinematics().unwrap();
        data.collision().unwrap();
        let limbs = |geoms: [usize; 2]| geoms.map(|geom| copy.limb_of_geom(geom).unwrap());
        let neighbouring = |[a, b]: [usize; 2]| copy.creature.neighbouring(a, b);
        data.contacts().filter(|contact| neighbouring(limbs(contact.geoms))).count()
    };
    assert_eq!(colliding(&xml), 0);
    let (start, end) = (xml.find("<contact>").unwrap(), xml.find("</contact>").unwrap());
    assert!(colliding(&[&xml[..start], &xml[end + "</contact>".len()..]].concat()) > 0);
}

/// Axes that were never learned and a range of one point still make a model that MuJoCo takes.
#[test]
fn a_schema_that_knows_nothing_is_a_model_too() {
    let original = body(Model::from_xml(MIXED).unwrap(), &JointSelection::All);
    let empty = BodySchema::zero(&original.creature);
    let copy = read_back(&to_mjcf(&Agent::new(original.creature.clone(), Skin::default()).unwrap(), &empty));
    let truth = GroundTruth::new(&copy).unwrap().schema;
    assert!(truth.positions.iter().all(|position| position.norm() < ROUND_TRIP));
    let hinge = truth.axes[1];
    assert!((hinge - Vector3::z()).norm() < ROUND_TRIP);

    let dof = |kind| Dof { name: format!("{kind:?}"), kind, range: [0.3, 0.3], follows: None };
    let dofs = [DofKind::Hinge, DofKind::Slide, DofKind::Ball].map(dof).to_vec();
    let limbs = vec!["trunk".to_string(), "limb".to_string()];
    let stiff =
        Creature::new("stiff".to_string(), limbs, vec![Joint::new("joint", 0, dofs)], Vec::new()).unwrap();
    let copy =
        read_back(&to_mjcf(&Agent::new(stiff.clone(), Skin::default()).unwrap(), &BodySchema::zero(&stiff)));
    assert_eq!(copy.creature.dof(), 5);
}

/// What a format makes of a body at its truth.
fn exported(body: &Body, name: &str) -> String {
    let (agent, truth) = (Agent::of(body).unwrap(), GroundTruth::new(body).unwrap().schema);
    let path = Path::new(name);
    let (_, bytes) = (ExportFormat::of(path).unwrap().files)(&agent, &truth, path).pop().unwrap();
    String::from_utf8(bytes).unwrap()
}

#[test]
fn a_table_has_every_joint_to_the_last_digit() {
    let mixed = body(Model::from_xml(MIXED).unwrap(), &JointSelection::All);
    let truth = GroundTruth::new(&mixed).unwrap().schema;
    let text = exported(&mixed, "mixed.csv");
    let mut table = csv::Reader::from_reader(text.as_bytes());
    let rows: Vec<csv::StringRecord> = table.records().map(Result::unwrap).collect();
    let dofs: Vec<(usize, &Dof)> = mixed
        .creature
        .joints()
        .iter()
        .enumerate()
        .flat_map(|(j, joint)| joint.dofs.iter().map(move |d| (j, d)))
        .collect();
    assert_eq!(rows.len(), dofs.len());
    for (k, (row, (joint, dof))) in rows.iter().zip(dofs).enumerate() {
        assert_eq!((&row[0], &row[2]), (mixed.creature.joints()[joint].name.as_str(), dof.name.as_str()));
        let numbers = |from: usize| Vector3::from_fn(|i, _| row[from + i].parse().unwrap());
        assert_eq!(numbers(4), truth.positions[joint], "{row:?}");
        match dof.kind {
            DofKind::Ball => assert_eq!((&row[3], &row[7]), ("ball", "")),
            _ => assert_eq!(numbers(7), truth.axes[k], "{row:?}"),
        }
    }
}

#[test]
fn a_picture_for_paraview_has_every_receptor_where_the_schema_puts_it() {
    let max = max(&JointSelection::All);
    let truth = GroundTruth::new(&max).unwrap().schema;
    let skin = skin_of(&max);
    let text = exported(&max, "max.vtk");
    let (_, points) = text.split_once(" double\n").unwrap();
    let corners: Vec<Vector3<f64>> = points
        .lines()
        .map_while(|line| {
            let numbers: Vec<f64> = line.split(' ').map_while(|word| word.parse().ok()).collect();
            (numbers.len() == 3).then(|| Vector3::from_column_slice(&numbers))
        })
        .collect();
    assert_eq!(corners.len(), 4 * skin.receptors.len());
    let frames = limb_frames(&max.creature, &truth, &max.creature.reference_posture());
    for (four, receptor) in corners.chunks(4).zip(&skin.receptors) {
        let middle = four.iter().sum::<Vector3<f64>>() / 4.0;
        assert!((middle - frames[receptor.limb].point(&receptor.position)).norm() < ROUND_TRIP);
        let [u, v] = receptor.half_extents.map(|half| 2.0 * half);
        let sides = [(four[1] - four[0]).norm(), (four[2] - four[1]).norm()];
        assert!((sides[0] - u).abs() < ROUND_TRIP && (sides[1] - v).abs() < ROUND_TRIP, "{sides:?}: {u} {v}");
    }
    for part in ["POLYGONS", "CELL_DATA", "SCALARS limb", "NORMALS normal"] {
        assert!(text.contains(&format!("\n{part} ")), "{part}");
    }
}
