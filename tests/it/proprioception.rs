//! What tells an agent its posture: the joint sensors of the model, cutoff and noise among it, and the posture itself
//! where there are none; and how often the `touch` sensor of a receptor fires with the contact that it is taken to feel.

use std::sync::Arc;

use bodyschema::creature::{Body, JointSelection};
use bodyschema::mujoco::{Data, Model, Sensor, SensorKind};
use bodyschema::senses::{ContactReader, FAINT, RecordedTouch, joint_sensors};
use serde_json::Value;

use crate::common::program::succeeds;
use crate::common::{babble, max, repository, take, with_agent};

/// How far the sensors of a copy of Max tell an angle, radians.
const CUTOFF: f64 = 0.25;
/// How exactly a clipped angle is the cutoff, radians: it is told as a difference.
const EXACTLY: f64 = 1e-12;

/// Max's file with its joint sensors changed.
fn max_with(change: impl Fn(&str) -> String) -> String {
    std::fs::read_to_string(repository("mjcf/max/max.xml"))
        .unwrap()
        .lines()
        .map(|line| change(line) + "\n")
        .collect()
}

/// Max whose joint sensors have these attributes as well.
fn max_sensing(attributes: &str) -> String {
    max_with(|line| line.replace("<jointpos ", &format!("<jointpos {attributes} ")))
}

fn max_without_joint_sensors() -> String {
    max_with(|line| if line.contains("<jointpos ") { String::new() } else { line.to_string() })
}

/// The torso of a Max from text, and its touches.
fn touches(xml: &str, jobs: usize) -> (Body, Vec<RecordedTouch>) {
    let model = Arc::new(Model::from_xml(xml).unwrap());
    let (body, agent) = with_agent(Body::new(model, &"torso".parse::<JointSelection>().unwrap()).unwrap());
    let touches = babble(&body, &agent, 30, 1, jobs);
    (body, touches)
}

#[test]
fn joint_sensors_with_a_cutoff_tell_clipped_angles() {
    let (_, exact) = touches(&max_with(str::to_string), 1);
    let (body, clipped) = touches(&max_sensing(&format!("cutoff=\"{CUTOFF}\"")), 1);
    assert!(joint_sensors(&body).iter().all(|sensor| sensor.as_ref().unwrap().cutoff == Some(CUTOFF)));
    let mut beyond = 0;
    for (exact, clipped) in exact.iter().zip(&clipped) {
        assert_eq!(exact.ends, clipped.ends, "what is touched is the same");
        for (really, told) in exact.posture.iter().zip(&clipped.posture) {
            assert!((told - really.clamp(-CUTOFF, CUTOFF)).abs() < EXACTLY, "{really} is told as {told}");
            beyond += usize::from(really.abs() > CUTOFF);
        }
    }
    assert!(beyond > exact.len(), "{beyond} angles of {} touches are beyond the cutoff", exact.len());
}

#[test]
fn without_joint_sensors_the_posture_itself_is_felt() {
    let (body, without) = touches(&max_without_joint_sensors(), 1);
    assert!(joint_sensors(&body).iter().all(Option::is_none));
    let (body, with) = touches(&max_with(str::to_string), 1);
    assert!(joint_sensors(&body).iter().all(Option::is_some));
    assert_eq!(with, without, "sensors that tell all tell the posture to the last bit");
}

#[test]
fn noise_of_joint_sensors_is_felt_where_it_is_enabled_and_does_not_depend_on_threads() {
    let deviation = 0.01;
    let noisy = max_sensing(&format!("noise=\"{deviation}\""));
    let (_, exact) = touches(&max_with(str::to_string), 1);
    assert_eq!(touches(&noisy, 1).1, exact, "noise that is not enabled is none");
    let enabled = noisy.replace("<option ", "<option><flag sensornoise=\"enable\"/></option><option ");
    if !bodyschema::mujoco::schema().unwrap().contains("sensornoise") {
        // Newer engines have no noise of sensors: the file is read without it.
        assert_eq!(touches(&enabled, 1).1, exact);
        return;
    }
    let (_, felt) = touches(&enabled, 1);
    assert_eq!(felt, touches(&enabled, 2).1);
    let off = exact.iter().zip(&felt).flat_map(|(a, b)| a.posture.iter().zip(&b.posture).map(|(a, b)| b - a));
    let off: Vec<f64> = off.collect();
    let spread = (off.iter().map(|x| x * x).sum::<f64>() / off.len() as f64).sqrt();
    assert!((spread / deviation - 1.0).abs() < 0.1, "{spread} rad rather than {deviation}");
}

#[test]
fn inspect_says_what_tells_the_posture() {
    let place = tempfile::tempdir().unwrap();
    for (text, sentence, sensed) in [
        (max_with(str::to_string), "read from 103 joint sensors", 103),
        (max_sensing("cutoff=\"0.25\""), "103 of them have a cutoff", 103),
        (max_without_joint_sensors(), "no joint has a sensor", 0),
    ] {
        std::fs::write(place.path().join("copy.xml"), text).unwrap();
        assert!(succeeds(place.path(), &["inspect", "copy.xml"]).contains(sentence), "{sentence}");
        let told: Value =
            serde_json::from_str(&succeeds(place.path(), &["inspect", "copy.xml", "--json"])).unwrap();
        let sensors = &told["joint_sensors"];
        assert_eq!(sensors["sensed"].as_array().unwrap().len(), sensed, "{sentence}");
        assert_eq!(sensors["posture_itself"].as_array().unwrap().len(), 103 - sensed, "{sentence}");
    }
}

/// Of the ends of touches without forces, the share whose receptor's own sensor fires: a contact that has only just begun
/// presses on hardly anything, and the engine's soft contacts often give it no force at all.
const ONSETS: [f64; 2] = [0.35, 0.7];

#[test]
fn receptors_fire_as_hard_as_their_own_touch_sensors_read() {
    let (body, agent) = with_agent(max("torso"));
    let reader = ContactReader::new(&body, agent.skin());
    let mut data = Data::new(body.model.clone()).unwrap();
    let sensor = |receptor: usize| {
        let id = &agent.skin().receptors[receptor].id;
        let on = |s: &Sensor| {
            s.kind == SensorKind::Touch && body.model.site(s.id.unwrap()).name == Some(id.as_str())
        };
        body.model.sensors().find(on).expect("all of Max's receptors have sensors").adr
    };
    let (mut ends, mut fired, mut felt_at_all, mut read) = (0, 0, 0, 0);
    for touch in babble(&body, &agent, 200, 1, 2) {
        take(&body, &mut data, &touch.posture);
        data.forward().unwrap();
        let felt = reader.skin_contacts(&body, agent.skin(), &data);
        let fires =
            |receptor: usize| felt.iter().flat_map(|c| c.spots()).any(|spot| spot.receptor == receptor);
        for contact in &felt {
            let reading = data.sensordata()[sensor(contact.spot.receptor)];
            (felt_at_all, read) = (felt_at_all + 1, read + usize::from(contact.force == reading));
            assert!(contact.force == reading || reading < FAINT, "{} N are {reading} N", contact.force);
        }
        ends += 2;
        fired += touch.ends.iter().filter(|end| fires(end.receptor)).count();
    }
    let onsets = fired as f64 / f64::from(ends);
    assert!((ONSETS[0]..=ONSETS[1]).contains(&onsets), "{onsets} of {ends} ends of touches");
    assert!(4 * read > 3 * felt_at_all, "sensors read {read} of {felt_at_all}");
}

/// A ball that a block is pressed against from below. Two patches hold the point, and the nearer one is sunk below the
/// surface, where the engine's sensor reads nothing.
const SUNK: &str = r#"<mujoco>
  <compiler angle="radian" autolimits="true"/>
  <option gravity="0 0 9.81"/>
  <worldbody>
    <geom pos="0 0 .149" size=".05"/>
    <body name="block"><freejoint/><geom type="box" size=".1 .1 .1"/>
      <site name="sunk" type="box" size=".02 .02 .001" pos="0 0 .09"/>
      <site name="flush" type="box" size=".05 .05 .001" pos=".02 0 .1"/>
      <body name="arm" pos=".5 0 0"><joint axis="0 1 0" range="-1 1"/><geom size=".05"/></body>
    </body>
  </worldbody>
  <sensor>SENSORS</sensor>
</mujoco>"#;

#[test]
fn which_of_two_receptors_fires_is_what_their_sensors_say_and_if_none_reads_the_nearest() {
    for (sensors, fires) in [
        ("<touch site=\"sunk\"/><touch site=\"flush\"/>", vec!["flush"]),
        ("<touch site=\"flush\"/>", vec!["flush"]),
        ("<touch site=\"sunk\"/>", vec!["sunk"]),
    ] {
        let model = Arc::new(Model::from_xml(&SUNK.replace("SENSORS", sensors)).unwrap());
        let (body, agent) = with_agent(Body::new(model.clone(), &JointSelection::All).unwrap());
        // In the body's own model nothing but the body collides.
        let mut data = Data::new(model).unwrap();
        data.forward().unwrap();
        let reader = ContactReader::new(&body, agent.skin());
        let felt = reader.skin_contacts(&body, agent.skin(), &data);
        let felt: Vec<&str> =
            felt.iter().map(|c| agent.skin().receptors[c.spot.receptor].id.as_str()).collect();
        assert_eq!(felt, fires, "{sensors}");
    }
}
