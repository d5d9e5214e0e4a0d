//! Motions with physics: the body is held and carried as it should be, and touches are where limbs press.

use std::sync::Arc;

use crate::common::{creature, max, repository, take, two_arms, with_agent};
use bodyschema::agent::Agent;
use bodyschema::babbling::{Babbler, BabblingOptions, BoutsDone, Made, PolicyName};
use bodyschema::creature::{Body, JointSelection, Posture};
use bodyschema::evaluation::evaluate_learned;
use bodyschema::ground_truth::GroundTruth;
use bodyschema::learning::{Input, Learner, SecondOrder};
use bodyschema::mujoco::{Data, Model};
use bodyschema::senses::{ContactReader, Reading, RecordedTouch};
use bodyschema::session::{TOUCHES_FILE, TouchWriter, read_touches};
use bodyschema::simulation::{Ending, MotionName, Movers};
use bodyschema::skin::{GrowOptions, grow};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

/// How far a body that is held may give way, radians.
const HELD: f64 = 0.1 * std::f64::consts::PI / 180.0;
/// The deepest that limbs may be in each other where receptors fire, metres: the way of 3 m/s in the finest step.
const DEPTH: f64 = 3.0 * 0.002 / 256.0;
/// The error of a schema from receptors, millimetres: what such depths leave, with room …
const HELD_OUT_MM: f64 = 0.1;
/// … and from contact points, which are the same point of space however deep limbs are.
const EXACT_MM: f64 = 1e-6;
/// Simulated time for which postures are held, seconds.
const HOLDING: f64 = 1.0;
/// Where a contact ends up in the two limbs' frames may differ by this, metres.
const SAME_PLACE: f64 = 1e-9;

fn zoo(name: &str) -> (Body, Agent) {
    let model = Model::from_path(repository(&format!("mjcf/{name}/{name}.xml"))).unwrap();
    let body = Body::new(Arc::new(model), &JointSelection::All).unwrap();
    let agent = Agent::new(body.creature.clone(), grow(&body, &GrowOptions::default()).unwrap()).unwrap();
    (body, agent)
}

/// Two arms of capsules at a trunk of one.
fn arms() -> (Body, Agent) {
    let capsule = "type=\"capsule\" size=\"0.04 0.2\"";
    with_agent(creature(&two_arms("type=\"capsule\" size=\"0.1 0.3\"", capsule)))
}

fn dynamic<'a>(body: &'a Body, agent: &'a Agent) -> Babbler<'a> {
    Babbler::new(Movers::new(body, agent, MotionName::Dynamic).unwrap())
}

fn touches(babbler: &Babbler, touches: usize, seed: u64, jobs: usize) -> Vec<RecordedTouch> {
    let mut made = Vec::new();
    let options = BabblingOptions { touches, seed, jobs };
    let receive = |news: Made| {
        if let Made::Touch(touch) = news {
            made.push(touch.clone());
        }
        Ok(())
    };
    let from = BoutsDone::default();
    let (effort, _) = babbler.babble(PolicyName::Random, from, &options, receive).unwrap();
    assert!(effort.simulated_s > 0.0);
    made
}

/// The greatest difference between two postures without balls.
fn away(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).fold(0.0, |most, (a, b)| f64::max(most, (a - b).abs()))
}

#[test]
fn gravity_does_not_move_a_body_that_is_held() {
    let bodies = ["hexapod", "octopus", "snake", "fourarms", "sauropod", "contraption"].map(zoo);
    for (body, agent) in bodies.into_iter().chain([with_agent(max("torso"))]) {
        let babbler = dynamic(&body, &agent);
        let mut mover = babbler.movers().mover().unwrap();
        let start = mover.posture().to_vec();
        while mover.effort().simulated_s < HOLDING {
            assert_eq!(mover.advance(&start).unwrap(), Ending::Free);
        }
        let moved = away(mover.posture(), &start);
        assert!(moved < HELD, "{}: {moved} rad", body.creature.name());
    }
}

#[test]
fn servos_carry_the_body_to_a_free_posture_in_human_time() {
    let (body, agent) = with_agent(max("torso"));
    let babbler = dynamic(&body, &agent);
    let mut mover = babbler.movers().mover().unwrap();
    // A little of every range: nothing is in the way.
    let posture = mover.posture().to_vec();
    let elements = body.creature.elements();
    let target: Vec<f64> = elements
        .map(|at| posture[at.coordinate()] + 0.1 * (at.range[1] - posture[at.coordinate()]))
        .collect();
    assert_eq!(mover.advance(&target).unwrap(), Ending::Free);
    assert!(away(mover.posture(), &target) < 0.01, "{}", away(mover.posture(), &target));
    // Minimum jerk at 2 rad/s at its fastest.
    let most = away(&posture, &target);
    let took = mover.effort().simulated_s;
    assert!(took >= (1.875 * most / 2.0).max(0.3) - 0.01 && took < 2.0, "{took} s for {most} rad");
}

#[test]
fn receptors_fire_where_limbs_press_in_the_posture_of_the_touch() {
    let (body, agent) = with_agent(max("torso"));
    let reader = ContactReader::new(&body, agent.skin());
    let mut data = Data::new(body.model.clone()).unwrap();
    let babbler = dynamic(&body, &agent);
    let mut mover = babbler.movers().mover().unwrap();
    let mut rng = ChaCha8Rng::seed_from_u64(2);
    let mut made = Vec::new();
    while made.len() < 5 {
        if let Ending::Touch(met) = mover.advance(&Posture::random(&body.creature, &mut rng)).unwrap() {
            made.push(mover.touch(0, met).unwrap());
        }
    }
    let mut last = 0.0;
    for (i, touch) in made.iter().enumerate() {
        let moment = touch.moment.unwrap();
        assert!(moment.force > 0.0 && moment.time > last, "touch {i}: {moment:?}");
        last = moment.time;
        take(&body, &mut data, &touch.posture);
        // The very contact, read again from the posture alone.
        let reads = |contact: &_| match reader.read(&body, agent.skin(), &data, contact) {
            Reading::Touch(met) => (0..2).all(|k| {
                let off = met.exact_contact.points[k] - touch.exact_contact().points[k];
                met.receptors[k] == touch.ends[k].receptor && off.norm() < SAME_PLACE
            }),
            _ => false,
        };
        let found = data.contacts().find(|contact| reads(contact));
        let depth = -found.unwrap_or_else(|| panic!("touch {i} is no contact of its posture")).distance;
        assert!((0.0..DEPTH).contains(&depth), "touch {i}: {depth} m deep");
        let recorded = touch.exact_contact().depth.unwrap();
        assert!((depth - recorded).abs() < SAME_PLACE, "touch {i}: {depth} m, not {recorded} m");
        let limbs = touch.ends.map(|end| agent.skin().receptors[end.receptor].limb);
        assert!(!body.creature.neighbouring(limbs[0], limbs[1]), "touch {i}: {limbs:?}");
    }
}

#[test]
fn what_is_felt_must_part_before_it_is_felt_again() {
    let (body, agent) = arms();
    let babbler = dynamic(&body, &agent);
    let mut mover = babbler.movers().mover().unwrap();
    let start = mover.posture().to_vec();
    let mut rng = ChaCha8Rng::seed_from_u64(1);
    let mut stuck = 0;
    for _ in 0..60 {
        mover.reset().unwrap();
        let target = Posture::random(&body.creature, &mut rng);
        if !matches!(mover.advance(&target).unwrap(), Ending::Touch(_)) {
            continue;
        }
        let (touched, time) = (mover.posture().to_vec(), mover.moment().unwrap().time);
        // Pressing on, the limbs hold each other up or slide along each other: no touch of theirs is new.
        let on = mover.advance(&target).unwrap();
        if on == Ending::Again {
            stuck += 1;
            assert_eq!((mover.effort().again, mover.moment()), (1, None));
            assert!(mover.effort().simulated_s > time + 0.5, "{} s", mover.effort().simulated_s);
            assert!(away(mover.posture(), &target) > 0.01, "it went through");
            // Once they have parted they feel each other again.
            assert_eq!(mover.advance(&start).unwrap(), Ending::Free);
            assert!(matches!(mover.advance(&target).unwrap(), Ending::Touch(_)));
            assert!(away(mover.posture(), &touched) < 0.5);
        }
    }
    assert!(stuck > 0, "no motion got stuck, which proves nothing");
}

#[test]
fn the_same_seed_gives_the_same_touches_with_any_number_of_threads() {
    let (body, agent) = zoo("contraption");
    let babbler = dynamic(&body, &agent);
    let one = touches(&babbler, 40, 3, 1);
    assert_eq!(one, touches(&babbler, 40, 3, 2));
    assert_ne!(one, touches(&babbler, 40, 4, 2));
    assert!(one.iter().any(|touch| touch.bout > 0), "one bout proves nothing");
}

#[test]
fn a_log_of_touches_with_physics_reads_back_bit_for_bit() {
    let (body, agent) = zoo("contraption");
    let mut made = touches(&dynamic(&body, &agent), 20, 5, 2);
    // A log may hold touches of both kinds.
    (made[3].moment, made[3].exact_contact_mut().depth) = (None, None);
    let folder = tempfile::tempdir().unwrap();
    let mut writer = TouchWriter::create(folder.path(), &agent).unwrap();
    made.iter().for_each(|touch| writer.write(touch).unwrap());
    writer.finish().unwrap();
    let path = folder.path().join(TOUCHES_FILE);
    assert_eq!(read_touches(&path, &agent).unwrap().touches, made);

    let text = std::fs::read_to_string(&path).unwrap();
    assert_eq!(text.matches("\"force\":").count(), made.len() - 1);
    let line = text.lines().nth(1).unwrap();
    let half = text.replace(line, &line.replace("\"force\":", "\"strength\":"));
    for (wrong, word) in [(half, "all three"), (text.replacen("\"depth\":", "\"depth\":-", 1), "depth")] {
        std::fs::write(&path, wrong).unwrap();
        let error = read_touches(&path, &agent).unwrap_err().to_string();
        assert!(error.contains(word), "{error}");
    }
}

#[test]
fn a_schema_learned_from_touches_with_physics_is_as_good_as_they_are_deep() {
    let (body, agent) = zoo("contraption");
    let truth = GroundTruth::new(&body).unwrap();
    let made = touches(&dynamic(&body, &agent), 200, 1, 2);
    // From points in space every error is one of the posture: a step later it would be some millimetres.
    // One joint more rests on a single touch, which might be false for all that others tell: it is not claimed.
    for (input, least, bound_mm) in [(Input::Contact, 7, EXACT_MM), (Input::Receptor, 4, HELD_OUT_MM)] {
        let mut learner = SecondOrder::new(&agent, input, 1);
        made.iter().for_each(|touch| learner.touch(&touch.felt(input)));
        let learned = learner.learn();
        let known = body.creature.joints().len() - learned.undetermined().len();
        assert!(known >= least, "{input:?}: {known} joints, {:?}", learned.verdict);
        let found = evaluate_learned(&agent, &truth, &learned).bound_mm.unwrap();
        assert!(found.error_rms < bound_mm, "{input:?}: {:?} {found:?}", learned.verdict);
    }
}
