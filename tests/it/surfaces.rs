//! What receptors say is true of every shape: under the true schema the surfaces under two receptors that touched
//! meet, and they meet where the contact was.

use std::collections::BTreeMap;
use std::sync::Arc;

use crate::common::{babble, repository, truth};
use bodyschema::agent::Agent;
use bodyschema::creature::{Body, JointSelection};
use bodyschema::geometry::Shape;
use bodyschema::learning::surface_gap::SurfaceGap;
use bodyschema::learning::{Input, SecondOrder};
use bodyschema::mujoco::Model;
use bodyschema::skin::{GrowOptions, grow};

/// Touches per creature.
const TOUCHES: usize = 1000;
/// Limbs press into each other by a micrometre before a motion stops, and the engine's own contacts are that exact.
const GAP: f64 = 4e-6;
/// Then it goes back to where they barely touch, but where they slide along each other.
const BARELY: f64 = 2e-9;
const SLIDING: f64 = 0.02;
/// Round surfaces are nearly parallel where they touch: median distance of the places, metres.
const PLACE: f64 = 1e-4;

fn kind(shape: &Shape) -> &'static str {
    match shape {
        Shape::Sphere { .. } => "sphere",
        Shape::Capsule { .. } => "capsule",
        Shape::Ellipsoid { .. } => "ellipsoid",
        Shape::Cylinder { .. } => "cylinder",
        Shape::Box { .. } => "box",
        Shape::Hull(_) => "hull",
        Shape::Mesh => "mesh",
    }
}

#[test]
fn the_truth_closes_the_gap_between_any_two_shapes() {
    let mut places: BTreeMap<[&str; 2], Vec<f64>> = BTreeMap::new();
    let mut wide = 0;
    for name in ["contraption", "sauropod", "hexapod", "fourarms"] {
        let model = Model::from_path(repository(&format!("mjcf/{name}/{name}.xml"))).unwrap();
        let body = Body::new(Arc::new(model), &JointSelection::All).unwrap();
        let agent = Agent::new(body.creature.clone(), grow(&body, &GrowOptions::default()).unwrap()).unwrap();
        let truth = truth(&body);
        let learner = SecondOrder::new(&agent, Input::Receptor, 1);
        for touch in babble(&body, &agent, TOUCHES, 1, 2) {
            let (_, prepared) = learner.prepare_one(&touch);
            let frames = prepared.frames(&truth);
            let found = SurfaceGap::new(agent.skin(), 1.0).gap(&prepared.ends, &frames);
            let shapes = prepared.ends.map(|end| {
                let surface =
                    agent.skin().receptors[end.receptor].surface.expect("receptors grow on surfaces");
                kind(&agent.skin().surfaces[surface].shape)
            });
            assert!(found.distance.abs() < GAP, "{name}, {shapes:?}: {} m", found.distance);
            wide += usize::from(found.distance.abs() > BARELY);
            let first = touch.ends.iter().position(|end| end.receptor == prepared.ends[0].receptor).unwrap();
            let off = (found.middle() - frames[0].point(&touch.exact_contact().points[first])).norm();
            let [a, b] = shapes;
            places.entry([a.min(b), a.max(b)]).or_default().push(off);
        }
    }
    let all: usize = places.values().map(Vec::len).sum();
    assert!((wide as f64) < SLIDING * all as f64, "{wide} of {all}");
    for (shapes, off) in &mut places {
        off.sort_by(f64::total_cmp);
        assert!(off[off.len() / 2] < PLACE, "{shapes:?}: {} m", off[off.len() / 2]);
    }
    assert!(places.len() > 12, "{:?}", places.keys());
}
