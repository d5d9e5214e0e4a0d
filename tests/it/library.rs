//! The library's front: it does what the program does, and is as small as a person can learn.

use bodyschema::agent::Agent;
use bodyschema::session::{
    SCHEMA_FILE, Session, SessionRequest, TOUCHES_FILE, read_touches, write_schema_with_std,
};

use crate::common::program::succeeds;
use crate::common::repository;

/// Whether the program, with some options, and the library, asked for the same, come to the same touches and schema.
fn does_the_same(model: &str, options: &[&str], request: &SessionRequest) {
    let folder = tempfile::tempdir().unwrap();
    let place = folder.path().join("session");
    let command = [&["babble", model, "--out", place.to_str().unwrap()], options].concat();
    succeeds(&repository("."), &command);
    let babbled = Agent::from_mjcf(repository(model)).unwrap().babble_as(request).unwrap();
    let log = read_touches(&place.join(TOUCHES_FILE), &Session::read(&place).unwrap().agent).unwrap();
    assert!(
        log.touches == babbled.touches(),
        "{model}: {} and {}",
        log.touches.len(),
        babbled.touches().len()
    );
    let learned = babbled.learn().unwrap();
    let creature = learned.embodied().creature();
    let (path, schema) = (folder.path().join("schema.json"), learned.learned());
    write_schema_with_std(&path, creature, &schema.schema, schema.schema_std(creature).as_ref()).unwrap();
    let [by_program, by_library] = [place.join(SCHEMA_FILE), path].map(|path| std::fs::read(path).unwrap());
    assert!(by_program == by_library, "{model}: {:?}", schema.verdict);
}

#[test]
fn the_shortest_path_does_what_the_program_does_by_default() {
    does_the_same("mjcf/bodies/ant.xml", &[], &SessionRequest::default());
}

#[test]
fn a_budget_of_work_ends_both_at_the_same_touch_and_with_the_same_schema() {
    let request = SessionRequest { work: Some(2.0), ..SessionRequest::default() };
    does_the_same("mjcf/max/max.xml", &["--work", "2"], &request);
}
