//! The space that a hand can get to: the map against postures drawn at random, its levels, and its queries.

mod common;

use bodyschema::babbling::random_posture;
use bodyschema::learning::Input;
use bodyschema::peripersonal::{Level, OwnBody, ReachableMap};
use bodyschema::skin::skin_of;
use common::{creature, max, truth, two_arms};
use nalgebra::Vector3;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

/// The rounding of a kept posture, metres.
const ROUNDING: f64 = 1e-5;

fn knowing(body: &bodyschema::creature::Body) -> OwnBody {
    OwnBody::new(&body.creature, &skin_of(body), truth(body), &[], Input::Receptor)
}

fn max_map(voxel: f64) -> (OwnBody, ReachableMap) {
    let own = knowing(&max("torso"));
    let hands = ["left_hand", "right_hand"].map(|name| own.creature.limb(name).unwrap());
    let map = ReachableMap::new(&own, hands[0], own.carrier_of(&hands), voxel).unwrap();
    (own, map)
}

#[test]
fn timing() {
    for voxel in [0.05, 0.02] {
        let began = std::time::Instant::now();
        let (own, map) = max_map(voxel);
        eprintln!("QQ {voxel}: {:.2} s, volumes {:?}, {} voxels, box {:?}, tip {:?}", began.elapsed().as_secs_f64(), map.volumes(), map.voxels().count(), map.lattice(), map.tip);
        eprintln!("QQ chest {}", own.creature.limbs()[map.chest]);
        let mut rng = ChaCha8Rng::seed_from_u64(5);
        let (mut found, mut all) = (0, 0);
        for k in 0..200_000 {
            let _ = k; let posture = random_posture(&own.creature, &mut rng);
            let frames = own.frames(&posture);
            let p = map.frame.inverse_point(&frames[map.hand].point(&map.tip.point));
            all += 1;
            found += usize::from(map.level(&p) != Level::OutOfReach);
        }
        eprintln!("QQ samples {found} of {all}");
    }
}
