//! What calibration found, written into the table of Denavit and Hartenberg's numbers that the robot is from.

use std::path::Path;

use super::dh::NUMBERS;
use super::dh_table::{Field, table};
use super::edits::{Edits, Written, digits, unsaid_compliance, unsaid_gain};
use super::tags::Fault;
use crate::calibration::robot::{Element, Robot, Value};
use crate::session::RecordError;

/// How the format is called in what is left out.
const FORMAT: &str = "a DH table";

/// The table `original`, which `robot` was read from, in its own columns and units, with `values` in the place of the numbers
/// that differ from them, and every other byte as it was. A column or field `theta` or `beta` is added where one is needed.
///
/// `path` is what the file is called in messages.
///
/// # Errors
/// Where `original` is no such table.
pub fn write_dh(
    path: &Path,
    original: &[u8],
    robot: &Robot,
    values: &[Value],
) -> Result<Written, RecordError> {
    written(original, robot, values).map_err(|(line, message)| RecordError::format(path, Some(line), message))
}

fn written(original: &[u8], robot: &Robot, values: &[Value]) -> Result<Written, Fault> {
    let table = table(original)?;
    let mut edits = Edits::default();
    for field in NUMBERS {
        // A cell's place and what is to stand in it, and what is to be in rows without one.
        let mut new = Vec::new();
        for row in &table.rows {
            let name = format!("{}.{}", row.text(Field::Joint).unwrap_or_default(), field.name());
            let Some(quantity) = robot.quantity(&name) else {
                let message = format!("the robot has no {name}: give the file that it was read from");
                return Err((row.line, message));
            };
            let value = values[quantity].number();
            match row.cell(field) {
                Some(cell) => {
                    let old = cell.si_number().unwrap_or_default();
                    if value != old {
                        edits.replace(cell.at.clone(), digits(cell.own_unit(value)));
                    }
                }
                None => new.push((row.end, value)),
            }
        }
        if new.iter().all(|(_, value)| *value == 0.0) {
            continue;
        }
        if let Some(header) = table.header_end {
            edits.insert(header, format!(",{}", field.name()));
        }
        for (end, value) in new {
            match table.header_end {
                Some(_) => edits.insert(end, format!(",{}", digits(value))),
                None if value != 0.0 => {
                    edits.insert(end, format!(", \"{}\": {}", field.name(), digits(value)))
                }
                None => {}
            }
        }
    }
    Ok(Written { bytes: edits.of(original), left_out: unsaid(robot, values) })
}

/// What a table has no columns for.
fn unsaid(robot: &Robot, values: &[Value]) -> Vec<String> {
    let mut unsaid = Vec::new();
    for (dof, about) in robot.dofs.iter().enumerate() {
        let Some(q) = about.quantities else { continue };
        let name = &about.name;
        if values[q.sign].number() < 0.0 {
            unsaid.push(format!(
                "sign of {name} (-1) cannot be said in {FORMAT}: take what its encoder reads the other way round"
            ));
        }
        unsaid.extend(unsaid_gain(robot, values, dof, FORMAT));
        unsaid.extend(unsaid_compliance(robot, values, dof, FORMAT));
        let aside = values[q.axis].distance(&robot.quantities[q.axis].nominal);
        if aside > 0.0 {
            unsaid.push(format!(
                "axis of {name} (aside by {aside:.6} rad) cannot be said in {FORMAT}: calibrate {name}.alpha and \
                 {name}.beta in its place"
            ));
        }
    }
    for link in &robot.links {
        let changed = link.elements.iter().any(|element| match element {
            Element::Shift(q) | Element::Turn(q) => values[*q] != robot.quantities[*q].nominal,
            _ => false,
        });
        if changed {
            let parent = &robot.links[link.parent].name;
            unsaid.push(format!(
                "link {} on {parent} cannot be said in {FORMAT}: keep its pose elsewhere",
                link.name
            ));
        }
    }
    unsaid
}

#[cfg(test)]
mod tests {
    use nalgebra::{Rotation3, Vector3};
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    use super::*;
    use crate::calibration::robot::Posed;
    use crate::geometry::Frame;
    use crate::record::robot::dh::read_dh;

    const CSV: &str = "# A hand, with millimetres.\r
joint, a_mm ,d,alpha [deg],theta_deg,kind,parent,min_deg,max_deg,max_mm\r
j1,0,0.30,90, 0,,,-170,170,\r
j2,\"250.5\",0,0,-90.0,hinge,,,,\r
slide,10,0.1,-90,5,slide,j2,,,300\r
flange,0,0.05,0,45,fixed,j1,,,\r
";
    const JSON: &str = r#"{
  "name": "arm", "convention": "modified",
  "joints": [
    {"joint": "j1", "a": 0, "d": 0.30, "alpha_deg": 90, "range_deg": [-170, 170]},
    {"joint": "j2", "link": "fore", "a_mm": 250.5, "d": 0, "alpha": -0.1, "theta": 0.20, "comment": "odd"},
    {"joint": "slide", "kind": "prismatic", "a": 0.01, "d": 0.1, "alpha": 1, "beta": 0.05, "range": [0, 0.3], "parent": "fore"},
    {"joint": "old", "a": 0.01, "d": 0.1, "alpha": 1, "beta_deg": 3, "convention": "standard", "parent": "base"}
  ]
}
"#;

    fn read(text: &str) -> Result<Robot, String> {
        read_dh(Path::new("table"), text.as_bytes()).map_err(|error| error.to_string())
    }

    fn write(text: &str, robot: &Robot, values: &[Value]) -> (String, Vec<String>) {
        let Written { bytes, left_out } =
            write_dh(Path::new("table"), text.as_bytes(), robot, values).unwrap();
        (String::from_utf8(bytes).unwrap(), left_out)
    }

    fn turn(axis: usize, angle: f64) -> Frame {
        let rotation = Rotation3::new(Vector3::ith(axis, angle)).into_inner();
        Frame { rotation, origin: Vector3::zeros() }
    }

    fn shift(axis: usize, by: f64) -> Frame {
        Frame { origin: Vector3::ith(axis, by), ..Frame::identity() }
    }

    fn far(a: &Frame, b: &Frame) -> f64 {
        (a.rotation - b.rotation).norm().max((a.origin - b.origin).norm())
    }

    #[test]
    fn links_are_where_the_conventions_have_them() {
        let standard = |theta: f64, d, a, alpha| turn(2, theta) * shift(2, d) * shift(0, a) * turn(0, alpha);
        let modified = |theta: f64, d, a, alpha| turn(0, alpha) * shift(0, a) * turn(2, theta) * shift(2, d);
        let degree = std::f64::consts::PI / 180.0;
        let [p, q, s, o] = [0.3, -0.7, 0.05, 1.1];
        let first = standard(p, 0.3, 0.0, 90.0 * degree);
        let second = first * standard(q - 90.0 * degree, 0.0, 0.2505, 0.0);
        let csv = [
            ("j1_link", first),
            ("j2_link", second),
            ("slide_link", second * standard(5.0 * degree, 0.1 + s, 0.01, -90.0 * degree)),
            ("flange_link", first * standard(45.0 * degree, 0.05, 0.0, 0.0)),
        ];
        let first = modified(p, 0.3, 0.0, 90.0 * degree);
        let second = first * modified(q + 0.2, 0.0, 0.2505, -0.1);
        let json = [
            ("j1_link", first),
            ("fore", second),
            ("slide_link", second * turn(0, 1.0) * shift(0, 0.01) * turn(1, 0.05) * shift(2, 0.1 + s)),
            ("old_link", standard(o, 0.1, 0.01, 1.0) * turn(1, 3.0 * degree)),
        ];
        for (text, expected) in [(CSV, csv), (JSON, json)] {
            let robot = read(text).unwrap();
            let (nominal, posture) = (robot.nominal(), [p, q, s, o]);
            let frames = Posed::new(&robot, &nominal, &posture[..robot.coordinates()]).frames();
            for (name, frame) in expected {
                let found = &frames[robot.link(name).unwrap()];
                assert!(far(found, &frame) < 1e-12, "{name}: {found:?} {frame:?}");
            }
            assert!((robot.dofs[0].range[1] - 170.0 * degree).abs() < 1e-15);
            assert!((robot.dofs[2].range[1] - 0.3).abs() < 1e-15);
            assert!(robot.quantity("j1.offset").is_none() && robot.quantity("slide.theta").is_some());
            assert_eq!(robot.quantity("j2.theta"), robot.dofs[1].quantities.map(|q| q.offset));
        }
    }

    #[test]
    fn what_did_not_change_is_written_byte_for_byte() {
        for text in [CSV.to_string(), format!("\u{feff}{CSV}"), CSV.trim_end().to_string(), JSON.to_string()]
        {
            let robot = read(&text).unwrap();
            assert_eq!(write(&text, &robot, &robot.nominal()), (text, Vec::new()));
        }
    }

    #[test]
    fn only_the_numbers_that_changed_are_written() {
        for (text, from, to) in [
            (CSV, "\"250.5\",0,0,-90.0", "\"250.75\",0,0,-90.0"),
            (JSON, "250.5, \"d\": 0, \"alpha\": -0.1", "250.75, \"d\": 0, \"alpha\": -0.1"),
        ] {
            let robot = read(text).unwrap();
            let mut values = robot.nominal();
            values[robot.quantity("j2.a").unwrap()] = Value::Number(0.25075);
            let (found, left_out) = write(text, &robot, &values);
            assert_eq!((found, left_out), (text.replace(from, to), Vec::new()));
        }
        let robot = read(JSON).unwrap();
        let mut values = robot.nominal();
        values[robot.quantity("j1.theta").unwrap()] = Value::Number(0.5);
        assert_eq!(write(JSON, &robot, &values).0, JSON.replace("170]}", "170], \"theta\": 0.5}"));
        let robot = read(CSV).unwrap();
        let mut values = robot.nominal();
        values[robot.quantity("j2.beta").unwrap()] = Value::Number(0.5);
        let lines: Vec<String> = write(CSV, &robot, &values).0.lines().map(str::to_string).collect();
        assert!(
            lines[1].ends_with("max_mm,beta") && lines[2].ends_with("170,,0") && lines[3].ends_with(",0.5")
        );
    }

    #[test]
    fn a_calibrated_robot_reads_back_as_the_same() {
        let mut rng = ChaCha8Rng::seed_from_u64(3);
        for text in [CSV, JSON] {
            let robot = read(text).unwrap();
            let mut values = robot.nominal();
            for (quantity, value) in robot.quantities.iter().zip(&mut values) {
                let called = |what: &&str| quantity.name.ends_with(*what);
                if [".theta", ".d", ".a", ".alpha", ".beta"].iter().any(called) {
                    *value = value.stepped(&[rng.random_range(-0.1..0.1)]);
                }
            }
            let (written, left_out) = write(text, &robot, &values);
            assert_eq!(left_out, Vec::<String>::new());
            let again = read(&written).unwrap();
            for _ in 0..20 {
                let posture: Vec<f64> =
                    (0..robot.coordinates()).map(|_| rng.random_range(-2.0..2.0)).collect();
                let one = Posed::new(&robot, &values, &posture).frames();
                let other = Posed::new(&again, &again.nominal(), &posture).frames();
                assert!(one.iter().zip(&other).all(|(a, b)| far(a, b) < 1e-12), "{written}");
            }
        }
    }

    #[test]
    fn what_a_table_cannot_say_is_told() {
        let mut robot = read(CSV).unwrap();
        robot.add_mount("tip", 1, Frame::identity());
        let mut values = robot.nominal();
        for (name, value) in [
            ("j1.sign", Value::Number(-1.0)),
            ("j1.gain", Value::Number(1.01)),
            ("slide.compliance", Value::Number(1e-3)),
            ("j2.axis", Value::Direction(Vector3::new(0.0, 0.1, 1.0).normalize())),
            ("tip.position", Value::Position(Vector3::x())),
        ] {
            values[robot.quantity(name).unwrap()] = value;
        }
        let (text, left_out) = write(CSV, &robot, &values);
        assert_eq!(text, CSV);
        let begin = ["sign of j1", "gain of j1", "axis of j2", "compliance of slide", "link tip on j1_link"];
        let all = left_out.iter().zip(begin).all(|(sentence, begin)| sentence.starts_with(begin));
        assert!(all && left_out.len() == begin.len(), "{left_out:?}");
    }

    #[test]
    fn mistakes_get_a_sentence() {
        let with = |text: &str, from: &str, to: &str| {
            assert!(text.contains(from), "{from}");
            read(&text.replacen(from, to, 1)).unwrap_err()
        };
        let cases = [
            (read("<robot name=\"arm\"/>").unwrap_err(), "table, line 1: it is XML where a table"),
            (with(CSV, "alpha [deg]", "comment"), "table, line 2: there is no column alpha: "),
            (
                with(CSV, "alpha [deg]", "alpha"),
                "table, line 3: alpha of joint j1 is 90 radians: call it alpha_deg",
            ),
            (with(CSV, "a_mm", "a"), "table, line 4: a of joint j2 is 250.5 metres: call it a_mm"),
            (with(CSV, "min_deg", "min"), "table, line 3: min of joint j1 is -170 radians: call it min_deg"),
            (
                with(CSV, "slide,10", "slide,q2"),
                "line 5: a of joint slide is \"q2\", which is no finite number: ",
            ),
            (
                with(CSV, "5,slide", "5,screw"),
                "line 5: joint slide is of the kind \"screw\": give hinge, slide or fixed",
            ),
            (
                with(CSV, "slide,j2", "slide,j9"),
                "line 5: joint slide hangs on j9, which is neither a joint nor a link: ",
            ),
            (
                with(CSV, "slide,j2,,,300", "slide,j2,,90,"),
                "max of joint slide, which shifts, has another unit: ",
            ),
            (with(CSV, "slide,j2", "slide,slide"), "line 5: joint slide hangs on itself: "),
            (with(CSV, ",,,,\r\nslide", ",,\r\nslide"), "line 4: it has 8 cells in place of 10: "),
            (with(CSV, "fixed,j1", "fixed,base,,,\r\nj1,0,0,0,0,,"), "there are two joints j1: rename one"),
            (read("joint;a;d").unwrap_err(), "line 1: its columns are separated by ';': "),
            (with(JSON, "\"alpha_deg\": 90, ", ""), "line 4: joint j1 has no alpha: give it"),
            (
                with(JSON, "modified", "paul"),
                "the convention \"paul\" is not known: give standard or modified",
            ),
            (with(JSON, "[0, 0.3]", "0.3"), "line 6: \"range\" is no list of two numbers: "),
            (with(JSON, "[0, 0.3]", "[0.3, 0]"), "the range of joint slide leaves it no room"),
            (
                with(JSON, "\"j1\",", "\"j1\", \"parent\": \"slide\","),
                "joints j1, j2, slide hang on each other in a circle: ",
            ),
            (with(JSON, "\"comment\"", "\"weight\""), "line 5: \"weight\" is none of joint, "),
            (
                with(JSON, "\"joints\"", "\"links\""),
                "it is no table of Denavit and Hartenberg's numbers (unknown field",
            ),
        ];
        for (message, expected) in cases {
            assert!(message.contains(expected), "{message} != {expected}");
        }
    }
}
