//! Whether the learner is as sure as it should be: noise that is what its model assumes, and how often its
//! intervals hold the truth.
//!
//! The truth makes the data here and judges the result; nothing of it gets to the learner.

use nalgebra::{Quaternion, UnitQuaternion, Vector3};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

use bodyschema::agent::Agent;
use bodyschema::creature::{Creature, DofKind, Posture};
use bodyschema::evaluation::HeldOutPoint;
use bodyschema::geometry::tangent_basis;
use bodyschema::ground_truth::GroundTruth;
use bodyschema::kinematics::{Chain, ChainSide};
use bodyschema::learning::Z95;
use bodyschema::learning::observability::Observability;
use bodyschema::learning::observation::Observation;
use bodyschema::learning::surface_gap::SurfaceGap;
use bodyschema::schema::BodySchema;
use bodyschema::senses::{Input, RecordedTouch, Touch};

/// Random stream of the session's seed; bouts of babbling and initial guesses count from 0 and never get here.
const STREAM: u64 = u64::MAX - 3;
/// Newton's steps to a posture of the gap that was drawn.
const STEPS: usize = 20;
/// How near to it a posture must come, in deviations of the noise.
const REACHED: f64 = 1e-3;
/// Step of the differences that the gap's gradient is taken by, radians and metres.
const DIFFERENCE: f64 = 1e-5;

/// The touches with the noise that the surfaces' model assumes: at the true schema every gap is drawn from
/// a normal distribution of standard deviation `deviation`, metres.
///
/// The posture is what is wrong: it is moved along the gap's gradient over the joints between the two limbs
/// until the gap is the one that was drawn. Receptors stay as they were felt. Touches whose gap cannot be
/// changed by any joint are left out. The same seed gives the same noise.
pub fn with_gap_noise(
    agent: &Agent,
    truth: &GroundTruth,
    touches: &[RecordedTouch],
    deviation: f64,
    seed: u64,
) -> Vec<Touch> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    rng.set_stream(STREAM);
    let noisy = touches.iter().filter_map(|touch| {
        let standard: f64 = StandardNormal.sample(&mut rng);
        let posture = posture_of_gap(agent, truth, touch, deviation * standard, REACHED * deviation)?;
        Some(Touch { posture, ..touch.felt(Input::Receptor) })
    });
    noisy.collect()
}

/// The posture near a touch's own at which the true surfaces are `gap` apart; none where it is not found.
fn posture_of_gap(
    agent: &Agent,
    truth: &GroundTruth,
    touch: &Touch,
    gap: f64,
    tolerance: f64,
) -> Option<Posture> {
    let limbs = touch.limbs(agent.skin());
    let chain = Chain::between(agent.creature(), limbs[0], limbs[1]);
    let gap_at = |posture: &[f64]| true_gap(agent, truth, touch, posture);
    let ways = ways_to_move(agent.creature(), &chain);
    let mut posture = touch.posture.clone();
    for _ in 0..STEPS {
        let miss = gap - gap_at(&posture);
        if miss.abs() <= tolerance {
            return Some(posture);
        }
        let slope = |way: &PostureDirection| {
            let at = |step: f64| {
                let mut moved = posture.clone();
                way.step(&mut moved, step);
                gap_at(&moved)
            };
            (at(DIFFERENCE) - at(-DIFFERENCE)) / (2.0 * DIFFERENCE)
        };
        let gradient: Vec<f64> = ways.iter().map(slope).collect();
        let squared: f64 = gradient.iter().map(|slope| slope * slope).sum();
        if squared < 1e-12 {
            return None;
        }
        ways.iter().zip(&gradient).for_each(|(way, slope)| way.step(&mut posture, slope * miss / squared));
    }
    None
}

/// The gap of a touch's surfaces at a posture of the true body, metres.
pub fn true_gap(agent: &Agent, truth: &GroundTruth, touch: &Touch, posture: &[f64]) -> f64 {
    let skin = agent.skin();
    let limbs = touch.limbs(skin);
    let chain = Chain::between(agent.creature(), limbs[0], limbs[1]);
    let frames =
        [0, 1].map(|k| ChainSide::new(agent.creature(), &chain.sides[k], posture).frame(&truth.schema));
    let ends = touch.ends.map(|end| Observation {
        receptor: end.receptor,
        position: skin.receptors[end.receptor].position,
        covariance: nalgebra::Matrix3::identity(),
    });
    SurfaceGap::new(skin, 1.0).gap(&ends, &frames).distance
}

/// One way in which a posture can change: a coordinate, or a ball's turn about one of three directions.
struct PostureDirection {
    coordinate: usize,
    turn: Option<Vector3<f64>>,
}

impl PostureDirection {
    /// Changes a posture by `step`, radians or metres.
    fn step(&self, posture: &mut [f64], step: f64) {
        let coordinates = &mut posture[self.coordinate..];
        match self.turn {
            None => coordinates[0] += step,
            Some(direction) => {
                let [w, x, y, z] = [coordinates[0], coordinates[1], coordinates[2], coordinates[3]];
                let read = UnitQuaternion::from_quaternion(Quaternion::new(w, x, y, z));
                let turned = read * UnitQuaternion::from_scaled_axis(direction * step);
                coordinates[..4].copy_from_slice(&[turned.w, turned.i, turned.j, turned.k]);
            }
        }
    }
}

fn ways_to_move(creature: &Creature, chain: &Chain) -> Vec<PostureDirection> {
    let mut ways = Vec::new();
    for joint in chain.joints().map(|joint| &creature.joints()[joint]) {
        for at in joint.elements() {
            let coordinate = at.coordinate();
            match at.kind {
                DofKind::Hinge | DofKind::Slide => ways.push(PostureDirection { coordinate, turn: None }),
                DofKind::Ball => ways.extend(
                    [Vector3::x(), Vector3::y(), Vector3::z()]
                        .map(|turn| PostureDirection { coordinate, turn: Some(turn) }),
                ),
            }
        }
    }
    ways
}

/// Errors in units of their own predicted standard deviations: standard normal where the learner is as
/// sure as it should be. What the touches do not determine is left out.
#[derive(Clone, Debug, Default)]
pub struct NormalizedErrors {
    /// Per coordinate of every placed skin point, in the frame of the other limb.
    pub points: Vec<f64>,
    /// Per coordinate of every joint's position.
    pub positions: Vec<f64>,
    /// Per coordinate of every axis across its direction.
    pub axes: Vec<f64>,
}

impl NormalizedErrors {
    /// The errors of a schema, with the covariance that its touches give.
    pub fn new(
        creature: &Creature,
        truth: &GroundTruth,
        schema: &BodySchema,
        observability: &Observability,
        points: &[HeldOutPoint],
    ) -> NormalizedErrors {
        let mut errors = NormalizedErrors::default();
        for point in points {
            let Some(covariance) =
                observability.point_covariance(creature, schema, &point.posture, point.limbs, &point.p_a)
            else {
                continue;
            };
            let miss = point.land(creature, schema) - point.land(creature, &truth.schema);
            errors.points.extend((0..3).map(|i| miss[i] / covariance[(i, i)].sqrt()));
        }
        let parameters = &observability.parameters;
        for (joint, offset) in parameters.positions.iter().enumerate() {
            let Some(offset) = *offset else { continue };
            let miss = schema.positions[joint] - truth.schema.positions[joint];
            for i in 0..3 {
                let deviation = observability.parameter_std(offset + i);
                errors.positions.extend(deviation.map(|deviation| miss[i] / deviation));
            }
        }
        for (dof, offset) in parameters.axes.iter().enumerate() {
            let Some(offset) = *offset else { continue };
            let miss = tangent_basis(&schema.axes[dof]).tr_mul(&-truth.schema.axes[dof]);
            for i in 0..2 {
                let deviation = observability.parameter_std(offset + i);
                errors.axes.extend(deviation.map(|deviation| miss[i] / deviation));
            }
        }
        errors
    }
}

/// The share of errors within their 95 % intervals; NaN of none.
pub fn covered(normalized: &[f64]) -> f64 {
    let within = normalized.iter().filter(|error| error.abs() <= Z95).count();
    within as f64 / normalized.len() as f64
}
