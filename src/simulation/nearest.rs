//! How near limbs come to each other that do not touch.

use std::collections::BTreeMap;

use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

use super::{Relation, SelfContact};
use crate::agent::Agent;
use crate::creature::{Body, Posture};
use crate::geometry::{PlacedShape, Precision, gap};
use crate::ground_truth::GroundTruth;
use crate::kinematics::limb_frames;
use crate::mujoco;
use crate::skin::Surface;

/// Random postures that are looked at, always the same ones.
const POSTURES: usize = 200;

/// The two limbs that come nearest to each other of all that may touch.
#[derive(Clone, Debug, PartialEq)]
pub struct NearestLimbs {
    /// Their names.
    pub limbs: [String; 2],
    /// The least gap between them in random postures, metres; 0 or less where they meet.
    pub gap: f64,
}

impl NearestLimbs {
    /// Looks at a body in random postures; none where no two limbs with surfaces may touch.
    ///
    /// # Errors
    /// Where the engine fails.
    pub(super) fn new(body: &Body, agent: &Agent) -> mujoco::Result<Option<NearestLimbs>> {
        let (creature, schema) = (&body.creature, GroundTruth::new(body)?.schema);
        let mut of_limb: Vec<Vec<&Surface>> = vec![Vec::new(); creature.limbs().len()];
        agent.skin().surfaces.iter().for_each(|surface| of_limb[surface.limb].push(surface));
        let contact = SelfContact::new(body)?;
        let may_touch = contact.pairs.iter().filter(|pair| pair.relation == Relation::Touch);
        let mut least: BTreeMap<[usize; 2], f64> =
            may_touch.map(|pair| (pair.limbs, f64::INFINITY)).collect();
        let mut rng = ChaCha8Rng::seed_from_u64(0);
        for _ in 0..POSTURES {
            let frames = limb_frames(creature, &schema, &Posture::random(creature, &mut rng));
            let placed: Vec<Vec<PlacedShape>> = of_limb
                .iter()
                .zip(&frames)
                .map(|(of_it, frame)| of_it.iter().filter_map(|surface| surface.placed(frame)).collect())
                .collect();
            for (limbs, least) in &mut least {
                let [first, second] = limbs.map(|limb| &placed[limb]);
                for (a, b) in first.iter().flat_map(|a| second.iter().map(move |b| (a, b))) {
                    *least = least.min(gap(a, b, Precision::LowerBound).distance);
                }
            }
        }
        let nearest = least.into_iter().min_by(|a, b| a.1.total_cmp(&b.1)).filter(|(_, gap)| gap.is_finite());
        Ok(nearest.map(|(limbs, gap)| NearestLimbs {
            limbs: limbs.map(|limb| creature.limbs()[limb].clone()),
            gap,
        }))
    }
}

impl std::fmt::Display for NearestLimbs {
    fn fmt(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
        let NearestLimbs { limbs: [first, second], gap } = self;
        match *gap > 0.0 {
            true => write!(
                f,
                "of all limbs that may touch {first} and {second} come nearest, to {:.2} mm in {POSTURES} random postures: \
                 give joints wider ranges, or limbs more girth",
                1e3 * gap
            ),
            false => write!(
                f,
                "{first} and {second} meet in random postures, but no motion brought skin to skin: give it more time \
                 (--seconds), move more joints (--joints all) or grow more skin"
            ),
        }
    }
}
