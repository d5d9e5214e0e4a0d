//! What a creature does when it is talked to, and that it does nothing when it is asked, forbidden, or told of what is past.

use std::io::Write;
use std::process::{Command, Stdio};

use crate::common::shell::{copy_models, run};
use crate::common::{repository, sessions};
use crate::interaction::{at_table, learned_max};
use bodyschema::interaction::{Conversation, Intent, Reply};
use bodyschema::simulation::Stage;
use nalgebra::{Point3, Vector3};

/// Says something, and shows what is answered.
pub fn say(talk: &mut Conversation, request: &str) -> Reply {
    let reply = talk.hear(request).unwrap();
    eprintln!("> {request}\n{}", reply.said);
    reply
}

/// The scene of the paper's section 4, in its words; where things end is where they were to be put.
#[test]
fn the_papers_scene_word_for_word() {
    let (stage, mut talk) = at_table(learned_max(400));
    let place = |thing: usize| stage.thing_pose(thing).translation.vector;
    let reply = say(&mut talk, "Reach for an object near to your body.");
    assert_eq!((reply.intent, reply.done), (Intent::Explore, Some(true)), "{}", reply.said);
    let thing = reply.felt[0]["thing"].as_u64().unwrap() as usize;
    let found = place(thing);
    let reply = say(&mut talk, "Where do you feel this?");
    assert!(reply.said.contains("receptor"), "{}", reply.said);
    let reply = say(&mut talk, "Touch it with your other hand.");
    assert_eq!((reply.intent, reply.done), (Intent::Touch, Some(true)), "{}", reply.said);
    assert!((place(thing) - found).norm() < 0.05, "touching does not carry it off: {} {found}", place(thing));
    let reply = say(&mut talk, "Put it as far away as possible.");
    assert_eq!((reply.intent, reply.done), (Intent::PutFar, Some(true)), "{}", reply.said);
    let far = place(thing);
    assert!(far.x > found.x + 0.02, "from {found} to {far}");
    let reply = say(&mut talk, "Lean forward and try again.");
    assert_eq!((reply.intent, reply.done), (Intent::LeanForward, Some(true)), "{}", reply.said);
    let farther = place(thing);
    assert!(farther.x > far.x + 0.05 && farther.z > 0.98, "from {far} to {farther}");
    // What he says of where it is now is where it is.
    let at = reply.felt[0]["at"].as_array().unwrap().iter().map(|x| x.as_f64().unwrap());
    let at = stage.root_pose() * Point3::from(Vector3::from_iterator(at));
    assert!((at.coords - farther).norm() < 0.1, "{at} and {farther}");
}

#[test]
fn questions_prohibitions_and_reports_do_not_move_him() {
    let (stage, mut talk) = at_table(learned_max(400));
    let reply = say(&mut talk, "is there something in front of you?");
    assert_eq!(reply.done, Some(true), "{}", reply.said);
    let reply = say(&mut talk, "touch your belly");
    assert_eq!((reply.intent, reply.done), (Intent::TouchOwn, Some(true)), "{}", reply.said);
    let posture = talk.actor.posture();
    let time = stage.time();
    for (request, intent) in [
        ("don't touch it", Intent::Dont),
        ("what did you touch?", Intent::Report),
        ("did you touch it?", Intent::Report),
        ("where is your left elbow?", Intent::WhereOwn),
        ("is it near or far?", Intent::NearOrFar),
        ("can you reach it?", Intent::NearOrFar),
        ("how far is it?", Intent::HowFar),
        ("how big is it?", Intent::HowBig),
        ("how many things are there?", Intent::HowMany),
        ("what do you feel?", Intent::WhatFelt),
        ("keep still", Intent::KeepStill),
        ("sing a song", Intent::Unknown),
        ("hello", Intent::Greet),
        ("touch it", Intent::Touch),
    ] {
        let reply = say(&mut talk, request);
        assert_eq!(reply.intent, intent, "{request}: {}", reply.said);
        assert!(reply.said.len() > 3 && !reply.said.contains('\n'), "{request}");
    }
    assert_eq!(
        (talk.actor.posture(), stage.time()),
        (posture, time),
        "he has not moved, nor has time gone on"
    );
    // He was told not to; asked whether he should, he does.
    let reply = say(&mut talk, "yes");
    assert_eq!(reply.intent, Intent::Touch, "{}", reply.said);
    assert!(stage.time() > time);
    let reply = say(&mut talk, "what did you do?");
    assert!(reply.said.contains("felt around") && reply.said.contains("belly"), "{}", reply.said);
}

#[test]
fn how_big_a_thing_is_he_tells_once_he_has_felt_its_shape() {
    // He pushes the thing in feeling it, here and in about half of all conversations, and then has to claim nothing.
    tells_how_big_once_he_has_felt_it(at_table(learned_max(400)));
}

/// Whether he came to know a thing's shape; what he says of its size is true either way.
fn tells_how_big_once_he_has_felt_it((stage, mut talk): (Stage, Conversation)) -> bool {
    let reply = say(&mut talk, "is there something in front of you?");
    let thing = reply.felt[0]["thing"].as_u64().unwrap() as usize;
    let before = say(&mut talk, "how big is it?").said;
    assert!(before.contains("only one place"), "{before}");
    let reply = say(&mut talk, "feel its shape");
    assert_eq!(reply.intent, Intent::FeelShape, "{}", reply.said);
    let time = stage.time();
    if reply.done == Some(false) {
        assert!(reply.said.contains("I do not know its shape"), "{}", reply.said);
        let said = say(&mut talk, "how big is it?").said;
        assert!(said.contains("only one place"), "{said}");
        return false;
    }
    let said = say(&mut talk, "how big is it?").said;
    assert_eq!(stage.time(), time, "what he has felt he only tells");
    // Height, length and width as the scene has them, centimetres.
    let truly = match stage.thing_name(thing).as_str() {
        "box" => [10.0, 7.0, 7.0],
        "can" => [11.0, 6.6, 6.6],
        "brick" => [7.0, 11.0, 6.0],
        "bottle" => [18.0, 6.0, 6.0],
        other => panic!("{other}"),
    };
    let told: Vec<f64> = said
        .split(" cm")
        .filter_map(|part| part.rsplit(' ').next().and_then(|number| number.parse().ok()))
        .collect();
    assert_eq!(told.len(), 3, "{said}");
    assert!(told.iter().zip(truly).all(|(told, truly)| (told - truly).abs() <= 2.0), "{said}: {truly:?}");
    true
}

#[test]
fn parts_of_his_body_are_where_they_truly_are() {
    let (stage, mut talk) = at_table(learned_max(400));
    let limb = |name: &str| stage.agent().creature().limb(name).unwrap();
    let reply = say(&mut talk, "where is your left elbow?");
    // "3 cm behind my pelvis, 25 cm to my left, 30 cm above it."
    let numbers: Vec<f64> = reply.said.split(' ').filter_map(|word| word.parse().ok()).collect();
    let truth = stage.limb_frames()[limb("left_forearm")].origin;
    let truth = stage.root_pose().inverse_transform_point(&Point3::from(truth)).coords;
    for (said, truth) in numbers.iter().zip([truth.x, truth.y, truth.z]) {
        assert!((said - 100.0 * truth.abs()).abs() < 1.5, "{} and {truth}", reply.said);
    }
    assert_eq!(numbers.len(), 3, "{}", reply.said);
    for part in ["nose", "chin", "belly", "right elbow", "left forearm", "chest"] {
        let reply = say(&mut talk, &format!("touch your {part}"));
        assert_eq!((reply.intent, reply.done), (Intent::TouchOwn, Some(true)), "{}", reply.said);
    }
}

#[test]
fn talk_ends_where_it_is_told_to_and_takes_any_bytes() {
    let mut child = Command::new(env!("CARGO_BIN_EXE_bodyschema"))
        .args(["talk", repository("mjcf/max/table.xml").to_str().unwrap(), "max", "--json"])
        .current_dir(sessions::max())
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let mut input = child.stdin.take().unwrap();
    input.write_all(b"hello\n\n\xff\xfe what is this\nwho are you?\nquit\nhelp\n").unwrap();
    drop(input);
    let output = child.wait_with_output().unwrap();
    let said = String::from_utf8(output.stdout).unwrap();
    assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
    let replies: Vec<serde_json::Value> =
        said.lines().map(|line| serde_json::from_str(line).unwrap()).collect();
    let intents: Vec<&str> = replies.iter().map(|reply| reply["intent"].as_str().unwrap()).collect();
    assert_eq!(
        (intents.first(), intents.last(), intents.len()),
        (Some(&"greet"), Some(&"quit"), 4),
        "{said}"
    );
    for key in ["heard", "intent", "said", "done", "asks", "felt"] {
        assert!(replies.iter().all(|reply| reply.get(key).is_some()), "{key}");
    }
}

#[test]
fn a_demonstration_learns_once_and_says_where_to_look() {
    let place = tempfile::tempdir().unwrap();
    copy_models(place.path());
    for (learned, printed) in [("--out sessions/demo", "Learned"), ("is complete", "Goodbye")] {
        let line = "echo goodbye | bodyschema demo 2>&1";
        let said = run(place.path(), line);
        for words in
            [learned, printed, "sessions/demo/report.html in one yourself", "live at http://127.0.0.1:"]
        {
            assert!(said.contains(words), "{words}: {said}");
        }
    }
}
