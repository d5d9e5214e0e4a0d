//! What a sense is, and the senses of every creature on a stage.
//!
//! To add one, write a file with a [`Sense`] and a line in [`SENSES`]: a creature on a stage reads it by its type, from
//! [`AgentHandle::sense`](crate::simulation::AgentHandle::sense).

use std::any::Any;

use super::skin_contact::SkinContact;
use super::{Aura, Balance, Proprioception, TouchSensor};
use crate::agent::Agent;
use crate::creature::{Body, Posture};
use crate::error::Result;
use crate::geometry::Frame;
use crate::mujoco::Data;

/// Makes a sense for a creature on a stage.
pub type NewSense = fn(&SensingBody) -> Result<Box<dyn Sense>>;

/// The senses of every creature on a stage: touch, posture, proximity, balance.
pub const SENSES: &[NewSense] = &[
    |own| Ok(Box::new(TouchSensor::of(own)?)),
    |own| Ok(Box::new(Proprioception::of(own)?)),
    |own| Ok(Box::new(Aura::of(own))),
    |_| Ok(Box::new(Balance::default())),
];

/// The creature that a sense is made for.
#[derive(Clone, Copy)]
pub struct SensingBody<'a> {
    /// The agent that senses.
    pub agent: &'a Agent,
    /// Its body in the model.
    pub body: &'a Body,
    /// `X_WL` of every limb in the posture that the creature came with.
    pub frames: &'a [Frame],
}

/// The state after a step. A sense reports no more of it than a body could feel.
#[derive(Clone, Copy)]
pub struct SensedStep<'a> {
    /// Simulated time at its beginning, seconds.
    pub time: f64,
    /// The agent that senses.
    pub agent: &'a Agent,
    /// Its body in the model.
    pub body: &'a Body,
    /// The posture that the body is really in.
    pub posture: &'a Posture,
    /// What the engine computed: poses, and after contacts their forces.
    pub data: &'a Data,
    /// The contacts with the skin.
    pub contacts: &'a [SkinContact],
}

/// A sense: it keeps its latest report.
pub trait Sense: Any {
    /// Senses the state after a step. Senses of events have this, those of a state have [`Sense::place`] alone.
    ///
    /// # Errors
    /// Where the engine fails.
    fn step(&mut self, step: &SensedStep) -> Result<()> {
        self.place(step)
    }

    /// Senses the state of a body that was put into a posture at once, as before the first step.
    ///
    /// # Errors
    /// Where the engine fails.
    fn place(&mut self, _step: &SensedStep) -> Result<()> {
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use nalgebra::Vector3;

    use super::*;
    use crate::creature::JointSelection;
    use crate::mujoco::Model;

    /// A trunk on its side with an arm, whose elbow is read no farther than 0.5.
    const TIPPED: &str = r#"<mujoco>
  <compiler angle="radian" autolimits="true"/>
  <worldbody><body name="trunk" quat="1 1 0 0"><freejoint/><geom size=".1"/>
    <body name="arm" pos=".3 0 0"><joint name="elbow" axis="0 0 1" range="-1 1"/><geom size=".05"/>
      <site name="tip" size=".01"/></body>
  </body></worldbody>
  <sensor><jointpos joint="elbow" cutoff="0.5"/><touch site="tip"/></sensor>
</mujoco>"#;

    /// A sense of one's own: it counts steps.
    #[derive(Default)]
    struct Steps(usize);

    impl Sense for Steps {
        fn step(&mut self, _: &SensedStep) -> Result<()> {
            self.0 += 1;
            Ok(())
        }
    }

    fn read<S: Sense>(senses: &[Box<dyn Sense>]) -> &S {
        let mut found = senses.iter().filter_map(|sense| (sense.as_ref() as &dyn Any).downcast_ref());
        let (Some(sense), None) = (found.next(), found.next()) else { panic!("each sense is there once") };
        sense
    }

    #[test]
    fn every_sense_is_made_placed_and_stepped_from_one_list() {
        let model = Arc::new(Model::from_xml(TIPPED).expect("it is a model"));
        let body = Body::new(model, &JointSelection::All).expect("it is a creature");
        let agent = Agent::of(&body).expect("it has a skin");
        let mut data = body.reference_data().expect("the engine computes");
        let posture = Posture::from(vec![0.75]);
        body.put(&posture, &mut data).expect("the engine computes");
        let own = SensingBody { agent: &agent, body: &body, frames: &body.limb_frames(&data) };
        let made = SENSES.iter().map(|new| new(&own)).collect::<Result<Vec<_>>>();
        let mut senses = made.expect("the engine computes");
        senses.push(Box::new(Steps::default()));
        let step = SensedStep {
            time: 0.0,
            agent: &agent,
            body: &body,
            posture: &posture,
            data: &data,
            contacts: &[],
        };
        for sense in &mut senses {
            sense.place(&step).and_then(|()| sense.step(&step)).expect("the engine computes");
        }
        assert_eq!(read::<Steps>(&senses).0, 1);
        assert!((read::<Balance>(&senses).up - Vector3::y()).norm() < 1e-9);
        assert_eq!(**read::<Proprioception>(&senses).felt(), [0.5]);
        assert_eq!(read::<TouchSensor>(&senses).present().count(), 0);
        assert_eq!(read::<Aura>(&senses).approaches().count(), 0);
    }
}
