//! Which numbers of a schema a solver may move, and where they stand in its vector.

use nalgebra::DVector;

use crate::creature::{Creature, DofKind};
use crate::kinematics::tangent_basis;
use crate::schema::BodySchema;

/// How an axis is parameterised.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum AxisModel {
    /// Free in R³, three parameters: the rotation becomes a polynomial and loses its local minima.
    Relaxed,
    /// On the unit sphere, two parameters: what an axis is.
    Unit,
}

/// The place of every free joint position and axis in a parameter vector.
#[derive(Clone, Debug)]
pub struct Parameters {
    /// Offset of `l_P` per joint; none where it is held.
    pub positions: Vec<Option<usize>>,
    /// Offset of `a_P` per degree of freedom; none where it is held.
    pub axes: Vec<Option<usize>>,
    /// How the axes are parameterised.
    pub axis_model: AxisModel,
    len: usize,
}

impl Parameters {
    /// Position and axes of each joint for which `free` holds.
    pub fn new(creature: &Creature, axis_model: AxisModel, free: impl Fn(usize) -> bool) -> Parameters {
        let mut parameters = Parameters {
            positions: vec![None; creature.joints().len()],
            axes: vec![None; creature.dof_elements()],
            axis_model,
            len: 0,
        };
        for (j, joint) in creature.joints().iter().enumerate() {
            if !free(j) {
                continue;
            }
            parameters.positions[j] = Some(parameters.len);
            parameters.len += 3;
            for (k, dof) in joint.dof_indices().zip(&joint.dofs) {
                if dof.kind != DofKind::Ball {
                    parameters.axes[k] = Some(parameters.len);
                    parameters.len += parameters.axis_size();
                }
            }
        }
        parameters
    }

    /// The position of one joint, and nothing else.
    pub fn position(creature: &Creature, joint: usize) -> Parameters {
        let mut parameters = Parameters::new(creature, AxisModel::Unit, |_| false);
        parameters.positions[joint] = Some(0);
        parameters.len = 3;
        parameters
    }

    /// Number of parameters.
    pub fn len(&self) -> usize {
        self.len
    }

    /// Whether nothing is free.
    pub fn is_empty(&self) -> bool {
        self.len == 0
    }

    /// Parameters per axis.
    pub fn axis_size(&self) -> usize {
        match self.axis_model {
            AxisModel::Relaxed => 3,
            AxisModel::Unit => 2,
        }
    }

    /// The schema after a step of the parameters; unit axes stay on the sphere.
    pub fn step(&self, schema: &BodySchema, step: &DVector<f64>) -> BodySchema {
        let mut moved = schema.clone();
        for (position, offset) in moved.positions.iter_mut().zip(&self.positions) {
            if let Some(offset) = *offset {
                *position += step.fixed_rows::<3>(offset);
            }
        }
        for (axis, offset) in moved.axes.iter_mut().zip(&self.axes) {
            let Some(offset) = *offset else { continue };
            match self.axis_model {
                AxisModel::Relaxed => *axis += step.fixed_rows::<3>(offset),
                AxisModel::Unit => {
                    let turned = *axis + tangent_basis(axis) * step.fixed_rows::<2>(offset);
                    *axis = turned.normalize();
                }
            }
        }
        moved
    }
}
