//! A tool in the hand: a rigid stick that is touched with.
//!
//! A stick that a limb holds is felt at the receptors that hold it, and touches far from them. The agent does
//! not know how long it is nor where it points: its tip, in the limb's frame, and its radius are what it
//! learns, with the surfaces that it touches where the schema puts them. From then on it is a part of the
//! body: the tip can be placed like any point of the skin.

use std::collections::BTreeMap;

use nalgebra::{Matrix4, Vector3, Vector4};

use crate::geometry::{Capsule, Frame};
use crate::learning::annealing::{NARROWEST, quantile};
use crate::learning::touch_set::PreparedTouch;
use crate::schema::BodySchema;
use crate::skin::Skin;

/// How far the tip may be at first, metres: an arm's length is tried, and half and a quarter of it.
const REACH: f64 = 0.6;
/// The thickness that a stick is taken to have at first, metres.
const FIRST_RADIUS: f64 = 0.01;
/// Steps of the fit at one width.
const ITERATIONS: usize = 8;
/// Residuals beyond so many deviations count ever less (Cauchy weights).
const TAIL: f64 = 3.0;

/// A stick on a limb: a capsule from where it is held to its tip.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tool {
    /// The limb that holds it.
    pub limb: usize,
    /// Where it is held, in the limb's frame, metres.
    pub grip: Vector3<f64>,
    /// The centre of its round tip, in the limb's frame, metres.
    pub tip: Vector3<f64>,
    /// Its radius, metres.
    pub radius: f64,
}

impl Tool {
    /// The gap between the tool and the surface on the other side of a touch, metres; none for a touch
    /// without the limb that holds it, or of a surface that is no sphere or capsule.
    pub fn gap(&self, skin: &Skin, schema: &BodySchema, touch: &PreparedTouch) -> Option<f64> {
        let side = (0..2).find(|&k| skin.receptors[touch.ends[k].receptor].limb == self.limb)?;
        self.gap_at(skin, touch, side, &touch.frames(schema))
    }

    fn gap_at(&self, skin: &Skin, touch: &PreparedTouch, side: usize, frames: &[Frame; 2]) -> Option<f64> {
        let surface = skin.receptors[touch.ends[1 - side].receptor].surface?;
        let other = skin.surfaces[surface].as_capsule()?.placed(&frames[1 - side]);
        Some(self.capsule().placed(&frames[side]).gap(&other).distance)
    }

    /// The tool in its limb's frame.
    fn capsule(&self) -> Capsule {
        Capsule { ends: [self.grip, self.tip], radius: self.radius }
    }

    /// The stick on a limb that explains most of the touches, and how many of them it explains to `close`,
    /// metres.
    pub fn fit(
        limb: usize,
        skin: &Skin,
        schema: &BodySchema,
        touches: &[&PreparedTouch],
        close: f64,
    ) -> Option<(Tool, usize)> {
        let receptor_of = |touch: &PreparedTouch| {
            touch.ends.iter().map(|end| end.receptor).find(|&r| skin.receptors[r].limb == limb)
        };
        // Whatever the stick touches, the same receptor feels.
        let mut felt: BTreeMap<usize, usize> = BTreeMap::new();
        touches.iter().filter_map(|touch| receptor_of(touch)).for_each(|r| *felt.entry(r).or_default() += 1);
        let (&receptor, _) = felt.iter().max_by_key(|(_, count)| **count)?;
        let grip = skin.receptors[receptor].position;
        let mut best: Option<(Tool, usize)> = None;
        for length in [0.25 * REACH, 0.5 * REACH, REACH] {
            for direction in directions() {
                let initial_guess = Tool { limb, grip, tip: grip + direction * length, radius: FIRST_RADIUS };
                let tool = initial_guess.settled(skin, schema, touches);
                let explained = tool.explained(skin, schema, touches, close);
                if best.is_none_or(|(_, most)| explained > most) {
                    best = Some((tool, explained));
                }
            }
        }
        best
    }

    /// The tool fitted to all touches that it explained so far: moved a little, or where that leaves many of
    /// them open (the tip has touched, and before it the shaft alone had), anew.
    pub fn refitted(&self, skin: &Skin, schema: &BodySchema, touches: &[&PreparedTouch], close: f64) -> Tool {
        let settled = self.settled(skin, schema, touches);
        let explained = settled.explained(skin, schema, touches, close);
        if 10 * explained >= 9 * touches.len() {
            return settled;
        }
        let anew = Tool::fit(self.limb, skin, schema, touches, close);
        anew.filter(|(_, more)| *more > explained).map_or(settled, |(tool, _)| tool)
    }

    /// How many touches it explains to `close`, metres.
    pub fn explained(
        &self,
        skin: &Skin,
        schema: &BodySchema,
        touches: &[&PreparedTouch],
        close: f64,
    ) -> usize {
        let gap = |touch: &&PreparedTouch| self.gap(skin, schema, touch).is_some_and(|gap| gap.abs() < close);
        touches.iter().filter(|touch| gap(touch)).count()
    }

    /// The tool moved to close its gaps: Levenberg-Marquardt over tip and radius, annealed as the gaps close.
    pub fn settled(&self, skin: &Skin, schema: &BodySchema, touches: &[&PreparedTouch]) -> Tool {
        let placed: Vec<(&PreparedTouch, usize, [Frame; 2])> = touches
            .iter()
            .filter_map(|touch| {
                let limb_at = |k: &usize| skin.receptors[touch.ends[*k].receptor].limb == self.limb;
                let side = (0..2).find(limb_at)?;
                Some((*touch, side, touch.frames(schema)))
            })
            .collect();
        let gaps = |tool: &Tool| -> Vec<f64> {
            placed
                .iter()
                .filter_map(|(touch, side, frames)| tool.gap_at(skin, touch, *side, frames))
                .collect()
        };
        let mut tool = *self;
        let mut found = gaps(&tool);
        if found.len() < 4 {
            return tool;
        }
        let mut deviation = 0.05_f64;
        let mut damping = 1e-3;
        while deviation >= NARROWEST {
            // Touches of the shaft alone leave the length open: then it is as short as they allow.
            let cost = |tool: &Tool, found: &[f64]| -> f64 {
                let gaps: f64 = found.iter().map(|gap| (gap / deviation / TAIL).powi(2).ln_1p()).sum();
                TAIL * TAIL * gaps + (tool.tip - tool.grip).norm_squared() / (REACH * REACH)
            };
            for _ in 0..ITERATIONS {
                let slopes: Vec<Vec<f64>> = (0..4)
                    .map(|k| {
                        const STEP: f64 = 1e-7;
                        let mut step = Vector4::zeros();
                        step[k] = STEP;
                        let shifted = gaps(&tool.moved(&step));
                        shifted.iter().zip(&found).map(|(after, before)| (after - before) / STEP).collect()
                    })
                    .collect();
                let (mut hessian, mut gradient) = (Matrix4::zeros(), Vector4::zeros());
                for (i, gap) in found.iter().enumerate() {
                    let weight = 1.0 / (1.0 + (gap / deviation / TAIL).powi(2));
                    let slope = Vector4::from_fn(|k, _| slopes[k][i]);
                    hessian += slope * slope.transpose() * weight;
                    gradient += slope * (weight * gap);
                }
                let pull = (deviation / REACH).powi(2);
                for k in 0..3 {
                    hessian[(k, k)] += pull;
                    gradient[k] += pull * (tool.tip - tool.grip)[k];
                }
                let floor = 1e-6 * hessian.diagonal().amax().max(f64::MIN_POSITIVE);
                for k in 0..4 {
                    hessian[(k, k)] += damping * hessian[(k, k)] + floor;
                }
                let Some(factor) = hessian.cholesky() else { break };
                let trial = tool.moved(&-factor.solve(&gradient));
                let after = gaps(&trial);
                if after.len() == found.len() && cost(&trial, &after) < cost(&tool, &found) {
                    (tool, found, damping) = (trial, after, (0.1 * damping).max(1e-9));
                } else {
                    damping *= 10.0;
                }
            }
            damping = damping.min(1.0);
            let mut sizes: Vec<f64> = found.iter().map(|gap| gap.abs()).collect();
            sizes.sort_by(f64::total_cmp);
            deviation = (1.5 * quantile(&sizes, 0.6)).min(0.5 * deviation);
        }
        tool
    }

    fn moved(&self, step: &Vector4<f64>) -> Tool {
        let tip = self.tip + step.xyz();
        Tool { tip, radius: (self.radius + step.w).clamp(0.0, 0.2), ..*self }
    }
}

/// The directions to the faces and corners of a cube.
fn directions() -> impl Iterator<Item = Vector3<f64>> {
    let signs = [-1.0, 0.0, 1.0];
    let all = signs.into_iter().flat_map(move |x| {
        signs.into_iter().flat_map(move |y| signs.into_iter().map(move |z| Vector3::new(x, y, z)))
    });
    all.filter(|v| v.norm_squared() == 1.0 || v.norm_squared() == 3.0).map(|v| v.normalize())
}
