//! What is believed of a body before, or besides, its touches.
//!
//! A prior is a Gaussian about a schema, independent for every position and axis. A weak one keeps joints
//! that few touches involve within the size of a body; a calibrated one carries what a user knows.

use nalgebra::{DMatrix, Vector2, Vector3};
use rand::Rng;
use rand_distr::{Distribution, StandardNormal};

use crate::agent::Agent;
use crate::creature::Creature;
use crate::geometry::tangent_basis;
use crate::learning::initial_guess::randomize_joint;
use crate::learning::least_squares::Linearization;
use crate::learning::{AxisModel, Parameters};
use crate::schema::BodySchema;

/// Independent Gaussians about the positions and axes of a schema.
#[derive(Clone, Debug)]
pub struct Prior {
    /// The means.
    pub mean: BodySchema,
    /// Per joint, standard deviation of each coordinate of its position, metres; infinite where nothing is known.
    pub position_deviations: Vec<Vector3<f64>>,
    /// Standard deviation of each coordinate of an axis across its direction, radians; infinite where
    /// nothing is known.
    pub axis_deviations: Vec<f64>,
}

impl Prior {
    /// Nothing but that joints are within `size` metres of the joints before them.
    pub fn size(creature: &Creature, size: f64) -> Prior {
        Prior {
            mean: BodySchema::zero(creature),
            position_deviations: vec![Vector3::repeat(size); creature.joints().len()],
            axis_deviations: vec![f64::INFINITY; creature.dof_elements()],
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
        for (offset, deviation) in parameters.positions.iter().zip(&self.position_deviations) {
            let Some(offset) = *offset else { continue };
            (0..3).for_each(|i| information[(offset + i, offset + i)] += deviation[i].powi(-2));
        }
        for (offset, deviation) in parameters.axes.iter().zip(&self.axis_deviations) {
            let Some(offset) = *offset else { continue };
            let size = parameters.axis_size();
            (offset..offset + size).for_each(|i| information[(i, i)] += deviation.powi(-2));
        }
    }

    fn position_misses<'a>(
        &'a self,
        schema: &'a BodySchema,
    ) -> impl Iterator<Item = (Vector3<f64>, Vector3<f64>)> + 'a {
        let misses = schema.positions.iter().zip(&self.mean.positions).map(|(now, mean)| now - mean);
        misses.zip(self.position_deviations.iter().map(|deviation| deviation.map(|d| d.powi(-2))))
    }

    fn axis_misses<'a>(&'a self, schema: &'a BodySchema) -> impl Iterator<Item = (Vector3<f64>, f64)> + 'a {
        let misses = schema.axes.iter().zip(&self.mean.axes).map(|(now, mean)| now - mean);
        misses.zip(self.axis_deviations.iter().map(|deviation| deviation.powi(-2)))
    }
}

/// What a least-squares problem knows besides its touches.
pub trait PriorTerm {
    /// Its cost at a schema, over free parameters.
    fn cost(&self, parameters: &Parameters, schema: &BodySchema) -> f64;
    /// Adds it to normal equations, its cost included.
    fn add(&self, parameters: &Parameters, schema: &BodySchema, model: &mut Linearization);
}

impl PriorTerm for Prior {
    /// `½ Σ (difference / deviation)²`.
    fn cost(&self, parameters: &Parameters, schema: &BodySchema) -> f64 {
        let free = |offset: &Option<usize>| offset.is_some();
        let misses = self.position_misses(schema).zip(&parameters.positions);
        let positions = misses
            .filter(|(_, offset)| free(offset))
            .map(|((miss, weight), _)| weight.dot(&miss.component_mul(&miss)));
        let misses = self.axis_misses(schema).zip(&parameters.axes);
        let axes =
            misses.filter(|(_, offset)| free(offset)).map(|((miss, weight), _)| weight * miss.norm_squared());
        0.5 * (positions.sum::<f64>() + axes.sum::<f64>())
    }

    fn add(&self, parameters: &Parameters, schema: &BodySchema, model: &mut Linearization) {
        model.cost += self.cost(parameters, schema);
        for ((miss, weight), offset) in self.position_misses(schema).zip(&parameters.positions) {
            let Some(offset) = *offset else { continue };
            for i in 0..3 {
                model.hessian[(offset + i, offset + i)] += weight[i];
                model.scale[offset + i] += weight[i];
                model.gradient[offset + i] += weight[i] * miss[i];
            }
        }
        for (k, ((miss, weight), offset)) in self.axis_misses(schema).zip(&parameters.axes).enumerate() {
            let Some(offset) = *offset else { continue };
            let slope: Vec<f64> = match parameters.axis_model {
                AxisModel::Relaxed => miss.iter().copied().collect(),
                AxisModel::Unit => {
                    (tangent_basis(&schema.axes[k]).transpose() * miss).iter().copied().collect()
                }
            };
            for (i, slope) in slope.into_iter().enumerate() {
                model.hessian[(offset + i, offset + i)] += weight;
                model.scale[offset + i] += weight;
                model.gradient[offset + i] += weight * slope;
            }
        }
    }
}
