//! Lifting a thing between both palms: by friction, and not without.

use crate::common::{babble, max, repository, truth};
use bodyschema::agent::Agent;
use bodyschema::creature::JointSelection;
use bodyschema::geometry::Shape;
use bodyschema::interaction::{Actor, Trouble};
use bodyschema::learning::Certainty;
use bodyschema::peripersonal::{OwnBody, Palm};
use bodyschema::simulation::{Stage, StageOptions, Substance, Thing};
use nalgebra::Isometry3;

/// Where the top of the table is, metres.
const TOP: f64 = 0.98;

/// Max at a table with a box of 7 x 8 x 10 cm and 1 kg in front of him, which he has not felt yet.
fn at_a_box(friction: f64) -> (Stage, Actor, usize) {
    let body = max("torso");
    let agent = Agent::of(&body).unwrap();
    let touches = babble(&body, &agent, 300, 1, 2);
    let own =
        OwnBody::new(&agent, truth(&body), Certainty::Exact, touches.iter().map(|touch| &touch.posture));
    let thing = |name: &str, half: [f64; 3], at: [f64; 3], fixed: bool, substance: Substance| Thing {
        name: name.into(),
        shape: Shape::Box { half_extents: half },
        pose: Isometry3::translation(at[0], at[1], at[2]),
        fixed,
        substance,
    };
    let table = thing("table", [0.55, 1.0, 0.02], [0.77, 0.0, TOP - 0.02], true, Substance::default());
    let substance = Substance { mass: Some(1.0), friction: Some(friction) };
    let parcel = thing("parcel", [0.04, 0.035, 0.05], [0.45, 0.02, TOP + 0.05], false, substance);
    let joints: JointSelection = "torso".parse().unwrap();
    let options = StageOptions { joints, things: vec![table, parcel], ..StageOptions::default() };
    let stage = Stage::new(&repository("mjcf/max/max.xml"), &options).unwrap();
    let mut actor = Actor::new(own, stage.handle(), ["left_hand", "right_hand"], 1).unwrap();
    let parcel = stage.thing("parcel").unwrap();
    stage.place(&actor.ready()).unwrap();
    let height = actor.feel_table(0).unwrap();
    actor.know_table(height);
    (stage, actor, parcel)
}

#[test]
fn both_palms_lift_a_box_by_friction_alone_and_set_it_down() {
    let (stage, mut actor, parcel) = at_a_box(0.8);
    let found = actor.explore(1).unwrap().unwrap();
    assert_eq!(found.thing, parcel);
    let before = stage.thing_pose(parcel).translation.vector;
    let mut grip = actor.lift(&found, 1).unwrap();
    actor.hold_up(&mut grip, 2.0).unwrap();
    let held = stage.thing_pose(parcel).translation.vector;
    assert!(held.z - before.z > 0.08, "risen by {} m", held.z - before.z);
    actor.set_down(&mut grip).unwrap();
    actor.wait(0.3).unwrap();
    let after = stage.thing_pose(parcel).translation.vector;
    assert!((after - before).norm() < 0.05, "set down {} m from where it stood", (after - before).norm());
}

#[test]
fn what_has_no_friction_slips_and_he_says_so() {
    let (stage, mut actor, parcel) = at_a_box(0.05);
    let found = actor.explore(1).unwrap().unwrap();
    assert_eq!(found.thing, parcel);
    let trouble = actor.lift(&found, 0).unwrap_err();
    assert!(matches!(trouble, Trouble::Slipped), "{trouble}");
    assert!(trouble.to_string().contains("slips"));
    let after = stage.thing_pose(parcel).translation.vector;
    assert!(after.z < TOP + 0.06, "it is at a height of {} m", after.z);
}

#[test]
fn palms_are_the_hollow_sides_of_hands_and_face_each_other_at_ease() {
    let body = max("torso");
    let agent = Agent::of(&body).unwrap();
    let touches = babble(&body, &agent, 300, 1, 2);
    let own =
        OwnBody::new(&agent, truth(&body), Certainty::Exact, touches.iter().map(|touch| &touch.posture));
    let frames = own.frames(&own.at_ease());
    let facing = ["left_hand", "right_hand"].map(|name| {
        let limb = own.creature().limb(name).unwrap();
        let palm = Palm::of(&own, limb).unwrap();
        frames[limb].rotation * palm.frame.rotation.column(0)
    });
    assert!(facing[0].y < -0.9 && facing[1].y > 0.9, "{facing:?}");
}
