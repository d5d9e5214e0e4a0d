//! What touches feel like: the touch sensor on made-up contacts, random stimulations on physics, and `feel`.

use std::fs;
use std::process::{Command, Output};

use crate::common::{max, repository, with_agent};
use bodyschema::creature::JointSelection;
use bodyschema::senses::touch_sensor::RELEASE;
use bodyschema::senses::{Sensation, SkinContact, SkinSpot, TouchEvent, TouchKind, TouchSensor, Toucher};
use bodyschema::simulation::partner::Strokes;
use bodyschema::simulation::{Stage, StageOptions, StepSenses};
use bodyschema::skin::{Skin, SomatotopicMap};
use nalgebra::Vector3;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use serde_json::{Value, json};

/// A step of the made-up contacts, seconds.
const STEP: f64 = 0.002;
/// How long after the last contact a touch is decided at the most, seconds: one that stayed on its patch …
const SOON: f64 = 0.05;
/// … and one that moved and may go on beyond a hole in the skin.
const LONGEST: f64 = 0.24;
/// The model's bodies that touch, whichever they are.
const FINGER: usize = 1001;
const PEN: usize = 1002;

/// Max's skin, for contacts that nothing has simulated.
struct Skinned {
    limbs: Vec<String>,
    skin: Skin,
    map: SomatotopicMap,
}

impl Skinned {
    fn new() -> Skinned {
        let (body, agent) = with_agent(max("torso"));
        let map = SomatotopicMap::at_ease(&body, agent.skin()).unwrap();
        Skinned { limbs: agent.creature().limbs().to_vec(), skin: agent.skin().clone(), map }
    }

    fn receptor(&self, id: &str) -> usize {
        self.skin.receptor(id).unwrap_or_else(|| panic!("Max has no receptor {id}"))
    }

    fn spot(&self, receptor: usize) -> SkinSpot {
        SkinSpot { limb: self.skin.receptors[receptor].limb, receptor }
    }

    /// A contact that a receptor feels.
    fn on(&self, receptor: usize, thing: usize) -> SkinContact {
        SkinContact { spot: self.spot(receptor), by: Toucher::Thing(thing), force: 1.0 }
    }

    /// Whether the map has a neighbour of `b`, on its limb or another, for what comes from `a` and goes straight on.
    fn goes_on(&self, a: usize, b: usize) -> bool {
        let [from, to] = [a, b].map(|r| &self.skin.receptors[r]);
        self.map.neighbours(b).iter().map(|&next| &self.skin.receptors[next]).any(|next| {
            next.limb != to.limb || (next.position - to.position).angle(&(to.position - from.position)) < 0.8
        })
    }

    /// All pairs of neighbours, either way round.
    fn pairs(&self) -> impl Iterator<Item = [usize; 2]> {
        self.map.pairs().flat_map(|[a, b]| [[a, b], [b, a]])
    }

    fn limb_of(&self, receptor: usize) -> usize {
        self.skin.receptors[receptor].limb
    }

    /// Three receptors that lie nearly in a line, each the next one's neighbour, and more than 2 cm long in all.
    fn row(&self) -> [usize; 3] {
        let position = |r: usize| self.skin.receptors[r].position;
        for a in 0..self.skin.receptors.len() {
            for &b in self.map.neighbours(a) {
                for &c in self.map.neighbours(b) {
                    let (first, second) = (position(b) - position(a), position(c) - position(b));
                    if first.angle(&second) < 0.2 && first.norm().min(second.norm()) > 0.02 {
                        return [a, b, c];
                    }
                }
            }
        }
        panic!("Max has no row of receptors");
    }

    /// Contacts of a finger that goes straight from one receptor's middle to the next one's at 0.1 m/s.
    fn along(&self, way: &[usize]) -> Vec<Vec<SkinContact>> {
        let mut steps = Vec::new();
        for pair in way.windows(2) {
            let [from, to] = [pair[0], pair[1]].map(|r| self.skin.receptors[r].position);
            let count = ((to - from).norm() / (0.1 * STEP)).ceil() as usize;
            for k in 0..count {
                let share = k as f64 / count as f64;
                let receptor = if share < 0.5 { pair[0] } else { pair[1] };
                steps.push(vec![SkinContact { force: 2.0, ..self.on(receptor, FINGER) }]);
            }
        }
        steps
    }

    /// The events of contacts step by step, and of nothing for long enough after them.
    fn events(&self, steps: &[Vec<SkinContact>]) -> Vec<TouchEvent> {
        let mut sensor = TouchSensor::new(self.map.clone(), &self.skin);
        // Longer than what may come back is waited for.
        let silence = vec![Vec::new(); (20.0 * RELEASE / STEP) as usize];
        let steps = steps.iter().chain(&silence).enumerate();
        steps.flat_map(|(k, contacts)| sensor.follow(STEP * k as f64, contacts)).collect()
    }

    /// The sensations, of which each must have begun before.
    fn sensations(&self, steps: &[Vec<SkinContact>]) -> Vec<Sensation> {
        let (mut begun, mut sensations) = (Vec::new(), Vec::new());
        for event in self.events(steps) {
            match event {
                TouchEvent::Began { number, .. } => begun.push(number),
                TouchEvent::Sensed { number, sensation } => {
                    assert!(begun.contains(&number), "{number} has not begun");
                    sensations.push(sensation);
                }
            }
        }
        assert_eq!(begun.len(), sensations.len(), "what began has ended");
        sensations
    }

    /// The one sensation of these contacts.
    fn sensation(&self, steps: &[Vec<SkinContact>]) -> Sensation {
        let found = self.sensations(steps);
        let [sensation] = &found[..] else { panic!("{} sensations in place of one", found.len()) };
        sensation.clone()
    }
}

#[test]
fn at_one_place_a_short_touch_is_a_tap_and_a_long_one_a_press() {
    let max = Skinned::new();
    let receptor = max.receptor("left_forearm_05");
    for (steps, kind) in [(25, TouchKind::Tap), (250, TouchKind::Press)] {
        let felt = max.sensation(&vec![vec![max.on(receptor, FINGER)]; steps]);
        assert_eq!((felt.kind, felt.by), (kind, Toucher::Thing(FINGER)));
        let [side] = &felt.sides[..] else { panic!("{kind:?} has {} sides", felt.sides.len()) };
        assert_eq!(side.limb, max.skin.receptors[receptor].limb);
        assert_eq!(side.receptors.iter().map(|(r, _)| *r).collect::<Vec<_>>(), [receptor]);
        assert_eq!((side.path, side.speed, side.limbs[0].direction), (0.0, 0.0, Vector3::zeros()));
        assert!((felt.ended - felt.began - STEP * (steps - 1) as f64).abs() < 1e-9);
        assert!((felt.peak_force - 1.0).abs() < 1e-12 && (felt.mean_force - 1.0).abs() < 1e-12);
    }
}

#[test]
fn along_a_row_of_receptors_is_a_stroke_with_its_order_and_direction() {
    let max = Skinned::new();
    let row = max.row();
    let felt = max.sensation(&max.along(&row));
    assert_eq!(felt.kind, TouchKind::Stroke);
    let side = &felt.sides[0];
    assert_eq!(side.receptors.iter().map(|(r, _)| *r).collect::<Vec<_>>(), row);
    assert!(side.receptors.windows(2).all(|pair| pair[0].1[0] < pair[1].1[0]), "{:?}", side.receptors);
    let way = max.skin.receptors[row[2]].position - max.skin.receptors[row[0]].position;
    let direction = side.limbs[0].direction;
    assert!(direction.angle(&way) < 0.05, "{direction} rather than {way}");
    assert!((side.path - way.norm()).abs() < 0.006, "{} m of {}", side.path, way.norm());
    assert!((side.speed - 0.1).abs() < 0.02, "{} m/s", side.speed);
}

#[test]
fn to_and_fro_is_a_rub() {
    let max = Skinned::new();
    let [a, b, _] = max.row();
    assert_eq!(max.sensation(&max.along(&[a, b, a, b])).kind, TouchKind::Rub);
}

#[test]
fn a_bounce_shorter_than_the_release_stays_one_sensation() {
    let max = Skinned::new();
    let touching = vec![vec![max.on(max.receptor("left_forearm_05"), FINGER)]; 10];
    for (pause, count) in [(0.8 * RELEASE, 1), (1.5 * RELEASE, 2)] {
        let apart = vec![Vec::new(); (pause / STEP) as usize];
        let steps = [touching.clone(), apart, touching.clone()].concat();
        assert_eq!(max.sensations(&steps).len(), count, "after {pause} s apart");
    }
}

#[test]
fn two_parties_at_one_place_are_two_sensations() {
    let max = Skinned::new();
    let receptor = max.receptor("left_forearm_05");
    let both = vec![max.on(receptor, FINGER), max.on(receptor, PEN)];
    let felt = max.sensations(&vec![both; 20]);
    let mut parties: Vec<Option<usize>> = felt.iter().map(|sensation| sensation.by.thing()).collect();
    parties.sort_unstable();
    assert_eq!(parties, [Some(FINGER), Some(PEN)]);
}

#[test]
fn self_touch_has_two_sides_and_no_object() {
    let max = Skinned::new();
    let [arm, chest] = ["left_forearm_05", "chest_10"].map(|id| max.receptor(id));
    let other = max.on(chest, FINGER).spot;
    let own = SkinContact { by: Toucher::Own(other), ..max.on(arm, FINGER) };
    // Something else at the same place of the arm is felt apart from it.
    let felt = max.sensations(&vec![vec![own, max.on(arm, FINGER)]; 20]);
    let (own, others): (Vec<_>, Vec<_>) = felt.iter().partition(|sensation| sensation.by.own().is_some());
    assert_eq!((own.len(), others.len()), (1, 1));
    let limbs: Vec<usize> = own[0].sides.iter().map(|side| side.limb).collect();
    assert_eq!(limbs, [arm, chest].map(|receptor| max.skin.receptors[receptor].limb));
    assert_eq!(others[0].sides.len(), 1);
}

#[test]
fn random_stimulations_of_max_are_told_right_and_soon() {
    let options = StageOptions {
        joints: JointSelection::All,
        probes: vec!["probe".to_string()],
        ..StageOptions::default()
    };
    let stage = Stage::new(&repository("mjcf/max/max.xml"), &options).expect("Max can be touched");
    let probe = stage.thing("probe").unwrap();
    for seed in [1, 2] {
        for (k, kind) in TouchKind::ALL.into_iter().enumerate() {
            let mut rng = ChaCha8Rng::seed_from_u64(seed);
            rng.set_stream(k as u64);
            let done = Strokes::new(&stage).random(kind, stage.time(), &mut rng);
            let done = done.expect("Max has room for it");
            let end = done.path.end();
            stage.send_probe(0, done.path).unwrap();
            let (mut last_contact, mut felt) = (f64::NAN, Vec::new());
            loop {
                let StepSenses { time, contacts, touches, .. } = stage.step().unwrap();
                if contacts.iter().any(|contact| contact.by == Toucher::Thing(probe)) {
                    last_contact = time;
                }
                felt.extend(touches.into_iter().filter_map(|event| match event {
                    TouchEvent::Sensed { sensation, .. } => Some((sensation, time)),
                    TouchEvent::Began { .. } => None,
                }));
                // Longer than what may come back is waited for.
                if time > end + 1.0 {
                    break;
                }
            }
            let lasted = |sensation: &Sensation| sensation.ended - sensation.began;
            let longest = felt.iter().max_by(|a, b| lasted(&a.0).total_cmp(&lasted(&b.0)));
            let (told, _) = longest.unwrap_or_else(|| panic!("{kind:?} of seed {seed} was not felt"));
            let as_told = (told.kind, told.by, told.sides[0].limb);
            assert_eq!(as_told, (kind, Toucher::Thing(probe), done.limbs[0]), "seed {seed}");
            let decided = felt.last().expect("it was felt").1;
            let most = if matches!(kind, TouchKind::Tap | TouchKind::Press) { SOON } else { LONGEST };
            assert!(decided - last_contact <= most, "{kind:?} of seed {seed}: after {decided} s");
        }
    }
}

/// A receptor of one limb, its neighbour there, and that one's neighbour on another limb.
fn over_a_joint(max: &Skinned, limbs: [&str; 2]) -> [usize; 3] {
    let limbs = limbs.map(|name| max.limbs.iter().position(|limb| limb == name).unwrap());
    let found = max.pairs().filter(|pair| pair.map(|r| max.limb_of(r)) == limbs).find_map(|[a, b]| {
        let before = max.map.neighbours(a).iter().find(|&&other| max.limb_of(other) == limbs[0])?;
        Some([*before, a, b])
    });
    found.expect("the map goes over the joint")
}

#[test]
fn from_one_limb_on_to_the_next_is_one_stroke_over_a_short_gap_and_none_through_air() {
    let max = Skinned::new();
    let [before, a, b] = over_a_joint(&max, ["left_upper_arm", "left_forearm"]);
    let stays = |receptor: usize| vec![vec![max.on(receptor, FINGER)]; 40];
    for pause in [0, 20] {
        let steps = [max.along(&[before, a]), vec![Vec::new(); pause], stays(b)].concat();
        let felt = max.sensation(&steps);
        assert_eq!(felt.kind, TouchKind::Stroke);
        let [side] = &felt.sides[..] else { panic!("{} sides", felt.sides.len()) };
        assert_eq!([side.limb, side.last_limb], [a, b].map(|r| max.limb_of(r)));
        assert_eq!(
            side.limbs.iter().map(|part| part.limb).collect::<Vec<_>>(),
            [a, b].map(|r| max.limb_of(r))
        );
        assert_eq!(side.receptors.iter().map(|(r, _)| *r).collect::<Vec<_>>(), [before, a, b]);
        let way = max.skin.receptors[a].position - max.skin.receptors[before].position;
        assert!(side.path > way.norm() && side.limbs[0].direction.dot(&way) > 0.0);
        assert!(side.limbs[0].span[1] < side.limbs[1].span[0]);
    }
    // A finger of the other arm is no neighbour: nothing goes on there.
    let far = max.receptor("right_forearm_05");
    assert_eq!(max.sensations(&[max.along(&[before, a]), stays(far)].concat()).len(), 2);
}

#[test]
fn over_skin_without_receptors_a_stroke_goes_on_and_after_a_lift_it_does_not() {
    let max = Skinned::new();
    let gap = vec![Vec::new(); (0.015 / (0.1 * STEP)) as usize];
    let position = |r: usize| max.skin.receptors[r].position;
    let extent = |r: usize| 0.5 * max.skin.receptors[r].half_extents.iter().sum::<f64>();
    let on_one_limb = || max.pairs().filter(|[a, b]| max.limb_of(*a) == max.limb_of(*b));
    // From the last receptor before bare skin to one that is no neighbour of its, not far beyond.
    let over = on_one_limb().filter(|[a, b]| !max.goes_on(*a, *b)).find_map(|[a, b]| {
        let beyond = |&c: &usize| {
            let way = (position(c) - position(b)).norm() - extent(b) - extent(c);
            max.limb_of(c) == max.limb_of(b)
                && !max.map.adjacent(b, c)
                && c != a
                && (0.0..0.02).contains(&way)
        };
        Some([a, b, (0..max.skin.receptors.len()).find(beyond)?])
    });
    let [a, b, c] = over.expect("Max has bare skin");
    let steps = [max.along(&[a, b]), gap, vec![vec![max.on(c, FINGER)]; 20]].concat();
    let felt = max.sensation(&steps);
    assert_eq!((felt.kind, felt.sides[0].receptors.len()), (TouchKind::Stroke, 3));
    // In the midst of receptors that feel what comes next, a longer silence is a finger that was lifted.
    let at_joint = |r: usize| max.map.neighbours(r).iter().any(|&other| max.limb_of(other) != max.limb_of(r));
    let midst = on_one_limb().find(|[a, b]| max.goes_on(*a, *b) && !at_joint(*b)).unwrap();
    let lift = vec![Vec::new(); (0.04 / (0.1 * STEP)) as usize];
    let steps = [max.along(&midst), lift, vec![vec![max.on(midst[1], FINGER)]; 20]].concat();
    assert_eq!(max.sensations(&steps).len(), 2);
}

#[test]
fn two_fingers_of_one_party_stay_two_and_the_two_sides_of_a_crease_are_one() {
    let max = Skinned::new();
    let [a, b, c] = max.row();
    assert!(!max.map.adjacent(a, c));
    for (fingers, count) in [([a, c], 2), ([a, b], 1)] {
        let felt = max.sensations(&vec![fingers.map(|r| max.on(r, FINGER)).to_vec(); 20]);
        assert_eq!(felt.len(), count, "{fingers:?}");
    }
    // Where a finger lies in the bend of a joint both limbs feel it: that is one press.
    let [before, side, other] = over_a_joint(&max, ["left_forearm", "left_hand"]);
    let apart = max.map.neighbours(before).iter().find(|&&r| !max.map.adjacent(r, other) && r != side);
    for (fingers, count) in [([side, other], 1), ([*apart.unwrap(), other], 2)] {
        let felt = max.sensations(&vec![fingers.map(|r| max.on(r, FINGER)).to_vec(); 200]);
        assert_eq!(felt.len(), count, "{fingers:?} over the wrist");
        assert!(felt.iter().all(|felt| felt.kind == TouchKind::Press));
    }
}

#[test]
fn strokes_over_joints_of_max_are_one_sensation_each() {
    let options = StageOptions {
        joints: JointSelection::All,
        probes: vec!["probe".to_string()],
        ..StageOptions::default()
    };
    let stage = Stage::new(&repository("mjcf/max/max.xml"), &options).expect("Max can be touched");
    for (joints, seed) in [(1, 1), (1, 2), (2, 1), (2, 2)] {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let done = Strokes::new(&stage).across(joints, stage.time(), &mut rng).expect("Max has room");
        let end = done.path.end();
        stage.send_probe(0, done.path).unwrap();
        let mut felt = Vec::new();
        while stage.time() < end + 1.0 {
            felt.extend(stage.step().unwrap().touches.into_iter().filter_map(|event| match event {
                TouchEvent::Sensed { sensation, .. } => Some(sensation),
                TouchEvent::Began { .. } => None,
            }));
        }
        let [felt] = &felt[..] else { panic!("{:?} are {} sensations", done.limbs, felt.len()) };
        assert_eq!(felt.kind, TouchKind::Stroke);
        let ends = [done.limbs[0], done.limbs[joints]];
        assert_eq!([felt.sides[0].limb, felt.sides[0].last_limb], ends);
    }
}

/// `bodyschema skin feel` of Max with a script of this text.
fn feel(script: Option<&str>) -> Output {
    let place = tempfile::tempdir().unwrap();
    if let Some(script) = script {
        fs::write(place.path().join("touches.json"), script).unwrap();
    }
    let mut command = Command::new(env!("CARGO_BIN_EXE_bodyschema"));
    command.args(["skin", "feel"]).arg(repository("mjcf/max/max.xml")).args(["--script", "touches.json"]);
    command.current_dir(place.path()).env("RUST_BACKTRACE", "0").output().unwrap()
}

/// A script of one probe with these waypoints.
fn script(path: Value) -> String {
    json!({"probes": [{"name": "finger", "path": path}]}).to_string()
}

fn waypoint(time: f64, height: f64) -> Value {
    json!({"time": time, "receptor": "left_forearm_05", "height": height})
}

#[test]
fn feel_prints_what_begins_and_then_what_it_was() {
    let tap = json!([waypoint(0.0, 0.03), waypoint(0.3, -0.005), waypoint(0.4, 0.03)]);
    let output = feel(Some(&script(tap)));
    let message = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(0), "{message}");
    let text = String::from_utf8(output.stdout).unwrap();
    let events: Vec<Value> = text.lines().map(|line| serde_json::from_str(line).unwrap()).collect();
    let names: Vec<&str> = events.iter().filter_map(|event| event["event"].as_str()).collect();
    // A probe that stops above the skin swings back a little, which may alarm again.
    assert_eq!(names[..4], ["entered", "alarm", "began", "sensed"], "{text}");
    let [entered, alarm, began, sensed] = &events[..4] else { panic!("four events: {text}") };
    assert_eq!((&entered["by"], &entered["aura_limb"]), (&json!("finger"), &json!("left_forearm")));
    assert_eq!(alarm["contact"]["limb"], "left_forearm");
    let predicted = alarm["time"].as_f64().unwrap() + alarm["contact"]["time_to_contact"].as_f64().unwrap();
    assert!((predicted - began["time"].as_f64().unwrap()).abs() < 0.15, "{text}");
    assert_eq!((&began["event"], &sensed["event"]), (&json!("began"), &json!("sensed")));
    assert_eq!(began["number"], sensed["number"]);
    assert!(began["time"].as_f64() < sensed["time"].as_f64());
    for event in [began, sensed] {
        assert_eq!((&event["by"], &event["self_touch"]), (&json!("finger"), &json!(false)));
    }
    assert_eq!(began["places"][0]["receptor"], "left_forearm_05");
    assert_eq!((&sensed["kind"], &sensed["sides"][0]["limb"]), (&json!("tap"), &json!("left_forearm")));
    assert_eq!(sensed["began"], began["time"]);
}

#[test]
fn wrong_scripts_are_told_in_one_sentence() {
    let backwards = script(json!([waypoint(0.3, 0.03), waypoint(0.1, 0.0)]));
    let unknown = script(json!([{"time": 0.0, "receptor": "third_elbow_01"}]));
    let nowhere = script(json!([{"time": 0.0}]));
    let cases = [
        (Some("{\"probes\": [".to_string()), "line 1"),
        (Some(r#"{"probes": [{"name": "finger", "path": [], "colour": "red"}]}"#.to_string()), "colour"),
        (Some(unknown), "third_elbow_01"),
        (Some(backwards), "order them by time"),
        (Some(script(json!([]))), "no path"),
        (Some(nowhere), "\"at\" or \"receptor\""),
        (None, "cannot be read"),
    ];
    for (script, word) in cases {
        let output = feel(script.as_deref());
        let message = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(1), "{script:?}: {message}");
        assert!(output.stdout.is_empty(), "{script:?} prints something");
        assert_eq!(message.trim_end().lines().count(), 1, "{script:?}: {message}");
        assert!(
            message.starts_with("bodyschema: ") && !message.contains("panicked"),
            "{script:?}: {message}"
        );
        for word in [word, "touches.json"] {
            assert!(message.contains(word), "no \"{word}\" in: {message}");
        }
    }
}
