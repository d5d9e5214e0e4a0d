//! Hersch's rule, as the paper prints it: a step down the gradient for every touch, in both directions.
//!
//! For a chain of transforms `T = T_1∘R_1 ∘ … ∘ T_n∘R_n` from the frame of one receptor's limb to the
//! other's, and a touch that gives `v_n` in the one and `v'_n` in the other (IVA 2009, equations 1 and 2,
//! after Hersch et al. 2008):
//!
//! ```text
//! Δl_i = ε (v'_n − T(v_n))ᵀ ∏_{j<i} R_j
//! Δa_i = ε (v'_n − T(v_n))ᵀ ∏_{j<i} R_j ∂/∂a_i (R_i(T_{i+1}∘R_{i+1} … (v_n)))
//! ```
//!
//! Along the way down the tree a joint is passed in the other sense, `R_i⁻¹∘T_i⁻¹`: its rotation is
//! `R(a_i, −θ_i)` and its length enters with the sign turned. Axes are scaled back to unit length after
//! every step. Nothing is added to make the rule do better than it does.
//!
//! Algorithm 1 repeats until the touch at hand no longer misses (line 23), and so does this. How near to 0 a miss has
//! to be, whether one touch is enough, and whether touches come back, the paper does not say. Here the tolerance is 0
//! unless it is set, one touch decides, and passes, where asked for, take touches in the order made: a random one.

use nalgebra::{Matrix3, Vector3};

use crate::agent::Agent;
use crate::creature::{DofKind, ball};
use crate::kinematics::{Chain, axis_derivative, rotation};
use crate::learning::{Basis, Learned, Learner, Verdict};
use crate::schema::BodySchema;
use crate::senses::Input;
use crate::senses::Touch;

/// The small positive scalar ε of equations 1 and 2.
pub const STEP: f64 = 0.05;

/// A learner by Hersch's rule.
pub struct Hersch {
    agent: Agent,
    input: Input,
    step: f64,
    passes: usize,
    double_use: bool,
    tolerance: f64,
    schema: BodySchema,
    /// What is to come back in further passes; empty where there are none.
    kept: Vec<PointPair>,
    ended: bool,
}

/// One point of space as two limbs have it, at a posture.
struct PointPair {
    posture: Vec<f64>,
    limbs: [usize; 2],
    points: [Vector3<f64>; 2],
}

/// One transform of the chain, as it is passed on the way from one limb to the other.
enum HerschLink {
    /// `T∘R` turned round or not, a whole degree of freedom: rotation and its derivative's ingredients.
    Turn { dof: usize, matrix: Matrix3<f64>, sine: f64, versine: f64 },
    /// A slide by a signed distance.
    Slide { dof: usize, distance: f64 },
    /// A ball, of which nothing is learned.
    Ball(Matrix3<f64>),
    /// A joint's position, with the sign it has on the way.
    Shift { joint: usize, sign: f64 },
}

impl Hersch {
    /// A learner that starts from an initial guess.
    pub fn new(agent: &Agent, input: Input, initial_guess: BodySchema) -> Hersch {
        let (step, passes, double_use, tolerance) = (STEP, 1, true, 0.0);
        let (schema, kept, ended) = (initial_guess, Vec::new(), false);
        Hersch { agent: agent.clone(), input, step, passes, double_use, tolerance, schema, kept, ended }
    }

    /// Sets ε, [`STEP`] by default.
    pub fn with_step(mut self, step: f64) -> Hersch {
        self.step = step;
        self
    }

    /// Sets the passes over all touches: 1 by default, in which each is used as it comes. [`Learner::learn`] makes the
    /// further ones, every time from what the first one left.
    pub fn with_passes(mut self, passes: usize) -> Hersch {
        self.passes = passes;
        self
    }

    /// Sets whether a touch is used from one limb to the other and back, as by default, or from the first limb alone.
    pub fn with_double_use(mut self, double_use: bool) -> Hersch {
        self.double_use = double_use;
        self
    }

    /// Sets the miss at which learning ends for good, metres: 0 by default (IVA 2009, Algorithm 1, line 23). It is the
    /// miss of a touch's last use, as the step finds it.
    pub fn with_tolerance(mut self, tolerance: f64) -> Hersch {
        self.tolerance = tolerance;
        self
    }

    /// Learns from one point of space, given in the frames of two limbs at a posture, metres: a touch, or a part of one
    /// limb as the other sees it (Hersch et al. 2008: a hand in the head's frame).
    pub fn observe_points(&mut self, posture: &[f64], limbs: [usize; 2], points: [Vector3<f64>; 2]) {
        let pair = PointPair { posture: posture.to_vec(), limbs, points };
        self.observe(&pair);
        if self.passes > 1 {
            self.kept.push(pair);
        }
    }

    /// One turn of Algorithm 1's loop.
    fn observe(&mut self, pair: &PointPair) {
        if self.ended {
            return;
        }
        let ([a, b], [p_a, p_b]) = (pair.limbs, pair.points);
        let mut miss = self.pass(&pair.posture, [a, b], p_a, p_b);
        // The double use of a touch: the same chain retraced (Algorithm 1, lines 18-22).
        if self.double_use {
            miss = self.pass(&pair.posture, [b, a], p_b, p_a);
        }
        self.ended = miss <= self.tolerance;
    }

    /// The links that carry a point of limb `from` into the frame of limb `to`, the last applied first.
    fn links(&self, posture: &[f64], from: usize, to: usize) -> Vec<HerschLink> {
        let chain = Chain::between(self.agent.creature(), from, to);
        let of = |side: usize, sign: f64| {
            chain.sides[side].iter().flat_map(move |&joint| self.joint_links(posture, joint, sign))
        };
        // Down to `to`: R⁻¹∘T⁻¹ per joint, the joint nearest to `to` outermost.
        let down: Vec<HerschLink> = of(1, -1.0).collect();
        down.into_iter().rev().chain(of(0, 1.0)).collect()
    }

    /// `T∘R_1∘…∘R_k` of a joint; with `sign` −1 each part is inverted, and the caller reverses their order.
    fn joint_links(&self, posture: &[f64], joint: usize, sign: f64) -> Vec<HerschLink> {
        let info = &self.agent.creature().joints()[joint];
        let mut links = vec![HerschLink::Shift { joint, sign }];
        for at in info.elements() {
            let (dof, q) = (at.axis(), at.coordinate());
            links.push(match at.kind {
                DofKind::Hinge => {
                    let (sine, cosine) = (sign * posture[q]).sin_cos();
                    let matrix = rotation(&self.schema.axes[dof], sine, 1.0 - cosine);
                    HerschLink::Turn { dof, matrix, sine, versine: 1.0 - cosine }
                }
                DofKind::Slide => HerschLink::Slide { dof, distance: sign * posture[q] },
                DofKind::Ball => {
                    let turned = ball(at.of(posture));
                    let turned = if sign < 0.0 { turned.inverse() } else { turned };
                    HerschLink::Ball(turned.to_rotation_matrix().into_inner())
                }
            });
        }
        links
    }

    /// One pass of Algorithm 1, lines 13-17: transform `v` into the other limb's frame and update every
    /// joint on the way by the error against `target`. How far it missed before, metres.
    fn pass(&mut self, posture: &[f64], limbs: [usize; 2], v: Vector3<f64>, target: Vector3<f64>) -> f64 {
        let links = self.links(posture, limbs[0], limbs[1]);
        // The point as it enters each link, innermost first.
        let mut entering = vec![Vector3::zeros(); links.len()];
        let mut p = v;
        for (link, enters) in links.iter().zip(&mut entering).rev() {
            *enters = p;
            p = match link {
                HerschLink::Turn { matrix, .. } | HerschLink::Ball(matrix) => matrix * p,
                HerschLink::Slide { dof, distance } => p + self.schema.axes[*dof] * *distance,
                HerschLink::Shift { joint, sign } => p + self.schema.positions[*joint] * *sign,
            };
        }
        // (v' − T(v))ᵀ ∏ R_j, carried inwards as a column.
        let mut error = (target - p) * self.step;
        for (link, enters) in links.iter().zip(&entering) {
            match link {
                HerschLink::Turn { dof, matrix, sine, versine } => {
                    let axis = &mut self.schema.axes[*dof];
                    let moved = *axis + axis_derivative(axis, *sine, *versine, enters).tr_mul(&error);
                    *axis = moved.try_normalize(1e-9).unwrap_or(*axis);
                    error = matrix.tr_mul(&error);
                }
                HerschLink::Slide { dof, distance } => {
                    let axis = &mut self.schema.axes[*dof];
                    let moved = *axis + error * *distance;
                    *axis = moved.try_normalize(1e-9).unwrap_or(*axis);
                }
                HerschLink::Ball(matrix) => error = matrix.tr_mul(&error),
                HerschLink::Shift { joint, sign } => self.schema.positions[*joint] += error * *sign,
            }
        }
        (target - p).norm()
    }
}

impl Learner for Hersch {
    fn touch(&mut self, touch: &Touch) {
        let limbs = touch.limbs(self.agent.skin());
        let places = touch.ends.map(|end| end.position(self.input, self.agent.skin()));
        self.observe_points(&touch.posture, limbs, places);
    }

    fn learn(&mut self) -> Learned {
        // Touches yet to come go on from the first pass, so the further ones are another learner's.
        let mut again =
            Hersch { schema: self.schema.clone(), kept: Vec::new(), agent: self.agent.clone(), ..*self };
        for _ in 1..self.passes {
            self.kept.iter().for_each(|pair| again.observe(pair));
        }
        let verdict =
            Verdict::Unjudged("Hersch's rule has no test of its own: look at the held-out error".to_string());
        Learned::unaccounted(again.schema, Basis::points(self.input), verdict, 1)
    }
}
