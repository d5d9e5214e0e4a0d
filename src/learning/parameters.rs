//! Which numbers of a schema a solver may move, and where they stand in its vector.

use nalgebra::{DVector, Matrix3, Matrix3x2, Rotation3, Vector3};

use crate::creature::{Creature, DofKind};
use crate::geometry::tangent_basis;
use crate::kinematics::SideJacobian;
use crate::schema::BodySchema;

/// How axes, and rotations of limbs' poses, are parameterised.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum AxisModel {
    /// Free in R³, three parameters: the rotation becomes a polynomial and loses its local minima.
    ///
    /// A limb's rotation becomes any matrix, nine parameters: what it does to a point is then linear in them.
    Relaxed,
    /// On the unit sphere, two parameters: what an axis is. A limb's rotation turns by a vector of three.
    Unit,
}

/// The place of every free joint position, axis and limb's pose in a parameter vector.
#[derive(Clone, Debug)]
pub struct Parameters {
    /// Offset of `l_P` per joint; none where it is held.
    pub positions: Vec<Option<usize>>,
    /// Offset of `a_P` per degree of freedom; none where it is held.
    pub axes: Vec<Option<usize>>,
    /// Offset of a limb's origin `c` per joint; none where it is held.
    pub limb_origins: Vec<Option<usize>>,
    /// Offset of a limb's rotation `Q` per joint; none where it is held.
    pub limb_rotations: Vec<Option<usize>>,
    /// How the axes are parameterised.
    pub axis_model: AxisModel,
    len: usize,
}

impl Parameters {
    /// Nothing to move.
    pub fn none() -> Parameters {
        Parameters {
            positions: Vec::new(),
            axes: Vec::new(),
            limb_origins: Vec::new(),
            limb_rotations: Vec::new(),
            axis_model: AxisModel::Unit,
            len: 0,
        }
    }

    /// Position and axes of each joint for which `free` holds.
    pub fn new(creature: &Creature, axis_model: AxisModel, free: impl Fn(usize) -> bool) -> Parameters {
        Parameters::of(creature, axis_model, &free, |joint, _| free(joint))
    }

    /// The position of each joint, and each axis by its joint and degree of freedom, for which these hold.
    pub fn of(
        creature: &Creature,
        axis_model: AxisModel,
        position: impl Fn(usize) -> bool,
        axis: impl Fn(usize, usize) -> bool,
    ) -> Parameters {
        let mut parameters = Parameters {
            positions: vec![None; creature.joints().len()],
            axes: vec![None; creature.dof_elements()],
            limb_origins: vec![None; creature.joints().len()],
            limb_rotations: vec![None; creature.joints().len()],
            axis_model,
            len: 0,
        };
        for (j, joint) in creature.joints().iter().enumerate() {
            if position(j) {
                parameters.positions[j] = Some(parameters.len);
                parameters.len += 3;
            }
            for (k, dof) in joint.dof_indices().zip(&joint.dofs) {
                if dof.kind != DofKind::Ball && axis(j, k) {
                    parameters.axes[k] = Some(parameters.len);
                    parameters.len += parameters.axis_size();
                }
            }
        }
        parameters
    }

    /// Frees the pose of each joint's limb for which `free` holds, but for the rotation of the one on joint
    /// `held`.
    pub fn with_limb_poses(mut self, free: impl Fn(usize) -> bool, held: Option<usize>) -> Parameters {
        for joint in (0..self.positions.len()).filter(|&joint| free(joint)) {
            self.limb_origins[joint] = Some(self.len);
            self.len += 3;
            if held != Some(joint) {
                self.limb_rotations[joint] = Some(self.len);
                self.len += self.rotation_size();
            }
        }
        self
    }

    /// The position of each joint for which `free` holds, and no axes.
    pub fn positions(creature: &Creature, axis_model: AxisModel, free: impl Fn(usize) -> bool) -> Parameters {
        Parameters::of(creature, axis_model, free, |_, _| false)
    }

    /// The position of one joint, and nothing else.
    pub fn position(creature: &Creature, joint: usize) -> Parameters {
        Parameters::positions(creature, AxisModel::Unit, |other| other == joint)
    }

    /// Where each of its positions and unit axes is among others, of those that are there: pairs of places.
    pub fn places_in(&self, others: &Parameters) -> Vec<(usize, usize)> {
        let positions = self.positions.iter().zip(&others.positions).map(|(a, b)| (a, b, 3));
        let axes = self.axes.iter().zip(&others.axes).map(|(a, b)| (a, b, 2));
        let mut places: Vec<(usize, usize)> = positions
            .chain(axes)
            .filter_map(|(a, b, width)| Some((*a.as_ref()?, *b.as_ref()?, width)))
            .flat_map(|(a, b, width)| (0..width).map(move |i| (a + i, b + i)))
            .collect();
        places.sort_unstable();
        places
    }

    /// What is free of some joints, side by side, and where each block of it is among all: its offset and its width.
    pub fn of_joints(
        &self,
        creature: &Creature,
        joints: impl Iterator<Item = usize>,
    ) -> (Parameters, Vec<(usize, usize)>) {
        let mut own = Parameters::of(creature, self.axis_model, |_| false, |_, _| false);
        let (mut blocks, mut len) = (Vec::new(), 0);
        let mut take = |offset: Option<usize>, width: usize| {
            blocks.push((offset?, width));
            len += width;
            Some(len - width)
        };
        for joint in joints {
            own.positions[joint] = take(self.positions[joint], 3);
            for dof in creature.joints()[joint].dof_indices() {
                own.axes[dof] = take(self.axes[dof], self.axis_size());
            }
            own.limb_origins[joint] = take(self.limb_origins[joint], 3);
            own.limb_rotations[joint] = take(self.limb_rotations[joint], self.rotation_size());
        }
        (Parameters { len, ..own }, blocks)
    }

    /// Whether nothing of a joint is free.
    pub fn holds(&self, creature: &Creature, joint: usize) -> bool {
        let of_joint =
            [&self.positions, &self.limb_origins, &self.limb_rotations].map(|places| places[joint]);
        let axes = creature.joints()[joint].dof_indices().map(|dof| self.axes[dof]);
        of_joint.into_iter().chain(axes).all(|place| place.is_none())
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

    /// Parameters per rotation of a limb's pose.
    pub fn rotation_size(&self) -> usize {
        match self.axis_model {
            AxisModel::Relaxed => 9,
            AxisModel::Unit => 3,
        }
    }

    /// The schema after a step of the parameters; unit axes stay on the sphere, and rotations rotations.
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
        let places = self.limb_origins.iter().zip(&self.limb_rotations);
        for (pose, (origin, rotation)) in moved.limb_poses.iter_mut().zip(places) {
            if let Some(offset) = *origin {
                pose.origin += step.fixed_rows::<3>(offset);
            }
            let Some(offset) = *rotation else { continue };
            match self.axis_model {
                AxisModel::Relaxed => {
                    pose.rotation += Matrix3::from_column_slice(step.fixed_rows::<9>(offset).as_slice());
                }
                AxisModel::Unit => {
                    let turn = Rotation3::new(step.fixed_rows::<3>(offset).into_owned());
                    pose.rotation = turn.matrix() * pose.rotation;
                }
            }
        }
        moved
    }

    /// The derivative of `direction · p_C` by every free number of one side of a chain: each block's offset and its slopes, once a
    /// block. `basis` is that of the tangent plane of a degree of freedom's unit axis.
    pub fn slopes(
        &self,
        schema: &BodySchema,
        side: &SideJacobian,
        direction: &Vector3<f64>,
        basis: impl Fn(usize) -> Matrix3x2<f64>,
        mut block: impl FnMut(usize, &[f64]),
    ) {
        for (joint, map) in &side.joints {
            if let Some(offset) = self.positions[*joint] {
                block(offset, map.tr_mul(direction).as_slice());
            }
        }
        for (dof, derivative) in &side.dofs {
            let Some(offset) = self.axes[*dof] else { continue };
            let free = derivative.tr_mul(direction);
            match self.axis_model {
                AxisModel::Relaxed => block(offset, free.as_slice()),
                AxisModel::Unit => block(offset, basis(*dof).tr_mul(&free).as_slice()),
            }
        }
        for pose in &side.poses {
            let along = pose.map.tr_mul(direction);
            if let Some(offset) = self.limb_origins[pose.joint] {
                block(offset, along.as_slice());
            }
            let Some(offset) = self.limb_rotations[pose.joint] else { continue };
            match self.axis_model {
                AxisModel::Relaxed => block(offset, (along * pose.point.transpose()).as_slice()),
                AxisModel::Unit => {
                    // d(Q p) = ω × Q p.
                    let turned = schema.limb_poses[pose.joint].rotation * pose.point;
                    block(offset, turned.cross(&along).as_slice());
                }
            }
        }
    }
}
