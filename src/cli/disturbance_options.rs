//! What is wrong with the agent's senses, as the command line says it.

use serde_json::{Value, json};

use crate::senses::Disturbances;

/// Options of disturbances, in the units that a person thinks in.
#[derive(clap::Args, Clone, Copy, Debug, Default, PartialEq)]
#[command(next_help_heading = "Disturbances, between the exact log and the learner")]
pub struct DisturbanceOptions {
    /// Standard deviation of every joint angle in every touch, degrees
    #[arg(long, value_name = "DEG", default_value_t = 0.0, value_parser = deviation)]
    joint_noise: f64,
    /// Standard deviation, per coordinate, of where the agent believes each receptor, millimetres
    #[arg(long, value_name = "MM", default_value_t = 0.0, value_parser = deviation)]
    receptor_noise: f64,
    /// Share of touches with a wrong receptor at one end, 0 to below 1
    #[arg(long, value_name = "FRACTION", default_value_t = 0.0, value_parser = share)]
    false_touches: f64,
    /// Standard deviation, per coordinate, of both points of contact in every touch, millimetres; only
    /// `--input contact` feels it
    #[arg(long, value_name = "MM", default_value_t = 0.0, value_parser = deviation)]
    point_noise: f64,
}

fn deviation(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(value) if value.is_finite() && value >= 0.0 => Ok(value),
        _ => Err("give a finite number that is not negative".into()),
    }
}

fn share(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(value) if (0.0..1.0).contains(&value) => Ok(value),
        _ => Err("give a number from 0 to below 1: 0.05 for one touch in twenty".into()),
    }
}

impl DisturbanceOptions {
    /// From degrees, millimetres and a share.
    pub fn new(joint_degrees: f64, receptor_millimetres: f64, false_touches: f64) -> DisturbanceOptions {
        let (joint_noise, receptor_noise) = (joint_degrees, receptor_millimetres);
        DisturbanceOptions { joint_noise, receptor_noise, false_touches, point_noise: 0.0 }
    }

    /// The same in radians and metres.
    pub fn disturbances(&self) -> Disturbances {
        Disturbances {
            joint_noise: self.joint_noise.to_radians(),
            receptor_noise: 1e-3 * self.receptor_noise,
            false_touches: self.false_touches,
            point_noise: 1e-3 * self.point_noise,
        }
    }

    /// As a JSON object, units in the keys.
    pub fn to_json(self) -> Value {
        json!({
            "joint_noise_deg": self.joint_noise,
            "receptor_noise_mm": self.receptor_noise,
            "false_touches": self.false_touches,
            "point_noise_mm": self.point_noise,
        })
    }
}

impl std::fmt::Display for DisturbanceOptions {
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
