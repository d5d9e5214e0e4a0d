//! What touches feel like: the touch sensor on made-up contacts, random stimulations on physics, and `feel`.

use std::fs;
use std::process::{Command, Output};

use crate::common::{max, repository, with_agent};
use bodyschema::creature::JointSelection;
use bodyschema::senses::touch_sensor::RELEASE;
use bodyschema::senses::{
    Party, Sensation, SkinContact, SkinSpot, TouchEvent, TouchKind, TouchSensor, Toucher,
};
use bodyschema::simulation::partner::Strokes;
use bodyschema::simulation::{Stage, StageOptions, StepSenses};
use bodyschema::skin::{Skin, SomatotopicMap};
use nalgebra::Vector3;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use serde_json::{Value, json};

/// A step of the made-up contacts, seconds.
const STEP: f64 = 0.002;
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

    fn spot(&self, receptor: usize, point: Vector3<f64>) -> SkinSpot {
        SkinSpot { limb: self.skin.receptors[receptor].limb, receptor, point, sensor_force: None }
    }

    /// A contact in the middle of a receptor.
    fn on(&self, receptor: usize, thing: usize) -> SkinContact {
        let spot = self.spot(receptor, self.skin.receptors[receptor].position);
        SkinContact { spot, by: Toucher::Thing(thing), force: 1.0 }
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
                let spot = self.spot(receptor, from + (to - from) * share);
                steps.push(vec![SkinContact { spot, by: Toucher::Thing(FINGER), force: 2.0 }]);
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
        assert_eq!((felt.kind, felt.by), (kind, Party::Thing(FINGER)));
        let [side] = &felt.sides[..] else { panic!("{kind:?} has {} sides", felt.sides.len()) };
        assert_eq!(side.limb, max.skin.receptors[receptor].limb);
        assert_eq!(side.receptors.iter().map(|(r, _)| *r).collect::<Vec<_>>(), [receptor]);
        assert_eq!((side.path, side.speed, side.direction), (0.0, 0.0, Vector3::zeros()));
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
    assert!(side.direction.angle(&way) < 0.05, "{} rather than {way}", side.direction);
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
    let mut parties: Vec<Party> = felt.iter().map(|sensation| sensation.by).collect();
    parties.sort_unstable();
    assert_eq!(parties, [Party::Thing(FINGER), Party::Thing(PEN)]);
}

#[test]
fn self_touch_has_two_sides_and_no_object() {
    let max = Skinned::new();
    let [arm, chest] = ["left_forearm_05", "chest_10"].map(|id| max.receptor(id));
    let other = max.on(chest, FINGER).spot;
    let own = SkinContact { by: Toucher::Own(other), ..max.on(arm, FINGER) };
    // Something else at the same place of the arm is felt apart from it.
    let felt = max.sensations(&vec![vec![own, max.on(arm, FINGER)]; 20]);
    let (own, others): (Vec<_>, Vec<_>) = felt.iter().partition(|sensation| sensation.by == Party::Own);
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
    let probe = stage.probe_thing(0);
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
                if time > end + 0.1 {
                    break;
                }
            }
            let lasted = |sensation: &Sensation| sensation.ended - sensation.began;
            let longest = felt.iter().max_by(|a, b| lasted(&a.0).total_cmp(&lasted(&b.0)));
            let (told, _) = longest.unwrap_or_else(|| panic!("{kind:?} of seed {seed} was not felt"));
            let as_told = (told.kind, told.by, told.sides[0].limb);
            assert_eq!(as_told, (kind, Party::Thing(probe), done.limbs[0]), "seed {seed}");
            let decided = felt.last().expect("it was felt").1;
            assert!(decided - last_contact <= 0.05, "{kind:?} of seed {seed}: after {decided} s");
        }
    }
}

/// Where the skins of two limbs meet: a receptor on each, and a point on each so near the border that the way between is
/// short.
fn border(max: &Skinned, limbs: [&str; 2]) -> [(usize, Vector3<f64>); 2] {
    let on = |name: &str| {
        let limb = max.limbs.iter().position(|limb| limb == name).unwrap();
        (0..max.skin.receptors.len()).filter(move |&r| max.skin.receptors[r].limb == limb)
    };
    let way = |a: usize, b: usize| {
        let [a, b] = [a, b].map(|r| (max.skin.receptors[r].limb, max.skin.receptors[r].position));
        max.map.way_across(a, b).unwrap()
    };
    let pairs = on(limbs[0]).flat_map(|a| on(limbs[1]).map(move |b| (a, b)));
    let (a, b) = pairs.min_by(|x, y| way(x.0, x.1).total_cmp(&way(y.0, y.1))).unwrap();
    [a, b].map(|r| (r, max.skin.receptors[r].position))
}

/// The point near one of a limb where its skin ends and another's begins, downhill from there.
fn towards_border(max: &Skinned, limb: usize, p: Vector3<f64>) -> Vector3<f64> {
    let way = |p: &Vector3<f64>| max.map.way_to_border(limb, p).unwrap();
    let step = |k: usize| Vector3::ith(k % 3, if k < 3 { 1e-4 } else { -1e-4 });
    let mut p = p;
    while let Some(next) = (0..6).map(|k| p + step(k)).find(|next| way(next) < way(&p)) {
        p = next;
    }
    p
}

/// A finger that goes at 0.1 m/s from one place of a limb to another, in the limb's frame.
fn going(max: &Skinned, receptor: usize, from: Vector3<f64>, to: Vector3<f64>) -> Vec<Vec<SkinContact>> {
    let count = ((to - from).norm() / (0.1 * STEP)).ceil() as usize;
    let at = |k: usize| from + (to - from) * (k as f64 / count as f64);
    let contact = |k| SkinContact { spot: max.spot(receptor, at(k)), by: Toucher::Thing(FINGER), force: 1.0 };
    (0..count).map(|k| vec![contact(k)]).collect()
}

#[test]
fn from_one_limb_on_to_the_next_is_one_stroke_over_a_short_gap_and_none_through_air() {
    let max = Skinned::new();
    let [(a, p_a), (b, p_b)] = border(&max, ["left_upper_arm", "left_forearm"]);
    let [limb_a, limb_b] = [a, b].map(|r| max.skin.receptors[r].limb);
    let [leaves, arrives] = [(limb_a, p_a), (limb_b, p_b)].map(|(limb, p)| towards_border(&max, limb, p));
    for pause in [0, 20] {
        let gap = vec![Vec::new(); pause];
        let steps = [going(&max, a, p_a, leaves), gap, going(&max, b, arrives, p_b)].concat();
        let felt = max.sensation(&steps);
        assert_eq!(felt.kind, TouchKind::Stroke);
        let [side] = &felt.sides[..] else { panic!("{} sides", felt.sides.len()) };
        assert_eq!([side.limb, side.last_limb], [limb_a, limb_b]);
        assert_eq!(side.limbs.iter().map(|part| part.limb).collect::<Vec<_>>(), [limb_a, limb_b]);
        assert_eq!(side.receptors.iter().map(|(r, _)| *r).collect::<Vec<_>>(), [a, b]);
        let [first, second] = [&side.limbs[0], &side.limbs[1]];
        let way = (leaves - p_a).norm() + (p_b - arrives).norm();
        assert!(side.path > way - 0.01 && side.path < way + 0.03, "{} m of {way}", side.path);
        assert!(first.direction.dot(&(leaves - p_a)) > 0.0 && second.direction.dot(&(p_b - arrives)) > 0.0);
        assert!(first.span[1] < second.span[0]);
    }
    // A finger of the other arm is no neighbour: nothing goes on there.
    let far = max.receptor("right_forearm_05");
    let steps = [going(&max, a, p_a, leaves), vec![vec![max.on(far, FINGER)]; 20]].concat();
    assert_eq!(max.sensations(&steps).len(), 2);
}

#[test]
fn over_skin_without_receptors_a_stroke_goes_on_and_after_a_lift_it_does_not() {
    let max = Skinned::new();
    let unfelt = 0.015;
    let gap = vec![Vec::new(); (unfelt / (0.1 * STEP)) as usize];
    let over = |receptor: usize, from: Vector3<f64>, to: Vector3<f64>| {
        let ahead = (to - from).normalize();
        let [out, on] = [to + ahead * unfelt, to + ahead * (unfelt + 0.02)];
        [going(&max, receptor, from, to), gap.clone(), going(&max, receptor, out, on)].concat()
    };
    // From the middle of a patch over an edge beyond which its limb has no receptors for as far as the finger goes unfelt.
    let receptors = || max.skin.receptors.iter().enumerate();
    let off_the_edge = receptors().find_map(|(r, own)| {
        let felt = |p: &Vector3<f64>| {
            receptors().any(|(_, other)| other.limb == own.limb && other.feels(p, &own.normal))
        };
        (0..16).find_map(|k| {
            let angle = f64::from(k) * std::f64::consts::TAU / 16.0;
            let ahead = own.tangent * angle.cos() + own.bitangent() * angle.sin();
            let at = |distance: f64| own.position + ahead * distance;
            let edge = (10..60).map(|k| 0.001 * f64::from(k)).find(|edge| !felt(&at(*edge)))?;
            let bare = (0..10).all(|k| !felt(&at(edge + 0.1 * unfelt * f64::from(k))));
            bare.then(|| (r, own.position, at(edge - 0.001)))
        })
    });
    let (edge, from, to) = off_the_edge.expect("Max has bare skin");
    let felt = max.sensation(&over(edge, from, to));
    assert_eq!(felt.kind, TouchKind::Stroke);
    let way = (to - from).norm() + unfelt + 0.02;
    assert!((felt.sides[0].path - way).abs() < 0.01, "{} m of {way}", felt.sides[0].path);
    // In the midst of a patch that feels what comes next, silence is a finger that was lifted.
    let whole = max.receptor("left_forearm_05");
    let own = &max.skin.receptors[whole];
    assert_eq!(max.sensations(&over(whole, own.position - own.tangent * 0.02, own.position)).len(), 2);
}

#[test]
fn two_fingers_of_one_party_stay_two_and_the_two_sides_of_a_crease_are_one() {
    let max = Skinned::new();
    let receptor = max.receptor("left_forearm_05");
    let middle = max.skin.receptors[receptor].position;
    let along = max.skin.receptors[receptor].tangent;
    let at = |distance: f64| SkinContact {
        spot: max.spot(receptor, middle + along * distance),
        by: Toucher::Thing(FINGER),
        force: 1.0,
    };
    for (apart, count) in [(0.025, 2), (0.012, 1)] {
        let felt = max.sensations(&vec![vec![at(-0.5 * apart), at(0.5 * apart)]; 20]);
        assert_eq!(felt.len(), count, "{apart} m apart");
    }
    // One lies still while the other passes it: a press and a stroke, though they come near each other.
    let passing = |k: usize| {
        let stays = at(0.0);
        let passes = SkinContact {
            spot: max.spot(
                receptor,
                middle
                    + along * (-0.03 + 0.1 * STEP * k as f64)
                    + max.skin.receptors[receptor].bitangent() * 0.012,
            ),
            ..at(0.0)
        };
        vec![stays, passes]
    };
    let felt = max.sensations(&(0..300).map(passing).collect::<Vec<_>>());
    let mut kinds: Vec<TouchKind> = felt.iter().map(|sensation| sensation.kind).collect();
    kinds.sort_unstable();
    assert_eq!(kinds, [TouchKind::Press, TouchKind::Stroke]);
    // Where a finger lies in the bend of a joint both limbs feel it: that is one press. Farther apart along the skin, on
    // either side of the joint, are two fingers.
    let [(a, p_a), (b, p_b)] = border(&max, ["left_forearm", "left_hand"]);
    let ends = [(a, p_a), (b, p_b)].map(|(r, p)| (r, p, towards_border(&max, max.skin.receptors[r].limb, p)));
    let spots = |share: f64| ends.map(|(r, p, to)| max.spot(r, to + (p - to) * share));
    let way = |[one, other]: [SkinSpot; 2]| {
        max.map.way_across((one.limb, one.point), (other.limb, other.point)).unwrap()
    };
    for (apart, count) in [(0.012, 1), (0.035, 2)] {
        let wide = (0..400).map(|k| spots(0.01 * f64::from(k))).find(|spots| way(*spots) >= apart);
        let wide = wide.expect("the limbs are long enough");
        assert!(way(wide) < apart + 0.003, "{} m in place of {apart}", way(wide));
        let both = wide.map(|spot| SkinContact { spot, by: Toucher::Thing(FINGER), force: 1.0 });
        assert_eq!(max.sensations(&vec![both.to_vec(); 200]).len(), count, "{apart} m apart over the wrist");
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
    let on = |name: &str| -> Vec<usize> {
        let limb = stage.agent().creature().limb(name).unwrap();
        let receptors = &stage.skin().receptors;
        (0..receptors.len()).filter(|&r| receptors[r].limb == limb).collect()
    };
    let arm = vec![["left_upper_arm", "left_forearm"], ["right_upper_arm", "right_forearm"]];
    // From the back of the hand to a fingertip, on whichever finger a probe gets there between the others.
    let fingers = ["thumb", "index", "middle", "ring", "little"].map(|name| format!("left_{name}_distal"));
    let finger: Vec<[&str; 2]> = fingers.iter().map(|tip| ["left_hand", tip.as_str()]).collect();
    for ways in [arm, finger] {
        let mut rng = ChaCha8Rng::seed_from_u64(1);
        let done = ways.iter().find_map(|[from, to]| {
            let (first, last) = (on(from), on(to));
            let mut pairs = first.iter().flat_map(|&a| last.iter().map(move |&b| (a, b)));
            let done = pairs.find_map(|(a, b)| Strokes::new(&stage).between(a, b, stage.time(), &mut rng))?;
            Some((done, *from, *to))
        });
        let (done, from, to) = done.unwrap_or_else(|| panic!("no way for any of {ways:?}"));
        let end = done.path.end();
        stage.send_probe(0, done.path).unwrap();
        let mut felt = Vec::new();
        while stage.time() < end + 0.1 {
            felt.extend(stage.step().unwrap().touches.into_iter().filter_map(|event| match event {
                TouchEvent::Sensed { sensation, .. } => Some(sensation),
                TouchEvent::Began { .. } => None,
            }));
        }
        let [felt] = &felt[..] else { panic!("from {from} to {to} are {} sensations", felt.len()) };
        let limbs = |ends: [usize; 2]| ends.map(|limb| stage.agent().creature().limbs()[limb].clone());
        assert_eq!(felt.kind, TouchKind::Stroke);
        assert_eq!(limbs([felt.sides[0].limb, felt.sides[0].last_limb]), [from, to]);
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
        (Some(backwards), "order of time"),
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
