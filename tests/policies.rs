//! Policies of babbling: the same touches whatever the threads, fewer motions, and aims that meet.

mod common;

use std::convert::Infallible;
use std::fs;
use std::process::Command;

use bodyschema::babbling::policy::inverse_kinematics::{InverseKinematics, REACHED};
use bodyschema::babbling::{Babbler, BabblingOptions, Effort, PolicyName, motions_until, random_posture};
use bodyschema::creature::Body;
use bodyschema::ground_truth::GroundTruth;
use bodyschema::learning::rough::imagined;
use bodyschema::learning::touch_set::TouchSet;
use bodyschema::senses::Touch;
use bodyschema::skin::skin_of;
use common::{creature, max, two_arms};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

/// How far the inverse kinematics and the chains of the learner may differ, metres.
const ROUNDING: f64 = 1e-9;

fn arms() -> String {
    two_arms(r#"type="capsule" size="0.12 0.2""#, r#"type="capsule" size="0.03 0.2""#)
}

fn babble_by(body: &Body, policy: PolicyName, touches: usize, jobs: usize) -> (Vec<Touch>, Effort) {
    let skin = skin_of(body);
    let babbler = Babbler::new::<Infallible>(body, &skin).unwrap();
    let mut made = Vec::new();
    let options = BabblingOptions { touches, seed: 3, jobs };
    let receive = |touch: &Touch| {
        made.push(touch.clone());
        Ok::<(), Infallible>(())
    };
    let effort = babbler.babble_by(policy, &options, receive).unwrap();
    (made, effort)
}

#[test]
fn every_policy_makes_the_same_touches_with_any_number_of_threads() {
    let body = creature(&arms());
    for policy in [PolicyName::Random, PolicyName::Steered, PolicyName::Informative] {
        let with = |threads: usize| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| babble_by(&body, policy, 45, threads).0)
        };
        // Schemas are learned after 20, 30 and 42 touches.
        let (one, three) = (with(1), with(3));
        assert_eq!(one.len(), 45);
        assert_eq!(format!("{one:?}"), format!("{three:?}"), "{policy}");
    }
}

#[test]
fn steered_motions_touch_more_often_than_random_ones() {
    let body = max("torso");
    let [random, steered] =
        [PolicyName::Random, PolicyName::Steered].map(|policy| babble_by(&body, policy, 60, 1).1.motions);
    assert!(3 * steered < 2 * random, "{steered} steered motions, {random} random ones");
}

#[test]
fn motions_are_counted_through_all_bouts() {
    let body = max("torso");
    for policy in [PolicyName::Random, PolicyName::Steered] {
        let (touches, effort) = babble_by(&body, policy, 60, 1);
        let motions = motions_until(&touches);
        assert_eq!(motions.last(), Some(&effort.motions), "{policy}");
        assert!(motions.windows(2).all(|pair| pair[0] < pair[1]), "{policy}: {motions:?}");
    }
}

#[test]
fn postures_found_by_inverse_kinematics_bring_the_receptors_together_within_the_ranges() {
    let body = creature(&arms());
    let (creature, skin) = (&body.creature, skin_of(&body));
    let schema = GroundTruth::new(&body).unwrap().schema;
    let mut rng = ChaCha8Rng::seed_from_u64(1);
    let mut met = 0;
    for _ in 0..40 {
        let start = random_posture(creature, &mut rng);
        for receptors in [[0, 1], [0, 2], [1, 2]] {
            let reach = InverseKinematics::new(creature, &skin, &schema, receptors, 0.0).solve(&start);
            for (dof, angle) in creature.dofs().zip(&reach.posture) {
                assert!((dof.range[0]..=dof.range[1]).contains(angle), "{angle} of {:?}", dof.range);
            }
            let set = TouchSet::new(creature, [imagined(&skin, receptors, &reach.posture)]);
            let miss = set.pairs[0].touches[0].miss(&schema).norm();
            assert!((miss - reach.miss).abs() < ROUNDING, "{miss} and {}", reach.miss);
            met += usize::from(miss <= REACHED);
        }
    }
    assert!(met >= 20, "only {met} of 120 met");
}

#[test]
fn a_session_says_by_which_policy_its_motions_were_chosen() {
    let place = tempfile::tempdir().unwrap();
    fs::write(place.path().join("arms.xml"), arms()).unwrap();
    let arguments =
        ["babble", "arms.xml", "--touches", "30", "--policy", "informative", "--out", "here", "--json"];
    let output = Command::new(env!("CARGO_BIN_EXE_bodyschema"))
        .args(arguments)
        .current_dir(place.path())
        .output()
        .unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let printed: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(printed["policy"], "informative");
    let session = fs::read_to_string(place.path().join("here/session.json")).unwrap();
    let session: serde_json::Value = serde_json::from_str(&session).unwrap();
    assert_eq!(session["options"]["policy"], "informative");
}
