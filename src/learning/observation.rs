//! What a touch says: from two felt places to residuals.

use nalgebra::{Matrix3, Vector3};
use serde::{Deserialize, Serialize};

use crate::geometry::Frame;
use crate::named::named;

named! {
    "knowledge of the skin",
    /// What the agent knows of its skin.
    #[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
    #[serde(rename_all = "snake_case")]
    #[cfg_attr(feature = "cli", derive(clap::ValueEnum))]
    pub enum SkinKnowledge {
        /// The surfaces under the receptors, each in its limb's own frame.
        #[default]
        Surface = "surface",
        /// The receptors' centres and extents alone.
        Centres = "centres",
    }
}

named! {
    "frames",
    /// Which frames points on limbs are given in.
    #[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
    #[serde(rename_all = "snake_case")]
    #[cfg_attr(feature = "cli", derive(clap::ValueEnum))]
    pub enum LimbFrames {
        /// Those of the joints that carry the limbs: with their origins there and, in the reference posture,
        /// parallel to their parents'.
        #[default]
        Joint = "joint",
        /// A frame of its own for every limb, fixed to it: its unknown pose on the joint is learned.
        Limb = "limb",
    }
}

/// What one end of a touch reports.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Observation {
    /// `p_LR`, where on the limb, in the limb's frame, metres: the receptor's centre or the exact point.
    pub position: Vector3<f64>,
    /// How far from there the contact may have been: a covariance in the limb's frame, m².
    pub covariance: Matrix3<f64>,
    /// The receptor that reports it, an index into the skin.
    pub receptor: usize,
}

/// The residuals of one touch, whitened, and how they change.
///
/// Every residual moves with the miss of one pair of points: its derivative is
/// `direction · (∂p_CA − ∂p_CB)`, with `points` the material points on the two limbs.
#[derive(Clone, Copy, Debug)]
pub struct TouchResiduals {
    /// The points in their limbs' frames, metres.
    pub points: [Vector3<f64>; 2],
    directions: [Vector3<f64>; TouchResiduals::MOST],
    values: [f64; TouchResiduals::MOST],
    count: usize,
}

impl TouchResiduals {
    /// The most residuals that one touch can have.
    pub const MOST: usize = 5;

    /// No residuals yet, for a pair of points.
    pub fn new(points: [Vector3<f64>; 2]) -> TouchResiduals {
        let directions = [Vector3::zeros(); TouchResiduals::MOST];
        TouchResiduals { points, directions, values: [0.0; TouchResiduals::MOST], count: 0 }
    }

    /// Adds a residual.
    pub fn push(&mut self, direction: Vector3<f64>, value: f64) {
        self.directions[self.count] = direction;
        self.values[self.count] = value;
        self.count += 1;
    }

    /// The derivative's direction per residual, in the ancestor's frame.
    pub fn directions(&self) -> &[Vector3<f64>] {
        &self.directions[..self.count]
    }

    /// The residuals.
    pub fn values(&self) -> &[f64] {
        &self.values[..self.count]
    }
}

/// How the two ends of a touch become residuals.
pub trait ObservationModel {
    /// What a linearization fixes of a touch, for the costs until the next one.
    type Fixed: Clone + Default;

    /// The whitened residuals at frames `X_CA` and `X_CB`, the touch's share of the cost, and what is fixed there; `fixed` is
    /// that of the linearization before.
    fn linearize(
        &self,
        ends: &[Observation; 2],
        frames: &[Frame; 2],
        fixed: &mut Self::Fixed,
    ) -> (TouchResiduals, f64);
    /// The touch's share of the cost.
    fn cost(&self, ends: &[Observation; 2], frames: &[Frame; 2], fixed: &Self::Fixed) -> f64;
}

/// The two places are one point: the miss `p_CA − p_CB` is noise.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum PointsMeet {
    /// Noise of the two ends' covariances, turned with their limbs: right near the answer.
    Shaped,
    /// Noise alike in all directions. From afar the limbs' orientations are wrong and so is any shape they
    /// turn: this finds the answer from several times as many random initial guesses.
    Anyhow,
    /// The same, distributed as Cauchy has it, so many deviations wide: what is farther apart may be no touch at all.
    Mostly(f64),
}

impl PointsMeet {
    fn miss(ends: &[Observation; 2], frames: &[Frame; 2]) -> Vector3<f64> {
        frames[0].point(&ends[0].position) - frames[1].point(&ends[1].position)
    }
}

impl PointsMeet {
    /// The whitening of a touch at its present frames `X_CA` and `X_CB`.
    pub fn whitening(&self, ends: &[Observation; 2], frames: &[Frame; 2]) -> Matrix3<f64> {
        // The mean over all directions of how far apart the two places may be.
        let variance = (ends[0].covariance + ends[1].covariance).trace() / 3.0;
        match *self {
            PointsMeet::Shaped => {}
            PointsMeet::Anyhow => return Matrix3::identity() / variance.sqrt(),
            PointsMeet::Mostly(width) => {
                let squared = PointsMeet::miss(ends, frames).norm_squared();
                return Matrix3::identity() / (variance + squared / width.powi(2)).sqrt();
            }
        }
        let turned = |k: usize| frames[k].rotation * ends[k].covariance * frames[k].rotation.transpose();
        let covariance = turned(0) + turned(1);
        // Rotations far from the answer may make it nearly singular.
        let covariance = covariance + Matrix3::identity() * (1e-3 * variance);
        covariance
            .cholesky()
            .and_then(|factor| factor.l().try_inverse())
            .filter(|whitening| whitening.iter().all(|x| x.is_finite()))
            .unwrap_or_else(|| Matrix3::identity() / variance.sqrt())
    }

    /// The sum of the squares of a touch's three whitened residuals at frames `X_CA` and `X_CB`.
    pub fn squared_misfit(&self, ends: &[Observation; 2], frames: &[Frame; 2]) -> f64 {
        2.0 * self.cost(ends, frames, &self.whitening(ends, frames))
    }
}

impl ObservationModel for PointsMeet {
    /// The whitening.
    type Fixed = Matrix3<f64>;

    fn linearize(
        &self,
        ends: &[Observation; 2],
        frames: &[Frame; 2],
        whitening: &mut Matrix3<f64>,
    ) -> (TouchResiduals, f64) {
        *whitening = self.whitening(ends, frames);
        let values = *whitening * PointsMeet::miss(ends, frames);
        let mut residuals = TouchResiduals::new([ends[0].position, ends[1].position]);
        for (row, value) in values.iter().enumerate() {
            residuals.push(whitening.row(row).transpose(), *value);
        }
        (residuals, 0.5 * values.norm_squared())
    }

    fn cost(&self, ends: &[Observation; 2], frames: &[Frame; 2], whitening: &Matrix3<f64>) -> f64 {
        0.5 * (whitening * PointsMeet::miss(ends, frames)).norm_squared()
    }
}
