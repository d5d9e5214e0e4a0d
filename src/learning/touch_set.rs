//! Touches made ready for a solver: grouped by limb pair, trigonometry done once.

use std::collections::BTreeSet;

use nalgebra::{DMatrix, DVector, Matrix3, Matrix3x2, Vector3};

use crate::creature::Creature;
use crate::deadline::count_work;
use crate::geometry::{Frame, Gap, tangent_basis};
use crate::kinematics::{Chain, ChainSide, SideJacobian};
use crate::learning::least_squares::{LeastSquares, Linearization, Stopping, levenberg_marquardt};
use crate::learning::observation::{Observation, ObservationModel, PointsMeet, TouchResiduals};
use crate::learning::prior::Prior;
use crate::learning::surface_gap::SurfaceGap;
use crate::learning::{AxisModel, Parameters};
use crate::schema::BodySchema;
use crate::senses::{Input, Touch};
use crate::skin::Skin;

/// What looking at how a touch is explained counts as, in work of [`count_work`].
pub(super) const LOOK: usize = 3_000;

/// How far a curved limb is taken to bulge out of a flat patch, metres.
const NORMAL_DEVIATION: f64 = 6e-3;

/// One touch as a solver sees it: two points that met in one posture.
#[derive(Clone, Debug)]
pub struct PreparedTouch {
    /// Per end, its side of the chain at the touch's posture.
    pub sides: [ChainSide; 2],
    /// Per end, what was felt.
    pub ends: [Observation; 2],
}

/// All touches between one pair of limbs.
#[derive(Clone, Debug)]
pub struct PairTouches {
    /// The two limbs.
    pub limbs: [usize; 2],
    /// The chain between them.
    pub chain: Chain,
    /// The touches.
    pub touches: Vec<PreparedTouch>,
}

/// Touches grouped by the pair of limbs, in the order of the limbs.
#[derive(Clone, Debug, Default)]
pub struct TouchSet {
    /// The groups.
    pub pairs: Vec<PairTouches>,
}

/// A touch between two limbs in a posture, as it enters a [`TouchSet`].
#[derive(Clone, Debug)]
pub struct LimbTouch<'a> {
    /// The limbs.
    pub limbs: [usize; 2],
    /// Posture coordinates.
    pub posture: &'a [f64],
    /// Per end, what was felt.
    pub ends: [Observation; 2],
}

impl TouchSet {
    /// How many touches each limb has.
    pub fn count_of_limbs(&self, creature: &Creature) -> Vec<usize> {
        let mut counts = vec![0; creature.limbs().len()];
        for pair in &self.pairs {
            pair.limbs.iter().for_each(|&limb| counts[limb] += pair.touches.len());
        }
        counts
    }

    /// Groups and prepares touches.
    pub fn new<'a>(creature: &Creature, touches: impl IntoIterator<Item = LimbTouch<'a>>) -> TouchSet {
        let mut set = TouchSet::default();
        touches.into_iter().for_each(|touch| set.push(creature, touch));
        set
    }

    /// Adds a touch.
    pub fn push(&mut self, creature: &Creature, touch: LimbTouch) {
        let (limbs, touch) = touch.prepare(creature);
        self.push_prepared(creature, limbs, touch);
    }

    /// Adds a touch between two limbs, the earlier one first, that is prepared already.
    pub fn push_prepared(&mut self, creature: &Creature, limbs: [usize; 2], touch: PreparedTouch) {
        let place = match self.pairs.binary_search_by_key(&limbs, |pair| pair.limbs) {
            Ok(place) => place,
            Err(place) => {
                let chain = Chain::between(creature, limbs[0], limbs[1]);
                self.pairs.insert(place, PairTouches { limbs, chain, touches: Vec::new() });
                place
            }
        };
        self.pairs[place].touches.push(touch);
    }

    /// Number of touches.
    pub fn len(&self) -> usize {
        self.pairs.iter().map(|pair| pair.touches.len()).sum()
    }

    /// Whether there is no touch.
    pub fn is_empty(&self) -> bool {
        self.pairs.is_empty()
    }

    /// All touches, pair by pair.
    pub fn touches(&self) -> impl Iterator<Item = &PreparedTouch> {
        self.pairs.iter().flat_map(|pair| &pair.touches)
    }

    /// The joints between limbs that touched.
    pub fn joints(&self) -> BTreeSet<usize> {
        self.pairs.iter().flat_map(|pair| pair.chain.joints()).collect()
    }

    /// The limbs that touched.
    pub fn limbs(&self) -> BTreeSet<usize> {
        self.pairs.iter().flat_map(|pair| pair.limbs).collect()
    }

    /// The same touches for whoever moves no more than these parameters from a schema on: joints that are held stay as it has
    /// them, multiplied out once and not for every look at a touch.
    pub fn with_held(&self, creature: &Creature, parameters: &Parameters, schema: &BodySchema) -> TouchSet {
        let is_held: Vec<bool> =
            (0..creature.joints().len()).map(|joint| parameters.holds(creature, joint)).collect();
        let mut set = self.clone();
        let changed = set.pairs.iter_mut().filter(|pair| pair.chain.joints().any(|joint| is_held[joint]));
        for touch in changed.flat_map(|pair| &mut pair.touches) {
            touch.sides.iter_mut().for_each(|side| *side = side.with_held(schema, |joint| is_held[joint]));
        }
        set
    }

    /// Per touch, the sum of the squares of the three whitened residuals of its points.
    pub fn squared_misfits(&self, model: PointsMeet, schema: &BodySchema) -> impl Iterator<Item = f64> {
        self.touches().map(move |touch| model.squared_misfit(&touch.ends, &touch.frames(schema)))
    }

    /// Root mean square of these residuals.
    pub fn misfit(&self, model: PointsMeet, schema: &BodySchema) -> f64 {
        (self.squared_misfits(model, schema).sum::<f64>() / (3 * self.len().max(1)) as f64).sqrt()
    }

    /// The pairs for which `keep` holds.
    pub fn filter(&self, keep: impl Fn(&PairTouches) -> bool) -> TouchSet {
        TouchSet { pairs: self.pairs.iter().filter(|pair| keep(pair)).cloned().collect() }
    }
}

impl<'a> LimbTouch<'a> {
    /// A touch of two receptors in a posture, made or only imagined: the centres of their patches, with the shape of these.
    pub fn of_receptors(skin: &Skin, receptors: [usize; 2], posture: &'a [f64]) -> LimbTouch<'a> {
        let felt = receptors.map(|receptor| &skin.receptors[receptor]);
        let ends = [0, 1].map(|end| Observation {
            receptor: receptors[end],
            position: felt[end].position,
            covariance: felt[end].covariance(NORMAL_DEVIATION),
        });
        LimbTouch { limbs: felt.map(|receptor| receptor.limb), posture, ends }
    }

    /// A touch as a skin reports it: of exact points their places, with a variance of each coordinate, m², by the standard
    /// deviation that they were given with.
    pub fn of(
        skin: &Skin,
        touch: &'a Touch,
        input: Input,
        variance: impl Fn(Option<f64>) -> f64,
    ) -> LimbTouch<'a> {
        let mut felt = LimbTouch::of_receptors(skin, touch.ends.map(|end| end.receptor), &touch.posture);
        if input == Input::Contact {
            for (seen, end) in felt.ends.iter_mut().zip(&touch.ends) {
                seen.position = end.position(input, skin);
                let deviation = end.point.and_then(|point| point.deviation);
                seen.covariance = Matrix3::from_diagonal_element(variance(deviation));
            }
        }
        felt
    }

    /// The limbs, the earlier one first, and the touch ready for a solver.
    pub fn prepare(mut self, creature: &Creature) -> ([usize; 2], PreparedTouch) {
        if self.limbs[0] > self.limbs[1] {
            self.limbs.swap(0, 1);
            self.ends.swap(0, 1);
        }
        let chain = Chain::between(creature, self.limbs[0], self.limbs[1]);
        let sides = [0, 1].map(|k| ChainSide::new(creature, &chain.sides[k], self.posture));
        (self.limbs, PreparedTouch { sides, ends: self.ends })
    }
}

impl PreparedTouch {
    /// `p_CA − p_CB`: how far apart the schema puts what touched, in the common ancestor's frame, metres.
    pub fn miss(&self, schema: &BodySchema) -> Vector3<f64> {
        let [a, b] = &self.sides;
        a.frame(schema).point(&self.ends[0].position) - b.frame(schema).point(&self.ends[1].position)
    }

    /// Where a schema has the surfaces under the two receptors come closest, in the common ancestor's frame.
    pub fn gap(&self, skin: &Skin, schema: &BodySchema) -> Gap {
        SurfaceGap::new(skin, 1.0).gap(&self.ends, &self.frames(schema))
    }

    /// How far apart a schema leaves the surfaces, metres; infinitely if they are nearer than the `widest` tolerance that is asked for
    /// and meet out of the patches that felt them.
    pub fn felt_gap(&self, skin: &Skin, schema: &BodySchema, widest: f64) -> f64 {
        let (model, frames) = (SurfaceGap::new(skin, 1.0), self.frames(schema));
        let found = model.gap(&self.ends, &frames);
        let gap = found.distance.abs();
        let is_elsewhere = gap < widest && !model.is_felt(&self.ends, &frames, &found);
        if is_elsewhere { f64::INFINITY } else { gap }
    }

    /// The derivative of the gap by every hinge's angle, and by turns of every ball, with the degree of freedom, metres a radian.
    pub fn gap_slopes(&self, skin: &Skin, schema: &BodySchema) -> impl Iterator<Item = (usize, f64)> {
        let frames = self.frames(schema);
        let found = SurfaceGap::new(skin, 1.0).gap(&self.ends, &frames);
        let points = [0, 1].map(|k| frames[k].inverse_point(&found.middle()));
        let derivatives = self.angle_derivatives(schema, points.each_ref());
        derivatives.into_iter().map(move |(dof, derivative)| (dof, found.normal.dot(&derivative)))
    }
}

/// The columns of a pair's Jacobian: which parameters its chain moves.
struct ChainColumns {
    /// These parameters side by side.
    own: Parameters,
    /// Offset in the whole parameter vector of each block of them, and its width.
    blocks: Vec<(usize, usize)>,
}

/// The least-squares problem of a touch set: parameters in, normal equations out.
pub struct TouchProblem<'a, M: ObservationModel> {
    creature: &'a Creature,
    touches: &'a TouchSet,
    parameters: &'a Parameters,
    model: M,
    prior: Option<&'a Prior>,
    columns: Vec<ChainColumns>,
    /// Per touch, in the order of the set, what the last linearization fixed.
    fixed: Vec<M::Fixed>,
}

impl<'a, M: ObservationModel> TouchProblem<'a, M> {
    /// The problem of explaining `touches` by moving `parameters`.
    pub fn new(
        creature: &'a Creature,
        touches: &'a TouchSet,
        parameters: &'a Parameters,
        model: M,
    ) -> TouchProblem<'a, M> {
        let columns = touches.pairs.iter().map(|pair| {
            let (own, blocks) = parameters.of_joints(creature, pair.chain.joints());
            ChainColumns { own, blocks }
        });
        let columns = columns.collect();
        let fixed = vec![M::Fixed::default(); touches.len()];
        TouchProblem { creature, touches, parameters, model, prior: None, columns, fixed }
    }

    /// The schema of least cost near another one.
    pub fn fit(mut self, start: BodySchema, stopping: Stopping) -> BodySchema {
        levenberg_marquardt(&mut self, start, stopping).state
    }

    /// Adds what is believed besides the touches.
    pub fn with_prior(mut self, prior: &'a Prior) -> TouchProblem<'a, M> {
        self.prior = Some(prior);
        self
    }
}

impl<M: ObservationModel> LeastSquares for TouchProblem<'_, M> {
    type State = BodySchema;

    fn linearize(&mut self, schema: &BodySchema) -> Linearization {
        debug_assert!(schema.fits(self.creature));
        let mut total = Linearization::nothing(self.parameters.len());
        let bases: Vec<Matrix3x2<f64>> = match self.parameters.axis_model {
            AxisModel::Relaxed => Vec::new(),
            AxisModel::Unit => schema.axes.iter().map(tangent_basis).collect(),
        };
        let mut fixed = self.fixed.iter_mut();
        let mut sides = [SideJacobian::default(), SideJacobian::default()];
        for (pair, columns) in self.touches.pairs.iter().zip(&self.columns) {
            let most_rows = pair.touches.len() * TouchResiduals::MOST;
            // Transposed, so that a touch writes adjacent memory.
            let width = columns.own.len();
            let mut jacobian = DMatrix::zeros(width, most_rows);
            let mut residuals = DVector::zeros(most_rows);
            let mut row = 0;
            for touch in &pair.touches {
                let fixed = fixed.next().expect("one for each touch");
                touch.sides.iter().zip(&mut sides).for_each(|(side, found)| side.outwards(schema, found));
                let frames = sides.each_ref().map(|side| side.frame);
                let (found, cost) = self.model.linearize(&touch.ends, &frames, fixed);
                total.cost += cost;
                for (k, side) in sides.iter_mut().enumerate() {
                    touch.sides[k].inwards(schema, &found.points[k], side);
                    let sign = if k == 0 { 1.0 } else { -1.0 };
                    for (i, direction) in found.directions().iter().enumerate() {
                        let row = &mut jacobian.as_mut_slice()[(row + i) * width..][..width];
                        let write = |offset: usize, slopes: &[f64]| {
                            row[offset..offset + slopes.len()].copy_from_slice(slopes);
                        };
                        let direction = direction * sign;
                        columns.own.slopes(schema, side, &direction, |dof| bases[dof], write);
                    }
                }
                for (i, value) in found.values().iter().enumerate() {
                    residuals[row + i] = *value;
                }
                row += found.values().len();
            }
            if width > 0 {
                let used = jacobian.columns(0, row);
                let hessian = used * used.transpose();
                let gradient = used * residuals.rows(0, row);
                count_work(LOOK * pair.touches.len() + row * width.pow(2));
                columns.scatter(&hessian, &gradient, &mut total);
            }
        }
        total.scale = total.hessian.diagonal();
        count_work(total.gradient.len().pow(3) / 6);
        if let Some(prior) = self.prior {
            prior.add(self.parameters, schema, &mut total);
        }
        total
    }

    fn cost(&self, schema: &BodySchema) -> f64 {
        let touches = self.touches.touches();
        count_work(LOOK * self.touches.len());
        touches
            .zip(&self.fixed)
            .map(|(touch, fixed)| self.model.cost(&touch.ends, &touch.frames(schema), fixed))
            .sum::<f64>()
            + self.prior.map_or(0.0, |prior| prior.cost(self.parameters, schema))
    }

    fn step(&self, schema: &BodySchema, step: &DVector<f64>) -> BodySchema {
        self.parameters.step(schema, step)
    }
}

impl PreparedTouch {
    /// `∂(p_CA − p_CB)/∂q` of a place on either limb by what turns between them, as
    /// [`angle_derivatives`](ChainSide::angle_derivatives) of both sides have it, metres a radian.
    pub fn angle_derivatives(
        &self,
        schema: &BodySchema,
        places: [&Vector3<f64>; 2],
    ) -> Vec<(usize, Vector3<f64>)> {
        let mut derivatives = Vec::new();
        self.sides[0].angle_derivatives(schema, places[0], &mut derivatives);
        let of_first = derivatives.len();
        self.sides[1].angle_derivatives(schema, places[1], &mut derivatives);
        derivatives[of_first..].iter_mut().for_each(|(_, derivative)| *derivative = -*derivative);
        derivatives
    }

    /// How joints that are misread spread its two points: the sum of `∂p_C/∂q (∂p_C/∂q)ᵀ` over what turns between them, in the
    /// common ancestor's frame, m² a square radian.
    pub fn spread_by_angles(&self, schema: &BodySchema) -> Matrix3<f64> {
        let derivatives = self.angle_derivatives(schema, self.ends.each_ref().map(|end| &end.position));
        derivatives.iter().map(|(_, derivative)| derivative * derivative.transpose()).sum()
    }

    /// `X_CA` and `X_CB`.
    pub fn frames(&self, schema: &BodySchema) -> [Frame; 2] {
        [self.sides[0].frame(schema), self.sides[1].frame(schema)]
    }
}

impl ChainColumns {
    /// Adds a pair's normal equations to those of all parameters: of the Hessian the lower triangle.
    fn scatter(&self, hessian: &DMatrix<f64>, gradient: &DVector<f64>, total: &mut Linearization) {
        let places = || {
            self.blocks.iter().scan(0, |local, &(offset, width)| {
                *local += width;
                Some((*local - width, offset, width))
            })
        };
        let (height, total_height) = (hessian.nrows(), total.hessian.nrows());
        let (from, to) = (hessian.as_slice(), total.hessian.as_mut_slice());
        for (column, column_offset, column_width) in places() {
            for k in 0..column_width {
                total.gradient[column_offset + k] += gradient[column + k];
                let from = &from[(column + k) * height..][..height];
                let to = &mut to[(column_offset + k) * total_height..][..total_height];
                for (row, offset, width) in places().filter(|&(_, offset, _)| offset >= column_offset) {
                    to[offset..offset + width]
                        .iter_mut()
                        .zip(&from[row..])
                        .for_each(|(to, from)| *to += from);
                }
            }
        }
    }
}
