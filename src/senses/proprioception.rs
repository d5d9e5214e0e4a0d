//! Proprioception: the posture as the joint sensors of the model tell it.
//!
//! A `jointpos` or `ballquat` sensor tells its joint's coordinate, no farther than its `cutoff` and, where the file
//! enables that, with its `noise`. A joint without one is felt as it is. The engine computes the readings; only the
//! noise is drawn here, from a stream of its own, so that the same seed feels the same whatever else runs beside it.

use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

use super::disturbance::misread;
use super::{Sense, SensedStep, SensingBody};
use crate::creature::{Body, DofKind, Posture};
use crate::error::Result;
use crate::mujoco::{Data, Sensor, SensorKind};

/// Two readings of a ball joint nearer than this are one, per number of its quaternion: the engine normalises it anew.
const ROUNDING: f64 = 1e-12;

/// What tells the coordinate of one degree of freedom, a ball counting as one.
#[derive(Clone, Debug, PartialEq)]
pub struct JointSensor {
    /// The greatest amount that it tells, radians or metres; `None` if it tells all.
    pub cutoff: Option<f64>,
    /// The standard deviation of its noise, radians or metres; 0 where it has none or the file does not enable it.
    pub noise: f64,
    /// Where its numbers start among those of all sensors.
    address: usize,
}

/// How the posture is felt, in a sentence: by the sensors that [`joint_sensors`] returns.
pub fn posture_in_words(sensors: &[Option<JointSensor>]) -> String {
    let count = |is: fn(&JointSensor) -> bool| sensors.iter().flatten().filter(|sensor| is(sensor)).count();
    let sensed = count(|_| true);
    if sensed == 0 {
        return "posture: no joint has a sensor, so every angle is read exactly".to_string();
    }
    let mut text = format!("posture: read from {sensed} joint sensors");
    for (count, what) in [
        (sensors.len() - sensed, "other angles are read exactly"),
        (count(|sensor| sensor.cutoff.is_some()), "of them have a cutoff"),
        (count(|sensor| sensor.noise > 0.0), "of them are noisy"),
    ] {
        if count > 0 {
            text += &format!("; {count} {what}");
        }
    }
    text
}

/// Per degree of freedom of a body, its sensor; `None` if it has none.
pub fn joint_sensors(body: &Body) -> Vec<Option<JointSensor>> {
    let model = &body.declared;
    let (enabled, noisy) = (model.has_sensors_enabled(), model.has_sensor_noise());
    let sensors: Vec<Sensor> = model.sensors().filter(|_| enabled).collect();
    let of_joint = |&joint: &usize| {
        let tells = |sensor: &&Sensor| {
            matches!(sensor.kind, SensorKind::JointPos | SensorKind::BallQuat) && sensor.id == Some(joint)
        };
        sensors.iter().find(tells).map(|sensor| JointSensor {
            cutoff: (sensor.cutoff > 0.0 && sensor.kind == SensorKind::JointPos).then_some(sensor.cutoff),
            noise: if noisy { sensor.noise } else { 0.0 },
            address: sensor.adr,
        })
    };
    body.segments.iter().flat_map(|segment| &segment.joints).map(of_joint).collect()
}

/// A degree of freedom that has a sensor.
struct Channel {
    /// Its first number in a posture.
    coordinate: usize,
    /// Its first number in the engine's `qpos`.
    qpos: usize,
    kind: DofKind,
    sensor: JointSensor,
}

/// The sense of posture of a body: one per thread.
pub struct Proprioception {
    channels: Vec<Channel>,
    /// The engine's data of this sense alone: coordinates and sensors, no poses.
    data: Data,
    noise: ChaCha8Rng,
    /// Without noise, the posture that it read last, and how that felt: a body that keeps still need not be read again.
    last: Option<[Posture; 2]>,
    /// The latest report to a creature on a stage.
    felt: Posture,
}

impl Sense for Proprioception {
    fn place(&mut self, step: &SensedStep) -> Result<()> {
        self.felt = self.read(step.body, step.posture)?;
        Ok(())
    }
}

impl Proprioception {
    /// The sense of a body, whose noise is drawn from a stream.
    ///
    /// # Errors
    /// Where the engine fails.
    pub fn new(body: &Body, noise: ChaCha8Rng) -> Result<Proprioception> {
        let dofs = joint_sensors(body).into_iter().zip(body.creature.elements());
        let channels = dofs.filter_map(|(sensor, at)| {
            let coordinate = at.coordinate();
            Some(Channel { coordinate, qpos: body.qpos_address(coordinate), kind: at.kind, sensor: sensor? })
        });
        let (channels, data) = (channels.collect(), Data::new(body.model.clone())?);
        Ok(Proprioception { channels, data, noise, last: None, felt: Posture::default() })
    }

    /// The sense of a creature on a stage, which is there once.
    pub(super) fn of(own: &SensingBody) -> Result<Proprioception> {
        Proprioception::new(own.body, ChaCha8Rng::seed_from_u64(0))
    }

    /// The posture as it was felt last on a stage.
    pub fn felt(&self) -> &Posture {
        &self.felt
    }

    /// Draws its noise from another stream from now on.
    pub fn draw_noise_from(&mut self, noise: ChaCha8Rng) {
        self.noise = noise;
    }

    /// The posture as it is felt where the body really is in `posture`.
    ///
    /// # Errors
    /// Where the engine fails.
    pub fn read(&mut self, body: &Body, posture: &[f64]) -> Result<Posture> {
        if let Some([_, felt]) = self.last.as_ref().filter(|[last, _]| **last == *posture) {
            return Ok(felt.clone());
        }
        let felt = self.read_anew(body, posture)?;
        if self.channels.iter().all(|channel| channel.sensor.noise == 0.0) {
            self.last = Some([Posture::from(posture), felt.clone()]);
        }
        Ok(felt)
    }

    fn read_anew(&mut self, body: &Body, posture: &[f64]) -> Result<Posture> {
        let mut felt = Posture::from(posture);
        let exact = body.qpos(posture);
        let mut qpos = exact.clone();
        for channel in self.channels.iter().filter(|channel| channel.sensor.noise > 0.0) {
            misread(&mut qpos[channel.qpos..], channel.kind, channel.sensor.noise, &mut self.noise);
        }
        self.data.set_qpos(&qpos)?;
        self.data.sense_positions()?;
        let readings = self.data.sensordata();
        let mut told = exact.clone();
        for Channel { qpos, kind, sensor, .. } in &self.channels {
            let count = kind.coordinates();
            told[*qpos..qpos + count].copy_from_slice(&readings[sensor.address..sensor.address + count]);
        }
        if told == exact {
            return Ok(felt);
        }
        let as_told = body.read_posture(&told);
        for Channel { coordinate, qpos, kind, .. } in &self.channels {
            let numbers = *qpos..qpos + kind.coordinates();
            let off = numbers.map(|k| (told[k] - exact[k]).abs()).fold(0.0, f64::max);
            // What the engine tells exactly stays as it is to the last bit.
            match kind {
                DofKind::Ball if off > ROUNDING => {
                    felt[*coordinate..coordinate + 4].copy_from_slice(&as_told[*coordinate..coordinate + 4]);
                }
                DofKind::Ball => {}
                DofKind::Hinge | DofKind::Slide => felt[*coordinate] += told[*qpos] - exact[*qpos],
            }
        }
        Ok(felt)
    }
}
