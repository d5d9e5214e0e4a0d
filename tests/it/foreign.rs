//! Models that nobody here prepared: for newer engines, with several creatures, with self-contact switched off,
//! with joints that follow others.

use std::path::Path;
use std::sync::Arc;

use crate::common::program::{refused, run};
use crate::common::{creature, is_newer_engine, repository};
use bodyschema::Error;
use bodyschema::creature::{Body, Creature, JointSelection, Posture, creatures};
use bodyschema::mujoco::{Data, Model, ObjectKind, SensorKind};
use bodyschema::simulation::{Relation, SelfContact};
use bodyschema::skin::Skin;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

/// The poses of geoms in the world, by their order.
fn geom_places(xml: &str) -> Vec<(Option<String>, [f64; 3])> {
    let model = Arc::new(Model::from_xml(xml).unwrap());
    let mut data = Data::new(model.clone()).unwrap();
    data.kinematics().unwrap();
    let place = |g: usize| data.geom_pose(g).translation.vector.into();
    let name = |g: usize| model.body(model.geom_body(g)).name.map(str::to_string);
    (0..model.ngeom()).map(|g| (name(g), place(g))).collect()
}

/// Whether geoms are of these bodies at these places.
fn assert_places(xml: &str, expected: &[(&str, [f64; 3])]) {
    let found = geom_places(xml);
    assert_eq!(found.len(), expected.len(), "{found:?}");
    for ((name, place), (body, expected)) in found.iter().zip(expected) {
        let away = (0..3).map(|k| (place[k] - expected[k]).abs()).fold(0.0, f64::max);
        assert!(
            name.as_deref() == Some(*body) && away < 1e-12,
            "{name:?} {place:?} and not {body} {expected:?}"
        );
    }
}

#[test]
fn frames_turn_what_is_in_them_joints_as_well() {
    let xml = r#"<mujoco>
  <default><geom size=".1"/><default class="far"><geom pos="0 0 5"/></default></default>
  <worldbody>
    <frame pos="5 0 0" euler="0 0 90">
      <body name="a" pos="1 0 0"><freejoint/>
        <geom/>
        <body name="b">
          <frame pos="0 1 0" euler="0 0 90" childclass="far">
            <joint name="hinge" pos=".5 0 0" axis="1 0 0"/><joint name="slide" type="slide" axis="0 1 0"/>
            <geom/>
            <geom pos="1 0 0"/>
            <geom type="capsule" fromto="0 0 0 2 0 0"/>
            <frame euler="90 0 0"><geom class="main" pos="0 0 1"/></frame>
          </frame>
        </body>
      </body>
    </frame>
  </worldbody>
</mujoco>"#;
    // The frame turns x into y; seen from the world, both turn x into -x.
    let expected = [
        ("a", [5.0, 1.0, 0.0]),
        ("b", [4.0, 1.0, 5.0]),
        ("b", [3.0, 1.0, 0.0]),
        ("b", [3.0, 1.0, 0.0]),
        // The inner frame's z is the outer one's -y, which is the body's x, and the world's y.
        ("b", [4.0, 2.0, 0.0]),
    ];
    assert_places(xml, &expected);
    let model = Model::from_xml(xml).unwrap();
    let joint = |name: &str| model.joint(model.id(ObjectKind::Joint, name).unwrap());
    let near = |a: nalgebra::Vector3<f64>, b: [f64; 3]| (a - nalgebra::Vector3::from(b)).norm() < 1e-12;
    assert!(near(joint("hinge").pos, [0.0, 1.5, 0.0]) && near(joint("hinge").axis, [0.0, 1.0, 0.0]));
    assert!(near(joint("slide").pos, [0.0, 1.0, 0.0]) && near(joint("slide").axis, [-1.0, 0.0, 0.0]));
}

#[test]
fn replicas_go_on_from_each_other_and_what_names_them_follows() {
    let xml = r#"<mujoco>
  <worldbody>
    <body name="hub"><geom size=".1"/>
      <replicate count="2" offset="1 0 0" euler="0 0 90" sep="-">
        <body name="leg" pos="0 0 1"><joint name="hip"/><geom size=".1"/>
          <replicate count="11" offset="0 1 0" sep="_">
            <body name="toe"><joint name="knuckle"/><geom size=".1"/><site name="tip"/></body>
          </replicate>
        </body>
      </replicate>
    </body>
  </worldbody>
  <contact><exclude body1="leg" body2="toe"/></contact>
  <sensor><touch name="felt" site="tip"/></sensor>
  <custom><tuple name="limb/toes"><element objtype="body" objname="toe"/></tuple></custom>
</mujoco>"#;
    let found = geom_places(xml);
    assert_eq!(found.len(), 25);
    let place = |name: &str| found.iter().find(|(body, _)| body.as_deref() == Some(name)).unwrap().1;
    let near = |a: [f64; 3], b: [f64; 3]| (0..3).all(|k| (a[k] - b[k]).abs() < 1e-12);
    assert!(near(place("leg-0"), [0.0, 0.0, 1.0]) && near(place("leg-1"), [1.0, 0.0, 1.0]));
    assert!(near(place("toe_10-0"), [0.0, 10.0, 1.0]) && near(place("toe_10-1"), [-9.0, 0.0, 1.0]));
    let model = Model::from_xml(xml).unwrap();
    assert!(model.id(ObjectKind::Joint, "knuckle_07-1").is_some());
    if is_newer_engine() {
        // It reads replicas itself, and leaves what names them as it is.
        return;
    }
    let touch = model.sensors().filter(|sensor| sensor.kind == SensorKind::Touch);
    assert_eq!(touch.filter_map(|sensor| sensor.id).collect::<std::collections::BTreeSet<_>>().len(), 22);
    assert_eq!(model.tuples()[0].entries.len(), 22);
}

#[test]
fn a_model_is_attached_with_its_own_units_classes_and_couplings() {
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, text: &str| std::fs::write(folder.path().join(name), text).unwrap();
    write(
        "finger.xml",
        r#"<mujoco model="finger">
  <compiler angle="radian" eulerseq="zyx"/>
  <default><default class="bone"><geom size=".02"/></default></default>
  <worldbody><body name="finger" pos="1 2 3" euler="1.5707963267948966 0 0" childclass="bone">
    <joint name="bend" range="-1 1"/><geom pos="1 0 0"/>
    <body name="tip" pos="0 1 0"><joint name="curl"/><geom/></body>
  </body><body name="other"><joint name="idle"/><geom size="1"/></body></worldbody>
  <equality><joint joint1="curl" joint2="bend"/><joint joint1="idle" joint2="bend"/></equality>
</mujoco>"#,
    );
    write(
        "hand.xml",
        r#"<mujoco>
  <asset><model name="finger" file="finger.xml"/></asset>
  <worldbody><body name="palm"><geom size=".1"/>
    <attach model="finger" body="finger" prefix="l_"/>
    <frame pos="0 0 10" euler="0 0 90"><attach model="finger" body="finger" prefix="r_"/></frame>
  </body></worldbody>
</mujoco>"#,
    );
    let (model, left_out) = Model::read(folder.path().join("hand.xml")).unwrap();
    assert!(left_out.is_empty(), "{left_out:?}");
    let model = Arc::new(model);
    let mut data = Data::new(model.clone()).unwrap();
    data.kinematics().unwrap();
    let expected = [
        ("palm", [0.0, 0.0, 0.0]),
        ("l_finger", [1.0, 3.0, 3.0]),
        ("l_tip", [0.0, 2.0, 3.0]),
        ("r_finger", [-3.0, 1.0, 13.0]),
        ("r_tip", [-2.0, 0.0, 13.0]),
    ];
    for (g, (body, place)) in expected.into_iter().enumerate() {
        assert_eq!(model.body(model.geom_body(g)).name, Some(body));
        assert!(
            (data.geom_pose(g).translation.vector - nalgebra::Vector3::from(place)).norm() < 1e-9,
            "{body}"
        );
    }
    assert_eq!(model.joint(0).range, [-1.0, 1.0]);
    let couplings = model.equalities();
    assert_eq!(couplings.len(), 2, "{couplings:?}");
    // A file that others are attached to can be given a skin, which is written out in full.
    let output = run(folder.path(), &["skin", "hand.xml", "--receptors", "40", "--out", "felt.xml"]);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    assert_eq!(Model::from_path(folder.path().join("felt.xml")).unwrap().nbody(), 6);
}

#[test]
fn inertias_stay_and_what_weighs_too_little_is_moved_all_the_same() {
    let heavy = |newer: &str| {
        let xml = format!(
            "<mujoco>{newer}<worldbody><body name='a'><inertial mass='7' diaginertia='1 1 1'/><joint/><geom size='.1'/></body>\
             <body><joint/><body><joint/></body></body></worldbody></mujoco>"
        );
        let data = Data::new(Arc::new(Model::from_xml(&xml).unwrap())).unwrap();
        data.model().nbody()
    };
    assert_eq!(heavy(""), 4);
    assert_eq!(heavy("<newer/>"), 4);
    for scale in [1e-4, 1e-3, 1e-2, 1.0, 1e3, 1e4] {
        let xml = tiny(scale);
        let body = Body::new(Arc::new(Model::from_xml(&xml).unwrap()), &JointSelection::All).unwrap();
        assert_eq!(body.creature.dof(), 3, "{scale}");
    }
}

/// A creature of two arms, some two lengths of a metre by `scale` across.
fn tiny(scale: f64) -> String {
    let of = |length: f64| length * scale;
    let arm = |side: f64, name: &str| {
        format!(
            r#"<body name="{name}" pos="0 {} 0"><joint name="{name}" axis="0 0 1" range="-150 150"/>
            <geom type="capsule" size="{}" fromto="0 0 0 {} 0 0"/>"#,
            of(side * 0.3),
            of(0.05),
            of(0.6)
        )
    };
    format!(
        r#"<mujoco><compiler autolimits="true"/><worldbody><body name="trunk"><geom type="box" size="{0} {0} {0}"/>
        {1}<body name="hand" pos="{3} 0 0"><joint name="wrist" axis="0 0 1" range="-150 150"/>
        <geom type="capsule" size="{4}" fromto="0 0 0 {3} 0 0"/></body></body>{2}</body></body></worldbody></mujoco>"#,
        of(0.2),
        arm(1.0, "left"),
        arm(-1.0, "right"),
        of(0.6),
        of(0.05)
    )
}

#[test]
fn a_chain_deeper_than_the_engines_reader_goes_is_read() {
    let chain = |last: &str| {
        let links: String = (0..300)
            .map(|k| format!(r#"<body name="b{k}" pos=".1 0 0"><joint/><geom size=".01"/>"#))
            .collect();
        format!("<mujoco><worldbody>{links}{last}{}</worldbody></mujoco>", "</body>".repeat(300))
    };
    let found = geom_places(&chain(""));
    assert_eq!(found.len(), 300);
    assert!((found[299].1[0] - 30.0).abs() < 1e-9, "{:?}", found[299]);
    let told = Model::from_xml(&chain("<geom size='-1'/>")).map(|_| ()).unwrap_err().to_string();
    assert!(told.contains("positive"), "{told}");
    let deep = format!(
        "<mujoco><worldbody>{}{}</worldbody></mujoco>",
        "<body>".repeat(5000),
        "</body>".repeat(5000)
    );
    let told = Model::from_xml(&deep).map(|_| ()).unwrap_err().to_string();
    assert!(told.contains("more than 1000 deep"), "{told}");
}

fn rooted(xml: &str, joints: &str, root: Option<&str>) -> Result<Body, Error> {
    let model = Arc::new(Model::from_xml(xml).unwrap());
    Body::rooted(model, &joints.parse::<JointSelection>().unwrap(), root)
}

#[test]
fn a_file_for_a_newer_engine_is_read_by_itself() {
    let path = repository("tests/it/models/newer.xml");
    let (model, left_out) = Model::read(&path).unwrap();
    let joints: Vec<_> = model.joints().filter_map(|joint| joint.name.map(str::to_string)).collect();
    assert_eq!(joints, ["shoulder_y", "shoulder_x", "elbow", "other_y"]);
    for what in ["<actuator>", "<keyframe>"] {
        assert!(left_out.unneeded.contains_key(what), "{what} is not in {left_out:?}");
    }
    assert!(left_out.lost.contains_key("hereafter of <joint>, which MuJoCo does not know"), "{left_out:?}");
    let mesh =
        left_out.lost.iter().find(|(what, _)| what.contains("nor a file of that name beside the model"));
    assert_eq!(mesh.map(|(_, count)| *count), Some(1), "{left_out:?}");
    let body = Body::new(Arc::new(model), &JointSelection::All).unwrap();
    assert_eq!(body.creature.limbs(), ["base", "upper", "lower", "other"]);
    // Ranges without `limited`, as newer engines read them.
    assert_eq!(body.creature.joints()[1].dofs[0].range, [-2.5, 2.5]);
}

#[test]
fn what_the_engine_takes_is_read_as_it_is() {
    let (model, left_out) = Model::read(repository("mjcf/max/max.xml")).unwrap();
    assert!(left_out.is_empty() && left_out.in_words().is_none(), "{left_out:?}");
    // Cameras and the like are of no use to a schema, and would be gone.
    let text = std::fs::read_to_string(repository("mjcf/max/max.xml")).unwrap();
    let worse = text.replacen("<worldbody", "<nonsense/><worldbody", 1);
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("worse.xml");
    std::fs::copy(repository("mjcf/max/body.xml"), folder.path().join("body.xml")).unwrap();
    std::fs::write(&path, worse).unwrap();
    let (reduced, left_out) = Model::read(&path).unwrap();
    assert!(left_out.unneeded.contains_key("<nonsense>"), "{left_out:?}");
    let bodies = [model, reduced].map(|model| Body::new(Arc::new(model), &JointSelection::Default).unwrap());
    let [whole, reduced] = &bodies;
    assert_eq!(whole.creature, reduced.creature);
    let skins: [Skin; 2] = [whole, reduced].map(bodyschema::skin::skin_of);
    assert_eq!(skins[0].receptors.len(), skins[1].receptors.len());
    for (a, b) in skins[0].receptors.iter().zip(&skins[1].receptors) {
        assert!((a.position - b.position).norm() < 1e-12 && (a.normal - b.normal).norm() < 1e-12, "{}", a.id);
    }
    let relations = bodies.each_ref().map(|body| {
        let contact = SelfContact::new(body).unwrap();
        contact.pairs.iter().map(|pair| (pair.limbs, pair.relation)).collect::<Vec<_>>()
    });
    assert_eq!(relations[0], relations[1]);
}

#[test]
fn the_command_line_tells_what_was_left_out() {
    let path = repository("tests/it/models/newer.xml");
    let (here, path) = (Path::new("."), path.to_str().unwrap());
    let told = |arguments: &[&str]| {
        let output = run(here, arguments);
        let [out, message] = [output.stdout, output.stderr].map(|text| String::from_utf8(text).unwrap());
        assert_eq!(output.status.code(), Some(0), "{message}");
        (out, message)
    };
    let (out, _) = told(&["inspect", path]);
    assert!(out.contains("newer: 3 joints") && out.contains("not needed: <actuator>"), "{out}");
    let (out, _) = told(&["inspect", path, "--json"]);
    let json: serde_json::Value = serde_json::from_str(&out).unwrap();
    assert_eq!(json["left_out"]["unneeded"]["<actuator>"], 1, "{out}");
    // Whoever opens the file is told in one line.
    let babbling =
        run(here, &["babble", path, "--touches", "1", "--joints", "elbow", "--out", "/nonexistent/session"]);
    let message = String::from_utf8(babbling.stderr).unwrap();
    let note = message.lines().find(|line| line.contains("was read without")).unwrap_or(&message);
    assert!(note.contains("geom of the mesh") && note.contains("kinds of part that"), "{message}");
}

#[test]
fn a_refusal_names_the_line_in_the_users_own_file() {
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, text: &str| std::fs::write(folder.path().join(name), text).unwrap();
    write(
        "part.xml",
        "<mujocoinclude>\n<worldbody>\n<body name='p'>\n<geom size='-1'/></body></worldbody></mujocoinclude>",
    );
    write("broken.xml", "<mujoco><worldbody>\n<body><geom size='1 2 3 4'/></body></worldbody></mujoco>");
    write(
        "arm.xml",
        "<mujoco model='arm'><worldbody>\n<body name='b'><joint/>\n<geom size='.1'/></body></worldbody></mujoco>",
    );
    let world = |inside: &str| {
        format!(
            "<mujoco>\n<newer/>\n<worldbody>\n<body name='a'><joint/>\n{inside}\n<geom size='.1'/></body></worldbody></mujoco>"
        )
    };
    let attach = "</body></worldbody><asset>\n<model name='arm' file='arm.xml'/></asset><worldbody><body><geom size='1'/>\n";
    let cases = [
        (world("<geom size='-1'/>"), "main.xml, line 5", "above 0"),
        (world("<joint axis='0 0 0'/>"), "main.xml, line 5", "not zero"),
        (world("<joint axis='1 0'/>"), "main.xml, line 5", "give it 3"),
        (world("<geom size='1e30'/>"), "main.xml, line 5", "smaller"),
        (world("<replicate><geom size='.1'/></replicate>"), "main.xml, line 5", "count"),
        (
            world("<replicate count='9000'><replicate count='9000'><geom size='1'/></replicate></replicate>"),
            "main.xml, line 5",
            "smaller count",
        ),
        (world("<frame>\n<geom size='-1'/></frame>"), "main.xml, line 6", "above 0"),
        (world("<attach model='leg'/>"), "main.xml, line 5", "<model name=\"leg\""),
        (
            world(&format!("{attach}<attach model='arm' body='leg'/>")),
            "main.xml, line 7",
            "arm.xml does not have",
        ),
        (
            world("</body></worldbody><include file='part.xml'/><worldbody><body>"),
            "part.xml, line 4",
            "above 0",
        ),
        (
            world("</body></worldbody><include file='gone.xml'/><worldbody><body>"),
            "main.xml, line 5",
            "gone.xml",
        ),
        // Errors of what is attached are in its own file.
        (
            world(
                "</body></worldbody><asset><model name='arm' file='broken.xml'/></asset><worldbody><body>\n<attach model='arm'/>",
            ),
            "broken.xml, line 2",
            "fewer numbers",
        ),
        (world("<attach/>"), "main.xml, line 5", "names no model"),
        (
            world("<replicate count='2.5'><geom size='1'/></replicate>"),
            "main.xml, line 5",
            "not a whole number",
        ),
        (
            world("<replicate count='2'><body name='z'><geom size='1'/></body></replicate><body name='z0'/>"),
            "main.xml, line 5",
            "repeated name",
        ),
        (world("</body></worldbody><body/><worldbody><body>"), "main.xml, line 5", "outside <worldbody>"),
        (
            world("</body></worldbody><option gravity='0 1'/><worldbody><body>"),
            "main.xml, line 5",
            "more numbers",
        ),
        (
            world(
                "<site name='s'/></body></worldbody><sensor>\n<touch site='s'/><touch site='s' cutoff='-1'/></sensor><worldbody><body>",
            ),
            "main.xml, line 6",
            "of 0 or above",
        ),
        (world("<body>"), "main.xml, line 6", "malformed"),
        (world("a\u{1}b"), "main.xml, line 5", "that XML does not allow"),
        ("<mujoco/>\n<!-- a remark -->\n <mujoco/>".into(), "main.xml, line 3", "content after </mujoco>"),
        ("<mujoco/>\n\nmore".into(), "main.xml, line 3", "content after </mujoco>"),
        ("<mujoco>\n\n<worldbody>".into(), "main.xml, line 3", "not closed"),
        ("<svg/>".into(), "main.xml, line 1", "<robot>"),
        ("<mujocoinclude/>".into(), "main.xml, line 1", "includes it"),
        (String::new(), "main.xml", "no XML"),
    ];
    for (xml, place, mend) in cases {
        write("main.xml", &xml);
        let told = Model::from_path(folder.path().join("main.xml")).map(|_| ()).unwrap_err().to_string();
        assert!(told.contains(place) && told.contains(mend) && told.lines().count() == 1, "{xml}\n{told}");
    }
    // The program says the same, and nothing of an option that there was.
    let broken = refused(folder.path(), 1, &["inspect", "main.xml"]);
    assert!(broken.contains("main.xml") && !broken.contains("--strip"), "{broken}");
}

#[test]
fn what_is_wrong_in_numbers_words_and_classes_is_refused_in_every_reading() {
    // The new element has the file put in plain terms, where no engine checks what is written out before it.
    let world = |class: &str, inside: &str| {
        format!(
            "<mujoco>\n<newer/><compiler angle='degree'/><default>{class}</default><worldbody><body>\n{inside}\n\
             <joint/><geom size='.1'/></body></worldbody></mujoco>"
        )
    };
    for (wrong, mend) in [
        ("<body name='b' pos='0 .2'/>", "pos of <body> b has 2 numbers; give it 3"),
        ("<body pos='here'/>", "\"here\" in pos of <body> is not a number"),
        ("<body pos='0,1 0 0'/>", "decimal points"),
        ("<body quat='0 0 0 0'/>", "no direction"),
        ("<geom size='.1' zaxis='0 0 0'/>", "no direction"),
        ("<geom size='.1' xyaxes='1 0 0 2 0 0'/>", "no direction"),
        ("<geom size='.1' euler='0 0 1' quat='1 0 0 0'/>", "rotated by both quat and euler"),
        ("<geom type='cube' size='.1'/>", "sphere"),
        ("<joint name='j' range='-1'/>", "range of <joint> j has 1 number; give it 2"),
        ("<joint range='-inf inf'/>", "not a finite number"),
        ("<joint armature='nan'/>", "not a finite number"),
        ("<joint limited='yes'/>", "true, false or auto"),
        ("<joint type='revolute'/>", "hinge"),
        ("<joint class='gone'/>", "class=\"gone\" of <joint> names no <default>"),
        ("<body childclass='gone'/>", "names no <default>"),
        ("<frame childclass='gone'/>", "names no <default>"),
        ("<frame pos='0 0'/>", "give it 3"),
        ("<frame euler='x 0 0'/>", "not a number"),
        ("<replicate count='2' offset='1'/>", "give it 3"),
    ] {
        let told = Model::from_xml(&world("", wrong)).map(|_| ()).unwrap_err().to_string();
        assert!(
            told.contains("line 3") && told.contains(mend) && told.lines().count() == 1,
            "{wrong}\n{told}"
        );
    }
    for (class, mend) in [
        ("<geom density='heavy'/>", "\"heavy\" in density of <geom> is not a number"),
        ("<joint axis='0 1'/>", "give it 3"),
        ("<default><joint/></default>", "has no class"),
        ("<default class='a'/><default class='a'/>", "two classes a"),
    ] {
        let told = Model::from_xml(&world(class, "")).map(|_| ()).unwrap_err().to_string();
        assert!(told.contains("line 2") && told.contains(mend), "{class}\n{told}");
    }
    let told = |compiler: &str| {
        let xml = world("", "").replace("<compiler angle='degree'/>", compiler);
        Model::from_xml(&xml).map(|_| ()).unwrap_err().to_string()
    };
    assert!(told("<compiler angle='grad'/>").contains("degree or radian"));
    assert!(told("<compiler eulerseq='xyq'/>").contains("not an order of axes"));
    // What no class can be of is told of, and nothing is an empty attribute.
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("odd.xml");
    std::fs::write(&path, world("<jont axis='0 1 0'/>", "<frame foo='1'/><joint axis=''/>")).unwrap();
    let (_, left_out) = Model::read(&path).unwrap();
    for what in ["<jont> in <default>", "foo of <frame>, which MuJoCo does not know"] {
        assert!(left_out.lost.contains_key(what), "{what} is not in {left_out:?}");
    }
}

#[test]
fn text_that_is_not_in_utf_8_is_told_by_its_encoding() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("wide.xml");
    let wide = "\u{feff}<mujoco/>".encode_utf16().flat_map(u16::to_le_bytes).collect::<Vec<u8>>();
    std::fs::write(&path, wide).unwrap();
    let told = Model::from_path(&path).map(|_| ()).unwrap_err().to_string();
    assert!(told.contains("save it in UTF-8"), "{told}");
}

#[test]
fn of_a_mesh_whose_faces_or_kind_the_engine_refuses_the_hull_is_left() {
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, text: &str| std::fs::write(folder.path().join(name), text).unwrap();
    let corners = "v 0 0 0\nv .1 0 0\nv 0 .2 0\nv 0 0 .3\n";
    let vertices = corners.replace('v', "vertex");
    // Faces of no area, an STL of text, and PLY.
    write("mesh.obj", &format!("{corners}f 1 1 1\nf 2 2 2\n"));
    write("mesh.stl", &format!("solid a\n{vertices}{vertices}{vertices}endsolid a\n"));
    write(
        "mesh.ply",
        &format!(
            "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\nend_header\n{}",
            corners.replace("v ", "")
        ),
    );
    let xml = |file: &str| {
        format!(
            "<mujoco>\n<asset><mesh name='m' file='{file}' scale='2 2 2'/></asset><worldbody><body name='b'><joint/>\n\
             <geom type='mesh' mesh='m' pos='0 0 1'/></body></worldbody></mujoco>"
        )
    };
    let read = |file: &str| {
        write("main.xml", &xml(file));
        Model::read(folder.path().join("main.xml"))
    };
    for file in ["mesh.obj", "mesh.stl", "mesh.ply"] {
        let (model, left_out) = read(file).unwrap();
        assert!(left_out.lost.is_empty(), "{file}: {left_out:?}");
        let model = Arc::new(model);
        let mut data = Data::new(model.clone()).unwrap();
        data.kinematics().unwrap();
        let pose = data.geom_pose(0);
        let heights = model.mesh_vertices(0).into_iter().map(|v| (pose * nalgebra::Point3::from(v)).z);
        let top = heights.fold(f64::MIN, f64::max);
        assert!((top - 1.6).abs() < 1e-6, "{file}: {top}");
    }
    // What cannot be read is told with the engine's reason.
    write("cut.stl", "solid");
    let (_, left_out) = read("cut.stl").unwrap();
    let told: Vec<&String> = left_out.lost.keys().collect();
    assert!(told[0].contains("mesh m, which this MuJoCo rejects: ") && told.len() == 1, "{told:?}");
    if !is_newer_engine() {
        // This crashes the engine.
        write("text.obj", "v a b c\nv 1 2\n");
        write("main.xml", &xml("text.obj"));
        let told = refused(folder.path(), 1, &["inspect", "main.xml"]);
        assert!(told.contains("main.xml, line 2: the mesh ") && told.contains("text.obj"), "{told}");
    }
}

const TWO: &str = r#"<mujoco>
  <worldbody>
    <body name="big"><geom size=".1"/>
      <body name="big_arm" pos="1 0 0"><joint name="a"/><geom size=".1"/>
        <body name="big_hand" pos="1 0 0"><joint name="b"/><geom size=".1"/>
          <body name="big_finger" pos="1 0 0"><joint name="c"/><geom size=".1"/></body>
        </body>
      </body>
    </body>
    <body name="small" pos="0 5 0"><freejoint/><geom size=".1"/>
      <body name="small_arm" pos="1 0 0"><joint name="d"/><geom size=".1"/></body>
    </body>
  </worldbody>
</mujoco>"#;

#[test]
fn of_several_creatures_the_root_chooses() {
    let limbs = |root| rooted(TWO, "all", root).unwrap().creature.limbs().to_vec();
    assert_eq!(limbs(None), ["big", "big_arm", "big_hand", "big_finger"]);
    assert_eq!(limbs(Some("small")), ["small", "small_arm"]);
    // A body in the middle of a tree is a root that stands still.
    assert_eq!(limbs(Some("big_arm")), ["big_arm", "big_hand", "big_finger"]);
    let wrong = rooted(TWO, "all", Some("nobody")).unwrap_err().to_string();
    assert!(wrong.contains("nobody") && wrong.contains("big, small"), "{wrong}");
    let still = rooted(TWO, "all", Some("big_finger")).unwrap_err();
    assert!(still.is_model() && still.to_string().contains("no hinge, slide or ball joint"), "{still}");
}

#[test]
fn other_creatures_in_a_file_are_told_of_and_props_are_none() {
    let folder = tempfile::tempdir().unwrap();
    let ball = r#"<body name="ball" pos="0 9 0"><freejoint/><geom size=".1"/></body></worldbody>"#;
    std::fs::write(folder.path().join("two.xml"), TWO.replace("</worldbody>", ball)).unwrap();
    let output = run(folder.path(), &["inspect", "two.xml", "--json"]);
    let json: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    let expected = serde_json::json!([{"root": "big", "joints": 3}, {"root": "small", "joints": 1}]);
    assert_eq!(json["creatures"], expected);
    let note = |arguments: &[&str]| {
        let arguments = [&["babble", "two.xml", "--touches", "3", "--out"], arguments].concat();
        String::from_utf8(run(folder.path(), &arguments).stderr).unwrap()
    };
    let told = note(&["one"]);
    assert!(told.contains("this is big (3 joints). --root selects another of small (1 joints)"), "{told}");
    assert!(!told.contains("ball"), "{told}");
    assert!(!note(&["other", "--root", "big"]).contains("several creatures"));
    for command in [&["skin", "--out", "skin.xml"][..], &["skin", "feel"], &["study", "learners"]] {
        let told = refused(folder.path(), 1, &[command, &["--root", "nobody", "two.xml"]].concat());
        assert!(told.contains("nobody") && told.contains("big, small"), "{told}");
    }
    let skin =
        run(folder.path(), &["skin", "two.xml", "--root", "small", "--receptors", "20", "--out", "skin.xml"]);
    assert!(skin.status.success(), "{}", String::from_utf8_lossy(&skin.stderr));
    let text = std::fs::read_to_string(folder.path().join("skin.xml")).unwrap();
    assert!(text.contains("small_arm_") && !text.contains("big_hand_"), "{text}");
}

const COUPLED: &str = r#"<mujoco>
  <compiler angle="radian" autolimits="true"/>
  <worldbody>
    <body name="palm"><geom size=".01"/>
      <body name="first"><joint name="knuckle" range="-1 1.5" ref="0.2"/><geom size=".01"/>
        <body name="second"><joint name="tip" range="-0.1 0.9" ref="0.1"/><geom size=".01"/></body>
      </body>
      <body name="still"><joint name="still" range="-1 1"/><geom size=".01"/></body>
    </body>
  </worldbody>
  <equality>
    <joint joint1="tip" joint2="knuckle" polycoef="0.05 0.5 0 0 0"/>
    <joint joint1="still" polycoef="0.25 0 0 0 0"/>
  </equality>
</mujoco>"#;

/// The dof of a creature called `name`, and its coordinate in a posture of hinges.
fn coordinate(creature: &Creature, posture: &[f64], name: &str) -> f64 {
    posture[creature.dofs().position(|dof| dof.name == name).unwrap()]
}

#[test]
fn joints_that_follow_others_follow_them_in_every_posture() {
    let body = creature(COUPLED);
    let creature = &body.creature;
    let mut rng = ChaCha8Rng::seed_from_u64(1);
    for _ in 0..100 {
        let posture = Posture::random(creature, &mut rng);
        let [knuckle, tip, still] =
            ["knuckle", "tip", "still"].map(|name| coordinate(creature, &posture, name));
        // MuJoCo counts both from the reference posture, as the creature does.
        assert!((tip - (0.05 + 0.5 * knuckle)).abs() < 1e-12, "{knuckle} {tip}");
        assert_eq!(still, 0.25);
        let dof = creature.dofs().find(|dof| dof.name == "tip").unwrap();
        assert!(dof.range[0] - 1e-9 <= tip && tip <= dof.range[1] + 1e-9, "{tip} {:?}", dof.range);
    }
    // The leader's range ends where its follower's does: (-0.2 - 0.05) / 0.5.
    let knuckle = creature.dofs().find(|dof| dof.name == "knuckle").unwrap();
    assert!((knuckle.range[0] + 0.5).abs() < 0.01, "{:?}", knuckle.range);
    let json = serde_json::to_string(creature).unwrap();
    assert_eq!(&serde_json::from_str::<Creature>(&json).unwrap(), creature);
}

/// A chain of hinges, coupled as given.
fn chained(couplings: &str) -> String {
    format!(
        r#"<mujoco><compiler angle="radian" autolimits="true"/><worldbody><body name="palm"><geom size=".01"/>
        <body name="1"><joint name="a" range="-1 1"/><geom size=".01"/><body name="2"><joint name="b" range="-2 2"/>
        <geom size=".01"/><body name="3"><joint name="c" range="-.5 2"/><geom size=".01"/></body></body></body></body>
        </worldbody><equality>{couplings}</equality></mujoco>"#
    )
}

#[test]
fn what_follows_a_follower_follows_its_leader() {
    // In either order of the file: b = 0.1 + a², c = 0.5 - 2 b = 0.3 - 2 a².
    let [b, c] = [
        r#"<joint joint1="b" joint2="a" polycoef="0.1 0 1 0 0"/>"#,
        r#"<joint joint1="c" joint2="b" polycoef="0.5 -2 0 0 0"/>"#,
    ];
    for couplings in [format!("{b}{c}"), format!("{c}{b}")] {
        let body = creature(&chained(&couplings));
        let creature = &body.creature;
        let mut rng = ChaCha8Rng::seed_from_u64(1);
        for _ in 0..50 {
            let posture = Posture::random(creature, &mut rng);
            let [a, b, c] = ["a", "b", "c"].map(|name| coordinate(creature, &posture, name));
            assert!((b - (0.1 + a * a)).abs() < 1e-12 && (c - (0.5 - 2.0 * b)).abs() < 1e-12, "{a} {b} {c}");
        }
        // c ends at -0.5, where a² is 0.4.
        let a = creature.dofs().find(|dof| dof.name == "a").unwrap();
        assert!((a.range[1] - 0.4f64.sqrt()).abs() < 0.01, "{:?}", a.range);
    }
}

#[test]
fn couplings_that_cannot_be_followed_are_told_by_their_joints() {
    let told = |couplings: &str| rooted(&chained(couplings), "all", None).unwrap_err().to_string();
    let circle =
        told(r#"<joint joint1="a" joint2="b"/><joint joint1="b" joint2="c"/><joint joint1="c" joint2="a"/>"#);
    assert!(circle.contains("a, b, c") && circle.contains("loop"), "{circle}");
    let steep = told(
        r#"<joint joint1="b" joint2="a" polycoef="0 0 0 1 0"/><joint joint1="c" joint2="b" polycoef="0 0 1 0 0"/>"#,
    );
    assert!(steep.contains("joint c follows a") && steep.contains("degree 6"), "{steep}");
}

#[test]
fn who_follows_a_joint_that_is_held_is_held_as_well() {
    let body = rooted(COUPLED, "tip", None).unwrap();
    let tip = body.creature.dofs().next().unwrap();
    assert_eq!((tip.range, tip.follows), ([0.05, 0.05], None));
}

/// Three capsules on a trunk, filters as given.
fn trident(geom: &str, contact: &str) -> Body {
    creature(&format!(
        r#"<mujoco>
  <compiler angle="degree" autolimits="true"/>
  <default><geom type="capsule" size=".03" {geom}/><joint axis="0 1 0" range="-170 170"/></default>
  <worldbody>
    <geom type="plane" size="1 1 1" contype="1" conaffinity="1"/>
    <body name="trunk"><geom fromto="0 0 -.2 0 0 .2"/>
      <body name="neck" pos="0 0 .2"><joint name="neck" range="-20 20"/><geom fromto="0 0 0 0 0 .1"/>
        <body name="head" pos="0 0 .1"><joint name="head" range="-20 20"/><geom fromto="0 0 -.15 0 0 .1"/></body>
      </body>
      <body name="left" pos="0 .05 .1"><joint name="left"/><geom fromto="0 0 0 .2 -.05 0"/>
        <body name="left_hand" pos=".2 -.05 0"><joint name="left_hand"/><geom fromto="0 0 0 .2 -.02 0"/></body>
      </body>
    </body>
  </worldbody>
  {contact}
</mujoco>"#
    ))
}

fn relation(body: &Body, a: &str, b: &str) -> (Relation, bool) {
    let contact = SelfContact::new(body).unwrap();
    let limbs = [a, b].map(|name| body.creature.limb(name).unwrap());
    let pair =
        contact.pairs.into_iter().find(|pair| pair.limbs == limbs || pair.limbs == [limbs[1], limbs[0]]);
    pair.map(|pair| (pair.relation, pair.switched_on)).unwrap()
}

#[test]
fn self_contact_that_a_model_forgot_is_switched_on() {
    let open = trident("", "");
    assert_eq!(relation(&open, "trunk", "left_hand"), (Relation::Touch, false));
    assert_eq!(relation(&open, "trunk", "left"), (Relation::Neighbours, false));
    assert_eq!(relation(&open, "trunk", "head"), (Relation::Overlap, false));
    for filters in [r#"contype="0" conaffinity="0""#, r#"contype="1" conaffinity="0""#] {
        let shut = trident(filters, "");
        assert_eq!(relation(&shut, "trunk", "left_hand"), (Relation::Touch, true), "{filters}");
        assert_eq!(relation(&shut, "trunk", "head"), (Relation::Overlap, false), "{filters}");
    }
}

#[test]
fn an_exclude_holds_unless_a_limb_has_nothing_else_to_touch() {
    let one = trident("", r#"<contact><exclude body1="trunk" body2="left_hand"/></contact>"#);
    assert_eq!(relation(&one, "trunk", "left_hand"), (Relation::Excluded, false));
    assert_eq!(relation(&one, "head", "left_hand"), (Relation::Touch, false));
    let names = ["trunk", "neck", "head"];
    let all: String =
        names.iter().map(|name| format!(r#"<exclude body1="{name}" body2="left_hand"/>"#)).collect();
    let all = trident("", &format!("<contact>{all}</contact>"));
    assert_eq!(relation(&all, "trunk", "left_hand"), (Relation::Touch, true));
}

#[test]
fn a_body_that_is_tangled_where_its_joints_are_zero_starts_elsewhere() {
    let xml = |pos: &str| {
        format!(
            r#"<mujoco><compiler autolimits="true"/><worldbody><body name="trunk"><geom size=".01"/>
            <body name="a"><joint axis="0 0 1" name="a" range="-90 90"/><geom type="capsule" size=".02" fromto="0 0 0 .3 0 0"/></body>
            <body name="b" pos="{pos}"><joint axis="0 0 1" name="b" range="-90 90"/><geom type="capsule" size=".02" fromto="0 0 0 0 .3 0"/></body>
            <body name="far" pos="0 0 3"><joint axis="0 0 1" name="far" range="-90 90"/><geom size=".02"/></body>
            </body></worldbody></mujoco>"#
        )
    };
    let zero = |posture: &[f64]| posture.iter().all(|&q| q == 0.0);
    let (apart, tangled) = (creature(&xml(".1 .1 0")), creature(&xml(".25 -.25 0")));
    assert!(zero(&SelfContact::new(&apart).unwrap().start));
    let contact = SelfContact::new(&tangled).unwrap();
    // Of the three joints one is turned, and no farther than it takes.
    let turned: Vec<f64> = contact.start.iter().copied().filter(|&q| q != 0.0).collect();
    assert!(turned.len() == 1 && turned[0].abs() < 1.0 && contact.start[2] == 0.0, "{:?}", contact.start);
    assert_eq!(relation(&tangled, "a", "b"), (Relation::Touch, false));
}

#[test]
fn a_trunk_that_stands_still_is_part_of_what_hangs_on_it() {
    let xml = |setting: &str| {
        format!(
            r#"<mujoco><compiler {setting}/><worldbody><body name="fly"><body name="thorax"><geom size=".1"/>
            <body name="left" pos="0 .2 0"><joint name="left" axis="1 0 0"/><geom size=".05"/></body>
            <body name="right" pos="0 -.2 0"><joint name="right" axis="1 0 0"/><geom size=".05"/></body>
            </body></body></worldbody></mujoco>"#
        )
    };
    for setting in ["", r#"fusestatic="true""#, r#"discardvisual="true""#] {
        let model = Model::from_xml(&xml(setting)).unwrap();
        let found: Vec<(String, usize)> =
            creatures(&model).into_iter().map(|creature| (creature.name, creature.joints)).collect();
        assert_eq!(found, [("fly".to_string(), 2)], "{setting}");
    }
}

/// The engine's compiler would take all memory and time that there is.
#[test]
fn a_file_that_keeps_the_engine_busy_is_given_up() {
    let folder = tempfile::tempdir().unwrap();
    let xml = r#"<mujoco><worldbody><body><composite type="particle" count="400 400 400" spacing="0.1">
        <geom size="0.01"/></composite></body></worldbody></mujoco>"#;
    std::fs::write(folder.path().join("endless.xml"), xml).unwrap();
    // Who may compute for two seconds alone gives the engine no longer.
    let mut shell = std::process::Command::new("bash");
    shell.args(["-c", r#"ulimit -t 2; exec "$0" inspect endless.xml"#, env!("CARGO_BIN_EXE_bodyschema")]);
    let output = shell.current_dir(folder.path()).output().unwrap();
    let said = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(1), "{said}");
    assert!(said.contains("endless.xml: MuJoCo did not finish loading it within 2 s"), "{said}");
}

#[test]
fn numbers_on_which_the_engine_crashes_or_never_returns_are_named_with_their_line() {
    let refusal = |xml: &str| Model::from_xml(xml).map(|_| ()).unwrap_err().to_string();
    let texture = refusal("<mujoco><asset>\n<texture width=\"999999999\"/></asset></mujoco>");
    assert!(texture.contains("line 2") && texture.contains("width"), "{texture}");
    for value in ["1e30", "-1e30", "nan", "inf", "0 1e30", "1e30m", "&#49;e30"] {
        let message = refusal(&format!("<mujoco><worldbody><geom size='{value}'/></worldbody></mujoco>"));
        assert!(message.contains("size"), "{message}");
    }
    let geom = refusal("<mujoco><worldbody><geom fromto = '0 0 0 0 0 1e30'/></worldbody></mujoco>");
    assert!(geom.contains("fromto"), "{geom}");
    assert!(refusal("<mujoco><size nuser_body='999999999'/></mujoco>").contains("nuser_body"));
    for setting in
        ["timestep='1e-300'", "timestep='0'", "timestep='-1'", "timestep='nan'", "timestep='1e300'"]
    {
        assert!(refusal(&format!("<mujoco><option {setting}/></mujoco>")).contains("timestep"), "{setting}");
    }
    for setting in ["iterations='2000000000'", "noslip_iterations='2000000000'", "mpr_iterations='-5'"] {
        assert!(
            refusal(&format!("<mujoco><option {setting}/></mujoco>")).contains("iterations"),
            "{setting}"
        );
    }
    let bodies = format!("<mujoco><worldbody>{}</worldbody></mujoco>", "<body/>".repeat(100_000));
    assert!(refusal(&bodies).contains("100000 elements <body>"));
    Model::from_xml(
        "<mujoco><!-- size=\"1e30\" ---- --><option timestep='0.002' iterations='100' noslip_iterations='0'/><asset>
        <texture name='t' type='2d' builtin='flat' width='512' height=\"512\"/></asset><worldbody>
        <geom type='box' size=\"1 2 3\" pos='-5 0 1e3' name=\"a>b\"/></worldbody></mujoco>",
    )
    .unwrap();
}
