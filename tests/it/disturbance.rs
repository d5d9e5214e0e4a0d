//! Disturbed senses: as much as was asked for, nothing more, and the same for the same seed.

use crate::common::{babble, creature, max, two_arms, with_agent};
use bodyschema::agent::Agent;
use bodyschema::creature::{Body, DofKind, Posture};
use bodyschema::senses::{Disturbances, Input, RecordedTouch, Touch};
use nalgebra::{Quaternion, UnitQuaternion};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

/// How far a deviation or a share estimated from some thousand draws may be from the one asked for.
const TOLERANCE: f64 = 0.1;

fn torso(touches: usize) -> (Agent, Vec<RecordedTouch>) {
    let (body, agent) = with_agent(max("torso"));
    let touches = babble(&body, &agent, touches, 3, 2);
    (agent, touches)
}

/// The touches as a kind of skin reports them.
fn as_felt(touches: &[RecordedTouch], input: Input) -> Vec<Touch> {
    touches.iter().map(|touch| touch.felt(input)).collect()
}

fn deviation(values: &[f64]) -> f64 {
    (values.iter().map(|x| x * x).sum::<f64>() / values.len() as f64).sqrt()
}

fn all() -> Disturbances {
    Disturbances { joint_noise: 0.002, receptor_noise: 0.001, false_touches: 0.1, point_noise: 0.001 }
}

#[test]
fn no_disturbance_changes_nothing_bit_for_bit() {
    let (agent, touches) = torso(50);
    let none = Disturbances::default();
    assert!(none.is_none() && !all().is_none());
    for input in [Input::Receptor, Input::Contact] {
        let felt = none.felt(&agent, &touches, input, 1);
        assert_eq!(felt.touches, as_felt(&touches, input));
        assert_eq!(felt.agent, agent);
    }
}

#[test]
fn the_same_seed_disturbs_alike_and_another_does_not() {
    let (agent, touches) = torso(60);
    let felt = |touches: &[RecordedTouch], seed| all().felt(&agent, touches, Input::Contact, seed);
    let first = felt(&touches, 1);
    assert_eq!(first, felt(&touches, 1));
    assert_ne!(first, felt(&touches, 2));
    assert_eq!(first.touches[..20], felt(&touches[..20], 1).touches, "later touches changed earlier ones");
}

#[test]
fn one_disturbance_does_not_change_what_another_draws() {
    let (agent, touches) = torso(60);
    let felt = |disturbances: Disturbances| disturbances.felt(&agent, &touches, Input::Contact, 1);
    let together = felt(all());
    let joints = felt(Disturbances { joint_noise: all().joint_noise, ..Default::default() });
    let receptors = felt(Disturbances { receptor_noise: all().receptor_noise, ..Default::default() });
    for (one, other) in together.touches.iter().zip(&joints.touches) {
        assert_eq!(one.posture, other.posture);
    }
    assert_eq!(together.agent, receptors.agent);
}

#[test]
fn joint_angles_deviate_as_much_as_asked_for_and_nothing_else_does() {
    let (agent, touches) = torso(200);
    let joint_noise = 0.002;
    let noise = Disturbances { joint_noise, ..Default::default() };
    let felt = noise.felt(&agent, &touches, Input::Contact, 1);
    let mut differences = Vec::new();
    for (felt, exact) in felt.touches.iter().zip(&as_felt(&touches, Input::Contact)) {
        assert_eq!((felt.ends, felt.bout, felt.motion), (exact.ends, exact.bout, exact.motion));
        differences.extend(felt.posture.iter().zip(&exact.posture).map(|(f, e)| f - e));
    }
    assert_eq!(felt.agent, agent);
    assert!((deviation(&differences) / joint_noise - 1.0).abs() < TOLERANCE);
}

/// A ball and a slide in place of the shoulders' hinges.
fn ball_and_slide() -> Body {
    let arms = two_arms(r#"type="capsule" size="0.12 0.2""#, r#"type="capsule" size="0.03 0.2""#);
    let arms = arms.replace(
        r#"<joint name="left_shoulder_a" axis="1 0.2 0" range="-2.4 2.4"/>"#,
        r#"<joint name="left_shoulder_a" type="ball" range="0 2"/>"#,
    );
    let arms = arms.replace(r#"<joint name="left_shoulder_b" axis="0 1 0.3" range="-2.4 2.4"/>"#, "");
    creature(&arms.replace(
        r#"<joint name="right_shoulder_a" axis="1 0.2 0" range="-2.4 2.4"/>"#,
        r#"<joint name="right_shoulder_a" type="slide" axis="1 0.2 0" range="-0.1 0.1"/>"#,
    ))
}

#[test]
fn a_ball_is_turned_by_the_deviation_and_a_slide_is_left_alone() {
    let (body, agent) = with_agent(ball_and_slide());
    let (first, mut rng) = (babble(&body, &agent, 1, 1, 1).remove(0), ChaCha8Rng::seed_from_u64(1));
    let touches: Vec<RecordedTouch> = (0..2000)
        .map(|n| Touch {
            bout: 0,
            motion: n,
            posture: Posture::random(&body.creature, &mut rng),
            ends: first.ends,
            moment: None,
        })
        .map(|touch| RecordedTouch::new(touch, *first.exact_contact()))
        .collect();
    let joint_noise = 0.003;
    let noise = Disturbances { joint_noise, ..Default::default() };
    let felt = noise.felt(&agent, &touches, Input::Contact, 1);
    let (mut turns, mut slides) = (Vec::new(), 0);
    for (felt, exact) in felt.touches.iter().zip(&touches) {
        let mut q = 0;
        for dof in body.creature.dofs() {
            match dof.kind {
                DofKind::Ball => {
                    let rotation = |posture: &[f64]| {
                        let quaternion =
                            Quaternion::new(posture[q], posture[q + 1], posture[q + 2], posture[q + 3]);
                        assert!((quaternion.norm() - 1.0).abs() < 1e-9);
                        UnitQuaternion::from_quaternion(quaternion)
                    };
                    let turn = rotation(&exact.posture).inverse() * rotation(&felt.posture);
                    turns.extend(turn.scaled_axis().iter().copied());
                }
                DofKind::Slide => {
                    assert_eq!(felt.posture[q], exact.posture[q]);
                    slides += 1;
                }
                DofKind::Hinge => assert_ne!(felt.posture[q], exact.posture[q]),
            }
            q += dof.kind.coordinates();
        }
    }
    assert!(slides > 0 && (deviation(&turns) / joint_noise - 1.0).abs() < TOLERANCE);
}

#[test]
fn every_receptor_is_displaced_with_its_surface_and_its_contacts() {
    let (agent, touches) = torso(100);
    let receptor_noise = 0.001;
    let noise = Disturbances { receptor_noise, ..Default::default() };
    let felt = noise.felt(&agent, &touches, Input::Contact, 1);
    let mut displacements = Vec::new();
    for (felt_receptor, exact) in felt.agent.skin().receptors.iter().zip(&agent.skin().receptors) {
        let displacement = felt_receptor.position - exact.position;
        displacements.extend(displacement.iter().copied());
        assert_eq!((felt_receptor.limb, felt_receptor.normal), (exact.limb, exact.normal));
        let [own, shared] = [(felt.agent.skin(), felt_receptor), (agent.skin(), exact)]
            .map(|(skin, receptor)| skin.surfaces[receptor.surface.unwrap()].clone());
        assert!((own.origin - shared.origin - displacement).norm() < 1e-15);
        assert_eq!((own.limb, own.rotation, own.shape), (shared.limb, shared.rotation, shared.shape));
    }
    assert!((deviation(&displacements) / receptor_noise - 1.0).abs() < TOLERANCE);
    for (felt_touch, exact) in felt.touches.iter().zip(&touches) {
        assert_eq!(felt_touch.posture, exact.posture);
        for (end, exact) in felt_touch.ends.iter().zip(&exact.felt(Input::Contact).ends) {
            let displacement = felt.agent.skin().receptors[end.receptor].position
                - agent.skin().receptors[end.receptor].position;
            assert_eq!(end.receptor, exact.receptor);
            assert!(
                (end.point.unwrap().position - exact.point.unwrap().position - displacement).norm() < 1e-15
            );
        }
    }
}

#[test]
fn as_many_touches_are_false_as_asked_for_and_all_are_well_formed() {
    let (agent, touches) = torso(200);
    let touches: Vec<RecordedTouch> = touches.iter().cycle().take(4000).cloned().collect();
    let false_touches = 0.1;
    let noise = Disturbances { false_touches, ..Default::default() };
    let felt = noise.felt(&agent, &touches, Input::Contact, 1);
    assert_eq!(felt.agent, agent);
    let (mut changed, mut first_stays) = (0, 0);
    for (felt, exact) in felt.touches.iter().zip(&as_felt(&touches, Input::Contact)) {
        assert_eq!(felt.posture, exact.posture);
        let limbs = felt.ends.map(|end| agent.skin().receptors[end.receptor].limb);
        assert!(limbs[0] < limbs[1], "the earlier limb comes first, and a limb never touches itself");
        if felt.ends == exact.ends {
            continue;
        }
        changed += 1;
        let strange: Vec<_> = felt.ends.iter().filter(|end| !exact.ends.contains(end)).collect();
        assert_eq!(strange.len(), 1, "one end is replaced, not both");
        assert_eq!(strange[0].point.unwrap().position, agent.skin().receptors[strange[0].receptor].position);
        first_stays += usize::from(felt.ends.contains(&exact.ends[0]));
    }
    let share = f64::from(changed) / touches.len() as f64;
    assert!((share / false_touches - 1.0).abs() < TOLERANCE, "{share}");
    let first = first_stays as f64 / f64::from(changed);
    assert!((first - 0.5).abs() < TOLERANCE, "either end is as likely: {first}");
}
