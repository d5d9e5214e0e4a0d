//! What is wrong with the agent's senses, in the units that a person thinks in.

use serde::{Deserialize, Serialize};

use crate::senses::Disturbances;

/// How much is wrong with an agent's senses, in degrees and millimetres; nothing by default.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "cli", derive(clap::Args))]
#[cfg_attr(
    feature = "cli",
    command(next_help_heading = "Disturbances, between the exact log and the learner")
)]
pub struct DisturbanceLevels {
    /// Standard deviation of every joint angle in every touch, degrees
    #[cfg_attr(feature = "cli", arg(long, value_name = "DEG", default_value_t = 0.0, value_parser = deviation))]
    #[serde(rename = "joint_noise_deg")]
    pub joint_noise: f64,
    /// Standard deviation, per coordinate, of where the agent believes each receptor, millimetres
    #[cfg_attr(feature = "cli", arg(long, value_name = "MM", default_value_t = 0.0, value_parser = deviation))]
    #[serde(rename = "receptor_noise_mm")]
    pub receptor_noise: f64,
    /// Share of touches with a wrong receptor at one end, 0 to below 1
    #[cfg_attr(feature = "cli", arg(long, value_name = "FRACTION", default_value_t = 0.0, value_parser = share))]
    pub false_touches: f64,
    /// Standard deviation, per coordinate, of both points of contact in every touch, millimetres; only `--input contact` feels it
    #[cfg_attr(feature = "cli", arg(long, value_name = "MM", default_value_t = 0.0, value_parser = deviation))]
    #[serde(rename = "point_noise_mm")]
    pub point_noise: f64,
}

impl DisturbanceLevels {
    /// The same in radians and metres.
    pub fn disturbances(&self) -> Disturbances {
        Disturbances {
            joint_noise: self.joint_noise.to_radians(),
            receptor_noise: 1e-3 * self.receptor_noise,
            false_touches: self.false_touches,
            point_noise: 1e-3 * self.point_noise,
        }
    }
}

impl std::fmt::Display for DisturbanceLevels {
    /// Those that are not zero in words, or "none".
    fn fmt(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
        // Shares in percent are seldom exact in binary.
        let percent = (1e10 * self.false_touches).round() / 1e8;
        let all = [
            (self.joint_noise, format!("joint noise {}°", self.joint_noise)),
            (self.receptor_noise, format!("receptor noise {} mm", self.receptor_noise)),
            (self.false_touches, format!("false touches {percent} %")),
            (self.point_noise, format!("point noise {} mm", self.point_noise)),
        ];
        let present: Vec<String> =
            all.into_iter().filter(|(amount, _)| *amount > 0.0).map(|(_, words)| words).collect();
        f.write_str(if present.is_empty() { "none".to_string() } else { present.join(", ") }.as_str())
    }
}

/// A deviation from the command line.
#[cfg(feature = "cli")]
fn deviation(text: &str) -> Result<f64, String> {
    let number = text.parse::<f64>().ok().filter(|value| value.is_finite() && *value >= 0.0);
    number.ok_or("give a finite number that is not negative".into())
}

/// A share from the command line.
#[cfg(feature = "cli")]
fn share(text: &str) -> Result<f64, String> {
    let number = text.parse::<f64>().ok().filter(|value| (0.0..1.0).contains(value));
    number.ok_or("give a number from 0 to below 1: 0.05 for one touch in twenty".into())
}
