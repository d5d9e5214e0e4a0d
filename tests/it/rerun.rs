//! A session as a recording for Rerun's viewer.

use std::process::Command;

#[cfg(not(feature = "rerun"))]
use crate::common::program::form_without_its_feature;

#[cfg(not(feature = "rerun"))]
#[test]
fn without_rerun_the_mend_is_told() {
    let place = form_without_its_feature("--rrd", "rerun");
    assert!(!place.path().join("s/session.rrd").exists());
}

#[test]
fn a_form_is_asked_for_and_only_one() {
    for arguments in [&["convert", "s"][..], &["convert", "s", "--parquet", "--rrd"]] {
        let output = Command::new(env!("CARGO_BIN_EXE_bodyschema")).args(arguments).output().unwrap();
        assert_eq!(output.status.code(), Some(2), "{}", String::from_utf8_lossy(&output.stderr));
    }
}

#[cfg(feature = "rerun")]
mod recording {
    use std::collections::BTreeMap;
    use std::fs;
    use std::path::Path;

    use crate::common::shell::run;
    use crate::common::{creature, repository, truth};
    use bodyschema::kinematics::limb_frames;
    use bodyschema::record::{LearningRecord, Session, TOUCHES_FILE, read_learning_table, read_touches};
    use nalgebra::{Quaternion, UnitQuaternion, Vector3};
    use re_chunk::Chunk;
    use re_log_encoding::Decoder;
    use re_log_types::LogMsg;

    use super::*;

    /// Most that single precision may take from a place, metres.
    const EXACT: f64 = 1e-6;

    /// What a recording has, by entity; what is the same at all times apart.
    #[derive(Default)]
    struct Read {
        constant: BTreeMap<String, Vec<Chunk>>,
        changing: BTreeMap<String, Vec<Chunk>>,
    }

    impl Read {
        fn new(path: &Path) -> Read {
            let mut found = Read::default();
            let file = std::io::BufReader::new(fs::File::open(path).unwrap());
            for message in Decoder::<LogMsg>::decode_lazy(file) {
                let LogMsg::ArrowMsg(_, message) = message.unwrap() else { continue };
                let chunk = Chunk::from_arrow_msg(&message).unwrap();
                chunk.sanity_check().unwrap();
                let kind = if chunk.is_static() { &mut found.constant } else { &mut found.changing };
                kind.entry(chunk.entity_path().to_string()).or_default().push(chunk);
            }
            found
        }

        fn times(&self, entity: &str, timeline: &str) -> Vec<i64> {
            let column = |chunk: &Chunk| Some(chunk.timelines().get(&timeline.into())?.times_raw().to_vec());
            self.changing[entity].iter().filter_map(column).flatten().collect()
        }

        /// Per row the places or directions that a component has.
        fn vectors(&self, entity: &str, component: &str) -> Vec<Vec<[f64; 3]>> {
            let chunks = self.changing[entity].iter();
            let rows = chunks.flat_map(|chunk| chunk.iter_slices::<[f32; 3]>(component.into()));
            rows.map(|row| row.iter().map(|v| v.map(f64::from)).collect()).collect()
        }

        /// Per row a rotation, x y z w.
        fn rotations(&self, entity: &str) -> Vec<[f64; 4]> {
            let chunks = self.changing[entity].iter();
            let rows =
                chunks.flat_map(|chunk| chunk.iter_slices::<[f32; 4]>("Transform3D:quaternion".into()));
            rows.map(|row| row[0].map(f64::from)).collect()
        }

        fn numbers(&self, entity: &str) -> Vec<f64> {
            let chunks = self.changing[entity].iter();
            chunks
                .flat_map(|chunk| chunk.iter_slices::<f64>("Scalars:scalars".into()).flatten().copied())
                .collect()
        }
    }

    fn near(a: [f64; 3], b: &Vector3<f64>) {
        assert!((Vector3::from(a) - b).norm() < EXACT, "{a:?} is not {b:?}");
    }

    #[test]
    fn a_recording_reads_back_as_bodies_touches_and_errors() {
        let place = tempfile::tempdir().unwrap();
        let model = repository("mjcf/hexapod/hexapod.xml");
        run(
            place.path(),
            &format!("bodyschema babble {} --touches 60 --motion dynamic --out s", model.display()),
        );
        run(place.path(), "bodyschema convert s --rrd && bodyschema convert s --rrd --out again.rrd");
        let (folder, file) = (place.path().join("s"), place.path().join("s/session.rrd"));
        assert!(fs::read(&file).unwrap() == fs::read(place.path().join("again.rrd")).unwrap());
        let read = Read::new(&file);
        assert!(read.constant.contains_key("/"), "the axes of all are not told");

        let session = Session::read(&folder).unwrap();
        let (own, skin) = (session.agent.creature(), session.agent.skin());
        let touches = read_touches(&folder.join(TOUCHES_FILE), &session.agent).unwrap().touches;
        let true_body = truth(&creature(&fs::read_to_string(&model).unwrap()));
        let initial_guess = own.reference_posture();
        let postures: Vec<_> =
            std::iter::once(&initial_guess).chain(touches.iter().map(|touch| &touch.posture)).collect();
        let counts: Vec<i64> = (0..=60).collect();
        assert_eq!(read.times("/true/skeleton", "touch"), counts);
        assert_eq!(read.times("/touch/place", "touch"), counts[1..]);
        let seconds = read.times("/true/skeleton", "time");
        assert!(seconds.len() == 61 && seconds[0] == 0 && seconds.is_sorted() && seconds[60] > 0);

        // The true body, by its skin and by where it touches itself.
        let frames: Vec<_> = postures.iter().map(|posture| limb_frames(own, &true_body, posture)).collect();
        for (limb, name) in own.limbs().iter().enumerate() {
            if !skin.receptors.iter().any(|receptor| receptor.limb == limb) {
                continue;
            }
            let entity = format!("/true/skin/{name}");
            let origins = read.vectors(&entity, "Transform3D:translation");
            let turned = read.rotations(&entity);
            assert_eq!((origins.len(), turned.len()), (61, 61));
            for ((frames, origin), turned) in frames.iter().zip(origins).zip(turned) {
                let [x, y, z, w] = turned;
                let rotation = UnitQuaternion::new_normalize(Quaternion::new(w, x, y, z));
                near(origin[0], &frames[limb].origin);
                assert!((rotation.to_rotation_matrix().matrix() - frames[limb].rotation).norm() < 1e-5);
            }
        }
        let receptors = read.vectors("/touch/receptors", "Points3D:positions");
        let places = read.vectors("/touch/place", "Points3D:positions");
        for (((touch, frames), two), place) in touches.iter().zip(&frames[1..]).zip(receptors).zip(places) {
            let mut middle = Vector3::zeros();
            for (end, shown) in touch.ends.iter().zip(two) {
                let receptor = &skin.receptors[end.receptor];
                near(shown, &frames[receptor.limb].point(&receptor.position));
                middle += frames[receptor.limb].point(&end.contact) / 2.0;
            }
            near(place[0], &middle);
        }

        // The learned one, by the last checkpoint until then.
        let checkpoints = LearningRecord::read(&folder, own).unwrap().unwrap().checkpoints;
        let joints = read.vectors("/learned/joints", "Points3D:positions");
        let arrows = read.vectors("/learned/axes", "Arrows3D:vectors");
        let first = read.times("/learned/joints", "touch")[0] as usize;
        assert_eq!(joints.len(), 61 - first);
        for ((k, joints), arrows) in (first..).zip(joints).zip(arrows) {
            let schema = &checkpoints.iter().rfind(|at| at.touches <= k).unwrap().schema;
            let frames = limb_frames(own, schema, postures[k]);
            for ((joint, l_p), shown) in own.joints().iter().zip(&schema.positions).zip(joints) {
                near(shown, &frames[joint.parent].point(l_p));
            }
            // A joint's first axis is turned by its parent alone, and all arrows are as long.
            let length = Vector3::from(arrows[0]).norm();
            for joint in own.joints() {
                let dof = joint.first_dof();
                let axis = frames[joint.parent].rotation * schema.axes[dof];
                near(arrows[dof], &(axis * length));
            }
        }

        let table = read_learning_table(&folder).unwrap();
        let column = table.columns.iter().position(|name| name == "heldout_mean_mm").unwrap();
        let told: Vec<f64> = table.rows.iter().filter_map(|row| row[column]).collect();
        assert!(!told.is_empty());
        assert_eq!(read.numbers("/error/heldout_mean_mm"), told);
    }

    #[test]
    fn a_body_without_a_model_is_shown_as_it_was_learned() {
        let place = tempfile::tempdir().unwrap();
        let robot = r#"{"name": "arm", "limbs": ["base", "forearm"], "joints": [{"name": "elbow", "parent": "base",
            "dofs": [{"name": "elbow_pitch", "kind": "hinge", "range": [-1.5, 1.5]}]}]}"#;
        let log = "limb_a,limb_b,ax,ay,az,bx,by,bz,elbow_pitch\n\
                   base,forearm,0.08,0.01,0.02,0.21,0.00,0.01,0.75\n\
                   base,forearm,0.05,0.02,0.02,0.19,0.01,0.00,1.10\n";
        fs::write(place.path().join("robot.json"), robot).unwrap();
        fs::write(place.path().join("touches.csv"), log).unwrap();
        run(place.path(), "bodyschema learn --creature robot.json --log touches.csv --out s");
        run(place.path(), "bodyschema convert s --rrd");
        let read = Read::new(&place.path().join("s/session.rrd"));
        assert!(!read.changing.keys().any(|entity| entity.starts_with("/true")));
        for entity in
            ["/learned/skeleton", "/learned/joints", "/learned/axes", "/touch/receptors", "/touch/place"]
        {
            assert!(read.changing.contains_key(entity), "no {entity} among {:?}", read.changing.keys());
        }
        assert!(read.times("/learned/skeleton", "time").is_empty());
    }

    #[test]
    fn a_file_that_cannot_be_written_leaves_nothing() {
        let place = tempfile::tempdir().unwrap();
        let model = repository("mjcf/hexapod/hexapod.xml");
        run(
            place.path(),
            &format!("bodyschema babble {} --touches 20 --learner hersch --out s", model.display()),
        );
        let mut convert = Command::new(env!("CARGO_BIN_EXE_bodyschema"));
        let arguments = ["convert", "s", "--rrd", "--out", "missing/session.rrd"];
        let output = convert.args(arguments).current_dir(place.path()).output().unwrap();
        let message = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(1), "{message}");
        assert!(message.contains("cannot write missing/session.rrd"), "{message}");
    }
}
