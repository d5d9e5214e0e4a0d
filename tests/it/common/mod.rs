//! Creatures and small helpers that several test files share.

pub mod browser;
pub mod calibrating;
pub mod clients;
pub mod drawing;
pub mod gap_noise;
pub mod program;
pub mod python;
pub mod served;
pub mod sessions;
pub mod shell;

use std::path::{Path, PathBuf};
use std::sync::Arc;

use bodyschema::agent::Agent;
use bodyschema::babbling::{Babbler, BabblingOptions, BoutsDone, Made, PolicyName};
use bodyschema::creature::{Body, JointSelection};
use bodyschema::ground_truth::GroundTruth;
use bodyschema::learning::{Certainty, Input, Learner, SecondOrder};
use bodyschema::mujoco::{Data, Model};
use bodyschema::peripersonal::OwnBody;
use bodyschema::schema::BodySchema;
use bodyschema::senses::RecordedTouch;
use bodyschema::session::SessionRequest;
use bodyschema::simulation::{MotionName, Movers};

/// Whether the engine is none of the family that Debian ships: docs/engines.md tells what is otherwise with these.
pub fn is_newer_engine() -> bool {
    bodyschema::mujoco::check().unwrap() >= bodyschema::mujoco::Version(300)
}

/// Asks for touches by random motions.
pub fn at_random(touches: usize) -> SessionRequest {
    SessionRequest::at_random(touches, 1)
}

/// A file of the repository.
pub fn repository(path: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join(path)
}

/// Max, moving the joints that `joints` names.
pub fn max(joints: &str) -> Body {
    let model = Model::from_path(repository("mjcf/max/max.xml")).unwrap();
    Body::new(Arc::new(model), &joints.parse::<JointSelection>().unwrap()).unwrap()
}

/// A creature from MJCF text, moving all its joints.
pub fn creature(xml: &str) -> Body {
    let model = Model::from_xml(xml).unwrap_or_else(|error| panic!("{error}\n{xml}"));
    Body::new(Arc::new(model), &JointSelection::All).unwrap()
}

/// Where a body's joints really are.
pub fn truth(body: &Body) -> BodySchema {
    GroundTruth::new(body).unwrap().schema
}

/// Puts a body into a posture and computes its poses and contacts.
pub fn take(body: &Body, data: &mut Data, posture: &[f64]) {
    body.put(posture, data).unwrap();
    data.collision().unwrap();
}

/// The first `touches` touches of a seed.
pub fn babble(body: &Body, agent: &Agent, touches: usize, seed: u64, jobs: usize) -> Vec<RecordedTouch> {
    let babbler = Babbler::new(Movers::new(body, agent, MotionName::Kinematic).unwrap());
    let mut made = Vec::new();
    let options = BabblingOptions { touches, seed, jobs };
    let receive = |news: Made| {
        if let Made::Touch(touch) = news {
            made.push(touch.clone());
        }
        Ok(())
    };
    babbler.babble(PolicyName::Random, BoutsDone::default(), &options, receive).unwrap();
    made
}

/// What an agent knows of its body by a schema that touches determine as well as they do.
pub fn own_body(agent: &Agent, schema: &BodySchema, input: Input, touches: &[RecordedTouch]) -> OwnBody {
    let mut learner = SecondOrder::new(agent, input, 0);
    touches.iter().for_each(|touch| learner.touch(&touch.felt(input)));
    let (account, _) = learner.account(schema);
    OwnBody::new(
        agent,
        schema.clone(),
        Certainty::Estimated(Box::new(account)),
        touches.iter().map(|touch| &touch.posture),
    )
}

/// A body and the agent in it, with the skin that its model gives it.
pub fn with_agent(body: Body) -> (Body, Agent) {
    let agent = Agent::of(&body).unwrap();
    (body, agent)
}

/// A trunk held in the world with two arms of two hinges each; every geom is bounded by a capsule only.
///
/// `shape` is the type and sizes of the forearms' geoms, `trunk` those of the trunk's.
pub fn two_arms(trunk: &str, shape: &str) -> String {
    let arm = |side: &str, y: f64| {
        format!(
            r#"<body name="{side}_upper" pos="0 {y} 0.4">
        <joint name="{side}_shoulder_a" axis="1 0.2 0" range="-2.4 2.4"/>
        <joint name="{side}_shoulder_b" axis="0 1 0.3" range="-2.4 2.4"/>
        <geom type="capsule" fromto="0 0 0 0.3 0 0" size="0.03"/>
        <body name="{side}_fore" pos="0.3 0 0">
          <joint name="{side}_elbow_a" axis="0 0 1" range="-2.6 2.6"/>
          <joint name="{side}_elbow_b" axis="0.3 1 0" range="-2.6 2.6"/>
          <geom {shape} pos="0.2 0 0" euler="0.3 0.2 0.1"/>
          <site name="{side}_r" type="box" size="0.3 0.3 0.001" pos="0.2 0 0.1"/>
        </body>
      </body>"#
        )
    };
    format!(
        r#"<mujoco model="two arms">
  <compiler angle="radian" autolimits="true"/>
  <worldbody>
    <body name="trunk" pos="0 0 1">
      <geom {trunk} pos="0 0 0.1"/>
      <site name="t_r" type="box" size="0.4 0.4 0.001" pos="0 0 0.45"/>
      {}
      {}
    </body>
  </worldbody>
  <sensor><touch site="left_r"/><touch site="right_r"/><touch site="t_r"/></sensor>
</mujoco>"#,
        arm("left", 0.25),
        arm("right", -0.25)
    )
}
