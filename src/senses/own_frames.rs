//! The same body and touches, told in frames of the limbs' own.
//!
//! Nobody describes the limbs of a real robot in frames with their origins at the joints: each has its own,
//! fixed to it, and where it is on its joint is not known. Here are such frames for a creature whose limbs are
//! described in their joints' frames: random ones, for measuring whether a learner finds them.

use nalgebra::{UnitQuaternion, Vector3};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

use crate::creature::Creature;
use crate::geometry::Frame;
use crate::schema::BodySchema;
use crate::senses::Touch;
use crate::skin::Skin;

/// The random stream of a seed that frames are drawn from: none that babbling, initial guesses or disturbances use.
const FRAME_STREAM: u64 = u64::MAX - 3;
/// How far an own frame's origin may be from the joint along each axis, metres.
const FARTHEST: f64 = 0.1;

/// Per limb, the pose of its own frame in the frame of its joint.
#[derive(Clone, Debug, PartialEq)]
pub struct OwnFrames(Vec<Frame>);

impl OwnFrames {
    /// Random frames: any rotation, and a shift of up to 0.1 m along each axis, for every limb, the root among
    /// them.
    pub fn random(creature: &Creature, seed: u64) -> OwnFrames {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        rng.set_stream(FRAME_STREAM);
        let frame = |_| {
            // Four normal numbers point to a rotation drawn uniformly from all.
            let [w, x, y, z]: [f64; 4] = std::array::from_fn(|_| StandardNormal.sample(&mut rng));
            let turn = UnitQuaternion::from_quaternion(nalgebra::Quaternion::new(w, x, y, z));
            let origin = Vector3::from_fn(|_, _| rng.random_range(-FARTHEST..FARTHEST));
            Frame { rotation: turn.to_rotation_matrix().into_inner(), origin }
        };
        OwnFrames((0..creature.limbs().len()).map(frame).collect())
    }

    /// The skin in these frames.
    pub fn skin(&self, skin: &Skin) -> Skin {
        let mut skin = skin.clone();
        for receptor in &mut skin.receptors {
            let frame = &self.0[receptor.limb];
            receptor.position = frame.inverse_point(&receptor.position);
            receptor.normal = frame.rotation.tr_mul(&receptor.normal);
            receptor.tangent = frame.rotation.tr_mul(&receptor.tangent);
        }
        for surface in &mut skin.surfaces {
            let frame = &self.0[surface.limb];
            surface.origin = frame.inverse_point(&surface.origin);
            surface.rotation = frame.rotation.tr_mul(&surface.rotation);
        }
        skin
    }

    /// Touches of a skin in these frames.
    pub fn touches(&self, skin: &Skin, touches: &[Touch]) -> Vec<Touch> {
        let mut touches = touches.to_vec();
        for end in touches.iter_mut().flat_map(|touch| &mut touch.ends) {
            end.contact = self.0[skin.receptors[end.receptor].limb].inverse_point(&end.contact);
        }
        touches
    }

    /// A schema with limbs in their joints' frames, of the same body in these frames.
    pub fn schema(&self, creature: &Creature, schema: &BodySchema) -> BodySchema {
        let mut schema = schema.clone().with_limb_poses();
        for (limb, frame) in self.0.iter().enumerate() {
            schema.reframe(creature, limb, frame);
        }
        schema
    }
}
