//! What `calibrate` says of a robot and its log, both ways: made robots with and without a fault, and logs that repeat themselves.

use std::f64::consts::TAU;

use crate::common::calibrating::Place;
use bodyschema::calibration::robot::{Knowledge, Posed, Robot};
use bodyschema::calibration::{
    Estimator, EstimatorOptions, Fit, Objection, Question, Touch, drop_repeats, folds, objections, split,
};
use bodyschema::session::read_robot;
use bodyschema::study::calibration::made::{Data, Fault, Made};
use nalgebra::Vector3;
use serde_json::Value as Json;

fn fitted<'a>(robot: &'a Robot, touches: &'a [Touch]) -> (Estimator<'a>, Fit, Vec<Objection>) {
    let estimator = Estimator::new(robot, touches, EstimatorOptions::default());
    let fit = estimator.fit();
    let objections = objections(&estimator, &fit, &[]);
    (estimator, fit, objections)
}

/// What is wrong is objected to and named, and nothing is where nothing is wrong, by every kind of data.
#[test]
fn verdicts_are_right_both_ways() {
    use Fault::*;
    let of_data = [
        (Data::SelfTouch, [None, Gain, SlippedMount, FewRows]),
        (Data::Plate, [None, DeadEncoder, Outliers, WrongStd]),
        (Data::Tracker, [None, Sign, Offset, Copies]),
        (Data::Place, [None, Convention, Gain, WrongStd]),
    ];
    let mut unnamed = Vec::new();
    for (data, fault) in of_data.into_iter().flat_map(|(data, faults)| faults.map(|fault| (data, fault))) {
        let made = Made::new(data, fault, 301);
        let (_, _, found) = fitted(&made.robot, &made.touches);
        assert_eq!(found.is_empty(), fault.is_harmless(), "{data}, {fault}: {found:?}");
        if let Some(name) = made.faulty {
            let about = found.iter().filter_map(|objection| objection.about.as_ref());
            if !about.into_iter().any(|about| about.contains(&name)) {
                unnamed.push(format!("{data}, {name}: {found:?}"));
            }
        }
    }
    // Mostly what is wrong is named as well; a mount that slipped may be taken for false touches.
    assert!(unnamed.len() <= 1, "{unnamed:?}");
}

#[test]
fn rows_that_repeat_count_once_and_stay_together() {
    let made = Made::new(Data::SelfTouch, Fault::None, 302);
    let mut held: Vec<Touch> = Vec::new();
    for touch in &made.touches {
        for k in 0..12 {
            let mut row = touch.clone();
            row.posture[0] += 5e-5 * f64::from(k);
            held.push(row);
        }
    }
    let rows = held.len();
    let [fitted_to, held_out] = split(&held, 0.3, 1);
    for parts in [vec![[fitted_to, held_out]], folds(&held, 5, 1)].concat() {
        let [fitted_to, held_out] = parts;
        assert!(held_out.len() > rows / 10 && fitted_to.len() + held_out.len() == rows);
        let near = |a: &Touch, b: &Touch| a.posture.iter().zip(&b.posture).all(|(a, b)| (a - b).abs() < 1e-3);
        assert!(held_out.iter().all(|a| !fitted_to.iter().any(|b| near(a, b))));
    }
    assert_eq!(drop_repeats(&mut held), rows - made.touches.len());
    assert_eq!(held, made.touches);
}

#[test]
fn stretches_of_time_are_held_out_together() {
    let mut touches = Made::new(Data::Tracker, Fault::None, 303).touches;
    for (k, touch) in touches.iter_mut().enumerate() {
        touch.time = Some(k as f64);
    }
    let [_, held_out] = split(&touches, 0.3, 1);
    let neighbours = held_out.windows(2).filter(|pair| pair[1].line == pair[0].line + 1).count();
    assert!(
        held_out.len() > 20 && neighbours * 10 > held_out.len() * 6,
        "{neighbours} of {}",
        held_out.len()
    );
}

/// An encoder's sign and a mount's turn that the touches leave open are the maker's in the end, and named.
#[test]
fn what_is_not_determined_stays_as_the_maker_has_it() {
    let mut made = Made::new(Data::SelfTouch, Fault::None, 304);
    made.robot.set_knowledge("*.sign", Knowledge::Free).unwrap();
    made.robot.set_knowledge("left_base.mount.position", Knowledge::Free).unwrap();
    let (_, fit, found) = fitted(&made.robot, &made.touches);
    assert!(found.is_empty(), "{found:?}");
    for (q, quantity) in made.robot.quantities.iter().enumerate() {
        if quantity.name.ends_with(".sign") || quantity.name.starts_with("left_base.mount") {
            assert_eq!(fit.values[q], quantity.nominal, "{}", quantity.name);
        }
    }
}

/// What is said of an offset counts, and where the touches speak against it that is said.
#[test]
fn a_prior_that_touches_contradict_is_an_objection() {
    let mut made = Made::new(Data::SelfTouch, Fault::None, 305);
    made.robot.set_knowledge("*.offset", Knowledge::Near(0.05)).unwrap();
    assert!(fitted(&made.robot, &made.touches).2.is_empty());
    made.robot.set_knowledge("*.offset", Knowledge::Near(0.002)).unwrap();
    let (_, _, found) = fitted(&made.robot, &made.touches);
    let about = found.iter().find(|found| found.question == Question::Prior).and_then(|o| o.about.clone());
    assert!(about.is_some_and(|about| about.ends_with(".offset")), "{found:?}");
}

#[test]
fn lengths_that_shrink_onto_what_is_touched_are_no_calibration() {
    let mut made = Made::new(Data::Plate, Fault::None, 306);
    made.robot.set_knowledge("*.a", Knowledge::Free).unwrap();
    made.robot.set_knowledge("*.d", Knowledge::Free).unwrap();
    let floor = made.robot.surface("floor").unwrap();
    made.touches.retain(|touch| touch.ends[1][0].feature == bodyschema::calibration::Feature::Surface(floor));
    let (_, fit, found) = fitted(&made.robot, &made.touches);
    // Either that is said, or lengths are what they are.
    for (q, quantity) in made.robot.quantities.iter().enumerate() {
        if [".a", ".d"].iter().any(|end| quantity.name.ends_with(end)) {
            let off = (fit.values[q].number() - made.truth[q].number()).abs();
            assert!(!found.is_empty() || off < 5e-3, "{} is {off} m off", quantity.name);
        }
    }
}

/// Two arms of two joints in a plane, as a table.
const PLANAR: &str = "joint,a,d,alpha,theta,parent,link\n\
    p,0.3,0,0,0,base,arm_p\nq,0.2,0,0,0,arm_p,hand_p\nr,0.25,0,0,0,base,arm_r\ns,0.2,0,0,0,arm_r,hand_r\n";

/// Where the hands of [`PLANAR`] are.
fn planar(angles: [f64; 4]) -> [Vector3<f64>; 2] {
    let reach = |[a, b]: [f64; 2], [first, second]: [f64; 2]| {
        Vector3::new(
            a * first.cos() + b * (first + second).cos(),
            a * first.sin() + b * (first + second).sin(),
            0.0,
        )
    };
    [reach([0.3, 0.2], [angles[0], angles[1]]), reach([0.25, 0.2], [angles[2], angles[3]])]
}

/// Angles that are spread and never repeat.
fn angle(row: usize, joint: usize) -> f64 {
    let golden = [0.618_034, 0.754_878, 0.569_840, 0.819_173][joint];
    TAU * (0.4 * ((row + 1) as f64 * golden).fract() - 0.2)
}

#[test]
fn a_distance_between_two_points_is_a_measurement() {
    let place = Place::new();
    place.write("two.csv", PLANAR);
    let mut log = String::from("limb_a,limb_b,ax,ay,az,bx,by,bz,distance_mm,p,q,r,s\n");
    for row in 0..60 {
        let angles: [f64; 4] = std::array::from_fn(|joint| angle(row, joint));
        let [a, b] = planar([angles[0], angles[1] + 0.03, angles[2], angles[3]]);
        log += &format!("hand_p,hand_r,0,0,0,0,0,0,{}", 1e3 * (a - b).norm());
        log += &angles.map(|x| format!(",{x}")).concat();
        log.push('\n');
    }
    place.write("log.csv", &log);
    let found = place.json(&["two.csv", "log.csv", "--free", "q.theta"]);
    assert!((found["quantities"][0]["after"].as_f64().unwrap() - 0.03).abs() < 1e-6, "{found}");
    assert_eq!(found["calibrated"], true, "{}", found["verdict"]);
    assert!(found["after"]["rms"].as_f64().unwrap() < 1e-6);
}

/// A tip in sockets that are known, nearly known or not at all, which a log names.
#[test]
fn places_of_a_log_are_known_near_or_free() {
    let place = Place::new();
    place.write("two.csv", PLANAR);
    let sockets: Vec<Vector3<f64>> =
        (0..4).map(|k| planar([angle(k, 0), angle(k, 1) + 0.4, 0.0, 0.0])[0]).collect();
    let log = |said: bool| {
        let mut log = String::from("limb_a,place,ax,ay,az,bx,by,bz,p,q\n");
        for (k, at) in sockets.iter().enumerate() {
            // Both ways to have the elbow reach a socket, for tips of several lengths.
            for tip in 0..4 {
                let out = 0.2 + 0.02 * f64::from(tip);
                let far = at.norm();
                let elbow = ((far * far - 0.09 - out * out) / (0.6 * out)).clamp(-1.0, 1.0).acos();
                for elbow in [elbow, -elbow] {
                    let shoulder = at.y.atan2(at.x) - (out * elbow.sin()).atan2(0.3 + out * elbow.cos());
                    let there = if said { format!("{},{},0", at.x, at.y) } else { ",,".into() };
                    let (p, q) = (shoulder - 0.05, elbow - 0.02);
                    log += &format!("hand_p,socket{k},{},0,0,{there},{p},{q}\n", out - 0.2);
                }
            }
        }
        log
    };
    place.write("known.csv", log(true));
    place.write("free.csv", log(false));
    let theta = |found: &Json, name: &str| {
        let quantities = found["quantities"].as_array().unwrap();
        let of =
            quantities.iter().find(|quantity| quantity["name"] == name).unwrap_or_else(|| panic!("{found}"));
        of["after"].as_f64().unwrap()
    };
    let known = place.json(&["two.csv", "known.csv", "--free", "p.theta", "--free", "q.theta"]);
    assert_eq!(known["calibrated"], true, "{}", known["verdict"]);
    assert!((theta(&known, "p.theta") - 0.05).abs() < 1e-6 && (theta(&known, "q.theta") - 0.02).abs() < 1e-6);
    // Of sockets that stand nobody knows where, the elbow is still determined.
    let free = place.json(&["two.csv", "free.csv", "--free", "q.theta"]);
    assert!((theta(&free, "q.theta") - 0.02).abs() < 1e-4, "{free}");
    let near = place.json(&["two.csv", "known.csv", "--free", "q.theta", "--prior", "socket*.position=5mm"]);
    assert_eq!(near["quantities"].as_array().unwrap().len(), 5, "{near}");
    place.fails(&["two.csv", "known.csv", "--prior", "socket*.position=5"], &["socket0.position", "unit"]);
    let both = |(number, line): (usize, &str)| {
        let mut cells: Vec<&str> = line.split(',').collect();
        cells.insert(2, ["limb_b", "base", ""][number.min(2)]);
        cells.join(",") + "\n"
    };
    place.write("both.csv", log(true).lines().enumerate().map(both).collect::<String>());
    place.fails(&["two.csv", "both.csv"], &["line 2", "both socket0 and base"]);
}

/// A joint that mimics one that mimics another goes along with the last, by all multipliers and offsets on the way.
#[test]
fn a_mimic_of_a_mimic_follows_its_leader() {
    let place = Place::new();
    let joint = |name: &str, parent: &str, axis: &str, mimic: &str| {
        format!(
            "<joint name=\"{name}\" type=\"revolute\"><parent link=\"{parent}\"/><child link=\"{name}_link\"/>{mimic}\
             <origin xyz=\"0 0 0.3\"/><axis xyz=\"{axis}\"/><limit lower=\"-2\" upper=\"2\" effort=\"1\" velocity=\"1\"/></joint>\
             <link name=\"{name}_link\"/>\n"
        )
    };
    let urdf = format!(
        "<robot name=\"arm\"><link name=\"base\"/>\n{}{}{}</robot>",
        joint("j2", "base", "0 1 0", ""),
        joint("j4", "j2_link", "1 0 0", "<mimic joint=\"j3\" multiplier=\"2\"/>"),
        joint("j3", "j4_link", "0 1 0", "<mimic joint=\"j2\" multiplier=\"-0.5\" offset=\"0.2\"/>"),
    );
    place.write("robot.urdf", &urdf);
    let file = read_robot(&place.path("robot.urdf")).unwrap();
    let (robot, values) = (&file.robot, file.robot.nominal());
    let q = robot.dofs[robot.dof("j4").unwrap()].quantities.unwrap();
    assert_eq!((values[q.gain].number(), values[q.offset].number()), (-1.0, 0.4));
    assert_eq!(Posed::new(robot, &values, &[0.3]).actual(robot.dof("j4").unwrap()), 0.4 - 0.3);
    // What did not change is as it was.
    assert_eq!(file.with_values(&place.path("robot.urdf"), &values).unwrap().bytes, urdf.as_bytes());
    let circle = urdf.replace("joint=\"j2\"", "joint=\"j4\"");
    place.write("circle.urdf", circle);
    assert!(read_robot(&place.path("circle.urdf")).is_err());
}

#[test]
fn a_deviation_without_a_unit_is_refused() {
    let place = Place::new();
    place.write("two.csv", PLANAR);
    place.write("log.csv", "limb_a,limb_b,ax,ay,az,bx,by,bz,p,q\nhand_p,base,0,0,0,0.5,0,0,0,0\n");
    place.fails(&["two.csv", "log.csv", "--prior", "q.theta=5"], &["q.theta", "unit", "5deg"]);
    place.fails(&["two.csv", "log.csv", "--prior", "q.a=5"], &["q.a", "unit", "5mm"]);
    place.fails(&["two.csv", "log.csv", "--places", "1"], &["--places", "1mm"]);
    // A ratio has none.
    let found = place.json(&["two.csv", "log.csv", "--prior", "q.gain=0.01"]);
    let verdict = found["verdict"].as_str().unwrap();
    assert!(verdict.contains("too few rows: 1, but at least"), "{verdict}");
}
