//! Touches made with one MuJoCo held against those made with another. Two engines cannot be in one program, so the
//! program that was built with the one writes its touches down, and that of the other compares: `.ci/engine`.

use std::collections::BTreeMap;
use std::fs;
use std::path::PathBuf;
use std::sync::Arc;

use bodyschema::agent::Agent;
use bodyschema::babbling::{Babbler, BabblingOptions, BoutsDone, Made, PolicyName};
use bodyschema::creature::{Body, JointSelection};
use bodyschema::mujoco::{GeomKind, Model};
use bodyschema::simulation::{MotionName, Movers};
use bodyschema::skin::{GrowOptions, grow};
use serde::{Deserialize, Serialize};

use crate::common::repository;

/// Those whose touches are compared; all their joints move.
const CREATURES: [&str; 7] = ["contraption", "fourarms", "hexapod", "max", "octopus", "sauropod", "snake"];
/// Touches per creature.
const TOUCHES: usize = 500;
/// How exactly engines agree, metres and radians.
const AGREEMENT: f64 = 1e-9;
/// Touches nearer than this are the same to what follows them in a bout, metres or radians.
const SAME_START: f64 = 1e-11;
/// Shapes whose contacts all engines find by the same formulas: they agree always.
const ALIKE: [&str; 2] = ["capsule", "sphere"];
/// How far apart engines may be, metres and radians, where other shapes meet, whose contacts they seek step by step or
/// by formulas that have changed. Measured between 2.2.2 and 4.0.0: up to 1.6e-5.
const NEARLY: f64 = 1e-4;

/// A touch as it is written down.
#[derive(Serialize, Deserialize)]
struct Written {
    bout: u64,
    motion: u64,
    posture: Vec<f64>,
    /// The shapes that met, the lesser name first.
    shapes: [String; 2],
    /// The points of contact in their limbs' frames, metres.
    contacts: [[f64; 3]; 2],
    limbs: [usize; 2],
}

/// The touches of an engine.
#[derive(Serialize, Deserialize)]
struct OfEngine {
    version: String,
    touches: BTreeMap<String, Vec<Written>>,
}

/// Where the touches are written down: the same place whatever the engine.
fn place() -> PathBuf {
    PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join("touches-of-an-engine.json")
}

/// The touches that this engine makes.
fn made_here() -> OfEngine {
    let version = bodyschema::mujoco::check().unwrap().to_string();
    OfEngine { version, touches: CREATURES.map(|name| (name.to_string(), touches(name))).into() }
}

fn touches(creature: &str) -> Vec<Written> {
    let model = Model::from_path(repository(&format!("mjcf/{creature}/{creature}.xml"))).unwrap();
    let body = Body::new(Arc::new(model), &JointSelection::All).unwrap();
    let agent = Agent::new(body.creature.clone(), grow(&body, &GrowOptions::default()).unwrap()).unwrap();
    let skin = agent.skin();
    let shape = |receptor: usize| {
        let surface = skin.receptors[receptor].surface;
        surface.map_or(GeomKind::Other(0), |surface| body.model.geom_kind(skin.surfaces[surface].geom))
    };
    let babbler = Babbler::new(Movers::new(&body, &agent, MotionName::Kinematic).unwrap());
    let mut made = Vec::new();
    let write = |news: Made| {
        let Made::Touch(touch) = news else { return Ok(()) };
        let mut shapes = touch.ends.map(|end| format!("{:?}", shape(end.receptor)).to_lowercase());
        shapes.sort();
        made.push(Written {
            bout: touch.bout,
            motion: touch.motion,
            posture: touch.posture.to_vec(),
            shapes,
            contacts: touch.exact_contact().points.map(Into::into),
            limbs: touch.ends.map(|end| skin.receptors[end.receptor].limb),
        });
        Ok(())
    };
    let options = BabblingOptions { touches: TOUCHES, seed: 1, jobs: 2 };
    babbler.babble(PolicyName::Random, BoutsDone::default(), &options, write).unwrap();
    made
}

/// How far apart two touches are, metres or radians; infinitely where they are not the same touch.
fn apart(a: &Written, b: &Written) -> f64 {
    if (a.bout, a.motion, a.limbs) != (b.bout, b.motion, b.limbs) {
        return f64::INFINITY;
    }
    let numbers = |touch: &Written| [&touch.posture[..], touch.contacts.as_flattened()].concat();
    numbers(a).iter().zip(numbers(b)).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
}

#[test]
#[ignore = "writes for the comparison of engines: see .ci/engine"]
fn touches_are_written_down() {
    fs::write(place(), serde_json::to_string(&made_here()).unwrap()).unwrap();
}

#[test]
#[ignore = "compares engines: see .ci/engine"]
fn touches_are_those_that_another_engine_wrote_down() {
    let text = fs::read_to_string(place()).expect("no touches of another engine: run .ci/engine");
    let other: OfEngine = serde_json::from_str(&text).unwrap();
    let here = made_here();
    println!(
        "MuJoCo {} and {}: touches compared, those apart, by how much at most",
        other.version, here.version
    );
    let mut wrong = Vec::new();
    for (creature, touches) in &here.touches {
        let mut by_shapes: BTreeMap<&[String; 2], Vec<f64>> = BTreeMap::new();
        for bout in other.touches[creature].chunk_by(|a, b| a.bout == b.bout) {
            let same = touches.iter().filter(|touch| touch.bout == bout[0].bout);
            for (a, b) in bout.iter().zip(same) {
                let distance = apart(a, b);
                by_shapes.entry(&a.shapes).or_default().push(distance);
                if distance > SAME_START {
                    // All that follows in the bout begins where this touch ended, and may end ten times as far off.
                    break;
                }
            }
        }
        for (shapes, distances) in by_shapes {
            let over = distances.iter().filter(|distance| **distance > AGREEMENT).count();
            let greatest = distances.iter().copied().fold(0.0, f64::max);
            println!(
                "{creature:12} {:20} {:4} {over:4} {greatest:9.1e}",
                shapes.join(" on "),
                distances.len()
            );
            let alike = shapes.iter().all(|shape| ALIKE.contains(&shape.as_str()));
            if greatest > if alike { AGREEMENT } else { NEARLY } {
                wrong.push(format!("{creature}: {}", shapes.join(" on ")));
            }
        }
    }
    assert!(wrong.is_empty(), "too far apart: {wrong:?}");
}
