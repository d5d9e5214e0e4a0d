//! The library's front: it does what the program does, and is as small as a person can learn.

use std::collections::BTreeSet;
use std::path::Path;

use bodyschema::agent::Agent;
use bodyschema::session::{SCHEMA_FILE, Session, SessionRequest, TOUCHES_FILE, read_touches, write_schema};

use crate::common::program::succeeds;
use crate::common::repository;
use crate::house::leaves_of;
use syn::{Attribute, Ident, Item, Visibility};

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
    write_schema(&path, creature, &schema.schema, schema.schema_std(creature).as_ref()).unwrap();
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

/// Most names of the crate's root, those of estimation not counted.
const MOST: usize = 130;
/// The rooms of estimation.
const ESTIMATION: [&str; 2] = ["learning", "calibration"];

/// What is wrong with a crate's root, given the code that shows how its names are used.
fn faults(root: &str, code: &str) -> Vec<String> {
    let used: BTreeSet<&str> = code.split(|c: char| !c.is_alphanumeric() && c != '_').collect();
    let (mut faults, mut counted) = (Vec::new(), 0);
    for item in syn::parse_file(root).unwrap().items {
        match item {
            Item::Use(item) if matches!(item.vis, Visibility::Public(_)) => {
                let mut leaves = Vec::new();
                leaves_of(&item.tree, &mut Vec::new(), &mut leaves);
                for (name, path) in leaves {
                    counted += usize::from(!ESTIMATION.contains(&path[0].as_str()));
                    if !used.contains(name.as_str()) {
                        faults.push(format!("{name} is in no documentation test and no example"));
                    }
                }
            }
            Item::Mod(item) if matches!(item.vis, Visibility::Public(_)) => {
                let hidden = |attribute: &Attribute| {
                    attribute.parse_args::<Ident>().is_ok_and(|word| word == "hidden")
                };
                if !item.attrs.iter().any(hidden) {
                    faults.push(format!("the module {} is shown: name what is public of it", item.ident));
                }
            }
            _ => {}
        }
    }
    println!("{counted} public names");
    if counted > MOST {
        faults.push(format!("{counted} public names: {MOST} at most"));
    }
    faults
}

/// The Rust code in the fenced blocks of a text.
fn fenced(text: &str) -> String {
    let blocks = text.split("```rust\n").skip(1);
    blocks.filter_map(|rest| rest.split("```").next()).collect()
}

#[test]
fn the_library_is_as_small_as_a_person_can_learn_and_each_name_is_shown_in_use() {
    let read = |path: &Path| std::fs::read_to_string(path).unwrap();
    let mut code = fenced(&read(&repository("docs/library.md")));
    for entry in std::fs::read_dir(repository("examples")).unwrap() {
        let path = entry.unwrap().path();
        if path.extension().is_some_and(|extension| extension == "rs") {
            code += &read(&path);
        }
    }
    let root = read(&repository("src/lib.rs"));
    assert_eq!(faults(&root, &code), [""; 0]);
    // Who follows the examples needs nothing that is not promised.
    let inner: Vec<&str> =
        code.split("bodyschema::").skip(1).filter_map(|rest| rest.split("::").next()).collect();
    let modules: Vec<&&str> =
        inner.iter().filter(|name| name.chars().all(|c| c.is_lowercase() || c == '_')).collect();
    assert!(modules.is_empty(), "{modules:?}");
    // What is not shown, a module that is, and a name too many are each found.
    let unused = code.replace("JointSelection", "");
    assert_eq!(faults(&root, &unused), ["JointSelection is in no documentation test and no example"]);
    assert_eq!(
        faults("#[doc(hidden)] pub mod a; pub mod b; mod c;", ""),
        ["the module b is shown: name what is public of it"]
    );
    let names = |count: usize| (0..count).map(|k| format!("n{k}")).collect::<Vec<_>>().join(", ");
    let root_of =
        |count: usize| format!("pub use learning::{{{}}}; pub use skin::{{{}}};", names(9), names(count));
    assert!(faults(&root_of(MOST), &names(MOST)).is_empty());
    assert_eq!(faults(&root_of(MOST + 1), &names(MOST + 1)).len(), 1);
}

#[test]
fn the_front_page_has_only_links_that_lead_somewhere_from_the_site_and_from_rustdoc() {
    let page = std::fs::read_to_string(repository("docs/library.md")).unwrap();
    for link in page.split("](").skip(1).filter_map(|rest| rest.split(')').next()) {
        assert!(link.starts_with('#') || link.starts_with("https://"), "{link}");
    }
    // In rustdoc these would be links, on the site they are not.
    assert!(!page.contains("[`"), "{page}");
}
