//! A limb grows while Max acts: he notices when he touches himself, and learns his body anew by feeling himself over.

use std::io::Write;
use std::process::{Command, Stdio};

use crate::common::{repository, sessions};
use crate::conversation::say;
use crate::interaction::{common_engine, learned_max};
use bodyschema::interaction::{Actor, BodyFound, Conversation, FeltOver, Intent, understood};
use bodyschema::simulation::{Stage, StageOptions};
use nalgebra::{Point3, Vector3};

fn at_the_table(seed: u64) -> (Stage, Conversation) {
    let stage = Stage::new(&repository("mjcf/max/table.xml"), &StageOptions::default()).unwrap();
    let hands = ["left_hand", "right_hand"];
    let mut actor = Actor::new(learned_max(400), stage.handle(), hands, seed).unwrap();
    stage.place(&actor.ready()).unwrap();
    (stage, Conversation::new(actor).unwrap())
}

/// How far off he has the tip of a hand in the posture that he is in, metres.
fn off(stage: &Stage, actor: &Actor, hand: usize) -> f64 {
    let place = actor.own.place(actor.hands[hand].tip);
    let truly = stage.limb_pose(place.limb) * Point3::from(place.point);
    let truly: Vector3<f64> = stage.root_pose().inverse_transform_point(&truly).coords;
    (actor.frames()[place.limb].point(&place.point) - truly).norm()
}

#[test]
fn a_limb_that_grows_is_noticed_and_learned_anew() {
    let (stage, mut talk) = at_the_table(1);
    let hand = stage.agent().creature().limb("left_hand").unwrap();
    let reply = say(&mut talk, "touch your nose with your left hand");
    assert_eq!((reply.done, reply.asks), (Some(true), false), "{}", reply.said);
    stage.grow_limb(hand, 0.03).unwrap();
    assert!((off(&stage, &talk.actor, 0) - 0.03).abs() < 1e-3);

    let reply = say(&mut talk, "touch your nose with your left hand");
    assert!(reply.asks && reply.said.contains("my body may have changed"), "{}", reply.said);
    let reply = say(&mut talk, "no");
    assert!((off(&stage, &talk.actor, 0) - 0.03).abs() < 1e-3, "{}", reply.said);
    let reply = say(&mut talk, "feel yourself over");
    if !common_engine(&stage) && reply.done == Some(false) {
        // Other touches: that he does not find out happens, and he says so.
        assert!(reply.said.contains("not how it has changed"), "{}", reply.said);
        return;
    }
    assert_eq!((reply.intent, reply.done), (Intent::FeelOver, Some(true)), "{}", reply.said);
    assert!(reply.said.contains("my left wrist is 3.0 cm from where I thought"), "{}", reply.said);
    for hand in 0..2 {
        assert!(off(&stage, &talk.actor, hand) < 5e-4, "{}", off(&stage, &talk.actor, hand));
    }
    // And he is not surprised any more.
    let reply = say(&mut talk, "touch your nose with your left hand");
    assert_eq!((reply.done, reply.asks), (Some(true), false), "{}", reply.said);
    let reply = say(&mut talk, "what did you do?");
    assert!(reply.said.contains("explored my body"), "{}", reply.said);
}

#[test]
fn a_body_that_is_as_it_was_is_found_so_and_kept() {
    let (_, mut talk) = at_the_table(2);
    let before = talk.actor.own.schema.clone();
    let found = talk.actor.feel_over().unwrap();
    assert!(matches!(found, FeltOver { touches: 24.., body: BodyFound::Same }), "{found:?}");
    assert_eq!(talk.actor.own.schema, before);
    assert!(talk.actor.take_unexpected().is_none());
}

#[test]
fn feeling_himself_over_is_asked_for_in_words() {
    for said in [
        "feel yourself over",
        "please touch yourself all over",
        "check your body",
        "recalibrate yourself",
        "learn your body anew",
        "could you examine your body?",
        "explore your body",
    ] {
        let understood = understood(said);
        assert!(
            understood.intent == Intent::FeelOver && understood.leave.is_some(),
            "{said}: {:?}",
            understood.intent
        );
    }
    for said in ["don't feel yourself over", "did you feel yourself over?", "you need not check your body"] {
        assert!(understood(said).leave.is_none(), "{said}");
    }
}

#[test]
fn what_happens_without_a_word_to_him_is_told_of_or_refused_in_a_sentence() {
    let talk = |line: &str| {
        let mut child = Command::new(env!("CARGO_BIN_EXE_bodyschema"))
            .args(["talk", repository("mjcf/max/table.xml").to_str().unwrap(), "max"])
            .current_dir(sessions::max())
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .unwrap();
        child.stdin.take().unwrap().write_all(format!("{line}\nquit\n").as_bytes()).unwrap();
        let output = child.wait_with_output().unwrap();
        (output.status.code(), String::from_utf8(output.stderr).unwrap())
    };
    let (status, told) = talk("/grow left_hand 30");
    assert!(status == Some(0) && told.contains("outwards by 30 mm"), "{status:?} {told}");
    for (line, why) in [
        ("/grow nose 30", "no joint moves a limb nose"),
        ("/grow left_hand NaN", "NaN is not a number of millimetres"),
        ("/grow left_hand 1e9", "between -300 and 300"),
        ("/shrink left_hand", "write /grow LIMB MILLIMETRES"),
    ] {
        let (status, told) = talk(line);
        assert!(status == Some(1) && told.contains(why), "{line}: {status:?} {told}");
    }
}

/// By `cargo test large:: -- --ignored`.
mod large {
    use super::*;

    #[test]
    #[ignore = "large: a minute"]
    fn what_several_joints_did_at_once_he_does_not_claim_to_know() {
        let (stage, mut talk) = at_the_table(3);
        for name in ["left_hand", "left_forearm", "left_upper_arm"] {
            stage.grow_limb(stage.agent().creature().limb(name).unwrap(), 0.03).unwrap();
        }
        let reply = say(&mut talk, "feel yourself over");
        if reply.done == Some(true) {
            assert!(off(&stage, &talk.actor, 0) < 1e-3, "he says that he knows: {}", reply.said);
        } else {
            let reply = say(&mut talk, "touch your nose");
            assert_eq!(reply.done, Some(false), "he does not act by it: {}", reply.said);
        }
    }
}
