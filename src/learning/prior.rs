//! What is believed of a body before, or besides, its touches, and what a user knows of it already.
//!
//! A prior is a Gaussian about a schema, independent for every position and axis but for what touches from before determine of
//! several together. A weak one keeps joints that few touches involve within the size of a body; a calibrated one carries what
//! a user knows.

use nalgebra::{DMatrix, DVector, Matrix2, Vector2, Vector3};
use rand::Rng;
use rand_distr::{Distribution, StandardNormal};

use crate::agent::Agent;
use crate::creature::Creature;
use crate::geometry::tangent_basis;
use crate::learning::initial_guess::randomize_joint;
use crate::learning::least_squares::Linearization;
use crate::learning::{AxisModel, Parameters};
use crate::schema::BodySchema;

/// How far from a limb's skin the joints on it may be, in units of the skin's own extent. Wide: it keeps
/// joints that few touches involve from running away, and weighs nothing against touches.
const SPREAD: f64 = 0.7;
/// The least deviation that a prior can have, metres and radians: as sharp as the sharpest touch. Who knows
/// better knows exactly.
pub const LEAST_DEVIATION: f64 = 1e-6;

/// Gaussians about the positions and axes of a schema.
#[derive(Clone, Debug)]
pub struct Prior {
    /// The means.
    pub mean: BodySchema,
    /// Per joint, standard deviation of each coordinate of its position, metres; infinite where nothing is known.
    pub position_deviations: Vec<Vector3<f64>>,
    /// Standard deviation of each coordinate of an axis across its direction, radians; infinite where
    /// nothing is known.
    pub axis_deviations: Vec<f64>,
    /// What else is known, of parameters together: what touches from before determine.
    pub correlated: Option<CorrelatedPrior>,
}

impl Prior {
    /// Nothing but that joints are within `size` metres of the joints before them.
    pub fn size(creature: &Creature, size: f64) -> Prior {
        Prior {
            mean: BodySchema::zero(creature),
            position_deviations: vec![Vector3::repeat(size); creature.joints().len()],
            axis_deviations: vec![f64::INFINITY; creature.dof_elements()],
            correlated: None,
        }
    }

    /// That a joint is not far from the skin of the limb that it is on: within `spread` times as far from
    /// the middle of that skin as the skin itself is. On limbs without skin, as on the average limb.
    pub fn skin(agent: &Agent, spread: f64) -> Prior {
        let creature = agent.creature();
        let limbs = creature.limbs().len();
        let (mut middles, mut squares) = (vec![Vector3::zeros(); limbs], vec![0.0; limbs]);
        let mut counts = vec![0.0_f64; limbs];
        for receptor in &agent.skin().receptors {
            middles[receptor.limb] += receptor.position;
            squares[receptor.limb] += receptor.position.norm_squared();
            counts[receptor.limb] += 1.0;
        }
        let all = (squares.iter().sum::<f64>() / counts.iter().sum::<f64>().max(1.0)).sqrt().max(1e-3);
        let mut prior = Prior::size(creature, spread * all);
        for (j, joint) in creature.joints().iter().enumerate() {
            let count = counts[joint.parent];
            if count > 0.0 {
                prior.mean.positions[j] = middles[joint.parent] / count;
                // From the limb's own joint as well as from the middle of its skin: it may be bare near its end.
                let deviation = spread * (squares[joint.parent] / count).sqrt().max(0.3 * all);
                prior.position_deviations[j] = Vector3::repeat(deviation);
            }
        }
        prior
    }

    /// A joint as it may be before any touch: at random, but for axes that are known nearly, which are drawn
    /// from the prior.
    pub fn randomize_joint(
        &self,
        creature: &Creature,
        schema: &mut BodySchema,
        joint: usize,
        rng: &mut impl Rng,
    ) {
        randomize_joint(creature, schema, joint, rng);
        for dof in creature.joints()[joint].dof_indices() {
            let deviation = self.axis_deviations[dof];
            if deviation.is_finite() {
                let sideways = Vector2::from_fn(|_, _| {
                    let standard: f64 = StandardNormal.sample(rng);
                    deviation * standard
                });
                let mean = self.mean.axes[dof];
                schema.axes[dof] = (mean + tangent_basis(&mean) * sideways).normalize();
            }
        }
    }

    /// Adds the prior's information, the inverse of its covariance, to that of touches (lower triangle).
    pub fn add_information(&self, parameters: &Parameters, information: &mut DMatrix<f64>) {
        for Term { place, size, weight, .. } in self.terms(parameters, &self.mean) {
            (0..size).for_each(|i| information[(place + i, place + i)] += weight[i]);
        }
    }

    /// `½ Σ (difference / deviation)²` over free parameters, and `½ dᵀ Λ d` of what is known together.
    pub fn cost(&self, parameters: &Parameters, schema: &BodySchema) -> f64 {
        let independent: f64 = self.terms(parameters, schema).map(|term| term.cost()).sum();
        independent + self.correlated.as_ref().map_or(0.0, |known| known.cost(schema))
    }

    /// Adds it to normal equations, its cost included.
    pub fn add(&self, parameters: &Parameters, schema: &BodySchema, model: &mut Linearization) {
        let mut cost = 0.0;
        for term in self.terms(parameters, schema) {
            cost += term.cost();
            let Term { place, size, weight, slope, .. } = term;
            for i in 0..size {
                model.hessian[(place + i, place + i)] += weight[i];
                model.scale[place + i] += weight[i];
                model.gradient[place + i] += weight[i] * slope[i];
            }
        }
        if let Some(known) = &self.correlated {
            cost += known.add(parameters, schema, model);
        }
        model.cost += cost;
    }

    /// The positions and axes among parameters, and how far they are from the mean in a schema.
    fn terms(&self, parameters: &Parameters, schema: &BodySchema) -> impl Iterator<Item = Term> {
        let positions = parameters.positions.iter().enumerate().filter_map(|(joint, offset)| {
            let place = (*offset)?;
            let miss = schema.positions[joint] - self.mean.positions[joint];
            let weight = self.position_deviations[joint].map(|deviation| deviation.powi(-2));
            Some(Term { place, size: 3, miss, weight, slope: miss })
        });
        let axes = parameters.axes.iter().enumerate().filter_map(move |(dof, offset)| {
            let place = (*offset)?;
            let miss = schema.axes[dof] - self.mean.axes[dof];
            let slope = match parameters.axis_model {
                AxisModel::Relaxed => miss,
                AxisModel::Unit => (tangent_basis(&schema.axes[dof]).transpose() * miss).push(0.0),
            };
            let weight = Vector3::repeat(self.axis_deviations[dof].powi(-2));
            Some(Term { place, size: parameters.axis_size(), miss, weight, slope })
        });
        positions.chain(axes)
    }
}

/// A position or an axis under a prior.
struct Term {
    /// Where its parameters begin, and how many they are.
    place: usize,
    size: usize,
    /// How far it is from the mean, and the inverse variance of each coordinate.
    miss: Vector3<f64>,
    weight: Vector3<f64>,
    /// The same distance in its parameters.
    slope: Vector3<f64>,
}

impl Term {
    fn cost(&self) -> f64 {
        0.5 * self.weight.dot(&self.miss.component_mul(&self.miss))
    }
}

/// A Gaussian about a schema with a full information matrix over some of its parameters.
#[derive(Clone, Debug)]
pub struct CorrelatedPrior {
    /// The mean.
    pub mean: BodySchema,
    /// The parameters that it is about; axes are unit axes.
    pub parameters: Parameters,
    /// The inverse of the covariance, symmetric.
    pub information: DMatrix<f64>,
    /// The variance of each parameter.
    pub variances: DVector<f64>,
}

impl CorrelatedPrior {
    /// How far a schema is from the mean, in the parameters about the mean.
    pub fn difference(&self, schema: &BodySchema) -> DVector<f64> {
        let mut difference = DVector::zeros(self.parameters.len());
        for (joint, offset) in self.parameters.positions.iter().enumerate() {
            if let Some(offset) = *offset {
                let miss = schema.positions[joint] - self.mean.positions[joint];
                difference.fixed_rows_mut::<3>(offset).copy_from(&miss);
            }
        }
        for (axis, offset) in self.parameters.axes.iter().enumerate() {
            if let Some(offset) = *offset {
                let basis = tangent_basis(&self.mean.axes[axis]);
                let miss = basis.transpose() * (schema.axes[axis] - self.mean.axes[axis]);
                difference.fixed_rows_mut::<2>(offset).copy_from(&miss);
            }
        }
        difference
    }

    /// `½ dᵀ Λ d` of the difference from the mean.
    fn cost(&self, schema: &BodySchema) -> f64 {
        let difference = self.difference(schema);
        0.5 * difference.dot(&(&self.information * &difference))
    }

    /// Adds it to normal equations, but for its cost, which it returns.
    fn add(&self, parameters: &Parameters, schema: &BodySchema, model: &mut Linearization) -> f64 {
        let difference = self.difference(schema);
        let mut pull = &self.information * &difference;
        let cost = 0.5 * difference.dot(&pull);
        let mut information = self.information.clone();
        // The present basis of an axis may not be the one about the mean.
        for (axis, offset) in self.parameters.axes.iter().enumerate() {
            let Some(offset) = offset.filter(|_| parameters.axes[axis].is_some()) else { continue };
            let turn = between_bases(schema, &self.mean, axis);
            if (turn - Matrix2::identity()).norm_squared() > 1e-24 {
                let slope = turn.transpose() * pull.fixed_rows::<2>(offset);
                pull.fixed_rows_mut::<2>(offset).copy_from(&slope);
                let rows = turn.transpose() * information.fixed_rows::<2>(offset);
                information.fixed_rows_mut::<2>(offset).copy_from(&rows);
                let columns = information.fixed_columns::<2>(offset) * turn;
                information.fixed_columns_mut::<2>(offset).copy_from(&columns);
            }
        }
        // What is not among the parameters is held at its mean.
        let places = self.parameters.places_in(parameters);
        for &(from, to) in &places {
            model.gradient[to] += pull[from];
            model.scale[to] += 1.0 / self.variances[from];
            for &(other_from, other_to) in &places {
                model.hessian[(other_to, to)] += information[(other_from, from)];
            }
        }
        cost
    }
}

/// `∂(coordinates about the second schema) / ∂(coordinates about the first)` of an axis.
pub(super) fn between_bases(first: &BodySchema, second: &BodySchema, axis: usize) -> Matrix2<f64> {
    tangent_basis(&second.axes[axis]).transpose() * tangent_basis(&first.axes[axis])
}

/// What is known of one joint.
#[derive(Clone, Debug, PartialEq)]
pub struct KnownJoint {
    /// The joint, by its index.
    pub joint: usize,
    /// Whether its position and all its axes are known exactly: it is not learned at all.
    pub exact: bool,
    /// Its position `l_P` in the parent limb's frame and the standard deviation of each coordinate (infinite
    /// where nothing is known of it, of no account where exact), metres.
    pub position: Option<[Vector3<f64>; 2]>,
    /// Degrees of freedom by their index, the unit axis `a_P`, and its standard deviation in each of the two
    /// directions across it, radians.
    pub axes: Vec<(usize, Vector3<f64>, f64)>,
}

impl KnownJoint {
    /// The same of a body with all lengths so many times as long.
    pub fn scaled(&self, by: f64) -> KnownJoint {
        KnownJoint { position: self.position.map(|known| known.map(|of| by * of)), ..self.clone() }
    }
}

/// Joints that are known before the first touch: some exactly, some nearly, most not at all.
#[derive(Clone, Debug)]
pub struct PriorKnowledge {
    /// Positions and axes with their deviations, given or guessed from where the skin is.
    pub prior: Prior,
    /// The same without what is guessed: what counts as evidence beside the touches.
    pub given: Prior,
    /// Per joint, whether it keeps the prior's mean.
    pub frozen: Vec<bool>,
}

impl PriorKnowledge {
    /// Nothing but where the skin is.
    pub fn nothing(agent: &Agent) -> PriorKnowledge {
        PriorKnowledge {
            prior: Prior::skin(agent, SPREAD),
            given: Prior::size(agent.creature(), f64::INFINITY),
            frozen: vec![false; agent.creature().joints().len()],
        }
    }

    /// Adds what is known of joints.
    pub fn with(mut self, joints: &[KnownJoint]) -> PriorKnowledge {
        for known in joints {
            self.frozen[known.joint] = known.exact;
            for prior in [&mut self.prior, &mut self.given] {
                if let Some([mean, deviation]) = known.position {
                    for i in (0..3).filter(|&i| deviation[i].is_finite()) {
                        prior.mean.positions[known.joint][i] = mean[i];
                        prior.position_deviations[known.joint][i] = deviation[i].max(LEAST_DEVIATION);
                    }
                }
                for (dof, mean, deviation) in &known.axes {
                    prior.mean.axes[*dof] = *mean;
                    prior.axis_deviations[*dof] = deviation.max(LEAST_DEVIATION);
                }
            }
        }
        self
    }

    /// Whether anything was given.
    pub fn is_given(&self) -> bool {
        let finite = |deviation: f64| deviation.is_finite();
        self.frozen.contains(&true)
            || self.given.position_deviations.iter().flatten().any(|&deviation| finite(deviation))
            || self.given.axis_deviations.iter().any(|&deviation| finite(deviation))
    }
}
