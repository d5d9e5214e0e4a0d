//! The gap of a touch as noise sees it.

use nalgebra::{DMatrix, Matrix3, Vector3};

use crate::agent::Agent;
use crate::kinematics::ChainSide;
use crate::learning::observation::Observation;
use crate::learning::prediction::row_variance;
use crate::learning::touch_set::{PreparedTouch, TouchSet};
use crate::schema::BodySchema;

/// How far joints are taken to be misread where the axes are chosen along which points are compared, radians.
const MISREAD: f64 = 0.01;

/// The gap of one touch at a schema, or that of its two points along one of three axes, and what it depends on.
#[derive(Clone, Debug)]
pub struct NoisyGap {
    /// The gap, metres.
    pub gap: f64,
    /// The variance that it was told to have, m²; 0 where nothing is told.
    pub(super) told: f64,
    /// Its derivative by the parameters: pairs of a parameter's place and the derivative by it.
    pub(super) entries: Vec<(usize, f64)>,
    /// `|∂g/∂q|²`, m² a square radian.
    pub(super) slope: f64,
    /// The two receptors.
    pub(super) receptors: [usize; 2],
    /// Where the surfaces are closest, in both limbs' frames, metres.
    pub(super) places: [Vector3<f64>; 2],
    /// Its derivative by shifts of the skin under them, each in its limb's frame.
    pub(super) normals: [Vector3<f64>; 2],
    /// How far apart the two limbs may be where the touch is false, metres.
    pub(super) width: f64,
}

/// What of touches is compared.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Compared {
    /// The gap between two surfaces.
    Surfaces,
    /// How far apart two points are, along three axes.
    Points,
}

impl Compared {
    /// How many gaps a touch has.
    pub fn gaps_a_touch(self) -> usize {
        match self {
            Compared::Surfaces => 1,
            Compared::Points => 3,
        }
    }
}

/// How far apart the limbs of each pair may be where a touch is false, metres: as far as limbs are large, or farther.
pub(super) fn widths(agent: &Agent, touches: &TouchSet) -> Vec<f64> {
    let mut sizes = vec![0.0; agent.creature().limbs().len()];
    for receptor in &agent.skin().receptors {
        let size: &mut f64 = &mut sizes[receptor.limb];
        *size = size.max(receptor.position.norm());
    }
    touches.pairs.iter().map(|pair| pair.limbs.iter().map(|&limb| sizes[limb]).sum()).collect()
}

/// Axes in the common ancestor's frame along which misread joints move the two points of a touch independently of one another, and
/// the variance that the points were told to have along each, m².
pub(super) fn axes_of_misses(schema: &BodySchema, touch: &PreparedTouch) -> (Matrix3<f64>, [f64; 3]) {
    let in_common = |(side, end): (&ChainSide, &Observation)| {
        let rotation = side.frame(schema).rotation;
        rotation * end.covariance * rotation.transpose()
    };
    let told: Matrix3<f64> = touch.sides.iter().zip(&touch.ends).map(in_common).sum();
    let misread = touch.spread_by_angles(schema) * MISREAD.powi(2);
    let axes = (told + misread).symmetric_eigen().eigenvectors;
    (axes, [0, 1, 2].map(|k| axes.column(k).dot(&(told * axes.column(k)))))
}

/// How far the skin under a receptor is shifted, in its limb's frame, metres: not at all where nothing is told of it.
pub(super) fn shift_under(shifts: &[Vector3<f64>], receptor: usize) -> Vector3<f64> {
    shifts.get(receptor).copied().unwrap_or_default()
}

impl NoisyGap {
    /// Its derivatives by the shifts of either receptor's skin.
    pub(super) fn shifts(&self) -> impl Iterator<Item = (usize, Vector3<f64>)> {
        self.receptors.into_iter().zip(self.normals)
    }

    /// `j Σ jᵀ` for a covariance of all parameters, m².
    pub fn predicted(&self, covariance: &DMatrix<f64>) -> f64 {
        row_variance(&self.entries, covariance)
    }
}
