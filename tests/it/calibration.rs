//! Robots put right by their own touches: the estimator against the truth and against an independent one, files in and out, and
//! what engineers get wrong.

use std::fs;

use crate::common::calibrating::{Place, double, falsify};
use crate::common::{at_random, repository};
use bodyschema::agent::Agent;
use bodyschema::calibration::robot::{Element, Form, Knowledge, Mover, Posed, Robot, Unit, Value};
use bodyschema::calibration::{
    End, Estimator, EstimatorOptions, Feature, Fit, Noise, Seen, Touch, add_places, judge, plan, split,
};
use bodyschema::creature::DofKind;
use bodyschema::geometry::Frame;
use bodyschema::session::simulated::{add_joint_noise, add_point_noise, misread, point_touches};
use bodyschema::session::{calibration_table, read_calibration_log, read_robot};
use nalgebra::{Rotation3, Vector3};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use serde_json::Value as Json;

/// The robot of the examples, and exact touches of it.
fn arms(touches: usize) -> (Robot, Vec<Touch>) {
    let path = repository("examples/robot/arms.urdf");
    let robot = read_robot(&path).unwrap().robot;
    let babbled = Agent::from_mjcf(&path).unwrap().babble_as(&at_random(touches)).unwrap();
    let embodied = babbled.embodied();
    let touches = point_touches(embodied.agent(), &embodied.truth().schema, &robot, babbled.touches());
    (robot, touches)
}

/// Encoders that are off: by up to 10° and 5 %, in either sense where signs are unknown, too. What is unknown is said to be.
fn off(robot: &mut Robot, seed: u64, signs: bool) -> Vec<Value> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let mut truth = robot.nominal();
    for q in robot.dofs.iter().filter_map(|dof| dof.quantities) {
        truth[q.offset] = Value::Number(rng.random_range(-0.17..0.17));
        truth[q.gain] = Value::Number(rng.random_range(0.95..1.05));
        let sign = if rng.random_bool(0.5) { 1.0 } else { -1.0 };
        truth[q.sign] = Value::Number(if signs { sign } else { 1.0 });
    }
    for pattern in ["*.offset", "*.gain"].into_iter().chain(signs.then_some("*.sign")) {
        robot.set_knowledge(pattern, Knowledge::Free).unwrap();
    }
    truth
}

/// The greatest difference of any number, and of any direction or turn the angle.
fn worst(values: &[Value], truth: &[Value]) -> f64 {
    values.iter().zip(truth).map(|(a, b)| a.distance(b)).fold(0.0, f64::max)
}

#[test]
fn twists_are_the_derivatives_of_poses() {
    const STEP: f64 = 1e-6;
    let mut robot = Robot::new("r", "base");
    let quantity = |robot: &mut Robot, name: &str, unit, value| robot.add_quantity(name, unit, value);
    let shift = quantity(&mut robot, "s", Unit::Metre, Value::Position(Vector3::new(0.1, -0.2, 0.3)));
    let turn = Rotation3::new(Vector3::new(0.3, -0.5, 0.2)).into_inner();
    let turn = quantity(&mut robot, "t", Unit::Radian, Value::Orientation(turn));
    let along = quantity(&mut robot, "a", Unit::Metre, Value::Number(0.15));
    let about = quantity(&mut robot, "b", Unit::Radian, Value::Number(0.7));
    let hinge = robot.add_dof("h", DofKind::Hinge, [-2.0, 2.0], Vector3::new(0.6, 0.0, 0.8));
    let slide = robot.add_dof("l", DofKind::Slide, [0.0, 1.0], Vector3::new(0.0, 0.6, 0.8));
    let elements = [
        Element::Shift(shift),
        Element::Turn(turn),
        Element::Dof(hinge),
        Element::ShiftAlong(0, along),
        Element::TurnAbout(1, about),
        Element::Dof(slide),
    ];
    let tip = robot.add_link("tip", 0, elements.to_vec());
    let q = robot.dofs[hinge].quantities.unwrap();
    let mut values = robot.nominal();
    values[q.sign] = Value::Number(-1.0);
    values[q.gain] = Value::Number(1.1);
    let p = Vector3::new(0.05, 0.02, -0.04);
    let posture = [0.4, 0.3];
    let at = |values: &[Value]| Posed::new(&robot, values, &posture).frame(&[tip]).point(&p);
    let mut slopes = Vec::new();
    Posed::new(&robot, &values, &posture).walk(&[tip], |mover, twist| {
        if let Mover::Parameter(quantity, part) = mover {
            slopes.push((quantity, part, twist.at(&at(&values))));
        }
    });
    // Three of the shift, three of the turn, one each of the numbers, five of either degree of freedom.
    assert_eq!(slopes.len(), 3 + 3 + 1 + 1 + 5 + 5);
    for (quantity, part, slope) in slopes {
        let moved = |size: f64| {
            let mut step = [0.0; 3];
            step[part] = size;
            let mut other = values.clone();
            other[quantity] = values[quantity].stepped(&step[..values[quantity].size()]);
            at(&other)
        };
        // Nothing weighs on joints here.
        if robot.quantities[quantity].name.ends_with("compliance") {
            assert_eq!(slope, Vector3::zeros());
            continue;
        }
        let numeric = (moved(STEP) - moved(-STEP)) / (2.0 * STEP);
        assert!((numeric - slope).norm() < 1e-8, "{}: {slope} {numeric}", robot.quantities[quantity].name);
    }
}

#[test]
fn encoders_are_put_right_signs_and_all() {
    let (mut robot, mut touches) = arms(400);
    let truth = off(&mut robot, 3, true);
    misread(&robot, &truth, &mut touches);
    let estimator = Estimator::new(&robot, &touches, EstimatorOptions::default());
    let fit = estimator.fit();
    assert!(worst(&fit.values, &truth) < 1e-8, "{}", worst(&fit.values, &truth));
    assert!(fit.told.ties.is_empty());
    assert!(fit.untold_signs.is_empty());
}

#[test]
fn what_cannot_be_told_apart_is_named() {
    let (mut robot, mut touches) = arms(300);
    let truth = off(&mut robot, 4, false);
    misread(&robot, &truth, &mut touches);
    // A wrist that is off looks like a hand that is mounted turned about its axis.
    robot.set_knowledge("left_hand.mount.*", Knowledge::Free).unwrap();
    let estimator = Estimator::new(&robot, &touches, EstimatorOptions::default());
    let fit = estimator.fit();
    let untold = fit.told.untold(&robot, &estimator.unknowns);
    assert_eq!(untold.len(), 1, "{untold:?}");
    let names = ["left_hand.mount.orientation", "left_hand.mount.position", "left_wrist.offset"];
    for name in names.iter().filter(|name| !name.ends_with("position")) {
        assert!(untold[0].names.contains(&name.to_string()), "{untold:?}");
    }
    assert_eq!(untold[0].ways, 1);
    // All else is.
    let right = robot.quantity("right_wrist.offset").unwrap();
    assert!(fit.values[right].distance(&truth[right]) < 1e-8);
    let left = estimator.unknowns.place(robot.quantity("left_wrist.offset").unwrap(), 0).unwrap();
    assert_eq!(fit.told.deviation(left), f64::INFINITY);
}

/// The error of encoders, root mean square in radians, from touches with noise of 1 mm.
fn error_of(spoil: impl Fn(&Robot, &mut Vec<Touch>, &mut ChaCha8Rng)) -> (f64, Fit) {
    let (mut robot, mut touches) = arms(500);
    let truth = off(&mut robot, 5, false);
    let mut rng = ChaCha8Rng::seed_from_u64(5);
    add_point_noise(&mut touches, 1e-3, &mut rng);
    spoil(&robot, &mut touches, &mut rng);
    misread(&robot, &truth, &mut touches);
    let estimator = Estimator::new(&robot, &touches, EstimatorOptions::default());
    let fit = estimator.fit();
    let offsets = robot.dofs.iter().filter_map(|dof| dof.quantities).map(|q| q.offset);
    let squares: Vec<f64> = offsets.map(|q| fit.values[q].distance(&truth[q]).powi(2)).collect();
    ((squares.iter().sum::<f64>() / squares.len() as f64).sqrt(), fit)
}

#[test]
fn false_touches_and_unpaired_contacts_cost_little() {
    let (clean, fit) = error_of(|_, _, _| {});
    assert_eq!(fit.noise.false_share, 0.0);
    let (spoiled, fit) = error_of(|robot, touches, rng| {
        double(robot, &robot.nominal(), touches, rng);
        falsify(touches, 0.2, rng);
    });
    // A second contact tells something, too.
    assert!(spoiled < 1.3 * clean, "{spoiled} {clean}");
    assert!((0.05..0.35).contains(&fit.noise.false_share), "{}", fit.noise.false_share);
    // It is much worse for who takes every touch for honest.
    let (mut robot, mut touches) = arms(500);
    let truth = off(&mut robot, 5, false);
    falsify(&mut touches, 0.2, &mut ChaCha8Rng::seed_from_u64(5));
    misread(&robot, &truth, &mut touches);
    let options = EstimatorOptions { false_touches: false, ..EstimatorOptions::default() };
    let fit = Estimator::new(&robot, &touches, options).fit();
    assert!(worst(&fit.values, &truth) > 10.0 * clean);
}

#[test]
fn what_is_nearly_known_weighs_as_much_as_it_should() {
    let golden: Json =
        serde_json::from_str(&fs::read_to_string(repository("tests/it/models/map.json")).unwrap()).unwrap();
    let place = Place::new();
    // The description says where joints nearly are, and how nearly.
    let mut robot = golden["robot"].clone();
    let mut prior = serde_json::Map::new();
    for (joint, known) in
        robot["joints"].as_array_mut().unwrap().iter_mut().zip(golden["known"]["joints"].as_array().unwrap())
    {
        let axis = &known["axes"][0];
        assert_eq!((&joint["name"], &joint["dofs"][0]["name"]), (&known["joint"], &axis["dof"]));
        (joint["position"], joint["dofs"][0]["axis"]) = (known["position"].clone(), axis["axis"].clone());
        let named = |name: &Json, of: &str| format!("{}.{of}", name.as_str().unwrap());
        prior.insert(named(&known["joint"], "position"), known["position_std"].clone());
        prior.insert(named(&axis["dof"], "axis"), axis["axis_std"].clone());
    }
    robot["prior"] = prior.into();
    place.write("robot.json", robot.to_string());
    place.write("touches.csv", golden["log"].as_str().unwrap());
    let found = place.json(&["robot.json", "touches.csv", "--false-touches", "no"]);
    let numbers = |name: &str| -> Vec<f64> {
        let quantities = found["quantities"].as_array().unwrap();
        let quantity = quantities.iter().find(|quantity| quantity["name"] == name).unwrap();
        quantity["after"].as_array().unwrap().iter().map(|x| x.as_f64().unwrap()).collect()
    };
    // The independent estimate is of greatest posterior at its own noise; positions to a tenth of their deviations.
    for (name, expected) in golden["map"].as_object().unwrap() {
        for (x, y) in numbers(name).iter().zip(expected.as_array().unwrap()) {
            assert!((x - y.as_f64().unwrap()).abs() < 2e-5, "{name}: {:?} {expected}", numbers(name));
        }
    }
    let noise = found["noise"]["points"][0].as_f64().unwrap();
    let expected = golden["noise"].as_f64().unwrap();
    assert!((noise / expected - 1.0).abs() < 0.02, "{noise} {expected}");
}

/// Two fingers of three joints whose tips are spheres, by which alone they feel each other.
#[test]
fn spheres_that_touched_calibrate_a_hand() {
    let mut robot = Robot::new("hand", "palm");
    let mut tips = Vec::new();
    for (finger, y) in [("thumb", -0.03), ("index", 0.03)] {
        let mut link = 0;
        let lengths = [Vector3::new(0.0, y, 0.0), Vector3::new(0.0, 0.0, 0.04), Vector3::new(0.0, 0.0, 0.03)];
        let axes = [Vector3::x(), Vector3::y(), Vector3::x()];
        for (k, (at, axis)) in lengths.into_iter().zip(axes).enumerate() {
            let name = format!("{finger}{k}");
            let shift = robot.add_quantity(format!("{name}.position"), Unit::Metre, Value::Position(at));
            let dof = robot.add_dof(&name, DofKind::Hinge, [-1.5, 1.5], axis);
            link = robot.add_link(name, link, vec![Element::Shift(shift), Element::Dof(dof)]);
        }
        let pose = Frame { origin: Vector3::new(0.0, 0.0, 0.025), ..Frame::identity() };
        tips.push(robot.add_sphere(&format!("{finger}_tip"), link, pose, 0.008));
    }
    let truth = robot.nominal();
    let touches = meetings(&robot, &truth, [tips[0], tips[1]], 150);
    robot.set_knowledge("thumb_tip.radius", Knowledge::Free).unwrap();
    robot.set_knowledge("*.offset", Knowledge::Near(0.1)).unwrap();
    let mut rng = ChaCha8Rng::seed_from_u64(1);
    for quantity in robot.quantities.iter_mut().filter(|quantity| quantity.is_open()) {
        let number = quantity.nominal.number();
        let size = if quantity.unit == Unit::Metre { 2e-3 } else { 0.05 };
        quantity.nominal = Value::Number(number + rng.random_range(-size..size));
    }
    let estimator = Estimator::new(&robot, &touches, EstimatorOptions::default());
    let fit = estimator.fit();
    let radius = robot.quantity("thumb_tip.radius").unwrap();
    assert!((fit.values[radius].number() - 0.008).abs() < 1e-6, "{:?}", fit.values[radius]);
    let seen = estimator.seen(&fit.values, &fit.noise);
    assert!(seen.iter().map(Seen::apart).fold(0.0, f64::max) < 1e-7);
}

/// Postures in which two surfaces just touch: random ones, put right along their gap's slope.
fn meetings(robot: &Robot, values: &[Value], surfaces: [usize; 2], count: usize) -> Vec<Touch> {
    let mut rng = ChaCha8Rng::seed_from_u64(2);
    let features = surfaces.map(Feature::Surface);
    let mut touches = Vec::new();
    while touches.len() < count {
        let mut posture: Vec<f64> =
            robot.dofs.iter().map(|dof| rng.random_range(dof.range[0]..dof.range[1])).collect();
        for _ in 0..50 {
            let posed = Posed::new(robot, values, &posture);
            let gap = posed.residuals([&features[0], &features[1]], 0.0, &|_, _| None);
            let slope = gap.by_dof.iter().map(|(_, slope)| slope.x * slope.x).sum::<f64>();
            for (dof, by) in &gap.by_dof {
                posture[*dof] -= (gap.value.x * by.x / slope.max(1e-9)).clamp(-0.3, 0.3);
            }
        }
        let gap = Posed::new(robot, values, &posture).miss([&features[0], &features[1]], 0.0).1.x;
        let within = robot.dofs.iter().zip(&posture).all(|(dof, q)| (dof.range[0]..dof.range[1]).contains(q));
        if gap.abs() < 1e-13 && within {
            let end = |k: usize| vec![End { feature: features[k], deviation: None }];
            touches.push(Touch {
                line: touches.len() + 2,
                posture,
                ends: [end(0), end(1)],
                distance: 0.0,
                time: None,
            });
        }
    }
    touches
}

/// An arm that presses on a plate, with joints that give way to its own weight.
#[test]
fn joints_that_give_way_are_found() {
    let mut robot = Robot::new("arm", "base");
    let mut link = 0;
    for (k, (at, axis)) in [
        (Vector3::new(0.0, 0.0, 0.1), Vector3::z()),
        (Vector3::zeros(), Vector3::y()),
        (Vector3::x() * 0.3, Vector3::y()),
    ]
    .into_iter()
    .enumerate()
    {
        let name = format!("j{k}");
        let shift = robot.add_quantity(format!("{name}.position"), Unit::Metre, Value::Position(at));
        let dof = robot.add_dof(&name, DofKind::Hinge, [-1.2, 1.2], axis);
        link = robot.add_link(name, link, vec![Element::Shift(shift), Element::Dof(dof)]);
        let centre = Vector3::new(0.15, 0.0, 0.0);
        robot.masses.push(bodyschema::calibration::robot::LinkMass { link, mass: 2.0, centre });
    }
    let tip = robot.add_place("tip", link, Vector3::x() * 0.25);
    let plate = robot.add_surface("plate", 0, Frame::identity(), Form::Plane);
    let mut truth = robot.nominal();
    for (name, value) in
        [("j1.compliance", 2e-3), ("j2.compliance", 4e-3), ("j1.offset", 0.03), ("j2.offset", -0.02)]
    {
        robot.set_knowledge(name, Knowledge::Free).unwrap();
        truth[robot.quantity(name).unwrap()] = Value::Number(value);
    }
    // Touches of the plate by heights: what is read is where the arm is told to go, and it hangs lower.
    let mut rng = ChaCha8Rng::seed_from_u64(7);
    let features = [Feature::Point(tip, Vector3::zeros()), Feature::Surface(plate)];
    let touches: Vec<Touch> = (0..60)
        .map(|line| {
            let posture: Vec<f64> = (0..3).map(|_| rng.random_range(-1.0..1.0)).collect();
            let height = Posed::new(&robot, &truth, &posture).miss([&features[0], &features[1]], 0.0).1.x;
            let end = |k: usize| vec![End { feature: features[k], deviation: None }];
            Touch { line, posture, ends: [end(0), end(1)], distance: height, time: None }
        })
        .collect();
    let fit = Estimator::new(&robot, &touches, EstimatorOptions::default()).fit();
    assert!(worst(&fit.values, &truth) < 1e-6, "{}", worst(&fit.values, &truth));
}

#[test]
fn a_plan_tells_more_than_chance() {
    let (mut robot, touches) = arms(1500);
    robot.set_knowledge("*.offset", Knowledge::Free).unwrap();
    let estimator = Estimator::new(&robot, &touches, EstimatorOptions::default());
    let noise = estimator.noise(1e-3, 1.7e-3);
    let told = |touches: &[Touch]| {
        let estimator = Estimator::new(&robot, touches, EstimatorOptions::default());
        let seen = estimator.seen(&robot.nominal(), &noise);
        let covariance = estimator.information(&seen, &noise, false).try_inverse().unwrap();
        covariance.diagonal().iter().map(|variance| variance.ln()).sum::<f64>()
    };
    let chosen = plan(&estimator, &robot.nominal(), &noise, 20);
    let planned: Vec<Touch> =
        chosen.touches.iter().map(|planned| touches[planned.candidate].clone()).collect();
    assert!(told(&planned) < told(&touches[..120]), "{} {}", told(&planned), told(&touches[..120]));
    assert!(chosen.touches.iter().all(|planned| planned.gain > 0.0 && planned.tells.1 > 1.0));
    // It comes near what no choice can better, and to what takes more touches at random.
    assert!((0.9..1.0).contains(&(chosen.floor / chosen.predicted)), "{} {}", chosen.floor, chosen.predicted);
    assert!(chosen.at_random.is_none_or(|count| count > 30), "{:?}", chosen.at_random);
}

#[test]
fn intervals_hold_what_they_say() {
    let (mut robot, mut touches) = arms(600);
    let truth = off(&mut robot, 6, false);
    misread(&robot, &truth, &mut touches);
    let mut rng = ChaCha8Rng::seed_from_u64(6);
    add_joint_noise(&robot, &mut touches, 2e-3, &mut rng);
    add_point_noise(&mut touches, 1e-3, &mut rng);
    let within: Vec<f64> = (0..6)
        .map(|seed| {
            let [fitted, fresh] = split(&touches, 0.3, seed);
            let estimator = Estimator::new(&robot, &fitted, EstimatorOptions::default());
            judge(&estimator, &estimator.fit(), &fresh).within
        })
        .collect();
    let mean = within.iter().sum::<f64>() / within.len() as f64;
    assert!((0.92..0.98).contains(&mean), "{within:?}");
}

#[test]
fn points_that_recur_are_places() {
    let (mut robot, touches) = arms(60);
    // Every touch three times: all points recur.
    let mut all: Vec<Touch> = touches.iter().flat_map(|touch| vec![touch.clone(); 3]).collect();
    let links = robot.links.len();
    assert_eq!(add_places(&mut robot, &mut all, 1e-3), 2 * touches.len());
    assert_eq!(robot.links.len(), links + 2 * touches.len());
    let on_place =
        |end: &End| matches!(end.feature, Feature::Point(link, p) if link >= links && p == Vector3::zeros());
    assert!(all.iter().flat_map(|touch| &touch.ends).flatten().all(on_place));
    let noise =
        Noise { groups: vec![1e-3; 8], joint: 0.0, false_share: 0.0, widths: vec![1.0; 8], dead: None };
    let seen = Estimator::new(&robot, &all, EstimatorOptions::default()).seen(&robot.nominal(), &noise);
    assert!(seen.iter().all(|seen| seen.apart() < 1e-9));
}

#[test]
fn a_urdf_comes_back_with_its_encoders_put_right() {
    let place = Place::new();
    let urdf = fs::read(repository("examples/robot/arms.urdf")).unwrap();
    place.write("arms.urdf", &urdf);
    place.write("touches.csv", fs::read(repository("examples/robot/touches.csv")).unwrap());
    let arguments = ["arms.urdf", "touches.csv", "--free", "*.offset", "--out", "made"];
    let found = place.json(&arguments);
    assert_eq!(found["calibrated"], true);
    assert!(found["after"]["rms"].as_f64().unwrap() < 2e-3);
    for file in ["quantities.csv", "calibration.json"] {
        assert!(place.path("made").join(file).exists(), "{file}");
    }
    // The page says what was found, and draws it.
    let page = fs::read_to_string(place.path("made/report.html")).unwrap();
    assert!(page.contains("calibrated: the estimated parameters explain the touches"), "{page}");
    let quantities = found["quantities"].as_array().unwrap();
    assert!(quantities.iter().all(|quantity| page.contains(quantity["name"].as_str().unwrap())));
    assert!(page.contains("id=\"by-pair\""));
    // A matrix of all with all, and what was read beside what is left.
    let table = |name: &str| -> Vec<Vec<String>> {
        let text = fs::read_to_string(place.path("made").join(name)).unwrap();
        text.lines().map(|line| line.split(',').map(str::to_string).collect()).collect()
    };
    let correlations = table("correlations.csv");
    assert_eq!((correlations.len(), correlations[0].len()), (11, 11));
    assert_eq!((correlations[0][3].as_str(), correlations[3][3].as_str()), ("left_roll.offset", "1.000000"));
    assert!(table("residuals.csv").iter().all(|row| row.len() == 6 + 10));
    // What is written reads encoders right: offsets are in the origins now.
    place.write("again.urdf", fs::read(place.path("made/arms.urdf")).unwrap());
    let again = place.json(&["again.urdf", "touches.csv", "--free", "*.offset"]);
    let rms = |found: &Json, when: &str| found[when]["rms"].as_f64().unwrap();
    assert!((rms(&again, "before") / rms(&found, "after") - 1.0).abs() < 1e-6);
    // Of the lines only those of joints changed.
    let written = fs::read_to_string(place.path("made/arms.urdf")).unwrap();
    let before = String::from_utf8(urdf).unwrap();
    for line in before.lines().filter(|line| !line.contains("<origin")) {
        assert!(written.contains(line), "{line}");
    }
    place.fails(&arguments, &["made", "already contains a calibration"]);
}

#[test]
fn a_description_keeps_its_own_lines_and_says_the_new_values() {
    let (mut robot, mut touches) = arms(150);
    let truth = off(&mut robot, 9, false);
    misread(&robot, &truth, &mut touches);
    let place = Place::new();
    let robot_json = r#"{
  "name": "elbow", "limbs": ["base", "arm"],
  "joints": [{"name": "elbow", "parent": "base", "position": [0.1, 0, 0],
    "dofs": [{"name": "pitch", "kind": "hinge", "axis": [0, 1, 0]}]}],
  "free": ["pitch.offset"]
}
"#;
    let mut log = String::from("limb_a,limb_b,ax,ay,az,bx,by,bz,pitch\n");
    for k in 0..30 {
        let angle = 0.05 * f64::from(k);
        let (sin, cos) = (angle + 0.02).sin_cos();
        log += &format!("base,arm,{},0.01,{},0.2,0.01,0,{angle}\n", 0.1 + 0.2 * cos, -0.2 * sin);
    }
    place.write("robot.json", robot_json);
    place.write("touches.csv", &log);
    place.json(&["robot.json", "touches.csv", "--out", "made"]);
    let written = fs::read_to_string(place.path("made/robot.json")).unwrap();
    assert!(robot_json.lines().skip(1).all(|line| written.contains(line)), "{written}");
    place.write("again.json", &written);
    let again = place.json(&["again.json", "touches.csv"]);
    assert!(again["before"]["rms"].as_f64().unwrap() < 1e-6, "{written}");
}

#[test]
fn the_log_that_is_written_is_the_log_that_is_read() {
    let (robot, touches) = arms(20);
    let place = Place::new();
    let all: Vec<&Touch> = touches.iter().collect();
    place.write("log.csv", calibration_table(&robot, &all, &[("gain", vec!["1".into(); all.len()])]));
    let log = read_calibration_log(&place.path("log.csv"), &robot).unwrap();
    assert_eq!(log.touches.len(), touches.len());
    assert_eq!(log.notes, ["unused columns: gain"]);
    for (read, made) in log.touches.iter().zip(&touches) {
        assert!(read.posture.iter().zip(&made.posture).all(|(a, b)| (a - b).abs() < 1e-6));
    }
}

/// What engineers get wrong, each with the words that its sentence must have.
#[test]
fn a_mistake_gets_a_sentence_with_its_mend() {
    let place = Place::new();
    let urdf = fs::read_to_string(repository("examples/robot/arms.urdf")).unwrap();
    let log = fs::read_to_string(repository("examples/robot/touches.csv")).unwrap();
    place.write("arms.urdf", &urdf);
    place.write("touches.csv", &log);
    let with_head = |from: &str, to: &str| log.replacen(from, to, 1);
    let metres = |cell: (usize, &str)| match cell {
        (2..8, number) => format!("{}", 1e3 * number.parse::<f64>().unwrap()),
        (_, text) => text.to_string(),
    };
    let rows =
        log.lines().skip(1).map(|line| line.split(',').enumerate().map(metres).collect::<Vec<_>>().join(","));
    let millimetres = format!("{}\n{}\n", log.lines().next().unwrap(), rows.collect::<Vec<_>>().join("\n"));
    let logs: [(&str, String, &[&str]); 9] = [
        ("millimetres.csv", millimetres, &["millimetres", "ax_mm"]),
        ("degrees.csv", log.replacen("_deg", "", 10), &["degrees", "left_yaw_deg"]),
        ("joint.csv", with_head("left_wrist_deg", "left_wirst_deg"), &["left_wrist", "left_wirst", "rename"]),
        (
            "case.csv",
            with_head("left_wrist_deg", "Left_Wrist_deg"),
            &["Left_Wrist_deg", "left_wrist", "rename"],
        ),
        ("limb.csv", log.replace("left_hand", "lefthand"), &["line", "lefthand", "left_hand"]),
        ("point.csv", with_head(",ax,", ",a_x,"), &["column ax is missing"]),
        (
            "words.csv",
            log.replacen("left_hand,right_hand,", "left_hand,right_hand,oops", 1),
            &["line", "ax", "not a number"],
        ),
        (
            "headless.csv",
            log.lines().skip(1).map(|l| format!("{l}\n")).collect(),
            &["column limb_a is missing"],
        ),
        ("empty.csv", log.lines().next().unwrap().to_string(), &["no touch"]),
    ];
    for (name, content, words) in &logs {
        place.write(name, content);
        place.fails(&["arms.urdf", name, "--free", "*.offset"], &[&[*name], *words].concat());
    }
    place.write("robot.json", "{\"name\": 3}");
    place.fails(&["touches.csv", "arms.urdf"], &["touches.csv", "robot first"]);
    place.fails(&["arms.urdf", "arms.urdf"], &["arms.urdf", "XML"]);
    place.fails(&["arms.urdf", "robot.json"], &["robot.json", "column limb_a is missing"]);
    place.fails(&["robot.json", "touches.csv"], &["robot.json", "name"]);
    place.fails(&["gone.urdf", "touches.csv"], &["gone.urdf", "exists"]);
    place.fails(&["arms.urdf", "touches.csv", "--free", "*.offsets"], &["*.offsets", "left_yaw.offset"]);
    place.fails(&["arms.urdf", "touches.csv", "--prior", "*.offset=5mm"], &["mm", "own unit"]);
    place.fails(&["arms.urdf", "touches.csv", "--prior", "*.offset"], &["=5mm"]);
    place.fails(&["arms.urdf", "touches.csv", "--fix", "*"], &["nothing to estimate"]);
    place.fails(&["arms.urdf", "touches.csv", "--held-out", "1.5"], &["between 0 and 1"]);
    // Exchanged limbs are a log that can be read: what is found explains nothing, and that is said.
    let exchanged: Vec<String> = log
        .lines()
        .enumerate()
        .map(|(i, line)| match line.splitn(3, ',').collect::<Vec<_>>()[..] {
            [a, b, rest] if i > 0 => format!("{b},{a},{rest}"),
            _ => line.to_string(),
        })
        .collect();
    place.write("exchanged.csv", exchanged.join("\n"));
    let found = place.json(&["arms.urdf", "exchanged.csv", "--free", "*.offset"]);
    assert_eq!(found["calibrated"], false);
    assert!(found["verdict"].as_str().unwrap().contains("swapped"), "{}", found["verdict"]);
}
