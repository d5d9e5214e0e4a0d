//! Learning: what the learners recover, and that they say so when they recover nothing.

use crate::common::{babble, creature, max, two_arms};
use bodyschema::agent::Agent;
use bodyschema::creature::{Body, Posture};
use bodyschema::evaluation::{Evaluation, evaluate};
use bodyschema::geometry::tangent_basis;
use bodyschema::ground_truth::GroundTruth;
use bodyschema::kinematics::limb_frames;
use bodyschema::learning::initial_guess::random_guess;
use bodyschema::learning::least_squares::{
    FIRST_DAMPING, LeastSquares, Linearization, Stopping, damped_from,
};
use bodyschema::learning::{Hersch, Input, Learned, Learner, SecondOrder, Verdict};
use bodyschema::schema::BodySchema;
use bodyschema::senses::RecordedTouch;
use nalgebra::{DMatrix, DVector, Rotation3, Unit, Vector3};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// Greatest mean held-out error from 500 exact contact points, millimetres (the issue's figure).
const CONTACTS_MM: f64 = 0.01;
/// Greatest mean held-out error from 1,000 touches of receptors on known surfaces, millimetres.
const SURFACES_MM: f64 = 0.1;
/// How far from the truth the axes are that Hersch's rule starts from, degrees.
const GUESS_DEGREES: f64 = 20.0;
/// How much of the initial guess's error Hersch's rule may leave.
const HERSCH_SHARE: f64 = 0.6;

/// A body with everything that a test of a learner needs.
struct Pupil {
    agent: Agent,
    truth: GroundTruth,
    touches: Vec<RecordedTouch>,
}

impl Pupil {
    fn new(body: &bodyschema::creature::Body, touches: usize, seed: u64) -> Pupil {
        let agent = Agent::of(body).unwrap();
        let truth = GroundTruth::new(body).unwrap();
        let touches = babble(body, &agent, touches, seed, 2);
        Pupil { agent, truth, touches }
    }

    fn second_order(&self, input: Input, seed: u64) -> Learned {
        let mut learner = SecondOrder::new(&self.agent, input, seed);
        self.touches.iter().for_each(|touch| learner.touch(&touch.felt(input)));
        learner.learn()
    }

    fn evaluate(&self, schema: &BodySchema, undetermined: &[usize]) -> Evaluation {
        evaluate(&self.agent, &self.truth, schema, undetermined)
    }

    fn heldout_mm(&self, schema: &BodySchema) -> f64 {
        self.evaluate(schema, &[]).heldout_mm.mean
    }

    /// The distance at which a schema puts the contact points of a touch, metres.
    fn miss(&self, schema: &BodySchema, touch: &RecordedTouch) -> f64 {
        let frames = limb_frames(self.agent.creature(), schema, &touch.posture);
        let (limbs, points) = (touch.limbs(self.agent.skin()), touch.exact_contact().points);
        let [a, b] = [0, 1].map(|k| frames[limbs[k]].point(&points[k]));
        (a - b).norm()
    }

    /// The truth with every axis turned by up to `GUESS_DEGREES` and every position shifted by up to 1 cm.
    fn perturbed(&self, seed: u64) -> BodySchema {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let mut schema = self.truth.schema.clone();
        for axis in &mut schema.axes {
            let around = rng.random_range(0.0..std::f64::consts::TAU);
            let sideways = tangent_basis(axis) * nalgebra::Vector2::new(f64::cos(around), f64::sin(around));
            let angle = rng.random_range(0.0..GUESS_DEGREES.to_radians());
            *axis = Rotation3::from_axis_angle(&Unit::new_normalize(sideways), angle) * *axis;
        }
        for position in &mut schema.positions {
            *position += Vector3::from_fn(|_, _| rng.random_range(-0.005..0.005));
        }
        schema
    }
}

#[test]
fn the_second_order_learner_recovers_the_torso_from_500_contact_points_whatever_the_guess() {
    let pupil = Pupil::new(&max("torso"), 500, 1);
    for seed in [101, 102, 103] {
        let learned = pupil.second_order(Input::Contact, seed);
        assert_eq!(learned.verdict, Verdict::Converged, "seed {seed}");
        assert!(learned.undetermined().is_empty(), "seed {seed}: {:?}", learned.undetermined());
        assert!(learned.schema.fits(pupil.agent.creature()));
        for axis in &learned.schema.axes {
            assert!((axis.norm() - 1.0).abs() < 1e-9, "seed {seed}: an axis of length {}", axis.norm());
        }
        let mean = pupil.heldout_mm(&learned.schema);
        assert!(mean <= CONTACTS_MM, "seed {seed}: {mean} mm");
    }
}

#[test]
fn the_second_order_learner_recovers_the_torso_from_1000_touches_of_receptors() {
    let pupil = Pupil::new(&max("torso"), 1000, 1);
    let learned = pupil.second_order(Input::Receptor, 1);
    assert_eq!(learned.verdict, Verdict::Converged);
    let mean = pupil.heldout_mm(&learned.schema);
    assert!(mean <= SURFACES_MM, "{mean} mm");
}

#[test]
fn the_same_touches_and_seed_give_the_same_schema() {
    let pupil = Pupil::new(&max("torso"), 400, 6);
    let [first, second] = [0, 1].map(|_| pupil.second_order(Input::Contact, 9));
    assert_eq!(first.schema, second.schema);
    assert_eq!((first.initial_guesses, first.verdict), (second.initial_guesses, second.verdict));
}

#[test]
fn herschs_rule_brings_axes_near_the_truth_nearer() {
    let pupil = Pupil::new(&max("torso"), 3000, 2);
    for seed in [1, 2] {
        let initial_guess = pupil.perturbed(seed);
        let before = pupil.heldout_mm(&initial_guess);
        let mut learner = Hersch::new(&pupil.agent, Input::Contact, initial_guess);
        for _ in 0..3 {
            pupil.touches.iter().for_each(|touch| learner.touch(&touch.felt(Input::Contact)));
        }
        let learned = learner.learn();
        assert!(matches!(learned.verdict, Verdict::Unjudged(_)), "it has no test of its own");
        let after = pupil.heldout_mm(&learned.schema);
        assert!(after < HERSCH_SHARE * before, "seed {seed}: {before} mm became {after} mm");
    }
}

#[test]
fn passes_of_herschs_rule_are_the_same_touches_again() {
    let pupil = Pupil::new(&max("torso"), 200, 2);
    let rule = || Hersch::new(&pupil.agent, Input::Contact, pupil.perturbed(1));
    let taught = |mut rule: Hersch, passes: usize| {
        (0..passes)
            .for_each(|_| pupil.touches.iter().for_each(|touch| rule.touch(&touch.felt(Input::Contact))));
        // Asking twice changes nothing.
        let [first, again] = [0, 1].map(|_| rule.learn().schema);
        assert_eq!(first, again);
        first
    };
    assert_eq!(taught(rule().with_passes(3), 1), taught(rule(), 3));
    assert_ne!(taught(rule().with_double_use(false), 1), taught(rule(), 1));
}

#[test]
fn herschs_rule_ends_at_the_first_touch_that_misses_little_enough() {
    let pupil = Pupil::new(&max("torso"), 200, 2);
    let initial_guess = pupil.perturbed(1);
    // How far each touch misses when the rule comes to it, and where it then leads.
    let mut states = vec![initial_guess.clone()];
    let mut rule = Hersch::new(&pupil.agent, Input::Contact, initial_guess.clone()).with_double_use(false);
    let mut misses = Vec::new();
    for touch in &pupil.touches {
        misses.push(pupil.miss(states.last().unwrap(), touch));
        rule.touch(&touch.felt(Input::Contact));
        states.push(rule.learn().schema);
    }
    let least = misses.iter().copied().fold(f64::INFINITY, f64::min);
    let ends = misses.iter().position(|&miss| miss == least).unwrap();
    let mut ending = Hersch::new(&pupil.agent, Input::Contact, initial_guess)
        .with_double_use(false)
        .with_passes(2)
        .with_tolerance(least * (1.0 + 1e-9));
    pupil.touches.iter().for_each(|touch| ending.touch(&touch.felt(Input::Contact)));
    assert_eq!(ending.learn().schema, states[ends + 1], "no touch after touch {ends}, in no pass");
}

#[test]
fn herschs_rule_leaves_the_truth_where_it_is() {
    let pupil = Pupil::new(&max("torso"), 500, 3);
    let truth = pupil.truth.schema.clone();
    let mut learner = Hersch::new(&pupil.agent, Input::Contact, truth);
    pupil.touches.iter().for_each(|touch| learner.touch(&touch.felt(Input::Contact)));
    let mean = pupil.heldout_mm(&learner.learn().schema);
    assert!(mean < 0.01, "{mean} mm");
}

#[test]
fn a_tiny_step_of_herschs_rule_lessens_the_error_of_the_touch_it_is_for() {
    const TINY: f64 = 1e-4;
    let slides = two_arms(r#"type="capsule" size="0.12 0.2""#, r#"type="capsule" size="0.03 0.2""#)
        .replace(r#"name="left_elbow_b" axis"#, r#"name="left_elbow_b" type="slide" axis"#)
        .replace("-2.6 2.6", "-0.1 2.6");
    for (name, body) in [("Max's torso", max("torso")), ("slide", creature(&slides))] {
        let pupil = Pupil::new(&body, 150, 4);
        let initial_guess = random_guess(pupil.agent.creature(), &mut ChaCha8Rng::seed_from_u64(5));
        for (i, touch) in pupil.touches.iter().enumerate() {
            let before = pupil.miss(&initial_guess, touch);
            let initial_guess = initial_guess.clone();
            let mut learner = Hersch::new(&pupil.agent, Input::Contact, initial_guess).with_step(TINY);
            learner.touch(&touch.felt(Input::Contact));
            let after = pupil.miss(&learner.learn().schema, touch);
            assert!(after < before, "{name}, touch {i}: {before} m became {after} m");
            assert!(after > 0.9 * before, "{name}, touch {i}: a tiny step went from {before} to {after} m");
        }
    }
}

#[test]
fn a_learner_that_is_told_nonsense_says_that_it_failed() {
    let arms = creature(&two_arms(r#"type="capsule" size="0.12 0.2""#, r#"type="capsule" size="0.03 0.2""#));
    fails_on_nonsense(&arms, 100);
}

fn fails_on_nonsense(body: &Body, touches: usize) {
    let mut pupil = Pupil::new(body, touches, 7);
    // Postures that have nothing to do with what was felt.
    let mut rng = ChaCha8Rng::seed_from_u64(1);
    for touch in &mut pupil.touches {
        touch.posture = Posture::random(pupil.agent.creature(), &mut rng);
    }
    for input in [Input::Contact, Input::Receptor] {
        let learned = pupil.second_order(input, 1);
        let why = match &learned.verdict {
            Verdict::Failed(why) => why,
            // Surfaces of single capsules meet in every posture when each turns about its own axis:
            // that explains the noise, and leaves every joint open.
            Verdict::Converged if learned.undetermined().len() == pupil.agent.creature().joints().len() => {
                continue;
            }
            other => panic!("{input:?}: {other:?} from noise, open {:?}", learned.undetermined()),
        };
        assert!(why.contains("--touches") && why.contains("--seed"), "{why}");
        assert!(learned.schema.fits(pupil.agent.creature()), "the schema has holes");
    }
}

/// Two arms, and a tail on the back that reaches nothing, with a joint on its joint.
fn with_idle_tail() -> String {
    let tail = r#"<body name="tail" pos="-3 0 0">
        <joint name="tail_root" axis="0 0 1" range="-1 1"/>
        <geom type="capsule" fromto="0 0 0 -0.2 0 0" size="0.02"/>
        <body name="tail_end" pos="-0.2 0 0">
          <joint name="tail_tip" axis="0 1 0" range="-0.5 0.5"/>
          <geom type="capsule" fromto="0 0 0 -0.2 0 0" size="0.02"/>
          <site name="tail_r" type="box" size="0.3 0.3 0.001"/>
        </body>
      </body>
    </body>
  </worldbody>
  <sensor><touch site="tail_r"/>"#;
    let arms = two_arms(r#"type="capsule" size="0.12 0.2""#, r#"type="capsule" size="0.03 0.2""#);
    let cut = arms.rfind("</body>").unwrap();
    let sensors = arms.find("<sensor>").unwrap() + "<sensor>".len();
    format!("{}{tail}{}", &arms[..cut], &arms[sensors..])
}

#[test]
fn joints_that_no_touch_involves_are_named() {
    names_the_tail(Input::Contact);
}

/// Learns two arms with a tail that touches nothing: the tail's joints are named as undetermined.
fn names_the_tail(input: Input) {
    let pupil = Pupil::new(&creature(&with_idle_tail()), 400, 8);
    let learned = pupil.second_order(input, 1);
    let joints = pupil.agent.creature().joints();
    let mut names: Vec<&str> =
        learned.undetermined().into_iter().map(|joint| joints[joint].name.as_str()).collect();
    names.sort_unstable();
    assert!(["tail_root", "tail_tip"].iter().all(|tail| names.contains(tail)), "{input:?}: {names:?}");
    assert!(learned.schema.fits(pupil.agent.creature()));
    if input == Input::Contact {
        assert_eq!(names.len(), 2, "{names:?}");
        assert_eq!(learned.verdict, Verdict::Converged);
        let evaluation = pupil.evaluate(&learned.schema, &learned.undetermined());
        assert!(evaluation.determined_mm.mean <= CONTACTS_MM, "{} mm", evaluation.determined_mm.mean);
        assert!(evaluation.heldout_mm.mean > 1.0, "the tail cannot have been guessed");
    }
}

#[test]
fn a_learner_without_touches_or_with_a_single_one_fails_without_a_panic() {
    for touches in [1, 2, 4, 5, 6] {
        let pupil = Pupil::new(&max("torso"), touches, 9);
        for input in [Input::Contact, Input::Receptor] {
            let learned = pupil.second_order(input, 1);
            assert!(
                matches!(learned.verdict, Verdict::Failed(_)),
                "{touches} touches, {input:?}: {:?}",
                learned.verdict
            );
            assert!(learned.schema.fits(pupil.agent.creature()));
        }
    }
    let mut none = Pupil::new(&max("torso"), 1, 9);
    none.touches.clear();
    let learned = none.second_order(Input::Contact, 1);
    assert!(matches!(learned.verdict, Verdict::Failed(_)), "{:?}", learned.verdict);
    assert_eq!(learned.undetermined().len(), none.agent.creature().joints().len());
}

#[test]
fn the_truth_has_no_error_and_what_is_known_not_at_all_has_much() {
    let pupil = Pupil::new(&max("torso"), 200, 10);
    let right = pupil.evaluate(&pupil.truth.schema, &[]);
    assert!(right.heldout_mm.max < 1e-9 && right.axis_deg.max < 1e-9 && right.axis_line_mm.max < 1e-9);
    let initial_guess = random_guess(pupil.agent.creature(), &mut ChaCha8Rng::seed_from_u64(1));
    let wrong = pupil.evaluate(&initial_guess, &[]);
    assert!(wrong.heldout_mm.mean > 50.0 && wrong.axis_deg.median > 10.0);
    let misses = bodyschema::evaluation::touch_misses;
    let exact = misses(&pupil.agent, &pupil.truth.schema, &pupil.touches);
    assert!(exact.max < 1e-3, "exact contact points are {} mm apart", exact.max);
}

/// `½ xᵀHx`.
struct Valley(DMatrix<f64>);

impl LeastSquares for Valley {
    type State = DVector<f64>;

    fn linearize(&mut self, x: &DVector<f64>) -> Linearization {
        let (hessian, scale) = (self.0.clone(), self.0.diagonal());
        Linearization { gradient: &hessian * x, cost: self.cost(x), hessian, scale }
    }

    fn cost(&self, x: &DVector<f64>) -> f64 {
        0.5 * x.dot(&(&self.0 * x))
    }

    fn step(&self, x: &DVector<f64>, step: &DVector<f64>) -> DVector<f64> {
        x + step
    }
}

#[test]
fn short_fits_come_as_far_as_a_long_one_if_each_goes_on_with_the_damping_of_the_one_before() {
    // A thousand times as long as it is wide, across both parameters.
    let mut valley = Valley(DMatrix::from_row_slice(2, 2, &[1.0, 1e-6 - 1.0, 1e-6 - 1.0, 1.0]));
    let short = Stopping { iterations: 2, ..Stopping::default() };
    let mut left = |goes_on: bool| {
        let mut damping = FIRST_DAMPING;
        let mut x = DVector::from_row_slice(&[1.0, 0.5]);
        for _ in 0..6 {
            damping = if goes_on { damping } else { FIRST_DAMPING };
            x = damped_from(&mut damping, &mut valley, x, short).state;
        }
        x.amax()
    };
    assert!(left(true) < 1e-6, "{}", left(true));
    assert!(left(false) > 0.1, "{}", left(false));
}

/// By `cargo test slow:: -- --ignored`.
mod slow {
    use super::*;

    #[test]
    #[ignore = "slow: receptors take all initial guesses where joints stay open"]
    fn joints_that_no_receptor_involves_are_named() {
        names_the_tail(Input::Receptor);
    }

    #[test]
    #[ignore = "slow: all initial guesses for Max's whole torso"]
    fn a_learner_of_max_that_is_told_nonsense_says_that_it_failed() {
        fails_on_nonsense(&max("torso"), 200);
    }
}
