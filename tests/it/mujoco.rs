//! The MuJoCo layer: what it reads, what it computes, and that nothing a file or a caller hands it
//! ends the process.

use std::path::PathBuf;
use std::sync::Arc;

use bodyschema::mujoco::{self, Data, Error, GeomKind, JointKind, Model, ObjectKind, SensorKind, Version};
use nalgebra::{Point3, UnitQuaternion, Vector3};

/// Agreement with what the engine computes itself.
const ROUNDING: f64 = 1e-12;

const ARM: &str = r#"<mujoco>
  <compiler angle="radian" autolimits="true"/>
  <worldbody>
    <geom name="floor" type="plane" size="0 0 1" pos="0 0 -5"/>
    <body name="upper" pos="0 0 1">
      <joint name="shoulder" axis="0 1 0" range="-1 2"/>
      <geom name="upper" type="capsule" size="0.05" fromto="0 0 0 0.3 0 0" mass="1"/>
      <body name="fore" pos="0.3 0 0" quat="0.70710678118654752 0 0 0.70710678118654752">
        <joint name="elbow" axis="0 0 1" pos="0.01 0.02 0.03"/>
        <geom name="fore" type="box" size="0.1 0.02 0.03" pos="0.1 0 0" mass="1"/>
        <site name="tip" type="box" size="0.01 0.01 0.001" pos="0.2 0 0" quat="0 1 0 0"/>
      </body>
    </body>
  </worldbody>
  <sensor>
    <touch name="tip" site="tip"/>
    <jointpos name="elbow angle" joint="elbow"/>
  </sensor>
  <custom>
    <tuple name="arm">
      <element objtype="joint" objname="elbow" prm="0.5"/>
      <element objtype="site" objname="tip"/>
    </tuple>
  </custom>
</mujoco>"#;

fn data(xml: &str) -> Data {
    Data::new(Arc::new(Model::from_xml(xml).unwrap())).unwrap()
}

/// A small generator of its own, so that these tests need nothing but the layer.
struct Noise(u64);

impl Noise {
    /// A number in -1..1.
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (self.0 >> 11) as f64 / (1u64 << 52) as f64 - 1.0
    }

    /// A posture with every coordinate in -π..π.
    fn posture(&mut self, nq: usize) -> Vec<f64> {
        (0..nq).map(|_| self.next() * std::f64::consts::PI).collect()
    }
}

#[test]
fn a_model_says_what_its_file_says() {
    let model = Model::from_xml(ARM).unwrap();
    assert_eq!(model.version(), mujoco::check().unwrap());
    assert_eq!((model.nq(), model.nv(), model.nbody(), model.njnt()), (2, 2, 3, 2));
    assert_eq!((model.ngeom(), model.nsite(), model.nsensor()), (3, 1, 2));
    assert_eq!(model.qpos0(), [0.0, 0.0]);
    assert_eq!(model.warning(), None);

    let fore = model.body(model.id(ObjectKind::Body, "fore").unwrap());
    assert_eq!((fore.name, fore.parent, fore.weld), (Some("fore"), 1, 2));
    assert_eq!((fore.joints, fore.geoms), (1..2, 2..3));
    assert_eq!(fore.pos, Vector3::new(0.3, 0.0, 0.0));

    let shoulder = model.joint(0);
    assert_eq!((shoulder.name, shoulder.kind), (Some("shoulder"), JointKind::Hinge));
    assert_eq!((shoulder.body, shoulder.qposadr, shoulder.dofadr), (1, 0, 0));
    assert_eq!((shoulder.limited, shoulder.range), (true, [-1.0, 2.0]));
    assert_eq!(shoulder.axis, Vector3::y());
    assert!(!model.joint(1).limited);
    assert_eq!(model.joint(1).pos, Vector3::new(0.01, 0.02, 0.03));

    let upper = model.geom(1);
    assert_eq!((upper.kind, upper.body, upper.contype), (GeomKind::Capsule, 1, 1));
    assert!((upper.size[1] - 0.15).abs() < ROUNDING && (upper.rbound - 0.2).abs() < ROUNDING);
    assert_eq!(model.geom(2).size, [0.1, 0.02, 0.03]);
    assert_eq!(model.site(0).name, Some("tip"));

    let sensors: Vec<_> = model.sensors().map(|sensor| (sensor.kind, sensor.object)).collect();
    let expected = [(SensorKind::Touch, ObjectKind::Site), (SensorKind::JointPos, ObjectKind::Joint)];
    assert_eq!(sensors, expected);
    assert_eq!((model.sensor(1).id, model.sensor(1).adr, model.sensor(1).dim), (Some(1), 1, 1));

    let tuples = model.tuples();
    assert_eq!(tuples[0].name, Some("arm"));
    let entries: Vec<_> = tuples[0].entries.iter().map(|e| (e.object, e.id, e.prm)).collect();
    assert_eq!(entries, [(ObjectKind::Joint, 1, 0.5), (ObjectKind::Site, 0, 0.0)]);
    assert_eq!(model.id(ObjectKind::Joint, "knee"), None);
}

#[test]
fn quaternions_change_order_at_the_boundary() {
    let model = Model::from_xml(ARM).unwrap();
    let quarter = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), std::f64::consts::FRAC_PI_2);
    assert!(model.body(2).quat.angle_to(&quarter) < 1e-7);
    let half = UnitQuaternion::from_axis_angle(&Vector3::x_axis(), std::f64::consts::PI);
    assert!(model.site(0).quat.angle_to(&half) < 1e-7);
}

#[test]
fn poses_follow_the_posture() {
    let mut data = data(ARM);
    let model = data.model().clone();
    let mut noise = Noise(1);
    for _ in 0..20 {
        data.set_qpos(&noise.posture(2)).unwrap();
        data.kinematics().unwrap();
        for (i, body) in model.bodies().enumerate().skip(1) {
            // By hand: the joint turns the body about its anchor and axis.
            let joint = model.joint(body.joints.start);
            let turn = UnitQuaternion::from_scaled_axis(joint.axis * data.qpos()[joint.qposadr]);
            let x_wp = data.body_pose(body.parent);
            let rotation = body.quat * turn;
            let position = body.pos + body.quat * joint.pos - rotation * joint.pos;
            let x_wb = data.body_pose(i);
            let expected = x_wp * Point3::from(position);
            assert!((x_wb.translation.vector - expected.coords).norm() < ROUNDING);
            assert!((x_wb.rotation.inverse() * (x_wp.rotation * rotation)).angle() < 1e-7);
            let anchor = x_wb * Point3::from(joint.pos);
            assert!((data.joint_anchor(body.joints.start) - anchor).norm() < ROUNDING);
            let axis = x_wb.rotation * joint.axis;
            assert!((data.joint_axis(body.joints.start).into_inner() - axis).norm() < ROUNDING);
        }
        let site = model.site(0);
        let tip = data.body_pose(site.body) * Point3::from(site.pos);
        assert!((data.site_pose(0).translation.vector - tip.coords).norm() < ROUNDING);
        let rotation = data.body_pose(site.body).rotation * site.quat;
        assert!(data.site_pose(0).rotation.angle_to(&rotation) < 1e-7);
    }
}

#[test]
fn two_spheres_touch_where_they_overlap() {
    let mut data = data(
        r#"<mujoco><worldbody>
             <body><freejoint/><geom type="sphere" size="0.3"/></body>
             <body><freejoint/><geom type="sphere" size="0.2"/></body>
           </worldbody></mujoco>"#,
    );
    let at = |x: f64| [0., 0., 0., 1., 0., 0., 0., x, 0., 0., 1., 0., 0., 0.];
    data.set_qpos(&at(0.45)).unwrap();
    data.kinematics().unwrap();
    data.collision().unwrap();
    let contacts: Vec<_> = data.contacts().collect();
    assert_eq!(contacts.len(), 1);
    assert_eq!(contacts[0].geoms, [0, 1]);
    assert!((contacts[0].distance + 0.05).abs() < ROUNDING);
    assert!((contacts[0].normal - Vector3::x()).norm() < ROUNDING);
    assert!((contacts[0].position - Point3::new(0.275, 0.0, 0.0)).norm() < ROUNDING);
    assert_eq!(data.contact_force(0), Vector3::zeros());

    data.forward().unwrap();
    assert!(data.contact_force(0).x > 0.0);

    data.set_qpos(&at(0.51)).unwrap();
    data.kinematics().unwrap();
    data.collision().unwrap();
    assert_eq!(data.contacts().count(), 0);
}

#[test]
fn kinematics_and_collision_give_the_contacts_of_forward() {
    let mut short = data(HUMAN);
    let mut long = Data::new(short.model().clone()).unwrap();
    let mut noise = Noise(2);
    let mut found = 0;
    for _ in 0..100 {
        let posture = noise.posture(short.model().nq());
        short.set_qpos(&posture).unwrap();
        short.kinematics().unwrap();
        short.collision().unwrap();
        long.set_qpos(&posture).unwrap();
        long.forward().unwrap();
        found += short.contacts().count();
        assert!(short.contacts().eq(long.contacts()));
    }
    assert!(found > 0);
}

#[test]
fn mesh_vertices_lie_in_the_geoms_frame() {
    let mut data = data(
        r#"<mujoco><asset>
             <mesh name="tetra" vertex="0 0 0  1 0 0  0 1 0  0 0 1"/>
           </asset><worldbody>
             <body><geom type="mesh" mesh="tetra"/><geom size="1"/></body>
           </worldbody></mujoco>"#,
    );
    data.kinematics().unwrap();
    let vertices = data.model().mesh_vertices(0);
    assert_eq!(vertices.len(), 4);
    for corner in [Vector3::zeros(), Vector3::x(), Vector3::y(), Vector3::z()] {
        let reached = |v: &Vector3<f64>| (data.geom_pose(0) * Point3::from(*v) - Point3::from(corner)).norm();
        assert!(vertices.iter().any(|vertex| reached(vertex) < 1e-6));
    }
    assert!(data.model().mesh_vertices(1).is_empty());
}

/// A creature whose limbs meet in every way that the filters know.
const HUMAN: &str = r#"<mujoco>
  <default><joint type="hinge"/><geom type="capsule" size="0.08 0.15"/></default>
  <worldbody>
    <geom name="floor" type="plane" size="0 0 1"/>
    <geom name="wall" type="box" size="0.1 0.5 0.5"/>
    <body name="a"><joint axis="1 0 0"/><geom/>
      <body name="b" pos="0 0 0.1"><joint axis="0 1 0"/><geom/><geom type="ellipsoid" size="0.1 0.2 0.05"/>
        <body name="b welded" pos="0 0.1 0"><geom/>
          <body name="c" pos="0.1 0 0"><joint axis="0 0 1"/><geom contype="2" conaffinity="1"/></body>
        </body>
      </body>
      <body name="d" pos="0 0.1 0"><joint axis="0 1 0"/><geom contype="0" conaffinity="2"/>
        <body name="e" pos="0 0.1 0"><joint axis="1 0 0"/><geom contype="4" conaffinity="4"/>
          <geom contype="0" conaffinity="0"/></body>
      </body>
      <body name="f" pos="0.05 0 0"><joint axis="0 1 0"/><geom name="f"/></body>
      <body name="g" pos="-0.05 0 0"><joint axis="0 1 0"/><geom name="g" contype="0" conaffinity="0"/></body>
    </body>
    <body name="standing" pos="0 0 0.1"><geom type="sphere" size="0.1"/></body>
  </worldbody>
  <contact>
    <exclude body1="b" body2="f"/>
    <exclude body1="f" body2="c"/>
    <exclude body1="f" body2="g"/>
    <pair geom1="g" geom2="f"/>
    <pair geom1="g" geom2="floor"/>
  </contact>
</mujoco>"#;

/// All pairs that touch in some of many random postures are those that `collides` allows, and since
/// the limbs are heaped together, nearly all that it allows touch.
#[test]
fn the_filters_are_the_engines() {
    let variants = [
        ("", ""),
        ("<worldbody>", "<option><flag filterparent=\"disable\"/></option><worldbody>"),
        ("<worldbody>", "<option collision=\"predefined\"/><worldbody>"),
        ("<worldbody>", "<option collision=\"dynamic\"/><worldbody>"),
        ("<worldbody>", "<option><flag contact=\"disable\"/></option><worldbody>"),
    ];
    for (from, to) in variants {
        if to.contains("collision=") && mujoco::check().unwrap() >= Version(300) {
            continue; // MuJoCo 3 has no such option.
        }
        let xml = if from.is_empty() { HUMAN.to_string() } else { HUMAN.replacen(from, to, 1) };
        let mut data = data(&xml);
        let model = data.model().clone();
        let n = model.ngeom();
        let mut met = vec![false; n * n];
        let mut noise = Noise(3);
        for _ in 0..2000 {
            data.set_qpos(&noise.posture(model.nq())).unwrap();
            data.kinematics().unwrap();
            data.collision().unwrap();
            for contact in data.contacts() {
                let [a, b] = contact.geoms;
                met[a * n + b] = true;
                met[b * n + a] = true;
            }
        }
        for a in 0..n {
            for b in 0..n {
                let said = model.collides(a, b);
                assert_eq!(said, met[a * n + b], "geoms {a} and {b} after {to:?}");
            }
        }
    }
    let model = Model::from_xml(HUMAN).unwrap();
    let excludes: Vec<_> =
        model.excludes().map(|pair| pair.map(|body| model.body(body).name.unwrap())).collect();
    assert_eq!(excludes.len(), 3);
    for pair in [["b", "f"], ["c", "f"], ["f", "g"]] {
        assert!(excludes.contains(&pair), "{excludes:?}");
    }
}

#[test]
fn a_missing_file_is_named() {
    let path = PathBuf::from("no/such/creature.xml");
    let text = Model::from_path(&path).unwrap_err().to_string();
    assert!(text.starts_with("no/such/creature.xml: no such file"), "{text}");
    let text = Model::from_path(std::env::temp_dir()).unwrap_err().to_string();
    assert!(text.contains("not a regular file"), "{text}");
}

#[test]
fn a_broken_file_is_named_with_its_line() {
    let folder = tempfile::tempdir().unwrap();
    let broken = [
        ("<mujoco>\n<worldbody>\n<geom size='1'>\n</worldbody>\n</mujoco>", ", line 4: malformed XML"),
        ("<mujoco>\n<worldbody>\n<geom sise='1'/>\n</worldbody>\n</mujoco>", "line 3"),
        ("<mujoco>\n<worldbody>\n<geom/>\n</worldbody>\n</mujoco>", "line"),
        ("", "XML"),
    ];
    for (xml, place) in broken {
        let path = folder.path().join("broken.xml");
        std::fs::write(&path, xml).unwrap();
        let error = Model::from_path(&path).unwrap_err();
        assert!(matches!(error, Error::Read { .. }));
        let text = error.to_string();
        assert!(text.contains("broken.xml") && text.contains(place), "{text}");
        assert_eq!(text.lines().count(), 1);
    }
    let path = folder.path().join("broken.xml");
    std::fs::write(&path, "<mujoco>\n<include file='nowhere.xml'/></mujoco>").unwrap();
    let text = Model::from_path(&path).unwrap_err().to_string();
    assert!(text.contains("nowhere.xml") && text.contains("line 2"), "{text}");
    let text = Model::from_xml("<mujoco><no></mujoco>").unwrap_err().to_string();
    assert!(text.starts_with(Model::STRING_NAME), "{text}");
}

#[test]
fn hostile_sizes_are_refused_in_included_files_too() {
    let folder = tempfile::tempdir().unwrap();
    let main = folder.path().join("main.xml");
    let part = folder.path().join("part.xml");
    std::fs::write(&main, "<mujoco><worldbody><include file='part.xml'/></worldbody></mujoco>").unwrap();
    std::fs::write(&part, "<mujocoinclude>\n<geom size='0.1 1e30' type='capsule'/></mujocoinclude>").unwrap();
    let error = Model::from_path(&main).unwrap_err();
    assert!(matches!(error, Error::Read { line: Some(2), .. }), "{error}");
    assert!(error.to_string().contains("part.xml, line 2"), "{error}");
    std::fs::write(&part, "<mujocoinclude>\n<geom size='0.1 1' type='capsule'/></mujocoinclude>").unwrap();
    assert_eq!(Model::from_path(&main).unwrap().ngeom(), 1);
    let texture =
        "<mujoco><asset><texture type='2d' builtin='flat' width='999999999' height='9'/></asset></mujoco>";
    assert!(matches!(Model::from_xml(texture), Err(Error::Read { line: Some(1), .. })));
}

#[test]
fn a_wrong_posture_is_refused_and_changes_nothing() {
    let mut data = data(ARM);
    data.set_qpos(&[0.1, 0.2]).unwrap();
    for bad in [f64::NAN, f64::INFINITY, -f64::INFINITY, 1e11] {
        let error = data.set_qpos(&[0.0, bad]).unwrap_err();
        assert_eq!(error, Error::NotFinite { what: "qpos", index: 1 });
    }
    let error = data.set_qpos(&[0.0]).unwrap_err();
    assert_eq!(error, Error::Size { what: "qpos", expected: 2, found: 1 });
    assert_eq!(data.qpos(), [0.1, 0.2]);
}

/// `count` spheres in a row, apart from each other, each free to slide to the first.
fn row(count: usize, size: &str) -> String {
    let sphere = |i: usize| {
        format!("<body pos='{} 0 0'><joint type='slide' axis='1 0 0'/><geom size='1'/></body>", 3 * i)
    };
    let spheres: String = (0..count).map(sphere).collect();
    format!("<mujoco>{size}<worldbody>{spheres}</worldbody></mujoco>")
}

/// The posture that heaps the spheres of a row in one point.
fn heaped(count: usize) -> Vec<f64> {
    (0..count).map(|i| -3.0 * i as f64).collect()
}

/// Enough stack for spheres apart, not for the constraints of ten heaped.
const LITTLE_STACK: &str = "<size nstack='600'/>";

/// Whether contacts and stack share one arena, as they do after MuJoCo 2.2: it fills up elsewhere.
fn has_arena() -> bool {
    mujoco::check().unwrap() >= Version(230)
}

#[test]
fn an_error_inside_the_engine_is_a_value_and_the_data_live_on() {
    if has_arena() {
        return;
    }
    let mut data = data(&row(10, LITTLE_STACK));
    for _ in 0..3 {
        data.forward().unwrap();
        data.set_qpos(&heaped(10)).unwrap();
        let error = data.forward().unwrap_err();
        assert!(matches!(error, Error::Engine { call: "mj_forward", .. }), "{error}");
        assert!(error.to_string().contains("tack"), "{error}");
        assert_eq!(data.contacts().count(), 0);
        assert_eq!(data.qpos(), data.model().qpos0());
    }
    no_log_file();
}

#[test]
fn a_few_hundred_contacts_fit_and_too_many_are_an_error() {
    let mut few = data(&row(20, ""));
    few.set_qpos(&heaped(20)).unwrap();
    few.kinematics().unwrap();
    few.collision().unwrap();
    assert_eq!(few.contacts().count(), 190);

    if has_arena() {
        return;
    }
    let mut many = data(&row(80, ""));
    many.set_qpos(&heaped(80)).unwrap();
    for _ in 0..3 {
        many.kinematics().unwrap();
        let error = many.collision().unwrap_err();
        assert!(matches!(error, Error::Warning { call: "mj_collision", .. }), "{error}");
        assert!(error.to_string().to_lowercase().contains("contact"), "{error}");
        assert_eq!(many.contacts().count(), 0);
    }
    no_log_file();
}

/// Neither the engine's log file nor a question on the terminal.
fn no_log_file() {
    assert!(!PathBuf::from("MUJOCO_LOG.TXT").exists());
}

#[test]
fn threads_share_a_model_and_agree() {
    let model = Arc::new(Model::from_xml(HUMAN).unwrap());
    let run = |model: Arc<Model>| {
        let mut data = Data::new(model).unwrap();
        let mut noise = Noise(4);
        let mut contacts = Vec::new();
        for _ in 0..200 {
            data.set_qpos(&noise.posture(data.model().nq())).unwrap();
            data.kinematics().unwrap();
            data.collision().unwrap();
            contacts.extend(data.contacts());
        }
        contacts
    };
    let alone = run(model.clone());
    std::thread::scope(|scope| {
        let threads: Vec<_> = (0..4)
            .map(|_| {
                let model = model.clone();
                scope.spawn(move || (run(model), Model::from_xml(ARM).unwrap().nbody()))
            })
            .collect();
        for thread in threads {
            let (contacts, nbody) = thread.join().unwrap();
            assert!(contacts == alone && nbody == 3);
        }
    });
}

#[test]
fn a_failure_on_one_thread_leaves_the_others_alone() {
    if has_arena() {
        return;
    }
    std::thread::scope(|scope| {
        for failing in [true, false, true, false] {
            scope.spawn(move || {
                let size = if failing { LITTLE_STACK } else { "" };
                let mut data = data(&row(10, size));
                for _ in 0..50 {
                    data.set_qpos(&heaped(10)).unwrap();
                    assert_eq!(data.forward().is_err(), failing);
                }
            });
        }
    });
}
