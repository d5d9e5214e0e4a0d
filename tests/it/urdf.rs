//! URDF, written and read: readers take the learned body, MuJoCo moves its links as the schema says, and a maker's robot is
//! read like any other creature.

use std::sync::Arc;

use crate::common::{creature, max, truth, two_arms};
use bodyschema::agent::Agent;
use bodyschema::creature::{Body, Creature, DofKind, JointSelection, Posture};
use bodyschema::export::{Urdf, to_urdf};
use bodyschema::geometry::Shape;
use bodyschema::kinematics::limb_frames;
use bodyschema::learning::initial_guess::random_guess;
use bodyschema::mujoco::{Data, Model, ObjectKind};
use bodyschema::schema::BodySchema;
use nalgebra::{Quaternion, UnitQuaternion};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

/// Agreement of places (metres) and rotations after a round trip through URDF.
const ROUND_TRIP: f64 = 1e-9;
/// How far the mesh of an ellipsoid may be from it, as a share of its semi-axes.
const MESH: f64 = 0.01;

/// A slide, joints in series, a ball in mid-chain, and a geom of each shape.
const MIXED: &str = r#"<mujoco model="mixed">
  <compiler angle="radian"/>
  <worldbody>
    <body name="trunk">
      <freejoint/>
      <geom type="box" size="0.1 0.2 0.3" quat="0.7 0.1 0.2 0.3"/>
      <body name="piston" pos="0.2 0 0.4" quat="0.8 0.2 0.1 0">
        <joint name="push" type="slide" axis="0.3 0 1" limited="true" range="-0.1 0.2"/>
        <joint name="swing" axis="1 1 0" limited="true" range="-1 1"/>
        <joint name="twist" axis="0 0 1" pos="0.05 0 0.01"/>
        <geom type="cylinder" size="0.05 0.1" pos="0 0 0.3"/>
        <body name="bowl" pos="0.1 0 0.1">
          <joint name="roll" type="ball" limited="true" range="0 1.2"/>
          <geom type="ellipsoid" size="0.05 0.06 0.07" quat="0.5 0.5 0.1 0.2"/>
          <body name="loose" pos="-0.1 0 0.2">
            <joint name="spin" type="ball"/>
            <joint name="slip" type="slide" axis="0 1 0"/>
            <geom type="capsule" size="0.02 0.1" pos="0 0 0.1"/>
            <geom type="sphere" size="0.03" pos="0 0 0.25"/>
          </body>
        </body>
      </body>
    </body>
  </worldbody>
</mujoco>"#;

/// A schema as URDF, in a folder of its own.
fn export(agent: &Agent, schema: &BodySchema) -> (tempfile::TempDir, Urdf) {
    let urdf = to_urdf(agent, schema, "ellipsoid.stl");
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("body.urdf"), &urdf.xml).unwrap();
    if let Some(mesh) = &urdf.mesh {
        std::fs::write(folder.path().join("ellipsoid.stl"), mesh).unwrap();
    }
    (folder, urdf)
}

fn read_back(folder: &tempfile::TempDir) -> Arc<Model> {
    Arc::new(Model::from_path(folder.path().join("body.urdf")).unwrap())
}

/// The angles about x, y and z in turn that make a rotation.
fn turns(w: f64, x: f64, y: f64, z: f64) -> [f64; 3] {
    let r = UnitQuaternion::from_quaternion(Quaternion::new(w, x, y, z)).to_rotation_matrix();
    let r = r.matrix();
    [f64::atan2(-r[(1, 2)], r[(2, 2)]), r[(0, 2)].clamp(-1.0, 1.0).asin(), f64::atan2(-r[(0, 1)], r[(0, 0)])]
}

/// Names and coordinates of the URDF's joints in a posture of the creature.
fn coordinates(creature: &Creature, posture: &[f64]) -> Vec<(String, f64)> {
    let mut named = Vec::new();
    let mut rest = posture;
    for dof in creature.dofs() {
        let (own, after) = rest.split_at(dof.kind.coordinates());
        rest = after;
        match dof.kind {
            DofKind::Ball => {
                let angles = turns(own[0], own[1], own[2], own[3]);
                named.extend(
                    ["x", "y", "z"].iter().zip(angles).map(|(a, t)| (format!("{}_{a}", dof.name), t)),
                );
            }
            _ => named.push((dof.name.clone(), own[0])),
        }
    }
    named
}

/// MuJoCo moves the links of the URDF as the schema moves the limbs.
fn same_motion(agent: &Agent, schema: &BodySchema) {
    let (folder, _) = export(agent, schema);
    let model = read_back(&folder);
    let mut data = Data::new(model.clone()).unwrap();
    let mut rng = ChaCha8Rng::seed_from_u64(7);
    let root = &agent.creature().limbs()[0];
    let body_of = |limb: &str| model.id(ObjectKind::Body, limb).unwrap_or_else(|| panic!("{limb} is lost"));
    for _ in 0..50 {
        let posture = Posture::random(agent.creature(), &mut rng);
        let mut qpos = model.qpos0().to_vec();
        for (name, value) in coordinates(agent.creature(), &posture) {
            let joint = model.joints().find(|joint| joint.name == Some(&name));
            qpos[joint.unwrap_or_else(|| panic!("{name} is lost")).qposadr] = value;
        }
        data.set_qpos(&qpos).unwrap();
        data.kinematics().unwrap();
        for (limb, frame) in limb_frames(agent.creature(), schema, &posture).iter().enumerate() {
            let name = &agent.creature().limbs()[limb];
            // The root is where the world is.
            let pose = if name == root { data.body_pose(0) } else { data.body_pose(body_of(name)) };
            let rotation = pose.rotation.to_rotation_matrix().into_inner();
            let away = (pose.translation.vector - frame.origin).norm();
            assert!(away < ROUND_TRIP, "{name}: {away} m");
            assert!((rotation - frame.rotation).norm() < ROUND_TRIP, "{name}");
        }
    }
}

#[test]
fn mujoco_moves_the_links_as_the_schema_moves_the_limbs() {
    for body in [
        max("torso"),
        creature(MIXED),
        creature(&two_arms(r#"type="sphere" size="0.1""#, r#"type="capsule" size="0.03 0.2""#)),
    ] {
        let wrong = random_guess(&body.creature, &mut ChaCha8Rng::seed_from_u64(3));
        for schema in [truth(&body), wrong] {
            same_motion(&Agent::of(&body).unwrap(), &schema);
        }
    }
}

#[test]
fn a_reader_of_urdf_finds_every_limb_and_degree_of_freedom() {
    let body = creature(MIXED);
    let (_folder, urdf) = export(&Agent::of(&body).unwrap(), &truth(&body));
    let robot = urdf_rs::read_from_string(&urdf.xml).unwrap();
    let links: Vec<&str> = robot.links.iter().map(|link| link.name.as_str()).collect();
    for limb in body.creature.limbs() {
        assert!(links.contains(&limb.as_str()), "{limb} is no link");
    }
    // Every joint carries one link, and all links but the root are carried once.
    assert_eq!(robot.links.len(), robot.joints.len() + 1);
    let carried: std::collections::BTreeSet<&str> =
        robot.joints.iter().map(|j| j.child.link.as_str()).collect();
    assert_eq!(carried.len(), robot.joints.len());
    assert!(!carried.contains(body.creature.limbs()[0].as_str()));
    assert_eq!(robot.joints.len(), body.creature.dof(), "a ball counts three");
    let joint = |name: &str| robot.joints.iter().find(|joint| joint.name == name).unwrap();
    let kind = |name: &str| format!("{:?}", joint(name).joint_type);
    assert_eq!(
        [kind("push"), kind("swing"), kind("twist"), kind("roll_y")],
        ["Prismatic", "Revolute", "Continuous", "Continuous"]
    );
    assert_eq!([joint("push").limit.lower, joint("push").limit.upper], [-0.1, 0.2]);
    for link in robot.links.iter().filter(|link| link.name != robot.links[0].name) {
        assert!(link.inertial.mass.value > 0.0, "{} weighs nothing", link.name);
    }
}

/// What the links are made of is where the skin is: MuJoCo's geoms, sampled, lie on the skin's surfaces.
#[test]
fn shapes_are_where_the_skin_is() {
    let body = creature(MIXED);
    let agent = Agent::of(&body).unwrap();
    let skin = agent.skin();
    let (folder, _) = export(&agent, &truth(&body));
    let model = read_back(&folder);
    let mut data = Data::new(model.clone()).unwrap();
    data.kinematics().unwrap();
    let frames = limb_frames(&body.creature, &truth(&body), &body.creature.reference_posture());
    // A capsule is three solids, all others one.
    assert_eq!(model.ngeom(), skin.surfaces.len() + 2);
    let mut geom = 0;
    for surface in &skin.surfaces {
        let pieces = if matches!(surface.shape, Shape::Capsule { .. }) { 3 } else { 1 };
        let centre = frames[surface.limb].point(&surface.origin);
        let first = data.geom_pose(geom).translation.vector;
        assert!((first - centre).norm() < 1e-6, "{:?} at {first} and not {centre}", surface.shape);
        if let Shape::Ellipsoid { semi_axes } = surface.shape {
            let vertices = model.mesh_vertices(geom);
            assert!(vertices.len() > 100, "a sphere of {} corners", vertices.len());
            let pose = data.geom_pose(geom);
            for vertex in vertices {
                let p_l = frames[surface.limb].inverse_point(&(pose * nalgebra::Point3::from(vertex)).coords);
                let (distance, _) = surface.signed_distance(&p_l).unwrap();
                assert!(distance.abs() < MESH * semi_axes[2], "a corner of the mesh is {distance} m off");
            }
        }
        geom += pieces;
    }
}

/// A robot as its maker describes it, in a package of its own.
const ROBOT: &str = r#"<?xml version="1.0"?>
<robot name="picker">
  <material name="grey"><color rgba="0.5 0.5 0.5 1"/></material>
  <link name="world"/>
  <joint name="mount" type="fixed"><parent link="world"/><child link="base"/><origin xyz="0 0 1"/></joint>
  <link name="base">
    <inertial><origin xyz="0 0 0.1" rpy="0 0 1.5707963267948966"/><mass value="4"/>
      <inertia ixx="1" iyy="2" izz="2.5" ixy="0" ixz="0" iyz="0"/></inertial>
    <visual><geometry><mesh filename="package://picker/meshes/pretty.dae"/></geometry></visual>
    <collision><origin xyz="0 0 0.1"/><geometry><box size="0.2 0.4 0.6"/></geometry></collision>
  </link>
  <joint name="lift" type="prismatic"><parent link="base"/><child link="arm"/>
    <origin xyz="0 0 1" rpy="1.5707963267948966 0 1.5707963267948966"/><axis xyz="0 1 0"/><limit lower="0" upper="0.4" effort="1" velocity="1"/></joint>
  <link name="arm"><collision><geometry><cylinder radius="0.05" length="1"/></geometry></collision></link>
  <joint name="grip" type="revolute"><parent link="arm"/><child link="left"/><origin xyz="0.5 0 0"/>
    <axis xyz="0 0 1"/><limit lower="-0.2" upper="0.8" effort="1" velocity="1"/></joint>
  <link name="left"><visual><geometry><sphere radius="0.1"/></geometry></visual></link>
  <joint name="follow" type="continuous"><parent link="arm"/><child link="right"/><origin xyz="-0.5 0 0"/>
    <axis xyz="0 0 1"/><mimic joint="grip" multiplier="-2" offset="0.1"/></joint>
  <link name="right"><collision><geometry><mesh filename="package://picker/meshes/block.stl" scale="2 2 2"/></geometry></collision>
    <collision><geometry><mesh filename="package://picker/meshes/gone.stl"/></geometry></collision></link>
  <transmission name="t"/>
</robot>"#;

/// A tetrahedron as STL, its edges one long.
fn stl() -> Vec<u8> {
    let corners = [[0.0f32, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    let mut bytes = vec![0u8; 80];
    bytes.extend(4u32.to_le_bytes());
    for face in [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]] {
        bytes.extend([0.0f32; 3].iter().flat_map(|x| x.to_le_bytes()));
        bytes.extend(face.iter().flat_map(|&k: &usize| corners[k]).flat_map(f32::to_le_bytes));
        bytes.extend([0u8; 2]);
    }
    bytes
}

#[test]
fn a_robot_of_a_package_is_read_by_the_same_door() {
    let folder = tempfile::tempdir().unwrap();
    let (meshes, urdf) = (folder.path().join("meshes"), folder.path().join("urdf"));
    std::fs::create_dir_all(&meshes).unwrap();
    std::fs::create_dir_all(&urdf).unwrap();
    std::fs::write(meshes.join("block.stl"), stl()).unwrap();
    let path = urdf.join("picker.urdf");
    std::fs::write(&path, ROBOT).unwrap();
    let (model, left_out) = Model::read(&path).unwrap();
    let lost: Vec<&String> = left_out.lost.keys().collect();
    assert!(lost.len() == 1 && lost[0].contains("package://picker/meshes/gone.stl"), "{left_out:?}");
    assert!(left_out.unneeded.contains_key("<transmission>"), "{left_out:?}");
    let model = Arc::new(model);
    let mut data = Data::new(model.clone()).unwrap();
    data.kinematics().unwrap();
    let body = |name: &str| model.id(ObjectKind::Body, name).unwrap_or_else(|| panic!("{name} is lost"));
    // Where urdf-rs, which knows nothing of MuJoCo, has the links.
    let robot = urdf_rs::read_from_string(ROBOT).unwrap();
    for joint in &robot.joints {
        let ([x, y, z], [roll, pitch, yaw]) = (joint.origin.xyz.0, joint.origin.rpy.0);
        let turn = UnitQuaternion::from_euler_angles(roll, pitch, yaw);
        let parent = if joint.parent.link == "world" { 0 } else { body(&joint.parent.link) };
        let expected = data.body_pose(parent) * nalgebra::Isometry3::from_parts([x, y, z].into(), turn);
        let found = data.body_pose(body(&joint.child.link));
        assert!(
            (found.translation.vector - expected.translation.vector).norm() < ROUND_TRIP,
            "{}",
            joint.name
        );
        assert!(found.rotation.angle_to(&expected.rotation) < 1e-7, "{}", joint.name);
    }
    // The lift goes up along the arm's y axis, which is the world's z axis.
    assert!((data.joint_axis(0).into_inner() - nalgebra::Vector3::z()).norm() < ROUND_TRIP);
    // A box is given by its whole sides, and what does not collide is all there is of the left finger.
    let geoms: Vec<_> = model.geoms().collect();
    assert_eq!(geoms.len(), 4);
    assert_eq!(geoms[0].size.as_slice(), [0.1, 0.2, 0.3]);
    assert_eq!(model.geom_body(2), body("left"));
    let corner = model.mesh_vertices(3).iter().map(|v| v.norm()).fold(0.0, f64::max);
    assert!((1.0..2.1).contains(&corner), "scaled by two: {corner}");
    let creature = Body::new(model.clone(), &JointSelection::All).unwrap().creature;
    let mut rng = ChaCha8Rng::seed_from_u64(1);
    for _ in 0..20 {
        let posture = Posture::random(&creature, &mut rng);
        let of = |name: &str| posture[creature.dofs().position(|dof| dof.name == name).unwrap()];
        assert!((of("follow") - (0.1 - 2.0 * of("grip"))).abs() < 1e-12);
    }
}

#[test]
fn a_robot_that_is_no_tree_is_told_by_link_and_line() {
    let link = |name: &str| format!("<link name='{name}'/>\n");
    let joint = |name: &str, parent: &str, child: &str, more: &str| {
        format!(
            "<joint name='{name}' type='revolute'><parent link='{parent}'/><child link='{child}'/>{more}</joint>\n"
        )
    };
    let robot = |parts: &[String]| format!("<robot name='r'>\n{}</robot>", parts.concat());
    let shaped = |shape: &str| {
        robot(&[format!("<link name='a'><visual><geometry>{shape}</geometry></visual></link>\n")])
    };
    let (a, b, c) = (link("a"), link("b"), link("c"));
    let cases = [
        (
            robot(&[a.clone(), b.clone(), c.clone(), joint("1", "a", "b", "")]),
            "line 4",
            "a and c are not carried",
        ),
        (robot(&[a.clone(), joint("1", "a", "zz", "")]), "line 3", "zz"),
        (
            robot(&[a.clone(), b.clone(), joint("1", "a", "b", ""), joint("2", "a", "b", "")]),
            "line 5",
            "two parent joints",
        ),
        (
            robot(&[a.clone(), b.clone(), joint("1", "a", "b", ""), joint("2", "b", "a", "")]),
            "urdf",
            "form a loop",
        ),
        (
            robot(&[a.clone(), b.clone(), joint("1", "a", "b", "<mimic joint='zz'/>")]),
            "line 4",
            "mimics zz, which does not exist",
        ),
        (
            robot(&[a.clone(), b.clone(), joint("1", "a", "b", "<axis xyz='0 0 0'/>")]),
            "line 4",
            "no direction",
        ),
        (robot(&[a.clone(), a.clone()]), "line 3", "two links are called a"),
        (robot(&[a.clone(), "<link/>\n".into()]), "line 3", "no name"),
        (
            robot(&[a.clone(), b.clone(), joint("1", "a", "b", "<mimic joint='1'/>")]),
            "line 4",
            "mimics itself; remove",
        ),
        (
            robot(&[
                a.clone(),
                b.clone(),
                c.clone(),
                joint("1", "a", "b", "<mimic joint='2'/>"),
                joint("2", "b", "c", "<mimic joint='1'/>"),
            ]),
            "line 5",
            "mimics itself by way of 2",
        ),
        (robot(&[a.clone(), b.clone(), joint("1", "a", "b", "<mimic/>")]), "line 4", "names no joint"),
        (robot(&[a.clone(), b.clone(), joint("1", "a", "b", "<axis xyz='1 0'/>")]), "line 4", "give it 3"),
        (
            robot(&[a.clone(), b.clone(), joint("1", "a", "b", "<origin xyz='0, 0, 1'/>")]),
            "line 4",
            "spaces between numbers",
        ),
        (
            robot(&[a.clone(), b.clone(), joint("1", "a", "b", "<origin xyz='0 0 ${h}'/>")]),
            "line 4",
            "xacro FILE",
        ),
        (
            robot(&[a.clone(), b.clone(), joint("1", "a", "b", "<limit lower='low' upper='1'/>")]),
            "line 4",
            "\"low\" in lower",
        ),
        (shaped("<sphere radius='-1'/>"), "line 2", "numbers above 0"),
        (shaped("<cylinder radius='1'/>"), "line 2", "length"),
        (shaped("<mesh/>"), "line 2", "names no file"),
        ("<robot>\n<xacro:include filename='x'/></robot>".into(), "line 2", "xacro FILE"),
        ("<robot/>".into(), "urdf", "<link>"),
    ];
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("r.urdf");
    for (xml, place, words) in cases {
        std::fs::write(&path, &xml).unwrap();
        let told = Model::from_path(&path).map(|_| ()).unwrap_err().to_string();
        assert!(told.contains(place) && told.contains(words) && told.lines().count() == 1, "{xml}\n{told}");
    }
}
