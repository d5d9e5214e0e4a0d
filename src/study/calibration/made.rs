//! Simulated robots and logs, with and without faults, to test the verdict on a calibration.
//!
//! A robot is one arm or two of four to six hinges by Denavit and Hartenberg's numbers, whose encoders are off by up to 5° and
//! whose offsets are to be found. Its log is of one kind of data, and has at most one fault.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use nalgebra::{Rotation3, Vector3};
use rand::{Rng, RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use crate::calibration::robot::{Element, Form, Knowledge, LinkMass, Posed, Robot, Unit, Value};
use crate::calibration::{End, Feature, Touch, drop_repeats};
use crate::creature::DofKind;
use crate::geometry::Frame;
use crate::named::named;
use crate::session::simulated::normal;

named! {
    "data",
    /// What a log is of.
    #[derive(Clone, Copy, Debug, PartialEq, Eq)]
    pub enum Data {
        /// Points of two hands that met.
        SelfTouch = "self-touch",
        /// Points of a hand on three plates.
        Plate = "plate",
        /// Targets on a hand as a tracker sees them that stands nobody knows exactly where.
        Tracker = "tracker",
        /// Tips of a tool in sockets of which one robot in two knows where they are.
        Place = "place",
    }
}

named! {
    "case",
    /// What is wrong with a robot or its log.
    #[derive(Clone, Copy, Debug, PartialEq, Eq)]
    pub enum Fault {
        /// Nothing but what is to be found.
        None = "none",
        /// An encoder always reads the same.
        DeadEncoder = "dead-encoder",
        /// An encoder's gain is off by 5 to 15 %.
        Gain = "gain",
        /// An encoder is off by 4 to 8° that is said to be right.
        Offset = "offset",
        /// The table is of the other convention.
        Convention = "convention",
        /// An encoder counts the other way.
        Sign = "sign",
        /// What is on the hand slips by 8 to 15 mm in the course of the log.
        SlippedMount = "slipped-mount",
        /// Every row is there several times.
        Copies = "copies",
        /// There are three rows, or six that give one equation each.
        FewRows = "few-rows",
        /// One touch in ten is of another place.
        Outliers = "outliers",
        /// Noise is said to be a quarter of what it is.
        WrongStd = "wrong-std",
        /// A joint gives way to the weight of what it carries.
        Compliance = "compliance",
    }
}

impl Fault {
    /// Whether a log with it can be calibrated by all the same.
    pub fn is_harmless(self) -> bool {
        matches!(self, Fault::None | Fault::Copies | Fault::Outliers)
    }
}

/// A robot, its log, and what there is to say about them.
pub struct Made {
    /// The robot as its maker has it, with what is to be found.
    pub robot: Robot,
    /// The log.
    pub touches: Vec<Touch>,
    /// The true values.
    pub truth: Vec<Value>,
    /// What an objection is to name: a joint, a mount, the convention; `None` if there is nothing to name.
    pub faulty: Option<String>,
}

/// Rows of a log.
const ROWS: usize = 90;
/// Postures for each row from which a touch is looked for, at the most.
const ATTEMPTS: usize = 100;
/// Links' lengths, where points of a hand are, joints' ranges and greatest offsets, metres and radians.
const LENGTHS: [f64; 2] = [0.08, 0.3];
const HAND: f64 = 0.06;
const RANGE: f64 = 1.3;
const OFF: f64 = 0.09;
/// How differently a hand sags for a joint that gives way at the least, metres.
const SAG: f64 = 2e-3;
/// How far off a tracker and free sockets are, metres and radians.
const MISPLACED: f64 = 0.01;
const TURNED: f64 = 0.02;

impl Made {
    /// The robot of a seed with a log of some data and a fault: the first whose touches can be made.
    pub fn new(data: Data, fault: Fault, seed: u64) -> Made {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        loop {
            if let Some(made) = Made::drawn(data, fault, seed, &mut rng) {
                return made;
            }
        }
    }

    /// A robot and its log. `None` if what is to touch is out of reach.
    fn drawn(data: Data, fault: Fault, seed: u64, rng: &mut ChaCha8Rng) -> Option<Made> {
        let mut robot = Robot::new("made", "base");
        let sides: &[(&str, f64)] =
            if data == Data::SelfTouch { &[("left", 0.15), ("right", -0.15)] } else { &[("arm", 0.0)] };
        let hands: Vec<usize> = sides.iter().map(|(side, y)| add_arm(&mut robot, side, *y, rng)).collect();
        robot.mount_all();
        let body = as_it_is(&robot, fault);
        let surroundings = surroundings(&mut robot, (&body, hands[0]), data, rng);
        let mut made = Made { truth: robot.nominal(), touches: Vec::new(), faulty: None, robot };
        made.misplace(data, &surroundings, rng);
        let may_be = |dof: &usize| {
            let name = &made.robot.dofs[*dof].name;
            match fault {
                // What turns all of a robot looks like surroundings that are turned.
                Fault::Offset => !name.ends_with("_j1"),
                Fault::Compliance => {
                    made.gives_way(*dof, hands[usize::from(name.starts_with("right"))], seed)
                }
                _ => true,
            }
        };
        let dofs: Vec<usize> = (0..made.robot.dofs.len()).filter(may_be).collect();
        let dof = dofs.get(rng.random_range(0..dofs.len().max(1))).copied().unwrap_or_default();
        made.spoil(fault, dof, rng);
        let noise = 10f64.powf(rng.random_range(-3.6..-3.0));
        let is_said = rng.random_bool(0.5) || fault == Fault::WrongStd;
        let said = noise * if fault == Fault::WrongStd { 0.25 } else { 1.0 };
        made.log(data, (&hands, &surroundings), fault, [noise, rng.random_range(0.3..0.7)], rng)?;
        for end in made.touches.iter_mut().flat_map(|touch| &mut touch.ends).flatten() {
            // One side is measured, or both alike.
            let of_hand = hands.contains(&end.feature.link(&made.robot));
            let share = match data {
                Data::SelfTouch => 0.5f64.sqrt(),
                _ => f64::from(u8::from(of_hand == (data != Data::Tracker))),
            };
            end.deviation = is_said.then_some(share * said);
        }
        made.spoil_log(fault, dof, rng);
        Some(made)
    }

    /// Puts encoders off, and what stands about where nobody knows exactly; says what is to be found.
    fn misplace(&mut self, data: Data, surroundings: &[Feature], rng: &mut impl Rng) {
        let free = data == Data::Tracker || (data == Data::Place && rng.random_bool(0.5));
        // What turns all of a robot looks like surroundings that are turned.
        let offsets: Vec<usize> =
            self.robot.encoders().skip(usize::from(free)).map(|(_, q)| q.offset).collect();
        for offset in offsets {
            self.truth[offset] = Value::Number(rng.random_range(-OFF..OFF));
            self.robot.quantities[offset].knowledge[0] = Knowledge::Free;
        }
        for feature in surroundings.iter().filter(|_| free) {
            for element in self.robot.links[feature.link(&self.robot)].elements.clone() {
                let (Element::Shift(q) | Element::Turn(q)) = element else { continue };
                let size = if self.robot.quantities[q].unit == Unit::Metre { MISPLACED } else { TURNED };
                self.robot.quantities[q].nominal = self.truth[q].stepped(point(size, rng).as_slice());
                self.robot.quantities[q].knowledge = [Knowledge::Free; 3];
            }
        }
    }

    /// Whether its hand is elsewhere in some postures than in others for a joint that gives way: no weight turns about what is upright.
    fn gives_way(&self, dof: usize, hand: usize, seed: u64) -> bool {
        let Some(q) = self.robot.dofs[dof].quantities else { return false };
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let mut soft = self.truth.clone();
        soft[q.compliance] = Value::Number(0.01);
        let by = |_| {
            let posture = posture(&self.robot, RANGE, &mut rng);
            let [soft, stiff] =
                [&soft, &self.truth].map(|values| hand_at(&self.robot, values, &posture, hand));
            (soft - stiff).norm()
        };
        let moves: Vec<f64> = (0..30).map(by).collect();
        let mean = moves.iter().sum::<f64>() / moves.len() as f64;
        moves.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / moves.len() as f64 > SAG.powi(2)
    }

    /// What is wrong with the robot.
    fn spoil(&mut self, fault: Fault, dof: usize, rng: &mut impl Rng) {
        let Some(q) = self.robot.dofs[dof].quantities else { return };
        let size = rng.random_range(0.0..1.0);
        let mut either = |size: f64| if rng.random_bool(0.5) { size } else { -size };
        let wrong = match fault {
            Fault::Gain => Some((q.gain, 1.0 + either(0.05 + 0.1 * size))),
            Fault::Offset => Some((q.offset, either(0.07 + 0.07 * size))),
            Fault::Sign => Some((q.sign, -1.0)),
            Fault::Compliance => Some((q.compliance, 0.01 + 0.02 * size)),
            _ => None,
        };
        if let Some((quantity, number)) = wrong {
            self.truth[quantity] = Value::Number(number);
            self.robot.quantities[quantity].knowledge[0] = Knowledge::Known;
        }
        self.faulty = match fault {
            Fault::Convention => Some("convention".into()),
            Fault::SlippedMount => Some("mount".into()),
            Fault::DeadEncoder => Some(self.robot.dofs[dof].name.clone()),
            _ => wrong.map(|_| self.robot.dofs[dof].name.clone()),
        };
    }

    /// The touches, of the robot as it is.
    fn log(
        &mut self,
        data: Data,
        (hands, surroundings): (&[usize], &[Feature]),
        fault: Fault,
        [noise, slips]: [f64; 2],
        rng: &mut ChaCha8Rng,
    ) -> Option<()> {
        let robot = as_it_is(&self.robot, fault);
        let mut truth = self.truth.clone();
        let tips: Vec<Vector3<f64>> = (0..3).map(|_| point(HAND, rng)).collect();
        let rows = match (fault, data) {
            (Fault::FewRows, Data::Plate) => 6,
            (Fault::FewRows, _) => 3,
            _ => ROWS,
        };
        for _ in 0..=ATTEMPTS * rows {
            let k = self.touches.len();
            if k == rows {
                return Some(());
            }
            if fault == Fault::SlippedMount && k as f64 >= slips * rows as f64 && truth == self.truth {
                let Element::Shift(position) = robot.links[hands[0]].elements[0] else { return None };
                let by = Rotation3::new(point(TAU, rng)) * Vector3::x() * rng.random_range(8e-3..15e-3);
                truth[position] = truth[position].stepped(by.as_slice());
            }
            let tip = if data == Data::SelfTouch { point(HAND, rng) } else { tips[k % 3] };
            let other = match data {
                Data::SelfTouch => Feature::Point(hands[1], point(HAND, rng)),
                _ => surroundings[rng.random_range(0..surroundings.len())],
            };
            let posture = posture(&robot, RANGE, rng);
            let off = Vector3::from_fn(|_, _| noise * normal(rng));
            let met = if data == Data::Tracker {
                let posed = Posed::new(&robot, &truth, &posture);
                let (frames, tracker) = (posed.frames(), other.link(&robot));
                let seen = frames[tracker].inverse_point(&frames[hands[0]].point(&tip)) + off;
                Some((posture, Feature::Point(tracker, seen)))
            } else {
                meeting(&robot, &truth, posture, [&Feature::Point(hands[0], tip), &other], off)
                    .map(|posture| (posture, other))
            };
            let Some((posture, other)) = met else { continue };
            let ends =
                [Feature::Point(hands[0], tip), other].map(|feature| vec![End { feature, deviation: None }]);
            self.touches.push(Touch { line: k + 2, posture, ends, distance: 0.0, time: None });
        }
        None
    }

    /// What is wrong with the log.
    fn spoil_log(&mut self, fault: Fault, dof: usize, rng: &mut ChaCha8Rng) {
        let honest = self.touches.clone();
        match fault {
            Fault::DeadEncoder => {
                let read = rng.random_range(-0.5..0.5);
                self.touches.iter_mut().for_each(|touch| touch.posture[dof] = read);
            }
            Fault::Outliers => {
                for touch in &mut self.touches {
                    if rng.random_bool(0.1) {
                        touch.posture.clone_from(&honest[rng.random_range(0..honest.len())].posture);
                    }
                }
            }
            Fault::Copies => {
                (0..rng.random_range(2..12)).for_each(|_| self.touches.extend_from_slice(&honest));
                drop_repeats(&mut self.touches);
            }
            _ => {}
        }
    }
}

/// The robot whose touches are logged.
fn as_it_is(robot: &Robot, fault: Fault) -> Robot {
    let other = (fault == Fault::Convention).then(|| robot.of_other_convention()).flatten();
    other.unwrap_or_else(|| robot.clone())
}

fn point(size: f64, rng: &mut impl Rng) -> Vector3<f64> {
    Vector3::from_fn(|_, _| rng.random_range(-size..size))
}

fn posture(robot: &Robot, range: f64, rng: &mut impl Rng) -> Vec<f64> {
    robot.dofs.iter().map(|_| rng.random_range(-range..range)).collect()
}

/// Where a hand is.
fn hand_at(robot: &Robot, values: &[Value], posture: &[f64], hand: usize) -> Vector3<f64> {
    Posed::new(robot, values, posture).frames()[hand].origin
}

/// Adds an arm; the link of its hand's points.
fn add_arm(robot: &mut Robot, side: &str, y: f64, rng: &mut impl Rng) -> usize {
    let turn = Rotation3::new(Vector3::x() * -4.0 * y).into_inner();
    let shoulder = Frame { rotation: turn, origin: Vector3::new(0.0, y, 0.3) };
    let mut link = robot.add_link(format!("{side}_base"), 0, vec![Element::Fixed(shoulder)]);
    let count = rng.random_range(4..=6);
    for k in 1..=count {
        let name = format!("{side}_j{k}");
        let dof = robot.add_dof(&name, DofKind::Hinge, [-PI, PI], Vector3::z());
        // Axes are across one another, but for one or two.
        let across = if rng.random_bool(0.7) || k == 1 { FRAC_PI_2 } else { 0.0 };
        let alpha = if rng.random_bool(0.5) { across } else { -across };
        let length = rng.random_range(LENGTHS[0]..LENGTHS[1]);
        let numbers = [
            ("d", Unit::Metre, rng.random_range(0.0..0.1)),
            ("a", Unit::Metre, length),
            ("alpha", Unit::Radian, alpha),
            ("beta", Unit::Radian, 0.0),
        ];
        let [d, a, alpha, beta] = numbers
            .map(|(what, unit, x)| robot.add_quantity(format!("{name}.{what}"), unit, Value::Number(x)));
        let elements = vec![
            Element::Dof(dof),
            Element::ShiftAlong(2, d),
            Element::ShiftAlong(0, a),
            Element::TurnAbout(0, alpha),
            Element::TurnAbout(1, beta),
        ];
        let called = if k == count { format!("{side}_hand") } else { format!("{side}_l{k}") };
        link = robot.add_link(called, link, elements);
        let centre = Vector3::new(-0.5 * length, 0.0, 0.0);
        robot.masses.push(LinkMass { link, mass: rng.random_range(0.5..2.0), centre });
    }
    // Its mount is the one of this name, once all have one.
    robot.add_mount(&format!("{side}_hand.mount"), link, Frame::identity())
}

/// What stands about a robot.
fn surroundings(
    robot: &mut Robot,
    (body, hand): (&Robot, usize),
    data: Data,
    rng: &mut impl Rng,
) -> Vec<Feature> {
    match data {
        Data::SelfTouch => Vec::new(),
        Data::Tracker => {
            let rotation = Rotation3::new(point(1.0, rng)).into_inner();
            let pose = Frame { rotation, origin: Vector3::new(1.5, 0.5, 0.5) };
            vec![Feature::Point(robot.add_mount("tracker", 0, pose), Vector3::zeros())]
        }
        Data::Place => (1..=5)
            .map(|k| {
                // Where the hand can be.
                let posture = posture(body, 0.5 * RANGE, rng);
                let at = hand_at(body, &body.nominal(), &posture, hand);
                Feature::Point(robot.add_place(&format!("socket{k}"), 0, at), Vector3::zeros())
            })
            .collect(),
        Data::Plate => [
            ("floor", Vector3::zeros(), [0.0, 0.0]),
            ("wall", Vector3::x() * 0.3, [0.0, -FRAC_PI_2]),
            ("side", Vector3::y() * 0.25, [FRAC_PI_2, 0.0]),
        ]
        .map(|(name, origin, [roll, pitch])| {
            let rotation = Rotation3::from_euler_angles(roll, pitch, 0.0).into_inner();
            Feature::Surface(robot.add_surface(name, 0, Frame { rotation, origin }, Form::Plane))
        })
        .to_vec(),
    }
}

/// What encoders read where two features are off each other by no more than noise, near a posture.
fn meeting(
    robot: &Robot,
    values: &[Value],
    mut posture: Vec<f64>,
    features: [&Feature; 2],
    off: Vector3<f64>,
) -> Option<Vec<f64>> {
    for _ in 0..40 {
        let posed = Posed::new(robot, values, &posture);
        let met = posed.residuals(features, 0.0, &|_, _| None);
        let mut value = met.value - off;
        (met.size..3).for_each(|i| value[i] = 0.0);
        if value.norm() < 1e-10 {
            return posture.iter().all(|x| x.abs() < 1.5 * RANGE).then_some(posture);
        }
        let mut square = nalgebra::Matrix3::identity() * 1e-9;
        met.by_dof.iter().for_each(|(_, slope)| square += slope * slope.transpose());
        let pull = square.try_inverse()? * value;
        for (dof, slope) in &met.by_dof {
            let q = robot.dofs[*dof].quantities?;
            let per_read = values[q.sign].number() * values[q.gain].number();
            posture[*dof] -= (slope.dot(&pull) / per_read).clamp(-0.3, 0.3);
        }
    }
    None
}
