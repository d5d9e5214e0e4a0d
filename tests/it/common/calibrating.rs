//! `bodyschema calibrate` in a folder of its own, and logs that are disturbed.

use std::fs;
use std::path::PathBuf;
use std::process::{Command, Output};

use bodyschema::calibration::robot::{Posed, Robot, Value};
use bodyschema::calibration::{End, Feature, Touch};
use bodyschema::session::simulated::normal;
use nalgebra::Vector3;
use rand::{Rng, RngExt};
use serde_json::Value as Json;
use tempfile::TempDir;

/// A folder to calibrate in.
pub struct Place(TempDir);

impl Place {
    /// An empty one.
    pub fn new() -> Place {
        Place(tempfile::tempdir().unwrap())
    }

    /// A file in it.
    pub fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    /// Writes a file.
    pub fn write(&self, name: &str, text: impl AsRef<[u8]>) {
        fs::write(self.path(name), text).unwrap();
    }

    /// Runs `bodyschema calibrate` there.
    pub fn run(&self, arguments: &[&str]) -> Output {
        let program = env!("CARGO_BIN_EXE_bodyschema");
        Command::new(program).current_dir(self.0.path()).arg("calibrate").args(arguments).output().unwrap()
    }

    /// What it prints as JSON.
    pub fn json(&self, arguments: &[&str]) -> Json {
        let output = self.run(&[arguments, &["--json"]].concat());
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        serde_json::from_slice(&output.stdout).unwrap()
    }

    /// It fails with a last line that has these words.
    pub fn fails(&self, arguments: &[&str], words: &[&str]) {
        let output = self.run(arguments);
        let told = String::from_utf8_lossy(&output.stderr);
        assert!(!output.status.success(), "{arguments:?}");
        let last = told.lines().last().unwrap_or_default();
        for word in words {
            assert!(last.contains(word), "{last} lacks {word}");
        }
    }
}

/// Adds a second contact to touches of points, as where a limb lies on another: a point a few centimetres from the first on one
/// side, and what is there on the other by the robot's `values`. Which contact of a side met which of the other is not told.
pub fn double(robot: &Robot, values: &[Value], touches: &mut [Touch], rng: &mut impl Rng) {
    const APART: f64 = 0.04;
    for touch in touches {
        let posed = Posed::new(robot, values, &touch.posture);
        let [Feature::Point(a, p), Feature::Point(b, _)] =
            [touch.ends[0][0].feature, touch.ends[1][0].feature]
        else {
            continue;
        };
        let aside = Vector3::from_fn(|_, _| APART * normal(rng));
        let [to_a, to_b] = posed.paths([a, b]);
        let there = posed.frame(&to_b).inverse_point(&posed.frame(&to_a).point(&(p + aside)));
        let deviation = None;
        touch.ends[0].push(End { feature: Feature::Point(a, p + aside), deviation });
        touch.ends[1].insert(0, End { feature: Feature::Point(b, there), deviation });
    }
}

/// Makes a share of touches false: one of their ends is that of another touch of the log.
pub fn falsify(touches: &mut [Touch], share: f64, rng: &mut impl Rng) {
    let honest = touches.to_vec();
    for touch in touches.iter_mut() {
        if rng.random_bool(share) {
            let other = &honest[rng.random_range(0..honest.len())];
            let side = rng.random_range(0..2);
            touch.ends[side].clone_from(&other.ends[side]);
            touch.ends[side].truncate(touch.ends[1 - side].len());
        }
    }
}
