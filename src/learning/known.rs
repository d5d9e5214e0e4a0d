//! What a user knows of a body already.

use nalgebra::Vector3;

use crate::agent::Agent;
use crate::learning::Prior;

/// How far from a limb's skin the joints on it may be, in units of the skin's own extent. Wide: it keeps
/// joints that few touches involve from running away, and weighs nothing against touches.
const SPREAD: f64 = 0.7;
/// The least deviation that a prior can have, metres and radians: as sharp as the sharpest touch. Who knows
/// better knows exactly.
pub const LEAST_DEVIATION: f64 = 1e-6;

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
    pub(super) fn scaled(&self, by: f64) -> KnownJoint {
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
