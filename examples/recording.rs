//! A recording of a real body, here an elbow, with no model at all: `cargo run --release --example recording`.

use std::error::Error;
use std::f64::consts::FRAC_PI_2;
use std::fs;

use bodyschema::{BabbledSession, LearningOptions, learn_session};

const ARM: &str = r#"{"name": "arm", "limbs": ["base", "forearm"], "joints": [{"name": "elbow", "parent": "base",
  "dofs": [{"name": "elbow_pitch", "kind": "hinge", "range": [-1.5, 1.5]}]}]}"#;

fn main() -> Result<(), Box<dyn Error>> {
    let folder = std::env::temp_dir().join(format!("bodyschema-recording-{}", std::process::id()));
    fs::create_dir_all(&folder)?;
    let (creature, log) = (folder.join("arm.json"), folder.join("touches.csv"));
    fs::write(&creature, ARM)?;
    fs::write(&log, touches())?;

    let options = LearningOptions::default();
    let recorded = BabbledSession::of_recording((&creature, &log), usize::MAX, None, &options, vec![], &())?;
    let options = options.for_session(&recorded.session)?;
    recorded.write(&folder)?;
    let learned = learn_session(&folder, &recorded, &options, None, &[], &())?;
    println!("{}", learned.record.verdict);
    println!("elbow: {:.4?} m", learned.learned.schema.positions[0].as_slice());
    println!("axis: {:.4?}", learned.learned.schema.axes[0].as_slice());
    Ok(fs::remove_dir_all(&folder)?)
}

/// Points of a forearm that turns about y at x = 0.1 m, and where they touch the base.
fn touches() -> String {
    let mut lines = "limb_a,limb_b,ax,ay,az,bx,by,bz,elbow_pitch\n".to_string();
    for k in 0..60 {
        let share = f64::from(k) / 60.0;
        let angle = FRAC_PI_2 * (share - 0.5);
        let [x, y, z] = [0.2, 0.05 * (7.0 * share).sin(), 0.03 * (11.0 * share).cos()];
        let (sin, cos) = angle.sin_cos();
        let base = [0.1 + cos * x + sin * z, y, cos * z - sin * x];
        lines += &format!("base,forearm,{},{},{},{x},{y},{z},{angle}\n", base[0], base[1], base[2]);
    }
    lines
}
