//! Every reader of a file, with a good file.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use bodyschema::agent::Agent;
use bodyschema::senses::Firing;
use bodyschema::session::{
    BabblingProgress, LearningRecord, Session, SpaceRecord, SpaceSlice, read_calibration_log, read_creature,
    read_firings, read_known, read_learning_table, read_map, read_recording, read_robot,
    read_schema_with_std, read_touches, write_firings, write_map,
};
use bodyschema::simulation::partner::Script;
use bodyschema::skin::SomatotopicMap;
use bodyschema::study::{Asked, StudyOptions, StudyShare};
use serde_json::Value;
use tempfile::TempDir;

use crate::common::program::succeeds;
use crate::common::{repository, two_arms};

/// How long a process may take before it hangs: a learner tries guess after guess where touches tell little, ten seconds of a
/// processor that others may use as well.
const PATIENCE: Duration = Duration::from_secs(300);

/// How reading a file ends.
pub enum Ending {
    /// It is taken: what it is read as.
    Accepted(String),
    /// It is refused with a sentence.
    Refused(String),
    /// A process does not come to an end.
    Hang,
    /// A process panics.
    Panic(String),
    /// A process is ended by a signal.
    Signal(i32),
}

/// What reads files of a kind.
pub struct Reader {
    /// What it reads.
    pub name: &'static str,
    /// The file's name where it is read.
    pub file: PathBuf,
    /// A good file.
    pub good: Vec<u8>,
    /// Of so many inputs in all, how many are its.
    pub share: usize,
    /// Whether a process of its own reads.
    pub process: bool,
    pub read: Box<dyn Fn(&Path) -> Ending + Sync>,
}

/// A folder in which files are read, and a session that is whole.
pub struct Yard {
    pub place: TempDir,
}

pub const CREATURE: &str = r#"{
  "name": "crane", "limbs": ["base", "turret", "arm"],
  "joints": [
    {"name": "bearing", "parent": "base", "limb": "turret", "dofs": [{"name": "turn", "kind": "ball"}]},
    {"name": "boom", "parent": "turret", "dofs": [
      {"name": "lift", "kind": "hinge", "range": [-1.5, 1.5]}, {"name": "reach", "kind": "slide", "range": [0.0, 0.5]}]}],
  "skin": {"receptors": [{"id": "r", "limb": "arm", "position": [0, 0, 0.1], "normal": [0, 0, 1], "tangent": [1, 0, 0],
    "half_extents": [0.01, 0.01], "surface": 0}],
    "surfaces": [{"limb": "arm", "origin": [0, 0, 0], "rotation": [1, 0, 0, 0, 1, 0, 0, 0, 1],
      "shape": {"capsule": {"radius": 0.1, "half_length": 0.2}}}]}
}"#;
pub const LOG: &str = "limb_a,limb_b,ax,ay,az,bx,by,bz,turn_w,turn_x,turn_y,turn_z,lift,reach,a_std,b_std
base,arm,0.1,0.2,0.3,-0.1,0,1e-2,1,0,0,0,0.5,0.25,0.001,
base,arm,0.12,0.21,0.32,-0.1,0.01,2e-2,0.6,0.8,0,0,-0.5,0.2,0.001,0.002
base,arm,0.11,0.22,0.33,-0.12,0.02,3e-2,0,0,1,0,0.7,0.1,0.001,0.002
";
const LINES: &str = r#"{"posture": {"turn": [1, 0, 0, 0], "lift": 0.5, "reach": 0.25}, "limbs": ["base", "arm"], "contacts": [[0.1, 0.2, 0.3], [0.1, 0.0, 0.0]]}
{"posture": [1, 0, 0, 0, 0.5, 0.25], "limbs": ["base", "arm"], "contacts": [[0.1, 0.2, 0.3], [0.1, 0.0, 0.0]], "deviations": [0.001, null], "bout": 1, "motion": 2}
{"posture": [0, 1, 0, 0, 0.7, 0.15], "limbs": ["base", "arm"], "contacts": [[0.1, 0.21, 0.31], [0.1, 0.0, 0.1]], "bout": 1, "motion": 3}
"#;
pub const ROBOT: &str = r#"{
  "name": "arm", "limbs": ["base", "upper", "hand"],
  "joints": [{"name": "shoulder", "parent": "base", "position": [0, 0, 0.3], "dofs": [{"name": "shoulder", "kind": "hinge", "range": [-2, 2], "axis": [0, 1, 0]}]},
    {"name": "elbow", "parent": 1, "position": [0.3, 0, 0], "dofs": [{"name": "elbow", "kind": "hinge", "axis": [0, 0, 1]}]}],
  "frames": [{"name": "tool", "on": "hand", "position": [0.1, 0, 0], "rpy": [0, 0.1, 0]}],
  "points": [{"name": "tip", "on": "tool", "position": [0.02, 0, 0]}],
  "surfaces": [{"name": "pad", "on": "base", "position": [0, 0, 0.1], "rpy": [0, 0, 0], "shape": {"box": {"half_extents": [0.1, 0.1, 0.05]}}},
    {"name": "ball", "on": "upper", "shape": {"sphere": {"radius": 0.05}}}, {"name": "table", "on": "base", "shape": "plane"}],
  "masses": [{"on": "hand", "mass": 1.5, "centre": [0.05, 0, 0]}], "gravity": [0, 0, -9.81],
  "values": {"elbow.offset": 0.02, "tip.position": [0.02, 0.001, 0]},
  "free": ["*.offset"], "fix": ["shoulder.offset"], "prior": {"elbow.position": "5 mm", "tip.position": 0.01}
}"#;
pub const ROBOT_LOG: &str = "limb_a,limb_b,ax,ay,az,bx_mm,by_mm,bz_mm,shoulder,elbow_deg,a_std,distance
upper,tip,0.1,0.02,0.03,,,,0.5,40,0.001,0
base,tip,0.1,0.02,0.03,,,,-0.7,-30,0.001,
pad,hand,,,,100,20,3,0.25,20,0.002,0.01
";
const DH: &str = "joint,kind,parent,a,d_mm,alpha_deg,theta,min_deg,max_deg
shoulder,hinge,base,0.1,300,90,0,-120,120
elbow,hinge,,0.3,0,0,0.5,-150,150
lift,slide,,0,0.2,-90,0,,
";
const SCRIPT: &str = r#"{"probes": [{"name": "finger", "path": [{"time": 0, "at": [0.3, 0.1, 0.2]},
 {"time": 1.5, "receptor": "left_r", "height": -0.001}, {"time": 2, "at": [0.3, 0.1, 0.3]}]}]}"#;
const URDF: &str = r#"<?xml version="1.0"?>
<robot name="arm">
  <link name="base"><collision><geometry><sphere radius="0.05"/></geometry></collision></link>
  <link name="upper">
    <inertial><origin xyz="0 0 0.1"/><mass value="1.5"/><inertia ixx="0.1" ixy="0" ixz="0" iyy="0.1" iyz="0" izz="0.1"/></inertial>
    <collision><origin xyz="0 0 0.1" rpy="0 0 0.5"/><geometry><cylinder radius="0.03" length="0.2"/></geometry></collision>
  </link>
  <joint name="shoulder" type="revolute">
    <origin rpy="1.55 -0.3 3.12" xyz="0.1 0 0.30"/><parent link="base"/><child link="upper"/>
    <axis xyz="0 0 2"/><limit lower="-1.0" upper="2" effort="5" velocity="1"/>
  </joint>
  <link name="tip"><collision><geometry><box size="0.1 0.05 0.02"/></geometry></collision></link>
  <joint name="finger" type="prismatic"><parent link="upper"/><child link="tip"/><origin xyz="0 0 0.1"/>
    <axis xyz="0.6 0 0.8"/><limit lower="0" upper="0.04" effort="1" velocity="1"/></joint>
  <link name="other"/>
  <joint name="thumb" type="prismatic"><parent link="upper"/><child link="other"/><axis xyz="0 -1 0"/>
    <mimic joint="finger" multiplier="-0.5"/></joint>
</robot>
"#;

fn taken<T: std::fmt::Debug, E: std::fmt::Display>(read: Result<T, E>) -> Ending {
    match read {
        Ok(value) => Ending::Accepted(format!("{value:?}")),
        Err(error) => Ending::Refused(error.to_string()),
    }
}

/// How the program ends with some arguments, told by its exit code and whether it says so in a sentence.
pub fn program(arguments: &[&std::ffi::OsStr], inputs: &Path) -> Ending {
    let mut command = Command::new(env!("CARGO_BIN_EXE_bodyschema"));
    command.args(arguments).current_dir(inputs).env("RUST_BACKTRACE", "0").env("RAYON_NUM_THREADS", "1");
    let mut child =
        command.stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::piped()).spawn().unwrap();
    let mut pipe = child.stderr.take().unwrap();
    let said = std::thread::spawn(move || {
        let mut bytes = Vec::new();
        std::io::Read::read_to_end(&mut pipe, &mut bytes)
            .map(|_| String::from_utf8_lossy(&bytes).into_owned())
    });
    let began = Instant::now();
    let status = loop {
        if let Some(status) = child.try_wait().unwrap() {
            break status;
        }
        if began.elapsed() > PATIENCE {
            child.kill().unwrap();
            child.wait().unwrap();
            return Ending::Hang;
        }
        std::thread::sleep(Duration::from_millis(1));
    };
    let said = said.join().unwrap().unwrap_or_default();
    match (status.code(), std::os::unix::process::ExitStatusExt::signal(&status)) {
        (_, Some(signal)) => Ending::Signal(signal),
        _ if said.contains("panicked at") => Ending::Panic(said),
        (Some(0), _) => Ending::Accepted(said),
        (Some(1 | 2), _) if !said.trim().is_empty() => Ending::Refused(said),
        (code, _) => Ending::Panic(format!("exit code {code:?} without a sentence: {said}")),
    }
}

impl Yard {
    /// A folder with a session of two arms in `s`.
    pub fn new() -> Yard {
        let yard = Yard { place: tempfile::tempdir().unwrap() };
        let arms = two_arms(r#"type="capsule" size="0.12 0.2""#, r#"type="capsule" size="0.03 0.2""#);
        fs::write(yard.path("arms.xml"), arms).unwrap();
        let babble = ["babble", "arms.xml", "--touches", "60", "--learner", "lm", "--out", "s", "--quiet"];
        succeeds(yard.place.path(), &babble);
        yard
    }

    pub fn path(&self, name: &str) -> PathBuf {
        self.place.path().join(name)
    }

    fn of_session(&self, name: &str) -> Vec<u8> {
        fs::read(self.path("s").join(name)).unwrap()
    }

    /// All readers.
    pub fn readers(&self) -> Vec<Reader> {
        let session = Session::read(&self.path("s")).unwrap();
        let agent: Agent = session.agent.clone();
        let (folder, creature) = (self.path("r"), agent.creature().clone());
        fs::create_dir_all(&folder).unwrap();
        let crane = self.path("crane.json");
        fs::write(&crane, CREATURE).unwrap();
        let crane = read_creature(&crane).unwrap().agent;
        let robot_file = self.path("robot.json");
        fs::write(&robot_file, ROBOT).unwrap();
        let robot = read_robot(&robot_file).unwrap().robot;
        let mut readers = Vec::new();
        let mut add = |name, file: &str, good: &[u8], share, read: Box<dyn Fn(&Path) -> Ending + Sync>| {
            // As other changes write it, so that what differs is what was changed.
            let good = serde_json::from_slice::<Value>(good)
                .map_or(good.to_vec(), |value| serde_json::to_vec_pretty(&value).unwrap());
            readers.push(Reader { name, file: folder.join(file), good, share, process: false, read });
        };
        fn within(path: &Path) -> &Path {
            path.parent().unwrap()
        }
        add(
            "session",
            "session.json",
            &self.of_session("session.json"),
            14,
            Box::new(|path| taken(Session::read(within(path)))),
        );
        let of = agent.clone();
        add(
            "touches",
            "touches.jsonl",
            &self.of_session("touches.jsonl"),
            10,
            Box::new(move |path| taken(read_touches(path, &of))),
        );
        let of = creature.clone();
        add(
            "schema",
            "schema.json",
            &self.of_session("schema.json"),
            10,
            Box::new(move |path| taken(read_schema_with_std(path, &of))),
        );
        let of = creature.clone();
        let known = self.of_session("schema.json");
        add("known", "known.json", &known, 6, Box::new(move |path| taken(read_known(path, &of))));
        let of = creature.clone();
        add(
            "learning record",
            "learning.json",
            &self.of_session("learning.json"),
            6,
            Box::new(move |path| taken(LearningRecord::read(within(path), &of))),
        );
        add(
            "learning table",
            "learning.csv",
            &self.of_session("learning.csv"),
            5,
            Box::new(|path| taken(read_learning_table(within(path)))),
        );
        let slice = SpaceSlice {
            name: "from above".into(),
            axes: [0, 1],
            at: 0.2,
            first: [-0.4, -0.4],
            rows: vec!["00120".into(), "04321".into()],
            outlines: vec![vec![[0.1, 0.2], [0.2, 0.3]]],
        };
        let space = SpaceRecord {
            chest: "trunk".into(),
            hands: vec!["left_fore".into()],
            voxel: 0.05,
            litres: vec![[1.5, 2.5]],
            doubts: Vec::new(),
            slices: vec![slice],
        };
        space.write(&folder).unwrap();
        let good = fs::read(folder.join("space.json")).unwrap();
        add("space", "space.json", &good, 3, Box::new(|path| taken(SpaceRecord::read(within(path)))));
        let effort = session.effort.unwrap();
        BabblingProgress { bouts: 3, touches: 40, effort }.write(&folder).unwrap();
        let good = fs::read(folder.join("babbling.json")).unwrap();
        add(
            "progress",
            "babbling.json",
            &good,
            2,
            Box::new(|path| {
                taken(
                    BabblingProgress::read(within(path))
                        .map(|progress| (progress, progress.done()))
                        .ok_or("not used"),
                )
            }),
        );
        let share = StudyShare {
            share: "3/16".into(),
            command: ["bodyschema", "study", "learners", "--shard", "3/16"].map(String::from).to_vec(),
            asked: Asked {
                study: "learners".into(),
                program: "bodyschema".into(),
                engine: "2.2.2".into(),
                options: StudyOptions { trials: 40, seed: 7, ..StudyOptions::default() },
                creature: None,
            },
        };
        fs::write(folder.join("study-share.json"), serde_json::to_string_pretty(&share).unwrap()).unwrap();
        let good = fs::read(folder.join("study-share.json")).unwrap();
        let read = |path: &Path| taken(StudyShare::read(within(path)));
        add("share of a study", "study-share.json", &good, 2, Box::new(read));
        let firings = (0..6).map(|k| {
            let first = 0.1 * k as f64;
            Firing { receptor: k % 3, span: [first, first + 0.05] }
        });
        let firings: Vec<Firing> = firings.collect();
        write_firings(&folder, creature.name(), agent.skin(), &firings).unwrap();
        let good = fs::read(folder.join("firings.jsonl")).unwrap();
        let of = agent.clone();
        add(
            "firings",
            "firings.jsonl",
            &good,
            3,
            Box::new(move |path| taken(read_firings(path, of.creature().name(), of.skin()))),
        );
        let map = SomatotopicMap::of_links(agent.skin().receptors.len(), [[0, 1], [1, 2]]);
        write_map(&self.path("map.json"), creature.name(), agent.skin(), &map).unwrap();
        let good = fs::read(self.path("map.json")).unwrap();
        let of = agent.clone();
        add(
            "map",
            "map.json",
            &good,
            3,
            Box::new(move |path| taken(read_map(path, of.creature().name(), of.skin()))),
        );
        add("creature", "creature.json", CREATURE.as_bytes(), 8, Box::new(|path| taken(read_creature(path))));
        let of = crane.clone();
        add(
            "recording, CSV",
            "log.csv",
            LOG.as_bytes(),
            7,
            Box::new(move |path| taken(read_recording(path, &of))),
        );
        add(
            "recording, JSON",
            "log.jsonl",
            LINES.as_bytes(),
            7,
            Box::new(move |path| taken(read_recording(path, &crane))),
        );
        add("robot, JSON", "robot.json", ROBOT.as_bytes(), 8, Box::new(|path| taken(read_robot(path))));
        add("robot, URDF", "robot.urdf", URDF.as_bytes(), 7, Box::new(robot_but_mjcf));
        add("robot, DH", "dh.csv", DH.as_bytes(), 6, Box::new(robot_but_mjcf));
        add(
            "robot's log",
            "robot.csv",
            ROBOT_LOG.as_bytes(),
            8,
            Box::new(move |path| taken(read_calibration_log(path, &robot))),
        );
        add("script", "script.json", SCRIPT.as_bytes(), 3, Box::new(|path| taken(Script::read(path))));
        let place = self.place.path().to_path_buf();
        let mut add = |name, file: &str, good: Vec<u8>, share, arguments: &'static [&'static str]| {
            let place = place.clone();
            let read = move |path: &Path| {
                let mut arguments: Vec<&std::ffi::OsStr> =
                    arguments.iter().map(|word| word.as_ref()).collect();
                arguments.push(path.as_os_str());
                program(&arguments, &place)
            };
            readers.push(Reader {
                name,
                file: folder.join(file),
                good,
                share,
                process: true,
                read: Box::new(read),
            });
        };
        add("model, MJCF", "model.xml", fs::read(self.path("arms.xml")).unwrap(), 6, &["rehearse", "--"]);
        add(
            "model, prepared",
            "ant.xml",
            fs::read(repository("mjcf/bodies/ant.xml")).unwrap(),
            3,
            &["rehearse", "--"],
        );
        add(
            "model, newer MJCF",
            "newer.xml",
            fs::read(repository("tests/it/models/newer.xml")).unwrap(),
            3,
            &["rehearse", "--"],
        );
        add("model, URDF", "model.urdf", URDF.into(), 4, &["rehearse", "--"]);
        for reader in &mut readers {
            reader.share *= 10;
        }
        readers
    }
}

/// A robot that MuJoCo does not read: that one may crash, and has a process of its own.
fn robot_but_mjcf(path: &Path) -> Ending {
    if bodyschema::session::is_mjcf(path) {
        return Ending::Refused("MJCF is read by processes of their own".into());
    }
    taken(read_robot(path))
}
