//! Learning where the tip of a stick is that he holds, by touching himself with it.
//!
//! Nobody tells him how long it is nor where it leads. He moves both arms at random, so that what he expects of the stick
//! meets other skin, until the stick touches him: the hand feels it pressed and other skin feels it. From there he comes
//! once more, slowly, and takes down both receptors and the posture. The stick that closes the gaps of these touches over his
//! learned schema is what he believes; he counts as known only what has predicted held-out touches, the tip's among them.

use nalgebra::{Matrix3, Vector3};
use rand::RngExt;
use rand_chacha::ChaCha8Rng;

use super::{MARGIN, Trouble};
use crate::creature::Posture;
use crate::geometry::{Capsule, Frame};
use crate::interaction::actor::Actor;
use crate::interaction::stick::KnownStick;
use crate::learning::observation::Observation;
use crate::learning::touch_set::{LimbTouch, PreparedTouch};
use crate::learning::{Tool, Z95};
use crate::peripersonal::straight;

/// How often he moves at the most.
const MOTIONS: usize = 200;
/// Touches after which he gives up.
const MOST: usize = 40;
/// How often he draws where to go until the stick, as far as he knows it, should touch him there.
const DRAWS: usize = 60;
/// … and until its tip should, before its shaft does.
const DRAWS_BY_TIP: usize = 600;
/// Postures of a way that are looked at, …
const LOOKS: u32 = 40;
/// … and the share of a stick that is its shaft.
const SHAFT: f64 = 0.9;
/// How far a stick is taken to reach before it has touched anything, metres.
const FIRST_LENGTH: f64 = 0.3;
/// How far over a table the hands, and where the stick may lead, keep while it is not known, metres.
const ABOVE: f64 = 0.12;
/// How clear of his own body he keeps the arms, metres.
const CLEAR: f64 = 0.01;
/// Every so many touches the stick may turn out to be another than was believed.
const ANEW: usize = 3;
/// Touches from which the stick is looked for first …
const FIRST: usize = 8;
/// … and those that it must be known from at the least, …
const LEAST: usize = 20;
/// … so many of them with the tip.
const BY_TIP: usize = 6;
/// The last touches, each predicted before it was learned from, …
const FRESH: usize = 8;
/// … of which so many must be the tip's, …
const FRESH_BY_TIP: usize = 3;
/// … and all but so many, for skin may be touched where two limbs meet, …
const FALSE: usize = 1;
/// … as near as this to what was expected, metres.
const FORETOLD: f64 = 2e-3;
/// The standard deviation to which the tip must be known, metres.
const CERTAIN: f64 = 1e-3;
/// Touches that a stick explains are as near as this to it, metres.
const CLOSE: f64 = 1e-3;

/// How much room a hand that is held out has before it, metres, at the best.
const ROOM: f64 = 0.5;

impl Actor {
    /// Holds a hand out for a stick: where it points, there is most room.
    ///
    /// # Errors
    /// [`Trouble`] on the way.
    pub fn hold_out(&mut self, hand: usize) -> Result<(), Trouble> {
        let arm = self.hands[hand].arm.clone();
        let grip = self.own.place(self.grip_of(hand));
        let pointing = grip.point.try_normalize(1e-6).unwrap_or(grip.direction);
        let holding = self.own.carried_by(arm[0] + 1);
        let best = self.best_drawn(&arm, |actor, frames| {
            let ends = [grip.point, grip.point + pointing * ROOM].map(|p| frames[grip.limb].point(&p));
            let before = Capsule { ends, radius: 0.0 };
            let over = actor
                .table
                .map_or(ROOM, |height| ends.iter().map(|p| p.dot(&actor.up) - height).fold(ROOM, f64::min));
            let others = (0..holding.len()).filter(|&limb| !holding[limb]);
            let to_other = |limb| actor.clearance.to_capsule(frames, limb, &before, ROOM);
            others.map(to_other).fold(over, f64::min)
        });
        best.map_or(Ok(()), |posture| self.go(&posture))
    }

    /// Touches himself with the stick that he holds until he knows where its tip is; what he knows then. `None` if he could
    /// not tell: then he does not use it.
    ///
    /// # Errors
    /// Where the engine fails.
    pub fn learn_stick(&mut self) -> Result<Option<KnownStick>, Trouble> {
        let mut rng = self.new_rng();
        let mut belief = None;
        // How far off each touch was from what was expected, and whether by the tip.
        let mut foretold: Vec<(f64, bool)> = Vec::new();
        for _ in 0..MOTIONS {
            let target = self.where_it_may_touch(belief.as_ref(), &mut rng);
            // Elsewhere, whatever the stick meets.
            let target = target.or_else(|| self.draw_clear(DRAWS, &mut rng, |_, _| true));
            let Some(target) = target else { continue };
            let touch = self.touch_exactly(&target, Actor::is_of_stick, Actor::touches_by_stick)?;
            let told = touch.and_then(|(receptor, posture)| self.prepared(receptor, &posture));
            let Some(touch) = told else { continue };
            let (skin, schema) = (self.own.skin(), &self.own.schema);
            foretold.push(belief.as_ref().map_or((f64::INFINITY, false), |tool: &Tool| {
                let gap = tool.gap(skin, schema, &touch).map_or(f64::INFINITY, f64::abs);
                (gap, tool.touches_with_tip(skin, schema, &touch))
            }));
            let Some(stick) = self.stick.as_mut() else { return Ok(None) };
            stick.touches.push(touch);
            belief = self.believed(belief);
            if foretold.len() >= MOST {
                break;
            }
            if let Some(known) = belief.and_then(|tool| self.known_for_certain(tool, &foretold)) {
                self.know_stick(known);
                return Ok(Some(known));
            }
        }
        Ok(None)
    }

    /// The stick that explains the touches so far: that believed before, moved, or another.
    fn believed(&self, before: Option<Tool>) -> Option<Tool> {
        let stick = self.stick.as_ref()?;
        let touches: Vec<&PreparedTouch> = stick.touches.iter().collect();
        if touches.len() < FIRST {
            return None;
        }
        let (skin, schema) = (self.own.skin(), &self.own.schema);
        match before {
            Some(tool) if touches.len().is_multiple_of(ANEW) => {
                Some(tool.refitted(skin, schema, &touches, CLOSE))
            }
            Some(tool) => Some(tool.settled(skin, schema, &touches)),
            None => {
                Tool::fit(self.hands[stick.hand].limb, skin, schema, &touches, CLOSE).map(|(tool, _)| tool)
            }
        }
    }

    /// What is known of the stick where it is known well enough to be used.
    fn known_for_certain(&self, tool: Tool, foretold: &[(f64, bool)]) -> Option<KnownStick> {
        let stick = self.stick.as_ref()?;
        let touches: Vec<&PreparedTouch> = stick.touches.iter().collect();
        let fresh = &foretold[foretold.len().checked_sub(FRESH)?..];
        let foretold = fresh.iter().filter(|(gap, _)| *gap <= FORETOLD).count();
        let (skin, schema) = (self.own.skin(), &self.own.schema);
        let by_tip = touches.iter().filter(|touch| tool.touches_with_tip(skin, schema, touch)).count();
        let enough = touches.len() >= LEAST
            && by_tip >= BY_TIP
            && fresh.iter().filter(|(gap, tip)| *tip && *gap <= FORETOLD).count() >= FRESH_BY_TIP
            && foretold + FALSE >= FRESH;
        if !enough {
            return None;
        }
        let deviation = self.own.tip_deviation(&tool, &touches);
        let within = Z95 * deviation;
        (deviation <= CERTAIN).then_some(KnownStick { tool, within, touches: touches.len(), by_tip })
    }

    /// A random posture of both arms to which the way is clear of his own body and in which the stick, as it is believed or
    /// expected, would be in other skin: its tip, once something is believed.
    fn where_it_may_touch(&self, belief: Option<&Tool>, rng: &mut ChaCha8Rng) -> Option<Posture> {
        let stick = self.stick.as_ref()?;
        let hand = &self.hands[stick.hand];
        let limb = hand.limb;
        let grip = self.own.skin().receptors[stick.receptor].position;
        let pointing = grip.try_normalize(1e-6).unwrap_or_else(Vector3::x);
        let expected = belief.copied().unwrap_or(Tool {
            limb,
            grip,
            tip: grip + pointing * FIRST_LENGTH,
            radius: CLEAR,
        });
        // Now and then what is not expected is tried.
        let tip_only = belief.is_some() && rng.random_bool(0.7);
        let from = self.posture();
        let holding = self.own.carried_by(hand.arm[0] + 1);
        let others: Vec<usize> = (0..self.own.creature().limbs().len())
            .filter(|&other| !holding[other] && !self.own.creature().neighbouring(limb, other))
            .collect();
        let draws = if tip_only { DRAWS_BY_TIP } else { DRAWS };
        self.draw_clear(draws, rng, |target, frames| {
            let Capsule { ends, radius } = expected.capsule().placed(&frames[limb]);
            let about = Capsule { ends: if tip_only { [ends[1]; 2] } else { ends }, radius };
            let meets = |&other: &usize| self.clearance.to_capsule(frames, other, &about, CLEAR) < 0.0;
            let tip_first = || !tip_only || self.meets_with_tip_first(&expected, &others, [&from, target]);
            self.is_high(ends.into_iter()) && others.iter().any(meets) && tip_first()
        })
    }

    /// A random posture of both arms with the hands over the table to which the way is clear of his own body, and that is `useful`.
    fn draw_clear(
        &self,
        draws: usize,
        rng: &mut ChaCha8Rng,
        useful: impl Fn(&Posture, &[Frame]) -> bool,
    ) -> Option<Posture> {
        let (arms, from) = (self.arms(), self.posture());
        let clearance = self.clearance.moved_by(&self.own, &arms).eased_at(&[self.own.frames(&from)], CLEAR);
        (0..draws).find_map(|_| {
            let target = self.own.random_posture(&from, &arms, rng);
            let frames = self.own.frames(&target);
            let high = self.is_high(self.hands.iter().map(|hand| frames[hand.limb].origin));
            let clear = |to| straight(&self.own, &clearance, &from, to, MARGIN);
            (high && useful(&target, &frames) && clear(&target)).then_some(target)
        })
    }

    /// Whether points of the root's frame are not over a table, or well over it.
    pub(super) fn is_high(&self, mut points: impl Iterator<Item = Vector3<f64>>) -> bool {
        self.table.is_none_or(|height| {
            let edge = self.trunk_front(height);
            points.all(|p| p.dot(&self.front) < edge || p.dot(&self.up) > height + ABOVE)
        })
    }

    /// Whether on a straight way a stick meets one of some limbs with its tip before it does with its shaft.
    fn meets_with_tip_first(&self, tool: &Tool, limbs: &[usize], [from, to]: [&Posture; 2]) -> bool {
        for k in 1..=LOOKS {
            let share = f64::from(k) / f64::from(LOOKS);
            let posture = Posture::between(self.own.creature(), from, to, share);
            let frames = self.own.frames(&posture);
            let stick = tool.capsule().placed(&frames[tool.limb]);
            let [grip, end] = stick.ends;
            let gap = |body: &Capsule| {
                let to = |&limb: &usize| self.clearance.to_capsule(&frames, limb, body, CLEAR);
                limbs.iter().map(to).fold(f64::INFINITY, f64::min)
            };
            if gap(&Capsule { ends: [grip, grip.lerp(&end, SHAFT)], ..stick }) < CLEAR {
                return false;
            }
            if gap(&Capsule { ends: [end; 2], ..stick }) < 0.0 {
                return true;
            }
        }
        false
    }

    /// The touch of a receptor by the stick, in a posture, for who learns from it.
    fn prepared(&self, receptor: usize, posture: &Posture) -> Option<PreparedTouch> {
        let ends = [self.stick.as_ref()?.receptor, receptor];
        let found = ends.map(|receptor| &self.own.skin().receptors[receptor]);
        let touch = LimbTouch {
            limbs: found.map(|found| found.limb),
            posture,
            // Where on a patch it was is not told; the fit goes by surfaces.
            ends: [0, 1].map(|k| Observation {
                receptor: ends[k],
                position: found[k].position,
                covariance: Matrix3::zeros(),
            }),
        };
        // Where the limb that was touched is not known, it tells nothing of the stick.
        let limbs = [touch.limbs[1], touch.limbs[0]];
        self.own.covariance(posture, limbs, &found[1].position)?;
        Some(touch.prepare(self.own.creature()).1)
    }
}
