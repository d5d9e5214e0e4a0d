//! Raising a held thing, and lowering it until it stands.
//!
//! It is held by one hand to which it is welded by a touch, as where it is put far away.

use nalgebra::Vector3;

use super::actor::{Actor, CAREFUL};
use super::tasks::Trouble;
use crate::creature::Posture;
use crate::kinematics::{Place, REACHED};
use crate::peripersonal::{OutOfReach, PosturePath, ReachTarget};
use crate::senses::Toucher;

/// Steps of a way up or down, metres: so small that the arm keeps its pose by going on from step to step.
const STRIDE: f64 = 0.005;
/// How much lower than where it stood a thing is let down before it is let go, metres.
const SINKS: f64 = 0.003;

impl Actor {
    /// Raises what the limb of a receptor holds by so much, metres, or as much of it as its arm can; how much.
    ///
    /// # Errors
    /// [`Trouble`] where it cannot raise it, or meets something.
    pub(super) fn raise(&mut self, receptor: usize, by: f64) -> Result<f64, Trouble> {
        let way = self.upwards(receptor, by);
        if way.is_empty() {
            return Err(OutOfReach::Barred.into());
        }
        let before = self.feels_at(receptor).0;
        let met =
            self.follow(&PosturePath(way), CAREFUL, |_, contact| matches!(contact.by, Toucher::Own(_)))?;
        if met.is_empty() {
            Ok((self.feels_at(receptor).0 - before).dot(&self.up))
        } else {
            Err(Trouble::Hit(met))
        }
    }

    /// Lowers what the limb of a receptor holds by so much until it is felt to stand; whether it was felt.
    ///
    /// # Errors
    /// Where the engine fails.
    pub(super) fn lower(&mut self, receptor: usize, by: f64) -> Result<bool, Trouble> {
        let way = self.upwards(receptor, -(by + SINKS));
        let met =
            self.follow(&PosturePath(way), CAREFUL, |_, contact| matches!(contact.by, Toucher::Through(_)))?;
        Ok(!met.is_empty())
    }

    /// Postures on a straight way of a receptor's place up, or down, as far as the arm goes.
    pub(super) fn upwards(&mut self, receptor: usize, by: f64) -> Vec<Posture> {
        let Some(hand) = self.arm_of(receptor) else { return Vec::new() };
        let arm = self.hands[hand].arm.clone();
        let place = Place { direction: Vector3::zeros(), ..self.own.place(receptor) };
        let (here, mut posture, up) = (self.feels_at(receptor).0, self.posture(), self.up);
        let steps = (by.abs() / STRIDE).ceil().max(1.0) as u32;
        let reaching = self.reaching(arm);
        let mut way = Vec::new();
        for k in 1..=steps {
            let point = here + up * (by * f64::from(k) / f64::from(steps));
            let reach = reaching.solve(place, &ReachTarget { point, direction: Vector3::zeros() }, &posture);
            if reach.miss > REACHED {
                break;
            }
            posture.clone_from(&reach.posture);
            way.push(reach.posture);
        }
        way
    }
}
