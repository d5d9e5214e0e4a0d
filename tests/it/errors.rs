//! Each error is of one kind, and its predicates are true: what is at fault is what they say.

use std::error::Error as _;
use std::path::Path;
use std::sync::Arc;

use bodyschema::Error;
use bodyschema::agent::Agent;
use bodyschema::babbling::PolicyName;
use bodyschema::learning::{Input, SecondOrder};
use bodyschema::mujoco::{Data, Model};
use bodyschema::session::{FolderLock, Session, own_body, read_calibration_log, read_robot};
use bodyschema::study::Share;

use crate::common::{at_random, repository};

/// The kinds, in the order in which [`kinds`] asks for them.
const KINDS: [&str; 5] = ["file", "model", "engine", "usage", "not learned"];

fn kinds(error: &Error) -> Vec<&'static str> {
    let asked =
        [error.is_file(), error.is_model(), error.is_engine(), error.is_usage(), error.is_not_learned()];
    KINDS.into_iter().zip(asked).filter_map(|(kind, is)| is.then_some(kind)).collect()
}

/// The error for a model that is written into a folder.
fn of_model(folder: &Path, inner: &str) -> Error {
    let path = folder.join("creature.xml");
    std::fs::write(&path, format!("<mujoco><worldbody>{inner}</worldbody></mujoco>")).unwrap();
    Agent::from_mjcf(&path).and_then(|creature| creature.babbler(Default::default()).map(drop)).unwrap_err()
}

#[test]
fn an_error_is_of_the_kind_of_its_cause_and_of_no_other() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name);
    std::fs::write(path("robot.csv"), "no table\n").unwrap();
    std::fs::write(path("log.csv"), "limb_a\nx\n").unwrap();
    let arms = read_robot(&repository("examples/robot/arms.urdf")).unwrap().robot;
    let geom = r#"<geom type="sphere" size="0.1"/>"#;
    let joint = r#"<joint axis="0 0 1" range="-1 1" limited="true"/>"#;
    let alone = format!("<body>{joint}{geom}</body>");
    let still = format!("<body>{geom}</body>");
    let lock = FolderLock::take(folder.path()).unwrap();
    let max = Agent::from_mjcf(repository("mjcf/max/max.xml")).unwrap();
    let agent = max.agent().clone();
    let untouched = max
        .babble_as(&at_random(0))
        .unwrap()
        .learn_with(Input::Contact, |agent| SecondOrder::new(agent, Input::Contact, 1));
    let mut data = Data::new(Arc::new(Model::from_xml("<mujoco/>").unwrap())).unwrap();
    let cases: [(&str, Error, &str, &str); 11] = [
        ("no model", Agent::from_mjcf("no/such.xml").err().unwrap(), "model", "no/such.xml: "),
        ("no MJCF", of_model(folder.path(), "<geom typ='x'/>"), "model", "line 1"),
        ("nothing moves", of_model(folder.path(), &still), "model", "creature.xml: the model has no hinge"),
        ("nothing touches", of_model(folder.path(), &alone), "model", "creature.xml: "),
        ("no session", Session::read(&path("nowhere")).unwrap_err(), "file", "nowhere"),
        ("a log that is none", read_calibration_log(&path("log.csv"), &arms).unwrap_err(), "file", "log.csv"),
        ("no robot", read_robot(&path("robot.csv")).err().unwrap(), "file", "robot.csv"),
        ("in use", FolderLock::take(folder.path()).err().unwrap(), "file", "is writing to it"),
        ("no policy", "by chance".parse::<PolicyName>().unwrap_err(), "usage", "by chance"),
        ("no touch", untouched.err().unwrap(), "not learned", "babble first"),
        ("the engine", data.set_qpos(&[1.0]).unwrap_err().into(), "engine", "qpos"),
    ];
    for (name, error, kind, said) in &cases {
        assert_eq!(kinds(error), [*kind], "{name}: {error}");
        assert!(error.to_string().contains(said), "{name}: {error}");
    }
    let busy: Vec<&str> = cases.iter().filter(|case| case.1.is_busy()).map(|case| case.0).collect();
    let no_contact: Vec<&str> =
        cases.iter().filter(|case| case.1.is_no_contact()).map(|case| case.0).collect();
    assert_eq!((busy, no_contact), (vec!["in use"], vec!["nothing touches"]));
    drop(lock);
    assert!(kinds(&"5/3".parse::<Share>().unwrap_err()) == ["usage"]);
    let other = Agent::from_mjcf(repository("mjcf/hexapod/hexapod.xml")).unwrap();
    assert_eq!(kinds(&agent.with_skin(other.agent().skin().clone()).unwrap_err()), ["usage"]);
    assert_eq!(kinds(&own_body(folder.path()).err().unwrap()), ["file"]);
}

#[test]
fn what_the_system_said_is_the_source_of_an_error() {
    let missing = repository("no/such.urdf");
    let error = read_robot(&missing).err().unwrap();
    let source = error.source().and_then(|source| source.downcast_ref::<std::io::Error>()).unwrap();
    assert_eq!(source.kind(), std::io::ErrorKind::NotFound);
    let sentence = format!("cannot read {}: no such file or directory: ", missing.display());
    assert!(error.is_file() && error.to_string().starts_with(&sentence), "{error}");
    // A thread may hand it on.
    fn is_sent<T: Send + Sync + 'static>(_: &T) {}
    is_sent(&error);
}
