//! A body posed according to a schema.

use nalgebra::Vector3;
use serde_json::{Value, json};

use super::{point, whole};
use crate::agent::Agent;
use crate::creature::Creature;
use crate::geometry::Frame;
use crate::kinematics::limb_frames;
use crate::schema::BodySchema;

/// One schema laid out in the root limb's frame, metres.
#[derive(Clone, Debug, Default)]
pub(in crate::view) struct Pose {
    /// `X_RL` of every limb.
    pub frames: Vec<Frame>,
    /// Where each limb begins: at its joint, wherever its own frame is. Empty where nothing has joints.
    pub begins: Vec<Vector3<f64>>,
}

impl Pose {
    /// In a posture.
    pub fn new(creature: &Creature, schema: &BodySchema, posture: &[f64]) -> Pose {
        let frames = limb_frames(creature, schema, posture);
        let placed = creature.joints().iter().zip(&schema.positions);
        let begins = std::iter::once(frames[0].origin)
            .chain(placed.map(|(joint, position)| frames[joint.parent].point(position)))
            .collect();
        Pose { frames, begins }
    }

    /// In the rest posture.
    pub fn at_rest(creature: &Creature, schema: &BodySchema) -> Pose {
        Pose::new(creature, schema, &creature.reference_posture())
    }

    /// Parts at some poses, without joints.
    #[cfg(feature = "live")]
    pub fn of_parts(frames: Vec<Frame>) -> Pose {
        Pose { frames, begins: Vec::new() }
    }

    /// The same elsewhere.
    #[cfg(feature = "live")]
    pub fn moved(mut self, by: &Vector3<f64>) -> Pose {
        self.frames.iter_mut().for_each(|frame| frame.origin += by);
        self.begins.iter_mut().for_each(|begin| *begin += by);
        self
    }

    /// As the viewer takes it: the frame of each limb, and where it begins.
    pub fn told(&self) -> Value {
        let frames: Vec<i64> = self.frames.iter().flat_map(numbers).collect();
        let begins: Vec<i64> = self.begins.iter().flat_map(point).collect();
        json!({ "frames": frames, "begins": begins })
    }
}

/// A frame as the viewer takes it: a quaternion w x y z and an origin.
pub(super) fn numbers(frame: &Frame) -> [i64; 7] {
    let (q, o) = (frame.quaternion(), frame.origin);
    [q.w, q.i, q.j, q.k, o.x, o.y, o.z].map(whole)
}

/// The limbs that carry no other and have skin, and the middle of it in the limb's frame, metres.
pub(super) fn tips(agent: &Agent) -> Vec<(usize, Vector3<f64>)> {
    let (creature, skin) = (agent.creature(), agent.skin());
    let middle = |limb: usize| {
        let own: Vec<_> = skin.receptors.iter().filter(|r| r.limb == limb).map(|r| r.position).collect();
        let carries = creature.joints().iter().any(|joint| joint.parent == limb);
        (!carries && !own.is_empty()).then(|| (limb, own.iter().sum::<Vector3<f64>>() / own.len() as f64))
    };
    (0..creature.limbs().len()).filter_map(middle).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn poses_are_told_as_quaternions_and_places_in_tenths_of_millimetres() {
        let turn = nalgebra::UnitQuaternion::from_axis_angle(&Vector3::z_axis(), std::f64::consts::FRAC_PI_2);
        let frame =
            Frame { rotation: turn.to_rotation_matrix().into_inner(), origin: Vector3::new(1.0, 2.0, 3.0) };
        let told = Pose::of_parts(vec![frame]).moved(&Vector3::x()).told();
        assert_eq!(told, json!({ "frames": [7071, 0, 0, 7071, 20000, 20000, 30000], "begins": [] }));
    }
}
