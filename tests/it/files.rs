//! Files as people have them: whatever can be meant by one is read, alike by every command, and what is read otherwise than it
//! stands there is told.

use std::io::Write;
use std::path::Path;
use std::sync::Arc;

use crate::common::calibrating::Place;
use crate::common::program::{refused, run, succeeds};
use crate::common::repository;
use bodyschema::agent::Agent;
use bodyschema::creature::{Body, JointSelection};
use bodyschema::model_files::LeftOut;
use bodyschema::mujoco::Model;
use bodyschema::session::{Recording, read_creature, read_recording, read_robot};
use flate2::Compression;
use flate2::write::GzEncoder;
use serde_json::{Value, json};

/// An arm of three hinges, the last of which carries a link that may be given another shape.
const ARM: &str = r#"<robot name="arm">
  <link name="base"><collision><geometry><cylinder radius="0.05" length="0.2"/></geometry></collision></link>
  <joint name="j1" type="revolute"><parent link="base"/><child link="l1"/><origin xyz="0 0 0.2"/>
    <axis xyz="0 0 1"/><limit lower="-2.5" upper="2.5" effort="1" velocity="1"/></joint>
  <link name="l1"><collision><origin xyz="0 0 0.1"/><geometry><box size="0.06 0.06 0.1"/></geometry></collision></link>
  <joint name="j2" type="revolute"><parent link="l1"/><child link="l2"/><origin xyz="0 0 0.3"/>
    <axis xyz="0 1 0"/><limit lower="-2" upper="2" effort="1" velocity="1"/></joint>
  <link name="l2"><collision><origin xyz="0 0 0.15"/><geometry><sphere radius="0.04"/></geometry></collision></link>
  <joint name="j3" type="revolute"><parent link="l2"/><child link="l3"/><origin xyz="0 0 0.3"/>
    <axis xyz="0 1 0"/><limit lower="-2" upper="2" effort="1" velocity="1"/></joint>
  <link name="l3"><collision><origin xyz="0 0 0.06"/><geometry><sphere radius="0.04"/></geometry></collision></link>
</robot>"#;

/// A tetrahedron as STL.
fn stl() -> Vec<u8> {
    let corners = [[0.0f32, 0.0, 0.0], [0.1, 0.0, 0.0], [0.0, 0.1, 0.0], [0.0, 0.0, 0.1]];
    let mut bytes = vec![0u8; 80];
    bytes.extend(4u32.to_le_bytes());
    for face in [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]] {
        bytes.extend([0.0f32; 3].iter().flat_map(|x| x.to_le_bytes()));
        bytes.extend(face.iter().flat_map(|&k: &usize| corners[k]).flat_map(f32::to_le_bytes));
        bytes.extend([0u8; 2]);
    }
    bytes
}

fn write(path: &Path, bytes: impl AsRef<[u8]>) {
    std::fs::create_dir_all(path.parent().unwrap()).unwrap();
    std::fs::write(path, bytes).unwrap();
}

/// A model of a text, with its creature and what was said of it.
fn read(name: &str, text: &str) -> (Body, LeftOut) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join(name);
    write(&path, text);
    let (model, left_out) = Model::read(&path).unwrap();
    (Body::new(Arc::new(model), &JointSelection::All).unwrap(), left_out)
}

/// What `calibrate` takes a text for.
fn robot(name: &str, text: &str) -> Result<bodyschema::session::RobotFile, String> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join(name);
    write(&path, text);
    read_robot(&path).map_err(|error| error.to_string())
}

#[test]
fn limits_that_are_none_are_taken_for_none_by_all_and_told() {
    let pi = std::f64::consts::PI;
    let free = [-pi, pi];
    for (limits, expected, told) in [
        (["-1e16", "1e16"], free, "-1e16 to 1e16, are ignored"),
        (["-1e38", "1e38"], free, "are ignored"),
        (["-inf", "inf"], free, "-inf to inf, are ignored"),
        (["-Infinity", "+Infinity"], free, "are ignored"),
        (["2.5", "-2.5"], free, "2.5 to -2.5, are ignored"),
        (["0.5", "0.5"], free, "0.5 to 0.5, are ignored"),
        (["0", "0"], free, "0.0 to 0.0, are ignored"),
        (["-1.5", "1e16"], [-1.5, 2.0 * pi - 1.5], "are read as -1.500 to 4.783"),
        (["-inf", "1"], [1.0 - 2.0 * pi, 1.0], "are read as -5.283 to 1.000"),
        (["-2.5", "2.5"], [-2.5, 2.5], ""),
    ] {
        let [lower, upper] = limits;
        let limits = format!("lower=\"{lower}\" upper=\"{upper}\"");
        let text = ARM.replace("lower=\"-2.5\" upper=\"2.5\"", &limits);
        let (body, left_out) = read("arm.urdf", &text);
        let robot = robot("arm.urdf", &text).unwrap();
        let ranges = [body.creature.joints()[0].dofs[0].range, robot.robot.dofs[0].range];
        for range in ranges {
            assert!((0..2).all(|k| (range[k] - expected[k]).abs() < 1e-12), "{limits}: {range:?}");
        }
        for notes in [&left_out.notes, &robot.notes] {
            let noted = notes.iter().any(|note| note.contains("limits of joint j1") && note.contains(told));
            assert_eq!(noted, !told.is_empty(), "{limits}: {notes:?}");
        }
    }
    let folder = tempfile::tempdir().unwrap();
    write(&folder.path().join("arm.urdf"), ARM.replace("lower=\"-2.5\"", "lower=\"nan\""));
    assert!(refused(folder.path(), 1, &["inspect", "arm.urdf"]).contains("is not a finite number"));
    // A file of MJCF may have them, too.
    let (body, left_out) = read(
        "arm.xml",
        "<mujoco><worldbody><body name='a'><geom size='.1'/><body name='b' pos='1 0 0'><joint name='j' type='slide' limited='true' \
         range='-1e16 1e16'/><geom size='.1'/></body></body></worldbody></mujoco>",
    );
    assert_eq!(body.creature.joints()[0].dofs[0].range, [-0.5, 0.5]);
    assert!(left_out.notes[0].contains("limits of joint j, -1e16 to 1e16"), "{:?}", left_out.notes);
}

#[test]
fn turns_in_degrees_are_noted_by_whoever_reads_them() {
    for (from, to, title) in [
        (
            "<origin xyz=\"0 0 0.3\"/>\n    <axis xyz=\"0 1 0\"/>",
            "<origin xyz=\"0 0 0.3\" rpy=\"0 90 0\"/>",
            "joint j2",
        ),
        ("<origin xyz=\"0 0 0.15\"/>", "<origin xyz=\"0 0 0.15\" rpy=\"0 0 -180\"/>", "link l2"),
        ("<origin xyz=\"0 0 0.1\"/>", "<origin rpy=\"45 0 0\" xyz=\"0 0 0.1\"/>", "link l1"),
    ] {
        let text = ARM.replacen(from, to, 1);
        let (_, left_out) = read("arm.urdf", &text);
        let words = format!("of {title} is more than a turn: give radians, not degrees");
        assert!(left_out.notes.iter().any(|note| note.contains(&words)), "{:?}", left_out.notes);
        assert!(robot("arm.urdf", &text).unwrap_err().contains(&words));
    }
    assert!(
        read("arm.urdf", &ARM.replace("<origin xyz=\"0 0 0.15\"/>", "<origin rpy=\"0 6.28 0\"/>"))
            .1
            .notes
            .is_empty()
    );
    // Whoever inspects or babbles is told.
    let folder = tempfile::tempdir().unwrap();
    write(
        &folder.path().join("arm.urdf"),
        ARM.replace("<origin xyz=\"0 0 0.15\"/>", "<origin rpy=\"0 90 0\"/>"),
    );
    let told = "rpy=\"0 90 0\" of link l2 is more than a turn";
    assert!(succeeds(folder.path(), &["inspect", "arm.urdf"]).contains(told));
    let babbling = ["babble", "arm.urdf", "--touches", "3", "--out", "s"];
    assert!(String::from_utf8_lossy(&run(folder.path(), &babbling).stderr).contains(told));
}

/// The arm with a mesh for its last link but one.
fn meshed(shape: &str) -> String {
    ARM.replace(
        "<collision><origin xyz=\"0 0 0.15\"/><geometry><sphere radius=\"0.04\"/></geometry></collision>",
        shape,
    )
}

fn collision(file: &str) -> String {
    format!("<collision><geometry><mesh filename=\"{file}\"/></geometry></collision>")
}

#[test]
fn meshes_are_found_where_people_have_them() {
    for (written, lies) in [
        ("package://arm_description/meshes/l2.stl", "l2.stl"),
        ("package://arm/meshes/visual/l2.stl", "meshes/l2.stl"),
        ("package://arm/meshes/visual/l2.stl", "visual/l2.stl"),
        ("package://arm/meshes/l2.stl", "../meshes/l2.stl"),
        ("package://arm/my%20meshes/l2.stl", "../my meshes/l2.stl"),
        ("model://arm/meshes/l2.stl", "../meshes/l2.stl"),
        ("meshes/l2%2B.stl", "meshes/l2+.stl"),
        ("file://HERE/my%20meshes/l2.stl", "my meshes/l2.stl"),
        ("file://localhost/HERE/l2.stl", "l2.stl"),
        ("meshes\\l2.stl", "meshes/l2.stl"),
        ("C:\\robots\\arm\\meshes\\l2.stl", "meshes/l2.stl"),
        ("meshes/L2.STL", "meshes/l2.stl"),
        ("package://arm/Meshes/l2.stl", "../meshes/l2.stl"),
        ("/home/somebody/arm/meshes/l2.stl", "l2.stl"),
        ("../meshes/l2.stl", "../meshes/l2.stl"),
    ] {
        let folder = tempfile::tempdir().unwrap();
        let home = folder.path().join("urdf");
        write(&home.join("arm.urdf"), meshed(&collision(&written.replace("HERE", home.to_str().unwrap()))));
        write(&home.join(lies), stl());
        let (model, left_out) = Model::read(home.join("arm.urdf")).unwrap();
        assert!(left_out.lost.is_empty(), "{written}, {lies}: {left_out:?}");
        assert_eq!(model.mesh_vertices(2).len(), 4, "{written}");
    }
    // As MJCF has them: the same rules.
    for (written, lies) in [("l2.stl", "l2.stl"), ("L2.stl", "assets/l2.STL"), ("a\\l2.stl", "assets/l2.stl")]
    {
        let folder = tempfile::tempdir().unwrap();
        let text = format!(
            "<mujoco><compiler meshdir='assets'/><asset><mesh name='m' file='{written}'/></asset><worldbody><body name='a'>\
             <geom size='.1'/><body name='b' pos='1 0 0'><joint/><geom type='mesh' mesh='m'/></body></body></worldbody></mujoco>"
        );
        write(&folder.path().join("arm.xml"), text);
        write(&folder.path().join(lies), stl());
        let (model, left_out) = Model::read(folder.path().join("arm.xml")).unwrap();
        assert!(left_out.lost.is_empty() && model.ngeom() == 2, "{written}: {left_out:?}");
    }
}

#[test]
fn a_mesh_that_cannot_be_read_is_named_and_the_rest_goes_on() {
    const POINTER: &str = "version https://git-lfs.github.com/spec/v1\noid sha256:4665a5ea\nsize 12345\n";
    let shown = "<visual><origin xyz=\"0 0 0.15\"/><geometry><cylinder radius=\"0.03\" length=\"0.2\"/></geometry></visual>";
    let whole = stl();
    for (file, bytes, told) in [
        ("package://x/l2.dae", None, "l2.dae nor a file of that name beside the model"),
        ("l2.dae", Some(b"<COLLADA/>".as_slice()), "l2.dae cannot be read as DAE"),
        ("l2.glb", Some(b"glTF".as_slice()), "l2.glb is not STL, OBJ, PLY, DAE or MSH"),
        (
            "l2.stl",
            Some(POINTER.as_bytes()),
            "is a Git LFS pointer, not a mesh; fetch it with `git lfs pull`",
        ),
        ("l2.obj", Some(POINTER.as_bytes()), "`git lfs pull`"),
        ("l2.stl", Some(&whole[..150]), "l2.stl cannot be read as STL"),
    ] {
        for visual in ["", shown] {
            let folder = tempfile::tempdir().unwrap();
            write(&folder.path().join("arm.urdf"), meshed(&format!("{visual}{}", collision(file))));
            if let Some(bytes) = bytes {
                write(&folder.path().join("l2").with_extension(file.rsplit('.').next().unwrap()), bytes);
            }
            let (model, left_out) = Model::read(folder.path().join("arm.urdf")).unwrap();
            let lost: Vec<&String> = left_out.lost.keys().collect();
            assert!(lost.len() == 1 && lost[0].contains(file) && lost[0].contains(told), "{file}: {lost:?}");
            // It is touched on what is shown, where there is that.
            assert_eq!(model.ngeom(), if visual.is_empty() { 3 } else { 4 }, "{file}");
            let noted = left_out.notes.iter().any(|note| note.contains("link l2 uses its visual shape"));
            assert_eq!(noted, !visual.is_empty(), "{file}: {:?}", left_out.notes);
        }
    }
    // Where the collision shape is there, nobody asks for what is shown.
    let (_, left_out) = read(
        "arm.urdf",
        &ARM.replace(
            "<link name=\"l2\">",
            "<link name=\"l2\"><visual><geometry><mesh filename=\"l2.dae\"/></geometry></visual>",
        ),
    );
    assert!(left_out.lost.is_empty() && left_out.notes.is_empty(), "{left_out:?}");
}

#[test]
fn textures_that_are_not_there_are_nobodys_loss() {
    let text = "<mujoco><asset><texture name='t' type='2d' file='gone.png'/><material name='m' texture='t' rgba='1 0 0 1'/></asset>\
                <worldbody><body name='a'><geom size='.1' material='m'/><body name='b' pos='1 0 0'><joint/><geom size='.1'/></body>\
                </body></worldbody></mujoco>";
    let (body, left_out) = read("arm.xml", text);
    assert!(left_out.is_empty(), "{left_out:?}");
    assert_eq!(body.creature.limbs().len(), 2);
}

#[test]
fn what_mimics_what_mimics_is_followed_alike() {
    let mimic = |text: &str, joint: &str, mimic: &str| {
        let mark = format!("<child link=\"l{}\"/>", &joint[1..]);
        text.replacen(&mark, &format!("{mark}{mimic}"), 1)
    };
    let chained = mimic(ARM, "j2", "<mimic joint=\"j1\" multiplier=\"-0.5\" offset=\"0.2\"/>");
    let chained = mimic(&chained, "j3", "<mimic joint=\"j2\" multiplier=\"2\" offset=\"0.1\"/>");
    let (body, _) = read("arm.urdf", &chained);
    let file = robot("arm.urdf", &chained).unwrap();
    // j3 = 2 (0.2 − 0.5 j1) + 0.1
    let follows = body.creature.dofs().nth(2).unwrap().follows.unwrap();
    assert_eq!((follows.leader, &follows.polynomial[..2]), (0, [0.5, -1.0].as_slice()));
    let value = |name: &str| {
        let quantity = file.robot.quantity(name).unwrap();
        file.robot.nominal()[quantity].number()
    };
    assert_eq!([value("j3.gain"), value("j3.offset")], [-1.0, 0.5]);
    assert_eq!(file.robot.coordinates(), 1);
    // Written back as it was, byte for byte.
    let same = file.with_values(Path::new("arm.urdf"), &file.robot.nominal()).unwrap();
    assert_eq!(String::from_utf8(same.bytes).unwrap(), chained);
    // What mimics a joint that stands still stands still as well, wherever that is.
    let fixed = mimic(
        &ARM.replacen("type=\"revolute\"", "type=\"fixed\"", 1),
        "j3",
        "<mimic joint=\"j1\" offset=\"0.3\"/>",
    );
    let (body, _) = read("arm.urdf", &fixed);
    assert_eq!(body.creature.dofs().nth(1).unwrap().range, [0.3; 2]);
    assert_eq!(robot("arm.urdf", &fixed).unwrap().robot.dofs.len(), 1);
    for (joints, told) in [
        (
            mimic(&mimic(ARM, "j2", "<mimic joint=\"j3\"/>"), "j3", "<mimic joint=\"j2\"/>"),
            "mimics itself by way of",
        ),
        (mimic(ARM, "j2", "<mimic joint=\"gone\"/>"), "mimics gone, which does not exist"),
    ] {
        let folder = tempfile::tempdir().unwrap();
        write(&folder.path().join("arm.urdf"), &joints);
        assert!(
            Model::read(folder.path().join("arm.urdf")).unwrap_err().to_string().contains(told),
            "{told}"
        );
        assert!(robot("arm.urdf", &joints).unwrap_err().contains(told), "{told}");
    }
}

#[test]
fn names_that_are_made_up_are_nobody_elses() {
    let arm = |root: &str, first: &str, more: &str| {
        format!(
            "<mujoco><worldbody><body {root}><freejoint/><geom size='.1'/><body {first} pos='0 .3 0'><joint axis='1 0 0'/>{more}\
             <geom size='.1'/><body name='body2' pos='0 .3 0'><joint name='joint1' axis='0 0 1'/><geom size='.1'/></body></body></body>\
             </worldbody></mujoco>"
        )
    };
    for (text, limbs) in [
        (arm("", "name='body1'", ""), vec!["body1_", "body1", "body2"]),
        (arm("name='body1_'", "", ""), vec!["body1_", "body2_", "body2"]),
        // Two joints in series have a limb between them.
        (arm("name='a/0'", "name='a'", "<joint name='k' pos='.1 0 0'/>"), vec!["a/0", "a/0_", "a", "body2"]),
    ] {
        let (body, _) = read("arm.xml", &text);
        assert_eq!(body.creature.limbs(), limbs, "{text}");
        let mut names: Vec<&str> = body.creature.dofs().map(|dof| dof.name.as_str()).collect();
        let all = names.len();
        names.sort();
        names.dedup();
        assert_eq!(names.len(), all, "{names:?}");
        // What is written down is read again.
        Agent::of(&body).unwrap();
    }
    let folder = tempfile::tempdir().unwrap();
    write(&folder.path().join("arm.xml"), arm("", "name='body1'", ""));
    let babble =
        ["babble", "arm.xml", "--touches", "30", "--policy", "random", "--out", "s", "--learner", "hersch"];
    succeeds(folder.path(), &babble);
    succeeds(folder.path(), &["report", "s"]);
}

#[test]
fn a_skin_is_written_as_any_mujoco_reads_it() {
    let folder = tempfile::tempdir().unwrap();
    // A number, which engines write in their own ways.
    let bounded = |text: &str| {
        let value = text.split_once("boundmass=\"").and_then(|(_, rest)| rest.split_once('"'));
        value.is_some_and(|(value, _)| value.parse() == Ok(1e-6))
    };
    // A link that carries another and is nothing by itself.
    let empty = meshed("");
    write(&folder.path().join("arm.urdf"), empty);
    let text = succeeds(folder.path(), &["skin", "arm.urdf"]);
    assert!(bounded(&text), "{text}");
    write(&folder.path().join("skin.xml"), &text);
    // The same of MJCF, with all else as it was, and its folders.
    let light = "<mujoco><compiler meshdir=\"m\"/><worldbody><body name=\"a\"><geom size=\".1\"/><body name=\"b\" pos=\"1 0 0\">\
                 <joint/><body name=\"c\"><joint axis=\"1 0 0\"/><geom size=\".1\"/></body></body></body></worldbody></mujoco>";
    write(&folder.path().join("arm.xml"), light);
    let text = succeeds(folder.path(), &["skin", "arm.xml"]);
    assert!(bounded(&text) && text.contains("meshdir=\"m\""), "{text}");
    // What needs nothing gets nothing.
    let heavy = light.replace("<joint/>", "<joint/><geom size=\".1\"/>");
    write(&folder.path().join("arm.xml"), heavy);
    let text = succeeds(folder.path(), &["skin", "arm.xml"]);
    assert!(
        !text.contains("bound") && text.contains("meshdir=\"m\"") && !text.contains("texturedir"),
        "{text}"
    );
}

#[test]
fn couplings_that_no_posture_keeps_are_not_heeded_whatever_the_file_is_for() {
    let text = |option: &str| {
        format!(
            "<mujoco>{option}<worldbody><body name='a'><geom size='.1'/><body name='b' pos='1 0 0'><joint name='j'/><geom size='.1'/>\
             </body><body name='c' pos='-1 0 0'><joint name='k'/><geom size='.1'/></body></body></worldbody><tendon><fixed name='s'>\
             <joint joint='j' coef='1'/></fixed><fixed name='t'><joint joint='k' coef='1'/></fixed></tendon><equality>\
             <tendon tendon1='s' tendon2='t'/></equality></mujoco>"
        )
    };
    for option in ["", "<option integrator='implicitfast'/>", "<option><flag nativeccd='enable'/></option>"] {
        let folder = tempfile::tempdir().unwrap();
        write(&folder.path().join("arm.xml"), text(option));
        let printed = succeeds(folder.path(), &["inspect", "arm.xml"]);
        assert!(
            printed.contains("1 constraints that close loops or couple tendons are ignored"),
            "{printed}"
        );
        assert!(!printed.contains("not needed: <tendon> in"), "{printed}");
        let printed: Value =
            serde_json::from_str(&succeeds(folder.path(), &["inspect", "arm.xml", "--json"])).unwrap();
        assert_eq!(printed["constraints_not_heeded"], 1, "{option}");
    }
}

// Logs.

const CRANE: &str = r#"{"name": "crane", "limbs": ["base", "arm", "hand"], "joints": [
  {"name": "lift", "parent": "base", "dofs": [{"name": "lift", "kind": "hinge", "range": [-1.5, 1.5]}]},
  {"name": "reach_m", "parent": "arm", "dofs": [{"name": "reach_m", "kind": "slide", "range": [0.0, 0.5]}]}]}"#;
const HEAD: &str = "limb_a,limb_b,ax,ay,az,bx,by,bz,lift,reach_m";

/// Touches as lines of cells.
fn rows() -> Vec<String> {
    (0..4).map(|k| format!("base,hand,0.1,0.2,0.{k}1,-0.1,0,0.01,0.{k}5,0.25")).collect()
}

/// The same as JSON.
fn lines() -> Vec<Value> {
    let line = |k: u32| {
        let z = format!("0.{k}1").parse::<f64>().unwrap();
        let lift = format!("0.{k}5").parse::<f64>().unwrap();
        json!({"posture": {"lift": lift, "reach_m": 0.25}, "limbs": ["base", "hand"],
               "contacts": [[0.1, 0.2, z], [-0.1, 0.0, 0.01]]})
    };
    (0..4).map(line).collect()
}

fn recording(name: &str, bytes: impl AsRef<[u8]>) -> Result<Recording, String> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join(name);
    write(&path, bytes);
    write(&folder.path().join("crane.json"), CRANE);
    let described = read_creature(&folder.path().join("crane.json")).unwrap();
    read_recording(&path, &described.agent).map_err(|error| error.to_string())
}

fn packed(bytes: &[u8]) -> Vec<u8> {
    let mut packer = GzEncoder::new(Vec::new(), Compression::default());
    packer.write_all(bytes).unwrap();
    packer.finish().unwrap()
}

#[test]
fn a_log_is_read_by_what_is_in_it() {
    let csv = format!("{HEAD}\n{}\n", rows().join("\n"));
    let json: String = lines().iter().map(|line| format!("{line}\n")).collect();
    let expected = recording("log.csv", &csv).unwrap();
    assert_eq!((expected.touches.len(), expected.notes.len()), (4, 0), "{:?}", expected.notes);
    let array = Value::Array(lines());
    let pretty: String = lines().iter().map(|line| format!("{line:#}\n")).collect();
    let utf_16: Vec<u8> =
        [0xfeff].into_iter().chain(csv.encode_utf16()).flat_map(|unit: u16| unit.to_le_bytes()).collect();
    for (name, bytes) in [
        ("log.txt", csv.clone().into_bytes()),
        ("log", csv.clone().into_bytes()),
        ("log.jsonl", csv.clone().into_bytes()),
        ("log.tsv", csv.replace(',', "\t").into_bytes()),
        ("log.txt", csv.replace(',', ";").replace('.', ",").into_bytes()),
        ("log.csv", format!("\u{feff}{}", csv.replace('\n', "\r\n")).into_bytes()),
        ("log.csv", format!("\n{}\n,,,,,,,,,\n\n", csv.replace('\n', "\n\n")).into_bytes()),
        ("log.csv", csv.trim_end().as_bytes().to_vec()),
        ("log.csv.gz", packed(csv.as_bytes())),
        ("log.csv", packed(csv.as_bytes())),
        ("log.csv", utf_16),
        ("log.json", json.clone().into_bytes()),
        ("log.csv", json.clone().into_bytes()),
        ("log.jsonl", format!("\u{feff}{}", json.replace('\n', "\r\n")).into_bytes()),
        ("log.jsonl", json.replace('\n', "\n\n \n").into_bytes()),
        ("log.jsonl.gz", packed(json.as_bytes())),
        ("log.json", array.to_string().into_bytes()),
        ("log.json", format!("\n {array:#}\n").into_bytes()),
        ("log.json.gz", packed(format!("{array:#}").as_bytes())),
        ("log.json", pretty.into_bytes()),
    ] {
        let read = recording(name, &bytes).unwrap_or_else(|error| panic!("{error}"));
        assert_eq!(read, expected, "{name}: {}", String::from_utf8_lossy(&bytes));
    }
}

#[test]
fn a_log_that_is_being_written_is_read_up_to_its_last_line() {
    let csv = format!("{HEAD}\n{}\n", rows().join("\n"));
    let json: String = lines().iter().map(|line| format!("{line}\n")).collect();
    let array = format!("{:#}", Value::Array(lines()));
    for (name, text, touches) in [
        ("log.csv", &csv[..csv.len() - 20], 3),
        ("log.txt", &csv.replace(',', "\t")[..csv.len() - 12], 3),
        ("log.jsonl", &json[..json.len() - 30], 3),
        ("log.json", &array[..array.len() - 60], 3),
        ("log.json", &array[..array.rfind(']').unwrap()], 4),
    ] {
        let read = recording(name, text).unwrap_or_else(|error| panic!("{error}"));
        assert_eq!(read.touches.len(), touches, "{name}");
        let cut = read.notes.iter().any(|note| note.contains("it ends in the middle of line"));
        assert_eq!(cut, touches < 4, "{name}: {:?}", read.notes);
    }
    // What is packed is cut off in the middle of what it packs.
    let many: String = format!("{HEAD}\n") + &format!("{}\n", rows().join("\n")).repeat(5000);
    let bytes = packed(many.as_bytes());
    let read = recording("log.csv.gz", &bytes[..bytes.len() / 2]).unwrap();
    assert!(read.notes.iter().any(|note| note.contains("the gzip file is truncated")), "{:?}", read.notes);
    assert!(recording("log.csv.gz", &bytes[..8]).unwrap_err().contains("unpack it first"));
}

#[test]
fn numbers_that_are_not_finite_leave_their_touch_out_and_are_told() {
    let csv = |from: &str, to: &str| {
        let mut rows = rows();
        rows[2] = rows[2].replacen(from, to, 1);
        format!("{HEAD}\n{}\n", rows.join("\n"))
    };
    let json = |pointer: &str, word: &str| {
        let mut lines = lines();
        *lines[2].pointer_mut(pointer).unwrap() = json!("HERE");
        let text: String = lines.iter().map(|line| format!("{line}\n")).collect();
        text.replace("\"HERE\"", word)
    };
    for (name, text, told) in [
        ("log.csv", csv("0.2,", "NaN,"), "line 4: column 4, ay: NaN is not finite"),
        ("log.csv", csv("0.2,", "-inf,"), "line 4: column 4, ay: -inf is not finite"),
        ("log.csv", csv("0.25", "nan"), "line 4: column 9, lift: nan is not finite"),
        ("log.jsonl", json("/contacts/0/2", "NaN"), "line 3: az: NaN is not finite"),
        ("log.jsonl", json("/contacts/1/0", "-Infinity"), "line 3: bx: NaN is not finite"),
        ("log.jsonl", json("/posture/lift", "Infinity"), "line 3: lift: NaN is not finite"),
        ("log.jsonl", json("/posture/lift", "null"), "line 3: lift: NaN is not finite"),
    ] {
        let read = recording(name, &text).unwrap_or_else(|error| panic!("{error}"));
        assert_eq!(read.touches.len(), 3, "{text}");
        let words = format!("1 of 4 touches are ignored because their numbers are not finite: {told}");
        assert!(read.notes[0].starts_with(&words), "{text}: {:?}", read.notes);
    }
    // A name is no number, whatever it is.
    let named = format!("{HEAD}\n{}\n", rows().join("\n")).replace("hand", "NaN");
    assert!(recording("log.csv", named).unwrap_err().contains("no limb \"NaN\""));
    let none = rows().iter().map(|row| row.replacen("0.2,", "nan,", 1)).collect::<Vec<_>>().join("\n");
    let message = recording("log.csv", format!("{HEAD}\n{none}\n")).unwrap_err();
    assert!(
        message.contains("it contains no touches") && message.contains("ay: nan is not finite"),
        "{message}"
    );
}

#[test]
fn a_columns_unit_is_read_in_any_spelling_and_refused_where_it_measures_something_else() {
    let expected = recording("log.csv", format!("{HEAD}\n{}\n", rows().join("\n"))).unwrap();
    let degrees: Vec<String> = rows()
        .iter()
        .map(|row| {
            let mut cells: Vec<String> = row.split(',').map(str::to_string).collect();
            cells[8] = cells[8].parse::<f64>().unwrap().to_degrees().to_string();
            cells.join(",")
        })
        .collect();
    for title in [
        "lift [Deg]",
        "lift (deg)",
        "lift_DEG",
        "lift [°]",
        "liftDeg",
        "lift / deg",
        "lift_degrees",
        "lift{deg.}",
    ] {
        let read = recording("log.csv", format!("{}\n{}\n", HEAD.replace("lift", title), degrees.join("\n")));
        let read = read.unwrap_or_else(|error| panic!("{title}: {error}"));
        for (a, b) in read.touches.iter().zip(&expected.touches) {
            assert!((a.posture[0] - b.posture[0]).abs() < 1e-12, "{title}");
            // The joint is called so: it is metres as they stand.
            assert_eq!(a.posture[1], 0.25);
        }
    }
    for (from, to, told) in [
        ("ax", "ax_deg", "column \"ax_deg\": ax is a length: give it in m, cm or mm"),
        ("bz", "bz [rad]", "column \"bz [rad]\": bz is a length"),
        ("lift", "lift_mm", "column \"lift_mm\": lift is an angle: give it in rad or deg"),
        ("reach_m", "reach_m [deg]", "reach_m is a length"),
        ("lift", "lift [turns]", "column \"lift [turns]\": unknown unit turns: give rad or deg"),
        ("reach_m", "reach", "column reach_m is missing"),
    ] {
        let log = format!("{}\n{}\n", HEAD.replace(from, to), rows().join("\n"));
        let message = recording("log.csv", log).unwrap_err();
        assert!(message.contains("line 1") && message.contains(told), "{to}: {message}");
    }
}

/// A thumb whose joint is called as an anatomist calls it.
const THUMB: &str = r#"joint,theta,d,a,alpha
thumb,0,0.1,0.3,pi/2
thumb_cm,0,0,0.3,-π/2
"#;

#[test]
fn calibrate_reads_columns_as_learn_does() {
    let place = Place::new();
    place.write("thumb.csv", THUMB);
    let file = read_robot(&place.path("thumb.csv")).unwrap();
    let log = |head: &str, row: &str| {
        place.write(
            "log.csv",
            format!("limb_a,limb_b,ax,ay,az,bx,by,bz,{head}\nbase,thumb_cm_link,0.1,0,0,0.1,0,0,{row}\n"),
        );
        bodyschema::session::read_calibration_log(&place.path("log.csv"), &file.robot)
            .map_err(|e| e.to_string())
    };
    // In the file's order, whatever the order of its columns.
    let read = log("thumb_cm,thumb", "0.5,0.25").unwrap();
    assert_eq!(read.touches[0].posture, [0.25, 0.5]);
    let read = log("thumb [Deg],thumb_cm_DEG", "45,90").unwrap();
    let pi = std::f64::consts::PI;
    assert!((read.touches[0].posture[0] - pi / 4.0).abs() < 1e-12);
    assert!((read.touches[0].posture[1] - pi / 2.0).abs() < 1e-12);
    for (head, row, told) in [
        ("thumb_mm,thumb_cm", "1,1", "column \"thumb_mm\": thumb is an angle"),
        ("thumb [steps],thumb_cm", "1,1", "unknown unit steps"),
        ("thumb_cm", "1", "joint thumb moves a touched link but has no reading"),
        ("thumb [rad],thumb_cm", "90,1", "if they are degrees, call the column thumb_deg"),
    ] {
        let message = log(head, row).unwrap_err();
        assert!(message.contains(told), "{head}: {message}");
    }
    // Whatever it is packed and separated by.
    let text = std::fs::read_to_string(place.path("log.csv")).unwrap().replace("90,1\n", "0.1,1\n");
    let expected = log("thumb [rad],thumb_cm", "0.1,1").unwrap();
    for (name, bytes) in [
        ("log.txt", text.replace(',', "\t").into_bytes()),
        ("log.csv.gz", packed(text.as_bytes())),
        ("log.csv", format!("\u{feff}{}", text.replace('\n', "\r\n\r\n")).into_bytes()),
    ] {
        place.write(name, &bytes);
        let read = bodyschema::session::read_calibration_log(&place.path(name), &file.robot).unwrap();
        assert_eq!(read.touches[0].posture, expected.touches[0].posture, "{name}");
    }
    // A number that is none is told of where it is needed.
    let head = "limb_a,limb_b,ax,ay,az,bx,by,bz,thumb,thumb_cm\n";
    let touch = "base,thumb_cm_link,0.1,0,0,0.1,0,0";
    place.write(
        "log.csv",
        format!("{head}{touch},0.1,0.2\n{touch},nan,0.2\nbase,thumb_link,0.1,0,0,0.1,0,0,0.1,nan\n"),
    );
    let read = bodyschema::session::read_calibration_log(&place.path("log.csv"), &file.robot).unwrap();
    assert_eq!(read.touches.len(), 2);
    assert!(
        read.notes[0].contains("1 of 3 touches are ignored") && read.notes[0].contains("line 3"),
        "{:?}",
        read.notes
    );
}

#[test]
fn a_table_as_books_print_it_is_read_and_kept_as_it_is() {
    let place = Place::new();
    place.write("thumb.csv", THUMB);
    let file = read_robot(&place.path("thumb.csv")).unwrap();
    let alpha = |name: &str| file.robot.nominal()[file.robot.quantity(name).unwrap()].number();
    let half = std::f64::consts::FRAC_PI_2;
    assert_eq!([alpha("thumb.alpha"), alpha("thumb_cm.alpha")], [half, -half]);
    let mut values = file.robot.nominal();
    let same = file.with_values(&place.path("thumb.csv"), &values).unwrap();
    assert_eq!(String::from_utf8(same.bytes).unwrap(), THUMB);
    values[file.robot.quantity("thumb.alpha").unwrap()] = bodyschema::calibration::robot::Value::Number(1.5);
    let written = file.with_values(&place.path("thumb.csv"), &values).unwrap();
    assert_eq!(String::from_utf8(written.bytes).unwrap(), THUMB.replace("pi/2", "1.5"));
    place.write("thumb.csv", THUMB.replace("pi/2", "pie/2"));
    assert!(
        read_robot(&place.path("thumb.csv"))
            .unwrap_err()
            .to_string()
            .contains("is \"pie/2\", not a finite number")
    );
}

#[test]
fn the_files_of_the_repository_are_found_without_a_word() {
    let (_, left_out) = Model::read(repository("mjcf/hexapod/hexapod.xml")).unwrap();
    assert_eq!(left_out, LeftOut::default());
}
