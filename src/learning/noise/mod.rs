//! The noise of touches as it is: how much of it there is of each kind, estimated from the gaps that a schema leaves.
//!
//! A gap between two surfaces that touched, or between two points that were one, is not zero where joints are misread, anew
//! in every touch; where a receptor and the skin under it are not where the agent believes them, the same in all touches of
//! that receptor; and where a touch is false and says nothing at all. With the gap's derivatives by the parameters (`j`), by the joint angles
//! (`∂g/∂q`) and by shifts of the skin under its two receptors (`n`), to first order
//!
//! ```text
//! g = j δ + Σ n d + e      d ~ N(0, σ_r²), three coordinates a receptor
//!                          e ~ N(0, σ₀² + σ_q² |∂g/∂q|²)   with probability 1 − ε, else anywhere
//! ```
//!
//! That is a linear mixed model. The deviations are those of greatest restricted likelihood, found by fixed-point steps on
//! its derivatives (Harville, "Maximum Likelihood Approaches to Variance Component Estimation", 1977; the steps of Zhou,
//! Hu, Zhou and Lange, "MM Algorithms for Variance Components Models", 2019); the share `ε` and who is honest by
//! expectation and maximisation (Dempster, Laird and Rubin 1977). What touches determine in such noise is the information
//! that is left when the shifts `d` are eliminated from the normal equations of `δ` and `d` together (Schur's complement).

mod adjusted;
mod estimate;
mod gap;
mod problem;

pub use adjusted::{Adjusted, gaps_of};
pub use estimate::{Noise, information, likeness};
pub use gap::{Compared, NoisyGap};
pub use problem::NoisyProblem;
