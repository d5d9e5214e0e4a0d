//! A tool in the hand: a rigid stick that is touched with.
//!
//! A stick that a limb holds is felt at the receptors that hold it, and touches far from them. The agent does
//! not know how long it is nor where it points: its tip, in the limb's frame, and its radius are what it
//! learns, with the surfaces that it touches where the schema puts them. From then on it is a part of the
//! body: the tip can be placed like any point of the skin.

use std::collections::BTreeMap;

use nalgebra::{DMatrix, DVector, Vector3};

use crate::geometry::{Capsule, Frame, Gap, Precision, gap as gap_between};
use crate::learning::Parameters;
use crate::learning::annealing::{NARROWEST, quantile};
use crate::learning::least_squares::{LeastSquares, Linearization, Stopping, levenberg_marquardt};
use crate::learning::observability::Observability;
use crate::learning::prediction::GapRow;
use crate::learning::touch_set::PreparedTouch;
use crate::schema::BodySchema;
use crate::skin::Skin;

/// How far the tip may be at first, metres: an arm's length is tried, and half and a quarter of it.
const REACH: f64 = 0.6;
/// The thickness that a stick is taken to have at first, metres.
const FIRST_RADIUS: f64 = 0.01;
/// How far from the receptor's middle the stick's axis may leave the hand, metres: a standard deviation, half a patch.
const GRIP: f64 = 0.01;
/// How well the radius is known before any touch, metres: a standard deviation.
const RADIUS: f64 = 0.02;
/// What a touch is never truer than, metres: how far skin goes in a step of a careful motion.
const TOUCH: f64 = 1e-4;
/// What is learned of a stick: its tip, where it leaves the hand, and its radius.
const PARAMETERS: usize = 7;
/// … of which so many are its tip's coordinates.
const POINT: f64 = 3.0;
/// Steps of the fit at one width.
const ITERATIONS: usize = 8;
/// From one width to the next it is no narrower than this share.
const NARROWING: f64 = 0.2;
/// Residuals beyond so many deviations count ever less (Cauchy weights).
const TAIL: f64 = 3.0;
/// The share of a stick's length, from its tip, within which a touch tells how long it is.
const TIP: f64 = 1e-3;

/// A stick on a limb: a capsule from where it is held to its tip.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tool {
    /// The limb that holds it.
    pub limb: usize,
    /// Where its axis leaves the hand, in the limb's frame, metres.
    pub grip: Vector3<f64>,
    /// The centre of its round tip, in the limb's frame, metres.
    pub tip: Vector3<f64>,
    /// Its radius, metres.
    pub radius: f64,
}

impl Tool {
    /// The gap between the tool and the surface on the other side of a touch, metres; none for a touch
    /// without the limb that holds it, or of a surface that is not known.
    pub fn gap(&self, skin: &Skin, schema: &BodySchema, touch: &PreparedTouch) -> Option<f64> {
        let side = self.side(skin, touch)?;
        Some(self.gap_at(skin, touch, side, &touch.frames(schema))?.distance)
    }

    /// Whether it is the tip that touches, which alone tells how long the stick is.
    pub fn touches_with_tip(&self, skin: &Skin, schema: &BodySchema, touch: &PreparedTouch) -> bool {
        let Some(side) = self.side(skin, touch) else { return false };
        let frames = touch.frames(schema);
        self.gap_at(skin, touch, side, &frames).is_some_and(|gap| {
            let along = self.tip - self.grip;
            let at = frames[side].inverse_point(&gap.points[0]) - self.grip;
            at.dot(&along) > (1.0 - TIP) * along.norm_squared()
        })
    }

    /// The side of a touch that is the limb's which holds it.
    fn side(&self, skin: &Skin, touch: &PreparedTouch) -> Option<usize> {
        (0..2).find(|&k| skin.receptors[touch.ends[k].receptor].limb == self.limb)
    }

    fn gap_at(&self, skin: &Skin, touch: &PreparedTouch, side: usize, frames: &[Frame; 2]) -> Option<Gap> {
        let surface = skin.receptors[touch.ends[1 - side].receptor].surface?;
        let other = skin.surfaces[surface].placed(&frames[1 - side])?;
        Some(gap_between(&self.capsule().placed(&frames[side]), &other, Precision::Exact))
    }

    /// The tool in its limb's frame.
    pub fn capsule(&self) -> Capsule {
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

    /// The tool moved to close its gaps: Levenberg-Marquardt over tip, grip and radius, annealed as the gaps close.
    pub fn settled(&self, skin: &Skin, schema: &BodySchema, touches: &[&PreparedTouch]) -> Tool {
        let gaps = Gaps::of(self, skin, schema, touches);
        let mut tool = *self;
        if gaps.of_tool(&tool).len() < 4 {
            return tool;
        }
        let mut closing = Closing { held: gaps.held(), gaps, deviation: 0.05 };
        while closing.deviation >= NARROWEST {
            let stopping = Stopping { iterations: ITERATIONS, ..Stopping::default() };
            tool = levenberg_marquardt(&mut closing, tool, stopping).state;
            // Where most touches are the shaft's, the few of the tip must not be taken for false ones at once.
            let next = 1.5 * quantile(&sizes(&closing.gaps.of_tool(&tool)), 0.6);
            closing.deviation = next.clamp(NARROWING * closing.deviation, 0.5 * closing.deviation);
        }
        tool
    }

    /// How well touches tell where the tip is: one standard deviation of its distance, metres, to first order at this tool,
    /// by how well it closes their gaps and by how well the body is known over which it does; infinite where they leave it
    /// open. A body of which nothing is told is taken as it is.
    pub fn tip_deviation(
        &self,
        skin: &Skin,
        schema: &BodySchema,
        touches: &[&PreparedTouch],
        body: Option<&Observability>,
    ) -> f64 {
        let gaps = Gaps::of(self, skin, schema, touches);
        let found = gaps.of_tool(self);
        // Of a normal distribution, 68 % is within one deviation.
        let spare = (found.len() as f64 - PARAMETERS as f64).max(1.0);
        let of_all = quantile(&sizes(&found), 0.68) * (found.len() as f64 / spare).sqrt();
        // The tip's touches alone tell how long it is, and few may be among many of the shaft.
        let by_tip: Vec<f64> = touches
            .iter()
            .filter(|touch| self.touches_with_tip(skin, schema, touch))
            .filter_map(|touch| self.gap(skin, schema, touch))
            .collect();
        let spare = (by_tip.len() as f64 - POINT).max(1.0);
        let of_tip = match by_tip.len() {
            0 => 0.0,
            count => quantile(&sizes(&by_tip), 0.68) * (count as f64 / spare).sqrt(),
        };
        let deviation = of_all.max(of_tip).max(TOUCH);
        let mut hessian = gaps.linearized(self, deviation).hessian;
        for k in 3..PARAMETERS {
            hessian[(k, k)] += if k < 6 { GRIP } else { RADIUS }.powi(-2);
        }
        let Some(factor) = hessian.cholesky() else { return f64::INFINITY };
        let inverse = factor.inverse();
        let of_tip = inverse.rows(0, 3);
        let by_touches = of_tip.columns(0, 3).trace();
        // An error of the body opens many gaps at once, and the tip follows all of them.
        let by_body = body.map_or(Some(0.0), |body| {
            let shifts = of_tip * gaps.opened_by_body(self, deviation, schema, &body.parameters);
            body.shift_covariance(&shifts).map(|covariance| covariance.trace())
        });
        let variance = by_touches + by_body.unwrap_or(f64::INFINITY);
        if variance.is_finite() && variance >= 0.0 { variance.sqrt() } else { f64::INFINITY }
    }

    fn moved(&self, step: &DVector<f64>) -> Tool {
        let (tip, grip) = (self.tip + step.fixed_rows::<3>(0), self.grip + step.fixed_rows::<3>(3));
        Tool { tip, grip, radius: (self.radius + step[6]).clamp(0.0, 0.2), ..*self }
    }
}

/// The touches of a limb that holds a stick, with where limbs are in them.
struct Gaps<'a> {
    skin: &'a Skin,
    placed: Vec<Placed<'a>>,
}

/// A touch, its side that is the limb's which holds the stick, and where both limbs are.
type Placed<'a> = (&'a PreparedTouch, usize, [Frame; 2]);

impl<'a> Gaps<'a> {
    fn of(tool: &Tool, skin: &'a Skin, schema: &BodySchema, touches: &[&'a PreparedTouch]) -> Gaps<'a> {
        let placed =
            |touch: &&'a PreparedTouch| Some((*touch, tool.side(skin, touch)?, touch.frames(schema)));
        Gaps { skin, placed: touches.iter().filter_map(placed).collect() }
    }

    /// Where the stick is held: the middle of the receptor that feels it, in the limb's frame, metres.
    fn held(&self) -> Vector3<f64> {
        let at = |(touch, side, _): &Placed| self.skin.receptors[touch.ends[*side].receptor].position;
        self.placed.first().map_or(Vector3::zeros(), at)
    }

    /// The gaps that a tool leaves open, metres.
    fn of_tool(&self, tool: &Tool) -> Vec<f64> {
        let gap =
            |(touch, side, frames): &Placed| Some(tool.gap_at(self.skin, touch, *side, frames)?.distance);
        self.placed.iter().filter_map(gap).collect()
    }

    /// Each touch with its gap, how that opens as the tool changes, and its weight: Cauchy's, for a width in metres, 1/m².
    fn slopes(
        &self,
        tool: &Tool,
        deviation: f64,
    ) -> impl Iterator<Item = (&Placed<'a>, Gap, DVector<f64>, f64)> {
        self.placed.iter().filter_map(move |placed| {
            let (touch, side, frames) = placed;
            let gap = tool.gap_at(self.skin, touch, *side, frames)?;
            let along = tool.tip - tool.grip;
            let at = frames[*side].inverse_point(&gap.points[0]) - tool.grip;
            let share = (at.dot(&along) / along.norm_squared().max(f64::MIN_POSITIVE)).clamp(0.0, 1.0);
            let normal = frames[*side].rotation.tr_mul(&gap.normal);
            let of_radius = std::iter::once(-1.0);
            let slope =
                [share, 1.0 - share].into_iter().flat_map(|share| [0, 1, 2].map(|k| share * normal[k]));
            let slope = DVector::from_iterator(PARAMETERS, slope.chain(of_radius));
            let weight = 1.0 / (deviation.powi(2) + (gap.distance / TAIL).powi(2));
            Some((placed, gap, slope, weight))
        })
    }

    /// The normal equations of the gaps at a tool, for a width in metres.
    fn linearized(&self, tool: &Tool, deviation: f64) -> Linearization {
        let mut model = Linearization::nothing(PARAMETERS);
        for (_, gap, slope, weight) in self.slopes(tool, deviation) {
            model.hessian.ger(weight, &slope, &slope, 1.0);
            model.gradient.axpy(weight * gap.distance, &slope, 1.0);
        }
        model
    }

    /// `Jᵀ W G` with `G` how the gaps open with the schema's parameters, a column each.
    fn opened_by_body(
        &self,
        tool: &Tool,
        deviation: f64,
        schema: &BodySchema,
        parameters: &Parameters,
    ) -> DMatrix<f64> {
        let mut opened = DMatrix::zeros(PARAMETERS, parameters.len());
        let mut row = GapRow::default();
        for ((touch, side, frames), gap, slope, weight) in self.slopes(tool, deviation) {
            // The two places that meet, each in its limb's frame.
            let mut meeting = (*touch).clone();
            meeting.ends[*side].position = frames[*side].inverse_point(&gap.points[0]);
            meeting.ends[1 - side].position = frames[1 - side].inverse_point(&gap.points[1]);
            let along = if *side == 0 { gap.normal } else { -gap.normal };
            row.set_miss(parameters, schema, &meeting, &along);
            for &(column, opens) in &row.entries {
                let mut column = opened.column_mut(column);
                column.axpy(weight * opens, &slope, 1.0);
            }
        }
        opened
    }
}

/// The problem of closing a stick's gaps at one width of these, metres.
struct Closing<'a> {
    gaps: Gaps<'a>,
    /// Where the stick is held, in the limb's frame, metres.
    held: Vector3<f64>,
    deviation: f64,
}

impl LeastSquares for Closing<'_> {
    type State = Tool;

    fn linearize(&mut self, tool: &Tool) -> Linearization {
        let mut model = self.gaps.linearized(tool, self.deviation);
        for (first, at, metres) in [(0, tool.tip, REACH), (3, tool.grip, GRIP)] {
            for k in 0..3 {
                model.hessian[(first + k, first + k)] += metres.powi(-2);
                model.gradient[first + k] += (at - self.held)[k] * metres.powi(-2);
            }
        }
        Linearization { scale: model.hessian.diagonal(), cost: self.cost(tool), ..model }
    }

    /// Touches of the shaft alone leave the length open: then it is as short as they allow.
    fn cost(&self, tool: &Tool) -> f64 {
        let gaps = self.gaps.of_tool(tool);
        let gaps: f64 = gaps.iter().map(|gap| (gap / self.deviation / TAIL).powi(2).ln_1p()).sum();
        let known = (tool.tip - self.held).norm_squared() / (REACH * REACH)
            + (tool.grip - self.held).norm_squared() / (GRIP * GRIP);
        0.5 * (TAIL * TAIL * gaps + known)
    }

    fn step(&self, tool: &Tool, step: &DVector<f64>) -> Tool {
        tool.moved(step)
    }
}

/// How wide gaps are, the narrowest first.
fn sizes(gaps: &[f64]) -> Vec<f64> {
    let mut sizes: Vec<f64> = gaps.iter().map(|gap| gap.abs()).collect();
    sizes.sort_by(f64::total_cmp);
    sizes
}

/// The directions to the faces and corners of a cube.
fn directions() -> impl Iterator<Item = Vector3<f64>> {
    let signs = [-1.0, 0.0, 1.0];
    let all = signs.into_iter().flat_map(move |x| {
        signs.into_iter().flat_map(move |y| signs.into_iter().map(move |z| Vector3::new(x, y, z)))
    });
    all.filter(|v| v.norm_squared() == 1.0 || v.norm_squared() == 3.0).map(|v| v.normalize())
}
