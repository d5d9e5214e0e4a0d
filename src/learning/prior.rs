//! What is believed of a body before, or besides, its touches.
//!
//! A prior is a Gaussian about a schema, independent for every position and axis. A weak one keeps joints
//! that few touches involve within the size of a body; a calibrated one carries what a user knows.

use nalgebra::Vector3;

use crate::creature::Creature;
use crate::kinematics::tangent_basis;
use crate::learning::least_squares::Linearization;
use crate::learning::{AxisModel, Parameters};
use crate::schema::BodySchema;
use crate::skin::Skin;

/// Independent Gaussians about the positions and axes of a schema.
#[derive(Clone, Debug)]
pub struct Prior {
    /// The means.
    pub mean: BodySchema,
    /// Standard deviation of each coordinate of a joint's position, metres; infinite where nothing is known.
    pub position_deviations: Vec<f64>,
    /// Standard deviation of each coordinate of an axis across its direction, radians; infinite where
    /// nothing is known.
    pub axis_deviations: Vec<f64>,
}

impl Prior {
    /// Nothing but that joints are within `size` metres of the joints before them.
    pub fn size(creature: &Creature, size: f64) -> Prior {
        Prior {
            mean: BodySchema::zero(creature),
            position_deviations: vec![size; creature.joints().len()],
            axis_deviations: vec![f64::INFINITY; creature.dof_elements()],
        }
    }

    /// That a joint is not far from the skin of the limb that it is on: within `spread` times as far from
    /// the middle of that skin as the skin itself is. On limbs without skin, as on the average limb.
    pub fn skin(creature: &Creature, skin: &Skin, spread: f64) -> Prior {
        let limbs = creature.limbs().len();
        let (mut middles, mut squares) = (vec![Vector3::zeros(); limbs], vec![0.0; limbs]);
        let mut counts = vec![0.0_f64; limbs];
        for receptor in &skin.receptors {
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
                prior.position_deviations[j] = spread * (squares[joint.parent] / count).sqrt().max(0.3 * all);
            }
        }
        prior
    }

    fn position_misses<'a>(
        &'a self,
        schema: &'a BodySchema,
    ) -> impl Iterator<Item = (Vector3<f64>, f64)> + 'a {
        let misses = schema.positions.iter().zip(&self.mean.positions).map(|(now, mean)| now - mean);
        misses.zip(self.position_deviations.iter().map(|deviation| deviation.powi(-2)))
    }

    fn axis_misses<'a>(&'a self, schema: &'a BodySchema) -> impl Iterator<Item = (Vector3<f64>, f64)> + 'a {
        let misses = schema.axes.iter().zip(&self.mean.axes).map(|(now, mean)| now - mean);
        misses.zip(self.axis_deviations.iter().map(|deviation| deviation.powi(-2)))
    }
}

/// What a least-squares problem knows besides its touches.
pub trait Beforehand {
    /// Its cost at a schema, over free parameters.
    fn cost(&self, parameters: &Parameters, schema: &BodySchema) -> f64;
    /// Adds it to normal equations, its cost included.
    fn add(&self, parameters: &Parameters, schema: &BodySchema, model: &mut Linearization);
}

impl Beforehand for Prior {
    /// `½ Σ (difference / deviation)²`.
    fn cost(&self, parameters: &Parameters, schema: &BodySchema) -> f64 {
        let free = |offset: &Option<usize>| offset.is_some();
        let misses = self.position_misses(schema).zip(&parameters.positions);
        let positions =
            misses.filter(|(_, offset)| free(offset)).map(|((miss, weight), _)| weight * miss.norm_squared());
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
                model.hessian[(offset + i, offset + i)] += weight;
                model.gradient[offset + i] += weight * miss[i];
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
                model.gradient[offset + i] += weight * slope;
            }
        }
    }
}
