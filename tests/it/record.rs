//! The session on disk: what is written reads back bit for bit, and a wrong file gets one sentence.

use std::fs;
use std::path::{Path, PathBuf};

use bodyschema::Error;
use bodyschema::agent::Agent;
use bodyschema::creature::{AuraLimb, Creature, Dof, DofKind, Joint};
use bodyschema::geometry::Shape;
use bodyschema::schema::BodySchema;
use bodyschema::senses::{ExactContact, Moment, RecordedTouch, Touch, TouchEnd};
use bodyschema::session::*;
use bodyschema::simulation::Effort;
use bodyschema::skin::{Receptor, Skin, Surface};
use nalgebra::{Matrix3, Vector3};
use sha2::{Digest, Sha256};
use tempfile::TempDir;

/// Numbers that a careless format would change.
const AWKWARD: [f64; 12] = [
    0.1,
    -0.0,
    0.1 + 0.2,
    1.0 / 3.0,
    f64::MIN_POSITIVE,
    5e-324,
    0.9999999999999998,
    -0.9999999999999998,
    0.9007199254740993,
    2.225073858507201e-308,
    std::f64::consts::PI,
    8.41e-21,
];

fn dof(name: &str, kind: DofKind) -> Dof {
    let low = if kind == DofKind::Ball { 0.0 } else { -1.5 };
    Dof { name: name.into(), kind, range: [low, 0.1 + 0.2], follows: None }
}

/// A trunk with an arm of a hinge pair and a slide, and a head on a ball.
fn creature() -> Creature {
    let joints = vec![
        Joint::new(
            "shoulder",
            0,
            vec![dof("shoulder_abduction", DofKind::Hinge), dof("shoulder_flexion", DofKind::Hinge)],
        ),
        Joint::new("reach", 1, vec![dof("reach", DofKind::Slide)]),
        Joint::new("neck", 0, vec![dof("neck", DofKind::Ball)]),
    ];
    let limbs = ["trunk", "arm", "hand", "head"].map(String::from).to_vec();
    let auras = vec![AuraLimb { name: "arm".into(), limbs: vec![1, 2] }];
    Creature::new("tot".into(), limbs, joints, auras).unwrap()
}

fn receptor(id: &str, limb: usize, position: Vector3<f64>) -> Receptor {
    let (normal, tangent) = (Vector3::x(), Vector3::y());
    Receptor {
        id: id.into(),
        limb,
        position,
        normal,
        tangent,
        half_extents: [0.01, 1.0 / 3.0],
        // The only surface is the hand's.
        surface: (limb == 2).then_some(0),
    }
}

fn skin() -> Skin {
    let surface = Surface {
        limb: 2,
        origin: Vector3::new(0.1, -0.0, 1e-300),
        rotation: Matrix3::identity(),
        shape: Shape::Capsule { radius: 0.05, half_length: 1.0 / 7.0 },
        geom: 0,
    };
    Skin {
        receptors: vec![
            receptor("trunk_00", 0, Vector3::new(0.1 + 0.2, -0.0, 5e-324)),
            receptor("hand_00", 2, Vector3::new(1.0 / 3.0, 0.0, 0.0)),
            receptor("head_00", 3, Vector3::new(0.0, 0.0, 0.1)),
            receptor("head_01", 3, Vector3::new(0.0, 0.1, 0.1)),
        ],
        surfaces: vec![surface],
    }
}

fn agent() -> Agent {
    Agent::new(creature(), skin()).unwrap()
}

/// A touch of the hand on the head, with numbers from [`AWKWARD`].
fn touch(i: usize) -> RecordedTouch {
    let awkward = |k: usize| AWKWARD[(5 * i + k) % AWKWARD.len()];
    let vector = |k: usize| Vector3::new(awkward(k), awkward(k + 1), awkward(k + 2));
    let with_forces = i % 3 == 1;
    let touch = Touch {
        bout: u64::MAX - i as u64,
        motion: i as u64,
        posture: vec![awkward(0), awkward(1), awkward(2), 0.5f64.sqrt(), -0.0, 0.5f64.sqrt(), 5e-324].into(),
        ends: [TouchEnd::at(1), TouchEnd::at(2 + i % 2)],
        moment: with_forces.then_some(Moment { time: awkward(9).abs(), force: awkward(10).abs() }),
    };
    let contact = ExactContact {
        points: [vector(3), vector(6)],
        deviations: [None; 2],
        depth: with_forces.then_some(awkward(11).abs()),
    };
    RecordedTouch::new(touch, contact)
}

/// Everything of a touch as bits, so that -0 is not 0.
fn bits(touch: &RecordedTouch) -> Vec<u64> {
    let contact = touch.exact_contact();
    let numbers = touch.posture.iter().chain(contact.points.iter().flatten());
    let indices = touch.ends.iter().map(|end| end.receptor as u64).chain([touch.bout, touch.motion]);
    let moment = touch.moment.map(|moment| [moment.time, moment.force]);
    let moment = moment.into_iter().flatten().chain(contact.depth).map(f64::to_bits);
    numbers.map(|x| x.to_bits()).chain(indices).chain(moment).collect()
}

fn vector_bits<'a>(vectors: impl IntoIterator<Item = &'a Vector3<f64>>) -> Vec<u64> {
    vectors.into_iter().flat_map(|v| v.iter().map(|x| x.to_bits())).collect()
}

/// A folder with a log of `count` touches.
fn log_of(count: usize) -> (TempDir, PathBuf) {
    let folder = tempfile::tempdir().unwrap();
    let agent = agent();
    let mut writer = TouchWriter::create(folder.path(), &agent).unwrap();
    (0..count).for_each(|i| writer.write(&touch(i)).unwrap());
    writer.finish().unwrap();
    let path = folder.path().join(TOUCHES_FILE);
    (folder, path)
}

/// The error's sentence, after a check that it names the file, the line if there is one, and a mend.
fn sentence(error: &Error, path: &Path, line: Option<usize>) -> String {
    let text = error.to_string();
    let place = line.map_or(path.display().to_string(), |line| format!("{}, line {line}", path.display()));
    assert!(text.starts_with(&format!("{place}: ")), "{text}");
    assert!(!text.contains('\n') && !text.ends_with('.'), "{text}");
    let mend = text.rsplit(": ").next().unwrap();
    let imperatives =
        ["give", "correct", "restore", "divide", "convert", "update", "leave", "name", "choose", "use"];
    assert!(imperatives.iter().any(|verb| mend.starts_with(verb)), "{text}");
    text
}

/// Reads a log of two touches after `spoil` changed its lines; expects a complaint about `line`.
fn complaint(line: usize, spoil: impl FnOnce(&mut Vec<String>)) -> String {
    let (_folder, path) = log_of(2);
    let mut lines: Vec<String> = fs::read_to_string(&path).unwrap().lines().map(String::from).collect();
    spoil(&mut lines);
    fs::write(&path, lines.iter().map(|line| format!("{line}\n")).collect::<String>()).unwrap();
    sentence(&read_touches(&path, &agent()).unwrap_err(), &path, Some(line))
}

/// As [`complaint`] about the first touch, in whose line `from` becomes `to`.
fn complaint_after(from: &str, to: &str) -> String {
    complaint(2, |lines| {
        assert!(lines[1].contains(from), "{from} is not in {}", lines[1]);
        lines[1] = lines[1].replacen(from, to, 1);
    })
}

#[test]
fn touches_read_back_bit_for_bit() {
    let (_folder, path) = log_of(40);
    let log = read_touches(&path, &agent()).unwrap();
    assert_eq!((log.touches.len(), log.truncated), (40, None));
    for (i, read) in log.touches.iter().enumerate() {
        assert_eq!(bits(read), bits(&touch(i)));
    }
}

#[test]
fn the_log_can_be_read_alone() {
    let (_folder, path) = log_of(1);
    let text = fs::read_to_string(path).unwrap();
    let (header, line) = text.split_once('\n').unwrap();
    let expected =
        r#"{"format":"bodyschema touches","version":1,"creature":"tot","coordinates":7,"units":"m rad"}"#;
    assert_eq!(header, expected);
    let line: serde_json::Value = serde_json::from_str(line).unwrap();
    assert_eq!(line["receptors"], serde_json::json!(["hand_00", "head_00"]));
    assert_eq!(line["limbs"], serde_json::json!(["hand", "head"]));
    assert_eq!(line["positions"], serde_json::json!([[1.0 / 3.0, 0.0, 0.0], [0.0, 0.0, 0.1]]));
    assert_eq!(line["contacts"][0][0], AWKWARD[3]);
}

#[test]
fn every_touch_is_on_disk_as_soon_as_it_is_written() {
    let folder = tempfile::tempdir().unwrap();
    let agent = agent();
    let mut writer = TouchWriter::create(folder.path(), &agent).unwrap();
    for i in 0..5 {
        let log = read_touches(&folder.path().join(TOUCHES_FILE), &agent).unwrap();
        assert_eq!((log.touches.len(), log.truncated), (i, None));
        writer.write(&touch(i)).unwrap();
    }
}

#[test]
fn a_log_cut_anywhere_keeps_the_touches_before() {
    let (_folder, path) = log_of(3);
    let whole = fs::read(&path).unwrap();
    let header = whole.iter().position(|&b| b == b'\n').unwrap() + 1;
    for cut in header..whole.len() {
        fs::write(&path, &whole[..cut]).unwrap();
        let log = read_touches(&path, &agent()).unwrap();
        let lines = whole[..cut].iter().filter(|&&b| b == b'\n').count();
        let at_end = [b'\n', b'}'].contains(&whole[cut - 1]);
        let complete = lines - 1 + usize::from(whole[cut - 1] == b'}');
        assert_eq!(log.truncated, (!at_end).then_some(lines + 1), "cut at {cut}");
        assert_eq!(log.touches.len(), complete, "cut at {cut}");
        assert!(log.touches.iter().enumerate().all(|(i, read)| bits(read) == bits(&touch(i))));
    }
    // What a disk leaves after the power failed.
    fs::write(&path, [&whole[..], &[0; 100]].concat()).unwrap();
    let log = read_touches(&path, &agent()).unwrap();
    assert_eq!((log.touches.len(), log.truncated, log.zeros), (3, None, 100));
    fs::write(&path, [&whole[..whole.len() - 20], &[0; 7]].concat()).unwrap();
    let log = read_touches(&path, &agent()).unwrap();
    assert_eq!((log.touches.len(), log.truncated, log.zeros), (2, Some(4), 7));
}

#[test]
fn a_log_that_is_there_is_never_overwritten_and_zeros_at_its_end_are_dropped() {
    let (folder, path) = log_of(3);
    let (whole, agent) = (fs::read(&path).unwrap(), agent());
    let message = sentence(&TouchWriter::create(folder.path(), &agent).unwrap_err(), &path, None);
    assert!(message.contains("a log already exists"), "{message}");
    assert_eq!(fs::read(&path).unwrap(), whole);
    for (kept, zeros) in [(whole.len(), 1), (whole.len() - 9, 100_000), (0, 70_000), (20, 3)] {
        fs::write(&path, [&whole[..kept], &vec![0; zeros]].concat()).unwrap();
        let mut writer = TouchWriter::resume(folder.path(), &agent).unwrap();
        assert_eq!(writer.zeros(), zeros);
        (0..3).for_each(|i| writer.write(&touch(i)).unwrap());
        writer.finish().unwrap();
        assert!(fs::read(&path).unwrap() == whole, "{kept} bytes and {zeros} zeros");
    }
}

/// A process may be killed between any two moves of a generation that is whole: who comes next does the rest.
#[test]
fn a_generation_is_all_there_or_not_at_all_wherever_its_writer_was_killed() {
    let names = ["learned.xml", "learning.csv", "learning.json", SCHEMA_FILE];
    let begun = |moved: usize, whole: bool| {
        let folder = tempfile::tempdir().unwrap();
        let hidden = folder.path().join(if whole { ".generation" } else { ".generation.part" });
        fs::create_dir(&hidden).unwrap();
        // Slices of where hands get to are of the schema before.
        fs::write(hidden.join(".removed"), "space.json\n").unwrap();
        fs::write(folder.path().join("space.json"), "old").unwrap();
        for (k, name) in names.iter().enumerate() {
            fs::write(folder.path().join(name), if k < moved { "new" } else { "old" }).unwrap();
            if k >= moved {
                fs::write(hidden.join(name), "new").unwrap();
            }
        }
        folder
    };
    let is = |folder: &TempDir, text: &str| {
        let all = names.iter().all(|name| fs::read_to_string(folder.path().join(name)).unwrap() == text);
        let hidden = fs::read_dir(folder.path()).unwrap().flatten().map(|entry| entry.file_name());
        all && !hidden.into_iter().any(|name| name.to_string_lossy().starts_with('.'))
    };
    for moved in 0..=names.len() {
        let folder = begun(moved, true);
        drop(FolderLock::take(folder.path()).unwrap());
        assert!(is(&folder, "new"), "a writer after {moved} moves");
        let folder = begun(moved, true);
        drop(ReadLock::take(folder.path()).unwrap());
        assert!(is(&folder, "new"), "a reader after {moved} moves");
        assert!(!folder.path().join("space.json").exists(), "after {moved} moves");
    }
    let folder = begun(0, false);
    fs::write(folder.path().join(".schema.json.4194305.part"), "{").unwrap();
    drop(FolderLock::take(folder.path()).unwrap());
    assert!(is(&folder, "old"));
}

#[test]
fn a_folder_has_one_writer_and_is_not_changed_while_it_is_read() {
    let folder = tempfile::tempdir().unwrap();
    let lock = FolderLock::take(folder.path()).unwrap();
    let busy = FolderLock::take(folder.path()).unwrap_err().to_string();
    let process = format!("process {}", std::process::id());
    assert!(busy.contains(&process) && busy.contains(folder.path().to_str().unwrap()), "{busy}");
    fs::write(lock.part().unwrap().join("schema.json"), "new").unwrap();
    let reading = ReadLock::take(folder.path()).unwrap();
    std::thread::scope(|scope| {
        let commit = scope.spawn(|| lock.commit().unwrap());
        std::thread::sleep(std::time::Duration::from_millis(50));
        assert!(!folder.path().join("schema.json").exists(), "it was changed while it was read");
        drop(reading);
        commit.join().unwrap();
    });
    assert_eq!(fs::read_to_string(folder.path().join("schema.json")).unwrap(), "new");
    drop(lock);
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1, "something is left");
    FolderLock::take(folder.path()).unwrap();
}

#[test]
fn a_log_cut_in_its_header_is_refused() {
    let (_folder, path) = log_of(1);
    let whole = fs::read(&path).unwrap();
    let header = whole.iter().position(|&b| b == b'\n').unwrap();
    for cut in 0..header {
        fs::write(&path, &whole[..cut]).unwrap();
        let error = read_touches(&path, &agent()).unwrap_err();
        sentence(&error, &path, Some(1));
    }
}

#[test]
fn an_empty_log_and_a_missing_header_are_named() {
    assert!(complaint(1, Vec::clear).contains("no header"));
    assert!(complaint(1, |lines| drop(lines.remove(0))).contains("states no format"));
    assert!(complaint(1, |lines| lines[0] = "hello".into()).contains("states no readable format"));
    assert!(complaint(1, |lines| lines[0] = "[1]".into()).contains("states no readable format"));
}

#[test]
fn a_foreign_header_is_named() {
    let spoilt = |from: &'static str, to: &'static str| {
        complaint(1, move |lines| {
            assert!(lines[0].contains(from));
            lines[0] = lines[0].replace(from, to);
        })
    };
    assert!(spoilt("bodyschema touches", "bodyschema schema").contains("\"bodyschema schema\""));
    let newer = spoilt("\"version\":1", "\"version\":2");
    assert!(newer.contains("newer version") && newer.ends_with("update bodyschema"), "{newer}");
    for version in ["0", "-1", "1.5", "\"1\"", "null"] {
        complaint(1, |lines| lines[0] = lines[0].replace("n\":1", &format!("n\":{version}")));
    }
    assert!(spoilt("\"tot\"", "\"max\"").contains("belong to \"max\" with 7"));
    assert!(spoilt("\"coordinates\":7", "\"coordinates\":8").contains("with 8 coordinates"));
    assert!(spoilt("\"m rad\"", "\"mm deg\"").contains("\"mm deg\""));
    assert!(spoilt("\"units\":\"m rad\"", "\"u\":0").contains("units"));
}

#[test]
fn malformed_lines_are_named() {
    assert!(complaint(2, |lines| lines[1].truncate(50)).contains("ends in the middle"));
    assert!(complaint(2, |lines| lines[1].clear()).contains("ends in the middle"));
    assert!(complaint(3, |lines| lines[2] = "]".into()).contains("column 1"));
    assert!(complaint(3, |lines| lines[2] = "{}".into()).contains("missing field"));
    assert!(complaint_after("\"motion\":0", "\"motion\":-1").contains("invalid value"));
    assert!(complaint_after("\"posture\"", "\"pose\"").contains("`posture`"));
    assert!(complaint_after("\"head_00\"", "\"head_00\",\"head_01\"").contains("not a valid touch"));
}

#[test]
fn touches_of_another_body_are_named() {
    assert!(complaint_after("\"head_00\"", "\"head_99\"").contains("no receptor \"head_99\""));
    let limb = complaint_after("[\"hand\",\"head\"]", "[\"hand\",\"arm\"]");
    assert!(limb.contains("\"head_00\" is on limb head, not on \"arm\""), "{limb}");
    assert!(complaint_after("\"posture\":[", "\"posture\":[0.5,").contains("8 numbers"));
    assert!(complaint_after("[0.0,0.0,0.1]", "[0.0,0.0,0.2]").contains("position of receptor \"head_00\""));
    let both = complaint(2, |lines| {
        lines[1] = lines[1]
            .replace("hand_00", "head_01")
            .replace("[\"hand\"", "[\"head\"")
            .replace("[[0.3333333333333333,0.0,0.0]", "[[0.0,0.1,0.1]");
    });
    assert!(both.contains("two limbs"), "{both}");
}

#[test]
fn numbers_that_are_not_finite_are_named() {
    assert!(complaint_after("\"posture\":[0.1", "\"posture\":[null").contains("shoulder_abduction"));
    assert!(complaint_after("0.7071067811865476", "null").contains("posture's neck"));
    assert!(complaint_after("0.7071067811865476", "0.8").contains("quaternion of neck"));
    assert!(
        complaint_after("\"contacts\":[[0.3333333333333333", "\"contacts\":[[null").contains("contact at")
    );
    assert!(
        complaint_after("\"positions\":[[0.3333333333333333", "\"positions\":[[null").contains("position")
    );
    assert!(complaint_after("\"posture\":[0.1", "\"posture\":[1e999").contains("out of range"));
}

#[test]
fn fields_unknown_to_this_version_are_passed_over() {
    let (_folder, path) = log_of(2);
    let text = fs::read_to_string(&path).unwrap().replace('{', "{\"later\":[1,{\"a\":null}],");
    fs::write(&path, text).unwrap();
    assert_eq!(read_touches(&path, &agent()).unwrap().touches.len(), 2);
}

#[test]
fn a_touch_that_could_not_be_read_is_not_written() {
    let folder = tempfile::tempdir().unwrap();
    let agent = agent();
    let path = folder.path().join(TOUCHES_FILE);
    let mut writer = TouchWriter::create(folder.path(), &agent).unwrap();
    writer.write(&touch(0)).unwrap();
    let spoils: [fn(&mut RecordedTouch); 5] = [
        |touch| touch.posture[0] = f64::NAN,
        |touch| touch.posture = touch.posture[..3].into(),
        |touch| touch.exact_contact_mut().points[1].y = f64::INFINITY,
        |touch| touch.ends[0].receptor = 99,
        |touch| touch.ends[1].receptor = touch.ends[0].receptor,
    ];
    for spoil in spoils {
        let mut touch = touch(1);
        spoil(&mut touch);
        sentence(&writer.write(&touch).unwrap_err(), &path, Some(3));
    }
    writer.finish().unwrap();
    assert_eq!(read_touches(&path, &agent).unwrap().touches.len(), 1);
}

fn schema() -> BodySchema {
    let axis = Vector3::new(0.1, -0.7, 1.0 / 3.0).normalize();
    BodySchema {
        positions: vec![
            Vector3::new(0.1 + 0.2, -0.0, 5e-324),
            Vector3::new(1.0 / 3.0, 9999.999999999998, -1e-300),
            Vector3::new(0.0, 1.0, -2.225073858507201e-308),
        ],
        axes: vec![axis, -Vector3::z(), Vector3::x(), Vector3::zeros()],
        limb_poses: Vec::new(),
    }
}

#[test]
fn a_schema_reads_back_bit_for_bit() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("deep").join(SCHEMA_FILE);
    write_schema(&path, &creature(), &schema(), None).unwrap();
    let read = read_schema(&path, &creature()).unwrap();
    assert_eq!(vector_bits(&read.positions), vector_bits(&schema().positions));
    assert_eq!(vector_bits(&read.axes), vector_bits(&schema().axes));
}

#[test]
fn a_schema_is_told_by_name_a_vector_a_line() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join(SCHEMA_FILE);
    write_schema(&path, &creature(), &schema(), None).unwrap();
    let text = fs::read_to_string(&path).unwrap();
    let begin = r#"{
  "format": "bodyschema schema",
  "version": 1,
  "creature": "tot",
  "joints": [
    {
      "joint": "shoulder",
      "parent": "trunk",
      "position": [0.30000000000000004,-0.0,5e-324],
      "axes": [
        {
          "dof": "shoulder_abduction",
          "kind": "hinge",
          "axis": ["#;
    assert!(text.starts_with(begin), "{text}");
    assert!(text.ends_with("]\n    }\n  ]\n}\n"), "{text}");
}

/// Reads a schema in which `from` became `to`, and returns what is complained about.
fn schema_complaint(from: &str, to: &str, line: Option<usize>) -> String {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join(SCHEMA_FILE);
    write_schema(&path, &creature(), &schema(), None).unwrap();
    let text = fs::read_to_string(&path).unwrap();
    assert!(text.contains(from), "{text}");
    fs::write(&path, text.replacen(from, to, 1)).unwrap();
    sentence(&read_schema(&path, &creature()).unwrap_err(), &path, line)
}

#[test]
fn a_wrong_schema_is_named() {
    assert!(schema_complaint("bodyschema schema", "urdf", None).contains("\"urdf\""));
    assert!(schema_complaint("\"version\": 1", "\"version\": 9", None).contains("newer version"));
    assert!(schema_complaint("\"tot\"", "\"max\"", None).contains("belongs to \"max\""));
    assert!(schema_complaint("\"reach\"", "\"elbow\"", None).contains("\"elbow\""));
    assert!(schema_complaint("\"trunk\"", "\"hand\"", None).contains("on \"hand\""));
    assert!(schema_complaint("shoulder_flexion", "twist", None).contains("\"twist\""));
    assert!(
        schema_complaint("\"kind\": \"slide\"", "\"kind\": \"hinge\"", None).contains("a different kind")
    );
    assert!(schema_complaint("[1.0,0.0,0.0]", "[2.0,0.0,0.0]", None).contains("length 2"));
    assert!(schema_complaint("[1.0,0.0,0.0]", "null", None).contains("no axis for \"reach\""));
    assert!(schema_complaint("[1.0,0.0,0.0]", "[1.0,0.0]", Some(31)).contains("invalid length 2"));
    assert!(schema_complaint("5e-324", "null", Some(9)).contains("null"));
    assert!(schema_complaint("\"joints\": [", "\"joints\": [],\"x\": [", None).contains("0 joints"));
    assert!(schema_complaint("{", "", Some(2)).contains("an object"));
}

#[test]
fn a_schema_with_more_fields_is_read() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join(SCHEMA_FILE);
    write_schema(&path, &creature(), &schema(), None).unwrap();
    let text = fs::read_to_string(&path).unwrap().replace('{', "{\"deviation\": [0.1, null],");
    fs::write(&path, text).unwrap();
    assert_eq!(read_schema(&path, &creature()).unwrap(), schema());
}

#[test]
fn a_schema_that_could_not_be_read_is_not_written() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join(SCHEMA_FILE);
    let spoils: [fn(&mut BodySchema); 3] = [
        |schema| schema.positions[0].x = f64::NAN,
        |schema| schema.axes[1] *= 2.0,
        |schema| schema.axes.truncate(1),
    ];
    for spoil in spoils {
        let mut schema = schema();
        spoil(&mut schema);
        sentence(&write_schema(&path, &creature(), &schema, None).unwrap_err(), &path, None);
    }
    assert!(!path.exists());
}

fn session() -> Session {
    let effort = Effort { motions: 12, engine_checks: 345, bare: 6, simulated_s: 7.25, ..Effort::default() };
    Session {
        program: PROGRAM.into(),
        engine: "2.2.2".into(),
        model: "mjcf/tot/scene.xml".into(),
        model_hash: "sha256:0".into(),
        recording: None,
        command: ["bodyschema", "babble", "my model.xml"].map(String::from).to_vec(),
        host: Some(Host { cpu: "a processor".into(), cores: 2, os: "an operating system".into() }),
        seed: u64::MAX,
        options: SessionOptions {
            root: Some("trunk".into()),
            touches: 40,
            joints: "torso".into(),
            input: Some("receptor".into()),
            learner: None,
            known: None,
            policy: Some("stages".into()),
            motion: Some("dynamic".into()),
            asked: serde_json::json!({"touches": 40, "joint_noise": 0.1}),
        },
        effort: Some(BabblingEffort {
            of_motions: effort,
            babbling_s: 1.234_567_891,
            ..BabblingEffort::default()
        }),
        agent: agent(),
    }
}

#[test]
fn a_session_reads_back_bit_for_bit() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path().join("new");
    for effort in [None, session().effort] {
        let session = Session { effort, ..session() };
        session.write(&folder).unwrap();
        let read = Session::read(&folder).unwrap();
        assert_eq!(read, session);
        for (a, b) in read.agent.skin().receptors.iter().zip(&session.agent.skin().receptors) {
            assert_eq!(vector_bits([&a.position]), vector_bits([&b.position]));
        }
        assert_eq!(read.agent.creature().joints()[2].coordinates().start, 3);
    }
    let left: Vec<_> = fs::read_dir(&folder).unwrap().map(|entry| entry.unwrap().file_name()).collect();
    assert_eq!(left, [SESSION_FILE]);
}

#[test]
fn a_wrong_session_is_named() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join(SESSION_FILE);
    session().write(folder.path()).unwrap();
    let whole = fs::read_to_string(&path).unwrap();
    let complaint = |from: &str, to: &str, line: Option<usize>| {
        assert!(whole.contains(from), "{whole}");
        fs::write(&path, whole.replacen(from, to, 1)).unwrap();
        sentence(&Session::read(folder.path()).unwrap_err(), &path, line)
    };
    assert!(complaint("bodyschema session", "x", None).contains("\"x\""));
    assert!(complaint("\"version\": 1", "\"version\": 2", None).contains("newer version"));
    assert!(complaint("\"seed\": 18446744073709551615", "\"seed\": -1", Some(14)).contains("invalid value"));
    assert!(complaint("head_01", "head_00", None).contains("\"head_00\" occurs twice"));
    assert!(complaint("\"limb\": 3", "\"limb\": 4", None).contains("\"head_00\" is on a limb"));
    assert!(complaint("\"surface\": 0", "\"surface\": 1", None).contains("\"hand_00\" is on a surface"));
    let half = whole[..whole.len() / 2].trim_end();
    fs::write(&path, half).unwrap();
    let text = sentence(&Session::read(folder.path()).unwrap_err(), &path, Some(half.lines().count()));
    assert!(text.contains("ends in the middle"), "{text}");
}

#[test]
fn an_agent_has_the_limbs_and_surfaces_that_its_skin_is_on() {
    let refused = |spoil: fn(&mut Skin)| {
        let mut skin = skin();
        spoil(&mut skin);
        Agent::new(creature(), skin).unwrap_err().to_string()
    };
    assert!(refused(|skin| skin.receptors[0].limb = 99).contains("\"trunk_00\" is on a limb"));
    assert!(refused(|skin| skin.receptors[0].surface = Some(1)).contains("\"trunk_00\" is on a surface"));
    assert!(refused(|skin| skin.receptors[1].id = "trunk_00".into()).contains("\"trunk_00\" occurs twice"));
    assert!(refused(|skin| skin.receptors[2].normal.x = f64::NAN).contains("\"head_00\" has a number"));
    assert!(refused(|skin| skin.surfaces[0].limb = 4).contains("surface 0"));
}

#[test]
fn a_session_is_replaced_whole_or_not_at_all() {
    let folder = tempfile::tempdir().unwrap();
    session().write(folder.path()).unwrap();
    // Where the new file is to be written, before it is put in the old one's place, there is a folder.
    fs::create_dir(folder.path().join(format!(".{SESSION_FILE}.part"))).unwrap();
    let other = Session { seed: 8, ..session() };
    assert_eq!(
        other.write(folder.path()).unwrap_err().to_string(),
        format!(
            "cannot write {}: is a directory: give another folder with --out",
            folder.path().join(SESSION_FILE).display()
        )
    );
    assert_eq!(Session::read(folder.path()).unwrap(), session());
}

#[test]
fn what_cannot_be_written_or_read_is_named() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("file");
    fs::write(&file, "").unwrap();
    let inside = file.join("session");
    let agent = agent();
    let errors = [
        session().write(&inside).unwrap_err(),
        TouchWriter::create(&inside, &agent).unwrap_err(),
        write_learning_table(&inside, &[]).unwrap_err(),
        write_schema(&inside.join(SCHEMA_FILE), agent.creature(), &schema(), None).unwrap_err(),
    ];
    for error in errors {
        let expected =
            format!("cannot write {}: not a directory: give another folder with --out", inside.display());
        assert_eq!(error.to_string(), expected);
    }
    let missing = folder.path().join("missing");
    let errors = [
        (read_touches(&missing, &agent).unwrap_err(), missing.clone()),
        (read_schema(&missing, agent.creature()).unwrap_err(), missing.clone()),
        (model_hash(&missing).unwrap_err(), missing.clone()),
    ];
    for (error, path) in errors {
        let begin = format!("cannot read {}: no such file or directory: give", path.display());
        assert!(error.to_string().starts_with(&begin), "{error}");
    }
    let error = Session::read(&missing).unwrap_err().to_string();
    assert!(error.starts_with(&format!("{}: no such folder: give one", missing.display())), "{error}");
}

#[cfg(target_os = "linux")]
#[test]
fn a_full_disk_is_named() {
    let folder = tempfile::tempdir().unwrap();
    std::os::unix::fs::symlink("/dev/full", folder.path().join(TOUCHES_FILE)).unwrap();
    let error = TouchWriter::create(folder.path(), &agent()).unwrap_err().to_string();
    assert!(error.contains("touches.jsonl: no space left on device: free some space"), "{error}");
}

#[test]
fn the_learning_table_has_a_row_per_checkpoint() {
    let folder = tempfile::tempdir().unwrap();
    let rows = [(100, 0.1 + 0.2, f64::NAN), (1000, 5.0, 0.5)].map(|(touches, mean, rms)| LearningRow {
        touches,
        heldout_mean_mm: Some(mean),
        fresh_rms: Some(rms),
        ..LearningRow::default()
    });
    write_learning_table(folder.path(), &rows).unwrap();
    let text = fs::read_to_string(folder.path().join(LEARNING_FILE)).unwrap();
    let head = "touches,predicted_gap_mm,predicted_deviation_mm,converged,fresh_rms,heldout_mean_mm,heldout_p95_mm,\
                hand_mean_mm,axis_median_deg\n";
    assert_eq!(text, format!("{head}100,,,,,0.30000000000000004,,,\n1000,,,,0.5,5.0,,,\n"));
    let [first, second] = rows;
    let first = LearningRow { fresh_rms: None, ..first };
    assert_eq!(read_learning_table(folder.path()).unwrap(), [first, second]);
}

#[test]
fn a_model_is_known_by_its_content_and_what_it_includes() {
    let folder = tempfile::tempdir().unwrap();
    let put = |name: &str, text: &str| {
        let path = folder.path().join(name);
        fs::write(&path, text).unwrap();
        path
    };
    let hash = |text: &str| -> String {
        let digest = Sha256::digest(text).iter().map(|byte| format!("{byte:02x}")).collect::<String>();
        format!("sha256:{digest}")
    };
    assert_eq!(model_hash(&put("bare.xml", "<mujoco/>")).unwrap(), hash("<mujoco/>"));
    let body = r#"<mujoco><include file="more.xml"/></mujoco>"#;
    let main =
        put("main.xml", r#"<mujoco><include file="body.xml"/><!-- <include file="no.xml"/> --></mujoco>"#);
    put("body.xml", body);
    put("more.xml", "<mujoco/>");
    let before = model_hash(&main).unwrap();
    let all = format!("{}{body}<mujoco/>", fs::read_to_string(&main).unwrap());
    assert_eq!(before, hash(&all));
    put("more.xml", "<mujoco />");
    assert_ne!(before, model_hash(&main).unwrap());
    put("more.xml", r#"<mujoco><include file="main.xml"/></mujoco>"#);
    assert!(model_hash(&main).unwrap_err().to_string().contains("a second time"));
    fs::remove_file(folder.path().join("more.xml")).unwrap();
    assert!(model_hash(&main).unwrap_err().to_string().contains("more.xml"));
}
