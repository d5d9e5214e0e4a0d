//! The zoo: every creature loads, has the tree that its README claims, moves as MuJoCo moves it, and starts out
//! touching nothing; small ones learn themselves.

use std::collections::BTreeSet;
use std::sync::Arc;

use crate::common::{babble, repository, take};
use bodyschema::agent::Agent;
use bodyschema::creature::{Body, DofKind, JointSelection, Posture};
use bodyschema::evaluation::evaluate_learned;
use bodyschema::ground_truth::GroundTruth;
use bodyschema::kinematics::limb_frames;
use bodyschema::learning::{Input, Learner, SecondOrder};
use bodyschema::mujoco::{Data, GeomKind, Model};
use bodyschema::skin::{GrowOptions, grow};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

/// Agreement of positions with MuJoCo's, by the creature's size, and of rotation matrices, per entry.
const AGREEMENT: f64 = 1e-10;
/// Root mean square of held-out errors that touches determine, millimetres (the figure, of the mean).
const DETERMINED_MM: f64 = 0.5;
/// Random postures per creature.
const POSTURES: usize = 20;

/// A creature of the zoo and what is claimed of it.
struct Claim {
    name: &'static str,
    joints: usize,
    dof: usize,
    /// Limbs that carry two limbs or more.
    branching: usize,
    /// Limbs that carry none.
    tips: usize,
    free: bool,
}

const ZOO: [Claim; 6] = [
    Claim { name: "hexapod", joints: 18, dof: 18, branching: 1, tips: 6, free: true },
    Claim { name: "octopus", joints: 32, dof: 32, branching: 1, tips: 8, free: true },
    Claim { name: "snake", joints: 18, dof: 18, branching: 1, tips: 2, free: true },
    Claim { name: "fourarms", joints: 15, dof: 29, branching: 1, tips: 5, free: false },
    Claim { name: "sauropod", joints: 20, dof: 29, branching: 1, tips: 6, free: true },
    Claim { name: "contraption", joints: 12, dof: 17, branching: 2, tips: 4, free: false },
];

fn body(name: &str) -> Body {
    let model = Model::from_path(repository(&format!("mjcf/{name}/{name}.xml"))).unwrap();
    assert_eq!(model.warning(), None, "{name}");
    Body::new(Arc::new(model), &JointSelection::All).unwrap()
}

#[test]
fn the_trees_are_what_they_are_claimed_to_be() {
    let mut shapes = Vec::new();
    for claim in ZOO {
        let Claim { name, .. } = claim;
        let body = body(name);
        let creature = &body.creature;
        let free = body.model.nq() > creature.coordinates();
        assert_eq!((creature.name(), free), (name, claim.free));
        assert_eq!((creature.joints().len(), creature.dof()), (claim.joints, claim.dof), "{name}");
        let carried = |limb: usize| creature.joints().iter().filter(|joint| joint.parent == limb).count();
        let limbs = || 0..creature.limbs().len();
        assert_eq!(limbs().filter(|&limb| carried(limb) > 1).count(), claim.branching, "{name}");
        assert_eq!(limbs().filter(|&limb| carried(limb) == 0).count(), claim.tips, "{name}");
        assert!(body.model.bodies().skip(1).all(|b| b.name.is_some()), "{name}");
        assert!(body.model.joints().all(|joint| joint.name.is_some()), "{name}");
        assert!(creature.dofs().all(|dof| dof.range[0] < dof.range[1]), "{name}");
        let names: BTreeSet<&str> = creature.dofs().map(|dof| dof.name.as_str()).collect();
        assert_eq!(names.len(), creature.dofs().count(), "{name}");
        shapes.extend(body.model.geoms().map(|geom| geom.kind));
    }
    use GeomKind::{Box, Capsule, Cylinder, Ellipsoid, Sphere};
    for kind in [Sphere, Capsule, Cylinder, Box, Ellipsoid] {
        assert!(shapes.contains(&kind), "no {kind:?} is in the zoo");
    }
    let contraption = body("contraption");
    for kind in [DofKind::Hinge, DofKind::Slide, DofKind::Ball] {
        assert!(contraption.creature.dofs().any(|dof| dof.kind == kind), "no {kind:?}");
    }
}

#[test]
fn axes_are_not_those_that_limbs_lie_along() {
    for Claim { name, .. } in ZOO {
        let body = body(name);
        let straight = body.model.joints().filter(|joint| joint.axis.amax() > 1.0 - 1e-9).count();
        assert!(straight * 4 < body.model.njnt(), "{name}: {straight} axes are straight");
    }
}

#[test]
fn kinematics_agree_with_mujoco() {
    for Claim { name, .. } in ZOO {
        let body = body(name);
        let schema = GroundTruth::new(&body).unwrap().schema;
        let mut data = Data::new(body.model.clone()).unwrap();
        let mut rng = ChaCha8Rng::seed_from_u64(5);
        for _ in 0..POSTURES {
            let posture = Posture::random(&body.creature, &mut rng);
            take(&body, &mut data, &posture);
            let frames = limb_frames(&body.creature, &schema, &posture);
            let root = data.body_pose(body.root);
            for (limb, frame) in frames.iter().enumerate() {
                let pose = root.inv_mul(&body.limb_pose(&data, limb).unwrap());
                let off = (frame.origin - pose.translation.vector).norm();
                let turned = (frame.rotation - pose.rotation.to_rotation_matrix().into_inner()).amax();
                let size = 1.0 + pose.translation.vector.norm();
                assert!(
                    off < AGREEMENT * size && turned < AGREEMENT,
                    "{name}, limb {limb}: {off} m, {turned}"
                );
            }
        }
    }
}

#[test]
fn the_reference_posture_touches_nothing() {
    let mut found = Vec::new();
    for Claim { name, .. } in ZOO {
        let body = body(name);
        let mut data = Data::new(body.model.clone()).unwrap();
        take(&body, &mut data, &body.creature.reference_posture());
        let names = |geom: usize| body.model.body(body.model.geom_body(geom)).name.map(str::to_string);
        let touching: Vec<_> = data.contacts().map(|contact| contact.geoms.map(names)).collect();
        found.extend(touching.into_iter().map(|bodies| (name, bodies)));
    }
    assert!(found.is_empty(), "{found:?}");
}

/// What 2,000 exact contacts teach a creature is right, and they teach at least `least` joints.
fn assert_right_or_named(name: &str, least: usize) {
    let body = body(name);
    let agent = Agent::new(body.creature.clone(), grow(&body, &GrowOptions::default()).unwrap()).unwrap();
    let mut learner = SecondOrder::new(&agent, Input::Contact, 1);
    babble(&body, &agent, 2000, 1, 2).iter().for_each(|touch| learner.touch(&touch.felt(Input::Contact)));
    let learned = learner.learn();
    let known = body.creature.joints().len() - learned.undetermined().len();
    assert!(known >= least, "{name}: {known} joints, {:?}", learned.verdict);
    let truth = GroundTruth::new(&body).unwrap();
    // Where a limb that nothing touches lies along its joints' axes is gauge freedom, and not counted.
    let found = evaluate_learned(&agent, &truth, &learned).bound_mm.unwrap();
    assert!(found.error_rms <= DETERMINED_MM, "{name}: {found:?}");
}

#[test]
fn what_the_contraption_learns_is_right_and_the_rest_is_named() {
    assert_right_or_named("contraption", 4);
}

#[test]
fn what_the_hexapod_learns_is_right_and_the_rest_is_named() {
    assert_right_or_named("hexapod", 6);
}
