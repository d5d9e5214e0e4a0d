//! Touches of a simulated robot as its encoders and skins would report them: to see what a calibration is worth where the
//! truth is known.

use rand::Rng;
use rand_distr::{Distribution, StandardNormal};

use crate::agent::Agent;
use crate::calibration::robot::{Posed, Robot, Value};
use crate::calibration::{End, Feature, Touch};
use crate::creature::{DofKind, Posture, ball};
use crate::geometry::Frame;
use crate::kinematics::limb_frames;
use crate::schema::BodySchema;
use crate::senses::RecordedTouch;

/// Touches of an agent, whose joints are where a schema says, as a log of points tells them for a robot with links and degrees
/// of freedom of the same names. The robot's frames may be others, and its root one that carries the agent's: with all joints
/// at their references both are the same body. Of limbs that the robot does not have there is no touch.
pub fn point_touches(
    agent: &Agent,
    schema: &BodySchema,
    robot: &Robot,
    touches: &[RecordedTouch],
) -> Vec<Touch> {
    let creature = agent.creature();
    // What follows another joint need not be at zero where that one is.
    let mut zero = Posture::reference(creature);
    creature.couple(&mut zero);
    let own = limb_frames(creature, schema, &zero);
    let nominal = robot.nominal();
    // What encoders read where every hinge and slide is at its own zero.
    let mut reference = robot.zero_posture();
    for dof in robot.leaders() {
        let Some(q) = dof.quantities else { continue };
        let [sign, gain, offset] = [q.sign, q.gain, q.offset].map(|q| nominal[q].number());
        reference[dof.coordinate] = 0.0 - offset / (sign * gain);
    }
    // Joints that the agent does not move are where their limits let them be.
    for dof in robot.leaders().filter(|dof| dof.kind != DofKind::Ball) {
        if creature.dofs().all(|other| other.name != dof.name) {
            let at = &mut reference[dof.coordinate];
            *at = at.max(dof.range[0]).min(dof.range[1]);
        }
    }
    let theirs = Posed::new(robot, &nominal, &reference).frames();
    let root = robot.link(&creature.limbs()[0]).map_or(Frame::identity(), |link| theirs[link]);
    // Per limb the robot's link for its points, and the limb's frame in that link's.
    let places: Vec<Option<(usize, Frame)>> = creature
        .limbs()
        .iter()
        .zip(&own)
        .map(|(name, frame)| robot.points_of(name).map(|link| (link, theirs[link].inverse() * root * *frame)))
        .collect();
    let end = |touch: &RecordedTouch, k: usize| {
        let (link, pose) = places[touch.limbs(agent.skin())[k]]?;
        let point = pose.point(&touch.exact_contact().points[k]);
        Some(vec![End { feature: Feature::Point(link, point), deviation: None }])
    };
    let one = |(i, touch): (usize, &RecordedTouch)| {
        let mut posture = reference.clone();
        for (joint, place) in creature.joints().iter().zip(&places[1..]) {
            for element in joint.elements() {
                let Some(dof) = robot.leaders().find(|dof| dof.name == element.name) else { continue };
                let (at, read) = (dof.coordinate, element.of(&touch.posture));
                match (dof.kind, place) {
                    (DofKind::Ball, Some((_, pose))) => {
                        // The same turn, about axes of the link's frame.
                        let turn = ball(read);
                        let axis = pose.direction(&turn.imag());
                        posture[at..at + 4].copy_from_slice(&[turn.w, axis.x, axis.y, axis.z]);
                    }
                    (DofKind::Ball, None) => posture[at..at + 4].copy_from_slice(read),
                    (DofKind::Hinge | DofKind::Slide, _) => posture[at] += read[0],
                }
            }
        }
        Some(Touch {
            line: i + 2,
            posture,
            ends: [end(touch, 0)?, end(touch, 1)?],
            distance: 0.0,
            time: None,
        })
    };
    touches.iter().enumerate().filter_map(one).collect()
}

/// What encoders that are off make of touches whose postures are as the joints are; `values` says how they are off. Joints that
/// give way are left as they are.
pub fn misread(robot: &Robot, values: &[Value], touches: &mut [Touch]) {
    let number = |quantity: usize| values[quantity].number();
    for dof in &robot.dofs {
        let Some(q) = dof.quantities else { continue };
        for touch in touches.iter_mut() {
            let at = &mut touch.posture[dof.coordinate];
            *at = (*at - number(q.offset)) / (number(q.sign) * number(q.gain));
        }
    }
}

/// Adds normal noise to what encoders of hinges read, radians.
pub fn add_joint_noise(robot: &Robot, touches: &mut [Touch], deviation: f64, rng: &mut impl Rng) {
    for touch in touches {
        for dof in robot.dofs.iter().filter(|dof| dof.kind == DofKind::Hinge) {
            touch.posture[dof.coordinate] += deviation * normal(rng);
        }
    }
}

/// Adds normal noise to the coordinates of points, metres.
pub fn add_point_noise(touches: &mut [Touch], deviation: f64, rng: &mut impl Rng) {
    for end in touches.iter_mut().flat_map(|touch| &mut touch.ends).flatten() {
        if let Feature::Point(_, point) = &mut end.feature {
            point.iter_mut().for_each(|x| *x += deviation * normal(rng));
        }
    }
}

/// A number from the standard normal distribution.
pub fn normal(rng: &mut impl Rng) -> f64 {
    StandardNormal.sample(rng)
}
