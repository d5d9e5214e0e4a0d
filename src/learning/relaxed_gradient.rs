//! The repaired gradient: Hersch's rule, a step for every touch, with what made it fail taken away.
//!
//! Five repairs, and nothing else, carry a plain stochastic gradient from random initial guesses to the answer:
//!
//! 1. *Axes are relaxed*: free in R³, with `R = I + sin θ [a]× + (1 − cos θ) [a]×²` polynomial in them. They
//!    are never scaled back while learning goes on, only in the schema that is handed out. On the sphere an
//!    axis that points the wrong way has to turn all the way round; off it, it shrinks and grows again.
//! 2. *The chain is symmetric*: both places are carried up to the common ancestor and nothing is inverted, so
//!    that one pass does what Hersch's two do.
//! 3. *The step is normalised*: whatever the chain's length, a touch closes the same share of its miss.
//! 4. *Touches are kept and used again*, in passes of random order, and a receptor's extent counts ever more:
//!    at first the centres are pulled together, at last the miss weighs only as far as the two patches do
//!    not explain it.
//! 5. *Axes drift home*: noise makes relaxed axes shrink, so each step also goes down the gradient of
//!    `¼ (|a|² − 1)²`, from not at all in the first pass to gently in the last.
//!
//! With miss `e = p_CA − p_CB`, its Jacobian `J`, the parameters' scale `M` (positions in units of
//! [`LENGTH`], axes in units of 1) and the covariance `Σ` of both places, all in the ancestor's frame, a
//! touch makes the step
//!
//! ```text
//! Δ = −ε M Jᵀ (J M Jᵀ + Σ / s)⁻¹ e
//! ```
//!
//! in which s falls from 1 to [`LAST_SCALE`]. For large s this is the normalised least-mean-squares step
//! (Kaczmarz's projection of the touch's three equations), for small s it is `ε s` times the gradient of
//! the whitened miss, with a step that decays. Then every axis of the chain makes the step
//! `−w (|a|² − 1) a`, in which w rises from 0 to [`LAST_PULL`].
//!
//! What it cannot do: every touch counts alike, and on Max's torso one false touch in fifty undid the others.

use nalgebra::{Matrix3, Vector3};
use rand::SeedableRng;
use rand::seq::SliceRandom;
use rand_chacha::ChaCha8Rng;

use crate::agent::Agent;
use crate::deadline::count_work;
use crate::kinematics::{Chain, ChainSide, SideJacobian};
use crate::learning::touch_set::{LimbTouch, PreparedTouch};
use crate::learning::{Basis, Learned, Learner, Verdict};
use crate::schema::BodySchema;
use crate::senses::Input;
use crate::senses::Touch;

/// The share ε of a touch's miss that a step closes: half, where 1 lets the last touch undo all others.
pub const SHARE: f64 = 0.5;
/// How far a joint's position moves as readily as its axis by 1, metres: about a limb's radius. From 0.05 to
/// 0.1 it makes little difference; from 1 nothing is learned.
pub const LENGTH: f64 = 0.07;
/// Where the scale s of the steps ends; it starts at 1 and falls by the same factor in every pass.
pub const LAST_SCALE: f64 = 1e-5;
/// Where the weight w of the pull towards unit axes ends; it starts at 0 and rises with the square of the
/// passes done. From 0.01 to 1 it makes no difference; with 0 receptor centres leave a seventh more error.
pub const LAST_PULL: f64 = 0.1;
/// Steps in all, whatever the number of touches: about a second.
pub const STEPS: usize = 1_000_000;
/// What a step counts as, in work of [`count_work`].
const STEP: usize = 4_000;
/// How exact a contact point is taken to be, metres.
const CONTACT_DEVIATION: f64 = 1e-4;
/// The seed's stream for the order of touches; the initial guess is drawn from stream 0.
const ORDER_STREAM: u64 = 1;

/// The learner `gradient`.
pub struct RelaxedGradient {
    agent: Agent,
    input: Input,
    initial_guess: BodySchema,
    seed: u64,
    steps: usize,
    touches: Vec<PreparedTouch>,
}

impl RelaxedGradient {
    /// A learner that starts from an initial guess and takes its touches in an order drawn from `seed`.
    pub fn new(agent: &Agent, input: Input, initial_guess: BodySchema, seed: u64) -> RelaxedGradient {
        RelaxedGradient {
            agent: agent.clone(),
            input,
            initial_guess,
            seed,
            steps: STEPS,
            touches: Vec::new(),
        }
    }

    /// Sets the number of steps in all, [`STEPS`] by default; every touch is used once at the least.
    pub fn with_steps(mut self, steps: usize) -> RelaxedGradient {
        self.steps = steps;
        self
    }
}

/// Descends from an initial guess by `steps` steps, every touch used once at the least; axes are left relaxed.
fn descend(
    touches: &[PreparedTouch],
    initial_guess: BodySchema,
    steps: usize,
    rng: &mut ChaCha8Rng,
) -> BodySchema {
    let mut schema = initial_guess;
    let mut order: Vec<usize> = (0..touches.len()).collect();
    let mut sides = [SideJacobian::default(), SideJacobian::default()];
    let passes = (steps / order.len().max(1)).max(1);
    count_work(STEP * passes * order.len());
    for pass in 0..passes {
        let progress = pass as f64 / (passes - 1).max(1) as f64;
        let weights = (LAST_SCALE.powf(progress), LAST_PULL * progress * progress);
        order.shuffle(rng);
        order.iter().for_each(|&touch| step(&mut schema, &touches[touch], weights, &mut sides));
    }
    schema
}

/// One step down from one touch, with the present scale s of the steps and weight w of the pull.
fn step(
    schema: &mut BodySchema,
    touch: &PreparedTouch,
    (scale, pull): (f64, f64),
    sides: &mut [SideJacobian; 2],
) {
    let mut resistance = Matrix3::zeros();
    for ((side, end), jacobian) in touch.sides.iter().zip(&touch.ends).zip(&mut *sides) {
        side.point_jacobian(schema, &end.position, jacobian);
        let rotation = jacobian.frame.rotation;
        resistance += rotation * end.covariance * rotation.transpose() / scale;
        for (_, by_position) in &jacobian.joints {
            resistance += by_position * by_position.transpose() * (LENGTH * LENGTH);
        }
        for (_, by_axis) in &jacobian.dofs {
            resistance += by_axis * by_axis.transpose();
        }
    }
    let Some(factor) = resistance.cholesky() else { return };
    let force = factor.solve(&(sides[0].position - sides[1].position)) * SHARE;
    // Far off, relaxed chains may overflow: such a touch says nothing.
    if !force.iter().all(|x| x.is_finite()) {
        return;
    }
    for (jacobian, sign) in sides.iter().zip([-1.0, 1.0]) {
        let force: Vector3<f64> = force * sign;
        for (joint, by_position) in &jacobian.joints {
            schema.positions[*joint] += by_position.tr_mul(&force) * (LENGTH * LENGTH);
        }
        for (dof, by_axis) in &jacobian.dofs {
            let axis = &mut schema.axes[*dof];
            *axis += by_axis.tr_mul(&force);
            // Bounded, so that an axis far too long shrinks in place of turning over.
            *axis *= 1.0 - (pull * (axis.norm_squared() - 1.0)).clamp(-0.5, 0.5);
        }
    }
}

impl Learner for RelaxedGradient {
    fn touch(&mut self, touch: &Touch) {
        let variance = |_| 0.5 * CONTACT_DEVIATION * CONTACT_DEVIATION;
        let felt = LimbTouch::of(self.agent.skin(), touch, self.input, variance);
        let chain = Chain::between(self.agent.creature(), felt.limbs[0], felt.limbs[1]);
        let sides = [0, 1].map(|k| ChainSide::new(self.agent.creature(), &chain.sides[k], &touch.posture));
        self.touches.push(PreparedTouch { sides, ends: felt.ends });
    }

    fn learn(&mut self) -> Learned {
        let mut rng = ChaCha8Rng::seed_from_u64(self.seed);
        rng.set_stream(ORDER_STREAM);
        let mut schema = descend(&self.touches, self.initial_guess.clone(), self.steps, &mut rng);
        let mut why = "the gradient has no test of its own: look at the held-out error";
        if !schema.fits(self.agent.creature()) {
            schema = self.initial_guess.clone();
            why = "the gradient diverged and its initial guess is left: try more touches (--touches) or --learner lm";
        }
        schema.normalize_axes(self.agent.creature());
        let verdict = Verdict::Unjudged(why.to_string());
        Learned::unaccounted(schema, Basis::points(self.input), verdict, 1)
    }
}
