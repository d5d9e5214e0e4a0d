//! Models that nobody here prepared: for newer engines, with several creatures, with self-contact switched off,
//! with joints that follow others.

use std::path::Path;
use std::sync::Arc;

use crate::common::program::{refused, run};
use crate::common::{creature, repository};
use bodyschema::creature::{Body, BodyError, Creature, JointSelection, Posture};
use bodyschema::mujoco::Model;
use bodyschema::simulation::{Relation, SelfContact};
use bodyschema::skin::Skin;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

fn rooted(xml: &str, joints: &str, root: Option<&str>) -> Result<Body, BodyError> {
    let model = Arc::new(Model::from_xml(xml).unwrap());
    Body::rooted(model, &joints.parse::<JointSelection>().unwrap(), root)
}

#[test]
fn a_file_for_a_newer_engine_is_stripped_to_its_tree() {
    let path = repository("tests/it/models/newer.xml");
    let refused = Model::from_path(&path).map(|_| ()).unwrap_err().to_string();
    assert!(refused.contains("newer.xml"), "{refused}");
    let (model, left_out) = Model::stripped(&path).unwrap();
    let joints: Vec<_> = model.joints().filter_map(|joint| joint.name.map(str::to_string)).collect();
    assert_eq!(joints, ["shoulder_y", "shoulder_x", "elbow", "other_y"]);
    for what in ["<actuator>", "<keyframe>", "hereafter of <joint>", "mesh flat with its geoms"] {
        assert!(left_out.contains_key(what), "{what} is not in {left_out:?}");
    }
    let body = Body::new(Arc::new(model), &JointSelection::All).unwrap();
    assert_eq!(body.creature.limbs(), ["base", "upper", "lower", "other"]);
    // Ranges without `limited`, as newer engines read them.
    assert_eq!(body.creature.joints()[1].dofs[0].range, [-2.5, 2.5]);
}

#[test]
fn what_is_not_in_the_way_is_not_stripped() {
    let path = repository("mjcf/max/max.xml");
    let (whole, (stripped, _)) = (Model::from_path(&path).unwrap(), Model::stripped(&path).unwrap());
    let bodies = [whole, stripped].map(|model| Body::new(Arc::new(model), &JointSelection::Default).unwrap());
    let [whole, stripped] = &bodies;
    assert_eq!(whole.creature, stripped.creature);
    let skins: [Skin; 2] = [whole, stripped].map(bodyschema::skin::skin_of);
    assert_eq!(skins[0], skins[1]);
    assert_eq!(SelfContact::new(whole).unwrap(), SelfContact::new(stripped).unwrap());
}

#[test]
fn the_command_line_tells_of_strip_and_lists_what_it_leaves_out() {
    let path = repository("tests/it/models/newer.xml");
    let (here, path) = (Path::new("."), path.to_str().unwrap());
    assert!(refused(here, 1, &["inspect", path]).contains("--strip"));
    let stripped = run(here, &["inspect", "--strip", path]);
    let [out, message] = [stripped.stdout, stripped.stderr].map(|text| String::from_utf8(text).unwrap());
    assert_eq!(stripped.status.code(), Some(0), "{message}");
    assert!(out.contains("newer: 3 joints"), "{out}");
    assert!(message.contains("left out of") && message.contains("<actuator>"), "{message}");
}

#[test]
fn a_file_that_no_stripping_mends_says_what_is_wrong() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("broken.xml"), "<mujoco><worldbody><body></worldbody></mujoco>")
        .unwrap();
    let broken = refused(folder.path(), 1, &["inspect", "broken.xml"]);
    assert!(broken.contains("broken.xml") && !broken.contains("--strip"), "{broken}");
    let broken = refused(folder.path(), 1, &["inspect", "--strip", "broken.xml"]);
    assert!(broken.contains("malformed"), "{broken}");
}

const TWO: &str = r#"<mujoco>
  <worldbody>
    <body name="big"><geom size=".1"/>
      <body name="big_arm" pos="1 0 0"><joint name="a"/><geom size=".1"/>
        <body name="big_hand" pos="1 0 0"><joint name="b"/><geom size=".1"/>
          <body name="big_finger" pos="1 0 0"><joint name="c"/><geom size=".1"/></body>
        </body>
      </body>
    </body>
    <body name="small" pos="0 5 0"><freejoint/><geom size=".1"/>
      <body name="small_arm" pos="1 0 0"><joint name="d"/><geom size=".1"/></body>
    </body>
  </worldbody>
</mujoco>"#;

#[test]
fn of_several_creatures_the_root_chooses() {
    let limbs = |root| rooted(TWO, "all", root).unwrap().creature.limbs().to_vec();
    assert_eq!(limbs(None), ["big", "big_arm", "big_hand", "big_finger"]);
    assert_eq!(limbs(Some("small")), ["small", "small_arm"]);
    // A body in the middle of a tree is a root that stands still.
    assert_eq!(limbs(Some("big_arm")), ["big_arm", "big_hand", "big_finger"]);
    let wrong = rooted(TWO, "all", Some("nobody")).unwrap_err().to_string();
    assert!(wrong.contains("nobody") && wrong.contains("big, small"), "{wrong}");
    assert!(matches!(rooted(TWO, "all", Some("big_finger")), Err(BodyError::NoJoints)));
}

const COUPLED: &str = r#"<mujoco>
  <compiler angle="radian" autolimits="true"/>
  <worldbody>
    <body name="palm"><geom size=".01"/>
      <body name="first"><joint name="knuckle" range="-1 1.5" ref="0.2"/><geom size=".01"/>
        <body name="second"><joint name="tip" range="-0.1 0.9" ref="0.1"/><geom size=".01"/></body>
      </body>
      <body name="still"><joint name="still" range="-1 1"/><geom size=".01"/></body>
    </body>
  </worldbody>
  <equality>
    <joint joint1="tip" joint2="knuckle" polycoef="0.05 0.5 0 0 0"/>
    <joint joint1="still" polycoef="0.25 0 0 0 0"/>
  </equality>
</mujoco>"#;

/// The dof of a creature called `name`, and its coordinate in a posture of hinges.
fn coordinate(creature: &Creature, posture: &[f64], name: &str) -> f64 {
    posture[creature.dofs().position(|dof| dof.name == name).unwrap()]
}

#[test]
fn joints_that_follow_others_follow_them_in_every_posture() {
    let body = creature(COUPLED);
    let creature = &body.creature;
    let mut rng = ChaCha8Rng::seed_from_u64(1);
    for _ in 0..100 {
        let posture = Posture::random(creature, &mut rng);
        let [knuckle, tip, still] =
            ["knuckle", "tip", "still"].map(|name| coordinate(creature, &posture, name));
        // MuJoCo counts both from the reference posture, as the creature does.
        assert!((tip - (0.05 + 0.5 * knuckle)).abs() < 1e-12, "{knuckle} {tip}");
        assert_eq!(still, 0.25);
        let dof = creature.dofs().find(|dof| dof.name == "tip").unwrap();
        assert!(dof.range[0] - 1e-9 <= tip && tip <= dof.range[1] + 1e-9, "{tip} {:?}", dof.range);
    }
    // The leader's range ends where its follower's does: (-0.2 - 0.05) / 0.5.
    let knuckle = creature.dofs().find(|dof| dof.name == "knuckle").unwrap();
    assert!((knuckle.range[0] + 0.5).abs() < 0.01, "{:?}", knuckle.range);
    let json = serde_json::to_string(creature).unwrap();
    assert_eq!(&serde_json::from_str::<Creature>(&json).unwrap(), creature);
}

#[test]
fn who_follows_a_joint_that_is_held_is_held_as_well() {
    let body = rooted(COUPLED, "tip", None).unwrap();
    let tip = body.creature.dofs().next().unwrap();
    assert_eq!((tip.range, tip.follows), ([0.05, 0.05], None));
}

/// Three capsules on a trunk, filters as given.
fn trident(geom: &str, contact: &str) -> Body {
    creature(&format!(
        r#"<mujoco>
  <compiler angle="degree" autolimits="true"/>
  <default><geom type="capsule" size=".03" {geom}/><joint axis="0 1 0" range="-170 170"/></default>
  <worldbody>
    <geom type="plane" size="1 1 1" contype="1" conaffinity="1"/>
    <body name="trunk"><geom fromto="0 0 -.2 0 0 .2"/>
      <body name="neck" pos="0 0 .2"><joint name="neck" range="-20 20"/><geom fromto="0 0 0 0 0 .1"/>
        <body name="head" pos="0 0 .1"><joint name="head" range="-20 20"/><geom fromto="0 0 -.15 0 0 .1"/></body>
      </body>
      <body name="left" pos="0 .05 .1"><joint name="left"/><geom fromto="0 0 0 .2 -.05 0"/>
        <body name="left_hand" pos=".2 -.05 0"><joint name="left_hand"/><geom fromto="0 0 0 .2 -.02 0"/></body>
      </body>
    </body>
  </worldbody>
  {contact}
</mujoco>"#
    ))
}

fn relation(body: &Body, a: &str, b: &str) -> (Relation, bool) {
    let contact = SelfContact::new(body).unwrap();
    let limbs = [a, b].map(|name| body.creature.limb(name).unwrap());
    let pair =
        contact.pairs.into_iter().find(|pair| pair.limbs == limbs || pair.limbs == [limbs[1], limbs[0]]);
    pair.map(|pair| (pair.relation, pair.switched_on)).unwrap()
}

#[test]
fn self_contact_that_a_model_forgot_is_switched_on() {
    let open = trident("", "");
    assert_eq!(relation(&open, "trunk", "left_hand"), (Relation::Touch, false));
    assert_eq!(relation(&open, "trunk", "left"), (Relation::Neighbours, false));
    assert_eq!(relation(&open, "trunk", "head"), (Relation::Overlap, false));
    for filters in [r#"contype="0" conaffinity="0""#, r#"contype="1" conaffinity="0""#] {
        let shut = trident(filters, "");
        assert_eq!(relation(&shut, "trunk", "left_hand"), (Relation::Touch, true), "{filters}");
        assert_eq!(relation(&shut, "trunk", "head"), (Relation::Overlap, false), "{filters}");
    }
}

#[test]
fn an_exclude_holds_unless_a_limb_has_nothing_else_to_touch() {
    let one = trident("", r#"<contact><exclude body1="trunk" body2="left_hand"/></contact>"#);
    assert_eq!(relation(&one, "trunk", "left_hand"), (Relation::Excluded, false));
    assert_eq!(relation(&one, "head", "left_hand"), (Relation::Touch, false));
    let names = ["trunk", "neck", "head"];
    let all: String =
        names.iter().map(|name| format!(r#"<exclude body1="{name}" body2="left_hand"/>"#)).collect();
    let all = trident("", &format!("<contact>{all}</contact>"));
    assert_eq!(relation(&all, "trunk", "left_hand"), (Relation::Touch, true));
}

#[test]
fn a_body_that_is_tangled_where_its_joints_are_zero_starts_elsewhere() {
    let xml = |pos: &str| {
        format!(
            r#"<mujoco><compiler autolimits="true"/><worldbody><body name="trunk"><geom size=".01"/>
            <body name="a"><joint axis="0 0 1" name="a" range="-90 90"/><geom type="capsule" size=".02" fromto="0 0 0 .3 0 0"/></body>
            <body name="b" pos="{pos}"><joint axis="0 0 1" name="b" range="-90 90"/><geom type="capsule" size=".02" fromto="0 0 0 0 .3 0"/></body>
            </body></worldbody></mujoco>"#
        )
    };
    let zero = |posture: &[f64]| posture.iter().all(|&q| q == 0.0);
    let (apart, tangled) = (creature(&xml(".1 .1 0")), creature(&xml(".25 -.25 0")));
    assert!(zero(&SelfContact::new(&apart).unwrap().start));
    let contact = SelfContact::new(&tangled).unwrap();
    assert!(!zero(&contact.start));
    assert_eq!(relation(&tangled, "a", "b"), (Relation::Touch, false));
}

mod slow {
    use super::*;

    /// The engine's compiler would take all memory and time that there is.
    #[test]
    #[ignore = "slow: takes as long as the limit, 20 s"]
    fn a_file_that_keeps_the_engine_busy_is_given_up() {
        let folder = tempfile::tempdir().unwrap();
        let xml = r#"<mujoco><worldbody><body><composite type="particle" count="400 400 400" spacing="0.1">
            <geom size="0.01"/></composite></body></worldbody></mujoco>"#;
        std::fs::write(folder.path().join("endless.xml"), xml).unwrap();
        assert!(refused(folder.path(), 1, &["inspect", "endless.xml"]).contains("endless.xml"));
    }
}
