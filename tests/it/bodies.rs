//! Generated bodies: the same on every machine, as they are described, of all kinds and sizes; and the study of them.

use std::collections::BTreeSet;
use std::sync::Arc;
use std::time::{Duration, Instant};

use crate::common::program::{refused, succeeds};
use crate::common::{at_random, repository};
use bodyschema::agent::Agent;
use bodyschema::creature::{Body, DofKind, JointSelection};
use bodyschema::deadline::Deadline;
use bodyschema::learning::{Input, Learner, SecondOrder, Verdict};
use bodyschema::mujoco::Model;
use bodyschema::study::generated::{DrawnBody, Family, GeneratedBody, LENGTHS};
use bodyschema::study::{Study, StudyOptions, StudyRun};
use sha2::{Digest, Sha256};

/// Seeds that are looked at.
const SEEDS: std::ops::RangeInclusive<u64> = 1..=200;

#[test]
fn a_seed_gives_the_same_bytes_for_ever() {
    let found = [1, 7, 27, 45].map(|seed| {
        let hash = Sha256::digest(GeneratedBody::new(seed).mjcf);
        hash[..4].iter().map(|byte| format!("{byte:02x}")).collect::<String>()
    });
    assert_eq!(found, ["cfdb0ed2", "6b45b427", "6385d835", "74c1ce14"]);
}

#[test]
fn every_body_loads_and_is_what_it_is_said_to_be() {
    for seed in SEEDS {
        let GeneratedBody { drawn, mjcf, .. } = GeneratedBody::new(seed);
        let model = Model::from_xml(&mjcf).unwrap_or_else(|error| panic!("seed {seed}: {error}"));
        assert_eq!(model.warning(), None, "seed {seed}");
        let body = Body::new(Arc::new(model), &JointSelection::All).unwrap();
        let creature = &body.creature;
        let of_kind = |kind: DofKind| creature.dofs().filter(|dof| dof.kind == kind).count();
        let found = [DofKind::Hinge, DofKind::Slide, DofKind::Ball].map(of_kind);
        assert_eq!(found, [drawn.hinges, drawn.slides, drawn.balls], "seed {seed}");
        assert_eq!(creature.dof(), drawn.dof, "seed {seed}");
        assert_eq!(creature.limbs().len(), drawn.limbs + drawn.bare, "seed {seed}");
        assert_eq!(
            creature.dofs().filter(|dof| dof.follows.is_some()).count(),
            drawn.followers,
            "seed {seed}"
        );
        assert_eq!(creature.name(), format!("body-{seed}"));
        assert!(creature.dofs().all(|dof| dof.range[0] < dof.range[1]), "seed {seed}");
        assert!(creature.dofs().all(|dof| dof.range[0] <= 0.0 && dof.range[1] > 0.0), "seed {seed}");
    }
}

#[test]
fn families_sizes_and_joints_of_all_kinds_occur() {
    let drawn: Vec<_> = SEEDS.map(|seed| GeneratedBody::new(seed).drawn).collect();
    for family in Family::ALL {
        let count = drawn.iter().filter(|body| body.family == family.name()).count();
        assert!(count >= 10, "{family}: {count}");
    }
    let [least, most] = LENGTHS;
    assert!(drawn.iter().all(|body| (least..=most).contains(&body.length)));
    for decade in [0.01, 0.1, 1.0] {
        let count = drawn.iter().filter(|body| (decade..10.0 * decade).contains(&body.length)).count();
        assert!((40..=100).contains(&count), "{count} bodies from {decade} m on");
    }
    let kinds = |body: &DrawnBody| {
        let DrawnBody { slides, balls, locked, spins, followers, welded, bare, skew, .. } = *body;
        [slides, balls, locked, spins, followers, welded, bare]
            .map(|count| count > 0)
            .into_iter()
            .chain([skew == 0.0, skew > 1.0])
    };
    for kind in 0..kinds(&drawn[0]).count() {
        let having = drawn.iter().filter(|body| kinds(body).nth(kind) == Some(true)).count();
        assert!(having >= 5, "kind {kind}: {having} bodies");
    }
    let texts: BTreeSet<String> = SEEDS.map(|seed| GeneratedBody::new(seed).mjcf).collect();
    assert_eq!(texts.len(), SEEDS.count(), "every seed another body");
    for part in ["<freejoint", "<touch ", "type=\"ellipsoid\"", "type=\"cylinder\"", "type=\"box\""] {
        let count = texts.iter().filter(|text| text.contains(part)).count();
        assert!((20..200).contains(&count), "{count} bodies have {part}");
    }
}

/// Small bodies that are soon learned.
const SMALL: [u64; 3] = [8, 12, 46];

#[test]
fn of_small_bodies_nothing_is_claimed_wrongly() {
    let study = Study::of_name("bodies").unwrap();
    let mut learned = 0;
    for seed in SMALL {
        let cases = ["default", "lm", "hersch", "contact", "contact, angles"].map(String::from).to_vec();
        let options = StudyOptions { trials: 1, seed, touches: Some(150), cases, ..StudyOptions::default() };
        let found = StudyRun::new(study, options, None).unwrap().findings(|_| true).unwrap();
        let rows = found.table().to_json();
        let rows = rows.as_array().unwrap();
        let ways: Vec<&str> = rows.iter().map(|row| row["way"].as_str().unwrap()).collect();
        assert_eq!(ways[..4], ["default", "lm", "hersch", "contact"]);
        assert_eq!(ways[4..], ["contact, angles to 0.1°", "contact, angles to 1°"]);
        for row in rows {
            let count = |name: &str| row[name].as_u64().unwrap_or_else(|| panic!("{name}: {row}"));
            assert_eq!((&row["seed"], count("wrong")), (&seed.into(), 0), "{row}");
            assert!(count("claims") <= count("pairs") && count("joints_named") <= count("joints"), "{row}");
            assert!(row["outcome"] != "panicked" && row["outcome"] != "refused", "{row}");
        }
        let summary = found.summary().to_json();
        let all = summary.as_array().unwrap().iter().find(|row| row["family"] == "all").unwrap();
        assert_eq!((&all["way"], &all["trials"]), (&"default".into(), &1.into()), "{all}");
        learned += all["learned"].as_u64().unwrap() + all["learned_partly"].as_u64().unwrap();
    }
    assert!(learned > 0);
}

#[test]
fn who_has_no_time_is_told_so() {
    let embodied = Agent::from_mjcf(repository("mjcf/hexapod/hexapod.xml")).unwrap();
    let babbled = embodied.babble_as(&at_random(300)).unwrap();
    let learner = |agent| {
        let mut learner = SecondOrder::new(agent, Input::Contact, 1);
        learner.end_at(Deadline::after(Instant::now(), Duration::ZERO));
        learner
    };
    match babbled.learn_with(Input::Contact, learner).unwrap().0.verdict {
        Verdict::Failed(why) => assert!(why.contains("time was up") && why.contains("--seconds"), "{why}"),
        other => panic!("{other:?}"),
    }
}

#[test]
fn the_program_writes_bodies_and_studies_them() {
    let place = tempfile::tempdir().unwrap();
    let text = succeeds(place.path(), &["study", "generate", "--seed", "8"]);
    assert_eq!(text.trim(), GeneratedBody::new(8).mjcf.trim());
    let json = succeeds(
        place.path(),
        &["study", "generate", "--seed", "7", "--count", "3", "--out", "many", "--json"],
    );
    assert_eq!(json.lines().count(), 3);
    for seed in 7..=9 {
        let file = place.path().join(format!("many/body-{seed}.xml"));
        assert_eq!(std::fs::read_to_string(file).unwrap(), GeneratedBody::new(seed).mjcf);
    }
    let message = refused(place.path(), 2, &["study", "generate", "--count", "3"]);
    assert!(message.contains("--out"), "{message}");
    let message = refused(place.path(), 1, &["study", "bodies", "many/body-8.xml"]);
    assert!(message.contains("leave out the model"), "{message}");
    let arguments = ["study", "bodies", "--seed", "8", "--trials", "1", "--touches", "40", "--json"];
    let found: serde_json::Value = serde_json::from_str(&succeeds(place.path(), &arguments)).unwrap();
    assert_eq!((&found["rows"][0]["seed"], &found["rows"][0]["wrong"]), (&8.into(), &0.into()));
    assert!(place.path().join("studies/bodies/study.csv").is_file());
}

/// The row of a study of one body and one way to learn, with some more options.
fn studied(seed: &str, way: &str, options: [&str; 2]) -> serde_json::Value {
    let place = tempfile::tempdir().unwrap();
    let mut command = vec!["study", "bodies", "--trials", "1", "--seed", seed, "--way", way, "--json"];
    command.extend(options);
    let mut found: serde_json::Value = serde_json::from_str(&succeeds(place.path(), &command)).unwrap();
    found["rows"][0].take()
}

/// Two limbs in touch that hardly move while others do close as fast as rounding says.
#[test]
fn a_touch_of_limbs_that_hardly_move_is_in_the_posture_of_its_motion() {
    let row = studied("42108", "default", ["--touches", "250"]);
    // A motion between two that touch already was once an error, after which no touch came.
    assert_eq!(row["reason"], "", "{row}");
    assert!(row["claims"].as_u64().unwrap() >= 60, "{row}");
}

/// `some`: whether anything of the body can be told.
fn nothing_is_claimed_wrongly(seed: &str, way: &str, seconds: &str, some: bool) {
    let row = studied(seed, way, ["--seconds", seconds]);
    assert_eq!(row["claims"].as_u64().unwrap() > 0, some, "{row}");
    assert_eq!(row["wrong"], 0, "{row}");
}

mod slow {
    use super::*;

    /// Bodies that were claimed wrongly once: hands of centimetres, bodies with a joint that hardly turns or slides along its
    /// limb, two fingers of which nothing can be told, whose touches any posture explains, and two bodies of whose touches
    /// most are of two limbs, with a wrong answer that closes them nearly.
    #[test]
    #[ignore = "slow: two minutes"]
    fn bodies_that_were_claimed_wrongly_once_are_not() {
        for (seed, some) in [
            ("22555", true),
            ("30219", true),
            ("33266", true),
            ("33697", true),
            ("32689", false),
            ("36175", true),
            ("36537", true),
        ] {
            nothing_is_claimed_wrongly(seed, "default", "50", some);
        }
    }

    /// The same of `lm`: a hinge with a mirror image that closes all, limbs most of whose touches stay open, and a body that did
    /// not change when all that was known of it turned out to be wrong.
    #[test]
    #[ignore = "slow: two minutes"]
    fn bodies_that_lm_claimed_wrongly_once_are_not() {
        for seed in ["39901", "40002", "40094", "40106"] {
            nothing_is_claimed_wrongly(seed, "lm", "300", true);
        }
        // Of this one the search finds an answer that stands by luck alone.
        assert_eq!(studied("40148", "lm", ["--seconds", "300"])["wrong"], 0);
    }
}

/// By `cargo test large:: -- --ignored`.
mod large {
    use super::*;

    /// Two fingers of which nothing can be told, which are cut short in 50 s, and were claimed wrongly in more.
    #[test]
    #[ignore = "large: a minute"]
    fn fingers_of_which_nothing_can_be_told_are_not_claimed_however_long_they_are_learned() {
        nothing_is_claimed_wrongly("33970", "default", "120", false);
    }
}
