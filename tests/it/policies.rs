//! Policies of babbling: the same touches whatever the threads, with fewer motions.

use std::fs;
use std::process::Command;

use crate::common::{creature, max, truth, two_arms};
use bodyschema::agent::Agent;
use bodyschema::babbling::policy::{Foreseen, Foresight};
use bodyschema::babbling::{Babbler, BabblingOptions, BoutsDone, Made, PolicyName};
use bodyschema::creature::{Body, Posture};
use bodyschema::senses::RecordedTouch;
use bodyschema::simulation::{Effort, Ending, MotionName, Movers};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

fn arms() -> String {
    two_arms(r#"type="capsule" size="0.12 0.2""#, r#"type="capsule" size="0.03 0.2""#)
}

fn babble_by(body: &Body, policy: PolicyName, touches: usize, jobs: usize) -> (Vec<RecordedTouch>, Effort) {
    let agent = Agent::of(body).unwrap();
    let babbler = Babbler::new(Movers::new(body, &agent, MotionName::Kinematic).unwrap());
    let mut made = Vec::new();
    let options = BabblingOptions { touches, seed: 3, jobs };
    let receive = |news: Made| {
        if let Made::Touch(touch) = news {
            made.push(touch.clone());
        }
        Ok(())
    };
    let (effort, _) = babbler.babble(policy, BoutsDone::default(), &options, receive).unwrap();
    (made, effort)
}

#[test]
fn every_policy_makes_the_same_touches_with_any_number_of_threads() {
    for (policy, body) in [(PolicyName::Random, creature(&arms())), (PolicyName::Stages, max("torso"))] {
        let with = |threads: usize| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| babble_by(&body, policy, 45, threads).0)
        };
        let (one, three) = (with(1), with(3));
        assert_eq!(one.len(), 45);
        assert_eq!(format!("{one:?}"), format!("{three:?}"), "{policy}");
    }
}

#[test]
fn all_motions_are_counted_although_the_body_starts_over() {
    let (touches, effort) = babble_by(&max("torso"), PolicyName::Stages, 60, 1);
    let motions: Vec<u64> = touches.iter().map(|touch| touch.motion).collect();
    assert_eq!(motions.last(), Some(&effort.motions));
    assert!(motions.windows(2).all(|pair| pair[0] < pair[1]), "{motions:?}");
}

#[test]
fn a_session_says_by_which_policy_its_motions_were_chosen() {
    let place = tempfile::tempdir().unwrap();
    fs::write(place.path().join("arms.xml"), arms()).unwrap();
    let arguments =
        ["babble", "arms.xml", "--touches", "30", "--policy", "stages", "--out", "here", "--json"];
    let output = Command::new(env!("CARGO_BIN_EXE_bodyschema"))
        .args(arguments)
        .current_dir(place.path())
        .output()
        .unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let printed: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(printed["policy"], "stages");
    let session = fs::read_to_string(place.path().join("here/session.json")).unwrap();
    let session: serde_json::Value = serde_json::from_str(&session).unwrap();
    assert_eq!(session["options"]["policy"], "stages");
}

/// With the true schema it is right but for what is thinner than the way between two looks; with a schema in which the
/// elbows are elsewhere it is not.
#[test]
fn what_a_motion_touches_first_is_foreseen_by_the_schema() {
    let body = max("torso");
    let agent = Agent::of(&body).unwrap();
    let movers = Movers::new(&body, &agent, MotionName::Kinematic).unwrap();
    let right_with = |schema| {
        let mut foresight = Foresight::new(&agent);
        let mut mover = movers.mover().unwrap();
        let mut rng = ChaCha8Rng::seed_from_u64(7);
        let (mut right, mut wrong) = (0, 0);
        for motion in 0..400 {
            let from = mover.felt_posture().unwrap();
            let target = Posture::random(&body.creature, &mut rng);
            let foreseen = foresight.foresee(schema, [&from, &target], |_| true);
            let is_right = match mover.advance(&target).unwrap() {
                Ending::Touch(met) => {
                    let mut met = mover.touch(0, met).unwrap().limbs(agent.skin());
                    met.sort_unstable();
                    matches!(foreseen, Foreseen::Meeting(limbs, _) if limbs == met)
                }
                Ending::Free => {
                    foresight.pass(schema, &target, |_| true);
                    foreseen == Foreseen::Nothing
                }
                Ending::Again => foreseen == Foreseen::Stuck,
                Ending::Bare => continue,
            };
            // At first it is found out which limbs do not feel each other.
            match is_right {
                _ if motion < 100 => {}
                true => right += 1,
                false => wrong += 1,
            }
        }
        f64::from(right) / f64::from(right + wrong)
    };
    let schema = truth(&body);
    let mut other = schema.clone();
    let elbow = body.creature.joints().iter().position(|joint| joint.name == "left_elbow").unwrap();
    other.positions[elbow].z += 0.15;
    let (known, mistaken) = (right_with(&schema), right_with(&other));
    assert!(known > 0.9, "{known} of the motions end as foreseen");
    assert!(mistaken < known - 0.05, "{mistaken} with a wrong schema, {known} with the right one");
}
