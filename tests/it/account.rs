//! How sure a schema is: worked out once by the learner, and the same wherever it is asked for.

use std::fs;

use crate::common::program::succeeds;
use crate::common::{babble, creature, max, two_arms};
use bodyschema::agent::Agent;
use bodyschema::creature::Posture;
use bodyschema::ground_truth::GroundTruth;
use bodyschema::learning::initial_guess::random_guess;
use bodyschema::learning::{
    Certainty, Hersch, Input, Learned, Learner, LimbFrames, SecondOrder, Verdict, Z95,
};
use bodyschema::peripersonal::{Doubt, OwnBody};
use bodyschema::senses::RecordedTouch;
use bodyschema::session::{LEARNED_RECORD_FILE, LearningRecord, RecordedAccount, own_body};
use nalgebra::Vector3;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use serde_json::Value;

fn arms() -> String {
    two_arms(r#"type="sphere" size="0.1""#, r#"type="capsule" size="0.03 0.2""#)
}

fn learned(mut learner: impl Learner, input: Input, touches: &[RecordedTouch]) -> Learned {
    touches.iter().for_each(|touch| learner.touch(&touch.felt(input)));
    learner.learn()
}

/// The doubt about a hand in the head's frame.
fn doubt(own: &OwnBody, limbs: [&str; 2]) -> Option<Doubt> {
    let limbs = limbs.map(|name| own.creature().limb(name).unwrap());
    own.trusts(&own.at_ease(), limbs, &Vector3::zeros()).err()
}

/// By Hersch's rule from few touches the schema is hundreds of millimetres wrong, and nobody has measured it.
#[test]
fn a_schema_that_was_never_put_to_the_test_is_not_trusted() {
    let body = max("torso");
    let agent = Agent::of(&body).unwrap();
    let touches = babble(&body, &agent, 300, 2, 2);
    let initial_guess = || random_guess(agent.creature(), &mut ChaCha8Rng::seed_from_u64(1));
    for unjudged in [
        learned(Hersch::new(&agent, Input::Receptor, initial_guess()), Input::Receptor, &touches),
        // One that has a test, and fails it.
        learned(SecondOrder::new(&agent, Input::Receptor, 1), Input::Receptor, &touches[..20]),
    ] {
        assert!(matches!(unjudged.certainty(), Certainty::Unknown), "{:?}", unjudged.verdict);
        let own = OwnBody::of(&agent, &unjudged, touches.iter().map(|touch| &touch.posture));
        let doubt = doubt(&own, ["left_hand", "head"]).expect("nobody put it to the test");
        assert_eq!(doubt, Doubt::Unknown);
        assert!(!doubt.to_string().contains("mm"), "{doubt}");
        let (place, head) = (own.place(0), own.creature().limb("head").unwrap());
        assert_eq!(own.covariance(&own.at_ease(), [place.limb, head], &place.point), None);
    }
}

#[test]
fn a_session_opened_again_is_as_sure_as_its_learner_was() {
    // Receptors on round arms do not tell how these turn about their own length.
    let (max, arms) = (max("torso"), creature(&arms()));
    let folder = tempfile::tempdir().unwrap();
    for (body, touches, limbs, input, frames) in [
        (&max, 350, ["left_hand", "right_hand"], Input::Receptor, LimbFrames::Joint),
        (&arms, 200, ["left_fore", "right_fore"], Input::Contact, LimbFrames::Joint),
        (&arms, 200, ["left_fore", "right_fore"], Input::Contact, LimbFrames::Limb),
    ] {
        let agent = Agent::of(body).unwrap();
        let touches = babble(body, &agent, touches, 1, 2);
        let learned = learned(SecondOrder::new(&agent, input, 1).with_frames(frames), input, &touches);
        assert!(learned.verdict.converged(), "{input:?} {frames:?}: {:?}", learned.verdict);
        let record = LearningRecord {
            converged: true,
            account: Some(RecordedAccount::of(&learned)),
            ..LearningRecord::default()
        };
        record.write(folder.path(), agent.creature()).unwrap();
        let read = LearningRecord::read(folder.path(), agent.creature()).unwrap();
        let recorded = read.account.as_ref().unwrap();
        assert_eq!((recorded.basis, recorded.deviation), (learned.basis, learned.deviation));
        let certainties = [learned.certainty(), read.certainty()];
        let [before, after] = certainties.map(|certainty| {
            OwnBody::new(
                &agent,
                learned.schema.clone(),
                certainty,
                touches.iter().map(|touch| &touch.posture),
            )
        });
        let mut rng = ChaCha8Rng::seed_from_u64(4);
        for _ in 0..20 {
            let posture = Posture::random(agent.creature(), &mut rng);
            let covariance = |own: &OwnBody| {
                let limbs = limbs.map(|name| agent.creature().limb(name).unwrap());
                own.covariance(&posture, limbs, &Vector3::new(0.1, 0.0, 0.02)).unwrap()
            };
            // To the last bit.
            assert_eq!(covariance(&before), covariance(&after), "{input:?} {frames:?}");
        }
        let [before, after] = [&learned.account, &recorded.account].map(|account| account.as_ref().unwrap());
        assert_eq!(before.classes(), after.classes());
        assert!(before.claims_any() && before.limbs() == after.limbs());
        for &a in before.limbs() {
            for &b in before.limbs() {
                assert_eq!(before.distance(a, b), after.distance(a, b));
                assert_eq!(before.claims(a, b), after.claims(a, b));
            }
        }
        let (found, again) = (&before.observability, &after.observability);
        assert_eq!(found.schema_std(agent.creature()), again.schema_std(agent.creature()));
        assert_eq!(
            found.undetermined(agent.creature(), &learned.schema),
            again.undetermined(agent.creature(), &learned.schema)
        );
    }
}

#[test]
fn a_session_says_that_it_does_not_know_where_its_learner_did_not() {
    let place = tempfile::tempdir().unwrap();
    let place = place.path();
    fs::write(place.join("arms.xml"), arms()).unwrap();
    let limbs = ["left_fore", "right_fore"];
    let doubt_of = |session: &str| doubt(&own_body(&place.join(session)).unwrap().1, limbs);
    let babble = ["babble", "arms.xml", "--touches", "200"];
    succeeds(place, &[&babble[..], &["--learner", "hersch", "--out", "hersch"]].concat());
    assert_eq!(doubt_of("hersch"), Some(Doubt::Unknown));
    // The same touches by a learner that knows how good it is.
    succeeds(place, &["learn", "hersch", "--input", "contact"]);
    assert_eq!(doubt_of("hersch"), None);
    let json = succeeds(place, &["report", "hersch", "--json"]);
    // What is asked later is what was learned, not what some other learner would say.
    let told: Value = serde_json::from_str(&json).unwrap();
    let file = fs::read_to_string(place.join("hersch").join(LEARNED_RECORD_FILE)).unwrap();
    let record: Value = serde_json::from_str(&file).unwrap();
    let metres = record["account"]["touch_deviation"].as_f64().unwrap();
    assert_eq!(told["touch_deviation_mm"].as_f64().unwrap(), 1e3 * metres);
    assert_eq!(record["account"]["basis"]["input"], "contact");

    // A record from before accounts were kept reads, and says nothing of how good it is.
    let mut old = record.clone();
    old.as_object_mut().unwrap().remove("account");
    fs::write(place.join("hersch").join(LEARNED_RECORD_FILE), old.to_string()).unwrap();
    assert_eq!(doubt_of("hersch"), Some(Doubt::Unknown));
    succeeds(place, &["report", "hersch"]);
    // One of another creature is refused.
    let other = file.replace("\"left_shoulder\"", "\"left_knee\"");
    assert_ne!(other, file);
    fs::write(place.join("hersch").join(LEARNED_RECORD_FILE), other).unwrap();
    assert!(own_body(&place.join("hersch")).is_err());
}

/// The account's way to a distance, twists of joints, against the covariance of each point by its own Jacobian.
#[test]
fn distances_are_those_of_the_points_that_are_known_worst() {
    let body = max("torso");
    let agent = Agent::of(&body).unwrap();
    let truth = GroundTruth::new(&body).unwrap();
    let touches = babble(&body, &agent, 400, 3, 2);
    for (input, frames) in [(Input::Receptor, LimbFrames::Joint), (Input::Contact, LimbFrames::Limb)] {
        let mut learner = SecondOrder::new(&agent, input, 1).with_frames(frames);
        touches.iter().for_each(|touch| learner.touch(&touch.felt(input)));
        let (account, _) = learner.account(&truth.schema);
        let mut rng = ChaCha8Rng::seed_from_u64(9);
        let (mut bounded, mut open) = (0, 0);
        for &a in account.limbs() {
            for &b in account.limbs().iter().filter(|&&b| b > a) {
                // At other postures and of all receptors no point is much worse, and some is as bad.
                let mut worst = 0.0f64;
                for _ in 0..6 {
                    let posture = Posture::random(agent.creature(), &mut rng);
                    for [from, to] in [[a, b], [b, a]] {
                        for receptor in agent.skin().receptors.iter().filter(|receptor| receptor.limb == from)
                        {
                            let covariance = account.observability.point_covariance(
                                agent.creature(),
                                &truth.schema,
                                &posture,
                                [from, to],
                                &receptor.position,
                            );
                            let variance =
                                covariance.map_or(f64::INFINITY, |c| c.symmetric_eigenvalues().max());
                            worst = worst.max(Z95 * variance.sqrt());
                        }
                    }
                }
                let distance = account.distance(a, b);
                assert_eq!(distance.is_finite(), worst.is_finite(), "{input:?}: limbs {a} and {b}");
                if worst.is_finite() {
                    bounded += 1;
                    assert!((0.3..3.0).contains(&(distance / worst)), "{input:?}: {distance} m, {worst} m");
                } else {
                    open += 1;
                }
            }
        }
        assert!(bounded > 20, "{input:?}: {bounded} bounded, {open} open");
    }
}

#[test]
fn a_learner_that_places_nothing_says_that_it_has_not_learned() {
    let body = creature(&arms());
    let agent = Agent::of(&body).unwrap();
    let touches = babble(&body, &agent, 60, 1, 2);
    let mut learner = SecondOrder::new(&agent, Input::Contact, 1);
    touches[..3].iter().for_each(|touch| learner.touch(&touch.felt(Input::Contact)));
    let (account, _) = learner.account(&GroundTruth::new(&body).unwrap().schema);
    assert!(!account.claims_any(), "{:?}", account.classes());
    assert!(matches!(account.verdict(agent.creature()), Verdict::Failed(_)));
    assert_eq!(account.undetermined().len(), agent.creature().joints().len());
    let why = |name: &str| account.openness(agent.creature(), agent.creature().limb(name).unwrap());
    assert!(account.limbs().iter().any(|&limb| account.openness(agent.creature(), limb).is_some()));
    assert!(why("left_fore").is_some() || why("right_fore").is_some());
}
