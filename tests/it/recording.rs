//! Learning from recordings: a creature in JSON, a log as JSON lines or as comma-separated values, no model.

use std::fs;
use std::path::PathBuf;
use std::process::{Command, Output};

use crate::common::{babble, creature, max, repository, two_arms};
use bodyschema::agent::Agent;
use bodyschema::creature::{Creature, Dof, DofKind, Posture};
use bodyschema::evaluation::evaluate;
use bodyschema::ground_truth::GroundTruth;
use bodyschema::learning::{Input, Learner, SecondOrder, Verdict};
use bodyschema::senses::{Disturbances, RecordedTouch, Touch};
use bodyschema::session::{Recording, read_creature, read_recording};
use bodyschema::skin::Skin;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use serde_json::{Value, json};
use tempfile::TempDir;

/// A base with a turret on a ball and a telescopic arm: every kind of degree of freedom.
const CRANE: &str = r#"{
  "name": "crane",
  "limbs": ["base", "turret", "arm"],
  "joints": [
    {"name": "bearing", "parent": "base", "limb": "turret", "dofs": [{"name": "turn", "kind": "ball"}]},
    {"name": "boom", "parent": "turret", "dofs": [
      {"name": "lift", "kind": "hinge", "range": [-1.5, 1.5]},
      {"name": "reach", "kind": "slide", "range": [0.0, 0.5]}]}
  ]
}"#;
const HEADER: &str = "limb_a,limb_b,ax,ay,az,bx,by,bz,turn_w,turn_x,turn_y,turn_z,lift,reach,a_std,b_std";
const ROW: &str = "base,arm,0.1,0.2,0.3,-0.1,0,1e-2,1,0,0,0,0.5,0.25,0.001,";

/// A folder with the files of a recording.
struct Place(TempDir);

impl Place {
    fn new() -> Place {
        Place(tempfile::tempdir().unwrap())
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    fn write(&self, name: &str, text: &str) -> PathBuf {
        fs::write(self.path(name), text).unwrap();
        self.path(name)
    }

    /// Reads a log of the crane.
    fn crane(&self, name: &str, log: &str) -> Result<Recording, String> {
        let described = read_creature(&self.write("crane.json", CRANE)).unwrap();
        let path = self.write(name, log);
        let read = read_recording(&path, &described.agent);
        read.map_err(|error| sentence(&error.to_string(), name))
    }

    fn run(&self, arguments: &[&str]) -> Output {
        let mut command = Command::new(env!("CARGO_BIN_EXE_bodyschema"));
        command.args(arguments).current_dir(self.0.path()).env("RUST_BACKTRACE", "0").output().unwrap()
    }

    fn succeeds(&self, arguments: &[&str]) -> String {
        let output = self.run(arguments);
        let told = String::from_utf8_lossy(&output.stderr);
        assert!(output.status.success(), "{arguments:?}: {told}");
        String::from_utf8(output.stdout).unwrap()
    }

    fn fails(&self, arguments: &[&str]) -> String {
        let output = self.run(arguments);
        assert_eq!(output.status.code(), Some(1), "{arguments:?}");
        String::from_utf8(output.stderr).unwrap()
    }
}

/// A message behind the file's name; it is one line and has a mend behind a colon.
fn sentence(message: &str, file: &str) -> String {
    assert!(!message.contains('\n'), "{message}");
    let (_, rest) = message.split_once(file).unwrap_or_else(|| panic!("{message} does not name {file}"));
    assert!(rest.contains(": "), "{message} has no mend");
    rest.trim_start_matches([',', ':', ' ']).to_string()
}

fn dofs(creature: &Creature) -> Vec<&Dof> {
    creature.dofs().collect()
}

/// Touches as a robot's own program might write them.
fn to_csv(agent: &Agent, touches: &[RecordedTouch], receptors: bool) -> String {
    let (creature, skin) = (agent.creature(), agent.skin());
    let names: Vec<&str> = creature.dofs().map(|dof| dof.name.as_str()).collect();
    let ends = if receptors { "receptor_a,receptor_b" } else { "limb_a,limb_b,ax,ay,az,bx,by,bz" };
    let mut text = format!("{ends},{}\n", names.join(","));
    for touch in touches {
        let on = touch.ends.map(|end| &skin.receptors[end.receptor]);
        let mut cells: Vec<String> = match receptors {
            true => on.map(|receptor| receptor.id.clone()).to_vec(),
            false => on.map(|receptor| creature.limbs()[receptor.limb].clone()).to_vec(),
        };
        if !receptors {
            cells.extend(touch.exact_contact().points.iter().flatten().map(f64::to_string));
        }
        cells.extend(touch.posture.iter().map(f64::to_string));
        text += &format!("{}\n", cells.join(","));
    }
    text
}

#[test]
fn rows_and_lines_say_the_same() {
    let place = Place::new();
    let rows = format!("{HEADER}\n{ROW}\n\n# a comment\n{}\n", ROW.replace("base,arm", "arm,base"));
    let lines = r#"{"posture": {"lift": 0.5, "reach": 0.25, "turn": [1, 0, 0, 0]}, "limbs": ["base", "arm"],
 "contacts": [[0.1, 0.2, 0.3], [-0.1, 0, 1e-2]], "deviations": [0.001, null]}"#
        .replace('\n', "");
    let turned = r#"{"posture": [1, 0, 0, 0, 0.5, 0.25], "limbs": ["arm", "base"],
 "contacts": [[0.1, 0.2, 0.3], [-0.1, 0, 1e-2]], "deviations": [0.001, null]}"#
        .replace('\n', "");
    let a = place.crane("touches.csv", &rows).unwrap();
    let b = place.crane("touches.jsonl", &format!("{lines}\n\n{turned}\n")).unwrap();
    assert_eq!(a, b);
    assert_eq!(a.input, Input::Contact);
    let [first, second] = a.touches.as_slice() else { panic!("{} touches", a.touches.len()) };
    assert_eq!(first.posture[..], [1.0, 0.0, 0.0, 0.0, 0.5, 0.25]);
    let limb = |touch: &Touch, k: usize| a.agent.skin().receptors[touch.ends[k].receptor].limb;
    assert_eq!([limb(first, 0), limb(first, 1)], [0, 2]);
    assert_eq!(first.exact_contact().deviations, [Some(0.001), None]);
    // The end on the earlier limb comes first, with all that belongs to it.
    assert_eq!([limb(second, 0), limb(second, 1)], [0, 2]);
    assert_eq!(second.exact_contact().points[1], first.exact_contact().points[0]);
    assert_eq!(second.exact_contact().deviations, [None, Some(0.001)]);
}

#[test]
fn a_touch_that_is_held_or_copied_counts_once() {
    let place = Place::new();
    // The encoders flicker while it lasts; another touch is of another point.
    let held: String =
        (0..20).map(|k| format!("{}\n", ROW.replace("0.25", &format!("0.2500{k:02}")))).collect();
    let log = format!("{HEADER}\n{held}{}\n{ROW}\n", ROW.replace("0.1,0.2", "0.11,0.2"));
    let read = place.crane("touches.csv", &log).unwrap();
    assert_eq!(read.touches.len(), 2);
    assert_eq!(read.notes, ["20 of 22 rows are repeats in the same posture; each touch counts once"]);
    assert_eq!(read.touches[0].posture[5], 0.25);
}

#[test]
fn a_row_that_cannot_be_read_is_named_by_line_and_column() {
    let place = Place::new();
    let wrong = [
        ("base,arm,0.1", "base,leg,0.1", "line 4: column limb_b: crane has no limb \"leg\""),
        (",0.2,", ",zero,", "line 4: column 4, ay: \"zero\" is not a number"),
        (",0.2,", ",,", "line 4: column 4, ay: it is empty"),
        (",0.5,", ",,", "line 4: column 13, lift: it is empty"),
        (",0.001,", ",-1,", "line 4: column 15, a_std: -1 is negative"),
        (",0.25,0.001,", ",0.25", "line 4: it has 14 cells instead of 16"),
        (",1,0,0,0,", ",0.5,0,0,0,", "line 4: the posture's quaternion of turn has length 0.5"),
        ("base,arm", "arm,arm", "on limb arm, but a touch needs two limbs"),
        ("base,arm", ",arm", "line 4: end a has no limb"),
    ];
    for (from, to, expected) in wrong {
        let row = ROW.replace(from, to);
        assert_ne!(row, ROW);
        let log = format!("{HEADER}\n{ROW}\n\n{row}\n");
        let message = place.crane("touches.csv", &log).unwrap_err();
        assert!(message.contains(expected), "{row}: {message}");
    }
}

#[test]
fn columns_that_are_missing_unknown_or_doubled_are_named() {
    let place = Place::new();
    let wrong = [
        (
            HEADER.replace("lift", "lft"),
            "column lift is missing: add this degree of freedom, or is lft meant?",
        ),
        (HEADER.replace(",lift", ""), "column lift is missing"),
        (HEADER.replace("turn_y", "turn_x"), "column 11, turn_x: it occurs twice"),
        (HEADER.replace(",by", ""), "column by is missing: a point has three coordinates"),
        (HEADER.replace("limb_a,", ""), "column limb_a is missing"),
        (String::new(), "begin with a line of column names"),
    ];
    for (header, expected) in wrong {
        let message = place.crane("touches.csv", &format!("{header}\n")).unwrap_err();
        assert!(message.contains(expected), "{header}: {message}");
    }
    assert!(
        place.crane("touches.csv", &format!("{HEADER}\n")).unwrap_err().contains("it contains no touches")
    );
    assert!(place.crane("touches.jsonl", "\n").unwrap_err().contains("it contains no touches"));
}

#[test]
fn units_are_read_from_columns_and_what_means_nothing_is_passed_over() {
    let place = Place::new();
    let log = |header: &str, row: &str| place.crane("touches.csv", &format!("{header}\n{row}\n")).unwrap();
    let plain = log(HEADER, ROW);
    assert!(plain.notes.is_empty(), "{:?}", plain.notes);
    let header = HEADER.replace("lift", "lift_deg").replace("ax,ay,az", "ax [mm],ay [mm],az [mm]");
    let row =
        ROW.replace("0.1,0.2,0.3", "100,200,300").replace(",0.5,", &format!(",{},", 0.5f64.to_degrees()));
    let other = log(&format!("{header},temperature"), &format!("{row},21"));
    assert_eq!(other.notes, ["unused columns: temperature"]);
    let (a, b) = (&plain.touches[0], &other.touches[0]);
    assert!(a.posture.iter().zip(b.posture.iter()).all(|(a, b)| (a - b).abs() < 1e-12));
    let [a, b] = [a, b].map(|touch| touch.exact_contact().points);
    assert!(a.iter().zip(&b).all(|(a, b)| (a - b).norm() < 1e-12));
}

#[test]
fn a_line_that_is_no_touch_is_named_with_what_is_wrong() {
    let place = Place::new();
    let right = json!({"posture": {"turn": [1, 0, 0, 0], "lift": 0.5, "reach": 0.25}, "limbs": ["base", "arm"],
                       "contacts": [[0.1, 0.2, 0.3], [0.1, 0.0, 0.0]]});
    let wrong: [(&str, Value, &str); 8] = [
        ("/posture/lift", json!("half"), "lift: \"half\" is not a number"),
        ("/posture/lift", json!([]), "lift is neither a number nor a string"),
        ("/posture/turn", json!(1), "turn_w: it is empty"),
        ("/posture", json!([1, 0, 0, 0, 0.5]), "posture has 5 numbers instead of 6"),
        ("/posture", json!(3), "posture is neither a list"),
        ("/limbs/1", json!("leg"), "column limb_b: crane has no limb \"leg\""),
        ("/contacts", Value::Null, "end a has a limb but no point on it"),
        ("/limbs", Value::Null, "end a has no limb"),
    ];
    for (pointer, value, expected) in wrong {
        let mut line = right.clone();
        *line.pointer_mut(pointer).unwrap() = value;
        let message = place.crane("touches.jsonl", &format!("{right}\n{line}\n")).unwrap_err();
        assert!(message.starts_with("line 2: ") && message.contains(expected), "{line}: {message}");
    }
    let message = place.crane("touches.jsonl", &right.to_string().replace("limbs", "limb")).unwrap_err();
    assert!(message.contains("line 1: limb is neither a number nor a string"), "{message}");
    let missing = json!({"posture": {"turn": [1, 0, 0, 0], "lift": 0.5}, "limbs": ["base", "arm"],
                         "contacts": [[0.1, 0.2, 0.3], [0.1, 0.0, 0.0]]});
    let message = place.crane("touches.jsonl", &missing.to_string()).unwrap_err();
    assert!(message.contains("column reach is missing"), "{message}");
}

#[test]
fn units_that_cannot_be_are_told() {
    let place = Place::new();
    let degrees = format!("{HEADER}\n{}\n", ROW.replace(",0.5,", ",45,"));
    let message = place.crane("touches.csv", &degrees).unwrap_err();
    assert!(
        message.contains("lift is 45") && message.contains("convert them and the range to radians"),
        "{message}"
    );
    let millimetres = format!("{HEADER}\n{}\n", ROW.replace("0.1,0.2,0.3,-0.1", "100,200,300,-100"));
    let read = place.crane("touches.csv", &millimetres).unwrap();
    assert!(read.notes.iter().any(|note| note.contains("convert them to metres")), "{:?}", read.notes);
    let beyond = format!("{HEADER}\n{}\n", ROW.replace(",0.25,", ",0.9,"));
    let read = place.crane("touches.csv", &beyond).unwrap();
    assert!(read.notes.iter().any(|note| note.contains("reach goes from")), "{:?}", read.notes);
    assert!(place.crane("touches.csv", &format!("{HEADER}\n{ROW}\n")).unwrap().notes.is_empty());
}

#[test]
fn a_creature_file_with_anything_wrong_in_it_is_refused_by_field() {
    let place = Place::new();
    let wrong = [
        ("\"parent\": \"turret\"", "\"parent\": \"trret\"", "joints[1].parent: limbs contains no \"trret\""),
        ("\"parent\": \"turret\", ", "", "joints[1]: missing field `parent`"),
        ("\"kind\": \"hinge\"", "\"kind\": \"knee\"", "joints[1].dofs[0].kind: unknown variant `knee`"),
        ("\"kind\": \"hinge\", ", "", "missing field `kind`"),
        (", \"range\": [0.0, 0.5]", "", "joints[1].dofs[1] is a slide without a range"),
        ("\"range\": [0.0, 0.5]", "\"range\": [1.0, 0.5]", "the range of reach is not two numbers in order"),
        (
            "\"range\": [0.0, 0.5]",
            "\"rng\": [0.0, 0.5]",
            "joints[1].dofs[1].rng: unknown field `rng`, expected one of",
        ),
        (
            "\"range\": [0.0, 0.5]",
            "\"range\": [0, 1], \"follows\": {\"leader\": \"lft\", \"polynomial\": [0, 1, 0, 0, 0]}",
            "joints[1].dofs[1].follows.leader: no degree of freedom \"lft\"",
        ),
        (
            "\"range\": [0.0, 0.5]",
            "\"range\": [0, 1], \"follows\": {\"leader\": 1, \"polynomal\": [0, 1, 0, 0, 0]}",
            "unknown field `polynomal`, expected `leader` or `polynomial`",
        ),
        ("\"limb\": \"turret\"", "\"limb\": \"arm\"", "joints[0].limb differs from limb 1 of the list"),
        ("\"turret\", \"arm\"]", "\"turret\"]", "a creature with 2 limbs needs one joint fewer"),
        ("[\"base\", \"turret\", \"arm\"]", "[\"base\", \"turret\", \"turret\"]", "two limbs are called"),
        ("\"name\": \"lift\"", "\"name\": \"reach\"", "two degrees of freedom are called \"reach\""),
        ("\"name\": \"crane\",", "", "missing field `name`"),
        ("\"dofs\": [{\"name\": \"turn\", \"kind\": \"ball\"}]", "\"dofs\": []", "has no degrees of freedom"),
        ("\"limbs\": [\"base\", \"turret\", \"arm\"],", "", "missing field `limbs`"),
        ("\"limbs\": [", "\"limbs\": ", "it is not a valid description of a creature"),
    ];
    for (from, to, expected) in wrong {
        assert!(CRANE.contains(from), "{from}");
        let path = place.write("crane.json", &CRANE.replace(from, to));
        let message = sentence(&read_creature(&path).unwrap_err().to_string(), "crane.json");
        assert!(message.contains(expected), "{from} → {to}: {message}");
    }
    for (text, expected) in [
        ("[]", "expected an object"),
        ("", "ends in the middle"),
        ("{\"creature\": 1}", "expected an object"),
    ] {
        let message =
            sentence(&read_creature(&place.write("c.json", text)).unwrap_err().to_string(), "c.json");
        assert!(message.contains(expected), "{text}: {message}");
    }
}

#[test]
fn what_may_be_left_out_of_a_creature_file_is_filled_in() {
    let place = Place::new();
    let bare = read_creature(&place.write("crane.json", CRANE)).unwrap();
    let ranges: Vec<[f64; 2]> = dofs(bare.agent.creature()).iter().map(|dof| dof.range).collect();
    assert_eq!(ranges[0], [0.0, std::f64::consts::PI]);
    assert_eq!(dofs(bare.agent.creature())[0].kind, DofKind::Ball);
    // The same creature as another program would give it: indices, a skin, a session's other fields.
    let session = json!({"seed": 7, "creature": serde_json::to_value(bare.agent.creature()).unwrap(),
        "skin": {"receptors": [{"id": "r", "limb": "arm", "position": [0, 0, 0.1], "normal": [0, 0, 1],
                                "tangent": [1, 0, 0], "half_extents": [0.01, 0.01], "surface": null}]}});
    let read = read_creature(&place.write("session.json", &session.to_string())).unwrap();
    assert_eq!((read.agent.creature(), read.seed), (bare.agent.creature(), Some(7)));
    assert_eq!(read.agent.skin().receptors[0].limb, 2);
    // What follows another says so by its name, or as a session's file does.
    let coupled = |leader: &str| {
        let follows =
            format!(r#"0.5], "follows": {{"leader": {leader}, "polynomial": [0.25, 0.1, 0, 0, 0]}}"#);
        read_creature(&place.write("coupled.json", &CRANE.replace("0.5]", &follows))).unwrap().agent
    };
    let named = coupled("\"lift\"");
    assert_eq!(named, coupled("1"));
    assert_eq!(dofs(named.creature())[2].follows.unwrap().leader, 1);
    let session = json!({"creature": serde_json::to_value(named.creature()).unwrap()});
    let read = read_creature(&place.write("session.json", &session.to_string())).unwrap();
    assert_eq!(read.agent.creature(), named.creature());
}

/// The issue's own words: without the model the same schema to the last digit.
#[test]
fn a_log_without_a_model_gives_the_same_schema_to_the_last_digit() {
    let place = Place::new();
    place.write("arms.xml", &two_arms(r#"type="sphere" size="0.1""#, r#"type="capsule" size="0.03 0.2""#));
    place.succeeds(&["babble", "arms.xml", "--touches", "100", "--out", "made", "--learner", "hersch"]);
    let log = fs::read_to_string(place.path("made/touches.jsonl")).unwrap();
    let session: Value =
        serde_json::from_str(&fs::read_to_string(place.path("made/session.json")).unwrap()).unwrap();
    for input in ["receptor", "contact"] {
        place.succeeds(&["learn", "made", "--input", input]);
        let with_model = fs::read(place.path("made/schema.json")).unwrap();
        // The model is gone, and so is all of the session but its creature, skin and log.
        let parts = json!({"creature": session["creature"], "skin": session["skin"]});
        place.write("creature.json", &parts.to_string());
        place.write("touches.jsonl", &log);
        fs::rename(place.path("arms.xml"), place.path("gone.xml")).unwrap();
        let arguments = ["learn", "--creature", "creature.json", "--log", "touches.jsonl", "--input", input];
        let printed = place.succeeds(&[&arguments[..], &["--out", input]].concat());
        assert!(printed.contains("without a model"), "{printed}");
        assert_eq!(fs::read(place.path(input).join("schema.json")).unwrap(), with_model, "{input}");
        // What was made is a session as any other.
        place.succeeds(&["learn", input]);
        assert_eq!(fs::read(place.path(input).join("schema.json")).unwrap(), with_model, "{input}");
        place.succeeds(&["report", input]);
        place.succeeds(&["export", input]);
        fs::rename(place.path("gone.xml"), place.path("arms.xml")).unwrap();
        assert!(place.succeeds(&["report", input, "--model", "arms.xml"]).contains("angle between axes"));
    }
    let taken =
        place.fails(&["learn", "--creature", "creature.json", "--log", "touches.jsonl", "--out", "made"]);
    assert!(taken.contains("already contains a session"), "{taken}");
}

#[test]
fn points_and_receptors_as_comma_separated_values_are_those_of_the_log() {
    let body = creature(&two_arms(r#"type="sphere" size="0.1""#, r#"type="capsule" size="0.03 0.2""#));
    let agent = Agent::of(&body).unwrap();
    let touches = babble(&body, &agent, 60, 1, 1);
    let place = Place::new();
    let receptors = place.write("receptors.csv", &to_csv(&agent, &touches, true));
    let read = read_recording(&receptors, &agent).unwrap();
    assert_eq!((read.input, &read.agent), (Input::Receptor, &agent));
    let places = |touches: &[RecordedTouch]| -> Vec<_> {
        touches.iter().map(|t| (t.posture.clone(), t.ends.map(|end| end.receptor))).collect()
    };
    assert_eq!(places(&read.touches), places(&touches));
    // Points alone need no skin.
    let bare = agent.with_skin(Skin::default()).unwrap();
    let points = place.write("points.csv", &to_csv(&agent, &touches, false));
    let read = read_recording(&points, &bare).unwrap();
    assert_eq!(read.input, Input::Contact);
    for (a, b) in read.touches.iter().zip(&touches) {
        assert_eq!(a.exact_contact().points, b.exact_contact().points);
        let limb = |skin: &Skin, touch: &Touch| touch.ends.map(|end| skin.receptors[end.receptor].limb);
        assert_eq!(limb(read.agent.skin(), a), limb(agent.skin(), b));
    }
    // A receptor that no skin knows, and a skin that does not know it.
    let unknown = read_recording(&receptors, &bare).unwrap_err().to_string();
    assert!(unknown.contains("line 2: column receptor_a: the skin has no receptor"), "{unknown}");
}

/// Greatest mean held-out error from 1,000 touches of Max with 1 mm of noise in each coordinate of both points,
/// millimetres. The bound of the root mean square is 1.36 mm.
const NOISY_MM: f64 = 1.5;

#[test]
fn max_is_learned_from_points_with_noise_of_which_nothing_is_said() {
    let body = max("torso");
    let (agent, truth) = (Agent::of(&body).unwrap(), GroundTruth::new(&body).unwrap());
    let exact = babble(&body, &agent, 1000, 1, 2);
    let noise = Disturbances { point_noise: 1e-3, ..Default::default() };
    let touches = noise.felt(&agent, &exact, Input::Contact, 1).touches;
    for given in [None, Some(1e-3)] {
        let mut learner = SecondOrder::new(&agent, Input::Contact, 1);
        for touch in &touches {
            let mut touch = touch.clone();
            touch.ends.iter_mut().flat_map(|end| &mut end.point).for_each(|point| point.deviation = given);
            learner.touch(&touch);
        }
        let learned = learner.learn();
        assert_eq!(learned.verdict, Verdict::Converged, "{given:?}");
        // The pelvis, at the end of the longest chains, is placed to 1.8 mm, and a point to 1.4 mm.
        assert!(
            learned.undetermined().iter().all(|&joint| joint == 0),
            "{given:?}: {:?}",
            learned.undetermined()
        );
        let evaluation = evaluate(&agent, &truth, &learned.schema, &[]);
        assert!(evaluation.heldout_mm.mean < NOISY_MM, "{given:?}: {} mm", evaluation.heldout_mm.mean);
        // Both ends together.
        let seen = learned.deviation.unwrap() / (2f64.sqrt() * 1e-3);
        assert!((seen - 1.0).abs() < 0.05, "{given:?}: noise is seen {seen} times as wide as it is");
    }
}

/// Points whose deviations are given weigh as much as these say: a precise half is worth more than all alike.
#[test]
fn deviations_are_weights() {
    let body = creature(&two_arms(r#"type="sphere" size="0.1""#, r#"type="capsule" size="0.03 0.2""#));
    let (agent, truth) = (Agent::of(&body).unwrap(), GroundTruth::new(&body).unwrap());
    let exact = babble(&body, &agent, 400, 5, 1);
    let coarse =
        Disturbances { point_noise: 5e-3, ..Default::default() }.felt(&agent, &exact, Input::Contact, 5);
    let fine =
        Disturbances { point_noise: 2e-4, ..Default::default() }.felt(&agent, &exact, Input::Contact, 5);
    let learn = |given: bool| {
        let mut learner = SecondOrder::new(&agent, Input::Contact, 1);
        for (i, (fine, coarse)) in fine.touches.iter().zip(&coarse.touches).enumerate() {
            let (touch, deviation) = if i % 2 == 0 { (fine, 2e-4) } else { (coarse, 5e-3) };
            let mut touch = touch.clone();
            let points = touch.ends.iter_mut().flat_map(|end| &mut end.point);
            points.for_each(|point| point.deviation = given.then_some(deviation));
            learner.touch(&touch);
        }
        let learned = learner.learn();
        evaluate(&agent, &truth, &learned.schema, &learned.undetermined()).determined_mm.mean
    };
    let (weighed, alike) = (learn(true), learn(false));
    assert!(3.0 * weighed < alike, "weighed {weighed} mm, all alike {alike} mm");
}

#[test]
fn the_example_of_the_documentation_is_read() {
    let document = fs::read_to_string(repository("docs/recordings.md")).unwrap();
    let section = document.split("## From a robot's own recordings").nth(1).expect("the section is there");
    let block = |language: &str| {
        let (_, rest) = section.split_once(&format!("```{language}\n")).expect("a block");
        rest.split_once("```").unwrap().0.to_string()
    };
    let place = Place::new();
    let described = read_creature(&place.write("robot.json", &block("json"))).unwrap();
    let log = place.write("touches.csv", &block("csv"));
    let read = read_recording(&log, &described.agent).unwrap();
    assert_eq!((read.touches.len(), read.input, read.notes.len()), (2, Input::Contact, 0));
}

/// Touches of chance are no noise: however much of it is allowed for, they are not believed.
#[test]
fn touches_of_chance_are_not_learned() {
    let body = creature(&two_arms(r#"type="sphere" size="0.1""#, r#"type="capsule" size="0.03 0.2""#));
    let agent = Agent::of(&body).unwrap();
    let mut rng = ChaCha8Rng::seed_from_u64(1);
    let mut learner = SecondOrder::new(&agent, Input::Contact, 1);
    for mut touch in babble(&body, &agent, 40, 5, 1) {
        touch.posture = Posture::random(&body.creature, &mut rng);
        learner.touch(&touch.felt(Input::Contact));
    }
    let learned = learner.learn_in(2);
    assert!(!learned.verdict.converged());
    assert_eq!(learned.undetermined().len(), body.creature.joints().len());
}

/// Two arms of three hinges each on one base, which meet tip to tip: all of it could be one point.
#[test]
fn a_body_that_may_be_shrunk_to_a_point_is_not_claimed() {
    const UPPER: f64 = 0.3;
    const LOWER: f64 = 0.25;
    let mut log = "limb_a,limb_b,ax,ay,az,bx,by,bz,l0,l1,l2,r0,r1,r2\n".to_string();
    for k in 0..200 {
        // A place in front of the shoulders, which are 0.4 m apart, and the angles that bring both tips there.
        let k = f64::from(k);
        let place = [0.3 + 0.1 * (2.3 * k).cos(), 0.1 * (1.7 * k).sin(), 0.12 * (3.1 * k).sin()];
        let angles = |shoulder: f64, bend: f64| {
            let (x, y, z) = (place[0], place[1] - shoulder, place[2]);
            let far = x.hypot(y);
            let cosine = (far * far + z * z - UPPER * UPPER - LOWER * LOWER) / (2.0 * UPPER * LOWER);
            let elbow = bend * cosine.clamp(-1.0, 1.0).acos();
            let lift = z.atan2(far) - (LOWER * elbow.sin()).atan2(UPPER + LOWER * elbow.cos());
            [y.atan2(x), lift, elbow]
        };
        let ([l0, l1, l2], [r0, r1, r2]) = (angles(0.2, 1.0), angles(-0.2, -1.0));
        log += &format!("left,right,0.25,0,0,0.25,0,0,{l0},{l1},{l2},{r0},{r1},{r2}\n");
    }
    let joint = |name: &str, parent: &str, limb: &str| {
        let dof = json!({"name": name, "kind": "hinge", "range": [-3.2, 3.2]});
        json!({"name": name, "parent": parent, "limb": limb, "dofs": [dof]})
    };
    let body = json!({
        "name": "tips",
        "limbs": ["base", "left_turret", "left_upper", "left", "right_turret", "right_upper", "right"],
        "joints": [
            joint("l0", "base", "left_turret"), joint("l1", "left_turret", "left_upper"),
            joint("l2", "left_upper", "left"), joint("r0", "base", "right_turret"),
            joint("r1", "right_turret", "right_upper"), joint("r2", "right_upper", "right"),
        ],
    });
    let place = Place::new();
    let (body, log) = (place.write("tips.json", &body.to_string()), place.write("tips.csv", &log));
    let [body, log, session] =
        [body, log, place.path("session")].map(|path| path.to_str().unwrap().to_string());
    let said = place.succeeds(&["learn", "--creature", &body, "--log", &log, "--out", &session]);
    assert!(said.contains("NOT learned: all touches are at one point of each limb"), "{said}");
    // What to do is said, and that there is nothing to draw.
    assert!(said.contains("next: record more touches, between more pairs of limbs"), "{said}");
    let refused = place.fails(&["render", &session, "--touch", "1", "--out", "touch.png"]);
    assert!(refused.contains("the shapes of its limbs are unknown"), "{refused}");
}
